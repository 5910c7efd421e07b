//! `candela merge`: tiles become the file of the whole render.

use std::io::{self, Write};
use std::path::PathBuf;

use candela::exr::{self, MergeReport};
use candela::internal::counted;
use candela::output::{self, Unfinished};

use super::render::named;
use super::sequence::output_name;
use super::{Failure, refuse_same_files, refuse_terminal, sequence};

/// Merge the tiles of an image, rendered by many machines perhaps, to the bytes of the whole render
///
/// Takes what `candela render --tile I/N` writes: all N tiles, in any order. The new file is that of a render without
/// --tile, to the byte, under any compression, with all layers. Tiles that are missing, damaged or of another scene,
/// version or option are refused, with the tile that is to be rendered anew.
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Examples:
  candela merge t0.exr t1.exr t2.exr -o scene.exr
      The three tiles of an image
  candela merge scene.tile####.exr -o scene.exr
      All tiles under the names that `candela render` gives them where no other is said
  candela merge scene.tile####.0001.exr -o scene.0001.exr
      Those of frame 1, of a sequence whose frames are rendered in tiles
  candela merge 'tiles/*.exr' -o scene.exr
      All files of a folder")]
pub(crate) struct Arguments {
    /// The tiles: files, a pattern such as *.exr, or numbered files such as t.####.exr or t.%04d.exr
    #[arg(value_name = "IN.exr", required = true)]
    inputs: Vec<PathBuf>,

    /// The EXR file to write; - is standard output
    #[arg(short, long, value_name = "OUT.exr", value_parser = named("exr"))]
    output: PathBuf,

    /// No summary
    #[arg(short, long)]
    quiet: bool,
}

/// Writes the merged file; what there is to say goes to `messages`.
pub(crate) fn run(
    arguments: &Arguments,
    unfinished: &Unfinished,
    messages: &mut impl Write,
) -> Result<(), Failure> {
    let Arguments {
        inputs,
        output,
        quiet,
    } = arguments;
    let inputs: Vec<PathBuf> = sequence::found(inputs)?
        .into_iter()
        .map(|(path, _)| path)
        .collect();
    let read: Vec<_> = inputs.iter().map(PathBuf::as_path).collect();
    refuse_same_files(&read, &[output])?;
    refuse_terminal(output)?;
    // Found out now rather than after the headers were read.
    output::check(output)?;
    let report = exr::merge(&inputs, output, unfinished)?;
    if !quiet {
        // Nowhere is left to report that the message itself cannot be written.
        let _ = summarize(arguments, &report, messages);
    }
    Ok(())
}

fn summarize(
    arguments: &Arguments,
    report: &MergeReport,
    messages: &mut impl Write,
) -> io::Result<()> {
    let [[width, height], [columns, rows]] = [report.resolution, report.size];
    let size = if report.size == report.resolution {
        format!("{width} × {height}")
    } else {
        format!("{columns} × {rows} of {width} × {height}")
    };
    let name = output_name(&arguments.output);
    let tiles = counted(report.tiles as usize, "tile", "tiles");
    writeln!(messages, "{name}: {size}, merged from {tiles}")
}
