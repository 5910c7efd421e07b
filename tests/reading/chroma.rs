//! Luminance with chroma, and other channels with fewer samples than pixels.

use candela::exr::read;
use exr::meta::BlockDescription;
use exr::meta::attribute::{ChannelDescription, Compression, IntegerBounds, SampleType, Text};
use exr::meta::header::Header;
use exr::prelude::Vec2;

use crate::measured::Measured;

use super::file::{Channel, Part, bytes, channel, row, write};

/// The windowed sinc of ImfRgbaYca.cpp at 1, 3, … 13 pixels.
const FILTER: [f32; 7] = [
    0.627_123, -0.186_077, 0.087_929, -0.043_159, 0.019_597, -0.007_540, 0.002_128,
];

/// The luminance weights of Rec.709.
const WEIGHTS: [f32; 3] = [0.212_639, 0.715_168_7, 0.072_192_3];

/// Errors of about 1, of a few operations in f32: R, G and B, which share two sums over 14 samples; how saturated
/// a pixel is, and its luminance.
const CHROMA: f64 = 1.91e-6;
const LIMITED: f64 = 1.19e-7;

fn sampled(name: &str, value: impl Fn(i32, i32) -> f32 + 'static) -> Channel {
    Channel {
        sampling: 2,
        ..channel(name, value)
    }
}

/// Y, RY, BY and A of a picture `side` pixels wide and high that starts at (−2, 4).
fn part(
    side: i32,
    y: impl Fn(i32, i32) -> f32 + 'static,
    ry: impl Fn(i32, i32) -> f32 + 'static,
    by: impl Fn(i32, i32) -> f32 + 'static,
) -> Part {
    let channels = vec![
        channel("A", |_, _| 0.5),
        sampled("BY", by),
        sampled("RY", ry),
        channel("Y", y),
    ];
    let window = [-2, 4, side - 3, side + 3];
    Part {
        data: window,
        display: window,
        ..row(side, channels)
    }
}

/// R, G, B, A of a pixel by Y, RY, BY.
fn expected(y: f32, ry: f32, by: f32) -> [f32; 4] {
    let (r, b) = ((ry + 1.0) * y, (by + 1.0) * y);
    [
        r,
        (y - WEIGHTS[0] * r - WEIGHTS[2] * b) / WEIGHTS[1],
        b,
        0.5,
    ]
}

fn see(worst: &mut Measured, found: [f32; 4], expected: [f32; 4]) {
    for (a, b) in found.iter().zip(expected) {
        worst.see(f64::from((a - b).abs()), || {
            format!("{found:?}, not {expected:?}")
        });
    }
}

#[test]
fn even_chroma_is_the_same_everywhere() {
    let mut worst = Measured::new("even_chroma", CHROMA);
    let folder = tempfile::tempdir().unwrap();
    let luminance = |x: i32, y: i32| 0.1 + 0.01 * (x + 2 * y) as f32;
    let path = write(
        folder.path(),
        &[part(40, luminance, |_, _| 0.3, |_, _| -0.2)],
    );
    let image = read(&path).unwrap();
    assert!(image.has_alpha);
    for (place, &pixel) in image.pixels.iter().enumerate() {
        let (x, y) = (place as i32 % 40 - 2, place as i32 / 40 + 4);
        let y = luminance(x, y);
        see(&mut worst, pixel, expected(y, 0.3, -0.2));
    }
    worst.judge();
}

#[test]
fn grays_come_back_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let luminance = |x: i32, y: i32| ((x * 7 + y * 13) as f32).sin().abs();
    let path = write(
        folder.path(),
        &[part(36, luminance, |_, _| 0.0, |_, _| 0.0)],
    );
    let image = read(&path).unwrap();
    for (place, &pixel) in image.pixels.iter().enumerate() {
        let y = luminance(place as i32 % 36 - 2, place as i32 / 36 + 4);
        assert_eq!(pixel, [y, y, y, 0.5]);
    }
}

/// One sample of chroma spreads as the filter's weights along its row and its column; so little of it
/// that no pixel is too saturated.
#[test]
fn chroma_between_samples_is_that_of_the_filter() {
    let mut worst = Measured::new("chroma_between_samples", CHROMA);
    let folder = tempfile::tempdir().unwrap();
    let red = |x: i32, y: i32| if (x, y) == (18, 24) { 0.001 } else { 0.0 };
    let path = write(folder.path(), &[part(40, |_, _| 1.0, red, |_, _| 0.5)]);
    let image = read(&path).unwrap();
    let weight = |distance: i32| match distance.unsigned_abs() {
        0 => 1.0,
        odd if odd % 2 == 1 => FILTER.get(odd as usize / 2).copied().unwrap_or(0.0),
        _ => 0.0,
    };
    for (place, &pixel) in image.pixels.iter().enumerate() {
        let (x, y) = (place as i32 % 40 - 2, place as i32 / 40 + 4);
        let red = 0.001 * weight(x - 18) * weight(y - 24);
        see(&mut worst, pixel, expected(1.0, red, 0.5));
    }
    worst.judge();
}

/// A pixel much more saturated than its four corners keeps three quarters of the way from full
/// saturation to their mean, and all of its luminance.
#[test]
fn excessive_saturation_is_limited() {
    let folder = tempfile::tempdir().unwrap();
    let red = |x: i32, y: i32| if (x, y) == (12, 12) { 3.0 } else { 0.0 };
    let path = write(folder.path(), &[part(40, |_, _| 1.0, red, |_, _| 0.0)]);
    let saturation = |[r, g, b, _]: [f32; 4]| 1.0 - r.min(g).min(b) / r.max(g).max(b);
    let corner = saturation(expected(1.0, 3.0 * FILTER[0] * FILTER[0], 0.0));
    let limit = 1.0 - (1.0 - corner) / 4.0;
    assert!(limit < saturation(expected(1.0, 3.0, 0.0)));
    let pixels = read(&path).unwrap().pixels;
    let found = saturation(pixels[(12 - 4) * 40 + 12 + 2]);
    let mut worst = Measured::new("limited saturation", LIMITED);
    worst.see(f64::from((found - limit).abs()), || "saturation".to_owned());
    for [r, g, b, _] in pixels {
        let luminance = WEIGHTS[0] * r + WEIGHTS[1] * g + WEIGHTS[2] * b;
        worst.see(f64::from((luminance - 1.0).abs()), || {
            "luminance".to_owned()
        });
    }
    worst.judge();
}

#[test]
fn fewer_samples_of_a_color_are_repeated() {
    let folder = tempfile::tempdir().unwrap();
    let value = |x: i32, y: i32| (x + 10 * y) as f32;
    let channels = vec![
        sampled("B", value),
        channel("G", value),
        channel("R", value),
    ];
    let window = [0, 0, 5, 3];
    let part = Part {
        data: window,
        display: window,
        ..row(6, channels)
    };
    let image = read(&write(folder.path(), &[part])).unwrap();
    for (place, &[r, g, b, a]) in image.pixels.iter().enumerate() {
        let (x, y) = (place as i32 % 6, place as i32 / 6);
        let stored = value(x, y);
        assert_eq!(
            [r, g, b, a],
            [stored, stored, value(x / 2 * 2, y / 2 * 2), 1.0]
        );
    }
    // A window that the sampling does not divide is not legal.
    let part = Part {
        data: [0, 0, 4, 3],
        ..row(6, vec![sampled("Y", value)])
    };
    let error = read(&write(folder.path(), &[part]))
        .unwrap_err()
        .to_string();
    assert!(error.contains("a sampling that does not fit"), "{error}");
}

/// The same picture in blocks of 16 and 32 lines, packed by the codecs of the `exr` crate.
#[test]
fn chroma_in_every_lossless_compression() {
    let folder = tempfile::tempdir().unwrap();
    let y = |x: i32, y: i32| 0.5 + 0.4 * ((x * y) as f32 / 50.0).sin();
    let red = |x: i32, y: i32| 0.2 * ((x + y) as f32 / 9.0).sin();
    let plain = || part(40, y, red, |x, _| 0.01 * x as f32);
    let expected = read(&write(folder.path(), &[plain()])).unwrap().pixels;
    for (number, compression) in [
        (1, Compression::RLE),
        (2, Compression::ZIP1),
        (3, Compression::ZIP16),
        (4, Compression::PIZ),
    ] {
        let path = folder.path().join("packed.exr");
        std::fs::write(&path, packed(&plain(), number, compression)).unwrap();
        assert_eq!(read(&path).unwrap().pixels, expected, "{compression}");
    }
}

/// A file of one part in a compression of the `exr` crate.
fn packed(part: &Part, number: u8, compression: Compression) -> Vec<u8> {
    let plain = bytes(std::slice::from_ref(part));
    let [left, top, right, bottom] = part.data;
    let (width, height) = (right - left + 1, bottom - top + 1);
    let lines = compression.scan_lines_per_block() as i32;
    let start = u64::from_le_bytes(first_offset(&plain, height)) as usize;
    let mut head = plain[..start - 8 * height as usize].to_vec();
    let name = b"compression\0compression\0\x01\0\0\0";
    let place = head.windows(name.len()).position(|bytes| bytes == name);
    head[place.unwrap() + name.len()] = number;

    // Lines of the plain file, without their coordinates and lengths.
    let mut rest = &plain[start..];
    let mut raw_lines = Vec::new();
    while !rest.is_empty() {
        let length = i32::from_le_bytes(rest[4..8].try_into().unwrap()) as usize;
        raw_lines.push(rest[8..8 + length].to_vec());
        rest = &rest[8 + length..];
    }
    let description = |channel: &Channel| ChannelDescription {
        name: Text::from(std::str::from_utf8(&channel.name).unwrap()),
        sample_type: SampleType::F32,
        quantize_linearly: false,
        sampling: Vec2(channel.sampling as usize, channel.sampling as usize),
    };
    let list: Vec<_> = part.channels.iter().map(description).collect();
    let size = Vec2(width as usize, height as usize);
    let mut header = Header::new(Text::from(""), size, list.into());
    header.compression = compression;
    header.blocks = BlockDescription::ScanLines;
    let blocks: Vec<Vec<u8>> = raw_lines
        .chunks(lines as usize)
        .zip((top..).step_by(lines as usize))
        .map(|(raw, y)| {
            let section = IntegerBounds::new((left, y), (width as usize, raw.len()));
            let packed = compression.compress_image_section_to_le(&header, raw.concat(), section);
            let packed = packed.unwrap();
            [
                &y.to_le_bytes()[..],
                &(packed.len() as i32).to_le_bytes(),
                &packed,
            ]
            .concat()
        })
        .collect();
    let mut place = (head.len() + 8 * blocks.len()) as u64;
    for block in &blocks {
        head.extend_from_slice(&place.to_le_bytes());
        place += block.len() as u64;
    }
    head.extend(blocks.concat());
    head
}

/// The first entry of the offset table of a file with one line in each block: it says where the table
/// ends.
fn first_offset(file: &[u8], lines: i32) -> [u8; 8] {
    let entries = (0..file.len() - 8).map(|place| (place, &file[place..place + 8]));
    let mut found = entries.filter(|(place, bytes)| {
        let offset = u64::from_le_bytes((*bytes).try_into().unwrap());
        offset == (place + 8 * lines as usize) as u64
    });
    found.next().unwrap().1.try_into().unwrap()
}
