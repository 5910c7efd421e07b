//! `candela contact-sheet`: all views of a picture, or all layers of a file, side by side.

mod equations;
mod sheet;

use std::ffi::OsStr;
use std::io::Write;
use std::path::{Path, PathBuf};

use candela::display::{Exposure, Image, Input, Settings, Thumbnail, View, shown_exposure};
use candela::exr::Content;
use candela::internal::{counted, printable, printable_path};
use candela::output::Unfinished;
use clap::builder::{OsStringValueParser, PossibleValuesParser, TypedValueParser};

use super::Failure;
use super::advice::frame_number;
use super::develop::ExposureArguments;
use super::numbers::number;
use super::render::count;
use super::sequence::{found, input_name, named_after};
use equations::equation;
use sheet::{Cell, GROUND, Head, Layout, sheet};

/// The most layers on a sheet: more are not looked at, and take their time.
const MOST: usize = 100;

/// The most columns of a small picture.
const WIDEST: u32 = 4096;

/// A small picture is at most so many times as high as wide may be.
const HIGHEST: u32 = 4;

/// What the sheet's name has in place of the file's extension.
const SUFFIX: &str = "contact.png";

/// Make a sheet of small pictures: all views of an EXR, or all its layers, or the frames of a sequence
///
/// Of a PNG, JPEG, TIFF or Radiance HDR too, as `candela tonemap` reads it, all views.
///
/// Frames are `f.####.exr` or `f.%04d.exr`, a pattern such as `*.exr`, or several files; of more than 100, 100 are shown.
///
/// Each picture is made small in linear light, from the file itself, and has its name below. All are at the same
/// exposure. Of layers, those with colors are shown as light; single channels as grays over their range, which is
/// written beside the name; vectors as colors, 0.5 + 0.5 x. Beside the layers of `candela render --layers` stands the
/// equation of the lecture that they show, such as L5 or L4: V.
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Examples:
  candela contact-sheet scene.exr
      Make scene.contact.png here: the picture in each view
  candela contact-sheet scene.exr --auto-exposure -o views.png
      At the exposure that brings it into view
  candela contact-sheet scene.exr --layers
      Each layer of the file, with its name
  candela contact-sheet scene.exr --layers --view reinhard --width 240
      Smaller, and nothing clips
  candela contact-sheet scene.exr --layer light_key
      What one light adds, in each view
  candela contact-sheet f.####.exr --width 240 -o shot.png
      The frames of a sequence, with their numbers")]
pub(crate) struct Arguments {
    /// The EXR file, or a PNG, JPEG, TIFF or Radiance HDR; - is standard input; or frames, f.####.exr
    #[arg(value_name = "IN.exr", required = true)]
    inputs: Vec<PathBuf>,

    /// The PNG file, or - for standard output [default: IN.contact.png in the current folder]
    #[arg(short, long, value_name = "OUT.png", value_parser = png_path())]
    output: Option<PathBuf>,

    /// Show all layers in place of all views
    #[arg(long)]
    layers: bool,

    /// The layer to show in all views, as in tonemap [default: the channels R, G, B, A outside of layers]
    #[arg(long, value_name = "NAME", conflicts_with = "layers")]
    layer: Option<String>,

    /// The view of layers with light, and of frames [default: srgb]
    #[arg(
        long,
        value_name = "NAME",
        value_parser = PossibleValuesParser::new(View::ALL.map(View::name))
            .try_map(|name| name.parse::<View>())
    )]
    view: Option<View>,

    /// Columns of each small picture, 1 to 4096
    #[arg(long, value_name = "N", default_value_t = 480, value_parser = |text: &str| count(text, WIDEST))]
    width: u32,

    #[command(flatten)]
    exposure: ExposureArguments,
}

impl Arguments {
    /// What is wrong with the options as they stand together.
    pub(crate) fn misuse(&self) -> Option<String> {
        let is_pattern = frame_number(self.input()).is_some()
            || self.input().to_string_lossy().contains(['*', '?', '[']);
        // A file of that very name is meant.
        let is_there = || self.input().symlink_metadata().is_ok();
        let is_one = self.inputs.len() == 1 && (!is_pattern || is_there());
        if is_one && !self.layers && self.view.is_some() {
            let message =
                "one file is shown in all views; --view goes with --layers, or with frames";
            return Some(message.to_owned());
        }
        (!is_one && self.layers).then(|| {
            "--layers shows those of one file; leave it out to see frames, or name one file"
                .to_owned()
        })
    }

    /// What the sheet is about: the first of several files.
    fn input(&self) -> &Path {
        self.inputs.first().map_or(Path::new("-"), PathBuf::as_path)
    }
}

/// Makes the sheet; warnings, and the exposure if it was chosen, go to `messages`.
pub(crate) fn run(
    arguments: &Arguments,
    unfinished: &Unfinished,
    messages: &mut impl Write,
) -> Result<(), Failure> {
    let frames = found(&arguments.inputs)?;
    let input = arguments.input();
    let default;
    let output = match &arguments.output {
        Some(output) => output.as_path(),
        None => {
            default = match frame_number(input) {
                Some(part) => {
                    let name = input.to_string_lossy().replacen(&part, "", 1);
                    named_after(Path::new(&name.replace("..", ".")), SUFFIX)?
                }
                None => named_after(input, SUFFIX)?,
            };
            &default
        }
    };
    super::refuse_terminal(output)?;
    let found = match frames.as_slice() {
        [(one, None)] if arguments.layers => layers(arguments, one, output)?,
        [(one, None)] => views(arguments, one, output)?,
        frames => sequence(arguments, frames, output)?,
    };
    // Nowhere is left to report that the messages themselves cannot be written.
    for warning in &found.warnings {
        let _ = writeln!(messages, "warning: {}: {warning}", input_name(input));
    }
    if arguments.exposure.exposure().is_auto() {
        let _ = writeln!(messages, "exposure: {}", shown_exposure(found.ev));
    }
    let [width, height] = found.resolution;
    let mut notes = vec![format!("{width} × {height}"), short_exposure(found.ev)];
    notes.extend(arguments.view.map(|view| view.name().to_owned()));
    let head = Head {
        title: title(input, arguments.layer.as_deref()),
        note: notes.join("  ·  "),
    };
    let layout = Layout::new(found.cells.len() as u32, found.picture);
    let image = sheet(&layout, &head, &found.cells)?;
    image.write_png(output, unfinished)?;
    Ok(())
}

/// What goes on the sheet.
struct Found {
    /// Width and height of the file's display window.
    resolution: [u32; 2],
    ev: f64,
    /// Width and height of each picture.
    picture: [u32; 2],
    cells: Vec<Cell>,
    warnings: Vec<String>,
}

/// One picture in all views.
fn views(arguments: &Arguments, path: &Path, output: &Path) -> Result<Found, Failure> {
    let input = Input::open(path, arguments.layer.as_deref())?;
    super::refuse_same_files(&[path], &[output])?;
    let picture = small(arguments.width, &input);
    let thumbnail = Thumbnail::new(&input, picture, arguments.exposure.exposure())?;
    let ev = thumbnail.ev();
    let cell = |view: View| Cell {
        name: view.name().to_owned(),
        note: String::new(),
        image: developed(&thumbnail, view, ev),
    };
    Ok(Found {
        resolution: input.resolution(),
        ev,
        picture,
        cells: View::ALL.into_iter().map(cell).collect(),
        warnings: thumbnail.warnings().to_vec(),
    })
}

/// All layers of a file.
fn layers(arguments: &Arguments, path: &Path, output: &Path) -> Result<Found, Failure> {
    let file = Input::layers(path)?;
    super::refuse_same_files(&[path], &[output])?;
    let view = arguments.view.unwrap_or_default();
    let mut warnings = Vec::new();
    let names: Vec<&str> = file.names().collect();
    let shown = &names[..names.len().min(MOST)];
    if shown.len() < names.len() {
        warnings.push(format!(
            "{} are left out; show one of them with `candela tonemap --layer NAME`: {}, …",
            counted(names.len() - MOST, "layer", "layers"),
            printable(names[MOST]),
        ));
    }
    let Some((&first, rest)) = shown.split_first() else {
        let file = input_name(path);
        return Err(format!("{file} has no channels, so that there is nothing to show").into());
    };

    // The first one says how large the pictures are, and at which exposure.
    let input = Input::from(file.reader(0)?);
    let (resolution, picture) = (input.resolution(), small(arguments.width, &input));
    let thumbnail = Thumbnail::new(&input, picture, arguments.exposure.exposure())?;
    let ev = thumbnail.ev();
    let mut cells = vec![cell(first, &thumbnail, view, ev)];
    add_warnings(&mut warnings, &thumbnail);
    for (number, name) in (1..).zip(rest) {
        let thumbnail = Thumbnail::new(&file.reader(number)?.into(), picture, Exposure::Ev(ev))?;
        cells.push(cell(name, &thumbnail, view, ev));
        add_warnings(&mut warnings, &thumbnail);
    }
    Ok(Found {
        resolution,
        ev,
        picture,
        cells,
        warnings,
    })
}

/// Frames of a sequence, all at the exposure of the first.
fn sequence(
    arguments: &Arguments,
    frames: &[(PathBuf, Option<String>)],
    output: &Path,
) -> Result<Found, Failure> {
    let paths: Vec<&Path> = frames.iter().map(|(path, _)| path.as_path()).collect();
    super::refuse_same_files(&paths, &[output])?;
    let mut warnings = Vec::new();
    if frames.len() > MOST {
        let all = counted(frames.len(), "frame", "frames");
        warnings.push(format!("{MOST} of {all} are shown, evenly over all"));
    }
    let shown = frames.len().min(MOST);
    let last = (frames.len() - 1) as u64;
    // The first and the last are among them.
    let place = |number: usize| number as u64 * last / (shown as u64 - 1).max(1);
    let mut first: Option<([u32; 2], [u32; 2], f64)> = None;
    let mut cells = Vec::new();
    for number in 0..shown {
        let (path, frame) = &frames[place(number) as usize];
        let input = Input::open(path, arguments.layer.as_deref())?;
        let resolution = input.resolution();
        let exposure = first.map_or_else(
            || arguments.exposure.exposure(),
            |(_, _, ev)| Exposure::Ev(ev),
        );
        let picture =
            first.map_or_else(|| small(arguments.width, &input), |(_, picture, _)| picture);
        let thumbnail = Thumbnail::new(&input, picture, exposure)?;
        let (of_first, _, ev) = *first.get_or_insert((resolution, picture, thumbnail.ev()));
        if of_first != resolution {
            let name = |[width, height]: [u32; 2]| format!("{width} × {height}");
            return Err(format!(
                "{} has {} pixels, and {} before it {}; a sheet shows frames of one size",
                printable_path(path),
                name(resolution),
                printable_path(paths[0]),
                name(of_first),
            )
            .into());
        }
        let shown = frame.clone().unwrap_or_else(|| title(path, None));
        let view = arguments.view.unwrap_or_default();
        cells.push(Cell {
            name: printable(&shown),
            note: String::new(),
            ..cell("", &thumbnail, view, ev)
        });
        add_warnings(&mut warnings, &thumbnail);
    }
    let (resolution, picture, ev) = first.unwrap_or(([0; 2], [1; 2], 0.0));
    Ok(Found {
        resolution,
        ev,
        picture,
        cells,
        warnings,
    })
}

/// Adds warnings that are not there yet: many are of the file, and not of a layer.
fn add_warnings(warnings: &mut Vec<String>, thumbnail: &Thumbnail) {
    for warning in thumbnail.warnings() {
        if !warnings.contains(warning) {
            warnings.push(warning.clone());
        }
    }
}

/// A layer as it is shown.
fn cell(name: &str, thumbnail: &Thumbnail, view: View, ev: f64) -> Cell {
    let equation = equation(name);
    let name = if name.is_empty() {
        "R, G, B".to_owned()
    } else {
        printable(name)
    };
    match thumbnail.content() {
        Content::Light => Cell {
            name,
            note: equation.unwrap_or_default().to_owned(),
            image: developed(thumbnail, view, ev),
        },
        Content::Vectors | Content::Numbers => Cell {
            name,
            note: match equation {
                Some(equation) => format!("{equation}  {}", range(thumbnail)),
                None => range(thumbnail),
            },
            image: thumbnail.scaled(GROUND),
        },
    }
}

fn developed(thumbnail: &Thumbnail, view: View, ev: f64) -> Image {
    thumbnail.developed(&Settings {
        exposure: Exposure::Ev(ev),
        view,
        ..Settings::default()
    })
}

/// From what to what a layer goes.
fn range(thumbnail: &Thumbnail) -> String {
    let Some(range) = thumbnail.range() else {
        return "no numbers".to_owned();
    };
    let [least, most] = [range.least, range.most].map(digits);
    if least == most {
        return least;
    }
    let scale = if range.is_logarithmic { ", log" } else { "" };
    format!("{least} … {most}{scale}")
}

/// Three significant digits.
fn digits(value: f64) -> String {
    let rounded = format!("{value:.2e}").parse().unwrap_or(value);
    number(rounded).replace('-', "−")
}

/// Width and height of a small picture: as wide as asked, unless that makes it too high. Pictures that are smaller are
/// made larger by a whole factor, so that their pixels stay sharp.
fn small(width: u32, input: &Input) -> [u32; 2] {
    let aspect = f64::from(input.pixel_aspect());
    // As a range, which holds no NaN.
    let aspect = if (0.1..=10.0).contains(&aspect) {
        aspect
    } else {
        1.0
    };
    small_size(width, input.resolution(), aspect)
}

fn small_size(width: u32, resolution: [u32; 2], aspect: f64) -> [u32; 2] {
    let [columns, rows] = resolution.map(f64::from);
    let most = f64::from(width);
    let mut factor = (most / columns).min(most * f64::from(HIGHEST) * aspect / rows);
    if factor > 1.0 {
        factor = factor.floor();
    }
    [columns * factor, rows * factor / aspect].map(|side| (side.round() as u32).max(1))
}

/// The file's name without its folder, and the layer.
fn title(input: &Path, layer: Option<&str>) -> String {
    let name = Path::new(input.file_name().unwrap_or(input.as_os_str()));
    let name = input_name(name);
    match layer {
        Some(layer) => format!("{name}  {}", printable(layer)),
        None => name,
    }
}

/// With two decimals at most.
fn short_exposure(ev: f64) -> String {
    let rounded = (ev * 100.0).round() / 100.0;
    let sign = if rounded > 0.0 { "+" } else { "" };
    format!("{sign}{} EV", number(rounded).replace('-', "−"))
}

/// A path whose name does not promise another format, such as the input's.
fn png_path() -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().try_map(|path| {
        let path = PathBuf::from(path);
        super::advice::no_frames(&path)?;
        match path.extension() {
            Some(extension) if !extension.eq_ignore_ascii_case(OsStr::new("png")) => Err(format!(
                "candela contact-sheet writes PNG; name the file {}",
                printable_path(&path.with_extension("png"))
            )),
            _ => Ok(path),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_pictures_keep_their_shape() {
        assert_eq!(small_size(480, [1280, 720], 1.0), [480, 270]);
        assert_eq!(small_size(480, [60, 40], 1.0), [480, 320]);
        assert_eq!(small_size(480, [300, 200], 1.0), [300, 200]);
        assert_eq!(small_size(480, [1280, 720], 2.0), [480, 135]);
        assert_eq!(small_size(480, [4000, 10], 1.0), [480, 1]);
        assert_eq!(small_size(480, [10, 40_000], 1.0), [1, 1920]);
        assert_eq!(small_size(1, [7, 7], 1.0), [1, 1]);
    }

    #[test]
    fn what_is_written() {
        assert_eq!(short_exposure(0.0), "0 EV");
        assert_eq!(short_exposure(1.456), "+1.46 EV");
        assert_eq!(short_exposure(-2.0), "−2 EV");
        assert_eq!(short_exposure(-0.001), "0 EV");
        assert_eq!(digits(-1234.5), "−1230");
        assert_eq!(digits(0.000_012_34), "1.23e−5");
        assert_eq!(title(Path::new("a/b.exr"), None), "b.exr");
        let default = |input| named_after(Path::new(input), SUFFIX).ok();
        assert_eq!(default("a/b.c.exr"), Some(PathBuf::from("b.c.contact.png")));
        assert_eq!(default("-"), None);
    }
}
