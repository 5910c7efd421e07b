//! Types C, B and A of the same light agree.

use super::*;

/// A distribution without any symmetry, by direction.
fn light(d: DVec3) -> f64 {
    let along = d.dot(DVec3::new(0.3, -0.2, 1.0).normalize());
    100.0 * libm::exp(4.0 * (along - 1.0)) + 5.0 * (1.0 + d.y) + 3.0 * (1.0 + d.x * d.z)
}

#[test]
fn three_tables_of_one_light() {
    let table = |kind: u8, vertical: &[f64], horizontal: &[f64]| {
        let coordinates = [Coordinates::C, Coordinates::B, Coordinates::A][usize::from(kind) - 1];
        let text = Text::new(kind, vertical, horizontal).of(|vertical, horizontal| {
            light(coordinates.direction(Angles {
                vertical,
                horizontal,
            }))
        });
        let photometry = parse(&text).photometry;
        assert_eq!(photometry.coordinates(), coordinates);
        photometry
    };
    for (step, tolerance) in [(5.0, 0.8), (2.5, 0.2), (1.0, 0.032)] {
        let list = |from: f64, to: f64| steps(from, to, ((to - from) / step) as usize + 1);
        let c = table(1, &list(0.0, 180.0), &list(0.0, 360.0));
        let b = table(2, &list(-180.0, 180.0), &list(-90.0, 90.0));
        let a = table(3, &list(-90.0, 90.0), &list(-180.0, 180.0));
        for direction in directions() {
            let expected = light(direction);
            for photometry in [&c, &b, &a] {
                let actual = photometry.intensity(direction);
                assert!(
                    (actual - expected).abs() < tolerance,
                    "{:?} {direction} {actual} {expected}",
                    photometry.coordinates()
                );
            }
        }
        for photometry in [&b, &a] {
            assert_near(photometry.lumens(), c.lumens(), tolerance / 200.0);
            assert_near(
                photometry.zonal_lumens(),
                c.zonal_lumens(),
                tolerance / 50.0,
            );
            let widths = (photometry.beam_angle(), c.beam_angle());
            assert_near(
                widths.0.plane_0.unwrap(),
                widths.1.plane_0.unwrap(),
                tolerance / 10.0,
            );
            assert_near(
                widths.0.plane_90.unwrap(),
                widths.1.plane_90.unwrap(),
                tolerance / 10.0,
            );
            for plane in [0.0, 30.0, 90.0, 200.0] {
                let curves = photometry.polar_curve(plane, 25).into_iter();
                for ((at, actual), (also_at, expected)) in curves.zip(c.polar_curve(plane, 25)) {
                    assert_eq!(at, also_at);
                    assert!((actual - expected).abs() < 2.0 * tolerance);
                }
            }
        }
    }
}

/// Half of the sphere is dark where types A and B say nothing.
#[test]
fn what_is_behind_is_dark() {
    for kind in [2, 3] {
        let (vertical, horizontal) = (steps(-90.0, 90.0, 5), steps(-90.0, 90.0, 5));
        let text = Text::new(kind, &vertical, &horizontal).of(|_, _| 1.0);
        let photometry = parse_clean(&text).photometry;
        for direction in directions() {
            let expected = f64::from(direction.z > 0.0);
            assert_eq!(photometry.intensity(direction), expected, "{direction}");
        }
    }
}
