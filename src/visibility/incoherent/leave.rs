//! L2 for rays that leave a surface: what they meet after their start.
//!
//! No distance is compared with a fixed one. A flat shape does not meet the rays that leave it, nor one whose plane
//! the start is on up to its rounding error; of a sphere that a ray leaves the other crossing is known.

use crate::math::DVec3;
use crate::visibility::primitive::Primitive;
use crate::visibility::ray_batch::RayStart;
use crate::visibility::search::Way;
use crate::visibility::shape::single_crossings;

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
/// Where the start is on the sphere, one of the crossings is there, and the other as far beyond the middle of both. All
/// others are those of [`shape`](crate::visibility::shape), to the bit.
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
    let crossings = single_crossings([way.origin, way.direction], center, radius)?;
    crossings.into_iter().find(|&t| t > start.t)
}
