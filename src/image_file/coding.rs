//! What code values mean: the curve from them to light, and the primaries.

use glam::DVec3;

use crate::color::Primaries;
use crate::color::transfer::{hlg_decode, pq_decode, srgb_decode};

/// The luminance of diffuse white in cd/m² (ITU-R BT.2408-7, section 2.1): what becomes 1 of codings that have light
/// beyond it.
const REFERENCE_WHITE: f64 = 203.0;

/// The peak luminance in cd/m² of the display that HLG's system gamma of 1.2 belongs to (ITU-R BT.2100-2, table 5).
const HLG_PEAK: f64 = 1000.0;

/// That gamma.
const HLG_GAMMA: f64 = 1.2;

/// From code values, 0 to 1, to light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Curve {
    /// IEC 61966-2-1.
    Srgb,
    /// A power of the code value.
    Power(f64),
    /// The code value itself.
    Linear,
    /// ITU-R BT.2100-2, table 4, with 1 at 203 cd/m².
    Pq,
    /// ITU-R BT.2100-2, table 5, on a display of 1000 cd/m², with 1 at 203 cd/m².
    Hlg,
}

impl Curve {
    /// The light of a code value. Of HLG it is the scene's, which [`Coding::finish`] makes the display's.
    pub(super) fn light(self, code: f64) -> f64 {
        match self {
            Self::Srgb => srgb_decode(code),
            Self::Power(exponent) => libm::pow(code.max(0.0), exponent),
            Self::Linear => code,
            Self::Pq => pq_decode(code.clamp(0.0, 1.0)) / REFERENCE_WHITE,
            Self::Hlg => hlg_decode(code.clamp(0.0, 1.0)),
        }
    }
}

/// What R, G, B of a file mean.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Coding {
    pub(super) curve: Curve,
    pub(super) primaries: Primaries,
    /// Whether black and white are the codes 16 and 235 of 8 bits (ITU-T H.273, VideoFullRangeFlag 0).
    pub(super) is_narrow: bool,
}

impl Coding {
    /// What a file that says nothing means.
    pub(super) const SRGB: Self = Self {
        curve: Curve::Srgb,
        primaries: Primaries::REC709,
        is_narrow: false,
    };

    /// Light as it is.
    pub(super) const LINEAR: Self = Self {
        curve: Curve::Linear,
        ..Self::SRGB
    };

    /// The light of each of the codes 0 to `largest`, 255 or 65 535.
    pub(super) fn table(&self, largest: u16) -> Vec<f32> {
        let whole = f64::from(largest);
        // 16 and 219 of 8 bits, times 2⁸ in 16.
        let unit = if largest > 255 { 256.0 } else { 1.0 };
        let codes = 0..=largest;
        let value = |code: u16| {
            let code = f64::from(code);
            if self.is_narrow {
                (code - 16.0 * unit) / (219.0 * unit)
            } else {
                code / whole
            }
        };
        codes
            .map(|code| self.curve.light(value(code)) as f32)
            .collect()
    }

    /// What is still to be done to the light of a pixel: HLG's system gamma, L = L_W / 203 · Y^(γ − 1) · E.
    pub(super) fn finish(&self, rgb: [f32; 3]) -> [f32; 3] {
        match self.curve {
            Curve::Hlg => {
                let scene = DVec3::from_array(rgb.map(f64::from));
                let luminance = scene.dot(DVec3::from_array(self.primaries.luminance_weights()));
                let gain = libm::pow(luminance.max(0.0), HLG_GAMMA - 1.0);
                let display = scene * (gain * HLG_PEAK / REFERENCE_WHITE);
                display.to_array().map(|channel| channel as f32)
            }
            Curve::Srgb | Curve::Power(_) | Curve::Linear | Curve::Pq => rgb,
        }
    }
}

/// The primaries of a code point of ITU-T H.273, table 2; `None` for those that are not known here.
pub(super) const fn primaries_of(code: u8) -> Option<Primaries> {
    /// ITU-T H.273, table 2: the whites of 5 to 7 and 9 are D65, that of 11 is DCI's.
    const D65: [f64; 2] = Primaries::REC709.white;
    match code {
        1 => Some(Primaries::REC709),
        5 => Some(Primaries {
            red: [0.64, 0.33],
            green: [0.29, 0.60],
            blue: [0.15, 0.06],
            white: D65,
        }),
        6 | 7 => Some(Primaries {
            red: [0.630, 0.340],
            green: [0.310, 0.595],
            blue: [0.155, 0.070],
            white: D65,
        }),
        9 => Some(Primaries::REC2020),
        10 => Some(Primaries::XYZ),
        11 => Some(Primaries {
            white: [0.314, 0.351],
            ..Primaries::P3_D65
        }),
        12 => Some(Primaries::P3_D65),
        _ => None,
    }
}

/// The curve of a code point of ITU-T H.273, table 3, for pictures that are shown on a screen; `None` for those that
/// are not known here.
pub(super) const fn curve_of(code: u8) -> Option<Curve> {
    match code {
        // A camera's curves, of which screens make light by ITU-R BT.1886's power of 2.4.
        1 | 6 | 14 | 15 => Some(Curve::Power(2.4)),
        4 => Some(Curve::Power(2.2)),
        5 => Some(Curve::Power(2.8)),
        8 => Some(Curve::Linear),
        13 => Some(Curve::Srgb),
        16 => Some(Curve::Pq),
        18 => Some(Curve::Hlg),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// BT.2408-7, table 1: diffuse white is the code 58 % of PQ, and 75 % of HLG.
    #[test]
    fn reference_white_is_one() {
        let pq = Curve::Pq.light(0.580_688_9);
        assert!((pq - 1.0).abs() < 2e-6, "{pq}");
        let hlg = Coding {
            curve: Curve::Hlg,
            primaries: Primaries::REC2020,
            is_narrow: false,
        };
        let scene = hlg.curve.light(0.75) as f32;
        let [white, ..] = hlg.finish([scene; 3]);
        // 203.1 cd/m², which the report rounds.
        assert!((white - 1.0).abs() < 2e-3, "{white}");
        let [peak, ..] = hlg.finish([1.0; 3]);
        assert!((peak - 1000.0 / 203.0).abs() < 1e-5, "{peak}");
    }

    #[test]
    fn tables_begin_at_black_and_end_at_white() {
        for curve in [Curve::Srgb, Curve::Power(2.2), Curve::Linear] {
            for largest in [u16::from(u8::MAX), u16::MAX] {
                let coding = Coding {
                    curve,
                    ..Coding::SRGB
                };
                let table = coding.table(largest);
                assert_eq!(table.len(), usize::from(largest) + 1);
                assert_eq!((table[0], table[usize::from(largest)]), (0.0, 1.0));
                let narrow = Coding {
                    is_narrow: true,
                    ..coding
                };
                let (table, unit) = (narrow.table(largest), usize::from(largest > 255) * 255 + 1);
                assert_eq!((table[16 * unit], table[235 * unit]), (0.0, 1.0));
            }
        }
    }
}
