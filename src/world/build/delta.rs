//! Perfectly smooth materials: mirrors, metals, glass, panes, and coats.

use std::sync::Arc;

use super::color::Bound;
use super::{Builder, Reported, as_written};
use crate::optics;
use crate::scene::{self, Glass as Written, GlassIndex, Metal, Mirror, Problem, Spanned, Value};
use crate::spectrum::Spectrum;
use crate::world::delta::{Absorption, ComplexIndex, Delta, Glass, Tint};

/// The refractive index of what lets light through.
const TRANSPARENT: (f64, f64, &str) = (1.0, 4.0, "a refractive index from 1 to 4");

/// n and k of a metal.
const METALLIC: (f64, f64, &str) = (0.0, 100.0, "a number from 0 to 100");

/// The helium d line in nm, at which the index of a glass is told.
const D_LINE: f64 = 587.5618;

/// A refractive index, as far as a scene says it.
enum Index {
    Number(f64),
    Curve(Arc<Spectrum>),
}

impl Index {
    fn spectrum(&self) -> Spectrum {
        match self {
            Self::Number(n) => Spectrum::constant(*n),
            Self::Curve(spectrum) => Spectrum::clone(spectrum),
        }
    }

    fn at_d_line(&self) -> f64 {
        match self {
            Self::Number(n) => *n,
            Self::Curve(spectrum) => spectrum.at(D_LINE),
        }
    }
}

impl Builder<'_> {
    /// What a material reflects like a mirror or lets through; `None` of lobes alone, and after an error.
    pub(super) fn delta(&mut self, entry: &scene::Entry<scene::Material>) -> Option<Delta> {
        let name = || format!("material `{}`", entry.name);
        match &entry.value {
            scene::Material::Phong(lobes) | scene::Material::NormalizedPhong(lobes) => {
                self.coat(lobes.coat.as_ref()?).ok()
            }
            scene::Material::Mirror(mirror) => {
                self.note_spectra([&mirror.reflectance.value], name);
                let reflection = self.reflection("reflectance", &mirror.reflectance, Bound::Albedo);
                Some(Delta::Mirror(Tint {
                    rgb: reflection.rgb,
                    reflectance: reflection.reflectance.filter(|_| self.is_spectral),
                    schlick: mirror.schlick,
                }))
            }
            scene::Material::Metal(metal) => {
                self.spectral_values.push(name());
                self.metal(metal).ok()
            }
            scene::Material::Glass(glass) => {
                self.note_spectra([&glass.absorption.value], name);
                self.glass(glass).ok()
            }
            scene::Material::Pane(pane) => {
                let (least, most, expected) = TRANSPARENT;
                let legal = |n| (least..=most).contains(&n);
                let n = self.number("n", pane.n, legal, expected).ok()?;
                Some(Delta::Pane { n })
            }
        }
    }

    fn coat(&mut self, coat: &Mirror) -> Result<Delta, Reported> {
        let expected = "a number from 0 to 1: a coat is clear";
        let Value::Uniform(reflectance) = coat.reflectance.value else {
            let value = "a color".to_owned();
            self.out_of_range("reflectance", coat.reflectance.span, value, expected);
            return Err(Reported);
        };
        let written = Spanned::new(reflectance, coat.reflectance.span);
        let legal = |reflectance| (0.0..=1.0).contains(&reflectance);
        Ok(Delta::Coat {
            reflectance: self.number("reflectance", written, legal, expected)?,
            schlick: coat.schlick,
        })
    }

    fn metal(&mut self, metal: &Metal) -> Result<Delta, Reported> {
        let index = match metal {
            Metal::Preset(name) => {
                let Some(known) = optics::Metal::named(&name.value) else {
                    return Err(self.unknown("metal", name, optics::Metal::names()));
                };
                ComplexIndex {
                    n: Spectrum::from_fn(|nm| known.index(nm)[0]),
                    k: Spectrum::from_fn(|nm| known.index(nm)[1]),
                }
            }
            Metal::Indices { n, k } => {
                let (n, k) = (self.index("n", n, METALLIC), self.index("k", k, METALLIC));
                ComplexIndex {
                    n: n?.spectrum(),
                    k: k?.spectrum(),
                }
            }
        };
        Ok(Delta::Metal(Arc::new(index)))
    }

    fn glass(&mut self, glass: &Written) -> Result<Delta, Reported> {
        let index = match &glass.index {
            GlassIndex::Value(value) => self.index("n", value, TRANSPARENT),
            GlassIndex::Sellmeier(name) => match optics::Glass::named(&name.value) {
                Some(known) => Ok(Index::Curve(Arc::new(Spectrum::from_fn(|nm| {
                    known.dispersion.index(nm)
                })))),
                None => Err(self.unknown("glass", name, optics::Glass::names())),
            },
        };
        let absorption = self.reflection("absorption", &glass.absorption, Bound::None);
        let index = index?;
        if let (Index::Number(_), GlassIndex::Value(value)) = (&index, &glass.index)
            && glass.dispersion
        {
            const CONFLICT: &str = "`dispersion` takes an index for each wavelength, and this one is the same for all; \
                                    expected `sellmeier = \"N-BK7\"` or a curve for `n`, or no `dispersion`";
            self.report(value.span, Problem::Conflict(CONFLICT.to_owned()));
            return Err(Reported);
        }
        let n = match &glass.index {
            // The formula itself, without the grid.
            GlassIndex::Sellmeier(name) => optics::Glass::named(&name.value)
                .map_or(index.at_d_line(), |known| known.dispersion.index(D_LINE)),
            GlassIndex::Value(_) => index.at_d_line(),
        };
        Ok(Delta::Glass(Glass {
            n,
            dispersion: match index {
                Index::Curve(spectrum) if glass.dispersion => Some(spectrum),
                Index::Curve(_) | Index::Number(_) => None,
            },
            absorption: (!absorption.is_black()).then(|| Absorption {
                rgb: absorption.rgb,
                spectrum: absorption.reflectance.filter(|_| self.is_spectral),
            }),
        }))
    }

    /// A refractive index within a range.
    fn index(
        &mut self,
        key: &'static str,
        written: &Spanned<Value>,
        (least, most, expected): (f64, f64, &str),
    ) -> Result<Index, Reported> {
        let index = match &written.value {
            Value::Uniform(n) => Index::Number(*n),
            Value::Curve(curve) => Index::Curve(Arc::new(curve.spectrum())),
            // What moves is a sum of numbers and curves.
            Value::Mixed(mixture) => {
                let mut sum = vec![0.0; crate::spectrum::SAMPLES];
                let mut are_numbers = true;
                for (weight, part) in &mixture.0 {
                    let part = Spanned::new(part.clone(), written.span);
                    let part = self.index(key, &part, (least, most, expected))?;
                    are_numbers &= matches!(part, Index::Number(_));
                    for (sum, value) in sum.iter_mut().zip(part.spectrum().values()) {
                        *sum += weight * value;
                    }
                }
                if are_numbers {
                    Index::Number(sum[0])
                } else {
                    let mut values = sum.into_iter();
                    let value = |_| values.next().unwrap_or_default();
                    Index::Curve(Arc::new(Spectrum::from_fn(value)))
                }
            }
            _ => {
                let value = "a color".to_owned();
                self.out_of_range(key, written.span, value, expected);
                return Err(Reported);
            }
        };
        let out_of_range = match &index {
            Index::Number(n) => (!(least..=most).contains(n)).then(|| as_written(*n)),
            Index::Curve(spectrum) => {
                let mut pairs = crate::spectrum::wavelengths().zip(spectrum.values());
                let wrong = pairs.find(|(_, n)| !(least..=most).contains(*n));
                wrong.map(|(nm, n)| format!("{} at {nm} nm", as_written(*n)))
            }
        };
        match out_of_range {
            Some(value) => {
                self.out_of_range(key, written.span, value, expected);
                Err(Reported)
            }
            None => Ok(index),
        }
    }

    fn unknown<'n>(
        &mut self,
        what: &'static str,
        name: &Spanned<String>,
        names: impl Iterator<Item = &'n str>,
    ) -> Reported {
        let problem = Problem::unknown(what, &name.value, names);
        self.report(name.span, problem);
        Reported
    }
}

/// Whether a perfectly smooth material needs light to be carried wavelength by wavelength.
pub(super) fn is_spectral(material: &scene::Material) -> bool {
    match material {
        scene::Material::Phong(lobes) | scene::Material::NormalizedPhong(lobes) => {
            lobes.diffuse.value.is_spectral() || lobes.specular.value.is_spectral()
        }
        scene::Material::Mirror(mirror) => mirror.reflectance.value.is_spectral(),
        scene::Material::Metal(_) => true,
        scene::Material::Glass(glass) => glass.dispersion || glass.absorption.value.is_spectral(),
        scene::Material::Pane(_) => false,
    }
}
