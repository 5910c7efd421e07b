//! Luminaire files as they are on disk, IES LM-63: bytes to a table to photometry.
//!
//! A file tells the luminous intensity of a luminaire in cd over vertical and horizontal angles. All
//! editions of the standard are read (1986, 1991, 1995, 2002, 2019), all types (C, B, A) and symmetries,
//! relative and absolute photometry. An intensity is what is written × multiplier × ballast factor ×
//! ballast-lamp factor × tilt factor at 0°; the last but one is none in LM-63-2019. The [coordinates] page says
//! which direction a pair of angles is.
//!
//! Many files are not as the standard has it. What they mean is read where it is clear, and each repair is
//! counted in [`IesRemarks`]; what is not clear is an [`IesError`] with its line and column, what was expected
//! and the way out. There is no panic on any input, and no memory is allocated on the word of a count in the
//! file: reading takes linear time, and at most fifty times the size of the file, which is limited to 16 MB.
//!
//! Rules are those of ANSI/IESNA LM-63-02, "Standard File Format for the Electronic Transfer of Photometric Data
//! and Related Information", and of its successor LM-63-19.

mod angles;
mod beam;
mod body;
pub mod coordinates;
mod error;
mod flux;
mod header;
mod limits;
mod numbers;
mod photometry;
mod remarks;
#[cfg(test)]
mod tests;
mod tilt;

use std::cell::RefCell;
use std::fmt::Display;
use std::io::Read;
use std::path::{Path, PathBuf};

pub use beam::{Peak, Widths};
pub use body::{Factors, Lamps, Opening};
pub use coordinates::{Angles, Coordinates};
pub use error::{Fault, IesError, Place};
pub use header::{Edition, Keyword};
pub use photometry::{Photometry, Symmetry};
pub use remarks::IesRemarks;
pub use tilt::{LampGeometry, Tilt, TiltFactors};

use body::Given;
use header::TiltLine;
use limits::LARGEST_FILE;
use numbers::{Commas, Numbers};

use crate::input::{self, Foreign, Hash};

/// A luminaire as its file has it.
#[derive(Clone, Debug, PartialEq)]
pub struct IesFile {
    /// The edition of LM-63 that it names.
    pub edition: Edition,
    /// Its keywords in the order of the file.
    pub keywords: Vec<Keyword>,
    /// Its lamps.
    pub lamps: Lamps,
    /// The factors that are in the intensities of `photometry`.
    pub factors: Factors,
    /// How the file came about, by the code of LM-63-2019.
    pub generation: Option<f64>,
    /// The size of the luminous opening; `None` where its unit is unknown.
    pub opening: Option<Opening>,
    /// Input power, in W.
    pub watts: f64,
    /// How tilting changes the light. The factor at 0° is applied, no other.
    pub tilt: Tilt,
    /// The intensities.
    pub photometry: Photometry,
    /// What was not taken as written.
    pub remarks: IesRemarks,
}

impl IesFile {
    /// Reads an IES file. A file of tilt factors that it names is looked for beside it.
    ///
    /// # Errors
    /// [`IesError`] for anything that is not a whole table of intensities with one above 0.
    pub fn load(path: &Path) -> Result<Self, IesError> {
        Self::load_hashed(path).map(|(file, _)| file)
    }

    /// [`IesFile::load`], and the hashes of what was read for it, a file of tilt factors after the file itself.
    pub(crate) fn load_hashed(path: &Path) -> Result<(Self, Vec<(PathBuf, Hash)>), IesError> {
        let bytes = contents(path)?;
        let files = RefCell::new(vec![(path.to_owned(), Hash::of(&bytes))]);
        let file = Self::parse_with(&bytes, |name| {
            let path = beside(path, name);
            let bytes = contents(&path)?;
            files.borrow_mut().push((path, Hash::of(&bytes)));
            Ok::<_, IesError>(bytes)
        })?;
        Ok((file, files.into_inner()))
    }

    /// Reads the bytes of an IES file. A file of tilt factors that it names is not applied.
    ///
    /// # Errors
    /// As [`IesFile::load`].
    pub fn parse(bytes: &[u8]) -> Result<Self, IesError> {
        Self::read(bytes, None::<fn(&str) -> Result<Vec<u8>, IesError>>)
    }

    /// Reads the bytes of an IES file; `tilt_file` gives those of the file of tilt factors of a name.
    ///
    /// # Errors
    /// As [`IesFile::load`].
    pub fn parse_with<E: Display>(
        bytes: &[u8],
        tilt_file: impl Fn(&str) -> Result<Vec<u8>, E>,
    ) -> Result<Self, IesError> {
        Self::read(bytes, Some(tilt_file))
    }

    /// The text of the first keyword of this name, in any case.
    pub fn keyword(&self, name: &str) -> Option<&str> {
        let mut keywords = self.keywords.iter();
        let found = keywords.find(|keyword| keyword.name.eq_ignore_ascii_case(name));
        found.map(|keyword| keyword.text.as_str())
    }

    /// The rated luminous flux of all lamps in lm; `None` for absolute photometry. What leaves the luminaire is less:
    /// [`Photometry::lumens`].
    pub fn rated_lumens(&self) -> Option<f64> {
        self.lamps.lumens.map(|lumens| lumens * self.lamps.count)
    }

    fn read<E: Display>(
        bytes: &[u8],
        tilt_file: Option<impl Fn(&str) -> Result<Vec<u8>, E>>,
    ) -> Result<Self, IesError> {
        let mut remarks = IesRemarks::default();
        let start = begin(bytes, &mut remarks)?;
        header::look_at_lines(bytes, &mut remarks);
        let header = header::read(bytes, start, &mut remarks);
        let header = header.map_err(|problem| problem.in_file(bytes, None))?;
        let mut tilt = Tilt::None;
        if let TiltLine::File(name, offset) = header.tilt {
            let name = String::from_utf8_lossy(name).into_owned();
            tilt = match tilt_file {
                Some(tilt_file) => {
                    let line = Place::of(bytes, offset).line;
                    Tilt::Factors(read_tilt(name, line, tilt_file, &mut remarks)?)
                }
                None => {
                    remarks.unread_tilt = true;
                    Tilt::File(name)
                }
            };
        }
        let given = Given {
            edition: header.edition,
            has_tilt: header.tilt == TiltLine::Include,
            tilt: match &tilt {
                Tilt::Factors(factors) => Some(factors),
                Tilt::None | Tilt::File(_) => None,
            },
        };
        let body = body::read(bytes, header.end, given, &remarks);
        let body = body.map_err(|problem| problem.in_file(bytes, None))?;
        Ok(Self {
            edition: header.edition,
            keywords: header.keywords,
            lamps: body.lamps,
            factors: body.factors,
            generation: body.generation,
            opening: body.opening,
            watts: body.watts,
            tilt: body.tilt.map_or(tilt, Tilt::Factors),
            photometry: body.photometry,
            remarks: body.remarks,
        })
    }
}

/// Where the text of a file starts.
fn begin(bytes: &[u8], remarks: &mut IesRemarks) -> Result<usize, IesError> {
    const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();
    if bytes.len() > LARGEST_FILE {
        return Err(IesError::TooLarge);
    }
    remarks.byte_order_mark = bytes.starts_with(BYTE_ORDER_MARK);
    let start = if remarks.byte_order_mark {
        BYTE_ORDER_MARK.len()
    } else {
        0
    };
    let text = bytes.get(start..).unwrap_or_default();
    if text.is_empty() {
        return Err(IesError::Empty);
    }
    match Foreign::of(text) {
        Some(found) => Err(IesError::Foreign { found }),
        None => Ok(start),
    }
}

/// The path of a file that another one names: beside it, whatever folder of another machine the name tells.
fn beside(path: &Path, name: &str) -> PathBuf {
    let name = name.rsplit(['/', '\\']).next().unwrap_or(name);
    path.with_file_name(name)
}

/// The bytes of a file, unless it is too large.
fn contents(path: &Path) -> Result<Vec<u8>, IesError> {
    let (file, size) = input::open::<IesError>(path)?;
    if size > LARGEST_FILE as u64 {
        return Err(IesError::TooLarge);
    }
    let mut bytes = Vec::new();
    bytes
        .try_reserve_exact(usize::try_from(size).unwrap_or(0))
        .map_err(|_| IesError::NoMemory)?;
    // It may have grown meanwhile.
    file.take(LARGEST_FILE as u64 + 1).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Reads a file of tilt factors. It is what stands behind `TILT=INCLUDE`.
fn read_tilt<E: Display>(
    name: String,
    line: usize,
    tilt_file: impl Fn(&str) -> Result<Vec<u8>, E>,
    remarks: &mut IesRemarks,
) -> Result<TiltFactors, IesError> {
    let bytes = match tilt_file(&name) {
        Ok(bytes) => bytes,
        Err(error) => {
            let why = error.to_string();
            return Err(IesError::TiltFile { line, name, why });
        }
    };
    let start = match begin(&bytes, &mut IesRemarks::default()) {
        Ok(start) => start,
        Err(error) => {
            let why = error.to_string();
            return Err(IesError::TiltFile { line, name, why });
        }
    };
    let mut numbers = Numbers::new(&bytes, start, Commas::Delimit);
    TiltFactors::read(&mut numbers, remarks).map_err(|problem| problem.in_file(&bytes, Some(&name)))
}
