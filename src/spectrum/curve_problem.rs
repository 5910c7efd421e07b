//! What is wrong with a curve or with lines, and how to say it.

use std::fmt;

use super::wavelength_unit::WavelengthUnit;
use super::{FIRST, LAST};
use crate::printable::counted;

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
    /// All points beyond the same end of the grid's range, as where wavelengths are in another unit:
    /// nothing is said about the light that is computed.
    BesideGrid {
        /// The smallest wavelength, taken for nm.
        smallest: f64,
        /// The largest wavelength, taken for nm.
        largest: f64,
        /// Units in which some of the points would be on the range.
        units: Vec<WavelengthUnit>,
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
            Self::TooFewPoints { .. }
            | Self::UnequalLengths { .. }
            | Self::BesideGrid { .. }
            | Self::NoLines => None,
        }
    }

    /// Whether it is about a wavelength, rather than about a value.
    pub const fn is_about_wavelength(&self) -> bool {
        match self {
            Self::BadWavelength { .. }
            | Self::BesideGrid { .. }
            | Self::NotAscending { .. }
            | Self::OutsideGrid { .. } => true,
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
            Self::TooFewPoints { points } => write!(
                f,
                "the curve has {}, expected at least 2",
                counted(points, "point", "points")
            ),
            Self::UnequalLengths {
                wavelengths,
                values,
            } => write!(
                f,
                "the curve has {} and {}, expected as many of both",
                counted(wavelengths, "wavelength", "wavelengths"),
                counted(values, "value", "values"),
            ),
            Self::BadWavelength { nm, .. } => write!(
                f,
                "the wavelength is {nm}, expected a number of nanometers above 0"
            ),
            Self::BesideGrid {
                smallest,
                largest,
                ref units,
            } => {
                write!(
                    f,
                    "no point of the curve is from {FIRST} to {LAST} nm, all are from {smallest} to \
                     {largest}; wavelengths are in nm"
                )?;
                write_units(f, ", these look like", units)
            }
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
            )
            .and_then(|()| write_units(f, "; this looks like", &WavelengthUnit::likely(&[nm]))),
            Self::NoLines => write!(f, "there are no lines, expected at least 1"),
        }
    }
}

/// "these look like µm (1 µm is 1000 nm)", or nothing where there are no units.
fn write_units(f: &mut fmt::Formatter<'_>, start: &str, units: &[WavelengthUnit]) -> fmt::Result {
    for (number, unit) in units.iter().enumerate() {
        let link = if number == 0 { start } else { " or" };
        write!(f, "{link} {unit} ({})", unit.in_nm())?;
    }
    Ok(())
}
