//! Khronos PBR Neutral: base colors as they are, highlights compressed and bleached.
//!
//! Source: Khronos Group, "PBR Neutral Specification" (github.com/KhronosGroup/ToneMapping). With x the
//! smallest channel and F = 0.04, the reflectance of common dielectrics at normal incidence, f = x − x²/(4F)
//! up to x = 2F and F above is taken from all channels. Then, with p the largest, K = 0.8 − F: up to K all
//! stays as it is; above, the largest becomes q = 1 − (1 − K)²/(p + 1 − 2K), the others in proportion, and all
//! are mixed with the gray q by 1 − g, g = 1/(0.15 (p − q) + 1).
//!
//! The specification is of colors that are not negative; here negative channels are taken for 0.

use fearless_simd::Simd;

use crate::display::lanes::{Rgb, Transform, each};
use crate::simd::F64x16;

/// F of the specification.
const FRESNEL: f64 = 0.04;

/// K_s, from which on highlights are compressed.
const START: f64 = 0.8 - FRESNEL;

/// K_d: how soon they lose their color.
const DESATURATION: f64 = 0.15;

/// Khronos PBR Neutral, 0 to 1.
pub(in crate::display) struct PbrNeutral;

impl Transform for PbrNeutral {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
        let zero = F64x16::splat(simd, 0.0);
        let [r, g, b] = each(
            rgb,
            #[inline(always)]
            |x| x.max(zero),
        );
        let least = r.min(g).min(b);
        let is_dark = least.le(F64x16::splat(simd, 2.0 * FRESNEL));
        let reflected = is_dark.select(
            least - least * least / (4.0 * FRESNEL),
            F64x16::splat(simd, FRESNEL),
        );
        let rgb = [r - reflected, g - reflected, b - reflected];
        let peak = r.max(g).max(b) - reflected;
        let is_high = peak.gt(F64x16::splat(simd, START));
        let square = F64x16::splat(simd, (1.0 - START) * (1.0 - START));
        // Where it is not high, neither divisor is used; 1 keeps them from 0.
        let one = F64x16::splat(simd, 1.0);
        let peak = is_high.select(peak, one);
        let compressed = one - square / (peak + (1.0 - 2.0 * START));
        let kept = one / ((peak - compressed) * DESATURATION + 1.0);
        let scale = compressed / peak * kept;
        let gray = compressed * (one - kept);
        each(
            rgb,
            #[inline(always)]
            |x| is_high.select(x * scale + gray, x),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::lanes::of_one;

    #[test]
    fn closed_form() {
        // By the formula, to six decimals.
        for (rgb, expected) in [
            ([0.18; 3], [0.14; 3]),
            ([1.0; 3], [0.869_091; 3]),
            ([4.0; 3], [0.983_256; 3]),
            ([4.0, 0.1, 0.1], [0.983_256, 0.313_812, 0.313_812]),
            // 0.05 − 0.05²/0.16 is taken.
            ([0.05, 0.3, 0.5], [0.015_625, 0.265_625, 0.465_625]),
            ([0.0; 3], [0.0; 3]),
            ([-1.0, 0.0, 0.5], [0.0, 0.0, 0.5]),
        ] {
            let result = of_one(&PbrNeutral, rgb);
            for (actual, expected) in result.into_iter().zip(expected) {
                assert!((actual - expected).abs() < 6e-7, "{rgb:?}: {result:?}");
            }
        }
    }

    #[test]
    fn base_colors_lose_the_reflection_alone() {
        let rgb = [0.08, 0.35, 0.79];
        let result = of_one(&PbrNeutral, rgb);
        for (x, y) in rgb.into_iter().zip(result) {
            assert!((x - FRESNEL - y).abs() < 1e-15);
        }
    }
}
