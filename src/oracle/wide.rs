//! Numbers of twice f64's length: the sum of two f64, about 106 bits.
//!
//! The oracle is the judge of the renderer, so it has to be right where f64 is not: a scene of a micrometre on
//! a sphere of a thousand kilometres, a light a thousand million kilometres away, coordinates of which only the last
//! digits differ. What was written is exact in them, and so are differences of what was written.
//!
//! The algorithms are those of Dekker 1971, "A floating-point technique for extending the available precision",
//! and Knuth's sum, as Joldes, Muller & Popescu 2017 bound them: an operation is off by less than 2⁻¹⁰⁰.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// 2⁻¹⁰⁰, by which one operation is off at most.
pub(super) const ROUNDING: f64 = 1.0 / (1_u128 << 100) as f64;

/// high + low, |low| at most half the last place of high.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Wide {
    high: f64,
    low: f64,
}

/// A number that the equations are computed in.
pub(super) trait Real:
    Copy
    + PartialEq
    + PartialOrd
    + From<f64>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// √a
    fn sqrt(self) -> Self;

    /// The nearest f64.
    fn narrow(self) -> f64;
}

impl Real for f64 {
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }

    fn narrow(self) -> f64 {
        self
    }
}

/// a + b, and what rounding takes from it (Knuth).
fn exact_sum(a: f64, b: f64) -> [f64; 2] {
    let sum = a + b;
    let of_b = sum - a;
    [sum, (a - (sum - of_b)) + (b - of_b)]
}

/// The same where |a| ≥ |b| (Dekker).
fn ordered_sum(a: f64, b: f64) -> Wide {
    let high = a + b;
    Wide {
        high,
        low: if high.is_finite() {
            b - (high - a)
        } else {
            0.0
        },
    }
}

/// The upper and the lower half of the digits (Veltkamp).
fn halves(a: f64) -> [f64; 2] {
    const SPLIT: f64 = 134_217_729.0; // 2²⁷ + 1
    let scaled = SPLIT * a;
    let upper = scaled - (scaled - a);
    [upper, a - upper]
}

/// a b, and what rounding takes from it (Dekker).
fn exact_product(a: f64, b: f64) -> [f64; 2] {
    let product = a * b;
    let ([a1, a2], [b1, b2]) = (halves(a), halves(b));
    [
        product,
        // In an order that is the same for b a.
        ((a1 * b1 - product) + (a1 * b2 + a2 * b1)) + a2 * b2,
    ]
}

impl From<f64> for Wide {
    fn from(value: f64) -> Self {
        Self {
            high: value,
            low: 0.0,
        }
    }
}

impl Add for Wide {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let [high, rest] = exact_sum(self.high, other.high);
        let [low, least] = exact_sum(self.low, other.low);
        let sum = ordered_sum(high, rest + low);
        ordered_sum(sum.high, sum.low + least)
    }
}

impl Neg for Wide {
    type Output = Self;

    fn neg(self) -> Self {
        Self {
            high: -self.high,
            low: -self.low,
        }
    }
}

impl Sub for Wide {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Wide {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let [high, low] = exact_product(self.high, other.high);
        let across = self.high * other.low + self.low * other.high;
        ordered_sum(high, low + across)
    }
}

impl Div for Wide {
    type Output = Self;

    /// A quotient in f64, and two corrections of it.
    fn div(self, other: Self) -> Self {
        let first = self.high / other.high;
        if !first.is_finite() || first == 0.0 {
            return Self::from(first);
        }
        let rest = self - other * Self::from(first);
        let second = rest.high / other.high;
        let rest = rest - other * Self::from(second);
        let third = rest.high / other.high;
        ordered_sum(first, second) + Self::from(third)
    }
}

impl Real for Wide {
    /// A root in f64, and two steps of Newton's method.
    fn sqrt(self) -> Self {
        let first = self.high.sqrt();
        if first == 0.0 || !first.is_finite() {
            return Self::from(first);
        }
        let mut root = Self::from(first);
        for _ in 0..2 {
            let rest = self - root * root;
            root = root + Self::from(rest.high / (2.0 * first));
        }
        root
    }

    fn narrow(self) -> f64 {
        self.high
    }
}

impl PartialOrd for Wide {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        match self.high.partial_cmp(&other.high) {
            Some(std::cmp::Ordering::Equal) => self.low.partial_cmp(&other.low),
            order => order,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wide(value: f64) -> Wide {
        Wide::from(value)
    }

    #[track_caller]
    fn assert_near(actual: Wide, expected: Wide) {
        let off = (actual - expected).narrow().abs();
        assert!(off <= ROUNDING * expected.narrow().abs(), "{off:e}");
    }

    #[test]
    fn what_f64_forgets_is_kept() {
        let sum = wide(1e15) + wide(1e-15);
        assert_eq!((sum - wide(1e15)).narrow(), 1e-15);
        let product = wide(1.0 + 2.0_f64.powi(-52)) * wide(1.0 - 2.0_f64.powi(-53));
        let rest = product - wide(1.0) - wide(2.0_f64.powi(-53));
        assert_eq!(rest.narrow(), -2.0_f64.powi(-105));
    }

    #[test]
    fn division_and_root_are_undone() {
        for number in 1_u32..2000 {
            let x = wide(f64::from(number)) / wide(7.0) + wide(1e-20);
            assert_near(x * wide(3.0) / wide(3.0), x);
            assert_near(x / wide(3e9) * wide(3e9), x);
            assert_near(x.sqrt() * x.sqrt(), x);
        }
        assert_eq!(wide(4.0).sqrt(), wide(2.0));
    }

    /// Digits of √2 and 1/3 beyond those of f64, from tables.
    #[test]
    fn known_digits() {
        let root = wide(2.0).sqrt();
        // √2 = 1.4142135623730950488016887242096980785…
        assert_eq!(root.high, std::f64::consts::SQRT_2);
        assert!((root.low - -9.667_293_313_452_913e-17).abs() < 1e-31);
        let third = wide(1.0) / wide(3.0);
        assert!((third.low - 1.850_371_707_708_594e-17).abs() < 1e-31);
    }

    #[test]
    fn what_is_not_finite_stays_so() {
        assert_eq!((wide(1.0) / wide(0.0)).narrow(), f64::INFINITY);
        assert!((wide(0.0) / wide(0.0)).narrow().is_nan());
        assert!(!(wide(f64::INFINITY) + wide(1.0)).narrow().is_finite());
        assert_eq!(wide(0.0).sqrt(), wide(0.0));
    }

    #[test]
    fn the_lower_half_decides_where_the_upper_is_the_same() {
        let more = wide(1.0) + wide(1e-20);
        assert!(more > wide(1.0) && wide(1.0) - wide(1e-20) < wide(1.0));
        assert!(wide(-1.0) - wide(1e-20) < wide(-1.0));
    }
}
