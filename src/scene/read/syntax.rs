//! TOML to a tree with spans; which parts of it to believe after a syntax error.

use std::collections::HashSet;
use std::ops::Range;

use toml::de::{DeTable, DeValue, Error};
use toml_parser::lexer::TokenKind;

use super::super::diagnostic::{Diagnostic, MOST_COLLECTED, Problem, Span};
use super::Node;
use super::{habits, place};
use crate::printable::shortened;

/// The size in bytes up to which more than the first syntax error is looked for: text that is
/// nothing but errors costs 300 times its size in messages.
const RECOVERED_SIZE: usize = 128 << 10;

/// For how many duplicates the first one is looked up; more are not printed.
const FIRSTS_SHOWN: usize = 20;

/// How many keys a dotted key may have in the TOML parser.
const DEEPEST_KEY: usize = 80;

/// How many brackets may be open within each other; no scene needs more than four.
const DEEPEST_BRACKET: usize = 64;

/// What syntax errors leave unreliable in the tree that was recovered.
///
/// An entry that a syntax error has touched is left out without a word: what else is wrong with
/// it may only be a consequence.
#[derive(Debug)]
pub(super) struct Damage {
    /// Where the `[headers]` start, in ascending order.
    headers: Vec<usize>,
    /// The headers among these whose lines have an error.
    touched: HashSet<usize>,
    /// The first byte of what the parser did not find its way through.
    lost_from: usize,
}

impl Damage {
    pub(super) fn none() -> Self {
        Self {
            headers: Vec::new(),
            touched: HashSet::new(),
            lost_from: usize::MAX,
        }
    }

    /// After an error that hides the whole file.
    pub(super) fn whole() -> Self {
        Self {
            lost_from: 0,
            ..Self::none()
        }
    }

    /// A text that belongs to the scene is not there.
    pub(super) fn lose_a_text(&mut self) {
        self.lost_from = self.lost_from.min(usize::MAX - 1);
    }

    /// Of another text of the same scene, too.
    pub(super) fn add(&mut self, other: Self) {
        self.headers.extend(other.headers);
        self.touched.extend(other.touched);
        self.lost_from = self.lost_from.min(other.lost_from);
    }

    /// As it is in a text that begins at `start`.
    fn shifted(self, start: usize) -> Self {
        Self {
            headers: self.headers.into_iter().map(|at| at + start).collect(),
            touched: self.touched.into_iter().map(|at| at + start).collect(),
            lost_from: self.lost_from.saturating_add(start),
        }
    }

    /// Whether some part of the file is lost, and with it entries nobody knows the names of.
    pub(super) fn lost_entries(&self) -> bool {
        self.lost_from != usize::MAX
    }

    /// Whether what is written at `offset` cannot be believed.
    pub(super) fn reaches(&self, offset: usize) -> bool {
        offset >= self.lost_from
            || (!self.touched.is_empty()
                && self
                    .header_before(offset)
                    .is_some_and(|header| self.touched.contains(&header)))
    }

    fn header_before(&self, offset: usize) -> Option<usize> {
        let after = self.headers.partition_point(|&header| header <= offset);
        after.checked_sub(1).map(|last| self.headers[last])
    }
}

/// The tree of `text`, which begins at `start` of the whole, as far as it could be read, and the syntax errors.
pub(super) fn parse(text: &str, start: usize) -> (DeTable<'_>, Damage, Vec<Diagnostic>) {
    let (mut root, damage, diagnostics) = parse_alone(text);
    if start == 0 {
        return (root, damage, diagnostics);
    }
    let place = |at: usize| at + start;
    place::shift(&mut root, &place);
    let diagnostics = diagnostics.into_iter();
    let diagnostics = diagnostics.map(|diagnostic| diagnostic.placed(&place));
    (root, damage.shifted(start), diagnostics.collect())
}

fn parse_alone(text: &str) -> (DeTable<'_>, Damage, Vec<Diagnostic>) {
    if let Err(wrong) = readable(text) {
        return hopeless(wrong.span, wrong.problem);
    }
    let first = match DeTable::parse(text) {
        Ok(root) => return (root.into_inner(), Damage::none(), Vec::new()),
        Err(error) => error,
    };
    if text.len() > RECOVERED_SIZE {
        let Diagnostic { span, problem, .. } = first_error(text, &first);
        return hopeless(span, problem);
    }
    let (root, errors) = DeTable::parse_recoverable(text);
    let root = root.into_inner();
    let (damage, diagnostics) = assess(text, &root, &errors);
    (root, damage, diagnostics)
}

/// Whether the parser can be let loose on a text.
///
/// # Errors
/// What it would take too long or too deep a stack for.
pub(super) fn readable(text: &str) -> Result<(), Box<Diagnostic>> {
    // TOML has no lone carriage returns, and its parser takes quadratic time for many of them.
    if let Some(span) = lone_return(text) {
        let message = "a carriage return without a line feed; lines end in LF or CR LF";
        let problem = Problem::Syntax(message.to_owned());
        return Err(Box::new(Diagnostic::new(span, problem)));
    }
    // The parser has a stack frame for every open bracket, whatever its own limit says.
    if let Some(span) = too_deep(text) {
        let message = "brackets within brackets, more than a scene can have; is one not closed?";
        let problem = Problem::Syntax(message.to_owned());
        return Err(Box::new(Diagnostic::new(span, problem)));
    }
    Ok(())
}

/// The error that a large text ends with.
pub(super) fn first_error(text: &str, error: &Error) -> Diagnostic {
    let span = place(text, error);
    let line = line_around(text, span.start);
    if error.message() == "duplicate key" && text[line.clone()].trim_start().starts_with('[') {
        return duplicate_header(text, line, true);
    }
    Diagnostic::new(span, syntax(text, error.message(), span))
}

/// One error, after which nothing is looked at.
fn hopeless<'i>(span: Span, problem: Problem) -> (DeTable<'i>, Damage, Vec<Diagnostic>) {
    let diagnostics = vec![Diagnostic::new(span, problem)];
    (DeTable::new(), Damage::whole(), diagnostics)
}

/// The first carriage return that no line feed follows.
fn lone_return(text: &str) -> Option<Span> {
    let bytes = text.as_bytes();
    text.match_indices('\r')
        .map(|(start, _)| start)
        .find(|start| bytes.get(start + 1) != Some(&b'\n'))
        .map(|start| Span::from(start..start + 1))
}

/// The first bracket that more than [`DEEPEST_BRACKET`] others are open around.
///
/// A closing bracket counts only where it fits the innermost open one, so that after errors the
/// depth is rather over- than underrated.
fn too_deep(text: &str) -> Option<Span> {
    let mut open = Vec::with_capacity(DEEPEST_BRACKET);
    for token in toml_parser::Source::new(text).lex() {
        match token.kind() {
            kind @ (TokenKind::LeftSquareBracket | TokenKind::LeftCurlyBracket) => {
                if open.len() == DEEPEST_BRACKET {
                    let span = token.span();
                    return Some(Span::from(span.start()..span.end()));
                }
                open.push(kind);
            }
            TokenKind::RightSquareBracket => {
                open.pop_if(|kind| *kind == TokenKind::LeftSquareBracket);
            }
            TokenKind::RightCurlyBracket => {
                open.pop_if(|kind| *kind == TokenKind::LeftCurlyBracket);
            }
            TokenKind::Dot
            | TokenKind::Equals
            | TokenKind::Comma
            | TokenKind::Whitespace
            | TokenKind::Comment
            | TokenKind::Newline
            | TokenKind::LiteralString
            | TokenKind::BasicString
            | TokenKind::MlLiteralString
            | TokenKind::MlBasicString
            | TokenKind::Atom
            | TokenKind::Eof => {}
        }
    }
    None
}

/// Tells the errors that stay within their line from those after which nothing is certain, and
/// drops what only follows from an earlier one.
fn assess(text: &str, root: &DeTable<'_>, errors: &[Error]) -> (Damage, Vec<Diagnostic>) {
    let mut headers = Vec::new();
    let mut keys = HashSet::new();
    collect_starts(text, root, &mut headers, &mut keys);
    headers.sort_unstable();
    keys.extend(headers.iter().copied());
    let mut damage = Damage {
        headers,
        ..Damage::none()
    };

    let mut errors: Vec<(Span, &str)> = errors
        .iter()
        .map(|error| (place(text, error), error.message()))
        .collect();
    errors.sort_by_key(|&(span, _)| span);
    let first = errors.first().map(|&(span, _)| span.start);
    let open = errors.iter().find_map(|&(span, message)| {
        let what = unclosed(message)?;
        // Some brackets end in the tree where the first error is, not where the file ends.
        let value = outermost_value(root, span.start).or_else(|| outermost_value(root, first?))?;
        Some((value.start, what))
    });
    if let Some((start, what)) = open {
        // An unclosed bracket swallows what follows: that is one error, at the bracket.
        errors.retain(|(span, _)| span.start < start);
        errors.push((Span::from(start..start + 1), what));
    }
    errors.sort_by_key(|&(span, _)| span);

    let mut diagnostics = Vec::new();
    let mut duplicate_headers = HashSet::new();
    let mut last_line = None;
    for (span, message) in errors {
        let line = line_around(text, span.start);
        if diagnostics.len() == MOST_COLLECTED {
            damage.lost_from = damage.lost_from.min(line.start);
            break;
        }
        if last_line.replace(line.start) == Some(line.start) {
            continue;
        }
        let first = line.start + indentation(&text[line.clone()]);
        let owner = damage.header_before(span.start);
        if message == "duplicate key" {
            if duplicate_headers.contains(&owner) {
                // All keys of a owner that is there twice are there twice.
                continue;
            }
            let look_up = diagnostics.len() < FIRSTS_SHOWN;
            diagnostics.push(if owner == Some(first) {
                duplicate_headers.insert(owner);
                duplicate_header(text, line, look_up)
            } else {
                duplicate_key(text, root, owner, span, look_up)
            });
            match owner {
                Some(owner) => _ = damage.touched.insert(owner),
                None => damage.lost_from = 0,
            }
            continue;
        }
        diagnostics.push(Diagnostic::new(span, syntax(text, message, span)));
        let is_open = open.is_some_and(|(start, _)| start == span.start);
        let recovered = !is_open
            && !text[first..].starts_with('[')
            && next_statement(text, line.end).is_none_or(|next| keys.contains(&next));
        match owner {
            Some(owner) => _ = damage.touched.insert(owner),
            // Keys above all headers can belong to any entry.
            None => damage.lost_from = 0,
        }
        if !recovered {
            damage.lost_from = damage.lost_from.min(line.start);
            break;
        }
    }
    (damage, diagnostics)
}

/// Where an error is; the parser gives no place to keys that are nested too deeply.
fn place(text: &str, error: &Error) -> Span {
    let span = error.span().unwrap_or_else(|| {
        let mut start = 0;
        for line in text.split_inclusive('\n') {
            let key = line.split(['=', '#', ']']).next().unwrap_or(line);
            if key.matches('.').count() >= DEEPEST_KEY {
                return start..start + key.len();
            }
            start += line.len();
        }
        0..0
    });
    // A span of no bytes at 0 is the mark of what has no place.
    let end = if span.end == 0 && !text.is_empty() {
        text.ceil_char_boundary(1)
    } else {
        span.end
    };
    Span::from(span.start..end)
}

/// The message of the TOML parser, in the words of someone who edits a scene.
fn syntax(text: &str, message: &str, span: Span) -> Problem {
    if let Some(way_out) = habits::way_out(&text[line_around(text, span.start)]) {
        return Problem::Syntax(way_out);
    }
    let written = text.get(span.start..span.end).unwrap_or_default();
    let before = text[..span.start].trim_end_matches([' ', '\t']);
    let after = text[span.start..].trim_start_matches([' ', '\t']);
    let is_digit = |character: Option<char>| character.is_some_and(|c| c.is_ascii_digit());
    let decimal_comma = after
        .strip_prefix(',')
        .is_some_and(|rest| is_digit(before.chars().next_back()) && is_digit(rest.chars().next()));
    Problem::Syntax(if decimal_comma {
        "unexpected comma; numbers are written with a decimal point, such as `0.5`".to_owned()
    } else if message.starts_with("string values must be quoted") {
        if written.is_empty() {
            "a value is missing here".to_owned()
        } else {
            let written = shortened(written);
            format!("`{written}` is not a value; text is written in quotes, such as `\"clay\"`")
        }
    } else if message.starts_with("invalid basic string, expected `\"`") {
        "this text is never closed, expected `\"`".to_owned()
    } else if message.starts_with("unclosed table,") {
        "this header is never closed, expected `]`".to_owned()
    } else if message.contains("recursion") {
        "this is nested too deeply".to_owned()
    } else {
        message.replace("expected nothing", "it cannot stand here")
    })
}

/// What an error says to be open until the end of the file.
fn unclosed(message: &str) -> Option<&'static str> {
    if message.starts_with("unclosed array,") {
        Some("this `[` is never closed, expected `]`")
    } else if message.starts_with("unclosed inline table,") {
        Some("this `{` is never closed, expected `}`")
    } else if message.starts_with("invalid multi-line") {
        Some("this string of several lines is never closed")
    } else {
        None
    }
}

fn duplicate_header(text: &str, line: Range<usize>, look_up: bool) -> Diagnostic {
    let written = text[line.clone()].trim_end();
    let start = line.start + indentation(written);
    let mut path = Vec::new();
    if let Ok(header) = DeTable::parse(written) {
        let mut table = header.into_inner();
        while let Some((key, value)) = table.into_iter().next() {
            path.push(key.into_inner().into_owned());
            match value.into_inner() {
                DeValue::Table(inner) => table = inner,
                _ => break,
            }
        }
    }
    // What stands above the second one is a document of its own, which has the first.
    let first = look_up
        .then(|| {
            let (above, _) = DeTable::parse_recoverable(&text[..line.start]);
            find(text, above.get_ref(), &path)
        })
        .flatten();
    let (what, name) = match path.as_slice() {
        [section, name, _] if section == "materials" => ("material", name.clone()),
        [section, name, _] if section == "lights" => ("light", name.clone()),
        [section, name, _] if section == "objects" => ("object", name.clone()),
        [section] => ("section", section.clone()),
        _ => ("section", path.join(".")),
    };
    let end = start
        + written
            .trim_start()
            .find('#')
            .unwrap_or(written.trim_start().len());
    let end = start + text[start..end].trim_end().len();
    Diagnostic::new(
        Span::from(start..end),
        Problem::Duplicate { what, name, first },
    )
}

fn duplicate_key(
    text: &str,
    root: &DeTable<'_>,
    owner: Option<usize>,
    span: Span,
    look_up: bool,
) -> Diagnostic {
    let name = text[span.start..span.end].trim_matches(['"', '\'']);
    let is_dotted = text[..span.start].trim_end().ends_with('.')
        || text[span.end..].trim_start().starts_with('.');
    let first = (look_up && !is_dotted)
        .then(|| {
            let table = match owner {
                Some(owner) => table_at(root, owner)?,
                None => root,
            };
            let (key, _) = inline_table_around(table, span.start).get_key_value(name)?;
            (key.span().start < span.start).then(|| key.span().into())
        })
        .flatten();
    let name = name.to_owned();
    Diagnostic::new(
        span,
        Problem::Duplicate {
            what: "key",
            name,
            first,
        },
    )
}

/// Where the last key of `path` is written: its `[header]`, if it has one.
fn find(text: &str, table: &DeTable<'_>, path: &[String]) -> Option<Span> {
    let (last, above) = path.split_last()?;
    let mut table = table;
    for key in above {
        table = table.get(key.as_str())?.get_ref().as_table()?;
    }
    let (key, node) = table.get_key_value(last.as_str())?;
    Some(header(text, key.span().into(), node))
}

/// The table whose header starts at `header`.
fn table_at<'a, 'i>(table: &'a DeTable<'i>, header: usize) -> Option<&'a DeTable<'i>> {
    table.iter().find_map(|(_, node)| match node.get_ref() {
        DeValue::Table(inner) if node.span().start == header => Some(inner),
        DeValue::Table(inner) => table_at(inner, header),
        DeValue::Array(items) => items.iter().find_map(|item| {
            let inner = item.get_ref().as_table()?;
            if item.span().start == header {
                Some(inner)
            } else {
                table_at(inner, header)
            }
        }),
        _ => None,
    })
}

/// The innermost inline table around `offset` among the values of `table`, or `table` itself.
fn inline_table_around<'a, 'i>(table: &'a DeTable<'i>, offset: usize) -> &'a DeTable<'i> {
    fn within<'a, 'i>(node: &'a Node<'i>, offset: usize) -> Option<&'a DeTable<'i>> {
        if !node.span().contains(&offset) {
            return None;
        }
        match node.get_ref() {
            DeValue::Table(inner) => Some(inline_table_around(inner, offset)),
            DeValue::Array(items) => items.iter().find_map(|item| within(item, offset)),
            _ => None,
        }
    }
    table
        .iter()
        .find_map(|(_, node)| within(node, offset))
        .unwrap_or(table)
}

/// The value with brackets or quotes that is open at `offset`, seen from outside.
fn outermost_value(table: &DeTable<'_>, offset: usize) -> Option<Range<usize>> {
    table.iter().find_map(|(_, node)| {
        let span = node.span();
        let is_around = span.start < offset && offset <= span.end;
        match node.get_ref() {
            DeValue::Array(_) | DeValue::String(_) | DeValue::Table(_) if is_around => Some(span),
            DeValue::Table(inner) => outermost_value(inner, offset),
            DeValue::Array(items) => items
                .iter()
                .filter_map(|item| item.get_ref().as_table())
                .find_map(|inner| outermost_value(inner, offset)),
            _ => None,
        }
    })
}

/// Where headers and keys start that made it into the tree.
fn collect_starts(
    text: &str,
    table: &DeTable<'_>,
    headers: &mut Vec<usize>,
    keys: &mut HashSet<usize>,
) {
    for (key, node) in table {
        keys.insert(key.span().start);
        let start = node.span().start;
        match node.get_ref() {
            DeValue::Table(inner) => {
                if text[start..].starts_with('[') {
                    headers.push(start);
                }
                collect_starts(text, inner, headers, keys);
            }
            DeValue::Array(items) => {
                for item in items {
                    let start = item.span().start;
                    if let DeValue::Table(inner) = item.get_ref() {
                        if text[start..].starts_with("[[") {
                            headers.push(start);
                        }
                        collect_starts(text, inner, headers, keys);
                    }
                }
            }
            _ => {}
        }
    }
}

fn line_around(text: &str, offset: usize) -> Range<usize> {
    let start = text[..offset].rfind('\n').map_or(0, |newline| newline + 1);
    let end = text[offset..]
        .find('\n')
        .map_or(text.len(), |newline| offset + newline);
    start..end
}

fn indentation(line: &str) -> usize {
    line.len() - line.trim_start().len()
}

/// The first byte after `offset` that is neither blank nor comment.
fn next_statement(text: &str, offset: usize) -> Option<usize> {
    let mut start = offset;
    for line in text[offset..].split_inclusive('\n') {
        let content = line.trim();
        if !content.is_empty() && !content.starts_with('#') {
            return Some(start + indentation(line));
        }
        start += line.len();
    }
    None
}

/// The place of an entry: its `[header]`, or its key where it has none.
pub(super) fn header(text: &str, key: Span, node: &Node<'_>) -> Span {
    let span = Span::from(node.span());
    let has_header = node.get_ref().is_table() && text[span.start..].starts_with('[');
    if has_header { span } else { key }
}

/// A value as errors name it.
pub(super) fn described(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("the string \"{}\"", shortened(text)),
        DeValue::Integer(integer) => format!("the integer {}", shortened(&integer.to_string())),
        DeValue::Float(float) => format!("the number {}", shortened(float.as_str())),
        DeValue::Boolean(value) => format!("`{value}`"),
        DeValue::Datetime(_) => "a date or time".to_owned(),
        DeValue::Array(items) if items.is_empty() => "an empty array".to_owned(),
        DeValue::Array(items) => format!("an array of {}", items.len()),
        DeValue::Table(_) => "a table".to_owned(),
    }
}
