//! OpenEXR out and in.

mod file;
mod head;
mod merge;
mod ordered;
mod planes;
mod preserve;
mod read;
mod rewrite;
mod store;
mod tile;
mod whole;
mod write;
mod zip;

use std::fmt;
use std::str::FromStr;

pub(crate) use file::{ExrFile, Packer};
pub use merge::{MergeError, MergeReport, merge};
#[doc(hidden)]
pub use planes::write_planes;
#[doc(hidden)]
pub use read::{
    ChannelName, ColorMeaning, ColorTag, Content, DataWindow, ExrChannels, ExrLayers, ExrReader,
};
pub use read::{ExrError, ExrImage, ExrProblem, read};
pub(crate) use read::{SampleKind, StoredExr};
pub(crate) use rewrite::{COPIES_OF_BLOCK, RewriteError, Rewritten, rewrite};
pub(crate) use tile::TILE_ATTRIBUTES;
pub use tile::{NoTileNumber, Tile, TileNumber, TooManyTiles};
pub(crate) use whole::is_whole;

use crate::image::{Channel, ChannelKind, Channels, Window};

/// How a film is stored as OpenEXR.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ExrOptions {
    /// The type of every channel that holds light; others are always FLOAT. Default:
    /// [`Precision::Float`].
    pub precision: Precision,
    /// Default: [`Compression::Zip`].
    pub compression: Compression,
    /// Whether a `chromaticities` attribute goes beside `colorInteropID` in Rec.709, too, where readers that do not know
    /// the latter take it for granted. In other spaces it is there in any case. Default: no.
    pub chromaticities: bool,
    /// Whether a part of an image is written with a data window of the whole image, for readers that lose its place:
    /// outside of the part nothing is hit, and there is no light. Default: no.
    pub full_window: bool,
    /// Which tile this is, if it is one: the header says so, for [`merge`](merge()). The film's window is then
    /// [`Tile::window`]. Default: none.
    pub tile: Option<Tile>,
}

impl ExrOptions {
    /// The lines that are compressed together.
    pub(crate) fn lines_per_block(&self) -> usize {
        exr::meta::attribute::Compression::from(self.compression).scan_lines_per_block()
    }

    /// Whether the format can hold an image of this window with these channels beside R, G, B, A.
    ///
    /// # Errors
    /// Where the blocks of lines that are compressed together are too large, as thousands of
    /// columns with hundreds of channels are under the compressions of 32 lines and more; and where numbers that stand
    /// for names would lose digits; and where the window is not that of [`ExrOptions::tile`].
    pub fn check(&self, window: Window, channels: &Channels) -> Result<(), ExrOptionsError> {
        let is_matte = |channel: &Channel| match channel.kind {
            ChannelKind::Matte => true,
            ChannelKind::Light | ChannelKind::Relative | ChannelKind::Data => false,
        };
        if channels.list.iter().any(is_matte) && !self.compression.is_lossless(Precision::Float) {
            return Err(ExrOptionsError::LossyMattes(self.compression));
        }
        if let Some(tile) = self.tile
            && tile.window(self.compression) != Ok(window)
        {
            return Err(ExrOptionsError::NotTheTile(tile.number));
        }
        let bytes = |precision: Precision| precision.bytes() as u64;
        let further = channels.list.iter().map(|channel| match channel.kind {
            ChannelKind::Light | ChannelKind::Relative => bytes(self.precision),
            ChannelKind::Data | ChannelKind::Matte => bytes(Precision::Float),
        });
        let pixel: u64 = 4 * bytes(self.precision) + further.sum::<u64>();
        let block = |compression: Compression| {
            let compression = exr::meta::attribute::Compression::from(compression);
            let lines = u64::from(window.height).min(compression.scan_lines_per_block() as u64);
            pixel * u64::from(window.width) * lines
        };
        let fits = |compression| i32::try_from(block(compression)).is_ok();
        if fits(self.compression) {
            return Ok(());
        }
        let others = [Compression::Zip, Compression::Zips];
        Err(ExrOptionsError::LargeBlocks(LargeBlocks {
            compression: self.compression,
            gigabytes: block(self.compression) as f64 / 1e9,
            other: others.into_iter().find(|&other| fits(other)),
        }))
    }
}

/// A file cannot be written like that.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExrOptionsError {
    /// Its blocks would be too large.
    #[error(transparent)]
    LargeBlocks(LargeBlocks),
    /// Numbers that stand for names would be others.
    #[error(
        "compression {0} loses digits, and the ids of a Cryptomatte would be others; choose zip, zips, piz, rle or \
         none, or leave the layer `cryptomatte` out"
    )]
    LossyMattes(Compression),
    /// The window is not where the tile is.
    #[error("the window that is rendered is not that of tile {0}; take the one of `Tile::window`")]
    NotTheTile(TileNumber),
}

/// So many channels do not fit the blocks of a compression.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "compression {compression} would make blocks of {gigabytes:.1} GB of so many channels, where \
     OpenEXR's limit is 2.1 GB; {}render the image in parts with --crop",
    .other.map_or_else(String::new, |other| format!("choose {other}, or "))
)]
#[doc(hidden)]
pub struct LargeBlocks {
    compression: Compression,
    gigabytes: f64,
    /// One that they do fit.
    other: Option<Compression>,
}

/// What was written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ExrReport {
    /// Values beyond ±65 504, stored as that; always 0 with [`Precision::Float`].
    pub clamped_to_half: u64,
    /// Values of light beside R, G, B, A that are not 0 but below the smallest normal half, 6.1e-5,
    /// where it has fewer digits; always 0 with [`Precision::Float`].
    pub small_in_half: u64,
    /// How far the sums of layers that are R, G and B are off these at most, in cd/m²: `candela:residual`. 0 where there
    /// are none.
    pub residual: f64,
    /// The file's length in bytes.
    pub bytes: u64,
}

/// The type of a channel's values.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 32 bits (FLOAT): the film's own values.
    #[default]
    Float,
    /// 16 bits (HALF): 11 significant bits, up to 65 504.
    Half,
}

impl Precision {
    /// Bytes of a value.
    pub(crate) const fn bytes(self) -> usize {
        match self {
            Self::Float => size_of::<f32>(),
            Self::Half => size_of::<half::f16>(),
        }
    }
}

/// What of a file is still in memory once it is written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Preserve {
    /// Nothing.
    #[default]
    Nothing,
    /// What the file shows: R, G, B and A as whoever reads it finds them, 16 bytes for each pixel.
    Image,
}

/// How the pixels are compressed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Compression {
    /// Not at all.
    None,
    /// Run lengths; lossless.
    Rle,
    /// Deflate, each line by itself; lossless.
    Zips,
    /// Deflate, blocks of 16 lines; lossless.
    #[default]
    Zip,
    /// Wavelets, blocks of 32 lines; lossless, for grainy images.
    Piz,
    /// Deflate on 24 bits; lossless with HALF, relative error up to 2⁻¹⁶ with FLOAT.
    Pxr24,
    /// DCT as in JPEG, blocks of 32 lines; lossy, at the standard level 45.
    Dwaa,
    /// DCT as in JPEG, blocks of 256 lines; lossy, at the standard level 45.
    Dwab,
}

impl Compression {
    /// Every compression, in the order of the documentation.
    pub const ALL: [Self; 8] = [
        Self::None,
        Self::Rle,
        Self::Zips,
        Self::Zip,
        Self::Piz,
        Self::Pxr24,
        Self::Dwaa,
        Self::Dwab,
    ];

    /// The name that users and OpenEXR's own tools know it by.
    pub const fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Rle => "rle",
            Self::Zips => "zips",
            Self::Zip => "zip",
            Self::Piz => "piz",
            Self::Pxr24 => "pxr24",
            Self::Dwaa => "dwaa",
            Self::Dwab => "dwab",
        }
    }

    /// Whether values of this precision come back as they were, to the bit.
    pub const fn is_lossless(self, precision: Precision) -> bool {
        match (self, precision) {
            (Self::None | Self::Rle | Self::Zips | Self::Zip | Self::Piz, _)
            | (Self::Pxr24, Precision::Half) => true,
            (Self::Pxr24, Precision::Float) | (Self::Dwaa | Self::Dwab, _) => false,
        }
    }
}

impl fmt::Display for Compression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is not that of a [`Compression`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown compression `{0}`, expected {expected}", expected = Compression::ALL.map(Compression::name).join(", "))]
#[doc(hidden)]
pub struct UnknownCompression(pub String);

impl FromStr for Compression {
    type Err = UnknownCompression;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|compression| compression.name() == name)
            .ok_or_else(|| UnknownCompression(name.to_string()))
    }
}

/// The attribute that names the color space of R, G, B.
const COLOR_INTEROP_ID: &str = "colorInteropID";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_have_a_limit() {
        let window = Window::whole([65_536, 65_536]);
        let every_nm = (360..=830).map(|nm| Channel {
            name: format!("S0.{nm},000000nm"),
            kind: ChannelKind::Light,
        });
        let fits = |compression, channels: &Channels| {
            let options = ExrOptions {
                compression,
                ..ExrOptions::default()
            };
            options.check(window, channels).is_ok()
        };
        for compression in Compression::ALL {
            assert!(fits(compression, &Channels::default()));
        }
        let channels = Channels {
            list: every_nm.collect(),
            ..Channels::default()
        };
        assert!(fits(Compression::Zip, &channels));
        // 32 lines of 65536 pixels of 475 values of 4 bytes are 4 GB.
        assert!(!fits(Compression::Piz, &channels));
        let message = |compression, window| {
            let options = ExrOptions {
                compression,
                ..ExrOptions::default()
            };
            options.check(window, &channels).unwrap_err().to_string()
        };
        assert!(message(Compression::Piz, window).contains("; choose zip, or render"));
        let wide = Window::whole([1 << 19, 1 << 16]);
        assert!(message(Compression::Zip, wide).contains("; choose zips, or render"));
        let wider = Window::whole([1 << 24, 1]);
        assert!(message(Compression::Zips, wider).contains("; render the image in parts"));
        // But of one line they are not.
        let line = Window::whole([65_536, 1]);
        let options = ExrOptions {
            compression: Compression::Piz,
            ..ExrOptions::default()
        };
        assert_eq!(options.check(line, &channels), Ok(()));
    }

    #[test]
    fn compressions_have_names() {
        for compression in Compression::ALL {
            assert_eq!(compression.name().parse(), Ok(compression));
        }
        assert_eq!(
            "zap".parse::<Compression>().unwrap_err().to_string(),
            "unknown compression `zap`, expected none, rle, zips, zip, piz, pxr24, dwaa, dwab"
        );
    }
}
