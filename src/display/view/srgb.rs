//! The picture as it is: radiance 1 is the screen's white, and what exceeds it clips.

use fearless_simd::Simd;

use crate::display::lanes::{Rgb, Transform};

/// What the screen cannot show, it clips.
pub(in crate::display) struct Clip;

impl Transform for Clip {
    #[inline(always)]
    fn apply<S: Simd>(&self, _: S, rgb: Rgb<S>) -> Rgb<S> {
        rgb
    }
}
