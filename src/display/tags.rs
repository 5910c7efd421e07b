//! What a file says about the samples in it, whatever its format.

use super::{Bits, Screen};
use crate::color::Primaries;

/// What a picture says about its samples, and where it comes from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tags {
    /// The screen for which the code values are.
    pub screen: Screen,
    /// Keys and texts. A PNG's keys have 1 to 79 characters of Latin-1.
    pub text: Vec<(String, String)>,
    /// The brightest that is shown.
    pub content_light: Option<ContentLight>,
    /// The display that the picture was made for.
    pub mastering: Option<Mastering>,
}

/// How bright a picture is, in cd/m² (CTA-861.3-A, annex A). Range: 0 to 429 496.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContentLight {
    /// MaxCLL: the brightest channel of a pixel.
    pub brightest: f64,
    /// MaxFALL: the mean over the picture of each pixel's brightest channel.
    pub average: f64,
}

/// The display that a picture was made for (SMPTE ST 2086:2018).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mastering {
    /// Its primaries and white. Range: 0 to 1.31.
    pub primaries: Primaries,
    /// Its least and greatest luminance in cd/m². Range: 0 to 429 496.
    pub luminance: [f64; 2],
}

/// The size and kind of a file's samples.
#[derive(Clone, Copy)]
pub(super) struct Shape {
    pub(super) resolution: [u32; 2],
    pub(super) has_alpha: bool,
    pub(super) bits: Bits,
    /// How much wider than high a pixel is.
    pub(super) pixel_aspect: f32,
}

impl Shape {
    /// Samples of a pixel.
    pub(super) const fn channels(&self) -> usize {
        if self.has_alpha { 4 } else { 3 }
    }

    /// Bytes of a row.
    pub(super) const fn row_bytes(&self) -> usize {
        self.resolution[0] as usize * self.channels() * self.bits.bytes()
    }
}
