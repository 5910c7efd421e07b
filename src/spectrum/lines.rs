//! Spectra as users and tables give them: single lines.

use super::curve_problem::CurveProblem;
use super::{FIRST, SAMPLES, Spectrum, is_on_grid};

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
            if !is_on_grid(nm) {
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
