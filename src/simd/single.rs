//! Numbers of 32 bits, sixteen of which are one register.

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Not, Sub};

use fearless_simd::prelude::*;
use fearless_simd::{Simd, f32x16, mask32x16, u32x16};

use super::{F64x16, LANES};

/// An f32 in each lane: for what is decided with a margin, and asked again in f64 within it. Its
/// products and sums may be fused, so that no pixel may depend on more than such a decision.
#[derive(Clone, Copy, Debug)]
pub(crate) struct F32x16<S: Simd>(f32x16<S>);

/// A truth value for each of [`F32x16`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Mask32x16<S: Simd>(mask32x16<S>);

/// A u32 in each lane; sums and products are modulo 2³².
#[derive(Clone, Copy, Debug)]
pub(crate) struct U32x16<S: Simd>(u32x16<S>);

impl<S: Simd> F64x16<S> {
    /// The nearest f32 of each.
    #[inline(always)]
    pub(crate) fn narrowed(self, simd: S) -> F32x16<S> {
        F32x16(simd.narrow_f64x8(self.0[0], self.0[1]))
    }
}

impl<S: Simd> F32x16<S> {
    /// The same number in every lane.
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: f32) -> Self {
        Self(f32x16::splat(simd, value))
    }

    /// The first [`LANES`] numbers of a slice.
    #[inline(always)]
    pub(crate) fn load(simd: S, numbers: &[f32]) -> Self {
        Self(f32x16::from_slice(simd, &numbers[..LANES]))
    }

    /// Into the first [`LANES`] places of a slice.
    #[inline(always)]
    pub(crate) fn store(self, numbers: &mut [f32]) {
        self.0.store_slice(&mut numbers[..LANES]);
    }

    /// As f64, exactly.
    #[inline(always)]
    pub(crate) fn widened(self, simd: S) -> F64x16<S> {
        let (low, high) = simd.widen_f32x16(self.0);
        F64x16([low, high])
    }

    /// self · factor + term, rounded once or twice.
    #[inline(always)]
    pub(crate) fn times_plus(self, factor: Self, term: Self) -> Self {
        Self(self.0.mul_add(factor.0, term.0))
    }

    /// The whole part of numbers from 0 to below 2³¹.
    #[inline(always)]
    pub(crate) fn truncated(self, simd: S) -> U32x16<S> {
        U32x16(simd.cvt_u32_f32x16(self.0))
    }

    /// √
    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    /// The magnitude.
    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self(self.0.abs())
    }

    /// The smaller of two numbers, neither NaN.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0))
    }

    /// The larger of two numbers, neither NaN.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }

    /// The smallest of all; none may be NaN.
    #[inline(always)]
    pub(crate) fn smallest(self) -> f32 {
        self.0.reduce_min()
    }

    /// The largest of all; none may be NaN.
    #[inline(always)]
    pub(crate) fn largest(self) -> f32 {
        self.0.reduce_max()
    }

    /// Where it is below or equal.
    #[inline(always)]
    pub(crate) fn le(self, other: Self) -> Mask32x16<S> {
        Mask32x16(self.0.simd_le(other.0))
    }

    /// Where it is above.
    #[inline(always)]
    pub(crate) fn gt(self, other: Self) -> Mask32x16<S> {
        Mask32x16(self.0.simd_gt(other.0))
    }

    /// Where it is above or equal.
    #[inline(always)]
    pub(crate) fn ge(self, other: Self) -> Mask32x16<S> {
        Mask32x16(self.0.simd_ge(other.0))
    }
}

/// The smallest of each of sixteen, none NaN; side by side.
#[inline(always)]
pub(crate) fn smallest_of_each<S: Simd>(mut rows: [F32x16<S>; LANES]) -> F32x16<S> {
    // Two rows become one with half as many of each, in turn; the last one has them in order.
    let mut half = LANES / 2;
    while half > 0 {
        for row in 0..half {
            let (first, second) = (rows[row].0, rows[row + half].0);
            let (low, high) = first.interleave(second);
            rows[row] = F32x16(low.min(high));
        }
        half /= 2;
    }
    rows[0]
}

/// Four rows as sixteen of four: the first of each, the second of each, and so on.
#[inline(always)]
pub(crate) fn side_by_side<S: Simd>([a, b, c, d]: [F32x16<S>; 4]) -> [[f32; 4]; LANES] {
    let (ac, next_ac) = a.0.interleave(c.0);
    let (bd, next_bd) = b.0.interleave(d.0);
    let (first, second) = ac.interleave(bd);
    let (third, fourth) = next_ac.interleave(next_bd);
    let mut fours = [[0.0; 4]; LANES];
    let (rows, _) = fours.as_flattened_mut().as_chunks_mut::<LANES>();
    for (row, numbers) in rows.iter_mut().zip([first, second, third, fourth]) {
        numbers.store_slice(row);
    }
    fours
}

impl<S: Simd> U32x16<S> {
    /// The same in every lane.
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: u32) -> Self {
        Self(u32x16::splat(simd, value))
    }

    /// The first [`LANES`] of a slice.
    #[inline(always)]
    pub(crate) fn load(simd: S, words: &[u32]) -> Self {
        Self(u32x16::from_slice(simd, &words[..LANES]))
    }

    /// Into the first [`LANES`] places of a slice.
    #[inline(always)]
    pub(crate) fn store(self, words: &mut [u32]) {
        self.0.store_slice(&mut words[..LANES]);
    }

    /// Where it is equal.
    #[inline(always)]
    pub(crate) fn eq(self, other: Self) -> Mask32x16<S> {
        Mask32x16(self.0.simd_eq(other.0))
    }

    /// Where it is below.
    #[inline(always)]
    pub(crate) fn lt(self, other: Self) -> Mask32x16<S> {
        Mask32x16(self.0.simd_lt(other.0))
    }

    /// Shifted towards the larger places.
    #[inline(always)]
    pub(crate) fn shifted_up(self, bits: u32) -> Self {
        Self(self.0 << bits)
    }

    /// Shifted towards the smaller places.
    #[inline(always)]
    pub(crate) fn shifted_down(self, bits: u32) -> Self {
        Self(self.0 >> bits)
    }

    /// As f64, exactly.
    #[inline(always)]
    pub(crate) fn widened(self, simd: S) -> F64x16<S> {
        let (low, high) = simd.widen_u32x16(self.0);
        F64x16([simd.cvt_f64_u64x8(low), simd.cvt_f64_u64x8(high)])
    }
}

impl<S: Simd> Mask32x16<S> {
    /// From one bit for each lane, the first lane lowest.
    #[inline(always)]
    pub(crate) fn from_bits(simd: S, bits: u32) -> Self {
        Self(mask32x16::from_bitmask(simd, u64::from(bits)))
    }

    /// One bit for each lane, the first lane lowest.
    #[inline(always)]
    pub(crate) fn to_bits(self) -> u32 {
        self.0.to_bitmask() as u32
    }

    /// `yes` where it is true, else `no`.
    #[inline(always)]
    pub(crate) fn select(self, yes: F32x16<S>, no: F32x16<S>) -> F32x16<S> {
        F32x16(self.0.select(yes.0, no.0))
    }

    /// `yes` where it is true, else `no`.
    #[inline(always)]
    pub(crate) fn select_words(self, yes: U32x16<S>, no: U32x16<S>) -> U32x16<S> {
        U32x16(self.0.select(yes.0, no.0))
    }
}

macro_rules! of_registers {
    ($($type:ident: $trait:ident $method:ident $operator:tt)*) => {$(
        impl<S: Simd> $trait for $type<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0 $operator other.0)
            }
        }
    )*};
}

of_registers! {
    F32x16: Add add +
    F32x16: Sub sub -
    F32x16: Mul mul *
    F32x16: Div div /
    U32x16: Add add +
    U32x16: Mul mul *
    U32x16: BitAnd bitand &
    U32x16: BitOr bitor |
    U32x16: BitXor bitxor ^
    Mask32x16: BitAnd bitand &
    Mask32x16: BitOr bitor |
}

impl<S: Simd> Not for Mask32x16<S> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}
