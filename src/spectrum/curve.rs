//! Spectra as users and tables give them: points of a curve.

use std::ops::Range;

use super::curve_problem::CurveProblem;
use super::wavelength_unit::WavelengthUnit;
use super::{FIRST, LAST, Spectrum, VISIBLE, is_on_grid};

/// Neighbors closer than this, in nm, are finer than the grid. Less than 1 by a rounding, so that a
/// table such as 400.1, 401.1, … is not.
const FINE: f64 = 1.0 - 1e-9;

/// A tabulated spectrum: at least two points, ascending in wavelength, none of them negative.
///
/// It is linear between its points and constant beyond; [`Curve::spectrum`] says what becomes of
/// points closer than the grid's 1 nm.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    wavelengths: Vec<f64>,
    values: Vec<f64>,
}

impl Curve {
    /// A curve through points: `wavelengths` in nm and a value for each.
    ///
    /// # Errors
    /// Fewer than two points, unequal lengths, wavelengths that are not positive, finite and
    /// strictly ascending, or all below 360 nm or all above 830 nm, values that are negative or
    /// not finite.
    pub fn new(wavelengths: Vec<f64>, values: Vec<f64>) -> Result<Self, CurveProblem> {
        if wavelengths.len() != values.len() {
            return Err(CurveProblem::UnequalLengths {
                wavelengths: wavelengths.len(),
                values: values.len(),
            });
        }
        if wavelengths.len() < 2 {
            let points = wavelengths.len();
            return Err(CurveProblem::TooFewPoints { points });
        }
        let is_positive = |nm: &f64| nm.is_finite() && *nm > 0.0;
        let smallest = wavelengths.iter().copied().fold(f64::INFINITY, f64::min);
        let largest = wavelengths.iter().copied().fold(0.0, f64::max);
        let is_beside = largest < f64::from(FIRST) || smallest > f64::from(LAST);
        if wavelengths.iter().all(is_positive) && is_beside {
            return Err(CurveProblem::BesideGrid {
                smallest,
                largest,
                units: WavelengthUnit::likely(&wavelengths),
            });
        }
        for (index, (&nm, &value)) in wavelengths.iter().zip(&values).enumerate() {
            if !is_positive(&nm) {
                return Err(CurveProblem::BadWavelength { index, nm });
            }
            if index > 0 && nm <= wavelengths[index - 1] {
                let before = wavelengths[index - 1];
                return Err(CurveProblem::NotAscending { index, nm, before });
            }
            if !(value.is_finite() && value >= 0.0) {
                return Err(CurveProblem::BadValue { index, value });
            }
        }
        Ok(Self {
            wavelengths,
            values,
        })
    }

    /// The wavelengths of the points in nm.
    pub fn wavelengths(&self) -> &[f64] {
        &self.wavelengths
    }

    /// The value of each point.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// The range of the points in nm, where it leaves out a part of what is [`VISIBLE`].
    pub fn gap(&self) -> Option<[f64; 2]> {
        let range = [
            self.wavelengths[0],
            self.wavelengths[self.wavelengths.len() - 1],
        ];
        (range[0] > VISIBLE[0] || range[1] < VISIBLE[1]).then_some(range)
    }

    /// The largest value of the points on the grid's range, and the wavelength in nm where it is
    /// first; `None` if no point is there. [`Curve::spectrum`] may not reach it.
    pub fn peak(&self) -> Option<(f64, f64)> {
        let points = self.values.iter().copied().zip(self.wavelengths.iter());
        let points = points.filter(|&(_, &nm)| is_on_grid(nm));
        points.fold(None, |peak, (value, &nm)| match peak {
            Some((largest, _)) if largest >= value => peak,
            Some(_) | None => Some((value, nm)),
        })
    }

    /// The curve on the grid: linear between the points, constant beyond the first and the last.
    ///
    /// Linear, because it stays between its neighbors: a narrow line is not surrounded by ripples
    /// below zero, and a reflectance does not exceed 1.
    ///
    /// Where points are 1 nm apart or more, the value at λ_i is the curve's own. Where two neighbors
    /// that reach into (λ_i − 1, λ_i + 1) are closer, it is the mean
    ///
    /// S_i = ∫ f(λ) max(0, 1 − |λ − λ_i|) dλ, in nm,
    ///
    /// so that a line finer than the grid keeps its power wherever it lies: the weights of neighbors
    /// sum to 1 everywhere.
    pub fn spectrum(&self) -> Spectrum {
        Spectrum::from_fn(|nm| {
            // The points within reach, and one on either side.
            let inside = self.wavelengths.partition_point(|&point| point <= nm - 1.0);
            let beyond = self.wavelengths.partition_point(|&point| point < nm + 1.0);
            let around = inside.saturating_sub(1)..self.wavelengths.len().min(beyond + 1);
            let mut neighbors = self.wavelengths[around].windows(2);
            if neighbors.any(|pair| pair[1] - pair[0] < FINE) {
                self.mean(nm, inside..beyond)
            } else {
                self.at(nm)
            }
        })
    }

    /// The value at any wavelength in nm.
    fn at(&self, nm: f64) -> f64 {
        let (wavelengths, values) = (&self.wavelengths, &self.values);
        let above = wavelengths.partition_point(|&point| point < nm);
        if above == 0 {
            values[0]
        } else if above == wavelengths.len() {
            values[above - 1]
        } else {
            let (from, to) = (wavelengths[above - 1], wavelengths[above]);
            let share = (nm - from) / (to - from);
            values[above - 1] * (1.0 - share) + values[above] * share
        }
    }

    /// ∫ f(λ) max(0, 1 − |λ − center|) dλ, with `inside` the points less than 1 nm from the center.
    ///
    /// Between the points and the center both factors are linear, so that Simpson's rule is exact.
    fn mean(&self, center: f64, inside: Range<usize>) -> f64 {
        let own = |i: usize| (self.wavelengths[i], self.values[i]);
        let middle = inside.start
            + self.wavelengths[inside.clone()].partition_point(|&point| point < center);
        let computed = |nm: f64| std::iter::once((nm, self.at(nm)));
        let breaks = computed(center - 1.0)
            .chain((inside.start..middle).map(own))
            .chain(computed(center))
            .chain((middle..inside.end).map(own))
            .chain(computed(center + 1.0));
        let (mut sum, mut least, mut most) = (0.0, f64::INFINITY, 0.0_f64);
        let mut before: Option<(f64, f64)> = None;
        for (nm, value) in breaks {
            (least, most) = (least.min(value), most.max(value));
            if let Some((from, start)) = before {
                let weights = [from, nm].map(|nm| 1.0 - (nm - center).abs());
                let middle = (start + value) * (weights[0] + weights[1]);
                sum += (nm - from) / 6.0 * (start * weights[0] + middle + value * weights[1]);
            }
            before = Some((nm, value));
        }
        // A mean is within; a rounding must not make a reflectance of 1 more than that.
        sum.clamp(least, most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sums of a few terms below 1, but with wavelengths of hundreds of nm in between.
    const ROUNDING: f64 = 1e-12;

    #[test]
    fn curves_are_linear_between_points_and_constant_beyond() {
        let curve = Curve::new(vec![400.5, 410.5, 700.0], vec![1.0, 3.0, 0.5]).unwrap();
        let spectrum = curve.spectrum();
        assert_eq!(spectrum.at(360.0), 1.0);
        assert_eq!(spectrum.at(400.0), 1.0);
        assert!((spectrum.at(405.0) - 1.9).abs() < 1e-15);
        assert_eq!(spectrum.at(700.0), 0.5);
        assert_eq!(spectrum.at(830.0), 0.5);
        assert_eq!(curve.gap(), Some([400.5, 700.0]));
    }

    #[test]
    fn any_spacing_gives_the_same_straight_line() {
        let wavelengths = vec![300.0, 361.7, 500.0, 500.001, 777.7, 2000.0];
        let values = wavelengths.iter().map(|nm| nm / 1000.0).collect();
        let curve = Curve::new(wavelengths, values).unwrap();
        for (nm, value) in super::super::wavelengths().zip(curve.spectrum().values()) {
            assert!((value - nm / 1000.0).abs() < 1e-14);
        }
        assert_eq!(curve.gap(), None);
    }

    /// The triangles of a line of mercury, wherever between two wavelengths of the grid it is.
    #[test]
    fn fine_light_keeps_its_power_and_its_place() {
        for shift in [0.0, 0.1, 0.25, 0.5, 0.77] {
            let wavelengths: Vec<f64> = [435.0, 435.6, 435.8, 436.0, 436.6]
                .map(|nm| nm + shift)
                .to_vec();
            let values = vec![0.0, 0.01, 1.0, 0.01, 0.0];
            let spectrum = Curve::new(wavelengths, values).unwrap().spectrum();
            assert!((spectrum.total() - 0.208).abs() < ROUNDING, "{shift}");
            let moments = super::super::wavelengths().zip(spectrum.values());
            let moment: f64 = moments.map(|(nm, power)| (nm - 435.8) * power).sum();
            assert!((moment - shift * 0.208).abs() < ROUNDING, "{shift}");
        }
        // ∫ max(0, 1 − |λ − 435.8|/0.2) max(0, 1 − |λ − 436|) dλ = 0.2 · 0.8, because
        // the line is all on one side of 436 nm, where the weight is linear.
        let line = Curve::new(vec![435.6, 435.8, 436.0], vec![0.0, 1.0, 0.0]).unwrap();
        let spectrum = line.spectrum();
        assert!((spectrum.at(435.0) - 0.2 * 0.2).abs() < ROUNDING);
        assert!((spectrum.at(436.0) - 0.2 * 0.8).abs() < ROUNDING);
        assert_eq!([434.0, 437.0].map(|nm| spectrum.at(nm)), [0.0; 2]);
    }

    /// A curve of any noise at 0.05 nm: the trapezoids that it is made of.
    #[test]
    fn fine_light_is_its_integral() {
        let wavelengths: Vec<f64> = (0..=8000).map(|i| 380.0 + 0.05 * f64::from(i)).collect();
        let noise = |i: u32| f64::from(i.wrapping_mul(2_654_435_761) >> 16) / 65536.0;
        let mut values: Vec<f64> = (0..=8000).map(noise).collect();
        (values[0], values[8000]) = (0.0, 0.0);
        let trapezoids: f64 = (1..=8000)
            .map(|i| (wavelengths[i] - wavelengths[i - 1]) * (values[i] + values[i - 1]) / 2.0)
            .sum();
        let curve = Curve::new(wavelengths, values).unwrap();
        let error = curve.spectrum().total() / trapezoids - 1.0;
        assert!(error.abs() < 1e-12, "{error}");
    }

    #[test]
    fn fine_reflectances_stay_within_their_range() {
        for step in [0.01, 0.1, 0.3, 0.7, 0.999] {
            let wavelengths: Vec<f64> = (0..1000).map(|i| 400.0 + step * f64::from(i)).collect();
            let one = Curve::new(wavelengths.clone(), vec![1.0; 1000]).unwrap();
            assert_eq!(one.spectrum(), Spectrum::constant(1.0), "{step}");
            let values = (0..1000).map(|i| if i % 3 == 0 { 1.0 } else { 0.25 });
            let comb = Curve::new(wavelengths, values.collect()).unwrap();
            let values = comb.spectrum();
            assert!(values.values().iter().all(|v| (0.25..=1.0).contains(v)));
        }
    }

    /// Where no neighbors are closer than 1 nm, the values at the grid are the curve's own, to the
    /// bit, and a fine part elsewhere does not change them.
    #[test]
    fn other_curves_are_sampled() {
        let wavelengths: Vec<f64> = (0..=400).map(|i| 380.1 + f64::from(i)).collect();
        let values: Vec<f64> = (0..=400).map(|i| f64::from(i * 37 % 101)).collect();
        let coarse = Curve::new(wavelengths.clone(), values.clone()).unwrap();
        let sampled = Spectrum::from_fn(|nm| coarse.at(nm));
        assert_eq!(coarse.spectrum(), sampled);
        let (mut finer, mut values) = (wavelengths, values);
        finer.insert(101, 480.6);
        values.insert(101, 500.0);
        let finer = Curve::new(finer, values).unwrap().spectrum();
        for (nm, (finer, sampled)) in
            super::super::wavelengths().zip(finer.values().iter().zip(sampled.values()))
        {
            assert_eq!(
                finer != sampled,
                [480.0, 481.0, 482.0].contains(&nm),
                "{nm}"
            );
        }
    }

    #[test]
    fn peaks_are_of_points_on_the_grid_s_range() {
        let peak = |wavelengths: [f64; 3], values: [f64; 3]| {
            let curve = Curve::new(wavelengths.to_vec(), values.to_vec()).unwrap();
            curve.peak()
        };
        assert_eq!(
            peak([550.0, 550.4, 551.0], [0.1, 5.0, 0.1]),
            Some((5.0, 550.4))
        );
        assert_eq!(
            peak([300.0, 550.0, 900.0], [9.0, 1.0, 7.0]),
            Some((1.0, 550.0))
        );
        assert_eq!(
            peak([400.0, 500.0, 600.0], [1.0, 2.0, 2.0]),
            Some((2.0, 500.0))
        );
        assert_eq!(peak([300.0, 350.0, 900.0], [1.0; 3]), None);
    }

    #[test]
    fn other_units_are_recognized() {
        use WavelengthUnit as Unit;
        let problem = |wavelengths: &[f64]| {
            let values = vec![1.0; wavelengths.len()];
            Curve::new(wavelengths.to_vec(), values).unwrap_err()
        };
        for (wavelengths, expected) in [
            (&[0.38, 0.55, 0.78][..], &[Unit::Micrometer][..]),
            (&[3800.0, 5500.0, 7800.0], &[Unit::Angstrom]),
            (&[12_900.0, 18_000.0, 26_300.0], &[Unit::Wavenumber]),
            // Whatever the order: wavenumbers that ascend as wavelengths do.
            (&[26_300.0, 18_000.0, 12_900.0], &[Unit::Wavenumber]),
            (&[1.6, 2.3, 3.2], &[Unit::Electronvolt]),
            (&[3.8e-7, 5.5e-7, 7.8e-7], &[Unit::Meter]),
            (&[3.8e-4, 5.5e-4, 7.8e-4], &[Unit::Millimeter]),
            (&[3.8e14, 5.5e14, 7.8e14], &[Unit::Hertz]),
            (
                &[0.3, 0.5, 1.0, 2.5],
                &[Unit::Micrometer, Unit::Electronvolt],
            ),
            (
                &[3000.0, 5000.0, 25_000.0],
                &[Unit::Angstrom, Unit::Wavenumber],
            ),
            // Infrared and ultraviolet alone.
            (&[900.0, 1700.0], &[]),
            (&[250.0, 350.0], &[]),
        ] {
            let problem = problem(wavelengths);
            assert!(problem.is_about_wavelength() && problem.index().is_none());
            let CurveProblem::BesideGrid { units, .. } = &problem else {
                panic!("{problem}");
            };
            assert_eq!(units, expected, "{wavelengths:?}");
        }
        assert_eq!(
            problem(&[0.38, 0.55, 0.78]).to_string(),
            "no point of the curve is from 360 to 830 nm, all are from 0.38 to 0.78; wavelengths are \
             in nm, these look like µm (1 µm is 1000 nm)"
        );
        assert_eq!(
            problem(&[900.0, 1700.0]).to_string(),
            "no point of the curve is from 360 to 830 nm, all are from 900 to 1700; wavelengths are \
             in nm"
        );
    }

    #[test]
    fn bad_curves_are_refused() {
        let problem = |wavelengths: &[f64], values: &[f64]| {
            Curve::new(wavelengths.to_vec(), values.to_vec()).unwrap_err()
        };
        assert_eq!(
            problem(&[400.0], &[1.0]),
            CurveProblem::TooFewPoints { points: 1 }
        );
        assert_eq!(
            problem(&[400.0, 500.0], &[1.0]),
            CurveProblem::UnequalLengths {
                wavelengths: 2,
                values: 1
            }
        );
        for (wavelengths, values, index) in [
            ([400.0, 400.0, 500.0], [1.0; 3], 1),
            ([400.0, 500.0, 450.0], [1.0; 3], 2),
            ([f64::NAN, 500.0, 600.0], [1.0; 3], 0),
            ([-1.0, 500.0, 600.0], [1.0; 3], 0),
            ([400.0, 500.0, 600.0], [1.0, -0.1, 1.0], 1),
            ([400.0, 500.0, 600.0], [1.0, 1.0, f64::NAN], 2),
            ([400.0, 500.0, f64::INFINITY], [1.0; 3], 2),
        ] {
            let problem = problem(&wavelengths, &values);
            assert_eq!(problem.index(), Some(index), "{problem}");
        }
    }
}
