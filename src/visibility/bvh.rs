//! A bounding volume hierarchy with eight children a node, built by obvhs, and how a batch of rays
//! goes down it.
//!
//! Boxes are f32 in a frame of the tree's own, in which the whole is about 1 across: they work
//! the same at any scale and anywhere. They are conservative. Boxes are rounded outwards when
//! they are made, and the slab test gives way by more than the rounding of its own ray, so that
//! no shape is missed that the f64 intersection would hit.
//!
//! A batch descends together. First [`Bundle`] tells which parts of the tree any of its rays could
//! meet. From there on each node is visited once, with the list of the quads of rays that meet it:
//! a quad's four slab tests are one, and no ray has a stack or branches of its own.

use std::collections::VecDeque;
use std::ops::Range;

use glam::{BVec4A, DVec3, Vec3, Vec4};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

use super::bundle::Bundle;
use super::search::Bounded;
use crate::math::Ray;

/// Children of a node.
const WIDTH: usize = 8;

/// Rays side by side in one register.
const QUAD: usize = 4;

/// Rays of a batch at most.
pub(super) const BATCH: usize = 256 * QUAD;

/// Boxes that a batch of rays starts with, about: more are found with fewer steps down from each,
/// but every ray has to look at all.
const CUT_SIZE: usize = 16;

/// Shapes in a leaf at most. Their own boxes sort them better than a common one.
const LEAF_SIZE: u32 = 1;

/// How much the far side of a slab test gives way: the relative rounding of both sides is below
/// 2γ₃ with γ₃ = 3u/(1 − 3u), u = 2⁻²⁴ (Ize 2013, "Robust BVH Ray Traversal"); here twice that.
const SLAB_GIVES_WAY: f32 = 1.0 + 12.0 * (f32::EPSILON / 2.0);

/// How much a box gives way, per unit of distance of the ray's origin (in the tree's frame, and
/// at least 1): rounding the origin to f32 moves it by 2⁻²⁴, and rounding boxes and origin in f64
/// by far less. Four times that.
const BOX_GIVES_WAY: f32 = 4.0 * (f32::EPSILON / 2.0);

/// The smallest component of a direction (in the tree's frame) that is divided by. Below it, a
/// ray changes no coordinate by more than a box gives way, and a larger quotient would not be
/// finite.
const SMALLEST_COMPONENT: f32 = 1e-18;

/// A box in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub(super) min: DVec3,
    pub(super) max: DVec3,
}

impl Bounds {
    /// The smallest box around points; `None` where there are none.
    pub(super) fn around(points: impl Iterator<Item = DVec3>) -> Option<Self> {
        points
            .map(|point| Self {
                min: point,
                max: point,
            })
            .reduce(Self::union)
    }

    fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// The largest coordinate, by magnitude.
    pub(super) fn reach(&self) -> f64 {
        self.min.abs().max(self.max.abs()).max_element()
    }

    /// The box with `margin` added on every side.
    pub(super) fn grown(self, margin: f64) -> Self {
        Self {
            min: self.min - margin,
            max: self.max + margin,
        }
    }
}

/// The tree.
#[derive(Debug)]
pub(super) struct Bvh {
    nodes: Vec<Node>,
    /// Middle of the tree's frame in world space.
    center: DVec3,
    /// From world space to the tree's frame: a power of two.
    scale: f64,
}

/// Up to eight boxes and what is in them.
#[derive(Clone, Debug)]
struct Node {
    /// The first `len` are there.
    members: [Member; WIDTH],
    len: u8,
}

/// A box and what is in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Member {
    min: Vec3,
    max: Vec3,
    child: Child,
}

/// What is in a box.
#[derive(Clone, Copy, Debug)]
enum Child {
    /// A node.
    Node(u32),
    /// Shapes.
    Leaf { first: u32, count: u8 },
}

/// The rays of a batch in the tree's frame, four by four, arranged for slab tests.
#[derive(Debug)]
pub(super) struct Batch {
    quads: Vec<QuadRays>,
    /// How much boxes give way to the rounding of these rays.
    margin: f32,
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
    /// A tree over shapes, and the order in which its leaves have them.
    pub(super) fn new<S: Bounded>(shapes: &[S]) -> (Self, Vec<u32>) {
        let whole = shapes.iter().map(Bounded::bounds).reduce(Bounds::union);
        let whole = whole.expect("a tree is planned only for shapes");
        let center = (whole.min + whole.max) * 0.5;
        let size = (whole.max - whole.min).max_element();
        let mut tree = Self {
            nodes: Vec::new(),
            center,
            scale: libm::exp2(-f64::from(libm::ilogb(size))),
        };
        let boxes: Vec<Aabb> = shapes
            .iter()
            .map(|shape| {
                let bounds = shape.bounds();
                Aabb {
                    min: rounded_down(tree.to_frame(bounds.min)).into(),
                    max: rounded_up(tree.to_frame(bounds.max)).into(),
                }
            })
            .collect();
        let parameters = BvhBuildParams {
            max_prims_per_leaf: LEAF_SIZE,
            ..BvhBuildParams::medium_build()
        };
        let binary = build_bvh2(&boxes, parameters, &mut std::time::Duration::default());
        tree.widen(&binary);
        (tree, binary.primitive_indices)
    }

    fn to_frame(&self, position: DVec3) -> DVec3 {
        (position - self.center) * self.scale
    }

    /// Makes nodes of eight from a binary tree, each by opening the largest box while there is
    /// room.
    fn widen(&mut self, binary: &Bvh2) {
        // Binary nodes whose wide node is reserved but not filled in yet.
        let mut open = vec![(0_usize, 0_usize)];
        self.nodes.push(Node::EMPTY);
        while let Some((binary_index, wide_index)) = open.pop() {
            let root = &binary.nodes[binary_index];
            let mut members = Vec::with_capacity(WIDTH);
            if root.is_leaf() {
                members.push(binary_index);
            } else {
                members.extend([root.first_index as usize, root.first_index as usize + 1]);
            }
            while members.len() < WIDTH {
                let inner = members
                    .iter()
                    .enumerate()
                    .filter(|&(_, &m)| !binary.nodes[m].is_leaf());
                let largest = inner.max_by(|&(_, &a), &(_, &b)| {
                    let area = |member: usize| binary.nodes[member].aabb().half_area();
                    area(a).total_cmp(&area(b))
                });
                let Some((place, &member)) = largest else {
                    break;
                };
                let first = binary.nodes[member].first_index as usize;
                members[place] = first;
                members.push(first + 1);
            }
            for &member in &members {
                let node = &binary.nodes[member];
                let child = if node.is_leaf() {
                    Child::Leaf {
                        first: node.first_index,
                        count: node.prim_count as u8,
                    }
                } else {
                    open.push((member, self.nodes.len()));
                    self.nodes.push(Node::EMPTY);
                    Child::Node(self.nodes.len() as u32 - 1)
                };
                self.nodes[wide_index].push(Member::new(node.aabb(), child));
            }
        }
    }

    /// What of the tree a whole batch of rays has to look at: about [`CUT_SIZE`] boxes that together
    /// hold every shape that a ray of the bundle could meet, roughly near to far.
    pub(super) fn cut(&self, bundle: &Bundle) -> Vec<Member> {
        let bundle = bundle.in_frame(self.center, self.scale);
        let margin = (bundle.reach() + 1.0) * f64::from(BOX_GIVES_WAY);
        let may_meet = |member: &Member| bundle.may_meet(&member.bounds().grown(margin));
        let mut pieces = Vec::with_capacity(CUT_SIZE + WIDTH);
        let mut queue: VecDeque<Member> = self.nodes[0].members().iter().copied().collect();
        queue.retain(may_meet);
        while let Some(member) = queue.pop_front() {
            match member.child {
                Child::Node(index) if pieces.len() + queue.len() < CUT_SIZE => {
                    let members = self.nodes[index as usize].members().iter().copied();
                    queue.extend(members.filter(may_meet));
                }
                Child::Node(_) | Child::Leaf { .. } => pieces.push(member),
            }
        }
        let distance = |member: &Member| bundle.distance_along(&member.bounds());
        pieces.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        pieces
    }

    /// Arranges at most [`BATCH`] rays, each of interest for t from 0 to its limit.
    pub(super) fn batch(&self, rays: &[Ray], limits: &[f64]) -> Batch {
        assert!(
            rays.len() <= BATCH,
            "a batch is small enough for its quads to be numbered in a u8"
        );
        let reach = rays
            .iter()
            .map(|ray| self.to_frame(ray.origin.0).abs().max_element());
        let reach = reach.fold(0.0, f64::max);
        let quads = rays
            .chunks(QUAD)
            .zip(limits.chunks(QUAD))
            .map(|(rays, limits)| {
                // The last quad may have fewer rays; the others of it never meet anything.
                let mut quad = QuadRays {
                    origin: [Vec4::ZERO; 3],
                    inverse: [Vec4::ONE; 3],
                    limit: Vec4::NEG_ONE,
                };
                for (lane, (ray, &limit)) in rays.iter().zip(limits).enumerate() {
                    let origin = self.to_frame(ray.origin.0).as_vec3();
                    let direction = (ray.direction * self.scale).as_vec3();
                    for axis in 0..3 {
                        quad.origin[axis][lane] = origin[axis];
                        quad.inverse[axis][lane] = inverse(direction[axis]);
                    }
                    quad.limit[lane] = not_below(limit);
                }
                quad
            });
        Batch {
            quads: quads.collect(),
            margin: (reach as f32 + 1.0) * BOX_GIVES_WAY,
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
            nodes: &self.nodes,
            lists: all.collect(),
            batch,
            leaf,
        };
        let everyone = (0, descent.lists.len());
        for members in roots.chunks(WIDTH) {
            descent.open(members, everyone);
        }
    }

    /// Bytes of the nodes.
    pub(super) fn memory(&self) -> usize {
        size_of_val(self.nodes.as_slice())
    }
}

impl Member {
    fn new(bounds: &Aabb, child: Child) -> Self {
        Self {
            min: bounds.min.into(),
            max: bounds.max.into(),
            child,
        }
    }

    fn bounds(&self) -> Bounds {
        Bounds {
            min: self.min.as_dvec3(),
            max: self.max.as_dvec3(),
        }
    }
}

impl Node {
    const EMPTY: Self = Self {
        members: [Member {
            min: Vec3::INFINITY,
            max: Vec3::NEG_INFINITY,
            child: Child::Leaf { first: 0, count: 0 },
        }; WIDTH],
        len: 0,
    };

    fn push(&mut self, member: Member) {
        self.members[usize::from(self.len)] = member;
        self.len += 1;
    }

    fn members(&self) -> &[Member] {
        &self.members[..usize::from(self.len)]
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
                    let shapes = first as usize..first as usize + usize::from(count);
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
                    let limit = (self.leaf)(shapes.clone(), index * QUAD + lane);
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

/// A parameter in f32 that is not below it, with room for the rounding of a slab test.
fn not_below(t: f64) -> f32 {
    t as f32 * SLAB_GIVES_WAY
}

fn rounded_down(position: DVec3) -> Vec3 {
    Vec3::from_array(position.to_array().map(|exact| {
        let near = exact as f32;
        if f64::from(near) > exact {
            near.next_down()
        } else {
            near
        }
    }))
}

fn rounded_up(position: DVec3) -> Vec3 {
    -rounded_down(-position)
}
