//! Why a mesh file cannot be used, and where in it.

use std::collections::TryReserveError;
use std::fmt;

use super::remarks::MeshRemarks;
use crate::input::{Foreign, NotAFile, is_transient};
use crate::printable::{excerpt, printable};

/// Why a mesh file cannot be used. The message says where in the file and what was expected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// The file cannot be read.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// A directory, a device, a pipe.
    #[error("{0}, expected a PLY or OBJ file")]
    NotAFile(#[from] NotAFile),
    /// There is not enough memory for it.
    #[error("there is not enough memory to read the mesh")]
    NoMemory,
    /// It was another file when it was looked at again.
    #[error("the file changed while it was read")]
    Changed,
    /// No bytes at all.
    #[error("the file is empty, expected a PLY or OBJ mesh")]
    Empty,
    /// Text of an encoding that is not read, or a compressed file.
    #[error("it is {found}, expected a PLY or OBJ mesh in ASCII or UTF-8; {}", .found.way_out())]
    Foreign {
        /// What it is instead.
        found: Foreign,
    },
    /// Neither the first bytes nor the name are those of a format that is read.
    #[error(
        "unknown mesh format, expected PLY (first line `ply`) or OBJ (a name that ends in `.obj`)"
    )]
    UnknownFormat,
    /// Vertices alone, or nothing but comments.
    #[error(
        "the mesh has no faces, expected at least one triangle or polygon{}",
        Instead(remarks)
    )]
    NoFaces {
        /// What is there instead, as far as it was counted.
        remarks: Box<MeshRemarks>,
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

impl MeshError {
    /// Whether another machine, or another try, may have more luck with the same file: memory was
    /// short, reading failed, or the file changed meanwhile.
    pub fn is_transient(&self) -> bool {
        match self {
            Self::Io(error) => is_transient(error),
            Self::NoMemory | Self::Changed => true,
            Self::NotAFile(_)
            | Self::Empty
            | Self::Foreign { .. }
            | Self::UnknownFormat
            | Self::NoFaces { .. }
            | Self::Invalid { .. } => false,
        }
    }
}

impl From<TryReserveError> for MeshError {
    fn from(_: TryReserveError) -> Self {
        Self::NoMemory
    }
}

/// What was skipped of a mesh without faces, as a message goes on with it.
struct Instead<'a>(&'a MeshRemarks);

impl fmt::Display for Instead<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.list().as_slice() {
            [] => Ok(()),
            list => write!(f, "; it has {}", list.join("; ")),
        }
    }
}

/// A place in a mesh file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// The line or byte.
    pub position: Position,
    /// The element of a PLY file that it is in.
    pub element: Option<ElementPlace>,
}

/// A line of text, or a byte of binary data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Position {
    /// A line, the first one 1.
    Line(usize),
    /// A byte, the first one 0.
    Byte(usize),
}

/// An element of a PLY file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ElementPlace {
    /// The kind of element: `vertex`, `face`, …
    pub name: String,
    /// Its number, the first one 0, as PLY counts.
    pub index: u64,
    /// How many the header announces.
    pub count: u64,
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
    /// A line that is too short.
    #[error("the line ends, expected {expected}")]
    LineEnds {
        /// What is missing.
        expected: &'static str,
    },
    /// A file that is too short.
    #[error("the file ends, expected {expected}; it is cut off, or its header counts too many")]
    FileEnds {
        /// What is missing.
        expected: &'static str,
    },
    /// A coordinate that is infinite or not a number.
    #[error("coordinate {axis} is {value}, expected a finite number")]
    NotFinite {
        /// `x`, `y` or `z`.
        axis: char,
        /// As understood.
        value: f64,
    },
    /// An index that names no vertex.
    #[error("{what} {index} does not exist, expected {}", Indices { first: *first, count: *count })]
    NoSuchIndex {
        /// `vertex`
        what: &'static str,
        /// As written.
        index: i64,
        /// The smallest index of the format: 0 in PLY, 1 in OBJ.
        first: u8,
        /// How many there are, for a negative index up to this place.
        count: usize,
    },
    /// A face too large to be cut into triangles.
    #[error(
        "a face of {corners} corners, expected at most {most}; cut it into triangles in the program it comes from",
        most = super::limits::MAX_CORNERS
    )]
    TooManyCorners {
        /// How many it has at least.
        corners: i64,
    },
    /// Concave faces that would take too long to cut.
    #[error(
        "the concave faces up to this one are too intricate; cut them into triangles in the program they come from"
    )]
    TooIntricate,
    /// There is not enough memory; it becomes [`MeshError::NoMemory`].
    #[error("there is not enough memory to read the mesh")]
    NoMemory,
    /// A header without an end.
    #[error(
        "a header of more than {megabytes} MB, expected `end_header` before",
        megabytes = super::limits::LONGEST_HEADER >> 20
    )]
    LongHeader,
    /// A count that no 32-bit index reaches.
    #[error("more than {} {what}, expected fewer", u32::MAX)]
    TooMany {
        /// `vertices`, `triangles`, …
        what: &'static str,
    },
    /// Corners so short that the mesh would outgrow its file without bound.
    #[error(
        "the mesh takes more than {times} times the memory of its file from here on; cut its polygons into triangles in the program it comes from",
        times = super::limits::TIMES_FILE_SIZE
    )]
    TooLarge,
    /// A part of the header that must be there.
    #[error("the header has no {what}, expected {expected}")]
    Missing {
        /// What is missing.
        what: &'static str,
        /// How it is written.
        expected: &'static str,
    },
    /// A name of the header that is there twice.
    #[error("{what} `{}` is there twice", printable(name))]
    Duplicate {
        /// `element` or `property`.
        what: &'static str,
        /// Its name.
        name: String,
    },
    /// Legal, but not read.
    #[error("{what} are not supported; {instead}")]
    Unsupported {
        /// What was found.
        what: &'static str,
        /// The way out.
        instead: &'static str,
    },
}

/// The indices that exist, as a message says them.
struct Indices {
    first: u8,
    count: usize,
}

impl fmt::Display for Indices {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.count, self.first) {
            (0, _) => f.write_str("one of the file's, which has none there"),
            (count, 0) => write!(f, "0 to {}", count - 1),
            (count, _) => write!(f, "1 to {count}, or -{count} to -1 counted backwards"),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(ElementPlace { name, index, count }) = &self.element {
            let name = printable(name);
            write!(f, "{name} {index} of {count} at ")?;
        }
        match self.position {
            Position::Line(line) => write!(f, "line {line}"),
            Position::Byte(byte) => write!(f, "byte {byte}"),
        }
    }
}

impl Fault {
    /// `found` instead of `expected`, [as it can be shown](excerpt).
    #[cold]
    pub(super) fn unexpected(found: &[u8], expected: &'static str) -> Box<Self> {
        Box::new(Self::Unexpected {
            found: excerpt(found),
            expected,
        })
    }

    /// This fault at a line, the first one 1.
    pub(super) fn at_line(self, line: usize) -> MeshError {
        self.at(Position::Line(line), None)
    }

    /// This fault at a position, in an element.
    pub(super) fn at(self, position: Position, element: Option<ElementPlace>) -> MeshError {
        if self == Self::NoMemory {
            return MeshError::NoMemory;
        }
        MeshError::Invalid {
            place: Place { position, element },
            fault: self,
        }
    }
}
