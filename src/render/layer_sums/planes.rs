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
}

impl Planes {
    pub(super) fn new(count: usize) -> Self {
        Self {
            sums: vec![Column::ZERO; count],
            is_used: vec![false; count],
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
        add_column(simd, samples, &mut self.sums[plane], column);
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
