//! L2: the shapes, legal and in world space relative to the anchor.

use std::ops::Range;

use crate::math::{DVec3, Normal, Point, all_three};
use crate::mesh::MeshRemarks;
use crate::scene::ShadowTerminator;

/// ‖p − c‖ = R. Range: R above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// c
    pub center: Point,
    /// R
    pub radius: f64,
    /// The object that it belongs to.
    pub object: u32,
}

/// n · (p − p₀) = 0, without end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// p₀
    pub point: Point,
    /// n
    pub normal: Normal,
    /// The object that it belongs to.
    pub object: u32,
}

/// ‖p − c‖ ≤ R and n · (p − c) = 0: flat and round. Range: R above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disk {
    /// c
    pub center: Point,
    /// n
    pub normal: Normal,
    /// R
    pub radius: f64,
    /// The object that it belongs to.
    pub object: u32,
}

impl Disk {
    /// The plane that it is in.
    #[inline(always)]
    pub(crate) fn plane(&self) -> Plane {
        Plane {
            point: self.center,
            normal: self.normal,
            object: self.object,
        }
    }
}

/// All triangles of the world, mesh after mesh in the order of the objects. None is degenerate.
#[derive(Clone, Debug, Default)]
pub struct Triangles {
    /// Vertex positions of all meshes.
    pub(super) positions: Vec<DVec3>,
    /// Three indices into the positions for each triangle.
    pub(super) corners: Vec<[u32; 3]>,
    /// The meshes; their triangle ranges follow each other without gaps.
    pub(super) meshes: Vec<Mesh>,
}

/// One mesh, or one triangle as a mesh of its own.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// The object that it belongs to.
    pub object: u32,
    /// Its triangles.
    pub triangles: Range<u32>,
    /// Vertex normals where the plan interpolates them.
    pub normals: Option<MeshNormals>,
    /// Where its shadow rays start, as asked for.
    pub shadow_terminator: ShadowTerminator,
    /// How many triangles of the file had no area and were dropped.
    pub degenerate: usize,
    /// How many more were dropped since f64 cannot tell their corners apart where they are placed.
    pub vanished: usize,
    /// What of the file was not taken as written.
    pub remarks: MeshRemarks,
}

/// Vertex normals of a mesh in world space.
#[derive(Clone, Debug)]
pub struct MeshNormals {
    /// The normals.
    pub vectors: Vec<Normal>,
    /// Which of them a triangle has.
    pub corners: NormalCorners,
}

/// Which normals belong to the corners of triangles.
#[derive(Clone, Debug)]
pub enum NormalCorners {
    /// Those of their vertices: the first normal is that of this one.
    OfVertices(u32),
    /// Three indices for each triangle of the mesh.
    Own(Vec<[u32; 3]>),
}

/// Which corner of a triangle comes first, in the same cyclic order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Turn(u8);

impl Turn {
    /// The corner between the two shorter edges first. The cross product of two long and nearly parallel
    /// edges would lose the short one's digits.
    #[inline(always)]
    pub(crate) fn to_shorter_edges([a, b, c]: [DVec3; 3]) -> Self {
        let [ab, bc, ca] = all_three([b - a, c - b, a - c], DVec3::length_squared);
        if bc >= ab && bc >= ca {
            Self(0)
        } else if ca >= ab {
            Self(1)
        } else {
            Self(2)
        }
    }

    #[inline(always)]
    pub(crate) fn of<T>(self, [a, b, c]: [T; 3]) -> [T; 3] {
        match self.0 {
            0 => [a, b, c],
            1 => [b, c, a],
            _ => [c, a, b],
        }
    }

    /// In two bits.
    pub(crate) fn bits(self) -> u32 {
        u32::from(self.0)
    }

    /// Of the lowest two bits.
    #[inline(always)]
    pub(crate) fn of_bits(bits: u32) -> Self {
        Self((bits & 3) as u8)
    }

    /// The places of the corners before; by a table, since no branch could guess it.
    #[inline(always)]
    fn places(self) -> [usize; 3] {
        const PLACES: [[usize; 3]; 4] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [2, 0, 1]];
        PLACES[usize::from(self.0 & 3)]
    }
}

/// The same triangle, [its corner between the two shorter edges](Turn::to_shorter_edges) first.
#[inline(always)]
pub(crate) fn from_shorter_edges(vertices: [DVec3; 3]) -> [DVec3; 3] {
    Turn::to_shorter_edges(vertices).of(vertices)
}

/// Normal times twice the area of a triangle that starts at the corner
/// [between its shorter edges](from_shorter_edges).
#[inline(always)]
pub(crate) fn area_vector([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// The normal of a triangle, on the side from which its corners are counter-clockwise; `None`
/// where it has no area.
#[inline(always)]
pub(crate) fn triangle_normal(vertices: [DVec3; 3]) -> Option<Normal> {
    Normal::new(area_vector(from_shorter_edges(vertices)))
}

impl Mesh {
    /// Whether its shadow rays start off its triangles, at p′: see [`ShadowTerminator::Hanika`]. Without
    /// vertex normals nothing says where that is.
    pub fn lifts_shadow_rays(&self) -> bool {
        match self.shadow_terminator {
            ShadowTerminator::Geometric => false,
            ShadowTerminator::Hanika => self.normals.is_some(),
        }
    }
}

impl Triangles {
    /// How many there are.
    pub fn len(&self) -> usize {
        self.corners.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.corners.is_empty()
    }

    /// The meshes in the order of the objects.
    pub fn meshes(&self) -> &[Mesh] {
        &self.meshes
    }

    /// The corners of a triangle.
    #[inline]
    pub fn vertices(&self, triangle: u32) -> [DVec3; 3] {
        all_three(self.corners[triangle as usize], |vertex| {
            self.positions[vertex as usize]
        })
    }

    /// The corners of a triangle from one of them on.
    #[inline(always)]
    pub(crate) fn vertices_from(&self, triangle: u32, start: Turn) -> [DVec3; 3] {
        let corners = &self.corners[triangle as usize];
        all_three(
            start.places(),
            #[inline(always)]
            |place| self.positions[corners[place] as usize],
        )
    }

    /// The mesh that a triangle belongs to.
    #[inline]
    pub fn mesh(&self, triangle: u32) -> &Mesh {
        let after = self
            .meshes
            .partition_point(|mesh| mesh.triangles.start <= triangle);
        &self.meshes[after - 1]
    }

    /// Bytes of the arrays.
    pub fn memory(&self) -> usize {
        let normals = self.meshes.iter().filter_map(|mesh| mesh.normals.as_ref());
        size_of_val(self.positions.as_slice())
            + size_of_val(self.corners.as_slice())
            + size_of_val(self.meshes.as_slice())
            + normals
                .map(|normals| {
                    size_of_val(normals.vectors.as_slice())
                        + match &normals.corners {
                            NormalCorners::OfVertices(_) => 0,
                            NormalCorners::Own(corners) => size_of_val(corners.as_slice()),
                        }
                })
                .sum::<usize>()
    }

    /// The normals at the corners of a triangle, of a mesh that has `normals` and begins with triangle `first`.
    #[inline]
    pub fn normals_at(&self, normals: &MeshNormals, first: u32, triangle: u32) -> [Normal; 3] {
        let corners = match &normals.corners {
            NormalCorners::OfVertices(vertex) => {
                all_three(self.corners[triangle as usize], |corner| corner - vertex)
            }
            NormalCorners::Own(corners) => corners[(triangle - first) as usize],
        };
        all_three(corners, |corner| normals.vectors[corner as usize])
    }
}
