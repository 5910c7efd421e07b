//! L2 and L4 for triangles, without cracks between neighbors.

use super::bvh::Bounds;
use super::search::Bounded;
use super::{Primitive, SurfacePoint};
use crate::math::{DVec3, Normal, Ray};

/// A triangle with its index in the world, its corners side by side in memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct FacetedTriangle {
    vertices: [DVec3; 3],
    index: u32,
}

/// The normal of a triangle whose corners are counter-clockwise; `None` where it has no area.
pub(super) fn normal(vertices: [DVec3; 3]) -> Option<Normal> {
    Normal::new(area_vector(vertices))
}

/// Normal times twice the area.
fn area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// The edge functions of a ray: how far it passes on the inner side of each edge, as volumes
/// d · (vᵢ × vⱼ) with the corners seen from the ray's origin. The i-th belongs to the edge
/// opposite of the i-th corner.
///
/// a × b = −(b × a) holds to the bit in floating point without fused operations, so two triangles
/// that share an edge agree on which side of it the ray passes: no ray slips between them.
fn edge_functions(vertices: [DVec3; 3], ray: &Ray) -> [f64; 3] {
    let d = ray.direction;
    let [a, b, c] = vertices.map(|vertex| vertex - ray.origin.0);
    [d.dot(b.cross(c)), d.dot(c.cross(a)), d.dot(a.cross(b))]
}

/// Whether the ray's line passes through the triangle: on the same side of all edges.
fn passes_through([u, v, w]: [f64; 3]) -> bool {
    (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0)
}

/// Barycentric coordinates of the point where a ray that hits the triangle does so.
pub(super) fn weights(vertices: [DVec3; 3], ray: &Ray) -> [f64; 3] {
    let volumes = edge_functions(vertices, ray);
    let sum: f64 = volumes.iter().sum();
    volumes.map(|volume| volume / sum)
}

impl FacetedTriangle {
    pub(super) fn new(index: u32, vertices: [DVec3; 3]) -> Self {
        Self { vertices, index }
    }

    /// The triangle's index in the world.
    pub(super) fn index(&self) -> u32 {
        self.index
    }

    /// L2: where the ray meets the triangle at t above 0.
    pub(super) fn intersect(&self, ray: &Ray) -> Option<f64> {
        if !passes_through(edge_functions(self.vertices, ray)) {
            return None;
        }
        let normal = area_vector(self.vertices);
        let t = normal.dot(self.vertices[0] - ray.origin.0) / normal.dot(ray.direction);
        // A ray in the triangle's plane gives an infinite or NaN t: seen edge-on it has no extent.
        (t > 0.0 && t.is_finite()).then_some(t)
    }

    /// L4: whether the triangle stands strictly between the start of the ray, a light, and
    /// `point` at its end: they are on different sides of its plane, each further from it than
    /// its rounding error, and the ray passes through it. A triangle does not occlude itself.
    pub(super) fn occludes(&self, ray: &Ray, point: &SurfacePoint) -> bool {
        if point.primitive == Primitive::Triangle(self.index)
            || !passes_through(edge_functions(self.vertices, ray))
        {
            return false;
        }
        let normal = area_vector(self.vertices);
        let to_point = point.position.0 - self.vertices[0];
        let to_light = ray.origin.0 - self.vertices[0];
        let point_height = normal.dot(to_point);
        let light_height = normal.dot(to_light);
        let rounding = |length: f64| 8.0 * f64::EPSILON * length;
        let scale = normal.length();
        (point_height > 0.0) != (light_height > 0.0)
            && point_height.abs() > (point.error + rounding(to_point.length())) * scale
            && light_height.abs() > rounding(to_light.length() + ray.origin.0.length()) * scale
    }
}

impl Bounded for FacetedTriangle {
    fn bounds(&self) -> Bounds {
        let [a, b, c] = self.vertices;
        Bounds {
            min: a.min(b).min(c),
            max: a.max(b).max(c),
        }
    }
}
