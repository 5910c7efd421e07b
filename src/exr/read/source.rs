//! Where the bytes of an OpenEXR file come from: a file, which is read piece by piece, or memory, into
//! which a pipe is read whole, since an EXR cannot be read from front to back.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use sha2::{Digest, Sha256};

use super::ExrProblem;
use crate::input::Hash;

/// What every OpenEXR file begins with.
pub(in crate::exr) const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// The most that is read from a pipe: 4 GiB.
const MAX_PIPED: usize = 1 << 32;

/// Memory for a pipe grows by at least so much; so much is hashed at a time.
const PIECE: usize = 1 << 20;

/// The bytes of a file, at any place.
#[derive(Debug)]
pub(super) struct Source {
    length: u64,
    bytes: Bytes,
}

#[derive(Debug)]
enum Bytes {
    File(Mutex<File>),
    Memory(Vec<u8>),
}

impl Source {
    /// A file by its path, `-` for standard input; pipes and devices are read into memory.
    pub(super) fn open(path: &Path) -> Result<Self, ExrProblem> {
        if path == Path::new("-") {
            return Self::of_stream(&mut io::stdin().lock());
        }
        let mut file = File::open(path).map_err(ExrProblem::Io)?;
        let metadata = file.metadata().map_err(ExrProblem::Io)?;
        if metadata.is_dir() {
            return Err(ExrProblem::Io(io::ErrorKind::IsADirectory.into()));
        }
        if metadata.is_file() {
            return Ok(Self::of_file(file, metadata.len()));
        }
        Self::of_stream(&mut file)
    }

    /// What is left of a stream that cannot seek.
    pub(super) fn of_stream(stream: &mut dyn Read) -> Result<Self, ExrProblem> {
        let mut bytes = Vec::new();
        loop {
            if bytes.len() == bytes.capacity() {
                let more = bytes.len().max(PIECE);
                bytes.try_reserve(more).map_err(|_| ExrProblem::NoMemory {
                    bytes: (bytes.len() + more) as u64,
                })?;
            }
            let room = bytes.capacity() - bytes.len();
            let read = stream
                .take(room as u64)
                .read_to_end(&mut bytes)
                .map_err(ExrProblem::Io)?;
            // What is no EXR may have no end, as /dev/zero.
            if !bytes.starts_with(&MAGIC[..bytes.len().min(MAGIC.len())]) {
                return Err(ExrProblem::NotExr);
            }
            if read == 0 {
                return Ok(Self::of_memory(bytes));
            }
            if bytes.len() > MAX_PIPED {
                return Err(ExrProblem::Unsupported(
                    "what comes through the pipe is longer than 4 GiB; write it to a file first"
                        .to_owned(),
                ));
            }
        }
    }

    /// A file in memory.
    pub(super) fn of_memory(bytes: Vec<u8>) -> Self {
        Self {
            length: bytes.len() as u64,
            bytes: Bytes::Memory(bytes),
        }
    }

    fn of_file(file: File, length: u64) -> Self {
        Self {
            length,
            bytes: Bytes::File(Mutex::new(file)),
        }
    }

    /// The file's length when it was opened.
    pub(super) const fn length(&self) -> u64 {
        self.length
    }

    /// Fills `bytes` from the place `start` on.
    pub(super) fn read_at(&self, start: u64, bytes: &mut [u8]) -> Result<(), ExrProblem> {
        let end = start.checked_add(bytes.len() as u64);
        if end.is_none_or(|end| end > self.length) {
            return Err(ExrProblem::Damaged("it ends too early".to_owned()));
        }
        match &self.bytes {
            Bytes::Memory(all) => {
                bytes.copy_from_slice(&all[start as usize..][..bytes.len()]);
                Ok(())
            }
            Bytes::File(file) => {
                // A place in a file stays one, even if another thread panicked meanwhile.
                let mut file = file.lock().unwrap_or_else(PoisonError::into_inner);
                file.seek(SeekFrom::Start(start))
                    .and_then(|_| file.read_exact(bytes))
                    .map_err(ExrProblem::Io)
            }
        }
    }

    /// The hash of all bytes.
    pub(super) fn hash(&self) -> Result<Hash, ExrProblem> {
        let mut hash = Sha256::new();
        let mut piece = Vec::new();
        super::resize(&mut piece, PIECE.min(self.length as usize), 0)?;
        let mut place = 0;
        while place < self.length {
            let count = (self.length - place).min(PIECE as u64) as usize;
            self.read_at(place, &mut piece[..count])?;
            hash.update(&piece[..count]);
            place += count as u64;
        }
        Ok(Hash::finished(hash))
    }

    /// So many bytes from the place `start` on.
    pub(super) fn bytes_at(&self, start: u64, count: usize) -> Result<Vec<u8>, ExrProblem> {
        // Before memory is asked for.
        if start.saturating_add(count as u64) > self.length {
            return Err(ExrProblem::Damaged("it ends too early".to_owned()));
        }
        let mut bytes = Vec::new();
        super::resize(&mut bytes, count, 0)?;
        self.read_at(start, &mut bytes)?;
        Ok(bytes)
    }
}

/// The source read from front to back, for headers.
pub(super) struct Cursor<'s> {
    source: &'s Source,
    place: u64,
    /// What was read ahead, from `buffer_start` on.
    buffer: Vec<u8>,
    buffer_start: u64,
}

/// Bytes that are read ahead.
const AHEAD: u64 = 1 << 16;

impl<'s> Cursor<'s> {
    pub(super) const fn new(source: &'s Source) -> Self {
        Self {
            source,
            place: 0,
            buffer: Vec::new(),
            buffer_start: 0,
        }
    }

    pub(super) const fn place(&self) -> u64 {
        self.place
    }

    pub(super) fn skip(&mut self, count: u64) -> Result<(), ExrProblem> {
        self.place = self.place.saturating_add(count);
        if self.place > self.source.length {
            return Err(ExrProblem::Damaged("it ends in the header".to_owned()));
        }
        Ok(())
    }

    /// Whether there are so many bytes left.
    pub(super) fn check(&self, count: usize) -> Result<(), ExrProblem> {
        if self.place.saturating_add(count as u64) > self.source.length {
            return Err(ExrProblem::Damaged("it ends in the header".to_owned()));
        }
        Ok(())
    }

    pub(super) fn byte(&mut self) -> Result<u8, ExrProblem> {
        let is_here = |cursor: &Self| {
            let offset = cursor.place.checked_sub(cursor.buffer_start)?;
            cursor.buffer.get(offset as usize).copied()
        };
        if let Some(byte) = is_here(self) {
            self.place += 1;
            return Ok(byte);
        }
        let count = AHEAD.min(self.source.length - self.place);
        self.buffer = self.source.bytes_at(self.place, count as usize)?;
        self.buffer_start = self.place;
        let byte = is_here(self);
        self.place += 1;
        byte.ok_or_else(|| ExrProblem::Damaged("it ends in the header".to_owned()))
    }

    pub(super) fn array<const N: usize>(&mut self) -> Result<[u8; N], ExrProblem> {
        let mut bytes = [0; N];
        for byte in &mut bytes {
            *byte = self.byte()?;
        }
        Ok(bytes)
    }

    /// A text up to a zero byte, of at most 255 bytes.
    pub(super) fn text(&mut self) -> Result<Vec<u8>, ExrProblem> {
        let mut text = Vec::new();
        loop {
            match self.byte()? {
                0 => return Ok(text),
                _ if text.len() == 255 => {
                    return Err(ExrProblem::Damaged(
                        "a name in the header has no end".to_owned(),
                    ));
                }
                byte => text.push(byte),
            }
        }
    }

    /// So many bytes of the header.
    pub(super) fn bytes(&mut self, count: usize) -> Result<Vec<u8>, ExrProblem> {
        let bytes = self.source.bytes_at(self.place, count)?;
        self.place += count as u64;
        Ok(bytes)
    }
}
