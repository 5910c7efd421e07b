//! What glass a ray is inside of.
//!
//! Glass objects may overlap. Where they do, the medium is that of the object with the smallest bounding box, of equally
//! large ones the first in the file; where there is none it is air, n = 1.

use std::f64::consts::PI;

use super::surface::{Shape, Surface};
use super::vector::{Vector, WideVector, cross, dot, length, narrowed, subtract};
use super::wide::{Real, Wide};

/// The glass objects that a ray is inside of, by their indices, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Inside(Vec<usize>);

impl Inside {
    /// This one as well.
    pub(super) fn with(&self, object: usize) -> Self {
        let Self(mut objects) = self.without(object);
        let place = objects.partition_point(|&other| other < object);
        objects.insert(place, object);
        Self(objects)
    }

    /// All but this one.
    pub(super) fn without(&self, object: usize) -> Self {
        let others = self.0.iter().copied();
        Self(others.filter(|&other| other != object).collect())
    }
}

/// All glass objects.
#[derive(Clone, Debug)]
pub(super) struct Media(Vec<Body>);

/// A glass object.
#[derive(Clone, Debug)]
struct Body {
    object: usize,
    /// Of its bounding box.
    volume: f64,
    /// Whether its triangles, as they are written, are turned inwards.
    is_turned: bool,
}

impl Media {
    /// Of the objects for which `is_glass` says so.
    pub(super) fn new(surfaces: &[Surface], is_glass: impl Fn(usize) -> bool) -> Self {
        let mut bodies = Vec::new();
        for of_object in surfaces.chunk_by(|a, b| a.object == b.object) {
            let object = of_object[0].object;
            if is_glass(object) {
                bodies.push(Body::new(object, of_object));
            }
        }
        Self(bodies)
    }

    /// The object whose glass is where all these are; `None` in air.
    pub(super) fn innermost(&self, inside: &Inside) -> Option<usize> {
        let bodies = self.0.iter();
        let around = bodies.filter(|body| inside.0.contains(&body.object));
        // The first of equally small ones.
        let smallest = around.min_by(|a, b| a.volume.total_cmp(&b.volume));
        smallest.map(|body| body.object)
    }

    /// Whether an object's triangles are turned inwards.
    pub(super) fn is_turned(&self, object: usize) -> bool {
        let mut bodies = self.0.iter();
        bodies.any(|body| body.object == object && body.is_turned)
    }

    /// The objects around a point.
    pub(super) fn around(&self, surfaces: &[Surface], point: WideVector) -> Inside {
        let bodies = self.0.iter().map(|body| body.object);
        let around = bodies.filter(|&object| {
            let of_object = surfaces.iter().filter(|surface| surface.object == object);
            let shapes: Vec<&Shape> = of_object.map(|surface| &surface.shape).collect();
            is_around(&shapes, point)
        });
        Inside(around.collect())
    }
}

impl Body {
    fn new(object: usize, surfaces: &[Surface]) -> Self {
        let shapes: Vec<&Shape> = surfaces.iter().map(|surface| &surface.shape).collect();
        Self {
            object,
            volume: bounds(&shapes),
            is_turned: signed_volume(&shapes) < Wide::from(0.0),
        }
    }
}

/// The corners of all triangles.
fn triangles<'s>(shapes: &'s [&Shape]) -> impl Iterator<Item = &'s [WideVector; 3]> + Clone {
    shapes.iter().filter_map(|shape| match shape {
        Shape::Triangle { vertices, .. } => Some(vertices),
        Shape::Sphere { .. }
        | Shape::Plane { .. }
        | Shape::Rectangle { .. }
        | Shape::Disk { .. } => None,
    })
}

/// The volume of the bounding box: of a sphere (2r)³.
fn bounds(shapes: &[&Shape]) -> f64 {
    match shapes {
        [Shape::Sphere { radius, .. }] => {
            let width = *radius + *radius;
            (width * width * width).narrow()
        }
        // Only bodies are made of glass in a legal scene.
        [Shape::Plane { .. }] => f64::INFINITY,
        _ => {
            let volume = [0, 1, 2].map(|axis: usize| {
                let corners = triangles(shapes).flatten().map(|corner| corner[axis]);
                let smaller = |a: Wide, b: Wide| if b < a { b } else { a };
                let larger = |a: Wide, b: Wide| if b > a { b } else { a };
                let least = corners.clone().reduce(smaller).unwrap_or_default();
                corners.reduce(larger).unwrap_or_default() - least
            });
            (volume[0] * volume[1] * volume[2]).narrow()
        }
    }
}

/// Σ a·(b × c) / 6: below 0 where closed triangles are turned inwards.
fn signed_volume(shapes: &[&Shape]) -> Wide {
    let volume = |[a, b, c]: &[WideVector; 3]| dot(*a, cross(*b, *c)) / Wide::from(6.0);
    triangles(shapes)
        .map(volume)
        .fold(Wide::from(0.0), |sum, part| sum + part)
}

/// Whether a body is around a point: closed triangles fill all directions as seen from there, once or another odd number
/// of times.
fn is_around(shapes: &[&Shape], point: WideVector) -> bool {
    match shapes {
        [Shape::Sphere { center, radius }] => length(subtract(point, *center)) < *radius,
        _ => {
            let angles = triangles(shapes).map(|corners| {
                solid_angle(corners.map(|corner| narrowed(subtract(corner, point))))
            });
            let times = (angles.sum::<f64>() / (4.0 * PI)).round().abs();
            times % 2.0 == 1.0
        }
    }
}

/// The solid angle of a triangle as seen from the origin, with a sign (van Oosterom and Strackee 1983):
/// tan(Ω/2) = a·(b × c) / (abc + (a·b) c + (b·c) a + (c·a) b).
fn solid_angle([a, b, c]: [Vector; 3]) -> f64 {
    let [of_a, of_b, of_c] = [a, b, c].map(length);
    let volume = dot(a, cross(b, c));
    let sum = of_a * of_b * of_c + dot(a, b) * of_c + dot(b, c) * of_a + dot(c, a) * of_b;
    2.0 * volume.atan2(sum)
}
