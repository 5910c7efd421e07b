//! Metals against the complex form, and against dielectrics.

use super::*;

/// x + i y, as much of it as the amplitudes take.
#[derive(Clone, Copy)]
struct Complex(f64, f64);

impl Complex {
    fn plus(self, other: Self) -> Self {
        Self(self.0 + other.0, self.1 + other.1)
    }

    fn minus(self, other: Self) -> Self {
        Self(self.0 - other.0, self.1 - other.1)
    }

    fn times(self, other: Self) -> Self {
        Self(
            self.0 * other.0 - self.1 * other.1,
            self.0 * other.1 + self.1 * other.0,
        )
    }

    fn square(self) -> f64 {
        self.0 * self.0 + self.1 * self.1
    }

    /// The root in the upper half-plane: of waves in a metal, the one that fades.
    fn root(self) -> Self {
        let modulus = self.0.hypot(self.1);
        let angle = self.1.atan2(self.0) / 2.0;
        let length = modulus.sqrt();
        Self(length * angle.cos(), length * angle.sin())
    }
}

/// ½ (|r∥|² + |r⊥|²) with r⊥ = (c − g)/(c + g), r∥ = (η² c − g)/(η² c + g), g = √(η² − s²).
fn by_amplitudes(c: f64, n: f64, k: f64) -> f64 {
    let eta = Complex(n, k);
    let square = eta.times(eta);
    let g = square.minus(Complex((1.0 - c) * (1.0 + c), 0.0)).root();
    let c = Complex(c, 0.0);
    let part = |a: Complex| a.minus(g).square() / a.plus(g).square();
    0.5 * (part(square.times(c)) + part(c))
}

#[test]
fn reflectance_at_angles() {
    let published = [
        (0.2, 3.0, 0.0, 0.923_371_647_510),
        (0.2, 3.0, 60.0, 0.918_411_084_659),
        (0.2, 3.0, 85.0, 0.963_598_561_778),
        (2.9, 3.1, 0.0, 0.532_634_971_797),
        (2.9, 3.1, 60.0, 0.515_658_688_218),
        (2.9, 3.1, 85.0, 0.660_118_722_346),
    ];
    for (n, k, degrees, reflectance) in published {
        assert_published(conductor(cosine(degrees), n, k), reflectance, 12);
    }
}

#[test]
fn equals_the_complex_form() {
    for n in [0.0, 0.02, 0.2, 0.7, 1.0, 1.01, 1.5, 2.9, 6.0, 30.0] {
        for k in [1e-6, 0.01, 0.3, 1.0, 3.1, 8.0, 50.0] {
            for c in cosines() {
                let [real, complex] = [conductor(c, n, k), by_amplitudes(c, n, k)];
                assert!(
                    (real - complex).abs() < 1e-12,
                    "{n}, {k}, {c}: {real}, {complex}"
                );
                assert!((0.0..=1.0).contains(&real), "{n}, {k}, {c}: {real}");
            }
        }
    }
}

#[test]
fn without_absorption_it_is_a_dielectric() {
    for n in [
        0.3,
        0.75,
        1.0 - 1e-9,
        1.0,
        1.0 + 1e-9,
        1.000_3,
        1.33,
        1.5,
        2.4,
        40.0,
    ] {
        for c in cosines() {
            let [metal, glass] = [conductor(c, n, 0.0), dielectric(c, n)];
            assert_eq!(metal.to_bits(), glass.to_bits(), "{n}, {c}");
        }
    }
}

#[test]
fn along_the_normal() {
    for n in [0.02_f64, 0.2, 1.0, 2.9, 30.0] {
        for k in [1e-6_f64, 0.01, 1.0, 8.0, 1e3] {
            let expected = ((n - 1.0) * (n - 1.0) + k * k) / ((n + 1.0) * (n + 1.0) + k * k);
            let relative = conductor(1.0, n, k) / expected - 1.0;
            assert!(relative.abs() < 1e-14, "{n}, {k}: {relative}");
        }
    }
}

/// R of large k is 1 − 4 n/k² times (1/c + c)/2, but for terms of the relative size (n² + 1)/k².
#[test]
fn strong_absorption_reflects_nearly_all() {
    for k in [1e3, 1e4, 1e5] {
        let n = 2.0;
        for c in cosines().skip(20) {
            let missing = 1.0 - conductor(c, n, k);
            let expected = 4.0 * n / (k * k) * (1.0 / c + c) / 2.0;
            assert!(
                (missing - expected).abs() < 0.5 * expected / k + 3e-16,
                "{k}, {c}: {missing}, {expected}"
            );
        }
    }
    for k in [1e9, 1e30, 1e70] {
        assert_eq!(conductor(0.5, 1.0, k), 1.0);
    }
}

#[test]
fn grazing_light_is_reflected() {
    for (n, k) in [(0.0, 1.0), (0.2, 3.0), (1.0, 1e-9), (2.9, 3.1), (1e3, 1e3)] {
        assert_eq!(conductor(0.0, n, k), 1.0, "{n}, {k}");
    }
}
