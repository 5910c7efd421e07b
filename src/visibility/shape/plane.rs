//! L2 and L4 for infinite planes.

mod setup;

use fearless_simd::Simd;

use crate::simd::{F64x16, Mask64x16};
use crate::visibility::primitive::Primitive;
use crate::visibility::question::{NearestHit, Occlusion, SegmentEnds};
use crate::visibility::rays::{ROUNDING, Rays};
use crate::world::Plane;
pub(in crate::visibility) use setup::rasterize_plane;

/// L2: where the rays meet the plane, if they do so at t above 0.
#[inline(always)]
pub(in crate::visibility) fn intersect<S: Simd>(
    simd: S,
    plane: &Plane,
    rays: &Rays<S>,
    nearest: &mut NearestHit<S>,
) {
    let t = met(plane, rays);
    // A ray along the plane gives an infinite or NaN t.
    let found = t.is_positive() & t.lt(F64x16::splat(simd, f64::INFINITY));
    nearest.offer(simd, found, t, Primitive::whole(plane.object));
}

/// L2: where the lines of rays meet the plane.
#[inline(always)]
pub(in crate::visibility) fn met<S: Simd>(plane: &Plane, rays: &Rays<S>) -> F64x16<S> {
    let normal = plane.normal.get();
    let height = -rays.origin.minus(plane.point.0).dot_with(normal);
    height / rays.direction.dot_with(normal)
}

/// L4: whether the plane stands strictly between the start of the ray, a light, and the point at
/// its end: they are on different sides of it, each further from it than its rounding error.
#[inline(always)]
pub(in crate::visibility) fn occlude<S: Simd>(
    simd: S,
    plane: &Plane,
    occlusion: &mut Occlusion<'_, S>,
) {
    let normal = plane.normal.get();
    let light = occlusion.light;
    let to_light = light.from(plane.point);
    let light_height = normal.dot(to_light);
    if light_height.abs() <= ROUNDING * (to_light.length() + light.0.length()) {
        return;
    }
    let points = occlusion.points;
    let to_point = points.position.minus(plane.point.0);
    let point_height = to_point.dot_with(normal);
    let is_own = points
        .primitive
        .eq(Primitive::whole(plane.object).lanes(simd));
    // The sum of the components' magnitudes is at least the length.
    let length = to_point.taxicab();
    // Positive where the point is on the other side than the light.
    let beyond = if light_height > 0.0 {
        -point_height
    } else {
        point_height
    };
    let is_clear = beyond.gt(points.error + length * ROUNDING);
    occlusion.hide(is_clear & !is_own);
}

/// L4: the same for segments that share nothing; which of them the plane stands in the way of.
#[inline(always)]
pub(in crate::visibility) fn is_between<S: Simd>(
    simd: S,
    plane: &Plane,
    start: &SegmentEnds<S>,
    end: &SegmentEnds<S>,
) -> Mask64x16<S> {
    let normal = plane.normal.get();
    let own = Primitive::whole(plane.object).lanes(simd);
    let to_start = start.position.minus(plane.point.0);
    let start_height = to_start.dot_with(normal);
    let length = to_start.dot(to_start).sqrt() + start.position.dot(start.position).sqrt();
    let is_apart = start_height.abs().gt(start.error + length * ROUNDING);
    let to_end = end.position.minus(plane.point.0);
    let end_height = to_end.dot_with(normal);
    let beyond = start_height.is_positive().select(-end_height, end_height);
    let is_clear = beyond.gt(end.error + to_end.taxicab() * ROUNDING);
    is_apart & is_clear & !(start.primitive.eq(own) | end.primitive.eq(own))
}
