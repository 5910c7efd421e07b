//! The files that layers make: the same for any machine, and what OpenImageIO makes of them.

use std::io::Cursor;
use std::path::Path;

use candela::exr::{ExrOptions, Precision};
use candela::image::{ChannelKind, Film};
use candela::output::Unfinished;
use candela::render::SimdLevel;
use candela::render::{self, Layers, Options};
use candela::scene::{Object, Scene, Value};
use candela::world::{Wavelengths, World};

use super::{F32_ROUNDING, WALL, all, ball, depths, scenes, share, spectral, with_layers};
use crate::images::{at_width, parse};
use crate::openimageio::{decode, idiff_agrees, idiff_agrees_within, oiiotool};

#[test]
fn threads_and_instructions_give_the_same_file() {
    let folder = tempfile::tempdir().unwrap();
    let layers = Layers {
        spectral: Some(Wavelengths::new(400, 700, 100).unwrap()),
        ..all()
    };
    for (name, scene) in spectral(scenes(&folder, 10)) {
        let (world, camera) = World::new(&scene).unwrap();
        let file = |threads, simd| {
            let options = Options {
                samples: 3,
                layers: layers.clone(),
                simd,
                ..Options::default()
            };
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().unwrap().install(|| {
                let mut file = Cursor::new(Vec::new());
                let film = render::render(&world, &camera, &options).unwrap();
                film.write_exr_to(&mut file, &ExrOptions::default())
                    .unwrap();
                file.into_inner()
            })
        };
        let first = file(1, SimdLevel::default());
        assert!(
            file(2, SimdLevel::default()) == first,
            "{name} on two threads"
        );
        for (instructions, simd) in SimdLevel::available() {
            assert!(file(1, simd) == first, "{name} on {instructions}");
        }
    }
}

fn write(film: &Film, path: &Path, precision: Precision) -> u64 {
    let options = ExrOptions {
        precision,
        ..ExrOptions::default()
    };
    let report = film.write_exr(path, &options, &Unfinished::new()).unwrap();
    report.small_in_half
}

/// OpenImageIO puts the picture together again from its lights, the background among them.
#[test]
fn oiiotool_adds_the_lights_up() {
    let mut scene = at_width(Scene::builtin(), 320);
    scene.image.background.value = Value::Uniform(0.125);
    // Behind the wall, the background is seen.
    let mut objects = scene.objects.iter();
    assert!(objects.any(|object| matches!(object.value, Object::Plane { .. })));
    scene
        .objects
        .retain(|object| !matches!(object.value, Object::Plane { .. }));
    let film = with_layers(&scene, 4, all());
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(&film, &folder.join("a.exr"), Precision::Float);
    let names = scene.lights.iter().map(|light| light.name.as_str());
    let names: Vec<&str> = names.chain(["background"]).collect();
    assert_eq!(names.len(), 4);
    let mut arguments = String::new();
    for (index, name) in names.iter().enumerate() {
        let ch = ["R", "G", "B"]
            .map(|c| format!("{c}=light_{name}.{c}"))
            .join(",");
        let add = if index == 0 { "" } else { " --add" };
        arguments += &format!("a.exr --ch {ch}{add} ");
    }
    oiiotool(folder, &format!("{arguments} -d float -o sum.exr"));
    oiiotool(folder, "a.exr --ch R,G,B -o beauty.exr");
    // f32 sums of four: two more roundings each than the film's own.
    let relative = 8.0 * F32_ROUNDING;
    let (sum, beauty) = (folder.join("sum.exr"), folder.join("beauty.exr"));
    assert!(idiff_agrees_within(&sum, &beauty, relative, 0));
    // Without the background's, it would be another picture.
    let last = arguments.rfind("a.exr").unwrap();
    oiiotool(
        folder,
        &format!("{} -d float -o sum.exr", &arguments[..last]),
    );
    assert!(!idiff_agrees_within(&sum, &beauty, relative, 0));
}

/// OpenImageIO puts a ball and a wall that were rendered apart together by their depths. Without
/// shadows this is the scene with both.
#[test]
fn oiiotool_composes_by_depth() {
    let camera = ball("perspective]\nvertical_fov = 40");
    // At the eye, a light casts no shadow that is seen.
    let camera = camera.replace("position = [0, 1, 5]", "position = [0, 0, 5]");
    let tilted = WALL
        .replace("[7, 8, -3]", "[0, 0, 0.25]")
        .replace("[0, 0, -1]", "[0.3, 1, 1]");
    let ball_alone = camera.find("[objects.ball").unwrap();
    let depth = Layers {
        depth: true,
        ..Layers::default()
    };
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (name, text) in [
        ("ball.exr", camera.clone()),
        ("wall.exr", camera[..ball_alone].to_owned() + &tilted),
        ("both.exr", camera.clone() + &tilted),
    ] {
        let film = with_layers(&parse(&text), 1, depth.clone());
        write(&film, &folder.join(name), Precision::Float);
    }
    for order in ["ball.exr wall.exr", "wall.exr ball.exr"] {
        oiiotool(folder, &format!("{order} --zover -o composed.exr"));
        assert!(
            idiff_agrees(&folder.join("composed.exr"), &folder.join("both.exr")),
            "{order}"
        );
    }
    assert!(!idiff_agrees(
        &folder.join("ball.exr"),
        &folder.join("both.exr")
    ));
    assert!(!idiff_agrees(
        &folder.join("wall.exr"),
        &folder.join("both.exr")
    ));
}

/// HALF is for light and normals; small components of normals are small beside 1, and no loss.
#[test]
fn depth_stays_float() {
    let mut scene = at_width(Scene::builtin(), 120);
    scene.lights.truncate(1);
    let film = with_layers(&scene, 1, all());
    let kinds: Vec<ChannelKind> = film.channels().list.iter().map(|c| c.kind).collect();
    let expected = [
        [ChannelKind::Light; 3].as_slice(),
        &[ChannelKind::Relative; 3],
        &[ChannelKind::Data],
    ];
    assert_eq!(kinds, expected.concat());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let small = write(&film, &path, Precision::Half);
    let tiny = |value: f32| value != 0.0 && value.abs() < 6.1e-5;
    let light = &scene.lights[0].name;
    let of_light = share(&film, light)
        .into_iter()
        .flatten()
        .filter(|&v| tiny(v))
        .count();
    assert_eq!(small, of_light as u64);
    let decoded = decode(&path);
    let place = |name: &str| decoded.channels.iter().position(|c| c == name).unwrap();
    for (pixel, &depth) in depths(&film).iter().enumerate() {
        assert_eq!(decoded.pixel(pixel % 120, pixel / 120)[place("Z")], depth);
    }
    let info = oiiotool(folder.path(), "--info -v a.exr");
    for expected in [
        "Z (float)",
        "N.X (half)",
        &format!("light_{light}.R (half)"),
    ] {
        assert!(info.contains(expected), "{info}");
    }
    assert!(
        info.contains("candela:layers: \"lights,depth,normal\""),
        "{info}"
    );
}
