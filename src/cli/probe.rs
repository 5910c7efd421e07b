//! `candela probe`: the lecture's equation at one pixel, term by term, light by light.

mod point;
mod range;
mod table;
mod ways;

use std::io::{self, Write};

use candela::oracle::{Explanation, Oracle};
use candela::render::RenderError;
use candela::scene::{Scene, Transport};
use candela::spectrum;
use rayon::prelude::*;
use serde::Serialize;

use super::Failure;
use super::crop::{Crop, crop};
use super::source::{FrameArguments, SceneArguments};
use point::Point;
use range::Range;
use table::{line, table};

/// Pixels of a region that are computed before they are written.
const TOGETHER: usize = 1024;

/// Explain pixels: every term of the equation, light by light, with its numbers
///
/// Computes the pixel's center, or another point of the image, in f64, straight from the equations L1 to L9, by
/// other code than the renderer's, and says how far the renderer is from that at the center of a pixel.
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Examples:
  candela probe scene.toml --pixel 640,360
      The pixel in the middle of a 1280 × 720 image, as a table
  candela probe scene.toml --pixel 640,360 --spectrum
      The same, with the radiance at every tenth nm from 380 to 780
  candela probe scene.toml --pixel 640,360 --spectrum=580:600:1
      The same, around the lines of sodium
  candela probe scene.toml --pixel 0,0 --json
      The pixel at the top left, as JSON
  candela probe scene.toml --pixel 640,360 --pixel 641.25,360.5
      Two points: the middle of a pixel, and one left of the middle of the next
  candela probe scene.toml --region 630,350,650,370
      All pixels of a part, a line each")]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,

    #[command(flatten)]
    pub(super) frame: FrameArguments,

    /// The pixel's column and row, 0,0 at the top left; may be said several times
    ///
    /// A whole number is the middle of its column or row; one with decimals is a place, in pixels from the
    /// left or upper edge of the image: 3 and 3.5 are the same, 3.0 is the left edge of column 3.
    #[arg(
        long,
        value_name = "X,Y",
        value_parser = point::point,
        allow_hyphen_values = true,
        required_unless_present = "region"
    )]
    pixel: Vec<Point>,

    /// The centers of all pixels of a part, from column X0 and row Y0 up to X1 and Y1, which are
    /// outside: a line each, or a JSON array
    #[arg(
        long,
        value_name = "X0,Y0,X1,Y1",
        value_parser = crop,
        allow_hyphen_values = true,
        conflicts_with_all = ["pixel", "spectrum"]
    )]
    region: Option<Crop>,

    /// Add the radiance wavelength by wavelength, from START to END nm, every STEP nm; a scene of
    /// RGB values alone is computed spectrally for that, unless it says `transport = "rgb"`
    #[arg(
        long,
        value_name = "START:END:STEP",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = Range::DEFAULT,
    )]
    spectrum: Option<Range>,

    /// Write JSON, with all digits
    #[arg(long)]
    json: bool,
}

/// Why a pixel cannot be explained.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ProbeError {
    /// Not a pixel of this image.
    #[error(
        "pixel {point} is outside of the image, which has {} × {} pixels: \
         X is 0 to {}, Y is 0 to {}",
        resolution[0], resolution[1],
        resolution[0].saturating_sub(1), resolution[1].saturating_sub(1)
    )]
    Outside { point: Point, resolution: [u32; 2] },
    /// A spectrum was asked for where light has none.
    #[error(
        "there is no spectrum, because the scene says `transport = \"rgb\"`; leave that line out, \
         or probe without --spectrum"
    )]
    NoSpectrum,
    /// The pixel cannot be rendered.
    #[error("{0}")]
    Render(#[from] RenderError),
    /// The output cannot be written.
    #[error("{0}")]
    Output(#[from] io::Error),
}

/// One explained pixel, as `--json` writes it.
#[derive(Debug, Serialize)]
struct Report {
    /// Column and row of the pixel that the point is in.
    pixel: [u32; 2],
    /// The point in pixels, from the top left corner of the image.
    point: [f64; 2],
    /// The equations, in f64 at the point.
    #[serde(flatten)]
    explanation: Explanation,
    /// The radiance wavelength by wavelength, where that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    spectrum: Option<SpectralRadiance>,
    /// What the renderer makes of the same point; `None` beside the center of a pixel.
    renderer: Option<Rendered>,
}

/// L9 wavelength by wavelength.
#[derive(Debug, Serialize)]
struct SpectralRadiance {
    /// In nm.
    wavelengths: Vec<u32>,
    /// L_o(λ) at each.
    radiance: Vec<f64>,
    unit: &'static str,
}

/// The renderer's value beside the equations'.
#[derive(Debug, Serialize)]
struct Rendered {
    /// Radiance in cd/m² as it stands in the film.
    radiance: [f32; 3],
    /// `radiance` minus that of the equations.
    difference: [f64; 3],
}

/// Makes a scene that leaves it open be computed spectrally, if a spectrum is asked for.
pub(crate) fn prepare(arguments: &Arguments, scene: &mut Scene) {
    let transport = &mut scene.image.transport.value;
    if arguments.spectrum.is_some() && *transport == Transport::Auto {
        *transport = Transport::Spectral;
    }
}

/// Explains points of a legal scene. `renderer` gives the radiance that the renderer finds at
/// the center of a pixel; it is asked only for pixels that the image has.
///
/// # Errors
/// [`ProbeError::Outside`] for a point that the image does not have, [`ProbeError::NoSpectrum`] where
/// one is asked for and light is carried as RGB, [`ProbeError::Render`] where `renderer` fails,
/// [`ProbeError::Output`] where `output` cannot be written; a region that is not inside of the image.
pub(crate) fn run(
    arguments: &Arguments,
    scene: &Scene,
    renderer: impl Fn([u32; 2]) -> Result<[f32; 3], RenderError> + Sync,
    output: &mut impl Write,
) -> Result<(), Failure> {
    let resolution = scene.image.resolution.value;
    let region = arguments
        .region
        .map(|region| region.within("--region", resolution));
    let region = region.transpose()?;
    if let Some(&point) = arguments
        .pixel
        .iter()
        .find(|point| !point.is_in(resolution))
    {
        return Err(ProbeError::Outside { point, resolution }.into());
    }
    let oracle = Oracle::new(scene);
    let report = |&point: &Point| report(arguments, &oracle, &renderer, point);
    let Some(region) = region else {
        let reports = arguments.pixel.iter().map(report);
        let reports: Vec<Report> = reports.collect::<Result<_, _>>()?;
        match (&reports[..], arguments.json) {
            // As ever.
            ([report], true) => write_json(report, output)?,
            (reports, true) => write_json(reports, output)?,
            (reports, false) => {
                for (index, report) in reports.iter().enumerate() {
                    if index > 0 {
                        writeln!(output).map_err(ProbeError::from)?;
                    }
                    let table = table(report, resolution);
                    output
                        .write_all(table.as_bytes())
                        .map_err(ProbeError::from)?;
                }
            }
        }
        return Ok(output.flush().map_err(ProbeError::from)?);
    };
    // What is printed of a large region is never in memory as a whole.
    let mut pixels = region.pixels().map(Point::center).peekable();
    let mut start = if arguments.json { "[\n" } else { "" };
    while pixels.peek().is_some() {
        let together: Vec<Point> = pixels.by_ref().take(TOGETHER).collect();
        let reports = together.par_iter().map(report);
        let reports: Vec<Report> = reports.collect::<Result<_, _>>()?;
        for report in &reports {
            let line = if arguments.json {
                serde_json::to_string(report).map_err(io::Error::from)
            } else {
                Ok(line(report))
            };
            let line = line.map_err(ProbeError::from)?;
            write!(output, "{start}{line}").map_err(ProbeError::from)?;
            start = if arguments.json { ",\n" } else { "\n" };
        }
    }
    let end = if arguments.json { "\n]" } else { "" };
    writeln!(output, "{end}").map_err(ProbeError::from)?;
    Ok(output.flush().map_err(ProbeError::from)?)
}

/// JSON with line breaks, as people read it.
fn write_json(
    report: &(impl Serialize + ?Sized),
    output: &mut impl Write,
) -> Result<(), ProbeError> {
    serde_json::to_writer_pretty(&mut *output, report).map_err(io::Error::from)?;
    Ok(writeln!(output)?)
}

/// All that is said of a point.
fn report(
    arguments: &Arguments,
    oracle: &Oracle,
    renderer: &impl Fn([u32; 2]) -> Result<[f32; 3], RenderError>,
    point: Point,
) -> Result<Report, ProbeError> {
    let [px, py] = point.position();
    let spectrum = match arguments.spectrum {
        None => None,
        Some(range) => {
            let radiance = oracle.spectral_radiance(px, py);
            let radiance = radiance.ok_or(ProbeError::NoSpectrum)?;
            let place = |nm: u32| (nm - spectrum::FIRST) as usize;
            Some(SpectralRadiance {
                wavelengths: range.wavelengths().collect(),
                radiance: range.wavelengths().map(|nm| radiance[place(nm)]).collect(),
                unit: "W.m^-2.sr^-1.nm^-1",
            })
        }
    };
    let explanation = oracle.explain(px, py);
    let rendered = if point.is_center() {
        let radiance = renderer(point.pixel())?;
        let difference = std::array::from_fn(|i| f64::from(radiance[i]) - explanation.radiance[i]);
        Some(Rendered {
            radiance,
            difference,
        })
    } else {
        None
    };
    Ok(Report {
        pixel: point.pixel(),
        point: point.position(),
        explanation,
        spectrum,
        renderer: rendered,
    })
}

#[cfg(test)]
mod tests;
