//! Screens: their primaries, and how light becomes code values.

use fearless_simd::Simd;

use super::lanes::{Rgb, Transform, each, log2};
use crate::color::Primaries;
use crate::color::transfer::{CONTRAST, LINEAR_END, OFFSET, SLOPE, hlg, pq};
use crate::simd::{F64x16, power};

/// The screens that pictures are made for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Screen {
    /// IEC 61966-2-1: the primaries of Rec.709, the sRGB curve.
    #[default]
    Srgb,
    /// Display P3: the primaries of P3, a white of D65, the sRGB curve.
    P3,
    /// ITU-R BT.2100: the primaries of Rec.2020, perceptual quantizer (SMPTE ST 2084).
    Rec2020Pq,
    /// ITU-R BT.2100: the primaries of Rec.2020, hybrid log-gamma, for a peak of 1000 cd/m².
    Rec2020Hlg,
    /// ITU-R BT.1886 with a black of 0: the primaries of Rec.709, a power of 2.4.
    Rec1886,
    /// The primaries of Rec.709; code values are light.
    Linear,
}

impl Screen {
    /// Every screen, in the order of the documentation.
    pub const ALL: [Self; 6] = [
        Self::Srgb,
        Self::P3,
        Self::Rec2020Pq,
        Self::Rec2020Hlg,
        Self::Rec1886,
        Self::Linear,
    ];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Srgb => "srgb",
            Self::P3 => "p3",
            Self::Rec2020Pq => "rec2020-pq",
            Self::Rec2020Hlg => "rec2020-hlg",
            Self::Rec1886 => "rec1886",
            Self::Linear => "linear",
        }
    }

    /// Its primaries and white.
    pub const fn primaries(self) -> Primaries {
        match self {
            Self::Srgb | Self::Rec1886 | Self::Linear => Primaries::REC709,
            Self::P3 => Primaries::P3_D65,
            Self::Rec2020Pq | Self::Rec2020Hlg => Primaries::REC2020,
        }
    }

    /// Whether it shows more light than paper reflects.
    pub const fn is_hdr(self) -> bool {
        match self {
            Self::Rec2020Pq | Self::Rec2020Hlg => true,
            Self::Srgb | Self::P3 | Self::Rec1886 | Self::Linear => false,
        }
    }

    /// The luminance of a light of 1 in cd/m², unless the user says another: HDR's reference white of BT.2408-7, section
    /// 2; 80 of sRGB's reference conditions (IEC 61966-2-1, table 1); 100 of BT.1886's (BT.2035).
    pub const fn white(self) -> f64 {
        match self {
            Self::Rec2020Pq | Self::Rec2020Hlg => 203.0,
            Self::Srgb | Self::P3 | Self::Linear => 80.0,
            Self::Rec1886 => 100.0,
        }
    }

    /// The largest luminance that has a code, in cd/m²; `None` where a light of 1 has the largest code.
    pub const fn peak(self) -> Option<f64> {
        match self {
            Self::Rec2020Pq => Some(pq::PEAK),
            Self::Rec2020Hlg => Some(hlg::PEAK),
            Self::Srgb | Self::P3 | Self::Rec1886 | Self::Linear => None,
        }
    }

    /// The code points of its primaries and its curve (ITU-T H.273, tables 2 and 3). BT.1886 has none of its own: it is
    /// how screens show what has that of BT.709.
    pub(super) const fn code_points(self) -> [u8; 2] {
        match self {
            Self::Srgb => [1, 13],
            Self::P3 => [12, 13],
            Self::Rec2020Pq => [9, 16],
            Self::Rec2020Hlg => [9, 18],
            Self::Rec1886 => [1, 1],
            Self::Linear => [1, 8],
        }
    }

    /// The exponent from light to code values in hundred thousandths, for programs that know no cICP; `None` where
    /// no power is near.
    pub(super) const fn gamma(self) -> Option<u32> {
        match self {
            // The PNG specification's own for the curve of sRGB.
            Self::Srgb | Self::P3 => Some(45_455),
            Self::Rec1886 => Some(41_667),
            Self::Linear => Some(100_000),
            Self::Rec2020Pq | Self::Rec2020Hlg => None,
        }
    }

    /// How light, of which 1 is so many cd/m², becomes code values.
    pub(super) const fn transfer(self, white: f64) -> Transfer {
        match self {
            Self::Srgb | Self::P3 => Transfer::Srgb,
            Self::Rec2020Pq => Transfer::Pq {
                part: white / pq::PEAK,
            },
            Self::Rec2020Hlg => Transfer::Hlg {
                part: white / hlg::PEAK,
            },
            Self::Rec1886 => Transfer::Power,
            Self::Linear => Transfer::Linear,
        }
    }
}

/// From linear light in the screen's primaries to code values, of which 1 is the largest. What is outside clips
/// later, as codes are whole numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Transfer {
    /// The curve of sRGB ([`crate::color::transfer`]); below 0 its line goes on, as in OpenColorIO.
    Srgb,
    /// Light to the power of 1/2.4 (BT.1886); below 0 it is mirrored.
    Power,
    /// The perceptual quantizer, [`pq`]; a light of 1 is this part of 10 000 cd/m².
    Pq { part: f64 },
    /// Hybrid log-gamma, [`hlg`]; a light of 1 is this part of 1000 cd/m².
    Hlg { part: f64 },
    /// As it is.
    Linear,
}

impl Transform for Transfer {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
        match *self {
            Self::Srgb => each(
                rgb,
                #[inline(always)]
                |light| srgb(simd, light),
            ),
            Self::Power => each(
                rgb,
                #[inline(always)]
                |light| mirrored(simd, light, power(simd, light.abs(), 1.0 / CONTRAST)),
            ),
            Self::Pq { part } => each(
                rgb,
                #[inline(always)]
                |light| perceptual(simd, light * part),
            ),
            Self::Hlg { part } => {
                let [r, g, b] = rgb;
                hybrid(simd, [r * part, g * part, b * part])
            }
            Self::Linear => rgb,
        }
    }
}

/// With the sign of the light.
#[inline(always)]
fn mirrored<S: Simd>(simd: S, light: F64x16<S>, code: F64x16<S>) -> F64x16<S> {
    light.lt(F64x16::splat(simd, 0.0)).select(-code, code)
}

#[inline(always)]
fn srgb<S: Simd>(simd: S, light: F64x16<S>) -> F64x16<S> {
    let is_linear = light.le(F64x16::splat(simd, LINEAR_END));
    let curved = power(simd, light, 1.0 / CONTRAST) * (1.0 + OFFSET) - OFFSET;
    is_linear.select(light * SLOPE, curved)
}

#[inline(always)]
fn perceptual<S: Simd>(simd: S, light: F64x16<S>) -> F64x16<S> {
    let zero = F64x16::splat(simd, 0.0);
    let one = F64x16::splat(simd, 1.0);
    let y = power(simd, light.max(zero).min(one), pq::M1);
    power(simd, (y * pq::C2 + pq::C1) / (y * pq::C3 + 1.0), pq::M2)
}

/// The light of the screen to that of the scene, by the inverse of the system's gamma, and that to code values.
#[inline(always)]
fn hybrid<S: Simd>(simd: S, [r, g, b]: Rgb<S>) -> Rgb<S> {
    let zero = F64x16::splat(simd, 0.0);
    let one = F64x16::splat(simd, 1.0);
    let [red, green, blue] = hlg::LUMINANCE;
    // Negative where a color is outside of the gamut. Near 0 the gain would have no limit.
    let luminance = (r * red + g * green + b * blue).abs();
    let luminance = luminance.max(F64x16::splat(simd, hlg::LEAST_LUMINANCE));
    let gain = power(simd, luminance, 1.0 / hlg::GAMMA - 1.0);
    each(
        [r, g, b],
        #[inline(always)]
        |light| {
            let scene = light.max(zero) * gain;
            let is_root = scene.le(F64x16::splat(simd, hlg::ROOT_END));
            let argument = is_root.select(one, scene * 12.0 - hlg::B);
            let logarithm = log2(simd, argument) * (hlg::A * std::f64::consts::LN_2) + hlg::C;
            is_root.select((scene * 3.0).sqrt(), logarithm)
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::transfer;
    use crate::display::lanes::{Matrix, of_one};

    /// Of the polynomials of logarithm and power.
    const EXACT: f64 = 1e-10;

    #[track_caller]
    fn assert_code(transfer: Transfer, light: f64, expected: f64, tolerance: f64) {
        let [code, ..] = of_one(&transfer, [light; 3]);
        assert!((code - expected).abs() <= tolerance, "{light}: {code}");
    }

    #[test]
    fn srgb_is_the_formula() {
        for i in 0..=1100 {
            let light = f64::from(i) / 1000.0;
            assert_code(Transfer::Srgb, light, transfer::srgb_encode(light), EXACT);
        }
        assert_code(Transfer::Srgb, -0.5, -0.5 * SLOPE, EXACT);
    }

    /// SMPTE ST 2084 as its formula gives it.
    #[test]
    fn perceptual_quantizer() {
        for (luminance, code) in [
            (0.0, 7.309_559_025_783_966e-7),
            (0.1, 0.062_336_9),
            (1.0, 0.149_945_7),
            (18.0, 0.347_966_7),
            (100.0, 0.508_078_4),
            (203.0, 0.580_688_9),
            (1000.0, 0.751_827_1),
            (4000.0, 0.902_572_4),
            (10_000.0, 1.0),
        ] {
            let transfer = Screen::Rec2020Pq.transfer(1.0);
            assert_code(transfer, luminance, code, 0.5e-7 + EXACT);
        }
        // Its reference white.
        let transfer = Screen::Rec2020Pq.transfer(Screen::Rec2020Pq.white());
        assert_code(transfer, 1.0, 0.580_688_9, 1e-7);
        assert_code(transfer, -1.0, 7.309_559_025_783_966e-7, EXACT);
    }

    /// BT.2100-2, table 5, and BT.2408-7: reference white is 75 %, within its decimals.
    #[test]
    fn hybrid_log_gamma() {
        let of_screen = |part: f64| Screen::Rec2020Hlg.transfer(1000.0 * part);
        assert_code(of_screen(1.0), 1.0, 1.0, 1e-7);
        assert_code(of_screen(1.0), 0.0, 0.0, EXACT);
        // Scene light of 1/12 is at half the range.
        assert_code(of_screen(1.0), (1.0_f64 / 12.0).powf(1.2), 0.5, 1e-7);
        assert_code(of_screen(1.0), 0.265_f64.powf(1.2), 0.750_03, 1e-5);
        let white = Screen::Rec2020Hlg.transfer(Screen::Rec2020Hlg.white());
        assert_code(white, 1.0, 0.75, 1e-3);
    }

    #[test]
    fn a_power_of_2_4() {
        assert_code(Transfer::Power, 0.18, 0.18_f64.powf(1.0 / 2.4), EXACT);
        assert_code(Transfer::Power, 0.0, 0.0, 0.0);
        assert_code(Transfer::Power, 1.0, 1.0, 0.0);
    }

    #[test]
    fn screens_have_names_of_their_own() {
        let mut names = Screen::ALL.map(Screen::name);
        names.sort_unstable();
        assert!(names.windows(2).all(|pair| pair[0] != pair[1]));
    }

    #[test]
    fn a_wider_screen_keeps_white() {
        let to_screen = Matrix::between(&Primaries::REC709, &Primaries::REC2020).unwrap();
        let [r, g, b] = of_one(&to_screen, [1.0; 3]);
        assert!((r - 1.0).abs().max((g - 1.0).abs()).max((b - 1.0).abs()) < 1e-14);
        // BT.2087-0, annex 2.
        let red = of_one(&to_screen, [1.0, 0.0, 0.0]);
        for (found, published) in red.into_iter().zip([0.6274, 0.0691, 0.0164]) {
            assert!((found - published).abs() <= 0.5e-4);
        }
        assert!(Matrix::between(&Primaries::REC709, &Primaries::REC709).is_none());
    }
}
