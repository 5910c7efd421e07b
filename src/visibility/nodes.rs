//! A tree as rays go down it: the boxes of eight children side by side.

use glam::DVec3;

pub(super) use super::bvh::WIDTH;
use super::bvh::{Bvh, Child, Member};
use super::search::Shape;

/// Up to eight boxes and what is in them.
#[derive(Clone, Debug)]
pub(super) struct Node {
    /// For each axis the lower and the upper planes of the boxes.
    pub(super) planes: [[[f32; WIDTH]; 2]; 3],
    /// A node, or the first block of the shapes in the box.
    pub(super) children: [u32; WIDTH],
    /// How many shapes; 0 for a node.
    pub(super) counts: [u32; WIDTH],
    /// One bit for each child that is there.
    pub(super) present: u32,
}

/// A box that is to be opened.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// A node, or the first block of the shapes.
    pub(super) child: u32,
    /// How many shapes; 0 for a node.
    pub(super) count: u32,
    /// The smallest t at which a ray enters, in the tree's frame.
    pub(super) at: f32,
}

/// A tree over shapes that are somewhere in blocks.
#[derive(Debug)]
pub(super) struct Tree {
    /// The root first.
    pub(super) nodes: Vec<Node>,
    /// Middle of the tree's frame in world space.
    pub(super) center: DVec3,
    /// From world space to the tree's frame: a power of two.
    pub(super) scale: f64,
}

/// The shapes of a block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Members {
    /// The first in the order of the tree.
    pub(super) first: u32,
    pub(super) count: u32,
}

impl Tree {
    /// A tree over shapes but some, in order, the order of the shapes in its leaves, and the blocks, from
    /// `first_block` on. Each leaf has blocks of [`Shape::WIDTH`] shapes for itself, one after the other.
    pub(super) fn new<T: Shape>(
        shapes: &[T],
        without: &[usize],
        first_block: u32,
    ) -> (Self, Vec<u32>, Vec<Members>) {
        let (bvh, order) = Bvh::new(shapes, without);
        let mut blocks = Vec::with_capacity(shapes.len() / T::WIDTH * 2);
        let mut take = |first: u32, count: u32| {
            let place = first_block + blocks.len() as u32;
            for start in (0..count).step_by(T::WIDTH) {
                blocks.push(Members {
                    first: first + start,
                    count: (count - start).min(T::WIDTH as u32),
                });
            }
            place
        };
        let nodes = bvh.nodes().iter();
        let nodes = nodes
            .map(|node| Node::of(node.members(), &mut take))
            .collect();
        let tree = Self {
            nodes,
            center: bvh.center(),
            scale: bvh.scale(),
        };
        (tree, order, blocks)
    }

    /// Bytes of the nodes.
    pub(super) fn memory(&self) -> usize {
        size_of_val(self.nodes.as_slice())
    }
}

impl Node {
    /// Of at most eight members; `block` gives the first block of a leaf by its shapes.
    fn of(members: &[Member], block: &mut impl FnMut(u32, u32) -> u32) -> Self {
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
                Child::Leaf { first, count } => (block(first, count), count),
            };
            node.present |= 1 << place;
        }
        node
    }
}
