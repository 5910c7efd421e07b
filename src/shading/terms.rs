//! The terms of L9 as data: what the layers of an image are made of.

use super::groups::{Groups, Share};
use crate::simd::{LANES, ones};
use crate::units::ReflectedIntensity;
use crate::world::Lobes;

/// The terms of L9 without their color, of the points of one packet: geometry × weight for each light that
/// reaches a point and each reflectance that the point has.
///
/// A buffer that is used packet after packet: it holds at most as many entries as there are lights, and
/// products of these with the packet's reflectances.
#[derive(Clone, Debug, Default)]
pub(crate) struct Terms {
    /// What each point reflects with, point by point.
    reflecting: Vec<Reflecting>,
    /// Where in `reflecting` each point of the packet starts, and the last one ends.
    starts: [usize; LANES + 1],
    /// Light by light, in the order of the sum.
    lights: Vec<LightTerms>,
    /// I · k of each of `lights` on each of the packet's reflectances.
    products: Vec<Lobes<ReflectedIntensity>>,
    /// How many reflectances the packet has.
    shares: usize,
}

/// What one point reflects with: one of its reflectances, by its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Reflecting {
    /// The point, by its place in the batch.
    pub point: usize,
    /// An index into [`World::materials`](crate::world::World::materials).
    pub reflectance: usize,
    weight: f64,
    /// Its place among those of the packet.
    share: usize,
}

/// What a light that reaches points of a packet does there.
#[derive(Clone, Copy, Debug)]
struct LightTerms {
    light: usize,
    /// One bit for each point that it reaches.
    points: u32,
    geometry: Lobes<[f64; LANES]>,
}

/// One term of L9 without its color: what a light that is seen does at a point, by geometry and weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Term {
    /// The point, by its place in the batch.
    pub point: usize,
    /// An index into [`World::lights`](crate::world::World::lights).
    pub light: usize,
    /// An index into [`World::materials`](crate::world::World::materials).
    pub reflectance: usize,
    /// Its place in [`Terms::reflecting`].
    pub place: usize,
    /// The cosine term of each lobe over d², in m⁻², at most [`f64::MAX`], times the weight of the
    /// reflectance: times I · k it is the radiance that the lobe sends to the viewer.
    pub geometry: Lobes<f64>,
    /// I · k of each lobe, carried as the world carries light.
    pub reflected: Lobes<ReflectedIntensity>,
}

impl Terms {
    /// Forgets all terms, and takes what the points of a packet reflect with.
    pub(super) fn begin(&mut self, first: usize, hit: u32, groups: &Groups) {
        self.lights.clear();
        self.products.clear();
        self.reflecting.clear();
        self.shares = groups.shares().len();
        self.reflecting.reserve(LANES);
        for lane in 0..LANES {
            self.starts[lane] = self.reflecting.len();
            if hit >> lane & 1 == 0 {
                continue;
            }
            for (place, share) in groups.shares().iter().enumerate() {
                if share.members >> lane & 1 == 0 {
                    continue;
                }
                let weight = share.weight(lane);
                // What is of weight 0 is left out.
                if weight != 0.0 {
                    self.reflecting.push(Reflecting {
                        point: first + lane,
                        reflectance: share.reflectance as usize,
                        weight,
                        share: place,
                    });
                }
            }
        }
        self.starts[LANES] = self.reflecting.len();
    }

    /// Takes what a light does at the points that it reaches.
    pub(super) fn add(
        &mut self,
        light: usize,
        points: u32,
        geometry: Lobes<[f64; LANES]>,
        groups: &Groups,
        reflected: impl FnMut(usize) -> Lobes<ReflectedIntensity>,
    ) {
        let reflectances = groups.shares().iter();
        let reflectances = reflectances.map(|share| share.reflectance as usize);
        self.products.extend(reflectances.map(reflected));
        self.lights.push(LightTerms {
            light,
            points,
            geometry,
        });
    }

    /// What the points that are hit reflect with, point by point, whether any light reaches them or none.
    pub(crate) fn reflecting(&self) -> &[Reflecting] {
        &self.reflecting
    }

    /// All terms: light by light, point by point within.
    #[inline]
    pub(crate) fn iter(&self) -> impl Iterator<Item = Term> {
        self.lights
            .iter()
            .enumerate()
            .flat_map(move |(row, terms)| {
                ones(terms.points).flat_map(move |lane| {
                    let diffuse = terms.geometry.diffuse[lane];
                    let specular = terms.geometry.specular[lane];
                    let places = self.starts[lane]..self.starts[lane + 1];
                    places.map(move |place| {
                        let Reflecting {
                            point,
                            reflectance,
                            weight,
                            share,
                        } = self.reflecting[place];
                        Term {
                            point,
                            light: terms.light,
                            reflectance,
                            place,
                            geometry: Lobes {
                                diffuse: diffuse * weight,
                                specular: specular * weight,
                            },
                            reflected: self.products[row * self.shares + share],
                        }
                    })
                })
            })
    }
}

impl Share {
    /// Of a point of the packet.
    fn weight(&self, lane: usize) -> f64 {
        match &self.weights {
            Some(weights) => weights[lane],
            None => 1.0,
        }
    }
}
