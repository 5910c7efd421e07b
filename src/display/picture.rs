//! The radiance that is shown: R, G, B, A in a display window.

use std::borrow::Cow;

use crate::color::Primaries;
use crate::color::adaptation::conversion;
use crate::exr::ExrImage;
use crate::image::{Film, Window};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Pixels that a thread looks at in one go.
const PIECE: usize = 1 << 14;

/// Linear radiance in Rec.709, RGB premultiplied by coverage A, with nothing in it that is not a
/// number.
#[derive(Clone, Debug)]
pub struct Picture<'a> {
    resolution: [u32; 2],
    window: Option<Window>,
    /// R, G, B, A row by row from the top of `window`. Infinities may be there.
    pixels: Cow<'a, [[f32; 4]]>,
    has_alpha: bool,
    /// What is odd about what the file says of its color space.
    odd_color: Option<String>,
    repaired: Repaired,
}

impl Picture<'static> {
    /// The picture of an EXR file, converted from the space that the file names. A value that is
    /// not a number becomes 0, and its pixel counts in [`Picture::warnings`].
    pub fn new(mut image: ExrImage) -> Self {
        let meaning = image.color.meaning();
        let prepare = Prepare::from(&meaning.primaries, false);
        let pieces = image.pixels.par_chunks_mut(PIECE);
        let repaired = pieces
            .map(|pixels| prepare.apply(pixels))
            .reduce(Repaired::default, Repaired::and);
        Self {
            resolution: image.resolution,
            window: image.window,
            pixels: Cow::Owned(image.pixels),
            has_alpha: image.has_alpha,
            odd_color: meaning.warning,
            repaired,
        }
    }
}

impl<'a> Picture<'a> {
    /// The picture of a film, without the way over a file. A film's values are finite.
    pub fn of_film(film: &'a Film) -> Self {
        let mut pixels = Cow::Borrowed(film.pixels());
        let primaries = film.metadata().color_space.primaries();
        if primaries != Primaries::REC709 {
            let prepare = Prepare::from(&primaries, false);
            let pieces = pixels.to_mut().par_chunks_mut(PIECE);
            pieces.for_each(|pixels| {
                prepare.apply(pixels);
            });
        }
        Self {
            resolution: film.resolution(),
            window: Some(film.window()),
            pixels,
            has_alpha: true,
            odd_color: None,
            repaired: Repaired::default(),
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
        self.has_alpha && self.pixels.par_chunks(PIECE).any(has_uncovered_light)
    }

    /// R, G, B, A of every pixel that there is data for, row by row.
    pub fn pixels(&self) -> &[[f32; 4]] {
        &self.pixels
    }

    /// Pixels in a row of the data.
    pub(super) fn width(&self) -> usize {
        self.window.map_or(0, |window| window.width as usize)
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
        let odd_color = self.odd_color.iter().cloned();
        odd_color.chain(self.repaired.warnings(false)).collect()
    }
}

/// Makes of rows as a file has them rows of a picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prepare {
    /// To Rec.709, from another space.
    matrix: Option<DMat3>,
    /// Whether what is not a number stays so.
    keeps_invalid: bool,
}

/// Values in a file that are no light.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Repaired {
    /// Pixels with a NaN, which became 0.
    pub(super) nan: u64,
    /// Pixels with an infinity.
    pub(super) infinite: u64,
}

impl Prepare {
    /// From a space with these primaries.
    pub(super) fn from(primaries: &Primaries, keeps_invalid: bool) -> Self {
        Self {
            matrix: (*primaries != Primaries::REC709)
                .then(|| conversion(primaries, &Primaries::REC709)),
            keeps_invalid,
        }
    }

    /// Makes what is not a number 0, unless it is kept, and linear Rec.709 of the rest. Infinite values stay as they
    /// are.
    pub(super) fn apply(self, pixels: &mut [[f32; 4]]) -> Repaired {
        let repaired = repair(pixels, self.keeps_invalid);
        if let Some(matrix) = self.matrix {
            for [r, g, b, _] in pixels {
                let rgb = DVec3::new(f64::from(*r), f64::from(*g), f64::from(*b));
                if rgb.is_finite() {
                    let limit = DVec3::splat(f64::from(f32::MAX));
                    let converted = (matrix * rgb).clamp(-limit, limit);
                    [*r, *g, *b] = converted.to_array().map(|channel| channel as f32);
                }
            }
        }
        repaired
    }
}

impl Repaired {
    pub(super) const fn and(self, other: Self) -> Self {
        Self {
            nan: self.nan + other.nan,
            infinite: self.infinite + other.infinite,
        }
    }

    /// What the user should know about it, a sentence each.
    pub(super) fn warnings(self, shows_invalid: bool) -> Vec<String> {
        let pixels = |count: u64| match count {
            1 => "1 pixel has".to_string(),
            count => format!("{count} pixels have"),
        };
        let mut warnings = Vec::new();
        if self.nan > 0 {
            warnings.push(format!(
                "{} values that are not a number; these are shown {}",
                pixels(self.nan),
                if shows_invalid { "in magenta" } else { "as 0" }
            ));
        }
        if self.infinite > 0 {
            warnings.push(format!(
                "{} infinite values; these are shown {}",
                pixels(self.infinite),
                if shows_invalid {
                    "in cyan"
                } else {
                    "as white, or black below 0"
                }
            ));
        }
        warnings
    }
}

/// Whether any pixel has light but no coverage.
pub(super) fn has_uncovered_light(pixels: &[[f32; 4]]) -> bool {
    let is_uncovered = |&[r, g, b, a]: &[f32; 4]| a == 0.0 && [r, g, b].iter().any(|&c| c > 0.0);
    pixels.iter().any(is_uncovered)
}

/// Makes what is not a number 0, unless it is kept; how many pixels had that, and how many have infinities.
fn repair(pixels: &mut [[f32; 4]], keeps_invalid: bool) -> Repaired {
    let (mut nan, mut infinite) = (0, 0);
    for pixel in pixels {
        if pixel.iter().all(|value| value.is_finite()) {
            continue;
        }
        nan += u64::from(pixel.iter().any(|value| value.is_nan()));
        infinite += u64::from(pixel.iter().any(|value| value.is_infinite()));
        if !keeps_invalid {
            *pixel = pixel.map(|value| if value.is_nan() { 0.0 } else { value });
        }
    }
    Repaired { nan, infinite }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_stays_white_and_red_is_red() {
        let mut pixels = [[1.0, 1.0, 1.0, 0.5], [1.0, 0.0, 0.0, 1.0]];
        Prepare::from(&Primaries::AP1, false).apply(&mut pixels);
        for channel in &pixels[0][..3] {
            assert!((channel - 1.0).abs() < 1e-6);
        }
        assert_eq!(pixels[0][3], 0.5);
        // The published matrix from ACEScg to Rec.709.
        for (actual, expected) in pixels[1].iter().zip([1.705_051, -0.130_256, -0.024_003]) {
            assert!((actual - expected).abs() < 2e-6, "{actual}");
        }
        let mut infinite = [[f32::INFINITY, 1.0, 2.0, 1.0]];
        Prepare::from(&Primaries::AP1, false).apply(&mut infinite);
        assert_eq!(infinite, [[f32::INFINITY, 1.0, 2.0, 1.0]]);
    }
}
