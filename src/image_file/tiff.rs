//! TIFF: gray and color in 8 and 16 bits, which are coded as sRGB, and color in 32-bit floats, which are light.

use std::io::Cursor;

use ::image::codecs::tiff::TiffDecoder;
use ::image::{ColorType, ImageDecoder, Limits};

use super::coding::Coding;
use super::orientation::upright;
use super::problem::{ImageFileProblem, of_decoder, unsupported};
use super::samples::{Channels, Depth, Layout};
use super::{Decoded, ImageFormat, check_size, room};

pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, ImageFileProblem> {
    let problem = |error| of_decoder(ImageFormat::Tiff, error);
    let mut decoder = TiffDecoder::new(Cursor::new(bytes)).map_err(problem)?;
    let resolution = <[u32; 2]>::from(decoder.dimensions());
    check_size(resolution, bytes.len())?;
    let (channels, depth) = match decoder.color_type() {
        ColorType::L8 => (Channels::Gray, Depth::Eight),
        ColorType::La8 => (Channels::GrayAlpha, Depth::Eight),
        ColorType::Rgb8 => (Channels::Rgb, Depth::Eight),
        ColorType::Rgba8 => (Channels::Rgba, Depth::Eight),
        ColorType::L16 => (Channels::Gray, Depth::Sixteen),
        ColorType::La16 => (Channels::GrayAlpha, Depth::Sixteen),
        ColorType::Rgb16 => (Channels::Rgb, Depth::Sixteen),
        ColorType::Rgba16 => (Channels::Rgba, Depth::Sixteen),
        ColorType::Rgb32F => (Channels::Rgb, Depth::Float),
        ColorType::Rgba32F => (Channels::Rgba, Depth::Float),
        other => return Err(unsupported(ImageFormat::Tiff, &format!("{other:?}"))),
    };
    let tags = Tags::of(bytes);
    let mut warnings = Vec::new();
    if tags.has_profile {
        warnings.push(super::problem::PROFILE.to_owned());
    }
    let coding = match depth {
        Depth::Eight | Depth::Sixteen => Coding::SRGB,
        Depth::Float => Coding::LINEAR,
    };
    let layout = Layout {
        depth,
        channels,
        is_premultiplied: tags.is_premultiplied,
        coding,
    };
    // The decoder has samples of its own; those of inks are four.
    let [width, height] = resolution.map(u64::from);
    let own = width * height * 4 * depth.bytes() as u64;
    let mut samples = room(resolution, layout.pixel_bytes(), own)?;
    let mut limits = Limits::no_limits();
    // Its own samples, and as much for a strip or tile.
    limits.max_alloc = Some(own.saturating_mul(2).saturating_add(1 << 20));
    decoder.set_limits(limits).map_err(problem)?;
    let orientation = decoder.orientation().map_err(problem)?;
    decoder.read_image(&mut samples).map_err(problem)?;
    let mut pixels = layout.pixels(&samples)?;
    let resolution = upright(&mut pixels, resolution, orientation)?;
    Ok(Decoded {
        resolution,
        pixels,
        has_alpha: channels.has_alpha(),
        primaries: coding.primaries,
        pixel_aspect: 1.0,
        warnings,
    })
}

/// What the first directory says that the decoder does not tell (TIFF 6.0, section 2 and `ExtraSamples`).
#[derive(Debug, Default, PartialEq, Eq)]
struct Tags {
    /// `ExtraSamples` begins with 1, associated alpha.
    is_premultiplied: bool,
    /// There is an ICC profile.
    has_profile: bool,
}

/// Numbers of a file in its own order.
struct Numbers<'b> {
    bytes: &'b [u8],
    is_little: bool,
}

impl Numbers<'_> {
    /// The number of so many bytes at this place; `None` beyond the end.
    fn at(&self, place: u64, size: usize) -> Option<u64> {
        let place = usize::try_from(place).ok()?;
        let bytes = self.bytes.get(place..place.checked_add(size)?)?;
        let add = |number: u64, &byte: &u8| number << 8 | u64::from(byte);
        Some(if self.is_little {
            bytes.iter().rev().fold(0, add)
        } else {
            bytes.iter().fold(0, add)
        })
    }
}

impl Tags {
    const EXTRA_SAMPLES: u64 = 338;
    const ICC_PROFILE: u64 = 34675;
    const ASSOCIATED: u64 = 1;

    /// Nothing where the directory is beyond the end: the decoder says what is wrong.
    fn of(bytes: &[u8]) -> Self {
        Self::read(bytes).unwrap_or_default()
    }

    fn read(bytes: &[u8]) -> Option<Self> {
        let numbers = Numbers {
            bytes,
            is_little: bytes.starts_with(b"II"),
        };
        let mut tags = Self::default();
        // Sizes of a count of entries, of an entry, and of places.
        let is_big = numbers.at(2, 2)? == 43;
        let (count_size, entry, place_size) = if is_big { (8, 20, 8) } else { (2, 12, 4) };
        let directory = numbers.at(if is_big { 8 } else { 4 }, place_size)?;
        let count = numbers.at(directory, count_size)?;
        for number in 0..count {
            let start = directory.checked_add(count_size as u64 + number * entry)?;
            match numbers.at(start, 2)? {
                Self::EXTRA_SAMPLES => {
                    let value = start + 4 + place_size as u64;
                    tags.is_premultiplied = numbers.at(value, 2)? == Self::ASSOCIATED;
                }
                Self::ICC_PROFILE => tags.has_profile = true,
                _ => {}
            }
        }
        Some(tags)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A directory alone, in both orders and sizes.
    #[test]
    fn tags_are_found_in_every_kind() {
        fn file(is_little: bool, is_big: bool) -> Vec<u8> {
            let number = |value: u64, size: usize| -> Vec<u8> {
                let mut bytes = value.to_le_bytes()[..size].to_vec();
                if !is_little {
                    bytes.reverse();
                }
                bytes
            };
            let place = if is_big { 8 } else { 4 };
            let mut file = if is_little { b"II" } else { b"MM" }.to_vec();
            file.extend(number(if is_big { 43 } else { 42 }, 2));
            if is_big {
                file.extend(number(8, 2));
                file.extend(number(0, 2));
            }
            file.extend(number(2 * place, place as usize));
            file.extend(number(2, if is_big { 8 } else { 2 }));
            for (tag, value) in [(338, 1), (34675, 0)] {
                file.extend(number(tag, 2));
                file.extend(number(3, 2));
                file.extend(number(1, place as usize));
                file.extend(number(value, 2));
                file.resize(file.len() + place as usize - 2, 0);
            }
            file
        }
        let expected = Tags {
            is_premultiplied: true,
            has_profile: true,
        };
        for (is_little, is_big) in [(true, false), (false, false), (true, true), (false, true)] {
            let file = file(is_little, is_big);
            assert_eq!(Tags::of(&file), expected);
            assert_eq!(Tags::of(&file[..6]), Tags::default());
        }
    }
}
