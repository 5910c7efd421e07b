//! Pictures that are no OpenEXR files: PNG, JPEG, TIFF, Radiance HDR.

use std::fs;
use std::io::Cursor;

use candela::display::{Bits, Exposure, Settings, View, convert};
use candela::internal::srgb_decode;
use candela::output::Unfinished;
use image::codecs::hdr::HdrEncoder;
use image::codecs::jpeg::JpegEncoder;
use image::codecs::tiff::TiffEncoder;
use image::{ExtendedColorType, ImageEncoder, Rgb};
use png::{BitDepth, ColorType};

use super::{NEAREST, Shown, assert_pixels, shown};

/// A PNG of these samples, after `more` is done to its encoder and chunks are written.
fn png_of(
    [width, height]: [u32; 2],
    color: ColorType,
    depth: BitDepth,
    samples: &[u8],
    more: impl FnOnce(&mut png::Encoder<'_, &mut Vec<u8>>),
    chunks: &[(&[u8; 4], &[u8])],
) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(color);
    encoder.set_depth(depth);
    more(&mut encoder);
    let mut writer = encoder.write_header().unwrap();
    for (name, content) in chunks {
        writer
            .write_chunk(png::chunk::ChunkType(**name), content)
            .unwrap();
    }
    writer.write_image_data(samples).unwrap();
    writer.finish().unwrap();
    bytes
}

/// Codes that are not too regular, of all sizes.
fn codes(count: usize) -> Vec<u8> {
    (0..count).map(|i| (i * i * 7 + i * 31) as u8).collect()
}

/// What is made of a file's bytes, whatever it is called.
fn shown_of(bytes: &[u8], settings: &Settings) -> Result<Shown, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.exr");
    fs::write(&path, bytes).unwrap();
    shown(&path, None, settings)
}

fn flat(shown: &Shown) -> Vec<u8> {
    shown.pixels.concat()
}

const SIZE: [u32; 2] = [13, 7];
const COUNT: usize = 13 * 7;

/// sRGB to light and back, at EV 0: each code becomes itself.
#[test]
fn codes_come_back() {
    let sixteen = Settings {
        bits: Bits::Sixteen,
        ..NEAREST
    };
    let samples = codes(COUNT * 6);
    let wide = samples
        .as_chunks::<2>()
        .0
        .iter()
        .map(|&pair| u16::from_be_bytes(pair));
    let wide: Vec<u8> = wide.flat_map(u16::to_ne_bytes).collect();
    let png = |depth, samples: &[u8]| png_of(SIZE, ColorType::Rgb, depth, samples, |_| (), &[]);
    let tiff = |color, samples: &[u8]| {
        let mut bytes = Cursor::new(Vec::new());
        let encoder = TiffEncoder::new(&mut bytes);
        encoder
            .write_image(samples, SIZE[0], SIZE[1], color)
            .unwrap();
        bytes.into_inner()
    };
    for file in [
        png(BitDepth::Eight, &samples[..COUNT * 3]),
        tiff(ExtendedColorType::Rgb8, &samples[..COUNT * 3]),
    ] {
        let shown = shown_of(&file, &NEAREST).unwrap();
        assert_eq!(flat(&shown), samples[..COUNT * 3]);
        assert_eq!(shown.report.warnings, [""; 0]);
    }
    for file in [
        png(BitDepth::Sixteen, &samples),
        tiff(ExtendedColorType::Rgb16, &wide),
    ] {
        assert_eq!(flat(&shown_of(&file, &sixteen).unwrap()), samples);
    }
}

/// Grays, palettes, few bits, and a color that is transparent.
#[test]
fn every_kind_of_png_is_read() {
    let eight = codes(COUNT);
    let gray = png_of(
        SIZE,
        ColorType::Grayscale,
        BitDepth::Eight,
        &eight,
        |_| (),
        &[],
    );
    let expected: Vec<u8> = eight.iter().flat_map(|&code| [code; 3]).collect();
    assert_eq!(flat(&shown_of(&gray, &NEAREST).unwrap()), expected);

    // Two pixels to a byte: 0x1 and 0xe are the sixteenths 17 and 238 of 255.
    let few = png_of(
        [2, 1],
        ColorType::Grayscale,
        BitDepth::Four,
        &[0x1e],
        |_| (),
        &[],
    );
    assert_eq!(
        flat(&shown_of(&few, &NEAREST).unwrap()),
        [17, 17, 17, 238, 238, 238]
    );

    let palette = [10, 20, 30, 200, 100, 50];
    let indexed =
        |encoder: &mut png::Encoder<'_, &mut Vec<u8>>| encoder.set_palette(palette.to_vec());
    let indexed = png_of(
        [8, 1],
        ColorType::Indexed,
        BitDepth::One,
        &[0b0110_0000],
        indexed,
        &[],
    );
    let shown_pixels = shown_of(&indexed, &NEAREST).unwrap().pixels;
    assert_eq!(
        shown_pixels[..3],
        [[10, 20, 30], [200, 100, 50], [200, 100, 50]]
    );

    let with_alpha = [50, 100, 150, 255, 250, 200, 150, 51, 9, 8, 7, 0];
    let rgba = png_of(
        [3, 1],
        ColorType::Rgba,
        BitDepth::Eight,
        &with_alpha,
        |_| (),
        &[],
    );
    let expected = [50, 100, 150, 255, 250, 200, 150, 51, 0, 0, 0, 0];
    assert_eq!(flat(&shown_of(&rgba, &NEAREST).unwrap()), expected);

    let keyed = |encoder: &mut png::Encoder<'_, &mut Vec<u8>>| encoder.set_trns(&[0, 7][..]);
    let keyed = png_of(
        [2, 1],
        ColorType::Grayscale,
        BitDepth::Eight,
        &[7, 8],
        keyed,
        &[],
    );
    assert_eq!(
        flat(&shown_of(&keyed, &NEAREST).unwrap()),
        [0, 0, 0, 0, 8, 8, 8, 255]
    );
}

/// What a PNG says about its colors, in the order in which it counts.
#[test]
fn colors_of_a_png_are_heeded() {
    let of = |samples: [u8; 3], chunks: &[(&[u8; 4], &[u8])]| {
        let png = png_of(
            [1, 1],
            ColorType::Rgb,
            BitDepth::Eight,
            &samples,
            |_| (),
            chunks,
        );
        shown_of(&png, &NEAREST).unwrap()
    };
    let half = [128; 3];
    let code = |light: f64| {
        let coded = 1.055 * light.powf(1.0 / 2.4) - 0.055;
        [(255.0 * coded).round() as u8; 3]
    };
    let linear = code(128.0 / 255.0);
    let gamma_of_one = 100_000_u32.to_be_bytes();
    let srgb: (&[u8; 4], &[u8]) = (b"sRGB", &[0]);
    let gamma: (&[u8; 4], &[u8]) = (b"gAMA", &gamma_of_one);
    let profile: (&[u8; 4], &[u8]) = (b"iCCP", b"p\0\0\x78\x9c\x03\0\0\0\0\x01");
    let linear_points: (&[u8; 4], &[u8]) = (b"cICP", &[1, 8, 0, 1]);
    for (chunks, expected, warnings) in [
        (&[][..], half, 0),
        (&[gamma], linear, 0),
        (&[srgb, gamma], half, 0),
        (&[gamma, profile], half, 1),
        (&[linear_points, srgb], linear, 0),
        (&[linear_points, profile], linear, 0),
        (
            &[(b"cICP", &[1, 1, 0, 1])],
            code((128.0_f64 / 255.0).powf(2.4)),
            0,
        ),
        (&[(b"cICP", &[1, 13, 0, 0])], [130; 3], 0), // (128 − 16) · 255/219
        (&[(b"cICP", &[1, 99, 0, 1])], half, 1),
        (&[(b"cICP", &[99, 13, 0, 1])], half, 1),
    ] {
        let shown = of(half, chunks);
        assert_pixels(&shown, &[expected]);
        assert_eq!(shown.report.warnings.len(), warnings, "{chunks:?}");
    }
    // P3's red is outside of Rec.709; its green by the published matrix, coded: −0.225 0.949 −0.079 of (0, 0.9, 0)…
    let p3 = |samples| flat(&of(samples, &[(b"cICP", &[12, 13, 0, 1])]));
    assert_eq!(p3([255, 255, 255]), [255, 255, 255]);
    // Against colour-science 0.4.7: (200, 150, 100) of Display P3 is (209.18, 147.42, 91.02) of sRGB.
    assert_pixels(
        &of([200, 150, 100], &[(b"cICP", &[12, 13, 0, 1])]),
        &[[209, 147, 91]],
    );
    // The same by cHRM.
    let values = [
        31_270, 32_900, 68_000, 32_000, 26_500, 69_000, 15_000, 6000_u32,
    ];
    let chromaticities: Vec<u8> = values
        .iter()
        .flat_map(|value| value.to_be_bytes())
        .collect();
    assert_eq!(
        flat(&of([200, 150, 100], &[(b"cHRM", &chromaticities)])),
        p3([200, 150, 100])
    );
    // PQ's 58 % and HLG's 75 % are diffuse white (ITU-R BT.2408-7, table 1).
    assert_pixels(&of([148; 3], &[(b"cICP", &[9, 16, 0, 1])]), &[[254; 3]]);
    assert_pixels(&of([191; 3], &[(b"cICP", &[9, 18, 0, 1])]), &[[254; 3]]);
}

#[test]
fn pixels_of_a_png_that_are_not_square_stay_so() {
    let chunk: (&[u8; 4], &[u8]) = (b"pHYs", &[0, 0, 0, 1, 0, 0, 0, 2, 0]);
    let png = png_of(
        [1, 1],
        ColorType::Rgb,
        BitDepth::Eight,
        &[1, 2, 3],
        |_| (),
        &[chunk],
    );
    let shown = shown_of(&png, &NEAREST).unwrap();
    assert_eq!(shown.dimensions, Some([1_000_000, 2_000_000]));
    assert_eq!(shown.report.warnings.len(), 1);
}

/// Against the decoder of another crate's face.
#[test]
fn jpeg_is_srgb() {
    let [width, height] = SIZE;
    let smooth: Vec<u8> = (0..COUNT * 3)
        .map(|i| (i * 2 / 3 + i % 3 * 20) as u8)
        .collect();
    let mut jpeg = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut jpeg, 95);
    encoder
        .write_image(&smooth, width, height, ExtendedColorType::Rgb8)
        .unwrap();
    let theirs = image::load_from_memory(&jpeg).unwrap().to_rgb8();
    assert_eq!(flat(&shown_of(&jpeg, &NEAREST).unwrap()), *theirs.as_raw());
    let mut gray = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut gray, 95);
    encoder
        .write_image(&smooth[..COUNT], width, height, ExtendedColorType::L8)
        .unwrap();
    let theirs = image::load_from_memory(&gray).unwrap().to_rgb8();
    assert_eq!(flat(&shown_of(&gray, &NEAREST).unwrap()), *theirs.as_raw());
}

/// Floats of a TIFF and numbers of an HDR are light, whatever their size.
#[test]
fn floats_are_light() {
    let light: Vec<Rgb<f32>> = (0..COUNT)
        .map(|i| Rgb([1.0, 0.25, 0.0078125].map(|v| v * (i % 16) as f32)))
        .collect();
    let samples: Vec<u8> = light
        .iter()
        .flat_map(|pixel| pixel.0)
        .flat_map(f32::to_ne_bytes)
        .collect();
    let mut tiff = Cursor::new(Vec::new());
    let encoder = TiffEncoder::new(&mut tiff);
    encoder
        .write_image(&samples, SIZE[0], SIZE[1], ExtendedColorType::Rgb32F)
        .unwrap();
    let mut hdr = Vec::new();
    let [width, height] = SIZE.map(|side| side as usize);
    HdrEncoder::new(&mut hdr)
        .encode(&light, width, height)
        .unwrap();
    // White is at 16 once.
    let settings = Settings {
        exposure: Exposure::Ev(-4.0),
        view: View::Srgb,
        ..NEAREST
    };
    let expected: Vec<[u8; 3]> = light
        .iter()
        .map(|pixel| {
            pixel.0.map(|v| {
                let light = f64::from(v) / 16.0;
                let coded = if light <= 0.003_130_8 {
                    12.92 * light
                } else {
                    1.055 * light.powf(1.0 / 2.4) - 0.055
                };
                (coded * 255.0).round() as u8
            })
        })
        .collect();
    let of_tiff = shown_of(tiff.get_ref(), &settings).unwrap();
    assert_eq!(of_tiff.pixels, expected);
    // Mantissas of 8 bits, of the largest channel's power of two: a step of it is 1/128 of the largest at most.
    let of_hdr = shown_of(&hdr, &settings).unwrap();
    for (found, expected) in of_hdr.pixels.iter().zip(&expected) {
        let light = |code: u8| srgb_decode(f64::from(code) / 255.0);
        let step = light(*expected.iter().max().unwrap()) / 128.0;
        for (&found, &expected) in found.iter().zip(expected) {
            let [least, most] = [-1.0, 1.0]
                .map(|sign| light(expected.saturating_add_signed(sign as i8)) + sign * step);
            assert!(
                (least..=most).contains(&light(found)),
                "{found}, not {expected}"
            );
        }
    }
}

/// Files of each format, as they are cut off and damaged below.
fn files() -> [(&'static str, Vec<u8>); 5] {
    let [width, height] = SIZE;
    let samples = codes(COUNT * 3);
    let png = png_of(
        SIZE,
        ColorType::Rgb,
        BitDepth::Eight,
        &samples,
        |_| (),
        &[(b"sRGB", &[0])],
    );
    let mut jpeg = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut jpeg, 90);
    encoder
        .write_image(&samples, width, height, ExtendedColorType::Rgb8)
        .unwrap();
    let mut tiff = Cursor::new(Vec::new());
    let encoder = TiffEncoder::new(&mut tiff);
    encoder
        .write_image(&samples, width, height, ExtendedColorType::Rgb8)
        .unwrap();
    let light: Vec<Rgb<f32>> = samples
        .as_chunks::<3>()
        .0
        .iter()
        .map(|&rgb| Rgb(rgb.map(f32::from)))
        .collect();
    let mut hdr = Vec::new();
    HdrEncoder::new(&mut hdr)
        .encode(&light, width as usize, height as usize)
        .unwrap();
    let mut old = b"#?RGBE\nFORMAT=32-bit_rle_rgbe\n\n-Y 7 +X 13\n".to_vec();
    for _ in 0..7 {
        // A pixel, and runs of it: 11, and one.
        old.extend([9, 8, 7, 128, 1, 1, 1, 11, 3, 4, 5, 128]);
    }
    [
        ("PNG", png),
        ("JPEG", jpeg),
        ("TIFF", tiff.into_inner()),
        ("HDR", hdr),
        ("old HDR", old),
    ]
}

/// Whatever of a file is missing is an error with its name, and the picture that was there stays.
#[test]
fn files_that_end_too_early_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("in"), folder.path().join("out.png"));
    fs::write(&output, "old").unwrap();
    for (format, whole) in files() {
        // The last chunk of a PNG says nothing.
        let end = whole.len() - if format == "PNG" { 12 } else { 0 };
        for length in 0..end {
            // A directory at the end of a TIFF is first looked for there.
            fs::write(&input, &whole[..length]).unwrap();
            let error = convert(&input, &output, &NEAREST, &Unfinished::new()).unwrap_err();
            let message = error.to_string();
            let name = format!("cannot read {}: ", input.display());
            assert!(message.starts_with(&name), "{format} {length}: {message}");
            if length >= 8 {
                let says_so = message.contains("damaged or incomplete")
                    || message.contains("too many for the data");
                assert!(says_so, "{format} {length}: {message}");
            }
            assert_eq!(fs::read(&output).unwrap(), b"old");
        }
        fs::write(&input, &whole).unwrap();
        convert(
            &input,
            &folder.path().join("new.png"),
            &NEAREST,
            &Unfinished::new(),
        )
        .unwrap();
    }
}

/// Damaged copies of each file; hundreds of thousands of them were tried when this was written.
const DAMAGED_COPIES: usize = 400;

#[test]
fn damaged_pictures_give_a_picture_or_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let (input, output) = (folder.path().join("in"), folder.path().join("out.png"));
    let mut state = 1_u64;
    let mut random = |below: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let copies = std::env::var("CANDELA_FUZZ")
        .ok()
        .and_then(|said| said.parse().ok());
    let (mut pictures, mut errors) = (0, 0);
    for (format, whole) in files() {
        for _ in 0..copies.unwrap_or(DAMAGED_COPIES) {
            let mut copy = whole.clone();
            for _ in 0..1 + random(4) {
                let place = 2 + random(copy.len() - 2);
                copy[place] = [0, 1, 0x7f, 0x80, 0xff, random(256) as u8][random(6)];
            }
            fs::write(&input, &copy).unwrap();
            match convert(&input, &output, &NEAREST, &Unfinished::new()) {
                Ok(_) => pictures += 1,
                Err(error) => {
                    errors += 1;
                    let message = error.to_string();
                    assert!(message.lines().count() == 1, "{format}: {message}");
                }
            }
        }
    }
    assert!(pictures > 100 && errors > 100, "{pictures} {errors}");
}

/// Nothing of a claimed size is asked for: these would be terabytes.
#[test]
fn sizes_are_not_believed() {
    let mut png = files()[0].1.clone();
    png[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
    // The checksum of IHDR, which is over its name and content.
    let sum = !png[12..29].iter().fold(!0_u32, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| {
            if sum & 1 == 1 {
                sum >> 1 ^ 0xedb8_8320
            } else {
                sum >> 1
            }
        })
    });
    png[29..33].copy_from_slice(&sum.to_be_bytes());
    let hdr = b"#?RADIANCE\n\n-Y 2000000000 +X 2000000000\n".to_vec();
    let mut jpeg = files()[1].1.clone();
    let frame = jpeg
        .windows(2)
        .position(|pair| pair == [0xff, 0xc0])
        .unwrap();
    jpeg[frame + 5..frame + 9].fill(0xff);
    for file in [png, hdr, jpeg] {
        let message = shown_of(&file, &NEAREST).map(|_| ()).unwrap_err();
        assert!(
            message.contains("pixels are too many for the data in it"),
            "{message}"
        );
    }
}

#[test]
fn layers_are_of_openexr_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    fs::write(&path, &files()[0].1).unwrap();
    let message = shown(&path, Some("light_key"), &NEAREST)
        .map(|_| ())
        .unwrap_err();
    assert_eq!(
        message,
        format!(
            "cannot read {}: it is a PNG, which has no layers; leave --layer away",
            path.display()
        )
    );
}
