//! What some rays have in common on their way down a tree.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};

use super::node::WIDTH;
use super::stack::{Entry, Stack};
use super::wide::{Tree, WideNode};
use crate::math::DVec3;
use crate::simd::{F64x16, Mask64x16, ones};
use crate::visibility::batch::range;
use crate::visibility::rays::{ROUNDING, Rays};

/// By how much planes and depths give way, over the sum of the magnitudes that go into them: rounding a
/// normal, an offset, and the three products and sums to f32, 2⁻²⁴ each, eight in all, and as much again.
const PLANE_ERROR: f64 = 1.0 / (1 << 20) as f64;

/// The largest coordinate of a box in a tree's frame, in which the whole is about 1 across.
pub(super) const REACH: f64 = 2.0;

/// Further from a tree than this, in its own size, no ray tells its boxes apart.
const FARTHEST: f64 = 1e30;

/// A direction n, and how far along it something reaches in a tree's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    pub(super) exact: DVec3,
    normal: [f32; 3],
    /// For each axis 1 if the upper plane of a box is further along n than the lower one.
    upper: [usize; 3],
    pub(super) offset: f32,
}

impl Side {
    /// What is further along `normal` than `offset`, and somewhat more. In lengths of the frame, from the
    /// middle of which rays start `distance` away at most; what is `error` beside them counts as met.
    #[inline(always)]
    pub(super) fn new(normal: DVec3, offset: f64, distance: f64, error: f64) -> Self {
        let size = normal.x.abs() + normal.y.abs() + normal.z.abs();
        let rounding = distance * ROUNDING + error;
        let room = (size * REACH + offset.abs()) * PLANE_ERROR + size * rounding;
        let offset = offset - room;
        // Too far away to tell, and NaN: everything.
        let offset = if offset.abs() < FARTHEST {
            offset as f32
        } else {
            f32::NEG_INFINITY
        };
        Self {
            exact: normal,
            normal: [normal.x as f32, normal.y as f32, normal.z as f32],
            upper: [
                usize::from(normal.x > 0.0),
                usize::from(normal.y > 0.0),
                usize::from(normal.z > 0.0),
            ],
            offset,
        }
    }

    /// How far along n the boxes of a node reach: `end` is 1 for their farthest corners, 0 for the nearest.
    #[inline(always)]
    pub(super) fn reach<S: Simd>(&self, simd: S, node: &WideNode, end: usize) -> f32x8<S> {
        let [x, y, z] = self.normal;
        let [ux, uy, uz] = self.upper;
        let place = |upper: usize| upper ^ (1 - end);
        let along_x = f32x8::from_slice(simd, &node.planes[0][place(ux)]) * x;
        let along_y = f32x8::from_slice(simd, &node.planes[1][place(uy)]) * y;
        let along_z = f32x8::from_slice(simd, &node.planes[2][place(uz)]) * z;
        along_x + along_y + along_z
    }
}

/// A plane that all rays of a beam are beyond: n · (p − center) ≥ `offset` for every point p that a ray may meet.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct BeamPlane {
    /// n, of any length.
    pub(in crate::visibility) normal: DVec3,
    pub(in crate::visibility) offset: f64,
}

impl BeamPlane {
    /// |n_x| + |n_y| + |n_z|, which is at least the length of n.
    #[inline(always)]
    pub(in crate::visibility) fn size(&self) -> f64 {
        self.normal.x.abs() + self.normal.y.abs() + self.normal.z.abs()
    }
}

/// Four planes around some rays, and where they start along their middle.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct Beam {
    pub(super) sides: [Side; 4],
    pub(super) start: Side,
    /// How far along `start` boxes have to reach, to be ahead of where the rays start.
    pub(super) behind: f32,
    /// From the world to the tree's frame.
    pub(super) center: DVec3,
    pub(super) scale: f64,
}

impl Beam {
    /// No rays.
    pub(super) const NONE: Self = {
        let side = Side {
            exact: DVec3::ZERO,
            normal: [0.0; 3],
            upper: [0; 3],
            offset: f32::INFINITY,
        };
        Self {
            sides: [side; 4],
            start: side,
            behind: f32::INFINITY,
            center: DVec3::ZERO,
            scale: 1.0,
        }
    };

    /// Rays from `origin` whose directions are x u + y v + w, or the like of it, with x and y in a
    /// rectangle. What is `error` beside them counts as met: an end that is this far off may be on a sphere.
    #[inline(always)]
    pub(in crate::visibility) fn from_point(
        tree: &Tree,
        origin: DVec3,
        [u, v, w]: [DVec3; 3],
        [left, right, bottom, top]: [f64; 4],
        error: f64,
    ) -> Self {
        let origin = (origin - tree.center) * tree.scale;
        let (distance, error) = (origin.length(), error * tree.scale);
        let side = |normal: DVec3| Side::new(normal, normal.dot(origin), distance, error);
        let start = side(w);
        Self {
            sides: [
                side(u - w * left),
                side(w * right - u),
                side(v - w * bottom),
                side(w * top - v),
            ],
            start,
            behind: start.offset,
            center: tree.center,
            scale: tree.scale,
        }
    }

    /// Rays along w that start `start` beyond `origin` and, along u and v, in a rectangle beside it; none starts
    /// or ends further from there than `distance` along w. What is `error` beside them counts as met.
    #[inline(always)]
    pub(in crate::visibility) fn along(
        tree: &Tree,
        origin: DVec3,
        [u, v, w]: [DVec3; 3],
        [left, right, bottom, top]: [f64; 4],
        [start, distance]: [f64; 2],
        error: f64,
    ) -> Self {
        let origin = origin - tree.center;
        let distance = origin.length() + distance + (right - left) + (top - bottom);
        let (distance, error) = (distance * tree.scale, error * tree.scale);
        let side = |normal: DVec3, offset: f64| {
            let offset = normal.dot(origin) + offset;
            Side::new(normal, offset * tree.scale, distance, error)
        };
        let start = side(w, start);
        Self {
            sides: [
                side(u, left),
                side(-u, -right),
                side(v, bottom),
                side(-v, -top),
            ],
            start,
            behind: start.offset,
            center: tree.center,
            scale: tree.scale,
        }
    }

    /// The same rays, which come from infinitely far away; depths count from where they did.
    #[inline]
    pub(in crate::visibility) fn without_start(self) -> Self {
        Self {
            behind: f32::NEG_INFINITY,
            ..self
        }
    }

    /// Rays that start at one point, and are much the same, or that have one direction, those with a bit
    /// in `asked`; and the largest depth that is gained with t, of those. What is `error` beside them counts
    /// as met.
    #[inline(always)]
    pub(in crate::visibility) fn of<S: Simd>(
        simd: S,
        tree: &Tree,
        rays: &Rays<S>,
        middle: DVec3,
        asked: u32,
        error: f64,
    ) -> (Self, f64) {
        let asked = Mask64x16::from_bits(simd, asked);
        let Some(w) = middle.try_normalize() else {
            return (Self::everything(tree), f64::INFINITY);
        };
        let (u, v) = w.any_orthonormal_pair();
        let depth = rays.direction.dot_with(w);
        let [shallowest, deepest] = range(simd, depth, asked);
        if let Some(origin) = rays.shared_origin {
            if shallowest.is_nan() || shallowest <= 0.0 {
                return (Self::everything(tree), f64::INFINITY);
            }
            let [left, right] = range(simd, rays.direction.dot_with(u) / depth, asked);
            let [bottom, top] = range(simd, rays.direction.dot_with(v) / depth, asked);
            let rectangle = [left, right, bottom, top];
            let beam = Self::from_point(tree, origin, [u, v, w], rectangle, error);
            return (beam, deepest);
        }
        let origin = rays.origin.minus(tree.center);
        let [_, distance] = range(simd, origin.taxicab(), asked);
        let side = |normal: DVec3| {
            let [least, _] = range(simd, origin.dot_with(normal), asked);
            let (distance, error) = (distance * tree.scale, error * tree.scale);
            Side::new(normal, least * tree.scale, distance, error)
        };
        let start = side(w);
        let beam = Self {
            sides: [side(u), side(-u), side(v), side(-v)],
            start,
            behind: start.offset,
            center: tree.center,
            scale: tree.scale,
        };
        (beam, deepest)
    }

    /// How deep rays start along the beam, and how much deeper they are with t, in the tree's frame.
    #[inline(always)]
    pub(super) fn depths<S: Simd>(&self, rays: &Rays<S>) -> [F64x16<S>; 2] {
        let origin = rays.origin.minus(self.center);
        let along = self.start.exact * self.scale;
        [origin.dot_with(along), rays.direction.dot_with(along)]
    }

    /// A depth in the tree's frame, of a ray that starts at another one, or somewhat more: boxes that
    /// [begin](Self::meet) beyond it are deeper.
    #[inline(always)]
    pub(super) fn limit_in_frame(depth: f64, start: f64) -> f32 {
        let rounding = start.abs() * (4.0 * ROUNDING);
        let limit = depth + (REACH + depth.abs()) * (4.0 * PLANE_ERROR) + rounding;
        if limit < FARTHEST {
            limit as f32
        } else {
            f32::INFINITY
        }
    }

    /// Any rays.
    fn everything(tree: &Tree) -> Self {
        let side = Side::new(DVec3::ZERO, f64::NEG_INFINITY, 0.0, 0.0);
        Self {
            sides: [side; 4],
            start: side,
            behind: side.offset,
            center: tree.center,
            scale: tree.scale,
        }
    }

    /// A depth of the world in the tree's frame, at least, from where [`Self::meet`] counts.
    #[inline(always)]
    fn limit(&self, depth: f64) -> f32 {
        let depth = depth * self.scale;
        let start = f64::from(self.start.offset);
        let limit = start + depth + (REACH + depth + start.abs()) * (4.0 * PLANE_ERROR);
        if limit < FARTHEST {
            limit as f32
        } else {
            f32::INFINITY
        }
    }

    /// One bit for each child of a node whose box a ray might meet up to `limit`, and how deep the box
    /// begins.
    #[inline(always)]
    pub(super) fn meet<S: Simd>(
        &self,
        simd: S,
        node: &WideNode,
        limit: f32,
    ) -> (u32, [f32; WIDTH]) {
        let [left, right, bottom, top] = &self.sides;
        let begins = self.start.reach(simd, node, 0);
        let meets = left.reach(simd, node, 1).simd_ge(left.offset)
            & right.reach(simd, node, 1).simd_ge(right.offset)
            & bottom.reach(simd, node, 1).simd_ge(bottom.offset)
            & top.reach(simd, node, 1).simd_ge(top.offset)
            & self.start.reach(simd, node, 1).simd_ge(self.behind)
            & begins.simd_le(limit);
        let bits = meets.to_bitmask() as u32 & node.present;
        let mut at = [0.0; WIDTH];
        begins.store_slice(&mut at);
        (bits, at)
    }

    /// Goes down a tree to the leaves that a ray might meet, near ones first, and no deeper than `depth` of
    /// the world. `show` is given a leaf's first block, how many shapes it has, and the first block of
    /// the leaf that is likely to be next, and says how deep to go from then on, if at all.
    #[inline(always)]
    pub(in crate::visibility) fn descend<S: Simd>(
        &self,
        simd: S,
        tree: &Tree,
        depth: f64,
        stack: &mut Stack,
        mut show: impl FnMut(u32, u32, Option<u32>) -> Option<f64>,
    ) {
        let mut limit = self.limit(depth);
        let mut height = self.open(simd, &tree.nodes[0], limit, stack, 0);
        while height > 0 {
            height -= 1;
            let Entry { child, count, at } = stack[height];
            if at > limit {
                continue;
            }
            if count == 0 {
                let node = &tree.nodes[child as usize];
                height = self.open(simd, node, limit, stack, height);
                continue;
            }
            let next = stack[..height].last();
            let next = next.filter(|next| next.count > 0).map(|next| next.child);
            let Some(depth) = show(child, count, next) else {
                return;
            };
            limit = self.limit(depth);
        }
    }

    /// The planes around the rays, in lengths of the world.
    #[inline(always)]
    pub(in crate::visibility) fn planes(&self) -> [BeamPlane; 4] {
        let [left, right, bottom, top] = &self.sides;
        [
            self.plane(left),
            self.plane(right),
            self.plane(bottom),
            self.plane(top),
        ]
    }

    #[inline(always)]
    fn plane(&self, side: &Side) -> BeamPlane {
        BeamPlane {
            normal: side.exact,
            offset: f64::from(side.offset) / self.scale,
        }
    }

    /// The point from which the planes' offsets count.
    #[inline(always)]
    pub(in crate::visibility) fn center(&self) -> DVec3 {
        self.center
    }

    /// Puts the children of a node that the beam meets on the stack, the nearest on top; its new height.
    #[inline(always)]
    fn open<S: Simd>(
        &self,
        simd: S,
        node: &WideNode,
        limit: f32,
        stack: &mut Stack,
        bottom: usize,
    ) -> usize {
        let (bits, at) = self.meet(simd, node, limit);
        let mut height = bottom;
        for child in ones(bits) {
            let entry = Entry {
                child: node.children[child],
                count: node.counts[child],
                at: at[child],
            };
            let mut place = height;
            while place > bottom && stack[place - 1].at < entry.at {
                stack[place] = stack[place - 1];
                place -= 1;
            }
            stack[place] = entry;
            height += 1;
        }
        height
    }
}
