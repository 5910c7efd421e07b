//! Writes channels of any names as they are: FLOAT, one part, scan lines, ZIP.

use std::io::{self, Write};
use std::path::Path;

use exr::meta::BlockDescription;
use exr::meta::attribute::{
    ChannelDescription, Compression, IntegerBounds, LineOrder, SampleType, Text,
};
use exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use exr::prelude::{SmallVec, Vec2};
use rayon::prelude::*;

use super::file::into_io;
use super::head::head;
use super::read::DataWindow;
use super::zip::Zip;
use crate::output::{self, OutputError, Unfinished};

/// Blocks that are compressed at a time.
const TOGETHER: usize = 64;

/// Writes channels as an OpenEXR file, whole or not at all: name and samples, row by row of the data window. Nothing
/// is said of colors.
///
/// # Errors
/// If the file cannot be written, or the format cannot hold it: two channels of one name, or a block of more than
/// 2 GB.
///
/// # Panics
/// If a channel has not as many samples as the window has pixels.
#[doc(hidden)]
pub fn write_planes(
    path: &Path,
    window: DataWindow,
    planes: &[(&str, &[f32])],
    unfinished: &Unfinished,
) -> Result<(), OutputError> {
    assert!(
        planes
            .iter()
            .all(|(_, plane)| plane.len() as u64 == window.count())
    );
    let mut planes = planes.to_vec();
    planes.sort_by_key(|&(name, _)| name);
    output::write(path, unfinished, |mut sink| {
        write(&mut sink, window, &planes)
    })
}

fn write(sink: &mut impl Write, window: DataWindow, planes: &[(&str, &[f32])]) -> io::Result<()> {
    let header = header(window, planes)?;
    let mut head = head(&header).map_err(into_io)?;
    let lines = Compression::ZIP16.scan_lines_per_block();
    let [width, height] = window.size.map(|side| side as usize);
    let tops: Vec<usize> = (0..height).step_by(lines).collect();
    let block = width as u64 * lines.min(height) as u64 * planes.len() as u64 * 4;
    if i32::try_from(block).is_err() {
        let message = "so many channels do not fit the blocks of OpenEXR, 2.1 GB";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
    }
    // The table comes before the blocks, and a pipe cannot go back: they are compressed first.
    let mut blocks: Vec<Vec<u8>> = Vec::new();
    for tops in tops.chunks(TOGETHER) {
        blocks.par_extend(tops.par_iter().map_init(
            || Zip::new(true),
            |zip, &top| {
                let rows = top * width..height.min(top + lines) * width;
                let mut raw = Vec::new();
                for start in rows.step_by(width) {
                    for (_, plane) in planes {
                        let line = plane[start..start + width].iter();
                        raw.extend(line.flat_map(|value| value.to_le_bytes()));
                    }
                }
                let y = window.corner[1] as i32 + top as i32;
                let mut block = y.to_le_bytes().to_vec();
                block.extend([0; 4]);
                zip.compress(&raw, &mut block);
                let length = (block.len() - 8) as i32;
                block[4..8].copy_from_slice(&length.to_le_bytes());
                block
            },
        ));
    }
    let mut offset = (head.len() + 8 * blocks.len()) as u64;
    for block in &blocks {
        head.extend(offset.to_le_bytes());
        offset += block.len() as u64;
    }
    sink.write_all(&head)?;
    blocks.iter().try_for_each(|block| sink.write_all(block))
}

fn header(window: DataWindow, planes: &[(&str, &[f32])]) -> io::Result<Header> {
    let channels: SmallVec<[ChannelDescription; 5]> = planes
        .iter()
        .map(|(name, _)| {
            let name = Text::from_slice_unchecked(name.as_bytes());
            ChannelDescription::new(name, SampleType::F32, false)
        })
        .collect();
    let side = |side: i64| {
        i32::try_from(side).map_err(|_| {
            let message = "its data window is beyond the limits of OpenEXR";
            io::Error::new(io::ErrorKind::InvalidInput, message)
        })
    };
    let corner = Vec2(side(window.corner[0])?, side(window.corner[1])?);
    let [width, height] = window.resolution.map(|side| side as usize);
    let [columns, rows] = window.size.map(|side| side as usize);
    let software = concat!("candela ", env!("CARGO_PKG_VERSION"));
    let image = ImageAttributes::new(IntegerBounds::from_dimensions((width, height)));
    let header = Header::new(Text::from(""), (columns, rows), channels)
        .with_encoding(
            Compression::ZIP16,
            BlockDescription::ScanLines,
            LineOrder::Increasing,
        )
        .with_shared_attributes(image)
        .with_attributes(LayerAttributes {
            layer_position: corner,
            software_name: Some(Text::from_slice_unchecked(software.as_bytes())),
            ..LayerAttributes::default()
        });
    Ok(header)
}
