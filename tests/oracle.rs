//! The renderer against the oracle, pixel by pixel: two programs with nothing in common but the
//! scene as it was written.

use std::path::Path;

use candela::exr::ExrOptions;
use candela::image::{Film, Window};
use candela::oracle::{Oracle, Sample};
use candela::output::Unfinished;
use candela::render::{Options, render};
use candela::scene::{Object, Scene};
use candela::simd::SimdLevel;
use candela::world::World;
use rayon::prelude::*;

use crate::generate;
use crate::images::{at_width, bits, film_of, name_of, parse, scene_files};
use crate::openimageio::{idiff_agrees, idiff_agrees_within};

/// The promise: relative error of a pixel. It allows a thousandth of the pixels to be beyond, where
/// a condition number is so large (a light just above a surface) that the last bits of p show;
/// [`WORST`] does not.
const TOLERANCE: f64 = 1e-5;

/// What no pixel may exceed, flips apart. Colors are f32 on the way: narrowing I·k and the cosine
/// term, their product, and the sum over each light round by 6e-8 at most, 7e-7 for 8 lights;
/// positions and cosines are f64. The worst of 3000 generated scenes is 1.7e-7.
const WORST: f64 = 2e-6;

/// Below this part of the image's median lit radiance, errors are relative to that instead of the
/// pixel: it is 20 stops below what the picture shows.
const FLOOR: f64 = 1e-6;

/// The part of the pixels whose ray passes within rounding of an edge, so that either side is
/// right: of a scene, where one pixel is always allowed, and of all scenes together.
const FLIPS: f64 = 5e-4;

/// Pixels away at which decisions are asked again, to find edges: far above what rounding moves a
/// ray by, far below what a viewer sees.
const NEARBY: f64 = 1e-5;

/// Columns of the images of scene files: twice a prime. Even, so that a divider that is seen edge-on
/// in the middle lies between pixels; and no more than that, so that the edges of regular charts do not
/// lie in the centers of pixels.
const WIDTH: u32 = 94;

/// Surfaces to be gone through for one image of a scene file: the oracle has no tree.
const BUDGET: f64 = 3e8;

/// One scene's verdict.
#[derive(Debug, Default)]
struct Comparison {
    pixels: usize,
    /// Pixels that show a surface with light on it.
    lit: usize,
    /// Pixels beside an edge of what is seen or of a shadow, and pixels with a light more or less.
    flips: usize,
    worst: f64,
    worst_at: [usize; 2],
}

fn oracle_pixels(oracle: &Oracle) -> Vec<Sample> {
    let [width, height] = oracle.resolution();
    (0..height)
        .into_par_iter()
        .flat_map_iter(|y| (0..width).map(move |x| [x, y]))
        .map(|[x, y]| oracle.radiance(f64::from(x) + 0.5, f64::from(y) + 0.5))
        .collect()
}

/// The largest channel. Beside it there may be negative ones, where a color is outside of the
/// working space.
fn brightest(radiance: [f64; 3]) -> f64 {
    radiance.into_iter().map(f64::abs).fold(0.0, f64::max)
}

/// The middle of all radiances above 0, or 1 where there is none.
fn median_lit(samples: &[Sample]) -> f64 {
    let lit = samples.iter().map(|sample| brightest(sample.radiance));
    let mut lit: Vec<f64> = lit.filter(|&radiance| radiance > 0.0).collect();
    lit.sort_by(f64::total_cmp);
    lit.get(lit.len() / 2).copied().unwrap_or(1.0)
}

fn error(actual: [f32; 4], expected: &Sample, floor: f64) -> f64 {
    if f64::from(actual[3]) != expected.coverage {
        return f64::INFINITY;
    }
    let scale = brightest(expected.radiance).max(floor);
    let difference = |channel: usize| f64::from(actual[channel]) - expected.radiance[channel];
    (0..3)
        .map(|i| difference(i).abs() / scale)
        .fold(0.0, f64::max)
}

/// Whether rounding may decide at this pixel: something else is seen, or another light arrives, a
/// hair's breadth away.
pub(crate) fn is_edge(oracle: &Oracle, [x, y]: [usize; 2]) -> bool {
    let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
    let center = oracle.decisions(x, y);
    let steps = [-NEARBY, 0.0, NEARBY];
    steps
        .into_iter()
        .flat_map(|dx| steps.map(|dy| [dx, dy]))
        .any(|[dx, dy]| oracle.decisions(x + dx, y + dy) != center)
}

/// Whether the pixel is right but for lights that are there and should not be, or the other way.
fn is_whole_lights(oracle: &Oracle, [x, y]: [usize; 2], actual: [f32; 4], floor: f64) -> bool {
    let explanation = oracle.explain(x as f64 + 0.5, y as f64 + 0.5);
    let lights = &explanation.lights;
    if explanation.hit.is_none() || lights.len() > 8 {
        return false;
    }
    (0_u32..1 << lights.len()).any(|chosen| {
        let mut radiance = [0.0; 3];
        for (index, light) in lights.iter().enumerate() {
            if chosen >> index & 1 == 1 {
                for (channel, sum) in radiance.iter_mut().enumerate() {
                    *sum += light.unoccluded[channel];
                }
            }
        }
        let coverage = 1.0;
        error(actual, &Sample { radiance, coverage }, floor) <= TOLERANCE
    })
}

fn compare(scene: &Scene) -> Comparison {
    let oracle = Oracle::new(scene);
    let film = film_of(scene, 1);
    let expected = oracle_pixels(&oracle);
    assert_eq!(film.pixels().len(), expected.len());
    let floor = FLOOR * median_lit(&expected);
    let width = oracle.resolution()[0] as usize;
    let mut comparison = Comparison {
        pixels: expected.len(),
        ..Comparison::default()
    };
    for (index, (&actual, expected)) in film.pixels().iter().zip(&expected).enumerate() {
        let pixel = [index % width, index / width];
        comparison.lit +=
            usize::from(expected.coverage > 0.0 && brightest(expected.radiance) > 0.0);
        let error = error(actual, expected, floor);
        let may_flip = || is_edge(&oracle, pixel) || is_whole_lights(&oracle, pixel, actual, floor);
        if error > TOLERANCE && may_flip() {
            comparison.flips += 1;
        } else if error > comparison.worst {
            comparison.worst = error;
            comparison.worst_at = pixel;
        }
    }
    comparison
}

/// Compares all scenes; what is wrong with any of them.
fn judge(scenes: &[(String, Scene)]) {
    let comparisons: Vec<(&str, Comparison)> = scenes
        .par_iter()
        .map(|(name, scene)| (name.as_str(), compare(scene)))
        .collect();
    let mut failures = Vec::new();
    let (mut pixels, mut lit, mut flips, mut worst) = (0, 0, 0, 0.0_f64);
    for (name, comparison) in &comparisons {
        println!("{name}: {comparison:?}");
        pixels += comparison.pixels;
        lit += comparison.lit;
        flips += comparison.flips;
        worst = worst.max(comparison.worst);
        let of = comparison.pixels as f64;
        if comparison.worst > WORST || comparison.flips as f64 > (FLIPS * of).max(1.0) {
            failures.push(format!("{name}: {comparison:?}"));
        }
    }
    println!("{pixels} pixels, {lit} lit, {flips} flips, worst relative error {worst:e}");
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    // Of black images nothing is learned.
    assert!(3 * lit > pixels, "{lit} of {pixels} pixels are lit");
    assert!(
        flips as f64 <= FLIPS * pixels as f64,
        "{flips} flips in {pixels} pixels"
    );
}

/// One scene with the oracle's image, for tests that stand elsewhere: within [`TOLERANCE`] and
/// [`FLIPS`]. How many pixels show a surface with light on it.
pub(crate) fn assert_agrees(name: &str, scene: &Scene) -> usize {
    let comparison = compare(scene);
    let flips = (FLIPS * comparison.pixels as f64).max(1.0);
    assert!(
        comparison.worst <= TOLERANCE && comparison.flips as f64 <= flips,
        "{name}: {comparison:?}"
    );
    comparison.lit
}

#[test]
fn generated_scenes() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = generate::scenes(folder.path());
    judge(&scenes);
}

/// Shadow rays that start off the triangles, with all that is hard for them put in on purpose.
#[test]
fn generated_terminators() {
    let folder = tempfile::tempdir().unwrap();
    let count = generate::count().div_ceil(4);
    judge(&generate::terminators(count, folder.path()));
}

/// At how many columns the oracle is done in reasonable time.
fn affordable_width(scene: &Scene) -> u32 {
    let surfaces: usize = scene
        .objects
        .iter()
        .map(|object| match &object.value {
            Object::Mesh { geometry, .. } => geometry.triangles.len(),
            Object::Sphere { .. } | Object::Plane { .. } | Object::Triangle { .. } => 1,
        })
        .sum();
    let rays = BUDGET / surfaces as f64 / (1 + scene.lights.len()) as f64;
    let [width, height] = scene.image.resolution.value.map(f64::from);
    ((rays * width / height).sqrt() as u32).clamp(16, WIDTH)
}

#[test]
fn scene_files_agree() {
    let scenes: Vec<(String, Scene)> = scene_files()
        .iter()
        .map(|path| {
            let scene = Scene::load(path).unwrap_or_else(|error| panic!("{error}"));
            let width = affordable_width(&scene);
            (name_of(path), at_width(scene, width))
        })
        .collect();
    judge(&scenes);
}

/// A curve with points from 3e-3 to 3 nm apart, in turns, from 340 nm on.
fn any_spacing() -> String {
    let mut nm = 340.0;
    let mut wavelengths = Vec::new();
    for i in 0..1000_i32 {
        nm += 10.0_f64.powf(f64::from(i * 7 % 31) / 10.0 - 2.5);
        wavelengths.push(nm);
    }
    let values: Vec<i32> = (0..1000).map(|i| i * 37 % 101).collect();
    format!("{{ wavelengths = {wavelengths:?}, values = {values:?} }}")
}

/// The renderer's spectrum of each light, beside the oracle's of a background of that value: wavelength
/// by wavelength, so that nothing is averaged away.
#[test]
fn spectra_of_lights_agree() {
    /// Relative to the peak. Both solve for colors to 1e-13 or so; where these are saturated, spectra
    /// change faster than they do.
    const SPECTRUM: f64 = 1e-8;
    let steps = [0.0, 1e-3, 0.1, 0.5, 0.99, 1.0];
    let triples = steps.into_iter().flat_map(|r| {
        let pairs = steps
            .into_iter()
            .flat_map(move |g| steps.map(|b| [r, g, b]));
        pairs.filter(|rgb| *rgb != [0.0; 3])
    });
    let mut values: Vec<String> = triples.map(|rgb| format!("{rgb:?}")).collect();
    for kind in [
        "{ wavelengths = [300, 450.25, 450.5, 600, 900], values = [1, 0.5, 2, 0.1, 3] }",
        "{ wavelengths = [435, 435.6, 435.8, 436, 436.6], values = [0, 0.01, 1, 0.01, 0] }",
        "{ wavelengths = [359.2, 359.9, 360.4, 829.7, 830.2], values = [0, 1, 0, 0, 1] }",
        "{ lines = [[360, 1], [435.8, 0.5], [546.074, 1], [546.1, 2], [830, 0.1]] }",
        "{ rgb = [0.9, 0.2, 0.4], space = \"p3-d65\" }",
        "{ rgb = [0.4, 0.9, 0.3], space = \"rec2020\" }",
        "{ rgb = [0.5, 0.4, 0.9], space = \"acescg\" }",
        // Hardly within reach.
        "{ rgb = [1, 0.02, 0], space = \"rec2020\" }",
    ] {
        values.push(kind.to_owned());
    }
    values.push(any_spacing());
    let mut worst = (0.0, String::new());
    for (space, observer) in [
        ("rec709", "1931"),
        ("p3-d65", "1931"),
        ("rec2020", "1964"),
        ("acescg", "1931"),
        ("acescg", "1964"),
    ] {
        for value in &values {
            let scene = parse(&format!(
                "[image]\nresolution = [1, 1]\ntransport = \"spectral\"\nbackground = {value}\n\
                 color_space = \"{space}\"\nobserver = \"{observer}\"\n\
                 [camera.orthographic]\neye = [0, 0, 0]\nlook_at = [0, 0, -1]\nheight = 1\n\
                 [lights.l.point]\nposition = [0, 0, 0]\nintensity = {value}\n\
                 [materials.m.phong]\n\
                 [objects.o.sphere]\nmaterial = \"m\"\ncenter = [0, 0, 9]\nradius = 1\n"
            ));
            let (world, _) = World::new(&scene).unwrap_or_else(|error| panic!("{error}"));
            let actual = world.spectra().unwrap().light(0).values();
            let expected = Oracle::new(&scene).spectral_radiance(0.5, 0.5).unwrap();
            let peak = expected.iter().copied().fold(0.0, f64::max);
            for (actual, expected) in actual.iter().zip(&expected) {
                let error = (actual - expected).abs() / peak;
                if error > worst.0 {
                    worst = (error, format!("{value} in {space}, {observer}"));
                }
            }
        }
    }
    println!("worst: {worst:?}");
    assert!(worst.0 <= SPECTRUM, "{worst:?}");
}

/// The test can fail: an oracle of another scene is not agreed with.
#[test]
fn a_wrong_image_is_found() {
    let scene = at_width(Scene::builtin(), WIDTH);
    let mut oracle = oracle_pixels(&Oracle::new(&scene));
    let film = film_of(&scene, 1);
    let floor = FLOOR * median_lit(&oracle);
    let lit = oracle
        .iter()
        .position(|sample| brightest(sample.radiance) > floor)
        .unwrap();
    assert!(error(film.pixels()[lit], &oracle[lit], floor) < TOLERANCE);
    oracle[lit].radiance = oracle[lit]
        .radiance
        .map(|channel| channel * (1.0 + 3.0 * TOLERANCE));
    assert!(error(film.pixels()[lit], &oracle[lit], floor) > TOLERANCE);
}

fn write(film: &Film, path: &Path) {
    film.write_exr(path, &ExrOptions::default(), &Unfinished::new())
        .unwrap();
}

#[test]
fn idiff_finds_no_difference() {
    let folder = tempfile::tempdir().unwrap();
    let scene = at_width(Scene::builtin(), 320);
    let film = film_of(&scene, 1);
    let oracle = Oracle::new(&scene);
    let pixels = oracle_pixels(&oracle)
        .iter()
        .map(|sample| {
            let [r, g, b] = sample.radiance;
            [r, g, b, sample.coverage].map(|channel| channel as f32)
        })
        .collect();
    let window = Window::whole(oracle.resolution());
    let expected = Film::new(oracle.resolution(), window, pixels, film.metadata().clone());
    let (a, b) = (folder.path().join("a.exr"), folder.path().join("b.exr"));
    write(&film, &a);
    write(&expected, &b);
    let flips = (FLIPS * film.pixels().len() as f64) as usize;
    assert!(idiff_agrees_within(&a, &b, TOLERANCE, flips));
    // And it would find one.
    let mut pixels = film.pixels().to_vec();
    for pixel in &mut pixels {
        pixel[1] *= 1.0 + 10.0 * TOLERANCE as f32;
    }
    let wrong = Film::new(film.resolution(), window, pixels, film.metadata().clone());
    write(&wrong, &b);
    assert!(!idiff_agrees_within(&a, &b, TOLERANCE, flips));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = tempfile::tempdir().unwrap();
    let mut scenes = generate::scenes(scenes.path());
    scenes.truncate(10);
    scenes.push(("lecture".to_owned(), at_width(Scene::builtin(), 200)));
    for (name, scene) in scenes {
        let rendered = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let film = pool.unwrap().install(|| film_of(&scene, 4));
            let path = folder.path().join(format!("{threads}.exr"));
            write(&film, &path);
            (bits(&film), path)
        };
        let (one, one_path) = rendered(1);
        for threads in [2, 3, 7] {
            let (many, path) = rendered(threads);
            assert_eq!(one, many, "{name} with {threads} threads");
            let bytes = |path: &Path| std::fs::read(path).unwrap();
            assert!(
                bytes(&one_path) == bytes(&path),
                "{name} with {threads} threads"
            );
            if name == "lecture" {
                assert!(idiff_agrees(&one_path, &path));
            }
        }
    }
}

#[test]
fn any_instruction_set_gives_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let mut scenes = generate::scenes(folder.path());
    scenes.truncate(20);
    scenes.push(("lecture".to_owned(), at_width(Scene::builtin(), 200)));
    for (name, scene) in scenes {
        let (world, camera) = World::new(&scene).unwrap_or_else(|error| panic!("{error}"));
        let rendered = |simd| {
            let options = Options {
                samples: 3,
                simd,
                ..Options::default()
            };
            bits(&render(&world, &camera, &options))
        };
        let widest = rendered(SimdLevel::default());
        for (instructions, simd) in SimdLevel::available() {
            assert!(rendered(simd) == widest, "{name} on {instructions}");
        }
    }
}
