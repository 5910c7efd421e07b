//! What the equations say about one point of the image, term by term.

use std::f64::consts::PI;

use serde::Serialize;

use super::hit::Hit;
use super::lighting::Model;
use super::outcome::Outcome;
use super::vector::{add, length, narrowed, widened};
use super::ways::WayTerms;
use super::wide::{ROUNDING, Real};
use super::{Lamp, Oracle, Shine, Smooth, Term};

/// L9 at one point of the image with all its terms, as `candela probe --json` writes it.
///
/// Lengths are in meters, positions and directions in world space, colors linear RGB of the scene's
/// color space. Where light is carried spectrally, light is given as the observer sees it, and a
/// reflectance as it looks under white light, illuminant D65: their products are taken wavelength by
/// wavelength, so that those of the RGB are others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Explanation {
    /// How light is carried.
    pub transport: TransportUsed,
    /// What the primary ray hits (L1, L2); `None` where that is nothing.
    pub hit: Option<HitTerms>,
    /// The terms of the sum, in the order of the file; empty where nothing is hit, or what has no lobes. Under a coat
    /// they are those of the lobes alone, of which it lets 1 − R through.
    pub lights: Vec<LightTerms>,
    /// Where the hit is on a perfectly smooth surface, the ways of light over it, the strongest first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub ways: Vec<WayTerms>,
    /// How many there are that are not among `ways`.
    #[serde(skip_serializing_if = "is_zero")]
    pub more_ways: usize,
    /// L9, and what comes over smooth surfaces: L_o in cd/m²; the background where nothing is hit.
    pub radiance: [f64; 3],
}

/// How light is carried from the lamps to the viewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum TransportUsed {
    /// In three channels.
    Rgb,
    /// Wavelength by wavelength.
    Spectral,
}

/// The nearest surface along the primary ray.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct HitTerms {
    /// The object's name, or that of a light.
    pub object: String,
    /// The name of the mesh's group, where the file has groups.
    pub group: Option<String>,
    /// The triangle's index in the mesh file, where the object is a mesh.
    pub triangle: Option<usize>,
    /// The material's name; of a light its own.
    pub material: String,
    /// What it sends to the viewer, where it is a light, which reflects nothing; `None` for objects.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub emission: Option<EmissionTerms>,
    /// What the material says.
    pub reflectance: MaterialTerms,
    /// p
    pub position: [f64; 3],
    /// n, turned towards the viewer; interpolated where a mesh has vertex normals.
    pub normal: [f64; 3],
    /// The normal of the surface itself, turned towards the viewer.
    pub geometric_normal: [f64; 3],
    /// ω_o, the unit direction from p to the viewer.
    pub to_viewer: [f64; 3],
    /// p′ − p: how far from p its shadow rays start, in meters, where the mesh says
    /// `shadow_terminator = "hanika"`; else `None`.
    pub lift: Option<[f64; 3]>,
    /// t of L1: from the eye, or from the image plane of an orthographic camera, to p.
    pub distance: f64,
    /// How far p is from the eye, or from the plane through it, along the view axis: `Z` of
    /// `--layers depth`.
    pub depth: f64,
}

/// What a light that is hit sends to the viewer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct EmissionTerms {
    /// L_e in cd/m².
    pub luminance: [f64; 3],
    /// Whether it shines to this side; if not it is black.
    pub shines: bool,
}

/// The constants of L5 and L7.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MaterialTerms {
    /// `phong` or `normalized_phong`; `mirror`, `metal`, `glass` or `pane`, which have no lobes.
    pub model: &'static str,
    /// Whether there is a coat over the lobes.
    #[serde(skip_serializing_if = "is_false")]
    pub is_coated: bool,
    /// k_d or ρ_d
    pub diffuse: [f64; 3],
    /// k_s or ρ_s
    pub specular: [f64; 3],
    /// n, if it was written.
    pub shininess: Option<f64>,
}

/// One light's term of L9: `radiance` = `incident` · (`diffuse` + `specular`) · V, channel by channel
/// where light is carried as RGB, else wavelength by wavelength and not of these RGB.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LightTerms {
    /// The light's name.
    pub name: String,
    /// I in candela; of a sun E in lux, of an area L in cd/m².
    pub intensity: [f64; 3],
    /// d; infinite for a sun, in JSON `null`; of an area to its middle.
    pub distance: f64,
    /// Of a spot, where in its cone p is; `None` for other lights, and where d is 0.
    pub spot: Option<SpotTerms>,
    /// Of a luminaire, what it sends towards p; `None` for other lights, and where d is 0.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub luminaire: Option<LuminaireTerms>,
    /// Of an area, how large it is as seen from p, and how much of it is seen; `None` for other lights.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub area: Option<AreaTerms>,
    /// L3: I / d² in lux, of a spot I f(θ) / d², of a sun E, of an area L Ω; 0 where d is 0.
    pub incident: [f64; 3],
    /// ω_i, the unit direction from p to the light; 0 where d is 0. Of an area to its middle.
    pub to_light: [f64; 3],
    /// cos(n, ω_i), below 0 counted as 0. Of an area the mean over what is above the surface.
    pub cos_incident: f64,
    /// L6: ω_r; 0 where d is 0.
    pub reflected: [f64; 3],
    /// cos(ω_o, ω_r), below 0 counted as 0. Of an area, where there is a lobe, the largest.
    pub cos_lobe: f64,
    /// L5: r_d in sr⁻¹, cosine included; 0 where the light is below the surface. Of an area the mean over what is above.
    pub diffuse: [f64; 3],
    /// L7: r_s in sr⁻¹, with all factors of the model; 0 where the light is below the surface. Of an area the mean
    /// over what is above.
    pub specular: [f64; 3],
    /// What becomes of this light here.
    pub outcome: Outcome,
    /// L4: whether V is 1, of an area for all of it that is above the surface; also where there are panes alone.
    pub visible: bool,
    /// The panes that it is seen through; `None` where there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub panes: Option<PaneTerms>,
    /// The name of the object that stands between (from p′ on, where shadow rays are lifted), the nearest to p;
    /// `None` where V is 1. Of an area the first of those that hide a part of it.
    pub occluder: Option<String>,
    /// L_i r in cd/m²: what the light's share would be with V = 1; 0 where the light is below the
    /// surface.
    pub unoccluded: [f64; 3],
    /// The light's share of L9 in cd/m².
    pub radiance: [f64; 3],
}

/// What panes let through.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PaneTerms {
    /// Their names, the nearest to p first; of an area those before a part of it, in the order of the file.
    pub names: Vec<String>,
    /// V = Π T, of an area the part of its light that arrives.
    pub transmittance: f64,
}

/// Where in a spot's cone a point is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SpotTerms {
    /// θ, between the axis and the way from the light, in degrees.
    pub angle: f64,
    /// f(θ): 1 up to the inner angle, 0 from the outer on.
    pub falloff: f64,
}

/// What a luminaire sends towards a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LuminaireTerms {
    /// The vertical and the horizontal angle of its file, in degrees.
    pub angles: [f64; 2],
    /// The intensity there over that into the brightest direction.
    pub factor: f64,
}

/// How a light with an area is seen from a point.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AreaTerms {
    /// Ω: how large it is above the surface, in sr.
    pub solid_angle: f64,
    /// The part of the light that leaves p, if it reflects to all sides alike, that would reach it: ∫ cos(n, ω_i) dω / π.
    pub form_factor: f64,
    /// How much of its light that would arrive without anything in the way does: a part from 0 to 1.
    pub seen: f64,
    /// The names of what hides a part of it, in the order of the file.
    pub occluders: Vec<String>,
    /// How far `radiance` may be off, in cd/m², by the integral's own estimate.
    pub error: [f64; 3],
}

impl Oracle {
    /// L1 and L2, for reading.
    pub(super) fn hit_terms(&self, hit: &Hit) -> HitTerms {
        let object = self.object(hit.surface);
        let triangle = self.surfaces[hit.surface].triangle;
        HitTerms {
            object: object.name.clone(),
            group: triangle.and_then(|triangle| object.group(triangle)),
            triangle,
            material: object.material_name.clone(),
            emission: self.emitted(hit).map(|emitted| EmissionTerms {
                luminance: self.palette.seen(&emitted),
                shines: self.shines(hit),
            }),
            reflectance: MaterialTerms {
                model: match (&object.smooth, object.material.model) {
                    (Some(smooth), _) if !smooth.has_lobes() => smooth.kind(),
                    (_, Model::Phong) => "phong",
                    (_, Model::NormalizedPhong) => "normalized_phong",
                },
                is_coated: matches!(object.smooth.as_deref(), Some(Smooth::Coat(_))),
                diffuse: self.palette.under_white(&object.material.diffuse),
                specular: self.palette.under_white(&object.material.specular),
                shininess: object.material.shininess,
            },
            position: self.as_written(hit),
            normal: narrowed(hit.normal),
            geometric_normal: narrowed(hit.geometric_normal),
            to_viewer: narrowed(hit.to_viewer),
            lift: hit.lift.map(|lift| narrowed(lift.way)),
            distance: hit.distance.narrow(),
            depth: self.camera.depth(hit.position),
        }
    }

    /// p from the scene's origin. What is smaller than the rounding of the numbers it is a sum of is 0.
    pub(super) fn as_written(&self, hit: &Hit) -> [f64; 3] {
        let far = length(hit.position).narrow();
        let size = [0, 1, 2].map(|axis| self.reference[axis].abs() + far);
        let position = narrowed(add(hit.position, widened(self.reference)));
        [0, 1, 2].map(|axis| {
            if position[axis].abs() <= ROUNDING * size[axis] {
                0.0
            } else {
                position[axis]
            }
        })
    }

    /// L3 to L8 for one light, for reading.
    pub(super) fn light_terms(&self, hit: &Hit, light: &Lamp) -> LightTerms {
        let term = self.term(hit, light);
        let occluder = match (&term.shine, term.outcome) {
            (Some(shine), _) => shine.occluders.first().copied(),
            (None, Outcome::Lit | Outcome::Through | Outcome::Partial | Outcome::AtPoint) => None,
            (None, Outcome::Occluded | Outcome::Below | Outcome::Outside) => {
                self.occluder(hit, light)
            }
        };
        let panes = self.pane_terms(&term);
        LightTerms {
            name: light.name.clone(),
            intensity: self.palette.seen(&light.intensity),
            distance: term.distance,
            spot: term.spot,
            luminaire: term.luminaire,
            area: term.shine.map(|shine| self.area_terms(&shine)),
            incident: self.palette.seen(&term.incident),
            to_light: term.to_light,
            cos_incident: term.cos_incident,
            reflected: term.reflected,
            cos_lobe: term.cos_lobe,
            diffuse: self.palette.under_white(&term.reflectance.diffuse),
            specular: self.palette.under_white(&term.reflectance.specular),
            outcome: term.outcome,
            visible: occluder.is_none(),
            panes,
            occluder: occluder.map(|surface| self.object(surface).name.clone()),
            unoccluded: self.palette.seen(&term.unoccluded),
            radiance: self.palette.seen(&term.radiance),
        }
    }

    fn pane_terms(&self, term: &Term) -> Option<PaneTerms> {
        let name = |&surface: &usize| self.object(surface).name.clone();
        (!term.panes.is_empty()).then(|| PaneTerms {
            names: term.panes.iter().map(name).collect(),
            transmittance: term.transmittance,
        })
    }

    fn area_terms(&self, shine: &Shine) -> AreaTerms {
        let mut occluders: Vec<String> = Vec::new();
        // Surfaces of one object follow each other.
        for &surface in &shine.occluders {
            let name = &self.object(surface).name;
            if occluders.last() != Some(name) {
                occluders.push(name.clone());
            }
        }
        AreaTerms {
            solid_angle: shine.solid_angle,
            form_factor: shine.projected / PI,
            seen: shine.seen,
            occluders,
            error: self.palette.seen_error(&shine.error),
        }
    }
}

/// For what is left out of JSON, where there is nothing of it.
fn is_zero(count: &usize) -> bool {
    *count == 0
}

fn is_false(flag: &bool) -> bool {
    !flag
}
