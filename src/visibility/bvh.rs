//! A bounding volume hierarchy with eight children a node.
//!
//! Boxes are f32 in a frame of the tree's own, in which the whole is about 1 across: they work
//! the same at any scale and anywhere. They are rounded outwards, so that no shape is missed that
//! the f64 intersection would hit.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::builder::{self, Item};
use super::search::Shape;
use crate::math::all_three;

/// Children of a node.
pub(super) const WIDTH: usize = 8;

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
    #[inline]
    pub(super) fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
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
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Node {
    /// The first `len` are there.
    members: [Member; WIDTH],
    len: u8,
}

/// A box and what is in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Member {
    pub(super) min: Vec3,
    pub(super) max: Vec3,
    pub(super) child: Child,
}

/// What is in a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Child {
    /// A node.
    Node(u32),
    /// Shapes.
    Leaf { first: u32, count: u32 },
}

impl Bvh {
    /// A tree over shapes, by their numbers, but the few `listed` ones, with [`Shape::WIDTH`] of them in a
    /// leaf if a plane parts them, and the order in which its leaves have them.
    pub(super) fn new<S: Shape>(
        count: u32,
        shape: &(impl Fn(u32) -> S + Sync),
        listed: &[u32],
    ) -> (Self, Vec<u32>) {
        let nowhere = Bounds {
            min: DVec3::INFINITY,
            max: DVec3::NEG_INFINITY,
        };
        let bounds = (0..count).into_par_iter().map(|index| {
            if listed.contains(&index) {
                nowhere
            } else {
                shape(index).bounds()
            }
        });
        let whole = bounds.reduce(|| nowhere, Bounds::union);
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
            let Bounds { min, max } = shape(index).bounds();
            let (min, max) = (tree.to_frame(min), tree.to_frame(max));
            Item::new(rounded_down(min), rounded_up(max), index)
        });
        let mut items: Vec<Item> = items.collect();
        for &index in listed.iter().rev() {
            items.swap_remove(index as usize);
        }
        let (nodes, order) = builder::build(items, S::WIDTH);
        tree.nodes = nodes;
        (tree, order)
    }

    /// Into the frame in which the whole tree is about 1 across.
    #[inline]
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

    /// Middle of the tree's frame in world space.
    pub(super) fn center(&self) -> DVec3 {
        self.center
    }
}

impl Node {
    /// Nothing yet.
    pub(super) const EMPTY: Self = Self {
        members: [Member {
            min: Vec3::INFINITY,
            max: Vec3::NEG_INFINITY,
            child: Child::Leaf { first: 0, count: 0 },
        }; WIDTH],
        len: 0,
    };

    /// One more box; there are at most [`WIDTH`].
    pub(super) fn push(&mut self, member: Member) {
        self.members[usize::from(self.len)] = member;
        self.len += 1;
    }

    /// The boxes that are there.
    #[inline]
    pub(super) fn members(&self) -> &[Member] {
        &self.members[..usize::from(self.len)]
    }

    /// The boxes that are there.
    #[inline]
    pub(super) fn members_mut(&mut self) -> &mut [Member] {
        &mut self.members[..usize::from(self.len)]
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
