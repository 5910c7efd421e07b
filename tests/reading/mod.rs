//! EXR files as other programs have them: which channels, in which colors, and what is said where they
//! are not shown; and pictures of other formats.

mod brightness;
mod channels;
mod chroma;
mod color;
mod file;
mod layers;
mod limits;
mod pictures;
mod pipes;
mod tiffs;

use std::fs;
use std::io::Cursor;
use std::path::Path;

use candela::display::{Dither, Input, Report, Settings, convert_input};
use candela::output::Unfinished;

/// Without dither: every value becomes the nearest code.
const NEAREST: Settings<'static> = Settings {
    dither: Dither::None,
    ..Settings::new()
};

/// A PNG of 8 bits: its pixels as they are stored.
struct Shown {
    report: Report,
    pixels: Vec<Vec<u8>>,
    /// Pixels to a unit, beside and below each other.
    dimensions: Option<[u32; 2]>,
}

/// What `candela tonemap` makes of a file, or of a layer of it; the message where it makes nothing.
fn shown(exr: &Path, layer: Option<&str>, settings: &Settings<'_>) -> Result<Shown, String> {
    let png = exr.with_extension("png");
    let input = Input::open(exr, layer).map_err(|error| error.to_string())?;
    let report = convert_input(&input, &png, settings, &Unfinished::new());
    let report = report.map_err(|error| error.to_string())?;
    let bytes = fs::read(&png).unwrap();
    let mut decoder = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    let mut samples = vec![0; decoder.output_buffer_size().unwrap()];
    decoder.next_frame(&mut samples).unwrap();
    let info = decoder.info();
    assert_eq!([info.width, info.height], report.resolution);
    let channels = info.color_type.samples();
    let dimensions = info.pixel_dims.map(|dims| [dims.xppu, dims.yppu]);
    Ok(Shown {
        report,
        pixels: samples.chunks(channels).map(<[u8]>::to_vec).collect(),
        dimensions,
    })
}

/// Holds pixels against what they should be, to within one code.
#[track_caller]
fn assert_pixels(shown: &Shown, expected: &[[u8; 3]]) {
    assert_eq!(shown.pixels.len(), expected.len());
    for (found, expected) in shown.pixels.iter().zip(expected) {
        let close = found.iter().zip(expected).all(|(a, b)| a.abs_diff(*b) <= 1);
        assert!(close, "{:?}, not {expected:?}", shown.pixels);
    }
}
