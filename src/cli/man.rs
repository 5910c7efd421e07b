//! `candela man`: manual pages, made of the same text as `--help`.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use candela::internal::printable_path;
use candela::output::{self, Unfinished};
use clap::{Command, CommandFactory};
use clap_mangen::Man;

use super::Failure;

/// Write the manual pages, for who packages candela
///
/// candela.1 and one page for each command, such as candela-render.1. Without a folder, candela.1 goes
/// to standard output.
#[derive(Debug, clap::Args)]
#[command(hide = true)]
#[command(after_long_help = "\
Examples:
  candela man /usr/local/share/man/man1
  candela man | man -l -")]
pub(crate) struct Arguments {
    /// The folder, which is made if it is not there
    #[arg(value_name = "DIR")]
    folder: Option<PathBuf>,
}

pub(crate) fn run(
    arguments: &Arguments,
    unfinished: &Unfinished,
    output: &mut impl Write,
) -> Result<(), Failure> {
    let Some(folder) = &arguments.folder else {
        output.write_all(&page(command())?)?;
        return Ok(());
    };
    fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make the folder {}: {error}", printable_path(folder)))?;
    let main = command();
    let commands = main
        .get_subcommands()
        .filter(|command| !command.is_hide_set());
    for command in commands.cloned().chain([main.clone()]) {
        let name = command.get_display_name().unwrap_or("candela").to_owned();
        let page = page(command)?;
        write(&folder.join(format!("{name}.1")), &page, unfinished)?;
    }
    Ok(())
}

fn write(path: &Path, page: &[u8], unfinished: &Unfinished) -> Result<(), Failure> {
    Ok(output::write(path, unfinished, |sink| {
        sink.write_all(page)
    })?)
}

/// The program as its pages describe it: the same on every machine.
fn command() -> Command {
    let mut command = super::Arguments::command().disable_help_subcommand(true);
    command = command.mut_subcommand("render", |render| {
        // Which instructions there are depends on the processor.
        render.mut_arg("simd", |simd| simd.hide_possible_values(true))
    });
    command.build();
    command
}

/// A page in troff. Examples keep their lines.
fn page(command: Command) -> Result<Vec<u8>, Failure> {
    let examples = command.get_after_long_help().map(ToString::to_string);
    let man = Man::new(
        command
            .after_long_help(None::<&str>)
            .after_help(None::<&str>),
    );
    let mut page = Vec::new();
    man.render(&mut page)?;
    if let Some(examples) = examples {
        let start = examples
            .strip_prefix("Examples:\n")
            .or(examples.strip_prefix("Example:\n"));
        let lines = start.unwrap_or(&examples).lines();
        writeln!(page, ".SH EXAMPLES\n.nf")?;
        for line in lines {
            if line == "Exit codes:" {
                writeln!(page, ".fi\n.SH EXIT STATUS\n.nf")?;
                continue;
            }
            // A period or a quote at the start would be a command, a backslash an escape.
            let line = line.replace('\\', "\\e").replace('-', "\\-");
            writeln!(page, "\\&{line}")?;
        }
        writeln!(page, ".fi")?;
    }
    Ok(page)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_page() {
        let place = tempfile::tempdir().unwrap();
        let folder = place.path().join("share/man1");
        let arguments = Arguments {
            folder: Some(folder.clone()),
        };
        run(&arguments, &Unfinished::new(), &mut Vec::new()).unwrap();
        let read = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
        let files = fs::read_dir(&folder).unwrap().count();
        let commands = command();
        let commands: Vec<_> = commands
            .get_subcommands()
            .filter(|c| !c.is_hide_set())
            .collect();
        assert_eq!(files, commands.len() + 1);
        for command in commands {
            let page = read(&format!("candela-{}.1", command.get_name()));
            for part in [
                ".TH candela-",
                ".SH NAME",
                ".SH SYNOPSIS",
                ".SH DESCRIPTION",
                ".SH OPTIONS",
            ] {
                assert!(page.contains(part), "{part} in {page}");
            }
        }
        let render = read("candela-render.1");
        assert!(render.contains("\\fB\\-\\-samples\\fR"), "{render}");
        assert!(
            render.contains("\n\\&  candela render scene.toml \\-o scene.exr"),
            "{render}"
        );
        assert!(!render.contains("avx"), "{render}");
    }

    #[test]
    fn the_main_page_goes_to_standard_output() {
        let mut page = Vec::new();
        let arguments = Arguments { folder: None };
        run(&arguments, &Unfinished::new(), &mut page).unwrap();
        let page = String::from_utf8(page).unwrap();
        assert!(page.contains(".TH candela 1"), "{page}");
        assert!(page.contains("candela\\-render(1)"), "{page}");
        assert!(page.contains("\n.SH EXIT STATUS\n.nf\n\\&  0  "), "{page}");
    }
}
