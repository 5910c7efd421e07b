//! L4: V(p), whether something stands strictly between p and p_L.
//!
//! Surfaces have two sides and no thickness. The segment p p_L passes through one where its ends
//! lie strictly on different sides, or, for a sphere, where both are outside and its middle is
//! not. Asking for sides, and not for a ray parameter above some epsilon, makes the answer
//! independent of the scene's size.
//!
//! "Strictly" needs care only where an end lies on the surface: p on a coincident duplicate, at a
//! shared edge, where spheres touch; p_L on a wall. An end is on a surface where its distance is
//! not larger than what rounding alone can make it, see [`ROUNDING`].

use super::surface::barycentric;
use super::vector::{Vector, dot, length, scale, subtract};

/// How far rounding can move a computed point off its surface, in units of ε = 2⁻⁵² times the
/// magnitude of the coordinates that go into it.
///
/// With u = ε/2, M = |p| + |a|, and |o|, t ≤ |p|: in t = n·(a − o) / n·ω the numerator is off by
/// 4u M, the denominator by 3u, the quotient by u more, which moves o + t ω off the plane by 8u M;
/// the sum itself by 2u |p|. Measuring n'·(p − a') for another surface is off by 4u M', and a unit
/// normal by 4u. In all 18u (M + M') = 9 ε (M + M'), and up to half an ε for each coordinate as
/// written; 16 leaves room for the normals of triangles.
const ROUNDING: f64 = 16.0;

/// The segment from a shaded point to a light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// p
    pub(super) from: Vector,
    /// p_L
    pub(super) to: Vector,
    /// |p| + |a|: the size of the coordinates that p was computed from.
    pub(super) magnitude: f64,
    /// How far the oracle's origin is from the scene's: written coordinates are rounded there.
    pub(super) reference: f64,
}

/// Where a point is relative to a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Side {
    /// Inside the sphere, or where the normal does not point.
    Below,
    /// On it, as far as f64 can tell.
    On,
    /// Outside the sphere, or where the normal points.
    Above,
}

impl Segment {
    /// p_L − p
    pub(super) fn vector(&self) -> Vector {
        subtract(self.to, self.from)
    }

    /// Whether light and point are at one place, as far as f64 can tell: d = 0.
    pub(super) fn is_a_point(&self) -> bool {
        length(self.vector()) <= self.rounding(self.magnitude + length(self.to))
    }

    /// What rounding alone can make of a distance 0 between points of this `magnitude`.
    fn rounding(&self, magnitude: f64) -> f64 {
        ROUNDING * f64::EPSILON * (magnitude + self.reference)
    }

    fn side(&self, distance: f64, magnitude: f64) -> Side {
        if distance.abs() <= self.rounding(magnitude) {
            Side::On
        } else if distance > 0.0 {
            Side::Above
        } else {
            Side::Below
        }
    }

    /// The sides of the plane through `point` on which p and p_L are.
    pub(super) fn sides_of_plane(&self, point: Vector, normal: Vector) -> (Side, Side) {
        let distance = |end| dot(normal, subtract(end, point));
        self.sides(distance, length(point))
    }

    /// The sides of a sphere on which p and p_L are.
    fn sides_of_sphere(&self, center: Vector, radius: f64) -> (Side, Side) {
        let distance = |end| length(subtract(end, center)) - radius;
        self.sides(distance, length(center) + radius)
    }

    /// The sides of a surface on which p and p_L are, from their signed distances to it and its
    /// own `magnitude`.
    fn sides(&self, distance: impl Fn(Vector) -> f64, magnitude: f64) -> (Side, Side) {
        (
            self.side(distance(self.from), self.magnitude + magnitude),
            self.side(distance(self.to), length(self.to) + magnitude),
        )
    }
}

/// L4, plane: the part of the way from p to p_L at which the plane stands between, if it does.
pub(super) fn plane_between(segment: &Segment, point: Vector, normal: Vector) -> Option<f64> {
    match segment.sides_of_plane(point, normal) {
        (Side::Above, Side::Below) | (Side::Below, Side::Above) => {
            let height = dot(normal, subtract(segment.from, point)).abs();
            let depth = dot(normal, subtract(segment.to, point)).abs();
            Some(height / (height + depth))
        }
        (Side::On, _) | (_, Side::On) | (Side::Above, Side::Above) | (Side::Below, Side::Below) => {
            None
        }
    }
}

/// L4, triangle: its plane stands between, and the segment passes inside its edges.
pub(super) fn triangle_between(
    segment: &Segment,
    vertices: &[Vector; 3],
    normal: Vector,
) -> Option<f64> {
    let part = plane_between(segment, vertices[0], normal)?;
    // Seen from the end that has the smaller coordinates, and so the smaller rounding errors:
    // p may lie near the horizon, p_L as far as the sun.
    let origin = if length(segment.from) <= length(segment.to) {
        segment.from
    } else {
        segment.to
    };
    barycentric(origin, segment.vector(), vertices)?;
    Some(part)
}

/// L4, sphere: the part of the way from p to p_L at which the sphere first stands between, if it
/// does. `own` says that p is on this sphere and the side from which the viewer sees it.
pub(super) fn sphere_between(
    segment: &Segment,
    center: Vector,
    radius: f64,
    own: Option<OwnSphere>,
) -> Option<f64> {
    let (m, k) = (subtract(segment.from, center), subtract(segment.to, center));
    let way = segment.vector();
    let (from, to) = segment.sides_of_sphere(center, radius);
    let from = own.map_or(from, |_| Side::On);
    let starts_inwards = match own {
        Some(OwnSphere { starts_inwards }) => starts_inwards,
        None => dot(m, way) < 0.0,
    };
    let ends_outwards = dot(k, way) > 0.0;

    // Half the chord that the sphere cuts from the line, around the line's middle; measured from
    // the nearer end, where rounding errors are smaller.
    let squared = dot(way, way);
    let middle = -dot(m, way) / squared;
    let across = if length(m) <= length(k) {
        subtract(m, scale(way, dot(m, way) / squared))
    } else {
        subtract(k, scale(way, dot(k, way) / squared))
    };
    let across = length(across);
    let half_chord = ((radius - across).max(0.0) * (radius + across) / squared).sqrt();
    let entry = (middle - half_chord).clamp(0.0, 1.0);
    let exit = (middle + half_chord).clamp(0.0, 1.0);

    match (from, to) {
        (Side::Above, Side::Above) => {
            (starts_inwards && ends_outwards && across < radius).then_some(entry)
        }
        (Side::Above, Side::Below) => Some(entry),
        (Side::Below, Side::Above) => Some(exit),
        (Side::On, Side::Above) => starts_inwards.then_some(exit),
        (Side::Above, Side::On) => ends_outwards.then_some(entry),
        // A sphere is convex: between two points in or on it there is nothing of it.
        (Side::Below | Side::On, Side::Below | Side::On) => None,
    }
}

/// That p is on the sphere itself, whatever rounding says.
#[derive(Clone, Copy, Debug)]
pub(super) struct OwnSphere {
    /// Whether the way to the light starts into the sphere.
    pub(super) starts_inwards: bool,
}
