//! Emitters, planes and lobes at random beside brute force.

use super::super::{Conic, Polygon, polygon};
use super::cubature::{Estimate, Region, axes_across};
use crate::math::DVec3;

/// Random numbers that are the same on every machine (Vigna's splitmix64).
pub(super) struct Random(pub(super) u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    pub(super) fn within(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * ((self.next() >> 11) as f64 / (1_u64 << 53) as f64)
    }

    /// Evenly over the orders of magnitude.
    pub(super) fn scale(&mut self, from: f64, to: f64) -> f64 {
        self.within(from.ln(), to.ln()).exp()
    }

    pub(super) fn direction(&mut self) -> DVec3 {
        loop {
            let [x, y, z] = [(); 3].map(|()| self.within(-1.0, 1.0));
            let vector = DVec3::new(x, y, z);
            if (0.01..1.0).contains(&vector.length_squared()) {
                return vector.normalize();
            }
        }
    }

    fn exponent(&mut self, largest: f64) -> f64 {
        match self.next() % 5 {
            0 => self.within(0.0, 3.0),
            1 => self.within(0.0, 30.0).floor(),
            2 => self.scale(1.0, 200.0).floor(),
            3 => self.scale(1.0, 200.0),
            _ => self.scale(1.0, largest),
        }
    }
}

/// A triangle or a rectangle, seen from somewhere.
fn corners(random: &mut Random) -> Vec<DVec3> {
    let normal = random.direction();
    let [x, y] = axes_across(normal);
    let distance = random.scale(0.03, 10.0);
    let middle = normal * distance + x * random.within(-2.0, 2.0) + y * random.within(-2.0, 2.0);
    if random.within(0.0, 1.0) < 0.5 {
        let [a, b] = [x * random.scale(0.1, 1.0), y * random.scale(0.1, 1.0)];
        vec![
            middle - a - b,
            middle + a - b,
            middle + a + b,
            middle - a + b,
        ]
    } else {
        let mut corner = || middle + x * random.within(-1.0, 1.0) + y * random.within(-1.0, 1.0);
        vec![corner(), corner(), corner()]
    }
}

/// Below this, relative to a full lobe or to 1, the brute force is not trusted whatever it says.
const TRUSTED: f64 = 1e-10;

/// What a random emitter, horizon and lobe were.
#[derive(Debug)]
struct Case {
    n: DVec3,
    w: DVec3,
    exponent: f64,
}

impl Case {
    fn check(&self, name: &str, actual: f64, expected: Estimate, full: f64) {
        let error = (actual - expected.value).abs();
        assert!(
            error <= TRUSTED * full + expected.error,
            "{name}: {actual} instead of {expected:?}, {:e} of {full}: {self:?}",
            error / full
        );
    }

    fn check_all(&self, [irradiance, lobe, cosine]: [f64; 3], region: impl Fn() -> Region) {
        let &Self { n, w, exponent } = self;
        let full = |plus: f64| std::f64::consts::TAU / (exponent + plus);
        let expected = region().irradiance(n, TRUSTED);
        self.check("irradiance", irradiance, expected, 1.0);
        let expected = region().cut(n).lobe(w, None, exponent, TRUSTED * full(1.0));
        self.check("lobe", lobe, expected, full(1.0));
        let expected = region()
            .cut(n)
            .lobe(w, Some(n), exponent, TRUSTED * full(2.0));
        self.check("cosine", cosine, expected, full(2.0));
    }
}

#[test]
fn polygons_are_what_brute_force_says() {
    let mut random = Random(1);
    for turn in 0..2000 {
        let corners = corners(&mut random);
        let n = random.direction();
        let w = if turn % 2 == 0 {
            random.direction()
        } else {
            // Inside, and close to an edge.
            let [a, b] = [(); 2].map(|()| random.within(0.0, 1.0));
            let side = corners[0].lerp(corners[1], a);
            side.lerp(corners[2], b * b * b).normalize()
        };
        let exponent = random.exponent(1e6);
        let clipped = Polygon::new(&corners).unwrap().clipped(n).unwrap();
        let actual = [
            polygon::irradiance(&corners, n),
            polygon::lobe(clipped.corners(), w, exponent),
            polygon::cosine_lobe(clipped.corners(), w, n, exponent),
        ];
        Case { n, w, exponent }.check_all(actual, || Region::polygon(&corners));
    }
}

#[test]
fn disks_and_spheres_are_what_brute_force_says() {
    let mut random = Random(2);
    for turn in 0..2000 {
        let normal = random.direction();
        let distance = random.scale(0.03, 10.0);
        let center = normal * distance + random.direction() * random.within(0.0, 2.0);
        let radius = random.scale(0.1, 1.0);
        let is_sphere = turn % 2 == 0;
        let conic = if is_sphere {
            Conic::of_sphere(center, radius)
        } else {
            Conic::of_disk(center, normal, radius)
        };
        let region = || {
            if is_sphere {
                Region::sphere(center, radius)
            } else {
                Region::disk(center, normal, radius)
            }
        };
        let Some(conic) = conic else {
            continue;
        };
        // So close to its plane or surface rows end where rounding says.
        let apart = if is_sphere {
            center.length() / radius - 1.0
        } else {
            center.dot(normal).abs()
        };
        if apart < 1e-3 {
            continue;
        }
        let n = random.direction();
        let w = if turn % 4 < 2 {
            random.direction()
        } else {
            let [x, y] = axes_across(normal);
            let (sin, cos) = random.within(0.0, 7.0).sin_cos();
            let rim = (x * cos + y * sin) * radius;
            (center + rim * random.within(0.9, 1.1)).normalize()
        };
        let exponent = random.exponent(1e6);
        let clipped = conic.clipped(n).unwrap();
        let actual = [
            conic.irradiance(n),
            clipped.lobe(w, exponent),
            clipped.cosine_lobe(w, n, exponent),
        ];
        Case { n, w, exponent }.check_all(actual, region);
    }
}
