//! Planar polygons as they are seen from a point, and cut by planes through it.
//!
//! Corners are vectors from the point, in any unit, of lengths from 1e-70 to 1e70 of it. What is integrated over a
//! polygon does not depend on the sense in which they are written.

use crate::math::DVec3;

/// So many corners a polygon may have. Each cut adds one at most where it is convex.
pub(crate) const MOST_CORNERS: usize = 24;

/// A planar polygon, seen from the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Polygon {
    corners: [DVec3; MOST_CORNERS],
    count: usize,
}

impl Polygon {
    const NOTHING: Self = Self {
        corners: [DVec3::ZERO; MOST_CORNERS],
        count: 0,
    };

    /// `None` where there are more than [`MOST_CORNERS`], or one is not finite.
    pub(crate) fn new(corners: &[DVec3]) -> Option<Self> {
        if !corners.iter().all(|corner| corner.is_finite()) {
            return None;
        }
        let mut polygon = Self::NOTHING;
        polygon
            .corners
            .get_mut(..corners.len())?
            .copy_from_slice(corners);
        polygon.count = corners.len();
        Some(polygon)
    }

    pub(crate) fn corners(&self) -> &[DVec3] {
        &self.corners[..self.count]
    }

    /// What of it is where `inward · x ≥ 0`, cut by the plane through the point with this normal (Sutherland &
    /// Hodgman 1974). Of one that is not convex, parts may be joined by edges there and back on the plane, over
    /// which integrals cancel. `None` where that has more than [`MOST_CORNERS`].
    pub(crate) fn clipped(&self, inward: DVec3) -> Option<Self> {
        let mut clipped = Self::NOTHING;
        let mut is_full = false;
        for_each_clipped(self.corners(), inward, |corner| {
            match clipped.corners.get_mut(clipped.count) {
                Some(place) => {
                    *place = corner;
                    clipped.count += 1;
                }
                None => is_full = true,
            }
        });
        (!is_full).then_some(clipped)
    }
}

/// The corners of what is left of a polygon where `inward · x ≥ 0`, one by one.
#[inline(always)]
fn for_each_clipped(corners: &[DVec3], inward: DVec3, mut take: impl FnMut(DVec3)) {
    let Some(&last) = corners.last() else {
        return;
    };
    let mut before = last;
    let mut height_before = inward.dot(before);
    for &corner in corners {
        let height = inward.dot(corner);
        // From the end that is inside, so that two polygons with this edge have the same crossing.
        if height_before >= 0.0 && height < 0.0 {
            take(before + (corner - before) * (height_before / (height_before - height)));
        } else if height_before < 0.0 && height > 0.0 {
            take(corner + (before - corner) * (height / (height - height_before)));
        }
        if height >= 0.0 {
            take(corner);
        }
        (before, height_before) = (corner, height);
    }
}

/// The edges of what is left of a polygon where `inward · x ≥ 0`, one by one.
#[inline(always)]
pub(super) fn for_each_edge(corners: &[DVec3], inward: DVec3, mut take: impl FnMut(DVec3, DVec3)) {
    let mut first = None;
    let mut before = DVec3::ZERO;
    for_each_clipped(corners, inward, |corner| {
        if first.is_none() {
            first = Some(corner);
        } else {
            take(before, corner);
        }
        before = corner;
    });
    if let Some(first) = first {
        take(before, first);
    }
}

/// v₀ × v₁, from the edge between them, so that little cancels where it is short.
#[inline(always)]
pub(super) fn across(from: DVec3, to: DVec3) -> DVec3 {
    from.cross(to - from)
}

/// Corners that are so close to a plane, relative to their lengths, are on it: more than what corners and planes
/// are rounded by.
pub(super) const SLACK: f64 = 2e-15;

/// |x| + |y| + |z|
#[inline(always)]
pub(super) fn l1(vector: DVec3) -> f64 {
    vector.x.abs() + vector.y.abs() + vector.z.abs()
}
