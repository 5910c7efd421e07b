//! `candela verify`: the renderer against the oracle, on the user's own scene.

mod edge;
mod pixels;
mod report;

use std::io::Write;
use std::path::{Path, PathBuf};

use candela::exr::ExrOptions;
use candela::image::{Film, Window};
use candela::oracle::{Oracle, Sample};
use candela::output::{self, Unfinished};
use candela::render::{Job, Options};
use candela::scene::Scene;
use candela::world::Loaded;
use candela::{Renderer, image};
use rayon::prelude::*;

use super::Failure;
use super::failure::Beyond;
use super::source::{FrameArguments, SceneArguments};
use edge::Edges;
use report::{Flip, Histogram, Report};

/// Below this part of the median radiance of what is lit, errors are relative to that instead of the pixel.
const FLOOR: f64 = 1e-6;

/// The part of the light without shadow by which what is seen of a light with an area may be off, where something hides
/// a part: what the renderer promises (docs/scene-format.md).
const OF_UNSHADOWED: f64 = 1e-6;

/// One pixel in so many may be on the other side of an edge, where nothing else is asked for.
const ONE_FLIP_IN: u64 = 500_000;

/// The most pixels of `--pixels`; more are `--all`.
const MOST: u64 = 10_000_000;

/// Check the renderer on a scene: each pixel against the equations, computed by other code
///
/// Renders the scene with one sample a pixel, its center, and computes the same pixels by the oracle: in f64, by brute
/// force, straight from the equations L1 to L9, by code that shares nothing with the renderer. Says how far both
/// are apart; of each pixel that is off, which edge it lies on. In the penumbra of lights with an area what the oracle
/// may itself be off by, as it states, counts for the renderer, and so does a millionth of the light without shadow.
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Examples:
  candela verify scene.toml
      1000 pixels, always the same ones
  candela verify scene.toml --pixels 20000 --seed 7
      More of them, and others
  candela verify scene.toml --all --oracle oracle.exr
      All of them, with the oracle's picture

Exit codes:
  0   every pixel agrees, but for as many flips at edges as are allowed
  1   the scene is not legal, or a file cannot be written
  3   a pixel is off")]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,

    #[command(flatten)]
    pub(super) frame: FrameArguments,

    /// How many pixels to compare, pseudo-random ones
    #[arg(
        long,
        value_name = "N",
        default_value = "1000",
        value_parser = clap::value_parser!(u64).range(1..=MOST),
        conflicts_with = "all"
    )]
    pixels: u64,

    /// Compare all pixels
    #[arg(long)]
    all: bool,

    /// Which pixels: each seed has others, the same on every machine
    #[arg(long, value_name = "S", default_value = "0", conflicts_with = "all")]
    seed: u64,

    /// The relative error up to which a pixel agrees
    #[arg(long, value_name = "X", default_value = "1e-5", value_parser = super::diff::limit)]
    tolerance: f64,

    /// How many pixels may be on the other side of an edge [default: 1 for each 500 000, rounded up]
    #[arg(long, value_name = "N")]
    max_flips: Option<u64>,

    /// Write the oracle's picture, FLOAT, of all pixels
    #[arg(long, value_name = "OUT.exr", value_parser = super::render::named("exr"), requires = "all")]
    oracle: Option<PathBuf>,

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
    let Loaded {
        scene,
        world,
        camera,
        ..
    } = arguments.scene.load(arguments.frame.number(), |_| {})?;
    if let Some(path) = &arguments.oracle {
        let inputs = scene.files();
        let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
        super::refuse_same_files(&inputs, &[path])?;
        super::refuse_terminal(path)?;
        output::check(path)?;
    }
    // What is estimated from points of lights is no equation's.
    let options = Options {
        cuts_areas: true,
        ..Options::default()
    };
    let (film, _) = Renderer::new(&world)?.film(&camera, &options, &Job::new())?;
    let oracle = Oracle::new(&scene);

    let pixels = pixels::chosen(film.resolution(), arguments.count(), arguments.seed)?;
    let mut samples: Vec<Sample> = Vec::new();
    samples.try_reserve_exact(pixels.len())?;
    let center = |[x, y]: [u32; 2]| oracle.radiance(f64::from(x) + 0.5, f64::from(y) + 0.5);
    samples.par_extend(pixels.par_iter().map(|&pixel| center(pixel)));

    let report = compared(arguments, &scene, &oracle, &film, &pixels, &samples)?;
    if let Some(path) = &arguments.oracle {
        picture(&film, &samples)?.write_exr(path, &ExrOptions::default(), unfinished)?;
    }
    if arguments.json {
        report.write_json(output)?;
    } else {
        report.write_text(arguments.oracle.as_deref(), output)?;
    }
    output.flush()?;
    match report.objection() {
        None => Ok(()),
        Some(objection) => Err(Beyond(objection).into()),
    }
}

impl Arguments {
    /// How many pixels are compared, if not all.
    fn count(&self) -> Option<u64> {
        (!self.all).then_some(self.pixels)
    }
}

/// Holds each pixel against the oracle's.
fn compared(
    arguments: &Arguments,
    scene: &Scene,
    oracle: &Oracle,
    film: &Film,
    pixels: &[[u32; 2]],
    samples: &[Sample],
) -> Result<Report, Failure> {
    let floor = FLOOR * median_lit(samples)?;
    let resolution = film.resolution();
    let rendered =
        |[x, y]: [u32; 2]| film.pixels()[y as usize * resolution[0] as usize + x as usize];
    let mut errors: Vec<f64> = Vec::new();
    errors.try_reserve_exact(pixels.len())?;
    let both = pixels.par_iter().zip(samples);
    errors.par_extend(both.map(|(&pixel, sample)| error(rendered(pixel), sample, floor)));

    let mut histogram = Histogram::default();
    let (mut largest, mut largest_at) = (0.0, None);
    let mut off = Vec::new();
    for (index, &error) in errors.iter().enumerate() {
        histogram.add(error);
        if error > arguments.tolerance {
            off.push(index);
        } else if error > largest {
            (largest, largest_at) = (error, Some(pixels[index]));
        }
    }
    let edges = Edges::new(scene, oracle, floor);
    let flips = off.par_iter().map(|&index| {
        let pixel = pixels[index];
        let [r, g, b, a] = rendered(pixel);
        Flip {
            pixel,
            error: errors[index],
            renderer: [r, g, b],
            oracle: samples[index].radiance,
            edge: edges.of(pixel, [r, g, b, a]),
        }
    });
    let count = pixels.len() as u64;
    Ok(Report {
        scene: arguments.scene.name().to_string_lossy().into_owned(),
        pixels: count,
        of: Window::whole(resolution).count(),
        seed: arguments.seed,
        tolerance: arguments.tolerance,
        max_flips: arguments.max_flips.unwrap_or(count.div_ceil(ONE_FLIP_IN)),
        histogram,
        largest,
        largest_at,
        flips: flips.collect(),
    })
}

/// The largest channel.
fn brightest(radiance: [f64; 3]) -> f64 {
    radiance.into_iter().map(f64::abs).fold(0.0, f64::max)
}

/// The median of all radiances above 0, or 1 where there is none.
fn median_lit(samples: &[Sample]) -> Result<f64, Failure> {
    let mut lit: Vec<f64> = Vec::new();
    lit.try_reserve_exact(samples.len())?;
    let radiances = samples.iter().map(|sample| brightest(sample.radiance));
    lit.extend(radiances.filter(|&radiance| radiance > 0.0));
    let middle = lit.len() / 2;
    if lit.is_empty() {
        return Ok(1.0);
    }
    Ok(*lit.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// The largest difference of R, G, B, beyond what both may be off by in a penumbra, over the largest of the oracle's;
/// infinite where one of both sees a surface and the other does not.
fn error(rendered: [f32; 4], expected: &Sample, floor: f64) -> f64 {
    if f64::from(rendered[3]) != expected.coverage {
        return f64::INFINITY;
    }
    let scale = brightest(expected.radiance).max(floor);
    let beyond = (0..3).map(|channel| {
        let difference = f64::from(rendered[channel]) - expected.radiance[channel];
        let of_renderer = OF_UNSHADOWED * expected.unshadowed[channel].abs();
        difference.abs() - expected.error[channel] - of_renderer
    });
    beyond.fold(0.0, f64::max) / scale
}

/// The oracle's picture, with all that the header says of the film but what made it.
fn picture(film: &Film, samples: &[Sample]) -> Result<Film, Failure> {
    let mut pixels: Vec<[f32; 4]> = Vec::new();
    pixels.try_reserve_exact(samples.len())?;
    pixels.extend(samples.iter().map(|sample| {
        let [r, g, b] = sample.radiance;
        [r, g, b, sample.coverage].map(|value| value as f32)
    }));
    let mut metadata: image::Metadata = film.metadata().clone();
    metadata.provenance.retain(|(key, _)| key != "plan");
    metadata
        .provenance
        .push(("oracle".to_owned(), "f64, brute force".to_owned()));
    metadata.provenance.sort();
    Ok(Film::new(
        film.resolution(),
        film.window(),
        pixels,
        metadata,
    ))
}
