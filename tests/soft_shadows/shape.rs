//! Shapes in 64-bit floats: where a ray meets them, and points of them as lights.

use std::f64::consts::{PI, TAU};

use super::Vector;

/// Hits this near to either end of a shadow ray, in parts of it, are its ends.
pub(super) const ENDS: f64 = 1e-9;

pub(super) fn plus(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(super) fn minus(a: Vector, b: Vector) -> Vector {
    plus(a, times(b, -1.0))
}

pub(super) fn times(a: Vector, factor: f64) -> Vector {
    a.map(|x| x * factor)
}

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub(super) fn unit(a: Vector) -> Vector {
    times(a, 1.0 / dot(a, a).sqrt())
}

/// Two unit vectors across another.
pub(super) fn across(normal: Vector, up: Vector) -> [Vector; 2] {
    let along = unit(minus(up, times(normal, dot(up, normal))));
    [cross(along, normal), along]
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Shape {
    Sphere {
        center: Vector,
        radius: f64,
    },
    Plane {
        point: Vector,
        normal: Vector,
    },
    Triangle([Vector; 3]),
    Disk {
        center: Vector,
        normal: Vector,
        radius: f64,
    },
    Rectangle {
        center: Vector,
        normal: Vector,
        /// Half of its sides.
        sides: [Vector; 2],
    },
}

/// Where a plane is met, in parts of `way`.
fn plane_at(from: Vector, way: Vector, point: Vector, normal: Vector) -> Option<f64> {
    let slope = dot(way, normal);
    (slope != 0.0).then(|| dot(minus(point, from), normal) / slope)
}

impl Shape {
    /// Where it is met first between `least` and `most`, in parts of `way`.
    pub(super) fn hit(&self, from: Vector, way: Vector, [least, most]: [f64; 2]) -> Option<f64> {
        let is_between = |t: &f64| *t > least && *t < most;
        let on = |t: f64| plus(from, times(way, t));
        match *self {
            Self::Sphere { center, radius } => {
                let to = minus(center, from);
                let (square, half) = (dot(way, way), dot(to, way));
                let nearest = minus(to, times(way, half / square));
                let rest = radius * radius - dot(nearest, nearest);
                if rest <= 0.0 {
                    return None;
                }
                let (middle, half_chord) = (half / square, (rest / square).sqrt());
                let ends = [middle - half_chord, middle + half_chord];
                ends.into_iter().find(is_between)
            }
            Self::Plane { point, normal } => plane_at(from, way, point, normal).filter(is_between),
            Self::Triangle([a, b, c]) => {
                let normal = cross(minus(b, a), minus(c, a));
                let t = plane_at(from, way, a, normal).filter(is_between)?;
                let is_inside =
                    |p: Vector, q: Vector| dot(cross(minus(q, p), minus(on(t), p)), normal) >= 0.0;
                (is_inside(a, b) && is_inside(b, c) && is_inside(c, a)).then_some(t)
            }
            Self::Disk {
                center,
                normal,
                radius,
            } => {
                let t = plane_at(from, way, center, normal).filter(is_between)?;
                let beside = minus(on(t), center);
                (dot(beside, beside) <= radius * radius).then_some(t)
            }
            Self::Rectangle {
                center,
                normal,
                sides,
            } => {
                let t = plane_at(from, way, center, normal).filter(is_between)?;
                let beside = minus(on(t), center);
                let is_in = |side: &Vector| dot(beside, *side).abs() <= dot(*side, *side);
                sides.iter().all(is_in).then_some(t)
            }
        }
    }

    pub(super) fn normal(&self, at: Vector) -> Vector {
        match *self {
            Self::Sphere { center, .. } => unit(minus(at, center)),
            Self::Triangle([a, b, c]) => unit(cross(minus(b, a), minus(c, a))),
            Self::Plane { normal, .. }
            | Self::Disk { normal, .. }
            | Self::Rectangle { normal, .. } => unit(normal),
        }
    }

    /// A point of it as a light, for u and v from 0 to 1, and the area that stands for all of them. Of a sphere they are on
    /// the part that is seen from `p`.
    pub(super) fn point(&self, p: Vector, u: f64, v: f64) -> (Vector, f64) {
        match *self {
            Self::Sphere { center, radius } => {
                let away = minus(p, center);
                let axis = unit(away);
                let part = 1.0 - radius / dot(away, away).sqrt();
                let cos = 1.0 - u * part;
                let sin = (1.0 - cos * cos).max(0.0).sqrt();
                let helper = if axis[1].abs() < 0.9 {
                    [0.0, 1.0, 0.0]
                } else {
                    [1.0, 0.0, 0.0]
                };
                let [x, y] = across(axis, helper);
                let (sine, cosine) = (TAU * v).sin_cos();
                let way = plus(
                    times(axis, cos),
                    plus(times(x, sin * cosine), times(y, sin * sine)),
                );
                (
                    plus(center, times(way, radius)),
                    TAU * radius * radius * part,
                )
            }
            Self::Disk {
                center,
                normal,
                radius,
            } => {
                let helper = if normal[1].abs() < 0.9 {
                    [0.0, 1.0, 0.0]
                } else {
                    [1.0, 0.0, 0.0]
                };
                let [x, y] = across(normal, helper);
                let (sine, cosine) = (TAU * v).sin_cos();
                let way = plus(times(x, cosine), times(y, sine));
                let point = plus(center, times(way, radius * u.sqrt()));
                (point, PI * radius * radius)
            }
            Self::Rectangle { center, sides, .. } => {
                let [x, y] = sides;
                let beside = plus(times(x, 2.0 * u - 1.0), times(y, 2.0 * v - 1.0));
                let area = 4.0 * (dot(x, x) * dot(y, y)).sqrt();
                (plus(center, beside), area)
            }
            Self::Plane { .. } | Self::Triangle(_) => panic!("no light has this shape"),
        }
    }
}

pub(super) struct Light {
    pub(super) shape: Shape,
    pub(super) luminance: Vector,
    pub(super) is_two_sided: bool,
    pub(super) is_visible: bool,
}

impl Light {
    /// The cosine at the light, towards a point; 0 where its back is black.
    pub(super) fn cosine(&self, at: Vector, way: Vector) -> f64 {
        let cos = dot(self.shape.normal(at), way);
        if self.is_two_sided {
            cos.abs()
        } else {
            cos.max(0.0)
        }
    }
}

#[derive(Clone, Copy)]
pub(super) struct Material {
    pub(super) diffuse: Vector,
    pub(super) specular: f64,
    pub(super) shininess: f64,
    pub(super) is_normalized: bool,
}
