//! The gamut compression of ACES 2.0 (Lib.Academy.OutputTransform.ctl, `compressGamut`): what is outside of
//! the limiting gamut comes inside at its hue, along a line in J and M towards a focus on the far side of the
//! axis of grays.

use fearless_simd::Simd;

use super::Limits;
use super::appearance::REFERENCE_LUMINANCE;
use crate::display::lanes::log2;
use crate::simd::{F64x16, power, powers};

/// `smoothCusps`: where the lower and the upper hull meet, the smaller one is rounded over this part of M.
const SMOOTH_CUSPS: f64 = 0.12;

/// `smoothM`: by this part of the rounding, cusps are moved outward.
const SMOOTH_COLORFULNESS: f64 = 0.27;

/// The cusps' M is this many times the gamut's, to make up for the rounding.
pub(super) const CUSP_MARGIN: f64 = 1.0 + SMOOTH_COLORFULNESS * SMOOTH_CUSPS;

/// `cuspMidBlend`: the focus is between the cusp's J and middle gray's.
const CUSP_TO_MIDDLE: f64 = 1.3;

/// `focusGainBlend`: above this part of the way from the cusp to the peak, lines are flatter.
const FLATTER_FROM: f64 = 0.3;

/// `focusDistance`, and how much of it is added for each tenfold peak.
const FOCUS_DISTANCE: f64 = 1.35;
const FOCUS_DISTANCE_GAIN: f64 = 1.75;

/// The least distance from the peak's J that flattens (`getFocusGain`).
const LEAST_DISTANCE: f64 = 1e-4;

/// `compressionThreshold`: what is inside of this part of the gamut stays.
const THRESHOLD: f64 = 0.75;

/// The exponent of the lower hull, and how much is added for each tenfold peak (`lowerHullGamma`).
const LOWER_HULL: f64 = 1.14;
const LOWER_HULL_GAIN: f64 = 0.07;

/// Below this colorfulness a color is taken for gray: it is at most this far from where it belongs.
const GRAY: f64 = 1e-8;

/// The limiting gamut at a hue.
pub(super) struct Gamut<S: Simd> {
    /// J and M where it is most colorful.
    pub(super) cusp: [F64x16<S>; 2],
    /// 1/γ
    pub(super) upper_hull: F64x16<S>,
}

/// A line through the axis of grays.
pub(super) struct Line<S: Simd> {
    /// J where M is 0.
    axis: F64x16<S>,
    /// J gained for each unit of M.
    slope: F64x16<S>,
    /// J on the axis of the line of the same focus and gain that goes through the cusp.
    cusp_axis: F64x16<S>,
}

/// What depends on the peak.
pub(super) struct Compression {
    limits: Limits,
    focus_distance: f64,
    /// 1/γ of the lower hull.
    lower_hull: f64,
    /// J of middle gray.
    middle: f64,
}

impl Compression {
    pub(super) fn new(peak: f64, middle: f64, limits: Limits) -> Self {
        let tenfolds = libm::log10(peak / REFERENCE_LUMINANCE);
        Self {
            limits,
            focus_distance: FOCUS_DISTANCE * (1.0 + FOCUS_DISTANCE_GAIN * tenfolds),
            lower_hull: 1.0 / (LOWER_HULL + LOWER_HULL_GAIN * tenfolds),
            middle,
        }
    }

    /// J and M inside of the gamut, of J and M up to where AP1 reaches, `reach` at the peak's J; and whether
    /// any of them is another than before.
    #[inline(always)]
    pub(super) fn apply<S: Simd>(
        &self,
        simd: S,
        gamut: &Gamut<S>,
        reach: F64x16<S>,
        [lightness, colorfulness]: [F64x16<S>; 2],
    ) -> ([F64x16<S>; 2], bool) {
        let zero = F64x16::splat(simd, 0.0);
        if !colorfulness.gt(F64x16::splat(simd, GRAY)).any() {
            return ([lightness, colorfulness], false);
        }
        let line = self.line(simd, gamut.cusp, [lightness, colorfulness]);
        let boundary = self.boundary(simd, gamut, &line);
        // Above the peak, or where the hulls leave nothing, all is gray.
        let is_gray = lightness.gt(F64x16::splat(simd, self.limits.lightness)) | boundary.le(zero);
        let inside = is_gray.select(zero, colorfulness);
        if !inside.gt(boundary * THRESHOLD).any() {
            return ([lightness, inside], false);
        }
        let reached = self.reached(simd, reach, &line);
        let part = (boundary / reached).max(F64x16::splat(simd, THRESHOLD));
        let threshold = part * boundary;
        // t + s n/(1 + n) with n = (M − t)/s: it maps t to t with a slope of 1, and what is reached to the
        // boundary.
        let beyond = inside - threshold;
        let per_scale = F64x16::splat(simd, 1.0) / (boundary - threshold)
            - F64x16::splat(simd, 1.0) / (reached - threshold);
        let compressed = threshold + beyond / (beyond * per_scale + 1.0);
        let is_compressed = beyond.gt(zero) & part.lt(F64x16::splat(simd, 1.0)) & !is_gray;
        (
            [
                is_compressed.select(line.axis + compressed * line.slope, lightness),
                is_compressed.select(compressed, inside),
            ],
            true,
        )
    }

    /// The line through J and M.
    #[inline(always)]
    pub(super) fn line<S: Simd>(
        &self,
        simd: S,
        cusp: [F64x16<S>; 2],
        [lightness, colorfulness]: [F64x16<S>; 2],
    ) -> Line<S> {
        let peak = F64x16::splat(simd, self.limits.lightness);
        let blend = -cusp[0] * (1.0 / self.limits.lightness) + CUSP_TO_MIDDLE;
        let blend = blend.min(F64x16::splat(simd, 1.0));
        let focus = cusp[0] + (-cusp[0] + self.middle) * blend;
        let flatter = cusp[0] + (peak - cusp[0]) * FLATTER_FROM;
        let mut gain = F64x16::splat(simd, self.limits.lightness * self.focus_distance);
        let is_flatter = lightness.gt(flatter);
        if is_flatter.any() {
            let distance = (peak - lightness).max(F64x16::splat(simd, LEAST_DISTANCE));
            let ratio = is_flatter.select((peak - flatter) / distance, F64x16::splat(simd, 1.0));
            let tenfolds = log2(simd, ratio) * std::f64::consts::LOG10_2;
            gain = gain * (tenfolds * tenfolds + 1.0);
        }
        let axis = self.axis([lightness, colorfulness], focus, gain);
        let cusp_axis = self.axis(cusp, focus, gain);
        let reach = axis.lt(focus).select(axis, peak - axis);
        Line {
            axis,
            slope: reach * (axis - focus) / (focus * gain),
            cusp_axis,
        }
    }

    /// J on the axis of grays of the line through J and M (`solve_J_intersect`).
    #[inline(always)]
    fn axis<S: Simd>(
        &self,
        [lightness, colorfulness]: [F64x16<S>; 2],
        focus: F64x16<S>,
        gain: F64x16<S>,
    ) -> F64x16<S> {
        let scaled = colorfulness / gain;
        let peak = self.limits.lightness;
        // The slope grows with the distance of x, the J that is sought, from the focus and from 0 or the peak:
        // J = x + M x (x − f)/(f g) below the focus, J = x + M (p − x) (x − f)/(f g) above. They are
        // a x² + b x = c and −a x² + b x = c, solved so that nothing cancels.
        let a = scaled / focus;
        let is_below = lightness.lt(focus);
        let b = is_below.select(-scaled + 1.0, scaled + a * peak + 1.0);
        let c = is_below.select(lightness, scaled * peak + lightness);
        let product = a * c * 4.0;
        let root = (b * b + is_below.select(product, -product)).sqrt();
        c * 2.0 / (b + root)
    }

    /// M where the line leaves the gamut (`findGamutBoundaryIntersection`).
    #[inline(always)]
    pub(super) fn boundary<S: Simd>(&self, simd: S, gamut: &Gamut<S>, line: &Line<S>) -> F64x16<S> {
        let cusp = gamut.cusp;
        let ratio = line.axis / line.cusp_axis;
        let shifted = line.cusp_axis * power(simd, ratio, self.lower_hull);
        let lower = crossing(shifted, line.slope, cusp);
        // The upper hull is the same upside down, from the peak.
        let peak = F64x16::splat(simd, self.limits.lightness);
        let [axis, cusp_axis] = [peak - line.axis, peak - line.cusp_axis];
        let shifted = cusp_axis * powers(simd, axis / cusp_axis, gamut.upper_hull);
        let upper = crossing(shifted, -line.slope, [peak - cusp[0], cusp[1]]);
        // The smaller of the two, rounded by a cubic where they are near each other.
        let width = cusp[1] * SMOOTH_CUSPS;
        let near = (width - (lower - upper).abs()).max(F64x16::splat(simd, 0.0)) / width;
        lower.min(upper) - near * near * near * width * (1.0 / 6.0)
    }

    /// M where the line leaves what AP1 reaches (`getReachBoundary`).
    #[inline(always)]
    fn reached<S: Simd>(&self, simd: S, reach: F64x16<S>, line: &Line<S>) -> F64x16<S> {
        let peak = self.limits.lightness;
        let part = power(simd, line.axis * (1.0 / peak), self.limits.per_exponent);
        crossing(part * peak, line.slope, [F64x16::splat(simd, peak), reach])
    }
}

impl<S: Simd> Line<S> {
    /// J at M.
    #[inline(always)]
    pub(super) fn lightness(&self, colorfulness: F64x16<S>) -> F64x16<S> {
        self.axis + self.slope * colorfulness
    }
}

/// M where a line from (axis, 0) meets the one from 0 to a corner (J, M). A hull is a power function from 0 to
/// its corner; that the line's axis is shifted by that power makes this an estimate of where the two meet.
#[inline(always)]
fn crossing<S: Simd>(
    axis: F64x16<S>,
    slope: F64x16<S>,
    [lightness, colorfulness]: [F64x16<S>; 2],
) -> F64x16<S> {
    axis * colorfulness / (lightness - slope * colorfulness)
}
