//! A tree as rays go down it: the boxes of eight children side by side.

use std::hint::black_box;

use glam::DVec3;
use rayon::prelude::*;

use super::bounds::Bounds;
use super::bvh::Bvh;
use super::node::{Child, Member, WIDTH};
use super::parts::PlacedPart;

/// Up to eight boxes and what is in them.
#[derive(Clone, Debug)]
pub(in crate::visibility) struct WideNode {
    /// For each axis the lower and the upper planes of the boxes.
    pub(in crate::visibility) planes: [[[f32; WIDTH]; 2]; 3],
    /// A node, or the first block of the shapes in the box.
    pub(in crate::visibility) children: [u32; WIDTH],
    /// How many shapes; 0 for a node.
    pub(in crate::visibility) counts: [u32; WIDTH],
    /// One bit for each child that is there.
    pub(in crate::visibility) present: u32,
}

/// A tree over shapes that are somewhere in blocks.
#[derive(Debug)]
pub(in crate::visibility) struct Tree {
    /// The root first.
    pub(in crate::visibility) nodes: Vec<WideNode>,
    /// Middle of the tree's frame in world space.
    pub(in crate::visibility) center: DVec3,
    /// From world space to the tree's frame: a power of two.
    pub(in crate::visibility) scale: f64,
    /// The largest coordinate of any box in the tree's frame.
    pub(in crate::visibility) reach: f64,
}

/// The shapes of a block.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct BlockRange {
    /// The first in the order of the tree.
    pub(in crate::visibility) first: u32,
    pub(in crate::visibility) count: u32,
}

impl Tree {
    /// A tree over shapes of these bounds, `width` of them to a block, but the few `listed` ones, and the order
    /// of the shapes in its leaves. Their blocks are put behind those of the listed shapes, leaf by leaf.
    pub(in crate::visibility) fn new(
        count: u32,
        width: usize,
        bounds: &(impl Fn(u32) -> Bounds + Sync),
        listed: &[u32],
        blocks: &mut Vec<BlockRange>,
    ) -> (Self, Vec<u32>) {
        let (bvh, order) = Bvh::new(count, width, bounds, listed);
        blocks.reserve(order.len() / width * 5 / 4);
        (
            Self::widened(&bvh, width, listed.len() as u32, blocks),
            order,
        )
    }

    /// A tree over the shapes of parts, with blocks and an order as of [`Tree::new`]; `listed` shapes come before
    /// them.
    pub(in crate::visibility) fn of_parts(
        parts: &[PlacedPart<'_>],
        width: usize,
        bounds: &(impl Fn(u32) -> Bounds + Sync),
        listed: u32,
        blocks: &mut Vec<BlockRange>,
    ) -> (Self, Vec<u32>) {
        let (bvh, order) = Bvh::of_parts(parts, bounds);
        blocks.reserve(order.len() / width * 5 / 4);
        (Self::widened(&bvh, width, listed, blocks), order)
    }

    fn widened(bvh: &Bvh, width: usize, before: u32, blocks: &mut Vec<BlockRange>) -> Self {
        let mut starts = Vec::with_capacity(bvh.nodes().len());
        for node in bvh.nodes() {
            starts.push(blocks.len() as u32);
            for member in node.members() {
                if let Child::Leaf { first, count } = member.child {
                    blocks.extend(blocks_of(before + first, count, width));
                }
            }
        }
        let nodes = bvh.nodes().par_iter().zip(&starts);
        let nodes = nodes.map(|(node, &start)| {
            let mut next = start;
            WideNode::of(node.members(), &mut |count| {
                let place = next;
                next += count.div_ceil(width as u32);
                place
            })
        });
        let nodes: Vec<WideNode> = nodes.collect();
        Self {
            reach: bvh.reach(),
            nodes,
            center: bvh.center(),
            scale: bvh.scale(),
        }
    }

    /// Bytes of the nodes.
    pub(in crate::visibility) fn memory(&self) -> usize {
        size_of_val(self.nodes.as_slice())
    }
}

/// The blocks of shapes that follow each other: each has `width` of them, the last one the rest.
pub(in crate::visibility) fn blocks_of(
    first: u32,
    count: u32,
    width: usize,
) -> impl Iterator<Item = BlockRange> {
    (0..count).step_by(width).map(move |start| BlockRange {
        first: first + start,
        count: (count - start).min(width as u32),
    })
}

impl WideNode {
    /// Reads a number of each line of it, so that it is on its way from memory.
    #[inline(always)]
    pub(super) fn touch(&self) {
        let [[x, _], [y, _], [z, _]] = &self.planes;
        black_box((x[0], y[0], z[0], self.children[0], self.present));
    }

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
