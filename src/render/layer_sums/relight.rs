//! What lights of other colors need: the light of each light, reflectance by reflectance, seen directly and by ways that
//! leave all wavelengths the same part.

use fearless_simd::Simd;

use super::super::arrivals::Arrivals;
use super::super::batch::NumberedSamples;
use super::super::layers::Content;
use super::LayerSums;
use crate::shading::{Filters, LightTerms, Shaded, emitter_seen};
use crate::simd::{F64x16, LANES, ones};
use crate::visibility::{PACKETS, Points};
use crate::world::{Chain, Lobes, ReflectanceTerm};

impl LayerSums<'_> {
    /// I_v × geometry × weight × factor, reflectance by reflectance.
    #[inline(always)]
    pub(super) fn add_relight<S: Simd>(
        &mut self,
        simd: S,
        samples: NumberedSamples<'_>,
        shaded: &Shaded,
        terms: &LightTerms,
        (first, share): (usize, usize),
        arrivals: Option<Arrivals<'_>>,
    ) {
        let Some(reflectances) = &self.requested.reflectances else {
            return;
        };
        let first = first + share * reflectances.count();
        let candelas = self.requested.candelas[terms.light];
        // Few are in a batch.
        let mut done: Vec<usize> = Vec::new();
        for packet in 0..PACKETS {
            for of_packet in shaded.shares(packet) {
                let Lobes { diffuse, specular } =
                    reflectances.of_material(of_packet.reflectance as usize);
                for ReflectanceTerm {
                    reflectance,
                    factor,
                } in [diffuse, specular]
                {
                    let chain = shaded.filters.chain(of_packet.filter);
                    let place = reflectances.along(chain, reflectance);
                    if factor != 0.0 && !done.contains(&place) {
                        done.push(place);
                    }
                }
            }
        }
        for place in done {
            for (packet, &bits) in terms.points.iter().enumerate() {
                let lanes = packet * LANES..(packet + 1) * LANES;
                let mut values = [0.0; LANES];
                for of_packet in shaded.shares(packet) {
                    let lobes = reflectances.of_material(of_packet.reflectance as usize);
                    let chain = shaded.filters.chain(of_packet.filter);
                    for (lobe, geometry) in [
                        (lobes.diffuse, &terms.geometry.diffuse),
                        (lobes.specular, &terms.geometry.specular),
                    ] {
                        let along = reflectances.along(chain, lobe.reflectance);
                        if along == place && lobe.factor != 0.0 {
                            for lane in ones(bits & of_packet.members) {
                                let weight = of_packet.weight(lane) * (lobe.factor * candelas);
                                values[lane] += geometry[lanes.start + lane] * weight;
                            }
                        }
                    }
                }
                F64x16::load(simd, &values).store(&mut self.column[lanes]);
            }
            self.add_arrived(simd, samples, first + place, arrivals);
        }
    }

    /// Adds what rays that have left surfaces see of lights themselves, which is of any color, as what is flat.
    pub(super) fn add_relight_emission<S: Simd>(
        &mut self,
        simd: S,
        samples: NumberedSamples<'_>,
        points: &Points,
        filters: &Filters,
        arrivals: Arrivals<'_>,
    ) {
        let requested = self.requested;
        let Some((first, reflectances)) = requested
            .place(Content::Relight)
            .zip(requested.reflectances.as_ref())
        else {
            return;
        };
        if !self.sees_lights(points) {
            return;
        }
        let count = reflectances.count();
        // Few are in a batch.
        let mut chains: Vec<Option<Chain>> = Vec::new();
        for (packet, &bits) in points.hit.iter().enumerate() {
            for lane in ones(bits) {
                let chain = filters.chain(filters.number(packet * LANES + lane));
                if !chains.contains(&chain) {
                    chains.push(chain);
                }
            }
        }
        for &share in requested.shares.seen() {
            for &chain in &chains {
                let is_along = |slot| filters.chain(filters.number(slot)) == chain;
                if self.fill_emission(points, share, is_along) {
                    let plane = first + share * count + reflectances.along(chain, 0);
                    self.add_arrived(simd, samples, plane, Some(arrivals));
                }
            }
        }
    }

    /// Whether any point is on a light.
    pub(super) fn sees_lights(&self, points: &Points) -> bool {
        let world = self.requested.world;
        world.has_emission()
            && points.hit.iter().enumerate().any(|(packet, &bits)| {
                let mut slots = ones(bits).map(|lane| packet * LANES + lane);
                slots.any(|slot| emitter_seen(world, points, slot).is_some())
            })
    }

    /// L_v of the lights of a share that are seen by some of the rays, into the column; whether any is.
    pub(super) fn fill_emission(
        &mut self,
        points: &Points,
        share: usize,
        is_of_rays: impl Fn(usize) -> bool,
    ) -> bool {
        let requested = self.requested;
        let mut is_any = false;
        self.column.fill(0.0);
        for (packet, &bits) in points.hit.iter().enumerate() {
            for lane in ones(bits) {
                let slot = packet * LANES + lane;
                if let Some((index, light)) = emitter_seen(requested.world, points, slot)
                    && requested.shares.of_light(index) == Some(share)
                    && is_of_rays(slot)
                {
                    is_any = true;
                    self.column[slot] = requested.candelas[index] * light.over_area();
                }
            }
        }
        is_any
    }

    /// Adds the column, or what of it arrives.
    #[inline(always)]
    pub(super) fn add_arrived<S: Simd>(
        &mut self,
        simd: S,
        samples: NumberedSamples<'_>,
        plane: usize,
        arrivals: Option<Arrivals<'_>>,
    ) {
        let column = match arrivals {
            None => &self.column,
            Some(arrivals) => {
                arrivals.scatter_one(&self.column, &mut self.arrived);
                &self.arrived
            }
        };
        self.planes.add(simd, samples, plane, column);
    }
}
