//! A table with a symmetry is the whole table.

use super::*;

/// Intensities with the symmetry of a table, by what is the same in its images.
fn smooth(v: f64, part: f64) -> f64 {
    100.0 + 40.0 * libm::cos(v.to_radians()) + 30.0 * part * libm::sin(v.to_radians())
}

/// The same file with all planes.
fn agrees(horizontal: &[f64], part: impl Fn(f64) -> f64, symmetry: Symmetry) {
    for vertical in [
        steps(0.0, 90.0, 7),
        steps(90.0, 180.0, 4),
        steps(0.0, 180.0, 13),
    ] {
        let some = Text::new(1, &vertical, horizontal).of(|v, h| smooth(v, part(h)));
        let all = Text::new(1, &vertical, &steps(0.0, 360.0, 25)).of(|v, h| smooth(v, part(h)));
        let (some, all) = (parse(&some).photometry, parse(&all).photometry);
        assert_eq!(some.symmetry(), symmetry, "{horizontal:?}");
        for direction in directions() {
            let (a, b) = (some.intensity(direction), all.intensity(direction));
            assert!(
                (a - b).abs() <= 1e-12 * b.abs(),
                "{horizontal:?} {direction} {a} {b}"
            );
        }
        assert_near(some.lumens(), all.lumens(), 1e-13);
        assert_near(some.zonal_lumens(), all.zonal_lumens(), 1e-13);
        for (some, all) in [
            (some.beam_angle(), all.beam_angle()),
            (some.field_angle(), all.field_angle()),
        ] {
            assert_near(some.plane_0.unwrap(), all.plane_0.unwrap(), 1e-12);
            assert_near(some.plane_90.unwrap(), all.plane_90.unwrap(), 1e-12);
        }
        let (some, all) = (some.peak(), all.peak());
        assert_near(some.candela, all.candela, 1e-14);
    }
}

fn cos(degrees: f64) -> f64 {
    libm::cos(degrees.to_radians())
}

#[test]
fn every_symmetry_is_the_whole_table() {
    agrees(&[0.0], |_| 1.0, Symmetry::Axial);
    agrees(&[90.0], |_| 1.0, Symmetry::Axial);
    let quadrants = |h: f64| cos(2.0 * h);
    for first in [0.0, 90.0, 180.0, 270.0, -90.0] {
        agrees(
            &steps(first, first + 90.0, 7),
            quadrants,
            Symmetry::Quadrants,
        );
    }
    let mirrored = |h: f64| cos(h) + 0.5 * cos(2.0 * h);
    for first in [0.0, 180.0, -180.0] {
        agrees(
            &steps(first, first + 180.0, 13),
            mirrored,
            Symmetry::Mirrored,
        );
    }
    let across = |h: f64| cos(h - 90.0) + 0.5 * cos(2.0 * h);
    for first in [90.0, 270.0, -90.0] {
        agrees(
            &steps(first, first + 180.0, 13),
            across,
            Symmetry::MirroredAcross,
        );
    }
    let none = |h: f64| cos(h - 33.0) + 0.5 * cos(2.0 * h + 10.0);
    for first in [0.0, 90.0, 15.0, -180.0, -15.0] {
        agrees(&steps(first, first + 360.0, 25), none, Symmetry::None);
        agrees(&steps(first, first + 345.0, 24), none, Symmetry::None);
    }
}

/// Lists that start again at 0 amid the turn.
#[test]
fn planes_that_begin_in_the_middle() {
    let none = |h: f64| cos(h - 33.0);
    let mut whole: Vec<f64> = steps(90.0, 345.0, 18);
    whole.extend(steps(0.0, 75.0, 6));
    agrees(&whole, none, Symmetry::None);
    let across = |h: f64| cos(h - 90.0);
    let mut half: Vec<f64> = steps(270.0, 345.0, 6);
    half.extend(steps(0.0, 90.0, 7));
    agrees(&half, across, Symmetry::MirroredAcross);
    let mut descending = steps(0.0, 180.0, 13);
    descending.reverse();
    agrees(&descending, cos, Symmetry::Mirrored);
}

#[test]
fn types_a_and_b_are_mirrored() {
    let f = |v: f64, h: f64| 50.0 + 30.0 * cos(v - 20.0) * cos(h * h / 90.0);
    for kind in [2, 3] {
        let table = |horizontal: &[f64]| {
            parse(&Text::new(kind, &steps(-90.0, 90.0, 13), horizontal).of(f)).photometry
        };
        let whole = table(&steps(-90.0, 90.0, 13));
        for half in [table(&steps(0.0, 90.0, 7)), table(&steps(-90.0, 0.0, 7))] {
            assert_eq!(half.symmetry(), Symmetry::Mirrored);
            for direction in directions() {
                let (a, b) = (half.intensity(direction), whole.intensity(direction));
                assert!((a - b).abs() <= 1e-12 * b, "{direction} {a} {b}");
            }
            assert_near(half.lumens(), whole.lumens(), 1e-13);
        }
    }
}
