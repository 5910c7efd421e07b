//! Lines and words of text, scanned byte by byte.

use super::decimal::{decimal_digit, parse_float, scan_float, whole};
use super::error::Fault;
use super::separators::{is_blank, is_separator, line_end_ahead};

/// A position in the bytes of a text, with the rules of its format.
///
/// Lines end in LF, CR LF or, as on the first Macintoshes, CR alone. Blanks are the usual ones and
/// what programs leave at the end of a file: NUL, and the mark by which DOS ends a text, 0x1A.
#[derive(Clone, Debug)]
pub(super) struct Scanner<'a> {
    bytes: &'a [u8],
    position: usize,
    dialect: Dialect,
}

/// What differs between the text formats.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dialect {
    /// Nothing but values on a line.
    Ply,
    /// As [`Dialect::Ply`], but line ends are blanks.
    UnlinedPly,
    /// `#` starts a comment, `\` at the end of a line joins the next one to it.
    Obj,
}

/// What stands where an index belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Index {
    Number(i64),
    /// Something else.
    Other,
}

impl<'a> Scanner<'a> {
    /// From the start of a text.
    pub(super) const fn new(bytes: &'a [u8], dialect: Dialect) -> Self {
        Self {
            bytes,
            position: 0,
            dialect,
        }
    }

    /// The rules that it follows.
    pub(super) const fn dialect(&self) -> Dialect {
        self.dialect
    }

    /// The byte that is next.
    pub(super) const fn position(&self) -> usize {
        self.position
    }

    /// The bytes that are left.
    pub(super) fn rest(&self) -> &'a [u8] {
        &self.bytes[self.position..]
    }

    #[inline]
    fn peek(&self) -> Option<u8> {
        self.bytes.get(self.position).copied()
    }

    /// Goes to the next byte that is not blank, on this line.
    #[inline]
    pub(super) fn skip_blanks(&mut self) {
        loop {
            match self.peek() {
                Some(byte) if is_blank(byte) => self.position += 1,
                Some(b'\n' | b'\r') if self.dialect == Dialect::UnlinedPly => self.position += 1,
                Some(b'\\') if self.dialect == Dialect::Obj => {
                    let Some(length) = line_end_ahead(&self.bytes[self.position + 1..]) else {
                        return;
                    };
                    self.position += 1 + length;
                }
                _ => return,
            }
        }
    }

    /// Goes to the first line from here that is not empty; whether there is one.
    pub(super) fn skip_empty_lines(&mut self) -> bool {
        loop {
            self.skip_blanks();
            match self.peek() {
                Some(b'\n' | b'\r') => self.position += 1,
                Some(_) => return true,
                None => return false,
            }
        }
    }

    /// Whether nothing more stands on this line but a comment.
    #[inline]
    pub(super) fn at_line_end(&mut self) -> bool {
        self.skip_blanks();
        match self.peek() {
            None | Some(b'\n' | b'\r') => true,
            Some(b'#') => self.dialect == Dialect::Obj,
            Some(_) => false,
        }
    }

    /// Goes to the next line, where nothing more stands on this one.
    #[inline]
    pub(super) fn end_line(&mut self, expected: &'static str) -> Result<(), Box<Fault>> {
        if !self.at_line_end() {
            return Err(Fault::unexpected(self.token(), expected));
        }
        if self.peek() == Some(b'\n') {
            self.position += 1;
        } else {
            self.skip_line();
        }
        Ok(())
    }

    /// Goes past `count` values on this line, whatever they are; whether all are there.
    pub(super) fn skip_words(&mut self, count: usize) -> bool {
        (0..count).all(|_| !self.at_line_end() && !self.word().is_empty())
    }

    /// Goes to the next line, whatever stands on this one; what stood on it.
    pub(super) fn skip_line(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let length = rest.iter().position(|&byte| byte == b'\n' || byte == b'\r');
        let line = &rest[..length.unwrap_or(rest.len())];
        self.position += line.len();
        self.accept(b'\r');
        self.accept(b'\n');
        line
    }

    /// Goes past this line and those that `\` joins to it, if that is before a comment.
    pub(super) fn skip_joined_lines(&mut self) {
        let is_joined = |line: &[u8]| {
            let statement = line.split(|&byte| byte == b'#').next().unwrap_or(line);
            statement.trim_ascii_end().ends_with(b"\\")
        };
        while is_joined(self.skip_line()) {}
    }

    /// The bytes up to the next blank or line end.
    pub(super) fn token(&self) -> &'a [u8] {
        let rest = self.rest();
        let length = rest.iter().position(|&byte| is_separator(byte));
        &rest[..length.unwrap_or(rest.len())]
    }

    /// Goes past the next word on this line; the word.
    pub(super) fn word(&mut self) -> &'a [u8] {
        self.skip_blanks();
        let word = self.token();
        self.position += word.len();
        word
    }

    /// Whether `byte` is next; goes past it if so.
    #[inline]
    pub(super) fn accept(&mut self, byte: u8) -> bool {
        let next = self.peek() == Some(byte);
        self.position += usize::from(next);
        next
    }

    /// The next number on this line, as the f64 nearest to its decimal text.
    #[inline]
    pub(super) fn float(&mut self, expected: &'static str) -> Result<f64, Box<Fault>> {
        self.skip_blanks();
        let (value, length) = match scan_float(self.rest()) {
            Some(scanned) => scanned,
            None => self.slow_float(expected)?,
        };
        self.position += length;
        Ok(value)
    }

    /// Numbers that take more than one exact operation, and what is no number at all.
    #[cold]
    fn slow_float(&self, expected: &'static str) -> Result<(f64, usize), Box<Fault>> {
        let token = self.token();
        let token = token.strip_suffix(b"\\").unwrap_or(token);
        if token.is_empty() {
            return Err(self.nothing(expected));
        }
        if let Some(value) = parse_float(token) {
            return Ok((value, token.len()));
        }
        // A comment may follow without a blank. Not before the above: `1.#INF` is a number.
        let before_comment = token.split(|&byte| byte == b'#').next().unwrap_or(token);
        match parse_float(before_comment) {
            Some(value) if self.dialect == Dialect::Obj => Ok((value, before_comment.len())),
            Some(_) | None => Err(Fault::unexpected(token, expected)),
        }
    }

    /// The next integer on this line; what follows it directly is not looked at.
    #[inline]
    pub(super) fn integer_prefix(&mut self, expected: &'static str) -> Result<i64, Box<Fault>> {
        /// Digits that fit in i64 in any case.
        const MOST_DIGITS: usize = 18;
        self.skip_blanks();
        let rest = self.rest();
        let negative = rest.first() == Some(&b'-');
        let sign = usize::from(negative || rest.first() == Some(&b'+'));
        let mut value = 0_i64;
        let mut length = sign;
        while let Some(digit) = rest.get(length).and_then(|&byte| decimal_digit(byte)) {
            if length - sign == MOST_DIGITS {
                return Err(Fault::unexpected(self.token(), expected));
            }
            value = value * 10 + i64::from(digit);
            length += 1;
        }
        if length == sign {
            return Err(match self.token() {
                [] => self.nothing(expected),
                token => Fault::unexpected(token, expected),
            });
        }
        self.position += length;
        Ok(if negative { -value } else { value })
    }

    /// The next integer on this line, with a blank or the line's end after it. It may be written
    /// as a number with nothing but zeros after the point.
    #[inline]
    pub(super) fn integer(&mut self, expected: &'static str) -> Result<i64, Box<Fault>> {
        self.skip_blanks();
        let start = self.position;
        if let Ok(value) = self.integer_prefix(expected)
            && self.peek().is_none_or(is_separator)
        {
            return Ok(value);
        }
        self.position = start;
        self.whole_float(expected)
    }

    /// The next number on this line, if it is an integer all the same.
    #[cold]
    fn whole_float(&mut self, expected: &'static str) -> Result<i64, Box<Fault>> {
        let start = self.position;
        let value = self.float(expected)?;
        whole(value).ok_or_else(|| {
            self.position = start;
            Fault::unexpected(self.token(), expected)
        })
    }

    /// Goes past the index that starts at the next byte, with no blank before it, up to a slash or the
    /// end of the word; `None` where none stands there.
    #[inline]
    pub(super) fn index(&mut self) -> Option<Index> {
        let start = self.position;
        let value = match self.peek() {
            Some(b'-' | b'+' | b'0'..=b'9') => self.integer_prefix("").ok(),
            _ => None,
        };
        // As nearly always.
        if let (Some(_), Some(b'/' | b' ' | b'\n')) = (value, self.peek()) {
            return value.map(Index::Number);
        }
        let is_end = |byte| is_separator(byte) || matches!(byte, b'/' | b'\\' | b'#');
        if self.peek().is_none_or(is_end) {
            return if self.position == start {
                None
            } else {
                value.map(Index::Number)
            };
        }
        while self.peek().is_some_and(|byte| !is_end(byte)) {
            self.position += 1;
        }
        Some(Index::Other)
    }

    /// Goes past the slashes that end a word, behind which nothing stands.
    #[inline]
    pub(super) fn skip_empty_places(&mut self) {
        if self.peek() == Some(b'/') {
            let slashes = self.rest().iter().take_while(|&&byte| byte == b'/').count();
            let after = self.bytes.get(self.position + slashes);
            if after.is_none_or(|&byte| is_separator(byte) || matches!(byte, b'\\' | b'#')) {
                self.position += slashes;
            }
        }
    }

    /// Nothing but a blank, a line end, a comment or a line joined by `\` may follow.
    #[inline]
    pub(super) fn end_word(&self, expected: &'static str) -> Result<(), Box<Fault>> {
        match self.peek() {
            None | Some(b' ' | b'\n' | b'\r' | b'\\' | b'#') => Ok(()),
            Some(byte) if is_blank(byte) => Ok(()),
            Some(_) => Err(Fault::unexpected(self.token(), expected)),
        }
    }

    /// The fault of a value that is not there.
    #[cold]
    fn nothing(&self, expected: &'static str) -> Box<Fault> {
        Box::new(if self.peek().is_none() {
            Fault::FileEnds { expected }
        } else {
            Fault::LineEnds { expected }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn float(text: &str) -> Result<f64, Box<Fault>> {
        Scanner::new(text.as_bytes(), Dialect::Ply).float("a number")
    }

    /// A small generator with a full period, so that the tests are the same everywhere.
    fn splitmix64(state: &mut u64) -> u64 {
        *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = *state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// The standard library rounds exactly; so must every text here.
    #[track_caller]
    fn same_as_std(text: &str) {
        let expected: f64 = text.parse().unwrap();
        let scanned = float(text).unwrap();
        assert_eq!(scanned.to_bits(), expected.to_bits(), "{text}");
    }

    #[test]
    fn floats_are_the_nearest_f64_of_their_text() {
        let mut state = 1;
        for _ in 0..100_000 {
            let bits = splitmix64(&mut state);
            let any = f64::from_bits(bits);
            if any.is_finite() {
                same_as_std(&format!("{any}"));
                same_as_std(&format!("{any:e}"));
            }
            let single = f32::from_bits(bits as u32);
            if single.is_finite() {
                same_as_std(&format!("{single:e}"));
            }
            // As modeling programs write: a few digits before and after the point.
            let decimals = (bits % 12) as usize;
            let usual = (splitmix64(&mut state) as i64 as f64) / 2_f64.powi(50);
            same_as_std(&format!("{usual:.decimals$}"));
            // Around the limits of the fast path: 15 to 21 digits, exponents to ±30.
            let mantissa = u128::from(splitmix64(&mut state)) * 7;
            let exponent = (bits >> 32) as i32 % 31;
            same_as_std(&format!("{mantissa}e{exponent}"));
            same_as_std(&format!("-0.{}e{exponent:+}", mantissa >> (bits % 60)));
        }
    }

    #[test]
    fn float_forms() {
        for text in [
            "0",
            "-0",
            "+1",
            "1.",
            ".5",
            "-.5",
            "1e3",
            "1E+3",
            "1.5e-3",
            "1e22",
            "1e23",
            "9007199254740993",
            "9007199254740992",
            "1e-400",
            "1e400",
            "4.9e-324",
            "179769313486231570000000000000000000000e270",
            "00000000000000000000000000000000.1",
            "0.000000000000000000000000000000000000000000001",
            "inf",
            "-inf",
            "1e0003",
        ] {
            same_as_std(text);
        }
    }

    #[test]
    fn what_programs_print_for_infinity_and_nan() {
        for text in [
            "nan",
            "-nan",
            "+NaN",
            "NAN",
            "nan(ind)",
            "-nan(ind)",
            "nan(snan)",
            "-NAN(IND)",
            "nan(0x8000000000000)",
            "-nan(0xfffff)",
            "NaN0x7ff8000000000000",
            "NaNQ",
            "NaNS",
            "qNaN",
            "sNaN",
            "1.#IND",
            "-1.#IND",
            "1.#IND00",
            "-1.#IND000000",
            "1.#QNAN",
            "1.#SNAN",
            "-1.#QNAN0",
            "1.#QNAN00e+000",
            "1.#R",
        ] {
            assert!(float(text).unwrap().is_nan(), "{text}");
        }
        for text in [
            "inf",
            "Inf",
            "INF",
            "infinity",
            "Infinity",
            "INFINITY",
            "1.#INF",
            "1.#inf",
            "1.#INF00",
            "1.#INF00e+000",
            "∞",
        ] {
            for (sign, expected) in [("", 1.0), ("+", 1.0), ("-", -1.0)] {
                let text = format!("{sign}{text}");
                assert_eq!(float(&text).unwrap(), expected * f64::INFINITY, "{text}");
            }
        }
        for text in ["nano!", "1.#", "1#INF", "infinite", "nan nan,", "1.#IND.5"] {
            let first = text.split(' ').next().unwrap();
            assert_eq!(
                float(text).is_ok(),
                first == "nan" || first == "1.#",
                "{text}"
            );
        }
    }

    #[test]
    fn comments_without_a_blank() {
        let mut scanner = Scanner::new(b"1.5#x 2\n-nan(ind)# y\r1.#INF #", Dialect::Obj);
        assert_eq!(scanner.float("").unwrap(), 1.5);
        scanner.end_line("").unwrap();
        assert!(scanner.float("").unwrap().is_nan());
        scanner.end_line("").unwrap();
        assert_eq!(scanner.float("").unwrap(), f64::INFINITY);
        assert!(float("1.5#x").is_err());
    }

    #[test]
    fn what_is_no_float() {
        for text in [
            "x", "1x", "-", ".", "1e", "1e+", "0x10", "1,5", "--1", "1.2.3", "\u{e9}",
        ] {
            assert!(
                matches!(*float(text).unwrap_err(), Fault::Unexpected { .. }),
                "{text}"
            );
        }
        assert_eq!(
            *float("  ").unwrap_err(),
            Fault::FileEnds {
                expected: "a number"
            }
        );
        assert_eq!(
            *float(" \n1").unwrap_err(),
            Fault::LineEnds {
                expected: "a number"
            }
        );
    }

    #[test]
    fn integers() {
        let integer =
            |text: &str| Scanner::new(text.as_bytes(), Dialect::Ply).integer("an integer");
        assert_eq!(integer(" 42 ").unwrap(), 42);
        assert_eq!(integer("-7\n").unwrap(), -7);
        assert_eq!(integer("+7").unwrap(), 7);
        assert_eq!(
            integer("999999999999999999").unwrap(),
            999_999_999_999_999_999
        );
        assert_eq!(integer("3.000000000000000000e+00").unwrap(), 3);
        assert_eq!(integer("-1.0 ").unwrap(), -1);
        for text in ["1.5", "x", "-", "9999999999999999999", "1/2", "nan", "inf"] {
            assert!(
                matches!(*integer(text).unwrap_err(), Fault::Unexpected { .. }),
                "{text}"
            );
        }
    }

    #[test]
    fn lines_and_blanks() {
        let mut scanner = Scanner::new(b"1 \\\r\n 2 # three\n4", Dialect::Obj);
        assert_eq!(scanner.float("").unwrap(), 1.0);
        assert_eq!(scanner.float("").unwrap(), 2.0);
        scanner.end_line("").unwrap();
        assert_eq!(scanner.rest(), b"4");
        assert_eq!(scanner.integer("").unwrap(), 4);
        assert!(!scanner.skip_empty_lines());
    }

    #[test]
    fn found_text_is_cut_and_escaped() {
        let Fault::Unexpected { found, .. } = *Fault::unexpected(&[0xff; 1000], "") else {
            panic!("another fault");
        };
        assert_eq!(found, format!("{}…", "\\xff".repeat(40)));
    }
}
