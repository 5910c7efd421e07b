//! Lights with an area: their shapes, and what they send out in all.

use std::f64::consts::PI;

use super::surface::{Shape, Surface};
use super::value::Extent;
use super::vector::{Vector, WideVector, cross, dot, length, scale, subtract, unit, widened};
use super::wide::{Real, Wide};
use crate::scene::{Aim, AreaShape, ShadowTerminator};

/// A surface that shines, with the same luminance everywhere and in all directions.
#[derive(Clone, Debug)]
pub(super) struct Area {
    /// A rectangle, a disk or a sphere.
    pub(super) shape: Shape,
    /// Whether a flat one shines against its normal too.
    pub(super) is_two_sided: bool,
    /// Whether it is seen, and in the way of light.
    pub(super) is_visible: bool,
}

impl Area {
    /// With `reference` as the origin; `None` where it does not point anywhere, which no legal one does.
    pub(super) fn new(shape: &AreaShape, is_visible: bool, reference: Vector) -> Option<Self> {
        let center = subtract(widened(shape.center().value), widened(reference));
        let axis = |aim: &Aim| {
            unit(match aim {
                Aim::LookAt(point) => subtract(widened(point.value), widened(shape.center().value)),
                Aim::Direction(direction) => widened(direction.value),
            })
        };
        let (made, is_two_sided) = match shape {
            AreaShape::Rectangle {
                aim,
                up,
                size,
                two_sided,
                ..
            } => {
                let normal = axis(aim)?;
                let [side, up] = sides(normal, up.map(|up| up.value))?;
                let [across, along] = size.value.map(|size| Wide::from(0.5 * size));
                let halves = [scale(side, across), scale(up, along)];
                let rectangle = Shape::Rectangle {
                    center,
                    normal,
                    halves,
                };
                (rectangle, *two_sided)
            }
            AreaShape::Disk {
                aim,
                radius,
                two_sided,
                ..
            } => {
                let disk = Shape::Disk {
                    center,
                    normal: axis(aim)?,
                    radius: radius.value.into(),
                };
                (disk, *two_sided)
            }
            AreaShape::Sphere { radius, .. } => {
                let radius = radius.value.into();
                (Shape::Sphere { center, radius }, false)
            }
        };
        Some(Self {
            shape: made,
            is_two_sided,
            is_visible,
        })
    }

    /// What it sends out at 1 cd/m²: along its normal, and in all.
    pub(super) fn extent(&self) -> Extent {
        let flat = |area: f64| Extent {
            intensity: area,
            flux: PI * area * if self.is_two_sided { 2.0 } else { 1.0 },
        };
        match &self.shape {
            Shape::Rectangle { halves, .. } => {
                let [a, b] = halves.map(|semi| dot(semi, semi).sqrt().narrow());
                flat(4.0 * a * b)
            }
            Shape::Disk { radius, .. } => flat(PI * radius.narrow().powi(2)),
            Shape::Sphere { radius, .. } => {
                let intensity = PI * radius.narrow().powi(2);
                let flux = 4.0 * PI * intensity;
                Extent { intensity, flux }
            }
            // Nothing else shines.
            Shape::Plane { .. } | Shape::Triangle { .. } => flat(f64::INFINITY),
        }
    }

    /// How far its points are from its middle at most.
    pub(super) fn reach(&self) -> f64 {
        match &self.shape {
            Shape::Rectangle { halves, .. } => {
                let [a, b] = halves.map(|semi| dot(semi, semi).sqrt().narrow());
                a.hypot(b)
            }
            Shape::Disk { radius, .. } | Shape::Sphere { radius, .. } => radius.narrow(),
            Shape::Plane { .. } | Shape::Triangle { .. } => f64::INFINITY,
        }
    }

    /// Whether it shines to the side where its normal points, or to the other one.
    pub(super) fn shines(&self, in_front: bool) -> bool {
        in_front || self.is_two_sided
    }

    /// The surface that is seen, of the light and the object of these numbers.
    pub(super) fn surface(&self, light: usize, object: usize) -> Surface {
        Surface {
            object,
            light: Some(light),
            triangle: None,
            shadow_terminator: ShadowTerminator::Geometric,
            shape: self.shape.clone(),
        }
    }
}

/// The directions across `up` and along it, square to the axis.
fn sides(axis: WideVector, up: Option<Vector>) -> Option<[WideVector; 2]> {
    // An `up` of nobody, or along the axis, is y, or −z along that.
    let is_across = |up: &WideVector| length(cross(axis, *up)).narrow() > 1e-6;
    let written = match up {
        Some(up) => Some(unit(widened(up))?),
        None => None,
    };
    let up = written
        .into_iter()
        .chain([widened([0.0, 1.0, 0.0])])
        .find(is_across);
    let up = up.unwrap_or(widened([0.0, 0.0, -1.0]));
    let up = unit(subtract(up, scale(axis, dot(up, axis))))?;
    Some([cross(axis, up), up])
}
