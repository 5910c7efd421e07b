//! Reads R, G, B and A of an OpenEXR file, ours or anyone's.
//!
//! The first part that has channels `R`, `G` and `B` counts: scan lines or tiles, half, float or
//! unsigned int (as the number that it is), any compression that the `exr` crate decodes, of a multi-resolution image the
//! largest level. Only what the display window shows is decoded. The file is not trusted: what its
//! header claims is held against the file's length before memory is asked for.

use std::fs::File;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use exr::block::UncompressedBlock;
use exr::block::chunk::{
    Chunk, CompressedBlock, CompressedScanLineBlock, CompressedTileBlock, TileCoordinates,
};
use exr::meta::attribute::{AttributeValue, Compression, IntegerBounds, SampleType};
use exr::meta::header::Header;
use exr::meta::{MetaData, magic_number};
use exr::prelude::Vec2;
use half::f16;
use rayon::prelude::*;

use super::COLOR_INTEROP_ID;
use crate::color::Primaries;
use crate::film::Window;

/// What an OpenEXR file shows: R, G, B, A inside the display window.
#[derive(Clone, Debug)]
pub struct ExrImage {
    /// Width and height of the display window.
    pub resolution: [u32; 2],
    /// The part of the display window, from its top left, that the file has pixels for; `None` if
    /// the data window lies outside.
    pub window: Option<Window>,
    /// R, G, B, A row by row from the top of `window`, as stored, RGB premultiplied by A; A is 1
    /// where the file has none. May hold infinities and NaN.
    pub pixels: Vec<[f32; 4]>,
    /// Whether the file has a channel A.
    pub has_alpha: bool,
    /// What the file says about the color space of R, G, B.
    pub color: ColorTag,
}

/// What a file says about the color space of its R, G, B.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ColorTag {
    /// The attribute `colorInteropID`.
    pub interop_id: Option<String>,
    /// The attribute `chromaticities`.
    pub chromaticities: Option<Primaries>,
}

/// An OpenEXR file could not be read.
#[derive(Debug, thiserror::Error)]
#[error("cannot read {}: {problem}", path.display())]
pub struct ExrError {
    /// The file as the user named it.
    pub path: PathBuf,
    /// What failed.
    pub problem: ExrProblem,
}

impl ExrError {
    /// Whether another machine or a later try may do better: no memory, a failing disk, a file that is
    /// gone amid the reading.
    pub fn is_transient(&self) -> bool {
        match &self.problem {
            ExrProblem::Io(error) => !matches!(
                error.kind(),
                io::ErrorKind::NotFound
                    | io::ErrorKind::PermissionDenied
                    | io::ErrorKind::IsADirectory
                    | io::ErrorKind::NotADirectory
                    | io::ErrorKind::InvalidInput
                    | io::ErrorKind::InvalidFilename
            ),
            ExrProblem::NotExr
            | ExrProblem::NoRgb(_)
            | ExrProblem::Unsupported(_)
            | ExrProblem::Damaged(_)
            | ExrProblem::TooLarge(..) => false,
        }
    }
}

/// Why an OpenEXR file could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ExrProblem {
    /// The system reports an error.
    #[error("{0}")]
    Io(io::Error),
    /// Something else than OpenEXR.
    #[error("it is not an OpenEXR file")]
    NotExr,
    /// No part has R, G and B.
    #[error("it has no channels R, G, B; it has {}", listed(.0))]
    NoRgb(Vec<String>),
    /// Legal, but of a kind that is not read.
    #[error("{0}")]
    Unsupported(String),
    /// The file contradicts itself or ends too early.
    #[error("the file is damaged or incomplete ({0})")]
    Damaged(String),
    /// More pixels than the limit below or than memory holds.
    #[error("{0} × {1} pixels are too many")]
    TooLarge(usize, usize),
}

/// At most this many names are listed: a file may have thousands of channels.
const LISTED: usize = 20;

fn listed(names: &[String]) -> String {
    let mut list = names[..names.len().min(LISTED)].join(", ");
    if names.len() > LISTED {
        list += &format!(" and {} more", names.len() - LISTED);
    }
    list
}

/// The largest display window, in pixels, around a small data window: 16 384 squared.
///
/// A display window's size is a claim that no data backs, so a damaged header could ask for any
/// amount of memory.
const MAX_SPARSE_PIXELS: usize = 1 << 28;

/// Display windows above [`MAX_SPARSE_PIXELS`] are plausible up to this multiple of the data.
const MAX_SPARSITY: usize = 16;

/// Blocks that each thread decodes at a time.
const BLOCKS_PER_THREAD: usize = 8;

/// Reads what an OpenEXR file shows.
///
/// # Errors
/// See [`ExrProblem`].
pub fn read(path: &Path) -> Result<ExrImage, ExrError> {
    let image = File::open(path)
        .map_err(ExrProblem::Io)
        .and_then(|file| read_file(&file));
    image.map_err(|problem| ExrError {
        path: path.to_path_buf(),
        problem,
    })
}

fn read_file(file: &File) -> Result<ExrImage, ExrProblem> {
    let metadata = file.metadata().map_err(ExrProblem::Io)?;
    if metadata.is_dir() {
        return Err(ExrProblem::Io(io::ErrorKind::IsADirectory.into()));
    }
    read_from(&mut BufReader::new(file), metadata.len())
}

fn read_from(reader: &mut (impl Read + Seek), length: u64) -> Result<ExrImage, ExrProblem> {
    let mut magic = [0; magic_number::BYTES.len()];
    match reader.read_exact(&mut magic) {
        Ok(()) if magic == magic_number::BYTES => {}
        Err(error) if error.kind() != io::ErrorKind::UnexpectedEof => {
            return Err(ExrProblem::Io(error));
        }
        Ok(()) | Err(_) => return Err(ExrProblem::NotExr),
    }
    reader.rewind().map_err(ExrProblem::Io)?;
    let meta = MetaData::read_from_buffered(&mut *reader, false)?;
    let (part, header) = rgb_part(&meta)?;
    let geometry = Geometry::new(header, length)?;

    let offsets = block_offsets(reader, &meta, part, &geometry, length)?;
    let mut pixels = Vec::new();
    if let Some(window) = geometry.window {
        let (width, height) = (window.width as usize, window.height as usize);
        let count = width * height;
        pixels
            .try_reserve_exact(count)
            .map_err(|_| ExrProblem::TooLarge(width, height))?;
        pixels.resize(count, [0.0, 0.0, 0.0, 1.0]);
        let channels = Channel::find(header);
        for batch in offsets.chunks(BLOCKS_PER_THREAD * rayon::current_num_threads()) {
            let chunks = batch
                .iter()
                .map(|offset| read_chunk(reader, &meta, part, offset))
                .collect::<Result<Vec<_>, _>>()?;
            let blocks: Vec<UncompressedBlock> = chunks
                .into_par_iter()
                .map(|chunk| UncompressedBlock::decompress_chunk(chunk, &meta, false))
                .collect::<Result<_, _>>()?;
            for (block, expected) in blocks.iter().zip(batch) {
                if block.index.pixel_position != expected.position {
                    return Err(damaged("a block is not where the header says"));
                }
                geometry.copy(
                    block,
                    &channels,
                    header.channels.bytes_per_pixel,
                    &mut pixels,
                );
            }
        }
    }

    Ok(ExrImage {
        resolution: geometry.resolution,
        window: geometry.window,
        pixels,
        has_alpha: header.channels.list.iter().any(|c| c.name.eq("A")),
        color: color_tag(header),
    })
}

/// The first part with R, G and B.
fn rgb_part(meta: &MetaData) -> Result<(usize, &Header), ExrProblem> {
    let has_rgb = |header: &Header| {
        let has = |name| header.channels.list.iter().any(|c| c.name.eq(name));
        ["R", "G", "B"].into_iter().all(has)
    };
    let Some((part, header)) = meta
        .headers
        .iter()
        .enumerate()
        .find(|(_, header)| has_rgb(header))
    else {
        let names = meta.headers.iter().flat_map(|header| {
            let part = header.own_attributes.layer_name.as_ref();
            header.channels.list.iter().map(move |channel| match part {
                Some(part) if meta.headers.len() > 1 => format!("{} (part {part})", channel.name),
                _ => channel.name.to_string(),
            })
        });
        return Err(ExrProblem::NoRgb(names.collect()));
    };
    if header.deep {
        return Err(ExrProblem::Unsupported(
            "deep pixels are not supported; flatten them first".to_string(),
        ));
    }
    if header
        .channels
        .list
        .iter()
        .any(|c| c.sampling != Vec2(1, 1))
    {
        return Err(ExrProblem::Unsupported(
            "channels with fewer samples than pixels are not supported".to_string(),
        ));
    }
    header.validate(meta.headers.len() > 1, &mut false, false)?;
    Ok((part, header))
}

/// Where a file's pixels are, and which of them count.
struct Geometry {
    /// Width and height of the display window.
    resolution: [u32; 2],
    /// The part of the display window that the file has pixels for.
    window: Option<Window>,
    /// The top left of `window` in the data window.
    origin: Vec2<usize>,
    /// Width and height of the data window.
    size: Vec2<usize>,
    /// Width and height of a block that is not cut off.
    block: Vec2<usize>,
}

impl Geometry {
    fn new(header: &Header, length: u64) -> Result<Self, ExrProblem> {
        let data = header.data_window();
        let display = header.shared_attributes.display_window;
        // Windows are within ±2³⁰, which the crate checks while it reads them.
        let too_large = |size: Vec2<usize>| ExrProblem::TooLarge(size.width(), size.height());

        let bytes = data.size.area() as u128 * header.channels.bytes_per_pixel as u128;
        if bytes > u128::from(length) * u128::from(largest_ratio(header.compression)) {
            return Err(damaged(&format!(
                "{length} bytes cannot hold {} × {} pixels",
                data.size.width(),
                data.size.height()
            )));
        }
        let plausible = MAX_SPARSE_PIXELS.max(data.size.area().saturating_mul(MAX_SPARSITY));
        if display.size.area() > plausible {
            return Err(too_large(display.size));
        }

        let overlap = |data: (i32, usize), display: (i32, usize)| {
            let start = data.0.max(display.0);
            let end =
                (i64::from(data.0) + data.1 as i64).min(i64::from(display.0) + display.1 as i64);
            let length = u32::try_from(end - i64::from(start)).unwrap_or(0);
            (start, length)
        };
        let side = |bounds: IntegerBounds| {
            (
                (bounds.position.x(), bounds.size.width()),
                (bounds.position.y(), bounds.size.height()),
            )
        };
        let ((data_x, data_y), (display_x, display_y)) = (side(data), side(display));
        let (left, width) = overlap(data_x, display_x);
        let (top, height) = overlap(data_y, display_y);
        let window = (width > 0 && height > 0).then(|| Window {
            x: left.abs_diff(display.position.x()),
            y: top.abs_diff(display.position.y()),
            width,
            height,
        });
        Ok(Self {
            resolution: [display.size.width() as u32, display.size.height() as u32],
            window,
            origin: Vec2(
                left.abs_diff(data.position.x()) as usize,
                top.abs_diff(data.position.y()) as usize,
            ),
            size: data.size,
            block: header.max_block_pixel_size(),
        })
    }

    /// The block with this index in the offset table; the largest level comes first.
    fn position(&self, index: usize) -> Vec2<usize> {
        let columns = self.size.width().div_ceil(self.block.width());
        Vec2(
            index % columns * self.block.width(),
            index / columns * self.block.height(),
        )
    }

    /// Whether a block at this position has pixels that count.
    fn shows(&self, position: Vec2<usize>) -> bool {
        self.window.is_some_and(|window| {
            let overlaps = |block: usize, size: usize, window: usize, length: u32| {
                block < window + length as usize && window < block + size
            };
            overlaps(
                position.x(),
                self.block.width(),
                self.origin.x(),
                window.width,
            ) && overlaps(
                position.y(),
                self.block.height(),
                self.origin.y(),
                window.height,
            )
        })
    }

    /// Copies what counts of a block to its place.
    fn copy(
        &self,
        block: &UncompressedBlock,
        channels: &[Channel],
        bytes_per_pixel: usize,
        pixels: &mut [[f32; 4]],
    ) {
        let Some(window) = self.window else { return };
        let (left, width) = (
            block.index.pixel_position.x(),
            block.index.pixel_size.width(),
        );
        let columns =
            left.max(self.origin.x())..(left + width).min(self.origin.x() + window.width as usize);
        let lines = block.data.chunks_exact(width * bytes_per_pixel);
        for (line, y) in lines.zip(block.index.pixel_position.y()..) {
            let Some(row) = y.checked_sub(self.origin.y()) else {
                continue;
            };
            if row >= window.height as usize {
                break;
            }
            let start = row * window.width as usize + columns.start - self.origin.x();
            let target = &mut pixels[start..start + columns.len()];
            for channel in channels {
                let values = &line[channel.offset * width..];
                let from = columns.start - left;
                channel.copy(values, from, target);
            }
        }
    }
}

/// One of R, G, B, A in a file.
struct Channel {
    /// Its place in a pixel.
    index: usize,
    /// Bytes of a pixel that are stored before it.
    offset: usize,
    sample_type: SampleType,
}

impl Channel {
    fn find(header: &Header) -> Vec<Self> {
        header
            .channels
            .channels_with_byte_offset()
            .filter_map(|(offset, channel)| {
                let index = ["R", "G", "B", "A"]
                    .into_iter()
                    .position(|name| channel.name.eq(name))?;
                Some(Self {
                    index,
                    offset,
                    sample_type: channel.sample_type,
                })
            })
            .collect()
    }

    /// Decodes a line's values from column `from` on.
    fn copy(&self, line: &[u8], from: usize, target: &mut [[f32; 4]]) {
        match self.sample_type {
            SampleType::F16 => self.decode(line, from, target, |b| f16::from_ne_bytes(b).to_f32()),
            SampleType::F32 => self.decode(line, from, target, f32::from_ne_bytes),
            SampleType::U32 => self.decode(line, from, target, |b| u32::from_ne_bytes(b) as f32),
        }
    }

    fn decode<const N: usize>(
        &self,
        line: &[u8],
        from: usize,
        target: &mut [[f32; 4]],
        value: impl Fn([u8; N]) -> f32,
    ) {
        let (values, _) = line.as_chunks::<N>();
        for (pixel, &bytes) in target.iter_mut().zip(&values[from..]) {
            pixel[self.index] = value(bytes);
        }
    }
}

/// A block's place in the file and in the data window.
struct Offset {
    byte: u64,
    position: Vec2<usize>,
}

/// Where the file has the blocks that count.
fn block_offsets(
    reader: &mut (impl Read + Seek),
    meta: &MetaData,
    part: usize,
    geometry: &Geometry,
    length: u64,
) -> Result<Vec<Offset>, ExrProblem> {
    // The tables of all parts follow the headers, 8 bytes a block.
    let start = reader.stream_position().map_err(ExrProblem::Io)?;
    let blocks = |headers: &[Header]| -> u128 {
        headers
            .iter()
            .map(|header| header.chunk_count as u128)
            .sum()
    };
    if u128::from(start) + 8 * blocks(&meta.headers) > u128::from(length) {
        return Err(damaged("it ends in the offset table"));
    }
    let before = blocks(&meta.headers[..part]) as u64;
    reader
        .seek(SeekFrom::Start(start + 8 * before))
        .map_err(ExrProblem::Io)?;

    let columns = geometry.size.width().div_ceil(geometry.block.width());
    let rows = geometry.size.height().div_ceil(geometry.block.height());
    let mut offsets = Vec::new();
    for index in 0..columns * rows {
        let mut bytes = [0; 8];
        reader.read_exact(&mut bytes).map_err(ExrProblem::Io)?;
        let (byte, position) = (u64::from_le_bytes(bytes), geometry.position(index));
        if byte == 0 {
            return Err(damaged("a block was never written"));
        }
        if byte >= length {
            return Err(damaged("a block lies behind the end of the file"));
        }
        if geometry.shows(position) {
            offsets.push(Offset { byte, position });
        }
    }
    Ok(offsets)
}

fn read_chunk(
    reader: &mut (impl Read + Seek),
    meta: &MetaData,
    part: usize,
    offset: &Offset,
) -> Result<Chunk, ExrProblem> {
    reader
        .seek(SeekFrom::Start(offset.byte))
        .map_err(ExrProblem::Io)?;
    let chunk = Chunk::read(&mut *reader, meta)?;
    let header = &meta.headers[part];
    let is_here = chunk.layer_index == part
        && header
            .get_block_data_indices(&chunk.compressed_block)
            .is_ok_and(|found| {
                let block = header.max_block_pixel_size();
                found
                    == TileCoordinates {
                        tile_index: offset.position / block,
                        level_index: Vec2(0, 0),
                    }
            });
    if !is_here {
        return Err(damaged("a block is not where the header says"));
    }
    if let (
        Compression::DWAA(_) | Compression::DWAB(_),
        CompressedBlock::ScanLine(CompressedScanLineBlock {
            compressed_pixels_le: bytes,
            ..
        })
        | CompressedBlock::Tile(CompressedTileBlock {
            compressed_pixels_le: bytes,
            ..
        }),
    ) = (header.compression, &chunk.compressed_block)
    {
        check_dwa_sizes(bytes, header)?;
    }
    Ok(chunk)
}

/// Holds the sizes at the start of a DWA block against the block's.
///
/// The decoder asks for memory by them, without a check: a damaged one aborts the process.
fn check_dwa_sizes(bytes: &[u8], header: &Header) -> Result<(), ExrProblem> {
    /// Version, seven section sizes, counts of AC and DC coefficients, coder.
    const COUNTERS: usize = 11;
    let (counters, _) = bytes.as_chunks::<8>();
    // Any block of eight by eight values is full, of 4 bytes each; run lengths can double them.
    let block = header.max_block_pixel_size();
    let padded = block.width().next_multiple_of(8) * block.height().next_multiple_of(8);
    let largest = 2 * 4 * padded * header.channels.list.len();
    let is_raw = bytes.len() == header.max_block_byte_size();
    let too_large = |counter: &[u8; 8]| u64::from_le_bytes(*counter) > largest as u64;
    if !is_raw && counters.iter().take(COUNTERS).any(too_large) {
        return Err(damaged("a DWA block claims more data than it has pixels"));
    }
    Ok(())
}

/// An upper bound of how many bytes of pixels one byte of the file can hold.
fn largest_ratio(compression: Compression) -> u32 {
    // Deflate's longest match: 258 bytes for two bits.
    const DEFLATE: u32 = 1032;
    match compression {
        Compression::Uncompressed => 1,
        // Two bytes for a run of 128.
        Compression::RLE => 64,
        Compression::ZIP1 | Compression::ZIP16 => DEFLATE,
        // Four bytes are stored as three.
        Compression::PXR24 => DEFLATE * 4 / 3 + 1,
        // At best a run of 255 values for nine bits of Huffman code.
        Compression::PIZ => 512,
        // 16 values in three bytes.
        Compression::B44 | Compression::B44A => 11,
        // 64 values in two coefficients, these deflated; other channels as run lengths, deflated.
        Compression::DWAA(_) | Compression::DWAB(_) => 64 * DEFLATE,
        // Not decoded; the decoder says so.
        Compression::HTJ2K32 | Compression::HTJ2K256 => 64 * DEFLATE,
    }
}

fn color_tag(header: &Header) -> ColorTag {
    let xy = |Vec2(x, y): Vec2<f32>| [f64::from(x), f64::from(y)];
    let interop_id = match header.own_attributes.other.get(COLOR_INTEROP_ID.as_bytes()) {
        Some(AttributeValue::Text(id)) => Some(id.to_string()),
        _ => None,
    };
    let chromaticities = header.shared_attributes.chromaticities.map(|c| Primaries {
        red: xy(c.red),
        green: xy(c.green),
        blue: xy(c.blue),
        white: xy(c.white),
    });
    ColorTag {
        interop_id,
        chromaticities,
    }
}

fn damaged(reason: &str) -> ExrProblem {
    ExrProblem::Damaged(reason.to_string())
}

impl From<exr::error::Error> for ExrProblem {
    fn from(error: exr::error::Error) -> Self {
        use exr::error::Error;
        match error {
            Error::Io(error) => Self::Io(error),
            Error::NotSupported(reason) => Self::Unsupported(format!("not supported: {reason}")),
            Error::Invalid(reason) => Self::Damaged(reason.into_owned()),
            // Only callers of the crate make this one, and this one does not.
            Error::Aborted => Self::Damaged("reading was aborted".to_string()),
        }
    }
}
