//! Nodes of a tree that is being built.

use glam::Vec3;

/// Children of a node.
pub(in crate::visibility) const WIDTH: usize = 8;

/// Up to eight boxes and what is in them.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::visibility) struct BuildNode {
    /// The first `len` are there.
    members: [Member; WIDTH],
    len: u8,
}

/// A box and what is in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::visibility) struct Member {
    pub(in crate::visibility) min: Vec3,
    pub(in crate::visibility) max: Vec3,
    pub(in crate::visibility) child: Child,
}

/// What is in a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::visibility) enum Child {
    /// A node.
    Node(u32),
    /// Shapes.
    Leaf { first: u32, count: u32 },
}

impl BuildNode {
    /// Nothing yet.
    pub(in crate::visibility) const EMPTY: Self = Self {
        members: [Member {
            min: Vec3::INFINITY,
            max: Vec3::NEG_INFINITY,
            child: Child::Leaf { first: 0, count: 0 },
        }; WIDTH],
        len: 0,
    };

    /// One more box; there are at most [`WIDTH`].
    pub(in crate::visibility) fn push(&mut self, member: Member) {
        self.members[usize::from(self.len)] = member;
        self.len += 1;
    }

    /// The boxes that are there.
    #[inline]
    pub(in crate::visibility) fn members(&self) -> &[Member] {
        &self.members[..usize::from(self.len)]
    }

    /// The boxes that are there.
    #[inline]
    pub(in crate::visibility) fn members_mut(&mut self) -> &mut [Member] {
        &mut self.members[..usize::from(self.len)]
    }
}
