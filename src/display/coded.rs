//! sRGB code values as light, for views that end in code values.

use fearless_simd::Simd;

use super::lanes::{Rgb, each};
use crate::color::transfer::{CONTRAST, LINEAR_END, OFFSET, SLOPE};
use crate::simd::{F64x16, power};

/// The light of code values by the sRGB curve, such that the curve gives them back to 1e-9; continued on its line below
/// 0, and on its curve above 1.
#[inline(always)]
pub(super) fn light<S: Simd>(simd: S, rgb: Rgb<S>) -> Rgb<S> {
    each(
        rgb,
        #[inline(always)]
        |code| {
            // The two pieces overlap by 3e-8: each code takes the one that leads back to it.
            let is_linear = code.le(F64x16::splat(simd, SLOPE * LINEAR_END));
            let curved = power(simd, (code + OFFSET) / (1.0 + OFFSET), CONTRAST);
            is_linear.select(code / SLOPE, curved)
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::transfer;
    use crate::display::lanes::{Transform, of_one};

    struct Light;

    impl Transform for Light {
        #[inline(always)]
        fn apply<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
            light(simd, rgb)
        }
    }

    #[test]
    fn the_curve_gives_the_codes_back() {
        // Where the pieces meet, in steps finer than what they overlap by, and everywhere.
        let meeting = (-50..50).map(|i| SLOPE * LINEAR_END + f64::from(i) * 1e-9);
        let all = (0..=100_000).map(|i| f64::from(i) / 100_000.0);
        for code in meeting.chain(all) {
            let [positive, negative, _] = of_one(&Light, [code, -code, 0.0]);
            let back = transfer::srgb_encode(positive);
            assert!((back - code).abs() < 1e-11, "{code}: {back}");
            assert!((negative + code / SLOPE).abs() < 1e-15, "{positive}");
        }
    }

    #[test]
    fn published_values() {
        let [half, white, _] = of_one(&Light, [0.5, 1.0, 0.0]);
        assert!((half - 0.214_041_140_5).abs() < 1e-10);
        assert!((white - 1.0).abs() < 1e-15);
    }
}
