//! Sixteen numbers side by side, on any instruction set.
//!
//! All kernels work on [`LANES`] f64 at a time, whatever the machine's registers hold, with nothing
//! but +, −, ·, ÷, √, comparisons and selections. Each of these is exact to the last bit by IEEE 754
//! and none is fused with another, so that every instruction set gives the same bits.
//!
//! A kernel is written once, generic over the instruction set; [`Door::run`] is the only place that
//! chooses one.

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};
use std::str::FromStr;

use fearless_simd::prelude::*;
use fearless_simd::{Level, Simd, f32x16, f64x8, mask32x16, mask64x8, u32x16, u64x8};

use crate::math::DVec3;

/// Numbers side by side.
pub const LANES: usize = 16;

/// Lanes of one register, two of which are a set of lanes: long operations of the two overlap.
const HALF: usize = LANES / 2;

/// An f64 in each lane.
#[derive(Clone, Copy, Debug)]
pub struct Lanes<S: Simd>([f64x8<S>; 2]);

/// A truth value in each lane.
#[derive(Clone, Copy, Debug)]
pub struct Mask<S: Simd>([mask64x8<S>; 2]);

/// A u64 in each lane.
#[derive(Clone, Copy, Debug)]
pub struct Ids<S: Simd>([u64x8<S>; 2]);

/// An f32 in each lane: for what is decided with a margin, and asked again in f64 within it. Its
/// products and sums may be fused, so that no pixel may depend on more than such a decision.
#[derive(Clone, Copy, Debug)]
pub struct Singles<S: Simd>(f32x16<S>);

/// A truth value for each of [`Singles`].
#[derive(Clone, Copy, Debug)]
pub struct SingleMask<S: Simd>(mask32x16<S>);

/// A u32 in each lane; sums and products are modulo 2³².
#[derive(Clone, Copy, Debug)]
pub struct Words<S: Simd>(u32x16<S>);

/// A vector in each lane.
#[derive(Clone, Copy, Debug)]
pub struct Vectors<S: Simd> {
    /// Along x.
    pub x: Lanes<S>,
    /// Along y.
    pub y: Lanes<S>,
    /// Along z.
    pub z: Lanes<S>,
}

impl<S: Simd> Lanes<S> {
    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: f64) -> Self {
        Self([f64x8::splat(simd, value); 2])
    }

    /// The first [`LANES`] numbers of a slice.
    #[inline(always)]
    pub fn load(simd: S, numbers: &[f64]) -> Self {
        Self([
            f64x8::from_slice(simd, &numbers[..HALF]),
            f64x8::from_slice(simd, &numbers[HALF..LANES]),
        ])
    }

    /// Into the first [`LANES`] places of a slice.
    #[inline(always)]
    pub fn store(self, numbers: &mut [f64]) {
        self.0[0].store_slice(&mut numbers[..HALF]);
        self.0[1].store_slice(&mut numbers[HALF..LANES]);
    }

    /// As an array.
    #[inline(always)]
    pub fn to_array(self) -> [f64; LANES] {
        let mut array = [0.0; LANES];
        self.store(&mut array);
        array
    }

    /// √
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self([self.0[0].sqrt(), self.0[1].sqrt()])
    }

    /// [`inverse_root`](crate::math::inverse_root) of each, to the same bits.
    #[inline(always)]
    pub fn inverse_root(self, simd: S) -> Self {
        let one = f32x16::splat(simd, 1.0);
        let near = one / self.narrowed(simd).0.sqrt();
        let (low, high) = simd.widen_f32x16(near);
        let one = Self::splat(simd, 1.0);
        let y = Self([low, high]);
        let y = y + y * ((one - self * y * y) * 0.5);
        y + y * ((one - self * y * y) * 0.5)
    }

    /// The magnitude.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self([self.0[0].abs(), self.0[1].abs()])
    }

    /// The smallest of all; none may be NaN.
    #[inline(always)]
    pub fn smallest(self) -> f64 {
        let [low, high] = self.0;
        low.simd_lt(high).select(low, high).reduce_min()
    }

    /// The smaller of two numbers; `other` where one of them is not a number.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        self.lt(other).select(self, other)
    }

    /// The larger of two numbers; `other` where one of them is not a number.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        self.gt(other).select(self, other)
    }

    /// The largest of all; none may be NaN.
    #[inline(always)]
    pub fn largest(self) -> f64 {
        let [low, high] = self.0;
        low.simd_gt(high).select(low, high).reduce_max()
    }

    /// Where it is below.
    #[inline(always)]
    pub fn lt(self, other: Self) -> Mask<S> {
        Mask([self.0[0].simd_lt(other.0[0]), self.0[1].simd_lt(other.0[1])])
    }

    /// Where it is below or equal.
    #[inline(always)]
    pub fn le(self, other: Self) -> Mask<S> {
        Mask([self.0[0].simd_le(other.0[0]), self.0[1].simd_le(other.0[1])])
    }

    /// Where it is above.
    #[inline(always)]
    pub fn gt(self, other: Self) -> Mask<S> {
        Mask([self.0[0].simd_gt(other.0[0]), self.0[1].simd_gt(other.0[1])])
    }

    /// Where it is above or equal.
    #[inline(always)]
    pub fn ge(self, other: Self) -> Mask<S> {
        Mask([self.0[0].simd_ge(other.0[0]), self.0[1].simd_ge(other.0[1])])
    }

    /// Where it is equal.
    #[inline(always)]
    pub fn eq(self, other: Self) -> Mask<S> {
        Mask([self.0[0].simd_eq(other.0[0]), self.0[1].simd_eq(other.0[1])])
    }

    /// Where it is above 0.
    #[inline(always)]
    pub fn is_positive(self) -> Mask<S> {
        Mask([self.0[0].simd_gt(0.0), self.0[1].simd_gt(0.0)])
    }

    /// The bits of each.
    #[inline(always)]
    pub fn to_bits(self) -> Ids<S> {
        Ids([self.0[0].to_bits(), self.0[1].to_bits()])
    }

    /// The number with these bits in each.
    #[inline(always)]
    pub fn from_bits(bits: Ids<S>) -> Self {
        Self([f64x8::from_bits(bits.0[0]), f64x8::from_bits(bits.0[1])])
    }
}

impl<S: Simd> Lanes<S> {
    /// The nearest f32 of each.
    #[inline(always)]
    pub fn narrowed(self, simd: S) -> Singles<S> {
        Singles(simd.narrow_f64x8(self.0[0], self.0[1]))
    }
}

impl<S: Simd> Singles<S> {
    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: f32) -> Self {
        Self(f32x16::splat(simd, value))
    }

    /// The first [`LANES`] numbers of a slice.
    #[inline(always)]
    pub fn load(simd: S, numbers: &[f32]) -> Self {
        Self(f32x16::from_slice(simd, &numbers[..LANES]))
    }

    /// Into the first [`LANES`] places of a slice.
    #[inline(always)]
    pub fn store(self, numbers: &mut [f32]) {
        self.0.store_slice(&mut numbers[..LANES]);
    }

    /// self · factor + term, rounded once or twice.
    #[inline(always)]
    pub fn times_plus(self, factor: Self, term: Self) -> Self {
        Self(self.0.mul_add(factor.0, term.0))
    }

    /// √
    #[inline(always)]
    pub fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }

    /// The magnitude.
    #[inline(always)]
    pub fn abs(self) -> Self {
        Self(self.0.abs())
    }

    /// The smaller of two numbers, neither NaN.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self(self.0.min(other.0))
    }

    /// The larger of two numbers, neither NaN.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self(self.0.max(other.0))
    }

    /// The smallest of all; none may be NaN.
    #[inline(always)]
    pub fn smallest(self) -> f32 {
        self.0.reduce_min()
    }

    /// The largest of all; none may be NaN.
    #[inline(always)]
    pub fn largest(self) -> f32 {
        self.0.reduce_max()
    }

    /// Where it is below or equal.
    #[inline(always)]
    pub fn le(self, other: Self) -> SingleMask<S> {
        SingleMask(self.0.simd_le(other.0))
    }

    /// Where it is above.
    #[inline(always)]
    pub fn gt(self, other: Self) -> SingleMask<S> {
        SingleMask(self.0.simd_gt(other.0))
    }

    /// Where it is above or equal.
    #[inline(always)]
    pub fn ge(self, other: Self) -> SingleMask<S> {
        SingleMask(self.0.simd_ge(other.0))
    }
}

/// The smallest of each of sixteen, none NaN; side by side.
#[inline(always)]
pub fn smallest_of_each<S: Simd>(mut rows: [Singles<S>; LANES]) -> Singles<S> {
    // Two rows become one with half as many of each, in turn; the last one has them in order.
    let mut half = LANES / 2;
    while half > 0 {
        for row in 0..half {
            let (first, second) = (rows[row].0, rows[row + half].0);
            let (low, high) = first.interleave(second);
            rows[row] = Singles(low.min(high));
        }
        half /= 2;
    }
    rows[0]
}

impl<S: Simd> Words<S> {
    /// The same in every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: u32) -> Self {
        Self(u32x16::splat(simd, value))
    }

    /// The first [`LANES`] of a slice.
    #[inline(always)]
    pub fn load(simd: S, words: &[u32]) -> Self {
        Self(u32x16::from_slice(simd, &words[..LANES]))
    }

    /// Into the first [`LANES`] places of a slice.
    #[inline(always)]
    pub fn store(self, words: &mut [u32]) {
        self.0.store_slice(&mut words[..LANES]);
    }

    /// Where it is equal.
    #[inline(always)]
    pub fn eq(self, other: Self) -> SingleMask<S> {
        SingleMask(self.0.simd_eq(other.0))
    }

    /// Where it is below.
    #[inline(always)]
    pub fn lt(self, other: Self) -> SingleMask<S> {
        SingleMask(self.0.simd_lt(other.0))
    }

    /// Shifted towards the larger places.
    #[inline(always)]
    pub fn shifted_up(self, bits: u32) -> Self {
        Self(self.0 << bits)
    }

    /// Shifted towards the smaller places.
    #[inline(always)]
    pub fn shifted_down(self, bits: u32) -> Self {
        Self(self.0 >> bits)
    }

    /// As f64, exactly.
    #[inline(always)]
    pub fn widened(self, simd: S) -> Lanes<S> {
        let (low, high) = simd.widen_u32x16(self.0);
        Lanes([simd.cvt_f64_u64x8(low), simd.cvt_f64_u64x8(high)])
    }
}

impl<S: Simd> SingleMask<S> {
    /// From one bit for each lane, the first lane lowest.
    #[inline(always)]
    pub fn from_bits(simd: S, bits: u32) -> Self {
        Self(mask32x16::from_bitmask(simd, u64::from(bits)))
    }

    /// One bit for each lane, the first lane lowest.
    #[inline(always)]
    pub fn to_bits(self) -> u32 {
        self.0.to_bitmask() as u32
    }

    /// `yes` where it is true, else `no`.
    #[inline(always)]
    pub fn select(self, yes: Singles<S>, no: Singles<S>) -> Singles<S> {
        Singles(self.0.select(yes.0, no.0))
    }

    /// `yes` where it is true, else `no`.
    #[inline(always)]
    pub fn select_words(self, yes: Words<S>, no: Words<S>) -> Words<S> {
        Words(self.0.select(yes.0, no.0))
    }
}

impl<S: Simd> Ids<S> {
    /// The same in every lane.
    #[inline(always)]
    pub fn splat(simd: S, value: u64) -> Self {
        Self([u64x8::splat(simd, value); 2])
    }

    /// The first [`LANES`] of a slice.
    #[inline(always)]
    pub fn load(simd: S, ids: &[u64]) -> Self {
        Self([
            u64x8::from_slice(simd, &ids[..HALF]),
            u64x8::from_slice(simd, &ids[HALF..LANES]),
        ])
    }

    /// As an array.
    #[inline(always)]
    pub fn to_array(self) -> [u64; LANES] {
        let mut array = [0; LANES];
        self.0[0].store_slice(&mut array[..HALF]);
        self.0[1].store_slice(&mut array[HALF..]);
        array
    }

    /// Where it is below.
    #[inline(always)]
    pub fn lt(self, other: Self) -> Mask<S> {
        Mask([self.0[0].simd_lt(other.0[0]), self.0[1].simd_lt(other.0[1])])
    }

    /// Where it is equal.
    #[inline(always)]
    pub fn eq(self, other: Self) -> Mask<S> {
        Mask([self.0[0].simd_eq(other.0[0]), self.0[1].simd_eq(other.0[1])])
    }

    /// Shifted towards the larger places.
    #[inline(always)]
    pub fn shifted_up(self, bits: u32) -> Self {
        Self([self.0[0] << bits, self.0[1] << bits])
    }

    /// Shifted towards the smaller places.
    #[inline(always)]
    pub fn shifted_down(self, bits: u32) -> Self {
        Self([self.0[0] >> bits, self.0[1] >> bits])
    }

    /// The sum, modulo 2⁶⁴.
    #[inline(always)]
    pub fn plus(self, other: u64) -> Self {
        Self([self.0[0] + other, self.0[1] + other])
    }

    /// The bits that both have.
    #[inline(always)]
    pub fn and(self, other: u64) -> Self {
        Self([self.0[0] & other, self.0[1] & other])
    }

    /// The bits that either has.
    #[inline(always)]
    pub fn or(self, other: u64) -> Self {
        Self([self.0[0] | other, self.0[1] | other])
    }
}

impl<S: Simd> Mask<S> {
    /// From one bit for each lane, the first lane lowest.
    #[inline(always)]
    pub fn from_bits(simd: S, bits: u32) -> Self {
        let half = |bits: u32| mask64x8::from_bitmask(simd, u64::from(bits & 0xff));
        Self([half(bits), half(bits >> HALF)])
    }

    /// One bit for each lane, the first lane lowest.
    #[inline(always)]
    pub fn to_bits(self) -> u32 {
        let [low, high] = [
            self.0[0].to_bitmask() as u32 & 0xff,
            self.0[1].to_bitmask() as u32 & 0xff,
        ];
        low | high << HALF
    }

    /// Whether it is true in any lane.
    #[inline(always)]
    pub fn any(self) -> bool {
        (self.0[0] | self.0[1]).any_true()
    }

    /// `yes` where it is true, else `no`.
    #[inline(always)]
    pub fn select(self, yes: Lanes<S>, no: Lanes<S>) -> Lanes<S> {
        Lanes([
            self.0[0].select(yes.0[0], no.0[0]),
            self.0[1].select(yes.0[1], no.0[1]),
        ])
    }

    /// `yes` where it is true, else `no`.
    #[inline(always)]
    pub fn select_ids(self, yes: Ids<S>, no: Ids<S>) -> Ids<S> {
        Ids([
            self.0[0].select(yes.0[0], no.0[0]),
            self.0[1].select(yes.0[1], no.0[1]),
        ])
    }

    /// `yes` where it is true, else `no`.
    #[inline(always)]
    pub fn select_vectors(self, yes: Vectors<S>, no: Vectors<S>) -> Vectors<S> {
        Vectors {
            x: self.select(yes.x, no.x),
            y: self.select(yes.y, no.y),
            z: self.select(yes.z, no.z),
        }
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
    Singles: Add add +
    Singles: Sub sub -
    Singles: Mul mul *
    Singles: Div div /
    Words: Add add +
    Words: Mul mul *
    Words: BitAnd bitand &
    Words: BitOr bitor |
    Words: BitXor bitxor ^
    SingleMask: BitAnd bitand &
    SingleMask: BitOr bitor |
}

impl<S: Simd> Not for SingleMask<S> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
}

macro_rules! arithmetic {
    ($($trait:ident $method:ident $operator:tt)*) => {$(
        impl<S: Simd> $trait for Lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self([self.0[0] $operator other.0[0], self.0[1] $operator other.0[1]])
            }
        }

        impl<S: Simd> $trait<f64> for Lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                Self([self.0[0] $operator other, self.0[1] $operator other])
            }
        }
    )*};
}

arithmetic! { Add add + Sub sub - Mul mul * Div div / }

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self([-self.0[0], -self.0[1]])
    }
}

impl<S: Simd> BitAnd for Mask<S> {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self([self.0[0] & other.0[0], self.0[1] & other.0[1]])
    }
}

impl<S: Simd> BitOr for Mask<S> {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self([self.0[0] | other.0[0], self.0[1] | other.0[1]])
    }
}

impl<S: Simd> Not for Mask<S> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self([!self.0[0], !self.0[1]])
    }
}

impl<S: Simd> Vectors<S> {
    /// The same vector in every lane.
    #[inline(always)]
    pub fn splat(simd: S, vector: DVec3) -> Self {
        Self {
            x: Lanes::splat(simd, vector.x),
            y: Lanes::splat(simd, vector.y),
            z: Lanes::splat(simd, vector.z),
        }
    }

    /// The first [`LANES`] of three columns.
    #[inline(always)]
    pub fn load(simd: S, [x, y, z]: [&[f64]; 3]) -> Self {
        Self {
            x: Lanes::load(simd, x),
            y: Lanes::load(simd, y),
            z: Lanes::load(simd, z),
        }
    }

    /// Into the first [`LANES`] places of three columns.
    #[inline(always)]
    pub fn store(self, [x, y, z]: [&mut [f64]; 3]) {
        self.x.store(x);
        self.y.store(y);
        self.z.store(z);
    }

    /// a · b
    #[inline(always)]
    pub fn dot(self, other: Self) -> Lanes<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// a · b with one vector for all lanes.
    #[inline(always)]
    pub fn dot_with(self, other: DVec3) -> Lanes<S> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// x, y or z.
    #[inline(always)]
    pub fn component(self, axis: usize) -> Lanes<S> {
        match axis {
            0 => self.x,
            1 => self.y,
            _ => self.z,
        }
    }

    /// a × b
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - other.y * self.z,
            y: self.z * other.x - other.z * self.x,
            z: self.x * other.y - other.x * self.y,
        }
    }

    /// The sum of the components' magnitudes: at least the length, at most √3 times as much.
    #[inline(always)]
    pub fn taxicab(self) -> Lanes<S> {
        self.x.abs() + self.y.abs() + self.z.abs()
    }

    /// The component of the largest magnitude, as a magnitude.
    #[inline(always)]
    pub fn largest(self) -> Lanes<S> {
        self.x.abs().max(self.y.abs()).max(self.z.abs())
    }

    /// Each vector times a number.
    #[inline(always)]
    pub fn times(self, factor: Lanes<S>) -> Self {
        Self {
            x: self.x * factor,
            y: self.y * factor,
            z: self.z * factor,
        }
    }

    /// Each vector minus one for all lanes.
    #[inline(always)]
    pub fn minus(self, other: DVec3) -> Self {
        Self {
            x: self.x - other.x,
            y: self.y - other.y,
            z: self.z - other.z,
        }
    }
}

impl<S: Simd> Add for Vectors<S> {
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

impl<S: Simd> Sub for Vectors<S> {
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

impl<S: Simd> Neg for Vectors<S> {
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

/// Which instructions the kernels use. All give the same bits.
#[derive(Clone, Copy, Debug)]
pub struct Door(Level);

impl PartialEq for Door {
    fn eq(&self, other: &Self) -> bool {
        std::mem::discriminant(&self.0) == std::mem::discriminant(&other.0)
    }
}

impl Eq for Door {}

/// A kernel: one body for all instruction sets. What it calls must be inlined into it, since only
/// what is inside is compiled for the instructions chosen.
pub trait Kernel {
    /// What it comes to.
    type Output;

    /// The body; marked `#[inline(always)]`.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

impl Default for Door {
    /// The widest instructions that the machine has.
    fn default() -> Self {
        Self(Level::new())
    }
}

/// A name that is none of an instruction set, or of one that the machine lacks.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{name}` is not an instruction set of this machine, expected one of {available}")]
pub struct UnknownInstructions {
    name: String,
    available: String,
}

impl Door {
    /// Those of this machine with their names, the widest first.
    pub fn available() -> Vec<(&'static str, Self)> {
        let level = Level::new();
        #[cfg(target_arch = "x86_64")]
        let levels = [
            ("avx512", level.as_avx512().map(Simd::level)),
            ("avx2", level.as_avx2().map(Simd::level)),
            ("sse2", level.as_sse2().map(Simd::level)),
        ];
        #[cfg(target_arch = "aarch64")]
        let levels = [("neon", level.as_neon().map(Simd::level))];
        #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
        let levels = [("scalar", Some(level))];
        levels
            .into_iter()
            .filter_map(|(name, level)| Some((name, Self(level?))))
            .collect()
    }

    /// Runs a kernel, compiled for these instructions.
    #[inline(always)]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        // Not by the crate's `dispatch!` where it can be helped: it would compile every kernel also
        // for the levels in between.
        #[cfg(target_arch = "x86_64")]
        if let Some(simd) = self.0.as_avx512() {
            simd.vectorize(
                #[inline(always)]
                || kernel.run(simd),
            )
        } else if let Some(simd) = self.0.as_avx2() {
            simd.vectorize(
                #[inline(always)]
                || kernel.run(simd),
            )
        } else {
            let simd = self.0.as_sse2().expect("every x86-64 has SSE2");
            simd.vectorize(
                #[inline(always)]
                || kernel.run(simd),
            )
        }
        #[cfg(not(target_arch = "x86_64"))]
        fearless_simd::dispatch!(self.0, simd => kernel.run(simd))
    }
}

impl FromStr for Door {
    type Err = UnknownInstructions;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let available = Self::available();
        let found = available.iter().find(|(known, _)| *known == name);
        found.map(|(_, door)| *door).ok_or_else(|| {
            let names: Vec<&str> = available.iter().map(|(name, _)| *name).collect();
            UnknownInstructions {
                name: name.to_owned(),
                available: names.join(", "),
            }
        })
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
            let x = Lanes::load(simd, &self.0);
            let y = (x * 3.7 - 1.0) / (x + 0.3);
            let z = y.abs().sqrt().max(x).min(Lanes::splat(simd, 2.5));
            let exponent = z.to_bits().shifted_down(52).and(0x7ff);
            let is_small = exponent.lt(Ids::splat(simd, 1023));
            (is_small & !x.is_positive()).select(-z, z).to_array()
        }
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        let numbers = std::array::from_fn(|i| (i as f64 - 7.3) * 0.37);
        let bits = |door: Door| door.run(Arithmetic(numbers)).map(f64::to_bits);
        let expected = bits(Door::default());
        for (name, door) in Door::available() {
            assert_eq!(bits(door), expected, "{name}");
            assert!(name.parse::<Door>().is_ok());
        }
        assert!("mmx".parse::<Door>().is_err());
    }

    struct Bits(u32);

    impl Kernel for Bits {
        type Output = u32;

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> u32 {
            Mask::from_bits(simd, self.0).to_bits()
        }
    }

    #[test]
    fn masks_keep_their_bits() {
        for (_, door) in Door::available() {
            for bits in [0, 1, 0x8000, 0xffff, 0x1234] {
                assert_eq!(door.run(Bits(bits)), bits);
            }
        }
    }
}
