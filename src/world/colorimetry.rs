//! From spectra to the working space, and from colors to spectra.
//!
//! XYZ = K_m ∫ S(λ) (x̄, ȳ, z̄)(λ) dλ is what the observer sees, in cd/m² where S is a spectral
//! radiance. White is D65 in every scene: the XYZ are adapted (Bradford) from the observer's own
//! XYZ of illuminant D65 to the white of the working space, then its matrix makes them RGB. For the
//! 2° observer and a space whose white is D65, nothing is adapted, as [`Illuminant::D65`] has the
//! chromaticity by which such spaces are defined.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::color::adaptation::{bradford, conversion};
use crate::scene::ColorSpace;
use crate::spectrum::upsample;
use crate::spectrum::{Illuminant, Observer, SAMPLES, Spectrum};

/// Linear RGB of one space in another, whites adapted.
pub fn converted(rgb: [f64; 3], from: ColorSpace, to: ColorSpace) -> [f64; 3] {
    if from == to {
        return rgb;
    }
    let matrix = conversion(&from.primaries(), &to.primaries());
    (matrix * DVec3::from_array(rgb)).to_array()
}

/// How much of the light of a color is scaled down, one after the other, until a smooth spectrum
/// has its chromaticity: the darker, the more saturated it may be.
const DIMMER: [f64; 5] = [0.5, 0.125, 1.0 / 32.0, 1.0 / 128.0, 1.0 / 512.0];

/// How one observer sees spectra in one working space.
#[derive(Clone, Debug)]
pub struct Colorimetry {
    observer: Observer,
    /// What R, G and B are integrals with: K_m times the color matching functions of the space.
    matching: [Spectrum; 3],
    /// Illuminant D65 of 1 cd.
    white: Spectrum,
    /// `matching` under `white`, so that R, G and B of a reflectance of 1 are 1.
    under_white: [Spectrum; 3],
}

impl Colorimetry {
    /// For this observer and working space.
    pub fn new(observer: Observer, space: ColorSpace) -> Self {
        let d65 = Illuminant::D65.spectrum();
        let white = d65.scaled(1.0 / observer.luminous(&d65));
        let primaries = space.primaries();
        let seen = DVec3::from_array(observer.xyz(&white));
        let matrix: DMat3 = primaries.from_xyz() * bradford(seen, primaries.white_xyz());
        let xyz = observer.color_matching();
        let matching = [0, 1, 2].map(|channel| {
            let row = matrix.row(channel) * observer.luminous_efficacy();
            let value = |i: usize| row.x * xyz[0][i] + row.y * xyz[1][i] + row.z * xyz[2][i];
            on_grid(value)
        });
        let under_white = [0, 1, 2].map(|channel: usize| {
            let product = matching[channel].times(&white);
            product.scaled(1.0 / product.total())
        });
        Self {
            observer,
            matching,
            white,
            under_white,
        }
    }

    /// Whose color matching functions they are.
    pub fn observer(&self) -> Observer {
        self.observer
    }

    /// R, G, B of a light: in cd of a spectral intensity in W·sr⁻¹·nm⁻¹.
    pub fn light(&self, spectrum: &Spectrum) -> [f64; 3] {
        [0, 1, 2].map(|channel: usize| spectrum.integral(self.matching[channel].values()))
    }

    /// R, G, B of a reflectance under white light.
    pub fn reflectance(&self, spectrum: &Spectrum) -> [f64; 3] {
        [0, 1, 2].map(|channel: usize| spectrum.integral(self.under_white[channel].values()))
    }

    /// ∫ S(λ) m(λ) for the three channels' m: what [`Colorimetry::light`] integrates of a light,
    /// before a reflectance is multiplied in.
    pub(super) fn seen(&self, light: &Spectrum) -> [Spectrum; 3] {
        [0, 1, 2].map(|channel: usize| self.matching[channel].times(light))
    }

    /// Luminous intensity in cd of a spectral intensity in W·sr⁻¹·nm⁻¹.
    pub fn luminous(&self, spectrum: &Spectrum) -> f64 {
        self.observer.luminous(spectrum)
    }

    /// A light of 1 cd that is white: illuminant D65.
    pub fn white(&self) -> &Spectrum {
        &self.white
    }

    /// The reflectance of a color under white light, from 0 to 1 at every wavelength; `None` if no
    /// smooth one has it.
    pub fn reflectance_of(&self, rgb: [f64; 3]) -> Option<SpectralReflectance> {
        if rgb[0] == rgb[1] && rgb[1] == rgb[2] {
            return (0.0..=1.0)
                .contains(&rgb[0])
                .then_some(SpectralReflectance::Flat(rgb[0]));
        }
        let coefficients = upsample::reflectance(&self.under_white, rgb)?;
        Some(SpectralReflectance::Spectrum(Arc::new(
            coefficients.spectrum(),
        )))
    }

    /// A curve of any size whose color under white light is `rgb`: a reflectance where there is
    /// one, else that of a darker color, scaled up. `None` for colors that no light has.
    pub fn unbounded(&self, rgb: [f64; 3]) -> Option<SpectralReflectance> {
        if rgb[0] == rgb[1] && rgb[1] == rgb[2] {
            return Some(SpectralReflectance::Flat(rgb[0]));
        }
        let brightest = rgb.into_iter().fold(0.0, f64::max);
        DIMMER.into_iter().find_map(|dimmer| {
            let scale = dimmer / brightest;
            let coefficients =
                upsample::reflectance(&self.under_white, rgb.map(|channel| channel * scale))?;
            let spectrum = coefficients.spectrum().scaled(1.0 / scale);
            Some(SpectralReflectance::Spectrum(Arc::new(spectrum)))
        })
    }
}

/// A reflectance, or the share of white light that a colored one is.
#[derive(Clone, Debug, PartialEq)]
pub enum SpectralReflectance {
    /// The same at every wavelength.
    Flat(f64),
    /// One number for each wavelength.
    Spectrum(Arc<Spectrum>),
}

impl SpectralReflectance {
    /// The largest value.
    pub fn peak(&self) -> f64 {
        match self {
            Self::Flat(value) => *value,
            Self::Spectrum(spectrum) => spectrum.peak().0,
        }
    }

    /// Whether nothing is reflected.
    pub fn is_black(&self) -> bool {
        self.peak() == 0.0
    }

    /// This share of a light.
    pub fn of(&self, light: &Spectrum) -> Spectrum {
        match self {
            Self::Flat(value) => light.scaled(*value),
            Self::Spectrum(spectrum) => light.times(spectrum),
        }
    }

    /// The largest sum of two, and the wavelength in nm where it is first; `None` where it is
    /// everywhere.
    pub(super) fn peak_with(&self, other: &Self) -> (f64, Option<f64>) {
        let somewhere = |spectrum: &Spectrum, more: f64| {
            let (peak, nm) = spectrum.peak();
            (peak + more, Some(nm))
        };
        match (self, other) {
            (Self::Flat(a), Self::Flat(b)) => (a + b, None),
            (Self::Spectrum(spectrum), Self::Flat(more))
            | (Self::Flat(more), Self::Spectrum(spectrum)) => somewhere(spectrum, *more),
            (Self::Spectrum(a), Self::Spectrum(b)) => {
                somewhere(&on_grid(|i| a.values()[i] + b.values()[i]), 0.0)
            }
        }
    }
}

/// The spectrum whose value at the i-th wavelength of the grid is f(i).
pub(super) fn on_grid(f: impl Fn(usize) -> f64) -> Spectrum {
    let mut places = 0..SAMPLES;
    Spectrum::from_fn(|_| f(places.next().expect("the grid has SAMPLES wavelengths")))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// f64 sums of 471 terms.
    const ROUNDING: f64 = 1e-13;

    fn everywhere(mut test: impl FnMut(&Colorimetry, ColorSpace)) {
        for observer in Observer::ALL {
            for space in ColorSpace::ALL {
                test(&Colorimetry::new(observer, space), space);
            }
        }
    }

    #[test]
    fn d65_is_white_in_every_space() {
        everywhere(|colorimetry, _| {
            for channel in colorimetry.light(colorimetry.white()) {
                assert!((channel - 1.0).abs() < ROUNDING, "{channel}");
            }
        });
    }

    /// The luminance of the working space's RGB is K_m ∫ ȳ, whatever the light.
    #[test]
    fn luminous_intensity_survives_the_way_to_rgb() {
        for space in ColorSpace::ALL {
            let colorimetry = Colorimetry::new(Observer::Cie1931, space);
            let weights = space.primaries().luminance_weights();
            for illuminant in Illuminant::ALL {
                let spectrum = illuminant.spectrum();
                let rgb = colorimetry.light(&spectrum);
                let y: f64 = weights.iter().zip(rgb).map(|(w, c)| w * c).sum();
                let luminous = colorimetry.luminous(&spectrum);
                // Adaptation is not free of luminance: Bradford keeps Y of white, and of other
                // colors as well as it moves them; to ACES' white that is percent for sodium.
                let bound = if space == ColorSpace::AcesCg {
                    0.02
                } else {
                    2e-4
                };
                assert!(
                    (y / luminous - 1.0).abs() < bound,
                    "{}: {}",
                    illuminant.name(),
                    y / luminous
                );
            }
        }
    }

    #[test]
    fn colors_become_spectra_and_come_back() {
        everywhere(|colorimetry, space| {
            for literal in [
                [0.8, 0.3, 0.05],
                [0.05, 0.3, 0.8],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [0.0, 0.0, 1.0],
                [1.0, 1.0, 0.0],
                [0.0, 1.0, 1.0],
                [1.0, 0.0, 1.0],
                [0.0; 3],
                [1.0; 3],
                [0.18; 3],
            ] {
                let rgb = converted(literal, ColorSpace::Rec709, space);
                let reflectance = colorimetry
                    .reflectance_of(if literal[0] == literal[1] && literal[1] == literal[2] {
                        literal
                    } else {
                        rgb
                    })
                    .unwrap_or_else(|| panic!("{literal:?} in {}", space.name()));
                let back = colorimetry.reflectance(&reflectance.of(&Spectrum::constant(1.0)));
                for (back, rgb) in back.into_iter().zip(rgb) {
                    assert!((back - rgb).abs() <= upsample::RESIDUAL, "{back} {rgb}");
                }
            }
        });
    }

    /// The primaries of P3 and wider spaces are, but for P3's green and blue as light, at the edge
    /// of what light can be, where no smooth spectrum is.
    #[test]
    fn primaries_within_reach() {
        for (space, as_light, as_surface) in [
            (ColorSpace::Rec709, [true; 3], [true; 3]),
            (ColorSpace::P3D65, [false, true, true], [false; 3]),
            (ColorSpace::Rec2020, [false; 3], [false; 3]),
            (ColorSpace::AcesCg, [false; 3], [false; 3]),
        ] {
            let colorimetry = Colorimetry::new(Observer::Cie1931, space);
            let unit = |i: usize| [0, 1, 2].map(|j: usize| if i == j { 1.0 } else { 0.0 });
            let light = [0, 1, 2].map(|i: usize| colorimetry.unbounded(unit(i)).is_some());
            let surface = [0, 1, 2].map(|i: usize| colorimetry.reflectance_of(unit(i)).is_some());
            assert_eq!((light, surface), (as_light, as_surface), "{}", space.name());
        }
    }
}
