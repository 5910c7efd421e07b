//! Why a luminaire file cannot be used, and where in it.

use std::collections::TryReserveError;
use std::fmt;

use super::coordinates::Coordinates;
use super::limits::{LARGEST_FILE, LEAST_CANDELA, MOST_ANGLES, MOST_CANDELA};
use crate::input::{Foreign, NotAFile, is_transient};
use crate::printable::{excerpt, printable};

/// Why a luminaire file cannot be used. The message says where in the file and what was expected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IesError {
    /// The file cannot be read.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// A directory, a device, a pipe.
    #[error("{0}, expected an IES file")]
    NotAFile(#[from] NotAFile),
    /// There is not enough memory for it.
    #[error("there is not enough memory to read the luminaire file")]
    NoMemory,
    /// No bytes at all.
    #[error("the file is empty, expected an IES file (LM-63)")]
    Empty,
    /// More bytes than any luminaire has.
    #[error(
        "the file has more than {megabytes} MB, expected an IES file (LM-63), which is text of some kB",
        megabytes = LARGEST_FILE >> 20
    )]
    TooLarge,
    /// Text of an encoding that is not read, or a compressed file.
    #[error("it is {found}, expected an IES file in ASCII, Latin-1 or UTF-8; {}", .found.way_out())]
    Foreign {
        /// What it is instead.
        found: Foreign,
    },
    /// The file of tilt factors that it names cannot be read.
    #[error(
        "line {line}: the file of tilt factors `{}` cannot be read: {why}; expected it beside the IES file; without it, write `TILT=NONE`",
        printable(name)
    )]
    TiltFile {
        /// The line of the IES file that names it.
        line: usize,
        /// Its name.
        name: String,
        /// What the one who reads it says.
        why: String,
    },
    /// Something in the file is wrong.
    #[error("{place}: {fault}")]
    Invalid {
        /// Where.
        place: Place,
        /// What.
        fault: Fault,
    },
}

impl IesError {
    /// Whether another machine, or another try, may have more luck with the same file.
    pub fn is_transient(&self) -> bool {
        match self {
            Self::Io(error) => is_transient(error),
            Self::NoMemory => true,
            Self::NotAFile(_)
            | Self::Empty
            | Self::TooLarge
            | Self::Foreign { .. }
            | Self::TiltFile { .. }
            | Self::Invalid { .. } => false,
        }
    }
}

/// A place in a luminaire file, or in the file of tilt factors that it names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The name of the file of tilt factors, if it is there.
    pub tilt_file: Option<String>,
    /// The line, the first one 1.
    pub line: usize,
    /// The byte in this line, the first one 1.
    pub column: usize,
}

impl Place {
    /// That of the byte `offset`. Lines end in LF, CR LF or CR.
    pub(super) fn of(bytes: &[u8], offset: usize) -> Self {
        let before = &bytes[..offset.min(bytes.len())];
        let (mut line, mut start) = (1, 0);
        for (i, &byte) in before.iter().enumerate() {
            let ends = match byte {
                b'\n' => true,
                b'\r' => bytes.get(i + 1) != Some(&b'\n'),
                _ => false,
            };
            if ends {
                line += 1;
                start = i + 1;
            }
        }
        Self {
            tilt_file: None,
            line,
            column: before.len() - start + 1,
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(name) = &self.tilt_file {
            write!(f, "tilt file `{}`, ", printable(name))?;
        }
        write!(f, "line {}, column {}", self.line, self.column)
    }
}

/// What is wrong at a place. Each message says what was expected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Fault {
    /// Something else than what belongs there.
    #[error("found `{found}`, expected {expected}")]
    Unexpected {
        /// As written, cut to a readable length.
        found: String,
        /// What belongs there.
        expected: &'static str,
    },
    /// A file that is too short.
    #[error("the file ends, expected {expected}; it is cut off, or its counts are too high")]
    FileEnds {
        /// What is missing.
        expected: &'static str,
    },
    /// A number that is none of those that are allowed.
    #[error("{what} is {value}, expected {expected}")]
    OutOfRange {
        /// Which.
        what: &'static str,
        /// As understood.
        value: f64,
        /// What belongs there.
        expected: &'static str,
    },
    /// Counts that the file does not keep.
    #[error(
        "the file counts {vertical} vertical and {horizontal} horizontal angles, expected {needed} numbers of angles and intensities, but only {found} follow; it is cut off, or its counts are wrong"
    )]
    TooFew {
        /// Vertical angles.
        vertical: usize,
        /// Horizontal angles.
        horizontal: usize,
        /// How many numbers these need.
        needed: usize,
        /// How many are there.
        found: usize,
    },
    /// Counts beyond all luminaires.
    #[error(
        "{count} {what}, expected at most {MOST_ANGLES}; measured luminaires have some hundred"
    )]
    TooManyAngles {
        /// `vertical angles`, …
        what: &'static str,
        /// As written.
        count: f64,
    },
    /// An angle outside of its coordinate system.
    #[error(
        "{what} angle {value} of {coordinates} photometry, expected {least} to {most} degrees; see whether the type (1 for C, 2 for B, 3 for A) is the right one"
    )]
    Angle {
        /// `vertical` or `horizontal`.
        what: &'static str,
        /// As written, in degrees.
        value: f64,
        /// Of the file.
        coordinates: Coordinates,
        /// The smallest that there is.
        least: f64,
        /// The largest that there is.
        most: f64,
    },
    /// An angle that is there twice, with different values.
    #[error(
        "{what} angle {value} is there twice with different values, expected each angle once; remove one of them and its values"
    )]
    Twice {
        /// `vertical`, `horizontal` or `tilt`.
        what: &'static str,
        /// In degrees.
        value: f64,
    },
    /// Horizontal angles of type C that are of no symmetry.
    #[error(
        "horizontal angles of type C photometry from {first} to {last}, expected 0 alone, 0 to 90, 0 to 180, 90 to 270 or 0 to 360 degrees; add the planes that are missing"
    )]
    NoSymmetry {
        /// In degrees.
        first: f64,
        /// In degrees.
        last: f64,
    },
    /// Horizontal angles of type A or B that leave out the middle.
    #[error(
        "horizontal angles of {coordinates} photometry from {first} to {last}, expected at least two, from 0 (both sides alike) or from a negative angle"
    )]
    NoMiddle {
        /// Of the file.
        coordinates: Coordinates,
        /// In degrees.
        first: f64,
        /// In degrees.
        last: f64,
    },
    /// An intensity that is clearly negative.
    #[error(
        "an intensity of {value} cd, expected none below 0; only those down to {per_mille} thousandths of the largest are taken for noise and become 0",
        per_mille = super::limits::NOISE_PER_MILLE
    )]
    Negative {
        /// With all factors.
        value: f64,
    },
    /// An intensity that is no number any more.
    #[error(
        "an intensity of {value} cd with all factors, expected at most {MOST_CANDELA}; see whether the multiplier is right"
    )]
    TooBright {
        /// With all factors.
        value: f64,
    },
    /// Nothing but zeros.
    #[error(
        "no intensity is above {LEAST_CANDELA} cd, expected one at least; a lamp that is off is better left out of the scene"
    )]
    Dark,
    /// Commas that may be decimal points or separators.
    #[error(
        "commas that may be decimal points or part numbers, expected decimal points; replace the commas by points, or put blanks between the numbers"
    )]
    Commas,
    /// There is not enough memory; it becomes [`IesError::NoMemory`].
    #[error("there is not enough memory to read the luminaire file")]
    NoMemory,
}

/// A fault at a byte of the text that is read.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Problem {
    pub(super) offset: usize,
    pub(super) fault: Box<Fault>,
}

impl Problem {
    #[cold]
    pub(super) fn new(offset: usize, fault: Fault) -> Self {
        Self {
            offset,
            fault: Box::new(fault),
        }
    }

    /// `found` instead of `expected`, [as it can be shown](excerpt).
    #[cold]
    pub(super) fn unexpected(offset: usize, found: &[u8], expected: &'static str) -> Self {
        let found = excerpt(found);
        Self::new(offset, Fault::Unexpected { found, expected })
    }

    /// As the error of the file with these bytes.
    pub(super) fn in_file(self, bytes: &[u8], tilt_file: Option<&str>) -> IesError {
        if *self.fault == Fault::NoMemory {
            return IesError::NoMemory;
        }
        IesError::Invalid {
            place: Place {
                tilt_file: tilt_file.map(str::to_owned),
                ..Place::of(bytes, self.offset)
            },
            fault: *self.fault,
        }
    }
}

impl From<TryReserveError> for Problem {
    fn from(_: TryReserveError) -> Self {
        Self::new(0, Fault::NoMemory)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_lines_of_all_kinds() {
        let place = |text: &str, offset| {
            let place = Place::of(text.as_bytes(), offset);
            (place.line, place.column)
        };
        assert_eq!(place("", 0), (1, 1));
        assert_eq!(place("ab\ncd", 4), (2, 2));
        assert_eq!(place("ab\r\ncd", 4), (2, 1));
        assert_eq!(place("ab\rcd\r\r", 6), (3, 1));
        assert_eq!(place("ab\n", 99), (2, 1));
    }
}
