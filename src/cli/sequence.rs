//! Many files in one call: frames of a sequence, patterns, lists.

use std::collections::HashMap;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use candela::internal::printable_path;

use super::{Failure, advice};

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
            Some(output) => match (advice::frame_number(output), number) {
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
                    return Err(format!(
                        "more than one file cannot become {}; name the outputs with ####, as in \
                         f.####.{extension}, or give a folder",
                        printable_path(output)
                    )
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

/// The files that arguments stand for, as those of [`conversions`], each as often as it is named.
pub(super) fn inputs(arguments: &[PathBuf]) -> Result<Vec<PathBuf>, Failure> {
    let mut inputs = Vec::new();
    for argument in arguments {
        inputs.extend(files(argument)?.into_iter().map(|found| found.path));
    }
    Ok(inputs)
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
        return frames(argument, &part);
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
fn frames(pattern: &Path, part: &str) -> Result<Vec<Found>, Failure> {
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
    let mut numbered: Vec<(u64, Found)> = Vec::new();
    for entry in entries {
        let entry =
            entry.map_err(|error| format!("cannot list {}: {error}", printable_path(folder)))?;
        let entry = entry.file_name();
        let Some(digits) = entry.to_str().and_then(|entry| {
            let digits = entry.strip_prefix(before)?.strip_suffix(after)?;
            let is_padded = least == 1
                || digits.len() == least
                || digits.len() > least && !digits.starts_with('0');
            let is_number = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
            (is_padded && is_number).then_some(digits)
        }) else {
            continue;
        };
        let Ok(number) = digits.parse() else {
            continue;
        };
        let found = Found {
            path: pattern.with_file_name(&entry),
            number: Some(digits.to_owned()),
        };
        numbered.push((number, found));
    }
    numbered.sort_by_key(|(number, _)| *number);
    if numbered.is_empty() {
        return Err(format!(
            "no frame has a name like {}, with a number of at least {least} digits for `{part}`",
            printable_path(pattern)
        )
        .into());
    }
    Ok(numbered.into_iter().map(|(_, found)| found).collect())
}

/// How many digits a frame's number has at least.
fn padding(part: &str) -> usize {
    let hashes = part.chars().filter(|&c| c == '#').count();
    if hashes > 0 {
        return hashes;
    }
    let digits: String = part.chars().filter(char::is_ascii_digit).collect();
    digits.parse().unwrap_or(1).max(1)
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

/// A frame's name: the number in the place of the part that stands for it.
fn numbered(pattern: &Path, part: &str, number: &str) -> PathBuf {
    let name = pattern
        .file_name()
        .and_then(OsStr::to_str)
        .unwrap_or_default();
    let number = number.trim_start_matches('0');
    let width = padding(part);
    pattern.with_file_name(name.replacen(part, &format!("{number:0>width$}"), 1))
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
