//! The output transform of ACES 2.0 (Academy, `Lib.Academy.OutputTransform.ctl`, v2.0): from radiance to a screen
//! of some peak and primaries.
//!
//! ```text
//! R, G, B ─ AP1 ─ A, a, b ─ tone scale ─ chroma compression ─ gamut compression ─ limiting R, G, B
//!            │       │          │               │                    │                   │
//!            │       │          │               │                    │                   clamp to 0 … peak
//!            │       │          │               │                    J and M along a line into the gamut
//!            │       │          │               M, by how much A changed, in what AP1 reaches
//!            │       │          A → luminance → luminance on the screen → A
//!            │       the appearance: achromatic, colorfulness M = √(a² + b²), hue, which stays
//!            clamp to 0 … 8 times what reaches the peak
//! ```
//!
//! The standard has J, M and h, the appearance's lightness, colorfulness and hue. J = 100 Aᶜᶻ, so that where it
//! raises a ratio of two J to 1/cz, that is the ratio of their A; and the sine and the cosine of h are b/M and
//! a/M. That spares three powers, a sine and a cosine.
//!
//! **Range.** Any finite R, G, B; peaks from 100 to 10 000 cd/m², for which the tone scale is made.
//!
//! **What is measured.** Against OpenColorIO 2.6.0, whose built-in transforms are what most programs show:
//! half a million colors (grays from −10 to +10 EV, the primaries, muted and saturated ones up to 2¹⁰, and those
//! outside of Rec.709 and of AP1) differ by 4.4e-5 at most in sRGB codes and in those of Display P3. As f32 the
//! tables of OpenColorIO carry errors of that size: the same algorithm in f64 differs by 2.4e-6 of the peak at
//! most, with one exception.
//!
//! **Where OpenColorIO and the CTL differ**, OpenColorIO is followed: in the hues of the table of cusps, the
//! points at which its upper hull is tried, and how closely each entry is sought. One thing is not: with Rec.2020,
//! for 0.13° of hue at most, OpenColorIO's search takes the line of the next two hues in place of the right
//! one, off by up to 0.07° (at 192.05° for 1000 cd/m²). There the most saturated of colors differ by up to
//! 4e-4 in PQ codes, and by 2e-3 for 10 000 cd/m²; with Rec.709, and with P3 up to 1000 cd/m², none do.

mod appearance;
mod chroma;
mod gamut;
mod lookup;
mod tables;
#[cfg(test)]
mod tests;
mod tone;

use fearless_simd::Simd;
use glam::DMat3;

use crate::color::Primaries;
use crate::color::adaptation::conversion;
use crate::display::lanes::{Rgb, Transform, each, product, rows};
use crate::simd::{F64x16, angle, power};

use appearance::{Achromatic, Appearance, LIGHTNESS, REFERENCE_LUMINANCE};
use chroma::Chroma;
use gamut::Compression;
use lookup::Lookup;
use tables::{Source, Tables};
use tone::ToneScale;

/// Less colorful, or darker, is nothing: it is below all that normal numbers give.
const NOTHING: f64 = 1e-150;

/// The transform for one screen.
pub(in crate::display) struct Aces2 {
    /// From Rec.709, whose white becomes the one of ACES.
    to_ap1: [[f64; 3]; 3],
    /// To Rec.709. As in OpenColorIO, no white is adapted to another.
    to_rec709: [[f64; 3]; 3],
    scene: Appearance,
    screen: Appearance,
    achromatic: Achromatic,
    tone: ToneScale,
    chroma: Chroma,
    compression: Compression,
    hues: Lookup,
    limits: Limits,
    /// R, G, B of the peak.
    peak: f64,
}

/// The appearance of the peak's white.
#[derive(Clone, Copy)]
struct Limits {
    /// J
    lightness: f64,
    /// A
    achromatic: f64,
    /// cz: J = 100 Aᶜᶻ.
    exponent: f64,
    /// 1/cz
    per_exponent: f64,
}

impl Aces2 {
    /// For a screen with a peak of some cd/m² and a gamut. A result of 1 is 100 cd/m², so that the peak's white
    /// is peak/100.
    pub(in crate::display) fn new(peak: f64, limiting: &Primaries) -> Self {
        let scene = Appearance::new(&Primaries::AP1);
        let screen = Appearance::new(limiting);
        let tone = ToneScale::new(peak);
        let exponent = appearance::lightness_exponent();
        let limits = Limits {
            lightness: appearance::lightness(peak),
            achromatic: appearance::achromatic(peak),
            exponent,
            per_exponent: 1.0 / exponent,
        };
        let middle = appearance::lightness(tone.gray);
        let compression = Compression::new(peak, middle, limits);
        let rgb_peak = peak / REFERENCE_LUMINANCE;
        let tables = Tables::new(&Source {
            reach: &scene,
            limiting: &screen,
            limits: &limits,
            compression: &compression,
            peak: rgb_peak,
            brightest: tone.brightest,
        });
        let to_rec709 = if *limiting == Primaries::REC709 {
            DMat3::IDENTITY
        } else {
            Primaries::REC709.from_xyz() * limiting.to_xyz()
        };
        Self {
            to_ap1: rows(conversion(&Primaries::REC709, &Primaries::AP1)),
            to_rec709: rows(to_rec709),
            scene,
            screen,
            achromatic: Achromatic::new(),
            tone,
            chroma: Chroma::new(peak),
            compression,
            hues: Lookup::new(&tables),
            limits,
            peak: rgb_peak,
        }
    }
}

impl Aces2 {
    /// The radiance of grays that reaches the peak.
    pub(in crate::display) const fn white(&self) -> f64 {
        self.tone.roof
    }
}

impl Transform for Aces2 {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, rgb: Rgb<S>) -> Rgb<S> {
        let zero = F64x16::splat(simd, 0.0);
        let one = F64x16::splat(simd, 1.0);
        let brightest = F64x16::splat(simd, self.tone.brightest);
        let scene = each(
            product(&self.to_ap1, rgb),
            #[inline(always)]
            |x| x.max(zero).min(brightest),
        );
        let [achromatic, a, b] = self.scene.opponent(simd, scene);
        let colorfulness = (a * a + b * b).sqrt();
        let has_hue = colorfulness.gt(F64x16::splat(simd, NOTHING));
        let per_colorfulness = one / has_hue.select(colorfulness, one);
        let cosine = has_hue.select(a * per_colorfulness, one);
        let sine = b * per_colorfulness;
        let hue = angle(simd, [a, b], colorfulness);
        let hue = self.hues.at(simd, hue, [cosine, sine]);

        let luminance = self.achromatic.luminance(simd, achromatic);
        let luminance = self.tone.apply(simd, luminance);
        let toned = self.achromatic.of_luminance(simd, luminance);
        let lightness = power(simd, toned, self.limits.exponent) * LIGHTNESS;

        let change = toned / achromatic.max(F64x16::splat(simd, NOTHING));
        let colorfulness = self.chroma.apply(
            simd,
            &self.limits,
            &hue,
            [lightness, toned],
            colorfulness * change,
        );
        let before = [lightness, colorfulness];
        let ([lightness, colorfulness], has_changed) =
            self.compression.apply(simd, &hue.gamut, hue.reach, before);
        let achromatic = if has_changed {
            power(
                simd,
                lightness * (1.0 / LIGHTNESS),
                self.limits.per_exponent,
            )
        } else {
            toned
        };
        let opponent = [achromatic, colorfulness * cosine, colorfulness * sine];
        let peak = F64x16::splat(simd, self.peak);
        let limited = each(
            self.screen.rgb(simd, opponent),
            #[inline(always)]
            |x| x.max(zero).min(peak),
        );
        product(&self.to_rec709, limited)
    }
}
