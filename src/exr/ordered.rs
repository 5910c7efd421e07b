//! Blocks that come in any order, written in the order of the lines, after a table that says where each is.

use std::collections::BTreeMap;
use std::io::{self, SeekFrom};

use crate::output::Sink;

/// The blocks of a file that is being written.
pub(super) struct Ordered<'f> {
    sink: &'f mut dyn Sink,
    /// Where the offset table is.
    table: u64,
    /// Where the next block goes.
    position: u64,
    /// Where each block is, as far as they are written.
    offsets: Vec<u64>,
    /// Blocks that came before one above them, by their index.
    early: BTreeMap<usize, Vec<u8>>,
}

impl<'f> Ordered<'f> {
    /// Writes the head, and keeps room for the table of so many blocks.
    ///
    /// # Errors
    /// What the sink reports.
    pub(super) fn begin(
        sink: &'f mut dyn Sink,
        mut head: Vec<u8>,
        blocks: usize,
    ) -> io::Result<Self> {
        let table = head.len() as u64;
        head.resize(head.len() + blocks * size_of::<u64>(), 0);
        sink.write_all(&head)?;
        Ok(Self {
            sink,
            table,
            position: head.len() as u64,
            offsets: Vec::with_capacity(blocks),
            early: BTreeMap::new(),
        })
    }

    /// Takes the block with this index, and writes all that is there without a gap.
    ///
    /// # Errors
    /// What the sink reports.
    pub(super) fn add(&mut self, index: usize, block: &[u8]) -> io::Result<()> {
        if index > self.offsets.len() {
            self.early.insert(index, block.to_vec());
            return Ok(());
        }
        self.write(block)?;
        while let Some(block) = self.early.remove(&self.offsets.len()) {
            self.write(&block)?;
        }
        Ok(())
    }

    fn write(&mut self, block: &[u8]) -> io::Result<()> {
        self.sink.write_all(block)?;
        self.offsets.push(self.position);
        self.position += block.len() as u64;
        Ok(())
    }

    /// Writes the table, after all blocks have come, and over some places of the head what is known by then; the
    /// file's length.
    ///
    /// # Errors
    /// What the sink reports.
    pub(super) fn finish(self, patches: &[(u64, &[u8])]) -> io::Result<u64> {
        let sink = self.sink;
        sink.seek(SeekFrom::Start(self.table))?;
        let offsets = self.offsets.into_iter();
        let table: Vec<u8> = offsets.flat_map(u64::to_le_bytes).collect();
        sink.write_all(&table)?;
        for &(place, bytes) in patches {
            sink.seek(SeekFrom::Start(place))?;
            sink.write_all(bytes)?;
        }
        sink.flush()?;
        Ok(self.position)
    }
}
