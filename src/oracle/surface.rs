//! The scene's surfaces as plain geometry, and L2: where a ray meets them.
//!
//! Rectangles and disks are those of lights; objects are made of the other shapes.

use super::camera::Ray;
use super::vector::{
    Vector, WideVector, add, cross, dot, length, multiply, narrowed, scale, subtract, unit, widened,
};
use super::wide::{Real, Wide};
use crate::scene::{MeshFile, Object, ShadowTerminator};

/// A sphere, a plane, one triangle, or what a light is made of, in the oracle's coordinates.
#[derive(Clone, Debug)]
pub(super) struct Surface {
    /// The index of its object in the scene; those of lights that are seen come after all others.
    pub(super) object: usize,
    /// The index of the light that it is.
    pub(super) light: Option<usize>,
    /// For a triangle of a mesh, its index in the mesh file.
    pub(super) triangle: Option<usize>,
    /// Where its shadow rays start, if it has vertex normals.
    pub(super) shadow_terminator: ShadowTerminator,
    pub(super) shape: Shape,
}

#[derive(Clone, Debug)]
pub(super) enum Shape {
    Sphere {
        center: WideVector,
        radius: Wide,
    },
    Plane {
        point: WideVector,
        /// Of unit length.
        normal: WideVector,
    },
    Rectangle {
        center: WideVector,
        /// Of unit length.
        normal: WideVector,
        /// From the center to the middles of two sides, square to each other.
        halves: [WideVector; 2],
    },
    Disk {
        center: WideVector,
        /// Of unit length.
        normal: WideVector,
        radius: Wide,
    },
    Triangle {
        /// In an order of their own: see [`Shape::triangle`].
        vertices: [WideVector; 3],
        /// The geometric normal, of unit length.
        normal: WideVector,
        /// Unit normals at the vertices of a smooth mesh.
        vertex_normals: Option<[WideVector; 3]>,
    },
}

impl Surface {
    /// The surfaces of one object, in the order of the file, with `reference` as the origin.
    ///
    /// A triangle without an area is left out, and so is a plane without a normal.
    pub(super) fn all_of(index: usize, object: &Object, reference: Vector) -> Vec<Self> {
        let surface = |triangle, shape| Self {
            object: index,
            light: None,
            triangle,
            shadow_terminator: ShadowTerminator::Geometric,
            shape,
        };
        // Exact: nothing that was written is rounded.
        let reference = widened(reference);
        let relative = |point: Vector| subtract(widened(point), reference);
        match object {
            Object::Sphere { center, radius, .. } => vec![surface(
                None,
                Shape::Sphere {
                    center: relative(center.value),
                    radius: radius.value.into(),
                },
            )],
            Object::Plane { point, normal, .. } => unit(widened(normal.value))
                .map(|normal| {
                    let point = relative(point.value);
                    surface(None, Shape::Plane { point, normal })
                })
                .into_iter()
                .collect(),
            Object::Triangle { vertices, .. } => {
                let vertices = vertices.value.map(relative);
                Shape::triangle(vertices, None)
                    .map(|shape| surface(None, shape))
                    .into_iter()
                    .collect()
            }
            Object::Mesh {
                scale,
                rotate,
                translate,
                smooth,
                shadow_terminator,
                geometry,
                ..
            } => {
                let transform = Transform {
                    scale: scale.value,
                    rotate: rotate.value,
                    // Together first: far from the origin the two nearly cancel.
                    translate: relative(translate.value),
                };
                (0..geometry.triangles.len())
                    .filter_map(|triangle| {
                        let shape = transform.triangle(geometry, triangle, *smooth)?;
                        Some(Self {
                            shadow_terminator: *shadow_terminator,
                            ..surface(Some(triangle), shape)
                        })
                    })
                    .collect()
            }
        }
    }

    /// L2: the distance along the ray to where it first meets the surface, above 0.
    pub(super) fn intersect(&self, ray: &Ray) -> Option<Wide> {
        if !self.may_meet(ray) {
            return None;
        }
        match &self.shape {
            Shape::Sphere { center, radius } => ray_sphere(ray, *center, *radius),
            Shape::Plane { point, normal } => ray_plane(ray, *point, *normal),
            Shape::Rectangle {
                center,
                normal,
                halves,
            } => ray_plane(ray, *center, *normal)
                .filter(|&t| is_in_rectangle(subtract(ray.at(t), *center), halves)),
            Shape::Disk {
                center,
                normal,
                radius,
            } => ray_plane(ray, *center, *normal)
                .filter(|&t| length(subtract(ray.at(t), *center)) <= *radius),
            Shape::Triangle {
                vertices, normal, ..
            } => ray_triangle(ray, vertices, *normal),
        }
    }

    /// Whether the line of a ray may meet it: `false` is certain, by f64 with room for all its rounding. Of most
    /// surfaces that is all that has to be asked.
    pub(super) fn may_meet(&self, ray: &Ray) -> bool {
        let (origin, direction) = (narrowed(ray.origin), narrowed(ray.direction));
        match &self.shape {
            // There are few of lights.
            Shape::Plane { .. } | Shape::Rectangle { .. } | Shape::Disk { .. } => true,
            Shape::Sphere { center, radius } => {
                let m = subtract(narrowed(*center), origin);
                let along = dot(m, direction) / dot(direction, direction);
                let across = subtract(m, scale(direction, along));
                let sizes = [dot(origin, origin), dot(m, m), radius.narrow().powi(2)];
                let room = ROOM * (sizes[0] + sizes[1] + sizes[2]);
                // Squares beyond f64 are not a number: they are not surely beside it.
                let is_beside = dot(across, across) > sizes[2] + room;
                !is_beside
            }
            Shape::Triangle { vertices, .. } => {
                let vertices = vertices.map(narrowed);
                let [a, b, c] = along_the_line(origin, direction, &vertices);
                let sum = |v: Vector| v[0].abs() + v[1].abs() + v[2].abs();
                let magnitude = vertices.into_iter().map(sum).fold(0.0, f64::max) + sum(origin);
                let size = |p: [f64; 2]| p[0].abs() + p[1].abs();
                let room = ROOM * magnitude * (size(a) + size(b) + size(c));
                let areas = [area(b, c), area(c, a), area(a, b)];
                !(areas.iter().any(|&area| area > room) && areas.iter().any(|&area| area < -room))
            }
        }
    }
}

/// Far more than f64 can be off in a few operations, relative.
const ROOM: f64 = 1e-13;

impl Shape {
    /// A triangle, or `None` where its edges span no area.
    ///
    /// Its first corner becomes the one opposite to the longest edge: the cross product of the two
    /// shorter edges has the smallest rounding error, and so has a distance measured from there.
    fn triangle(
        mut vertices: [WideVector; 3],
        mut vertex_normals: Option<[WideVector; 3]>,
    ) -> Option<Self> {
        let [a, b, c] = vertices;
        let [opposite_a, opposite_b, opposite_c] =
            [subtract(c, b), subtract(a, c), subtract(b, a)].map(length);
        let first = if opposite_a >= opposite_b && opposite_a >= opposite_c {
            0
        } else if opposite_b >= opposite_c {
            1
        } else {
            2
        };
        vertices.rotate_left(first);
        if let Some(normals) = &mut vertex_normals {
            normals.rotate_left(first);
        }
        let [a, b, c] = vertices;
        Some(Self::Triangle {
            vertices,
            normal: unit(cross(subtract(b, a), subtract(c, a)))?,
            vertex_normals,
        })
    }

    /// The size of the coordinates as whose rounding surfaces count as coincident, relative to the eye: of a
    /// plane and a sphere how far away they are, wherever their points and centers are.
    pub(super) fn magnitude(&self) -> f64 {
        match self {
            Self::Sphere { center, radius } => (length(*center) - *radius).narrow().abs(),
            Self::Plane { point, normal } => dot(*point, *normal).narrow().abs(),
            Self::Rectangle { center, .. } | Self::Disk { center, .. } => length(*center).narrow(),
            Self::Triangle {
                vertices: [point, ..],
                ..
            } => length(*point).narrow(),
        }
    }
}

/// v ↦ T R S v with R = R_z R_y R_x.
struct Transform {
    scale: Vector,
    /// Degrees about x, y and z.
    rotate: Vector,
    translate: WideVector,
}

impl Transform {
    /// One triangle of a mesh file, transformed.
    fn triangle(&self, mesh: &MeshFile, triangle: usize, smooth: bool) -> Option<Shape> {
        let corners = |vectors: &[Vector], indices: &[u32; 3]| -> Option<[Vector; 3]> {
            let corner = |i: usize| vectors.get(indices[i] as usize).copied();
            Some([corner(0)?, corner(1)?, corner(2)?])
        };
        let positions = mesh.triangles.get(triangle)?;
        let vertices = corners(&mesh.positions, positions)?.map(|vertex| self.point(vertex));
        let vertex_normals = mesh
            .normals
            .as_ref()
            .filter(|_| smooth)
            .and_then(|normals| {
                let indices = match &normals.triangles {
                    Some(triangles) => triangles.get(triangle)?,
                    None => positions,
                };
                let [a, b, c] = corners(&normals.vectors, indices)?;
                Some([self.normal(a)?, self.normal(b)?, self.normal(c)?])
            });
        Shape::triangle(vertices, vertex_normals)
    }

    /// T R S v
    fn point(&self, v: Vector) -> WideVector {
        let scaled = multiply(widened(self.scale), widened(v));
        add(self.rotated(scaled), self.translate)
    }

    /// A normal is transformed by the inverse transpose, (R S)⁻ᵀ = R S⁻¹, and normalized.
    fn normal(&self, n: Vector) -> Option<WideVector> {
        let inverse = widened(self.scale).map(|factor| Wide::from(1.0) / factor);
        unit(self.rotated(multiply(inverse, widened(n))))
    }

    /// R_z R_y R_x v
    fn rotated(&self, [x, y, z]: WideVector) -> WideVector {
        let [about_x, about_y, about_z] = self
            .rotate
            .map(|degrees| degrees.to_radians().sin_cos())
            .map(|(sin, cos)| (Wide::from(sin), Wide::from(cos)))
            .map(|(sin, cos)| move |a: Wide, b: Wide| (cos * a - sin * b, sin * a + cos * b));
        let (y, z) = about_x(y, z);
        let (z, x) = about_y(z, x);
        let (x, y) = about_z(x, y);
        [x, y, z]
    }
}

/// L2, sphere: ‖o + t ω − c‖² = R².
///
/// With the vector m = c − o, its part b = m·ω along the ray and the rest m − b ω across it,
/// t = b ∓ √(R² − ‖m − b ω‖²). For small spheres far away this form does not cancel, as the
/// textbook's b² − 4ac does. Of the two roots the smaller comes from their product ‖m‖² − R², for
/// the same reason.
fn ray_sphere(ray: &Ray, center: WideVector, radius: Wide) -> Option<Wide> {
    let zero = Wide::from(0.0);
    let m = subtract(center, ray.origin);
    let b = dot(m, ray.direction);
    let across = length(subtract(m, scale(ray.direction, b)));
    let discriminant = (radius - across) * (radius + across);
    if discriminant < zero {
        return None;
    }
    let root = discriminant.sqrt();
    let larger = if b < zero { b - root } else { b + root };
    let distance = length(m);
    let other = (distance - radius) * (distance + radius) / larger;
    let ordered = if other < larger {
        [other, larger]
    } else {
        [larger, other]
    };
    ordered.into_iter().find(|&t| counts(t))
}

/// L2, plane through a with normal n: n·(o + t ω − a) = 0, so t = n·(a − o) / n·ω.
fn ray_plane(ray: &Ray, point: WideVector, normal: WideVector) -> Option<Wide> {
    let t = plane_parameter(ray, point, normal);
    counts(t).then_some(t)
}

/// Whether a point of the plane of a rectangle, seen from its center, is between its sides.
pub(super) fn is_in_rectangle(from_center: WideVector, halves: &[WideVector; 2]) -> bool {
    halves.iter().all(|&semi| {
        let along = dot(from_center, semi);
        let most = dot(semi, semi);
        -most <= along && along <= most
    })
}

/// n·(a − o) / n·ω, infinite or NaN where the ray is parallel to the plane.
fn plane_parameter(ray: &Ray, point: WideVector, normal: WideVector) -> Wide {
    dot(normal, subtract(point, ray.origin)) / dot(normal, ray.direction)
}

/// L2, triangle: where the ray meets its plane, if that is inside all three edges.
///
/// The corners bound t: the plane of a sliver, whose normal is mostly rounding, may be met far
/// outside of them.
fn ray_triangle(ray: &Ray, vertices: &[WideVector; 3], normal: WideVector) -> Option<Wide> {
    barycentric(ray.origin, ray.direction, vertices)?;
    let along = vertices.map(|vertex| dot(subtract(vertex, ray.origin), ray.direction));
    let smaller = |a: Wide, b: Wide| if b < a { b } else { a };
    let larger = |a: Wide, b: Wide| if b > a { b } else { a };
    let [nearest, farthest] = [
        along.into_iter().reduce(smaller)?,
        along.into_iter().reduce(larger)?,
    ];
    let t = plane_parameter(ray, vertices[0], normal);
    // A plane along the ray is met anywhere, and NaN is not larger than anything.
    let t = if t > nearest { t } else { nearest };
    let t = smaller(t, farthest);
    counts(t).then_some(t)
}

/// The barycentric coordinates at which a line passes through a triangle, edges included, or
/// `None` where it passes outside.
///
/// The corners are projected along the line onto a plane through two axes, where the line is the
/// point (0, 0); the coordinates are as the areas x y' − y x' that this point spans with the
/// edges (Woop, Benthin & Wald 2013). Rounding moves a corner in the same way for all triangles
/// that share it, and cannot turn the sign of an area, only make it 0, which counts as inside. So
/// no line slips through where triangles share an edge or a corner.
pub(super) fn barycentric(
    origin: WideVector,
    direction: WideVector,
    vertices: &[WideVector; 3],
) -> Option<[Wide; 3]> {
    let zero = Wide::from(0.0);
    let [a, b, c] = along_the_line(origin, direction, vertices);
    let areas = [area(b, c), area(c, a), area(a, b)];
    let inside = areas.iter().all(|&area| area >= zero) || areas.iter().all(|&area| area <= zero);
    let sum = areas[0] + areas[1] + areas[2];
    (inside && sum != zero).then(|| areas.map(|area| area / sum))
}

/// The corners as seen along a line, which is the point (0, 0).
fn along_the_line<T: Real>(
    origin: [T; 3],
    direction: [T; 3],
    vertices: &[[T; 3]; 3],
) -> [[T; 2]; 3] {
    let z = longest_axis(narrowed(direction));
    let (x, y) = ((z + 1) % 3, (z + 2) % 3);
    let (slope_x, slope_y) = (direction[x] / direction[z], direction[y] / direction[z]);
    vertices.map(|vertex| {
        let v = subtract(vertex, origin);
        [v[x] - slope_x * v[z], v[y] - slope_y * v[z]]
    })
}

/// Twice the area between (0, 0) and two points.
fn area<T: Real>(p: [T; 2], q: [T; 2]) -> T {
    p[0] * q[1] - p[1] * q[0]
}

/// The axis along which a vector is longest.
fn longest_axis(v: Vector) -> usize {
    let [x, y, z] = v.map(f64::abs);
    if x >= y && x >= z {
        0
    } else if y >= z {
        1
    } else {
        2
    }
}

/// Whether a root of L2 counts: in front of the origin.
fn counts(t: Wide) -> bool {
    t > Wide::from(0.0) && t.narrow().is_finite()
}
