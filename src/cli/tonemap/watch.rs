//! A file that is looked at again and again.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::thread;
use std::time::{Duration, SystemTime};

use candela::internal::printable_path;
use candela::output::Unfinished;

use super::Arguments;
use crate::cli::Failure;
use crate::cli::sequence::Conversion;

/// How often it is looked at.
const PERIOD: Duration = Duration::from_millis(200);

/// What a change of a file changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct State {
    length: u64,
    modified: Option<SystemTime>,
}

impl State {
    /// `None` where there is no such file.
    fn of(path: &Path) -> Option<Self> {
        let metadata = fs::metadata(path).ok()?;
        Some(Self {
            length: metadata.len(),
            modified: metadata.modified().ok(),
        })
    }
}

/// Makes the PNG, and makes it anew whenever the file changes: until a signal ends the program. A file that cannot be
/// shown, because another program is still writing it, is told and waited for.
pub(super) fn run(
    arguments: &Arguments,
    conversion: &Conversion,
    unfinished: &Unfinished,
    messages: &mut impl Write,
) -> Result<(), Failure> {
    let input = &conversion.input;
    if input == Path::new("-") || !input.is_file() {
        return Err(format!(
            "{} cannot be watched: it is not a file",
            printable_path(input)
        )
        .into());
    }
    if conversion.output == Path::new("-") {
        return Err(
            "what is watched cannot go to standard output; give a file with -o OUT.png".into(),
        );
    }
    let mut shown = None;
    loop {
        let state = State::of(input);
        if state.is_some() && state != shown {
            // Changes while it is read are seen as such the next time.
            shown = state;
            let text = match super::convert(arguments, conversion, unfinished) {
                Ok(told) => format!("{told}{}\n", printable_path(&conversion.output)),
                Err(failure) => format!("warning: {failure}\n"),
            };
            let _ = messages.write_all(text.as_bytes());
            let _ = messages.flush();
        }
        if unfinished.is_canceled() {
            return Ok(());
        }
        thread::sleep(PERIOD);
    }
}
