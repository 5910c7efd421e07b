//! Frames on the command line: `--frames 1-100:2`, and names of files with their numbers.

use std::collections::HashSet;
use std::fmt;
use std::path::{Path, PathBuf};

use candela::internal::printable_path;

use super::sequence::DECIMALS;
use super::{advice, sequence};

/// A frame is kept in these parts, so that steps add up without rounding.
const PARTS: i64 = 1_000_000;

/// The largest number of a frame.
const LARGEST: i64 = 1_000_000_000;

/// How many frames one call may have.
const MOST: usize = 1_000_000;

/// The number of a frame, which may have a fraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Frame(i64);

impl Frame {
    pub(super) const ONE: Self = Self(PARTS);

    /// How many frames it comes after another.
    pub(super) const fn after(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }

    pub(super) const fn is_whole(self) -> bool {
        self.0 % PARTS == 0
    }

    pub(super) fn number(self) -> f64 {
        self.0 as f64 / PARTS as f64
    }

    /// A file's name with this number in the place of `####` or `%04d`; the same where it has no such place.
    pub(super) fn name(self, pattern: &Path) -> PathBuf {
        match advice::frame_number(pattern) {
            Some(part) => sequence::numbered(pattern, &part, &self.to_string()),
            None => pattern.to_owned(),
        }
    }
}

impl fmt::Display for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.0 < 0 { "-" } else { "" };
        let parts = self.0.unsigned_abs();
        let (whole, fraction) = (parts / PARTS as u64, parts % PARTS as u64);
        write!(f, "{sign}{whole}")?;
        if fraction == 0 {
            return Ok(());
        }
        let digits = format!("{fraction:0width$}", width = DECIMALS as usize);
        write!(f, ".{}", digits.trim_end_matches('0'))
    }
}

/// Frames in the order in which they are rendered, each once; at least one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Frames(Vec<Frame>);

impl Frames {
    pub(super) fn list(&self) -> &[Frame] {
        &self.0
    }
}

/// `12`, `12.5`, `-3`
pub(super) fn frame(text: &str) -> Result<Frame, String> {
    let text = text.trim();
    let parsed = number(text).filter(|(_, rest)| rest.is_empty());
    let (frame, _) = parsed.ok_or_else(|| {
        format!(
            "expected the number of a frame with at most {DECIMALS} decimals, such as 12 or 12.5"
        )
    })?;
    Ok(frame)
}

/// `1-100`, `1-100:2`, `1-100x2`, `1,5,9-12`
pub(super) fn frames(text: &str) -> Result<Frames, String> {
    let mut list = Vec::new();
    let mut known = HashSet::new();
    for part in text.split(',') {
        for frame in range(part.trim())? {
            if !known.insert(frame) {
                return Err(format!("frame {frame} is there twice"));
            }
            list.push(frame);
        }
        if list.len() > MOST {
            return Err(format!(
                "more than {MOST} frames; render them in several calls"
            ));
        }
    }
    Ok(Frames(list))
}

/// The frames of `12`, `1-100`, `1-100:2` or `100-1:-1`.
fn range(text: &str) -> Result<Vec<Frame>, String> {
    let expected = || {
        "expected frames such as 1-100, 1-100:2 or 1,5,9-12, with at most six decimals".to_owned()
    };
    let (first, rest) = number(text).ok_or_else(expected)?;
    if rest.is_empty() {
        return Ok(vec![first]);
    }
    let rest = rest.strip_prefix('-').ok_or_else(expected)?;
    let (last, rest) = number(rest).ok_or_else(expected)?;
    let step = match rest.strip_prefix([':', 'x']) {
        Some(step) => {
            let (step, rest) = number(step).ok_or_else(expected)?;
            if !rest.is_empty() {
                return Err(expected());
            }
            step
        }
        None if rest.is_empty() => Frame(PARTS),
        None => return Err(expected()),
    };
    if step.0 == 0 {
        return Err("a step of 0 frames leads nowhere; expected one such as 1-100:2".to_owned());
    }
    if (last.0 - first.0) * step.0.signum() < 0 {
        let way_out = if step.0 > 0 {
            format!("; write {last}-{first}, or {first}-{last}:-1 for the other order")
        } else {
            String::new()
        };
        return Err(format!("there is no frame in {text}{way_out}"));
    }
    let count = (last.0 - first.0) / step.0 + 1;
    if count > MOST as i64 {
        return Err(format!(
            "more than {MOST} frames; render them in several calls"
        ));
    }
    Ok((0..count).map(|i| Frame(first.0 + i * step.0)).collect())
}

/// The number at the start of a text, and what comes after it.
fn number(text: &str) -> Option<(Frame, &str)> {
    let (sign, digits) = match text.strip_prefix('-') {
        Some(digits) => (-1, digits),
        None => (1, text),
    };
    let end = digits
        .find(|c: char| !c.is_ascii_digit() && c != '.')
        .unwrap_or(digits.len());
    let (digits, rest) = digits.split_at(end);
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, "0"));
    if whole.is_empty() || fraction.is_empty() || fraction.len() > DECIMALS as usize {
        return None;
    }
    let whole: i64 = whole.parse().ok().filter(|&whole| whole <= LARGEST)?;
    let decimals = fraction.len() as u32;
    let fraction: i64 = fraction.parse().ok()?;
    let parts = whole * PARTS + fraction * 10_i64.pow(DECIMALS - decimals);
    Some((Frame(sign * parts), rest))
}

/// Whether a name has a place for numbers of frames just where there are several.
pub(super) fn check_name(path: &Path, frames: Option<&Frames>) -> Result<(), String> {
    let part = advice::place_of_number(path)?;
    let shown = || printable_path(path);
    match (part, frames) {
        (Some(part), None) => Err(format!(
            "`{part}` in {} stands for the number of a frame; say which ones by --frames, such as --frames 1-100",
            shown()
        )),
        (Some(_), Some(_)) | (None, None) => Ok(()),
        (None, Some(frames)) if frames.list().len() == 1 || path == Path::new("-") => Ok(()),
        (None, Some(frames)) => Err(format!(
            "{} frames cannot all become {}; give the name a place for their numbers, such as {}",
            frames.list().len(),
            shown(),
            printable_path(&with_place(path)),
        )),
    }
}

/// NAME.####.EXTENSION
pub(super) fn with_place(path: &Path) -> PathBuf {
    let extension = path.extension().unwrap_or_default().to_string_lossy();
    path.with_extension(format!("####.{extension}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn listed(text: &str) -> Result<String, String> {
        let frames = frames(text)?;
        let frames = frames.list().iter().map(Frame::to_string);
        Ok(frames.collect::<Vec<_>>().join(" "))
    }

    #[test]
    fn ranges_steps_and_lists() {
        for (text, expected) in [
            ("7", "7"),
            ("1-4", "1 2 3 4"),
            ("1-8:3", "1 4 7"),
            ("1-8x3", "1 4 7"),
            ("1,5,9-11", "1 5 9 10 11"),
            ("-2-1", "-2 -1 0 1"),
            ("-4--2", "-4 -3 -2"),
            ("3-1:-1", "3 2 1"),
            ("1-2:0.1", "1 1.1 1.2 1.3 1.4 1.5 1.6 1.7 1.8 1.9 2"),
            ("0.000001", "0.000001"),
            (" 1 , 2 ", "1 2"),
        ] {
            assert_eq!(listed(text).as_deref(), Ok(expected), "{text}");
        }
    }

    #[test]
    fn what_is_no_frames_is_said() {
        for (text, part) in [
            ("", "expected frames"),
            ("a", "expected frames"),
            ("1-", "expected frames"),
            ("1-2-3", "expected frames"),
            ("1;2", "expected frames"),
            ("1.0000001", "expected frames"),
            ("1,,2", "expected frames"),
            ("9999999999", "expected frames"),
            ("5-1", "write 1-5, or 5-1:-1"),
            ("1-5:-1", "there is no frame in 1-5:-1"),
            ("1-5:0", "leads nowhere"),
            ("1-3,2", "frame 2 is there twice"),
            ("1-1000000000", "more than 1000000 frames"),
        ] {
            let message = listed(text).unwrap_err();
            assert!(message.contains(part), "{text}: {message}");
        }
    }

    #[test]
    fn names_have_numbers() {
        let name = |pattern: &str, text: &str| {
            let frame = frame(text).unwrap();
            frame
                .name(Path::new(pattern))
                .to_string_lossy()
                .into_owned()
        };
        assert_eq!(name("a/f.####.exr", "7"), "a/f.0007.exr");
        assert_eq!(name("f_%03d.exr", "12345"), "f_12345.exr");
        assert_eq!(name("f.####.exr", "12.5"), "f.0012.5.exr");
        assert_eq!(name("f.####.exr", "-7"), "f.-007.exr");
        assert_eq!(name("f.####.exr", "0"), "f.0000.exr");
        assert_eq!(name("f.####.exr", "-0.5"), "f.-000.5.exr");
        assert_eq!(name("f.%d.exr", "-0.5"), "f.-0.5.exr");
        assert_eq!(name("f.<FRAME>.exr", "7"), "f.7.exr");
        assert_eq!(name("still.exr", "3"), "still.exr");
    }

    #[test]
    fn places_for_numbers_are_where_there_are_frames() {
        let frames = |text: &str| frames(text).unwrap();
        let check =
            |name: &str, frames: Option<Frames>| check_name(Path::new(name), frames.as_ref());
        assert!(
            check("f.####.exr", None)
                .unwrap_err()
                .contains("--frames 1-100")
        );
        assert!(
            check("f.exr", Some(frames("1-2")))
                .unwrap_err()
                .contains("f.####.exr")
        );
        assert_eq!(check("f.exr", Some(frames("3"))), Ok(()));
        assert_eq!(check("f.####.exr", Some(frames("3"))), Ok(()));
        assert_eq!(check("f.exr", None), Ok(()));
        for name in ["f.%04d.####.exr", "f.####.####.exr"] {
            let error = check(name, Some(frames("1-2"))).unwrap_err();
            assert!(error.contains("two places"), "{error}");
        }
    }
}
