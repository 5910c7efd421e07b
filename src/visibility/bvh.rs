//! A bounding volume hierarchy with eight children a node, built by obvhs.
//!
//! Boxes are f32 in a frame of the tree's own, in which the whole is about 1 across: they work
//! the same at any scale and anywhere. They are rounded outwards, so that no shape is missed that
//! the f64 intersection would hit.

use glam::{DVec3, Vec3};
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::builder::build_bvh2;

use super::search::Shape;

/// Children of a node.
pub(super) const WIDTH: usize = 8;

/// Shapes in a leaf at most. Their own boxes sort them better than a common one.
const LEAF_SIZE: u32 = 1;

/// How much a box gives way, per unit of distance of the ray's origin (in the tree's frame, and
/// at least 1): rounding the origin to f32 moves it by 2⁻²⁴, and rounding boxes and origin in f64
/// by far less. Four times that.
pub(super) const BOX_GIVES_WAY: f32 = 4.0 * (f32::EPSILON / 2.0);

/// Levels of nodes below the root at most; a subtree that would go deeper becomes one leaf. Trees of
/// ten million triangles have about ten.
const DEEPEST: usize = 64;

/// The tree's frame is at most this power of two larger or smaller than the world: f32 boxes and
/// rays stay far from overflow.
const LARGEST_EXPONENT: i32 = 100;

/// A box in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub(super) min: DVec3,
    pub(super) max: DVec3,
}

impl Bounds {
    /// The smallest box around two boxes.
    pub(super) fn union(self, other: Self) -> Self {
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
pub(super) struct Node {
    /// The first `len` are there.
    members: [Member; WIDTH],
    len: u8,
}

/// A box and what is in it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Member {
    pub(super) min: Vec3,
    pub(super) max: Vec3,
    pub(super) child: Child,
}

/// What is in a box.
#[derive(Clone, Copy, Debug)]
pub(super) enum Child {
    /// A node.
    Node(u32),
    /// Shapes.
    Leaf { first: u32, count: u32 },
}

impl Bvh {
    /// A tree over shapes, and the order in which its leaves have them.
    pub(super) fn new<S: Shape>(shapes: &[S]) -> (Self, Vec<u32>) {
        let whole = shapes.iter().map(Shape::bounds).reduce(Bounds::union);
        let whole = whole.expect("a tree is planned only for shapes");
        let center = whole.min * 0.5 + whole.max * 0.5;
        let size = (whole.max - whole.min).max_element();
        // Shapes smaller than the rounding of their place may have no size in common.
        let exponent = if size > 0.0 { libm::ilogb(size) } else { 0 };
        let mut tree = Self {
            nodes: Vec::new(),
            center,
            scale: libm::exp2(-f64::from(
                exponent.clamp(-LARGEST_EXPONENT, LARGEST_EXPONENT),
            )),
        };
        let boxes: Vec<Aabb> = shapes
            .iter()
            .map(|shape| tree.outer_box(&shape.bounds()))
            .collect();
        let clumps = Clumps::new(&boxes);
        let parameters = BvhBuildParams {
            max_prims_per_leaf: LEAF_SIZE,
            ..BvhBuildParams::medium_build()
        };
        let binary = build_bvh2(
            &clumps.bounds,
            parameters,
            &mut std::time::Duration::default(),
        );
        let order = tree.widen(&binary, &clumps);
        (tree, order)
    }

    /// Into the frame in which the whole tree is about 1 across.
    pub(super) fn to_frame(&self, position: DVec3) -> DVec3 {
        (position - self.center) * self.scale
    }

    /// From lengths of the world to lengths of the tree's frame: a power of two.
    pub(super) fn scale(&self) -> f64 {
        self.scale
    }

    /// All nodes, the root first.
    pub(super) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    fn outer_box(&self, bounds: &Bounds) -> Aabb {
        Aabb {
            min: rounded_down(self.to_frame(bounds.min)).into(),
            max: rounded_up(self.to_frame(bounds.max)).into(),
        }
    }

    /// Makes nodes of eight from a binary tree over clumps, each by opening the largest box while
    /// there is room, and returns the order in which the leaves have the shapes.
    fn widen(&mut self, binary: &Bvh2, clumps: &Clumps) -> Vec<u32> {
        let mut order = Vec::with_capacity(clumps.shapes.len());
        // Binary nodes whose wide node is reserved but not filled in yet, with their depth.
        let mut open = vec![(0_usize, 0_usize, 0_usize)];
        self.nodes.push(Node::EMPTY);
        while let Some((binary_index, wide_index, depth)) = open.pop() {
            for member in wide_members(binary, binary_index) {
                let node = &binary.nodes[member];
                let child = if node.is_leaf() || depth == DEEPEST {
                    let first = order.len() as u32;
                    for clump in leaves_below(binary, member) {
                        order.extend_from_slice(clumps.shapes_of(clump));
                    }
                    Child::Leaf {
                        first,
                        count: order.len() as u32 - first,
                    }
                } else {
                    open.push((member, self.nodes.len(), depth + 1));
                    self.nodes.push(Node::EMPTY);
                    Child::Node(self.nodes.len() as u32 - 1)
                };
                self.nodes[wide_index].push(Member::new(node.aabb(), child));
            }
        }
        order
    }

    /// Middle of the tree's frame in world space.
    pub(super) fn center(&self) -> DVec3 {
        self.center
    }
}

/// Shapes whose boxes have one center, such as copies of each other, together: no tree can part
/// them, and the builder takes quadratic time to try.
struct Clumps {
    /// The shapes, clump after clump.
    shapes: Vec<u32>,
    /// Where each clump starts in `shapes`, and where the last one ends.
    starts: Vec<usize>,
    /// The box around each clump.
    bounds: Vec<Aabb>,
}

impl Clumps {
    fn new(boxes: &[Aabb]) -> Self {
        let center = |shape: &u32| {
            let bounds = &boxes[*shape as usize];
            (bounds.min + bounds.max).to_array().map(f32::to_bits)
        };
        let mut shapes: Vec<u32> = (0..boxes.len() as u32).collect();
        // The builder does best with shapes in the order of the scene: it is kept unless there
        // are clumps.
        let mut centers: Vec<[u32; 3]> = shapes.iter().map(center).collect();
        centers.sort_unstable();
        let has_clumps = centers.windows(2).any(|pair| pair[0] == pair[1]);
        if has_clumps {
            shapes.sort_by_key(center);
        }
        let mut starts = Vec::with_capacity(shapes.len() + 1);
        let mut bounds: Vec<Aabb> = Vec::with_capacity(shapes.len());
        for (place, shape) in shapes.iter().enumerate() {
            let shape_box = &boxes[*shape as usize];
            match bounds.last_mut() {
                Some(clump) if has_clumps && center(&shapes[place - 1]) == center(shape) => {
                    *clump = clump.union(shape_box);
                }
                Some(_) | None => {
                    starts.push(place);
                    bounds.push(*shape_box);
                }
            }
        }
        starts.push(shapes.len());
        Self {
            shapes,
            starts,
            bounds,
        }
    }

    fn shapes_of(&self, clump: u32) -> &[u32] {
        let clump = clump as usize;
        &self.shapes[self.starts[clump]..self.starts[clump + 1]]
    }
}

/// Up to eight descendants of a node that together have all below it: the largest is opened while
/// there is room.
fn wide_members(binary: &Bvh2, root: usize) -> Vec<usize> {
    let children = |index: usize| {
        let first = binary.nodes[index].first_index as usize;
        [first, first + 1]
    };
    let mut members = Vec::with_capacity(WIDTH);
    if binary.nodes[root].is_leaf() {
        members.push(root);
    } else {
        members.extend(children(root));
    }
    while members.len() < WIDTH {
        let inner = members.iter().enumerate();
        let inner = inner.filter(|&(_, &member)| !binary.nodes[member].is_leaf());
        let largest = inner.max_by(|&(_, &a), &(_, &b)| {
            let area = |member: usize| binary.nodes[member].aabb().half_area();
            area(a).total_cmp(&area(b))
        });
        let Some((place, &member)) = largest else {
            break;
        };
        let [first, second] = children(member);
        members[place] = first;
        members.push(second);
    }
    members
}

/// The primitives of all leaves below a node, or of the node if it is a leaf.
fn leaves_below(binary: &Bvh2, root: usize) -> Vec<u32> {
    let mut primitives = Vec::new();
    let mut open = vec![root];
    while let Some(index) = open.pop() {
        let node = &binary.nodes[index];
        let first = node.first_index as usize;
        if node.is_leaf() {
            let indices = first..first + node.prim_count as usize;
            primitives.extend_from_slice(&binary.primitive_indices[indices]);
        } else {
            open.extend([first, first + 1]);
        }
    }
    primitives
}

impl Member {
    fn new(bounds: &Aabb, child: Child) -> Self {
        Self {
            min: bounds.min.into(),
            max: bounds.max.into(),
            child,
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

    /// The boxes that are there.
    pub(super) fn members(&self) -> &[Member] {
        &self.members[..usize::from(self.len)]
    }
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
