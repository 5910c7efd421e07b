//! EXR files of any origin as candela shows them.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use candela::display::{
    Alpha, Bits, DisplayError, Dither, Exposure, Picture, Settings, View, convert, tonemap,
};
use candela::exr::{Compression, ExrOptions, ExrProblem, read};
use candela::image::{Film, Metadata, Window};
use candela::output::{OutputProblem, Unfinished};
use candela::scene::{ColorSpace, Scene};

use crate::images::{at_width, film_of};
use crate::measured::Measured;
use crate::openimageio::{Decoded, decode, oiiotool};

/// Without dither: every value becomes the nearest code.
const NEAREST: Settings<'static> = Settings {
    dither: Dither::None,
    ..Settings::new()
};

/// A PNG as the png crate decodes it: width, samples of a pixel, all samples.
#[derive(Debug, PartialEq)]
struct Png {
    width: usize,
    channels: usize,
    samples: Vec<u16>,
}

impl Png {
    fn pixel(&self, x: usize, y: usize) -> &[u16] {
        &self.samples[(y * self.width + x) * self.channels..][..self.channels]
    }
}

fn decode_png(path: &Path) -> Png {
    let bytes = fs::read(path).unwrap();
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    assert!(reader.info().srgb.is_some(), "no sRGB chunk");
    let (color, depth) = reader.output_color_type();
    let mut raw = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut raw).unwrap();
    let samples = match depth {
        png::BitDepth::Eight => raw.into_iter().map(u16::from).collect(),
        png::BitDepth::Sixteen => {
            let (pairs, _) = raw.as_chunks::<2>();
            pairs.iter().map(|&pair| u16::from_be_bytes(pair)).collect()
        }
        other => panic!("{other:?}"),
    };
    Png {
        width: reader.info().width as usize,
        channels: color.samples(),
        samples,
    }
}

/// EV by which a middle gray of 0.18 is exposed: the 1e-6 cd/m² that are added before logarithms are taken make
/// 8.0e-6 of it, and the rounding of 0.18 to f32 the rest.
const EXPOSURE: f64 = 8.07e-6;

/// Converts `name`.exr in a folder.
fn shown(folder: &Path, name: &str, settings: &Settings<'_>) -> Png {
    let (exr, png) = (folder.join(name), folder.join("shown.png"));
    convert(&exr, &png, settings, &Unfinished::new()).unwrap();
    decode_png(&png)
}

/// The code of a radiance by the standard's formula, at EV 0 in the sRGB view.
fn code(radiance: f64, largest: f64) -> u16 {
    let light = radiance.clamp(0.0, 1.0);
    let coded = if light <= 0.0031308 {
        12.92 * light
    } else {
        1.055 * light.powf(1.0 / 2.4) - 0.055
    };
    (coded * largest).round() as u16
}

/// Holds a PNG against an EXR as OpenImageIO decodes it.
#[track_caller]
fn assert_shows(png: &Png, exr: &Decoded, largest: f64) {
    let place = |name: &str| exr.channels.iter().position(|channel| channel == name);
    let [r, g, b] = ["R", "G", "B"].map(|name| place(name).unwrap());
    let alpha = place("A");
    let [data_x, data_y, data_width, data_height] = exr.data_window;
    let [left, top, width, height] = exr.display_window;
    assert_eq!(png.width, width as usize);
    assert_eq!(png.channels, if alpha.is_some() { 4 } else { 3 });
    assert_eq!(png.samples.len(), (width * height) as usize * png.channels);
    for y in 0..height {
        for x in 0..width {
            let (column, row) = (x + left - data_x, y + top - data_y);
            let is_inside = (0..data_width).contains(&column) && (0..data_height).contains(&row);
            let mut expected = vec![0; png.channels];
            if is_inside {
                let pixel = exr.pixel(column as usize, row as usize);
                let coverage = alpha.map_or(1.0, |alpha| f64::from(pixel[alpha]));
                let divisor = if coverage > 0.0 { coverage } else { 1.0 };
                for (expected, channel) in expected.iter_mut().zip([r, g, b]) {
                    *expected = code(f64::from(pixel[channel]) / divisor, largest);
                }
                if alpha.is_some() {
                    expected[3] = (coverage * largest).round() as u16;
                }
            }
            assert_eq!(png.pixel(x as usize, y as usize), expected, "at ({x}, {y})");
        }
    }
}

/// A gradient in all channels from 0 to 1.5, with another alpha in each corner.
const GRADIENT: &str = "--pattern fill:topleft=0,0.1,0.2,1:topright=1.5,0.5,0.1,1\
:bottomleft=0.001,0.02,0.9,0.5:bottomright=0.3,1.2,0.7,0.25 70x50 4 --chnames R,G,B,A";

#[test]
fn foreign_files_are_shown_right() {
    let folder = tempfile::tempdir().unwrap();
    for (case, how) in [
        ("half, zips", "-d half --compression zips -o a.exr"),
        ("float, piz", "-d float --compression piz -o a.exr"),
        ("tiles, half", "-d half --tile 32 32 -o a.exr"),
        (
            "tiles, dwaa",
            "-d half --tile 64 64 --compression dwaa -o a.exr",
        ),
        ("dwab", "-d float --compression dwab -o a.exr"),
        ("b44a", "-d half --compression b44a -o a.exr"),
        ("pxr24", "-d float --compression pxr24 -o a.exr"),
        ("mipmaps", "-d half --tile 16 16 -otex a.exr"),
        ("no alpha", "--ch R,G,B -d half -o a.exr"),
        (
            "more channels",
            "--ch R,G,B,A,Z=0.5,P.X=0.25,light.R=9 -d float -o a.exr",
        ),
        ("mixed types", "-d R=half,G=float,B=half,A=float -o a.exr"),
        (
            "display window inside",
            "--fullsize 40x30+11+13 -d half -o a.exr",
        ),
        (
            "display window around",
            "--fullsize 100x90-10-20 -d half -o a.exr",
        ),
        (
            "overlap",
            "--fullsize 60x40+30-12 -d half --tile 32 32 -o a.exr",
        ),
        ("apart", "--fullsize 20x20+500+0 -d half -o a.exr"),
        (
            "elsewhere",
            "--origin -37-41 --fullsize 70x50-37-41 -d float -o a.exr",
        ),
    ] {
        oiiotool(folder.path(), &format!("{GRADIENT} {how}"));
        let exr = decode(&folder.path().join("a.exr"));
        for (bits, largest) in [(Bits::Eight, 255.0), (Bits::Sixteen, 65_535.0)] {
            let settings = Settings { bits, ..NEAREST };
            println!("{case}"); // Printed where the test fails.
            assert_shows(&shown(folder.path(), "a.exr", &settings), &exr, largest);
        }
    }
}

#[test]
fn integers_are_the_numbers_that_they_are() {
    let folder = tempfile::tempdir().unwrap();
    oiiotool(
        folder.path(),
        "--pattern constant:color=0,1,0.001 8x8 3 -d uint32 -o a.exr",
    );
    assert!(oiiotool(folder.path(), "--info a.exr").contains("uint openexr"));
    // 0 and two numbers far beyond the screen's white.
    assert_eq!(
        shown(folder.path(), "a.exr", &NEAREST).pixel(7, 7),
        [0, 255, 255]
    );
}

#[test]
fn the_first_part_with_rgb_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    oiiotool(
        folder.path(),
        &format!(
            "{GRADIENT} -d float -o rgb.exr --chnames X,Y,Z,W -o other.exr \
             other.exr rgb.exr --siappend other.exr --siappend -d half -o parts.exr"
        ),
    );
    oiiotool(folder.path(), "rgb.exr -d half -o single.exr");
    assert_shows(
        &shown(folder.path(), "parts.exr", &NEAREST),
        &decode(&folder.path().join("single.exr")),
        255.0,
    );
}

#[test]
fn a_file_without_rgb_says_what_it_has() {
    let folder = tempfile::tempdir().unwrap();
    for (channels, listed) in [
        ("G", "G"),
        ("A,Z", "A, Z"),
        ("light.R,light.G,light.B", "light"),
    ] {
        let count = channels.split(',').count();
        oiiotool(
            folder.path(),
            &format!("--create 8x8 {count} --chnames {channels} -o a.exr"),
        );
        let exr = folder.path().join("a.exr");
        let png = folder.path().join("a.png");
        let error = convert(&exr, &png, &NEAREST, &Unfinished::new()).unwrap_err();
        let message = error.to_string();
        let expected = format!(
            "cannot read {}: it has no channels R, G, B; it has {listed}; show one of these with \
             --layer NAME",
            exr.display()
        );
        assert_eq!(message, expected);
        assert!(!png.exists());
    }
}

#[test]
fn openimageio_encodes_the_same_srgb() {
    let folder = tempfile::tempdir().unwrap();
    oiiotool(
        folder.path(),
        &format!(
            "{GRADIENT} --ch R,G,B -d float -o a.exr \
             --colorconvert lin_rec709_scene srgb_rec709_scene -d uint8 -o theirs.png"
        ),
    );
    let ours = shown(folder.path(), "a.exr", &NEAREST);
    let theirs = decode_png(&folder.path().join("theirs.png"));
    assert_eq!(ours.samples.len(), theirs.samples.len());
    for (&ours, &theirs) in ours.samples.iter().zip(&theirs.samples) {
        // OpenColorIO's curve is a smoothed one, and its rounding its own.
        assert!(ours.abs_diff(theirs) <= 1, "{ours} {theirs}");
    }
}

#[test]
fn exposure_and_views() {
    let folder = tempfile::tempdir().unwrap();
    oiiotool(
        folder.path(),
        "--pattern constant:color=0.045,0.25,4 8x8 3 -d float -o a.exr",
    );
    let settings = |exposure, view| Settings {
        exposure,
        view,
        ..NEAREST
    };
    let pixel = |settings| {
        shown(folder.path(), "a.exr", &settings)
            .pixel(0, 0)
            .to_vec()
    };
    let codes = |light: [f64; 3]| light.map(|light| code(light, 255.0));
    assert_eq!(
        pixel(settings(Exposure::Ev(2.0), View::Srgb)),
        codes([0.18, 1.0, 16.0])
    );
    assert_eq!(
        pixel(settings(Exposure::Ev(-1.5), View::Reinhard)),
        codes([0.045, 0.25, 4.0].map(|x| {
            let exposed = x * 0.5_f64.powf(1.5);
            exposed / (1.0 + exposed)
        }))
    );
    let luminance: f64 = 0.2126390 * 0.045 + 0.7151687 * 0.25 + 0.0721923 * 4.0;
    assert_eq!(
        pixel(settings(Exposure::Auto, View::Srgb)),
        codes([0.045, 0.25, 4.0].map(|x| x * 0.18 / luminance))
    );
}

#[test]
fn warnings() {
    let folder = tempfile::tempdir().unwrap();
    let warnings = |how: &str| {
        oiiotool(folder.path(), &format!("{GRADIENT} {how} -o a.exr"));
        let exr = folder.path().join("a.exr");
        let png = folder.path().join("a.png");
        convert(&exr, &png, &NEAREST, &Unfinished::new())
            .unwrap()
            .warnings
    };
    assert!(warnings("").is_empty());
    assert!(warnings("--attrib colorInteropID lin_rec709_scene").is_empty());
    assert!(warnings("--attrib colorInteropID lin_ap1_scene").is_empty());
    assert_eq!(
        warnings("--attrib colorInteropID g22_rec709_tx"),
        [
            "the file's color space is `g22_rec709_tx`; it is shown as linear Rec.709, without conversion"
        ]
    );
    let chromaticities = "--attrib:type=float[8] chromaticities";
    assert!(
        warnings(&format!(
            "{chromaticities} .64,.33,.3,.6,.15,.06,.3127,.329"
        ))
        .is_empty()
    );
    let ap1 = format!("{chromaticities} .713,.293,.165,.83,.128,.044,.32168,.33767");
    assert!(warnings(&ap1).is_empty());
    let collapsed = warnings(&format!("{chromaticities} .6,.3,.6,.3,.6,.3,.3127,.329"));
    assert!(collapsed[0].contains("R (0.6000, 0.3000)"), "{collapsed:?}");
}

/// A spectral scene is the same picture in every working space, from the film and from the file; a
/// rounding may take a code to its neighbor.
#[test]
fn working_spaces_are_shown_alike() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Scene::load("scenes/metamers.toml").unwrap();
    let mut pictures: Vec<Vec<u8>> = Vec::new();
    for space in ColorSpace::ALL {
        let mut scene = at_width(scene.clone(), 128);
        scene.image.color_space.value = space;
        let film = film_of(&scene, 1);
        let exr = folder.path().join("a.exr");
        film.write_exr(&exr, &ExrOptions::default(), &Unfinished::new())
            .unwrap();
        let settings = NEAREST;
        let of_film = tonemap(&Picture::of_film(&film), &settings);
        let of_file = tonemap(&Picture::new(read(&exr).unwrap()), &settings);
        assert_eq!(of_film.samples(), of_file.samples(), "{}", space.name());
        pictures.push(of_file.samples().to_vec());
    }
    for picture in &pictures[1..] {
        let pairs = picture.iter().zip(&pictures[0]);
        let largest = pairs.map(|(&a, &b)| a.abs_diff(b)).max();
        assert!(largest <= Some(1), "{largest:?}");
    }
}

/// An EXR of these pixels in one row, uncompressed.
fn exr_of(pixels: &[[f32; 4]]) -> Vec<u8> {
    let width = pixels.len() as u32;
    let window = Window {
        x: 0,
        y: 0,
        width,
        height: 1,
    };
    let metadata = Metadata {
        color_space: ColorSpace::Rec709,
        world_to_camera: [[0.0; 4]; 4],
        world_to_ndc: [[0.0; 4]; 4],
        provenance: Vec::new(),
        numbers: Vec::new(),
    };
    let film = Film::new([width, 1], window, pixels.to_vec(), metadata);
    let options = ExrOptions {
        compression: Compression::None,
        ..ExrOptions::default()
    };
    let mut file = Cursor::new(Vec::new());
    film.write_exr_to(&mut file, &options).unwrap();
    file.into_inner()
}

/// A library user need not go over a file.
#[test]
fn a_film_is_shown_as_its_file_is() {
    let film = film_of(&Scene::builtin(), 1);
    let folder = tempfile::tempdir().unwrap();
    let exr = folder.path().join("film.exr");
    film.write_exr(&exr, &ExrOptions::default(), &Unfinished::new())
        .unwrap();
    let settings = NEAREST;
    let from_file = tonemap(&Picture::new(read(&exr).unwrap()), &settings);
    assert_eq!(tonemap(&Picture::of_film(&film), &settings), from_file);
}

#[test]
fn values_that_are_no_numbers_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let (exr, png) = (folder.path().join("a.exr"), folder.path().join("a.png"));
    let pixels = [
        [f32::NAN, 1.0, f32::INFINITY, 1.0],
        [f32::INFINITY, f32::NEG_INFINITY, 0.0, 1.0],
        [0.18, 0.18, 0.18, f32::NAN],
        [0.09, 0.09, 0.09, 0.5],
    ];
    fs::write(&exr, exr_of(&pixels)).unwrap();
    let settings = Settings {
        exposure: Exposure::Auto,
        alpha: Alpha::Keep,
        ..NEAREST
    };
    let report = convert(&exr, &png, &settings, &Unfinished::new()).unwrap();
    assert_eq!(
        report.warnings,
        [
            "2 pixels have values that are not a number; these are shown as 0",
            "2 pixels have infinite values; these are shown as white, or black below 0",
        ]
    );
    // Only the last pixel, a middle gray, has a luminance and coverage.
    let mut of_exposure = Measured::new("EV of middle gray", EXPOSURE);
    of_exposure.see(report.ev.abs(), || report.ev.to_string());
    of_exposure.judge();
    let gray = code(0.18, 255.0);
    assert_eq!(
        decode_png(&png).samples,
        [
            [0, 255, 255, 255],
            [255, 0, 0, 255],
            [gray, gray, gray, 0],
            [gray, gray, gray, 128]
        ]
        .concat()
    );
}

#[test]
fn opaque_drops_alpha() {
    let folder = tempfile::tempdir().unwrap();
    oiiotool(folder.path(), &format!("{GRADIENT} -d float -o a.exr"));
    oiiotool(folder.path(), "a.exr --ch R,G,B -o b.exr");
    let settings = Settings {
        alpha: Alpha::Opaque,
        ..NEAREST
    };
    assert_eq!(
        shown(folder.path(), "a.exr", &settings),
        shown(folder.path(), "b.exr", &NEAREST)
    );
}

#[test]
fn same_png_for_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    oiiotool(folder.path(), &format!("{GRADIENT} -d half -o a.exr"));
    let settings = Settings {
        exposure: Exposure::Auto,
        view: View::Reinhard,
        ..NEAREST
    };
    let png = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| shown(folder.path(), "a.exr", &settings));
        fs::read(folder.path().join("shown.png")).unwrap()
    };
    let one = png(1);
    assert!(png(2) == one && png(7) == one);
}

/// Puts another value for an attribute into an EXR.
fn with_attribute(exr: &[u8], name: &str, value: &[i32]) -> Vec<u8> {
    // Name, kind and length come before the value.
    let start = exr
        .windows(name.len() + 1)
        .position(|bytes| bytes == [name.as_bytes(), &[0]].concat())
        .unwrap();
    let kind = start + name.len() + 1;
    let kind_length = exr[kind..].iter().position(|&byte| byte == 0).unwrap();
    let mut place = kind + kind_length + 1 + 4;
    let mut exr = exr.to_vec();
    for number in value {
        exr[place..place + 4].copy_from_slice(&number.to_le_bytes());
        place += 4;
    }
    exr
}

#[test]
fn claims_that_no_data_backs_are_errors() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let exr = exr_of(&[[0.5; 4]; 16]);
    let problem = |bytes: &[u8]| {
        fs::write(&path, bytes).unwrap();
        let error = read(&path).unwrap_err();
        assert!(error.to_string().contains("a.exr: "), "{error}");
        error.problem
    };
    const FAR: i32 = (1 << 30) - 2;
    for (what, bytes) in [
        ("wide", with_attribute(&exr, "dataWindow", &[0, 0, FAR, 0])),
        ("high", with_attribute(&exr, "dataWindow", &[0, 0, 15, FAR])),
        (
            "huge",
            with_attribute(&exr, "dataWindow", &[-FAR, -FAR, FAR, FAR]),
        ),
        ("no compression", with_attribute(&exr, "compression", &[77])),
        ("block 0", {
            let mut bytes = exr.clone();
            let table = bytes.len() - 16 * 16 - 8 - 8;
            bytes[table..table + 8].fill(0);
            bytes
        }),
        ("block at the end", {
            let mut bytes = exr.clone();
            let table = bytes.len() - 16 * 16 - 8 - 8;
            let length = bytes.len() as u64;
            bytes[table..table + 8].copy_from_slice(&length.to_le_bytes());
            bytes
        }),
    ] {
        let problem = problem(&bytes);
        assert!(
            matches!(problem, ExrProblem::Damaged(_)),
            "{what}: {problem}"
        );
    }
    for [right, bottom] in [[1 << 20, 1 << 20], [1 << 20, 0], [0, 1 << 20]] {
        let sparse = with_attribute(&exr, "displayWindow", &[0, 0, right, bottom]);
        assert!(matches!(problem(&sparse), ExrProblem::TooLarge(..)));
    }
    for [right, bottom] in [[(1 << 20) - 1, 0], [0, (1 << 20) - 1], [16383, 16383]] {
        let sparse = with_attribute(&exr, "displayWindow", &[0, 0, right, bottom]);
        fs::write(folder.path().join("sparse.exr"), sparse).unwrap();
        let resolution = read(&folder.path().join("sparse.exr")).unwrap().resolution;
        assert_eq!(resolution, [right, bottom].map(|last| last as u32 + 1));
    }
    for other in ["", "P", "\x76\x2f\x31", "not an EXR, but text"] {
        assert!(matches!(problem(other.as_bytes()), ExrProblem::NotExr));
    }
    for end in 4..exr.len() {
        let problem = problem(&exr[..end]);
        assert!(
            matches!(problem, ExrProblem::Damaged(_)),
            "{end}: {problem}"
        );
    }
    assert!(matches!(
        read(folder.path()).unwrap_err().problem,
        ExrProblem::Io(_)
    ));
    assert!(matches!(
        read(&folder.path().join("none.exr")).unwrap_err().problem,
        ExrProblem::Io(_)
    ));
}

/// Damaged copies of each file; ten thousands of them were tried when this was written.
const DAMAGED_COPIES: usize = 60;

#[test]
fn damaged_files_give_a_picture_or_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let (path, damaged) = (folder.path().join("a.exr"), folder.path().join("b.exr"));
    let mut state = 1_u64;
    let mut random = |below: usize| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    let (mut pictures, mut errors) = (0, 0);
    for compression in [
        "none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab",
    ] {
        for tiles in ["", "--tile 32 32"] {
            let how = format!("-d half --compression {compression} {tiles} -o a.exr");
            oiiotool(folder.path(), &format!("{GRADIENT} {how}"));
            let whole = fs::read(&path).unwrap();
            for _ in 0..DAMAGED_COPIES {
                let mut copy = whole.clone();
                for _ in 0..1 + random(4) {
                    // As often in the header as in all of the file.
                    let below = if random(2) == 0 { 600 } else { copy.len() };
                    copy[random(below)] = [0, 1, 0x7f, 0x80, 0xff][random(5)];
                }
                fs::write(&damaged, &copy).unwrap();
                match read(&damaged) {
                    Ok(_) => pictures += 1,
                    Err(_) => errors += 1,
                }
            }
        }
    }
    assert!(pictures > 100 && errors > 100, "{pictures} {errors}");
}

#[test]
fn the_old_png_stays_if_there_is_no_new_one() {
    let folder = tempfile::tempdir().unwrap();
    let (exr, png) = (folder.path().join("a.exr"), folder.path().join("a.png"));
    fs::write(&png, "old").unwrap();
    fs::write(&exr, "no EXR").unwrap();
    let convert_to = |png: &Path| convert(&exr, png, &NEAREST, &Unfinished::new());
    assert!(matches!(convert_to(&png), Err(DisplayError::Decode(_))));

    fs::write(&exr, exr_of(&[[0.5; 4]])).unwrap();
    let missing = folder.path().join("none").join("a.png");
    match convert_to(&missing) {
        Err(DisplayError::Write(error)) => {
            assert!(matches!(error.problem, OutputProblem::MissingFolder(_)));
        }
        other => panic!("{other:?}"),
    }
    let unfinished = Unfinished::new();
    unfinished.cancel();
    assert!(convert(&exr, &png, &NEAREST, &unfinished).is_err());
    assert_eq!(fs::read_to_string(&png).unwrap(), "old");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}
