//! The box filter: the mean over the samples of each pixel of a tile.

use std::ops::Range;

use fearless_simd::Simd;

use super::batch::{NumberedSamples, PIXELS, Run, SampleRange};
use super::counts::{BEYOND_WHITE, Counts};
use crate::simd::{F32x16, F64x16, LANES, Mask32x16, U32x16, every_nth, side_by_side};
use crate::visibility::{BATCH, Column, Points};

/// The box filter: the mean over the samples of each pixel of a tile, summed in f64.
#[derive(Clone)]
pub(super) struct PixelSums {
    radiance: [Column; 3],
    pub(super) hits: [u32; PIXELS],
}

impl Default for PixelSums {
    fn default() -> Self {
        Self {
            radiance: [Column::ZERO; 3],
            hits: [0; PIXELS],
        }
    }
}

impl PixelSums {
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }

    /// The sums of some pixels, by their numbers, in this order.
    pub(super) fn gather(&mut self, all: &Self, numbers: &[u32]) {
        let columns = self.radiance.iter_mut().zip(&all.radiance);
        for (sums, all) in columns {
            for (sum, &number) in sums.iter_mut().zip(numbers) {
                *sum = all[number as usize];
            }
        }
        for (hits, &number) in self.hits.iter_mut().zip(numbers) {
            *hits = all.hits[number as usize];
        }
    }

    /// Puts the sums of some pixels back in their places.
    pub(super) fn scatter(&self, all: &mut Self, numbers: &[u32]) {
        let columns = self.radiance.iter().zip(&mut all.radiance);
        for (sums, all) in columns {
            for (&sum, &number) in sums.iter().zip(numbers) {
                all[number as usize] = sum;
            }
        }
        for (&hits, &number) in self.hits.iter().zip(numbers) {
            all.hits[number as usize] = hits;
        }
    }

    /// Σ L of a pixel.
    pub(super) fn radiance(&self, pixel: usize) -> [f64; 3] {
        let [r, g, b] = &self.radiance;
        [r[pixel], g[pixel], b[pixel]]
    }

    /// Sets the sums of a pixel.
    pub(super) fn set(&mut self, pixel: usize, radiance: [f64; 3], hits: u32) {
        for (sums, radiance) in self.radiance.iter_mut().zip(radiance) {
            sums[pixel] = radiance;
        }
        self.hits[pixel] = hits;
    }

    /// Adds the radiance of one sample of a pixel.
    pub(super) fn add_sample(&mut self, pixel: usize, radiance: [f64; 3], is_hit: bool) {
        for (sums, radiance) in self.radiance.iter_mut().zip(radiance) {
            sums[pixel] += radiance;
        }
        self.hits[pixel] += u32::from(is_hit);
    }

    /// Adds the radiance of some samples, those of each pixel in their order.
    #[inline(always)]
    pub(super) fn add<S: Simd>(
        &mut self,
        simd: S,
        range: SampleRange,
        points: &Points,
        radiance: &[Column; 3],
    ) {
        let pixels = range.whole_pixels();
        for (sums, column) in self.radiance.iter_mut().zip(radiance) {
            fold_runs::<S, Sum, _>(simd, pixels.clone(), || range.runs(), sums, column);
        }
        match pixels {
            Some((samples, pixels)) if points.all_hit() => {
                for hits in &mut self.hits[pixels] {
                    *hits += samples as u32;
                }
            }
            _ if points.none_hit() => {}
            _ => {
                for Run { pixel, slots } in range.runs() {
                    self.hits[pixel] += points.hits(slots);
                }
            }
        }
    }

    /// R, G, B, A of sixteen pixels with so many samples each, and what of [`Counts`] is known of the first
    /// `count` by then. A pixel without samples is 0.
    #[inline(always)]
    pub(super) fn means<S: Simd>(
        &self,
        simd: S,
        first: usize,
        count: usize,
        samples: &[u32; PIXELS],
    ) -> ([[f32; 4]; LANES], Counts) {
        let one = F64x16::splat(simd, 1.0);
        let samples = U32x16::load(simd, &samples[first..]).widened(simd).max(one);
        let hits = U32x16::load(simd, &self.hits[first..]).widened(simd);
        let alpha = (hits / samples).narrowed(simd);
        let mut means = [alpha; 4];
        let mut clamped = 0;
        for (narrow, column) in means.iter_mut().zip(&self.radiance) {
            let mean = F64x16::load(simd, &column[first..]) / samples;
            let largest = F64x16::splat(simd, f64::from(f32::MAX));
            if (!mean.abs().le(largest)).any() {
                let mut values = [0.0; LANES];
                for (value, mean) in values.iter_mut().zip(mean.to_array()).take(count) {
                    let (narrow, is_clamped) = narrowed(mean);
                    *value = narrow;
                    clamped += u64::from(is_clamped);
                }
                *narrow = F32x16::load(simd, &values);
            } else {
                *narrow = mean.narrowed(simd);
            }
        }
        let [r, g, b, _] = means;
        let is_counted = Mask32x16::from_bits(simd, u32::MAX >> (u32::BITS - count as u32));
        let largest = is_counted.select(r.max(g).max(b), F32x16::splat(simd, 0.0));
        let is_beyond = largest.gt(F32x16::splat(simd, BEYOND_WHITE));
        let met = Counts {
            hits: self.hits[first..][..count]
                .iter()
                .copied()
                .map(u64::from)
                .sum(),
            clamped,
            brightest: largest.largest().max(0.0),
            beyond_white: u64::from(is_beyond.to_bits().count_ones()),
            ..Counts::default()
        };
        (side_by_side(means), met)
    }
}

/// Adds a number of each sample to the sum of its pixel, those of each pixel in their order.
#[inline(never)]
pub(super) fn add_column<S: Simd>(
    simd: S,
    samples: NumberedSamples<'_>,
    sums: &mut Column,
    column: &Column,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let runs = || samples.runs();
            fold_runs::<S, Sum, _>(simd, samples.whole_pixels(), runs, sums, column);
        },
    );
}

/// Takes the least of a number of each sample and of what its pixel has.
#[inline(never)]
pub(super) fn least_of_column<S: Simd>(
    simd: S,
    samples: NumberedSamples<'_>,
    least: &mut Column,
    column: &Column,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            let runs = || samples.runs();
            fold_runs::<S, Least, _>(simd, samples.whole_pixels(), runs, least, column);
        },
    );
}

/// What becomes of the numbers of a pixel.
trait Fold {
    fn lanes<S: Simd>(one: F64x16<S>, other: F64x16<S>) -> F64x16<S>;
    fn number(one: f64, other: f64) -> f64;
}

struct Sum;

impl Fold for Sum {
    #[inline(always)]
    fn lanes<S: Simd>(one: F64x16<S>, other: F64x16<S>) -> F64x16<S> {
        one + other
    }

    #[inline(always)]
    fn number(one: f64, other: f64) -> f64 {
        one + other
    }
}

struct Least;

impl Fold for Least {
    #[inline(always)]
    fn lanes<S: Simd>(one: F64x16<S>, other: F64x16<S>) -> F64x16<S> {
        one.min(other)
    }

    #[inline(always)]
    fn number(one: f64, other: f64) -> f64 {
        one.min(other)
    }
}

/// Folds the numbers of the samples of each pixel into what it has, in their order: of whole pixels that follow each
/// other sixteen at a time.
#[inline(always)]
fn fold_runs<S: Simd, F: Fold, R: Iterator<Item = Run>>(
    simd: S,
    whole_pixels: Option<(usize, Range<usize>)>,
    runs: impl FnOnce() -> R,
    folded: &mut Column,
    column: &Column,
) {
    match whole_pixels {
        Some((1, pixels)) => fold_each::<S, F, 1>(simd, &mut folded[pixels.start..], column),
        Some((2, pixels)) => fold_each::<S, F, 2>(simd, &mut folded[pixels.start..], column),
        Some((4, pixels)) => fold_each::<S, F, 4>(simd, &mut folded[pixels.start..], column),
        Some((8, pixels)) => fold_each::<S, F, 8>(simd, &mut folded[pixels.start..], column),
        Some((16, pixels)) => fold_each::<S, F, 16>(simd, &mut folded[pixels.start..], column),
        _ => {
            for Run { pixel, slots } in runs() {
                let numbers = column[slots].iter();
                folded[pixel] = numbers.fold(folded[pixel], |all, &one| F::number(all, one));
            }
        }
    }
}

/// Folds into each of some numbers N of its own, one after the other.
#[inline(always)]
fn fold_each<S: Simd, F: Fold, const N: usize>(simd: S, folded: &mut [f64], column: &Column) {
    for (first, folded) in (0..BATCH).step_by(N * LANES).zip(folded.chunks_mut(LANES)) {
        let mut rows = [F64x16::splat(simd, 0.0); N];
        for (place, row) in rows.iter_mut().enumerate() {
            *row = F64x16::load(simd, &column[first + place * LANES..]);
        }
        let mut all = F64x16::load(simd, folded);
        for row in every_nth(rows) {
            all = F::lanes(all, row);
        }
        all.store(folded);
    }
}

/// Here, and nowhere before, light becomes f32; whether it was beyond the largest.
pub(super) fn narrowed(light: f64) -> (f32, bool) {
    let largest = f64::from(f32::MAX);
    if light.is_nan() {
        // Two lights at the very point, one of a color beyond the gamut: ∞ − ∞ is too large as well.
        return (f32::MAX, true);
    }
    let narrow = light.clamp(-largest, largest) as f32;
    (narrow, light.abs() > largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_narrowed_once_and_counted() {
        assert_eq!(narrowed(0.1), (0.1_f32, false));
        assert_eq!(narrowed(f64::from(f32::MAX)), (f32::MAX, false));
        // Colors beyond the gamut are negative.
        for (light, expected) in [
            (1e39, f32::MAX),
            (f64::INFINITY, f32::MAX),
            (-1e39, -f32::MAX),
            (f64::NAN, f32::MAX),
        ] {
            assert_eq!(narrowed(light), (expected, true));
        }
    }
}
