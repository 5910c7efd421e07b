//! `candela probe`: the lecture's equation at one pixel, term by term, light by light.

mod table;

use std::io::{self, Write};
use std::path::PathBuf;

use candela::oracle::{Explanation, Oracle};
use candela::scene::Scene;
use serde::Serialize;

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
  candela probe scene.toml --pixel 0,0 --json
      The pixel at the top left, as JSON")]
pub(crate) struct Arguments {
    /// The scene file
    #[arg(value_name = "SCENE.toml")]
    pub(crate) scene: PathBuf,

    /// The pixel's column and row; 0,0 is at the top left
    #[arg(long, value_name = "X,Y", value_parser = pixel, allow_hyphen_values = true)]
    pixel: [u32; 2],

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
    /// The output cannot be written.
    #[error("cannot write the explanation: {0}")]
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
    /// What the renderer makes of the same point.
    renderer: Rendered,
}

/// The renderer's value beside the equations'.
#[derive(Debug, Serialize)]
struct Rendered {
    /// Radiance in cd/m² as it stands in the film.
    radiance: [f32; 3],
    /// `radiance` minus that of the equations.
    difference: [f64; 3],
}

/// Explains one pixel of a legal scene. `renderer` gives the radiance that the renderer finds at
/// the center of a pixel; it is asked only if the image has that pixel.
///
/// # Errors
/// [`ProbeError::Outside`] for a pixel that the image does not have, [`ProbeError::Output`] where
/// `output` cannot be written.
pub(crate) fn run(
    arguments: &Arguments,
    scene: &Scene,
    renderer: impl FnOnce([u32; 2]) -> [f32; 3],
    output: &mut impl Write,
) -> Result<(), ProbeError> {
    let (pixel, resolution) = (arguments.pixel, scene.image.resolution.value);
    if pixel[0] >= resolution[0] || pixel[1] >= resolution[1] {
        return Err(ProbeError::Outside { pixel, resolution });
    }
    let [px, py] = pixel.map(|coordinate| f64::from(coordinate) + 0.5);
    let explanation = Oracle::new(scene).explain(px, py);
    let radiance = renderer(pixel);
    let difference = std::array::from_fn(|i| f64::from(radiance[i]) - explanation.radiance[i]);
    let report = Report {
        pixel,
        explanation,
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
