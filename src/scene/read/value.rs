//! Values for light and color, in every notation.

use std::path::Path;
use std::sync::Arc;

use toml::de::{DeTable, DeValue};

use super::super::diagnostic::{Problem, Span, Spanned};
use super::super::value::Value;
use super::Node;
use super::fields::{Fields, Reader, spanned};
use super::illuminant::{illuminant_called, temperature, unknown_illuminant};
use super::key::{Form, Key, Purpose};
use super::notation::{
    BLACKBODY, COLOR, DAYLIGHT, DENSITY, FILE, ILLUMINANT, LINES, Notation, RGB, SIZE,
    SIZE_OF_AREA, SIZE_OF_SUN, SPACE, VALUES, WAVELENGTHS,
};
use crate::color::ColorSpace;
use crate::printable::shortened;
use crate::spectrum::{Curve, CurveProblem, Illuminant, Lines};

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

    /// One of a few names; the default where the key is not there.
    pub(super) fn choice<T: Copy + Default>(
        &mut self,
        key: &Key,
        what: &'static str,
        all: &[T],
        name: impl Fn(T) -> &'static str,
    ) -> Option<Spanned<T>> {
        let Some(written) = self.optional_string(key)? else {
            return Some(Spanned::new(T::default(), self.header));
        };
        let Some(&choice) = all.iter().find(|choice| name(**choice) == written.value) else {
            let names = all.iter().map(|choice| name(*choice));
            let problem = Problem::unknown(what, &written.value, names);
            self.reader.report(written.span, problem);
            return None;
        };
        Some(Spanned::new(choice, written.span))
    }

    /// A color space; Rec.709 where the key is not there.
    pub(super) fn color_space(&mut self, key: &Key) -> Option<Spanned<ColorSpace>> {
        self.choice(key, "color space", &ColorSpace::ALL, ColorSpace::name)
    }
}

impl Reader<'_> {
    /// A value, which may move.
    fn value(&mut self, key: &Key, node: &Node<'_>, purpose: Purpose) -> Option<Value> {
        self.moving(node, |reader, node| reader.still_value(key, node, purpose))
    }

    fn still_value(&mut self, key: &Key, node: &Node<'_>, purpose: Purpose) -> Option<Value> {
        match node.get_ref() {
            DeValue::Integer(_) | DeValue::Float(_) => {
                self.number(key, key.name, node).map(Value::Uniform)
            }
            DeValue::Array(_) | DeValue::String(_) if purpose.is_index() => {
                self.wrong_type(key.name, node, key.value);
                None
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
                if let Some(table) = table_for(text, purpose)
                    && color.is_none()
                {
                    let conflict =
                        format!("`{}` is a text; write `{} = {table}`", key.name, key.name);
                    self.report(node.span().into(), Problem::Conflict(conflict));
                } else if color.is_none() {
                    let expected = if text.starts_with('#') {
                        "`#` and six hexadecimal digits, such as `\"#c86432\"`"
                    } else {
                        key.value
                    };
                    self.wrong_type(key.name, node, expected);
                }
                color.map(Value::Srgb)
            }
            DeValue::Table(_) if self.are_keys_within_keys(node) => None,
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
        let span = Span::from(node.span());
        let written = Notation::ALL
            .into_iter()
            .find(|notation| table.contains_key(notation.key().name));
        let Some(notation) = written else {
            self.no_notation(table, span, purpose);
            return None;
        };
        let key = notation.key();
        let mut sizes = Notation::ALL.into_iter().filter(|other| {
            matches!(other, Notation::Sized(_)) && table.contains_key(other.key().name)
        });
        if let (Some(first), Some(second)) = (sizes.next(), sizes.next()) {
            let second = second.key().name;
            let place = table.keys().find(|written| written.get_ref() == second);
            let place = place.map_or(span, |written| written.span().into());
            let conflict = format!(
                "`{second}` says the size a second time, beside `{}`; expected one of them",
                first.key().name
            );
            self.report(place, Problem::Conflict(conflict));
            return None;
        }
        if let Err(why) = notation.is_for(purpose) {
            let place = table.keys().find(|written| written.get_ref() == key.name);
            let place = place.map_or(span, |written| written.span().into());
            self.report(place, Problem::Conflict(format!("`{}` {why}", key.name)));
            return None;
        }
        let mut fields = Fields::new(self, notation.form(), table, span);
        let value = fields.notation(notation);
        fields.finish()?;
        value
    }

    /// Reports a table of which no key says what it is.
    fn no_notation(&mut self, table: &DeTable<'_>, span: Span, purpose: Purpose) {
        let notations = Notation::ALL.into_iter();
        let notations = notations.filter(|notation| notation.is_for(purpose).is_ok());
        let mut keys: Vec<&'static Key> = notations.map(Notation::key).collect();
        // A second key of a notation tells which one was meant; of another, the first is missing.
        let size = match purpose {
            Purpose::Light => Some(&SIZE),
            Purpose::Illuminance => Some(&SIZE_OF_SUN),
            Purpose::Luminance => Some(&SIZE_OF_AREA),
            Purpose::Color
            | Purpose::Background
            | Purpose::Surface
            | Purpose::Index
            | Purpose::GlassIndex => None,
        };
        let missing = if table.contains_key(COLOR.name) && size.is_some() {
            keys.push(&COLOR);
            size
        } else if table.contains_key(VALUES.name) || purpose.is_index() {
            keys.push(&VALUES);
            Some(&WAVELENGTHS)
        } else if table.is_empty() || table.contains_key(SPACE.name) {
            keys.push(&SPACE);
            Some(&RGB)
        } else {
            None
        };
        let mut fields = Fields::new(self, Form::new(&keys), table, span);
        if let Some(missing) = missing {
            fields.require(missing);
        }
        fields.finish();
    }
}

impl Fields<'_, '_, '_> {
    /// The value of a table in this notation.
    fn notation(&mut self, notation: Notation) -> Option<Value> {
        match notation {
            Notation::Rgb => {
                let node = self.require(&RGB);
                let rgb = node.and_then(|node| self.reader.moving_numbers(&RGB, node));
                let space = self.color_space(&SPACE);
                Some(Value::Rgb {
                    rgb: rgb?,
                    space: space?.value,
                })
            }
            Notation::Illuminant => self.illuminant().map(Value::Illuminant),
            Notation::Daylight => self.number(&DAYLIGHT).map(|t| Value::Daylight(t.value)),
            Notation::Blackbody => self.number(&BLACKBODY).map(|t| Value::Blackbody(t.value)),
            Notation::Curve => self.curve(),
            Notation::File => {
                let file = self.string(&FILE)?;
                self.reader.curve_file(&file).map(Value::Curve)
            }
            Notation::Lines => self.lines(),
            Notation::Sized(unit) => {
                let amount = self.number(notation.key());
                let Some(node) = self.get(&COLOR) else {
                    return Some(Value::sized(unit, amount?.value, 1.0));
                };
                // Lights of that size mix, rather than colors of any size.
                let size = amount.map_or(1.0, |amount| amount.value);
                let sized = self.reader.moving(node, |reader, node| {
                    let color = reader.still_value(&COLOR, node, Purpose::Color)?;
                    Some(Value::sized(unit, size, color))
                });
                amount.and(sized)
            }
            Notation::Density => self.density(),
        }
    }

    fn illuminant(&mut self) -> Option<Illuminant> {
        let name = self.string(&ILLUMINANT)?;
        let illuminant = Illuminant::named(&name.value);
        if illuminant.is_none() {
            self.reader
                .report(name.span, unknown_illuminant(&name.value));
        }
        illuminant
    }

    /// `{ wavelengths = […], values = […] }`
    fn curve(&mut self) -> Option<Value> {
        let (wavelengths, values) = (self.require(&WAVELENGTHS), self.require(&VALUES));
        let (wavelength_node, value_node) = (wavelengths?, values?);
        let wavelengths = self.reader.list(&WAVELENGTHS, wavelength_node);
        let values = self.reader.list(&VALUES, value_node);
        let curve = Curve::new(wavelengths?, values?);
        let place = |problem: &CurveProblem| {
            if problem.is_about_wavelength() {
                wavelength_node
            } else {
                value_node
            }
        };
        let curve = self.reader.legal(curve, place)?;
        Some(Value::Curve(Arc::new(curve)))
    }

    /// `{ lines = [[nm, W/sr], …] }`
    fn lines(&mut self) -> Option<Value> {
        let node = self.require(&LINES)?;
        let Some(items) = node.get_ref().as_array() else {
            self.reader.wrong_type(LINES.name, node, LINES.value);
            return None;
        };
        let lines: Vec<Option<[f64; 2]>> = items
            .iter()
            .enumerate()
            .map(|(i, item)| self.reader.numbers(&LINES, &format!("lines[{i}]"), item))
            .collect();
        let lines = lines.into_iter().collect::<Option<Vec<_>>>()?;
        let lines = self.reader.legal(Lines::new(lines), |_| node)?;
        Some(Value::Lines(Arc::new(lines)))
    }

    /// `{ watts_per_steradian_nm = … }`: a number, which is the same at every wavelength, or a
    /// curve.
    fn density(&mut self) -> Option<Value> {
        let node = self.require(&DENSITY)?;
        match node.get_ref() {
            DeValue::Integer(_) | DeValue::Float(_) => {
                let density = self.reader.number(&DENSITY, DENSITY.name, node)?;
                let ends = [crate::spectrum::FIRST, crate::spectrum::LAST].map(f64::from);
                let curve = Curve::new(ends.to_vec(), vec![density; 2]);
                let curve = self.reader.legal(curve, |_| node)?;
                Some(Value::Curve(Arc::new(curve)))
            }
            DeValue::Table(table) => {
                let is_other = |name: &str| {
                    let curve = [&WAVELENGTHS, &VALUES, &FILE].map(|key| key.name);
                    let mut known = Notation::ALL.iter().map(|notation| notation.key().name);
                    !curve.contains(&name) && known.any(|known| known == name)
                };
                if let Some(other) = table.keys().find(|key| is_other(key.get_ref())) {
                    let alone = if other.get_ref() == LINES.name {
                        "; lines are in W/sr, as a light's `intensity = { lines = … }`"
                    } else {
                        ""
                    };
                    let conflict = format!(
                        "`{}` cannot be in `{}`, which takes a number or a curve, such as \
                         `{{ wavelengths = [400, 550, 700], values = [0.1, 0.5, 0.4] }}`{alone}",
                        other.get_ref(),
                        DENSITY.name,
                    );
                    self.reader
                        .report(other.span().into(), Problem::Conflict(conflict));
                    return None;
                }
                let notation = if table.contains_key(FILE.name) {
                    Notation::File
                } else {
                    Notation::Curve
                };
                let span = node.span().into();
                let mut fields = Fields::new(self.reader, notation.form(), table, span);
                let value = fields.notation(notation);
                fields.finish()?;
                value
            }
            DeValue::String(_) | DeValue::Boolean(_) | DeValue::Datetime(_) | DeValue::Array(_) => {
                self.reader.wrong_type(DENSITY.name, node, DENSITY.value);
                None
            }
        }
    }
}

impl Reader<'_> {
    /// An array of numbers of any length.
    fn list(&mut self, key: &Key, node: &Node<'_>) -> Option<Vec<f64>> {
        let Some(items) = node.get_ref().as_array() else {
            self.wrong_type(key.name, node, key.value);
            return None;
        };
        let mut numbers = Vec::with_capacity(items.len());
        let mut sound = true;
        for (i, item) in items.iter().enumerate() {
            let number = match item.get_ref() {
                DeValue::Integer(_) | DeValue::Float(_) => self.number(key, key.name, item),
                DeValue::String(_)
                | DeValue::Boolean(_)
                | DeValue::Datetime(_)
                | DeValue::Array(_)
                | DeValue::Table(_) => {
                    self.wrong_type(&format!("{}[{i}]", key.name), item, "a number");
                    None
                }
            };
            sound &= number.is_some();
            numbers.extend(number);
        }
        sound.then_some(numbers)
    }

    /// What is there, if it is legal; else an error at the item of the array that is wrong.
    fn legal<'n, 'i: 'n, T>(
        &mut self,
        made: Result<T, CurveProblem>,
        place: impl Fn(&CurveProblem) -> &'n Node<'i>,
    ) -> Option<T> {
        let problem = match made {
            Ok(legal) => return Some(legal),
            Err(problem) => problem,
        };
        let node = place(&problem);
        let items = node.get_ref().as_array();
        let item = problem
            .index()
            .zip(items)
            .and_then(|(index, items)| items.get(index));
        let span = item.unwrap_or(node).span().into();
        self.report(span, Problem::Conflict(problem.to_string()));
        None
    }

    /// The curve in `file`; one that cannot be read is reported where it is named first.
    fn curve_file(&mut self, file: &Spanned<String>) -> Option<Arc<Curve>> {
        let path = self.files.path(file);
        if let Some(known) = self.files.curves.get(&path) {
            return known.clone();
        }
        let loaded = match super::super::curve::load(&path) {
            Ok((curve, hash)) => {
                self.files.note(file, &path, hash);
                Some(Arc::new(curve))
            }
            Err(error) => {
                let path = path.clone();
                let error = Box::new(error);
                self.report(file.span, Problem::Curve { path, error });
                None
            }
        };
        self.files.curves.insert(path, loaded.clone());
        loaded
    }
}

/// The table that a text where a color should be stands for, if it does.
fn table_for(text: &str, purpose: Purpose) -> Option<String> {
    let is_color = purpose == Purpose::Color;
    if is_color && let Some(illuminant) = illuminant_called(text) {
        return Some(format!("{{ illuminant = \"{}\" }}", illuminant.name()));
    }
    if is_color && let Some(kelvin) = temperature(text) {
        return Some(format!("{{ blackbody = {kelvin} }}"));
    }
    let extension = Path::new(text).extension()?.to_str()?;
    let is_curve = ["csv", "spd", "txt", "dat", "tsv"].contains(&&*extension.to_lowercase());
    is_curve.then(|| format!("{{ file = \"{}\" }}", shortened(text)))
}

/// `#rrggbb`, in either case.
pub(in crate::scene) fn srgb(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#')?;
    if digits.len() != 6 || !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return None;
    }
    let channels = u32::from_str_radix(digits, 16).ok()?.to_be_bytes();
    Some([channels[1], channels[2], channels[3]])
}
