//! Dielectrics, panes, absorption.

use super::*;
use crate::optics::fresnel::cos_transmitted;

const INDICES: [f64; 12] = [
    0.3,
    0.5,
    0.75,
    0.99,
    1.0 - 1e-9,
    1.0 + 1e-9,
    1.000_3,
    1.33,
    1.5,
    2.4,
    4.0,
    40.0,
];

#[test]
fn reflectance_at_angles() {
    let angles = [0.0, 30.0, 45.0, 60.0, 75.0, 85.0, 89.0];
    let glass = [
        0.04,
        0.041_522_625_975_8,
        0.050_239_911_012_2,
        0.089_186_712_802_2,
        0.253_060_562_990,
        0.612_799_645_265,
        0.904_184_949_780,
    ];
    let water = [
        0.020_059_312_199_5,
        0.021_112_457_865_3,
        0.027_521_383_560_8,
        0.059_125_599_247_4,
        0.211_426_604_134,
        0.582_728_244_892,
        0.896_046_505_214,
    ];
    for (n, published) in [(1.5, glass), (1.33, water)] {
        for (degrees, published) in angles.into_iter().zip(published) {
            assert_published(dielectric(cosine(degrees), n), published, 12);
        }
    }
}

#[test]
fn reflectance_from_inside() {
    let inside = |degrees| dielectric(cosine(degrees), 1.0 / 1.5);
    assert_published(inside(20.0), 0.041_728_518_190_6, 12);
    assert_published(inside(40.0), 0.245_291_204_287, 12);
    assert_published(inside(41.8), 0.890_771_921_5, 10);
    // The critical angle is 41.8103149°.
    assert!(inside(41.810_314_8) < 1.0 && inside(41.810_315).to_bits() == 1_f64.to_bits());
    assert!(cos_transmitted(cosine(41.810_314_8), 1.0 / 1.5).is_some());
    assert!(cos_transmitted(cosine(41.810_315), 1.0 / 1.5).is_none());
}

#[test]
fn no_boundary_without_a_difference() {
    for c in cosines() {
        assert_eq!(dielectric(c, 1.0), 0.0);
        assert!((cos_transmitted(c, 1.0).unwrap() - c).abs() < 1e-16);
    }
}

#[test]
fn grazing_light_is_reflected() {
    for eta in INDICES {
        assert_eq!(dielectric(0.0, eta), 1.0, "{eta}");
        assert_eq!(pane(0.0, eta), [1.0, 0.0], "{eta}");
    }
}

#[test]
fn along_the_normal() {
    for eta in INDICES {
        let root: f64 = (eta - 1.0) / (eta + 1.0);
        let relative = dielectric(1.0, eta) / (root * root) - 1.0;
        assert!(relative.abs() < 2e-15, "{eta}: {relative}");
        assert!((cos_transmitted(1.0, eta).unwrap() - 1.0).abs() < 2e-16);
    }
}

/// Where η is near 1 F is ((η − 1)/(2 c²))² (1 + (2 c² − 1)²)/2 but for terms of the relative size (η − 1)/c².
#[test]
fn a_slight_difference_keeps_its_digits() {
    for distance in [1e-9, -1e-9, 1e-12, -1e-12] {
        let eta: f64 = 1.0 + distance;
        for c in cosines().skip(20) {
            let double = 2.0 * c * c;
            let first = (eta - 1.0) / double;
            let polarized = double - 1.0;
            let expected = first * first * (1.0 + polarized * polarized) / 2.0;
            let relative = dielectric(c, eta) / expected - 1.0;
            assert!(
                relative.abs() < 4.0 * distance.abs() / (c * c) + 2e-15,
                "{eta}, {c}: {relative}"
            );
        }
    }
}

/// The amplitudes as textbooks have them.
fn amplitudes(c: f64, eta: f64) -> [f64; 2] {
    let t = cos_transmitted(c, eta).unwrap();
    [(eta * c - t) / (eta * c + t), (c - eta * t) / (c + eta * t)]
}

#[test]
fn equals_the_squares_of_the_amplitudes() {
    for eta in INDICES {
        for c in cosines() {
            if cos_transmitted(c, eta).is_none() {
                assert_eq!(dielectric(c, eta), 1.0);
                continue;
            }
            let [parallel, perpendicular] = amplitudes(c, eta);
            let expected = 0.5 * (parallel * parallel + perpendicular * perpendicular);
            let f = dielectric(c, eta);
            assert!((f - expected).abs() < 2e-15, "{eta}, {c}: {f}, {expected}");
            assert!((0.0..=1.0).contains(&f));
        }
    }
}

#[test]
fn at_brewsters_angle_one_polarization_is_not_reflected() {
    for eta in INDICES {
        let c = 1.0 / (1.0 + eta * eta).sqrt();
        let [parallel, perpendicular] = amplitudes(c, eta);
        assert!(parallel.abs() < 4e-15, "{eta}: {parallel}");
        let relative = dielectric(c, eta) / (0.5 * perpendicular * perpendicular) - 1.0;
        // The amplitude loses digits where η is near 1.
        assert!(
            relative.abs() < 4e-15 + 1e-15 / (eta - 1.0).abs(),
            "{eta}: {relative}"
        );
    }
    let angle = 1.5_f64.atan();
    assert_published(angle.to_degrees(), 56.309_932_474_0, 10);
    assert_published(dielectric(angle.cos(), 1.5), 0.073_964_497_041_4, 12);
}

/// F(c, η) = F(c_t, 1/η): both sides of a boundary reflect alike.
#[test]
fn reflectance_is_reciprocal() {
    let mut most = 0.0_f64;
    for eta in INDICES {
        for c in cosines().skip(1) {
            let Some(t) = cos_transmitted(c, eta) else {
                continue;
            };
            // What the rounding of c_t moves back to c, times the slope of F, which is below 4 max(η, 1/η)² /c.
            let larger = eta.max(1.0 / eta);
            let conditioned = 1.0 + larger * larger / (c * c);
            let difference = (dielectric(c, eta) - dielectric(t, 1.0 / eta)).abs();
            most = most.max(difference / conditioned);
            if (0.5..=2.5).contains(&eta) && c >= 0.3 && t >= 0.3 {
                assert!(difference < 1e-14, "{eta}, {c}: {difference}");
            }
        }
    }
    assert!(most < 1e-15, "{most}");
}

/// 2 ∫ F c dc over c in 0..=1, by Simpson's rule.
#[test]
fn hemispherical_mean() {
    let steps = 4000;
    let mut sum = 0.0;
    for step in 0..=steps {
        let c = f64::from(step) / f64::from(steps);
        let weight = match step {
            _ if step == 0 || step == steps => 1.0,
            _ if step % 2 == 1 => 4.0,
            _ => 2.0,
        };
        sum += weight * 2.0 * c * dielectric(c, 1.5);
    }
    assert_published(sum / (3.0 * f64::from(steps)), 0.091_777_959_342_4, 12);
}

#[test]
fn panes() {
    let [reflected, transmitted] = pane(cosine(60.0), 1.5);
    assert_published(transmitted, 0.836_232_462_710, 12);
    assert_published(reflected, 0.163_767_537_290, 12);
    for eta in INDICES {
        for c in cosines() {
            let [reflected, transmitted] = pane(c, eta);
            assert!((reflected + transmitted - 1.0).abs() <= f64::EPSILON);
            assert!(reflected >= 0.0 && transmitted >= 0.0);
            // Faces by the sum of all that goes to and fro.
            let f = dielectric(c, eta);
            let (mut sum, mut inside) = (0.0, 1.0 - f);
            for _ in 0..2000 {
                sum += inside * (1.0 - f);
                inside *= f * f;
            }
            if f < 0.99 {
                assert!((sum - transmitted).abs() < 1e-14, "{eta}, {c}");
            }
        }
    }
}

/// What the mean of both polarizations adds to R of a pane.
#[test]
fn panes_of_apart_polarizations_reflect_less() {
    let mut most = 0.0_f64;
    for c in cosines() {
        let apart = amplitudes(c, 1.5).map(|amplitude| {
            let face = amplitude * amplitude;
            face / (1.0 + face)
        });
        let excess = pane(c, 1.5)[0] - (apart[0] + apart[1]);
        assert!(excess > -1e-15, "{c}: {excess}");
        most = most.max(excess);
    }
    assert_published(most, 0.0222, 4);
    let apart = amplitudes(cosine(60.0), 1.5).map(|r| r * r / (1.0 + r * r));
    assert_published(apart[0] + apart[1], 0.151_871_590_271_2, 12);
}

#[test]
fn schlicks_ends() {
    for r0 in [0.0, 0.04, 0.5, 0.9, 1.0] {
        assert_eq!(schlick(r0, 1.0), r0);
        assert_eq!(schlick(r0, 0.0), 1.0);
        assert!((schlick(r0, 0.5) - (r0 + (1.0 - r0) / 32.0)).abs() < 1e-16);
    }
}

#[test]
fn absorption_multiplies_over_distances() {
    assert_eq!(absorbed(0.0, 5.0), 1.0);
    assert_eq!(absorbed(3.0, 0.0), 1.0);
    // ln 2 over 1 m halves.
    assert!((absorbed(std::f64::consts::LN_2, 3.0) - 0.125).abs() < 1e-16);
    let both = absorbed(0.7, 0.2) * absorbed(0.7, 1.1);
    assert!((absorbed(0.7, 1.3) - both).abs() < 1e-15);
    assert_eq!(absorbed(1e9, 1e9), 0.0);
}
