//! Tiles: parts of an image that are rendered by themselves, by many machines perhaps, and merged to the bytes of the
//! whole.
//!
//! A tile is whole rows. It is cut where the renderer's own tiles and the file's blocks of lines are, so that its
//! samples are those of the whole image, and its blocks can be copied as they are.

use std::fmt;
use std::str::FromStr;

use sha2::{Digest, Sha256};

use super::{Compression, ExrOptions};
use crate::image::Window;
use crate::input::Hash;

/// Rows that the renderer works on together, counted from the top of what is rendered.
const RENDERED_TOGETHER: u32 = 16;

/// Which tile of how many: 3/16 is the fourth of sixteen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct TileNumber {
    index: u32,
    count: u32,
}

/// A tile of a part of an image, or of the whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Which.
    pub number: TileNumber,
    /// Of what.
    pub of: Window,
}

/// There are fewer rows than so many tiles need.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{number} is a tile of too many: {height} rows make {strips} strip{} of {lines} rows under compression {compression}, \
     and each tile has at least one; choose N of I/N from 1 to {strips}",
    if *strips == 1 { "" } else { "s" }
)]
pub struct TooManyTiles {
    number: TileNumber,
    height: u32,
    compression: Compression,
    lines: u32,
    strips: u32,
}

/// A text that is no [`TileNumber`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected I/N, tile I of N, with I from 0 to N - 1, such as 0/16")]
pub struct NoTileNumber;

impl TileNumber {
    /// Tile `index`, from 0, of `count`.
    ///
    /// # Errors
    /// If `index` is not below `count`.
    pub const fn new(index: u32, count: u32) -> Result<Self, NoTileNumber> {
        if index < count {
            Ok(Self { index, count })
        } else {
            Err(NoTileNumber)
        }
    }

    /// From 0, from the top.
    pub const fn index(self) -> u32 {
        self.index
    }

    /// How many there are.
    pub const fn count(self) -> u32 {
        self.count
    }
}

impl fmt::Display for TileNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

impl FromStr for TileNumber {
    type Err = NoTileNumber;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let number = |digits: &str| {
            let is_number = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
            is_number.then(|| digits.parse().ok()).flatten()
        };
        let (index, count) = text.split_once('/').ok_or(NoTileNumber)?;
        let numbers = number(index).zip(number(count)).ok_or(NoTileNumber)?;
        Self::new(numbers.0, numbers.1)
    }
}

impl Tile {
    /// Where it is. Of S strips of whole rows, cut from the top at multiples of the larger of 16 and the rows that
    /// `compression` takes together, tile I of N has those from ⌊I·S/N⌋ up to ⌊(I+1)·S/N⌋.
    ///
    /// # Errors
    /// If there are more tiles than strips.
    pub fn window(self, compression: Compression) -> Result<Window, TooManyTiles> {
        let lines = ExrOptions {
            compression,
            ..ExrOptions::default()
        };
        let lines = RENDERED_TOGETHER.max(lines.lines_per_block() as u32);
        let Self { number, of } = self;
        let strips = of.height.div_ceil(lines);
        if number.count > strips {
            return Err(TooManyTiles {
                number,
                height: of.height,
                compression,
                lines,
                strips,
            });
        }
        // At most the height and the strip that is cut off.
        let row = |index: u32| {
            let strip = u64::from(index) * u64::from(strips) / u64::from(number.count);
            (strip * u64::from(lines)).min(of.height.into()) as u32
        };
        let (top, bottom) = (row(number.index), row(number.index + 1));
        Ok(Window {
            y: of.y + top,
            height: bottom - top,
            ..of
        })
    }
}

/// Which tile a file is, as text: `3/16`.
pub(super) const TILE: &str = "candela:tile";

/// What it is a tile of: the data window of the merged file, as that is written.
pub(super) const TILE_WINDOW: &str = "candela:tile_window";

/// The hash of a tile, see [`TileHash`].
pub(super) const TILE_HASH: &str = "candela:tile_sha256";

/// All that only a tile has.
pub(crate) const TILE_ATTRIBUTES: [&str; 3] = [TILE, TILE_WINDOW, TILE_HASH];

/// What stands for a hash that is not known yet.
pub(super) const NO_HASH: [u8; 64] = [b'0'; 64];

/// The hash by which a tile that was damaged on its way is found, whatever its compression: SHA-256 of the hashes, 32
/// bytes each, of its head with 64 zeros in place of this hash, and of its blocks from the top, each with its place
/// and its length.
pub(super) struct TileHash(Sha256);

/// The hash of a block, or of a head.
pub(super) type BlockHash = [u8; 32];

/// The hash of a block with its place and its length.
pub(super) fn block_hash(block: &[u8]) -> BlockHash {
    Sha256::digest(block).into()
}

impl TileHash {
    /// Of a tile whose head has this hash.
    pub(super) fn new(head: BlockHash) -> Self {
        Self(Sha256::new_with_prefix(head))
    }

    /// With all blocks: 64 hexadecimal digits.
    pub(super) fn finish(self, blocks: &[BlockHash]) -> String {
        let Self(mut hash) = self;
        for block in blocks {
            hash.update(block);
        }
        Hash::finished(hash).to_string()
    }
}

/// Where in a head the digits of [`TILE_HASH`] are, if they are there.
pub(super) fn hash_place(head: &[u8]) -> Option<usize> {
    let length = (NO_HASH.len() as u32).to_le_bytes();
    let start = [TILE_HASH.as_bytes(), b"\0string\0", &length].concat();
    let place = head.windows(start.len()).position(|bytes| bytes == start)?;
    Some(place + start.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_read_as_they_are_written() {
        for text in ["0/1", "3/16", "15/16", "4294967294/4294967295"] {
            let number: TileNumber = text.parse().unwrap();
            assert_eq!(number.to_string(), text);
        }
        for text in [
            "",
            "/",
            "3",
            "3/",
            "/16",
            "16/16",
            "17/16",
            "0/0",
            "-1/16",
            "+1/16",
            "1/ 16",
            "1/2/3",
            "a/b",
            "1.0/2",
            "0/4294967296",
            "3of16",
        ] {
            assert_eq!(text.parse::<TileNumber>(), Err(NoTileNumber), "{text}");
        }
    }

    /// All tiles together are the window, none is empty, and each begins at a strip.
    #[test]
    fn tiles_are_the_window() {
        for compression in Compression::ALL {
            let lines = match compression {
                Compression::Dwab => 256,
                Compression::Piz | Compression::Dwaa => 32,
                Compression::None
                | Compression::Rle
                | Compression::Zips
                | Compression::Zip
                | Compression::Pxr24 => 16,
            };
            for height in [1, 15, 16, 17, 256, 257, 1080, 2160] {
                let of = Window {
                    x: 3,
                    y: 5,
                    width: 7,
                    height,
                };
                let strips = height.div_ceil(lines);
                for count in [1, 2, 3, 7, strips].into_iter().filter(|&n| n <= strips) {
                    let mut next = of.y;
                    for index in 0..count {
                        let number = TileNumber::new(index, count).unwrap();
                        let window = Tile { number, of }.window(compression).unwrap();
                        assert_eq!((window.x, window.width, window.y), (3, 7, next));
                        assert_eq!((window.y - of.y) % lines, 0);
                        assert!(window.height > 0);
                        next += window.height;
                    }
                    assert_eq!(next, of.y + of.height);
                }
                let number = TileNumber::new(0, strips + 1).unwrap();
                let message = Tile { number, of }.window(compression).unwrap_err();
                let message = message.to_string();
                assert!(
                    message.contains(&format!("make {strips} strip")),
                    "{message}"
                );
                assert!(message.contains(&format!("of {lines} rows")), "{message}");
            }
        }
    }

    /// Tile 3 of 16 of a 1080p image: 68 strips, those from ⌊3·68/16⌋ = 12 up to ⌊4·68/16⌋ = 17.
    #[test]
    fn a_tile_by_hand() {
        let tile = Tile {
            number: TileNumber::new(3, 16).unwrap(),
            of: Window::whole([1920, 1080]),
        };
        let window = tile.window(Compression::Zip).unwrap();
        assert_eq!((window.y, window.height), (192, 80));
    }
}
