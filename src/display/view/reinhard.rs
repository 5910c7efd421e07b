//! Reinhard et al. 2002, eq. 3: x / (1 + x).
//!
//! The paper has it on luminance. Here it is applied per channel, as most renderers do: on
//! luminance a saturated color keeps channels above 1, which then clip with a shift in hue, while
//! per channel everything stays inside 0 to 1 and strong light bleaches towards white.

use fearless_simd::Simd;

use crate::display::lanes::{Rgb, Transform, each};
use crate::simd::F64x16;

/// x / (1 + x) for each channel, 0 below 0.
pub(in crate::display) struct Reinhard;

impl Transform for Reinhard {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
        let zero = F64x16::splat(simd, 0.0);
        each(
            rgb,
            #[inline(always)]
            |x| {
                let x = x.max(zero);
                x / (x + 1.0)
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::lanes::of_one;

    #[test]
    fn closed_form() {
        let [a, b, c] = of_one(&Reinhard, [0.18, 1.0, 4.0]);
        assert!((a - 0.18 / 1.18).abs() < f64::EPSILON);
        assert!((b - 0.5).abs() < f64::EPSILON);
        assert!((c - 0.8).abs() < f64::EPSILON);
    }
}
