//! What the rays of one pixel, and the shadow rays from what they meet, may meet at all: so that of large meshes
//! not every triangle is asked for every ray. In f64, with room for its rounding.

use super::super::surface::{Shape, Surface};
use super::super::vector::{Vector, add, dot, length, narrowed, scale, subtract};
use super::super::wide::Real;
use super::super::{Oracle, Place};
use crate::scene::ShadowTerminator;

/// Far more than f64 is off, relative to coordinates.
const ROOM: f64 = 1e-9;

/// A sphere around a surface, or a part of one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    pub(super) center: Vector,
    pub(super) radius: f64,
}

impl Ball {
    /// Around a surface; `None` around a plane.
    pub(super) fn around(surface: &Surface) -> Option<Self> {
        match &surface.shape {
            Shape::Sphere { center, radius } => {
                let center = narrowed(*center);
                let radius = radius.narrow() * (1.0 + ROOM);
                Some(Self { center, radius })
            }
            Shape::Disk { center, radius, .. } => {
                let center = narrowed(*center);
                let radius = radius.narrow() * (1.0 + ROOM);
                Some(Self { center, radius })
            }
            Shape::Rectangle { center, halves, .. } => {
                let center = narrowed(*center);
                let [a, b] = halves.map(|semi| length(narrowed(semi)));
                let radius = a.hypot(b) * (1.0 + ROOM);
                Some(Self { center, radius })
            }
            Shape::Plane { .. } => None,
            Shape::Triangle { vertices, .. } => Some(Self::around_points(&vertices.map(narrowed))),
        }
    }

    fn around_points(points: &[Vector]) -> Self {
        let sum = points.iter().fold([0.0; 3], |sum, &point| add(sum, point));
        let center = scale(sum, 1.0 / points.len() as f64);
        let from_center = |&point: &Vector| length(subtract(point, center));
        let radius = points.iter().map(from_center).fold(0.0, f64::max);
        Self {
            center,
            radius: radius * (1.0 + ROOM),
        }
    }

    fn magnitude(&self) -> f64 {
        length(self.center) + self.radius
    }
}

/// All rays of a pixel: within a cone, or a cylinder.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beam {
    origin: Vector,
    /// Of unit length.
    axis: Vector,
    /// Half its width at the origin, and how much wider it gets on the way.
    half_width: f64,
    tangent: f64,
    /// The rays through the pixel's corners: their origins and directions.
    corners: [[Vector; 2]; 4],
}

impl Beam {
    /// Of the square from (`x`, `y`) to (`x` + 1, `y` + 1).
    pub(super) fn new(oracle: &Oracle, x: f64, y: f64) -> Self {
        let ray = |px: f64, py: f64| {
            let ray = oracle.camera.primary_ray(px, py);
            [narrowed(ray.origin), narrowed(ray.direction)]
        };
        let [origin, axis] = ray(x + 0.5, y + 0.5);
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let corners = corners.map(|[u, v]| ray(x + u, y + v));
        let largest = |of: &dyn Fn(&[Vector; 2]) -> f64| corners.iter().map(of).fold(0.0, f64::max);
        Self {
            origin,
            axis,
            half_width: largest(&|[from, _]| length(subtract(*from, origin))) * (1.0 + 1e-6),
            tangent: largest(&|[_, along]| {
                let cos = dot(*along, axis);
                length(subtract(*along, scale(axis, cos))) / cos
            }) * (1.0 + 1e-6),
            corners,
        }
    }

    /// Whether a ray may meet something within a ball.
    fn may_meet(&self, ball: &Ball) -> bool {
        let way = subtract(ball.center, self.origin);
        let along = dot(way, self.axis);
        let across = length(subtract(way, scale(self.axis, along)));
        let room = ROOM * (ball.magnitude() + length(self.origin));
        let slant = (1.0 + self.tangent * self.tangent).sqrt();
        along > -ball.radius - room
            && across
                <= self.half_width + along.max(0.0) * self.tangent + ball.radius * slant + room
    }

    /// A ball around what of a surface rays may meet; `None` where that has no end.
    pub(super) fn part_of(&self, surface: &Surface, ball: Option<&Ball>) -> Option<Ball> {
        let on_plane = match &surface.shape {
            Shape::Sphere { .. } => None,
            // A light reflects nothing: no shadow rays start there.
            Shape::Rectangle { .. } | Shape::Disk { .. } => None,
            Shape::Plane { point, normal } => self.on_plane(narrowed(*point), narrowed(*normal)),
            Shape::Triangle {
                vertices, normal, ..
            } => self.on_plane(narrowed(vertices[0]), narrowed(*normal)),
        };
        match (on_plane, ball) {
            (Some(part), Some(&whole)) if part.radius < whole.radius => Some(part),
            (_, Some(&whole)) => Some(whole),
            (part, None) => part,
        }
    }

    /// A ball around what of a plane rays meet.
    fn on_plane(&self, point: Vector, normal: Vector) -> Option<Ball> {
        let mut hits = [[0.0; 3]; 4];
        for (hit, [origin, direction]) in hits.iter_mut().zip(&self.corners) {
            let slope = dot(normal, *direction);
            let t = dot(normal, subtract(point, *origin)) / slope;
            // Near the horizon f64 does not know where.
            if !(t > 0.0 && t.is_finite() && slope.abs() > 1e-6) {
                return None;
            }
            *hit = add(*origin, scale(*direction, t));
        }
        let ball = Ball::around_points(&hits);
        Some(Ball {
            radius: ball.radius * (1.0 + 1e-3) + ROOM * ball.magnitude(),
            ..ball
        })
    }
}

/// The surfaces that rays of a beam may meet.
pub(super) fn met(balls: &[Option<Ball>], beam: &Beam) -> Vec<usize> {
    let balls = balls.iter().enumerate();
    balls
        .filter_map(|(index, ball)| {
            let may_meet = ball.is_none_or(|ball| beam.may_meet(&ball));
            may_meet.then_some(index)
        })
        .collect()
}

/// The surfaces that may be between a part of one, where shadow rays start, and a light, whose points are as far as
/// `reach` from its middle.
pub(super) fn between(
    balls: &[Option<Ball>],
    surface: &Surface,
    part: Option<Ball>,
    light: Place,
    reach: f64,
) -> Vec<usize> {
    let Some(part) = part else {
        return (0..balls.len()).collect();
    };
    let lifted = match surface.shadow_terminator {
        ShadowTerminator::Geometric => 0.0,
        // The way off the triangle is no longer than to the corner that is farthest away.
        ShadowTerminator::Hanika => match Ball::around(surface) {
            Some(whole) => 2.0 * whole.radius,
            None => 0.0,
        },
    };
    let from = part.center;
    let (way, farthest, size) = match light {
        Place::At(light) => {
            let light = narrowed(light);
            (subtract(light, from), 1.0, length(from) + length(light))
        }
        Place::Toward(way) => (narrowed(way), f64::INFINITY, length(from)),
    };
    let squared = dot(way, way);
    let stands_between = |ball: &Ball| {
        let to_ball = subtract(ball.center, from);
        let along = if squared > 0.0 {
            (dot(to_ball, way) / squared).clamp(0.0, farthest)
        } else {
            0.0
        };
        let across = length(subtract(to_ball, scale(way, along)));
        across <= part.radius + lifted + reach + ball.radius + ROOM * (size + ball.magnitude())
    };
    let balls = balls.iter().enumerate();
    balls
        .filter_map(|(index, ball)| {
            ball.is_none_or(|ball| stands_between(&ball))
                .then_some(index)
        })
        .collect()
}
