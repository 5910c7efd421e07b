//! Lights with an area: published integrals through the whole program, the oracle's word in penumbrae of all kinds,
//! and the same bits whatever renders them.

use std::f64::consts::PI;
use std::fmt::Write;

use candela::image::{Film, Window};
use candela::oracle::Oracle;
use candela::render::{ErrorTarget, Job, Layers, Options, Renderer, SimdLevel};
use candela::scene::Scene;
use candela::world::World;

use crate::measured::{HALF_LAST_BIT, Measured};

/// Relative error where nothing but the rounding to f32 is between the integral and the pixel.
const ROUNDING: f64 = Measured::ROOM * HALF_LAST_BIT;

fn film_with(text: &str, options: &Options) -> Film {
    let scene = Scene::parse(text, "test.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
    let (world, camera) = World::new(&scene).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let renderer = Renderer::new(&world).unwrap();
    renderer.film(&camera, options, &Job::new()).unwrap().0
}

/// One point at the origin of a surface across +z, of k_d 1, with a light of luminance 1 that is not seen.
fn at_origin(light: &str, occluders: &str) -> f64 {
    let text = format!(
        "[image]\nresolution = [1, 1]\n\
         [camera.orthographic]\neye = [0, 0, 1e-3]\nlook_at = [0, 0, 0]\nheight = 1e-9\n\
         [materials.m.phong]\ndiffuse = 1\n\
         [objects.floor.plane]\nmaterial = \"m\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n\
         [lights.l.{light}\nluminance = 1\nvisible = false\n{occluders}"
    );
    f64::from(film_with(&text, &Options::default()).pixels()[0][0])
}

/// E/L at the origin, from closed forms checked by quadrature to twelve digits.
#[test]
fn irradiance_is_the_published_one() {
    let square = "rectangle]\ncenter = [0, 0, 1]\ndirection = [0, 0, -1]\nsize = [1, 1]";
    let wall =
        "rectangle]\ncenter = [1, 1, 1]\ndirection = [-1, 0, 0]\nup = [0, 0, 1]\nsize = [2, 1]";
    let sunk =
        "rectangle]\ncenter = [1, 0, 0]\ndirection = [-1, 0, 0]\nup = [0, 0, 1]\nsize = [2, 2]";
    let sphere = |radius: f64, distance: f64, degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        format!(
            "sphere]\ncenter = [{:?}, 0, {:?}]\nradius = {radius:?}",
            distance * sin,
            distance * cos
        )
    };
    let disk = |center: [f64; 3], way: [f64; 3], radius: f64| {
        format!("disk]\ncenter = {center:?}\ndirection = {way:?}\nradius = {radius:?}")
    };
    let triangle = |corners: [[f64; 3]; 3]| {
        format!("[objects.t.triangle]\nmaterial = \"m\"\nvertices = {corners:?}\n")
    };
    let ball = "[objects.b.sphere]\nmaterial = \"m\"\ncenter = [0.2, 0.4, 2]\nradius = 0.5\n";
    let cases = [
        (square.to_owned(), String::new(), 0.7522746884541),
        (wall.to_owned(), String::new(), 0.2423172952985),
        (sunk.to_owned(), String::new(), 0.3501882877139),
        (sphere(1.0, 3.0, 30.0), String::new(), 0.302299894039),
        (sphere(1.0, 2.0, 75.0), String::new(), 0.221200880053),
        (sphere(1.0, 2.0, 90.0), String::new(), 0.09058607370608),
        (sphere(1.0, 2.0, 110.0), String::new(), 0.006753065521712),
        (sphere(0.9, 1.0, 100.0), String::new(), 0.5184408855793),
        (
            disk([0.0, 0.0, 2.0], [0.0, 0.0, -1.0], 1.0),
            String::new(),
            0.2 * PI,
        ),
        (
            disk([1.5, 0.0, 2.0], [0.0, 0.0, -1.0], 1.0),
            String::new(),
            0.3213351027517,
        ),
        (
            disk([1.0, 0.0, 2.0], [-1.0, 0.0, -1.0], 0.5),
            String::new(),
            0.1271831419767,
        ),
        (
            square.to_owned(),
            triangle([[-0.1, -0.1, 0.5], [0.15, -0.05, 0.5], [0.0, 0.15, 0.5]]),
            0.6423574661489,
        ),
        (
            square.to_owned(),
            triangle([[0.0, -0.1, 0.5], [0.4, 0.05, 0.5], [0.05, 0.3, 0.5]]),
            0.554641868674,
        ),
        (
            "sphere]\ncenter = [0, 1, 4]\nradius = 1".to_owned(),
            ball.to_owned(),
            0.04796521428976,
        ),
    ];
    for (light, occluders, expected) in cases {
        let actual = at_origin(&light, &occluders);
        let error = (actual / expected - 1.0).abs();
        assert!(error <= ROUNDING, "{light}: {actual}, expected {expected}");
    }
}

/// A scene of a kind: floor, spheres and triangles under lights of all shapes.
fn generated(seed: u64) -> String {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    let mut uniform = |least: f64, most: f64| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        least + (most - least) * ((state >> 11) as f64 / (1_u64 << 53) as f64)
    };
    let mut text = String::from(
        "[image]\nresolution = [20, 16]\n\
         [camera.perspective]\neye = [0.5, 2, 5]\nlook_at = [0, 0.4, 0]\nvertical_fov = 40\n\
         [materials.m0.phong]\ndiffuse = [0.3, 0.2, 0.1]\n\
         [materials.m1.phong]\ndiffuse = 0.2\nspecular = 0.4\nshininess = 60\n\
         [materials.m2.normalized_phong]\ndiffuse = 0.4\nspecular = 0.3\nshininess = 12.5\n\
         [objects.floor.plane]\nmaterial = \"m1\"\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n",
    );
    for light in 0..2 {
        let center = [uniform(-1.5, 1.5), uniform(1.2, 2.5), uniform(-1.5, 1.5)];
        let kind = match uniform(0.0, 3.0) as u32 {
            0 => format!(
                "rectangle]\nlook_at = [0, 0, 0]\nsize = [{:?}, {:?}]",
                uniform(0.1, 1.2),
                uniform(0.1, 1.2)
            ),
            1 => format!(
                "disk]\nlook_at = [0, 0, 0]\ntwo_sided = true\nradius = {:?}",
                uniform(0.1, 0.7)
            ),
            _ => format!("sphere]\nradius = {:?}", uniform(0.05, 0.5)),
        };
        writeln!(
            text,
            "[lights.l{light}.{kind}\ncenter = {center:?}\nluminance = [20, 15, 10]\nvisible = {}",
            uniform(0.0, 1.0) < 0.7
        )
        .unwrap();
    }
    for object in 0..4 {
        let center = [uniform(-1.0, 1.0), uniform(0.1, 1.1), uniform(-1.0, 1.0)];
        if uniform(0.0, 1.0) < 0.5 {
            writeln!(
                text,
                "[objects.o{object}.sphere]\nmaterial = \"m2\"\ncenter = {center:?}\nradius = {:?}",
                uniform(0.1, 0.4)
            )
            .unwrap();
        } else {
            let mut corner = || [0, 1, 2].map(|axis: usize| center[axis] + uniform(-0.6, 0.6));
            let corners = [corner(), corner(), corner()];
            writeln!(
                text,
                "[objects.o{object}.triangle]\nmaterial = \"m0\"\nvertices = {corners:?}"
            )
            .unwrap();
        }
    }
    text
}

/// In light, in penumbrae and in highlights the renderer is where the oracle is, but for what that may be off by. It is
/// relative to the pixel: of the light that would be there with nothing in the way it is less.
#[test]
fn penumbrae_are_those_of_the_oracle() {
    /// Twice the worst of 36 scenes of such a kind.
    const TOLERANCE: f64 = 1e-4;
    for seed in 0..20 {
        let text = generated(seed);
        let scene = Scene::parse(&text, "test.toml").unwrap();
        let oracle = Oracle::new(&scene);
        let film = film_with(&text, &Options::default());
        let values = film.pixels().iter().map(|pixel| pixel[0]);
        let floor = 1e-3 * f64::from(values.fold(0.0, f32::max));
        for (place, pixel) in film.pixels().iter().enumerate() {
            let (x, y) = (place % 20, place / 20);
            let expected = oracle.radiance(x as f64 + 0.5, y as f64 + 0.5);
            let off = (0..3).map(|channel| {
                let truth = expected.radiance[channel];
                let off = (f64::from(pixel[channel]) - truth).abs() - expected.error[channel];
                off / truth.max(floor)
            });
            let off = off.fold(0.0, f64::max);
            assert!(
                off <= TOLERANCE,
                "seed {seed}, pixel {x},{y}: {off}\n{text}"
            );
        }
    }
}

#[test]
fn threads_instructions_and_parts_make_no_difference() {
    let layers = Layers {
        lights: true,
        irradiance: true,
        shadow: true,
        ..Layers::default()
    };
    for (seed, target) in [(1, None), (2, None), (3, Some(ErrorTarget::new(0.05)))] {
        let text = generated(seed);
        let options = Options {
            target,
            layers: layers.clone(),
            ..Options::default()
        };
        let bits = |film: &Film, place: usize| -> Vec<u32> {
            let values = film.pixels()[place].into_iter().chain(film.values(place));
            values.map(f32::to_bits).collect()
        };
        let whole = film_with(&text, &options);
        let mut others = Vec::new();
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            others.push(pool.build().unwrap().install(|| film_with(&text, &options)));
        }
        for (_, simd) in SimdLevel::available() {
            others.push(film_with(
                &text,
                &Options {
                    simd,
                    ..options.clone()
                },
            ));
        }
        for other in &others {
            for place in 0..whole.pixels().len() {
                assert_eq!(
                    bits(&whole, place),
                    bits(other, place),
                    "seed {seed}, {place}"
                );
            }
        }
        let window = Window {
            x: 3,
            y: 5,
            width: 13,
            height: 9,
        };
        let part = Options {
            window: Some(window),
            ..options
        };
        let part = film_with(&text, &part);
        for (place, [x, y]) in window.pixels().enumerate() {
            let pixel = (y * 20 + x) as usize;
            assert_eq!(
                bits(&part, place),
                bits(&whole, pixel),
                "seed {seed}, {x},{y}"
            );
        }
    }
}

/// Lights and what those that are seen send themselves add up to the picture.
#[test]
fn layers_add_up() {
    let text = generated(5);
    for layers in [
        Layers {
            lights: true,
            ..Layers::default()
        },
        Layers {
            diffuse: true,
            specular: true,
            ..Layers::default()
        },
    ] {
        let film = film_with(
            &text,
            &Options {
                layers,
                ..Options::default()
            },
        );
        for (place, pixel) in film.pixels().iter().enumerate() {
            let values: Vec<f32> = film.values(place);
            for channel in 0..3 {
                let sum: f64 = values[channel..]
                    .iter()
                    .step_by(3)
                    .map(|&part| f64::from(part))
                    .sum();
                let whole = f64::from(pixel[channel]);
                assert!(
                    (sum - whole).abs() <= 1e-6 * whole,
                    "{place}: {sum}, {whole}"
                );
            }
        }
    }
}

/// What is seen of a light itself is its luminance from the front, and black from behind.
#[test]
fn a_light_is_seen_from_its_front() {
    for (direction, expected) in [("[0, 0, 1]", 7.0), ("[0, 0, -1]", 0.0)] {
        for shape in ["rectangle]\nsize = [1, 1]", "disk]\nradius = 0.6"] {
            let text = format!(
                "[image]\nresolution = [1, 1]\n\
                 [camera.perspective]\neye = [0, 0, 3]\nlook_at = [0, 0, 0]\nvertical_fov = 1\n\
                 [materials.m.phong]\ndiffuse = 1\n\
                 [objects.o.sphere]\nmaterial = \"m\"\ncenter = [0, 0, -9]\nradius = 1\n\
                 [lights.l.{shape}\ncenter = [0, 0, 0]\ndirection = {direction}\nluminance = 7\n"
            );
            let pixel = film_with(&text, &Options::default()).pixels()[0];
            assert_eq!(
                pixel,
                [expected, expected, expected, 1.0],
                "{shape} {direction}"
            );
        }
    }
}

/// An `up` along the way of the light is as if nothing were said: y, or -z along that.
#[test]
fn an_up_along_the_axis_is_the_default() {
    for (direction, up) in [
        ([0.0, -1.0, 0.0], [0.0, 3.0, 0.0]),
        ([1.0, -1.0, 0.5], [-2.0, 2.0, -1.0]),
    ] {
        let scene = |up: &str| {
            format!(
                "[image]\nresolution = [24, 16]\n\
                 [camera.perspective]\neye = [0.5, 2, 5]\nlook_at = [0, 0.4, 0]\nvertical_fov = 40\n\
                 [materials.m.phong]\ndiffuse = 0.3\n\
                 [objects.floor.plane]\nmaterial = \"m\"\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n\
                 [lights.l.rectangle]\ncenter = [-0.3, 1.5, 0]\ndirection = {direction:?}\nsize = [1, 0.2]\n\
                 luminance = 3\n{up}"
            )
        };
        let film = |up: &str| film_with(&scene(up), &Options::default());
        let written = film(&format!("up = {up:?}"));
        assert!(written.pixels() == film("").pixels(), "{direction:?}");
    }
}
