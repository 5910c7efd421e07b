//! Trees that are built apart and stand under one.
//!
//! Which shapes are together in a box is found for each part on its own, by its builder; that is what takes time,
//! and it is kept as long as the part's shapes stay where they are. Where the boxes of all parts are in the frame
//! of the whole is found again each time.

use glam::Vec3;
use rayon::prelude::*;

use super::bounds::Bounds;
use super::builder::{self, Item};
use super::frame::TreeFrame;
use super::node::{BuildNode, Child, Member, WIDTH};

/// Which shapes of a part are together in a box.
#[derive(Debug)]
pub(in crate::visibility) struct PartTree {
    /// The root first; leaves count the part's shapes in its order. The boxes are in a frame of its own.
    nodes: Vec<BuildNode>,
    /// The part's shapes by their places in it, as leaves have them.
    order: Vec<u32>,
}

/// A part of a tree that is put together: what is in its boxes, and the numbers of its shapes.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct PlacedPart<'p> {
    pub(in crate::visibility) tree: &'p PartTree,
    pub(in crate::visibility) numbers: &'p [u32],
}

/// A box of the tree's frame.
#[derive(Clone, Copy, Debug)]
struct Box3 {
    min: Vec3,
    max: Vec3,
}

impl PartTree {
    /// Of shapes with these bounds, at least one, `width` of them in a leaf if a plane parts them.
    pub(in crate::visibility) fn new(
        numbers: &[u32],
        width: usize,
        bounds: &(impl Fn(u32) -> Bounds + Sync),
    ) -> Self {
        let all = numbers.par_iter().map(|&number| bounds(number));
        let whole = all.reduce(|| Bounds::NOWHERE, Bounds::union);
        let frame = TreeFrame::around(whole);
        let item = |place: u32| {
            let (min, max) = frame.around_box(bounds(numbers[place as usize]));
            Item::new(min, max, place)
        };
        let around = frame.around_box(whole);
        let count = numbers.len() as u32;
        let (nodes, order) = builder::build(count, &[], around.into(), &item, width);
        Self { nodes, order }
    }

    /// Bytes of the arrays.
    pub(in crate::visibility) fn memory(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.order.as_slice())
    }
}

/// The nodes of all parts under common ones, the root first, with boxes in a frame; and the numbers of all shapes as
/// the leaves have them.
pub(super) fn together(
    parts: &[PlacedPart<'_>],
    frame: &TreeFrame,
    bounds: &(impl Fn(u32) -> Bounds + Sync),
) -> (Vec<BuildNode>, Vec<u32>) {
    let mut order = Vec::with_capacity(parts.iter().map(|part| part.numbers.len()).sum());
    let mut trees = Vec::with_capacity(parts.len());
    for PlacedPart { tree, numbers } in parts {
        let first = order.len() as u32;
        let placed = tree.order.par_iter().map(|&place| numbers[place as usize]);
        order.par_extend(placed);
        let mut nodes = tree.nodes.clone();
        nodes.par_iter_mut().for_each(|node| {
            for member in node.members_mut() {
                if let Child::Leaf {
                    first: start,
                    count,
                } = &mut member.child
                {
                    *start += first;
                    let shapes = &order[*start as usize..(*start + *count) as usize];
                    let boxes = shapes.iter().map(|&number| {
                        let (min, max) = frame.around_box(bounds(number));
                        Box3 { min, max }
                    });
                    let Box3 { min, max } = boxes.fold(Box3::NOWHERE, Box3::union);
                    (member.min, member.max) = (min, max);
                }
            }
        });
        let around = refit(&mut nodes, 0);
        trees.push((around, nodes));
    }
    let mut members: Vec<(usize, Box3)> = trees
        .iter()
        .map(|(around, _)| *around)
        .enumerate()
        .collect();
    let mut all = vec![BuildNode::EMPTY];
    put_under(&mut all, 0, &mut members);
    // Now it is known where each part's nodes go.
    let mut end = all.len() as u32;
    let starts: Vec<u32> = trees
        .iter()
        .map(|(_, nodes)| {
            let start = end;
            end += nodes.len() as u32;
            start
        })
        .collect();
    for node in &mut all {
        for member in node.members_mut() {
            if let Child::Leaf { first: part, .. } = member.child {
                member.child = Child::Node(starts[part as usize]);
            }
        }
    }
    for ((_, mut nodes), start) in trees.into_iter().zip(starts) {
        for member in nodes.iter_mut().flat_map(BuildNode::members_mut) {
            if let Child::Node(index) = &mut member.child {
                *index += start;
            }
        }
        all.append(&mut nodes);
    }
    (all, order)
}

/// Makes the boxes of nodes from those of the leaves below one of them; the box around all.
fn refit(nodes: &mut [BuildNode], index: usize) -> Box3 {
    let mut around = Box3::NOWHERE;
    for place in 0..nodes[index].members().len() {
        let member = nodes[index].members()[place];
        let inner = match member.child {
            Child::Leaf { .. } => Box3 {
                min: member.min,
                max: member.max,
            },
            Child::Node(below) => refit(nodes, below as usize),
        };
        let member = &mut nodes[index].members_mut()[place];
        (member.min, member.max) = (inner.min, inner.max);
        around = around.union(inner);
    }
    around
}

/// Puts parts under a node, and further nodes where there are more than eight: by their middles along the axis on
/// which these are widest. The part's number stands for its root, as a leaf.
fn put_under(nodes: &mut Vec<BuildNode>, index: usize, parts: &mut [(usize, Box3)]) {
    let middle = |&(_, Box3 { min, max }): &(usize, Box3)| min * 0.5 + max * 0.5;
    let (least, most) = parts.iter().map(middle).fold(
        (Vec3::INFINITY, Vec3::NEG_INFINITY),
        |(least, most), middle| (least.min(middle), most.max(middle)),
    );
    let widest = (most - least).max_position();
    parts.sort_by(|a, b| {
        let by_middle = middle(a)[widest].total_cmp(&middle(b)[widest]);
        by_middle.then(a.0.cmp(&b.0))
    });
    for group in parts.chunks_mut(parts.len().div_ceil(WIDTH)) {
        let around = group.iter().map(|&(_, around)| around);
        let Box3 { min, max } = around.fold(Box3::NOWHERE, Box3::union);
        let child = if let [(part, _)] = group {
            Child::Leaf {
                first: *part as u32,
                count: 1,
            }
        } else {
            let below = nodes.len();
            nodes.push(BuildNode::EMPTY);
            put_under(nodes, below, group);
            Child::Node(below as u32)
        };
        nodes[index].push(Member { min, max, child });
    }
}

impl Box3 {
    const NOWHERE: Self = Self {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
    };

    fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }
}
