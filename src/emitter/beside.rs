//! Which shapes may hide a part of an emitter, told soon.

use super::{Emitter, Gloss, Occluder, Surface};
use crate::math::{DVec3, Normal, Point};

/// What a point sees an emitter in: planes through the point around it, and a cone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sight {
    point: Point,
    horizon: DVec3,
    /// The emitter's plane, beyond which nothing hides it, and how far from the point that is.
    front: Option<(DVec3, f64)>,
    /// Around a rectangle: inside is where n·x ≥ 0.
    sides: Option<[DVec3; 4]>,
    /// Around the emitter: its axis of unit length, sine and cosine; `None` from within its bounding sphere.
    cone: Option<(DVec3, f64, f64)>,
}

/// More than rounding, of sines.
const ROOM: f64 = 1e-12;

/// A lobe that is below this everywhere on an emitter, as a power of e, adds nothing to a picture: 1e-30.
const DARK: f64 = -69.077_552_789_821_37;

impl Emitter {
    /// Whether a lobe is anywhere on it more than next to nothing.
    pub(crate) fn may_meet(&self, point: Point, gloss: &Gloss) -> bool {
        let center = self.center().from(point);
        let distance = center.length();
        let radius = match self.surface() {
            Surface::Rectangle([corner, ..]) => (corner - self.center().0).length(),
            Surface::Disk { radius, .. } | Surface::Sphere { radius } => radius,
        };
        let sine = radius / distance;
        let cosine = gloss.axis.get().dot(center) / distance;
        // From inside of the ball around it, or with its axis amid the ball, a lobe may be 1.
        if !(sine < 1.0 && cosine < (1.0 - sine * sine).sqrt()) {
            return true;
        }
        // cos(α − β) of the angles of the ball's center and of its radius.
        let nearest = cosine * (1.0 - sine * sine).sqrt() + (1.0 - cosine * cosine).sqrt() * sine;
        nearest > 0.0 && gloss.shininess * libm::log(nearest) > DARK
    }

    /// How a point sees it.
    pub(crate) fn sight(&self, point: Point, horizon: Normal) -> Sight {
        let center = self.center().from(point);
        let front = self.normal().map(|normal| {
            let height = normal.get().dot(center);
            (normal.get() * height.signum(), height.abs())
        });
        let mut sides = None;
        let radius = match self.surface() {
            Surface::Rectangle(corners) => {
                let corners = corners.map(|corner| corner - point.0);
                let side = |from: usize, to: usize| {
                    let normal = corners[from].cross(corners[to] - corners[from]);
                    if normal.dot(center) < 0.0 {
                        -normal
                    } else {
                        normal
                    }
                };
                sides = Some([side(0, 1), side(1, 2), side(2, 3), side(3, 0)]);
                (corners[0] - center).length()
            }
            Surface::Disk { radius, .. } | Surface::Sphere { radius } => radius,
        };
        let distance = center.length();
        let sine = radius / distance;
        let cone = (sine < 1.0).then(|| (center / distance, sine, (1.0 - sine * sine).sqrt()));
        Sight {
            point,
            horizon: horizon.get(),
            front,
            sides,
            cone,
        }
    }
}

impl Sight {
    /// Whether a shape may hide a part of the emitter: not where it is below the horizon, beyond the emitter's plane
    /// or beside all ways to it.
    pub(crate) fn may_be_hidden_by(&self, occluder: &Occluder) -> bool {
        match *occluder {
            Occluder::Triangle(corners) => self.may_be_hidden_by_triangle(corners),
            Occluder::Ball { center, radius } | Occluder::Disk { center, radius, .. } => {
                self.may_be_hidden_by_ball(center - self.point.0, radius)
            }
            Occluder::Plane { .. } => true,
        }
    }

    fn may_be_hidden_by_triangle(&self, corners: [DVec3; 3]) -> bool {
        let [a, b, c] = corners.map(|corner| corner - self.point.0);
        let all = |normal: DVec3, most: f64| {
            normal.dot(a) <= most && normal.dot(b) <= most && normal.dot(c) <= most
        };
        if all(self.horizon, 0.0) {
            return false;
        }
        if let Some((normal, distance)) = self.front
            && all(-normal, -distance)
        {
            return false;
        }
        if let Some(sides) = &self.sides
            && sides.iter().any(|&side| all(side, 0.0))
        {
            return false;
        }
        let Some((axis, sine, _)) = self.cone else {
            return true;
        };
        let normal = (b - a).cross(c - a);
        let sign = normal.dot(a);
        let is_outside = |from: DVec3, to: DVec3| {
            // The plane through an edge, its normal towards the triangle.
            let plane = from.cross(to) * sign;
            plane.dot(axis) < -(sine + ROOM) * plane.length()
        };
        !(is_outside(a, b) || is_outside(b, c) || is_outside(c, a))
    }

    fn may_be_hidden_by_ball(&self, center: DVec3, radius: f64) -> bool {
        if self.horizon.dot(center) <= -radius {
            return false;
        }
        if let Some((normal, distance)) = self.front
            && normal.dot(center) - radius >= distance
        {
            return false;
        }
        let distance = center.length();
        let Some((axis, sine, cosine)) = self.cone.filter(|_| distance > radius) else {
            return true;
        };
        // The angle between the axes is more than both half-angles together.
        let of_ball = radius / distance;
        let cos_ball = (1.0 - of_ball * of_ball).sqrt();
        let cos_sum = cosine * cos_ball - sine * of_ball;
        axis.dot(center) >= (cos_sum - ROOM) * distance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dark_is_1e_30() {
        assert!((DARK - 1e-30_f64.ln()).abs() < 1e-13);
    }
}
