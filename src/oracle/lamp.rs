//! Lights as the oracle has them: from what was written.

use super::area::Area;
use super::components::Components;
use super::luminaire::Luminaire;
use super::spot::Cone;
use super::value::{Extent, Palette};
use super::vector::{Vector, WideVector, subtract, unit, widened};
use crate::scene::Light;

/// A light.
#[derive(Clone, Debug)]
pub(super) struct Lamp {
    pub(super) name: String,
    pub(super) place: Place,
    /// I in candela, or in W·sr⁻¹·nm⁻¹; of a spot on its axis. Of a sun E in lux, or in W·m⁻²·nm⁻¹;
    /// of an area L in cd/m², or in W·m⁻²·sr⁻¹·nm⁻¹.
    pub(super) intensity: Components,
    /// What a spot shines into; `None` is all directions.
    pub(super) cone: Option<Cone>,
    /// What a luminaire sends where.
    pub(super) luminaire: Option<Luminaire>,
    /// What has an area, around its place.
    pub(super) area: Option<Area>,
}

/// Where light comes from.
#[derive(Clone, Copy, Debug)]
pub(super) enum Place {
    /// p_L
    At(WideVector),
    /// The unit vector to a sun.
    Toward(WideVector),
}

/// How far along the way to a sun something is looked for that stands between, in m: beyond all coordinates of a scene.
pub(super) const BEYOND_ALL: f64 = 1e33;

impl Lamp {
    pub(super) fn new(name: &str, light: &Light, palette: &Palette, reference: Vector) -> Self {
        match light {
            Light::Point {
                position,
                intensity,
                group: _,
            } => Self {
                name: name.to_owned(),
                place: Place::At(subtract(widened(position.value), widened(reference))),
                intensity: palette.light(&intensity.value),
                cone: None,
                luminaire: None,
                area: None,
            },
            Light::Spot {
                position,
                aim,
                intensity,
                inner,
                outer,
                falloff,
                group: _,
            } => {
                let angles = [inner.value, outer.value];
                let cone = Cone::new(position.value, aim, angles, *falloff);
                Self {
                    name: name.to_owned(),
                    place: Place::At(subtract(widened(position.value), widened(reference))),
                    intensity: palette.light_into(&intensity.value, cone.flux()),
                    cone: Some(cone),
                    luminaire: None,
                    area: None,
                }
            }
            Light::Ies {
                position,
                aim,
                up,
                file: _,
                luminaire,
                intensity,
                scale,
                group: _,
            } => {
                let up = up.map(|up| up.value);
                let luminaire = Luminaire::new(position.value, aim, up, luminaire);
                Self {
                    name: name.to_owned(),
                    place: Place::At(subtract(widened(position.value), widened(reference))),
                    intensity: palette
                        .light_into(&intensity.value, luminaire.flux())
                        .scaled(scale.value),
                    cone: None,
                    luminaire: Some(luminaire),
                    area: None,
                }
            }
            Light::Area {
                shape,
                luminance,
                visible,
                samples: _,
                group: _,
            } => {
                let area = Area::new(shape, *visible, reference);
                // Without a direction there is nothing of it.
                let nothing = || Extent {
                    intensity: f64::INFINITY,
                    flux: f64::INFINITY,
                };
                let extent = area.as_ref().map_or_else(nothing, Area::extent);
                Self {
                    name: name.to_owned(),
                    place: Place::At(subtract(widened(shape.center().value), widened(reference))),
                    intensity: palette.sized(&luminance.value, extent),
                    cone: None,
                    luminaire: None,
                    area,
                }
            }
            Light::Sun {
                direction,
                illuminance,
                group: _,
            } => Self {
                name: name.to_owned(),
                place: Place::Toward(
                    unit(widened(direction.value.map(|part| -part))).unwrap_or_default(),
                ),
                intensity: palette.light(&illuminance.value),
                cone: None,
                luminaire: None,
                area: None,
            },
        }
    }
}
