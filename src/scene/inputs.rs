//! What a picture depends on, as hashes: of the scene file, of the files that it names, and of the
//! content of scenes that no file has.

use std::collections::HashMap;
use std::fmt::{self, Write as _};
use std::path::PathBuf;
use std::sync::Arc;

use sha2::{Digest, Sha256};

use super::{Object, Scene};
use crate::input::Hash;
use crate::mesh::MeshFile;

/// A file that a scene names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    /// As written in the scene.
    pub name: String,
    /// Joined to the scene's folder.
    pub path: PathBuf,
    /// Of its bytes as they were read.
    pub hash: Hash,
}

impl Scene {
    /// SHA-256 of the scene file's text; of a scene made in code, whose text is empty, of all that
    /// it holds: it differs wherever a value differs, and is the same for the same values with
    /// one version of candela.
    pub fn hash(&self) -> Hash {
        if self.source.text.is_empty() {
            self.content_hash()
        } else {
            Hash::of(self.source.own_text().as_bytes())
        }
    }

    /// SHA-256 of all files that the picture depends on: of the lines that are the hash of the scene
    /// file, as `sha256sum` prints it, then of each file that the scene names, in the order of
    /// [`Scene::inputs`], then of each text that was set on the command line. A scene that names no other file has
    /// one line. Names are no part of it: those of files stand in the scene file. Of a scene made in code it is
    /// [`Scene::hash`], which covers its meshes and curves.
    pub fn inputs_hash(&self) -> Hash {
        let hash = self.hash();
        if self.source.text.is_empty() {
            return hash;
        }
        let mut lines = Hasher::default();
        let set = self.source.set().map(|text| Hash::of(text.as_bytes()));
        let inputs = self.inputs.iter().map(|input| input.hash);
        for hash in std::iter::once(hash).chain(inputs).chain(set) {
            lines.line(&hash);
        }
        lines.finish()
    }

    fn content_hash(&self) -> Hash {
        let Self {
            source: _,
            anchor,
            image,
            camera,
            materials,
            lights,
            objects,
            inputs: _,
        } = self;
        let mut hasher = Hasher::default();
        let mut meshes: HashMap<*const MeshFile, usize> = HashMap::new();
        if let Some(anchor) = anchor {
            hasher.debug(anchor);
        }
        hasher.debug(image);
        hasher.debug(camera);
        hasher.debug(materials);
        hasher.debug(lights);
        for entry in objects {
            let mut entry = entry.clone();
            if let Object::Mesh { geometry, .. } = &mut entry.value {
                // Each mesh once, however many objects have it: where it comes first.
                let count = meshes.len();
                let number = *meshes.entry(Arc::as_ptr(geometry)).or_insert_with(|| {
                    hasher.debug(geometry);
                    count
                });
                hasher.debug(&number);
                *geometry = Arc::default();
            }
            hasher.debug(&entry);
        }
        hasher.finish()
    }
}

/// Hashes text as it is written.
#[derive(Default)]
struct Hasher(Sha256);

impl fmt::Write for Hasher {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}

impl Hasher {
    /// A hash on a line of its own.
    fn line(&mut self, hash: &Hash) {
        writeln!(self, "{hash}").expect("a hash takes any text");
    }

    /// A value with all its digits and names.
    fn debug(&mut self, value: &impl fmt::Debug) {
        writeln!(self, "{value:?}").expect("a hash takes any text");
    }

    fn finish(self) -> Hash {
        Hash::finished(self.0)
    }
}
