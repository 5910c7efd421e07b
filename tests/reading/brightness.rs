//! How bright a picture is: what a PNG in PQ says of itself.

use std::fs;
use std::io::Cursor;

use candela::display::{Bits, Screen, Settings, convert};
use candela::output::Unfinished;

use super::NEAREST;
use super::file::{Part, channel, row, write};

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
