//! L9 over a light that has an area: L_o = ∫ L_e r(ω_i, ω_o) V(p, x) dω over its points x that face p and are above
//! the horizon of p.
//!
//! The light is cut into lines. From where to where each surface hides a line is known (`shadow`), so that what is left
//! are smooth pieces; these and then the lines are integrated by Kronrod's rule, and where it differs from Gauss's by
//! halves, those of the largest difference first.
//!
//! Panes hide nothing: where one is before a piece, that counts by T(θ), within the integral.
//!
//! A rule over lines is only as good as what it integrates is smooth, and does not see what is between its lines. Hence
//! they are parted where the curves that bound hidden pieces change (`structure`): at the lines where this is known to
//! happen (`events`), and wherever two lines of a rule turn out to differ in them.

mod curve;
mod events;
mod kronrod;
mod line;
mod polynomial;
mod shadow;
mod structure;
mod view;

use super::area::Area;
use super::occlusion::Segment;
use super::outcome::Outcome;
use super::surface::Surface;
use super::vector::{Vector, cross, dot, length, scale, unit};
use kronrod::nodes;
use line::angular;
use shadow::{Hidden, Occluder};
use structure::Structure;
use view::{Line, View, cosine};

/// Where something is in the way, rules may differ by less than both are off: by so much.
const KINKS: f64 = 8.0;

/// What rounding may be of all that is integrated.
const ROUNDING: f64 = 1e-13;

/// Parts of an interval that are not halved any more.
const NARROWEST: f64 = 1e-13;

/// Of so many surfaces it is looked for where any two of their edges pass each other; of more, the lines are so many
/// times 15 at least.
const FEW: usize = 24;
const PARTS: u32 = 16;

/// So much of all that may be asked goes into the search for events, if there are more surfaces.
const OF_EVENTS: usize = 4;

/// How often parts are parted where their lines differ in structure.
const MOST_PARTED: usize = 256;

/// How far within a part the first and the last line are that are compared with its others, and how far at least, of
/// all lines.
const WITHIN: f64 = 1e-6;
const WITHIN_ALL: f64 = 1e-11;

/// When an integral is good enough.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort {
    /// How far it may be off, relative to that of the light without anything in the way.
    pub(super) tolerance: f64,
    /// How often at most it is asked whether a surface is in the way of a line.
    pub(super) most: usize,
}

/// What is integrated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kernel {
    /// What the light has to be above of.
    pub(super) horizon: Vector,
    /// n
    pub(super) normal: Vector,
    /// Of the lobe: where it points and n.
    pub(super) lobe: Option<([f64; 3], f64)>,
    /// Whether the lobe has a cosine.
    pub(super) lobe_has_cosine: bool,
    /// How much errors of ∫ cos dω and of the lobe's integral count.
    pub(super) weights: [f64; 2],
}

/// What may be in the way: surfaces, and which of them p is on.
pub(super) struct Scene<'s> {
    pub(super) surfaces: &'s [Surface],
    pub(super) own: usize,
    /// The light's own number, which is not in its own way.
    pub(super) light: Option<usize>,
    /// The refractive index of a surface that is a pane.
    pub(super) pane: &'s dyn Fn(usize) -> Option<f64>,
}

/// ∫ dω, ∫ cos(n, ω_i) dω, ∫ cosⁿ(ω_o, ω_r) dω with the factors of the model that depend on ω_i.
pub(super) type Triple = [f64; 3];

/// The integrals over a light.
#[derive(Clone, Debug)]
pub(super) struct Integrals {
    /// With V = 1.
    pub(super) whole: Triple,
    pub(super) seen: Triple,
    /// How far each may be off.
    pub(super) error: Triple,
    /// The surfaces that hide a part of it.
    pub(super) occluders: Vec<usize>,
    /// The panes before a part of it.
    pub(super) panes: Vec<usize>,
    /// The direction of the light that is nearest to the lobe's.
    pub(super) peak: Option<Vector>,
    /// The shortest way to the light.
    pub(super) nearest: Vector,
}

/// The integrals over a light as seen from where the segment to its middle begins, or why there is nothing of it.
pub(super) fn integrals(
    area: &Area,
    segment: &Segment,
    kernel: &Kernel,
    scene: &Scene<'_>,
    among: impl Iterator<Item = usize>,
    effort: Effort,
) -> Result<Integrals, Outcome> {
    let view = View::new(area, segment.from).ok_or(Outcome::Outside)?;
    let parameters = view.parameters(kernel.horizon);
    let (range, mut places) = parameters.ok_or(Outcome::Below)?;
    let occluders: Vec<Occluder> = among
        .filter_map(|index| {
            let surface = &scene.surfaces[index];
            if surface.light.is_some() && surface.light == scene.light {
                return None;
            }
            let is_own = index == scene.own;
            let occluder = Occluder::new(index, surface, segment, is_own, &view)?;
            Some(occluder.of_pane((scene.pane)(index)))
        })
        .collect();
    let mut integrator = Integrator {
        view: &view,
        kernel,
        hides: vec![false; occluders.len()],
        occluders: &occluders,
        asked: 0,
        found: Vec::new(),
        covered: Vec::new(),
        turns: Vec::new(),
        least: NARROWEST * (range[1] - range[0]),
        partings: MOST_PARTED,
    };
    let most_of_events = if occluders.len() <= FEW {
        usize::MAX
    } else {
        let part = |i: u32| range[0] + (range[1] - range[0]) * f64::from(i) / f64::from(PARTS);
        places.extend((1..PARTS).map(part));
        effort.most / OF_EVENTS
    };
    let events = integrator.events(range, most_of_events);
    places.extend(events.places);
    integrator.turns = events.turns;
    let nearest = integrator.best(range, |direction| -length(direction), Line::nearest);
    let peak = kernel.lobe.map(|(way, exponent)| {
        let most_along = |line: &Line| line.most_along(way);
        let peak = integrator.best(range, |direction| cosine(way, direction), most_along);
        let width = lobe_width(way, exponent, peak.1);
        integrator.part_around(peak, width, range, &mut places);
        unit(peak.1).unwrap_or(way)
    });
    integrator.part_around(nearest, 1.0, range, &mut places);
    let mut integrals = integrator.over_lines(range, places, effort);
    integrals.peak = peak;
    integrals.nearest = scale(nearest.1, view.part_to(nearest.1));
    let hides = integrator.hides.iter().zip(&occluders);
    let hides = hides.filter_map(|(&hides, occluder)| hides.then_some(occluder));
    let (panes, opaque): (Vec<&Occluder>, Vec<&Occluder>) =
        hides.partition(|occluder| occluder.is_pane());
    integrals.occluders = opaque.iter().map(|occluder| occluder.surface).collect();
    integrals.panes = panes.iter().map(|occluder| occluder.surface).collect();
    Ok(integrals)
}

/// The angle within which a lobe changes at a direction: where it falls, faster than at its middle.
fn lobe_width(way: Vector, exponent: f64, direction: Vector) -> f64 {
    let tangent = length(cross(way, direction)) / dot(way, direction).abs();
    2.0 / (exponent.sqrt() + exponent * tangent)
}

/// Of all that is integrated: without anything in the way, what is seen, and how far both may be off.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    whole: Triple,
    seen: Triple,
    error: Triple,
}

impl Sum {
    fn add(&mut self, other: &Self, factor: f64) {
        for i in 0..3 {
            self.whole[i] += factor * other.whole[i];
            self.seen[i] += factor * other.seen[i];
            self.error[i] += factor * other.error[i];
        }
    }

    /// This by the finer of two rules, with how far that is from the coarser one.
    fn compared(mut self, coarse: &Self) -> Self {
        for i in 0..3 {
            let whole = (self.whole[i] - coarse.whole[i]).abs();
            let mut seen = (self.seen[i] - coarse.seen[i]).abs();
            if self.seen[i] != self.whole[i] {
                seen *= KINKS;
            }
            self.error[i] += whole.max(seen);
        }
        self
    }
}

/// Lines from one to another.
#[derive(Clone, Copy, Debug)]
struct Span {
    ends: [f64; 2],
    /// At which ends a curve turns.
    turns: [bool; 2],
}

impl Span {
    fn size(&self) -> f64 {
        self.ends[1] - self.ends[0]
    }

    /// A place within, from 0 to 1, and how fast it changes. What grows like a root at an end is smooth in these.
    fn at(&self, u: f64) -> [f64; 2] {
        let size = self.size();
        let (part, slope) = match self.turns {
            [false, false] => (u, 1.0),
            [true, false] => (u * u, 2.0 * u),
            [false, true] => (u * (2.0 - u), 2.0 * (1.0 - u)),
            [true, true] => (u * u * (3.0 - 2.0 * u), 6.0 * u * (1.0 - u)),
        };
        [self.ends[0] + size * part, size * slope]
    }

    fn parted(self, places: &[f64]) -> impl Iterator<Item = Self> {
        let cuts: Vec<f64> = [self.ends[0]]
            .iter()
            .chain(places)
            .chain(&[self.ends[1]])
            .copied()
            .collect();
        let last = cuts.len() - 2;
        (0..=last).map(move |i| Self {
            ends: [cuts[i], cuts[i + 1]],
            turns: [i == 0 && self.turns[0], i == last && self.turns[1]],
        })
    }
}

#[derive(Clone, Copy, Debug)]
struct Part {
    span: Span,
    sum: Sum,
}

/// A line of a rule.
#[derive(Clone, Copy, Debug)]
struct Sample {
    parameter: f64,
    structure: Structure,
    /// By how much the integral changes with the parameter.
    seen: Triple,
}

struct Integrator<'a> {
    view: &'a View,
    kernel: &'a Kernel,
    occluders: &'a [Occluder],
    /// Whether each was found to hide something.
    hides: Vec<bool>,
    /// How often it was asked whether one is in the way of a line, plus the lines.
    asked: usize,
    /// What of a line is hidden.
    found: Vec<Hidden>,
    /// What of it is behind a pane, and which.
    covered: Vec<(Hidden, usize)>,
    /// Lines where curves turn.
    turns: Vec<f64>,
    /// The size of parts that are not halved any more.
    least: f64,
    /// How often parts may still be parted where their lines differ.
    partings: usize,
}

impl Integrator<'_> {
    /// How much an error counts.
    fn weighted(&self, triple: &Triple) -> f64 {
        let [diffuse, lobe] = self.kernel.weights;
        diffuse * triple[1] + lobe * triple[2]
    }

    fn line_at(&self, parameter: f64) -> Line {
        self.view.line(parameter, self.kernel.horizon)
    }

    /// The parameter and the direction at which something is largest, that falls to all sides of there.
    fn best(
        &self,
        range: [f64; 2],
        value: impl Fn(Vector) -> f64,
        of_line: impl Fn(&Line) -> f64,
    ) -> (f64, Vector) {
        let direction = |parameter: f64| {
            let line = self.line_at(parameter);
            line.at(of_line(&line))
        };
        let [mut low, mut high] = range;
        for _ in 0..80 {
            let third = (high - low) / 3.0;
            let (a, b) = (low + third, high - third);
            if value(direction(a)) < value(direction(b)) {
                low = a;
            } else {
                high = b;
            }
        }
        let parameter = 0.5 * (low + high);
        (parameter, direction(parameter))
    }

    /// Parts lines around one, ever farther away: first where the direction is so many radians off.
    fn part_around(
        &self,
        (parameter, direction): (f64, Vector),
        width: f64,
        range: [f64; 2],
        places: &mut Vec<f64>,
    ) {
        let rows = width * length(direction) / angular(direction, self.view.across);
        let slope = self.line_at(parameter).slope;
        // Where a disk ends, lines are ever nearer to each other.
        graded(parameter, rows / slope.max(rows.sqrt()), range, places);
    }

    /// All lines.
    fn over_lines(&mut self, range: [f64; 2], mut places: Vec<f64>, effort: Effort) -> Integrals {
        places.extend(range);
        let places = sorted(places, range);
        let mut parts: Vec<Part> = Vec::with_capacity(places.len());
        for pair in places.windows(2) {
            let ends = [pair[0], pair[1]];
            let turns = |end: f64| {
                let mut turns = self.turns.iter();
                turns.any(|turn| (turn - end).abs() <= self.least)
            };
            let turns = ends.map(turns);
            self.add_parts(Span { ends, turns }, effort.most, &mut parts);
        }
        loop {
            let mut sum = Sum::default();
            let mut worst: Option<(usize, f64)> = None;
            for (index, part) in parts.iter().enumerate() {
                sum.add(&part.sum, 1.0);
                let error = self.weighted(&part.sum.error);
                let can_be_halved = part.span.size() > self.least;
                if can_be_halved && worst.is_none_or(|(_, most)| error > most) {
                    worst = Some((index, error));
                }
            }
            let is_enough =
                self.weighted(&sum.error) <= effort.tolerance * self.weighted(&sum.whole);
            let Some((index, _)) = worst.filter(|_| !is_enough && self.asked < effort.most) else {
                return Integrals {
                    whole: sum.whole,
                    seen: sum.seen,
                    error: std::array::from_fn(|i| sum.error[i] + ROUNDING * sum.whole[i]),
                    occluders: Vec::new(),
                    panes: Vec::new(),
                    peak: None,
                    nearest: self.view.middle,
                };
            };
            let span = parts.swap_remove(index).span;
            let middle = span.ends[0] + 0.5 * span.size();
            for span in span.parted(&[middle]) {
                self.add_parts(span, effort.most, &mut parts);
            }
        }
    }

    /// Integrates over lines, parted where these differ in structure.
    fn add_parts(&mut self, span: Span, most: usize, parts: &mut Vec<Part>) {
        let mut open = vec![span];
        while let Some(span) = open.pop() {
            let (mut part, lines) = self.part(span);
            let differ = |pair: &[Sample]| pair[0].structure != pair[1].structure;
            let is_one = !lines.windows(2).any(differ);
            if is_one {
                parts.push(part);
                continue;
            }
            if self.partings > 0 && self.asked < most && span.size() > 1e3 * self.least {
                self.partings -= 1;
                let lines: Vec<_> = lines
                    .iter()
                    .map(|line| (line.parameter, line.structure))
                    .collect();
                let size = self.least / NARROWEST;
                let places = sorted(
                    span.ends
                        .into_iter()
                        .chain(self.changes(&lines, size))
                        .collect(),
                    span.ends,
                );
                if places.len() > 2 {
                    open.extend(span.parted(&places[1..places.len() - 1]));
                    continue;
                }
            }
            // Wherever between two lines the change is.
            for pair in lines.windows(2).filter(|pair| differ(pair)) {
                let size = pair[1].parameter - pair[0].parameter;
                for (i, error) in part.sum.error.iter_mut().enumerate() {
                    *error += size * (pair[1].seen[i] - pair[0].seen[i]).abs();
                }
            }
            parts.push(part);
        }
    }

    /// By one rule, with its lines in order, and two more at the ends.
    fn part(&mut self, span: Span) -> (Part, Vec<Sample>) {
        let (mut fine, mut coarse) = (Sum::default(), Sum::default());
        let mut lines = Vec::with_capacity(17);
        for [u, of_fine, of_coarse] in nodes([0.0, 1.0]) {
            let [parameter, speed] = span.at(u);
            let line = self.line_at(parameter);
            let (sum, structure) = self.line(&line);
            fine.add(&sum, of_fine * speed * line.slope);
            coarse.add(&sum, of_coarse * speed * line.slope);
            lines.push(Sample {
                parameter,
                structure,
                seen: sum.seen.map(|seen| seen * line.slope),
            });
        }
        lines.sort_by(|a, b| a.parameter.total_cmp(&b.parameter));
        let within = (WITHIN * span.size()).max(WITHIN_ALL / NARROWEST * self.least);
        if !self.occluders.is_empty() && within < 1e-3 * span.size() {
            let [from, to] = span.ends;
            let mut sample = |parameter: f64, like: Sample| Sample {
                parameter,
                structure: self.structure_at(parameter, NARROWEST),
                ..like
            };
            let first = sample(from + within, lines[0]);
            let last = sample(to - within, lines[lines.len() - 1]);
            lines.insert(0, first);
            lines.push(last);
        }
        let sum = fine.compared(&coarse);
        (Part { span, sum }, lines)
    }
}

/// Adds places around one, each step three times the one before.
fn graded(middle: f64, step: f64, [from, to]: [f64; 2], places: &mut Vec<f64>) {
    let size = to - from;
    // Not a number is no step.
    if step.is_nan() || step >= size {
        return;
    }
    let mut step = step.max(1e-9 * size);
    places.push(middle);
    while step < size {
        places.extend([middle - step, middle + step]);
        step *= 3.0;
    }
}

/// In order, within a range, without what is hardly apart.
fn sorted(mut places: Vec<f64>, [from, to]: [f64; 2]) -> Vec<f64> {
    let least = NARROWEST * (to - from);
    places.retain(|&place| {
        place == from || place == to || place > from + least && place < to - least
    });
    places.sort_by(f64::total_cmp);
    places.dedup_by(|a, b| *a - *b <= least);
    places
}
