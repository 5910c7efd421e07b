//! `candela tonemap --view false-color`: units, lines and the legend.

use std::fs;
use std::io::Cursor;
use std::path::Path;

use candela::exr::{DataWindow, write_planes};
use candela::output::Unfinished;
use tempfile::TempDir;

use super::{candela, fails, output, succeeds, text};

const WIDTH: usize = 300;
const HEIGHT: usize = 200;

/// An EXR whose layer `irradiance` is 10 lx at the left edge and 10 lx more for each pixel to the right; nothing covers the
/// ten rows at the bottom.
fn ramp() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let window = DataWindow {
        resolution: [WIDTH as u32, HEIGHT as u32],
        corner: [0, 0],
        size: [WIDTH as u32, HEIGHT as u32],
    };
    let covered = |place: usize| place / WIDTH < HEIGHT - 10;
    let lux: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|place| {
            if covered(place) {
                10.0 * ((place % WIDTH) as f32 + 0.5)
            } else {
                0.0
            }
        })
        .collect();
    let alpha: Vec<f32> = (0..WIDTH * HEIGHT)
        .map(|place| f32::from(u8::from(covered(place))))
        .collect();
    let planes: [(&str, &[f32]); 5] = [
        ("A", &alpha),
        ("B", &alpha),
        ("G", &alpha),
        ("R", &alpha),
        ("irradiance", &lux),
    ];
    write_planes(
        &folder.path().join("ramp.exr"),
        window,
        &planes,
        &Unfinished::new(),
    )
    .unwrap();
    folder
}

/// Rows of R, G, B, A in 16 bits.
fn png(path: &Path) -> Vec<Vec<[u16; 4]>> {
    let bytes = fs::read(path).unwrap();
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    let (color, depth) = reader.output_color_type();
    assert_eq!(color, png::ColorType::Rgba);
    let mut raw = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut raw).unwrap();
    let samples: Vec<u16> = match depth {
        png::BitDepth::Eight => raw.iter().map(|&code| u16::from(code) * 257).collect(),
        _ => {
            let (pairs, _) = raw.as_chunks::<2>();
            pairs.iter().map(|&pair| u16::from_be_bytes(pair)).collect()
        }
    };
    let (pixels, _) = samples.as_chunks::<4>();
    let width = reader.info().width as usize;
    pixels.chunks(width).map(<[_]>::to_vec).collect()
}

const LUX: &str = "tonemap ramp.exr --view false-color=10:10000 --unit lx --dither none";

/// 1000 lx are at x = 100 of the ramp.
#[test]
fn a_line_is_where_its_value_is() {
    let folder = ramp();
    let folder = folder.path();
    for bits in ["8", "16"] {
        succeeds(
            folder,
            &format!("{LUX} --bits {bits} --legend none -o plain.png"),
        );
        succeeds(
            folder,
            &format!("{LUX} --bits {bits} --legend none --iso-lines 1000 -o lines.png"),
        );
        let (plain, lines) = (
            png(&folder.join("plain.png")),
            png(&folder.join("lines.png")),
        );
        assert_eq!([lines[0].len(), lines.len()], [WIDTH, HEIGHT]);
        let mut unlabeled = 0;
        for (before, after) in plain.iter().zip(&lines).take(HEIGHT - 11) {
            let changed: Vec<usize> = (0..WIDTH).filter(|&x| before[x] != after[x]).collect();
            if changed == [99, 100] {
                unlabeled += 1;
            }
            assert!(changed.iter().all(|x| (85..115).contains(x)), "{changed:?}");
        }
        assert!(unlabeled > 100, "{unlabeled}");
        // Where nothing is, there is no color and no line.
        for row in &lines[HEIGHT - 10..] {
            assert!(row.iter().all(|pixel| pixel[3] == 0));
        }
    }
}

/// The mark of 100 lx is where the bar has the color of 100 lx, and the picture is as it was.
#[test]
fn the_legend_is_beside_the_picture() {
    let folder = ramp();
    let folder = folder.path();
    let lux = LUX.replace("=10:10000", "=10:1000");
    succeeds(folder, &format!("{lux} --legend none -o plain.png"));
    succeeds(folder, &format!("{lux} -o legend.png"));
    succeeds(folder, &format!("{lux} --iso-lines 100 -o marked.png"));
    let [plain, legend, marked] =
        ["plain.png", "legend.png", "marked.png"].map(|name| png(&folder.join(name)));
    assert_eq!(legend.len(), HEIGHT);
    assert!(legend[0].len() > WIDTH + 30 && marked[0].len() > WIDTH + 30);
    for (with, without) in legend.iter().zip(&plain) {
        assert_eq!(&with[..WIDTH], &without[..]);
        assert!(with[WIDTH..].iter().all(|pixel| pixel[3] == u16::MAX));
    }
    // The bar begins after its margin; pixel 10 of the ramp has 105 lx, pixel 9 has 95.
    let bar = WIDTH + 12;
    let off = |color: [u16; 4]| {
        (0..3)
            .map(|c| i64::from(color[c].abs_diff(plain[50][9][c])))
            .sum::<i64>()
    };
    let near = (0..HEIGHT)
        .min_by_key(|&row| off(legend[row][bar]))
        .unwrap();
    let changed: Vec<usize> = (0..HEIGHT)
        .filter(|&row| legend[row][bar] != marked[row][bar])
        .collect();
    assert!(!changed.is_empty() && changed.len() <= 3, "{changed:?}");
    assert!(
        changed.iter().all(|row| row.abs_diff(near) <= 3),
        "{changed:?}, {near}"
    );
}

#[test]
fn the_range_is_chosen_and_said() {
    let folder = ramp();
    let folder = folder.path();
    let chosen = output(
        folder,
        "tonemap ramp.exr --view false-color --unit lx --iso-lines auto -o a.png",
    );
    assert_eq!(text(&chosen.stderr), "range: 10 to 5000 lx\n");
    // The PNG says how it is made again.
    let bytes = String::from_utf8_lossy(&fs::read(folder.join("a.png")).unwrap()).into_owned();
    let start = bytes.find("candela tonemap --layer").unwrap();
    let command = &bytes[start..][..bytes[start..].find("--legend beside").unwrap() + 15];
    assert!(
        command.contains("--view false-color=10:5000 --unit lx"),
        "{command}"
    );
    let again = command
        .trim_start_matches("candela ")
        .replace("tonemap", "tonemap ramp.exr -o b.png");
    succeeds(folder, &again);
    assert!(fs::read(folder.join("a.png")).unwrap() == fs::read(folder.join("b.png")).unwrap());
    // A TIFF has the same size.
    succeeds(
        folder,
        "tonemap ramp.exr --view false-color --unit lx --iso-lines auto -o a.tif",
    );
    assert!(fs::metadata(folder.join("a.tif")).unwrap().len() > (4 * WIDTH * HEIGHT) as u64);
}

#[test]
fn threads_change_nothing() {
    let folder = ramp();
    let folder = folder.path();
    let made = ["1", "4"].map(|threads| {
        let arguments = "tonemap ramp.exr --view false-color --unit lx --iso-lines auto -o a.png";
        let status = candela(folder, arguments)
            .env("RAYON_NUM_THREADS", threads)
            .output()
            .unwrap();
        assert!(status.status.success());
        fs::read(folder.join("a.png")).unwrap()
    });
    assert!(made[0] == made[1]);
}

#[test]
fn what_is_wrong_is_said() {
    let folder = ramp();
    let folder = folder.path();
    for (options, said) in [
        (
            "--unit lx",
            "--unit is of false colors: add --view false-color",
        ),
        (
            "--iso-lines 5",
            "--iso-lines is of false colors: add --view false-color",
        ),
        (
            "--view false-color --unit lumen",
            "possible values: stops, nits, lx",
        ),
        (
            "--view false-color --iso-lines 100",
            "add --unit nits or --unit lx",
        ),
        (
            "--view false-color --unit lx --iso-lines 100,bright",
            "`bright` is not a number",
        ),
        (
            "--view false-color --unit lx --iso-lines 0,100",
            "the scale is logarithmic and has no 0",
        ),
        (
            "--view false-color --unit lx --iso 100,200",
            "lines of equal light are --iso-lines",
        ),
        (
            "--view false-color=1:9 --unit stops",
            "--unit nits or --unit lx",
        ),
        (
            "--view false-color --unit lx --white-balance A",
            "--white-balance changes luminances",
        ),
    ] {
        let message = fails(folder, &format!("tonemap ramp.exr {options} -o x.png"), 2);
        assert!(message.contains(said), "{options}: {message}");
    }
    let planes: [(&str, &[f32]); 3] = ["B", "G", "R"].map(|name| (name, &[1.0_f32][..]));
    let window = DataWindow {
        resolution: [1, 1],
        corner: [0, 0],
        size: [1, 1],
    };
    write_planes(
        &folder.join("plain.exr"),
        window,
        &planes,
        &Unfinished::new(),
    )
    .unwrap();
    let lux = "--view false-color --unit lx -o x.png";
    let message = fails(folder, &format!("tonemap plain.exr {lux}"), 1);
    assert!(
        message.contains("render it with --layers irradiance"),
        "{message}"
    );
    succeeds(folder, "tonemap ramp.exr -o code.png");
    let message = fails(folder, &format!("tonemap code.png {lux}"), 1);
    assert!(
        message.contains("has no layers; leave --unit lx away"),
        "{message}"
    );
}
