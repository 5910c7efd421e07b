//! A bounding volume hierarchy with eight children a node.
//!
//! Boxes are f32 in a frame of the tree's own, in which the whole is about 1 across: they work
//! the same at any scale and anywhere. They are rounded outwards, so that no shape is missed that
//! the f64 intersection would hit.

use glam::DVec3;
use rayon::prelude::*;

use super::bounds::Bounds;
use super::builder::{self, Item};
use super::frame::TreeFrame;
use super::node::BuildNode;
use super::parts::{PlacedPart, together};

/// The tree.
#[derive(Debug)]
pub(in crate::visibility) struct Bvh {
    nodes: Vec<BuildNode>,
    frame: TreeFrame,
}

impl Bvh {
    /// A tree over shapes, by their numbers, but the few `listed` ones, with `width` of them in a leaf
    /// if a plane parts them, and the order in which its leaves have them.
    pub(in crate::visibility) fn new(
        count: u32,
        width: usize,
        bounds: &(impl Fn(u32) -> Bounds + Sync),
        listed: &[u32],
    ) -> (Self, Vec<u32>) {
        let all = (0..count).into_par_iter().map(|index| {
            if listed.contains(&index) {
                Bounds::NOWHERE
            } else {
                bounds(index)
            }
        });
        let whole = all.reduce(|| Bounds::NOWHERE, Bounds::union);
        let frame = TreeFrame::around(whole);
        let item = |index| {
            let (min, max) = frame.around_box(bounds(index));
            Item::new(min, max, index)
        };
        let around = frame.around_box(whole);
        let (nodes, order) = builder::build(count, listed, around.into(), &item, width);
        (Self { nodes, frame }, order)
    }

    /// A tree over the shapes of parts, each with a tree of its own.
    pub(in crate::visibility) fn of_parts(
        parts: &[PlacedPart<'_>],
        bounds: &(impl Fn(u32) -> Bounds + Sync),
    ) -> (Self, Vec<u32>) {
        let all = parts.par_iter().flat_map(|part| part.numbers);
        let all = all.map(|&number| bounds(number));
        let frame = TreeFrame::around(all.reduce(|| Bounds::NOWHERE, Bounds::union));
        let (nodes, order) = together(parts, &frame, bounds);
        (Self { nodes, frame }, order)
    }

    /// From lengths of the world to lengths of the tree's frame: a power of two.
    pub(in crate::visibility) fn scale(&self) -> f64 {
        self.frame.scale
    }

    /// All nodes, the root first.
    pub(in crate::visibility) fn nodes(&self) -> &[BuildNode] {
        &self.nodes
    }

    /// The largest coordinate of any box in the tree's frame.
    pub(in crate::visibility) fn reach(&self) -> f64 {
        let members = self.nodes[0].members().iter();
        let reach = members.map(|member| member.min.abs().max(member.max.abs()).max_element());
        f64::from(reach.fold(0.0, f32::max))
    }

    /// Middle of the tree's frame in world space.
    pub(in crate::visibility) fn center(&self) -> DVec3 {
        self.frame.center
    }
}
