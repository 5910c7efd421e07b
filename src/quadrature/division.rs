//! The mean over one pixel from parts of it: the part that is least exact is divided into its quarters, until the
//! pixel is as exact as it is to be.
//!
//! Of a part that is smooth or has one edge the mean is told as it is of whole pixels; of another, only between what its
//! radiance is. So where edges cross or end, and where a sliver is seen, what is not told becomes a fourth as large with
//! each division, where samples become half as wrong with two or three times as many.
//!
//! In penumbrae the means of parts are estimates from some points. What these do not show, the ends of shadows' borders, is
//! off to both sides, or along a line, which passes through √N of N parts: it adds up as squares do. How the radiance bends adds up
//! as it is. That is seen when a part is divided: where its mean changes by D, that of its quarters is D/3 off, as a
//! fourth of what theirs together was.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::radiance::{Content, WIDE_BORDER};
use super::surface::Surface;
use super::view::{Square, View};
use super::{BLOCK, Mean, Quadrature, REGION, Told, aligned};

/// Half the side of the least part: smaller ones matter to no error that can be asked for.
const LEAST: f64 = 1.0 / 65536.0;

/// Where edges cross, what is not told becomes less as parts become more, in proportion; along a curve only as the root of them
/// does. So of this part of them it is asked whether all of them may do.
const TRIED: usize = 8;

/// What adds up as squares do, and how the radiance bends, are taken to be larger by this.
const MARGIN: f64 = 2.0;

/// A part of a pixel.
#[derive(Clone, Copy, Debug)]
struct Part {
    square: Square,
    /// What is not known at all is infinitely far off.
    mean: Mean,
    /// Whether nothing jumps in it.
    is_smooth: bool,
    /// How far the mean is off by how the radiance bends, to which side: known of quarters of what was smooth.
    bend: Option<[f64; 3]>,
}

impl Part {
    /// In pixels.
    fn area(&self) -> f64 {
        4.0 * self.square.half * self.square.half
    }

    /// How much this part adds to the error of a pixel of a radiance, as bits that have the order of the numbers.
    fn urgency(&self, radiance: f64) -> u64 {
        let [r, g, b, alpha] = self.mean.error;
        (self.area() * (r.max(g).max(b) / radiance + alpha)).to_bits()
    }

    /// Tells the quarters of this part how they bend.
    fn bend_quarters(&self, quarters: &mut [Self; 4]) {
        if !(self.is_smooth && quarters.iter().all(|part| part.is_smooth)) {
            return;
        }
        let bend = [0, 1, 2].map(|channel: usize| {
            let sum: f64 = quarters.iter().map(|part| part.mean.value[channel]).sum();
            (0.25 * sum - self.mean.value[channel]) / 3.0
        });
        for part in quarters {
            part.bend = Some(bend);
        }
    }
}

/// The mean over a pixel.
fn mean_of(parts: &[Part]) -> Mean {
    let mut all = Mean {
        value: [0.0; 4],
        error: [0.0; 4],
        is_bound: true,
    };
    let (mut bends, mut sums, mut squares) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    for part in parts {
        let area = part.area();
        let Mean {
            value,
            error,
            is_bound,
        } = part.mean;
        for (all, value) in all.value.iter_mut().zip(value) {
            *all += area * value;
        }
        all.error[3] += area * error[3];
        all.is_bound &= is_bound;
        for channel in 0..3 {
            let error = area * error[channel];
            match part.bend {
                Some(bend) if !is_bound => {
                    bends[channel] += area * bend[channel];
                    sums[channel] += error;
                    squares[channel] += error * error;
                }
                _ => all.error[channel] += error,
            }
        }
    }
    for channel in 0..3 {
        let estimate = MARGIN * (bends[channel].abs() + squares[channel].sqrt());
        all.error[channel] += estimate.min(sums[channel]);
    }
    all
}

impl Quadrature<'_> {
    /// The mean over a pixel, from at most so many parts or few more, or fewer where it cannot be told that it is exact
    /// enough with all of them; `None` where nothing is known.
    pub(crate) fn divide(&mut self, pixel: [u32; 2], most_parts: usize) -> Option<Mean> {
        let told = self.told_of_pixel(pixel);
        let all = self.part(aligned(pixel, 1), told)?;
        let [r, g, b, _] = all.mean.value;
        let radiance = r.max(g).max(b).max(self.target.floor);
        let radiance = radiance.max(f64::MIN_POSITIVE);
        let mut parts = vec![all];
        let mut next = BinaryHeap::from([(all.urgency(radiance), Reverse(0))]);
        let mut mean = all.mean;
        // To add all up takes its time too.
        let mut add_up_at = most_parts / TRIED;
        while let Some((_, Reverse(number))) = next.pop() {
            let whole = parts[number];
            let [a, b, c, d] = whole.square.quarters();
            let mut quarters = [
                self.part(a, told)?,
                self.part(b, told)?,
                self.part(c, told)?,
                self.part(d, told)?,
            ];
            whole.bend_quarters(&mut quarters);
            let numbers = [number, parts.len(), parts.len() + 1, parts.len() + 2];
            for (number, part) in numbers.into_iter().zip(&quarters) {
                let urgency = part.urgency(radiance);
                if urgency > 0 && part.square.half > LEAST {
                    next.push((urgency, Reverse(number)));
                }
            }
            parts[number] = quarters[0];
            parts.extend_from_slice(&quarters[1..]);
            if parts.len() >= add_up_at || next.is_empty() {
                mean = mean_of(&parts);
                add_up_at = parts.len() + parts.len() / 8;
                let left = most_parts as f64 / parts.len() as f64;
                let off = self.target.largest(&mean.value, &mean.error);
                let is_hopeless = off > left.max(1.0) * self.target.relative;
                if self.target.is_met(mean.value, mean.error) || is_hopeless || left <= 1.0 {
                    break;
                }
            }
        }
        let is_known = mean.error.iter().all(|error| error.is_finite());
        is_known.then_some(mean)
    }

    /// What is told of a pixel on the way down to it.
    fn told_of_pixel(&mut self, pixel: [u32; 2]) -> Told {
        self.lists.clear();
        self.reaches.clear();
        self.enter(pixel.map(|place| place / REGION));
        let mut told = Told {
            primary: self.region.primary,
            reaches: 0,
            is_asked: false,
        };
        let mut side = BLOCK;
        while side >= 1 {
            let square = aligned(pixel.map(|place| place / side), side);
            let view = View::new(self.camera, square);
            (told, _) = self.refine(square, &view, told);
            side /= 2;
        }
        told
    }

    /// A part of a pixel of which something is told; `None` of mirrors and glass.
    fn part(&mut self, square: Square, known: Told) -> Option<Part> {
        let (lists, reaches) = (self.lists.len(), self.reaches.len());
        let view = View::new(self.camera, square);
        let (told, surface) = self.refine(square, &view, known);
        let smooth = self.smooth_radiance(&told, surface.as_ref(), Some(WIDE_BORDER));
        let mean = match &smooth {
            _ if self.shows_delta(told.primary) => None,
            Some(radiance) => Some(Mean::of(radiance, &told)),
            None => Some(self.edge_or_middle(square, &view, &told, surface.as_ref())),
        };
        self.lists.truncate(lists);
        self.reaches.truncate(reaches);
        Some(Part {
            square,
            mean: mean?,
            is_smooth: smooth.is_some(),
            bend: None,
        })
    }

    /// The mean over a square with one edge, or what is in the middle between the least and the most that is anywhere in it.
    fn edge_or_middle(
        &mut self,
        square: Square,
        view: &View,
        told: &Told,
        surface: Option<&Surface>,
    ) -> Mean {
        if let Some(mean) = self.across_edge(square, view, told, surface) {
            return mean;
        }
        let range = self.range(square, view, told, surface, Content::All);
        let (value, error) = match range {
            Some(range) => {
                let ends =
                    std::array::from_fn(|channel| [range.least[channel], range.most[channel]]);
                let of = |of: fn([f64; 2]) -> f64| ends.map(of);
                (
                    of(|[least, most]| 0.5 * (least + most)),
                    of(|[least, most]| 0.5 * (most - least)),
                )
            }
            None => ([0.0; 4], [f64::INFINITY; 4]),
        };
        Mean {
            value,
            error,
            is_bound: true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The error of so many estimates along each side of a pixel.
    fn error_of(side: u32, error: f64, bend: f64) -> f64 {
        let squares = (0..side).flat_map(|y| (0..side).map(move |x| [x, y]));
        let parts: Vec<Part> = squares
            .map(|place| {
                let half = 0.5 / f64::from(side);
                Part {
                    square: Square {
                        middle: place.map(|place| f64::from(2 * place + 1) * half),
                        half,
                    },
                    mean: Mean {
                        value: [5.0; 4],
                        error: [error, error, error, 0.0],
                        is_bound: false,
                    },
                    is_smooth: true,
                    bend: Some([bend; 3]),
                }
            })
            .collect();
        let mean = mean_of(&parts);
        assert!((mean.value[0] - 5.0).abs() < 1e-12 && !mean.is_bound);
        mean.error[0]
    }

    /// What borders of shadows add to parts of a penumbra is off to both sides; how the radiance bends adds up.
    #[test]
    fn estimates_add_up_as_squares_and_bends_as_they_are() {
        for (found, expected) in [
            (error_of(2, 1.0, 0.0), 1.0),
            (error_of(8, 1.0, 0.0), 0.25),
            (error_of(16, 0.5, 0.0), 0.0625),
            (error_of(16, 0.5, -0.01), 0.0825),
        ] {
            assert!((found - expected).abs() < 1e-12, "{found} {expected}");
        }
    }
}
