//! How a batch of rays goes down a tree.
//!
//! A batch descends together. First its [`Bundle`](super::bundle::Bundle) tells which parts of the
//! tree any of its rays could meet. From there on each node is visited once, with the list of the
//! quads of rays that meet it: a quad's four slab tests are one, and no ray has a stack or branches
//! of its own.
//!
//! The slab test gives way by more than the rounding of its own ray, so that no box is missed that
//! a ray meets.

use std::ops::Range;

use glam::{BVec4A, DVec3, Vec4};

use super::bvh::{BOX_GIVES_WAY, Bvh, Child, Member, Node, WIDTH};
use crate::math::Ray;

/// Rays side by side in one register.
const QUAD: usize = 4;

/// Rays of a batch at most.
pub(super) const LARGEST_BATCH: usize = 256 * QUAD;

/// How much the far side of a slab test gives way. A parameter is rounded four times (the
/// direction to f32, its inverse, the difference, the product), each by at most u = 2⁻²⁴, so two of
/// them differ by less than 2 · 4u (after Ize 2013, "Robust BVH Ray Traversal"); here half as much
/// again.
const SLAB_GIVES_WAY: f32 = 1.0 + 12.0 * (f32::EPSILON / 2.0);

/// The smallest component of a direction about 1 long that is divided by. Below it, a ray changes
/// no coordinate by more than a box gives way, and a larger quotient would not be finite.
const SMALLEST_COMPONENT: f32 = 1e-18;

/// Farther from a tree than this, in its own size, no ray tells its boxes apart.
const FARTHEST: DVec3 = DVec3::splat(1e30);

/// The rays of a batch in the tree's frame, four by four, arranged for slab tests.
#[derive(Debug)]
pub(super) struct Batch {
    quads: Vec<QuadRays>,
    /// How much boxes give way to the rounding of these rays.
    margin: f32,
    /// For each ray, its parameter in the tree's frame over that in the world.
    stretch: Vec<f64>,
}

/// Four rays.
#[derive(Clone, Copy, Debug)]
struct QuadRays {
    origin: [Vec4; 3],
    inverse: [Vec4; 3],
    /// The largest t of each ray that is of interest; below 0 none is.
    limit: Vec4,
}

/// Which rays of a quad meet a box.
#[derive(Clone, Copy, Debug, Default)]
struct Quad {
    index: u8,
    /// One bit for each ray.
    mask: u8,
}

/// A box that some rays of the batch meet.
#[derive(Clone, Copy, Debug)]
struct Met {
    child: Child,
    /// The smallest t at which one of them enters it.
    enters: f32,
    /// Where the list of its quads is.
    quads: (usize, usize),
}

/// A batch on its way down a tree.
struct Descent<'t, F> {
    nodes: &'t [Node],
    batch: &'t mut Batch,
    /// The lists of all boxes that are open, behind each other.
    lists: Vec<Quad>,
    leaf: F,
}

impl Bvh {
    /// Arranges at most [`LARGEST_BATCH`] rays, each of interest for t from 0 to its limit.
    pub(super) fn batch(&self, rays: &[Ray], limits: &[f64]) -> Batch {
        assert!(
            rays.len() <= LARGEST_BATCH,
            "a batch is small enough for its quads to be numbered in a u8"
        );
        let mut reach = 0.0_f64;
        let mut stretch = Vec::with_capacity(rays.len());
        let mut quads = Vec::with_capacity(rays.len().div_ceil(QUAD));
        for (rays, limits) in rays.chunks(QUAD).zip(limits.chunks(QUAD)) {
            // The last quad may have fewer rays; the others of it never meet anything.
            let mut origins = [[0.0; QUAD]; 3];
            let mut inverses = [[1.0; QUAD]; 3];
            let mut nearest = [-1.0; QUAD];
            for (lane, (ray, &limit)) in rays.iter().zip(limits).enumerate() {
                let origin = self.to_frame(ray.origin.0);
                reach = reach.max(origin.abs().max_element());
                let origin = origin.clamp(-FARTHEST, FARTHEST).as_vec3().to_array();
                // Directions about 1 long, whatever their length in the world.
                let direction = ray.direction * self.scale();
                let length = power_of_two_below(direction.abs().max_element());
                let direction = (direction * (1.0 / length)).as_vec3().to_array();
                for axis in 0..3 {
                    origins[axis][lane] = origin[axis];
                    inverses[axis][lane] = inverse(direction[axis]);
                }
                nearest[lane] = not_below(limit * length);
                stretch.push(length);
            }
            quads.push(QuadRays {
                origin: origins.map(Vec4::from_array),
                inverse: inverses.map(Vec4::from_array),
                limit: Vec4::from_array(nearest),
            });
        }
        let margin = if reach < FARTHEST.x {
            (reach as f32 + 1.0) * BOX_GIVES_WAY
        } else {
            // Too far away to tell anything apart: every box may be met.
            f32::MAX / 4.0
        };
        Batch {
            quads,
            margin,
            stretch,
        }
    }

    /// Shows `leaf` the shapes below `roots` that each ray of a batch may meet up to its limit,
    /// roughly near to far: a range of shapes, and the ray's index. `leaf` gives back the ray's new
    /// limit, below 0 if the ray is done.
    pub(super) fn descend(
        &self,
        roots: &[Member],
        batch: &mut Batch,
        leaf: impl FnMut(Range<usize>, usize) -> f64,
    ) {
        let all = (0..batch.quads.len()).map(|index| Quad {
            index: index as u8,
            mask: 0b1111,
        });
        let mut descent = Descent {
            nodes: self.nodes(),
            lists: all.collect(),
            batch,
            leaf,
        };
        let everyone = (0, descent.lists.len());
        for members in roots.chunks(WIDTH) {
            descent.open(members, everyone);
        }
    }
}

impl QuadRays {
    /// Where each ray enters the box, and which rays do so up to their limit.
    #[inline(always)]
    fn meet(&self, lower: [Vec4; 3], upper: [Vec4; 3]) -> (Vec4, BVec4A) {
        let slab = |axis: usize| {
            let to_lower = (lower[axis] - self.origin[axis]) * self.inverse[axis];
            let to_upper = (upper[axis] - self.origin[axis]) * self.inverse[axis];
            (to_lower.min(to_upper), to_lower.max(to_upper))
        };
        let [x, y, z] = [slab(0), slab(1), slab(2)];
        let enters = x.0.max(y.0).max(z.0.max(Vec4::ZERO));
        let leaves = x.1.min(y.1).min(z.1) * SLAB_GIVES_WAY;
        (enters, enters.cmple(leaves.min(self.limit)))
    }
}

impl<F: FnMut(Range<usize>, usize) -> f64> Descent<'_, F> {
    /// Visits the boxes among `members` that rays of the list at `quads` meet, the nearest first.
    fn open(&mut self, members: &[Member], quads: (usize, usize)) {
        let bottom = self.lists.len();
        let mut met: [Option<Met>; WIDTH] = [None; WIDTH];
        let mut count: usize = 0;
        for member in members {
            if let Some(found) = self.meet(member, quads) {
                // Keeps the nearest first.
                let mut place = count;
                while let Some(before) = place.checked_sub(1)
                    && met[before].is_some_and(|other| other.enters > found.enters)
                {
                    met[place] = met[before];
                    place = before;
                }
                met[place] = Some(found);
                count += 1;
            }
        }
        for Met {
            child,
            enters,
            quads,
        } in met.into_iter().flatten()
        {
            match child {
                Child::Node(index) => {
                    if self.is_of_interest(enters, quads) {
                        let nodes = self.nodes;
                        self.open(nodes[index as usize].members(), quads);
                    }
                }
                Child::Leaf { first, count } => {
                    let shapes = first as usize..first as usize + count as usize;
                    self.show(&shapes, quads);
                }
            }
        }
        self.lists.truncate(bottom);
    }

    /// Makes the list of those quads of a list that meet a box.
    #[inline(always)]
    fn meet(&mut self, member: &Member, (start, end): (usize, usize)) -> Option<Met> {
        let lower = (member.min - self.batch.margin).to_array().map(Vec4::splat);
        let upper = (member.max + self.batch.margin).to_array().map(Vec4::splat);
        let bottom = self.lists.len();
        self.lists.resize(bottom + end - start, Quad::default());
        let (before, found) = self.lists.split_at_mut(bottom);
        let mut nearest = Vec4::INFINITY;
        let mut count = 0;
        for quad in &before[start..end] {
            let (enters, meets) = self.batch.quads[usize::from(quad.index)].meet(lower, upper);
            let mask = meets.bitmask() as u8 & quad.mask;
            // Written in any case and kept only if it counts: no branch to guess wrong.
            found[count] = Quad {
                index: quad.index,
                mask,
            };
            count += usize::from(mask != 0);
            nearest = nearest.min(Vec4::select(meets, enters, Vec4::INFINITY));
        }
        self.lists.truncate(bottom + count);
        (count > 0).then(|| Met {
            child: member.child,
            enters: nearest.min_element(),
            quads: (bottom, bottom + count),
        })
    }

    /// Whether any ray of a list may still meet something that begins at `enters`; its limit may
    /// have come nearer since the list was made.
    fn is_of_interest(&self, enters: f32, (start, end): (usize, usize)) -> bool {
        let limits = self.lists[start..end].iter();
        let limits = limits.map(|quad| self.batch.quads[usize::from(quad.index)].limit);
        limits.fold(Vec4::NEG_ONE, Vec4::max).max_element() >= enters
    }

    /// Shows shapes to the rays of a list.
    fn show(&mut self, shapes: &Range<usize>, (start, end): (usize, usize)) {
        for place in start..end {
            let Quad { index, mask } = self.lists[place];
            let index = usize::from(index);
            let mut mask = mask;
            while mask != 0 {
                let lane = mask.trailing_zeros() as usize;
                mask &= mask - 1;
                if self.batch.quads[index].limit[lane] >= 0.0 {
                    let ray = index * QUAD + lane;
                    let limit = (self.leaf)(shapes.clone(), ray) * self.batch.stretch[ray];
                    self.batch.quads[index].limit[lane] = not_below(limit);
                }
            }
        }
    }
}

/// One over a component of a direction in the tree's frame, finite.
fn inverse(component: f32) -> f32 {
    let divisor = if component.abs() < SMALLEST_COMPONENT {
        SMALLEST_COMPONENT.copysign(component)
    } else {
        component
    };
    1.0 / divisor
}

/// The largest power of two that is not above a length, to be divided by; 1 for a length of 0.
fn power_of_two_below(length: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff << 52;
    let power = f64::from_bits(length.to_bits() & EXPONENT);
    if power > 0.0 { power } else { 1.0 }
}

/// A parameter in f32 that is not below it, with room for the rounding of a slab test.
fn not_below(t: f64) -> f32 {
    t as f32 * SLAB_GIVES_WAY
}
