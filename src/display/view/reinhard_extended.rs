//! Reinhard et al. 2002, eq. 4: x (1 + x/w²) / (1 + x), which makes x = w the screen's white.
//!
//! Per channel, as `reinhard` is, and for the reason that is given there. As w grows, it becomes that.

use fearless_simd::Simd;

use crate::display::lanes::{Rgb, Transform, each};
use crate::simd::F64x16;

/// x (1 + x/w²) / (1 + x) for each channel, 0 below 0, above 1 where x is above w.
pub(in crate::display) struct ReinhardExtended {
    /// w: the exposed radiance that becomes the screen's white; above 0.
    pub(in crate::display) white: f64,
}

impl Default for ReinhardExtended {
    /// A white of 4, two stops above the screen's: a middle of the range that is used, from 1, which leaves all as it
    /// is, to ∞.
    fn default() -> Self {
        Self { white: 4.0 }
    }
}

impl Transform for ReinhardExtended {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
        let zero = F64x16::splat(simd, 0.0);
        let per_square = 1.0 / (self.white * self.white);
        each(
            rgb,
            #[inline(always)]
            |x| {
                let x = x.max(zero);
                x * (x * per_square + 1.0) / (x + 1.0)
            },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::lanes::of_one;

    #[test]
    fn closed_form() {
        let [a, b, c] = of_one(&ReinhardExtended::default(), [-1.0, 1.0, 4.0]);
        assert_eq!(a, 0.0);
        assert!((b - (1.0 + 1.0 / 16.0) / 2.0).abs() < f64::EPSILON);
        assert!((c - 1.0).abs() < f64::EPSILON);
    }

    #[test]
    fn a_white_of_one_changes_nothing() {
        let rgb = [0.18, 0.5, 3.0];
        let result = of_one(&ReinhardExtended { white: 1.0 }, rgb);
        for (x, y) in rgb.into_iter().zip(result) {
            assert!((x - y).abs() <= f64::EPSILON * x);
        }
    }
}
