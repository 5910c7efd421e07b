//! Where an emitter is: its surface, points on it, and which of its sides a point sees.

use std::f64::consts::TAU;

use super::{Emitter, Shape};
use crate::math::{DVec3, Normal, Point};

/// The shape of an emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Surface {
    /// Four corners in turn, counter-clockwise seen from the side that the normal points to.
    Rectangle([DVec3; 4]),
    Disk {
        normal: Normal,
        radius: f64,
    },
    Sphere {
        radius: f64,
    },
}

/// 1 less than the golden ratio: steps of this part of a whole fill it evenly, however many there are.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

impl Emitter {
    /// Its middle.
    pub(crate) fn center(&self) -> Point {
        self.center
    }

    /// Its shape.
    pub(crate) fn surface(&self) -> Surface {
        match self.shape {
            Shape::Rectangle { halves: [a, b], .. } => Surface::Rectangle(
                [-a - b, a - b, a + b, b - a].map(|corner| self.center.0 + corner),
            ),
            Shape::Disk { radius, normal, .. } => Surface::Disk { normal, radius },
            Shape::Sphere { radius } => Surface::Sphere { radius },
        }
    }

    /// The side that it shines to; `None` of a sphere.
    pub(crate) fn normal(&self) -> Option<Normal> {
        match self.shape {
            Shape::Rectangle { normal, .. } | Shape::Disk { normal, .. } => Some(normal),
            Shape::Sphere { .. } => None,
        }
    }

    /// Whether its back shines too.
    pub(crate) fn is_two_sided(&self) -> bool {
        match self.shape {
            Shape::Rectangle { is_two_sided, .. } | Shape::Disk { is_two_sided, .. } => {
                is_two_sided
            }
            Shape::Sphere { .. } => false,
        }
    }

    /// Whether what looks along a direction to the viewer, from a point of its surface, sees the side that shines.
    pub(crate) fn shines_along(&self, from: Point, to_viewer: DVec3) -> bool {
        match self.shape {
            Shape::Rectangle {
                normal,
                is_two_sided,
                ..
            }
            | Shape::Disk {
                normal,
                is_two_sided,
                ..
            } => is_two_sided || normal.get().dot(to_viewer) > 0.0,
            Shape::Sphere { .. } => from.from(self.center).dot(to_viewer) > 0.0,
        }
    }

    /// Whether it has no back that shines, and all of a box is behind it or in its plane.
    pub(crate) fn is_behind(&self, [least, most]: [DVec3; 2]) -> bool {
        let Some(normal) = self.normal().filter(|_| !self.is_two_sided()) else {
            return false;
        };
        let normal = normal.get();
        let highest = DVec3::select(normal.cmpgt(DVec3::ZERO), most, least);
        normal.dot(highest - self.center.0) <= 0.0
    }

    /// A box around it, from its least to its largest coordinates.
    pub(crate) fn bounds(&self) -> [DVec3; 2] {
        let reach = match self.shape {
            Shape::Rectangle { halves: [a, b], .. } => a.abs() + b.abs(),
            Shape::Disk { radius, normal, .. } => {
                let [x, y, z] = normal.get().to_array();
                let across = |a: f64, b: f64| libm::hypot(a, b);
                DVec3::new(across(y, z), across(z, x), across(x, y)) * radius
            }
            Shape::Sphere { radius } => DVec3::splat(radius),
        };
        [self.center.0 - reach, self.center.0 + reach]
    }

    /// So many points spread evenly over it, each with its part of the area in m²: a lattice of the golden ratio
    /// (of a disk and a sphere Vogel's spiral), of which no two are in one row or column.
    pub(crate) fn points(&self, count: u32) -> impl ExactSizeIterator<Item = SurfacePoint> + use<> {
        let emitter = *self;
        let share = f64::from(count).recip();
        let area = self.area() * share;
        (0..count).map(move |number| {
            let along = (f64::from(number) + 0.5) * share;
            let turn = (f64::from(number) + 0.5) * GOLDEN;
            let turn = turn - libm::floor(turn);
            let (place, normal) = match emitter.shape {
                Shape::Rectangle {
                    halves: [a, b],
                    normal,
                    ..
                } => (
                    a * (2.0 * along - 1.0) + b * (2.0 * turn - 1.0),
                    normal.get(),
                ),
                Shape::Disk { radius, normal, .. } => {
                    let across = normal.get().any_orthonormal_vector();
                    let up = normal.get().cross(across);
                    let (sin, cos) = libm::sincos(TAU * turn);
                    let out = radius * along.sqrt();
                    (across * (out * cos) + up * (out * sin), normal.get())
                }
                Shape::Sphere { radius } => {
                    let z = 2.0 * along - 1.0;
                    let (sin, cos) = libm::sincos(TAU * turn);
                    let out = ((1.0 - z) * (1.0 + z)).sqrt();
                    let normal = DVec3::new(out * cos, out * sin, z);
                    (normal * radius, normal)
                }
            };
            SurfacePoint {
                position: Point(emitter.center.0 + place),
                normal,
                area,
            }
        })
    }
}

/// A point of an emitter that stands for a part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SurfacePoint {
    pub(crate) position: Point,
    /// Of unit length.
    pub(crate) normal: DVec3,
    /// In m².
    pub(crate) area: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_spread_over_the_whole_surface() {
        let normal = Normal::new(DVec3::new(1.0, 2.0, -0.5)).unwrap();
        let center = Point(DVec3::new(3.0, -1.0, 0.5));
        let halves = [DVec3::new(2.0, 0.0, 0.0), DVec3::new(0.0, 0.0, 0.5)];
        for emitter in [
            Emitter::rectangle(center, halves, false).unwrap(),
            Emitter::disk(center, normal, 1.5, false).unwrap(),
            Emitter::sphere(center, 1.5).unwrap(),
        ] {
            let points: Vec<_> = emitter.points(1000).collect();
            let area: f64 = points.iter().map(|point| point.area).sum();
            assert!((area / emitter.area() - 1.0).abs() < 1e-12);
            let [least, most] = emitter.bounds();
            let mean: DVec3 = points.iter().map(|point| point.position.0).sum::<DVec3>() / 1000.0;
            assert!((mean - center.0).length() < 2e-3 * (most - least).length());
            for point in &points {
                let place = point.position.0;
                assert!(place.cmpge(least - 1e-12).all() && place.cmple(most + 1e-12).all());
                assert!((point.normal.length() - 1.0).abs() < 1e-14);
            }
            // Nowhere further from the box than they are dense.
            let reached = points
                .iter()
                .fold([DVec3::MAX, DVec3::MIN], |[a, b], point| {
                    [a.min(point.position.0), b.max(point.position.0)]
                });
            assert!((reached[0] - least).abs().max_element() < 0.05);
            assert!((reached[1] - most).abs().max_element() < 0.05);
        }
    }

    #[test]
    fn golden_is_the_golden_ratio_less_1() {
        assert!((GOLDEN - (5.0_f64.sqrt() - 1.0) / 2.0).abs() < 1e-16);
    }
}
