//! Perfectly smooth materials: mirrors, metals, glass, panes and coats, with what they say as components.

use super::components::Components;
use super::fresnel;
use super::spectrum::{at, flat, interpolated, on_grid};
use super::value::{Palette, is_number, numbers};
use super::wide::{Real, Wide};
use crate::optics::{Glass as KnownGlass, Metal as KnownMetal};
use crate::scene::{self, GlassIndex};

/// The helium d line in nm, where all light goes unless it is dispersed.
const D_LINE: f64 = 587.5618;

/// What a smooth material does with a ray.
#[derive(Clone, Debug)]
pub(super) enum Smooth {
    /// L = R L(reflected)
    Mirror(Mirror),
    /// L = R L(reflected) + (1 − R) L_lobes
    Coat(Mirror),
    /// L = R L(reflected), R of n + ik, at each wavelength.
    Metal { n: Components, k: Components },
    /// L = F L(reflected) + (1 − F)(n_i/n_t)² L(refracted)
    Glass(Glass),
    /// L = R L(reflected) + T L(straight on)
    Pane { n: f64 },
}

/// R of a mirror, or of a coat.
#[derive(Clone, Debug)]
pub(super) struct Mirror {
    /// Across the surface.
    reflectance: Components,
    /// Whether it rises to 1 at grazing angles.
    schlick: bool,
}

/// A body that bends light.
#[derive(Clone, Debug)]
pub(super) struct Glass {
    /// Where all light goes the same way.
    n: f64,
    /// Where each wavelength goes its own.
    dispersed: Option<Components>,
    /// σ in m⁻¹
    absorption: Components,
}

impl Smooth {
    /// `None` of lobes alone.
    pub(super) fn new(material: &scene::Material, palette: &Palette) -> Option<Self> {
        let mirror = |mirror: &scene::Mirror| Mirror {
            reflectance: palette.reflectance(&mirror.reflectance.value),
            schlick: mirror.schlick,
        };
        Some(match material {
            scene::Material::Phong(lobes) | scene::Material::NormalizedPhong(lobes) => {
                Self::Coat(mirror(lobes.coat.as_ref()?))
            }
            scene::Material::Mirror(written) => Self::Mirror(mirror(written)),
            scene::Material::Metal(metal) => Self::metal(metal),
            scene::Material::Glass(glass) => Self::Glass(Glass::new(glass, palette)),
            scene::Material::Pane(pane) => Self::Pane { n: pane.n.value },
        })
    }

    fn metal(metal: &scene::Metal) -> Self {
        match metal {
            scene::Metal::Preset(name) => {
                // One that is not known is not in a legal scene.
                let points = KnownMetal::named(&name.value).map_or(&[][..], |known| known.points);
                let [wavelengths, n, k] = [0, 1, 2]
                    .map(|column: usize| points.iter().map(|p| p[column]).collect::<Vec<f64>>());
                let index = |values: &[f64]| match values {
                    [] => flat(0.0),
                    values => on_grid(|nm| interpolated(&wavelengths, values, nm)),
                };
                Self::Metal {
                    n: index(&n),
                    k: index(&k),
                }
            }
            scene::Metal::Indices { n, k } => Self::Metal {
                n: numbers(&n.value),
                k: numbers(&k.value),
            },
        }
    }

    /// As in a scene file.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Mirror(_) => "mirror",
            Self::Coat(_) => "coat",
            Self::Metal { .. } => "metal",
            Self::Glass(_) => "glass",
            Self::Pane { .. } => "pane",
        }
    }

    /// Whether there are lobes under it, which lights light.
    pub(super) fn has_lobes(&self) -> bool {
        match self {
            Self::Coat(_) => true,
            Self::Mirror(_) | Self::Metal { .. } | Self::Glass(_) | Self::Pane { .. } => false,
        }
    }
}

impl Mirror {
    /// R where the ray has this cosine.
    pub(super) fn at(&self, cos: Wide) -> Components {
        let cos = cos.narrow();
        let Components(across) = &self.reflectance;
        Components(if self.schlick {
            across.iter().map(|&r| fresnel::schlick(r, cos)).collect()
        } else {
            across.clone()
        })
    }
}

/// R of a metal at each wavelength, where the ray has this cosine; in RGB that of the spectrum.
pub(super) fn of_metal(n: &Components, k: &Components, cos: Wide, palette: &Palette) -> Components {
    let both = n.0.iter().zip(&k.0);
    let reflectance = both.map(|(&n, &k)| fresnel::conductor(cos.narrow(), n, k));
    palette.of_spectrum(Components(reflectance.collect()))
}

impl Glass {
    fn new(glass: &scene::Glass, palette: &Palette) -> Self {
        let (n, dispersed) = match &glass.index {
            GlassIndex::Value(value) => {
                let on_grid = numbers(&value.value);
                let n = at(&on_grid, D_LINE);
                (n, (!is_number(&value.value)).then_some(on_grid))
            }
            GlassIndex::Sellmeier(name) => match KnownGlass::named(&name.value) {
                Some(known) => {
                    let coefficients = known.dispersion;
                    let n = |nm: f64| sellmeier(coefficients.b, coefficients.c, nm);
                    (n(D_LINE), Some(on_grid(n)))
                }
                // Not in a legal scene.
                None => (1.0, None),
            },
        };
        Self {
            n,
            dispersed: dispersed.filter(|_| glass.dispersion && palette.is_spectral()),
            absorption: palette.reflectance(&glass.absorption.value),
        }
    }

    /// Whether each wavelength goes a way of its own.
    pub(super) fn is_dispersive(&self) -> bool {
        self.dispersed.is_some()
    }

    /// n, of one of the wavelengths where these go their own ways.
    pub(super) fn index(&self, wavelength: Option<usize>) -> f64 {
        match (&self.dispersed, wavelength) {
            (Some(Components(n)), Some(wavelength)) => n[wavelength],
            _ => self.n,
        }
    }

    /// e^(−σx): what is left after so many meters.
    pub(super) fn left_after(&self, distance: f64) -> Components {
        let Components(absorption) = &self.absorption;
        let left = |&sigma: &f64| {
            // However far it is.
            if sigma == 0.0 {
                1.0
            } else {
                (-sigma * distance).exp()
            }
        };
        Components(absorption.iter().map(left).collect())
    }
}

/// n² = 1 + Σ B λ²/(λ² − C), λ in µm (Sellmeier 1871).
fn sellmeier(b: [f64; 4], c: [f64; 4], nm: f64) -> f64 {
    let squared = (nm / 1000.0).powi(2);
    let terms = b.iter().zip(c).map(|(b, c)| b * squared / (squared - c));
    (1.0 + terms.sum::<f64>()).sqrt()
}
