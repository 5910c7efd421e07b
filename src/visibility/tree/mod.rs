//! A bounding volume hierarchy over boxes, whatever is in them: built, made wide, and met by beams of rays.

mod around;
mod beam;
mod bounds;
mod builder;
mod bvh;
mod frame;
mod node;
mod packet;
mod parts;
mod ray;
mod shaft;
mod stack;
mod wide;

pub(in crate::visibility) use beam::Beam;
pub(in crate::visibility) use bounds::Bounds;
pub(in crate::visibility) use frame::TreeFrame;
pub(in crate::visibility) use packet::{Descents, PacketDescent};
pub(in crate::visibility) use parts::{PartTree, PlacedPart};
pub(in crate::visibility) use ray::{Approach, DESCENTS, Descent, Step, TreeRay};
pub(in crate::visibility) use shaft::{HalfSpace, MOST_SIDES, TreeVolume};
pub(in crate::visibility) use stack::{EMPTY_STACK, Stack};
pub(in crate::visibility) use wide::{BlockRange, Tree, blocks_of};
