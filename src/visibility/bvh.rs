//! A bounding volume hierarchy with eight children a node, built by obvhs.
//!
//! Boxes are f32 in a frame of the tree's own, in which the whole is about 1 across: they work
//! the same at any scale and anywhere. They are conservative. Boxes are rounded outwards when
//! they are made, and the slab test gives way by more than the rounding of its own ray, so that
//! no shape is missed that the f64 intersection would hit.

use std::collections::VecDeque;
use std::ops::Range;

use glam::{DVec3, Vec3, Vec4};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

use super::bundle::Bundle;
use super::search::Bounded;
use crate::math::{Point, Ray};

/// Children of a node.
const WIDTH: usize = 2 * HALF;

/// Children side by side in one register.
const HALF: usize = 4;

/// Pieces of the tree that a batch of rays starts with, about: more are found with fewer steps
/// down from each, but every ray has to look at all.
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
#[repr(align(64))]
pub(super) struct Node {
    /// Lower x, y, z, then upper x, y, z, of all children.
    bounds: [[Vec4; 2]; 6],
    children: [Child; WIDTH],
}

/// What is in a box.
#[derive(Clone, Copy, Debug)]
enum Child {
    /// Nothing; its box is empty.
    None,
    /// A node.
    Node(u32),
    /// Shapes.
    Leaf { first: u32, count: u8 },
}

/// A child still to be visited, and the parameter at which the ray enters its box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pending {
    child: Child,
    enters: f32,
}

/// The start of a ray in the tree's frame, moved by what boxes give way: one way for lower and
/// the other for upper bounds.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Viewpoint {
    for_lower: Vec3,
    for_upper: Vec3,
}

/// A ray in the tree's frame, arranged for slab tests.
struct SlabRay {
    /// Which rows of [`Node::bounds`] the ray meets first and last, axis by axis.
    near: [usize; 3],
    far: [usize; 3],
    /// The origin as the near and the far bounds need it.
    near_origin: [Vec4; 3],
    far_origin: [Vec4; 3],
    inverse: [Vec4; 3],
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
            ..BvhBuildParams::fast_build()
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
            for (slot, &member) in members.iter().enumerate() {
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
                self.nodes[wide_index].set(slot, node.aabb(), child);
            }
        }
    }

    /// What of the tree a whole batch of rays has to look at: a few nodes, packed anew, that
    /// together hold every shape that a ray of the bundle could meet. A tree is descended once for
    /// the batch until the pieces are as many as [`CUT_SIZE`].
    pub(super) fn cut(&self, bundle: &Bundle) -> Vec<Node> {
        let bundle = bundle.in_frame(self.center, self.scale);
        let margin = (bundle.reach() + 1.0) * f64::from(BOX_GIVES_WAY);
        let mut pieces: Vec<(Aabb, Child)> = Vec::with_capacity(CUT_SIZE + WIDTH);
        let mut queue = VecDeque::from([(Aabb::INFINITY, Child::Node(0))]);
        while let Some((bounds, child)) = queue.pop_front() {
            match child {
                Child::Node(index) if pieces.len() + queue.len() < CUT_SIZE => {
                    let members = self.nodes[index as usize].members();
                    queue.extend(members.filter(|(bounds, _)| {
                        let bounds = Bounds {
                            min: bounds.min.as_dvec3(),
                            max: bounds.max.as_dvec3(),
                        };
                        bundle.may_meet(&bounds.grown(margin))
                    }));
                }
                Child::Node(_) | Child::Leaf { .. } => pieces.push((bounds, child)),
                Child::None => {}
            }
        }
        let pack = |pieces: &[(Aabb, Child)]| {
            let mut node = Node::EMPTY;
            for (slot, &(bounds, child)) in pieces.iter().enumerate() {
                node.set(slot, &bounds, child);
            }
            node
        };
        pieces.chunks(WIDTH).map(pack).collect()
    }

    /// A place from which many rays start.
    pub(super) fn viewpoint(&self, origin: Point) -> Viewpoint {
        let origin = self.to_frame(origin.0).as_vec3();
        let margin = Vec3::splat((origin.abs().max_element() + 1.0) * BOX_GIVES_WAY);
        Viewpoint {
            for_lower: origin + margin,
            for_upper: origin - margin,
        }
    }

    fn slab_ray(&self, viewpoint: &Viewpoint, direction: DVec3) -> SlabRay {
        let direction = (direction * self.scale).as_vec3().to_array();
        let (lower, upper) = (
            viewpoint.for_lower.to_array(),
            viewpoint.for_upper.to_array(),
        );
        let forwards = direction.map(|component| component >= 0.0);
        let select = |axis: usize, near: bool| (forwards[axis] == near, axis);
        let row = |(is_lower, axis): (bool, usize)| if is_lower { axis } else { axis + 3 };
        let origin =
            |(is_lower, axis): (bool, usize)| if is_lower { lower[axis] } else { upper[axis] };
        SlabRay {
            near: std::array::from_fn(|axis| row(select(axis, true))),
            far: std::array::from_fn(|axis| row(select(axis, false))),
            near_origin: std::array::from_fn(|axis| Vec4::splat(origin(select(axis, true)))),
            far_origin: std::array::from_fn(|axis| Vec4::splat(origin(select(axis, false)))),
            inverse: direction.map(|component| {
                Vec4::splat(
                    1.0 / if component.abs() < SMALLEST_COMPONENT {
                        SMALLEST_COMPONENT.copysign(component)
                    } else {
                        component
                    },
                )
            }),
        }
    }

    /// Shows `leaf` the leaves below `roots` that the ray meets at t from 0 to `limit`, roughly
    /// near to far. `leaf` gives the new limit back.
    pub(super) fn visit(
        &self,
        roots: &[Node],
        ray: &Ray,
        limit: f64,
        stack: &mut Vec<Pending>,
        mut leaf: impl FnMut(Range<usize>) -> f64,
    ) {
        let slabs = self.slab_ray(&self.viewpoint(ray.origin), ray.direction);
        let mut limit = not_below(limit);
        stack.clear();
        for root in roots {
            root.push_sorted(&slabs, limit, stack, 0);
        }
        while let Some(Pending { child, enters }) = stack.pop() {
            if enters > limit {
                continue;
            }
            match child {
                Child::None => {}
                Child::Leaf { first, count } => {
                    limit = not_below(leaf(first as usize..first as usize + usize::from(count)));
                }
                Child::Node(index) => {
                    let bottom = stack.len();
                    self.nodes[index as usize].push_sorted(&slabs, limit, stack, bottom);
                }
            }
        }
    }

    /// Whether `leaf` holds for any leaf below `roots` that a ray from `viewpoint` meets at t from
    /// 0 to 1.
    pub(super) fn any(
        &self,
        roots: &[Node],
        viewpoint: &Viewpoint,
        direction: DVec3,
        stack: &mut Vec<Pending>,
        leaf: impl Fn(Range<usize>) -> bool,
    ) -> bool {
        let slabs = self.slab_ray(viewpoint, direction);
        let limit = not_below(1.0);
        stack.clear();
        for root in roots {
            root.push(&slabs, limit, stack);
        }
        while let Some(Pending { child, .. }) = stack.pop() {
            match child {
                Child::None => {}
                Child::Leaf { first, count } => {
                    if leaf(first as usize..first as usize + usize::from(count)) {
                        return true;
                    }
                }
                Child::Node(index) => self.nodes[index as usize].push(&slabs, limit, stack),
            }
        }
        false
    }

    /// Bytes of the nodes.
    pub(super) fn memory(&self) -> usize {
        size_of_val(self.nodes.as_slice())
    }
}

impl Node {
    const EMPTY: Self = {
        let (lower, upper) = ([Vec4::INFINITY; 2], [Vec4::NEG_INFINITY; 2]);
        Self {
            bounds: [lower, lower, lower, upper, upper, upper],
            children: [Child::None; WIDTH],
        }
    };

    fn set(&mut self, slot: usize, bounds: &Aabb, child: Child) {
        let (min, max) = (bounds.min.to_array(), bounds.max.to_array());
        for axis in 0..3 {
            self.bounds[axis][slot / HALF][slot % HALF] = min[axis];
            self.bounds[axis + 3][slot / HALF][slot % HALF] = max[axis];
        }
        self.children[slot] = child;
    }

    /// The children and their boxes.
    fn members(&self) -> impl Iterator<Item = (Aabb, Child)> + '_ {
        (0..WIDTH).map(|slot| {
            let bound = |row: usize| self.bounds[row][slot / HALF][slot % HALF];
            let min = Vec3::new(bound(0), bound(1), bound(2));
            let max = Vec3::new(bound(3), bound(4), bound(5));
            (Aabb::new(min.into(), max.into()), self.children[slot])
        })
    }

    /// Puts the children that the ray meets on the stack.
    #[inline(always)]
    fn push(&self, ray: &SlabRay, limit: f32, stack: &mut Vec<Pending>) {
        self.meet(ray, limit, |child, enters| {
            stack.push(Pending { child, enters })
        });
    }

    /// Puts the children that the ray meets on the stack, the nearest of all above `bottom` on
    /// top.
    #[inline(always)]
    fn push_sorted(&self, ray: &SlabRay, limit: f32, stack: &mut Vec<Pending>, bottom: usize) {
        self.meet(ray, limit, |child, enters| {
            stack.push(Pending { child, enters });
            let mut place = stack.len() - 1;
            while place > bottom && stack[place - 1].enters < stack[place].enters {
                stack.swap(place - 1, place);
                place -= 1;
            }
        });
    }

    /// Shows `met` the children whose boxes the ray enters at t from 0 to `limit`, and where.
    #[inline(always)]
    fn meet(&self, ray: &SlabRay, limit: f32, mut met: impl FnMut(Child, f32)) {
        let (near, far) = (
            ray.near.map(|row| &self.bounds[row]),
            ray.far.map(|row| &self.bounds[row]),
        );
        for half in 0..2 {
            let near_at =
                |axis: usize| (near[axis][half] - ray.near_origin[axis]) * ray.inverse[axis];
            let far_at = |axis: usize| (far[axis][half] - ray.far_origin[axis]) * ray.inverse[axis];
            let enters = near_at(0).max(near_at(1)).max(near_at(2).max(Vec4::ZERO));
            let leaves = far_at(0).min(far_at(1)).min(far_at(2)) * SLAB_GIVES_WAY;
            let mut hits = enters.cmple(leaves.min(Vec4::splat(limit))).bitmask();
            while hits != 0 {
                let slot = hits.trailing_zeros() as usize;
                hits &= hits - 1;
                met(self.children[half * HALF + slot], enters[slot]);
            }
        }
    }
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
