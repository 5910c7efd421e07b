//! Why a picture could not be read.

use std::io;
use std::path::{Path, PathBuf};

use ::image::ImageError;

use super::ImageFormat;
use crate::input::is_transient;
use crate::memory::OutOfMemory;
use crate::printable::{printable, printable_path};

/// A picture could not be read.
#[derive(Debug, thiserror::Error)]
#[error("cannot read {}: {problem}", named(path))]
pub struct ImageFileError {
    /// The file as the user named it.
    pub path: PathBuf,
    /// What failed.
    pub problem: ImageFileProblem,
}

fn named(path: &Path) -> String {
    if path == Path::new("-") {
        "standard input".to_owned()
    } else {
        printable_path(path)
    }
}

impl ImageFileError {
    pub(crate) fn new(path: &Path, problem: ImageFileProblem) -> Self {
        Self {
            path: path.to_path_buf(),
            problem,
        }
    }

    /// Whether another machine or a later try may do better: no memory, a failing disk.
    pub fn is_transient(&self) -> bool {
        match &self.problem {
            ImageFileProblem::Io(error) => is_transient(error),
            ImageFileProblem::NoMemory(_) => true,
            ImageFileProblem::Unknown
            | ImageFileProblem::NoLayers(..)
            | ImageFileProblem::Unsupported(_)
            | ImageFileProblem::Damaged(_)
            | ImageFileProblem::TooLarge(..) => false,
        }
    }
}

/// Why a picture could not be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageFileProblem {
    /// The system reports an error.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// None of the formats that are read.
    #[error("it is not an OpenEXR file, nor a PNG, JPEG, TIFF or Radiance HDR")]
    Unknown,
    /// Layers are asked for, by this option, which only OpenEXR has.
    #[error("it is a {}, which has no layers; leave {} away", .0.name(), .1)]
    NoLayers(ImageFormat, &'static str),
    /// Legal, but of a kind that is not read.
    #[error("{0}")]
    Unsupported(String),
    /// The file contradicts itself or ends too early.
    #[error("the file is damaged or incomplete ({0})")]
    Damaged(String),
    /// More pixels than a file of its length can hold.
    #[error("{0} × {1} pixels are too many for the data in it")]
    TooLarge(u32, u32),
    /// The system does not give the memory.
    #[error(transparent)]
    NoMemory(#[from] OutOfMemory),
}

/// What is said where a file stops before its end.
pub(super) const TOO_EARLY: &str = "it ends too early";

pub(super) fn damaged(reason: &str) -> ImageFileProblem {
    // Decoders quote what is in the file.
    ImageFileProblem::Damaged(printable(reason))
}

/// A kind of a format that is not read, and the way out.
pub(super) fn unsupported(format: ImageFormat, kind: &str) -> ImageFileProblem {
    ImageFileProblem::Unsupported(format!(
        "this kind of {} is not read ({}); convert it, as by `oiiotool in -d float -o out.exr`",
        format.name(),
        printable(kind)
    ))
}

/// What an error of reading means where the file is in memory, which reads without errors of its own.
pub(super) fn of_memory(error: &io::Error) -> ImageFileProblem {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => damaged(TOO_EARLY),
        _ => damaged(&error.to_string()),
    }
}

/// What an error of a decoder means.
pub(super) fn of_decoder(format: ImageFormat, error: ImageError) -> ImageFileProblem {
    match error {
        ImageError::IoError(error) => of_memory(&error),
        ImageError::Unsupported(error) => unsupported(format, &error.to_string()),
        ImageError::Limits(_) => damaged("it claims more memory than its pixels take"),
        ImageError::Decoding(error) => {
            let cause = std::error::Error::source(&error).map(ToString::to_string);
            damaged(&cause.unwrap_or_else(|| error.to_string()))
        }
        ImageError::Encoding(_) | ImageError::Parameter(_) => damaged(&error.to_string()),
    }
}

/// What is said of a file with an ICC profile.
pub(super) const PROFILE: &str = "its ICC profile is not applied: it is shown as sRGB; convert it to sRGB first if its colors are others";
