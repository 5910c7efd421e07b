//! `candela relight`: a picture in other light, from its layers of lights.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use candela::internal::printable;
use candela::output::{self, Unfinished};
use candela::relight::{self, RelightError, Report, Setting};

use super::Failure;
use super::render::named;
use super::sequence::{input_name, output_name};

/// Change the lights of an image that was rendered: brighter, darker, off, or in another color
///
/// Reads an EXR with a layer for each light, as `candela render --layers lights` writes it, and adds its lights up
/// anew: what comes out is what a new render with these lights would be. What cannot be made exactly of what is in
/// the file is refused with the reason. The new file has the layers of the new lights, and can be relit again.
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Examples:
  candela relight scene.exr -o relit.exr --light key=2
      The light `key` twice as bright
  candela relight scene.exr -o relit.exr --light key=0.5 --light fill=off
      Half of the key, and no fill
  candela relight scene.exr -o relit.exr --light rim=#ff8040
      The candela that it has, in another color
  candela relight scene.exr -o relit.exr --light key={blackbody=3200}
      As a black body of 3200 K
  candela relight scene.exr -o relit.exr --light key=2,#ff8040
      Both at once
  candela relight scene.exr -o scene.exr --light background=0.5
      In place; the old file is there until the new one is whole")]
pub(crate) struct Arguments {
    /// The EXR file with layers of lights; - is standard input
    #[arg(value_name = "IN.exr")]
    input: PathBuf,

    /// The EXR file to write, which may be the same; - is standard output
    #[arg(short, long, value_name = "OUT.exr", value_parser = named("exr"))]
    output: PathBuf,

    /// What becomes of a light, a group of lights or the background; may be said once for each
    ///
    /// A number multiplies its intensity, and `off` is 0. A color, as #rrggbb or as what `color` of a scene takes
    /// in braces or brackets, takes the place of its own and keeps the candela. key=2,#ff8040 does both. A
    /// background can be multiplied only.
    #[arg(
        long = "light",
        value_name = "NAME=VALUE",
        required = true,
        value_parser = |text: &str| text.parse::<Setting>()
    )]
    lights: Vec<Setting>,

    /// No summary and no warnings
    #[arg(short, long)]
    quiet: bool,
}

/// Writes the new file; what there is to say goes to `messages`.
pub(crate) fn run(
    arguments: &Arguments,
    unfinished: &Unfinished,
    messages: &mut impl Write,
) -> Result<(), Failure> {
    let Arguments {
        input,
        output,
        lights,
        quiet,
    } = arguments;
    super::refuse_terminal(output)?;
    // Found out now rather than after the whole file was read.
    output::check(output)?;
    let report =
        relight::relight(input, output, lights, unfinished).map_err(|error| told(input, error))?;
    if !quiet {
        // Nowhere is left to report that the messages themselves cannot be written.
        let _ = summarize(arguments, &report, messages);
    }
    Ok(())
}

/// A line for the file, then one for each note and each warning.
fn summarize(arguments: &Arguments, report: &Report, messages: &mut impl Write) -> io::Result<()> {
    let [[width, height], [columns, rows]] = [report.resolution, report.size];
    let size = if report.size == report.resolution {
        format!("{width} × {height}")
    } else {
        format!("{columns} × {rows} of {width} × {height}")
    };
    let lights: Vec<String> = arguments.lights.iter().map(ToString::to_string).collect();
    writeln!(
        messages,
        "{}: {size}, relit with {}",
        output_name(&arguments.output),
        printable(&lights.join(" "))
    )?;
    for note in &report.notes {
        writeln!(messages, "note: {note}")?;
    }
    let counted = [
        (
            report.clamped_to_float,
            "values beyond the largest FLOAT, which became that",
        ),
        (
            report.clamped_to_half,
            "values beyond the largest HALF, which became that",
        ),
        (
            report.were_clamped,
            "values that were beyond the largest HALF or FLOAT already, so that their light is not known",
        ),
        (
            report.small_in_half,
            "values of layers of light below 6.1e-5, of which HALF keeps few digits",
        ),
    ];
    for (count, what) in counted.into_iter().filter(|&(count, _)| count > 0) {
        writeln!(messages, "warning: {what}: {count}")?;
    }
    Ok(())
}

/// An error, with the file that it is about where it does not say so itself.
fn told(input: &Path, error: RelightError) -> Failure {
    match error {
        RelightError::Color(errors) => errors.into(),
        RelightError::Read(error) => error.into(),
        RelightError::Write(error) => error.into(),
        RelightError::Memory(error) => error.into(),
        error => format!("cannot relight {}: {error}", input_name(input)).into(),
    }
}
