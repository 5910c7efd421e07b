//! What happens where memory ends.
//!
//! Whatever has the size of a file or of an option is asked for first, and is an error with a figure
//! where it is not there (`candela::memory`). What is left are small allocations, of the standard library
//! and of other crates, which Rust ends by SIGABRT after a line on standard error, `memory allocation of
//! N bytes failed`. The process has the exit code of all lack of memory then, too. (SIGABRT has one more
//! cause, which would be a mistake in candela: a stack that overflows, of which Rust's line tells.)

use std::io;

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
