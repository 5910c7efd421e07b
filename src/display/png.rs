//! Writes an image as PNG, tagged as sRGB.

use std::io::{self, Write};
use std::path::Path;

use png::{
    BitDepth, ColorType, Compression, Encoder, EncodingError, PixelDimensions, SrgbRenderingIntent,
    Unit,
};

use super::{Bits, Image};
use crate::output::{self, OutputError, Unfinished};

impl Image {
    /// Writes the image as a PNG file, whole or not at all.
    ///
    /// # Errors
    /// If the file cannot be written, or the run is canceled; the target is then as it was.
    pub fn write_png(&self, path: &Path, unfinished: &Unfinished) -> Result<(), OutputError> {
        output::write(path, unfinished, |sink| self.write_png_to(sink))
    }

    /// Writes the image as PNG into `sink`.
    ///
    /// # Errors
    /// What the sink reports.
    pub fn write_png_to(&self, sink: impl Write) -> io::Result<()> {
        let encoder = encoder(sink, self.resolution, self.has_alpha, self.bits);
        let mut writer = encoder.write_header().map_err(into_io)?;
        writer.write_image_data(&self.samples).map_err(into_io)?;
        writer.finish().map_err(into_io)
    }
}

/// A PNG of these properties.
pub(super) fn encoder<'a, W: Write>(
    sink: W,
    [width, height]: [u32; 2],
    has_alpha: bool,
    bits: Bits,
) -> Encoder<'a, W> {
    let mut encoder = Encoder::new(sink, width, height);
    encoder.set_color(if has_alpha {
        ColorType::Rgba
    } else {
        ColorType::Rgb
    });
    encoder.set_depth(match bits {
        Bits::Eight => BitDepth::Eight,
        Bits::Sixteen => BitDepth::Sixteen,
    });
    encoder.set_compression(Compression::Fast);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    encoder
}

/// The chunk pHYs for pixels that are so much wider than high; `None` for square ones, and where it says
/// nothing that can be.
pub(super) fn pixel_dimensions(aspect: f32) -> Option<PixelDimensions> {
    /// More digits than cameras and their formats have.
    const UNIT: f64 = 1e6;
    let aspect = f64::from(aspect);
    // As a range, which holds no NaN.
    if !(1e-3..=1e3).contains(&aspect) || (aspect - 1.0).abs() < 1e-4 {
        return None;
    }
    // The more of them there are to a length, the narrower they are.
    Some(PixelDimensions {
        xppu: UNIT as u32,
        yppu: (aspect * UNIT).round() as u32,
        unit: Unit::Unspecified,
    })
}

pub(super) fn into_io(error: EncodingError) -> io::Error {
    match error {
        EncodingError::IoError(error) => error,
        error => io::Error::new(io::ErrorKind::InvalidInput, error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names and contents of a PNG's chunks.
    fn chunks(bytes: &[u8]) -> Vec<(&[u8], &[u8])> {
        let (signature, mut rest) = bytes.split_at(8);
        assert_eq!(signature, b"\x89PNG\r\n\x1a\n");
        let mut chunks = Vec::new();
        while !rest.is_empty() {
            let length = u32::from_be_bytes(rest[..4].try_into().unwrap()) as usize;
            chunks.push((&rest[4..8], &rest[8..8 + length]));
            rest = &rest[12 + length..];
        }
        chunks
    }

    #[test]
    fn header_and_srgb_chunk() {
        for (bits, has_alpha, kind) in [
            (Bits::Eight, false, 2),
            (Bits::Eight, true, 6),
            (Bits::Sixteen, false, 2),
            (Bits::Sixteen, true, 6),
        ] {
            let channels = if has_alpha { 4 } else { 3 };
            let image = Image {
                resolution: [3, 2],
                has_alpha,
                bits,
                samples: (0..3 * 2 * channels * bits.bytes())
                    .map(|i| i as u8)
                    .collect(),
            };
            let mut bytes = Vec::new();
            image.write_png_to(&mut bytes).unwrap();

            let chunks = chunks(&bytes);
            let depth = 8 * bits.bytes() as u8;
            assert_eq!(
                chunks[0],
                (
                    b"IHDR".as_slice(),
                    [0, 0, 0, 3, 0, 0, 0, 2, depth, kind, 0, 0, 0].as_slice()
                )
            );
            // Before the pixels: perceptual intent.
            assert_eq!(chunks[1], (b"sRGB".as_slice(), [0].as_slice()));

            let mut reader = png::Decoder::new(io::Cursor::new(&bytes))
                .read_info()
                .unwrap();
            let mut decoded = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut decoded).unwrap();
            assert_eq!(decoded, image.samples);
        }
    }
}
