//! Screens: how light becomes code values.

use fearless_simd::Simd;

use super::lanes::{Rgb, Transform, each};
use crate::color::transfer::{CONTRAST, LINEAR_END, OFFSET, SLOPE};
use crate::simd::{F64x16, power};

/// From linear light in the screen's primaries, of which 1 is its white, to code values from 0 to 1: what is
/// outside clips.
pub(super) enum Transfer {
    /// [`crate::color::transfer`]
    Srgb,
}

impl Transform for Transfer {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
        let zero = F64x16::splat(simd, 0.0);
        let one = F64x16::splat(simd, 1.0);
        match self {
            Self::Srgb => each(
                rgb,
                #[inline(always)]
                |light| {
                    let light = light.max(zero).min(one);
                    let is_linear = light.le(F64x16::splat(simd, LINEAR_END));
                    let curved = power(simd, light, 1.0 / CONTRAST) * (1.0 + OFFSET) - OFFSET;
                    is_linear.select(light * SLOPE, curved)
                },
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::transfer;
    use crate::display::lanes::of_one;

    #[test]
    fn srgb_is_the_formula() {
        for i in -10..=1010 {
            let light = f64::from(i) / 1000.0;
            let [code, ..] = of_one(&Transfer::Srgb, [light; 3]);
            let expected = transfer::srgb_encode(light).clamp(0.0, 1.0);
            assert!((code - expected).abs() < 1e-11, "{light}: {code}");
        }
    }
}
