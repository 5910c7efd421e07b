//! Triangle setup: the edge functions of triangles (Pineda 1988, "A Parallel Algorithm for Polygon
//! Rasterization") and their reciprocal depths, as affine functions of a sample.

mod parallel;

use fearless_simd::Simd;

use super::leaf_block::{F32_ROUNDING, LeafBlock, LeafFrame, SingleVectors};
use crate::math::both;
use crate::simd::{F32x16, LANES, Mask32x16, ones};
use crate::visibility::batch::{PACKETS, Row};
use crate::visibility::primitive::ShapeId;
use crate::visibility::projection::{
    Affine, BatchProjection, DepthTest, Extents, Fragments, NEGLIGIBLE, NOISE, POLYNOMIAL_ERROR,
    RECIPROCAL_DEPTH_LIMIT, Shared, State,
};

/// A column of functions, those of triangle after triangle.
#[derive(Clone, Copy, Debug)]
struct Affines([Row; 3]);

impl Affines {
    const NONE: Self = Self([Row([0.0; LANES]); 3]);

    #[inline(always)]
    fn get(&self, index: usize) -> Affine {
        let [constant, x, y] = &self.0;
        Affine([constant.0[index], x.0[index], y.0[index]])
    }

    #[inline(always)]
    fn load<S: Simd>(&self, simd: S) -> SingleVectors<S> {
        let [constant, x, y] = &self.0;
        SingleVectors {
            x: F32x16::load(simd, &x.0),
            y: F32x16::load(simd, &y.0),
            z: F32x16::load(simd, &constant.0),
        }
    }

    #[inline(always)]
    fn store<S: Simd>(&mut self, c: SingleVectors<S>) {
        let [constant, x, y] = &mut self.0;
        c.z.store(&mut constant.0);
        c.x.store(&mut x.0);
        c.y.store(&mut y.0);
    }
}

/// The bound on the error of an edge function, over the length of the edge times [`LeafFrame::edge_error`]: see
/// [`TriangleSetups::set_up`]. Samples that are nearer to an edge are ambiguous.
pub(in crate::visibility) const EDGE_FUNCTION_ERROR: f32 = 1.0 / (1 << 19) as f32;

/// Six products of the sizes of a triangle's offsets and its distance must be larger than this part of
/// them together, or its reciprocal depth may be off by more than a sixth.
const FLATTEST: f32 = 1.0 / (1 << 17) as f32;

/// Corners at a depth below this part of their distance are not clearly before a projection's origin.
const NEAREST: f32 = 1.0 / (1 << 17) as f32;

/// A triangle smaller than this part of its distance has corners that rounding puts in one place: 2⁹ times
/// what an f64 may be off.
const SMALLEST: f32 = 1.0 / (1_u64 << 44) as f32;

/// Of the error of a reciprocal depth, over u and the flatness of the triangle: what that of V makes, over the
/// distance, and what that of n makes. See [`TriangleSetups::set_up_planes`].
const OF_VOLUME: f32 = 26.0;
const OF_NORMAL: f32 = 20.0;

/// What the factors k and 1/V, the products, the sums and the sample make of it, over u.
const OF_FACTORS: f32 = 16.0;

/// Sixteen triangles in the frame of their leaf block.
#[derive(Clone, Copy)]
struct Corners<S: Simd> {
    a: SingleVectors<S>,
    b: SingleVectors<S>,
    c: SingleVectors<S>,
    ab: SingleVectors<S>,
    ac: SingleVectors<S>,
    /// About the lengths of ab and ac.
    ab_size: F32x16<S>,
    ac_size: F32x16<S>,
}

impl<S: Simd> Corners<S> {
    #[inline(always)]
    fn new(simd: S, frame: &LeafFrame, projection: &BatchProjection, leaf: &LeafBlock) -> Self {
        let [a, ab, ac] = frame.offsets(simd, projection, leaf);
        Self {
            a,
            b: a.plus(ab),
            c: a.plus(ac),
            ab,
            ac,
            ab_size: ab.size(simd),
            ac_size: ac.size(simd),
        }
    }

    /// Which are larger than this. Corners that are one and the same as far as the rounding of their offset can
    /// tell are anywhere.
    #[inline(always)]
    fn have_size(&self, simd: S, smallest: f32) -> Mask32x16<S> {
        let size = self.ab_size.min(self.ac_size);
        size.gt(F32x16::splat(simd, smallest))
    }
}

/// The reciprocal depths of triangles, as affine functions of a sample.
#[derive(Clone, Copy)]
struct Planes<S: Simd> {
    reciprocal_depth: SingleVectors<S>,
    /// The sum of the magnitudes of its terms.
    magnitude: F32x16<S>,
    error: F32x16<S>,
    /// Whether the triangle can be told from f32.
    is_told: Mask32x16<S>,
}

/// The boxes of triangles seen from a point, left, right, bottom and top, and the largest of their reciprocal
/// depths: anywhere, where not all corners are clearly before the projection's origin.
///
/// Corners drift, across and along; samples are off by 5 u, and divisions by 2 u.
#[inline(always)]
fn boxes_from_point<S: Simd>(
    simd: S,
    projection: &BatchProjection,
    frame: &LeafFrame,
    corners: &Corners<S>,
    has_size: Mask32x16<S>,
) -> ([F32x16<S>; 4], F32x16<S>) {
    let Corners { a, b, c, .. } = *corners;
    let one = F32x16::splat(simd, 1.0);
    let zero = F32x16::splat(simd, 0.0);
    let infinite = F32x16::splat(simd, f32::INFINITY);
    let [extent_x, extent_y] = both(projection.extent, |extent| extent as f32);
    let nearest = a.z.min(b.z).min(c.z);
    let has_reciprocal_depth =
        (1.0 / RECIPROCAL_DEPTH_LIMIT..RECIPROCAL_DEPTH_LIMIT).contains(&frame.reciprocal_depth);
    let nearest_told = if has_reciprocal_depth {
        frame.distance * NEAREST
    } else {
        f32::INFINITY
    };
    let is_before = has_size & nearest.gt(F32x16::splat(simd, nearest_told));
    let (in_a, in_b, in_c) = (one / a.z, one / b.z, one / c.z);
    let inverse = in_a.max(in_b).max(in_c);
    let [drift_x, drift_y, drift_z] = frame.drift;
    let give = F32x16::splat(simd, POLYNOMIAL_ERROR);
    let slope = inverse.times_plus(F32x16::splat(simd, drift_z * F32_ROUNDING), give);
    let noise = frame.distance * NOISE;
    let room_x = inverse.times_plus(
        F32x16::splat(simd, drift_x * F32_ROUNDING + noise),
        F32x16::splat(simd, extent_x * POLYNOMIAL_ERROR),
    );
    let room_y = inverse.times_plus(
        F32x16::splat(simd, drift_y * F32_ROUNDING + noise),
        F32x16::splat(simd, extent_y * POLYNOMIAL_ERROR),
    );
    let (ax, bx, cx) = (a.x * in_a, b.x * in_b, c.x * in_c);
    let (ay, by, cy) = (a.y * in_a, b.y * in_b, c.y * in_c);
    let (left, right) = (ax.min(bx).min(cx), ax.max(bx).max(cx));
    let (bottom, top) = (ay.min(by).min(cy), ay.max(by).max(cy));
    let left = left - left.abs().times_plus(slope, room_x);
    let right = right + right.abs().times_plus(slope, room_x);
    let bottom = bottom - bottom.abs().times_plus(slope, room_y);
    let top = top + top.abs().times_plus(slope, room_y);
    let to_reciprocal_depth = F32x16::splat(simd, frame.reciprocal_depth as f32);
    let most = inverse * to_reciprocal_depth * (one + slope);
    let sides = [
        is_before.select(left, zero - infinite),
        is_before.select(right, infinite),
        is_before.select(bottom, zero - infinite),
        is_before.select(top, infinite),
    ];
    (sides, is_before.select(most, infinite))
}

/// The setup of sixteen triangles.
#[derive(Clone, Debug)]
pub(in crate::visibility) struct TriangleSetups {
    /// Positive inside, and over the sum of the magnitudes of its terms.
    edges: [Affines; 3],
    reciprocal_depth: Affines,
    /// How far the reciprocal depth may be off.
    reciprocal_depth_error: Row,
    pub(in crate::visibility) extents: Extents,
    /// One bit for each packet that a triangle may be of interest to.
    packets: [u32; LANES],
    /// One bit for each triangle that may be of interest to any ray.
    pub(in crate::visibility) of_interest: u32,
    /// One bit for each that cannot be told from f32.
    untold: u32,
    /// One bit for each that may reach behind where parallel rays start.
    cut: u32,
}

impl Default for TriangleSetups {
    fn default() -> Self {
        let row = Row([0.0; LANES]);
        Self {
            edges: [Affines::NONE; 3],
            reciprocal_depth: Affines::NONE,
            reciprocal_depth_error: row,
            extents: Extents::default(),
            packets: [0; LANES],
            of_interest: 0,
            untold: 0,
            cut: 0,
        }
    }
}

impl TriangleSetups {
    /// Sets up the triangles of a leaf block with a bit.
    ///
    /// All is in units of the leaf block's size. With u = 2⁻²⁴, m the middle and ℓ the length of an offset:
    /// an offset is stored with an error of u in each component, and turned by three products and sums with
    /// axes rounded to f32, so that it is off by 5 u ℓ; so is the offset from the middle to the first corner a,
    /// with ℓ ≤ 1. Adding m, rounded to f32 by itself, makes u (2 |m| + 6) for each component of a, and
    /// u (3 |m| + 18) for b and c. The offset from b to c is the longest one, and off by 11 u of its length.
    ///
    /// In an edge function p × e no term is larger than ℓ (|m| + 1) for e. Of that it is off by 5 u or
    /// 11 u for e, by 2 u for the products, 1 u for the factor, 3 u for its sum, and 5 u for x and y of a
    /// sample; and by ℓ times the error of p. That is 28 u of [`LeafFrame::edge_error`]; the offsets in f64, which
    /// move a whole edge, are worth another 4 u of it: [`EDGE_FUNCTION_ERROR`].
    #[inline(always)]
    pub(in crate::visibility) fn set_up<S: Simd>(
        &mut self,
        simd: S,
        projection: &mut BatchProjection,
        leaf: &LeafBlock,
        bits: u32,
    ) {
        if let Shared::Direction(start) = projection.shared {
            self.set_up_parallel(simd, projection, start, leaf, bits);
            return;
        }
        self.cut = 0;
        let frame = LeafFrame::new(projection, leaf);
        let corners = Corners::new(simd, &frame, projection, leaf);
        let has_size = corners.have_size(simd, frame.distance * SMALLEST);
        let (sides, most) = boxes_from_point(simd, projection, &frame, &corners, has_size);
        let meets = projection.is_of_interest(simd, sides, most);
        if !self.place(simd, projection, sides, most, meets.to_bits() & bits) {
            return;
        }
        let extent = both(
            projection.extent,
            #[inline(always)]
            |extent| F32x16::splat(simd, extent as f32),
        );
        let planes = self.set_up_planes(simd, projection, &frame, &corners, has_size, extent);
        self.extents.covers = 0;
        if projection.state == State::Bounded {
            self.cover(simd, planes, most, extent);
        }
    }

    /// The edge functions and reciprocal depths of triangles seen from a point; which of them can be told, and
    /// which of those may hold a ray.
    ///
    /// Twice the areas that the edges span with the origin, as vectors, are the edge functions: of a corner and
    /// an edge, not of two corners, the products of which would cancel.
    ///
    /// The normal is off by 16 u of the product of its edges in each component, and the volume V by 21 u of that
    /// and the distance. Errors of a sliver's normal and of a grazing view multiply: [`FLATTEST`]. The reciprocal
    /// depth is k (n · d) / V: an error of a sixth in V makes 20 u of 16 u, and 26 u of 21 u.
    #[inline(always)]
    fn set_up_planes<S: Simd>(
        &mut self,
        simd: S,
        projection: &BatchProjection,
        frame: &LeafFrame,
        corners: &Corners<S>,
        has_size: Mask32x16<S>,
        extent: [F32x16<S>; 2],
    ) -> Planes<S> {
        let Corners { a, b, ab, ac, .. } = *corners;
        let one = F32x16::splat(simd, 1.0);
        let zero = F32x16::splat(simd, 0.0);
        let to_reciprocal_depth = F32x16::splat(simd, frame.reciprocal_depth as f32);
        let bc = ac.minus(ab);
        let sizes = [corners.ab_size, corners.ac_size, bc.size(simd)];
        let normal = ab.cross(ac);
        let volume = a.dot(normal);
        let edges = corners.ab_size * corners.ac_size;
        let is_clear = has_size
            & volume
                .abs()
                .gt(edges * F32x16::splat(simd, frame.distance * FLATTEST + frame.error));
        let sign = volume.gt(zero).select(one, zero - one);
        let (are_told, is_met) =
            self.set_up_edges(simd, frame, [a, b], [ab, ac, bc], sizes, sign, extent);
        let over_volume = one / volume;
        let reciprocal_depth = normal.times(to_reciprocal_depth * over_volume);
        let magnitude = reciprocal_depth.magnitude(extent);
        let is_told = is_clear
            & are_told
            & magnitude.gt(F32x16::splat(simd, (1.0 / RECIPROCAL_DEPTH_LIMIT) as f32))
            & magnitude.le(F32x16::splat(simd, RECIPROCAL_DEPTH_LIMIT as f32));
        self.reciprocal_depth.store(reciprocal_depth);
        let [extent_x, extent_y] = both(projection.extent, |extent| extent as f32);
        let flatness = edges * F32x16::splat(simd, F32_ROUNDING) * over_volume.abs();
        let of_volume = flatness.times_plus(
            F32x16::splat(simd, frame.distance * OF_VOLUME),
            F32x16::splat(simd, F32_ROUNDING * OF_FACTORS),
        );
        let of_normal = flatness
            * to_reciprocal_depth
            * F32x16::splat(simd, (1.0 + extent_x + extent_y) * OF_NORMAL);
        let error = magnitude.times_plus(of_volume, of_normal);
        error.store(&mut self.reciprocal_depth_error.0);
        self.untold = !is_told.to_bits();
        self.of_interest &= is_met.to_bits() | self.untold;
        Planes {
            reciprocal_depth,
            magnitude,
            error,
            is_told,
        }
    }

    /// Which triangles all rays of a bounded projection meet, and the ranges of their reciprocal depths, of
    /// which none is above `most`.
    #[inline(always)]
    fn cover<S: Simd>(
        &mut self,
        simd: S,
        planes: Planes<S>,
        most: F32x16<S>,
        extent: [F32x16<S>; 2],
    ) {
        let Planes {
            reciprocal_depth,
            magnitude,
            error,
            is_told,
        } = planes;
        // Twice the room: for the three sums of the least of an affine function.
        let inside = F32x16::splat(simd, 2.0 * EDGE_FUNCTION_ERROR);
        let [edge_a, edge_b, edge_c] = &self.edges;
        let give = error + magnitude * F32x16::splat(simd, 2.0 * POLYNOMIAL_ERROR);
        let least = reciprocal_depth.smallest(extent) - give;
        let covers = edge_a.load(simd).smallest(extent).gt(inside)
            & edge_b.load(simd).smallest(extent).gt(inside)
            & edge_c.load(simd).smallest(extent).gt(inside)
            & least.gt(F32x16::splat(simd, 0.0));
        let largest = (reciprocal_depth.largest(extent) + give).min(most);
        let range = [least, is_told.select(largest, most)];
        self.extents
            .cover_with(covers.to_bits() & is_told.to_bits(), range);
    }

    /// Keeps the boxes of triangles, and which of those with a bit hold any ray; whether there are such.
    #[inline(always)]
    fn place<S: Simd>(
        &mut self,
        simd: S,
        projection: &mut BatchProjection,
        boxes: [F32x16<S>; 4],
        most: F32x16<S>,
        bits: u32,
    ) -> bool {
        self.of_interest = bits;
        if bits == 0 {
            return false;
        }
        if let Some(grid) = projection.sample_grid(simd, self.of_interest.count_ones()) {
            let places = grid.places(simd, boxes);
            for place in ones(self.of_interest) {
                let packets = grid.packets(&places, place);
                self.packets[place] = packets;
                self.of_interest &= !(u32::from(packets == 0) << place);
            }
            if self.of_interest == 0 {
                return false;
            }
        } else {
            self.packets = [u32::MAX; LANES];
        }
        self.extents.store(boxes, most);
        true
    }

    /// The edge functions, of which `sign` makes those positive whose triangles turn the other way: by the
    /// first two corners, the offsets ab, ac and bc, and their sizes. Which can be told, and which
    /// may hold a ray of this extent.
    #[inline(always)]
    #[expect(
        clippy::too_many_arguments,
        reason = "what both kinds of projection know of triangles"
    )]
    fn set_up_edges<S: Simd>(
        &mut self,
        simd: S,
        frame: &LeafFrame,
        [a, b]: [SingleVectors<S>; 2],
        [ab, ac, bc]: [SingleVectors<S>; 3],
        [ab_size, ac_size, bc_size]: [F32x16<S>; 3],
        sign: F32x16<S>,
        extent: [F32x16<S>; 2],
    ) -> (Mask32x16<S>, Mask32x16<S>) {
        let edges = ab_size * ac_size;
        // Of the longest edge, opposite of the first corner: the rounding of the offset to a corner moves all.
        let rounding = bc_size * F32x16::splat(simd, frame.distance * NEGLIGIBLE as f32);
        let [beside_first, opposite_first] = frame.edge_error;
        let shortest = ab_size.min(ac_size).min(bc_size);
        let are_told = (shortest * F32x16::splat(simd, beside_first)).gt(rounding);
        // The reciprocals of the three lengths from one division: none is below 2⁻⁴².
        let scale = sign / (edges * bc_size);
        let beside = scale * bc_size * F32x16::splat(simd, 1.0 / beside_first);
        let opposite = scale * edges * F32x16::splat(simd, 1.0 / opposite_first);
        let [opposite_a, opposite_b, opposite_c] = &mut self.edges;
        let edge_a = b.cross(bc).times(opposite);
        let edge_b = ac.cross(a).times(beside * ab_size);
        let edge_c = a.cross(ab).times(beside * ac_size);
        opposite_a.store(edge_a);
        opposite_b.store(edge_b);
        opposite_c.store(edge_c);
        // One edge may have all rays on its outer side. Twice the room: for the three sums of this.
        let outside = F32x16::splat(simd, -2.0 * EDGE_FUNCTION_ERROR);
        let is_met = edge_a.largest(extent).gt(outside)
            & edge_b.largest(extent).gt(outside)
            & edge_c.largest(extent).gt(outside);
        (are_told, is_met)
    }

    /// Rasterizes the triangles with a bit; `id` says which they are.
    #[inline(always)]
    pub(in crate::visibility) fn rasterize<S: Simd>(
        &self,
        simd: S,
        triangles: u32,
        id: impl Fn(usize) -> ShapeId,
        projection: &mut BatchProjection,
        depth_test: impl DepthTest,
    ) {
        // A triangle has to do with one packet or with a few, and with none of the rays of every other:
        // a branch on each would mostly be mispredicted. So first all pairs are told that may be of interest.
        let mut near = [0_u64; PAIRS / 64];
        for triangle in ones(triangles) {
            let packets =
                projection.meets(simd, &self.extents.get(triangle)) & self.packets[triangle];
            if self.untold >> triangle & 1 == 1 {
                for packet in ones(packets) {
                    depth_test.leave_unresolved(simd, projection, packet, id(triangle));
                }
            } else {
                let first = triangle * PACKETS;
                near[first / 64] |= u64::from(packets) << (first % 64);
            }
        }
        let tested = near.iter().map(|pairs| u64::from(pairs.count_ones()));
        depth_test.work(&mut projection.work).pairs += tested.sum::<u64>();
        let mut pairs = [0; PAIRS];
        let mut count = 0;
        for (first, mut bits) in (0..).step_by(64).zip(near) {
            while bits != 0 {
                let pair = first + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                let packet = pair % PACKETS;
                let fragments = self.fragments(simd, projection, pair / PACKETS, packet);
                let is_of_interest =
                    fragments.may_cover & projection.concerns(simd, packet, fragments.most);
                pairs[count] = pair as u8;
                count += usize::from(is_of_interest.to_bits() != 0);
            }
        }
        for &pair in &pairs[..count] {
            let (triangle, packet) = (usize::from(pair) / PACKETS, usize::from(pair) % PACKETS);
            let fragments = self.fragments(simd, projection, triangle, packet);
            depth_test.resolve(simd, projection, packet, id(triangle), fragments);
        }
    }

    /// What a triangle says of the rays of a packet.
    #[inline(always)]
    fn fragments<S: Simd>(
        &self,
        simd: S,
        projection: &BatchProjection,
        triangle: usize,
        packet: usize,
    ) -> Fragments<S> {
        let samples = projection.samples(simd, packet);
        let [a, b, c] = &self.edges;
        let inside = a.get(triangle).at(simd, samples);
        let inside = inside.min(b.get(triangle).at(simd, samples));
        let inside = inside.min(c.get(triangle).at(simd, samples));
        let reciprocal_depth = self.reciprocal_depth.get(triangle).at(simd, samples);
        let error = F32x16::splat(simd, self.reciprocal_depth_error.0[triangle]);
        let fragments = Fragments {
            may_cover: inside.ge(F32x16::splat(simd, -EDGE_FUNCTION_ERROR)),
            covered: inside.gt(F32x16::splat(simd, EDGE_FUNCTION_ERROR)),
            least: reciprocal_depth - error,
            most: reciprocal_depth + error,
        };
        if self.cut >> triangle & 1 == 1 {
            projection.ahead(simd, fragments)
        } else {
            fragments
        }
    }
}

/// Triangles of a leaf and packets of a batch: one fits a byte.
const PAIRS: usize = LANES * PACKETS;
const _: () = assert!(PAIRS == 1 << u8::BITS);
