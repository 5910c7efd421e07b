//! `candela completions`: a script for the shell.

use std::io::Write;

use clap::CommandFactory;
use clap_complete::Shell;

use super::Failure;

/// Print a script that completes candela's commands and options in a shell
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Examples:
  candela completions bash > ~/.local/share/bash-completion/completions/candela
  candela completions zsh > ~/.zfunc/_candela
  candela completions fish > ~/.config/fish/completions/candela.fish")]
pub(crate) struct Arguments {
    /// The shell
    shell: Shell,
}

pub(crate) fn run(arguments: &Arguments, output: &mut impl Write) -> Result<(), Failure> {
    let mut script = Vec::new();
    let mut command = super::Arguments::command();
    clap_complete::generate(arguments.shell, &mut command, "candela", &mut script);
    output.write_all(&script)?;
    Ok(())
}
