//! L4 on the lines of a light: from where to where a surface stands between them and p.
//!
//! Whether it does changes only where the direction to a line passes an edge of the surface, or touches a sphere, or
//! where the line passes through the surface: at roots of linear and quadratic functions. Between these it is decided
//! once, by the rules of `occlusion`.

use super::super::occlusion::{Segment, Side};
use super::super::surface::{Shape, Surface};
use super::super::vector::{
    Vector, WideVector, add, cross, dot, length, narrowed, scale, subtract,
};
use super::super::wide::{Real, Wide};
use super::view::{Line, View};

/// Of bounds, relative: far more than f64 is off.
const ROOM: f64 = 1e-9;

/// A surface that may stand between p and a light, relative to p.
#[derive(Clone, Debug)]
pub(super) struct Occluder {
    /// The index of its surface.
    pub(super) surface: usize,
    /// The rows of the light before which it may be.
    pub(super) rows: [f64; 2],
    shape: Between,
    /// What coordinates may be off by.
    room: f64,
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
        extents.into_iter().all(is_before).then_some(Self {
            surface: index,
            rows: extents[0],
            shape,
            room,
        })
    }

    /// Whether it may be before a row.
    pub(super) fn is_in_row(&self, row: f64) -> bool {
        self.rows[0] - ROOM <= row && row <= self.rows[1] + ROOM
    }

    /// From where to where on a line it is in the way.
    pub(super) fn intervals(&self, view: &View, line: &Line, found: &mut Vec<[f64; 2]>) {
        let [first, last] = line.ends;
        let mut places = [0.0; 16];
        let mut count = 0;
        let mut add = |s: f64| {
            if s > first && s < last && count < places.len() {
                places[count] = s;
                count += 1;
            }
        };
        match &self.shape {
            Between::Flat {
                normal,
                offset,
                bounds,
            } => {
                match bounds {
                    Bounds::All => add(line.zero_of(*normal, 0.0)),
                    Bounds::Edges(edges) => {
                        for &edge in edges {
                            add(line.zero_of(edge, 0.0));
                        }
                    }
                    Bounds::Round { center, radius } => {
                        circle(line, *normal, *offset, *center, *radius)
                            .into_iter()
                            .for_each(&mut add);
                    }
                }
                match &view.sphere {
                    None => add(line.zero_of(*normal, *offset)),
                    Some(sphere) => circle(line, *normal, *offset, sphere.center, sphere.radius)
                        .into_iter()
                        .for_each(&mut add),
                }
            }
            Between::Ball {
                center,
                radius,
                power,
                side,
            } => {
                if *side == Side::On {
                    add(line.zero_of(*center, 0.0));
                } else {
                    // (d·m)² = ‖d‖² power
                    let at = |v: Vector| dot(v, *center);
                    let (a, b) = (at(line.along), at(line.start));
                    quadratic(
                        a * a - power * dot(line.along, line.along),
                        a * b - power * dot(line.along, line.start),
                        b * b - power * dot(line.start, line.start),
                    )
                    .into_iter()
                    .for_each(&mut add);
                }
                match &view.sphere {
                    None => {
                        let from = subtract(line.start, *center);
                        quadratic(
                            dot(line.along, line.along),
                            dot(line.along, from),
                            dot(from, from) - radius * radius,
                        )
                        .into_iter()
                        .for_each(&mut add);
                    }
                    Some(sphere) => {
                        // Both spheres meet in a plane.
                        let normal = subtract(*center, sphere.center);
                        let offset = 0.5 * (power - sphere.power);
                        circle(line, normal, offset, sphere.center, sphere.radius)
                            .into_iter()
                            .for_each(&mut add);
                    }
                }
            }
        }
        let places = &mut places[..count];
        places.sort_by(f64::total_cmp);
        let mut from = first;
        for to in places.iter().copied().chain([last]) {
            if to > from && self.stands_before(view, line.at(0.5 * (from + to))) {
                found.push([from, to]);
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

/// Where the directions to a line pass a circle: what a plane at `offset` has in common with a sphere.
fn circle(line: &Line, normal: Vector, offset: f64, center: Vector, radius: f64) -> [f64; 2] {
    // ‖offset d − (n·d) c‖² = R² (n·d)²
    let part = |d: Vector| {
        let along = dot(normal, d);
        (
            subtract(scale(d, offset), scale(center, along)),
            radius * along,
        )
    };
    let ((a, of_a), (b, of_b)) = (part(line.along), part(line.start));
    quadratic(
        dot(a, a) - of_a * of_a,
        dot(a, b) - of_a * of_b,
        dot(b, b) - of_b * of_b,
    )
}

/// The roots of a s² + 2 b s + c; not a number where there are none.
fn quadratic(a: f64, b: f64, c: f64) -> [f64; 2] {
    let root = (b * b - a * c).sqrt();
    let larger = -(b + root.copysign(b));
    [larger / a, c / larger]
}
