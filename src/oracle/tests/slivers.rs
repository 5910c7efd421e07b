//! Narrow shadows on lights with an area, which no line of a rule may happen to meet: against contour integrals, and
//! against the same scene turned, so that its lines are others. All at p = 0.

use super::area::{ball, disk, plus, rectangle};
use super::*;
use crate::oracle::Sample;
use crate::oracle::vector::{cross, dot, unit};
use crate::scene::AreaShape;

/// How far an integral may be off, relative to that of the light without anything in the way.
const TOLERANCE: f64 = 1e-7;

/// Random numbers.
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    fn uniform(&mut self, from: f64, to: f64) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        from + (to - from) * ((self.0 >> 11) as f64 / (1_u64 << 53) as f64)
    }

    fn sign(&mut self) -> f64 {
        self.uniform(-1.0, 1.0).signum()
    }

    fn vector(&mut self) -> [f64; 3] {
        [0; 3].map(|_| self.uniform(-1.0, 1.0))
    }
}

/// A point of the plane of a light.
type Point = [f64; 2];

fn minus([a, b]: Point, [c, d]: Point) -> Point {
    [a - c, b - d]
}

/// How far a point is to the left of the line through two.
fn left(from: Point, to: Point, point: Point) -> f64 {
    let ([a, b], [c, d]) = (minus(to, from), minus(point, from));
    a * d - b * c
}

fn counterclockwise([a, b, c]: [Point; 3]) -> [Point; 3] {
    if left(a, b, c) < 0.0 {
        [a, c, b]
    } else {
        [a, b, c]
    }
}

/// What of a polygon is within a convex one, after Sutherland and Hodgman.
fn clipped(polygon: &[Point], within: &[Point]) -> Vec<Point> {
    let mut polygon = polygon.to_vec();
    for (i, &from) in within.iter().enumerate() {
        let to = within[(i + 1) % within.len()];
        let mut inside = Vec::new();
        for (j, &a) in polygon.iter().enumerate() {
            let b = polygon[(j + 1) % polygon.len()];
            let (of_a, of_b) = (left(from, to, a), left(from, to, b));
            if of_a >= 0.0 {
                inside.push(a);
            }
            if (of_a >= 0.0) != (of_b >= 0.0) {
                let part = of_a / (of_a - of_b);
                inside.push([0, 1].map(|axis: usize| a[axis] + part * (b[axis] - a[axis])));
            }
        }
        polygon = inside;
    }
    polygon
}

/// A light in the plane center + x a + y b, of x, y from −1 to 1 or of x² + y² up to 1.
#[derive(Clone, Copy, Debug)]
struct Light {
    center: [f64; 3],
    normal: [f64; 3],
    axes: [[f64; 3]; 2],
    is_round: bool,
}

impl Light {
    /// Above the horizon, and shining to p.
    fn new(random: &mut Random, is_round: bool) -> Self {
        loop {
            let center = [
                random.uniform(-1.0, 1.0),
                random.uniform(-1.0, 1.0),
                random.uniform(0.5, 2.0),
            ];
            let to_p = unit(center).unwrap().map(|c| -c);
            let normal = unit(plus(to_p, random.vector(), 0.5)).unwrap();
            let up = random.vector();
            let up = unit(plus(up, normal, -dot(up, normal))).unwrap();
            let side = cross(normal, up);
            let [a, b] = [0; 2].map(|_| random.uniform(0.1, 0.6));
            let b = if is_round { a } else { b };
            let axes = [side.map(|c| a * c), up.map(|c| b * c)];
            let light = Self {
                center,
                normal,
                axes,
                is_round,
            };
            let corners = [[1.0, 1.0], [1.0, -1.0], [-1.0, -1.0], [-1.0, 1.0]];
            if corners.iter().all(|&corner| light.at(corner)[2] > 0.01)
                && dot(center, normal) < -0.05
            {
                return light;
            }
        }
    }

    fn at(&self, [x, y]: Point) -> [f64; 3] {
        plus(plus(self.center, self.axes[0], x), self.axes[1], y)
    }

    fn shape(&self) -> AreaShape {
        let [a, b] = self.axes.map(|axis| dot(axis, axis).sqrt());
        if self.is_round {
            disk(self.center, self.normal, a)
        } else {
            rectangle(self.center, self.normal, self.axes[1], [2.0 * a, 2.0 * b])
        }
    }

    /// ½ ∮ n·(v × dv)/‖v‖² along the straight way between two points: Lambert's formula.
    fn straight(&self, from: Point, to: Point) -> f64 {
        let (from, to) = (self.at(from), self.at(to));
        let across = cross(from, to);
        let sine = dot(across, across).sqrt();
        if sine == 0.0 {
            return 0.0;
        }
        0.5 * sine.atan2(dot(from, to)) * across[2] / sine
    }

    /// The same along the circle, counterclockwise.
    fn arc(&self, from: f64, to: f64) -> f64 {
        const STEPS: u32 = 24;
        // Gauss's rule of 3 points.
        let node = 0.6_f64.sqrt();
        let step = (to - from) / f64::from(STEPS);
        let mut sum = 0.0;
        for i in 0..STEPS {
            for (place, weight) in [(-node, 5.0), (0.0, 8.0), (node, 5.0)] {
                let angle = from + step * (f64::from(i) + 0.5 + 0.5 * place);
                let (sin, cos) = angle.sin_cos();
                let v = self.at([cos, sin]);
                let [a, b] = self.axes;
                let way = plus(a.map(|c| -sin * c), b, cos);
                sum += weight / 18.0 * step * 0.5 * cross(v, way)[2] / dot(v, v);
            }
        }
        sum
    }

    /// ∫ cos dω of a polygon.
    fn polygon(&self, corners: &[Point]) -> f64 {
        let next = corners.iter().cycle().skip(1);
        let pairs = corners.iter().zip(next);
        pairs.map(|(&a, &b)| self.straight(a, b)).sum::<f64>().abs()
    }

    /// ∫ cos dω of what of a counterclockwise polygon is on it.
    fn within(&self, corners: &[Point]) -> f64 {
        if corners.len() < 3 {
            return 0.0;
        }
        if !self.is_round {
            return self.polygon(&clipped(corners, &SQUARE));
        }
        // The parts of edges within the circle.
        let mut pieces: Vec<[Point; 2]> = Vec::new();
        for (i, &a) in corners.iter().enumerate() {
            let way = minus(corners[(i + 1) % corners.len()], a);
            let (square, mixed) = (
                way[0].powi(2) + way[1].powi(2),
                a[0] * way[0] + a[1] * way[1],
            );
            let rest = a[0].powi(2) + a[1].powi(2) - 1.0;
            let root = (mixed * mixed - square * rest).sqrt();
            let ends = [(-mixed - root) / square, (-mixed + root) / square];
            // Not a number where the edge does not meet the circle, or is no edge.
            let is_met = ends[0] < 1.0 && ends[1] > 0.0;
            if !is_met {
                continue;
            }
            let ends = ends.map(|t| t.clamp(0.0, 1.0));
            pieces.push(ends.map(|t| [a[0] + t * way[0], a[1] + t * way[1]]));
        }
        if pieces.is_empty() {
            let next = corners.iter().cycle().skip(1);
            let is_whole = corners
                .iter()
                .zip(next)
                .all(|(&a, &b)| left(a, b, [0.0; 2]) > 0.0);
            return if is_whole { self.whole() } else { 0.0 };
        }
        let mut sum = 0.0;
        for (i, &[from, to]) in pieces.iter().enumerate() {
            sum += self.straight(from, to);
            let [next, _] = pieces[(i + 1) % pieces.len()];
            let gap = minus(next, to);
            if gap[0].abs() + gap[1].abs() > 1e-12 {
                let [from, to] = [to, next].map(|[x, y]: Point| y.atan2(x));
                let turn = if to < from {
                    std::f64::consts::TAU
                } else {
                    0.0
                };
                sum += self.arc(from, to + turn);
            }
        }
        sum.abs()
    }

    fn whole(&self) -> f64 {
        if self.is_round {
            self.arc(0.0, std::f64::consts::TAU).abs()
        } else {
            self.polygon(&SQUARE)
        }
    }

    /// A triangle whose shadow is this one.
    fn occluder(&self, corners: [Point; 3], random: &mut Random) -> [[f64; 3]; 3] {
        corners.map(|corner| {
            let part = random.uniform(0.2, 0.9);
            self.at(corner).map(|c| part * c)
        })
    }
}

const SQUARE: [Point; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];

/// The floor z = 0, seen from nearby.
fn floor() -> Builder {
    Builder::looking([3e-3, -2e-3, 0.7e-3], [0.0; 3]).plane([0.0; 3], [0.0, 0.0, 1.0])
}

/// A shadow down to so small a size, of all kinds in turns.
fn shadow(random: &mut Random, kind: u32) -> [Point; 3] {
    let size = 10.0_f64.powf(random.uniform(-4.0, 0.0));
    let signs = [random.sign(), random.sign()];
    let is_swapped = random.sign() > 0.0;
    let mut any = |most: f64| [0; 2].map(|_| random.uniform(-most, most));
    let corners = match kind % 5 {
        0 => [any(1.5), any(1.5), any(1.5)],
        // Cuts off a corner.
        1 => {
            let [a, b] = any(0.9).map(|part| size * (1.0 + part));
            let (on_one, on_other) = ([1.0 - a, 1.0], [1.0, 1.0 - b]);
            let beyond = |from: Point, to: Point| [0, 1].map(|i: usize| 2.0 * to[i] - from[i]);
            [
                beyond(on_other, beyond(on_other, on_one)),
                beyond(on_one, beyond(on_one, on_other)),
                [3.0, 3.0],
            ]
        }
        // Comes in over an edge.
        2 => {
            let [x, wide] = any(0.9);
            let wide = 0.5 * wide.abs();
            [[x, 1.0 - size], [x - wide, 1.3], [x + 0.5 * wide, 1.7]]
        }
        // A needle.
        3 => {
            let from = any(1.5);
            let [x, y] = any(size);
            [from, any(1.5), [from[0] + x, from[1] + y]]
        }
        // Within.
        _ => {
            let middle = any(0.99);
            [(); 3].map(|()| {
                let [x, y] = any(size);
                [middle[0] + x, middle[1] + y]
            })
        }
    };
    counterclockwise(corners.map(|[x, y]| {
        let [x, y] = [signs[0] * x, signs[1] * y];
        if is_swapped { [y, x] } else { [x, y] }
    }))
}

#[derive(Default)]
struct Worst {
    off: f64,
    stated: f64,
}

impl Worst {
    /// That the integral is the expected one as far as stated.
    #[track_caller]
    fn compare(&mut self, seed: u64, sample: &Sample, expected: f64, whole: f64, more: f64) {
        let off = (sample.radiance[0] - expected).abs() / whole;
        let stated = sample.error[0] / whole;
        assert!(
            off <= stated + more,
            "{seed}: off by {off:e}, said to be {stated:e}"
        );
        assert!(off <= TOLERANCE, "{seed}: off by {off:e}");
        assert!(stated <= TOLERANCE, "{seed}: said to be off by {stated:e}");
        self.off = self.off.max(off);
        self.stated = self.stated.max(stated);
    }
}

/// What of these numbers is rounding, of the contour integrals.
const DIGITS: f64 = 1e-11;

#[test]
fn one_triangle() {
    let mut worst = Worst::default();
    for seed in 0..4000 {
        let mut random = Random::new(seed);
        let light = Light::new(&mut random, seed % 2 == 1);
        let corners = shadow(&mut random, (seed / 2) as u32);
        let triangle = light.occluder(corners, &mut random);
        let scene = floor().area(light.shape()).triangle(triangle);
        let whole = light.whole();
        let expected = whole - light.within(&corners);
        let sample = scene.oracle().radiance(0.5, 0.5);
        worst.compare(seed, &sample, expected, whole, DIGITS);
    }
    println!("off {:e}, stated {:e}", worst.off, worst.stated);
}

#[test]
fn two_triangles() {
    let mut worst = Worst::default();
    for seed in 0..4000 {
        let mut random = Random::new(seed);
        let light = Light::new(&mut random, seed % 2 == 1);
        let first = shadow(&mut random, (seed / 2) as u32);
        let second = shadow(&mut random, (seed / 10) as u32);
        let scene = floor()
            .area(light.shape())
            .triangle(light.occluder(first, &mut random))
            .triangle(light.occluder(second, &mut random));
        let whole = light.whole();
        let both = clipped(&first, &second);
        let hidden = light.within(&first) + light.within(&second) - light.within(&both);
        let sample = scene.oracle().radiance(0.5, 0.5);
        worst.compare(seed, &sample, whole - hidden, whole, DIGITS);
    }
    println!("off {:e}, stated {:e}", worst.off, worst.stated);
}

/// Several surfaces of all shapes before lights of all shapes: turned, the lines are others, and the value is the same.
#[test]
fn turned_scenes() {
    let (mut off, mut stated) = (0.0_f64, 0.0_f64);
    let mut partial = 0;
    for seed in 0..1500 {
        let mut random = Random::new(seed);
        let light = Light::new(&mut random, seed % 3 == 1);
        let turn = {
            let a = unit(random.vector()).unwrap();
            let b = random.vector();
            let b = unit(plus(b, a, -dot(a, b))).unwrap();
            [a, b, cross(a, b)]
        };
        let count = 1 + seed / 3 % 4;
        let mut occluders: Vec<Object> = Vec::new();
        for _ in 0..count {
            let at = [random.uniform(-1.2, 1.2), random.uniform(-1.2, 1.2)];
            let middle = light.at(at).map(|c| random.uniform(0.5, 0.52) * c);
            let size = 0.3 * 10.0_f64.powf(random.uniform(-2.0, 0.0));
            occluders.push(match random.uniform(0.0, 3.0) as u32 {
                0 => Object::Triangle {
                    material: MATTE.to_owned().into(),
                    vertices: [(); 3].map(|()| plus(middle, random.vector(), size)).into(),
                },
                1 => Object::Plane {
                    material: MATTE.to_owned().into(),
                    point: middle.into(),
                    normal: random.vector().into(),
                },
                _ => Object::Sphere {
                    material: MATTE.to_owned().into(),
                    center: middle.into(),
                    radius: size.into(),
                },
            });
        }
        let is_ball = seed % 3 == 2;
        let of = |turned: &dyn Fn([f64; 3]) -> [f64; 3]| {
            let shape = if is_ball {
                ball(turned(light.center), 0.3)
            } else {
                Light {
                    center: turned(light.center),
                    normal: turned(light.normal),
                    axes: light.axes.map(turned),
                    ..light
                }
                .shape()
            };
            let normal = turned([0.0, 0.0, 1.0]);
            let eye = turned([3e-3, -2e-3, 0.7e-3]);
            let mut scene = Builder::looking(eye, [0.0; 3])
                .plane([0.0; 3], normal)
                .area(shape);
            for object in occluders.clone() {
                scene = scene.object(match object {
                    Object::Triangle {
                        material,
                        mut vertices,
                    } => {
                        vertices.value = vertices.value.map(turned);
                        Object::Triangle { material, vertices }
                    }
                    Object::Plane {
                        material,
                        point,
                        normal,
                    } => Object::Plane {
                        material,
                        point: turned(point.value).into(),
                        normal: turned(normal.value).into(),
                    },
                    Object::Sphere {
                        material,
                        center,
                        radius,
                    } => Object::Sphere {
                        material,
                        center: turned(center.value).into(),
                        radius,
                    },
                    other @ Object::Mesh { .. } => other,
                });
            }
            scene
        };
        let scene = of(&|v| v);
        let turned = of(&|v| turn.map(|axis| dot(axis, v)));
        let terms = scene.first_light();
        let whole = terms.unoccluded[0];
        let [a, b] = [&scene, &turned].map(|scene| scene.oracle().radiance(0.5, 0.5));
        let apart = (a.radiance[0] - b.radiance[0]).abs() / whole;
        let both = (a.error[0] + b.error[0]) / whole;
        if whole == 0.0 {
            continue;
        }
        assert!(
            apart <= both + DIGITS && apart <= TOLERANCE && both <= TOLERANCE,
            "{seed}: {apart:e} apart, said to be {both:e}"
        );
        off = off.max(apart);
        stated = stated.max(both);
        partial += u32::from(terms.outcome == crate::oracle::Outcome::Partial);
    }
    println!("apart {off:e}, stated {stated:e}");
    assert!(partial > 500, "{partial}");
}

/// A globe of many triangles, of which most are behind others, before a light whose lines are along one side of it or the other.
#[test]
fn turned_globes() {
    let (mut off, mut stated) = (0.0_f64, 0.0_f64);
    let mut partial = 0;
    for seed in 0..60 {
        let mut random = Random::new(seed);
        let light = Light::new(&mut random, false);
        let at = [random.uniform(-1.2, 1.2), random.uniform(-1.2, 1.2)];
        let translate = light.at(at).map(|c| 0.5 * c);
        let size = 0.2 * 10.0_f64.powf(random.uniform(-2.0, 0.0));
        let [a, b] = light.axes;
        let of = |axes: [[f64; 3]; 2]| {
            let placed = Placed {
                scale: [size; 3],
                translate,
                ..AS_IS
            };
            let shape = Light { axes, ..light }.shape();
            let scene = floor().area(shape).mesh(&globe(6), placed);
            scene.oracle().radiance(0.5, 0.5)
        };
        let whole = light.whole();
        let [a, b] = [of([a, b]), of([b, a.map(|c| -c)])];
        let apart = (a.radiance[0] - b.radiance[0]).abs() / whole;
        let both = (a.error[0] + b.error[0]) / whole;
        assert!(
            apart <= both + DIGITS && apart <= TOLERANCE,
            "{seed}: {apart:e} apart, said to be {both:e}"
        );
        let seen = a.radiance[0] / whole;
        partial += u32::from(seen > 0.0 && seen < 1.0 - TOLERANCE);
        off = off.max(apart);
        stated = stated.max(both);
    }
    println!("apart {off:e}, stated {stated:e}, {partial} of them partly hidden");
    assert!(partial > 20, "{partial}");
}
