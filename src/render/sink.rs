//! Where rendered tiles go.

use std::ops::{ControlFlow, Range};

use super::sums::narrowed;
use crate::image::Window;

/// What takes rendered tiles: a film in memory, a file, a window on the screen.
pub trait Sink: Sync {
    /// Takes a tile, from any thread. Tiles are begun row by row from the top left, and each comes once;
    /// beside each thread's own none is out of this order. To break ends rendering, once the tiles are
    /// done that are under way.
    fn take(&self, tile: &RenderedTile) -> ControlFlow<()>;
}

/// A tile of an image: the means of its pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderedTile {
    window: Window,
    /// R, G, B, A, row by row.
    pixels: Vec<[f32; 4]>,
    /// How many channels there are beside these.
    channels: usize,
    /// Their values, channel by channel, row by row within.
    values: Vec<f32>,
    /// Which of the last of these channels are about errors.
    error_channels: ErrorChannels,
}

/// Which channels about errors there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct ErrorChannels {
    /// `error` and `error_kind`.
    pub(super) error: bool,
    /// `samples`.
    pub(super) samples: bool,
}

impl ErrorChannels {
    /// How many.
    pub(super) fn count(self) -> usize {
        2 * usize::from(self.error) + usize::from(self.samples)
    }
}

impl RenderedTile {
    /// Without pixels, for so many channels beside R, G, B, A.
    pub(super) fn new(channels: usize, error_channels: ErrorChannels) -> Self {
        Self {
            window: Window::whole([0, 0]),
            pixels: Vec::new(),
            channels,
            values: Vec::new(),
            error_channels,
        }
    }

    /// Makes room for the pixels of a window, all of which are then to be set.
    pub(super) fn begin(&mut self, window: Window) {
        let count = window.width as usize * window.height as usize;
        self.window = window;
        self.pixels.resize(count, [0.0; 4]);
        self.values.resize(count * self.channels, 0.0);
    }

    /// Its place in the image.
    pub fn window(&self) -> Window {
        self.window
    }

    /// R, G, B, A of its pixels, row by row from its top.
    pub fn pixels(&self) -> &[[f32; 4]] {
        &self.pixels
    }

    /// The values of further channels of its pixels, channel by channel, row by row within.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Sets the pixel at a column and row of the tile.
    #[inline(always)]
    pub(super) fn set(&mut self, [column, row]: [u32; 2], pixel: [f32; 4]) {
        self.pixels[(row * self.window.width + column) as usize] = pixel;
    }

    /// The values of some channels that follow each other, channel by channel, row by row within.
    pub(super) fn channels_mut(&mut self, channels: Range<usize>) -> &mut [f32] {
        let count = self.pixels.len();
        &mut self.values[channels.start * count..channels.end * count]
    }

    /// Sets channels of the pixel at a column and row of the tile to sums over so many samples; how many means are
    /// beyond the largest f32.
    pub(super) fn set_values(
        &mut self,
        [column, row]: [u32; 2],
        first: usize,
        sums: &[f64],
        samples: f64,
    ) -> u64 {
        let count = self.pixels.len();
        let pixel = (row * self.window.width + column) as usize;
        let mut clamped = 0;
        for (channel, sum) in (first..).zip(sums) {
            let (value, is_clamped) = narrowed(sum / samples);
            self.values[channel * count + pixel] = value;
            clamped += u64::from(is_clamped);
        }
        clamped
    }

    /// R, G, B, A of the pixel at a column and row of the tile.
    pub(super) fn pixel(&self, [column, row]: [u32; 2]) -> [f32; 4] {
        self.pixels[(row * self.window.width + column) as usize]
    }

    /// Whether anything is asked for of the errors or samples of pixels.
    pub(super) fn wants_errors(&self) -> bool {
        self.error_channels.count() > 0
    }

    /// Sets what is asked for of a pixel's error in cd/m², its kind and the samples taken.
    pub(super) fn set_error(
        &mut self,
        [column, row]: [u32; 2],
        error: f32,
        is_bound: bool,
        samples: u32,
    ) {
        let channels = self.error_channels;
        let first = self.channels - channels.count();
        let pixel = (row * self.window.width + column) as usize;
        let kind = if is_bound { 0.0 } else { 1.0 };
        let error = channels.error.then_some([error, kind]);
        let samples = channels.samples.then_some(samples as f32);
        let count = self.pixels.len();
        for (channel, value) in (first..).zip(error.into_iter().flatten().chain(samples)) {
            self.values[channel * count + pixel] = value;
        }
    }

    /// Sets the samples taken of all pixels, where that is asked for.
    pub(super) fn set_samples(&mut self, samples: u32) {
        if self.error_channels.samples {
            let last = self.channels - 1;
            self.channels_mut(last..last + 1).fill(samples as f32);
        }
    }

    /// Copies it to its place in whole rows of `window`, of which `pixels` and `values` have the first
    /// at `top`.
    pub(super) fn copy_to(
        &self,
        window: Window,
        top: u32,
        pixels: &mut [[f32; 4]],
        values: &mut [f32],
    ) {
        let [columns, width] = [self.window.width, window.width].map(|side| side as usize);
        let left = (self.window.x - window.x) as usize;
        let first = (self.window.y - top) as usize;
        for row in 0..self.window.height as usize {
            let (from, to) = (row * columns, (first + row) * width);
            pixels[to + left..][..columns].copy_from_slice(&self.pixels[from..][..columns]);
            let values = values[to * self.channels..].chunks_exact_mut(width);
            let of_tile = self.values.chunks_exact(self.pixels.len());
            for (values, of_tile) in values.zip(of_tile) {
                values[left..][..columns].copy_from_slice(&of_tile[from..][..columns]);
            }
        }
    }
}
