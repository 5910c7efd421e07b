//! An EXR file that is being written: blocks of lines are compressed by many threads, in any order,
//! and written in the order of the lines.

use std::io;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

use exr::meta::attribute::IntegerBounds;
use exr::meta::header::Header;

use super::head::{head, residual_place};
use super::ordered::Ordered;
use super::preserve::Preserved;
use super::store::{FileChannel, Halves, residual};
use super::tile::{BlockHash, TileHash, block_hash, hash_place};
use super::zip::Zip;
use super::{ExrImage, ExrOptions, ExrReport, Precision, Preserve};
use crate::image::{ImageSpec, Rows};
use crate::output::Sink;

/// An EXR file whose blocks may come in any order.
pub(crate) struct ExrFile<'f> {
    header: Header,
    channels: Vec<FileChannel<'f>>,
    /// Sums of layers that are the image.
    sums: &'f [Vec<usize>],
    /// Of light.
    precision: Precision,
    preserved: Option<Preserved>,
    /// Whether this is a tile, whose hash is in the header.
    is_hashed: bool,
    has_failed: AtomicBool,
    written: Mutex<Written<'f>>,
}

/// The part of a file that is written.
struct Written<'f> {
    blocks: Ordered<'f>,
    /// Where the residual of sums is, if it is in the header.
    residual_place: Option<u64>,
    residual: f64,
    halves: Halves,
    /// Where this is a tile, whose hash is in the header.
    hashed: Option<Hashed>,
    /// What ended the writing.
    error: Option<io::Error>,
}

/// What the hash of a tile is made of.
struct Hashed {
    head: Vec<u8>,
    /// Where in the head the hash is.
    place: usize,
    /// Of each block.
    blocks: Vec<BlockHash>,
}

/// What a thread compresses one block after the other with.
pub(crate) struct Packer {
    /// A block before compression.
    raw: Vec<u8>,
    /// A block as it goes into the file.
    block: Vec<u8>,
    /// A line of sums.
    sums: Vec<f64>,
    /// Where the compression is of that kind.
    zip: Option<Zip>,
}

impl<'f> ExrFile<'f> {
    /// Writes all that comes before the blocks.
    ///
    /// # Errors
    /// As [`Film::write_exr_to`](crate::image::Film::write_exr_to).
    pub(crate) fn begin(
        spec: &'f ImageSpec,
        options: &ExrOptions,
        preserve: Preserve,
        sink: &'f mut dyn Sink,
    ) -> io::Result<Self> {
        let channels = spec.file_channels(options.precision);
        let header = spec.header(options, &channels);
        options
            .check(spec.window, &spec.channels)
            .map_err(|error| io::Error::new(io::ErrorKind::InvalidInput, error))?;
        let preserved = match preserve {
            Preserve::Nothing => None,
            Preserve::Image => Some(Preserved::new(spec, options, &channels)?),
        };
        let head = head(&header).map_err(into_io)?;
        let hash_place = options.tile.and_then(|_| hash_place(&head));
        let written = Written {
            residual_place: residual_place(&head),
            residual: 0.0,
            hashed: hash_place.map(|place| Hashed {
                head: head.clone(),
                place,
                blocks: vec![BlockHash::default(); header.chunk_count],
            }),
            blocks: Ordered::begin(sink, head, header.chunk_count)?,
            halves: Halves::default(),
            error: None,
        };
        Ok(Self {
            header,
            channels,
            sums: &spec.channels.sums,
            precision: options.precision,
            preserved,
            is_hashed: written.hashed.is_some(),
            has_failed: AtomicBool::new(false),
            written: Mutex::new(written),
        })
    }

    /// Lines of a block that is not cut off.
    pub(crate) fn lines_per_block(&self) -> usize {
        self.header.compression.scan_lines_per_block()
    }

    /// How many blocks there are.
    pub(crate) fn blocks(&self) -> usize {
        self.header.chunk_count
    }

    /// What a thread needs to add blocks.
    pub(crate) fn packer(&self) -> Packer {
        let is_float = |channel: &&FileChannel<'_>| channel.precision == Precision::Float;
        let floats = self.channels.iter().filter(is_float).count();
        let mostly_float = 2 * floats >= self.channels.len();
        Packer {
            raw: Vec::new(),
            block: Vec::new(),
            sums: Vec::new(),
            zip: Zip::of(self.header.compression, mostly_float),
        }
    }

    /// Whether anything went wrong: further blocks are of no use.
    pub(crate) fn has_failed(&self) -> bool {
        self.has_failed.load(Ordering::Relaxed)
    }

    /// Compresses the block with this index, counted from the top, and writes all that is there
    /// without a gap. What goes wrong is told by [`ExrFile::finish`].
    pub(crate) fn add(&self, index: usize, rows: Rows<'_>, packer: &mut Packer) {
        match self.pack(index, rows, packer) {
            Ok((halves, residual)) => {
                let hash = self.is_hashed.then(|| block_hash(&packer.block));
                let mut written = self.written();
                if let Some((hashed, hash)) = written.hashed.as_mut().zip(hash) {
                    hashed.blocks[index] = hash;
                }
                written.halves.add(halves);
                written.residual = written.residual.max(residual);
                if written.error.is_none()
                    && let Err(error) = written.blocks.add(index, &packer.block)
                {
                    written.error = Some(error);
                    self.has_failed.store(true, Ordering::Relaxed);
                }
            }
            Err(error) => {
                self.written().error.get_or_insert(error);
                self.has_failed.store(true, Ordering::Relaxed);
            }
        }
    }

    /// Writes the offset table, after all blocks have come.
    ///
    /// # Errors
    /// The first that there was.
    pub(crate) fn finish(self) -> io::Result<(ExrReport, Option<ExrImage>)> {
        let written = self.written.into_inner();
        let written = written.unwrap_or_else(PoisonError::into_inner);
        if let Some(error) = written.error {
            return Err(error);
        }
        let residual = (written.residual as f32).to_le_bytes();
        let mut patches: Vec<(u64, &[u8])> = Vec::new();
        if let Some(place) = written.residual_place {
            patches.push((place, &residual));
        }
        let hash = written.hashed.map(|hashed| {
            let Hashed {
                mut head,
                place,
                blocks,
            } = hashed;
            if let Some(place) = written.residual_place {
                head[place as usize..][..residual.len()].copy_from_slice(&residual);
            }
            (
                place as u64,
                TileHash::new(block_hash(&head)).finish(&blocks),
            )
        });
        if let Some((place, hash)) = &hash {
            patches.push((*place, hash.as_bytes()));
        }
        let bytes = written.blocks.finish(&patches)?;
        let report = ExrReport {
            clamped_to_half: written.halves.clamped,
            small_in_half: written.halves.small,
            residual: written.residual,
            bytes,
        };
        Ok((report, self.preserved.map(Preserved::into_image)))
    }

    /// Makes a block as the file has it: its first line, its length, and its pixels.
    fn pack(&self, index: usize, rows: Rows<'_>, packer: &mut Packer) -> io::Result<(Halves, f64)> {
        let Packer {
            raw,
            block,
            sums,
            zip,
        } = packer;
        let width = self.header.layer_size.width();
        let top = index * self.lines_per_block();
        raw.clear();
        let halves = rows.store(&self.channels, width, raw);
        let residual = residual(rows, self.sums, width, self.precision, sums);
        if let Some(preserved) = self.preserved.as_ref().filter(|kept| kept.is_lossless()) {
            preserved.add(top, raw);
        }

        block.clear();
        let y = self.header.own_attributes.layer_position.y() + top as i32;
        block.extend_from_slice(&y.to_le_bytes());
        // The length comes later.
        block.extend_from_slice(&[0; 4]);
        let start = block.len();
        if let Some(zip) = zip {
            zip.compress(raw, block);
        } else {
            let lines = rows.pixels.len() / width;
            let section = IntegerBounds::new((0, top as i32), (width, lines));
            let compression = self.header.compression;
            let pixels = compression
                .compress_image_section_to_le(&self.header, std::mem::take(raw), section)
                .map_err(into_io)?;
            block.extend_from_slice(&pixels);
            if let Some(preserved) = self.preserved.as_ref().filter(|kept| !kept.is_lossless()) {
                let section = IntegerBounds::new(
                    (self.header.own_attributes.layer_position.x(), y),
                    (width, lines),
                );
                let decoded = compression
                    .decompress_image_section_from_le(&self.header, pixels, section, false)
                    .map_err(into_io)?;
                preserved.add(top, &decoded);
            }
        }
        let length = (block.len() - start) as i32;
        block[start - size_of::<i32>()..start].copy_from_slice(&length.to_le_bytes());
        Ok((halves, residual))
    }

    /// A panic elsewhere ends the render in any case.
    fn written(&self) -> MutexGuard<'_, Written<'f>> {
        self.written.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

pub(super) fn into_io(error: exr::error::Error) -> io::Error {
    match error {
        exr::error::Error::Io(error) => error,
        error => io::Error::new(io::ErrorKind::InvalidInput, error.to_string()),
    }
}
