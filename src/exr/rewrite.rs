//! Writes a file that was read once more: some channels changed, some left out, everything else as it was.
//!
//! Blocks of lines are read, changed, compressed as they were and written, each by one thread, in the order of the
//! lines: the file is never in memory as a whole.

use std::io;
use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};

use exr::meta::attribute::IntegerBounds;
use exr::meta::header::Header;

use super::file::into_io;
use super::head::residual_place;
use super::ordered::Ordered;
use super::read::{Attribute, ExrError, SampleKind, StoredExr};
use super::zip::Zip;
use crate::output::Sink;
use crate::turns::in_turn;

/// A block that is changed is there as the file has it, decoded, changed and compressed, and what the codecs need in
/// between.
pub(crate) const COPIES_OF_BLOCK: u64 = 8;

/// The longest name of an attribute or a channel that readers of old expect.
const SHORT_NAME: usize = 31;

/// The flag in the version field that says that names may be longer.
const LONG_NAMES: u32 = 1 << 10;

/// What differs from the file that was read.
pub(crate) struct Rewritten<'a> {
    /// The channels that stay, by their places, ascending.
    pub(crate) kept: &'a [usize],
    /// Text attributes that are added, or take the place of others of their name.
    pub(crate) texts: &'a [(&'a str, String)],
    /// Attributes that are left out.
    pub(crate) left_out: &'a [&'a str],
}

/// Why a file could not be written again.
#[derive(Debug)]
pub(crate) enum RewriteError {
    /// What was to be changed cannot be read.
    Read(ExrError),
    /// What was changed cannot be written.
    Write(io::Error),
}

/// Writes the file into `sink`; the length of what was written. `change` is given a block of lines as
/// [`StoredExr::lines`] has it, and appends what the new file has instead: all channels that are kept. Where the head
/// says how far sums of layers are off the image, `residual` says so anew, from the states of all threads.
///
/// # Errors
/// Whatever is wrong with the file, and what the sink reports.
pub(crate) fn rewrite<S: Send>(
    stored: &StoredExr,
    rewritten: &Rewritten<'_>,
    sink: &mut dyn Sink,
    state: impl Fn() -> S + Sync,
    change: impl Fn(&mut S, &[u8], &mut Vec<u8>) + Sync,
    residual: impl FnOnce(&[S]) -> Option<f64>,
) -> Result<(u64, Vec<S>), RewriteError> {
    let head = head(stored, rewritten).map_err(RewriteError::Write)?;
    let residual_place = residual_place(&head);
    let header = stored.header(rewritten.kept);
    let ordered = Ordered::begin(sink, head, stored.blocks()).map_err(RewriteError::Write)?;
    let ordered = Mutex::new(ordered);
    let failed = Mutex::new(None);
    let is_float = |channel: &&usize| stored.kind(**channel) == SampleKind::Float;
    let mostly_float = 2 * rewritten.kept.iter().filter(is_float).count() >= rewritten.kept.len();
    let states = in_turn(
        stored.blocks(),
        || (state(), Packer::new(&header, mostly_float)),
        |(state, packer), index| {
            let packed = stored.lines(index).map_err(RewriteError::Read);
            let packed = packed.and_then(|lines| {
                packer.raw.clear();
                change(state, &lines, &mut packer.raw);
                packer
                    .pack(&header, stored, index)
                    .map_err(RewriteError::Write)
            });
            let added = packed.and_then(|()| {
                // A panic elsewhere ends the run in any case.
                let mut ordered = ordered.lock().unwrap_or_else(PoisonError::into_inner);
                ordered
                    .add(index, &packer.block)
                    .map_err(RewriteError::Write)
            });
            match added {
                Ok(()) => ControlFlow::Continue(()),
                Err(error) => {
                    let mut failed = failed.lock().unwrap_or_else(PoisonError::into_inner);
                    failed.get_or_insert(error);
                    ControlFlow::Break(())
                }
            }
        },
    );
    if let Some(error) = failed.into_inner().unwrap_or_else(PoisonError::into_inner) {
        return Err(error);
    }
    let ordered = ordered.into_inner().unwrap_or_else(PoisonError::into_inner);
    let states: Vec<S> = states.into_iter().map(|(state, _)| state).collect();
    let number = residual_place
        .zip(residual(&states))
        .map(|(place, residual)| (place, (residual as f32).to_le_bytes()));
    let number = number.as_ref().map(|(place, bytes)| (*place, &bytes[..]));
    let length = ordered.finish(number.as_slice());
    let length = length.map_err(RewriteError::Write)?;
    Ok((length, states))
}

/// What a thread compresses one block after the other with.
struct Packer {
    /// A block before compression.
    raw: Vec<u8>,
    /// A block as it goes into the file.
    block: Vec<u8>,
    /// Where the compression is of that kind.
    zip: Option<Zip>,
}

impl Packer {
    fn new(header: &Header, mostly_float: bool) -> Self {
        Self {
            raw: Vec::new(),
            block: Vec::new(),
            zip: Zip::of(header.compression, mostly_float),
        }
    }

    /// Makes a block as the file has it: its first line, its length, and its pixels.
    fn pack(&mut self, header: &Header, stored: &StoredExr, index: usize) -> io::Result<()> {
        let Self { raw, block, zip } = self;
        let [width, height] = stored.size().map(|side| side as usize);
        let top = index * stored.lines_per_block() as usize;
        let lines = (stored.lines_per_block() as usize).min(height - top);
        block.clear();
        block.extend((stored.top() + top as i32).to_le_bytes());
        // The length comes later.
        block.extend([0; 4]);
        let start = block.len();
        if let Some(zip) = zip {
            zip.compress(raw, block);
        } else {
            let section = IntegerBounds::new((0, top as i32), (width, lines));
            let compression = header.compression;
            let pixels = compression
                .compress_image_section_to_le(header, std::mem::take(raw), section)
                .map_err(into_io)?;
            block.extend(pixels);
        }
        let length = i32::try_from(block.len() - start).map_err(|_| {
            let message = "a block of lines does not fit OpenEXR's limit of 2.1 GB";
            io::Error::new(io::ErrorKind::InvalidInput, message)
        })?;
        block[start - size_of::<i32>()..start].copy_from_slice(&length.to_le_bytes());
        Ok(())
    }
}

/// The file up to the offset table, attributes sorted by name.
fn head(stored: &StoredExr, rewritten: &Rewritten<'_>) -> io::Result<Vec<u8>> {
    let is_replaced = |attribute: &&Attribute| {
        let is = |name: &str| attribute.name == name.as_bytes();
        is("channels")
            || is("lineOrder")
            || rewritten.texts.iter().any(|(name, _)| is(name))
            || rewritten.left_out.iter().any(|name| is(name))
    };
    let stays = stored.attributes().iter();
    let mut attributes: Vec<Attribute> = stays.filter(|it| !is_replaced(it)).cloned().collect();
    let mut add = |name: &str, kind: &str, value: Vec<u8>| {
        attributes.push(Attribute {
            name: name.as_bytes().to_vec(),
            kind: kind.as_bytes().to_vec(),
            value,
        });
    };
    add("channels", "chlist", stored.channel_list(rewritten.kept));
    // From the top.
    add("lineOrder", "lineOrder", vec![0]);
    for (name, text) in rewritten.texts {
        add(name, "string", text.clone().into_bytes());
    }
    attributes.sort_by(|a, b| a.name.cmp(&b.name));

    let names = rewritten.kept.iter();
    let longest = names.map(|&kept| stored.names()[kept].len());
    let of_attributes = attributes.iter().map(|it| it.name.len().max(it.kind.len()));
    let has_long_names = longest
        .chain(of_attributes)
        .any(|length| length > SHORT_NAME);
    let version = 2 | if has_long_names { LONG_NAMES } else { 0 };
    stored_head(version, &attributes)
}

/// A file up to the offset table, with these attributes in this order.
///
/// # Errors
/// Where one does not fit the format.
pub(super) fn stored_head(version: u32, attributes: &[Attribute]) -> io::Result<Vec<u8>> {
    let mut bytes = super::read::MAGIC.to_vec();
    bytes.extend(u32::to_le_bytes(version));
    for Attribute { name, kind, value } in attributes {
        let size = i32::try_from(value.len()).map_err(|_| {
            let message = "an attribute does not fit OpenEXR's limit of 2.1 GB";
            io::Error::new(io::ErrorKind::InvalidInput, message)
        })?;
        for name in [name, kind] {
            bytes.extend(name);
            bytes.push(0);
        }
        bytes.extend(size.to_le_bytes());
        bytes.extend(value);
    }
    bytes.push(0);
    Ok(bytes)
}
