//! L2 and L4 for infinite planes.

use super::{ROUNDING, SurfacePoint};
use crate::math::Ray;
use crate::world::Plane;

/// L2: where the ray meets the plane, if it does so at t above 0.
pub(super) fn intersect(plane: &Plane, ray: &Ray) -> Option<f64> {
    let normal = plane.normal.get();
    let t = normal.dot(plane.point.from(ray.origin)) / normal.dot(ray.direction);
    // A ray along the plane gives an infinite or NaN t.
    (t > 0.0 && t.is_finite()).then_some(t)
}

/// L4: whether the plane stands strictly between the start of the ray, a light, and `point` at
/// its end: they are on different sides of it, each further from it than its rounding error.
pub(super) fn occludes(plane: &Plane, ray: &Ray, point: &SurfacePoint) -> bool {
    let normal = plane.normal.get();
    let to_point = point.position.from(plane.point);
    let to_light = ray.origin.from(plane.point);
    let point_height = normal.dot(to_point);
    let light_height = normal.dot(to_light);
    let rounding = |length: f64| ROUNDING * length;
    (point_height > 0.0) != (light_height > 0.0)
        && point_height.abs() > point.error + rounding(to_point.length())
        && light_height.abs() > rounding(to_light.length() + ray.origin.0.length())
}
