//! Mesh files as they are on disk: PLY and OBJ, before any transformation.
//!
//! A file is read in blocks, each parsed while it is in the processor's cache. What makes the readers candela's own instead of a
//! crate's: every error says where (line, or byte and element) and what was expected, no memory
//! is allocated on the word of a count in the file, and text is scanned at hundreds of megabytes
//! a second with every decimal number rounded to the nearest f64.
//!
//! Loading takes linear time, and at most ten times the file's size plus 64 MB of memory, whatever
//! the file says; a usual mesh takes what it keeps and no more.

mod decimal;
mod error;
mod limits;
mod memory;
mod normals;
mod obj;
mod ply;
mod polygon;
mod remarks;
mod separators;
mod source;
mod strip;
mod surface;
mod text;

use std::io::Cursor;
use std::ops::Range;
use std::path::Path;

pub use error::MeshError;
#[doc(hidden)]
pub use error::{ElementPlace, Fault, Place, Position};
pub use remarks::MeshRemarks;
use source::Source;

use crate::input::{self, Foreign, Hash, Hashed};

/// A mesh as its file has it: positions in f64, polygons cut into triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshFile {
    /// Vertex positions. Range: finite. Those of [`MeshRemarks::unused_positions`] are any.
    pub positions: Vec<[f64; 3]>,
    /// Three indices into `positions` each, counter-clockwise seen from outside. Triangles
    /// without area are among them as the file has them.
    pub triangles: Vec<[u32; 3]>,
    /// Vertex normals, if the file has them.
    pub normals: Option<MeshNormals>,
    /// Named parts of the mesh (OBJ `g` and `o`), in the order of the file; empty where it has
    /// none. Ranges into `triangles`, not overlapping, none of them empty; triangles before the
    /// first name belong to no group.
    pub groups: Vec<MeshGroup>,
    /// What was not taken as written.
    pub remarks: MeshRemarks,
}

/// Vertex normals of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshNormals {
    /// The normals: finite, of any length but zero. As written, but for those that
    /// [`MeshRemarks::mended_normals`] counts.
    pub vectors: Vec<[f64; 3]>,
    /// Three indices into `vectors` for each triangle, where they differ from the position
    /// indices; `None` where normal i belongs to position i (as always in PLY).
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

impl MeshFile {
    /// Reads a PLY or OBJ file; which one it is, its first bytes and then its name tell.
    ///
    /// # Errors
    /// [`MeshError`] for anything that is not a whole and finite mesh with at least one triangle.
    pub fn load(path: &Path) -> Result<Self, MeshError> {
        Self::load_hashed(path).map(|(mesh, _)| mesh)
    }

    /// [`MeshFile::load`], and the hash of the file's bytes.
    pub(super) fn load_hashed(path: &Path) -> Result<(Self, Hash), MeshError> {
        let (file, size) = input::open::<MeshError>(path)?;
        let size = usize::try_from(size).unwrap_or(usize::MAX);
        let mut file = Hashed::new(file);
        let mesh = Self::read(Source::new(&mut file, size)?, path)?;
        Ok((mesh, file.finish()?))
    }

    /// Reads a mesh from the bytes of a PLY or OBJ file of the name `name`.
    ///
    /// # Errors
    /// As [`MeshFile::load`].
    pub fn parse(bytes: &[u8], name: &Path) -> Result<Self, MeshError> {
        Self::read(Source::new(&mut Cursor::new(bytes), bytes.len())?, name)
    }

    fn read(mut source: Source<'_>, name: &Path) -> Result<Self, MeshError> {
        const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();
        if source.window().starts_with(BYTE_ORDER_MARK) {
            source.skip(BYTE_ORDER_MARK.len());
        }
        let start = source.window();
        if start.is_empty() {
            return Err(MeshError::Empty);
        }
        if let Some(found) = Foreign::of(start) {
            return Err(MeshError::Foreign { found });
        }
        let extension = |expected: &str| {
            name.extension()
                .is_some_and(|written| written.eq_ignore_ascii_case(expected))
        };
        if ply::has_signature(start) {
            ply::read(source)
        } else if extension("obj") {
            obj::read(source)
        } else if extension("ply") {
            let first_line = text::Scanner::new(start, text::Dialect::Ply).skip_line();
            Err(Fault::unexpected(first_line, "`ply`, the first line of a PLY file").at_line(1))
        } else {
            Err(MeshError::UnknownFormat)
        }
    }
}

/// `a` − `b`
#[inline]
fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a` × `b`
#[inline]
fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_mesh_file() {
        let message = |bytes: &[u8], name: &str| {
            MeshFile::parse(bytes, Path::new(name))
                .unwrap_err()
                .to_string()
        };
        assert!(message(b"", "a.ply").contains("empty"));
        assert!(message(b"solid x", "a.stl").contains("unknown mesh format"));
        assert!(message(b"v 1 2 3", "obj").contains("unknown mesh format"));
        assert_eq!(
            message(b"solid \xff\ny", "a.ply"),
            "line 1: found `solid \\xff`, expected `ply`, the first line of a PLY file"
        );
        assert!(message(b"# nothing\n", "a.OBJ").contains("no faces"));
    }

    #[test]
    fn files_that_cannot_be_read() {
        let folder = tempfile::tempdir().unwrap();
        let error = MeshFile::load(folder.path()).unwrap_err();
        assert_eq!(
            error.to_string(),
            "it is a directory, expected a PLY or OBJ file"
        );
        let error = MeshFile::load(&folder.path().join("absent.ply")).unwrap_err();
        assert!(matches!(error, MeshError::Io(_)), "{error}");
    }

    #[test]
    fn the_signature_decides_before_the_name() {
        let ply = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
            property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
            0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.obj");
        std::fs::write(&path, ply).unwrap();
        assert_eq!(MeshFile::load(&path).unwrap().triangles, [[0, 1, 2]]);
    }
}
