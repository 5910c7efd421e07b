//! The bands of a spectral image: geometry is summed over a pixel's samples, and meets the spectra
//! once a pixel.
//!
//! L9 is linear in I · k, and I · k depends on the light and the material alone:
//!
//! L(λ) = Σ_(light, material) I(λ) k_d(λ) · G_d + I(λ) k_s(λ) · G_s, G = Σ_samples geometry / N
//!
//! so that a band costs two multiplications for each light and material that a pixel shows,
//! however many samples it has.

use crate::shading::Term;
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
        }
    }

    /// The place for a material in a pixel. Pixels come one after the other.
    pub(super) fn place(&mut self, pixel: usize, material: usize) -> Place {
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

    /// Adds a term to the sum of its light.
    pub(super) fn add(&mut self, Place(place): Place, term: &Term) {
        let sum = &mut self.sums[place * self.lights + term.light];
        // At a light the terms are as large as f64 holds; infinity times black would be NaN.
        let and = |sum: f64, more: f64| (sum + more).min(f64::MAX);
        sum.diffuse = and(sum.diffuse, term.geometry.diffuse);
        sum.specular = and(sum.specular, term.geometry.specular);
    }

    /// Adds the radiance of each pixel before `end` to its sum, band by band, and forgets it.
    /// `sums` holds pixel by pixel, band by band.
    pub(super) fn finish(&mut self, end: usize, bands: &Bands, sums: &mut [f64]) {
        let count = bands.wavelengths().count();
        let finished = self.seen.partition_point(|seen| seen.pixel < end);
        for (place, seen) in self.seen.drain(..finished).enumerate() {
            let pixel = &mut sums[seen.pixel * count..][..count];
            let geometry = &self.sums[place * self.lights..][..self.lights];
            for (light, geometry) in geometry.iter().enumerate() {
                let reflected = bands.transport(light, seen.material);
                add_scaled(pixel, geometry.diffuse, reflected.diffuse);
                add_scaled(pixel, geometry.specular, reflected.specular);
            }
        }
        self.sums.drain(..finished * self.lights);
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
        let term = Term {
            point: 0,
            light: 0,
            material: 0,
            geometry: Lobes {
                diffuse: f64::MAX,
                specular: 0.0,
            },
        };
        geometry.add(place, &term);
        geometry.add(place, &term);
        assert_eq!(geometry.sums[0].diffuse, f64::MAX);
    }
}
