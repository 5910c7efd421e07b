//! A convex volume on its way down a tree: the boxes that reach into all of its half-spaces.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};

use super::beam::Side;
use super::stack::{Entry, Stack};
use super::wide::{Tree, WideNode};
use super::{Bounds, node::WIDTH};
use crate::math::DVec3;
use crate::simd::ones;

/// How far a plane is off in the frame of a tree, over the largest coordinate of its middle: three products and
/// their sum, and the difference from the plane's own offset, are rounded by ε/2 each, of numbers up to three times
/// that; and as much again for room.
const FRAME_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Half-spaces of a volume, at most.
pub(in crate::visibility) const MOST_SIDES: usize = 12;

/// All x with n·x at least `offset`, in the world.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::visibility) struct HalfSpace {
    pub(in crate::visibility) normal: DVec3,
    pub(in crate::visibility) offset: f64,
}

/// Half-spaces before the boxes of a tree, and along which direction the near boxes are.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct TreeVolume {
    sides: [Side; MOST_SIDES],
    count: usize,
    along: Side,
    center: DVec3,
    scale: f64,
}

impl TreeVolume {
    /// What is within `error` of the half-spaces counts as in them; boxes are nearer the less they reach along
    /// `along`.
    pub(in crate::visibility) fn new(
        tree: &Tree,
        half_spaces: &[HalfSpace],
        along: DVec3,
        error: f64,
    ) -> Self {
        // The middle of the frame takes digits as well.
        let error = error + tree.center.abs().max_element() * FRAME_ROUNDING;
        let side = |HalfSpace { normal, offset }: HalfSpace| {
            let in_frame = (offset - normal.dot(tree.center)) * tree.scale;
            Side::new(normal, in_frame, 0.0, error * tree.scale)
        };
        let along = HalfSpace {
            normal: along,
            offset: along.dot(tree.center),
        };
        let along = side(along);
        let mut sides = [along; MOST_SIDES];
        for (to, &from) in sides.iter_mut().zip(half_spaces) {
            *to = side(from);
        }
        Self {
            sides,
            count: half_spaces.len().min(MOST_SIDES),
            along,
            center: tree.center,
            scale: tree.scale,
        }
    }

    /// A depth of the world in the tree's frame, or somewhat more: what boxes beyond it are dropped by.
    fn limit(&self, depth: f64) -> f32 {
        let offset = (depth - self.along.exact.dot(self.center)) * self.scale;
        // `along` gives way to the near side by what boxes' reaches may be off.
        let limit = offset - 2.0 * f64::from(self.along.offset);
        if limit.abs() < f64::from(f32::MAX) {
            limit as f32
        } else {
            f32::INFINITY
        }
    }

    /// One bit for each child of a node whose box may reach into the volume up to `limit`, and how deep it begins.
    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, node: &WideNode, limit: f32) -> (u32, [f32; WIDTH]) {
        let begins = self.along.reach(simd, node, 0);
        let mut meets = begins.simd_le(f32x8::splat(simd, limit));
        for side in &self.sides[..self.count] {
            meets &= side.reach(simd, node, 1).simd_ge(side.offset);
        }
        let mut at = [0.0; WIDTH];
        begins.store_slice(&mut at);
        (meets.to_bitmask() as u32 & node.present, at)
    }

    /// Goes down a tree to the leaves that reach into the volume up to a depth, near ones first. `show` is given a
    /// leaf's first block and how many shapes it has, and says how deep to go from then on, if at all.
    #[inline(always)]
    pub(in crate::visibility) fn descend<S: Simd>(
        &self,
        simd: S,
        tree: &Tree,
        depth: f64,
        stack: &mut Stack,
        mut show: impl FnMut(u32, u32) -> Option<f64>,
    ) {
        let mut limit = self.limit(depth);
        stack[0] = Entry {
            child: 0,
            count: 0,
            at: f32::NEG_INFINITY,
        };
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let Entry { child, count, at } = stack[height];
            if at > limit {
                continue;
            }
            if count > 0 {
                let Some(depth) = show(child, count) else {
                    return;
                };
                limit = self.limit(depth);
                continue;
            }
            let node = &tree.nodes[child as usize];
            let (bits, at) = self.meet(simd, node, limit);
            let bottom = height;
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
        }
    }
}

impl Bounds {
    /// Its eight corners.
    pub(in crate::visibility) fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|corner| {
            let pick = |axis: usize| {
                if corner >> axis & 1 == 0 {
                    self.min[axis]
                } else {
                    self.max[axis]
                }
            };
            DVec3::new(pick(0), pick(1), pick(2))
        })
    }
}
