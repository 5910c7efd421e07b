//! Legal scenes of many things: `docs/limits.md` says how many there may be.

use std::path::Path;
use std::process::Command;

use candela::exr::ExrOptions;
use candela::oracle::Oracle;
use candela::render::Layers;
use candela::scene::{Reading, Scene};
use candela::world::difference::differences;
use candela::world::physics::{self, Warning};
use candela::{Options, World, render};

use crate::allocation::peak;
use crate::fuzzing;
use crate::measured::Measured;

/// How many lights, materials and objects: with `CANDELA_FUZZ`, as many as `docs/limits.md` gives times
/// for.
fn many() -> usize {
    if std::env::var_os("CANDELA_FUZZ").is_some() {
        60_000
    } else {
        4000
    }
}

const HEAD: &str = "\
[image]
resolution = [2, 2]
[camera.orthographic]
eye = [0, 0, 5]
look_at = [0, 0, 0]
height = 3
";

fn material(number: usize) -> String {
    format!("[materials.material{number}.phong]\ndiffuse = [0.5, 0.25, 0.{number}]\n")
}

fn light(number: usize) -> String {
    format!("[lights.light{number}.point]\nposition = [{number}, 0, 9]\nintensity = 1\n")
}

fn sphere(number: usize, material: usize) -> String {
    format!(
        "[objects.object{number}.sphere]\nmaterial = \"material{material}\"\n\
         center = [{number}, 0, 0]\nradius = 0.4\n"
    )
}

fn repeated(count: usize, part: impl Fn(usize) -> String) -> String {
    (0..count).map(part).collect()
}

fn read(bytes: &[u8]) -> Result<World, candela::scene::Diagnostics> {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let scene = Reading::of_text(text, Path::new("tests/bad_scenes/many.toml")).complete()?;
    World::new(&scene).map(|(world, _)| world)
}

/// The limits of time and memory of all fuzzers hold: both are in proportion to the file's size.
#[test]
fn many_lights_materials_and_objects() {
    let many = many();
    let names = "x".repeat(190);
    let long = |number: usize| format!("[materials.{names}{number}.phong]\n");
    for (name, is_legal, text) in [
        (
            "lights, materials and objects",
            true,
            repeated(many, light) + &repeated(many, material) + &repeated(many, |n| sphere(n, n)),
        ),
        (
            "objects of the last material",
            true,
            repeated(many, material) + &repeated(many, |n| sphere(n, many - 1)),
        ),
        (
            "objects of no material",
            false,
            repeated(many, material) + &repeated(many, |n| sphere(n, many + n)),
        ),
        (
            "long names",
            true,
            repeated(many, long) + &material(0) + &sphere(0, 0),
        ),
        (
            "objects of one mesh",
            true,
            material(0)
                + &repeated(many, |n| {
                    format!(
                        "[objects.o{n}.mesh]\nmaterial = \"material0\"\nfile = \"triangle.obj\"\n"
                    )
                }),
        ),
        (
            "materials of one curve",
            true,
            material(0)
                + &sphere(0, 0)
                + &repeated(many, |n| {
                    format!("[materials.m{n}.phong]\ndiffuse = {{ file = \"curve.csv\" }}\n")
                }),
        ),
        (
            "triangles",
            true,
            material(0)
                + &repeated(many, |n| {
                    format!(
                        "[objects.o{n}.triangle]\nmaterial = \"material0\"\n\
                         vertices = [[0, 0, 0], [1, 0, 0], [0, 1, {n}]]\n"
                    )
                }),
        ),
    ] {
        let text = HEAD.to_owned() + &text;
        match fuzzing::check(text.as_bytes(), read) {
            Ok(is_accepted) => assert_eq!(is_accepted, is_legal, "`{name}`"),
            Err(broken) => panic!("`{name}` {broken}"),
        }
    }
}

/// A table of products has room for materials that objects have, and for no others: 4000 lights on
/// 4000 materials would be too many for one.
#[test]
fn unused_materials_take_nothing() {
    let text = HEAD.replace("[2, 2]", "[2, 2]\ntransport = \"spectral\"")
        + &repeated(4000, light)
        + &repeated(4000, material)
        + &sphere(0, 3999);
    let scene = Scene::parse(&text, "many.toml").unwrap();
    let (world, _) = World::new(&scene).unwrap();
    assert_eq!(world.used_materials(), [3999]);
    assert_eq!(world.products_memory(), Some(4000 * 56));
    // And the product is the one of that material.
    let alone = HEAD.replace("[2, 2]", "[2, 2]\ntransport = \"spectral\"")
        + &light(0)
        + &material(3999)
        + &sphere(0, 3999);
    let (alone, _) = World::new(&Scene::parse(&alone, "one.toml").unwrap()).unwrap();
    assert_eq!(world.reflected(0, 3999), alone.reflected(0, 0));
    assert_eq!(world.reflected(3999, 3999), alone.reflected(0, 0));
}

/// Pairs beyond what a table holds are made where they are needed: memory grows with lights and materials, not
/// with their product, which would be 2 GB here.
#[test]
fn spectral_pairs_have_no_limit() {
    let text = HEAD.replace("[2, 2]", "[3, 3]\ntransport = \"spectral\"")
        + &repeated(6000, light)
        + &repeated(6000, |n| {
            format!("[materials.material{n}.phong]\ndiffuse = [0.5, 0.4, 0.3]\n")
        })
        + &repeated(6000, |n| sphere(n, n));
    let scene = Scene::parse(&text, "many.toml").unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let (film, most) = pool.unwrap().install(|| {
        peak(|| {
            let (world, camera) = World::new(&scene).unwrap();
            assert_eq!(world.products_memory(), Some(0));
            render(&world, &camera, &Options::default()).unwrap()
        })
    });
    assert!(film.pixels().iter().any(|pixel| pixel[0] > 0.0));
    // The spectra of 6000 lights are 23 MB, and what a thread keeps of products is 7 MB.
    assert!(most < 60_000_000, "{most}");
}

/// Products that there is no room for are an error with the figure, and another machine may do.
#[cfg(target_os = "linux")]
#[test]
fn too_many_products_are_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let text = HEAD.replace("[2, 2]", "[2, 2]\ntransport = \"spectral\"")
        + &repeated(2000, light)
        + &repeated(2000, |n| {
            format!("[materials.material{n}.phong]\ndiffuse = 0.5\n")
        })
        + &repeated(2000, |n| sphere(n, n));
    std::fs::write(folder.path().join("many.toml"), text).unwrap();
    let limited = format!(
        "ulimit -v 150000; exec {} check many.toml",
        env!("CARGO_BIN_EXE_candela")
    );
    let mut shell = Command::new("sh");
    let shell = shell.args(["-c", &limited]).current_dir(folder.path());
    // One arena for all threads: where each has its own, it depends on their order whether it is the products
    // that find no room in so few addresses, or one of the small allocations after it.
    let shell = shell.env("MALLOC_ARENA_MAX", "1");
    let shell = shell.env("RAYON_NUM_THREADS", "2");
    let output = shell.env_remove("RUST_MIN_STACK").output().unwrap();
    assert_eq!(output.status.code(), Some(75));
    assert_eq!(
        String::from_utf8(output.stderr).unwrap(),
        "error: out of memory: the products of the spectra of 2000 lights and 2000 materials would \
         take 224.0 MB, more than there is; use fewer of them, or `transport = \"rgb\"` in `[image]`, \
         which takes none\n--> many.toml\n"
    );
}

/// In a picture of many lights on many materials, each pixel is what the oracle says.
#[test]
fn many_lights_on_many_materials_are_rendered() {
    let mut worst = Measured::rounding("many lights on many materials");
    let text = HEAD.to_owned()
        + &repeated(300, light)
        + &repeated(300, material)
        + &repeated(300, |n| sphere(n, n));
    let scene = Scene::parse(&text, "many.toml").unwrap();
    let (world, camera) = World::new(&scene).unwrap();
    let film = render(&world, &camera, &Options::default()).unwrap();
    let oracle = Oracle::new(&scene);
    for (place, pixel) in film.pixels().iter().enumerate() {
        let (x, y) = (place % 2, place / 2);
        let expected = oracle.radiance(x as f64 + 0.5, y as f64 + 0.5).radiance;
        for (actual, expected) in pixel.iter().zip(expected) {
            let off = (f64::from(*actual) - expected).abs();
            worst.see(off / expected.max(f64::MIN_POSITIVE), || {
                format!("{x}, {y}")
            });
        }
    }
    worst.judge();
    let differences = differences(&world, &world);
    assert_eq!(differences.len(), 300);
    assert!(
        differences
            .iter()
            .all(|of| of.worst == 0.0 && of.materials == 300)
    );
}

/// As many channels as there are lights, three each, are written and have the right names.
#[test]
fn many_layers_are_written() {
    let lights = 2000;
    let text = HEAD.to_owned() + &repeated(lights, light) + &material(0) + &sphere(0, 0);
    let (world, camera) = World::new(&Scene::parse(&text, "many.toml").unwrap()).unwrap();
    let layers = Layers {
        lights: true,
        ..Layers::default()
    };
    let options = Options {
        layers,
        ..Options::default()
    };
    let film = render(&world, &camera, &options).unwrap();
    let mut bytes = std::io::Cursor::new(Vec::new());
    film.write_exr_to(&mut bytes, &ExrOptions::default())
        .unwrap();
    let bytes = bytes.into_inner();
    let name = format!("light_light{}.B\0", lights - 1);
    let found = |name: &str| {
        bytes
            .windows(name.len())
            .any(|part| part == name.as_bytes())
    };
    assert!(found(&name));
    assert!(!found("light_light2000.B\0"));
}

/// Lights in objects are found, however many there are of both.
#[test]
fn lights_are_found_inside_of_many_objects() {
    let many = 20_000;
    // Every light is in the dome, the even ones also in a sphere of their own.
    let text = HEAD.to_owned()
        + &material(0)
        + &repeated(many, |n| {
            format!("[lights.light{n}.point]\nposition = [{n}, 0, 0]\nintensity = 1\n")
        })
        + &repeated(many / 2, |n| {
            let center = 2 * n;
            format!(
                "[objects.o{n}.sphere]\nmaterial = \"material0\"\ncenter = [{center}, 0, 0]\n\
                 radius = 0.4\n"
            )
        })
        + "[objects.dome.sphere]\nmaterial = \"material0\"\ncenter = [0, 0, 0]\nradius = 1e6\n"
        + "[objects.beside.sphere]\nmaterial = \"material0\"\ncenter = [0.5, 0, 0]\nradius = 0.5\n";
    let (world, _) = World::new(&Scene::parse(&text, "many.toml").unwrap()).unwrap();
    let inside: Vec<(String, usize, String)> = physics::warnings(&world)
        .into_iter()
        .filter_map(|warning| match warning {
            Warning::LightInside {
                light,
                more,
                object,
            } => Some((light, more, object)),
            _ => None,
        })
        .collect();
    assert_eq!(inside.len(), many / 2 + 1);
    for (n, (light, more, object)) in inside[..many / 2].iter().enumerate() {
        let expected = (format!("light{}", 2 * n), 0, format!("o{n}"));
        assert_eq!((light.clone(), *more, object.clone()), expected);
    }
    let dome = &inside[many / 2];
    assert_eq!(*dome, ("light0".to_owned(), many - 1, "dome".to_owned()));
}
