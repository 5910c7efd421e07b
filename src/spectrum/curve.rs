//! Spectra as users and tables give them: points of a curve, or single lines.

use std::fmt;

use super::{FIRST, LAST, SAMPLES, Spectrum, VISIBLE};

/// A tabulated spectrum: at least two points, ascending in wavelength, none of them negative.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    wavelengths: Vec<f64>,
    values: Vec<f64>,
}

/// What is wrong with a curve or with lines; `index` counts the points from 0.
#[derive(Clone, Debug, PartialEq)]
pub enum CurveProblem {
    /// A curve of one point, or none.
    TooFewPoints {
        /// How many there are.
        points: usize,
    },
    /// More of one than of the other.
    UnequalLengths {
        /// Wavelengths.
        wavelengths: usize,
        /// Values.
        values: usize,
    },
    /// A wavelength that is not a positive, finite number of nm.
    BadWavelength {
        /// Which point.
        index: usize,
        /// As understood.
        nm: f64,
    },
    /// A wavelength that is not above the one before.
    NotAscending {
        /// Which point.
        index: usize,
        /// Its wavelength.
        nm: f64,
        /// The wavelength before.
        before: f64,
    },
    /// A value that is negative, infinite or not a number.
    BadValue {
        /// Which point.
        index: usize,
        /// As understood.
        value: f64,
    },
    /// A line at a wavelength that is not on the grid's range.
    OutsideGrid {
        /// Which line.
        index: usize,
        /// Its wavelength.
        nm: f64,
    },
    /// No lines at all.
    NoLines,
}

impl CurveProblem {
    /// The point that is wrong, if it is one.
    pub const fn index(&self) -> Option<usize> {
        match *self {
            Self::BadWavelength { index, .. }
            | Self::NotAscending { index, .. }
            | Self::BadValue { index, .. }
            | Self::OutsideGrid { index, .. } => Some(index),
            Self::TooFewPoints { .. } | Self::UnequalLengths { .. } | Self::NoLines => None,
        }
    }

    /// Whether it is about a wavelength, rather than about a value.
    pub const fn is_about_wavelength(&self) -> bool {
        match self {
            Self::BadWavelength { .. } | Self::NotAscending { .. } | Self::OutsideGrid { .. } => {
                true
            }
            Self::TooFewPoints { .. }
            | Self::UnequalLengths { .. }
            | Self::BadValue { .. }
            | Self::NoLines => false,
        }
    }
}

impl fmt::Display for CurveProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::TooFewPoints { points: 0 } => {
                write!(f, "the curve has no points, expected at least 2")
            }
            Self::TooFewPoints { points } => {
                let plural = if points == 1 { "" } else { "s" };
                write!(
                    f,
                    "the curve has {points} point{plural}, expected at least 2"
                )
            }
            Self::UnequalLengths {
                wavelengths,
                values,
            } => write!(
                f,
                "the curve has {wavelengths} wavelengths and {values} values, expected as many \
                 of both",
            ),
            Self::BadWavelength { nm, .. } => write!(
                f,
                "the wavelength is {nm}, expected a number of nanometers above 0"
            ),
            Self::NotAscending { nm, before, .. } if nm == before => write!(
                f,
                "the wavelength {nm} nm is there twice, expected each once, in ascending order"
            ),
            Self::NotAscending { nm, before, .. } => write!(
                f,
                "the wavelength {nm} nm comes after {before} nm, expected ascending order"
            ),
            Self::BadValue { value, .. } => {
                write!(f, "the value is {value}, expected a number of at least 0")
            }
            Self::OutsideGrid { nm, .. } => write!(
                f,
                "the line is at {nm} nm, expected a wavelength from {FIRST} to {LAST} nm"
            ),
            Self::NoLines => write!(f, "there are no lines, expected at least 1"),
        }
    }
}

impl Curve {
    /// A curve through points: `wavelengths` in nm and a value for each.
    ///
    /// # Errors
    /// Fewer than two points, unequal lengths, wavelengths that are not positive, finite and
    /// strictly ascending, values that are negative or not finite.
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
        for (index, (&nm, &value)) in wavelengths.iter().zip(&values).enumerate() {
            if !(nm.is_finite() && nm > 0.0) {
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

    /// The curve on the grid: linear between the points, constant beyond the first and the last.
    ///
    /// Linear, because it stays between its neighbors: a narrow line is not surrounded by ripples
    /// below zero, and a reflectance does not exceed 1.
    pub fn spectrum(&self) -> Spectrum {
        let (wavelengths, values) = (&self.wavelengths, &self.values);
        let mut above = 0;
        Spectrum::from_fn(|nm| {
            while above < wavelengths.len() && wavelengths[above] < nm {
                above += 1;
            }
            if above == 0 {
                values[0]
            } else if above == wavelengths.len() {
                values[above - 1]
            } else {
                let (from, to) = (wavelengths[above - 1], wavelengths[above]);
                let share = (nm - from) / (to - from);
                values[above - 1] * (1.0 - share) + values[above] * share
            }
        })
    }
}

/// An emission of single wavelengths, each with its power.
#[derive(Clone, Debug, PartialEq)]
pub struct Lines(Vec<[f64; 2]>);

impl Lines {
    /// Lines of (wavelength in nm, power); any order, also several at one wavelength.
    ///
    /// # Errors
    /// No lines, wavelengths beyond the grid, powers that are negative or not finite.
    pub fn new(lines: Vec<[f64; 2]>) -> Result<Self, CurveProblem> {
        if lines.is_empty() {
            return Err(CurveProblem::NoLines);
        }
        for (index, &[nm, value]) in lines.iter().enumerate() {
            if !(f64::from(FIRST)..=f64::from(LAST)).contains(&nm) {
                return Err(CurveProblem::OutsideGrid { index, nm });
            }
            if !(value.is_finite() && value >= 0.0) {
                return Err(CurveProblem::BadValue { index, value });
            }
        }
        Ok(Self(lines))
    }

    /// Wavelength in nm and power of each line.
    pub fn lines(&self) -> &[[f64; 2]] {
        &self.0
    }

    /// The lines on the grid, as power per nm: each is parted among the two wavelengths beside it,
    /// the nearer getting more.
    ///
    /// An integral with any weights is then the weights' own, interpolated linearly at the line.
    pub fn spectrum(&self) -> Spectrum {
        let mut values = [0.0; SAMPLES];
        for &[nm, power] in &self.0 {
            let place = nm - f64::from(FIRST);
            let below = (place as usize).min(SAMPLES - 2);
            let share = place - below as f64;
            values[below] += power * (1.0 - share);
            values[below + 1] += power * share;
        }
        Spectrum(Box::new(values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn lines_keep_their_power_and_their_place() {
        let lines = Lines::new(vec![[589.0, 0.5], [589.6, 0.25], [830.0, 1.0]]).unwrap();
        let spectrum = lines.spectrum();
        assert!((spectrum.total() - 1.75).abs() < 1e-15);
        let first_moment: f64 = super::super::wavelengths()
            .zip(spectrum.values())
            .map(|(nm, power)| nm * power)
            .sum();
        let expected = 589.0 * 0.5 + 589.6 * 0.25 + 830.0;
        assert!((first_moment - expected).abs() < 1e-10);
        assert!(Lines::new(Vec::new()).is_err());
        assert!(Lines::new(vec![[359.0, 1.0]]).is_err());
        assert!(Lines::new(vec![[f64::NAN, 1.0]]).is_err());
        assert!(Lines::new(vec![[500.0, -1.0]]).is_err());
    }
}
