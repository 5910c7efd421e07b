//! One file per command.

mod tonemap;

use std::process::ExitCode;

use candela::output::Unfinished;
use clap::{Parser, Subcommand};

#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Tonemap(tonemap::Arguments),
}

pub(crate) fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let unfinished = Unfinished::new();
    let Command::Tonemap(arguments) = &arguments.command;
    match tonemap::run(arguments, &unfinished, &mut std::io::stderr()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
