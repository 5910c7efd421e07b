//! The texts that make one scene: its file, the files that it includes, and what is set on the command line.
//!
//! They stand one behind the other in one text, so that a place is one number:
//!
//! ```text
//! scene.toml ⏎ lights.toml ⏎ lights.key.point.intensity = 20 ⏎
//! ```

use std::collections::HashSet;
use std::fs;
use std::ops::Range;
use std::path::{Path, PathBuf};

use toml::de::{DeTable, DeValue};
use toml_parser::lexer::TokenKind;

use super::super::diagnostic::{Diagnostic, IncludeError, Problem, Span};
use super::super::inputs::Input;
use super::super::{Part, Source};
use super::syntax::described;
use super::{LARGEST_FILE, change, folder_of, read_stream};
use crate::input::{self, Hash};

/// The key above all sections that names further files.
pub(super) const INCLUDE: &str = "include";

/// What messages call the texts that were set on the command line.
const SET: &str = "--set";

/// How many files one scene may include.
const MOST_INCLUDED: usize = 1000;

/// The texts of a scene.
pub(super) struct Document {
    pub(super) source: Source,
    /// What the files that a text names are relative to, and where it begins.
    pub(super) folders: Vec<(usize, PathBuf)>,
    /// The included files, and where they are named.
    pub(super) included: Vec<(Span, Input)>,
    pub(super) diagnostics: Vec<Diagnostic>,
    /// Those that are in it, by their real paths.
    known: HashSet<PathBuf>,
}

impl Document {
    /// A scene file with the files that it includes, relative to `folder`, and texts that were set.
    pub(super) fn new(text: String, path: &Path, folder: &Path, set: &[String]) -> Self {
        let own = 0..text.len();
        let mut document = Self {
            source: Source::new(path.to_owned(), text),
            folders: vec![(0, folder.to_owned())],
            included: Vec::new(),
            diagnostics: Vec::new(),
            known: HashSet::new(),
        };
        // What comes through a pipe has no path that anything could include.
        document.known.extend(fs::canonicalize(path));
        document.include_all(own, folder);
        for text in set {
            let quoted = change::quoted(text);
            let text = quoted.as_deref().unwrap_or(text);
            document.append(text, Path::new(SET), folder, true);
        }
        document
    }

    /// Where each text is, the scene file's first.
    pub(super) fn texts(&self) -> impl Iterator<Item = Range<usize>> {
        let own = 0..self.source.own_text().len();
        let parts = self.source.parts.iter().filter(|part| !part.is_set);
        std::iter::once(own).chain(parts.map(|part| part.range.clone()))
    }

    fn append(&mut self, text: &str, name: &Path, folder: &Path, is_set: bool) -> Range<usize> {
        self.source.text.push('\n');
        let start = self.source.text.len();
        self.source.text.push_str(text);
        let range = start..self.source.text.len();
        self.source.parts.push(Part {
            name: name.to_owned(),
            range: range.clone(),
            is_set,
        });
        self.folders.push((start, folder.to_owned()));
        range
    }

    /// Reads the files that a text includes, and those that these include.
    fn include_all(&mut self, range: Range<usize>, folder: &Path) {
        let text = &self.source.text[range.clone()];
        let files = match included(text) {
            Ok(files) => files,
            Err(wrong) => {
                self.diagnostics.push(wrong.placed(&|at| at + range.start));
                return;
            }
        };
        for (name, span) in files {
            let span = shifted(span, range.start);
            if let Err(problem) = self.include(&name, span, folder) {
                self.diagnostics.push(Diagnostic::new(span, problem));
            }
        }
    }

    fn include(&mut self, name: &str, span: Span, folder: &Path) -> Result<(), Problem> {
        if self.included.len() == MOST_INCLUDED {
            let message = format!("a scene includes at most {MOST_INCLUDED} files");
            return Err(Problem::Conflict(message));
        }
        let path = folder.join(name);
        let unreadable = |error: IncludeError| Problem::Included {
            path: path.clone(),
            error,
        };
        let real = fs::canonicalize(&path).map_err(|error| unreadable(error.into()))?;
        // A pipe would be waited for.
        let (file, length) = input::open(&path).map_err(unreadable)?;
        if self.source.text.len() as u64 + length > LARGEST_FILE {
            return Err(unreadable(too_large()));
        }
        if !self.known.insert(real) {
            let message = format!("`{name}` is a part of this scene already; include it once");
            return Err(Problem::Conflict(message));
        }
        let bytes = match read_stream(file) {
            Ok(bytes) => bytes,
            Err(Problem::Unreadable(error)) => return Err(unreadable(error.into())),
            // It has grown since.
            Err(_) => return Err(unreadable(too_large())),
        };
        let hash = Hash::of(&bytes);
        let text = String::from_utf8(bytes).map_err(|_| unreadable(IncludeError::NotUtf8))?;
        let input = Input {
            name: name.to_owned(),
            path: path.clone(),
            hash,
        };
        self.included.push((span, input));
        let folder = folder_of(&path).to_owned();
        let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
        let range = self.append(text, &path, &folder, false);
        self.include_all(range, &folder);
        Ok(())
    }
}

const fn too_large() -> IncludeError {
    IncludeError::TooLarge {
        limit: LARGEST_FILE / 1_000_000,
    }
}

/// A place in a text that begins at `start` of another.
fn shifted(span: Span, start: usize) -> Span {
    Span::from(span.start + start..span.end + start)
}

/// The names of the files that a text includes, with their places.
fn included(text: &str) -> Result<Vec<(String, Span)>, Box<Diagnostic>> {
    let top = above_headers(text);
    if !top.contains(INCLUDE) {
        return Ok(Vec::new());
    }
    // What is wrong with its form is found when the whole text is read.
    let Ok(tree) = DeTable::parse(top) else {
        return Ok(Vec::new());
    };
    let Some(node) = tree.get_ref().get(INCLUDE) else {
        return Ok(Vec::new());
    };
    let wrong = |node: &toml::Spanned<DeValue<'_>>, key: String, expected| {
        let found = described(node.get_ref());
        let problem = Problem::WrongType {
            key,
            found,
            expected,
        };
        Box::new(Diagnostic::new(node.span().into(), problem))
    };
    let expected = "a list of files, such as `include = [\"lights.toml\"]`";
    let Some(items) = node.get_ref().as_array() else {
        return Err(wrong(node, INCLUDE.to_owned(), expected));
    };
    let names = items.iter().enumerate().map(|(index, item)| {
        let name = item.get_ref().as_str();
        let name = name.filter(|name| !name.is_empty()).ok_or_else(|| {
            let key = format!("{INCLUDE}[{index}]");
            wrong(item, key, "the name of a file, such as `\"lights.toml\"`")
        })?;
        Ok((name.to_owned(), item.span().into()))
    });
    names.collect()
}

/// The text before the first `[header]`.
fn above_headers(text: &str) -> &str {
    let (mut open, mut is_start) = (0_usize, true);
    for token in toml_parser::Source::new(text).lex() {
        match token.kind() {
            TokenKind::LeftSquareBracket if is_start && open == 0 => {
                return &text[..token.span().start()];
            }
            TokenKind::LeftSquareBracket | TokenKind::LeftCurlyBracket => open += 1,
            TokenKind::RightSquareBracket | TokenKind::RightCurlyBracket => {
                open = open.saturating_sub(1);
            }
            TokenKind::Newline => {
                is_start = true;
                continue;
            }
            TokenKind::Whitespace | TokenKind::Comment => continue,
            TokenKind::Dot
            | TokenKind::Equals
            | TokenKind::Comma
            | TokenKind::LiteralString
            | TokenKind::BasicString
            | TokenKind::MlLiteralString
            | TokenKind::MlBasicString
            | TokenKind::Atom
            | TokenKind::Eof => {}
        }
        is_start = false;
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_named_above_all_headers() {
        let names = |text: &str| -> Vec<String> {
            let files = included(text).unwrap();
            files.into_iter().map(|(name, _)| name).collect()
        };
        assert_eq!(
            names("include = [\"a.toml\",\n  \"b.toml\"\n]\n[image]\n"),
            ["a.toml", "b.toml"]
        );
        assert_eq!(
            names("# include\n[image]\ninclude = [\"a.toml\"]\n"),
            [""; 0]
        );
        assert_eq!(names("include = []\n"), [""; 0]);
        for wrong in [
            "include = \"a.toml\"",
            "include = [1]",
            "include = [\"\"]",
            "include = {}",
        ] {
            let message = included(wrong).unwrap_err().problem.to_string();
            assert!(message.contains("expected"), "{message}");
        }
    }

    #[test]
    fn headers_end_the_top() {
        assert_eq!(above_headers("a = [\n[1],\n]\n [b]\n"), "a = [\n[1],\n]\n ");
        assert_eq!(above_headers("a = 1"), "a = 1");
    }
}
