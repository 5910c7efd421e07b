//! What the layers of a film keep of a tile's samples: for each kind of layer its sums, pixel by
//! pixel, in f64.
//!
//! The loop over batches tells [`LayerSums`] which points a batch has ([`LayerSums::see`]) and, where a
//! layer wants them, the terms of L9 packet by packet ([`LayerSums::add`]); without layers there are no
//! sums.

use super::bands::{self, Further, Geometry};
use super::batch::NumberedSamples;
use super::layers::{Layers, has_background_share};
use super::sums::narrowed;
use crate::camera::Camera;
use crate::image::BACKGROUND_DEPTH;
use crate::math::DVec3;
use crate::shading::Terms;
use crate::simd::ones;
use crate::visibility::{Column, Points};
use crate::world::{Bands, World};

/// The layers to make, and what they are made from.
#[derive(Clone, Copy)]
pub(super) struct RequestedLayers<'w> {
    world: &'w World,
    camera: &'w Camera,
    layers: Layers,
    bands: Option<&'w Bands<'w>>,
}

impl<'w> RequestedLayers<'w> {
    /// `None` where no layer is asked for. `bands` are those of [`Layers::spectral`].
    pub(super) fn new(
        world: &'w World,
        camera: &'w Camera,
        layers: Layers,
        bands: Option<&'w Bands<'w>>,
    ) -> Option<Self> {
        let requested = Self {
            world,
            camera,
            layers,
            bands,
        };
        (requested.sums(0).channels() > 0).then_some(requested)
    }

    /// Room for so many pixels.
    pub(super) fn sums(self, pixels: usize) -> LayerSums<'w> {
        let Self {
            world,
            camera,
            layers,
            bands,
        } = self;
        LayerSums {
            lights: layers.lights.then(|| LightSums::new(world, pixels)),
            depths: layers.depth.then(|| Depths::new(camera, pixels)),
            normals: layers.normal.then(|| vec![DVec3::ZERO; pixels]),
            spectral: bands.map(|bands| SpectralSums::new(bands, pixels)),
        }
    }
}

/// The sums of a tile's pixels. In a pass, samples come in the order of the pixels.
pub(super) struct LayerSums<'w> {
    lights: Option<LightSums<'w>>,
    depths: Option<Depths>,
    /// Σ n of each pixel.
    normals: Option<Vec<DVec3>>,
    spectral: Option<SpectralSums<'w>>,
}

impl<'w> LayerSums<'w> {
    /// How many channels a pixel has.
    pub(super) fn channels(&self) -> usize {
        let lights = self.lights.as_ref().map_or(0, |lights| 3 * lights.shares);
        let depth = usize::from(self.depths.is_some());
        let normal = 3 * usize::from(self.normals.is_some());
        let spectral = self.spectral.as_ref();
        let bands = spectral.map_or(0, |spectral| spectral.bands.wavelengths().count());
        lights + depth + normal + bands
    }

    /// Adds what the points of a batch are by themselves.
    pub(super) fn see(&mut self, batch: NumberedSamples<'_>, points: &Points) {
        let Self {
            lights,
            depths,
            normals,
            spectral: _,
        } = self;
        if let Some(depths) = depths {
            depths.add(batch, points);
        }
        if let Some(normals) = normals {
            for_each_hit(batch, points, points.shading_normals(), |pixel, normal| {
                normals[pixel] += normal;
            });
        }
        if let Some(lights) = lights {
            lights.add_background(batch, points);
        }
    }

    /// Whether any layer is made of the terms of L9.
    pub(super) fn want_terms(&self) -> bool {
        self.lights.is_some() || self.spectral.is_some()
    }

    /// Adds the terms of the points of a packet. Packets come in order.
    pub(super) fn add(&mut self, batch: NumberedSamples<'_>, terms: &Terms<'_>) {
        for (pixel, samples) in batch.of_packet(terms.first) {
            let hit = samples & terms.hit;
            if hit == 0 {
                continue;
            }
            if let Some(lights) = &mut self.lights {
                lights.add(pixel, hit, terms);
            }
            if let Some(spectral) = &mut self.spectral {
                spectral.add(pixel, hit, terms);
            }
        }
    }

    /// Ends the pass for the pixels before `end`.
    pub(super) fn finish(&mut self, end: usize, further: Further) {
        if let Some(spectral) = &mut self.spectral {
            spectral.finish(end, further);
        }
    }

    /// The values of a pixel with so many samples, `misses` of which hit nothing, in the order of [`Layers::channels`]; how many are beyond the largest f32.
    pub(super) fn means(
        &mut self,
        pixel: usize,
        misses: u32,
        samples: u32,
        values: &mut [f32],
    ) -> u64 {
        let mut output = Output {
            rest: values,
            clamped: 0,
        };
        let samples = f64::from(samples.max(1));
        if let Some(lights) = &self.lights {
            for share in lights.of(pixel) {
                output.put(share, samples);
            }
        }
        if let Some(depths) = &self.depths {
            output.put(&[depths.of(pixel)], 1.0);
        }
        if let Some(normals) = &self.normals {
            output.put(&normals[pixel].to_array(), samples);
        }
        if let Some(spectral) = &mut self.spectral {
            output.put(spectral.of(pixel, misses), samples);
        }
        output.clamped
    }
}

/// The values of a pixel that are not written yet.
struct Output<'v> {
    rest: &'v mut [f32],
    clamped: u64,
}

impl Output<'_> {
    fn put(&mut self, sums: &[f64], samples: f64) {
        let (values, rest) = std::mem::take(&mut self.rest).split_at_mut(sums.len());
        for (value, sum) in values.iter_mut().zip(sums) {
            let (mean, is_clamped) = narrowed(sum / samples);
            *value = mean;
            self.clamped += u64::from(is_clamped);
        }
        self.rest = rest;
    }
}

/// Tells of each sample of a batch that hits something its pixel, and what the columns have of it.
fn for_each_hit(
    batch: NumberedSamples<'_>,
    points: &Points,
    vectors: &[Column; 3],
    mut each: impl FnMut(usize, DVec3),
) {
    let [xs, ys, zs] = vectors;
    for (slot, pixel) in batch.iter() {
        if points.is_hit(slot) {
            each(pixel, DVec3::new(xs[slot], ys[slot], zs[slot]));
        }
    }
}

/// Σ L_i r V of each light, as if it were alone: the terms that the radiance is made of, in the
/// same order, so that the sums have the bits of a film with this light only.
struct LightSums<'w> {
    world: &'w World,
    /// How many there are in each pixel: the lights', and the background's unless that is black.
    shares: usize,
    pixels: usize,
    /// Share by share, pixel by pixel within: terms come light by light.
    sums: Vec<[f64; 3]>,
}

impl<'w> LightSums<'w> {
    fn new(world: &'w World, pixels: usize) -> Self {
        let shares = world.lights().len() + usize::from(has_background_share(world));
        Self {
            world,
            shares,
            pixels,
            sums: vec![[0.0; 3]; pixels * shares],
        }
    }

    /// The shares of a pixel.
    fn of(&self, pixel: usize) -> impl Iterator<Item = &[f64; 3]> {
        (0..self.shares).map(move |share| &self.sums[share * self.pixels + pixel])
    }

    /// Adds some samples of a pixel.
    fn add(&mut self, pixel: usize, samples: u32, terms: &Terms<'_>) {
        for of_light in terms.lights {
            let [r, g, b] = &mut self.sums[of_light.light * self.pixels + pixel];
            for lane in ones(of_light.points & samples) {
                *r += of_light.radiance[0][lane];
                *g += of_light.radiance[1][lane];
                *b += of_light.radiance[2][lane];
            }
        }
    }

    fn add_background(&mut self, batch: NumberedSamples<'_>, points: &Points) {
        let lights = self.world.lights().len();
        if self.shares == lights {
            return;
        }
        let background = self.world.background().0.0;
        for (slot, pixel) in batch.iter() {
            if !points.is_hit(slot) {
                let sum = &mut self.sums[lights * self.pixels + pixel];
                for (sum, channel) in sum.iter_mut().zip(background) {
                    *sum += channel;
                }
            }
        }
    }
}

/// The nearest of each pixel's samples along the view axis. A mean would be a place between things
/// at which there is nothing.
struct Depths {
    eye: DVec3,
    forward: DVec3,
    /// Infinite where nothing is hit.
    nearest: Vec<f64>,
}

impl Depths {
    fn new(camera: &Camera, pixels: usize) -> Self {
        Self {
            eye: camera.eye().0,
            forward: camera.forward().get(),
            nearest: vec![f64::INFINITY; pixels],
        }
    }

    fn add(&mut self, batch: NumberedSamples<'_>, points: &Points) {
        let Self {
            eye,
            forward,
            nearest,
        } = self;
        for_each_hit(batch, points, &points.position, |pixel, position| {
            let depth = (position - *eye).dot(*forward);
            if depth < nearest[pixel] {
                nearest[pixel] = depth;
            }
        });
    }

    fn of(&self, pixel: usize) -> f64 {
        let nearest = self.nearest[pixel];
        if nearest == f64::INFINITY {
            f64::from(BACKGROUND_DEPTH)
        } else {
            nearest
        }
    }
}

/// What samples of a pixel reflect with.
#[derive(Clone, Copy, Debug)]
struct PixelShare {
    /// Its place among those of the packet.
    share: usize,
    /// One bit for each sample that has it, and any weight of it.
    samples: u32,
}

/// The bands of a tile's pixels.
struct SpectralSums<'b> {
    bands: &'b Bands<'b>,
    geometry: Geometry,
    /// The shares of a packet in one pixel, in the order of their first sample.
    shares: Vec<PixelShare>,
    /// Of pixels with all samples, pixel by pixel, band by band.
    sums: Vec<f64>,
    /// Of one pixel, whatever it has.
    pixel: Vec<f64>,
}

impl<'b> SpectralSums<'b> {
    fn new(bands: &'b Bands<'b>, pixels: usize) -> Self {
        Self {
            bands,
            geometry: Geometry::new(bands.lights()),
            shares: Vec::new(),
            sums: vec![0.0; pixels * bands.wavelengths().count()],
            pixel: Vec::new(),
        }
    }

    /// Adds some samples of a pixel.
    fn add(&mut self, pixel: usize, samples: u32, terms: &Terms<'_>) {
        let Self {
            geometry, shares, ..
        } = self;
        shares.clear();
        for (share, of_share) in terms.shares.iter().enumerate() {
            let samples = of_share.weighted() & samples;
            if samples != 0 {
                shares.push(PixelShare { share, samples });
            }
        }
        shares.sort_by_key(|of_pixel| of_pixel.samples.trailing_zeros());
        for of_pixel in &*shares {
            let share = &terms.shares[of_pixel.share];
            let place = geometry.place(pixel, share.reflectance as usize);
            for of_light in terms.lights {
                geometry.add(place, of_light, share, of_pixel.samples);
            }
        }
    }

    fn finish(&mut self, end: usize, further: Further) {
        self.geometry
            .finish(end, further, self.bands, &mut self.sums);
    }

    /// The sums of a pixel, with the background where samples miss.
    fn of(&mut self, pixel: usize, misses: u32) -> &[f64] {
        let count = self.bands.wavelengths().count();
        let sums = &mut self.pixel;
        sums.clear();
        sums.extend_from_slice(&self.sums[pixel * count..][..count]);
        self.geometry.add_kept(pixel, self.bands, sums);
        bands::add_scaled(sums, f64::from(misses), self.bands.background());
        sums
    }
}
