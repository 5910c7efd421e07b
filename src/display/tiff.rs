//! Writes a picture as TIFF 6.0, not compressed, strip by strip as its rows come; as BigTIFF where it is too large for that.
//!
//! The directory, which says where the strips are, what their samples mean and where they come from, is behind them.

use std::borrow::Cow;
use std::io::{self, Seek, Write};

use ::tiff::TiffError;
use ::tiff::encoder::{DirectoryEncoder, Rational, TiffEncoder, TiffKind, TiffValue};
use ::tiff::tags::{
    CompressionMethod, ExtraSamples, PhotometricInterpretation, PlanarConfiguration,
    ResolutionUnit, SampleFormat, Tag, Type,
};

use super::Bits;
use super::png::pixel_dimensions;
use super::tags::{Shape, Tags};
use crate::memory;
use crate::output::Sink;

/// Bytes of a strip, of which a row is the least. TIFF 6.0, section 4, names 8 kB, of the memory of its time.
const STRIP: usize = 1 << 18;

/// Bytes of a directory, beside its texts and the places of strips.
const DIRECTORY: u64 = 1 << 12;

/// Tags of TIFF 6.0, section 20: chromaticities (x, y) of white, and of red, green and blue.
const WHITE_POINT: Tag = Tag::Unknown(318);
const PRIMARY_CHROMATICITIES: Tag = Tag::Unknown(319);

/// The text that has a tag of its own.
const SOFTWARE: &str = "Software";

/// Writes a picture whose rows, from the top, `rows` writes: samples as in a PNG, those of 16 bits with the high byte first,
/// and floats in the machine's order.
///
/// # Errors
/// What the sink reports; what `rows` does.
pub(super) fn write<T, E: From<io::Error>>(
    sink: &mut dyn Sink,
    shape: Shape,
    tags: &Tags,
    rows: impl FnOnce(&mut (dyn Write + Send)) -> Result<T, E>,
) -> Result<T, E> {
    if is_small(shape, tags) {
        let encoder = TiffEncoder::new(sink).map_err(into_io)?;
        write_with(encoder, shape, tags, rows)
    } else {
        let encoder = TiffEncoder::new_big(sink).map_err(into_io)?;
        write_with(encoder, shape, tags, rows)
    }
}

/// Whether all places in the file have 32 bits, as TIFF 6.0 has them.
fn is_small(shape: Shape, tags: &Tags) -> bool {
    let height = u64::from(shape.resolution[1]);
    let samples = (shape.row_bytes() as u64).saturating_mul(height);
    // Of each strip its place, its length and what it is aligned by.
    let strips = height.div_ceil(u64::from(strip_rows(shape))) * 16;
    let texts = tags.text.iter();
    let texts: usize = texts.map(|(key, text)| key.len() + text.len() + 4).sum();
    samples.saturating_add(strips + texts as u64 + DIRECTORY) <= u64::from(u32::MAX)
}

/// Rows of each strip but the last.
fn strip_rows(shape: Shape) -> u32 {
    let rows = STRIP / shape.row_bytes().max(1);
    // At most `STRIP`.
    (rows as u32).clamp(1, shape.resolution[1].max(1))
}

fn write_with<W, K, T, E>(
    mut encoder: TiffEncoder<W, K>,
    shape: Shape,
    tags: &Tags,
    rows: impl FnOnce(&mut (dyn Write + Send)) -> Result<T, E>,
) -> Result<T, E>
where
    W: Write + Seek + Send,
    K: TiffKind + Send,
    E: From<io::Error>,
{
    let directory = encoder.image_directory().map_err(into_io)?;
    let mut strips = Strips::new(directory, shape)?;
    let done = rows(&mut strips)?;
    strips.finish(tags)?;
    Ok(done)
}

/// What gathers rows to strips.
struct Strips<'e, W: Write + Seek, K: TiffKind> {
    directory: DirectoryEncoder<'e, W, K>,
    shape: Shape,
    /// Bytes of each strip but the last.
    whole: usize,
    strip: Vec<u8>,
    /// Of the strips that are written.
    places: Vec<u64>,
    lengths: Vec<u64>,
}

impl<W: Write + Seek, K: TiffKind> Write for Strips<'_, W, K> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let taken = bytes.len().min(self.whole - self.strip.len());
        self.strip.extend_from_slice(&bytes[..taken]);
        if self.strip.len() == self.whole {
            self.end_strip().map_err(into_io)?;
        }
        Ok(taken)
    }

    /// Strips are written when they are whole.
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl<'e, W: Write + Seek, K: TiffKind> Strips<'e, W, K> {
    fn new(directory: DirectoryEncoder<'e, W, K>, shape: Shape) -> io::Result<Self> {
        let whole = shape.row_bytes() * strip_rows(shape) as usize;
        let mut strip = Vec::new();
        memory::reserve(&mut strip, whole).map_err(|error| {
            let error = error.for_what("a strip of the TIFF");
            io::Error::new(io::ErrorKind::OutOfMemory, error)
        })?;
        Ok(Self {
            directory,
            shape,
            whole,
            strip,
            places: Vec::new(),
            lengths: Vec::new(),
        })
    }

    fn end_strip(&mut self) -> Result<(), TiffError> {
        if self.shape.bits == Bits::Sixteen {
            // Numbers in a TIFF have the order that its header says: the encoder's is that of the machine.
            let (pairs, _) = self.strip.as_chunks_mut::<2>();
            for pair in pairs {
                *pair = u16::from_be_bytes(*pair).to_ne_bytes();
            }
        }
        self.align()?;
        self.places
            .push(self.directory.write_data(&self.strip[..])?);
        self.lengths.push(self.strip.len() as u64);
        self.strip.clear();
        Ok(())
    }

    /// Fills up to a place at which any number may begin (TIFF 6.0, section 2: a word; of BigTIFF eight bytes).
    fn align(&mut self) -> Result<(), TiffError> {
        let end = self.directory.write_data(&[][..] as &[u8])?;
        let missing = end.next_multiple_of(8) - end;
        self.directory
            .write_data(&[0_u8; 8][..missing as usize])
            .map(drop)
    }

    fn finish(mut self, tags: &Tags) -> io::Result<()> {
        if !self.strip.is_empty() {
            self.end_strip().map_err(into_io)?;
        }
        self.align().map_err(into_io)?;
        self.tag_samples().map_err(into_io)?;
        self.tag(tags).map_err(into_io)?;
        self.directory.finish().map_err(into_io)
    }

    /// What the samples are, and where.
    fn tag_samples(&mut self) -> Result<(), TiffError> {
        let directory = &mut self.directory;
        let Shape {
            resolution: [width, height],
            has_alpha,
            bits,
            pixel_aspect,
        } = self.shape;
        let channels = self.shape.channels();
        directory.write_tag(Tag::ImageWidth, width)?;
        directory.write_tag(Tag::ImageLength, height)?;
        let numbers = [u16::from(bits.number()); 4];
        directory.write_tag(Tag::BitsPerSample, &numbers[..channels])?;
        let uncompressed = CompressionMethod::None.to_u16();
        directory.write_tag(Tag::Compression, uncompressed)?;
        let color = PhotometricInterpretation::RGB.to_u16();
        directory.write_tag(Tag::PhotometricInterpretation, color)?;
        directory.write_tag(Tag::SamplesPerPixel, channels as u16)?;
        let chunky = PlanarConfiguration::Chunky.to_u16();
        directory.write_tag(Tag::PlanarConfiguration, chunky)?;
        let format = match bits {
            Bits::Eight | Bits::Sixteen => SampleFormat::Uint,
            Bits::ThirtyTwo => SampleFormat::IEEEFP,
        };
        directory.write_tag(Tag::SampleFormat, &[format.to_u16(); 4][..channels])?;
        if has_alpha {
            let unassociated = ExtraSamples::UnassociatedAlpha.to_u16();
            directory.write_tag(Tag::ExtraSamples, unassociated)?;
        }

        directory.write_tag(Tag::RowsPerStrip, strip_rows(self.shape))?;
        for (tag, numbers) in [
            (Tag::StripOffsets, &self.places),
            (Tag::StripByteCounts, &self.lengths),
        ] {
            let numbers = numbers.iter().map(|&number| K::convert_offset(number));
            let numbers = numbers.collect::<Result<Vec<_>, _>>()?;
            directory.write_tag(tag, K::convert_slice(&numbers))?;
        }

        // Pixels per length, of a unit that is none.
        let (x, y) = pixel_dimensions(pixel_aspect).map_or((1, 1), |dims| (dims.xppu, dims.yppu));
        directory.write_tag(Tag::XResolution, Rational { n: x, d: x })?;
        directory.write_tag(Tag::YResolution, Rational { n: y, d: x })?;
        let no_unit = ResolutionUnit::None.to_u16();
        directory.write_tag(Tag::ResolutionUnit, no_unit)
    }

    /// What the colors mean, as far as TIFF has tags for that, and where they come from.
    fn tag(&mut self, tags: &Tags) -> Result<(), TiffError> {
        let primaries = tags.screen.primaries();
        let white = primaries.white.map(hundred_thousandths);
        self.directory.write_tag(WHITE_POINT, white)?;
        let corners = [primaries.red, primaries.green, primaries.blue];
        let corners: Vec<_> = corners.into_iter().flatten().collect();
        let corners: Vec<_> = corners.into_iter().map(hundred_thousandths).collect();
        self.directory
            .write_tag(PRIMARY_CHROMATICITIES, &corners[..])?;

        let mut description = String::new();
        for (key, text) in &tags.text {
            if key == SOFTWARE {
                self.text(Tag::Software, text)?;
            } else {
                description.extend([key, ": ", text, "\n"]);
            }
        }
        if description.is_empty() {
            return Ok(());
        }
        self.text(Tag::ImageDescription, &description)
    }

    fn text(&mut self, tag: Tag, text: &str) -> Result<(), TiffError> {
        self.directory.write_tag(tag, Text(text))?;
        self.align()
    }
}

fn hundred_thousandths(value: f64) -> Rational {
    const UNIT: u32 = 100_000;
    Rational {
        n: (value * f64::from(UNIT)).round() as u32,
        d: UNIT,
    }
}

/// A text of the type ASCII in UTF-8, as other programs read what TIFF 6.0 has no other type for.
struct Text<'t>(&'t str);

impl TiffValue for Text<'_> {
    const BYTE_LEN: u8 = 1;
    const FIELD_TYPE: Type = Type::ASCII;

    fn count(&self) -> usize {
        self.0.len() + 1
    }

    fn data(&self) -> Cow<'_, [u8]> {
        Cow::Owned([self.0.as_bytes(), &[0]].concat())
    }
}

fn into_io(error: TiffError) -> io::Error {
    match error {
        TiffError::IoError(error) => error,
        error => io::Error::new(io::ErrorKind::InvalidInput, error),
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Cursor, SeekFrom};

    use ::tiff::decoder::ifd::Value;
    use ::tiff::decoder::{Decoder, DecodingResult};

    use super::*;
    use crate::color::Primaries;
    use crate::display::Screen;

    const SHAPE: Shape = Shape {
        resolution: [701, 509],
        has_alpha: false,
        bits: Bits::Eight,
        pixel_aspect: 1.0,
    };

    fn tags() -> Tags {
        let text = [("Software", "candela 1"), ("a", "b"), ("c", "Lämpchen")];
        Tags {
            screen: Screen::P3,
            text: text
                .map(|(key, text)| (key.to_owned(), text.to_owned()))
                .into(),
            content_light: None,
            mastering: None,
        }
    }

    /// Bytes as a PNG has them, that change from sample to sample and from row to row.
    fn samples(shape: Shape) -> Vec<u8> {
        let count = shape.row_bytes() * shape.resolution[1] as usize;
        (0..count).map(|place| ((place * 31) >> 3) as u8).collect()
    }

    /// As rows of different numbers come.
    fn write_rows(rows: &mut (dyn Write + Send), shape: Shape) -> io::Result<()> {
        let samples = samples(shape);
        let (first, rest) = samples.split_at(shape.row_bytes());
        rows.write_all(first)?;
        rest.chunks(shape.row_bytes() * 150)
            .try_for_each(|chunk| rows.write_all(chunk))
    }

    fn file(shape: Shape, is_big: bool) -> Cursor<Vec<u8>> {
        let mut file = Cursor::new(Vec::new());
        let rows = |rows: &mut (dyn Write + Send)| write_rows(rows, shape);
        if is_big {
            let encoder = TiffEncoder::new_big(&mut file).unwrap();
            write_with(encoder, shape, &tags(), rows).unwrap();
        } else {
            write(&mut file, shape, &tags(), rows).unwrap();
        }
        file.set_position(0);
        file
    }

    /// Those of a PNG, by an encoder that takes a picture as a whole and by a decoder.
    #[test]
    fn samples_and_tags_are_read_back() {
        for bits in Bits::ALL {
            for (has_alpha, is_big) in [(false, false), (true, false), (false, true), (true, true)]
            {
                let shape = Shape {
                    bits,
                    has_alpha,
                    ..SHAPE
                };
                let file = file(shape, is_big);
                assert_eq!(file.get_ref()[2], if is_big { 43 } else { 42 });
                let mut decoder = Decoder::new(file).unwrap();
                assert_eq!(decoder.dimensions().unwrap(), (701, 509));
                assert_eq!(
                    decoder.get_tag_u32(Tag::RowsPerStrip).unwrap(),
                    strip_rows(shape)
                );
                assert!(decoder.strip_count().unwrap() > 3);
                let extra = decoder.find_tag_unsigned_vec::<u16>(Tag::ExtraSamples);
                assert_eq!(extra.unwrap(), has_alpha.then(|| vec![2]));
                let expected = samples(shape);
                match decoder.read_image().unwrap() {
                    DecodingResult::U8(found) => assert!(found == expected),
                    DecodingResult::U16(found) => {
                        let bytes: Vec<u8> = found.into_iter().flat_map(u16::to_be_bytes).collect();
                        assert!(bytes == expected);
                    }
                    DecodingResult::F32(found) => {
                        let bytes: Vec<u8> = found.into_iter().flat_map(f32::to_ne_bytes).collect();
                        assert!(bytes == expected);
                    }
                    other => panic!("{other:?}"),
                }
            }
        }
    }

    fn rationals(value: Value) -> Vec<f64> {
        match value {
            Value::Rational(n, d) => vec![f64::from(n) / f64::from(d)],
            Value::List(values) => values.into_iter().flat_map(rationals).collect(),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn tags_say_what_the_samples_are() {
        let shape = Shape {
            pixel_aspect: 2.0,
            ..SHAPE
        };
        let mut decoder = Decoder::new(file(shape, false)).unwrap();
        let mut numbers = |tag| rationals(decoder.get_tag(tag).unwrap());
        assert_eq!(numbers(Tag::XResolution), [1.0]);
        // Twice as wide as high: in the same length there are twice as many below each other.
        assert_eq!(numbers(Tag::YResolution), [2.0]);
        let Primaries {
            red,
            green,
            blue,
            white,
        } = Primaries::P3_D65;
        assert_eq!(numbers(WHITE_POINT), white);
        assert_eq!(numbers(PRIMARY_CHROMATICITIES), [red, green, blue].concat());
        let mut text = |tag| decoder.get_tag_ascii_string(tag).unwrap();
        assert_eq!(text(Tag::Software), "candela 1");
        assert_eq!(text(Tag::ImageDescription), "a: b\nc: Lämpchen\n");
    }

    /// Every place in the directory is even (TIFF 6.0, section 2), and so is that of the directory.
    #[test]
    fn places_are_at_words() {
        let file = file(SHAPE, false).into_inner();
        let number =
            |place: usize| u32::from_ne_bytes(file[place..place + 4].try_into().unwrap()) as usize;
        let directory = number(4);
        assert_eq!(directory % 2, 0);
        let count = u16::from_ne_bytes(file[directory..directory + 2].try_into().unwrap());
        for entry in 0..usize::from(count) {
            let entry = directory + 2 + entry * 12;
            let kind = u16::from_ne_bytes(file[entry + 2..entry + 4].try_into().unwrap());
            let size = match kind {
                2 => 1,
                3 => 2,
                4 => 4,
                5 => 8,
                other => panic!("{other}"),
            };
            if size * number(entry + 4) > 4 {
                assert_eq!(number(entry + 8) % 2, 0);
            }
        }
    }

    #[test]
    fn what_is_larger_than_4_gib_is_big() {
        let shape = |width, height| Shape {
            resolution: [width, height],
            has_alpha: true,
            ..SHAPE
        };
        // 65 536 bytes a row, so that a strip has four: 2^16 rows are all that there is.
        assert!(is_small(shape(16_384, 65_500), &tags()));
        assert!(!is_small(shape(16_384, 65_536), &tags()));
        // The directory takes place as well: of 16 384 strips, 16 bytes each.
        assert!(!is_small(shape(16_384, 65_533), &tags()));
        assert!(!is_small(shape(u32::MAX, u32::MAX), &tags()));
        let wordy = Tags {
            text: vec![(String::new(), "x".repeat(5 << 20))],
            ..Tags::default()
        };
        assert!(!is_small(shape(16_384, 65_480), &wordy));
        assert!(is_small(shape(16_384, 65_480), &tags()));
    }

    /// A sink that is full after so many bytes.
    struct Full(usize);

    impl Write for Full {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0 = self
                .0
                .checked_sub(bytes.len())
                .ok_or(io::ErrorKind::StorageFull)?;
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl Seek for Full {
        fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
            Ok(0)
        }
    }

    /// At the header, a strip, a tag, and the directory.
    #[test]
    fn errors_of_the_sink_stay_what_they_are() {
        let whole = file(SHAPE, false).into_inner().len();
        for room in [0, 7, 100_000, 600_000, whole - 600, whole - 100] {
            let rows = |rows: &mut (dyn Write + Send)| write_rows(rows, SHAPE);
            let error = write(&mut Full(room), SHAPE, &tags(), rows).unwrap_err();
            assert_eq!(error.kind(), io::ErrorKind::StorageFull, "{room}");
        }
    }
}
