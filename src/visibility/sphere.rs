//! L2 and L4 for spheres: ‖r(t) − c‖² = R².

use super::bvh::Bounds;
use super::search::Bounded;
use super::{Primitive, ROUNDING, SurfacePoint};
use crate::math::{DVec3, Point, Ray};
use crate::world::Sphere;

/// A sphere with its index in the world.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    center: Point,
    radius: f64,
    index: u32,
}

/// Both parameters at which a line meets a sphere, the nearer first.
struct Crossings {
    first: f64,
    second: f64,
}

impl Ball {
    pub(super) fn new(index: u32, sphere: &Sphere) -> Self {
        Self {
            center: sphere.center,
            radius: sphere.radius,
            index,
        }
    }

    /// The sphere's index in the world.
    pub(super) fn index(&self) -> u32 {
        self.index
    }

    /// L2 with the whole line. The discriminant R² − |oc − (oc·ω)ω|² and the root c/q keep their
    /// precision for a sphere that is small and far away, where b² − 4ac cancels.
    fn crossings(&self, ray: &Ray) -> Option<Crossings> {
        let d = ray.direction;
        let oc = self.center.from(ray.origin);
        let dd = d.dot(d);
        let along = oc.dot(d);
        let across = oc - d * (along / dd);
        let discriminant = self.radius * self.radius - across.dot(across);
        if discriminant < 0.0 {
            return None;
        }
        let root = (dd * discriminant).sqrt();
        let q = if along < 0.0 {
            along - root
        } else {
            along + root
        };
        let distance = oc.length();
        let c = (distance - self.radius) * (distance + self.radius);
        // q is 0 only for a ray that starts on the sphere and touches it there.
        let (a, b) = if q == 0.0 {
            (0.0, 0.0)
        } else {
            (q / dd, c / q)
        };
        Some(Crossings {
            first: if a < b { a } else { b },
            second: if a < b { b } else { a },
        })
    }

    /// L2: where the ray first meets the sphere at t above 0, from outside or inside.
    pub(super) fn intersect(&self, ray: &Ray) -> Option<f64> {
        let Crossings { first, second } = self.crossings(ray)?;
        if first > 0.0 {
            Some(first)
        } else {
            (second > 0.0).then_some(second)
        }
    }

    /// L4: whether the sphere stands strictly between the start of the ray, a light, and `point`
    /// at its end.
    pub(super) fn occludes(&self, ray: &Ray, point: &SurfacePoint) -> bool {
        let outwards = point.position.from(self.center);
        let distance = outwards.length();
        let light_distance = ray.origin.from(self.center).length();
        let rounding = |length: f64| ROUNDING * length;
        // A light on the sphere itself is not occluded by the surface that it is on.
        let at_light = rounding(light_distance + self.radius + ray.origin.0.length());
        let is_own = point.primitive == Primitive::Sphere(self.index);
        let at_point = point.error + rounding(distance + self.radius);
        if is_own || (distance - self.radius).abs() <= at_point {
            // The point is on this sphere, so no root of L2 at the point can be trusted. Where the
            // way to the light leads inwards, it leaves the sphere again unless the light is
            // inside; where it leads outwards, it never comes back.
            let light_is_outside = light_distance - self.radius > at_light;
            return outwards.dot(ray.direction) > 0.0 && light_is_outside;
        }
        let Some(Crossings { first, second }) = self.crossings(ray) else {
            return false;
        };
        let after_light = at_light / ray.direction.length();
        let is_between = |t: f64| t > after_light && t < 1.0;
        is_between(first) || is_between(second)
    }
}

impl Bounded for Ball {
    fn bounds(&self) -> Bounds {
        Bounds {
            min: self.center.0 - DVec3::splat(self.radius),
            max: self.center.0 + DVec3::splat(self.radius),
        }
    }
}
