//! Colors that a screen's primaries cannot mix.

use fearless_simd::Simd;

use super::lanes::{Rgb, Transform};
use crate::color::Primaries;
use crate::color::adaptation::conversion;
use crate::simd::{F64x16, power};
use glam::DVec3;

/// What becomes of colors outside of the screen's gamut, whose R, G or B is below 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gamut {
    /// The channel is 0.
    #[default]
    Clip,
    /// Saturated colors move towards gray: those of Rec.2020 come to lie inside, in their order, and what is not
    /// saturated stays as it is.
    Compress,
}

impl Gamut {
    /// Every choice, in the order of the documentation.
    pub const ALL: [Self; 2] = [Self::Clip, Self::Compress];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Clip => "clip",
            Self::Compress => "compress",
        }
    }
}

/// Distances from gray up to this stay: those of the colors of usual paints and lights in Rec.709.
const THRESHOLD: f64 = 0.8;

/// How sharply the compression sets in, as in the Reference Gamut Compression of ACES 1.3.
const POWER: f64 = 1.2;

/// The curve of the Reference Gamut Compression of ACES 1.3 (Academy S-2020-001): a channel c below the largest of
/// R, G, B, M > 0, is at the distance d = (M − c)/M. From t = [`THRESHOLD`] on, d becomes
/// t + s x / (1 + x^p)^(1/p), x = (d − t)/s, with the s of each channel that takes the largest distance of
/// Rec.2020's colors to 1. (There s is for the cameras of its time, in AP1; here for the screen's own primaries.)
#[derive(Debug)]
pub(super) struct Compression {
    /// s; `None` where no color of Rec.2020 is outside.
    scales: [Option<f64>; 3],
}

impl Compression {
    /// In a screen's primaries; `None` where nothing is to be done.
    pub(super) fn new(screen: &Primaries) -> Option<Self> {
        let to_screen = conversion(&Primaries::REC2020, screen);
        // The distance of a channel is largest at a corner of the cube of colors.
        let corners = (1..7).map(|bits: u32| {
            let part = |bit: u32| f64::from(bits >> bit & 1);
            to_screen * DVec3::new(part(0), part(1), part(2))
        });
        let limits = corners.fold(DVec3::ZERO, |limits, color| {
            let most = color.max_element();
            limits.max((DVec3::splat(most) - color) / most)
        });
        let scales = limits.to_array().map(scale);
        scales
            .iter()
            .any(Option::is_some)
            .then_some(Self { scales })
    }
}

/// s of a channel whose largest distance is so much.
fn scale(limit: f64) -> Option<f64> {
    // What rounding leaves of 1 is no distance.
    let beyond = limit - 1.0;
    (beyond > 1e-9).then(|| {
        let ratio = (1.0 - THRESHOLD) / (limit - THRESHOLD);
        (limit - THRESHOLD) / libm::pow(libm::pow(ratio, -POWER) - 1.0, 1.0 / POWER)
    })
}

impl Transform for Compression {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
        let [r, g, b] = rgb;
        let most = r.max(g).max(b);
        let is_light = most.gt(F64x16::splat(simd, 0.0));
        // Of black, and of what is below 0 altogether, nothing is said.
        let safe = is_light.select(most, F64x16::splat(simd, 1.0));
        let inverse = F64x16::splat(simd, 1.0) / safe;
        let [red, green, blue] = self.scales;
        let compressed = [
            channel(simd, r, safe, inverse, red),
            channel(simd, g, safe, inverse, green),
            channel(simd, b, safe, inverse, blue),
        ];
        let [x, y, z] = compressed;
        [
            is_light.select(x, r),
            is_light.select(y, g),
            is_light.select(z, b),
        ]
    }
}

#[inline(always)]
fn channel<S: Simd>(
    simd: S,
    value: F64x16<S>,
    most: F64x16<S>,
    inverse: F64x16<S>,
    scale: Option<f64>,
) -> F64x16<S> {
    let Some(scale) = scale else {
        return value;
    };
    let distance = (most - value) * inverse;
    let is_far = distance.gt(F64x16::splat(simd, THRESHOLD));
    if !is_far.any() {
        return value;
    }
    let x = (distance - THRESHOLD) * (1.0 / scale);
    let root = power(simd, power(simd, x, POWER) + 1.0, -1.0 / POWER);
    let compressed = most - (x * root * scale + THRESHOLD) * most;
    is_far.select(compressed, value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::lanes::of_one;

    #[test]
    fn rec2020_comes_inside_and_gray_stays() {
        let screen = Compression::new(&Primaries::REC709).unwrap();
        let to_screen = conversion(&Primaries::REC2020, &Primaries::REC709);
        let mut least = f64::INFINITY;
        for bits in 1..8_u32 {
            let part = |bit: u32| f64::from(bits >> bit & 1);
            let color = to_screen * DVec3::new(part(0), part(1), part(2));
            let inside = of_one(&screen, color.to_array());
            least = inside.into_iter().fold(least, f64::min);
            // The brightest channel is kept.
            let most = inside.into_iter().fold(0.0, f64::max);
            assert!((most - color.max_element()).abs() < 1e-12);
        }
        // A border of the one is the border of the other, to the polynomials of the powers.
        assert!(least.abs() < 1e-9, "{least}");
        for color in [
            [0.18; 3],
            [1.0, 0.5, 0.3],
            [0.2, 0.2, 0.9],
            [-1.0, -2.0, 0.0],
        ] {
            assert_eq!(of_one(&screen, color), color);
        }
    }

    #[test]
    fn order_is_kept() {
        let screen = Compression::new(&Primaries::REC709).unwrap();
        let mut last = f64::INFINITY;
        for step in 0..400 {
            let [red, ..] = of_one(&screen, [1.0 - f64::from(step) / 100.0, 1.0, 0.5]);
            assert!(red < last);
            last = red;
        }
    }

    #[test]
    fn the_widest_screen_needs_none() {
        assert!(Compression::new(&Primaries::REC2020).is_none());
        assert!(Compression::new(&Primaries::P3_D65).is_some());
    }
}
