//! What a packet of rays asks, and what is known of the answer so far.

use fearless_simd::Simd;

use super::primitive::Primitive;
use crate::math::{DVec3, Point};
use crate::simd::{DVec3x16, F64x16, Mask64x16, U64x16};

/// The nearest hits so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearestHit<S: Simd> {
    /// The rays that ask.
    pub(super) asked: Mask64x16<S>,
    pub(super) asked_bits: u32,
    /// t; infinite where nothing is hit.
    pub(super) t: F64x16<S>,
    pub(super) primitive: U64x16<S>,
}

impl<S: Simd> NearestHit<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, asked_bits: u32) -> Self {
        Self {
            asked: Mask64x16::from_bits(simd, asked_bits),
            asked_bits,
            t: F64x16::splat(simd, f64::INFINITY),
            primitive: U64x16::splat(simd, u64::MAX),
        }
    }

    /// Takes the hits that are nearer; at the same distance what is written first in the scene.
    #[inline(always)]
    pub(super) fn offer(
        &mut self,
        simd: S,
        found: Mask64x16<S>,
        t: F64x16<S>,
        primitive: Primitive,
    ) {
        let primitive = primitive.lanes(simd);
        let ties = t.eq(self.t) & primitive.lt(self.primitive);
        let is_nearer = found & self.asked & (t.lt(self.t) | ties);
        self.t = is_nearer.select(t, self.t);
        self.primitive = is_nearer.select_ids(primitive, self.primitive);
    }
}

/// Points of surfaces that ask for a light.
#[derive(Clone, Copy, Debug)]
pub(super) struct SegmentEnds<S: Simd> {
    pub(super) position: DVec3x16<S>,
    pub(super) error: F64x16<S>,
    pub(super) primitive: U64x16<S>,
}

/// One end of a segment.
#[derive(Clone, Copy, Debug)]
pub(super) struct End {
    pub(super) position: DVec3,
    /// A bound on its rounding error.
    pub(super) error: f64,
    /// What it is on.
    pub(super) primitive: Primitive,
}

/// Which points a light reaches, so far.
#[derive(Debug)]
pub(super) struct Occlusion<'p, S: Simd> {
    pub(super) light: Point,
    pub(super) points: &'p SegmentEnds<S>,
    /// Those that nothing is known to hide.
    pub(super) asked: Mask64x16<S>,
    pub(super) asked_bits: u32,
}

impl<S: Simd> Occlusion<'_, S> {
    #[inline(always)]
    pub(super) fn hide(&mut self, hidden: Mask64x16<S>) {
        self.asked = self.asked & !hidden;
        self.asked_bits = self.asked.to_bits();
    }
}
