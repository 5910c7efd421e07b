//! The frame of a tree.

use glam::{DVec3, Vec3};

use super::bounds::Bounds;
use crate::math::all_three;

/// The tree's frame is at most this power of two larger or smaller than the world: f32 boxes and
/// rays stay far from overflow.
const LARGEST_EXPONENT: i32 = 100;

/// In which the whole tree is about 1 across, around the origin: f32 does for its boxes at any scale and anywhere.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct TreeFrame {
    /// Its middle in world space.
    pub(in crate::visibility) center: DVec3,
    /// From lengths of the world to lengths of the frame: a power of two.
    pub(in crate::visibility) scale: f64,
}

impl TreeFrame {
    /// Around a box of the world.
    pub(in crate::visibility) fn around(whole: Bounds) -> Self {
        let size = (whole.max - whole.min).max_element();
        // Shapes smaller than the rounding of their place may have no size in common.
        let exponent = if size > 0.0 { libm::ilogb(size) } else { 0 };
        Self {
            center: whole.min * 0.5 + whole.max * 0.5,
            scale: libm::exp2(-f64::from(
                exponent.clamp(-LARGEST_EXPONENT, LARGEST_EXPONENT),
            )),
        }
    }

    /// The corners of a box of the world in the frame, rounded outwards.
    #[inline]
    pub(super) fn around_box(&self, Bounds { min, max }: Bounds) -> (Vec3, Vec3) {
        (
            rounded_down(self.of_world(min)),
            rounded_up(self.of_world(max)),
        )
    }

    #[inline]
    fn of_world(&self, position: DVec3) -> DVec3 {
        (position - self.center) * self.scale
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
