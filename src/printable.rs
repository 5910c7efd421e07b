//! Text from files and command lines as it may be shown on a terminal.
//!
//! A name in a file may hold anything: escape sequences that steer the terminal, line ends that fake
//! a message, characters that turn the direction of writing, or a megabyte of text. Whatever a message
//! quotes goes through here.

use std::path::Path;

/// A text that is longer, in characters, loses its middle: both ends of a name or a path tell more.
const LONGEST: usize = 240;

/// The length in characters above which a quoted name is shortened in messages.
pub(crate) const QUOTED_LENGTH: usize = 60;

/// `text` with escapes for all that does not print, such as `\u{1b}`, and without its middle where it
/// is longer than 240 characters.
pub fn printable(text: &str) -> String {
    let count = text.chars().count();
    if count <= LONGEST {
        return text.chars().map(Escaped).map(String::from).collect();
    }
    let half = LONGEST / 2;
    let start = text.chars().take(half);
    let end = text.chars().skip(count - (LONGEST - half - 1));
    let escaped = |characters: &mut dyn Iterator<Item = char>| -> String {
        characters.map(Escaped).map(String::from).collect()
    };
    escaped(&mut { start }) + "…" + &escaped(&mut { end })
}

/// `text` for a message: [`printable`], and without its end where it is a long one.
pub(crate) fn shortened(text: &str) -> String {
    match text.char_indices().nth(QUOTED_LENGTH) {
        Some((end, _)) => printable(&text[..end]) + "…",
        None => printable(text),
    }
}

/// Bytes of a file in a message: cut to a readable length, with escapes for what cannot be printed.
pub(crate) fn excerpt(bytes: &[u8]) -> String {
    const READABLE: usize = 40;
    let mut text = bytes[..bytes.len().min(READABLE)]
        .escape_ascii()
        .to_string();
    if bytes.len() > READABLE {
        text.push('…');
    }
    text
}

/// A file's name as [`printable`] text.
pub fn printable_path(path: &Path) -> String {
    printable(&path.to_string_lossy())
}

/// Bytes that should be UTF-8, as [`printable`] text; what is not becomes U+FFFD.
pub(crate) fn printable_bytes(bytes: &[u8]) -> String {
    printable(&String::from_utf8_lossy(bytes))
}

/// Whether a character prints as itself, and does nothing else to a terminal.
pub fn is_printable(character: char) -> bool {
    !steers(character)
}

/// A text as one word of a POSIX shell: in single quotes (XCU 2.2.2) where it holds more than plain letters.
pub fn shell_word(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "/._-+:,=".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        return text.to_owned();
    }
    format!("'{}'", text.replace('\'', r"'\''"))
}

/// A count with its noun: `1 triangle`, `2 triangles`.
pub fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{count} {}", if count == 1 { one } else { many })
}

/// A character that is written as an escape where it would not print as itself.
struct Escaped(char);

impl From<Escaped> for String {
    fn from(Escaped(character): Escaped) -> Self {
        if steers(character) {
            character.escape_default().collect()
        } else {
            character.into()
        }
    }
}

/// Whether a character moves the cursor, ends a line or changes the direction of writing.
fn steers(character: char) -> bool {
    character.is_control()
        || matches!(
            character,
            // Line and paragraph separators, and the controls of bidirectional text (UAX #9).
            '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}'
                // A byte order mark amid a text is invisible.
                | '\u{feff}'
        )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_no_plural() {
        let counted = |count| counted(count, "vertex", "vertices");
        assert_eq!(
            [0, 1, 2].map(counted),
            ["0 vertices", "1 vertex", "2 vertices"]
        );
    }

    #[test]
    fn plain_text_is_as_it_is() {
        for text in [
            "",
            "light_key.R",
            "Füll.光",
            "a path/with spaces.exr",
            &"x".repeat(240),
        ] {
            assert_eq!(printable(text), text);
        }
    }

    #[test]
    fn what_steers_a_terminal_is_escaped() {
        assert_eq!(printable("a\u{1b}[31mb\u{7}\r\n"), r"a\u{1b}[31mb\u{7}\r\n");
        assert_eq!(
            printable("a\u{9b}b\u{202e}c\u{2028}"),
            r"a\u{9b}b\u{202e}c\u{2028}"
        );
        assert_eq!(printable_bytes(b"a\xffb\x1b"), "a\u{fffd}b\\u{1b}");
        assert_eq!(printable_path(Path::new("a\nb.exr")), r"a\nb.exr");
    }

    #[test]
    fn characters_that_print_are_told() {
        for character in ['a', ' ', 'é', '光', '\u{fffd}'] {
            assert!(is_printable(character), "{character:?}");
        }
        for character in ['\n', '\t', '\u{7f}', '\u{9b}', '\u{202e}', '\u{2066}'] {
            assert!(!is_printable(character), "{character:?}");
        }
    }

    #[test]
    fn long_text_loses_its_middle() {
        let long = format!("{}{}", "a".repeat(100_000), "z".repeat(100_000));
        let short = printable(&long);
        assert_eq!(short, format!("{}…{}", "a".repeat(120), "z".repeat(119)));
    }
}
