//! `candela job`: what a render farm takes, of a scene and the options of `render`.

mod chunks;
mod opencue;
mod openjd;
mod quoting;
mod slurm;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use candela::internal::{counted, printable, printable_path};
use candela::output::{self, Unfinished};
use clap::{Parser, ValueEnum};

use super::advice;
use super::failure::Misuse;
use super::frames::{Frames, frames};
use super::render::{self, FirstFrame, count, named};
use super::source::is_standard_input;
use super::{Command, Failure};
use chunks::{Cost, chunk_size};

/// More tiles than any image is worth; how many an image may have, its strips say.
const MOST_TILES: u32 = 10_000;

/// The farm that takes the job.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Engine {
    /// Open Job Description 2023-09: `openjd run` on one machine, AWS Deadline Cloud
    #[value(name = "openjd")]
    OpenJd,
    /// A batch script for `sbatch`
    Slurm,
    /// A list of commands for `cuecmd`
    #[value(name = "opencue")]
    OpenCue,
}

/// Print what a render farm takes: frames in chunks, or tiles and their merge
///
/// Nothing is rendered but parts of the first frame, for half a second, to find out how many frames make a task of some
/// minutes. Paths are parameters of the job, and a task that is run again goes on where it was ended (--skip-done).
/// How to submit it stands in the first lines.
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Examples:
  candela job shot.toml --frames 1-240 -o f.####.exr > job.yaml
      A sequence, for `openjd run` and AWS Deadline Cloud
  candela job shot.toml --frames 1-240 -- --samples 64 --layers lights > job.yaml
      With options of `candela render`, after two dashes
  candela job scene.toml --tiles 16 -o scene.exr > job.yaml
      One image in 16 tiles, and a step that merges them
  candela job shot.toml --frames 1-240 --engine slurm > job.sh
      A batch script for Slurm
  candela job shot.toml --frames 1-240 --bundle bundle
      A folder for `deadline bundle submit`, with the list of all files that the scene names")]
pub(crate) struct Arguments {
    /// The scene file
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,

    /// The frames, such as 1-100, 1-100:2 or 1,5,9-12 [default: a still]
    #[arg(long, visible_alias = "frame", value_name = "LIST", value_parser = frames, allow_hyphen_values = true)]
    frames: Option<Frames>,

    /// Part each image into so many tiles, which are merged when all are there
    #[arg(long, value_name = "N", value_parser = |text: &str| count(text, MOST_TILES))]
    tiles: Option<u32>,

    /// The farm
    #[arg(long, value_name = "NAME", default_value = "openjd")]
    engine: Engine,

    /// The EXR file, or those of all frames, such as out/f.####.exr [default: SCENE.exr or SCENE.####.exr in the current
    /// folder]
    #[arg(short, long, value_name = "OUT.exr", value_parser = named("exr"))]
    output: Option<PathBuf>,

    /// Seconds that a frame takes on the machines of the farm, instead of measuring it here
    #[arg(long, value_name = "S", value_parser = super::diff::limit)]
    seconds_per_frame: Option<f64>,

    /// Write template.yaml, parameter_values.yaml and asset_references.yaml to this folder, which is made if it is not
    /// there: a job bundle of AWS Deadline Cloud. Nothing goes to standard output
    #[arg(long, value_name = "DIR")]
    bundle: Option<PathBuf>,

    /// Options of `candela render` for all tasks, after --, such as --samples 64 --layers lights
    #[arg(last = true, value_name = "OPTIONS")]
    options: Vec<String>,
}

/// A job, whatever the farm.
struct Job {
    scene: String,
    /// The folder of what is written; empty for the current one.
    folder: String,
    /// Its name, with a place for numbers where there are several frames.
    name: String,
    frames: Option<Frames>,
    tiles: Option<u32>,
    options: Vec<String>,
    cost: Cost,
    /// Frames of a task.
    chunk: usize,
    /// Absolute paths of all files that the scene was read from.
    inputs: Vec<String>,
}

pub(crate) fn run(
    arguments: &Arguments,
    unfinished: &Unfinished,
    output: &mut impl Write,
) -> Result<(), Failure> {
    if arguments.bundle.is_some() && arguments.engine != Engine::OpenJd {
        return misuse("--bundle goes with --engine openjd");
    }
    if arguments.engine == Engine::OpenCue && arguments.tiles.is_some() {
        return misuse(
            "a list of cuecmd has no command that waits for others, so that tiles would not be merged; \
             leave out --tiles, or choose --engine openjd or slurm",
        );
    }
    let render = arguments.render()?;
    let job = super::with_threads(None, || Job::new(arguments, &render))?;
    let Some(folder) = &arguments.bundle else {
        let text = match arguments.engine {
            Engine::OpenJd => openjd::template(&job)?,
            Engine::Slurm => slurm::script(&job),
            Engine::OpenCue => opencue::list(&job)?,
        };
        output.write_all(text.as_bytes())?;
        return Ok(());
    };
    fs::create_dir_all(folder)
        .map_err(|error| format!("cannot make the folder {}: {error}", printable_path(folder)))?;
    for (name, text) in openjd::bundle(&job)? {
        output::write(&folder.join(name), unfinished, |sink| {
            sink.write_all(text.as_bytes())
        })?;
    }
    Ok(())
}

fn misuse<T>(message: &str) -> Result<T, Failure> {
    Err(Misuse(message.to_owned()).into())
}

impl Arguments {
    /// The command that the tasks are parts of, as `candela render` reads it.
    fn render(&self) -> Result<render::Arguments, Failure> {
        if is_standard_input(&self.scene) {
            return misuse("the machines of a farm have no standard input; give the scene a file");
        }
        let frames = self.frames.as_ref().map(chunks::text);
        let scene = text(&self.scene, "the scene")?;
        let mut words = vec!["candela".to_owned(), "render".to_owned()];
        words.extend(frames.map(|frames| format!("--frames={frames}")));
        if let Some(output) = &self.output {
            words.push(format!("--output={}", text(output, "-o")?));
        }
        // Said here, they cannot be said twice.
        let own = ["--skip-done", "--progress=openjd", "--quiet"];
        words.extend(own.map(str::to_owned));
        words.extend(self.options.iter().cloned());
        words.extend(["--".to_owned(), scene]);
        let parsed = super::Arguments::try_parse_from(&words).map_err(|error| {
            let text = error.to_string();
            let first = text.lines().next().unwrap_or_default();
            let message = first.strip_prefix("error: ").unwrap_or(first);
            Misuse(format!(
                "the options of `candela render` after `--`: {}",
                printable(message)
            ))
        })?;
        let Command::Render(render) = parsed.command else {
            return misuse("what stands after `--` are options of `candela render`");
        };
        if let Some(misuse) = render.misuse() {
            return Err(Misuse(misuse).into());
        }
        for (name, is_twice) in [
            ("-o", render.has_output() != self.output.is_some()),
            ("--frames", render.has_frames() != self.frames.is_some()),
        ] {
            if is_twice {
                return Err(Misuse(format!(
                    "{name} stands after `--`; it is an option of `candela job`, and stands before"
                ))
                .into());
            }
        }
        if let Some(option) = render.beyond_jobs() {
            return Err(Misuse(format!(
                "{option} is not for jobs, whose tasks write EXR files alone; leave it out. Pictures of frames are made \
                 by `candela tonemap`"
            ))
            .into());
        }
        let has = |name: &str| {
            let is = |word: &String| word.split('=').next() == Some(name);
            self.options.iter().any(is)
        };
        for name in ["--tile", "--base"] {
            if has(name) {
                return Err(Misuse(format!(
                    "{name} is not for jobs: tiles are parted by --tiles, and the files that a scene names are found from \
                     its own folder"
                ))
                .into());
            }
        }
        Ok(*render)
    }
}

impl Job {
    /// Reads and checks the scene; renders a part of it, where what a frame takes matters and is not said.
    fn new(arguments: &Arguments, render: &render::Arguments) -> Result<Self, Failure> {
        let output = FirstFrame::output(render);
        let first = FirstFrame::load(render, arguments.tiles)?;
        let number = arguments
            .frames
            .as_ref()
            .map_or(1, |list| list.list().len());
        let cost = match arguments.seconds_per_frame {
            Some(seconds) => Cost::Stated(seconds),
            None if number > 1 && arguments.tiles.is_none() => Cost::Measured(first.seconds()?),
            None => Cost::Unknown,
        };
        let name = output.file_name().unwrap_or_default();
        let job = Self {
            scene: text(&arguments.scene, "the scene")?,
            folder: text(output.parent().unwrap_or(Path::new("")), "-o")?,
            name: text(Path::new(name), "-o")?,
            frames: arguments.frames.clone(),
            tiles: arguments.tiles,
            options: arguments.options.clone(),
            cost,
            chunk: chunk_size(cost),
            inputs: first
                .files()
                .iter()
                .map(|path| text(&std::path::absolute(path)?, "a file of the scene"))
                .collect::<Result<_, Failure>>()?,
        };
        let rest = match advice::frame_number(&output) {
            Some(part) => job.name.replacen(&part, "0001", 1),
            None => job.name.clone(),
        };
        if job.tiles.is_some() && job.frames.is_some() && rest == job.name {
            return misuse(
                "tiles of frames need a place for the number of the frame in their name, such as -o f.####.exr",
            );
        }
        if job.tiles.is_some() && advice::frame_number(Path::new(&rest)).is_some() {
            return misuse(
                "the name of -o has a second place for numbers, which tiles need; choose another",
            );
        }
        Ok(job)
    }

    /// The chunks of frames, each as `--frames` takes it.
    fn chunks(&self) -> Vec<String> {
        let list = self.frames.as_ref().map_or(&[][..], Frames::list);
        list.chunks(self.chunk).map(chunks::text_of).collect()
    }

    /// The numbers of all frames as they stand in names.
    fn numbers(&self) -> Vec<String> {
        let list = self.frames.as_ref().map_or(&[][..], Frames::list);
        let place =
            advice::frame_number(Path::new(&self.name)).unwrap_or_else(|| "####".to_owned());
        let number = |frame: &super::frames::Frame| frame.name(Path::new(&place));
        list.iter()
            .map(|frame| number(frame).to_string_lossy().into_owned())
            .collect()
    }

    /// The name of an image with a number in its place, before and after what tells the tile from others.
    fn tile_name(&self, number: Option<&str>, tile: &str) -> String {
        let name = self.numbered(number);
        let count = self.tiles.unwrap_or(1);
        let stem = name.strip_suffix(".exr").unwrap_or(&name);
        format!("{stem}.tile{tile}.of{count}.exr")
    }

    /// The name of an image with a number in its place.
    fn numbered(&self, number: Option<&str>) -> String {
        match (number, advice::frame_number(Path::new(&self.name))) {
            (Some(number), Some(part)) => self.name.replacen(&part, number, 1),
            (Some(_), None) | (None, _) => self.name.clone(),
        }
    }

    /// The name of an image in its folder.
    fn path(&self, name: &str) -> String {
        if self.folder.is_empty() {
            // A command does not take it for an option.
            if name.starts_with('-') {
                format!("./{name}")
            } else {
                name.to_owned()
            }
        } else {
            let path = Path::new(&self.folder).join(name);
            path.to_string_lossy().into_owned()
        }
    }

    /// The scene, which a command does not take for an option.
    fn scene_word(&self) -> String {
        if self.scene.starts_with('-') {
            format!("./{}", self.scene)
        } else {
            self.scene.clone()
        }
    }

    /// What is said of the sizes of tasks.
    fn remark(&self) -> String {
        let frames = self.frames.as_ref().map_or(1, |list| list.list().len());
        match self.tiles {
            Some(tiles) => format!(
                "{}, each in {}, and their merge.",
                counted(frames, "image", "images"),
                counted(tiles as usize, "tile", "tiles"),
            ),
            None => self.cost.remark(frames, self.chunk),
        }
    }
}

/// A path as text: templates and scripts are UTF-8.
fn text(path: &Path, what: &str) -> Result<String, Failure> {
    match path.to_str() {
        Some(text) => Ok(text.to_owned()),
        None => Err(format!(
            "the name of {what}, {}, is no UTF-8, which jobs are; rename it",
            printable_path(path)
        )
        .into()),
    }
}
