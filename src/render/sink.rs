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
}

impl RenderedTile {
    /// Without pixels, for so many channels beside R, G, B, A.
    pub(super) fn new(channels: usize) -> Self {
        Self {
            window: Window::whole([0, 0]),
            pixels: Vec::new(),
            channels,
            values: Vec::new(),
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
