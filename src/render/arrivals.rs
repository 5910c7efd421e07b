//! Where the light of a batch of rays arrives, and how much of it.

use crate::visibility::{BATCH, Column};

/// What becomes of the light that the rays of a batch see on its way to the eye.
#[derive(Clone, Copy)]
pub(super) struct Arrivals<'a> {
    /// The camera ray that each comes from, by its place in its batch; no two come from one.
    pub(super) samples: &'a [u16],
    /// How much of the radiance arrives, per primary; where light is carried spectrally all three are the same, and
    /// filters say the rest.
    pub(super) weights: &'a [Column; 3],
}

impl Arrivals<'_> {
    /// What arrives of a part of the radiance, at the places of the camera rays.
    pub(super) fn scatter(self, from: &[Column; 3], to: &mut [Column; 3]) {
        for ((to, from), weights) in to.iter_mut().zip(from).zip(self.weights) {
            to.fill(0.0);
            for (slot, &sample) in self.samples.iter().enumerate() {
                to[usize::from(sample)] = weights[slot] * from[slot];
            }
        }
    }

    /// The same of one number of each ray, where light is carried spectrally.
    pub(super) fn scatter_one(self, from: &Column, to: &mut Column) {
        to.fill(0.0);
        for (slot, sample, weight) in self.iter() {
            to[sample] = weight * from[slot];
        }
    }

    /// The place, the camera ray and the weight of each ray, where light is carried spectrally.
    pub(super) fn iter(self) -> impl Iterator<Item = (usize, usize, f64)> {
        debug_assert!(self.samples.len() <= BATCH, "a batch is no larger");
        let weights = self.weights[0].iter();
        let samples = self.samples.iter().zip(weights).enumerate();
        samples.map(|(slot, (&sample, &weight))| (slot, usize::from(sample), weight))
    }
}
