//! Shapes as shafts meet them: convex sets, in f64.

use crate::math::DVec3;
use crate::visibility::tree::HalfSpace;

/// The size of what a shape or a shaft is off by, over the largest coordinates that go into it: rays that are
/// computed in f64 from its corners are within a few hundred roundings of the shaft. What is nearer to a border
/// than this is on neither side.
pub(super) const MARGIN: f64 = 1.0 / (1_u64 << 40) as f64;

/// One shape.
#[derive(Clone, Copy, Debug)]
pub(super) enum Solid {
    Sphere { center: DVec3, radius: f64 },
    Triangle([DVec3; 3]),
    Plane { point: DVec3, normal: DVec3 },
}

/// A corner of a shaft: the segment from `start` to `start + way`, or without end in that direction.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CornerRay {
    pub(super) start: DVec3,
    pub(super) way: DVec3,
    pub(super) is_endless: bool,
}

impl CornerRay {
    fn size(&self) -> f64 {
        self.start.abs().max_element() + self.way.abs().max_element()
    }
}

/// Where the plane of a flat shape is from a corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Above,
    Below,
    Unclear,
}

impl Side {
    fn of(height: f64, room: f64) -> Self {
        if height > room {
            Self::Above
        } else if height < -room {
            Self::Below
        } else {
            Self::Unclear
        }
    }
}

impl Solid {
    /// The largest coordinate.
    fn size(&self) -> f64 {
        match *self {
            Self::Sphere { center, radius } => center.abs().max_element() + radius,
            Self::Triangle([a, b, c]) => a.abs().max(b.abs()).max(c.abs()).max_element(),
            Self::Plane { point, .. } => point.abs().max_element(),
        }
    }

    /// The least and the largest n·x of its points.
    fn reach(&self, normal: DVec3) -> [f64; 2] {
        match *self {
            Self::Sphere { center, radius } => {
                let (middle, half) = (normal.dot(center), normal.length() * radius);
                [middle - half, middle + half]
            }
            Self::Triangle(corners) => {
                let [a, b, c] = corners.map(|corner| normal.dot(corner));
                [a.min(b).min(c), a.max(b).max(c)]
            }
            Self::Plane { .. } => [f64::NEG_INFINITY, f64::INFINITY],
        }
    }

    /// The least depth of its points.
    pub(super) fn nearest(&self, along: DVec3) -> f64 {
        let [least, _] = self.reach(along);
        least - MARGIN * self.size() * 3.0
    }

    /// The largest depth of its points.
    pub(super) fn farthest(&self, along: DVec3) -> f64 {
        let [_, most] = self.reach(along);
        most + MARGIN * self.size() * 3.0
    }

    /// A point of a flat shape, and a normal of any length.
    fn flat(&self) -> Option<[DVec3; 2]> {
        match *self {
            Self::Sphere { .. } => None,
            Self::Triangle([a, b, c]) => Some([a, (b - a).cross(c - a)]),
            Self::Plane { point, normal } => Some([point, normal]),
        }
    }

    /// Of a flat shape, on which side of its plane a point clearly is.
    fn side(&self, [point, normal]: [DVec3; 2], of: DVec3) -> Side {
        let room = (self.size() + of.abs().max_element()) * MARGIN;
        Side::of(normal.dot(of - point), room * normal.abs().element_sum())
    }

    /// Whether it is certain that no ray of a shaft meets it: all of it is on the outer side of a half-space, or
    /// all of the shaft on one side of its plane.
    pub(super) fn is_beside(
        &self,
        half_spaces: &[HalfSpace],
        corners: &[CornerRay],
        size: f64,
    ) -> bool {
        let room = (self.size() + size) * MARGIN * 3.0;
        let is_outside = half_spaces.iter().any(|half_space| {
            let [_, most] = self.reach(half_space.normal);
            most < half_space.offset - room * half_space.normal.abs().max_element()
        });
        is_outside || self.flat().is_some_and(|flat| self.is_off(flat, corners))
    }

    /// Whether all corners are on one side of the plane.
    fn is_off(&self, flat: [DVec3; 2], corners: &[CornerRay]) -> bool {
        let [_, normal] = flat;
        let Some(first) = corners.first() else {
            return false;
        };
        let side = self.side(flat, first.start);
        side != Side::Unclear
            && corners.iter().all(|corner| {
                let end = if corner.is_endless {
                    let room = corner.way.abs().max_element() * MARGIN;
                    Side::of(normal.dot(corner.way), room * normal.abs().element_sum())
                } else {
                    self.side(flat, corner.start + corner.way)
                };
                self.side(flat, corner.start) == side && end == side
            })
    }

    /// Where at most a corner of a shaft enters it, as a part of the way; `None` if it is not certain that it
    /// does, from outside and before its end, with room for every ray that is rounded.
    ///
    /// For a point p and a convex set K, the set of all q whose segment from p meets K is convex: of p + s (k − p)
    /// and p + s′ (k′ − p), with s and s′ at least 1, every mean is p + s″ (k″ − p) with s″ ≥ 1 and k″ a
    /// mean of k and k′. So if all corners of one box see all those of another through K, all points see all
    /// points through it. The same holds of the directions of rays from one point (between two depths: the
    /// harmonic mean of two depths is one), and of the starts of parallel ones.
    pub(super) fn enters(&self, corner: &CornerRay) -> Option<f64> {
        let room = (self.size() + corner.size()) * MARGIN;
        let at = match *self {
            Self::Sphere { center, radius } => enters_sphere(corner, center, radius, room),
            Self::Triangle(corners) => {
                let flat = self.flat()?;
                passes_between(corner, corners, room).then_some(())?;
                enters_plane(corner, flat, room)
            }
            Self::Plane { point, normal } => enters_plane(corner, [point, normal], room),
        }?;
        (corner.is_endless || at < 1.0).then_some(at)
    }

    /// Whether all of `other` is beyond the plane of this one as seen from the shaft.
    pub(super) fn is_before(&self, other: &Self, corners: &[CornerRay]) -> bool {
        let Some(flat) = self.flat() else {
            return false;
        };
        let Some(corner) = corners.first() else {
            return false;
        };
        let [point, normal] = flat;
        let from = match self.side(flat, corner.start) {
            Side::Above => normal,
            Side::Below => -normal,
            Side::Unclear => return false,
        };
        let [_, most] = other.reach(from);
        let room = (self.size() + other.size()) * MARGIN * from.abs().element_sum();
        most < from.dot(point) - room
    }

    /// Whether it is flat, and all of `front` is on the side of its plane that the shaft comes from.
    pub(super) fn is_beyond(&self, front: &Self, corners: &[CornerRay]) -> bool {
        let (Some(flat), Some(corner)) = (self.flat(), corners.first()) else {
            return false;
        };
        let [point, normal] = flat;
        let side = self.side(flat, corner.start);
        let from = match side {
            Side::Above => normal,
            Side::Below => -normal,
            Side::Unclear => return false,
        };
        let [least, _] = front.reach(from);
        let room = (self.size() + front.size()) * MARGIN * from.abs().element_sum();
        least > from.dot(point) + room
            && corners
                .iter()
                .all(|corner| self.side(flat, corner.start) == side)
    }

    /// Of a flat shape, where a corner ray comes through its plane as a part of the way from `origin`, at least:
    /// negative behind it. `None` where that is not clear.
    pub(super) fn crosses(&self, origin: DVec3, way: DVec3) -> Option<f64> {
        let flat = self.flat()?;
        let [point, normal] = flat;
        let room = (self.size() + origin.abs().max_element() + way.abs().max_element()) * MARGIN;
        let room = room * normal.abs().element_sum();
        let (height, speed) = (normal.dot(point - origin), normal.dot(way));
        let is_clear = height.abs() > room && speed.abs() > room;
        is_clear.then(|| {
            let at = height / speed;
            let least = at - (room / speed).abs() * (1.0 + at.abs());
            // Whether it is before the origin or behind is clear from the signs.
            if at > 0.0 {
                least.max(0.0)
            } else {
                at.min(-0.0)
            }
        })
    }
}

/// The ball that is smaller by the room is entered before the end, from outside of the one that is larger by it.
fn enters_sphere(corner: &CornerRay, center: DVec3, radius: f64, room: f64) -> Option<f64> {
    let oc = center - corner.start;
    let square = corner.way.length_squared();
    let small = radius - 3.0 * room;
    let along = oc.dot(corner.way) / square;
    let across = (oc - corner.way * along).length();
    let is_outside = oc.length() > radius + 3.0 * room;
    if !(is_outside && small > 0.0 && across < small && along > 0.0) {
        return None;
    }
    let half = ((small - across) * (small + across) / square).sqrt();
    // Rounding of the way's length over the sphere is within the room.
    Some(along - half + room / square.sqrt())
}

/// The start is clearly before the plane, and the end, or the direction, clearly beyond.
fn enters_plane(corner: &CornerRay, [point, normal]: [DVec3; 2], room: f64) -> Option<f64> {
    let room = room * normal.abs().element_sum();
    let height = normal.dot(corner.start - point);
    let speed = normal.dot(corner.way);
    let is_through = if height > 0.0 {
        speed < -room
    } else {
        speed > room
    };
    if !(is_through && height.abs() > room) {
        return None;
    }
    let at = -height / speed;
    Some(at + (room / speed).abs() * (1.0 + at))
}

/// Whether a corner's line passes between a triangle's edges, clear of all three.
fn passes_between(corner: &CornerRay, corners: [DVec3; 3], room: f64) -> bool {
    let [a, b, c] = corners.map(|vertex| vertex - corner.start);
    let volume = |p: DVec3, q: DVec3| {
        let (volume, edge) = (corner.way.dot(p.cross(q)), q - p);
        // Either end of the edge, and the line, may be beside where they are by the room.
        let sizes = corner.way.length() * (p.length() + q.length() + edge.length());
        Side::of(volume, sizes * room)
    };
    let sides = [volume(a, b), volume(b, c), volume(c, a)];
    sides[0] != Side::Unclear && sides.iter().all(|&side| side == sides[0])
}
