//! What stands before the numbers: the edition, keywords, and the line `TILT=`.
//!
//! LM-63-02, section 4: the first line names the edition; lines `[KEYWORD] text` follow, `[MORE]` going on
//! with the one before; the line `TILT=` ends them. LM-63-1986 has neither the first line nor keywords, but
//! lines of any text.

use super::error::{Fault, Problem};
use super::limits::LONGEST_LINE;
use super::remarks::IesRemarks;

/// The edition of LM-63 that a file names in its first line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Edition {
    /// LM-63-1986, which has no such line.
    Lm63_1986,
    /// `IESNA91`
    Lm63_1991,
    /// `IESNA:LM-63-1995`
    Lm63_1995,
    /// `IESNA:LM-63-2002`
    Lm63_2002,
    /// `IES:LM-63-2019`
    Lm63_2019,
}

impl Edition {
    /// Its name: `LM-63-2002`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Lm63_1986 => "LM-63-1986",
            Self::Lm63_1991 => "LM-63-1991",
            Self::Lm63_1995 => "LM-63-1995",
            Self::Lm63_2002 => "LM-63-2002",
            Self::Lm63_2019 => "LM-63-2019",
        }
    }
}

/// A line `[KEYWORD] text` of a file, with the lines `[MORE]` that go on with it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Keyword {
    /// In upper case, without brackets.
    pub name: String,
    /// Lines parted by `\n`, without blanks at their ends.
    pub text: String,
}

/// What `TILT=` says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TiltLine<'a> {
    None,
    Include,
    /// The name of a file, and where it stands.
    File(&'a [u8], usize),
}

/// All that stands before the numbers.
#[derive(Clone, Debug)]
pub(super) struct Header<'a> {
    pub(super) edition: Edition,
    pub(super) keywords: Vec<Keyword>,
    pub(super) tilt: TiltLine<'a>,
    /// Where the numbers start.
    pub(super) end: usize,
}

/// The first line of `bytes` from `start` on without its end, and where the next one starts.
fn line(bytes: &[u8], start: usize) -> (&[u8], usize) {
    let rest = &bytes[start..];
    let Some(length) = rest.iter().position(|byte| b"\r\n".contains(byte)) else {
        return (rest, bytes.len());
    };
    let end = if rest[length..].starts_with(b"\r\n") {
        length + 2
    } else {
        length + 1
    };
    (&rest[..length], start + end)
}

/// Whether a byte is blank at the ends of a line: what programs leave at the end of a file is, too.
fn is_blank(byte: u8) -> bool {
    byte.is_ascii_whitespace() || matches!(byte, 0 | 0x1a)
}

/// Without what is blank at its start.
fn trimmed_start(text: &[u8]) -> &[u8] {
    let start = text.iter().position(|&byte| !is_blank(byte));
    &text[start.unwrap_or(text.len())..]
}

/// Without what is blank at both ends.
fn trimmed(text: &[u8]) -> &[u8] {
    let end = text.iter().rposition(|&byte| !is_blank(byte));
    trimmed_start(&text[..end.map_or(0, |last| last + 1)])
}

/// UTF-8, or Latin-1, of which each byte is the character of its number.
fn decoded(text: &[u8], remarks: &mut IesRemarks) -> String {
    if let Ok(text) = std::str::from_utf8(text) {
        return text.to_owned();
    }
    IesRemarks::add(&mut remarks.latin1_lines);
    text.iter().map(|&byte| char::from(byte)).collect()
}

impl Edition {
    /// That which a first line names; `Err` where it names one that is not known, `None` where it names none.
    fn of(line: &[u8]) -> Option<Result<Self, ()>> {
        const LONGEST: usize = 60;
        if line.len() > LONGEST {
            return None;
        }
        let letters = line.iter().filter(|byte| byte.is_ascii_alphanumeric());
        let letters: String = letters
            .map(|byte| char::from(byte.to_ascii_uppercase()))
            .collect();
        let name = letters.strip_prefix("IESNA");
        let name = name.or_else(|| letters.strip_prefix("IES"))?;
        let (year, is_named) = match name.strip_prefix("LM63") {
            Some(year) => (year, true),
            None => (name, false),
        };
        if !is_named && !year.bytes().all(|byte| byte.is_ascii_digit()) {
            return None;
        }
        let year = year
            .strip_prefix("19")
            .filter(|rest| rest.len() == 2)
            .unwrap_or(year);
        let year = year
            .strip_prefix("20")
            .filter(|rest| rest.len() == 2)
            .unwrap_or(year);
        Some(match year {
            "86" => Ok(Self::Lm63_1986),
            "91" => Ok(Self::Lm63_1991),
            "95" => Ok(Self::Lm63_1995),
            "02" => Ok(Self::Lm63_2002),
            "19" => Ok(Self::Lm63_2019),
            _ => Err(()),
        })
    }
}

/// Reads up to the line `TILT=`.
pub(super) fn read<'a>(
    bytes: &'a [u8],
    start: usize,
    remarks: &mut IesRemarks,
) -> Result<Header<'a>, Problem> {
    let mut keywords: Vec<Keyword> = Vec::new();
    let mut edition = None;
    let mut plain_lines = 0;
    let mut position = start;
    let mut is_first = true;
    while position < bytes.len() {
        let (whole, next) = line(bytes, position);
        let text = trimmed(whole);
        let offset = position + whole.len() - trimmed_start(whole).len();
        if let Some((tilt, end)) = tilt_line(text, offset, next, remarks) {
            // What names itself an edition that has these lines is no file of 1986.
            if edition.is_some_and(|edition| edition > Edition::Lm63_1986) {
                remarks.plain_lines = plain_lines;
            }
            remarks.no_edition = edition.is_none() && !keywords.is_empty();
            return Ok(Header {
                edition: edition.unwrap_or(Edition::Lm63_1986),
                keywords,
                tilt,
                end,
            });
        }
        let named = if is_first { Edition::of(text) } else { None };
        if let Some(named) = named {
            remarks.unknown_edition = named.is_err();
            edition = Some(named.unwrap_or(Edition::Lm63_2002));
        } else if let Some((name, value)) = keyword(text) {
            if name.iter().any(u8::is_ascii_lowercase) {
                IesRemarks::add(&mut remarks.small_keywords);
            }
            add(&mut keywords, name, value, remarks)?;
        } else if !text.is_empty() {
            plain_lines += 1;
        }
        is_first &= text.is_empty();
        position = next;
    }
    let expected = "a line `TILT=NONE` before the numbers; this is how every IES file has it";
    let fault = Fault::FileEnds { expected };
    Err(Problem::new(bytes.len(), fault))
}

/// The name and the rest of a line `[NAME] rest`.
fn keyword(line: &[u8]) -> Option<(&[u8], &[u8])> {
    let inner = line.strip_prefix(b"[")?;
    let end = inner.iter().position(|&byte| byte == b']')?;
    Some((trimmed(&inner[..end]), trimmed(&inner[end + 1..])))
}

fn add(
    keywords: &mut Vec<Keyword>,
    name: &[u8],
    text: &[u8],
    remarks: &mut IesRemarks,
) -> Result<(), Problem> {
    let name = decoded(name, remarks).to_uppercase();
    let text = decoded(text, remarks);
    match keywords.last_mut() {
        Some(last) if name == "MORE" => {
            last.text.try_reserve(text.len() + 1)?;
            last.text.push('\n');
            last.text.push_str(&text);
        }
        _ => {
            keywords.try_reserve(1)?;
            keywords.push(Keyword { name, text });
        }
    }
    Ok(())
}

/// What a line `TILT=` says, and where what follows it starts.
fn tilt_line<'a>(
    line: &'a [u8],
    offset: usize,
    next: usize,
    remarks: &mut IesRemarks,
) -> Option<(TiltLine<'a>, usize)> {
    let (name, rest) = line.split_at_checked(b"TILT".len())?;
    if !name.eq_ignore_ascii_case(b"TILT") {
        return None;
    }
    let value = trimmed_start(rest).strip_prefix(b"=")?;
    let name = trimmed_start(value);
    let start = offset + line.len() - name.len();
    let ends = |byte: &u8| byte.is_ascii_whitespace() || *byte == b',';
    let length = name.iter().position(ends).unwrap_or(name.len());
    let word = &name[..length];
    remarks.loose_tilt = !line.starts_with(b"TILT=") || value.len() > name.len();
    let is = |expected: &[u8]| word.eq_ignore_ascii_case(expected);
    if word.is_empty() {
        remarks.loose_tilt = true;
        return Some((TiltLine::None, next));
    }
    if is(b"NONE") || is(b"INCLUDE") {
        remarks.loose_tilt |= word.iter().any(u8::is_ascii_lowercase);
        let tilt = if is(b"NONE") {
            TiltLine::None
        } else {
            TiltLine::Include
        };
        // Numbers may follow on the same line.
        return Some((tilt, start + word.len()));
    }
    Some((TiltLine::File(name, start), next))
}

/// Marks lines that are too long, and line ends that are old.
pub(super) fn look_at_lines(bytes: &[u8], remarks: &mut IesRemarks) {
    let mut position = 0;
    let mut has_line_feed = false;
    let mut lines = 0_u64;
    while position < bytes.len() {
        let (text, next) = line(bytes, position);
        if text.len() > LONGEST_LINE {
            IesRemarks::add(&mut remarks.long_lines);
        }
        has_line_feed |= bytes[..next].last() == Some(&b'\n');
        lines += 1;
        position = next;
    }
    remarks.carriage_returns = !has_line_feed && lines > 1;
}
