//! Why tiles cannot be merged, and the way out.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use super::difference::Difference;
use crate::exr::{ExrError, ExrProblem, TileNumber};
use crate::image::Window;
use crate::output::OutputError;
use crate::printable::printable_path;

/// Tiles could not be merged; nothing was written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MergeError {
    /// A file cannot be read.
    #[error("{}{}", .0, way_out(.0))]
    Read(#[from] ExrError),
    /// The merged file cannot be written.
    #[error(transparent)]
    Write(#[from] OutputError),
    /// No file was named.
    #[error("there are no tiles to merge")]
    NoTiles,
    /// Something that cannot be read twice.
    #[error(
        "cannot merge {}: it is no file, and tiles are read more than once; write it to a file first",
        stream(.0)
    )]
    Stream(PathBuf),
    /// An image that is whole, or a part that does not say of what.
    #[error(
        "{} is no tile (it has no `candela:tile`); merge takes what `candela render --tile I/N` writes, and no other \
         images, parts by --crop among them",
        printable_path(.0)
    )]
    NoTile(PathBuf),
    /// What it says that it is makes no sense.
    #[error(
        "{} does not say which tile it is in a way that candela writes; render it anew with `candela render --tile I/N`",
        printable_path(.0)
    )]
    BrokenTile(PathBuf),
    /// Its window is not that of its number.
    #[error(
        "{} says that it is tile {number}, but its rows are not {}; render it anew with `candela render --tile {number}`",
        printable_path(path),
        rows(*expected)
    )]
    Misplaced {
        /// The tile.
        path: PathBuf,
        /// Which it says it is.
        number: TileNumber,
        /// Where that would be, if anywhere.
        expected: Option<Window>,
    },
    /// Tiles of different renders.
    #[error(
        "{} and {} are no tiles of one image: {} is {} in the first and {} in the second; {}",
        printable_path(&paths[0]), printable_path(&paths[1]),
        difference.name(), difference.values[0], difference.values[1], difference.way_out()
    )]
    Differs {
        /// The first that was named, and the other.
        paths: Box<[PathBuf; 2]>,
        /// The first one that there is.
        difference: Box<Difference>,
    },
    /// Tiles of an image in so many and in other parts.
    #[error(
        "{} is tile {}, and {} is tile {}; an image is merged from tiles of one count",
        printable_path(&paths[0]), numbers[0], printable_path(&paths[1]), numbers[1]
    )]
    OtherCount {
        /// The first that was named, and the other.
        paths: [PathBuf; 2],
        /// Theirs.
        numbers: [TileNumber; 2],
    },
    /// A tile is there twice.
    #[error(
        "{} and {} are both tile {number}; name one of them",
        printable_path(&paths[0]), printable_path(&paths[1])
    )]
    Twice {
        /// Both.
        paths: [PathBuf; 2],
        /// Which they are.
        number: TileNumber,
    },
    /// Tiles are not there.
    #[error("{}", are_missing(missing, *count))]
    Missing {
        /// Their numbers, from 0.
        missing: Vec<RangeInclusive<u32>>,
        /// How many there should be.
        count: u32,
    },
    /// A tile is not what was written when it was rendered.
    #[error(
        "{} is damaged or incomplete ({reason}); render it anew with `candela render --tile {number}`",
        printable_path(path)
    )]
    Damaged {
        /// The tile.
        path: PathBuf,
        /// Which it says it is.
        number: TileNumber,
        /// How that is known.
        reason: String,
    },
    /// A tile was there, and is not there any more.
    #[error("{} was there when the merge began, and is gone; merge again once it is there", printable_path(.0))]
    Vanished(PathBuf),
    /// A tile is not the one that it was.
    #[error("{} was written anew while it was merged; merge again", printable_path(.0))]
    Changed(PathBuf),
}

impl MergeError {
    /// Whether a later try may do better, of what this error alone tells.
    pub fn is_transient(&self) -> bool {
        match self {
            Self::Vanished(_) | Self::Changed(_) => true,
            Self::Read(error) => error.is_transient(),
            Self::Write(error) => error.is_transient(),
            Self::NoTiles
            | Self::Stream(_)
            | Self::NoTile(_)
            | Self::BrokenTile(_)
            | Self::Misplaced { .. }
            | Self::Differs { .. }
            | Self::OtherCount { .. }
            | Self::Twice { .. }
            | Self::Missing { .. }
            | Self::Damaged { .. } => false,
        }
    }
}

/// What helps where a file is there, but no tile.
fn way_out(error: &ExrError) -> &'static str {
    match error.problem {
        ExrProblem::Damaged(_) | ExrProblem::NotExr => {
            "; render it anew with `candela render --tile I/N`"
        }
        ExrProblem::Io(_)
        | ExrProblem::NoRgb(_)
        | ExrProblem::NoLayer { .. }
        | ExrProblem::Unsupported(_)
        | ExrProblem::TooLarge(..)
        | ExrProblem::NoMemory { .. } => "",
    }
}

fn stream(path: &Path) -> String {
    if path == Path::new("-") {
        "standard input".to_owned()
    } else {
        printable_path(path)
    }
}

/// `96 to 191`
fn rows(window: Option<Window>) -> String {
    match window {
        Some(Window {
            x,
            y,
            width,
            height,
        }) => format!(
            "{y} to {} of columns {x} to {}",
            y + height - 1,
            x + width - 1
        ),
        None => "any, as there are fewer than tiles".to_owned(),
    }
}

/// As many ranges are listed: there may be thousands.
const LISTED: usize = 20;

/// `tiles 3, 5-7 of 16 are missing; …`
fn are_missing(missing: &[RangeInclusive<u32>], count: u32) -> String {
    let range = |range: &RangeInclusive<u32>| match (range.start(), range.end()) {
        (start, end) if start == end => start.to_string(),
        (start, end) => format!("{start}-{end}"),
    };
    let listed: Vec<String> = missing.iter().take(LISTED).map(range).collect();
    let mut list = listed.join(", ");
    if missing.len() > LISTED {
        list += ", …";
    }
    let first = missing.first().map_or(0, |range| *range.start());
    let all = missing.iter();
    let all: u64 = all
        .map(|range| u64::from(range.end() - range.start()) + 1)
        .sum();
    let (tiles, are) = if all == 1 {
        ("tile", "is")
    } else {
        ("tiles", "are")
    };
    format!(
        "{tiles} {list} of {count} {are} missing; render with `candela render --tile {first}/{count}`, \
         or name all files of the image"
    )
}
