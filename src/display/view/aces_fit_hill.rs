//! Hill's fit of ACES 1.0: a matrix, (v (v + a) − b) / (v (c v + d) + e), and a matrix.
//!
//! Source: S. Hill's fit as published with MJP and D. Neubelt's Baking Lab, `ACES.hlsl`. The first matrix is
//! from linear Rec.709 to AP1 with the RRT's desaturation, the second the ODT's desaturation and the way
//! back, so that strong colors bleach as they do in ACES. Some programs expose it by 1.8 or 1/0.6
//! beforehand; here `--exposure` does that. Below 0 the fit rises again: what the first matrix leaves
//! there is taken for 0, as ACES does.

use fearless_simd::Simd;

use crate::display::lanes::{Rgb, Transform, each, product};
use crate::simd::F64x16;

/// Baking Lab, `ACES.hlsl`, by rows.
const TO_FIT: [[f64; 3]; 3] = [
    [0.59719, 0.35458, 0.04823],
    [0.07600, 0.90834, 0.01566],
    [0.02840, 0.13383, 0.83777],
];
const TO_SCREEN: [[f64; 3]; 3] = [
    [1.60475, -0.53108, -0.07367],
    [-0.10208, 1.10813, -0.00605],
    [-0.00327, -0.07276, 1.07602],
];

/// Hill's fit, at least 0. Grays above 25.7 exceed 1, by up to 2 %.
pub(in crate::display) struct AcesFitHill;

impl AcesFitHill {
    /// The gray that becomes the screen's white: where (1 − c) v² + (a − d) v − (b + e) is 0.
    pub(in crate::display) const WHITE: f64 = 25.6684;
}

impl Transform for AcesFitHill {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
        let zero = F64x16::splat(simd, 0.0);
        let curved = each(
            product(&TO_FIT, rgb),
            #[inline(always)]
            |v| {
                let v = v.max(zero);
                (v * (v + 0.024_578_6) - 0.000_090_537)
                    / (v * (v * 0.983_729 + 0.432_951_0) + 0.238_081)
            },
        );
        each(
            product(&TO_SCREEN, curved),
            #[inline(always)]
            |light| light.max(zero),
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
        for (gray, expected) in [(0.18, 0.105_591), (1.0, 0.619_115), (4.0, 0.909_014)] {
            let [r, g, b] = of_one(&AcesFitHill, [gray; 3]);
            // The matrices' rows sum to 1 to 1e-5.
            assert!((r - expected).abs() < 5e-7, "{gray}: {r}");
            assert!((g - r).abs() < 1e-5 && (b - r).abs() < 1e-5);
        }
        assert_eq!(of_one(&AcesFitHill, [-1.0, 0.0, 0.0]), [0.0; 3]);
    }

    #[test]
    fn the_white_is_the_root() {
        let v = AcesFitHill::WHITE;
        let rest = (1.0 - 0.983_729) * v * v + (0.024_578_6 - 0.432_951_0) * v
            - (0.000_090_537 + 0.238_081);
        assert!(rest.abs() < 1e-4, "{rest}");
    }
}
