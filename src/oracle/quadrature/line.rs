//! The integrals along one line.

use super::super::vector::{Vector, cross, length};
use super::kronrod::nodes;
use super::shadow::Hidden;
use super::structure::{Structure, join, structure};
use super::view::{Line, View, cosine};
use super::{Integrator, Kernel, NARROWEST, Sum, Triple, graded, lobe_width, sorted};

/// How far the integral along one line may be off, relative to itself.
const LINE_TOLERANCE: f64 = 1e-10;

/// A piece of a line is halved so often at most.
const DEPTH: u32 = 16;

/// More than any surface has curves.
const CURVES: usize = 8;

/// What is before a piece of a line.
enum Cover {
    /// Something through which nothing comes.
    Whole,
    /// These panes, or none.
    Panes(Vec<usize>),
}

impl Integrator<'_> {
    /// Finds what is hidden of a line; what is not farther apart than `room` is joined.
    pub(super) fn find_hidden(&mut self, line: &Line, room: f64) -> Structure {
        self.asked += 1;
        self.found.clear();
        self.covered.clear();
        let numbers = (0_u32..).step_by(CURVES);
        let occluders = self.occluders.iter().zip(&mut self.hides).zip(numbers);
        for (index, ((occluder, hides), number)) in occluders.enumerate() {
            if occluder.is_in_row(line.row) {
                self.asked += 1;
                let before = self.found.len();
                occluder.intervals(self.view, line, number, &mut self.found);
                *hides |= self.found.len() > before;
                if occluder.is_pane() {
                    let pieces = self.found.drain(before..);
                    let pieces = pieces.filter(|piece| piece.ends[1] - piece.ends[0] > room);
                    self.covered.extend(pieces.map(|piece| (piece, index)));
                }
            }
        }
        join(&mut self.found, room);
        let covered = self.covered.iter().map(|(piece, _)| *piece);
        structure(line, &self.found, covered)
    }

    /// The panes before a piece of a line, which begin and end where pieces do.
    fn panes_before(&self, [from, to]: [f64; 2]) -> Vec<usize> {
        let middle = 0.5 * (from + to);
        let is_before = |piece: &Hidden| piece.ends[0] <= middle && middle <= piece.ends[1];
        let covered = self.covered.iter();
        covered
            .filter_map(|(piece, index)| is_before(piece).then_some(*index))
            .collect()
    }

    pub(super) fn structure_at(&mut self, parameter: f64, room: f64) -> Structure {
        let line = self.line_at(parameter);
        if line.ends[0] >= line.ends[1] {
            return 0;
        }
        self.find_hidden(&line, room)
    }

    /// One line.
    pub(super) fn line(&mut self, line: &Line) -> (Sum, Structure) {
        let mut total = Sum::default();
        let [first, last] = line.ends;
        if first >= last {
            self.asked += 1;
            return (total, 0);
        }
        let structure = self.find_hidden(line, NARROWEST);

        let mut places = Vec::with_capacity(8);
        places.push(line.zero_of(self.kernel.normal, 0.0));
        let range = [first, last];
        let mut around = |s: f64, width: f64| {
            let direction = line.at(s);
            let step = width * length(direction) / angular(direction, line.along);
            graded(s, step, range, &mut places);
        };
        around(line.nearest(), 1.0);
        if let Some((way, exponent)) = self.kernel.lobe {
            let peak = line.most_along(way);
            around(peak, lobe_width(way, exponent, line.at(peak)));
            places.push(line.zero_of(way, 0.0));
        }
        // Pieces that are hidden and that are not, in turns.
        let mut from = first;
        let mut pieces = Vec::with_capacity(2 * self.found.len() + 1);
        for &Hidden {
            ends: [start, end], ..
        } in &self.found
        {
            if start > from {
                pieces.push(([from, start], true));
                from = start;
            }
            if end > from {
                pieces.push(([from, end], false));
                from = end;
            }
        }
        if last > from {
            pieces.push(([from, last], true));
        }
        for (piece, _) in &self.covered {
            places.extend(piece.ends);
        }
        let mut smooth = Vec::with_capacity(pieces.len() + places.len());
        for (ends, is_seen) in pieces {
            let inside = places.iter().copied();
            let inside = inside.filter(|&s| s > ends[0] && s < ends[1]);
            let cuts = sorted(inside.chain(ends).collect(), ends);
            for pair in cuts.windows(2) {
                let ends = [pair[0], pair[1]];
                let cover = if is_seen {
                    Cover::Panes(self.panes_before(ends))
                } else {
                    Cover::Whole
                };
                let piece = self.piece(line, ends, &cover);
                let expected = self.weighted(&piece.whole.map(f64::abs));
                smooth.push((ends, cover, piece, expected));
            }
        }
        let allowed: f64 = LINE_TOLERANCE * smooth.iter().map(|piece| piece.3).sum::<f64>();
        for (ends, cover, piece, _) in smooth {
            self.refined(line, ends, &cover, piece, allowed, DEPTH, &mut total);
        }
        (total, structure)
    }

    /// Adds a piece, by halves where these are not what the whole is.
    #[expect(
        clippy::too_many_arguments,
        reason = "what a piece is, and where it goes"
    )]
    fn refined(
        &self,
        line: &Line,
        ends: [f64; 2],
        cover: &Cover,
        piece: Sum,
        allowed: f64,
        depth: u32,
        total: &mut Sum,
    ) {
        if depth == 0 || self.weighted(&piece.error) <= allowed {
            total.add(&piece, 1.0);
            return;
        }
        let middle = 0.5 * (ends[0] + ends[1]);
        for semi in [[ends[0], middle], [middle, ends[1]]] {
            let of_half = self.piece(line, semi, cover);
            self.refined(line, semi, cover, of_half, allowed, depth - 1, total);
        }
    }

    /// A smooth piece of a line, by one rule, and how far the coarser one is from that.
    fn piece(&self, line: &Line, ends: [f64; 2], cover: &Cover) -> Sum {
        let (mut fine, mut coarse) = ([[0.0; 3]; 2], [[0.0; 3]; 2]);
        for [s, of_fine, of_coarse] in nodes(ends) {
            let direction = line.at(s);
            let through = match cover {
                Cover::Whole => 0.0,
                Cover::Panes(panes) => panes
                    .iter()
                    .map(|&pane| self.occluders[pane].transmittance(self.view, direction))
                    .product(),
            };
            let values = self.kernel.at(self.view, direction);
            for (i, value) in values.into_iter().enumerate() {
                for (of, value) in [value, value * through].into_iter().enumerate() {
                    fine[of][i] += of_fine * value;
                    coarse[of][i] += of_coarse * value;
                }
            }
        }
        let off = |of: usize, i: usize| (fine[of][i] - coarse[of][i]).abs();
        Sum {
            whole: fine[0],
            seen: fine[1],
            error: std::array::from_fn(|i| off(0, i).max(off(1, i))),
        }
    }
}

impl Kernel {
    fn at(&self, view: &View, direction: Vector) -> Triple {
        let density = view.density(direction);
        let cos = cosine(self.normal, direction).max(0.0);
        let lobe = self.lobe.map_or(0.0, |(way, exponent)| {
            let cos_lobe = cosine(way, direction);
            let power = if cos_lobe <= 0.0 {
                0.0
            } else if cos_lobe < 0.5 {
                cos_lobe.powf(exponent)
            } else {
                // Close to 1 its last digits are what a large n is about.
                let sine = length(cross(way, direction)) / length(direction);
                (0.5 * exponent * (-sine * sine).ln_1p()).exp()
            };
            power * if self.lobe_has_cosine { cos } else { 1.0 }
        });
        [density, density * cos, density * lobe]
    }
}

/// ‖ω × way‖ for the unit vector ω of a direction: how fast a direction turns on that way, times its length.
pub(super) fn angular(direction: Vector, way: Vector) -> f64 {
    length(cross(direction, way)) / length(direction)
}
