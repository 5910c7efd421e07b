//! A line of a pixel: its smooth pieces, and the integral over them.

use super::Sum;
use super::gauss::{FIVE, THREE};
use super::point::{Pace, Point, Points, Signature, may_hide_a_peak};

/// How exactly it is known where a piece ends, in pixels.
pub(super) const BREAK: f64 = 2e-9;

/// A narrower piece is not integrated, but bounded.
const NARROW: f64 = 1e-7;

/// A piece is halved so often at most.
const DEPTH: u32 = 34;

/// The part of the allowed error that a part of a line or a pixel gets at least.
pub(super) const LEAST_SHARE: f64 = 0.05;

/// So many points of a line that are not what their piece is may show what was missed.
const SURPRISES: usize = 40;

/// A part of a line along which values change smoothly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    pub(super) from: f64,
    pub(super) to: f64,
    pub(super) signature: Signature,
}

/// A line across a pixel, y = const.
#[derive(Clone, Debug)]
pub(super) struct Line {
    pub(super) y: f64,
    pub(super) pieces: Vec<Piece>,
    /// dx/dy of where pieces end, as far as it is known.
    pub(super) drift: Option<Vec<f64>>,
}

/// The integral over a line.
#[derive(Clone, Debug)]
pub(super) struct Integral {
    pub(super) sum: Sum,
    /// Of each light the nearest.
    pub(super) paces: Vec<Pace>,
}

impl Line {
    /// Where each piece but the last ends.
    pub(super) fn breaks(&self) -> impl Iterator<Item = f64> + Clone {
        self.pieces[..self.pieces.len() - 1]
            .iter()
            .map(|piece| piece.to)
    }

    pub(super) fn middles(&self) -> impl Iterator<Item = f64> {
        self.pieces
            .iter()
            .map(|piece| 0.5 * (piece.from + piece.to))
    }

    pub(super) fn has_pieces_of(&self, other: &Self) -> bool {
        let signatures = |line: &Self| {
            line.pieces
                .iter()
                .map(|piece| piece.signature)
                .collect::<Vec<_>>()
        };
        signatures(self) == signatures(other)
    }

    /// Whether there is a piece of this kind somewhere from one place to another.
    pub(super) fn has_at(&self, signature: Signature, [from, to]: [f64; 2]) -> bool {
        let is_there =
            |piece: &Piece| piece.signature == signature && piece.from < to && piece.to > from;
        self.pieces.iter().any(is_there)
    }

    /// Learns how pieces go on from a line that has the same ones.
    pub(super) fn drift_from(&mut self, other: &Self) {
        let over = 1.0 / (self.y - other.y);
        self.drift = Some(
            self.breaks()
                .zip(other.breaks())
                .map(|(a, b)| (a - b) * over)
                .collect(),
        );
    }

    /// Where pieces end on a line at `y`, if they go on as they do here.
    pub(super) fn continued(&self, y: f64) -> Option<Vec<f64>> {
        let drift = self.drift.as_ref()?;
        Some(
            self.breaks()
                .zip(drift)
                .map(|(at, drift)| at + drift * (y - self.y))
                .collect(),
        )
    }
}

/// The middles of what lies between breaks from 0 to 1 after `left`.
pub(super) fn middles_of(left: f64, breaks: &[f64]) -> Vec<f64> {
    let ends: Vec<f64> = [left]
        .into_iter()
        .chain(breaks.iter().copied())
        .chain([left + 1.0])
        .collect();
    ends.windows(2)
        .map(|pair| 0.5 * (pair[0] + pair[1]))
        .collect()
}

/// Finds pieces: points that are known to be of interest, and where pieces are expected to end.
pub(super) struct Hints<'a> {
    pub(super) seeds: &'a [f64],
    pub(super) breaks: &'a [f64],
}

impl Points<'_> {
    /// The line at `y` from `ends[0]` to `ends[1]`, as far as the hints tell.
    pub(super) fn line(&mut self, y: f64, ends: [f64; 2], hints: &Hints<'_>) -> Line {
        let inside = |x: &f64| *x > ends[0] + BREAK && *x < ends[1] - BREAK;
        let mut places: Vec<f64> = hints.seeds.iter().copied().filter(inside).collect();
        places.extend(ends);
        places.sort_by(f64::total_cmp);
        places.dedup_by(|a, b| *a - *b < BREAK);
        let points: Vec<Point> = places.iter().map(|&x| self.at(x, y)).collect();
        let mut pieces = vec![Piece {
            from: ends[0],
            to: ends[1],
            signature: points[0].signature,
        }];
        for pair in points.windows(2) {
            self.part(y, &pair[0], &pair[1], hints.breaks, &mut pieces);
        }
        Line {
            y,
            pieces,
            drift: None,
        }
    }

    /// Finds where pieces end between two points.
    fn part(&mut self, y: f64, from: &Point, to: &Point, guesses: &[f64], pieces: &mut Vec<Piece>) {
        if from.signature == to.signature {
            return;
        }
        let (mut low, mut high) = (from.clone(), to.clone());
        let guess = guesses.iter().copied().find(|&x| x > low.x && x < high.x);
        let mut step = BREAK;
        let mut sides = guess.map(|guess| (guess, 0));
        while high.x - low.x > 1.5 * BREAK {
            let x = match sides {
                Some((guess, taken)) => {
                    // Around the guess, farther and farther away.
                    let side = if taken % 2 == 0 { -step } else { step };
                    if taken % 2 == 1 {
                        step *= 16.0;
                    }
                    let is_enough = low.x > guess - step && high.x < guess + step && taken > 1;
                    let is_far = step > 0.25 * (high.x - low.x);
                    sides = (!(is_enough || is_far)).then_some((guess, taken + 1));
                    guess + side
                }
                None => 0.5 * (low.x + high.x),
            };
            if !(x > low.x && x < high.x) {
                if sides.is_none() && 0.5 * (low.x + high.x) == x {
                    break;
                }
                continue;
            }
            let middle = self.at(x, y);
            if middle.signature == low.signature {
                low = middle;
            } else if middle.signature == high.signature {
                high = middle;
            } else {
                self.part(y, &low, &middle, guesses, pieces);
                self.part(y, &middle, &high, guesses, pieces);
                return;
            }
        }
        let at = 0.5 * (low.x + high.x);
        let last = pieces.last_mut().expect("a line has a piece");
        let end = last.to;
        last.to = at;
        pieces.push(Piece {
            from: at,
            to: end,
            signature: high.signature,
        });
    }

    /// The integral over a line. Where a point is not what its piece is, the line is parted anew; `false` if it then
    /// has other pieces.
    pub(super) fn integral(
        &mut self,
        line: &mut Line,
        ends: [f64; 2],
        allowed: [f64; 4],
    ) -> (Integral, bool) {
        let mut is_as_before = true;
        let mut surprises = Vec::new();
        loop {
            match self.all_pieces(line, allowed, surprises.len() < SURPRISES) {
                Ok(integral) => return (integral, is_as_before),
                Err(x) => {
                    surprises.push(x);
                    let seeds: Vec<f64> = line.middles().chain(surprises.iter().copied()).collect();
                    let breaks: Vec<f64> = line.breaks().collect();
                    let hints = Hints {
                        seeds: &seeds,
                        breaks: &breaks,
                    };
                    let parted = self.line(line.y, ends, &hints);
                    is_as_before &= parted.has_pieces_of(line);
                    *line = parted;
                }
            }
        }
    }

    fn all_pieces(
        &mut self,
        line: &Line,
        allowed: [f64; 4],
        is_strict: bool,
    ) -> Result<Integral, f64> {
        let mut integral = Integral {
            sum: Sum::default(),
            paces: Vec::new(),
        };
        for piece in &line.pieces {
            let width = piece.to - piece.from;
            if width <= NARROW {
                let point = self.at(0.5 * (piece.from + piece.to), line.y);
                let spread = self.spread();
                integral.sum.add(width, &point.value, &spread);
                continue;
            }
            self.piece(line.y, piece, allowed, is_strict, DEPTH, &mut integral)?;
        }
        let spread = self.spread();
        let breaks = line.pieces.len() as f64;
        for (error, spread) in integral.sum.error.iter_mut().zip(spread) {
            *error += breaks * BREAK * spread;
        }
        Ok(integral)
    }

    /// Adds the integral over a piece: by two rules, and by halves where these do not agree.
    fn piece(
        &mut self,
        y: f64,
        piece: &Piece,
        allowed: [f64; 4],
        is_strict: bool,
        depth: u32,
        integral: &mut Integral,
    ) -> Result<(), f64> {
        let width = piece.to - piece.from;
        let mut sums = [[0.0; 4]; 2];
        let mut points = Vec::with_capacity(8);
        let mut is_one_piece = true;
        for (sum, rule) in sums.iter_mut().zip([THREE, FIVE]) {
            for [place, weight] in rule {
                // The middle is in both rules.
                let x = piece.from + width * place;
                let point = self.at(x, y);
                if point.signature != piece.signature {
                    if is_strict {
                        return Err(x);
                    }
                    is_one_piece = false;
                }
                for (sum, value) in sum.iter_mut().zip(point.value) {
                    *sum += weight * value;
                }
                points.push(point);
            }
        }
        points.sort_by(|a, b| a.x.total_cmp(&b.x));
        let hides = points
            .windows(2)
            .any(|pair| may_hide_a_peak(&pair[0].paces, &pair[1].paces));
        let [coarse, fine] = sums;
        let apart: [f64; 4] =
            std::array::from_fn(|channel| (coarse[channel] - fine[channel]).abs());
        // A narrow piece may be off by more.
        let share = (LEAST_SHARE / width).max(1.0);
        let is_near = apart
            .iter()
            .zip(allowed.iter().zip(self.noise))
            .all(|(apart, (allowed, noise))| *apart <= allowed * share + noise);
        if (is_near && !hides) || depth == 0 || !self.may_go_on() {
            let spread = self.spread();
            let error = if is_one_piece { apart } else { spread };
            integral.sum.add(width, &fine, &error);
            for point in &points {
                if integral.paces.is_empty() {
                    integral.paces.clone_from(&point.paces);
                }
                for (least, pace) in integral.paces.iter_mut().zip(&point.paces) {
                    *least = least.nearer(*pace);
                }
            }
            return Ok(());
        }
        let middle = 0.5 * (piece.from + piece.to);
        let halves = [
            Piece {
                to: middle,
                ..*piece
            },
            Piece {
                from: middle,
                ..*piece
            },
        ];
        for side in &halves {
            self.piece(y, side, allowed, is_strict, depth - 1, integral)?;
        }
        Ok(())
    }
}
