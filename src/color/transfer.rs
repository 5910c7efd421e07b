//! The sRGB transfer function, IEC 61966-2-1, to the letter.
//!
//! Powers are libm's own, which are the same on every machine.
//!
//! The standard's two pieces meet to seven digits only; its constants are kept, as everyone's are.

/// Where the linear piece ends, in light.
pub(crate) const LINEAR_END: f64 = 0.003_130_8;

/// The slope of the linear piece.
pub(crate) const SLOPE: f64 = 12.92;

/// The exponent of the other piece, from code values to light.
pub(crate) const CONTRAST: f64 = 2.4;

/// What code values of that piece lack.
pub(crate) const OFFSET: f64 = 0.055;

/// Where the linear piece ends, in code values.
pub(crate) const CODED_END: f64 = 0.040_45;

/// Linear light to code value, both 0 to 1.
pub(crate) fn srgb_encode(light: f64) -> f64 {
    if light <= LINEAR_END {
        SLOPE * light
    } else {
        (1.0 + OFFSET) * libm::pow(light, 1.0 / CONTRAST) - OFFSET
    }
}

/// Code value to linear light, both 0 to 1.
pub fn srgb_decode(code: f64) -> f64 {
    if code <= CODED_END {
        code / SLOPE
    } else {
        libm::pow((code + OFFSET) / (1.0 + OFFSET), CONTRAST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_values() {
        assert_eq!(srgb_encode(0.0), 0.0);
        assert!((srgb_encode(1.0) - 1.0).abs() < 1e-15);
        // W3C's sample values: middle gray, and the code 128 of every stylesheet.
        assert!((srgb_encode(0.18) - 0.461_356_129_5).abs() < 1e-10);
        assert!((srgb_decode(128.0 / 255.0) - 0.215_860_500_1).abs() < 1e-10);
        assert!((srgb_decode(0.5) - 0.214_041_140_5).abs() < 1e-10);
        // The linear piece.
        assert!((srgb_encode(0.002) - 0.025_84).abs() < 1e-15);
        assert!((srgb_decode(0.025_84) - 0.002).abs() < 1e-15);
    }

    #[test]
    fn codes_come_back() {
        for bits in [8, 16] {
            let largest = (1_u32 << bits) - 1;
            for code in 0..=largest {
                let light = srgb_decode(f64::from(code) / f64::from(largest));
                let back = srgb_encode(light) * f64::from(largest);
                assert_eq!(back.round(), f64::from(code));
            }
        }
    }

    #[test]
    fn pieces_meet() {
        // As far as the standard's constants do.
        let step = 1.055 * LINEAR_END.powf(1.0 / 2.4) - 0.055 - 12.92 * LINEAR_END;
        assert!(step.abs() < 3e-8, "{step}");
    }
}
