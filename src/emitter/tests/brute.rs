//! What is received past occluders by brute force: from many points, each of which is seen or not.

use super::super::{Emitter, Occluder, Received, Receiver};
use super::cubature::axes_across;
use super::fuzz::Random;
use super::normal;
use crate::math::{DVec3, Point};

/// What is received, and its error, from points spread evenly over the emitter; whether each is seen is asked of
/// the shapes themselves.
pub(super) struct Brute<'a> {
    pub(super) emitter: &'a TestEmitter,
    pub(super) point: DVec3,
    pub(super) receiver: &'a Receiver,
    pub(super) occluders: &'a [Occluder],
}

#[derive(Clone, Copy, Debug)]
pub(super) enum TestEmitter {
    Rectangle(DVec3, [DVec3; 2]),
    Disk(DVec3, DVec3, f64),
    Sphere(DVec3, f64),
}

impl TestEmitter {
    pub(super) fn emitter(&self) -> Emitter {
        match *self {
            Self::Rectangle(center, halves) => Emitter::rectangle(Point(center), halves, true),
            Self::Disk(center, facing, radius) => {
                Emitter::disk(Point(center), normal(facing), radius, true)
            }
            Self::Sphere(center, radius) => Emitter::sphere(Point(center), radius),
        }
        .unwrap()
    }
}

/// Whether there is something on the way, ends left out.
fn is_blocked(from: DVec3, to: DVec3, occluder: &Occluder) -> bool {
    let way = to - from;
    let meets = |place: DVec3, normal: DVec3| {
        let t = normal.dot(place - from) / normal.dot(way);
        (t > 1e-9 && t < 1.0 - 1e-9).then(|| from + way * t)
    };
    match *occluder {
        Occluder::Triangle([a, b, c]) => {
            let normal = (b - a).cross(c - a);
            meets(a, normal).is_some_and(|hit| {
                [(a, b), (b, c), (c, a)]
                    .iter()
                    .all(|(a, b)| normal.dot((b - a).cross(hit - a)) >= 0.0)
            })
        }
        Occluder::Plane { point, normal } => meets(point, normal).is_some(),
        Occluder::Disk {
            center,
            normal,
            radius,
        } => meets(center, normal).is_some_and(|hit| (hit - center).length() <= radius),
        Occluder::Ball { center, radius } => {
            let (a, b) = (way.length_squared(), way.dot(from - center));
            let c = (from - center).length_squared() - radius * radius;
            let square = b * b - a * c;
            let [near, far] = [-1.0, 1.0].map(|sign| (-b + sign * square.sqrt()) / a);
            if c < 0.0 {
                far < 1.0 - 1e-9
            } else {
                square > 0.0 && far > 0.0 && near > 0.0 && near < 1.0 - 1e-9
            }
        }
    }
}

impl Brute<'_> {
    /// Of so many points in each of two directions.
    pub(super) fn received(&self, count: u32) -> Received {
        let step = 1.0 / f64::from(count);
        let mut sum = Received::default();
        let mut random = Random(u64::from(count));
        for row in 0..count {
            for column in 0..count {
                let [s, t] = [row, column].map(|i| (f64::from(i) + random.within(0.0, 1.0)) * step);
                self.add(s, t, step * step, &mut sum);
            }
        }
        sum
    }

    fn add(&self, s: f64, t: f64, part: f64, sum: &mut Received) {
        let turned = |radius: f64| {
            let (sin, cos) = (std::f64::consts::TAU * t).sin_cos();
            [cos * radius, sin * radius]
        };
        let (place, solid_angle) = match *self.emitter {
            TestEmitter::Rectangle(center, [a, b]) => {
                let place = center + a * (2.0 * s - 1.0) + b * (2.0 * t - 1.0);
                let way = place - self.point;
                let across = a.cross(b) * 4.0;
                (place, across.dot(way).abs() / way.length().powi(3))
            }
            TestEmitter::Disk(center, facing, radius) => {
                let [x, y] = axes_across(facing);
                let [cos, sin] = turned(radius * s.sqrt());
                let place = center + x * cos + y * sin;
                let way = place - self.point;
                let across = facing * (std::f64::consts::PI * radius * radius);
                (place, across.dot(way).abs() / way.length().powi(3))
            }
            TestEmitter::Sphere(center, radius) => {
                let to_center = center - self.point;
                let distance = to_center.length();
                let axis = to_center / distance;
                let [x, y] = axes_across(axis);
                let sine = radius / distance;
                let height = sine * sine / (1.0 + (1.0 - sine * sine).sqrt());
                let cos = 1.0 - s * height;
                let [along_x, along_y] = turned((1.0 - cos * cos).sqrt());
                let u = axis * cos + x * along_x + y * along_y;
                let middle = u.dot(to_center);
                let beside = (to_center - u * middle).length();
                let near = middle - ((radius - beside) * (radius + beside)).max(0.0).sqrt();
                (self.point + u * near, std::f64::consts::TAU * height)
            }
        };
        let u = (place - self.point).normalize();
        let horizon = self.receiver.horizon.get();
        let is_seen = |occluder| !is_blocked(self.point, place, occluder);
        if horizon.dot(u) <= 0.0 || !self.occluders.iter().all(is_seen) {
            return;
        }
        let solid_angle = solid_angle * part;
        let cosine = self.receiver.normal.get().dot(u).max(0.0);
        sum.solid_angle += solid_angle;
        sum.irradiance += solid_angle * cosine;
        if let Some(gloss) = self.receiver.gloss {
            let power = gloss.axis.get().dot(u).max(0.0).powf(gloss.shininess);
            let factor = if gloss.has_cosine { cosine } else { 1.0 };
            sum.lobe += solid_angle * power * factor;
        }
    }
}
