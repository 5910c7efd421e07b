//! A bounding volume hierarchy with eight children a node.
//!
//! Boxes are f32 in a frame of the tree's own, in which the whole is about 1 across: they work
//! the same at any scale and anywhere. They are rounded outwards, so that no shape is missed that
//! the f64 intersection would hit.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::bounds::Bounds;
use super::builder::{self, Item};
use super::node::BuildNode;
use crate::math::all_three;

/// The tree's frame is at most this power of two larger or smaller than the world: f32 boxes and
/// rays stay far from overflow.
const LARGEST_EXPONENT: i32 = 100;

/// The tree.
#[derive(Debug)]
pub(in crate::visibility) struct Bvh {
    nodes: Vec<BuildNode>,
    /// Middle of the tree's frame in world space.
    center: DVec3,
    /// From world space to the tree's frame: a power of two.
    scale: f64,
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
        let nowhere = Bounds {
            min: DVec3::INFINITY,
            max: DVec3::NEG_INFINITY,
        };
        let all = (0..count).into_par_iter().map(|index| {
            if listed.contains(&index) {
                nowhere
            } else {
                bounds(index)
            }
        });
        let whole = all.reduce(|| nowhere, Bounds::union);
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
        let items = (0..count).into_par_iter().map(|index| {
            let Bounds { min, max } = bounds(index);
            let (min, max) = (tree.to_frame(min), tree.to_frame(max));
            Item::new(rounded_down(min), rounded_up(max), index)
        });
        let mut items: Vec<Item> = items.collect();
        for &index in listed.iter().rev() {
            items.swap_remove(index as usize);
        }
        let (nodes, order) = builder::build(items, width);
        tree.nodes = nodes;
        (tree, order)
    }

    /// Into the frame in which the whole tree is about 1 across.
    #[inline]
    pub(in crate::visibility) fn to_frame(&self, position: DVec3) -> DVec3 {
        (position - self.center) * self.scale
    }

    /// From lengths of the world to lengths of the tree's frame: a power of two.
    pub(in crate::visibility) fn scale(&self) -> f64 {
        self.scale
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
        self.center
    }
}

#[inline]
fn rounded_down(position: DVec3) -> Vec3 {
    Vec3::from_array(all_three(position.to_array(), |exact| {
        let near = exact as f32;
        if f64::from(near) > exact {
            near.next_down()
        } else {
            near
        }
    }))
}

#[inline]
fn rounded_up(position: DVec3) -> Vec3 {
    -rounded_down(-position)
}
