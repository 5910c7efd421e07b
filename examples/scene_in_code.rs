//! A scene made in code, without a file: spheres on a floor, a mesh of numbers, three lamps.
//!
//! ```console
//! $ cargo run --release --example scene_in_code -- FOLDER
//! ```
//!
//! writes `steps.exr` in cd/m² and a picture of it, `steps.png`, to FOLDER (here, if it is left out).

use std::error::Error;
use std::path::{Path, PathBuf};

use candela::display::{self, Exposure, Settings, View};
use candela::exr::ExrOptions;
use candela::output::Unfinished;
use candela::scene::{Camera, Image, Light, Material, MeshFile, Object, Placement, Scene, Value};
use candela::{Options, World, render};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os().nth(1).unwrap_or_else(|| ".".into());
    let picture = run(Path::new(&folder), 720)?;
    println!("{}", picture.display());
    Ok(())
}

/// Renders the scene, `height` pixels high, and returns where its picture is.
pub(crate) fn run(folder: &Path, height: u32) -> Result<PathBuf, Box<dyn Error>> {
    let mut scene = Scene::new(
        Image::new(height * 16 / 9, height).background([0.05, 0.06, 0.08]),
        Camera::perspective([0.0, 3.0, 9.0], [0.0, 0.6, 0.0], 26.0),
    )
    .material("floor", Material::normalized_phong(0.25))
    .material(
        "stone",
        Material::normalized_phong("#8f8a80".parse::<Value>()?),
    )
    .light("key", Light::point([5.0, 8.0, 6.0], [300.0, 270.0, 225.0]))
    .light(
        "fill",
        Light::point([-7.0, 5.0, 5.0], Value::lumens(1200.0, [0.5, 0.7, 1.0])),
    )
    .light("back", Light::point([1.0, 6.0, -8.0], 80.0))
    .object("floor", Object::plane("floor", [0.0; 3], [0.0, 1.0, 0.0]));

    // Five spheres, each with a sharper highlight.
    for step in 0..5 {
        let name = format!("gloss {step}");
        let shininess = 4.0_f64.powi(step + 1);
        let material = Material::normalized_phong([0.45, 0.1, 0.08]).specular(0.3, shininess);
        let center = [f64::from(step) * 1.1 - 2.2, 0.5, 0.6];
        scene = scene
            .material(name.as_str(), material)
            .object(name.as_str(), Object::sphere(name.as_str(), center, 0.5));
    }
    let placement = Placement {
        scale: [3.2, 1.4, 1.2],
        translate: [0.0, 0.0, -2.4],
        ..Placement::default()
    };
    scene = scene.object("stairs", Object::mesh("stone", stairs(5), placement));

    // Whatever is out of range, or a name that is not there, is found here.
    let (world, camera) = World::new(&scene)?;
    let options = Options {
        samples: 16,
        ..Options::default()
    };
    let film = render(&world, &camera, &options)?;

    let exr = folder.join("steps.exr");
    let png = folder.join("steps.png");
    film.write_exr(&exr, &ExrOptions::default(), &Unfinished::new())?;
    let settings = Settings {
        exposure: Exposure::Ev(2.0),
        view: View::Reinhard,
        ..Settings::default()
    };
    display::convert(&exr, &png, &settings, &Unfinished::new())?;
    Ok(png)
}

/// Stairs that rise from the middle of each side: 2 wide, 1 high and 1 deep.
fn stairs(steps: u32) -> MeshFile {
    let mut mesh = MeshFile::default();
    for step in 0..steps {
        let share = f64::from(step) / f64::from(steps);
        let (half_width, depth) = (1.0 - share, 1.0 - share);
        let (low, high) = (share, share + 1.0 / f64::from(steps));
        let first = mesh.positions.len() as u32;
        for (y, z) in [(low, depth), (high, depth), (high, 0.0), (low, 0.0)] {
            mesh.positions.push([-half_width, y, z]);
            mesh.positions.push([half_width, y, z]);
        }
        // The front, the top and the two sides; corners are counter-clockwise seen from outside.
        for [a, b, c, d] in [[0, 1, 3, 2], [2, 3, 5, 4], [1, 7, 5, 3], [0, 2, 4, 6]] {
            let corner = |index: u32| first + index;
            mesh.triangles.push([a, b, c].map(corner));
            mesh.triangles.push([a, c, d].map(corner));
        }
    }
    mesh
}
