//! `--layers spectral`: bands against closed forms, against the picture that they belong to, and in
//! the eyes of colour-science.

use std::fs;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::process::Command;

use candela::exr::{ExrOptions, Precision};
use candela::image::{Film, Window};
use candela::internal::bradford;
use candela::internal::{Lab, delta_e_2000};
use candela::output::Unfinished;
use candela::render::{self, Job, Layers, Options, Renderer};
use candela::scene::{Scene, Transport};
use candela::spectrum::{Illuminant, Observer, SAMPLES};
use candela::world::{Wavelengths, World};
use glam::{DMat3, DVec3};

use crate::images::{at_width, bits, name_of, parse, scene_files};
use crate::openimageio::{decode, oiiotool};

/// Half a unit in the last place of an f32.
const F32_ROUNDING: f64 = 1.0 / (1 << 24) as f64;

fn bands_of(scene: &Scene, samples: u32, wavelengths: Wavelengths) -> Film {
    let options = Options {
        samples,
        layers: Layers {
            spectral: Some(wavelengths),
            ..Layers::default()
        },
        ..Options::default()
    };
    film_of(scene, &options)
}

fn film_of(scene: &Scene, options: &Options) -> Film {
    let mut scene = scene.clone();
    scene.image.transport.value = Transport::Spectral;
    let (world, camera) = World::new(&scene).unwrap_or_else(|error| panic!("{error}"));
    render::render(&world, &camera, options).unwrap()
}

/// The bits of all bands of all pixels.
fn band_bits(film: &Film) -> Vec<Vec<u32>> {
    let bits_of = |pixel| film.values(pixel).iter().map(|v| v.to_bits()).collect();
    (0..film.pixels().len()).map(bits_of).collect()
}

fn every_nm() -> Wavelengths {
    Wavelengths::new(360, 830, 1).unwrap()
}

/// Seen from straight above, one pixel to the metre: a floor with a sheen below a lamp 2 m up, which
/// is above column 4 and row 4, and a hole at the right.
const FLOOR: &str = r#"
    [image]
    resolution = [9, 9]
    background = 0.25

    [camera.orthographic]
    eye = [0, 1, 0]
    look_at = [0, 0, 0]
    up = [0, 0, -1]
    height = 9

    [materials.paint.phong]
    diffuse = { wavelengths = [360, 560, 830], values = [0.1, 0.9, 0.36] }
    specular = 0.2
    shininess = 30

    [lights.lamp.point]
    position = [0, 2, 0]
    intensity = { candela = 12, color = { illuminant = "D65" } }

    [objects.left.triangle]
    material = "paint"
    vertices = [[-9, 0, -99], [-9, 0, 99], [3, 0, 99]]

    [objects.right.triangle]
    material = "paint"
    vertices = [[-9, 0, -99], [3, 0, 99], [3, 0, -99]]
"#;

/// I(λ) of 1 cd of illuminant D65, from its definition alone.
pub(crate) fn d65_of_one_candela() -> [f64; SAMPLES] {
    let d65 = Illuminant::D65.spectrum();
    let [_, y, _] = Observer::Cie1931.color_matching();
    let luminous: f64 = d65.values().iter().zip(y).map(|(s, y)| s * y).sum();
    d65.values().map(|value| value / (683.0 * luminous))
}

fn paint(nm: u32) -> f64 {
    let nm = f64::from(nm);
    if nm <= 560.0 {
        0.1 + 0.8 * (nm - 360.0) / 200.0
    } else {
        0.9 - 0.54 * (nm - 560.0) / 270.0
    }
}

/// L(λ) = I(λ)/d² (k_d(λ) cos(n, ω_i) + k_s cosⁿ(ω_o, ω_r)), where the two cosines are equal because
/// the viewer looks along the normal; d = 2/cos.
fn floor(nm: u32, cosine: f64) -> f64 {
    let intensity = 12.0 * d65_of_one_candela()[(nm - 360) as usize];
    let distance = 2.0 / cosine;
    intensity / (distance * distance) * (paint(nm) * cosine + 0.2 * cosine.powi(30))
}

/// The rounding to f32, and f64 sums along the way.
const CLOSED_FORM: f64 = 1.1 * F32_ROUNDING;

fn assert_close(actual: f32, expected: f64, what: impl std::fmt::Debug) {
    let error = (f64::from(actual) / expected - 1.0).abs();
    assert!(error <= CLOSED_FORM, "{what:?}: {actual} {expected}");
}

#[test]
fn bands_are_the_equation_at_each_wavelength() {
    let film = bands_of(&parse(FLOOR), 1, every_nm());
    for (column, cosine) in [(4, 1.0), (6, 2.0 / 8.0_f64.sqrt())] {
        let bands = film.values(9 * 4 + column);
        for (&band, nm) in bands.iter().zip(360..) {
            assert_close(band, floor(nm, cosine), (column, nm));
        }
    }
    // A background of 0.25 is white light, D65 of 0.25 cd/m².
    for (&band, white) in film.values(9 * 4 + 8).iter().zip(d65_of_one_candela()) {
        assert_close(band, 0.25 * white, "background");
    }
}

#[test]
fn wide_bands_are_means_under_a_hat() {
    let film = bands_of(&parse(FLOOR), 1, Wavelengths::new(400, 700, 20).unwrap());
    for (&band, center) in film.values(9 * 4 + 4).iter().zip((400..).step_by(20)) {
        let weighted = (center - 19..center + 20_u32)
            .map(|nm| (1.0 - f64::from(nm.abs_diff(center)) / 20.0) * floor(nm, 1.0));
        assert_close(band, weighted.sum::<f64>() / 20.0, center);
    }
}

/// What a pixel shows in part adds in proportion, the background too.
#[test]
fn bands_of_samples_are_averaged() {
    let text = FLOOR.replace("resolution = [9, 9]", "resolution = [1, 1]");
    let narrow = text.replace("height = 9", "height = 1e-6");
    // The edge of the floor, x = 3, through the middle of the pixel.
    let edge = narrow
        .replace("eye = [0, 1, 0]", "eye = [3, 1, 0]")
        .replace("look_at = [0, 0, 0]", "look_at = [3, 0, 0]");
    let film = bands_of(&parse(&edge), 1024, Wavelengths::default());
    assert_eq!(film.pixels()[0][3], 0.5);
    let cosine = 2.0 / 13.0_f64.sqrt();
    let expected = |nm: u32| {
        let hat = |at: u32| 1.0 - f64::from(at.abs_diff(nm)) / 10.0;
        let white = d65_of_one_candela();
        let at = |at: u32| floor(at, cosine) + 0.25 * white[(at - 360) as usize];
        let mean: f64 = (nm - 9..nm + 10).map(|nm| hat(nm) * at(nm)).sum();
        mean / 10.0 / 2.0
    };
    // The pixel is a micrometre wide.
    const WIDTH: f64 = 1e-6;
    for (&band, nm) in film.values(0).iter().zip((380..).step_by(10)) {
        let error = (f64::from(band) / expected(nm) - 1.0).abs();
        assert!(error <= WIDTH, "{nm}: {band} {}", expected(nm));
    }
}

/// A nanometre below a lamp of 3e38 cd the bands are as large as f32 holds.
#[test]
fn bands_beyond_f32_are_clamped_and_counted() {
    let text = FLOOR
        .replace("candela = 12", "candela = 3e38")
        .replace("position = [0, 2, 0]", "position = [0, 1e-9, 0]");
    let mut scene = parse(&text);
    scene.image.transport.value = Transport::Spectral;
    let (world, camera) = World::new(&scene).unwrap();
    let renderer = Renderer::new(&world).unwrap();
    let options = Options {
        layers: Layers {
            spectral: Some(Wavelengths::default()),
            ..Layers::default()
        },
        ..Options::default()
    };
    let (film, counts) = renderer.film(&camera, &options, &Job::new()).unwrap();
    assert!(film.values(9 * 4 + 4).iter().all(|&band| band == f32::MAX));
    assert_eq!(counts.clamped, 3 + 41);
}

/// A scene of ours that has every kind of thing, small.
fn some_scene(name: &str) -> Scene {
    let path = Path::new("scenes").join(name).with_extension("toml");
    at_width(Scene::load(path).unwrap(), 75)
}

#[test]
fn red_green_blue_are_what_they_are_without_bands() {
    for path in scene_files() {
        let scene = at_width(Scene::load(&path).unwrap(), 60);
        for samples in [1, 3] {
            let without = Options {
                samples,
                ..Options::default()
            };
            let without = film_of(&scene, &without);
            let with = bands_of(&scene, samples, Wavelengths::new(400, 700, 100).unwrap());
            assert_eq!(without.channels().list.len(), 0);
            assert!(bits(&without) == bits(&with), "{}", name_of(&path));
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_file() {
    let scene = some_scene("sodium");
    let file = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let film = bands_of(&scene, 3, Wavelengths::default());
            let mut file = Cursor::new(Vec::new());
            film.write_exr_to(&mut file, &ExrOptions::default())
                .unwrap();
            file.into_inner()
        })
    };
    let first = file(1);
    for threads in [2, 3, 8] {
        assert!(file(threads) == first, "{threads}");
    }
}

/// Each pixel owns its sum: neither the tile nor the batch that it is in matters. 3 samples make
/// batches end within a pixel, 300 make a pixel have more than one.
#[test]
fn a_part_has_the_bands_of_the_whole() {
    let scene = some_scene("sodium");
    let window = Window {
        x: 33,
        y: 11,
        width: 21,
        height: 17,
    };
    for samples in [3, 300] {
        let options = Options {
            samples,
            window: Some(window),
            layers: Layers {
                spectral: Wavelengths::new(550, 650, 10),
                ..Layers::default()
            },
            ..Options::default()
        };
        let (part, whole) = (
            film_of(&scene, &options),
            film_of(
                &scene,
                &Options {
                    window: None,
                    ..options
                },
            ),
        );
        let width = whole.window().width;
        let (part, whole) = (band_bits(&part), band_bits(&whole));
        for ([x, y], part) in window.pixels().zip(part) {
            assert!(part == whole[(y * width + x) as usize], "{x} {y} {samples}");
        }
    }
}

/// Bands to the working space as a reader of the file would do it: Σ S_b c̄(λ_b) Δ · 683, white
/// adapted, matrix.
pub(crate) fn rgb_of(bands: &[f32], wavelengths: Wavelengths) -> DVec3 {
    let observer = Observer::Cie1931;
    let matching = observer.color_matching();
    let xyz = [0, 1, 2].map(|channel: usize| {
        let products = bands.iter().zip(wavelengths.iter());
        let products =
            products.map(|(&band, nm)| f64::from(band) * matching[channel][(nm - 360) as usize]);
        683.0 * f64::from(wavelengths.step()) * products.sum::<f64>()
    });
    to_rgb() * DVec3::from_array(xyz)
}

fn to_rgb() -> DMat3 {
    let primaries = candela::scene::ColorSpace::Rec709.primaries();
    let d65 = d65_of_one_candela();
    let matching = Observer::Cie1931.color_matching();
    let white = matching.map(|m| 683.0 * m.iter().zip(d65).map(|(m, s)| m * s).sum::<f64>());
    primaries.from_xyz() * bradford(DVec3::from_array(white), primaries.white_xyz())
}

/// The lamps of the table in docs/spectral-images.md.
const LAMPS: [(&str, &str); 6] = [
    ("D65", r#"{ illuminant = "D65" }"#),
    ("A", r#"{ illuminant = "A" }"#),
    ("F11", r#"{ illuminant = "F11" }"#),
    ("LED-B3", r#"{ illuminant = "LED-B3" }"#),
    ("HP1", r#"{ illuminant = "HP1" }"#),
    ("sodium", "{ lines = [[589.0, 0.5], [589.6, 0.5]] }"),
];

/// The ColorChecker under a lamp: 8 by 8 pixels a patch.
fn chart(color: &str) -> Scene {
    let text = fs::read_to_string("scenes/colorchecker.toml").unwrap();
    let lit = text.replace(r#"{ illuminant = "D65" }"#, color);
    assert!(color.contains("D65") || lit != text);
    at_width(Scene::parse(&lit, "scenes/colorchecker.toml").unwrap(), 64)
}

/// Where the 24 patches are in [`chart`], and the white strip below.
fn patches() -> (Vec<usize>, usize) {
    let pixel = |column: usize, row: usize| 64 * (7 + 10 * row) + 7 + 10 * column;
    let patches = (0..4).flat_map(|row| (0..6).map(move |column| pixel(column, row)));
    (patches.collect(), pixel(2, 4))
}

#[test]
fn one_nm_integrates_to_the_picture() {
    for (lamp, color) in LAMPS {
        let film = bands_of(&chart(color), 1, every_nm());
        for (pixel, &[r, g, b, _]) in film.pixels().iter().enumerate() {
            let picture = DVec3::new(r.into(), g.into(), b.into());
            let error = (rgb_of(&film.values(pixel), every_nm()) - picture).abs();
            // Each band and channel is rounded by itself; RGB has negative coefficients, so that
            // the errors of XYZ can come out up to 5 times as large.
            let bound = 5.0 * F32_ROUNDING * picture.abs().max_element();
            assert!(error.max_element() <= bound, "{lamp} {pixel}: {error}");
        }
    }
}

/// Mean and largest ΔE00 between the picture's patches and their integrated bands, where the white
/// strip has L* = 100, for each lamp: the numbers of docs/spectral-images.md.
type Row = [(f64, f64); 6];
const QUADRATURE: [(u32, Row); 4] = [
    (
        1,
        [
            (0.00, 0.01),
            (0.00, 0.00),
            (0.00, 0.00),
            (0.00, 0.00),
            (0.00, 0.00),
            (0.00, 0.00),
        ],
    ),
    (
        5,
        [
            (0.02, 0.04),
            (0.02, 0.05),
            (0.07, 0.18),
            (0.05, 0.11),
            (0.09, 0.22),
            (0.35, 0.56),
        ],
    ),
    (
        10,
        [
            (0.11, 0.21),
            (0.09, 0.20),
            (0.30, 0.83),
            (0.21, 0.52),
            (0.41, 1.03),
            (0.29, 0.45),
        ],
    ),
    (
        20,
        [
            (0.39, 0.73),
            (0.32, 0.81),
            (1.27, 3.30),
            (0.69, 1.58),
            (1.30, 3.11),
            (5.37, 8.01),
        ],
    ),
];

/// The numbers above have two decimals.
const TABLE: f64 = 0.006;

#[test]
fn quadrature_errors_are_those_of_the_docs() {
    let (patches, white) = patches();
    let to_xyz = candela::scene::ColorSpace::Rec709.primaries().to_xyz();
    let mut wrong = String::new();
    for (step, row) in QUADRATURE {
        let wavelengths = Wavelengths::new(380, 780, step).unwrap();
        for ((lamp, color), (mean, worst)) in LAMPS.into_iter().zip(row) {
            let film = bands_of(&chart(color), 1, wavelengths);
            let picture = |pixel: usize| {
                let [r, g, b, _] = film.pixels()[pixel].map(f64::from);
                to_xyz * DVec3::new(r, g, b)
            };
            // The adapted eye: the lamp's own white.
            let white = picture(white);
            let differences: Vec<f64> = patches
                .iter()
                .map(|&pixel| {
                    let integrated = to_xyz * rgb_of(&film.values(pixel), wavelengths);
                    let lab = |xyz| Lab::from_xyz(xyz, white);
                    delta_e_2000(lab(integrated), lab(picture(pixel)))
                })
                .collect();
            let found_mean = differences.iter().sum::<f64>() / 24.0;
            let found_worst = differences.iter().copied().fold(0.0, f64::max);
            if (found_mean - mean).abs() > TABLE || (found_worst - worst).abs() > TABLE {
                wrong += &format!("{step} nm, {lamp}: {found_mean:.4} {found_worst:.4}\n");
            }
        }
    }
    assert!(wrong.is_empty(), "\n{wrong}");
}

/// The python with colour-science that `tests/setup.sh` makes.
fn python() -> Command {
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/colour-science/bin/python");
    assert!(
        python.exists(),
        "{} is missing; run ./check, which installs it",
        python.display()
    );
    Command::new(python)
}

/// What `colour.read_spectral_image_Fichet2021` makes of a file: wavelengths in nm, and radiance
/// pixel by pixel, band by band.
fn read_by_colour_science(path: &Path) -> (Vec<f64>, Vec<f64>) {
    const SCRIPT: &str = "
import sys, colour
components, specification = colour.read_spectral_image_Fichet2021(sys.argv[1], additional_data=True)
assert specification.is_emissive and not specification.is_polarised
assert list(components) == ['S0'], components.keys()
wavelengths, values = components['S0']
print(' '.join(str(nm) for nm in wavelengths), flush=True)
sys.stdout.buffer.write(values.astype('<f8').tobytes())
";
    let mut command = python();
    command.args(["-W", "ignore", "-c", SCRIPT]).arg(path);
    let output = command.output().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    let line = output
        .stdout
        .iter()
        .position(|&byte| byte == b'\n')
        .unwrap();
    let (line, values) = output.stdout.split_at(line);
    let wavelengths = std::str::from_utf8(line).unwrap().split(' ');
    let (values, rest) = values[1..].as_chunks::<8>();
    assert!(rest.is_empty());
    (
        wavelengths.map(|nm| nm.parse().unwrap()).collect(),
        values
            .iter()
            .map(|&bytes| f64::from_le_bytes(bytes))
            .collect(),
    )
}

fn written(film: &Film, folder: &Path, precision: Precision) -> PathBuf {
    let path = folder.join("bands.exr");
    let options = ExrOptions {
        precision,
        ..ExrOptions::default()
    };
    film.write_exr(&path, &options, &Unfinished::new()).unwrap();
    path
}

#[test]
fn colour_science_reads_the_bands() {
    let film = bands_of(
        &some_scene("sodium"),
        1,
        Wavelengths::new(400, 700, 20).unwrap(),
    );
    let folder = tempfile::tempdir().unwrap();
    let path = written(&film, folder.path(), Precision::Float);
    oiiotool(folder.path(), "bands.exr -o resaved.exr");
    let pixels = 0..film.pixels().len();
    let expected: Vec<f64> = pixels
        .flat_map(|pixel| film.values(pixel).into_iter().map(f64::from))
        .collect();
    for path in [path, folder.path().join("resaved.exr")] {
        let (wavelengths, values) = read_by_colour_science(&path);
        let nm: Vec<f64> = (0..16).map(|band| 400.0 + 20.0 * f64::from(band)).collect();
        assert_eq!(wavelengths, nm);
        assert!(values == expected, "{}", path.display());
    }
}

#[test]
fn the_header_says_what_the_bands_are() {
    let film = bands_of(&parse(FLOOR), 1, Wavelengths::new(400, 700, 100).unwrap());
    let folder = tempfile::tempdir().unwrap();
    for (precision, name) in [(Precision::Float, "float"), (Precision::Half, "half")] {
        let path = written(&film, folder.path(), precision);
        let info = oiiotool(folder.path(), "--info -v bands.exr");
        for expected in [
            &format!("8 channel, {name} openexr"),
            "channel list: R, G, B, A, S0.400,000000nm, S0.500,000000nm",
            "spectralLayoutVersion: \"1.0\"",
            "emissiveUnits: \"W.m^-2.sr^-1\"",
            "candela:layers: \"spectral\"",
            r#"candela:bands: "{"first":400,"last":700,"step":100,"unit":"W.m^-2.sr^-1.nm^-1","weights":"hat"}""#,
        ] {
            assert!(info.contains(expected), "no `{expected}` in\n{info}");
        }
        let decoded = decode(&path);
        let [r, g, b, a] = film.pixels()[40];
        let all: Vec<f32> = [r, g, b, a]
            .into_iter()
            .chain(film.values(40).iter().copied())
            .collect();
        for (&value, &stored) in all.iter().zip(decoded.pixel(4, 4)) {
            match precision {
                Precision::Float => assert_eq!(value, stored),
                Precision::Half => assert_eq!(half::f16::from_f32(value).to_f32(), stored),
            }
        }
    }
}

#[test]
fn values_that_half_holds_badly_are_counted() {
    let film = bands_of(&parse(FLOOR), 1, Wavelengths::default());
    let small = (0..81).flat_map(|pixel| film.values(pixel));
    let small = small.filter(|&value| value > 0.0 && value < 6.1e-5).count() as u64;
    assert!(small > 0);
    let report = |precision| {
        let options = ExrOptions {
            precision,
            ..ExrOptions::default()
        };
        film.write_exr_to(&mut Cursor::new(Vec::new()), &options)
            .unwrap()
    };
    assert_eq!(report(Precision::Half).small_in_half, small);
    assert_eq!(report(Precision::Float).small_in_half, 0);
}
