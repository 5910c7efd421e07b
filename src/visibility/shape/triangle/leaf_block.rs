//! Leaf blocks: triangles quantized to f32 around a middle in f64, as projections take them.

use std::hint::black_box;

use fearless_simd::Simd;

use crate::math::{DVec3, all_three, both};
use crate::simd::{DVec3x16, F32x16, LANES};
use crate::visibility::batch::Row;
use crate::visibility::projection::{BatchProjection, NEGLIGIBLE};
use crate::world::geometry::Turn;

/// How far offsets from the middle are off by its place, over its largest coordinate: a corner less the middle and
/// back again are two roundings of ε/2, in each of three axes, and less than as much again for room.
const MIDDLE_ROUNDING: f64 = 4.0 * f64::EPSILON;

/// One rounding to f32.
pub(in crate::visibility) const F32_ROUNDING: f32 = 1.0 / (1 << 24) as f32;

/// A vector in each lane.
#[derive(Clone, Copy)]
pub(in crate::visibility) struct SingleVectors<S: Simd> {
    pub(in crate::visibility) x: F32x16<S>,
    pub(in crate::visibility) y: F32x16<S>,
    pub(in crate::visibility) z: F32x16<S>,
}

impl<S: Simd> SingleVectors<S> {
    #[inline(always)]
    pub(in crate::visibility) fn load(simd: S, [x, y, z]: &[Row; 3]) -> Self {
        Self {
            x: F32x16::load(simd, &x.0),
            y: F32x16::load(simd, &y.0),
            z: F32x16::load(simd, &z.0),
        }
    }

    /// In other axes.
    #[inline(always)]
    pub(in crate::visibility) fn turned(self, simd: S, [u, v, w]: &[[f32; 3]; 3]) -> Self {
        Self {
            x: self.along(simd, u),
            y: self.along(simd, v),
            z: self.along(simd, w),
        }
    }

    #[inline(always)]
    fn along(self, simd: S, [x, y, z]: &[f32; 3]) -> F32x16<S> {
        let zs = self.z * F32x16::splat(simd, *z);
        let yzs = self.y.times_plus(F32x16::splat(simd, *y), zs);
        self.x.times_plus(F32x16::splat(simd, *x), yzs)
    }

    #[inline(always)]
    pub(in crate::visibility) fn plus(self, other: Self) -> Self {
        Self {
            x: self.x + other.x,
            y: self.y + other.y,
            z: self.z + other.z,
        }
    }

    #[inline(always)]
    pub(in crate::visibility) fn minus(self, other: Self) -> Self {
        Self {
            x: self.x - other.x,
            y: self.y - other.y,
            z: self.z - other.z,
        }
    }

    #[inline(always)]
    pub(in crate::visibility) fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    #[inline(always)]
    pub(in crate::visibility) fn dot(self, other: Self) -> F32x16<S> {
        let yzs = self.y.times_plus(other.y, self.z * other.z);
        self.x.times_plus(other.x, yzs)
    }

    /// At least the length, and 8 % more at most: (√2 − 1) times the smaller two components added to the
    /// largest.
    #[inline(always)]
    pub(in crate::visibility) fn size(self, simd: S) -> F32x16<S> {
        let (x, y, z) = (self.x.abs(), self.y.abs(), self.z.abs());
        let largest = x.max(y).max(z) * F32x16::splat(simd, 0.5857);
        (x + y + z).times_plus(F32x16::splat(simd, 0.4143), largest)
    }

    #[inline(always)]
    pub(in crate::visibility) fn times(self, factor: F32x16<S>) -> Self {
        Self {
            x: self.x * factor,
            y: self.y * factor,
            z: self.z * factor,
        }
    }

    /// The largest values of functions on a projection, or more.
    #[inline(always)]
    pub(in crate::visibility) fn largest(self, [x, y]: [F32x16<S>; 2]) -> F32x16<S> {
        let terms = self.y.abs().times_plus(y, self.z);
        self.x.abs().times_plus(x, terms)
    }

    /// The smallest values of functions on a projection, or less.
    #[inline(always)]
    pub(in crate::visibility) fn smallest(self, [x, y]: [F32x16<S>; 2]) -> F32x16<S> {
        self.z - (self.x.abs() * x + self.y.abs() * y)
    }

    /// The sum of the magnitudes of the terms of functions on a projection, at most.
    #[inline(always)]
    pub(in crate::visibility) fn magnitude(self, [x, y]: [F32x16<S>; 2]) -> F32x16<S> {
        let terms = self.y.abs().times_plus(y, self.z.abs());
        self.x.abs().times_plus(x, terms)
    }
}

/// Triangles side by side, by their first corners and the offsets from there to the two others. An offset in f32
/// keeps the digits that the difference of two corners in f32 would lose.
#[derive(Clone, Debug)]
#[repr(align(64))]
pub(in crate::visibility) struct LeafBlock {
    /// From the middle to the first corners, and from there to the second and to the third ones, over
    /// the size, axis by axis.
    pub(in crate::visibility) first: [Row; 3],
    pub(in crate::visibility) to_second: [Row; 3],
    pub(in crate::visibility) to_third: [Row; 3],
    pub(super) middle: DVec3,
    /// No corner is further from the middle.
    pub(super) size: f64,
    pub(in crate::visibility) over_size: f64,
    /// The number of the first triangle in the order of all: beside the middle, which is read in any case.
    pub(in crate::visibility) number: u32,
    pub(super) turns: Turns,
    /// What fills the last line of memory that a block takes in any case.
    pub(super) objects: Objects,
}

/// Which objects the triangles of a block are of: mostly one.
#[derive(Clone, Debug)]
pub(super) enum Objects {
    One(u32),
    Each(Box<[u32; LANES]>),
}

impl Objects {
    /// Of at most sixteen triangles, at least one.
    pub(super) fn of(objects: impl ExactSizeIterator<Item = u32> + Clone) -> Self {
        let first = objects.clone().next().expect("a block has a triangle");
        if objects.clone().all(|object| object == first) {
            return Self::One(first);
        }
        let mut each = Box::new([first; LANES]);
        for (place, object) in each.iter_mut().zip(objects) {
            *place = object;
        }
        Self::Each(each)
    }

    #[inline(always)]
    pub(super) fn get(&self, place: usize) -> u32 {
        match self {
            Self::One(object) => *object,
            Self::Each(objects) => objects[place],
        }
    }
}

/// Where the corners of sixteen triangles start among those of the world, two bits each.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Turns(u32);

impl Turns {
    /// Of one that was not set yet.
    pub(super) fn set(&mut self, place: usize, turn: Turn) {
        self.0 |= turn.bits() << (2 * place);
    }

    #[inline(always)]
    pub(super) fn get(self, place: usize) -> Turn {
        Turn::of_bits(self.0 >> (2 * place))
    }
}

impl LeafBlock {
    /// Of triangles whose first corners are between their shorter edges: at most sixteen, the first of which
    /// has this number.
    pub(super) fn of(
        triangles: impl ExactSizeIterator<Item = [DVec3; 3]> + Clone,
        number: u32,
        turns: Turns,
        objects: Objects,
    ) -> Self {
        let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for [a, b, c] in triangles.clone() {
            least = least.min(a).min(b).min(c);
            most = most.max(a).max(b).max(c);
        }
        let middle = least * 0.5 + most * 0.5;
        // √3 times the largest component, and room for rounding.
        let reach = (most - middle).max(middle - least).max_element();
        let size = (reach * 1.75).max(f64::MIN_POSITIVE);
        let none = [Row([0.0; LANES]); 3];
        let mut leaf = Self {
            first: none,
            to_second: none,
            to_third: none,
            middle,
            size,
            over_size: 1.0 / size,
            number,
            turns,
            objects,
        };
        for (place, [a, b, c]) in triangles.enumerate() {
            let (first, to_second, to_third) =
                ((a - middle) / size, (b - a) / size, (c - a) / size);
            for axis in 0..3 {
                leaf.first[axis].0[place] = first[axis] as f32;
                leaf.to_second[axis].0[place] = to_second[axis] as f32;
                leaf.to_third[axis].0[place] = to_third[axis] as f32;
            }
        }
        leaf
    }

    /// The corners, which may be off by [`Self::error`] in each coordinate.
    #[inline(always)]
    pub(in crate::visibility) fn corners<S: Simd>(&self, simd: S) -> [DVec3x16<S>; 3] {
        let a = self.widened(simd, &self.first).minus(-self.middle);
        let ab = self.widened(simd, &self.to_second);
        let ac = self.widened(simd, &self.to_third);
        [a, a + ab, a + ac]
    }

    #[inline(always)]
    fn widened<S: Simd>(&self, simd: S, [x, y, z]: &[Row; 3]) -> DVec3x16<S> {
        DVec3x16 {
            x: F32x16::load(simd, &x.0).widened(simd) * self.size,
            y: F32x16::load(simd, &y.0).widened(simd) * self.size,
            z: F32x16::load(simd, &z.0).widened(simd) * self.size,
        }
    }

    /// Reads a number of each line of it, so that it is on its way from memory while another one is drawn:
    /// leaves are far from each other, and each would be waited for.
    #[inline(always)]
    pub(in crate::visibility) fn touch(&self) {
        for offsets in [&self.first, &self.to_second, &self.to_third] {
            let [x, y, z] = offsets;
            black_box((x.0[0], y.0[0], z.0[0]));
        }
        black_box(self.middle.x);
    }

    /// The rounding of offsets to f32, 2⁻²⁴ of at most three sizes, and of sums in f64.
    pub(in crate::visibility) fn error(&self) -> f64 {
        self.size * NEGLIGIBLE * 8.0 + self.middle.abs().max_element() * MIDDLE_ROUNDING
    }
}

/// Where a leaf block is as seen from a projection's origin, in units of its size.
pub(in crate::visibility) struct LeafFrame {
    /// Its middle, in the axes of the projection.
    pub(in crate::visibility) middle: [f32; 3],
    /// How far the coordinates of corners may be off, and a quarter more, over [`F32_ROUNDING`].
    pub(in crate::visibility) drift: [f32; 3],
    /// At least the sum of the magnitudes of a corner's coordinates.
    pub(in crate::visibility) distance: f32,
    /// How far edge functions may be off, over the length of the edge and
    /// [`EDGE_FUNCTION_ERROR`](super::setup::EDGE_FUNCTION_ERROR): those of edges at the first corner, and that
    /// of the edge opposite.
    pub(in crate::visibility) edge_error: [f32; 2],
    /// From the reciprocal of a depth in sizes of the block to that in units of the projection.
    pub(in crate::visibility) reciprocal_depth: f64,
    /// How far the projection's rays may be off, over [`NEGLIGIBLE`].
    pub(in crate::visibility) error: f32,
}

impl LeafFrame {
    /// In the axes of the projection the offsets to the first corners, and from there to the others.
    #[inline(always)]
    pub(in crate::visibility) fn offsets<S: Simd>(
        &self,
        simd: S,
        projection: &BatchProjection,
        leaf: &LeafBlock,
    ) -> [SingleVectors<S>; 3] {
        let [x, y, z] = self.middle;
        let middle = SingleVectors {
            x: F32x16::splat(simd, x),
            y: F32x16::splat(simd, y),
            z: F32x16::splat(simd, z),
        };
        let first = SingleVectors::load(simd, &leaf.first).turned(simd, &projection.orientation);
        [
            middle.plus(first),
            SingleVectors::load(simd, &leaf.to_second).turned(simd, &projection.orientation),
            SingleVectors::load(simd, &leaf.to_third).turned(simd, &projection.orientation),
        ]
    }

    #[inline(always)]
    pub(in crate::visibility) fn new(projection: &BatchProjection, leaf: &LeafBlock) -> Self {
        let to_middle = leaf.middle - projection.origin;
        let over_size = leaf.over_size;
        let middle = all_three(projection.axes, |axis| {
            (axis.dot(to_middle) * over_size) as f32
        });
        let [x, y, z] = all_three(middle, f32::abs);
        let [extent_x, extent_y] = both(projection.extent, |extent| extent as f32);
        // The terms of an edge function, where the coordinates of a point are of these sizes.
        let terms = |x: f32, y: f32, z: f32| (y + z) * extent_x + (z + x) * extent_y + (x + y);
        let (middle_terms, one_terms) = (terms(x, y, z), terms(1.0, 1.0, 1.0));
        let drift = |size: f32| (size * 3.0 + 18.0) * 1.25;
        Self {
            middle,
            drift: [drift(x), drift(y), drift(z)],
            distance: x + y + z + 4.0,
            // 16 (|m| + 1) + 2 |m| + 6 and 22 (|m| + 1) + 3 |m| + 18, over 28.
            edge_error: [
                (middle_terms * 18.0 + one_terms * 22.0) / 28.0,
                (middle_terms * 25.0 + one_terms * 40.0) / 28.0,
            ],
            reciprocal_depth: projection.unit * over_size,
            error: (projection.error * over_size / NEGLIGIBLE) as f32,
        }
    }
}
