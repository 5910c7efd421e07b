//! L2 for rays that leave a surface: what they meet after their start.
//!
//! No distance is compared with a fixed one. A flat shape does not meet the rays that leave it, nor one whose plane
//! the start is on up to its rounding error. For spheres see their own module.

use crate::math::DVec3;
use crate::visibility::primitive::Primitive;
use crate::visibility::ray_batch::RayStart;

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
