//! L5 to L8 at one point for one light, without the light's color and the material's.

use super::power;
use crate::math::{DVec3, Point};
use crate::visibility::SurfacePoint;
use crate::world::material::Model;
use crate::world::{Lobes, Material, Plan};

/// What one light does at one point, by geometry alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Geometry {
    /// The light is above the surface: cosine terms over d², in m⁻².
    Lit(Lobes<f64>),
    /// The light is below the surface and adds nothing.
    Below,
    /// The light is at the point itself, d = 0, where L3 has no value; it adds nothing.
    Singular,
}

impl Geometry {
    pub(super) fn new(
        point: &SurfacePoint,
        light: Point,
        material: &Material,
        plan: &Plan,
    ) -> Self {
        if point.is_at(light) {
            return Self::Singular;
        }
        if !point.faces(light) {
            return Self::Below;
        }
        let to_light = light.from(point.position);
        let distance_squared = to_light.dot(to_light);
        let incident = to_light / distance_squared.sqrt();
        let normal = point.shading_normal.get();
        let cos_incident = positive(normal.dot(incident));
        let specular = if plan.specular() && material.is_specular() {
            let cos_lobe = positive(point.to_viewer.get().dot(reflection(normal, incident)));
            let lobe = power(cos_lobe, material.shininess());
            match material.model() {
                Model::Phong => lobe,
                Model::NormalizedPhong => lobe * cos_incident,
            }
        } else {
            0.0
        };
        // Closer than 1e-154 to a light the quotient is beyond f64, and would make a black channel
        // NaN.
        let per_area = |cosine: f64| (cosine / distance_squared).min(f64::MAX);
        Self::Lit(Lobes {
            diffuse: per_area(cos_incident),
            specular: per_area(specular),
        })
    }

    /// Whether the light is above the surface, so that L4 matters.
    pub(super) fn faces_light(&self) -> bool {
        match self {
            Self::Lit(_) => true,
            Self::Below | Self::Singular => false,
        }
    }
}

/// L6: ω_r = 2 (n·ω_i) n − ω_i, the ideal direction of reflection.
fn reflection(normal: DVec3, incident: DVec3) -> DVec3 {
    normal * (2.0 * normal.dot(incident)) - incident
}

/// Cosines below 0 count as 0.
fn positive(cosine: f64) -> f64 {
    if cosine > 0.0 { cosine } else { 0.0 }
}
