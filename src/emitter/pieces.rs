//! Convex pieces of an outline, cut by planes through the point, and what blockers do to them.

use std::ops::Range;

use super::clip::{SLACK, across, l1};
use super::conic::{Side, WholeCone};
use super::occluder::Blocker;
use crate::math::DVec3;

/// A piece is dropped that has less than this part of the area of all.
const SLIVER: f64 = 1e-16;

/// The corners of pieces, one piece after the other: against the clock, as they are seen from the point.
#[derive(Debug, Default)]
pub(super) struct Pieces {
    corners: Vec<DVec3>,
    /// Of the corners of the piece that is cut.
    heights: Vec<f64>,
    /// The square of the area below which pieces are dropped.
    sliver: f64,
    /// Two vectors along the plane of all pieces, and one across.
    axes: [DVec3; 3],
}

/// A rectangle in the plane of all pieces, as wide and as high as something is that is seen in front of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounds {
    least: [f64; 2],
    largest: [f64; 2],
}

impl Bounds {
    const ALL: Self = Self {
        least: [f64::NEG_INFINITY; 2],
        largest: [f64::INFINITY; 2],
    };

    pub(super) fn are_apart(&self, other: &Self) -> bool {
        self.least[0] >= other.largest[0]
            || other.least[0] >= self.largest[0]
            || self.least[1] >= other.largest[1]
            || other.least[1] >= self.largest[1]
    }
}

/// What a plane leaves of a piece.
pub(super) enum Split {
    Inside,
    Outside,
    /// Each has corners, unless it is so small that it is left out.
    Both {
        inside: Range<usize>,
        outside: Range<usize>,
    },
}

/// What a blocker does to a piece.
#[derive(Clone, Copy)]
pub(super) enum Effect {
    Nothing,
    /// It blocks all of it.
    All,
    /// A plane cuts it first.
    Cut(DVec3),
    /// It blocks what is within a cone.
    Within(WholeCone),
    /// It blocks what is not.
    Without(WholeCone),
    /// It blocks what is within a cone and not within another.
    Ring {
        cone: WholeCone,
        hole: WholeCone,
    },
}

impl Pieces {
    pub(super) fn clear(&mut self) {
        self.corners.clear();
    }

    /// The first piece.
    pub(super) fn take(&mut self, corners: &[DVec3]) -> Range<usize> {
        self.clear();
        self.corners.extend_from_slice(corners);
        let area = area(&self.corners);
        self.sliver = area.length_squared() * (SLIVER * SLIVER);
        let is_backwards = corners.first().is_some_and(|first| area.dot(*first) < 0.0);
        if is_backwards {
            self.corners.reverse();
        }
        let across = if is_backwards { -area } else { area };
        let along = corners.get(1).map_or(DVec3::ZERO, |to| to - corners[0]);
        self.axes = [along, across.cross(along), across];
        0..self.corners.len()
    }

    /// Around what is seen of a convex polygon; all, where not all of it is in front of the point, or where there is
    /// no polygon.
    pub(super) fn bounds_of(&self, corners: &[DVec3]) -> Bounds {
        let [x, y, z] = self.axes;
        let mut bounds = Bounds {
            least: [f64::INFINITY; 2],
            largest: [f64::NEG_INFINITY; 2],
        };
        for &corner in corners {
            let height = z.dot(corner);
            if height <= 0.0 {
                return Bounds::ALL;
            }
            let place = [x.dot(corner) / height, y.dot(corner) / height];
            for (axis, &place) in place.iter().enumerate() {
                bounds.least[axis] = bounds.least[axis].min(place);
                bounds.largest[axis] = bounds.largest[axis].max(place);
            }
        }
        if corners.is_empty() {
            return Bounds::ALL;
        }
        bounds
    }

    pub(super) fn corners(&self, piece: &Range<usize>) -> &[DVec3] {
        &self.corners[piece.clone()]
    }

    /// A plane through the point cuts a piece in two. Corners that are on it as numbers are rounded are on it.
    pub(super) fn split(&mut self, piece: &Range<usize>, plane: DVec3) -> Split {
        let scale = SLACK * l1(plane);
        let (mut least, mut largest) = (0.0_f64, 0.0_f64);
        self.heights.clear();
        for &corner in &self.corners[piece.clone()] {
            let height = plane.dot(corner);
            let is_on_it = height.abs() <= scale * l1(corner);
            let height = if is_on_it { 0.0 } else { height };
            (least, largest) = (least.min(height), largest.max(height));
            self.heights.push(height);
        }
        if least >= 0.0 {
            return Split::Inside;
        }
        if largest <= 0.0 {
            return Split::Outside;
        }
        let inside = self.clip(piece, 1.0);
        let outside = self.clip(piece, -1.0);
        Split::Both { inside, outside }
    }

    /// The corners of a piece where heights are not negative, times a sign; none of a sliver.
    fn clip(&mut self, piece: &Range<usize>, sign: f64) -> Range<usize> {
        let start = self.corners.len();
        let count = piece.len();
        for place in 0..count {
            let next = if place + 1 < count { place + 1 } else { 0 };
            let [from, to] = [place, next].map(|place| self.corners[piece.start + place]);
            let [height, next_height] = [place, next].map(|place| self.heights[place]);
            if sign * height >= 0.0 {
                self.corners.push(from);
            }
            // From the end where heights are positive, so that both sides have the same crossing.
            if height > 0.0 && next_height < 0.0 {
                let crossing = from + (to - from) * (height / (height - next_height));
                self.corners.push(crossing);
            } else if height < 0.0 && next_height > 0.0 {
                let crossing = to + (from - to) * (next_height / (next_height - height));
                self.corners.push(crossing);
            }
        }
        if area(&self.corners[start..]).length_squared() <= self.sliver {
            self.corners.truncate(start);
        }
        start..self.corners.len()
    }
}

/// Twice the area of a planar polygon, as a vector across it.
fn area(corners: &[DVec3]) -> DVec3 {
    let mut sum = DVec3::ZERO;
    if let [first, rest @ ..] = corners {
        for pair in rest.windows(2) {
            sum += (pair[0] - first).cross(pair[1] - first);
        }
    }
    sum
}

/// Whether none of some vectors is above a plane, as numbers are rounded.
fn are_below(plane: DVec3, corners: &[DVec3]) -> bool {
    let scale = SLACK * l1(plane);
    corners
        .iter()
        .all(|&corner| plane.dot(corner) <= scale * l1(corner))
}

/// Whether a piece has nothing within planes, and within the convex polygon around which they are, if there is one.
pub(super) fn are_apart(planes: &[DVec3], polygon: &[DVec3], corners: &[DVec3]) -> bool {
    if planes.iter().any(|&plane| are_below(plane, corners)) {
        return true;
    }
    let Some(&last) = corners.last() else {
        return true;
    };
    if polygon.is_empty() {
        return false;
    }
    let mut before = last;
    for &corner in corners {
        let plane = across(before, corner);
        // Planes through ends that are close to each other may be anywhere.
        if are_below(plane, polygon) && are_below(-plane, corners) {
            return true;
        }
        before = corner;
    }
    false
}

/// What a blocker does to a piece.
pub(super) fn effect_of(blocker: &Blocker, corners: &[DVec3]) -> Effect {
    let planes = blocker.planes();
    let polygon = blocker.corners.as_ref();
    let polygon = polygon.map_or(&[][..], |polygon| &polygon[..blocker.count]);
    if are_apart(planes, polygon, corners) {
        return Effect::Nothing;
    }
    let within = blocker
        .cone
        .map_or(Side::Inside, |cone| cone.side_of(corners));
    let hole = blocker
        .hole
        .map_or(Side::Outside, |hole| hole.side_of(corners));
    if within == Side::Outside || hole == Side::Inside {
        return Effect::Nothing;
    }
    if let Some(&plane) = planes.iter().find(|plane| !are_below(-**plane, corners)) {
        return Effect::Cut(plane);
    }
    let cone = blocker.cone.filter(|_| within == Side::Across);
    let hole = blocker.hole.filter(|_| hole == Side::Across);
    match (cone, hole) {
        (None, None) => Effect::All,
        (Some(cone), None) => Effect::Within(cone),
        (None, Some(hole)) => Effect::Without(hole),
        (Some(cone), Some(hole)) => Effect::Ring { cone, hole },
    }
}

/// A plane across the longest way through a piece, in the middle of its angle.
pub(super) fn longest(corners: &[DVec3]) -> DVec3 {
    let (mut longest, mut plane) = (0.0, DVec3::ZERO);
    for (place, from) in corners.iter().enumerate() {
        for to in &corners[place + 1..] {
            let apart = *from / from.length() - *to / to.length();
            let square = apart.length_squared();
            if square > longest {
                (longest, plane) = (square, apart);
            }
        }
    }
    plane
}
