//! The files that a scene names: meshes, luminaires and curves.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::super::diagnostic::{Span, Spanned};
use super::super::inputs::Input;
use super::document::Document;
use crate::ies::IesFile;
use crate::input::Hash;
use crate::mesh::MeshFile;
use crate::spectrum::Curve;

/// The files that one scene names, each read once; `None` for a file that could not be read,
/// which has been reported.
#[derive(Clone, Debug, Default)]
pub(super) struct Files {
    /// What paths are relative to that are named from these places on.
    pub(super) folders: Vec<(usize, PathBuf)>,
    pub(super) meshes: HashMap<PathBuf, Option<Arc<MeshFile>>>,
    pub(super) luminaires: HashMap<PathBuf, Option<Arc<IesFile>>>,
    pub(super) curves: HashMap<PathBuf, Option<Arc<Curve>>>,
    /// Those that were read, and where they are named first.
    pub(super) read: Vec<(Span, Input)>,
}

impl Files {
    pub(super) fn of(document: &Document) -> Self {
        Self {
            folders: document.folders.clone(),
            meshes: HashMap::new(),
            luminaires: HashMap::new(),
            curves: HashMap::new(),
            read: document.included.clone(),
        }
    }

    /// Where the file is that is named at `name.span`.
    pub(super) fn path(&self, name: &Spanned<String>) -> PathBuf {
        let is_before = |(start, _): &&(usize, PathBuf)| *start <= name.span.start;
        match self.folders.iter().rfind(is_before) {
            Some((_, folder)) => folder.join(&name.value),
            None => PathBuf::from(&name.value),
        }
    }

    /// Remembers a file that was read for what is written at `name.span`.
    pub(super) fn note(&mut self, name: &Spanned<String>, path: &Path, hash: Hash) {
        let input = Input {
            name: name.value.clone(),
            path: path.to_owned(),
            hash,
        };
        self.read.push((name.span, input));
    }

    /// The files that were read, in the order in which the scene names them: sections are read in
    /// another one.
    pub(super) fn inputs(&mut self) -> Vec<Input> {
        self.read.sort_by_key(|&(span, _)| span);
        self.read.drain(..).map(|(_, input)| input).collect()
    }
}
