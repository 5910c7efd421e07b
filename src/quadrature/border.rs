//! Shadows of lights with an area on a whole surface: how far their borders move across a light, for estimates, and
//! where all is dark; and how far away it is.

use super::Shadow;
use super::surface::{Solid, Surface, rounding};
use crate::emitter::{Accuracy, Emitter, Occluder, Receiver, Surface as EmitterSurface};
use crate::math::{DVec3, Normal, Point};

/// How exact it is where it is only asked whether anything arrives.
const ACCURACY_OF_DARK: Accuracy = Accuracy {
    relative: 1e-6,
    most_cells: 64,
};

/// A part of space: where n·x ≥ d.
type HalfSpace = (DVec3, f64);

/// What of shapes may be seen before a light from some points.
struct Sight {
    place: DVec3,
    /// How far the points are from the place.
    room: f64,
    /// What hides anything of the light from any of them is within all of these.
    within: [Option<HalfSpace>; 6],
}

/// How much of a light may come into view between two points of a surface, past shapes: as a part of all of it. The border
/// of a shadow that falls on the light moves across it as far as the points are apart, the farther the nearer to them is
/// what makes it: an edge of a triangle, or where a ball is touched.
pub(super) fn border(
    surface: &Surface,
    emitter: &Emitter,
    shapes: &(impl Iterator<Item = Solid> + Clone),
) -> f64 {
    let sight = Sight::new(surface, emitter);
    let apart = 2.0 * sight.room;
    let distance = (emitter.center().0 - sight.place).length();
    let over_width = over_width(emitter);
    let moved = |nearest: f64| {
        let nearest = nearest - apart;
        if nearest > 0.0 {
            apart * ((distance - nearest).max(0.0) / nearest) * over_width
        } else {
            f64::INFINITY
        }
    };
    let mut widest = 0.0;
    for shape in shapes.clone() {
        let Solid::Triangle { corners, .. } = shape else {
            widest = f64::max(widest, moved(sight.distance(&shape)));
            continue;
        };
        for edge in 0..3 {
            let [a, b, c] = [0, 1, 2].map(|place: usize| corners[(edge + place) % 3]);
            let Some(nearest) = sight.distance_of_edge([a, b]) else {
                continue;
            };
            let part = moved(nearest);
            if part > widest && !sight.is_inner([a, b, c], shapes.clone()) {
                widest = part;
            }
        }
    }
    widest
}

/// One over how wide a light is; of a rectangle along both of its sides.
pub(super) fn over_width(emitter: &Emitter) -> f64 {
    match emitter.surface() {
        EmitterSurface::Rectangle([a, b, c, _]) => 1.0 / (b - a).length() + 1.0 / (c - b).length(),
        EmitterSurface::Disk { radius, .. } | EmitterSurface::Sphere { radius } => 1.0 / radius,
    }
}

impl Sight {
    fn new(surface: &Surface, emitter: &Emitter) -> Self {
        let (place, room) = (surface.position.center(), surface.position.radius());
        let center = emitter.center().0;
        let mut within = [None; 6];
        let [sides @ .., front, horizon] = &mut within;
        if let EmitterSurface::Rectangle(corners) = emitter.surface() {
            for (number, side) in sides.iter_mut().enumerate() {
                let [from, to] = [corners[number], corners[(number + 1) % 4]];
                // Through the place and a side of the light. Ways to the light from points that are elsewhere leave it
                // by no more than they are apart.
                let normal = (from - place).cross(to - from);
                let normal = normal * (normal.dot(center - place).signum() / normal.length());
                *side = Some((normal, normal.dot(place) - room));
            }
        }
        if let Some(normal) = emitter.normal() {
            let normal = normal.get();
            let towards = normal * normal.dot(place - center).signum();
            *front = Some((towards, towards.dot(center)));
        }
        *horizon = surface
            .plane()
            .map(|[point, normal]| (normal, normal.dot(point)));
        Self {
            place,
            room,
            within,
        }
    }

    /// How far the border of a shape is.
    fn distance(&self, shape: &Solid) -> f64 {
        match *shape {
            Solid::Sphere { center, radius } => {
                let distance = (center - self.place).length();
                ((distance - radius) * (distance + radius)).max(0.0).sqrt()
            }
            Solid::Plane { .. } | Solid::Triangle { .. } | Solid::Disk { .. } => {
                shape.distance(self.place)
            }
        }
    }

    /// How far what may be seen of an edge before the light is; `None` where that is nothing.
    fn distance_of_edge(&self, [a, b]: [DVec3; 2]) -> Option<f64> {
        let way = b - a;
        let (mut from, mut to) = (0.0, 1.0);
        for (normal, least) in self.within.iter().flatten() {
            let [start, end] = [a, b].map(|end| normal.dot(end) - least);
            if start < 0.0 && end < 0.0 {
                return None;
            }
            if start < 0.0 {
                from = f64::max(from, start / (start - end));
            } else if end < 0.0 {
                to = f64::min(to, start / (start - end));
            }
        }
        if from > to {
            return None;
        }
        let foot = (self.place - a).dot(way) / way.length_squared();
        // No part of an edge without length is seen.
        let nearest = a + way * foot.max(from).min(to);
        Some((nearest - self.place).length())
    }

    /// Whether another triangle goes on beyond an edge a, b of one with another corner c: as the other half of a flat side.
    fn is_inner(&self, [a, b, c]: [DVec3; 3], mut shapes: impl Iterator<Item = Solid>) -> bool {
        let across = (a - self.place).cross(b - self.place);
        // As a point moves by the room, the plane through it and the edge turns, by more the nearer it is to the edge.
        let side = |corner: DVec3| {
            let height = across.dot(corner - self.place);
            let turned = (corner - a).length() * (b - a).length();
            let is_told = height.abs() > self.room * (across.length() + turned);
            if is_told { height.signum() } else { 0.0 }
        };
        let here = side(c);
        shapes.any(|shape| {
            let Solid::Triangle { corners, .. } = shape else {
                return false;
            };
            let mut others = corners.iter().filter(|&&corner| corner != a && corner != b);
            let (Some(&other), None) = (others.next(), others.next()) else {
                return false;
            };
            here * side(other) < 0.0
        })
    }
}

/// Whether balls hide all of a light from everywhere on a flat surface, all of whose points are before the light.
///
/// It is so where smaller balls hide it from the middle, by as much as other points are apart from there: if a segment to the
/// middle is nearer to a ball's center than R − δ, one with the same other end to a point no further than δ from the middle is
/// nearer than R.
pub(super) fn is_hidden(
    surface: &Surface,
    emitter: &Emitter,
    balls: impl Iterator<Item = (DVec3, f64)>,
    Shadow {
        shadow, occluders, ..
    }: &mut Shadow,
) -> bool {
    let Some(horizon) = surface.plane().and_then(|[_, normal]| Normal::new(normal)) else {
        return false;
    };
    let (middle, apart) = (surface.position.center(), surface.position.radius());
    let center = emitter.center().0;
    let [least, most] = emitter.bounds();
    occluders.clear();
    occluders.extend(balls.filter_map(|(center, radius)| {
        let smaller = radius - apart - rounding(middle, center);
        // A ball that the light is in, or that it reaches into, is not between.
        let is_outside = (center.clamp(least, most) - center).length() > radius;
        (is_outside && smaller > 0.0).then_some(Occluder::Ball {
            center,
            radius: smaller,
        })
    }));
    // Mostly it is seen right away that its middle is not hidden.
    let hides_middle = |occluder: &Occluder| {
        let Occluder::Ball {
            center: of_ball,
            radius,
        } = *occluder
        else {
            return false;
        };
        let way = center - middle;
        let along = (way.dot(of_ball - middle) / way.length_squared()).clamp(0.0, 1.0);
        (middle + way * along - of_ball).length() < radius
    };
    if !occluders.iter().any(hides_middle) {
        return false;
    }
    let receiver = Receiver {
        horizon,
        normal: horizon,
        gloss: None,
    };
    let error = rounding(middle, center);
    let seen = emitter.received_past(
        Point(middle),
        &receiver,
        occluders,
        error,
        &ACCURACY_OF_DARK,
        shadow,
    );
    // Of what is not decided a half is counted.
    seen.is_some_and(|seen| seen.value.solid_angle <= 0.0)
}

/// How far a box is from a light, at least; 0 where a point in it may be behind the light.
pub(super) fn nearest(emitter: &Emitter, [least, most]: [DVec3; 2]) -> f64 {
    let center = emitter.center().0;
    let [low, high] = emitter.bounds();
    let beside = (low - most).max(least - high).max(DVec3::ZERO).length();
    match (emitter.surface(), emitter.normal()) {
        (EmitterSurface::Sphere { radius }, _) => {
            (center.clamp(least, most) - center).length() - radius
        }
        (_, Some(normal)) => {
            let normal = normal.get();
            let end = |of_most: bool| {
                let is_up = normal.cmpgt(DVec3::ZERO);
                let (up, down) = if of_most {
                    (most, least)
                } else {
                    (least, most)
                };
                normal.dot(DVec3::select(is_up, up, down) - center)
            };
            let (lowest, highest) = (end(false), end(true));
            let height = if lowest > 0.0 {
                lowest
            } else if highest < 0.0 && emitter.is_two_sided() {
                -highest
            } else {
                return 0.0;
            };
            height.max(beside)
        }
        (_, None) => 0.0,
    }
}
