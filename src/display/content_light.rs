//! How bright a picture in PQ is, measured on its samples as they are written (CTA-861.3-A, annex A).

use super::Bits;
use super::tags::ContentLight;
use crate::color::transfer::pq_decode;

/// Parts of a cd/m²: the unit of a PNG's cLLI. In whole numbers of it sums are the same in any order.
const PARTS: f64 = 1e4;

/// The luminance of every code, in 0.0001 cd/m².
pub(super) struct LightMeter {
    luminances: Vec<u32>,
    bits: Bits,
    channels: usize,
}

/// What was measured of some pixels, in 0.0001 cd/m².
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Light {
    /// The brightest channel.
    brightest: u32,
    /// Of each pixel's brightest channel.
    sum: u128,
}

impl LightMeter {
    /// For samples in PQ; `None` for floats, which no file has that says how bright it is.
    pub(super) fn new(bits: Bits, channels: usize) -> Option<Self> {
        let most = match bits {
            Bits::Eight => u32::from(u8::MAX),
            Bits::Sixteen => u32::from(u16::MAX),
            Bits::ThirtyTwo => return None,
        };
        let luminance = |code| pq_decode(f64::from(code) / f64::from(most));
        let luminances = (0..=most).map(|code| (luminance(code) * PARTS).round() as u32);
        Some(Self {
            luminances: luminances.collect(),
            bits,
            channels,
        })
    }

    /// Of samples as a PNG has them: R, G, B as they are, whatever their coverage.
    pub(super) fn of_row(&self, samples: &[u8]) -> Light {
        let pixels = samples.chunks_exact(self.channels * self.bits.bytes());
        // More light has a larger code.
        pixels.fold(Light::default(), |light, pixel| {
            let color = &pixel[..3 * self.bits.bytes()];
            let code = match self.bits {
                Bits::Eight => color.iter().copied().max().map(usize::from),
                Bits::Sixteen | Bits::ThirtyTwo => {
                    let (codes, _) = color.as_chunks::<2>();
                    let codes = codes.iter().map(|&code| u16::from_be_bytes(code));
                    codes.max().map(usize::from)
                }
            };
            let brightest = self.luminances[code.unwrap_or(0)];
            light.and(Light {
                brightest,
                sum: brightest.into(),
            })
        })
    }
}

impl Light {
    pub(super) fn and(self, other: Self) -> Self {
        Self {
            brightest: self.brightest.max(other.brightest),
            sum: self.sum + other.sum,
        }
    }

    /// Of a picture of so many pixels, at least one.
    pub(super) fn content(self, pixels: u64) -> ContentLight {
        ContentLight {
            brightest: f64::from(self.brightest) / PARTS,
            average: self.sum as f64 / pixels as f64 / PARTS,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// SMPTE ST 2084: half the range is 92.25 cd/m², and 16 bits of 203 cd/m² are 38 055 codes.
    #[test]
    fn the_brightest_channel_counts() {
        let meter = LightMeter::new(Bits::Eight, 3).unwrap();
        let light = meter.of_row(&[0, 0, 0, 10, 255, 3, 128, 128, 127, 0, 0, 0]);
        let content = light.content(4);
        assert_eq!(content.brightest, 10_000.0);
        let half = content.average * 4.0 - 10_000.0;
        assert!((half - pq_decode(128.0 / 255.0)).abs() < 0.5e-4, "{half}");

        // A fourth sample is no light.
        let meter = LightMeter::new(Bits::Sixteen, 4).unwrap();
        let white = 38_055_u16.to_be_bytes();
        let row = [[0, 0], white, [0, 200], [255, 255]].concat();
        let content = meter.of_row(&row).content(1);
        // Half a code.
        assert!((content.brightest - 203.0).abs() < 0.02, "{content:?}");
        assert_eq!(content.average, content.brightest);
        assert!(LightMeter::new(Bits::ThirtyTwo, 3).is_none());
    }

    #[test]
    fn parts_add_up_to_the_whole() {
        let meter = LightMeter::new(Bits::Sixteen, 3).unwrap();
        let samples: Vec<u8> = (0..6 * 1000_u32).map(|i| ((i * i) >> 5) as u8).collect();
        let whole = meter.of_row(&samples);
        for pixels in [1, 7, 400] {
            let parts = samples.chunks(6 * pixels).map(|part| meter.of_row(part));
            assert_eq!(parts.fold(Light::default(), Light::and), whole);
        }
    }
}
