//! L over a square, and what it may be where it is not known.

use std::f64::consts::TAU;

use super::area::{Past, Slopes};
use super::light::geometry;
use super::model::Model;
use super::surface::Surface;
use super::view::{Square, View};
use super::{List, Primary, Quadrature, Range, Reach, Told};
use crate::camera::Projection;
use crate::emitter::Surface as EmitterSurface;
use crate::visibility::{ShaftAnswer, ShaftQuestion, object_and_triangle};
use crate::world::Light;
use crate::world::light::AreaLight;

/// What arrives past shapes is estimated where no border of a shadow moves across more than this part of a light from one
/// end of a pixel to the other.
pub(super) const WIDE_BORDER: f64 = 0.5;

/// Only where nothing is hidden.
pub(super) const NO_BORDER: f64 = -1.0;

/// A light that reaches a square.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arriving {
    pub(super) light: usize,
    /// The shapes that hide a part of it.
    pub(super) past: Option<List>,
}

impl Quadrature<'_> {
    /// L of a surface under some lights, per primary.
    pub(super) fn radiance(
        &self,
        surface: &Surface,
        shape: u64,
        lights: &[Arriving],
        slopes: Slopes,
    ) -> [Model; 3] {
        let mut sums = self.emission(shape).map(Model::constant);
        for &light in lights {
            let terms = self.light_share(surface, shape, light, slopes);
            sums = [sums[0] + terms[0], sums[1] + terms[1], sums[2] + terms[2]];
        }
        sums
    }

    /// What a shape sends itself, if it is a light that is seen: from the side that the camera is on.
    pub(super) fn emission(&self, shape: u64) -> [f64; 3] {
        let (object, _) = object_and_triangle(shape);
        let index = self.world.objects()[object as usize].emits;
        let light = index.and_then(|index| self.world.lights()[index].value.area());
        let Some(light) = light else {
            return [0.0; 3];
        };
        let center = light.emitter.center();
        let to_viewer = match self.camera.projection() {
            Projection::Perspective { .. } => self.camera.eye().from(center),
            Projection::Orthographic { .. } => -self.camera.forward().get(),
        };
        let is_seen = match light.emitter.surface() {
            // From outside all of it, from inside nothing.
            EmitterSurface::Sphere { radius } => match self.camera.projection() {
                Projection::Perspective { .. } => to_viewer.length() > radius,
                Projection::Orthographic { .. } => true,
            },
            EmitterSurface::Rectangle(_) | EmitterSurface::Disk { .. } => {
                light.emitter.shines_along(center, to_viewer)
            }
        };
        if is_seen { light.luminance() } else { [0.0; 3] }
    }

    /// What one light alone does to a surface, per primary.
    pub(super) fn light_share(
        &self,
        surface: &Surface,
        shape: u64,
        Arriving { light, past }: Arriving,
        slopes: Slopes,
    ) -> [Model; 3] {
        let (object, _) = object_and_triangle(shape);
        let index = self.world.objects()[object as usize].material;
        let material = &self.world.materials()[index].value;
        let origin = self.origin(light, surface.position.bounds());
        let light_value = &self.world.lights()[light].value;
        let space = &mut *self.shadow.borrow_mut();
        let past = past.map(|list| {
            let shapes = self.list(list).iter();
            space.occluders.clear();
            space
                .occluders
                .extend(shapes.map(|&shape| self.solid(shape).occluder()));
            Past {
                occluders: &space.occluders,
                space: &mut space.shadow,
            }
        });
        let lobes = geometry(surface, light_value, origin, material, slopes, past);
        let reflected = self.world.reflected(light, index);
        let (kd, ks) = (reflected.diffuse.0.0, reflected.specular.0.0);
        let of =
            |channel: usize| lobes.diffuse.times(kd[channel]) + lobes.specular.times(ks[channel]);
        [of(0), of(1), of(2)]
    }

    /// The lights that reach a square, if it is known of all whether and how they do; and whether it is proven. Of a light
    /// with an area of which shapes hide a part, only if no border of a shadow moves across more than a part of it, see
    /// [`WIDE_BORDER`].
    pub(super) fn arriving(
        &self,
        told: &Told,
        surface: &Surface,
        border: f64,
    ) -> Option<(Vec<Arriving>, bool)> {
        let mut is_bound = true;
        let mut arriving = Vec::new();
        for light in 0..self.world.lights().len() {
            match self.reaches[told.reaches + light] {
                Reach::Dark => {}
                Reach::Lit => arriving.push(Arriving { light, past: None }),
                Reach::Several(list) if self.most_of_border(surface, light, list) <= border => {
                    is_bound = false;
                    let past = Some(list);
                    arriving.push(Arriving { light, past });
                }
                _ => return None,
            }
        }
        Some((arriving, is_bound))
    }

    /// Whether no border of a shadow in a square is narrower than that, and no light's cone ends in it.
    pub(super) fn has_no_edge(&self, shape: u64, told: &Told, surface: &Surface) -> bool {
        let Some((lights, _)) = self.arriving(told, surface, 1.0) else {
            return false;
        };
        lights.into_iter().all(|arriving| {
            let has_area = self.world.lights()[arriving.light].value.area().is_some();
            has_area || {
                let share = self.light_share(surface, shape, arriving, Slopes::Left);
                share.iter().all(Model::is_known)
            }
        })
    }

    /// L over a square that is smooth, per primary: where nothing jumps, the border of a spot's cone included; and
    /// whether it is proven.
    pub(super) fn smooth_radiance(
        &self,
        told: &Told,
        surface: Option<&Surface>,
        border: f64,
    ) -> Option<([Model; 3], bool)> {
        match (told.primary, surface) {
            (Primary::Background, _) => {
                Some((self.world.background().0.0.map(Model::constant), true))
            }
            (Primary::One(shape), Some(surface)) => {
                let (lights, is_bound) = self.arriving(told, surface, border)?;
                let radiance = self.radiance(surface, shape, &lights, Slopes::Left);
                let is_known = radiance.iter().all(Model::is_known);
                is_known.then_some((radiance, is_bound))
            }
            _ => None,
        }
    }

    /// What R, G, B and A are anywhere in a square.
    pub(super) fn range(
        &mut self,
        square: Square,
        view: &View,
        told: &Told,
        surface: Option<&Surface>,
    ) -> Option<Range> {
        let background = Range::new(self.world.background().0.0, 0.0);
        match (told.primary, surface) {
            (Primary::Background, _) => Some(background),
            (Primary::One(shape), Some(surface)) => {
                self.range_of(shape, surface, Some(told.reaches))
            }
            (Primary::Several(list), _) => {
                let shapes = self.list(list).to_vec();
                let mut all: Option<Range> =
                    self.sees_background(square, &shapes).then_some(background);
                for shape in shapes {
                    let solid = self.solid(shape);
                    let surface = Surface::new(view, &solid).or_else(|| {
                        let (silhouette, _) = solid.silhouette(view)?;
                        Surface::at_silhouette(view, &solid, &silhouette)
                    });
                    let range = match surface {
                        Some(surface) => self.range_of(shape, &surface, None),
                        None => self.range_by_distance(shape),
                    };
                    let range = range?;
                    all = Some(all.map_or(range, |all| all.union(&range)));
                }
                all
            }
            (Primary::One(shape), None) => self.range_by_distance(shape),
            (Primary::Unasked | Primary::Many, _) => None,
        }
    }

    /// Whether any ray through a square may pass by all of some shapes.
    pub(super) fn sees_background(&mut self, square: Square, shapes: &[u64]) -> bool {
        let shaft = self.window(square);
        !shapes.iter().any(|&shape| {
            let answer = self.visibility.shaft_among(
                &shaft,
                ShaftQuestion::Blockage,
                u64::MAX,
                &[shape],
                &mut self.space,
            );
            matches!(answer, ShaftAnswer::All(_))
        })
    }

    /// What a surface that is met in a square is anywhere, as the lights reach it.
    pub(super) fn range_of(
        &mut self,
        shape: u64,
        surface: &Surface,
        known: Option<usize>,
    ) -> Option<Range> {
        let (lists, kept) = (self.lists.len(), self.reaches.len());
        let reaches = known.unwrap_or_else(|| self.reach_all(shape, surface, None, None));
        let mut range = Range::new(self.emission(shape), 1.0);
        for light in 0..self.world.lights().len() {
            let reach = self.reaches[reaches + light];
            if reach == Reach::Dark {
                continue;
            }
            let is_area = self.world.lights()[light].value.area().is_some();
            let terms = if is_area && reach != Reach::Lit {
                // What is below the horizon is not told from what is above.
                [Model::UNKNOWN; 3]
            } else {
                let arriving = Arriving { light, past: None };
                self.light_share(surface, shape, arriving, Slopes::Left)
            };
            let limits = self.limits(Some(surface), shape, light);
            let part = match reach {
                // Nothing else is in the square, and no border of a shadow is narrower: samples meet it.
                Reach::Several(list)
                    if is_area
                        && known.is_some()
                        && self.most_of_border(surface, light, list) < 1.0 =>
                {
                    0.0
                }
                _ => 1.0,
            };
            for (channel, (term, [lowest, highest])) in terms.iter().zip(limits).enumerate() {
                let (least, most) = (term.least().max(lowest), term.most().min(highest));
                range.add(
                    channel,
                    if reach == Reach::Lit {
                        [least, most]
                    } else {
                        [least.min(0.0) * part, most.max(0.0) * part]
                    },
                );
            }
        }
        self.lists.truncate(lists);
        self.reaches.truncate(kept);
        let mut all = range.least.iter().chain(&range.most);
        all.all(|value| value.is_finite()).then_some(range)
    }

    /// How much of a light may come into view between two points of a surface, past shapes of a list: as a part of all
    /// of it, for estimates. The border of a shadow that falls on the light moves across it as far as the points are
    /// apart, the farther the nearer to them the shape is.
    fn most_of_border(&self, surface: &Surface, light: usize, list: List) -> f64 {
        let Some(AreaLight { emitter, .. }) = self.world.lights()[light].value.area() else {
            return f64::INFINITY;
        };
        let (place, apart) = (surface.position.center(), 2.0 * surface.position.radius());
        let distance = (emitter.center().0 - place).length();
        let over_width = match emitter.surface() {
            EmitterSurface::Rectangle([a, b, c, _]) => {
                1.0 / (b - a).length() + 1.0 / (c - b).length()
            }
            EmitterSurface::Disk { radius, .. } | EmitterSurface::Sphere { radius } => 1.0 / radius,
        };
        let shapes = self.list(list).iter();
        let parts = shapes.map(|&shape| {
            let nearest = self.solid(shape).distance(place) - apart;
            if nearest > 0.0 {
                apart * ((distance - nearest).max(0.0) / nearest) * over_width
            } else {
                f64::INFINITY
            }
        });
        parts.fold(0.0, f64::max)
    }

    /// What a shape is anywhere, by its distance from the lights alone.
    pub(super) fn range_by_distance(&self, shape: u64) -> Option<Range> {
        let mut range = Range::new(self.emission(shape), 1.0);
        for light in 0..self.world.lights().len() {
            let limits = self.limits(None, shape, light);
            for (channel, limits) in limits.into_iter().enumerate() {
                range.add(channel, limits);
            }
        }
        let mut all = range.least.iter().chain(&range.most);
        all.all(|value| value.is_finite()).then_some(range)
    }

    /// Between what one light's share of a surface is anywhere, by its distance alone: the lobes are at most 1.
    pub(super) fn limits(
        &self,
        surface: Option<&Surface>,
        shape: u64,
        light: usize,
    ) -> [[f64; 2]; 3] {
        let (object, _) = object_and_triangle(shape);
        let index = self.world.objects()[object as usize].material;
        let value = &self.world.lights()[light].value;
        let bounds = surface.and_then(|surface| surface.position.bounds());
        let origin = self.origin(light, bounds);
        let from_box = bounds.map_or(0.0, |[least, most]| {
            (origin.clamp(least, most) - origin).length()
        });
        let distance = from_box.max(self.solid(shape).distance(origin));
        let geometry = match value {
            Light::Point(_) | Light::Spot(_) | Light::Ies(_) => 1.0 / (distance * distance),
            // No lobe is more than all of what is seen, which is at most a half of all directions.
            Light::Area(light) => {
                let emitter = &light.emitter;
                let [least, most] = emitter.bounds();
                let reach = 0.5 * (most - least).length();
                let near = (distance - reach).max(0.0);
                let solid_angle = (emitter.area() / (near * near)).min(TAU);
                solid_angle / emitter.intensity()
            }
            Light::Sun(_) => 1.0,
        };
        let reflected = self.world.reflected(light, index);
        let (kd, ks) = (reflected.diffuse.0.0, reflected.specular.0.0);
        [0, 1, 2].map(|channel: usize| {
            let parts = [kd[channel], ks[channel]];
            let sum = |bound: fn(f64, f64) -> f64| {
                geometry * parts.iter().map(|&part| bound(part, 0.0)).sum::<f64>()
            };
            [sum(f64::min), sum(f64::max)]
        })
    }
}
