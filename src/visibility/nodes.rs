//! A tree as packets of rays go down it: the boxes of eight children side by side.

use glam::DVec3;

use super::bundle::Bundle;
pub(super) use super::bvh::{BOX_GIVES_WAY, WIDTH};
use super::bvh::{Bounds, Bvh, Child, Member};
use super::search::Shape;

/// Nodes that a batch of rays starts with, about: more leave fewer steps to each packet, but every
/// packet has to look at all.
const ENTRIES: usize = 2;

/// Up to eight boxes and what is in them.
#[derive(Clone, Debug)]
pub(super) struct Node {
    /// For each axis the lower and the upper planes of the boxes.
    pub(super) planes: [[[f32; WIDTH]; 2]; 3],
    /// A node, or the first of the shapes in the box.
    pub(super) children: [u32; WIDTH],
    /// How many shapes; 0 for a node.
    pub(super) counts: [u32; WIDTH],
    /// One bit for each child that is there.
    pub(super) present: u32,
}

/// A box that is to be opened.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// A node, or the first of the shapes.
    pub(super) child: u32,
    /// How many shapes; 0 for a node.
    pub(super) count: u32,
    /// The smallest t at which a ray enters, in the tree's frame.
    pub(super) at: f32,
}

/// Shapes in the order in which a tree's leaves have them, and the tree.
#[derive(Debug)]
pub(super) struct Tree<T> {
    pub(super) shapes: Vec<T>,
    /// The root first.
    pub(super) nodes: Vec<Node>,
    /// Middle of the tree's frame in world space.
    pub(super) center: DVec3,
    /// From world space to the tree's frame: a power of two.
    pub(super) scale: f64,
}

impl<T: Shape> Tree<T> {
    pub(super) fn new(shapes: &[T]) -> Self {
        let (bvh, order) = Bvh::new(shapes);
        let nodes = bvh.nodes().iter().map(|node| Node::of(node.members()));
        Self {
            shapes: order.iter().map(|&index| shapes[index as usize]).collect(),
            nodes: nodes.collect(),
            center: bvh.center(),
            scale: bvh.scale(),
        }
    }

    /// Nodes that together have every shape that a ray of the bundle could meet, near ones first.
    pub(super) fn entries(&self, bundle: &Bundle) -> Vec<Node> {
        let bundle = bundle.in_frame(self.center, self.scale);
        let margin = (bundle.reach() + 1.0) * f64::from(BOX_GIVES_WAY);
        let may_meet = |member: &Member| bundle.may_meet(&member.bounds().grown(margin));
        let mut pieces: Vec<Member> = Vec::with_capacity((ENTRIES + 1) * WIDTH);
        let mut queue: std::collections::VecDeque<Member> = self.nodes[0].members().collect();
        queue.retain(may_meet);
        while let Some(member) = queue.pop_front() {
            match member.child {
                Child::Node(index) if pieces.len() + queue.len() < ENTRIES * WIDTH => {
                    queue.extend(self.nodes[index as usize].members().filter(may_meet));
                }
                Child::Node(_) | Child::Leaf { .. } => pieces.push(member),
            }
        }
        let distance = |member: &Member| bundle.distance_along(&member.bounds());
        pieces.sort_by(|a, b| distance(a).total_cmp(&distance(b)));
        pieces.chunks(WIDTH).map(Node::of).collect()
    }

    /// Bytes of shapes and nodes.
    pub(super) fn memory(&self) -> usize {
        size_of_val(self.shapes.as_slice()) + size_of_val(self.nodes.as_slice())
    }
}

impl Node {
    /// Of at most eight members.
    fn of(members: &[Member]) -> Self {
        let mut node = Self {
            planes: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3],
            children: [0; WIDTH],
            counts: [0; WIDTH],
            present: 0,
        };
        for (place, member) in members.iter().enumerate() {
            for axis in 0..3 {
                node.planes[axis][0][place] = member.min[axis];
                node.planes[axis][1][place] = member.max[axis];
            }
            (node.children[place], node.counts[place]) = match member.child {
                Child::Node(index) => (index, 0),
                Child::Leaf { first, count } => (first, count),
            };
            node.present |= 1 << place;
        }
        node
    }

    fn members(&self) -> impl Iterator<Item = Member> + '_ {
        (0..WIDTH)
            .filter(|place| self.present >> place & 1 == 1)
            .map(|place| {
                let corner = |end: usize| {
                    glam::Vec3::from_array(
                        [0, 1, 2].map(|axis: usize| self.planes[axis][end][place]),
                    )
                };
                Member {
                    min: corner(0),
                    max: corner(1),
                    child: match (self.children[place], self.counts[place]) {
                        (index, 0) => Child::Node(index),
                        (first, count) => Child::Leaf { first, count },
                    },
                }
            })
    }
}

impl Member {
    fn bounds(&self) -> Bounds {
        Bounds {
            min: self.min.as_dvec3(),
            max: self.max.as_dvec3(),
        }
    }
}
