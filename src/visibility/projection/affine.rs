//! Affine functions on a projection.

use fearless_simd::Simd;

use crate::simd::F32x16;

/// A function c₀ + c₁ x + c₂ y on the projection.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct Affine(pub(in crate::visibility) [f32; 3]);

impl Affine {
    #[inline(always)]
    pub(in crate::visibility) fn at<S: Simd>(self, simd: S, [x, y]: [F32x16<S>; 2]) -> F32x16<S> {
        let [c, cx, cy] = self.0;
        let cy = y.times_plus(F32x16::splat(simd, cy), F32x16::splat(simd, c));
        x.times_plus(F32x16::splat(simd, cx), cy)
    }
}
