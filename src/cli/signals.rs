//! What signals do to a run: it ends, without a file half-written.

use std::io;

use candela::internal::look_for_threads;
use candela::output::Unfinished;

/// What a shell adds to the number of the signal that ended a program.
#[cfg(unix)]
const SIGNALED: i32 = 128;

/// What a shell reports of a program that Ctrl-C ended: 128 + SIGINT.
#[cfg(not(unix))]
const INTERRUPTED: i32 = 130;

/// Makes Ctrl-C, and the signals by which shells, systems and batch queues end a program, end the run
/// at once, without a file half-written. What whoever started the run wants ignored, as `nohup` does,
/// stays so. A file that grows beyond `ulimit -f` is an error where it is written, and ends nothing.
///
/// # Errors
/// Where the system gives no thread to wait for signals.
#[cfg(unix)]
pub(super) fn heed(unfinished: &Unfinished) -> io::Result<()> {
    use std::sync::Arc;
    use std::sync::atomic::AtomicBool;

    use signal_hook::consts::{
        SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU, SIGXFSZ,
    };
    // With any handler the write fails, and says why.
    signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)))?;

    let ignored = ignored();
    let heeded = [SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGUSR1, SIGUSR2, SIGXCPU];
    let heeded = heeded
        .iter()
        .filter(|&&signal| ignored & (1 << (signal - 1)) == 0);
    let mut signals = signal_hook::iterator::Signals::new(heeded)?;
    let unfinished = unfinished.clone();
    let room = look_for_threads(1);
    room.map_err(|error| io::Error::other(error.for_what("a thread")))?;
    std::thread::Builder::new().spawn(move || {
        if let Some(signal) = signals.forever().next() {
            unfinished.cancel();
            std::process::exit(SIGNALED + signal);
        }
    })?;
    Ok(())
}

/// One bit for each signal that the process was started to ignore, as Linux tells; elsewhere none.
#[cfg(unix)]
fn ignored() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

/// Makes Ctrl-C end the run at once, without a file half-written.
///
/// # Errors
/// Where the system gives no thread to wait for it.
#[cfg(not(unix))]
pub(super) fn heed(unfinished: &Unfinished) -> io::Result<()> {
    let unfinished = unfinished.clone();
    ctrlc::set_handler(move || {
        unfinished.cancel();
        std::process::exit(INTERRUPTED);
    })
    .map_err(io::Error::other)
}
