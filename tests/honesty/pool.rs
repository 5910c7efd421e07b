//! What is found of many scenes together: four pixels of one say little.

use std::collections::BTreeMap;

use super::{Findings, MET};

/// The part of all estimates that has to hold.
const ESTIMATES_THAT_HOLD: f64 = 0.99;

/// What estimates state of their true errors in the median, at most, over all scenes but [`FAR_BETTER`].
const MEDIAN: f64 = 10.0;

/// Deviations of a binomial distribution by which a count may be above its mean: one in forty is further off.
const DEVIATIONS: f64 = 2.0;

/// Scenes, and kinds of generated ones, whose estimates are in the median more than [`MEDIAN`] times the true error,
/// and the median that was found once: of 40 pixels a scene, but of 4 from `many-lights` to `units` and of the
/// horizon, and of 4 to 12 of a generated kind. An estimate has room for an edge and for listed shapes that no sample
/// has met; where they are not in the pixel, the mean is far nearer. Dense meshes (`torus`) and what touches
/// (`contacts`) list the most.
const FAR_BETTER: &[(&str, f64)] = &[
    ("blackbody", 2.6e6),
    ("colorchecker", 200.0),
    ("colorchecker-a", 45.0),
    ("colorchecker-f11", 150.0),
    ("colorchecker-hp1", 130.0),
    ("colorchecker-led-b3", 240.0),
    ("diffuse", 13.0),
    ("first", 15.0),
    ("inside", 520.0),
    ("inverse-square", 30.0),
    ("many-lights", 77.0),
    ("metamers", 26.0),
    ("normalized", 20.0),
    ("orthographic", 12.0),
    ("perspective", 35.0),
    ("specular", 16.0),
    ("units", 5e3),
    ("contacts", 210.0),
    ("crowd", 32.0),
    ("grazing", 100.0),
    ("near lights", 450.0),
    ("room", 12.0),
    ("shards", 16.0),
    ("terminators", 230.0),
    ("torus", 1.1e3),
    ("a horizon, and a light in a plane, perspective", 7.7e3),
    ("a sharp cone, perspective", 16.0),
    ("a sharp cone, orthographic", 18.0),
    ("coincident planes and spheres, perspective", 740.0),
    ("coincident planes and spheres, orthographic", 230.0),
    ("inside a sphere, a light outside of it, orthographic", 66.0),
    ("intersecting spheres, perspective", 150.0),
    ("intersecting spheres, orthographic", 18.0),
    ("lights near surfaces, perspective", 460.0),
    ("lights near surfaces, orthographic", 140.0),
    ("sharp highlights, perspective", 320.0),
    ("sharp highlights, orthographic", 18.0),
    ("walls edge-on, perspective", 86.0),
    ("walls edge-on, orthographic", 15.0),
];

/// Pixels of a scene from which on its median tells whether it is still among [`FAR_BETTER`].
const MANY: usize = 40;

#[derive(Debug, Default)]
pub(super) struct Pool {
    bounds: usize,
    estimates: usize,
    holding: usize,
    /// Stated over true errors of estimates, by scene or kind.
    ratios: BTreeMap<String, Vec<f64>>,
    judged: usize,
    /// Pixels that miss the target and state to meet it.
    missing: usize,
    objections: Vec<String>,
}

impl Pool {
    pub(super) fn add(&mut self, name: &str, findings: &Findings) {
        self.bounds += findings.of(true).count();
        self.estimates += findings.of(false).count();
        self.holding += findings.of(false).filter(|judged| judged.holds()).count();
        self.judged += findings.judged.len();
        let all = findings.judged.iter();
        self.missing += all
            .filter(|judged| !judged.meets_target_or_says_not())
            .count();
        let ratios = self.ratios.entry(kind(name).to_owned()).or_default();
        ratios.extend(findings.ratios());
        let found = findings.objections().into_iter();
        self.objections
            .extend(found.map(|objection| format!("{name}: {objection}")));
    }

    pub(super) fn print(&self) {
        println!(
            "{} bounds; {} of {} estimates hold, median {:.2}; {} of {} pixels miss the target and do not say so",
            self.bounds,
            self.holding,
            self.estimates,
            self.median(),
            self.missing,
            self.judged
        );
        for (kind, ratios) in &self.ratios {
            println!(
                "  {kind}: {} with median {:.2}",
                ratios.len(),
                median(ratios)
            );
        }
    }

    /// Over all scenes but those that are known to be far better.
    fn median(&self) -> f64 {
        let counted = self.ratios.iter().filter(|(kind, _)| !is_far_better(kind));
        let ratios: Vec<f64> = counted.flat_map(|(_, ratios)| ratios.clone()).collect();
        median(&ratios)
    }

    pub(super) fn objections(&self) -> Vec<String> {
        let mut objections = self.objections.clone();
        if self.estimates - self.holding > most(self.estimates, 1.0 - ESTIMATES_THAT_HOLD) {
            objections.push(format!(
                "{} of {} of the estimates hold",
                self.holding, self.estimates
            ));
        }
        if self.missing > most(self.judged, 1.0 - MET) {
            objections.push(format!(
                "{} of {} pixels miss the target by their true error",
                self.missing, self.judged
            ));
        }
        if self.median() > MEDIAN {
            objections.push(format!(
                "estimates state {:.1} of their errors in the median",
                self.median()
            ));
        }
        for (kind, ratios) in &self.ratios {
            let found = median(ratios);
            // By half, as of any figure that is measured.
            if is_far_better(kind) && ratios.len() >= MANY && 2.0 * found < MEDIAN {
                objections.push(format!("{kind}: {found:.1} in the median is no exception"));
            }
        }
        objections
    }
}

/// What a scene is called in [`FAR_BETTER`]: a generated one, whose name has a number, by its kind.
fn kind(name: &str) -> &str {
    let kind = name.trim_start_matches(|c: char| c.is_ascii_digit() || c == ' ');
    kind.strip_suffix(" under spots").unwrap_or(kind)
}

fn is_far_better(kind: &str) -> bool {
    FAR_BETTER.iter().any(|(name, _)| *name == kind)
}

/// How many of so many may be, if each is with this probability.
fn most(count: usize, probability: f64) -> usize {
    let mean = count as f64 * probability;
    (mean + DEVIATIONS * (mean * (1.0 - probability)).sqrt()).floor() as usize
}

/// The middle one; 1 where there is none.
pub(super) fn median(numbers: &[f64]) -> f64 {
    let mut numbers = numbers.to_vec();
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied().unwrap_or(1.0)
}
