//! Transfer functions: sRGB's (IEC 61966-2-1) to the letter, and PQ's and HLG's of ITU-R BT.2100-2.
//!
//! Powers are libm's own, which are the same on every machine.
//!
//! The two pieces of sRGB's standard meet to seven digits only; its constants are kept, as everyone's are.

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

/// Linear light to code value, both 0 to 1: what lanes are held against.
#[cfg(test)]
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

/// The perceptual quantizer (SMPTE ST 2084; BT.2100-2, table 4): light y, as a part of [`pq::PEAK`], has the code
/// ((c₁ + c₂ yᵐ) / (1 + c₃ yᵐ))ⁿ with m = [`pq::M1`], n = [`pq::M2`].
pub(crate) mod pq {
    /// In cd/m².
    pub(crate) const PEAK: f64 = 10_000.0;
    pub(crate) const M1: f64 = 2610.0 / 16_384.0;
    pub(crate) const M2: f64 = 2523.0 / 4096.0 * 128.0;
    pub(crate) const C1: f64 = 3424.0 / 4096.0;
    pub(crate) const C2: f64 = 2413.0 / 4096.0 * 32.0;
    pub(crate) const C3: f64 = 2392.0 / 4096.0 * 32.0;
}

/// Hybrid log-gamma (BT.2100-2, table 5): scene light E from 0 to 1 has the code √(3E) up to [`hlg::ROOT_END`], and
/// a ln(12E − b) + c above. A screen shows E Y^(γ − 1) of its peak, Y the luminance of E.
pub(crate) mod hlg {
    /// In cd/m², that of the nominal screen, for which γ is 1.2.
    pub(crate) const PEAK: f64 = 1000.0;
    pub(crate) const GAMMA: f64 = 1.2;
    pub(crate) const ROOT_END: f64 = 1.0 / 12.0;
    pub(crate) const A: f64 = 0.178_832_77;
    /// 1 − 4a
    pub(crate) const B: f64 = 1.0 - 4.0 * A;
    /// ½ − a ln 4a
    pub(crate) const C: f64 = 0.559_910_729_529_562;
    /// Colors of less luminance, as a part of the peak, get the gain of this: OpenColorIO's 1e-4, in units of 3^γ-ths of the
    /// peak, 3^−1.2 · 1e-4.
    pub(crate) const LEAST_LUMINANCE: f64 = 2.675_805_205_867_435_8e-5;
    /// Of R, G and B in Y, as table 5 rounds them.
    pub(crate) const LUMINANCE: [f64; 3] = [0.2627, 0.6780, 0.0593];
}

/// PQ's code value, 0 to 1, to luminance in cd/m², 0 to 10 000 (ITU-R BT.2100-2, table 4, the EOTF).
pub(crate) fn pq_decode(code: f64) -> f64 {
    let power = libm::pow(code, 1.0 / pq::M2);
    pq::PEAK
        * libm::pow(
            (power - pq::C1).max(0.0) / (pq::C2 - pq::C3 * power),
            1.0 / pq::M1,
        )
}

/// HLG's code value to the light of the scene, both 0 to 1 (ITU-R BT.2100-2, table 5, the inverse OETF).
pub(crate) fn hlg_decode(code: f64) -> f64 {
    if code <= 0.5 {
        code * code / 3.0
    } else {
        (libm::exp((code - hlg::C) / hlg::A) + hlg::B) / 12.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Codes of luminances by the inverse of the EOTF, as colour-science 0.4.7 prints them.
    #[test]
    fn pq_is_the_published_one() {
        for (luminance, code) in [
            (0.1, 0.062_336_9),
            (1.0, 0.149_945_7),
            (18.0, 0.347_966_7),
            (100.0, 0.508_078_4),
            (203.0, 0.580_688_9),
            (1000.0, 0.751_827_1),
            (4000.0, 0.902_572_4),
        ] {
            let found = pq_decode(code);
            // Half a unit of the code's last digit is 1.3e-6 of the darkest.
            assert!(
                (found / luminance - 1.0).abs() < 2.6e-6,
                "{luminance}: {found}"
            );
        }
        assert_eq!((pq_decode(0.0), pq_decode(1.0)), (0.0, 10_000.0));
    }

    #[test]
    fn hlg_is_the_published_one() {
        // BT.2100-2: the pieces meet at E = 1/12, and 1 is 1.
        assert!((hlg_decode(0.5) - 1.0 / 12.0).abs() < 1e-15);
        assert!((hlg_decode(0.5_f64.next_up()) - 1.0 / 12.0).abs() < 1e-8);
        assert!((hlg_decode(1.0) - 1.0).abs() < 1e-7);
        assert!((hlg_decode(0.75) - 0.265).abs() < 1e-4);
    }

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

    #[test]
    fn the_pieces_of_hybrid_log_gamma_meet() {
        let least = 1e-4 / libm::pow(3.0, hlg::GAMMA);
        assert!((least / hlg::LEAST_LUMINANCE - 1.0).abs() < 1e-15);
        let c = 0.5 - hlg::A * (4.0 * hlg::A).ln();
        assert!((c - hlg::C).abs() < 1e-15);
        let above = hlg::A * (12.0 * hlg::ROOT_END - hlg::B).ln() + hlg::C;
        assert!((above - 0.5).abs() < 1e-15);
    }

    /// palette's powers and constants, whose decoding differs by the last bit, which rendered colors would show.
    #[test]
    fn palette_agrees() {
        use palette::encoding::{FromLinear, IntoLinear, Srgb};
        for i in 0..=10_000 {
            let value = f64::from(i) / 1e4;
            let coded: f64 = Srgb::from_linear(value);
            let light: f64 = Srgb::into_linear(value);
            assert!((coded - srgb_encode(value)).abs() < 1e-15, "{value}");
            assert!((light - srgb_decode(value)).abs() < 7e-16, "{value}");
        }
    }
}
