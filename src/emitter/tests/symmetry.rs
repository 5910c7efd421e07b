//! What must hold of any emitter: parts add up, turning all turns nothing, and order does not matter.

use super::fuzz::Random;
use super::{Conic, DVec3, Polygon, polygon, square, v};

/// All there is of a polygon, after a horizon.
fn all(corners: &[DVec3], n: DVec3, w: DVec3, exponent: f64) -> [f64; 4] {
    let above = Polygon::new(corners).unwrap().clipped(n).unwrap();
    let full = exponent + 1.0;
    [
        polygon::irradiance(corners, n),
        polygon::solid_angle(corners),
        polygon::lobe(above.corners(), w, exponent) * full,
        polygon::cosine_lobe(above.corners(), w, n, exponent) * full,
    ]
}

#[track_caller]
fn is_same(a: [f64; 4], b: [f64; 4], what: &str) {
    for (a, b) in a.into_iter().zip(b) {
        assert!((a - b).abs() < 1.5e-12, "{what}: {a} {b}");
    }
}

struct Turn([DVec3; 3]);

impl Turn {
    fn of(&self, x: DVec3) -> DVec3 {
        self.0[0] * x.x + self.0[1] * x.y + self.0[2] * x.z
    }
}

#[test]
fn parts_orders_turns_and_scales() {
    let mut random = Random(4);
    for _ in 0..1000 {
        let offset = random.direction();
        let corners = square().map(|corner| corner + offset);
        let [n, w, cut, axis] = [(); 4].map(|()| random.direction());
        let exponent = random.scale(0.1, 1e5);
        let whole = all(&corners, n, w, exponent);

        let polygon = Polygon::new(&corners).unwrap();
        let parts = [cut, -cut].map(|side| polygon.clipped(side).unwrap());
        let [a, b] = parts.map(|part| all(part.corners(), n, w, exponent));
        let sum = [0, 1, 2, 3].map(|place| a[place] + b[place]);
        is_same(whole, sum, "two parts");

        let mut reversed = corners;
        reversed.reverse();
        is_same(whole, all(&reversed, n, w, exponent), "reversed");
        reversed.rotate_left(1);
        is_same(whole, all(&reversed, n, w, exponent), "rotated");

        let scaled = corners.map(|corner| corner * 1e5);
        is_same(whole, all(&scaled, n, w, exponent), "scaled");

        let [x, y] = super::cubature::axes_across(axis);
        let turn = Turn([x, y, x.cross(y)]);
        let turned = corners.map(|corner| turn.of(corner));
        let there = all(&turned, turn.of(n), turn.of(w), exponent);
        is_same(whole, there, "turned");
    }
}

#[test]
fn a_cone_cut_in_two_is_whole() {
    let mut random = Random(5);
    for turn in 0..1000 {
        let [facing, n, w, cut] = [(); 4].map(|()| random.direction());
        let center = random.direction() * random.scale(0.6, 3.0);
        let conic = if turn % 2 == 0 {
            Conic::of_sphere(center, 0.5)
        } else {
            Conic::of_disk(center, facing, 0.5)
        };
        let Some(conic) = conic else {
            continue;
        };
        let exponent = random.scale(0.1, 1e4);
        let all = |conic: &Conic| {
            let above = conic.clipped(n).unwrap();
            let full = exponent + 1.0;
            [
                conic.irradiance(n),
                conic.solid_angle(),
                above.lobe(w, exponent) * full,
                above.cosine_lobe(w, n, exponent) * full,
            ]
        };
        let whole = all(&conic);
        let parts = [cut, -cut].map(|side| conic.clipped(side).unwrap());
        let [a, b] = parts.map(|part| all(&part));
        let sum = [0, 1, 2, 3].map(|place| a[place] + b[place]);
        is_same(whole, sum, "two parts");
        // n = 0 and n = 1 are the solid angle and the irradiance.
        let above = conic.clipped(n).unwrap();
        assert!((above.lobe(n, 1.0) - whole[0]).abs() < 1e-13);
        assert!(
            (above.cosine_lobe(w, n, 0.0) - above.clipped(w).unwrap().irradiance(n)).abs() < 1e-13
        );
        assert!((above.lobe(w, 0.0) - above.clipped(w).unwrap().solid_angle()).abs() < 1e-12);
    }
}

/// A polygon that is not convex is what it lacks less than its hull.
#[test]
fn notches_count() {
    let notched = [
        v(-1.0, -1.0, 1.0),
        v(1.0, -1.0, 1.0),
        v(0.2, 0.1, 1.0),
        v(1.0, 1.0, 1.0),
        v(-1.0, 1.0, 1.0),
    ];
    let hull = [notched[0], notched[1], notched[3], notched[4]];
    let notch = [notched[1], notched[3], notched[2]];
    let mut random = Random(6);
    for _ in 0..300 {
        let [n, w] = [(); 2].map(|()| random.direction());
        let exponent = random.scale(0.1, 1e5);
        let [a, b, c] = [&notched[..], &hull, &notch].map(|part| all(part, n, w, exponent));
        let difference = [0, 1, 2, 3].map(|place| b[place] - c[place]);
        is_same(a, difference, "notch");
    }
}

/// Nothing that is not a number comes of points in the plane, on an edge, on a corner, and far away.
#[test]
fn there_is_a_number_everywhere() {
    let mut random = Random(7);
    let places = [0.0, 0.25, 0.5, 0.5 + 1e-16, 1.0, 1e8];
    for x in places {
        for y in places {
            for z in [0.0, 1e-300, 1e-16, 1e-8, 1e-3, 1e8] {
                let corners = square().map(|corner| corner - v(x, y, 1.0 - z));
                let [n, w] = [(); 2].map(|()| random.direction());
                let values = all(&corners, n, w, random.scale(0.1, 1e9));
                assert!(
                    values.iter().all(|value| (0.0..7.0).contains(value)),
                    "{values:?}"
                );
                let disk = Conic::of_disk(v(x, y, z), DVec3::Z, 0.5);
                if let Some(disk) = disk {
                    let above = disk.clipped(n).unwrap();
                    let exponent = random.scale(0.1, 1e9);
                    let values = [
                        disk.irradiance(n),
                        disk.solid_angle(),
                        above.lobe(w, exponent),
                        above.cosine_lobe(w, n, exponent),
                    ];
                    let is_fine = values.iter().all(|value| (0.0..7.0).contains(value));
                    assert!(is_fine, "{x} {y} {z}: {values:?}");
                }
            }
        }
    }
}
