//! How to render.

use super::layers::Layers;
use crate::image::Window;
use crate::simd::SimdLevel;

/// The most samples of a pixel.
pub const MAX_SAMPLES: u32 = 65_536;

/// How to render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Samples of each pixel. 1 samples pixel centers and nothing else; more are a fixed pattern
    /// that differs from pixel to pixel. Range: 1 to [`MAX_SAMPLES`]. Default 1.
    pub samples: u32,
    /// The part of the image to render; `None` is all of it.
    pub window: Option<Window>,
    /// What is made beside R, G, B and A. Default: nothing.
    pub layers: Layers,
    /// The instructions to render with, which make no difference to the image. Default: the widest
    /// that the machine has.
    pub simd: SimdLevel,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            samples: 1,
            window: None,
            layers: Layers::default(),
            simd: SimdLevel::default(),
        }
    }
}
