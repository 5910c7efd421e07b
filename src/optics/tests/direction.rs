//! Directions of reflected and refracted light.

use super::*;
use crate::math::DVec3;
use crate::optics::fresnel::cos_transmitted;

/// A unit vector, as exact as it can be.
fn unit(x: f64, y: f64, z: f64) -> DVec3 {
    let vector = DVec3::new(x, y, z);
    vector / vector.length()
}

/// Normals, and directions against them.
fn pairs() -> impl Iterator<Item = [DVec3; 2]> {
    let steps = || (-3..=3).map(f64::from);
    let all = steps().flat_map(move |x| steps().map(move |y| [x, y]));
    let normals = [
        unit(0.0, 0.0, 1.0),
        unit(1.0, -2.0, 3.0),
        unit(-5.0, 0.3, 0.2),
        unit(0.7, 0.6, -0.5),
    ];
    normals.into_iter().flat_map(move |normal| {
        all.clone().flat_map(move |[x, y]| {
            [0.02, 0.7, 5.0].into_iter().filter_map(move |depth| {
                let direction = unit(x + 0.1, y - 0.2, -depth);
                let direction = if normal.dot(direction) > 0.0 {
                    -direction
                } else {
                    direction
                };
                (normal.dot(direction) < 0.0).then_some([direction, normal])
            })
        })
    })
}

#[test]
fn reflection_turns_the_part_along_the_normal() {
    for [d, n] in pairs() {
        let r = reflected(d, n);
        assert!((r.length() - 1.0).abs() <= 1e-15);
        assert!((n.dot(r) + n.dot(d)).abs() < 5e-16);
        assert!((n.cross(r) - n.cross(d)).length() < 5e-16);
        assert!((reflected(d, -n) - r).length() == 0.0);
    }
}

/// n × d = η n × t, the cosine is c_t, and the length stays 1.
#[test]
fn refraction_fulfills_snell() {
    let (mut bent, mut total) = (0, 0);
    for [d, n] in pairs() {
        for eta in [0.25, 1.0 / 1.5, 0.99, 1.0, 1.000_3, 1.33, 1.5, 2.4, 4.0] {
            let c = (-n.dot(d)).min(1.0);
            let Some(t) = refracted(d, n, eta) else {
                assert!(eta < 1.0 && cos_transmitted(c, eta).is_none());
                total += 1;
                continue;
            };
            bent += 1;
            let length = t.length();
            assert!((length - 1.0).abs() <= 5e-16, "{eta}, {c}: {length}");
            assert!((n.cross(d) - n.cross(t) * eta).length() < 1e-15);
            assert!((-n.dot(t) - cos_transmitted(c, eta).unwrap()).abs() < 3e-15);
            assert!(n.dot(t) <= 0.0);
        }
    }
    assert!(bent > 3000 && total > 300, "{bent}, {total}");
}

/// A thousand parallel faces.
#[test]
fn lengths_stay_one() {
    for [d, n] in pairs() {
        let mut t = d;
        for _ in 0..500 {
            t = refracted(t, n, 2.4).unwrap();
            let Some(out) = refracted(t, n, 1.0 / 2.4) else {
                break;
            };
            t = out;
            assert!((t.length() - 1.0).abs() <= 5e-16);
        }
        assert!((t - d).length() < 1e-12 / -n.dot(d));
    }
}

#[test]
fn refraction_there_and_back() {
    for [d, n] in pairs() {
        for eta in [1.33, 1.5, 2.4] {
            let t = refracted(d, n, eta).unwrap();
            // Backwards from inside, the same boundary seen from its other side.
            if let Some(back) = refracted(-t, -n, 1.0 / eta) {
                // Near grazing incidence few digits of the angle are left.
                let error = (back + d).length();
                assert!(error < 3e-15 / -n.dot(d), "{eta}: {error}");
            }
        }
    }
}

#[test]
fn light_along_the_normal_is_not_bent() {
    for n in [unit(0.0, 0.0, 1.0), unit(1.0, -2.0, 3.0)] {
        for eta in [0.5, 1.0, 1.5] {
            assert!((refracted(-n, n, eta).unwrap() + n).length() < 3e-16);
            assert!((reflected(-n, n) - n).length() < 3e-16);
        }
    }
}

#[test]
fn angles_in_glass() {
    let glass = Glass::named("N-BK7").unwrap().dispersion;
    let c = cosine(60.0);
    let direction = DVec3::new((1.0 - c * c).sqrt(), 0.0, -c);
    let published = [
        (400.0, 34.452_021_513_9),
        (550.0, 34.771_703_472_5),
        (700.0, 34.915_334_030_5),
    ];
    for (nm, degrees) in published {
        let normal = DVec3::new(0.0, 0.0, 1.0);
        let t = refracted(direction, normal, glass.index(nm)).unwrap();
        assert_published(t.x.asin().to_degrees(), degrees, 10);
    }
}
