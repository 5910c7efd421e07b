//! Sixteen numbers side by side, on any instruction set.
//!
//! All kernels work on [`LANES`] f64 at a time, whatever the machine's registers hold, with nothing
//! but +, −, ·, ÷, √, comparisons and selections. Each of these is exact to the last bit by IEEE 754
//! and none is fused with another, so that every instruction set gives the same bits.
//!
//! A kernel is written once, generic over the instruction set; [`SimdLevel::run`] is the only place that
//! chooses one.

mod level;
mod single;
mod transcendental;

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Range, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f64x8, mask64x8, u64x8};

pub(crate) use level::Kernel;
pub use level::{SimdLevel, UnknownInstructions};
pub(crate) use single::{F32x16, Mask32x16, U32x16, side_by_side, smallest_of_each};
pub(crate) use transcendental::{angle, exp2, log2, power, powers};

use crate::math::DVec3;

/// Numbers side by side.
pub(crate) const LANES: usize = 16;

/// F64x16 of one register, two of which are a set of lanes: long operations of the two overlap.
const HALF: usize = LANES / 2;

/// An f64 in each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F64x16<S: Simd>([f64x8<S>; 2]);

/// A truth value in each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mask64x16<S: Simd>([mask64x8<S>; 2]);

/// A u64 in each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct U64x16<S: Simd>([u64x8<S>; 2]);

/// A vector in each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DVec3x16<S: Simd> {
    /// Along x.
    pub x: F64x16<S>,
    /// Along y.
    pub y: F64x16<S>,
    /// Along z.
    pub z: F64x16<S>,
}

/// The lanes with a bit, the first lane's lowest: in order.
#[inline(always)]
pub(crate) fn ones(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let place = (bits != 0).then(|| bits.trailing_zeros() as usize)?;
        bits &= bits - 1;
        Some(place)
    })
}

impl<S: Simd> F64x16<S> {
    /// The same number in every lane.
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: f64) -> Self {
        Self([f64x8::splat(simd, value); 2])
    }

    /// The first [`LANES`] numbers of a slice.
    #[inline(always)]
    pub(crate) fn load(simd: S, numbers: &[f64]) -> Self {
        Self([
            f64x8::from_slice(simd, &numbers[..HALF]),
            f64x8::from_slice(simd, &numbers[HALF..LANES]),
        ])
    }

    /// Into the first [`LANES`] places of a slice.
    #[inline(always)]
    pub(crate) fn store(self, numbers: &mut [f64]) {
        self.0[0].store_slice(&mut numbers[..HALF]);
        self.0[1].store_slice(&mut numbers[HALF..LANES]);
    }

    /// As an array.
    #[inline(always)]
    pub(crate) fn to_array(self) -> [f64; LANES] {
        let mut array = [0.0; LANES];
        self.store(&mut array);
        array
    }

    /// √
    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        Self([self.0[0].sqrt(), self.0[1].sqrt()])
    }

    /// 1/√x, for x from 1e-30 to 1e30 to 4e-16 of it, and to the same bits as the scalar one of `math`.
    #[inline(always)]
    pub(crate) fn inverse_root(self, simd: S) -> Self {
        let y = self.nearly_inverse_root(simd);
        y + y * ((Self::splat(simd, 1.0) - self * y * y) * 0.5)
    }

    /// 1/√x, for x from 1e-30 to 1e30 to 1e-13 of it: an f32 root, off by 2⁻²² at most, and one of Newton's
    /// steps, which leaves 1.5 times the square of that.
    #[inline(always)]
    pub(crate) fn nearly_inverse_root(self, simd: S) -> Self {
        let near = F32x16::splat(simd, 1.0) / self.narrowed(simd).sqrt();
        let y = near.widened(simd);
        y + y * ((Self::splat(simd, 1.0) - self * y * y) * 0.5)
    }

    /// The magnitude.
    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self([self.0[0].abs(), self.0[1].abs()])
    }

    /// The largest whole number that is not above.
    #[inline(always)]
    pub(crate) fn floor(self) -> Self {
        Self([self.0[0].floor(), self.0[1].floor()])
    }

    /// The smaller of two numbers; `other` where one of them is not a number.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        self.lt(other).select(self, other)
    }

    /// The larger of two numbers; `other` where one of them is not a number.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        self.gt(other).select(self, other)
    }

    /// The largest of all; none may be NaN.
    #[inline(always)]
    pub(crate) fn largest(self) -> f64 {
        let [low, high] = self.0;
        low.simd_gt(high).select(low, high).reduce_max()
    }

    /// Where it is below.
    #[inline(always)]
    pub(crate) fn lt(self, other: Self) -> Mask64x16<S> {
        Mask64x16([self.0[0].simd_lt(other.0[0]), self.0[1].simd_lt(other.0[1])])
    }

    /// Where it is below or equal.
    #[inline(always)]
    pub(crate) fn le(self, other: Self) -> Mask64x16<S> {
        Mask64x16([self.0[0].simd_le(other.0[0]), self.0[1].simd_le(other.0[1])])
    }

    /// Where it is above.
    #[inline(always)]
    pub(crate) fn gt(self, other: Self) -> Mask64x16<S> {
        Mask64x16([self.0[0].simd_gt(other.0[0]), self.0[1].simd_gt(other.0[1])])
    }

    /// Where it is above or equal.
    #[inline(always)]
    pub(crate) fn ge(self, other: Self) -> Mask64x16<S> {
        Mask64x16([self.0[0].simd_ge(other.0[0]), self.0[1].simd_ge(other.0[1])])
    }

    /// Where it is equal.
    #[inline(always)]
    pub(crate) fn eq(self, other: Self) -> Mask64x16<S> {
        Mask64x16([self.0[0].simd_eq(other.0[0]), self.0[1].simd_eq(other.0[1])])
    }

    /// Where it is in a range.
    #[inline(always)]
    pub(crate) fn is_within(self, simd: S, range: Range<f64>) -> Mask64x16<S> {
        self.ge(Self::splat(simd, range.start)) & self.lt(Self::splat(simd, range.end))
    }

    /// Where it is above 0.
    #[inline(always)]
    pub(crate) fn is_positive(self) -> Mask64x16<S> {
        Mask64x16([self.0[0].simd_gt(0.0), self.0[1].simd_gt(0.0)])
    }

    /// The bits of each.
    #[inline(always)]
    pub(crate) fn to_bits(self) -> U64x16<S> {
        U64x16([self.0[0].to_bits(), self.0[1].to_bits()])
    }

    /// The number with these bits in each.
    #[inline(always)]
    pub(crate) fn from_bits(bits: U64x16<S>) -> Self {
        Self([f64x8::from_bits(bits.0[0]), f64x8::from_bits(bits.0[1])])
    }
}

/// Of N rows of numbers, one after the other, every N-th: the first row has those from the first on, the
/// second those from the second on, and so on. N is a power of two.
#[inline(always)]
pub(crate) fn every_nth<S: Simd, const N: usize>(mut rows: [F64x16<S>; N]) -> [F64x16<S>; N] {
    // Even places before odd ones turns the bits of all places round by one.
    for _ in 0..N.ilog2() {
        let before = rows;
        for row in 0..N / 2 {
            let ([first, second], [third, fourth]) = (before[2 * row].0, before[2 * row + 1].0);
            let (even, odd) = first.deinterleave(second);
            let (next_even, next_odd) = third.deinterleave(fourth);
            rows[row] = F64x16([even, next_even]);
            rows[N / 2 + row] = F64x16([odd, next_odd]);
        }
    }
    rows
}

impl<S: Simd> U64x16<S> {
    /// The same in every lane.
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: u64) -> Self {
        Self([u64x8::splat(simd, value); 2])
    }

    /// The first [`LANES`] of a slice.
    #[inline(always)]
    pub(crate) fn load(simd: S, ids: &[u64]) -> Self {
        Self([
            u64x8::from_slice(simd, &ids[..HALF]),
            u64x8::from_slice(simd, &ids[HALF..LANES]),
        ])
    }

    /// As an array.
    #[inline(always)]
    pub(crate) fn to_array(self) -> [u64; LANES] {
        let mut array = [0; LANES];
        self.0[0].store_slice(&mut array[..HALF]);
        self.0[1].store_slice(&mut array[HALF..]);
        array
    }

    /// Where it is below.
    #[inline(always)]
    pub(crate) fn lt(self, other: Self) -> Mask64x16<S> {
        Mask64x16([self.0[0].simd_lt(other.0[0]), self.0[1].simd_lt(other.0[1])])
    }

    /// Where it is equal.
    #[inline(always)]
    pub(crate) fn eq(self, other: Self) -> Mask64x16<S> {
        Mask64x16([self.0[0].simd_eq(other.0[0]), self.0[1].simd_eq(other.0[1])])
    }

    /// Shifted towards the larger places.
    #[inline(always)]
    pub(crate) fn shifted_up(self, bits: u32) -> Self {
        Self([self.0[0] << bits, self.0[1] << bits])
    }

    /// Shifted towards the smaller places.
    #[inline(always)]
    pub(crate) fn shifted_down(self, bits: u32) -> Self {
        Self([self.0[0] >> bits, self.0[1] >> bits])
    }

    /// The sum, modulo 2⁶⁴.
    #[inline(always)]
    pub(crate) fn plus(self, other: u64) -> Self {
        Self([self.0[0] + other, self.0[1] + other])
    }

    /// The bits that both have.
    #[inline(always)]
    pub(crate) fn and(self, other: u64) -> Self {
        Self([self.0[0] & other, self.0[1] & other])
    }

    /// The bits that either has.
    #[inline(always)]
    pub(crate) fn or(self, other: u64) -> Self {
        Self([self.0[0] | other, self.0[1] | other])
    }
}

impl<S: Simd> Mask64x16<S> {
    /// From one bit for each lane, the first lane lowest.
    #[inline(always)]
    pub(crate) fn from_bits(simd: S, bits: u32) -> Self {
        let half = |bits: u32| mask64x8::from_bitmask(simd, u64::from(bits & 0xff));
        Self([half(bits), half(bits >> HALF)])
    }

    /// One bit for each lane, the first lane lowest.
    #[inline(always)]
    pub(crate) fn to_bits(self) -> u32 {
        let [low, high] = [
            self.0[0].to_bitmask() as u32 & 0xff,
            self.0[1].to_bitmask() as u32 & 0xff,
        ];
        low | high << HALF
    }

    /// Whether it is true in any lane.
    #[inline(always)]
    pub(crate) fn any(self) -> bool {
        (self.0[0] | self.0[1]).any_true()
    }

    /// `yes` where it is true, else `no`.
    #[inline(always)]
    pub(crate) fn select(self, yes: F64x16<S>, no: F64x16<S>) -> F64x16<S> {
        F64x16([
            self.0[0].select(yes.0[0], no.0[0]),
            self.0[1].select(yes.0[1], no.0[1]),
        ])
    }

    /// `yes` where it is true, else `no`.
    #[inline(always)]
    pub(crate) fn select_ids(self, yes: U64x16<S>, no: U64x16<S>) -> U64x16<S> {
        U64x16([
            self.0[0].select(yes.0[0], no.0[0]),
            self.0[1].select(yes.0[1], no.0[1]),
        ])
    }

    /// `yes` where it is true, else `no`.
    #[inline(always)]
    pub(crate) fn select_vectors(self, yes: DVec3x16<S>, no: DVec3x16<S>) -> DVec3x16<S> {
        DVec3x16 {
            x: self.select(yes.x, no.x),
            y: self.select(yes.y, no.y),
            z: self.select(yes.z, no.z),
        }
    }
}

macro_rules! arithmetic {
    ($($trait:ident $method:ident $operator:tt)*) => {$(
        impl<S: Simd> $trait for F64x16<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self([self.0[0] $operator other.0[0], self.0[1] $operator other.0[1]])
            }
        }

        impl<S: Simd> $trait<f64> for F64x16<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                Self([self.0[0] $operator other, self.0[1] $operator other])
            }
        }
    )*};
}

arithmetic! { Add add + Sub sub - Mul mul * Div div / }

impl<S: Simd> Neg for F64x16<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self([-self.0[0], -self.0[1]])
    }
}

impl<S: Simd> BitAnd for Mask64x16<S> {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self([self.0[0] & other.0[0], self.0[1] & other.0[1]])
    }
}

impl<S: Simd> BitOr for Mask64x16<S> {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self([self.0[0] | other.0[0], self.0[1] | other.0[1]])
    }
}

impl<S: Simd> Not for Mask64x16<S> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self([!self.0[0], !self.0[1]])
    }
}

impl<S: Simd> DVec3x16<S> {
    /// The same vector in every lane.
    #[inline(always)]
    pub(crate) fn splat(simd: S, vector: DVec3) -> Self {
        Self {
            x: F64x16::splat(simd, vector.x),
            y: F64x16::splat(simd, vector.y),
            z: F64x16::splat(simd, vector.z),
        }
    }

    /// The first [`LANES`] of three columns.
    #[inline(always)]
    pub(crate) fn load(simd: S, [x, y, z]: [&[f64]; 3]) -> Self {
        Self {
            x: F64x16::load(simd, x),
            y: F64x16::load(simd, y),
            z: F64x16::load(simd, z),
        }
    }

    /// Into the first [`LANES`] places of three columns.
    #[inline(always)]
    pub(crate) fn store(self, [x, y, z]: [&mut [f64]; 3]) {
        self.x.store(x);
        self.y.store(y);
        self.z.store(z);
    }

    /// a · b
    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> F64x16<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// a · b with one vector for all lanes.
    #[inline(always)]
    pub(crate) fn dot_with(self, other: DVec3) -> F64x16<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// The vector in one lane.
    #[inline(always)]
    pub(crate) fn lane(self, lane: usize) -> DVec3 {
        let [x, y, z] = [self.x.to_array(), self.y.to_array(), self.z.to_array()];
        DVec3::new(x[lane], y[lane], z[lane])
    }

    /// x, y or z.
    #[inline(always)]
    pub(crate) fn component(self, axis: usize) -> F64x16<S> {
        match axis {
            0 => self.x,
            1 => self.y,
            _ => self.z,
        }
    }

    /// a × b
    #[inline(always)]
    pub(crate) fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    /// The sum of the components' magnitudes: at least the length, at most √3 times as much.
    #[inline(always)]
    pub(crate) fn taxicab(self) -> F64x16<S> {
        self.x.abs() + self.y.abs() + self.z.abs()
    }

    /// The component of the largest magnitude, as a magnitude.
    #[inline(always)]
    pub(crate) fn largest(self) -> F64x16<S> {
        self.x.abs().max(self.y.abs()).max(self.z.abs())
    }

    /// The smaller of each component.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        Self {
            x: self.x.min(other.x),
            y: self.y.min(other.y),
            z: self.z.min(other.z),
        }
    }

    /// The larger of each component.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        Self {
            x: self.x.max(other.x),
            y: self.y.max(other.y),
            z: self.z.max(other.z),
        }
    }

    /// Each vector times a number.
    #[inline(always)]
    pub(crate) fn times(self, factor: F64x16<S>) -> Self {
        Self {
            x: self.x * factor,
            y: self.y * factor,
            z: self.z * factor,
        }
    }

    /// Each vector minus one for all lanes.
    #[inline(always)]
    pub(crate) fn minus(self, other: DVec3) -> Self {
        Self {
            x: self.x - other.x,
            y: self.y - other.y,
            z: self.z - other.z,
        }
    }
}

impl<S: Simd> Add for DVec3x16<S> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self {
            x: self.x + other.x,
            y: self.y + other.y,
            z: self.z + other.z,
        }
    }
}

impl<S: Simd> Sub for DVec3x16<S> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self {
            x: self.x - other.x,
            y: self.y - other.y,
            z: self.z - other.z,
        }
    }
}

impl<S: Simd> Neg for DVec3x16<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            x: -self.x,
            y: -self.y,
            z: -self.z,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A bit of everything.
    struct Arithmetic([f64; LANES]);

    impl Kernel for Arithmetic {
        type Output = [f64; LANES];

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            let x = F64x16::load(simd, &self.0);
            let y = (x * 3.7 - 1.0) / (x + 0.3);
            let z = y.abs().sqrt().max(x).min(F64x16::splat(simd, 2.5));
            let exponent = z.to_bits().shifted_down(52).and(0x7ff);
            let is_small = exponent.lt(U64x16::splat(simd, 1023));
            (is_small & !x.is_positive()).select(-z, z).to_array()
        }
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        let numbers = std::array::from_fn(|i| (i as f64 - 7.3) * 0.37);
        let bits = |level: SimdLevel| level.run(Arithmetic(numbers)).map(f64::to_bits);
        let expected = bits(SimdLevel::default());
        for (name, level) in SimdLevel::available() {
            assert_eq!(bits(level), expected, "{name}");
            assert!(name.parse::<SimdLevel>().is_ok());
        }
        assert!("mmx".parse::<SimdLevel>().is_err());
    }

    struct Rows;

    impl Kernel for Rows {
        type Output = [[f64; LANES]; 4];

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            let numbers: [f64; 4 * LANES] = std::array::from_fn(|place| place as f64);
            let row = |row: usize| F64x16::load(simd, &numbers[row * LANES..]);
            let [a, b, c, d] = every_nth([row(0), row(1), row(2), row(3)]);
            [a.to_array(), b.to_array(), c.to_array(), d.to_array()]
        }
    }

    #[test]
    fn every_nth_is_every_nth() {
        for (_, level) in SimdLevel::available() {
            for (first, row) in level.run(Rows).into_iter().enumerate() {
                for (lane, number) in row.into_iter().enumerate() {
                    assert_eq!(number, (first + 4 * lane) as f64);
                }
            }
        }
    }

    struct Bits(u32);

    impl Kernel for Bits {
        type Output = u32;

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> u32 {
            Mask64x16::from_bits(simd, self.0).to_bits()
        }
    }

    #[test]
    fn masks_keep_their_bits() {
        for (_, level) in SimdLevel::available() {
            for bits in [0, 1, 0x8000, 0xffff, 0x1234] {
                assert_eq!(level.run(Bits(bits)), bits);
            }
        }
    }
}
