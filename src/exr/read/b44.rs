//! OpenEXR's B44 and B44A: squares of 4 × 4 halves in 14 bytes, or 3 where they are all the same.
//!
//! The `exr` crate decodes neither channels with fewer samples than pixels nor, without overflow,
//! damaged ones. Layout: OpenEXR's ImfB44Compressor.cpp.

use half::f16;

use super::{ExrProblem, damaged};

/// A channel of a block.
pub(super) struct Plane {
    /// Samples beside and below each other.
    pub(super) size: [usize; 2],
    pub(super) is_half: bool,
    /// Whether differences of the halves count, not ratios.
    pub(super) is_linear: bool,
}

/// Samples of a square's side.
const SIDE: usize = 4;

/// From here on, the third byte, whose upper six bits are a shift of at most 12, says that all samples
/// are the same.
const IS_FLAT: u8 = 13 << 2;

/// The samples of one plane after the other, little-endian, each row by row.
pub(super) fn decode(planes: &[Plane], mut bytes: &[u8]) -> Result<Vec<Vec<u8>>, ExrProblem> {
    let short = || damaged("a B44 block is too short");
    let mut decoded = Vec::with_capacity(planes.len());
    for plane in planes {
        let [width, height] = plane.size;
        let count = width * height;
        let mut samples = Vec::new();
        if !plane.is_half {
            let (raw, rest) = bytes.split_at_checked(4 * count).ok_or_else(short)?;
            bytes = rest;
            super::resize(&mut samples, raw.len(), 0)?;
            samples.copy_from_slice(raw);
            decoded.push(samples);
            continue;
        }
        super::resize(&mut samples, 2 * count, 0)?;
        for top in (0..height).step_by(SIDE) {
            for left in (0..width).step_by(SIDE) {
                let (square, rest) = square(bytes).ok_or_else(short)?;
                bytes = rest;
                for (line, y) in square.chunks_exact(SIDE).zip(top..height) {
                    let start = 2 * (y * width + left);
                    let end = 2 * (y * width + width.min(left + SIDE));
                    let (targets, _) = samples[start..end].as_chunks_mut::<2>();
                    for (target, &sample) in targets.iter_mut().zip(line) {
                        let sample = if plane.is_linear {
                            logarithm(sample)
                        } else {
                            sample
                        };
                        *target = sample.to_le_bytes();
                    }
                }
            }
        }
        decoded.push(samples);
    }
    Ok(decoded)
}

/// The samples of a square, and what comes after it.
fn square(bytes: &[u8]) -> Option<([u16; SIDE * SIDE], &[u8])> {
    let (head, rest) = bytes.split_first_chunk::<3>()?;
    let first = u16::from_be_bytes([head[0], head[1]]);
    if head[2] >= IS_FLAT {
        return Some(([ordered(first); SIDE * SIDE], rest));
    }
    let (square, rest) = bytes.split_first_chunk::<14>()?;
    let shift = u32::from(square[2] >> 2);
    let bias = (0x20_u32 << shift) as u16;
    // 15 differences of six bits each, from the last two bits of byte 2 on.
    let packed = square[2..]
        .iter()
        .fold(0_u128, |all, &byte| all << 8 | u128::from(byte));
    let difference = |number: usize| {
        let six = (packed >> (6 * (14 - number)) & 0x3f) as u32;
        ((six << shift) as u16).wrapping_sub(bias)
    };
    let mut samples = [0_u16; SIDE * SIDE];
    samples[0] = first;
    // Down the first column, then along the rows, column by column.
    for row in 1..SIDE {
        samples[SIDE * row] = samples[SIDE * (row - 1)].wrapping_add(difference(row - 1));
    }
    for column in 1..SIDE {
        for row in 0..SIDE {
            let place = SIDE * row + column;
            let number = 3 + SIDE * (column - 1) + row;
            samples[place] = samples[place - 1].wrapping_add(difference(number));
        }
    }
    Some((samples.map(ordered), rest))
}

/// The bits of a half from a number in the order of the halves' values.
const fn ordered(number: u16) -> u16 {
    if number & 0x8000 != 0 {
        number & 0x7fff
    } else {
        !number
    }
}

/// 8 ln x of the bits of a half, as bits; of what is no number, or below 0, it is 0.
///
/// The squares keep ratios. Of a channel whose differences count, as chroma's do, e^(x/8) was packed.
fn logarithm(bits: u16) -> u16 {
    let value = f16::from_bits(bits);
    if !value.is_finite() || value < f16::ZERO {
        return 0;
    }
    f16::from_f64(8.0 * libm::log(value.to_f64())).to_bits()
}
