//! Writes a film as OpenEXR: one part, scan lines, channels R, G, B, A and those of its layers.
//!
//! The `exr` crate validates the header and serializes attributes. The file is put together here,
//! because the crate's own writer puts custom attributes in the order of a hash map, which differs from
//! run to run, and starts a thread pool of its own: here attributes are sorted by name, blocks are
//! compressed on the current `rayon` pool and written in order ([`ExrFile`]), so that one film makes
//! one file to the byte, and the film is never copied as a whole.

use std::io::{self, Seek, Write};
use std::ops::ControlFlow;
use std::path::Path;

use exr::meta::attribute::{
    self, AttributeValue, ChannelDescription, Chromaticities, IntegerBounds, LineOrder, SampleType,
    Text,
};
use exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use exr::meta::{BlockDescription, Requirements, magic_number, sequence_end};
use exr::prelude::{SmallVec, Vec2};
use half::f16;

use super::ExrFile;
use super::color_interop_id;
use super::{COLOR_INTEROP_ID, Compression, ExrOptions, ExrReport, Precision};
use crate::image::{ChannelKind, Channels, Film, ImageSpec, Metadata, Rows};
use crate::output::{self, OutputError, Unfinished};
use crate::turns::in_turn;
use crate::world::colorimetry::primaries;

/// The channels that every film has, in the order of its pixels.
const RGBA: [&str; 4] = ["R", "G", "B", "A"];

/// A channel of the file, and where the film has its values.
pub(super) struct FileChannel<'f> {
    name: &'f str,
    pub(super) precision: Precision,
    source: Source,
    /// Whether digits that halves lose below their smallest normal one are worth a word.
    is_small_counted: bool,
}

/// Where the values of a channel are.
#[derive(Clone, Copy)]
enum Source {
    /// In [`Film::pixels`], at this place of each.
    Pixels(usize),
    /// In [`Film::values`], at this place of each.
    Values(usize),
}

impl Film {
    /// Writes the film as an OpenEXR file, whole or not at all.
    ///
    /// One film and one set of options make one file, to the byte, for any number of threads.
    ///
    /// # Errors
    /// If the file cannot be written, or the run is canceled; the target is then as it was.
    pub fn write_exr(
        &self,
        path: &Path,
        options: &ExrOptions,
        unfinished: &Unfinished,
    ) -> Result<ExrReport, OutputError> {
        output::write(path, unfinished, |mut sink| {
            self.write_exr_to(&mut sink, options)
        })
    }

    /// Writes the film as OpenEXR into `sink`, from the sink's start.
    ///
    /// # Errors
    /// What the sink reports; `InvalidInput` if the format cannot hold the film: where a
    /// provenance key is longer than 247 bytes or holds a zero, where two channels have one name,
    /// and where [`ExrOptions::check`] fails.
    pub fn write_exr_to(
        &self,
        sink: &mut (impl Write + Seek + Send),
        options: &ExrOptions,
    ) -> io::Result<ExrReport> {
        let file = ExrFile::begin(self.spec(), options, sink)?;
        let (blocks, lines) = (file.blocks(), file.lines_per_block());
        let height = self.window().height as usize;
        in_turn(
            blocks,
            || file.packer(),
            |packer, index| {
                let top = index * lines;
                let rows = self.rows(top..height.min(top + lines));
                file.add(index, rows, packer);
                if file.has_failed() {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            },
        );
        file.finish()
    }
}

impl ImageSpec {
    /// All channels in the file's order, which is that of their names' bytes.
    pub(super) fn file_channels(&self, precision: Precision) -> Vec<FileChannel<'_>> {
        let rgba = RGBA
            .into_iter()
            .enumerate()
            .map(|(place, name)| FileChannel {
                name,
                precision,
                source: Source::Pixels(place),
                is_small_counted: false,
            });
        let further = self.channels.list.iter().enumerate();
        let further = further.map(|(place, channel)| FileChannel {
            name: &channel.name,
            precision: match channel.kind {
                ChannelKind::Light | ChannelKind::Direction => precision,
                ChannelKind::Data => Precision::Float,
            },
            source: Source::Values(place),
            is_small_counted: match channel.kind {
                ChannelKind::Light => true,
                ChannelKind::Direction | ChannelKind::Data => false,
            },
        });
        let mut channels: Vec<_> = rgba.chain(further).collect();
        channels.sort_by_key(|channel| channel.name);
        channels
    }

    pub(super) fn header(&self, options: &ExrOptions, channels: &[FileChannel<'_>]) -> Header {
        let channels: SmallVec<[ChannelDescription; 5]> = channels
            .iter()
            .map(|channel| {
                let sample_type = match channel.precision {
                    Precision::Float => SampleType::F32,
                    Precision::Half => SampleType::F16,
                };
                let name = Text::from_slice_unchecked(channel.name.as_bytes());
                ChannelDescription::new(name, sample_type, false)
            })
            .collect();
        let (window, [width, height]) = (self.window, self.resolution);

        let mut image =
            ImageAttributes::new(IntegerBounds::from_dimensions((width as _, height as _)));
        if options.chromaticities {
            image.chromaticities = Some(chromaticities(&self.metadata));
        }
        Header::new(
            Text::from(""),
            (window.width as usize, window.height as usize),
            channels,
        )
        .with_encoding(
            options.compression.into(),
            BlockDescription::ScanLines,
            LineOrder::Increasing,
        )
        .with_shared_attributes(image)
        .with_attributes(LayerAttributes {
            // The scene's limit on the resolution is far below the largest i32.
            layer_position: Vec2(window.x as i32, window.y as i32),
            ..attributes(&self.metadata, &self.channels)
        })
    }
}

impl Rows<'_> {
    /// Appends a block of lines as the file has it before compression.
    pub(super) fn store(
        self,
        channels: &[FileChannel<'_>],
        width: usize,
        bytes: &mut Vec<u8>,
    ) -> Halves {
        let further = self.values.len() / self.pixels.len();
        let mut halves = Halves::default();
        for start in (0..self.pixels.len()).step_by(width) {
            let row = start..start + width;
            for channel in channels {
                let precision = channel.precision;
                let stored = match channel.source {
                    Source::Pixels(place) => {
                        let pixels = self.pixels[row.clone()].iter();
                        let values = pixels.map(|pixel| pixel[place]);
                        store(values, precision, bytes)
                    }
                    Source::Values(place) => {
                        let pixels = row.clone();
                        let values = pixels.map(|pixel| self.values[pixel * further + place]);
                        store(values, precision, bytes)
                    }
                };
                halves.clamped += stored.clamped;
                if channel.is_small_counted {
                    halves.small += stored.small;
                }
            }
        }
        halves
    }
}

/// Values that halves do not hold well.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Halves {
    /// Beyond ± the largest.
    pub(super) clamped: u64,
    /// Not 0, but below the smallest normal one.
    pub(super) small: u64,
}

impl Halves {
    pub(super) fn add(&mut self, more: Self) {
        self.clamped += more.clamped;
        self.small += more.small;
    }
}

/// Appends values as the file has them before compression.
fn store(
    values: impl ExactSizeIterator<Item = f32>,
    precision: Precision,
    bytes: &mut Vec<u8>,
) -> Halves {
    let mut halves = Halves::default();
    let start = bytes.len();
    match precision {
        Precision::Float => {
            bytes.resize(start + values.len() * size_of::<f32>(), 0);
            let (stored, _) = bytes[start..].as_chunks_mut();
            for (stored, value) in stored.iter_mut().zip(values) {
                *stored = value.to_ne_bytes();
            }
        }
        Precision::Half => {
            bytes.resize(start + values.len() * size_of::<f16>(), 0);
            let (stored, _) = bytes[start..].as_chunks_mut();
            for (stored, value) in stored.iter_mut().zip(values) {
                let (half, is_clamped) = to_half(value);
                halves.clamped += u64::from(is_clamped);
                let is_small = value != 0.0 && value.abs() < f16::MIN_POSITIVE.to_f32();
                halves.small += u64::from(is_small);
                *stored = half.to_ne_bytes();
            }
        }
    }
    halves
}

/// Rounds to the nearest half, values beyond the largest to that; whether it was beyond.
fn to_half(value: f32) -> (f16, bool) {
    let largest = f16::MAX.to_f32();
    (
        f16::from_f32(value.clamp(-largest, largest)),
        value.abs() > largest,
    )
}

/// The file up to the offset table, attributes sorted by name.
pub(super) fn head(header: &Header) -> exr::error::Result<Vec<u8>> {
    let mut requirements = Requirements {
        file_format_version: 2,
        is_single_layer_and_tiled: false,
        has_long_names: false,
        has_deep_data: false,
        has_multiple_layers: false,
    };
    header.validate(false, &mut requirements.has_long_names, true)?;
    for name in header.own_attributes.other.keys() {
        if name.as_slice().contains(&0) {
            return Err(exr::error::Error::Invalid(
                "an attribute's name holds a zero".into(),
            ));
        }
    }

    let mut attributes: Vec<(&[u8], AttributeValue)> = header.all_named_attributes().collect();
    attributes.sort_by_key(|&(name, _)| name);

    let mut bytes = Vec::new();
    magic_number::write(&mut bytes)?;
    requirements.write(&mut bytes)?;
    for (name, value) in &attributes {
        attribute::write(name, value, &mut bytes)?;
    }
    sequence_end::write(&mut bytes)?;
    Ok(bytes)
}

/// What the header says beside windows and channels. The film's unit is cd/m², hence
/// `whiteLuminance` = 1.
fn attributes(metadata: &Metadata, channels: &Channels) -> LayerAttributes {
    let text = |string: &str| Text::from_slice_unchecked(string.as_bytes());
    let mut attributes = LayerAttributes {
        white_luminance: Some(1.0),
        world_to_camera: Some(for_row_vectors(&metadata.world_to_camera)),
        world_to_normalized_device: Some(for_row_vectors(&metadata.world_to_ndc)),
        software_name: Some(text(concat!("candela ", env!("CARGO_PKG_VERSION")))),
        ..LayerAttributes::default()
    };
    let interop_id = text(color_interop_id(metadata.color_space));
    attributes
        .other
        .insert(text(COLOR_INTEROP_ID), AttributeValue::Text(interop_id));
    let provenance = metadata.provenance.iter();
    let provenance = provenance.map(|(key, value)| (text(&format!("candela:{key}")), value));
    let of_channels = channels.attributes.iter();
    let of_channels = of_channels.map(|(name, value)| (text(name), value));
    for (name, value) in provenance.chain(of_channels) {
        attributes
            .other
            .insert(name, AttributeValue::Text(text(value)));
    }
    attributes
}

/// An M44f in Imath's convention, p' = p M with p a row, from a matrix for columns, p' = M p.
fn for_row_vectors(matrix: &[[f64; 4]; 4]) -> [f32; 16] {
    std::array::from_fn(|i| matrix[i % 4][i / 4] as f32)
}

fn chromaticities(metadata: &Metadata) -> Chromaticities {
    let xy = |[x, y]: [f64; 2]| Vec2(x as f32, y as f32);
    let primaries = primaries(metadata.color_space);
    Chromaticities {
        red: xy(primaries.red),
        green: xy(primaries.green),
        blue: xy(primaries.blue),
        white: xy(primaries.white),
    }
}

impl From<Compression> for attribute::Compression {
    fn from(compression: Compression) -> Self {
        match compression {
            Compression::None => Self::Uncompressed,
            Compression::Rle => Self::RLE,
            Compression::Zips => Self::ZIP1,
            Compression::Zip => Self::ZIP16,
            Compression::Piz => Self::PIZ,
            Compression::Pxr24 => Self::PXR24,
            Compression::Dwaa => Self::DWAA(None),
            Compression::Dwab => Self::DWAB(None),
        }
    }
}

pub(super) fn into_io(error: exr::error::Error) -> io::Error {
    match error {
        exr::error::Error::Io(error) => error,
        error => io::Error::new(io::ErrorKind::InvalidInput, error.to_string()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_rounded_and_clamped() {
        assert_eq!(to_half(1.0), (f16::ONE, false));
        assert_eq!(to_half(65_504.0), (f16::MAX, false));
        assert_eq!(to_half(65_505.0), (f16::MAX, true));
        assert_eq!(to_half(-1e30), (f16::MIN, true));
        // Halfway between 1 and the next half, 1 + 2⁻¹⁰: to even.
        assert_eq!(to_half(1.0 + 1.0 / 2048.0), (f16::ONE, false));
    }

    #[test]
    fn matrices_are_transposed() {
        // Column vectors keep the translation in the last column, row vectors in the last row.
        let matrix = [
            [1.0, 0.0, 0.0, 5.0],
            [0.0, 1.0, 0.0, 6.0],
            [0.0, 0.0, 1.0, 7.0],
            [0.0, 0.0, 0.0, 1.0],
        ];
        let expected = [
            1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 5.0, 6.0, 7.0, 1.0,
        ];
        assert_eq!(for_row_vectors(&matrix), expected);
    }
}
