//! Chromatic adaptation: what a color under one white corresponds to under another.

use glam::{DMat3, DVec3};

use super::Primaries;

/// XYZ to the sharpened cone responses of the Bradford transform (Lam 1985, as linearized in
/// ICC.1:2022, annex E).
const BRADFORD: DMat3 = DMat3::from_rows(
    DVec3::new(0.8951, 0.2664, -0.1614),
    DVec3::new(-0.7502, 1.7135, 0.0367),
    DVec3::new(0.0389, -0.0685, 1.0296),
);

/// XYZ to the cone responses of CIECAM16 (CIE 248:2022, section 3; Li et al. 2017).
const CAT16: DMat3 = DMat3::from_rows(
    DVec3::new(0.401_288, 0.650_173, -0.051_461),
    DVec3::new(-0.250_268, 1.204_414, 0.045_854),
    DVec3::new(-0.002_079, 0.048_952, 0.953_127),
);

/// The linear Bradford adaptation from XYZ under the white `from` to XYZ under the white `to`.
///
/// M⁻¹ · diag(M·to / M·from) · M, a von Kries scaling of the cone responses (ICC.1:2022, annex E).
/// It takes `from` to `to`; equal whites give exactly the identity.
///
/// Both whites are XYZ with positive cone responses, which every real white has, and commonly have
/// Y = 1: a difference in Y is adapted away like one in color.
pub fn bradford(from: DVec3, to: DVec3) -> DMat3 {
    von_kries(&BRADFORD, from, to)
}

/// The complete adaptation by CAT16 from XYZ under the white `from` to XYZ under the white `to`; as [`bradford`],
/// of which this is the newer sibling, with the cone responses of CIECAM16.
pub(crate) fn cat16(from: DVec3, to: DVec3) -> DMat3 {
    von_kries(&CAT16, from, to)
}

/// Whether CAT16 can take light of this XYZ for white: all of its cone responses are above 0.
pub(super) fn excites_all_cones(xyz: DVec3) -> bool {
    (CAT16 * xyz).min_element() > 0.0
}

fn von_kries(cones: &DMat3, from: DVec3, to: DVec3) -> DMat3 {
    if from == to {
        return DMat3::IDENTITY;
    }
    let gain = (*cones * to) / (*cones * from);
    cones.inverse() * DMat3::from_diagonal(gain) * *cones
}

/// Linear RGB of one space to linear RGB of another.
///
/// Where the whites differ, colors are adapted with [`bradford`], so that R = G = B stays so. XYZ itself
/// is not adapted: its white is that of equal numbers, no light's.
/// Colors outside the gamut of `to` get negative components. The same space gives exactly the
/// identity.
pub(crate) fn conversion(from: &Primaries, to: &Primaries) -> DMat3 {
    if from == to {
        return DMat3::IDENTITY;
    }
    if from.is_xyz() || to.is_xyz() {
        return to.from_xyz() * from.to_xyz();
    }
    to.from_xyz() * bradford(from.white_xyz(), to.white_xyz()) * from.to_xyz()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::tests::{SPACES, assert_matrix};

    /// A few operations in f64 on values near 1.
    const ROUNDING: f64 = 1e-14;

    /// Matrices printed with six decimals.
    const SIX_DECIMALS: f64 = 0.5e-6 + ROUNDING;

    /// Matrices printed with twelve decimals.
    const TWELVE_DECIMALS: f64 = 0.5e-12 + ROUNDING;

    #[test]
    fn rec709_to_aces_is_the_published_one() {
        assert_matrix(
            conversion(&Primaries::REC709, &Primaries::AP1),
            [
                [0.613097, 0.339523, 0.047379],
                [0.070194, 0.916354, 0.013452],
                [0.020616, 0.109570, 0.869815],
            ],
            SIX_DECIMALS,
        );
        assert_matrix(
            conversion(&Primaries::REC709, &Primaries::AP0),
            [
                [0.439633, 0.382989, 0.177378],
                [0.089776, 0.813439, 0.096784],
                [0.017541, 0.111547, 0.870912],
            ],
            SIX_DECIMALS,
        );
    }

    /// Against colour-science 0.4.7.
    #[test]
    fn conversions_are_those_of_colour_science() {
        assert_matrix(
            conversion(&Primaries::AP1, &Primaries::REC709),
            [
                [1.705050992658, -0.621792120657, -0.083258872001],
                [-0.130256417507, 1.140804736575, -0.010548319068],
                [-0.024003356805, -0.128968976065, 1.152972332870],
            ],
            TWELVE_DECIMALS,
        );
        assert_matrix(
            conversion(&Primaries::REC709, &Primaries::REC2020),
            [
                [0.627403895935, 0.329283038378, 0.043313065687],
                [0.069097289358, 0.919540395075, 0.011362315566],
                [0.016391438875, 0.088013307877, 0.895595253248],
            ],
            TWELVE_DECIMALS,
        );
        // Rec.709 and P3 share their blue and the line from it to the white.
        assert_matrix(
            conversion(&Primaries::REC709, &Primaries::P3_D65),
            [
                [0.822461968714, 0.177538031286, 0.0],
                [0.033194198851, 0.966805801149, 0.0],
                [0.017082630721, 0.072397440664, 0.910519928615],
            ],
            TWELVE_DECIMALS,
        );
        assert_matrix(
            bradford(Primaries::REC709.white_xyz(), Primaries::AP1.white_xyz()),
            [
                [1.013034914650, 0.006105257823, -0.014970943627],
                [0.007698230125, 0.998163352118, -0.005032038535],
                [-0.002841317432, 0.004685156723, 0.924506137458],
            ],
            TWELVE_DECIMALS,
        );
    }

    #[test]
    fn white_becomes_white() {
        for from in SPACES {
            for to in SPACES {
                let adapted = bradford(from.white_xyz(), to.white_xyz()) * from.white_xyz();
                assert!(adapted.abs_diff_eq(to.white_xyz(), ROUNDING), "{adapted}");
                let converted = conversion(&from, &to) * DVec3::ONE;
                assert!(converted.abs_diff_eq(DVec3::ONE, ROUNDING), "{converted}");
            }
        }
    }

    #[test]
    fn there_and_back() {
        for from in SPACES {
            for to in SPACES {
                let both = conversion(&to, &from) * conversion(&from, &to);
                assert!(both.abs_diff_eq(DMat3::IDENTITY, ROUNDING), "{both}");
            }
        }
    }

    #[test]
    fn the_same_space_is_exactly_the_identity() {
        for space in SPACES {
            assert_eq!(conversion(&space, &space), DMat3::IDENTITY);
            assert_eq!(
                bradford(space.white_xyz(), space.white_xyz()),
                DMat3::IDENTITY
            );
        }
    }

    #[test]
    fn xyz_is_not_adapted() {
        let matrix = conversion(&Primaries::XYZ, &Primaries::REC709);
        assert!(matrix.abs_diff_eq(Primaries::REC709.from_xyz(), ROUNDING));
        let back = conversion(&Primaries::REC709, &Primaries::XYZ);
        assert!(back.abs_diff_eq(Primaries::REC709.to_xyz(), ROUNDING));
    }

    /// palette inverts Bradford's matrix as it is printed, to seven digits.
    #[test]
    fn palette_agrees_to_its_digits() {
        use palette::Xyz;
        use palette::chromatic_adaptation::AdaptFromUnclamped;
        use palette::white_point::{Any, D50, D65, WhitePoint};
        let vector = |white: Xyz<Any, f64>| DVec3::new(white.x, white.y, white.z);
        let ours = bradford(vector(D65::get_xyz()), vector(D50::get_xyz()));
        for column in 0..3 {
            let [x, y, z] = [0, 1, 2].map(|place| f64::from(u8::from(place == column)));
            let Xyz { x, y, z, .. } =
                Xyz::<D50, f64>::adapt_from_unclamped(Xyz::<D65, f64>::new(x, y, z));
            let theirs = DVec3::new(x, y, z);
            assert!(ours.col(column).abs_diff_eq(theirs, 1.6e-7), "{theirs}");
        }
    }
}
