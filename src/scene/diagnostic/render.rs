//! Diagnostics as text: the line of the file, a caret under the place, and the way out.

use std::ops::Range;
use std::path::{Path, PathBuf};

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};

use super::super::{Part, Source};
use super::{Diagnostic, Diagnostics, MOST_COLLECTED, Problem, Span};
use crate::printable::{is_printable, printable_path};

/// How many errors are printed; whoever has more mends these first.
const PRINTED: usize = 20;

/// The width that lines of the file are shortened to, in characters.
const WIDTH: usize = 100;

/// The length of a line in bytes above which it is not shown, not even in part: looking at every
/// character of a line of 100 MB takes longer than the user waits.
const LONGEST_LINE: usize = 100_000;

impl Diagnostics {
    /// All messages, each with its line of the file, without a newline at the end.
    ///
    /// `color` is for terminals: ANSI escapes.
    pub fn render(&self, color: bool) -> String {
        let renderer = if color {
            Renderer::styled().hyperlink(false)
        } else {
            Renderer::plain()
        }
        .term_width(WIDTH);
        let mut messages: Vec<String> = self
            .list
            .iter()
            .take(PRINTED)
            .map(|diagnostic| diagnostic.render(&renderer, &self.source))
            .collect();
        match self.list.len().saturating_sub(PRINTED) {
            0 => {}
            1 => messages.push("and 1 more error".to_owned()),
            more if self.list.len() >= MOST_COLLECTED => {
                messages.push(format!("and at least {more} more errors"));
            }
            more => messages.push(format!("and {more} more errors")),
        }
        messages.join("\n\n")
    }
}

impl Diagnostic {
    fn render(&self, renderer: &Renderer, source: &Source) -> String {
        let path = printable_path(source.at(self.span.start).0);
        let mut group = Group::with_title(Level::ERROR.primary_title(self.to_string()));
        group = match place(source, self.span) {
            Place::None => group.element(Origin::path(path.clone())),
            Place::Unshown { line, column } => {
                group.element(Origin::path(path.clone()).line(line).char_column(column))
            }
            Place::Line { text, line, span } => group.element(
                Snippet::source(text)
                    .line_start(line)
                    .path(path.clone())
                    .annotation(
                        AnnotationKind::Primary
                            .span(span.start..span.end)
                            .label(self.problem.label()),
                    ),
            ),
        };
        if let Problem::Duplicate {
            first: Some(first), ..
        } = self.problem
            && let Place::Line { text, line, span } = place(source, first)
        {
            group = group.element(
                Snippet::source(text)
                    .line_start(line)
                    .path(printable_path(source.at(first.start).0))
                    .annotation(
                        AnnotationKind::Context
                            .span(span.start..span.end)
                            .label("first here"),
                    ),
            );
        }
        if let Some(help) = self.problem.help() {
            group = group.element(Level::HELP.message(help));
        } else if self.is_between_smooth_keys(&source.text) {
            let help = "between keys, `smooth` may go beyond them; `linear` does not";
            group = group.element(Level::HELP.message(help));
        }
        unsteered(&renderer.render(&[group]))
    }
}

impl Diagnostic {
    /// Whether it is about a value that may be out of range where the values of its keys are not.
    fn is_between_smooth_keys(&self, text: &str) -> bool {
        let is_out = matches!(self.problem, Problem::OutOfRange { .. });
        let written = text.get(self.span.start..self.span.end);
        self.frame.is_some() && is_out && written.is_some_and(|text| text.contains("\"smooth\""))
    }
}

/// A message without what the renderer takes over from the line of the file and would steer a terminal. It
/// replaces ESC and its like itself, and makes those that color the message.
fn unsteered(message: &str) -> String {
    let is_kept = |character| matches!(character, '\n' | '\u{1b}') || is_printable(character);
    let kept = |character| {
        if is_kept(character) {
            character
        } else {
            '\u{fffd}'
        }
    };
    message.chars().map(kept).collect()
}

/// Where a span is, as far as it can be shown.
enum Place<'a> {
    /// It concerns the file as a whole.
    None,
    /// On a line too long to show.
    Unshown { line: usize, column: usize },
    /// On this line; a span of several lines is cut at the end of its first.
    Line {
        text: &'a str,
        line: usize,
        span: Span,
    },
}

fn place(source: &Source, span: Span) -> Place<'_> {
    if span == Span::default() {
        return Place::None;
    }
    let (_, part) = source.at(span.start);
    let text = &source.text[..part.end];
    let offset = text.floor_char_boundary(span.start);
    let start = text[..offset].rfind('\n').map_or(0, |newline| newline + 1);
    let rest = &text[start..];
    let content = rest.split('\n').next().unwrap_or(rest);
    let content = content.strip_suffix('\r').unwrap_or(content);
    if content.len() > LONGEST_LINE {
        let (line, column) = source.line_column(offset);
        return Place::Unshown { line, column };
    }
    let from = (offset - start).min(content.len());
    let to = content.floor_char_boundary(span.end.saturating_sub(start));
    Place::Line {
        text: content,
        line: source.line_column(start).0,
        span: Span {
            start: from,
            end: to.max(from),
        },
    }
}

impl Source {
    /// The text of a scene file that is all that there is.
    pub const fn new(path: PathBuf, text: String) -> Self {
        Self {
            path,
            text,
            parts: Vec::new(),
        }
    }

    /// The text of the scene file itself.
    pub fn own_text(&self) -> &str {
        &self.text[self.own()]
    }

    /// What was set on the command line.
    pub fn set(&self) -> impl Iterator<Item = &str> {
        let set = self.parts.iter().filter(|part| part.is_set);
        set.map(|part| &self.text[part.range.clone()])
    }

    /// What messages call the text that a byte belongs to, and where that text is.
    pub fn at(&self, offset: usize) -> (&Path, Range<usize>) {
        // Each text ends with a byte of its own, which its end may stand for.
        let is_in = |part: &&Part| part.range.start <= offset;
        match self.parts.iter().rfind(is_in) {
            Some(part) => (&part.name, part.range.clone()),
            None => (&self.path, self.own()),
        }
    }

    fn own(&self) -> Range<usize> {
        // A line feed parts it from what comes after it.
        let end = self.parts.first().map(|part| part.range.start - 1);
        0..end.unwrap_or(self.text.len())
    }

    /// The line and the column, in characters, of a byte of the text; both from 1.
    pub fn line_column(&self, offset: usize) -> (usize, usize) {
        let (_, part) = self.at(offset);
        let before = &self.text[part.start..self.text.floor_char_boundary(offset)];
        let line = before.bytes().filter(|&byte| byte == b'\n').count() + 1;
        let start = before.rfind('\n').map_or(0, |newline| newline + 1);
        (line, before[start..].chars().count() + 1)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    fn rendered(text: &str, span: Span, problem: Problem) -> String {
        let source = Arc::new(Source::new("scene.toml".into(), text.to_owned()));
        let list = vec![Diagnostic::new(span, problem)];
        Diagnostics::new(source, list).unwrap().to_string()
    }

    fn at(text: &str, part: &str) -> Span {
        let start = text.find(part).unwrap();
        Span::from(start..start + part.len())
    }

    #[test]
    fn caret_under_the_place() {
        let text = "[image]\nresolution = 7\n";
        let problem = Problem::Syntax("wrong".to_owned());
        assert_eq!(
            rendered(text, at(text, "7"), problem),
            "error: wrong\n \
             --> scene.toml:2:14\n  \
             |\n\
             2 | resolution = 7\n  \
             |              ^"
        );
    }

    #[test]
    fn windows_line_ends_tabs_and_wide_characters() {
        let text = "# 漢字\r\n\té = \"漢字\" + ü\r\n";
        let problem = Problem::Syntax("wrong".to_owned());
        assert_eq!(
            rendered(text, at(text, "ü"), problem),
            "error: wrong\n \
             --> scene.toml:2:13\n  \
             |\n\
             2 |     é = \"漢字\" + ü\n  \
             |                  ^"
        );
    }

    #[test]
    fn a_span_of_several_lines_shows_the_first() {
        let text = "a = [\n1,\n2]\n";
        let problem = Problem::Syntax("wrong".to_owned());
        let shown = rendered(text, at(text, "[\n1,\n2]"), problem);
        assert!(shown.ends_with("1 | a = [\n  |     ^"), "{shown}");
    }

    #[test]
    fn the_end_of_the_file_is_a_place() {
        for text in ["a", "a\n", "a\r\n", "ä"] {
            let end = Span::from(text.len()..text.len());
            let shown = rendered(text, end, Problem::Syntax("wrong".to_owned()));
            assert!(shown.ends_with('^'), "{shown}");
        }
    }

    #[test]
    fn long_lines_are_shortened_around_the_place() {
        let text = format!("a = [{} x]", "1, ".repeat(10_000));
        let shown = rendered(&text, at(&text, "x"), Problem::Syntax("wrong".to_owned()));
        assert!(shown.contains("scene.toml:1:30007"), "{shown}");
        assert!(shown.contains("1, 1,  x]"), "{shown}");
        let longest = shown.lines().map(|line| line.chars().count()).max();
        assert!(longest <= Some(WIDTH + 10), "{longest:?}");
    }

    #[test]
    fn endless_lines_are_not_shown() {
        let text = format!("a = \"{}\" x", "é".repeat(LONGEST_LINE));
        assert_eq!(
            rendered(&text, at(&text, "x"), Problem::Syntax("wrong".to_owned())),
            "error: wrong\n--> scene.toml:1:100008"
        );
    }

    #[test]
    fn what_has_no_place_names_the_file() {
        assert_eq!(
            rendered("", Span::default(), Problem::Syntax("wrong".to_owned())),
            "error: wrong\n--> scene.toml"
        );
    }

    #[test]
    fn twenty_are_printed_and_the_rest_counted() {
        let source = Arc::new(Source::new("scene.toml".into(), "x\n".repeat(50)));
        let list = (0..50)
            .rev()
            .map(|i| Diagnostic::new(Span::from(2 * i..2 * i + 1), Problem::Empty))
            .collect();
        let text = Diagnostics::new(source, list).unwrap().to_string();
        assert_eq!(text.matches("error: ").count(), PRINTED);
        assert!(text.ends_with("\n\nand 30 more errors"), "{text}");
        // In the order of the file, whatever order they were found in.
        assert!(text.find("toml:2:1") < text.find("toml:20:1"));
    }

    /// The renderer itself knows nothing of CSI in one character and of directions of writing.
    #[test]
    fn what_steers_a_terminal_is_replaced_in_lines() {
        let text = "a = \"\u{1b}[31m\u{9b}31m\u{202e}\u{2028}\" x\n";
        for color in [false, true] {
            let source = Source::new("a\u{1b}\u{9b}.toml".into(), text.to_owned());
            let source = Arc::new(source);
            let problem = Problem::Syntax("wrong".to_owned());
            let list = vec![Diagnostic::new(at(text, "x"), problem)];
            let shown = Diagnostics::new(source, list).unwrap().render(color);
            assert!(
                shown.contains("␛[31m\u{fffd}31m\u{fffd}\u{fffd}"),
                "{shown:?}"
            );
            assert!(shown.contains(r"a\u{1b}\u{9b}.toml"), "{shown:?}");
            if !color {
                let caret = shown.lines().last().unwrap();
                assert!(
                    caret.ends_with('^') && !shown.contains('\u{1b}'),
                    "{shown:?}"
                );
            }
        }
    }

    #[test]
    fn color_is_only_for_terminals() {
        let source = Arc::new(Source::new("scene.toml".into(), "x".to_owned()));
        let list = vec![Diagnostic::new(Span::from(0..1), Problem::Empty)];
        let diagnostics = Diagnostics::new(source, list).unwrap();
        assert!(diagnostics.render(true).contains('\u{1b}'));
        assert!(!diagnostics.render(false).contains('\u{1b}'));
    }
}
