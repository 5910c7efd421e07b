//! A bounding volume hierarchy over boxes, whatever is in them: built, made wide, and met by beams of rays.

mod beam;
mod bounds;
mod builder;
mod bvh;
mod node;
mod ray;
mod stack;
mod wide;

pub(in crate::visibility) use beam::Beam;
pub(in crate::visibility) use bounds::Bounds;
pub(in crate::visibility) use ray::{Approach, TreeRay};
pub(in crate::visibility) use stack::{EMPTY_STACK, Stack};
pub(in crate::visibility) use wide::{BlockRange, Tree, blocks_of};
