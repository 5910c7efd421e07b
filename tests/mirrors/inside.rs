//! What is seen from inside of glass that absorbs light: layers are of what arrives.

use candela::image::Film;
use candela::render::{Layers, Options};

use super::{ROUNDING, assert_near};
use crate::images::film_of_text;

fn layers() -> Options {
    Options {
        samples: 2,
        layers: Layers {
            lights: true,
            diffuse: true,
            specular: true,
            ..Layers::default()
        },
        ..Options::default()
    }
}

/// A channel of all pixels.
fn channel(film: &Film, name: &str) -> Vec<f64> {
    let mut list = film.channels().list.iter();
    let place = list.position(|channel| channel.name == name);
    let place = place.unwrap_or_else(|| panic!("no {name}"));
    let pixels = 0..film.pixels().len();
    pixels
        .map(|pixel| f64::from(film.values(pixel)[place]))
        .collect()
}

/// A lamp, a panel and a ball in a ball of glass, and a floor beyond.
fn ball(transport: &str) -> String {
    format!(
        "[image]\nresolution = [24, 16]\nmax_depth = 3\nbackground = [0.1, 0.2, 0.3]\ntransport = \"{transport}\"\n\
         [camera.perspective]\neye = [0.1, 0.2, 1.5]\nlook_at = [0.2, 0, -1]\nvertical_fov = 70\n\
         [materials.g.glass]\nn = 1.5\nabsorption = [0.4, 0.2, 0.1]\n\
         [materials.m.phong]\ndiffuse = 0.2\nspecular = 0.3\nshininess = 20\n\
         [lights.l.point]\nposition = [0.5, 1.2, 0.6]\nintensity = 5\n\
         [lights.panel.rectangle]\ncenter = [-0.6, 0.2, -0.6]\nlook_at = [0.1, 0.2, 1.5]\nsize = [0.6, 0.4]\n\
         luminance = [2, 3, 4]\n\
         [objects.around.sphere]\nmaterial = \"g\"\ncenter = [0, 0, 0]\nradius = 2\n\
         [objects.within.sphere]\nmaterial = \"m\"\ncenter = [0.3, 0, -0.7]\nradius = 0.6\n\
         [objects.beyond.plane]\nmaterial = \"m\"\npoint = [0, -3, 0]\nnormal = [0, 1, 0]\n"
    )
}

#[test]
fn layers_from_inside_of_glass_add_up() {
    for transport in ["rgb", "spectral"] {
        let film = film_of_text(&ball(transport), &layers());
        for (place, letter) in ["R", "G", "B"].into_iter().enumerate() {
            for parts in [
                &["light_l", "light_panel", "light_background", "emission"][..],
                &[
                    "diffuse",
                    "specular",
                    "background",
                    "emission",
                    "reflection",
                    "refraction",
                ],
            ] {
                let parts = parts.iter();
                let parts = parts.map(|part| channel(&film, &format!("{part}.{letter}")));
                let parts: Vec<Vec<f64>> = parts.collect();
                for (pixel, rgba) in film.pixels().iter().enumerate() {
                    let total: f64 = parts.iter().map(|part| part[pixel]).sum();
                    let size: f64 = parts.iter().map(|part| part[pixel].abs()).sum();
                    let error = (total - f64::from(rgba[place])).abs();
                    assert!(error <= ROUNDING * size, "{transport} {pixel}: {error}");
                }
            }
        }
        let seen = channel(&film, "emission.R");
        assert!(seen.into_iter().filter(|&it| it > 0.0).count() > 4);
    }
}

/// L e^(−σd) of a panel that is 1.5 m from the eye in the glass, and nothing else.
#[test]
fn emission_is_what_the_glass_leaves() {
    for transport in ["rgb", "spectral"] {
        let text = format!(
            "[image]\nresolution = [1, 1]\ntransport = \"{transport}\"\n\
             [camera.orthographic]\neye = [0, 0, 1]\nlook_at = [0, 0, -1]\nheight = 1e-12\n\
             [materials.g.glass]\nn = 1.5\nabsorption = [0.4, 0.2, 0.1]\n\
             [objects.ball.sphere]\nmaterial = \"g\"\ncenter = [0, 0, 0]\nradius = 2\n\
             [lights.panel.rectangle]\ncenter = [0, 0, -0.5]\ndirection = [0, 0, 1]\nsize = [1, 1]\nluminance = 8\n"
        );
        let film = film_of_text(&text, &layers());
        for (place, (letter, sigma)) in [("R", 0.4_f64), ("G", 0.2), ("B", 0.1)]
            .into_iter()
            .enumerate()
        {
            for layer in ["emission", "emission_panel"] {
                let emission = channel(&film, &format!("{layer}.{letter}"))[0];
                assert_eq!(emission, f64::from(film.pixels()[0][place]), "{transport}");
                if transport == "rgb" {
                    assert_near(emission, 8.0 * (-sigma * 1.5).exp(), layer);
                }
            }
        }
    }
}
