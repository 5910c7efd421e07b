//! From words to arguments; what is wrong with them is said without a character that would steer the
//! terminal.

use std::ffi::{OsStr, OsString};
use std::io::{self, Write};
use std::process::ExitCode;

use candela::internal::{is_printable, printable};
use clap::error::ErrorKind;
use clap::{CommandFactory, Parser};

use super::advice;
use super::failure::{self, Failure};
use super::{Arguments, Command};

/// A word of more bytes is cut in messages; the longest sensible lists are shorter.
const LONGEST_WORD: usize = 2000;

/// The arguments of the program.
///
/// # Errors
/// What is wrong with them, or the help that they ask for.
pub(super) fn parse() -> Result<Arguments, clap::Error> {
    let words: Vec<OsString> = std::env::args_os().collect();
    parsed(&words).map_err(|error| {
        let shown: Vec<OsString> = words.iter().map(|word| printable_word(word)).collect();
        advice::advised(printable_error(error, &words, &shown), &shown)
    })
}

fn parsed(words: &[OsString]) -> Result<Arguments, clap::Error> {
    let arguments = Arguments::try_parse_from(words)?;
    let misuse = match &arguments.command {
        Command::Render(render) => render.misuse().map(|misuse| ("render", misuse)),
        Command::Tonemap(tonemap) => tonemap.misuse().map(|misuse| ("tonemap", misuse)),
        Command::ContactSheet(sheet) => sheet.misuse().map(|misuse| ("contact-sheet", misuse)),
        Command::Check(_)
        | Command::Light(_)
        | Command::Lux(_)
        | Command::Probe(_)
        | Command::Verify(_)
        | Command::Report(_)
        | Command::Diff(_)
        | Command::Relight(_)
        | Command::Merge(_)
        | Command::Job(_)
        | Command::New(_)
        | Command::Completions(_)
        | Command::Schema(_)
        | Command::Man(_) => None,
    };
    if let Some((name, misuse)) = misuse {
        let mut command = Arguments::command();
        command.build();
        let command = command.find_subcommand_mut(name);
        let command = command.expect("the command that was parsed is there");
        return Err(command.error(ErrorKind::ArgumentConflict, misuse));
    }
    Ok(arguments)
}

/// The error again, of words that can be printed: it repeats those that are wrong.
fn printable_error(error: clap::Error, words: &[OsString], shown: &[OsString]) -> clap::Error {
    if shown == words {
        return error;
    }
    match parsed(shown) {
        Err(shown) if shown.kind() == error.kind() => shown,
        // The error is about the very characters.
        Ok(_) | Err(_) => {
            let text = error.to_string();
            let first = text.lines().next().unwrap_or_default();
            let message = first.strip_prefix("error: ").unwrap_or(first);
            Arguments::command().error(error.kind(), printable(message))
        }
    }
}

fn printable_word(word: &OsStr) -> OsString {
    let text = word.to_string_lossy();
    if text.len() <= LONGEST_WORD && text.chars().all(is_printable) {
        return text.into_owned().into();
    }
    printable(&text).into()
}

/// Prints what is wrong with the arguments, or the help; the exit code that belongs to it.
pub(super) fn report(error: &clap::Error) -> ExitCode {
    let printed = error.print().and_then(|()| io::stdout().flush());
    match printed {
        Err(unprinted) if !error.use_stderr() => {
            failure::report(&Failure::from(failure::named(unprinted)))
        }
        // Nowhere is left to report that the message itself cannot be written.
        Ok(()) | Err(_) => ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2)),
    }
}
