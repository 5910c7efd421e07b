//! Fluxes against published figures and numeric quadrature.

use super::*;

#[test]
fn three_angles() {
    let text = Text::new(1, &[0.0, 45.0, 90.0], &[0.0]);
    let photometry =
        parse_clean(&text.of(|v, _| [100.0, 80.0, 10.0][(v / 45.0) as usize])).photometry;
    assert_near(photometry.lumens(), 351.161_243_192_6, 1e-12);
    // 2π (90 (1 − cos 45°) + 45 cos 45°)
    let zonal = std::f64::consts::TAU * (90.0 - 45.0 * 0.5_f64.sqrt());
    assert_near(photometry.zonal_lumens(), zonal, 1e-14);
}

/// The same intensity everywhere: 4π of it, or 2π.
#[test]
fn constant_intensity() {
    let sphere = 4.0 * std::f64::consts::PI;
    for (kind, vertical, horizontal, part) in [
        (1, steps(0.0, 180.0, 5), vec![0.0], 1.0),
        (1, steps(0.0, 90.0, 3), steps(0.0, 90.0, 4), 0.5),
        (1, steps(90.0, 180.0, 3), steps(0.0, 180.0, 4), 0.5),
        (1, steps(0.0, 180.0, 3), steps(90.0, 270.0, 4), 1.0),
        (1, steps(0.0, 180.0, 3), steps(0.0, 360.0, 4), 1.0),
        (2, steps(-90.0, 90.0, 3), steps(-90.0, 90.0, 4), 0.5),
        (2, steps(-90.0, 90.0, 3), steps(0.0, 90.0, 4), 0.5),
        (2, steps(-180.0, 180.0, 3), steps(0.0, 90.0, 4), 1.0),
        (3, steps(-90.0, 90.0, 3), steps(-90.0, 90.0, 4), 0.5),
        (3, steps(0.0, 90.0, 3), steps(0.0, 90.0, 4), 0.25),
        (3, steps(-90.0, 90.0, 3), steps(-180.0, 180.0, 4), 1.0),
    ] {
        let text = Text::new(kind, &vertical, &horizontal).of(|_, _| 2.0);
        let photometry = parse_clean(&text).photometry;
        assert_near(photometry.lumens(), 2.0 * sphere * part, 1e-14);
        assert_near(photometry.zonal_lumens(), 2.0 * sphere * part, 1e-14);
    }
}

/// Six nodes on −1 to 1 (Gauss and Legendre) with their weights.
const NODES: [(f64, f64); 3] = [
    (0.238_619_186_083_196_9, 0.467_913_934_572_691_04),
    (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (0.932_469_514_203_152, 0.171_324_492_379_170_34),
];

/// ∫ f over a span.
fn quadrature(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (middle, half) = (from.midpoint(to), (to - from) / 2.0);
    let pairs = NODES
        .iter()
        .map(|&(x, weight)| (f(middle - half * x) + f(middle + half * x)) * weight);
    pairs.sum::<f64>() * half
}

/// Whatever `intensity` says, over the sphere in the very directions.
fn numeric(photometry: &Photometry) -> f64 {
    let coordinates = photometry.coordinates();
    let at = |vertical, horizontal| {
        let direction = coordinates.direction(Angles {
            vertical,
            horizontal,
        });
        photometry.intensity(direction)
    };
    let (vertical, horizontal) = photometry.angles();
    // All of the circle or of what is there, in cells without a kink.
    let mut around: Vec<f64> = match coordinates {
        Coordinates::C => (0..=360)
            .map(|i| f64::from(i) * 7.5)
            .take_while(|&h| h <= 360.0)
            .collect(),
        Coordinates::A | Coordinates::B => horizontal.iter().flat_map(|&h| [h, -h]).collect(),
    };
    around.sort_by(f64::total_cmp);
    around.dedup();
    let mut sum = 0.0;
    for &[v0, v1] in vertical.array_windows() {
        for &[h0, h1] in around.array_windows() {
            sum += quadrature(v0, v1, |v| {
                quadrature(h0, h1, |h| {
                    let jacobian = match coordinates {
                        Coordinates::C => libm::sin(v.to_radians()),
                        Coordinates::A => libm::cos(v.to_radians()),
                        Coordinates::B => libm::cos(h.to_radians()),
                    };
                    at(v, h) * jacobian
                })
            });
        }
    }
    let degree = 1.0_f64.to_radians();
    sum * degree * degree
}

#[test]
fn the_closed_form_is_the_integral() {
    for (kind, vertical, horizontal) in [
        (1, vec![0.0, 10.0, 15.0, 42.5, 60.0, 90.0], vec![0.0]),
        (
            1,
            vec![0.0, 10.0, 15.0, 42.5, 60.0, 80.0],
            vec![0.0, 22.5, 30.0, 90.0],
        ),
        (1, vec![90.0, 117.0, 180.0], vec![0.0, 22.5, 150.0, 180.0]),
        (1, vec![0.0, 33.0, 180.0], vec![90.0, 97.5, 225.0, 270.0]),
        (
            1,
            vec![0.0, 33.0, 90.0, 180.0],
            vec![0.0, 97.5, 225.0, 360.0],
        ),
        (
            1,
            vec![0.0, 33.0, 90.0, 180.0],
            vec![7.5, 97.5, 225.0, 367.5],
        ),
        (
            2,
            vec![-90.0, -20.0, 0.0, 33.0, 90.0],
            vec![-90.0, -11.0, 3.0, 90.0],
        ),
        (
            2,
            vec![-50.0, -20.0, 0.0, 33.0, 60.0],
            vec![0.0, 11.0, 30.0, 70.0],
        ),
        (
            3,
            vec![-90.0, -20.0, 0.0, 33.0, 90.0],
            vec![-90.0, -11.0, 3.0, 90.0],
        ),
        (
            3,
            vec![-50.0, -20.0, 0.0, 33.0, 60.0],
            vec![0.0, 11.0, 30.0, 70.0],
        ),
    ] {
        let text = Text::new(kind, &vertical, &horizontal);
        let text = text.of(|v, h| {
            100.0 + 50.0 * libm::sin(v * 0.1 + 1.0) + 30.0 * libm::cos(h.rem_euclid(360.0) * 0.3)
        });
        let mut photometry = parse(&text).photometry;
        // A table that was turned has its first plane at the end again.
        assert_near(photometry.lumens(), numeric(&photometry), 1e-9);
        let (exact, zonal) = (photometry.lumens(), photometry.zonal_lumens());
        assert_near(zonal, exact, 0.1);
        photometry = photometry.scaled(3.0);
        assert_near(photometry.lumens(), 3.0 * exact, 1e-14);
    }
}
