//! `candela probe`: the lecture's equation at one pixel, term by term, light by light.

mod range;
mod table;

use std::io::{self, Write};

use candela::oracle::{Explanation, Oracle};
use candela::render::RenderError;
use candela::scene::{Scene, Transport};
use candela::spectrum;
use serde::Serialize;

use super::source::SceneArguments;
use range::Range;
use table::table;

/// Explain one pixel: every term of the equation, light by light, with its numbers
///
/// Computes the pixel's center in f64, straight from the equations L1 to L9, by other code than the
/// renderer's, and says how far the renderer is from that.
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
      The pixel at the top left, as JSON")]
pub(crate) struct Arguments {
    #[command(flatten)]
    pub(super) scene: SceneArguments,

    /// The pixel's column and row; 0,0 is at the top left
    #[arg(long, value_name = "X,Y", value_parser = pixel, allow_hyphen_values = true)]
    pixel: [u32; 2],

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
        "pixel {},{} is outside of the image, which has {} × {} pixels: \
         X is 0 to {}, Y is 0 to {}",
        pixel[0], pixel[1], resolution[0], resolution[1],
        resolution[0].saturating_sub(1), resolution[1].saturating_sub(1)
    )]
    Outside {
        pixel: [u32; 2],
        resolution: [u32; 2],
    },
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
    /// Column and row.
    pixel: [u32; 2],
    /// The equations, in f64 at the pixel's center.
    #[serde(flatten)]
    explanation: Explanation,
    /// The radiance wavelength by wavelength, where that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    spectrum: Option<SpectralRadiance>,
    /// What the renderer makes of the same point.
    renderer: Rendered,
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

/// Explains one pixel of a legal scene. `renderer` gives the radiance that the renderer finds at
/// the center of a pixel; it is asked only if the image has that pixel.
///
/// # Errors
/// [`ProbeError::Outside`] for a pixel that the image does not have, [`ProbeError::NoSpectrum`] where
/// one is asked for and light is carried as RGB, [`ProbeError::Render`] where `renderer` fails,
/// [`ProbeError::Output`] where `output` cannot be
/// written.
pub(crate) fn run(
    arguments: &Arguments,
    scene: &Scene,
    renderer: impl FnOnce([u32; 2]) -> Result<[f32; 3], RenderError>,
    output: &mut impl Write,
) -> Result<(), ProbeError> {
    let (pixel, resolution) = (arguments.pixel, scene.image.resolution.value);
    if pixel[0] >= resolution[0] || pixel[1] >= resolution[1] {
        return Err(ProbeError::Outside { pixel, resolution });
    }
    let [px, py] = pixel.map(|coordinate| f64::from(coordinate) + 0.5);
    let oracle = Oracle::new(scene);
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
    let radiance = renderer(pixel)?;
    let difference = std::array::from_fn(|i| f64::from(radiance[i]) - explanation.radiance[i]);
    let report = Report {
        pixel,
        explanation,
        spectrum,
        renderer: Rendered {
            radiance,
            difference,
        },
    };
    if arguments.json {
        serde_json::to_writer_pretty(&mut *output, &report).map_err(io::Error::from)?;
        writeln!(output)?;
    } else {
        output.write_all(table(&report, resolution).as_bytes())?;
    }
    Ok(output.flush()?)
}

/// Reads `X,Y`.
fn pixel(text: &str) -> Result<[u32; 2], String> {
    let number = |part: &str| part.trim().parse().ok();
    text.split_once(',')
        .and_then(|(x, y)| Some([number(x)?, number(y)?]))
        .ok_or_else(|| "expected column and row, two whole numbers such as 640,360".to_owned())
}

#[cfg(test)]
mod tests;
