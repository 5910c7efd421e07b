//! What a shape says of the samples of a packet.

use fearless_simd::Simd;

use crate::simd::{F32x16, Mask32x16};

/// What a shape says of the rays of a packet.
#[derive(Clone, Copy)]
pub(in crate::visibility) struct Fragments<S: Simd> {
    /// Those that may meet it.
    pub(in crate::visibility) may_cover: Mask32x16<S>,
    /// Those that do, certainly.
    pub(in crate::visibility) covered: Mask32x16<S>,
    /// Between which reciprocal depths they do.
    pub(in crate::visibility) least: F32x16<S>,
    pub(in crate::visibility) most: F32x16<S>,
}
