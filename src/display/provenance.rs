//! Where a picture comes from, as texts of a PNG.

use super::{DisplayError, Dither, Input, Settings};

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
    pub(super) fn texts(&self, settings: &Settings, ev: f64) -> Vec<(String, String)> {
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
    fn command(&self, settings: &Settings, ev: f64) -> String {
        let Settings {
            exposure: _, // As a number, which does not depend on a crop.
            view,
            bits,
            alpha,
            dither,
            frame: _,
        } = settings;
        let layer = self
            .layer
            .as_deref()
            .map_or_else(String::new, |layer| format!(" --layer {}", word(layer)));
        format!(
            "candela tonemap{layer} --exposure {ev} --view {} --bits {} --alpha {} --dither {}",
            view.name(),
            bits.number(),
            alpha.name(),
            Dither::name(*dither),
        )
    }
}

/// A text as a word of the shell.
fn word(text: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_.,:/+-".contains(c);
    if !text.is_empty() && text.chars().all(is_plain) {
        return text.to_owned();
    }
    format!("'{}'", text.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_makes_the_picture_again() {
        let mut provenance = Provenance::of_scene("ab");
        provenance.layer = Some("S0.550,000000nm".to_owned());
        let texts = provenance.texts(&Settings::default(), -1.5);
        let expected = "candela tonemap --layer S0.550,000000nm --exposure -1.5 --view srgb --bits 8 --alpha auto \
                        --dither blue";
        assert_eq!(texts[4].1, expected);
        assert_eq!(
            texts[3],
            ("candela:scene_sha256".to_owned(), "ab".to_owned())
        );
        assert_eq!(word("it's"), r"'it'\''s'");
        assert_eq!(word(""), "''");
    }
}
