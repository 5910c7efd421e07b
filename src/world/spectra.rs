//! Light that is carried wavelength by wavelength, as far as the renderer needs to know: the
//! products of lights with reflectances, integrated when they are first needed, and, for spectral images, band
//! by band. `docs/spectral-images.md` says how exact a picture the bands give.

mod through;

use std::sync::OnceLock;

use super::Lobes;
use super::colorimetry::{Colorimetry, SpectralReflectance};
use crate::memory::{self, OutOfMemory};
use crate::spectrum::{FIRST, LAST, Spectrum};
use crate::units::{Intensity, ReflectedIntensity, Rgb};

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

/// The most pairs of a light and a reflectance whose products have a table: 235 MB. Of more, each thread keeps
/// those that it has made last.
const LARGEST_TABLE: u64 = 1 << 22;

/// How many products a thread keeps where there is no table: 7 MB. One tile sees few reflectances, by all
/// lights: so these are the products of a tile of two reflectances and 60 000 lights.
const RECENT: usize = 1 << 17;

/// I · k of lights and the materials that objects have, where that takes an integral:
///
/// T = K_m ∫ I(λ) k(λ) m(λ) dλ, with the working space's color matching functions m.
///
/// A product is made when it is first asked for. It depends on its light and its material alone, so that it
/// has the same bits whichever thread makes it, and however often.
#[derive(Clone, Debug)]
pub(super) struct Products {
    columns: Columns,
    lights: usize,
    /// Light by light, column by column within; empty where it would be too large.
    table: Vec<OnceLock<Lobes<ReflectedIntensity>>>,
}

/// Products that one thread has made last, where a table of all would be too large.
#[derive(Clone, Debug, Default)]
pub(crate) struct RecentProducts {
    /// Each with the number of its pair plus 1; a place for each remainder of that number.
    slots: Vec<(u64, Lobes<ReflectedIntensity>)>,
}

impl Spectra {
    /// I · k of a light, whose R, G, B are `intensity`, on a material. A gray k takes these, which are as they
    /// were written.
    pub(super) fn product(
        &self,
        light: usize,
        Intensity(Rgb(intensity)): Intensity,
        material: usize,
    ) -> Lobes<ReflectedIntensity> {
        let mut seen = None;
        let mut integrated = |lobe: &ScaledReflectance| {
            let rgb = match &lobe.reflectance {
                SpectralReflectance::Flat(value) => {
                    intensity.map(|channel| channel * (value * lobe.factor))
                }
                SpectralReflectance::Spectrum(reflectance) => {
                    let seen =
                        seen.get_or_insert_with(|| self.colorimetry.seen(&self.lights[light]));
                    [0, 1, 2].map(|channel: usize| {
                        reflectance.integral(seen[channel].values()) * lobe.factor
                    })
                }
            };
            ReflectedIntensity(Rgb(rgb))
        };
        let Lobes { diffuse, specular } = &self.materials[material];
        Lobes {
            diffuse: integrated(diffuse),
            specular: integrated(specular),
        }
    }
}

impl Spectra {
    /// R, G, B of light that has gone through a filter: of a lamp's intensity, or of radiance.
    pub(super) fn filtered(&self, light: &Spectrum, filter: &Spectrum) -> [f64; 3] {
        let seen = self.colorimetry.seen(light);
        [0, 1, 2].map(|channel: usize| filter.integral(seen[channel].values()))
    }

    /// I · k of a light on a material, through a filter.
    pub(super) fn filtered_product(
        &self,
        light: usize,
        material: usize,
        filter: &Spectrum,
    ) -> Lobes<ReflectedIntensity> {
        let filtered = self.lights[light].times(filter);
        let seen = self.colorimetry.seen(&filtered);
        let integrated = |lobe: &ScaledReflectance| {
            let channel = |channel: usize| match &lobe.reflectance {
                SpectralReflectance::Flat(value) => seen[channel].total() * (value * lobe.factor),
                SpectralReflectance::Spectrum(reflectance) => {
                    reflectance.integral(seen[channel].values()) * lobe.factor
                }
            };
            ReflectedIntensity(Rgb([0, 1, 2].map(channel)))
        };
        let Lobes { diffuse, specular } = &self.materials[material];
        Lobes {
            diffuse: integrated(diffuse),
            specular: integrated(specular),
        }
    }
}

impl Products {
    /// Bytes of the table.
    pub(super) fn memory(&self) -> u64 {
        size_of_val(self.table.as_slice()) as u64
    }

    /// Room for the products of `spectra`.
    ///
    /// # Errors
    /// If there is not so much memory.
    pub(super) fn new(spectra: &Spectra) -> Result<Self, OutOfMemory> {
        Self::with_table(spectra, LARGEST_TABLE)
    }

    /// With a table of at most so many pairs.
    fn with_table(spectra: &Spectra, largest: u64) -> Result<Self, OutOfMemory> {
        let columns = Columns::of(spectra);
        let pairs = spectra.lights.len() as u64 * columns.used as u64;
        let mut table = Vec::new();
        if pairs <= largest {
            let pairs = spectra.lights.len() * columns.used;
            memory::reserve(&mut table, pairs)?;
            table.resize_with(pairs, OnceLock::new);
        }
        Ok(Self {
            columns,
            lights: spectra.lights.len(),
            table,
        })
    }

    #[cfg(test)]
    pub(super) fn drop_table(&mut self) {
        self.table = Vec::new();
    }

    /// Of one light on one material, if there is a table, and it is made.
    #[inline(always)]
    pub(super) fn known(
        &self,
        light: usize,
        material: usize,
    ) -> Option<&Lobes<ReflectedIntensity>> {
        let column = self.columns.of_materials[material]?;
        self.table.get(light * self.columns.used + column)?.get()
    }

    /// One that is not known, made by `integrate`; zero where no object has the material.
    pub(super) fn make(
        &self,
        light: usize,
        material: usize,
        recent: Option<&mut RecentProducts>,
        integrate: impl FnOnce() -> Lobes<ReflectedIntensity>,
    ) -> Lobes<ReflectedIntensity> {
        let Some(column) = self.columns.of_materials[material] else {
            return Lobes::default();
        };
        match (self.table.get(light * self.columns.used + column), recent) {
            (Some(place), _) => *place.get_or_init(integrate),
            (None, None) => integrate(),
            (None, Some(recent)) => {
                // All lights of one material side by side: a tile's products do not push each other out.
                let lights = self.lights as u64;
                recent.get_or_make(column as u64 * lights + light as u64, integrate)
            }
        }
    }
}

impl RecentProducts {
    fn get_or_make(
        &mut self,
        pair: u64,
        integrate: impl FnOnce() -> Lobes<ReflectedIntensity>,
    ) -> Lobes<ReflectedIntensity> {
        if self.slots.is_empty() && memory::reserve(&mut self.slots, RECENT).is_ok() {
            self.slots.resize(RECENT, Default::default());
        }
        // Where there is no memory for them, none are kept.
        let place = (pair % RECENT as u64) as usize;
        match self.slots.get_mut(place) {
            Some((known, product)) if *known == pair + 1 => *product,
            Some(slot) => {
                *slot = (pair + 1, integrate());
                slot.1
            }
            None => integrate(),
        }
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

/// The most numbers of 8 bytes that a table of I · k band by band may take, 256 MB. Of more, each pixel makes those of the lights and
/// materials that it shows.
const LARGEST_BANDS: u64 = 1 << 25;

/// What the pixels of a spectral image are made of: I · k of lights and the materials that objects have, and the
/// background, band by band. As products, they are made when they are first asked for.
#[derive(Clone, Debug)]
pub struct Bands<'w> {
    spectra: &'w Spectra,
    wavelengths: Wavelengths,
    columns: Columns,
    /// Light by light, used material by used material within: diffuse and specular, band by band. Empty where
    /// it would be too large.
    table: Vec<OnceLock<Box<[f64]>>>,
    background: Vec<f64>,
}

impl<'w> Bands<'w> {
    /// The products of `spectra` at `wavelengths`.
    pub fn new(spectra: &'w Spectra, wavelengths: Wavelengths) -> Self {
        let columns = Columns::of(spectra);
        let pairs = spectra.lights.len() * columns.used;
        let has_table = Self::table_size(spectra, wavelengths) > 0;
        let mut table = Vec::new();
        table.resize_with(if has_table { pairs } else { 0 }, OnceLock::new);
        Self {
            spectra,
            wavelengths,
            columns,
            table,
            background: wavelengths.means(&spectra.background),
        }
    }

    /// How many numbers of 8 bytes the table takes, once all of it is made; 0 where there is none.
    fn table_size(spectra: &Spectra, wavelengths: Wavelengths) -> u64 {
        let used = spectra.used.iter().filter(|used| **used).count() as u64;
        let place = size_of::<OnceLock<Box<[f64]>>>().div_ceil(size_of::<f64>());
        let size = 2 * wavelengths.count() + place;
        let table = (used * spectra.lights.len() as u64).saturating_mul(size as u64);
        if table > LARGEST_BANDS { 0 } else { table }
    }

    /// How many numbers, of 8 bytes, the products of `spectra` at `wavelengths` may take.
    pub fn size(spectra: &Spectra, wavelengths: Wavelengths) -> u64 {
        Self::table_size(spectra, wavelengths) + wavelengths.count() as u64
    }

    /// Where the bands are.
    pub fn wavelengths(&self) -> Wavelengths {
        self.wavelengths
    }

    /// How many lights there are.
    pub fn lights(&self) -> usize {
        self.spectra.lights.len()
    }

    /// I · k of both lobes of a material under a light in W·sr⁻²·nm⁻¹, band by band; in `room` where no table
    /// has it.
    ///
    /// # Panics
    /// If no object has the material.
    pub fn transport<'b>(
        &'b self,
        light: usize,
        material: usize,
        room: &'b mut Vec<f64>,
    ) -> Lobes<&'b [f64]> {
        let column = self.columns.of_materials[material];
        let column = column.expect("only materials of objects are seen");
        let bands: &[f64] = match self.table.get(light * self.columns.used + column) {
            Some(place) => place.get_or_init(|| self.product(light, material).collect()),
            None => {
                room.clear();
                room.extend(self.product(light, material));
                room
            }
        };
        let (diffuse, specular) = bands.split_at(self.wavelengths.count());
        Lobes { diffuse, specular }
    }

    /// Diffuse and specular, band by band.
    fn product(&self, light: usize, material: usize) -> impl Iterator<Item = f64> {
        let light = &self.spectra.lights[light];
        let Lobes { diffuse, specular } = &self.spectra.materials[material];
        [diffuse, specular].into_iter().flat_map(move |lobe| {
            let (means, scale) = match &lobe.reflectance {
                SpectralReflectance::Flat(value) => {
                    (self.wavelengths.means(light), value * lobe.factor)
                }
                SpectralReflectance::Spectrum(reflectance) => {
                    let product = light.times(reflectance);
                    (self.wavelengths.means(&product), lobe.factor)
                }
            };
            means.into_iter().map(move |mean| mean * scale)
        })
    }

    /// Radiance where nothing is hit, in W·m⁻²·sr⁻¹·nm⁻¹, band by band.
    pub fn background(&self) -> &[f64] {
        &self.background
    }

    /// What a light sends along its normal, band by band.
    pub(crate) fn light(&self, light: usize) -> Vec<f64> {
        self.wavelengths.means(self.spectra.light(light))
    }
}

/// A place in a table for each material that objects have.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    /// Each material's column, if any object has it.
    pub(super) of_materials: Vec<Option<usize>>,
    /// How many columns there are.
    pub(super) used: usize,
}

impl Columns {
    pub(super) fn of(spectra: &Spectra) -> Self {
        let mut used = 0;
        let columns = spectra.used.iter().map(|is_used| {
            is_used.then(|| {
                used += 1;
                used - 1
            })
        });
        Self {
            of_materials: columns.collect(),
            used,
        }
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
        assert_eq!(bands.table.len(), 2 * 2);
        let room = 3 * bands.table.len() + bands.background.len();
        let size = Bands::size(&spectra, Wavelengths::default());
        assert_eq!(size, (2 * 2 * 2 * 41 + room) as u64);
        let mut without_table = bands.clone();
        without_table.table.clear();
        for (light, material, expected) in [(0, 1, 0.2), (0, 2, 0.3), (1, 1, 0.4), (1, 2, 0.6)] {
            let (mut room, mut other) = (Vec::new(), Vec::new());
            let of_pair = bands.transport(light, material, &mut room);
            assert_eq!(
                of_pair,
                without_table.transport(light, material, &mut other)
            );
            for band in of_pair.diffuse {
                assert!(
                    (band - expected).abs() < 1e-14,
                    "{light} {material}: {band}"
                );
            }
            assert!(room.is_empty() && other.len() == 82);
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
