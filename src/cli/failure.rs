//! What a command failed with: its message and its exit code.

use std::collections::TryReserveError;
use std::error::Error;
use std::io::{self, Write};
use std::path::Path;
use std::process::ExitCode;

use candela::OutOfMemory;
use candela::display::DisplayError;
use candela::exr::{ExrError, MergeError};
use candela::image_file::ImageFileError;
use candela::output::{self, OutputError};
use candela::scene::Diagnostics;
use rayon::ThreadPoolBuildError;

/// What a command failed with; [`report`] alone prints it.
pub(crate) type Failure = Box<dyn Error + Send + Sync>;

/// What another machine or a later try may cure, as `EX_TEMPFAIL` of sysexits.h.
pub(super) const TRANSIENT: u8 = 75;

/// A failure that says in words alone that a later try, or another machine, may cure it.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct Transient(Failure);

/// `failure` as one that a later try, or another machine, may cure.
pub(super) fn transient(failure: Failure) -> Failure {
    Transient(failure).into()
}

/// Whether a later try, or another machine, may cure it.
pub(super) fn is_passing(failure: &Failure) -> bool {
    any(&**failure, &is_transient)
}

/// Where the command line is wrong, as clap says it.
const MISUSE: u8 = 2;

/// Arguments that are wrong, which only the files show that they are about.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(super) struct Misuse(pub(super) String);

/// Where something is further off than a limit allows.
const BEYOND: u8 = 3;

/// All went well, and what was found is beyond a limit.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(super) struct Beyond(pub(super) String);

/// Prints a failure; the exit code that belongs to it.
pub(super) fn report(failure: &Failure) -> ExitCode {
    let failure: &(dyn Error + 'static) = &**failure;
    // Whoever reads the output has stopped to, as `head` does.
    if any(failure, &is_broken_pipe) {
        return ExitCode::SUCCESS;
    }
    print(failure);
    if failure.is::<Beyond>() {
        BEYOND.into()
    } else if failure.is::<Misuse>() {
        MISUSE.into()
    } else if any(failure, &is_transient) {
        TRANSIENT.into()
    } else {
        ExitCode::FAILURE
    }
}

/// Prints a failure, with lines of the scene file where it is about one.
fn print(failure: &(dyn Error + 'static)) {
    let stderr = io::stderr();
    let has_color = std::env::var_os("NO_COLOR").is_none_or(|set| set.is_empty());
    let color = has_color && super::is_steerable(&stderr);
    let message = match failure.downcast_ref::<Diagnostics>() {
        Some(diagnostics) => diagnostics.render(color),
        None => format!("error: {failure}"),
    };
    // Nowhere is left to report that the message itself cannot be written.
    let _ = writeln!(stderr.lock(), "{message}");
}

/// Whether an error by itself tells of what a later try, or another machine, may cure.
fn is_transient(error: &(dyn Error + 'static)) -> bool {
    error.is::<Transient>()
        || error.is::<OutOfMemory>()
        || error.is::<TryReserveError>()
        || error.is::<ThreadPoolBuildError>()
        || error
            .downcast_ref::<Diagnostics>()
            .is_some_and(Diagnostics::is_transient)
        || error
            .downcast_ref::<ExrError>()
            .is_some_and(ExrError::is_transient)
        || error
            .downcast_ref::<MergeError>()
            .is_some_and(MergeError::is_transient)
        || error
            .downcast_ref::<ImageFileError>()
            .is_some_and(ImageFileError::is_transient)
        || error
            .downcast_ref::<OutputError>()
            .is_some_and(OutputError::is_transient)
        || error
            .downcast_ref::<io::Error>()
            .is_some_and(output::is_transient)
}

fn is_broken_pipe(error: &(dyn Error + 'static)) -> bool {
    let is_broken = |error: &io::Error| error.kind() == io::ErrorKind::BrokenPipe;
    error
        .downcast_ref::<OutputError>()
        .is_some_and(OutputError::is_broken_pipe)
        || error.downcast_ref::<io::Error>().is_some_and(is_broken)
}

/// Whether something holds of an error or of one of its causes.
fn any(error: &(dyn Error + 'static), holds: &dyn Fn(&(dyn Error + 'static)) -> bool) -> bool {
    holds(error) || cause(error).is_some_and(|cause| any(cause, holds))
}

/// The cause of an error, also of those that hide it: they speak for it, and give away its own cause
/// instead.
fn cause<'a>(error: &'a (dyn Error + 'static)) -> Option<&'a (dyn Error + 'static)> {
    if let Some(error) = error.downcast_ref::<io::Error>() {
        return error
            .get_ref()
            .map(|cause| cause as &'a (dyn Error + 'static));
    }
    if let Some(error) = error.downcast_ref::<DisplayError>() {
        return match error {
            DisplayError::Read(cause) => Some(cause),
            DisplayError::Decode(cause) => Some(cause),
            DisplayError::Write(cause) => Some(cause),
            DisplayError::Memory(cause) => Some(cause),
            _ => error.source(),
        };
    }
    error.source()
}

/// Standard output for text, whose errors say what could not be written.
pub(super) struct StandardOutput<W>(W);

impl StandardOutput<io::Stdout> {
    pub(super) fn new() -> Self {
        Self(io::stdout())
    }
}

impl<W: Write> Write for StandardOutput<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes).map_err(named)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush().map_err(named)
    }
}

/// An error of standard output, of the same kind, so that whoever asks for that finds it.
pub(super) fn named(error: io::Error) -> io::Error {
    io::Error::new(error.kind(), OutputError::new(Path::new("-"), error))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error_of(kind: io::ErrorKind) -> OutputError {
        OutputError::new(Path::new("a.exr"), kind.into())
    }

    /// Whether 75 is the code of a failure, in whatever it is wrapped.
    fn is_cured_later(failure: impl Into<Failure>) -> bool {
        any(&*failure.into(), &is_transient)
    }

    #[test]
    fn what_a_later_try_may_cure() {
        assert!(is_cured_later(error_of(io::ErrorKind::StorageFull)));
        assert!(is_cured_later(DisplayError::Write(error_of(
            io::ErrorKind::QuotaExceeded
        ))));
        assert!(is_cured_later(named(io::ErrorKind::StorageFull.into())));
        assert!(is_cured_later(io::Error::other(
            Vec::<u64>::new().try_reserve(usize::MAX).unwrap_err()
        )));
        assert!(is_cured_later(transient("no memory".into())));
        assert!(is_cured_later(MergeError::Vanished("a.exr".into())));
        assert!(is_cured_later(MergeError::Write(error_of(
            io::ErrorKind::StorageFull
        ))));
    }

    #[test]
    fn what_stays_wrong() {
        assert!(!is_cured_later(error_of(io::ErrorKind::PermissionDenied)));
        assert!(!is_cured_later(error_of(io::ErrorKind::ReadOnlyFilesystem)));
        assert!(!is_cured_later(io::Error::from(io::ErrorKind::NotFound)));
        assert!(!is_cured_later("the pixel is outside of the image"));
        assert!(!is_cured_later(MergeError::NoTile("a.exr".into())));
    }

    #[test]
    fn readers_that_went_away_are_found_in_whatever_tells() {
        for failure in [
            Failure::from(error_of(io::ErrorKind::BrokenPipe)),
            DisplayError::Write(error_of(io::ErrorKind::BrokenPipe)).into(),
            named(io::ErrorKind::BrokenPipe.into()).into(),
            io::Error::from(io::ErrorKind::BrokenPipe).into(),
        ] {
            assert!(any(&*failure, &is_broken_pipe), "{failure}");
        }
        let full: Failure = error_of(io::ErrorKind::StorageFull).into();
        assert!(!any(&*full, &is_broken_pipe));
    }
}
