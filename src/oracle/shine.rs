//! Lights with an area: what is seen of one, and its term of L9.

use super::area::Area;
use super::components::Components;
use super::hit::Hit;
use super::lamp::Lamp;
use super::lighting::{Material, Model, Reflectance, cosine, ideal_reflection};
use super::outcome::Outcome;
use super::quadrature::{self, Effort, Integrals, Kernel};
use super::vector::{Vector, WideVector, length, narrowed, subtract, unit, widened};
use super::wide::Real;
use super::{Oracle, Place, Smooth, Term};

/// What is known of a light with an area beside its term.
#[derive(Clone, Debug)]
pub(super) struct Shine {
    /// ∫ dω over what is above the horizon.
    pub(super) solid_angle: f64,
    /// ∫ cos(n, ω_i) dω
    pub(super) projected: f64,
    /// The part of that which is seen; of the solid angle, where that is 0.
    pub(super) seen: f64,
    /// How far the term of L9 may be off.
    pub(super) error: Components,
    /// The surfaces that hide a part of it.
    pub(super) occluders: Vec<usize>,
    /// The unit vector to where of it the lobe is largest.
    pub(super) peak: Option<Vector>,
    /// The shortest way to it.
    pub(super) nearest: Vector,
}

impl Shine {
    /// Of a light of which nothing is above the horizon, or which does not shine to p.
    fn nothing(material: &Material) -> Self {
        Self {
            solid_angle: 0.0,
            projected: 0.0,
            seen: 0.0,
            error: material.diffuse.zero(),
            occluders: Vec::new(),
            peak: None,
            nearest: [0.0; 3],
        }
    }
}

impl Oracle {
    /// L_e where a ray has hit a light: nothing from behind. `None` on all else.
    pub(super) fn emitted(&self, hit: &Hit) -> Option<Components> {
        let light = &self.lights[self.surfaces[hit.surface].light?];
        Some(if self.shines(hit) {
            light.intensity.clone()
        } else {
            light.intensity.zero()
        })
    }

    /// Whether a ray has hit a light on a side that shines.
    pub(super) fn shines(&self, hit: &Hit) -> bool {
        let light = self.surfaces[hit.surface].light;
        let area = light.and_then(|light| self.lights[light].area.as_ref());
        area.is_some_and(|area| area.shines(hit.is_in_front))
    }

    /// The term of a light with an area, of this luminance, on a surface of this material, which only some surfaces
    /// may be in the way of. Where shadow rays are lifted it is taken at p′, above the horizon of n.
    pub(super) fn area_term(
        &self,
        hit: &Hit,
        (light, area): (&Lamp, &Area),
        luminance: &Components,
        material: &Material,
        among: impl Iterator<Item = usize>,
        effort: Effort,
    ) -> Term {
        let segment = self.shadow_segment(hit, light);
        let horizon = match hit.lift {
            Some(_) => hit.normal,
            None => hit.geometric_normal,
        };
        let factors = factors(material);
        let largest = |components: &Components| components.0.iter().copied().fold(0.0, f64::max);
        let weights = [
            factors[0] * largest(&material.diffuse),
            factors[1] * largest(&material.specular),
        ];
        let way = narrowed(ideal_reflection(hit.normal, hit.to_viewer));
        let lobe = material.shininess.filter(|_| weights[1] > 0.0);
        let kernel = Kernel {
            horizon: narrowed(horizon),
            normal: narrowed(hit.normal),
            lobe: unit(way).zip(lobe),
            lobe_has_cosine: material.model == Model::NormalizedPhong,
            // Where nothing is reflected, what arrives is told.
            weights: if weights == [0.0; 2] {
                [1.0, 0.0]
            } else {
                weights
            },
        };
        let pane = |surface: usize| match self.object(surface).smooth.as_deref() {
            Some(Smooth::Pane { n }) => Some(*n),
            _ => None,
        };
        let scene = quadrature::Scene {
            surfaces: &self.surfaces,
            own: hit.surface,
            light: self.light_number(light),
            pane: &pane,
        };
        let found = quadrature::integrals(area, &segment, &kernel, &scene, among, effort);
        let middle = match light.place {
            Place::At(position) => subtract(position, segment.from),
            Place::Toward(way) => way,
        };
        let mut term = Term::of_area(hit, middle, luminance, material, factors, found);
        // Triangles of one object follow each other.
        term.panes
            .dedup_by_key(|&mut pane| self.surfaces[pane].object);
        term
    }

    fn light_number(&self, light: &Lamp) -> Option<usize> {
        self.lights
            .iter()
            .position(|other| other.name == light.name)
    }
}

impl Term {
    fn of_area(
        hit: &Hit,
        middle: WideVector,
        luminance: &Components,
        material: &Material,
        factors: [f64; 2],
        found: Result<Integrals, Outcome>,
    ) -> Self {
        let to_light = unit(middle).unwrap_or(hit.normal);
        let reflected = ideal_reflection(hit.normal, to_light);
        let nothing = material.nothing();
        let dark = nothing.sum();
        let mut term = Self {
            distance: length(middle).narrow(),
            spot: None,
            luminaire: None,
            shine: None,
            incident: dark.clone(),
            to_light: narrowed(to_light),
            cos_incident: cosine(hit.normal, to_light).narrow(),
            reflected: narrowed(reflected),
            cos_lobe: cosine(hit.to_viewer, reflected).narrow(),
            reflectance: nothing,
            outcome: Outcome::Below,
            panes: Vec::new(),
            transmittance: 1.0,
            unoccluded: dark.clone(),
            radiance: dark,
        };
        let integrals = match found {
            Ok(integrals) => integrals,
            Err(outcome) => {
                term.outcome = outcome;
                term.shine = Some(Box::new(Shine::nothing(material)));
                return term;
            }
        };
        let [solid_angle, projected, _] = integrals.whole;
        // The integral of r L_e over what a triple is of.
        let reflected_of = |triple: &[f64; 3]| Reflectance {
            diffuse: material.diffuse.scaled(factors[0] * triple[1]),
            specular: material.specular.scaled(factors[1] * triple[2]),
        };
        let of = |triple: &[f64; 3]| luminance.times(&reflected_of(triple).sum());
        let mean = integrals.whole.map(|integral| integral / solid_angle);
        let [of_solid_angle, of_projected] =
            [0, 1].map(|i: usize| integrals.seen[i] / integrals.whole[i]);
        let seen = if projected > 0.0 {
            of_projected
        } else {
            of_solid_angle
        };
        if let Some(peak) = integrals.peak {
            let way = ideal_reflection(hit.normal, hit.to_viewer);
            term.cos_lobe = cosine(way, widened(peak)).narrow();
        }
        term.incident = luminance.scaled(solid_angle);
        term.cos_incident = mean[1];
        term.reflectance = reflected_of(&mean);
        term.unoccluded = of(&integrals.whole);
        term.radiance = of(&integrals.seen);
        term.outcome = if integrals.occluders.is_empty() && integrals.panes.is_empty() {
            Outcome::Lit
        } else if integrals.occluders.is_empty() {
            Outcome::Through
        } else if integrals.seen[0] <= 0.0 {
            Outcome::Occluded
        } else {
            Outcome::Partial
        };
        term.panes = integrals.panes;
        term.transmittance = seen;
        term.shine = Some(Box::new(Shine {
            solid_angle,
            projected,
            seen,
            error: of(&integrals.error),
            occluders: integrals.occluders,
            peak: integrals.peak,
            nearest: integrals.nearest,
        }));
        term
    }
}

/// By what k_d and k_s are multiplied, beside the cosines.
fn factors(material: &Material) -> [f64; 2] {
    use std::f64::consts::{FRAC_1_PI, TAU};
    let lobe = |n: f64| (n + 2.0) / TAU;
    match material.model {
        Model::Phong => [1.0, 1.0],
        Model::NormalizedPhong => [FRAC_1_PI, material.shininess.map_or(0.0, lobe)],
    }
}
