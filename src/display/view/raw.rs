//! The numbers of the file as code values, without a curve: for data, such as normals or masks.

use fearless_simd::Simd;

use crate::display::lanes::{Rgb, Transform};

/// Code values as they are, 0 to 1 of which the screen shows. No transfer comes after it.
pub(in crate::display) struct Raw;

impl Transform for Raw {
    #[inline(always)]
    fn apply<S: Simd>(&self, _: S, rgb: Rgb<S>) -> Rgb<S> {
        rgb
    }
}
