//! Hable's curve for Uncharted 2: h(2x) / h(11.2), per channel.
//!
//! h(x) = (x (A x + C B) + D E) / (x (A x + B) + D F) − E/F, of which A is the strength of the shoulder, B and
//! C strength and angle of the straight part, and D, E, F strength, numerator and denominator of the toe.
//! Source: J. Hable, "Filmic Tonemapping Operators" (2010), with the constants given there: the exposure
//! bias 2, by which x is multiplied, and the white W = 11.2, so that x = 5.6 becomes the screen's white.

use fearless_simd::Simd;

use crate::display::lanes::{Rgb, Transform, each};
use crate::simd::F64x16;

/// Hable 2010: A to F.
const SHOULDER: f64 = 0.15;
const STRAIGHT: f64 = 0.50;
const ANGLE: f64 = 0.10;
const TOE: f64 = 0.20;
const NUMERATOR: f64 = 0.02;
const DENOMINATOR: f64 = 0.30;

/// Hable 2010: what x is multiplied by, and W.
const BIAS: f64 = 2.0;
const WHITE: f64 = 11.2;

/// h(2x) / h(11.2) for each channel, 0 below 0, above 1 where x is above 5.6.
pub(in crate::display) struct Hable;

impl Hable {
    /// The radiance that becomes the screen's white.
    pub(in crate::display) const WHITE: f64 = WHITE / BIAS;
}

/// h of the white.
const FULL: f64 = (WHITE * (SHOULDER * WHITE + ANGLE * STRAIGHT) + TOE * NUMERATOR)
    / (WHITE * (SHOULDER * WHITE + STRAIGHT) + TOE * DENOMINATOR)
    - NUMERATOR / DENOMINATOR;

impl Transform for Hable {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
        let zero = F64x16::splat(simd, 0.0);
        each(
            rgb,
            #[inline(always)]
            |x| {
                let x = x.max(zero) * BIAS;
                let shoulder = x * SHOULDER;
                let above = x * (shoulder + ANGLE * STRAIGHT) + TOE * NUMERATOR;
                let below = x * (shoulder + STRAIGHT) + TOE * DENOMINATOR;
                // −E/F is −h(0): black is 0 but for the last bit.
                ((above / below - NUMERATOR / DENOMINATOR) / FULL).max(zero)
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
        let [a, b, c] = of_one(&Hable, [0.18, 1.0, 4.0]);
        assert!((a - 0.128_338).abs() < 5e-7, "{a}");
        assert!((b - 0.492_919).abs() < 5e-7, "{b}");
        assert!((c - 0.918_030).abs() < 5e-7, "{c}");
        let [black, white, negative] = of_one(&Hable, [0.0, Hable::WHITE, -1.0]);
        assert!(black.abs() < 1e-15, "{black}");
        assert!((white - 1.0).abs() < 1e-15, "{white}");
        assert_eq!(negative, black);
    }
}
