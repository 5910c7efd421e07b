//! From code values of an sRGB screen to its light, in lanes: for views that are made of codes.

use fearless_simd::Simd;

use crate::color::transfer::{CODED_END, CONTRAST, OFFSET, SLOPE};
use crate::display::lanes::{Rgb, each};
use crate::simd::{F64x16, power};

/// The inverse of the sRGB curve ([`crate::color::transfer`]) in each channel; it goes on above 1, and is mirrored
/// below 0.
#[inline(always)]
pub(super) fn light<S: Simd>(simd: S, codes: Rgb<S>) -> Rgb<S> {
    let zero = F64x16::splat(simd, 0.0);
    let coded_end = F64x16::splat(simd, CODED_END);
    each(
        codes,
        #[inline(always)]
        |code| {
            let size = code.abs();
            let curved = power(simd, (size + OFFSET) / (1.0 + OFFSET), CONTRAST);
            let light = size.le(coded_end).select(size / SLOPE, curved);
            code.lt(zero).select(-light, light)
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::transfer::srgb_decode;
    use crate::display::lanes::{Transform, of_one};

    struct Light;

    impl Transform for Light {
        #[inline(always)]
        fn apply<S: Simd>(&self, simd: S, codes: Rgb<S>) -> Rgb<S> {
            light(simd, codes)
        }
    }

    #[test]
    fn codes_are_decoded_by_the_formula() {
        for i in 0..=1200 {
            let code = f64::from(i) / 1000.0;
            let [up, down, _] = of_one(&Light, [code, -code, 0.0]);
            assert!((up - srgb_decode(code)).abs() < 3e-11, "{code}: {up}");
            assert_eq!(down, -up);
        }
    }
}
