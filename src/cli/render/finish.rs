//! The end of a frame: its files get their names while the next one is being rendered.

use std::sync::mpsc::sync_channel;
use std::thread::{Builder, JoinHandle};

use candela::output::{OutputError, Written};

use crate::cli::Failure;

/// Files that are written, but may not have their names yet.
pub(super) struct Finishing(State);

enum State {
    Elsewhere(JoinHandle<Result<(), OutputError>>),
    Done(Result<(), OutputError>),
}

impl Finishing {
    /// Has a thread wait for the disk; waits itself where there is none.
    pub(super) fn begin(files: Vec<Written>) -> Self {
        let finish = |files: Vec<Written>| files.into_iter().try_for_each(Written::finish);
        let (give, taken) = sync_channel::<Vec<Written>>(1);
        let thread = Builder::new().spawn(move || taken.recv().map_or(Ok(()), finish));
        Self(match thread {
            Ok(thread) => match give.send(files) {
                Ok(()) => State::Elsewhere(thread),
                Err(files) => State::Done(finish(files.0)),
            },
            Err(_) => State::Done(finish(files)),
        })
    }

    /// Waits until the files have their names.
    pub(super) fn wait(self) -> Result<(), Failure> {
        let finished = match self.0 {
            State::Elsewhere(thread) => {
                let joined = thread.join();
                joined.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            }
            State::Done(finished) => finished,
        };
        Ok(finished?)
    }
}
