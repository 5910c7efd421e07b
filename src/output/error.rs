//! Why a file could not be written, what helps, and whether a later try may.

use std::io;
use std::path::{Path, PathBuf};

use super::{STANDARD_STREAM, folder_of};
use crate::printable::printable_path;

/// A file could not be written; the target is as it was before.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {problem}", name(path))]
pub struct OutputError {
    /// The target as the user named it.
    pub path: PathBuf,
    /// What failed, and the way out.
    pub problem: OutputProblem,
}

/// Why a file could not be written. Each message says the way out, where there is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputProblem {
    /// The target's folder is not there.
    #[error("the folder {} does not exist; create it, or choose another place", printable_path(.0))]
    MissingFolder(PathBuf),
    /// What should be the target's folder is something else.
    #[error("{} is not a folder; choose another place", printable_path(.0))]
    NotAFolder(PathBuf),
    /// The target names a folder.
    #[error("it is a folder; add a file name")]
    IsFolder,
    /// The target names nothing.
    #[error("the file name is empty; give one")]
    NoName,
    /// The name is longer than the file system can hold.
    #[error("the name is too long for the file system ({0}); choose a shorter one")]
    NameTooLong(io::Error),
    /// A disk or a socket, which a file neither replaces nor is written into.
    #[error("it is {0}; give the name of a file")]
    NotAFile(&'static str),
    /// The folder cannot be written to.
    #[error(
        "the folder {} cannot be written to ({error}); choose another place",
        printable_path(folder)
    )]
    ClosedFolder {
        /// The folder.
        folder: PathBuf,
        /// The system's reason.
        error: io::Error,
    },
    /// Nothing can be written to the file system.
    #[error("its file system is read-only ({0}); choose a place on another one")]
    ReadOnly(io::Error),
    /// The file is there and must not be overwritten.
    #[error("the file is there and is write-protected ({0}); remove it, or choose another name")]
    Protected(io::Error),
    /// No space left.
    #[error("the disk is full ({0}); free some space, or choose another place")]
    Full(io::Error),
    /// The user may not have more on this disk.
    #[error("the disk quota is used up ({0}); remove other files, or choose another place")]
    Quota(io::Error),
    /// The file would be larger than the process or the file system allows.
    #[error(
        "the file is larger than the file size limit ({0}); raise the limit (`ulimit -f`), choose \
         another place, or make the file smaller"
    )]
    SizeLimit(io::Error),
    /// What goes to standard output is kept in a temporary file first, and that failed.
    #[error(
        "the temporary folder {}, which keeps the file until it is whole, cannot be used ({error}); \
         choose another one by TMPDIR, or write to a file",
        printable_path(folder)
    )]
    Unassembled {
        /// The folder for temporary files.
        folder: PathBuf,
        /// The system's reason.
        error: io::Error,
    },
    /// The unfinished file was removed by somebody else.
    #[error("its unfinished file {} has been removed meanwhile; try again", printable_path(.0))]
    Removed(PathBuf),
    /// Symbolic links that lead to each other.
    #[error("its symbolic links lead in a circle; choose another name")]
    LinkLoop,
    /// Bytes that are no text would go to a terminal.
    #[error("it is a terminal, which cannot show the file; send it to a file or a pipe")]
    Terminal,
    /// The run was interrupted before the file was whole.
    #[error("interrupted; nothing was left behind")]
    Canceled,
    /// The disk, or the server that has it, failed.
    #[error("the disk or its server failed ({0}); try again, or choose another place")]
    Device(io::Error),
    /// Anything else that the system reports.
    #[error("{0}")]
    Io(io::Error),
}

impl OutputError {
    /// What an error while something is written to `path` means.
    pub fn new(path: &Path, error: io::Error) -> Self {
        Self {
            path: path.to_path_buf(),
            problem: classified(error),
        }
    }

    /// Whether a later try, or another machine, may do better with the same command: the disk is full,
    /// a quota or a limit is reached, a device fails.
    pub fn is_transient(&self) -> bool {
        match &self.problem {
            OutputProblem::Full(_)
            | OutputProblem::Quota(_)
            | OutputProblem::SizeLimit(_)
            | OutputProblem::Removed(_)
            | OutputProblem::Device(_) => true,
            OutputProblem::Io(error) | OutputProblem::Unassembled { error, .. } => {
                is_transient(error)
            }
            OutputProblem::MissingFolder(_)
            | OutputProblem::ClosedFolder { .. }
            | OutputProblem::NotAFolder(_)
            | OutputProblem::IsFolder
            | OutputProblem::NoName
            | OutputProblem::NameTooLong(_)
            | OutputProblem::NotAFile(_)
            | OutputProblem::ReadOnly(_)
            | OutputProblem::Protected(_)
            | OutputProblem::LinkLoop
            | OutputProblem::Terminal
            | OutputProblem::Canceled => false,
        }
    }

    /// Whether the reader of a pipe has gone away, as `head` does when it has seen enough.
    pub fn is_broken_pipe(&self) -> bool {
        matches!(&self.problem, OutputProblem::Io(error) if error.kind() == io::ErrorKind::BrokenPipe)
    }
}

/// Whether the same call may succeed later, or on another machine: the error tells of a disk, a server
/// or a limit, not of what was asked for.
pub fn is_transient(error: &io::Error) -> bool {
    use io::ErrorKind;
    matches!(
        error.kind(),
        ErrorKind::StorageFull
            | ErrorKind::QuotaExceeded
            | ErrorKind::FileTooLarge
            | ErrorKind::OutOfMemory
            | ErrorKind::StaleNetworkFileHandle
            | ErrorKind::TimedOut
            | ErrorKind::Interrupted
            | ErrorKind::WouldBlock
            | ErrorKind::ResourceBusy
            | ErrorKind::ConnectionReset
            | ErrorKind::ConnectionAborted
            | ErrorKind::ConnectionRefused
            | ErrorKind::NotConnected
            | ErrorKind::HostUnreachable
            | ErrorKind::NetworkUnreachable
            | ErrorKind::NetworkDown
    ) || is_device(error)
        || is_out_of_files(error)
}

/// Whether a device, or the server behind it, failed.
fn is_device(error: &io::Error) -> bool {
    use io::ErrorKind;
    // EIO, which has no kind of its own, is 5 on every Unix.
    let is_eio = cfg!(unix) && error.raw_os_error() == Some(5);
    is_eio
        || matches!(
            error.kind(),
            ErrorKind::StaleNetworkFileHandle | ErrorKind::TimedOut
        )
}

/// Whether too many files are open, in this process or in the system.
fn is_out_of_files(error: &io::Error) -> bool {
    // ENFILE and EMFILE, which have no kinds of their own, are 23 and 24 on every Unix.
    cfg!(unix) && matches!(error.raw_os_error(), Some(23 | 24))
}

/// What an error while a file is written means.
pub(super) fn classified(error: io::Error) -> OutputProblem {
    match error.kind() {
        io::ErrorKind::StorageFull => OutputProblem::Full(error),
        io::ErrorKind::QuotaExceeded => OutputProblem::Quota(error),
        io::ErrorKind::FileTooLarge => OutputProblem::SizeLimit(error),
        io::ErrorKind::ReadOnlyFilesystem => OutputProblem::ReadOnly(error),
        io::ErrorKind::InvalidFilename => OutputProblem::NameTooLong(error),
        io::ErrorKind::IsADirectory => OutputProblem::IsFolder,
        _ if is_device(&error) => OutputProblem::Device(error),
        _ => OutputProblem::Io(error),
    }
}

/// What an error while a file is looked for, created or renamed means.
pub(super) fn folder_problem(target: &Path, error: io::Error) -> OutputProblem {
    let folder = folder_of(target).to_path_buf();
    match error.kind() {
        io::ErrorKind::NotFound if !folder.exists() => OutputProblem::MissingFolder(folder),
        io::ErrorKind::NotADirectory => OutputProblem::NotAFolder(folder),
        io::ErrorKind::NotFound | io::ErrorKind::PermissionDenied => {
            OutputProblem::ClosedFolder { folder, error }
        }
        _ => classified(error),
    }
}

/// What an error while an existing file is opened means. To remove it is a way out only where its folder
/// can be written to.
pub(super) fn protection_problem(path: &Path, error: io::Error) -> OutputProblem {
    if error.kind() != io::ErrorKind::PermissionDenied {
        return classified(error);
    }
    match tempfile::tempfile_in(folder_of(path)) {
        Ok(_) => OutputProblem::Protected(error),
        Err(error) => folder_problem(path, error),
    }
}

/// What an error while the content is assembled means: the system's are about the temporary file.
pub(super) fn unassembled(error: io::Error) -> OutputProblem {
    if error.raw_os_error().is_none() {
        return classified(error);
    }
    let folder = std::env::temp_dir();
    OutputProblem::Unassembled { folder, error }
}

/// A target as messages name it.
fn name(path: &Path) -> String {
    if path.as_os_str() == STANDARD_STREAM {
        "to standard output".to_owned()
    } else if path.as_os_str().is_empty() {
        "an output".to_owned()
    } else {
        printable_path(path)
    }
}
