//! Writes an image as TIFF 6.0, not compressed.
//!
//! What the encoder has no place for is lost: what the colors mean, the aspect of pixels, provenance, and the tag
//! `ExtraSamples` that says that a fourth sample is alpha.

use std::io;

use ::image::codecs::tiff::TiffEncoder;
use ::image::{ExtendedColorType, ImageEncoder, ImageError};

use super::Bits;
use crate::output::Sink;

/// The most bytes of samples: places in a TIFF have 32 bits. The rest is for its directory.
const MOST: u64 = u32::MAX as u64 - (1 << 20);

/// Whether a TIFF can hold so many bytes of samples.
pub(super) fn check(bytes: u64) -> io::Result<()> {
    if bytes <= MOST {
        return Ok(());
    }
    Err(io::Error::new(
        io::ErrorKind::InvalidInput,
        "a TIFF holds at most 4 GiB; write a PNG, or fewer bits",
    ))
}

/// Writes samples, which are row by row from the top; those of 16 bits have the high byte first, as in a PNG.
pub(super) fn write(
    sink: &mut dyn Sink,
    [width, height]: [u32; 2],
    has_alpha: bool,
    bits: Bits,
    samples: &mut [u8],
) -> io::Result<()> {
    let color = match (bits, has_alpha) {
        (Bits::Eight, false) => ExtendedColorType::Rgb8,
        (Bits::Eight, true) => ExtendedColorType::Rgba8,
        (Bits::Sixteen, false) => ExtendedColorType::Rgb16,
        (Bits::Sixteen, true) => ExtendedColorType::Rgba16,
        (Bits::ThirtyTwo, false) => ExtendedColorType::Rgb32F,
        (Bits::ThirtyTwo, true) => ExtendedColorType::Rgba32F,
    };
    if bits == Bits::Sixteen {
        // The encoder takes the machine's order.
        let (pairs, _) = samples.as_chunks_mut::<2>();
        for pair in pairs {
            *pair = u16::from_be_bytes(*pair).to_ne_bytes();
        }
    }
    let written = TiffEncoder::new(sink).write_image(samples, width, height, color);
    written.map_err(|error| match error {
        ImageError::IoError(error) => error,
        error => io::Error::new(io::ErrorKind::InvalidInput, error),
    })
}
