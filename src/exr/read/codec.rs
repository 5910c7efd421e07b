//! From the bytes of a block to its samples.
//!
//! The `exr` crate decodes; what it takes for granted is checked before. It allocates what a block
//! claims to hold without asking, so that a block is given to it only if its bytes can hold as much, and
//! if the system has that memory.

use exr::meta::BlockDescription;
use exr::meta::attribute::{
    ChannelDescription, Compression, IntegerBounds, LevelMode, SampleType, Text, TileDescription,
};
use exr::meta::header::Header;
use exr::prelude::Vec2;

use super::b44::{self, Plane};
use super::geometry::{Rectangle, samples};
use super::header::{Channel, Part, SampleKind};
use super::{ExrProblem, damaged};

/// Decodes the blocks of a part.
#[derive(Debug)]
pub(super) struct Codec {
    compression: Compression,
    header: Header,
    channels: Vec<Channel>,
    /// Whether any channel has fewer samples than pixels.
    is_sampled: bool,
    /// The coordinates of the data window's top left.
    start: [i32; 2],
}

/// The way out for what cannot be decoded.
const WAY_OUT: &str = "convert it first, as by `oiiotool in.exr --compression zip -o out.exr`";

/// The decoder of DWA compares the layers of all channels with each other, block by block.
const MAX_DWA_CHANNELS: usize = 1 << 12;

/// The compression with this number in the file.
pub(super) fn compression(number: u8) -> Result<Compression, ExrProblem> {
    let unsupported = |name: &str| {
        Err(ExrProblem::Unsupported(format!(
            "its pixels are compressed with {name}, which is not supported; {WAY_OUT}"
        )))
    };
    match number {
        0 => Ok(Compression::Uncompressed),
        1 => Ok(Compression::RLE),
        2 => Ok(Compression::ZIP1),
        3 => Ok(Compression::ZIP16),
        4 => Ok(Compression::PIZ),
        5 => Ok(Compression::PXR24),
        6 => Ok(Compression::B44),
        7 => Ok(Compression::B44A),
        8 => Ok(Compression::DWAA(None)),
        9 => Ok(Compression::DWAB(None)),
        10 => unsupported("HTJ2K256 (High-Throughput JPEG 2000, of OpenEXR 3.4)"),
        11 => unsupported("HTJ2K32 (High-Throughput JPEG 2000, of OpenEXR 3.4)"),
        number => unsupported(&format!(
            "a method newer than OpenEXR 3.4 (number {number}), or the file is damaged"
        )),
    }
}

/// An upper bound of how many bytes of pixels one byte of the file can hold.
pub(super) fn largest_ratio(compression: Compression) -> u64 {
    // Deflate's longest match: 258 bytes for two bits.
    const DEFLATE: u64 = 1032;
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
        // Not decoded.
        Compression::HTJ2K32 | Compression::HTJ2K256 => 1,
    }
}

impl Codec {
    pub(super) fn new(part: &Part, size: [u32; 2]) -> Result<Self, ExrProblem> {
        let compression = compression(part.compression)?;
        let is_dwa = matches!(compression, Compression::DWAA(_) | Compression::DWAB(_));
        if is_dwa && part.channels.len() > MAX_DWA_CHANNELS {
            return Err(ExrProblem::Unsupported(format!(
                "it has more than {MAX_DWA_CHANNELS} channels in DWA; {WAY_OUT}"
            )));
        }
        let list: Vec<ChannelDescription> = part.channels.iter().map(description).collect();
        let layer_size = Vec2(size[0] as usize, size[1] as usize);
        let mut header = Header::new(Text::from(""), layer_size, list.into());
        header.compression = compression;
        header.blocks = match part.tiles {
            None => BlockDescription::ScanLines,
            Some(tiles) => BlockDescription::Tiles(TileDescription {
                tile_size: Vec2(tiles.width as usize, tiles.height as usize),
                level_mode: LevelMode::Singular,
                rounding_mode: exr::math::RoundingMode::Down,
            }),
        };
        // In the order of the file, which the crate would sort.
        header.channels.list = part.channels.iter().map(description).collect();
        Ok(Self {
            compression,
            header,
            channels: part.channels.clone(),
            is_sampled: part
                .channels
                .iter()
                .any(|channel| channel.sampling != [1, 1]),
            start: [part.data_window[0], part.data_window[1]],
        })
    }

    pub(super) const fn is_sampled(&self) -> bool {
        self.is_sampled
    }

    pub(super) fn channels(&self) -> &[Channel] {
        &self.channels
    }

    /// Lines of a block of scan lines that is not cut off.
    pub(super) fn lines(compression: Compression) -> u32 {
        compression.scan_lines_per_block() as u32
    }

    /// Samples of a channel in a line of a block, 0 where the line, by its place in the data window,
    /// has none.
    pub(super) fn in_line(&self, channel: &Channel, block: Rectangle, line: u32) -> usize {
        let [x, y] = channel.sampling;
        if y > 1 && samples(self.start[1] + line as i32, 1, y) == 0 {
            return 0;
        }
        if x == 1 {
            return block.width as usize;
        }
        samples(self.start[0] + block.left as i32, block.width, x) as usize
    }

    /// Bytes of a block before compression.
    pub(super) fn bytes(&self, block: Rectangle) -> u64 {
        let area = |channel: &Channel| -> u64 {
            let [x, y] = channel.sampling;
            let [left, top] = [
                self.start[0] + block.left as i32,
                self.start[1] + block.top as i32,
            ];
            let columns = samples(left, block.width, x);
            u64::from(columns) * u64::from(samples(top, block.height, y))
        };
        let bytes = |channel: &Channel| area(channel).saturating_mul(channel.kind.bytes() as u64);
        self.channels.iter().map(bytes).fold(0, u64::saturating_add)
    }

    /// Whether a file of this length can have pixels for all of a data window.
    pub(super) fn check_length(&self, size: [u32; 2], length: u64) -> Result<(), ExrProblem> {
        let [width, height] = size;
        let whole = Rectangle {
            left: 0,
            top: 0,
            width,
            height,
        };
        if self.bytes(whole) > length.saturating_mul(largest_ratio(self.compression)) {
            return Err(damaged(&format!(
                "{length} bytes cannot hold {width} × {height} pixels"
            )));
        }
        Ok(())
    }

    /// The samples of a block, native-endian: line by line, in each line channel by channel in the order of
    /// the file.
    pub(super) fn decode(&self, block: Rectangle, bytes: Vec<u8>) -> Result<Vec<u8>, ExrProblem> {
        let expected = self.bytes(block);
        let ratio = largest_ratio(self.compression);
        if expected > (bytes.len() as u64).saturating_mul(ratio) {
            return Err(damaged("a block has too few bytes for its pixels"));
        }
        let expected = match i32::try_from(expected) {
            Ok(expected) => expected as usize,
            Err(_) => {
                return Err(ExrProblem::Unsupported(
                    "it has blocks of more than 2 GB; save it with another compression".to_owned(),
                ));
            }
        };
        // The crate takes memory without asking: the decoded block, and what it is made from.
        super::probe(3 * expected)?;
        match self.compression {
            Compression::B44 | Compression::B44A if bytes.len() != expected => {
                self.b44(block, &bytes, expected)
            }
            Compression::DWAA(_) | Compression::DWAB(_) => {
                self.check_dwa(block, &bytes, expected)?;
                self.by_crate(block, bytes, expected)
            }
            Compression::Uncompressed
            | Compression::RLE
            | Compression::ZIP1
            | Compression::ZIP16
            | Compression::PIZ
            | Compression::PXR24
            | Compression::B44
            | Compression::B44A
            | Compression::HTJ2K32
            | Compression::HTJ2K256 => self.by_crate(block, bytes, expected),
        }
    }

    fn by_crate(
        &self,
        block: Rectangle,
        bytes: Vec<u8>,
        expected: usize,
    ) -> Result<Vec<u8>, ExrProblem> {
        let position = (
            self.start[0] + block.left as i32,
            self.start[1] + block.top as i32,
        );
        let size = (block.width as usize, block.height as usize);
        let decoded = if !self.is_sampled {
            let section = IntegerBounds::new(position, size);
            let header = &self.header;
            self.compression
                .decompress_image_section_from_le(header, bytes, section, false)?
        } else {
            self.sampled(position, size, bytes, expected)?
        };
        if decoded.len() != expected {
            return Err(damaged(
                "a block has another number of pixels than it should",
            ));
        }
        Ok(decoded)
    }

    /// A block with channels of fewer samples than pixels. The crate counts as many bytes for each pixel,
    /// and is told what makes its product right.
    fn sampled(
        &self,
        position: (i32, i32),
        size: (usize, usize),
        bytes: Vec<u8>,
        expected: usize,
    ) -> Result<Vec<u8>, ExrProblem> {
        let unsupported = |what: &str| {
            Err(ExrProblem::Unsupported(format!(
                "{what} are not supported; {WAY_OUT}"
            )))
        };
        if cfg!(target_endian = "big") {
            return unsupported("channels with fewer samples than pixels");
        }
        let mut header = self.header.clone();
        let section = match self.compression {
            // Bytes are bytes to these.
            Compression::Uncompressed
            | Compression::RLE
            | Compression::ZIP1
            | Compression::ZIP16 => {
                header.layer_size = Vec2(expected, 1);
                header.channels.bytes_per_pixel = 1;
                IntegerBounds::new((0, 0), (expected, 1))
            }
            Compression::PIZ
            | Compression::PXR24
            | Compression::B44
            | Compression::B44A
            | Compression::DWAA(_)
            | Compression::DWAB(_)
            | Compression::HTJ2K32
            | Compression::HTJ2K256 => {
                let pixels = size.0 * size.1;
                let fits = |channel: &Channel| {
                    size.0.is_multiple_of(channel.sampling[0] as usize)
                        && size.1.is_multiple_of(channel.sampling[1] as usize)
                };
                if !expected.is_multiple_of(pixels) || !self.channels.iter().all(fits) {
                    return unsupported("channels of this sampling in this compression");
                }
                header.channels.bytes_per_pixel = expected / pixels;
                IntegerBounds::new(position, size)
            }
        };
        let compression = self.compression;
        Ok(compression.decompress_image_section_from_le(&header, bytes, section, false)?)
    }

    fn b44(&self, block: Rectangle, bytes: &[u8], expected: usize) -> Result<Vec<u8>, ExrProblem> {
        let planes: Vec<Plane> = self
            .channels
            .iter()
            .map(|channel| {
                let lines = (block.top..block.top + block.height)
                    .filter(|&line| self.in_line(channel, block, line) > 0);
                let [x, _] = channel.sampling;
                let left = self.start[0] + block.left as i32;
                Plane {
                    size: [samples(left, block.width, x) as usize, lines.count()],
                    is_half: channel.kind == SampleKind::Half,
                    is_linear: channel.is_linear,
                }
            })
            .collect();
        let planes = b44::decode(&planes, bytes)?;
        let mut places = vec![0; planes.len()];
        let mut decoded = Vec::new();
        decoded
            .try_reserve_exact(expected)
            .map_err(|_| ExrProblem::NoMemory {
                bytes: expected as u64,
            })?;
        for line in block.top..block.top + block.height {
            let channels = self.channels.iter().zip(&planes).zip(&mut places);
            for ((channel, plane), place) in channels {
                let count = self.in_line(channel, block, line) * channel.kind.bytes();
                decoded.extend_from_slice(&plane[*place..*place + count]);
                *place += count;
            }
        }
        if cfg!(target_endian = "big") {
            return Err(ExrProblem::Unsupported(format!(
                "B44 is not supported on this machine; {WAY_OUT}"
            )));
        }
        Ok(decoded)
    }

    /// Holds the sizes at the start of a DWA block against the block's and against what its bytes can
    /// hold.
    ///
    /// The decoder asks for memory by them, without a check: a damaged one aborts the process.
    fn check_dwa(&self, block: Rectangle, bytes: &[u8], expected: usize) -> Result<(), ExrProblem> {
        /// Version, seven section sizes, counts of AC and DC coefficients, coder.
        const COUNTERS: usize = 11;
        if bytes.len() == expected {
            return Ok(());
        }
        let (counters, _) = bytes.as_chunks::<8>();
        let Some(counters) = counters.get(..COUNTERS) else {
            return Err(damaged("a DWA block ends in its head"));
        };
        let counter = |place: usize| u64::from_le_bytes(counters[place]);
        // Any square of eight by eight values is full, of 4 bytes each; run lengths can double them.
        let padded = u64::from(block.width.next_multiple_of(8))
            * u64::from(block.height.next_multiple_of(8));
        let largest = padded.saturating_mul(8 * self.channels.len() as u64);
        let claims = [
            // What is claimed, in bytes, and the bytes that it is made from, at their best.
            (counter(1), counter(2).saturating_mul(1032)),
            (
                counter(8).saturating_mul(2),
                counter(3).saturating_mul(1032),
            ),
            (
                counter(9).saturating_mul(2),
                counter(4).saturating_mul(1032),
            ),
            (counter(6), counter(5).saturating_mul(1032)),
            (counter(7), counter(6).saturating_mul(64)),
        ];
        let stored = (2..=5).map(counter).fold(0, u64::saturating_add);
        let is_too_much = |&(claimed, backed): &(u64, u64)| claimed > largest || claimed > backed;
        if stored > bytes.len() as u64 || claims.iter().any(is_too_much) {
            return Err(damaged("a DWA block claims more data than it has"));
        }
        Ok(())
    }
}

pub(super) fn description(channel: &Channel) -> ChannelDescription {
    ChannelDescription {
        name: Text::from_bytes_unchecked(channel.name.as_slice().into()),
        sample_type: match channel.kind {
            SampleKind::Uint => SampleType::U32,
            SampleKind::Half => SampleType::F16,
            SampleKind::Float => SampleType::F32,
        },
        quantize_linearly: channel.is_linear,
        sampling: Vec2(channel.sampling[0] as usize, channel.sampling[1] as usize),
    }
}

impl From<exr::error::Error> for ExrProblem {
    fn from(error: exr::error::Error) -> Self {
        use exr::error::Error;
        match error {
            // The crate reads from memory here: what is missing is missing in the block.
            Error::Io(_) => damaged("a block ends too early"),
            Error::NotSupported(reason) => Self::Unsupported(format!("{reason}; {WAY_OUT}")),
            Error::Invalid(reason) => Self::Damaged(reason.into_owned()),
            // Only callers of the crate make this one, and this one does not.
            Error::Aborted => damaged("reading was aborted"),
        }
    }
}
