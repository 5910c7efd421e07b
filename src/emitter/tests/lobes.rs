//! Sharp lobes on and beside an edge, and small and far emitters.

use std::f64::consts::{PI, TAU};

use super::cubature::Region;
use super::{square, v};
use crate::emitter::{Conic, polygon};
use crate::math::DVec3;

/// Beside the middle of the square's edge, and so far inside.
fn beside(offset: f64) -> DVec3 {
    v(0.5 - offset, 0.1, 1.0).normalize()
}

const OFFSETS: [f64; 6] = [0.0, 1e-6, -1e-6, 1e-3, -1e-3, 1e-4];

#[test]
fn sharp_lobes_beside_an_edge_are_what_brute_force_says() {
    for exponent in [1e3, 1e5, 1e6] {
        let full = TAU / (exponent + 1.0);
        for offset in OFFSETS {
            let w = beside(offset);
            let actual = polygon::lobe(&square(), w, exponent);
            let expected = Region::polygon(&square()).lobe(w, None, exponent, 1e-11 * full);
            let error = (actual - expected.value).abs() / full;
            assert!(error < 4e-14, "{exponent} {offset}: {error:e}");
            let actual = polygon::cosine_lobe(&square(), w, DVec3::Z, exponent);
            let region = Region::polygon(&square());
            let expected = region.lobe(w, Some(DVec3::Z), exponent, 1e-11 * full);
            let error = (actual - expected.value).abs() / full;
            assert!(error < 4e-14, "{exponent} {offset}: {error:e}");
        }
    }
}

/// Where a lobe is so narrow that it sees but one edge, the part of it beyond a great circle at the angle δ is ∫ (1
/// − cᵏ) dφ/k with tan φ = x: ½ − (1/π) ∫₀^∞ (1 + tan²δ (1 + x²))^(−k/2) dx/(1 + x²), here by the trapezoidal rule
/// in x = sinh s, whose error falls off faster than any power.
fn beyond(distance: f64, k: f64) -> f64 {
    let square = distance.tan().powi(2);
    let step = 1.0 / 64.0;
    let sum: f64 = (-2560..=2560)
        .map(|place| {
            let s = f64::from(place) * step;
            let exponent = -0.5 * k * (square * s.cosh().powi(2)).ln_1p();
            // dx/(1 + x²) = ds/cosh s
            exponent.exp() / s.cosh() * step
        })
        .sum();
    sum / TAU
}

#[test]
fn the_sharpest_lobes_see_one_edge() {
    for exponent in [1e6, 1e8, 1e9] {
        for offset in OFFSETS {
            let w = beside(offset);
            let across = v(-1.0, 0.0, 0.5).normalize();
            let distance = across.dot(w).asin();
            let outside = beyond(distance.abs(), exponent + 1.0);
            let part = if distance > 0.0 {
                1.0 - outside
            } else {
                outside
            };
            let actual = polygon::lobe(&square(), w, exponent) * (exponent + 1.0) / TAU;
            assert!(
                (actual - part).abs() < 1e-14,
                "{exponent} {offset}: {actual} {part}"
            );
            // v·u is w·v to 1/n.
            let actual = polygon::cosine_lobe(&square(), w, DVec3::Z, exponent);
            let actual = actual * (exponent + 2.0) / TAU;
            assert!((actual - part * w.z).abs() < 2.0 / exponent.sqrt());
        }
        // Beside a corner, a quarter in the plane of which the corner is.
        let corner = polygon::lobe(&square(), v(0.5, 0.5, 1.0).normalize(), exponent);
        let [a, b] = [v(-1.0, 0.0, 0.5), v(0.0, -1.0, 0.5)].map(DVec3::normalize);
        let angle = PI - a.dot(b).acos();
        assert!((corner * (exponent + 1.0) / angle - 1.0).abs() < 1e-10);
    }
}

#[test]
fn sharp_lobes_at_the_rim_see_half_or_a_bit_less() {
    let disk = Conic::of_disk(v(0.0, 0.0, 1.0), -DVec3::Z, 0.5).unwrap();
    for exponent in [1e3, 1e6, 1e9] {
        let full = TAU / (exponent + 1.0);
        let share = |offset: f64| {
            let w = v(0.5 - offset, 0.0, 1.0).normalize();
            disk.lobe(w, exponent) / full
        };
        // The rim bends away by 1/√n.
        let on = share(0.0);
        assert!(
            on < 0.5 && on > 0.5 - 1.0 / exponent.sqrt(),
            "{exponent}: {on}"
        );
        // Both sides of it together, as what is on one side of a great circle and the other.
        for offset in [1e-6, 1e-3] {
            let sum = share(offset) + share(-offset);
            assert!(
                (sum - 2.0 * on).abs() < 4.0 / exponent.sqrt(),
                "{exponent}: {sum}"
            );
            assert!(share(offset) > on && share(-offset) < on);
        }
        let far_inside = share(0.4);
        assert!(exponent < 1e4 || (far_inside - 1.0).abs() < 1e-11);
        assert!(exponent < 1e4 || share(-0.4) < 1e-11);
    }
}

/// Of what is small and far, all digits are left.
#[test]
fn small_emitters_are_points() {
    let n = v(0.2, -0.1, 1.0).normalize();
    let w = v(-0.3, 0.1, 1.0).normalize();
    let facing = v(0.3, 0.2, -1.0).normalize();
    for distance in [10.0, 1e2, 1e3, 1e4, 1e6, 1e8] {
        let center = v(0.3, 0.4, 1.0).normalize() * distance;
        let [x, y] = super::cubature::axes_across(facing);
        let [x, y] = [x, y].map(|side| side * 0.5);
        let corners = [
            center - x - y,
            center + x - y,
            center + x + y,
            center - x + y,
        ];
        // As they are rounded.
        let area =
            |corners: &[DVec3; 4]| (corners[2] - corners[0]).cross(corners[3] - corners[1]) * 0.5;
        let u = center / distance;
        let solid_angle = area(&corners).dot(u).abs() / (distance * distance);
        let disk = Conic::of_disk(center, facing, 0.5).unwrap();
        let disk_angle = PI * 0.25 * facing.dot(u).abs() / (distance * distance);
        // The next term is of 1/d², and corners are rounded by 1e-16 d.
        let allowed = 4.0 / (distance * distance) + 4e-16 * distance + 1e-13;
        for exponent in [0.0, 3.0, 7.5] {
            let lobe = w.dot(u).powf(exponent);
            for (actual, expected) in [
                (polygon::irradiance(&corners, n), n.dot(u) * solid_angle),
                (polygon::solid_angle(&corners), solid_angle),
                (polygon::lobe(&corners, w, exponent), lobe * solid_angle),
                (
                    polygon::cosine_lobe(&corners, w, n, exponent),
                    lobe * n.dot(u) * solid_angle,
                ),
                (disk.irradiance(n), n.dot(u) * disk_angle),
                (disk.solid_angle(), disk_angle),
                (disk.lobe(w, exponent), lobe * disk_angle),
                (
                    disk.cosine_lobe(w, n, exponent),
                    lobe * n.dot(u) * disk_angle,
                ),
            ] {
                let error = (actual / expected - 1.0).abs();
                let allowed = allowed * (1.0 + exponent * exponent);
                assert!(
                    error < allowed,
                    "{distance} {exponent}: {error:e} {allowed:e}"
                );
            }
        }
    }
}

/// From one way of integrating to the other nothing jumps.
#[test]
fn small_and_wide_meet() {
    let n = v(0.2, -0.1, 1.0).normalize();
    let w = v(-0.3, 0.1, 1.0).normalize();
    for (size, tolerance) in [(0.99e-2, 1e-12), (0.99e-3, 1e-11)] {
        let at = |scale: f64| {
            let corners = square().map(|corner| v(corner.x * scale, corner.y * scale, 1.0));
            let area = scale * scale;
            let disk = Conic::of_disk(DVec3::Z, DVec3::Z, scale / 2.0).unwrap();
            [
                polygon::irradiance(&corners, n) / area,
                polygon::lobe(&corners, w, 33.0) / area,
                polygon::cosine_lobe(&corners, w, n, 20.5) / area,
                disk.lobe(w, 33.0) / area,
                disk.cosine_lobe(w, n, 20.5) / area,
            ]
        };
        // Around the size where the way changes, which is that of the diagonal or of the diameter.
        for middle in [size, size / 2.0_f64.sqrt()] {
            let [below, on, above] = [0.97, 1.0, 1.03].map(|factor| at(middle * factor));
            for place in 0..5 {
                let bend = (below[place] - 2.0 * on[place] + above[place]) / on[place];
                let expected = 1e3 * (0.03 * middle).powi(2);
                assert!(
                    bend.abs() < tolerance + expected,
                    "{size} {place}: {bend:e}"
                );
            }
        }
    }
}
