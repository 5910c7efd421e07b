//! The keys of one entry: present, of the right type, and none left over.

use std::rc::Rc;

use toml::de::{DeInteger, DeTable, DeValue};

use super::super::diagnostic::{Diagnostic, MOST_COLLECTED, Problem, Span, Spanned};
use super::change::Changes;
use super::key::{Form, Key};
use super::moving_entries::Moving;
use super::syntax::{Damage, described};
use super::{Files, Node};

/// Reads a tree and collects what is wrong with it.
pub(super) struct Reader<'a> {
    pub(super) text: &'a str,
    pub(super) damage: Damage,
    pub(super) diagnostics: Vec<Diagnostic>,
    pub(super) files: Files,
    pub(super) changes: Rc<Changes<'a>>,
    /// At which all that moves is read.
    pub(super) frame: f64,
    /// Whether it is the value of a key that is read.
    pub(super) is_within_keys: bool,
    /// The frames of the keys that were met, in no order.
    pub(super) key_frames: Vec<f64>,
    /// The entries that move.
    pub(super) moving: Moving,
}

impl Reader<'_> {
    /// Reports `problem`, unless a syntax error at the same place explains it.
    pub(super) fn report(&mut self, span: Span, problem: Problem) {
        let explained = if span == Span::default() {
            self.damage.lost_entries()
        } else {
            self.damage.reaches(span.start)
        };
        if !explained && self.diagnostics.len() < MOST_COLLECTED {
            self.diagnostics.push(Diagnostic::new(span, problem));
        }
    }

    /// Reports each of several problems.
    pub(super) fn report_all(&mut self, problems: impl IntoIterator<Item = (Span, Problem)>) {
        for (span, problem) in problems {
            self.report(span, problem);
        }
    }

    /// Reports that `key` holds something else than it should.
    pub(super) fn wrong_type(&mut self, key: &str, node: &Node<'_>, expected: &'static str) {
        let problem = Problem::WrongType {
            key: key.to_owned(),
            found: described(node.get_ref()),
            expected,
        };
        self.report(node.span().into(), problem);
    }

    /// An integer or float as f64; infinite and NaN where the file says `inf` and `nan`.
    ///
    /// `name` is the key's, or an element of it such as `center[1]`.
    pub(super) fn number(&mut self, key: &Key, name: &str, node: &Node<'_>) -> Option<f64> {
        let (number, written) = match node.get_ref() {
            DeValue::Integer(integer) => (integer_as_f64(integer), integer.to_string()),
            DeValue::Float(float) => {
                let written = float.as_str();
                let number = written.parse::<f64>().ok();
                let overflow =
                    |&n: &f64| n.is_finite() || !written.ends_with(|c: char| c.is_ascii_digit());
                (number.filter(overflow), written.to_owned())
            }
            DeValue::String(_)
            | DeValue::Boolean(_)
            | DeValue::Datetime(_)
            | DeValue::Array(_)
            | DeValue::Table(_) => {
                self.wrong_type(name, node, key.value);
                return None;
            }
        };
        if number.is_none() {
            let problem = Problem::OutOfRange {
                key: key.name,
                value: written,
                expected: "a number of at most 1.8e308, the largest in 64-bit floating point"
                    .to_owned(),
            };
            self.report(node.span().into(), problem);
        }
        number
    }

    /// An array of exactly `N` items.
    pub(super) fn items<'n, 'i, const N: usize>(
        &mut self,
        key: &Key,
        name: &str,
        node: &'n Node<'i>,
    ) -> Option<&'n [Node<'i>; N]> {
        let items = node
            .get_ref()
            .as_array()
            .and_then(|items| <&[Node<'i>; N]>::try_from(&**items).ok());
        if items.is_none() {
            self.wrong_type(name, node, key.value);
        }
        items
    }

    /// An array of `N` numbers.
    pub(super) fn numbers<const N: usize>(
        &mut self,
        key: &Key,
        name: &str,
        node: &Node<'_>,
    ) -> Option<[f64; N]> {
        let items = self.items::<N>(key, name, node)?;
        let mut numbers = [0.0; N];
        let mut sound = true;
        for (i, (number, item)) in numbers.iter_mut().zip(items).enumerate() {
            let is_number = matches!(item.get_ref(), DeValue::Integer(_) | DeValue::Float(_));
            let read = if is_number {
                self.number(key, name, item)
            } else {
                self.wrong_type(&format!("{name}[{i}]"), item, "a number");
                None
            };
            sound &= read.is_some();
            *number = read.unwrap_or_default();
        }
        sound.then_some(numbers)
    }
}

/// The keys of one table, of which [`Fields::finish`] reports those that its form does not have.
pub(super) struct Fields<'r, 'a, 'i> {
    pub(super) reader: &'r mut Reader<'a>,
    table: &'r DeTable<'i>,
    form: Form<'r>,
    /// Where errors and defaults point that have no key of their own.
    pub(super) header: Span,
    missing: Vec<&'static Key>,
}

impl<'r, 'a, 'i> Fields<'r, 'a, 'i> {
    pub(super) const fn new(
        reader: &'r mut Reader<'a>,
        form: Form<'r>,
        table: &'r DeTable<'i>,
        header: Span,
    ) -> Self {
        Self {
            reader,
            table,
            form,
            header,
            missing: Vec::new(),
        }
    }

    /// The value of `key`, if it is there.
    pub(super) fn get(&mut self, key: &Key) -> Option<&'r Node<'i>> {
        // What the form does not have would be reported as unknown, and would not be in the schema.
        assert!(self.form.has(key.name), "`{}` is in no table", key.name);
        self.table.get(key.name)
    }

    /// The value of `key`; that it is not there is an error.
    pub(super) fn require(&mut self, key: &'static Key) -> Option<&'r Node<'i>> {
        let node = self.get(key);
        if node.is_none() {
            self.missing.push(key);
        }
        node
    }

    pub(super) fn number(&mut self, key: &'static Key) -> Option<Spanned<f64>> {
        let node = self.require(key)?;
        spanned(self.reader.moving_number(key, node), node)
    }

    /// `Some(None)` where the key is not there, `None` where its value is in error.
    pub(super) fn optional_number(&mut self, key: &Key) -> Option<Option<Spanned<f64>>> {
        match self.get(key) {
            Some(node) => spanned(self.reader.moving_number(key, node), node).map(Some),
            None => Some(None),
        }
    }

    /// The number of `key`, or `default` where it is not there.
    pub(super) fn number_or(&mut self, key: &Key, default: f64) -> Option<Spanned<f64>> {
        let written = self.optional_number(key)?;
        Some(written.unwrap_or(Spanned::new(default, self.header)))
    }

    pub(super) fn vector(&mut self, key: &'static Key) -> Option<Spanned<[f64; 3]>> {
        let node = self.require(key)?;
        spanned(self.reader.moving_numbers(key, node), node)
    }

    pub(super) fn vector_or(&mut self, key: &Key, default: [f64; 3]) -> Option<Spanned<[f64; 3]>> {
        match self.get(key) {
            Some(node) => spanned(self.reader.moving_numbers(key, node), node),
            None => Some(Spanned::new(default, self.header)),
        }
    }

    pub(super) fn string(&mut self, key: &'static Key) -> Option<Spanned<String>> {
        let node = self.require(key)?;
        self.string_of(key, node)
    }

    pub(super) fn optional_string(&mut self, key: &Key) -> Option<Option<Spanned<String>>> {
        match self.get(key) {
            Some(node) => self.string_of(key, node).map(Some),
            None => Some(None),
        }
    }

    fn string_of(&mut self, key: &Key, node: &Node<'_>) -> Option<Spanned<String>> {
        let text = node.get_ref().as_str();
        if text.is_none() {
            self.reader.wrong_type(key.name, node, key.value);
        }
        spanned(text.map(str::to_owned), node)
    }

    pub(super) fn boolean_or(&mut self, key: &Key, default: bool) -> Option<bool> {
        let Some(node) = self.get(key) else {
            return Some(default);
        };
        let value = node.get_ref().as_bool();
        if value.is_none() {
            self.reader.wrong_type(key.name, node, key.value);
        }
        value
    }

    /// Reports the keys that the form does not have and the ones that are missing; `None` if there
    /// are any. A missing key that is there under another name is one error, not two.
    pub(super) fn finish(self) -> Option<()> {
        let mut sound = self.missing.is_empty();
        let mut missing = self.missing;
        for key in self.table.keys() {
            let name = key.get_ref();
            if !self.form.has(name) {
                let problem = self.form.unknown(name);
                if let Some(meant) = problem.nearest() {
                    missing.retain(|missing| missing.name != meant);
                }
                self.reader.report(key.span().into(), problem);
                sound = false;
            }
        }
        for key in missing {
            let problem = Problem::Missing {
                what: "key",
                name: key.name.to_owned(),
                expected: key.line,
            };
            self.reader.report(self.header, problem);
        }
        sound.then_some(())
    }
}

pub(super) fn spanned<T>(value: Option<T>, node: &Node<'_>) -> Option<Spanned<T>> {
    value.map(|value| Spanned::new(value, node.span().into()))
}

/// A TOML integer of any size, rounded to the nearest f64 where it has more than 53 bits.
fn integer_as_f64(integer: &DeInteger<'_>) -> Option<f64> {
    if integer.radix() == 10 {
        return integer
            .as_str()
            .parse()
            .ok()
            .filter(|number: &f64| number.is_finite());
    }
    u128::from_str_radix(integer.as_str(), integer.radix())
        .ok()
        .map(|integer| integer as f64)
}
