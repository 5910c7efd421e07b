//! The boxes of a tree that wait to be opened.

use super::node::WIDTH;

/// A box that is to be opened.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct Entry {
    /// A node, or the first block of the shapes.
    pub(in crate::visibility) child: u32,
    /// How many shapes; 0 for a node.
    pub(in crate::visibility) count: u32,
    /// The smallest t at which a ray enters, in the tree's frame.
    pub(in crate::visibility) at: f32,
}

/// A part's tree is at most 64 nodes deep, and the one over 2³² parts at most 11.
const DEEPEST: usize = 64 + 11;

/// Boxes that wait to be opened at most: each node leaves 7 behind.
pub(super) const STACK: usize = DEEPEST * (WIDTH - 1) + 2 * WIDTH;

/// Boxes that wait to be opened.
pub(in crate::visibility) type Stack = [Entry; STACK];

/// No boxes.
pub(in crate::visibility) const EMPTY_STACK: Stack = [Entry {
    child: 0,
    count: 0,
    at: 0.0,
}; STACK];
