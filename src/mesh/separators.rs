//! The bytes that part the words of a text: blanks and the ends of lines.

/// Whether a byte parts the values of a line.
#[inline]
pub(super) const fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t' | b'\x0b' | b'\x0c' | b'\x1a' | b'\0')
}

/// Whether a byte ends a value: a blank or the end of a line.
#[inline]
pub(super) const fn is_separator(byte: u8) -> bool {
    is_blank(byte) || matches!(byte, b'\n' | b'\r')
}

/// The length of the line end that `bytes` start with, and of the blanks before it, if there is one.
pub(super) fn line_end_ahead(bytes: &[u8]) -> Option<usize> {
    let blanks = bytes.iter().take_while(|&&byte| is_blank(byte)).count();
    match &bytes[blanks..] {
        [b'\r', b'\n', ..] => Some(blanks + 2),
        [b'\r' | b'\n', ..] => Some(blanks + 1),
        _ => None,
    }
}
