//! The tone scale of ACES 2.0 (Lib.Academy.Tonescale.ctl, v2.0): luminance in the scene to luminance on a
//! screen.

use fearless_simd::Simd;

use super::appearance::REFERENCE_LUMINANCE;
use crate::simd::{F64x16, power};

/// g: contrast.
const CONTRAST: f64 = 1.15;

/// t₁: flare, which makes the toe.
const FLARE: f64 = 0.04;

/// c: middle gray in the scene.
const GRAY: f64 = 0.18;

/// c_d: the luminance of middle gray on a screen of 100 cd/m².
const GRAY_LUMINANCE: f64 = 10.013;

/// w_g: how much of its luminance middle gray gains with each doubling of the peak.
const GRAY_GAIN: f64 = 0.14;

/// The radiance that reaches the peak, with peaks of 100 and of 10 000 cd/m².
const ROOF: [f64; 2] = [128.0, 896.0];

/// Radiance above the roof by more than this is as bright as at this.
const ABOVE_ROOF: f64 = 8.0;

/// Y' = f²/(f + t₁) with f = m₂ (Y/(Y + s₂))ᵍ; Y and Y' are of [`REFERENCE_LUMINANCE`].
pub(super) struct ToneScale {
    m2: f64,
    s2: f64,
    /// The radiance that reaches the peak.
    pub(super) roof: f64,
    /// The radiance that everything brighter is taken for.
    pub(super) brightest: f64,
    /// The luminance of middle gray on the screen, cd/m².
    pub(super) gray: f64,
}

impl ToneScale {
    /// For a screen with a peak of some cd/m².
    pub(super) fn new(peak: f64) -> Self {
        // Doublings of 100 cd/m².
        let stops = libm::log2(peak / REFERENCE_LUMINANCE);
        let roof = ROOF[0] + (ROOF[1] - ROOF[0]) * stops / libm::log2(100.0);
        // f at the peak, so that the peak is f²/(f + t₁).
        let without_flare =
            |luminance: f64| 0.5 * (luminance + (luminance * (luminance + 4.0 * FLARE)).sqrt());
        let top = without_flare(peak / REFERENCE_LUMINANCE);
        let gray = GRAY_LUMINANCE / REFERENCE_LUMINANCE * (1.0 + stops * GRAY_GAIN);
        // m₁ reaches the peak at the roof, m₂ does with the s₂ that puts middle gray where it belongs.
        let relative = roof / top;
        let highest = |offset: f64| top / libm::pow(relative / (relative + offset), CONTRAST);
        let gray_part = libm::pow(without_flare(gray) / highest(1.0), 1.0 / CONTRAST);
        let offset = GRAY * (1.0 - gray_part) / (top * gray_part);
        Self {
            m2: highest(offset),
            s2: offset * top,
            roof,
            brightest: ABOVE_ROOF * roof,
            gray: gray * REFERENCE_LUMINANCE,
        }
    }

    /// The luminance on the screen of a luminance in the scene.
    #[inline(always)]
    pub(super) fn apply<S: Simd>(&self, simd: S, luminance: F64x16<S>) -> F64x16<S> {
        let part = luminance / (luminance + self.s2);
        let f = power(simd, part, CONTRAST) * self.m2;
        f * f / (f + FLARE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_are_published() {
        // By the Academy's formulas for 100 cd/m².
        let tone = ToneScale::new(100.0);
        assert!((tone.s2 - 0.919_858_254_2).abs() < 1e-10);
        assert!((tone.m2 - 1.047_103_762_4).abs() < 1e-10);
        assert!((tone.brightest - 1024.0).abs() < 1e-10);
    }
}
