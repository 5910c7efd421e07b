//! Many files, side by side.

use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use candela::internal::counted;
use candela::output::Unfinished;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rayon::prelude::*;

use super::Arguments;
use crate::cli::advice::frame_number;
use crate::cli::sequence::Conversion;
use crate::cli::{Failure, failure, is_steerable};

/// Makes all; a file that fails does not keep the others from it.
pub(super) fn run(
    arguments: &Arguments,
    conversions: &[Conversion],
    unfinished: &Unfinished,
    messages: &mut (impl Write + Send),
) -> Result<(), Failure> {
    let style = ProgressStyle::with_template("{wide_bar} {pos} of {len}, {eta} left");
    let style = style.expect("the template is well-formed");
    let target = if !arguments.quiet && is_steerable(&io::stderr()) {
        ProgressDrawTarget::stderr()
    } else {
        ProgressDrawTarget::hidden()
    };
    let bar = ProgressBar::with_draw_target(Some(conversions.len() as u64), target);
    let bar = bar.with_style(style);
    let are_frames = arguments
        .inputs
        .iter()
        .any(|input| frame_number(input).is_some());
    if let Some(warning) = arguments.development.of_frames().filter(|_| are_frames) {
        let _ = writeln!(messages, "warning: {warning}");
    }
    let view = arguments.development.false_color();
    if are_frames && arguments.false_color.chooses(view) {
        let _ = writeln!(
            messages,
            "warning: each frame has a range of false colors of its own; give all of them one, such as --view \
             false-color=10:1000"
        );
    }
    let messages = Mutex::new(messages);
    let is_transient = AtomicBool::new(true);
    let failed = conversions.par_iter().filter(|conversion| {
        let done = super::convert(arguments, conversion, unfinished);
        let text = match &done {
            Ok(told) => told.clone(),
            Err(failure) => {
                if !failure::is_passing(failure) {
                    is_transient.store(false, Ordering::Relaxed);
                }
                format!("error: {failure}\n")
            }
        };
        if !text.is_empty() {
            let mut messages = messages.lock().unwrap_or_else(PoisonError::into_inner);
            bar.suspend(|| {
                // Nowhere is left to report that the messages themselves cannot be written.
                let _ = messages.write_all(text.as_bytes());
            });
        }
        bar.inc(1);
        done.is_err()
    });
    let failed = failed.count();
    bar.finish_and_clear();
    if failed == 0 {
        return Ok(());
    }
    let failure: Failure = format!(
        "{} of {} could not be converted",
        failed,
        counted(conversions.len(), "file", "files")
    )
    .into();
    Err(if is_transient.into_inner() {
        failure::transient(failure)
    } else {
        failure
    })
}
