//! Bands of light that comes by mirrors and glass: closed forms, the oracle wavelength by wavelength, and the picture
//! that they belong to.

use candela::image::{Film, Window};
use candela::oracle::Oracle;
use candela::render::{Layers, Options};
use candela::scene::Scene;
use candela::world::Wavelengths;

use super::everything;
use crate::images::{assert_same_everywhere, film_of_text, parse};
use crate::measured::{HALF_LAST_BIT, Measured};
use crate::spectral_image::{d65_of_one_candela, rgb_of};

fn every_nm() -> Wavelengths {
    Wavelengths::new(360, 830, 1).unwrap()
}

fn bands_of(text: &str, wavelengths: Wavelengths) -> Film {
    film_of_text(text, &with_bands(1, wavelengths))
}

fn with_bands(samples: u32, wavelengths: Wavelengths) -> Options {
    Options {
        samples,
        layers: Layers {
            spectral: Some(wavelengths),
            ..Layers::default()
        },
        ..Options::default()
    }
}

/// The bands of the one pixel of a scene are these of each wavelength in nm, up to the rounding to f32.
fn assert_bands(text: &str, expected: impl Fn(f64) -> f64) {
    let film = bands_of(text, every_nm());
    for (&band, nm) in film.values(0).iter().zip(360..) {
        let expected = expected(f64::from(nm));
        let error = (f64::from(band) / expected - 1.0).abs();
        assert!(
            error <= Measured::ROOM * HALF_LAST_BIT,
            "{nm} nm: {band}, expected {expected}"
        );
    }
}

fn white(nm: f64) -> f64 {
    d65_of_one_candela()[nm as usize - 360]
}

/// A curve that is straight from 360 to 830 nm.
fn ramp(from: f64, to: f64) -> (String, impl Fn(f64) -> f64) {
    let text = format!("{{ wavelengths = [360, 830], values = [{from:?}, {to:?}] }}");
    (text, move |nm| from + (to - from) * (nm - 360.0) / 470.0)
}

/// An eye that looks along −z, at what a plane of the material `m` at z = 0 shows of a wall behind it, lit by a lamp.
fn facing_a_wall(material: &str, wall: &str) -> String {
    format!(
        "[image]\nresolution = [1, 1]\n\
         [camera.orthographic]\neye = [0, 0, 1]\nlook_at = [0, 0, 0]\nheight = 1e-12\n\
         [materials.m.{material}\n[materials.wall.phong]\ndiffuse = {wall}\n\
         [lights.lamp.point]\nposition = [0, 0, 2]\nintensity = 12\n\
         [objects.mirror.plane]\nmaterial = \"m\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n\
         [objects.wall.plane]\nmaterial = \"wall\"\npoint = [0, 0, 4]\nnormal = [0, 0, -1]\n"
    )
}

/// S = R I k/d²: of a metal, of a colored mirror, and of a gray one that shows a colored wall.
#[test]
fn bands_are_those_of_a_lit_wall_times_what_the_mirror_reflects() {
    let (n, n_at) = ramp(0.2, 1.4);
    let (k, k_at) = ramp(1.9, 4.5);
    let (color, color_at) = ramp(0.1, 0.9);
    let lamp = |nm: f64| 12.0 * white(nm) / 4.0;
    let metal = format!("metal]\nn = {n}\nk = {k}");
    assert_bands(&facing_a_wall(&metal, "0.25"), |nm| {
        let (n, k) = (n_at(nm), k_at(nm));
        let reflected = ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k);
        lamp(nm) * 0.25 * reflected
    });
    let mirror = format!("mirror]\nreflectance = {color}");
    assert_bands(&facing_a_wall(&mirror, "0.25"), |nm| {
        lamp(nm) * 0.25 * color_at(nm)
    });
    assert_bands(&facing_a_wall(&mirror, &color), |nm| {
        lamp(nm) * color_at(nm).powi(2)
    });
    let gray = "mirror]\nreflectance = 0.75";
    assert_bands(&facing_a_wall(gray, &color), |nm| {
        lamp(nm) * color_at(nm) * 0.75
    });
    // Wide bands are means of the product under a hat.
    let film = bands_of(
        &facing_a_wall(&mirror, &color),
        Wavelengths::new(400, 700, 20).unwrap(),
    );
    for (&band, center) in film.values(0).iter().zip((400_u32..).step_by(20)) {
        let at = |nm: u32| lamp(f64::from(nm)) * color_at(f64::from(nm)).powi(2);
        let mean = (center - 19..center + 20)
            .map(|nm| (1.0 - f64::from(nm.abs_diff(center)) / 20.0) * at(nm))
            .sum::<f64>()
            / 20.0;
        let error = (f64::from(band) / mean - 1.0).abs();
        assert!(error <= Measured::ROOM * HALF_LAST_BIT, "{center}: {band}");
    }
}

/// e^(−σ(λ)d) of a body that bends nothing: of the background beyond it, of a light that is seen through it, and of
/// what the eye sees from within, a lit wall and a light.
#[test]
fn bands_are_absorbed_by_the_metre() {
    let (sigma, sigma_at) = ramp(0.2, 1.1);
    let ball = |eye: f64, more: &str| {
        format!(
            "[image]\nresolution = [1, 1]\n{more}\
             [camera.orthographic]\neye = [0, 0, {eye:?}]\nlook_at = [0, 0, -1]\nheight = 1e-12\n\
             [materials.g.glass]\nn = 1\nabsorption = {sigma}\n\
             [materials.wall.phong]\ndiffuse = 0.25\n\
             [objects.ball.sphere]\nmaterial = \"g\"\ncenter = [0, 0, 0]\nradius = 2\n"
        )
    };
    let panel = |z: f64| {
        format!(
            "[lights.panel.rectangle]\ncenter = [0, 0, {z:?}]\ndirection = [0, 0, 1]\nsize = [1, 1]\nluminance = 8\n"
        )
    };
    let left = |nm: f64, metres: f64| (-sigma_at(nm) * metres).exp();
    assert_bands(&ball(3.0, "background = 0.5\n"), |nm| {
        0.5 * white(nm) * left(nm, 4.0)
    });
    assert_bands(&(ball(3.0, "") + &panel(-3.0)), |nm| {
        8.0 * white(nm) * left(nm, 4.0)
    });
    assert_bands(&(ball(1.0, "") + &panel(-0.5)), |nm| {
        8.0 * white(nm) * left(nm, 1.5)
    });
    let wall = "[objects.wall.plane]\nmaterial = \"wall\"\npoint = [0, 0, -1]\nnormal = [0, 0, 1]\n\
        [lights.lamp.point]\nposition = [0, 0, 1.5]\nintensity = 10\n";
    assert_bands(&(ball(1.0, "") + wall), |nm| {
        0.25 * 10.0 / 6.25 * white(nm) * left(nm, 2.0)
    });
}

/// The largest difference of a band to the oracle's, over the largest of its pixel.
fn oracle_error(scene: &Scene, film: &Film, measured: &mut Measured) {
    let oracle = Oracle::new(scene);
    let [width, _] = film.resolution();
    for place in 0..film.pixels().len() {
        let [x, y] = [place as u32 % width, place as u32 / width].map(f64::from);
        let expected = oracle.spectral_radiance(x + 0.5, y + 0.5).unwrap();
        let largest = expected.iter().fold(0.0_f64, |most, &it| most.max(it));
        for (&band, (nm, &expected)) in film.values(place).iter().zip((360..).zip(&expected)) {
            let error = (f64::from(band) - expected).abs();
            let relative = if error == 0.0 { 0.0 } else { error / largest };
            measured.see(relative, || format!("pixel {place}, {nm} nm"));
        }
    }
}

/// Every band of scenes with all that is smooth, with the oracle.
#[test]
fn bands_agree_with_the_oracle() {
    let all = everything("spectral").replace("[96, 64]", "[24, 16]");
    let without = |part: &str| {
        let lines = all.lines().collect::<Vec<_>>().join("\n");
        let start = lines.find(part).unwrap();
        let end = lines[start + 1..].find("\n[").map(|end| start + 1 + end);
        lines[..start].to_owned() + end.map_or("", |end| &lines[end..])
    };
    let inside = without("[objects.pane.triangle]")
        .replace("eye = [0, 1.5, 5]", "eye = [0.1, 0.6, 0.9]")
        .replace("look_at = [0, 0.5, 0]", "look_at = [0, 0.3, -1]");
    for (name, text, figure) in [
        (
            "a lamp and a pane",
            without("[lights.panel.rectangle]"),
            6e-8,
        ),
        ("a panel", without("[objects.pane.triangle]"), 6e-8),
        ("a panel and a pane", all.clone(), 1.1e-7),
        ("inside of glass", inside, 6e-8),
    ] {
        assert!(!text.contains("[96, 64]"));
        let film = bands_of(&text, every_nm());
        let mut measured = Measured::new(format!("bands of {name}"), figure);
        oracle_error(&parse(&text), &film, &mut measured);
        measured.judge();
    }
}

/// A prism of glass that disperses light, before a lamp-lit wall of two colors.
fn prism() -> String {
    "[image]\nresolution = [12, 3]\nmax_depth = 3\nbackground = 0.02\n\
     [camera.orthographic]\neye = [0, 0.3, 4]\nlook_at = [0, 0.3, 0]\nheight = 0.3\n\
     [materials.g.glass]\nsellmeier = \"N-SF11\"\ndispersion = true\n\
     [materials.red.phong]\ndiffuse = [0.5, 0.1, 0.05]\n[materials.blue.phong]\ndiffuse = [0.02, 0.1, 0.5]\n\
     [lights.lamp.point]\nposition = [0, 3, 3]\nintensity = 50\n\
     [objects.ball.sphere]\nmaterial = \"g\"\ncenter = [0, 0, 0]\nradius = 0.8\n\
     [objects.red.triangle]\nmaterial = \"red\"\nvertices = [[-9, -9, -2], [0, -9, -2], [0, 9, -2]]\n\
     [objects.blue.triangle]\nmaterial = \"blue\"\nvertices = [[0, -9, -2], [9, -9, -2], [0, 9, -2]]\n"
        .to_owned()
}

#[test]
fn bands_of_dispersed_light_agree_with_the_oracle() {
    let film = bands_of(&prism(), every_nm());
    let mut measured = Measured::new("bands of dispersed light", 2.1e-6);
    oracle_error(&parse(&prism()), &film, &mut measured);
    measured.judge();
}

/// At 1 nm the bands integrate to R, G and B.
#[test]
fn bands_through_mirrors_integrate_to_the_picture() {
    for text in [
        everything("spectral").replace("[96, 64]", "[48, 32]"),
        prism(),
    ] {
        let film = film_of_text(&text, &with_bands(3, every_nm()));
        for (place, pixel) in film.pixels().iter().enumerate() {
            let integrated = rgb_of(&film.values(place), every_nm()).to_array();
            let largest = pixel[..3]
                .iter()
                .fold(0.0, |most, it| f64::max(most, (*it).into()));
            for (channel, integrated) in pixel.iter().zip(integrated) {
                let error = (f64::from(*channel) - integrated).abs();
                // Each band and channel is rounded by itself; R, G and B have negative coefficients.
                assert!(
                    error <= 5.0 * HALF_LAST_BIT * largest,
                    "{place}: {error}, {pixel:?}"
                );
            }
        }
    }
}

#[test]
fn threads_instructions_and_parts_make_no_difference_to_bands() {
    // The samples of one pixel may be more than a batch.
    for (samples, resolution, [x, y, width, height]) in [
        (3, "[48, 32]", [17, 11, 21, 13]),
        (300, "[12, 8]", [4, 2, 5, 4]),
    ] {
        let part = Window {
            x,
            y,
            width,
            height,
        };
        let text = everything("spectral").replace("[96, 64]", resolution);
        let options = with_bands(samples, Wavelengths::new(400, 700, 50).unwrap());
        assert_same_everywhere(&text, &options, part);
    }
}
