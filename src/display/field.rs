//! The numbers that false colors show, pixel by pixel: for ranges and lines that depend on all of them.

use rayon::prelude::*;

use super::picture::Prepare;
use super::source::Source;
use super::{DisplayError, Input};
use crate::color::Primaries;
use crate::image::Window;
use crate::memory;

/// Luminances in Rec.709 of a picture as its file has them, or a layer's numbers; divided by coverage.
#[derive(Clone, Debug)]
pub struct Field {
    /// Where they are in the display window.
    window: Window,
    /// Row by row from the top of the window; NaN where there is no surface.
    values: Vec<f32>,
}

impl Field {
    /// Reads all of a picture; colors are of this space, or of the one that the file names. `None` where no pixel of it
    /// is shown.
    ///
    /// # Errors
    /// If the picture cannot be read, or there is no memory for its numbers.
    pub fn read(input: &Input, space: Option<Primaries>) -> Result<Option<Self>, DisplayError> {
        let source = Source::from(input);
        let Some(window) = source.window() else {
            return Ok(None);
        };
        let primaries = space.unwrap_or_else(|| source.color().meaning().primaries);
        let prepare = Prepare::from(&primaries, false);
        let has_alpha = source.has_alpha();
        let width = window.width as usize;
        let mut values = Vec::new();
        memory::reserve(&mut values, width * window.height as usize)
            .map_err(|error| error.for_what("the numbers of the picture"))?;
        for band in source.bands() {
            let mut pixels = source.rows(band)?;
            let start = values.len();
            values.resize(start + pixels.len(), f32::NAN);
            let rows = pixels.par_chunks_mut(width);
            rows.zip(values[start..].par_chunks_mut(width))
                .for_each(|(pixels, values)| {
                    prepare.apply(pixels);
                    for (value, pixel) in values.iter_mut().zip(pixels) {
                        *value = number(*pixel, has_alpha);
                    }
                });
        }
        Ok(Some(Self { window, values }))
    }

    /// Of numbers that are known, row by row.
    ///
    /// # Panics
    /// If they are not as many as the window has pixels.
    pub fn new(window: Window, values: Vec<f32>) -> Self {
        assert_eq!(
            values.len(),
            window.width as usize * window.height as usize,
            "a number for each pixel"
        );
        Self { window, values }
    }

    /// Where the numbers are in the display window.
    pub const fn window(&self) -> Window {
        self.window
    }

    /// Columns and rows.
    pub const fn size(&self) -> [usize; 2] {
        [self.window.width as usize, self.window.height as usize]
    }

    /// All numbers, row by row; NaN where there is no surface.
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// The number of a pixel.
    pub fn at(&self, x: usize, y: usize) -> f32 {
        self.values[y * self.window.width as usize + x]
    }

    /// The number that this part of those above 0, from 0 to 1, does not exceed: the nearest rank. `None` where none
    /// is above 0.
    pub fn quantile(&self, part: f64) -> Option<f64> {
        // The leading bits of a float above 0 are in its order, and counts have none: 128 steps for a factor of 2.
        const UNCOUNTED: u32 = 16;
        let mut counts = vec![0_u64; (f32::INFINITY.to_bits() >> UNCOUNTED) as usize + 1];
        for value in self.values.iter().filter(|&&value| value > 0.0) {
            counts[(value.to_bits() >> UNCOUNTED) as usize] += 1;
        }
        let all: u64 = counts.iter().sum();
        let rank = (part * all as f64).ceil().max(1.0) as u64;
        let mut below = 0;
        let step = counts.iter().position(|count| {
            below += count;
            below >= rank
        });
        step.filter(|_| all > 0)
            .map(|step| f64::from(f32::from_bits((step as u32) << UNCOUNTED)))
    }
}

fn number([r, g, b, alpha]: [f32; 4], has_alpha: bool) -> f32 {
    let per_coverage = match has_alpha {
        true if alpha > 0.0 && alpha.is_finite() => 1.0 / f64::from(alpha),
        true => return f32::NAN,
        false => 1.0,
    };
    if r == g && g == b {
        // A gray is what it is: the weights add up to 1 but for a rounding.
        return (f64::from(r) * per_coverage) as f32;
    }
    let weights = Primaries::REC709.luminance_weights();
    let channels = weights.iter().zip([r, g, b]);
    let luminance: f64 = channels.map(|(weight, c)| weight * f64::from(c)).sum();
    (luminance * per_coverage) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coverage_is_divided_out() {
        assert_eq!(number([150.0, 150.0, 150.0, 0.5], true), 300.0);
        assert_eq!(number([150.0, 150.0, 150.0, 1.0], false), 150.0);
        assert!(number([1.0, 1.0, 1.0, 0.0], true).is_nan());
        let green = number([0.0, 2.0, 0.0, 1.0], true);
        assert!((green - 1.430_3).abs() < 1e-3, "{green}");
    }

    #[test]
    fn quantiles_of_what_is_lit() {
        let values = (0..=100).map(|value| value as f32).chain([f32::NAN; 10]);
        let field = Field::new(Window::whole([111, 1]), values.collect());
        for (part, expected) in [(0.0, 1.0), (0.5, 50.0), (0.9, 90.0), (1.0, 100.0)] {
            let got = field.quantile(part).unwrap();
            assert!((got / expected - 1.0).abs() < 0.01, "{got}");
        }
        let dark = Field::new(Window::whole([2, 1]), vec![0.0, f32::NAN]);
        assert_eq!(dark.quantile(0.5), None);
    }
}
