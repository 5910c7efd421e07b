//! `[section.name.variant]`: the names, and one variant each.

use std::borrow::Cow;
use std::rc::Rc;

use toml::de::{DeTable, DeValue};

use super::super::Entry;
use super::super::diagnostic::{Problem, Span};
use super::Node;
use super::fields::{Fields, Reader};
use super::key::{Elsewhere, Form, unknown};
use super::syntax::header;
use crate::memory::{self, OutOfMemory};
use crate::printable::shortened;

/// A kind of entry: its keys, and what reads them.
pub(super) struct Variant<T> {
    /// `sphere`
    pub(super) name: &'static str,
    /// A sentence or two for whoever edits a scene.
    pub(super) about: &'static str,
    /// What it is called elsewhere.
    pub(super) also: &'static [&'static str],
    pub(super) form: Form<'static>,
    pub(super) read: fn(&mut Fields<'_, '_, '_>) -> Option<T>,
}

/// The kinds of entry that a section can hold.
pub(super) struct Variants<T: 'static> {
    pub(super) list: &'static [Variant<T>],
    /// Kinds that there are elsewhere, but not here.
    pub(super) elsewhere: &'static [Elsewhere],
}

/// A section of named entries.
pub(super) struct Section<T: 'static> {
    /// `materials`
    pub(super) key: &'static str,
    /// "material"
    pub(super) entry: &'static str,
    /// "a material"
    pub(super) an_entry: &'static str,
    /// Whether names become those of EXR channels.
    pub(super) names_channels: bool,
    /// "kind of material"
    pub(super) kind: &'static str,
    /// "`[materials.NAME.phong]` with a name of your choice"
    pub(super) example: &'static str,
    pub(super) variants: Variants<T>,
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
    /// All names, of entries in error too.
    pub(super) fn names(&self) -> Vec<&str> {
        let sound = self.sound.iter().map(|entry| entry.name.as_str());
        sound
            .chain(self.broken.iter().map(String::as_str))
            .collect()
    }

    /// In the order of the file.
    pub(super) fn in_order(mut self) -> Vec<Entry<T>> {
        self.sound.sort_by_key(|entry| entry.span);
        self.sound
    }
}

/// The longest name in bytes: with `light_` and a channel it fits the 255 bytes of an EXR channel
/// name.
pub(super) const LONGEST_NAME: usize = 200;

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
            let changes = Rc::clone(&reader.changes);
            let changed = changes.apply(&[self.key, name], node);
            let changed = changed.map(|(changed, wrong)| {
                reader.report_all(wrong);
                changed
            });
            let node = changed.as_ref().unwrap_or(node);
            let read = reader.watched(|reader| self.entry(reader, name, span, node));
            match reader.note_motion(read, self.key, Some((name, span)), Some(node)) {
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
                    // Of `[materials.Material.001.phong]` the name is `Material.001`.
                    let parts = node.get_ref().as_table().into_iter().flatten();
                    for (part, _) in parts.filter(|(_, node)| node.get_ref().is_table()) {
                        memory::reserve(&mut entries.broken, 1)?;
                        let whole = format!("{name}.{}", part.get_ref());
                        entries.broken.push(whole);
                    }
                }
            }
        }
        Ok(())
    }

    fn entry(&self, reader: &mut Reader<'_>, name: &str, span: Span, node: &Node<'_>) -> Option<T> {
        let why = objection(name, self.names_channels);
        let is_sound = why.is_none();
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
        let is_kind = |text: &str| self.variants.find(text).is_some();
        let path = if is_kind(name) && !table.iter().any(|(_, node)| node.get_ref().is_table()) {
            // `[objects.sphere]`: it is the name that was forgotten.
            format!("{}.NAME", self.key)
        } else {
            format!("{}.{}", self.key, as_key(name))
        };
        let header = header(reader.text, span, node);
        let value = one_variant(
            reader,
            &Choice {
                what: self.entry,
                name,
                kind: self.kind,
                path: &path,
                names_channels: self.names_channels,
                header,
            },
            table,
            &self.variants,
        );
        value.filter(|_| is_sound)
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
    /// Whether its name becomes that of channels, which has no dot.
    pub(super) names_channels: bool,
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
    let is_known = |name: &str| variants.find(name).is_some();
    let any_kind = members
        .iter()
        .any(|(key, node)| is_known(key.get_ref()) || node.get_ref().is_table());
    if !any_kind {
        let problem = Problem::NoVariant {
            what: choice.what,
            name: choice.name.to_owned(),
            expected: variants
                .list
                .iter()
                .map(|variant| format!("[{}.{}]", choice.path, variant.name))
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
        let Some(variant) = variants.find(name) else {
            let inner = node.get_ref().as_table();
            let kind = inner.and_then(|table| table.keys().find(|key| is_known(key.get_ref())));
            if let (Some(kind), Some((section, _))) = (kind, choice.path.split_once('.')) {
                // `[objects.Plane.001.plane]`: the name has a dot.
                let (why, whole) = if choice.names_channels {
                    let why = "the name of a light has no dot, which parts layer and channel in the EXR; \
                               write";
                    (why, format!("{}_{name}", choice.name).replace('.', "_"))
                } else {
                    let why = "a name with a dot stands in quotes:";
                    (why, format!("{}.{name}", choice.name))
                };
                let (key, kind) = (as_key(&whole), kind.get_ref());
                let problem = Problem::Conflict(format!("{why} `[{section}.{key}.{kind}]`"));
                reader.report(header, problem);
                sound = false;
                continue;
            }
            reader.report(key.span().into(), variants.unknown(choice.kind, name));
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
        let mut fields = Fields::new(reader, variant.form, fields, header);
        value = (variant.read)(&mut fields);
        sound &= fields.finish().is_some();
    }
    value.filter(|_| sound)
}

impl<T> Variants<T> {
    fn find(&self, name: &str) -> Option<&Variant<T>> {
        self.list.iter().find(|variant| variant.name == name)
    }

    /// What to say of a kind that is not here.
    fn unknown(&self, what: &'static str, name: &str) -> Problem {
        let word = name.to_lowercase().replace('-', "_");
        let is_called = |variant: &&Variant<T>| variant.also.contains(&&*word);
        if let Some(variant) = self.list.iter().find(is_called) {
            return Problem::OtherWord {
                what,
                name: name.to_owned(),
                meant: variant.name,
            };
        }
        let names = self.list.iter().map(|variant| variant.name);
        unknown(what, name, names, self.elsewhere)
    }
}

/// Why `name` cannot be used, if so. Names come back in messages, mattes and on command lines; those
/// of lights, in EXR channels too, where a dot separates layer and channel.
pub(crate) fn objection(name: &str, names_channels: bool) -> Option<Cow<'static, str>> {
    let is_allowed = |(place, character): (usize, char)| {
        let is_own = character.is_alphanumeric() || matches!(character, '_' | '-' | ' ' | '.');
        is_own || place > 0 && is_mark(character)
    };
    Some(Cow::Borrowed(if name.is_empty() {
        "names have at least one letter or digit"
    } else if name.len() > LONGEST_NAME {
        "names are at most 200 bytes long"
    } else if !name.char_indices().all(is_allowed) {
        if names_channels {
            "names are made of letters, digits, `_`, `-` and spaces"
        } else {
            "names are made of letters, digits, `_`, `-`, `.` and spaces"
        }
    } else if name.starts_with(' ') || name.ends_with(' ') {
        "names do not start or end with a space"
    } else if names_channels && name.contains('.') {
        let other = shortened(&name.replace('.', "_"));
        let why = format!("a dot parts layer and channel in the EXR; write `{other}`");
        return Some(Cow::Owned(why));
    } else {
        return None;
    }))
}

/// Whether a character is a part of the letter before it: an accent, or the vowel and tone signs of
/// scripts such as Thai and Devanagari. The standard library escapes these at the start of a text alone.
fn is_mark(character: char) -> bool {
    let is_printed = |text: &str| text.escape_debug().eq(text.chars());
    let mut bytes = [b'a'; 5];
    let length = character.encode_utf8(&mut bytes[1..]).len();
    let behind_a_letter = std::str::from_utf8(&bytes[..=length]);
    let is_printed_behind = behind_a_letter.is_ok_and(is_printed);
    is_printed_behind && !character.escape_debug().eq([character])
}

/// A name as TOML writes it in a header: in quotes where it has more than ASCII letters, digits, `_`
/// and `-`.
fn as_key(name: &str) -> String {
    let is_bare = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-');
    if !name.is_empty() && name.bytes().all(is_bare) {
        name.to_owned()
    } else {
        format!("\"{}\"", shortened(name))
    }
}
