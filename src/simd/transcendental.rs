//! Logarithms and powers in every lane, in plain f64 arithmetic: the same bits on every machine, unlike the
//! platform's own.

use std::f64::consts::{LN_2, LOG2_E, PI, SQRT_2};

use fearless_simd::Simd;

use super::F64x16;

/// 1/(2k + 1), the coefficients of artanh(s)/s in s². s² is at most (3 − 2√2)² ≈ 0.0295, so the
/// first term left out is below 0.0295⁷ / 15 ≈ 1.3e-12 of the sum.
const ARTANH: [f64; 7] = {
    let mut coefficients = [0.0; 7];
    let mut k = 0;
    while k < coefficients.len() {
        coefficients[k] = 1.0 / (2 * k + 1) as f64;
        k += 1;
    }
    coefficients
};

/// (−1)ᵏ/(2k + 1), the coefficients of arctan(t)/t in t². t² is at most (√2 − 1)² ≈ 0.1716, so the first term
/// left out of arctan(t) is below 0.4143 · 0.1716¹² / 25 ≈ 1.1e-11.
const ARCTANGENT: [f64; 12] = {
    let mut coefficients = [0.0; 12];
    let mut k = 0;
    while k < coefficients.len() {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        coefficients[k] = sign / (2 * k + 1) as f64;
        k += 1;
    }
    coefficients
};

/// 1/k!, the coefficients of eˣ. |x| is at most ½ ln 2 ≈ 0.3466, so the first term left out is
/// below 0.3466¹⁰ / 10! ≈ 7e-12.
const EXPONENTIAL: [f64; 10] = {
    let mut coefficients = [1.0; 10];
    let mut k = 1;
    while k < coefficients.len() {
        coefficients[k] = coefficients[k - 1] / k as f64;
        k += 1;
    }
    coefficients
};

/// Below this power of two, exp2 gives 0: the smallest normal f64 is 2⁻¹⁰²².
const LOWEST_EXPONENT: f64 = -1022.0;

/// Added and subtracted, this rounds a number of far smaller magnitude to an integer: the last bit
/// of a number from 2⁵² to 2⁵³ stands for 1.
const ROUNDS: f64 = 1.5 * (1_u64 << 52) as f64;

/// The digits of an f64, without sign and exponent.
const MANTISSA: u64 = (1 << 52) - 1;

/// xⁿ in every lane for normal x above 0; 0 for what is not. Relative error: below 1e-11 · (1 + |n log₂ x|), as
/// long as the result is a normal number; 0 below that. n log₂ x is at most 1023.
#[inline(always)]
pub(crate) fn power<S: Simd>(simd: S, x: F64x16<S>, exponent: f64) -> F64x16<S> {
    powers(simd, x, F64x16::splat(simd, exponent))
}

/// [`power`] with an exponent for each lane.
///
/// A function of its own: inlined wherever a color is raised to a power, it would take minutes to compile.
#[inline(never)]
pub(crate) fn powers<S: Simd>(simd: S, x: F64x16<S>, exponent: F64x16<S>) -> F64x16<S> {
    simd.vectorize(
        #[inline(always)]
        || {
            let is_above_zero = x.ge(F64x16::splat(simd, f64::MIN_POSITIVE));
            let x = is_above_zero.select(x, F64x16::splat(simd, 1.0));
            let result = exp2(simd, log2(simd, x) * exponent);
            is_above_zero.select(result, F64x16::splat(simd, 0.0))
        },
    )
}

/// log₂ x of normal numbers: with x = 2ᵉ m, m from 1/√2 to √2, log₂ x = e + 2 log₂ e · artanh(s),
/// s = (m − 1)/(m + 1).
#[inline(always)]
pub(crate) fn log2<S: Simd>(simd: S, x: F64x16<S>) -> F64x16<S> {
    let bits = x.to_bits();
    // An integer below 2⁵² in the digits of 2⁵² is that much more.
    const INTEGERS: f64 = (1_u64 << 52) as f64;
    let exponent =
        F64x16::from_bits(bits.shifted_down(52).or(INTEGERS.to_bits())) - (INTEGERS + 1023.0);
    let mantissa = F64x16::from_bits(bits.and(MANTISSA).or(1.0_f64.to_bits()));
    let is_large = mantissa.gt(F64x16::splat(simd, SQRT_2));
    let exponent = is_large.select(exponent + 1.0, exponent);
    let mantissa = is_large.select(mantissa * 0.5, mantissa);
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    exponent + s * (2.0 * LOG2_E) * polynomial(simd, &ARTANH, s * s)
}

/// 2ˣ for x up to 1023: the integer part by the exponent's bits, the rest, at most ½, by the series
/// of e^(x ln 2).
#[inline(always)]
pub(crate) fn exp2<S: Simd>(simd: S, x: F64x16<S>) -> F64x16<S> {
    let is_tiny = x.lt(F64x16::splat(simd, LOWEST_EXPONENT));
    let rounded = x + ROUNDS;
    let rest = (x - (rounded - ROUNDS)) * LN_2;
    // The lowest digits of `rounded` are the integer.
    let power = F64x16::from_bits(rounded.to_bits().plus(1023).shifted_up(52));
    let result = polynomial(simd, &EXPONENTIAL, rest) * power;
    is_tiny.select(F64x16::splat(simd, 0.0), result)
}

/// The angle of (x, y) in degrees from the x axis towards the y axis, from 0 to 360, of which `radius` is the
/// length; 0 where that is 0. It is within 2e-9 of a degree.
///
/// With the larger and the smaller of |x| and |y|, half of the angle between the larger's axis and the vector has
/// the tangent t = smaller/(radius + larger), which is at most √2 − 1.
#[inline(never)]
pub(crate) fn angle<S: Simd>(simd: S, place: [F64x16<S>; 2], radius: F64x16<S>) -> F64x16<S> {
    simd.vectorize(
        #[inline(always)]
        || angle_of(simd, place, radius),
    )
}

#[inline(always)]
fn angle_of<S: Simd>(simd: S, [x, y]: [F64x16<S>; 2], radius: F64x16<S>) -> F64x16<S> {
    let zero = F64x16::splat(simd, 0.0);
    let (width, height) = (x.abs(), y.abs());
    let is_steep = height.gt(width);
    let smaller = is_steep.select(width, height);
    let larger = is_steep.select(height, width);
    let t = smaller / (radius + larger).max(F64x16::splat(simd, f64::MIN_POSITIVE));
    let from_axis = t * polynomial(simd, &ARCTANGENT, t * t) * (2.0 * 180.0 / PI);
    let in_quadrant = is_steep.select(-from_axis + 90.0, from_axis);
    let above = x.lt(zero).select(-in_quadrant + 180.0, in_quadrant);
    y.lt(zero).select(-above + 360.0, above)
}

/// Σ c_k xᵏ, even and odd powers apart: two chains of dependent sums in place of one.
#[inline(always)]
fn polynomial<S: Simd, const N: usize>(
    simd: S,
    coefficients: &[f64; N],
    x: F64x16<S>,
) -> F64x16<S> {
    let x2 = x * x;
    let (mut even, mut odd) = (F64x16::splat(simd, 0.0), F64x16::splat(simd, 0.0));
    for pair in coefficients.chunks(2).rev() {
        even = even * x2 + pair[0];
        odd = odd * x2 + pair.get(1).copied().unwrap_or(0.0);
    }
    even + odd * x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Kernel, LANES, SimdLevel};

    struct Power(f64, f64);

    impl Kernel for Power {
        type Output = [f64; LANES];

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            power(simd, F64x16::splat(simd, self.0), self.1).to_array()
        }
    }

    struct Angle([f64; 2]);

    impl Kernel for Angle {
        type Output = f64;

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> f64 {
            let [x, y] = [
                F64x16::splat(simd, self.0[0]),
                F64x16::splat(simd, self.0[1]),
            ];
            angle(simd, [x, y], (x * x + y * y).sqrt()).to_array()[0]
        }
    }

    #[test]
    fn angles_agree_with_libm() {
        for step in 0..=7200 {
            let degrees = f64::from(step) / 20.0;
            let (sine, cosine) = libm::sincos(degrees.to_radians());
            for size in [1e-100, 1e-3, 1.0, 1e100] {
                let [x, y] = [cosine * size, sine * size];
                let expected = libm::atan2(y, x).to_degrees();
                let expected = if expected < 0.0 {
                    expected + 360.0
                } else {
                    expected
                };
                for (name, level) in SimdLevel::available() {
                    let found = level.run(Angle([x, y]));
                    let error = (found - expected).abs();
                    assert!(error < 2e-9, "{degrees}, {size} by {name}: {error}");
                    assert!((0.0..=360.0).contains(&found));
                }
            }
        }
        // On the axes it is exact, and what has no direction lies on the first of them.
        for (x, y, expected) in [
            (0.0, 0.0, 0.0),
            (2.0, 0.0, 0.0),
            (0.0, 2.0, 90.0),
            (-2.0, 0.0, 180.0),
            (0.0, -2.0, 270.0),
        ] {
            assert_eq!(SimdLevel::default().run(Angle([x, y])), expected);
        }
    }

    #[test]
    fn powers_agree_with_libm() {
        for exponent in [
            -2.4,
            -0.5,
            0.159_301_757_812_5,
            1.0 / 2.4,
            1.0,
            2.4,
            78.84375,
        ] {
            for step in -300..=300 {
                let x = (f64::from(step) / 10.0).exp2() * 1.07;
                let expected = libm::pow(x, exponent);
                let size = (exponent * x.log2()).abs();
                for (name, level) in SimdLevel::available() {
                    let [result, ..] = level.run(Power(x, exponent));
                    let error = (result / expected - 1.0).abs();
                    if size < 1000.0 {
                        assert!(
                            error <= 1e-11 * (1.0 + size),
                            "{x}^{exponent} by {name}: {error}"
                        );
                    }
                }
            }
            for x in [0.0, -0.0, -1.0, f64::NEG_INFINITY, f64::NAN, 1e-310] {
                assert_eq!(SimdLevel::default().run(Power(x, exponent))[0], 0.0);
            }
        }
    }
}
