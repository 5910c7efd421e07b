//! A large scene file in pieces, each a tree by itself: the tree of a whole file takes up to 150
//! times the file's size.
//!
//! A piece ends where an entry does, and is as long as its entries until they are long enough:
//!
//! ```text
//! [objects.a.sphere]     ┐
//! …                      │ a piece
//! [objects.b.sphere]     │
//! …                      ┘
//! [lights]               ┐
//! a.point = { … }        │ a piece
//! b.point = { … }        ┘
//! c.point = { … }          a piece, with `[lights]` before it
//! ```

use std::collections::HashMap;
use std::ops::Range;

use toml::de::DeTable;
use toml_parser::lexer::{Lexer, TokenKind};

use super::super::diagnostic::{Diagnostic, Problem, Span};
use super::place::shift;
use super::sections::SECTIONS;
use super::{ENTRIES, syntax};

/// The size in bytes from which on a piece ends with its last entry.
const PIECE: usize = 64 << 10;

/// How many values one entry can have: a tree takes up to 300 bytes for each. Curves of so many points
/// belong in files.
const MOST_VALUES: usize = 500_000;

/// A piece of a scene file: a header that holds for it, if its own is in a piece before, and text.
struct Piece {
    header: Option<Range<usize>>,
    body: Range<usize>,
}

/// What the statements of one entry have in common: the section's key and the entry's, as written.
/// Statements of a section without entries have only its key in common.
type Entry<'t> = [&'t str; 2];

/// Calls `each` with the tree of every piece of a text that begins at `start` of the whole, from the first to the
/// last, until there is an error.
pub(super) fn for_each<'t>(
    text: &'t str,
    start: usize,
    mut each: impl FnMut(Tree<'t, '_>) -> Result<(), Box<Diagnostic>>,
) -> Result<(), Box<Diagnostic>> {
    let mut scanner = Scanner::new(text);
    let in_whole = |at: usize| at + start;
    while let Some(Piece { header, body }) = scanner
        .next()
        .map_err(|wrong| Box::new(wrong.placed(&in_whole)))?
    {
        let Some(header) = header else {
            let offset = body.start + start;
            let place = |at: usize| at + offset;
            let mut tree = parse(&text[body], &place)?;
            shift(&mut tree, &place);
            each(Tree::Own(tree))?;
            continue;
        };
        let copy = format!("{}\n{}", &text[header.clone()], &text[body.clone()]);
        let place = |at: usize| match at.checked_sub(header.len() + 1) {
            Some(at) => in_whole(at + body.start),
            None => in_whole(at + header.start),
        };
        let mut tree = parse(&copy, &place)?;
        shift(&mut tree, &place);
        each(Tree::Continued(&tree))?;
    }
    Ok(())
}

/// The tree of a piece, with places in the whole file.
pub(super) enum Tree<'t, 'p> {
    /// Of a piece that starts with a header of its own.
    Own(DeTable<'t>),
    /// Of more entries of a section that began before.
    Continued(&'p DeTable<'p>),
}

fn parse<'p>(
    piece: &'p str,
    place: &impl Fn(usize) -> usize,
) -> Result<DeTable<'p>, Box<Diagnostic>> {
    let tree = DeTable::parse(piece)
        .map_err(|error| Box::new(syntax::first_error(piece, &error).placed(place)))?;
    Ok(tree.into_inner())
}

/// Finds the pieces.
struct Scanner<'t> {
    text: &'t str,
    tokens: Lexer<'t>,
    /// The kinds of the brackets that are open.
    open: Vec<TokenKind>,
    /// Where the piece starts, where its last statement ends, and the header that holds for it.
    start: usize,
    end: usize,
    header: Option<Range<usize>>,
    /// The entry of the last statement, how many values it has so far, and where it starts.
    entry: Entry<'t>,
    values: usize,
    entry_start: usize,
    /// The last header, if it is one of a section whose keys are entries.
    section: Option<(&'t str, Range<usize>)>,
    /// The sections that have a header of their own.
    headers: HashMap<&'t str, Span>,
    ended: bool,
}

/// How a statement begins: a header, or the keys of a value.
struct Statement<'t> {
    start: usize,
    /// One past its `]`.
    header_end: Option<usize>,
    /// The first two keys, and how many there are.
    keys: Entry<'t>,
    count: usize,
    /// Lines before it with nothing but comments.
    blank_lines: usize,
}

impl<'t> Scanner<'t> {
    fn new(text: &'t str) -> Self {
        Self {
            text,
            tokens: toml_parser::Source::new(text).lex(),
            open: Vec::new(),
            start: 0,
            end: 0,
            header: None,
            entry: ["", ""],
            values: 0,
            entry_start: 0,
            section: None,
            headers: HashMap::new(),
            ended: false,
        }
    }

    /// The next piece.
    fn next(&mut self) -> Result<Option<Piece>, Box<Diagnostic>> {
        while !self.ended {
            let before = self.end;
            let Some(statement) = self.statement() else {
                self.ended = true;
                let piece = self.cut(before, 0, None);
                return Ok((!piece.body.is_empty()).then_some(piece));
            };
            let own = statement.start;
            let is_header = statement.header_end.is_some();
            let entry = match (&self.section, is_header) {
                (Some((section, _)), false) => [*section, statement.keys[0]],
                (None, false) => self.entry,
                (_, true) if is_undivided(statement.keys[0]) => [statement.keys[0], ""],
                (_, true) => statement.keys,
            };
            // Also where there are but comments: these have tokens, too.
            let is_long = own - self.start >= PIECE && entry != self.entry;
            // What has a header from before holds nothing else.
            let is_done = self.header.is_some() && is_header;
            let continued = self.section.as_ref().filter(|_| !is_header);
            let continued = continued.map(|(_, header)| header.clone());
            if let Some(end) = statement.header_end {
                self.note_header(&statement, own..end)?;
                let is_section = statement.count == 1 && ENTRIES.contains(&statement.keys[0]);
                self.section = is_section.then(|| (statement.keys[0], own..end));
            }
            if entry == self.entry {
                self.values += statement.blank_lines;
            } else {
                (self.entry, self.values, self.entry_start) = (entry, 0, own);
            }
            let piece = (is_long || is_done).then(|| self.cut(before, own, continued));
            if !is_header {
                self.value()?;
            }
            if let Some(piece) = piece
                && !piece.body.is_empty()
            {
                return Ok(Some(piece));
            }
        }
        Ok(None)
    }

    /// Remembers the header of a section; a second one is an error that no piece shows.
    fn note_header(
        &mut self,
        statement: &Statement<'t>,
        place: Range<usize>,
    ) -> Result<(), Box<Diagnostic>> {
        let [section, _] = statement.keys;
        if statement.count != 1 || !SECTIONS.contains(&section) {
            return Ok(());
        }
        let span = Span::from(place);
        let Some(first) = self.headers.insert(section, span) else {
            return Ok(());
        };
        let problem = Problem::Duplicate {
            what: "section",
            name: section.to_owned(),
            first: Some(first),
        };
        Err(Box::new(Diagnostic::new(span, problem)))
    }

    /// Ends the piece; the next one starts at `start` and has this header.
    fn cut(&mut self, end: usize, start: usize, header: Option<Range<usize>>) -> Piece {
        let from = std::mem::replace(&mut self.start, start);
        Piece {
            header: std::mem::replace(&mut self.header, header),
            body: from.min(end)..end,
        }
    }

    /// Reads a header, or keys up to their `=`; `None` at the end of the file.
    fn statement(&mut self) -> Option<Statement<'t>> {
        let mut statement: Option<Statement<'t>> = None;
        let (mut brackets, mut blank_lines) = (0, 0);
        for token in self.tokens.by_ref() {
            let (start, end) = (token.span().start(), token.span().end());
            match token.kind() {
                TokenKind::Newline | TokenKind::Eof if statement.is_none() => blank_lines += 1,
                TokenKind::Newline | TokenKind::Eof => break,
                TokenKind::Whitespace | TokenKind::Comment => {}
                kind => {
                    self.end = end;
                    let known = statement.get_or_insert(Statement {
                        start,
                        header_end: None,
                        keys: ["", ""],
                        count: 0,
                        blank_lines,
                    });
                    match kind {
                        TokenKind::Equals => break,
                        TokenKind::LeftSquareBracket => brackets += 1,
                        TokenKind::RightSquareBracket => known.header_end = Some(end),
                        TokenKind::Atom
                        | TokenKind::BasicString
                        | TokenKind::LiteralString
                        | TokenKind::MlBasicString
                        | TokenKind::MlLiteralString => {
                            if let Some(key) = known.keys.get_mut(known.count) {
                                *key = self.text[start..end].trim_matches(['"', '\'']);
                            }
                            known.count += 1;
                        }
                        TokenKind::Dot
                        | TokenKind::Comma
                        | TokenKind::LeftCurlyBracket
                        | TokenKind::RightCurlyBracket
                        | TokenKind::Whitespace
                        | TokenKind::Comment
                        | TokenKind::Newline
                        | TokenKind::Eof => {}
                    }
                }
            }
        }
        // What has a bracket, but none that closes it, is an error that the tree's parser finds.
        if let Some(statement) = &mut statement
            && brackets > 0
            && statement.header_end.is_none()
        {
            statement.header_end = Some(statement.start);
        }
        statement
    }

    /// Reads a value to the end of its line.
    fn value(&mut self) -> Result<(), Box<Diagnostic>> {
        self.open.clear();
        for token in self.tokens.by_ref() {
            self.end = token.span().end();
            match token.kind() {
                TokenKind::Newline if self.open.is_empty() => break,
                TokenKind::Comma | TokenKind::Equals | TokenKind::Newline => self.values += 1,
                kind @ (TokenKind::LeftSquareBracket | TokenKind::LeftCurlyBracket) => {
                    self.values += 1;
                    self.open.push(kind);
                }
                TokenKind::RightSquareBracket => {
                    self.open
                        .pop_if(|kind| *kind == TokenKind::LeftSquareBracket);
                }
                TokenKind::RightCurlyBracket => {
                    self.open
                        .pop_if(|kind| *kind == TokenKind::LeftCurlyBracket);
                }
                TokenKind::Dot
                | TokenKind::Whitespace
                | TokenKind::Comment
                | TokenKind::LiteralString
                | TokenKind::BasicString
                | TokenKind::MlLiteralString
                | TokenKind::MlBasicString
                | TokenKind::Atom
                | TokenKind::Eof => {}
            }
            if self.values > MOST_VALUES {
                let message = format!(
                    "more than {MOST_VALUES} values in one entry; put long curves and triangles \
                     into files of their own; or is a bracket not closed?"
                );
                let end = self.text.ceil_char_boundary(self.entry_start + 1);
                let span = Span::from(self.entry_start..end);
                return Err(Box::new(Diagnostic::new(span, Problem::Conflict(message))));
            }
        }
        Ok(())
    }
}

/// Whether a section is one that has no entries: it is not parted.
fn is_undivided(section: &str) -> bool {
    SECTIONS.contains(&section) && !ENTRIES.contains(&section)
}
