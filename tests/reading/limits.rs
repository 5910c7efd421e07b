//! What is not read, what is said of it, and how much memory a file may take.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use candela::display::{Alpha, Dither, Exposure, Picture, Settings, convert, tonemap};
use candela::exr::{Compression, ExrOptions, ExrProblem, read};
use candela::image::{Film, Metadata, Window};
use candela::output::Unfinished;
use candela::scene::ColorSpace;

use super::file::{Part, bytes, channel, rgb, row, write};
use super::{NEAREST, shown};
use crate::allocation::peak;
use crate::openimageio::oiiotool;

const COLORS: [[f32; 3]; 4] = [[0.5; 3]; 4];

fn part() -> Part {
    row(4, rgb("", &COLORS))
}

#[track_caller]
fn refused(part: Part) -> String {
    let folder = tempfile::tempdir().unwrap();
    match shown(&write(folder.path(), &[part]), None, &NEAREST) {
        Ok(_) => panic!("it is shown"),
        Err(message) => message,
    }
}

fn window(sides: [i32; 4]) -> Vec<u8> {
    sides.into_iter().flat_map(i32::to_le_bytes).collect()
}

#[test]
fn compressions_that_are_not_decoded_are_named() {
    for (number, expected) in [
        (10, "HTJ2K256 (High-Throughput JPEG 2000, of OpenEXR 3.4)"),
        (11, "HTJ2K32 (High-Throughput JPEG 2000, of OpenEXR 3.4)"),
        (12, "newer than OpenEXR 3.4 (number 12)"),
        (255, "newer than OpenEXR 3.4 (number 255)"),
    ] {
        let message = refused(Part {
            compression: number,
            ..part()
        });
        assert!(message.contains(expected), "{message}");
        assert!(message.contains("`oiiotool in.exr --compression zip -o out.exr`"));
    }
}

#[test]
fn what_oiiotool_writes_as_htj2k_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let how = "--pattern constant:color=.1,.2,.3 64x64 3 -d half --compression htj2k256 -o a.exr";
    oiiotool(folder.path(), how);
    let error = read(&folder.path().join("a.exr")).unwrap_err().to_string();
    assert!(error.contains("HTJ2K256"), "{error}");
}

#[test]
fn deep_pixels_are_named() {
    let message = refused(part().with("type", "string", "deepscanline"));
    assert!(message.contains("it has deep pixels"), "{message}");
    assert!(message.contains("--flatten"), "{message}");
    let message = refused(part().with("type", "string", "hologram"));
    assert!(message.contains("the unknown type `hologram`"), "{message}");
}

#[test]
fn windows_that_are_turned_around_are_errors() {
    for (name, title) in [
        ("dataWindow", "data window"),
        ("displayWindow", "display window"),
    ] {
        for sides in [[3, 0, 2, 0], [0, 5, 3, 0], [i32::MAX, 0, i32::MIN, 0]] {
            let message = refused(part().with(name, "box2i", window(sides)));
            let expected = format!(
                "its {title} is turned around: from ({}, {})",
                sides[0], sides[1]
            );
            assert!(message.contains(&expected), "{message}");
        }
        let message = refused(part().with(name, "box2i", window([i32::MIN, 0, i32::MAX, 0])));
        assert!(
            message.contains("beyond the limits of OpenEXR"),
            "{message}"
        );
    }
}

#[test]
fn nothing_in_the_display_window_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let aside = Part {
        data: [100, 100, 101, 100],
        display: [0, 0, 3, 1],
        ..row(2, vec![channel("Y", |_, _| 1.0)])
    };
    let shown = shown(&write(folder.path(), &[aside]), None, &NEAREST).unwrap();
    assert_eq!(shown.pixels, vec![vec![0, 0, 0]; 8]);
    assert_eq!(
        shown.report.warnings,
        [
            "the data window, (100, 100) to (101, 100), is outside of the display window, \
             (0, 0) to (3, 1): nothing is shown"
        ]
    );
}

#[test]
fn pixels_that_are_not_square_are_tagged() {
    let folder = tempfile::tempdir().unwrap();
    let of = |aspect: f32| {
        let part = part().with("pixelAspectRatio", "float", aspect.to_le_bytes());
        shown(&write(folder.path(), &[part]), None, &NEAREST).unwrap()
    };
    // Twice as wide as high: twice as many to a unit of height.
    let wide = of(2.0);
    assert_eq!(wide.dimensions, Some([1_000_000, 2_000_000]));
    assert!(wide.report.warnings[0].contains("2 times as wide as high"));
    for square in [1.0, f32::NAN, 0.0, -1.0, f32::INFINITY] {
        let square = of(square);
        assert_eq!(square.dimensions, None);
        assert!(square.report.warnings.is_empty());
    }
}

#[test]
fn black_and_blown_out_pictures_are_remarked() {
    let folder = tempfile::tempdir().unwrap();
    let with = |values: &'static [f32], exposure| {
        let channels = vec![channel("Y", |x, _| values[x as usize])];
        let path = write(folder.path(), &[row(values.len() as i32, channels)]);
        let settings = Settings {
            exposure,
            ..NEAREST
        };
        shown(&path, None, &settings).unwrap().report
    };
    let of = |values, ev| with(values, Exposure::Ev(ev));
    let black = of(&[0.0; 4], 0.0);
    assert_eq!(black.brightest, 0.0);
    assert_eq!(
        black.remarks(),
        ["the picture is black: no pixel has any light"]
    );
    let dark = of(&[0.0, 0.0003], 0.0);
    assert!((dark.brightest - 0.0003).abs() < 1e-9);
    assert!(dark.is_black);
    assert_eq!(
        dark.remarks(),
        [
            "the picture is black: its brightest pixel has a luminance of 0.0003, where the screen's \
          white is 1; try --auto-exposure"
        ]
    );
    let lifted = of(&[0.0, 0.0003], 10.0);
    assert!(!lifted.is_black && lifted.remarks().is_empty());
    let bright = of(&[1.0, 2.0, 0.5, f32::INFINITY, 0.2, 0.2, 0.2, 0.2], 0.0);
    assert_eq!((bright.brightest, bright.clipped), (2.0, 0.25));
    assert!(bright.remarks()[0].starts_with("25 % of the picture is brighter than the screen"));
    assert!(of(&[1.0, 0.5], 0.0).remarks().is_empty());

    // What the automatic exposure did not cure, it is not said to cure. log2(1e8) = 26.6, and the
    // log-average of the four is 0.1: log2(0.18 / 0.1) = 0.85.
    for exposure in [Exposure::Auto, Exposure::Ev(0.0)] {
        let remark = &with(&[0.0, 1e-8], exposure).remarks()[0];
        assert!(remark.ends_with("; try --exposure 27"), "{remark}");
    }
    assert_eq!(
        with(&[0.01, 0.01, 0.01, 100.0], Exposure::Auto).remarks(),
        [
            "25 % of the picture is brighter than the screen and clips; try --view reinhard, or an \
          --exposure below 0.8"
        ]
    );
}

#[test]
fn an_exposure_of_nothing_has_no_sign() {
    let folder = tempfile::tempdir().unwrap();
    let mut report = shown(&write(folder.path(), &[part()]), None, &NEAREST)
        .unwrap()
        .report;
    for (ev, expected) in [
        (-0.0001, "0.000 EV"),
        (-0.0, "0.000 EV"),
        (-1.25, "-1.250 EV"),
    ] {
        report.ev = ev;
        assert_eq!(report.exposure(), expected);
    }
}

/// An EXR of candela's of so many pixels.
fn film(side: u32, compression: Compression, pixel: impl Fn(usize) -> [f32; 4]) -> Vec<u8> {
    let metadata = Metadata {
        color_space: ColorSpace::Rec709,
        world_to_camera: [[0.0; 4]; 4],
        world_to_ndc: [[0.0; 4]; 4],
        provenance: Vec::new(),
        numbers: Vec::new(),
    };
    let pixels = (0..(side * side) as usize).map(pixel).collect();
    let film = Film::new([side; 2], Window::whole([side; 2]), pixels, metadata);
    let options = ExrOptions {
        compression,
        ..ExrOptions::default()
    };
    let mut file = Cursor::new(Vec::new());
    film.write_exr_to(&mut file, &options).unwrap();
    file.into_inner()
}

/// What a file becomes by bands is what it becomes as a whole, whatever the threads.
#[test]
fn bands_make_the_picture_of_the_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let pixel = |i: usize| {
        let (x, y) = ((i % 300) as f32, (i / 300) as f32);
        [
            x / 200.0,
            y / 300.0,
            (x * y).sin().abs(),
            if y < 250.0 { 1.0 } else { 0.5 },
        ]
    };
    // Light without coverage, in the last row alone.
    let uncovered = |i: usize| {
        let [r, g, b, a] = pixel(i);
        [r, g, b, if i == 300 * 299 + 7 { 0.0 } else { a }]
    };
    let picture = |pixels: Vec<u8>, tiles: bool| {
        fs::write(&path, pixels).unwrap();
        if tiles {
            oiiotool(folder.path(), "a.exr --tile 64 32 -o a.exr");
        }
        for (exposure, dither) in [
            (Exposure::Ev(0.5), Dither::None),
            (Exposure::Auto, Dither::Blue),
        ] {
            let settings = Settings {
                exposure,
                dither,
                alpha: Alpha::Auto,
                ..NEAREST
            };
            let whole = tonemap(&Picture::new(read(&path).unwrap()), &settings);
            for threads in [1, 3] {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
                let shown = pool
                    .unwrap()
                    .install(|| shown(&path, None, &settings).unwrap());
                let channels = if whole.has_alpha() { 4 } else { 3 };
                assert_eq!(shown.pixels[0].len(), channels);
                assert!(
                    shown.pixels.concat() == whole.samples(),
                    "{settings:?} {threads}"
                );
            }
        }
    };
    for compression in [Compression::Zip, Compression::Dwab] {
        picture(film(300, compression, pixel), false);
        picture(film(300, compression, uncovered), false);
    }
    picture(film(300, Compression::Zip, pixel), true);
    picture(film(300, Compression::Zip, uncovered), true);
}

/// The most that this thread, which does all the work, has allocated while it converts.
fn peak_of(exr: &Path, format: &str) -> (Result<(), String>, usize) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let picture = exr.with_extension(format);
    pool.unwrap().install(|| {
        peak(|| {
            let converted = convert(exr, &picture, &NEAREST, &Unfinished::new());
            converted.map(drop).map_err(|error| error.to_string())
        })
    })
}

/// 2000 × 2000 pixels are 64 MB as R, G, B, A in FLOAT. A band of 2 MiB, twice, the rows that are
/// encoded, and one block in the making are all that there is at a time.
#[test]
fn a_picture_is_never_in_memory_as_a_whole() {
    let folder = tempfile::tempdir().unwrap();
    let exr = folder.path().join("a.exr");
    let pixel = |i: usize| [(i % 2000) as f32 / 2000.0, (i as f32).sin().abs(), 0.5, 1.0];
    fs::write(&exr, film(2000, Compression::Zip, pixel)).unwrap();
    for format in ["png", "tif"] {
        let (converted, bytes) = peak_of(&exr, format);
        assert_eq!(converted, Ok(()));
        assert!(bytes < 16_000_000, "{format}: {bytes}");
    }
}

/// A file of 60 kB that claims 20000 × 20000 pixels is given up at its first block, which would have
/// 20000 × 32 pixels.
#[test]
fn a_small_file_takes_small_memory() {
    let folder = tempfile::tempdir().unwrap();
    let exr = folder.path().join("a.exr");
    let side = 20_000;
    for compression in [3, 4, 5, 7, 8, 9] {
        let claim = Part {
            compression,
            ..part().with("dataWindow", "box2i", window([0, 0, side - 1, side - 1]))
        };
        let claim = claim.with("displayWindow", "box2i", window([0, 0, side - 1, side - 1]));
        let mut file = bytes(&[claim]);
        // One block of noise, to which all of the offset table points.
        file.truncate(file.len() - 8 - 8 - 4 * 12);
        let place = (file.len() + 8 * 1250) as u64;
        file.extend((0..1250).flat_map(|_| place.to_le_bytes()));
        file.extend_from_slice(&0_i32.to_le_bytes());
        file.extend_from_slice(&49_000_i32.to_le_bytes());
        file.extend((0..49_000_u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 24) as u8));
        fs::write(&exr, file).unwrap();
        let (converted, bytes) = peak_of(&exr, "png");
        let message = converted.unwrap_err();
        assert!(
            message.contains("damaged or incomplete"),
            "{compression}: {message}"
        );
        // A band of one block in f32, and that block in the making.
        assert!(bytes < 40_000_000, "{compression}: {bytes}, {message}");
    }
}

/// Lists of channels and names may be most of a file.
#[test]
fn headers_take_little_more_than_their_size() {
    let folder = tempfile::tempdir().unwrap();
    let exr = folder.path().join("a.exr");
    let list = |count: u32| -> Vec<u8> {
        let channels = (0..count).flat_map(|number| {
            // Each in a layer of its own.
            let mut channel = format!("{number:x}.c").into_bytes();
            channel.extend_from_slice(&[0, 2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
            channel
        });
        channels.chain([0]).collect()
    };
    let file = bytes(&[part().with("channels", "chlist", list(100_000))]);
    let length = file.len();
    fs::write(&exr, file).unwrap();
    let (converted, peak) = peak_of(&exr, "png");
    assert!(
        converted
            .unwrap_err()
            .contains("it has no channels R, G, B")
    );
    assert!(peak < 20 * length, "{peak} for {length}");

    fs::write(
        &exr,
        bytes(&[part().with("channels", "chlist", list(300_000))]),
    )
    .unwrap();
    let (converted, peak) = peak_of(&exr, "png");
    assert!(
        converted
            .unwrap_err()
            .contains("hundreds of thousands of channels")
    );
    assert!(peak < 1_000_000, "{peak}");

    // Other attributes are passed over.
    let preview = vec![0; 10_000_000];
    fs::write(&exr, bytes(&[part().with("preview", "preview", preview)])).unwrap();
    let (converted, peak) = peak_of(&exr, "png");
    assert_eq!(converted, Ok(()));
    assert!(peak < 8_000_000, "{peak}");
}

#[test]
fn errors_that_may_pass_are_told_apart() {
    let folder = tempfile::tempdir().unwrap();
    let is_transient = |path: &Path| read(path).unwrap_err().is_transient();
    assert!(!is_transient(&folder.path().join("none.exr")));
    assert!(!is_transient(folder.path()));
    let text = folder.path().join("text.exr");
    fs::write(&text, "no EXR").unwrap();
    assert!(!is_transient(&text));
    let error = candela::exr::ExrError {
        path: text.clone(),
        problem: ExrProblem::NoMemory { bytes: 1 << 40 },
    };
    assert!(error.is_transient());
    assert!(error.to_string().contains("out of memory: 1099511.6 MB"));
    let error = candela::exr::ExrError {
        path: text,
        problem: ExrProblem::Io(std::io::ErrorKind::StaleNetworkFileHandle.into()),
    };
    assert!(error.is_transient());
}
