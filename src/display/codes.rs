//! Light to sRGB codes, without a power for each sample.
//!
//! A code of 8 bits stands for a range of light, and there are only 256 of them: where each ends is found
//! once, by the very formula, and looked up afterwards. The codes are the formula's own, at a tenth of the time.

use super::{Bits, Dither};
use crate::color::transfer;

/// Parts that light from 0 to 1 is looked up by: at most one code and a bit in each, since the curve
/// is steepest at 0, by 12.92.
const PARTS: usize = 4096;

/// The codes of light from 0 to 1.
pub(super) enum Codes {
    /// For 8 bits, the nearest code.
    Nearest(Table),
    /// For 8 bits, by the pixel's threshold; the table has the codes rounded down.
    Dithered(Table),
    /// For 16 bits, where the table would take longer than most pictures.
    Formula,
}

/// The largest code that is not above light coded, plus an offset.
pub(super) struct Table {
    /// The code of the least light in each part.
    first: Vec<u8>,
    /// The least light that has a code higher than this.
    ends: Vec<f64>,
}

/// How far, in codes, a straight line between two codes is from the curve at most: it bends most above
/// its linear piece, at code 11, by 1.4 / 8 / (11 + 14).
const BEND: f64 = 0.01;

impl Codes {
    pub(super) fn new(bits: Bits, dither: Dither) -> Self {
        match (bits, dither) {
            (Bits::Eight, Dither::None) => Self::Nearest(Table::new(0.5)),
            (Bits::Eight, Dither::Blue) => Self::Dithered(Table::new(0.0)),
            (Bits::Sixteen, _) => Self::Formula,
        }
    }

    /// The code of light at a pixel whose threshold is this; light outside 0 to 1 clips.
    pub(super) fn code(&self, light: f64, threshold: f64) -> u16 {
        match self {
            Self::Nearest(table) => table.code(light),
            Self::Dithered(table) => {
                let below = table.code(light);
                let Some(&end) = table.ends.get(usize::from(below)) else {
                    return below;
                };
                let start = below.checked_sub(1);
                let start = start.map_or(0.0, |before| table.ends[usize::from(before)]);
                let part = (light - start) / (end - start) + threshold - 1.0;
                // Close to the border the straight line may be wrong, and the formula is asked.
                if part.abs() > BEND {
                    below + u16::from(part > 0.0)
                } else {
                    formula(light, threshold)
                }
            }
            Self::Formula => Bits::Sixteen.quantize(transfer::srgb_encode(light)),
        }
    }
}

impl Table {
    fn new(offset: f64) -> Self {
        let mut ends = Vec::with_capacity(255);
        for code in 1..=Bits::Eight.largest() {
            let before = ends.last().copied().unwrap_or(0.0);
            ends.push(least_light(code, before, offset));
        }
        let first = (0..=PARTS).map(|part| formula(part as f64 / PARTS as f64, offset) as u8);
        Self {
            first: first.collect(),
            ends,
        }
    }

    fn code(&self, light: f64) -> u16 {
        // `as` saturates, and makes 0 of what is no number.
        let part = ((light * PARTS as f64) as usize).min(PARTS);
        let mut code = self.first[part];
        while self
            .ends
            .get(usize::from(code))
            .is_some_and(|&end| light >= end)
        {
            code += 1;
        }
        u16::from(code)
    }
}

/// ⌊255 · coded light + offset⌋, which for an offset of 0.5 is the nearest code.
fn formula(light: f64, offset: f64) -> u16 {
    let largest = Bits::Eight.largest();
    let code = transfer::srgb_encode(light) * f64::from(largest) + offset;
    // `as` saturates, and rounds down.
    (code as u16).min(largest)
}

/// The least light with this code of 8 bits, which is above that with the code before.
fn least_light(code: u16, before: f64, offset: f64) -> f64 {
    // Numbers from 0 up are in the order of their bits.
    let (mut below, mut reaches) = (before.to_bits(), 2.0_f64.to_bits());
    while below + 1 < reaches {
        let middle = below.midpoint(reaches);
        if formula(f64::from_bits(middle), offset) >= code {
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

    /// Light around every border of the table, in each of its parts, and beyond its ends.
    fn lights(ends: &[f64]) -> Vec<f64> {
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
        around.chain(parts).chain(many).chain(odd).collect()
    }

    #[test]
    fn codes_are_those_of_the_formula() {
        let eight = Codes::new(Bits::Eight, Dither::None);
        let Codes::Nearest(table) = &eight else {
            panic!("8 bits are looked up");
        };
        assert!(table.ends.is_sorted());
        let sixteen = Codes::new(Bits::Sixteen, Dither::Blue);
        for light in lights(&table.ends) {
            for (codes, bits) in [(&eight, Bits::Eight), (&sixteen, Bits::Sixteen)] {
                let expected = bits.quantize(transfer::srgb_encode(light));
                assert_eq!(codes.code(light, 0.9), expected, "{light}");
            }
        }
    }

    #[test]
    fn dithered_codes_are_those_of_the_formula() {
        let codes = Codes::new(Bits::Eight, Dither::Blue);
        let Codes::Dithered(table) = &codes else {
            panic!("8 bits are looked up");
        };
        assert!(table.ends.is_sorted());
        for light in lights(&table.ends) {
            for threshold in [1.0 / 8192.0, 0.25, 0.5, 8191.0 / 8192.0] {
                let code = codes.code(light, threshold);
                assert_eq!(code, formula(light, threshold), "{light} {threshold}");
            }
        }
    }

    /// Also where light has been through FLOAT.
    #[test]
    fn exact_codes_stay() {
        let codes = Codes::new(Bits::Eight, Dither::Blue);
        for code in 0..=255_u8 {
            let light = f64::from(transfer::srgb_decode(f64::from(code) / 255.0) as f32);
            for threshold in [1.0 / 8192.0, 0.5, 8191.0 / 8192.0] {
                assert_eq!(codes.code(light, threshold), u16::from(code));
            }
        }
    }
}
