//! L9 over a square of the image, of a light with an area: a model of what arrives.
//!
//! Where nothing of the light is hidden, it is proven.
//!
//! With x on the light, r = x − p, u = r/|r| and n_x the light's normal, both lobes are integrals of
//!
//! f = (w·u)ⁿ (n·u) (−n_x·r)/|r|³
//!
//! over the light, whose value at the middle of the square is a closed form (`emitter`). How they bend is told by
//! bounds of the derivatives of f, by the product rule from those of p, n and w, times the area: with |r| ≥ d and
//! |p′| ≤ a, |p″| ≤ b,
//!
//! | factor | is at most | first derivative | second derivative |
//! | --- | --- | --- | --- |
//! | u | 1 | a/d | 2 a²/(√3 d²) + b/d |
//! | (−n_x·r)/\|r\|³ | 1/d² | 4a/d³ | 18 a²/d⁴ + 4b/d³ |
//!
//! A part of a sphere comes into view as p moves. At its rim n_x·r is 0, so that the first derivatives are those of
//! what is seen; the second ones have ∮ (n_x·p′)²/|r|³ dl/|∇(n_x·r)| more, where |∇(n_x·r)| is |r|/R on a sphere of
//! radius R: at most 2πR² a²/d⁴.
//!
//! Past shapes that hide a part of the light, what arrives is computed in the middle of the square and at the middles of
//! its sides (`Emitter::received_past`), and how it bends is an estimate from these. Where borders of shadows are
//! wider than some squares, it is smooth enough for that, as nothing narrower can be in it.

use std::f64::consts::{PI, TAU};

use super::border::nearest;
use super::model::{Model, Vector};
use super::surface::{Surface, rounding};
use crate::emitter::{
    Accuracy, Emitter, Gloss, Occluder, Received, Receiver, ShadowSpace, Surface as EmitterSurface,
};
use crate::math::{DVec3, Direction, Normal, Point};
use crate::world::light::AreaLight;
use crate::world::material::Model as Reflection;
use crate::world::panes::PanesBefore;
use crate::world::{Lobes, Material};

/// Whether slopes are told, or only how far values may be from the one in the middle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Slopes {
    Told,
    Left,
    /// Left, and past shapes only the value in the middle is computed.
    Glimpsed,
    /// Only the value in the middle is asked for.
    None,
}

/// What hides a part of a light.
pub(super) struct Past<'a> {
    pub(super) occluders: &'a [Occluder],
    pub(super) panes: &'a PanesBefore,
    /// Room for those of them that a point asks for.
    pub(super) kept: &'a mut Vec<Occluder>,
    /// No border of a shadow moves across more than this part of the light.
    pub(super) border: f64,
    pub(super) space: &'a mut ShadowSpace,
}

/// How far what arrives past shapes may be off, as a part of what arrives with nothing in the way.
const ACCURACY: Accuracy = Accuracy {
    relative: 1e-6,
    most_cells: 65_536,
};

/// Second differences of what arrives past shapes are taken to be larger by this.
const BEND_MARGIN: f64 = 2.0;

/// As a second derivative along each axis, what no end of an axis shows, as a part of what borders move across: where one
/// begins on a diagonal, beyond two ends, the mean is (√2 − 1/√2)³/12 of the slope off, and that is half of what moves at
/// most; 0.044 along both axes would have it. Twice that, as with other bends.
const UNSEEN: f64 = 0.09;

/// What the lobes are functions of.
#[derive(Clone, Copy)]
struct Place {
    position: Vector,
    normal: Vector,
    /// w
    axis: Vector,
}

/// Bounds on how fast p, n and w change: on their first and second derivatives along a way of length 1.
#[derive(Clone, Copy)]
struct Speed {
    position: [f64; 2],
    normal: [f64; 2],
    axis: [f64; 2],
}

/// Bounds on the size of a function and of its first and second derivatives.
#[derive(Clone, Copy)]
struct Bounds([f64; 3]);

impl Bounds {
    /// Of a product.
    fn times(self, other: Self) -> Self {
        let ([f, f1, f2], [g, g1, g2]) = (self.0, other.0);
        Self([f * g, f1 * g + f * g1, f2 * g + 2.0 * f1 * g1 + f * g2])
    }
}

/// A light as it is seen from all points of a square.
struct Sight<'a> {
    emitter: &'a Emitter,
    /// It in parts: a rectangle in quarters, anything else whole.
    parts: [Part; 4],
    count: usize,
    /// How much more the second derivatives may be, as a part of a²/d⁴ times the area.
    rim: f64,
    /// |n| is at most this, and |w|: 1 but where their linear parts are taken.
    normal: f64,
    axis: f64,
    lobe: Option<Lobe>,
}

/// A part of a light.
#[derive(Clone, Copy, Default)]
struct Part {
    /// |r| is at least this, and above 0.
    nearest: f64,
    /// In m², of what is seen.
    area: f64,
}

struct Lobe {
    shininess: f64,
    has_cosine: bool,
    /// At least cⁿ and its first and second derivatives in c = w·u, which are infinite where the slope jumps.
    powers: [f64; 3],
}

/// The cosine terms of L5 and L7 of the lobes over the light, per cd along its normal: in m⁻².
pub(super) fn geometry(
    surface: &Surface,
    light: &AreaLight,
    material: &Material,
    slopes: Slopes,
    past: Option<Past<'_>>,
) -> Lobes<Model> {
    let unknown = Lobes {
        diffuse: Model::UNKNOWN,
        specular: Model::UNKNOWN,
    };
    let normal = surface.normal();
    let place = Place {
        position: surface.position,
        normal,
        // L6: ω_r mirrored, so that ω_o·ω_r = w·u.
        axis: normal.scaled(surface.cos_viewer.times(2.0)) - surface.to_viewer,
    };
    let Some(sight) = Sight::new(&light.emitter, &place, material, slopes) else {
        return unknown;
    };
    let fixed = surface.plane().and_then(|[_, normal]| Normal::new(normal));
    let models = match past {
        None if slopes == Slopes::None => {
            let values = sight.values(&place, fixed, [0.0; 3]);
            values.map(|values| values.map(Model::constant))
        }
        Some(mut past) if slopes == Slopes::None => {
            let values = sight.values_past(&place, fixed, [0.0; 3], &mut past);
            values.map(|values| values.map(Model::constant))
        }
        None => sight.models(&place, fixed, slopes),
        Some(mut past) if slopes == Slopes::Glimpsed => sight.glimpse(&place, fixed, &mut past),
        Some(mut past) => sight.estimates(&place, fixed, &mut past),
    };
    let Some(models) = models else {
        return unknown;
    };
    let [diffuse, specular] = models.map(|model| model.times(light.over_area()));
    Lobes { diffuse, specular }
}

impl<'a> Sight<'a> {
    /// `None` where a point may be on the light.
    fn new(
        emitter: &'a Emitter,
        place: &Place,
        material: &Material,
        slopes: Slopes,
    ) -> Option<Self> {
        let bounds = place.position.bounds()?;
        let has_cosine = match material.model() {
            Reflection::Phong => false,
            Reflection::NormalizedPhong => true,
        };
        let shininess = material.is_specular().then(|| material.shininess());
        let is_apart = nearest(emitter, bounds) > 0.0;
        if slopes == Slopes::None {
            let lobe = shininess.map(|shininess| Lobe {
                shininess,
                has_cosine,
                powers: [f64::INFINITY; 3],
            });
            return is_apart.then(|| Self::without_bounds(emitter, place, lobe));
        }
        let lobe = shininess.map(|n| Lobe::new(emitter, place, n, has_cosine));
        is_apart.then(|| Self::at(emitter, bounds, place, lobe))
    }

    fn without_bounds(emitter: &'a Emitter, place: &Place, lobe: Option<Lobe>) -> Self {
        Self {
            emitter,
            parts: [Part::default(); 4],
            count: 0,
            rim: 0.0,
            normal: place.normal.magnitude(),
            axis: place.axis.magnitude(),
            lobe,
        }
    }

    /// Of points in a box.
    fn at(emitter: &'a Emitter, bounds: [DVec3; 2], place: &Place, lobe: Option<Lobe>) -> Self {
        let mut sight = Self::without_bounds(emitter, place, lobe);
        sight.count = 1;
        let whole = |area: f64| Part {
            nearest: nearest(emitter, bounds),
            area,
        };
        match emitter.surface() {
            EmitterSurface::Rectangle(corners) => {
                let [a, b, c, _] = corners;
                let halves = [(b - a) * 0.25, (c - b) * 0.25];
                let area = 0.25 * emitter.area();
                let quarter = |corner: DVec3| {
                    let center = Point((emitter.center().0 + corner) * 0.5);
                    let quarter = Emitter::rectangle(center, halves, emitter.is_two_sided())?;
                    let nearest = nearest(&quarter, bounds);
                    (nearest > 0.0).then_some(Part { nearest, area })
                };
                // What is too small to be parted is taken whole.
                if let [Some(a), Some(b), Some(c), Some(d)] = corners.map(quarter) {
                    sight.parts = [a, b, c, d];
                    sight.count = 4;
                } else {
                    sight.parts[0] = whole(emitter.area());
                }
            }
            EmitterSurface::Disk { .. } => sight.parts[0] = whole(emitter.area()),
            EmitterSurface::Sphere { radius } => {
                sight.parts[0] = whole(TAU * radius * radius);
                sight.rim = 1.0;
            }
        }
        sight
    }

    /// Both integrals, in sr. `fixed` is the normal where all points are in one plane.
    fn models(&self, place: &Place, fixed: Option<Normal>, slopes: Slopes) -> Option<[Model; 2]> {
        let at = |[u, v, w]: [f64; 3]| self.values(place, fixed, [u, v, w]);
        let middle = at([0.0; 3])?;
        let ends = match slopes {
            Slopes::Told => place.ends(middle, at)?,
            _ => [[middle; 2]; 3],
        };
        let axes = [0, 1].map(|axis| self.bounds(&place.speed(|vector| vector.derivatives(axis))));
        // From the middle to anywhere, along the linear parts, and from there.
        let along = self.bounds(&place.speed(|vector| [vector.reach(), 0.0]));
        let beside = self.bounds(&place.speed(|vector| [vector.rest(), 0.0]));
        let mut models = [Model::UNKNOWN; 2];
        for (lobe, model) in models.iter_mut().enumerate() {
            let [first, second] =
                [1, 2].map(|order: usize| axes.map(|bounds| bounds[lobe].0[order]));
            let [_, along_first, along_second] = along[lobe].0;
            let beside = beside[lobe].0[1];
            let slope = ends.map(|[after, before]| 0.5 * (after[lobe] - before[lobe]));
            let rest = match slopes {
                // Half of the bend to anywhere; and each slope is off by half of the bend along its axis.
                Slopes::Told => 2.0 * along_second + beside,
                _ => along_first + beside,
            };
            *model = Model::known(middle[lobe], slope, rest, first, second);
        }
        Some(models)
    }

    /// The same past shapes, as an estimate.
    fn estimates(
        &self,
        place: &Place,
        fixed: Option<Normal>,
        past: &mut Past<'_>,
    ) -> Option<[Model; 2]> {
        let mut at = |place_in_square| self.values_past(place, fixed, place_in_square, past);
        let middle = at([0.0; 3])?;
        let ends = place.ends(middle, at)?;
        let beside = self.bounds(&place.speed(|vector| [vector.rest(), 0.0]));
        let unseen = beside.map(|Bounds([free, ..])| UNSEEN * past.border * free);
        // The ends are on lines: how p, n and w bend comes to it.
        let bends = [0, 1].map(|axis: usize| {
            self.bounds(&place.speed(|vector| [0.0, vector.derivatives(axis)[1]]))
        });
        let mut models = [Model::UNKNOWN; 2];
        for (lobe, model) in models.iter_mut().enumerate() {
            let slope = ends.map(|[after, before]| 0.5 * (after[lobe] - before[lobe]));
            let bend = ends.map(|[after, before]| {
                BEND_MARGIN * (after[lobe] - 2.0 * middle[lobe] + before[lobe]).abs()
            });
            let rest = 0.5 * bend.iter().sum::<f64>() + beside[lobe].0[1] + unseen[lobe];
            let second =
                [0, 1].map(|axis: usize| bend[axis] + bends[axis][lobe].0[2] + unseen[lobe]);
            let first = [0, 1].map(|axis: usize| slope[axis].abs() + second[axis]);
            *model = Model::known(middle[lobe], slope, rest, first, second);
        }
        Some(models)
    }

    /// The same from the middle alone. Over the square no more comes into view than a part of the light, which is so much
    /// of all integrals at most; to anywhere from the middle half of that. Where that begins in the middle, on one of its
    /// sides, the mean is an eighth of it off: as if both second derivatives were three eighths.
    fn glimpse(
        &self,
        place: &Place,
        fixed: Option<Normal>,
        past: &mut Past<'_>,
    ) -> Option<[Model; 2]> {
        let middle = self.values_past(place, fixed, [0.0; 3], past)?;
        let axes = [0, 1].map(|axis| self.bounds(&place.speed(|vector| vector.derivatives(axis))));
        let away = self.bounds(&place.speed(|vector| [vector.reach() + vector.rest(), 0.0]));
        let mut models = [Model::UNKNOWN; 2];
        for (lobe, model) in models.iter_mut().enumerate() {
            let [free, steepest, _] = away[lobe].0;
            let moved = past.border * free;
            let [first, second] =
                [1, 2].map(|order: usize| axes.map(|bounds| bounds[lobe].0[order]));
            *model = Model::known(
                middle[lobe],
                [0.0; 3],
                steepest + 0.5 * moved,
                first.map(|first| first + 0.5 * moved),
                second.map(|second| second + 0.375 * moved),
            );
        }
        Some(models)
    }

    /// Both integrals at a place, along the linear parts, past shapes.
    fn values_past(
        &self,
        place: &Place,
        fixed: Option<Normal>,
        at: [f64; 3],
        past: &mut Past<'_>,
    ) -> Option<[f64; 2]> {
        let horizon = match fixed {
            Some(normal) => normal,
            None => Normal::new(place.normal.at(at))?,
        };
        let mut is_known = true;
        let values = self.receive(place, horizon, at, |emitter, point, receiver| {
            let sight = emitter.sight(point, horizon);
            let hiding = past.occluders.iter().copied();
            past.kept.clear();
            past.kept
                .extend(hiding.filter(|occluder| sight.may_be_hidden_by(occluder)));
            if past.kept.is_empty() && past.panes.is_empty() {
                return emitter.received_by_lobes(point, receiver);
            }
            let from = (point, rounding(point.0, emitter.center().0));
            let (kept, space) = (&past.kept[..], &mut *past.space);
            let seen = past
                .panes
                .received(emitter, from, receiver, kept, &ACCURACY, space);
            is_known &= !seen.is_undimmed;
            seen.received
        });
        values.filter(|_| is_known)
    }

    /// Both integrals at a place, along the linear parts.
    fn values(&self, place: &Place, fixed: Option<Normal>, at: [f64; 3]) -> Option<[f64; 2]> {
        let position = place.position.at(at);
        let horizon = match (fixed, self.emitter.normal()) {
            (Some(normal), _) => normal,
            // All of the light is above the horizon; this one has all of it above, too.
            (None, Some(across)) => {
                let side = across.get().dot(self.emitter.center().0 - position);
                Normal::new(across.get() * side.signum())?
            }
            (None, None) => Normal::new(self.emitter.center().0 - position)?,
        };
        self.receive(place, horizon, at, Emitter::received_by_lobes)
    }

    fn receive(
        &self,
        place: &Place,
        horizon: Normal,
        at: [f64; 3],
        received: impl FnOnce(&Emitter, Point, &Receiver) -> Option<Received>,
    ) -> Option<[f64; 2]> {
        let position = Point(place.position.at(at));
        let way = place.normal.at(at);
        let normal = Normal::new(way)?;
        let axis = place.axis.at(at);
        let gloss = match &self.lobe {
            None => None,
            Some(lobe) => Some(Gloss {
                axis: Direction::new(axis)?,
                shininess: lobe.shininess,
                has_cosine: lobe.has_cosine,
            }),
        };
        let receiver = Receiver {
            horizon,
            normal,
            gloss,
        };
        let received = received(self.emitter, position, &receiver).unwrap_or_default();
        let (size, scale) = (
            way.length(),
            gloss.map_or(1.0, |gloss| libm::pow(axis.length(), gloss.shininess)),
        );
        let scale = if gloss.is_some_and(|gloss| gloss.has_cosine) {
            scale * size
        } else {
            scale
        };
        Some([received.irradiance * size, received.lobe * scale])
    }

    /// Of both integrals, along a way.
    fn bounds(&self, speed: &Speed) -> [Bounds; 2] {
        let mut sums = [Bounds([0.0; 3]); 2];
        for part in &self.parts[..self.count] {
            for (sum, bounds) in sums.iter_mut().zip(self.bounds_of(part, speed)) {
                for (sum, bound) in sum.0.iter_mut().zip(bounds.0) {
                    *sum += bound;
                }
            }
        }
        sums
    }

    fn bounds_of(&self, &Part { nearest, area }: &Part, speed: &Speed) -> [Bounds; 2] {
        let over = 1.0 / nearest;
        let [a, b] = speed.position;
        // u
        let direction = [
            a * over,
            2.0 / 3.0_f64.sqrt() * (a * over).powi(2) + b * over,
        ];
        let density = Bounds([
            over * over,
            4.0 * a * over.powi(3),
            (18.0 + self.rim) * a * a * over.powi(4) + 4.0 * b * over.powi(3),
        ]);
        let density = density.times(Bounds([area, 0.0, 0.0]));
        // A scalar product with u.
        let cosine = |size: f64, [first, second]: [f64; 2]| {
            Bounds([size, first, second]).times(Bounds([1.0, direction[0], direction[1]]))
        };
        let incident = cosine(self.normal, speed.normal);
        let diffuse = incident.times(density);
        let Some(lobe) = &self.lobe else {
            return [diffuse, Bounds([0.0; 3])];
        };
        let specular = lobe.power(cosine(self.axis, speed.axis)).times(density);
        let specular = if lobe.has_cosine {
            specular.times(incident)
        } else {
            specular
        };
        [diffuse, specular]
    }
}

impl Lobe {
    fn new(emitter: &Emitter, place: &Place, shininess: f64, has_cosine: bool) -> Self {
        let way = emitter.center().0 - place.position.center();
        let (axis, distance) = (place.axis.center(), way.length());
        let (length, turned) = (axis.length(), place.axis.radius());
        let [least, most] = emitter.bounds();
        let reach = 0.5 * (most - least).length() + place.position.radius();
        // How far any point of the light is seen from its middle, and any axis is from the middle one.
        let within = |reach: f64, distance: f64| {
            if reach < distance {
                libm::asin(reach / distance)
            } else {
                PI
            }
        };
        let spread = within(reach, distance) + within(turned, length);
        let angle = libm::acos((axis.dot(way) / (length * distance)).clamp(-1.0, 1.0));
        let cosine = |angle: f64| libm::cos(angle.clamp(0.0, PI));
        let (least, most) = (cosine(angle + spread), cosine(angle - spread));
        let (longest, shortest) = (length + turned, (length - turned).max(0.0));
        let least = least * if least > 0.0 { shortest } else { longest };
        Self {
            shininess,
            has_cosine,
            powers: powers(shininess, [least, most * longest]),
        }
    }

    /// Of max(0, c)ⁿ, from bounds of the derivatives of c.
    fn power(&self, Bounds([_, first, second]): Bounds) -> Bounds {
        let [at, slope, bend] = self.powers;
        if at == f64::INFINITY {
            return Bounds([f64::INFINITY; 3]);
        }
        Bounds([at, slope * first, bend * first * first + slope * second])
    }
}

/// At least max(0, c)ⁿ and its derivatives for c in a range.
fn powers(n: f64, [least, most]: [f64; 2]) -> [f64; 3] {
    if most <= 0.0 {
        return [0.0; 3];
    }
    if n < 2.0 && least <= 0.0 {
        // The slope jumps where c is 0.
        return [f64::INFINITY; 3];
    }
    // Where the exponent is below 0, the largest is at the least.
    let power = |exponent: f64| libm::pow(if exponent < 0.0 { least } else { most }, exponent);
    [
        power(n),
        n * power(n - 1.0),
        (n * (n - 1.0)).abs() * power(n - 2.0),
    ]
}

impl Place {
    /// Of each vector.
    fn speed(&self, of: impl Fn(&Vector) -> [f64; 2]) -> Speed {
        Speed {
            position: of(&self.position),
            normal: of(&self.normal),
            axis: of(&self.axis),
        }
    }

    /// What both integrals are at the ends of each axis, after the middle and before it.
    fn ends(
        &self,
        middle: [f64; 2],
        mut at: impl FnMut([f64; 3]) -> Option<[f64; 2]>,
    ) -> Option<[[[f64; 2]; 2]; 3]> {
        // Along an axis that there is not they are those of the middle.
        let mut ends = [[middle; 2]; 3];
        let axes = 2 + usize::from(self.position.has_third());
        for (axis, ends) in ends.iter_mut().enumerate().take(axes) {
            let mut end = [0.0; 3];
            end[axis] = 1.0;
            let after = at(end)?;
            end[axis] = -1.0;
            *ends = [after, at(end)?];
        }
        Some(ends)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Models against the closed form all over squares: values are within the rest of the linear part, first and
    /// second differences within the derivatives.
    #[test]
    fn models_hold() {
        let center = Point(DVec3::new(0.2, -0.1, 1.5));
        let down = Normal::new(DVec3::new(0.2, 0.1, -1.0)).unwrap();
        let halves = [DVec3::new(0.5, 0.0, 0.1), DVec3::new(0.0, 0.3, 0.03)];
        let emitters = [
            Emitter::rectangle(center, halves, true).unwrap(),
            Emitter::disk(center, down, 0.5, false).unwrap(),
            Emitter::sphere(center, 0.4).unwrap(),
        ];
        let mut state = 1_u64;
        let mut uniform = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            2.0 * (state >> 11) as f64 / (1_u64 << 53) as f64 - 1.0
        };
        let mut vector = |size: f64| DVec3::new(uniform(), uniform(), uniform()) * size;
        // How much of the rest, and of the second derivatives, there is at most.
        let mut most = [0.0_f64; 2];
        for number in 0..540 {
            let emitter = &emitters[number % 3];
            let size = [0.1, 0.02, 0.002][number / 3 % 3];
            let shininess = [2.0, 7.5, 40.0][number / 9 % 3];
            let [position, normal, axis] = [0.5, 0.2, 0.5].map(&mut vector);
            let mut linear = |middle: DVec3| Vector::linear(middle, [vector(size), vector(size)]);
            let place = Place {
                position: linear(position),
                normal: linear((DVec3::Z + normal).normalize()),
                axis: linear((DVec3::Z + axis).normalize()),
            };
            let lobe = Lobe::new(emitter, &place, shininess, number % 2 == 0);
            let bounds = place.position.bounds().unwrap();
            let sight = Sight::at(emitter, bounds, &place, Some(lobe));
            let value = |u: f64, v: f64| sight.values(&place, None, [u, v, 0.0]).unwrap();
            for slopes in [Slopes::Told, Slopes::Left] {
                let models = sight.models(&place, None, slopes).unwrap();
                for (lobe, model) in models.iter().enumerate() {
                    let at = |u: f64, v: f64| value(u, v)[lobe];
                    for step in 0..25 {
                        let [u, v] = [step % 5, step / 5].map(|i: u32| f64::from(i) * 0.5 - 1.0);
                        let off = (model.at([u, v, 0.0]) - at(u, v)).abs();
                        assert!(off <= model.rest + 1e-12, "{number}: {off} {}", model.rest);
                        most[0] = most[0].max(off / model.rest);
                    }
                    let middle = at(0.0, 0.0);
                    for (axis, (after, before)) in
                        [(at(1.0, 0.0), at(-1.0, 0.0)), (at(0.0, 1.0), at(0.0, -1.0))]
                            .into_iter()
                            .enumerate()
                    {
                        let first = 0.5 * (after - before).abs();
                        let second = (after - 2.0 * middle + before).abs();
                        let [one, two] = model.derivatives(axis);
                        assert!(first <= one + 1e-12, "{number}: {first} {one}");
                        assert!(second <= two + 1e-12, "{number}: {second} {two}");
                        most[1] = most[1].max(second / two);
                    }
                }
            }
        }
        // They are bounds, but not of another order.
        assert!(most.iter().all(|&part| part > 0.02), "{most:?}");
    }
}
