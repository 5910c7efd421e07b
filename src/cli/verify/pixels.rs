//! Which pixels are compared.

use std::collections::BTreeSet;

use candela::image::Window;

use crate::cli::Failure;

/// All pixels of an image row by row, or so many of them, each once: which ones is a function of the image's size, the
/// count and the seed.
///
/// By Floyd's algorithm (Bentley & Floyd 1987, "A sample of brilliance") over SplitMix64 (Steele, Lea & Flood 2014,
/// "Fast splittable pseudorandom number generators").
pub(super) fn chosen(
    resolution: [u32; 2],
    count: Option<u64>,
    seed: u64,
) -> Result<Vec<[u32; 2]>, Failure> {
    let whole = Window::whole(resolution);
    let all = whole.count();
    let count = count.unwrap_or(all).min(all);
    let mut pixels = Vec::new();
    pixels.try_reserve_exact(usize::try_from(count)?)?;
    if count == all {
        pixels.extend(whole.pixels());
        return Ok(pixels);
    }
    let mut state = seed;
    let mut chosen = BTreeSet::new();
    for last in all - count..all {
        let number = (u128::from(next(&mut state)) * u128::from(last + 1)) >> 64;
        if !chosen.insert(number as u64) {
            chosen.insert(last);
        }
    }
    let width = u64::from(resolution[0]);
    // Both are below the image's sides.
    pixels.extend(
        chosen
            .into_iter()
            .map(|number| [(number % width) as u32, (number / width) as u32]),
    );
    Ok(pixels)
}

/// SplitMix64.
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixels(count: u64, seed: u64) -> Vec<[u32; 2]> {
        chosen([60, 40], Some(count), seed).unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn each_once_and_inside() {
        for count in [1, 7, 1000, 2399, 2400, 5000] {
            let found = pixels(count, 3);
            let different: BTreeSet<_> = found.iter().copied().collect();
            assert_eq!(different.len() as u64, count.min(2400));
            assert!(found.iter().all(|&[x, y]| x < 60 && y < 40));
        }
        assert_eq!(pixels(100, 3), pixels(100, 3));
        assert_ne!(pixels(100, 3), pixels(100, 4));
    }

    /// The generator's published values for the seed 1234567.
    #[test]
    fn published_numbers() {
        let mut state = 1_234_567;
        assert_eq!(next(&mut state), 6_457_827_717_110_365_317);
        assert_eq!(next(&mut state), 3_203_168_211_198_807_973);
    }

    #[test]
    fn they_are_everywhere() {
        let mut quarters = [0; 4];
        for [x, y] in pixels(1000, 0) {
            quarters[usize::from(x >= 30) + 2 * usize::from(y >= 20)] += 1;
        }
        assert!(
            quarters.iter().all(|&count| (200..300).contains(&count)),
            "{quarters:?}"
        );
    }
}
