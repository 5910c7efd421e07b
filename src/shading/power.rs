//! cosⁿ of L7 in plain f64 arithmetic: the same bits on every machine, unlike the platform's `pow`.

use fearless_simd::Simd;

use crate::simd::{F64x16, exp2, log2};

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
