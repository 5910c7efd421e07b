//! ꟻLIP of light that no screen shows at once: the largest over all exposures that show something.
//!
//! Andersson, Nilsson, Shirley & Akenine-Möller 2021, "Visualizing Errors in Rendered High Dynamic Range Images",
//! with the authors' default tone mapper, a fit of ACES.

use rayon::prelude::*;

use super::flip::flip_of;
use super::room;
use crate::memory::OutOfMemory;

/// Exposures go from where the brightest pixel comes to this code value to where the median does.
const BRIGHT: f32 = 0.85;

/// The tone mapper: (c₀ x² + c₁ x + c₂) / (c₃ x² + c₄ x + c₅), without the exposure of 0.6 that belongs to it.
const TONE: [f32; 6] = [
    0.6 * 0.6 * 2.51,
    0.6 * 0.03,
    0.0,
    0.6 * 0.6 * 2.43,
    0.6 * 0.59,
    0.14,
];

/// HDR-ꟻLIP of two pictures in linear Rec.709, of any unit, row by row from 0 to 1; `None` where the median luminance
/// of the reference is not above 0 or the largest is not finite, since then there is no range of exposures.
///
/// # Errors
/// If there is not so much memory.
///
/// # Panics
/// If both are not of one size, or of whole rows.
pub fn hdr_flip(
    width: usize,
    reference: &[[f32; 3]],
    image: &[[f32; 3]],
) -> Result<Option<Vec<f32>>, OutOfMemory> {
    let Some([first, last]) = exposures(reference)? else {
        return Ok(None);
    };
    let count = (last - first).ceil().max(2.0) as u32;
    let step = (last - first) / (count - 1) as f32;
    let mut most = room(image.len(), 0.0_f32)?;
    for number in 0..count {
        let factor = libm::exp2f(first + number as f32 * step);
        let errors = flip_of(width, reference, image, |rgb| {
            rgb.map(|channel| tone_mapped(channel * factor))
        })?;
        let both = most.par_iter_mut().zip(errors);
        both.for_each(|(most, error)| *most = most.max(error));
    }
    Ok(Some(most))
}

fn tone_mapped(x: f32) -> f32 {
    let [a, b, c, d, e, f] = TONE;
    (x * x * a + x * b + c) / (x * x * d + x * e + f)
}

/// The first and the last exposure in EV.
fn exposures(reference: &[[f32; 3]]) -> Result<Option<[f32; 2]>, OutOfMemory> {
    if reference.is_empty() {
        return Ok(None);
    }
    let mut luminances = room(reference.len(), 0.0_f32)?;
    let both = luminances.par_iter_mut().zip(reference);
    both.for_each(|(luminance, [r, g, b])| *luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b);
    let brightest = luminances.iter().copied().fold(f32::NEG_INFINITY, f32::max);
    let middle = luminances.len() / 2;
    let median = *luminances.select_nth_unstable_by(middle, f32::total_cmp).1;
    // What the tone mapper makes BRIGHT: the larger root of a quadratic.
    let [a, b, c] = std::array::from_fn(|i| TONE[i] - BRIGHT * TONE[3 + i]);
    let half = -0.5 * (b / a);
    let white = half + (half * half - c / a).sqrt();
    let range = [brightest, median].map(|luminance| libm::log2f(white / luminance));
    Ok((median > 0.0 && brightest.is_finite()).then_some(range))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// It is of no unit: what is a hundred times as bright has other exposures.
    #[test]
    fn the_unit_does_not_matter() {
        let picture = |scale: f32, error: f32| -> Vec<[f32; 3]> {
            let of = |i: usize| if i == 30 { error } else { 1.0 };
            (0..64)
                .map(|i| [scale * of(i) * (1 << (i / 8)) as f32; 3])
                .collect()
        };
        let mean = |scale: f32| -> f32 {
            let errors = hdr_flip(8, &picture(scale, 1.0), &picture(scale, 2.0));
            let errors = errors.unwrap_or_else(|error| panic!("{error}"));
            errors.unwrap_or_default().iter().sum::<f32>() / 64.0
        };
        assert!(mean(1.0) > 0.001);
        assert!((mean(1.0) / mean(100.0) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn black_has_no_exposures() {
        let black = [[0.0; 3]; 4];
        assert_eq!(hdr_flip(2, &black, &[[1.0; 3]; 4]), Ok(None));
    }
}
