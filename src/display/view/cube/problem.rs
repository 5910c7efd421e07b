//! Why a `.cube` file could not be read: where, what was expected, and the way out.

use std::io;
use std::path::PathBuf;

use super::keywords::{KEYWORDS, LONGEST_FILE, LONGEST_LINE};
use crate::input::{self, Foreign, NotAFile};
use crate::memory::OutOfMemory;
use crate::printable::printable_path;

/// A `.cube` file could not be read.
#[derive(Debug, thiserror::Error)]
#[error("cannot read {}{problem}", printable_path(path))]
pub struct CubeError {
    /// The file as the user named it.
    pub path: PathBuf,
    /// What failed.
    pub problem: CubeProblem,
}

impl CubeError {
    /// Whether another machine or a later try may do better: no memory, a failing disk.
    pub fn is_transient(&self) -> bool {
        match &self.problem {
            CubeProblem::Io(error) => input::is_transient(error),
            CubeProblem::NoMemory(_) => true,
            CubeProblem::NotAFile(_)
            | CubeProblem::TooLarge { .. }
            | CubeProblem::Foreign { .. }
            | CubeProblem::Line { .. }
            | CubeProblem::NoSize
            | CubeProblem::Missing { .. } => false,
        }
    }
}

/// Why a `.cube` file could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CubeProblem {
    /// The system reports an error.
    #[error(": {0}")]
    Io(#[from] io::Error),
    /// A folder, a device, a pipe.
    #[error(": {0}")]
    NotAFile(#[from] NotAFile),
    /// More than any table takes.
    #[error(
        ": it has {:.1} GB, and a .cube file has at most {:.1} GB",
        *.bytes as f64 / 1e9,
        LONGEST_FILE as f64 / 1e9
    )]
    TooLarge {
        /// The file's length.
        bytes: u64,
    },
    /// The right text, maybe, in a form that is not read.
    #[error(": it is {found}; {}", found.way_out())]
    Foreign {
        /// What it is.
        found: Foreign,
    },
    /// Something is wrong in a line.
    #[error(", line {line}: {fault}")]
    Line {
        /// The line, from 1 on.
        line: u64,
        /// What is wrong.
        fault: CubeFault,
    },
    /// No table is announced.
    #[error(": it has no LUT_1D_SIZE and no LUT_3D_SIZE; is it a .cube file?")]
    NoSize,
    /// The file ends too early.
    #[error(": it ends after {found} of the {expected} lines of numbers that its size asks for")]
    Missing {
        /// Lines that the sizes ask for.
        expected: u64,
        /// Lines that are there.
        found: u64,
    },
    /// The system does not give the memory.
    #[error(": {0}")]
    NoMemory(#[from] OutOfMemory),
}

/// What is wrong in a line of a `.cube` file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CubeFault {
    /// Bytes that are no text.
    #[error("expected text in UTF-8; is it a .cube file?")]
    NotUtf8,
    /// More bytes than lines of text have.
    #[error("it is longer than {LONGEST_LINE} bytes; is it a .cube file?")]
    Long,
    /// Not the numbers that belong there.
    #[error("expected {expected}, found `{found}`")]
    Numbers {
        /// How many of what.
        expected: &'static str,
        /// The line, printable.
        found: String,
    },
    /// Infinite, not a number, or beyond ±3.4e38.
    #[error("expected finite numbers, found `{0}`")]
    NotFinite(String),
    /// A word that is no keyword.
    #[error("expected three numbers or one of {}, found `{found}`", KEYWORDS.join(", "))]
    Keyword {
        /// The word, printable.
        found: String,
    },
    /// The table is for code values of video levels.
    #[error(
        "{0} asks for video levels, which are not read; export the table for full range (data levels)"
    )]
    VideoLevels(&'static str),
    /// A table of no such size.
    #[error("{keyword} is from 2 to {most}, found {found}")]
    Size {
        /// Which table.
        keyword: &'static str,
        /// The most entries along an axis.
        most: u64,
        /// What is there, printable.
        found: String,
    },
    /// A table that the file is too short for.
    #[error("a table of {entries} entries takes {least} bytes at least, and the file has {bytes}")]
    Short {
        /// R, G, B of so many places.
        entries: u64,
        /// What they take, at least.
        least: u64,
        /// What there is.
        bytes: u64,
    },
    /// Said before.
    #[error("{0} is there twice")]
    Twice(&'static str),
    /// Two names for the same range.
    #[error("{0} contradicts {1}, which is there as well; remove one of them")]
    Beside(&'static str, &'static str),
    /// A range of one of two tables.
    #[error(
        "{0} does not say which of the two tables it is about; write LUT_1D_INPUT_RANGE and LUT_3D_INPUT_RANGE instead"
    )]
    Ambiguous(&'static str),
    /// A range without length.
    #[error("the domain's end must be above its start, found {least} to {most}")]
    Domain {
        /// Where it starts.
        least: f64,
        /// Where it ends.
        most: f64,
    },
    /// A range of a table that is not there.
    #[error("{0} is about a table that is not there")]
    NoTable(&'static str),
    /// Numbers before the size of the table.
    #[error("numbers before LUT_1D_SIZE or LUT_3D_SIZE")]
    BeforeSize,
    /// A keyword after the first numbers.
    #[error("{0} after the first line of numbers; keywords come before")]
    Late(&'static str),
    /// More numbers than the table takes.
    #[error("more lines of numbers than the {0} that its size asks for")]
    Surplus(u64),
}
