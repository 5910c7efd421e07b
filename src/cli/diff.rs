//! `candela diff`: how far an EXR is from another, layer by layer, with limits.

mod figures;
mod layers;
mod limits;
mod picture;
mod report;

use std::io::Write;
use std::path::{Path, PathBuf};

use candela::compare::{self, Metrics, Pair};
use candela::exr::{DataWindow, ExrChannels, write_planes};
use candela::internal::printable_path;
use candela::output::{self, Unfinished};
use clap::builder::{OsStringValueParser, TypedValueParser};

use super::Failure;
use super::failure::Beyond;
use super::source::is_standard_input;
use figures::{LayerReport, mean};
use layers::{Common, Layer};
use limits::Limits;
pub(super) use limits::limit;
use report::Report;

/// Samples of channels that are in memory at a time, where a layer has no more.
const TOGETHER: u64 = 1 << 27;

/// Compare two EXRs, layer by layer: errors, relative errors, pixels that flip, ꟻLIP
///
/// A is the reference, B is measured against it. Reads any OpenEXR file, from candela or elsewhere. With
/// limits, the exit code is 3 where a layer is beyond one of them.
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Examples:
  candela diff reference.exr scene.exr
      How far each layer of scene.exr is from that of reference.exr
  candela diff reference.exr scene.exr -o error.png
      The relative error as a picture: black up to 1e-6, bright where it is 1
  candela diff reference.exr scene.exr -o error.exr
      The absolute error of each channel
  candela diff reference.exr scene.exr --max-relative 1e-4 --max-flips 3
      For CI: 0 where the largest relative error is at most 1e-4 and 3 pixels flip, else 3
  candela diff reference.exr scene.exr --layers RGB,Z --json
      Of the channels R, G, B, A and of the depth, as JSON

Exit codes:
  0   no layer is beyond a limit, or there are no limits
  1   a file cannot be read, or both cannot be compared
  3   a layer is beyond a limit")]
pub(crate) struct Arguments {
    /// The reference; - is standard input
    #[arg(value_name = "A.exr")]
    reference: PathBuf,

    /// The image that is measured against it; - is standard input
    #[arg(value_name = "B.exr")]
    image: PathBuf,

    /// The error as a file: DIFF.exr has |B − A| of each channel in FLOAT, DIFF.png the relative error of
    /// R, G, B in false colors; may be said twice
    #[arg(short, long, value_name = "DIFF", value_parser = difference_path())]
    output: Vec<PathBuf>,

    /// Layers to compare, parted by commas: RGB is the channels outside of layers; Z, N, light_key
    /// [default: all, which both files must have]
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    layers: Vec<String>,

    /// The relative error from which on a pixel counts as a flip
    #[arg(long, value_name = "X", default_value = "0.01", value_parser = limit)]
    tolerance: f64,

    #[command(flatten)]
    limits: Limits,

    /// Write JSON, with all digits
    #[arg(long)]
    json: bool,
}

/// Compares; the report goes to `output`.
pub(crate) fn run(
    arguments: &Arguments,
    unfinished: &Unfinished,
    output: &mut impl Write,
) -> Result<(), Failure> {
    arguments.check_paths()?;
    let reference = ExrChannels::open(&arguments.reference)?;
    let image = ExrChannels::open(&arguments.image)?;
    let names = [&arguments.reference, &arguments.image].map(|path| named(path));
    let common = layers::common([&reference, &image], &names, &arguments.layers)?;

    let wants_exr = arguments.output.iter().any(|path| !is_png(path));
    let mut differences: Vec<(String, Vec<f32>)> = Vec::new();
    let mut picture = None;
    let shown = common.layers.iter().position(Layer::has_color).unwrap_or(0);
    let mut reports = Vec::new();
    for batch in batches(&common) {
        let layers = &common.layers[batch.clone()];
        let channels = |side: usize| layers.iter().flat_map(move |layer| layer.channels(side));
        let references = reference.read(&channels(0).collect::<Vec<_>>())?;
        let images = image.read(&channels(1).collect::<Vec<_>>())?;
        let (mut rest_of_references, mut rest_of_images) =
            (references.into_iter(), images.into_iter());
        for (index, layer) in batch.zip(layers) {
            let take = |rest: &mut std::vec::IntoIter<Vec<f32>>| -> Vec<Vec<f32>> {
                rest.take(layer.count()).collect()
            };
            let planes = [take(&mut rest_of_references), take(&mut rest_of_images)];
            let wants_picture = index == shown && arguments.output.iter().any(|path| is_png(path));
            let (report, errors) = compared(arguments, layer, &planes, wants_picture)?;
            reports.push(report);
            if let Some(errors) = errors {
                picture = Some((layer.window, errors));
            }
            if wants_exr {
                let [references, images] = planes;
                let absolute = references.into_iter().zip(images).map(absolute);
                differences.extend(layer.names().map(str::to_owned).zip(absolute));
            }
        }
    }

    let beyond = arguments.limits.beyond(&reports)?;
    for path in &arguments.output {
        if is_png(path) {
            if let Some((window, errors)) = &picture {
                picture::write(path, *window, errors, unfinished)?;
            }
        } else {
            let window = one_window(&common)?;
            let planes: Vec<(&str, &[f32])> = differences
                .iter()
                .map(|(name, plane)| (name.as_str(), plane.as_slice()))
                .collect();
            write_planes(path, window, &planes, unfinished)?;
        }
    }
    let report = Report {
        reference: &names[0],
        image: &names[1],
        tolerance: arguments.tolerance,
        layers: &reports,
        left_out: &common.left_out,
        beyond: &beyond,
    };
    if arguments.json {
        report.write_json(output)?;
    } else {
        report.write_text(&arguments.output, output)?;
    }
    output.flush()?;
    match beyond.first() {
        None => Ok(()),
        Some(first) => {
            let more = match beyond.len() - 1 {
                0 => String::new(),
                more => format!(", and {more} more"),
            };
            Err(Beyond(format!("{} {first}{more}", names[1])).into())
        }
    }
}

impl Arguments {
    /// Whether the files that are written are others than those that are read.
    fn check_paths(&self) -> Result<(), Failure> {
        let inputs = [self.reference.as_path(), self.image.as_path()];
        if inputs.iter().all(|path| is_standard_input(path)) {
            return Err(
                "both images would come from standard input; give one of them as a file".into(),
            );
        }
        let outputs: Vec<&Path> = self.output.iter().map(PathBuf::as_path).collect();
        super::refuse_same_files(&inputs, &outputs)?;
        for path in outputs {
            output::check(path)?;
        }
        Ok(())
    }
}

/// The metrics of a layer; and its relative errors, if they are wanted for a picture.
fn compared(
    arguments: &Arguments,
    layer: &Layer,
    planes: &[Vec<Vec<f32>>; 2],
    wants_errors: bool,
) -> Result<(LayerReport, Option<Vec<f32>>), Failure> {
    let [reference, image] =
        [0, 1].map(|side| planes[side].iter().map(Vec::as_slice).collect::<Vec<_>>());
    let width = layer.window.size[0] as usize;
    let pair = Pair {
        width,
        reference: &reference,
        image: &image,
        relative: layer.relative(),
    };
    let metrics = Metrics::new(&pair, arguments.tolerance)?;
    let errors = if wants_errors {
        Some(compare::relative_errors(&pair)?)
    } else {
        None
    };
    let flips = match &layer.color {
        None => None,
        // Nothing flips, at any exposure.
        Some(_) if metrics.max_error == 0.0 => Some((0.0, Some(0.0))),
        Some(primaries) => {
            let pixels =
                |planes: &[&[f32]]| compare::rec709([planes[0], planes[1], planes[2]], primaries);
            let (reference, image) = (pixels(&reference)?, pixels(&image)?);
            let ldr = compare::ldr_flip(width, &reference, &image)?;
            let hdr = compare::hdr_flip(width, &reference, &image)?;
            Some((mean(&ldr), hdr.as_deref().map(mean)))
        }
    };
    Ok((LayerReport::new(layer, metrics, flips), errors))
}

/// Layers that are read together: a file is decoded once for each of these ranges.
fn batches(common: &Common) -> Vec<std::ops::Range<usize>> {
    let mut batches: Vec<std::ops::Range<usize>> = Vec::new();
    let mut samples = 0;
    for (index, layer) in common.layers.iter().enumerate() {
        let more = 2 * layer.window.count() * layer.count() as u64;
        match batches.last_mut() {
            Some(batch) if samples + more <= TOGETHER => {
                batch.end = index + 1;
                samples += more;
            }
            Some(_) | None => {
                batches.push(index..index + 1);
                samples = more;
            }
        }
    }
    batches
}

/// |B − A| in f32, in the memory of A.
fn absolute((mut reference, image): (Vec<f32>, Vec<f32>)) -> Vec<f32> {
    for (r, i) in reference.iter_mut().zip(image) {
        let is_same = *r == i || (r.is_nan() && i.is_nan());
        *r = if is_same {
            0.0
        } else {
            (f64::from(i) - f64::from(*r)).abs() as f32
        };
    }
    reference
}

/// The data window of all layers, if it is one.
fn one_window(common: &Common) -> Result<DataWindow, Failure> {
    let mut windows = common.layers.iter().map(|layer| layer.window);
    let first = windows.next().ok_or("there is no layer to compare")?;
    if windows.all(|window| window == first) {
        return Ok(first);
    }
    Err(
        "the parts of the files have different data windows, which one part cannot hold; choose \
         layers of one window with --layers"
            .into(),
    )
}

fn is_png(path: &Path) -> bool {
    path.extension()
        .is_some_and(|extension| extension.eq_ignore_ascii_case("png"))
}

/// A file to write: what it holds goes by its extension.
fn difference_path() -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().try_map(|path| {
        let path = PathBuf::from(path);
        super::advice::no_frames(&path)?;
        let extension = path.extension().map(std::ffi::OsStr::to_ascii_lowercase);
        match extension {
            Some(extension) if extension == "exr" || extension == "png" => Ok(path),
            Some(_) | None => Err(format!(
                "expected DIFF.exr, the absolute error of each channel, or DIFF.png, the relative \
                 error in false colors, not {}",
                printable_path(&path)
            )),
        }
    })
}

/// How a message names an input.
fn named(path: &Path) -> String {
    if is_standard_input(path) {
        "standard input".to_owned()
    } else {
        printable_path(path)
    }
}
