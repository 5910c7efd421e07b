//! The samples of a tile's pixels, batch by batch, and where in the image they are.

use std::ops::Range;

use fearless_simd::Simd;

use super::sampling::{Pattern, Sampler};
use crate::camera::{Camera, Projection};
use crate::image::Window;
use crate::math::DVec3;
use crate::simd::{DVec3x16, F64x16, LANES, U32x16};
use crate::visibility::{BATCH, Column, RayBatch};

/// Pixels along the side of a tile: its rays are alike enough to be traced as one batch.
pub(super) const TILE: u32 = 16;

/// Pixels of a tile.
pub(super) const PIXELS: usize = (TILE * TILE) as usize;

/// A number for each pixel of a tile.
type PerPixel = [u32; PIXELS];

/// A number for each sample of a batch.
type PerSample = [u32; BATCH];

/// A column has a place for each pixel of a tile.
const _: () = assert!(PIXELS <= BATCH);

/// The pixels of a tile in the order in which they are sampled, which keeps neighbors together: the
/// rays of a batch, and any few of them in a row, are as alike as they can be. A pixel's place in this
/// order is its number.
#[derive(Clone, Debug)]
pub(super) struct TilePixels {
    window: Window,
    count: usize,
    /// Column and row of each in the tile.
    in_tile: [PerPixel; 2],
    /// The place of each, counted row by row.
    row_major: PerPixel,
}

impl Default for TilePixels {
    fn default() -> Self {
        Self {
            window: Window::whole([0, 0]),
            count: 0,
            in_tile: [[0; PIXELS]; 2],
            row_major: [0; PIXELS],
        }
    }
}

impl TilePixels {
    /// Takes the pixels of a tile.
    pub(super) fn begin(&mut self, window: Window) {
        let size = |window: Window| [window.width, window.height];
        let is_as_before = size(self.window) == size(window);
        self.window = window;
        if is_as_before {
            return;
        }
        self.count = 0;
        for &[column, row] in &Z_ORDER {
            if column < window.width && row < window.height {
                self.in_tile[0][self.count] = column;
                self.in_tile[1][self.count] = row;
                self.row_major[self.count] = row * window.width + column;
                self.count += 1;
            }
        }
    }

    /// The place of each in the tile, counted row by row.
    pub(super) fn row_major(&self) -> &[u32] {
        &self.row_major[..self.count]
    }

    /// The tile's place in the image.
    pub(super) fn window(&self) -> Window {
        self.window
    }

    /// Column and row in the tile of each.
    pub(super) fn iter(&self) -> impl ExactSizeIterator<Item = [u32; 2]> {
        let [columns, rows] = &self.in_tile;
        (0..self.count).map(|pixel| [columns[pixel], rows[pixel]])
    }
}

/// Some pixels of a tile, by their numbers in [`TilePixels`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Selection([u64; PIXELS / 64]);

impl Selection {
    /// All.
    pub(super) const ALL: Self = Self([u64::MAX; PIXELS / 64]);

    /// None.
    pub(super) const NONE: Self = Self([0; PIXELS / 64]);

    /// Adds a pixel.
    pub(super) fn insert(&mut self, pixel: usize) {
        self.0[pixel / 64] |= 1 << (pixel % 64);
    }

    /// Takes a pixel out.
    pub(super) fn remove(&mut self, pixel: usize) {
        self.0[pixel / 64] &= !(1 << (pixel % 64));
    }

    /// Their numbers.
    pub(super) fn iter(self) -> impl Iterator<Item = usize> {
        (0..PIXELS).filter(move |&pixel| self.contains(pixel))
    }

    /// Whether a pixel is among them.
    pub(super) fn contains(self, pixel: usize) -> bool {
        self.0[pixel / 64] >> (pixel % 64) & 1 == 1
    }
}

impl FromIterator<usize> for Selection {
    fn from_iter<I: IntoIterator<Item = usize>>(pixels: I) -> Self {
        let mut selection = Self::NONE;
        for pixel in pixels {
            selection.insert(pixel);
        }
        selection
    }
}

/// The pixels of a pass, in the order of the tile.
#[derive(Clone, Debug)]
struct PassPixels {
    selection: Selection,
    count: usize,
    /// The number of each in the tile.
    numbers: PerPixel,
    /// Column and row of each in the tile, where they are not all of its pixels.
    in_tile: [PerPixel; 2],
    /// Column and row of each in the image.
    in_image: [PerPixel; 2],
    /// What scrambles the samples of each.
    seeds: [PerPixel; 2],
}

impl PassPixels {
    /// Takes the numbers of the pixels that are selected, and where they are not all, their columns and
    /// rows in the tile.
    fn take(&mut self, tile: &TilePixels, selection: &Selection) {
        if *selection == Selection::ALL {
            // Most passes are over all pixels of whole tiles.
            if (self.selection, self.count) != (Selection::ALL, tile.count) {
                for (number, pixel) in self.numbers.iter_mut().zip(0..tile.count as u32) {
                    *number = pixel;
                }
            }
            self.count = tile.count;
        } else {
            self.count = 0;
            for pixel in (0..tile.count).filter(|&pixel| selection.contains(pixel)) {
                self.numbers[self.count] = pixel as u32;
                self.in_tile[0][self.count] = tile.in_tile[0][pixel];
                self.in_tile[1][self.count] = tile.in_tile[1][pixel];
                self.count += 1;
            }
        }
        self.selection = *selection;
    }
}

/// Samples that are traced and shaded together, those of pixel after pixel.
#[derive(Clone, Debug)]
pub(super) struct Batch {
    pixels: PassPixels,
    pattern: Pattern,
    spacing: [f64; 2],
    /// The first sample of each pixel, and how many there are.
    start: usize,
    samples: usize,
    /// The first sample of the batch, counted through the pass.
    first: usize,
    len: usize,
    /// The number in its pixel of the first sample of `sequence`, which is the same in most batches.
    phase: Option<usize>,
    /// What is scrambled.
    sequence: [PerSample; 2],
    /// What scrambles it, and the place in the image of each sample's pixel.
    seeds: [PerSample; 2],
    corners: [PerSample; 2],
    /// Each sample's place in the image.
    positions: [Column; 2],
}

impl Default for Batch {
    fn default() -> Self {
        Self {
            pixels: PassPixels {
                selection: Selection::ALL,
                count: 0,
                numbers: [0; PIXELS],
                in_tile: [[0; PIXELS]; 2],
                in_image: [[0; PIXELS]; 2],
                seeds: [[0; PIXELS]; 2],
            },
            pattern: Pattern::Grid(1),
            spacing: [1.0; 2],
            start: 0,
            samples: 1,
            first: 0,
            len: 0,
            phase: None,
            sequence: [[0; BATCH]; 2],
            seeds: [[0; BATCH]; 2],
            corners: [[0; BATCH]; 2],
            positions: [Column::ZERO; 2],
        }
    }
}

impl Batch {
    /// Begins a pass: these samples of some pixels of a tile. Samples of one pixel follow each other.
    #[inline(always)]
    pub(super) fn begin<S: Simd>(
        &mut self,
        simd: S,
        sampler: &Sampler,
        tile: &TilePixels,
        selection: &Selection,
        samples: Range<u32>,
    ) {
        let (start, samples) = (samples.start as usize, samples.len());
        let pattern = sampler.pattern();
        if (self.pattern, self.start, self.samples) != (pattern, start, samples) {
            (self.pattern, self.phase) = (pattern, None);
            (self.start, self.samples) = (start, samples);
        }
        self.spacing = sampler.spacing();
        (self.first, self.len) = (0, 0);
        let pixels = &mut self.pixels;
        pixels.take(tile, selection);
        let corner = [tile.window.x, tile.window.y].map(|corner| U32x16::splat(simd, corner));
        for first in (0..pixels.count).step_by(LANES) {
            let [columns, rows] = if *selection == Selection::ALL {
                &tile.in_tile
            } else {
                &pixels.in_tile
            };
            let column = U32x16::load(simd, &columns[first..]) + corner[0];
            let row = U32x16::load(simd, &rows[first..]) + corner[1];
            column.store(&mut pixels.in_image[0][first..]);
            row.store(&mut pixels.in_image[1][first..]);
            let [seeds_x, seeds_y] = sampler.seeds(simd, [column, row]);
            seeds_x.store(&mut pixels.seeds[0][first..]);
            seeds_y.store(&mut pixels.seeds[1][first..]);
        }
    }

    /// Takes the next samples of the tile; whether there are any.
    #[inline(always)]
    pub(super) fn next<S: Simd>(&mut self, simd: S, sampler: &Sampler) -> bool {
        self.first += self.len;
        let left = self.pixels.count * self.samples - self.first;
        self.len = left.min(BATCH);
        if left == 0 {
            return false;
        }
        let phase = self.first % self.samples;
        if self.phase != Some(phase) {
            self.phase = Some(phase);
            let [first, second] = &mut self.sequence;
            let samples = self.start..self.start + self.samples;
            for (slot, sample) in (0..BATCH).zip(samples.cycle().skip(phase)) {
                [first[slot], second[slot]] = sampler.sequence(sample);
            }
        }
        let range = self.range();
        for dimension in 0..2 {
            let pixels = &self.pixels;
            range.spread(
                simd,
                &pixels.in_image[dimension],
                &mut self.corners[dimension],
            );
            range.spread(simd, &pixels.seeds[dimension], &mut self.seeds[dimension]);
            for first in (0..self.len).step_by(LANES) {
                let sequence = &self.sequence[dimension][first..];
                let seeds = &self.seeds[dimension][first..];
                let corner = U32x16::load(simd, &self.corners[dimension][first..]);
                let place = corner.widened(simd) + sampler.offsets(simd, sequence, seeds);
                let place = place * self.spacing[dimension];
                place.store(&mut self.positions[dimension][first..]);
            }
        }
        true
    }

    /// How many samples it has.
    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// L1: the primary rays of a camera through the samples.
    #[inline(always)]
    pub(super) fn rays<S: Simd>(
        &self,
        simd: S,
        camera: &Camera,
    ) -> RayBatch<'_, impl Fn(usize) -> DVec3x16<S>> {
        let [x, y] = &self.positions;
        self.sharing(
            camera,
            #[inline(always)]
            move |packet| {
                let first = packet * LANES;
                let x = F64x16::load(simd, &x[first..]);
                camera.varying(simd, x, F64x16::load(simd, &y[first..]))
            },
        )
    }

    /// The primary rays of a camera, of which `varying` is what differs.
    #[inline(always)]
    fn sharing<F>(&self, camera: &Camera, varying: F) -> RayBatch<'_, F> {
        let count = self.len;
        match camera.projection() {
            Projection::Perspective { .. } => RayBatch::FromPoint {
                origin: camera.eye(),
                direction: varying,
                count,
                around: Some(self.corners(camera)),
            },
            Projection::Orthographic { .. } => RayBatch::Along {
                direction: camera.forward().get(),
                origin: varying,
                count,
            },
        }
    }

    /// The directions of the primary rays around all samples.
    #[inline(always)]
    fn corners(&self, camera: &Camera) -> [DVec3; 4] {
        let pixels = self.range().pixel(0)..=self.range().last_pixel();
        let [x, y] = &self.pixels.in_image;
        let [across, down] = self.spacing;
        let [left, right] = around(&x[pixels.clone()]).map(|place| place * across);
        let [top, bottom] = around(&y[pixels]).map(|place| place * down);
        [
            camera.ray(left, top).direction,
            camera.ray(right, top).direction,
            camera.ray(left, bottom).direction,
            camera.ray(right, bottom).direction,
        ]
    }

    /// The samples, counted through the pass.
    pub(super) fn range(&self) -> SampleRange {
        SampleRange {
            samples: self.samples,
            first: self.first,
            len: self.len,
        }
    }

    /// The numbers in the tile of the pixels of the pass.
    pub(super) fn numbers(&self) -> &[u32] {
        &self.pixels.numbers[..self.pixels.count]
    }

    /// Whether the pass is over all pixels of the tile.
    pub(super) fn is_over_all(&self) -> bool {
        self.pixels.selection == Selection::ALL
    }

    /// The samples with the numbers of their pixels.
    pub(super) fn numbered(&self) -> NumberedSamples<'_> {
        NumberedSamples {
            range: self.range(),
            start: self.start,
            numbers: &self.pixels.numbers,
            is_over_all: self.is_over_all(),
        }
    }
}

/// Some samples of a pass, counted pixel by pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampleRange {
    /// Samples of a pixel.
    samples: usize,
    first: usize,
    len: usize,
}

/// Samples of one pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Run {
    /// The pixel, by its place among those of the pass.
    pub(super) pixel: usize,
    /// Their places in the batch.
    pub(super) slots: Range<usize>,
}

impl SampleRange {
    /// The samples of pixel after pixel.
    #[inline(always)]
    pub(super) fn runs(self) -> impl Iterator<Item = Run> {
        let (mut pixel, mut start) = (self.pixel(0), 0);
        // Of the first pixel some samples may have been in the batch before.
        let mut left = (pixel + 1) * self.samples - self.first;
        std::iter::from_fn(move || {
            let end = (start + left).min(self.len);
            (start < end).then(|| {
                let run = Run {
                    pixel,
                    slots: start..end,
                };
                (pixel, start, left) = (pixel + 1, end, self.samples);
                run
            })
        })
    }

    /// The pixel of the sample in a slot, by its place among those of the pass.
    pub(super) fn pixel(self, slot: usize) -> usize {
        (self.first + slot) / self.samples
    }

    /// The pixel of the last sample.
    pub(super) fn last_pixel(self) -> usize {
        self.pixel(self.len - 1)
    }

    /// The slot after the last sample of a pixel that has samples in the batch.
    fn end(self, pixel: usize) -> usize {
        ((pixel + 1) * self.samples - self.first).min(self.len)
    }

    /// Samples of a pixel, and the pixels, where no pixel has samples in another batch.
    #[inline(always)]
    pub(super) fn whole_pixels(self) -> Option<(usize, Range<usize>)> {
        BATCH.is_multiple_of(self.samples).then(|| {
            let first = self.first / self.samples;
            (self.samples, first..first + self.len / self.samples)
        })
    }

    /// Gives each sample the number of its pixel.
    #[inline(always)]
    fn spread<S: Simd>(self, simd: S, numbers: &PerPixel, column: &mut PerSample) {
        match self.whole_pixels() {
            Some((1, pixels)) => spread_over::<1>(&numbers[pixels], column),
            Some((2, pixels)) => spread_over::<2>(&numbers[pixels], column),
            Some((4, pixels)) => spread_over::<4>(&numbers[pixels], column),
            Some((8, pixels)) => spread_over::<8>(&numbers[pixels], column),
            Some((LANES, pixels)) => {
                for (place, &number) in numbers[pixels].iter().enumerate() {
                    U32x16::splat(simd, number).store(&mut column[place * LANES..]);
                }
            }
            _ => {
                for Run { pixel, slots } in self.runs() {
                    column[slots].fill(numbers[pixel]);
                }
            }
        }
    }
}

/// The samples of a batch with the numbers of their pixels in the tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct NumberedSamples<'b> {
    range: SampleRange,
    /// The first sample of each pixel.
    start: usize,
    numbers: &'b PerPixel,
    is_over_all: bool,
}

impl NumberedSamples<'_> {
    /// Samples of a pixel, and the numbers of the pixels, where these follow each other and have no samples in another
    /// batch.
    #[inline(always)]
    pub(super) fn whole_pixels(self) -> Option<(usize, Range<usize>)> {
        self.range.whole_pixels().filter(|_| self.is_over_all)
    }

    /// The samples of pixel after pixel, by their numbers.
    pub(super) fn runs(self) -> impl Iterator<Item = Run> {
        self.range.runs().map(move |Run { pixel, slots }| Run {
            pixel: self.numbers[pixel] as usize,
            slots,
        })
    }

    /// The slot of each sample and its pixel.
    pub(super) fn iter(self) -> impl Iterator<Item = (usize, usize)> {
        (0..self.range.len).map(move |slot| (slot, self.pixel(slot)))
    }

    /// The number of the sample in a slot among those of its pixel.
    pub(super) fn number_in_pixel(self, slot: usize) -> usize {
        self.start + (self.range.first + slot) % self.range.samples
    }

    /// The samples of a packet that starts in a slot, pixel by pixel: one bit for each.
    pub(super) fn of_packet(self, first: usize) -> impl Iterator<Item = (usize, u32)> {
        let end = self.range.len.min(first + LANES);
        let mut start = first;
        std::iter::from_fn(move || {
            if start >= end {
                return None;
            }
            let pixel = self.range.pixel(start);
            let of_pixel = start..self.range.end(pixel).min(end);
            start = of_pixel.end;
            let after = |slot: usize| u32::MAX.checked_shl((slot - first) as u32).unwrap_or(0);
            let bits = after(of_pixel.start) & !after(of_pixel.end);
            Some((self.numbers[pixel] as usize, bits))
        })
    }

    /// The pixel of the sample in a slot.
    fn pixel(self, slot: usize) -> usize {
        self.numbers[self.range.pixel(slot)] as usize
    }

    /// The pixel of the last sample of the batch.
    pub(super) fn last_pixel(self) -> usize {
        self.pixel(self.range.len - 1)
    }
}

/// The least and the largest place in the image that pixels with these columns, or rows, cover.
#[inline(always)]
fn around(numbers: &[u32]) -> [f64; 2] {
    let (mut least, mut most) = (u32::MAX, 0);
    for &number in numbers {
        least = least.min(number);
        most = most.max(number);
    }
    [f64::from(least), f64::from(most) + 1.0]
}

/// Gives each of N samples the number of its pixel.
#[inline(always)]
fn spread_over<const N: usize>(numbers: &[u32], column: &mut PerSample) {
    let (samples, _) = column.as_chunks_mut::<N>();
    for (samples, &number) in samples.iter_mut().zip(numbers) {
        *samples = [number; N];
    }
}

/// Column and row of the pixels of a tile along a Z-order curve: the even and the odd bits of the
/// number. Four in a row are a square, and so are four of these.
const Z_ORDER: [[u32; 2]; PIXELS] = {
    let mut order = [[0; 2]; PIXELS];
    let mut n = 0;
    while n < order.len() {
        let mut bit = 0;
        while 1 << (2 * bit) < order.len() {
            order[n][0] |= ((n >> (2 * bit) & 1) << bit) as u32;
            order[n][1] |= ((n >> (2 * bit + 1) & 1) << bit) as u32;
            bit += 1;
        }
        n += 1;
    }
    order
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Kernel, SimdLevel};

    struct Spread<'n>(SampleRange, &'n PerPixel);

    impl Kernel for Spread<'_> {
        type Output = PerSample;

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> PerSample {
            let Self(range, numbers) = self;
            let mut column = [0; BATCH];
            range.spread(simd, numbers, &mut column);
            column
        }
    }

    #[test]
    fn every_sample_has_its_pixel() {
        for samples in [1, 2, 3, 4, 16, 100, 256, 300, 1024] {
            let numbers = std::array::from_fn(|pixel| 7 * pixel as u32);
            for first in (0..3 * samples + 512).step_by(BATCH) {
                let range = SampleRange {
                    samples,
                    first,
                    len: BATCH,
                };
                if range.last_pixel() >= PIXELS {
                    continue;
                }
                let column = SimdLevel::default().run(Spread(range, &numbers));
                let expected = |slot: usize| (first + slot) / samples;
                for (slot, &spread) in column.iter().enumerate() {
                    assert_eq!(range.pixel(slot), expected(slot));
                    assert_eq!(
                        spread,
                        7 * expected(slot) as u32,
                        "{samples} {first} {slot}"
                    );
                }
                let runs: Vec<Run> = range.runs().collect();
                assert_eq!(runs.iter().map(|run| run.slots.len()).sum::<usize>(), BATCH);
                for Run { pixel, slots } in runs {
                    assert!(slots.clone().all(|slot| expected(slot) == pixel));
                    assert!(!slots.is_empty());
                }
            }
        }
    }

    #[test]
    fn four_pixels_in_a_row_are_a_square() {
        for four in Z_ORDER.chunks(4) {
            let [x, y] = four[0];
            assert_eq!(four, [[x, y], [x + 1, y], [x, y + 1], [x + 1, y + 1]]);
        }
        let mut all = Z_ORDER;
        all.sort_unstable();
        assert!(all.iter().zip(0..).all(|(&[x, y], n)| x * TILE + y == n));
    }
}
