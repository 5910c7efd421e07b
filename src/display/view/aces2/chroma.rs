//! The chroma compression of ACES 2.0 (Lib.Academy.OutputTransform.ctl, `chromaCompression`): colorfulness
//! follows the tone scale, is held inside of what AP1 reaches, and is expanded in the middle.

use fearless_simd::Simd;

use super::Limits;
use super::appearance::REFERENCE_LUMINANCE;
use super::lookup::Hue;
use crate::simd::F64x16;

/// `chroma_compress`, and how much of it is added for each tenfold peak.
const COMPRESSION: f64 = 2.4;
const COMPRESSION_GAIN: f64 = 3.3;

/// `chroma_expand`, how much of it is taken off for each tenfold peak, and the least that is left.
const EXPANSION: f64 = 1.3;
const EXPANSION_LOSS: f64 = 0.69;
const LEAST_EXPANSION: f64 = 0.2;

/// `chroma_expand_thr`, of the peak in cd/m².
const EXPANSION_THRESHOLD: f64 = 0.5;

/// The norm's growth with the peak P in cd/m²: (0.03379 P)^0.30596 − 0.45135 (`chromaCompressScale`).
const NORM_FACTOR: f64 = 0.03379;
const NORM_EXPONENT: f64 = 0.30596;
const NORM_OFFSET: f64 = 0.45135;

/// The norm as a Fourier series in the hue, of M of a screen of 100 cd/m² (`chromaCompressionNorm`).
const NORM_COSINES: [f64; 3] = [11.34072, 16.46899, 7.88380];
const NORM_SINES: [f64; 3] = [14.66441, -6.37224, 9.19364];
const NORM_MEAN: f64 = 77.12896;

/// How much the first toe ends before the limit (`chromaCompression`).
const BEFORE_LIMIT: f64 = 0.001;

/// The least curvature of a toe (`toe`).
const LEAST_CURVATURE: f64 = 0.001;

/// What depends on the peak.
pub(super) struct Chroma {
    compression: f64,
    expansion: f64,
    threshold: f64,
    norm: f64,
}

impl Chroma {
    pub(super) fn new(peak: f64) -> Self {
        let tenfolds = libm::log10(peak / REFERENCE_LUMINANCE);
        Self {
            compression: COMPRESSION * (1.0 + COMPRESSION_GAIN * tenfolds),
            expansion: (EXPANSION * (1.0 - EXPANSION_LOSS * tenfolds)).max(LEAST_EXPANSION),
            threshold: EXPANSION_THRESHOLD / peak,
            norm: libm::pow(NORM_FACTOR * peak, NORM_EXPONENT) - NORM_OFFSET,
        }
    }

    /// The colorfulness at a toned lightness J of what had M, which is given scaled by as much as the tone
    /// scale changed A. `achromatic` is A at J.
    #[inline(always)]
    pub(super) fn apply<S: Simd>(
        &self,
        simd: S,
        limits: &Limits,
        at: &Hue<S>,
        [lightness, achromatic]: [F64x16<S>; 2],
        colorfulness: F64x16<S>,
    ) -> F64x16<S> {
        let zero = F64x16::splat(simd, 0.0);
        let norm = norm(at) * self.norm;
        let part = lightness * (1.0 / limits.lightness);
        let rest = (F64x16::splat(simd, 1.0) - part).max(zero);
        // (J/J_max)^(1/cz) is A/A_max.
        let limit = achromatic * (1.0 / limits.achromatic) * at.reach / norm;
        let from_limit = toe(
            simd,
            limit - colorfulness / norm,
            limit - BEFORE_LIMIT,
            rest * self.expansion,
            (part * part + self.threshold).sqrt(),
        );
        toe(
            simd,
            limit - from_limit,
            limit,
            part * self.compression,
            rest,
        ) * norm
    }
}

#[inline(always)]
fn norm<S: Simd>(at: &Hue<S>) -> F64x16<S> {
    // Of twice and three times the hue.
    let (c1, s1) = (at.cosine, at.sine);
    let (c2, s2) = (c1 * c1 - s1 * s1, c1 * s1 * 2.0);
    let (c3, s3) = (c1 * c2 - s1 * s2, s1 * c2 + c1 * s2);
    let cosines = c1 * NORM_COSINES[0] + c2 * NORM_COSINES[1] + c3 * NORM_COSINES[2];
    let sines = s1 * NORM_SINES[0] + s2 * NORM_SINES[1] + s3 * NORM_SINES[2];
    cosines + sines + NORM_MEAN
}

/// A curve from 0 to `limit` with a toe, and x as it is above it: the positive root y of
/// y² − (k₃ x − k₁) y − k₂ k₃ x = 0 with k₃ = (limit + k₁)/(limit + k₂) (`toe`).
#[inline(always)]
fn toe<S: Simd>(
    simd: S,
    x: F64x16<S>,
    limit: F64x16<S>,
    k1: F64x16<S>,
    k2: F64x16<S>,
) -> F64x16<S> {
    let k2 = k2.max(F64x16::splat(simd, LEAST_CURVATURE));
    let k1 = (k1 * k1 + k2 * k2).sqrt();
    let scaled = x * (limit + k1) / (limit + k2);
    let b = scaled - k1;
    let root = (b * b + k2 * scaled * 4.0).sqrt();
    x.gt(limit).select(x, (b + root) * 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Kernel, SimdLevel};

    struct Toe([f64; 4]);

    impl Kernel for Toe {
        type Output = f64;

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> f64 {
            let [x, limit, k1, k2] = self.0;
            let result = toe(
                simd,
                F64x16::splat(simd, x),
                F64x16::splat(simd, limit),
                F64x16::splat(simd, k1),
                F64x16::splat(simd, k2),
            );
            result.to_array()[0]
        }
    }

    #[test]
    fn a_toe_is_the_inverse_of_its_formula() {
        // x = (y² + k₁ y)/(k₃ (y + k₂)) (`toe` of the CTL, inverse), which is 0 at 0 and the limit at the limit.
        for [limit, k1, k2] in [[1.0, 0.5, 0.1], [0.7, 2.4, 0.9], [2.0, 0.0, 0.3]] {
            let k1_and_k2 = f64::hypot(k1, k2);
            let k3 = (limit + k1_and_k2) / (limit + k2);
            for part in [0.0, 0.01, 0.3, 0.99, 1.0] {
                let y = limit * part;
                let x = (y * y + k1_and_k2 * y) / (k3 * (y + k2));
                let found = SimdLevel::default().run(Toe([x, limit, k1, k2]));
                assert!(
                    (found - y).abs() < 1e-14,
                    "{limit}, {k1}, {k2}: {y}, {found}"
                );
            }
            assert_eq!(SimdLevel::default().run(Toe([3.0, limit, k1, k2])), 3.0);
        }
    }
}
