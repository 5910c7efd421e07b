//! RGB color spaces: their primaries, the luminance and the matrices that follow from them, the
//! conversion between them, color differences, and transfer functions.
//!
//! XYZ is CIE 1931 throughout, RGB is linear, and matrices multiply columns: `to_xyz() * rgb`.

use glam::{DMat3, DVec3};

pub(crate) mod adaptation;
pub(crate) mod difference;
mod space;
pub(crate) mod transfer;

pub use space::ColorSpace;

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

impl Primaries {
    /// The weights of R, G and B in the luminance Y; they sum to 1.
    ///
    /// They are the middle row of the matrix from RGB to XYZ (SMPTE RP 177): the columns are the
    /// primaries' XYZ, scaled so that R = G = B = 1 is the white at Y = 1.
    pub fn luminance_weights(&self) -> [f64; 3] {
        if self.has_dark_primary() {
            let matrix = self.by_sums();
            return [0, 1, 2].map(|column| matrix.col(column).y);
        }
        let columns = self.columns();
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

    /// Linear RGB to XYZ, with R = G = B = 1 at the white's XYZ, Y = 1 (SMPTE RP 177).
    ///
    /// The middle row is [`Self::luminance_weights`], to the bit. Primaries that lie on one line,
    /// or a white with a y of zero, give components that are not finite.
    pub fn to_xyz(&self) -> DMat3 {
        if self.has_dark_primary() {
            return self.by_sums();
        }
        let columns = DMat3::from_cols_array_2d(&self.columns());
        columns * DMat3::from_diagonal(DVec3::from_array(self.luminance_weights()))
    }

    /// XYZ to linear RGB: the inverse of [`Self::to_xyz`].
    ///
    /// Colors outside the gamut have negative components.
    pub fn from_xyz(&self) -> DMat3 {
        self.to_xyz().inverse()
    }

    /// The XYZ of the white, at Y = 1.
    pub fn white_xyz(&self) -> DVec3 {
        DVec3::from_array(xyz(self.white))
    }

    /// Whether light of a chromaticity (x, y), y > 0, can be adapted to as a white ([CAT16](crate::display::Settings::white)).
    pub fn can_be_white(chromaticity: [f64; 2]) -> bool {
        adaptation::excites_all_cones(DVec3::from_array(xyz(chromaticity)))
    }

    /// Whether these are the primaries of XYZ itself, as far as files are exact.
    pub fn is_xyz(&self) -> bool {
        let list = |p: &Self| [p.red, p.green, p.blue].into_iter().flatten();
        list(self)
            .zip(list(&Self::XYZ))
            .all(|(found, expected)| (found - expected).abs() <= 1e-3)
    }

    /// Whether a primary has no luminance, so that it cannot be scaled to Y = 1.
    fn has_dark_primary(&self) -> bool {
        [self.red, self.green, self.blue]
            .iter()
            .any(|&[_, y]| y == 0.0)
    }

    /// [`Self::to_xyz`] from primaries at X + Y + Z = 1.
    fn by_sums(&self) -> DMat3 {
        let column = |[x, y]: [f64; 2]| DVec3::new(x, y, 1.0 - x - y);
        let columns = [self.red, self.green, self.blue].map(column);
        let columns = DMat3::from_cols(columns[0], columns[1], columns[2]);
        columns * DMat3::from_diagonal(columns.inverse() * self.white_xyz())
    }

    /// The XYZ of red, green and blue, each at Y = 1.
    fn columns(&self) -> [[f64; 3]; 3] {
        [self.red, self.green, self.blue].map(xyz)
    }
}

/// The XYZ of a chromaticity at Y = 1.
fn xyz([x, y]: [f64; 2]) -> [f64; 3] {
    [x / y, 1.0, (1.0 - x - y) / y]
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

    /// A few operations in f64 on values near 1.
    const ROUNDING: f64 = 1e-14;

    pub(super) const SPACES: [Primaries; 6] = [
        Primaries::REC709,
        Primaries::ADOBE_RGB,
        Primaries::P3_D65,
        Primaries::REC2020,
        Primaries::AP1,
        Primaries::AP0,
    ];

    /// `expected` is row by row, as matrices are printed.
    pub(super) fn assert_matrix(found: DMat3, expected: [[f64; 3]; 3], tolerance: f64) {
        let expected = DMat3::from_cols_array_2d(&expected).transpose();
        assert!(
            found.abs_diff_eq(expected, tolerance),
            "{found} is not {expected}"
        );
    }

    #[test]
    fn rec709_matrices_are_the_published_ones() {
        assert_matrix(
            Primaries::REC709.to_xyz(),
            [
                [0.4123907993, 0.3575843394, 0.1804807884],
                [0.2126390059, 0.7151686788, 0.0721923154],
                [0.0193308187, 0.1191947798, 0.9505321522],
            ],
            PUBLISHED,
        );
        assert_matrix(
            Primaries::REC709.from_xyz(),
            [
                [3.2409699419, -1.5373831776, -0.4986107603],
                [-0.9692436363, 1.8759675015, 0.0415550574],
                [0.0556300797, -0.2039769589, 1.0569715142],
            ],
            PUBLISHED,
        );
    }

    /// Against colour-science 0.4.7, `normalised_primary_matrix`, at twelve decimals.
    #[test]
    fn matrices_are_those_of_colour_science() {
        let tolerance = 0.5e-12 + ROUNDING;
        assert_matrix(
            Primaries::P3_D65.to_xyz(),
            [
                [0.486570948648, 0.265667693169, 0.198217285234],
                [0.228974564070, 0.691738521837, 0.079286914094],
                [0.0, 0.045113381859, 1.043944368901],
            ],
            tolerance,
        );
        assert_matrix(
            Primaries::REC2020.to_xyz(),
            [
                [0.636958048301, 0.144616903586, 0.168880975164],
                [0.262700212011, 0.677998071519, 0.059301716470],
                [0.0, 0.028072693049, 1.060985057711],
            ],
            tolerance,
        );
        assert_matrix(
            Primaries::REC2020.from_xyz(),
            [
                [1.716651187971, -0.355670783776, -0.253366281374],
                [-0.666684351832, 1.616481236635, 0.015768545814],
                [0.017639857445, -0.042770613258, 0.942103121235],
            ],
            tolerance,
        );
        assert_matrix(
            Primaries::AP1.to_xyz(),
            [
                [0.662454181109, 0.134004206456, 0.156187687005],
                [0.272228716781, 0.674081765811, 0.053689517408],
                [-0.005574649490, 0.004060733529, 1.010339100313],
            ],
            tolerance,
        );
        assert_matrix(
            Primaries::AP0.to_xyz(),
            [
                [0.952552395938, 0.0, 0.000093678632],
                [0.343966449765, 0.728166096613, -0.072132546379],
                [0.0, 0.0, 1.008825184352],
            ],
            tolerance,
        );
    }

    #[test]
    fn to_xyz_and_back() {
        for space in SPACES {
            let both = space.from_xyz() * space.to_xyz();
            assert!(both.abs_diff_eq(DMat3::IDENTITY, ROUNDING), "{both}");
        }
    }

    #[test]
    fn the_middle_row_is_the_luminance_to_the_bit() {
        for space in SPACES {
            assert_eq!(space.to_xyz().row(1).to_array(), space.luminance_weights());
        }
    }

    /// What figures shown so far were computed with.
    #[test]
    fn luminance_weights_keep_their_bits() {
        let bits = |space: Primaries| space.luminance_weights().map(f64::to_bits);
        assert_eq!(
            bits(Primaries::REC709),
            [
                0x3fcb_37c1_4409_3a33,
                0x3fe6_e2a9_6ccd_cb18,
                0x3fb2_7b32_117f_32da
            ]
        );
        assert_eq!(
            bits(Primaries::P3_D65),
            [
                0x3fcd_4f09_dc25_d090,
                0x3fe6_22b8_d315_7a46,
                0x3fb4_4c25_af08_8ca7
            ]
        );
        assert_eq!(
            bits(Primaries::REC2020),
            [
                0x3fd0_d014_8ccf_66f1,
                0x3fe5_b229_02fd_967d,
                0x3fae_5ccb_69ab_60a3
            ]
        );
        assert_eq!(
            bits(Primaries::AP1),
            [
                0x3fd1_6c31_fee6_c9ec,
                0x3fe5_9213_ec5f_a45d,
                0x3fab_7d31_42cf_6ae3
            ]
        );
    }

    #[test]
    fn rgb_one_is_the_white() {
        for space in SPACES {
            let white = space.to_xyz() * DVec3::ONE;
            assert!(white.abs_diff_eq(space.white_xyz(), ROUNDING), "{white}");
        }
        let d65 = DVec3::new(0.950_455_927_051_671_7, 1.0, 1.089_057_750_759_878_4);
        assert!(Primaries::REC709.white_xyz().abs_diff_eq(d65, ROUNDING));
    }

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

    #[test]
    fn xyz_is_itself() {
        let matrix = Primaries::XYZ.to_xyz();
        assert!(matrix.abs_diff_eq(DMat3::IDENTITY, ROUNDING), "{matrix}");
        assert_eq!(Primaries::XYZ.luminance_weights(), [0.0, 1.0, 0.0]);
        assert!(Primaries::XYZ.is_xyz());
        assert!(SPACES.iter().all(|space| !space.is_xyz()));
    }

    /// A primary without luminance does as one with hardly any.
    #[test]
    fn a_primary_may_have_no_luminance() {
        let with_blue = |y: f64| Primaries {
            blue: [0.1, y],
            ..Primaries::REC709
        };
        let (dark, almost) = (with_blue(0.0), with_blue(1e-9));
        assert!(dark.to_xyz().abs_diff_eq(almost.to_xyz(), 1e-7));
        assert_eq!(dark.luminance_weights()[2], 0.0);
        let white = dark.to_xyz() * DVec3::ONE;
        assert!(white.abs_diff_eq(dark.white_xyz(), ROUNDING), "{white}");
    }

    /// palette's white is D65 to five digits of XYZ, ours that of xy to four, as the standards have it.
    #[test]
    fn palette_agrees_as_far_as_its_white() {
        use palette::Xyz;
        use palette::convert::FromColorUnclamped;
        use palette::encoding::{DisplayP3, Linear, Rec2020, Srgb};
        use palette::rgb::Rgb;
        use palette::white_point::D65;
        const OF_WHITE: f64 = 4.6e-4;
        for column in 0..3 {
            let [r, g, b] = [0, 1, 2].map(|place| f64::from(u8::from(place == column)));
            let theirs: [(Primaries, Xyz<D65, f64>); 3] = [
                (
                    Primaries::REC709,
                    Xyz::from_color_unclamped(Rgb::<Linear<Srgb>, f64>::new(r, g, b)),
                ),
                (
                    Primaries::P3_D65,
                    Xyz::from_color_unclamped(Rgb::<Linear<DisplayP3>, f64>::new(r, g, b)),
                ),
                (
                    Primaries::REC2020,
                    Xyz::from_color_unclamped(Rgb::<Linear<Rec2020>, f64>::new(r, g, b)),
                ),
            ];
            for (space, Xyz { x, y, z, .. }) in theirs {
                let ours = space.to_xyz().col(column);
                let theirs = DVec3::new(x, y, z);
                assert!(ours.abs_diff_eq(theirs, OF_WHITE), "{ours} {theirs}");
            }
        }
    }
}
