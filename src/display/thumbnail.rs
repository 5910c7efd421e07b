//! A file's picture made small, as it is read: the means of the light, or of the numbers, over the area of each pixel.

use rayon::prelude::*;

use super::exposure::{Exposure, LogSum, Meter};
use super::picture::{Prepare, Repaired};
use super::source::Source;
use super::{Alpha, DisplayError, Frame, Image, Input, Picture, Settings, tonemap};
use crate::exr::{ColorTag, Content, ExrImage};
use crate::image::{BACKGROUND_DEPTH, Window};
use crate::memory;

/// Numbers whose largest is so many times their least are shown by their logarithm.
const LOGARITHMIC: f64 = 100.0;

/// A small picture of what a file shows.
#[derive(Clone, Debug)]
pub struct Thumbnail {
    resolution: [u32; 2],
    /// R, G, B, A row by row; what is not light is multiplied by A, the share that has a number.
    pixels: Vec<[f32; 4]>,
    content: Content,
    has_alpha: bool,
    ev: f64,
    /// Of all numbers of the file, the components of vectors among them.
    ends: Option<[f32; 2]>,
    warnings: Vec<String>,
}

/// What a gray stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// What is black; of vectors, what is minus one.
    pub least: f64,
    /// What is white.
    pub most: f64,
    /// Whether grays go by the logarithm.
    pub is_logarithmic: bool,
}

/// What one row adds.
struct Row {
    means: Vec<[f64; 4]>,
    logarithms: LogSum,
    ends: Option<[f32; 2]>,
    repaired: Repaired,
}

impl Thumbnail {
    /// The display window of a file in so many pixels, at least one in each direction, with the exposure that it has at
    /// its full size.
    ///
    /// # Errors
    /// If the file cannot be read, or there is no memory for so many pixels.
    pub fn new(
        input: &Input,
        resolution: [u32; 2],
        exposure: Exposure,
    ) -> Result<Self, DisplayError> {
        let exr = Source::from(input);
        let meter = Meter::new(exposure);
        exr.check_resolution()?;
        let resolution = resolution.map(|side| side.max(1));
        let content = exr.content();
        let color = exr.color().meaning();
        let prepare = Prepare::from(&color.primaries, false);
        let [columns, lines] =
            [0, 1].map(|side| Axis::new(exr.resolution()[side], resolution[side]));

        let count = resolution[0] as usize * resolution[1] as usize;
        let mut sums: Vec<[f64; 4]> = Vec::new();
        memory::reserve(&mut sums, count)
            .map_err(|error| DisplayError::Memory(error.for_what("a small picture")))?;
        sums.resize(count, [0.0; 4]);
        let (mut logarithms, mut ends) = (LogSum::default(), None);
        let mut repaired = Repaired::default();
        let window = exr.window();
        let (width, left, top) = window.map_or((1, 0, 0), |w| (w.width as usize, w.x, w.y));
        for band in exr.bands() {
            let mut pixels = exr.rows(band.clone())?;
            let rows = pixels.par_chunks_mut(width).map(|row| {
                let (repaired, ends) = match content {
                    Content::Light => (prepare.apply(row), None),
                    Content::Vectors | Content::Numbers => (Repaired::default(), keep_numbers(row)),
                };
                Row {
                    means: columns.means(left, row),
                    logarithms: match &meter {
                        Ok(meter) => meter.of_row(row),
                        Err(_) => LogSum::default(),
                    },
                    ends,
                    repaired,
                }
            });
            let rows: Vec<Row> = rows.collect();
            // In order: the same sums for any number of threads.
            for (row, line) in rows.into_iter().zip(band) {
                logarithms = logarithms.and(row.logarithms);
                repaired = repaired.and(row.repaired);
                ends = both(ends, row.ends);
                for (place, weight) in lines.shares(top + line) {
                    let into = &mut sums[place * row.means.len()..][..row.means.len()];
                    for (sum, mean) in into.iter_mut().zip(&row.means) {
                        add(sum, *mean, weight);
                    }
                }
            }
        }
        let mut warnings = exr.warnings();
        warnings.extend(color.warning);
        warnings.extend(repaired.warnings(false));
        Ok(Self {
            resolution,
            pixels: sums
                .into_iter()
                .map(|sum| sum.map(|value| value as f32))
                .collect(),
            content,
            has_alpha: exr.has_alpha(),
            ev: match meter {
                Err(ev) => ev,
                Ok(meter) if content == Content::Light => meter.ev(logarithms),
                Ok(_) => 0.0,
            },
            ends,
            warnings,
        })
    }

    /// What the user should know about the file, a sentence each.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// What it is a picture of.
    pub const fn content(&self) -> Content {
        self.content
    }

    /// The exposure in EV: the given one, or that of the light of the file.
    pub const fn ev(&self) -> f64 {
        self.ev
    }

    /// The light as a screen shows it, over black.
    pub fn developed(&self, settings: &Settings<'_>) -> Image {
        let [width, height] = self.resolution;
        let picture = Picture::new(ExrImage {
            resolution: self.resolution,
            window: Some(Window {
                x: 0,
                y: 0,
                width,
                height,
            }),
            pixels: self.pixels.clone(),
            has_alpha: self.has_alpha,
            // Prepared already.
            color: ColorTag::default(),
        });
        let settings = Settings {
            alpha: Alpha::Opaque,
            frame: Frame::Display,
            ..*settings
        };
        tonemap(&picture, &settings)
    }

    /// From what to what the numbers go; `None` where there are none. Of vectors, to both sides of 0.
    pub fn range(&self) -> Option<Range> {
        let [least, most] = self.ends?.map(f64::from);
        Some(match self.content {
            Content::Vectors => {
                // Unit vectors may be off by a rounding.
                let reach = least.abs().max(most.abs());
                let reach = if reach <= 1.001 { 1.0 } else { reach };
                Range {
                    least: -reach,
                    most: reach,
                    is_logarithmic: false,
                }
            }
            Content::Light | Content::Numbers => Range {
                least,
                most,
                is_logarithmic: least > 0.0 && most / least > LOGARITHMIC,
            },
        })
    }

    /// The numbers as grays over [`Thumbnail::range`], vectors as colors; what has none is `nothing`.
    pub fn scaled(&self, nothing: [u8; 3]) -> Image {
        let range = self.range();
        let nothing = nothing.map(f64::from);
        let color = |&[x, y, z, share]: &[f32; 4]| {
            let share = f64::from(share).clamp(0.0, 1.0);
            let codes: [f64; 3] = std::array::from_fn(|channel| {
                let mean = f64::from([x, y, z][channel]) / share;
                let code = range.map_or(0.0, |range| 255.0 * range.part(mean));
                if share > 0.0 {
                    share * code + (1.0 - share) * nothing[channel]
                } else {
                    nothing[channel]
                }
            });
            codes.map(|code| (code + 0.5) as u8)
        };
        Image::opaque(self.resolution, self.pixels.iter().map(color).collect())
    }
}

impl Range {
    /// Where a number is, from 0 to 1.
    fn part(self, number: f64) -> f64 {
        let Self { least, most, .. } = self;
        let part = if self.is_logarithmic {
            libm::log(number / least) / libm::log(most / least)
        } else if most > least {
            (number - least) / (most - least)
        } else {
            // All are equal.
            0.5
        };
        part.clamp(0.0, 1.0)
    }
}

/// Leaves of a row what is a number, with an A of 1, and nothing of the rest; from what to what the numbers go.
/// The depth of nothing is no number.
fn keep_numbers(row: &mut [[f32; 4]]) -> Option<[f32; 2]> {
    let mut ends = None;
    for pixel in row {
        let [x, y, z, _] = *pixel;
        let numbers = [x, y, z];
        if numbers.iter().all(|number| number.abs() < BACKGROUND_DEPTH) {
            *pixel = [x, y, z, 1.0];
            let least = x.min(y).min(z);
            let most = x.max(y).max(z);
            ends = both(ends, Some([least, most]));
        } else {
            *pixel = [0.0; 4];
        }
    }
    ends
}

fn both(one: Option<[f32; 2]>, other: Option<[f32; 2]>) -> Option<[f32; 2]> {
    match (one, other) {
        (Some([a, b]), Some([c, d])) => Some([a.min(c), b.max(d)]),
        (one, other) => one.or(other),
    }
}

fn add(sum: &mut [f64; 4], value: [f64; 4], weight: f64) {
    for (sum, value) in sum.iter_mut().zip(value) {
        *sum += value * weight;
    }
}

/// One side of a picture, and of a smaller or larger one.
#[derive(Clone, Copy)]
struct Axis {
    from: u32,
    to: u32,
}

impl Axis {
    const fn new(from: u32, to: u32) -> Self {
        Self { from, to }
    }

    /// The places that pixel `number` of the picture is in, and which share of each it covers. In whole numbers:
    /// shares of a place have the sum 1, but for rounding.
    fn shares(self, number: u32) -> impl Iterator<Item = (usize, f64)> {
        // In units in which a pixel is `to` wide, and a place `from`.
        let (from, to) = (u64::from(self.from), u64::from(self.to));
        let start = u64::from(number) * to;
        let end = start + to;
        let places = start / from..end.div_ceil(from).min(to);
        places.map(move |place| {
            let covered = end.min((place + 1) * from) - start.max(place * from);
            (place as usize, covered as f64 / from as f64)
        })
    }

    /// The means of a row that starts at pixel `left`.
    fn means(self, left: u32, row: &[[f32; 4]]) -> Vec<[f64; 4]> {
        let mut means = vec![[0.0; 4]; self.to as usize];
        for (number, pixel) in (left..).zip(row) {
            for (place, weight) in self.shares(number) {
                add(&mut means[place], pixel.map(f64::from), weight);
            }
        }
        means
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_cover_each_place_once() {
        for (from, to) in [
            (7, 3),
            (3, 7),
            (4, 2),
            (2, 4),
            (5, 5),
            (1, 6),
            (6, 1),
            (1280, 480),
        ] {
            let axis = Axis::new(from, to);
            let mut sums = vec![0.0; to as usize];
            for number in 0..from {
                for (place, weight) in axis.shares(number) {
                    assert!(weight > 0.0 && weight <= 1.0);
                    sums[place] += weight;
                }
            }
            assert!(
                sums.iter().all(|sum: &f64| (sum - 1.0).abs() < 1e-14),
                "{from} to {to}: {sums:?}"
            );
        }
    }

    #[test]
    fn means_are_by_area() {
        let row: Vec<[f32; 4]> = [3.0, 6.0, 9.0].iter().map(|&value| [value; 4]).collect();
        let assert_means = |to, expected: &[f64]| {
            let means = Axis::new(3, to).means(0, &row);
            assert_eq!(means.len(), expected.len());
            for (mean, expected) in means.into_iter().zip(expected) {
                assert!((mean[0] - expected).abs() < 1e-14);
            }
        };
        assert_means(1, &[6.0]);
        // The middle one is half in each.
        assert_means(2, &[4.0, 8.0]);
        assert_means(6, &[3.0, 3.0, 6.0, 6.0, 9.0, 9.0]);
    }

    fn small(content: Content, ends: [f32; 2], pixels: &[[f32; 4]]) -> Thumbnail {
        Thumbnail {
            resolution: [pixels.len() as u32, 1],
            pixels: pixels.to_vec(),
            content,
            has_alpha: false,
            ev: 0.0,
            ends: Some(ends),
            warnings: Vec::new(),
        }
    }

    #[test]
    fn numbers_go_from_black_to_white() {
        let gray = |value: f32| [value, value, value, 1.0];
        let half = [1.5, 1.5, 1.5, 0.5];
        let pixels = [gray(1.0), gray(3.0), gray(5.0), [0.0; 4], half];
        let depth = small(Content::Numbers, [1.0, 5.0], &pixels);
        let expected = [[0; 3], [128; 3], [255; 3], [10, 20, 30], [69, 74, 79]];
        assert_eq!(
            depth.scaled([10, 20, 30]).samples(),
            expected.as_flattened()
        );
        // A quarter of eight stops.
        let stops = small(Content::Numbers, [0.25, 64.0], &[gray(1.0)]);
        assert!(stops.range().unwrap().is_logarithmic);
        assert_eq!(stops.scaled([0; 3]).samples(), [64; 3]);
        let flat = small(Content::Numbers, [2.0, 2.0], &[gray(2.0)]);
        assert_eq!(flat.scaled([0; 3]).samples(), [128; 3]);
    }

    #[test]
    fn vectors_are_colors() {
        let normals = small(Content::Vectors, [-0.6, 1.000_1], &[[0.0, 1.0, -1.0, 1.0]]);
        assert_eq!(normals.scaled([0; 3]).samples(), [128, 255, 0]);
        let places = small(Content::Vectors, [-2.0, 8.0], &[[8.0, -4.0, 0.0, 1.0]]);
        let range = places.range().unwrap();
        assert_eq!((range.least, range.most), (-8.0, 8.0));
        assert_eq!(places.scaled([0; 3]).samples(), [255, 64, 128]);
    }

    #[test]
    fn what_is_no_number_is_nothing() {
        let mut row = [
            [f32::NAN, 0.0, 0.0, 1.0],
            [1.0, 2.0, 3.0, 1.0],
            [BACKGROUND_DEPTH; 4],
            [f32::NEG_INFINITY, 0.0, 0.0, 1.0],
        ];
        assert_eq!(keep_numbers(&mut row), Some([1.0, 3.0]));
        assert_eq!(row, [[0.0; 4], [1.0, 2.0, 3.0, 1.0], [0.0; 4], [0.0; 4]]);
        assert_eq!(keep_numbers(&mut [[f32::NAN; 4]]), None);
    }
}
