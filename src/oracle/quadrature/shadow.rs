//! L4 on the lines of a light: from where to where a surface stands between them and p.
//!
//! Whether it does changes only where the direction to a line passes an edge of the surface, or touches a sphere, or
//! where the line passes through the surface: at roots of linear and quadratic functions. Between these it is decided
//! once, by the rules of `occlusion`.

use super::super::fresnel;
use super::super::occlusion::{Segment, Side};
use super::super::surface::{Shape, Surface};
use super::super::vector::{
    Vector, WideVector, add, cross, dot, length, narrowed, scale, subtract,
};
use super::super::wide::{Real, Wide};
use super::curve::Curve;
use super::polynomial::quadratic;
use super::view::{Line, View, cosine};

/// Of bounds, relative: far more than f64 is off.
const ROOM: f64 = 1e-9;

/// Sines of angles within which a point is looked at as if it were on an edge.
const NEAR: f64 = 1e-7;

/// A surface that may stand between p and a light, relative to p.
#[derive(Clone, Debug)]
pub(super) struct Occluder {
    /// The index of its surface.
    pub(super) surface: usize,
    /// The rows of the light before which it may be.
    rows: [f64; 2],
    /// The same along the lines.
    columns: [f64; 2],
    /// Where it begins and ends on the light, and where it passes through the light.
    pub(super) curves: Vec<Curve>,
    shape: Between,
    /// What coordinates may be off by.
    room: f64,
    /// n of a pane, which lets light through.
    pane: Option<f64>,
}

#[derive(Clone, Debug)]
enum Between {
    Flat {
        normal: Vector,
        /// Of its plane along the normal; not 0.
        offset: f64,
        bounds: Bounds,
    },
    Ball {
        center: Vector,
        radius: f64,
        /// ‖center‖² − radius²
        power: f64,
        /// Where p is.
        side: Side,
    },
}

/// What of a plane there is.
#[derive(Clone, Debug)]
enum Bounds {
    All,
    /// Where all these functions of the direction are above 0: planes through p and the edges.
    Edges(Vec<Vector>),
    Round {
        center: Vector,
        radius: f64,
    },
}

/// How far something is seen to extend, from 0 in the middle of the light to ±1 at its ends: across lines, and along
/// them.
type Extents = [[f64; 2]; 2];

const EVERYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

impl Occluder {
    /// A surface, if it may be between. `is_own` says that p is on it.
    pub(super) fn new(
        index: usize,
        surface: &Surface,
        segment: &Segment,
        is_own: bool,
        view: &View,
    ) -> Option<Self> {
        let relative = |point: WideVector| subtract(point, segment.from);
        let magnitude = surface.shape.magnitude();
        let room = view.room + 16.0 * f64::EPSILON * (segment.magnitude + magnitude);
        let plane = |point: WideVector, normal: WideVector| {
            let (side, _) = segment.sides_of_plane(point, normal, magnitude);
            let offset = dot(normal, relative(point)).narrow();
            (!is_own && side != Side::On && offset != 0.0).then_some((narrowed(normal), offset))
        };
        let (shape, extents) = match &surface.shape {
            Shape::Plane { point, normal } => {
                let (normal, offset) = plane(*point, *normal)?;
                let bounds = Bounds::All;
                let shape = Between::Flat {
                    normal,
                    offset,
                    bounds,
                };
                (shape, [EVERYWHERE; 2])
            }
            Shape::Triangle {
                vertices, normal, ..
            } => {
                let (normal, offset) = plane(vertices[0], *normal)?;
                let corners = vertices.map(|corner| narrowed(relative(corner)));
                let extents = view.extents_of_corners(&corners)?;
                let bounds = Bounds::Edges(edges(&corners));
                let shape = Between::Flat {
                    normal,
                    offset,
                    bounds,
                };
                (shape, extents)
            }
            Shape::Rectangle {
                center,
                normal,
                halves: [a, b],
            } => {
                let (normal, offset) = plane(*center, *normal)?;
                let middle = relative(*center);
                let corners = [
                    add(add(middle, *a), *b),
                    add(subtract(middle, *a), *b),
                    subtract(subtract(middle, *a), *b),
                    subtract(add(middle, *a), *b),
                ]
                .map(narrowed);
                let extents = view.extents_of_corners(&corners)?;
                let bounds = Bounds::Edges(edges(&corners));
                let shape = Between::Flat {
                    normal,
                    offset,
                    bounds,
                };
                (shape, extents)
            }
            Shape::Disk {
                center,
                normal,
                radius,
            } => {
                let (normal, offset) = plane(*center, *normal)?;
                let (center, radius) = (narrowed(relative(*center)), radius.narrow());
                let extents = view.extents_of_round(center, radius, Some(normal))?;
                let bounds = Bounds::Round { center, radius };
                let shape = Between::Flat {
                    normal,
                    offset,
                    bounds,
                };
                (shape, extents)
            }
            Shape::Sphere { center, radius } => {
                let way = relative(*center);
                let distance = length(way);
                let side = if is_own {
                    Side::On
                } else {
                    let (side, _) = segment.sides_of_sphere(*center, *radius, magnitude);
                    side
                };
                let power = (distance - *radius) * (distance + *radius);
                let (center, radius) = (narrowed(way), radius.narrow());
                let extents = if side == Side::Above {
                    view.extents_of_round(center, radius, None)?
                } else {
                    [EVERYWHERE; 2]
                };
                let power = if side == Side::On {
                    Wide::from(0.0)
                } else {
                    power
                };
                let shape = Between::Ball {
                    center,
                    radius,
                    power: power.narrow(),
                    side,
                };
                (shape, extents)
            }
        };
        let is_before = |[from, to]: [f64; 2]| from <= 1.0 + ROOM && to >= -1.0 - ROOM;
        extents.into_iter().all(is_before).then(|| Self {
            surface: index,
            rows: extents[0],
            columns: extents[1],
            curves: shape.curves(view),
            shape,
            room,
            pane: None,
        })
    }

    /// The same, if it is a pane of this index.
    pub(super) fn of_pane(self, pane: Option<f64>) -> Self {
        Self { pane, ..self }
    }

    pub(super) fn is_pane(&self) -> bool {
        self.pane.is_some()
    }

    /// T(θ) of a pane for light from a point of the light in this direction, before which it is.
    pub(super) fn transmittance(&self, view: &View, direction: Vector) -> f64 {
        let Some(n) = self.pane else {
            return 0.0;
        };
        let (cos, times) = match &self.shape {
            Between::Flat { normal, .. } => (cosine(*normal, direction).abs(), 1),
            Between::Ball {
                center,
                radius,
                side,
                ..
            } => {
                let across = length(cross(*center, direction)) / length(direction) / radius;
                let point = scale(direction, view.part_to(direction));
                let is_within = length(subtract(point, *center)) <= radius + self.room;
                let is_passed_through = *side == Side::Above && !is_within;
                let cos = ((1.0 - across) * (1.0 + across)).max(0.0).sqrt();
                (cos, if is_passed_through { 2 } else { 1 })
            }
        };
        let [_, transmittance] = fresnel::pane(Wide::from(cos.min(1.0)), n);
        transmittance.powi(times)
    }

    /// Whether it and another may be before the same points.
    pub(super) fn may_meet(&self, other: &Self) -> bool {
        let overlap = |a: [f64; 2], b: [f64; 2]| a[0] <= b[1] + ROOM && b[0] <= a[1] + ROOM;
        overlap(self.rows, other.rows) && overlap(self.columns, other.columns)
    }

    /// Whether its shadow may begin or end at a point that is on one of its curves: others of its edges are not passed.
    pub(super) fn may_end_at(&self, direction: Vector) -> bool {
        let Between::Flat {
            bounds: Bounds::Edges(edges),
            ..
        } = &self.shape
        else {
            return true;
        };
        let size = length(direction);
        edges
            .iter()
            .all(|&edge| dot(edge, direction) >= -NEAR * size * length(edge))
    }

    /// Whether it may be before a row.
    pub(super) fn is_in_row(&self, row: f64) -> bool {
        self.rows[0] - ROOM <= row && row <= self.rows[1] + ROOM
    }

    /// From where to where on a line it is in the way; the shadows' curves are numbered from `number` on.
    pub(super) fn intervals(&self, view: &View, line: &Line, number: u32, found: &mut Vec<Hidden>) {
        let [first, last] = line.ends;
        let mut places = [(0.0, 0); 16];
        let mut count = 0;
        for (curve, number) in self.curves.iter().zip(number..) {
            for s in curve.on(line.row) {
                if s > first && s < last && count < places.len() {
                    places[count] = (s, number);
                    count += 1;
                }
            }
        }
        let places = &mut places[..count];
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut from = (first, Hidden::END);
        for to in places.iter().copied().chain([(last, Hidden::END)]) {
            if to.0 > from.0 && self.stands_before(view, line.at(0.5 * (from.0 + to.0))) {
                found.push(Hidden {
                    ends: [from.0, to.0],
                    curves: [from.1, to.1],
                });
            }
            from = to;
        }
    }

    /// L4: whether it stands strictly between p and the point of the light in this direction.
    fn stands_before(&self, view: &View, direction: Vector) -> bool {
        let point = scale(direction, view.part_to(direction));
        match &self.shape {
            Between::Flat {
                normal,
                offset,
                bounds,
            } => {
                let beyond = (dot(*normal, point) - offset) * offset.signum();
                let is_beyond = beyond > self.room;
                is_beyond
                    && match bounds {
                        Bounds::All => true,
                        Bounds::Edges(edges) => {
                            edges.iter().all(|&edge| dot(edge, direction) >= 0.0)
                        }
                        Bounds::Round { center, radius } => {
                            let met = scale(direction, offset / dot(*normal, direction));
                            length(subtract(met, *center)) <= *radius
                        }
                    }
            }
            Between::Ball {
                center,
                radius,
                power,
                side,
            } => {
                let from_center = subtract(point, *center);
                let outside = length(from_center) - radius;
                let along = dot(direction, *center);
                match side {
                    Side::Below => outside > self.room,
                    Side::On => outside > self.room && along > 0.0,
                    Side::Above if outside < -self.room => true,
                    Side::Above => {
                        along > 0.0
                            && along * along > dot(direction, direction) * power
                            && dot(from_center, direction) > 0.0
                    }
                }
            }
        }
    }
}

/// What is hidden of a line, or behind a pane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hidden {
    pub(super) ends: [f64; 2],
    /// The numbers of the curves at the ends.
    pub(super) curves: [u32; 2],
}

impl Hidden {
    /// The number of the end of a line.
    pub(super) const END: u32 = u32::MAX;
}

impl Between {
    fn curves(&self, view: &View) -> Vec<Curve> {
        let mut curves = Vec::with_capacity(5);
        match self {
            Self::Flat {
                normal,
                offset,
                bounds,
            } => {
                let plane = (*normal, *offset);
                match bounds {
                    Bounds::All => curves.push(Curve::straight(view, *normal, 0.0)),
                    Bounds::Edges(edges) => {
                        curves.extend(edges.iter().map(|&edge| Curve::straight(view, edge, 0.0)));
                    }
                    Bounds::Round { center, radius } => {
                        curves.push(Curve::circle(view, plane, (*center, *radius)));
                    }
                }
                curves.push(match &view.sphere {
                    None => Curve::straight(view, *normal, *offset),
                    Some(sphere) => Curve::circle(view, plane, (sphere.center, sphere.radius)),
                });
            }
            Self::Ball {
                center,
                radius,
                power,
                side,
            } => {
                curves.push(if *side == Side::On {
                    Curve::straight(view, *center, 0.0)
                } else {
                    Curve::cone(view, *center, *power)
                });
                curves.push(match &view.sphere {
                    None => Curve::sphere(view, *center, *radius),
                    Some(sphere) => {
                        // Both spheres meet in a plane.
                        let normal = subtract(*center, sphere.center);
                        let offset = 0.5 * (power - sphere.power);
                        Curve::circle(view, (normal, offset), (sphere.center, sphere.radius))
                    }
                });
            }
        }
        curves
    }
}

impl View {
    /// Of something flat with these corners; `None` where it is not between p and the light.
    fn extents_of_corners(&self, corners: &[Vector]) -> Option<Extents> {
        let heights = corners.iter().map(|&corner| dot(self.normal, corner));
        let lowest = heights.clone().fold(f64::INFINITY, f64::min);
        let highest = heights.fold(f64::NEG_INFINITY, f64::max);
        if highest <= 0.0 || lowest >= self.height {
            return None;
        }
        if lowest <= ROOM * highest {
            return Some([EVERYWHERE; 2]);
        }
        Some([self.across, self.along].map(|axis| {
            let places = corners.iter().map(|&corner| {
                let met = scale(corner, self.height / dot(self.normal, corner));
                dot(subtract(met, self.middle), axis) / dot(axis, axis)
            });
            places.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], s| {
                [least.min(s), most.max(s)]
            })
        }))
    }

    /// Of a sphere, or of a disk across a normal: planes through p and a row touch it.
    fn extents_of_round(
        &self,
        center: Vector,
        radius: f64,
        normal: Option<Vector>,
    ) -> Option<Extents> {
        let height = dot(self.normal, center);
        if height + radius <= 0.0 || height - radius >= self.height {
            return None;
        }
        if height <= radius * (1.0 + ROOM) {
            return Some([EVERYWHERE; 2]);
        }
        Some(
            [[self.across, self.along], [self.along, self.across]].map(|[axis, other]| {
                let (start, slope) = (cross(other, self.middle), cross(other, axis));
                // How far such a plane may be from the center.
                let square = |a: Vector, b: Vector| {
                    let flat = normal.map_or(0.0, |normal| dot(a, normal) * dot(b, normal));
                    radius * radius * (dot(a, b) - flat)
                };
                let (at_start, by_slope) = (dot(start, center), dot(slope, center));
                let roots = quadratic(
                    by_slope * by_slope - square(slope, slope),
                    at_start * by_slope - square(start, slope),
                    at_start * at_start - square(start, start),
                );
                match roots {
                    [a, b] if a.is_finite() && b.is_finite() => [a.min(b), a.max(b)],
                    _ => EVERYWHERE,
                }
            }),
        )
    }
}

/// The planes through p and each edge, their normals to the inside.
fn edges(corners: &[Vector]) -> Vec<Vector> {
    let middle = corners
        .iter()
        .fold([0.0; 3], |sum, &corner| add(sum, corner));
    let next = corners.iter().cycle().skip(1);
    corners
        .iter()
        .zip(next)
        .map(|(&corner, &next)| {
            let normal = cross(corner, next);
            scale(normal, dot(normal, middle).signum())
        })
        .collect()
}
