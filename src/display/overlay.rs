//! What is laid over a picture: legends, labels.

use super::{Bits, code_of_8, code_of_16};

/// What is drawn over a picture, and how much room it has beside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Drawn<'a> {
    /// The first is below the others.
    pub overlays: &'a [Overlay],
    /// So many columns are added at the right of the picture, for overlays that are there.
    pub columns: u32,
    /// The options that it comes from, such as `--iso-lines 100,300`, for the text of a PNG that says how it is made
    /// again.
    pub options: &'a str,
}

impl Drawn<'_> {
    /// The picture as it is.
    pub const NOTHING: Self = Self {
        overlays: &[],
        columns: 0,
        options: "",
    };
}

impl Default for Drawn<'_> {
    fn default() -> Self {
        Self::NOTHING
    }
}

/// Coded pixels that are laid over a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Overlay {
    /// Where its top left is in the picture. What is outside of the picture is left out.
    pub corner: [u32; 2],
    /// Pixels in a row. Range: above 0.
    pub width: u32,
    /// R, G, B, A row by row, by the screen's codes; RGB is not multiplied by A.
    pub pixels: Vec<[u8; 4]>,
}

impl Overlay {
    /// Over row `y` of a picture.
    pub(super) fn lay_on_row(&self, y: u32, row: &mut [u8], bits: Bits, has_alpha: bool) {
        let Some(own) = y.checked_sub(self.corner[1]) else {
            return;
        };
        let width = self.width as usize;
        let Some(over) = self.pixels.chunks(width.max(1)).nth(own as usize) else {
            return;
        };
        let bytes = bits.bytes();
        let samples = row.chunks_exact_mut((3 + usize::from(has_alpha)) * bytes);
        for (samples, over) in samples.skip(self.corner[0] as usize).zip(over) {
            // Most of an overlay of lines is nothing.
            if over[3] > 0 {
                lay(samples, over, bits);
            }
        }
    }
}

/// A pixel over another: Porter and Duff's "over", with colors that are not multiplied by coverage.
fn lay(samples: &mut [u8], over: &[u8; 4], bits: Bits) {
    let bytes = bits.bytes();
    let [r, g, b, a] = over.map(|sample| f64::from(sample) / f64::from(u8::MAX));
    let mut under = [0.0, 0.0, 0.0, 1.0];
    for (under, sample) in under.iter_mut().zip(samples.chunks_exact(bytes)) {
        *under = match *sample {
            [code] => f64::from(code) / f64::from(u8::MAX),
            [high, low] => f64::from(u16::from_be_bytes([high, low])) / f64::from(u16::MAX),
            [a, b, c, d] => f64::from(f32::from_ne_bytes([a, b, c, d])),
            _ => unreachable!("samples have 8, 16 or 32 bits"),
        };
    }
    let coverage = a + under[3] * (1.0 - a);
    let share = if coverage > 0.0 { a / coverage } else { 0.0 };
    let mixed = |over: f64, under: f64| under + (over - under) * share;
    let out = [
        mixed(r, under[0]),
        mixed(g, under[1]),
        mixed(b, under[2]),
        coverage,
    ];
    for (sample, value) in samples.chunks_exact_mut(bytes).zip(out) {
        match bits {
            Bits::Eight => sample.copy_from_slice(&[code_of_8(value)]),
            Bits::Sixteen => sample.copy_from_slice(&code_of_16(value).to_be_bytes()),
            Bits::ThirtyTwo => sample.copy_from_slice(&(value as f32).to_ne_bytes()),
        }
    }
}
