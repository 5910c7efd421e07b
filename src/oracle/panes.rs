//! L4 through panes: light that comes straight through one is T(θ) of it, θ between its way and the pane's normal.

use super::fresnel;
use super::occlusion::{Segment, Side};
use super::surface::{Shape, Surface};
use super::vector::{WideVector, dot, length, scale, subtract};
use super::wide::{Real, Wide};

/// Two triangles that share the edge through which a segment goes are one pane: parts of the way up to which crossings of
/// one object are the same.
const SAME: f64 = 1e-12;

/// Where a segment goes through a pane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    /// The index of its surface.
    pub(super) surface: usize,
    object: usize,
    /// Of the way from p to p_L.
    part: f64,
    /// T, of a sphere that is crossed twice T².
    pub(super) transmittance: f64,
}

impl Crossing {
    /// A surface of index n that stands between, first at this part of the way.
    pub(super) fn of(
        index: usize,
        surface: &Surface,
        segment: &Segment,
        part: f64,
        n: f64,
    ) -> Self {
        let way = segment.vector();
        let (cos, times) = match &surface.shape {
            Shape::Plane { normal, .. }
            | Shape::Triangle { normal, .. }
            | Shape::Rectangle { normal, .. }
            | Shape::Disk { normal, .. } => (cosine(*normal, way), 1),
            Shape::Sphere { center, radius } => {
                let from_center = subtract(segment.from, *center);
                let along = dot(from_center, way) / dot(way, way);
                let across = length(subtract(from_center, scale(way, along))) / *radius;
                let squared = Wide::from(1.0) - across * across;
                let cos = if squared > Wide::from(0.0) {
                    squared.sqrt()
                } else {
                    Wide::from(0.0)
                };
                let magnitude = surface.shape.magnitude();
                let sides = segment.sides_of_sphere(*center, *radius, magnitude);
                let is_passed_through = sides == (Side::Above, Side::Above);
                (cos, if is_passed_through { 2 } else { 1 })
            }
        };
        let [_, transmittance] = fresnel::pane(cos, n);
        Self {
            surface: index,
            object: surface.object,
            part,
            transmittance: transmittance.powi(times),
        }
    }

    /// Without those that are met twice, where triangles of one object share an edge; the nearest to p first.
    pub(super) fn once_each(mut crossings: Vec<Self>) -> Vec<Self> {
        crossings.sort_by(|a, b| a.part.total_cmp(&b.part));
        let mut kept: Vec<Self> = Vec::with_capacity(crossings.len());
        for crossing in crossings {
            let is_same = |other: &Self| {
                other.object == crossing.object && crossing.part - other.part <= SAME
            };
            if !kept.iter().any(is_same) {
                kept.push(crossing);
            }
        }
        kept
    }
}

/// Of the angle between a way and a normal, on either side.
fn cosine(normal: WideVector, way: WideVector) -> Wide {
    let (zero, one) = (Wide::from(0.0), Wide::from(1.0));
    let cos = dot(normal, way) / length(way);
    let cos = if cos < zero { -cos } else { cos };
    if cos > one { one } else { cos }
}
