//! How bright a picture is: what a PNG in PQ says of itself, and what is remarked under each view and on each screen.

use std::fs;
use std::io::Cursor;

use candela::display::{Bits, Screen, Settings, View, convert};
use candela::output::Unfinished;

use super::file::{Part, channel, row, write};
use super::{NEAREST, shown};

/// What a viewer is told, in cd/m²: MaxCLL and MaxFALL.
fn content_light(png: &[u8]) -> Option<[f64; 2]> {
    let reader = png::Decoder::new(Cursor::new(png)).read_info().unwrap();
    let told = reader.info().content_light_level?;
    let levels = [
        told.max_content_light_level,
        told.max_frame_average_light_level,
    ];
    Some(levels.map(|level| f64::from(level) / 1e4))
}

/// A light of 1 is 203 cd/m² (ITU-R BT.2408); the mean is that of the whole picture, half of which has no data.
#[test]
fn pictures_in_pq_say_how_bright_they_are() {
    const LIGHT: [f32; 4] = [0.0, 1.0, 2.0, 10.0];
    let folder = tempfile::tempdir().unwrap();
    let part = Part {
        data: [0, 1, 3, 2],
        display: [0, 0, 3, 3],
        ..row(4, vec![channel("Y", |x, _| LIGHT[x as usize])])
    };
    let exr = write(folder.path(), &[part]);
    let made = |screen, bits, threads| {
        let settings = Settings {
            screen,
            bits,
            ..NEAREST
        };
        let png = folder.path().join("a.png");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let convert = || convert(&exr, &png, &settings, &Unfinished::new());
        pool.build().unwrap().install(convert).unwrap();
        fs::read(png).unwrap()
    };
    // Half a code at 2030 cd/m²: 65 535 of them for a range in which light grows by about e¹⁰.
    for (bits, tolerance) in [(Bits::Sixteen, 0.2), (Bits::Eight, 40.0)] {
        let png = made(Screen::Rec2020Pq, bits, 1);
        let [brightest, average] = content_light(&png).unwrap();
        assert!((brightest - 2030.0).abs() < tolerance, "{brightest}");
        let expected = (203.0 + 406.0 + 2030.0) * 2.0 / 16.0;
        assert!((average - expected).abs() < tolerance / 8.0, "{average}");
        assert_eq!(made(Screen::Rec2020Pq, bits, 3), png);
        // All checksums are right, and so are the pixels.
        assert!(image::load_from_memory(&png).is_ok());
    }
    for screen in Screen::ALL {
        if screen != Screen::Rec2020Pq {
            assert_eq!(content_light(&made(screen, Bits::Sixteen, 1)), None);
        }
    }
}

/// What is said goes by what can be seen, and what has a code.
#[test]
fn remarks_go_by_the_view_and_the_screen() {
    let folder = tempfile::tempdir().unwrap();
    let remarks = |value: f32, view, screen| {
        let part = row(2, vec![channel("Y", move |x, _| value * x as f32)]);
        let settings = Settings {
            view,
            screen,
            ..NEAREST
        };
        let path = write(folder.path(), &[part]);
        let remarks = shown(&path, None, &settings).unwrap().report.remarks();
        remarks.concat()
    };
    for (value, view, screen, expected) in [
        (0.01, View::FalseColor, Screen::Srgb, ""),
        (1e6, View::FalseColor, Screen::Srgb, ""),
        (
            0.0,
            View::FalseColor,
            Screen::Srgb,
            "the picture is black: no pixel has any light",
        ),
        // Of 80 cd/m², 2 % are 1.6.
        (1.0, View::Srgb, Screen::Srgb, ""),
        (
            1.0,
            View::Absolute,
            Screen::Srgb,
            "the picture is black: its brightest pixel has a luminance of 1, where the screen's white is 80; \
             try --exposure 6",
        ),
        (
            100.0,
            View::Absolute,
            Screen::Srgb,
            "50 % of the picture is brighter than the screen and clips; try a larger --white-nits, a lower \
             --exposure, or another --view",
        ),
        (100.0, View::Absolute, Screen::Rec2020Pq, ""),
        // 49 times diffuse white on one screen, and 4.9 times on the other.
        (10.0, View::Srgb, Screen::Rec2020Pq, ""),
        (
            10.0,
            View::Srgb,
            Screen::Rec2020Hlg,
            "50 % of the picture is brighter than the screen and clips; try --auto-exposure, a lower --exposure, \
             or --view reinhard",
        ),
        (0.5, View::Raw, Screen::Srgb, ""),
        (
            0.1,
            View::Raw,
            Screen::Srgb,
            "the picture is black: its numbers, as code values, are all close to 0; try --exposure 3",
        ),
        (
            2.0,
            View::Raw,
            Screen::Srgb,
            "50 % of the picture has numbers above 1, the largest code value, and clips; try a lower --exposure",
        ),
        (1e6, View::Reinhard, Screen::Srgb, ""),
        (
            0.001,
            View::Reinhard,
            Screen::Srgb,
            "the picture is black: its brightest pixel has a luminance of 0.001, which the view `reinhard` \
             shows as black; try --auto-exposure",
        ),
    ] {
        let found = remarks(value, view, screen);
        assert_eq!(found, expected, "{value}, {view}, {}", screen.name());
    }
}
