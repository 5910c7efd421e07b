//! Light that is carried wavelength by wavelength, as far as the renderer needs to know: the
//! products of every light with every reflectance, integrated once, and, for spectral images, band
//! by band. `docs/spectral-images.md` says how exact a picture the bands give.

use rayon::prelude::*;

use super::colorimetry::{Colorimetry, SpectralReflectance};
use super::{Lobes, Named, PointLight};
use crate::memory::{self, OutOfMemory};
use crate::spectrum::{FIRST, LAST, Spectrum};
use crate::units::{ReflectedIntensity, Rgb};

/// The spectra of a world's lights, materials and background.
#[derive(Clone, Debug)]
pub struct Spectra {
    pub(super) colorimetry: Colorimetry,
    /// I(λ) of each light in W·sr⁻¹·nm⁻¹.
    pub(super) lights: Vec<Spectrum>,
    /// k_d(λ) and k_s(λ) of each material.
    pub(super) materials: Vec<Lobes<ScaledReflectance>>,
    /// Whether any object has the material.
    pub(super) used: Vec<bool>,
    /// Of what is behind everything, in W·m⁻²·sr⁻¹·nm⁻¹.
    pub(super) background: Spectrum,
}

/// k(λ) of one lobe in sr⁻¹: a reflectance and the factor of its model, such as 1/π.
#[derive(Clone, Debug)]
pub struct ScaledReflectance {
    pub(super) reflectance: SpectralReflectance,
    pub(super) factor: f64,
}

impl Spectra {
    /// How the observer sees them.
    pub fn colorimetry(&self) -> &Colorimetry {
        &self.colorimetry
    }

    /// I(λ) of a light in W·sr⁻¹·nm⁻¹.
    pub fn light(&self, light: usize) -> &Spectrum {
        &self.lights[light]
    }
}

/// I · k of every light on every material that objects have, where that takes an integral:
///
/// T = K_m ∫ I(λ) k(λ) m(λ) dλ, with the working space's color matching functions m.
#[derive(Clone, Debug)]
pub(super) struct Products {
    /// Each material's column, if any object has it.
    columns: Vec<Option<usize>>,
    /// How many columns there are.
    used: usize,
    /// Light by light, column by column within.
    table: Vec<Lobes<ReflectedIntensity>>,
}

impl Products {
    /// Bytes of the table.
    pub(super) fn memory(&self) -> u64 {
        size_of_val(self.table.as_slice()) as u64
    }

    /// The products of `spectra`. A gray k takes the light's own R, G, B, which are as they were
    /// written.
    ///
    /// # Errors
    /// If there is not so much memory.
    pub(super) fn new(
        spectra: &Spectra,
        lights: &[Named<PointLight>],
    ) -> Result<Self, OutOfMemory> {
        let mut used = 0;
        let columns = spectra.used.iter().map(|is_used| {
            is_used.then(|| {
                used += 1;
                used - 1
            })
        });
        let columns = columns.collect();
        let mut table = Vec::new();
        memory::reserve(&mut table, lights.len().saturating_mul(used))?;
        table.resize(lights.len() * used, Lobes::default());
        let materials = spectra.materials.iter().zip(&spectra.used);
        let materials: Vec<_> = materials
            .filter_map(|(m, used)| used.then_some(m))
            .collect();
        // No chunk may be of length 0; without materials that are used there is none.
        let rows = table.par_chunks_mut(used.max(1));
        rows.zip(&spectra.lights)
            .zip(lights)
            .for_each(|((row, spectrum), light)| {
                let seen = spectra.colorimetry.seen(spectrum);
                let rgb = light.value.intensity.0.0;
                let integrated = |lobe: &ScaledReflectance| {
                    let rgb = match &lobe.reflectance {
                        SpectralReflectance::Flat(value) => {
                            rgb.map(|channel| channel * (value * lobe.factor))
                        }
                        SpectralReflectance::Spectrum(reflectance) => {
                            [0, 1, 2].map(|channel: usize| {
                                reflectance.integral(seen[channel].values()) * lobe.factor
                            })
                        }
                    };
                    ReflectedIntensity(Rgb(rgb))
                };
                for (product, lobes) in row.iter_mut().zip(&materials) {
                    *product = Lobes {
                        diffuse: integrated(&lobes.diffuse),
                        specular: integrated(&lobes.specular),
                    };
                }
            });
        Ok(Self {
            columns,
            used,
            table,
        })
    }

    /// Of one light on one material; zero where no object has it.
    #[inline]
    pub(super) fn of(&self, light: usize, material: usize) -> Lobes<ReflectedIntensity> {
        let column = self.columns[material];
        column.map_or_else(Lobes::default, |column| {
            self.table[light * self.used + column]
        })
    }
}

/// The wavelengths at which a spectral image has its layers, equally spaced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wavelengths {
    first: u32,
    step: u32,
    count: u32,
}

impl Default for Wavelengths {
    /// 380 to 780 nm at 10 nm.
    fn default() -> Self {
        Self {
            first: 380,
            step: 10,
            count: 41,
        }
    }
}

impl Wavelengths {
    /// From `first` to `last` nm, both included, at `step` nm; `None` unless these are on the grid
    /// and `last` is some steps from `first`.
    pub const fn new(first: u32, last: u32, step: u32) -> Option<Self> {
        if first < FIRST || last > LAST || last <= first || step == 0 {
            return None;
        }
        if !(last - first).is_multiple_of(step) {
            return None;
        }
        Some(Self {
            first,
            step,
            count: (last - first) / step + 1,
        })
    }

    /// The shortest in nm.
    pub const fn first(self) -> u32 {
        self.first
    }

    /// The longest in nm.
    pub const fn last(self) -> u32 {
        self.first + (self.count - 1) * self.step
    }

    /// How many there are: at least 2.
    pub const fn count(self) -> usize {
        self.count as usize
    }

    /// Their distance in nm.
    pub const fn step(self) -> u32 {
        self.step
    }

    /// Each in nm, ascending.
    pub fn iter(self) -> impl ExactSizeIterator<Item = u32> {
        (0..self.count).map(move |band| self.first + band * self.step)
    }

    /// The mean of a spectrum around each, per nm:
    ///
    /// S_b = (1/Δ) ∫ S(λ) max(0, 1 − |λ − λ_b|/Δ) dλ, with Δ the step.
    ///
    /// The weights of neighbors sum to 1 everywhere, so that no light is lost between two bands or
    /// counted in both; Σ S_b f(λ_b) Δ is the integral of S with f interpolated linearly between
    /// the bands, however spiky S is. At the ends of the grid, where a half of the weights is cut
    /// off, it is the mean over the other half.
    pub fn means(self, spectrum: &Spectrum) -> Vec<f64> {
        let values = spectrum.values();
        self.iter()
            .map(|center| {
                let from = center.saturating_sub(self.step).max(FIRST);
                let to = (center + self.step).min(LAST);
                let (mut sum, mut weights) = (0.0, 0.0);
                for nm in from..=to {
                    let weight = f64::from(self.step - center.abs_diff(nm)) / f64::from(self.step);
                    sum += weight * values[(nm - FIRST) as usize];
                    weights += weight;
                }
                sum / weights
            })
            .collect()
    }
}

/// What the pixels of a spectral image are made of: I · k of every light and every material that
/// objects have, and the background, band by band.
#[derive(Clone, Debug)]
pub struct Bands {
    wavelengths: Wavelengths,
    lights: usize,
    /// Each material's place among those that are used.
    places: Vec<Option<usize>>,
    used: usize,
    /// Light by light, used material by used material within, diffuse and specular, band by band.
    transport: Vec<f64>,
    background: Vec<f64>,
}

impl Bands {
    /// The products of `spectra` at `wavelengths`.
    pub fn new(spectra: &Spectra, wavelengths: Wavelengths) -> Self {
        let mut used = 0;
        let places = spectra.used.iter().map(|is_used| {
            is_used.then(|| {
                used += 1;
                used - 1
            })
        });
        let places = places.collect();
        let rows = spectra.lights.par_iter();
        let transport = rows.flat_map_iter(|light| {
            let of_light = wavelengths.means(light);
            let reflected = move |lobe: &ScaledReflectance| {
                let (mut means, scale) = match &lobe.reflectance {
                    SpectralReflectance::Flat(value) => (of_light.clone(), value * lobe.factor),
                    SpectralReflectance::Spectrum(reflectance) => {
                        (wavelengths.means(&light.times(reflectance)), lobe.factor)
                    }
                };
                for mean in &mut means {
                    *mean *= scale;
                }
                means
            };
            let used = spectra.materials.iter().zip(&spectra.used);
            let lobes = used.filter_map(|(lobes, used)| used.then_some(lobes));
            let lobes = lobes.flat_map(|lobes| [&lobes.diffuse, &lobes.specular]);
            lobes.flat_map(reflected)
        });
        Self {
            wavelengths,
            lights: spectra.lights.len(),
            places,
            used,
            transport: transport.collect(),
            background: wavelengths.means(&spectra.background),
        }
    }

    /// How many numbers, of 8 bytes, the products of `spectra` at `wavelengths` are.
    pub fn size(spectra: &Spectra, wavelengths: Wavelengths) -> u64 {
        let used = spectra.used.iter().filter(|used| **used).count() as u64;
        let lobes = 2 * used * spectra.lights.len() as u64;
        (lobes + 1) * wavelengths.count() as u64
    }

    /// Where the bands are.
    pub fn wavelengths(&self) -> Wavelengths {
        self.wavelengths
    }

    /// How many lights there are.
    pub fn lights(&self) -> usize {
        self.lights
    }

    /// I · k of both lobes of a material under a light in W·sr⁻²·nm⁻¹, band by band.
    ///
    /// # Panics
    /// If no object has the material.
    pub fn transport(&self, light: usize, material: usize) -> Lobes<&[f64]> {
        let bands = self.wavelengths.count();
        let place = self.places[material].expect("only materials of objects are seen");
        let start = 2 * bands * (light * self.used + place);
        Lobes {
            diffuse: &self.transport[start..start + bands],
            specular: &self.transport[start + bands..start + 2 * bands],
        }
    }

    /// Radiance where nothing is hit, in W·m⁻²·sr⁻¹·nm⁻¹, band by band.
    pub fn background(&self) -> &[f64] {
        &self.background
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ColorSpace;
    use crate::spectrum::Observer;

    #[test]
    fn wavelengths_are_checked() {
        let wavelengths = Wavelengths::new(400, 700, 10).unwrap();
        assert_eq!(wavelengths.count(), 31);
        assert_eq!(wavelengths.iter().last(), Some(700));
        assert_eq!(Wavelengths::new(380, 780, 10), Some(Wavelengths::default()));
        for (first, last, step) in [
            (400, 700, 0),
            (700, 400, 10),
            (400, 400, 10),
            (400, 705, 10),
            (350, 700, 10),
            (400, 840, 10),
        ] {
            assert_eq!(Wavelengths::new(first, last, step), None);
        }
    }

    /// Bands are as many as the used materials need, and each finds its own.
    #[test]
    fn only_materials_that_are_used_have_bands() {
        let colorimetry = Colorimetry::new(Observer::Cie1931, ColorSpace::Rec709);
        let flat = |value| ScaledReflectance {
            reflectance: SpectralReflectance::Flat(value),
            factor: 1.0,
        };
        let material = |value| Lobes {
            diffuse: flat(value),
            specular: flat(0.0),
        };
        let spectra = Spectra {
            colorimetry,
            lights: vec![Spectrum::constant(1.0), Spectrum::constant(2.0)],
            materials: [0.1, 0.2, 0.3].map(material).to_vec(),
            used: vec![false, true, true],
            background: Spectrum::constant(0.0),
        };
        let bands = Bands::new(&spectra, Wavelengths::default());
        assert_eq!(bands.transport.len(), 2 * 2 * 2 * 41);
        let numbers = bands.transport.len() + bands.background.len();
        let size = Bands::size(&spectra, Wavelengths::default());
        assert_eq!(size, numbers as u64);
        for (light, material, expected) in [(0, 1, 0.2), (0, 2, 0.3), (1, 1, 0.4), (1, 2, 0.6)] {
            for band in bands.transport(light, material).diffuse {
                assert!(
                    (band - expected).abs() < 1e-14,
                    "{light} {material}: {band}"
                );
            }
        }
    }

    /// Nothing is lost: the bands' means times the step are the whole, lines included.
    #[test]
    fn bands_keep_the_light() {
        let line = |at: u32| Spectrum::from_fn(move |nm| f64::from(u8::from(nm == f64::from(at))));
        let wavelengths = Wavelengths::new(400, 700, 7 + 3).unwrap();
        for at in [400, 403, 555, 589, 700] {
            let total: f64 = wavelengths.means(&line(at)).iter().sum();
            assert!((total * 10.0 - 1.0).abs() < 1e-14, "{at}: {total}");
        }
        for mean in wavelengths.means(&Spectrum::constant(3.0)) {
            assert!((mean - 3.0).abs() < 1e-14);
        }
        // Of a straight line the means are its values.
        let slope = wavelengths.means(&Spectrum::from_fn(|nm| nm));
        for (mean, nm) in slope.into_iter().zip(wavelengths.iter()) {
            assert!((mean - f64::from(nm)).abs() < 1e-11);
        }
        // Also at the ends of the grid there is a mean.
        let ends = Wavelengths::new(360, 830, 10).unwrap();
        assert!((ends.means(&Spectrum::constant(3.0))[0] - 3.0).abs() < 1e-14);
    }
}
