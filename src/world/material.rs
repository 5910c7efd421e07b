//! The materials of L8, in the one form that the kernels know.

use super::Lobes;
use crate::units::{Reflectance, Rgb};

/// A Phong material (L5–L8) in the one form that the kernels know:
///
/// r = k_d cos(n, ω_i) + k_s f(n·ω_i) cosⁿ(ω_o, ω_r), with f = 1 for `phong` and f = cos(n, ω_i)
/// for `normalized_phong`, whose 1/π and (n+2)/(2π) are part of k_d and k_s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    model: Model,
    /// k_d and k_s, before any light is multiplied in.
    reflectance: Lobes<Reflectance>,
    /// n. Meaningless, and 1, where k_s is 0.
    shininess: f64,
}

/// Which of the two models of L8.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Model {
    /// The lecture's, without normalization.
    Phong,
    /// Lafortune & Willems 1994: no more light leaves than arrives.
    NormalizedPhong,
}

impl Material {
    /// Without lobes: a mirror, or glass.
    pub(super) const BLACK: Self = Self {
        model: Model::Phong,
        reflectance: Lobes {
            diffuse: Reflectance(Rgb([0.0; 3])),
            specular: Reflectance(Rgb([0.0; 3])),
        },
        shininess: 1.0,
    };

    /// `phong`: k_d and k_s as they are.
    pub(super) fn phong(diffuse: [f64; 3], specular: [f64; 3], shininess: f64) -> Self {
        Self {
            model: Model::Phong,
            reflectance: Lobes {
                diffuse: Reflectance(Rgb(diffuse)),
                specular: Reflectance(Rgb(specular)),
            },
            shininess,
        }
    }

    /// `normalized_phong` from its albedos: k_d = ρ_d/π, k_s = ρ_s (n+2)/(2π).
    pub(super) fn normalized_phong(diffuse: [f64; 3], specular: [f64; 3], shininess: f64) -> Self {
        use std::f64::consts::{PI, TAU};
        Self {
            model: Model::NormalizedPhong,
            reflectance: Lobes {
                diffuse: Reflectance(Rgb(diffuse.map(|albedo| albedo / PI))),
                specular: Reflectance(Rgb(specular.map(|albedo| albedo * (shininess + 2.0) / TAU))),
            },
            shininess,
        }
    }

    /// What k_d and k_s are of the numbers that were written: 1, or those of `normalized_phong`.
    pub(super) fn factors(&self) -> Lobes<f64> {
        use std::f64::consts::{PI, TAU};
        match self.model {
            Model::Phong => Lobes {
                diffuse: 1.0,
                specular: 1.0,
            },
            Model::NormalizedPhong => Lobes {
                diffuse: 1.0 / PI,
                specular: (self.shininess + 2.0) / TAU,
            },
        }
    }

    /// Which model it is.
    #[inline]
    pub fn model(&self) -> Model {
        self.model
    }

    /// k_d and k_s of the formula above, per primary.
    #[inline]
    pub fn reflectance(&self) -> Lobes<Reflectance> {
        self.reflectance
    }

    /// k_d as it was written: of `normalized_phong` its albedo, of which the formula above has 1/π.
    pub fn albedo(&self) -> [f64; 3] {
        let Reflectance(Rgb(diffuse)) = self.reflectance.diffuse;
        diffuse.map(|channel| channel / self.factors().diffuse)
    }

    /// n. Range: above 0.
    #[inline]
    pub fn shininess(&self) -> f64 {
        self.shininess
    }

    /// Whether the material has a specular lobe at all.
    #[inline]
    pub fn is_specular(&self) -> bool {
        !self.reflectance.specular.is_black()
    }
}
