//! Batches of rays, and their numbers in columns.

use fearless_simd::Simd;

use crate::math::DVec3;
use crate::simd::{DVec3x16, F64x16, LANES, Mask64x16};

/// Rays that are traced and shaded together.
pub(crate) const BATCH: usize = 256;

/// Packets of a batch.
pub(crate) const PACKETS: usize = BATCH / LANES;

/// One number for each ray of a batch.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Column(pub(crate) [f64; BATCH]);

impl Column {
    pub(crate) const ZERO: Self = Self([0.0; BATCH]);
}

impl std::ops::Deref for Column {
    type Target = [f64; BATCH];

    #[inline(always)]
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl std::ops::DerefMut for Column {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

/// An f32 for each of sixteen.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Row(pub(super) [f32; LANES]);

/// An f32 for each ray of a batch.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Floats(pub(super) [f32; BATCH]);

/// Three columns of a packet.
#[inline(always)]
pub(crate) fn columns(columns: &[Column; 3], packet: usize) -> [&[f64]; 3] {
    let [x, y, z] = columns;
    let lanes = packet * LANES..(packet + 1) * LANES;
    [&x[lanes.clone()], &y[lanes.clone()], &z[lanes]]
}

#[inline(always)]
pub(super) fn columns_mut(columns: &mut [Column; 3], packet: usize) -> [&mut [f64]; 3] {
    let [x, y, z] = columns;
    let lanes = packet * LANES..(packet + 1) * LANES;
    [&mut x[lanes.clone()], &mut y[lanes.clone()], &mut z[lanes]]
}

/// The rest of three columns, from a place on.
#[inline(always)]
pub(super) fn columns_from(columns: &mut [Column; 3], place: usize) -> [&mut [f64]; 3] {
    let [x, y, z] = columns;
    [&mut x[place..], &mut y[place..], &mut z[place..]]
}

/// The vector of one ray in three columns.
#[inline(always)]
pub(crate) fn vector(columns: &[Column; 3], ray: usize) -> DVec3 {
    let [x, y, z] = columns;
    DVec3::new(x[ray], y[ray], z[ray])
}

/// The offsets of a packet's points from an origin.
#[inline(always)]
pub(super) fn offsets<S: Simd>(
    simd: S,
    positions: &[Column; 3],
    packet: usize,
    origin: DVec3,
) -> DVec3x16<S> {
    DVec3x16::load(simd, columns(positions, packet)).minus(origin)
}

/// One bit for each of the first `count` lanes of a packet.
#[inline]
pub(super) fn first_lanes(count: usize, packet: usize) -> u32 {
    let left = count.saturating_sub(packet * LANES).min(LANES);
    (1_u32 << left) - 1
}

/// The ranges of columns over the lanes with a bit; `None` where there is none.
#[inline(always)]
pub(super) fn ranges<S: Simd>(
    simd: S,
    bits: impl Fn(usize) -> u32,
    vectors: impl Fn(usize) -> DVec3x16<S>,
) -> Option<[DVec3; 2]> {
    let infinite = DVec3x16::splat(simd, DVec3::INFINITY);
    let (mut least, mut most) = (infinite, -infinite);
    let mut any = 0;
    for packet in 0..PACKETS {
        let bits = bits(packet);
        if bits == 0 {
            continue;
        }
        any |= bits;
        let asked = Mask64x16::from_bits(simd, bits);
        let vectors = vectors(packet);
        let low = asked.select_vectors(vectors, infinite);
        let high = asked.select_vectors(vectors, -infinite);
        least.x = low.x.min(least.x);
        least.y = low.y.min(least.y);
        least.z = low.z.min(least.z);
        most.x = high.x.max(most.x);
        most.y = high.y.max(most.y);
        most.z = high.z.max(most.z);
    }
    if any == 0 {
        return None;
    }
    Some([
        -DVec3::new(
            (-least.x).largest(),
            (-least.y).largest(),
            (-least.z).largest(),
        ),
        DVec3::new(most.x.largest(), most.y.largest(), most.z.largest()),
    ])
}

/// The largest component of any direction in a range.
#[inline]
pub(super) fn longest([least, most]: &[DVec3; 2]) -> f64 {
    least.abs().max(most.abs()).max_element()
}

/// The range of the numbers in some lanes.
#[inline(always)]
pub(super) fn range<S: Simd>(simd: S, column: F64x16<S>, asked: Mask64x16<S>) -> [f64; 2] {
    let infinite = F64x16::splat(simd, f64::INFINITY);
    [
        -asked.select(-column, -infinite).largest(),
        asked.select(column, -infinite).largest(),
    ]
}
