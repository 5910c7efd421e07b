//! Exposure: radiance × 2^EV.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use super::Picture;
use crate::color::Primaries;

/// What a picture's radiance is multiplied by before the view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// 2^EV. Range: finite.
    Ev(f64),
    /// So that the log-average luminance becomes [`KEY`]; see [`auto_ev`].
    Auto,
    /// So that the luminance which so many percent of the lit pixels do not exceed becomes the screen's white. Range:
    /// above 0, at most 100.
    Percentile(f64),
}

impl Default for Exposure {
    /// The picture as it is.
    fn default() -> Self {
        Self::Ev(0.0)
    }
}

impl Exposure {
    /// The exposure of this picture in EV.
    pub fn ev(self, picture: &Picture<'_>) -> f64 {
        match Meter::new(self) {
            Ok(meter) => meter.ev_of(picture),
            Err(ev) => ev,
        }
    }

    /// The exposure of a photograph of the scene, whose pixels are luminances in cd/m²: a sensor of so much speed (ISO
    /// 12232:2019, by saturation), a shutter that is open for so many seconds, an aperture of f/N. What saturates
    /// it becomes the screen's white:
    ///
    /// L_max = 1.2 · 2^EV100, EV100 = log2(N²/t · 100/S).
    ///
    /// The 1.2 is 78/65: a saturation at 78 lx·s/S, and the light that a lens lets through, 65 % of π/4 L/N². Range
    /// of all three: above 0, finite.
    pub fn of_camera(iso: f64, shutter: f64, aperture: f64) -> Self {
        let ev100 = 2.0 * aperture.log2() - shutter.log2() + (100.0 / iso).log2();
        Self::Ev(-ev100 - SATURATION.log2())
    }

    /// Whether it depends on the picture.
    pub const fn is_auto(self) -> bool {
        match self {
            Self::Ev(_) => false,
            Self::Auto | Self::Percentile(_) => true,
        }
    }
}

/// The luminance that saturates a sensor, over 2^EV100 (ISO 12232:2019; Lagarde & de Rousiers 2014, section 5.1).
const SATURATION: f64 = 78.0 / 65.0;

/// What the log-average luminance is mapped to: a middle gray (Reinhard et al. 2002, eq. 2).
pub const KEY: f64 = 0.18;

/// δ of the log-average, in cd/m²: about the faintest light that a rested eye sees.
///
/// In the paper it keeps ln from pixels at 0. Here pixels at or below it do not count at all: with
/// direct light alone, whole shadows are exactly black, and any δ small enough not to veil the
/// picture would let them drag the average down by several stops.
pub const DELTA: f64 = 1e-6;

/// 2^EV, kept finite and above zero, so that neither 0 × ∞ nor an inverse can arise.
pub fn scale(ev: f64) -> f64 {
    ev.clamp(f64::from(f64::MIN_EXP) - 1.0, f64::from(f64::MAX_EXP) - 1.0)
        .exp2()
}

/// The exposure that maps the log-average luminance L̄ to [`KEY`]: EV = log2(0.18 / L̄) with
/// L̄ = exp(mean ln(δ + L)) (Reinhard, Stark, Shirley, Ferwerda: Photographic tone reproduction
/// for digital images, 2002, eq. 1 and 2). 0 where no pixel counts, as in a black picture.
///
/// L is the luminance in Rec.709, by which no coverage is multiplied. Those pixels of the display
/// window count, by their coverage, that are covered at all, whose values are finite, and whose
/// luminance is above δ = [`DELTA`]. A background seen past all objects has no coverage.
pub fn auto_ev(picture: &Picture<'_>) -> f64 {
    Exposure::Auto.ev(picture)
}

/// Measures an exposure, row by row.
pub(super) enum Meter {
    Average,
    Percentile {
        percent: f64,
        /// Pixels by the leading bits of their luminance.
        counts: Vec<AtomicU64>,
    },
}

/// Bits of an f32 luminance that are left out of the count: 12 of its digits stay, 1/4096 of it.
const UNCOUNTED: u32 = 11;

impl Meter {
    /// Unless the exposure is known, which it is then.
    pub(super) fn new(exposure: Exposure) -> Result<Self, f64> {
        match exposure {
            Exposure::Ev(ev) => Err(ev),
            Exposure::Auto => Ok(Self::Average),
            Exposure::Percentile(percent) => Ok(Self::Percentile {
                percent,
                counts: (0..=f32::MAX.to_bits() >> UNCOUNTED)
                    .map(|_| AtomicU64::new(0))
                    .collect(),
            }),
        }
    }

    /// Of a row, in its order.
    pub(super) fn of_row(&self, pixels: &[[f32; 4]]) -> LogSum {
        match self {
            Self::Average => LogSum::of_row(pixels),
            Self::Percentile { counts, .. } => {
                let weights = Primaries::REC709.luminance_weights();
                for (luminance, _) in pixels.iter().filter_map(|pixel| lit(weights, pixel)) {
                    let bits = (luminance as f32).min(f32::MAX).to_bits();
                    counts[(bits >> UNCOUNTED) as usize].fetch_add(1, Ordering::Relaxed);
                }
                LogSum::default()
            }
        }
    }

    /// The exposure of what was measured, of which this is the sum.
    pub(super) fn ev(&self, sum: LogSum) -> f64 {
        match self {
            Self::Average => sum.ev(),
            Self::Percentile { percent, counts } => {
                let counts = counts.iter().map(|count| count.load(Ordering::Relaxed));
                let all: u64 = counts.clone().sum();
                // The nearest rank.
                let rank = (all as f64 * percent / 100.0).ceil().max(1.0);
                let mut below = 0;
                let reached = counts.into_iter().position(|count| {
                    below += count;
                    below as f64 >= rank
                });
                let Some(place) = reached.filter(|_| all > 0) else {
                    return 0.0;
                };
                // The middle of what has these bits.
                let bits = (place as u32) << UNCOUNTED | 1 << (UNCOUNTED - 1);
                -f64::from(f32::from_bits(bits)).log2()
            }
        }
    }

    fn ev_of(&self, picture: &Picture<'_>) -> f64 {
        let width = picture.width();
        let rows = picture.pixels().par_chunks(width.max(1));
        // Rows added in order: the same sum for any number of threads, from a film and from a file.
        let rows: Vec<LogSum> = rows.map(|row| self.of_row(row)).collect();
        self.ev(rows.into_iter().fold(LogSum::default(), LogSum::and))
    }
}

/// The luminance of a pixel that counts for the exposure, and its coverage.
fn lit(weights: [f64; 3], pixel: &[f32; 4]) -> Option<(f64, f64)> {
    let [r, g, b, alpha] = pixel.map(f64::from);
    // An infinity or a negative alpha makes the luminance infinite, NaN or negative.
    let luminance = (weights[0] * r + weights[1] * g + weights[2] * b) / alpha;
    let counts = alpha > 0.0 && luminance > DELTA && luminance.is_finite() && alpha.is_finite();
    counts.then(|| (luminance, alpha.min(1.0)))
}

/// Sums over some pixels, for the log-average luminance.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LogSum {
    /// Of ln(δ + L), by coverage.
    logarithms: f64,
    /// Of the coverage.
    coverage: f64,
}

impl LogSum {
    /// Over a row, in its order.
    pub(super) fn of_row(pixels: &[[f32; 4]]) -> Self {
        let mut sum = Self::default();
        let weights = Primaries::REC709.luminance_weights();
        for (luminance, coverage) in pixels.iter().filter_map(|pixel| lit(weights, pixel)) {
            sum.logarithms += coverage * (DELTA + luminance).ln();
            sum.coverage += coverage;
        }
        sum
    }

    pub(super) fn and(self, other: Self) -> Self {
        Self {
            logarithms: self.logarithms + other.logarithms,
            coverage: self.coverage + other.coverage,
        }
    }

    /// The exposure that makes the average a middle gray.
    pub(super) fn ev(self) -> f64 {
        if self.coverage == 0.0 {
            return 0.0;
        }
        KEY.log2() - self.logarithms / self.coverage * std::f64::consts::LOG2_E
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exr::{ColorTag, ExrImage};
    use crate::image::Window;

    /// In EV: δ beside a luminance of at least 0.18 is log2(1 + 1e-6 / 0.18) = 8.0e-6, and the
    /// rounding of the radiance to f32 at most 1e-7.
    const TOLERANCE: f64 = 8.2e-6;

    fn ev(pixels: &[[f32; 4]]) -> f64 {
        let width = pixels.len() as u32;
        auto_ev(&Picture::new(ExrImage {
            resolution: [width, 1],
            window: Some(Window {
                x: 0,
                y: 0,
                width,
                height: 1,
            }),
            pixels: pixels.to_vec(),
            has_alpha: true,
            color: ColorTag::default(),
        }))
    }

    fn gray(luminance: f32, alpha: f32) -> [f32; 4] {
        let premultiplied = luminance * alpha;
        [premultiplied, premultiplied, premultiplied, alpha]
    }

    #[track_caller]
    fn assert_close(ev: f64, expected: f64) {
        assert!((ev - expected).abs() < TOLERANCE, "{ev}, not {expected}");
    }

    #[test]
    fn a_uniform_gray_becomes_middle_gray() {
        assert_close(ev(&[gray(0.18, 1.0); 5]), 0.0);
        assert_close(ev(&[gray(0.72, 1.0); 5]), -2.0);
        // Coverage does not change what is covered.
        assert_close(ev(&[gray(0.72, 0.25); 5]), -2.0);
    }

    #[test]
    fn the_average_is_geometric_and_by_coverage() {
        // √(0.5 · 8) = 2.
        let expected = (0.18_f64 / 2.0).log2();
        assert_close(ev(&[gray(0.5, 1.0), gray(8.0, 1.0)]), expected);
        assert_close(
            ev(&[gray(0.5, 1.0), gray(8.0, 0.5), gray(8.0, 0.5)]),
            expected,
        );
    }

    #[test]
    fn luminance_is_that_of_rec709() {
        assert_close(ev(&[[0.0, 1.0, 0.0, 1.0]]), (0.18_f64 / 0.7151687).log2());
    }

    #[test]
    fn shadows_background_and_non_finite_values_do_not_count() {
        let counted = gray(0.72, 1.0);
        assert_close(
            ev(&[
                counted,
                gray(0.0, 1.0),
                [5.0, 5.0, 5.0, 0.0],
                [f32::INFINITY, 0.0, 0.0, 1.0],
                [-3.0, -3.0, -3.0, 1.0],
                [1.0, 1.0, 1.0, f32::INFINITY],
                [f32::NAN, f32::NAN, f32::NAN, 1.0],
            ]),
            -2.0,
        );
    }

    #[test]
    fn a_percentile_becomes_white() {
        let pixels: Vec<[f32; 4]> = (1..=200).map(|i| gray(i as f32, 1.0)).collect();
        let picture = Picture::new(ExrImage {
            resolution: [200, 1],
            window: Some(Window::whole([200, 1])),
            pixels,
            has_alpha: true,
            color: ColorTag::default(),
        });
        for (percent, luminance) in [(100.0, 200.0), (99.0, 198.0), (50.0, 100.0), (0.1, 1.0)] {
            let ev = Exposure::Percentile(percent).ev(&picture);
            // Half of the last of 12 bits.
            let tolerance = (1.0 + 1.0 / 8192.0_f64).log2();
            assert!(
                (ev + f64::log2(luminance)).abs() <= tolerance,
                "{percent}: {ev}"
            );
        }
    }

    /// Sunlit paper: 100 000 lx on white, by the rule of a sunny 16.
    #[test]
    fn a_camera() {
        let Exposure::Ev(ev) = Exposure::of_camera(100.0, 1.0 / 100.0, 16.0) else {
            panic!("a camera knows its exposure");
        };
        let saturated = 1.2 * 16.0 * 16.0 * 100.0;
        assert!((scale(ev) * saturated - 1.0).abs() < 1e-12);
    }

    #[test]
    fn black_stays_as_it_is() {
        assert_eq!(ev(&[gray(0.0, 1.0); 3]), 0.0);
        assert_eq!(ev(&[gray(0.0, 0.0); 3]), 0.0);
    }
}
