//! What is received past occluders, beside numbers computed apart and sums of parts.

use super::super::shadow::Bounded;
use super::super::{Accuracy, Emitter, Occluder, Receiver, ShadowSpace};
use super::cubature::axes_across;
use super::fuzz::Random;
use super::{is_near, normal, v};
use crate::math::{DVec3, Point};

pub(super) const ORIGIN: Point = Point::new(0.0, 0.0, 0.0);

pub(super) const FINE: Accuracy = Accuracy {
    relative: 1e-6,
    most_cells: 100_000,
};

pub(super) fn receiver(up: DVec3) -> Receiver {
    Receiver {
        horizon: normal(up),
        normal: normal(up),
        gloss: None,
    }
}

fn square() -> Emitter {
    let halves = [v(0.0, 0.5, 0.0), v(0.5, 0.0, 0.0)];
    Emitter::rectangle(Point::new(0.0, 0.0, 1.0), halves, false).unwrap()
}

fn past(emitter: &Emitter, point: Point, receiver: &Receiver, occluders: &[Occluder]) -> Bounded {
    let mut space = ShadowSpace::default();
    let bounded = emitter.received_past(point, receiver, occluders, 1e-12, &FINE, &mut space);
    bounded.unwrap_or_default()
}

/// A convex planar polygon, as triangles around its first corner.
fn fan(corners: &[DVec3]) -> Vec<Occluder> {
    let pairs = corners.windows(2).skip(1);
    pairs
        .map(|pair| Occluder::Triangle([corners[0], pair[0], pair[1]]))
        .collect()
}

#[test]
fn shadows_are_those_computed_apart() {
    let up = receiver(DVec3::Z);
    let free = square().received(ORIGIN, &up).unwrap();
    is_near(free.irradiance, 0.752_274_688_454_1);
    let irradiance =
        |occluders: &[Occluder]| past(&square(), ORIGIN, &up, occluders).value.irradiance;
    let corners = [(-9.0, -9.0), (0.1, -9.0), (0.1, 9.0), (-9.0, 9.0)];
    let corners = corners.map(|(x, y)| v(x, y, 0.5));
    is_near(irradiance(&fan(&corners)), 0.207_575_167_619_8);
    for (corners, expected) in [
        (
            [(-0.1, -0.1), (0.15, -0.05), (0.0, 0.15)],
            0.642_357_466_148_9,
        ),
        ([(0.0, -0.1), (0.4, 0.05), (0.05, 0.3)], 0.554_641_868_674),
    ] {
        let [a, b, c] = corners.map(|(x, y)| v(x, y, 0.5));
        is_near(irradiance(&[Occluder::Triangle([a, b, c])]), expected);
        is_near(irradiance(&[Occluder::Triangle([a, c, b])]), expected);
        // The same cut in three.
        let middle = (a + b + c) / 3.0;
        let parts = [[a, b, middle], [b, c, middle], [c, a, middle]].map(Occluder::Triangle);
        is_near(irradiance(&parts), expected);
    }
}

#[test]
fn a_ball_hides_a_part_of_a_sphere() {
    let light = Emitter::sphere(Point::new(0.0, 1.0, 4.0), 1.0).unwrap();
    let ball = Occluder::Ball {
        center: v(0.2, 0.4, 2.0),
        radius: 0.5,
    };
    let free = light.received(ORIGIN, &receiver(DVec3::Z)).unwrap();
    is_near(free.irradiance, 0.179_281_914_787_8);
    let bounded = past(&light, ORIGIN, &receiver(DVec3::Z), &[ball]);
    is_near(bounded.value.irradiance, 0.047_965_214_289_76);
    assert!(bounded.error.irradiance < 1e-13);
}

/// A bumpy sheet of so many squares to a side, each of two triangles with a corner of its own or a shared one.
fn sheet(count: u32, height: f64, half: f64, bump: f64) -> Vec<Occluder> {
    let corner = |column: u32, row: u32| {
        let [s, t] = [column, row].map(|place| f64::from(place) / f64::from(count));
        let lift = bump * ((7.0 * s).sin() + (5.0 * t).cos());
        v(
            (2.0 * s - 1.0) * half,
            (2.0 * t - 1.0) * half,
            height + lift,
        )
    };
    let mut triangles = Vec::new();
    for row in 0..count {
        for column in 0..count {
            let [a, b] = [0, 1].map(|more| corner(column + more, row));
            let [d, c] = [0, 1].map(|more| corner(column + more, row + 1));
            triangles.extend([[a, b, c], [a, c, d]].map(Occluder::Triangle));
        }
    }
    triangles
}

fn emitters() -> [Emitter; 3] {
    let center = Point::new(0.0, 0.0, 1.0);
    [
        square(),
        Emitter::disk(center, normal(-DVec3::Z), 0.5, false).unwrap(),
        Emitter::sphere(center, 0.4).unwrap(),
    ]
}

/// Nothing comes through edges that triangles share, from above one of them, from a corner, or from elsewhere.
#[test]
fn meshes_have_no_gaps() {
    let mut random = Random(5);
    let mut worst = 0.0_f64;
    for emitter in emitters() {
        for turn in 0..60 {
            let point = match turn {
                0 => DVec3::ZERO,
                1 => v(0.1, 0.1, 0.0),
                2 => v(0.1, -0.1, 0.0),
                _ => random.direction() * v(0.3, 0.3, 0.1),
            };
            let bump = if turn % 2 == 0 { 0.0 } else { 0.03 };
            let up = receiver(DVec3::Z);
            let sheet = sheet(10, 0.4, 1.0, bump);
            let free = emitter.received(Point(point), &up).unwrap();
            let Bounded { value, error } = past(&emitter, Point(point), &up, &sheet);
            worst = worst.max(value.irradiance / free.irradiance);
            worst = worst.max(value.solid_angle / free.solid_angle);
            assert!(error.irradiance < 1e-13, "{error:?}");
        }
    }
    assert!(worst <= 1e-15, "{worst:e}");
}

/// A sphere of triangles is as good as one that hides the same: what is seen past it does not depend on the order.
#[test]
fn the_order_of_occluders_does_not_matter() {
    let mut random = Random(6);
    for emitter in emitters() {
        for levels in 0..3 {
            let center = random.direction() * 0.1 + DVec3::Z * 0.5;
            let mut triangles: Vec<_> = icosphere(center, 0.1, levels)
                .into_iter()
                .map(Occluder::Triangle)
                .collect();
            let up = receiver(DVec3::Z);
            let one = past(&emitter, ORIGIN, &up, &triangles);
            triangles.reverse();
            let other = past(&emitter, ORIGIN, &up, &triangles);
            is_near(one.value.irradiance, other.value.irradiance);
            let half = triangles.len() / 3;
            triangles.rotate_left(half);
            let other = past(&emitter, ORIGIN, &up, &triangles);
            is_near(one.value.irradiance, other.value.irradiance);
            assert!(one.error.irradiance < 1e-11);
        }
    }
}

/// What is seen past a flat hole in a wall and past the plug that fits it are all there is.
#[test]
fn a_hole_and_its_plug_make_a_whole() {
    let mut random = Random(7);
    for emitter in emitters() {
        for _ in 0..40 {
            let corners =
                [(); 3].map(|()| random.direction() * 0.25 * v(1.0, 1.0, 0.0) + DVec3::Z * 0.5);
            let [mut a, mut b, c] = corners;
            let area = (b - a).cross(c - a).z;
            if area.abs() < 0.02 {
                continue;
            }
            if area < 0.0 {
                (a, b) = (b, a);
            }
            let up = receiver(DVec3::Z);
            let free = emitter.received(ORIGIN, &up).unwrap();
            let plug = past(&emitter, ORIGIN, &up, &[Occluder::Triangle([a, b, c])]);
            let far = |corner: DVec3, from: DVec3| from + (corner - from) * 100.0;
            let mut wall = Vec::new();
            let middle = (a + b + c) / 3.0;
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let [from_far, to_far] = [from, to].map(|corner| far(corner, middle));
                wall.push(Occluder::Triangle([from, from_far, to_far]));
                wall.push(Occluder::Triangle([from, to_far, to]));
            }
            let hole = past(&emitter, ORIGIN, &up, &wall);
            let sum = plug.value + hole.value;
            is_near(sum.irradiance, free.irradiance);
            is_near(sum.solid_angle, free.solid_angle);
        }
    }
}

/// The surface a point is on hides nothing of what is above it, and what stands on it does.
#[test]
fn what_a_point_is_on_does_not_count() {
    let up = receiver(DVec3::Z);
    let floor = fan(&[
        v(-5.0, -5.0, 0.0),
        v(5.0, -5.0, 0.0),
        v(5.0, 5.0, 0.0),
        v(-5.0, 5.0, 0.0),
    ]);
    let plane = Occluder::Plane {
        point: v(3.0, 4.0, 0.0),
        normal: DVec3::Z,
    };
    let disk = Occluder::Disk {
        center: v(0.1, 0.0, 0.0),
        normal: DVec3::Z,
        radius: 1.0,
    };
    let ball = Occluder::Ball {
        center: v(0.0, 0.0, -0.7),
        radius: 0.7,
    };
    // A box of which a corner is at the point, two of its sides through it.
    let wall = |a: DVec3, b: DVec3| fan(&[a, b, b + DVec3::Z * 0.3, a + DVec3::Z * 0.3]);
    let [near, right, far, left] = [
        DVec3::ZERO,
        v(0.3, 0.0, 0.0),
        v(0.3, 0.3, 0.0),
        v(0.0, 0.3, 0.0),
    ];
    let mut block = fan(&[near, right, far, left].map(|corner| corner + DVec3::Z * 0.3));
    for [from, to] in [[near, right], [right, far], [far, left], [left, near]] {
        block.extend(wall(from, to));
    }
    for emitter in emitters() {
        let free = emitter.received(ORIGIN, &up).unwrap();
        for occluders in [floor.as_slice(), &[plane], &[disk], &[ball]] {
            let bounded = past(&emitter, ORIGIN, &up, occluders);
            is_near(bounded.value.irradiance, free.irradiance);
        }
        // A quarter is behind the block.
        let bounded = past(&emitter, ORIGIN, &up, &block);
        is_near(bounded.value.irradiance, 0.75 * free.irradiance);
    }
}

/// What is behind the emitter, or in its plane, hides nothing; what is inside of a ball is hidden from outside, and
/// from inside all else.
#[test]
fn what_is_behind_does_not_count() {
    let up = receiver(DVec3::Z);
    let ball = |z: f64, radius: f64| Occluder::Ball {
        center: DVec3::Z * z,
        radius,
    };
    let facing = |z: f64, radius: f64| Occluder::Disk {
        center: DVec3::Z * z,
        normal: DVec3::Z,
        radius,
    };
    let plane = |z: f64| Occluder::Plane {
        point: DVec3::Z * z,
        normal: DVec3::Z,
    };
    for emitter in emitters() {
        let free = emitter.received(ORIGIN, &up).unwrap().irradiance;
        let is_sphere = emitter == emitters()[2];
        let seen = |occluder: Occluder| {
            let bounded = past(&emitter, ORIGIN, &up, &[occluder]);
            bounded.value.irradiance / free
        };
        for occluder in [ball(2.0, 0.55), facing(1.5, 9.0), plane(1.5)] {
            is_near(seen(occluder), 1.0);
        }
        if !is_sphere {
            is_near(seen(facing(1.0, 9.0)), 1.0);
            is_near(seen(plane(1.0)), 1.0);
            let sheet = sheet(4, 1.0, 1.0, 0.0);
            is_near(past(&emitter, ORIGIN, &up, &sheet).value.irradiance, free);
        }
        for occluder in [ball(1.0, 0.9), ball(0.0, 0.5), facing(0.5, 9.0), plane(0.5)] {
            assert!(seen(occluder) <= 1e-15, "{occluder:?}");
        }
        is_near(seen(ball(0.0, 9.0)), 1.0);
    }
}

/// A ball of so many times four triangles.
pub(super) fn icosphere(center: DVec3, radius: f64, levels: u32) -> Vec<[DVec3; 3]> {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let mut corners = Vec::new();
    for [a, b] in [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]] {
        corners.extend([
            v(0.0, a, b * golden),
            v(a, b * golden, 0.0),
            v(b * golden, 0.0, a),
        ]);
    }
    let mut triangles = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                let [a, b, c] = [i, j, k].map(|i: usize| corners[i]);
                let are_close = |a: DVec3, b: DVec3| (a - b).length() < 2.1;
                if are_close(a, b) && are_close(b, c) && are_close(c, a) {
                    triangles.push([a, b, c].map(DVec3::normalize));
                }
            }
        }
    }
    for _ in 0..levels {
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                // The same to the bit from both sides of an edge.
                let [ab, bc, ca] = [a + b, b + c, c + a].map(DVec3::normalize);
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let placed = triangles.into_iter();
    placed
        .map(|triangle| triangle.map(|corner| center + corner * radius))
        .collect()
}

/// A side of a box that goes on from that on which the point is, beyond a common edge, hides nothing of what the horizon
/// leaves of an emitter, wherever rounding puts it.
#[test]
fn the_next_side_of_a_box_hides_nothing() {
    let mut random = Random(11);
    for _ in 0..3000 {
        let up = random.direction();
        let [along, across] = axes_across(up);
        let corner = random.direction();
        let [x, y] = [[0.02, 0.2], [0.0, 0.1]].map(|[from, to]| random.within(from, to));
        let rounded = up * random.within(-2e-15, 2e-15);
        let point = Point(corner + along * x + across * y + rounded);
        let next = [
            corner,
            corner + across * random.within(0.2, 1.0),
            corner - up * random.within(0.2, 1.0),
        ];
        let center = Point(point.0 - along * random.within(1.0, 2.0) + up * 0.1);
        let turned = normal(along + up * random.within(-0.5, 0.5));
        let halves = axes_across(turned.get()).map(|half| half * 0.3);
        let emitters = [
            Emitter::rectangle(center, halves, true).unwrap(),
            Emitter::disk(center, turned, 0.4, true).unwrap(),
            Emitter::sphere(center, 0.4).unwrap(),
        ];
        for emitter in &emitters {
            let receiver = receiver(up);
            let free = emitter.received(point, &receiver).unwrap();
            let seen = past(emitter, point, &receiver, &[Occluder::Triangle(next)]);
            let off = (seen.value.irradiance - free.irradiance).abs();
            assert!(
                off <= seen.error.irradiance,
                "{off:e} {emitter:?} {point:?}"
            );
        }
    }
}
