//! The format as one who does not read a file sees it: sections, their kinds of entry, and keys.

use super::entries::{LONGEST_NAME, Section, Variant, Variants, objection};
use super::key::Form;
use super::sections::{CAMERAS, IMAGE, LIGHTS, MATERIALS, OBJECTS};

/// A kind of entry.
pub(in crate::scene) struct Kind {
    /// `sphere`
    pub(in crate::scene) name: &'static str,
    pub(in crate::scene) about: &'static str,
    pub(in crate::scene) form: Form<'static>,
}

/// A section of entries with names.
pub(in crate::scene) struct Named {
    /// `objects`
    pub(in crate::scene) key: &'static str,
    /// "an object"
    pub(in crate::scene) an_entry: &'static str,
    pub(in crate::scene) kinds: Vec<Kind>,
}

/// The keys of `[image]`.
pub(in crate::scene) const fn image() -> Form<'static> {
    IMAGE
}

/// The kinds of camera, of which a scene has one.
pub(in crate::scene) fn cameras() -> Vec<Kind> {
    kinds(&CAMERAS)
}

/// The sections whose entries have names.
pub(in crate::scene) fn named() -> [Named; 3] {
    [section(&MATERIALS), section(&LIGHTS), section(&OBJECTS)]
}

/// The longest name in bytes.
pub(in crate::scene) const fn longest_name() -> usize {
    LONGEST_NAME
}

/// Whether a character may be amid a name.
pub(in crate::scene) fn may_be_in_a_name(character: char) -> bool {
    objection(&format!("a{character}a")).is_none()
}

fn section<T>(section: &Section<T>) -> Named {
    Named {
        key: section.key,
        an_entry: section.an_entry,
        kinds: kinds(&section.variants),
    }
}

fn kinds<T>(variants: &Variants<T>) -> Vec<Kind> {
    let kind = |variant: &Variant<T>| Kind {
        name: variant.name,
        about: variant.about,
        form: variant.form,
    };
    variants.list.iter().map(kind).collect()
}
