//! Where the samples of a pixel are.

use fearless_simd::Simd;

use crate::simd::{F64x16, U32x16};

/// The sample positions of pixels: the same on every machine and in every run.
///
/// One sample is the pixel's center. More are, unless they are the middles of a grid, the first points of the
/// two-dimensional Sobol' sequence, Owen-scrambled with a seed from the pixel's position (hash-based: Laine & Karras 2011,
/// "Stratified Sampling for Stochastic Transparency", with the mixing constants of Vegdahl 2021),
/// so that any power of two of them is stratified in every way and neighbors are independent.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sampler {
    pattern: Pattern,
    /// Of a sequence, before it is scrambled, each number with its highest bit last; of a grid, column and row.
    sequence: Vec<[u32; 2]>,
    /// Pixels of the image from one pixel of the grid to the next.
    spacing: [f64; 2],
}

/// What kind of places samples have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pattern {
    /// The scrambled sequence.
    Scrambled,
    /// The middles of so many equal parts along each side, the same in all pixels.
    Grid(u32),
}

impl Sampler {
    pub(super) fn new(samples: u32) -> Self {
        if samples == 1 {
            return Self::grid(1);
        }
        let sequence = (0..samples).map(|sample| [sample, sobol(sample).reverse_bits()]);
        Self {
            pattern: Pattern::Scrambled,
            sequence: sequence.collect(),
            spacing: [1.0; 2],
        }
    }

    /// The middles of `side` × `side` equal parts of the pixel, row by row.
    pub(super) fn grid(side: u32) -> Self {
        let sequence = (0..side * side).map(|sample| [sample % side, sample / side]);
        Self {
            pattern: Pattern::Grid(side),
            sequence: sequence.collect(),
            spacing: [1.0; 2],
        }
    }

    /// The centers of so many columns and rows that the whole image is parted into, as if they were the pixels of one.
    pub(super) fn over(image: [u32; 2], parts: [u32; 2]) -> Self {
        Self {
            spacing: [0, 1].map(|axis| f64::from(image[axis]) / f64::from(parts[axis])),
            ..Self::grid(1)
        }
    }

    pub(super) fn pattern(&self) -> Pattern {
        self.pattern
    }

    /// Pixels of the image from one of those that are sampled to the next: 1, unless the samples are over the whole
    /// image.
    pub(super) fn spacing(&self) -> [f64; 2] {
        self.spacing
    }

    /// How many samples a pixel has.
    pub(super) fn samples(&self) -> u32 {
        self.sequence.len() as u32
    }

    /// What scrambles the two dimensions for the pixels at some columns x and rows y.
    #[inline(always)]
    pub(super) fn seeds<S: Simd>(&self, simd: S, [x, y]: [U32x16<S>; 2]) -> [U32x16<S>; 2] {
        if self.pattern != Pattern::Scrambled {
            return [U32x16::splat(simd, 0); 2];
        }
        let seed = hash(simd, hash(simd, x) ^ y);
        [
            hash(simd, seed ^ U32x16::splat(simd, 1)),
            hash(simd, seed ^ U32x16::splat(simd, 2)),
        ]
    }

    /// The sequence before it is scrambled, with the highest bits last.
    pub(super) fn sequence(&self, sample: usize) -> [u32; 2] {
        self.sequence[sample]
    }

    /// Positions of samples within their pixels, from 0 to 1, dimension by dimension: from the sequence
    /// and the pixels' seeds.
    #[inline(always)]
    pub(super) fn offsets<S: Simd>(&self, simd: S, sequence: &[u32], seeds: &[u32]) -> F64x16<S> {
        match self.pattern {
            Pattern::Grid(1) => return F64x16::splat(simd, 0.5),
            Pattern::Grid(side) => {
                let part = U32x16::load(simd, sequence).widened(simd);
                return (part + F64x16::splat(simd, 0.5)) * (1.0 / f64::from(side));
            }
            Pattern::Scrambled => {}
        }
        let sequence = U32x16::load(simd, sequence);
        let scrambled = scrambled(simd, sequence, U32x16::load(simd, seeds));
        // A fraction of 2³² as a number from 0 to below 1, exactly.
        scrambled.widened(simd) * (1.0 / 4_294_967_296.0)
    }
}

/// The second dimension of the Sobol' sequence; the first is the bit-reversed index. Its direction
/// numbers are the rows of Pascal's triangle modulo 2 (primitive polynomial x + 1).
fn sobol(index: u32) -> u32 {
    let mut result = 0;
    let mut direction = 1 << 31;
    for bit in 0..u32::BITS {
        if index >> bit & 1 == 1 {
            result ^= direction;
        }
        direction ^= direction >> 1;
    }
    result
}

/// Nested uniform (Owen) scrambling of fractions of 2³², given with the highest bits last: each bit is
/// flipped by a hash of the bits above it.
#[inline(always)]
fn scrambled<S: Simd>(simd: S, bits: U32x16<S>, seed: U32x16<S>) -> U32x16<S> {
    let odd = seed.shifted_down(16) | U32x16::splat(simd, 1);
    let bits = bits ^ (bits * U32x16::splat(simd, 0x3d20_adea));
    let bits = (bits + seed) * odd;
    let bits = bits ^ (bits * U32x16::splat(simd, 0x0552_6c56));
    let bits = bits ^ (bits * U32x16::splat(simd, 0x53a2_2864));
    reversed(simd, bits)
}

/// The bits of each in the opposite order: neighbors change places, then pairs, and so on.
#[inline(always)]
fn reversed<S: Simd>(simd: S, bits: U32x16<S>) -> U32x16<S> {
    let bits = swapped(simd, bits, 1, 0x5555_5555);
    let bits = swapped(simd, bits, 2, 0x3333_3333);
    let bits = swapped(simd, bits, 4, 0x0f0f_0f0f);
    let bits = swapped(simd, bits, 8, 0x00ff_00ff);
    bits.shifted_up(16) | bits.shifted_down(16)
}

/// Groups of `width` bits change places with their neighbors; `mask` has every other group.
#[inline(always)]
fn swapped<S: Simd>(simd: S, bits: U32x16<S>, width: u32, mask: u32) -> U32x16<S> {
    let mask = U32x16::splat(simd, mask);
    (bits & mask).shifted_up(width) | (bits.shifted_down(width) & mask)
}

/// A hash of 32 bits with full avalanche (Wellons 2018, "Prospecting for Hash Functions":
/// lowbias32).
#[inline(always)]
fn hash<S: Simd>(simd: S, bits: U32x16<S>) -> U32x16<S> {
    let bits = bits ^ bits.shifted_down(16);
    let bits = bits * U32x16::splat(simd, 0x7feb_352d);
    let bits = bits ^ bits.shifted_down(15);
    let bits = bits * U32x16::splat(simd, 0x846c_a68b);
    bits ^ bits.shifted_down(16)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Kernel, LANES, SimdLevel};

    struct Offsets<'s>(&'s Sampler, [u32; 2]);

    impl Kernel for Offsets<'_> {
        type Output = Vec<[f64; 2]>;

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            let Self(sampler, pixel) = self;
            let [x, y] = pixel;
            let seeds = sampler.seeds(simd, [U32x16::splat(simd, x), U32x16::splat(simd, y)]);
            let mut columns = [[0; LANES]; 2];
            for (column, seeds) in columns.iter_mut().zip(seeds) {
                seeds.store(column);
            }
            (0..sampler.samples() as usize)
                .map(|sample| {
                    let sequence = sampler.sequence(sample).map(|number| [number; LANES]);
                    [0, 1].map(|dimension: usize| {
                        sampler
                            .offsets(simd, &sequence[dimension], &columns[dimension])
                            .to_array()[7]
                    })
                })
                .collect()
        }
    }

    fn offsets(pixel: [u32; 2], samples: u32) -> Vec<[f64; 2]> {
        SimdLevel::default().run(Offsets(&Sampler::new(samples), pixel))
    }

    #[test]
    fn one_sample_is_the_center() {
        assert_eq!(offsets([7, 3], 1), [[0.5, 0.5]]);
    }

    #[test]
    fn samples_stay_in_their_pixel() {
        for samples in [2, 3, 5, 100] {
            for offset in offsets([1234, 77], samples) {
                assert!(offset.iter().all(|&axis| (0.0..1.0).contains(&axis)));
            }
        }
    }

    /// A (0, m, 2)-net in base 2: each of 2ᵐ points is alone in every box of area 2⁻ᵐ whose sides
    /// are powers of two.
    #[test]
    fn powers_of_two_are_stratified_in_every_way() {
        for pixel in [[0, 0], [1, 0], [640, 359]] {
            for m in 0..=8 {
                let points = offsets(pixel, 1 << m);
                for columns_log2 in 0..=m {
                    let (columns, rows) = (1_u32 << columns_log2, 1_u32 << (m - columns_log2));
                    let mut filled = vec![false; 1 << m];
                    for [x, y] in points.iter().filter(|_| m > 0) {
                        let column = (x * f64::from(columns)) as usize;
                        let row = (y * f64::from(rows)) as usize;
                        let is_second =
                            std::mem::replace(&mut filled[row * columns as usize + column], true);
                        assert!(!is_second, "{pixel:?} {m} {columns_log2}");
                    }
                }
            }
        }
    }

    #[test]
    fn neighbors_differ() {
        assert_ne!(offsets([10, 10], 4), offsets([11, 10], 4));
        assert_ne!(offsets([10, 10], 4), offsets([10, 11], 4));
    }

    /// The pattern is a promise: the first samples of two pixels, written down once.
    #[test]
    fn the_pattern_stays() {
        let first = offsets([0, 0], 4)[0];
        let second = offsets([100, 50], 16)[7];
        assert_eq!(first, [0.010954105528071523, 0.6680603655986488]);
        assert_eq!(second, [0.5822251820936799, 0.022587761748582125]);
    }
}
