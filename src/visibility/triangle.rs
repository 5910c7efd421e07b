//! L2 and L4 for triangles, without cracks between neighbors.

use super::bvh::Bounds;
use super::search::Bounded;
use super::{Primitive, ROUNDING, SurfacePoint};
use crate::math::{DVec3, Ray};
use crate::world::geometry::{area_vector, from_shorter_edges};

/// A triangle with its index in the world, its corners side by side in memory.
#[derive(Clone, Copy, Debug)]
pub(super) struct Facet {
    /// In the cyclic order of the world, from the corner between the two shorter edges on.
    vertices: [DVec3; 3],
    index: u32,
}

/// A ray, arranged for many triangles: its largest axis z, and the shear that turns it into that
/// axis (Woop, Benthin & Wald 2013, "Watertight Ray/Triangle Intersection").
///
/// Sheared and seen along z, a triangle is flat, and the ray passes through it where the origin is
/// inside. Each corner is projected on its own, whatever triangle it is part of. The edge function
/// xᵢ yⱼ − xⱼ yᵢ compares two products, and rounding each of them cannot turn their order around:
/// it has the right sign or is 0, which counts as inside. So no ray slips between triangles that
/// share an edge or a corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShearedRay {
    ray: Ray,
    axis: Axis,
    /// The other two components of the direction over that of the axis, in cyclic order.
    shear: [f64; 2],
}

/// The axis along which a ray is longest.
#[derive(Clone, Copy, Debug)]
enum Axis {
    X,
    Y,
    Z,
}

/// Barycentric coordinates of the point where a ray that hits the triangle does so.
pub(super) fn weights(vertices: [DVec3; 3], ray: &Ray) -> [f64; 3] {
    let functions = ShearedRay::new(*ray).edge_functions(vertices);
    let sum: f64 = functions.iter().sum();
    functions.map(|function| function / sum)
}

impl ShearedRay {
    pub(super) fn new(ray: Ray) -> Self {
        let d = ray.direction;
        let size = d.abs();
        let (axis, shear) = if size.x >= size.y && size.x >= size.z {
            (Axis::X, [d.y / d.x, d.z / d.x])
        } else if size.y >= size.z {
            (Axis::Y, [d.z / d.y, d.x / d.y])
        } else {
            (Axis::Z, [d.x / d.z, d.y / d.z])
        };
        Self { ray, axis, shear }
    }

    /// The edge functions of the triangle around the ray: twice the areas that the ray makes with
    /// its edges. The i-th belongs to the edge opposite of the i-th corner.
    #[inline(always)]
    fn edge_functions(&self, vertices: [DVec3; 3]) -> [f64; 3] {
        match self.axis {
            Axis::X => self.projected(vertices, |v| [v.y, v.z, v.x]),
            Axis::Y => self.projected(vertices, |v| [v.z, v.x, v.y]),
            Axis::Z => self.projected(vertices, |v| [v.x, v.y, v.z]),
        }
    }

    /// The edge functions, with `turned` to bring the ray's axis to the end.
    #[inline(always)]
    fn projected(&self, [a, b, c]: [DVec3; 3], turned: impl Fn(DVec3) -> [f64; 3]) -> [f64; 3] {
        let project = |vertex: DVec3| {
            let [x, y, z] = turned(vertex - self.ray.origin.0);
            [x - self.shear[0] * z, y - self.shear[1] * z]
        };
        let edge = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - q[0] * p[1];
        let (a, b, c) = (project(a), project(b), project(c));
        [edge(b, c), edge(c, a), edge(a, b)]
    }

    /// Whether the ray's line passes through the triangle: all edge functions have one sign.
    #[inline(always)]
    fn passes_through(&self, vertices: [DVec3; 3]) -> bool {
        let [u, v, w] = self.edge_functions(vertices);
        (u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0)
    }
}

impl Axis {
    /// The component of a vector along this axis.
    fn of(self, vector: DVec3) -> f64 {
        match self {
            Self::X => vector.x,
            Self::Y => vector.y,
            Self::Z => vector.z,
        }
    }
}

impl Facet {
    pub(super) fn new(index: u32, vertices: [DVec3; 3]) -> Self {
        Self {
            vertices: from_shorter_edges(vertices),
            index,
        }
    }

    /// The triangle's index in the world.
    pub(super) fn index(&self) -> u32 {
        self.index
    }

    /// L2: where the ray meets the triangle at t above 0.
    pub(super) fn intersect(&self, sheared: &ShearedRay) -> Option<f64> {
        if !sheared.passes_through(self.vertices) {
            return None;
        }
        let ray = &sheared.ray;
        let normal = area_vector(self.vertices);
        let speed = normal.dot(ray.direction);
        // Seen edge-on, as far as can be told, a triangle has no extent.
        let tilt = normal.length_squared() * ray.direction.length_squared();
        if speed * speed <= ROUNDING * ROUNDING * tilt {
            return None;
        }
        let t = normal.dot(self.vertices[0] - ray.origin.0) / speed;
        // The hit is between the corners, also where the normal of a sliver is not worth much.
        let heights = self
            .vertices
            .map(|vertex| sheared.axis.of(vertex - ray.origin.0) / sheared.axis.of(ray.direction));
        let nearest = heights[0].min(heights[1]).min(heights[2]);
        let farthest = heights[0].max(heights[1]).max(heights[2]);
        Some(t.max(nearest).min(farthest)).filter(|&t| t > 0.0)
    }

    /// L4: whether the triangle stands strictly between the start of the ray, a light, and
    /// `point` at its end: they are on different sides of its plane, each further from it than
    /// its rounding error, and the ray passes through it. A triangle does not occlude itself.
    pub(super) fn occludes(&self, sheared: &ShearedRay, point: &SurfacePoint) -> bool {
        if point.primitive == Primitive::Triangle(self.index)
            || !sheared.passes_through(self.vertices)
        {
            return false;
        }
        let normal = area_vector(self.vertices);
        let light = sheared.ray.origin.0;
        let to_point = point.position.0 - self.vertices[0];
        let to_light = light - self.vertices[0];
        let point_height = normal.dot(to_point);
        let light_height = normal.dot(to_light);
        let rounding = |length: f64| ROUNDING * length;
        let scale = normal.length();
        (point_height > 0.0) != (light_height > 0.0)
            && point_height.abs() > (point.error + rounding(to_point.length())) * scale
            && light_height.abs() > rounding(to_light.length() + light.length()) * scale
    }
}

impl Bounded for Facet {
    fn bounds(&self) -> Bounds {
        let [a, b, c] = self.vertices;
        Bounds {
            min: a.min(b).min(c),
            max: a.max(b).max(c),
        }
    }
}
