//! The nearest hit of a primary ray: p, n and ω_o.

use super::camera::Ray;
use super::surface::{Shape, Surface, barycentric};
use super::terminator::OnTriangle;
use super::vector::{WideVector, add, dot, negate, scale, subtract, unit};
use super::wide::Wide;
use crate::scene::ShadowTerminator;

/// The nearest point along a primary ray.
pub(super) struct Hit {
    /// The index of its surface.
    pub(super) surface: usize,
    /// t
    pub(super) distance: Wide,
    /// p
    pub(super) position: WideVector,
    /// Towards the viewer.
    pub(super) geometric_normal: WideVector,
    /// n: interpolated where the mesh is smooth, on the side of the geometric normal.
    pub(super) normal: WideVector,
    /// Whether the vertex normals are on the far side of the geometric normal, so that n is turned over.
    pub(super) is_behind: bool,
    /// Whether the viewer is where the normal of the surface as written points: of a sphere outside.
    pub(super) is_in_front: bool,
    /// ω_o
    pub(super) to_viewer: WideVector,
    /// Where the mesh says so, how shadow rays start elsewhere than at p.
    pub(super) lift: Option<Lift>,
}

/// `shadow_terminator = "hanika"` at a point.
#[derive(Clone, Copy)]
pub(super) struct Lift {
    /// p′ − p
    pub(super) way: WideVector,
    /// The size of the coordinates from which p′ is computed, beside those of p.
    pub(super) magnitude: f64,
}

impl Hit {
    pub(super) fn new(index: usize, surface: &Surface, ray: &Ray, distance: Wide) -> Self {
        let shape = &surface.shape;
        let to_viewer = negate(ray.direction);
        let on_ray = ray.at(distance);
        let (position, outward) = match shape {
            Shape::Plane { normal, .. }
            | Shape::Rectangle { normal, .. }
            | Shape::Disk { normal, .. }
            | Shape::Triangle { normal, .. } => (on_ray, *normal),
            Shape::Sphere { center, .. } => {
                let normal = unit(subtract(on_ray, *center)).unwrap_or(to_viewer);
                (on_ray, normal)
            }
        };
        let geometric_normal = turned_towards(outward, to_viewer);
        let is_in_front = dot(outward, to_viewer) >= Wide::from(0.0);
        let interpolated = interpolated_normal(shape, ray);
        let is_behind =
            interpolated.is_some_and(|normal| dot(normal, geometric_normal) < Wide::from(0.0));
        let lift = match surface.shadow_terminator {
            ShadowTerminator::Geometric => None,
            ShadowTerminator::Hanika => {
                interpolated.and_then(|_| lift(shape, ray, position, is_behind))
            }
        };
        Self {
            surface: index,
            distance,
            position,
            geometric_normal,
            normal: interpolated.map_or(geometric_normal, |normal| {
                turned_towards(normal, geometric_normal)
            }),
            is_behind,
            is_in_front,
            to_viewer,
            lift,
        }
    }
}

/// Surfaces are two-sided: the normal, or its opposite, on the side of `side`.
fn turned_towards(normal: WideVector, side: WideVector) -> WideVector {
    if dot(normal, side) < Wide::from(0.0) {
        negate(normal)
    } else {
        normal
    }
}

/// The vertex normals of a smooth triangle, weighted by the barycentric coordinates of the hit.
/// `None` for anything else, and where the weighted normals cancel.
fn interpolated_normal(shape: &Shape, ray: &Ray) -> Option<WideVector> {
    match shape {
        Shape::Triangle {
            vertices,
            vertex_normals: Some([a, b, c]),
            ..
        } => {
            let [in_a, in_b, in_c] = barycentric(ray.origin, ray.direction, vertices)?;
            unit(add(add(scale(*a, in_a), scale(*b, in_b)), scale(*c, in_c)))
        }
        Shape::Triangle {
            vertex_normals: None,
            ..
        }
        | Shape::Sphere { .. }
        | Shape::Rectangle { .. }
        | Shape::Disk { .. }
        | Shape::Plane { .. } => None,
    }
}

/// How a point of a smooth triangle is lifted; `is_behind` where its vertex normals are on the far side.
fn lift(shape: &Shape, ray: &Ray, position: WideVector, is_behind: bool) -> Option<Lift> {
    let Shape::Triangle {
        vertices,
        vertex_normals: Some(normals),
        ..
    } = shape
    else {
        return None;
    };
    let point = OnTriangle {
        position,
        vertices: *vertices,
        normals: if is_behind {
            normals.map(negate)
        } else {
            *normals
        },
        barycentric: barycentric(ray.origin, ray.direction, vertices)?,
    };
    Some(Lift {
        way: point.lift(),
        magnitude: point.magnitude(),
    })
}

/// Whether the way from a point of a sphere to the light starts into the sphere.
pub(super) fn starts_inwards(hit: &Hit, center: WideVector, way: WideVector) -> bool {
    let outward = turned_towards(hit.geometric_normal, subtract(hit.position, center));
    dot(outward, way) < Wide::from(0.0)
}
