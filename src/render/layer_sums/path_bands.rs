//! Band by band what comes by mirrors and glass, and what glass around the eye lets through.
//!
//! Light that every wavelength of has lost the same part of goes the way of all geometry: it is summed for each light and
//! material of a pixel, times its weight. Light with a filter of its own, as of a metal at an angle, is made into bands
//! where it is met:
//!
//! S_b = weight · mean_b(I(λ) k(λ) filter(λ)) · G
//!
//! Both are summed sample by sample, and only then pixel by pixel, so that the order of a sum does not depend on which
//! samples are traced together.

use std::collections::HashMap;

use super::super::arrivals::Arrivals;
use super::super::bands::{Further, Geometry, add_scaled};
use super::super::batch::NumberedSamples;
use crate::shading::{LightTerms, Shaded, emitter_seen};
use crate::simd::{LANES, ones};
use crate::visibility::{BATCH, PACKETS, Points};
use crate::world::{Bands, Lobes, World};

/// How many terms are kept before those of one sample, material and light become one.
const MANY: usize = 1 << 16;

/// What a light does at a point that a sample sees without a filter.
#[derive(Clone, Copy, Debug)]
struct Term {
    sample: usize,
    material: usize,
    light: usize,
    geometry: Lobes<f64>,
}

impl Term {
    fn key(&self) -> [usize; 3] {
        [self.sample, self.material, self.light]
    }
}

/// The bands that rays have beside those of camera rays.
pub(super) struct PathBands<'b> {
    bands: &'b Bands<'b>,
    geometry: Geometry,
    terms: Vec<Term>,
    /// Of each sample of a batch, band by band.
    of_samples: Vec<f64>,
    has_any: [bool; BATCH],
    /// Pixel by pixel, band by band.
    sums: Vec<f64>,
    /// How many camera rays of each pixel meet nothing whose background is among these.
    misses: Vec<u32>,
    /// What lights that are seen send along their normals, band by band.
    emission: HashMap<usize, Vec<f64>>,
    room: Vec<f64>,
}

impl<'b> PathBands<'b> {
    pub(super) fn new(bands: &'b Bands<'b>) -> Self {
        let count = bands.wavelengths().count();
        Self {
            bands,
            geometry: Geometry::new(bands.lights()),
            terms: Vec::new(),
            of_samples: vec![0.0; BATCH * count],
            has_any: [false; BATCH],
            sums: Vec::new(),
            misses: Vec::new(),
            emission: HashMap::new(),
            room: Vec::new(),
        }
    }

    /// Forgets all samples, and makes room for so many pixels.
    pub(super) fn begin(&mut self, pixels: usize) {
        self.geometry = Geometry::new(self.bands.lights());
        self.sums.clear();
        self.sums
            .resize(pixels * self.bands.wavelengths().count(), 0.0);
        self.misses.clear();
        self.misses.resize(pixels, 0);
    }

    /// Adds what rays that have left surfaces see of lights and of the background.
    pub(super) fn add_path(
        &mut self,
        world: &World,
        points: &Points,
        shaded: &Shaded,
        arrivals: Arrivals<'_>,
    ) {
        self.add_emission(world, points, shaded, arrivals);
        self.add_background(points, shaded, arrivals);
    }

    /// The same of camera rays that start inside of glass.
    pub(super) fn add_dimmed(
        &mut self,
        world: &World,
        samples: NumberedSamples<'_>,
        points: &Points,
        shaded: &Shaded,
        arrivals: Arrivals<'_>,
    ) {
        self.add_path(world, points, shaded, arrivals);
        for (slot, pixel) in samples.iter() {
            self.misses[pixel] += u32::from(!is_hit(points, slot));
        }
    }

    /// Adds what lights that rays meet send themselves.
    fn add_emission(
        &mut self,
        world: &World,
        points: &Points,
        shaded: &Shaded,
        arrivals: Arrivals<'_>,
    ) {
        if !world.has_emission() {
            return;
        }
        for (slot, sample, weight) in arrivals.iter() {
            if !is_hit(points, slot) {
                continue;
            }
            let Some((index, light)) = emitter_seen(world, points, slot) else {
                continue;
            };
            let bands = self.bands;
            let weight = weight * light.over_area();
            match shaded.filters.get(shaded.filters.number(slot)) {
                None => {
                    let emission = self
                        .emission
                        .entry(index)
                        .or_insert_with(|| bands.light(index));
                    self.has_any[sample] = true;
                    add_scaled(
                        of_sample(&mut self.of_samples, bands, sample),
                        weight,
                        emission,
                    );
                }
                Some(filter) => self.add(sample, weight, &bands.light_through(index, filter)),
            }
        }
    }

    /// Adds the background where rays meet nothing.
    fn add_background(&mut self, points: &Points, shaded: &Shaded, arrivals: Arrivals<'_>) {
        let bands = self.bands;
        if bands.background().iter().all(|&band| band == 0.0) {
            return;
        }
        for (slot, sample, weight) in arrivals.iter() {
            if is_hit(points, slot) {
                continue;
            }
            match shaded.filters.get(shaded.filters.number(slot)) {
                None => self.add(sample, weight, bands.background()),
                Some(filter) => self.add(sample, weight, &bands.background_through(filter)),
            }
        }
    }

    /// Adds what a light does at the points that rays meet.
    pub(super) fn add_light(
        &mut self,
        shaded: &Shaded,
        terms: &LightTerms,
        Arrivals { samples, weights }: Arrivals<'_>,
    ) {
        let Self {
            bands,
            terms: list,
            of_samples,
            has_any,
            room,
            ..
        } = self;
        for packet in 0..PACKETS {
            for share in shaded.shares(packet) {
                let lit = terms.points[packet] & share.weighted();
                if lit == 0 {
                    continue;
                }
                let material = share.reflectance as usize;
                let filter = shaded.filters.get(share.filter);
                let filtered = filter
                    .map(|filter| bands.transport_through(terms.light, material, filter, room));
                for lane in ones(lit) {
                    let slot = packet * LANES + lane;
                    let sample = usize::from(samples[slot]);
                    let weight = weights[0][slot] * share.weight(lane);
                    // At a light the terms are as large as f64 holds; infinity times black would be NaN.
                    let geometry = Lobes {
                        diffuse: (terms.geometry.diffuse[slot] * weight).min(f64::MAX),
                        specular: (terms.geometry.specular[slot] * weight).min(f64::MAX),
                    };
                    match &filtered {
                        None => list.push(Term {
                            sample,
                            material,
                            light: terms.light,
                            geometry,
                        }),
                        Some(Lobes { diffuse, specular }) => {
                            has_any[sample] = true;
                            let sums = of_sample(of_samples, bands, sample);
                            add_scaled(sums, geometry.diffuse, diffuse);
                            add_scaled(sums, geometry.specular, specular);
                        }
                    }
                }
            }
        }
        if self.terms.len() >= MANY {
            self.merge();
        }
    }

    /// Adds what the samples of a batch have come to to the sums of their pixels.
    pub(super) fn end_batch(&mut self, samples: NumberedSamples<'_>) {
        self.merge();
        let mut terms = self.terms.drain(..).peekable();
        for (slot, pixel) in samples.iter() {
            while let Some(term) = terms.next_if(|term| term.sample == slot) {
                let place = self.geometry.place(pixel, term.material);
                self.geometry.add_lobes(place, term.light, term.geometry);
            }
            if std::mem::take(&mut self.has_any[slot]) {
                let count = self.bands.wavelengths().count();
                let sums = &mut self.sums[pixel * count..][..count];
                let of_sample = of_sample(&mut self.of_samples, self.bands, slot);
                for (sum, band) in sums.iter_mut().zip(of_sample) {
                    *sum += std::mem::take(band);
                }
            }
        }
    }

    pub(super) fn finish(&mut self, end: usize, further: Further) {
        self.geometry
            .finish(end, further, self.bands, &mut self.sums);
    }

    /// How many of a pixel's rays that meet nothing are among these.
    pub(super) fn misses(&self, pixel: usize) -> u32 {
        self.misses[pixel]
    }

    /// Adds what a pixel has to its bands.
    pub(super) fn add_to(&self, pixel: usize, bands: &mut [f64]) {
        let count = bands.len();
        let mut of_pixel = self.sums[pixel * count..][..count].to_vec();
        self.geometry.add_kept(pixel, self.bands, &mut of_pixel);
        for (band, more) in bands.iter_mut().zip(of_pixel) {
            *band += more;
        }
    }

    /// Makes one of all terms of a sample, material and light. Each is summed in the order in which it came, however
    /// often this is done.
    fn merge(&mut self) {
        self.terms.sort_by_key(Term::key);
        self.terms.dedup_by(|next, sum| {
            let is_same = next.key() == sum.key();
            if is_same {
                let add = |sum: f64, more: f64| (sum + more).min(f64::MAX);
                sum.geometry = Lobes {
                    diffuse: add(sum.geometry.diffuse, next.geometry.diffuse),
                    specular: add(sum.geometry.specular, next.geometry.specular),
                };
            }
            is_same
        });
    }

    fn add(&mut self, sample: usize, weight: f64, bands: &[f64]) {
        self.has_any[sample] = true;
        add_scaled(
            of_sample(&mut self.of_samples, self.bands, sample),
            weight,
            bands,
        );
    }
}

/// The bands of a sample of a batch.
fn of_sample<'s>(of_samples: &'s mut [f64], bands: &Bands<'_>, sample: usize) -> &'s mut [f64] {
    let count = bands.wavelengths().count();
    &mut of_samples[sample * count..][..count]
}

fn is_hit(points: &Points, slot: usize) -> bool {
    points.hit[slot / LANES] >> (slot % LANES) & 1 == 1
}
