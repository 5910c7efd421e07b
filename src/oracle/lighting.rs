//! L3 and L5 to L8: light that arrives, and how a surface reflects it.

use super::components::Components;
use super::value::Palette;
use super::vector::{WideVector, dot, scale, subtract};
use super::wide::{Real, Wide};
use crate::scene;

/// L3: L_i = I / d², the light that a point light sends to a point at distance d: in lux, or in
/// W·m⁻²·nm⁻¹.
pub(super) fn incident_light(intensity: &Components, distance: f64) -> Components {
    intensity.scaled(1.0 / (distance * distance))
}

/// The cosine of the angle between two unit vectors; below 0 it counts as 0.
pub(super) fn cosine(a: WideVector, b: WideVector) -> Wide {
    let (zero, one) = (Wide::from(0.0), Wide::from(1.0));
    let cosine = dot(a, b);
    if cosine > one {
        one
    } else if cosine > zero {
        cosine
    } else {
        zero
    }
}

/// L5: r_d = k_d cos(n, ω_i), Lambert's diffuse reflectance.
pub(super) fn diffuse_reflectance(k_d: &Components, cos_incident: Wide) -> Components {
    k_d.scaled(cos_incident.narrow())
}

/// L6: ω_r = 2 (n·ω_i) n − ω_i, the ideal reflection direction.
pub(super) fn ideal_reflection<T: Real>(n: [T; 3], to_light: [T; 3]) -> [T; 3] {
    subtract(scale(n, T::from(2.0) * dot(n, to_light)), to_light)
}

/// L7: r_s = k_s cosⁿ(ω_o, ω_r), the specular reflectance with shininess n.
///
/// Close to 1 the cosine's last digits are what a large n is about: cosⁿ = exp(n ln(1 − (1 − cos))).
pub(super) fn specular_reflectance(k_s: &Components, cos_lobe: Wide, shininess: f64) -> Components {
    let missing = (Wide::from(1.0) - cos_lobe).narrow();
    let power = if missing < 0.5 {
        (shininess * (-missing).ln_1p()).exp()
    } else {
        cos_lobe.narrow().powf(shininess)
    };
    k_s.scaled(power)
}

/// L8: r = r_d + r_s, kept apart, in sr⁻¹: the radiance per lux from a light at ω_i.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Reflectance {
    /// r_d
    pub(super) diffuse: Components,
    /// r_s
    pub(super) specular: Components,
}

impl Reflectance {
    /// L8: r = r_d + r_s.
    pub(super) fn sum(&self) -> Components {
        self.diffuse.plus(&self.specular)
    }
}

/// The two models that L8 stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Model {
    Phong,
    NormalizedPhong,
}

/// A material with its colors as components.
#[derive(Clone, Debug)]
pub(super) struct Material {
    pub(super) model: Model,
    /// k_d or ρ_d
    pub(super) diffuse: Components,
    /// k_s or ρ_s
    pub(super) specular: Components,
    /// n, where it was written. A lobe without n reflects nothing: a legal one has k_s = 0.
    pub(super) shininess: Option<f64>,
}

impl Material {
    /// A surface that reflects nothing.
    pub(super) fn black(palette: &Palette) -> Self {
        Self {
            model: Model::Phong,
            diffuse: palette.black(),
            specular: palette.black(),
            shininess: None,
        }
    }

    pub(super) fn new(material: &scene::Material, palette: &Palette) -> Self {
        let (model, lobes) = match material {
            scene::Material::Phong(lobes) => (Model::Phong, lobes),
            scene::Material::NormalizedPhong(lobes) => (Model::NormalizedPhong, lobes),
            // These have no lobes.
            scene::Material::Mirror(_)
            | scene::Material::Metal(_)
            | scene::Material::Glass(_)
            | scene::Material::Pane(_) => return Self::black(palette),
        };
        Self {
            model,
            diffuse: palette.reflectance(&lobes.diffuse.value),
            specular: palette.reflectance(&lobes.specular.value),
            shininess: lobes.shininess.as_ref().map(|shininess| shininess.value),
        }
    }

    /// No reflectance, of as many components.
    pub(super) fn nothing(&self) -> Reflectance {
        Reflectance {
            diffuse: self.diffuse.zero(),
            specular: self.specular.zero(),
        }
    }

    /// L8, by the material's model, from cos(n, ω_i) and cos(ω_o, ω_r).
    pub(super) fn reflectance(&self, cos_incident: Wide, cos_lobe: Wide) -> Reflectance {
        match self.model {
            Model::Phong => self.phong(cos_incident, cos_lobe),
            Model::NormalizedPhong => self.normalized_phong(cos_incident, cos_lobe),
        }
    }

    /// L8, the lecture's model to the letter: r = k_d cos(n, ω_i) + k_s cosⁿ(ω_o, ω_r).
    fn phong(&self, cos_incident: Wide, cos_lobe: Wide) -> Reflectance {
        Reflectance {
            diffuse: diffuse_reflectance(&self.diffuse, cos_incident),
            specular: match self.shininess {
                Some(n) => specular_reflectance(&self.specular, cos_lobe, n),
                None => self.specular.zero(),
            },
        }
    }

    /// L8, normalized (Lafortune & Willems 1994):
    /// r = cos(n, ω_i) [ρ_d/π + ρ_s (n+2)/(2π) cosⁿ(ω_o, ω_r)].
    fn normalized_phong(&self, cos_incident: Wide, cos_lobe: Wide) -> Reflectance {
        use std::f64::consts::{FRAC_1_PI, TAU};
        Reflectance {
            diffuse: diffuse_reflectance(&self.diffuse.scaled(FRAC_1_PI), cos_incident),
            specular: match self.shininess {
                Some(n) => specular_reflectance(&self.specular, cos_lobe, n)
                    .scaled((n + 2.0) / TAU * cos_incident.narrow()),
                None => self.specular.zero(),
            },
        }
    }
}
