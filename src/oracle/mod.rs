//! The lecture's equations, as exactly as they can be computed: the truth that the renderer is compared with.
//!
//! One small function for each equation, brute force, from the scene as it was written. Nothing
//! here is shared with the renderer but the published tables of the CIE and of refractive indices, neither its vectors nor its
//! materials nor its colors nor its search for the nearest hit, so that no mistake can hide on both
//! sides.
//!
//! | | equation | function |
//! | --- | --- | --- |
//! | L1 | r(t) = o + t ω | `camera`: `perspective_ray`, `orthographic_ray` |
//! | L2 | ‖r(t) − c‖² = R² | `surface`: `ray_sphere`, `ray_plane`, `ray_triangle` |
//! | L3 | L_i = I / d² | `lighting`: `incident_light` |
//! | L4 | V ∈ {0, 1} | `occlusion`: `sphere_between`, `plane_between`, `triangle_between` |
//! | | p′ = p + Σ bᵢ max(0, (vᵢ − p)·nᵢ) nᵢ | `terminator`: `OnTriangle::lift` |
//! | L5 | r_d = k_d cos(n, ω_i) | `lighting`: `diffuse_reflectance` |
//! | L6 | ω_r = 2 (n·ω_i) n − ω_i | `lighting`: `ideal_reflection` |
//! | L7 | r_s = k_s cosⁿ(ω_o, ω_r) | `lighting`: `specular_reflectance` |
//! | L8 | r = r_d + r_s | `lighting`: `phong`, `normalized_phong` |
//! | L9 | L_o = Σ L_i r V | [`Oracle::radiance`] |
//! | | L = R L(reflected) + T L(beyond) | `path` |
//! | | F, of Fresnel's equations | `fresnel`: `dielectric`, `conductor`, `pane` |
//! | | ∫ L_e r V dω, over a light with an area | `quadrature` |
//!
//! L3 and L5 to L9 hold component by component, however many a color has: three where light is
//! carried as RGB, 471 where it is carried spectrally. Only what comes out is made RGB of the
//! scene's color space.
//!
//! | | what | module |
//! | --- | --- | --- |
//! | spectra | illuminants, daylight, black bodies, curves, lines | `spectrum` |
//! | X = K_m ∫ S x̄ dλ | colors of spectra, Bradford's adaptation, RGB spaces | `colorimetry` |
//! | R = ½ + x / (2 √(1 + x²)) | reflectances of colors (Jakob & Hanika 2019) | `upsampling` |
//! | | values in all notations | `value` |
//! | ∫∫ L_o dx dy | the mean over a pixel | [`PixelQuadrature`] |
//!
//! Where things are is computed in numbers of twice f64's length (`wide`), relative to the eye, so that neither
//! a scene far from the origin nor one that is tiny beside its spheres loses precision. f64 decides only what it
//! surely can: which surfaces a line misses. Light and colors are f64.
//!
//! The scene must be legal, as [`crate::world`] decides. One that is not gives wrong numbers, but
//! no panic: a material that is not there is black, a camera without a direction sees the
//! background.

mod area;
mod camera;
mod colorimetry;
mod components;
mod decisions;
mod explanation;
mod fresnel;
mod hit;
mod lamp;
mod light;
mod lighting;
mod luminaire;
mod media;
mod occlusion;
mod outcome;
mod panes;
mod path;
mod pixel;
mod quadrature;
mod shine;
mod smooth;
mod spectrum;
mod spot;
mod surface;
mod terminator;
#[cfg(test)]
mod tests;
mod upsampling;
mod value;
mod vector;
mod way;
mod ways;
mod wide;

use std::collections::HashMap;
use std::sync::Arc;

use crate::mesh::MeshGroup;
use crate::scene::{Object, Scene};

use camera::{Camera, Ray};
use components::Components;
#[doc(hidden)]
pub use decisions::{Beyond, Decisions};
#[doc(hidden)]
pub use explanation::{
    AreaTerms, EmissionTerms, LuminaireTerms, PaneTerms, SpotTerms, TransportUsed,
};
pub use explanation::{Explanation, HitTerms, LightTerms, MaterialTerms};
use hit::Hit;
use lamp::{Lamp, Place};
use light::Light;
use lighting::{Material, Reflectance, cosine, ideal_reflection, incident_light};
use media::Media;
#[doc(hidden)]
pub use outcome::Event;
pub use outcome::Outcome;
use panes::Crossing;
pub use pixel::{PixelMean, PixelQuadrature};
use quadrature::Effort;
use shine::Shine;
use smooth::Smooth;
use surface::Surface;
use value::Palette;
use vector::{Vector, ZERO, length, narrowed, subtract, unit};
use way::Between;
#[doc(hidden)]
pub use ways::{VertexTerms, WayTerms};
use wide::{Real, Wide};

/// How far the integral over a light may be off, relative to that with nothing in the way, if effort allows.
const TOLERANCE: f64 = 1e-8;

/// A scene, ready for the equations.
#[derive(Clone, Debug)]
pub struct Oracle {
    resolution: [u32; 2],
    /// The eye as written: the origin of all positions below.
    reference: Vector,
    camera: Camera,
    palette: Palette,
    /// Radiance where nothing is hit.
    background: Components,
    /// In the order of the file, each mesh triangle by triangle; lights that are seen come last.
    surfaces: Vec<Surface>,
    /// In the order of the file, and after them the lights that are seen.
    objects: Vec<NamedObject>,
    /// In the order of the file.
    lights: Vec<Lamp>,
    /// The glass objects.
    media: Media,
    /// How often a ray is reflected or refracted at most.
    max_depth: u32,
    /// When an integral over a light is good enough.
    effort: Effort,
}

/// What the surfaces of one object have in common.
#[derive(Clone, Debug)]
struct NamedObject {
    name: String,
    groups: Vec<MeshGroup>,
    material_name: String,
    /// Shared by all objects that have it.
    material: Arc<Material>,
    /// What it does beside its lobes, or without any.
    smooth: Option<Arc<Smooth>>,
}

/// The value of a point of the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// L_o (L9) in cd/m², linear RGB of the scene's color space; the background where nothing is
    /// hit.
    pub radiance: [f64; 3],
    /// 1 where something is hit, else 0.
    pub coverage: f64,
    /// How far R, G and B may be off, by its own estimate: integrals over lights with an area have an end. 0 where there
    /// are none.
    pub error: [f64; 3],
    /// What of `radiance` would come from those lights with an area of which something hides a part, if nothing did.
    pub unshadowed: [f64; 3],
}

/// Which surface a ray hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[doc(hidden)]
pub struct HitId {
    /// The object's index in the scene; lights that are seen come after all objects, in the order of the file.
    pub object: usize,
    /// For a mesh, the triangle's index in the mesh file.
    pub triangle: Option<usize>,
}

/// One light's term of L9 and what it is made of.
struct Term {
    distance: f64,
    /// Of a spot: θ and f(θ).
    spot: Option<SpotTerms>,
    /// Of a luminaire: the angles, and what is sent there.
    luminaire: Option<LuminaireTerms>,
    /// Of a light with an area: what of it is above the horizon, and what is seen.
    shine: Option<Box<Shine>>,
    incident: Components,
    to_light: Vector,
    cos_incident: f64,
    reflected: Vector,
    cos_lobe: f64,
    reflectance: Reflectance,
    outcome: Outcome,
    /// The surfaces of panes that it is seen through, the nearest first; of an area those before a part of it.
    panes: Vec<usize>,
    /// V of these panes; of an area that part of its light that arrives.
    transmittance: f64,
    /// L_i r; of an area ∫ L_e r dω
    unoccluded: Components,
    /// L_i r V; of an area ∫ L_e r V dω
    radiance: Components,
}

impl Oracle {
    /// Prepares a legal scene: transforms its meshes and turns its colors into components.
    pub fn new(scene: &Scene) -> Self {
        let resolution = scene.image.resolution.value;
        let reference = scene.camera.value.view().eye.value;
        let surfaces = scene.objects.iter().enumerate();
        let palette = Palette::new(scene);
        let materials = scene.materials.iter();
        let materials: HashMap<&str, Arc<Material>> = materials
            .map(|entry| {
                let material = Material::new(&entry.value, &palette);
                (entry.name.as_str(), Arc::new(material))
            })
            .collect();
        let smooth: HashMap<&str, Arc<Smooth>> = scene
            .materials
            .iter()
            .filter_map(|entry| {
                let smooth = Smooth::new(&entry.value, &palette)?;
                Some((entry.name.as_str(), Arc::new(smooth)))
            })
            .collect();
        let black = Arc::new(Material::black(&palette));
        let lights: Vec<Lamp> = scene
            .lights
            .iter()
            .map(|light| Lamp::new(&light.name, &light.value, &palette, reference))
            .collect();
        let mut objects: Vec<NamedObject> = scene
            .objects
            .iter()
            .map(|object| {
                let name = object.value.material().value.as_str();
                let material = materials.get(name).unwrap_or(&black);
                NamedObject {
                    smooth: smooth.get(name).cloned(),
                    ..NamedObject::new(&object.name, &object.value, material)
                }
            })
            .collect();
        let mut surfaces: Vec<Surface> = surfaces
            .flat_map(|(index, object)| Surface::all_of(index, &object.value, reference))
            .collect();
        for (index, light) in lights.iter().enumerate() {
            if let Some(area) = light.area.as_ref().filter(|area| area.is_visible) {
                surfaces.push(area.surface(index, objects.len()));
                objects.push(NamedObject::of_light(&light.name, &black));
            }
        }
        Self {
            resolution,
            reference,
            camera: Camera::new(&scene.camera.value, resolution),
            background: palette.light(&scene.image.background.value),
            media: Media::new(&surfaces, |object| {
                matches!(objects[object].smooth.as_deref(), Some(Smooth::Glass(_)))
            }),
            surfaces,
            objects,
            lights,
            max_depth: scene.image.max_depth.value as u32,
            effort: Effort {
                tolerance: TOLERANCE,
                most: Self::EFFORT,
            },
            palette,
        }
    }

    /// How often at most it is asked of a light with an area at a point whether a surface hides a part of one of its
    /// lines, unless it is [told otherwise](Self::with_effort).
    pub const EFFORT: usize = 200_000;

    /// With so many questions at most; with more of them the penumbra of complex things has smaller errors.
    #[must_use]
    pub fn with_effort(mut self, effort: usize) -> Self {
        self.effort.most = effort;
        self
    }

    /// Width and height of the image in pixels.
    pub fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    /// L9 at a point of the image: L_o(ω_o) = Σ L_i(p) r(ω_i, ω_o) V(p), over the lights in the
    /// order of the file.
    ///
    /// `px` and `py` are in pixels from the top left corner of the image; the center of pixel
    /// (x, y) is (x + 0.5, y + 0.5).
    pub fn radiance(&self, px: f64, py: f64) -> Sample {
        let seen = self.seen(px, py);
        Sample {
            radiance: self.palette.seen(&seen.light.radiance),
            coverage: if seen.is_covered { 1.0 } else { 0.0 },
            error: self.palette.seen_error(&seen.light.error),
            unshadowed: self.palette.seen(&seen.light.unshadowed),
        }
    }

    /// L9 wavelength by wavelength, where light is carried so: L_o(λ) in W·m⁻²·sr⁻¹·nm⁻¹ at each nm
    /// from 360 to 830; coordinates as in [`Oracle::radiance`]. The background where nothing is hit,
    /// `None` where light is carried as RGB.
    pub fn spectral_radiance(&self, px: f64, py: f64) -> Option<Vec<f64>> {
        if !self.palette.is_spectral() {
            return None;
        }
        let Components(radiance) = self.seen(px, py).light.radiance;
        Some(radiance)
    }

    /// What the primary ray hits; coordinates as in [`Oracle::radiance`].
    pub fn trace(&self, px: f64, py: f64) -> Option<HitId> {
        let hit = self.nearest(&self.camera.primary_ray(px, py))?;
        Some(self.id(&hit))
    }

    /// The name of what is hit: of an object, or of a light.
    #[doc(hidden)]
    pub fn name_of(&self, hit: HitId) -> &str {
        &self.objects[hit.object].name
    }

    /// L9 with all its terms; coordinates as in [`Oracle::radiance`].
    pub fn explain(&self, px: f64, py: f64) -> Explanation {
        let transport = if self.palette.is_spectral() {
            TransportUsed::Spectral
        } else {
            TransportUsed::Rgb
        };
        let hit = self.nearest(&self.camera.primary_ray(px, py));
        let (ways, more_ways) = match &hit {
            Some(hit) if self.smooth(hit).is_some() => self.strongest_ways(px, py),
            _ => (Vec::new(), 0),
        };
        let lights = hit.as_ref().map_or_else(Vec::new, |hit| {
            self.lights_of(hit)
                .map(|light| self.light_terms(hit, light))
                .collect()
        });
        Explanation {
            transport,
            hit: hit.as_ref().map(|hit| self.hit_terms(hit)),
            lights,
            ways,
            more_ways,
            radiance: self.palette.seen(&self.seen(px, py).light.radiance),
        }
    }

    /// L1 and L2: the nearest hit. Of equally near ones the first in the file counts.
    fn nearest(&self, ray: &Ray) -> Option<Hit> {
        self.nearest_of(ray, 0..self.surfaces.len())
    }

    /// The same among some surfaces, in the order of the file.
    fn nearest_of(&self, ray: &Ray, among: impl Iterator<Item = usize>) -> Option<Hit> {
        self.nearest_by(ray, among, |index| self.surfaces[index].intersect(ray))
    }

    /// The same by what tells where each is met.
    fn nearest_by(
        &self,
        ray: &Ray,
        among: impl Iterator<Item = usize>,
        met: impl Fn(usize) -> Option<Wide>,
    ) -> Option<Hit> {
        let mut nearest: Option<(usize, Wide)> = None;
        for index in among {
            if let Some(t) = met(index)
                && nearest.is_none_or(|(_, smallest)| t < smallest)
            {
                nearest = Some((index, t));
            }
        }
        let (surface, distance) = nearest?;
        Some(Hit::new(surface, &self.surfaces[surface], ray, distance))
    }

    /// L9: the sum over all lights; what a light sends out, where one is hit.
    fn sum_over_lights(&self, hit: &Hit) -> Light {
        if let Some(emitted) = self.emitted(hit) {
            return Light::only(emitted);
        }
        let mut light = Light::only(self.background.zero());
        for term in self.lights.iter().map(|light| self.term(hit, light)) {
            let mut of_term = Light::only(term.radiance);
            if let Some(shine) = term.shine {
                of_term.error = shine.error;
                if let Outcome::Partial | Outcome::Occluded = term.outcome {
                    of_term.unshadowed = term.unoccluded;
                }
            }
            light = light.plus(&of_term);
        }
        light
    }

    /// The lights that have a term where a ray has hit: a light has no lobes, and a mirror none either.
    fn lights_of(&self, hit: &Hit) -> impl Iterator<Item = &Lamp> {
        let is_light = self.surfaces[hit.surface].light.is_some();
        let has_lobes = !is_light && self.smooth(hit).is_none_or(Smooth::has_lobes);
        self.lights.iter().filter(move |_| has_lobes)
    }

    /// L3 to L8: one light's term of L9.
    fn term(&self, hit: &Hit, light: &Lamp) -> Term {
        let material = self.material(hit);
        self.term_of(
            hit,
            light,
            &light.intensity,
            material,
            0..self.surfaces.len(),
            self.effort,
        )
    }

    /// The same for a light of this intensity on a surface of this material, which only some surfaces may be
    /// in the way of.
    fn term_of(
        &self,
        hit: &Hit,
        light: &Lamp,
        intensity: &Components,
        material: &Material,
        occluders: impl Iterator<Item = usize>,
        effort: Effort,
    ) -> Term {
        if let Some(area) = &light.area {
            return self.area_term(hit, (light, area), intensity, material, occluders, effort);
        }
        let segment = self.segment(hit, light);
        let Some(to_light) = unit(segment.vector()).filter(|_| !segment.is_a_point()) else {
            return Term::nothing(material);
        };
        let distance = match light.place {
            Place::At(_) => length(segment.vector()).narrow(),
            Place::Toward(_) => f64::INFINITY,
        };
        let spot = light.cone.map(|cone| {
            let angle = cone.angle(narrowed(subtract(segment.from, segment.to)));
            SpotTerms {
                angle: angle.to_degrees(),
                falloff: cone.falloff(angle),
            }
        });
        let luminaire = light.luminaire.as_ref().map(|luminaire| {
            let angles = luminaire.angles(narrowed(subtract(segment.from, segment.to)));
            LuminaireTerms {
                angles,
                factor: luminaire.factor(angles),
            }
        });
        let factor = luminaire.map(|luminaire| luminaire.factor);
        let falloff = spot.map(|spot| spot.falloff).or(factor).unwrap_or(1.0);
        let incident = match light.place {
            Place::At(_) => incident_light(intensity, distance).scaled(falloff),
            // L3 of parallel light: L_i = E.
            Place::Toward(_) => intensity.clone(),
        };
        let cos_incident = cosine(hit.normal, to_light);
        let reflected = ideal_reflection(hit.normal, to_light);
        let cos_lobe = cosine(hit.to_viewer, reflected);

        let mut panes: Vec<Crossing> = Vec::new();
        let outcome = if !self.light_is_above(hit, &segment, to_light) {
            Outcome::Below
        } else if falloff == 0.0 {
            Outcome::Outside
        } else {
            match self.between(hit, light, occluders) {
                Between::Surface(_) => Outcome::Occluded,
                Between::Panes(crossed) if crossed.is_empty() => Outcome::Lit,
                Between::Panes(crossed) => {
                    panes = crossed;
                    Outcome::Through
                }
            }
        };
        let reflectance = match outcome {
            Outcome::Lit | Outcome::Partial | Outcome::Through | Outcome::Occluded => {
                material.reflectance(cos_incident, cos_lobe)
            }
            Outcome::Below | Outcome::Outside | Outcome::AtPoint => material.nothing(),
        };
        let transmittance = panes.iter().map(|pane| pane.transmittance).product();
        let visibility = match outcome {
            Outcome::Lit => 1.0,
            Outcome::Through => transmittance,
            Outcome::Partial
            | Outcome::Occluded
            | Outcome::Below
            | Outcome::Outside
            | Outcome::AtPoint => 0.0,
        };
        let unoccluded = incident.times(&reflectance.sum());
        Term {
            distance,
            spot,
            luminaire,
            shine: None,
            incident,
            to_light: narrowed(to_light),
            cos_incident: cos_incident.narrow(),
            reflected: narrowed(reflected),
            cos_lobe: cos_lobe.narrow(),
            reflectance,
            outcome,
            panes: panes.iter().map(|pane| pane.surface).collect(),
            transmittance,
            radiance: unoccluded.scaled(visibility),
            unoccluded,
        }
    }

    fn id(&self, hit: &Hit) -> HitId {
        let surface = &self.surfaces[hit.surface];
        HitId {
            object: surface.object,
            triangle: surface.triangle,
        }
    }

    fn object(&self, surface: usize) -> &NamedObject {
        &self.objects[self.surfaces[surface].object]
    }

    fn material(&self, hit: &Hit) -> &Material {
        &self.object(hit.surface).material
    }
}

impl NamedObject {
    fn new(name: &str, object: &Object, material: &Arc<Material>) -> Self {
        Self {
            name: name.to_owned(),
            groups: match object {
                Object::Mesh { geometry, .. } => geometry.groups.clone(),
                Object::Sphere { .. } | Object::Plane { .. } | Object::Triangle { .. } => {
                    Vec::new()
                }
            },
            material_name: object.material().value.clone(),
            material: Arc::clone(material),
            smooth: None,
        }
    }

    /// A light that is seen: it reflects nothing.
    fn of_light(name: &str, black: &Arc<Material>) -> Self {
        Self {
            name: name.to_owned(),
            groups: Vec::new(),
            material_name: name.to_owned(),
            material: Arc::clone(black),
            smooth: None,
        }
    }

    /// The name of the group that a triangle of the mesh belongs to.
    fn group(&self, triangle: usize) -> Option<String> {
        let triangle = u32::try_from(triangle).ok()?;
        self.groups
            .iter()
            .find(|group| group.triangles.contains(&triangle))
            .map(|group| group.name.clone())
    }
}

impl Term {
    /// The outcome, by which values jump.
    fn decided(&self, light: &Lamp) -> Outcome {
        match self.outcome {
            Outcome::Lit | Outcome::Through | Outcome::Occluded | Outcome::Below
                if light.area.is_some() =>
            {
                Outcome::Partial
            }
            outcome => outcome,
        }
    }

    /// d = 0, the model's singularity: the light adds nothing.
    fn nothing(material: &Material) -> Self {
        let reflectance = material.nothing();
        let dark = reflectance.sum();
        Self {
            distance: 0.0,
            spot: None,
            luminaire: None,
            shine: None,
            incident: dark.clone(),
            to_light: ZERO,
            cos_incident: 0.0,
            reflected: ZERO,
            cos_lobe: 0.0,
            reflectance,
            outcome: Outcome::AtPoint,
            panes: Vec::new(),
            transmittance: 1.0,
            unoccluded: dark.clone(),
            radiance: dark,
        }
    }
}
