//! A mesh file that is read block by block.

use std::io::{self, Read, Seek, SeekFrom};

use super::separators::is_separator;
use super::text::Dialect;

/// Bytes that are read at once: enough to hide what a call costs, few enough to stay in a
/// processor's cache until they are parsed.
const BLOCK: usize = 256 << 10;

/// Bytes that are read at once where a file should have ended.
const LEAST_BLOCK: usize = 4 << 10;

/// Where a file's bytes come from.
pub(super) trait Input: Read + Seek {}

impl<T: Read + Seek> Input for T {}

/// The part of a file that is looked at: it moves forwards, and grows where a line or an element
/// is longer than a block.
pub(super) struct Source<'r> {
    input: &'r mut dyn Input,
    /// Those of the file from `offset` on, the first `start` of them done with.
    buffer: Vec<u8>,
    start: usize,
    offset: usize,
    /// Whether the file ends with the buffer.
    ended: bool,
    size: usize,
}

impl<'r> Source<'r> {
    /// The first block of a file of `size` bytes, or more if it grows meanwhile.
    ///
    /// # Errors
    /// Besides what reading can meet, here and below: no memory, and a file that has become shorter
    /// than it was.
    pub(super) fn new(input: &'r mut dyn Input, size: usize) -> io::Result<Self> {
        let mut source = Self {
            input,
            buffer: Vec::new(),
            start: 0,
            offset: 0,
            ended: false,
            size,
        };
        source.read_on()?;
        Ok(source)
    }

    /// The size of the file in bytes, as it was told.
    pub(super) const fn size(&self) -> usize {
        self.size
    }

    /// The bytes that are looked at.
    pub(super) fn window(&self) -> &[u8] {
        &self.buffer[self.start..]
    }

    /// Where the window starts in the file, in bytes.
    pub(super) const fn position(&self) -> usize {
        self.offset + self.start
    }

    /// Whether nothing of the file comes after the window.
    pub(super) const fn has_ended(&self) -> bool {
        self.ended
    }

    /// How many bytes are left from the window's start on, if the file is as long as it was told.
    pub(super) fn remaining(&self) -> usize {
        let seen = self.offset + self.buffer.len();
        self.window().len() + self.size.saturating_sub(seen)
    }

    /// Is done with the first `count` bytes of the window.
    pub(super) fn skip(&mut self, count: usize) {
        self.start = (self.start + count).min(self.buffer.len());
    }

    /// Adds to the window what comes next, as much again if it is long; whether there is
    /// anything in it then.
    pub(super) fn read_on(&mut self) -> io::Result<bool> {
        if !self.ended {
            self.offset += self.start;
            self.buffer.drain(..self.start);
            self.start = 0;
            // One byte more than there should be shows that the file has ended.
            let rest = self.remaining() - self.buffer.len() + 1;
            let room = BLOCK.max(self.buffer.len()).min(LEAST_BLOCK.max(rest));
            self.buffer.try_reserve_exact(room)?;
            let mut block = Read::take(&mut *self.input, room as u64);
            self.ended = block.read_to_end(&mut self.buffer)? < room;
            if self.ended && self.offset + self.buffer.len() < self.size {
                let changed = "the file became shorter while it was read";
                return Err(io::Error::new(io::ErrorKind::UnexpectedEof, changed));
            }
        }
        Ok(!self.window().is_empty())
    }

    /// The whole lines, those that `\` joins together, that the window has; it grows until it has
    /// one. Only the last line of a file may have no end.
    pub(super) fn lines(&mut self, dialect: Dialect) -> io::Result<&[u8]> {
        loop {
            if self.ended {
                return Ok(self.window());
            }
            if let Some(length) = whole_lines(self.window(), dialect) {
                return Ok(&self.window()[..length]);
            }
            self.read_on()?;
        }
    }

    /// Adds to the window all that comes.
    pub(super) fn read_all(&mut self) -> io::Result<()> {
        while !self.ended {
            self.read_on()?;
        }
        Ok(())
    }

    /// Goes back or forth to a byte of the file.
    pub(super) fn go_to(&mut self, position: usize) -> io::Result<()> {
        self.input.seek(SeekFrom::Start(position as u64))?;
        self.buffer.clear();
        self.start = 0;
        self.offset = position;
        self.ended = false;
        self.read_on()?;
        Ok(())
    }

    /// Goes to the end of the file; how many bytes were left, but for blanks at the end.
    pub(super) fn count_rest(&mut self) -> io::Result<u64> {
        let mut passed = 0;
        let mut count = 0;
        loop {
            let window = self.window();
            let length = window.len();
            if let Some(last) = window.iter().rposition(|&byte| !is_separator(byte)) {
                count = passed + last as u64 + 1;
            }
            passed += length as u64;
            self.skip(length);
            if !self.read_on()? {
                return Ok(count);
            }
        }
    }

    /// The line of the byte that is `ahead` of the window's start, the first one 1. Read again
    /// from the file's beginning, so that nobody counts lines before there is an error to report;
    /// the window is lost.
    pub(super) fn line(&mut self, ahead: usize) -> io::Result<usize> {
        let mut before = self.position() + ahead;
        let mut line = 1;
        let mut last = b'\n';
        self.go_to(0)?;
        while before > 0 {
            let window = self.window();
            let length = window.len().min(before);
            for &byte in &window[..length] {
                let ends = byte == b'\r' || byte == b'\n' && last != b'\r';
                line += usize::from(ends);
                last = byte;
            }
            before -= length;
            self.skip(length);
            if !self.read_on()? {
                break;
            }
        }
        Ok(line)
    }
}

/// The length of the lines in `bytes` that end there and are not joined to one that does not.
///
/// A CR that is the last byte may be half of a line end.
fn whole_lines(bytes: &[u8], dialect: Dialect) -> Option<usize> {
    let mut end = match bytes {
        [rest @ .., b'\r'] => rest.len(),
        _ => bytes.len(),
    };
    loop {
        end = bytes[..end].iter().rposition(|&byte| is_line_end(byte))?;
        let joined = match dialect {
            Dialect::Ply | Dialect::UnlinedPly => false,
            Dialect::Obj => {
                let line = bytes[..end].strip_suffix(b"\r").unwrap_or(&bytes[..end]);
                let blank = |&&byte: &&u8| !is_line_end(byte) && is_separator(byte);
                line.iter().rev().find(|byte| !blank(byte)) == Some(&b'\\')
            }
        };
        if !joined {
            return Some(end + 1);
        }
    }
}

const fn is_line_end(byte: u8) -> bool {
    matches!(byte, b'\n' | b'\r')
}

#[cfg(test)]
mod tests;
