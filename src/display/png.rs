//! Writes an image as PNG: what its samples mean, and where it comes from, in chunks before the pixels.

use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

use png::chunk::ChunkType;
use png::text_metadata::{ITXtChunk, TEXtChunk};
use png::{
    BitDepth, ColorType, Compression, Encoder, EncodingError, PixelDimensions, ScaledFloat,
    SourceChromaticities, SrgbRenderingIntent, Unit, Writer,
};

use super::screen::Screen;
use super::tags::{ContentLight, Mastering, Shape, Tags};
use super::{Bits, Image};
use crate::color::Primaries;
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
        self.write_tagged_png_to(sink, &Tags::default())
    }

    /// Writes the image as PNG with these tags into `sink`.
    ///
    /// # Errors
    /// What the sink reports; a key that a PNG cannot hold; samples of 32 bits.
    pub fn write_tagged_png_to(&self, sink: impl Write, tags: &Tags) -> io::Result<()> {
        let shape = Shape {
            resolution: self.resolution,
            has_alpha: self.has_alpha,
            bits: self.bits,
            pixel_aspect: 1.0,
        };
        let mut writer = begin(sink, shape, tags)?;
        writer.write_image_data(&self.samples).map_err(into_io)?;
        writer.finish().map_err(into_io)
    }
}

/// Units of luminance in cLLI and mDCV: 0.0001 cd/m² (PNG, third edition, sections 11.3.2.8 and 11.3.2.7).
fn luminance(value: f64) -> [u8; 4] {
    // `as` saturates.
    ((value * 1e4).round() as u32).to_be_bytes()
}

impl ContentLight {
    fn chunk(self) -> Vec<u8> {
        [luminance(self.brightest), luminance(self.average)].concat()
    }
}

impl Mastering {
    /// Chromaticities in units of 0.00002, red, green, blue, white; then the greatest and the least luminance.
    fn chunk(self) -> Vec<u8> {
        let Primaries {
            red,
            green,
            blue,
            white,
        } = self.primaries;
        let places = [red, green, blue, white].into_iter().flatten();
        let places = places.map(|value| ((value * 5e4).round() as u16).to_be_bytes());
        let [least, greatest] = self.luminance.map(luminance);
        let mut chunk = places.flatten().collect::<Vec<u8>>();
        chunk.extend(greatest);
        chunk.extend(least);
        chunk
    }
}

/// A PNG that is begun: all its chunks before the pixels are written.
pub(super) fn begin<'a, W: Write + 'a>(
    sink: W,
    shape: Shape,
    tags: &Tags,
) -> io::Result<Writer<W>> {
    let [width, height] = shape.resolution;
    let mut encoder: Encoder<'a, W> = Encoder::new(sink, width, height);
    encoder.set_color(if shape.has_alpha {
        ColorType::Rgba
    } else {
        ColorType::Rgb
    });
    encoder.set_depth(match shape.bits {
        Bits::Eight => BitDepth::Eight,
        Bits::Sixteen => BitDepth::Sixteen,
        Bits::ThirtyTwo => return Err(io::Error::new(io::ErrorKind::InvalidInput, NO_FLOATS)),
    });
    encoder.set_compression(Compression::Fast);
    encoder.set_pixel_dims(pixel_dimensions(shape.pixel_aspect));
    // For programs that know no cICP; of both, cICP counts (PNG, third edition, section 4.3).
    if tags.screen == Screen::Srgb {
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    } else {
        if let Some(gamma) = tags.screen.gamma() {
            encoder.set_source_gamma(ScaledFloat::from_scaled(gamma));
        }
        encoder.set_source_chromaticities(chromaticities(&tags.screen.primaries()));
    }
    let mut writer = encoder.write_header().map_err(into_io)?;
    let [primaries, transfer] = tags.screen.code_points();
    // Of RGB, all of the codes.
    let mut chunk = |name, content: &[u8]| writer.write_chunk(ChunkType(name), content);
    chunk(*b"cICP", &[primaries, transfer, 0, 1]).map_err(into_io)?;
    if let Some(mastering) = tags.mastering {
        chunk(*b"mDCV", &mastering.chunk()).map_err(into_io)?;
    }
    for (key, text) in &tags.text {
        let written = if text.is_ascii() {
            writer.write_text_chunk(&TEXtChunk::new(key.as_str(), text.as_str()))
        } else {
            writer.write_text_chunk(&ITXtChunk::new(key.as_str(), text.as_str()))
        };
        written.map_err(into_io)?;
    }
    // The last before the pixels: where it ends, what is written so far ends.
    if let Some(content_light) = tags.content_light {
        let written = writer.write_chunk(ChunkType(CONTENT_LIGHT), &content_light.chunk());
        written.map_err(into_io)?;
    }
    Ok(writer)
}

/// The name of the chunk with [`ContentLight`].
const CONTENT_LIGHT: [u8; 4] = *b"cLLI";

/// The bytes of that chunk behind its name: two numbers and its checksum.
const CONTENT_LIGHT_LENGTH: u64 = 12;

/// Counts the bytes that go through.
pub(super) struct Counted<'c, W> {
    pub(super) sink: W,
    pub(super) count: &'c AtomicU64,
}

impl<W: Write> Write for Counted<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.sink.write(bytes)?;
        self.count.fetch_add(written as u64, Ordering::Relaxed);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }
}

/// Says how bright the picture is in a PNG that is written already: its chunk of that, whatever is in it, is the last
/// before the pixels, which begin at `pixels`. The sink is at its end, before and after.
///
/// # Errors
/// What the sink reports.
pub(super) fn tell_content_light(
    sink: &mut (impl Write + Seek + ?Sized),
    pixels: u64,
    content_light: ContentLight,
) -> io::Result<()> {
    let content = content_light.chunk();
    let checksum = checksum(&[&CONTENT_LIGHT[..], &content].concat());
    sink.seek(SeekFrom::Start(pixels - CONTENT_LIGHT_LENGTH))?;
    sink.write_all(&content)?;
    sink.write_all(&checksum.to_be_bytes())?;
    sink.seek(SeekFrom::End(0)).map(drop)
}

/// The checksum of a chunk's name and content: CRC-32 (PNG, third edition, section 5.5 and annex D; ISO 3309).
fn checksum(bytes: &[u8]) -> u32 {
    /// x³² + x²⁶ + … + 1, the lowest power in the highest bit.
    const POLYNOMIAL: u32 = 0xEDB8_8320;
    let rest = bytes.iter().fold(u32::MAX, |rest, &byte| {
        (0..8).fold(rest ^ u32::from(byte), |rest, _| {
            let is_odd = rest & 1 == 1;
            rest >> 1 ^ if is_odd { POLYNOMIAL } else { 0 }
        })
    });
    !rest
}

/// Why a PNG of floats is refused.
const NO_FLOATS: &str = "a PNG has no samples of 32 bits";

fn chromaticities(primaries: &Primaries) -> SourceChromaticities {
    let place = |[x, y]: [f64; 2]| (scaled(x), scaled(y));
    SourceChromaticities {
        white: place(primaries.white),
        red: place(primaries.red),
        green: place(primaries.green),
        blue: place(primaries.blue),
    }
}

/// A number in hundred thousandths, as gAMA and cHRM have them.
fn scaled(value: f64) -> ScaledFloat {
    ScaledFloat::from_scaled((value * 1e5).round() as u32)
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
            // Before the pixels: perceptual intent, and the same for programs that know cICP.
            assert_eq!(chunks[1], (b"sRGB".as_slice(), [0].as_slice()));
            assert_eq!(chunks[2], (b"cICP".as_slice(), [1, 13, 0, 1].as_slice()));

            let mut reader = png::Decoder::new(io::Cursor::new(&bytes))
                .read_info()
                .unwrap();
            let mut decoded = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut decoded).unwrap();
            assert_eq!(decoded, image.samples);
        }
    }

    fn tagged(tags: &Tags) -> Vec<u8> {
        let mut bytes = Vec::new();
        let image = Image::opaque([1, 1], vec![[1, 2, 3]]);
        image.write_tagged_png_to(&mut bytes, tags).unwrap();
        bytes
    }

    /// Code points by the registry of W3C's PNG, third edition, section 11.3.2.6, whose examples have four of them; and
    /// what stands beside them for older programs.
    #[test]
    fn screens_are_told_twice() {
        for (screen, points, names, gamma) in [
            (Screen::Srgb, [1, 13], &["sRGB"][..], None),
            (Screen::P3, [12, 13], &["gAMA", "cHRM"], Some(45_455)),
            (Screen::Rec2020Pq, [9, 16], &["cHRM"], None),
            (Screen::Rec2020Hlg, [9, 18], &["cHRM"], None),
            (Screen::Rec1886, [1, 1], &["gAMA", "cHRM"], Some(41_667)),
            (Screen::Linear, [1, 8], &["gAMA", "cHRM"], Some(100_000_u32)),
        ] {
            let tags = Tags {
                screen,
                ..Tags::default()
            };
            let bytes = tagged(&tags);
            let chunks = chunks(&bytes);
            let found: Vec<&[u8]> = chunks.iter().map(|(name, _)| *name).collect();
            let names = ["IHDR"].iter().chain(names);
            let names = names.chain(&["cICP", "IDAT", "IEND"]);
            assert!(
                found
                    .iter()
                    .eq(&names.map(|name| name.as_bytes()).collect::<Vec<_>>())
            );
            let content = |wanted: &str| {
                let mut chunks = chunks.iter();
                chunks
                    .find(|(name, _)| *name == wanted.as_bytes())
                    .map(|(_, content)| *content)
            };
            let [primaries, transfer] = points;
            assert_eq!(content("cICP"), Some(&[primaries, transfer, 0, 1][..]));
            assert_eq!(
                content("gAMA"),
                gamma.map(u32::to_be_bytes).as_ref().map(|bytes| &bytes[..])
            );
        }
        // cHRM: white, red, green, blue; of SMPTE EG 432-1 in hundred thousandths.
        let bytes = tagged(&Tags {
            screen: Screen::P3,
            ..Tags::default()
        });
        let values = [
            31_270, 32_900, 68_000, 32_000, 26_500, 69_000, 15_000, 6000_u32,
        ];
        let expected: Vec<u8> = values
            .iter()
            .flat_map(|value| value.to_be_bytes())
            .collect();
        assert_eq!(chunks(&bytes)[2], (b"cHRM".as_slice(), &expected[..]));
    }

    /// The examples of the specification: BT.2020's red is 35 400, 14 600; 1000 cd/m² are 10 000 000.
    #[test]
    fn mastering_and_content_are_told_in_their_units() {
        let bytes = tagged(&Tags {
            screen: Screen::Rec2020Pq,
            text: vec![
                ("Software".to_owned(), "candela".to_owned()),
                (
                    "candela:command".to_owned(),
                    "--layer 'Lämpchen'".to_owned(),
                ),
            ],
            content_light: Some(ContentLight {
                brightest: 1000.0,
                average: 0.25,
            }),
            mastering: Some(Mastering {
                primaries: Primaries::REC2020,
                luminance: [0.0001, 4000.0],
            }),
        });
        let chunks = chunks(&bytes);
        let names: Vec<String> = chunks
            .iter()
            .map(|(name, _)| String::from_utf8_lossy(name).into_owned())
            .collect();
        assert_eq!(
            names,
            [
                "IHDR", "cHRM", "cICP", "mDCV", "tEXt", "iTXt", "cLLI", "IDAT", "IEND"
            ]
        );
        let places = [35_400, 14_600, 8500, 39_850, 6550, 2300, 15_635, 16_450_u16];
        let mut expected: Vec<u8> = places
            .iter()
            .flat_map(|place| place.to_be_bytes())
            .collect();
        expected.extend([40_000_000, 1_u32].map(u32::to_be_bytes).as_flattened());
        assert_eq!(chunks[3].1, expected);
        let expected = [10_000_000, 2500_u32].map(u32::to_be_bytes);
        assert_eq!(chunks[6].1, expected.as_flattened());
        assert_eq!(chunks[4].1, b"Software\0candela");
        assert_eq!(
            chunks[5].1,
            "candela:command\0\0\0\0\0--layer 'Lämpchen'".as_bytes()
        );
        // And as the crate reads it.
        let reader = png::Decoder::new(io::Cursor::new(&bytes))
            .read_info()
            .unwrap();
        let info = reader.info();
        let mastering = info.mastering_display_color_volume.unwrap();
        assert_eq!(
            (mastering.max_luminance, mastering.min_luminance),
            (40_000_000, 1)
        );
        assert_eq!(
            info.content_light_level.unwrap().max_content_light_level,
            10_000_000
        );
        assert_eq!(
            info.coding_independent_code_points
                .unwrap()
                .transfer_function,
            16
        );
    }

    /// As if it had been known: the same bytes, checksums among them.
    #[test]
    fn content_light_is_told_afterwards() {
        let image = Image::opaque([2, 1], vec![[1, 2, 3]; 2]);
        let with = |brightest, average| Tags {
            screen: Screen::Rec2020Pq,
            text: vec![("key".to_owned(), "cLLI".to_owned())],
            content_light: Some(ContentLight { brightest, average }),
            mastering: None,
        };
        let known = with(203.0, 1.5);
        let mut expected = Vec::new();
        image.write_tagged_png_to(&mut expected, &known).unwrap();

        let mut file = io::Cursor::new(b"before".to_vec());
        file.seek(SeekFrom::End(0)).unwrap();
        let start = file.position();
        let count = AtomicU64::new(0);
        let sink = Counted {
            sink: &mut file,
            count: &count,
        };
        let shape = Shape {
            resolution: image.resolution,
            has_alpha: false,
            bits: Bits::Eight,
            pixel_aspect: 1.0,
        };
        let mut writer = begin(sink, shape, &with(0.0, 0.0)).unwrap();
        let pixels = start + count.load(Ordering::Relaxed);
        writer.write_image_data(&image.samples).unwrap();
        writer.finish().unwrap();
        tell_content_light(&mut file, pixels, known.content_light.unwrap()).unwrap();
        assert_eq!(file.stream_position().unwrap(), 6 + expected.len() as u64);
        assert_eq!(&file.get_ref()[6..], expected);
    }

    /// The check value of CRC-32/ISO-HDLC.
    #[test]
    fn checksums() {
        assert_eq!(checksum(b"123456789"), 0xCBF4_3926);
    }

    #[test]
    fn what_a_png_cannot_hold_is_an_error() {
        let image = Image::opaque([1, 1], vec![[1, 2, 3]]);
        let tags = Tags {
            text: vec![("k".repeat(80), String::new())],
            ..Tags::default()
        };
        assert!(image.write_tagged_png_to(io::sink(), &tags).is_err());
        let floats = Image {
            bits: Bits::ThirtyTwo,
            ..image
        };
        assert!(floats.write_png_to(io::sink()).is_err());
    }
}
