//! Bands of light that has gone through a filter: over colored mirrors, through glass that absorbs or disperses it.

use super::Bands;
use crate::spectrum::Spectrum;
use crate::world::Lobes;
use crate::world::colorimetry::SpectralReflectance;

impl Bands<'_> {
    /// I · k · filter of both lobes of a material under a light in W·sr⁻²·nm⁻¹, band by band; made in `room`.
    pub(crate) fn transport_through<'r>(
        &self,
        light: usize,
        material: usize,
        filter: &Spectrum,
        room: &'r mut Vec<f64>,
    ) -> Lobes<&'r [f64]> {
        let filtered = self.spectra.lights[light].times(filter);
        let Lobes { diffuse, specular } = &self.spectra.materials[material];
        room.clear();
        // Of both lobes the same, if both are gray.
        let mut of_light: Option<Vec<f64>> = None;
        for lobe in [diffuse, specular] {
            match &lobe.reflectance {
                SpectralReflectance::Flat(value) => {
                    let means = of_light.get_or_insert_with(|| self.wavelengths.means(&filtered));
                    let scale = value * lobe.factor;
                    room.extend(means.iter().map(|mean| mean * scale));
                }
                SpectralReflectance::Spectrum(reflectance) => {
                    let means = self.wavelengths.means(&filtered.times(reflectance));
                    room.extend(means.into_iter().map(|mean| mean * lobe.factor));
                }
            }
        }
        let (diffuse, specular) = room.split_at(self.wavelengths.count());
        Lobes { diffuse, specular }
    }

    /// What a light sends along its normal, through a filter.
    pub(crate) fn light_through(&self, light: usize, filter: &Spectrum) -> Vec<f64> {
        self.wavelengths
            .means(&self.spectra.light(light).times(filter))
    }

    /// The background through a filter.
    pub(crate) fn background_through(&self, filter: &Spectrum) -> Vec<f64> {
        self.wavelengths
            .means(&self.spectra.background.times(filter))
    }
}
