//! Keys in a scene file: `{ keys = [[1, [0, 1, 4]], [24, [2, 1, 4]]], interpolation = "smooth" }`.

use toml::de::DeValue;

use super::super::diagnostic::{Problem, Span};
use super::super::keys::{Blend, Blendable, Interpolation};
use super::Node;
use super::fields::{Fields, Reader};
use super::key::{Form, Key, Kind, key};

/// The frames of keys lie within plus and minus this.
pub(in crate::scene) const LAST_FRAME: f64 = 1e9;

/// The keys of what moves.
pub(in crate::scene) const MOVING: Form<'_> = Form::new(&[&KEYS, &INTERPOLATION]);

const KEYS: Key = key!(
    "keys",
    "pairs of a frame and a value, frames ascending",
    "[[1, 0], [24, 2]]"
)
.of(Kind::Keys)
.about("Pairs of a frame and the value there; frames ascend and may have fractions.")
.also(&["key", "keyframes", "frames", "times"]);
const INTERPOLATION: Key = key!(
    "interpolation",
    "`\"linear\"`, `\"smooth\"` or `\"step\"`",
    "\"smooth\""
)
.of(Kind::Name(interpolations))
.or("\"linear\"")
.about(
    "From one key to the next: in a straight line; as a cubic Hermite spline with slopes of Catmull and Rom, 0 at the \
     ends; or staying until the next key.",
)
.also(&["ease", "easing", "mode"]);

fn interpolations() -> Vec<&'static str> {
    Interpolation::ALL.map(Interpolation::name).to_vec()
}

impl Reader<'_> {
    /// A number, which may move.
    pub(super) fn moving_number(&mut self, key: &Key, node: &Node<'_>) -> Option<f64> {
        self.moving(node, |reader, node| reader.number(key, key.name, node))
    }

    /// Three numbers, which may move.
    pub(super) fn moving_numbers(&mut self, key: &Key, node: &Node<'_>) -> Option<[f64; 3]> {
        self.moving(node, |reader, node| reader.numbers(key, key.name, node))
    }

    /// What is at a node at the reader's frame, be it a value or keys.
    pub(super) fn moving<'i, T: Blendable>(
        &mut self,
        node: &Node<'i>,
        read: impl Fn(&mut Self, &Node<'i>) -> Option<T>,
    ) -> Option<T> {
        let table = match node.get_ref() {
            DeValue::Table(table) if has_keys(table.keys().map(toml::Spanned::get_ref)) => table,
            _ => return read(self, node),
        };
        if self.are_keys_within_keys(node) {
            return None;
        }
        let span = node.span().into();
        self.is_within_keys = true;
        let mut fields = Fields::new(self, MOVING, table, span);
        let pairs = fields.require(&KEYS);
        let keys = pairs.and_then(|node| fields.reader.keys(node, read));
        let interpolation = fields.choice(
            &INTERPOLATION,
            "interpolation",
            &Interpolation::ALL,
            Interpolation::name,
        );
        let finished = fields.finish();
        self.is_within_keys = false;
        finished?;
        let (frames, values) = keys?;
        self.key_frames.extend_from_slice(&frames);
        let blend = Blend::at(self.frame, &frames, interpolation?.value);
        Some(T::blended(&values, &blend))
    }

    /// Reports keys in the value of a key.
    pub(super) fn are_keys_within_keys(&mut self, node: &Node<'_>) -> bool {
        let names = node.get_ref().as_table().into_iter().flatten();
        if !self.is_within_keys || !has_keys(names.map(|(key, _)| key.get_ref())) {
            return false;
        }
        let message = "keys within keys; write one list of keys";
        self.report(node.span().into(), Problem::Conflict(message.to_owned()));
        true
    }

    /// The frames and the values of keys, of which there is at least one.
    fn keys<'i, T>(
        &mut self,
        node: &Node<'i>,
        read: impl Fn(&mut Self, &Node<'i>) -> Option<T>,
    ) -> Option<(Vec<f64>, Vec<T>)> {
        let items = node.get_ref().as_array();
        let Some(items) = items.filter(|items| !items.is_empty()) else {
            self.wrong_type(KEYS.name, node, KEYS.value);
            return None;
        };
        let mut frames = Vec::with_capacity(items.len());
        let mut values = Vec::with_capacity(items.len());
        let mut is_sound = true;
        for (index, item) in items.iter().enumerate() {
            let name = format!("{}[{index}]", KEYS.name);
            let pair = item.get_ref().as_array().map(|pair| &**pair);
            let Some([frame, value]) = pair else {
                self.wrong_type(&name, item, "a frame and a value, such as `[24, 0.5]`");
                is_sound = false;
                continue;
            };
            let frame = self.key_frame(&name, frame, frames.last().copied());
            let value = read(self, value);
            is_sound &= frame.is_some() && value.is_some();
            frames.extend(frame);
            values.extend(value);
        }
        is_sound.then_some((frames, values))
    }

    /// The frame of a key, which comes after another.
    fn key_frame(&mut self, name: &str, node: &Node<'_>, last: Option<f64>) -> Option<f64> {
        if !matches!(node.get_ref(), DeValue::Integer(_) | DeValue::Float(_)) {
            self.wrong_type(
                name,
                node,
                "the number of a frame first, such as `[24, 0.5]`",
            );
            return None;
        }
        let frame = self.number(&KEYS, name, node)?;
        let problem = if !(-LAST_FRAME..=LAST_FRAME).contains(&frame) {
            format!("the frame {frame:e} of `{name}` is not from -1e9 to 1e9")
        } else if let Some(last) = last.filter(|&last| last >= frame) {
            format!(
                "the frame {frame} of `{name}` does not come after {last}; keys stand in the order of their frames"
            )
        } else {
            return Some(frame);
        };
        self.report(node.span().into(), Problem::Conflict(problem));
        None
    }
}

impl Reader<'_> {
    /// Reads something, and whether that moves.
    pub(super) fn watched<T>(&mut self, read: impl FnOnce(&mut Self) -> T) -> (T, bool) {
        let before = self.key_frames.len();
        let value = read(self);
        (value, self.key_frames.len() > before)
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
}

/// Whether a table is one of keys, be it misspelt: no value has such words.
fn has_keys<'k>(mut names: impl Iterator<Item = &'k std::borrow::Cow<'k, str>>) -> bool {
    names.any(|name| {
        let is = |key: &Key| name == key.name || key.also.contains(&name.as_ref());
        is(&KEYS) || name == INTERPOLATION.name
    })
}
