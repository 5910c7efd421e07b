//! What happens where memory ends.
//!
//! Whatever has the size of a file or of an option is asked for first, and is an error with a figure
//! where it is not there (`candela::memory`). What is left are small allocations, of the standard library
//! and of other crates, which Rust ends by SIGABRT after a line on standard error, `memory allocation of
//! N bytes failed`. The process has the exit code of all lack of memory then, too. (SIGABRT has one more
//! cause, which would be a mistake in candela: a stack that overflows, of which Rust's line tells.)

use std::error::Error;
use std::io;

use candela::memory::OutOfMemory;
use candela::scene::Diagnostics;

use super::Failure;

/// Makes SIGABRT end the process with the exit code of what another machine or a later try may cure.
#[cfg(unix)]
pub(super) fn end_with(code: u8) -> io::Result<()> {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use signal_hook::consts::SIGABRT;
    use signal_hook::flag::register_conditional_shutdown;

    let always = Arc::new(AtomicBool::new(true));
    register_conditional_shutdown(SIGABRT, code.into(), always)?;
    Ok(())
}

/// Elsewhere there are no such signals.
#[cfg(not(unix))]
pub(super) fn end_with(_: u8) -> io::Result<()> {
    Ok(())
}

/// The system gives no thread, which is for lack of memory or of threads.
#[derive(Debug, thiserror::Error)]
#[error("cannot start a thread: {0}; there is too little memory, or too many threads run")]
pub(super) struct NoThread(pub(super) io::Error);

/// What there is too little memory for, in words.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct TooLittle(Failure);

/// `failure` as one that is for lack of memory.
pub(super) fn for_lack_of_memory(failure: Failure) -> Failure {
    TooLittle(failure).into()
}

/// The system gives no threads to work with, which is for lack of memory or of threads.
pub(super) fn no_threads(error: &rayon::ThreadPoolBuildError) -> Failure {
    for_lack_of_memory(format!("cannot start the threads to work with: {error}").into())
}

/// Whether a failure is a lack of memory, or an input that could not be read to its end.
pub(super) fn is_transient(failure: &(dyn Error + 'static)) -> bool {
    failure.is::<OutOfMemory>()
        || failure.is::<TooLittle>()
        || failure.is::<NoThread>()
        || failure
            .downcast_ref::<Diagnostics>()
            .is_some_and(Diagnostics::is_transient)
}
