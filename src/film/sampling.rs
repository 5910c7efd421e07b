//! Where the samples of a pixel are.

/// The sample positions of pixels: the same on every machine and in every run.
///
/// One sample is the pixel's center. More are the first points of the two-dimensional Sobol'
/// sequence, Owen-scrambled with a seed from the pixel's position (hash-based: Laine & Karras 2011,
/// "Stratified Sampling for Stochastic Transparency", with the mixing constants of Vegdahl 2021),
/// so that any power of two of them is stratified in every way and neighbors are independent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Sampler {
    /// The sequence before it is scrambled.
    sequence: Vec<[u32; 2]>,
}

impl Sampler {
    pub(super) fn new(samples: u32) -> Self {
        let sequence = (0..samples).map(|sample| [sample.reverse_bits(), sobol(sample)]);
        Self {
            sequence: sequence.collect(),
        }
    }

    /// Position of a sample within the image, in pixels, for the pixel at column x and row y.
    pub(super) fn position(&self, [x, y]: [u32; 2], sample: u32) -> [f64; 2] {
        let offset = if self.sequence.len() == 1 {
            [0.5, 0.5]
        } else {
            let [first, second] = self.sequence[sample as usize];
            let seed = hash(hash(x) ^ y);
            [
                unit_interval(scrambled(first, hash(seed ^ 1))),
                unit_interval(scrambled(second, hash(seed ^ 2))),
            ]
        };
        [f64::from(x) + offset[0], f64::from(y) + offset[1]]
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

/// Nested uniform (Owen) scrambling of a fraction of 2³²: each bit is flipped by a hash of the
/// bits above it.
fn scrambled(fraction: u32, seed: u32) -> u32 {
    let mut bits = fraction.reverse_bits();
    bits ^= bits.wrapping_mul(0x3d20_adea);
    bits = bits.wrapping_add(seed);
    bits = bits.wrapping_mul((seed >> 16) | 1);
    bits ^= bits.wrapping_mul(0x0552_6c56);
    bits ^= bits.wrapping_mul(0x53a2_2864);
    bits.reverse_bits()
}

/// A hash of 32 bits with full avalanche (Wellons 2018, "Prospecting for Hash Functions":
/// lowbias32).
fn hash(mut bits: u32) -> u32 {
    bits ^= bits >> 16;
    bits = bits.wrapping_mul(0x7feb_352d);
    bits ^= bits >> 15;
    bits = bits.wrapping_mul(0x846c_a68b);
    bits ^ bits >> 16
}

/// A fraction of 2³² as a number from 0 to below 1, exactly.
fn unit_interval(fraction: u32) -> f64 {
    f64::from(fraction) / 4_294_967_296.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn offsets(pixel: [u32; 2], samples: u32) -> Vec<[f64; 2]> {
        let sampler = Sampler::new(samples);
        let [x, y] = pixel.map(f64::from);
        let position = |sample| sampler.position(pixel, sample);
        (0..samples)
            .map(position)
            .map(|p| [p[0] - x, p[1] - y])
            .collect()
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
