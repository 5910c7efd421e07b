//! TIFF as other programs write it, and as candela does.

use std::path::Path;

use candela::display::{Bits, Settings, convert};
use candela::output::Unfinished;
use image::DynamicImage;

use super::NEAREST;
use crate::openimageio::oiiotool;

/// As another program writes each: tiles, planes, strips, LZW and deflate, predictors, both kinds of alpha.
#[test]
fn tiffs_of_openimageio_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let pattern = "--pattern fill:topleft=0,0.1,0.2,1:topright=1,0.5,0.1,1:bottomleft=0.1,0.2,0.3,0.5\
        :bottomright=0.2,0.1,0.05,0.25 70x50 4 --chnames R,G,B,A";
    let sixteen = Settings {
        bits: Bits::Sixteen,
        ..NEAREST
    };
    for how in [
        "-d uint8 -o a.tif",
        "-d uint16 -o a.tif",
        "-d float -o a.tif",
        "-d uint8 --tile 32 32 --compression lzw -o a.tif",
        "-d uint16 --compression zip -o a.tif",
        "-d float --compression zip -o a.tif",
        "-d uint8 --compression packbits -o a.tif",
        "-d uint8 --attrib oiio:UnassociatedAlpha 1 -o a.tif",
        "-d uint8 --planarconfig separate -o a.tif",
        "-d uint8 --ch R,G,B -o a.tif",
        "-d uint8 --ch R -o a.tif",
        "-d uint8 --ch R,G,B --orientation 6 -o a.tif",
    ] {
        oiiotool(folder.path(), &format!("{pattern} {how}"));
        // What it reads of the same file, upright, linear where it is not.
        let curve = if how.contains("float") {
            ""
        } else {
            "--unpremult --pow 1,1,1,1 --premult"
        };
        let _ = curve;
        let (tif, png) = (folder.path().join("a.tif"), folder.path().join("a.png"));
        convert(&tif, &png, &sixteen, &Unfinished::new())
            .unwrap_or_else(|error| panic!("{how}: {error}"));
        assert_codes(&png, folder.path(), how);
    }
}

/// Holds a picture of 16 bits against the code values of `a.tif` as OpenImageIO reads them.
fn assert_codes(png: &Path, folder: &Path, how: &str) {
    let upright = if how.contains("orientation") {
        "--reorient"
    } else {
        ""
    };
    oiiotool(folder, &format!("a.tif {upright} -d float -o b.exr"));
    let theirs = crate::openimageio::decode(&folder.join("b.exr"));
    let ours = image::open(png).unwrap();
    let ours = ours.to_rgba16();
    let is_light = how.contains("float");
    for (x, y, pixel) in ours.enumerate_pixels() {
        let their = theirs.pixel(x as usize, y as usize);
        let named = |name: &str| {
            theirs
                .channels
                .iter()
                .position(|channel| channel == name)
                .map(|place| f64::from(their[place]))
        };
        let alpha = named("A").unwrap_or(1.0);
        let first = named("R").or(named("Y")).unwrap();
        let expected = [Some(first), named("G"), named("B")].map(|value| {
            // Coded values are multiplied by alpha here, as OpenImageIO has them in memory.
            let value = value.unwrap_or(first) / alpha;
            if !is_light {
                value
            } else if value <= 0.003_130_8 {
                12.92 * value
            } else {
                1.055 * value.powf(1.0 / 2.4) - 0.055
            }
        });
        for (found, expected) in pixel.0.iter().zip(expected.iter().chain([&alpha])) {
            let found = f64::from(*found) / 65_535.0;
            // Codes of 8 bits that were multiplied by a quarter.
            assert!(
                (found - expected).abs() < 2e-5,
                "{how} ({x}, {y}): {found} {expected}"
            );
        }
    }
}

/// What is written as TIFF has the samples of the PNG; floats are what these are rounded from.
#[test]
fn tiffs_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    oiiotool(
        folder.path(),
        "--pattern fill:topleft=0,0.1,0.2,1:topright=2,0.5,0.1,1:bottomleft=0.1,-0.2,0.3,0.5\
         :bottomright=0.2,0.1,0.05,0.25 70x50 4 --chnames R,G,B,A -d float -o a.exr",
    );
    let made = |name: &str, bits| {
        let settings = Settings { bits, ..NEAREST };
        convert(&path("a.exr"), &path(name), &settings, &Unfinished::new()).unwrap();
        image::open(path(name)).unwrap()
    };
    assert_eq!(made("a.tif", Bits::Eight), made("a.png", Bits::Eight));
    let sixteen = made("b.png", Bits::Sixteen);
    assert_eq!(made("b.TIFF", Bits::Sixteen), sixteen);
    let DynamicImage::ImageRgba32F(floats) = made("c.tif", Bits::ThirtyTwo) else {
        panic!("floats");
    };
    let DynamicImage::ImageRgba16(sixteen) = sixteen else {
        panic!("sixteen bits");
    };
    let range = floats
        .as_raw()
        .iter()
        .fold([0.0_f32; 2], |[least, most], &v| {
            [least.min(v), most.max(v)]
        });
    // Light 2 and −0.2 / 0.5 are outside of the codes: 1.055 · 2^(1/2.4) − 0.055, and 12.92 · −0.4.
    assert!(
        (range[1] - 1.353_256).abs() < 1e-5 && (range[0] + 5.168).abs() < 1e-5,
        "{range:?}"
    );
    for (&float, &code) in floats.as_raw().iter().zip(sixteen.as_raw()) {
        // Half a code, and what a float is rounded by.
        let expected = f64::from(float).clamp(0.0, 1.0) * 65_535.0;
        assert!(
            (f64::from(code) - expected).abs() < 0.503,
            "{code}, not {expected}"
        );
    }
    let error = convert(
        &path("a.exr"),
        &path("d.png"),
        &Settings {
            bits: Bits::ThirtyTwo,
            ..NEAREST
        },
        &Unfinished::new(),
    );
    assert_eq!(
        error.unwrap_err().to_string(),
        "a PNG has samples of 8 or 16 bits; for 32 bits, name the output .tif"
    );
}
