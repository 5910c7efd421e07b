//! Thin panes before lights with an area.

use std::f64::consts::FRAC_PI_2;

use super::geometry::area_vector;
use super::{Delta, Shape, World};
use crate::emitter::{Accuracy, Emitter, Occluder, Panes, Received, Receiver, ShadowSpace, Untold};
use crate::math::{DVec3, Point};
use crate::optics;

/// Of the angle at which a ball is seen, the part within which T is a smooth function.
const INNER: f64 = 0.95;

/// The panes through which a light with an area is seen from a point.
#[derive(Debug, Default)]
pub(crate) struct PanesBefore {
    flat: Vec<Occluder>,
    /// A vector across each of the flat ones, and its index of refraction.
    across: Vec<(DVec3, f64)>,
    /// Balls that all of the light is seen through.
    balls: Vec<Ball>,
    /// Whether there are balls that a part of the light is seen through.
    has_border: bool,
}

/// A ball of a thin pane, as it is seen from a point.
#[derive(Clone, Copy, Debug)]
struct Ball {
    /// To its center.
    axis: DVec3,
    /// How far the center is, over the radius.
    distance: f64,
    /// How often its surface is crossed: once from within or to within, else twice.
    crossings: i32,
    n: f64,
}

/// How a ball is before a light.
enum Before {
    Nothing,
    All(Ball),
    Part,
}

/// What is received past all that stands before a light.
pub(crate) struct Past {
    /// `None` where it is nothing.
    pub(crate) received: Option<Received>,
    /// Whether there are panes of which nothing has been taken away.
    pub(crate) is_undimmed: bool,
}

impl PanesBefore {
    pub(crate) fn clear(&mut self) {
        self.flat.clear();
        self.across.clear();
        self.balls.clear();
        self.has_border = false;
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.flat.is_empty() && self.balls.is_empty() && !self.has_border
    }

    /// A pane that is this object, or a triangle of it, before a light that is seen from a point.
    pub(crate) fn add(
        &mut self,
        world: &World,
        [object, triangle]: [u32; 2],
        occluder: Occluder,
        (emitter, point): (&Emitter, Point),
    ) {
        let object = &world.objects()[object as usize];
        let Some(Delta::Pane { n }) = world.delta(object.material) else {
            return;
        };
        let across = match object.shape {
            Shape::Sphere(index) => {
                let sphere = &world.spheres()[index];
                match Ball::before(sphere.center, sphere.radius, *n, emitter, point) {
                    Before::Nothing => {}
                    Before::All(ball) => self.balls.push(ball),
                    Before::Part => self.has_border = true,
                }
                return;
            }
            Shape::Plane(index) => world.planes()[index].normal.get(),
            Shape::Disk(index) => world.disks()[index].normal.get(),
            Shape::Mesh(_) => area_vector(world.triangles().vertices(triangle)),
        };
        self.flat.push(occluder);
        self.across.push((across.normalize_or_zero(), *n));
    }

    /// What is received past opaque shapes and through these. Where a part of the light is seen through a ball, or there
    /// are very many, they are left to rays.
    pub(crate) fn received(
        &self,
        emitter: &Emitter,
        (point, error): (Point, f64),
        receiver: &Receiver,
        occluders: &[Occluder],
        accuracy: &Accuracy,
        space: &mut ShadowSpace,
    ) -> Past {
        let panes = Panes {
            shapes: &self.flat,
            whole: self.balls.len(),
            normal: &|pane| match self.across.get(pane) {
                Some((across, _)) => *across,
                None => self.balls[pane - self.across.len()].axis,
            },
            transmittance: &|pane, way| self.transmittance(pane, way),
        };
        let through = if self.is_empty() || self.has_border {
            Err(Untold)
        } else {
            emitter.received_through(point, receiver, occluders, &panes, error, accuracy, space)
        };
        let is_undimmed = through.is_err() && !self.is_empty();
        let seen = through.unwrap_or_else(|Untold| {
            emitter.received_past(point, receiver, occluders, error, accuracy, space)
        });
        Past {
            received: seen.map(|seen| seen.value),
            is_undimmed,
        }
    }

    /// T along a direction of any length.
    fn transmittance(&self, pane: usize, way: DVec3) -> f64 {
        let Some(&(across, n)) = self.across.get(pane) else {
            return self.balls[pane - self.across.len()].transmittance(way);
        };
        let cosine = (across.dot(way) / way.length()).abs().min(1.0);
        let [_, transmittance] = optics::pane(cosine, n);
        transmittance
    }
}

impl Ball {
    /// The light counts as the ball around it.
    fn before(center: Point, radius: f64, n: f64, emitter: &Emitter, point: Point) -> Before {
        let to_center = center.from(point);
        let distance = to_center.length();
        let [least, most] = emitter.bounds();
        let light = emitter.center();
        let reach = 0.5 * (most - least).length();
        let apart = (light.0 - center.0).length();
        let (is_within, is_light_within) = (distance < radius, apart + reach < radius);
        let is_light_outside = apart - reach > radius;
        let ball = |crossings| {
            Before::All(Self {
                axis: to_center.normalize_or(DVec3::Z),
                distance: distance / radius,
                crossings,
                n,
            })
        };
        let to_light = light.from(point);
        let far = to_light.length();
        if far <= reach {
            return Before::Part;
        }
        // Both are seen as circles.
        let angle = to_center.angle_between(to_light);
        let of_light = (reach / far).asin();
        match (is_within, is_light_within) {
            (true, true) => Before::Nothing,
            // As a function of its cosine T would have to be told on both sides of a right angle.
            (true, false) if is_light_outside && (angle - FRAC_PI_2).abs() > of_light => ball(1),
            (false, true) => ball(1),
            (false, false) if is_light_outside => {
                let of_ball = (radius / distance).asin();
                if angle >= of_ball + of_light || far + reach < distance - radius {
                    Before::Nothing
                } else if angle + of_light < INNER * of_ball && far > distance {
                    ball(2)
                } else {
                    Before::Part
                }
            }
            _ => Before::Part,
        }
    }

    /// T along a direction of any length: the sine of the angle of incidence is how far the line is from the center, over
    /// the radius.
    fn transmittance(&self, way: DVec3) -> f64 {
        let sine = self.axis.cross(way).length() / way.length() * self.distance;
        let cosine = (1.0 - sine * sine).max(0.0).sqrt();
        let [_, transmittance] = optics::pane(cosine, self.n);
        transmittance.powi(self.crossings)
    }
}
