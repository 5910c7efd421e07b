//! The mesh as it grows while its file is read.

use super::MeshRemarks;
use super::error::Fault;
use super::limits::MAX_CORNERS;
use super::memory::Memory;
use super::polygon::Triangulator;

/// The vertices and triangles read so far.
#[derive(Debug)]
pub(super) struct Surface {
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) remarks: MeshRemarks,
    pub(super) memory: Memory,
    /// The vertex whose position is a fault if it is not finite; others are only counted.
    wanted: Option<u32>,
    triangulator: Triangulator,
}

impl Surface {
    /// Nothing yet, of a file of `size` bytes.
    pub(super) fn for_file(size: usize) -> Self {
        Self {
            positions: Vec::new(),
            triangles: Vec::new(),
            remarks: MeshRemarks::default(),
            memory: Memory::for_file(size),
            wanted: None,
            triangulator: Triangulator::for_file(size),
        }
    }

    /// As [`Surface::for_file`], to find out what is wrong with a vertex: see
    /// [`Surface::broken_vertex`].
    pub(super) fn to_find(vertex: u32, size: usize) -> Self {
        Self {
            wanted: Some(vertex),
            ..Self::for_file(size)
        }
    }

    /// Room for `additional` more triangles.
    #[inline]
    pub(super) fn room_for_triangles(&mut self, additional: usize) -> Result<(), Box<Fault>> {
        self.memory
            .make_room(&mut self.triangles, additional, "triangles")
    }

    /// Whether the next vertex is the one that is wanted.
    pub(super) fn is_wanted(&self) -> bool {
        self.wanted == Some(self.positions.len() as u32)
    }

    /// A vertex. Whether it must be finite, the faces decide: see [`Surface::broken_vertex`].
    #[inline]
    pub(super) fn vertex(&mut self, position: [f64; 3]) -> Result<(), Box<Fault>> {
        if !is_finite(position) {
            self.not_finite(position)?;
        }
        self.memory.make_room(&mut self.positions, 1, "vertices")?;
        self.positions.push(position);
        Ok(())
    }

    #[cold]
    fn not_finite(&mut self, position: [f64; 3]) -> Result<(), Box<Fault>> {
        let mut coordinates = ['x', 'y', 'z'].into_iter().zip(position);
        if self.is_wanted()
            && let Some((axis, value)) = coordinates.find(|(_, value)| !value.is_finite())
        {
            return Err(Box::new(Fault::NotFinite { axis, value }));
        }
        MeshRemarks::add(&mut self.remarks.unused_positions);
        Ok(())
    }

    /// The first vertex without a finite position that a triangle uses. Where there is none, those that
    /// no triangle uses get the position of one that is used, once all of the file is read.
    pub(super) fn broken_vertex(&mut self) -> Option<u32> {
        if self.remarks.unused_positions == 0 {
            return None;
        }
        let is_broken = |&&vertex: &&u32| !is_finite(self.positions[vertex as usize]);
        let broken = self.triangles.iter().flatten().filter(is_broken).min();
        let used = self
            .triangles
            .first()
            .map(|&[a, _, _]| self.positions[a as usize]);
        if let (None, Some(used)) = (broken, used) {
            for position in self.positions.iter_mut().filter(|p| !is_finite(**p)) {
                *position = used;
            }
        }
        broken.copied()
    }

    /// A face with these corners, which exist; each triangle's corner numbers go to `triangle`.
    /// One of fewer than three corners is skipped.
    #[inline]
    pub(super) fn face(
        &mut self,
        corners: &[u32],
        mut triangle: impl FnMut(&mut Memory, [u32; 3]) -> Result<(), Box<Fault>>,
    ) -> Result<(), Box<Fault>> {
        if let &[a, b, c] = corners {
            self.room_for_triangles(1)?;
            self.triangles.push([a, b, c]);
            return triangle(&mut self.memory, [0, 1, 2]);
        }
        if corners.len() < 3 {
            MeshRemarks::add(&mut self.remarks.small_faces);
            return Ok(());
        }
        corner_count(corners.len() as i64)?;
        self.room_for_triangles(corners.len() - 2)?;
        let positions = corners.iter().map(|&i| self.positions[i as usize]);
        let cut = self.triangulator.triangulate(positions)?;
        if cut.folded {
            MeshRemarks::add(&mut self.remarks.folded_polygons);
        }
        for &numbers in cut.triangles {
            self.triangles.push(numbers.map(|i| corners[i as usize]));
            triangle(&mut self.memory, numbers)?;
        }
        Ok(())
    }
}

/// Whether a face can have this many corners; the number as a size.
#[inline]
pub(super) fn corner_count(corners: i64) -> Result<usize, Box<Fault>> {
    match usize::try_from(corners) {
        Ok(count @ ..=MAX_CORNERS) => Ok(count),
        Ok(_) => Err(Box::new(Fault::TooManyCorners { corners })),
        Err(_) => Err(Fault::unexpected(
            corners.to_string().as_bytes(),
            "the number of a face's corners",
        )),
    }
}

/// Whether all coordinates are finite.
#[inline]
fn is_finite(position: [f64; 3]) -> bool {
    position.iter().all(|x| x.is_finite())
}
