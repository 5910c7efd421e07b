//! The command line: arguments to the library to an exit code. One file per command.

mod advice;
mod check;
mod completions;
mod contact_sheet;
mod crop;
mod develop;
mod diff;
mod display_server;
mod drawing;
mod failure;
mod false_color;
mod frames;
mod isolines;
mod job;
mod legality;
mod legend;
mod light;
mod lux;
mod man;
mod merge;
mod new;
mod numbers;
mod probe;
mod relight;
mod render;
mod report;
mod schema;
mod sequence;
mod shortage;
mod signals;
mod source;
mod tonemap;
mod usage;
mod verify;

use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;

use candela::Renderer;
use candela::image::Window;
use candela::internal::look_for_threads;
use candela::internal::printable_path;
use candela::output::{OutputError, OutputProblem, Place, Unfinished};
use candela::render::{Job, Options};
use candela::world::Loaded;
use clap::{ColorChoice, Parser, Subcommand};
use failure::{Failure, Misuse, StandardOutput};

/// More threads than any machine makes use of.
const MAX_THREADS: u32 = 1024;

/// A renderer for direct light: exact, fast, deterministic
///
/// Renders a scene file to a linear OpenEXR image in cd/m² and makes a PNG of it in a step of its
/// own.
#[derive(Debug, Parser)]
#[command(version, max_term_width = 100, color = color_choice())]
#[command(after_long_help = "\
Examples:
  candela render
      Render the built-in scene to lecture.exr
  candela new
      Write a first scene, scene.toml, to start from
  candela render scene.toml --preview scene.png
      Render a scene, and make a picture of it
  candela contact-sheet scene.exr --layers
      All layers of an image on one sheet
  candela relight scene.exr -o relit.exr --light key=2 --light fill=off
      Other light on an image, without rendering
  candela merge scene.tile####.exr -o scene.exr
      One image of tiles that many machines have rendered
  candela job scene.toml --frames 1-240 > job.yaml
      What a render farm takes: Open Job Description, Slurm or OpenCue
  candela check scene.toml
      Is it legal, what will be computed, what will it cost
  candela probe scene.toml --pixel 640,360
      The sum at one pixel, term by term
  candela light downlight.ies -o polar.svg
      What an IES file says, and its polar diagram
  candela lux office.toml --from -3,0.75,2 --u 6,0,0 --v 0,0,-4
      Illuminance of a working plane: mean, uniformity, point by point
  candela verify scene.toml
      Does the renderer agree with the equations on this scene
  candela report scene.toml -o report
      Speed against error, as a page with tables and a plot
  candela diff reference.exr scene.exr
      How far an image is from another, layer by layer

Exit codes:
  0        done; also where the reader of a pipe has seen enough
  1        something is wrong with a file or a value
  2        wrong usage
  3        diff or verify has found more than its limits allow
  75       what a later try or another machine may cure: no memory, a full disk, a quota or a limit,
           an error of a disk or a server
  128 + n  ended by signal n, such as 130 by Ctrl-C")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Render(Box<render::Arguments>),
    Tonemap(tonemap::Arguments),
    ContactSheet(contact_sheet::Arguments),
    Relight(relight::Arguments),
    Merge(merge::Arguments),
    Job(job::Arguments),
    Check(check::Arguments),
    Probe(probe::Arguments),
    Light(light::Arguments),
    Lux(lux::Arguments),
    Verify(verify::Arguments),
    Report(report::Arguments),
    Diff(diff::Arguments),
    New(new::Arguments),
    Completions(completions::Arguments),
    Schema(schema::Arguments),
    Man(man::Arguments),
}

/// Runs the command that the arguments name.
pub(crate) fn main() -> ExitCode {
    let arguments = match usage::parse() {
        Ok(arguments) => arguments,
        Err(error) => return usage::report(&error),
    };
    let unfinished = Unfinished::new();
    let heeded = shortage::end_with(failure::TRANSIENT).and_then(|()| signals::heed(&unfinished));
    let heeded = heeded.map_err(|error| NoSignals(error).into());
    match heeded.and_then(|()| run(&arguments.command, &unfinished)) {
        Ok(()) => ExitCode::SUCCESS,
        // The handler is about to end the process; what it interrupted is no failure.
        Err(_) if unfinished.is_canceled() => loop {
            std::thread::park();
        },
        Err(failure) => failure::report(&failure),
    }
}

fn run(command: &Command, unfinished: &Unfinished) -> Result<(), Failure> {
    let mut output = StandardOutput::new();
    match command {
        Command::Render(arguments) => render::run(arguments, unfinished),
        Command::Tonemap(arguments) => with_threads(None, || {
            tonemap::run(arguments, unfinished, &mut io::stderr())
        }),
        Command::ContactSheet(arguments) => with_threads(None, || {
            contact_sheet::run(arguments, unfinished, &mut io::stderr())
        }),
        Command::Relight(arguments) => with_threads(None, || {
            relight::run(arguments, unfinished, &mut io::stderr())
        }),
        Command::Merge(arguments) => with_threads(None, || {
            merge::run(arguments, unfinished, &mut io::stderr())
        }),
        Command::Check(arguments) => with_threads(None, || check::run(arguments, &mut output)),
        Command::Probe(arguments) => with_threads(None, || probe(arguments, &mut output)),
        Command::Verify(arguments) => {
            with_threads(None, || verify::run(arguments, unfinished, &mut output))
        }
        Command::Lux(arguments) => {
            with_threads(None, || lux::run(arguments, unfinished, &mut output))
        }
        Command::Light(arguments) => light::run(arguments, unfinished, &mut output),
        Command::Job(arguments) => job::run(arguments, unfinished, &mut output),
        Command::Report(arguments) => report::run(arguments, unfinished, &mut output),
        Command::Diff(arguments) => {
            with_threads(None, || diff::run(arguments, unfinished, &mut output))
        }
        Command::New(arguments) => new::run(arguments, unfinished, &mut output),
        Command::Completions(arguments) => completions::run(arguments, &mut output),
        Command::Man(arguments) => man::run(arguments, unfinished, &mut output),
        Command::Schema(schema::Arguments {}) => schema::run(&mut output),
    }?;
    Ok(output.flush()?)
}

fn probe(arguments: &probe::Arguments, output: &mut impl Write) -> Result<(), Failure> {
    let Loaded {
        scene,
        world,
        camera,
        ..
    } = arguments.scene.load(arguments.frame.number(), |scene| {
        probe::prepare(arguments, scene);
    })?;
    let renderer = Renderer::new(&world)?;
    let rendered = |[x, y]: [u32; 2]| {
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
        let (film, _) = renderer.film(&camera, &options, &Job::new())?;
        let [r, g, b, _] = film.pixels()[0];
        Ok([r, g, b])
    };
    probe::run(arguments, &scene, rendered, output)
}

/// Works with as many threads as asked; without that, as many as `RAYON_NUM_THREADS` says, or one for
/// each logical processor.
fn with_threads<T: Send>(
    asked: Option<u32>,
    work: impl FnOnce() -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let variable = std::env::var("RAYON_NUM_THREADS").ok();
    let threads = threads(asked, variable.as_deref());
    look_for_threads(threads).map_err(|error| NoThreads(error.for_what("their stacks").into()))?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .map_err(|error| NoThreads(error.into()))?;
    pool.install(work)
}

/// The system gives nothing to wait for signals with.
#[derive(Debug, thiserror::Error)]
#[error("cannot wait for signals: {0}")]
struct NoSignals(#[source] io::Error);

/// The system gives no more threads.
#[derive(Debug, thiserror::Error)]
#[error(
    "cannot start the threads to work with: {0}; choose fewer by RAYON_NUM_THREADS or --threads"
)]
struct NoThreads(#[source] Failure);

/// How many threads work, from 1 to [`MAX_THREADS`]. What the variable says is taken only if it is a
/// number of threads, be it too large.
fn threads(asked: Option<u32>, variable: Option<&str>) -> usize {
    let said = || {
        let digits = variable.map(str::trim).filter(|text| !text.is_empty())?;
        let is_number = digits.bytes().all(|byte| byte.is_ascii_digit());
        // More digits than a number has are a large number.
        let number = is_number.then(|| digits.parse().unwrap_or(u32::MAX));
        number.filter(|&number| number > 0)
    };
    let processors = || std::thread::available_parallelism().map_or(1, usize::from);
    let asked = asked.or_else(said).map(|threads| threads as usize);
    let threads = asked.unwrap_or_else(processors);
    threads.clamp(1, MAX_THREADS as usize)
}

/// Whether terminals take sequences for colors and for moving back.
fn terminals_are_steerable() -> bool {
    std::env::var_os("TERM").is_none_or(|name| name != "dumb")
}

/// Whether a stream is a terminal that takes such sequences.
fn is_steerable(stream: &impl IsTerminal) -> bool {
    stream.is_terminal() && terminals_are_steerable()
}

/// Where clap prints in color: by its own rule, which heeds NO_COLOR, but never at terminals that are
/// dumb. Alone it would color these too where `CI` is set.
fn color_choice() -> ColorChoice {
    if terminals_are_steerable() {
        ColorChoice::Auto
    } else {
        ColorChoice::Never
    }
}

/// Refuses to write over a file that is read, or two files to one place.
fn refuse_same_files(inputs: &[&Path], outputs: &[&Path]) -> Result<(), Failure> {
    let read: Vec<Place> = inputs
        .iter()
        .map(|input| Place::of_input(source::unshown(input)))
        .collect();
    let mut written: Vec<Place> = Vec::new();
    for output in outputs {
        let place = Place::of_output(output);
        if let Some(index) = read.iter().position(|input| input.is(&place)) {
            return Err(format!(
                "{} would be written over {}, which is read; give another name",
                printable_path(output),
                printable_path(inputs[index]),
            )
            .into());
        }
        if let Some(index) = written.iter().position(|other| other.is(&place)) {
            if place.is_standard_output() && written[index].is_standard_output() {
                let message = "two outputs would go to standard output; give one of them a file";
                return Err(Misuse(message.to_owned()).into());
            }
            return Err(format!(
                "{} and {} would be one file; give another name",
                printable_path(outputs[index]),
                printable_path(output),
            )
            .into());
        }
        written.push(place);
    }
    Ok(())
}

/// Refuses to send what is no text to a terminal, before there is work done for it.
fn refuse_terminal(output: &Path) -> Result<(), Failure> {
    if io::stdout().is_terminal() && Place::of_output(output).is_standard_output() {
        let path = output.to_path_buf();
        let problem = OutputProblem::Terminal;
        return Err(OutputError { path, problem }.into());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_as_many_as_asked_or_said_or_there() {
        let there = std::thread::available_parallelism().map_or(1, usize::from);
        for (asked, variable, expected) in [
            (Some(3), Some("5"), 3),
            (None, Some("5"), 5),
            (None, Some(" 7 "), 7),
            (None, Some("1025"), 1024),
            (None, Some("100000"), 1024),
            (None, Some("99999999999999999999999999"), 1024),
            (None, Some("0"), there.min(1024)),
            (None, Some(""), there.min(1024)),
            (None, Some("-1"), there.min(1024)),
            (None, Some("many"), there.min(1024)),
            (None, None, there.min(1024)),
        ] {
            assert_eq!(threads(asked, variable), expected, "{asked:?} {variable:?}");
        }
    }
}
