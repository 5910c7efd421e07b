//! What stands between a point and an emitter, as a set of directions.
//!
//! With the emitter's front, a plane across which the point sees it (its own plane; of a sphere, that of the circle
//! where it is touched), any opaque shape blocks the directions within planes through the point, within an elliptic
//! cone, and outside of another, its hole: exactly, however the shape cuts the emitter.
//!
//! Along a direction u a plane n·x = d is met at d/(n·u). So of two planes in front of the point the first is met
//! before the second where (d₂ n₁ − d₁ n₂)·u > 0.

use super::clip::{across, l1};
use super::conic::{Conic, WholeCone};
use crate::math::{DVec3, Point};

/// An opaque shape, where the emitter is.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Occluder {
    Triangle([DVec3; 3]),
    Ball {
        center: DVec3,
        radius: f64,
    },
    Disk {
        center: DVec3,
        normal: DVec3,
        radius: f64,
    },
    Plane {
        point: DVec3,
        normal: DVec3,
    },
}

/// So many corners a triangle has that a plane has cut.
pub(super) const MOST_EDGES: usize = 4;

/// How coordinates are rounded, relative to the largest: some times 2⁻⁵³.
const ROUNDINGS: f64 = 8.0 * f64::EPSILON / 2.0;

/// A point that looks at an emitter.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pub(super) point: Point,
    /// How far the point may be from where it is meant to be.
    pub(super) error: f64,
    pub(super) front: Plane,
    /// The center and the radius of a sphere.
    pub(super) ball: Option<(DVec3, f64)>,
}

/// Where n·x = d, x from the point on; d is not negative, n of unit length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    pub(super) normal: DVec3,
    pub(super) distance: f64,
}

/// A set of directions that are blocked: within all planes and the cone, but not within the hole.
#[derive(Clone, Copy, Debug)]
pub(super) struct Blocker {
    /// Inside is where n·u ≥ 0.
    pub(super) planes: [DVec3; MOST_EDGES],
    pub(super) count: usize,
    /// The corners of what has as many as planes.
    pub(super) corners: Option<[DVec3; MOST_EDGES]>,
    pub(super) cone: Option<WholeCone>,
    pub(super) hole: Option<WholeCone>,
}

impl Occluder {
    fn is_solid(&self) -> bool {
        match self {
            Self::Triangle(corners) => corners.iter().all(|corner| corner.is_finite()),
            Self::Plane { point, normal } => point.is_finite() && normal.is_finite(),
            Self::Ball { center, radius } => {
                center.is_finite() && *radius > 0.0 && radius.is_finite()
            }
            Self::Disk {
                center,
                normal,
                radius,
            } => {
                let is_flat = center.is_finite() && normal.is_finite();
                is_flat && *radius > 0.0 && radius.is_finite()
            }
        }
    }
}

impl Plane {
    /// The plane through a place, its normal turned away from the point. `None` where it is closer than that.
    fn new(place: DVec3, normal: DVec3, least: f64) -> Option<Self> {
        let normal = normal / normal.length();
        let distance = normal.dot(place);
        // What is no number is no plane.
        (distance.abs() > least).then(|| Self {
            normal: normal * distance.signum(),
            distance: distance.abs(),
        })
    }

    /// Where this is met before the other.
    fn before(self, other: Self) -> DVec3 {
        self.normal * other.distance - other.normal * self.distance
    }

    /// How far beyond this a place is.
    fn height(self, place: DVec3) -> f64 {
        self.normal.dot(place) - self.distance
    }

    /// Where it cuts a ball, as it is seen from the point. `None` where it does not, or is seen as a line.
    fn section(self, (center, radius): (DVec3, f64)) -> Option<WholeCone> {
        let height = self.height(center);
        let square = (radius - height) * (radius + height);
        let middle = center - self.normal * height;
        let section =
            (square > 0.0).then(|| Conic::of_disk(middle, self.normal, square.sqrt()))??;
        Some(section.whole())
    }

    /// Where lines from the point touch a ball.
    pub(super) fn polar((center, radius): (DVec3, f64)) -> Self {
        let length = center.length();
        Self {
            normal: center / length,
            distance: ((length - radius) * (length + radius)).max(0.0) / length,
        }
    }
}

impl Blocker {
    const ALL: Self = Self {
        planes: [DVec3::ZERO; MOST_EDGES],
        count: 0,
        corners: None,
        cone: None,
        hole: None,
    };

    fn within(plane: DVec3) -> Self {
        let mut blocker = Self::ALL;
        blocker.planes[0] = plane;
        blocker.count = 1;
        blocker
    }

    fn of_cone(cone: WholeCone) -> Self {
        Self {
            cone: Some(cone),
            ..Self::ALL
        }
    }

    pub(super) fn planes(&self) -> &[DVec3] {
        &self.planes[..self.count]
    }

    /// Whether it blocks a direction.
    pub(super) fn blocks(&self, way: DVec3) -> bool {
        self.planes().iter().all(|plane| plane.dot(way) >= 0.0)
            && self.cone.is_none_or(|cone| cone.holds(way))
            && !self.hole.is_some_and(|hole| hole.holds(way))
    }

    pub(super) fn is_straight(&self) -> bool {
        self.cone.is_none() && self.hole.is_none()
    }
}

impl View {
    /// Of an occluder, what it blocks: at most two sets of directions. What has no size or no place blocks nothing.
    pub(super) fn blocked_by(&self, occluder: &Occluder) -> [Option<Blocker>; 2] {
        if !occluder.is_solid() {
            return [None, None];
        }
        let from = |place: DVec3| place - self.point.0;
        match *occluder {
            Occluder::Triangle(corners) => [self.triangle(corners), None],
            Occluder::Plane { point, normal } => {
                let plane = Plane::new(from(point), normal, self.least(&[point]));
                [plane.and_then(|plane| self.plane(plane)), None]
            }
            Occluder::Disk {
                center,
                normal,
                radius,
            } => {
                let least = self.least(&[center]) + ROUNDINGS * radius;
                let plane = Plane::new(from(center), normal, least);
                let disk = plane.and_then(|plane| self.disk(plane, from(center), radius, least));
                [disk, None]
            }
            Occluder::Ball { center, radius } => {
                let least = self.least(&[center]) + ROUNDINGS * radius;
                self.ball((from(center), radius), least)
            }
        }
    }

    /// What is closer is there, as far as anybody knows.
    fn least(&self, places: &[DVec3]) -> f64 {
        let largest = places.iter().fold(self.point.0.abs(), |largest, place| {
            largest.max(place.abs())
        });
        self.error + ROUNDINGS * largest.max_element()
    }

    fn triangle(&self, places: [DVec3; 3]) -> Option<Blocker> {
        let corners = places.map(|place| place - self.point.0);
        let [a, b, c] = corners;
        let least = self.least(&places);
        let plane = Plane::new(a, (b - a).cross(c - a), least)?;
        let mut hole = None;
        let is_cut;
        if let Some(ball) = self.ball {
            let height = plane.height(ball.0);
            if height <= -ball.1 {
                return None;
            }
            // Of one whose plane cuts the sphere, what is before where that is touched is before all of it, except
            // what is inside.
            is_cut = height < ball.1;
            if is_cut && is_triangle_near(corners, ball, height) {
                hole = plane.section(ball);
            }
        } else {
            is_cut = corners
                .iter()
                .any(|&corner| self.front.height(corner) > -least);
        }
        let mut kept = [DVec3::ZERO; MOST_EDGES];
        let mut count = 0;
        if is_cut {
            let height = |corner: DVec3| -(self.front.height(corner) + least);
            for place in 0..3 {
                let (from, to) = (corners[place], corners[(place + 1) % 3]);
                let [start, end] = [from, to].map(height);
                if start > 0.0 {
                    kept[count] = from;
                    count += 1;
                }
                // From the end that is before, so that two triangles with this edge have the same crossing.
                if start > 0.0 && end <= 0.0 {
                    kept[count] = from + (to - from) * (start / (start - end));
                    count += 1;
                } else if start <= 0.0 && end > 0.0 {
                    kept[count] = to + (from - to) * (end / (end - start));
                    count += 1;
                }
            }
        } else {
            kept[..3].copy_from_slice(&corners);
            count = 3;
        }
        if count < 3 {
            return None;
        }
        // Against the clock as they are seen from the point.
        if (b - a).cross(c - a).dot(plane.normal) < 0.0 {
            kept[..count].reverse();
        }
        let mut blocker = Blocker {
            count,
            corners: Some(kept),
            hole,
            ..Blocker::ALL
        };
        for place in 0..count {
            blocker.planes[place] = edge_plane(kept[place], kept[(place + 1) % count]);
        }
        Some(blocker)
    }

    fn plane(&self, plane: Plane) -> Option<Blocker> {
        let mut blocker = Blocker::within(plane.before(self.front));
        if let Some(ball) = self.ball {
            let height = plane.height(ball.0);
            if height <= -ball.1 {
                return None;
            }
            if height >= ball.1 {
                return Some(Blocker::ALL);
            }
            blocker.hole = plane.section(ball);
            return Some(blocker);
        }
        // Of the emitter's own plane nothing is left but rounding.
        let largest = plane.distance.max(self.front.distance);
        let rounding = 4.0 * self.least(&[]) + 16.0 * f64::EPSILON * largest;
        (l1(blocker.planes[0]) > rounding).then_some(blocker)
    }

    fn disk(&self, plane: Plane, center: DVec3, radius: f64, least: f64) -> Option<Blocker> {
        let mut blocker = Blocker::of_cone(Conic::of_disk(center, plane.normal, radius)?.whole());
        if let Some(ball) = self.ball {
            let height = plane.height(ball.0);
            if height <= -ball.1 {
                return None;
            }
            if height < ball.1 {
                blocker.planes[0] = plane.before(self.front);
                blocker.count = 1;
                let foot = ball.0 - plane.normal * height;
                let beside = ((foot - center).length() - radius).max(0.0);
                if libm::hypot(beside, height) < ball.1 {
                    blocker.hole = plane.section(ball);
                }
            }
            return Some(blocker);
        }
        let height = self.front.height(center);
        let half = radius * plane.normal.cross(self.front.normal).length();
        if height - half >= -least {
            return None;
        }
        if height + half > -least {
            blocker.planes[0] = plane.before(self.front);
            blocker.count = 1;
        }
        Some(blocker)
    }

    fn ball(&self, ball: (DVec3, f64), least: f64) -> [Option<Blocker>; 2] {
        let (center, radius) = ball;
        let apart = center.length() - radius;
        if apart.abs() <= least {
            // The point is on it, and it is below its own tangent plane.
            return [Some(Blocker::within(center)), None];
        }
        if let Some(light) = self.ball {
            return self.ball_at_sphere(ball, light, least);
        }
        let section = || self.front.section(ball);
        let height = self.front.height(center);
        if apart < 0.0 {
            // From inside there is to be seen what is inside.
            let hole = section();
            return [
                Some(Blocker {
                    hole,
                    ..Blocker::ALL
                }),
                None,
            ];
        }
        if height - radius >= -least {
            return [None, None];
        }
        let cone = Conic::of_sphere(center, radius).map(|cone| cone.whole());
        if height + radius <= 0.0 {
            return [cone.map(Blocker::of_cone), None];
        }
        self.cut_ball(Plane::polar(ball).before(self.front), cone, section())
    }

    /// Of a ball that the front cuts: its cone where it is touched before the front, and elsewhere the section.
    fn cut_ball(
        &self,
        before: DVec3,
        cone: Option<WholeCone>,
        section: Option<WholeCone>,
    ) -> [Option<Blocker>; 2] {
        let part = |plane: DVec3, cone: WholeCone| Blocker {
            cone: Some(cone),
            ..Blocker::within(plane)
        };
        [
            cone.map(|cone| part(before, cone)),
            section.map(|section| part(-before, section)),
        ]
    }

    /// Of two balls, that of which the point has the shorter tangents is in front, unless they cut each other: then
    /// the plane of the circle in which they do takes the part of the front.
    fn ball_at_sphere(
        &self,
        ball: (DVec3, f64),
        light: (DVec3, f64),
        least: f64,
    ) -> [Option<Blocker>; 2] {
        let power = |(center, radius): (DVec3, f64)| {
            let length = center.length();
            (length - radius) * (length + radius)
        };
        let between = ball.0 - light.0;
        let distance = between.length();
        let difference = power(ball) - power(light);
        let is_inside = power(ball) < 0.0;
        if distance + ball.1 <= light.1 + least {
            return [None, None];
        }
        if distance + light.1 <= ball.1 {
            let is_all = !is_inside;
            return [is_all.then_some(Blocker::ALL), None];
        }
        let cone = Conic::of_sphere(ball.0, ball.1).map(|cone| cone.whole());
        if distance >= ball.1 + light.1 {
            if is_inside {
                return [Some(Blocker::ALL), None];
            }
            let cone = cone.filter(|_| difference < 0.0);
            return [cone.map(Blocker::of_cone), None];
        }
        let offset = difference / (2.0 * distance);
        let side = if offset > 0.0 { 1.0 } else { -1.0 };
        let circle = Plane {
            normal: between * (side / distance),
            distance: offset.abs(),
        };
        // From the light's center, where fewer digits cancel.
        let along = 0.5 * (distance + (light.1 - ball.1) * ((light.1 + ball.1) / distance));
        let square = (light.1 - along) * (light.1 + along);
        let middle = light.0 + between * (along / distance);
        let section = || {
            let section =
                (square > 0.0).then(|| Conic::of_disk(middle, circle.normal, square.sqrt()))??;
            Some(section.whole())
        };
        if difference < 0.0 && !is_inside {
            return self.cut_ball(Plane::polar(ball).before(circle), cone, section());
        }
        // Of the light there is to be seen what is before the circle's plane, and what is seen through it; where it
        // is the ball that is behind, its cone holds all the rest.
        let blocker = Blocker {
            hole: section(),
            ..Blocker::within(-self.front.before(circle))
        };
        [Some(blocker), None]
    }
}

/// Whether a triangle is closer to a center than a radius, of which its plane is so far.
fn is_triangle_near(corners: [DVec3; 3], (center, radius): (DVec3, f64), height: f64) -> bool {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let mut is_above = true;
    for place in 0..3 {
        let (from, to) = (corners[place], corners[(place + 1) % 3]);
        let edge = to - from;
        let to_center = center - from;
        is_above &= normal.dot(edge.cross(to_center)) >= 0.0;
        let along = (edge.dot(to_center) / edge.length_squared()).clamp(0.0, 1.0);
        if (to_center - edge * along).length_squared() < radius * radius {
            return true;
        }
    }
    is_above && height.abs() < radius
}

/// The plane through an edge and the point, to the bit the opposite of that of the same edge the other way round, so
/// that between two triangles there is no gap.
fn edge_plane(from: DVec3, to: DVec3) -> DVec3 {
    if from.to_array() <= to.to_array() {
        across(from, to)
    } else {
        -across(to, from)
    }
}
