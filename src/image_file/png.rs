//! PNG: 1 to 16 bits, gray, color or palette, with alpha or without; of an animation the first picture.
//!
//! What counts of what it says about its colors is cICP, then iCCP, sRGB, and gAMA with cHRM, as the third edition of
//! the specification has it (W3C 2025, section 4.3).

use std::io::Cursor;

use ::png::{BitDepth, ColorType, Decoder, DecodingError, Info, Limits, Transformations, Unit};

use super::coding::{Coding, Curve, curve_of, primaries_of};
use super::problem::{ImageFileProblem, TOO_EARLY, damaged, of_memory, unsupported};
use super::samples::{Channels, Depth, Layout};
use super::{Decoded, ImageFormat, check_size, room};
use crate::color::Primaries;

/// Bytes of memory for chunks beside the pixels.
const BESIDE: usize = 1 << 24;

/// Bytes of a row that the decoder keeps for each of its own: the row, the one before, and what is inflated ahead.
const ROWS: u64 = 8;

/// The most bytes of a pixel in the file.
const PIXEL: u64 = 8;

pub(super) fn decode(bytes: &[u8]) -> Result<Decoded, ImageFileProblem> {
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: BESIDE });
    decoder.set_ignore_text_chunk(true);
    // Whether it is there is enough, and it may unpack to a lot.
    decoder.set_ignore_iccp_chunk(true);
    // Palettes become colors, few bits 8, and a color that is transparent alpha.
    decoder.set_transformations(Transformations::EXPAND);
    let header = decoder.read_header_info().map_err(problem)?;
    let resolution = [header.width, header.height];
    check_size(resolution, bytes.len())?;
    crate::memory::look_for(u64::from(header.width) * PIXEL * ROWS)
        .map_err(|error| error.for_what("rows of the picture"))?;
    let mut reader = decoder.read_info().map_err(problem)?;
    let mut warnings = Vec::new();
    let coding = coding(reader.info(), has_profile(bytes), &mut warnings);
    let (color, depth) = reader.output_color_type();
    let channels = match color {
        ColorType::Grayscale => Channels::Gray,
        ColorType::GrayscaleAlpha => Channels::GrayAlpha,
        ColorType::Rgb => Channels::Rgb,
        ColorType::Rgba => Channels::Rgba,
        ColorType::Indexed => return Err(damaged("its palette is missing")),
    };
    let depth = match depth {
        BitDepth::Eight => Depth::Eight,
        BitDepth::Sixteen => Depth::Sixteen,
        BitDepth::One | BitDepth::Two | BitDepth::Four => {
            return Err(unsupported(ImageFormat::Png, "samples of few bits"));
        }
    };
    let layout = Layout {
        depth,
        channels,
        is_premultiplied: false,
        coding,
    };
    let mut samples = room(resolution, layout.pixel_bytes(), 0)?;
    reader.next_frame(&mut samples).map_err(problem)?;
    if depth == Depth::Sixteen {
        let (pairs, _) = samples.as_chunks_mut::<2>();
        for pair in pairs {
            *pair = u16::from_be_bytes(*pair).to_ne_bytes();
        }
    }
    Ok(Decoded {
        resolution,
        pixels: layout.pixels(&samples)?,
        has_alpha: channels.has_alpha(),
        primaries: coding.primaries,
        pixel_aspect: pixel_aspect(reader.info()),
        warnings,
    })
}

fn problem(error: DecodingError) -> ImageFileProblem {
    match error {
        DecodingError::IoError(error) => of_memory(&error),
        DecodingError::Format(error) => {
            let said = error.to_string();
            damaged(if said.contains("unexpected end") {
                TOO_EARLY
            } else {
                &said
            })
        }
        DecodingError::Parameter(error) => damaged(&error.to_string()),
        DecodingError::LimitsExceeded => unsupported(
            ImageFormat::Png,
            "a chunk beside its pixels is larger than 16 MB",
        ),
    }
}

/// Whether there is an ICC profile, a chunk iCCP before the pixels.
fn has_profile(bytes: &[u8]) -> bool {
    let mut rest = bytes.get(8..).unwrap_or_default();
    while let [a, b, c, d, name @ ..] = rest {
        let length = u32::from_be_bytes([*a, *b, *c, *d]) as usize;
        match name.get(..4) {
            Some(b"iCCP") => return true,
            Some(b"IDAT") | None => return false,
            Some(_) => {}
        }
        // Its name, and the checksum behind it.
        rest = name.get(length.saturating_add(8)..).unwrap_or_default();
    }
    false
}

/// What its code values mean.
fn coding(info: &Info<'_>, has_profile: bool, warnings: &mut Vec<String>) -> Coding {
    if let Some(points) = info.coding_independent_code_points {
        let (primaries, transfer) = (points.color_primaries, points.transfer_function);
        let known = (primaries_of(primaries), curve_of(transfer));
        if known.0.is_none() || known.1.is_none() {
            warnings.push(format!(
                "its color space, primaries {primaries} and transfer {transfer} of ITU-T H.273, is not known; \
                 what is not known of it is taken for that of sRGB"
            ));
        }
        return Coding {
            curve: known.1.unwrap_or(Curve::Srgb),
            primaries: known.0.unwrap_or(Primaries::REC709),
            is_narrow: !points.is_video_full_range_image,
        };
    }
    if has_profile {
        warnings.push(super::problem::PROFILE.to_owned());
        return Coding::SRGB;
    }
    if info.srgb.is_some() {
        return Coding::SRGB;
    }
    let mut coding = Coding::SRGB;
    if let Some(gamma) = info.gama_chunk {
        // The exponent from light to code values, in hundred thousandths.
        let gamma = f64::from(gamma.into_scaled()) / 1e5;
        if (0.1..=10.0).contains(&gamma) {
            coding.curve = if gamma == 1.0 {
                Curve::Linear
            } else {
                Curve::Power(1.0 / gamma)
            };
        } else {
            warnings.push(format!(
                "its gamma, {gamma}, is none that a picture has; it is shown as sRGB"
            ));
        }
    }
    if let Some(chromaticities) = info.chrm_chunk {
        let place = |(x, y): (::png::ScaledFloat, ::png::ScaledFloat)| {
            [x, y].map(|value| f64::from(value.into_scaled()) / 1e5)
        };
        coding.primaries = Primaries {
            red: place(chromaticities.red),
            green: place(chromaticities.green),
            blue: place(chromaticities.blue),
            white: place(chromaticities.white),
        };
    }
    coding
}

fn pixel_aspect(info: &Info<'_>) -> f32 {
    match info.pixel_dims {
        Some(dimensions) if dimensions.xppu > 0 && dimensions.yppu > 0 => {
            match dimensions.unit {
                // The more of them there are to a length, the narrower they are.
                Unit::Unspecified | Unit::Meter => {
                    (f64::from(dimensions.yppu) / f64::from(dimensions.xppu)) as f32
                }
            }
        }
        Some(_) | None => 1.0,
    }
}
