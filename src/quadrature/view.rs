//! The rays through a square of the image, as models.

use super::model::{Model, Vector};
use crate::camera::Camera;
use crate::math::DVec3;

/// A square of the image, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Square {
    pub(super) middle: [f64; 2],
    /// Half its side.
    pub(super) half: f64,
}

impl Square {
    /// Its quarters, row by row.
    pub(super) fn quarters(self) -> [Self; 4] {
        let half = self.half * 0.5;
        [[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]].map(|[u, v]| Self {
            middle: [self.middle[0] + u * half, self.middle[1] + v * half],
            half,
        })
    }
}

/// The primary rays through a square.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pub(super) origin: Vector,
    pub(super) direction: Vector,
    /// |ω|² and 1/|ω|
    pub(super) square: Model,
    pub(super) inverse: Model,
}

impl View {
    pub(super) fn new(camera: &Camera, square: Square) -> Self {
        let [x, y] = square.middle;
        let half = square.half;
        let middle = camera.ray(x, y);
        // Rays are linear in the place, so that differences are slopes.
        let along = |before: crate::math::Ray, after: crate::math::Ray| {
            let origin = (after.origin.0 - before.origin.0) * 0.5;
            let direction = (after.direction - before.direction) * 0.5;
            [origin, direction]
        };
        let across = along(camera.ray(x - half, y), camera.ray(x + half, y));
        let down = along(camera.ray(x, y - half), camera.ray(x, y + half));
        let origin = Vector::linear(middle.origin.0, [across[0], down[0]]);
        let direction = Vector::linear(middle.direction, [across[1], down[1]]);
        let square = direction.dot(direction);
        Self {
            origin,
            direction,
            square,
            inverse: square.root().reciprocal(),
        }
    }
}

/// How rays get to a plane, all from one side of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Approach {
    /// Of their origins over the plane: above 0.
    pub(super) height: Model,
    /// −n·ω: the distance is height/facing where that is above 0, elsewhere they do not get there.
    pub(super) facing: Model,
    /// n, on the side that they come from.
    pub(super) normal: DVec3,
}

impl Approach {
    pub(super) fn new(view: &View, point: DVec3, normal: DVec3) -> Option<Self> {
        let height = view.origin.minus(point).along(normal);
        let (height, normal) = if height.center < 0.0 {
            (-height, -normal)
        } else {
            (height, normal)
        };
        (height.least() > 0.0).then(|| Self {
            height,
            facing: -view.direction.along(normal),
            normal,
        })
    }

    /// Whether all rays get there.
    pub(super) fn is_met(&self) -> bool {
        self.facing.least() > 0.0
    }

    /// Where rays get there before they get to another plane: 1/t is facing/height, and larger of the nearer one.
    pub(super) fn before(&self, other: &Self) -> Model {
        self.facing * other.height - other.facing * self.height
    }
}
