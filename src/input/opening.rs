//! Files that a scene names, opened only where they are files.

use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::path::Path;

/// What is not a file: a folder, a device, a pipe. Opening a pipe would wait for its other end.
#[derive(Debug, thiserror::Error)]
#[error("it is {found}")]
pub struct NotAFile {
    /// "a directory", "a device or pipe"
    pub found: &'static str,
}

/// Opens the file at `path` and says its size in bytes.
///
/// # Errors
/// [`NotAFile`], and what the system says where it cannot be opened.
pub(crate) fn open<E: From<NotAFile> + From<io::Error>>(path: &Path) -> Result<(File, u64), E> {
    let metadata = fs::metadata(path)?;
    let kind = metadata.file_type();
    if kind.is_file() {
        Ok((File::open(path)?, metadata.len()))
    } else if kind.is_dir() {
        Err(E::from(NotAFile {
            found: "a directory",
        }))
    } else {
        Err(E::from(NotAFile {
            found: "a device or pipe",
        }))
    }
}

/// Whether a later try, or another machine, may read an input: it is there and may be read, but memory
/// was short or reading failed.
pub(crate) fn is_transient(error: &io::Error) -> bool {
    // Of many kinds, and more to come, these are about what was written; others are the machine's.
    let is_wrong = matches!(
        error.kind(),
        ErrorKind::NotFound
            | ErrorKind::PermissionDenied
            | ErrorKind::IsADirectory
            | ErrorKind::NotADirectory
            | ErrorKind::InvalidFilename
            | ErrorKind::InvalidInput
            | ErrorKind::InvalidData
            | ErrorKind::Unsupported
    );
    !is_wrong && !leads_to_no_file(error)
}

/// Whether a path is a circle of links (ELOOP), or leads to a socket or a device that nobody answers for
/// (ENXIO, ENODEV). None of them has a kind of its own.
fn leads_to_no_file(error: &io::Error) -> bool {
    const ENXIO: i32 = 6;
    const ENODEV: i32 = 19;
    const ELOOP: i32 = if cfg!(target_os = "linux") { 40 } else { 62 };
    cfg!(unix) && matches!(error.raw_os_error(), Some(ENXIO | ENODEV | ELOOP))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_another_try_may_cure() {
        for kind in [ErrorKind::OutOfMemory, ErrorKind::UnexpectedEof] {
            assert!(is_transient(&kind.into()), "{kind}");
        }
        // EIO: input/output error.
        #[cfg(unix)]
        assert!(is_transient(&io::Error::from_raw_os_error(5)));
        for kind in [ErrorKind::NotFound, ErrorKind::PermissionDenied] {
            assert!(!is_transient(&kind.into()), "{kind}");
        }
        // ENXIO, ENODEV, ELOOP.
        #[cfg(target_os = "linux")]
        for code in [6, 19, 40] {
            let error = io::Error::from_raw_os_error(code);
            assert!(!is_transient(&error), "{error}");
        }
    }
}
