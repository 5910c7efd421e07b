//! cosⁿ of L7 in plain f64 arithmetic: the same bits on every machine, unlike the platform's `pow`.

use std::f64::consts::{LN_2, LOG2_E, SQRT_2};

use fearless_simd::Simd;

use crate::simd::F64x16;

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

/// Below this power of two, exp2 gives 0: the smallest normal f64 is 2⁻¹⁰²².
const LOWEST_EXPONENT: f64 = -1022.0;

/// Added and subtracted, this rounds a number of far smaller magnitude to an integer: the last bit
/// of a number from 2⁵² to 2⁵³ stands for 1.
const ROUNDS: f64 = 1.5 * (1_u64 << 52) as f64;

/// The digits of an f64, without sign and exponent.
const MANTISSA: u64 = (1 << 52) - 1;

/// baseⁿ for a base from 0 to 1 and n above 0. Relative error: below 2e-9 where the result is above
/// 1e-300, and below 1e-10 where it is above 1e-30: far less than the rounding of a pixel to f32. The
/// result is 0 below 2⁻¹⁰²².
///
/// A base above 1, as a cosine may be by rounding, counts as 1.
#[inline(always)]
pub(super) fn powers<S: Simd>(simd: S, base: F64x16<S>, exponent: F64x16<S>) -> F64x16<S> {
    let one = F64x16::splat(simd, 1.0);
    let zero = F64x16::splat(simd, 0.0);
    let is_above_zero = base.ge(F64x16::splat(simd, f64::MIN_POSITIVE));
    if !is_above_zero.any() {
        return zero;
    }
    let base = is_above_zero.select(base.lt(one).select(base, one), one);
    is_above_zero.select(exp2(simd, exponent * log2(simd, base)), zero)
}

/// Powers up to this come from multiplication: n factors, so n − 1 roundings of 2⁻⁵³ in effect, which are
/// 2⁻³⁷ of the power at most.
const LARGEST_WHOLE: u32 = 1 << 16;

/// An exponent whose powers are best had by multiplication: a whole number.
#[inline(always)]
pub(super) fn whole_exponent(exponent: f64) -> Option<u32> {
    let whole = exponent as u32;
    (f64::from(whole) == exponent && (1..=LARGEST_WHOLE).contains(&whole)).then_some(whole)
}

/// baseⁿ in every lane for n from 1 to [`LARGEST_WHOLE`], by squares: a base below 0 counts as 0, one above 1
/// as 1.
#[inline(always)]
pub(super) fn whole_powers<S: Simd>(simd: S, base: F64x16<S>, exponent: u32) -> F64x16<S> {
    let base = base.max(F64x16::splat(simd, 0.0));
    let base = base.min(F64x16::splat(simd, 1.0));
    let mut result = base;
    for bit in (0..exponent.ilog2()).rev() {
        result = result * result;
        if exponent >> bit & 1 == 1 {
            result = result * base;
        }
    }
    result
}

/// log₂ x of normal numbers: with x = 2ᵉ m, m from 1/√2 to √2, log₂ x = e + 2 log₂ e · artanh(s),
/// s = (m − 1)/(m + 1).
#[inline(always)]
fn log2<S: Simd>(simd: S, x: F64x16<S>) -> F64x16<S> {
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
fn exp2<S: Simd>(simd: S, x: F64x16<S>) -> F64x16<S> {
    let is_tiny = x.lt(F64x16::splat(simd, LOWEST_EXPONENT));
    let rounded = x + ROUNDS;
    let rest = (x - (rounded - ROUNDS)) * LN_2;
    // The lowest digits of `rounded` are the integer.
    let power = F64x16::from_bits(rounded.to_bits().plus(1023).shifted_up(52));
    let result = polynomial(simd, &EXPONENTIAL, rest) * power;
    is_tiny.select(F64x16::splat(simd, 0.0), result)
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

    /// [`powers`] of one base.
    fn power(base: f64, exponent: f64) -> f64 {
        let [result, ..] = SimdLevel::default().run(Power { base, exponent });
        result
    }

    /// In all lanes.
    struct Power {
        base: f64,
        exponent: f64,
    }

    impl Kernel for Power {
        type Output = [f64; LANES];

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            let base = F64x16::splat(simd, self.base);
            powers(simd, base, F64x16::splat(simd, self.exponent)).to_array()
        }
    }

    /// What the doc comment of [`powers`] promises.
    const RELATIVE_ERROR: f64 = 2e-9;

    #[test]
    fn agrees_with_the_standard_library() {
        for exponent in [0.01, 0.5, 1.0, 2.0, 20.0, 50.0, 80.0, 1e3, 1e4, 1e6] {
            for step in 1..=4000 {
                // Dense near 1, where large exponents have their lobe.
                for base in [
                    f64::from(step) / 4000.0,
                    1.0 - f64::from(step) / (exponent * 200.0),
                ] {
                    if base <= 0.0 {
                        continue;
                    }
                    let expected = base.powf(exponent);
                    let error = (power(base, exponent) - expected).abs();
                    // The rounding of log₂ grows with the exponent of the result, at most 1000.
                    assert!(
                        error <= RELATIVE_ERROR * expected || expected < 1e-300,
                        "{base}^{exponent}"
                    );
                }
            }
        }
    }

    struct WholePower(f64, u32);

    impl Kernel for WholePower {
        type Output = [f64; LANES];

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            whole_powers(simd, F64x16::splat(simd, self.0), self.1).to_array()
        }
    }

    #[test]
    fn whole_powers_agree_with_the_standard_library() {
        /// 2⁻³⁷, and what the library's function may be off.
        const ERROR: f64 = 1.1 / (1_u64 << 37) as f64;
        for exponent in [1, 2, 3, 7, 20, 50, 80, 127, 1000, 65_535, 65_536] {
            assert_eq!(whole_exponent(f64::from(exponent)), Some(exponent));
            for step in 0..=1000 {
                let base = 1.0 - f64::from(step) / (300.0 + f64::from(exponent) * 5.0);
                let [power, ..] = SimdLevel::default().run(WholePower(base, exponent));
                let expected = base.max(0.0).powf(f64::from(exponent));
                let error = (power - expected).abs();
                assert!(error <= ERROR * expected + 1e-300, "{base}^{exponent}");
            }
            assert_eq!(SimdLevel::default().run(WholePower(1.5, exponent))[0], 1.0);
            assert_eq!(SimdLevel::default().run(WholePower(-1.5, exponent))[0], 0.0);
        }
        for exponent in [0.0, 0.5, 50.1, 65_537.0, 1e9, f64::MAX] {
            assert_eq!(whole_exponent(exponent), None);
        }
    }

    #[test]
    fn exact_where_it_can_be() {
        for exponent in [0.3, 1.0, 50.0, 1e9] {
            assert_eq!(power(1.0, exponent), 1.0);
            assert_eq!(power(1.0 + f64::EPSILON, exponent), 1.0);
            assert_eq!(power(0.0, exponent), 0.0);
        }
        assert_eq!(power(0.5, 20.0), 2.0_f64.powi(-20));
        assert_eq!(power(0.25, 600.0), 0.0);
    }
}
