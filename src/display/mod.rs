//! From radiance to a picture on a screen.
//!
//! ```text
//! input ─ picture ─ exposure ─ view ─ transfer ─ quantize ─ PNG, TIFF
//!  │      │          │         │        │          │
//!  │      │          │         │        │          2⁸ codes, dithered, 2¹⁶, or none: floats
//!  │      │          │         │        light 0 to 1 → sRGB code value 0 to 1
//!  │      │          │         radiance 0 to ∞ → light 0 to 1
//!  │      │          × 2^EV, given or from the log-average luminance
//!  │      display window of R, G, B, A; NaN → 0; RGB ÷ A where alpha is kept
//!  OpenEXR, row by row; PNG, JPEG, TIFF, Radiance HDR, as a whole
//! ```
//!
//! All of it is computed in f64, each pixel by itself, sixteen side by side: the same picture gives the
//! same file, to the byte, for any number of threads and instruction set.

mod coded;
mod content_light;
mod develop;
mod dither;
#[doc(hidden)]
pub mod exposure;
mod field;
mod format;
mod gamut;
mod input;
mod lanes;
mod overlay;
mod picture;
mod png;
mod provenance;
mod report;
mod screen;
mod source;
mod stream;
mod tags;
mod thumbnail;
mod tiff;
mod view;

use rayon::prelude::*;

use develop::Develop;
pub use dither::Dither;
pub use exposure::Exposure;
#[doc(hidden)]
pub use field::Field;
#[doc(hidden)]
pub use format::OutputFormat;
pub use gamut::Gamut;
#[doc(hidden)]
pub use input::Input;
pub use overlay::{Drawn, Overlay};
#[doc(hidden)]
pub use picture::Picture;
pub use report::Report;
#[doc(hidden)]
pub use report::{LOOKS_BLACK, MANY_CLIPPED, digits, shown_exposure};
pub use screen::Screen;
pub use stream::convert;
#[doc(hidden)]
pub use stream::{convert_image, convert_input};
#[doc(hidden)]
pub use tags::{ContentLight, Mastering, Tags};
#[doc(hidden)]
pub use thumbnail::Thumbnail;
#[doc(hidden)]
pub use view::UnknownView;
pub use view::{BadRange, Cube, CubeError, CubeFault, CubeProblem, FalseColor, Measure, View};

use crate::color::Primaries;
use crate::exr::ExrError;
use crate::image_file::ImageFileError;
use crate::memory::OutOfMemory;
use crate::output::OutputError;

/// How a picture is shown. The default: as it is, sRGB, 8 bits, with its alpha.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings<'a> {
    /// What the radiance is multiplied by.
    pub exposure: Exposure,
    /// How radiance becomes light on the screen.
    pub view: View,
    /// Bits of each sample.
    pub bits: Bits,
    /// What becomes of coverage.
    pub alpha: Alpha,
    /// How light between two codes of 8 bits is shown.
    pub dither: Dither,
    /// What of a file's windows is shown; pictures in memory are their display window.
    pub frame: Frame,
    /// What the picture is shown on.
    pub screen: Screen,
    /// The luminance of a light of 1 on the screen in cd/m², where it is not [`Screen::white`]. Range: above 0, at
    /// most 10 000.
    pub white_luminance: Option<f64>,
    /// The chromaticity (x, y) of what is to look white; `None` leaves colors as they are.
    pub white: Option<[f64; 2]>,
    /// What becomes of colors that the screen cannot mix.
    pub gamut: Gamut,
    /// The primaries of the file's numbers, instead of those that the file names.
    pub input: Option<Primaries>,
    /// Whether pixels with values that are not a number are shown in magenta, and those with infinities in cyan.
    pub shows_invalid: bool,
    /// What [`View::FalseColor`] shows.
    pub false_color: FalseColor,
    /// The table of [`View::Cube`], which shows the picture as it is where there is none.
    pub cube: Option<&'a Cube>,
    /// What is drawn over and beside the picture.
    pub drawn: Drawn<'a>,
}

impl Settings<'_> {
    /// The default, for constants.
    pub const fn new() -> Self {
        Self {
            exposure: Exposure::Ev(0.0),
            view: View::Srgb,
            bits: Bits::Eight,
            alpha: Alpha::Auto,
            dither: Dither::Blue,
            frame: Frame::Display,
            screen: Screen::Srgb,
            white_luminance: None,
            white: None,
            gamut: Gamut::Clip,
            input: None,
            shows_invalid: false,
            false_color: FalseColor::STOPS,
            cube: None,
            drawn: Drawn::NOTHING,
        }
    }
}

impl Default for Settings<'_> {
    fn default() -> Self {
        Self::new()
    }
}

/// What of an EXR's windows is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Frame {
    /// All of the display window, black where there is no data.
    #[default]
    Display,
    /// The data window, such as the part of an image that was rendered. A part is shown as it is in the
    /// whole, to the code, where the exposure is the same.
    Data,
}

/// Bits of each sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bits {
    /// 256 codes.
    #[default]
    Eight,
    /// 65 536 codes.
    Sixteen,
    /// Code values as floats, 1 for full light; nothing is rounded to codes, and nothing clips. For TIFF.
    ThirtyTwo,
}

impl Bits {
    /// Every choice, in the order of the documentation.
    pub const ALL: [Self; 3] = [Self::Eight, Self::Sixteen, Self::ThirtyTwo];

    /// The number on the command line.
    pub const fn number(self) -> u8 {
        match self {
            Self::Eight => 8,
            Self::Sixteen => 16,
            Self::ThirtyTwo => 32,
        }
    }

    const fn bytes(self) -> usize {
        self.number() as usize / 8
    }
}

/// The nearest code of a value from 0 to 1, of 8 bits; values outside clip.
fn code_of_8(value: f64) -> u8 {
    // `as` saturates, and rounds down what has half a code added.
    (value * f64::from(u8::MAX) + 0.5) as u8
}

/// As [`code_of_8`], of 16 bits.
fn code_of_16(value: f64) -> u16 {
    (value * f64::from(u16::MAX) + 0.5) as u16
}

/// What becomes of the picture's coverage A.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Alpha {
    /// As [`Alpha::Keep`], unless there is light where A is 0, as with a background: a PNG cannot
    /// hold that beside its alpha, so the picture is then [`Alpha::Opaque`].
    #[default]
    Auto,
    /// It becomes the PNG's alpha, and RGB is divided by it, since PNG's is not premultiplied.
    /// Where A is 0, the color stays as it is. A picture without A gives a PNG without alpha.
    Keep,
    /// The PNG has no alpha and shows the premultiplied light as it is: the picture over black.
    Opaque,
}

impl Alpha {
    /// Every choice, in the order of the documentation.
    pub const ALL: [Self; 3] = [Self::Auto, Self::Keep, Self::Opaque];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::Keep => "keep",
            Self::Opaque => "opaque",
        }
    }
}

/// An sRGB-coded picture, ready for a PNG.
#[derive(Clone, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub struct Image {
    resolution: [u32; 2],
    has_alpha: bool,
    bits: Bits,
    /// Row by row from the top, R, G, B and A where there is alpha; 16 bits have the high byte
    /// first, as in a PNG; floats are in the machine's order.
    samples: Vec<u8>,
}

impl Image {
    /// An opaque picture of sRGB-coded pixels in 8 bits, row by row from the top.
    ///
    /// # Panics
    /// If the pixels are not as many as the resolution has.
    pub fn opaque(resolution: [u32; 2], pixels: Vec<[u8; 3]>) -> Self {
        let [width, height] = resolution.map(|side| side as usize);
        assert_eq!(pixels.len(), width * height);
        Self {
            resolution,
            has_alpha: false,
            bits: Bits::Eight,
            samples: pixels.into_flattened(),
        }
    }

    /// Lays something over the picture.
    pub fn lay(&mut self, overlay: &Overlay) {
        let row_bytes = self.resolution[0] as usize * self.pixel_bytes();
        for (y, row) in (0..).zip(self.samples.chunks_exact_mut(row_bytes.max(1))) {
            overlay.lay_on_row(y, row, self.bits, self.has_alpha);
        }
    }

    fn pixel_bytes(&self) -> usize {
        (3 + usize::from(self.has_alpha)) * self.bits.bytes()
    }

    /// Width and height.
    pub const fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    /// Whether pixels have a fourth sample, A, by which RGB is not multiplied.
    pub const fn has_alpha(&self) -> bool {
        self.has_alpha
    }

    /// Bits of each sample.
    pub const fn bits(&self) -> Bits {
        self.bits
    }

    /// The samples row by row from the top, R, G, B and A where there is alpha; of 16 bits the
    /// high byte first.
    pub fn samples(&self) -> &[u8] {
        &self.samples
    }
}

/// A picture could not be shown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DisplayError {
    /// The EXR could not be read.
    #[error(transparent)]
    Read(#[from] ExrError),
    /// A picture of another format could not be read, or it is none that is.
    #[error(transparent)]
    Decode(#[from] ImageFileError),
    /// The format of the output has no samples of 32 bits.
    #[error("a PNG has samples of 8 or 16 bits; for 32 bits, name the output .tif")]
    NoFloats,
    /// The output could not be written.
    #[error(transparent)]
    Write(#[from] OutputError),
    /// There is no memory for the picture.
    #[error(transparent)]
    Memory(#[from] OutOfMemory),
}

impl DisplayError {
    /// Whether another machine or a later try may do better: no memory, a full disk, a failing
    /// one.
    pub fn is_transient(&self) -> bool {
        match self {
            Self::Read(error) => error.is_transient(),
            Self::Decode(error) => error.is_transient(),
            Self::NoFloats => false,
            Self::Write(error) => error.is_transient(),
            Self::Memory(_) => true,
        }
    }
}

/// Exposes, views, encodes and quantizes a picture.
#[doc(hidden)]
pub fn tonemap(picture: &Picture<'_>, settings: &Settings<'_>) -> Image {
    let ev = settings.exposure.ev(picture);
    developed(picture, &develop(picture, settings, ev))
}

fn develop<'a>(picture: &Picture<'_>, settings: &Settings<'a>, ev: f64) -> Develop<'a> {
    let has_alpha = picture.has_alpha()
        && match settings.alpha {
            Alpha::Auto => !picture.has_uncovered_light(),
            Alpha::Keep => true,
            Alpha::Opaque => false,
        };
    Develop::new(settings, ev, has_alpha, [0, 0])
}

fn developed(picture: &Picture<'_>, develop: &Develop) -> Image {
    let [width, height] = picture.resolution().map(|side| side as usize);
    let row_bytes = width * develop.pixel_bytes();
    let mut samples = vec![0; row_bytes * height];
    let rows = samples.par_chunks_exact_mut(row_bytes).enumerate();
    rows.for_each(|(y, row)| {
        let (left, pixels) = picture.row(y);
        develop.row(y as u32, left as u32, pixels, row);
    });
    Image {
        resolution: picture.resolution(),
        has_alpha: develop.has_alpha(),
        bits: develop.bits(),
        samples,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::transfer;
    use crate::exr::{ColorTag, ExrImage};
    use crate::image::Window;

    /// Without dither: every value becomes the nearest code.
    const NEAREST: Settings<'static> = Settings {
        dither: Dither::None,
        ..Settings::new()
    };

    /// A picture whose data window is the whole display window, one row.
    fn row(pixels: &[[f32; 4]], has_alpha: bool) -> Picture<'static> {
        let width = pixels.len() as u32;
        Picture::new(ExrImage {
            resolution: [width, 1],
            window: Some(Window {
                x: 0,
                y: 0,
                width,
                height: 1,
            }),
            pixels: pixels.to_vec(),
            has_alpha,
            color: ColorTag::default(),
        })
    }

    fn samples(pixels: &[[f32; 4]], has_alpha: bool, settings: Settings<'_>) -> Vec<u8> {
        tonemap(&row(pixels, has_alpha), &settings).samples
    }

    #[test]
    fn codes_are_rounded_to_the_nearest() {
        // The light that is coded halfway between two codes divides them.
        for code in 0..255_u8 {
            let border = transfer::srgb_decode((f64::from(code) + 0.5) / 255.0) as f32;
            let (below, above) = (border * (1.0 - 1e-5), border * (1.0 + 1e-5));
            let got = samples(&[[below, above, border, 1.0]], false, NEAREST);
            assert_eq!(got[..2], [code, code + 1]);
        }
    }

    #[test]
    fn sixteen_bits_are_stored_high_byte_first() {
        let settings = Settings {
            bits: Bits::Sixteen,
            ..NEAREST
        };
        // 0.18 is coded as 0.461356, × 65535 = 30234.99.
        let [high, low] = 30_235_u16.to_be_bytes();
        let got = samples(&[[0.18, 1.0, 0.0, 1.0]], false, settings);
        assert_eq!(got, [high, low, 255, 255, 0, 0]);
    }

    #[test]
    fn alpha_is_divided_out_before_the_view() {
        // A white of radiance 3, half covered: reinhard sees 3, not 1.5.
        let settings = Settings {
            view: View::Reinhard,
            ..NEAREST
        };
        let covered = samples(&[[3.0, 3.0, 3.0, 1.0]], true, settings);
        let half = samples(&[[1.5, 1.5, 1.5, 0.5]], true, settings);
        assert_eq!(covered[..3], half[..3]);
        assert_eq!((covered[3], half[3]), (255, 128));
    }

    #[test]
    fn light_without_coverage_keeps_its_color() {
        let kept = Settings {
            alpha: Alpha::Keep,
            ..NEAREST
        };
        assert_eq!(
            samples(&[[1.0, 0.0, 0.5, 0.0]], true, kept),
            [255, 0, 188, 0]
        );
    }

    /// A PNG's alpha would make a background invisible.
    #[test]
    fn a_background_makes_the_picture_opaque() {
        let settings = NEAREST;
        let covered = [0.25, 0.25, 0.25, 0.5];
        assert_eq!(samples(&[covered, [0.0; 4]], true, settings).len(), 8);
        let lit = [0.0, 0.5, 0.0, 0.0];
        let opaque = samples(&[covered, lit], true, settings);
        assert_eq!(opaque, [137, 137, 137, 0, 188, 0]);
    }

    #[test]
    fn opaque_shows_the_premultiplied_light() {
        let settings = Settings {
            alpha: Alpha::Opaque,
            ..NEAREST
        };
        assert_eq!(
            samples(&[[0.5, 0.5, 0.5, 0.5]], true, settings),
            [188, 188, 188]
        );
    }

    #[test]
    fn what_is_not_a_number_is_black_and_infinity_white() {
        let pixels = [[f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1.0]];
        for view in View::ALL {
            let settings = Settings { view, ..NEAREST };
            if view.is_per_channel() {
                assert_eq!(samples(&pixels, false, settings), [0, 255, 0], "{view:?}");
            }
            let white = [[f32::INFINITY, f32::INFINITY, f32::INFINITY, 1.0]];
            assert_eq!(samples(&white, false, settings), [255; 3], "{view:?}");
            let black = [[f32::NEG_INFINITY, f32::NAN, f32::NEG_INFINITY, 1.0]];
            assert_eq!(samples(&black, false, settings), [0; 3], "{view:?}");
        }
        let infinite_alpha = [[f32::INFINITY, 1.0, f32::NAN, f32::INFINITY]];
        assert_eq!(samples(&infinite_alpha, true, NEAREST), [255, 255, 0, 255]);
    }

    #[test]
    fn any_finite_exposure_gives_a_picture() {
        for (ev, expected) in [
            (f64::MAX, [0, 255, 255]),
            (f64::MIN, [0, 0, 0]),
            (1.0, [0, 255, 188]),
        ] {
            let settings = Settings {
                exposure: Exposure::Ev(ev),
                ..NEAREST
            };
            assert_eq!(samples(&[[0.0, 0.5, 0.25, 1.0]], false, settings), expected);
        }
    }

    #[test]
    fn outside_of_the_data_is_nothing() {
        let picture = |has_alpha| {
            Picture::new(ExrImage {
                resolution: [3, 2],
                window: Some(Window {
                    x: 1,
                    y: 1,
                    width: 1,
                    height: 1,
                }),
                pixels: vec![[1.0; 4]],
                has_alpha,
                color: ColorTag::default(),
            })
        };
        let mut expected = vec![0; 3 * 2 * 4];
        expected[(3 + 1) * 4..][..4].fill(255);
        assert_eq!(tonemap(&picture(true), &NEAREST).samples, expected);
        let mut expected = vec![0; 3 * 2 * 3];
        expected[(3 + 1) * 3..][..3].fill(255);
        assert_eq!(tonemap(&picture(false), &NEAREST).samples, expected);
    }
}
