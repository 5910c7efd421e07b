//! Lines in the manner of other formats (YAML, JSON, Python, pbrt, C), in a file that is not TOML for
//! them: what to write instead.

use crate::printable::shortened;

/// What to say of a line with a syntax error, where it is one that a habit makes.
pub(super) fn way_out(line: &str) -> Option<String> {
    let line = line.trim();
    if ["//", "/*", ";", "--"]
        .iter()
        .any(|start| line.starts_with(start))
    {
        return Some("comments begin with `#`".to_owned());
    }
    let (key, rest) = key(line)?;
    let before = rest.len();
    let rest = rest.trim_start();
    let is_parted = rest.len() < before;
    let (sign, value) = ["==", "=>", ":=", "=", ":"]
        .iter()
        .find_map(|sign| rest.strip_prefix(sign).map(|value| (*sign, value)))
        .unwrap_or(("", rest));
    if value.contains("//") {
        return Some("comments begin with `#`".to_owned());
    }
    // Without a sign it may be anything; two words are a key and its value where the second is one.
    if sign.is_empty()
        && !(is_parted && value.starts_with(|c: char| c.is_ascii_digit() || "-\"[".contains(c)))
    {
        return None;
    }
    let bare = value.split('#').next().unwrap_or(value).trim();
    let (bare, end) = match bare.strip_suffix([',', ';']) {
        Some(before) => (before.trim_end(), &bare[before.len()..]),
        None => (bare, ""),
    };
    if bare.is_empty() {
        return match sign {
            ":" | ":=" | "=>" => Some(format!(
                "a section has a header, such as `[{}]`",
                shortened(key)
            )),
            _ => None,
        };
    }
    let written = as_toml(bare);
    let wanted = || {
        format!(
            "write `{} = {}`",
            shortened(key),
            shortened(written.as_deref().unwrap_or(bare))
        )
    };
    match (sign, written.is_some()) {
        ("=", false) if end.is_empty() => None,
        ("=", false) => Some(format!("a line ends without `{end}`; {}", wanted())),
        ("" | "=", _) => Some(format!("this is not TOML; {}", wanted())),
        _ => Some(format!("a key has `=` and its value; {}", wanted())),
    }
}

/// The key that a line begins with, and what follows.
fn key(line: &str) -> Option<(&str, &str)> {
    let quote = line
        .chars()
        .next()
        .filter(|first| matches!(first, '"' | '\''));
    let line = line.trim_start_matches(['"', '\'']);
    let is_in = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-' | '.');
    let end = line.find(|c| !is_in(c)).unwrap_or(line.len());
    let (key, rest) = line.split_at(end);
    let rest = match quote {
        Some(quote) => rest.strip_prefix(quote)?,
        None => rest,
    };
    let is_key = key.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_');
    is_key.then_some((key, rest))
}

/// A value of another format as TOML, where it is none.
fn as_toml(value: &str) -> Option<String> {
    match value {
        "True" | "TRUE" | "yes" | "on" => return Some("true".to_owned()),
        "False" | "FALSE" | "no" | "off" => return Some("false".to_owned()),
        _ => {}
    }
    if let Some(number) = number(value) {
        return (number != value).then_some(number);
    }
    let inner = [('(', ')'), ('{', '}'), ('<', '>')]
        .iter()
        .find_map(|&(open, close)| value.strip_prefix(open)?.strip_suffix(close));
    let is_list = inner.is_some();
    let numbers: Vec<String> = inner
        .unwrap_or(value)
        .split([',', ' ', '\t'])
        .filter(|part| !part.is_empty())
        .map(number)
        .collect::<Option<_>>()?;
    // A single comma may be a decimal one, of which another message speaks.
    let is_list = is_list || numbers.len() > 2 || !value.contains(',');
    is_list.then(|| format!("[{}]", numbers.join(", ")))
}

/// A number as TOML has it: `.5` is 0.5, `5.` is 5.0, `0.5f` is 0.5.
fn number(text: &str) -> Option<String> {
    let text = text.strip_suffix(['f', 'F']).unwrap_or(text);
    let (sign, digits) = match text.strip_prefix(['-', '+']) {
        Some(digits) => (&text[..1], digits),
        None => ("", text),
    };
    let is_number = digits.parse::<f64>().is_ok_and(f64::is_finite);
    if !is_number {
        return None;
    }
    let before = if digits.starts_with('.') { "0" } else { "" };
    let after = if digits.ends_with('.') { "0" } else { "" };
    Some(format!("{sign}{before}{digits}{after}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_formats_are_understood() {
        for (line, expected) in [
            (
                "radius: 0.5",
                "a key has `=` and its value; write `radius = 0.5`",
            ),
            (
                "  \"radius\": 0.5,",
                "a key has `=` and its value; write `radius = 0.5`",
            ),
            (
                "'radius': .5",
                "a key has `=` and its value; write `radius = 0.5`",
            ),
            (
                "radius := 0.5  # big",
                "a key has `=` and its value; write `radius = 0.5`",
            ),
            (
                "radius == 0.5",
                "a key has `=` and its value; write `radius = 0.5`",
            ),
            (
                "material: \"clay\"",
                "a key has `=` and its value; write `material = \"clay\"`",
            ),
            (
                "center: [0, 1, 0]",
                "a key has `=` and its value; write `center = [0, 1, 0]`",
            ),
            (
                "center: 0 1 0",
                "a key has `=` and its value; write `center = [0, 1, 0]`",
            ),
            ("radius 0.5", "this is not TOML; write `radius = 0.5`"),
            ("radius = .5", "this is not TOML; write `radius = 0.5`"),
            ("radius = -5.", "this is not TOML; write `radius = -5.0`"),
            ("radius = 0.5f", "this is not TOML; write `radius = 0.5`"),
            (
                "radius = 0.5;",
                "a line ends without `;`; write `radius = 0.5`",
            ),
            (
                "radius = 0.5,",
                "a line ends without `,`; write `radius = 0.5`",
            ),
            (
                "center = (0, 1, .5)",
                "this is not TOML; write `center = [0, 1, 0.5]`",
            ),
            (
                "center = 0 1 0",
                "this is not TOML; write `center = [0, 1, 0]`",
            ),
            (
                "center = 0, 1, 0",
                "this is not TOML; write `center = [0, 1, 0]`",
            ),
            ("smooth = True", "this is not TOML; write `smooth = true`"),
            ("camera:", "a section has a header, such as `[camera]`"),
            ("// the camera", "comments begin with `#`"),
            ("radius = 0.5 // metres", "comments begin with `#`"),
        ] {
            assert_eq!(way_out(line).as_deref(), Some(expected), "{line}");
        }
    }

    #[test]
    fn what_is_no_habit_is_left_to_the_parser() {
        for line in [
            "",
            "[objects.ball",
            "radius = ",
            "radius = \"0.5",
            "radius = 0,5",
            "diffuse = 0.1,0.2",
            "material = clay",
            "radius",
            "two words",
            "= 5",
            "é: 5",
        ] {
            assert_eq!(way_out(line), None, "{line}");
        }
    }
}
