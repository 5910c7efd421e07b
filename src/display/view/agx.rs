//! Sobotka's AgX, the base image, for an sRGB screen: colors are drawn together, and each channel of the logarithm
//! goes through one sigmoid.
//!
//! Source: T. Sobotka's configuration for OpenColorIO, github.com/sobotka/AgX (2022, AgX-S2O3): negative
//! channels are cut, the matrix is that of the file, log₂ from −12.47393 to 4.026069, that is from 10 stops
//! below to 6.5 above a gray of 0.18, becomes t from 0 to 1, clipped. Its table of 4096 entries is the curve
//! below, of slope 2 at the pivot (t₀, ½), t₀ = 10/16.5, with the powers 3 in the toe and 3.25 in the shoulder:
//!
//! y = ½ + 2 (t − t₀) / (1 + |u (t − t₀)|ᵖ)^(1/p), u such that y is 0 at t = 0 and 1 at t = 1.
//!
//! What comes out is code values of the screen. They are decoded here by the curve by which an sRGB screen codes
//! again, so that its codes are those to 1e-9.
//!
//! Blender's AgX is another one: it works in primaries of its own (FilmLight E-Gamut) and reaches the screen by a
//! table of 57³ colors that no formula gives; its looks, "AgX - Punchy" and others, belong to that. They are not
//! here, since they cannot be had exactly.

use fearless_simd::Simd;

use crate::display::coded;
use crate::display::lanes::{Rgb, Transform, each, exp2, log2, product};
use crate::simd::F64x16;

/// sobotka/AgX, `config.ocio`, by rows.
const INSET: [[f64; 3]; 3] = [
    [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
    [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
    [0.0423756549057051, 0.0784336, 0.879142973793104],
];

/// log₂ of black, and the stops from there to white; the file rounds white to 4.026069.
const BLACK: f64 = -12.47393;
const STOPS: f64 = 4.026069 - BLACK;

/// t₀ and ½: where a gray of 0.18 goes.
const PIVOT: [f64; 2] = [10.0 / 16.5, 0.5];

/// At the pivot.
const SLOPE: f64 = 2.0;

const TOE_POWER: f64 = 3.0;
const SHOULDER_POWER: f64 = 3.25;

/// AgX's base image, with uᵖ of both sides of the curve.
pub(in crate::display) struct Agx {
    toe: f64,
    shoulder: f64,
}

/// uᵖ of a side that goes through half of the range over a `width` in t: ½ = 2 w / (1 + (u w)ᵖ)^(1/p).
fn bend(power: f64, width: f64) -> f64 {
    libm::pow(2.0 * SLOPE, power) - libm::pow(width, -power)
}

impl Agx {
    /// The gray that becomes the screen's white, 2^4.026069.
    pub(in crate::display) const WHITE: f64 = 16.291_8;

    pub(in crate::display) fn new() -> Self {
        let [pivot, _] = PIVOT;
        Self {
            toe: bend(TOE_POWER, pivot),
            shoulder: bend(SHOULDER_POWER, 1.0 - pivot),
        }
    }
}

impl Transform for Agx {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
        let zero = F64x16::splat(simd, 0.0);
        let one = F64x16::splat(simd, 1.0);
        let [pivot, middle] = PIVOT;
        let rgb = each(
            rgb,
            #[inline(always)]
            |x| x.max(zero),
        );
        let codes = each(
            product(&INSET, rgb),
            #[inline(always)]
            |x| {
                // Anything below 2^BLACK is black.
                let x = x.max(F64x16::splat(simd, 1e-30));
                let t = (log2(simd, x) - BLACK) / STOPS;
                let t = t.max(zero).min(one);
                let from_pivot = t - pivot;
                let distance = from_pivot.abs();
                let is_toe = from_pivot.lt(zero);
                // To the powers of 3 and 3 + ¼.
                let cube = distance * distance * distance;
                let below = cube * self.toe;
                let above = cube * distance.sqrt().sqrt() * self.shoulder;
                let root = is_toe.select(
                    F64x16::splat(simd, -1.0 / TOE_POWER),
                    F64x16::splat(simd, -1.0 / SHOULDER_POWER),
                );
                let bent = is_toe.select(below, above) + 1.0;
                let code = from_pivot * SLOPE * exp2(simd, log2(simd, bent) * root) + middle;
                // The ends are met but for the last bits.
                code.max(zero).min(one)
            },
        );
        coded::light(simd, codes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::transfer;
    use crate::display::lanes::of_one;

    fn codes(rgb: [f64; 3]) -> [f64; 3] {
        of_one(&Agx::new(), rgb).map(transfer::srgb_encode)
    }

    #[test]
    fn bends_are_those_of_other_programs() {
        let agx = Agx::new();
        assert!((agx.toe - 59.507_875).abs() < 1e-9);
        assert!((agx.shoulder - 69.862_789_135_455_39).abs() < 1e-9);
    }

    #[test]
    fn closed_form() {
        // The ends, and figures of the file's table by OpenColorIO 2.6.0, to six decimals.
        for black in [0.0, -1.0, 1e-5] {
            let [code, ..] = codes([black; 3]);
            assert!(code.abs() < 1e-12, "{code}");
        }
        let [white, ..] = codes([1e30; 3]);
        assert!((white - 1.0).abs() < 1e-9, "{white}");
        for (rgb, expected) in [
            ([1.0, 0.0, 0.0], [0.761_799, 0.256_303, 0.256_471]),
            ([0.8, 0.3, 0.05], [0.733_031, 0.590_039, 0.399_873]),
        ] {
            let codes = codes(rgb);
            for (code, expected) in codes.into_iter().zip(expected) {
                assert!((code - expected).abs() < 1e-6, "{rgb:?}: {codes:?}");
            }
        }
        // Grays are so but for the matrix, whose rows sum to 1 to 1.4e-4.
        let [middle, white] = [codes([0.18; 3]), codes([1.0; 3])];
        assert!(middle.into_iter().all(|code| (code - 0.5).abs() < 5e-5));
        assert!(
            white.into_iter().all(|code| (code - 0.7875).abs() < 5e-5),
            "{white:?}"
        );
    }
}
