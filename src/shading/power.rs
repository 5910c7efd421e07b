//! cosⁿ of L7 in plain f64 arithmetic: the same bits on every machine, unlike the platform's `pow`.

use std::f64::consts::{LN_2, LOG2_E, SQRT_2};

/// Terms of the series of [`log2`]: s² is at most (3 − 2√2)² ≈ 0.0295, so the first term left out
/// is below 0.0295¹¹ / 23 ≈ 6e-19 of the sum.
const LOG_TERMS: u32 = 11;

/// Terms of the series of [`exp2`]: |x ln 2| is at most 0.3466, so the first term left out is below
/// 0.3466¹⁴ / 14! ≈ 4e-18.
const EXP_TERMS: u32 = 14;

/// Below this power of two, exp2 gives 0: the smallest normal f64 is 2⁻¹⁰²².
const LOWEST_EXPONENT: f64 = -1022.0;

/// baseⁿ for a base from 0 to 1 and n above 0. Relative error: below 1e-12 where the result is
/// above 1e-300, and 0 below that.
///
/// A base may be above 1 by rounding, as cosines are.
pub fn power(base: f64, exponent: f64) -> f64 {
    if base < f64::MIN_POSITIVE {
        return 0.0;
    }
    exp2(exponent * log2(base))
}

/// log₂ x of a normal number: with x = 2ᵉ m, m from 1/√2 to √2, log₂ x = e + 2 log₂ e · artanh(s),
/// s = (m − 1)/(m + 1).
fn log2(x: f64) -> f64 {
    const MANTISSA: u64 = (1 << 52) - 1;
    let bits = x.to_bits();
    let exponent = (bits >> 52) as i32 - 1023;
    let mantissa = f64::from_bits((bits & MANTISSA) | 1.0_f64.to_bits());
    let (exponent, mantissa) = if mantissa > SQRT_2 {
        (exponent + 1, mantissa * 0.5)
    } else {
        (exponent, mantissa)
    };
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let s2 = s * s;
    let series = (0..LOG_TERMS)
        .rev()
        .fold(0.0, |sum, term| sum * s2 + 1.0 / f64::from(2 * term + 1));
    f64::from(exponent) + 2.0 * LOG2_E * s * series
}

/// 2ˣ for x up to 1023: the integer part by the exponent's bits, the rest, at most ½, by the series
/// of e^(x ln 2).
fn exp2(x: f64) -> f64 {
    if x < LOWEST_EXPONENT {
        return 0.0;
    }
    let integer = x.round_ties_even();
    let rest = (x - integer) * LN_2;
    let series = (1..EXP_TERMS)
        .rev()
        .fold(1.0, |sum, term| 1.0 + sum * rest / f64::from(term));
    series * f64::from_bits(((integer as i64 + 1023) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the doc comment of [`power`] promises.
    const RELATIVE_ERROR: f64 = 1e-12;

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

    #[test]
    fn exact_where_it_can_be() {
        for exponent in [0.3, 1.0, 50.0, 1e9] {
            assert_eq!(power(1.0, exponent), 1.0);
            assert_eq!(power(0.0, exponent), 0.0);
        }
        assert_eq!(power(0.5, 20.0), 2.0_f64.powi(-20));
        assert_eq!(power(0.25, 600.0), 0.0);
    }
}
