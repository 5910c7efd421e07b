//! The renderer against the oracle, pixel by pixel: two programs with nothing in common but the
//! scene as it was written.

use std::cell::OnceCell;
use std::path::Path;

use candela::exr::ExrOptions;
use candela::image::{Film, Window};
use candela::oracle::{Explanation, Oracle, Sample};
use candela::output::Unfinished;
use candela::render::SimdLevel;
use candela::render::{Layers, Options, render};
use candela::scene::{Light, Material, Object, Scene};
use candela::world::World;
use rayon::prelude::*;

use crate::generate;
use crate::images::{at_width, bits, film_of, is_smooth, name_of, parse, scene_files};
use crate::measured::{HALF_LAST_BIT, Measured};
use crate::openimageio::{idiff_agrees, idiff_agrees_within};

/// The promise: relative error of a pixel, for any scene. A condition number may be so large (a light just
/// above a surface) that the last bits of p show; of the scenes below none comes near to it.
pub(crate) const TOLERANCE: f64 = 1e-5;

/// The worst of the generated scenes, with shadow rays that start on the triangles and off them, and of
/// `scenes/`: half the last bit of an f32. All before the film is f64.
pub(crate) const WORST: f64 = HALF_LAST_BIT;

/// The worst of [`MANY`] generated scenes or more: a light just above a surface, where the last bits of p show.
pub(crate) const WORST_OF_MANY: f64 = 1.62e-7;
const MANY: u64 = 1000;

/// The worst of those of `scenes/` that have lights with an area, beside what the oracle states: what the renderer's
/// own quadrature may be off by.
const WORST_OF_AREAS: f64 = 3.22e-7;

/// Below this part of the image's median lit radiance, errors are relative to that instead of the
/// pixel: it is 20 stops below what the picture shows.
const FLOOR: f64 = 1e-6;

/// The part of the pixels of all scenes whose ray may pass so closely by an edge that rounding decides its side;
/// one pixel of each is allowed. Of the 880 000 pixels here none is such, and of the 11 million of 3000 generated
/// scenes, and 750 with shadow rays that start off the triangles, one is. Off an edge none may be.
pub(crate) const FLIPS: f64 = 2e-6;

/// Pixels away at which decisions are asked again, to find edges: far above what rounding moves a
/// ray by, far below what a viewer sees. And so many roundings of the eye's coordinates, where these are far from
/// the origin.
const NEARBY: f64 = 1e-5;
const ROUNDINGS: f64 = 512.0;

/// Relative change of a light's share so far away, where there is no edge.
const NEARBY_CHANGE: f64 = 1e-3;

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
    /// Pixels at an edge of what is seen, or of a shadow, that are right but for the side.
    flips: usize,
    /// Pixels that are wrong.
    wrong: Vec<[usize; 2]>,
    /// Of the others.
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
        .map(|i| (difference(i).abs() - expected.error[i]).max(0.0) / scale)
        .fold(0.0, f64::max)
}

/// How many pixels away an edge may be, so that rounding decides its side.
fn nearby(scene: &Scene) -> f64 {
    let view = scene.camera.value.view();
    let [eye, look_at] = [view.eye.value, view.look_at.value];
    let furthest = eye.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let distance = (0..3).map(|i| (eye[i] - look_at[i]).powi(2)).sum::<f64>();
    let rows = f64::from(scene.image.resolution.value[1]);
    NEARBY + ROUNDINGS * f64::EPSILON * furthest / distance.sqrt() * rows
}

/// Whether rounding may decide at this pixel: something else is seen, or another light arrives, a
/// hair's breadth away.
pub(crate) fn is_edge(oracle: &Oracle, scene: &Scene, [x, y]: [usize; 2]) -> bool {
    let (x, y) = (x as f64 + 0.5, y as f64 + 0.5);
    let center = oracle.decisions(x, y);
    let nearby = nearby(scene);
    let steps = [-nearby, 0.0, nearby];
    steps
        .into_iter()
        .flat_map(|dx| steps.map(|dy| [dx, dy]))
        .any(|[dx, dy]| oracle.decisions(x + dx, y + dy) != center)
}

/// What the renderer has made of a pixel: R, G, B, A, and of each light its share of R, G, B.
pub(crate) struct Rendered<'film> {
    pub(crate) pixel: [f32; 4],
    pub(crate) shares: &'film [f32],
}

/// Whether a pixel is right but for the side of an edge that rounding has put it on: it shows what is seen a
/// hair's breadth away, with each light as it arrives there; and a light that is there and should not be, or
/// the other way, is one that has the edge of its shadow here.
pub(crate) fn is_flip(
    oracle: &Oracle,
    scene: &Scene,
    [x, y]: [usize; 2],
    rendered: &Rendered<'_>,
    floor: f64,
) -> bool {
    let nearby = nearby(scene);
    let steps = [0.0, -nearby, nearby];
    let around = steps
        .into_iter()
        .flat_map(|dx| steps.map(|dy| [x as f64 + 0.5 + dx, y as f64 + 0.5 + dy]));
    let around: Vec<Explanation> = around.map(|[x, y]| oracle.explain(x, y)).collect();
    let seen = |terms: &Explanation| {
        terms
            .hit
            .as_ref()
            .map(|hit| (hit.object.clone(), hit.triangle))
    };
    around.iter().any(|shown| {
        let coverage = if shown.hit.is_some() { 1.0 } else { 0.0 };
        if shown.hit.is_none() {
            let radiance = shown.radiance;
            let background = Sample {
                radiance,
                coverage,
                error: [0.0; 3],
                unshadowed: [0.0; 3],
            };
            return error(rendered.pixel, &background, floor) <= TOLERANCE;
        }
        let scale = brightest(shown.radiance).max(floor);
        let mut lights = shown.lights.iter().enumerate();
        f64::from(rendered.pixel[3]) == coverage
            && lights.all(|(index, light)| {
                let share = &rendered.shares[3 * index..3 * index + 3];
                let differs = |expected: [f64; 3], tolerance: f64| {
                    let tolerance = tolerance * scale.max(brightest(expected));
                    let mut channels = share.iter().zip(expected);
                    channels.any(|(&a, b)| (f64::from(a) - b).abs() > tolerance)
                };
                // As it arrives here; or on the same surface, on the other side of its shadow's edge.
                !differs(light.radiance, TOLERANCE)
                    || around
                        .iter()
                        .filter(|other| seen(other) == seen(shown))
                        .any(|other| {
                            other.lights[index].outcome != light.outcome
                                && !differs(other.lights[index].radiance, NEARBY_CHANGE)
                        })
            })
    })
}

fn compare(scene: &Scene) -> Comparison {
    let oracle = Oracle::new(scene);
    let film = film_of(scene, 1);
    let layered = OnceCell::new();
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
        if error > TOLERANCE {
            let rendered = Rendered {
                pixel: actual,
                shares: &layered.get_or_init(|| with_shares(scene)).values(index),
            };
            if is_flip(&oracle, scene, pixel, &rendered, floor) {
                comparison.flips += 1;
            } else {
                comparison.wrong.push(pixel);
            }
        } else if error > comparison.worst {
            comparison.worst = error;
            comparison.worst_at = pixel;
        }
    }
    comparison
}

/// The image with each light as a layer of its own.
fn with_shares(scene: &Scene) -> Film {
    let layers = Layers {
        lights: true,
        ..Layers::default()
    };
    let (world, camera) = World::new(scene).unwrap_or_else(|error| panic!("{error}"));
    let options = Options {
        samples: 1,
        layers,
        ..Options::default()
    };
    render(&world, &camera, &options).unwrap()
}

/// Compares all scenes; what is wrong with any of them.
fn judge(what: &str, measured: f64, scenes: &[(String, Scene)]) {
    let comparisons: Vec<(&str, Comparison)> = scenes
        .par_iter()
        .map(|(name, scene)| (name.as_str(), compare(scene)))
        .collect();
    let mut failures = Vec::new();
    let (mut pixels, mut lit, mut flips) = (0, 0, 0);
    let mut worst = Measured::new(what, measured);
    for (name, comparison) in &comparisons {
        println!("{name}: {comparison:?}");
        pixels += comparison.pixels;
        lit += comparison.lit;
        flips += comparison.flips;
        worst.see(comparison.worst, || {
            format!("{name} {:?}", comparison.worst_at)
        });
        if !comparison.wrong.is_empty() || comparison.flips > 1 {
            failures.push(format!("{name}: {comparison:?}"));
        }
    }
    println!("{pixels} pixels, {lit} lit, {flips} flips");
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    worst.judge();
    // Of black images nothing is learned.
    assert!(3 * lit > pixels, "{lit} of {pixels} pixels are lit");
    assert!(
        flips as f64 <= (FLIPS * pixels as f64).max(1.0),
        "{flips} flips in {pixels} pixels"
    );
}

/// One scene with the oracle's image, for tests that stand elsewhere: within the promise, with one pixel that is
/// on the other side of an edge. How many pixels show a surface with light on it.
pub(crate) fn assert_agrees(name: &str, scene: &Scene) -> usize {
    let comparison = compare(scene);
    println!("{:e}, {} flips", comparison.worst, comparison.flips);
    assert!(
        comparison.wrong.is_empty() && comparison.flips <= 1,
        "{name}: {comparison:?}"
    );
    comparison.lit
}

/// How many pixels of a scene there are, and how many are not the oracle's.
pub(crate) fn disagreement(name: &str, scene: &Scene) -> [u64; 2] {
    let comparison = compare(scene);
    println!("{name}: {comparison:?}");
    let differ = comparison.wrong.len() as u64 + comparison.flips as u64;
    [comparison.pixels as u64, differ]
}

/// The worst of as many scenes as are asked for.
fn worst_of_generated() -> f64 {
    if generate::count() < MANY {
        WORST
    } else {
        WORST_OF_MANY
    }
}

#[test]
fn generated_scenes() {
    let folder = tempfile::tempdir().unwrap();
    let scenes = generate::scenes(folder.path());
    judge("generated scenes", worst_of_generated(), &scenes);
}

/// Shadow rays that start off the triangles, with all that is hard for them put in on purpose.
#[test]
fn generated_terminators() {
    let folder = tempfile::tempdir().unwrap();
    let count = generate::count().div_ceil(4);
    let scenes = generate::terminators(count, folder.path());
    judge("terminators", WORST, &scenes);
}

/// The same scenes, with cones of light.
#[test]
fn generated_spots() {
    let folder = tempfile::tempdir().unwrap();
    let count = generate::count().div_ceil(3);
    let scenes = generate::spots(count, folder.path());
    judge("spots", WORST, &scenes);
}

/// The same scenes, under parallel light and what IES files say.
#[test]
fn generated_suns_and_luminaires() {
    let folder = tempfile::tempdir().unwrap();
    let count = generate::count().div_ceil(3);
    let scenes = generate::suns(count, folder.path());
    judge("suns and luminaires", WORST, &scenes);
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
    let mut rays = BUDGET / surfaces as f64 / (1 + scene.lights.len()) as f64;
    if has_areas(scene) {
        rays /= OF_AREAS;
    }
    if is_smooth(scene) {
        rays /= OF_WAYS;
    }
    if disperses(scene) {
        rays /= WAVELENGTHS;
    }
    let [width, height] = scene.image.resolution.value.map(f64::from);
    ((rays * width / height).sqrt() as u32).clamp(16, WIDTH)
}

fn disperses(scene: &Scene) -> bool {
    let mut materials = scene.materials.iter();
    materials.any(|material| match &material.value {
        Material::Glass(glass) => glass.dispersion,
        _ => false,
    })
}

fn has_areas(scene: &Scene) -> bool {
    let mut lights = scene.lights.iter();
    lights.any(|light| matches!(light.value, Light::Area { .. }))
}

/// About so many ways of light it follows where anything is smooth.
const OF_WAYS: f64 = 30.0;

/// Where glass disperses light it follows each.
const WAVELENGTHS: f64 = 471.0;

/// Of integrals over lights the oracle needs more time than of a ray to a point: so many times.
const OF_AREAS: f64 = 40.0;

#[test]
fn scene_files_agree() {
    let scenes = scene_files().into_iter().map(|path| {
        let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{error}"));
        let width = affordable_width(&scene);
        (name_of(&path), at_width(scene, width))
    });
    let (areas, points): (Vec<_>, Vec<_>) = scenes.partition(|(_, scene)| has_areas(scene));
    judge("scene files", WORST, &points);
    judge("scene files with areas", WORST_OF_AREAS, &areas);
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
    const SPECTRUM: f64 = 6.21e-12;
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
    let mut worst = Measured::new("spectra of lights", SPECTRUM);
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
                worst.see((actual - expected).abs() / peak, || {
                    format!("{value} in {space}, {observer}")
                });
            }
        }
    }
    worst.judge();
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

/// A point on the edge of one light's shadow, amid the light of another.
#[test]
fn only_the_light_of_an_edge_may_flip() {
    let scene = parse(
        "[image]\nresolution = [1, 1]\n\
         [camera.orthographic]\neye = [5, 5, 0]\nlook_at = [0, 0, 0]\nheight = 1\n\
         [materials.m.phong]\ndiffuse = 0.5\n\
         [objects]\nfloor.plane = { material = \"m\", point = [0, 0, 0], normal = [0, 1, 0] }\n\
         roof.triangle = { material = \"m\", vertices = [[0, 1, -9], [0, 1, 9], [-9, 1, 0]] }\n\
         [lights]\nedge.point = { position = [0, 2, 0], intensity = 4 }\n\
         free.point = { position = [3, 2, 1], intensity = 7 }\n",
    );
    let oracle = Oracle::new(&scene);
    let center = oracle.explain(0.5, 0.5);
    let [edge, free] = [0, 1].map(|light: usize| center.lights[light].unoccluded[0] as f32);
    assert!(edge > 0.1 && free > 0.1);
    let is_right = |edge: f32, free: f32, alpha: f32| {
        let sum = edge + free;
        let rendered = Rendered {
            pixel: [sum, sum, sum, alpha],
            shares: &[edge, edge, edge, free, free, free],
        };
        is_flip(&oracle, &scene, [0, 0], &rendered, 1e-9)
    };
    assert!(is_right(edge, free, 1.0) && is_right(0.0, free, 1.0));
    for (edge, free, alpha) in [
        (edge, 0.0, 1.0),
        (0.0, 0.0, 1.0),
        // The sum is one that may be.
        (free, edge, 1.0),
        (0.5 * edge, free, 1.0),
        (1.01 * edge, free, 1.0),
        (edge, free, 0.0),
    ] {
        assert!(!is_right(edge, free, alpha), "{edge} {free} {alpha}");
    }
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
    let tolerance = Measured::ROOM * WORST;
    assert!(idiff_agrees_within(&a, &b, tolerance, 0));
    // And it would find one.
    let mut pixels = film.pixels().to_vec();
    for pixel in &mut pixels {
        pixel[1] *= 1.0 + 10.0 * tolerance as f32;
    }
    let wrong = Film::new(film.resolution(), window, pixels, film.metadata().clone());
    write(&wrong, &b);
    assert!(!idiff_agrees_within(&a, &b, tolerance, 0));
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
            bits(&render(&world, &camera, &options).unwrap())
        };
        let widest = rendered(SimdLevel::default());
        for (instructions, simd) in SimdLevel::available() {
            assert!(rendered(simd) == widest, "{name} on {instructions}");
        }
    }
}

/// One whose coordinates are a hundred million times its size: the oracle takes them as they are written, and so
/// does the renderer.
#[test]
fn far_from_the_origin_both_see_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let (name, scene) = generate::scene(1474, folder.path());
    assert!(nearby(&scene) > 100.0 * NEARBY);
    let comparison = compare(&scene);
    assert!(comparison.wrong.is_empty(), "{name}: {comparison:?}");
    assert_eq!(comparison.flips, 0);
}
