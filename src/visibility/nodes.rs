//! A tree as rays go down it: the boxes of eight children side by side.

use glam::DVec3;
use rayon::prelude::*;

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
    /// A tree over shapes but the few `listed` ones, and the order of the shapes in its leaves. Their blocks
    /// are put behind those of the listed shapes, leaf by leaf.
    pub(super) fn new<T: Shape>(
        count: u32,
        shape: &(impl Fn(u32) -> T + Sync),
        listed: &[u32],
        blocks: &mut Vec<Members>,
    ) -> (Self, Vec<u32>) {
        let (bvh, order) = Bvh::new(count, shape, listed);
        let before = listed.len() as u32;
        let mut starts = Vec::with_capacity(bvh.nodes().len());
        blocks.reserve(count as usize / T::WIDTH * 5 / 4);
        for node in bvh.nodes() {
            starts.push(blocks.len() as u32);
            for member in node.members() {
                if let Child::Leaf { first, count } = member.child {
                    blocks.extend(blocks_of::<T>(before + first, count));
                }
            }
        }
        let nodes = bvh.nodes().par_iter().zip(&starts);
        let nodes = nodes.map(|(node, &start)| {
            let mut next = start;
            Node::of(node.members(), &mut |count| {
                let place = next;
                next += count.div_ceil(T::WIDTH as u32);
                place
            })
        });
        let nodes = nodes.collect();
        let tree = Self {
            nodes,
            center: bvh.center(),
            scale: bvh.scale(),
        };
        (tree, order)
    }

    /// Bytes of the nodes.
    pub(super) fn memory(&self) -> usize {
        size_of_val(self.nodes.as_slice())
    }
}

/// The blocks of shapes that follow each other: each has [`Shape::WIDTH`] of them, the last one the rest.
pub(super) fn blocks_of<T: Shape>(first: u32, count: u32) -> impl Iterator<Item = Members> {
    (0..count).step_by(T::WIDTH).map(move |start| Members {
        first: first + start,
        count: (count - start).min(T::WIDTH as u32),
    })
}

impl Node {
    /// Of at most eight members; `block` gives the first block of a leaf by the number of its shapes.
    fn of(members: &[Member], block: &mut impl FnMut(u32) -> u32) -> Self {
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
                Child::Leaf { count, .. } => (block(count), count),
            };
            node.present |= 1 << place;
        }
        node
    }
}
