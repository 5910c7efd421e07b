//! Light to sRGB codes, without a power for each sample.
//!
//! A code of 8 bits stands for a range of light, and there are only 256 of them: where each ends is found
//! once, by the very formula, and looked up afterwards. The codes are the formula's own, at a tenth of the time.

use super::Bits;
use crate::color::transfer;

/// Parts that light from 0 to 1 is looked up by: at most one code and a bit in each, since the curve
/// is steepest at 0, by 12.92.
const PARTS: usize = 4096;

/// The codes of light from 0 to 1.
pub(super) enum Codes {
    /// For 8 bits.
    Table {
        /// The code of the least light in each part.
        first: Vec<u8>,
        /// The least light that has a code higher than this.
        ends: Vec<f64>,
    },
    /// For 16 bits, where the table would take longer than most pictures.
    Formula,
}

impl Codes {
    pub(super) fn new(bits: Bits) -> Self {
        match bits {
            Bits::Eight => {
                let mut ends = Vec::with_capacity(255);
                for code in 1..=bits.largest() {
                    let before = ends.last().copied().unwrap_or(0.0);
                    ends.push(least_light(code, before));
                }
                let first =
                    (0..=PARTS).map(|part| formula(Bits::Eight, part as f64 / PARTS as f64) as u8);
                Self::Table {
                    first: first.collect(),
                    ends,
                }
            }
            Bits::Sixteen => Self::Formula,
        }
    }

    /// The nearest code; light outside 0 to 1 clips.
    pub(super) fn code(&self, light: f64) -> u16 {
        match self {
            Self::Table { first, ends } => {
                // `as` saturates, and makes 0 of what is no number.
                let part = ((light * PARTS as f64) as usize).min(PARTS);
                let mut code = first[part];
                while ends.get(usize::from(code)).is_some_and(|&end| light >= end) {
                    code += 1;
                }
                u16::from(code)
            }
            Self::Formula => formula(Bits::Sixteen, light),
        }
    }
}

fn formula(bits: Bits, light: f64) -> u16 {
    bits.quantize(transfer::srgb_encode(light))
}

/// The least light with this code of 8 bits, which is above that with the code before.
fn least_light(code: u16, before: f64) -> f64 {
    // Numbers from 0 up are in the order of their bits.
    let (mut below, mut reaches) = (before.to_bits(), 1.0_f64.to_bits());
    while below + 1 < reaches {
        let middle = below.midpoint(reaches);
        if formula(Bits::Eight, f64::from_bits(middle)) >= code {
            reaches = middle;
        } else {
            below = middle;
        }
    }
    f64::from_bits(reaches)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_those_of_the_formula() {
        let eight = Codes::new(Bits::Eight);
        let Codes::Table { ends, .. } = &eight else {
            panic!("8 bits are looked up");
        };
        assert!(ends.is_sorted());
        let around = ends
            .iter()
            .flat_map(|&end| [end.next_down(), end, end.next_up()]);
        let parts = (0..=PARTS).map(|part| part as f64 / PARTS as f64);
        let parts = parts.flat_map(|part| [part.next_down(), part, part.next_up()]);
        let many = (0..100_000).map(|i| (f64::from(i) / 1e5).powi(3));
        let odd = [
            -1.0,
            -0.0,
            5e-324,
            2.0,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NAN,
        ];
        let sixteen = Codes::new(Bits::Sixteen);
        for light in around.chain(parts).chain(many).chain(odd) {
            assert_eq!(eight.code(light), formula(Bits::Eight, light), "{light}");
            assert_eq!(
                sixteen.code(light),
                formula(Bits::Sixteen, light),
                "{light}"
            );
        }
    }
}
