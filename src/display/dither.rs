//! Dither: light between two codes of 8 bits as a fine pattern of both.
//!
//! A slow gradient, rounded to the nearest code, is a staircase whose steps the eye sees as rings. Here
//! a value v, counted in codes, becomes ⌊v + t⌋ with a threshold t of the pixel's place: of many
//! pixels with the same v, a share of v − ⌊v⌋ gets the upper code, and the mean is right. What is a code
//! exactly stays as it is for every t from 0 to 1, so that black, white and flat charts keep their
//! values. (Noise of a triangular distribution would hide how the noise itself varies with v, and
//! change these.)
//!
//! The thresholds are those of the R₂ sequence (Roberts 2018, "The unreasonable effectiveness of
//! quasirandom sequences"): t = frac(x/g + y/g²) with the plastic number g, g³ = g + 1. Neighbors
//! differ much, so that the pattern is fine, like blue noise, and nothing repeats. It is computed in
//! whole numbers: the same on every machine. All channels of a pixel share a threshold, so that a gray stays
//! gray.

/// Whether light between two codes is shown as a pattern of both; for 8 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Dither {
    /// As a fine pattern by the R₂ sequence.
    #[default]
    Blue,
    /// Not at all: each value becomes the nearest code.
    None,
}

impl Dither {
    /// Every choice, in the order of the documentation.
    pub const ALL: [Self; 2] = [Self::Blue, Self::None];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Blue => "blue",
            Self::None => "none",
        }
    }
}

/// 2³²/g and 2³²/g², rounded.
const STEPS: [u32; 2] = [3_242_174_889, 2_447_445_414];

/// Bits of a threshold. With more, the rounding of FLOAT would reach exact codes.
const BITS: u32 = 12;

/// The threshold of a pixel of the display window, above 0 and below 1: an odd multiple of 2⁻¹³.
pub(super) fn threshold(x: u32, y: u32) -> f64 {
    let place = x
        .wrapping_mul(STEPS[0])
        .wrapping_add(y.wrapping_mul(STEPS[1]));
    let step = place >> (u32::BITS - BITS);
    (f64::from(step) + 0.5) / f64::from(1_u32 << BITS)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_powers_of_the_plastic_number() {
        // By Newton's method on g³ = g + 1.
        let mut g = 1.3_f64;
        for _ in 0..20 {
            g -= (g * g * g - g - 1.0) / (3.0 * g * g - 1.0);
        }
        let rounded = |power: i32| (2_f64.powi(32) / g.powi(power)).round() as u32;
        assert_eq!(STEPS, [rounded(1), rounded(2)]);
    }

    /// In any square of 16 × 16 pixels, 256, the thresholds are spread as evenly as 256 can be but
    /// for a few: the mean of a flat value is right.
    #[test]
    fn thresholds_are_even_everywhere() {
        for (left, top) in [(0, 0), (1000, 77), (65_000, 40_000), (u32::MAX - 15, 5)] {
            for level in 1..8 {
                let value = f64::from(level) / 8.0;
                let places = (0..256).map(|i| (left + i % 16, top + i / 16));
                let above = places.filter(|&(x, y)| threshold(x, y) >= 1.0 - value);
                let expected = 256.0 * value;
                assert!(
                    (above.count() as f64 - expected).abs() <= 6.0,
                    "{left} {top} {value}"
                );
            }
        }
    }

    #[test]
    fn thresholds_stay_inside() {
        for (x, y) in [(0, 0), (1, 0), (0, 1), (u32::MAX, u32::MAX)] {
            let t = threshold(x, y);
            assert!(t >= 1.0 / 8192.0 && t <= 1.0 - 1.0 / 8192.0, "{t}");
        }
    }
}
