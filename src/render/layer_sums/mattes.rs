//! Cryptomatte: by how much each object, or material, covers each pixel.

use super::super::batch::{NumberedSamples, PIXELS, TilePixels};
use super::super::cryptomatte::Id;
use super::super::sink::RenderedTile;
use crate::simd::{LANES, ones};
use crate::visibility::Points;

/// What covers the pixels of a tile, and how many of their samples.
pub(super) struct Mattes {
    /// What stands for each name in the file.
    ids: Vec<f32>,
    ranks: usize,
    /// What the first sample of each pixel that hits anything hits, and how many others do.
    first: Box<[Covering; PIXELS]>,
    /// What else there is.
    others: Vec<Vec<Covering>>,
    /// Of one pixel, in order.
    sorted: Vec<Covering>,
}

/// Something that is met by some samples of a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Covering {
    what: u32,
    samples: u32,
}

impl Mattes {
    pub(super) fn new<'n>(names: impl Iterator<Item = &'n str>, ranks: usize) -> Self {
        Self {
            ids: names.map(|name| Id::of(name).value()).collect(),
            ranks,
            first: Box::new([Covering::default(); PIXELS]),
            others: vec![Vec::new(); PIXELS],
            sorted: Vec::new(),
        }
    }

    pub(super) fn clear(&mut self) {
        self.first.fill(Covering::default());
        for others in &mut self.others {
            others.clear();
        }
    }

    #[inline(always)]
    pub(super) fn add(
        &mut self,
        samples: NumberedSamples<'_>,
        points: &Points,
        what: impl Fn(usize) -> u32,
    ) {
        for (packet, &hit) in points.hit.iter().enumerate() {
            if hit == 0 {
                continue;
            }
            let first = packet * LANES;
            for (pixel, of_pixel) in samples.of_packet(first) {
                let mut rest = of_pixel & hit;
                // Mostly all samples of a pixel are of one thing.
                while rest != 0 {
                    let one = what(first + rest.trailing_zeros() as usize);
                    let same = ones(rest).filter(|&lane| what(first + lane) == one);
                    let same = same.fold(0, |bits, lane| bits | 1 << lane);
                    self.count(pixel, one, u32::count_ones(same));
                    rest &= !same;
                }
            }
        }
    }

    /// So many more samples of a pixel are of something.
    #[inline(always)]
    fn count(&mut self, pixel: usize, what: u32, samples: u32) {
        let first = &mut self.first[pixel];
        if first.samples == 0 || first.what == what {
            first.what = what;
            first.samples += samples;
        } else {
            add_other(&mut self.others[pixel], Covering { what, samples });
        }
    }

    /// Writes ids and coverages of those that cover most of each pixel.
    pub(super) fn write(
        &mut self,
        pixels: &TilePixels,
        taken: &[u32; PIXELS],
        channel: usize,
        rendered: &mut RenderedTile,
    ) {
        let channels = channel..channel + 2 * self.ranks;
        let count = pixels.iter().len();
        let values = rendered.channels_mut(channels);
        values.fill(0.0);
        let places = pixels.row_major().iter().map(|&place| place as usize);
        for ((pixel, place), first) in places.enumerate().zip(self.first.iter()) {
            if first.samples == 0 {
                continue;
            }
            let coverage = |samples: u32| samples as f32 / taken[pixel] as f32;
            let others = &self.others[pixel];
            if others.is_empty() {
                values[place] = self.ids[first.what as usize];
                values[count + place] = coverage(first.samples);
                continue;
            }
            self.sorted.clear();
            self.sorted.push(*first);
            self.sorted.extend(others);
            // Of equals the first in the file.
            self.sorted
                .sort_unstable_by_key(|covering| (u32::MAX - covering.samples, covering.what));
            for (rank, covering) in self.sorted.iter().take(self.ranks).enumerate() {
                values[2 * rank * count + place] = self.ids[covering.what as usize];
                values[(2 * rank + 1) * count + place] = coverage(covering.samples);
            }
        }
    }
}

#[inline(never)]
fn add_other(others: &mut Vec<Covering>, more: Covering) {
    match others.iter_mut().find(|other| other.what == more.what) {
        Some(other) => other.samples += more.samples,
        None => others.push(more),
    }
}
