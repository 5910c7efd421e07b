//! The numbers behind `TILT=`: free format, parted by blanks, commas and line ends.
//!
//! LM-63-02, section 3, lists the delimiters: a comma, spaces, a line end. Where a number stands within a
//! line means nothing to this reader, so that numbers split anywhere and lines of any length are read.

use super::error::{Fault, Problem};

/// What a comma between two digits is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Commas {
    /// A delimiter, as the standard has it.
    Delimit,
    /// A decimal point, as programs in half of Europe write it.
    Decimal,
}

/// A word between delimiters, and where it starts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Word<'a> {
    pub(super) text: &'a [u8],
    pub(super) offset: usize,
}

/// A number, and where it starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Number {
    pub(super) value: f64,
    pub(super) offset: usize,
}

/// A position among the numbers of a text.
#[derive(Clone, Debug)]
pub(super) struct Numbers<'a> {
    bytes: &'a [u8],
    position: usize,
    commas: Commas,
    /// Commas that were decimal points so far.
    pub(super) decimal_commas: u32,
    /// Exponents behind a D so far.
    pub(super) fortran_exponents: u32,
}

/// Blanks, line ends, and what programs leave at the end of a file: NUL, and the mark by which DOS ends a
/// text, 0x1A.
const fn is_blank(byte: u8) -> bool {
    matches!(
        byte,
        b' ' | b'\t' | b'\n' | b'\r' | b'\x0b' | b'\x0c' | b'\x1a' | b'\0'
    )
}

impl<'a> Numbers<'a> {
    /// From `position` on.
    pub(super) const fn new(bytes: &'a [u8], position: usize, commas: Commas) -> Self {
        Self {
            bytes,
            position,
            commas,
            decimal_commas: 0,
            fortran_exponents: 0,
        }
    }

    /// Where the next word is looked for.
    pub(super) const fn position(&self) -> usize {
        self.position
    }

    /// Whether the comma at `i` is a decimal point: digits on both sides.
    fn is_point(&self, i: usize) -> bool {
        self.commas == Commas::Decimal && is_between_digits(self.bytes, i)
    }

    fn is_delimiter(&self, i: usize) -> bool {
        match self.bytes[i] {
            b',' => !self.is_point(i),
            byte => is_blank(byte),
        }
    }

    /// The next word, if there is one.
    pub(super) fn word(&mut self) -> Option<Word<'a>> {
        let end = self.bytes.len();
        let offset = (self.position..end).find(|&i| !self.is_delimiter(i));
        let offset = offset.unwrap_or(end);
        self.position = (offset..end).find(|&i| self.is_delimiter(i)).unwrap_or(end);
        (offset < end).then(|| Word {
            text: &self.bytes[offset..self.position],
            offset,
        })
    }

    /// The next number.
    pub(super) fn next(&mut self, expected: &'static str) -> Result<Number, Problem> {
        let Some(word) = self.word() else {
            let fault = Fault::FileEnds { expected };
            return Err(Problem::new(self.bytes.len(), fault));
        };
        let offset = word.offset;
        let Some(value) = number(word.text) else {
            return Err(Problem::unexpected(offset, word.text, expected));
        };
        if self.commas == Commas::Decimal && word.text.contains(&b',') {
            self.decimal_commas = self.decimal_commas.saturating_add(1);
        }
        if word.text.iter().any(is_fortran_exponent) {
            self.fortran_exponents = self.fortran_exponents.saturating_add(1);
        }
        Ok(Number { value, offset })
    }

    /// How many words follow, counted up to `most`.
    pub(super) fn count(&self, most: usize) -> usize {
        let mut ahead = self.clone();
        (0..most).take_while(|_| ahead.word().is_some()).count()
    }

    /// What is behind the last number that is needed: numbers, and bytes from the first other word on.
    pub(super) fn rest(&mut self) -> (u64, u64) {
        let mut extra = 0;
        while let Some(word) = self.word() {
            if number(word.text).is_none() {
                let end = self.bytes.iter().rposition(|&byte| !is_blank(byte));
                let end = end.map_or(0, |last| last + 1);
                return (extra, end.saturating_sub(word.offset) as u64);
            }
            extra += 1;
        }
        (extra, 0)
    }
}

/// The finite decimal number that a word is. One comma may be its decimal point, and D may be before its exponent.
pub(super) fn number(word: &[u8]) -> Option<f64> {
    let is_part = |&byte: &u8| byte.is_ascii_digit() || b"+-.eEdD,".contains(&byte);
    if !word.iter().all(is_part) {
        return None;
    }
    let text = std::str::from_utf8(word).ok()?;
    let is_plain = |&byte: &u8| byte != b',' && !is_fortran_exponent(&byte);
    let value: f64 = if word.iter().all(is_plain) {
        text.parse().ok()?
    } else {
        let text = text.replacen(',', ".", 1).replacen(['d', 'D'], "e", 1);
        text.parse().ok()?
    };
    value.is_finite().then_some(value)
}

/// As programs in Fortran write numbers of double precision: `8.0D1`.
const fn is_fortran_exponent(byte: &u8) -> bool {
    matches!(byte, b'd' | b'D')
}

/// Where the first comma stands that may be a decimal point, from `start` on.
pub(super) fn first_tight_comma(bytes: &[u8], start: usize) -> Option<usize> {
    (start..bytes.len()).find(|&i| bytes[i] == b',' && is_between_digits(bytes, i))
}

fn is_between_digits(bytes: &[u8], i: usize) -> bool {
    let is_digit = |i: usize| bytes.get(i).is_some_and(u8::is_ascii_digit);
    i > 0 && is_digit(i - 1) && is_digit(i + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(text: &str, commas: Commas) -> Vec<f64> {
        let mut numbers = Numbers::new(text.as_bytes(), 0, commas);
        let count = numbers.count(usize::MAX);
        (0..count)
            .map(|_| numbers.next("a number").unwrap().value)
            .collect()
    }

    #[test]
    fn forms_of_numbers() {
        let text = "1.0E+3 .5 +5 5. -0.25 1e2\r\n7\t8\x0c9\r10";
        let expected = [1000.0, 0.5, 5.0, 5.0, -0.25, 100.0, 7.0, 8.0, 9.0, 10.0];
        assert_eq!(all(text, Commas::Delimit), expected);
        for other in [
            "", "x", "1x", "inf", "nan", "1e999", "0x1", "1.2.3", "--1", "1,2,3", "é",
        ] {
            assert_eq!(number(other.as_bytes()), None, "{other}");
        }
    }

    #[test]
    fn commas_part_numbers_or_are_points() {
        let text = "1,5, 2,0 ,3,,4";
        assert_eq!(all(text, Commas::Delimit), [1.0, 5.0, 2.0, 0.0, 3.0, 4.0]);
        assert_eq!(all(text, Commas::Decimal), [1.5, 2.0, 3.0, 4.0]);
        assert_eq!(first_tight_comma(text.as_bytes(), 0), Some(1));
        assert_eq!(first_tight_comma(b"1, 2 ,3,", 0), None);
    }

    #[test]
    fn what_is_behind_the_end() {
        let rest = |text: &str| Numbers::new(text.as_bytes(), 0, Commas::Delimit).rest();
        assert_eq!(rest(" \r\n\0\x1a"), (0, 0));
        assert_eq!(rest(" 1 2\n"), (2, 0));
        assert_eq!(rest(" 1 end 2 \n"), (1, 5));
    }
}
