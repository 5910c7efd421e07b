//! One pixel after the other from radiance to the samples of a PNG, and what is noticed on the way.

use super::codes::Codes;
use super::dither::threshold;
use super::{Bits, Settings, View, exposure};
use crate::color::Primaries;

/// A channel above this is brighter than the screen: it would have a code of 256 or more.
const CLIPS: f64 = 1.009;

/// The settings, as far as pixels need them.
pub(super) struct Develop {
    scale: f64,
    view: View,
    bits: Bits,
    codes: Codes,
    has_alpha: bool,
    /// Where the picture's top left is in the display window.
    origin: [u32; 2],
    /// Of R, G, B in the luminance.
    weights: [f64; 3],
}

/// What was noticed about some pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Seen {
    /// The largest finite luminance, before the exposure.
    pub(super) brightest: f64,
    /// Pixels of which a channel clips.
    pub(super) clipped: u64,
}

impl Seen {
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            brightest: self.brightest.max(other.brightest),
            clipped: self.clipped + other.clipped,
        }
    }
}

impl Develop {
    /// With an exposure of `ev`, whatever the settings say, for a picture whose top left is at `origin` in
    /// the display window.
    pub(super) fn new(settings: &Settings, ev: f64, has_alpha: bool, origin: [u32; 2]) -> Self {
        Self {
            scale: exposure::scale(ev),
            view: settings.view,
            bits: settings.bits,
            codes: Codes::new(settings.bits, settings.dither),
            has_alpha,
            origin,
            weights: Primaries::REC709.luminance_weights(),
        }
    }

    /// Whether the PNG has alpha.
    pub(super) const fn has_alpha(&self) -> bool {
        self.has_alpha
    }

    /// Bits of each sample.
    pub(super) const fn bits(&self) -> Bits {
        self.bits
    }

    /// Samples of a pixel.
    pub(super) const fn channels(&self) -> usize {
        if self.has_alpha { 4 } else { 3 }
    }

    /// Bytes of a pixel.
    pub(super) const fn pixel_bytes(&self) -> usize {
        self.channels() * self.bits.bytes()
    }

    /// Row `y` of the picture, of which there are pixels from column `left` on. Where there are
    /// none it is black, and transparent where there is alpha.
    pub(super) fn row(&self, y: u32, left: u32, pixels: &[[f32; 4]], row: &mut [u8]) -> Seen {
        row.fill(0);
        let [first_x, first_y] = self.origin;
        let mut seen = Seen::default();
        let samples = row.chunks_exact_mut(self.pixel_bytes()).skip(left as usize);
        for ((&pixel, samples), x) in pixels.iter().zip(samples).zip(left..) {
            // Backgrounds are large.
            if pixel == [0.0; 4] {
                continue;
            }
            self.pixel(
                pixel,
                threshold(first_x + x, first_y + y),
                samples,
                &mut seen,
            );
        }
        seen
    }

    /// One pixel from R, G, B, A to the samples of the image.
    fn pixel(&self, pixel: [f32; 4], threshold: f64, samples: &mut [u8], seen: &mut Seen) {
        let [r, g, b, alpha] = pixel.map(f64::from);
        let per_coverage = if self.has_alpha && alpha > 0.0 && alpha.is_finite() {
            1.0 / alpha
        } else {
            1.0
        };
        let radiance = [r, g, b].map(|radiance| radiance * per_coverage);
        let [red, green, blue] = self.weights;
        let luminance = red * radiance[0] + green * radiance[1] + blue * radiance[2];
        if luminance > seen.brightest && luminance.is_finite() {
            seen.brightest = luminance;
        }
        let exposed = radiance.map(|radiance| radiance * self.scale);
        if self.view.clips() && exposed.iter().any(|&channel| channel > CLIPS) {
            seen.clipped += 1;
        }
        let light = self.view.apply(exposed);
        let [r, g, b] = light.map(|light| self.codes.code(light, threshold));
        let codes = [r, g, b, self.bits.quantize(alpha)];
        match self.bits {
            Bits::Eight => {
                for (sample, code) in samples.iter_mut().zip(codes) {
                    *sample = code as u8;
                }
            }
            Bits::Sixteen => {
                for (sample, code) in samples.chunks_exact_mut(2).zip(codes) {
                    sample.copy_from_slice(&code.to_be_bytes());
                }
            }
        }
    }
}
