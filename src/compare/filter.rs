//! Filters along rows and columns, as ꟻLIP needs them.

use rayon::prelude::*;

use super::room;
use crate::memory::OutOfMemory;

/// An image of N numbers a pixel.
#[derive(Clone, Debug)]
pub(super) struct Grid<const N: usize> {
    pub(super) width: usize,
    pub(super) pixels: Vec<[f32; N]>,
}

impl<const N: usize> Grid<N> {
    pub(super) fn rows(&self) -> usize {
        self.pixels.len() / self.width
    }

    /// Each pixel the sum over the pixels of its row up to a filter's half width away; beyond the sides is what is
    /// at them. `add` adds a pixel with the filter's weights at its distance.
    pub(super) fn along_rows<const W: usize, const M: usize>(
        &self,
        filter: &[[f32; W]],
        add: impl Fn(&mut [f32; M], [f32; W], [f32; N]) + Sync,
    ) -> Result<Grid<M>, OutOfMemory> {
        let mut sums = room(self.pixels.len(), [0.0; M])?;
        let (width, half) = (self.width, filter.len() / 2);
        let rows = sums
            .par_chunks_mut(width)
            .zip(self.pixels.par_chunks(width));
        rows.for_each_init(
            || Vec::with_capacity(width + 2 * half),
            |padded, (sums, row)| {
                padded.clear();
                padded.extend(std::iter::repeat_n(row[0], half));
                padded.extend_from_slice(row);
                padded.extend(std::iter::repeat_n(row[width - 1], half));
                // Tap by tap, so that neighbors are computed side by side.
                for (tap, &weights) in filter.iter().enumerate() {
                    for (sum, &pixel) in sums.iter_mut().zip(&padded[tap..]) {
                        add(sum, weights, pixel);
                    }
                }
            },
        );
        Ok(Grid {
            width,
            pixels: sums,
        })
    }

    /// One row of the same along columns.
    pub(super) fn along_columns<const W: usize, const M: usize>(
        &self,
        y: usize,
        filter: &[[f32; W]],
        sums: &mut [[f32; M]],
        add: impl Fn(&mut [f32; M], [f32; W], [f32; N]),
    ) {
        let half = filter.len() / 2;
        sums.fill([0.0; M]);
        for (tap, &weights) in filter.iter().enumerate() {
            let from = (y + tap).saturating_sub(half).min(self.rows() - 1);
            let row = &self.pixels[from * self.width..][..self.width];
            for (sum, &pixel) in sums.iter_mut().zip(row) {
                add(sum, weights, pixel);
            }
        }
    }
}
