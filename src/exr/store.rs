//! The values of an image as a file has them before compression.

use half::f16;

use super::Precision;
use crate::image::{ChannelKind, ImageSpec, Rows};

/// The channels that every film has, in the order of its pixels.
const RGBA: [&str; 4] = ["R", "G", "B", "A"];

/// A channel of the file, and where the film has its values.
pub(super) struct FileChannel<'f> {
    pub(super) name: &'f str,
    pub(super) precision: Precision,
    stored_in: StoredIn,
    /// Whether digits that halves lose below their smallest normal one are worth a word.
    is_small_counted: bool,
}

/// Where the values of a channel are.
#[derive(Clone, Copy)]
enum StoredIn {
    /// In [`Rows::pixels`], at this place of each.
    Pixels(usize),
    /// In [`Rows::values`], at this place of each.
    Values(usize),
}

impl FileChannel<'_> {
    /// Its place among R, G, B, A, if it is one of them.
    pub(super) fn place_in_rgba(&self) -> Option<usize> {
        match self.stored_in {
            StoredIn::Pixels(place) => Some(place),
            StoredIn::Values(_) => None,
        }
    }
}

impl ImageSpec {
    /// All channels in the file's order, which is that of their names' bytes.
    pub(super) fn file_channels(&self, precision: Precision) -> Vec<FileChannel<'_>> {
        let rgba = RGBA
            .into_iter()
            .enumerate()
            .map(|(place, name)| FileChannel {
                name,
                precision,
                stored_in: StoredIn::Pixels(place),
                is_small_counted: false,
            });
        let further = self.channels.list.iter().enumerate();
        let further = further.map(|(place, channel)| FileChannel {
            name: &channel.name,
            precision: match channel.kind {
                ChannelKind::Light | ChannelKind::Relative => precision,
                ChannelKind::Data | ChannelKind::Matte => Precision::Float,
            },
            stored_in: StoredIn::Values(place),
            is_small_counted: match channel.kind {
                ChannelKind::Light => true,
                ChannelKind::Relative | ChannelKind::Data | ChannelKind::Matte => false,
            },
        });
        let mut channels: Vec<_> = rgba.chain(further).collect();
        channels.sort_by_key(|channel| channel.name);
        channels
    }
}

impl Rows<'_> {
    /// Appends a block of lines as the file has it before compression.
    pub(super) fn store(
        self,
        channels: &[FileChannel<'_>],
        width: usize,
        bytes: &mut Vec<u8>,
    ) -> Halves {
        let further = self.values.len() / self.pixels.len();
        let mut halves = Halves::default();
        for start in (0..self.pixels.len()).step_by(width) {
            let row = start..start + width;
            let values = &self.values[start * further..];
            for channel in channels {
                let precision = channel.precision;
                let stored = match channel.stored_in {
                    StoredIn::Pixels(place) => {
                        let pixels = self.pixels[row.clone()].iter();
                        let values = pixels.map(|pixel| pixel[place]);
                        store(values, precision, bytes)
                    }
                    StoredIn::Values(place) => {
                        let values = &values[place * width..][..width];
                        store(values.iter().copied(), precision, bytes)
                    }
                };
                halves.clamped += stored.clamped;
                if channel.is_small_counted {
                    halves.small += stored.small;
                }
            }
        }
        halves
    }
}

/// How far sums of layers are off the image at most, in the numbers that the file has.
pub(super) fn residual(
    rows: Rows<'_>,
    sums: &[Vec<usize>],
    width: usize,
    precision: Precision,
    space: &mut Vec<f64>,
) -> f64 {
    let stored = |value: f32| {
        f64::from(match precision {
            Precision::Float => value,
            Precision::Half => to_half(value).0.to_f32(),
        })
    };
    if sums.is_empty() {
        return 0.0;
    }
    let further = rows.values.len() / rows.pixels.len();
    let mut largest = 0.0_f64;
    let lines = rows.pixels.chunks_exact(width);
    for (pixels, values) in lines.zip(rows.values.chunks_exact(width * further)) {
        for layers in sums {
            for channel in 0..3 {
                space.clear();
                space.extend(pixels.iter().map(|pixel| -stored(pixel[channel])));
                for first in layers {
                    let values = &values[(first + channel) * width..][..width];
                    for (sum, &value) in space.iter_mut().zip(values) {
                        *sum += stored(value);
                    }
                }
                largest = space.iter().fold(largest, |most, sum| most.max(sum.abs()));
            }
        }
    }
    largest
}

/// Values that halves do not hold well.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Halves {
    /// Beyond ± the largest.
    pub(super) clamped: u64,
    /// Not 0, but below the smallest normal one.
    pub(super) small: u64,
}

impl Halves {
    pub(super) fn add(&mut self, more: Self) {
        self.clamped += more.clamped;
        self.small += more.small;
    }
}

/// Appends values as the file has them before compression.
fn store(
    values: impl ExactSizeIterator<Item = f32>,
    precision: Precision,
    bytes: &mut Vec<u8>,
) -> Halves {
    let mut halves = Halves::default();
    let start = bytes.len();
    match precision {
        Precision::Float => {
            bytes.resize(start + values.len() * size_of::<f32>(), 0);
            let (stored, _) = bytes[start..].as_chunks_mut();
            for (stored, value) in stored.iter_mut().zip(values) {
                *stored = value.to_ne_bytes();
            }
        }
        Precision::Half => {
            bytes.resize(start + values.len() * size_of::<f16>(), 0);
            let (stored, _) = bytes[start..].as_chunks_mut();
            for (stored, value) in stored.iter_mut().zip(values) {
                let (half, is_clamped) = to_half(value);
                halves.clamped += u64::from(is_clamped);
                let is_small = value != 0.0 && value.abs() < f16::MIN_POSITIVE.to_f32();
                halves.small += u64::from(is_small);
                *stored = half.to_ne_bytes();
            }
        }
    }
    halves
}

/// Rounds to the nearest half, values beyond the largest to that; whether it was beyond.
fn to_half(value: f32) -> (f16, bool) {
    let largest = f16::MAX.to_f32();
    (
        f16::from_f32(value.clamp(-largest, largest)),
        value.abs() > largest,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_rounded_and_clamped() {
        assert_eq!(to_half(1.0), (f16::ONE, false));
        assert_eq!(to_half(65_504.0), (f16::MAX, false));
        assert_eq!(to_half(65_505.0), (f16::MAX, true));
        assert_eq!(to_half(-1e30), (f16::MIN, true));
        // Halfway between 1 and the next half, 1 + 2⁻¹⁰: to even.
        assert_eq!(to_half(1.0 + 1.0 / 2048.0), (f16::ONE, false));
    }
}
