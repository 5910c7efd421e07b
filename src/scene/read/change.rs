//! What was set on the command line: `lights.key.point.intensity=20` in the place of what the files say.

use std::cell::Cell;

use toml::de::{DeString, DeTable, DeValue};
use toml_parser::lexer::TokenKind;

use super::super::Source;
use super::super::diagnostic::{Diagnostic, Problem, Span};
use super::place::shift;
use super::{ENTRIES, Node};
use crate::printable::shortened;

/// What such a text looks like.
const EXAMPLE: &str = "`lights.key.point.intensity=20`, `image.color_space=acescg` or \
                       `camera.perspective.vertical_fov=30`";

/// All that was set.
#[derive(Default)]
pub(super) struct Changes<'t>(Vec<Change<'t>>);

/// One value that was set.
struct Change<'t> {
    /// `lights`, `key`, `point`, `intensity`
    keys: Vec<toml::Spanned<DeString<'t>>>,
    value: Node<'t>,
    /// Whether what it is about is in the scene.
    is_used: Cell<bool>,
}

impl<'t> Changes<'t> {
    /// Reads what was set; what is wrong with it is reported.
    pub(super) fn read(source: &'t Source, diagnostics: &mut Vec<Diagnostic>) -> Self {
        let mut changes = Vec::new();
        for part in source.parts.iter().filter(|part| part.is_set) {
            match change(&source.text[part.range.clone()], part.range.start) {
                Ok(change) => changes.push(change),
                Err(problem) => {
                    let span = Span::from(part.range.clone());
                    diagnostics.push(Diagnostic::new(span, problem));
                }
            }
        }
        Self(changes)
    }

    /// What is at these keys with what was set in it, and what is wrong with that; `None` where nothing was.
    pub(super) fn apply(&self, keys: &[&str], node: &Node<'t>) -> Option<(Node<'t>, Vec<Wrong>)> {
        let is_about = |change: &&Change<'_>| {
            let mut names = change.keys.iter().map(|key| key.get_ref().as_ref());
            keys.iter().all(|&key| names.next() == Some(key))
        };
        let mut changes = self.0.iter().filter(is_about).peekable();
        changes.peek()?;
        let (mut changed, mut wrong) = (node.clone(), Vec::new());
        for change in changes {
            change.is_used.set(true);
            let further = &change.keys[keys.len()..];
            wrong.extend(set(&mut changed, keys, further, &change.value).err());
        }
        Some((changed, wrong))
    }

    /// The keys of what was set of entries that there are not.
    pub(super) fn unused(&self) -> impl Iterator<Item = &[toml::Spanned<DeString<'t>>]> {
        let unused = self.0.iter().filter(|change| !change.is_used.get());
        unused.map(|change| change.keys.as_slice())
    }
}

/// What is wrong, and where.
pub(super) type Wrong = (Span, Problem);

/// That keys lead to no value.
pub(super) fn sets_nothing() -> Problem {
    Problem::Conflict(format!("this sets no value; expected {EXAMPLE}"))
}

/// A text as TOML has it: a name may stand without quotes, which shells take away.
pub(super) fn quoted(text: &str) -> Option<String> {
    let (_, equals) = keys(text).filter(|&(count, _)| count > 0)?;
    if DeTable::parse(text).is_ok() {
        return None;
    }
    let value = text[equals + 1..].trim();
    let is_name = |c: char| c.is_alphanumeric() || matches!(c, '_' | '-' | '.' | '/' | '#');
    let is_bare = !value.is_empty() && value.chars().all(is_name);
    let quoted = is_bare.then(|| format!("{}\"{value}\"", &text[..=equals]))?;
    // What is wrong elsewhere is shown as it was typed.
    DeTable::parse(&quoted).is_ok().then_some(quoted)
}

/// What a text sets, which begins at `start` of the whole.
fn change(text: &str, start: usize) -> Result<Change<'_>, Problem> {
    let expected = || Problem::Syntax(format!("expected KEYS=VALUE, such as {EXAMPLE}"));
    let (count, equals) = keys(text)
        .filter(|&(count, _)| count > 0)
        .ok_or_else(expected)?;
    if text[equals + 1..].trim().is_empty() {
        let problem =
            format!("a value is missing after `=`; expected KEYS=VALUE, such as {EXAMPLE}");
        return Err(Problem::Syntax(problem));
    }
    let parsed = DeTable::parse(text).map_err(|error| {
        let message = error.message();
        Problem::Syntax(format!("{message}; expected KEYS=VALUE, such as {EXAMPLE}"))
    });
    let mut table = parsed?.into_inner();
    shift(&mut table, &|at| at + start);
    let mut found = Vec::new();
    loop {
        let mut items = table.into_iter();
        let (Some((key, value)), None) = (items.next(), items.next()) else {
            return Err(expected());
        };
        found.push(key);
        if found.len() == count {
            return Ok(Change {
                keys: found,
                value,
                is_used: Cell::new(false),
            });
        }
        let DeValue::Table(inner) = value.into_inner() else {
            return Err(expected());
        };
        table = inner;
    }
}

/// How many keys there are before the `=`, and where that is.
fn keys(text: &str) -> Option<(usize, usize)> {
    let mut count = 0;
    for token in toml_parser::Source::new(text).lex() {
        match token.kind() {
            TokenKind::Equals => return Some((count, token.span().start())),
            TokenKind::Atom | TokenKind::BasicString | TokenKind::LiteralString => count += 1,
            TokenKind::Dot | TokenKind::Whitespace => {}
            TokenKind::LeftSquareBracket
            | TokenKind::RightSquareBracket
            | TokenKind::LeftCurlyBracket
            | TokenKind::RightCurlyBracket
            | TokenKind::Comma
            | TokenKind::Comment
            | TokenKind::Newline
            | TokenKind::MlBasicString
            | TokenKind::MlLiteralString
            | TokenKind::Eof => return None,
        }
    }
    None
}

/// Sets what is at `keys` of a table, whose own keys were `above`.
fn set<'t>(
    node: &mut Node<'t>,
    above: &[&str],
    keys: &[toml::Spanned<DeString<'t>>],
    value: &Node<'t>,
) -> Result<(), Wrong> {
    let [key, further @ ..] = keys else {
        return Err((value.span().into(), sets_nothing()));
    };
    let span = Span::from(key.span());
    let DeValue::Table(table) = node.get_mut() else {
        let problem = Problem::Conflict(format!(
            "`{}` is no table here; set it as a whole",
            shortened(&above.join("."))
        ));
        return Err((span, problem));
    };
    let name = key.get_ref().as_ref();
    let is_entry = above
        .first()
        .is_some_and(|section| ENTRIES.contains(section));
    let is_camera = above == ["camera"];
    // `point` in `lights.key.point`: an entry stays of the kind that it is.
    let is_kind = is_camera || is_entry && above.len() == 2;
    if is_kind && !table.contains_key(name) {
        let kinds: Vec<&str> = table.keys().map(|key| key.get_ref().as_ref()).collect();
        let problem = Problem::unknown("kind in the scene:", name, kinds);
        return Err((span, problem));
    }
    if further.is_empty() {
        table.insert(key.clone(), value.clone());
        return Ok(());
    }
    let Some(inner) = table.get_mut(name) else {
        let problem = Problem::Conflict(format!(
            "there is no `{}` here to change a part of; set it as a whole",
            shortened(name)
        ));
        return Err((span, problem));
    };
    let above: Vec<&str> = above.iter().copied().chain([name]).collect();
    set(inner, &above, further, value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_end_at_the_sign() {
        assert_eq!(keys("a.b.c=1"), Some((3, 5)));
        assert_eq!(keys("a.\"b.c\" = {x.y = 1}"), Some((2, 8)));
        for wrong in ["", "a", "[a]", "a\nb=1", "{a=1}"] {
            assert_eq!(keys(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn values_are_those_of_files_and_bare_names() {
        let value = |text: &str| {
            let text = quoted(text).unwrap_or_else(|| text.to_owned());
            let change = change(&text, 0).ok()?;
            Some(
                change
                    .value
                    .get_ref()
                    .as_str()
                    .unwrap_or("no text")
                    .to_owned(),
            )
        };
        for (text, expected) in [
            ("image.color_space=acescg", "acescg"),
            ("objects.a.mesh.file=../b.ply", "../b.ply"),
            ("objects.a.mesh.file=\"b c.ply\"", "b c.ply"),
            ("materials.a.phong.diffuse=#804020", "#804020"),
            ("a.b={ candela = 3 }", "no text"),
        ] {
            assert_eq!(value(text).as_deref(), Some(expected), "{text}");
        }
        for wrong in [
            "a.b=",
            "a.b=[1",
            "a.b=1\nc=2",
            "a",
            "a.b={",
            "=3",
            "a.b=b c",
        ] {
            assert_eq!(value(wrong), None, "{wrong}");
        }
    }
}
