//! How different two colors look: CIE 1976 L\*a\*b\* and the CIEDE2000 difference.
//!
//! L\*a\*b\* is palette's. CIEDE2000 is our own: palette 0.7.7 lacks the last case of equation (14), hues that sum to more than
//! 360° from opposite sides, and is up to 2.1e-4 off there.
//!
//! Roots, powers and angles are libm's own, which are the same on every machine.

use glam::DVec3;
use palette::convert::FromColorUnclamped;
use palette::white_point::E;

/// A color in CIE 1976 L\*a\*b\* (ISO/CIE 11664-4:2019), relative to a white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lab {
    /// L\*, the lightness: 0 for black, 100 for the white.
    pub l: f64,
    /// a\*: green below 0, red above.
    pub a: f64,
    /// b\*: blue below 0, yellow above.
    pub b: f64,
}

impl Lab {
    /// L\* = 116 f(Y/Yₙ) − 16, a\* = 500 (f(X/Xₙ) − f(Y/Yₙ)), b\* = 200 (f(Y/Yₙ) − f(Z/Zₙ)).
    ///
    /// `xyz` and `white` have the same scale; the white is positive. Negative `xyz`, of colors
    /// outside a gamut, are on the line with which f begins, so that every finite color has a
    /// finite result.
    pub fn from_xyz(xyz: DVec3, white: DVec3) -> Self {
        // Relative to the white, the white is (1, 1, 1).
        let [x, y, z] = (xyz / white).to_array();
        let palette::Lab { l, a, b, .. } =
            palette::Lab::from_color_unclamped(palette::Xyz::<E, f64>::new(x, y, z));
        Self { l, a, b }
    }
}

/// CIEDE2000 with k_L = k_C = k_H = 1 (ISO/CIE 11664-6:2014); about 1 is just noticeable.
///
/// Symmetric, never negative, and 0 for equal colors. Step by step as in Sharma, Wu and Dalal, "The
/// CIEDE2000 color-difference formula" (Color Research & Application 30, 2005), whose equation
/// numbers are those below. The formula itself jumps where the hues are opposite.
pub fn delta_e_2000(a: Lab, b: Lab) -> f64 {
    // (2) to (7): a* is stretched near gray, which turns (a*, b*) into chroma and hue.
    let mean_chroma = (libm::hypot(a.a, a.b) + libm::hypot(b.a, b.b)) / 2.0;
    let stretch = 1.5 - 0.5 * saturation(mean_chroma);
    let (chroma_a, hue_a) = chroma_and_hue(a.a * stretch, a.b);
    let (chroma_b, hue_b) = chroma_and_hue(b.a * stretch, b.b);
    let both_have_hue = chroma_a != 0.0 && chroma_b != 0.0;

    // (8) to (11): the differences.
    let lightness = b.l - a.l;
    let chroma = chroma_b - chroma_a;
    let turn = hue_b - hue_a;
    let angle = if !both_have_hue {
        0.0
    } else if turn > 180.0 {
        turn - 360.0
    } else if turn < -180.0 {
        turn + 360.0
    } else {
        turn
    };
    let hue = 2.0 * libm::sqrt(chroma_a * chroma_b) * sin_degrees(angle / 2.0);

    // (12) to (14): the means. Hues more than half a circle apart meet on the other side.
    let mean_lightness = (a.l + b.l) / 2.0;
    let mean_chroma = (chroma_a + chroma_b) / 2.0;
    let sum = hue_a + hue_b;
    let mean_hue = if !both_have_hue {
        sum // One of them is 0 because it is none.
    } else if turn.abs() <= 180.0 {
        sum / 2.0
    } else if sum < 360.0 {
        (sum + 360.0) / 2.0
    } else {
        (sum - 360.0) / 2.0
    };

    // (15) to (21): how much each difference weighs there, and how chroma and hue interact in blue.
    let t = 1.0 - 0.17 * cos_degrees(mean_hue - 30.0)
        + 0.24 * cos_degrees(2.0 * mean_hue)
        + 0.32 * cos_degrees(3.0 * mean_hue + 6.0)
        - 0.20 * cos_degrees(4.0 * mean_hue - 63.0);
    let from_blue = (mean_hue - 275.0) / 25.0;
    let rotation = 30.0 * libm::exp(-from_blue * from_blue);
    let from_middle = (mean_lightness - 50.0) * (mean_lightness - 50.0);
    let lightness = lightness / (1.0 + 0.015 * from_middle / libm::sqrt(20.0 + from_middle));
    let chroma = chroma / (1.0 + 0.045 * mean_chroma);
    let hue = hue / (1.0 + 0.015 * mean_chroma * t);
    let interaction = -2.0 * saturation(mean_chroma) * sin_degrees(2.0 * rotation);

    // (22). The interaction is weaker than −2, so that only rounding could make the sum negative.
    let square = lightness * lightness + chroma * chroma + hue * hue + interaction * chroma * hue;
    libm::sqrt(square.max(0.0))
}

/// √(C⁷ / (C⁷ + 25⁷)): 0 for gray to 1 for vivid colors. As a ratio, it cannot overflow.
fn saturation(chroma: f64) -> f64 {
    1.0 / libm::sqrt(1.0 + libm::pow(25.0 / chroma, 7.0))
}

/// Chroma, and the hue in degrees from 0 to 360; gray has the hue 0.
fn chroma_and_hue(a: f64, b: f64) -> (f64, f64) {
    let chroma = libm::hypot(a, b);
    let hue = if chroma == 0.0 {
        0.0 // atan2 would tell apart the signs of zero.
    } else {
        libm::atan2(b, a).to_degrees()
    };
    (chroma, if hue < 0.0 { hue + 360.0 } else { hue })
}

fn sin_degrees(angle: f64) -> f64 {
    libm::sin(angle.to_radians())
}

fn cos_degrees(angle: f64) -> f64 {
    libm::cos(angle.to_radians())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Primaries;

    /// Half a unit of the fourth decimal, to which the 34 pairs are printed.
    const FOUR_DECIMALS: f64 = 0.5e-4;

    /// L\*a\*b\* is up to 100 and printed to ten decimals.
    const TEN_DECIMALS: f64 = 0.5e-10 + 1e-12;

    fn lab([l, a, b]: [f64; 3]) -> Lab {
        Lab { l, a, b }
    }

    fn assert_lab(found: Lab, expected: [f64; 3]) {
        let expected = lab(expected);
        assert!(
            (found.l - expected.l).abs() < TEN_DECIMALS
                && (found.a - expected.a).abs() < TEN_DECIMALS
                && (found.b - expected.b).abs() < TEN_DECIMALS,
            "{found:?} is not {expected:?}"
        );
    }

    /// Against colour-science 0.4.7, `XYZ_to_Lab` with the white at xy = (0.3127, 0.3290).
    #[test]
    fn lab_is_that_of_colour_science() {
        let white = Primaries::REC709.white_xyz();
        let of_xyz = |xyz| Lab::from_xyz(DVec3::from_array(xyz), white);
        assert_lab(
            of_xyz([0.20654008, 0.12197225, 0.05136952]),
            [41.527875294398, 52.638583035795, 26.923179222010],
        );
        // Below the knee, and below zero, on the same line: L* is odd there.
        assert_lab(
            of_xyz([0.001, 0.002, 0.003]),
            [1.806592592593, -3.690562484454, -1.175336206986],
        );
        assert_lab(
            of_xyz([-0.033, -0.002, 0.01]),
            [-1.806592592593, -127.396623198190, -17.409220516908],
        );
        let of_rgb = |rgb| of_xyz((Primaries::REC709.to_xyz() * DVec3::from_array(rgb)).to_array());
        assert_lab(
            of_rgb([1.0, 0.0, 0.0]),
            [53.237115595429, 80.090113523104, 67.203263511722],
        );
        assert_lab(
            of_rgb([0.0, 1.0, 0.0]),
            [87.735519109660, -86.181596890399, 83.186620273630],
        );
        assert_lab(
            of_rgb([0.0, 0.0, 1.0]),
            [32.300872903980, 79.195270307404, -107.855465539743],
        );
        assert_lab(of_rgb([0.18, 0.18, 0.18]), [49.496107610120, 0.0, 0.0]);
        assert_lab(of_rgb([1.0, 1.0, 1.0]), [100.0, 0.0, 0.0]);
        assert_lab(of_rgb([0.0, 0.0, 0.0]), [0.0, 0.0, 0.0]);
    }

    /// The scale cancels: XYZ in cd/m² gives the same as XYZ relative to the white.
    #[test]
    fn lab_is_relative_to_the_white() {
        let white = Primaries::AP1.white_xyz();
        let xyz = DVec3::new(0.3, 0.2, 0.1);
        let Lab { l, a, b } = Lab::from_xyz(xyz, white);
        assert_lab(Lab::from_xyz(xyz * 1234.5, white * 1234.5), [l, a, b]);
    }

    #[test]
    fn pieces_of_lab_meet() {
        let knee = 216.0_f64 / 24389.0;
        let cube_root_or_line = |ratio| {
            let Lab { l, .. } = Lab::from_xyz(DVec3::splat(ratio), DVec3::ONE);
            (l + 16.0) / 116.0
        };
        let step = cube_root_or_line(knee.next_up()) - cube_root_or_line(knee.next_down());
        assert!(step.abs() < 1e-15, "{step}");
        let slope =
            |from: f64, to: f64| (cube_root_or_line(to) - cube_root_or_line(from)) / (to - from);
        // A tangent: the slopes differ by the curvature alone, f″ h ≈ 600 h.
        let h = 1e-6;
        let bend = slope(knee, knee + h) - slope(knee - h, knee);
        assert!(bend.abs() < 1e-3, "{bend}");
    }

    /// Sharma, Wu and Dalal (2005), table 1, as printed there; colour-science 0.4.7 agrees.
    const SHARMA: [([f64; 3], [f64; 3], f64); 34] = [
        ([50.0, 2.6772, -79.7751], [50.0, 0.0, -82.7485], 2.0425),
        ([50.0, 3.1571, -77.2803], [50.0, 0.0, -82.7485], 2.8615),
        ([50.0, 2.8361, -74.0200], [50.0, 0.0, -82.7485], 3.4412),
        ([50.0, -1.3802, -84.2814], [50.0, 0.0, -82.7485], 1.0000),
        ([50.0, -1.1848, -84.8006], [50.0, 0.0, -82.7485], 1.0000),
        ([50.0, -0.9009, -85.5211], [50.0, 0.0, -82.7485], 1.0000),
        ([50.0, 0.0, 0.0], [50.0, -1.0, 2.0], 2.3669),
        ([50.0, -1.0, 2.0], [50.0, 0.0, 0.0], 2.3669),
        ([50.0, 2.4900, -0.0010], [50.0, -2.4900, 0.0009], 7.1792),
        ([50.0, 2.4900, -0.0010], [50.0, -2.4900, 0.0010], 7.1792),
        ([50.0, 2.4900, -0.0010], [50.0, -2.4900, 0.0011], 7.2195),
        ([50.0, 2.4900, -0.0010], [50.0, -2.4900, 0.0012], 7.2195),
        ([50.0, -0.0010, 2.4900], [50.0, 0.0009, -2.4900], 4.8045),
        ([50.0, -0.0010, 2.4900], [50.0, 0.0010, -2.4900], 4.8045),
        ([50.0, -0.0010, 2.4900], [50.0, 0.0011, -2.4900], 4.7461),
        ([50.0, 2.5, 0.0], [50.0, 0.0, -2.5], 4.3065),
        ([50.0, 2.5, 0.0], [73.0, 25.0, -18.0], 27.1492),
        ([50.0, 2.5, 0.0], [61.0, -5.0, 29.0], 22.8977),
        ([50.0, 2.5, 0.0], [56.0, -27.0, -3.0], 31.9030),
        ([50.0, 2.5, 0.0], [58.0, 24.0, 15.0], 19.4535),
        ([50.0, 2.5, 0.0], [50.0, 3.1736, 0.5854], 1.0000),
        ([50.0, 2.5, 0.0], [50.0, 3.2972, 0.0], 1.0000),
        ([50.0, 2.5, 0.0], [50.0, 1.8634, 0.5757], 1.0000),
        ([50.0, 2.5, 0.0], [50.0, 3.2592, 0.3350], 1.0000),
        (
            [60.2574, -34.0099, 36.2677],
            [60.4626, -34.1751, 39.4387],
            1.2644,
        ),
        (
            [63.0109, -31.0961, -5.8663],
            [62.8187, -29.7946, -4.0864],
            1.2630,
        ),
        (
            [61.2901, 3.7196, -5.3901],
            [61.4292, 2.2480, -4.9620],
            1.8731,
        ),
        (
            [35.0831, -44.1164, 3.7933],
            [35.0232, -40.0716, 1.5901],
            1.8645,
        ),
        (
            [22.7233, 20.0904, -46.6940],
            [23.0331, 14.9730, -42.5619],
            2.0373,
        ),
        (
            [36.4612, 47.8580, 18.3852],
            [36.2715, 50.5065, 21.2231],
            1.4146,
        ),
        (
            [90.8027, -2.0831, 1.4410],
            [91.1528, -1.6435, 0.0447],
            1.4441,
        ),
        (
            [90.9257, -0.5406, -0.9208],
            [88.6381, -0.8985, -0.7239],
            1.5381,
        ),
        (
            [6.7747, -0.2908, -2.4247],
            [5.8714, -0.0985, -2.2286],
            0.6377,
        ),
        (
            [2.0776, 0.0795, -1.1350],
            [0.9033, -0.0636, -0.5514],
            0.9082,
        ),
    ];

    #[test]
    fn the_34_pairs_of_sharma() {
        for (index, (a, b, expected)) in SHARMA.into_iter().enumerate() {
            let found = delta_e_2000(lab(a), lab(b));
            let pair = index + 1;
            assert!(
                (found - expected).abs() < FOUR_DECIMALS,
                "pair {pair}: {found} is not {expected}"
            );
        }
    }

    #[test]
    fn symmetric_and_zero_for_equals() {
        for (a, b, _) in SHARMA {
            let there = delta_e_2000(lab(a), lab(b));
            let back = delta_e_2000(lab(b), lab(a));
            assert!((there - back).abs() < 1e-12, "{there}, {back}");
            assert_eq!(delta_e_2000(lab(a), lab(a)), 0.0);
        }
    }

    /// Black, gray of either sign of zero, colors outside every gamut, and absurdly vivid ones.
    #[test]
    fn every_finite_color_has_a_difference() {
        let white = Primaries::REC709.white_xyz();
        let mut colors = vec![
            lab([0.0, 0.0, 0.0]),
            lab([50.0, -0.0, 0.0]),
            lab([50.0, -0.0, -0.0]),
            lab([-20.0, 1e-300, -1e-300]),
            lab([1e4, -1e50, 1e50]),
        ];
        for x in [-0.5, 0.0, 0.9] {
            for y in [-0.1, 0.0, 1.0] {
                for z in [-2.0, 0.0, 30.0] {
                    colors.push(Lab::from_xyz(DVec3::new(x, y, z), white));
                }
            }
        }
        for &a in &colors {
            for &b in &colors {
                let difference = delta_e_2000(a, b);
                assert!(
                    difference.is_finite() && difference >= 0.0,
                    "{difference} between {a:?} and {b:?}"
                );
            }
        }
        let gray = |sign: f64| lab([50.0, sign * 0.0, sign * 0.0]);
        assert_eq!(delta_e_2000(gray(1.0), gray(-1.0)), 0.0);
    }

    /// palette's, where the hues do not meet beyond 360°, and how far it is off where they do.
    #[test]
    fn palette_agrees_but_for_one_case() {
        use palette::color_difference::Ciede2000;
        let mut state = 1_u64;
        let mut random = |least: f64, most: f64| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            least + (most - least) * (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        let (mut agreeing, mut other) = (0.0_f64, 0.0_f64);
        for _ in 0..100_000 {
            let [a, b] = [(); 2].map(|()| {
                lab([
                    random(0.0, 100.0),
                    random(-128.0, 128.0),
                    random(-128.0, 128.0),
                ])
            });
            let theirs = |Lab { l, a, b }| palette::Lab::<E, f64>::new(l, a, b);
            let error = (delta_e_2000(a, b) - theirs(a).difference(theirs(b))).abs();
            let chroma = |color: Lab| libm::hypot(color.a, color.b);
            let stretch = 1.5 - 0.5 * saturation((chroma(a) + chroma(b)) / 2.0);
            let [one, two] = [a, b].map(|color| chroma_and_hue(color.a * stretch, color.b).1);
            if (one - two).abs() > 180.0 && one + two >= 360.0 {
                other = other.max(error);
            } else {
                agreeing = agreeing.max(error);
            }
        }
        assert!(agreeing < 1e-9, "{agreeing}");
        assert!(other > 1e-5 && other < 4.2e-4, "{other}");
    }
}
