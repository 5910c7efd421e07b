//! The mean of L9 and A over the square of a pixel, which its box filter has: to far more digits than samples give.
//!
//! Along a line of the image L is smooth but for where something else is met, or a light is decided on otherwise. So a
//! line is parted there (`line`), by bisection, and each piece is integrated by Gauss and Legendre's rules (`gauss`).
//! Lines that have the same pieces, in the same order, make a strip (`strip`); where it ends is found by bisection as
//! well, and over it integrals of lines are smooth again.
//!
//! Light of an area has kinks where its penumbra begins and where an edge in it does, but no jumps: there pieces are
//! halved until both rules agree.
//!
//! Where a smooth surface is seen, L is that of all its ways, and pieces are those where no way changes. Rounds of a lobe
//! or a light are not looked for there: what is small in a mirror may be missed.
//!
//! What is thin is looked for on 17 lines at 16 and more points of each, and once it is seen it is followed. What none
//! of these points meets, a 300th of the pixel's area or less, is missed, and no error tells of it.

mod gauss;
mod line;
mod point;
mod scope;
mod strip;
#[cfg(test)]
mod tests;

use std::collections::HashMap;
use std::sync::Arc;

use super::Oracle;
use super::lighting::Material;
use point::Points;
use scope::Ball;
use strip::Strips;

/// How far the lines and their ends stay within the pixel: at its very sides an edge that is exactly there would decide.
const INSET: f64 = 1e-9;

/// Of sums of some thousand numbers, relative.
const ROUNDING: f64 = 1e-13;

/// The mean over the square of a pixel, as its box filter takes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelMean {
    /// Of L9, or the background where nothing is hit, in cd/m²: linear RGB of the scene's color space.
    pub radiance: [f64; 3],
    /// The part of the square where something is hit.
    pub coverage: f64,
    /// How far R, G, B and the coverage may be off: the differences of rules of two orders, the sizes of what was not
    /// looked at any closer times the spread of values, and the largest error of integrals over lights with an area.
    pub error: [f64; 4],
    /// Whether the pieces of the pixel were told apart. If not, the points ran out before, and the error is large.
    pub is_resolved: bool,
    /// At how many points of the image L9 was taken.
    pub points: usize,
}

/// Means over the pixels of an image.
#[derive(Clone, Debug)]
pub struct PixelQuadrature<'o> {
    oracle: &'o Oracle,
    /// The most points of a pixel.
    budget: usize,
    /// Turns one line's points into another pixel's.
    seed: u64,
    background: [f64; 3],
    /// What each light sends out, as the observer sees it.
    luminances: Vec<[f64; 3]>,
    /// For each light and object the material with I k, as the observer sees it, in the place of k.
    products: Vec<Vec<Arc<Material>>>,
    /// Around each surface, where it has an end.
    balls: Vec<Option<Ball>>,
}

/// An integral, and how far it may be off: R, G, B, A.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    value: [f64; 4],
    error: [f64; 4],
}

impl Sum {
    fn add(&mut self, part: f64, value: &[f64; 4], error: &[f64; 4]) {
        for channel in 0..4 {
            self.value[channel] += part * value[channel];
            self.error[channel] += part * error[channel];
        }
    }
}

impl<'o> PixelQuadrature<'o> {
    /// The most points of a pixel, unless it is [told otherwise](Self::with_budget).
    pub const BUDGET: usize = 60_000;

    /// Prepares an oracle's pixels.
    pub fn new(oracle: &'o Oracle) -> Self {
        let mut made: HashMap<(usize, *const Material), Arc<Material>> = HashMap::new();
        let products = oracle.lights.iter().enumerate().map(|(index, light)| {
            let of_object = |material: &Arc<Material>| {
                let key = (index, Arc::as_ptr(material));
                let product = made.entry(key).or_insert_with(|| {
                    let seen = |reflectance: &super::Components| {
                        super::Components(
                            oracle
                                .palette
                                .seen(&light.intensity.times(reflectance))
                                .to_vec(),
                        )
                    };
                    Arc::new(Material {
                        model: material.model,
                        diffuse: seen(&material.diffuse),
                        specular: seen(&material.specular),
                        shininess: material.shininess,
                    })
                });
                Arc::clone(product)
            };
            oracle
                .objects
                .iter()
                .map(|object| &object.material)
                .map(of_object)
                .collect()
        });
        Self {
            oracle,
            budget: Self::BUDGET,
            seed: 0,
            background: oracle.palette.seen(&oracle.background),
            luminances: oracle
                .lights
                .iter()
                .map(|light| oracle.palette.seen(&light.intensity))
                .collect(),
            products: products.collect(),
            balls: oracle.surfaces.iter().map(Ball::around).collect(),
        }
    }

    /// With so many points of a pixel at most; the more there are, the less is left unresolved.
    #[must_use]
    pub fn with_budget(self, budget: usize) -> Self {
        Self { budget, ..self }
    }

    /// With other points at the beginning: what one seed misses another may find.
    #[must_use]
    pub fn with_seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// The mean over the square from (`x`, `y`) to (`x` + 1, `y` + 1), in pixels from the top left corner of the image.
    ///
    /// It is refined until its error is about `tolerance` times the mean of each channel, or of one that is a thousandth
    /// of the largest, or until the points run out.
    pub fn pixel(&self, x: u32, y: u32, tolerance: f64) -> PixelMean {
        let (left, top) = (f64::from(x), f64::from(y));
        let mut points = Points::new(self, left, top, tolerance);
        let mut random = self.seed ^ (u64::from(x) << 32 | u64::from(y));
        let mut strips = Strips {
            points: &mut points,
            ends: [left, top].map(|low| [low + INSET, low + 1.0 - INSET]),
            allowed: [0.0; 4],
            is_resolved: true,
        };
        let lines = strips.scan(&mut random);
        strips.allowed = strips.points.scale().map(|scale| tolerance * scale);
        let sum = strips.integral(lines);
        let is_resolved = strips.is_resolved;
        let spread = points.spread();
        let noise = points.noise;
        // What is outside of the lines and their ends.
        let over = 1.0 / (1.0 - 2.0 * INSET).powi(2);
        let [r, g, b, coverage] = sum.value.map(|value| value * over);
        PixelMean {
            radiance: [r, g, b],
            coverage,
            error: std::array::from_fn(|channel| {
                let rounding = ROUNDING * sum.value[channel].abs();
                let unseen = 4.0 * INSET * spread[channel];
                sum.error[channel] * over + unseen + rounding + noise[channel]
            }),
            is_resolved,
            points: points.count,
        }
    }
}

/// From 0 to below 1 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014).
fn splitmix(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}
