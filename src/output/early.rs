//! A file that is on its way to the disk while it is being written.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::panic::resume_unwind;
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{Builder, Scope, ScopedJoinHandle};

/// So many bytes are worth a trip to the disk.
const TRIP: usize = 4 << 20;

/// Writes a file, and has a thread wait for the disk meanwhile: whoever waits for the whole at the end
/// waits for the last bytes only.
pub(super) struct EarlySync<'scope, 'env> {
    file: BufWriter<&'env File>,
    scope: &'scope Scope<'scope, 'env>,
    /// Bytes that nobody has been asked to see to the disk.
    unsynced: usize,
    /// None before there is enough for it.
    disk: Option<Disk<'scope>>,
}

/// The thread that waits for the disk.
struct Disk<'scope> {
    ask: SyncSender<()>,
    thread: ScopedJoinHandle<'scope, io::Result<()>>,
}

impl<'scope, 'env> EarlySync<'scope, 'env> {
    pub(super) fn new(file: &'env File, scope: &'scope Scope<'scope, 'env>) -> Self {
        Self {
            file: BufWriter::new(file),
            scope,
            unsynced: 0,
            disk: None,
        }
    }

    /// Waits until the disk has everything.
    ///
    /// # Errors
    /// The first that there was, while writing or on the way to the disk: the system tells each but once.
    pub(super) fn finish(mut self) -> io::Result<()> {
        self.file.flush()?;
        if let Some(Disk { ask, thread }) = self.disk {
            drop(ask);
            thread.join().unwrap_or_else(|panic| resume_unwind(panic))?;
        }
        self.file.get_ref().sync_all()
    }

    fn sync(&mut self) {
        if self.disk.is_none() {
            let (ask, asked) = sync_channel(1);
            let file: &File = self.file.get_ref();
            let wait = move || asked.iter().try_for_each(|()| file.sync_data());
            // Without a thread everything goes at the end.
            let thread = Builder::new().spawn_scoped(self.scope, wait).ok();
            self.disk = thread.map(|thread| Disk { ask, thread });
        }
        if let Some(disk) = &self.disk {
            // A trip that is asked for already takes these bytes along.
            let _ = disk.ask.try_send(());
        }
    }
}

impl Write for EarlySync<'_, '_> {
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

impl Seek for EarlySync<'_, '_> {
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
            std::thread::scope(|scope| {
                let mut early = EarlySync::new(file.as_file(), scope);
                for piece in bytes.chunks(100_001) {
                    early.write_all(piece).unwrap();
                }
                early.seek(SeekFrom::Start(3)).unwrap();
                early.write_all(b"there").unwrap();
                assert_eq!(early.disk.is_some(), trips > 0);
                early.finish().unwrap();
            });
            let mut expected = bytes;
            expected[3..8].copy_from_slice(b"there");
            assert!(fs::read(file.path()).unwrap() == expected);
        }
    }
}
