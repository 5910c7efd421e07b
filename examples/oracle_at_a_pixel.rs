//! The renderer beside the oracle, which computes the same equation by other code in plain f64.
//!
//! ```console
//! $ cargo run --release --example oracle_at_a_pixel -- SCENE.toml X Y
//! ```
//!
//! prints what both make of the center of one pixel.

use std::error::Error;
use std::path::Path;

use candela::image::Window;
use candela::oracle::{Oracle, Sample};
use candela::world::Loaded;
use candela::{Options, World, render};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let scene = arguments
        .next()
        .unwrap_or_else(|| "scenes/lecture.toml".into());
    let mut coordinate = |default: u32| -> Result<u32, Box<dyn Error>> {
        match arguments.next() {
            Some(text) => Ok(text.to_string_lossy().parse()?),
            None => Ok(default),
        }
    };
    let pixel = [coordinate(640)?, coordinate(360)?];
    let (oracle, renderer) = both(Path::new(&scene), pixel)?;
    println!("oracle   {:?}", oracle.radiance);
    println!("renderer {renderer:?}");
    Ok(())
}

/// The radiance at the center of a pixel in cd/m², by the oracle and by the renderer.
pub(crate) fn both(scene: &Path, [x, y]: [u32; 2]) -> Result<(Sample, [f32; 3]), Box<dyn Error>> {
    // The oracle reads the scene as it was written, the renderer what was made of it.
    let Loaded {
        scene,
        world,
        camera,
        ..
    } = World::load(scene)?;
    let [width, height] = camera.resolution();
    if x >= width || y >= height {
        return Err(format!("the picture has {width} × {height} pixels").into());
    }
    let oracle = Oracle::new(&scene).radiance(f64::from(x) + 0.5, f64::from(y) + 0.5);

    let pixel = Window {
        x,
        y,
        width: 1,
        height: 1,
    };
    let options = Options {
        samples: 1, // the center of the pixel, and nothing else
        window: Some(pixel),
        ..Options::default()
    };
    let [r, g, b, _] = render(&world, &camera, &options)?.pixels()[0];
    Ok((oracle, [r, g, b]))
}
