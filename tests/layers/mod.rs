//! `--layers lights,depth,normal`: closed forms, the same numbers by other ways (a film of one light
//! alone, the oracle, OpenImageIO), and that nothing else changes.

mod files;
mod terms;

use candela::image::{BACKGROUND_DEPTH, Film, Window};
use candela::oracle::Oracle;
use candela::render::{self, Job, Layers, Options, Relight, Renderer};
use candela::scene::{Scene, Transport, Value};
use candela::world::{Wavelengths, World};

use crate::generate;
use crate::images::{at_width, bits, film_of, name_of, parse, scene_files};
use crate::measured::Measured;
use crate::oracle::{Rendered, is_flip};

/// Half a unit in the last place of an f32, relative: what narrowing an f64 may change.
const F32_ROUNDING: f64 = 1.0 / (1 << 24) as f64;

/// Narrowing, and f64 sums along the way.
const CLOSED_FORM: f64 = 1.001 * F32_ROUNDING;

/// Half the smallest f32: what narrowing may change where that is more.
const F32_UNDERFLOW: f64 = 1e-45;

fn all() -> Layers {
    Layers {
        lights: true,
        relight: Relight::Never,
        depth: true,
        normal: true,
        ..Layers::default()
    }
}

fn lights() -> Layers {
    Layers {
        lights: true,
        relight: Relight::Never,
        ..Layers::default()
    }
}

fn with_layers(scene: &Scene, samples: u32, layers: Layers) -> Film {
    let (world, camera) = World::new(scene).unwrap_or_else(|error| panic!("{error}"));
    let options = Options {
        samples,
        layers,
        ..Options::default()
    };
    render::render(&world, &camera, &options).unwrap()
}

/// The values of some channels, pixel by pixel.
fn channels<const N: usize>(film: &Film, names: [&str; N]) -> Vec<[f32; N]> {
    let list = &film.channels().list;
    let places = names.map(|name| list.iter().position(|c| c.name == name).unwrap());
    let pixels = 0..film.pixels().len();
    pixels
        .map(|pixel| places.map(|place| film.values(pixel)[place]))
        .collect()
}

fn depths(film: &Film) -> Vec<f32> {
    channels(film, ["Z"]).into_iter().flatten().collect()
}

fn normals(film: &Film) -> Vec<[f32; 3]> {
    channels(film, ["N.X", "N.Y", "N.Z"])
}

fn share(film: &Film, light: &str) -> Vec<[f32; 3]> {
    let name = |channel| format!("light_{light}.{channel}");
    channels(film, [&name("R"), &name("G"), &name("B")])
}

/// The bits of all values of all pixels.
fn value_bits(film: &Film) -> Vec<Vec<u32>> {
    let bits_of = |pixel| film.values(pixel).iter().map(|v| v.to_bits()).collect();
    (0..film.pixels().len()).map(bits_of).collect()
}

fn assert_close(actual: f32, expected: f64, what: impl std::fmt::Debug) {
    let error = (f64::from(actual) - expected).abs();
    assert!(
        error <= CLOSED_FORM * expected.abs(),
        "{what:?}: {actual} {expected}"
    );
}

/// A ball of radius 1 around the origin, seen along −z from 5 m away; its wall is 3 m behind it, and
/// a light is 1 m above the viewer.
fn ball(camera: &str) -> String {
    format!(
        "[image]
         resolution = [65, 65]
         [camera.{camera}
         eye = [0, 0, 5]
         look_at = [0, 0, 0]
         [materials.clay.phong]
         diffuse = 0.5
         [lights.key.point]
         position = [0, 1, 5]
         intensity = 10
         [objects.ball.sphere]
         material = 'clay'
         center = [0, 0, 0]
         radius = 1
        "
    )
}

const WALL: &str = "
    [objects.wall.plane]
    material = 'clay'
    point = [7, 8, -3]
    normal = [0, 0, -1]
";

/// x and y of the middle of a pixel of 65 × 65 on an image plane from −1 to 1.
fn on_image_plane(pixel: usize) -> [f64; 2] {
    let middle = |n: usize| (2.0 * n as f64 + 1.0) / 65.0 - 1.0;
    [middle(pixel % 65), -middle(pixel / 65)]
}

/// A wall across the view is as far away in the corners as in the middle, and the ball is where
/// |eye + t ω| = 1 with ω along the view axis of length 1.
#[test]
fn depth_is_along_the_view_axis() {
    let text = ball("perspective]\nvertical_fov = 90") + WALL;
    let film = with_layers(&parse(&text), 1, all());
    let mut on_ball = 0;
    for (pixel, &depth) in depths(&film).iter().enumerate() {
        let [x, y] = on_image_plane(pixel);
        // t² (x² + y² + 1) − 10 t + 24 = 0
        let square = x * x + y * y + 1.0;
        let discriminant = 25.0 - 24.0 * square;
        if discriminant > 0.0 {
            on_ball += 1;
            assert_close(depth, (5.0 - discriminant.sqrt()) / square, [x, y]);
        } else {
            assert_close(depth, 8.0, [x, y]);
        }
    }
    assert!(on_ball > 100);
    // Straight ahead, and exactly.
    assert_eq!(depths(&film)[32 * 65 + 32], 4.0);
}

/// Seen in parallel, with the image plane 3 units high: N is the place on the unit ball itself.
#[test]
fn normals_of_a_ball_are_its_points() {
    let film = with_layers(&parse(&ball("orthographic]\nheight = 3")), 1, all());
    let mut on_ball = 0;
    for (pixel, (normal, depth)) in normals(&film).into_iter().zip(depths(&film)).enumerate() {
        let [x, y] = on_image_plane(pixel).map(|x| 1.5 * x);
        let square = 1.0 - x * x - y * y;
        if square < 0.0 {
            assert_eq!((normal, depth), ([0.0; 3], BACKGROUND_DEPTH));
            assert_eq!(film.pixels()[pixel][3], 0.0);
            continue;
        }
        on_ball += 1;
        for (actual, expected) in normal.into_iter().zip([x, y, square.sqrt()]) {
            // Rounded beside 1, as f64 is in the sphere's equation.
            let error = (f64::from(actual) - expected).abs();
            assert!(error <= CLOSED_FORM * expected.abs() + 1e-12, "{x} {y}");
        }
        assert_close(depth, 5.0 - square.sqrt(), [x, y]);
    }
    assert!(on_ball > 1000);
}

/// Two-sided: the wall's normal is −z as written, and towards the viewer from either side.
#[test]
fn normals_are_turned_towards_the_viewer() {
    let text = ball("perspective]\nvertical_fov = 20") + WALL;
    // Past the ball, so that the wall alone is seen.
    for (eye, expected) in [("[0, 3, 5]", 1.0), ("[0, 3, -9]", -1.0)] {
        let text = text.replace("eye = [0, 0, 5]", &format!("eye = {eye}"));
        let text = text.replace("look_at = [0, 0, 0]", "look_at = [0, 3, -3]");
        let film = with_layers(&parse(&text), 1, all());
        for normal in normals(&film) {
            assert_eq!(normal, [0.0, 0.0, expected]);
            assert!(normal.iter().all(|c| c.to_bits() != (-0.0_f32).to_bits()));
        }
    }
}

/// A pixel whose left half shows a wall 2 m away, and whose upper right quarter one that is tilted
/// by 45° and 3 m away in its middle; a background of 0.25 shows in the rest.
const QUARTERS: &str = "
    [image]
    resolution = [1, 1]
    background = 0.25
    [camera.orthographic]
    eye = [0, 0, 2]
    look_at = [0, 0, 0]
    height = 1e-6
    [materials.clay.phong]
    diffuse = 0.5
    [lights.key.point]
    position = [0, 0, 1]
    intensity = 8
    [objects.near.triangle]
    material = 'clay'
    vertices = [[0, -9, 0], [0, 9, 0], [-9, 0, 0]]
    [objects.tilted.triangle]
    material = 'clay'
    vertices = [[-9, 0, -1], [9, 0, -1], [0, 9, 8]]
";

#[test]
fn samples_are_averaged_but_for_depth() {
    let without_near = QUARTERS.replace(
        "[[0, -9, 0], [0, 9, 0], [-9, 0, 0]]",
        "[[9, 9, 9], [9, 8, 9], [9, 9, 8]]",
    );
    let film = with_layers(&parse(QUARTERS), 1024, all());
    assert_eq!(film.pixels()[0][3], 0.75);
    // The pixel is a micrometre wide.
    const WIDTH: f64 = 1e-6;
    let close = |actual: f32, expected: f64| {
        assert!(
            (f64::from(actual) - expected).abs() <= WIDTH * expected.abs(),
            "{actual} {expected}"
        );
    };
    // A mean of 2 m, 3 m and nothing would be no depth of anything.
    close(depths(&film)[0], 2.0);
    close(
        depths(&with_layers(&parse(&without_near), 1024, all()))[0],
        3.0,
    );
    let tilted = 0.5_f64.sqrt();
    let [x, y, z] = normals(&film)[0];
    assert_eq!(x, 0.0);
    close(y, -0.25 * tilted);
    close(z, 0.5 + 0.25 * tilted);
    // L_o = 0.5 · 8 cd / d² · cos: 4 at 1 m, √½ at 2 m.
    let [key, ..] = share(&film, "key")[0];
    close(key, 0.5 * 4.0 + 0.25 * tilted);
    let [background, ..] = share(&film, "background")[0];
    assert_eq!(background, 0.25 * 0.25);
}

/// Generated scenes, some of each kind, some under spots, and the lecture's.
fn scenes(folder: &tempfile::TempDir, count: usize) -> Vec<(String, Scene)> {
    let mut scenes = generate::scenes(folder.path());
    scenes.truncate(count);
    scenes.extend(generate::spots(count as u64 / 4, folder.path()));
    scenes.push(("lecture".to_owned(), at_width(Scene::builtin(), 64)));
    scenes
}

/// Those that light can be carried through spectrally: of some, a reflectance would be above 1 between
/// the wavelengths that its color is made of.
fn spectral(mut scenes: Vec<(String, Scene)>) -> Vec<(String, Scene)> {
    for (_, scene) in &mut scenes {
        scene.image.transport.value = Transport::Spectral;
    }
    scenes.retain(|(_, scene)| World::new(scene).is_ok());
    assert!(scenes.len() >= 8, "{}", scenes.len());
    scenes
}

/// To the bit: a light's share is the film that has this light alone, and the background's is the
/// film without lights.
#[test]
fn a_share_is_the_film_of_one_light() {
    let folder = tempfile::tempdir().unwrap();
    let (mut compared, mut backgrounds) = (0, 0);
    for (name, mut scene) in scenes(&folder, 30) {
        // Also where the only spectrum is that of a light which is not there.
        scene.image.transport.value = match World::new(&scene).unwrap().0.spectra() {
            Some(_) => Transport::Spectral,
            None => Transport::Rgb,
        };
        for samples in [1, 3] {
            let film = with_layers(&scene, samples, lights());
            let alone = |scene: &Scene| -> Vec<[u32; 3]> {
                let film = film_of(scene, samples);
                let pixels = film.pixels().iter();
                pixels
                    .map(|&[r, g, b, _]| [r, g, b].map(f32::to_bits))
                    .collect()
            };
            let share_bits = |light: &str| -> Vec<[u32; 3]> {
                let pixels = share(&film, light).into_iter();
                pixels.map(|rgb| rgb.map(f32::to_bits)).collect()
            };
            for light in &scene.lights {
                let mut only = scene.clone();
                only.lights = vec![light.clone()];
                only.image.background.value = Value::ZERO;
                assert!(
                    share_bits(&light.name) == alone(&only),
                    "{name}: {}",
                    light.name
                );
                compared += 1;
            }
            if film.channels().list.len() > 3 * scene.lights.len() {
                let mut dark = scene.clone();
                dark.lights.clear();
                assert!(share_bits("background") == alone(&dark), "{name}");
                backgrounds += 1;
            }
        }
    }
    assert!(
        compared >= 120 && backgrounds >= 12,
        "{compared} {backgrounds}"
    );
}

/// Every share is rounded once, by half a unit in its last place, and so is the sum that R, G and B
/// are.
#[test]
fn shares_add_up_to_red_green_blue() {
    let folder = tempfile::tempdir().unwrap();
    for (name, scene) in scenes(&folder, 50) {
        for samples in [1, 4] {
            let film = with_layers(&scene, samples, lights());
            for (pixel, rgba) in film.pixels().iter().enumerate() {
                for (channel, &color) in rgba[..3].iter().enumerate() {
                    let shares = film.values(pixel).into_iter().skip(channel).step_by(3);
                    let (mut sum, mut magnitude, mut count) = (0.0, f64::from(color.abs()), 1.0);
                    for share in shares {
                        sum += f64::from(share);
                        magnitude += f64::from(share.abs());
                        count += 1.0;
                    }
                    let error = (f64::from(color) - sum).abs();
                    let bound = CLOSED_FORM * magnitude + count * F32_UNDERFLOW;
                    assert!(error <= bound, "{name}: {color} is not {sum}");
                }
            }
        }
    }
}

/// What is asked for beside it changes no bit of a channel.
#[test]
fn layers_leave_each_other_as_they_are() {
    let wavelengths = Wavelengths::new(400, 700, 50);
    let folder = tempfile::tempdir().unwrap();
    let mut scenes = scenes(&folder, 10);
    for path in scene_files() {
        scenes.push((name_of(&path), at_width(Scene::load(&path).unwrap(), 60)));
    }
    for (name, scene) in spectral(scenes) {
        for samples in [1, 3] {
            let every = Layers {
                spectral: wavelengths,
                ..all()
            };
            let every = with_layers(&scene, samples, every);
            let bands = 7;
            let of_lights = every.channels().list.len() - 4 - bands;
            let bits_of_every = value_bits(&every);
            for (layers, range) in [
                (Layers::default(), 0..0),
                (lights(), 0..of_lights),
                (
                    Layers {
                        lights: false,
                        normal: false,
                        ..all()
                    },
                    of_lights + 3..of_lights + 4,
                ),
                (
                    Layers {
                        lights: false,
                        depth: false,
                        ..all()
                    },
                    of_lights..of_lights + 3,
                ),
                (
                    Layers {
                        spectral: wavelengths,
                        ..Layers::default()
                    },
                    of_lights + 4..of_lights + 4 + bands,
                ),
            ] {
                let film = with_layers(&scene, samples, layers.clone());
                assert!(bits(&film) == bits(&every), "{name} {layers:?}");
                assert_eq!(film.channels().list, every.channels().list[range.clone()]);
                let some = bits_of_every.iter().map(|bits| &bits[range.clone()]);
                assert!(value_bits(&film).iter().eq(some), "{name} {layers:?}");
            }
        }
    }
}

/// Relative error of a light's share, as R, G and B have it; of one below this part of the picture's
/// brightest, relative to that.
const SHARE: f64 = 5.90e-8;
const FLOOR: f64 = 1e-6;

/// Relative error of a depth, and absolute error of a component of a normal: half the last bit of an
/// f32.
const DEPTH: f64 = 5.92e-8;
const NORMAL: f64 = 2.98e-8;

/// Of any of these, what is beyond all rounding, so that it must be another side of an edge.
const SIDE: f64 = 1e-5;

/// The part of the pixels whose ray passes an edge within rounding.
const FLIPS: f64 = 5e-4;

/// Every third pixel of scenes of all kinds.
#[test]
fn the_oracle_agrees() {
    let folder = tempfile::tempdir().unwrap();
    let nothing = (BACKGROUND_DEPTH, [0.0; 3]);
    let (mut compared, mut flips) = (0, 0);
    let figures = [("depth", DEPTH), ("normal", NORMAL), ("share", SHARE)];
    let mut worst = figures.map(|(what, figure)| Measured::new(what, figure));
    for (name, scene) in scenes(&folder, 50) {
        let film = with_layers(&scene, 1, all());
        let oracle = Oracle::new(&scene);
        let width = oracle.resolution()[0] as usize;
        let (depths, normals) = (depths(&film), normals(&film));
        let brightest = |rgb: [f64; 3]| rgb.map(f64::abs).into_iter().fold(0.0, f64::max);
        let shares: Vec<_> = scene
            .lights
            .iter()
            .map(|light| share(&film, &light.name))
            .collect();
        let most = film
            .pixels()
            .iter()
            .map(|&[r, g, b, _]| brightest([r, g, b].map(f64::from)));
        let floor = FLOOR * most.fold(f64::MIN_POSITIVE, f64::max);
        for pixel in (0..film.pixels().len()).step_by(3) {
            let at = [pixel % width, pixel / width];
            let terms = oracle.explain(at[0] as f64 + 0.5, at[1] as f64 + 0.5);
            let mut errors = [0.0_f64; 3];
            match &terms.hit {
                None => {
                    let is_nothing = (depths[pixel], normals[pixel]) == nothing;
                    errors[0] = if is_nothing { 0.0 } else { f64::INFINITY };
                }
                Some(hit) => {
                    errors[0] = (f64::from(depths[pixel]) / hit.depth - 1.0).abs();
                    for (&actual, expected) in normals[pixel].iter().zip(hit.normal) {
                        errors[1] = errors[1].max((f64::from(actual) - expected).abs());
                    }
                    for (share, light) in shares.iter().zip(&terms.lights) {
                        let scale = brightest(light.radiance).max(floor);
                        for (&actual, expected) in share[pixel].iter().zip(light.radiance) {
                            errors[2] = errors[2].max((f64::from(actual) - expected).abs() / scale);
                        }
                    }
                }
            }
            compared += 1;
            if errors.iter().all(|error| *error <= SIDE) {
                for (worst, error) in worst.iter_mut().zip(errors) {
                    worst.see(error, || format!("{name} {at:?}"));
                }
            } else {
                let rendered = Rendered {
                    pixel: film.pixels()[pixel],
                    shares: &film.values(pixel),
                };
                let is_flip = is_flip(&oracle, &scene, at, &rendered, floor);
                assert!(is_flip, "{name} at {at:?}: {errors:?}");
                flips += 1;
            }
        }
    }
    println!("{compared} pixels, {flips} flips");
    for worst in &worst {
        worst.judge();
    }
    assert!(
        f64::from(flips) <= FLIPS * f64::from(compared),
        "{flips} of {compared}"
    );
}

/// Each pixel owns its sums: 3 samples make batches end within a pixel, 300 make a pixel have more
/// than one.
#[test]
fn a_part_has_the_layers_of_the_whole() {
    let scene = at_width(Scene::builtin(), 75);
    let (world, camera) = World::new(&scene).unwrap();
    let window = Window {
        x: 33,
        y: 11,
        width: 21,
        height: 17,
    };
    for samples in [3, 300] {
        let whole = with_layers(&scene, samples, all());
        let options = Options {
            samples,
            window: Some(window),
            layers: all(),
            ..Options::default()
        };
        let part = render::render(&world, &camera, &options).unwrap();
        for (pixel, [x, y]) in window.pixels().enumerate() {
            let in_whole = (y * camera.resolution()[0] + x) as usize;
            let bits =
                |values: &[f32]| -> Vec<u32> { values.iter().map(|v| v.to_bits()).collect() };
            assert_eq!(bits(&part.values(pixel)), bits(&whole.values(in_whole)));
        }
    }
}

/// 1e-9 m below a lamp of 3e38 cd: in R, G, B, and in the light's share of each.
#[test]
fn shares_beyond_f32_are_clamped_and_counted() {
    let scene = parse(
        &QUARTERS
            .replace("intensity = 8", "intensity = 3e38")
            .replace("[0, 0, 1]\n", "[-1e-7, 0, 1e-9]\n"),
    );
    let (world, camera) = World::new(&scene).unwrap();
    let renderer = Renderer::new(&world).unwrap();
    let options = Options {
        samples: 64,
        layers: all(),
        ..Options::default()
    };
    let (film, counts) = renderer.film(&camera, &options, &Job::new()).unwrap();
    assert_eq!(share(&film, "key")[0], [f32::MAX; 3]);
    assert_eq!(counts.clamped, 3 + 3);
}

/// A scene of RGB lights without a light has no shares, and that is a film like any other.
#[test]
fn no_lights_have_no_shares() {
    let mut scene = parse(QUARTERS);
    scene.lights.clear();
    let film = with_layers(&scene, 1, lights());
    assert_eq!(film.channels().list.len(), 3);
    scene.image.background.value = Value::ZERO;
    let film = with_layers(&scene, 1, lights());
    assert!(film.channels().list.is_empty());
    assert_eq!(film.pixels().len(), 1);
}
