//! Triangle setup before parallel rays.

use fearless_simd::Simd;

use super::{
    Corners, F32_ROUNDING, FLATTEST, LeafBlock, LeafFrame, OF_NORMAL, SMALLEST, SingleVectors,
    TriangleSetups,
};
use crate::math::{all_three, both};
use crate::simd::{F32x16, Mask32x16};
use crate::visibility::projection::{
    BatchProjection, NEGLIGIBLE, NOISE, POLYNOMIAL_ERROR, RECIPROCAL_DEPTH_LIMIT, Start,
};

/// The units of projections, in sizes of leaf blocks, that are far from the ends of f32.
const UNITS_FIT: std::ops::Range<f64> = 1e-20..1e20;

/// Of the error of a reciprocal depth, over u and the sum of the magnitudes of its terms: their rounding, with
/// the error of s in them. See [`TriangleSetups::set_up_flattened`].
const OF_TERMS: f32 = 12.0;

impl LeafFrame {
    /// The frame of a leaf block seen by parallel rays. [`LeafFrame::reciprocal_depth`] is the projection's
    /// unit in it.
    #[inline(always)]
    fn parallel(projection: &BatchProjection, leaf: &LeafBlock, start: Start) -> Self {
        let frame = Self::new(projection, leaf);
        let [x, y, _] = all_three(frame.middle, f32::abs);
        let [extent_x, extent_y] = projection.extent;
        // The terms of an edge function: what a sample adds, and where x and y of a corner are of these sizes.
        let samples = ((extent_x + extent_y) * frame.reciprocal_depth) as f32;
        let (middle_terms, one_terms) = (x + y, 2.0);
        let from_start = (start.distance + 2.0 * projection.unit) * leaf.over_size;
        Self {
            distance: frame.distance + from_start as f32,
            edge_error: [
                (middle_terms * 18.0 + one_terms * 22.0 + samples * 16.0) / 28.0,
                (middle_terms * 25.0 + one_terms * 40.0 + samples * 22.0) / 28.0,
            ],
            ..frame
        }
    }
}

impl TriangleSetups {
    #[inline(never)]
    pub(in crate::visibility) fn set_up_parallel<S: Simd>(
        &mut self,
        simd: S,
        projection: &mut BatchProjection,
        start: Start,
        leaf: &LeafBlock,
        bits: u32,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.set_up_flattened(simd, projection, start, leaf, bits),
        );
    }

    /// [`TriangleSetups::set_up`] for parallel rays.
    ///
    /// The edge functions are those of the triangle in the plane w · p = k, k the projection's unit, seen from a
    /// point: all corners are at this depth, and the offsets between them are across. Lengths are those in
    /// space, as is the error of offsets, whatever is left of them in that plane. The depth k is
    /// exact but for its rounding, so that the error of a corner is in one term of three only; and a sample is
    /// off by 1 u and the noise of f64, less than from a point. So what is said of edges there holds here.
    ///
    /// With n the normal and s = (n_x, n_y) / n_z, the reciprocal depth at a sample d is s · (d − a/k) − a_z/k. An
    /// error of 16 u of |ab| |ac| in each component of n, and of an eighth in n_z, makes
    /// 20 u |ab| |ac| / |n_z| · (1 + |s|) of s. That counts over the offset of the sample from a, whose own error
    /// counts s times; and all terms are rounded up to ten times, 12 u with the error of s in them.
    #[inline(always)]
    fn set_up_flattened<S: Simd>(
        &mut self,
        simd: S,
        projection: &mut BatchProjection,
        start: Start,
        leaf: &LeafBlock,
        bits: u32,
    ) {
        let frame = LeafFrame::parallel(projection, leaf, start);
        let corners = Corners::new(simd, &frame, projection, leaf);
        let smallest = if UNITS_FIT.contains(&frame.reciprocal_depth) {
            frame.distance * SMALLEST
        } else {
            f32::INFINITY
        };
        let has_size = corners.have_size(simd, smallest);
        let (sides, [least, most]) = boxes_along(simd, projection, &frame, &corners, has_size);
        let [ahead, behind] = both(
            start.reciprocal_depth,
            #[inline(always)]
            |end| F32x16::splat(simd, end),
        );
        self.cut = !ahead.gt(most).to_bits();
        let meets = projection.is_of_interest(simd, sides, most) & least.le(behind);
        if self.place(simd, projection, sides, most, meets.to_bits() & bits) {
            self.set_up_planes_along(simd, projection, &frame, &corners, has_size);
        }
    }

    /// The edge functions and reciprocal depths of triangles seen by parallel rays; which of them can be told,
    /// and which of those may hold a ray.
    #[inline(always)]
    fn set_up_planes_along<S: Simd>(
        &mut self,
        simd: S,
        projection: &BatchProjection,
        frame: &LeafFrame,
        corners: &Corners<S>,
        has_size: Mask32x16<S>,
    ) {
        let splat = |value: f32| F32x16::splat(simd, value);
        let (zero, one) = (splat(0.0), splat(1.0));
        let Corners { a, b, ab, ac, .. } = *corners;
        let [extent_x, extent_y] = both(projection.extent, |extent| extent as f32);
        let extent = [splat(extent_x), splat(extent_y)];
        let bc = ac.minus(ab);
        let normal = ab.cross(ac);
        let edges = corners.ab_size * corners.ac_size;
        let is_clear = has_size & normal.z.abs().gt(edges * splat(FLATTEST));
        let sign = normal.z.gt(zero).select(one, zero - one);
        let unit = splat(frame.reciprocal_depth as f32);
        let in_plane = both(
            [a, b],
            #[inline(always)]
            |corner| SingleVectors { z: unit, ..corner },
        );
        let offsets = [across(ab, zero), across(ac, zero), across(bc, zero)];
        let sizes = [corners.ab_size, corners.ac_size, bc.size(simd)];
        let (are_told, is_met) =
            self.set_up_edges(simd, frame, in_plane, offsets, sizes, sign, extent);

        let over_unit = (1.0 / frame.reciprocal_depth) as f32;
        let scale = splat(over_unit);
        let over = one / normal.z;
        let (x, y) = (normal.x * over, normal.y * over);
        let at_middle = x.times_plus(a.x, y.times_plus(a.y, a.z));
        self.reciprocal_depth.store(SingleVectors {
            x,
            y,
            z: zero - at_middle * scale,
        });
        let [drift_x, drift_y, drift_z] = frame.drift;
        let (slope_x, slope_y) = (x.abs(), y.abs());
        let offset_x = a.x.abs().times_plus(scale, extent[0]);
        let offset_y = a.y.abs().times_plus(scale, extent[1]);
        let flatness = edges * over.abs();
        let of_normal = (slope_x + one) * offset_x + (slope_y + one) * offset_y;
        let of_corner = slope_x.times_plus(
            splat(drift_x),
            slope_y.times_plus(splat(drift_y), splat(drift_z)),
        );
        let of_terms =
            slope_x.times_plus(offset_x, slope_y.times_plus(offset_y, a.z.abs() * scale));
        let rounding = of_normal.times_plus(
            flatness * splat(OF_NORMAL),
            of_corner.times_plus(scale, of_terms * splat(OF_TERMS)),
        );
        // f64 finds the depth from the offset to a corner and the same normal, and samples are no better. What
        // hides an end is further from it than that is off, which is more than its rounding.
        let noise = frame.distance * NOISE + frame.error * NEGLIGIBLE as f32;
        let error = rounding.times_plus(
            splat(F32_ROUNDING),
            flatness * splat(2.0 * noise * over_unit),
        );
        error.store(&mut self.reciprocal_depth_error.0);
        let is_told = is_clear
            & are_told
            & splat(RECIPROCAL_DEPTH_LIMIT as f32).gt(of_terms)
            & splat(RECIPROCAL_DEPTH_LIMIT as f32).gt(error);
        self.untold = !is_told.to_bits();
        self.of_interest &= is_met.to_bits() | self.untold;
    }
}

/// The boxes of triangles seen by parallel rays, left, right, bottom and top, and the ranges of their reciprocal
/// depths: anywhere, for triangles without a size.
///
/// Corners drift and samples are off; numbers are rounded on their way to units of the projection.
#[inline(always)]
fn boxes_along<S: Simd>(
    simd: S,
    projection: &BatchProjection,
    frame: &LeafFrame,
    corners: &Corners<S>,
    has_size: Mask32x16<S>,
) -> ([F32x16<S>; 4], [F32x16<S>; 2]) {
    let splat = |value: f32| F32x16::splat(simd, value);
    let (zero, infinite) = (splat(0.0), splat(f32::INFINITY));
    let Corners { a, b, c, .. } = *corners;
    let [extent_x, extent_y] = both(projection.extent, |extent| extent as f32);
    let over_unit = (1.0 / frame.reciprocal_depth) as f32;
    let scale = splat(over_unit);
    let give = splat(POLYNOMIAL_ERROR);
    let noise = frame.distance * NOISE;
    let room = |drift: f32| splat((drift * F32_ROUNDING + noise) * over_unit);
    let [drift_x, drift_y, drift_z] = frame.drift;
    let room_x = room(drift_x) + splat(extent_x * POLYNOMIAL_ERROR);
    let room_y = room(drift_y) + splat(extent_y * POLYNOMIAL_ERROR);
    let room_z = room(drift_z);
    let left = a.x.min(b.x).min(c.x) * scale;
    let right = a.x.max(b.x).max(c.x) * scale;
    let bottom = a.y.min(b.y).min(c.y) * scale;
    let top = a.y.max(b.y).max(c.y) * scale;
    let most = zero - a.z.min(b.z).min(c.z) * scale;
    let least = zero - a.z.max(b.z).max(c.z) * scale;
    let left = left - left.abs().times_plus(give, room_x);
    let right = right + right.abs().times_plus(give, room_x);
    let bottom = bottom - bottom.abs().times_plus(give, room_y);
    let top = top + top.abs().times_plus(give, room_y);
    let most = most + most.abs().times_plus(give, room_z);
    let least = least - least.abs().times_plus(give, room_z);
    let sides = [
        has_size.select(left, zero - infinite),
        has_size.select(right, infinite),
        has_size.select(bottom, zero - infinite),
        has_size.select(top, infinite),
    ];
    let range = [
        has_size.select(least, zero - infinite),
        has_size.select(most, infinite),
    ];
    (sides, range)
}

/// What is left of an offset across the rays.
#[inline(always)]
fn across<S: Simd>(offset: SingleVectors<S>, zero: F32x16<S>) -> SingleVectors<S> {
    SingleVectors { z: zero, ..offset }
}
