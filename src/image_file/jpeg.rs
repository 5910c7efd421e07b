//! JPEG: 8 bits, gray, Y'CbCr or RGB, in sRGB.

use std::io::Cursor;

use ::image::codecs::jpeg::JpegDecoder;
use ::image::{ColorType, ImageDecoder};

use super::coding::Coding;
use super::orientation::upright;
use super::problem::{ImageFileProblem, TOO_EARLY, damaged, of_decoder, unsupported};
use super::samples::{Channels, Depth, Layout};
use super::{Decoded, ImageFormat, check_size, room};

/// Bytes for each pixel that the decoder takes: four coefficients of two bytes of a progressive picture.
const COEFFICIENTS: u64 = 8;

pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, ImageFileProblem> {
    let frame = Frame::of(bytes)?;
    check_size(frame.resolution, bytes.len())?;
    if frame.precision != 8 {
        let kind = format!("{} bits a sample", frame.precision);
        return Err(unsupported(ImageFormat::Jpeg, &kind));
    }
    let [width, height] = frame.resolution.map(u64::from);
    // The decoder takes a copy of the file besides.
    let beside = width * height * COEFFICIENTS + bytes.len() as u64;
    let problem = |error| of_decoder(ImageFormat::Jpeg, error);
    let mut samples = room(frame.resolution, 3, beside)?;
    let mut decoder = JpegDecoder::new(Cursor::new(bytes)).map_err(problem)?;
    let resolution = <[u32; 2]>::from(decoder.dimensions());
    let channels = match decoder.color_type() {
        ColorType::L8 => Channels::Gray,
        ColorType::Rgb8 => Channels::Rgb,
        other => return Err(unsupported(ImageFormat::Jpeg, &format!("{other:?}"))),
    };
    if resolution != frame.resolution {
        return Err(damaged("it has two sizes"));
    }
    let orientation = decoder.orientation().map_err(problem)?;
    let mut warnings = Vec::new();
    if frame.has_profile {
        warnings.push(super::problem::PROFILE.to_owned());
    }
    if frame.components == 4 {
        warnings.push(
            "its colors are those of inks, CMYK; they are converted without a profile".to_owned(),
        );
    }
    let layout = Layout {
        depth: Depth::Eight,
        channels,
        is_premultiplied: false,
        coding: Coding::SRGB,
    };
    samples.truncate(width as usize * height as usize * layout.pixel_bytes());
    decoder.read_image(&mut samples).map_err(problem)?;
    let mut pixels = layout.pixels(&samples)?;
    let resolution = upright(&mut pixels, resolution, orientation)?;
    Ok(Decoded {
        resolution,
        pixels,
        has_alpha: false,
        primaries: layout.coding.primaries,
        pixel_aspect: 1.0,
        warnings,
    })
}

/// What the segments of a file say (ITU-T T.81, annex B).
#[derive(Debug, PartialEq, Eq)]
struct Frame {
    resolution: [u32; 2],
    precision: u8,
    components: u8,
    has_profile: bool,
}

impl Frame {
    /// Goes through all segments up to the end of the image: decoders fill with gray what is missing of a file that was
    /// cut off.
    fn of(bytes: &[u8]) -> Result<Self, ImageFileProblem> {
        let early = || damaged(TOO_EARLY);
        let mut frame = None;
        let mut has_profile = false;
        // Behind the first marker, SOI.
        let mut place = 2;
        loop {
            // Any number of 0xff may stand before a marker.
            if *bytes.get(place).ok_or_else(early)? != 0xff {
                return Err(damaged("a segment does not end where it should"));
            }
            while *bytes.get(place).ok_or_else(early)? == 0xff {
                place += 1;
            }
            let marker = bytes[place];
            place += 1;
            // The end; and what has no length: RSTn, TEM.
            if marker == 0xd9 {
                break;
            }
            if matches!(marker, 0xd0..=0xd7 | 0x01) {
                continue;
            }
            let [high, low, content @ ..] = bytes.get(place..).unwrap_or_default() else {
                return Err(early());
            };
            let length = usize::from(u16::from_be_bytes([*high, *low]));
            let content = content.get(..length.saturating_sub(2)).ok_or_else(early)?;
            place += length.max(2);
            match marker {
                // SOFn, but not DHT, JPG and DAC amid them.
                0xc0..=0xc3 | 0xc5..=0xc7 | 0xc9..=0xcb | 0xcd..=0xcf => {
                    let [precision, y1, y0, x1, x0, components, ..] = *content else {
                        return Err(damaged("its frame header is too short"));
                    };
                    let side = |high, low| u32::from(u16::from_be_bytes([high, low]));
                    frame = frame.or(Some(([side(x1, x0), side(y1, y0)], precision, components)));
                }
                0xe2 => has_profile |= content.starts_with(b"ICC_PROFILE\0"),
                // Of a scan: its data goes on to the next marker.
                0xda => {
                    let data = &bytes[place..];
                    let end = data.windows(2).position(|pair| {
                        pair[0] == 0xff && !matches!(pair[1], 0 | 0xff | 0xd0..=0xd7)
                    });
                    place += end.ok_or_else(early)?;
                }
                _ => {}
            }
        }
        let (resolution, precision, components) =
            frame.ok_or_else(|| damaged("it has no frame header"))?;
        Ok(Self {
            resolution,
            precision,
            components,
            has_profile,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::image::codecs::jpeg::JpegEncoder;

    #[test]
    fn segments_are_found_up_to_the_end() {
        let mut bytes = Vec::new();
        let encoder = JpegEncoder::new_with_quality(&mut bytes, 90);
        let pixels: Vec<u8> = (0..30 * 20 * 3).map(|i| (i * 7) as u8).collect();
        ::image::ImageEncoder::write_image(
            encoder,
            &pixels,
            30,
            20,
            ::image::ExtendedColorType::Rgb8,
        )
        .unwrap();
        let frame = Frame {
            resolution: [30, 20],
            precision: 8,
            components: 3,
            has_profile: false,
        };
        assert_eq!(Frame::of(&bytes).unwrap(), frame);
        for end in 3..bytes.len() {
            let problem = Frame::of(&bytes[..end]).unwrap_err();
            assert!(matches!(problem, ImageFileProblem::Damaged(_)), "{end}");
        }
    }
}
