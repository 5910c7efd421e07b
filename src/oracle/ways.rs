//! The ways of light over smooth surfaces to the viewer, vertex by vertex, for reading.

use std::collections::HashMap;

use serde::Serialize;

use super::Oracle;
use super::components::Components;
use super::hit::Hit;
use super::outcome::Event;
use super::path::{Vertex, facing};
use super::smooth::Smooth;
use super::vector::add;
use super::wide::Real;

/// So many ways are told at most.
const TOLD: usize = 16;

/// A way from the viewer to what is seen at its end.
///
/// Light goes along it in the other direction. Where each wavelength goes its own way, those over the same surfaces are
/// one here: places and angles are those of the first of them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct WayTerms {
    /// What is hit, in turn; the last is what is seen.
    pub vertices: Vec<VertexTerms>,
    /// How many wavelengths go here; `None` where all do.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wavelengths: Option<usize>,
    /// What it adds to L_o in cd/m².
    pub radiance: [f64; 3],
}

/// The end of a ray.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct VertexTerms {
    /// The object's name, or that of a light; `None` where nothing is hit.
    pub object: Option<String>,
    /// The triangle's index in the mesh file, where the object is a mesh.
    pub triangle: Option<usize>,
    /// p; `None` where nothing is hit.
    pub position: Option<[f64; 3]>,
    /// From the vertex before, or from the eye; `None` where nothing is hit.
    pub distance: Option<f64>,
    /// What becomes of the ray here.
    pub event: Event,
    /// Between the ray and the normal, in degrees; `None` where nothing is hit.
    pub angle: Option<f64>,
    /// F, R, T, or of refraction (1 − F)(n_i/n_t)², as under D65. At the end 1, or 1 − R under a coat.
    pub factor: [f64; 3],
    /// The product of all factors so far, and of e^(−σx) of the glass on the way, as under D65.
    pub product: [f64; 3],
    /// What is added here in cd/m²: 0 but at the end.
    pub radiance: [f64; 3],
}

/// A vertex, and how a ray comes there.
struct Node {
    /// The vertex before, and which of its ways.
    came: Option<[usize; 2]>,
    /// The index of its surface.
    surface: Option<usize>,
    /// But for what becomes of the ray.
    terms: VertexTerms,
    /// Of each way from here: the event, the factor, the product.
    ways: Vec<(Event, [f64; 3], [f64; 3])>,
}

/// A way, from its last vertex on.
struct End {
    node: usize,
    event: Event,
    factor: [f64; 3],
    product: [f64; 3],
    radiance: [f64; 3],
    wavelength: Option<usize>,
}

impl Oracle {
    /// The ways that add most, and how many more there are.
    pub(super) fn strongest_ways(&self, px: f64, py: f64) -> (Vec<WayTerms>, usize) {
        let mut nodes: Vec<Node> = Vec::new();
        let mut ends: Vec<End> = Vec::new();
        self.walk(&self.camera.primary_ray(px, py), |vertex| {
            ends.extend(self.ends_at(vertex));
            nodes.push(self.node(vertex));
        });
        let mut ways: Vec<(WayTerms, f64)> = Vec::new();
        let mut known: HashMap<Vec<(Option<usize>, Event)>, usize> = HashMap::new();
        for end in ends {
            let (key, way) = way_to(&nodes, &end);
            let strength = largest(end.radiance);
            let Some(wavelengths) = way.wavelengths else {
                ways.push((way, strength));
                continue;
            };
            let place = *known.entry(key).or_insert(ways.len());
            match ways.get_mut(place) {
                None => ways.push((way, strength)),
                Some((same, _)) => same.join(&way, wavelengths),
            }
        }
        for (way, strength) in &mut ways {
            *strength = largest(way.radiance);
        }
        ways.sort_by(|a, b| b.1.total_cmp(&a.1));
        let more = ways.len().saturating_sub(TOLD);
        ways.truncate(TOLD);
        (ways.into_iter().map(|(way, _)| way).collect(), more)
    }

    fn node(&self, vertex: &Vertex<'_>) -> Node {
        let under_white = |factor: &Components| self.palette.under_white(factor);
        let hit = vertex.hit;
        let surface = hit.map(|hit| hit.surface);
        let ways = vertex.ways.iter().map(|way| {
            let product = vertex.weight.times(&way.factor);
            let product = match way.wavelength {
                Some(wavelength) => product.only(wavelength),
                None => product,
            };
            (way.event, under_white(&way.factor), under_white(&product))
        });
        Node {
            came: vertex.came.map(|came| [came.vertex, came.way]),
            surface,
            terms: VertexTerms {
                object: surface.map(|surface| self.object(surface).name.clone()),
                triangle: surface.and_then(|surface| self.surfaces[surface].triangle),
                position: hit.map(|hit| self.as_written(hit)),
                distance: hit.map(|hit| hit.distance.narrow()),
                event: Event::Background,
                angle: hit.map(angle),
                factor: [1.0; 3],
                product: [1.0; 3],
                radiance: [0.0; 3],
            },
            ways: ways.collect(),
        }
    }

    /// The ways that end at a vertex: what is seen there, and what is not followed.
    fn ends_at(&self, vertex: &Vertex<'_>) -> Vec<End> {
        let mut ends = Vec::new();
        let mut add_end = |event: Event, factor: &Components, weight: &Components, seen| {
            ends.push(End {
                wavelength: vertex.wavelength,
                node: vertex.number,
                event,
                factor: self.palette.under_white(factor),
                product: self.palette.under_white(weight),
                radiance: seen,
            });
        };
        let seen = self
            .palette
            .seen(&vertex.weight.times(&vertex.seen.radiance));
        let one = Components::uniform(1.0, self.background.0.len());
        match vertex.hit {
            None => add_end(Event::Background, &one, vertex.weight, seen),
            Some(hit) => match self.smooth(hit) {
                None if self.surfaces[hit.surface].light.is_some() => {
                    add_end(Event::Emitted, &one, vertex.weight, seen);
                }
                None => add_end(Event::Lit, &one, vertex.weight, seen),
                Some(Smooth::Coat(coat)) => {
                    let through = coat.at(facing(hit).1).rest();
                    add_end(Event::Lit, &through, &vertex.weight.times(&through), seen);
                }
                Some(_) => {}
            },
        }
        for way in vertex.ways {
            let event = if way.direction.is_none() {
                Event::Lost
            } else if !vertex.goes_on {
                Event::TooDeep
            } else {
                continue;
            };
            let mut weight = vertex.weight.times(&way.factor);
            if let Some(wavelength) = way.wavelength {
                weight = weight.only(wavelength);
            }
            if !weight.is_zero() {
                ends.push(End {
                    node: vertex.number,
                    event,
                    factor: self.palette.under_white(&way.factor),
                    product: self.palette.under_white(&weight),
                    radiance: [0.0; 3],
                    wavelength: way.wavelength,
                });
            }
        }
        ends
    }
}

impl WayTerms {
    /// Adds what another wavelength does on the same way.
    fn join(&mut self, other: &Self, wavelengths: usize) {
        self.wavelengths = self.wavelengths.map(|own| own + wavelengths);
        self.radiance = add(self.radiance, other.radiance);
        for (own, other) in self.vertices.iter_mut().zip(&other.vertices) {
            own.product = add(own.product, other.product);
            own.radiance = add(own.radiance, other.radiance);
        }
    }
}

/// Over which surfaces a way leads, and its terms.
fn way_to(nodes: &[Node], end: &End) -> (Vec<(Option<usize>, Event)>, WayTerms) {
    let node = &nodes[end.node];
    let mut key = vec![(node.surface, end.event)];
    let mut vertices = vec![VertexTerms {
        event: end.event,
        factor: end.factor,
        product: end.product,
        radiance: end.radiance,
        ..node.terms.clone()
    }];
    let mut came = node.came;
    while let Some([before, way]) = came {
        let node = &nodes[before];
        let (event, factor, product) = node.ways[way];
        key.push((node.surface, event));
        vertices.push(VertexTerms {
            event,
            factor,
            product,
            ..node.terms.clone()
        });
        came = node.came;
    }
    vertices.reverse();
    let way = WayTerms {
        vertices,
        wavelengths: end.wavelength.map(|_| 1),
        radiance: end.radiance,
    };
    (key, way)
}

/// Between the ray and the normal, in degrees.
fn angle(hit: &Hit) -> f64 {
    let (_, cos) = facing(hit);
    cos.narrow().acos().to_degrees()
}

/// The largest channel.
fn largest(radiance: [f64; 3]) -> f64 {
    radiance.into_iter().map(f64::abs).fold(0.0, f64::max)
}
