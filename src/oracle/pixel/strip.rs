//! Strips of a pixel whose lines have the same pieces, and the integral over them.

use super::gauss::SEVEN;
use super::line::{Hints, Integral, LEAST_SHARE, Line, middles_of};
use super::point::{Pace, Points, may_hide_a_peak};
use super::{Sum, splitmix};

/// Lines at the beginning, with as many points on each, so that nothing of more than a 16th of a pixel is missed, and
/// of what is thinner little.
const LINES: u32 = 16;

/// Two lines this near to each other, in pixels, may differ.
const NEAR: f64 = 1.0 / (1_u64 << 16) as f64;

/// And these are not looked between, whatever is there.
const NEAREST: f64 = 1.0 / (1_u64 << 29) as f64;

/// A strip is halved so often at most.
const DEPTH: u32 = 30;

/// Strips are looked at anew so often, after a line in between was found to have other pieces.
const ROUNDS: usize = 60;

/// What of the spread of values may lie between two lines that are [`NEAR`].
const UNSEEN: f64 = 0.02;

/// Integrates over one pixel.
pub(super) struct Strips<'p, 'q> {
    pub(super) points: &'p mut Points<'q>,
    /// Of x and of y.
    pub(super) ends: [[f64; 2]; 2],
    /// How far R, G, B, A may be off.
    pub(super) allowed: [f64; 4],
    pub(super) is_resolved: bool,
}

/// A part of a pixel whose lines have the same pieces.
#[derive(Clone, Copy, Debug)]
struct Strip {
    from: f64,
    to: f64,
    /// Whether pieces end there, so that the integral over lines may have the slope of a root.
    ends: [bool; 2],
}

/// An integral over a strip by one rule, and whether a peak may hide between its lines.
#[derive(Clone, Copy, Debug)]
struct Rough {
    sum: Sum,
    hides: bool,
}

impl Strip {
    fn halves(self) -> [Self; 2] {
        let middle = 0.5 * (self.from + self.to);
        [
            Self {
                to: middle,
                ends: [self.ends[0], false],
                ..self
            },
            Self {
                from: middle,
                ends: [false, self.ends[1]],
                ..self
            },
        ]
    }

    /// Where a line is and the slope of that, for s from 0 to 1: closer to each other where pieces end, so that a root
    /// is a polynomial of s.
    fn place(self, s: f64) -> [f64; 2] {
        match self.ends {
            [false, false] => [s, 1.0],
            [true, false] => [s * s, 2.0 * s],
            [false, true] => [s * (2.0 - s), 2.0 * (1.0 - s)],
            [true, true] => [s * s * (3.0 - 2.0 * s), 6.0 * s * (1.0 - s)],
        }
    }
}

impl Strips<'_, '_> {
    /// The lines at the beginning.
    pub(super) fn scan(&mut self, random: &mut u64) -> Vec<Line> {
        let [[left, right], [top, bottom]] = self.ends;
        let step = (right - left) / f64::from(LINES);
        let mut lines: Vec<Line> = Vec::new();
        for row in 0..=LINES {
            let y = if row == LINES {
                bottom
            } else {
                top + (bottom - top) * f64::from(row) / f64::from(LINES)
            };
            let mut seeds: Vec<f64> = (0..LINES)
                .map(|column| left + step * (f64::from(column) + splitmix(random)))
                .collect();
            let before = lines.last();
            seeds.extend(before.iter().flat_map(|line| line.middles()));
            let breaks: Vec<f64> = before.iter().flat_map(|line| line.breaks()).collect();
            let hints = Hints {
                seeds: &seeds,
                breaks: &breaks,
            };
            lines.push(self.points.line(y, self.ends[0], &hints));
        }
        // What one line has seen, the one before it may have missed.
        for row in (0..lines.len() - 1).rev() {
            self.look_again(&mut lines, row, row + 1);
        }
        for row in 1..lines.len() {
            self.look_again(&mut lines, row, row - 1);
        }
        self.look_between(&mut lines, random);
        lines
    }

    /// Adds lines through points between others that are not what they would be if nothing were between these.
    fn look_between(&mut self, lines: &mut Vec<Line>, random: &mut u64) {
        let left = self.ends[0][0];
        let step = (self.ends[0][1] - left) / f64::from(LINES);
        for row in (1..lines.len()).rev() {
            let (above, below) = (lines[row - 1].y, lines[row].y);
            let mut found: Vec<Line> = Vec::new();
            for column in 0..LINES {
                let x = left + step * (f64::from(column) + splitmix(random));
                let y = above + (below - above) * splitmix(random);
                let point = self.points.at(x, y);
                let [a, b] = [&lines[row - 1], &lines[row]];
                let near = |line: &Line| line.has_at(point.signature, [x - step, x + step]);
                if near(a) || near(b) {
                    continue;
                }
                let seeds: Vec<f64> = a.middles().chain(b.middles()).chain([x]).collect();
                let breaks: Vec<f64> = a.breaks().chain(b.breaks()).collect();
                let hints = Hints {
                    seeds: &seeds,
                    breaks: &breaks,
                };
                found.push(self.points.line(y, self.ends[0], &hints));
            }
            found.sort_by(|a, b| a.y.total_cmp(&b.y));
            found.dedup_by(|a, b| a.y == b.y);
            lines.splice(row..row, found);
        }
    }

    /// Parts a line anew where its neighbor has seen pieces. Whether it has others now.
    fn look_again(&mut self, lines: &mut [Line], row: usize, neighbor: usize) -> bool {
        let (line, other) = (&lines[row], &lines[neighbor]);
        if line.has_pieces_of(other) {
            return false;
        }
        let mut seeds: Vec<f64> = line.middles().chain(other.middles()).collect();
        if let Some(breaks) = other.continued(line.y) {
            seeds.extend(middles_of(self.ends[0][0], &breaks));
        }
        let breaks: Vec<f64> = line.breaks().chain(other.breaks()).collect();
        let hints = Hints {
            seeds: &seeds,
            breaks: &breaks,
        };
        let parted = self.points.line(line.y, self.ends[0], &hints);
        let is_new = !parted.has_pieces_of(line);
        if is_new {
            lines[row] = parted;
        }
        is_new
    }

    /// The integral over the pixel.
    pub(super) fn integral(&mut self, lines: Vec<Line>) -> Sum {
        let mut lines = self.resolved(lines);
        let mut known: Vec<([f64; 2], Sum)> = Vec::new();
        for round in 0.. {
            match self.by_strips(&lines, &mut known, round < ROUNDS) {
                Ok(sum) => return sum,
                Err(line) => {
                    let place = lines.partition_point(|other| other.y < line.y);
                    lines.insert(place, line);
                    lines = self.resolved(lines);
                }
            }
        }
        unreachable!("the last round finds no lines")
    }

    /// Adds lines until neighbors have the same pieces or are near to each other.
    fn resolved(&mut self, lines: Vec<Line>) -> Vec<Line> {
        let mut all: Vec<Line> = Vec::new();
        for line in lines {
            if let Some(last) = all.last().cloned() {
                self.resolve(&last, &line, &mut all);
            }
            all.push(line);
        }
        // Where a piece was followed up to a line that has not seen it, it is there as well.
        let mut is_changed = false;
        for row in 1..all.len() {
            is_changed |= self.look_again(&mut all, row, row - 1);
        }
        for row in (0..all.len() - 1).rev() {
            is_changed |= self.look_again(&mut all, row, row + 1);
        }
        if is_changed && self.points.may_go_on() {
            return self.resolved(all);
        }
        all
    }

    fn resolve(&mut self, a: &Line, b: &Line, all: &mut Vec<Line>) {
        let height = b.y - a.y;
        if a.has_pieces_of(b) || height <= NEAREST || !self.points.may_go_on() {
            return;
        }
        if height <= NEAR {
            let (left, right) = (self.value(a), self.value(b));
            let spread = self.points.spread();
            let is_near = (0..4).all(|channel| {
                let apart = (left[channel] - right[channel]).abs() + UNSEEN * spread[channel];
                height * apart <= 0.05 * self.allowed[channel]
            });
            if is_near {
                return;
            }
        }
        let y = 0.5 * (a.y + b.y);
        let mut seeds: Vec<f64> = a.middles().chain(b.middles()).collect();
        let mut breaks: Vec<f64> = Vec::new();
        for line in [a, b] {
            if let Some(continued) = line.continued(y) {
                seeds.extend(middles_of(self.ends[0][0], &continued));
                breaks.extend(continued);
            }
        }
        breaks.extend(a.breaks().chain(b.breaks()));
        let hints = Hints {
            seeds: &seeds,
            breaks: &breaks,
        };
        let mut middle = self.points.line(y, self.ends[0], &hints);
        let (mut a, mut b) = (a.clone(), b.clone());
        if middle.has_pieces_of(&a) {
            middle.drift_from(&a);
            a.drift.clone_from(&middle.drift);
        } else if middle.has_pieces_of(&b) {
            middle.drift_from(&b);
            b.drift.clone_from(&middle.drift);
        }
        self.resolve(&a, &middle, all);
        all.push(middle.clone());
        self.resolve(&middle, &b, all);
    }

    /// The integral over a line, roughly.
    fn value(&mut self, line: &Line) -> [f64; 4] {
        let mut line = line.clone();
        let (integral, _) = self.points.integral(&mut line, self.ends[0], self.allowed);
        integral.sum.value
    }

    fn by_strips(
        &mut self,
        lines: &[Line],
        known: &mut Vec<([f64; 2], Sum)>,
        is_strict: bool,
    ) -> Result<Sum, Line> {
        let mut sum = Sum::default();
        let mut first = 0;
        for row in 0..lines.len() {
            let is_last = row + 1 == lines.len();
            if !is_last && lines[row].has_pieces_of(&lines[row + 1]) {
                continue;
            }
            if row > first {
                let place = [lines[first].y, lines[row].y];
                let found = known
                    .iter()
                    .find(|(of, _)| *of == place)
                    .map(|(_, sum)| *sum);
                let strip = match found {
                    Some(strip) => strip,
                    None => {
                        let mut table = lines[first..=row].to_vec();
                        let strip = Strip {
                            from: place[0],
                            to: place[1],
                            ends: [first > 0, !is_last],
                        };
                        let strip = self.strip(&mut table, strip, DEPTH, is_strict)?;
                        known.push((place, strip));
                        strip
                    }
                };
                sum.add(1.0, &strip.value, &strip.error);
            }
            if !is_last {
                let strip = self.between(&lines[row], &lines[row + 1]);
                sum.add(1.0, &strip.value, &strip.error);
            }
            first = row + 1;
        }
        Ok(sum)
    }

    /// The integral between two lines of which little is known.
    fn between(&mut self, a: &Line, b: &Line) -> Sum {
        let height = b.y - a.y;
        let (left, right) = (self.value(a), self.value(b));
        let spread = self.points.spread();
        // Farther apart they are only where the points ran out.
        let is_near = height <= NEAR;
        self.is_resolved &= is_near;
        let value = std::array::from_fn(|channel| 0.5 * (left[channel] + right[channel]));
        let error = std::array::from_fn(|channel| {
            let unseen = if is_near { UNSEEN } else { 1.0 };
            0.5 * (left[channel] - right[channel]).abs() + unseen * spread[channel]
        });
        let mut sum = Sum::default();
        sum.add(height, &value, &error);
        sum
    }

    /// The integral over a strip: of all of it and of its halves, again and again until these agree.
    fn strip(
        &mut self,
        table: &mut Vec<Line>,
        strip: Strip,
        depth: u32,
        is_strict: bool,
    ) -> Result<Sum, Line> {
        let whole = self.whole(table, strip, is_strict)?;
        self.halved(table, strip, whole, depth, is_strict)
    }

    fn halved(
        &mut self,
        table: &mut Vec<Line>,
        strip: Strip,
        whole: Rough,
        depth: u32,
        is_strict: bool,
    ) -> Result<Sum, Line> {
        let height = strip.to - strip.from;
        let halves = strip.halves();
        let [first, second] = halves;
        let parts = [
            self.whole(table, first, is_strict)?,
            self.whole(table, second, is_strict)?,
        ];
        let mut sum = parts[0].sum;
        sum.add(1.0, &parts[1].sum.value, &parts[1].sum.error);
        let apart: [f64; 4] =
            std::array::from_fn(|channel| (whole.sum.value[channel] - sum.value[channel]).abs());
        let share = height.max(LEAST_SHARE);
        let is_near = (0..4).all(|channel| {
            let noise = height * self.points.noise[channel];
            apart[channel] <= self.allowed[channel] * share + noise
        });
        let hides = parts.iter().any(|part| part.hides);
        let can_go_on = depth > 0 && height > NEAREST && self.points.may_go_on();
        if (is_near && !hides) || !can_go_on {
            if !is_near || hides {
                self.is_resolved &= height <= NEAR;
            }
            let spread = self.points.spread();
            for channel in 0..4 {
                sum.error[channel] += apart[channel];
                if hides {
                    sum.error[channel] += height * spread[channel];
                }
            }
            return Ok(sum);
        }
        let mut sum = Sum::default();
        for (side, whole) in halves.into_iter().zip(parts) {
            let part = self.halved(table, side, whole, depth - 1, is_strict)?;
            sum.add(1.0, &part.value, &part.error);
        }
        Ok(sum)
    }

    /// The integral over a strip by one rule.
    fn whole(
        &mut self,
        table: &mut Vec<Line>,
        strip: Strip,
        is_strict: bool,
    ) -> Result<Rough, Line> {
        let height = strip.to - strip.from;
        let mut sum = Sum::default();
        let mut paces: Vec<Vec<Pace>> = Vec::new();
        for &[s, weight] in SEVEN {
            let [place, slope] = strip.place(s);
            let y = strip.from + height * place;
            let integral = self.line_of(table, y, height, is_strict)?;
            sum.add(
                slope * weight * height,
                &integral.sum.value,
                &integral.sum.error,
            );
            paces.push(integral.paces);
        }
        let hides = paces
            .windows(2)
            .any(|pair| may_hide_a_peak(&pair[0], &pair[1]));
        Ok(Rough { sum, hides })
    }

    /// The integral over a line of a strip; an error if it has other pieces.
    fn line_of(
        &mut self,
        table: &mut Vec<Line>,
        y: f64,
        height: f64,
        is_strict: bool,
    ) -> Result<Integral, Line> {
        let place = table
            .partition_point(|line| line.y < y)
            .clamp(1, table.len() - 1);
        let breaks = expected(table, place, y);
        let mut seeds = middles_of(self.ends[0][0], &breaks);
        if !breaks.is_empty() {
            seeds.extend(table[place - 1].middles().chain(table[place].middles()));
        }
        let hints = Hints {
            seeds: &seeds,
            breaks: &breaks,
        };
        let mut line = self.points.line(y, self.ends[0], &hints);
        let share = (LEAST_SHARE / height).max(1.0);
        let allowed = self.allowed.map(|allowed| allowed * share);
        let (integral, _) = self.points.integral(&mut line, self.ends[0], allowed);
        if !line.has_pieces_of(&table[place]) {
            if is_strict && self.points.may_go_on() {
                return Err(line);
            }
            self.is_resolved = false;
            return Ok(self.uncertain(integral));
        }
        if table[place].y != y && table[place - 1].y != y {
            table.insert(place, line);
        }
        Ok(integral)
    }

    /// An integral that may be anything that is in the pixel.
    fn uncertain(&self, mut integral: Integral) -> Integral {
        for (error, spread) in integral.sum.error.iter_mut().zip(self.points.spread()) {
            *error += spread;
        }
        integral
    }
}

/// Where pieces end at `y`, from the lines around: a polynomial through up to four of them.
fn expected(table: &[Line], place: usize, y: f64) -> Vec<f64> {
    let from = place.saturating_sub(2).min(table.len().saturating_sub(4));
    let near = &table[from..(from + 4).min(table.len())];
    let weights: Vec<f64> = (0..near.len())
        .map(|i| {
            let others = (0..near.len()).filter(|&j| j != i);
            others
                .map(|j| (y - near[j].y) / (near[i].y - near[j].y))
                .product()
        })
        .collect();
    let count = near[0].pieces.len() - 1;
    (0..count)
        .map(|at| {
            near.iter()
                .zip(&weights)
                .map(|(line, weight)| weight * line.pieces[at].to)
                .sum()
        })
        .collect()
}
