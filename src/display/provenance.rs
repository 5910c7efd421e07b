//! Where a picture comes from, as texts of a PNG.

use crate::printable::shell_word;

use super::{Cube, DisplayError, Input, Measure, Settings, View};

/// What a picture was made of.
#[derive(Clone, Debug)]
pub(super) struct Provenance {
    /// The name of the text that says what it was made of.
    key: &'static str,
    /// A SHA-256 hash in hexadecimal digits.
    hash: String,
    layer: Option<String>,
}

impl Provenance {
    /// Of a file, or of what came through a pipe.
    pub(super) fn of_input(input: &Input) -> Result<Self, DisplayError> {
        Ok(Self {
            key: "candela:source",
            hash: input.hash()?.to_string(),
            layer: input.layer().map(str::to_owned),
        })
    }

    /// Of a scene, by the hash that its EXR has as well.
    pub(super) fn of_scene(hash: &str) -> Self {
        Self {
            key: "candela:scene_sha256",
            hash: hash.to_owned(),
            layer: None,
        }
    }

    /// Keys and texts: the same for the same picture and settings, whatever its file is called.
    pub(super) fn texts(&self, settings: &Settings<'_>, ev: f64) -> Vec<(String, String)> {
        let software = concat!("candela ", env!("CARGO_PKG_VERSION"));
        [
            ("Software", software.to_owned()),
            ("candela:view", settings.view.name().to_owned()),
            ("candela:exposure", format!("{ev} EV")),
            (self.key, self.hash.clone()),
            ("candela:command", self.command(settings, ev)),
        ]
        .map(|(key, text)| (key.to_owned(), text))
        .into()
    }

    /// The options that make the picture again, all of them, since defaults may change.
    fn command(&self, settings: &Settings<'_>, ev: f64) -> String {
        let Settings {
            exposure: _, // As a number, which does not depend on a crop.
            view,
            bits,
            alpha,
            dither,
            frame: _,
            screen,
            white_luminance,
            white,
            gamut,
            input,
            shows_invalid,
            false_color,
            cube,
            drawn,
        } = settings;
        let view = match (view, false_color.measure()) {
            (View::FalseColor, Measure::Luminance | Measure::Illuminance) => {
                // Of the logarithms that it has, a rounding is left.
                let [least, most] = false_color.range().map(rounded);
                format!("false-color={least}:{most}")
            }
            (View::Cube, _) => {
                let name = cube.map_or("FILE.cube", Cube::name);
                format!("lut={name}")
            }
            (view, _) => view.name().to_owned(),
        };
        let mut words = vec!["candela tonemap".to_owned()];
        let mut option =
            |name: &str, value: &str| words.push(format!("--{name} {}", shell_word(value)));
        if let Some(layer) = &self.layer {
            option("layer", layer);
        }
        if let Some(input) = input {
            option("input-space", input.name().unwrap_or("rec709"));
        }
        option("exposure", &ev.to_string());
        if let Some([x, y]) = white {
            option("white-balance", &format!("{x},{y}"));
        }
        option("view", &view);
        if settings.view == View::FalseColor && false_color.measure() == Measure::Illuminance {
            option("unit", "lx");
        }
        option("display", screen.name());
        if let Some(luminance) = white_luminance {
            option("white-nits", &luminance.to_string());
        }
        option("gamut", gamut.name());
        option("bits", &bits.number().to_string());
        option("alpha", alpha.name());
        option("dither", dither.name());
        if *shows_invalid {
            words.push("--show-invalid".to_owned());
        }
        if !drawn.options.is_empty() {
            words.push(drawn.options.to_owned());
        }
        words.join(" ")
    }
}

/// To twelve digits.
fn rounded(number: f64) -> f64 {
    format!("{number:.11e}").parse().unwrap_or(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_makes_the_picture_again() {
        let mut provenance = Provenance::of_scene("ab");
        provenance.layer = Some("S0.550,000000nm".to_owned());
        let texts = provenance.texts(&Settings::default(), -1.5);
        let expected = "candela tonemap --layer S0.550,000000nm --exposure -1.5 --view srgb --display srgb --gamut clip \
                        --bits 8 --alpha auto --dither blue";
        assert_eq!(texts[4].1, expected);
        assert_eq!(
            texts[3],
            ("candela:scene_sha256".to_owned(), "ab".to_owned())
        );
        assert_eq!(shell_word("it's"), r"'it'\''s'");
        assert_eq!(shell_word(""), "''");
    }
}
