//! Which shape it is: by its place in the scene, and by its place in the arrays.

use fearless_simd::Simd;

use super::batch::BATCH;
use crate::simd::{LANES, Mask32x16, U64x16};

/// One shape that a ray can hit: its object, and of a mesh its triangle, in the order of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Primitive(pub(super) u64);

impl Primitive {
    /// An object of one shape.
    #[inline]
    pub(super) fn whole(object: u32) -> Self {
        Self(u64::from(object) << 32)
    }

    /// A triangle, by its index in the world.
    #[inline]
    pub(super) fn triangle(object: u32, index: u32) -> Self {
        Self(u64::from(object) << 32 | u64::from(index))
    }

    /// The object, and the triangle.
    #[inline]
    pub(super) fn parts(self) -> (u32, u32) {
        ((self.0 >> 32) as u32, self.0 as u32)
    }

    #[inline(always)]
    pub(super) fn lanes<S: Simd>(self, simd: S) -> U64x16<S> {
        U64x16::splat(simd, self.0)
    }
}

/// The slots of the shapes: what the kinds have beside the place among their kind.
pub(super) const TRIANGLES: u32 = 0;
pub(super) const SPHERES: u32 = 1 << 30;
pub(super) const PLANES: u32 = 2 << 30;
pub(super) const DISKS: u32 = 3 << 30;

/// Which shape it is.
#[derive(Clone, Copy)]
pub(super) struct ShapeId {
    pub(super) slot: u32,
    pub(super) primitive: Primitive,
}

impl ShapeId {
    /// The points of a packet that are on the shape, of which `primitives` says what each is on.
    #[inline(always)]
    pub(super) fn has<S: Simd>(
        self,
        simd: S,
        primitives: &[u64; BATCH],
        packet: usize,
    ) -> Mask32x16<S> {
        let on = U64x16::load(simd, &primitives[packet * LANES..]);
        Mask32x16::from_bits(simd, on.eq(self.primitive.lanes(simd)).to_bits())
    }
}
