//! Things that move: a frame of a scene with keys is the scene that says the same without them, whatever was rendered
//! before it.

use std::fs;
use std::path::Path;

use candela::exr::{ExrOptions, Preserve};
use candela::render::{Job, Layers, Options, Renderer};
use candela::scene::{Reading, Scene, Value};
use candela::world::{Loaded, World};
use tempfile::TempDir;

use crate::oracle::assert_agrees;

/// Everything that can move does.
const MOVING: &str = r##"
[image]
resolution = [48, 32]
background = { keys = [[1, [0.1, 0.2, 0.4]], [9, 0.2]] }

[camera.perspective]
eye = { keys = [[1, [0, 1.2, 4]], [5, [2, 1.4, 3.5]], [9, [3, 1.2, 2]]], interpolation = "smooth" }
look_at = { keys = [[1, [0, 0.4, 0]], [9, [0.2, 0.6, 0]]] }
up = { keys = [[1, [0, 1, 0]], [9, [0.2, 1, 0]]] }
vertical_fov = { keys = [[1, 40], [9, 30]] }

[lights.key.point]
position = { keys = [[1, [3, 4, 3]], [9, [-3, 4, 3]]] }
intensity = { keys = [[1, 30], [9, [20, 30, 40]]] }

[lights.lamp.spot]
position = { keys = [[1, [0, 3, 0]], [9, [1, 3, 1]]] }
look_at = { keys = [[1, [0, 0, 0]], [9, [0, 0, 1]]] }
intensity = { lumens = { keys = [[1, 100], [9, 300]] } }
inner = { keys = [[1, 10], [9, 20]] }
outer = { keys = [[1, 30], [9, 40]] }

[materials.clay.phong]
diffuse = { keys = [[1, "#c03020"], [9, [0.1, 0.2, 0.6]]] }
specular = { keys = [[1, 0.1], [9, 0.3]] }
shininess = { keys = [[1, 10], [9, 50]] }

[materials.chalk.normalized_phong]
diffuse = 0.5

[objects.ball.sphere]
material = "clay"
center = { keys = [[1, [-1, 0.5, 0]], [5, [0, 0.8, 0]], [9, [1, 0.5, 0]]], interpolation = "smooth" }
radius = { keys = [[1, 0.5], [9, 0.3]] }

[objects.shard.triangle]
material = "chalk"
vertices = { keys = [[1, [[0, 0, 0], [1, 0, 0], [0, 1, 0]]], [9, [[0, 0, 1], [1, 0, 1], [0, 1, 1]]]] }

[objects.floor.plane]
material = "chalk"
point = { keys = [[1, [0, 0, 0]], [9, [0, -0.2, 0]]] }
normal = { keys = [[1, [0, 1, 0]], [9, [0.1, 1, 0]]] }

[objects.quad.mesh]
material = "chalk"
file = "quad.obj"
scale = { keys = [[1, 1], [9, [2, 1, 1]]] }
rotate = { keys = [[1, [0, 0, 0]], [9, [0, 90, 30]]] }
translate = { keys = [[1, [-2, 0, -1]], [9, [-1, 0.5, -1]]], interpolation = "step" }
"##;

/// The same at frame 3, a quarter of the way: the smooth ones from the Hermite basis, t = 1/2 between frames 1 and 5,
/// with the slope 0 at the first key and (v₉ − v₁)/8 at the second.
const AT_FRAME_3: &str = r##"
[image]
resolution = [48, 32]
background = [0.125, 0.2, 0.35]

[camera.perspective]
eye = [0.8125, 1.3, 3.875]
look_at = [0.05, 0.45, 0]
up = [0.05, 1, 0]
vertical_fov = 37.5

[lights.key.point]
position = [1.5, 4, 3]
intensity = [27.5, 30, 32.5]

[lights.lamp.spot]
position = [0.25, 3, 0.25]
look_at = [0, 0, 0.25]
intensity = { lumens = 150 }
inner = 12.5
outer = 32.5

[materials.clay.phong]
diffuse = [0.42034, 0.07217, 0.16083]
specular = 0.15
shininess = 20

[materials.chalk.normalized_phong]
diffuse = 0.5

[objects.ball.sphere]
material = "clay"
center = [-0.625, 0.65, 0]
radius = 0.45

[objects.shard.triangle]
material = "chalk"
vertices = [[0, 0, 0.25], [1, 0, 0.25], [0, 1, 0.25]]

[objects.floor.plane]
material = "chalk"
point = [0, -0.05, 0]
normal = [0.025, 1, 0]

[objects.quad.mesh]
material = "chalk"
file = "quad.obj"
scale = [1.25, 1, 1]
rotate = [0, 22.5, 7.5]
translate = [-2, 0, -1]
"##;

const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";

fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("quad.obj"), QUAD).unwrap();
    fs::write(folder.path().join("moving.toml"), MOVING).unwrap();
    fs::write(folder.path().join("at3.toml"), AT_FRAME_3).unwrap();
    folder
}

fn at(path: &Path, frame: f64) -> Loaded {
    World::of_reading(Reading::of_file(path).at(frame), |_| {}).unwrap()
}

/// All numbers of a scene; places in the file are others.
fn numbers(scene: &Scene) -> Vec<f64> {
    let text = format!(
        "{:?} {:?} {:?} {:?} {:?}",
        scene.image, scene.camera, scene.materials, scene.lights, scene.objects
    );
    let mut found = Vec::new();
    let mut is_place = false;
    for word in text.split(|c: char| !(c.is_alphanumeric() || "._-".contains(c))) {
        if word == "span" {
            is_place = true;
        } else if word == "value" || word == "name" || word == "geometry" {
            is_place = false;
        } else if let Ok(number) = word.parse::<f64>()
            && !is_place
        {
            found.push(number);
        }
    }
    found
}

#[test]
fn a_frame_is_the_scene_that_says_the_same_without_keys() {
    let folder = folder();
    let moving = at(&folder.path().join("moving.toml"), 3.0);
    let still = Scene::load(folder.path().join("at3.toml")).unwrap();
    let (moving, still) = (numbers(&moving.scene), numbers(&still));
    assert_eq!(moving.len(), still.len());
    assert!(still.len() > 60);
    // The sRGB code is written with five digits.
    for (moving, still) in moving.into_iter().zip(still) {
        assert!((moving - still).abs() < 6e-6, "{moving}, expected {still}");
    }
}

/// Frames of one run are those of runs by themselves, to the bit; before and after all keys nothing moves.
#[test]
fn frames_do_not_depend_on_what_was_rendered_before() {
    let folder = folder();
    let path = folder.path().join("moving.toml");
    let mut run = at(&path, 1.0);
    let mut built = Some(Renderer::new(&run.world).unwrap().into_built());
    let options = Options {
        samples: 2,
        layers: Layers {
            lights: true,
            ..Layers::default()
        },
        ..Options::default()
    };
    let bytes = |renderer: &Renderer<'_>, camera: &candela::Camera| {
        let mut bytes = std::io::Cursor::new(Vec::new());
        let exr = ExrOptions::default();
        let rendered = renderer.exr(
            camera,
            &options,
            &exr,
            Preserve::Nothing,
            &Job::new(),
            &mut bytes,
        );
        rendered.unwrap();
        bytes.into_inner()
    };
    let mut seen = Vec::new();
    for frame in [4.0, 4.5, 9.0, 2.0, 1.0, -3.0, 100.0] {
        let change = run.motion.set(&mut run.scene, frame).unwrap();
        let (world, camera) = run.world.again(&run.scene, change).unwrap();
        let before = built.take().unwrap().of(&run.world);
        let renderer = before.again(&world).unwrap();
        let in_run = bytes(&renderer, &camera);
        built = Some(renderer.into_built());
        run.world = world;

        let alone = at(&path, frame);
        let renderer = Renderer::new(&alone.world).unwrap();
        assert!(bytes(&renderer, &alone.camera) == in_run, "frame {frame}");
        seen.push(in_run);
    }
    // As the last key, and as the first.
    assert!(seen[6] == seen[2] && seen[5] == seen[4]);
    assert!(seen[0] != seen[1]);
}

/// The oracle sees what the renderer sees, between keys too, in RGB and wavelength by wavelength.
#[test]
fn the_oracle_agrees_between_keys() {
    let folder = folder();
    let path = folder.path().join("moving.toml");
    let spectral = MOVING.replace(
        "intensity = { keys = [[1, 30], [9, [20, 30, 40]]] }",
        "intensity = { candela = 30, color = { keys = [[1, { blackbody = 2000 }], [9, { illuminant = \"F11\" }]] } }",
    );
    let other = folder.path().join("spectral.toml");
    fs::write(&other, spectral).unwrap();
    for path in [&path, &other] {
        assert!(assert_agrees("between keys", &at(path, 6.25).scene) > 100);
    }
}

/// Halfway between two lamps there is half of the light of each: of 2000 K and 8000 K with 10 cd each, 10 cd, and no
/// lamp of 5000 K.
#[test]
fn light_mixes_as_light() {
    let scene = |intensity: &str| {
        let text = format!(
            "[image]\nresolution = [9, 9]\n\
             [camera.orthographic]\neye = [0, 1, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, -1]\nheight = 9\n\
             [materials.chalk.phong]\ndiffuse = 0.5\n\
             [lights.lamp.point]\nposition = [0, 2, 0]\nintensity = {intensity}\n\
             [objects.floor.plane]\nmaterial = \"chalk\"\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n"
        );
        let reading = Reading::of_text(text, Path::new("lamp.toml")).at(2.0);
        let loaded = World::of_reading(reading, |_| {}).unwrap();
        let renderer = Renderer::new(&loaded.world).unwrap();
        let film = renderer
            .film(&loaded.camera, &Options::default(), &Job::new())
            .unwrap()
            .0;
        (loaded.world.candelas(0), film.pixels()[40])
    };
    let lamp = |kelvin: u32| format!("{{ candela = 10, color = {{ blackbody = {kelvin} }} }}");
    let (_, warm) = scene(&lamp(2000));
    let (_, cold) = scene(&lamp(8000));
    for mixed in [
        format!("{{ keys = [[1, {}], [3, {}]] }}", lamp(2000), lamp(8000)),
        "{ candela = 10, color = { keys = [[1, { blackbody = 2000 }], [3, { blackbody = 8000 }]] } }".to_owned(),
    ] {
        let (candela, seen) = scene(&mixed);
        assert!((candela - 10.0).abs() < 1e-9);
        for channel in 0..3 {
            let half = 0.5 * (warm[channel] + cold[channel]);
            assert!((seen[channel] - half).abs() < 1e-6, "{seen:?}");
        }
    }
    // A temperature that moves is a number that moves.
    let (_, moved) =
        scene("{ candela = 10, color = { blackbody = { keys = [[1, 2000], [3, 8000]] } } }");
    assert_eq!(moved, scene(&lamp(5000)).1);
    // Through a dark lamp `smooth` would swing below nothing.
    let dip = "{ keys = [[1, 0], [10, 0], [20, 100]], interpolation = \"smooth\" }";
    let text = format!("[lights.lamp.point]\nposition = [0, 2, 0]\nintensity = {dip}\n{REST}");
    let reading = Reading::of_text(text, Path::new("dip.toml")).at(5.0);
    let message = World::of_reading(reading, |_| {}).unwrap_err().to_string();
    assert!(
        message.contains("at frame 5, `intensity` is -"),
        "{message}"
    );
}

const REST: &str = "[image]\nresolution = [9, 9]\n\
    [camera.orthographic]\neye = [0, 1, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, -1]\nheight = 9\n\
    [materials.chalk.phong]\ndiffuse = 0.5\n\
    [objects.floor.plane]\nmaterial = \"chalk\"\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n";

/// A camera that looks elsewhere leaves all numbers of the world where they are.
#[test]
fn the_anchor_is_that_of_the_first_key() {
    let folder = folder();
    let path = folder.path().join("moving.toml");
    let anchors = [1.0, 5.5, 9.0].map(|frame| at(&path, frame).world.anchor().to_array());
    assert_eq!(anchors, [[0.0, 0.4, 0.0]; 3]);
    // And what stands still is built once.
    let moving_camera = "[camera.perspective]\neye = [0, 1, 4]\n\
        look_at = { keys = [[1, [0, 0, 0]], [9, [1, 1, 0]]] }\nvertical_fov = 40\n";
    let still = REST.replace(
        "[camera.orthographic]\neye = [0, 1, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, -1]\nheight = 9\n",
        moving_camera,
    );
    let loaded = Reading::of_text(still, Path::new("camera.toml"));
    let motion = loaded.motion.as_ref().unwrap();
    assert!(motion.moved().camera && !motion.moved().world);
    assert_eq!(motion.names(), ["the camera"]);
}

/// A value from a key is found where the key is written.
#[test]
fn values_keep_their_places() {
    let folder = folder();
    let path = folder.path().join("moving.toml");
    let mut loaded = at(&path, 1.0);
    let before = loaded.scene.lights[0].value.size().clone();
    loaded.motion.set(&mut loaded.scene, 7.0).unwrap();
    let after = loaded.scene.lights[0].value.size();
    assert_eq!(before.span, after.span);
    let text = &loaded.scene.source.text;
    assert!(text[after.span.start..].starts_with("{ keys = [[1, 30]"));
    assert_eq!(
        before.value,
        Value::Rgb {
            rgb: [30.0; 3],
            space: candela::scene::ColorSpace::Rec709
        }
    );
}
