//! Where rendered tiles go.

use std::ops::ControlFlow;

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
    /// Their values, row by row, pixel by pixel, channel by channel within.
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

    /// The values of further channels of its pixels, row by row, pixel by pixel, channel by channel within.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Sets the pixel at a column and row of the tile.
    #[inline(always)]
    pub(super) fn set(&mut self, [column, row]: [u32; 2], pixel: [f32; 4]) {
        self.pixels[(row * self.window.width + column) as usize] = pixel;
    }

    /// The values of the pixel at a column and row of the tile.
    pub(super) fn values_mut(&mut self, [column, row]: [u32; 2]) -> &mut [f32] {
        let pixel = (row * self.window.width + column) as usize;
        &mut self.values[pixel * self.channels..][..self.channels]
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
    pub(super) fn set_error(&mut self, place: [u32; 2], error: f32, is_bound: bool, samples: u32) {
        let channels = self.error_channels;
        let first = self.channels - channels.count();
        let mut values = self.values_mut(place)[first..].iter_mut();
        let kind = if is_bound { 0.0 } else { 1.0 };
        let error = channels.error.then_some([error, kind]);
        let samples = channels.samples.then_some(samples as f32);
        for value in error.into_iter().flatten().chain(samples) {
            if let Some(place) = values.next() {
                *place = value;
            }
        }
    }

    /// Sets the samples taken of all pixels, where that is asked for.
    pub(super) fn set_samples(&mut self, samples: u32) {
        if self.error_channels.samples {
            for values in self.values.chunks_exact_mut(self.channels) {
                if let Some(last) = values.last_mut() {
                    *last = samples as f32;
                }
            }
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
        let (columns, channels) = (self.window.width as usize, self.channels);
        let left = (self.window.x - window.x) as usize;
        let first = (self.window.y - top) as usize;
        for row in 0..self.window.height as usize {
            let (from, to) = (row * columns, (first + row) * window.width as usize + left);
            pixels[to..][..columns].copy_from_slice(&self.pixels[from..][..columns]);
            values[to * channels..][..columns * channels]
                .copy_from_slice(&self.values[from * channels..][..columns * channels]);
        }
    }
}
