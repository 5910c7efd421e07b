//! Many files in one call: frames of a sequence, patterns, lists.

use std::collections::HashMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use candela::internal::printable_path;

use super::failure::Misuse;
use super::{Failure, advice};

/// The decimals that the number of a frame may have.
pub(super) const DECIMALS: u32 = 6;

/// More digits no file system has room for in a name.
const MOST_DIGITS: usize = 255;

/// A file that is read, and what is made of it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Conversion {
    pub(super) input: PathBuf,
    pub(super) output: PathBuf,
}

/// A file that an argument stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Found {
    path: PathBuf,
    /// Of a frame, as the name has it.
    number: Option<String>,
}

/// What is to be made of what: of each file that `inputs` stand for an output with this extension, where `output`
/// says, else in the current folder.
///
/// An input is a file, or frames, `f.####.exr` or `f.%04d.exr`, or a pattern, `*.exr`. The output is a file, or a folder, or
/// frames.
pub(super) fn conversions(
    inputs: &[PathBuf],
    output: Option<&Path>,
    extension: &str,
) -> Result<Vec<Conversion>, Failure> {
    if let ([_, last], None) = (inputs, output)
        && last
            .extension()
            .is_some_and(|found| found.eq_ignore_ascii_case(extension))
        && last.symlink_metadata().is_err()
    {
        return Err(format!(
            "{0} is not there; a file to write is named by -o {0}",
            printable_path(last)
        )
        .into());
    }
    let mut found = Vec::new();
    for input in inputs {
        found.extend(files(input)?);
    }
    let is_one = found.len() == 1;
    let conversions = found.into_iter().map(|Found { path, number }| {
        let output = match output {
            None => named_after(&path, extension)?,
            Some(folder) if is_folder(folder) => folder.join(named_after(&path, extension)?),
            Some(output) => match (advice::place_of_number(output).map_err(Misuse)?, number) {
                (Some(part), number) => {
                    let Some(number) = number.or_else(|| last_digits(&path)) else {
                        return Err(format!(
                            "{} has no number to put in the place of `{part}`",
                            printable_path(&path)
                        )
                        .into());
                    };
                    numbered(output, &part, &number)
                }
                (None, _) if is_one => output.to_owned(),
                (None, _) => {
                    return Err(Misuse(format!(
                        "more than one file cannot become {}; name the outputs with ####, as in \
                         f.####.{extension}, or give a folder",
                        printable_path(output)
                    ))
                    .into());
                }
            },
        };
        Ok(Conversion {
            input: path,
            output,
        })
    });
    let conversions: Vec<Conversion> = conversions.collect::<Result<_, Failure>>()?;
    let mut made: HashMap<&Path, &Path> = HashMap::new();
    for Conversion { input, output } in &conversions {
        if let Some(other) = made.insert(output, input) {
            return Err(format!(
                "{} and {} would both become {}; give names by -o",
                printable_path(other),
                printable_path(input),
                printable_path(output)
            )
            .into());
        }
    }
    Ok(conversions)
}

/// The files that inputs stand for, each with the number of its frame as its name has it, where it is one of frames.
pub(super) fn found(inputs: &[PathBuf]) -> Result<Vec<(PathBuf, Option<String>)>, Failure> {
    let mut all = Vec::new();
    for input in inputs {
        let files = files(input)?.into_iter();
        all.extend(files.map(|Found { path, number }| (path, number)));
    }
    Ok(all)
}

/// Whether outputs go into it.
fn is_folder(path: &Path) -> bool {
    path != Path::new("-") && (path.is_dir() || path.as_os_str().as_encoded_bytes().ends_with(b"/"))
}

/// How a message names an input.
pub(super) fn input_name(input: &Path) -> String {
    if input == Path::new("-") {
        "standard input".to_owned()
    } else {
        printable_path(input)
    }
}

/// How a message names an output.
pub(super) fn output_name(output: &Path) -> String {
    if output == Path::new("-") {
        "standard output".to_owned()
    } else {
        printable_path(output)
    }
}

/// NAME.SUFFIX in the current folder. An input without a name cannot be read, which is found later.
pub(super) fn named_after(input: &Path, suffix: &str) -> Result<PathBuf, Failure> {
    if input == Path::new("-") || input.starts_with("/dev") || input.starts_with("/proc") {
        let extension = suffix.rsplit('.').next().unwrap_or(suffix);
        let kind = extension.to_uppercase();
        let name = input_name(input);
        return Err(format!(
            "{name} gives the {kind} no name; give it one with -o OUT.{extension}"
        )
        .into());
    }
    Ok(Path::new(input.file_name().unwrap_or_default()).with_extension(suffix))
}

/// The files that an argument stands for: where there is one of that very name, that.
fn files(argument: &Path) -> Result<Vec<Found>, Failure> {
    let one = |path: &Path| {
        vec![Found {
            path: path.to_owned(),
            number: None,
        }]
    };
    if argument == Path::new("-") || argument.symlink_metadata().is_ok() {
        return Ok(one(argument));
    }
    if let Some(part) = advice::frame_number(argument) {
        return sequence(argument, &part);
    }
    let is_pattern = argument
        .to_str()
        .is_some_and(|text| text.contains(['*', '?', '[']));
    if !is_pattern {
        // Reading it says what is wrong.
        return Ok(one(argument));
    }
    let text = argument.to_str().unwrap_or_default();
    let paths = glob::glob(text).map_err(|error| {
        format!(
            "{} is no pattern of names: {error}",
            printable_path(argument)
        )
    })?;
    let found: Vec<Found> = paths
        .filter_map(Result::ok)
        .filter(|path| !path.is_dir())
        .map(|path| Found { path, number: None })
        .collect();
    if found.is_empty() {
        return Err(format!("no file has a name like {}", printable_path(argument)).into());
    }
    Ok(found)
}

/// The frames of a sequence in a folder, by their numbers.
fn sequence(pattern: &Path, part: &str) -> Result<Vec<Found>, Failure> {
    let name = pattern
        .file_name()
        .and_then(OsStr::to_str)
        .unwrap_or_default();
    let (before, after) = name.split_once(part).unwrap_or((name, ""));
    let folder = match pattern.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    let least = padding(part);
    let entries = std::fs::read_dir(folder)
        .map_err(|error| format!("cannot list {}: {error}", printable_path(folder)))?;
    let mut numbered: Vec<(f64, Found)> = Vec::new();
    for entry in entries {
        let entry =
            entry.map_err(|error| format!("cannot list {}: {error}", printable_path(folder)))?;
        let entry = entry.file_name();
        let Some(number) = entry.to_str().and_then(|entry| {
            let number = entry.strip_prefix(before)?.strip_suffix(after)?;
            is_of_frame(number, least).then_some(number)
        }) else {
            continue;
        };
        let Ok(place) = number.parse() else {
            continue;
        };
        let found = Found {
            path: pattern.with_file_name(&entry),
            number: Some(number.to_owned()),
        };
        numbered.push((place, found));
    }
    numbered.sort_by(|(a, one), (b, other)| a.total_cmp(b).then_with(|| one.path.cmp(&other.path)));
    if numbered.is_empty() {
        return Err(format!(
            "no frame has a name like {}, with a number of at least {least} digits for `{part}`",
            printable_path(pattern)
        )
        .into());
    }
    Ok(numbered.into_iter().map(|(_, found)| found).collect())
}

/// Whether a text is the number of a frame with at least so many digits, as [`numbered`] writes it: it may have a sign
/// and decimals.
fn is_of_frame(text: &str, least: usize) -> bool {
    let (whole, decimals) = match text.split_once('.') {
        Some((whole, decimals)) => (whole, Some(decimals)),
        None => (text, None),
    };
    let digits = whole.strip_prefix('-').unwrap_or(whole);
    let are_digits =
        |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let is_padded =
        least == 1 || whole.len() == least || whole.len() > least && !digits.starts_with('0');
    // Others may be of a file that has a number before its extension, such as a version.
    let are_decimals =
        |text: &str| are_digits(text) && text.len() <= DECIMALS as usize && !text.ends_with('0');
    is_padded && are_digits(digits) && decimals.is_none_or(are_decimals)
}

/// How many characters a frame's number has at least, before its decimals.
fn padding(part: &str) -> usize {
    let hashes = part.chars().filter(|&c| c == '#').count();
    if hashes > 0 {
        return hashes.min(MOST_DIGITS);
    }
    let digits: String = part.chars().filter(char::is_ascii_digit).collect();
    if digits.is_empty() {
        return 1;
    }
    // What is no number is too large for one.
    let number = digits.parse().unwrap_or(MOST_DIGITS);
    number.clamp(1, MOST_DIGITS)
}

/// The number at the end of a name, before its extension.
fn last_digits(path: &Path) -> Option<String> {
    let stem = path.file_stem()?.to_str()?;
    let start = stem
        .rfind(|c: char| !c.is_ascii_digit())
        .map_or(0, |place| {
            place + stem[place..].chars().next().map_or(1, char::len_utf8)
        });
    let digits = &stem[start..];
    (!digits.is_empty()).then(|| digits.to_owned())
}

/// A frame's name: the number, which may have a sign and a fraction, in the place of the part that stands for it.
pub(super) fn numbered(pattern: &Path, part: &str, number: &str) -> PathBuf {
    let name = pattern
        .file_name()
        .and_then(OsStr::to_str)
        .unwrap_or_default();
    let (whole, fraction) = match number.find('.') {
        Some(point) => number.split_at(point),
        None => (number, ""),
    };
    let (sign, digits) = match whole.strip_prefix('-') {
        Some(digits) => ("-", digits),
        None => ("", whole),
    };
    // As `printf` has it: the sign is one of the characters.
    let digits = digits.trim_start_matches('0');
    let width = padding(part).saturating_sub(sign.len()).max(1);
    let number = format!("{sign}{digits:0>width$}{fraction}");
    pattern.with_file_name(name.replacen(part, &number, 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        folder
    }

    fn made(inputs: &[PathBuf], output: Option<&Path>) -> Result<Vec<String>, String> {
        let made = conversions(inputs, output, "png").map_err(|error| error.to_string())?;
        let name = |path: &Path| path.file_name().unwrap().to_str().unwrap().to_owned();
        Ok(made
            .iter()
            .map(|one| format!("{} {}", name(&one.input), name(&one.output)))
            .collect())
    }

    #[test]
    fn frames_are_found_in_order() {
        let folder = folder(&[
            "f.0002.exr",
            "f.0010.exr",
            "f.12345.exr",
            "f.02345.exr",
            "f.1.exr",
            "f.abcd.exr",
            "g.0001.exr",
            "f.0003.png",
        ]);
        let path = |name: &str| folder.path().join(name);
        for pattern in ["f.####.exr", "f.%04d.exr"] {
            assert_eq!(
                made(&[path(pattern)], Some(&path("o_%03d.png"))),
                Ok(vec![
                    "f.0002.exr o_002.png".to_owned(),
                    "f.0010.exr o_010.png".to_owned(),
                    "f.12345.exr o_12345.png".to_owned(),
                ])
            );
        }
        assert_eq!(
            made(&[path("f.%d.exr")], None).map(|made| made.len()),
            Ok(5),
        );
        let error = made(&[path("h.####.exr")], None).unwrap_err();
        assert!(error.starts_with("no frame has a name like"), "{error}");
        let error = made(&[path("f.####.exr")], Some(&path("one.png"))).unwrap_err();
        assert!(error.contains("name the outputs with ####"), "{error}");
    }

    #[test]
    fn what_is_rendered_is_found() {
        for pattern in ["f.####.exr", "f.%d.exr", "f.%03d.exr", "f.$F2.exr"] {
            let part = advice::frame_number(Path::new(pattern)).unwrap();
            let order = [
                "-12345.5", "-12", "-2", "-1.25", "-0.5", "0", "0.000001", "1", "1.25", "2", "10",
                "12345",
            ];
            let name = |number: &str| {
                let name = numbered(Path::new(pattern), &part, number);
                name.to_str().unwrap().to_owned()
            };
            let names: Vec<String> = order.iter().map(|number| name(number)).collect();
            let mut written: Vec<&str> = names.iter().map(String::as_str).collect();
            written.reverse();
            let folder = folder(&written);
            let path = folder.path().join(pattern);
            let inputs = sequence(&path, &part).unwrap();
            let inputs: Vec<&str> = inputs
                .iter()
                .map(|found| found.path.file_name().unwrap().to_str().unwrap())
                .collect();
            assert_eq!(inputs, names, "{pattern}");
            // Pictures have the numbers of what they are of.
            let output = folder.path().join("o.####.png");
            let made = conversions(&[path], Some(&output), "png").unwrap();
            let output = numbered(&output, "####", "-1.25");
            assert_eq!(made[3].output, output);
            assert!(output.ends_with("o.-001.25.png"));
        }
    }

    #[test]
    fn what_is_no_number_of_a_frame_is_left() {
        for (text, least) in [
            ("", 1),
            ("-", 1),
            (".5", 1),
            ("1.", 1),
            ("1.50", 1),
            ("1.0000001", 1),
            ("1.2.3", 1),
            ("+1", 1),
            ("1e5", 1),
            ("01", 4),
            ("00001", 4),
            ("-0001", 4),
            ("-01", 4),
        ] {
            assert!(!is_of_frame(text, least), "{text}");
        }
    }

    #[test]
    fn numbers_have_limits() {
        assert_eq!(padding("%d"), 1);
        assert_eq!(padding("%0d"), 1);
        assert_eq!(padding("%04d"), 4);
        for part in ["%065536d", "%99999999999999999999d", "%300d"] {
            assert_eq!(padding(part), MOST_DIGITS);
            let name = numbered(Path::new(part), part, "7");
            assert_eq!(name.as_os_str().len(), MOST_DIGITS);
        }
        assert_eq!(padding(&"#".repeat(1000)), MOST_DIGITS);
    }

    #[test]
    fn patterns_and_lists() {
        let folder = folder(&["a1.exr", "b.exr", "#.exr", "x.##.exr"]);
        let path = |name: &str| folder.path().join(name);
        assert_eq!(
            made(&[path("[ab]*.exr")], Some(folder.path())),
            Ok(vec!["a1.exr a1.png".to_owned(), "b.exr b.png".to_owned()])
        );
        assert_eq!(
            made(&[path("b.exr"), path("a1.exr")], None),
            Ok(vec!["b.exr b.png".to_owned(), "a1.exr a1.png".to_owned()])
        );
        // A file of that very name is meant.
        assert_eq!(
            made(&[path("x.##.exr")], None),
            Ok(vec!["x.##.exr x.##.png".to_owned()])
        );
        // The number of the name itself.
        assert_eq!(
            made(&[path("a1.exr")], Some(&path("o.####.png"))),
            Ok(vec!["a1.exr o.0001.png".to_owned()])
        );
        let error = made(&[path("b.exr")], Some(&path("o.####.png"))).unwrap_err();
        assert!(error.contains("has no number"), "{error}");
        let error = made(&[path("a*.png")], None).unwrap_err();
        assert!(error.starts_with("no file has a name like"), "{error}");
        let error = made(&[path("b.exr"), path("c.png")], None).unwrap_err();
        assert!(error.contains("a file to write is named by -o"), "{error}");
        let error = made(&[path("b.exr"), path("b.exr")], None).unwrap_err();
        assert!(error.contains("would both become b.png"), "{error}");
    }

    #[test]
    fn a_single_file() {
        let made = conversions(&[PathBuf::from("a/b.c.exr")], None, "png").unwrap();
        assert_eq!(made[0].output, Path::new("b.c.png"));
        for input in ["-", "/dev/stdin"] {
            let error = conversions(&[PathBuf::from(input)], None, "png").unwrap_err();
            assert!(error.to_string().ends_with("give it one with -o OUT.png"));
        }
        let made = conversions(&[PathBuf::from("-")], Some(Path::new("-")), "png").unwrap();
        assert_eq!(made[0].output, Path::new("-"));
    }
}
