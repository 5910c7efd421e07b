//! The headers of an OpenEXR file: what each of its parts is.
//!
//! Only what is needed to show a picture is kept; other attributes, previews among them, are passed over
//! unread. Layout: "OpenEXR File Layout", <https://openexr.com/en/latest/OpenEXRFileLayout.html>

use super::source::{Cursor, MAGIC, Source};
use super::{ColorTag, ExrProblem, damaged};
use crate::color::Primaries;
use crate::exr::COLOR_INTEROP_ID;
use crate::printable::printable_bytes;

/// Flags in the version field.
const TILED: u32 = 1 << 9;
const LONG_NAMES: u32 = 1 << 10;
const DEEP: u32 = 1 << 11;
const MULTI_PART: u32 = 1 << 12;

/// The most that channel lists of all parts may take, in bytes: some 200 000 channels.
const MAX_CHANNEL_LISTS: usize = 1 << 22;

/// The most parts; each takes some hundred bytes of memory.
const MAX_PARTS: usize = 1 << 14;

/// As much of a text of an attribute is kept.
const MAX_TEXT: usize = 1 << 12;

/// Coordinates of windows are within ±2³⁰, as in OpenEXR itself.
const FARTHEST: i32 = 1 << 30;

/// What a file begins with.
#[derive(Debug)]
pub(super) struct Headers {
    pub(super) parts: Vec<Part>,
    /// Whether chunks begin with the number of their part.
    pub(super) is_multi_part: bool,
    /// Where the offset tables start.
    pub(super) end: u64,
}

/// One picture of a file.
#[derive(Debug)]
pub(super) struct Part {
    /// The attribute `name`; empty where there is none.
    pub(super) name: Vec<u8>,
    pub(super) channels: Vec<Channel>,
    pub(super) compression: u8,
    /// The corners, both inside: left, top, right, bottom.
    pub(super) data_window: [i32; 4],
    pub(super) display_window: [i32; 4],
    pub(super) pixel_aspect: f32,
    pub(super) tiles: Option<Tiles>,
    pub(super) is_deep: bool,
    /// The attribute `chunkCount`.
    pub(super) chunk_count: Option<u64>,
    pub(super) color: ColorTag,
}

/// How a part is cut into tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Tiles {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) levels: Levels,
    /// Whether sizes of levels are rounded up.
    pub(super) rounds_up: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Levels {
    One,
    MipMap,
    RipMap,
}

/// A channel of a part.
#[derive(Clone, Debug)]
pub(super) struct Channel {
    /// The whole name, UTF-8 by the rules.
    pub(super) name: Vec<u8>,
    pub(super) kind: SampleKind,
    /// Whether differences count to the eye, not ratios: the attribute pLinear.
    pub(super) is_linear: bool,
    /// A sample for so many columns and rows.
    pub(super) sampling: [u32; 2],
}

/// The type of a channel's values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SampleKind {
    Uint,
    Half,
    Float,
}

impl SampleKind {
    /// Bytes of a value.
    pub(crate) const fn bytes(self) -> usize {
        match self {
            Self::Half => 2,
            Self::Uint | Self::Float => 4,
        }
    }
}

impl Headers {
    /// The headers of all parts.
    pub(super) fn read(source: &Source) -> Result<Self, ExrProblem> {
        let mut cursor = Cursor::new(source);
        if source.length() < MAGIC.len() as u64 || cursor.array()? != MAGIC {
            return Err(ExrProblem::NotExr);
        }
        let version = u32::from_le_bytes(cursor.array()?);
        let number = version & 0xff;
        if !(1..=2).contains(&number) {
            return Err(ExrProblem::Unsupported(format!(
                "it has version {number} of the format, and 2 is the newest that is known"
            )));
        }
        let unknown = version & !(0xff | TILED | LONG_NAMES | DEEP | MULTI_PART);
        if unknown != 0 {
            return Err(ExrProblem::Unsupported(format!(
                "it uses features newer than OpenEXR 3.4 (flags {unknown:#x})"
            )));
        }
        let is_multi_part = version & MULTI_PART != 0;
        let mut room = MAX_CHANNEL_LISTS;
        let mut parts: Vec<Part> = Vec::new();
        loop {
            let mut raw = Attributes::default();
            let is_there = raw.read(&mut cursor, &mut room)?;
            // Headers of many parts end with an empty one.
            if is_multi_part && !is_there && !parts.is_empty() {
                break;
            }
            if parts.len() == MAX_PARTS {
                return Err(ExrProblem::Unsupported(format!(
                    "it has more than {MAX_PARTS} parts"
                )));
            }
            let mut part = raw.part(version)?;
            // Attributes of the picture as a whole may be in the first part alone.
            if let Some(first) = parts.first()
                && part.color == ColorTag::default()
            {
                part.color = first.color.clone();
            }
            parts.push(part);
            if !is_multi_part {
                break;
            }
        }
        Ok(Self {
            parts,
            is_multi_part,
            end: cursor.place(),
        })
    }
}

/// The attributes of a header, as far as they matter.
#[derive(Default)]
struct Attributes {
    name: Vec<u8>,
    kind: Vec<u8>,
    channels: Option<Vec<Channel>>,
    compression: Option<u8>,
    data_window: Option<[i32; 4]>,
    display_window: Option<[i32; 4]>,
    pixel_aspect: Option<f32>,
    tiles: Option<Tiles>,
    chunk_count: Option<u64>,
    color: ColorTag,
}

impl Attributes {
    /// Reads a header up to its end; whether there was any attribute.
    fn read(&mut self, cursor: &mut Cursor<'_>, room: &mut usize) -> Result<bool, ExrProblem> {
        let mut is_there = false;
        loop {
            let name = cursor.text()?;
            if name.is_empty() {
                return Ok(is_there);
            }
            is_there = true;
            let kind = cursor.text()?;
            let size = i32::from_le_bytes(cursor.array()?);
            let size = usize::try_from(size).map_err(|_| wrong(&name))?;
            match (name.as_slice(), kind.as_slice()) {
                (b"channels", b"chlist") => {
                    cursor.check(size)?;
                    *room = room.checked_sub(size).ok_or_else(|| {
                        ExrProblem::Unsupported("it has hundreds of thousands of channels".into())
                    })?;
                    self.channels = Some(channels(&cursor.bytes(size)?)?);
                }
                (b"compression", b"compression") => {
                    let [byte] = value(cursor, &name, size)?;
                    self.compression = Some(byte);
                }
                (b"dataWindow", b"box2i") => {
                    self.data_window = Some(window(&value::<16>(cursor, &name, size)?));
                }
                (b"displayWindow", b"box2i") => {
                    self.display_window = Some(window(&value::<16>(cursor, &name, size)?));
                }
                (b"pixelAspectRatio", b"float") => {
                    self.pixel_aspect = Some(f32::from_le_bytes(value(cursor, &name, size)?));
                }
                (b"tiles", b"tiledesc") => {
                    self.tiles = Some(tiles(value(cursor, &name, size)?)?);
                }
                (b"chunkCount", b"int") => {
                    let count = i32::from_le_bytes(value(cursor, &name, size)?);
                    self.chunk_count = Some(u64::try_from(count).map_err(|_| wrong(&name))?);
                }
                (b"chromaticities", b"chromaticities") => {
                    let bytes = value::<32>(cursor, &name, size)?;
                    let (numbers, _) = bytes.as_chunks::<4>();
                    let [rx, ry, gx, gy, bx, by, wx, wy] =
                        std::array::from_fn(|i| f64::from(f32::from_le_bytes(numbers[i])));
                    self.color.chromaticities = Some(Primaries {
                        red: [rx, ry],
                        green: [gx, gy],
                        blue: [bx, by],
                        white: [wx, wy],
                    });
                }
                (b"name", b"string") if size <= MAX_TEXT => self.name = cursor.bytes(size)?,
                (b"type", b"string") if size <= MAX_TEXT => self.kind = cursor.bytes(size)?,
                (id, b"string") if id == COLOR_INTEROP_ID.as_bytes() => {
                    let id = cursor.bytes(size.min(MAX_TEXT))?;
                    cursor.skip(size.saturating_sub(MAX_TEXT) as u64)?;
                    // Strings have a length; some writers end them with a zero as well.
                    let id = String::from_utf8_lossy(&id);
                    let id = id.trim_end_matches('\0');
                    self.color.interop_id = (!id.is_empty()).then(|| id.to_owned());
                }
                _ => cursor.skip(size as u64)?,
            }
        }
    }

    fn part(self, version: u32) -> Result<Part, ExrProblem> {
        let missing = |name: &str| damaged(&format!("it has no attribute `{name}`"));
        let is_tiled = match self.kind.as_slice() {
            b"scanlineimage" | b"deepscanline" => false,
            b"tiledimage" | b"deeptile" => true,
            b"" => version & TILED != 0 && version & MULTI_PART == 0,
            other => {
                return Err(ExrProblem::Unsupported(format!(
                    "it has a part of the unknown type `{}`",
                    printable_bytes(other)
                )));
            }
        };
        let is_deep = matches!(self.kind.as_slice(), b"deepscanline" | b"deeptile")
            || (version & DEEP != 0 && version & MULTI_PART == 0);
        let tiles = match self.tiles {
            _ if !is_tiled => None,
            Some(tiles) => Some(tiles),
            None => return Err(missing("tiles")),
        };
        let inside = |name: &str, window: [i32; 4]| {
            let [left, top, right, bottom] = window;
            if left > right || top > bottom {
                return Err(damaged(&format!(
                    "its {name} is turned around: from ({left}, {top}) to ({right}, {bottom})"
                )));
            }
            if window
                .iter()
                .any(|side| !(-FARTHEST..=FARTHEST).contains(side))
            {
                return Err(damaged(&format!(
                    "its {name} is beyond the limits of OpenEXR"
                )));
            }
            Ok(window)
        };
        let data_window = self.data_window.ok_or_else(|| missing("dataWindow"))?;
        let display_window = self
            .display_window
            .ok_or_else(|| missing("displayWindow"))?;
        Ok(Part {
            name: self.name,
            channels: self.channels.ok_or_else(|| missing("channels"))?,
            compression: self.compression.ok_or_else(|| missing("compression"))?,
            data_window: inside("data window", data_window)?,
            display_window: inside("display window", display_window)?,
            pixel_aspect: self.pixel_aspect.unwrap_or(1.0),
            tiles,
            is_deep,
            chunk_count: self.chunk_count,
            color: self.color,
        })
    }
}

fn wrong(name: &[u8]) -> ExrProblem {
    let name = printable_bytes(name);
    damaged(&format!("its attribute `{name}` has a wrong size"))
}

/// The value of an attribute whose size is known.
fn value<const N: usize>(
    cursor: &mut Cursor<'_>,
    name: &[u8],
    size: usize,
) -> Result<[u8; N], ExrProblem> {
    if size != N {
        return Err(wrong(name));
    }
    cursor.array()
}

fn window(bytes: &[u8; 16]) -> [i32; 4] {
    let (numbers, _) = bytes.as_chunks::<4>();
    std::array::from_fn(|i| i32::from_le_bytes(numbers[i]))
}

fn tiles(bytes: [u8; 9]) -> Result<Tiles, ExrProblem> {
    let [w0, w1, w2, w3, h0, h1, h2, h3, mode] = bytes;
    let side = |bytes| {
        let side = u32::from_le_bytes(bytes);
        let is_legal = (1..=FARTHEST as u32).contains(&side);
        is_legal
            .then_some(side)
            .ok_or_else(|| damaged("its tiles have no legal size"))
    };
    Ok(Tiles {
        width: side([w0, w1, w2, w3])?,
        height: side([h0, h1, h2, h3])?,
        levels: match mode & 0x0f {
            0 => Levels::One,
            1 => Levels::MipMap,
            2 => Levels::RipMap,
            _ => return Err(damaged("its tiles have unknown levels")),
        },
        rounds_up: match mode >> 4 {
            0 => false,
            1 => true,
            _ => return Err(damaged("its levels have an unknown rounding")),
        },
    })
}

/// Reads a list of channels: name, type, whether linear, sampling.
fn channels(mut bytes: &[u8]) -> Result<Vec<Channel>, ExrProblem> {
    let broken = || damaged("its list of channels is broken");
    let mut channels = Vec::new();
    loop {
        let end = bytes
            .iter()
            .position(|&byte| byte == 0)
            .ok_or_else(broken)?;
        let (name, rest) = bytes.split_at(end);
        if name.is_empty() {
            break;
        }
        let (numbers, rest) = rest[1..].split_first_chunk::<16>().ok_or_else(broken)?;
        bytes = rest;
        let (numbers, _) = numbers.as_chunks::<4>();
        let sampling = |bytes| {
            let sampling = u32::from_le_bytes(bytes);
            let is_legal = (1..=FARTHEST as u32).contains(&sampling);
            is_legal.then_some(sampling).ok_or_else(broken)
        };
        channels.push(Channel {
            name: name.to_vec(),
            kind: match u32::from_le_bytes(numbers[0]) {
                0 => SampleKind::Uint,
                1 => SampleKind::Half,
                2 => SampleKind::Float,
                _ => return Err(broken()),
            },
            is_linear: numbers[1][0] != 0,
            sampling: [sampling(numbers[2])?, sampling(numbers[3])?],
        });
    }
    if channels.is_empty() {
        return Err(damaged("it has no channels"));
    }
    Ok(channels)
}
