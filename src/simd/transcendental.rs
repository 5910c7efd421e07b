//! Logarithms, powers and angles in every lane, in plain f64 arithmetic: the same bits on every machine, unlike the
//! platform's own.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, FRAC_PI_8, LN_2, LOG2_E, PI, SQRT_2};

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

/// (−1)ᵏ/(2k + 1), the coefficients of arctan(q)/q in q². |q| is at most tan π/16 ≈ 0.1989, so the first
/// term left out is below 0.1989¹⁶ / 17 ≈ 3.6e-13 of the sum.
const ARCTAN: [f64; 8] = {
    let mut coefficients = [0.0; 8];
    let mut k = 0;
    while k < coefficients.len() {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        coefficients[k] = sign / (2 * k + 1) as f64;
        k += 1;
    }
    coefficients
};

/// tan π/16 = √(4 + 2√2) − 1 − √2
const TAN_PI_16: f64 = 0.198_912_367_379_658;

/// tan π/8 = √2 − 1
const TAN_PI_8: f64 = SQRT_2 - 1.0;

/// tan 3π/16 = √(4 − 2√2) + 1 − √2
const TAN_3_PI_16: f64 = 0.668_178_637_919_298_9;

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
    let is_above_zero = x.ge(F64x16::splat(simd, f64::MIN_POSITIVE));
    let x = is_above_zero.select(x, F64x16::splat(simd, 1.0));
    let result = exp2(simd, log2(simd, x) * exponent);
    is_above_zero.select(result, F64x16::splat(simd, 0.0))
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

/// The angle of (x, y) from the x axis towards y, −π to π, to 4e-13: 0 at the origin. The magnitudes are at most
/// 1e300. 0 has no sign: left of the origin on the axis, the angle is π.
#[inline(always)]
pub(crate) fn atan2<S: Simd>(simd: S, y: F64x16<S>, x: F64x16<S>) -> F64x16<S> {
    let zero = F64x16::splat(simd, 0.0);
    let (side, up) = (x.abs(), y.abs());
    let is_steep = up.gt(side);
    let (large, small) = (up.max(side), up.min(side));
    // arctan(small/large) is 0, π/8 or π/4 and arctan(q), q = (small − large t)/(large + small t),
    // where t is the tangent of that angle.
    let is_above_first = small.gt(large * TAN_PI_16);
    let is_above_second = small.gt(large * TAN_3_PI_16);
    let zero_or_first = is_above_first.select(F64x16::splat(simd, TAN_PI_8), zero);
    let tangent = is_above_second.select(F64x16::splat(simd, 1.0), zero_or_first);
    let zero_or_first = is_above_first.select(F64x16::splat(simd, FRAC_PI_8), zero);
    let base = is_above_second.select(F64x16::splat(simd, FRAC_PI_4), zero_or_first);
    let divisor = large + small * tangent;
    let divisor = divisor.gt(zero).select(divisor, F64x16::splat(simd, 1.0));
    let q = (small - large * tangent) / divisor;
    let angle = base + q * polynomial(simd, &ARCTAN, q * q);
    let angle = is_steep.select(F64x16::splat(simd, FRAC_PI_2) - angle, angle);
    let angle = x.lt(zero).select(F64x16::splat(simd, PI) - angle, angle);
    y.lt(zero).select(-angle, angle)
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

    struct Angle(f64, f64);

    impl Kernel for Angle {
        type Output = [f64; LANES];

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            let [y, x] = [self.0, self.1].map(|number| F64x16::splat(simd, number));
            atan2(simd, y, x).to_array()
        }
    }

    #[test]
    fn angles_agree_with_libm() {
        for step in 0..10_000 {
            let (y, x) = libm::sincos((f64::from(step) / 5000.0 - 0.9999) * PI);
            for radius in [1.0, 1e-30, 1e290] {
                let (y, x) = (y * radius, x * radius);
                for (name, level) in SimdLevel::available() {
                    let [angle, ..] = level.run(Angle(y, x));
                    let error = (angle - libm::atan2(y, x)).abs();
                    assert!(error <= 2e-13, "{y}, {x} by {name}: {error}");
                }
            }
        }
        for (y, x) in [
            (0.0, 0.0),
            (0.0, 1.0),
            (1.0, 0.0),
            (0.0, -1.0),
            (-1.0, 0.0),
            (-1.0, 1.0),
        ] {
            let [angle, ..] = SimdLevel::default().run(Angle(y, x));
            assert!(
                (angle - libm::atan2(y, x)).abs() < 1e-15,
                "{y}, {x}: {angle}"
            );
        }
    }

    #[test]
    fn tangents_are_those_of_the_angles() {
        assert!((TAN_PI_16 - libm::tan(PI / 16.0)).abs() < 1e-15);
        assert!((TAN_PI_8 - libm::tan(PI / 8.0)).abs() < 1e-15);
        assert!((TAN_3_PI_16 - libm::tan(3.0 * PI / 16.0)).abs() < 1e-15);
    }

    struct Power(f64, f64);

    impl Kernel for Power {
        type Output = [f64; LANES];

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            power(simd, F64x16::splat(simd, self.0), self.1).to_array()
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
