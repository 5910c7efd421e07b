//! From the text of a scene file to a [`Scene`].
//!
//! The text becomes a tree with spans ([TOML](https://toml.io)); the tree is walked by hand, so
//! that everything wrong is found in one go, each with its place. What follows from another error
//! is not reported: an entry in error is left out, but its name stays known.

mod change;
mod document;
mod entries;
mod fields;
mod files;
mod foreign;
mod habits;
mod illuminant;
pub(super) mod key;
mod motion;
pub(super) mod moving;
mod moving_entries;
pub(super) mod notation;
pub(super) mod outline;
mod pieces;
mod place;
mod sections;
mod syntax;
#[cfg(test)]
mod tests;
mod value;

use std::collections::HashSet;
use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use toml::de::{DeString, DeTable, DeValue};

use super::diagnostic::{Diagnostic, Diagnostics, MOST_COLLECTED, Problem, Span, Spanned};
use super::inputs::Input;
use super::{Scene, Source};
use crate::ies::IesFile;
use crate::memory::{self, OutOfMemory};
use crate::mesh::MeshFile;

use change::{Changes, sets_nothing};
use document::{Document, INCLUDE};
use entries::Entries;
pub(crate) use entries::objection as name_objection;
use fields::Reader;
use files::Files;
pub use motion::{Change, FIRST_FRAME, Motion, Moved};
use moving_entries::Moving;
pub(super) use value::srgb;

use pieces::Tree;
use syntax::Damage;

/// A value in the tree, with its place.
type Node<'i> = toml::Spanned<DeValue<'i>>;

/// The largest scene file in bytes. A million objects fit; triangles belong in mesh files.
const LARGEST_FILE: u64 = 256_000_000;

/// The size in bytes above which a file is read [in pieces](pieces), so that all tables of an entry
/// must stand together.
const WHOLE: usize = 1 << 20;

/// How many times its size a file of many entries usually takes while it is read, and what is made
/// of it after that: 7 for spheres, and 2 more.
const USUAL_MEMORY: u64 = 10;

/// A scene file as far as it could be read, with everything that is wrong with its form.
///
/// What is in [`Reading::scene`] is sound by itself, so that ranges can be checked in the same
/// run; names of entries that were left out for an error are known still.
#[derive(Debug)]
pub struct Reading {
    /// The file.
    pub source: Arc<Source>,
    /// The scene without the entries in error. `None` where the image or the camera is in error.
    pub scene: Option<Scene>,
    /// What is wrong, in no particular order.
    pub diagnostics: Vec<Diagnostic>,
    /// Names that stand in the file, but not in `scene`.
    pub broken: Broken,
    /// What moves in the scene. `None` where the scene is.
    pub motion: Option<Motion>,
    /// The frame of `scene`.
    pub frame: f64,
}

/// The names of entries that were left out of a scene because of errors in them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Broken {
    /// Of `[materials]`.
    pub materials: HashSet<String>,
    /// Of `[lights]`.
    pub lights: HashSet<String>,
    /// Of `[objects]`.
    pub objects: HashSet<String>,
    /// Whether a syntax error or a misspelt section hides a part of the file, and with it entries
    /// of any name.
    pub lost_entries: bool,
}

impl Reading {
    /// Reads a scene file and the files that it names, which are relative to its folder.
    pub fn of_file(path: &Path) -> Self {
        Self::of_file_in(path, folder_of(path), &[])
    }

    /// Reads a scene file and the files that it names, which are relative to `folder`. Each text of `set`, such as
    /// `lights.key.point.intensity=20`, stands in the place of what the files say.
    pub fn of_file_in(path: &Path, folder: &Path, set: &[String]) -> Self {
        Self::of_read(read_bytes(path), path, folder, set)
    }

    /// Reads a scene from a stream, such as standard input, to its end. Errors call it `name`, and
    /// files that it names are relative to `folder`.
    pub fn of_stream(stream: impl io::Read, name: &Path, folder: &Path, set: &[String]) -> Self {
        Self::of_read(read_stream(stream), name, folder, set)
    }

    /// Reads a scene from text; mesh files are relative to the folder of `path`.
    pub fn of_text(text: String, path: &Path) -> Self {
        Self::of_text_in(text, path, folder_of(path), &[])
    }

    /// The scene that is rendered where no file is named, with each text of `set` in the place of what it says.
    pub fn of_builtin(set: &[String]) -> Self {
        let path = Path::new("<lecture.toml>");
        Self::of_text_in(super::BUILTIN.to_owned(), path, folder_of(path), set)
    }

    fn of_text_in(text: String, path: &Path, folder: &Path, set: &[String]) -> Self {
        if text.len() as u64 > LARGEST_FILE {
            let diagnostic = Diagnostic::new(Span::default(), too_large());
            return Self::failed(path, String::new(), diagnostic);
        }
        let mut document = Document::new(text, path, folder, set);
        // Better to know it now than amid of thousands of small pieces of memory.
        if let Err(error) = memory::look_for(document.source.text.len() as u64 * USUAL_MEMORY) {
            let problem = Problem::OutOfMemory {
                error: error.for_what("reading the scene file"),
                way_out: "",
            };
            let diagnostic = Diagnostic::new(Span::default(), problem);
            return Self::failed(path, String::new(), diagnostic);
        }
        let (scene, diagnostics, broken) = read(&mut document);
        let source = Arc::new(document.source);
        let (scene, motion) = scene.map(|scene| scene.with(&source)).unzip();
        Self {
            scene,
            source,
            diagnostics,
            broken,
            motion,
            frame: FIRST_FRAME,
        }
    }

    /// The same scene at another frame.
    #[must_use]
    pub fn at(mut self, frame: f64) -> Self {
        if let (Some(scene), Some(motion)) = (&mut self.scene, &self.motion)
            && let Err(diagnostics) = motion.set(scene, frame)
        {
            self.diagnostics.extend(diagnostics.into_list());
        }
        Self { frame, ..self }
    }

    fn of_read(read: Result<Vec<u8>, Problem>, path: &Path, folder: &Path, set: &[String]) -> Self {
        match read {
            Ok(bytes) => Self::of_bytes(bytes, path, folder, set),
            Err(problem) => Self::failed(
                path,
                String::new(),
                Diagnostic::new(Span::default(), problem),
            ),
        }
    }

    fn of_bytes(bytes: Vec<u8>, path: &Path, folder: &Path, set: &[String]) -> Self {
        match String::from_utf8(bytes) {
            Ok(text) => Self::of_text_in(text, path, folder, set),
            Err(error) => {
                if let Some(problem) = foreign::recognized(error.as_bytes(), path) {
                    let diagnostic = Diagnostic::new(Span::default(), problem);
                    return Self::failed(path, String::new(), diagnostic);
                }
                let start = error.utf8_error().valid_up_to();
                let byte = error.as_bytes()[start];
                // The replacement character stands where the byte is.
                let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
                let end = text.ceil_char_boundary(start + 1);
                let span = Span::from(start..end);
                Self::failed(path, text, Diagnostic::new(span, Problem::NotUtf8 { byte }))
            }
        }
    }

    fn failed(path: &Path, text: String, diagnostic: Diagnostic) -> Self {
        let path = path.to_owned();
        Self {
            source: Arc::new(Source::new(path, text)),
            scene: None,
            diagnostics: vec![diagnostic],
            broken: Broken {
                lost_entries: true,
                ..Broken::default()
            },
            motion: None,
            frame: FIRST_FRAME,
        }
    }

    /// Whether a material of this name is in the file, be it in error; true also where it could
    /// be in a part that another error hides.
    pub fn is_known_material(&self, name: &str) -> bool {
        self.broken.lost_entries
            || self.broken.materials.contains(name)
            || self
                .scene
                .iter()
                .flat_map(|scene| &scene.materials)
                .any(|material| material.name == name)
    }

    /// The scene, if nothing is wrong with its form.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn complete(self) -> Result<Scene, Diagnostics> {
        match Diagnostics::new(self.source, self.diagnostics) {
            Some(diagnostics) => Err(diagnostics),
            None => Ok(self
                .scene
                .expect("that image or camera cannot be read is among the diagnostics")),
        }
    }
}

/// The scene of [`Reading`] before its text has moved to where it stays.
struct Unsourced {
    image: super::Image,
    camera: Spanned<super::Camera>,
    materials: Vec<super::Entry<super::Material>>,
    lights: Vec<super::Entry<super::Light>>,
    objects: Vec<super::Entry<super::Object>>,
    inputs: Vec<Input>,
    moving: Moving,
}

impl Unsourced {
    fn with(self, source: &Arc<Source>) -> (Scene, Motion) {
        let anchor = self.moving.anchor(&source.text);
        let motion = Motion::new(source, self.moving);
        let scene = Scene {
            source: Arc::clone(source),
            anchor,
            image: self.image,
            camera: self.camera,
            materials: self.materials,
            lights: self.lights,
            objects: self.objects,
            inputs: self.inputs,
        };
        (scene, motion)
    }
}

fn read_bytes(path: &Path) -> Result<Vec<u8>, Problem> {
    let file = File::open(path).map_err(Problem::Unreadable)?;
    if file.metadata().map_err(Problem::Unreadable)?.len() > LARGEST_FILE {
        return Err(too_large());
    }
    read_stream(file)
}

fn read_stream(stream: impl io::Read) -> Result<Vec<u8>, Problem> {
    let mut bytes = Vec::new();
    // One byte more than allowed tells a file that is too large, also where it is a pipe
    // or a device without a known size.
    stream
        .take(LARGEST_FILE + 1)
        .read_to_end(&mut bytes)
        .map_err(Problem::Unreadable)?;
    if bytes.len() as u64 > LARGEST_FILE {
        return Err(too_large());
    }
    Ok(bytes)
}

/// The folder of a scene file.
fn folder_of(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new(""))
}

const fn too_large() -> Problem {
    Problem::TooLarge {
        limit: LARGEST_FILE / 1_000_000,
    }
}

fn out_of_memory(error: OutOfMemory) -> Diagnostic {
    let problem = Problem::OutOfMemory {
        error: error.for_what("what the scene file describes"),
        way_out: "",
    };
    Diagnostic::new(Span::default(), problem)
}

/// The sections whose keys are the names of entries.
const ENTRIES: [&str; 3] = [
    sections::MATERIALS.key,
    sections::LIGHTS.key,
    sections::OBJECTS.key,
];

fn read(document: &mut Document) -> (Option<Unsourced>, Vec<Diagnostic>, Broken) {
    // What is wrong with the texts themselves, and with what was set.
    let mut of_texts = std::mem::take(&mut document.diagnostics);
    let mut damage = Damage::none();
    if !of_texts.is_empty() {
        damage.lose_a_text();
    }
    let text = document.source.text.as_str();
    let mut reader = Reader {
        text,
        damage,
        diagnostics: Vec::new(),
        files: Files::of(document),
        changes: Rc::new(Changes::read(&document.source, &mut of_texts)),
        frame: FIRST_FRAME,
        is_within_keys: false,
        key_frames: Vec::new(),
        moving: Moving::nothing(),
    };
    let mut found = Found::default();
    let mut read = Ok(());
    let mut is_toml = true;
    for range in document.texts() {
        let part = &text[range.clone()];
        if part.len() > WHOLE {
            read = read.and_then(|()| found.read_pieces(&mut reader, part, range.start));
        } else {
            let (root, damage, diagnostics) = syntax::parse(part, range.start);
            is_toml &= diagnostics.is_empty();
            reader.damage.add(damage);
            reader.diagnostics.extend(diagnostics);
            read = read.and_then(|()| found.read_whole(&mut reader, root));
        }
    }
    is_toml &= read.is_ok();
    let is_sound = reader.diagnostics.is_empty() && of_texts.is_empty();
    if read.is_ok() && found.is_nothing() && is_sound {
        let diagnostic = Diagnostic::new(Span::default(), Problem::Empty);
        return (None, vec![diagnostic], Broken::default());
    }
    if !is_toml
        && let Some(problem) =
            foreign::recognized(document.source.own_text().as_bytes(), &document.source.path)
    {
        let diagnostic = Diagnostic::new(Span::default(), problem);
        return (None, vec![diagnostic], Broken::default());
    }
    if let Err(diagnostic) = read {
        reader.damage = Damage::whole();
        reader.diagnostics = vec![*diagnostic];
    }
    found.complete(reader, of_texts)
}

/// What was found in a file so far.
#[derive(Default)]
struct Found<'t> {
    /// How many trees had sections.
    trees: usize,
    /// The sections without entries.
    root: DeTable<'t>,
    materials: Entries<super::Material>,
    lights: Entries<super::Light>,
    objects: Entries<super::Object>,
    /// Sections that there are not.
    unknown: HashSet<String>,
    /// The sections that they were meant to be.
    misspelt: Vec<String>,
}

impl<'t> Found<'t> {
    /// Whether there is no section at all.
    fn is_nothing(&self) -> bool {
        self.trees == 0
    }

    fn read_whole(
        &mut self,
        reader: &mut Reader<'t>,
        root: DeTable<'t>,
    ) -> Result<(), Box<Diagnostic>> {
        self.read_entries(reader, &root)?;
        for (key, node) in root {
            let name = key.get_ref().as_ref();
            if sections::SECTIONS.contains(&name) && !ENTRIES.contains(&name) {
                self.add(key, node)?;
            }
        }
        Ok(())
    }

    /// Reads a text that begins at `start` of the whole, piece by piece.
    fn read_pieces(
        &mut self,
        reader: &mut Reader<'t>,
        text: &'t str,
        start: usize,
    ) -> Result<(), Box<Diagnostic>> {
        let readable = syntax::readable(text);
        readable.map_err(|wrong| Box::new(wrong.placed(&|at| at + start)))?;
        pieces::for_each(text, start, |tree| match tree {
            Tree::Continued(tree) => self.read_entries(reader, tree),
            Tree::Own(tree) => self.read_whole(reader, tree),
        })
    }

    /// Adds what a piece has of a section without entries.
    fn add(
        &mut self,
        key: toml::Spanned<DeString<'t>>,
        node: Node<'t>,
    ) -> Result<(), Box<Diagnostic>> {
        let Some(known) = self.root.get_mut(key.get_ref().as_ref()) else {
            self.root.insert(key, node);
            return Ok(());
        };
        let span = Span::from(node.span());
        let (place, section) = (known.span(), key.get_ref().as_ref());
        let twice = |name: &str, first: std::ops::Range<usize>, span| {
            let problem = Problem::Duplicate {
                what: "section",
                name: name.to_owned(),
                first: Some(first.into()),
            };
            Box::new(Diagnostic::new(span, problem))
        };
        let (DeValue::Table(known), DeValue::Table(more)) = (known.get_mut(), node.into_inner())
        else {
            return Err(twice(section, place, span));
        };
        for (key, node) in more {
            if let Some((first, _)) = known.get_key_value(key.get_ref().as_ref()) {
                let name = format!("{section}.{}", key.get_ref());
                return Err(twice(&name, first.span(), key.span().into()));
            }
            known.insert(key, node);
        }
        Ok(())
    }

    fn read_entries(
        &mut self,
        reader: &mut Reader<'_>,
        root: &DeTable<'_>,
    ) -> Result<(), Box<Diagnostic>> {
        self.trees += usize::from(!root.is_empty());
        self.find_unknown_sections(reader, root);
        let mut read = sections::MATERIALS.read(reader, root, &mut self.materials);
        read = read.and_then(|()| sections::LIGHTS.read(reader, root, &mut self.lights));
        read = read.and_then(|()| sections::OBJECTS.read(reader, root, &mut self.objects));
        read.map_err(|error| Box::new(out_of_memory(error)))
    }

    /// Reports sections that there are not, and finds out which were meant.
    fn find_unknown_sections(&mut self, reader: &mut Reader<'_>, root: &DeTable<'_>) {
        for key in root.keys() {
            let name = key.get_ref().as_ref();
            let is_known = sections::SECTIONS.contains(&name) || name == INCLUDE;
            let is_unknown = !is_known && !self.unknown.contains(name);
            if is_unknown && self.unknown.len() < MOST_COLLECTED {
                self.unknown.insert(name.to_owned());
                let problem = sections::unknown_section(name);
                self.misspelt.extend(problem.nearest().map(str::to_owned));
                reader.report(key.span().into(), problem);
            }
        }
    }

    /// What is wrong with something that was set, whose keys lead to no entry.
    fn unused_change(&self, keys: &[toml::Spanned<DeString<'_>>]) -> Option<(Span, Problem)> {
        let (section, entry) = keys.split_first()?;
        let (name, span) = (section.get_ref().as_ref(), Span::from(section.span()));
        let kinds = ["material", "light", "object"];
        let Some(number) = ENTRIES.iter().position(|&known| known == name) else {
            let is_known = sections::SECTIONS.contains(&name);
            // That there is no image or camera is said already.
            return (!is_known).then(|| (span, sections::unknown_section(name)));
        };
        let Some(entry) = entry.first() else {
            return Some((span, sets_nothing()));
        };
        let names = match number {
            0 => self.materials.names(),
            1 => self.lights.names(),
            _ => self.objects.names(),
        };
        let problem = Problem::unknown(kinds[number], entry.get_ref(), names);
        Some((entry.span().into(), problem))
    }

    fn complete(
        mut self,
        mut reader: Reader<'t>,
        of_texts: Vec<Diagnostic>,
    ) -> (Option<Unsourced>, Vec<Diagnostic>, Broken) {
        let changes = Rc::clone(&reader.changes);
        for (key, node) in &mut self.root {
            if let Some((changed, wrong)) = changes.apply(&[key.get_ref()], node) {
                *node = changed;
                reader.report_all(wrong);
            }
        }
        let image = reader.watched(|reader| sections::image(reader, &self.root, &self.misspelt));
        let image = reader.note_motion(image, "image", None, self.root.get("image"));
        let camera = reader.watched(|reader| sections::camera(reader, &self.root, &self.misspelt));
        let camera = reader.note_motion(camera, "camera", None, self.root.get("camera"));
        let unused = changes.unused();
        reader.report_all(unused.filter_map(|keys| self.unused_change(keys)));
        reader.diagnostics.extend(of_texts);
        let inputs = reader.files.inputs();
        let broken = |names: &[String]| names.iter().cloned().collect();
        let broken = Broken {
            materials: broken(&self.materials.broken),
            lights: broken(&self.lights.broken),
            objects: broken(&self.objects.broken),
            lost_entries: reader.damage.lost_entries() || !self.misspelt.is_empty(),
        };
        let scene = image.zip(camera).map(|(image, camera)| Unsourced {
            image,
            camera,
            materials: self.materials.in_order(),
            lights: self.lights.in_order(),
            objects: self.objects.in_order(),
            inputs,
            moving: reader.moving.with(reader.key_frames, reader.files),
        });
        (scene, reader.diagnostics, broken)
    }
}

impl Reader<'_> {
    /// The luminaire in `file`; one that cannot be read is reported where it is named first.
    fn luminaire(&mut self, file: &Spanned<String>) -> Option<Arc<IesFile>> {
        let path = self.files.path(file);
        if let Some(known) = self.files.luminaires.get(&path) {
            return known.clone();
        }
        let loaded = match IesFile::load_hashed(&path) {
            Ok((luminaire, files)) => {
                for (path, hash) in files {
                    self.files.note(file, &path, hash);
                }
                Some(Arc::new(luminaire))
            }
            Err(error) => {
                let path = path.clone();
                let error = Box::new(error);
                self.report(file.span, Problem::Ies { path, error });
                None
            }
        };
        self.files.luminaires.insert(path, loaded.clone());
        loaded
    }

    /// The mesh in `file`; one that cannot be read is reported where it is named first.
    fn mesh(&mut self, file: &Spanned<String>) -> Option<Arc<MeshFile>> {
        let path = self.files.path(file);
        if let Some(known) = self.files.meshes.get(&path) {
            return known.clone();
        }
        let loaded = match MeshFile::load_hashed(&path) {
            Ok((mesh, hash)) => {
                self.files.note(file, &path, hash);
                Some(Arc::new(mesh))
            }
            Err(error) => {
                let path = path.clone();
                let error = Box::new(error);
                self.report(file.span, Problem::Mesh { path, error });
                None
            }
        };
        self.files.meshes.insert(path, loaded.clone());
        loaded
    }
}
