//! Functions of wavelength: lights and reflectances on one grid, the observers' color matching
//! functions, and the spectra that have names.
//!
//! The grid is 360 to 830 nm at 1 nm, which is the domain of the CIE's color matching functions.
//! An integral over wavelength is the sum over the grid, as CIE 15:2018 has it, with Δλ = 1 nm.
//!
//! | type | what |
//! | --- | --- |
//! | [`Spectrum`] | one number for each wavelength of the grid |
//! | [`Curve`] | a tabulated spectrum of any spacing, linear between its points |
//! | [`Lines`] | an emission of single wavelengths |
//! | [`Illuminant`] | the CIE's illuminants by name |
//! | [`daylight()`], [`blackbody()`] | spectra by temperature |
//! | [`Observer`] | color matching functions and luminous efficacy |
//! | [`upsample`] | a smooth spectrum of a given color |

mod blackbody;
mod cubic;
mod curve;
mod curve_problem;
mod daylight;
mod illuminant;
mod lines;
mod observer;
#[doc(hidden)]
pub mod tables;
#[doc(hidden)]
pub mod upsample;
mod wavelength_unit;

#[doc(hidden)]
pub use blackbody::blackbody;
pub use curve::Curve;
pub use curve_problem::CurveProblem;
#[doc(hidden)]
pub use daylight::daylight;
pub use illuminant::Illuminant;
pub use lines::Lines;
pub use observer::Observer;
pub use wavelength_unit::WavelengthUnit;

/// The first wavelength of the grid in nm.
pub const FIRST: u32 = 360;

/// The last wavelength of the grid in nm.
pub const LAST: u32 = 830;

/// Wavelengths of the grid.
#[doc(hidden)]
pub const SAMPLES: usize = (LAST - FIRST) as usize + 1;

/// The part of the grid, in nm, in which all but 5e-4 of each color matching function lies: a
/// curve should cover it.
#[doc(hidden)]
pub const VISIBLE: [f64; 2] = [380.0, 780.0];

/// The wavelengths of the grid in nm.
#[doc(hidden)]
pub fn wavelengths() -> impl Iterator<Item = f64> {
    (FIRST..=LAST).map(f64::from)
}

/// Whether a wavelength is on the range of the grid.
fn is_on_grid(nm: f64) -> bool {
    (f64::from(FIRST)..=f64::from(LAST)).contains(&nm)
}

/// A function of wavelength: one number for each nm of the grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum(Box<[f64; SAMPLES]>);

impl Spectrum {
    /// The same everywhere.
    pub fn constant(value: f64) -> Self {
        Self(Box::new([value; SAMPLES]))
    }

    /// The value of `f` at each wavelength in nm.
    pub fn from_fn(mut f: impl FnMut(f64) -> f64) -> Self {
        let mut wavelengths = wavelengths();
        Self(Box::new(std::array::from_fn(|_| {
            f(wavelengths
                .next()
                .expect("the grid has SAMPLES wavelengths"))
        })))
    }

    /// One number for each wavelength of the grid.
    pub fn values(&self) -> &[f64; SAMPLES] {
        &self.0
    }

    /// This spectrum `factor` times.
    pub fn scaled(&self, factor: f64) -> Self {
        Self(Box::new(self.0.map(|value| value * factor)))
    }

    /// This spectrum times another, wavelength by wavelength.
    pub fn times(&self, other: &Self) -> Self {
        Self(Box::new(std::array::from_fn(|i| self.0[i] * other.0[i])))
    }

    /// ∫ f(λ) w(λ) dλ
    pub fn integral(&self, weights: &[f64; SAMPLES]) -> f64 {
        self.0.iter().zip(weights).map(|(f, w)| f * w).sum()
    }

    /// ∫ f(λ) dλ
    pub fn total(&self) -> f64 {
        self.0.iter().sum()
    }

    /// The largest value, and the wavelength in nm where it is first.
    pub fn peak(&self) -> (f64, f64) {
        let start = (self.0[0], f64::from(FIRST));
        self.0
            .iter()
            .zip(wavelengths())
            .fold(
                start,
                |peak, (&value, nm)| {
                    if value > peak.0 { (value, nm) } else { peak }
                },
            )
    }

    /// The value at any wavelength in nm: linear between those of the grid, constant beyond.
    pub fn at(&self, nm: f64) -> f64 {
        let place = (nm - f64::from(FIRST)).clamp(0.0, (SAMPLES - 1) as f64);
        let below = (place as usize).min(SAMPLES - 2);
        let share = place - below as f64;
        self.0[below] * (1.0 - share) + self.0[below + 1] * share
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_between_the_grid_are_linear() {
        let spectrum = Spectrum::from_fn(|nm| 2.0 * nm);
        assert_eq!(spectrum.at(500.25), 1000.5);
        assert_eq!(spectrum.at(830.0), 1660.0);
        assert_eq!(spectrum.at(100.0), 720.0);
        assert_eq!(spectrum.at(1000.0), 1660.0);
    }

    #[test]
    fn peaks_are_found() {
        assert_eq!(Spectrum::constant(2.0).peak(), (2.0, 360.0));
        let tent = Spectrum::from_fn(|nm| 10.0 - (nm - 555.0).abs());
        assert_eq!(tent.peak(), (10.0, 555.0));
    }
}
