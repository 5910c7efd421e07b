//! From decoded samples to linear R, G, B, A.

use super::coding::Coding;
use super::problem::ImageFileProblem;
use crate::memory;

/// What a sample is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Depth {
    /// A byte: 0 to 255.
    Eight,
    /// Two bytes, in the machine's order: 0 to 65 535.
    Sixteen,
    /// f32, in the machine's order.
    Float,
}

impl Depth {
    pub(super) const fn bytes(self) -> usize {
        match self {
            Self::Eight => 1,
            Self::Sixteen => 2,
            Self::Float => 4,
        }
    }
}

/// What the samples of a pixel are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Channels {
    Gray,
    GrayAlpha,
    Rgb,
    Rgba,
}

impl Channels {
    pub(super) const fn count(self) -> usize {
        match self {
            Self::Gray => 1,
            Self::GrayAlpha => 2,
            Self::Rgb => 3,
            Self::Rgba => 4,
        }
    }

    pub(super) const fn has_alpha(self) -> bool {
        match self {
            Self::Gray | Self::Rgb => false,
            Self::GrayAlpha | Self::Rgba => true,
        }
    }
}

/// How decoded samples lie in memory, and what they mean.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub(super) depth: Depth,
    pub(super) channels: Channels,
    /// Whether code values of R, G, B are multiplied by A.
    pub(super) is_premultiplied: bool,
    pub(super) coding: Coding,
}

impl Layout {
    pub(super) const fn pixel_bytes(&self) -> usize {
        self.depth.bytes() * self.channels.count()
    }

    /// Linear R, G, B, A of decoded samples; R, G, B multiplied by A.
    pub(super) fn pixels(&self, samples: &[u8]) -> Result<Vec<[f32; 4]>, ImageFileProblem> {
        let mut pixels = Vec::new();
        let count = samples.len() / self.pixel_bytes();
        memory::reserve(&mut pixels, count).map_err(|error| error.for_what("the picture"))?;
        match self.depth {
            Depth::Eight => {
                let codes = samples.chunks_exact(self.channels.count());
                let table = self.coding.table(u16::from(u8::MAX));
                pixels.extend(codes.map(|codes| {
                    let codes = self.spread(codes.iter().map(|&code| u16::from(code)), 255);
                    self.of_codes(codes, 255, &table)
                }));
            }
            Depth::Sixteen => {
                let (pairs, _) = samples.as_chunks::<2>();
                let codes = pairs.chunks_exact(self.channels.count());
                let table = self.coding.table(u16::MAX);
                pixels.extend(codes.map(|codes| {
                    let codes = codes.iter().map(|&pair| u16::from_ne_bytes(pair));
                    self.of_codes(self.spread(codes, u16::MAX), u16::MAX, &table)
                }));
            }
            Depth::Float => {
                let (fours, _) = samples.as_chunks::<4>();
                let values = fours.chunks_exact(self.channels.count());
                pixels.extend(values.map(|values| {
                    let values = values.iter().map(|&bytes| f32::from_ne_bytes(bytes));
                    self.of_floats(self.spread(values, 1.0))
                }));
            }
        }
        Ok(pixels)
    }

    /// The samples of a pixel as R, G, B, A.
    fn spread<T: Copy>(&self, samples: impl Iterator<Item = T>, opaque: T) -> [T; 4] {
        let mut all = [opaque; 4];
        for (place, sample) in all.iter_mut().zip(samples) {
            *place = sample;
        }
        let [first, second, third, fourth] = all;
        match self.channels {
            Channels::Gray => [first, first, first, opaque],
            Channels::GrayAlpha => [first, first, first, second],
            Channels::Rgb => [first, second, third, opaque],
            Channels::Rgba => [first, second, third, fourth],
        }
    }

    fn of_codes(&self, [r, g, b, a]: [u16; 4], largest: u16, table: &[f32]) -> [f32; 4] {
        let alpha = f32::from(a) / f32::from(largest);
        let rgb = if self.is_premultiplied && a > 0 && a < largest {
            // The curve belongs to the color that was multiplied.
            [r, g, b].map(|code| self.coding.curve.light(f64::from(code) / f64::from(a)) as f32)
        } else {
            [r, g, b].map(|code| table[usize::from(code)])
        };
        self.covered(rgb, alpha, a == 0 && self.is_premultiplied)
    }

    fn of_floats(&self, [r, g, b, a]: [f32; 4]) -> [f32; 4] {
        // Floats are light: what they are multiplied by needs no undoing.
        self.covered([r, g, b], a, self.is_premultiplied)
    }

    /// A pixel whose light is multiplied by its coverage, unless it `is` already.
    fn covered(&self, rgb: [f32; 3], alpha: f32, is: bool) -> [f32; 4] {
        let coverage = if is { 1.0 } else { alpha };
        let [r, g, b] = self.coding.finish(rgb).map(|channel| channel * coverage);
        [r, g, b, alpha]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::transfer::srgb_decode;

    fn pixels(
        depth: Depth,
        channels: Channels,
        is_premultiplied: bool,
        samples: &[u8],
    ) -> Vec<[f32; 4]> {
        let coding = match depth {
            Depth::Eight | Depth::Sixteen => Coding::SRGB,
            Depth::Float => Coding::LINEAR,
        };
        let layout = Layout {
            depth,
            channels,
            is_premultiplied,
            coding,
        };
        layout.pixels(samples).unwrap()
    }

    #[test]
    fn grays_are_spread() {
        let light = srgb_decode(128.0 / 255.0) as f32;
        let gray = pixels(Depth::Eight, Channels::Gray, false, &[128, 0]);
        assert_eq!(gray, [[light, light, light, 1.0], [0.0, 0.0, 0.0, 1.0]]);
        let [half] = pixels(Depth::Eight, Channels::GrayAlpha, false, &[128, 51])[..] else {
            panic!("one pixel");
        };
        assert_eq!(half, [light * 0.2, light * 0.2, light * 0.2, 0.2]);
    }

    /// A color that is multiplied by its coverage in code values has the light of the color times the coverage.
    #[test]
    fn both_kinds_of_alpha_mean_the_same() {
        let straight = pixels(Depth::Eight, Channels::Rgba, false, &[200, 100, 50, 51]);
        let premultiplied = pixels(Depth::Eight, Channels::Rgba, true, &[40, 20, 10, 51]);
        for (a, b) in straight[0].iter().zip(premultiplied[0]) {
            assert!((a - b).abs() < 1e-7, "{straight:?} {premultiplied:?}");
        }
        // Light without coverage stays.
        let glow = pixels(Depth::Eight, Channels::Rgba, true, &[255, 0, 0, 0]);
        assert_eq!(glow, [[1.0, 0.0, 0.0, 0.0]]);
        let floats = [2.0_f32, 1.0, 0.5, 0.5].map(f32::to_ne_bytes);
        let floats = floats.as_flattened();
        let straight = pixels(Depth::Float, Channels::Rgba, false, floats);
        assert_eq!(straight, [[1.0, 0.5, 0.25, 0.5]]);
        let premultiplied = pixels(Depth::Float, Channels::Rgba, true, floats);
        assert_eq!(premultiplied, [[2.0, 1.0, 0.5, 0.5]]);
    }
}
