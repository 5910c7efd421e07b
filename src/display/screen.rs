//! Screens: how light becomes code values.

use fearless_simd::Simd;

use super::lanes::{Rgb, Transform, each};
use crate::color::transfer::{CONTRAST, LINEAR_END, OFFSET, SLOPE};
use crate::simd::{F64x16, power};

/// From linear light in the screen's primaries, of which 1 is its white, to code values. What is outside of 0 to 1 stays
/// so: above 1 on the curve, below 0 on the line that it begins with. Codes clip it, floats keep it.
pub(super) enum Transfer {
    /// [`crate::color::transfer`]
    Srgb,
}

impl Transform for Transfer {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
        match self {
            Self::Srgb => each(
                rgb,
                #[inline(always)]
                |light| {
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
        for i in -10..=5000 {
            let light = f64::from(i) / 1000.0;
            let [code, ..] = of_one(&Transfer::Srgb, [light; 3]);
            let expected = transfer::srgb_encode(light);
            assert!((code - expected).abs() < 1e-11, "{light}: {code}");
        }
        // What is brighter than all else still has a code.
        for light in [1e30, -1e30] {
            let [code, ..] = of_one(&Transfer::Srgb, [light; 3]);
            let expected = transfer::srgb_encode(light);
            assert!((code / expected - 1.0).abs() < 1e-11, "{light}: {code}");
        }
    }
}
