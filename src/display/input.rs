//! A picture that is to be shown: an OpenEXR file, or one of another format, by its first bytes.

use std::fs::File;
use std::io::{self, Read, Seek};
use std::ops::Range;
use std::path::Path;

use super::DisplayError;
use super::source::Source;
use crate::exr::ExrReader;
use crate::image::Window;
use crate::image_file::{
    ImageFile, ImageFileError, ImageFileProblem, ImageFormat, rest_of, start_of,
};
use crate::input::Hash;

/// A picture that is open.
#[derive(Debug)]
pub enum Input {
    /// An OpenEXR file, which is read row by row.
    Exr(Box<ExrReader>),
    /// Another format, decoded.
    Image(Box<ImageFile>),
}

impl<'s> From<&'s Input> for Source<'s> {
    fn from(input: &'s Input) -> Self {
        match input {
            Input::Exr(file) => Self::File(file),
            Input::Image(image) => Self::Decoded(image),
        }
    }
}

impl Input {
    /// Opens a file, a pipe or a device; `-` is standard input. Of OpenEXR, the layer of this name, as
    /// [`ExrReader::open`] has it.
    ///
    /// # Errors
    /// If it cannot be read, is none of the formats that are, or has no such layer.
    pub fn open(path: &Path, layer: Option<&str>) -> Result<Self, DisplayError> {
        if path == Path::new("-") {
            return Self::of_stream(path, &mut io::stdin().lock(), layer);
        }
        let system = |error: io::Error| ImageFileError::new(path, error.into());
        let mut file = File::open(path).map_err(system)?;
        let kind = file.metadata().map_err(system)?.file_type();
        if kind.is_dir() {
            return Err(system(io::ErrorKind::IsADirectory.into()).into());
        }
        if kind.is_file() && ExrReader::begins(&start_of(&mut file).map_err(system)?) {
            return Ok(Self::Exr(Box::new(ExrReader::open(path, layer)?)));
        }
        if kind.is_file() {
            file.rewind().map_err(system)?;
        }
        Self::of_stream(path, &mut file, layer)
    }

    fn of_stream(
        path: &Path,
        stream: &mut dyn Read,
        layer: Option<&str>,
    ) -> Result<Self, DisplayError> {
        let failed = |problem| DisplayError::from(ImageFileError::new(path, problem));
        let start = start_of(stream).map_err(|error| failed(error.into()))?;
        if ExrReader::begins(&start) {
            let mut whole = start.as_slice().chain(stream);
            let reader = ExrReader::from_stream(path, &mut whole, layer)?;
            return Ok(Self::Exr(Box::new(reader)));
        }
        // Before the rest is read: what is none of them may have no end, as /dev/zero.
        let format = ImageFormat::of(&start).ok_or_else(|| failed(ImageFileProblem::Unknown))?;
        if layer.is_some() {
            return Err(failed(ImageFileProblem::NoLayers(format)));
        }
        let bytes = rest_of(start, stream).map_err(failed)?;
        let image = ImageFile::decode(path, format, &bytes)?;
        Ok(Self::Image(Box::new(image)))
    }

    /// Width and height of what is shown.
    pub fn resolution(&self) -> [u32; 2] {
        Source::from(self).resolution()
    }

    /// The rows of its window, in groups that are well read together, from the top.
    pub fn bands(&self) -> Vec<Range<u32>> {
        Source::from(self).bands().collect()
    }

    /// Rows of its window, R, G, B, A as the file has them.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn rows(&self, rows: Range<u32>) -> Result<Vec<[f32; 4]>, DisplayError> {
        Ok(Source::from(self).rows(rows)?)
    }

    /// The part of the picture, from its top left, that there are pixels for.
    pub const fn window(&self) -> Option<Window> {
        match self {
            Self::Exr(file) => file.window(),
            Self::Image(image) => image.image.window,
        }
    }

    /// The hash of the file, or of what came through the pipe.
    pub(super) fn hash(&self) -> Result<Hash, DisplayError> {
        match self {
            Self::Exr(file) => Ok(file.hash()?),
            Self::Image(image) => Ok(image.hash()),
        }
    }

    /// The layer that was asked for.
    pub(super) fn layer(&self) -> Option<&str> {
        match self {
            Self::Exr(file) => file.layer(),
            Self::Image(_) => None,
        }
    }
}
