//! The radiance that is shown: R, G, B, A in a display window.

use std::borrow::Cow;

use crate::color::Primaries;
use crate::film::exr::{ColorTag, ExrImage};
use crate::film::{Film, Window};

/// Linear radiance, RGB premultiplied by coverage A, with nothing in it that is not a number.
#[derive(Clone, Debug)]
pub struct Picture<'a> {
    resolution: [u32; 2],
    window: Option<Window>,
    /// R, G, B, A row by row from the top of `window`. Infinities may be there.
    pixels: Cow<'a, [[f32; 4]]>,
    has_alpha: bool,
    color: ColorTag,
    /// Pixels with a NaN, which became 0.
    nan: u64,
    /// Pixels with an infinity.
    infinite: u64,
}

impl Picture<'static> {
    /// The picture of an EXR file. A value that is not a number becomes 0, and its pixel counts in
    /// [`Picture::warnings`].
    pub fn new(mut image: ExrImage) -> Self {
        let (mut nan, mut infinite) = (0, 0);
        for pixel in &mut image.pixels {
            if pixel.iter().all(|value| value.is_finite()) {
                continue;
            }
            nan += u64::from(pixel.iter().any(|value| value.is_nan()));
            infinite += u64::from(pixel.iter().any(|value| value.is_infinite()));
            *pixel = pixel.map(|value| if value.is_nan() { 0.0 } else { value });
        }
        Self {
            resolution: image.resolution,
            window: image.window,
            pixels: Cow::Owned(image.pixels),
            has_alpha: image.has_alpha,
            color: image.color,
            nan,
            infinite,
        }
    }
}

impl<'a> Picture<'a> {
    /// The picture of a film, without the way over a file. A film's values are finite.
    pub fn of_film(film: &'a Film) -> Self {
        Self {
            resolution: film.resolution(),
            window: Some(film.window()),
            pixels: Cow::Borrowed(film.pixels()),
            has_alpha: true,
            color: ColorTag {
                interop_id: Some(
                    crate::film::exr::color_interop_id(film.metadata().color_space).to_string(),
                ),
                chromaticities: None,
            },
            nan: 0,
            infinite: 0,
        }
    }

    /// Width and height of the display window.
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
        self.has_alpha && self.pixels.iter().any(is_uncovered)
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
        if let Some(other) = other_space(&self.color) {
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

/// Identifiers of the ASWF Color Interop Forum that say nothing against linear Rec.709.
const REC709_IDS: [&str; 2] = ["lin_rec709_scene", "unknown"];

/// How far chromaticities in old files are off, as the Color Interop Forum has it.
const CHROMATICITY_TOLERANCE: f64 = 0.001;

/// What the tag says, if that is something else than linear Rec.709. The identifier counts where
/// there is one, as the Color Interop Forum asks. A file that says nothing is taken as Rec.709,
/// which is OpenEXR's default.
fn other_space(tag: &ColorTag) -> Option<String> {
    if let Some(id) = &tag.interop_id {
        return (!REC709_IDS.contains(&id.as_str())).then(|| format!("`{id}`"));
    }
    let found = tag.chromaticities?;
    let list = |p: &Primaries| [p.red, p.green, p.blue, p.white].into_iter().flatten();
    let differs = list(&found)
        .zip(list(&Primaries::REC709))
        // As a range, which holds no NaN.
        .any(|(found, expected)| {
            !(0.0..=CHROMATICITY_TOLERANCE).contains(&(found - expected).abs())
        });
    differs.then(|| {
        let [r, g, b, w] = [found.red, found.green, found.blue, found.white]
            .map(|[x, y]| format!("({x:.4}, {y:.4})"));
        format!("that of the chromaticities R {r}, G {g}, B {b}, white {w}")
    })
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

    #[test]
    fn color_tags() {
        assert_eq!(other_space(&ColorTag::default()), None);
        assert_eq!(other_space(&id("lin_rec709_scene")), None);
        assert_eq!(
            other_space(&id("lin_ap1_scene")),
            Some("`lin_ap1_scene`".to_string())
        );
        let chromaticities = |primaries: Primaries| ColorTag {
            interop_id: None,
            chromaticities: Some(primaries),
        };
        assert_eq!(other_space(&chromaticities(Primaries::REC709)), None);
        // Some writers round the white to four decimals of D65's own, others to f32.
        let rounded = Primaries {
            white: [0.31272, 0.32903],
            ..Primaries::REC709
        };
        assert_eq!(other_space(&chromaticities(rounded)), None);
        assert!(other_space(&chromaticities(Primaries::P3_D65)).is_some());
        // The identifier counts.
        let both = ColorTag {
            chromaticities: Some(Primaries::AP1),
            ..id("lin_rec709_scene")
        };
        assert_eq!(other_space(&both), None);
    }
}
