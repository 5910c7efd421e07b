//! What can be wrong with a scene, where, and the way out.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::Source;
use super::mesh::MeshError;

/// A range of bytes in the scene file; empty at 0 for what has no place in it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Span {
    /// The first byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

/// A value with its place in the scene file.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spanned<T> {
    /// The value.
    pub value: T,
    /// Where it was written; for a default, the entry that leaves it out.
    pub span: Span,
}

impl<T> Spanned<T> {
    /// `value`, written at `span`.
    pub const fn new(value: T, span: Span) -> Self {
        Self { value, span }
    }
}

impl<T> From<T> for Spanned<T> {
    fn from(value: T) -> Self {
        Self::new(value, Span::default())
    }
}

impl From<std::ops::Range<usize>> for Span {
    fn from(range: std::ops::Range<usize>) -> Self {
        Self {
            start: range.start,
            end: range.end,
        }
    }
}

/// One thing that is wrong, and where.
#[derive(Debug)]
pub struct Diagnostic {
    /// The place in the scene file.
    pub span: Span,
    /// What is wrong there.
    pub problem: Problem,
}

/// Everything that is wrong with one scene; never empty.
///
/// Displayed as the lines of the file with carets under the places, one message each.
#[derive(Debug)]
pub struct Diagnostics {
    source: Arc<Source>,
    list: Vec<Diagnostic>,
}

/// What is wrong. Each message says what was expected.
#[derive(Debug, thiserror::Error)]
pub enum Problem {
    /// The scene file itself cannot be read.
    #[error("cannot read the scene file: {0}")]
    Unreadable(std::io::Error),
    /// Not TOML.
    #[error("{0}")]
    Syntax(String),
    /// A key, section, variant or name that does not exist.
    #[error("unknown {what} `{name}`")]
    Unknown {
        /// The kind of name: `key`, `section`, `light`, `material`, …
        what: &'static str,
        /// As written.
        name: String,
        /// What could stand there.
        expected: Vec<String>,
        /// The nearest of these, if one is near.
        nearest: Option<String>,
    },
    /// A key or section that must be there.
    #[error("missing {what} `{name}`")]
    Missing {
        /// The kind of name: `key`, `section`, …
        what: &'static str,
        /// What must be there.
        name: String,
        /// What it would hold, with an example.
        expected: &'static str,
    },
    /// A value of another type.
    #[error("`{key}` is {found}, expected {expected}")]
    WrongType {
        /// The key.
        key: String,
        /// What was written: `a string`, `an array of 2`, …
        found: String,
        /// What is expected, with an example.
        expected: &'static str,
    },
    /// A number outside its range.
    #[error("`{key}` is {value}, expected {expected}")]
    OutOfRange {
        /// The key.
        key: &'static str,
        /// As understood.
        value: String,
        /// The range with its unit.
        expected: String,
    },
    /// Two entries of one name or a second camera.
    #[error("{what} `{name}` is there twice")]
    Duplicate {
        /// The kind of entry.
        what: &'static str,
        /// Its name.
        name: String,
    },
    /// Legal, but not rendered by this version.
    #[error("{what} is not supported yet; {instead}")]
    NotYet {
        /// What was asked for.
        what: String,
        /// What can be written today.
        instead: &'static str,
    },
    /// A mesh file that cannot be used.
    #[error("cannot use the mesh file {}: {error}", path.display())]
    Mesh {
        /// The file, joined to the scene's folder.
        path: PathBuf,
        /// Why.
        error: MeshError,
    },
    /// Values that do not fit together, such as an `up` along the view.
    #[error("{0}")]
    Conflict(String),
}

impl Diagnostics {
    /// The diagnostics of one scene, in the order of their places; `None` where there are none.
    pub fn new(source: Arc<Source>, mut list: Vec<Diagnostic>) -> Option<Self> {
        if list.is_empty() {
            return None;
        }
        list.sort_by_key(|diagnostic| diagnostic.span);
        Some(Self { source, list })
    }

    /// The single items, in the order of their places.
    pub fn list(&self) -> &[Diagnostic] {
        &self.list
    }

    /// The scene file's path.
    pub fn path(&self) -> &Path {
        &self.source.path
    }

    /// These and `others`, of the same scene, together.
    pub fn and(self, others: Option<Self>) -> Self {
        let mut list = self.list;
        list.extend(others.into_iter().flat_map(|others| others.list));
        list.sort_by_key(|diagnostic| diagnostic.span);
        Self {
            source: self.source,
            list,
        }
    }
}

impl std::error::Error for Diagnostics {}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for diagnostic in &self.list {
            writeln!(f, "{}: {}", self.source.path.display(), diagnostic.problem)?;
        }
        Ok(())
    }
}

/// nearest
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    candidates.into_iter().find(|c| strsim::jaro(name, c) > 0.8)
}
