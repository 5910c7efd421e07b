//! A file on its way to a stream, which can be read before it goes.

use std::fs::{File, OpenOptions};
use std::io;
use std::path::Path;

use tempfile::{Builder, TempPath};

use super::error::{OutputError, OutputProblem, kept, unassembled};
use super::target::{Target, resolve};
use super::{Sink, Unfinished, write};

/// A file in the folder for temporary files that stands for a device, a pipe or standard output: what was
/// sent there cannot be read again.
///
/// ```
/// use std::io::Write;
/// use std::path::Path;
///
/// use candela::output::{self, Staged, Unfinished};
///
/// let (target, unfinished) = (Path::new("/dev/null"), Unfinished::new());
/// match Staged::new(target, &unfinished)? {
///     Some(staged) => {
///         staged.fill(target, |sink| sink.write_all(b"a picture"))?;
///         // Here it can be read from `staged.path()`.
///         staged.send(target)?;
///     }
///     None => output::write(target, &unfinished, |sink| sink.write_all(b"a picture"))?,
/// }
/// # Ok::<(), output::OutputError>(())
/// ```
#[derive(Debug)]
pub struct Staged {
    path: TempPath,
    unfinished: Unfinished,
}

impl Staged {
    /// A file for a target that cannot be read again; `None` for one that can, a file.
    ///
    /// # Errors
    /// Where the target cannot be written to, or there is no room for temporary files.
    pub fn new(target: &Path, unfinished: &Unfinished) -> Result<Option<Self>, OutputError> {
        let failed = |problem| OutputError {
            path: target.to_path_buf(),
            problem,
        };
        match resolve(target).map_err(failed)? {
            Target::File { .. } => return Ok(None),
            Target::Stream | Target::StandardOutput => {}
        }
        // Created and listed in one step, so that no interruption falls between.
        let mut state = unfinished.lock();
        if state.canceled {
            return Err(failed(OutputProblem::Canceled));
        }
        let file = Builder::new()
            .prefix(".candela-")
            .suffix(".tmp")
            .make(|path| private().open(path));
        let file = file.map_err(|error| failed(unassembled(error)))?;
        let path = file.into_temp_path();
        state.files.insert(path.to_path_buf());
        Ok(Some(Self {
            path,
            unfinished: unfinished.clone(),
        }))
    }

    /// Where it is written, and can be read.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes it, as [`write()`] does.
    ///
    /// # Errors
    /// Whatever the system or `content` reports, of the target that the user knows.
    pub fn fill<T>(
        &self,
        target: &Path,
        content: impl FnOnce(&mut dyn Sink) -> io::Result<T>,
    ) -> Result<T, OutputError> {
        write(self.path(), &self.unfinished, content).map_err(|error| OutputError {
            path: target.to_path_buf(),
            problem: kept(error.problem),
        })
    }

    /// Sends it to its target.
    ///
    /// # Errors
    /// Whatever the system reports.
    pub fn send(self, target: &Path) -> Result<(), OutputError> {
        write(target, &self.unfinished, |sink| {
            io::copy(&mut File::open(self.path())?, sink).map(drop)
        })
    }
}

/// How to create a file that is nobody else's business, in a folder that everybody has.
fn private() -> OpenOptions {
    let mut new = OpenOptions::new();
    new.write(true).create_new(true);
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;
        new.mode(0o600);
    }
    new
}

impl Drop for Staged {
    fn drop(&mut self) {
        let path: &Path = &self.path;
        self.unfinished.lock().files.remove(path);
    }
}
