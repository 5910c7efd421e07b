//! A picture against its reference, in numbers and as a picture of its error.

use candela::Primaries;
use candela::compare::{self, FalseColor, Metrics, Pair};
use candela::display::{Exposure, Image, Picture, exposure};
use candela::image::Film;
use serde::Serialize;

use super::pictures::{Reduced, THUMBNAIL};
use crate::cli::Failure;

/// R, G, B of a picture, plane by plane, row by row.
pub(super) type Planes = [Vec<f32>; 3];

/// What pictures are measured against.
pub(super) struct Truth {
    pub(super) width: usize,
    pub(super) planes: Planes,
    primaries: Primaries,
    /// In linear Rec.709, 1 the screen's white at `ev`, and what the exposure multiplies by.
    shown: Vec<[f32; 3]>,
    scale: f32,
    /// The exposure at which it is shown.
    pub(super) ev: f64,
    /// The mean of R, G and B of all pixels, in cd/m².
    pub(super) mean: f64,
    /// The median of what is above 0, in cd/m²; 0 where nothing is.
    pub(super) median: f64,
}

/// How far a picture is from the truth. `None` where there is no such number, as of a black picture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Errors {
    /// √mean (I − R)² of R, G, B of all pixels, in cd/m².
    #[serde(rename = "rmse_cd_m2")]
    pub(super) rmse: f64,
    /// That in percent of the reference's mean.
    pub(super) rmse_percent: Option<f64>,
    /// mean (I − R)² / (R² + ε), ε = 10⁻² median².
    pub(super) relmse: Option<f64>,
    /// 99.9 % of the pixels have no larger |I − R| / max(R, 10⁻³ median).
    pub(super) relative_p999: Option<f64>,
    /// The largest of them.
    pub(super) relative_max: Option<f64>,
    /// The mean of ꟻLIP, as shown.
    pub(super) flip: f64,
    /// The mean of HDR-ꟻLIP.
    pub(super) hdr_flip: Option<f64>,
}

impl Truth {
    pub(super) fn new(film: &Film) -> Result<Self, Failure> {
        let planes = planes(film.pixels())?;
        let ev = Exposure::Auto.ev(&Picture::of_film(film));
        let scale = exposure::scale(ev) as f32;
        let primaries = film.metadata().color_space.primaries();
        let values = || planes.iter().flatten().map(|&value| f64::from(value));
        let mut truth = Self {
            width: film.window().width as usize,
            mean: values().sum::<f64>() / values().count() as f64,
            shown: shown(&planes, &primaries, scale)?,
            primaries,
            scale,
            ev,
            median: 0.0,
            planes,
        };
        truth.median = Metrics::new(&truth.pair(&truth.planes).borrowed(), 1.0)?.median;
        Ok(truth)
    }

    fn pair<'p>(&'p self, image: &'p Planes) -> PairOf<'p> {
        PairOf {
            width: self.width,
            reference: self.planes.each_ref().map(Vec::as_slice),
            image: image.each_ref().map(Vec::as_slice),
        }
    }

    /// Whether there is light to which errors can be relative.
    pub(super) fn has_light(&self) -> bool {
        self.median > 0.0 && self.mean > 0.0
    }

    /// An error in cd/m² in percent of the mean.
    pub(super) fn percent(&self, error: f64) -> Option<f64> {
        self.has_light().then(|| 100.0 * error / self.mean)
    }

    /// How far a picture is from it.
    pub(super) fn errors(&self, image: &Planes) -> Result<Errors, Failure> {
        let metrics = Metrics::new(&self.pair(image).borrowed(), 1.0)?;
        let of_light = |value: f64| self.has_light().then_some(value);
        let (flip, hdr_flip) = if metrics.max_error == 0.0 {
            // Nothing flips, at any exposure.
            (0.0, of_light(0.0))
        } else {
            let shown = shown(image, &self.primaries, self.scale)?;
            let flip = compare::ldr_flip(self.width, &self.shown, &shown)?;
            let hdr = compare::hdr_flip(self.width, &self.shown, &shown)?;
            (mean(&flip), hdr.as_deref().map(mean))
        };
        Ok(Errors {
            rmse: metrics.rmse,
            rmse_percent: self.percent(metrics.rmse),
            relmse: of_light(metrics.relmse),
            relative_p999: of_light(metrics.relative_p999),
            relative_max: of_light(metrics.relative_max),
            flip,
            hdr_flip,
        })
    }

    /// The part of the pixels of which no channel is off by more than `relative` times the larger of the reference and
    /// `floor`.
    pub(super) fn within(&self, image: &Planes, relative: f64, floor: f64) -> f64 {
        let count = self.planes[0].len();
        let is_within = |pixel: &usize| {
            self.planes.iter().zip(image).all(|(reference, image)| {
                let [r, i] = [reference[*pixel], image[*pixel]].map(f64::from);
                (i - r).abs() <= relative * r.max(floor)
            })
        };
        (0..count).filter(is_within).count() as f64 / count as f64
    }

    /// √mean (I − R)², in cd/m².
    pub(super) fn rmse(&self, image: &Planes) -> Result<f64, Failure> {
        Ok(Metrics::new(&self.pair(image).borrowed(), 1.0)?.rmse)
    }

    /// The relative errors of a picture's pixels in false colors, small.
    pub(super) fn error_picture(&self, image: &Planes) -> Result<Image, Failure> {
        let errors = compare::relative_errors(&self.pair(image).borrowed())?;
        let reduced = Reduced::new(self.width, errors.len(), THUMBNAIL);
        let colors = reduced.largest(&errors).into_iter();
        let colors = colors.map(|error| FalseColor::RELATIVE.color(error.into()));
        Ok(Image::opaque(reduced.resolution(), colors.collect()))
    }
}

/// The parts of a [`Pair`].
struct PairOf<'p> {
    width: usize,
    reference: [&'p [f32]; 3],
    image: [&'p [f32]; 3],
}

impl PairOf<'_> {
    fn borrowed(&self) -> Pair<'_> {
        Pair {
            width: self.width,
            reference: &self.reference,
            image: &self.image,
            relative: 3,
        }
    }
}

/// R, G, B of pixels, plane by plane.
pub(super) fn planes(pixels: &[[f32; 4]]) -> Result<Planes, Failure> {
    let mut planes = Planes::default();
    for (channel, plane) in planes.iter_mut().enumerate() {
        plane.try_reserve_exact(pixels.len())?;
        plane.extend(pixels.iter().map(|pixel| pixel[channel]));
    }
    Ok(planes)
}

/// A picture in linear Rec.709, exposed.
fn shown(planes: &Planes, primaries: &Primaries, scale: f32) -> Result<Vec<[f32; 3]>, Failure> {
    let mut pixels = compare::rec709(planes.each_ref().map(Vec::as_slice), primaries)?;
    for pixel in pixels.as_flattened_mut() {
        *pixel *= scale;
    }
    Ok(pixels)
}

/// The mean, summed up in f64.
fn mean(values: &[f32]) -> f64 {
    values.iter().copied().map(f64::from).sum::<f64>() / values.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four pixels of 1 cd/m².
    fn white() -> Truth {
        let planes = [const { [1.0; 4] }; 3].map(Vec::from);
        Truth {
            width: 2,
            primaries: Primaries::REC709,
            shown: shown(&planes, &Primaries::REC709, 1.0).unwrap(),
            scale: 1.0,
            ev: 0.0,
            mean: 1.0,
            median: 1.0,
            planes,
        }
    }

    #[test]
    fn errors_of_a_picture_that_is_known() {
        let truth = white();
        let mut image = truth.planes.clone();
        image[0][1] = 1.5;
        let errors = truth.errors(&image).unwrap();
        // One of twelve values is off by a half.
        let rmse = f64::sqrt(0.25 / 12.0);
        assert_eq!(errors.rmse, rmse);
        assert_eq!(errors.rmse_percent, Some(100.0 * rmse));
        assert_eq!(errors.relmse, Some(0.25 / 1.01 / 12.0));
        assert_eq!(errors.relative_max, Some(0.5));
        assert!(errors.hdr_flip.unwrap() > 0.0);
        // Beyond the screen's white nothing is to be seen.
        assert_eq!(errors.flip, 0.0);
        assert_eq!(truth.within(&image, 0.5, 0.1), 1.0);
        assert_eq!(truth.within(&image, 0.4, 0.1), 0.75);
        // Of what the floor is.
        assert_eq!(truth.within(&image, 0.4, 2.0), 1.0);
    }

    #[test]
    fn the_same_picture_has_no_error() {
        let truth = white();
        let errors = truth.errors(&truth.planes).unwrap();
        assert_eq!([errors.rmse, errors.flip], [0.0; 2]);
        assert_eq!(
            [errors.relmse, errors.relative_p999, errors.hdr_flip],
            [Some(0.0); 3]
        );
    }

    #[test]
    fn of_a_black_picture_nothing_is_relative() {
        let mut truth = white();
        truth.planes = [const { [0.0; 4] }; 3].map(Vec::from);
        truth.shown.fill([0.0; 3]);
        (truth.mean, truth.median) = (0.0, 0.0);
        let image = white().planes;
        let errors = truth.errors(&image).unwrap();
        assert_eq!(errors.rmse, 1.0);
        let relative = [
            errors.rmse_percent,
            errors.relmse,
            errors.relative_p999,
            errors.relative_max,
        ];
        assert_eq!(relative, [None; 4]);
        assert!(errors.flip > 0.9);
    }
}
