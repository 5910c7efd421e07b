//! L2 for rays that leave a surface: what they meet after their start.
//!
//! No distance is compared with a fixed one. A flat shape does not meet the rays that leave it, nor one whose plane
//! the start is on up to its rounding error; of a sphere that a ray leaves the other crossing is known.

use crate::math::DVec3;
use crate::visibility::primitive::Primitive;
use crate::visibility::ray_batch::RayStart;
use crate::visibility::search::Way;

/// Whether a ray that leaves a surface may meet a flat shape at t, a point and any normal of which are given.
#[inline]
pub(super) fn flat(
    start: &RayStart,
    t: f64,
    primitive: Primitive,
    point: DVec3,
    normal: DVec3,
) -> bool {
    let height = normal.dot(start.position - point);
    t > start.t && primitive.0 != start.primitive && height.abs() > start.error * normal.length()
}

/// Where a ray that leaves a surface first meets a sphere, if it does.
///
/// |o + t ω − c|² = r² has the roots t = (−b ± √D)/|ω|² with b = (o − c)·ω; where the start is on the sphere, one of
/// them is there, and the other as far beyond the middle of both.
#[inline]
pub(super) fn sphere(
    way: &Way,
    start: &RayStart,
    primitive: Primitive,
    center: DVec3,
    radius: f64,
) -> Option<f64> {
    let square = way.direction.length_squared();
    let outwards = start.position - center;
    let is_on = primitive.0 == start.primitive || (outwards.length() - radius).abs() <= start.error;
    if is_on {
        let t = start.t - 2.0 * outwards.dot(way.direction) / square;
        return (t > start.t).then_some(t);
    }
    let to_origin = way.origin - center;
    let along = to_origin.dot(way.direction);
    // The squared distance of the line from the center, without the digits that |o − c|² − r² loses.
    let beside = to_origin - way.direction * (along / square);
    let inside = (radius * radius - beside.length_squared()) * square;
    if inside < 0.0 || inside.is_nan() {
        return None;
    }
    let distance = to_origin.length();
    let product = (distance - radius) * (distance + radius);
    // Of the two sums the one that loses no digits; the other root is the product of both over it.
    let sum = -(along + inside.sqrt().copysign(along));
    let (one, other) = (sum / square, product / sum);
    let crossings = [one.min(other), one.max(other)];
    crossings.into_iter().find(|&t| t > start.t)
}
