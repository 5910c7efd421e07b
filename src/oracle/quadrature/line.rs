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

impl Integrator<'_> {
    /// Finds what is hidden of a line; what is not farther apart than `room` is joined.
    pub(super) fn find_hidden(&mut self, line: &Line, room: f64) -> Structure {
        self.asked += 1;
        self.found.clear();
        let numbers = (0_u32..).step_by(CURVES);
        for ((occluder, hides), number) in self.occluders.iter().zip(&mut self.hides).zip(numbers) {
            if occluder.is_in_row(line.row) {
                self.asked += 1;
                let before = self.found.len();
                occluder.intervals(self.view, line, number, &mut self.found);
                *hides |= self.found.len() > before;
            }
        }
        join(&mut self.found, room);
        structure(line, &self.found)
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
        let mut smooth = Vec::with_capacity(pieces.len() + places.len());
        for (ends, is_seen) in pieces {
            let inside = places.iter().copied();
            let inside = inside.filter(|&s| s > ends[0] && s < ends[1]);
            let cuts = sorted(inside.chain(ends).collect(), ends);
            for pair in cuts.windows(2) {
                let ends = [pair[0], pair[1]];
                let (value, error) = self.piece(line, ends);
                let expected = self.weighted(&value.map(f64::abs));
                smooth.push((ends, is_seen, value, error, expected));
            }
        }
        let allowed: f64 = LINE_TOLERANCE * smooth.iter().map(|piece| piece.4).sum::<f64>();
        for (ends, is_seen, value, error, _) in smooth {
            self.refined(
                line,
                ends,
                is_seen,
                (value, error),
                allowed,
                DEPTH,
                &mut total,
            );
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
        is_seen: bool,
        (value, error): (Triple, Triple),
        allowed: f64,
        depth: u32,
        total: &mut Sum,
    ) {
        if depth == 0 || self.weighted(&error) <= allowed {
            let seen = if is_seen { value } else { [0.0; 3] };
            let part = Sum {
                whole: value,
                seen,
                error,
            };
            total.add(&part, 1.0);
            return;
        }
        let middle = 0.5 * (ends[0] + ends[1]);
        for semi in [[ends[0], middle], [middle, ends[1]]] {
            let of_half = self.piece(line, semi);
            self.refined(line, semi, is_seen, of_half, allowed, depth - 1, total);
        }
    }

    /// A smooth piece of a line, by one rule, and how far the coarser one is from that.
    fn piece(&self, line: &Line, ends: [f64; 2]) -> (Triple, Triple) {
        let (mut fine, mut coarse) = ([0.0; 3], [0.0; 3]);
        for [s, of_fine, of_coarse] in nodes(ends) {
            let values = self.kernel.at(self.view, line.at(s));
            for (i, value) in values.into_iter().enumerate() {
                fine[i] += of_fine * value;
                coarse[i] += of_coarse * value;
            }
        }
        (fine, std::array::from_fn(|i| (fine[i] - coarse[i]).abs()))
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
