//! Lights: where they are and point, and how strong they are.

use std::sync::Arc;

use glam::DVec3;

use super::color::{Emission, Spread};
use super::{Builder, Reported, as_written};
use crate::math::{Direction, Point};
use crate::scene::{self, Aim, Problem, Spanned, Value};
use crate::spectrum::Spectrum;
use crate::units::{Intensity, Rgb};
use crate::world::light::{Cone, IesLight, Light, PointLight, SpotLight, SunLight};

/// An `up` this near to the axis, as a sine, is along it.
const ALONG: f64 = 1e-6;

impl Builder<'_> {
    /// A light and, where light is carried so, its spectrum. After an error the world is dropped.
    pub(super) fn light(
        &mut self,
        entry: &scene::Entry<scene::Light>,
    ) -> (Light, Option<Spectrum>) {
        let name = || format!("light `{}`", entry.name);
        self.note_spectra([&entry.value.size().value], name);
        match &entry.value {
            scene::Light::Point {
                position,
                intensity,
                group: _,
            } => {
                let emission = self.emission("intensity", intensity, Spread::EVERYWHERE);
                let light = PointLight {
                    position: self.light_position(*position),
                    intensity: Intensity(Rgb(emission.rgb)),
                };
                (Light::Point(light), emission.spectrum)
            }
            scene::Light::Spot {
                position,
                aim,
                intensity,
                inner,
                outer,
                falloff,
                group: _,
            } => {
                let cone = self.cone(*inner, *outer, *falloff);
                let Emission { rgb, spectrum } = self.spot_emission(intensity, cone);
                let axis = self.axis("position", *position, aim);
                let light = SpotLight {
                    position: self.light_position(*position),
                    axis: axis.unwrap_or_else(|Reported| {
                        Direction::new(DVec3::Z).expect("z is a direction")
                    }),
                    intensity: Intensity(Rgb(rgb)),
                    cone: cone.unwrap_or_else(|Reported| {
                        Cone::new(0.0, 1.0, *falloff).expect("1° is a cone")
                    }),
                };
                (Light::Spot(light), spectrum)
            }
            scene::Light::Ies {
                position,
                aim,
                up,
                file: _,
                luminaire,
                intensity,
                scale,
                group: _,
            } => {
                let photometry = &luminaire.photometry;
                let spread = Spread::of_flux(photometry.lumens() / photometry.peak().candela);
                let emission = self.emission("intensity", intensity, spread);
                let Emission { rgb, spectrum } = self.scaled(emission, *scale);
                let axis = self.axis("position", *position, aim);
                let (axis, up) = axis
                    .and_then(|axis| Ok((axis, self.up(axis, *up)?)))
                    .unwrap_or_else(|Reported| {
                        (
                            Direction::new(DVec3::Z).expect("z is a direction"),
                            DVec3::Y,
                        )
                    });
                let light = IesLight::new(
                    self.light_position(*position),
                    axis,
                    up,
                    Intensity(Rgb(rgb)),
                    Arc::clone(luminaire),
                );
                (Light::Ies(light.expect("`up` is across")), spectrum)
            }
            scene::Light::Area {
                shape,
                luminance,
                visible,
                samples,
                group: _,
            } => self.area_light(shape, luminance, *visible, *samples),
            scene::Light::Sun {
                direction,
                illuminance,
                group: _,
            } => {
                let Emission { rgb, spectrum } =
                    self.emission("illuminance", illuminance, Spread::EVERYWHERE);
                let way = self.direction("direction", *direction);
                let to_light = way.ok().and_then(|way| Direction::new(-way.get()));
                let light = SunLight {
                    to_light: to_light
                        .unwrap_or_else(|| Direction::new(DVec3::Z).expect("z is a direction")),
                    illuminance: Intensity(Rgb(rgb)),
                };
                (Light::Sun(light), spectrum)
            }
        }
    }

    /// The group of a light, which has a name that no light has.
    pub(super) fn light_group(&mut self, light: &scene::Light) -> Option<String> {
        let Spanned { value: name, span } = light.group()?;
        if let Some(why) = scene::name_objection(name, true) {
            let problem = Problem::BadName {
                what: "a group of lights",
                name: name.clone(),
                why,
            };
            self.report(*span, problem);
        } else if self.light_names.contains(name.as_str()) {
            let conflict = format!(
                "there is a light `{name}` as well as a group, whose layers would have one name, expected another \
                 name for one of them"
            );
            self.report(*span, Problem::Conflict(conflict));
        }
        Some(name.clone())
    }

    fn light_position(&mut self, position: Spanned<[f64; 3]>) -> Point {
        self.position("position", position)
            .unwrap_or(Point(DVec3::ZERO))
    }

    /// Of a flux, what a cone without an error makes of it.
    fn spot_emission(
        &mut self,
        intensity: &Spanned<Value>,
        cone: Result<Cone, Reported>,
    ) -> Emission {
        let spread = match cone {
            Ok(cone) => Spread::of_flux(cone.flux()),
            Err(Reported) => Spread::EVERYWHERE,
        };
        self.emission("intensity", intensity, spread)
    }

    fn cone(
        &mut self,
        inner: Spanned<f64>,
        outer: Spanned<f64>,
        falloff: scene::Falloff,
    ) -> Result<Cone, Reported> {
        let legal_outer = |angle: f64| (Cone::NARROWEST..=Cone::WIDEST).contains(&angle);
        let outer_angle = self.number(
            "outer",
            outer,
            legal_outer,
            "an angle from the axis from 1e-6 to 90 degrees",
        );
        let inner_angle = self.number(
            "inner",
            inner,
            |angle| (0.0..=Cone::WIDEST).contains(&angle),
            "an angle from the axis from 0 to 90 degrees",
        );
        let (inner_angle, outer_angle) = (inner_angle?, outer_angle?);
        Cone::new(inner_angle, outer_angle, falloff).ok_or_else(|| {
            let conflict = format!(
                "`inner` is {} degrees and `outer` {}, expected an `inner` of at most `outer`: it has its \
                 full intensity up to `inner` and is dark from `outer` on",
                as_written(inner_angle),
                as_written(outer_angle),
            );
            self.report(inner.span, Problem::Conflict(conflict));
            Reported
        })
    }

    /// A factor of a light.
    fn scaled(&mut self, emission: Emission, written: Spanned<f64>) -> Emission {
        let largest = emission.rgb.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let legal =
            |scale: f64| (0.0..=1e30).contains(&scale) && scale * largest <= f64::from(f32::MAX);
        let expected =
            "a factor from 0 to 1e30 that makes light of at most 3.4e38 in every channel";
        let scale = self
            .number("scale", written, legal, expected)
            .unwrap_or(0.0);
        Emission {
            rgb: emission.rgb.map(|channel| channel * scale),
            spectrum: emission.spectrum.map(|spectrum| spectrum.scaled(scale)),
        }
    }

    /// What horizontal angle 0 is towards, or a side runs along: where nothing is said, or what is said is along the
    /// light's way, y, or −z for light along that.
    pub(super) fn up(
        &mut self,
        axis: Direction,
        written: Option<Spanned<[f64; 3]>>,
    ) -> Result<DVec3, Reported> {
        let written = match written {
            Some(written) => Some(self.direction("up", written)?.get()),
            None => None,
        };
        let is_across = |up: &DVec3| axis.get().cross(*up).length() > ALONG;
        let chosen = written.into_iter().chain([DVec3::Y]).find(is_across);
        Ok(chosen.unwrap_or(DVec3::NEG_Z))
    }

    /// The unit vector along which a light points.
    pub(super) fn axis(
        &mut self,
        key: &'static str,
        position: Spanned<[f64; 3]>,
        aim: &Aim,
    ) -> Result<Direction, Reported> {
        match *aim {
            Aim::Direction(written) => {
                let vector = self.direction("direction", written)?.get();
                Ok(Direction::new(vector).expect("a normal has a direction"))
            }
            Aim::LookAt(written) => {
                let look_at = self.vector("look_at", written)?;
                let way = look_at - DVec3::from_array(position.value);
                // What is wrong with the position is said elsewhere.
                if !way.is_finite() {
                    return Err(Reported);
                }
                Direction::new(way).ok_or_else(|| {
                    let conflict = format!(
                        "`look_at` is the same point as `{key}`, expected a point to shine at, or a `direction`"
                    );
                    self.report(written.span, Problem::Conflict(conflict));
                    Reported
                })
            }
        }
    }
}
