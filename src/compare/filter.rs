//! Filters along rows and columns, as ꟻLIP needs them.

use rayon::prelude::*;

use super::room;
use crate::memory::OutOfMemory;

/// An image of N numbers a pixel, each in a plane of its own, row by row.
pub(super) struct Planes<const N: usize> {
    pub(super) width: usize,
    pub(super) planes: [Vec<f32>; N],
}

/// Which plane is filtered, and the weights from left to right or from top to bottom; the middle one is the pixel's
/// own.
pub(super) type Filter<'f> = (usize, &'f [f32]);

impl<const N: usize> Planes<N> {
    /// Black.
    ///
    /// # Errors
    /// If there is not so much memory.
    pub(super) fn new(width: usize, count: usize) -> Result<Self, OutOfMemory> {
        let mut planes = [const { Vec::new() }; N];
        for plane in &mut planes {
            *plane = room(count, 0.0)?;
        }
        Ok(Self { width, planes })
    }

    /// A plane for each filter, of sums along rows; beyond the sides is what is at them.
    ///
    /// # Errors
    /// If there is not so much memory.
    pub(super) fn along_rows<const M: usize>(
        &self,
        filters: [Filter<'_>; M],
    ) -> Result<Planes<M>, OutOfMemory> {
        let width = self.width;
        let mut filtered = Planes::new(width, self.planes.first().map_or(0, Vec::len))?;
        for (sums, (source, weights)) in filtered.planes.iter_mut().zip(filters) {
            let half = weights.len() / 2;
            let rows = sums
                .par_chunks_mut(width)
                .zip(self.planes[source].par_chunks(width));
            rows.for_each_init(
                || Vec::with_capacity(width + 2 * half),
                |padded, (sums, row)| {
                    padded.clear();
                    padded.extend(std::iter::repeat_n(row[0], half));
                    padded.extend_from_slice(row);
                    padded.extend(std::iter::repeat_n(row[width - 1], half));
                    for (tap, &weight) in weights.iter().enumerate() {
                        add(sums, weight, &padded[tap..tap + width]);
                    }
                },
            );
        }
        Ok(filtered)
    }

    /// A row of the same along columns.
    pub(super) fn along_columns<const M: usize>(
        &self,
        y: usize,
        filters: [Filter<'_>; M],
        sums: &mut [Vec<f32>; M],
    ) {
        for (sums, (source, weights)) in sums.iter_mut().zip(filters) {
            let plane = &self.planes[source];
            let (last, half) = (plane.len() / self.width - 1, weights.len() / 2);
            sums.fill(0.0);
            for (tap, &weight) in weights.iter().enumerate() {
                let from = (y + tap).saturating_sub(half).min(last);
                add(sums, weight, &plane[from * self.width..][..self.width]);
            }
        }
    }
}

/// Adds a weighted row, many pixels side by side.
fn add(sums: &mut [f32], weight: f32, row: &[f32]) {
    for (sum, value) in sums.iter_mut().zip(row) {
        *sum += weight * value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sides_are_repeated() {
        let image = Planes {
            width: 3,
            planes: [vec![1.0, 2.0, 4.0, 8.0, 16.0, 32.0]],
        };
        let weights = [100.0, 10.0, 1.0];
        let rows = image.along_rows([(0, &weights)]);
        let rows = rows.unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(rows.planes[0], [112.0, 124.0, 244.0, 896.0, 992.0, 1952.0]);
        let mut sums = [vec![0.0; 3]];
        image.along_columns(0, [(0, &weights)], &mut sums);
        assert_eq!(sums[0], [118.0, 236.0, 472.0]);
        image.along_columns(1, [(0, &weights)], &mut sums);
        assert_eq!(sums[0], [188.0, 376.0, 752.0]);
    }
}
