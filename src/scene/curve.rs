//! Curves from files of two columns, wavelength in nm and value.

use std::borrow::Cow;
use std::fmt;
use std::io::{self, Read};
use std::path::Path;

use crate::input::Hash;
use crate::input::{self, Foreign, NotAFile};
use crate::printable::shortened;
use crate::spectrum::{Curve, CurveProblem};

/// The largest curve file in bytes; a million points fit. Reading one takes at most six times its
/// size in memory.
const LARGEST_FILE: u64 = 32_000_000;

/// The fewest bytes that a point takes in a file: two digits and what parts them and ends the line.
const LEAST_POINT: usize = 4;

/// Why a curve file cannot be used, with the line where it is one.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CurveError {
    /// The file cannot be read.
    #[error("{0}")]
    Unreadable(#[from] io::Error),
    /// A directory, a device, a pipe.
    #[error("{0}, expected a file of two columns")]
    NotAFile(#[from] NotAFile),
    /// More text than a curve can have.
    #[error("the file is larger than {limit} MB", limit = LARGEST_FILE / 1_000_000)]
    TooLarge,
    /// Text of an encoding that is not read, or a compressed file.
    #[error("it is {found}, expected text in ASCII or UTF-8; {}", .found.way_out())]
    Foreign {
        /// What it is instead.
        found: Foreign,
    },
    /// Not text.
    #[error("the file is not text")]
    NotText,
    /// Another number of columns than two.
    #[error(
        "line {line}: {columns}, expected two, wavelength in nm and value, parted by blanks, a tab, \
         a comma or a semicolon",
        columns = Columns(*.columns)
    )]
    Columns {
        /// Counted from 1.
        line: u64,
        /// How many there are.
        columns: usize,
    },
    /// Text where a number should be.
    #[error("line {line}: {} is not a number{}", named(text), way_out(text))]
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

impl CurveError {
    /// Whether another machine, or another try, may have more luck with the same file: memory was
    /// short, or reading failed.
    pub fn is_transient(&self) -> bool {
        match self {
            Self::Unreadable(error) => input::is_transient(error),
            Self::NotAFile(_)
            | Self::TooLarge
            | Self::Foreign { .. }
            | Self::NotText
            | Self::Columns { .. }
            | Self::NotANumber { .. }
            | Self::Illegal { .. } => false,
        }
    }
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

/// A column as messages have it.
fn named(text: &str) -> String {
    if text.is_empty() {
        "an empty column".to_owned()
    } else {
        format!("`{}`", shortened(text))
    }
}

/// What to do about a text that is no number, if that can be told.
fn way_out(text: &str) -> &'static str {
    if number(&text.replacen(',', ".", 1)).is_some() {
        ", expected a decimal point"
    } else {
        ""
    }
}

/// Reads a curve file: two columns parted by blanks, tabs, commas or semicolons. What follows `#` or
/// `//` on a line is a comment; the lines before the first number may name the file and its columns.
/// Beside the curve, the hash of the file.
///
/// # Errors
/// A file that cannot be read, lines of other than two numbers, and points that do not make a
/// [`Curve`].
pub(super) fn load(path: &Path) -> Result<(Curve, Hash), CurveError> {
    let (file, size) = input::open::<CurveError>(path)?;
    if size > LARGEST_FILE {
        return Err(CurveError::TooLarge);
    }
    let mut bytes = Vec::new();
    // One byte more shows that the file has ended.
    bytes
        .try_reserve_exact(size as usize + 1)
        .map_err(io::Error::from)?;
    let length = file.take(LARGEST_FILE + 1).read_to_end(&mut bytes)?;
    if length as u64 > LARGEST_FILE {
        return Err(CurveError::TooLarge);
    }
    Ok((parse(&bytes)?, Hash::of(&bytes)))
}

fn parse(bytes: &[u8]) -> Result<Curve, CurveError> {
    if let Some(found) = Foreign::of(bytes) {
        return Err(CurveError::Foreign { found });
    }
    let bytes = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    if bytes.contains(&0) {
        return Err(CurveError::NotText);
    }
    let most = bytes.len() / LEAST_POINT + 1;
    let points = most.min(rows(bytes).count());
    let (mut wavelengths, mut values) = (Vec::new(), Vec::new());
    for column in [&mut wavelengths, &mut values] {
        column.try_reserve_exact(points).map_err(io::Error::from)?;
    }
    let heading = heading(bytes);
    for (line, row) in rows(bytes).skip(heading) {
        let columns = columns(&row);
        let numbers = [0, 1].map(|i| columns.get(i).and_then(|text| number(text)));
        let &[nm, value] = columns.as_slice() else {
            let columns = columns.len();
            return Err(CurveError::Columns { line, columns });
        };
        let [Some(nm_value), Some(value_value)] = numbers else {
            let text = if numbers[0].is_none() { nm } else { value }.to_owned();
            return Err(CurveError::NotANumber { line, text });
        };
        wavelengths.push(nm_value);
        values.push(value_value);
    }
    Curve::new(wavelengths, values).map_err(|problem| CurveError::Illegal {
        line: problem.index().and_then(|index| {
            let mut points = rows(bytes).skip(heading);
            points.nth(index).map(|(line, _)| line)
        }),
        problem,
    })
}

/// How many rows stand before the first that has a number, or something that begins like one: titles,
/// names of columns, comments of other kinds. Where no row has a number, the second is wrong.
fn heading(bytes: &[u8]) -> usize {
    let is_like_number = |text: &&str| {
        let text = text.trim_start_matches(['+', '-']);
        text.trim_start_matches('.')
            .starts_with(|c: char| c.is_ascii_digit())
    };
    let is_number = |text: &&str| number(&text.replacen(',', ".", 1)).is_some();
    let mut heading = 0;
    for (index, (_, row)) in rows(bytes).enumerate() {
        let columns = columns(&row);
        let mut first_two = columns.iter().take(2);
        let is_point = if index == 0 {
            first_two.any(is_number)
        } else {
            first_two.any(|text| is_number(text) || is_like_number(text))
        };
        if is_point {
            return heading;
        }
        heading += 1;
    }
    heading.min(1)
}

/// The lines, counted from 1, that are neither empty nor comments, without blanks and comments at
/// their ends. They end in LF, CR LF or CR; what is no UTF-8, as in old comments, becomes U+FFFD.
fn rows(bytes: &[u8]) -> impl Iterator<Item = (u64, Cow<'_, str>)> {
    let mut rest = Some(bytes);
    let mut line = 0;
    std::iter::from_fn(move || {
        loop {
            let text = rest?;
            let end = text.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
            let (row, after) = match end {
                Some(end) if text[end..].starts_with(b"\r\n") => (&text[..end], Some(end + 2)),
                Some(end) => (&text[..end], Some(end + 1)),
                None => (text, None),
            };
            rest = after.map(|after| &text[after..]);
            line += 1;
            let row = without_comment(row);
            if !row.is_empty() {
                return Some((line, String::from_utf8_lossy(row)));
            }
        }
    })
}

fn without_comment(row: &[u8]) -> &[u8] {
    let is_comment = |pair: &[u8]| pair[0] == b'#' || pair == b"//";
    let comment = row.windows(2).position(is_comment);
    let row = &row[..comment.unwrap_or(row.len())];
    // A window of two does not see the last byte alone, nor the mark by which DOS ends a text.
    let row = row.strip_suffix(b"#").unwrap_or(row);
    row.strip_suffix(b"\x1a").unwrap_or(row).trim_ascii()
}

/// The columns of a line: parted by semicolons if it has one, else by commas if it has one, else by
/// blanks. A comma between digits of a line that blanks part in two is a decimal comma.
fn columns(row: &str) -> Vec<&str> {
    let blanks = || row.split_whitespace();
    let is_decimal_comma = || {
        let before = row.split(',').next().unwrap_or_default();
        number(unquoted(before)).is_none() && blanks().count() == 2
    };
    let mut columns: Vec<&str> = if row.contains(';') {
        row.split(';').map(unquoted).collect()
    } else if row.contains(',') && !is_decimal_comma() {
        row.split(',').map(unquoted).collect()
    } else {
        blanks().map(unquoted).collect()
    };
    // Spreadsheets end lines with separators of columns that are empty.
    while columns.len() > 2 && columns.last().is_some_and(|last| last.is_empty()) {
        columns.pop();
    }
    columns
}

/// A column without the blanks and quotes around it.
fn unquoted(column: &str) -> &str {
    let column = column.trim();
    let inner = column
        .strip_prefix('"')
        .and_then(|rest| rest.strip_suffix('"'));
    inner.map_or(column, str::trim)
}

fn number(text: &str) -> Option<f64> {
    text.parse().ok()
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
            // As pbrt's and Mitsuba's, and what others make of it.
            "# nm value\n400 0.1\n500.5   0.25\n700 1\n",
            "  400 \t 0.1\n#\n// another\n500.5 0.25 # why\n700 1 // end\n\x1a",
            "wavelength in nm\treflectance of it\n400\t\t0.1\n500.5\t.25\n700\t1",
            "Wavelength\n400 0.1\n500.5 .25\n700 1#",
            "400 0.1\r500.5 0.25\r700 1\r",
            "nm;R;\n400;0.1;\n500.5;0.25;;\n700;1;\n",
            "400 , 0.1\n500.5 ,0.25\n700,1",
            // Titles and comments of other programs, and what Excel writes first.
            "Sample 7, green\nmeasured at noon\n\nnm,R\n400,0.1\n500.5,0.25\n700,1",
            "% measured\n% nm R\n400 0.1\n500.5 0.25\n700 1",
            "; measured\n! nm R\n400 0.1\n500.5 0.25\n700 1",
            "sep=;\nnm;R\n400;0.1\n500.5;0.25\n700;1\n",
            "2° observer,CIE\nnm,R\n400,0.1\n500.5,0.25\n700,1",
        ] {
            assert_eq!(parse(text.as_bytes()).unwrap(), expected, "{text}");
        }
        // Old comments are in other encodings.
        let latin = b"# in \xc5ngstr\xf6m\n\xb5m times 1000,R\n400,0.1\n500.5,0.25\n700,1\n";
        assert_eq!(parse(latin).unwrap(), expected);
    }

    #[test]
    fn what_is_wrong_has_its_line() {
        const PARTED: &str = "expected two, wavelength in nm and value, parted by blanks, a tab, a \
            comma or a semicolon";
        for (text, message) in [
            ("", "the curve has no points, expected at least 2".to_owned()),
            (
                "nm,value\n400,1\n",
                "the curve has 1 point, expected at least 2".to_owned(),
            ),
            (
                "nm,value\nnm,value\n",
                "line 2: `nm` is not a number".to_owned(),
            ),
            (
                "400,0.1\n500,red\n",
                "line 2: `red` is not a number".to_owned(),
            ),
            (
                "nm,value\r\n400,0.1\r\n500,red\r\n",
                "line 3: `red` is not a number".to_owned(),
            ),
            (
                "nm value\r400 0.1\r500 red\r",
                "line 3: `red` is not a number".to_owned(),
            ),
            (
                "400,0.1\n# a comment\n\n500,red\n",
                "line 4: `red` is not a number".to_owned(),
            ),
            (
                "\u{feff}nm,value\r\n400,0.1\r\n\r\n# a comment\r\n300,1\r\n",
                "line 5: the wavelength 300 nm comes after 400 nm, expected ascending order"
                    .to_owned(),
            ),
            ("400,0,1\n", format!("line 1: 3 columns, {PARTED}")),
            ("400\n", format!("line 1: one column, {PARTED}")),
            ("400,\n500,1\n", "line 1: an empty column is not a number".to_owned()),
            // Not a title: a point that would be lost.
            (
                "400,5;0,1\n500;0.2\n600;0.3\n",
                "line 1: `400,5` is not a number, expected a decimal point".to_owned(),
            ),
            (
                "nm R\n400nm 0.1\n500 0.2\n600 0.3\n",
                "line 2: `400nm` is not a number".to_owned(),
            ),
            (
                "nm R\n-4x 1%\n500 0.2\n600 0.3\n",
                "line 2: `-4x` is not a number".to_owned(),
            ),
            (
                "a title\nnm,R\n400,0.1\n500,red\n",
                "line 4: `red` is not a number".to_owned(),
            ),
            (
                "a title\nnm,R\n400,0.1\n500,-1\n",
                "line 4: the value is -1, expected a number of at least 0".to_owned(),
            ),
            ("a\nb\n", format!("line 2: one column, {PARTED}")),
            ("400 0.1 500 0.2", format!("line 1: 4 columns, {PARTED}")),
            (
                "400;0,1\n500;0,2\n",
                "line 1: `0,1` is not a number, expected a decimal point".to_owned(),
            ),
            (
                "400 0,1\n500 0,2\n",
                "line 1: `0,1` is not a number, expected a decimal point".to_owned(),
            ),
            (
                "400,nan\n500,1\n",
                "line 1: the value is NaN, expected a number of at least 0".to_owned(),
            ),
            (
                "# x\n400,0.1\n500,-2\n",
                "line 3: the value is -2, expected a number of at least 0".to_owned(),
            ),
            (
                "400,1\n400,2\n",
                "line 2: the wavelength 400 nm is there twice, expected each once, in ascending \
                order"
                    .to_owned(),
            ),
            (
                "500,1\n400,2\n",
                "line 2: the wavelength 400 nm comes after 500 nm, expected ascending order"
                    .to_owned(),
            ),
            (
                "inf,1\n400,2\n",
                "line 1: the wavelength is inf, expected a number of nanometers above 0".to_owned(),
            ),
            (
                "n\0m\0,\0R\0\n\0",
                "it is text in UTF-16 (little endian), expected text in ASCII or UTF-8; save it as \
                UTF-8"
                    .to_owned(),
            ),
            ("400,1\n\0\0", "the file is not text".to_owned()),
        ] {
            assert_eq!(parse(text.as_bytes()).unwrap_err().to_string(), message, "{text}");
        }
    }
}
