//! Sixteen rays side by side: where they start, where they go, and what they share.

use fearless_simd::Simd;

use crate::math::{DVec3, Point};
use crate::simd::{DVec3x16, F64x16, Mask64x16};

/// How much a few operations in f64 on coordinates of magnitude 1 can be off: each by ε/2, eight of
/// them, and as much again for room. Times a length, it is the bound below which "on the surface"
/// and "beside it" are the same.
pub(super) const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Rays r(t) = o + t ω, side by side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rays<S: Simd> {
    pub(super) origin: DVec3x16<S>,
    pub(super) direction: DVec3x16<S>,
    /// Where all start, if they start at one point.
    pub(super) shared_origin: Option<DVec3>,
    /// |ω|²
    pub(super) square: F64x16<S>,
}

/// Rays that are asked together, sheared for the triangles.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShearedRays<S: Simd> {
    pub(super) rays: Rays<S>,
    pub(super) shears: Shears<S>,
}

impl<S: Simd> ShearedRays<S> {
    #[inline(always)]
    pub(super) fn new(rays: Rays<S>) -> Self {
        Self {
            rays,
            shears: shears(rays.direction),
        }
    }
}

impl<S: Simd> Rays<S> {
    /// Rays from one point.
    #[inline(always)]
    pub(super) fn from_point(simd: S, origin: Point, direction: DVec3x16<S>) -> Self {
        let origins = DVec3x16::splat(simd, origin.0);
        Self::new(origins, direction, Some(origin.0))
    }

    #[inline(always)]
    pub(super) fn new(
        origin: DVec3x16<S>,
        direction: DVec3x16<S>,
        shared_origin: Option<DVec3>,
    ) -> Self {
        Self {
            origin,
            direction,
            shared_origin,
            square: direction.dot(direction),
        }
    }
}

/// Of rays that run along one axis, the others of their directions over that axis, in cyclic order.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shear<S: Simd> {
    /// The rays whose largest component is along this axis.
    pub(super) rays: Mask64x16<S>,
    /// One bit for each of them.
    pub(super) bits: u32,
    pub(super) slopes: [F64x16<S>; 2],
}

/// The shears of a packet, for x, y and z.
pub(super) type Shears<S> = [Shear<S>; 3];

/// The axis and the two that follow it.
pub(super) const CYCLE: [[usize; 3]; 3] = [[1, 2, 0], [2, 0, 1], [0, 1, 2]];

/// The shears of rays with these directions.
#[inline(always)]
fn shears<S: Simd>(direction: DVec3x16<S>) -> Shears<S> {
    let d = [direction.x, direction.y, direction.z];
    let size = [d[0].abs(), d[1].abs(), d[2].abs()];
    let is_x = size[0].ge(size[1]) & size[0].ge(size[2]);
    let is_y = size[1].ge(size[2]) & !is_x;
    let along = [is_x, is_y, !(is_x | is_y)];
    [
        shear(d, along[0], CYCLE[0]),
        shear(d, along[1], CYCLE[1]),
        shear(d, along[2], CYCLE[2]),
    ]
}

/// The shear of the rays that run along the last axis of a cycle.
#[inline(always)]
fn shear<S: Simd>(d: [F64x16<S>; 3], rays: Mask64x16<S>, [u, v, w]: [usize; 3]) -> Shear<S> {
    let bits = rays.to_bits();
    Shear {
        rays,
        bits,
        // No division for an axis that no ray has.
        slopes: if bits == 0 {
            [d[u]; 2]
        } else {
            [d[u] / d[w], d[v] / d[w]]
        },
    }
}
