//! Segments and hits of a batch, number by number in columns.

use fearless_simd::Simd;

use super::candidates::{Pair, gathered};
use crate::math::DVec3;
use crate::simd::{DVec3x16, F64x16, LANES, U64x16, ones};
use crate::visibility::batch::{BATCH, Column, PACKETS, columns, vector};
use crate::visibility::primitive::Primitive;
use crate::visibility::question::{End, SegmentEnds};
use crate::visibility::ray_batch::IncoherentRays;
use crate::visibility::search::Way;

/// What rays meet first.
#[derive(Clone, Debug)]
pub(crate) struct Hits {
    /// Where, at t above 0; infinite where there is nothing.
    pub(crate) t: Column,
    /// The object, and of a mesh the triangle, in the order of the scene; `u64::MAX` where there is nothing.
    pub(crate) primitive: [u64; BATCH],
}

/// Ends of segments.
#[derive(Clone, Debug)]
pub(crate) struct EndBatch {
    pub(crate) position: [Column; 3],
    /// A bound on the rounding error of each, 0 for a point that is where it is by definition, such as a light.
    pub(crate) error: Column,
    /// What each is on, `u64::MAX` for nothing: a flat shape does not hide its own points, a sphere only those
    /// of its far side.
    pub(crate) primitive: [u64; BATCH],
}

/// Segments, each with ends of its own.
#[derive(Clone, Debug, Default)]
pub(crate) struct IncoherentSegments {
    pub(crate) start: EndBatch,
    pub(crate) end: EndBatch,
    pub(crate) count: usize,
}

impl Default for Hits {
    fn default() -> Self {
        Self {
            t: Column([f64::INFINITY; BATCH]),
            primitive: [u64::MAX; BATCH],
        }
    }
}

impl Default for EndBatch {
    fn default() -> Self {
        Self {
            position: [Column::ZERO; 3],
            error: Column::ZERO,
            primitive: [u64::MAX; BATCH],
        }
    }
}

impl IncoherentRays {
    #[inline(always)]
    pub(super) fn way(&self, ray: usize, limit: f64) -> Way {
        let [origin, direction] = self.ray(ray);
        Way {
            origin,
            direction,
            error: 0.0,
            limit,
        }
    }
}

impl IncoherentSegments {
    #[inline(always)]
    pub(super) fn ends(&self, segment: usize) -> [End; 2] {
        [self.start.end(segment), self.end.end(segment)]
    }

    /// A box around the segments of a packet with a bit.
    #[inline(always)]
    pub(super) fn bounds(&self, packet: usize, bits: u32) -> [DVec3; 2] {
        let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for lane in ones(bits) {
            let [start, end] = self.ends(packet * LANES + lane);
            least = least.min(start.position).min(end.position);
            most = most.max(start.position).max(end.position);
        }
        [least, most]
    }

    /// The way of a segment that is still free.
    #[inline(always)]
    pub(super) fn way(&self, segment: usize, free: &[u32; PACKETS]) -> Option<Way> {
        let is_free = free[segment / LANES] >> (segment % LANES) & 1 == 1;
        is_free.then(
            #[inline(always)]
            || {
                let [start, end] = self.ends(segment);
                Way {
                    origin: start.position,
                    direction: end.position - start.position,
                    error: start.error.max(end.error),
                    limit: 1.0,
                }
            },
        )
    }
}

impl EndBatch {
    #[inline(always)]
    pub(super) fn end(&self, segment: usize) -> End {
        End {
            position: vector(&self.position, segment),
            error: self.error[segment],
            primitive: Primitive(self.primitive[segment]),
        }
    }

    #[inline(always)]
    pub(super) fn packet<S: Simd>(&self, simd: S, packet: usize) -> SegmentEnds<S> {
        let first = packet * LANES;
        SegmentEnds {
            position: DVec3x16::load(simd, columns(&self.position, packet)),
            error: F64x16::load(simd, &self.error[first..]),
            primitive: U64x16::load(simd, &self.primitive[first..]),
        }
    }

    #[inline(always)]
    pub(super) fn gathered<S: Simd>(&self, simd: S, pairs: &[Pair]) -> SegmentEnds<S> {
        let (mut error, mut primitive) = ([0.0; LANES], [0; LANES]);
        for (lane, pair) in pairs.iter().enumerate() {
            error[lane] = self.error[pair.ray as usize];
            primitive[lane] = self.primitive[pair.ray as usize];
        }
        SegmentEnds {
            position: gathered(simd, &self.position, pairs),
            error: F64x16::load(simd, &error),
            primitive: U64x16::load(simd, &primitive),
        }
    }

    /// Sets one end.
    pub(crate) fn set(&mut self, segment: usize, position: DVec3, error: f64, primitive: u64) {
        for axis in 0..3 {
            self.position[axis][segment] = position[axis];
        }
        self.error[segment] = error;
        self.primitive[segment] = primitive;
    }
}

impl Hits {
    /// Takes a hit if it is nearer; at the same distance what is written first in the scene.
    #[inline(always)]
    pub(super) fn offer(&mut self, ray: usize, t: f64, primitive: Primitive) {
        let known = self.t[ray];
        if t < known || t == known && primitive.0 < self.primitive[ray] {
            self.t[ray] = t;
            self.primitive[ray] = primitive.0;
        }
    }
}
