//! Pictures that are no OpenEXR files, decoded to linear light: PNG, JPEG, TIFF, Radiance HDR.
//!
//! ```text
//! first bytes ─ format ─ header ─ samples ─ orientation ─ R, G, B, A
//!                          │         │
//!                          │         code values become light; R, G, B are multiplied by A
//!                          size, held against the file's length; which curve, which primaries
//! ```
//!
//! **Memory.** The file is in memory as it is, its samples as they are decoded, and 16 bytes for each pixel. A size
//! that the file cannot hold is an error before any of it is asked for (`check_size`).

mod coding;
mod hdr;
mod jpeg;
mod orientation;
mod png;
mod problem;
mod samples;
mod tiff;

use std::io::{self, Read};
use std::path::Path;

pub use problem::{ImageFileError, ImageFileProblem};

use crate::color::Primaries;
use crate::exr::{ColorTag, ExrImage};
use crate::image::Window;
use crate::input::Hash;
use crate::memory;

/// So many bytes tell a format.
pub(crate) const TELLING: usize = 8;

/// The most that is read from a pipe: 4 GiB, as of an EXR.
const MAX_PIPED: u64 = 1 << 32;

/// Pixels that a byte of a file can stand for. Deflate packs at most 1032 bytes into one (zlib's technical details), LZW of
/// TIFF some 2730, each of them eight pixels of one bit: 21 840.
const PIXELS_PER_BYTE: u64 = 1 << 15;

/// A format by its first bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    /// Portable Network Graphics, third edition (W3C 2025).
    Png,
    /// JPEG (ITU-T T.81), as JFIF or Exif.
    Jpeg,
    /// TIFF 6.0 (Adobe 1992), or BigTIFF.
    Tiff,
    /// Radiance's pictures of shared exponents (Ward 1991, "Real pixels").
    Hdr,
}

impl ImageFormat {
    /// The format of a file that starts with these bytes, of which there are [`TELLING`] unless the file is shorter.
    pub(crate) fn of(start: &[u8]) -> Option<Self> {
        match start {
            [0x89, b'P', b'N', b'G', b'\r', b'\n', 0x1a, b'\n', ..] => Some(Self::Png),
            [0xff, 0xd8, 0xff, ..] => Some(Self::Jpeg),
            [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => Some(Self::Tiff),
            // `#?RADIANCE`, but other programs write their own name or `#?RGBE`.
            [b'#', b'?', ..] => Some(Self::Hdr),
            _ => None,
        }
    }

    /// The name in messages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::Tiff => "TIFF",
            Self::Hdr => "Radiance HDR",
        }
    }
}

/// A picture as it was read: linear light, R, G, B multiplied by A.
#[derive(Clone, Debug)]
pub struct ImageFile {
    /// The picture; 1 is the white of the format's coding.
    pub image: ExrImage,
    /// How much wider than high a pixel is.
    pub pixel_aspect: f32,
    /// What the user should know about the file, a sentence each.
    pub warnings: Vec<String>,
    /// Of the file's bytes.
    hash: Hash,
}

/// What a format's decoder makes of a file.
struct Decoded {
    resolution: [u32; 2],
    /// Linear R, G, B, A, row by row from the top.
    pixels: Vec<[f32; 4]>,
    has_alpha: bool,
    primaries: Primaries,
    pixel_aspect: f32,
    warnings: Vec<String>,
}

impl ImageFile {
    /// Decodes a file whose bytes are these; `path` names it in messages.
    ///
    /// # Errors
    /// See [`ImageFileProblem`].
    pub(crate) fn decode(
        path: &Path,
        format: ImageFormat,
        bytes: &[u8],
    ) -> Result<Self, ImageFileError> {
        let decoded = match format {
            ImageFormat::Png => png::decode(bytes),
            ImageFormat::Jpeg => jpeg::decode(bytes),
            ImageFormat::Tiff => tiff::decode(bytes),
            ImageFormat::Hdr => hdr::decode(bytes),
        };
        let decoded = decoded.map_err(|problem| ImageFileError::new(path, problem))?;
        let is_rec709 = decoded.primaries == Primaries::REC709;
        Ok(Self {
            image: ExrImage {
                resolution: decoded.resolution,
                window: Some(Window::whole(decoded.resolution)),
                pixels: decoded.pixels,
                has_alpha: decoded.has_alpha,
                color: ColorTag {
                    interop_id: None,
                    chromaticities: (!is_rec709).then_some(decoded.primaries),
                },
            },
            pixel_aspect: decoded.pixel_aspect,
            warnings: decoded.warnings,
            hash: Hash::of(bytes),
        })
    }

    /// The hash of the file.
    pub(crate) const fn hash(&self) -> Hash {
        self.hash
    }
}

/// The first bytes of a file, fewer than [`TELLING`] where it is shorter.
///
/// # Errors
/// What the stream reports.
pub(crate) fn start_of(stream: &mut dyn Read) -> io::Result<Vec<u8>> {
    let mut start = Vec::with_capacity(TELLING);
    stream.take(TELLING as u64).read_to_end(&mut start)?;
    Ok(start)
}

/// All bytes of a file that begins with `start`, of which the rest is in `stream`.
///
/// # Errors
/// What the stream reports; no memory; more than 4 GiB.
pub(crate) fn rest_of(
    mut start: Vec<u8>,
    stream: &mut dyn Read,
) -> Result<Vec<u8>, ImageFileProblem> {
    /// Memory grows by at least so much.
    const PIECE: usize = 1 << 20;
    loop {
        if start.len() == start.capacity() {
            let more = start.len().max(PIECE);
            memory::reserve(&mut start, more).map_err(|error| error.for_what("the file"))?;
        }
        let room = (start.capacity() - start.len()) as u64;
        if stream.take(room).read_to_end(&mut start)? == 0 {
            return Ok(start);
        }
        if start.len() as u64 > MAX_PIPED {
            return Err(ImageFileProblem::Unsupported(
                "it is longer than 4 GiB".to_owned(),
            ));
        }
    }
}

/// Whether a file of so many bytes can hold a picture of this size.
fn check_size([width, height]: [u32; 2], length: usize) -> Result<(), ImageFileProblem> {
    if width == 0 || height == 0 {
        return Err(problem::damaged("it has no pixels"));
    }
    let most = (length as u64).saturating_mul(PIXELS_PER_BYTE);
    if u64::from(width) * u64::from(height) > most {
        return Err(ImageFileProblem::TooLarge(width, height));
    }
    Ok(())
}

/// Room for so many decoded bytes, and whether there is memory for the pixels that they become and for so many more
/// bytes.
fn room(
    [width, height]: [u32; 2],
    pixel_bytes: usize,
    more: u64,
) -> Result<Vec<u8>, ImageFileProblem> {
    let count = u64::from(width) * u64::from(height);
    let decoded = count.saturating_mul(pixel_bytes as u64);
    let pixels = count.saturating_mul(size_of::<[f32; 4]>() as u64);
    let all = decoded.saturating_add(pixels).saturating_add(more);
    memory::look_for(all).map_err(|error| error.for_what("the picture"))?;
    // It fits, since there is memory for it.
    let decoded = decoded as usize;
    let mut bytes = Vec::new();
    memory::reserve(&mut bytes, decoded).map_err(|error| error.for_what("the picture"))?;
    bytes.resize(decoded, 0);
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_told_by_their_first_bytes() {
        for (start, format) in [
            (&b"\x89PNG\r\n\x1a\n"[..], Some(ImageFormat::Png)),
            (b"\xff\xd8\xff\xe0\0\x10JF", Some(ImageFormat::Jpeg)),
            (b"II*\0\x08\0\0\0", Some(ImageFormat::Tiff)),
            (b"MM\0*\0\0\0\x08", Some(ImageFormat::Tiff)),
            (b"II+\0\x08\0\0\0", Some(ImageFormat::Tiff)),
            (b"#?RADIAN", Some(ImageFormat::Hdr)),
            (b"#?RGBE\n\n", Some(ImageFormat::Hdr)),
            (b"\x76\x2f\x31\x01\x02\0\0\0", None),
            (b"\x89PNG", None),
            (b"", None),
        ] {
            assert_eq!(ImageFormat::of(start), format, "{start:?}");
        }
    }

    #[test]
    fn a_size_is_held_against_the_length() {
        assert!(check_size([4096, 4096], 512).is_ok());
        assert!(matches!(
            check_size([4096, 4097], 512),
            Err(ImageFileProblem::TooLarge(4096, 4097))
        ));
        assert!(check_size([u32::MAX; 2], 1 << 20).is_err());
        assert!(check_size([0, 1], 512).is_err());
    }
}
