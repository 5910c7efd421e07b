//! L4: V(p), whether something stands strictly between p and p_L.
//!
//! Surfaces have two sides and no thickness. The segment p p_L passes through one where its ends
//! lie strictly on different sides, or, for a sphere, where both are outside and its middle is
//! not. Asking for sides, and not for a ray parameter above some epsilon, makes the answer
//! independent of the scene's size.
//!
//! "Strictly" needs care only where an end lies on the surface: p on a coincident duplicate, at a
//! shared edge, where spheres touch; p_L on a wall. An end is on a surface where its distance is
//! not larger than what the rounding of what was written alone can make it, see [`ROUNDING`].

use super::camera::Ray;
use super::surface::{barycentric, is_in_rectangle};
use super::vector::{Vector, WideVector, add, dot, length, narrowed, scale, subtract, unit};
use super::wide::{Real, Wide};

/// How far coordinates that were meant to be on a surface may be off it, in units of ε = 2⁻⁵² times their
/// magnitude. They were computed by whoever wrote the scene: half an ε for each coordinate as written, and some
/// operations before. What is computed here is exact beside that.
const ROUNDING: f64 = 16.0;

/// The same for a light, of which each coordinate counts as far as it is across the surface: one that is 1e-15 m
/// above a floor at y = 0 is above it, wherever along the floor it is.
const ROUNDING_OF_LIGHT: f64 = 8.0;

/// The segment from a shaded point to a light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segment {
    /// p
    pub(super) from: WideVector,
    /// p_L
    pub(super) to: WideVector,
    /// |p| + |a|: the size of the coordinates that p is made of, relative to the eye.
    pub(super) magnitude: f64,
    /// Where the oracle's origin is in the scene.
    pub(super) reference: WideVector,
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
    pub(super) fn vector(&self) -> WideVector {
        subtract(self.to, self.from)
    }

    /// The line that it is a part of, from p on; `None` of no length.
    pub(super) fn line(&self) -> Option<Ray> {
        let direction = unit(self.vector())?;
        Some(Ray {
            origin: self.from,
            direction,
        })
    }

    /// Whether light and point are at one place, as far as f64 can tell: d = 0.
    pub(super) fn is_a_point(&self) -> bool {
        length(self.vector()).narrow() <= ROUNDING * f64::EPSILON * length(self.from).narrow()
    }

    /// The side on which p is, from its distance to a surface of this `magnitude`.
    fn side_of_point(&self, distance: Wide, magnitude: f64) -> Side {
        side(
            distance.narrow(),
            ROUNDING * f64::EPSILON * (self.magnitude + magnitude),
        )
    }

    /// A point's coordinates, as written or relative to the eye, whichever is smaller.
    fn sizes(&self, point: WideVector) -> Vector {
        let written = narrowed(add(point, self.reference));
        let relative = narrowed(point);
        [0, 1, 2].map(|axis| written[axis].abs().min(relative[axis].abs()))
    }

    /// The side on which p_L is, from its distance to a surface along the `normal` there, whose own coordinates
    /// are of this size across it.
    fn side_of_light(&self, distance: Wide, normal: Vector, size: f64) -> Side {
        let across = size_across(normal, self.sizes(self.to)) + size;
        side(distance.narrow(), ROUNDING_OF_LIGHT * f64::EPSILON * across)
    }

    /// The sides of the plane through `point` on which p and p_L are.
    pub(super) fn sides_of_plane(
        &self,
        point: WideVector,
        normal: WideVector,
        magnitude: f64,
    ) -> (Side, Side) {
        let distance = |end| dot(normal, subtract(end, point));
        let (size, across) = (self.sizes(point), narrowed(normal));
        let far = dot(normal, point).narrow().abs();
        let size = size_across(across, size).min(far);
        (
            self.side_of_point(distance(self.from), magnitude),
            self.side_of_light(distance(self.to), across, size),
        )
    }

    /// The sides of a sphere on which p and p_L are.
    pub(super) fn sides_of_sphere(
        &self,
        center: WideVector,
        radius: Wide,
        magnitude: f64,
    ) -> (Side, Side) {
        let distance = |end| length(subtract(end, center)) - radius;
        let outwards = unit(subtract(self.to, center)).map_or([0.0; 3], narrowed);
        (
            self.side_of_point(distance(self.from), magnitude),
            self.side_of_light(distance(self.to), outwards, magnitude),
        )
    }
}

/// The size of coordinates across a surface.
fn size_across(normal: Vector, sizes: Vector) -> f64 {
    (0..3).map(|axis| normal[axis].abs() * sizes[axis]).sum()
}

/// The side that a distance means, if it is larger than `rounding`.
fn side(distance: f64, rounding: f64) -> Side {
    if distance.abs() <= rounding {
        Side::On
    } else if distance > 0.0 {
        Side::Above
    } else {
        Side::Below
    }
}

/// L4, plane: the part of the way from p to p_L at which the plane stands between, if it does.
pub(super) fn plane_between(
    segment: &Segment,
    point: WideVector,
    normal: WideVector,
    magnitude: f64,
) -> Option<f64> {
    match segment.sides_of_plane(point, normal, magnitude) {
        (Side::Above, Side::Below) | (Side::Below, Side::Above) => {
            let height = dot(normal, subtract(segment.from, point)).narrow().abs();
            let depth = dot(normal, subtract(segment.to, point)).narrow().abs();
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
    vertices: &[WideVector; 3],
    normal: WideVector,
    magnitude: f64,
) -> Option<f64> {
    let part = plane_between(segment, vertices[0], normal, magnitude)?;
    barycentric(segment.from, segment.vector(), vertices)?;
    Some(part)
}

/// L4, rectangle: its plane stands between, and the segment passes inside its sides.
pub(super) fn rectangle_between(
    segment: &Segment,
    center: WideVector,
    normal: WideVector,
    halves: &[WideVector; 2],
    magnitude: f64,
) -> Option<f64> {
    let part = plane_between(segment, center, normal, magnitude)?;
    is_in_rectangle(from_center(segment, center, normal), halves).then_some(part)
}

/// L4, disk: its plane stands between, and the segment passes within its radius.
pub(super) fn disk_between(
    segment: &Segment,
    center: WideVector,
    normal: WideVector,
    radius: Wide,
    magnitude: f64,
) -> Option<f64> {
    let part = plane_between(segment, center, normal, magnitude)?;
    (length(from_center(segment, center, normal)) <= radius).then_some(part)
}

/// Where the line of a segment meets a plane, seen from a point of that.
fn from_center(segment: &Segment, center: WideVector, normal: WideVector) -> WideVector {
    let (from, way) = (subtract(segment.from, center), segment.vector());
    subtract(from, scale(way, dot(normal, from) / dot(normal, way)))
}

/// L4, sphere: the part of the way from p to p_L at which the sphere first stands between, if it
/// does. `own` says that p is on this sphere and the side from which the viewer sees it.
pub(super) fn sphere_between(
    segment: &Segment,
    center: WideVector,
    radius: Wide,
    magnitude: f64,
    own: Option<OwnSphere>,
) -> Option<f64> {
    let zero = Wide::from(0.0);
    let (m, k) = (subtract(segment.from, center), subtract(segment.to, center));
    let way = segment.vector();
    let (from, to) = segment.sides_of_sphere(center, radius, magnitude);
    let from = own.map_or(from, |_| Side::On);
    let starts_inwards = match own {
        Some(OwnSphere { starts_inwards }) => starts_inwards,
        None => dot(m, way) < zero,
    };
    let ends_outwards = dot(k, way) > zero;

    // Half the chord that the sphere cuts from the line, around the line's middle; measured from
    // the nearer end, where rounding errors are smaller.
    let squared = dot(way, way);
    let middle = -dot(m, way) / squared;
    let nearer = if length(m) <= length(k) { m } else { k };
    let across = length(subtract(nearer, scale(way, dot(nearer, way) / squared)));
    let inside = across < radius;
    let half_chord = if inside {
        ((radius - across) * (radius + across) / squared).sqrt()
    } else {
        zero
    };
    let entry = (middle - half_chord).narrow().clamp(0.0, 1.0);
    let exit = (middle + half_chord).narrow().clamp(0.0, 1.0);

    match (from, to) {
        (Side::Above, Side::Above) => (starts_inwards && ends_outwards && inside).then_some(entry),
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
