//! Light and reflectances between keys: sums of others.

use std::sync::Arc;

use super::color::{Bound, Emission, Reflection, Spread};
use super::{Builder, Reported, as_written};
use crate::scene::{Mixture, Spanned, Value};
use crate::spectrum::Spectrum;
use crate::world::colorimetry::{SpectralReflectance, on_grid};

/// What sums of numbers that cancel leave of nothing, relative to the largest.
const ROUNDING: f64 = 1e-12;

impl Builder<'_> {
    /// Light that is a sum of others.
    pub(super) fn mixed_light(
        &mut self,
        key: &'static str,
        written: &Spanned<Value>,
        mixture: &Mixture,
        spread: Spread,
    ) -> Result<Emission, Reported> {
        let before = self.diagnostics.len();
        let parts = mixture.0.iter().map(|(weight, part)| {
            let part = Spanned::new(part.clone(), written.span);
            (*weight, self.emission(key, &part, spread))
        });
        let parts: Vec<(f64, Emission)> = parts.collect();
        if self.diagnostics.len() > before {
            return Err(Reported);
        }
        let rgb = sums(parts.iter().map(|(weight, part)| (*weight, part.rgb)));
        let spectra: Option<Vec<(f64, &Spectrum)>> = parts
            .iter()
            .map(|(weight, part)| Some((*weight, part.spectrum.as_ref()?)))
            .collect();
        let spectrum = spectra.map(|spectra| sum(&spectra));
        let has_negative_parts = parts.iter().any(|(_, part)| least(&part.rgb) < 0.0);
        let (darkest, brightest) = match &spectrum {
            Some(spectrum) => (least(spectrum.values()), spectrum.peak().0),
            // A color that the working space does not hold has negative channels by right.
            None if has_negative_parts => (0.0, 0.0),
            None => (least(&rgb), most(&rgb)),
        };
        self.check_not_negative(key, written, darkest, brightest)?;
        Ok(Emission { rgb, spectrum })
    }

    /// A reflectance that is a sum of others.
    pub(super) fn mixed_reflection(
        &mut self,
        key: &'static str,
        written: &Spanned<Value>,
        mixture: &Mixture,
        bound: Bound,
    ) -> Result<Reflection, Reported> {
        let before = self.diagnostics.len();
        let parts = mixture.0.iter().map(|(weight, part)| {
            let part = Spanned::new(part.clone(), written.span);
            (*weight, self.reflection(key, &part, bound))
        });
        let parts: Vec<(f64, Reflection)> = parts.collect();
        if self.diagnostics.len() > before {
            return Err(Reported);
        }
        let rgb = sums(parts.iter().map(|(weight, part)| (*weight, part.rgb)));
        let reflectances: Option<Vec<(f64, Spectrum)>> = parts
            .iter()
            .map(|(weight, part)| {
                let spectrum = match part.reflectance.as_ref()? {
                    SpectralReflectance::Flat(value) => on_grid(|_| *value),
                    SpectralReflectance::Spectrum(spectrum) => Spectrum::clone(spectrum),
                };
                Some((*weight, spectrum))
            })
            .collect();
        let spectrum = reflectances.map(|parts| {
            let parts: Vec<_> = parts.iter().map(|(weight, part)| (*weight, part)).collect();
            sum(&parts)
        });
        let (darkest, brightest) = match &spectrum {
            Some(spectrum) => (least(spectrum.values()), spectrum.peak().0),
            None => (least(&rgb), most(&rgb)),
        };
        self.check_not_negative(key, written, darkest, brightest)?;
        if bound == Bound::Albedo && brightest > 1.0 + ROUNDING {
            let expected = "at most 1 in every channel and at every wavelength";
            self.out_of_range(key, written.span, as_written(brightest), expected);
            return Err(Reported);
        }
        Ok(Reflection {
            rgb,
            reflectance: spectrum.map(|spectrum| SpectralReflectance::Spectrum(Arc::new(spectrum))),
        })
    }

    /// Between keys there may be less than nothing.
    fn check_not_negative(
        &mut self,
        key: &'static str,
        written: &Spanned<Value>,
        least: f64,
        most: f64,
    ) -> Result<(), Reported> {
        if least >= -ROUNDING * most {
            return Ok(());
        }
        let expected = "0 or more, as `linear` stays between keys that are";
        self.out_of_range(key, written.span, as_written(least), expected);
        Err(Reported)
    }
}

fn sums(parts: impl Iterator<Item = (f64, [f64; 3])>) -> [f64; 3] {
    parts.fold([0.0; 3], |[r, g, b], (weight, [x, y, z])| {
        [r + weight * x, g + weight * y, b + weight * z]
    })
}

fn sum(parts: &[(f64, &Spectrum)]) -> Spectrum {
    on_grid(|i| {
        let parts = parts.iter();
        parts.map(|(weight, part)| weight * part.values()[i]).sum()
    })
}

fn least(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::INFINITY, f64::min)
}

fn most(values: &[f64]) -> f64 {
    values.iter().copied().fold(f64::NEG_INFINITY, f64::max)
}
