//! A picture that is to be shown: an OpenEXR file, or one of another format, by its first bytes.

use std::fs::File;
use std::io::{self, Cursor, Read, Seek};
use std::ops::Range;
use std::path::Path;

use super::DisplayError;
use super::source::Source;
use crate::exr::{ExrLayers, ExrReader};
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

impl From<ExrReader> for Input {
    fn from(reader: ExrReader) -> Self {
        Self::Exr(Box::new(reader))
    }
}

fn no_layers(path: &Path, format: ImageFormat, option: &'static str) -> DisplayError {
    ImageFileError::new(path, ImageFileProblem::NoLayers(format, option)).into()
}

/// A picture of which the first bytes are read, and what it is by them.
enum Begun {
    /// An OpenEXR file that can be read in any order.
    ExrFile,
    /// An OpenEXR file as it comes.
    ExrStream(Box<dyn Read>),
    /// Another format; its first bytes, and the rest.
    Image(ImageFormat, Vec<u8>, Box<dyn Read>),
}

impl Begun {
    fn open(path: &Path) -> Result<Self, ImageFileError> {
        let system = |error: io::Error| ImageFileError::new(path, error.into());
        if path == Path::new("-") {
            return Self::of_stream(path, Box::new(io::stdin()));
        }
        let mut file = File::open(path).map_err(system)?;
        let kind = file.metadata().map_err(system)?.file_type();
        if kind.is_dir() {
            return Err(system(io::ErrorKind::IsADirectory.into()));
        }
        if kind.is_file() {
            if ExrReader::begins(&start_of(&mut file).map_err(system)?) {
                return Ok(Self::ExrFile);
            }
            file.rewind().map_err(system)?;
        }
        Self::of_stream(path, Box::new(file))
    }

    fn of_stream(path: &Path, mut stream: Box<dyn Read>) -> Result<Self, ImageFileError> {
        let start =
            start_of(&mut stream).map_err(|error| ImageFileError::new(path, error.into()))?;
        if ExrReader::begins(&start) {
            return Ok(Self::ExrStream(Box::new(Cursor::new(start).chain(stream))));
        }
        // Before the rest is read: what is none of them may have no end, as /dev/zero.
        match ImageFormat::of(&start) {
            Some(format) => Ok(Self::Image(format, start, stream)),
            None => Err(ImageFileError::new(path, ImageFileProblem::Unknown)),
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
        match Begun::open(path)? {
            Begun::ExrFile => Ok(ExrReader::open(path, layer)?.into()),
            Begun::ExrStream(mut stream) => {
                Ok(ExrReader::from_stream(path, &mut stream, layer)?.into())
            }
            Begun::Image(format, ..) if layer.is_some() => Err(no_layers(path, format, "--layer")),
            Begun::Image(format, start, mut stream) => {
                let bytes = rest_of(start, &mut stream);
                let bytes = bytes.map_err(|problem| ImageFileError::new(path, problem))?;
                let image = ImageFile::decode(path, format, &bytes)?;
                Ok(Self::Image(Box::new(image)))
            }
        }
    }

    /// As [`Input::open`], of a layer of numbers: where it has no A of its own, it has that of its part's picture.
    ///
    /// # Errors
    /// If it cannot be read, is not OpenEXR, or has no such layer.
    pub fn open_covered(path: &Path, layer: &str) -> Result<Self, DisplayError> {
        match Begun::open(path)? {
            Begun::ExrFile => Ok(ExrReader::open_covered(path, layer)?.into()),
            Begun::ExrStream(mut stream) => {
                Ok(ExrReader::covered_from_stream(path, &mut stream, layer)?.into())
            }
            Begun::Image(format, ..) => Err(no_layers(path, format, "--unit lx")),
        }
    }

    /// The layers of a file, a pipe or a device; `-` is standard input.
    ///
    /// # Errors
    /// If it cannot be read, or is not OpenEXR, the only format that has layers.
    pub fn layers(path: &Path) -> Result<ExrLayers, DisplayError> {
        match Begun::open(path)? {
            Begun::ExrFile => Ok(ExrLayers::open(path)?),
            Begun::ExrStream(mut stream) => Ok(ExrLayers::from_stream(path, &mut stream)?),
            Begun::Image(format, ..) => Err(no_layers(path, format, "--layers")),
        }
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

    /// How much wider than high a pixel is.
    pub fn pixel_aspect(&self) -> f32 {
        Source::from(self).pixel_aspect()
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
