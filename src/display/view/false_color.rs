//! Luminance or illuminance as colors, to read exposure or light levels from a picture.
//!
//! The luminance Y of the exposed radiance, by the weights of Rec.709, goes to a place on the map viridis by its
//! logarithm: equal ratios of light look equally far apart. Below the range a color is black, above it white; neither is
//! on the map.
//! Of stops, a third of a stop around middle gray shows as middle gray itself.

use fearless_simd::Simd;

use super::viridis::VIRIDIS;
use crate::color::Primaries;
use crate::color::transfer::srgb_decode;
use crate::display::exposure::{KEY, scale};
use crate::display::lanes::{Rgb, Transform, each, log2};
use crate::simd::{F64x16, LANES};

/// log₂ of [`KEY`].
const LOG2_KEY: f64 = -2.473_931_188_332_412;

/// How far from middle gray, in stops, it is marked.
const MARKED: f64 = 1.0 / 6.0;

/// What false colors show, and over which range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FalseColor {
    measure: Measure,
    /// log₂ of the luminances at the ends.
    ends: [f64; 2],
}

/// What the numbers beside false colors say.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Measure {
    /// Stops from middle gray, 0.18 of the screen's white, once the picture is exposed.
    Stops,
    /// Luminance in cd/m² as the file has it, whatever the exposure.
    Luminance,
    /// Illuminance in lx as a layer of the file has it, whatever the exposure.
    Illuminance,
}

/// A range that false colors cannot have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "false colors go from a number above 0 to a larger one, both from 1e-30 to 1e30, such as 0.1 to 1000; found \
     {least} to {most}"
)]
pub struct BadRange {
    /// Where it starts.
    pub least: f64,
    /// Where it ends.
    pub most: f64,
}

impl Default for FalseColor {
    /// Eight stops on each side of middle gray.
    fn default() -> Self {
        Self::STOPS
    }
}

impl FalseColor {
    /// Eight stops on each side of middle gray.
    pub const STOPS: Self = {
        const REACH: f64 = 8.0;
        Self {
            measure: Measure::Stops,
            ends: [LOG2_KEY - REACH, LOG2_KEY + REACH],
        }
    };

    /// Luminances in cd/m², by their logarithm.
    ///
    /// # Errors
    /// If `least` is not below `most`, or one of them is not from 1e-30 to 1e30.
    pub fn luminance(least: f64, most: f64) -> Result<Self, BadRange> {
        Self::of(Measure::Luminance, least, most)
    }

    /// Illuminances in lx, by their logarithm.
    ///
    /// # Errors
    /// If `least` is not below `most`, or one of them is not from 1e-30 to 1e30.
    pub fn illuminance(least: f64, most: f64) -> Result<Self, BadRange> {
        Self::of(Measure::Illuminance, least, most)
    }

    fn of(measure: Measure, least: f64, most: f64) -> Result<Self, BadRange> {
        let is_legal = |end: &f64| (1e-30..=1e30).contains(end);
        if least < most && is_legal(&least) && is_legal(&most) {
            Ok(Self {
                measure,
                ends: [least.log2(), most.log2()],
            })
        } else {
            Err(BadRange { least, most })
        }
    }

    /// What the range is of.
    pub const fn measure(&self) -> Measure {
        self.measure
    }

    /// The ends of the range: in stops, in cd/m², or in lx.
    pub fn range(&self) -> [f64; 2] {
        let [least, most] = self.ends;
        match self.measure {
            Measure::Stops => [least - LOG2_KEY, most - LOG2_KEY],
            Measure::Luminance | Measure::Illuminance => [least.exp2(), most.exp2()],
        }
    }

    /// Where a number of the range is between its ends, 0 to 1; beyond them outside of that.
    pub fn part(&self, number: f64) -> f64 {
        let [least, most] = self.ends;
        let logarithm = match self.measure {
            Measure::Stops => number + LOG2_KEY,
            Measure::Luminance | Measure::Illuminance => libm::log2(number),
        };
        (logarithm - least) / (most - least)
    }

    /// The sRGB-coded color of a part of the range.
    pub fn color(&self, part: f64) -> [u8; 3] {
        let [least, most] = self.ends;
        let logarithm = least + part * (most - least);
        if self.measure == Measure::Stops && (logarithm - LOG2_KEY).abs() <= MARKED {
            // sRGB codes 0.18 as 117.6 of 255.
            return [118; 3];
        }
        // `as` makes 0 of what is below, and of NaN.
        VIRIDIS[((part * 255.0 + 0.5) as usize).min(255)]
    }

    /// The view of a picture that is exposed by 2^`ev`.
    pub(in crate::display) fn map(self, ev: f64) -> Map {
        let [least, most] = self.ends;
        let (least, marked) = match self.measure {
            Measure::Stops => (least, MARKED),
            Measure::Luminance | Measure::Illuminance => (least + scale(ev).log2(), -1.0),
        };
        Map {
            weights: Primaries::REC709.luminance_weights(),
            least,
            length: most - self.ends[0],
            marked,
            middle: LOG2_KEY,
            colors: Box::new(
                VIRIDIS.map(|codes| {
                    codes.map(|code| srgb_decode(f64::from(code) / f64::from(u8::MAX)))
                }),
            ),
        }
    }
}

/// Exposed luminance to the light of its false color.
pub(in crate::display) struct Map {
    /// Of R, G, B in the luminance.
    weights: [f64; 3],
    /// log₂ of the exposed luminance where the map begins, and how many stops it has.
    least: f64,
    length: f64,
    /// So far from this logarithm, gray is gray; never where it is below 0.
    marked: f64,
    middle: f64,
    colors: Box<[[f64; 3]; 256]>,
}

impl Transform for Map {
    #[inline(always)]
    fn apply<S: Simd>(&self, simd: S, [r, g, b]: Rgb<S>) -> Rgb<S> {
        let (zero, one) = (F64x16::splat(simd, 0.0), F64x16::splat(simd, 1.0));
        let luminance = r * self.weights[0] + g * self.weights[1] + b * self.weights[2];
        let is_lit = luminance.ge(F64x16::splat(simd, f64::MIN_POSITIVE));
        let logarithm = log2(simd, is_lit.select(luminance, one));
        let part = (logarithm - self.least) / self.length;
        let is_below = !is_lit | part.lt(zero);
        let is_above = is_lit & part.gt(one);
        let is_middle = is_lit
            & (logarithm - self.middle)
                .abs()
                .le(F64x16::splat(simd, self.marked));

        let place = part.max(zero).min(one) * 255.0;
        let cell = place.floor().min(F64x16::splat(simd, 254.0));
        let (part, cells) = (place - cell, cell.to_array());
        let mut before = [[0.0; LANES]; 3];
        let mut after = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let cell = cells[lane] as usize;
            let ([r, g, b], [next_r, next_g, next_b]) = (self.colors[cell], self.colors[cell + 1]);
            before[0][lane] = r;
            before[1][lane] = g;
            before[2][lane] = b;
            after[0][lane] = next_r;
            after[1][lane] = next_g;
            after[2][lane] = next_b;
        }
        let middle = F64x16::splat(simd, KEY);
        let [before_r, before_g, before_b] = before;
        let [after_r, after_g, after_b] = after;
        let between = [
            between(simd, &before_r, &after_r, part),
            between(simd, &before_g, &after_g, part),
            between(simd, &before_b, &after_b, part),
        ];
        each(
            between,
            #[inline(always)]
            |between| {
                let inside = is_middle.select(middle, between);
                is_below.select(zero, is_above.select(one, inside))
            },
        )
    }
}

#[inline(always)]
fn between<S: Simd>(
    simd: S,
    before: &[f64; LANES],
    after: &[f64; LANES],
    part: F64x16<S>,
) -> F64x16<S> {
    F64x16::load(simd, before) * (-part + 1.0) + F64x16::load(simd, after) * part
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::lanes::of_one;

    /// The nearest codes of the light of a gray's false color.
    fn codes(by: &Map, light: f64) -> [u8; 3] {
        let code = |light: f64| (crate::color::transfer::srgb_encode(light) * 255.0).round() as u8;
        of_one(by, [light; 3]).map(code)
    }

    /// The list of the map's authors, <https://github.com/BIDS/colormap>, in 8 bits.
    #[test]
    fn published_colors() {
        assert_eq!(VIRIDIS[0], [68, 1, 84]);
        assert_eq!(VIRIDIS[64], [59, 82, 139]);
        assert_eq!(VIRIDIS[128], [33, 145, 140]);
        assert_eq!(VIRIDIS[192], [94, 201, 98]);
        assert_eq!(VIRIDIS[255], [253, 231, 37]);
    }

    #[test]
    fn stops_are_equal_parts() {
        let map = FalseColor::default().map(0.0);
        for stop in -8..=8 {
            let place = f64::from(stop + 8) / 16.0 * 255.0;
            let got = codes(&map, 0.18 * f64::from(stop).exp2() * 1.000_001);
            if stop == 0 {
                assert_eq!(got, [118; 3]);
            } else if stop < 8 {
                // Between two entries, either is near.
                let entry = VIRIDIS[place.round() as usize];
                let off = got
                    .iter()
                    .zip(entry)
                    .map(|(&got, entry)| got.abs_diff(entry))
                    .max();
                assert!(off <= Some(1), "{stop}: {got:?}, {entry:?}");
            }
        }
        assert_eq!(codes(&map, 0.18 * 7.999_f64.exp2()), VIRIDIS[255]);
    }

    #[test]
    fn outside_is_black_or_white() {
        let map = FalseColor::default().map(0.0);
        for dark in [0.0, -1.0, -1e30, 1e-310, 0.18 * (-8.001_f64).exp2()] {
            assert_eq!(codes(&map, dark), [0; 3], "{dark}");
        }
        for bright in [0.18 * 8.001_f64.exp2(), 1e30] {
            assert_eq!(codes(&map, bright), [255; 3], "{bright}");
        }
    }

    /// Red, green and blue of one luminance have one color.
    #[test]
    fn luminance_alone_counts() {
        let map = FalseColor::default().map(0.0);
        let weights = Primaries::REC709.luminance_weights();
        let gray = of_one(&map, [0.5; 3]);
        for (channel, weight) in weights.into_iter().enumerate() {
            let mut rgb = [0.0; 3];
            rgb[channel] = 0.5 / weight;
            let colored = of_one(&map, rgb);
            for (colored, gray) in colored.iter().zip(gray) {
                assert!((colored - gray).abs() < 1e-11);
            }
        }
    }

    /// cd/m² are those of the file, whatever the exposure.
    #[test]
    fn luminance_does_not_depend_on_the_exposure() {
        let colors = FalseColor::luminance(0.1, 1000.0).unwrap();
        for ev in [-6.0, 0.0, 3.5] {
            let map = colors.map(ev);
            let exposed = |luminance: f64| luminance * ev.exp2();
            assert_eq!(codes(&map, exposed(0.100_001)), VIRIDIS[0]);
            assert_eq!(codes(&map, exposed(0.099)), [0; 3]);
            assert_eq!(codes(&map, exposed(999.999)), VIRIDIS[255]);
            assert_eq!(codes(&map, exposed(1001.0)), [255; 3]);
            // Three of four decades: 191.25.
            let [r, ..] = codes(&map, exposed(100.0));
            assert!((VIRIDIS[191][0]..=VIRIDIS[192][0]).contains(&r));
            // Middle gray has no mark here.
            assert_ne!(codes(&map, 0.18), [118; 3]);
        }
        assert_eq!(colors.part(10.0), 0.5);
        assert_eq!(colors.color(colors.part(0.1)), VIRIDIS[0]);
    }

    #[test]
    fn ranges_go_up() {
        for (least, most) in [
            (0.0, 1.0),
            (1.0, 1.0),
            (2.0, 1.0),
            (-1.0, 1.0),
            (1.0, f64::NAN),
        ] {
            assert!(FalseColor::luminance(least, most).is_err());
        }
        let [least, most] = FalseColor::default().range();
        assert!((least + 8.0).abs() < 1e-14 && (most - 8.0).abs() < 1e-14);
    }
}
