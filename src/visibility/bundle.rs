//! All rays of a batch at once.

use super::bvh::Bounds;
use crate::math::DVec3;

/// What the rays r(t) = o + t ω of a batch have in common: boxes around all o and around all ω,
/// and the range of t. Interval arithmetic tells which boxes none of them can meet.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bundle {
    origins: Bounds,
    directions: Bounds,
    /// The largest t. The smallest is 0.
    limit: f64,
}

impl Bundle {
    /// Rays whose origins and directions lie within these ranges.
    pub(super) fn new(origins: [DVec3; 2], directions: [DVec3; 2], limit: f64) -> Self {
        let bounds = |[min, max]: [DVec3; 2]| Bounds { min, max };
        Self {
            origins: bounds(origins),
            directions: bounds(directions),
            limit,
        }
    }

    /// The same rays in a frame that is moved by −`center` and then scaled.
    pub(super) fn in_frame(&self, center: DVec3, scale: f64) -> Self {
        let scaled = |bounds: Bounds, center: DVec3| Bounds {
            min: (bounds.min - center) * scale,
            max: (bounds.max - center) * scale,
        };
        Self {
            origins: scaled(self.origins, center),
            directions: scaled(self.directions, DVec3::ZERO),
            limit: self.limit,
        }
    }

    /// The largest coordinate of an origin, by magnitude.
    pub(super) fn reach(&self) -> f64 {
        self.origins.reach()
    }

    /// Whether any of the rays could meet the box. For each axis the parameters at which some ray
    /// is within the box's extent lie in one interval; where these have no t in common, none does.
    pub(super) fn may_meet(&self, bounds: &Bounds) -> bool {
        let lower = bounds.min - self.origins.max;
        let upper = bounds.max - self.origins.min;
        let mut from = 0.0_f64;
        let mut to = self.limit;
        for axis in 0..3 {
            let (lower, upper) = (lower[axis], upper[axis]);
            let (slowest, fastest) = (self.directions.min[axis], self.directions.max[axis]);
            // t ω ≥ lower for some ω, and t ω ≤ upper for some ω.
            if lower > 0.0 {
                if fastest <= 0.0 {
                    return false;
                }
                from = from.max(lower / fastest);
            } else if fastest < 0.0 {
                to = to.min(lower / fastest);
            }
            if upper < 0.0 {
                if slowest >= 0.0 {
                    return false;
                }
                from = from.max(upper / slowest);
            } else if slowest > 0.0 {
                to = to.min(upper / slowest);
            }
        }
        from <= to
    }

    /// How far along the middle of the rays the middle of a box is, for putting boxes in order.
    pub(super) fn distance_along(&self, bounds: &Bounds) -> f64 {
        let middle = |bounds: &Bounds| bounds.min * 0.5 + bounds.max * 0.5;
        (middle(bounds) - middle(&self.origins)).dot(middle(&self.directions))
    }
}
