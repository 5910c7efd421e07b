//! Radiance to pixels: the film, how it is filled, and the EXR that it becomes.

mod bands;
mod batch;
pub mod exr;
mod layers;
mod passes;
mod render;
mod renderer;
mod sampling;
mod strips;
mod turns;

pub use layers::{BACKGROUND_DEPTH, BACKGROUND_LIGHT, Channel, ChannelKind, Channels, Layers};
pub use render::{Counts, MAX_SAMPLES, Options, SCREEN_WHITE, render};
pub use renderer::Renderer;
pub use strips::memory;

use std::ops::Range;

use crate::scene::ColorSpace;
use render::Tile;

/// A rectangle of pixels; (0, 0) is the top left of the whole image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Leftmost column.
    pub x: u32,
    /// Topmost row.
    pub y: u32,
    /// Columns. Range: at least 1.
    pub width: u32,
    /// Rows. Range: at least 1.
    pub height: u32,
}

/// A rendered image: linear radiance in cd/m², RGB premultiplied by coverage A, in f32.
#[derive(Clone, Debug)]
pub struct Film {
    frame: Frame,
    /// R, G, B, A, row by row from the top of the frame's window.
    pixels: Vec<[f32; 4]>,
    /// The values of the frame's channels, row by row, pixel by pixel, channel by channel within;
    /// empty where there are none.
    values: Vec<f32>,
}

/// All that a film is but for its pixels, and all that the head of its file is made of: known
/// before the first pixel is.
#[derive(Clone, Debug)]
struct Frame {
    /// Width and height of the whole image: the EXR's display window.
    resolution: [u32; 2],
    /// The part that is rendered: the EXR's data window, inside the whole image.
    window: Window,
    /// What there is beside R, G, B, A.
    channels: Channels,
    /// What the EXR header says about the image.
    metadata: Metadata,
}

/// Whole rows of a film.
#[derive(Clone, Copy, Debug)]
struct Rows<'f> {
    /// R, G, B, A, row by row.
    pixels: &'f [[f32; 4]],
    /// The values of further channels, row by row, pixel by pixel, channel by channel within.
    values: &'f [f32],
}

/// What the EXR header says about the image beside its windows and channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Metadata {
    /// The space of R, G, B: `colorInteropID`.
    pub color_space: ColorSpace,
    /// World to camera space, for column vectors (p' = M p, `[row][column]`); camera space is left-handed, +x right, +y up,
    /// +z along the view.
    pub world_to_camera: [[f64; 4]; 4],
    /// World to normalized device coordinates, for column vectors, before the division by w:
    /// (0, 0) top left of the display window, y down.
    pub world_to_ndc: [[f64; 4]; 4],
    /// `candela:KEY` = value, sorted by key.
    pub provenance: Vec<(String, String)>,
}

impl Window {
    /// All of an image.
    pub const fn whole([width, height]: [u32; 2]) -> Self {
        Self {
            x: 0,
            y: 0,
            width,
            height,
        }
    }

    /// How many pixels it has.
    pub const fn count(self) -> u64 {
        self.width as u64 * self.height as u64
    }

    /// Column and row of every pixel, row by row.
    pub fn pixels(self) -> impl Iterator<Item = [u32; 2]> {
        let columns = move || self.x..self.x + self.width;
        (self.y..self.y + self.height).flat_map(move |y| columns().map(move |x| [x, y]))
    }
}

impl Film {
    /// A film without light or coverage, and 0 in all further channels.
    fn black(frame: Frame) -> Self {
        let Window { width, height, .. } = frame.window;
        let count = width as usize * height as usize;
        Self {
            pixels: vec![[0.0; 4]; count],
            values: vec![0.0; count * frame.channels.list.len()],
            frame,
        }
    }

    /// The film in square tiles of `side` pixels, smaller at the right and bottom.
    fn tiles(&mut self, side: u32) -> Vec<Tile<'_>> {
        let Window {
            x,
            y,
            width,
            height,
        } = self.frame.window;
        let mut tiles = Vec::new();
        let channels = self.frame.channels.list.len();
        let (columns, side_length) = (width as usize, side as usize);
        // No chunk may be of length 0; of no values there are none all the same.
        let mut values = self.values.chunks_mut((columns * channels).max(1));
        let strips = self.pixels.chunks_mut(columns * side_length);
        for (strip, top) in strips.zip((0..height).step_by(side_length)) {
            let first = tiles.len();
            tiles.extend((0..width).step_by(side_length).map(|left| Tile {
                window: Window {
                    x: x + left,
                    y: y + top,
                    width: side.min(width - left),
                    height: side.min(height - top),
                },
                rows: Vec::with_capacity(side_length),
                values: Vec::new(),
            }));
            for row in strip.chunks_mut(columns) {
                for (tile, part) in tiles[first..].iter_mut().zip(row.chunks_mut(side_length)) {
                    tile.rows.push(part);
                }
                let row = values.next().unwrap_or_default();
                let parts = row.chunks_mut((side_length * channels).max(1));
                for (tile, part) in tiles[first..].iter_mut().zip(parts) {
                    tile.values.push(part);
                }
            }
        }
        tiles
    }

    /// A film from its pixels, row by row from the top of `window`.
    ///
    /// # Panics
    /// If the pixels are not as many as `window` holds, or `window` is not inside the image.
    pub fn new(
        resolution: [u32; 2],
        window: Window,
        pixels: Vec<[f32; 4]>,
        metadata: Metadata,
    ) -> Self {
        assert_eq!(pixels.len(), window.width as usize * window.height as usize);
        assert!(
            window.x + window.width <= resolution[0] && window.y + window.height <= resolution[1]
        );
        let frame = Frame {
            resolution,
            window,
            channels: Channels::default(),
            metadata,
        };
        Self {
            frame,
            pixels,
            values: Vec::new(),
        }
    }

    /// The film with these channels beside R, G, B, A instead of those that it had. Their values
    /// are row by row from the top of the window, pixel by pixel, channel by channel within.
    ///
    /// # Panics
    /// If the values are not as many as the pixels have channels.
    pub fn with_channels(self, channels: Channels, values: Vec<f32>) -> Self {
        assert_eq!(values.len(), self.pixels.len() * channels.list.len());
        let frame = Frame {
            channels,
            ..self.frame
        };
        Self {
            frame,
            values,
            ..self
        }
    }

    /// Width and height of the whole image, of which [`Film::window`] is a part.
    pub fn resolution(&self) -> [u32; 2] {
        self.frame.resolution
    }

    /// The part of the image that this film holds.
    pub fn window(&self) -> Window {
        self.frame.window
    }

    /// R, G, B, A of every pixel of the window, row by row from its top.
    pub fn pixels(&self) -> &[[f32; 4]] {
        &self.pixels
    }

    /// What the film has beside R, G, B, A.
    pub fn channels(&self) -> &Channels {
        &self.frame.channels
    }

    /// The values of [`Film::channels`] of a pixel, by its place in [`Film::pixels`].
    pub fn values(&self, pixel: usize) -> &[f32] {
        let count = self.frame.channels.list.len();
        &self.values[pixel * count..][..count]
    }

    /// What the EXR header says about the image.
    pub fn metadata(&self) -> &Metadata {
        &self.frame.metadata
    }

    /// Some of its rows, counted from the top of its window.
    fn rows(&self, rows: Range<usize>) -> Rows<'_> {
        let width = self.frame.window.width as usize;
        let channels = self.frame.channels.list.len();
        let pixels = rows.start * width..rows.end * width;
        let values = pixels.start * channels..pixels.end * channels;
        Rows {
            pixels: &self.pixels[pixels],
            values: &self.values[values],
        }
    }
}
