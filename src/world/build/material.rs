//! Materials: their reflectances, and how much of the light these may be.

use super::color::{Bound, Reflection};
use super::{Builder, as_written, listed};
use crate::scene::{self, Problem};
use crate::world::colorimetry::SpectralReflectance;
use crate::world::spectra::ScaledReflectance;
use crate::world::{Lobes, Material};

/// The largest shininess. Its lobe is 3e-5 wide (1/√n); the rounding of a cosine, 1e-16, changes
/// cosⁿ by 1e-7 there, and no longer by little beyond.
const SHARPEST: f64 = 1e9;

/// Largest sum of the albedos of a `normalized_phong` material: 1, and an allowance for decimal
/// fractions such as 0.7 + 0.3 that binary numbers miss by a rounding.
const LARGEST_ALBEDO: f64 = 1.0 + 1e-12;

impl Builder<'_> {
    pub(super) fn material(
        &mut self,
        entry: &scene::Entry<scene::Material>,
    ) -> (Material, Option<Lobes<ScaledReflectance>>) {
        let (lobes, bound) = match &entry.value {
            // k_d is the share that is reflected towards any one viewer; k_s has no such limit,
            // since a narrow lobe with a large k_s still reflects little in all.
            scene::Material::Phong(lobes) => (lobes, Bound::None),
            scene::Material::NormalizedPhong(lobes) => (lobes, Bound::Albedo),
            scene::Material::Mirror(_)
            | scene::Material::Metal(_)
            | scene::Material::Glass(_)
            | scene::Material::Pane(_) => return (Material::BLACK, self.black()),
        };
        let name = || format!("material `{}`", entry.name);
        self.note_spectra([&lobes.diffuse.value, &lobes.specular.value], name);
        let diffuse = self.reflection("diffuse", &lobes.diffuse, Bound::Albedo);
        let specular = self.reflection("specular", &lobes.specular, bound);
        let shininess = match lobes.shininess {
            Some(written) => {
                let legal = |n: f64| n > 0.0 && n <= SHARPEST;
                self.number(
                    "shininess",
                    written,
                    legal,
                    "an exponent above 0, up to 1e9",
                )
                .unwrap_or(1.0)
            }
            None => {
                if !specular.is_black() {
                    self.report(
                        lobes.specular.span,
                        Problem::Missing {
                            what: "key",
                            name: "shininess".to_owned(),
                            expected: "the exponent n of the specular lobe, such as `shininess = 50`",
                        },
                    );
                }
                1.0
            }
        };
        let material = match entry.value {
            scene::Material::Phong(_) => Material::phong(diffuse.rgb, specular.rgb, shininess),
            _ => {
                self.check_albedo(lobes, &diffuse, &specular);
                Material::normalized_phong(diffuse.rgb, specular.rgb, shininess)
            }
        };
        let is_spectral = self.is_spectral;
        let reflectances = diffuse
            .reflectance
            .filter(|_| is_spectral)
            .zip(specular.reflectance)
            .map(|(diffuse, specular)| {
                let factors = material.factors();
                Lobes {
                    diffuse: ScaledReflectance {
                        reflectance: diffuse,
                        factor: factors.diffuse,
                    },
                    specular: ScaledReflectance {
                        reflectance: specular,
                        factor: factors.specular,
                    },
                }
            });
        (material, reflectances)
    }

    /// The lobes of what has none, where light is carried spectrally.
    fn black(&self) -> Option<Lobes<ScaledReflectance>> {
        let black = || ScaledReflectance {
            reflectance: SpectralReflectance::Flat(0.0),
            factor: 1.0,
        };
        self.is_spectral.then(|| Lobes {
            diffuse: black(),
            specular: black(),
        })
    }

    /// ρ_d + ρ_s is at most 1, in every channel or, of spectra, at every wavelength: the channels of
    /// saturated ones may be above 1 where no wavelength is.
    ///
    /// A curve with an RGB value where light is carried as RGB is legal in either way, as that value
    /// has no wavelengths of its own.
    fn check_albedo(&mut self, lobes: &scene::Lobes, diffuse: &Reflection, specular: &Reflection) {
        let span = lobes.specular.span.max(lobes.diffuse.span);
        let both = [diffuse, specular];
        let albedo: [f64; 3] = std::array::from_fn(|i| diffuse.rgb[i] + specular.rgb[i]);
        let in_channels = albedo.iter().all(|&albedo| albedo <= LARGEST_ALBEDO);
        let has_spectrum = both.iter().any(|lobe| lobe.reflectance.is_some());
        let has_triple = both
            .iter()
            .any(|lobe| lobe.reflectance.is_none() && !lobe.is_gray());
        if has_spectrum
            && !(has_triple && in_channels)
            && let Some(diffuse) = self.by_wavelength(diffuse)
            && let Some(specular) = self.by_wavelength(specular)
        {
            let (albedo, nm) = diffuse.peak_with(&specular);
            if albedo > LARGEST_ALBEDO {
                let place = nm.map_or_else(String::new, |nm| format!(" at {nm} nm"));
                let expected = "an albedo of at most 1 at every wavelength";
                let value = format!("{}{place}", as_written(albedo));
                self.out_of_range("diffuse + specular", span, value, expected);
            }
        } else if !in_channels {
            let expected = "an albedo of at most 1 in every channel";
            self.out_of_range("diffuse + specular", span, listed(&albedo), expected);
        }
    }
}
