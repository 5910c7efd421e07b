//! The tables of the scene format: which keys an entry has, what each holds, and how one speaks of it.
//!
//! The reader takes no key that is not in the table of its entry, and [the schema](super::super::schema())
//! is made of the same tables. `tests/schema.rs` holds both against each other, value by value.

use std::ops::Bound;

use super::super::diagnostic::Problem;

/// A key: its name, what it holds, and how errors and editors describe it.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct Key {
    pub(in crate::scene) name: &'static str,
    /// "a length in scene units, such as `0.5`"
    pub(in crate::scene) value: &'static str,
    /// "a length in scene units, such as `radius = 0.5`"
    pub(in crate::scene) line: &'static str,
    /// `0.5`
    pub(in crate::scene) example: &'static str,
    pub(in crate::scene) kind: Kind,
    pub(in crate::scene) presence: Presence,
    /// A sentence or two for whoever edits a scene: what it is, unit, range.
    pub(in crate::scene) about: &'static str,
    /// What it is called elsewhere: in other formats, in equations, in other spellings.
    pub(in crate::scene) also: &'static [&'static str],
}

/// Whether a key must be there.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) enum Presence {
    Required,
    /// It may be left out, and nothing stands for it.
    Optional,
    /// This value, as TOML, stands where the key does not.
    Default(&'static str),
    /// It must be there where the value of this other key is not zero.
    With(&'static str),
    /// It must be there where this other key is not, and may not where it is.
    InsteadOf(&'static str),
}

/// A range of numbers.
pub(in crate::scene) type Range = (Bound<f64>, Bound<f64>);

/// What a key holds.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) enum Kind {
    Number(Range),
    /// Three coordinates.
    Vector,
    /// Three coordinates, not all of them 0.
    Direction,
    /// Three vectors.
    Corners,
    /// A factor, or three of them; none is 0.
    Factors,
    /// Width and height.
    Pixels,
    /// Two lengths.
    Sides,
    /// A whole number from 1 to this.
    Whole(u32),
    /// A whole number from 0 to this.
    Count(u32),
    Boolean,
    Text,
    /// A name as those of lights.
    LightName,
    /// One of these.
    Name(fn() -> Vec<&'static str>),
    /// A value for light or color; if it is said as RGB, its channels are at most this.
    Value(Purpose, f64),
    /// Three channels, from 0.
    Channels,
    /// Two or more wavelengths.
    Wavelengths,
    /// Two or more numbers from 0.
    Amounts,
    /// Pairs of a wavelength and an amount.
    Lines,
    /// A number from 0, or a curve.
    Density,
    /// Pairs of a frame and a value.
    Keys,
}

/// What a value is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum Purpose {
    /// The intensity of a light, which has a size.
    Light,
    /// The illuminance of a light without a place, which has a size.
    Illuminance,
    /// The luminance of a light with an area, which has a size.
    Luminance,
    /// The color of a light whose size is beside it.
    Color,
    /// Radiance without a lamp.
    Background,
    /// A reflectance.
    Surface,
    /// A refractive index, or its imaginary part.
    Index,
    /// A refractive index of what lets light through.
    GlassIndex,
}

/// The largest coordinate, length and factor.
pub(in crate::scene) const LARGEST: f64 = 1e30;

/// Lengths in scene units.
pub(in crate::scene) const LENGTH: Range = (Bound::Excluded(0.0), Bound::Included(LARGEST));

/// Lengths of lights in scene units: of squares and reciprocals of these, f64 is far from its ends.
pub(in crate::scene) const EXTENT: Range = (Bound::Included(1e-15), Bound::Included(1e15));

/// Amounts of light, which are kept in 32-bit floating point.
pub(in crate::scene) const AMOUNT: Range = (Bound::Included(0.0), Bound::Included(BRIGHTEST));

/// The largest amount of light.
pub(super) const BRIGHTEST: f64 = f32::MAX as f64;

/// The keys that one table may hold, and what people look for in it that is not there.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct Form<'k> {
    /// In the order of the documentation.
    pub(in crate::scene) keys: &'k [&'static Key],
    pub(in crate::scene) elsewhere: &'static [Elsewhere],
}

/// Words for what is not a key here, but may be said otherwise.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct Elsewhere {
    /// In lower case.
    pub(in crate::scene) words: &'static [&'static str],
    /// The key that says it, if one does.
    pub(in crate::scene) key: Option<&'static str>,
    /// The way out: a sentence without a full stop.
    pub(in crate::scene) advice: &'static str,
}

impl Purpose {
    /// The least number that may stand there.
    pub(in crate::scene) const fn least(self) -> f64 {
        match self {
            Self::GlassIndex => 1.0,
            Self::Light
            | Self::Illuminance
            | Self::Luminance
            | Self::Color
            | Self::Background
            | Self::Surface
            | Self::Index => 0.0,
        }
    }

    /// Whether it is a number at each wavelength and no color.
    pub(in crate::scene) const fn is_index(self) -> bool {
        matches!(self, Self::Index | Self::GlassIndex)
    }
}

impl Key {
    /// See [`key!`].
    pub(super) const fn new(
        name: &'static str,
        example: &'static str,
        value: &'static str,
        line: &'static str,
    ) -> Self {
        Self {
            name,
            value,
            line,
            example,
            kind: Kind::Text,
            presence: Presence::Required,
            about: "",
            also: &[],
        }
    }

    pub(super) const fn of(mut self, kind: Kind) -> Self {
        self.kind = kind;
        self
    }

    pub(super) const fn about(mut self, about: &'static str) -> Self {
        self.about = about;
        self
    }

    pub(super) const fn optional(mut self) -> Self {
        self.presence = Presence::Optional;
        self
    }

    pub(super) const fn or(mut self, default: &'static str) -> Self {
        self.presence = Presence::Default(default);
        self
    }

    pub(super) const fn with(mut self, other: &'static str) -> Self {
        self.presence = Presence::With(other);
        self
    }

    pub(super) const fn instead_of(mut self, other: &'static str) -> Self {
        self.presence = Presence::InsteadOf(other);
        self
    }

    pub(super) const fn also(mut self, words: &'static [&'static str]) -> Self {
        self.also = words;
        self
    }
}

impl<'k> Form<'k> {
    pub(super) const fn new(keys: &'k [&'static Key]) -> Self {
        Self {
            keys,
            elsewhere: &[],
        }
    }

    pub(super) const fn elsewhere(mut self, elsewhere: &'static [Elsewhere]) -> Self {
        self.elsewhere = elsewhere;
        self
    }

    pub(super) fn has(&self, name: &str) -> bool {
        self.keys.iter().any(|key| key.name == name)
    }

    /// What to say of a key that is not here: its word here, or the way out, or the nearest name.
    pub(super) fn unknown(&self, name: &str) -> Problem {
        let word = name.to_lowercase().replace('-', "_");
        if let Some(key) = self.keys.iter().find(|key| key.also.contains(&&*word)) {
            return Problem::OtherWord {
                what: "key",
                name: name.to_owned(),
                meant: key.name,
            };
        }
        unknown(
            "key",
            name,
            self.keys.iter().map(|key| key.name),
            self.elsewhere,
        )
    }
}

/// What to say of a name that is not among `names`: the way out if it is told `elsewhere`, or the
/// nearest name.
pub(super) fn unknown(
    what: &'static str,
    name: &str,
    names: impl IntoIterator<Item = &'static str>,
    elsewhere: &[Elsewhere],
) -> Problem {
    let word = name.to_lowercase().replace('-', "_");
    let told = elsewhere.iter().find(|place| place.words.contains(&&*word));
    told.map_or_else(
        || Problem::unknown(what, name, names),
        |place| Problem::Elsewhere {
            what,
            name: name.to_owned(),
            key: place.key,
            advice: place.advice.into(),
        },
    )
}

/// `key!("radius", "a length in scene units", "0.5")`: name, meaning, example.
macro_rules! key {
    ($name:literal, $meaning:literal, $example:literal) => {
        $crate::scene::read::key::Key::new(
            $name,
            $example,
            concat!($meaning, ", such as `", $example, "`"),
            concat!($meaning, ", such as `", $name, " = ", $example, "`"),
        )
    };
}
pub(super) use key;

#[cfg(test)]
mod tests {
    use super::super::outline;
    use super::*;

    /// The tables of all kinds of entry.
    fn forms() -> Vec<Form<'static>> {
        let mut forms = vec![outline::image()];
        let named = outline::named()
            .into_iter()
            .flat_map(|section| section.kinds);
        forms.extend(
            outline::cameras()
                .into_iter()
                .chain(named)
                .map(|kind| kind.form),
        );
        forms
    }

    #[test]
    fn every_word_has_one_meaning() {
        for form in forms() {
            let names = form.keys.iter().map(|key| key.name);
            let words = form.keys.iter().flat_map(|key| key.also.iter().copied());
            let told = form
                .elsewhere
                .iter()
                .flat_map(|place| place.words.iter().copied());
            let mut all: Vec<&str> = names.chain(words).chain(told).collect();
            let folded = all
                .iter()
                .all(|word| word.to_lowercase().replace('-', "_") == *word);
            assert!(folded, "{all:?}");
            all.sort_unstable();
            let twice: Vec<_> = all.windows(2).filter(|pair| pair[0] == pair[1]).collect();
            assert!(twice.is_empty(), "{twice:?}");
        }
    }

    #[test]
    fn every_word_leads_to_its_key() {
        for form in forms() {
            for key in form.keys {
                for word in key.also {
                    let problem = form.unknown(&word.to_uppercase());
                    assert_eq!(problem.nearest(), Some(key.name), "{word}");
                }
            }
            for place in form.elsewhere {
                let named = place.key.is_none_or(|name| form.has(name));
                assert!(named, "{:?}", place.key);
                for word in place.words {
                    let problem = form.unknown(word);
                    assert!(
                        matches!(problem, Problem::Elsewhere { advice, .. } if advice == place.advice)
                    );
                }
            }
        }
    }
}
