//! A file as it is stored, for whoever writes it again with some of its channels changed: attributes byte by byte, and
//! blocks of lines.

use std::borrow::Cow;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use exr::meta::BlockDescription;
use exr::meta::attribute::{Compression, LineOrder, Text};
use exr::meta::header::Header;

use super::blocks::Blocks;
use super::codec;
use super::color::ColorTag;
use super::header::{Channel, Headers, SampleKind};
use super::layers::{Shape, Shown};
use super::source::{Cursor, MAGIC, Source};
use super::{ExrError, ExrProblem};
use crate::input::Hash;

/// The most attributes of a header: writers have some dozens.
const MAX_ATTRIBUTES: usize = 1 << 12;

/// An OpenEXR file of one part of scan lines that is open.
#[derive(Debug)]
pub(crate) struct StoredExr {
    path: PathBuf,
    /// The version field, flags among it.
    version: u32,
    attributes: Vec<Attribute>,
    channels: Vec<Channel>,
    /// The names of the channels.
    names: Vec<String>,
    color: ColorTag,
    compression: Compression,
    blocks: Blocks,
}

/// An attribute of a header.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Attribute {
    pub(crate) name: Vec<u8>,
    /// The name of its type.
    pub(crate) kind: Vec<u8>,
    pub(crate) value: Vec<u8>,
}

impl StoredExr {
    /// Opens a file, or a pipe or device, which is read into memory. `-` is standard input.
    ///
    /// # Errors
    /// See [`ExrProblem`]; parts, tiles and channels of fewer samples than pixels are not supported here.
    pub(crate) fn open(path: &Path) -> Result<Self, ExrError> {
        let opened = Source::open(path).and_then(|source| Self::new(path, source));
        opened.map_err(|problem| ExrError {
            path: path.to_path_buf(),
            problem,
        })
    }

    fn new(path: &Path, source: Source) -> Result<Self, ExrProblem> {
        let headers = Headers::read(&source)?;
        let unsupported = |what: &str| Err(ExrProblem::Unsupported(what.to_owned()));
        let part = &headers.parts[0];
        if headers.is_multi_part {
            return unsupported("it has parts; save it as a file of one part first");
        }
        if part.is_deep {
            return Err(super::deep());
        }
        if part.tiles.is_some() {
            return unsupported(
                "it has tiles; save it in scan lines first, as by `oiiotool in.exr --scanline -o out.exr`",
            );
        }
        if part
            .channels
            .iter()
            .any(|channel| channel.sampling != [1, 1])
        {
            return unsupported(
                "it has channels of fewer samples than pixels; save it as R, G and B first",
            );
        }
        let (version, attributes) = attributes(&source)?;
        let compression = match codec::compression(part.compression)? {
            Compression::DWAA(_) => Compression::DWAA(dwa_level(&attributes)),
            Compression::DWAB(_) => Compression::DWAB(dwa_level(&attributes)),
            other => other,
        };
        let shown = Shown {
            part: 0,
            channels: Shape::Single(0),
            alpha: None,
        };
        let names = part.channels.iter();
        let names = names.map(|channel| String::from_utf8_lossy(&channel.name).into_owned());
        Ok(Self {
            path: path.to_path_buf(),
            version,
            attributes,
            names: names.collect(),
            channels: part.channels.clone(),
            color: part.color.clone(),
            compression,
            blocks: Blocks::new(Arc::new(source), &headers, shown, [0.0; 3])?,
        })
    }

    /// All attributes, in the order of the file.
    pub(crate) fn attributes(&self) -> &[Attribute] {
        &self.attributes
    }

    /// The version field, flags among it.
    pub(in crate::exr) const fn version(&self) -> u32 {
        self.version
    }

    /// The length of the file in bytes, when it was opened.
    pub(in crate::exr) fn length(&self) -> u64 {
        self.blocks.source.length()
    }

    /// The text of an attribute, if it is there.
    pub(crate) fn text(&self, name: &str) -> Option<Cow<'_, str>> {
        let is_named = |attribute: &&Attribute| attribute.name == name.as_bytes();
        let attribute = self.attributes.iter().find(is_named)?;
        (attribute.kind == b"string").then(|| String::from_utf8_lossy(&attribute.value))
    }

    /// The names of all channels, in the order of the file.
    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// The type of a channel's values.
    pub(crate) fn kind(&self, channel: usize) -> SampleKind {
        self.channels[channel].kind
    }

    /// What the file says about the color space.
    pub(crate) const fn color(&self) -> &ColorTag {
        &self.color
    }

    /// Width and height of the display window.
    pub(crate) const fn resolution(&self) -> [u32; 2] {
        self.blocks.geometry.resolution
    }

    /// Width and height of the data window.
    pub(crate) const fn size(&self) -> [u32; 2] {
        self.blocks.geometry.size
    }

    /// How it is compressed, where candela writes such files.
    pub(in crate::exr) const fn compression(&self) -> Option<crate::exr::Compression> {
        use crate::exr::Compression as Ours;
        match self.compression {
            Compression::Uncompressed => Some(Ours::None),
            Compression::RLE => Some(Ours::Rle),
            Compression::ZIP1 => Some(Ours::Zips),
            Compression::ZIP16 => Some(Ours::Zip),
            Compression::PIZ => Some(Ours::Piz),
            Compression::PXR24 => Some(Ours::Pxr24),
            Compression::DWAA(_) => Some(Ours::Dwaa),
            Compression::DWAB(_) => Some(Ours::Dwab),
            Compression::B44 | Compression::B44A | Compression::HTJ2K32 | Compression::HTJ2K256 => {
                None
            }
        }
    }

    /// How many blocks of lines there are.
    pub(crate) const fn blocks(&self) -> usize {
        self.blocks.geometry.blocks[1] as usize
    }

    /// Bytes of a block that is not cut off, before compression.
    pub(crate) fn block_bytes(&self) -> u64 {
        self.blocks.block_bytes()
    }

    /// A block as it is before compression, native-endian: line by line, in each line channel by channel in the
    /// order of the file.
    ///
    /// # Errors
    /// See [`ExrProblem`].
    pub(crate) fn lines(&self, block: usize) -> Result<Vec<u8>, ExrError> {
        // As many as the height has, which is an u32.
        let lines = self.blocks.lines(block as u32);
        lines.map_err(|problem| self.error(problem))
    }

    /// A block as the file has it, with its place and its length before it.
    ///
    /// # Errors
    /// See [`ExrProblem`]; it is not decoded.
    pub(in crate::exr) fn packed(&self, block: usize) -> Result<Vec<u8>, ExrError> {
        // As many as the height has, which is an u32.
        let packed = self.blocks.packed(block as u32);
        packed.map_err(|problem| self.error(problem))
    }

    /// How far a stored value is from what it was before, relatively, at most: by rounding alone, or by
    /// [PXR24](super::super::Compression::Pxr24). `None` where compression has no such bound.
    pub(crate) fn rounding(&self, channel: usize) -> Option<f64> {
        let rounding = match self.kind(channel) {
            SampleKind::Uint => 0.0,
            // 11 and 24 significant bits.
            SampleKind::Half => 0.5_f64.powi(11),
            SampleKind::Float => 0.5_f64.powi(24),
        };
        match self.compression {
            Compression::Uncompressed
            | Compression::RLE
            | Compression::ZIP1
            | Compression::ZIP16
            | Compression::PIZ => Some(rounding),
            Compression::PXR24 => Some(match self.kind(channel) {
                SampleKind::Uint | SampleKind::Half => rounding,
                // 16 significant bits are left.
                SampleKind::Float => 0.5_f64.powi(16),
            }),
            Compression::B44
            | Compression::B44A
            | Compression::DWAA(_)
            | Compression::DWAB(_)
            | Compression::HTJ2K32
            | Compression::HTJ2K256 => None,
        }
    }

    /// The hash of the whole file.
    ///
    /// # Errors
    /// If it cannot be read.
    pub(crate) fn hash(&self) -> Result<Hash, ExrError> {
        let hashed = self.blocks.source.hash();
        hashed.map_err(|problem| self.error(problem))
    }

    /// The first line of the data window.
    pub(in crate::exr) const fn top(&self) -> i32 {
        self.blocks.geometry.start[1]
    }

    /// Lines of a block that is not cut off.
    pub(crate) const fn lines_per_block(&self) -> u32 {
        self.blocks.geometry.block[1]
    }

    /// What the `exr` crate needs to know to compress blocks of these channels.
    pub(in crate::exr) fn header(&self, kept: &[usize]) -> Header {
        let list = || {
            kept.iter()
                .map(|&kept| codec::description(&self.channels[kept]))
        };
        let size = self.size().map(|side| side as usize);
        let mut header = Header::new(Text::from(""), (size[0], size[1]), list().collect())
            .with_encoding(
                self.compression,
                BlockDescription::ScanLines,
                LineOrder::Increasing,
            );
        // In the order of the file, which the crate would sort.
        header.channels.list = list().collect();
        header
    }

    /// The value of the attribute `channels` for these channels: name, type, whether linear, sampling.
    pub(in crate::exr) fn channel_list(&self, kept: &[usize]) -> Vec<u8> {
        let mut list = Vec::new();
        for channel in kept.iter().map(|&kept| &self.channels[kept]) {
            list.extend(&channel.name);
            list.push(0);
            let kind: u32 = match channel.kind {
                SampleKind::Uint => 0,
                SampleKind::Half => 1,
                SampleKind::Float => 2,
            };
            list.extend(kind.to_le_bytes());
            list.extend([u8::from(channel.is_linear), 0, 0, 0]);
            let sampling = channel.sampling.iter();
            list.extend(sampling.flat_map(|step| step.to_le_bytes()));
        }
        list.push(0);
        list
    }

    fn error(&self, problem: ExrProblem) -> ExrError {
        ExrError {
            path: self.path.clone(),
            problem,
        }
    }
}

/// The attributes of a head in memory.
pub(in crate::exr) fn attributes_of(head: Vec<u8>) -> Result<Vec<Attribute>, ExrProblem> {
    attributes(&Source::of_memory(head)).map(|(_, attributes)| attributes)
}

/// The version field and the attributes of a header that was found to be sound.
fn attributes(source: &Source) -> Result<(u32, Vec<Attribute>), ExrProblem> {
    let mut cursor = Cursor::new(source);
    cursor.skip(MAGIC.len() as u64)?;
    let version = u32::from_le_bytes(cursor.array()?);
    let mut attributes: Vec<Attribute> = Vec::new();
    loop {
        let name = cursor.text()?;
        if name.is_empty() {
            return Ok((version, attributes));
        }
        if attributes.len() == MAX_ATTRIBUTES {
            return Err(ExrProblem::Unsupported(format!(
                "it has more than {MAX_ATTRIBUTES} attributes"
            )));
        }
        if attributes.iter().any(|attribute| attribute.name == name) {
            return Err(super::damaged("two of its attributes have one name"));
        }
        let kind = cursor.text()?;
        let size = i32::from_le_bytes(cursor.array()?);
        let size = usize::try_from(size)
            .map_err(|_| super::damaged("an attribute has a negative size"))?;
        let value = cursor.bytes(size)?;
        attributes.push(Attribute { name, kind, value });
    }
}

/// The level that DWA compresses at, if the file says one.
fn dwa_level(attributes: &[Attribute]) -> Option<f32> {
    let mut attributes = attributes.iter();
    let level = attributes.find(|attribute| attribute.name == b"dwaCompressionLevel")?;
    let bytes = level.value.as_slice().try_into().ok()?;
    Some(f32::from_le_bytes(bytes)).filter(|level| level.is_finite() && *level >= 0.0)
}
