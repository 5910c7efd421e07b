//! RGB color spaces: their primaries, the luminance that follows from them, and transfer functions.

pub mod transfer;

/// The CIE 1931 (x, y) chromaticities of an RGB space's primaries and white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primaries {
    /// The red primary.
    pub red: [f64; 2],
    /// The green primary.
    pub green: [f64; 2],
    /// The blue primary.
    pub blue: [f64; 2],
    /// The white point: R = G = B.
    pub white: [f64; 2],
}

/// D65 as the RGB standards round it (ITU-R BT.709-6, table 1).
const D65: [f64; 2] = [0.3127, 0.3290];

impl Primaries {
    /// ITU-R BT.709-6, which sRGB shares.
    pub const REC709: Self = Self {
        red: [0.640, 0.330],
        green: [0.300, 0.600],
        blue: [0.150, 0.060],
        white: D65,
    };

    /// P3 with a D65 white (SMPTE EG 432-1).
    pub const P3_D65: Self = Self {
        red: [0.680, 0.320],
        green: [0.265, 0.690],
        blue: [0.150, 0.060],
        white: D65,
    };

    /// ITU-R BT.2020-2.
    pub const REC2020: Self = Self {
        red: [0.708, 0.292],
        green: [0.170, 0.797],
        blue: [0.131, 0.046],
        white: D65,
    };

    /// AP1, the primaries of ACEScg (S-2014-004).
    pub const AP1: Self = Self {
        red: [0.713, 0.293],
        green: [0.165, 0.830],
        blue: [0.128, 0.044],
        white: [0.32168, 0.33767],
    };

    /// The weights of R, G and B in the luminance Y; they sum to 1.
    ///
    /// They are the middle row of the matrix from RGB to XYZ (SMPTE RP 177): the columns are the
    /// primaries' XYZ, scaled so that R = G = B = 1 is the white at Y = 1.
    pub fn luminance_weights(&self) -> [f64; 3] {
        let xyz = |[x, y]: [f64; 2]| [x / y, 1.0, (1.0 - x - y) / y];
        let columns = [xyz(self.red), xyz(self.green), xyz(self.blue)];
        let white = xyz(self.white);
        // Cramer's rule for columns · weights = white; Y is 1 in every column, so that the
        // weights are the luminances.
        let volume = determinant(columns);
        std::array::from_fn(|i| {
            let mut replaced = columns;
            replaced[i] = white;
            determinant(replaced) / volume
        })
    }
}

fn determinant([a, b, c]: [[f64; 3]; 3]) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1])
        + c[0] * (a[1] * b[2] - a[2] * b[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The published matrices have ten decimals.
    const PUBLISHED: f64 = 1e-10;

    #[test]
    fn luminance_weights_are_the_published_ones() {
        // IEC 61966-2-1 rounds Rec.709's to .2126, .7152, .0722; ten decimals from colour-science.
        let published = [0.2126390059, 0.7151686788, 0.0721923154];
        for (weight, published) in Primaries::REC709.luminance_weights().iter().zip(published) {
            assert!((weight - published).abs() < PUBLISHED, "{weight}");
        }
        // BT.2020-2, table 4, and S-2014-004, TRA1: as far as they are printed.
        let rounded = |weights: [f64; 3]| weights.map(|weight| (weight * 1e4).round());
        assert_eq!(
            rounded(Primaries::REC2020.luminance_weights()),
            [2627.0, 6780.0, 593.0]
        );
        assert_eq!(
            rounded(Primaries::AP1.luminance_weights()),
            [2722.0, 6741.0, 537.0]
        );
    }

    #[test]
    fn white_has_luminance_one() {
        for primaries in [
            Primaries::REC709,
            Primaries::P3_D65,
            Primaries::REC2020,
            Primaries::AP1,
        ] {
            let sum: f64 = primaries.luminance_weights().iter().sum();
            assert!((sum - 1.0).abs() < 1e-14, "{sum}");
        }
    }
}
