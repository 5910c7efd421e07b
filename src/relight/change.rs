//! What becomes of each share: from a setting to the numbers that channels are multiplied by.

use super::color::{self, Working};
use super::error::RelightError;
use super::record::{self, LightRecord};
use super::setting::Setting;
use super::shares::{Share, Shares};
use crate::exr::StoredExr;
use crate::scene::{ColorSpace, Transport};
use crate::spectrum::Spectrum;

/// Colors of lights that are one color but for their last digits differ by no more, relatively.
const ROUNDING: f64 = 1e-12;

/// A sum over channels: each by its place, and what it is multiplied by.
pub(super) type Terms = Vec<(usize, f64)>;

/// What becomes of a share.
#[derive(Clone, Debug)]
pub(super) struct Change {
    /// What its intensity is multiplied by.
    pub(super) factor: f64,
    pub(super) color: Recolor,
}

/// What becomes of its color.
#[derive(Clone, Debug)]
pub(super) enum Recolor {
    /// It stays.
    None,
    /// R, G and B are multiplied by these, the factor among them.
    Rgb([f64; 3]),
    /// R, G and B are made of what was reflected of any spectrum, the factor among them.
    Spectral {
        /// Of what flat reflectances reflect.
        flat: [f64; 3],
        /// Of what each curve reflects.
        curves: Vec<[f64; 3]>,
    },
}

impl Change {
    /// What R, G or B of a share's layer is made of.
    pub(super) fn terms(&self, share: &Share, layer: [usize; 3], channel: usize) -> Terms {
        match (&self.color, &share.relight) {
            (Recolor::Spectral { flat, curves }, Some(relight)) => {
                let flat = relight.flat.map(|place| (place, flat[channel]));
                let curves = relight.curves.iter().zip(curves);
                let curves = curves.map(|(&place, rgb)| (place, rgb[channel]));
                flat.into_iter().chain(curves).collect()
            }
            (Recolor::Spectral { .. } | Recolor::None | Recolor::Rgb(_), _) => {
                vec![(layer[channel], self.ratio(channel))]
            }
        }
    }

    /// What R, G or B of what the lights of a share send themselves is made of.
    pub(super) fn terms_of_emission(
        &self,
        share: &Share,
        emission: [usize; 3],
        channel: usize,
    ) -> Terms {
        let spectral = share.relight.as_ref().and_then(|relight| relight.emission);
        match (&self.color, spectral) {
            (Recolor::Spectral { flat, .. }, Some(place)) => vec![(place, flat[channel])],
            (Recolor::Spectral { .. } | Recolor::None | Recolor::Rgb(_), _) => {
                vec![(emission[channel], self.ratio(channel))]
            }
        }
    }

    /// What R, G or B is multiplied by, where that is all.
    pub(super) fn ratio(&self, channel: usize) -> f64 {
        match &self.color {
            Recolor::None | Recolor::Spectral { .. } => self.factor,
            Recolor::Rgb(ratios) => ratios[channel],
        }
    }

    pub(super) fn is_spectral(&self) -> bool {
        match self.color {
            Recolor::None | Recolor::Rgb(_) => false,
            Recolor::Spectral { .. } => true,
        }
    }
}

/// What becomes of each share, `None` where it stays as it is; the record of the lights becomes that of the new ones.
pub(super) fn changes(
    stored: &StoredExr,
    shares: &mut Shares,
    settings: &[Setting],
) -> Result<Vec<Option<Change>>, RelightError> {
    let mut changes = vec![None; shares.list.len()];
    let mut spectral = None;
    for (index, setting) in settings.iter().enumerate() {
        let name = setting.name();
        if settings[..index].iter().any(|other| other.name() == name) {
            return Err(RelightError::Twice(name.to_owned()));
        }
        let place = shares.place(name)?;
        if setting.is_nothing() {
            continue;
        }
        let share = &shares.list[place];
        if let Some(light) = shares.seen_of(share) {
            let share = share.name.clone();
            return Err(RelightError::Seen { light, share });
        }
        let factor = setting.factor();
        let (color, rgb) = match setting.color() {
            None => (Recolor::None, None),
            Some(_) if share.is_background => return Err(RelightError::BackgroundColor),
            Some(_) => {
                let record = shares.record.as_deref();
                let record = record.ok_or_else(|| RelightError::NoColors(name.to_owned()))?;
                let lights: Vec<&LightRecord> = share.lights.iter().map(|&l| &record[l]).collect();
                let working = working(stored)?;
                let (color, rgb) = match working.transport {
                    Transport::Rgb | Transport::Auto => of_rgb(setting, &lights, working)?,
                    Transport::Spectral => {
                        if spectral.is_none() {
                            spectral = Some(record::reflectances(stored)?);
                        }
                        let curves = spectral.as_deref().unwrap_or_default();
                        of_spectra(setting, share, &lights, working, curves)?
                    }
                };
                (color, Some(rgb))
            }
        };
        for (number, &light) in share.lights.iter().enumerate() {
            let Some(record) = shares
                .record
                .as_mut()
                .and_then(|record| record.get_mut(light))
            else {
                continue;
            };
            record.candela *= factor;
            record.rgb = match &rgb {
                None => record.rgb.map(|channel| channel * factor),
                Some(rgb) => rgb[number],
            };
        }
        changes[place] = Some(Change { factor, color });
    }
    Ok(changes)
}

/// What colors of the file depend on.
fn working(stored: &StoredExr) -> Result<Working, RelightError> {
    let id = stored.color().interop_id.as_deref();
    let mut spaces = ColorSpace::ALL.into_iter();
    let space = spaces.find(|space| id == Some(space.interop_id()));
    Ok(Working {
        space: space.ok_or(RelightError::NoColorSpace)?,
        observer: record::observer(stored)?,
        transport: record::transport(stored)?,
    })
}

/// I in cd for each primary of lights of these candelas in the new color, and what R, G and B are multiplied by.
fn of_rgb(
    setting: &Setting,
    lights: &[&LightRecord],
    working: Working,
) -> Result<(Recolor, Vec<[f64; 3]>), RelightError> {
    let name = || setting.name().to_owned();
    let mut rgb = Vec::new();
    for light in lights {
        let world = color::world(setting, light.candela * setting.factor(), working)?;
        rgb.push(world.lights()[0].value.intensity().0.0);
    }
    if !are_of_one_color(lights) {
        return Err(RelightError::MixedGroup(name()));
    }
    let mut ratios = [1.0; 3];
    for (channel, color) in ["red", "green", "blue"].into_iter().enumerate() {
        for (light, new) in lights.iter().zip(&rgb) {
            let (old, new) = (light.rgb[channel], new[channel]);
            if old != 0.0 {
                ratios[channel] = new / old;
            } else if new != 0.0 {
                return Err(RelightError::NoLight {
                    name: name(),
                    channel: color,
                });
            }
        }
    }
    Ok((Recolor::Rgb(ratios), rgb))
}

/// Whether all lights have one chromaticity, those that are dark aside.
fn are_of_one_color(lights: &[&LightRecord]) -> bool {
    let mut lit = lights.iter().filter(|light| light.candela > 0.0);
    let of_one_candela = |light: &LightRecord| light.rgb.map(|channel| channel / light.candela);
    let Some(first) = lit.next() else {
        return true;
    };
    let first = of_one_candela(first);
    let brightest = first
        .into_iter()
        .fold(0.0, |most: f64, channel| most.max(channel.abs()));
    lit.all(|light| {
        let pairs = of_one_candela(light).into_iter().zip(first);
        pairs
            .into_iter()
            .all(|(a, b)| (a - b).abs() <= ROUNDING * brightest)
    })
}

/// The same where light was carried spectrally.
fn of_spectra(
    setting: &Setting,
    share: &Share,
    lights: &[&LightRecord],
    working: Working,
    curves: &[Spectrum],
) -> Result<(Recolor, Vec<[f64; 3]>), RelightError> {
    let relight = share.relight.as_ref();
    let Some(relight) = relight.filter(|it| it.emission.is_some() || share.emission.is_none())
    else {
        return Err(RelightError::NotStored(share.name.clone()));
    };
    let world = color::world(setting, 1.0, working)?;
    let spectra = world.spectra().expect("light is carried spectrally there");
    let (colorimetry, light) = (spectra.colorimetry(), spectra.light(0));
    let factor = setting.factor();
    let rgb = world.lights()[0].value.intensity().0.0;
    let reflected = |curve: &Spectrum| {
        let reflected = colorimetry.light(&light.times(curve));
        reflected.map(|channel| channel * factor)
    };
    let Some(curves) = curves.get(..relight.curves.len()) else {
        return Err(RelightError::Header {
            attribute: "candela:reflectances",
            reason: format!(
                "`relight_{}` has more channels than there are curves",
                share.name
            ),
        });
    };
    let color = Recolor::Spectral {
        flat: rgb.map(|channel| channel * factor),
        curves: curves.iter().map(reflected).collect(),
    };
    let of_lights = lights.iter();
    let of_lights = of_lights.map(|light| rgb.map(|channel| channel * light.candela * factor));
    Ok((color, of_lights.collect()))
}
