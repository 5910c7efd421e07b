//! The bands of a spectral image: geometry is summed over a pixel's samples, and meets the spectra
//! once a pixel.
//!
//! L9 is linear in I · k, and I · k depends on the light and the material alone:
//!
//! L(λ) = Σ_(light, material) I(λ) k_d(λ) · G_d + I(λ) k_s(λ) · G_s, G = Σ_samples geometry / N
//!
//! so that a band costs two multiplications for each light and material that a pixel shows,
//! however many samples it has.

use std::collections::BTreeMap;

use crate::shading::{LightTerms, Share};
use crate::simd::ones;
use crate::world::{Bands, Lobes};

/// The geometry terms of the pixels that are being sampled.
#[derive(Clone, Debug)]
pub(super) struct Geometry {
    lights: usize,
    /// The pixels that are not finished, in the order of their first sample, each with one of its
    /// materials, in the order of their first hit.
    seen: Vec<Seen>,
    /// Σ geometry of each element of `seen`, light by light.
    sums: Vec<Lobes<f64>>,
    /// What pixels had when a pass ended after which more of their samples may come.
    kept: BTreeMap<usize, Kept>,
    /// Products of one light and material, where no table has them.
    product: Vec<f64>,
}

/// The geometry terms of a pixel between two passes.
#[derive(Clone, Debug, Default)]
struct Kept {
    materials: Vec<usize>,
    /// Material by material, light by light.
    sums: Vec<Lobes<f64>>,
}

/// Whether more samples of a pixel may come after a pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Further {
    /// It has all.
    None,
    /// In another pass.
    MayCome,
}

/// A material in a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Seen {
    pixel: usize,
    material: usize,
}

/// Where [`Geometry`] keeps the sums of a pixel's material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place(usize);

impl Geometry {
    /// For a world with so many lights.
    pub(super) fn new(lights: usize) -> Self {
        Self {
            lights,
            seen: Vec::new(),
            sums: Vec::new(),
            kept: BTreeMap::new(),
            product: Vec::new(),
        }
    }

    /// The place for a material in a pixel. Pixels come one after the other.
    pub(super) fn place(&mut self, pixel: usize, material: usize) -> Place {
        if self.seen.last().is_none_or(|last| last.pixel != pixel) {
            self.resume(pixel);
        }
        let of_pixel = self
            .seen
            .iter()
            .rev()
            .take_while(|seen| seen.pixel == pixel);
        let back = of_pixel
            .enumerate()
            .find_map(|(back, seen)| (seen.material == material).then_some(back));
        match back {
            Some(back) => Place(self.seen.len() - 1 - back),
            None => {
                self.seen.push(Seen { pixel, material });
                let length = self.sums.len() + self.lights;
                self.sums.resize(length, Lobes::default());
                Place(self.seen.len() - 1)
            }
        }
    }

    /// Adds what a light does at some points that it reaches, of the packet that starts at `first`, by their weights
    /// of a share.
    pub(super) fn add(
        &mut self,
        Place(place): Place,
        of_light: &LightTerms,
        first: usize,
        share: &Share,
        points: u32,
    ) {
        let sum = &mut self.sums[place * self.lights + of_light.light];
        let Lobes {
            mut diffuse,
            mut specular,
        } = *sum;
        for lane in ones(points) {
            let weight = share.weight(lane);
            diffuse += of_light.geometry.diffuse[first + lane] * weight;
            specular += of_light.geometry.specular[first + lane] * weight;
        }
        // At a light the terms are as large as f64 holds; infinity times black would be NaN.
        *sum = Lobes {
            diffuse: diffuse.min(f64::MAX),
            specular: specular.min(f64::MAX),
        };
    }

    /// Adds what a light does at a point, by its weight.
    pub(super) fn add_lobes(&mut self, Place(place): Place, light: usize, geometry: Lobes<f64>) {
        let sum = &mut self.sums[place * self.lights + light];
        *sum = Lobes {
            diffuse: (sum.diffuse + geometry.diffuse).min(f64::MAX),
            specular: (sum.specular + geometry.specular).min(f64::MAX),
        };
    }

    /// Takes up what a pixel had after the pass before.
    fn resume(&mut self, pixel: usize) {
        if let Some(Kept { materials, sums }) = self.kept.remove(&pixel) {
            let seen = materials.into_iter();
            self.seen
                .extend(seen.map(|material| Seen { pixel, material }));
            self.sums.extend(sums);
        }
    }

    /// Ends the pass for each pixel before `end`: adds its radiance to its sum, band by band, and forgets
    /// it, or keeps it for the next pass. `sums` holds pixel by pixel, band by band.
    pub(super) fn finish(
        &mut self,
        end: usize,
        further: Further,
        bands: &Bands<'_>,
        sums: &mut [f64],
    ) {
        let count = bands.wavelengths().count();
        let finished = self.seen.partition_point(|seen| seen.pixel < end);
        for (place, Seen { pixel, material }) in self.seen.drain(..finished).enumerate() {
            let geometry = &self.sums[place * self.lights..][..self.lights];
            match further {
                Further::None => {
                    let sums = &mut sums[pixel * count..][..count];
                    add_material(sums, geometry, material, bands, &mut self.product);
                }
                Further::MayCome => {
                    let kept = self.kept.entry(pixel).or_default();
                    kept.materials.push(material);
                    kept.sums.extend_from_slice(geometry);
                }
            }
        }
        self.sums.drain(..finished * self.lights);
    }

    /// Adds what is kept of a pixel to its sum, band by band.
    pub(super) fn add_kept(&self, pixel: usize, bands: &Bands<'_>, sums: &mut [f64]) {
        let Some(kept) = self.kept.get(&pixel) else {
            return;
        };
        let mut product = Vec::new();
        for (place, &material) in kept.materials.iter().enumerate() {
            let geometry = &kept.sums[place * self.lights..][..self.lights];
            add_material(sums, geometry, material, bands, &mut product);
        }
    }
}

/// Adds the radiance of a material of a pixel, from its geometry light by light.
/// `product` is room for a product that no table has.
fn add_material(
    sums: &mut [f64],
    geometry: &[Lobes<f64>],
    material: usize,
    bands: &Bands<'_>,
    product: &mut Vec<f64>,
) {
    for (light, geometry) in geometry.iter().enumerate() {
        if *geometry == Lobes::default() {
            continue;
        }
        let reflected = bands.transport(light, material, product);
        add_scaled(sums, geometry.diffuse, reflected.diffuse);
        add_scaled(sums, geometry.specular, reflected.specular);
    }
}

/// sum += factor · bands
pub(super) fn add_scaled(sum: &mut [f64], factor: f64, bands: &[f64]) {
    if factor > 0.0 {
        for (sum, band) in sum.iter_mut().zip(bands) {
            *sum += factor * band;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_has_one_place_for_each_material() {
        let mut geometry = Geometry::new(2);
        let first = geometry.place(0, 7);
        assert_ne!(geometry.place(0, 3), first);
        assert_eq!(geometry.place(0, 7), first);
        assert_ne!(geometry.place(1, 7), first);
        assert_eq!(geometry.sums.len(), 2 * 3);
    }

    #[test]
    fn sums_at_a_light_stay_finite() {
        let mut geometry = Geometry::new(1);
        let place = geometry.place(0, 0);
        let share = Share {
            members: 0b11,
            reflectance: 0,
            weights: None,
            filter: 0,
        };
        let mut of_light = LightTerms::default();
        of_light.geometry.diffuse.fill(f64::MAX);
        for _ in 0..2 {
            geometry.add(place, &of_light, 0, &share, 0b11);
            assert_eq!(geometry.sums[0].diffuse, f64::MAX);
        }
    }
}
