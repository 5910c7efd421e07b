//! The entries of a scene that move, kept as text to be read again at other frames.
//!
//! The text has each of them on one line. Places in it are turned into those in the scene's own text, so that errors
//! and values point where they were written.

use std::collections::HashMap;
use std::rc::Rc;

use toml::de::{DeTable, DeValue};

use super::super::diagnostic::{Diagnostic, Span, Spanned};
use super::super::motion::Moved;
use super::super::{Anchor, Camera, Entry, Image, Light, Material, Object};
use super::change::Changes;
use super::entries::Entries;
use super::fields::Reader;
use super::pieces::shift;
use super::syntax::{self, Damage};
use super::{Files, Node, sections};

/// What moves.
#[derive(Clone, Debug)]
pub(in crate::scene) struct Moving {
    /// The first and the last frame that has a key.
    pub(in crate::scene) frames: Option<[f64; 2]>,
    pub(in crate::scene) moved: Moved,
    /// "the camera", "light `key`"
    pub(in crate::scene) names: Vec<String>,
    text: String,
    /// Where in the scene's text the ends of keys and values are, by where they are in this one.
    places: HashMap<usize, usize>,
    files: Files,
}

/// What moves, at a frame.
pub(in crate::scene) struct AtFrame {
    pub(in crate::scene) entries: MovingEntries,
    pub(in crate::scene) diagnostics: Vec<Diagnostic>,
}

/// Of a scene, the entries that move.
pub(in crate::scene) struct MovingEntries {
    pub(in crate::scene) image: Option<Image>,
    pub(in crate::scene) camera: Option<Spanned<Camera>>,
    pub(in crate::scene) materials: Vec<Entry<Material>>,
    pub(in crate::scene) lights: Vec<Entry<Light>>,
    pub(in crate::scene) objects: Vec<Entry<Object>>,
}

impl Moving {
    /// Nothing yet.
    pub(super) fn nothing() -> Self {
        Self {
            frames: None,
            moved: Moved::default(),
            names: Vec::new(),
            text: String::new(),
            places: HashMap::new(),
            files: Files::default(),
        }
    }

    /// With the files that what moves may name, once all of them are read.
    pub(super) fn with(self, frames: Option<[f64; 2]>, files: Files) -> Self {
        Self {
            frames,
            files: if frames.is_some() {
                files
            } else {
                Files::default()
            },
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

    /// All that moves at a frame; `source` is the scene's text.
    pub(in crate::scene) fn at(&self, frame: f64, source: &str) -> AtFrame {
        let (mut root, _, diagnostics) = syntax::parse(&self.text, 0);
        shift(&mut root, &|place| {
            self.places.get(&place).copied().unwrap_or(0)
        });
        let mut reader = Reader {
            text: source,
            damage: Damage::none(),
            diagnostics,
            files: self.files.clone(),
            changes: Rc::new(Changes::default()),
            frame,
            is_within_keys: false,
            moved: None,
            moving: Self::nothing(),
        };
        let entries = reader.moving_entries(&root);
        AtFrame {
            entries,
            diagnostics: reader.diagnostics,
        }
    }
}

impl Moving {
    /// Where a camera that moves is at first.
    pub(super) fn anchor(&self, source: &str) -> Option<Anchor> {
        if !self.moved.camera {
            return None;
        }
        let camera = self.at(f64::NEG_INFINITY, source).entries.camera?;
        let view = camera.value.view();
        Some(Anchor {
            eye: view.eye.value,
            look_at: view.look_at.value,
        })
    }
}

impl Reader<'_> {
    /// Reads something, and whether that moves.
    pub(super) fn watched<T>(&mut self, read: impl FnOnce(&mut Self) -> T) -> (T, bool) {
        let before = self.moved.take();
        let value = read(self);
        let moved = self.moved;
        self.moved = match (before, moved) {
            (Some([first, last]), Some([a, b])) => Some([first.min(a), last.max(b)]),
            (before, moved) => before.or(moved),
        };
        (value, moved.is_some())
    }

    /// Keeps what moves and is not in error, to be read again at other frames.
    pub(super) fn note_motion<T>(
        &mut self,
        (value, moves): (Option<T>, bool),
        section: &str,
        name: Option<(&str, Span)>,
        node: Option<&Node<'_>>,
    ) -> Option<T> {
        if let Some(node) = node.filter(|_| moves && value.is_some()) {
            self.moving.add(section, name, node, self.text);
        }
        value
    }

    fn moving_entries(&mut self, root: &DeTable<'_>) -> MovingEntries {
        let mut image = None;
        if root.contains_key("image") {
            image = sections::image(self, root, &[]);
        }
        let mut camera = None;
        if root.contains_key("camera") {
            camera = sections::camera(self, root, &[]);
        }
        let (mut materials, mut lights, mut objects) =
            (Entries::default(), Entries::default(), Entries::default());
        let read = sections::MATERIALS
            .read(self, root, &mut materials)
            .and_then(|()| sections::LIGHTS.read(self, root, &mut lights))
            .and_then(|()| sections::OBJECTS.read(self, root, &mut objects));
        if let Err(error) = read {
            self.diagnostics.push(super::out_of_memory(error));
        }
        MovingEntries {
            image,
            camera,
            materials: materials.sound,
            lights: lights.sound,
            objects: objects.sound,
        }
    }
}
