//! `[section.name.variant]`: the names, and one variant each.

use toml::de::{DeTable, DeValue};

use super::super::Entry;
use super::super::diagnostic::{Problem, Span};
use super::Node;
use super::fields::{Fields, Reader};
use crate::memory::{self, OutOfMemory};

/// The kinds of entry that a section can hold: the name of each and what reads it.
pub(super) type Variants<T> = [(&'static str, fn(&mut Fields<'_, '_, '_>) -> Option<T>)];

/// A section of named entries.
pub(super) struct Section<T: 'static> {
    /// `materials`
    pub(super) key: &'static str,
    /// "material"
    pub(super) entry: &'static str,
    /// "a material"
    pub(super) an_entry: &'static str,
    /// "kind of material"
    pub(super) kind: &'static str,
    /// "`[materials.NAME.phong]` with a name of your choice"
    pub(super) example: &'static str,
    pub(super) variants: &'static Variants<T>,
}

/// The entries of a section, and the names of those that were left out for an error.
pub(super) struct Entries<T> {
    pub(super) sound: Vec<Entry<T>>,
    pub(super) broken: Vec<String>,
}

impl<T> Default for Entries<T> {
    fn default() -> Self {
        Self {
            sound: Vec::new(),
            broken: Vec::new(),
        }
    }
}

impl<T> Entries<T> {
    /// In the order of the file.
    pub(super) fn in_order(mut self) -> Vec<Entry<T>> {
        self.sound.sort_by_key(|entry| entry.span);
        self.sound
    }
}

/// The longest name in bytes: with `light_` and a channel it fits the 255 bytes of an EXR channel
/// name.
const LONGEST_NAME: usize = 200;

impl<T> Section<T> {
    /// Adds the entries of a tree, which may be one of several that the file is read in.
    ///
    /// # Errors
    /// If memory ends.
    pub(super) fn read(
        &self,
        reader: &mut Reader<'_>,
        root: &DeTable<'_>,
        entries: &mut Entries<T>,
    ) -> Result<(), OutOfMemory> {
        let Some(node) = root.get(self.key) else {
            return Ok(());
        };
        let DeValue::Table(names) = node.get_ref() else {
            reader.wrong_type(self.key, node, self.example);
            return Ok(());
        };
        for (key, node) in names {
            let name = key.get_ref().as_ref();
            let span = Span::from(key.span());
            match self.entry(reader, name, span, node) {
                Some(value) => {
                    memory::reserve(&mut entries.sound, 1)?;
                    entries.sound.push(Entry {
                        name: name.to_owned(),
                        span,
                        value,
                    });
                }
                None => {
                    memory::reserve(&mut entries.broken, 1)?;
                    entries.broken.push(name.to_owned());
                }
            }
        }
        Ok(())
    }

    fn entry(&self, reader: &mut Reader<'_>, name: &str, span: Span, node: &Node<'_>) -> Option<T> {
        let why = objection(name);
        if let Some(why) = why {
            let problem = Problem::BadName {
                what: self.an_entry,
                name: name.to_owned(),
                why,
            };
            reader.report(span, problem);
        }
        let DeValue::Table(table) = node.get_ref() else {
            reader.wrong_type(name, node, self.example);
            return None;
        };
        let is_kind = |text: &str| self.variants.iter().any(|(kind, _)| *kind == text);
        let path = if is_kind(name) && !table.iter().any(|(_, node)| node.get_ref().is_table()) {
            // `[objects.sphere]`: it is the name that was forgotten.
            format!("{}.NAME", self.key)
        } else {
            format!("{}.{name}", self.key)
        };
        let header = header(reader.text, span, node);
        let value = one_variant(
            reader,
            &Choice {
                what: self.entry,
                name,
                kind: self.kind,
                path: &path,
                header,
            },
            table,
            self.variants,
        );
        value.filter(|_| why.is_none())
    }
}

/// An entry that must be of one kind, as errors name it.
pub(super) struct Choice<'a> {
    /// "object"
    pub(super) what: &'static str,
    /// `ball`
    pub(super) name: &'a str,
    /// "kind of object"
    pub(super) kind: &'static str,
    /// `objects.ball`
    pub(super) path: &'a str,
    pub(super) header: Span,
}

/// Reads the one variant that `table` must hold.
pub(super) fn one_variant<T>(
    reader: &mut Reader<'_>,
    choice: &Choice<'_>,
    table: &DeTable<'_>,
    variants: &Variants<T>,
) -> Option<T> {
    let mut members: Vec<_> = table.iter().collect();
    members.sort_by_key(|(key, _)| key.span().start);
    let is_known = |name: &str| variants.iter().any(|(variant, _)| *variant == name);
    let any_kind = members
        .iter()
        .any(|(key, node)| is_known(key.get_ref()) || node.get_ref().is_table());
    if !any_kind {
        let problem = Problem::NoVariant {
            what: choice.what,
            name: choice.name.to_owned(),
            expected: variants
                .iter()
                .map(|(variant, _)| format!("[{}.{variant}]", choice.path))
                .collect(),
        };
        reader.report(choice.header, problem);
        return None;
    }

    let mut first: Option<Span> = None;
    let mut value = None;
    let mut sound = true;
    for (key, node) in members {
        let name = key.get_ref().as_ref();
        let header = header(reader.text, key.span().into(), node);
        let Some((_, read)) = variants.iter().find(|(variant, _)| *variant == name) else {
            let names = variants.iter().map(|(variant, _)| *variant);
            reader.report(
                key.span().into(),
                Problem::unknown(choice.kind, name, names),
            );
            sound = false;
            continue;
        };
        if let Some(first) = first {
            let problem = Problem::Duplicate {
                what: choice.what,
                name: choice.name.to_owned(),
                first: Some(first),
            };
            reader.report(header, problem);
            sound = false;
            continue;
        }
        first = Some(header);
        let DeValue::Table(fields) = node.get_ref() else {
            reader.wrong_type(name, node, "a table of its keys");
            sound = false;
            continue;
        };
        // An entry that a syntax error has touched may have lost keys or hold half a number.
        sound &= !reader.damage.reaches(header.start);
        let mut fields = Fields::new(reader, fields, header);
        value = read(&mut fields);
        sound &= fields.finish().is_some();
    }
    value.filter(|_| sound)
}

/// The place of an entry: its `[header]`, or its key where it has none.
pub(super) fn header(text: &str, key: Span, node: &Node<'_>) -> Span {
    let span = Span::from(node.span());
    let has_header = node.get_ref().is_table() && text[span.start..].starts_with('[');
    if has_header { span } else { key }
}

/// Why `name` cannot be used, if so. Names come back in EXR channels, where a dot separates layer
/// and channel, and on command lines.
pub(crate) fn objection(name: &str) -> Option<&'static str> {
    let is_allowed =
        |character: char| character.is_alphanumeric() || matches!(character, '_' | '-' | ' ');
    if name.is_empty() {
        Some("names have at least one letter or digit")
    } else if name.len() > LONGEST_NAME {
        Some("names are at most 200 bytes long")
    } else if !name.chars().all(is_allowed) {
        Some("names are made of letters, digits, `_`, `-` and spaces")
    } else if name.starts_with(' ') || name.ends_with(' ') {
        Some("names do not start or end with a space")
    } else {
        None
    }
}
