//! One ray on its way down a tree: each of a node's eight boxes by its slabs.
//!
//! The ray is moved to where it enters the tree's cube, in f64, so that f32 places it well however far away it
//! starts. From there r(t) = o + t d, with the largest component of d 1 and the boxes within a few of the
//! middle. A box is met where the largest t at which it enters a slab is not above the least at which
//! it leaves one. The slabs give way by a length that is more than all rounding (`Self::room`), so that each
//! slab's t is on the safe side by itself, whatever the axis.

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x8};

use super::node::WIDTH;
use super::stack::{EMPTY_STACK, Entry, Stack};
use super::wide::{Tree, WideNode};
use crate::math::DVec3;
use crate::simd::ones;
use crate::visibility::rays::ROUNDING;

/// By how much a slab gives way, over the largest coordinate of the cube: one rounding to f32, 2⁻²⁴, each for
/// 1/d times the plane, for o/d, their product and their sum, which is at most three times the cube; and three
/// times that for room.
const GIVES_WAY: f64 = 1.0 / (1 << 20) as f64;

/// A component of d is at least this: 1/d is finite, and over the cube the ray is off by nothing in f32.
const FLATTEST: f64 = 1e-20;

/// Rays that f64 places worse than this part of the cube are not for slabs.
const FARTHEST: f64 = 0.25;

/// A ray before the boxes of a tree.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct TreeRay {
    /// 1/d
    inverse: [f32; 3],
    /// −o/d, less and more what slabs give way.
    near: [f32; 3],
    far: [f32; 3],
    /// For each axis 1 if a ray enters the slab through its upper plane.
    upper: [usize; 3],
    /// Where it enters the cube, and t of the frame over t of the world.
    begin: f64,
    pace: f64,
    /// By how much a t of the frame may be off.
    room: f64,
}

/// How a ray comes to a tree.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) enum Approach {
    /// It passes by all boxes.
    Beside,
    /// It may meet some.
    Towards(TreeRay),
    /// It is too far away, or not finite.
    Untold,
}

impl TreeRay {
    pub(super) const NONE: Self = Self {
        inverse: [0.0; 3],
        near: [0.0; 3],
        far: [0.0; 3],
        upper: [0; 3],
        begin: 0.0,
        pace: 0.0,
        room: 0.0,
    };

    /// A ray from `origin` as a tree's boxes are met by it; what is `error` beside it counts as met.
    #[inline(always)]
    pub(in crate::visibility) fn approach(
        tree: &Tree,
        origin: DVec3,
        direction: DVec3,
        error: f64,
    ) -> Approach {
        let origin = (origin - tree.center) * tree.scale;
        let direction = direction * tree.scale;
        let pace = direction.abs().max_element();
        let over_pace = 1.0 / pace;
        let size = tree.reach * (1.0 + GIVES_WAY);
        let rounding = (origin.abs().element_sum() + size) * (4.0 * ROUNDING);
        let room = size * GIVES_WAY + rounding + error * tree.scale;
        // NaN as well.
        if !(room < size * FARTHEST && over_pace > 0.0 && over_pace < f64::INFINITY) {
            return Approach::Untold;
        }
        let cube = size + room;
        let (mut begin, mut end) = (0.0, f64::INFINITY);
        let mut unit = [0.0; 3];
        let mut over = [0.0; 3];
        let mut upper = [0; 3];
        for axis in 0..3 {
            let d = direction[axis] * over_pace;
            let size = if d.abs() > FLATTEST {
                d.abs()
            } else {
                FLATTEST
            };
            let is_down = d < 0.0;
            unit[axis] = if is_down { -size } else { size };
            upper[axis] = usize::from(is_down);
            over[axis] = 1.0 / unit[axis];
            let side = if is_down { cube } else { -cube };
            begin = f64::max(begin, (side - origin[axis]) * over[axis]);
            end = f64::min(end, (-side - origin[axis]) * over[axis]);
        }
        if begin > end {
            return Approach::Beside;
        }
        let mut ray = Self {
            inverse: [0.0; 3],
            near: [0.0; 3],
            far: [0.0; 3],
            upper,
            begin,
            pace,
            room,
        };
        for axis in 0..3 {
            let at = origin[axis] + unit[axis] * begin;
            let room = room * over[axis].abs();
            ray.inverse[axis] = over[axis] as f32;
            ray.near[axis] = (-at * over[axis] - room) as f32;
            ray.far[axis] = (-at * over[axis] + room) as f32;
        }
        Approach::Towards(ray)
    }

    /// A t of the world in the frame, or somewhat more.
    #[inline(always)]
    pub(in crate::visibility) fn limit(&self, t: f64) -> f32 {
        let t = t * self.pace;
        let limit = t - self.begin + (self.room + t.abs() * ROUNDING);
        // Rounded up: 2⁻²³ is more than one place of an f32.
        (limit + limit.abs() * f64::from(f32::EPSILON)) as f32
    }

    /// Across an axis 1/d, and −o/d less and more what slabs give way.
    #[inline(always)]
    pub(super) fn slab_of(&self, axis: usize) -> [f32; 3] {
        [self.inverse[axis], self.near[axis], self.far[axis]]
    }

    /// Where the ray enters the slabs of a node's boxes across an axis, and where it leaves them.
    #[inline(always)]
    fn slab<S: Simd>(&self, simd: S, node: &WideNode, axis: usize) -> (f32x8<S>, f32x8<S>) {
        let upper = self.upper[axis];
        let inverse = f32x8::splat(simd, self.inverse[axis]);
        let first = f32x8::from_slice(simd, &node.planes[axis][upper]);
        let second = f32x8::from_slice(simd, &node.planes[axis][1 - upper]);
        (
            first.mul_add(inverse, f32x8::splat(simd, self.near[axis])),
            second.mul_add(inverse, f32x8::splat(simd, self.far[axis])),
        )
    }

    /// One bit for each child of a node whose box the ray may meet up to `limit`, and where it enters.
    #[inline(always)]
    fn meet<S: Simd>(&self, simd: S, node: &WideNode, limit: f32) -> (u32, [f32; WIDTH]) {
        let (near_x, far_x) = self.slab(simd, node, 0);
        let (near_y, far_y) = self.slab(simd, node, 1);
        let (near_z, far_z) = self.slab(simd, node, 2);
        let near = near_x.max(near_y).max(near_z.max(f32x8::splat(simd, 0.0)));
        let far = far_x.min(far_y).min(far_z.min(f32x8::splat(simd, limit)));
        let mut at = [0.0; WIDTH];
        near.store_slice(&mut at);
        (near.simd_le(far).to_bitmask() as u32, at)
    }
}

/// A ray on its way: one step at a time, so that several can take turns and none waits for memory.
#[derive(Debug)]
pub(in crate::visibility) struct Descent {
    ray: TreeRay,
    stack: Box<Stack>,
    height: usize,
    limit: f32,
}

/// Rays that go alone, and are on their way at once.
pub(in crate::visibility) const DESCENTS: usize = 8;

/// What a step comes to.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) enum Step {
    /// A node was opened.
    Opened,
    /// A leaf is to be looked at: its first block, and how many shapes it has.
    Leaf { block: u32, count: u32 },
    /// There is nothing left.
    Done,
}

impl Default for Descent {
    fn default() -> Self {
        Self {
            ray: TreeRay::NONE,
            stack: Box::new(EMPTY_STACK),
            height: 0,
            limit: 0.0,
        }
    }
}

impl Descent {
    /// Sets out from the root, up to t of `limit`.
    #[inline(always)]
    pub(in crate::visibility) fn begin(&mut self, ray: TreeRay, limit: f64) {
        self.ray = ray;
        self.limit = ray.limit(limit);
        self.stack[0] = Entry {
            child: 0,
            count: 0,
            at: 0.0,
        };
        self.height = 1;
    }

    /// Goes up to t of `limit` from now on.
    #[inline(always)]
    pub(in crate::visibility) fn go_up_to(&mut self, limit: f64) {
        self.limit = self.ray.limit(limit);
    }

    /// Opens the next node that the ray may meet, near ones first if it is `SORTED`.
    #[inline(always)]
    pub(in crate::visibility) fn step<S: Simd, const SORTED: bool>(
        &mut self,
        simd: S,
        tree: &Tree,
    ) -> Step {
        let stack = &mut *self.stack;
        let mut height = self.height;
        let Entry { child, count, .. } = loop {
            if height == 0 {
                self.height = 0;
                return Step::Done;
            }
            height -= 1;
            if stack[height].at <= self.limit {
                break stack[height];
            }
        };
        if count > 0 {
            self.height = height;
            return Step::Leaf {
                block: child,
                count,
            };
        }
        let node = &tree.nodes[child as usize];
        let (bits, at) = self.ray.meet(simd, node, self.limit);
        let bottom = height;
        for child in ones(bits) {
            let entry = Entry {
                child: node.children[child],
                count: node.counts[child],
                at: at[child],
            };
            let mut place = height;
            if SORTED {
                while place > bottom && stack[place - 1].at < entry.at {
                    stack[place] = stack[place - 1];
                    place -= 1;
                }
            }
            stack[place] = entry;
            height += 1;
        }
        self.height = height;
        Step::Opened
    }

    /// What is likely to be next: a node is touched, so that it is on its way from memory; of a leaf its first
    /// block is given.
    #[inline(always)]
    pub(in crate::visibility) fn look_ahead(&self, tree: &Tree) -> Option<u32> {
        let next = self.stack.get(self.height.wrapping_sub(1))?;
        if next.count > 0 {
            return Some(next.child);
        }
        tree.nodes[next.child as usize].touch();
        None
    }
}
