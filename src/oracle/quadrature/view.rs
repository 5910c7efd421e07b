//! A light as it is seen from a point: a flat figure, cut into lines.

use std::f64::consts::FRAC_PI_2;

use super::super::area::Area;
use super::super::surface::Shape;
use super::super::vector::{
    Vector, WideVector, add, cross, dot, length, narrowed, negate, scale, subtract, unit, widened,
};
use super::super::wide::{Real, Wide};

/// How far coordinates that were meant to be in a plane may be off it, in units of ε times their size.
const ROUNDING: f64 = 16.0;

/// The directions from p to a light: those to a rectangle, or to a disk. Of a sphere it is the disk whose rim is
/// where it turns away from p, the base of the cone that holds it.
///
/// All is relative to p.
#[derive(Clone, Debug)]
pub(super) struct View {
    pub(super) middle: Vector,
    /// From the middle along lines, and across them: to the ends of a rectangle, or of a disk.
    pub(super) along: Vector,
    pub(super) across: Vector,
    pub(super) is_round: bool,
    /// The unit vector across all of it, away from p.
    pub(super) normal: Vector,
    /// How far p is from its plane; above 0.
    pub(super) height: f64,
    pub(super) sphere: Option<LightSphere>,
    /// What coordinates on the light may be off by.
    pub(super) room: f64,
}

/// The sphere itself.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightSphere {
    pub(super) center: Vector,
    pub(super) radius: f64,
    /// The square of the way from p to its rim.
    pub(super) power: f64,
}

/// A line of a view: start + s along, for s between two ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) start: Vector,
    pub(super) along: Vector,
    pub(super) ends: [f64; 2],
    /// How long it is to both sides, where no horizon cuts it.
    pub(super) semi: f64,
    /// Which one it is, −1 to 1.
    pub(super) row: f64,
    /// How fast the row changes.
    pub(super) slope: f64,
}

impl Line {
    pub(super) fn at(&self, s: f64) -> Vector {
        add(self.start, scale(self.along, s))
    }

    /// Where a linear function of the direction is 0.
    pub(super) fn zero_of(&self, normal: Vector, offset: f64) -> f64 {
        (offset - dot(normal, self.start)) / dot(normal, self.along)
    }

    /// Where it is nearest to p.
    pub(super) fn nearest(&self) -> f64 {
        let s = -dot(self.start, self.along) / dot(self.along, self.along);
        s.clamp(self.ends[0], self.ends[1])
    }

    /// Where its direction is nearest to another.
    pub(super) fn most_along(&self, way: Vector) -> f64 {
        let (at_start, by_along) = (dot(way, self.start), dot(way, self.along));
        let [square, mixed, other] = [
            dot(self.start, self.start),
            dot(self.start, self.along),
            dot(self.along, self.along),
        ];
        let [first, last] = self.ends;
        let s = (by_along * square - at_start * mixed) / (at_start * other - by_along * mixed);
        let inner = if s.is_finite() {
            s.clamp(first, last)
        } else {
            first
        };
        [first, last].into_iter().fold(inner, |best, s| {
            let is_better = cosine(way, self.at(s)) > cosine(way, self.at(best));
            if is_better { s } else { best }
        })
    }
}

/// The cosine between a unit vector and a direction of any length.
pub(super) fn cosine(way: Vector, direction: Vector) -> f64 {
    dot(way, direction) / length(direction)
}

impl View {
    /// `None` where the light does not shine to p, or p is on it.
    pub(super) fn new(area: &Area, from: WideVector) -> Option<Self> {
        let relative = |point: WideVector| subtract(point, from);
        match &area.shape {
            Shape::Rectangle {
                center,
                normal,
                halves,
            } => {
                let halves = halves.map(narrowed);
                Self::flat(area, from, *center, *normal, halves, false)
            }
            Shape::Disk {
                center,
                normal,
                radius,
            } => {
                let first = square_to(*normal)?;
                let second = cross(*normal, first);
                let halves = [first, second].map(|semi| narrowed(scale(semi, *radius)));
                Self::flat(area, from, *center, *normal, halves, true)
            }
            Shape::Sphere { center, radius } => {
                let way = relative(*center);
                let distance = length(way);
                let room = room([from, *center]) + ROUNDING * f64::EPSILON * radius.narrow();
                if (distance - *radius).narrow() <= room {
                    return None;
                }
                let power = (distance - *radius) * (distance + *radius);
                let normal = unit(way)?;
                let first = square_to(normal)?;
                let second = cross(normal, first);
                let rim = *radius * power.sqrt() / distance;
                let height = power / distance;
                Some(Self {
                    middle: narrowed(scale(normal, height)),
                    along: narrowed(scale(first, rim)),
                    across: narrowed(scale(second, rim)),
                    is_round: true,
                    normal: narrowed(normal),
                    height: height.narrow(),
                    sphere: Some(LightSphere {
                        center: narrowed(way),
                        radius: radius.narrow(),
                        power: power.narrow(),
                    }),
                    room,
                })
            }
            // Nothing else shines.
            Shape::Plane { .. } | Shape::Triangle { .. } => None,
        }
    }

    fn flat(
        area: &Area,
        from: WideVector,
        center: WideVector,
        normal: WideVector,
        [along, across]: [Vector; 2],
        is_round: bool,
    ) -> Option<Self> {
        let height = dot(normal, subtract(from, center)).narrow();
        let room = room([from, center]);
        if height.abs() <= room || !area.shines(height > 0.0) {
            return None;
        }
        let normal = narrowed(normal);
        Some(Self {
            middle: narrowed(subtract(center, from)),
            along,
            across,
            is_round,
            normal: if height > 0.0 { negate(normal) } else { normal },
            height: height.abs(),
            sphere: None,
            room,
        })
    }

    /// A line by a parameter in which its length is smooth.
    pub(super) fn line(&self, parameter: f64, horizon: Vector) -> Line {
        let (row, semi, slope) = if self.is_round {
            let (sin, cos) = parameter.sin_cos();
            (sin, cos.max(0.0), cos.max(0.0))
        } else {
            (parameter, 1.0, 1.0)
        };
        let mut line = Line {
            start: add(self.middle, scale(self.across, row)),
            along: self.along,
            ends: [-semi, semi],
            semi,
            row,
            slope,
        };
        let rises = dot(horizon, line.along);
        let at_start = dot(horizon, line.start);
        let zero = -at_start / rises;
        if zero.is_finite() {
            let end = usize::from(rises < 0.0);
            let clipped = zero.clamp(-semi, semi);
            line.ends[end] = if rises > 0.0 {
                clipped.max(line.ends[end])
            } else {
                clipped.min(line.ends[end])
            };
        } else if at_start <= 0.0 {
            line.ends = [0.0, 0.0];
        }
        line
    }

    /// The parameters of lines of which something is above the horizon, and between them those at which the ends of
    /// lines change their ways.
    pub(super) fn parameters(&self, horizon: Vector) -> Option<([f64; 2], Vec<f64>)> {
        let [middle, along, across] =
            [self.middle, self.along, self.across].map(|way| dot(horizon, way));
        let whole = if self.is_round {
            [-FRAC_PI_2, FRAC_PI_2]
        } else {
            [-1.0, 1.0]
        };
        let (range, corners) = if self.is_round {
            // middle + along cos q + across sin q = middle + most cos(q − q₀), and with −along.
            let most = along.hypot(across);
            if most <= middle {
                (whole, [f64::NAN; 4])
            } else if most <= -middle {
                return None;
            } else {
                let spread = (-middle / most).acos();
                let highest = across.atan2(along.abs());
                let other = across.atan2(-along.abs());
                let range = [highest - spread, highest + spread];
                let corners = [range[0], range[1], other - spread, other + spread];
                ([range[0].max(whole[0]), range[1].min(whole[1])], corners)
            }
        } else {
            let zeros = [along.abs(), -along.abs()].map(|along| -(middle + along) / across);
            let highest = middle + along.abs();
            let range = if across == 0.0 {
                if highest <= 0.0 {
                    return None;
                }
                whole
            } else if across > 0.0 {
                [zeros[0].max(-1.0), 1.0]
            } else {
                [-1.0, zeros[0].min(1.0)]
            };
            (range, [zeros[0], zeros[1], f64::NAN, f64::NAN])
        };
        let corners = corners
            .into_iter()
            .filter(|&q| q > range[0] && q < range[1])
            .collect();
        (range[0] < range[1]).then_some((range, corners))
    }

    /// The parameter of a row.
    pub(super) fn parameter(&self, row: f64) -> f64 {
        if self.is_round {
            row.clamp(-1.0, 1.0).asin()
        } else {
            row
        }
    }

    /// How many of a direction are the way to the light.
    pub(super) fn part_to(&self, direction: Vector) -> f64 {
        let Some(sphere) = &self.sphere else {
            return 1.0;
        };
        let along = dot(direction, sphere.center);
        let squared = along * along - dot(direction, direction) * sphere.power;
        sphere.power / (along + squared.max(0.0).sqrt())
    }

    /// dω/(ds d row) for a direction.
    pub(super) fn density(&self, direction: Vector) -> f64 {
        let area = length(cross(self.along, self.across));
        area * self.height / dot(direction, direction).powf(1.5)
    }
}

/// What coordinates of these sizes may be off by.
fn room(points: [WideVector; 2]) -> f64 {
    let sum: f64 = points.iter().map(|&point| length(point).narrow()).sum();
    ROUNDING * f64::EPSILON * sum
}

/// A unit vector square to another.
fn square_to(normal: WideVector) -> Option<WideVector> {
    let sizes = narrowed(normal).map(f64::abs);
    let least = (0..3).min_by(|&a, &b| sizes[a].total_cmp(&sizes[b]))?;
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let axis: [Wide; 3] = widened(axis);
    unit(cross(normal, axis))
}
