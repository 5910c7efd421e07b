//! Rays and segments that share nothing: each on its own way down the trees.
//!
//! A ray goes through the nodes alone, eight boxes at a time, and sixteen shapes of a leaf are put to it side
//! by side: spheres in f64, triangles in f32 with bounds ([`SingleRay`](super::shape::SingleRay)). What f32 cannot rule out is a
//! candidate, what it is sure of says how far to look. In the end the candidates of all rays of the batch are
//! put to f64, sixteen pairs of a ray and a triangle at a time, by the formulas of the packets. So a ray meets what it
//! meets in a packet, at the same t to the bit, and ties go by the order of the scene.
//!
//! Where the rays of a packet go much the same way, as those of a curved mirror do, they go together
//! ([`along_in_packets`](super::search::Search::along_in_packets)), and a leaf's shapes are put to all of them at once in f64.

mod batch;
mod candidates;
mod free;
mod leave;
mod nearest;

use fearless_simd::Simd;

use super::batch::{BATCH, PACKETS, first_lanes, vector};
use super::points::{Known, Points};
use super::projection::NOTHING;
use super::question::NearestHit;
use super::ray_batch::IncoherentRays;
use super::{Visibility, Workspace};
use crate::math::Point;
use crate::simd::{F64x16, LANES, U64x16, ones};
#[cfg(test)]
pub(crate) use batch::EndBatch;
pub(crate) use batch::{Hits, IncoherentSegments};
pub(super) use candidates::Candidates;

/// What a thread needs for batches that share nothing, to be used again and again.
#[derive(Debug, Default)]
pub(super) struct IncoherentSpace {
    candidates: Candidates,
    hits: Box<Hits>,
    segments: Box<IncoherentSegments>,
}

impl Visibility<'_> {
    /// L2: the points that rays meet first that share nothing.
    #[inline(never)]
    pub(super) fn nearest_incoherent<S: Simd>(
        &self,
        simd: S,
        rays: &IncoherentRays,
        space: &mut Workspace,
        points: &mut Points,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let IncoherentSpace {
                    candidates, hits, ..
                } = &mut space.incoherent;
                self.shapes.nearest_all(simd, rays, candidates, hits);
                points.begin(self.is_smooth);
                for packet in 0..PACKETS {
                    let asked = first_lanes(rays.count(), packet);
                    if asked == 0 {
                        points.hit[packet] = 0;
                        continue;
                    }
                    let first = packet * LANES;
                    let rays = rays.packet(simd, packet);
                    let nearest = NearestHit {
                        t: F64x16::load(simd, &hits.t[first..]),
                        primitive: U64x16::load(simd, &hits.primitive[first..]),
                        ..NearestHit::new(simd, asked)
                    };
                    let known = Known {
                        slots: &[NOTHING; LANES],
                        met: 0,
                        last: &mut None,
                    };
                    points.fill(simd, &self.shapes, packet, &rays, &nearest, known);
                }
                points.end(simd);
            },
        );
    }

    /// L2 alone: at what t each ray of a batch that shares nothing meets what first.
    #[inline(never)]
    pub(crate) fn hits<'s, S: Simd>(
        &self,
        simd: S,
        rays: &IncoherentRays,
        space: &'s mut Workspace,
    ) -> &'s Hits {
        let IncoherentSpace {
            candidates, hits, ..
        } = &mut space.incoherent;
        simd.vectorize(
            #[inline(always)]
            || self.shapes.nearest_all(simd, rays, candidates, hits),
        );
        hits
    }

    /// L4: one bit for each segment of a batch, packet by packet, that no shape stands strictly between the ends
    /// of, whatever they share.
    #[inline(never)]
    pub(super) fn free_incoherent<S: Simd>(
        &self,
        simd: S,
        segments: &IncoherentSegments,
        space: &mut Workspace,
    ) -> [u32; PACKETS] {
        let candidates = &mut space.incoherent.candidates;
        simd.vectorize(
            #[inline(always)]
            || self.shapes.free_all(simd, segments, candidates),
        )
    }

    /// L4 for points with a bit and a light that is very far away: the segments start at the points, beside which
    /// the shapes are known to the last digits. As seen from the light they are not.
    #[inline(never)]
    pub(super) fn free_to_far_point<S: Simd>(
        &self,
        simd: S,
        light: Point,
        points: &Points,
        facing: &[u32; PACKETS],
        space: &mut Workspace,
    ) -> [u32; PACKETS] {
        let starts = points.starts();
        let mut segments = std::mem::take(&mut space.incoherent.segments);
        let mut slots = [0; BATCH];
        segments.count = 0;
        for (packet, &bits) in facing.iter().enumerate() {
            for lane in ones(bits) {
                let slot = packet * LANES + lane;
                let start = vector(starts.position, slot);
                let primitive = points.primitive[slot];
                let segment = segments.count;
                segments
                    .start
                    .set(segment, start, starts.error[slot], primitive);
                segments.end.set(segment, light.0, 0.0, u64::MAX);
                slots[segment] = slot;
                segments.count += 1;
            }
        }
        let free = self.free_incoherent(simd, &segments, space);
        let mut lit = [0; PACKETS];
        for (segment, &slot) in slots[..segments.count].iter().enumerate() {
            let is_free = free[segment / LANES] >> (segment % LANES) & 1;
            lit[slot / LANES] |= is_free << (slot % LANES);
        }
        space.incoherent.segments = segments;
        lit
    }
}
