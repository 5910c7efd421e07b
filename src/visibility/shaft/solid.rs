//! Shapes as shafts meet them: convex sets, in f64.

use crate::math::DVec3;
use crate::visibility::tree::HalfSpace;
use crate::world::Disk;

/// The size of what a shape or a shaft is off by, over the largest coordinates that go into it: rays that are
/// computed in f64 from its corners are within a few hundred roundings of the shaft. What is nearer to a border
/// than this is on neither side.
pub(super) const MARGIN: f64 = 1.0 / (1_u64 << 40) as f64;

/// One shape.
#[derive(Clone, Copy, Debug)]
pub(super) enum Solid {
    Sphere {
        center: DVec3,
        radius: f64,
    },
    Triangle([DVec3; 3]),
    Plane {
        point: DVec3,
        normal: DVec3,
    },
    Disk {
        center: DVec3,
        normal: DVec3,
        radius: f64,
    },
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

/// What all rays of a shaft have in common.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Common {
    /// The point that they start from, or end at.
    Point(DVec3),
    /// Their direction, a unit vector.
    Direction(DVec3),
    Nothing,
}

/// A cone around all rays from or to its tip.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    tip: DVec3,
    /// Unit vector.
    axis: DVec3,
    sine: f64,
    cosine: f64,
    /// How far from the tip the rays get; infinite where they have no end.
    length: f64,
}

impl Cone {
    /// Around corners; `None` where they are not all on one side of the tip.
    pub(super) fn around(tip: DVec3, corners: &[CornerRay]) -> Option<Self> {
        let ways = || corners.iter().map(|corner| corner.from(tip));
        let axis = ways()
            .map(DVec3::normalize_or_zero)
            .sum::<DVec3>()
            .try_normalize()?;
        let (mut cosine, mut length) = (1.0_f64, 0.0_f64);
        for (way, corner) in ways().zip(corners) {
            cosine = cosine.min(way.dot(axis) / way.length());
            let [start, end] = [corner.start, corner.start + corner.way].map(|at| at - tip);
            let reach = start.length().max(end.length());
            length = length.max(if corner.is_endless {
                f64::INFINITY
            } else {
                reach
            });
        }
        // Wider by what f64 does not tell.
        let cosine = cosine - MARGIN;
        (cosine > 0.0).then(|| Self {
            tip,
            axis,
            sine: (1.0 - cosine * cosine).sqrt(),
            cosine,
            length,
        })
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

    /// Whether both are clear and not the same.
    fn is_opposite(self, other: Self) -> bool {
        matches!(
            (self, other),
            (Self::Above, Self::Below) | (Self::Below, Self::Above)
        )
    }
}

impl Solid {
    pub(super) fn of_disk(disk: &Disk) -> Self {
        Self::Disk {
            center: disk.center.0,
            normal: disk.normal.get(),
            radius: disk.radius,
        }
    }

    /// The largest coordinate.
    fn size(&self) -> f64 {
        match *self {
            Self::Sphere { center, radius } | Self::Disk { center, radius, .. } => {
                center.abs().max_element() + radius
            }
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
            Self::Disk {
                center,
                normal: own,
                radius,
            } => {
                let (middle, half) = (normal.dot(center), normal.cross(own).length() * radius);
                [middle - half, middle + half]
            }
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
            Self::Disk { center, normal, .. } => Some([center, normal]),
        }
    }

    /// Of a flat shape, on which side of its plane a point clearly is.
    fn side(&self, [point, normal]: [DVec3; 2], of: DVec3) -> Side {
        let room = (self.size() + of.abs().max_element()) * MARGIN;
        Side::of(normal.dot(of - point), room * normal.abs().element_sum())
    }

    /// Whether it is a sphere, or a disk in one, that is certainly outside of a cone.
    pub(super) fn is_outside(&self, cone: &Cone, size: f64) -> bool {
        let (Self::Sphere { center, radius } | Self::Disk { center, radius, .. }) = *self else {
            return false;
        };
        let room = (self.size() + size) * MARGIN * 4.0;
        let way = center - cone.tip;
        let along = way.dot(cone.axis);
        let square = way.length_squared();
        let across = (square - along * along).max(0.0).sqrt();
        // The difference of squares may have lost half of its digits.
        let room_across = 1e-7 * square.sqrt() + room;
        let most = radius + room;
        across * cone.cosine - along * cone.sine > most + room_across
            || square.sqrt() - most > cone.length
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
            let most = match *self {
                // The normals of half-spaces are unit vectors.
                Self::Sphere { center, radius } => half_space.normal.dot(center) + radius,
                Self::Triangle(_) | Self::Plane { .. } | Self::Disk { .. } => {
                    self.reach(half_space.normal)[1]
                }
            };
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

    /// Whether all rays pass by it, on the outer side of a plane through what all rays have in common and an edge of a
    /// triangle, or a plane that is between the rays and a sphere, or the one around a disk.
    pub(super) fn is_passed(&self, common: Common, corners: &[CornerRay], size: f64) -> bool {
        let room = (self.size() + size) * MARGIN;
        match *self {
            Self::Triangle(vertices) => (0..3).any(|edge| {
                let edge = [0, 1, 2].map(|next| vertices[(edge + next) % 3]);
                passes_edge(common, corners, edge, room)
            }),
            Self::Sphere { center, radius } | Self::Disk { center, radius, .. } => {
                passes_ball(common, corners, center, radius, room)
            }
            Self::Plane { .. } => false,
        }
    }

    /// Whether rays without an end start inside of a sphere, so that all of them leave it.
    pub(super) fn is_around(&self, corners: &[CornerRay]) -> bool {
        let Self::Sphere { center, radius } = *self else {
            return false;
        };
        corners.iter().all(|corner| {
            let room = (self.size() + corner.size()) * MARGIN * 3.0;
            corner.is_endless && (corner.start - center).length() < radius - room
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
            Self::Disk {
                center,
                normal,
                radius,
            } => enters_disk(corner, [center, normal], radius, room),
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

/// The plane is entered within the rim, clear of it.
fn enters_disk(
    corner: &CornerRay,
    [center, normal]: [DVec3; 2],
    radius: f64,
    room: f64,
) -> Option<f64> {
    let latest = enters_plane(corner, [center, normal], room)?;
    let from_center = corner.start - center;
    let at = -normal.dot(from_center) / normal.dot(corner.way);
    // The line may be beside where it is by the room, and come through the plane so much sooner or later.
    let along = (latest - at) * corner.way.length();
    let beside = (from_center + corner.way * at).length();
    (beside + 2.0 * along + 4.0 * room < radius).then_some(latest)
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

impl CornerRay {
    /// From a point that its line goes through.
    fn from(&self, point: DVec3) -> DVec3 {
        if self.is_endless || self.start == point {
            self.way
        } else {
            self.start - point
        }
    }
}

/// Whether all rays are on the other side of the edge from a to b than c.
fn passes_edge(common: Common, corners: &[CornerRay], [a, b, c]: [DVec3; 3], room: f64) -> bool {
    let edge = (b - a).length();
    match common {
        Common::Point(point) => {
            let [a, b, c] = [a - point, b - point, c - point];
            let normal = a.cross(b);
            let ends = a.length() + b.length() + edge;
            // The edge and the end of the way may be beside where they are by the room.
            let of = |way: DVec3| {
                let room = room * (way.length() * ends + normal.length());
                Side::of(normal.dot(way), room)
            };
            let inner = of(c);
            let mut ways = corners.iter().map(|corner| corner.from(point));
            ways.all(|way| of(way).is_opposite(inner))
        }
        Common::Direction(direction) => {
            let normal = (b - a).cross(direction);
            let of = |point: DVec3| {
                let way = point - a;
                let room = room * (way.length() + edge + normal.length());
                Side::of(normal.dot(way), room)
            };
            let inner = of(c);
            corners
                .iter()
                .all(|corner| of(corner.start).is_opposite(inner))
        }
        Common::Nothing => false,
    }
}

/// Whether a ball is beyond a plane that all rays are before.
fn passes_ball(
    common: Common,
    corners: &[CornerRay],
    center: DVec3,
    radius: f64,
    room: f64,
) -> bool {
    match common {
        Common::Point(point) => {
            let to_center = center - point;
            let middle: DVec3 = corners
                .iter()
                .map(|corner| corner.from(point).normalize())
                .sum();
            let Some(middle) = middle.try_normalize() else {
                return false;
            };
            let Some(aside) = to_center.reject_from_normalized(middle).try_normalize() else {
                return false;
            };
            // The plane through the point that just has all ways before it.
            let mut steepest = f64::NEG_INFINITY;
            for corner in corners {
                let way = corner.from(point);
                let along = way.dot(middle);
                let is_ahead = along > 0.0;
                if !is_ahead {
                    return false;
                }
                // A way that starts at the point is as exact as its length, another one as its end.
                let length = way.length();
                let error = if corner.is_endless {
                    MARGIN * length
                } else {
                    room
                };
                steepest = steepest.max((way.dot(aside) + 2.0 * error) / along);
            }
            let normal = aside - middle * steepest;
            to_center.dot(normal) > (radius + 2.0 * room) * normal.length()
        }
        Common::Direction(direction) => {
            let aside = (center - corners[0].start).reject_from_normalized(direction);
            let Some(aside) = aside.try_normalize() else {
                return false;
            };
            let far = |corner: &CornerRay| (center - corner.start).dot(aside) > radius + 4.0 * room;
            corners.iter().all(far)
        }
        Common::Nothing => false,
    }
}
