//! A scene file rendered to memory: pixels to compute with, no file written.
//!
//! ```console
//! $ cargo run --release --example render_to_memory -- SCENE.toml
//! ```
//!
//! says how large the picture is, how much of it is covered, and how bright it is.

use std::error::Error;
use std::path::Path;

use candela::world::Loaded;
use candela::{Options, World, render};

/// What the picture comes to.
#[derive(Debug)]
pub(crate) struct Summary {
    /// Width and height in pixels.
    pub(crate) resolution: [u32; 2],
    /// The share of the picture that objects cover.
    pub(crate) coverage: f64,
    /// The mean radiance in cd/m², of R, G and B.
    pub(crate) mean: [f64; 3],
    /// The brightest pixel, column and row, and its radiance.
    pub(crate) brightest: ([u32; 2], [f32; 3]),
}

fn main() -> Result<(), Box<dyn Error>> {
    let scene = std::env::args_os().nth(1);
    let scene = scene.unwrap_or_else(|| "scenes/lecture.toml".into());
    let Summary {
        resolution: [width, height],
        coverage,
        mean,
        brightest: ([x, y], radiance),
    } = summarize(Path::new(&scene), 4)?;
    println!(
        "{width} × {height} pixels, {:.1} % covered",
        100.0 * coverage
    );
    println!("mean radiance {mean:.4?} cd/m²");
    println!("the brightest pixel is {x},{y} with {radiance:.3?} cd/m²");
    Ok(())
}

/// Renders a scene file with so many samples a pixel, and looks at every pixel.
pub(crate) fn summarize(scene: &Path, samples: u32) -> Result<Summary, Box<dyn Error>> {
    let Loaded { world, camera, .. } = World::load(scene)?;
    let options = Options {
        samples,
        ..Options::default()
    };
    let film = render(&world, &camera, &options)?;
    let [width, _] = film.resolution();

    // Row by row from the top left: R, G, B in cd/m², and the share of the pixel that is covered.
    let pixels = film.pixels();
    let count = pixels.len() as f64;
    let coverage = pixels.iter().map(|[.., a]| f64::from(*a)).sum::<f64>() / count;
    let mean = [0, 1, 2].map(|c| pixels.iter().map(|rgba| f64::from(rgba[c])).sum::<f64>() / count);
    let sum = |[r, g, b, _]: &[f32; 4]| r + g + b;
    let brightest = pixels.iter().enumerate();
    let brightest = brightest.max_by(|(_, a), (_, b)| sum(a).total_cmp(&sum(b)));
    let (index, &[r, g, b, _]) = brightest.ok_or("the picture has no pixels")?;
    Ok(Summary {
        resolution: film.resolution(),
        coverage,
        mean,
        brightest: ([index as u32 % width, index as u32 / width], [r, g, b]),
    })
}
