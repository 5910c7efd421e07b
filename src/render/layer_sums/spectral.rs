//! Radiance band by band.

use std::collections::HashMap;

use super::super::bands::{self, Further, Geometry, Place};
use super::super::batch::NumberedSamples;
use super::path_bands::PathBands;
use crate::shading::{LightTerms, Shaded, emitter_seen};
use crate::simd::{LANES, ones};
use crate::visibility::{PACKETS, Points};
use crate::world::{Bands, World};

/// What some samples of a packet reflect with.
#[derive(Clone, Copy, Debug)]
struct PixelShare {
    packet: usize,
    /// Its place among the shares of the packet.
    share: usize,
    /// One bit for each sample that has it, and any weight of it.
    samples: u32,
    /// Where its sums are.
    place: Place,
}

/// The bands of a tile's pixels.
pub(super) struct SpectralSums<'b> {
    bands: &'b Bands<'b>,
    geometry: Geometry,
    /// Of a batch: packet by packet, pixel by pixel, in the order of their first sample.
    shares: Vec<PixelShare>,
    /// Of pixels with all samples, pixel by pixel, band by band.
    sums: Vec<f64>,
    /// Of one pixel, whatever it has.
    pixel: Vec<f64>,
    /// What lights that are seen send along their normals, band by band.
    emission: HashMap<usize, Vec<f64>>,
    /// What comes by mirrors and glass, where there are any.
    paths: Option<Box<PathBands<'b>>>,
}

impl<'b> SpectralSums<'b> {
    pub(super) fn new(world: &World, bands: &'b Bands<'b>) -> Self {
        Self {
            bands,
            geometry: Geometry::new(bands.lights()),
            shares: Vec::new(),
            sums: Vec::new(),
            pixel: Vec::new(),
            emission: HashMap::new(),
            paths: world.has_deltas().then(|| Box::new(PathBands::new(bands))),
        }
    }

    /// Forgets all samples, and makes room for so many pixels.
    pub(super) fn begin(&mut self, pixels: usize) {
        self.geometry = Geometry::new(self.bands.lights());
        self.sums.clear();
        self.sums
            .resize(pixels * self.bands.wavelengths().count(), 0.0);
        if let Some(paths) = &mut self.paths {
            paths.begin(pixels);
        }
    }

    /// Adds what lights that are seen send themselves.
    pub(super) fn add_emission(
        &mut self,
        world: &World,
        samples: NumberedSamples<'_>,
        points: &Points,
    ) {
        if !world.has_emission() {
            return;
        }
        let count = self.bands.wavelengths().count();
        for packet in 0..PACKETS {
            for (pixel, bits) in samples.of_packet(packet * LANES) {
                for lane in ones(bits & points.hit[packet]) {
                    let slot = packet * LANES + lane;
                    let Some((index, light)) = emitter_seen(world, points, slot) else {
                        continue;
                    };
                    let bands = self.bands;
                    let emission = self
                        .emission
                        .entry(index)
                        .or_insert_with(|| bands.light(index));
                    let over_area = light.over_area();
                    let sums = &mut self.sums[pixel * count..][..count];
                    for (sum, band) in sums.iter_mut().zip(emission) {
                        *sum += *band * over_area;
                    }
                }
            }
        }
    }

    /// What comes by mirrors and glass, where there are any.
    pub(super) fn paths(&mut self) -> Option<&mut PathBands<'b>> {
        self.paths.as_deref_mut()
    }

    /// Finds the places of what the points of a batch reflect with.
    pub(super) fn begin_lights(&mut self, samples: NumberedSamples<'_>, shaded: &Shaded) {
        self.shares.clear();
        let Self {
            geometry, shares, ..
        } = self;
        for packet in 0..PACKETS {
            let of_packet = shaded.shares(packet);
            if of_packet.is_empty() {
                continue;
            }
            for (pixel, samples) in samples.of_packet(packet * LANES) {
                let mut of_pixel: Vec<(usize, u32)> = of_packet
                    .iter()
                    .map(|share| share.weighted() & samples)
                    .enumerate()
                    .filter(|&(_, samples)| samples != 0)
                    .collect();
                of_pixel.sort_by_key(|(_, samples)| samples.trailing_zeros());
                shares.extend(of_pixel.into_iter().map(|(share, samples)| PixelShare {
                    packet,
                    share,
                    samples,
                    place: geometry.place(pixel, of_packet[share].reflectance as usize),
                }));
            }
        }
    }

    /// Adds what a light does at the points of a batch.
    pub(super) fn add_light(&mut self, shaded: &Shaded, terms: &LightTerms) {
        for of_pixel in &self.shares {
            let points = terms.points[of_pixel.packet] & of_pixel.samples;
            if points != 0 {
                let share = &shaded.shares(of_pixel.packet)[of_pixel.share];
                let first = of_pixel.packet * LANES;
                self.geometry
                    .add(of_pixel.place, terms, first, share, points);
            }
        }
    }

    pub(super) fn finish(&mut self, end: usize, further: Further) {
        self.geometry
            .finish(end, further, self.bands, &mut self.sums);
        if let Some(paths) = &mut self.paths {
            paths.finish(end, further);
        }
    }

    /// The sums of a pixel, with the background where samples miss.
    pub(super) fn of(&mut self, pixel: usize, misses: u32) -> &[f64] {
        let count = self.bands.wavelengths().count();
        let sums = &mut self.pixel;
        sums.clear();
        sums.extend_from_slice(&self.sums[pixel * count..][..count]);
        self.geometry.add_kept(pixel, self.bands, sums);
        let paths = self.paths.as_deref();
        let misses = misses - paths.map_or(0, |paths| paths.misses(pixel));
        bands::add_scaled(sums, f64::from(misses), self.bands.background());
        if let Some(paths) = paths {
            paths.add_to(pixel, sums);
        }
        sums
    }
}
