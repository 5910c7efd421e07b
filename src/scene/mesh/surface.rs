//! The mesh as it grows while its file is read.

use super::error::Fault;
use super::memory::Memory;
use super::polygon::{MAX_CORNERS, Triangulator};

/// The vertices and triangles read so far.
#[derive(Debug)]
pub(super) struct Surface {
    pub(super) positions: Vec<[f64; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
    /// Polygons with triangles that are turned over or overlap.
    pub(super) folded_polygons: u32,
    pub(super) memory: Memory,
    triangulator: Triangulator,
}

impl Surface {
    /// Nothing yet, of a file of `size` bytes.
    pub(super) fn for_file(size: usize) -> Self {
        Self {
            positions: Vec::new(),
            triangles: Vec::new(),
            folded_polygons: 0,
            memory: Memory::for_file(size),
            triangulator: Triangulator::for_file(size),
        }
    }

    /// Room for `additional` more triangles.
    #[inline]
    pub(super) fn room_for_triangles(&mut self, additional: usize) -> Result<(), Box<Fault>> {
        self.memory
            .make_room(&mut self.triangles, additional, "triangles")
    }

    /// A finite position.
    #[inline]
    pub(super) fn vertex(&mut self, position: [f64; 3]) -> Result<(), Box<Fault>> {
        finite(position)?;
        self.memory.make_room(&mut self.positions, 1, "vertices")?;
        self.positions.push(position);
        Ok(())
    }

    /// A face with these corners, which exist; each triangle's corner numbers go to `triangle`.
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
        corner_count(corners.len() as i64)?;
        self.room_for_triangles(corners.len() - 2)?;
        let positions = corners.iter().map(|&i| self.positions[i as usize]);
        let cut = self.triangulator.triangulate(positions)?;
        self.folded_polygons = self.folded_polygons.saturating_add(u32::from(cut.folded));
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
        Ok(count @ 3..=MAX_CORNERS) => Ok(count),
        Ok(0..3) | Err(_) => Err(Box::new(Fault::TooFewCorners { corners })),
        Ok(_) => Err(Box::new(Fault::TooManyCorners { corners })),
    }
}

/// Whether all coordinates are finite.
#[inline]
pub(super) fn finite(position: [f64; 3]) -> Result<(), Box<Fault>> {
    for (axis, value) in ['x', 'y', 'z'].into_iter().zip(position) {
        if !value.is_finite() {
            return Err(Box::new(Fault::NotFinite { axis, value }));
        }
    }
    Ok(())
}
