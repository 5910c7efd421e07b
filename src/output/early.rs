//! A file that is on its way to the disk while it is being written.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::panic::resume_unwind;
use std::sync::Arc;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

/// So many bytes are worth a trip to the disk.
const TRIP: usize = 4 << 20;

/// Writes a file, and has a thread wait for the disk meanwhile: whoever waits for the whole at the end
/// waits for the last bytes only.
pub(super) struct EarlySync {
    file: BufWriter<Arc<File>>,
    /// Bytes that nobody has been asked to see to the disk.
    unsynced: usize,
    /// None before there is enough for it.
    disk: Option<Disk>,
}

/// The thread that waits for the disk.
struct Disk {
    ask: SyncSender<()>,
    thread: JoinHandle<io::Result<()>>,
}

/// A file that is written, and on its way to the disk.
pub(super) struct Syncing {
    file: Arc<File>,
    disk: Option<Disk>,
}

impl EarlySync {
    pub(super) fn new(file: File) -> Self {
        Self {
            file: BufWriter::new(Arc::new(file)),
            unsynced: 0,
            disk: None,
        }
    }

    /// The file once everything is written, whether the disk has it or not.
    ///
    /// # Errors
    /// If it cannot be written.
    pub(super) fn written(self) -> io::Result<Syncing> {
        let disk = self.disk;
        let file = self
            .file
            .into_inner()
            .map_err(io::IntoInnerError::into_error)?;
        Ok(Syncing { file, disk })
    }

    fn sync(&mut self) {
        if self.disk.is_none() {
            let (ask, asked) = sync_channel(1);
            let file = Arc::clone(self.file.get_ref());
            let wait = move || asked.iter().try_for_each(|()| file.sync_data());
            // Without a thread everything goes at the end.
            let thread = Builder::new().spawn(wait).ok();
            self.disk = thread.map(|thread| Disk { ask, thread });
        }
        if let Some(disk) = &self.disk {
            // A trip that is asked for already takes these bytes along.
            let _ = disk.ask.try_send(());
        }
    }
}

impl Syncing {
    /// Waits until the disk has everything.
    ///
    /// # Errors
    /// The first that there was on the way to the disk: the system tells each but once.
    pub(super) fn finish(self) -> io::Result<()> {
        if let Some(Disk { ask, thread }) = self.disk {
            drop(ask);
            thread.join().unwrap_or_else(|panic| resume_unwind(panic))?;
        }
        self.file.sync_all()
    }
}

impl Write for EarlySync {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.unsynced += written;
        if self.unsynced >= TRIP {
            self.unsynced = 0;
            self.sync();
        }
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for EarlySync {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn everything_arrives() {
        for trips in [0, 1, 3] {
            let file = tempfile::NamedTempFile::new().unwrap();
            let bytes: Vec<u8> = (0..trips * TRIP + 1000).map(|i| i as u8).collect();
            let mut early = EarlySync::new(file.as_file().try_clone().unwrap());
            for piece in bytes.chunks(100_001) {
                early.write_all(piece).unwrap();
            }
            early.seek(SeekFrom::Start(3)).unwrap();
            early.write_all(b"there").unwrap();
            assert_eq!(early.disk.is_some(), trips > 0);
            early.written().unwrap().finish().unwrap();
            let mut expected = bytes;
            expected[3..8].copy_from_slice(b"there");
            assert!(fs::read(file.path()).unwrap() == expected);
        }
    }
}
