//! Boxes in world space.

use crate::math::DVec3;

/// A box in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::visibility) struct Bounds {
    pub(in crate::visibility) min: DVec3,
    pub(in crate::visibility) max: DVec3,
}

impl Bounds {
    /// Around nothing.
    pub(in crate::visibility) const NOWHERE: Self = Self {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    /// The smallest box around two boxes.
    #[inline]
    pub(in crate::visibility) fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }
}
