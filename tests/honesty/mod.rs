//! Stated errors against the oracle's means over pixels: bounds have to hold, and estimates mostly.

mod pool;
mod scenes;

use std::path::Path;

use candela::image::Film;
use candela::oracle::{Oracle, PixelMean, PixelQuadrature};
use candela::render::{ErrorTarget, Layers, Options, render};
use candela::scene::{Light, Object, Scene};
use candela::world::World;
use rayon::prelude::*;

use crate::generate::{self, Random};
use crate::images::{at_width, is_smooth, name_of, parse, scene_files};
use crate::measured::HALF_LAST_BIT;

use pool::{Pool, median};

/// So many pixels of each kind a scene, instead of [`PIXELS`]; from [`LONG`] on of all scenes.
const VARIABLE: &str = "CANDELA_HONESTY";
const PIXELS: usize = 4;
const LONG: usize = 1000;

/// Of generated scenes every so many is judged, unless the sweep is a long one.
const EVERY: usize = 5;

/// E of the target.
const TARGET: f64 = 0.01;

/// How exactly the oracle integrates, and how exactly it does where a bound seems broken.
const TOLERANCE: f64 = 1e-5;
const AGAIN: f64 = 1e-7;
const BUDGET_AGAIN: usize = 2_000_000;

/// What a stated error may be above what is allowed, as its f32 is rounded up.
const ROUNDING: f64 = 1e-6;

/// Columns of the images.
const WIDTH: u32 = 96;

/// The part of all pixels that meets the target or says that it does not.
const MET: f64 = 0.999;

/// One pixel's film and truth.
#[derive(Clone, Copy, Debug)]
struct Judged {
    pixel: [u32; 2],
    claim: Claim,
    stated: f64,
    /// The largest of R, G, B, less what the reference and the film's f32 may be off.
    off: f64,
    /// The same of A, beyond E.
    alpha_off: f64,
    /// By how many of what is allowed a pixel misses the target, of R, G, B.
    of_target: f64,
    /// Whether it states to meet the target.
    states_target: bool,
    reference: PixelMean,
}

impl Judged {
    fn told(&self) -> String {
        format!(
            "{:?}: {:e} stated, {:e} off, {:e} of A beyond E, {:.2} of the target; {:?}, {:?}",
            self.pixel,
            self.stated,
            self.off,
            self.alpha_off,
            self.of_target,
            self.claim,
            self.reference
        )
    }

    fn holds(&self) -> bool {
        self.off <= self.stated && self.alpha_off <= 0.0
    }

    fn meets_target_or_says_not(&self) -> bool {
        self.of_target <= 1.0 || !self.states_target
    }
}

/// What is found of a film.
#[derive(Debug, Default)]
struct Findings {
    /// Of the whole film.
    bounds: usize,
    estimates: usize,
    /// Pixels that neither state to meet the target nor have the most samples.
    silent: usize,
    /// Of the pixels that were judged.
    judged: Vec<Judged>,
    /// Pixels that the oracle did not resolve.
    unresolved: usize,
}

impl Findings {
    fn of(&self, is_bound: bool) -> impl Iterator<Item = &Judged> {
        self.judged
            .iter()
            .filter(move |judged| judged.claim.is_bound == is_bound)
    }

    fn broken_bounds(&self) -> Vec<&Judged> {
        self.of(true).filter(|judged| !judged.holds()).collect()
    }

    fn estimates_that_hold(&self) -> f64 {
        let all = self.of(false).count();
        let hold = self.of(false).filter(|judged| judged.holds()).count();
        if all == 0 {
            1.0
        } else {
            hold as f64 / all as f64
        }
    }

    /// Stated over true errors, of estimates that are off.
    fn ratios(&self) -> Vec<f64> {
        self.of(false)
            .filter(|judged| judged.off > 0.0)
            .map(|judged| judged.stated / judged.off)
            .collect()
    }

    /// What is dishonest about it, whatever other scenes are like.
    fn objections(&self) -> Vec<String> {
        let mut objections: Vec<String> = self
            .broken_bounds()
            .iter()
            .map(|judged| format!("a bound is broken at {}", judged.told()))
            .collect();
        let pixels = (self.bounds + self.estimates) as f64;
        if self.silent as f64 > pixels * (1.0 - MET) {
            objections.push(format!(
                "{} pixels miss the target and do not say so",
                self.silent
            ));
        }
        objections
    }
}

/// A film's pixels and what it states of them.
#[derive(Clone, Debug)]
struct Claims {
    width: usize,
    pixels: Vec<Claim>,
}

#[derive(Clone, Copy, Debug)]
struct Claim {
    value: [f32; 4],
    error: f32,
    is_bound: bool,
    samples: f32,
}

impl Claim {
    /// Whether it states to meet the target.
    fn states(&self, target: &ErrorTarget) -> bool {
        let value = self.value[..3].iter().map(|&value| f64::from(value));
        let largest = value.fold(0.0, f64::max);
        let allowed = target.relative * largest.max(target.floor.unwrap());
        f64::from(self.error) <= allowed * (1.0 + ROUNDING)
    }
}

impl Claims {
    fn of(film: &Film) -> Self {
        let channels = &film.channels().list;
        let number = |name| {
            channels
                .iter()
                .position(|channel| channel.name == name)
                .unwrap()
        };
        let [error, kind, samples] = ["error", "error_kind", "samples"].map(number);
        let claim = |place: usize| {
            let values = film.values(place);
            Claim {
                value: film.pixels()[place],
                error: values[error],
                is_bound: values[kind] == 0.0,
                samples: values[samples],
            }
        };
        Self {
            width: film.window().width as usize,
            pixels: (0..film.pixels().len()).map(claim).collect(),
        }
    }
}

/// Compares what is stated with the oracle, at so many pixels of each kind.
fn judge(
    scene: &Scene,
    claims: &Claims,
    target: &ErrorTarget,
    count: usize,
    seed: u64,
) -> Findings {
    let oracle = Oracle::new(scene);
    let quadrature = PixelQuadrature::new(&oracle);
    let floor = target.floor.unwrap();
    let mut findings = Findings::default();
    let mut places: [Vec<usize>; 2] = [Vec::new(), Vec::new()];
    for (place, claim) in claims.pixels.iter().enumerate() {
        places[usize::from(!claim.is_bound)].push(place);
        let has_all = claim.samples >= target.max_samples as f32;
        findings.silent += usize::from(!claim.states(target) && !has_all);
    }
    findings.bounds = places[0].len();
    findings.estimates = places[1].len();
    let mut random = Random::new(seed);
    let chosen: Vec<usize> = places
        .iter()
        .flat_map(|places| {
            let count = if places.is_empty() { 0 } else { count };
            (0..count)
                .map(|_| places[random.between(0.0, places.len() as f64) as usize])
                .collect::<Vec<_>>()
        })
        .collect();
    let judge_one = |place: usize| {
        let claim = claims.pixels[place];
        let pixel = [place % claims.width, place / claims.width].map(|at| at as u32);
        let compare = |reference: PixelMean| {
            let rest = |channel: usize| {
                let (value, [r, g, b]) = (f64::from(claim.value[channel]), reference.radiance);
                let truth = [r, g, b, reference.coverage][channel];
                let room = reference.error[channel] + HALF_LAST_BIT * truth.abs();
                ((value - truth).abs() - room).max(0.0)
            };
            let relative = |channel: usize| {
                rest(channel) / (target.relative * reference.radiance[channel].max(floor))
            };
            Judged {
                pixel,
                claim,
                stated: f64::from(claim.error),
                off: (0..3).map(rest).fold(0.0, f64::max),
                alpha_off: (rest(3) - target.relative).max(0.0),
                of_target: (0..3).map(relative).fold(0.0, f64::max),
                states_target: claim.states(target),
                reference,
            }
        };
        let [x, y] = pixel;
        let judged = compare(quadrature.pixel(x, y, TOLERANCE));
        if judged.holds() || !judged.claim.is_bound {
            return judged;
        }
        // Before a bound is called broken, the oracle looks closer, from other points.
        let closer = quadrature
            .clone()
            .with_budget(BUDGET_AGAIN)
            .with_seed(seed + 1);
        compare(closer.pixel(x, y, AGAIN))
    };
    findings.judged = chosen.into_par_iter().map(judge_one).collect();
    let unresolved = findings
        .judged
        .iter()
        .filter(|judged| !judged.reference.is_resolved);
    findings.unresolved = unresolved.count();
    findings
}

/// A scene's film with its errors, and the target with the floor that it had.
fn rendered(scene: &Scene, relative: f64) -> Option<(Claims, ErrorTarget)> {
    let (world, camera) = World::new(scene).unwrap_or_else(|error| panic!("{error}"));
    let plain = render(&world, &camera, &Options::default()).unwrap();
    let sum: f64 = plain.pixels().iter().map(|pixel| f64::from(pixel[1])).sum();
    let floor = 0.01 * sum / plain.pixels().len() as f64;
    if floor <= 0.0 || floor.is_nan() {
        return None;
    }
    let target = ErrorTarget {
        floor: Some(floor),
        ..ErrorTarget::new(relative)
    };
    let layers = Layers {
        error: true,
        samples: true,
        ..Layers::default()
    };
    let options = Options {
        target: Some(target),
        layers,
        ..Options::default()
    };
    let film = render(&world, &camera, &options).unwrap();
    Some((Claims::of(&film), target))
}

fn pixels() -> usize {
    match std::env::var(VARIABLE) {
        Ok(count) => count
            .parse()
            .expect("CANDELA_HONESTY is a number of pixels"),
        Err(_) => PIXELS,
    }
}

/// Judges scenes into one pool.
fn sweep(scenes: &[(String, Scene)], relative: f64, pool: &mut Pool) {
    let count = pixels();
    for (number, (name, scene)) in scenes.iter().enumerate() {
        let Some((claims, target)) = rendered(scene, relative) else {
            continue;
        };
        let findings = judge(scene, &claims, &target, count, number as u64);
        let worst = |is_bound: bool| {
            let ratios = findings
                .of(is_bound)
                .map(|judged| judged.off / judged.stated.max(1e-300));
            ratios.fold(0.0, f64::max)
        };
        println!(
            "{name}: {} bounds, worst {:.3}; {} estimates, worst {:.3}, {:.4} hold, median {:.2}; {} silent, {} unresolved",
            findings.bounds,
            worst(true),
            findings.estimates,
            worst(false),
            findings.estimates_that_hold(),
            median(&findings.ratios()),
            findings.silent,
            findings.unresolved,
        );
        pool.add(name, &findings);
    }
}

/// How many objects and triangles the oracle, which has no tree, is asked about.
fn surfaces(scene: &Scene) -> usize {
    let of_object = |object: &Object| match object {
        Object::Mesh { geometry, .. } => geometry.triangles.len(),
        Object::Sphere { .. } | Object::Plane { .. } | Object::Triangle { .. } => 1,
    };
    scene
        .objects
        .iter()
        .map(|object| of_object(&object.value))
        .sum()
}

fn is_long() -> bool {
    pixels() >= LONG
}

/// The true mean of a pixel under lights with an area takes seconds, as it does over mirrors: those scenes are for the long
/// sweep.
fn has_areas(scene: &Scene) -> bool {
    let mut lights = scene.lights.iter();
    lights.any(|light| matches!(light.value, Light::Area { .. }))
}

fn files() -> Vec<(String, Scene)> {
    /// More surfaces are for the long sweep.
    const FEW: usize = 500;
    scene_files()
        .iter()
        .map(|path| {
            let scene = Scene::load(path).unwrap_or_else(|error| panic!("{error}"));
            (name_of(path), at_width(scene, WIDTH))
        })
        .filter(|(_, scene)| {
            let is_short = surfaces(scene) <= FEW && !has_areas(scene) && !is_smooth(scene);
            is_long() || is_short
        })
        .collect()
}

fn generated(folder: &Path) -> Vec<(String, Scene)> {
    let every = if is_long() { 1 } else { EVERY };
    let scenes = (0..60).map(|seed| generate::scene(seed, folder));
    // Kinds come in tens: of each ten others.
    scenes
        .chain(generate::spots(30, folder))
        .chain(generate::terminators(10, folder))
        .enumerate()
        .filter(|(number, _)| (number + number / 10) % every == 0)
        .map(|(_, scene)| scene)
        .collect()
}

/// `scenes/`, generated scenes, and scenes that are hard to bound.
#[test]
fn stated_errors_are_honest() {
    let mut pool = Pool::default();
    sweep(&files(), TARGET, &mut pool);
    let folder = tempfile::tempdir().unwrap();
    sweep(&generated(folder.path()), TARGET, &mut pool);
    let hard = scenes::all().into_iter();
    let hard: Vec<(String, Scene)> = hard.map(|(name, text)| (name, parse(&text))).collect();
    sweep(&hard, TARGET, &mut pool);
    pool.print();
    let objections = pool.objections();
    assert!(objections.is_empty(), "{}", objections.join("\n"));
}

/// The judge can find fault: with films that are off by more than they state, with estimates that are too small, and
/// with pixels that miss the target and do not say so.
#[test]
fn dishonest_films_are_found_out() {
    let scene = at_width(Scene::builtin(), WIDTH);
    let (honest, target) = rendered(&scene, TARGET).unwrap();
    let objections = |claims: &Claims| {
        let mut pool = Pool::default();
        pool.add("lecture", &judge(&scene, claims, &target, 40, 7));
        pool.objections()
    };
    // Of this scene few pixels are estimates, and state more of their errors than those of all scenes do.
    let mut found = objections(&honest);
    found.retain(|objection| !objection.contains("in the median"));
    assert_eq!(found, Vec::<String>::new());
    let altered = |alter: &dyn Fn(&mut Claim)| {
        let mut claims = honest.clone();
        claims.pixels.iter_mut().for_each(alter);
        objections(&claims)
    };
    let is_about =
        |found: &[String], what: &str| found.iter().any(|objection| objection.contains(what));

    let found = altered(&|claim| {
        if claim.is_bound {
            claim.value[1] += 1.5 * claim.error + 1e-3 * claim.value[1];
        }
    });
    assert!(is_about(&found, "a bound is broken"), "{found:?}");

    let found = altered(&|claim| {
        if claim.is_bound {
            claim.value[3] -= 0.02;
        }
    });
    assert!(is_about(&found, "a bound is broken"), "{found:?}");

    let found = altered(&|claim| {
        if !claim.is_bound {
            claim.error *= 1e-4;
        }
    });
    assert!(is_about(&found, "of the estimates hold"), "{found:?}");

    let found = altered(&|claim| claim.error = 0.1 * claim.value[0] + 1.0);
    assert!(is_about(&found, "do not say so"), "{found:?}");
    assert!(is_about(&found, "in the median"), "{found:?}");

    let found = altered(&|claim| claim.value[0] *= 1.05);
    assert!(is_about(&found, "by their true error"), "{found:?}");
}
