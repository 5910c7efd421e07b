//! ACES 1.0's SDR Video for an sRGB screen: the reference rendering transform (RRT) and the output transform (ODT)
//! of 100 cd/m² in dim surround, as OpenColorIO has them.
//!
//! Source of the constants: the Academy's CTL, github.com/ampas/aces-dev 1.3, `RRT.ctl`,
//! `ODT.Academy.sRGB_100nits_dim.ctl` and the files of `ACESlib` named below. The judge is the view
//! "ACES 1.0 - SDR Video" of the display "sRGB - Display" in OpenColorIO's config
//! `studio-config-v2.2.0_aces-v1.3_ocio-v2.4`: `reference/display/ocio.py`.
//!
//! 1. Linear Rec.709 to AP0, by Bradford's adaptation from D65 to ACES's white.
//! 2. Glow: saturated dark colors become up to 5 % brighter.
//! 3. Red modifier: saturated reds become darker.
//! 4. AP0 to AP1, negative values cut before and after; colors are moved to the gray of their luminance by 4 %.
//! 5. The tone curve, per channel, on log₁₀: the RRT's spline and then the ODT's for 48 cd/m² of cinema.
//! 6. cd/m² to light: from 0.02 to 48.
//! 7. The dim surround: luminance to the power of 0.9811.
//! 8. To the gray by 7 %; AP1 to linear Rec.709, by Bradford's adaptation back.
//!
//! As in OpenColorIO, nothing is cut after step 4: the result is negative where a color is outside of Rec.709, and
//! above 1 for grays above 0.18 · 2^6.5 ≈ 16.3, up to 1.1. The CTL cuts at 0 and 1 in the end, and so does a screen.

use std::f64::consts::{LOG2_10, LOG10_2};

use fearless_simd::Simd;
use glam::DMat3;

use crate::color::Primaries;
use crate::color::adaptation::conversion;
use crate::display::lanes::{Rgb, Transform, each, exp2, log2, product, rows};
use crate::simd::{F64x16, angle, power};

/// `ACESlib.RRT_Common`: how much brighter dark colors become at most, and the luma of half of that.
const GLOW_GAIN: f64 = 0.05;
const GLOW_MIDDLE: f64 = 0.08;

/// `ACESlib.Utilities_Color`, `rgb_2_yc`: the share of the chroma in the luma.
const CHROMA_WEIGHT: f64 = 1.75;

/// `ACESlib.RRT_Common`: scale and pivot of red, and the hues for which they are, so many degrees around red.
const RED_SCALE: f64 = 0.82;
const RED_PIVOT: f64 = 0.03;
const RED_WIDTH: f64 = 135.0;

/// `ACESlib.RRT_Common` and `ACESlib.ODT_Common`: what is kept of the distance from gray.
const RRT_SATURATION: f64 = 0.96;
const ODT_SATURATION: f64 = 0.93;

/// `ACESlib.ODT_Common`: the exponent of the luminance.
const DIM_SURROUND: f64 = 0.9811;

/// In cd/m², `ACESlib.ODT_Common`: the black and the white of cinema.
const BLACK: f64 = 0.02;
const WHITE: f64 = 48.0;

/// A gray card, and the stops from it to the ends of the RRT's spline and of the ODT's (`ACESlib.Tonescales`).
const GRAY: f64 = 0.18;
const RRT_STOPS: f64 = 15.0;
const RRT_STOPS_ABOVE: f64 = 18.0;
const ODT_STOPS: f64 = 6.5;

/// log₁₀ of cd/m², the coefficients of the quadratic B-splines below and above the gray card
/// (`ACESlib.Tonescales`: `RRT_PARAMS`, and `ODT_48nits`).
const RRT: [[f64; 5]; 2] = [
    [
        -4.0,
        -4.0,
        -3.157_376_577_3,
        -0.485_249_995_8,
        1.847_732_470_6,
    ],
    [-0.718_548_242_5, 2.081_030_717_2, 3.668_124_123_7, 4.0, 4.0],
];
const ODT: [[f64; 9]; 2] = [
    [
        -1.698_970_004_3,
        -1.698_970_004_3,
        -1.477_9,
        -1.229_1,
        -0.864_8,
        -0.448,
        0.005_18,
        0.451_108_033_4,
        0.911_374_441_4,
    ],
    [
        0.515_438_696_5,
        0.847_043_778_3,
        1.135_8,
        1.380_2,
        1.519_7,
        1.598_5,
        1.646_7,
        1.674_609_135_7,
        1.687_873_339_0,
    ],
];

/// The slope of the ODT's spline beyond its upper end; the other ends are level.
const ODT_SLOPE_ABOVE: f64 = 0.04;

/// The view with its matrices by rows.
pub(in crate::display) struct Aces1 {
    to_aces: [[f64; 3]; 3],
    to_ap1: [[f64; 3]; 3],
    rrt_saturation: [[f64; 3]; 3],
    rrt: Spline<6>,
    odt: Spline<14>,
    /// Of AP1 in the luminance.
    luminance: [f64; 3],
    to_screen: [[f64; 3]; 3],
}

impl Aces1 {
    /// The gray that becomes the screen's white, 0.18 · 2^6.5.
    pub(in crate::display) const WHITE: f64 = 16.291_7;

    pub(in crate::display) fn new() -> Self {
        let (ap0, ap1, screen) = (Primaries::AP0, Primaries::AP1, Primaries::REC709);
        let stops = |stops: f64| libm::log10(GRAY * libm::exp2(stops));
        let rrt = Spline::new(
            &RRT,
            [stops(-RRT_STOPS), stops(0.0), stops(RRT_STOPS_ABOVE)],
            0.0,
        );
        let ends = [-ODT_STOPS, 0.0, ODT_STOPS].map(|stop| rrt.at(stops(stop)));
        Self {
            to_aces: rows(conversion(&screen, &ap0)),
            to_ap1: rows(conversion(&ap0, &ap1)),
            rrt_saturation: rows(saturation(RRT_SATURATION, &ap1)),
            odt: Spline::new(&ODT, ends, ODT_SLOPE_ABOVE),
            rrt,
            luminance: ap1.luminance_weights(),
            to_screen: rows(conversion(&ap1, &screen) * saturation(ODT_SATURATION, &ap1)),
        }
    }
}

/// Keeps `share` of the distance from the gray of the same luminance.
fn saturation(share: f64, primaries: &Primaries) -> DMat3 {
    let weights = glam::DVec3::from_array(primaries.luminance_weights()) * (1.0 - share);
    let gray = DMat3::from_rows(weights, weights, weights);
    gray + DMat3::from_diagonal(glam::DVec3::splat(share))
}

impl Transform for Aces1 {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
        let zero = F64x16::splat(simd, 0.0);
        let rgb = redder(simd, glowing(simd, product(&self.to_aces, rgb)));
        let rgb = at_least(zero, product(&self.to_ap1, at_least(zero, rgb)));
        let rgb = each(
            product(&self.rrt_saturation, rgb),
            #[inline(always)]
            |x| {
                // log₂ is of normal numbers; all below 5e-6 is black.
                let x = log2(simd, x.max(F64x16::splat(simd, 1e-30))) * LOG10_2;
                let luminance = exp2(
                    simd,
                    self.odt.lanes(simd, self.rrt.lanes(simd, x)) * LOG2_10,
                );
                // Black is 0 but for the last bits.
                ((luminance - BLACK) / (WHITE - BLACK)).max(zero)
            },
        );
        let [red, green, blue] = self.luminance;
        let [r, g, b] = rgb;
        let luminance = r * red + g * green + b * blue;
        // As OpenColorIO has it, to keep 0 from being divided by.
        let luminance = luminance.max(F64x16::splat(simd, 1e-10));
        let dimmed = power(simd, luminance, DIM_SURROUND - 1.0);
        let rgb = each(
            rgb,
            #[inline(always)]
            |x| x * dimmed,
        );
        product(&self.to_screen, rgb)
    }
}

#[inline(always)]
fn at_least<S: Simd>(least: F64x16<S>, rgb: Rgb<S>) -> Rgb<S> {
    each(
        rgb,
        #[inline(always)]
        |x| x.max(least),
    )
}

/// How far a color is from gray, 0 to 1, as ACES measures it: with noise in the dark taken for gray.
#[inline(always)]
fn distance_from_gray<S: Simd>(simd: S, [r, g, b]: Rgb<S>) -> F64x16<S> {
    let least = F64x16::splat(simd, 1e-10);
    let (low, high) = (r.min(g).min(b), r.max(g).max(b));
    (high.max(least) - low.max(least)) / high.max(F64x16::splat(simd, 1e-2))
}

/// Dark colors that are not gray, up to 5 % brighter.
#[inline(always)]
fn glowing<S: Simd>(simd: S, rgb: Rgb<S>) -> Rgb<S> {
    let zero = F64x16::splat(simd, 0.0);
    let one = F64x16::splat(simd, 1.0);
    let [r, g, b] = rgb;
    // Not negative but by rounding.
    let chroma = (b * (b - g) + g * (g - r) + r * (r - b)).max(zero).sqrt();
    let luma = (r + g + b + chroma * CHROMA_WEIGHT) / 3.0;
    // A smooth step of the saturation from 0 to 0.8, of two parabolas.
    let from_middle = (distance_from_gray(simd, rgb) - 0.4) / 0.2;
    let rest = (one - from_middle.abs() * 0.5).max(zero);
    let half_step = one - rest * rest;
    let half_step = from_middle.lt(zero).select(-half_step, half_step);
    let gain = (half_step + 1.0) * (0.5 * GLOW_GAIN);
    // All of it up to ⅔ of the middle, none from twice the middle on.
    let is_bright = luma.ge(F64x16::splat(simd, 2.0 * GLOW_MIDDLE));
    let luma = luma.max(F64x16::splat(simd, 2.0 / 3.0 * GLOW_MIDDLE));
    let share = F64x16::splat(simd, GLOW_MIDDLE) / luma - 0.5;
    let factor = one + is_bright.select(zero, gain * share);
    each(
        rgb,
        #[inline(always)]
        |x| x * factor,
    )
}

/// Reds that are not gray, darker.
#[inline(always)]
fn redder<S: Simd>(simd: S, rgb: Rgb<S>) -> Rgb<S> {
    let zero = F64x16::splat(simd, 0.0);
    let [r, g, b] = rgb;
    let (x, y) = (r * 2.0 - g - b, (g - b) * 3.0_f64.sqrt());
    let hue = angle(simd, [x, y], (x * x + y * y).sqrt());
    // A cubic B-spline of five knots over the width, 1 in the middle, as two truncated cubes.
    let from_red = hue.min(-hue + 360.0) * (4.0 / RED_WIDTH);
    let outer = (-from_red + 2.0).max(zero);
    let inner = (-from_red + 1.0).max(zero);
    let weight = (outer * outer * outer - inner * inner * inner * 4.0) * 0.25;
    let weight = weight * distance_from_gray(simd, rgb);
    [r + weight * (-r + RED_PIVOT) * (1.0 - RED_SCALE), g, b]
}

/// A quadratic spline without breaks in slope, level before its first knot: y = y₀ + Σ cₖ max(x − xₖ, 0)², up to its last
/// knot, and straight beyond.
struct Spline<const N: usize> {
    first: f64,
    /// xₖ and cₖ
    bends: [[f64; 2]; N],
    last: f64,
    slope_above: f64,
}

impl<const N: usize> Spline<N> {
    /// From the coefficients of two B-splines with evenly spaced knots, which meet with one slope, and the ends
    /// of both.
    fn new<const M: usize>(
        [below, above]: &[[f64; M]; 2],
        [first, middle, last]: [f64; 3],
        slope_above: f64,
    ) -> Self {
        const {
            assert!(
                N == 2 * (M - 2),
                "each side has two segments less than coefficients"
            );
        };
        let side = |coefficients: &[f64; M], start: f64, end: f64| {
            let step = (end - start) / (M - 2) as f64;
            // Of x², in each segment.
            let curvatures = coefficients.windows(3);
            let curvatures =
                curvatures.map(move |c| (c[0] - 2.0 * c[1] + c[2]) / (2.0 * step * step));
            let knots = (0..M - 2).map(move |k| start + k as f64 * step);
            knots.zip(curvatures).collect::<Vec<_>>()
        };
        let segments = [side(below, first, middle), side(above, middle, last)].concat();
        let mut before = 0.0;
        let mut bends = [[0.0; 2]; N];
        for (bend, (knot, curvature)) in bends.iter_mut().zip(segments) {
            *bend = [knot, curvature - before];
            before = curvature;
        }
        Self {
            first: (below[0] + below[1]) / 2.0,
            bends,
            last,
            slope_above,
        }
    }

    fn at(&self, x: f64) -> f64 {
        let within = x.min(self.last);
        let bends = self.bends.iter().map(|[knot, bend]| {
            let beyond = (within - knot).max(0.0);
            bend * beyond * beyond
        });
        self.first + bends.sum::<f64>() + self.slope_above * (x - self.last).max(0.0)
    }

    /// [`Self::at`], in every lane.
    #[inline(always)]
    fn lanes<S: Simd>(&self, simd: S, x: F64x16<S>) -> F64x16<S> {
        let zero = F64x16::splat(simd, 0.0);
        let within = x.min(F64x16::splat(simd, self.last));
        let mut y = (x - self.last).max(zero) * self.slope_above + self.first;
        for &[knot, bend] in &self.bends {
            let beyond = (within - knot).max(zero);
            y = y + beyond * beyond * bend;
        }
        y
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::transfer;
    use crate::display::lanes::of_one;

    /// The sRGB curve, which goes straight on below 0, as in OpenColorIO.
    fn code(light: f64) -> f64 {
        transfer::srgb_encode(light)
    }

    /// OpenColorIO 2.6.0 without optimization, in f32. Where the pieces of its sRGB curve meet they have one slope,
    /// which makes 1e-5 of difference, and 2.5e-4 of what is below 0.
    #[test]
    fn opencolorio_agrees() {
        for (rgb, expected) in [
            ([0.01; 3], [0.012_837; 3]),
            ([0.18; 3], [0.355_954; 3]),
            ([1.0; 3], [0.811_971; 3]),
            ([4.0; 3], [0.955_280; 3]),
            ([16.0; 3], [0.999_741; 3]),
            ([1.0, 0.0, 0.0], [0.803_756, -0.097_859, 0.024_502]),
            ([0.0, 1.0, 0.0], [0.329_846, 0.818_209, 0.169_028]),
            ([0.0, 0.0, 1.0], [-0.310_615, -0.035_383, 0.823_408]),
            ([4.0, 4.0, 0.0], [0.966_159, 0.956_025, 0.693_160]),
            ([0.8, 0.3, 0.05], [0.772_188, 0.509_798, 0.183_205]),
            ([0.45, 0.27, 0.19], [0.601_724, 0.471_494, 0.384_625]),
        ] {
            let codes = of_one(&Aces1::new(), rgb).map(code);
            for (code, expected) in codes.into_iter().zip(expected) {
                let allowed = 1e-5 + 2.5e-4 * f64::max(-expected, 0.0);
                assert!((code - expected).abs() < allowed, "{rgb:?}: {codes:?}");
            }
        }
    }

    #[test]
    fn splines_go_through_their_ends() {
        let aces = Aces1::new();
        let stops = |stops: f64| libm::log10(GRAY * libm::exp2(stops));
        // `ACESlib.Tonescales` gives cd/m² at the ends and the gray card: 4.8 is 10 % of 48.
        for (found, expected) in [
            (aces.rrt.at(stops(-15.0)), 1e-4),
            (aces.rrt.at(stops(0.0)), 4.8),
            (aces.rrt.at(stops(18.0)), 1e4),
            (aces.rrt.at(stops(30.0)), 1e4),
            (aces.odt.at(aces.rrt.at(stops(-6.5))), 0.02),
            (aces.odt.at(aces.rrt.at(stops(0.0))), 4.8),
            (aces.odt.at(aces.rrt.at(stops(6.5))), 48.0),
        ] {
            let difference = (found - libm::log10(expected)).abs();
            // The coefficients have ten decimals, of log₁₀.
            assert!(difference < 1e-9, "{expected}: {difference}");
        }
        // Straight beyond: 10 000 cd/m² of the RRT, at 0.04 in log₁₀.
        let beyond = 0.04 * (4.0 - aces.rrt.at(stops(6.5)));
        assert!((aces.odt.at(4.0) - aces.odt.at(aces.rrt.at(stops(6.5))) - beyond).abs() < 1e-12);
    }

    #[test]
    fn saturations_are_the_published_matrices() {
        // `RRT_SAT_MAT` and `ODT_SAT_MAT`, their first rows, to eight decimals.
        let rrt = rows(saturation(RRT_SATURATION, &Primaries::AP1))[0];
        let odt = rows(saturation(ODT_SATURATION, &Primaries::AP1))[0];
        let expected = [
            [0.970_889_15, 0.026_963_27, 0.002_147_58],
            [0.949_056_01, 0.047_185_72, 0.003_758_27],
        ];
        for (row, expected) in [rrt, odt].into_iter().zip(expected) {
            for (number, expected) in row.into_iter().zip(expected) {
                assert!((number - expected).abs() < 6e-9);
            }
        }
    }
}
