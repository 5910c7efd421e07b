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

/// Nodes without the members that they have not: mostly less than half is there.
#[derive(Debug)]
pub(super) struct PackedNodes {
    members: Box<[Member]>,
    lens: Box<[u8]>,
}

impl PackedNodes {
    pub(super) fn of(nodes: &[BuildNode]) -> Self {
        let members = nodes.iter().map(|node| node.members().len()).sum();
        let mut packed = Vec::with_capacity(members);
        packed.extend(nodes.iter().flat_map(BuildNode::members));
        Self {
            members: packed.into_boxed_slice(),
            lens: nodes.iter().map(|node| node.len).collect(),
        }
    }

    pub(super) fn len(&self) -> usize {
        self.lens.len()
    }

    /// Puts them at a place of the same length, of which `start` nodes come before in the whole tree.
    pub(super) fn unpack(&self, place: &mut [BuildNode], start: u32) {
        let mut members = self.members.iter();
        for (node, &len) in place.iter_mut().zip(&self.lens) {
            for &(mut member) in members.by_ref().take(usize::from(len)) {
                if let Child::Node(child) = &mut member.child {
                    *child += start;
                }
                node.push(member);
            }
        }
    }
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
