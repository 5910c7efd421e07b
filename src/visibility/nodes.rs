//! A tree as packets of rays go down it: the boxes of eight children side by side.

use glam::DVec3;

pub(super) use super::bvh::{BOX_GIVES_WAY, WIDTH};
use super::bvh::{Bvh, Child, Member};
use super::search::Shape;

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
}
