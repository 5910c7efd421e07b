//! Errors of numbers.

use rayon::prelude::*;
use serde::Serialize;

use super::{PIECE, room};
use crate::memory::OutOfMemory;

/// ε of relMSE is this part of the reference's median, squared.
const RELMSE_EPSILON: f64 = 1e-2;

/// Errors of what is darker than this part of the reference's median are relative to that.
const FLOOR: f64 = 1e-3;

/// A layer of a reference and of an image.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'p> {
    /// Pixels in a row. Range: at least 1.
    pub width: usize,
    /// R: the channels of the reference, each row by row.
    pub reference: &'p [&'p [f32]],
    /// I: the same channels of the image.
    pub image: &'p [&'p [f32]],
    /// So many channels, the first ones, count for what is relative: all but alpha.
    pub relative: usize,
}

/// A value of a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Place {
    /// Column, from the left of the pair.
    pub x: i64,
    /// Row, from its top.
    pub y: i64,
    /// The channel's place in the layer.
    #[serde(skip)]
    pub channel: usize,
}

/// How far a layer of an image is from that of a reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Metrics {
    /// max |I − R|; infinite where just one of them is NaN or infinite, or they are so in different ways.
    pub max_error: f64,
    /// The first value with the largest error; `None` where there is no error.
    pub max_at: Option<Place>,
    /// mean |I − R| over all values, those that are finite in both added up.
    pub mean_error: f64,
    /// √mean (I − R)², likewise.
    pub rmse: f64,
    /// 20 log₁₀(peak / RMSE) in dB, with the largest value of both images as the peak, or 1 if that is more;
    /// infinite where there is no error.
    pub psnr: f64,
    /// The median of |R|, without values that are 0, alpha, or not finite; 0 where there are no others.
    pub median: f64,
    /// mean (I − R)² / (R² + ε), ε = 10⁻² median². Without alpha.
    pub relmse: f64,
    /// Of the pixels' relative errors: a pixel's is the largest |I − R| / max(|R|, 10⁻³ median) of its
    /// channels without alpha. 99.9 % of the pixels have no larger one.
    pub relative_p999: f64,
    /// The largest of them.
    pub relative_max: f64,
    /// The first pixel that has it; `None` where there is no error.
    pub relative_max_at: Option<Place>,
    /// Pixels whose relative error is above the tolerance.
    pub flips: u64,
    /// Of how many pixels.
    pub pixels: u64,
    /// Values of the reference that are NaN or infinite.
    pub not_finite_in_reference: u64,
    /// Values of the image that are so.
    pub not_finite_in_image: u64,
}

/// What a piece of a channel adds.
#[derive(Clone, Copy)]
struct Sums {
    absolute: f64,
    square: f64,
    relative_square: f64,
    peak: f32,
    worst: f64,
    worst_at: usize,
    not_finite: [u64; 2],
}

impl Metrics {
    /// Compares a layer; `tolerance` is the relative error from which on a pixel is a flip.
    ///
    /// # Errors
    /// If there is not so much memory.
    ///
    /// # Panics
    /// If the planes are not of one length, or there are not as many of both.
    pub fn new(pair: &Pair<'_>, tolerance: f64) -> Result<Self, OutOfMemory> {
        pair.check();
        let median = pair.median()?;
        let epsilon = RELMSE_EPSILON * median * median;
        let count = pair.reference.first().map_or(0, |plane| plane.len());
        let channels = pair.reference.iter().zip(pair.image).enumerate();
        let mut all = Sums::nothing();
        let (mut relative_square, mut worst_channel) = (0.0, 0);
        for (channel, (reference, image)) in channels {
            let pieces = reference.par_chunks(PIECE).zip(image.par_chunks(PIECE));
            let pieces: Vec<Sums> = pieces.map(|(r, i)| Sums::of(r, i, epsilon)).collect();
            for (number, piece) in pieces.iter().enumerate() {
                if piece.worst > all.worst {
                    worst_channel = channel;
                }
                all.add(piece, number * PIECE);
                if channel < pair.relative {
                    relative_square += piece.relative_square;
                }
            }
        }
        let values = (count * pair.reference.len()) as f64;
        let rmse = (all.square / values).sqrt();
        let mut relative = relative_errors(pair)?;
        let worst = largest(&relative);
        let relative_max_at = worst.map(|index| pair.place(index, 0));
        let relative_max = worst.map_or(0.0, |index| f64::from(relative[index]));
        let flips = relative
            .par_iter()
            .filter(|&&error| f64::from(error) > tolerance);
        Ok(Self {
            max_error: all.worst,
            max_at: (all.worst > 0.0).then(|| pair.place(all.worst_at, worst_channel)),
            mean_error: all.absolute / values,
            rmse,
            psnr: 20.0 * (f64::from(all.peak) / rmse).log10(),
            median,
            relmse: relative_square / (count * pair.relative).max(1) as f64,
            flips: flips.count() as u64,
            relative_max,
            relative_max_at,
            relative_p999: percentile(&mut relative, 0.999),
            pixels: count as u64,
            not_finite_in_reference: all.not_finite[0],
            not_finite_in_image: all.not_finite[1],
        })
    }
}

/// Each pixel's largest |I − R| / max(|R|, 10⁻³ median) of its channels without alpha; infinite where there is
/// no such number.
///
/// # Errors
/// If there is not so much memory.
///
/// # Panics
/// As [`Metrics::new`].
pub fn relative_errors(pair: &Pair<'_>) -> Result<Vec<f32>, OutOfMemory> {
    pair.check();
    let floor = FLOOR * pair.median()?;
    let mut errors = room(
        pair.reference.first().map_or(0, |plane| plane.len()),
        0.0_f32,
    )?;
    errors
        .par_iter_mut()
        .enumerate()
        .for_each(|(index, error)| {
            for (reference, image) in pair.reference.iter().zip(pair.image).take(pair.relative) {
                let (r, i) = (reference[index], image[index]);
                let relative = match difference(r, i) {
                    0.0 => 0.0,
                    // Of a reference that is black.
                    difference => difference / f64::from(r.abs()).max(floor),
                };
                // Of two infinities there is no ratio; there is a difference all the same.
                let relative = if relative.is_nan() {
                    f32::INFINITY
                } else {
                    relative as f32
                };
                *error = error.max(relative);
            }
        });
    Ok(errors)
}

/// |I − R|; 0 where both are NaN or the same infinity, infinite where only one is finite.
fn difference(r: f32, i: f32) -> f64 {
    if r == i || (r.is_nan() && i.is_nan()) {
        return 0.0;
    }
    let difference = (f64::from(i) - f64::from(r)).abs();
    if difference.is_nan() {
        f64::INFINITY
    } else {
        difference
    }
}

impl Pair<'_> {
    fn check(&self) {
        assert_eq!(self.reference.len(), self.image.len(), "as many channels");
        let mut planes = self.reference.iter().chain(self.image);
        let count = self.reference.first().map_or(0, |plane| plane.len());
        assert!(
            planes.all(|plane| plane.len() == count),
            "planes of one size"
        );
    }

    fn place(&self, index: usize, channel: usize) -> Place {
        Place {
            x: (index % self.width) as i64,
            y: (index / self.width) as i64,
            channel,
        }
    }

    /// The median of |R| without 0, alpha, and what is not finite.
    fn median(&self) -> Result<f64, OutOfMemory> {
        let planes = &self.reference[..self.relative.min(self.reference.len())];
        let mut values = room(planes.iter().map(|plane| plane.len()).sum(), 0.0_f32)?;
        values.clear();
        let all = planes
            .iter()
            .flat_map(|plane| plane.iter().map(|r| r.abs()));
        values.extend(all.filter(|r| r.is_finite() && *r > 0.0));
        let middle = values.len() / 2;
        if values.is_empty() {
            return Ok(0.0);
        }
        Ok(f64::from(
            *values.select_nth_unstable_by(middle, f32::total_cmp).1,
        ))
    }
}

impl Sums {
    const fn nothing() -> Self {
        Self {
            absolute: 0.0,
            square: 0.0,
            relative_square: 0.0,
            // As idiff has it: of pictures whose white is 1 and that are darker.
            peak: 1.0,
            worst: 0.0,
            worst_at: 0,
            not_finite: [0; 2],
        }
    }

    fn of(reference: &[f32], image: &[f32], epsilon: f64) -> Self {
        let mut sums = Self::nothing();
        for (index, (&r, &i)) in reference.iter().zip(image).enumerate() {
            let error = difference(r, i);
            if error > sums.worst {
                (sums.worst, sums.worst_at) = (error, index);
            }
            if r.is_finite() && i.is_finite() {
                sums.absolute += error;
                sums.square += error * error;
                if error > 0.0 {
                    sums.relative_square += error * error / (f64::from(r).powi(2) + epsilon);
                }
                sums.peak = sums.peak.max(r).max(i);
            } else {
                sums.not_finite[0] += u64::from(!r.is_finite());
                sums.not_finite[1] += u64::from(!i.is_finite());
            }
        }
        sums
    }

    /// Adds a piece that starts at a place of its channel.
    fn add(&mut self, piece: &Self, start: usize) {
        self.absolute += piece.absolute;
        self.square += piece.square;
        self.peak = self.peak.max(piece.peak);
        if piece.worst > self.worst {
            (self.worst, self.worst_at) = (piece.worst, start + piece.worst_at);
        }
        for (sum, more) in self.not_finite.iter_mut().zip(piece.not_finite) {
            *sum += more;
        }
    }
}

/// The first of the largest, if it is above 0.
fn largest(errors: &[f32]) -> Option<usize> {
    let most = errors.par_iter().copied().reduce(|| 0.0, f32::max);
    (most > 0.0).then(|| errors.iter().position(|&error| error == most))?
}

/// The smallest error that this part of all is not above.
fn percentile(errors: &mut [f32], part: f64) -> f64 {
    let rank = (part * errors.len() as f64).ceil() as usize;
    if errors.is_empty() {
        return 0.0;
    }
    let rank = rank.clamp(1, errors.len()) - 1;
    f64::from(*errors.select_nth_unstable_by(rank, f32::total_cmp).1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn metrics(reference: &[&[f32]], image: &[&[f32]], relative: usize) -> Metrics {
        let pair = Pair {
            width: 2,
            reference,
            image,
            relative,
        };
        Metrics::new(&pair, 0.01).unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn closed_forms() {
        // Errors 0.5, 0, 1, 0 of the first channel; of alpha 0.25 once.
        let found = metrics(
            &[&[1.0, 2.0, 4.0, 0.0], &[1.0; 4]],
            &[&[1.5, 2.0, 3.0, 0.0], &[1.0, 0.75, 1.0, 1.0]],
            1,
        );
        assert_eq!(found.max_error, 1.0);
        let at = Place {
            x: 0,
            y: 1,
            channel: 0,
        };
        assert_eq!(found.max_at, Some(at));
        assert_eq!(found.mean_error, 1.75 / 8.0);
        let rmse = ((0.25 + 1.0 + 0.0625) / 8.0_f64).sqrt();
        assert_eq!(found.rmse, rmse);
        assert_eq!(found.psnr, 20.0 * (4.0 / rmse).log10());
        // Of 1, 2, 4: without what is 0.
        assert_eq!(found.median, 2.0);
        let relmse = (0.25 / 1.04 + 1.0 / 16.04) / 4.0;
        assert!((found.relmse - relmse).abs() < 1e-15);
        assert_eq!((found.relative_max, found.relative_p999), (0.5, 0.5));
        assert_eq!((found.flips, found.pixels), (2, 4));
    }

    #[test]
    fn what_is_not_finite() {
        let (nan, inf) = (f32::NAN, f32::INFINITY);
        let same = metrics(&[&[nan, inf, 1.0]], &[&[nan, inf, 1.0]], 1);
        assert_eq!((same.max_error, same.max_at, same.flips), (0.0, None, 0));
        assert_eq!(
            [same.not_finite_in_reference, same.not_finite_in_image],
            [2; 2]
        );
        for (r, i) in [(nan, 1.0), (1.0, nan), (inf, 1.0), (inf, -inf), (nan, inf)] {
            let found = metrics(&[&[1.0, r]], &[&[1.0, i]], 1);
            assert_eq!(found.max_error, f64::INFINITY, "{r} {i}");
            assert_eq!((found.mean_error, found.rmse), (0.0, 0.0), "{r} {i}");
            assert_eq!(found.flips, 1, "{r} {i}");
        }
    }

    #[test]
    fn black_has_no_relative_error() {
        let found = metrics(&[&[0.0; 4]], &[&[0.0; 4]], 1);
        assert_eq!(
            (found.relative_max, found.relmse, found.median),
            (0.0, 0.0, 0.0)
        );
        assert_eq!(found.psnr, f64::INFINITY);
        let found = metrics(&[&[0.0; 4]], &[&[0.0, 0.0, 0.0, 1.0]], 1);
        assert_eq!((found.relative_max, found.flips), (f64::INFINITY, 1));
    }
}
