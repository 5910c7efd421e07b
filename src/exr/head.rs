//! The head of a file: all that comes before its offset table, attributes sorted by name.

use exr::meta::attribute::{
    self, AttributeValue, ChannelDescription, Chromaticities, IntegerBounds, LineOrder, SampleType,
    Text,
};
use exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use exr::meta::{BlockDescription, Requirements, magic_number, sequence_end};
use exr::prelude::{SmallVec, Vec2};

use super::store::FileChannel;
use super::tile::{NO_HASH, TILE, TILE_HASH, TILE_WINDOW, Tile};
use super::{COLOR_INTEROP_ID, Compression, ExrOptions, Precision};
use crate::color::ColorSpace;
use crate::image::{Channels, ImageSpec, Metadata, Number};

impl ImageSpec {
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

        let mut own = attributes(&self.metadata, &self.channels);
        own.other
            .extend(options.tile.iter().flat_map(tile_attributes));
        let mut image =
            ImageAttributes::new(IntegerBounds::from_dimensions((width as _, height as _)));
        if options.chromaticities || self.metadata.color_space != ColorSpace::Rec709 {
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
            ..own
        })
    }
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

/// The attribute that says how far sums of layers are off the image.
pub(super) const RESIDUAL: &str = "candela:residual";

/// Where in a head the number of [`RESIDUAL`] is, if it is there.
pub(super) fn residual_place(head: &[u8]) -> Option<u64> {
    let start = [RESIDUAL.as_bytes(), b"\0float\0\x04\0\0\0"].concat();
    let place = head.windows(start.len()).position(|bytes| bytes == start)?;
    Some((place + start.len()) as u64)
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
    let interop_id = text(metadata.color_space.interop_id());
    attributes
        .other
        .insert(text(COLOR_INTEROP_ID), AttributeValue::Text(interop_id));
    let provenance = metadata.provenance.iter();
    let provenance = provenance.map(|(key, value)| (text(&format!("candela:{key}")), value));
    let of_channels = channels.attributes.iter();
    let of_channels = of_channels.map(|(name, value)| (text(name), value));
    for (name, number) in &metadata.numbers {
        let value = match *number {
            Number::Integer(value) => AttributeValue::I32(value),
            Number::Float(value) => AttributeValue::F32(value),
            Number::Pair([x, y]) => AttributeValue::FloatVec2(Vec2(x, y)),
        };
        attributes.other.insert(text(name), value);
    }
    if !channels.sums.is_empty() {
        // It is known when all is written.
        attributes
            .other
            .insert(text(RESIDUAL), AttributeValue::F32(0.0));
    }
    for (name, value) in provenance.chain(of_channels) {
        attributes
            .other
            .insert(name, AttributeValue::Text(text(value)));
    }
    attributes
}

/// What says which tile a file is.
fn tile_attributes(tile: &Tile) -> [(Text, AttributeValue); 3] {
    let text = |bytes: &[u8]| Text::from_slice_unchecked(bytes);
    let Tile { number, of } = tile;
    let window = IntegerBounds::new(
        (of.x as i32, of.y as i32),
        (of.width as usize, of.height as usize),
    );
    let number = number.to_string();
    [
        (TILE, AttributeValue::Text(text(number.as_bytes()))),
        (TILE_WINDOW, AttributeValue::IntegerBounds(window)),
        // It is known when all is written.
        (TILE_HASH, AttributeValue::Text(text(&NO_HASH))),
    ]
    .map(|(name, value)| (text(name.as_bytes()), value))
}

/// An M44f in Imath's convention, p' = p M with p a row, from a matrix for columns, p' = M p.
fn for_row_vectors(matrix: &[[f64; 4]; 4]) -> [f32; 16] {
    std::array::from_fn(|i| matrix[i % 4][i / 4] as f32)
}

fn chromaticities(metadata: &Metadata) -> Chromaticities {
    let xy = |[x, y]: [f64; 2]| Vec2(x as f32, y as f32);
    let primaries = metadata.color_space.primaries();
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

#[cfg(test)]
mod tests {
    use super::*;

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
