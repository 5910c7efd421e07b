//! Merges tiles that were rendered by themselves: the bytes of the whole render.
//!
//! ```text
//! headers of all tiles ─ the same but for what a tile is ─▶ one header
//! blocks of lines ─ copied as they are, hashed on the way ─▶ the same blocks
//! ```
//!
//! Blocks are not decoded: a compression that loses digits would lose more, and each tile has a hash of all that is in
//! it, which finds damage under every compression. Of every thread a few blocks are in memory at most, and of each tile
//! its place.

mod difference;
mod error;
mod totals;

use std::io;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

pub use error::MergeError;

use rayon::prelude::*;

use super::Compression;
use super::ordered::Ordered;
use super::read::{Attribute, ExrProblem, StoredExr};
use super::rewrite::stored_head;
use super::tile::{
    BlockHash, NO_HASH, TILE, TILE_ATTRIBUTES, TILE_HASH, TILE_WINDOW, Tile, TileHash, TileNumber,
    block_hash,
};
use crate::image::Window;
use crate::output::{self, Unfinished};
use crate::turns::in_turn;
use difference::difference;
use totals::Totals;

/// Blocks for each thread that are read together: one that comes late, as over a network, must not let all others pile
/// up in memory behind it.
const TOGETHER: usize = 8;

/// What was merged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct MergeReport {
    /// How many tiles.
    pub tiles: u32,
    /// Width and height of the whole image.
    pub resolution: [u32; 2],
    /// Width and height of the part that the file has pixels of.
    pub size: [u32; 2],
    /// The file's length in bytes.
    pub bytes: u64,
}

/// Merges all tiles of an image, in any order, into a file with the bytes of the whole render, whole or not at all.
/// The tiles are files; `-` as the output is standard output.
///
/// ```no_run
/// use candela::exr::merge;
/// use candela::output::Unfinished;
///
/// let tiles = ["a.exr", "b.exr"].map(Into::into);
/// merge(&tiles, "whole.exr".as_ref(), &Unfinished::new())?;
/// # Ok::<(), candela::exr::MergeError>(())
/// ```
///
/// # Errors
/// Where a file cannot be read or written, or is damaged, or is no tile; where tiles are missing, are there twice, or are
/// of different renders. The output is then as it was.
pub fn merge(
    inputs: &[PathBuf],
    output: &Path,
    unfinished: &Unfinished,
) -> Result<MergeReport, MergeError> {
    Merger::new(inputs)?.write(output, unfinished)
}

/// All tiles of an image, from the top.
#[derive(Debug)]
struct Merger {
    /// Of the first file that was named.
    version: u32,
    attributes: Vec<Attribute>,
    resolution: [u32; 2],
    /// What the tiles make up.
    of: Window,
    totals: Totals,
    tiles: Vec<TileFile>,
    blocks: usize,
}

/// A file that is a tile, as it was found.
#[derive(Debug)]
struct TileFile {
    path: PathBuf,
    number: TileNumber,
    /// Of the head, without the tile's own hash.
    head: BlockHash,
    /// The hash that the file gives.
    hash: Vec<u8>,
    /// Of the file.
    length: u64,
    /// Of the whole image's, the first that is here.
    first_block: usize,
    blocks: usize,
}

/// A tile's file while its blocks are read.
#[derive(Debug)]
struct Open {
    stored: Option<Arc<StoredExr>>,
    /// Blocks that are not read yet.
    left: usize,
}

/// The file that is being written.
struct Merged<'f> {
    blocks: Ordered<'f>,
    hashes: Vec<BlockHash>,
    /// What ended the writing.
    error: Option<Failure>,
}

/// Why a merge ended.
enum Failure {
    Merge(MergeError),
    Write(io::Error),
}

impl Merger {
    /// Looks at the headers of all files.
    fn new(inputs: &[PathBuf]) -> Result<Self, MergeError> {
        let mut merger: Option<Self> = None;
        for path in inputs {
            let stored = open(path)?;
            let (tile, compression) = tile(path, &stored)?;
            let merger = match &mut merger {
                Some(merger) => {
                    merger.check_same(path, &stored, tile.number)?;
                    merger
                }
                none => none.insert(Self {
                    version: stored.version(),
                    attributes: stored.attributes().to_vec(),
                    resolution: stored.resolution(),
                    of: tile.of,
                    totals: Totals::default(),
                    tiles: Vec::new(),
                    blocks: 0,
                }),
            };
            check_window(path, &stored, tile, compression)?;
            merger
                .totals
                .add(stored.attributes())
                .map_err(|name| MergeError::Damaged {
                    path: path.clone(),
                    number: tile.number,
                    reason: format!("its attribute `{name}` is no such number"),
                })?;
            merger
                .tiles
                .push(TileFile::new(path, &stored, tile.number)?);
        }
        let Some(mut merger) = merger else {
            return Err(MergeError::NoTiles);
        };
        merger.complete()?;
        Ok(merger)
    }

    /// Whether a file is of the same render as the first.
    fn check_same(
        &self,
        path: &Path,
        stored: &StoredExr,
        number: TileNumber,
    ) -> Result<(), MergeError> {
        let first = &self.tiles[0];
        let paths = [first.path.clone(), path.to_path_buf()];
        let versions = [self.version, stored.version()];
        let lists = [&self.attributes[..], stored.attributes()];
        if let Some(difference) = difference(versions, lists) {
            return Err(MergeError::Differs {
                paths: Box::new(paths),
                difference: Box::new(difference),
            });
        }
        if number.count() != first.number.count() {
            return Err(MergeError::OtherCount {
                paths,
                numbers: [first.number, number],
            });
        }
        Ok(())
    }

    /// Puts the tiles in order, and finds out whether each is there once.
    fn complete(&mut self) -> Result<(), MergeError> {
        self.tiles.sort_by_key(|tile| tile.number);
        if let Some([one, other]) = self
            .tiles
            .array_windows()
            .find(|[a, b]| a.number == b.number)
        {
            return Err(MergeError::Twice {
                paths: [one.path.clone(), other.path.clone()],
                number: one.number,
            });
        }
        let count = self.tiles[0].number.count();
        let mut missing = Vec::new();
        let mut next = 0;
        for index in self
            .tiles
            .iter()
            .map(|tile| tile.number.index())
            .chain([count])
        {
            if next < index {
                missing.push(next..=index - 1);
            }
            next = index.saturating_add(1);
        }
        if !missing.is_empty() {
            return Err(MergeError::Missing { missing, count });
        }
        for tile in &mut self.tiles {
            tile.first_block = self.blocks;
            self.blocks += tile.blocks;
        }
        Ok(())
    }

    /// The head of the whole render.
    fn head(&self) -> io::Result<Vec<u8>> {
        let Window {
            x,
            y,
            width,
            height,
        } = self.of;
        let corners = [x, y, x + width - 1, y + height - 1];
        let window: Vec<u8> = corners.into_iter().flat_map(u32::to_le_bytes).collect();
        let is_of_tile = |name: &[u8]| {
            let mut own = TILE_ATTRIBUTES.iter();
            own.any(|own| own.as_bytes() == name)
        };
        let kept = self.attributes.iter().filter(|it| !is_of_tile(&it.name));
        let attributes: Vec<Attribute> = kept
            .map(|attribute| Attribute {
                value: match attribute.name.as_slice() {
                    b"dataWindow" => window.clone(),
                    b"chunkCount" => (self.blocks as u32).to_le_bytes().to_vec(),
                    name => self
                        .totals
                        .value(name)
                        .unwrap_or_else(|| attribute.value.clone()),
                },
                ..attribute.clone()
            })
            .collect();
        stored_head(self.version, &attributes)
    }

    /// Copies all blocks.
    fn write(&self, output: &Path, unfinished: &Unfinished) -> Result<MergeReport, MergeError> {
        let open = self.tiles.iter().map(|tile| {
            Mutex::new(Open {
                stored: None,
                left: tile.blocks,
            })
        });
        let open: Vec<_> = open.collect();
        let mut unreadable = None;
        let written = output::write(output, unfinished, |sink| {
            let merged = Mutex::new(Merged {
                blocks: Ordered::begin(sink, self.head()?, self.blocks)?,
                hashes: vec![BlockHash::default(); self.blocks],
                error: None,
            });
            let together = TOGETHER * rayon::current_num_threads();
            for first in (0..self.blocks).step_by(together) {
                in_turn(
                    together.min(self.blocks - first),
                    || (),
                    |(), index| match self.copy(first + index, &open, &merged) {
                        Ok(()) => ControlFlow::Continue(()),
                        Err(error) => {
                            lock(&merged).error.get_or_insert(error);
                            ControlFlow::Break(())
                        }
                    },
                );
                if lock(&merged).error.is_some() {
                    break;
                }
            }
            let merged = merged.into_inner().unwrap_or_else(PoisonError::into_inner);
            let checked = match merged.error {
                None => self.check_hashes(&merged.hashes).map_err(Failure::Merge),
                Some(error) => Err(error),
            };
            match checked {
                Ok(()) => merged.blocks.finish(&[]),
                Err(Failure::Write(error)) => Err(error),
                Err(Failure::Merge(error)) => {
                    unreadable = Some(error);
                    Err(io::ErrorKind::InvalidData.into())
                }
            }
        });
        if let Some(error) = unreadable {
            return Err(error);
        }
        Ok(MergeReport {
            tiles: self.tiles.len() as u32,
            resolution: self.resolution,
            size: [self.of.width, self.of.height],
            bytes: written?,
        })
    }

    /// Copies a block.
    fn copy(
        &self,
        index: usize,
        open: &[Mutex<Open>],
        merged: &Mutex<Merged<'_>>,
    ) -> Result<(), Failure> {
        let place = self.tiles.partition_point(|tile| tile.first_block <= index) - 1;
        let (tile, open) = (&self.tiles[place], &open[place]);
        let stored = tile.opened(open).map_err(Failure::Merge)?;
        let packed = stored.packed(index - tile.first_block);
        let packed = packed.map_err(|error| Failure::Merge(tile.unreadable(error)))?;
        let hash = block_hash(&packed);
        {
            let mut merged = lock(merged);
            merged.hashes[index] = hash;
            merged.blocks.add(index, &packed).map_err(Failure::Write)?;
        }
        let mut open = lock(open);
        open.left -= 1;
        if open.left == 0 {
            // There may be more tiles than files that may be open.
            open.stored = None;
        }
        Ok(())
    }

    /// Whether all that was copied is what was written when the tiles were rendered.
    fn check_hashes(&self, hashes: &[BlockHash]) -> Result<(), MergeError> {
        for tile in &self.tiles {
            let blocks = &hashes[tile.first_block..][..tile.blocks];
            if TileHash::new(tile.head).finish(blocks).as_bytes() != tile.hash {
                return Err(MergeError::Damaged {
                    path: tile.path.clone(),
                    number: tile.number,
                    reason: format!("its content has not the hash that `{TILE_HASH}` gives"),
                });
            }
        }
        Ok(())
    }
}

impl TileFile {
    fn new(path: &Path, stored: &StoredExr, number: TileNumber) -> Result<Self, MergeError> {
        let damaged = |reason: &str| MergeError::Damaged {
            path: path.to_path_buf(),
            number,
            reason: reason.to_owned(),
        };
        let hash = attribute(stored, TILE_HASH, b"string");
        let hash = hash.filter(|hash| hash.len() == NO_HASH.len());
        Ok(Self {
            path: path.to_path_buf(),
            number,
            head: head_hash(stored).ok_or_else(|| damaged("its header cannot be written"))?,
            hash: hash
                .ok_or_else(|| damaged(&format!("it has no `{TILE_HASH}`")))?
                .to_vec(),
            length: stored.length(),
            first_block: 0,
            blocks: stored.blocks(),
        })
    }

    /// The file, which is opened if it is not open.
    fn opened(&self, open: &Mutex<Open>) -> Result<Arc<StoredExr>, MergeError> {
        let mut open = lock(open);
        if let Some(stored) = &open.stored {
            return Ok(Arc::clone(stored));
        }
        let stored = StoredExr::open(&self.path).map_err(|error| self.unreadable(error))?;
        let hash = attribute(&stored, TILE_HASH, b"string");
        let is_same = stored.length() == self.length
            && hash == Some(&self.hash)
            && head_hash(&stored) == Some(self.head);
        if !is_same {
            return Err(MergeError::Changed(self.path.clone()));
        }
        Ok(Arc::clone(open.stored.insert(Arc::new(stored))))
    }

    /// What it means that the tile, which was there, cannot be read.
    fn unreadable(&self, error: super::ExrError) -> MergeError {
        match &error.problem {
            ExrProblem::Io(problem) if problem.kind() == io::ErrorKind::NotFound => {
                MergeError::Vanished(self.path.clone())
            }
            ExrProblem::Damaged(reason) => MergeError::Damaged {
                path: self.path.clone(),
                number: self.number,
                reason: reason.clone(),
            },
            ExrProblem::Io(_)
            | ExrProblem::NotExr
            | ExrProblem::NoRgb(_)
            | ExrProblem::NoLayer { .. }
            | ExrProblem::Unsupported(_)
            | ExrProblem::TooLarge(..)
            | ExrProblem::NoMemory { .. } => error.into(),
        }
    }
}

/// Opens what should be a tile.
fn open(path: &Path) -> Result<StoredExr, MergeError> {
    // What is opened again must be a file; what is not there, or a folder, is an error of reading.
    let is_stream = path == Path::new("-")
        || path
            .metadata()
            .is_ok_and(|metadata| !metadata.is_file() && !metadata.is_dir());
    if is_stream {
        return Err(MergeError::Stream(path.to_path_buf()));
    }
    Ok(StoredExr::open(path)?)
}

/// What a file says that it is.
fn tile(path: &Path, stored: &StoredExr) -> Result<(Tile, Compression), MergeError> {
    let number = attribute(stored, TILE, b"string");
    let number = number.ok_or_else(|| MergeError::NoTile(path.to_path_buf()))?;
    let text = String::from_utf8_lossy(number);
    let of = attribute(stored, TILE_WINDOW, b"box2i").and_then(window);
    let (Ok(number), Some(of), Some(compression)) = (text.parse(), of, stored.compression()) else {
        return Err(MergeError::BrokenTile(path.to_path_buf()));
    };
    Ok((Tile { number, of }, compression))
}

/// Whether a tile is where its number says.
fn check_window(
    path: &Path,
    stored: &StoredExr,
    tile: Tile,
    compression: Compression,
) -> Result<(), MergeError> {
    let found = attribute(stored, "dataWindow", b"box2i").and_then(window);
    match tile.window(compression) {
        Ok(expected) if found == Some(expected) => Ok(()),
        Ok(expected) => Err(MergeError::Misplaced {
            path: path.to_path_buf(),
            number: tile.number,
            expected: Some(expected),
        }),
        Err(_) => Err(MergeError::Misplaced {
            path: path.to_path_buf(),
            number: tile.number,
            expected: None,
        }),
    }
}

/// The hash of a file's head, without the tile's own hash.
fn head_hash(stored: &StoredExr) -> Option<BlockHash> {
    let mut attributes = stored.attributes().to_vec();
    let own = attributes
        .iter_mut()
        .find(|it| it.name == TILE_HASH.as_bytes());
    if let Some(own) = own {
        own.value = NO_HASH.to_vec();
    }
    let head = stored_head(stored.version(), &attributes).ok()?;
    Some(block_hash(&head))
}

/// Whether a tile that is there is what was written when it was rendered.
pub(super) fn has_its_hash(stored: &StoredExr) -> bool {
    let blocks: Option<Vec<BlockHash>> = (0..stored.blocks())
        .into_par_iter()
        .map(|block| stored.packed(block).ok().map(|packed| block_hash(&packed)))
        .collect();
    let Some((head, blocks)) = head_hash(stored).zip(blocks) else {
        return false;
    };
    let hash = TileHash::new(head).finish(&blocks);
    attribute(stored, TILE_HASH, b"string") == Some(hash.as_bytes())
}

/// The value of an attribute of this type.
fn attribute<'s>(stored: &'s StoredExr, name: &str, kind: &[u8]) -> Option<&'s [u8]> {
    let mut all = stored.attributes().iter();
    let found = all.find(|it| it.name == name.as_bytes() && it.kind == kind)?;
    Some(&found.value)
}

/// A window from its corners, both inside, where none is left of or above the display window.
fn window(bytes: &[u8]) -> Option<Window> {
    let bytes: &[u8; 16] = bytes.try_into().ok()?;
    let (corners, _) = bytes.as_chunks::<4>();
    // Within the limits of OpenEXR.
    let side = |place: usize| {
        let side = u32::try_from(i32::from_le_bytes(corners[place])).ok()?;
        (side <= 1 << 30).then_some(side)
    };
    let [x, y, right, bottom] = [side(0)?, side(1)?, side(2)?, side(3)?];
    Some(Window {
        x,
        y,
        width: right.checked_sub(x)? + 1,
        height: bottom.checked_sub(y)? + 1,
    })
}

/// A panic elsewhere ends the run in any case.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests;
