//! A square through which one edge passes: the silhouette of a shape, the border of a shadow, a terminator, or where
//! two shapes meet.

use super::area::Slopes;
use super::clip::Clip;
use super::model::{Model, Vector};
use super::radiance::{Arriving, Radiance, WIDE_BORDER};
use super::shafts::{Beside, Known};
use super::surface::{Silhouette, Solid, Surface, one_of, within_rim};
use super::view::{Square, View};
use super::{List, Mean, Primary, Quadrature, Reach, Told};
use crate::math::DVec3;
use crate::visibility::{ShaftAnswer, ShaftQuestion};

/// L and A on one side of an edge.
struct Side {
    radiance: Radiance,
    alpha: f64,
}

/// An edge, and what is on its sides.
struct Edge {
    silhouette: Silhouette,
    inside: Side,
    outside: Side,
}

impl Quadrature<'_> {
    /// The mean over a square with one edge.
    pub(super) fn across_edge(
        &mut self,
        square: Square,
        view: &View,
        told: &Told,
        surface: Option<&Surface>,
    ) -> Option<Mean> {
        let (lists, reaches) = (self.lists.len(), self.reaches.len());
        let edge = match (told.primary, surface) {
            (Primary::One(shape), Some(surface)) => self.shadow(told, shape, surface),
            (Primary::Several(list), _) => self.silhouette(square, view, list),
            _ => None,
        };
        self.lists.truncate(lists);
        self.reaches.truncate(reaches);
        edge.and_then(|edge| edge.mean())
    }

    /// The border of one light's shadow of one shape, or the terminator of one light.
    fn shadow(&mut self, told: &Told, shape: u64, surface: &Surface) -> Option<Edge> {
        let count = self.world.lights().len();
        // Shadows of lights with an area have no such border.
        let is_open = |&light: &usize| {
            let reach = self.reaches[told.reaches + light];
            let has_area = self.world.lights()[light].value.area().is_some();
            !has_area && !matches!(reach, Reach::Lit | Reach::Dark)
        };
        let mut open = (0..count).filter(is_open);
        let (Some(light), None) = (open.next(), open.next()) else {
            return None;
        };
        let reaches = &self.reaches[told.reaches..][..count];
        let origin = self.origin(light, surface.position.bounds());
        let lit = match reaches[light] {
            Reach::Terminator => {
                // Nothing else may be in its way.
                let bounds = surface.position.bounds()?;
                let of_region = self.between(shape);
                let before = self.region.reaches[of_region + light];
                let question = ShaftQuestion::Contents;
                if self.between_points(bounds, origin, shape, before, question)
                    != ShaftAnswer::Nothing
                {
                    return None;
                }
                surface.height(origin)
            }
            Reach::Several(list) if list.end - list.start == 1 => {
                let occluder = self.solid(self.list(list)[0]);
                -occluded(surface, origin, &occluder)?
            }
            _ => return None,
        };
        let all = std::mem::replace(&mut self.reaches[told.reaches + light], Reach::Dark);
        let border = Some(WIDE_BORDER);
        let dark = self.radiance(surface, shape, told.reaches, border, Slopes::Told);
        self.reaches[told.reaches + light] = all;
        let dark = dark?;
        let arriving = Arriving::alone(light);
        let share = self.light_share(surface, shape, arriving, Slopes::Told);
        Some(Edge {
            silhouette: Silhouette {
                inside: lit,
                is_round: false,
            },
            inside: Side {
                radiance: dark.plus(share),
                alpha: 1.0,
            },
            outside: Side {
                radiance: dark,
                alpha: 1.0,
            },
        })
    }

    /// The silhouette of one shape before another or nothing, or where two meet.
    fn silhouette(&mut self, square: Square, view: &View, list: List) -> Option<Edge> {
        let mut shapes = self.list(list).to_vec();
        self.drop_covered(view, &mut shapes);
        let count = shapes.len();
        if count > 3 {
            return None;
        }
        for (place, &front) in shapes.iter().enumerate() {
            let others: Vec<u64> = (0..count)
                .filter(|&other| other != place)
                .map(|other| shapes[other])
                .collect();
            let back = self.alone(square, &others);
            let Some(back) = back else {
                continue;
            };
            let solid = self.solid(front);
            let Some((silhouette, reach)) = solid.silhouette(view) else {
                continue;
            };
            let mut beside = None;
            let outside = match back {
                None => Side {
                    radiance: Radiance::constant(self.world.background().0.0),
                    alpha: 0.0,
                },
                Some(back) => {
                    let behind = self.solid(back);
                    let surface = Surface::new(view, &behind)?;
                    // All of what is above of a plane is before it.
                    let plane = behind.approach(view).zip(behind.plane());
                    let plane = plane.map(|(approach, [point, _])| (point, approach.normal));
                    let plane = plane.filter(|&(point, normal)| solid.is_above(point, normal));
                    let is_behind = plane.is_some() || surface.distance.least() > reach;
                    if !is_behind {
                        continue;
                    }
                    let mut other = None;
                    if let Some((point, normal)) = plane {
                        beside = Some(Beside {
                            shape: back,
                            point,
                            normal,
                        });
                        if solid.stands_on(view, point, normal) {
                            other = Beside::new(view, front, &solid);
                        }
                    }
                    self.side(back, &surface, other)?
                }
            };
            let surface = Surface::at_silhouette(view, &solid, &silhouette)?;
            return Some(Edge {
                silhouette,
                inside: self.side(front, &surface, beside)?,
                outside,
            });
        }
        if let [a, b] = shapes[..] {
            return self.meeting(view, a, b);
        }
        None
    }

    /// Drops what is behind a triangle whose edge passes through a square wherever it is in the square, as a side of a
    /// box behind the one that is seen, and what is behind two with a common edge.
    pub(super) fn drop_covered(&self, view: &View, shapes: &mut Vec<u64>) {
        let told = |&shape: &u64| {
            let solid = self.solid(shape);
            let (edge, plane) = (solid.edge(view)?, solid.plane().zip(solid.approach(view))?);
            let ([point, _], approach) = plane;
            Some((shape, edge, point, approach.normal))
        };
        let fronts: Vec<_> = shapes.iter().filter_map(told).collect();
        for (place, &(front, inside, point, normal)) in fronts.iter().enumerate() {
            let is_behind = |shape: u64| self.solid(shape).is_above(point, -normal);
            let twin = fronts[..place]
                .iter()
                .find(|(_, other, ..)| ratio(other, &-inside).is_some());
            shapes.retain(|&shape| {
                if shape == front || !is_behind(shape) {
                    return true;
                }
                let solid = self.solid(shape);
                // What is in its plane may be seen in its place.
                let is_covered = !solid.is_above(point, normal)
                    && solid
                        .edge(view)
                        .is_some_and(|other| is_within(&other, &inside));
                let is_behind_both = twin.is_some_and(|&(twin, _, point, normal)| {
                    shape != twin && solid.is_above(point, -normal)
                });
                !(is_covered || is_behind_both)
            });
        }
    }

    /// What all rays through a square meet of some shapes; `None` where that is not one or nothing.
    #[expect(clippy::option_option, reason = "nothing is met, or it is not known")]
    fn alone(&mut self, square: Square, shapes: &[u64]) -> Option<Option<u64>> {
        let shaft = self.window(square);
        let answer = self.visibility.shaft_among(
            &shaft,
            ShaftQuestion::FirstHit,
            u64::MAX,
            shapes,
            &mut self.space,
        );
        match answer {
            ShaftAnswer::Nothing => Some(None),
            ShaftAnswer::All(shape) => Some(Some(shape)),
            ShaftAnswer::These | ShaftAnswer::TooMany => None,
        }
    }

    /// Two flat shapes without curved edges, on either side of a common edge, or of the line in which they meet.
    fn meeting(&mut self, view: &View, a: u64, b: u64) -> Option<Edge> {
        let (first, second) = (self.solid(a), self.solid(b));
        let is_flat = |solid: &Solid| matches!(solid, Solid::Plane { .. } | Solid::Triangle { .. });
        if !(is_flat(&first) && is_flat(&second)) {
            return None;
        }
        if first.is_all_over(view) && second.is_all_over(view) {
            return self.crossing(view, (a, &first), (b, &second));
        }
        let inside = match (first.silhouette(view), second.silhouette(view)) {
            (Some((first, _)), Some((second, _))) => {
                // The same line from both sides.
                ratio(&first.inside, &-second.inside)?;
                first.inside
            }
            _ => return None,
        };
        let surfaces = (Surface::new(view, &first)?, Surface::new(view, &second)?);
        Some(Edge {
            silhouette: Silhouette {
                inside,
                is_round: false,
            },
            inside: self.side(a, &surfaces.0, None)?,
            outside: self.side(b, &surfaces.1, None)?,
        })
    }

    /// Two flat shapes that pass through each other, or end in a corner: what is nearer is seen.
    fn crossing(
        &mut self,
        view: &View,
        (a, first): (u64, &Solid),
        (b, second): (u64, &Solid),
    ) -> Option<Edge> {
        let (to_first, to_second) = (first.approach(view)?, second.approach(view)?);
        let inside = to_first.before(&to_second);
        let surfaces = (Surface::new(view, first)?, Surface::new(view, second)?);
        let (of_first, of_second) = (Beside::new(view, a, first), Beside::new(view, b, second));
        Some(Edge {
            silhouette: Silhouette {
                inside,
                is_round: false,
            },
            inside: self.side(a, &surfaces.0, of_second)?,
            outside: self.side(b, &surfaces.1, of_first)?,
        })
    }

    /// L of a surface of which it is known how all lights reach it.
    fn side(&mut self, shape: u64, surface: &Surface, beside: Option<Beside>) -> Option<Side> {
        let known = beside.map_or(Known::Nothing, Known::Beside);
        let reaches = self.reach_all(shape, surface, known);
        let border = Some(WIDE_BORDER);
        let radiance = self.radiance(surface, shape, reaches, border, Slopes::Told)?;
        radiance.is_known().then_some(Side {
            radiance,
            alpha: 1.0,
        })
    }
}

/// Where a shape is between a surface and a light: above 0 there.
fn occluded(surface: &Surface, light: DVec3, occluder: &Solid) -> Option<Model> {
    let way = surface.position.minus(light);
    match *occluder {
        Solid::Sphere { center, radius } => {
            let to_center = center - light;
            let square = way.dot(way);
            let beside = Vector::constant(to_center).cross(way);
            let inside = square.times(radius * radius) - beside.dot(beside);
            // The nearest to its center is between the ends of the segment, which are both outside.
            let nearest = way.along(to_center) * square.reciprocal();
            let end = surface.position.minus(center);
            let is_outside = to_center.length() > radius && end.dot(end).least() > radius * radius;
            (is_outside && nearest.least() > 0.0 && nearest.most() < 1.0).then_some(inside)
        }
        Solid::Triangle {
            corners, normal, ..
        } => {
            let height = normal.dot(light - corners[0]);
            let end = surface.position.minus(corners[0]).along(normal);
            if !is_between(height, &end) {
                return None;
            }
            let from = corners.map(|corner| corner - light);
            one_of([0, 1, 2].map(|i: usize| way.along(from[i].cross(from[(i + 1) % 3]))))
        }
        Solid::Disk {
            center,
            normal,
            radius,
        } => {
            let height = normal.dot(light - center);
            let end = surface.position.minus(center).along(normal);
            is_between(height, &end)
                .then(|| within_rim(way, Vector::constant(center - light), normal, radius))
        }
        Solid::Plane { point, normal } => {
            let height = normal.dot(light - point);
            let end = surface.position.minus(point).along(normal);
            Some(end.times(-height.signum()))
        }
    }
}

/// What one linear function is of another, if that is a positive number.
fn ratio(f: &Model, g: &Model) -> Option<f64> {
    let pairs = [
        (f.center, g.center),
        (f.slope[0], g.slope[0]),
        (f.slope[1], g.slope[1]),
    ];
    // Any of them may be 0, as the center is where the line passes through the middle of the square.
    let largest = |a: (f64, f64), b: (f64, f64)| if a.0.abs() < b.0.abs() { b } else { a };
    let (of_f, of_g) = pairs.into_iter().reduce(largest)?;
    let (ratio, size) = (of_g / of_f, f.magnitude());
    let mut pairs = pairs.iter();
    let is_same = pairs.all(|(f, g)| (f * ratio - g).abs() <= 1e-9 * ratio.abs() * size);
    (ratio > 0.0 && is_same).then_some(ratio)
}

/// Whether a linear function is above 0 only where another is.
fn is_within(inner: &Model, outer: &Model) -> bool {
    let steepness = |edge: &Model| edge.slope[0].hypot(edge.slope[1]);
    let scale = steepness(outer) / steepness(inner);
    let difference = *outer - inner.times(scale);
    difference.least() >= -1e-9 * outer.magnitude()
}

/// Whether a light and points, by their heights over the plane of a flat shape, are on different sides of it.
fn is_between(light: f64, points: &Model) -> bool {
    if light > 0.0 {
        points.most() < 0.0
    } else {
        light < 0.0 && points.least() > 0.0
    }
}

impl Edge {
    /// The mean over the square.
    fn mean(&self) -> Option<Mean> {
        let Silhouette { inside, is_round } = self.silhouette;
        if !inside.is_known() || inside.slope[0] == 0.0 && inside.slope[1] == 0.0 {
            return None;
        }
        // The edge is between two lines.
        let rest = inside.rest;
        let line = inside.line();
        let scale = 0.5 * inside.most().max(0.0).sqrt();
        let here = Clip::new(&line, is_round.then_some(scale));
        let there = Clip::new(&-line, None);
        let more = Clip::new(&line.plus(rest), None).area - here.area;
        let less = here.area - Clip::new(&line.plus(-rest), None).area;
        let band = more.max(less);
        let mut mean = Mean {
            value: [0.0; 4],
            error: [0.0; 4],
            is_bound: self.inside.radiance.is_bound && self.outside.radiance.is_bound,
        };
        for channel in 0..3 {
            let (f, g) = (
                &self.inside.radiance.models[channel],
                &self.outside.radiance.models[channel],
            );
            // It may bend to one side in one place and to the other in another, where f − g may have another sign.
            let rise = (f.most() - g.least()).max(0.0);
            let fall = (g.most() - f.least()).max(0.0);
            let bent = (more * rise + less * fall).max(more * fall + less * rise);
            let mut error = bent + here.area * f.rest + there.area * g.rest;
            if is_round {
                // |√(φ + e) − √φ| ≤ |e|/√φ, in units of half of the largest.
                error += here.area * f.slope[2].abs() * rest * here.inverse_root / scale;
            }
            mean.value[channel] = here.area * f.at(here.middle) + there.area * g.at(there.middle);
            mean.error[channel] = error;
        }
        mean.value[3] = here.area * self.inside.alpha + there.area * self.outside.alpha;
        mean.error[3] = band * (self.inside.alpha - self.outside.alpha).abs();
        mean.value
            .iter()
            .chain(&mean.error)
            .all(|number| number.is_finite())
            .then_some(mean)
    }
}
