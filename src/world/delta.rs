//! Perfectly smooth surfaces (delta reflection and transmission): what each makes of a ray, before its color.

use std::sync::Arc;

use super::colorimetry::SpectralReflectance;
use crate::spectrum::Spectrum;

/// What a material reflects like a mirror, or lets through.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq)]
pub enum Delta {
    /// L = R L_r
    Mirror(Tint),
    /// L = R L_r + (1 − R) L_lobes, R the same at all wavelengths.
    Coat {
        /// R across the surface.
        reflectance: f64,
        /// Whether it rises to 1 at grazing angles.
        schlick: bool,
    },
    /// L = R L_r, R of Fresnel's equations at each wavelength.
    Metal(Arc<ComplexIndex>),
    /// L = F L_r + (1 − F) L_t
    Glass(Glass),
    /// L = R L_r + T L_t of both faces, unbent.
    Pane {
        /// The refractive index.
        n: f64,
    },
}

/// R of a mirror across the surface.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq)]
pub struct Tint {
    /// Under white light, in the working space.
    pub rgb: [f64; 3],
    /// Where light is carried spectrally.
    pub reflectance: Option<SpectralReflectance>,
    /// Whether it rises to 1 at grazing angles.
    pub schlick: bool,
}

/// n + ik over the wavelength.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq)]
pub struct ComplexIndex {
    /// The real part.
    pub n: Spectrum,
    /// The imaginary part.
    pub k: Spectrum,
}

/// A body that bends light.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq)]
pub struct Glass {
    /// The refractive index at 587.6 nm.
    pub n: f64,
    /// The index over the wavelength, where each goes a way of its own.
    pub dispersion: Option<Arc<Spectrum>>,
    /// σ in m⁻¹; `None` of clear glass.
    pub absorption: Option<Absorption>,
}

/// σ of a glass in m⁻¹.
#[doc(hidden)]
#[derive(Clone, Debug, PartialEq)]
pub struct Absorption {
    /// In each channel of the working space.
    pub rgb: [f64; 3],
    /// Where light is carried spectrally.
    pub spectrum: Option<SpectralReflectance>,
}

impl Delta {
    /// Its kind, as in a scene file.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Mirror(_) => "mirror",
            Self::Coat { .. } => "coat",
            Self::Metal(_) => "metal",
            Self::Glass(_) => "glass",
            Self::Pane { .. } => "pane",
        }
    }

    /// Whether anything is seen through it.
    pub(crate) fn transmits(&self) -> bool {
        match self {
            Self::Glass(_) | Self::Pane { .. } => true,
            Self::Mirror(_) | Self::Coat { .. } | Self::Metal(_) => false,
        }
    }

    /// Whether what is seen by way of it may have another color, where light is carried spectrally.
    pub(crate) fn colors(&self) -> bool {
        let is_curve = |value: Option<&SpectralReflectance>| {
            matches!(value, Some(SpectralReflectance::Spectrum(_)))
        };
        match self {
            Self::Mirror(tint) => is_curve(tint.reflectance.as_ref()),
            Self::Metal(_) => true,
            Self::Glass(glass) => {
                let absorption = glass.absorption.as_ref();
                let spectrum = absorption.and_then(|absorption| absorption.spectrum.as_ref());
                glass.dispersion.is_some() || is_curve(spectrum)
            }
            Self::Coat { .. } | Self::Pane { .. } => false,
        }
    }

    /// Whether there are lobes under it, which lights light.
    pub fn has_lobes(&self) -> bool {
        match self {
            Self::Coat { .. } => true,
            Self::Mirror(_) | Self::Metal(_) | Self::Glass(_) | Self::Pane { .. } => false,
        }
    }
}
