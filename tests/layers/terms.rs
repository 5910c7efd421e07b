//! The terms of the equation as layers: each beside the oracle, and what they add up to.

use candela::image::Film;
use candela::oracle::{Oracle, Outcome};
use candela::render::{Layers, MatteRanks, Relight};
use candela::scene::{Scene, Transport};

use super::{channels, scenes, with_layers};
use crate::images::parse;
use crate::measured::Measured;

/// Relative to the largest of the pixel: f32, and sums of a few terms.
const TERM: f64 = 5.94e-8;

/// Beyond all rounding, so that it is another side of an edge.
const SIDE: f64 = 1e-5;

fn every_term() -> Layers {
    Layers {
        lights: true,
        light_diffuse: true,
        light_specular: true,
        relight: Relight::Never,
        diffuse: true,
        specular: true,
        albedo: true,
        irradiance: true,
        position: true,
        shadow: true,
        ..Layers::default()
    }
}

fn rgb(film: &Film, layer: &str) -> Vec<[f32; 3]> {
    let names = ["R", "G", "B"].map(|channel| format!("{layer}.{channel}"));
    channels(film, names.each_ref().map(String::as_str))
}

fn largest(rgb: [f64; 3]) -> f64 {
    rgb.into_iter()
        .fold(0.0, |most, value| most.max(value.abs()))
}

fn apart(actual: [f32; 3], expected: [f64; 3]) -> f64 {
    let pairs = actual.into_iter().zip(expected);
    pairs.fold(0.0, |most, (actual, expected)| {
        most.max((f64::from(actual) - expected).abs())
    })
}

/// Every seventh pixel of scenes of all kinds, where light is carried as RGB.
#[test]
fn each_is_what_the_oracle_says() {
    let folder = tempfile::tempdir().unwrap();
    let mut worst = Measured::new("terms of the equation", TERM);
    let (mut compared, mut flips) = (0, 0);
    for (name, mut scene) in scenes(&folder, 50) {
        scene.image.transport.value = Transport::Rgb;
        let film = with_layers(&scene, 1, every_term());
        let oracle = Oracle::new(&scene);
        let width = oracle.resolution()[0] as usize;
        let weights = film.metadata().color_space.primaries().luminance_weights();
        let of_light = |suffix: &str| -> Vec<_> {
            let lights = scene.lights.iter();
            let layers = lights.map(|light| rgb(&film, &format!("light_{}{suffix}", light.name)));
            layers.collect()
        };
        let [lobes_d, lobes_s] = ["_diffuse", "_specular"].map(of_light);
        let shadows: Vec<_> = scene
            .lights
            .iter()
            .map(|light| channels(&film, [&format!("shadow_{}", light.name)]))
            .collect();
        let [diffuse, specular, albedo] =
            ["diffuse", "specular", "albedo"].map(|layer| rgb(&film, layer));
        let positions = channels(&film, ["P.X", "P.Y", "P.Z"]);
        let irradiance = channels(&film, ["irradiance"]);
        for pixel in (0..film.pixels().len()).step_by(7) {
            let at = [pixel % width, pixel / width];
            let terms = oracle.explain(at[0] as f64 + 0.5, at[1] as f64 + 0.5);
            let Some(hit) = &terms.hit else {
                let black = [0.0; 3];
                let all = [
                    diffuse[pixel],
                    specular[pixel],
                    albedo[pixel],
                    positions[pixel],
                ];
                let is_black = all == [black; 4] && irradiance[pixel] == [0.0];
                flips += u32::from(!is_black);
                continue;
            };
            let mut error = apart(albedo[pixel], hit.reflectance.diffuse);
            let extent = largest(hit.position).max(hit.distance);
            error = error.max(apart(positions[pixel], hit.position) / extent);
            let (mut sum_d, mut sum_s, mut lux) = ([0.0; 3], [0.0; 3], 0.0);
            let scale = largest(terms.radiance).max(1e-6);
            for (light, of_light) in terms.lights.iter().enumerate() {
                let v = if of_light.outcome == Outcome::Lit {
                    1.0
                } else {
                    0.0
                };
                error = error.max((f64::from(shadows[light][pixel][0]) - v).abs());
                let lobe = |r: [f64; 3]| [0, 1, 2].map(|c: usize| of_light.incident[c] * r[c] * v);
                let (d, s) = (lobe(of_light.diffuse), lobe(of_light.specular));
                error = error.max(apart(lobes_d[light][pixel], d) / scale);
                error = error.max(apart(lobes_s[light][pixel], s) / scale);
                for c in 0..3 {
                    sum_d[c] += d[c];
                    sum_s[c] += s[c];
                    lux += weights[c] * of_light.incident[c] * of_light.cos_incident * v;
                }
            }
            error = error.max(apart(diffuse[pixel], sum_d) / scale);
            error = error.max(apart(specular[pixel], sum_s) / scale);
            error = error.max((f64::from(irradiance[pixel][0]) - lux).abs() / lux.max(1e-6));
            compared += 1;
            if error > SIDE {
                flips += 1;
            } else {
                worst.see(error, || format!("{name} {at:?}"));
            }
        }
    }
    println!("{compared} pixels, {flips} flips");
    worst.judge();
    assert!(
        compared > 5000 && flips < compared / 500,
        "{flips} of {compared}"
    );
}

/// Of a spectral scene the lobes are integrals; they are R, G and B together all the same, and so are shares and groups.
#[test]
fn sums_are_red_green_blue() {
    let folder = tempfile::tempdir().unwrap();
    for (name, scene) in scenes(&folder, 50) {
        for transport in [Transport::Rgb, Transport::Auto] {
            let mut scene = scene.clone();
            scene.image.transport.value = transport;
            if candela::World::new(&scene).is_err() {
                // Some reflectances are above 1 between the wavelengths that their colors are made of.
                continue;
            }
            let film = with_layers(&scene, 4, every_term());
            let sums = &film.channels().sums;
            assert_eq!(sums.len(), 2, "{name}");
            for (pixel, rgba) in film.pixels().iter().enumerate() {
                let values = film.values(pixel);
                for layers in sums {
                    for (channel, &color) in rgba[..3].iter().enumerate() {
                        let addends = layers.iter().map(|first| values[first + channel]);
                        let (mut sum, mut bound) = (0.0, 0.0);
                        for addend in addends.chain([-color]) {
                            sum += f64::from(addend);
                            bound += half_a_unit(addend);
                        }
                        // Half a unit more for the sums in f64.
                        assert!(
                            f64::abs(sum) <= bound * 1.001,
                            "{name} {pixel}: {sum:e} {bound:e}"
                        );
                    }
                }
            }
        }
    }
}

/// Of the last place.
fn half_a_unit(value: f32) -> f64 {
    let value = value.abs();
    f64::from(value.next_up() - value) / 2.0
}

const LAMPS: &str = "
    [image]
    resolution = [24, 16]
    background = [0.1, 0.2, 0.3]
    [camera.orthographic]
    eye = [0, 0, 5]
    look_at = [0, 0, 0]
    height = 2.4
    [materials.clay.phong]
    diffuse = [0.5, 0.4, 0.3]
    specular = 0.2
    shininess = 20
    [materials.'µ.2'.phong]
    diffuse = 0.8
    [objects.ball.sphere]
    material = 'clay'
    center = [-0.6, 0, 0]
    radius = 0.7
    [objects.'球.left'.sphere]
    material = 'µ.2'
    center = [0.7, 0, 0]
    radius = 0.6
    [lights.a.point]
    position = [2, 3, 4]
    intensity = [10, 8, 6]
    group = 'window'
    [lights.b.point]
    position = [-2, 3, 4]
    intensity = [1, 8, 3]
    [lights.c.point]
    position = [0, 3, 6]
    intensity = 9
    group = 'window'
";

fn names(film: &Film) -> Vec<&str> {
    let list = film.channels().list.iter();
    list.map(|channel| channel.name.as_str()).collect()
}

/// A group's share is the sum of its lights'; what is chosen is made as it is among all.
#[test]
fn groups_and_choices() {
    let asked = |only: Option<&[&str]>| Layers {
        lights: true,
        shadow: true,
        only: only.map(|names| names.iter().map(|&name| name.to_owned()).collect()),
        ..Layers::default()
    };
    let scene = parse(LAMPS);
    let film = with_layers(&scene, 4, asked(None));
    let shares: Vec<&str> = names(&film)
        .into_iter()
        .filter(|name| name.ends_with(".R"))
        .collect();
    assert_eq!(
        shares,
        ["light_window.R", "light_b.R", "light_background.R"]
    );
    assert_eq!(names(&film)[9..], ["shadow_a", "shadow_b", "shadow_c"]);
    let ungrouped = with_layers(
        &parse(&LAMPS.replace("group = 'window'", "")),
        4,
        asked(None),
    );
    let (a, c) = (rgb(&ungrouped, "light_a"), rgb(&ungrouped, "light_c"));
    for (pixel, window) in rgb(&film, "light_window").into_iter().enumerate() {
        let sum = [0, 1, 2].map(|i: usize| f64::from(a[pixel][i]) + f64::from(c[pixel][i]));
        assert!(apart(window, sum) <= 1.2e-7 * largest(sum));
    }
    let some = with_layers(&scene, 4, asked(Some(&["b", "background"])));
    assert_eq!(names(&some)[0], "light_b.R");
    assert_eq!(names(&some)[6..], ["shadow_b"]);
    for layer in ["light_b", "light_background"] {
        assert_eq!(rgb(&some, layer), rgb(&film, layer));
    }
    // Not all are there.
    assert!(some.channels().sums.is_empty());
}

/// By hand: a pixel in the middle of a ball is covered by it alone, one at its edge by as much as A says; all
/// coverages are the alpha.
#[test]
fn mattes_say_what_covers_a_pixel() {
    let layers = Layers {
        object_mattes: true,
        material_mattes: true,
        matte_ranks: MatteRanks::new(3).unwrap(),
        ..Layers::default()
    };
    let film = with_layers(&parse(LAMPS), 16, layers);
    let expected: Vec<String> = [
        "CryptoObject00",
        "CryptoObject01",
        "CryptoMaterial00",
        "CryptoMaterial01",
    ]
    .iter()
    .flat_map(|layer| ["R", "G", "B", "A"].map(|channel| format!("{layer}.{channel}")))
    .collect();
    assert_eq!(names(&film), expected);
    let attribute = |name: &str| {
        let mut attributes = film.channels().attributes.iter();
        let found = attributes.find(|(key, _)| key == name);
        found.unwrap_or_else(|| panic!("{name}")).1.clone()
    };
    let manifest = |key: &str| -> serde_json::Value {
        serde_json::from_str(&attribute(&format!("cryptomatte/{key}/manifest"))).unwrap()
    };
    let id = |hash: &serde_json::Value| u32::from_str_radix(hash.as_str().unwrap(), 16).unwrap();
    assert_eq!(attribute("cryptomatte/3ae39a5/name"), "CryptoObject");
    assert_eq!(attribute("cryptomatte/be359d6/name"), "CryptoMaterial");
    let objects = manifest("3ae39a5");
    let [ball, left] = ["ball", "球.left"].map(|name| id(&objects[name]));
    // In the middle of the first ball: columns 0 to 24 are from −1.8 to 1.8.
    let middle = film.values(8 * 24 + 8);
    assert_eq!((middle[0].to_bits(), middle[1]), (ball, 1.0));
    assert_eq!(middle[2..8], [0.0; 6]);
    let (mut both, mut edges) = (0, 0);
    for (pixel, rgba) in film.pixels().iter().enumerate() {
        let values = film.values(pixel);
        let (objects, materials) = values.split_at(8);
        for of_kind in [objects, materials] {
            let (pairs, _) = of_kind.as_chunks::<2>();
            let coverage: f32 = pairs.iter().map(|[_, coverage]| coverage).sum();
            assert_eq!(coverage, rgba[3], "{pixel}");
            assert!(pairs.windows(2).all(|pair| pair[0][1] >= pair[1][1]));
            assert!(
                pairs
                    .iter()
                    .all(|&[id, coverage]| (id == 0.0) == (coverage == 0.0))
            );
        }
        edges += u32::from(rgba[3] > 0.0 && rgba[3] < 1.0);
        let ids = [values[0].to_bits(), values[2].to_bits()];
        both += u32::from(ids == [ball, left] || ids == [left, ball]);
    }
    assert!(edges > 10 && both > 0, "{edges} {both}");
}

/// Two channels of one name are found before anything is rendered.
#[test]
fn names_that_collide_are_found() {
    let world = |text: &str| {
        let scene = Scene::parse(text, "scene.toml").unwrap();
        candela::World::new(&scene).unwrap().0
    };
    let layers = every_term();
    assert_eq!(layers.collision(&world(LAMPS)), None);
    let colliding = LAMPS
        .replace("[lights.b.", "[lights.c_diffuse.")
        .replace("group = 'window'", "");
    let name = layers.collision(&world(&colliding));
    assert_eq!(name.as_deref(), Some("light_c_diffuse.B"));
    let only_shares = Layers {
        lights: true,
        ..Layers::default()
    };
    assert_eq!(only_shares.collision(&world(&colliding)), None);
    let background = LAMPS.replace("[lights.b.", "[lights.background.");
    assert!(only_shares.collision(&world(&background)).is_some());
}

/// A group has a name that no light has.
#[test]
fn a_group_with_the_name_of_a_light_is_refused() {
    for (from, to, said) in [
        (
            "group = 'window'",
            "group = 'b'",
            "there is a light `b` as well as a group",
        ),
        (
            "group = 'window'",
            "group = 'a.b'",
            "a dot parts layer and channel",
        ),
        ("group = 'window'", "group = ''", "at least one letter"),
    ] {
        let scene = Scene::parse(&LAMPS.replace(from, to), "scene.toml").unwrap();
        let errors = candela::World::new(&scene).unwrap_err().to_string();
        assert!(errors.contains(said), "{errors}");
    }
}

/// The bits of all layers are those of the whole, and of any number of threads.
#[test]
fn parts_have_the_terms_of_the_whole() {
    use candela::image::Window;
    let scene = parse(&LAMPS.replace("[24, 16]", "[75, 50]"));
    let all = || Layers {
        object_mattes: true,
        material_mattes: true,
        depth: true,
        normal: true,
        ..every_term()
    };
    let (world, camera) = candela::World::new(&scene).unwrap();
    let window = Window {
        x: 21,
        y: 7,
        width: 33,
        height: 19,
    };
    for samples in [1, 4, 3, 300] {
        let whole = with_layers(&scene, samples, all());
        let options = candela::Options {
            samples,
            window: Some(window),
            layers: all(),
            ..candela::Options::default()
        };
        let part = candela::render(&world, &camera, &options).unwrap();
        let bits = |values: Vec<f32>| -> Vec<u32> { values.iter().map(|v| v.to_bits()).collect() };
        for (pixel, [x, y]) in window.pixels().enumerate() {
            let in_whole = (y * camera.resolution()[0] + x) as usize;
            assert_eq!(bits(part.values(pixel)), bits(whole.values(in_whole)));
        }
    }
}
