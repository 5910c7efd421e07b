//! Sixteen rays and a triangle for each: L2 and L4 in f64, to the bits of [`super::Triangle`]'s.

use fearless_simd::Simd;

use super::{PlaneSetup, met, passes_through};
use crate::simd::{DVec3x16, F64x16, Mask64x16, U64x16};
use crate::visibility::question::SegmentEnds;
use crate::visibility::rays::{ROUNDING, ShearedRays};

/// Sixteen triangles, one for each ray.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct TrianglePerRay<S: Simd> {
    /// From the corners between the two shorter edges on.
    pub(in crate::visibility) corners: [DVec3x16<S>; 3],
    pub(in crate::visibility) primitive: U64x16<S>,
    /// One bit for each ray that has one.
    pub(in crate::visibility) asked: u32,
}

impl<S: Simd> TrianglePerRay<S> {
    #[inline(always)]
    fn passed_through(&self, simd: S, packet: &ShearedRays<S>) -> Mask64x16<S> {
        passes_through(simd, self.corners, packet, self.asked)
            & Mask64x16::from_bits(simd, self.asked)
    }

    /// L2: which rays meet their triangles at t above 0, and where.
    #[inline(always)]
    pub(in crate::visibility) fn intersect(
        &self,
        simd: S,
        packet: &ShearedRays<S>,
    ) -> (Mask64x16<S>, F64x16<S>) {
        let passes = self.passed_through(simd, packet);
        let setup = PlaneSetup::new(self.corners, packet.rays.origin);
        let (is_met, t) = met(&setup, &packet.rays, passes);
        (passes & is_met, t)
    }

    /// L4: which triangles stand strictly between the ends of their segments: these are on different sides of
    /// the plane, each further from it than its rounding error, and the ray passes through. A triangle hides
    /// nothing of itself.
    #[inline(always)]
    pub(in crate::visibility) fn occlude(
        &self,
        simd: S,
        packet: &ShearedRays<S>,
        start: &SegmentEnds<S>,
        end: &SegmentEnds<S>,
    ) -> Mask64x16<S> {
        let passes = self.passed_through(simd, packet);
        let [a, b, c] = self.corners;
        let normal = (b - a).cross(c - a);
        let scale = normal.dot(normal).sqrt();
        let to_start = start.position - a;
        let start_height = normal.dot(to_start);
        let length = to_start.dot(to_start).sqrt() + start.position.dot(start.position).sqrt();
        let start_error = start.error + length * ROUNDING;
        let is_apart = start_height.abs().gt(start_error * scale);
        let to_end = end.position - a;
        let end_height = to_end.dot(normal);
        let beyond = start_height.is_positive().select(-end_height, end_height);
        // The sum of the components' magnitudes is at least the length.
        let is_clear = beyond.gt((end.error + to_end.taxicab() * ROUNDING) * scale);
        let is_own = end.primitive.eq(self.primitive) | start.primitive.eq(self.primitive);
        passes & is_apart & is_clear & !is_own
    }
}
