//! All layers of a file by their names, to show one after the other.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::header::Headers;
use super::layers::{self, Layer};
use super::source::Source;
use super::{ExrError, ExrProblem, ExrReader};

/// An OpenEXR file that is open, with the layers that can be shown: colors and vectors, then single channels.
#[derive(Debug)]
pub struct ExrLayers {
    path: PathBuf,
    source: Arc<Source>,
    headers: Headers,
    list: Vec<Layer>,
}

impl ExrLayers {
    /// Opens a file, or a pipe or device, which is read into memory. `-` is standard input.
    ///
    /// # Errors
    /// See [`ExrProblem`].
    pub fn open(path: &Path) -> Result<Self, ExrError> {
        Self::of_source(path, Source::open(path))
    }

    /// As [`ExrLayers::open`], for a file that comes through a stream; `path` names it in messages.
    ///
    /// # Errors
    /// See [`ExrProblem`].
    pub fn from_stream(path: &Path, stream: &mut dyn Read) -> Result<Self, ExrError> {
        Self::of_source(path, Source::of_stream(stream))
    }

    fn of_source(path: &Path, source: Result<Source, ExrProblem>) -> Result<Self, ExrError> {
        let opened = source.and_then(|source| {
            let headers = Headers::read(&source)?;
            Ok(Self {
                path: path.to_path_buf(),
                source: Arc::new(source),
                list: layers::list(&headers),
                headers,
            })
        });
        opened.map_err(|problem| ExrError {
            path: path.to_path_buf(),
            problem,
        })
    }

    /// The names in order; an empty one is of what belongs to no layer.
    pub fn names(&self) -> impl ExactSizeIterator<Item = &str> {
        self.list.iter().map(|layer| layer.name.as_str())
    }

    /// The layer with this number.
    ///
    /// # Errors
    /// See [`ExrProblem`].
    ///
    /// # Panics
    /// If there are not so many.
    pub fn reader(&self, number: usize) -> Result<ExrReader, ExrError> {
        let shown = self.list[number].shown;
        let source = Arc::clone(&self.source);
        let opened = ExrReader::new(&self.path, source, &self.headers, shown);
        opened.map_err(|problem: ExrProblem| ExrError {
            path: self.path.clone(),
            problem,
        })
    }
}
