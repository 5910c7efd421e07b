//! What can be wrong with a scene, where, and the way out.

mod render;

use std::borrow::Cow;
use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::Source;
use super::curve::CurveError;
use crate::ies::IesError;
use crate::input::{NotAFile, is_transient};
use crate::memory::OutOfMemory;
use crate::mesh::MeshError;
use crate::printable::{QUOTED_LENGTH, printable, printable_path, shortened};

/// A range of bytes in the scene file; empty at 0 for what has no place in it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
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
    /// The entry that it is about, as people name it: "object `ball`", "the camera". Shown where
    /// there is no place to show, as in a scene made in code.
    pub entry: Option<String>,
    /// What is wrong there.
    pub problem: Problem,
    /// In a scene that moves, the frame at which it is.
    pub frame: Option<f64>,
}

/// Everything that is wrong with one scene; never empty.
///
/// Displayed as the lines of the file with carets under the places, one message each; see
/// [`Diagnostics::render`].
#[derive(Debug)]
pub struct Diagnostics {
    source: Arc<Source>,
    list: Vec<Diagnostic>,
}

/// What is wrong. Each message says what was expected.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The scene file itself cannot be read.
    #[error("cannot read the scene file: {0}")]
    Unreadable(io::Error),
    /// A file that the scene includes cannot be read.
    #[error("cannot read the included file {}: {error}", printable_path(path))]
    Included {
        /// The file, joined to the folder of the one that includes it.
        path: PathBuf,
        /// Why.
        error: IncludeError,
    },
    /// More text than a scene may have.
    #[error("the scene file is larger than {limit} MB")]
    TooLarge {
        /// The limit in MB (10⁶ bytes).
        limit: u64,
    },
    /// Not text.
    #[error("the byte 0x{byte:02X} is not UTF-8 text")]
    NotUtf8 {
        /// The first byte that cannot stand where it is.
        byte: u8,
    },
    /// A file of another kind.
    #[error("this is {what}, not a scene")]
    NotAScene {
        /// What it is, with its article.
        what: &'static str,
        /// What to do with it.
        way_out: &'static str,
    },
    /// Nothing but comments and blank lines.
    #[error("the scene file is empty")]
    Empty,
    /// Not TOML.
    #[error("{0}")]
    Syntax(String),
    /// A key, section, variant or name that does not exist. See [`Problem::unknown`].
    #[error("unknown {what} `{}`", shortened(name))]
    Unknown {
        /// The kind of name: `key`, `section`, `material`, `kind of light`, …
        what: &'static str,
        /// As written.
        name: String,
        /// What could stand there.
        expected: Vec<String>,
        /// The nearest of these, if one is near.
        nearest: Option<String>,
    },
    /// What other formats, or equations, call a key or a kind that is there under another name.
    #[error("unknown {what} `{}`", shortened(name))]
    OtherWord {
        /// The kind of name: `key`, `kind of object`, …
        what: &'static str,
        /// As written.
        name: String,
        /// Its name here.
        meant: &'static str,
    },
    /// A name for something that is said in another way, or not at all.
    #[error("unknown {what} `{}`", shortened(name))]
    Elsewhere {
        /// The kind of name: `key`, `kind of object`, …
        what: &'static str,
        /// As written.
        name: String,
        /// The key that says it, if one does.
        key: Option<&'static str>,
        /// The way out.
        advice: Cow<'static, str>,
    },
    /// A name that cannot be used.
    #[error("{} cannot be the name of {what}: {why}", quoted(name))]
    BadName {
        /// The kind of entry with its article: `an object`, …
        what: &'static str,
        /// As written.
        name: String,
        /// What names may be, or what to write instead.
        why: Cow<'static, str>,
    },
    /// An entry that does not say of which kind it is: `[objects.ball]` alone.
    #[error("{what} `{}` does not say of which kind it is", shortened(name))]
    NoVariant {
        /// The kind of entry: `object`, `camera`, …
        what: &'static str,
        /// Its name.
        name: String,
        /// The headers that could stand there: `[objects.ball.sphere]`, …
        expected: Vec<String>,
    },
    /// A key or section that must be there.
    #[error("missing {what} `{name}`")]
    Missing {
        /// The kind of name: `key`, `section`, …
        what: &'static str,
        /// What must be there.
        name: String,
        /// What it would hold, with an example; follows the word "add".
        expected: &'static str,
    },
    /// A value of another type.
    #[error("`{}` is {found}, expected {expected}", shortened(key))]
    WrongType {
        /// The key.
        key: String,
        /// What was written: `a string`, `an array of 2`, …
        found: String,
        /// What is expected, with an example.
        expected: &'static str,
    },
    /// A number outside its range.
    #[error("`{key}` is {}, expected {expected}", shortened(value))]
    OutOfRange {
        /// The key.
        key: &'static str,
        /// As understood.
        value: String,
        /// The range with its unit.
        expected: String,
    },
    /// Two entries of one name or a second camera.
    #[error("{what} `{}` is there twice", shortened(name))]
    Duplicate {
        /// The kind of entry.
        what: &'static str,
        /// Its name.
        name: String,
        /// Where the first one is, if that is known.
        first: Option<Span>,
    },
    /// A mesh file that cannot be used.
    #[error("cannot use the mesh file {}: {error}", printable_path(path))]
    Mesh {
        /// The file, joined to the scene's folder.
        path: PathBuf,
        /// Why.
        error: Box<MeshError>,
    },
    /// An IES file that cannot be used.
    #[error("cannot use the IES file {}: {error}", printable_path(path))]
    Ies {
        /// The file, joined to the scene's folder.
        path: PathBuf,
        /// Why.
        error: Box<IesError>,
    },
    /// A curve file that cannot be used.
    #[error("cannot use the curve file {}: {error}", printable_path(path))]
    Curve {
        /// The file, joined to the scene's folder.
        path: PathBuf,
        /// Why.
        error: Box<CurveError>,
    },
    /// Values that do not fit together, such as an `up` along the view.
    #[error("{0}")]
    Conflict(String),
    /// There is not enough memory.
    #[error("{error}{way_out}")]
    OutOfMemory {
        /// What it was for, and how much it was.
        error: OutOfMemory,
        /// What takes less, after a semicolon; empty where nothing does.
        way_out: &'static str,
    },
}

/// Why a file that a scene includes cannot be read.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum IncludeError {
    /// The system reports an error.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// A folder, a device or a pipe.
    #[error("{0}")]
    NotAFile(#[from] NotAFile),
    /// Not text.
    #[error("it is no text; save it as UTF-8")]
    NotUtf8,
    /// Too much text, together with the scene file and what it includes already.
    #[error("with it the scene has more than {limit} MB of text; expected at most that")]
    TooLarge {
        /// In MB.
        limit: u64,
    },
}

/// How many errors of one scene are collected; an entry in error after these is still left out.
pub(crate) const MOST_COLLECTED: usize = 1_000;

/// How many of the possible names an error keeps; a scene can have a million materials.
const EXPECTED_KEPT: usize = 12;

/// How many names are compared with a misspelt one: enough for any scene written by hand.
const NAMES_COMPARED: usize = 1_000;

impl Problem {
    /// An unknown `name` where one of `candidates` could stand, with the nearest of them.
    pub fn unknown<'a>(
        what: &'static str,
        name: &str,
        candidates: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let candidates: Vec<&str> = candidates.into_iter().take(NAMES_COMPARED).collect();
        Self::Unknown {
            what,
            name: name.to_owned(),
            nearest: nearest(name, candidates.iter().copied()).map(str::to_owned),
            expected: candidates
                .into_iter()
                .take(EXPECTED_KEPT)
                .map(str::to_owned)
                .collect(),
        }
    }

    /// The name that an unknown one was meant to be, as far as one can tell.
    pub fn nearest(&self) -> Option<&str> {
        if let Self::Unknown { nearest, .. } = self {
            nearest.as_deref()
        } else if let Self::OtherWord { meant, .. } = self {
            Some(meant)
        } else if let Self::Elsewhere { key, .. } = self {
            *key
        } else {
            None
        }
    }

    /// Whether a later try or another machine may cure it: there is not enough memory, or an input
    /// cannot be read to its end. What is not there, must not be read or is no file is most often
    /// misspelt, and stays so.
    pub fn is_transient(&self) -> bool {
        match self {
            Self::OutOfMemory { .. } => true,
            Self::Unreadable(error)
            | Self::Included {
                error: IncludeError::Io(error),
                ..
            } => is_transient(error),
            Self::Included {
                error:
                    IncludeError::NotAFile(_) | IncludeError::NotUtf8 | IncludeError::TooLarge { .. },
                ..
            } => false,
            Self::Mesh { error, .. } => error.is_transient(),
            Self::Ies { error, .. } => error.is_transient(),
            Self::Curve { error, .. } => error.is_transient(),
            Self::TooLarge { .. }
            | Self::NotUtf8 { .. }
            | Self::NotAScene { .. }
            | Self::Empty
            | Self::Syntax(_)
            | Self::OtherWord { .. }
            | Self::Elsewhere { .. }
            | Self::Unknown { .. }
            | Self::BadName { .. }
            | Self::NoVariant { .. }
            | Self::Missing { .. }
            | Self::WrongType { .. }
            | Self::OutOfRange { .. }
            | Self::Duplicate { .. }
            | Self::Conflict(_) => false,
        }
    }

    /// What stands under the caret, if anything.
    fn label(&self) -> Option<String> {
        if let Self::OtherWord { meant, .. } = self {
            return Some(format!("write `{meant}`"));
        }
        if let Self::Unknown { nearest, .. } = self {
            let nearest = nearest.as_ref()?;
            return Some(format!("did you mean `{}`?", printable(nearest)));
        }
        None
    }

    /// The way out, where the message itself does not name it.
    fn help(&self) -> Option<String> {
        match self {
            Self::Unreadable(error) if error.kind() == io::ErrorKind::NotFound => {
                Some("without a scene file, `candela render` renders the built-in scene".to_owned())
            }
            Self::TooLarge { .. } => Some(
                "put triangles into a mesh file and name it in `[objects.NAME.mesh]`".to_owned(),
            ),
            Self::NotUtf8 { .. } => Some("save the file as UTF-8".to_owned()),
            Self::Empty => Some(
                "a scene needs `[image]` with its `resolution`, a camera such as \
                 `[camera.perspective]`,\nand at least one material, light and object;\n\
                 without a scene file, `candela render` renders the built-in scene"
                    .to_owned(),
            ),
            Self::Unknown { what, expected, .. } => Some(if expected.is_empty() {
                format!("there is no {what} in this scene")
            } else {
                format!("expected {}", one_of(expected))
            }),
            Self::NotAScene { way_out, .. } => Some((*way_out).to_owned()),
            Self::Elsewhere { advice, .. } => Some(advice.clone().into_owned()),
            Self::NoVariant { expected, .. } => Some(format!("write {}", one_of(expected))),
            Self::Missing { expected, .. } => Some(format!("add {expected}")),
            Self::Unreadable(_)
            | Self::Included { .. }
            | Self::Syntax(_)
            | Self::OtherWord { .. }
            | Self::BadName { .. }
            | Self::WrongType { .. }
            | Self::OutOfRange { .. }
            | Self::Duplicate { .. }
            | Self::Mesh { .. }
            | Self::Ies { .. }
            | Self::Curve { .. }
            | Self::Conflict(_)
            | Self::OutOfMemory { .. } => None,
        }
    }
}

/// The candidate that `name` is most likely a misspelling of.
///
/// Damerau–Levenshtein distance, at most a third of the longer of the two; a difference in case
/// or in `-` and `_` alone is always near. The first of equally near ones.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    if name.is_empty() || name.len() > QUOTED_LENGTH {
        return None;
    }
    let folded = |text: &str| text.to_lowercase().replace(['-', ' '], "_");
    let wanted = folded(name);
    candidates
        .into_iter()
        .filter_map(|candidate| {
            let longest = candidate.chars().count().max(name.chars().count());
            let allowed = (longest / 3).max(1);
            if candidate.len().abs_diff(name.len()) > 4 * allowed {
                return None;
            }
            let distance = strsim::damerau_levenshtein(&wanted, &folded(candidate));
            (distance <= allowed && distance < longest).then_some((distance, candidate))
        })
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

/// `name` in backquotes, or what it is where there is nothing to quote.
fn quoted(name: &str) -> String {
    if name.is_empty() {
        "an empty string".to_owned()
    } else {
        format!("`{}`", shortened(name))
    }
}

/// `a`, `a or b`, `one of a, b, c`, each in backquotes.
fn one_of(names: &[String]) -> String {
    let quoted: Vec<String> = names
        .iter()
        .map(|name| format!("`{}`", shortened(name)))
        .collect();
    match quoted.as_slice() {
        [] => String::new(),
        [one] => one.clone(),
        [one, other] => format!("{one} or {other}"),
        many if many.len() < EXPECTED_KEPT => format!("one of {}", many.join(", ")),
        many => format!("one of {}, …", many.join(", ")),
    }
}

impl Diagnostic {
    /// `problem` at `span`.
    pub const fn new(span: Span, problem: Problem) -> Self {
        Self {
            span,
            entry: None,
            problem,
            frame: None,
        }
    }

    /// The same with all its places moved.
    #[must_use]
    pub(crate) fn placed(mut self, place: &impl Fn(usize) -> usize) -> Self {
        let moved = |span: Span| Span::from(place(span.start)..place(span.end));
        if let Problem::Duplicate { first, .. } = &mut self.problem {
            *first = first.map(moved);
        }
        self.span = moved(self.span);
        self
    }

    /// The same at a frame.
    #[must_use]
    pub(crate) fn at_frame(self, frame: f64) -> Self {
        let frame = Some(frame);
        Self { frame, ..self }
    }

    /// The same about `entry`.
    #[must_use]
    pub fn about(self, entry: Option<String>) -> Self {
        Self { entry, ..self }
    }
}

impl fmt::Display for Diagnostic {
    /// What is wrong; of which entry, where there is no place to show.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(frame) = self.frame {
            write!(f, "at frame {frame}, ")?;
        }
        if let Some(entry) = &self.entry
            && self.span == Span::default()
        {
            write!(f, "{entry}: ")?;
        }
        write!(f, "{}", self.problem)
    }
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

    /// The same at a frame of a scene that moves, which messages then name.
    #[must_use]
    pub fn at_frame(self, frame: f64) -> Self {
        let list = self.list.into_iter();
        Self {
            list: list.map(|diagnostic| diagnostic.at_frame(frame)).collect(),
            ..self
        }
    }

    pub(super) fn into_list(self) -> Vec<Diagnostic> {
        self.list
    }

    /// The single items, in the order of their places.
    pub fn list(&self) -> &[Diagnostic] {
        &self.list
    }

    /// Whether a later try or another machine may cure all that is wrong.
    pub fn is_transient(&self) -> bool {
        let mut problems = self.list.iter().map(|diagnostic| &diagnostic.problem);
        problems.all(Problem::is_transient)
    }

    /// The scene file's path.
    pub fn path(&self) -> &Path {
        &self.source.path
    }

    /// The same errors with places in another text, in which the scene's values were written.
    pub(crate) fn moved(self, source: Arc<Source>, place: impl Fn(Span) -> Span) -> Self {
        let list = self.list.into_iter();
        let list =
            list.map(|diagnostic| Diagnostic::new(place(diagnostic.span), diagnostic.problem));
        Self {
            source,
            list: list.collect(),
        }
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
        f.write_str(&self.render(false))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspelt_names_find_their_neighbor() {
        let keys = ["material", "center", "radius", "position", "vertical_fov"];
        for (written, meant) in [
            ("radus", Some("radius")),
            ("Radius", Some("radius")),
            ("raduis", Some("radius")),
            ("centre", Some("center")),
            ("vertical-fov", Some("vertical_fov")),
            ("verticalfov", Some("vertical_fov")),
            ("materials", Some("material")),
            ("color", None),
            ("x", None),
            ("", None),
        ] {
            assert_eq!(nearest(written, keys), meant, "{written}");
        }
    }

    #[test]
    fn of_equally_near_names_the_first() {
        assert_eq!(nearest("clay3", ["clay1", "clay2"]), Some("clay1"));
    }

    #[test]
    fn one_letter_names_are_not_all_alike() {
        assert_eq!(nearest("a", ["b"]), None);
        assert_eq!(nearest("a", ["A"]), Some("A"));
    }

    #[test]
    fn huge_names_are_cut_and_not_compared() {
        let huge = "a".repeat(100_000);
        let problem = Problem::unknown("key", &huge, [huge.as_str()]);
        assert!(problem.to_string().len() < 100);
        assert_eq!(nearest(&huge, ["a"]), None);
    }

    #[test]
    fn control_characters_do_not_reach_the_terminal() {
        assert_eq!(shortened("a\u{1b}[31m\n"), "a\\u{1b}[31m\\n");
    }

    #[test]
    fn a_million_possible_names_are_not_kept() {
        let names: Vec<String> = (0..100_000).map(|i| format!("clay{i}")).collect();
        let Problem::Unknown { expected, .. } =
            Problem::unknown("material", "gold", names.iter().map(String::as_str))
        else {
            panic!("another problem");
        };
        assert_eq!(expected.len(), EXPECTED_KEPT);
    }
}
