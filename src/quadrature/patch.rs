//! L over squares of many pixels, from its values at nine nodes: the corners, the middles of the sides, and the middle.
//!
//! Between the nodes L is interpolated by a polynomial P of degree 2 along each axis. On one axis, u from −1 to 1,
//! broken lines are at most M/8 off, where |f″| ≤ M, and P is M/8 at most off these, as |f(−1) − 2 f(0) + f(1)| ≤ M.
//! Along both, with the Lebesgue constant 5/4 of three nodes,
//!
//! |f − P| ≤ (M_u + 5/4 M_v)/4.
//!
//! So where all that arrives is proven to arrive, so is the error. It holds as well of what is anywhere between P and
//! the broken lines: of 0, where P is below it and no node is.
//!
//! In penumbrae the slope jumps where the border of a shadow begins to cross a light. Of one such line, broken lines are
//! off by at most the second differences of the nodes. Two of opposite signs that are between the same nodes may hide
//! from these: each of them changes the slope by no more than what arrives without shadows times the part of the
//! light that a border crosses over the whole square, and between two nodes, half of the square apart, broken lines are
//! off by at most a quarter of that. The estimate is the sum of all three.

use super::area::Slopes;
use super::radiance::{Arriving, LIKELY, Radiance, WIDE_BORDER};
use super::surface::Surface;
use super::view::{Square, View};
use super::{Primary, Quadrature, Told, Verdict};
use crate::image::Window;

/// What a square may be off by, as a part of what its pixels may: so little that beside others its sides are not seen.
const PART: f64 = 0.125;

/// Half the side of the least square that is interpolated where all is proven. Smaller ones take as long as samples do.
const LEAST: f64 = 2.0;

/// The same of such that are asked for: quarters of those that bend too much.
const LEAST_QUARTER: f64 = 4.0;

/// A quarter bends a fourth as much, or, as bounds of smaller squares are tighter, somewhat less.
const OF_QUARTER: f64 = 0.25;

/// What nodes say of a square.
#[expect(clippy::large_enum_variant, reason = "it is taken apart at once")]
pub(super) enum Fit {
    Told(Patch),
    /// They will of its quarters.
    OfQuarters,
    TooCoarse,
}

/// L over a square.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    square: Square,
    nodes: Nodes,
    alpha: f64,
    /// Of the mean over any pixel.
    error: [f64; 3],
    is_bound: bool,
}

/// R, G, B at the nodes, row by row.
#[derive(Clone, Copy, Debug)]
struct Nodes([[[f64; 3]; 3]; 3]);

impl Nodes {
    /// The least at any, for each primary.
    fn least(&self) -> [f64; 3] {
        let mut least = [f64::INFINITY; 3];
        for node in self.0.as_flattened() {
            for (least, value) in least.iter_mut().zip(node) {
                *least = least.min(*value);
            }
        }
        least
    }

    /// The largest second differences along rows and along columns.
    fn bends(&self, channel: usize) -> [f64; 2] {
        let at = |row: usize, column: usize| self.0[row][column][channel];
        let mut bends = [0.0_f64; 2];
        for line in 0..3 {
            let along = at(line, 0) - 2.0 * at(line, 1) + at(line, 2);
            let down = at(0, line) - 2.0 * at(1, line) + at(2, line);
            bends = [bends[0].max(along.abs()), bends[1].max(down.abs())];
        }
        bends
    }
}

/// The weights of three nodes at a place from −1 to 1.
fn weights(place: f64) -> [f64; 3] {
    [
        0.5 * place * (place - 1.0),
        (1.0 - place) * (1.0 + place),
        0.5 * place * (place + 1.0),
    ]
}

impl Patch {
    /// What is known of some pixels of the square, put in their places in a window.
    pub(super) fn tell(&self, pixels: Window, window: Window, verdicts: &mut [Verdict]) {
        let least = self.nodes.least().map(|least| least.min(0.0));
        let place = |pixel: u32, axis: usize| {
            weights((f64::from(pixel) + 0.5 - self.square.middle[axis]) / self.square.half)
        };
        let [r, g, b] = self.error;
        let error = [r, g, b, 0.0];
        for y in pixels.y..pixels.y + pixels.height {
            // The polynomials along this row, by their values at three nodes.
            let [upper, middle, lower] = place(y, 1);
            let [above, amid, below] = &self.nodes.0;
            let mut row = [[0.0; 3]; 3];
            for (node, values) in row.iter_mut().enumerate() {
                for (channel, value) in values.iter_mut().enumerate() {
                    *value = above[node][channel] * upper
                        + amid[node][channel] * middle
                        + below[node][channel] * lower;
                }
            }
            let start = (y - window.y) * window.width;
            for x in pixels.x..pixels.x + pixels.width {
                let [left, middle, right] = place(x, 0);
                let mut mean = [0.0, 0.0, 0.0, self.alpha];
                for channel in 0..3 {
                    let value =
                        row[0][channel] * left + row[1][channel] * middle + row[2][channel] * right;
                    mean[channel] = value.max(least[channel]);
                }
                verdicts[(start + x - window.x) as usize] = Verdict::Interpolated {
                    mean,
                    error,
                    is_bound: self.is_bound,
                };
            }
        }
    }
}

impl Quadrature<'_> {
    /// A square all of whose radiance is smooth.
    pub(super) fn smooth_patch(&self, square: Square, told: &Told, radiance: &Radiance) -> Fit {
        if square.half < LEAST {
            return Fit::TooCoarse;
        }
        let models = &radiance.models;
        let bound = [0, 1, 2].map(|channel: usize| self.bound(radiance, channel, square));
        let most = models.map(|model| model.most());
        let part = |part: f64| bound.map(|bound| bound * part);
        if !self.is_fine(most, part(OF_QUARTER)) {
            return Fit::TooCoarse;
        }
        let coarse = if square.half * 0.5 >= LEAST_QUARTER {
            Fit::OfQuarters
        } else {
            Fit::TooCoarse
        };
        if !self.is_fine(most, bound) {
            return coarse;
        }
        let is_constant =
            |axis: usize| models.iter().all(|model| model.derivatives(axis)[0] == 0.0);
        let nodes = if is_constant(0) && is_constant(1) {
            Nodes([[models.map(|model| model.center); 3]; 3])
        } else {
            match self.nodes(square, told, None) {
                Some(nodes) => nodes,
                None => return Fit::TooCoarse,
            }
        };
        let patch = Patch {
            square,
            nodes,
            alpha: f64::from(u8::from(told.primary != Primary::Background)),
            error: bound,
            is_bound: true,
        };
        if self.is_met_by(&patch) {
            Fit::Told(patch)
        } else {
            coarse
        }
    }

    /// A square across which no border of a shadow moves far.
    pub(super) fn penumbra_patch(
        &self,
        square: Square,
        told: &Told,
        surface: &Surface,
    ) -> Option<Patch> {
        let Primary::One(shape) = told.primary else {
            return None;
        };
        let mut proven = Radiance::constant(self.emission(shape));
        let mut free = [0.0; 3];
        let mut most = proven;
        for arriving in self.arriving(told.reaches, Some(WIDE_BORDER))? {
            let alone = Arriving::alone(arriving.light);
            if arriving.past.is_none() {
                let share = self.light_share(surface, shape, alone, Slopes::Left);
                proven = proven.plus(share);
                most = most.plus(share);
                continue;
            }
            let share = self.light_share(surface, shape, alone, Slopes::None);
            most = most.plus(share);
            let border = self.border_over(surface, &arriving);
            for (free, share) in free.iter_mut().zip(share) {
                *free += share.center.abs() * border;
            }
        }
        if !(proven.is_known() && most.is_known()) {
            return None;
        }
        let hidden = [0, 1, 2]
            .map(|channel: usize| self.bound(&proven, channel, square) + 0.125 * free[channel]);
        if !self.is_fine(most.models.map(|model| LIKELY * model.most()), hidden) {
            return None;
        }
        let nodes = self.nodes(square, told, Some(WIDE_BORDER))?;
        let error = [0, 1, 2]
            .map(|channel: usize| hidden[channel] + nodes.bends(channel).iter().sum::<f64>());
        let patch = Patch {
            square,
            nodes,
            alpha: 1.0,
            error,
            is_bound: false,
        };
        self.is_met_by(&patch).then_some(patch)
    }

    /// How far the mean over any pixel of a square is from what is interpolated in its middle.
    fn bound(&self, radiance: &Radiance, channel: usize, square: Square) -> f64 {
        let model = &radiance.models[channel];
        let [[_, across], [_, down]] = [0, 1].map(|axis: usize| model.derivatives(axis));
        0.25 * (across + 1.25 * down) + model.bend(0.5 / square.half)
    }

    /// Whether errors are as small as those of squares are to be.
    pub(super) fn is_fine(&self, least: [f64; 3], error: [f64; 3]) -> bool {
        let largest = PART * self.target.relative;
        let mut channels = least.iter().zip(error);
        channels.all(|(least, error)| error <= largest * least.max(self.target.floor))
    }

    fn is_met_by(&self, patch: &Patch) -> bool {
        // No pixel is darker than that.
        let least = patch.nodes.least();
        let least = [0, 1, 2].map(|channel: usize| least[channel] - patch.error[channel]);
        self.is_fine(least, patch.error)
    }

    /// L at the nodes of a square, where rays meet it there.
    fn nodes(&self, square: Square, told: &Told, border: Option<f64>) -> Option<Nodes> {
        let Primary::One(shape) = told.primary else {
            return None;
        };
        let solid = self.solid(shape);
        let mut nodes = Nodes([[[0.0; 3]; 3]; 3]);
        let [x, y] = square.middle;
        for (row, down) in nodes.0.iter_mut().zip([-1.0, 0.0, 1.0]) {
            for (node, across) in row.iter_mut().zip([-1.0, 0.0, 1.0]) {
                let place = Square {
                    middle: [x + across * square.half, y + down * square.half],
                    half: 0.0,
                };
                let surface = Surface::new(&View::new(self.camera, place), &solid)?;
                let radiance =
                    self.radiance(&surface, shape, told.reaches, border, Slopes::None)?;
                if !radiance.is_known() {
                    return None;
                }
                *node = radiance.models.map(|model| model.center);
            }
        }
        Some(nodes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: Square = Square {
        middle: [24.0, 40.0],
        half: 8.0,
    };

    const PIXELS: Window = Window {
        x: 16,
        y: 32,
        width: 16,
        height: 16,
    };

    fn means(patch: &Patch) -> Vec<[f64; 4]> {
        let mut verdicts = [Verdict::OPEN; 256];
        patch.tell(PIXELS, PIXELS, &mut verdicts);
        let mean = |verdict: &Verdict| match *verdict {
            Verdict::Interpolated { mean, .. } => mean,
            _ => panic!("it is interpolated"),
        };
        verdicts.iter().map(mean).collect()
    }

    fn patch(f: impl Fn(f64, f64) -> f64) -> Patch {
        let mut nodes = Nodes([[[0.0; 3]; 3]; 3]);
        for (row, v) in nodes.0.iter_mut().zip([-1.0, 0.0, 1.0]) {
            for (node, u) in row.iter_mut().zip([-1.0, 0.0, 1.0]) {
                *node = [f(u, v), 2.0, -f(u, v)];
            }
        }
        Patch {
            square: SQUARE,
            nodes,
            alpha: 1.0,
            error: [0.0; 3],
            is_bound: true,
        }
    }

    /// How far the middles of all pixels are off at most.
    fn off(f: impl Fn(f64, f64) -> f64 + Copy) -> f64 {
        let mut most = 0.0_f64;
        for ([x, y], mean) in PIXELS.pixels().zip(means(&patch(f))) {
            let [u, v] = [x - PIXELS.x, y - PIXELS.y].map(|place| (f64::from(place) - 7.5) / 8.0);
            assert!((mean[1] - 2.0).abs() < 1e-15 && mean[3] == 1.0);
            most = most.max((mean[0] - f(u, v)).abs());
        }
        most
    }

    #[test]
    fn what_is_quadratic_is_exact() {
        let found = off(|u, v| 9.0 + (1.0 + u - 3.0 * u * u) * (0.3 - v + 2.0 * v * v));
        assert!(found < 4e-15, "{found:e}");
    }

    /// Waves, whose second derivatives are known, and whatever is between them and broken lines: no more than is said, and
    /// not of another order.
    #[test]
    fn the_bound_holds() {
        let mut most = 0.0_f64;
        for number in 1..200 {
            let [a, b, c, d] =
                [0.7, 1.9, 0.31, 0.57].map(|step| 0.1 + f64::from(number) * step % 3.0);
            let wave = |u: f64, v: f64| libm::sin(a * u + c) * libm::cos(b * v + d);
            let bound = 0.25 * (a * a + 1.25 * b * b);
            let found = off(|u, v| 1.0 + wave(u, v));
            assert!(found <= bound, "{number}: {found} {bound}");
            most = most.max(found / bound);
            // What is not below 0 at the nodes is not below 0.
            let bent = means(&patch(|u, v| wave(u, v).max(0.0)));
            assert!(bent.iter().all(|mean| mean[0] >= 0.0), "{number}");
        }
        assert!(most > 0.1, "{most}");
    }
}
