//! What an estimate of the error of a pixel is made from, beside its sums.

use std::ops::Range;

use super::batch::{NumberedSamples, PIXELS};
use super::sums::PixelSums;
use crate::visibility::{Column, Points};

/// The samples of a pixel are parted into so many runs of the sequence, one after the other.
pub(super) const QUARTERS: usize = 4;

/// Statistics of the samples of a tile's pixels, by the pixels' numbers.
///
/// Where there is a power of four of samples, each quarter of them, in the order of the sequence, is a scrambled net of
/// its own over the whole pixel: four means that tell how far the mean of all of them may be off.
pub(super) struct Statistics {
    quarters: [PixelSums; QUARTERS],
    /// Of R, G and B of all samples; infinite where there are none.
    least: [Column; 3],
    most: [Column; 3],
}

impl Default for Statistics {
    fn default() -> Self {
        Self {
            quarters: Default::default(),
            least: [Column::ZERO; 3],
            most: [Column::ZERO; 3],
        }
    }
}

impl Statistics {
    pub(super) fn clear(&mut self) {
        for quarter in &mut self.quarters {
            quarter.clear();
        }
        for column in &mut self.least {
            column.fill(f64::INFINITY);
        }
        for column in &mut self.most {
            column.fill(f64::NEG_INFINITY);
        }
    }

    /// Makes all samples that a pixel has had, with these sums, the first quarter; the next pass makes the others.
    pub(super) fn widen(&mut self, pixel: usize, radiance: [f64; 3], hits: u32) {
        let [first, others @ ..] = &mut self.quarters;
        first.set(pixel, radiance, hits);
        for quarter in others {
            quarter.set(pixel, [0.0; 3], 0);
        }
    }

    /// Adds the radiance of the points of a batch of a pass: the first pass, from sample 0 on, has four quarters,
    /// each one after it the last three.
    pub(super) fn add(
        &mut self,
        samples: NumberedSamples<'_>,
        pass: &Range<u32>,
        points: &Points,
        radiance: &[Column; 3],
    ) {
        let (start, count) = (pass.start as usize, pass.len());
        let first = usize::from(start > 0);
        let in_quarter = count.div_ceil(QUARTERS - first);
        for (slot, pixel) in samples.iter() {
            let of_slot = radiance.each_ref().map(|column| column[slot]);
            let quarter = first + (samples.number_in_pixel(slot) - start) / in_quarter;
            self.quarters[quarter].add_sample(pixel, of_slot, points.is_hit(slot));
            for (channel, value) in of_slot.into_iter().enumerate() {
                let (least, most) = (&mut self.least[channel], &mut self.most[channel]);
                least[pixel] = least[pixel].min(value);
                most[pixel] = most[pixel].max(value);
            }
        }
    }

    /// The sums of the quarters: R, G, B and hits.
    pub(super) fn quarters(&self, pixel: usize) -> [([f64; 3], u32); QUARTERS] {
        self.quarters
            .each_ref()
            .map(|quarter| (quarter.radiance(pixel), quarter.hits[pixel]))
    }

    /// The least R, G and B of any sample of a pixel.
    pub(super) fn least(&self, pixel: usize) -> [f64; 3] {
        self.least.each_ref().map(|column| column[pixel])
    }

    /// The largest R, G and B of any sample of a pixel.
    pub(super) fn most(&self, pixel: usize) -> [f64; 3] {
        self.most.each_ref().map(|column| column[pixel])
    }
}

/// A column has a place for each pixel of a tile.
const _: () = assert!(PIXELS <= crate::visibility::BATCH);
