//! Curves from files of two columns, wavelength in nm and value.

use std::fmt;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};

use super::diagnostic::shortened;
use super::inputs::Hash;
use crate::spectrum::{Curve, CurveProblem};

/// The largest curve file in bytes; a million points fit.
const LARGEST_FILE: u64 = 32_000_000;

/// Why a curve file cannot be used, with the line where it is one.
#[derive(Debug, thiserror::Error)]
pub enum CurveError {
    /// The file cannot be read.
    #[error("{0}")]
    Unreadable(io::Error),
    /// More text than a curve can have.
    #[error("the file is larger than {limit} MB", limit = LARGEST_FILE / 1_000_000)]
    TooLarge,
    /// Not text.
    #[error("the file is not UTF-8 text")]
    NotText,
    /// Another number of columns than two.
    #[error("line {line}: {columns}, expected two, wavelength in nm and value, parted by a comma", columns = Columns(*.columns))]
    Columns {
        /// Counted from 1.
        line: u64,
        /// How many there are.
        columns: usize,
    },
    /// Text where a number should be.
    #[error("line {line}: `{}` is not a number", shortened(text))]
    NotANumber {
        /// Counted from 1.
        line: u64,
        /// As written.
        text: String,
    },
    /// Points that do not make a curve.
    #[error("{}{problem}", at_line(*line))]
    Illegal {
        /// Counted from 1; `None` where it is about the curve as a whole.
        line: Option<u64>,
        /// What is wrong.
        problem: CurveProblem,
    },
}

/// "one column", "3 columns"
struct Columns(usize);

impl fmt::Display for Columns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            1 => f.write_str("one column"),
            columns => write!(f, "{columns} columns"),
        }
    }
}

fn at_line(line: Option<u64>) -> String {
    line.map_or_else(String::new, |line| format!("line {line}: "))
}

/// Reads a curve file: two columns parted by commas, semicolons or tabs; lines that start with `#`
/// are comments, and the first line may name the columns. Beside the curve, the hash of the file.
///
/// # Errors
/// A file that cannot be read, lines of other than two numbers, and points that do not make a
/// [`Curve`].
pub(super) fn load(path: &Path) -> Result<(Curve, Hash), CurveError> {
    let mut text = String::new();
    let file = File::open(path).map_err(CurveError::Unreadable)?;
    let read = file.take(LARGEST_FILE + 1).read_to_string(&mut text);
    match read {
        Ok(length) if length as u64 > LARGEST_FILE => Err(CurveError::TooLarge),
        Ok(_) => Ok((parse(&text)?, Hash::of(text.as_bytes()))),
        Err(error) if error.kind() == io::ErrorKind::InvalidData => Err(CurveError::NotText),
        Err(error) => Err(CurveError::Unreadable(error)),
    }
}

fn parse(text: &str) -> Result<Curve, CurveError> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut reader = ReaderBuilder::new()
        .delimiter(delimiter(text))
        .has_headers(false)
        .flexible(true)
        .comment(Some(b'#'))
        .trim(Trim::All)
        .from_reader(text.as_bytes());
    let (mut wavelengths, mut values, mut starts) = (Vec::new(), Vec::new(), Vec::new());
    let mut record = StringRecord::new();
    let mut is_first = true;
    while reader
        .read_record(&mut record)
        .map_err(|_| CurveError::NotText)?
    {
        // A line of blanks alone.
        if record.len() == 1 && record[0].is_empty() {
            continue;
        }
        let start = record.position().map_or(0, csv::Position::byte);
        let line = || line_of_record(text, start);
        let may_be_header = std::mem::take(&mut is_first);
        let [nm, value] = columns(&record, line)?;
        match (number(nm, line), number(value, line)) {
            (Ok(nm), Ok(value)) => {
                wavelengths.push(nm);
                values.push(value);
                starts.push(start);
            }
            (Err(_), Err(_)) if may_be_header => {}
            (Err(error), _) | (_, Err(error)) => return Err(error),
        }
    }
    Curve::new(wavelengths, values).map_err(|problem| CurveError::Illegal {
        line: problem
            .index()
            .map(|index| line_of_record(text, starts[index])),
        problem,
    })
}

/// What parts the columns: a semicolon or tab if the first line of data has one, else a comma.
fn delimiter(text: &str) -> u8 {
    let mut lines = text
        .lines()
        .filter(|line| !line.is_empty() && !line.starts_with('#'));
    let first = lines.next().unwrap_or_default();
    [b';', b'\t']
        .into_iter()
        .find(|&delimiter| first.contains(char::from(delimiter)))
        .unwrap_or(b',')
}

/// The line, counted from 1, of the record that the reader found when it went on at the byte
/// `start`. What it passed over is before it: the rest of a line's end, empty lines and comments.
fn line_of_record(text: &str, start: u64) -> u64 {
    let (before, rest) = text.split_at(start as usize);
    let passed = rest
        .lines()
        .take_while(|line| line.is_empty() || line.starts_with('#'));
    let line = 1 + before.matches('\n').count() + passed.count();
    line as u64
}

fn columns(record: &StringRecord, line: impl Fn() -> u64) -> Result<[&str; 2], CurveError> {
    let columns = record.len();
    match (record.get(0), record.get(1)) {
        (Some(nm), Some(value)) if columns == 2 => Ok([nm, value]),
        _ => Err(CurveError::Columns {
            line: line(),
            columns,
        }),
    }
}

fn number(text: &str, line: impl Fn() -> u64) -> Result<f64, CurveError> {
    text.parse().map_err(|_| CurveError::NotANumber {
        line: line(),
        text: text.to_owned(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_of_any_separator_with_header_and_comments() {
        let expected = Curve::new(vec![400.0, 500.5, 700.0], vec![0.1, 0.25, 1.0]).unwrap();
        for text in [
            "400,0.1\n500.5,.25\n700,1",
            "# measured\nnm, value\n400, 0.1\n# a comment\n\n500.5, 0.25\r\n700, 1e0\n",
            "\u{feff}nm;value\n400;0.1\n500.5;0.25\n700;1\n",
            "400\t0.1\n500.5\t0.25\n700\t1\n",
            "\"400\",\"0.1\"\n500.5,0.25\n700,1\n",
            "  \nnm,value\n400,0.1\n500.5,0.25\n  \n700,1\n  ",
        ] {
            assert_eq!(parse(text).unwrap(), expected, "{text}");
        }
    }

    #[test]
    fn what_is_wrong_has_its_line() {
        for (text, message) in [
            ("", "the curve has no points, expected at least 2"),
            (
                "nm,value\n400,1\n",
                "the curve has 1 point, expected at least 2",
            ),
            ("nm,value\nnm,value\n", "line 2: `nm` is not a number"),
            ("400,0.1\n500,red\n", "line 2: `red` is not a number"),
            (
                "nm,value\r\n400,0.1\r\n500,red\r\n",
                "line 3: `red` is not a number",
            ),
            (
                "400,0.1\n# a comment\n\n500,red\n",
                "line 4: `red` is not a number",
            ),
            (
                "\u{feff}nm,value\r\n400,0.1\r\n\r\n# a comment\r\n300,1\r\n",
                "line 5: the wavelength 300 nm comes after 400 nm, expected ascending order",
            ),
            (
                "400,0,1\n",
                "line 1: 3 columns, expected two, wavelength in nm and value, parted by a comma",
            ),
            (
                "400 0.1\n",
                "line 1: one column, expected two, wavelength in nm and value, parted by a comma",
            ),
            ("400;0,1\n500;0,2\n", "line 1: `0,1` is not a number"),
            (
                "400,nan\n500,1\n",
                "line 1: the value is NaN, expected a number of at least 0",
            ),
            (
                "# x\n400,0.1\n500,-2\n",
                "line 3: the value is -2, expected a number of at least 0",
            ),
            (
                "400,1\n400,2\n",
                "line 2: the wavelength 400 nm is there twice, expected each once, in ascending order",
            ),
            (
                "500,1\n400,2\n",
                "line 2: the wavelength 400 nm comes after 500 nm, expected ascending order",
            ),
            (
                "inf,1\n400,2\n",
                "line 1: the wavelength is inf, expected a number of nanometers above 0",
            ),
        ] {
            assert_eq!(parse(text).unwrap_err().to_string(), message, "{text}");
        }
    }
}
