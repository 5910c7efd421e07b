//! What a picture is written as, by the name of its file.

use std::path::Path;

use super::Bits;

/// A format that is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputFormat {
    /// PNG: 8 or 16 bits, with tags and provenance.
    Png,
    /// TIFF 6.0, not compressed: 8 or 16 bits, or floats.
    Tiff,
}

impl OutputFormat {
    /// TIFF for names in `.tif` and `.tiff`, PNG for all others, standard output among them.
    pub fn of(path: &Path) -> Self {
        let is_tiff = path.extension().is_some_and(|extension| {
            ["tif", "tiff"]
                .iter()
                .any(|tiff| extension.eq_ignore_ascii_case(tiff))
        });
        if is_tiff { Self::Tiff } else { Self::Png }
    }

    /// Whether the format has samples of so many bits.
    pub const fn holds(self, bits: Bits) -> bool {
        match (self, bits) {
            (Self::Png, Bits::Eight | Bits::Sixteen) | (Self::Tiff, _) => true,
            (Self::Png, Bits::ThirtyTwo) => false,
        }
    }

    /// The name in messages.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Tiff => "TIFF",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_say_the_format() {
        for (name, format) in [
            ("a.png", OutputFormat::Png),
            ("a", OutputFormat::Png),
            ("-", OutputFormat::Png),
            ("a.tif", OutputFormat::Tiff),
            ("b/a.b.TIFF", OutputFormat::Tiff),
        ] {
            assert_eq!(OutputFormat::of(Path::new(name)), format, "{name}");
        }
    }
}
