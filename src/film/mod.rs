//! Radiance to pixels: the film, how it is filled, and the EXR that it becomes.

pub mod exr;

use crate::scene::ColorSpace;

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
    /// Width and height of the whole image: the EXR's display window.
    resolution: [u32; 2],
    /// The part that is rendered: the EXR's data window, inside the whole image.
    window: Window,
    /// R, G, B, A, row by row from the top of `window`.
    pixels: Vec<[f32; 4]>,
    /// What the EXR header says about the image.
    metadata: Metadata,
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

impl Film {
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
        Self {
            resolution,
            window,
            pixels,
            metadata,
        }
    }

    /// Width and height of the whole image, of which [`Film::window`] is a part.
    pub fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    /// The part of the image that this film holds.
    pub fn window(&self) -> Window {
        self.window
    }

    /// R, G, B, A of every pixel of the window, row by row from its top.
    pub fn pixels(&self) -> &[[f32; 4]] {
        &self.pixels
    }

    /// What the EXR header says about the image.
    pub fn metadata(&self) -> &Metadata {
        &self.metadata
    }
}
