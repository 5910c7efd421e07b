//! The color appearance model of ACES 2.0: CAM16 in the simplified form of Hellwig and Fairchild (2022), with
//! one viewing condition and the adaptation to the white complete.
//!
//! Colors are A, a, b: A is the achromatic response (1 for the white at 100 cd/m²), a and b are the red-green
//! and the yellow-blue one, scaled so that M = √(a² + b²) is the colorfulness. The hue h is the angle of
//! (a, b), and the lightness is J = 100 Aᶜᶻ.

use fearless_simd::Simd;
use glam::{DMat3, DVec3};

use crate::color::Primaries;
use crate::display::lanes::{Rgb, each, product, rows};
use crate::simd::{F64x16, power};

/// The luminance of R = G = B = 1, cd/m² (`referenceLuminance` of the CTL).
pub(super) const REFERENCE_LUMINANCE: f64 = 100.0;

/// The lightness of the white at [`REFERENCE_LUMINANCE`].
pub(super) const LIGHTNESS: f64 = 100.0;

/// L_A: the luminance that the eye is adapted to, cd/m² (CTL).
const ADAPTING_LUMINANCE: f64 = 100.0;

/// Y_b: the luminance of the background, of 100 (CTL).
const BACKGROUND: f64 = 20.0;

/// c: the impact of a dim surround (CTL, `viewingConditionsToSurround`; as in CIECAM02 and CAM16).
const SURROUND_IMPACT: f64 = 0.59;

/// N_c: the chromatic induction of a dim surround (CTL, `viewingConditionsToSurround`; as in CAM16).
const CHROMATIC_INDUCTION: f64 = 0.9;

/// Colorfulness for each unit of a and b (Hellwig and Fairchild 2022, M = 43 N_c √(a² + b²)).
const COLORFULNESS: f64 = 43.0;

/// The responses' exponent, offset and scale: R' = 400 xⁿ / (xⁿ + 27.13), of CIECAM02 (CIE 159:2004)
/// without its noise of 0.1.
const EXPONENT: f64 = 0.42;
const OFFSET: f64 = 27.13;
const SCALE: f64 = 400.0;

/// What a response, of 1, is kept below on the way back: the curve has its pole at 1 (OpenColorIO, `Ra_lim`).
const HIGHEST_RESPONSE: f64 = 0.99;

/// The sharpened cone responses of CAM16 as the primaries that have them for R, G and B (CTL, `CAM16_PRI`).
const CAM16: Primaries = Primaries {
    red: [0.8336, 0.1735],
    green: [2.3854, -1.4659],
    blue: [0.087, -0.125],
    white: [0.333, 0.333],
};

/// The weights of the three responses in A, a and b (CIECAM02, CIE 159:2004).
const ACHROMATIC: DVec3 = DVec3::new(2.0, 1.0, 1.0 / 20.0);
const RED_GREEN: DVec3 = DVec3::new(1.0, -12.0 / 11.0, 1.0 / 11.0);
const YELLOW_BLUE: DVec3 = DVec3::new(1.0 / 9.0, 1.0 / 9.0, -2.0 / 9.0);

/// The model for linear R, G, B of some primaries, whose white the eye is adapted to.
pub(super) struct Appearance {
    to_cones: [[f64; 3]; 3],
    from_cones: [[f64; 3]; 3],
    to_opponent: [[f64; 3]; 3],
    from_opponent: [[f64; 3]; 3],
}

impl Appearance {
    pub(super) fn new(primaries: &Primaries) -> Self {
        // A complete adaptation scales the responses to the white to one number, here F_L.
        let cones = CAM16.from_xyz() * primaries.to_xyz();
        let white = cones * DVec3::ONE;
        let cones = DMat3::from_diagonal(adaptation() / white) * cones;
        let colorfulness = SCALE * COLORFULNESS * CHROMATIC_INDUCTION;
        let opponent = DMat3::from_cols(
            ACHROMATIC / (ACHROMATIC.element_sum() * white_response()),
            RED_GREEN * colorfulness,
            YELLOW_BLUE * colorfulness,
        )
        .transpose();
        Self {
            to_cones: rows(cones),
            from_cones: rows(cones.inverse()),
            to_opponent: rows(opponent),
            from_opponent: rows(opponent.inverse()),
        }
    }

    /// A, a and b.
    #[inline(always)]
    pub(super) fn opponent<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
        let responses = each(
            product(&self.to_cones, rgb),
            #[inline(always)]
            |x| {
                let power = power(simd, x.abs(), EXPONENT);
                with_sign_of(simd, power / (power + OFFSET), x)
            },
        );
        product(&self.to_opponent, responses)
    }

    /// R, G, B from A, a and b.
    #[inline(always)]
    pub(super) fn rgb<S: Simd>(&self, simd: S, opponent: Rgb<S>) -> Rgb<S> {
        let cones = each(
            product(&self.from_opponent, opponent),
            #[inline(always)]
            |response| with_sign_of(simd, adapted(simd, response.abs()), response),
        );
        product(&self.from_cones, cones)
    }
}

/// cz, with z = 1.48 + √(Y_b/100): J = 100 Aᶜᶻ.
pub(super) fn lightness_exponent() -> f64 {
    SURROUND_IMPACT * (1.48 + (BACKGROUND / 100.0).sqrt())
}

/// The achromatic response to a white of some luminance, cd/m².
pub(super) fn achromatic(luminance: f64) -> f64 {
    response(luminance / REFERENCE_LUMINANCE * adaptation()) / white_response()
}

/// The lightness of a white of some luminance, cd/m².
pub(super) fn lightness(luminance: f64) -> f64 {
    LIGHTNESS * libm::pow(achromatic(luminance), lightness_exponent())
}

/// F_L = 0.2 k⁴ · 5 L_A + 0.1 (1 − k⁴)² (5 L_A)^⅓ with k = 1/(5 L_A + 1) (CIECAM02,
/// CIE 159:2004).
fn adaptation() -> f64 {
    let luminance = 5.0 * ADAPTING_LUMINANCE;
    let k4 = (1.0 / (luminance + 1.0)).powi(4);
    0.2 * k4 * luminance + 0.1 * (1.0 - k4).powi(2) * libm::cbrt(luminance)
}

/// The response of each cone, of 1, to the white at [`REFERENCE_LUMINANCE`].
fn white_response() -> f64 {
    response(adaptation())
}

fn response(adapted: f64) -> f64 {
    let power = libm::pow(adapted, EXPONENT);
    power / (power + OFFSET)
}

/// What has a response, of 1: (27.13 r / (1 − r))^(1/0.42), of a response from 0.
#[inline(always)]
fn adapted<S: Simd>(simd: S, response: F64x16<S>) -> F64x16<S> {
    let response = response.min(F64x16::splat(simd, HIGHEST_RESPONSE));
    let rest = F64x16::splat(simd, 1.0) - response;
    power(simd, response * OFFSET / rest, 1.0 / EXPONENT)
}

#[inline(always)]
fn with_sign_of<S: Simd>(simd: S, magnitude: F64x16<S>, of: F64x16<S>) -> F64x16<S> {
    of.lt(F64x16::splat(simd, 0.0))
        .select(-magnitude, magnitude)
}

/// The achromatic response that a change of luminance makes of another.
pub(super) struct Achromatic {
    white_response: f64,
    per_white: f64,
    adaptation: f64,
    per_adaptation: f64,
}

impl Achromatic {
    pub(super) fn new() -> Self {
        Self {
            white_response: white_response(),
            per_white: 1.0 / white_response(),
            adaptation: adaptation(),
            per_adaptation: 1.0 / adaptation(),
        }
    }

    /// The luminance of the white that has a response A from 0, of [`REFERENCE_LUMINANCE`].
    #[inline(always)]
    pub(super) fn luminance<S: Simd>(&self, simd: S, achromatic: F64x16<S>) -> F64x16<S> {
        adapted(simd, achromatic * self.white_response) * self.per_adaptation
    }

    /// A of a white of some luminance from 0, of [`REFERENCE_LUMINANCE`].
    #[inline(always)]
    pub(super) fn of_luminance<S: Simd>(&self, simd: S, luminance: F64x16<S>) -> F64x16<S> {
        let power = power(simd, luminance * self.adaptation, EXPONENT);
        power / (power + OFFSET) * self.per_white
    }
}
