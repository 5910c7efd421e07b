//! The point of a surface that a primary ray hits.

use super::{Hit, ROUNDING, triangle};
use crate::math::{DVec3, Direction, Normal, Point, Ray};
use crate::world::World;
use crate::world::geometry::{from_shorter_edges, triangle_normal};

/// One shape that a ray can hit, an index into the world's array of its kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Primitive {
    /// An index into [`World::spheres`].
    Sphere(u32),
    /// An index into [`World::planes`].
    Plane(u32),
    /// An index into [`World::triangles`].
    Triangle(u32),
}

/// p of the lecture, with all that L3 to L8 need there.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePoint {
    /// p, relative to the world's anchor.
    pub position: Point,
    /// A bound on the rounding error of `position`, in scene units: what is nearer to it than
    /// this may be the surface itself.
    pub error: f64,
    /// A point of the plane that touches the surface at `position`: for flat shapes one that is
    /// known exactly, for others `position` itself.
    tangent: Point,
    /// ω_o: from the point to the viewer.
    pub to_viewer: Direction,
    /// The normal of the surface, turned towards the viewer.
    pub geometric_normal: Normal,
    /// n of L5 to L7: the interpolated normal of a smooth mesh, on the viewer's side of the
    /// surface; elsewhere the geometric normal.
    pub shading_normal: Normal,
    /// What the ray hit.
    pub primitive: Primitive,
    /// An index into [`World::objects`].
    pub object: u32,
}

impl SurfacePoint {
    pub(super) fn new(world: &World, ray: &Ray, hit: &Hit) -> Self {
        let position = ray.at(hit.t);
        let to_viewer = Direction::new(-ray.direction).expect("a ray has a direction");
        let towards_viewer = |normal: Normal| {
            if normal.get().dot(to_viewer.get()) < 0.0 {
                normal.flipped()
            } else {
                normal
            }
        };
        let (object, normal, interpolated, tangent) = match hit.primitive {
            Primitive::Sphere(index) => {
                let sphere = &world.spheres()[index as usize];
                let normal = Normal::new(position.from(sphere.center));
                // A sphere smaller than the rounding of its place faces the viewer.
                let normal = normal.unwrap_or(Normal::from(to_viewer));
                (sphere.object, normal, None, position)
            }
            Primitive::Plane(index) => {
                let plane = &world.planes()[index as usize];
                (plane.object, plane.normal, None, plane.point)
            }
            Primitive::Triangle(index) => {
                let mesh = world.triangles().mesh(index);
                let vertices = world.triangles().vertices(index);
                let normal = triangle_normal(vertices).expect("no triangle is degenerate");
                let interpolated = mesh
                    .normals
                    .is_some()
                    .then(|| mesh.shading_normal(index, triangle::weights(vertices, ray)));
                let corner = Point(from_shorter_edges(vertices)[0]);
                (mesh.object, normal, interpolated.flatten(), corner)
            }
        };
        let geometric_normal = towards_viewer(normal);
        let shading_normal = interpolated.map_or(geometric_normal, |normal| {
            if normal.get().dot(geometric_normal.get()) < 0.0 {
                normal.flipped()
            } else {
                normal
            }
        });
        // t comes from the way to the shape's own reference, and is rounded with it; then one
        // rounding for the product and one for the sum.
        let magnitude = ray.origin.0.length()
            + (ray.direction * hit.t).length()
            + tangent.from(ray.origin).length();
        Self {
            position,
            tangent,
            error: ROUNDING * magnitude,
            to_viewer,
            geometric_normal,
            shading_normal,
            primitive: hit.primitive,
            object,
        }
    }

    /// Whether a light is above the surface: on the viewer's side of the tangent plane, further
    /// from it than rounding errors. A light in the very plane of a floor is not above it.
    pub fn faces(&self, light: Point) -> bool {
        let to_light = light.from(self.tangent);
        // The largest component stands for the length, which is at most √3 times as long.
        let length = |vector: DVec3| vector.abs().max_element();
        let rounding = 2.0 * ROUNDING * (length(to_light) + length(light.0));
        let known_to = if self.tangent == self.position {
            self.error
        } else {
            0.0
        };
        self.geometric_normal.get().dot(to_light) > rounding + known_to
    }

    /// Whether a light is at the point itself (d = 0), as far as can be told.
    pub fn is_at(&self, light: Point) -> bool {
        light.from(self.position).length_squared() <= self.error * self.error
    }
}
