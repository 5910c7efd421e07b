//! One ray before the sixteen triangles of a leaf block: what f32 can tell of each.
//!
//! The ray is taken from where it is nearest to the middle of the block along its largest axis w, so that all
//! numbers are of the size of the block and f32 is off by parts of it, however far away the ray
//! starts. It is sheared along w as in f64 (see [`super`]): a corner c is at
//! (c_u − s_u c_w, c_v − s_v c_w), and with p where the ray crosses the middle's plane, a the first corner less p,
//! and e and f the ways from it to the others, the edge functions are
//!
//! E_c = a × e, E_b = f × a, and E_a = e × f − E_b − E_c,
//!
//! all in units of the block's size. With u = 2⁻²⁴, and L the sum of the magnitudes of a sheared way's
//! components and of its w: the way is off by 7 u L in each component (it is stored with u, the slope is off by u,
//! and there are two operations); a by 14 u, and by the noise ρ of f64; |a| is at most 4 in each component. So
//! E_b and E_c are off by 57 u L + (14 u + ρ) L + 12 u L for the ways, for a, and for their own three
//! operations, and E_a + E_b + E_c = e × f by 17 u L L′. [`KAPPA`] and [`NU`] have room for the two sums of E_a,
//! whose terms are at most 4 (L + L′) + L L′.
//!
//! In f64 a corner is off by ρ/4 at most, and edge functions by no more than (2 L + 2 ρ) ρ where the ray
//! passes within ρ of the triangle; elsewhere they cannot all have one sign. The first is within κ L, the
//! second in τ, which also leaves triangles that are nothing beside their block to f64.

use fearless_simd::Simd;

use super::leaf_block::{F32_ROUNDING, LeafBlock};
use crate::math::{DVec3, both};
use crate::simd::{F32x16, LANES, Mask32x16};
use crate::visibility::batch::Row;
use crate::visibility::rays::{CYCLE, ROUNDING as F64_ROUNDING};

/// κ/u and ν/u of the module's errors.
const KAPPA: f32 = 96.0 * F32_ROUNDING;
const NU: f32 = 24.0 * F32_ROUNDING;

/// By how much depths give way beside what edge functions make of them: eight roundings of sums of five.
const DEPTH_GIVES_WAY: f32 = 64.0 * F32_ROUNDING;

/// How far f64 is off where a ray passes a block's middle, over the way there: the way, a slope, their product,
/// and a difference are rounded by ε/2 each, of numbers up to twice the way; and as much again for room.
const WAY_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// What a few roundings to f32 of a segment's ends and their distances from a plane come to.
const SLACK: f64 = 1.0 / (1 << 20) as f64;

/// Triangles whose edge functions are below this are nothing beside their block.
const TINIEST: f32 = 1.0 / (1_u64 << 40) as f32;

/// A ray that passes the middle further away than this passes all corners: sheared, they are within 2.
const WIDEST: f64 = 2.0 + 1.0 / (1 << 16) as f64;

/// Where f64 places a ray worse than this part of the block, f32 says nothing.
const NOISIEST: f64 = 1.0 / (1 << 20) as f64;

/// A ray as blocks are met by it.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct SingleRay {
    /// The axes u, v and w: w is that of the largest component.
    axes: [usize; 3],
    origin: DVec3,
    /// Those along u and v over that along w.
    slopes: [f64; 2],
    /// Of the direction along w, its reciprocal, and the sum of all components' magnitudes.
    along: f64,
    over_along: f64,
    length: f64,
}

/// What is told of the triangles of a block.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct BlockHits<S: Simd> {
    /// One bit for each that the ray may pass through, and for each that it does in f64 as well.
    pub(in crate::visibility) maybe: u32,
    pub(in crate::visibility) surely: u32,
    /// Between which depths along w from the middle, in units of the size.
    least: F32x16<S>,
    most: F32x16<S>,
    /// |E_a + E_b + E_c|, at least, and more than the length of the normal: their ratio is how far the ray
    /// gets from a triangle's plane along one unit of w, at least.
    speed: F32x16<S>,
    normal: F32x16<S>,
    /// From depths to t: along w from the start to the middle, and the size.
    to_middle: f64,
    size: f64,
    over_along: f64,
    /// At least how long the ways are from the start to the middle and from there to the world's anchor.
    distance: f64,
}

impl SingleRay {
    pub(in crate::visibility) const NONE: Self = Self {
        axes: CYCLE[0],
        origin: DVec3::ZERO,
        slopes: [0.0; 2],
        along: 1.0,
        over_along: 1.0,
        length: 1.0,
    };

    #[inline(always)]
    pub(in crate::visibility) fn new(origin: DVec3, direction: DVec3) -> Self {
        let size = direction.abs();
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let [u, v, w] = CYCLE[axis];
        let length = size.element_sum();
        let direction = direction.to_array();
        let along = direction[w];
        Self {
            axes: [u, v, w],
            origin,
            slopes: [direction[u] / along, direction[v] / along],
            along,
            over_along: 1.0 / along,
            length,
        }
    }
}

impl LeafBlock {
    /// What f32 can tell of those with a bit; `None` if the ray passes through none.
    #[inline(always)]
    pub(in crate::visibility) fn meet<S: Simd>(
        &self,
        simd: S,
        ray: &SingleRay,
        bits: u32,
    ) -> Option<BlockHits<S>> {
        let [u, v, w] = ray.axes;
        let to_middle = self.middle - ray.origin;
        let distance = to_middle.abs().element_sum();
        let to_middle = to_middle.to_array();
        let [slope_u, slope_v] = ray.slopes;
        let over_size = self.over_size;
        let noise = distance * over_size * WAY_ROUNDING;
        let beside_u = (slope_u * to_middle[w] - to_middle[u]) * over_size;
        let beside_v = (slope_v * to_middle[w] - to_middle[v]) * over_size;
        let is_told = noise < NOISIEST;
        if is_told && (beside_u.abs() > WIDEST || beside_v.abs() > WIDEST) {
            return None;
        }
        let noise = noise as f32;
        let (a_w, e_w, f_w) = (
            F32x16::load(simd, &self.first[w].0),
            F32x16::load(simd, &self.to_second[w].0),
            F32x16::load(simd, &self.to_third[w].0),
        );
        let low = a_w.min(a_w + e_w).min(a_w + f_w);
        let high = a_w.max(a_w + e_w).max(a_w + f_w);
        let mut hits = BlockHits {
            maybe: bits,
            surely: 0,
            least: low,
            most: high,
            speed: F32x16::splat(simd, 0.0),
            normal: F32x16::splat(simd, 1.0),
            to_middle: to_middle[w],
            size: self.size,
            over_along: ray.over_along,
            distance: distance + self.middle.abs().element_sum(),
        };
        if !is_told {
            hits.least = F32x16::splat(simd, f32::NEG_INFINITY);
            hits.most = F32x16::splat(simd, f32::INFINITY);
            return Some(hits);
        }
        let (minus_u, minus_v) = (
            F32x16::splat(simd, -slope_u as f32),
            F32x16::splat(simd, -slope_v as f32),
        );
        let (beside_u, beside_v) = (
            F32x16::splat(simd, beside_u as f32),
            F32x16::splat(simd, beside_v as f32),
        );
        let a_u = sheared(simd, a_w, minus_u, &self.first[u]) - beside_u;
        let a_v = sheared(simd, a_w, minus_v, &self.first[v]) - beside_v;
        let e_u = sheared(simd, e_w, minus_u, &self.to_second[u]);
        let e_v = sheared(simd, e_w, minus_v, &self.to_second[v]);
        let f_u = sheared(simd, f_w, minus_u, &self.to_third[u]);
        let f_v = sheared(simd, f_w, minus_v, &self.to_third[v]);
        let (size_e, size_f) = (
            e_u.abs() + e_v.abs() + e_w.abs(),
            f_u.abs() + f_v.abs() + f_w.abs(),
        );
        let edge_c = a_u * e_v - a_v * e_u;
        let edge_b = f_u * a_v - f_v * a_u;
        let whole = e_u * f_v - e_v * f_u;
        let edge_a = whole - edge_b - edge_c;
        let kappa = F32x16::splat(simd, KAPPA + 8.0 * noise);
        let tau = F32x16::splat(simd, TINIEST + 8.0 * noise * noise);
        let error_c = size_e.times_plus(kappa, tau);
        let error_b = size_f.times_plus(kappa, tau);
        let sizes = size_e * size_f;
        let error_whole = sizes * F32x16::splat(simd, NU + 8.0 * noise);
        let error_a = error_b + error_c + error_whole;
        let (edges, errors) = ([edge_a, edge_b, edge_c], [error_a, error_b, error_c]);
        let [maybe, surely] = have_one_sign(simd, edges, errors);
        hits.maybe = maybe & bits;
        if hits.maybe == 0 {
            return None;
        }
        hits.surely = surely & hits.maybe;
        let give = F32x16::splat(simd, DEPTH_GIVES_WAY + 2.0 * noise);
        hits.least = low - give;
        hits.most = high + give;
        if hits.surely != 0 {
            hits.find_depths(
                simd,
                a_w,
                give,
                Edges {
                    whole,
                    edges: [edge_b, edge_c],
                    offsets_w: [e_w, f_w],
                    errors: [error_b, error_c, error_whole],
                },
            );
            // |e|₁ is at most |e_u| + |e_v| + 3 |e_w|.
            hits.normal = sizes * F32x16::splat(simd, 9.0) + tau;
        }
        Some(hits)
    }
}

/// A coordinate, as seen along the ray.
#[inline(always)]
fn sheared<S: Simd>(simd: S, w: F32x16<S>, minus_slope: F32x16<S>, row: &Row) -> F32x16<S> {
    w.times_plus(minus_slope, F32x16::load(simd, &row.0))
}

/// One bit for each triangle whose edge functions may all be 0 or of one sign, and for each whose certainly are of
/// one sign.
#[inline(always)]
fn have_one_sign<S: Simd>(
    simd: S,
    [a, b, c]: [F32x16<S>; 3],
    [error_a, error_b, error_c]: [F32x16<S>; 3],
) -> [u32; 2] {
    let zero = F32x16::splat(simd, 0.0);
    let (most_a, most_b, most_c) = (a + error_a, b + error_b, c + error_c);
    let (least_a, least_b, least_c) = (a - error_a, b - error_b, c - error_c);
    let is_positive = most_a.min(most_b).min(most_c).ge(zero);
    let is_negative = least_a.max(least_b).max(least_c).le(zero);
    let surely_positive = least_a.min(least_b).min(least_c).gt(zero);
    let surely_negative = zero.gt(most_a.max(most_b).max(most_c));
    [
        (is_positive | is_negative).to_bits(),
        (surely_positive | surely_negative).to_bits(),
    ]
}

/// E_a + E_b + E_c; E_b and E_c; along w the ways to b and c; and how far E_b, E_c and the first may be off.
#[derive(Clone, Copy)]
struct Edges<S: Simd> {
    whole: F32x16<S>,
    edges: [F32x16<S>; 2],
    offsets_w: [F32x16<S>; 2],
    errors: [F32x16<S>; 3],
}

impl<S: Simd> BlockHits<S> {
    /// Finds the depths of those that the ray surely passes through: of the first corner, and what the weights
    /// of the others add. These are off by (error + weight · error of the whole) / |whole|.
    #[inline(always)]
    fn find_depths(&mut self, simd: S, a_w: F32x16<S>, give: F32x16<S>, edges: Edges<S>) {
        let Edges {
            whole,
            edges: [edge_b, edge_c],
            offsets_w: [e_w, f_w],
            errors: [error_b, error_c, error_whole],
        } = edges;
        let (zero, one) = (F32x16::splat(simd, 0.0), F32x16::splat(simd, 1.0));
        let is_sure = Mask32x16::from_bits(simd, self.surely);
        let size = whole.abs();
        let over = one / is_sure.select(size, one);
        let depth = (edge_b * e_w + edge_c * f_w) * over;
        let depth = a_w + whole.gt(zero).select(depth, zero - depth);
        let (size_e_w, size_f_w) = (e_w.abs(), f_w.abs());
        let of_edges = size_e_w.times_plus(error_b, size_f_w * error_c);
        let of_whole = (size_e_w + size_f_w + one) * error_whole;
        let error = (of_edges + of_whole).times_plus(over, give);
        self.least = is_sure.select((depth - error).max(self.least), self.least);
        self.most = is_sure.select((depth + error).min(self.most), self.most);
        self.speed = size - error_whole;
    }

    /// Between which t each is met, if it is: the least and the most.
    #[inline(always)]
    pub(in crate::visibility) fn reach(&self) -> Reach {
        let (mut least, mut most) = ([0.0; LANES], [0.0; LANES]);
        self.least.store(&mut least);
        self.most.store(&mut most);
        Reach {
            least,
            most,
            to_middle: self.to_middle,
            size: self.size,
            over_along: self.over_along,
        }
    }

    /// Of those that the ray surely passes through, one bit for each that is between both ends of a segment, t
    /// from 0 to 1, and clear of them: further from its plane than they may be off, by `errors` and by the
    /// rounding of ways to corners and of heights.
    #[inline(always)]
    pub(in crate::visibility) fn between(
        &self,
        simd: S,
        ray: &SingleRay,
        [at_start, at_end]: [f64; 2],
    ) -> u32 {
        let rounding = (self.distance + ray.length + self.size) * (4.0 * F64_ROUNDING);
        let over_size = 1.0 / self.size;
        // Depths along w from the middle, turned so that they grow along the ray.
        let start = -self.to_middle * over_size;
        let end = (ray.along - self.to_middle) * over_size;
        let zero = F32x16::splat(simd, 0.0);
        let is_up = ray.along > 0.0;
        let (least, most) = if is_up {
            (self.least, self.most)
        } else {
            (zero - self.most, zero - self.least)
        };
        let sign = if is_up { 1.0 } else { -1.0 };
        // What is rounded is moved towards the triangle.
        let start = (start * sign + start.abs() * SLACK) as f32;
        let end = (end * sign - end.abs() * SLACK) as f32;
        let [at_start, at_end] = both([at_start, at_end], |error| {
            (error + rounding) * over_size * (1.0 + SLACK)
        });
        let after = (least - F32x16::splat(simd, start)) * self.speed;
        let before = (F32x16::splat(simd, end) - most) * self.speed;
        let are_clear = after.gt(self.normal * F32x16::splat(simd, at_start as f32))
            & before.gt(self.normal * F32x16::splat(simd, at_end as f32));
        are_clear.to_bits() & self.surely
    }
}

/// By how much t of a depth may be off: three operations.
const ROOM_OF_T: f64 = 4.0 * f64::EPSILON;

/// Between which t triangles of a block are met.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct Reach {
    least: [f32; LANES],
    most: [f32; LANES],
    to_middle: f64,
    size: f64,
    over_along: f64,
}

impl Reach {
    #[inline(always)]
    fn t(&self, depth: f32) -> f64 {
        (self.to_middle + f64::from(depth) * self.size) * self.over_along
    }

    /// The least and the most t of one of them.
    #[inline(always)]
    pub(in crate::visibility) fn of(&self, place: usize) -> [f64; 2] {
        let (a, b) = (self.t(self.least[place]), self.t(self.most[place]));
        let (room_a, room_b) = (a.abs() * ROOM_OF_T, b.abs() * ROOM_OF_T);
        if a < b {
            [a - room_a, b + room_b]
        } else {
            [b - room_b, a + room_a]
        }
    }
}
