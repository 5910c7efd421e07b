//! Tiles whose pixels are rendered to an error: proven ones by one sample or a few, all others by as many as their
//! estimate asks for.

use super::accuracy::{ErrorCounts, Goal};
use super::batch::Selection;
use super::counts::Counts;
use super::sink::RenderedTile;
use super::statistics::QUARTERS;
use super::sums::narrowed;
use super::tile::{Kept, Setup, Space, Tile};
use crate::image::Window;
use crate::quadrature::{Quadrature, Range, Verdict};

/// Samples of the first pass over a pixel that nothing is proven of; each one after it makes them four times as many.
const FIRST_SAMPLES: u32 = 16;

/// How far the mean of N samples is off on both sides of an edge of height 1, as the root of the mean square: this times
/// N to the power of −3/4, over 1500 random edges.
const EDGE_ERROR: f64 = 0.396;

/// An edge is taken to be off by so many of these: of a hundred edges one is off by more.
const EDGE_MARGIN: f64 = 2.0;

/// The mean is taken to be off by so many of the deviations of four quarters, where they bend less than an edge does.
const DEVIATION_MARGIN: f64 = 2.0;

/// The same where there is no edge: the mean of four times as many samples is then off by an eighth.
const SMOOTH_MARGIN: f64 = 0.5;

/// What is listed in a pixel and no sample met is taken to cover as much of it as a sample stands for, times this: most
/// of it is not in the pixel at all, and of the rest no strip along an axis is twice as wide as a sample's.
const UNMET_PART: f64 = 0.45;

/// A part of a pixel takes about as long as so many samples.
const SAMPLES_OF_PART: u32 = 4;

/// Pixels that so many samples leave open are integrated in parts.
const DIVIDED_FROM: u32 = 256;

/// The relative rounding of a pixel to 32 bits.
const ROUNDING: f64 = f32::EPSILON as f64 * 0.5;

/// How exact a pixel is.
#[derive(Clone, Copy, Debug, PartialEq)]
struct PixelError {
    /// R, G, B and A.
    error: [f64; 4],
    /// The largest of R, G and B over the larger of radiance and floor.
    relative: f64,
    is_bound: bool,
    is_met: bool,
}

/// What a thread needs to render tiles to an error.
pub(super) struct Adaptive<'w> {
    quadrature: Quadrature<'w>,
    verdicts: Vec<Verdict>,
    errors: Vec<PixelError>,
}

impl<'w> Adaptive<'w> {
    pub(super) fn new(setup: &Setup<'w>, goal: &Goal) -> Self {
        Self {
            quadrature: Quadrature::new(
                setup.world,
                setup.camera,
                setup.visibility,
                setup.simd,
                goal.target,
                goal.is_plain,
            ),
            verdicts: Vec::new(),
            errors: Vec::new(),
        }
    }

    /// Renders a tile.
    pub(super) fn render(
        &mut self,
        setup: &Setup<'w>,
        goal: &'w Goal,
        window: Window,
        tile: &mut Tile<'w>,
        space: &mut Space,
        rendered: &mut RenderedTile,
    ) -> Counts {
        tile.begin(setup, window);
        self.quadrature.tell(window, &mut self.verdicts);
        self.errors.clear();
        let mut smooth = [Selection::NONE; 4];
        let mut open = Selection::NONE;
        for (pixel, place) in tile.places().enumerate() {
            let verdict = &self.verdicts[number(window, place)];
            let (error, relative, is_bound) = match *verdict {
                Verdict::Smooth {
                    side,
                    error: [r, g, b],
                    is_bound,
                    relative,
                } => {
                    smooth[side.trailing_zeros() as usize].insert(pixel);
                    ([r, g, b, 0.0], relative, is_bound)
                }
                Verdict::Interpolated {
                    mean,
                    error,
                    is_bound,
                }
                | Verdict::Integrated {
                    mean,
                    error,
                    is_bound,
                } => (error, goal.target.largest(&mean, &error), is_bound),
                Verdict::Open { .. } => {
                    open.insert(pixel);
                    ([f64::INFINITY; 4], f64::INFINITY, false)
                }
            };
            self.errors.push(PixelError {
                error,
                relative,
                is_bound,
                is_met: !matches!(verdict, Verdict::Open { .. }),
            });
        }
        let mut counts = Counts::default();
        for (grid, selection) in goal.grids.iter().zip(smooth) {
            if selection != Selection::NONE {
                let setup = Setup {
                    sampler: grid,
                    ..*setup
                };
                let all = tile.places().len();
                let selection = if selection.iter().count() == all {
                    Selection::ALL
                } else {
                    selection
                };
                let taken = tile.pass(&setup, 0..grid.samples(), &selection, space);
                counts = counts.and(taken);
            }
        }
        if open != Selection::NONE {
            tile.keep(Kept::SumsAndStatistics);
            counts = counts.and(self.sample(setup, goal, open, window, tile, space));
        }
        counts = counts.and(tile.means(setup, rendered));
        self.finish(goal, tile, rendered, counts)
    }

    /// Samples pixels until their estimates are good enough.
    fn sample(
        &mut self,
        setup: &Setup<'w>,
        goal: &Goal,
        mut open: Selection,
        window: Window,
        tile: &mut Tile<'w>,
        space: &mut Space,
    ) -> Counts {
        let mut counts = Counts::default();
        let places: Vec<[u32; 2]> = tile.places().collect();
        let mut samples = 0..FIRST_SAMPLES.min(goal.max_samples);
        while open != Selection::NONE {
            counts = counts.and(tile.pass(setup, samples.clone(), &open, space));
            for pixel in open.iter() {
                let verdict = &self.verdicts[number(window, places[pixel])];
                let (mean, mut error) =
                    estimate(tile, pixel, samples.end, verdict, goal.target.floor);
                for error in &mut error[..3] {
                    *error += setup.left_out;
                }
                if goal.target.floor == 0.0 && mean[..3] == [0.0; 3] {
                    // In a picture that is black at all points nothing else is expected where it is black again.
                    error[..3].fill(0.0);
                }
                let mut is_met = goal.target.is_met(mean, error);
                self.errors[pixel] = PixelError {
                    error,
                    relative: goal.target.largest(&mean, &error),
                    is_bound: false,
                    is_met,
                };
                let is_last = samples.end >= goal.max_samples;
                if !is_met && goal.is_plain && (samples.end >= DIVIDED_FROM || is_last) {
                    is_met = self.divide(goal, window, pixel, places[pixel], samples.end);
                }
                if is_met || is_last {
                    open.remove(pixel);
                } else {
                    tile.widen(pixel);
                }
            }
            samples = samples.end..samples.end.saturating_mul(4).min(goal.max_samples);
        }
        counts
    }

    /// Integrates a pixel in parts: whether that is exact enough. If it is not when there are no more samples, but is nearer
    /// than they are, it is taken as well.
    fn divide(
        &mut self,
        goal: &Goal,
        window: Window,
        pixel: usize,
        place: [u32; 2],
        samples: u32,
    ) -> bool {
        let verdict = &mut self.verdicts[number(window, place)];
        if !matches!(verdict, Verdict::Open { range: Some(_), .. }) {
            return false;
        }
        let [column, row] = place;
        let place = [window.x + column, window.y + row];
        let parts = (samples / SAMPLES_OF_PART) as usize;
        let mean = self.quadrature.divide(place, parts);
        let Some(mean) = mean else {
            return false;
        };
        let relative = goal.target.largest(&mean.value, &mean.error);
        let is_met = goal.target.is_met(mean.value, mean.error);
        if is_met || (samples >= goal.max_samples && relative < self.errors[pixel].relative) {
            *verdict = Verdict::Integrated {
                mean: mean.value,
                error: mean.error,
                is_bound: mean.is_bound,
            };
            self.errors[pixel] = PixelError {
                error: mean.error,
                relative,
                // Those that miss the target are counted among the estimates.
                is_bound: mean.is_bound && is_met,
                is_met,
            };
        }
        is_met
    }

    /// Puts in what was integrated, and writes the errors.
    fn finish(
        &self,
        goal: &Goal,
        tile: &Tile<'_>,
        rendered: &mut RenderedTile,
        mut counts: Counts,
    ) -> Counts {
        let window = rendered.window();
        let mut errors = ErrorCounts {
            floor: goal.target.floor,
            ..ErrorCounts::default()
        };
        for (pixel, place) in tile.places().enumerate() {
            let verdict = &self.verdicts[number(window, place)];
            if let Verdict::Interpolated { mean, .. } | Verdict::Integrated { mean, .. } = verdict {
                let mut clamped = 0;
                let narrow = mean.map(|channel| {
                    let (value, is_clamped) = narrowed(channel);
                    clamped += u64::from(is_clamped);
                    value
                });
                rendered.set(place, narrow);
                counts.add_pixel(narrow, clamped);
            }
            let PixelError {
                error,
                relative,
                is_bound,
                is_met,
            } = self.errors[pixel];
            // A pixel is rounded to 32 bits.
            let rounded = |relative: f64| {
                if relative > 0.0 {
                    relative + ROUNDING
                } else {
                    0.0
                }
            };
            if is_bound {
                match verdict {
                    Verdict::Integrated { .. } => errors.edges += 1,
                    Verdict::Smooth { .. }
                    | Verdict::Interpolated { .. }
                    | Verdict::Open { .. } => errors.smooth += 1,
                }
                errors.worst_bound = errors.worst_bound.max(rounded(relative));
            } else {
                errors.estimated += 1;
                errors.unmet += u64::from(!is_met);
                errors.worst_estimate = errors.worst_estimate.max(rounded(relative));
            }
            if rendered.wants_errors() {
                let values = rendered.pixel(place);
                let absolute = (0..3).fold(0.0_f64, |largest, channel| {
                    let value = f64::from(values[channel]).abs();
                    largest.max(error[channel] + value * ROUNDING)
                });
                rendered.set_error(place, above(absolute), is_bound, tile.taken(pixel));
            }
        }
        counts.errors = errors;
        counts
    }
}

/// The place of a pixel of a tile, counted row by row.
fn number(window: Window, [column, row]: [u32; 2]) -> usize {
    (row * window.width + column) as usize
}

/// The next f32 that is not below.
fn above(value: f64) -> f32 {
    let near = value as f32;
    if f64::from(near) < value {
        near.next_up()
    } else {
        near
    }
}

/// R, G, B and A of so many samples of a pixel, and how far each is off: from the quarters of the samples, from the range
/// that they have, and from the range of all that is in the pixel, met or not.
fn estimate(
    tile: &Tile<'_>,
    pixel: usize,
    samples: u32,
    verdict: &Verdict,
    floor: f64,
) -> ([f64; 4], [f64; 4]) {
    let (listed, is_smooth) = match *verdict {
        Verdict::Open { range, is_smooth } => (range, is_smooth),
        Verdict::Smooth { .. } | Verdict::Interpolated { .. } | Verdict::Integrated { .. } => {
            (None, true)
        }
    };
    let count = f64::from(samples);
    let statistics = tile.statistics().expect("open pixels have statistics");
    let ([r, g, b], hits) = tile.sums_of(pixel);
    let mean = [r, g, b, f64::from(hits)].map(|sum| sum / count);
    let quarters = statistics.quarters(pixel);
    let met = {
        let ([r, g, b], [x, y, z]) = (statistics.least(pixel), statistics.most(pixel));
        let is = |truth: bool| f64::from(u8::from(truth));
        Range {
            least: [r, g, b, is(hits == samples)],
            most: [x, y, z, is(hits > 0)],
        }
    };
    let part = count.min(QUARTERS as f64);
    let (of_deviation, of_range) = if is_smooth {
        (SMOOTH_MARGIN, count.powf(-1.5))
    } else {
        let edge = EDGE_MARGIN * EDGE_ERROR * count.powf(-0.75);
        (DEVIATION_MARGIN, edge)
    };
    let error = std::array::from_fn(|channel| {
        let deviation = quarters.iter().map(|(radiance, hits)| {
            let sum = if channel < 3 {
                radiance[channel]
            } else {
                f64::from(*hits)
            };
            sum * part / count - mean[channel]
        });
        let square: f64 = deviation.map(|off| off * off).sum::<f64>();
        // The deviation of the mean of the quarters.
        let deviation = (square / (part * (part - 1.0).max(1.0))).sqrt();
        let spread = met.most[channel] - met.least[channel];
        let error = (of_deviation * deviation).max(of_range * spread);
        if is_smooth {
            // Where all is dark, the end of a penumbra may be between the samples.
            let is_dark = met.most[channel] <= 0.0;
            let end = |listed: Range| UNMET_PART / count * listed.most[channel].max(0.0);
            return error.max(listed.filter(|_| is_dark).map_or(0.0, end));
        }
        let all = match listed {
            Some(Range { least, most }) => (most[channel] - least[channel]).max(spread),
            // Whatever is not met is taken to be as bright, or black; or there is nothing.
            None if channel < 3 => spread + mean[channel].max(floor),
            None => 1.0,
        };
        error.max(UNMET_PART / count * (all - spread)).min(all)
    });
    (mean, error)
}
