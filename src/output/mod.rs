//! Output files appear whole or not at all.
//!
//! A file is written beside its target under a temporary name, flushed to the disk, and renamed:
//! whoever looks sees the old file or the new one, never a part. On any error, and when the run is
//! [canceled](Unfinished::cancel), the temporary file is removed and the target stays as it was. What
//! a killed run has left is removed by the next one that writes to the same target on the same host.

mod early;
mod error;
mod stream;
mod target;
mod temporary;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;
use std::fs::{self, File, Permissions};
use std::io::{self, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tempfile::NamedTempFile;

use early::{EarlySync, Syncing};
#[doc(hidden)]
pub use error::is_transient;
pub use error::{OutputError, OutputProblem};
use error::{classified, folder_problem};
#[doc(hidden)]
pub use target::Place;
use target::{Target, resolve};

/// The name of standard output, and of standard input where something is read. A file of that name is
/// `./-`.
const STANDARD_STREAM: &str = "-";

/// The folder that holds `path`.
fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// What a file's content is written to, by any thread.
#[doc(hidden)]
pub trait Sink: Write + Seek + Send {}

impl<T: Write + Seek + Send> Sink for T {}

/// The temporary files that one run has under way.
///
/// Clones share one list, so that a signal handler can hold one of them. Creation, renaming and
/// cancellation exclude each other: after [`Unfinished::cancel`] no temporary file is left and no
/// target changes any more.
///
/// ```
/// use candela::output::{self, Unfinished};
///
/// let unfinished = Unfinished::new();
/// let at_interrupt = unfinished.clone();
/// // What a signal handler does before it ends the process:
/// at_interrupt.cancel();
/// let late = output::write("late.exr".as_ref(), &unfinished, |_| Ok(()));
/// assert!(late.is_err());
/// ```
#[derive(Clone, Debug, Default)]
pub struct Unfinished {
    shared: Arc<Mutex<State>>,
}

#[derive(Debug, Default)]
struct State {
    canceled: bool,
    files: BTreeSet<PathBuf>,
}

impl Unfinished {
    /// Nothing under way.
    pub fn new() -> Self {
        Self::default()
    }

    /// Removes what is under way, and lets nothing appear from now on: to be called when the run
    /// is interrupted. A file that was renamed before stays, whole.
    pub fn cancel(&self) {
        let mut state = self.lock();
        state.canceled = true;
        for file in std::mem::take(&mut state.files) {
            // Nobody is left to tell; the file may have gone with its folder.
            let _ = fs::remove_file(file);
        }
    }

    /// Whether [`Unfinished::cancel`] has been called.
    pub fn is_canceled(&self) -> bool {
        self.lock().canceled
    }

    /// A set of paths stays a set of paths, even if another thread panicked meanwhile.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Writes a file by `content`, whole or not at all.
///
/// A symbolic link is followed, what it points at is replaced. An existing file keeps its
/// permissions, a new one gets those that the umask leaves. `-` is standard output; a file of that
/// name is `./-`. Devices and pipes (`/dev/null`) are written to as they are. Since neither can seek,
/// the content is assembled first: in memory, or where it is large, in a temporary file without a name.
///
/// # Errors
/// Whatever the system or `content` reports; see [`OutputProblem`].
pub fn write<T>(
    path: &Path,
    unfinished: &Unfinished,
    content: impl FnOnce(&mut dyn Sink) -> io::Result<T>,
) -> Result<T, OutputError> {
    let (result, written) = begin(path, unfinished, content)?;
    written.finish()?;
    Ok(result)
}

/// Writes a file by `content` as [`write()`] does, but for its way to the disk and its name: these are left to
/// [`Written::finish`], on any thread, while something else is being done.
///
/// # Errors
/// As [`write()`].
#[doc(hidden)]
pub fn begin<T>(
    path: &Path,
    unfinished: &Unfinished,
    content: impl FnOnce(&mut dyn Sink) -> io::Result<T>,
) -> Result<(T, Written), OutputError> {
    let begun = match resolve(path) {
        Ok(Target::File {
            path: target,
            existing,
        }) => begin_file(target, existing, unfinished, content)
            .map(|(result, file)| (result, Some(file))),
        Ok(Target::Stream | Target::StandardOutput) if unfinished.is_canceled() => {
            Err(OutputProblem::Canceled)
        }
        Ok(Target::Stream) => stream::write(path, content).map(|result| (result, None)),
        Ok(Target::StandardOutput) => stream::write_standard(content).map(|result| (result, None)),
        Err(problem) => Err(problem),
    };
    let path = path.to_path_buf();
    match begun {
        Ok((result, file)) => Ok((result, Written { path, file })),
        Err(problem) => Err(OutputError { path, problem }),
    }
}

/// A file whose content is written, but which has not got its name.
#[doc(hidden)]
pub struct Written {
    path: PathBuf,
    /// None of what is no file.
    file: Option<WrittenFile>,
}

struct WrittenFile {
    temporary: NamedTempFile,
    syncing: Syncing,
    target: PathBuf,
    unfinished: Unfinished,
}

impl Written {
    /// Waits until the disk has it, and gives it its name.
    ///
    /// # Errors
    /// As [`write()`]; the target stays as it was.
    pub fn finish(self) -> Result<(), OutputError> {
        let finished = self.file.map_or(Ok(()), WrittenFile::finish);
        finished.map_err(|problem| OutputError {
            path: self.path,
            problem,
        })
    }
}

impl WrittenFile {
    /// A full disk or a lost server must be known before the old file goes.
    fn finish(self) -> Result<(), OutputProblem> {
        let Self {
            temporary,
            syncing,
            target,
            unfinished,
        } = self;
        let name = temporary.path().to_path_buf();
        let synced = syncing.finish();
        let mut state = unfinished.lock();
        state.files.remove(&name);
        if state.canceled {
            return Err(OutputProblem::Canceled);
        }
        // Dropping the temporary file on an error removes it.
        synced.map_err(classified)?;
        temporary.persist(&target).map_err(|error| {
            let is_removed = error.error.kind() == io::ErrorKind::NotFound;
            if is_removed && folder_of(&target).exists() {
                OutputProblem::Removed(name)
            } else {
                folder_problem(&target, error.error)
            }
        })?;
        Ok(())
    }
}

/// Finds out whether a file could be written, without leaving anything behind: for long work whose
/// result goes there.
///
/// # Errors
/// As [`write()`], as far as it can be known before.
#[doc(hidden)]
pub fn check(path: &Path) -> Result<(), OutputError> {
    let checked = match resolve(path) {
        Ok(Target::File { path: target, .. }) => tempfile::tempfile_in(folder_of(&target))
            .map(drop)
            .map_err(|error| folder_problem(&target, error)),
        Ok(Target::Stream | Target::StandardOutput) => Ok(()),
        Err(problem) => Err(problem),
    };
    checked.map_err(|problem| OutputError {
        path: path.to_path_buf(),
        problem,
    })
}

fn begin_file<T>(
    target: PathBuf,
    existing: Option<Permissions>,
    unfinished: &Unfinished,
    content: impl FnOnce(&mut dyn Sink) -> io::Result<T>,
) -> Result<(T, WrittenFile), OutputProblem> {
    // Created and listed in one step, so that no interruption falls between.
    let temporary = {
        let mut state = unfinished.lock();
        if state.canceled {
            return Err(OutputProblem::Canceled);
        }
        let temporary =
            temporary::create(&target).map_err(|error| folder_problem(&target, error))?;
        state.files.insert(temporary.path().to_path_buf());
        temporary
    };
    match fill(temporary.as_file(), existing, content) {
        Ok((result, syncing)) => {
            let file = WrittenFile {
                temporary,
                syncing,
                target,
                unfinished: unfinished.clone(),
            };
            Ok((result, file))
        }
        Err(error) => {
            let mut state = unfinished.lock();
            state.files.remove(temporary.path());
            Err(if state.canceled {
                OutputProblem::Canceled
            } else {
                classified(error)
            })
        }
    }
}

/// Writes the content.
fn fill<T>(
    file: &File,
    existing: Option<Permissions>,
    content: impl FnOnce(&mut dyn Sink) -> io::Result<T>,
) -> io::Result<(T, Syncing)> {
    if let Some(permissions) = existing {
        file.set_permissions(permissions)?;
    }
    let mut sink = EarlySync::new(file.try_clone()?);
    let result = content(&mut sink)?;
    Ok((result, sink.written()?))
}
