//! f(θ) of a spot at the points of a packet.

use fearless_simd::Simd;

use crate::math::SAFE_SQUARES;
#[cfg(test)]
use crate::simd::LANES;
use crate::simd::{DVec3x16, F64x16};
use crate::visibility::{PACKETS, Points, columns};
use crate::world::SpotLight;
use crate::world::light::{Cone, Falloff};

/// 1/√x, and 1/x, also where the f32 of x has not all its digits.
#[inline(always)]
pub(super) fn inverse_roots<S: Simd>(simd: S, square: F64x16<S>) -> [F64x16<S>; 2] {
    let is_safe = square.is_within(simd, SAFE_SQUARES);
    let mut inverse = square.nearly_inverse_root(simd);
    let mut inverse_square = inverse * inverse;
    if (!is_safe).any() {
        let one = F64x16::splat(simd, 1.0);
        inverse = is_safe.select(inverse, one / square.sqrt());
        inverse_square = is_safe.select(inverse_square, one / square);
    }
    [inverse, inverse_square]
}

/// f(θ) of a spot, from the ways to it and one over their lengths. 0 where it cannot be told, which is at the
/// spot itself.
#[inline(always)]
pub(super) fn falloff<S: Simd>(
    simd: S,
    spot: &SpotLight,
    to_light: DVec3x16<S>,
    inverse: F64x16<S>,
) -> F64x16<S> {
    let zero = F64x16::splat(simd, 0.0);
    let one = F64x16::splat(simd, 1.0);
    let axis = DVec3x16::splat(simd, spot.axis.get());
    let cos = -to_light.dot(axis) * inverse;
    // In two steps: a square of something small may be nothing.
    let across = to_light.cross(axis).times(inverse);
    let square = across.dot(across);
    // 1 − cos θ = sin²θ / (1 + cos θ), to the last digits where θ is small. No cone reaches beyond 90°.
    let is_before = cos.is_positive();
    let versine = square / (one + cos);
    let Cone {
        falloff,
        versine_outer,
        inverse_span,
        ..
    } = spot.cone;
    let clamped = |x: F64x16<S>| x.max(zero).min(one);
    let inside = clamped((F64x16::splat(simd, versine_outer) - versine) * inverse_span);
    let f = match falloff {
        Falloff::Smooth => inside * inside * (F64x16::splat(simd, 3.0) - inside * 2.0),
        Falloff::Gltf => inside * inside,
        Falloff::LinearAngle => {
            // tan(θ/2) = sin θ / (1 + cos θ)
            let angle = twice_arctangent(simd, square.sqrt() / (one + cos));
            let x = (F64x16::splat(simd, spot.cone.outer()) - angle) * spot.cone.inverse_angle;
            // Where the cone ends, one of the two may be rounded to 0 before the other.
            let is_inside = inside.is_positive();
            is_inside.select(clamped(x), zero)
        }
    };
    is_before.select(f, zero)
}

/// 2 arctan x for x from 0 to 1: arctan x = 2 arctan(x/(1 + √(1 + x²))), three times, so that the last is up to
/// tan(π/32) ≈ 0.0985; then the series Σ (−1)ᵏ x²ᵏ⁺¹/(2k + 1), whose first term left out is below 1e-18.
#[inline(always)]
fn twice_arctangent<S: Simd>(simd: S, x: F64x16<S>) -> F64x16<S> {
    /// (−1)ᵏ/(2k + 1)
    const COEFFICIENTS: [f64; 8] = [
        1.0,
        -1.0 / 3.0,
        1.0 / 5.0,
        -1.0 / 7.0,
        1.0 / 9.0,
        -1.0 / 11.0,
        1.0 / 13.0,
        -1.0 / 15.0,
    ];
    let one = F64x16::splat(simd, 1.0);
    let mut x = x;
    for _ in 0..3 {
        x = x / (one + (one + x * x).sqrt());
    }
    let square = x * x;
    let mut sum = F64x16::splat(simd, 0.0);
    for coefficient in COEFFICIENTS.into_iter().rev() {
        sum = sum * square + coefficient;
    }
    x * sum * 16.0
}

/// Which points that are hit have light of a spot, one bit for each: where f(θ) is above 0.
#[inline(always)]
pub(super) fn inside<S: Simd>(simd: S, spot: &SpotLight, points: &Points) -> [u32; PACKETS] {
    let mut inside = [0; PACKETS];
    for (packet, &hit) in points.hit.iter().enumerate() {
        if hit != 0 {
            inside[packet] = hit & inside_in(simd, spot, points, packet);
        }
    }
    inside
}

/// Of a packet.
#[inline(never)]
fn inside_in<S: Simd>(simd: S, spot: &SpotLight, points: &Points, packet: usize) -> u32 {
    simd.vectorize(
        #[inline(always)]
        || {
            let position = DVec3x16::load(simd, columns(&points.position, packet));
            let to_light = -position.minus(spot.position.0);
            let [inverse, _] = inverse_roots(simd, to_light.dot(to_light));
            falloff(simd, spot, to_light, inverse)
                .is_positive()
                .to_bits()
        },
    )
}

/// [`falloff`] at points at some ways from a spot, for tests.
#[cfg(test)]
pub(super) fn falloffs(spot: &SpotLight, ways: [[f64; 3]; LANES]) -> [f64; LANES] {
    struct At<'s>(&'s SpotLight, [[f64; 3]; LANES]);
    impl crate::simd::Kernel for At<'_> {
        type Output = [f64; LANES];

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            let Self(spot, ways) = self;
            let [x, y, z] = [0, 1, 2].map(|axis: usize| ways.map(|way| -way[axis]));
            let to_light = DVec3x16::load(simd, [&x, &y, &z]);
            let [inverse, _] = inverse_roots(simd, to_light.dot(to_light));
            falloff(simd, spot, to_light, inverse).to_array()
        }
    }
    crate::simd::SimdLevel::default().run(At(spot, ways))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::{DVec3, Direction, Point};
    use crate::units::{Intensity, Rgb};

    fn spot(inner: f64, outer: f64, falloff: Falloff) -> SpotLight {
        SpotLight {
            position: Point::new(0.0, 0.0, 0.0),
            axis: Direction::new(DVec3::NEG_Z).unwrap(),
            intensity: Intensity(Rgb([1.0; 3])),
            cone: Cone::new(inner, outer, falloff).unwrap(),
        }
    }

    /// f at so many degrees from the axis, at some distance.
    fn at(spot: &SpotLight, degrees: f64, distance: f64) -> f64 {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let way = [0.6 * sin, 0.8 * sin, -cos].map(|x| x * distance);
        falloffs(spot, [way; LANES])[0]
    }

    /// pbrt's, glTF's and Mitsuba's curves, computed apart to 13 digits.
    #[test]
    fn falloff_is_the_published_one() {
        for (falloff, expected) in [
            (Falloff::Smooth, 0.5700181841666),
            (Falloff::Gltf, 0.2990072972446),
            (Falloff::LinearAngle, 0.5),
        ] {
            let spot = spot(20.0, 30.0, falloff);
            for distance in [1e-120, 1e-12, 1.0, 1e12, 1e120] {
                let actual = at(&spot, 25.0, distance);
                assert!((actual - expected).abs() < 2e-13, "{falloff:?}: {actual}");
                for degrees in [0.0, 10.0, 19.999_999] {
                    assert_eq!(at(&spot, degrees, distance), 1.0);
                }
                for degrees in [30.000_001, 45.0, 90.0, 120.0, 180.0] {
                    assert_eq!(at(&spot, degrees, distance), 0.0);
                }
            }
        }
    }

    /// A millionth of a degree is as exact as 30 of them.
    #[test]
    fn small_cones_keep_their_digits() {
        for outer in [1e-6, 1e-3, 1.0, 60.0, 90.0] {
            let spot = spot(0.0, outer, Falloff::LinearAngle);
            for part in [0.25, 0.5, 0.75] {
                let actual = at(&spot, part * outer, 1.0);
                assert!((actual - (1.0 - part)).abs() < 1e-12, "{outer}: {actual}");
            }
            let spot = SpotLight {
                cone: Cone::new(0.0, outer, Falloff::Gltf).unwrap(),
                ..spot
            };
            let half = |degrees: f64| (degrees.to_radians() / 2.0).sin().powi(2);
            let expected = (1.0 - half(outer / 2.0) / half(outer)).powi(2);
            let actual = at(&spot, outer / 2.0, 1.0);
            assert!((actual - expected).abs() < 1e-12, "{outer}: {actual}");
        }
    }

    #[test]
    fn a_sharp_cone_has_an_edge() {
        for falloff in Falloff::ALL {
            let spot = spot(30.0, 30.0, falloff);
            assert_eq!(at(&spot, 30.0 - 1e-9, 1.0), 1.0);
            assert_eq!(at(&spot, 30.0 + 1e-9, 1.0), 0.0);
        }
    }

    /// At the spot and within the smallest numbers of it there is a number.
    #[test]
    fn there_is_a_number_at_the_apex() {
        for falloff in Falloff::ALL {
            let spot = spot(20.0, 30.0, falloff);
            for way in [0.0, 1e-320, 1e-170, 1e-150] {
                let f = falloffs(&spot, [[0.0, 0.0, -way]; LANES])[0];
                assert!((0.0..=1.0).contains(&f), "{way}: {f}");
            }
        }
    }
}
