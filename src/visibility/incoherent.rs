//! Rays and segments that share nothing: each on its own way down the trees.
//!
//! A ray goes through the nodes alone, eight boxes at a time, and sixteen shapes of a leaf are put to it side
//! by side: spheres in f64, triangles in f32 with bounds ([`SingleRay`](super::shape::SingleRay)). What f32 cannot rule out is a
//! candidate, what it is sure of says how far to look. In the end the candidates of all rays of the batch are
//! put to f64, sixteen pairs of a ray and a triangle at a time, by the formulas of the packets. So a ray meets what it
//! meets in a packet, at the same t to the bit, and ties go by the order of the scene.

mod batch;
mod candidates;
mod free;
mod nearest;

use fearless_simd::Simd;

use super::Visibility;
use super::batch::PACKETS;
#[cfg(test)]
pub(crate) use batch::EndBatch;
pub(crate) use batch::{Hits, RayBatch, SegmentBatch};
pub(crate) use candidates::Candidates;

impl Visibility<'_> {
    /// L2: what each ray of a batch meets first, whatever they share.
    #[inline(never)]
    pub(crate) fn nearest<S: Simd>(
        &self,
        simd: S,
        rays: &RayBatch,
        space: &mut Candidates,
        hits: &mut Hits,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.shapes.nearest_all(simd, rays, space, hits),
        );
    }

    /// L4: one bit for each segment of a batch, packet by packet, that no shape stands strictly between the ends
    /// of, whatever they share.
    #[inline(never)]
    pub(crate) fn free<S: Simd>(
        &self,
        simd: S,
        segments: &SegmentBatch,
        space: &mut Candidates,
    ) -> [u32; PACKETS] {
        simd.vectorize(
            #[inline(always)]
            || self.shapes.free_all(simd, segments, space),
        )
    }
}
