//! The lines at which what bounds their hidden pieces changes: where a curve begins or ends, and where one passes
//! another or the end of the light.

use super::curve::Curve;
use super::structure::Structure;
use super::view::Line;
use super::{FEW, Integrator, NARROWEST};

/// How far from a line its neighbors are at which it is decided whether something changes there.
const BESIDE: f64 = 1e-9;

/// The same for rows that are roots of a polynomial of degree 4.
const FAR_BESIDE: f64 = 1e-6;

/// How far off a line's ends a point is looked at as if it were on it.
const OUTSIDE: f64 = 1e-6;

/// A change is found to so much of all lines.
const FOUND: f64 = 1e-13;

/// The most changes that are looked for between two lines.
const MOST_BETWEEN: usize = 16;

/// A line at which something may change.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    parameter: f64,
    /// Whether a curve turns there, so that what is between its sides grows like a root.
    turns: bool,
    beside: f64,
}

/// Lines at which something changes, and those among them at which a curve turns.
#[derive(Debug, Default)]
pub(super) struct Events {
    pub(super) places: Vec<f64>,
    pub(super) turns: Vec<f64>,
}

impl Integrator<'_> {
    /// All of them, if there are few occluders. Of more it is not looked for where their curves pass each other, and
    /// the search ends when so much has been asked.
    pub(super) fn events(&mut self, range: [f64; 2], most: usize) -> Events {
        let mut candidates = self.candidates(range);
        candidates.sort_by(|a, b| a.parameter.total_cmp(&b.parameter));
        let size = range[1] - range[0];
        candidates.dedup_by(|next, kept| {
            let is_same =
                next.parameter - kept.parameter <= NARROWEST * size && next.beside == kept.beside;
            kept.turns |= is_same && next.turns;
            is_same
        });
        let mut events = Events::default();
        for candidate in candidates {
            if self.asked > most {
                break;
            }
            let beside = candidate.beside * size;
            let around = [candidate.parameter - beside, candidate.parameter + beside]
                .map(|parameter| (parameter, self.structure_at(parameter, 0.0)));
            if around[0].1 == around[1].1 {
                continue;
            }
            if candidate.beside > BESIDE {
                events.places.extend(self.changes(&around, size));
            } else {
                events.places.push(candidate.parameter);
            }
            if candidate.turns {
                events.turns.push(candidate.parameter);
            }
        }
        events
    }

    fn candidates(&self, range: [f64; 2]) -> Vec<Candidate> {
        let outline = Curve::outline(self.view, self.kernel.horizon);
        let least = NARROWEST * (range[1] - range[0]);
        let mut candidates = Vec::new();
        let occluders = self.occluders;
        for (i, occluder) in occluders.iter().enumerate() {
            let mut add = |[row, s]: [f64; 2], turns: bool, other: Option<usize>| {
                if row.is_nan() || row.abs() >= 1.0 {
                    return;
                }
                let parameter = self.view.parameter(row);
                if parameter <= range[0] + least || parameter >= range[1] - least {
                    return;
                }
                let mut beside = FAR_BESIDE;
                if !s.is_nan() {
                    let line = self.line_at(parameter);
                    let is_end = |of: usize| occluders[of].may_end_at(line.at(s));
                    if !is_on(&line, s) || !is_end(i) || other.is_some_and(|of| !is_end(of)) {
                        return;
                    }
                    beside = BESIDE;
                }
                candidates.push(Candidate {
                    parameter,
                    turns,
                    beside,
                });
            };
            for (k, curve) in occluder.curves.iter().enumerate() {
                for turn in curve.turns() {
                    add(turn, true, None);
                }
                for other in outline.iter().chain(&occluder.curves[k + 1..]) {
                    curve.crossings(other, |point| add(point, false, None));
                }
            }
            if occluders.len() > FEW {
                continue;
            }
            for (j, other) in occluders.iter().enumerate().skip(i + 1) {
                if !occluder.may_meet(other) {
                    continue;
                }
                for curve in &occluder.curves {
                    for of_other in &other.curves {
                        curve.crossings(of_other, |point| add(point, false, Some(j)));
                    }
                }
            }
        }
        candidates
    }

    /// Where structures change between lines that are in order, found by bisection.
    pub(super) fn changes(&mut self, lines: &[(f64, Structure)], size: f64) -> Vec<f64> {
        let mut found = Vec::new();
        for pair in lines.windows(2) {
            let mut open = vec![(pair[0], pair[1])];
            let mut left = MOST_BETWEEN;
            while let Some((low, high)) = open.pop() {
                if low.1 == high.1 || left == 0 {
                    continue;
                }
                let middle = 0.5 * (low.0 + high.0);
                if high.0 - low.0 <= FOUND * size || middle <= low.0 || middle >= high.0 {
                    found.push(middle);
                    left -= 1;
                    continue;
                }
                let middle = (middle, self.structure_at(middle, NARROWEST));
                open.extend([(middle, high), (low, middle)]);
            }
        }
        found
    }
}

/// Whether a place is on a line, or hardly beyond its ends.
fn is_on(line: &Line, s: f64) -> bool {
    s >= line.ends[0] - OUTSIDE && s <= line.ends[1] + OUTSIDE
}
