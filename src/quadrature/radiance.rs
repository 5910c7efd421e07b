//! L over a square, and what it may be where it is not known.

use std::f64::consts::TAU;

use super::area::{Past, Slopes};
use super::border::over_width;
use super::light::geometry;
use super::model::Model;
use super::shafts::Known;
use super::surface::Surface;
use super::view::{Square, View};
use super::{List, Primary, Quadrature, Range, Reach, Shadow, Told};
use crate::camera::Projection;
use crate::emitter::Surface as EmitterSurface;
use crate::math::Point;
use crate::visibility::{ShaftAnswer, ShaftQuestion, object_and_triangle};
use crate::world::Light;

/// What arrives past shapes is estimated where no border of a shadow moves across more than this part of a light from one
/// end of a pixel to the other.
pub(super) const WIDE_BORDER: f64 = 0.5;

/// Of what a light sends past shapes, the part that the range of what samples may not have met has, per part of the light
/// that a border moves across: where all of N samples are dark a penumbra may end between them and the pixel's border,
/// half the distance of two samples, N^−½/2, from there, and rises from its end as the distance x. That is
/// ∫ x dx = 1/(8 N) of the light where a border moves across all of it, and of the range 0.45/N is taken
/// (`UNMET_PART` of `render::adaptive`).
const PENUMBRA_END: f64 = 0.125 / 0.45;

/// What arrives in a penumbra is taken to be so much of what would without anything in the way, where it is asked whether to
/// try what takes less time: a guess, which changes no pixel's promise.
pub(super) const LIKELY: f64 = 0.125;

/// L over a square, per primary.
#[derive(Clone, Copy, Debug)]
pub(super) struct Radiance {
    pub(super) models: [Model; 3],
    /// Whether it is proven; else it is estimated from some points.
    pub(super) is_bound: bool,
}

impl Radiance {
    /// It is the same everywhere.
    pub(super) fn constant(radiance: [f64; 3]) -> Self {
        Self {
            models: radiance.map(Model::constant),
            is_bound: true,
        }
    }

    pub(super) fn is_known(&self) -> bool {
        self.models.iter().all(Model::is_known)
    }

    /// With more light, per primary.
    pub(super) fn plus(self, [r, g, b]: [Model; 3]) -> Self {
        let [red, green, blue] = self.models;
        Self {
            models: [red + r, green + g, blue + b],
            ..self
        }
    }
}

/// Which radiance of a square a range is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    All,
    /// What samples of a pixel may not meet: not what penumbrae as wide as it add.
    Unsampled,
}

/// A light that reaches a square.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arriving {
    pub(super) light: usize,
    /// The shapes that hide a part of it.
    pub(super) past: Option<List>,
    /// No border of a shadow moves across more than this part of it.
    border: f64,
}

impl Arriving {
    /// With nothing in the way.
    pub(super) fn alone(light: usize) -> Self {
        Self {
            light,
            past: None,
            border: 0.0,
        }
    }
}

impl Quadrature<'_> {
    /// L of a surface that reaches are told of, where all lights are known to arrive there: see [`Self::arriving`].
    pub(super) fn radiance(
        &self,
        surface: &Surface,
        shape: u64,
        reaches: usize,
        border: Option<f64>,
        slopes: Slopes,
    ) -> Option<Radiance> {
        let mut radiance = Radiance::constant(self.emission(shape));
        for light in self.arriving(reaches, border)? {
            radiance = radiance.plus(self.share(surface, shape, light, slopes));
            radiance.is_bound &= light.past.is_none();
        }
        Some(radiance)
    }

    /// The part of a light that borders of shadows, or the horizon of what is round, cross over a surface.
    pub(super) fn border_over(&self, surface: &Surface, arriving: &Arriving) -> f64 {
        let Arriving { light, border, .. } = *arriving;
        let Light::Area(light) = &self.world.lights()[light].value else {
            return border;
        };
        if surface.plane().is_some() {
            return border;
        }
        let way = light.emitter.center().0 - surface.position.center();
        let turned = 2.0 * surface.normal().radius();
        border + turned * way.length() * over_width(&light.emitter)
    }

    /// What one light alone does to a surface, by its value in the middle if that is near enough past shapes.
    fn share(&self, surface: &Surface, shape: u64, light: Arriving, slopes: Slopes) -> [Model; 3] {
        // How T changes along a surface is not known from one value.
        let has_panes = |list: List| self.list(list).iter().any(|&shape| self.is_pane(shape));
        if light.past.is_some_and(|list| !has_panes(list)) && slopes != Slopes::None {
            let border = self.border_over(surface, &light);
            let limits = self.limits(Some(surface), shape, light.light);
            let most = limits.map(|[least, most]| most.max(-least));
            let likely = most.map(|most| LIKELY * most);
            if self.is_fine(likely, most.map(|most| 0.5 * border * most)) {
                let share = self.light_share(surface, shape, light, Slopes::Glimpsed);
                let error = share.map(|model| {
                    if slopes == Slopes::Told {
                        model.rest
                    } else {
                        model.mean_error()
                    }
                });
                if self.is_fine(share.map(|model| model.least()), error) {
                    return share;
                }
            }
        }
        self.light_share(surface, shape, light, slopes)
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
        arriving: Arriving,
        slopes: Slopes,
    ) -> [Model; 3] {
        let Arriving { light, past, .. } = arriving;
        let (object, _) = object_and_triangle(shape);
        let index = self.world.objects()[object as usize].material;
        let material = &self.world.materials()[index].value;
        let origin = self.origin(light, surface.position.bounds());
        let light_value = &self.world.lights()[light].value;
        let Shadow {
            shadow,
            occluders,
            kept,
            panes,
        } = &mut *self.shadow.borrow_mut();
        let past = past.map(|list| {
            occluders.clear();
            panes.clear();
            for &shape in self.list(list) {
                let occluder = self.solid(shape).occluder();
                if self.is_pane(shape) {
                    let (object, triangle) = object_and_triangle(shape);
                    // Round ones are told of elsewhere.
                    if let Light::Area(light) = light_value {
                        let from = (&light.emitter, Point(surface.position.center()));
                        panes.add(self.world, [object, triangle], occluder, from);
                    }
                } else {
                    occluders.push(occluder);
                }
            }
            Past {
                occluders,
                panes,
                kept,
                border: self.border_over(surface, &arriving),
                space: shadow,
            }
        });
        let lobes = geometry(surface, light_value, origin, material, slopes, past);
        let reflected = self.world.reflected(light, index);
        let (kd, ks) = (reflected.diffuse.0.0, reflected.specular.0.0);
        let of =
            |channel: usize| lobes.diffuse.times(kd[channel]) + lobes.specular.times(ks[channel]);
        [of(0), of(1), of(2)]
    }

    /// The lights that reach a square, if it is known of all whether and how they do. Of a light with an area of which shapes
    /// hide a part, only if no border of a shadow moves across more than a part of it, see [`WIDE_BORDER`]; `None` is only
    /// where nothing is hidden.
    pub(super) fn arriving(
        &self,
        reaches: usize,
        border: Option<f64>,
    ) -> Option<impl Iterator<Item = Arriving>> {
        let reaches = &self.reaches[reaches..][..self.world.lights().len()];
        let is_known = |reach: &Reach| match *reach {
            Reach::Lit | Reach::Dark => true,
            Reach::Partial { border: widest, .. } => border.is_some_and(|border| widest <= border),
            Reach::Unasked
            | Reach::Terminator
            | Reach::Several(_)
            | Reach::Dimmed
            | Reach::Many => false,
        };
        let arriving = reaches
            .iter()
            .enumerate()
            .filter_map(|(light, reach)| match *reach {
                Reach::Partial { list, border } => Some(Arriving {
                    light,
                    past: Some(list),
                    border,
                }),
                Reach::Dark => None,
                _ => Some(Arriving::alone(light)),
            });
        reaches.iter().all(is_known).then_some(arriving)
    }

    /// Whether no border of a shadow in a square is narrower than that, and no light's cone ends in it.
    pub(super) fn has_no_edge(&self, shape: u64, told: &Told, surface: &Surface) -> bool {
        let Some(mut lights) = self.arriving(told.reaches, Some(1.0)) else {
            return false;
        };
        lights.all(|arriving| {
            let has_area = self.world.lights()[arriving.light].value.area().is_some();
            has_area || {
                let share = self.light_share(surface, shape, arriving, Slopes::Left);
                share.iter().all(Model::is_known)
            }
        })
    }

    /// L over a square that is smooth: where nothing jumps, the border of a spot's cone included.
    pub(super) fn smooth_radiance(
        &self,
        told: &Told,
        surface: Option<&Surface>,
        border: Option<f64>,
    ) -> Option<Radiance> {
        match (told.primary, surface) {
            (Primary::Background, _) => Some(Radiance::constant(self.world.background().0.0)),
            (Primary::One(shape), Some(surface)) => self
                .radiance(surface, shape, told.reaches, border, Slopes::Left)
                .filter(Radiance::is_known),
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
        content: Content,
    ) -> Option<Range> {
        let background = Range::new(self.world.background().0.0, 0.0);
        match (told.primary, surface) {
            (Primary::Background, _) => Some(background),
            (Primary::One(shape), Some(surface)) => self.range_of(shape, surface, told, content),
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
                        Some(surface) => {
                            let (lists, kept) = (self.lists.len(), self.reaches.len());
                            let reaches = self.reach_all(shape, &surface, Known::Nothing);
                            let told = Told { reaches, ..*told };
                            let range = self.range_of(shape, &surface, &told, content);
                            self.lists.truncate(lists);
                            self.reaches.truncate(kept);
                            range
                        }
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
    fn range_of(
        &self,
        shape: u64,
        surface: &Surface,
        told: &Told,
        content: Content,
    ) -> Option<Range> {
        let mut range = Range::new(self.emission(shape), 1.0);
        for light in 0..self.world.lights().len() {
            let reach = self.reaches[told.reaches + light];
            if reach == Reach::Dark {
                continue;
            }
            let is_area = self.world.lights()[light].value.area().is_some();
            let terms = if is_area && reach != Reach::Lit {
                // What is below the horizon is not told from what is above.
                [Model::UNKNOWN; 3]
            } else {
                let arriving = Arriving::alone(light);
                self.light_share(surface, shape, arriving, Slopes::Left)
            };
            let limits = self.limits(Some(surface), shape, light);
            let part = match reach {
                // Nothing else is in the square, and no border of a shadow is narrower: samples meet all but its end.
                Reach::Partial { border, .. }
                    if content == Content::Unsampled
                        && told.primary == Primary::One(shape)
                        && border < 1.0 =>
                {
                    PENUMBRA_END * border
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
        let mut all = range.least.iter().chain(&range.most);
        all.all(|value| value.is_finite()).then_some(range)
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
