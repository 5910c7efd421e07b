//! Channels that are sums over the samples of each pixel.

use fearless_simd::Simd;

use super::super::batch::{NumberedSamples, PIXELS, TilePixels};
use super::super::sink::RenderedTile;
use super::super::sums::{add_column, narrowed};
use crate::simd::{F64x16, LANES, U32x16};
use crate::visibility::Column;

/// The sums of channels, each with a number for each pixel of a tile.
pub(super) struct Planes {
    sums: Vec<Column>,
    /// Those to which anything was added.
    is_used: Vec<bool>,
    /// What the samples of a batch have come to, where paths add to them branch by branch: so the order of a pixel's sum
    /// does not depend on which samples are traced together.
    of_batch: Option<OfBatch>,
}

/// What the samples of a batch have come to, channel by channel.
struct OfBatch {
    columns: Vec<Column>,
    /// Those to which anything was added.
    is_used: Vec<bool>,
}

impl Planes {
    /// For so many channels; `has_paths` where batches [end](Self::end_batch).
    pub(super) fn new(count: usize, has_paths: bool) -> Self {
        Self {
            sums: vec![Column::ZERO; count],
            is_used: vec![false; count],
            of_batch: has_paths.then(|| OfBatch {
                columns: vec![Column::ZERO; count],
                is_used: vec![false; count],
            }),
        }
    }

    pub(super) fn clear(&mut self) {
        for (sums, is_used) in self.sums.iter_mut().zip(&mut self.is_used) {
            if std::mem::take(is_used) {
                sums.fill(0.0);
            }
        }
    }

    /// Adds a number of each sample.
    #[inline(always)]
    pub(super) fn add<S: Simd>(
        &mut self,
        simd: S,
        samples: NumberedSamples<'_>,
        plane: usize,
        column: &Column,
    ) {
        self.is_used[plane] = true;
        match &mut self.of_batch {
            None => add_column(simd, samples, &mut self.sums[plane], column),
            Some(of_batch) => {
                of_batch.is_used[plane] = true;
                let sums = of_batch.columns[plane].iter_mut();
                sums.zip(column.iter()).for_each(|(sum, more)| *sum += more);
            }
        }
    }

    /// Adds what the samples of a batch have come to to the sums of their pixels.
    #[inline(always)]
    pub(super) fn end_batch<S: Simd>(&mut self, simd: S, samples: NumberedSamples<'_>) {
        let Some(of_batch) = &mut self.of_batch else {
            return;
        };
        let planes = of_batch.columns.iter_mut().zip(&mut of_batch.is_used);
        for (sums, (column, is_used)) in self.sums.iter_mut().zip(planes) {
            if std::mem::take(is_used) {
                add_column(simd, samples, sums, column);
                column.fill(0.0);
            }
        }
    }

    /// Adds three numbers of each sample to three planes.
    #[inline(always)]
    pub(super) fn add_three<S: Simd>(
        &mut self,
        simd: S,
        samples: NumberedSamples<'_>,
        first: usize,
        columns: &[Column; 3],
    ) {
        for (plane, column) in (first..).zip(columns) {
            self.add(simd, samples, plane, column);
        }
    }

    /// The means over so many samples of each pixel, into the first channels; how many are beyond the largest f32.
    #[inline(always)]
    pub(super) fn means<S: Simd>(
        &self,
        simd: S,
        pixels: &TilePixels,
        taken: &[u32; PIXELS],
        rendered: &mut RenderedTile,
    ) -> u64 {
        let mut clamped = 0;
        let places = pixels.row_major();
        let largest = F64x16::splat(simd, f64::from(f32::MAX));
        for (channel, (sums, &is_used)) in self.sums.iter().zip(&self.is_used).enumerate() {
            let values = rendered.channels_mut(channel..channel + 1);
            if !is_used {
                values.fill(0.0);
                continue;
            }
            for (first, places) in (0..).step_by(LANES).zip(places.chunks(LANES)) {
                let samples = U32x16::load(simd, &taken[first..]).widened(simd);
                let samples = samples.max(F64x16::splat(simd, 1.0));
                let mean = F64x16::load(simd, &sums[first..]) / samples;
                let mut narrow = [0.0; LANES];
                if (!mean.abs().le(largest)).any() {
                    let means = mean.to_array();
                    for (narrow, mean) in narrow.iter_mut().zip(means).take(places.len()) {
                        let (value, is_clamped) = narrowed(mean);
                        *narrow = value;
                        clamped += u64::from(is_clamped);
                    }
                } else {
                    mean.narrowed(simd).store(&mut narrow);
                }
                for (&place, value) in places.iter().zip(narrow) {
                    values[place as usize] = value;
                }
            }
        }
        clamped
    }
}
