//! The numbers of the file as code values, without a curve: for data, such as normals or masks.

use fearless_simd::Simd;

use crate::display::coded;
use crate::display::lanes::{Rgb, Transform};

/// Code values as they are, 0 to 1 of which the screen shows. They are decoded here by the curve by which an sRGB
/// screen codes again, so that its codes are the numbers to 1e-9.
pub(in crate::display) struct Raw;

impl Transform for Raw {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
        coded::light(simd, rgb)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::transfer;
    use crate::display::lanes::of_one;

    #[test]
    fn codes_are_the_numbers() {
        for i in 0..=1000 {
            let code = f64::from(i) / 1000.0;
            let [light, ..] = of_one(&Raw, [code; 3]);
            assert!(
                (transfer::srgb_encode(light) - code).abs() < 1e-11,
                "{code}"
            );
        }
        let [negative, ..] = of_one(&Raw, [-0.5; 3]);
        assert!((negative + transfer::srgb_decode(0.5)).abs() < 1e-11);
    }
}
