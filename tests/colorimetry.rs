//! Colors through the whole program – scene file, EXR, XYZ – against tables that colour-science made
//! (`reference/`), and against the definitions of the units.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use candela::DVec3;
use candela::Primaries;
use candela::Scene;
use candela::exr::{self, ExrOptions};
use candela::internal::{Lab, delta_e_2000};
use candela::oracle::Oracle;
use candela::output::Unfinished;
use candela::scene::ColorSpace;
use candela::spectrum::{Illuminant, Observer, daylight, tables};
use candela::world::World;
use candela::world::colorimetry::converted;
use candela::world::difference::differences;
use candela::world::physics::albedo_at_normal_incidence;

use crate::images::{film_of, pixel, render};
use crate::measured::Measured;

/// ΔE00 of a patch, and in the mean: f32 in the file, and D65 as a formula rather than a rounded table.
pub(crate) const WORST: f64 = 3.84e-3;
const MEAN: f64 = 1.10e-3;

/// ΔE00 between RGB and spectra: the last of three decimals, and a gray of which each is computed in
/// its own way.
const CHECKED: f64 = 4.94e-4;

/// Error of white's X/Y and Z/Y, and of its Y beside 1: illuminant D65, and the white of the space with its four
/// decimals, to which light is adapted.
const WHITE: f64 = 2.31e-4;

/// A candela in any color, relative: R, G and B are f32, and the weights of their luminances too. Of the sums of the
/// observers' tables.
const UNIT: f64 = 3.57e-8;
const OBSERVER: f64 = 4.44e-5;

/// Error of R, G and B of about 1 in another working space: rounded to f32, and turned by a matrix.
const SPACE: f64 = 7.97e-8;

/// The six lights of the tables.
pub(crate) const LIGHTS: [&str; 6] = ["D65", "A", "F2", "F11", "LED-B3", "HP1"];

/// A table of `reference/`: its first columns are names, the others numbers.
fn table(file: &str, names: usize) -> BTreeMap<String, Vec<f64>> {
    let text = fs::read_to_string(Path::new("reference").join(file)).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('#')).skip(1);
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let numbers = cells[names..].iter().map(|cell| cell.parse().unwrap());
            (cells[..names].join(" "), numbers.collect())
        })
        .collect()
}

/// The color chart under another light, in a space, as R, G, B of its patches by name, out of an EXR.
fn chart(light: &str, space: &str) -> BTreeMap<String, [f64; 3]> {
    let path = Path::new("scenes/colorchecker.toml");
    let text = fs::read_to_string(path).unwrap();
    let text = text
        .replace("illuminant = \"D65\"", &format!("illuminant = \"{light}\""))
        .replace(
            "[960, 810]",
            &format!("[96, 81]\ncolor_space = \"{space}\""),
        );
    let scene = Scene::parse(&text, path).unwrap_or_else(|error| panic!("{error}"));
    let film = film_of(&scene, 1);
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("chart.exr");
    film.write_exr(&file, &ExrOptions::default(), &Unfinished::new())
        .unwrap();
    let image = exr::read(&file).unwrap();
    let at = |x: usize, y: usize| {
        let [r, g, b, _] = image.pixels[96 * y + x];
        [r, g, b].map(f64::from)
    };
    let mut patches: BTreeMap<String, [f64; 3]> = scene
        .materials
        .iter()
        .filter(|material| !["board", "white"].contains(&material.name.as_str()))
        .enumerate()
        .map(|(i, material)| {
            let [column, row] = [i % 6, i / 6];
            (material.name.clone(), at(10 + 15 * column, 10 + 15 * row))
        })
        .collect();
    patches.insert("white".to_owned(), at(48, 70));
    assert_eq!(patches.len(), 25);
    patches
}

fn lab(rgb: [f64; 3], white: [f64; 3], primaries: &Primaries) -> Lab {
    let xyz = |rgb| primaries.to_xyz() * DVec3::from_array(rgb);
    Lab::from_xyz(xyz(rgb), xyz(white))
}

fn lab_of_xyz(xyz: &[f64], white: &[f64]) -> Lab {
    Lab::from_xyz(DVec3::from_slice(xyz), DVec3::from_slice(white))
}

#[test]
fn the_color_checker_has_the_published_colors() {
    let mut of_patches = Measured::new("ΔE00 of patches", WORST);
    let mut of_means = Measured::new("ΔE00 in the mean", MEAN);
    let mut of_whites = Measured::new("XYZ of white", WHITE);
    let reference = table("colorchecker.csv", 2);
    for light in LIGHTS {
        let patches = chart(light, "rec709");
        let published = |patch: &str| &reference[&format!("{light} {patch}")];
        let white = patches["white"];
        let mut differences: Vec<f64> = patches
            .iter()
            .map(|(patch, &rgb)| {
                let actual = lab(rgb, white, &Primaries::REC709);
                let expected = lab_of_xyz(published(patch), published("white"));
                delta_e_2000(actual, expected)
            })
            .collect();
        differences.sort_by(f64::total_cmp);
        let mean = differences.iter().sum::<f64>() / differences.len() as f64;
        let worst = differences[differences.len() - 1];
        of_patches.see(worst, || light.to_owned());
        of_means.see(mean, || light.to_owned());
        // White itself, the light: absolute, in the file's own XYZ.
        let xyz = Primaries::REC709.to_xyz() * DVec3::from_array(white);
        for (actual, expected) in (xyz / xyz.y).to_array().iter().zip(published("white")) {
            of_whites.see((actual - expected).abs(), || light.to_owned());
        }
        of_whites.see((xyz.y - 1.0).abs(), || light.to_owned());
    }
    for measured in [of_patches, of_means, of_whites] {
        measured.judge();
    }
}

/// Without a test that can fail, the one above would prove little: RGB products are far off.
#[test]
fn rgb_transport_misses_the_published_colors() {
    let path = Path::new("scenes/colorchecker-f11.toml");
    let text = fs::read_to_string(path).unwrap();
    let resolution = |transport| format!("[96, 81]\ntransport = \"{transport}\"");
    let film = |transport| {
        let text = text.replace("[960, 810]", &resolution(transport));
        film_of(&Scene::parse(&text, path).unwrap(), 1)
    };
    let (rgb, spectral) = (film("rgb"), film("spectral"));
    let (mut sum, mut worst) = (0.0, 0.0_f64);
    for patch in 0..24 {
        let color = |film| {
            let at = |x, y| {
                let [r, g, b, _] = pixel(film, x, y);
                [r, g, b].map(f64::from)
            };
            let place = at(10 + 15 * (patch % 6), 10 + 15 * (patch / 6));
            lab(place, at(48, 70), &Primaries::REC709)
        };
        let difference = delta_e_2000(color(&rgb), color(&spectral));
        sum += difference;
        worst = worst.max(difference);
    }
    // From colour-science 0.4.7 on 5 nm: 3.5 in the mean, 10.5 at worst.
    let mean = sum / 24.0;
    let mut beside = Measured::new("ΔE00 of RGB under F11, beside a sum on 5 nm", 0.042);
    beside.see((mean - 3.5).abs(), || "mean".to_owned());
    beside.see((worst - 10.5).abs(), || "worst".to_owned());
    beside.judge();
}

/// ΔE00 of RGB under six lamps, in the four spaces: mean and worst of the 24 patches, as
/// `reference/rgb_or_spectral.py` computes them with colour-science 0.4.7 at 1 nm.
pub(crate) const PUBLISHED: [(&str, [[f64; 2]; 4]); 6] = [
    ("D65", [[0.0; 2]; 4]),
    (
        "A",
        [
            [4.185, 12.547],
            [1.627, 7.804],
            [1.785, 5.154],
            [1.889, 4.490],
        ],
    ),
    (
        "F2",
        [
            [4.968, 12.658],
            [4.109, 10.307],
            [3.558, 9.842],
            [3.377, 9.066],
        ],
    ),
    (
        "F11",
        [
            [3.542, 10.502],
            [2.589, 8.488],
            [2.160, 6.932],
            [1.988, 6.591],
        ],
    ),
    (
        "LED-B3",
        [
            [3.199, 8.629],
            [2.243, 6.954],
            [1.703, 5.561],
            [1.525, 5.238],
        ],
    ),
    (
        "HP1",
        [
            [18.365, 40.259],
            [8.333, 21.785],
            [7.589, 19.810],
            [6.340, 17.376],
        ],
    ),
];

/// What `candela check` says of it. The chart's two grays, which RGB misses by nothing, are in its mean too.
#[test]
fn check_says_by_how_much_rgb_misses_the_published_colors() {
    let path = Path::new("scenes/colorchecker.toml");
    let text = fs::read_to_string(path).unwrap();
    let mut checked = Measured::new("ΔE00 between RGB and spectra", CHECKED);
    for (light, of_spaces) in PUBLISHED {
        for (space, [mean, worst]) in ColorSpace::ALL.into_iter().zip(of_spaces) {
            let world = |transport| {
                let image = format!(
                    "[96, 81]\ncolor_space = \"{}\"\ntransport = \"{transport}\"",
                    space.name()
                );
                let text = text
                    .replace("illuminant = \"D65\"", &format!("illuminant = \"{light}\""))
                    .replace("[960, 810]", &image);
                World::new(&Scene::parse(&text, path).unwrap()).unwrap().0
            };
            let found = differences(&world("spectral"), &world("rgb"));
            assert_eq!((found.len(), found[0].materials), (1, 26));
            let mean_of_patches = found[0].mean * 26.0 / 24.0;
            let of_mean = (mean_of_patches - mean).abs();
            let of_worst = (found[0].worst - worst).abs();
            checked.see(of_mean.max(of_worst), || {
                format!("{light} {}", space.name())
            });
        }
    }
    checked.judge();
}

/// The same light, whatever the working space: only the numbers differ.
#[test]
fn every_working_space_shows_the_same_colors() {
    let mut worst = Measured::new("any working space", SPACE);
    for light in ["D65", "A"] {
        let rec709 = chart(light, "rec709");
        for space in ColorSpace::ALL {
            let patches = chart(light, space.name());
            for (patch, &rgb) in &patches {
                let back = converted(rgb, space, ColorSpace::Rec709);
                for (back, expected) in back.iter().zip(rec709[patch]) {
                    worst.see((back - expected).abs(), || {
                        format!("{patch} in {}", space.name())
                    });
                }
            }
            let [r, g, b] = patches["white"];
            if light == "D65" {
                assert!(r == g && g == b, "white in {} is {r} {g} {b}", space.name());
            }
        }
    }
    worst.judge();
}

/// Two surfaces, as curves on 5 nm, under lights that are sums of lines on 5 nm: then the integrals
/// are the raw sums of which the pair was made.
#[test]
fn the_metamers_part_as_published() {
    // ΔE00: published with one to three decimals, with other roundings of the tables.
    let mut worst = Measured::new("ΔE00 of metamers", 5.23e-5);
    let wavelengths: Vec<f64> = (0..81).map(|i| 380.0 + 5.0 * f64::from(i)).collect();
    let published = table("metamers.csv", 1);
    for (light, on_5_nm, rounded) in [
        ("D65", 0.0, 0.05),
        ("A", 6.744, 0.05),
        ("E", 3.831, 0.05),
        ("F2", 12.01, 0.05),
        ("F11", 6.459, 0.05),
        ("LED-B3", 5.015, 0.05),
    ] {
        let lines: Vec<String> = wavelengths
            .iter()
            .map(|&nm| format!("[{nm}, {}]", relative_power(light, nm)))
            .collect();
        let by_lines = difference(&format!("{{ lines = [{}] }}", lines.join(", ")));
        assert!((by_lines - on_5_nm).abs() < rounded, "{light}: {by_lines}");
        // The table's columns are the raw sums at 5 nm, and those of the curves at 1 nm.
        let by_curve = difference(&if light == "D65" {
            format!("{{ daylight = {} }}", 6500.0 * 1.4388 / 1.4380)
        } else {
            format!("{{ illuminant = \"{light}\" }}")
        });
        worst.see((by_lines - published[light][0]).abs(), || {
            format!("{light} at 5 nm")
        });
        worst.see((by_curve - published[light][1]).abs(), || {
            format!("{light} at 1 nm")
        });
        println!("{light}: {by_lines:.4} on 5 nm, {by_curve:.4} on 1 nm");
    }
    worst.judge();
}

/// The spectral power of an illuminant at 5 nm, from the tables, relative.
fn relative_power(light: &str, nm: f64) -> f64 {
    let tabulated = |table: &tables::Table| {
        let place = table.wavelengths().iter().position(|&there| there == nm);
        table.column(light)[place.unwrap()]
    };
    match light {
        // The CIE's, under which the pair is one; ours is that of RGB spaces.
        "D65" => daylight(6500.0 * 1.4388 / 1.4380).at(nm),
        "A" | "E" => Illuminant::named(light).unwrap().spectrum().at(nm),
        "F2" | "F11" => tabulated(tables::fluorescent()),
        _ => tabulated(tables::led()),
    }
}

/// ΔE00 of the metamers under a light, adapted to it.
fn difference(color: &str) -> f64 {
    let text = format!(
        "[image]\nresolution = [3, 1]\n\
         [camera.orthographic]\neye = [0, 0, 1]\nlook_at = [0, 0, 0]\nheight = 1\n\
         [materials]\n\
         a.phong = {{ diffuse = {{ file = \"curves/metamer-a.csv\" }} }}\n\
         b.phong = {{ diffuse = {{ file = \"curves/metamer-b.csv\" }} }}\n\
         white.phong = {{ diffuse = 1 }}\n\
         [lights.lamp.point]\nposition = [0, 0, 1e3]\n\
         intensity = {{ candela = 1e6, color = {color} }}\n\
         [objects]\n\
         a.sphere = {{ material = \"a\", center = [-1, 0, 0], radius = 0.4 }}\n\
         white.sphere = {{ material = \"white\", center = [0, 0, 0], radius = 0.4 }}\n\
         b.sphere = {{ material = \"b\", center = [1, 0, 0], radius = 0.4 }}\n"
    );
    let scene = Scene::parse(&text, "scenes/test.toml").unwrap_or_else(|e| panic!("{e}"));
    let film = film_of(&scene, 1);
    let [a, white, b] = [0, 1, 2].map(|x| {
        let [r, g, b, _] = pixel(&film, x, 0);
        [r, g, b].map(f64::from)
    });
    let lab = |rgb| lab(rgb, white, &Primaries::REC709);
    delta_e_2000(lab(a), lab(b))
}

/// The illuminance in lux on a white surface one meter straight below a light, as the luminance of
/// its pixel.
fn lux(intensity: &str, image: &str) -> f64 {
    let film = render(&white_floor(intensity, image), 1);
    let [r, g, b, _] = pixel(&film, 0, 0);
    let space = film.metadata().color_space;
    let weights = space.primaries().luminance_weights();
    weights[0] * f64::from(r) + weights[1] * f64::from(g) + weights[2] * f64::from(b)
}

fn white_floor(intensity: &str, image: &str) -> String {
    format!(
        "[image]\nresolution = [1, 1]\n{image}\n\
         [camera.orthographic]\neye = [0, 0, 0.5]\nlook_at = [0, 0, 0]\nheight = 1\n\
         [materials.white.phong]\ndiffuse = 1\n\
         [lights.lamp.point]\nposition = [0, 0, 1]\nintensity = {intensity}\n\
         [objects.floor.plane]\nmaterial = \"white\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n"
    )
}

/// The light of a candela is the same in every unit, and a candela is a candela in every color.
#[test]
fn units_reach_the_same_light() {
    let mut of_candela = Measured::new("candela in any color", UNIT);
    let mut of_lumens = Measured::rounding("lumens beside candela");
    for color in [
        "1",
        "[1, 0.2, 0.1]",
        "\"#4060ff\"",
        "{ rgb = [0.4, 0.6, 0.4], space = \"rec2020\" }",
        "{ illuminant = \"A\" }",
        "{ illuminant = \"F11\" }",
        "{ illuminant = \"HP1\" }",
        "{ daylight = 5600 }",
        "{ blackbody = 1900 }",
        "{ lines = [[589.0, 0.5], [589.6, 0.5]] }",
        "{ wavelengths = [400, 500, 700], values = [1, 0, 3] }",
    ] {
        for image in [
            "",
            "transport = \"rgb\"",
            "transport = \"spectral\"",
            "color_space = \"p3-d65\"",
        ] {
            let candela = lux(&format!("{{ candela = 100, color = {color} }}"), image);
            of_candela.see((candela / 100.0 - 1.0).abs(), || format!("{color} {image}"));
            let lumens = lux(
                &format!("{{ lumens = {}, color = {color} }}", 400.0 * PI),
                image,
            );
            of_lumens.see((lumens / candela - 1.0).abs(), || {
                format!("{color} {image}")
            });
        }
    }
    of_candela.judge();
    of_lumens.judge();
    // 1257 lm, as a lamp's box has it.
    let lumens = lux("{ lumens = 1257 }", "");
    let mut of_lamp = Measured::rounding("1257 lm");
    of_lamp.see((lumens * 4.0 * PI / 1257.0 - 1.0).abs(), String::new);
    of_lamp.judge();
    assert!((lumens - 100.0).abs() < 0.03);
}

/// K_m ∫ ȳ = 683 lm/W for light of one wavelength at the peak of ȳ, and the sums of the tables.
#[test]
fn watts_become_candela_by_the_observer() {
    let [line, everywhere] = [
        "{ lines = [[555, 1.0]] }",
        "{ watts_per_steradian_nm = 0.01 }",
    ]
    .map(|intensity| lux(intensity, ""));
    let mut of_observer = Measured::new("sums of the observer", OBSERVER);
    let mut of_flux = Measured::rounding("watts beside watts a steradian");
    of_observer.see((line / 683.0 - 1.0).abs(), || "555 nm".to_owned());
    let expected = 683.0 * 0.01 * 106.856_917;
    of_observer.see((everywhere / expected - 1.0).abs(), || "1931".to_owned());
    // A flux goes into 4π sr.
    let radiant = lux(
        "{ watts_per_steradian = 2, color = { lines = [[555, 7]] } }",
        "",
    );
    of_flux.see((radiant / (2.0 * line) - 1.0).abs(), || {
        "radiant".to_owned()
    });
    let flux = lux(
        &format!(
            "{{ watts = {}, color = {{ lines = [[555, 7]] }} }}",
            8.0 * PI
        ),
        "",
    );
    of_flux.see((flux / radiant - 1.0).abs(), || "flux".to_owned());
    // The 10° observer has its own ȳ: for equal energy 683.6 · 116.66 instead.
    let wide = lux("{ watts_per_steradian_nm = 0.01 }", "observer = \"1964\"");
    let expected = 683.6 * 0.01 * 116.661_877;
    of_observer.see((wide / expected - 1.0).abs(), || "1964".to_owned());
    of_observer.judge();
    of_flux.judge();
}

/// A lamp that is off may be black, in every unit; the renderer and the oracle agree.
#[test]
fn nothing_of_black_is_dark() {
    for unit in ["candela", "lumens", "watts", "watts_per_steradian"] {
        for color in ["0", "[0, 0, 0]", "{ lines = [[555, 0]] }", "[1, 0.5, 0]"] {
            for image in ["", "transport = \"rgb\"", "transport = \"spectral\""] {
                let intensity = format!("{{ {unit} = 0, color = {color} }}");
                assert_eq!(lux(&intensity, image), 0.0, "{intensity} {image}");
                let text = white_floor(&intensity, image);
                let scene = Scene::parse(&text, Path::new("test.toml")).unwrap();
                let oracle = Oracle::new(&scene).radiance(0.5, 0.5).radiance;
                assert_eq!(oracle, [0.0; 3], "{intensity} {image}");
            }
        }
    }
}

/// Two curves that reflect no more than all light at any wavelength are legal in every transport,
/// also if a channel of the two is above 1; more than all light at one wavelength is not.
#[test]
fn curves_of_one_material_are_judged_by_wavelength() {
    let load = |transport: &str, diffuse: &str, specular: &str| {
        let text = format!(
            "[image]\nresolution = [1, 1]\ntransport = \"{transport}\"\n\
             [camera.orthographic]\neye = [0, 0, 1]\nlook_at = [0, 0, 0]\nheight = 1\n\
             [materials.m.normalized_phong]\nshininess = 5\n\
             diffuse = {diffuse}\nspecular = {specular}\n\
             [lights.l.point]\nposition = [0, 0, 1]\nintensity = 1\n\
             [objects.o.sphere]\nmaterial = \"m\"\ncenter = [0, 0, 0]\nradius = 1\n"
        );
        World::new(&Scene::parse(&text, Path::new("test.toml")).unwrap())
    };
    let long = "{ wavelengths = [589, 590], values = [0, 0.9] }";
    for (specular, is_legal) in [
        ("{ wavelengths = [589, 590], values = [0, 0.1] }", true),
        ("{ wavelengths = [589, 590], values = [1, 0] }", true),
        ("0.1", true),
        ("[0.05, 0.1, 0.08]", true),
        ("{ wavelengths = [589, 590], values = [0, 0.2] }", false),
        ("0.2", false),
        ("[0.3, 0.2, 0.2]", false),
    ] {
        for transport in ["rgb", "spectral"] {
            for (diffuse, specular) in [(long, specular), (specular, long)] {
                let world = load(transport, diffuse, specular);
                assert_eq!(world.is_ok(), is_legal, "{transport} {diffuse} {specular}");
                let Err(error) = world else { continue };
                let expected = "expected an albedo of at most 1 at every wavelength";
                assert!(error.to_string().contains(expected), "{error}");
            }
        }
    }
    // Of a triple in RGB transport, what a smooth spectrum would have where none sees it is nothing.
    assert!(
        load(
            "rgb",
            "{ wavelengths = [780, 820], values = [0, 1] }",
            "[0.9, 0.4, 0.1]"
        )
        .is_ok()
    );
    // The claim is one: in a channel they are more.
    let (world, _) = load("rgb", long, "0.1").unwrap();
    let albedo = albedo_at_normal_incidence(&world.materials()[0].value);
    assert!(albedo[0] > 1.0, "{albedo:?}");
}

/// A light said as `[r, g, b]` on white gives that, to the bit; so does white light on gray.
#[test]
fn what_is_said_in_rgb_comes_out_in_rgb() {
    let rgb = |intensity: &str, diffuse: &str, image: &str| {
        let text = format!(
            "[image]\nresolution = [1, 1]\ntransport = \"spectral\"\n{image}\n\
             [camera.orthographic]\neye = [0, 0, 0.5]\nlook_at = [0, 0, 0]\nheight = 1\n\
             [materials.paint.phong]\ndiffuse = {diffuse}\n\
             [lights.lamp.point]\nposition = [0, 0, 1]\nintensity = {intensity}\n\
             [objects.floor.plane]\nmaterial = \"paint\"\npoint = [0, 0, 0]\nnormal = [0, 0, 1]\n"
        );
        let [r, g, b, _] = pixel(&render(&text, 1), 0, 0);
        [r, g, b]
    };
    let mut of_gray = Measured::rounding("gray in white light");
    let mut of_color = Measured::rounding("colors in white light");
    for image in ["", "observer = \"1964\""] {
        assert_eq!(rgb("[30, 20.5, 0.1]", "1", image), [30.0, 20.5, 0.1]);
        let half = rgb("[30, 20.5, 0.1]", "[0.5, 0.5, 0.5]", image);
        assert_eq!(half, [15.0, 10.25, 0.05]);
        for space in ColorSpace::ALL {
            let image = format!("{image}\ncolor_space = \"{}\"", space.name());
            let gray = rgb(
                "{ candela = 10, color = { illuminant = \"D65\" } }",
                "0.18",
                &image,
            );
            assert_eq!(gray, [gray[0]; 3], "{image}");
            of_gray.see((f64::from(gray[0]) / 1.8 - 1.0).abs(), || image.clone());
        }
        // White light on a color gives the color: as near as the spectrum that stands for it.
        for color in [
            [0.8_f32, 0.3, 0.05],
            [1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 1.0, 0.0],
        ] {
            let actual = rgb("1", &format!("{color:?}"), image);
            for (actual, expected) in actual.iter().zip(color) {
                let error = f64::from((actual - expected).abs());
                of_color.see(error, || format!("{color:?}: {actual}"));
            }
        }
    }
    of_gray.judge();
    of_color.judge();
}

/// Illuminants, black bodies and daylight have the chromaticities that colour-science computes, as an EXR shows.
#[test]
fn illuminants_have_the_chromaticities_of_colour_science() {
    // D65 itself, that of the CIE beside the white of RGB spaces; of all others f32.
    let mut of_d65 = Measured::new("chromaticity of D65", 2.69e-5);
    let mut worst = Measured::new("chromaticities", 6.59e-9);
    let published = table("illuminants.csv", 1);
    assert!(published.len() > 35);
    for (name, xy) in published {
        // Tables that differ from the formulas by their rounding.
        let color = if name.ends_with(" table") {
            continue;
        } else if let Some(kelvin) = name.strip_prefix("blackbody ") {
            format!("{{ blackbody = {} }}", kelvin.trim_end_matches(" K"))
        } else if let Some(kelvin) = name.strip_prefix("daylight ") {
            format!("{{ daylight = {} }}", kelvin.trim_end_matches(" K"))
        } else {
            format!("{{ illuminant = \"{name}\" }}")
        };
        let of_light = if name == "D65" {
            &mut of_d65
        } else {
            &mut worst
        };
        of_light.see(apart(rendered_chromaticity(&color), &xy), || name.clone());
    }
    of_d65.judge();
    worst.judge();
}

/// The CIE's four decimals of its 26 lamps (CIE 15:2018), which are sums of the tables at 5 nm: the light itself is off
/// by half of the last, and the EXR by no more.
#[test]
fn lamps_have_the_cie_s_chromaticities() {
    let mut of_lights = Measured::new("chromaticities of lamps", 4.99e-5);
    let mut in_files = Measured::new("chromaticities of lamps in an EXR", 4.99e-5);
    let published = table("published-illuminants.csv", 1);
    assert_eq!(published.len(), 26);
    for (name, xy) in published {
        let light = Illuminant::named(&name).unwrap().spectrum();
        let of_light = apart(chromaticity(Observer::Cie1931.xyz(&light)), &xy);
        assert!(of_light < 6e-5, "{name}: {of_light:e}");
        of_lights.see(of_light, || name.clone());
        let in_file = rendered_chromaticity(&format!("{{ illuminant = \"{name}\" }}"));
        let of_file = apart(in_file, &xy);
        assert!(of_file < 6e-5, "{name}: {of_file:e}");
        in_files.see(of_file, || name);
    }
    of_lights.judge();
    in_files.judge();
}

/// x, y of 100 cd of a color on white, out of the film.
fn rendered_chromaticity(color: &str) -> [f64; 2] {
    let text = white_floor(&format!("{{ candela = 100, color = {color} }}"), "");
    let [r, g, b, _] = pixel(&render(&text, 1), 0, 0);
    chromaticity(
        (Primaries::REC709.to_xyz() * DVec3::from_array([r, g, b].map(f64::from))).to_array(),
    )
}

fn chromaticity([x, y, z]: [f64; 3]) -> [f64; 2] {
    [x / (x + y + z), y / (x + y + z)]
}

fn apart(actual: [f64; 2], expected: &[f64]) -> f64 {
    let [x, y] = [0, 1].map(|i: usize| (actual[i] - expected[i]).abs());
    x.max(y)
}
