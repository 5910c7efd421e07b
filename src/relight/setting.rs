//! What is to become of a light, as it is written: `key=2`, `key=off`, `key=#ff8040`, `key=2,{blackbody=3200}`.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use crate::printable::{is_printable, shortened};

/// What is to become of one light, of the lights of a group, or of the background.
#[derive(Clone, Debug, PartialEq)]
pub struct Setting {
    text: String,
    name: String,
    factor: f64,
    /// Where in the text the color stands.
    color: Option<Range<usize>>,
}

/// What begins a color, as opposed to a factor.
const COLOR_STARTS: [char; 3] = ['#', '{', '['];

impl Setting {
    /// The name of the light, of the group, or `background`.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What its intensity is multiplied by. Range: 0 or more.
    pub const fn factor(&self) -> f64 {
        self.factor
    }

    /// Its new color, as a scene's `color` would have it, but without the quotes around `#rrggbb`.
    pub fn color(&self) -> Option<&str> {
        Some(&self.text[self.color_place()?])
    }

    /// Where in its text the color stands.
    pub(super) fn color_place(&self) -> Option<Range<usize>> {
        self.color.clone()
    }

    /// Whether all stays as it is.
    pub(super) fn is_nothing(&self) -> bool {
        self.factor == 1.0 && self.color.is_none()
    }
}

impl fmt::Display for Setting {
    /// As it was written.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

/// Why a text is no [`Setting`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingError {
    /// It has no name, or nothing behind it.
    #[error(
        "expected NAME=VALUE, such as key=2, key=off, key=#ff8040, key={{blackbody=3200}} or key=2,#ff8040"
    )]
    NoValue,
    /// A factor that is no number from 0 on.
    #[error(
        "`{}` is no factor, expected a number from 0 to 3.4e38, or off; a color begins with `#`, `{{` or `[`",
        shortened(.0)
    )]
    NoFactor(String),
    /// What stands behind a factor is no color.
    #[error(
        "`{}` behind the factor is no color, expected #rrggbb, {{…}} or [r, g, b], such as key=2,#ff8040",
        shortened(.0)
    )]
    NoColor(String),
    /// A color with a line end or another character that does not print.
    #[error("a color is on one line, of characters that print")]
    Unprintable,
}

impl FromStr for Setting {
    type Err = SettingError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let text = text.trim();
        let (name, value) = text.split_once('=').ok_or(SettingError::NoValue)?;
        let name = name.trim_end();
        let value = value.trim_start();
        if name.is_empty() || value.is_empty() {
            return Err(SettingError::NoValue);
        }
        let (factor, color) = if value.starts_with(COLOR_STARTS) {
            (1.0, Some(value))
        } else {
            let (written, color) = match value.split_once(',') {
                None => (value, None),
                Some((factor, color)) => (factor.trim_end(), Some(color.trim_start())),
            };
            (factor(written)?, color)
        };
        if let Some(color) = color {
            if !color.starts_with(COLOR_STARTS) {
                return Err(SettingError::NoColor(color.to_owned()));
            }
            if !color.chars().all(is_printable) {
                return Err(SettingError::Unprintable);
            }
        }
        Ok(Self {
            name: name.to_owned(),
            factor,
            // It is the end of the text.
            color: color.map(|color| text.len() - color.len()..text.len()),
            text: text.to_owned(),
        })
    }
}

fn factor(written: &str) -> Result<f64, SettingError> {
    if written == "off" {
        return Ok(0.0);
    }
    let factor = written.parse().ok();
    let factor = factor.filter(|factor| (0.0..=f64::from(f32::MAX)).contains(factor));
    // Without the sign that −0 has.
    factor
        .map(f64::abs)
        .ok_or_else(|| SettingError::NoFactor(written.to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_understood() {
        for (text, name, factor, color) in [
            ("key=2.0", "key", 2.0, None),
            ("key = 2", "key", 2.0, None),
            ("fill=off", "fill", 0.0, None),
            ("fill=-0", "fill", 0.0, None),
            ("rim=#ff8040", "rim", 1.0, Some("#ff8040")),
            ("key={blackbody=3200}", "key", 1.0, Some("{blackbody=3200}")),
            ("key=2,#ff8040", "key", 2.0, Some("#ff8040")),
            (
                " key = 1e-3 , [1, 0.5, 0] ",
                "key",
                1e-3,
                Some("[1, 0.5, 0]"),
            ),
            (
                "key left=off,{rgb=[1,2,3],space=\"acescg\"}",
                "key left",
                0.0,
                Some("{rgb=[1,2,3],space=\"acescg\"}"),
            ),
        ] {
            let setting: Setting = text.parse().unwrap();
            assert_eq!(setting.name(), name, "{text}");
            assert_eq!(setting.factor().to_bits(), f64::to_bits(factor), "{text}");
            assert_eq!(setting.color(), color, "{text}");
            assert_eq!(setting.to_string(), text.trim());
        }
    }

    #[test]
    fn what_is_none_says_what_would_be() {
        for (text, part) in [
            ("", "expected NAME=VALUE"),
            ("key", "expected NAME=VALUE"),
            ("=2", "expected NAME=VALUE"),
            ("key=", "expected NAME=VALUE"),
            ("key=-1", "`-1` is no factor"),
            ("key=inf", "`inf` is no factor"),
            ("key=nan", "`nan` is no factor"),
            ("key=1e39", "`1e39` is no factor"),
            ("key=red", "`red` is no factor"),
            ("key=2,", "`` behind the factor is no color"),
            ("key=2,red", "`red` behind the factor is no color"),
            ("key={blackbody=\n3200}", "on one line"),
        ] {
            let message = text.parse::<Setting>().unwrap_err().to_string();
            assert!(message.contains(part), "{text}: {message}");
        }
    }
}
