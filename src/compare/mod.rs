//! How far an image is from a reference: errors of numbers, of light, and of what a viewer sees.
//!
//! | | metric | where |
//! | --- | --- | --- |
//! | absolute | mean \|I − R\|, √mean (I − R)², 20 log₁₀(peak / RMSE), max \|I − R\| | [`Metrics`], as OpenImageIO's `idiff` |
//! | relative | mean (I − R)² / (R² + ε), percentiles of \|I − R\| / max(\|R\|, floor) | [`Metrics`] |
//! | perceived | ꟻLIP, of a picture on a screen and of all exposures | [`ldr_flip`], [`hdr_flip()`] |
//! | | a picture of the relative error | [`FalseColor`] |
//!
//! I is the image and R the reference. Sums have one order: the numbers are the same for any number of threads.

mod colors;
mod filter;
mod flip;
mod hdr_flip;
mod magma;
mod metrics;

pub use colors::FalseColor;
pub use flip::ldr_flip;
pub use hdr_flip::hdr_flip;
pub use metrics::{Metrics, Pair, Place, relative_errors};

use crate::color::Primaries;
use crate::color::adaptation::conversion;
use crate::memory::{OutOfMemory, reserve};
use glam::DVec3;
use rayon::prelude::*;

/// Pixels that a thread looks at in one go; sums are taken piece by piece, in order.
const PIECE: usize = 1 << 14;

/// Three planes of a color, R, G and B of these primaries, as pixels in linear Rec.709. What is not finite
/// becomes 0: it has no color.
///
/// # Errors
/// If there is not so much memory.
///
/// # Panics
/// If the planes are not of one length.
pub fn rec709(planes: [&[f32]; 3], primaries: &Primaries) -> Result<Vec<[f32; 3]>, OutOfMemory> {
    let [r, g, b] = planes;
    assert!(
        r.len() == g.len() && g.len() == b.len(),
        "planes of one image"
    );
    let matrix =
        (*primaries != Primaries::REC709).then(|| conversion(primaries, &Primaries::REC709));
    let mut pixels = room(r.len(), [0.0; 3])?;
    pixels
        .par_iter_mut()
        .enumerate()
        .for_each(|(index, pixel)| {
            let rgb = [r[index], g[index], b[index]];
            let rgb = rgb.map(|value| if value.is_finite() { value } else { 0.0 });
            *pixel = match matrix {
                None => rgb,
                Some(matrix) => {
                    let converted = matrix * DVec3::from(rgb.map(f64::from));
                    converted.to_array().map(|channel| channel as f32)
                }
            };
        });
    Ok(pixels)
}

/// A list of so many values, or an error where there is no memory for it.
fn room<T: Clone>(count: usize, value: T) -> Result<Vec<T>, OutOfMemory> {
    let mut list = Vec::new();
    reserve(&mut list, count).map_err(|error| error.for_what("comparing the images"))?;
    list.resize(count, value);
    Ok(list)
}
