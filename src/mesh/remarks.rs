//! What of a mesh file was not taken as written.

use crate::printable::excerpt;

/// What was skipped or repaired, counted so that `candela check` and `candela render` can say so;
/// all zero for a mesh without flaws.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshRemarks {
    /// Normals without a direction (zero, infinite or NaN) that a triangle with area uses.
    ///
    /// In PLY each became the mean of the geometric normals of the triangles around its vertex.
    /// In OBJ each face that names one has its triangles' geometric normals; these triangles are
    /// counted.
    pub mended_normals: u32,
    /// Corners of OBJ faces whose index of a normal names none. Their faces have the triangles'
    /// geometric normals.
    pub absent_normals: u32,
    /// OBJ faces of corners with and without a normal; they have geometric normals.
    pub partial_normals: u32,
    /// Polygons that cross themselves, so that some of their triangles are turned over or
    /// overlap.
    pub folded_polygons: u32,
    /// Faces and strips of fewer than three corners, which were skipped.
    pub small_faces: u32,
    /// Vertices without a finite position that no triangle uses.
    pub unused_positions: u32,
    /// OBJ statements of lines, points, curves and curved surfaces, which are not rendered.
    pub skipped_statements: u32,
    /// OBJ statements, and lines of a PLY header, that are none of the format.
    pub unknown_statements: u32,
    /// The first word of the first of these.
    pub unknown_example: Option<String>,
    /// Lines of text with more or fewer values than belong there, all those that are used being
    /// there.
    pub uneven_lines: u32,
    /// Whether the numbers of an ASCII PLY file are not parted into lines by elements, so that they
    /// were read one after the other.
    pub unlined: bool,
    /// Bytes, other than blanks, behind all that a PLY header counts.
    pub trailing_bytes: u64,
}

impl MeshRemarks {
    /// Whether everything was taken as written.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// These without what is about vertex normals, for a mesh that does not use them.
    #[must_use]
    pub fn without_normals(&self) -> Self {
        Self {
            mended_normals: 0,
            absent_normals: 0,
            partial_normals: 0,
            ..self.clone()
        }
    }

    /// Each as text: what the file has, and what became of it.
    pub fn list(&self) -> Vec<String> {
        let unknown = self.unknown_example.as_deref().unwrap_or_default();
        let unknown = [
            format!("unknown statement, `{unknown}`, which was skipped"),
            format!("unknown statements such as `{unknown}`, which were skipped"),
        ];
        let counts = [
            (
                u64::from(self.mended_normals),
                "normal without a direction, replaced by the geometric one",
                "normals without a direction, replaced by geometric ones",
            ),
            (
                u64::from(self.absent_normals),
                "corner that names a normal that is not there, replaced by the geometric one",
                "corners that name a normal that is not there, replaced by geometric ones",
            ),
            (
                u64::from(self.partial_normals),
                "face with normals at some corners only, which has its geometric one",
                "faces with normals at some corners only, which have their geometric ones",
            ),
            (
                u64::from(self.folded_polygons),
                "polygon that crosses itself",
                "polygons that cross themselves",
            ),
            (
                u64::from(self.small_faces),
                "face of fewer than 3 corners, which was skipped",
                "faces of fewer than 3 corners, which were skipped",
            ),
            (
                u64::from(self.unused_positions),
                "vertex without a finite position, which no face uses",
                "vertices without a finite position, which no face uses",
            ),
            (
                u64::from(self.skipped_statements),
                "line, point or curve, which is not rendered",
                "lines, points or curves, which are not rendered",
            ),
            (u64::from(self.unknown_statements), &unknown[0], &unknown[1]),
            (
                u64::from(self.uneven_lines),
                "line with more or fewer values than belong there",
                "lines with more or fewer values than belong there",
            ),
            (
                self.trailing_bytes,
                "byte behind all that its header counts, which was skipped",
                "bytes behind all that its header counts, which were skipped",
            ),
        ];
        let counts = counts.into_iter().filter(|&(count, ..)| count > 0);
        let counts = counts
            .map(|(count, one, many)| format!("{count} {}", if count == 1 { one } else { many }));
        let unlined = "lines that are not an element each, so that its numbers were read one after \
            the other";
        counts
            .chain(self.unlined.then(|| unlined.to_owned()))
            .collect()
    }

    /// One more of `count`.
    pub(super) fn add(count: &mut u32) {
        *count = count.saturating_add(1);
    }

    /// A statement that begins with an unknown `word`.
    pub(super) fn unknown(&mut self, word: &[u8]) {
        Self::add(&mut self.unknown_statements);
        if self.unknown_example.is_none() {
            self.unknown_example = Some(excerpt(word));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_and_many() {
        assert!(MeshRemarks::default().is_empty());
        assert!(MeshRemarks::default().list().is_empty());
        let mut remarks = MeshRemarks {
            mended_normals: 1,
            folded_polygons: 2,
            trailing_bytes: 1,
            ..MeshRemarks::default()
        };
        remarks.unknown(b"vw\x1b");
        assert_eq!(
            remarks.list(),
            [
                "1 normal without a direction, replaced by the geometric one",
                "2 polygons that cross themselves",
                "1 unknown statement, `vw\\x1b`, which was skipped",
                "1 byte behind all that its header counts, which was skipped",
            ]
        );
        remarks.unknown(b"other");
        assert_eq!(
            remarks.without_normals().list()[1],
            "2 unknown statements such as `vw\\x1b`, which were skipped"
        );
    }
}
