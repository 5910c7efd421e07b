//! Narkowicz's fit of ACES 1.0: x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14), per channel.
//!
//! Source: K. Narkowicz, "ACES Filmic Tone Mapping Curve" (2016), to whom it is within 0.0138 of the curve
//! of grays, exposed such that 1 becomes about 0.8. Colors are not ACES's, since their channels are curved
//! apart: `aces-fit-hill` is nearer, and `aces1` is ACES itself.

use fearless_simd::Simd;

use crate::display::lanes::{Rgb, Transform, each};
use crate::simd::F64x16;

/// Narkowicz's fit for each channel, 0 below 0, above 1 where x is above 7.2.
pub(in crate::display) struct AcesFit;

impl AcesFit {
    /// The radiance that becomes the screen's white: where 0.08 x² − 0.56 x − 0.14 is 0.
    pub(in crate::display) const WHITE: f64 = 7.241_657;
}

impl Transform for AcesFit {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
        let zero = F64x16::splat(simd, 0.0);
        each(
            rgb,
            #[inline(always)]
            |x| {
                let x = x.max(zero);
                x * (x * 2.51 + 0.03) / (x * (x * 2.43 + 0.59) + 0.14)
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
        // By the formula, to six decimals.
        let [a, b, c] = of_one(&AcesFit, [0.18, 1.0, 4.0]);
        assert!((a - 0.266_899).abs() < 5e-7, "{a}");
        assert!((b - 0.803_797).abs() < 5e-7, "{b}");
        assert!((c - 0.973_417).abs() < 5e-7, "{c}");
        let [white, negative, _] = of_one(&AcesFit, [AcesFit::WHITE, -1.0, 0.0]);
        assert!((white - 1.0).abs() < 1e-8, "{white}");
        assert_eq!(negative, 0.0);
    }
}
