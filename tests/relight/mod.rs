//! `candela relight`: what is relit is what a new render with these lights is.

mod channels;
mod files;
mod ways;

use std::collections::BTreeMap;
use std::path::Path;

use candela::exr::{ExrChannels, ExrOptions, Precision};
use candela::image::{Channel, ChannelKind, Film};
use candela::output::Unfinished;
use candela::relight::{RelightError, Report, Setting, relight};
use candela::render::{self, Layers, Options, Relight};
use candela::scene::Scene;
use candela::spectrum::Curve;
use candela::world::World;
use serde_json::json;

use crate::images::parse;
use crate::measured::Measured;

/// The largest relative error of a pixel, by sums of three or four shares in FLOAT.
const FLOAT: f64 = 1.2e-7;

/// The same in HALF.
const HALF: f64 = 8.4e-4;

const KEY: &str = "{ candela = 30, color = \"#ffe0c0\" }";
const FILL: &str = "{ candela = 12, color = [0.2, 0.5, 1] }";
const RIM: &str = "{ candela = 20, color = { blackbody = 5000 } }";

/// A ball and a leaf on a floor before a gray background, in three lights of these intensities.
fn scene(transport: &str, lights: [&str; 3], materials: [&str; 2]) -> Scene {
    let [key, fill, rim] = lights;
    let [ball, floor] = materials;
    parse(&format!(
        "[image]
         resolution = [48, 32]
         background = 0.125
         transport = '{transport}'
         color_space = 'rec2020'
         [camera.perspective]
         eye = [0, 1, 4]
         look_at = [0, 0.6, 0]
         vertical_fov = 40
         [materials.ball.phong]
         {ball}
         [materials.floor.phong]
         {floor}
         [lights.key.point]
         position = [3, 4, 3]
         intensity = {key}
         [lights.fill.point]
         position = [-3, 2, 1]
         intensity = {fill}
         [lights.rim.spot]
         position = [0, 3, -2]
         look_at = [0, 0.5, 0]
         outer = 40
         intensity = {rim}
         [objects.ball.sphere]
         material = 'ball'
         center = [0, 0.5, 0]
         radius = 0.5
         [objects.floor.sphere]
         material = 'floor'
         center = [0, -20, 0]
         radius = 20
        "
    ))
}

const BALL: &str = "diffuse = [0.2, 0.1, 0.05]\nspecular = 0.4\nshininess = 30";
const FLOOR: &str = "diffuse = 0.15";

fn in_rgb(lights: [&str; 3]) -> Scene {
    scene("rgb", lights, [BALL, FLOOR])
}

/// A film with each light's layer, and what its file says of the lights.
fn lit(scene: &Scene, candela: [f64; 3]) -> Film {
    let (world, camera) = World::new(scene).unwrap_or_else(|error| panic!("{error}"));
    let options = Options {
        samples: 2,
        layers: Layers {
            lights: true,
            relight: Relight::Never,
            ..Layers::default()
        },
        ..Options::default()
    };
    let film = render::render(&world, &camera, &options).unwrap();
    let lights = world.lights().iter().zip(candela);
    let lights: Vec<_> = lights
        .map(|(light, candela)| {
            json!({
                "name": light.name,
                "kind": "point",
                "group": null,
                "candela": candela,
                "rgb": light.value.intensity().0.0,
            })
        })
        .collect();
    let transport = if world.spectra().is_some() {
        "spectral"
    } else {
        "rgb"
    };
    let film = with_attribute(&film, "candela:lights", &json!(lights).to_string());
    with_attribute(&film, "candela:transport", transport)
}

fn all_values(film: &Film) -> Vec<f32> {
    let pixels = 0..film.pixels().len();
    pixels
        .flat_map(|pixel| film.values(pixel).to_vec())
        .collect()
}

/// The film with another attribute; one of this name goes.
fn with_attribute(film: &Film, name: &str, value: &str) -> Film {
    let mut channels = film.channels().clone();
    channels.attributes.retain(|(other, _)| other != name);
    channels
        .attributes
        .push((name.to_owned(), value.to_owned()));
    film.clone().with_channels(channels, all_values(film))
}

/// The film with one more channel.
fn with_channel(film: &Film, name: &str, kind: ChannelKind, values: &[f32]) -> Film {
    let mut channels = film.channels().clone();
    channels.list.push(Channel {
        name: name.to_owned(),
        kind,
    });
    let pixels = values.iter().enumerate();
    let values = pixels.flat_map(|(pixel, &value)| {
        let mut values = film.values(pixel).to_vec();
        values.push(value);
        values
    });
    let values = values.collect();
    film.clone().with_channels(channels, values)
}

/// The film without the channels of a layer.
fn without(film: &Film, layer: &str) -> Film {
    let mut channels = film.channels().clone();
    let stays = |channel: &Channel| !channel.name.starts_with(&format!("{layer}."));
    let kept: Vec<bool> = channels.list.iter().map(stays).collect();
    channels.list.retain(stays);
    channels.sums.clear();
    let values = all_values(film).into_iter().zip(kept.iter().cycle());
    let values = values.filter_map(|(value, kept)| kept.then_some(value));
    let values = values.collect();
    film.clone().with_channels(channels, values)
}

/// The values of a channel of a film.
fn channel(film: &Film, name: &str) -> Vec<f32> {
    let list = &film.channels().list;
    let place = list
        .iter()
        .position(|channel| channel.name == name)
        .unwrap();
    let pixels = 0..film.pixels().len();
    pixels.map(|pixel| film.values(pixel)[place]).collect()
}

fn settings(texts: &[&str]) -> Vec<Setting> {
    texts.iter().map(|text| text.parse().unwrap()).collect()
}

fn write(film: &Film, path: &Path, options: &ExrOptions) {
    film.write_exr(path, options, &Unfinished::new()).unwrap();
}

fn change(path: &Path, texts: &[&str]) -> Result<Report, RelightError> {
    relight(path, path, &settings(texts), &Unfinished::new())
}

/// Every channel of a file.
fn planes(path: &Path) -> BTreeMap<String, Vec<f32>> {
    let file = ExrChannels::open(path).unwrap();
    let names: Vec<_> = file.names().iter().collect();
    let planes = file.read(&names).unwrap();
    let names = names.iter().map(|channel| channel.name.clone());
    names.zip(planes).collect()
}

/// The largest error of the pixels of a file in R, G and B and of its layers of lights, relative to the pixel of the
/// film that it should be.
fn see(measured: &mut Measured, path: &Path, expected: &Film, what: &str) {
    let actual = planes(path);
    let layers = expected.channels().list.iter();
    let layers = layers.filter_map(|channel| channel.name.strip_suffix(".R"));
    let layers: Vec<String> = layers.map(|layer| format!("{layer}.")).collect();
    assert!(!layers.is_empty());
    for layer in layers.iter().map(String::as_str).chain([""]) {
        let of_film = ["R", "G", "B"].map(|c| match layer {
            "" => {
                let place = "RGB".find(c).unwrap();
                expected.pixels().iter().map(|pixel| pixel[place]).collect()
            }
            layer => channel(expected, &format!("{layer}{c}")),
        });
        let of_file = ["R", "G", "B"].map(|c| &actual[&format!("{layer}{c}")]);
        for pixel in 0..expected.pixels().len() {
            let pairs = [0, 1, 2].map(|c: usize| [of_film[c][pixel], of_file[c][pixel]]);
            let [largest, error] = pairs
                .iter()
                .fold([0.0_f64; 2], |[largest, error], &[a, b]| {
                    let [a, b] = [f64::from(a), f64::from(b)];
                    [largest.max(a.abs()), error.max((a - b).abs())]
                });
            let relative = if error == 0.0 { 0.0 } else { error / largest };
            measured.see(relative, || format!("{what}: {layer}{pixel}"));
        }
    }
}

/// Settings, and the intensities of a scene that would be rendered so, with their candelas.
type Case = (&'static [&'static str], [&'static str; 3], [f64; 3]);

const CASES: [Case; 7] = [
    (
        &["key=2"],
        ["{ candela = 60, color = \"#ffe0c0\" }", FILL, RIM],
        [60.0, 12.0, 20.0],
    ),
    (&["fill=off"], [KEY, "0", RIM], [30.0, 0.0, 20.0]),
    (
        &["rim=#ff8040"],
        [KEY, FILL, "{ candela = 20, color = \"#ff8040\" }"],
        [30.0, 12.0, 20.0],
    ),
    (
        &["key={blackbody=3200}"],
        ["{ candela = 30, color = { blackbody = 3200 } }", FILL, RIM],
        [30.0, 12.0, 20.0],
    ),
    (
        &["key = 0.5 , [1, 0.5, 0.25]", "rim=1e3"],
        [
            "{ candela = 15, color = [1, 0.5, 0.25] }",
            FILL,
            "{ candela = 20000, color = { blackbody = 5000 } }",
        ],
        [15.0, 12.0, 20000.0],
    ),
    (
        &["key=off", "fill=0", "rim=1e-6,{daylight=9000}"],
        ["0", "0", "{ candela = 20e-6, color = { daylight = 9000 } }"],
        [0.0, 0.0, 20e-6],
    ),
    (&["key=1"], [KEY, FILL, RIM], [30.0, 12.0, 20.0]),
];

#[test]
fn relit_is_rendered_anew() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let film = lit(&in_rgb([KEY, FILL, RIM]), [30.0, 12.0, 20.0]);
    for (precision, figure) in [(Precision::Float, FLOAT), (Precision::Half, HALF)] {
        let options = ExrOptions {
            precision,
            ..ExrOptions::default()
        };
        let mut measured = Measured::new(format!("relit in {precision:?}"), figure);
        for (texts, lights, candela) in CASES {
            // Halves below 6.1e-5 have few digits.
            if precision == Precision::Half && texts.contains(&"key=off") {
                continue;
            }
            write(&film, &path, &options);
            change(&path, texts).unwrap();
            see(
                &mut measured,
                &path,
                &lit(&in_rgb(lights), candela),
                texts[0],
            );
        }
        measured.judge();
    }
}

/// The background is a share as any other: its radiance is 0.125 times the factor.
#[test]
fn the_background_is_dimmed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let film = lit(&in_rgb([KEY, FILL, RIM]), [30.0, 12.0, 20.0]);
    write(&film, &path, &ExrOptions::default());
    change(&path, &["background=2"]).unwrap();
    let planes = planes(&path);
    let sky = planes["A"].iter().position(|&alpha| alpha == 0.0).unwrap();
    assert_eq!(
        ["R", "light_background.G"].map(|c| planes[c][sky]),
        [0.25; 2]
    );
    let error = change(&path, &["background=#ffffff"]).unwrap_err();
    assert!(error.to_string().contains("background=0.5"), "{error}");
}

/// What was relit is relit again, and says how it came about.
#[test]
fn relit_files_relight_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let film = lit(&in_rgb([KEY, FILL, RIM]), [30.0, 12.0, 20.0]);
    write(&film, &path, &ExrOptions::default());
    change(&path, &["key=3,#4080ff", "fill=off"]).unwrap();
    change(&path, &["key=0.5,#ff8040"]).unwrap();
    let lights = ["{ candela = 45, color = \"#ff8040\" }", "0", RIM];
    let expected = lit(&in_rgb(lights), [45.0, 0.0, 20.0]);
    let mut measured = Measured::new("relit twice", 1.5e-7);
    see(&mut measured, &path, &expected, "twice");
    measured.judge();
    // The header says what a render of these lights would.
    let said = files::text(&path, "candela:lights");
    let said: Vec<serde_json::Value> = serde_json::from_str(&said).unwrap();
    let attributes = &expected.channels().attributes;
    let should = attributes.iter().find(|(name, _)| name == "candela:lights");
    let should: Vec<serde_json::Value> = serde_json::from_str(&should.unwrap().1).unwrap();
    for (said, should) in said.iter().zip(&should) {
        assert_eq!(said["name"], should["name"]);
        assert_eq!(said["candela"], should["candela"]);
        for channel in 0..3 {
            let [a, b] = [said, should].map(|light| light["rgb"][channel].as_f64().unwrap());
            assert!((a - b).abs() <= 1e-13 * b.abs(), "{a} {b}");
        }
    }
    // A light that is off stays so.
    let error = change(&path, &["fill=#ffffff"]);
    assert!(error.is_ok());
    let steps = files::text(&path, "candela:relit");
    let steps: Vec<serde_json::Value> = serde_json::from_str(&steps).unwrap();
    assert_eq!(steps.len(), 3);
    assert_eq!(steps[0]["lights"], json!(["key=3,#4080ff", "fill=off"]));
    assert_eq!(steps[1]["lights"], json!(["key=0.5,#ff8040"]));
    assert_eq!(steps[0]["source_sha256"].as_str().unwrap().len(), 64);
}

/// Light of a key that is a billion times as bright leaves nothing behind where it goes off, as it would by R − L.
#[test]
fn what_goes_off_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let film = lit(&in_rgb(["3e10", FILL, RIM]), [3e10, 12.0, 20.0]);
    write(&film, &path, &ExrOptions::default());
    change(&path, &["key=off"]).unwrap();
    let mut measured = Measured::new("after a key of 3e10 cd", FLOAT);
    let expected = lit(&in_rgb(["0", FILL, RIM]), [0.0, 12.0, 20.0]);
    see(&mut measured, &path, &expected, "off");
    measured.judge();
}

/// Of a file with some of its lights as layers, the others stay.
#[test]
fn some_of_the_lights_are_enough() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let film = lit(&in_rgb([KEY, FILL, RIM]), [30.0, 12.0, 20.0]);
    let film = without(&without(&film, "light_fill"), "light_background");
    write(&film, &path, &ExrOptions::default());
    change(&path, &["key=2"]).unwrap();
    let expected = lit(&in_rgb(CASES[0].1), CASES[0].2);
    let expected = without(&without(&expected, "light_fill"), "light_background");
    let mut measured = Measured::new("of some lights", FLOAT);
    see(&mut measured, &path, &expected, "some");
    measured.judge();
    let error = change(&path, &["fill=2"]).unwrap_err();
    assert!(matches!(error, RelightError::NoLayer(_)), "{error}");
}

/// A group has one layer, and what is said of each of its lights.
fn grouped(candela: [f64; 3], lights: [&str; 3]) -> Film {
    let film = lit(&in_rgb(lights), candela);
    let mut grouped = without(&without(&film, "light_key"), "light_fill");
    for c in ["R", "G", "B"] {
        let [key, fill] = ["key", "fill"].map(|name| channel(&film, &format!("light_{name}.{c}")));
        let sum: Vec<f32> = key
            .iter()
            .zip(&fill)
            .map(|(&a, &b)| (f64::from(a) + f64::from(b)) as f32)
            .collect();
        grouped = with_channel(
            &grouped,
            &format!("light_window.{c}"),
            ChannelKind::Light,
            &sum,
        );
    }
    let attributes = &film.channels().attributes;
    let said = &attributes
        .iter()
        .find(|(name, _)| name == "candela:lights")
        .unwrap()
        .1;
    let mut said: Vec<serde_json::Value> = serde_json::from_str(said).unwrap();
    for light in &mut said[..2] {
        light["group"] = "window".into();
    }
    with_attribute(&grouped, "candela:lights", &json!(said).to_string())
}

#[test]
fn groups_change_as_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let warm = "{ candela = 12, color = \"#ffe0c0\" }";
    write(
        &grouped([30.0, 12.0, 20.0], [KEY, warm, RIM]),
        &path,
        &ExrOptions::default(),
    );
    change(&path, &["window=2,#4080ff"]).unwrap();
    let lights = [
        "{ candela = 60, color = \"#4080ff\" }",
        "{ candela = 24, color = \"#4080ff\" }",
        RIM,
    ];
    let mut measured = Measured::new("a group", 1.6e-7);
    see(
        &mut measured,
        &path,
        &grouped([60.0, 24.0, 20.0], lights),
        "group",
    );
    measured.judge();
    let error = change(&path, &["fill=2"]).unwrap_err().to_string();
    assert!(
        error.contains("as a part of its group `window` only"),
        "{error}"
    );
    // Of lights of several colors only the sum is known.
    write(
        &grouped([30.0, 12.0, 20.0], [KEY, FILL, RIM]),
        &path,
        &ExrOptions::default(),
    );
    let error = change(&path, &["window=#4080ff"]).unwrap_err();
    assert!(matches!(error, RelightError::MixedGroup(_)), "{error}");
    change(&path, &["window=2"]).unwrap();
}

/// The reflectance of the ball where light is carried spectrally.
const LEAF: [&str; 2] = [
    "[400, 500, 550, 600, 680, 740]",
    "[0.03, 0.04, 0.11, 0.05, 0.03, 0.3]",
];

fn in_spectra(lights: [&str; 3]) -> Scene {
    let [wavelengths, values] = LEAF;
    let leaf = format!("diffuse = {{ wavelengths = {wavelengths}, values = {values} }}");
    scene("spectral", lights, [&leaf, FLOOR])
}

/// A film of lights of these candelas with all that their new colors need: what a renderer of RGB makes of the
/// flat reflectance, and of one of 1 in place of the curve, in white light.
fn reflected(candela: [f64; 3], lights: [&str; 3]) -> Film {
    let mut film = lit(&in_spectra(lights), candela);
    let white = candela.map(|candela| candela.to_string());
    let white = [0, 1, 2].map(|light: usize| white[light].as_str());
    for (channel_name, materials) in [
        ("flat", ["diffuse = 0", FLOOR]),
        ("1", ["diffuse = 1", "diffuse = 0"]),
    ] {
        let geometry = lit(&scene("rgb", white, materials), candela);
        for light in ["key", "fill", "rim"] {
            let values = channel(&geometry, &format!("light_{light}.G"));
            let name = format!("relight_{light}.{channel_name}");
            film = with_channel(&film, &name, ChannelKind::Data, &values);
        }
    }
    let numbers = |text: &str| serde_json::from_str::<Vec<f64>>(text).unwrap();
    let curve = Curve::new(numbers(LEAF[0]), numbers(LEAF[1]))
        .unwrap()
        .spectrum();
    let curves = json!({ "observer": "1931", "curves": [curve.values().to_vec()] });
    with_attribute(&film, "candela:reflectances", &curves.to_string())
}

#[test]
fn spectral_light_is_rendered_anew() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let film = reflected([30.0, 12.0, 20.0], [KEY, FILL, RIM]);
    let mut measured = Measured::new("relit spectrally", FLOAT);
    for (texts, lights, candela) in CASES {
        write(&film, &path, &ExrOptions::default());
        change(&path, texts).unwrap();
        let expected = lit(&in_spectra(lights), candela);
        see(&mut measured, &path, &expected, texts[0]);
    }
    // Sodium: what RGB would be far off at.
    let lines = "{lines=[[589.0, 1], [589.6, 0.5]]}";
    write(&film, &path, &ExrOptions::default());
    change(&path, &["key=2"]).unwrap();
    change(&path, &[&format!("key=0.5,{lines}")]).unwrap();
    let sodium = format!("{{ candela = 30, color = {lines} }}");
    let expected = lit(&in_spectra([&sodium, FILL, RIM]), [30.0, 12.0, 20.0]);
    see(&mut measured, &path, &expected, "sodium");
    // What `render --layers lights` stores by itself.
    let own = |lights: [&str; 3]| {
        let (world, camera) = World::new(&in_spectra(lights)).unwrap();
        let options = Options {
            samples: 2,
            layers: Layers {
                lights: true,
                ..Layers::default()
            },
            ..Options::default()
        };
        render::render(&world, &camera, &options).unwrap()
    };
    for (texts, lights, _) in CASES {
        write(&own([KEY, FILL, RIM]), &path, &ExrOptions::default());
        change(&path, texts).unwrap();
        see(&mut measured, &path, &own(lights), texts[0]);
    }
    measured.judge();
    // Without what was reflected, there is no exact answer.
    write(
        &lit(&in_spectra([KEY, FILL, RIM]), [30.0, 12.0, 20.0]),
        &path,
        &ExrOptions::default(),
    );
    let error = change(&path, &["key=#ff8040"]).unwrap_err().to_string();
    assert!(
        error.contains("`--layers lights`, which stores them"),
        "{error}"
    );
    change(&path, &["key=2"]).unwrap();
}
