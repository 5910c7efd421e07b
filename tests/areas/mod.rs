//! Lights with an area: published integrals through the whole program, the oracle's word in penumbrae of all kinds,
//! and the same bits whatever renders them.

mod brute_force;
mod published;

use std::fmt::Write;

use candela::image::Window;
use candela::oracle::Oracle;
use candela::render::{ErrorTarget, Layers, Options};
use candela::scene::Scene;

use crate::images::{assert_same_everywhere, film_of_text};
use crate::measured::{HALF_LAST_BIT, Measured};

/// Relative error where nothing but the rounding to f32 is between the integral and the pixel.
const ROUNDING: f64 = Measured::ROOM * HALF_LAST_BIT;

/// One point, at the origin, of a surface that a light of luminance 1 shines on.
struct AtOrigin<'a> {
    normal: [f64; 3],
    /// Its kind and its values.
    material: &'a str,
    to_viewer: [f64; 3],
    /// Its shape and its values. It is not seen itself.
    light: &'a str,
    objects: &'a str,
}

impl AtOrigin<'_> {
    /// A picture of one pixel of it, which is the radiance of the point.
    fn scene(&self) -> String {
        let Self {
            normal,
            material,
            to_viewer,
            light,
            objects,
        } = self;
        let eye = to_viewer.map(|part| 1e-3 * part);
        format!(
            "[image]\nresolution = [1, 1]\n\
             [camera.orthographic]\neye = {eye:?}\nlook_at = [0, 0, 0]\nheight = 1e-9\n\
             [materials.m.{material}\n\
             [objects.floor.plane]\nmaterial = \"m\"\npoint = [0, 0, 0]\nnormal = {normal:?}\n\
             [lights.l.{light}\nluminance = 1\nvisible = false\n{objects}"
        )
    }

    fn radiance(&self) -> f64 {
        let film = film_of_text(&self.scene(), &Options::default());
        f64::from(film.pixels()[0][0])
    }
}

/// The objects of some triangles.
fn triangles<'t>(triangles: impl IntoIterator<Item = &'t [[f64; 3]; 3]>) -> String {
    let numbered = triangles.into_iter().enumerate();
    numbered
        .map(|(number, vertices)| {
            format!("[objects.t{number}.triangle]\nmaterial = \"m\"\nvertices = {vertices:?}\n")
        })
        .collect()
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
        let film = film_of_text(&text, &Options::default());
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
        let part = Window {
            x: 3,
            y: 5,
            width: 13,
            height: 9,
        };
        assert_same_everywhere(&text, &options, part);
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
        let film = film_of_text(
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
            let pixel = film_of_text(&text, &Options::default()).pixels()[0];
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
        let film = |up: &str| film_of_text(&scene(up), &Options::default());
        let written = film(&format!("up = {up:?}"));
        assert!(written.pixels() == film("").pixels(), "{direction:?}");
    }
}

/// How far pixels are from the oracle, relative to the light without shadow.
fn compare(text: &str, name: &str, measured: &mut Measured) {
    let scene = Scene::parse(text, "test.toml").unwrap_or_else(|error| panic!("{error}"));
    let oracle = Oracle::new(&scene);
    let film = film_of_text(text, &Options::default());
    let [width, _] = film.resolution();
    for (place, pixel) in (0..).zip(film.pixels()) {
        let (x, y) = (place % width, place / width);
        let expected = oracle.radiance(f64::from(x) + 0.5, f64::from(y) + 0.5);
        for (channel, &value) in pixel[..3].iter().enumerate() {
            let truth = expected.radiance[channel];
            let light = truth.max(expected.unshadowed[channel]);
            let off = (f64::from(value) - truth).abs() - expected.error[channel];
            if light > 0.0 {
                measured.see((off / light).max(0.0), || format!("{name}, pixel {x},{y}"));
            }
        }
    }
}

/// What comes through flat panes is the oracle's as well, beside their borders and in the shadows of other things.
#[test]
fn light_through_panes_is_that_of_the_oracle() {
    let mut measured = Measured::new("light of areas through panes".to_owned(), 3.2e-5);
    let panes = "[materials.p.pane]\nn = 1.5\n\
         [objects.first.triangle]\nmaterial = \"p\"\nvertices = [[-0.9, 0.2, -0.3], [0.4, 1.3, -0.4], [0.9, 1.1, 0.5]]\n\
         [objects.second.triangle]\nmaterial = \"p\"\nvertices = [[-0.9, 0.2, -0.3], [0.9, 1.1, 0.5], [-0.4, 0.3, 0.6]]\n\
         [objects.sheet.plane]\nmaterial = \"p\"\npoint = [0.2, 0, 0]\nnormal = [1, 0.1, 0.2]\n";
    for seed in 20..32 {
        let text = generated(seed) + panes;
        compare(&text, &format!("seed {seed}"), &mut measured);
    }
    measured.judge();
}

/// A lamp in a globe, and a panel above a dome: balls of a pane that all of a light is seen through.
#[test]
fn light_through_balls_of_panes_is_that_of_the_oracle() {
    let mut measured = Measured::new("light of areas through balls of panes".to_owned(), 4.6e-6);
    let scene = "[image]\nresolution = [24, 16]\n\
         [camera.perspective]\neye = [0, 0.5, 1.4]\nlook_at = [0, 0, 0]\nvertical_fov = 60\n\
         [materials.m.phong]\ndiffuse = 0.2\nspecular = 0.3\nshininess = 15\n[materials.p.pane]\nn = 1.5\n\
         [objects.floor.triangle]\nmaterial = \"m\"\nvertices = [[-0.9, -0.7, -0.9], [0.9, -0.7, -0.9], [0, -0.7, 1.2]]\n\
         [objects.ball.sphere]\nmaterial = \"m\"\ncenter = [0.3, -0.3, 0]\nradius = 0.3\n";
    for (name, body) in [
        (
            "globe",
            "[lights.lamp.sphere]\ncenter = [0, 0.9, 0]\nradius = 0.1\nluminance = 20\n\
             [objects.globe.sphere]\nmaterial = \"p\"\ncenter = [0.05, 0.9, 0]\nradius = 0.4\n",
        ),
        (
            "dome",
            "[lights.panel.disk]\ncenter = [0.3, 4, 0]\ndirection = [0, -1, 0]\nradius = 0.5\nluminance = 20\n\
             [objects.dome.sphere]\nmaterial = \"p\"\ncenter = [0.05, 0, 0]\nradius = 2\n",
        ),
    ] {
        compare(&(scene.to_owned() + body), name, &mut measured);
    }
    measured.judge();
}
