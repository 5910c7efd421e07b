//! Colors as written → linear Rec.709.

use crate::scene::{ColorSpace, Value};

/// The value as linear Rec.709. Only that space is legal in a scene today: numbers that were
/// written for another one are taken as they stand.
pub(super) fn linear_rgb(value: &Value) -> [f64; 3] {
    match *value {
        Value::Uniform(value) => [value; 3],
        Value::Rgb {
            rgb,
            space: ColorSpace::Rec709 | ColorSpace::P3D65 | ColorSpace::Rec2020 | ColorSpace::AcesCg,
        } => rgb,
        Value::Srgb(code) => code.map(srgb_decoded),
        Value::Illuminant(_)
        | Value::Daylight(_)
        | Value::Blackbody(_)
        | Value::Curve(_)
        | Value::Lines(_)
        | Value::Sized { .. } => [0.0; 3],
    }
}

/// The sRGB transfer function of IEC 61966-2-1, from an 8-bit code to linear light:
/// c / 12.92 up to 0.04045, ((c + 0.055) / 1.055)^2.4 above.
fn srgb_decoded(code: u8) -> f64 {
    let c = f64::from(code) / 255.0;
    if c <= 0.04045 {
        c / 12.92
    } else {
        ((c + 0.055) / 1.055).powf(2.4)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `powf` is good to a few units in the last place.
    const ROUNDING: f64 = 1e-15;

    #[test]
    fn srgb_codes() {
        // From decimal arithmetic with 40 digits.
        for (code, linear) in [
            (0, 0.0),
            (1, 1.0 / 255.0 / 12.92),
            (10, 10.0 / 255.0 / 12.92),
            (11, 0.003_346_535_763_899_158_5),
            (119, 0.184_474_994_500_440_9),
            (128, 0.215_860_500_113_899_2),
            (255, 1.0),
        ] {
            assert!((srgb_decoded(code) - linear).abs() < ROUNDING, "{code}");
        }
    }

    #[test]
    fn values_in_every_notation() {
        assert_eq!(linear_rgb(&Value::Uniform(0.5)), [0.5; 3]);
        assert_eq!(
            linear_rgb(&Value::Rgb {
                rgb: [0.1, 0.2, 0.3],
                space: ColorSpace::Rec709
            }),
            [0.1, 0.2, 0.3]
        );
        assert_eq!(linear_rgb(&Value::Srgb([255, 0, 255])), [1.0, 0.0, 1.0]);
    }
}
