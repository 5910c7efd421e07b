//! The EXR files that candela writes, as OpenImageIO sees them.

use std::fs;
use std::io::Cursor;
use std::path::Path;
use std::process::Command;

use candela::exr::{Compression, ExrOptions, Precision, read};
use candela::image::{Channel, ChannelKind, Channels, Film, Metadata, Number, Window};
use candela::output::{OutputProblem, Unfinished};
use candela::scene::ColorSpace;
use half::f16;

use crate::openimageio::{decode, idiff_agrees, oiiotool};

const RESOLUTION: [u32; 2] = [120, 90];
/// Neither even nor at the origin, and more than one block of every compression but DWAB.
const WINDOW: Window = Window {
    x: 7,
    y: 11,
    width: 101,
    height: 67,
};
const SIZE: usize = 101 * 67;

fn metadata() -> Metadata {
    Metadata {
        color_space: ColorSpace::Rec709,
        world_to_camera: [
            [0.0, 0.0, 1.0, 5.0],
            [0.0, 1.0, 0.0, 6.0],
            [-1.0, 0.0, 0.0, 7.0],
            [0.0, 0.0, 0.0, 1.0],
        ],
        world_to_ndc: [
            [2.0, 0.0, 0.25, 0.0],
            [0.0, 3.0, 0.75, 0.0],
            [0.0, 0.0, 1.0, 0.5],
            [0.0, 0.0, 1.0, 0.0],
        ],
        provenance: [("plan", "rgb, 3 lights"), ("scene", "größe")]
            .map(|(key, value)| (key.to_string(), value.to_string()))
            .to_vec(),
        numbers: [
            ("candela:samples", Number::Integer(16)),
            ("pinholeFocalLength", Number::Float(35.5)),
            ("sensorOverallDimensions", Number::Pair([36.0, 24.0])),
        ]
        .map(|(name, number)| (name.to_string(), number))
        .to_vec(),
    }
}

fn film_of(pixels: Vec<[f32; 4]>) -> Film {
    Film::new(RESOLUTION, WINDOW, pixels, metadata())
}

/// A smooth picture with an edge, as lossy compressions are made for.
fn smooth() -> Film {
    let pixel = |i: usize| {
        let (x, y) = ((i % 101) as f32 / 101.0, (i / 101) as f32 / 67.0);
        let light = if x + y > 1.0 { 2.0 } else { 0.25 };
        let coverage = if y > 0.5 { 1.0 } else { 0.5 };
        [
            light * (1.0 + x),
            light * (1.0 + y),
            light * (1.5 - x * y),
            coverage,
        ]
    };
    film_of((0..SIZE).map(pixel).collect())
}

/// Numbers of every magnitude and sign, which no compression can guess.
fn rough() -> Film {
    let mut state = 1_u32;
    let mut value = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let exponent = i32::from((state >> 8) as u8 % 60) - 40;
        let sign = if state & 0x80 == 0 { 1.0 } else { -1.0 };
        sign * (1.0 + (state >> 9) as f32 / (1 << 23) as f32) * (exponent as f32).exp2()
    };
    film_of(
        (0..SIZE)
            .map(|_| std::array::from_fn(|_| value()))
            .collect(),
    )
}

fn options(precision: Precision, compression: Compression) -> ExrOptions {
    ExrOptions {
        precision,
        compression,
        chromaticities: false,
        full_window: false,
        tile: None,
    }
}

fn bytes(film: &Film, options: &ExrOptions) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let report = film.write_exr_to(&mut file, options).unwrap();
    assert_eq!(report.bytes, file.get_ref().len() as u64);
    file.into_inner()
}

fn as_half(value: f32) -> f32 {
    f16::from_f32(value.clamp(-65_504.0, 65_504.0)).to_f32()
}

#[test]
fn header_as_oiiotool_prints_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    smooth()
        .write_exr(&path, &ExrOptions::default(), &Unfinished::new())
        .unwrap();
    let info = oiiotool(folder.path(), "--info -v a.exr");
    let lines: Vec<&str> = info.lines().map(str::trim).collect();
    let version = env!("CARGO_PKG_VERSION");
    for expected in [
        "channel list: R, G, B, A",
        "pixel data origin: x=7, y=11",
        "full/display size: 120 x 90",
        "full/display origin: 0, 0",
        "compression: \"zip\"",
        "colorInteropID: \"lin_rec709_scene\"",
        "whiteLuminance: 1",
        // Row vectors: the translation is in the last row.
        "worldToCamera: 0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0, 5, 6, 7, 1",
        "worldToNDC: 2, 0, 0, 0, 0, 3, 0, 0, 0.25, 0.75, 1, 1, 0, 0, 0.5, 0",
        &format!("software: \"candela {version}\""),
        "candela:plan: \"rgb, 3 lights\"",
        "candela:samples: 16",
        "pinholeFocalLength: 35.5",
        "sensorOverallDimensions: 36, 24",
        "candela:scene: \"größe\"",
        "openexr:lineOrder: \"increasingY\"",
        "oiio:subimages: 1",
    ] {
        assert!(lines.contains(&expected), "no `{expected}` in\n{info}");
    }
    assert!(
        lines[1].contains("101 x   67, 4 channel, float openexr"),
        "{info}"
    );
    for absent in ["chromaticities", "DateTime", "name"] {
        assert!(!info.contains(absent), "{absent} in\n{info}");
    }
}

#[test]
fn chromaticities_if_asked_for() {
    for (space, id, expected) in [
        (
            ColorSpace::Rec709,
            "lin_rec709_scene",
            "0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329",
        ),
        (
            ColorSpace::AcesCg,
            "lin_ap1_scene",
            "0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let film = Film::new(
            RESOLUTION,
            WINDOW,
            vec![[0.0; 4]; SIZE],
            Metadata {
                color_space: space,
                ..metadata()
            },
        );
        let options = ExrOptions {
            chromaticities: true,
            ..ExrOptions::default()
        };
        film.write_exr(&folder.path().join("a.exr"), &options, &Unfinished::new())
            .unwrap();
        let info = oiiotool(folder.path(), "--info -v a.exr");
        assert!(
            info.contains(&format!("colorInteropID: \"{id}\"")),
            "{info}"
        );
        assert!(
            info.contains(&format!("chromaticities: {expected}")),
            "{info}"
        );
    }
}

/// PXR24 keeps 15 of FLOAT's 23 bits, rounded.
const PXR24_RELATIVE: f32 = 1.0 / 65_536.0;

#[test]
fn every_compression_comes_back_in_openimageio() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, film: &Film, options: &ExrOptions| {
        let path = folder.path().join(name);
        film.write_exr(&path, options, &Unfinished::new()).unwrap();
        path
    };
    for compression in Compression::ALL {
        for precision in [Precision::Float, Precision::Half] {
            let is_lossless = compression.is_lossless(precision);
            let film = if is_lossless { rough() } else { smooth() };
            let path = write("a.exr", &film, &options(precision, compression));
            let decoded = decode(&path);
            let case = format!("{compression} {precision:?}");
            assert_eq!(decoded.channels, ["R", "G", "B", "A"], "{case}");
            assert_eq!(decoded.data_window, [7, 11, 101, 67], "{case}");
            assert_eq!(decoded.display_window, [0, 0, 120, 90], "{case}");

            // Our reader decodes what OpenEXR does, to the bit, the lossy ones as well.
            let ours = read(&path).unwrap();
            assert_eq!((ours.resolution, ours.window), (RESOLUTION, Some(WINDOW)));
            assert_eq!(bits(ours.pixels.as_flattened()), bits(&decoded.values));

            let stored: Vec<f32> = film
                .pixels()
                .as_flattened()
                .iter()
                .map(|&value| match precision {
                    Precision::Float => value,
                    Precision::Half => as_half(value),
                })
                .collect();
            match compression {
                Compression::Pxr24 if !is_lossless => {
                    for (&value, &stored) in decoded.values.iter().zip(&stored) {
                        let error = (value - stored).abs();
                        assert!(error <= stored.abs() * PXR24_RELATIVE, "{value} {stored}");
                    }
                }
                Compression::Dwaa | Compression::Dwab => {
                    write("plain.exr", &film, &options(precision, Compression::None));
                    let theirs = format!("plain.exr --compression {compression} -o theirs.exr");
                    oiiotool(folder.path(), &theirs);
                    let theirs = decode(&folder.path().join("theirs.exr"));
                    let theirs = worst(&theirs.values, &stored);
                    let ours = worst(&decoded.values, &stored);
                    // Both quantize the same coefficients by the same table.
                    assert!(ours > 0.0 && ours == theirs, "{case}: {ours} {theirs}");
                    // Coverage is not lossy.
                    for i in (3..stored.len()).step_by(4) {
                        assert_eq!(decoded.values[i], stored[i], "{case}");
                    }
                }
                Compression::None
                | Compression::Rle
                | Compression::Zips
                | Compression::Zip
                | Compression::Piz
                | Compression::Pxr24 => {
                    assert_eq!(bits(&decoded.values), bits(&stored), "{case}");
                }
            }
        }
    }
}

fn bits(values: &[f32]) -> Vec<u32> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// The largest difference.
fn worst(values: &[f32], expected: &[f32]) -> f32 {
    assert_eq!(values.len(), expected.len());
    let differences = values.iter().zip(expected).map(|(a, b)| (a - b).abs());
    differences.fold(0.0, f32::max)
}

#[test]
fn idiff_sees_one_picture_in_every_lossless_compression() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, compression| {
        let path = folder.path().join(name);
        smooth()
            .write_exr(
                &path,
                &options(Precision::Float, compression),
                &Unfinished::new(),
            )
            .unwrap();
        path
    };
    let plain = write("none.exr", Compression::None);
    for compression in [Compression::Rle, Compression::Zip, Compression::Piz] {
        assert!(idiff_agrees(&plain, &write("other.exr", compression)));
    }
    let other = folder.path().join("rough.exr");
    rough()
        .write_exr(&other, &ExrOptions::default(), &Unfinished::new())
        .unwrap();
    assert!(!idiff_agrees(&plain, &other));
}

#[test]
fn values_beyond_half_are_clamped_and_counted() {
    let mut pixels = vec![[1.0; 4]; SIZE];
    pixels[3] = [65_504.0, 65_505.0, -1e9, 1.0];
    pixels[SIZE - 1] = [f32::MAX, 0.0, 0.0, 1.0];
    let film = film_of(pixels);
    let mut file = Cursor::new(Vec::new());
    let half = options(Precision::Half, Compression::Zip);
    assert_eq!(
        film.write_exr_to(&mut file, &half).unwrap().clamped_to_half,
        3
    );
    let report = film
        .write_exr_to(&mut Cursor::new(Vec::new()), &ExrOptions::default())
        .unwrap();
    assert_eq!(report.clamped_to_half, 0);

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    fs::write(&path, file.into_inner()).unwrap();
    let decoded = decode(&path);
    assert_eq!(decoded.pixel(3, 0), [65_504.0, 65_504.0, -65_504.0, 1.0]);
    assert_eq!(decoded.pixel(100, 66), [65_504.0, 0.0, 0.0, 1.0]);
}

#[test]
fn same_bytes_for_any_number_of_threads() {
    for compression in Compression::ALL {
        let options = options(Precision::Half, compression);
        let film = smooth();
        let first = bytes(&film, &options);
        // Hash maps are seeded anew each time, so that repetition finds an order that varies.
        for threads in [1, 2, 3, 8, 1, 2, 3, 8] {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            assert!(pool.install(|| bytes(&film, &options)) == first);
        }
    }
}

/// Layers of every kind in one part: sorted by name, whatever their order in the film, and
/// distances stay FLOAT.
#[test]
fn channels_beside_rgba_come_back_in_every_compression() {
    let channel = |name: &str, kind| Channel {
        name: name.to_owned(),
        kind,
    };
    let channels = Channels {
        list: vec![
            channel("light_key.R", ChannelKind::Light),
            channel("Z", ChannelKind::Data),
            channel("N.X", ChannelKind::Relative),
            channel("B2", ChannelKind::Light),
        ],
        attributes: vec![("about".to_owned(), "the layers".to_owned())],
        sums: Vec::new(),
    };
    // Beyond HALF's range and digits; each channel differs.
    let values = |pixel: usize| {
        let x = pixel as f32;
        [x / 64.0, 1e6 + x, -1e-9 * x, 3.0 - x]
    };
    let film = smooth().with_channels(channels, (0..SIZE).flat_map(values).collect());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    for compression in Compression::ALL {
        // PXR24 rounds every FLOAT.
        if compression == Compression::Pxr24 {
            continue;
        }
        for precision in [Precision::Float, Precision::Half] {
            let case = format!("{compression} {precision:?}");
            film.write_exr(&path, &options(precision, compression), &Unfinished::new())
                .unwrap();
            let decoded = decode(&path);
            let place = |name| decoded.channels.iter().position(|c| c == name).unwrap();
            let places = ["light_key.R", "Z", "N.X", "B2"].map(place);
            let asked = |value| match precision {
                Precision::Float => value,
                Precision::Half => as_half(value),
            };
            for pixel in 0..SIZE {
                let [key, z, n, b2] = values(pixel);
                let stored = decoded.pixel(pixel % 101, pixel / 101);
                let expected = [asked(key), z, asked(n), asked(b2)];
                // DWA has losses in colors alone, which it knows by their names.
                let exact = usize::from(!compression.is_lossless(precision));
                let found = places.map(|place| stored[place]);
                assert_eq!(found[exact..], expected[exact..], "{case}");
            }
            let ours = read(&path).unwrap();
            for (pixel, ours) in ours.pixels.iter().enumerate() {
                let rgba = &decoded.pixel(pixel % 101, pixel / 101)[..4];
                assert_eq!(ours[..], *rgba, "{case}");
            }
        }
    }
    let info = oiiotool(folder.path(), "--info -v a.exr");
    let list = "channel list: R (half), G (half), B (half), A (half), Z (float), B2 (half), \
                N.X (half), light_key.R (half)";
    for expected in [list, "about: \"the layers\""] {
        assert!(info.contains(expected), "no `{expected}` in\n{info}");
    }
}

#[test]
fn two_channels_of_one_name_are_refused() {
    let channels = Channels {
        list: vec![Channel {
            name: "R".to_owned(),
            kind: ChannelKind::Light,
        }],
        attributes: Vec::new(),
        sums: Vec::new(),
    };
    let film = smooth().with_channels(channels, vec![0.0; SIZE]);
    let error = film.write_exr_to(&mut Cursor::new(Vec::new()), &ExrOptions::default());
    assert!(error.unwrap_err().to_string().contains("unique"));
}

/// Where the other process of the next test writes.
const OTHER_PROCESS: &str = "CANDELA_TEST_EXR_OF_OTHER_PROCESS";

#[test]
fn same_bytes_in_another_process() {
    let options = options(Precision::Float, Compression::Zip);
    if let Some(path) = std::env::var_os(OTHER_PROCESS) {
        fs::write(path, bytes(&smooth(), &options)).unwrap();
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let status = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "exr::same_bytes_in_another_process"])
        .env(OTHER_PROCESS, &path)
        .output()
        .unwrap()
        .status;
    assert!(status.success());
    assert!(fs::read(&path).unwrap() == bytes(&smooth(), &options));
}

#[test]
fn a_target_that_cannot_be_written_to_stays() {
    let folder = tempfile::tempdir().unwrap();
    let write = |path: &Path| {
        smooth()
            .write_exr(path, &ExrOptions::default(), &Unfinished::new())
            .map_err(|error| error.problem)
    };
    let missing = folder.path().join("none").join("a.exr");
    assert!(matches!(
        write(&missing),
        Err(OutputProblem::MissingFolder(_))
    ));
    #[cfg(target_os = "linux")]
    assert!(matches!(
        write(Path::new("/proc/a.exr")),
        Err(OutputProblem::ClosedFolder { .. })
    ));

    // Metadata that no EXR can hold is found before anything is written.
    let path = folder.path().join("a.exr");
    fs::write(&path, "old").unwrap();
    let mut metadata = metadata();
    metadata.provenance = vec![("k".repeat(300), String::new())];
    let film = Film::new(RESOLUTION, WINDOW, vec![[0.0; 4]; SIZE], metadata);
    let error = film
        .write_exr(&path, &ExrOptions::default(), &Unfinished::new())
        .unwrap_err();
    assert!(error.to_string().contains("255"), "{error}");
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}
