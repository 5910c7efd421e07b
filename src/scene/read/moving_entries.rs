//! The entries of a scene that move, kept as text to be read again at other frames.
//!
//! The text has each of them on one line. Places in it are turned into those in the scene's own text, so that errors
//! and values point where they were written.

use std::collections::HashMap;

use toml::de::DeValue;

use super::super::diagnostic::Span;
use super::{Files, Node};

/// What is different from one frame to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moved {
    /// The camera.
    pub camera: bool,
    /// Lights, materials, objects or the background.
    pub world: bool,
}

/// What moves.
#[derive(Clone, Debug)]
pub(super) struct Moving {
    /// The frames that have keys, each once, ascending.
    pub(super) key_frames: Vec<f64>,
    pub(super) moved: Moved,
    /// "the camera", "light `key`"
    pub(super) names: Vec<String>,
    pub(super) text: String,
    /// Where in the scene's text the ends of keys and values are, by where they are in this one.
    pub(super) places: HashMap<usize, usize>,
    pub(super) files: Files,
}

impl Moving {
    /// Nothing yet.
    pub(super) fn nothing() -> Self {
        Self {
            key_frames: Vec::new(),
            moved: Moved::default(),
            names: Vec::new(),
            text: String::new(),
            places: HashMap::new(),
            files: Files::default(),
        }
    }

    /// With the files that what moves may name, once all of them are read.
    pub(super) fn with(self, mut key_frames: Vec<f64>, files: Files) -> Self {
        key_frames.sort_by(f64::total_cmp);
        key_frames.dedup();
        Self {
            files: if key_frames.is_empty() {
                Files::default()
            } else {
                files
            },
            key_frames,
            ..self
        }
    }

    /// Adds a section without entries, or an entry of a section, with what it holds.
    pub(super) fn add(
        &mut self,
        section: &str,
        name: Option<(&str, Span)>,
        node: &Node<'_>,
        source: &str,
    ) {
        if section == "camera" {
            self.moved.camera = true;
        } else {
            self.moved.world = true;
        }
        self.names.push(match name {
            Some((name, _)) => format!("{} `{name}`", section.trim_end_matches('s')),
            None if section == "image" => "the background".to_owned(),
            None => format!("the {section}"),
        });
        self.text.push_str(section);
        if let Some((name, span)) = name {
            self.text.push('.');
            self.key(name, span);
        }
        self.text.push('=');
        self.node(node, source);
        self.text.push('\n');
    }

    fn key(&mut self, name: &str, span: Span) {
        self.places.insert(self.text.len(), span.start);
        self.text.push('"');
        for character in name.chars() {
            match character {
                '"' | '\\' => self.text.extend(['\\', character]),
                character if character.is_control() => {
                    let code = u32::from(character);
                    self.text.push_str(&format!("\\U{code:08x}"));
                }
                character => self.text.push(character),
            }
        }
        self.text.push('"');
        self.places.insert(self.text.len(), span.end);
    }

    fn node(&mut self, node: &Node<'_>, source: &str) {
        let span = node.span();
        self.places.insert(self.text.len(), span.start);
        match node.get_ref() {
            DeValue::Table(table) => {
                self.text.push('{');
                for (index, (key, value)) in table.iter().enumerate() {
                    if index > 0 {
                        self.text.push(',');
                    }
                    self.key(key.get_ref(), key.span().into());
                    self.text.push('=');
                    self.node(value, source);
                }
                self.text.push('}');
            }
            DeValue::Array(items) => {
                self.text.push('[');
                for (index, item) in items.iter().enumerate() {
                    if index > 0 {
                        self.text.push(',');
                    }
                    self.node(item, source);
                }
                self.text.push(']');
            }
            DeValue::String(_)
            | DeValue::Integer(_)
            | DeValue::Float(_)
            | DeValue::Boolean(_)
            | DeValue::Datetime(_) => self.text.push_str(&source[span.clone()]),
        }
        self.places.insert(self.text.len(), span.end);
    }
}
