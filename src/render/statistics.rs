//! What an estimate of the error of a pixel is made from, beside its sums.

use super::bands::Further;
use super::batch::{NumberedSamples, SUBSETS};
use super::layer_sums::{LayerSums, RequestedLayers};
use super::sums::PixelSums;
use crate::shading::Terms;
use crate::visibility::{Column, Points};

/// Statistics of the samples of a tile's pixels, by the pixels' numbers.
///
/// Samples are parted by their number in their pixel modulo four. Each subset is a scrambled net of its
/// own where there is a power of two of samples, so that four means of a pixel by a quarter of its samples
/// tell how far the mean of all of them may be off.
pub(super) struct Statistics<'w> {
    subsets: [Subset<'w>; SUBSETS],
    /// Of R, G and B of all samples; infinite where there are none.
    least: [Column; 3],
    most: [Column; 3],
}

/// The sums of a quarter of the samples.
pub(super) struct Subset<'w> {
    /// R, G, B, and hits.
    pub(super) pixels: PixelSums,
    /// The accumulators of the layers that are asked for.
    pub(super) layers: Option<LayerSums<'w>>,
}

impl<'w> Statistics<'w> {
    /// For so many pixels.
    pub(super) fn new(layers: Option<RequestedLayers<'w>>, pixels: usize) -> Self {
        let bound = |bound| {
            let mut column = Column::ZERO;
            column.fill(bound);
            column
        };
        Self {
            subsets: std::array::from_fn(|_| Subset {
                pixels: PixelSums::default(),
                layers: layers.map(|layers| layers.sums(pixels)),
            }),
            least: std::array::from_fn(|_| bound(f64::INFINITY)),
            most: std::array::from_fn(|_| bound(f64::NEG_INFINITY)),
        }
    }

    /// Adds what the points of a batch are by themselves.
    pub(super) fn see(&mut self, samples: NumberedSamples<'_>, points: &Points) {
        for (number, subset) in self.subsets.iter_mut().enumerate() {
            if let Some(layers) = &mut subset.layers {
                layers.see(samples.subset(number), points);
            }
        }
    }

    /// Adds the terms of the points of a packet.
    pub(super) fn add_terms(&mut self, samples: NumberedSamples<'_>, terms: &Terms<'_>) {
        for (number, subset) in self.subsets.iter_mut().enumerate() {
            if let Some(layers) = &mut subset.layers {
                layers.add(samples.subset(number), terms);
            }
        }
    }

    /// Adds the radiance of the points of a batch.
    pub(super) fn add(
        &mut self,
        samples: NumberedSamples<'_>,
        points: &Points,
        radiance: &[Column; 3],
    ) {
        let of_slot = |slot: usize| radiance.each_ref().map(|column| column[slot]);
        for (number, subset) in self.subsets.iter_mut().enumerate() {
            for (slot, pixel) in samples.subset(number).iter() {
                let (radiance, is_hit) = (of_slot(slot), points.is_hit(slot));
                subset.pixels.add_sample(pixel, radiance, is_hit);
                for (channel, value) in radiance.into_iter().enumerate() {
                    let (least, most) = (&mut self.least[channel], &mut self.most[channel]);
                    least[pixel] = least[pixel].min(value);
                    most[pixel] = most[pixel].max(value);
                }
            }
        }
    }

    /// Ends a pass for the pixels before `end`.
    pub(super) fn finish(&mut self, end: usize, further: Further) {
        for layers in self
            .subsets
            .iter_mut()
            .filter_map(|subset| subset.layers.as_mut())
        {
            layers.finish(end, further);
        }
    }
}

#[cfg_attr(
    not(test),
    expect(
        dead_code,
        reason = "for estimates of the error, which are still to come"
    )
)]
impl<'w> Statistics<'w> {
    /// The sums of the samples whose number in their pixel is 0, 1, 2 and 3 modulo four.
    pub(super) fn subsets(&mut self) -> &mut [Subset<'w>; SUBSETS] {
        &mut self.subsets
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
