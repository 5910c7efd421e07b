//! The command line: arguments to the library to an exit code. One file per command.

mod check;
mod completions;
mod develop;
mod probe;
mod render;
mod shortage;
mod tonemap;

use std::error::Error;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use candela::film::{self, Options, Window};
use candela::output::Unfinished;
use candela::scene::Diagnostics;
use candela::world::World;
use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, Subcommand};

/// What a shell adds to the number of the signal that ended a program.
#[cfg(unix)]
const SIGNALED: i32 = 128;

/// What a shell reports of a program that Ctrl-C ended: 128 + SIGINT.
#[cfg(not(unix))]
const INTERRUPTED: i32 = 130;

/// What another machine or a later try may cure, as `EX_TEMPFAIL` of sysexits.h.
const TRANSIENT: u8 = 75;

/// A renderer for direct light: exact, fast, deterministic
///
/// Renders a scene file to a linear OpenEXR image in cd/m² and makes a PNG of it in a step of its
/// own.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100)]
#[command(after_long_help = "\
Examples:
  candela render
      Render the built-in scene to lecture.exr
  candela render scene.toml -o scene.exr --samples 16 --preview scene.png
      Render a scene, and make a picture of it
  candela check scene.toml
      Is it legal, what will be computed, what will it cost
  candela probe scene.toml --pixel 640,360
      The sum at one pixel, term by term

Exit codes: 0 done; 1 something is wrong with a file, a value or the machine; 2 wrong usage;
128 + n ended by signal n, such as 130 by Ctrl-C.")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Render(render::Arguments),
    Tonemap(tonemap::Arguments),
    Check(check::Arguments),
    Probe(probe::Arguments),
    Completions(completions::Arguments),
}

/// What a command failed with; [`main`] alone prints it.
type Failure = Box<dyn Error + Send + Sync>;

/// Runs the command that the arguments name.
pub(crate) fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Command::Render(render) = &arguments.command
        && let Some(misuse) = render.misuse()
    {
        let mut command = Arguments::command();
        command.build();
        let render = command.find_subcommand_mut("render");
        let render = render.expect("the command that was parsed is there");
        render.error(ErrorKind::ArgumentConflict, misuse).exit();
    }
    let unfinished = Unfinished::new();
    let result = shortage::end_with(TRANSIENT)
        .map_err(Failure::from)
        .and_then(|()| at_interrupt(&unfinished))
        .and_then(|()| run(&arguments.command, &unfinished));
    match result {
        Ok(()) => ExitCode::SUCCESS,
        // The handler below is about to end the process; what it interrupted is no failure.
        Err(_) if unfinished.is_canceled() => loop {
            std::thread::park();
        },
        // Whoever reads the output has stopped to, as `head` does.
        Err(failure) if is_broken_pipe(&*failure) => ExitCode::SUCCESS,
        Err(failure) => {
            print(&*failure);
            if shortage::is_transient(&*failure) {
                TRANSIENT.into()
            } else {
                ExitCode::FAILURE
            }
        }
    }
}

fn run(command: &Command, unfinished: &Unfinished) -> Result<(), Failure> {
    if !matches!(command, Command::Render(_)) {
        // Threads that are not there are an error now, and would be a panic later.
        rayon::ThreadPoolBuilder::new()
            .build_global()
            .map_err(|error| shortage::no_threads(&error))?;
    }
    match command {
        Command::Render(arguments) => render::run(arguments, unfinished),
        Command::Tonemap(arguments) => tonemap::run(arguments, unfinished, &mut io::stderr()),
        Command::Check(arguments) => check::run(arguments, &mut io::stdout().lock()),
        Command::Probe(arguments) => {
            let (scene, world) = World::load_with(&arguments.scene, |scene| {
                probe::prepare(arguments, scene);
            })?;
            let renderer = |[x, y]: [u32; 2]| {
                let pixel = Window {
                    x,
                    y,
                    width: 1,
                    height: 1,
                };
                let options = Options {
                    window: Some(pixel),
                    ..Options::default()
                };
                let [r, g, b, _] = film::render(&world, &options).pixels()[0];
                [r, g, b]
            };
            Ok(probe::run(
                arguments,
                &scene,
                renderer,
                &mut io::stdout().lock(),
            )?)
        }
        Command::Completions(arguments) => completions::run(arguments, &mut io::stdout().lock()),
    }
}

/// Makes Ctrl-C, SIGTERM and SIGHUP end the run at once, without a file half-written. What whoever
/// started the run wants ignored, as `nohup` does, stays so.
#[cfg(unix)]
fn at_interrupt(unfinished: &Unfinished) -> Result<(), Failure> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let ignored = ignored_signals();
    let heeded = [SIGINT, SIGTERM, SIGHUP];
    let heeded = heeded
        .iter()
        .filter(|&&signal| ignored & (1 << (signal - 1)) == 0);
    let mut signals = signal_hook::iterator::Signals::new(heeded)?;
    let unfinished = unfinished.clone();
    let wait = move || {
        if let Some(signal) = signals.forever().next() {
            unfinished.cancel();
            std::process::exit(SIGNALED + signal);
        }
    };
    std::thread::Builder::new()
        .spawn(wait)
        .map_err(shortage::NoThread)?;
    Ok(())
}

/// One bit for each signal that the process was started to ignore, as Linux tells; elsewhere none.
#[cfg(unix)]
fn ignored_signals() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok())
        .unwrap_or(0)
}

/// Makes Ctrl-C end the run at once, without a file half-written.
#[cfg(not(unix))]
fn at_interrupt(unfinished: &Unfinished) -> Result<(), Failure> {
    let unfinished = unfinished.clone();
    ctrlc::set_handler(move || {
        unfinished.cancel();
        std::process::exit(INTERRUPTED);
    })?;
    Ok(())
}

/// Refuses to write over a file that is read, or two files to one place.
fn refuse_same_files(inputs: &[&Path], outputs: &[&Path]) -> Result<(), Failure> {
    for (number, output) in outputs.iter().enumerate() {
        let Some(place) = place(output) else { continue };
        let is_there = |other: &&&Path| self::place(other).as_ref() == Some(&place);
        if let Some(input) = inputs.iter().find(is_there) {
            return Err(format!(
                "{} would be written over {}, which is read; give another name",
                output.display(),
                input.display(),
            )
            .into());
        }
        if let Some(other) = outputs[..number].iter().find(is_there) {
            return Err(format!(
                "{} and {} would be one file; give another name",
                other.display(),
                output.display(),
            )
            .into());
        }
    }
    Ok(())
}

/// Where a file is or would be, whatever links lead there; `None` for what is no place for a file,
/// such as a device, which may be written to twice.
fn place(path: &Path) -> Option<PathBuf> {
    if let Ok(metadata) = path.metadata() {
        return path.canonicalize().ok().filter(|_| metadata.is_file());
    }
    let folder = path
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty());
    let folder = folder.unwrap_or(Path::new(".")).canonicalize().ok()?;
    Some(folder.join(path.file_name()?))
}

fn is_broken_pipe(failure: &(dyn Error + 'static)) -> bool {
    std::iter::successors(Some(failure), |&failure| failure.source())
        .filter_map(|failure| failure.downcast_ref::<io::Error>())
        .any(|error| error.kind() == io::ErrorKind::BrokenPipe)
}

/// Prints a failure, with lines of the scene file where it is about one.
fn print(failure: &(dyn Error + 'static)) {
    let stderr = io::stderr();
    let color = stderr.is_terminal() && std::env::var_os("NO_COLOR").is_none();
    let message = match failure.downcast_ref::<Diagnostics>() {
        Some(diagnostics) => diagnostics.render(color),
        None => format!("error: {failure}"),
    };
    // Nowhere is left to report that the message itself cannot be written.
    let _ = writeln!(stderr.lock(), "{message}");
}
