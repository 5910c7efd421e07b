//! Pictures for the page: small enough to be looked at side by side.

use candela::compare::FalseColor;
use candela::display::{self, Alpha, Exposure, Image, Picture, Settings};
use candela::image::{Film, Window};

use crate::cli::Failure;

/// The most columns of a picture among others.
pub(super) const THUMBNAIL: usize = 480;

/// The most columns of the render.
const LARGE: usize = 960;

/// A picture made of blocks of pixels of another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reduced {
    size: [usize; 2],
    /// Columns and rows of a block.
    block: usize,
}

impl Reduced {
    /// Of a picture with so many pixels in a row and in all, to at most so many columns.
    pub(super) fn new(width: usize, pixels: usize, most: usize) -> Self {
        Self {
            size: [width, pixels / width],
            block: width.div_ceil(most),
        }
    }

    /// Width and height.
    pub(super) fn resolution(self) -> [u32; 2] {
        self.size.map(|side| side.div_ceil(self.block) as u32)
    }

    /// The places of a block's pixels, for each block.
    fn blocks(self) -> impl Iterator<Item = impl Iterator<Item = usize>> {
        let Self {
            size: [width, height],
            block,
        } = self;
        let corners = (0..height).step_by(block);
        let corners = corners.flat_map(move |y| (0..width).step_by(block).map(move |x| [x, y]));
        corners.map(move |[left, top]| {
            let rows = top..(top + block).min(height);
            rows.flat_map(move |y| (left..(left + block).min(width)).map(move |x| y * width + x))
        })
    }

    /// The largest value of each block.
    pub(super) fn largest(self, values: &[f32]) -> Vec<f32> {
        let largest =
            |block| Iterator::fold(block, 0.0_f32, |most, place: usize| most.max(values[place]));
        self.blocks().map(largest).collect()
    }

    /// The mean of each block.
    fn means(self, pixels: &[[f32; 4]]) -> Vec<[f32; 4]> {
        let mean = |block: &mut dyn Iterator<Item = usize>| {
            let (mut sum, mut count) = ([0.0; 4], 0.0);
            for place in block {
                for (sum, value) in sum.iter_mut().zip(pixels[place]) {
                    *sum += f64::from(value);
                }
                count += 1.0;
            }
            sum.map(|sum| (sum / count) as f32)
        };
        self.blocks().map(|mut block| mean(&mut block)).collect()
    }
}

/// The film as a screen shows it at an exposure, small.
pub(super) fn shown(film: &Film, ev: f64) -> Image {
    let width = film.window().width as usize;
    let reduced = Reduced::new(width, film.pixels().len(), LARGE);
    let resolution = reduced.resolution();
    let small = Film::new(
        resolution,
        Window::whole(resolution),
        reduced.means(film.pixels()),
        film.metadata().clone(),
    );
    let settings = Settings {
        exposure: Exposure::Ev(ev),
        alpha: Alpha::Opaque,
        ..Settings::default()
    };
    display::tonemap(&Picture::of_film(&small), &settings)
}

/// How many samples the pixels took: black is one or none, light yellow as many as can be.
pub(super) const COUNTS: FalseColor = FalseColor {
    least: 1.0,
    most: 4096.0,
};

/// A film's samples in false colors, small.
pub(super) fn counts(film: &Film, samples: &[f32]) -> Image {
    let width = film.window().width as usize;
    let reduced = Reduced::new(width, samples.len(), THUMBNAIL);
    let colors = reduced.largest(samples).into_iter();
    let colors = colors.map(|count| COUNTS.color(count.into()));
    Image::opaque(reduced.resolution(), colors.collect())
}

/// The scale of false colors, from the least error to the largest.
pub(super) fn scale_bar(colors: &FalseColor) -> Image {
    const SIZE: [u32; 2] = [256, 12];
    let decades = libm::log(colors.most / colors.least);
    let row = (0..SIZE[0]).map(|x| {
        let part = f64::from(x) / f64::from(SIZE[0] - 1);
        colors.color(colors.least * libm::exp(part * decades))
    });
    let row: Vec<[u8; 3]> = row.collect();
    Image::opaque(SIZE, row.repeat(SIZE[1] as usize))
}

/// A picture as the bytes of a PNG.
pub(super) fn png(image: &Image) -> Result<Vec<u8>, Failure> {
    let mut bytes = Vec::new();
    image.write_png_to(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_cover_all() {
        let values: Vec<f32> = (0..5 * 3).map(|value| value as f32).collect();
        let reduced = Reduced::new(5, 15, 3);
        assert_eq!(reduced.resolution(), [3, 2]);
        assert_eq!(reduced.largest(&values), [6.0, 8.0, 9.0, 11.0, 13.0, 14.0]);
        let pixels: Vec<[f32; 4]> = values.iter().map(|&value| [value; 4]).collect();
        let means = reduced.means(&pixels);
        let expected = [3.0, 5.0, 6.5, 10.5, 12.5, 14.0];
        assert!(
            means
                .iter()
                .zip(expected)
                .all(|(mean, value)| *mean == [value; 4])
        );
        assert_eq!(Reduced::new(1, 1, 480).resolution(), [1, 1]);
    }
}
