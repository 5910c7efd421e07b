//! Luminous flux of a table of intensities.
//!
//! Two conventions. *Zonal lumens* (IES LM-46; the figures of reports): each zone between two vertical angles
//! has the mean of the intensities at its borders times its solid angle 2π(cos θ₁ − cos θ₂). *Lumens* are the
//! exact integral of what is rendered, the table that is bilinear in its angles. In public files they differ by
//! 0.0001 % (steps of half a degree) to 0.6 % (steps of 5° about a narrow beam).

use super::coordinates::Coordinates;
use super::photometry::{Photometry, Symmetry};

/// Two integrals over a span of latitudes from m − k to m + k, in radians, with the cosine c of latitude
/// (the sine for type C, whose angles start at a pole).
struct Span {
    /// ∫ c: the solid angle per radian around.
    whole: f64,
    /// ∫ c (x − m)/k: what half of a difference of the ends weighs.
    slope: f64,
}

impl Span {
    fn new(low: f64, high: f64, coordinates: Coordinates) -> Self {
        let middle = low.midpoint(high).to_radians();
        let half = ((high - low) / 2.0).to_radians();
        let (sin_m, cos_m) = libm::sincos(middle);
        // sin θ about its middle, or cos θ.
        let (value, derivative) = match coordinates {
            Coordinates::C => (sin_m, cos_m),
            Coordinates::A | Coordinates::B => (cos_m, -sin_m),
        };
        Self {
            whole: 2.0 * value * libm::sin(half),
            slope: 2.0 * derivative * first_moment(half),
        }
    }
}

/// (sin k − k cos k)/k = ∫₀ᵏ x sin x dx / k, also where both are nearly the same.
fn first_moment(k: f64) -> f64 {
    if k.abs() > 0.25 {
        let (sin, cos) = libm::sincos(k);
        return (sin - k * cos) / k;
    }
    // Σ (−1)ⁿ⁺¹ 2n k²ⁿ/(2n + 1)!; the first term left out is below 1e-18 of the sum.
    const COEFFICIENTS: [f64; 6] = [
        1.0 / 3.0,
        -1.0 / 30.0,
        1.0 / 840.0,
        -1.0 / 45_360.0,
        1.0 / 3_991_680.0,
        -1.0 / 518_918_400.0,
    ];
    let square = k * k;
    let sum = COEFFICIENTS.iter().rev();
    sum.fold(0.0, |sum, coefficient| sum * square + coefficient) * square
}

impl Photometry {
    /// The luminous flux by the zonal method, in lm: as reports of photometry state it.
    pub fn zonal_lumens(&self) -> f64 {
        self.flux(false)
    }

    /// The luminous flux in lm: the integral of [`Photometry::intensity`] over all directions, in closed form.
    pub fn lumens(&self) -> f64 {
        self.flux(true)
    }

    fn flux(&self, with_slope: bool) -> f64 {
        let coordinates = self.coordinates();
        let (vertical, horizontal) = self.angles();
        let value = |v: usize, h: usize| self.value(v, h).unwrap_or_default();
        let times = match self.symmetry() {
            Symmetry::Axial | Symmetry::None => 1.0,
            Symmetry::Quadrants => 4.0,
            Symmetry::Mirrored | Symmetry::MirroredAcross => 2.0,
        };
        if self.symmetry() == Symmetry::Axial {
            let mut sum = 0.0;
            for (v, &[low, high]) in vertical.array_windows().enumerate() {
                let span = Span::new(low, high, coordinates);
                let (a, b) = (value(v, 0), value(v + 1, 0));
                sum += span.part(a, b, with_slope);
            }
            return sum * std::f64::consts::TAU;
        }
        // The mean over two lines around the poles is exact where the table is linear around.
        let mut sum = 0.0;
        match coordinates {
            Coordinates::C | Coordinates::A => {
                for (v, &[low, high]) in vertical.array_windows().enumerate() {
                    let span = Span::new(low, high, coordinates);
                    for (h, &[from, to]) in horizontal.array_windows().enumerate() {
                        let a = value(v, h).midpoint(value(v, h + 1));
                        let b = value(v + 1, h).midpoint(value(v + 1, h + 1));
                        sum += span.part(a, b, with_slope) * (to - from).to_radians();
                    }
                }
            }
            Coordinates::B => {
                for (h, &[low, high]) in horizontal.array_windows().enumerate() {
                    let span = Span::new(low, high, coordinates);
                    for (v, &[from, to]) in vertical.array_windows().enumerate() {
                        let a = value(v, h).midpoint(value(v + 1, h));
                        let b = value(v, h + 1).midpoint(value(v + 1, h + 1));
                        sum += span.part(a, b, with_slope) * (to - from).to_radians();
                    }
                }
            }
        }
        sum * times
    }
}

impl Span {
    /// ∫ of what is linear from `a` to `b`; of its mean alone where `with_slope` is false.
    fn part(&self, a: f64, b: f64, with_slope: bool) -> f64 {
        let mean = a.midpoint(b) * self.whole;
        if with_slope {
            mean + (b - a) / 2.0 * self.slope
        } else {
            mean
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_meets_the_formula() {
        for k in [0.2_f64, 0.249_999, 0.250_001, 0.3] {
            let formula = (k.sin() - k * k.cos()) / k;
            assert!((first_moment(k) - formula).abs() < 1e-14, "{k}");
        }
        let tiny = 1e-9;
        assert!((first_moment(tiny) - tiny * tiny / 3.0).abs() < 1e-32);
        assert_eq!(first_moment(0.0), 0.0);
    }

    /// Constant intensity: solid angle.
    #[test]
    fn spans_add_up_to_the_sphere() {
        for coordinates in [Coordinates::A, Coordinates::B, Coordinates::C] {
            let (south, north) = coordinates.poles();
            let step = (north - south) / 7.0;
            let spans = (0..7).map(|i| south + step * f64::from(i));
            let whole: f64 = spans
                .map(|low| Span::new(low, low + step, coordinates).whole)
                .sum();
            assert!((whole - 2.0).abs() < 1e-14);
        }
    }
}
