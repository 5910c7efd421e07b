//! Light, and what it takes to know how well it is known.

use super::components::Components;

/// The light along a ray.
#[derive(Clone, Debug)]
pub(super) struct Light {
    pub(super) radiance: Components,
    /// How far that may be off.
    pub(super) error: Components,
    /// What would come from those lights with an area of which something hides a part, if nothing did.
    pub(super) unshadowed: Components,
}

impl Light {
    /// What no light with an area has a part in.
    pub(super) fn only(radiance: Components) -> Self {
        Self {
            error: radiance.zero(),
            unshadowed: radiance.zero(),
            radiance,
        }
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        Self {
            radiance: self.radiance.plus(&other.radiance),
            error: self.error.plus(&other.error),
            unshadowed: self.unshadowed.plus(&other.unshadowed),
        }
    }

    pub(super) fn times(&self, factor: &Components) -> Self {
        Self {
            radiance: self.radiance.times(factor),
            error: self.error.times(factor),
            unshadowed: self.unshadowed.times(factor),
        }
    }
}
