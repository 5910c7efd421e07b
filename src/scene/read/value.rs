//! Values for light and color, in every notation.

use toml::de::{DeTable, DeValue};

use super::super::diagnostic::{Problem, Spanned};
use super::super::value::{ColorSpace, Value};
use super::Node;
use super::fields::{Fields, Key, Reader, key, spanned};

const RGB: Key = key!("rgb", "three linear numbers", "[0.7, 0.3, 0.2]");
const SPACE: Key = key!("space", "the name of a color space", "\"rec709\"");

/// What can be written for a value that this version does not read yet.
const VALUES_TODAY: &str = "write a number such as `0.5`, `[r, g, b]` in linear Rec.709, \
                            or `\"#rrggbb\"`";

/// Notations that the format has for every value, but this version does not read.
const SPECTRA: [&str; 5] = ["illuminant", "blackbody", "wavelengths", "values", "file"];

/// Notations that the format has for lights only: a size in a unit.
const SIZES: [&str; 4] = ["candela", "lumens", "watts", "color"];

/// What a value is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// Light, which can have its size in a unit beside its color.
    Light,
    /// A reflectance.
    Surface,
}

impl Fields<'_, '_, '_> {
    pub(super) fn value(&mut self, key: &'static Key, purpose: Purpose) -> Option<Spanned<Value>> {
        let node = self.require(key)?;
        spanned(self.reader.value(key, node, purpose), node)
    }

    pub(super) fn value_or(
        &mut self,
        key: &Key,
        purpose: Purpose,
        default: Value,
    ) -> Option<Spanned<Value>> {
        match self.get(key) {
            Some(node) => spanned(self.reader.value(key, node, purpose), node),
            None => Some(Spanned::new(default, self.header)),
        }
    }

    /// A color space that this version works in; Rec.709 where the key is not there.
    pub(super) fn color_space(&mut self, key: &Key) -> Option<Spanned<ColorSpace>> {
        let Some(written) = self.optional_string(key)? else {
            return Some(Spanned::new(ColorSpace::default(), self.header));
        };
        let names = ColorSpace::ALL.map(ColorSpace::name);
        let Some(&space) = ColorSpace::ALL
            .iter()
            .find(|space| space.name() == written.value)
        else {
            let problem = Problem::unknown("color space", &written.value, names);
            self.reader.report(written.span, problem);
            return None;
        };
        if space != ColorSpace::Rec709 {
            let problem = Problem::NotYet {
                what: format!("`{} = \"{}\"`", key.name, space.name()),
                instead: "write `\"rec709\"`",
            };
            self.reader.report(written.span, problem);
            return None;
        }
        Some(Spanned::new(space, written.span))
    }
}

impl Reader<'_> {
    fn value(&mut self, key: &Key, node: &Node<'_>, purpose: Purpose) -> Option<Value> {
        match node.get_ref() {
            DeValue::Integer(_) | DeValue::Float(_) => {
                self.number(key, key.name, node).map(Value::Uniform)
            }
            DeValue::Array(_) => {
                let rgb = self.numbers(key, key.name, node)?;
                Some(Value::Rgb {
                    rgb,
                    space: ColorSpace::Rec709,
                })
            }
            DeValue::String(text) => {
                let color = srgb(text);
                if color.is_none() {
                    let expected = if text.starts_with('#') {
                        "`#` and six hexadecimal digits, such as `\"#c86432\"`"
                    } else {
                        key.value
                    };
                    self.wrong_type(key.name, node, expected);
                }
                color.map(Value::Srgb)
            }
            DeValue::Table(table) => self.value_table(node, table, purpose),
            DeValue::Boolean(_) | DeValue::Datetime(_) => {
                self.wrong_type(key.name, node, key.value);
                None
            }
        }
    }

    fn value_table(
        &mut self,
        node: &Node<'_>,
        table: &DeTable<'_>,
        purpose: Purpose,
    ) -> Option<Value> {
        let not_yet = table.iter().find(|(key, _)| {
            SPECTRA.contains(&key.get_ref().as_ref())
                || (purpose == Purpose::Light && SIZES.contains(&key.get_ref().as_ref()))
        });
        if let Some((key, _)) = not_yet {
            let problem = Problem::NotYet {
                what: format!("a value by `{}`", key.get_ref()),
                instead: VALUES_TODAY,
            };
            self.report(key.span().into(), problem);
            return None;
        }
        let mut fields = Fields::new(self, table, node.span().into());
        let rgb = match fields.require(&RGB) {
            Some(node) => fields.reader.numbers(&RGB, RGB.name, node),
            None => None,
        };
        let space = fields.color_space(&SPACE);
        fields.finish()?;
        Some(Value::Rgb {
            rgb: rgb?,
            space: space?.value,
        })
    }
}

/// `#rrggbb`, in either case.
fn srgb(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#')?;
    if digits.len() != 6 || !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return None;
    }
    let channels = u32::from_str_radix(digits, 16).ok()?.to_be_bytes();
    Some([channels[1], channels[2], channels[3]])
}
