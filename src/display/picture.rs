//! The radiance that is shown: R, G, B, A in a display window.

use std::borrow::Cow;

use crate::color::Primaries;
use crate::color::adaptation::conversion;
use crate::film::exr::{ColorTag, ExrImage, color_interop_id, primaries_of};
use crate::film::{Film, Window};
use glam::DVec3;
use rayon::prelude::*;

/// Pixels that a thread looks at in one go.
const PIECE: usize = 1 << 14;

/// Linear radiance in Rec.709, RGB premultiplied by coverage A, with nothing in it that is not a
/// number.
#[derive(Clone, Debug)]
pub struct Picture<'a> {
    resolution: [u32; 2],
    window: Option<Window>,
    /// Where its top left is in the display window.
    origin: [u32; 2],
    /// R, G, B, A row by row from the top of `window`. Infinities may be there.
    pixels: Cow<'a, [[f32; 4]]>,
    has_alpha: bool,
    /// What the file says of its color space that is not known.
    unknown_space: Option<String>,
    /// Pixels with a NaN, which became 0.
    nan: u64,
    /// Pixels with an infinity.
    infinite: u64,
}

impl Picture<'static> {
    /// The picture of an EXR file, converted from the space that the file names. A value that is
    /// not a number becomes 0, and its pixel counts in [`Picture::warnings`].
    pub fn new(mut image: ExrImage) -> Self {
        let repaired = image.pixels.par_chunks_mut(PIECE).map(repair);
        let (nan, infinite) = repaired.reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
        let space = other_primaries(&image.color);
        if let Ok(Some(primaries)) = &space {
            convert(&mut image.pixels, primaries);
        }
        Self {
            resolution: image.resolution,
            window: image.window,
            origin: [0, 0],
            pixels: Cow::Owned(image.pixels),
            has_alpha: image.has_alpha,
            unknown_space: space.err(),
            nan,
            infinite,
        }
    }
}

impl<'a> Picture<'a> {
    /// The picture of a film, without the way over a file. A film's values are finite.
    pub fn of_film(film: &'a Film) -> Self {
        let mut pixels = Cow::Borrowed(film.pixels());
        let space = primaries_of(color_interop_id(film.metadata().color_space));
        if let Some(primaries) = space.filter(|space| *space != Primaries::REC709) {
            convert(pixels.to_mut(), &primaries);
        }
        Self {
            resolution: film.resolution(),
            window: Some(film.window()),
            origin: [0, 0],
            pixels,
            has_alpha: true,
            unknown_space: None,
            nan: 0,
            infinite: 0,
        }
    }

    /// The part of it that there is data for, as a picture of its own; itself where there is none.
    pub fn of_data(self) -> Self {
        let Some(window) = self.window else {
            return self;
        };
        let Window {
            x,
            y,
            width,
            height,
        } = window;
        Self {
            resolution: [width, height],
            window: Some(Window::whole([width, height])),
            origin: [self.origin[0] + x, self.origin[1] + y],
            ..self
        }
    }

    /// Where its top left is in the display window: not 0, 0 of [`Picture::of_data`].
    pub(super) const fn origin(&self) -> [u32; 2] {
        self.origin
    }

    /// Width and height of what is shown, which is the display window unless it is
    /// [`Picture::of_data`].
    pub const fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    /// Whether the picture has coverage; without, A is 1 in every pixel.
    pub const fn has_alpha(&self) -> bool {
        self.has_alpha
    }

    /// Whether any pixel has light but no coverage.
    pub fn has_uncovered_light(&self) -> bool {
        let is_uncovered =
            |&[r, g, b, a]: &[f32; 4]| a == 0.0 && [r, g, b].iter().any(|&c| c > 0.0);
        let pieces = self.pixels.par_chunks(PIECE);
        self.has_alpha
            && pieces
                .into_par_iter()
                .any(|piece| piece.iter().any(is_uncovered))
    }

    /// R, G, B, A of every pixel that there is data for, row by row.
    pub fn pixels(&self) -> &[[f32; 4]] {
        &self.pixels
    }

    /// The pixels of a row of the display window, and the column where they start.
    pub(super) fn row(&self, y: usize) -> (usize, &[[f32; 4]]) {
        let Some(window) = self.window else {
            return (0, &[]);
        };
        let width = window.width as usize;
        match y.checked_sub(window.y as usize) {
            Some(row) if row < window.height as usize => {
                (window.x as usize, &self.pixels[row * width..][..width])
            }
            _ => (0, &[]),
        }
    }

    /// What the user should know about the picture, a sentence each.
    pub fn warnings(&self) -> Vec<String> {
        let pixels = |count: u64| match count {
            1 => "1 pixel has".to_string(),
            count => format!("{count} pixels have"),
        };
        let mut warnings = Vec::new();
        if let Some(other) = &self.unknown_space {
            warnings.push(format!(
                "the file's color space is {other}; it is shown as linear Rec.709, without \
                 conversion"
            ));
        }
        if self.nan > 0 {
            warnings.push(format!(
                "{} values that are not a number; these are shown as 0",
                pixels(self.nan)
            ));
        }
        if self.infinite > 0 {
            warnings.push(format!(
                "{} infinite values; these are shown as white, or black below 0",
                pixels(self.infinite)
            ));
        }
        warnings
    }
}

/// How far chromaticities in old files are off, as the Color Interop Forum has it.
const CHROMATICITY_TOLERANCE: f64 = 0.001;

/// The primaries that a tag means, where that is something else than linear Rec.709; an error is
/// what it says that is not known. The identifier counts where there is one, as the ASWF Color Interop
/// Forum asks. A file that says nothing is taken as Rec.709, which is OpenEXR's default.
fn other_primaries(tag: &ColorTag) -> Result<Option<Primaries>, String> {
    let found = match (&tag.interop_id, tag.chromaticities) {
        (Some(id), _) if id == "unknown" => return Ok(None),
        (Some(id), _) => primaries_of(id).ok_or_else(|| format!("`{id}`"))?,
        (None, Some(found)) => found,
        (None, None) => return Ok(None),
    };
    let list = |p: &Primaries| [p.red, p.green, p.blue, p.white].into_iter().flatten();
    let is_rec709 = list(&found)
        .zip(list(&Primaries::REC709))
        // As a range, which holds no NaN.
        .all(|(found, expected)| {
            (0.0..=CHROMATICITY_TOLERANCE).contains(&(found - expected).abs())
        });
    if is_rec709 {
        return Ok(None);
    }
    if !conversion(&found, &Primaries::REC709).is_finite() {
        let [r, g, b, w] = [found.red, found.green, found.blue, found.white]
            .map(|[x, y]| format!("({x:.4}, {y:.4})"));
        let what = format!("that of the chromaticities R {r}, G {g}, B {b}, white {w}");
        return Err(what);
    }
    Ok(Some(found))
}

/// Makes what is not a number 0; how many pixels had that, and how many have infinities.
fn repair(pixels: &mut [[f32; 4]]) -> (u64, u64) {
    let (mut nan, mut infinite) = (0, 0);
    for pixel in pixels {
        if pixel.iter().all(|value| value.is_finite()) {
            continue;
        }
        nan += u64::from(pixel.iter().any(|value| value.is_nan()));
        infinite += u64::from(pixel.iter().any(|value| value.is_infinite()));
        *pixel = pixel.map(|value| if value.is_nan() { 0.0 } else { value });
    }
    (nan, infinite)
}

/// Linear Rec.709, whites adapted, from another space. Infinite values stay as they are.
fn convert(pixels: &mut [[f32; 4]], from: &Primaries) {
    let matrix = conversion(from, &Primaries::REC709);
    pixels.par_iter_mut().for_each(|[r, g, b, _]| {
        let rgb = DVec3::new(f64::from(*r), f64::from(*g), f64::from(*b));
        if rgb.is_finite() {
            let limit = DVec3::splat(f64::from(f32::MAX));
            let converted = (matrix * rgb).clamp(-limit, limit);
            [*r, *g, *b] = converted.to_array().map(|channel| channel as f32);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    fn id(id: &str) -> ColorTag {
        ColorTag {
            interop_id: Some(id.to_string()),
            chromaticities: None,
        }
    }

    fn chromaticities(primaries: Primaries) -> ColorTag {
        ColorTag {
            interop_id: None,
            chromaticities: Some(primaries),
        }
    }

    #[test]
    fn color_tags() {
        assert_eq!(other_primaries(&ColorTag::default()), Ok(None));
        assert_eq!(other_primaries(&id("lin_rec709_scene")), Ok(None));
        assert_eq!(other_primaries(&id("unknown")), Ok(None));
        assert_eq!(
            other_primaries(&id("lin_ap1_scene")),
            Ok(Some(Primaries::AP1))
        );
        assert_eq!(
            other_primaries(&id("g22_rec709_tx")),
            Err("`g22_rec709_tx`".to_string())
        );
        let rec709 = chromaticities(Primaries::REC709);
        assert_eq!(other_primaries(&rec709), Ok(None));
        // Some writers round the white to four decimals of D65's own, others to f32.
        let rounded = Primaries {
            white: [0.31272, 0.32903],
            ..Primaries::REC709
        };
        assert_eq!(other_primaries(&chromaticities(rounded)), Ok(None));
        let p3 = chromaticities(Primaries::P3_D65);
        assert_eq!(other_primaries(&p3), Ok(Some(Primaries::P3_D65)));
        // The identifier counts.
        let both = ColorTag {
            chromaticities: Some(Primaries::AP1),
            ..id("lin_rec709_scene")
        };
        assert_eq!(other_primaries(&both), Ok(None));
        // Chromaticities of which no matrix can be made.
        for bad in [f64::NAN, 0.0] {
            let collapsed = Primaries {
                red: [bad, bad],
                ..Primaries::REC709
            };
            assert!(other_primaries(&chromaticities(collapsed)).is_err());
        }
    }

    #[test]
    fn white_stays_white_and_red_is_red() {
        let mut pixels = [[1.0, 1.0, 1.0, 0.5], [1.0, 0.0, 0.0, 1.0]];
        convert(&mut pixels, &Primaries::AP1);
        for channel in &pixels[0][..3] {
            assert!((channel - 1.0).abs() < 1e-6);
        }
        assert_eq!(pixels[0][3], 0.5);
        // The published matrix from ACEScg to Rec.709.
        for (actual, expected) in pixels[1].iter().zip([1.705_051, -0.130_256, -0.024_003]) {
            assert!((actual - expected).abs() < 2e-6, "{actual}");
        }
        let mut infinite = [[f32::INFINITY, 1.0, 2.0, 1.0]];
        convert(&mut infinite, &Primaries::AP1);
        assert_eq!(infinite, [[f32::INFINITY, 1.0, 2.0, 1.0]]);
    }
}
