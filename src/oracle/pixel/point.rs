//! L9 and A at points of one pixel, with what tells smooth pieces apart.

use std::collections::HashMap;
use std::rc::Rc;

use super::super::area::Area;
use super::super::components::Components;
use super::super::hit::Hit;
use super::super::lighting::{Material, ideal_reflection};
use super::super::quadrature::Effort;
use super::super::vector::{Vector, length, narrowed, scale, subtract};
use super::super::{Decisions, Outcome, Term};
use super::PixelQuadrature;
use super::scope::{self, Beam};

/// How far integrals over lights may be off, of what a pixel may be.
const OF_TOLERANCE: f64 = 0.1;

/// The decisions behind a value, as a number: between two points that agree, it changes smoothly.
pub(super) type Signature = u32;

/// What is decided at a point.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct Decided {
    surface: Option<usize>,
    is_behind: bool,
    lights: Vec<LightDecided>,
    /// Where the surface is smooth.
    over_smooth: Option<Decisions>,
}

/// What is decided about a light.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
struct LightDecided {
    outcome: Outcome,
    /// The surfaces of the panes that it is seen through.
    panes: Vec<usize>,
    /// Whether the point is within a spot's inner angle.
    is_in_core: bool,
    /// Whether the cosines of L5 and L7 are above 0.
    is_towards: [bool; 2],
}

/// Where a point is from the peaks of the integrand, light by light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// √n (ω_r − ω_o), of length m: a lobe is about exp(−m²/2). `None` where there is none.
    lobe: Option<Vector>,
    /// p_L − p, where light arrives.
    way: Option<Vector>,
}

impl Pace {
    /// Of the nearest points.
    pub(super) fn nearer(self, other: Self) -> Self {
        let shorter = |a: Option<Vector>, b: Option<Vector>| match (a, b) {
            (Some(a), Some(b)) if length(b) < length(a) => Some(b),
            (a, b) => a.or(b),
        };
        Self {
            lobe: shorter(self.lobe, other.lobe),
            way: shorter(self.way, other.way),
        }
    }
}

/// A point of the image.
#[derive(Clone, Debug)]
pub(super) struct Point {
    pub(super) x: f64,
    pub(super) signature: Signature,
    /// R, G, B, A.
    pub(super) value: [f64; 4],
    /// Of lights that are lit; else nothing is near.
    pub(super) paces: Vec<Pace>,
}

/// Asks for points of one pixel.
pub(super) struct Points<'q> {
    quadrature: &'q PixelQuadrature<'q>,
    beam: Beam,
    /// Surfaces that primary rays may meet.
    met: Vec<usize>,
    /// Surfaces that may be between a surface and a light.
    between: HashMap<[usize; 2], Rc<[usize]>>,
    signatures: HashMap<Decided, Signature>,
    /// Of integrals over lights with an area.
    effort: Effort,
    pub(super) count: usize,
    /// The largest error of integrals over lights with an area: R, G, B, and 0.
    pub(super) noise: [f64; 4],
    /// The least and the largest R, G, B, A, and the sum of their sizes.
    range: [[f64; 4]; 2],
    total: [f64; 4],
}

impl<'q> Points<'q> {
    pub(super) fn new(quadrature: &'q PixelQuadrature<'q>, x: f64, y: f64, tolerance: f64) -> Self {
        let beam = Beam::new(quadrature.oracle, x, y);
        Self {
            quadrature,
            met: scope::met(&quadrature.balls, &beam),
            beam,
            between: HashMap::new(),
            signatures: HashMap::new(),
            effort: Effort {
                tolerance: (OF_TOLERANCE * tolerance).max(quadrature.oracle.effort.tolerance),
                ..quadrature.oracle.effort
            },
            count: 0,
            noise: [0.0; 4],
            range: [[f64::INFINITY; 4], [f64::NEG_INFINITY; 4]],
            total: [0.0; 4],
        }
    }

    /// The value at a point of the image.
    pub(super) fn at(&mut self, x: f64, y: f64) -> Point {
        self.count += 1;
        let oracle = self.quadrature.oracle;
        let ray = oracle.camera.primary_ray(x, y);
        let hit = oracle.nearest_of(&ray, self.met.iter().copied());
        let (decided, [r, g, b], alpha, paces) = match hit {
            None => (
                Decided {
                    surface: None,
                    is_behind: false,
                    lights: Vec::new(),
                    over_smooth: None,
                },
                self.quadrature.background,
                0.0,
                Vec::new(),
            ),
            Some(hit) if oracle.smooth(&hit).is_some() => self.over_smooth(&hit, x, y),
            Some(hit) => self.shade(&hit),
        };
        let value = [r, g, b, alpha];
        for (channel, &value) in value.iter().enumerate() {
            self.range[0][channel] = self.range[0][channel].min(value);
            self.range[1][channel] = self.range[1][channel].max(value);
            self.total[channel] += value.abs();
        }
        let next = self.signatures.len() as Signature;
        Point {
            x,
            signature: *self.signatures.entry(decided).or_insert(next),
            value,
            paces,
        }
    }

    /// L where a ray has hit a smooth surface.
    fn over_smooth(&mut self, hit: &Hit, x: f64, y: f64) -> (Decided, [f64; 3], f64, Vec<Pace>) {
        let oracle = self.quadrature.oracle;
        let seen = oracle.seen(x, y);
        let error = oracle.palette.seen_error(&seen.light.error);
        for (noise, error) in self.noise.iter_mut().zip(error) {
            *noise = noise.max(error);
        }
        let decided = Decided {
            surface: Some(hit.surface),
            is_behind: hit.is_behind,
            lights: Vec::new(),
            over_smooth: Some(oracle.decisions(x, y)),
        };
        let radiance = oracle.palette.seen(&seen.light.radiance);
        (decided, radiance, 1.0, Vec::new())
    }

    /// L9 where a ray has hit.
    fn shade(&mut self, hit: &Hit) -> (Decided, [f64; 3], f64, Vec<Pace>) {
        let oracle = self.quadrature.oracle;
        if let Some(light) = oracle.surfaces[hit.surface].light {
            let decided = Decided {
                surface: Some(hit.surface),
                is_behind: !hit.is_in_front,
                lights: Vec::new(),
                over_smooth: None,
            };
            let luminance = self.quadrature.luminances[light];
            let radiance = luminance.map(|c| if oracle.shines(hit) { c } else { 0.0 });
            return (decided, radiance, 1.0, Vec::new());
        }
        let count = oracle.lights.len();
        let mut decided = Decided {
            surface: Some(hit.surface),
            is_behind: hit.is_behind,
            lights: Vec::with_capacity(count),
            over_smooth: None,
        };
        let mut radiance = [0.0; 3];
        let mut paces = Vec::with_capacity(count);
        let one = Components::uniform(1.0, 3);
        for (index, light) in oracle.lights.iter().enumerate() {
            let occluders = self.occluders(hit.surface, index);
            let object = oracle.surfaces[hit.surface].object;
            let material = &self.quadrature.products[index][object];
            // L_i r is linear in the product of I and k, component by component.
            let occluders = occluders.iter().copied();
            let term = oracle.term_of(hit, light, &one, material, occluders, self.effort);
            for (sum, share) in radiance.iter_mut().zip(&term.radiance.0) {
                *sum += share;
            }
            if let Some(shine) = &term.shine {
                for (noise, error) in self.noise.iter_mut().zip(&shine.error.0) {
                    *noise = noise.max(*error);
                }
            }
            let inner = light.cone.map(|cone| cone.inner_angle().to_degrees());
            decided.lights.push(LightDecided {
                outcome: term.decided(light),
                panes: if light.area.is_some() {
                    Vec::new()
                } else {
                    term.panes.clone()
                },
                is_in_core: term
                    .spot
                    .zip(inner)
                    .is_some_and(|(spot, inner)| spot.angle <= inner),
                is_towards: [term.cos_incident > 0.0, term.cos_lobe > 0.0]
                    .map(|is_towards| is_towards || light.area.is_some()),
            });
            paces.push(pace(hit, &term, material));
        }
        (decided, radiance, 1.0, paces)
    }

    fn occluders(&mut self, surface: usize, light: usize) -> Rc<[usize]> {
        let (quadrature, beam) = (self.quadrature, &self.beam);
        let found = || {
            let oracle = quadrature.oracle;
            let own = &oracle.surfaces[surface];
            let part = beam.part_of(own, quadrature.balls[surface].as_ref());
            let light = &oracle.lights[light];
            let reach = light.area.as_ref().map_or(0.0, Area::reach);
            scope::between(&quadrature.balls, own, part, light.place, reach).into()
        };
        Rc::clone(self.between.entry([surface, light]).or_insert_with(found))
    }

    /// Whether there are points left.
    pub(super) fn may_go_on(&self) -> bool {
        self.count < self.quadrature.budget
    }

    /// What errors are relative to: of R, G, B the mean of the points so far, or a thousandth of the largest of them.
    pub(super) fn scale(&self) -> [f64; 4] {
        let means = self.total.map(|sum| sum / self.count.max(1) as f64);
        let largest = means[..3].iter().copied().fold(0.0, f64::max);
        let [r, g, b] = [0, 1, 2].map(|channel| means[channel].max(1e-3 * largest));
        [r, g, b, 1.0]
    }

    /// How far apart the values in the pixel are, as far as they were met.
    pub(super) fn spread(&self) -> [f64; 4] {
        std::array::from_fn(|channel| (self.range[1][channel] - self.range[0][channel]).max(0.0))
    }
}

fn pace(hit: &Hit, term: &Term, material: &Material) -> Pace {
    let arrives = [Outcome::Lit, Outcome::Through, Outcome::Partial];
    if !arrives.contains(&term.outcome) {
        return Pace {
            lobe: None,
            way: None,
        };
    }
    if let Some(shine) = &term.shine {
        // Of a light with an area the direction that is nearest to the lobe's.
        let from_peak = |peak| {
            let mirrored = ideal_reflection(narrowed(hit.normal), peak);
            subtract(mirrored, narrowed(hit.to_viewer))
        };
        return Pace {
            lobe: shine
                .peak
                .zip(material.shininess)
                .map(|(peak, shininess)| scale(from_peak(peak), shininess.sqrt())),
            way: Some(shine.nearest),
        };
    }
    let has_lobe = material
        .specular
        .0
        .iter()
        .any(|&component| component != 0.0);
    let from_peak = subtract(term.reflected, narrowed(hit.to_viewer));
    Pace {
        lobe: material
            .shininess
            .filter(|_| has_lobe)
            .map(|shininess| scale(from_peak, shininess.sqrt())),
        // A sun is near to nothing.
        way: term
            .distance
            .is_finite()
            .then(|| scale(term.to_light, term.distance)),
    }
}

/// Whether a peak may hide between neighbors: where a lobe changes by more than its width and may be larger than
/// nothing in between, or a light is nearer than they are to each other.
pub(super) fn may_hide_a_peak(a: &[Pace], b: &[Pace]) -> bool {
    /// In widths of the lobe.
    const STEP: f64 = 1.5;
    const NOTHING: f64 = 5.0;
    a.iter().zip(b).any(|(a, b)| {
        let lobe = a.lobe.zip(b.lobe).is_some_and(|(a, b)| {
            let step = length(subtract(a, b));
            step > STEP && length(a).min(length(b)) - 0.5 * step < NOTHING
        });
        let way = a
            .way
            .zip(b.way)
            .is_some_and(|(a, b)| length(subtract(a, b)) > length(a).min(length(b)));
        lobe || way
    })
}
