//! Projections before rays of one direction: those of an orthographic camera, and the light of a sun.
//!
//! Such rays share a point that is infinitely far away. On the projection across them a sample is where a ray
//! starts, in units of the batch's size, and all that is true of shapes seen from a point is true here of
//! shapes as w flattens them. Depth does not shrink with distance, though: a plane's is affine in x and y
//! itself, not its reciprocal. So what stands for the reciprocal depth is minus the depth, which may have
//! either sign, from a point amid the shapes, as f32 has the most digits near 0; and what is behind the start
//! of the rays has to be told.
//!
//! The light of a sun comes the same way, from infinitely far away: nothing is behind its start, and what rays
//! end on takes the part of what they meet.

use fearless_simd::Simd;

use super::fragments::Fragments;
use super::{BatchProjection, NARROWEST, Shared, Start, State};
use crate::math::{DVec3, both};
use crate::simd::{DVec3x16, F32x16, F64x16, LANES, Mask32x16, smallest_of_each};
use crate::visibility::batch::{Column, PACKETS, offsets, ranges};
use crate::visibility::tree::{Beam, Tree};

/// Units of projections below this have no reciprocal in f64, or none to speak of.
const SMALLEST_UNIT: f64 = 1e-290;

/// How far the reciprocal depth of the start is off, over the sum of it and 2, the batch's size: one rounding
/// to f32, 2⁻²⁴, and as much again.
const START_ERROR: f64 = 1.0 / (1 << 23) as f64;

/// How far along the direction starts are from their plane by rounding, over the largest coordinates: a scalar
/// product of differences, six roundings of ε/2 of numbers up to three times those, and less than as much again for room.
const COORDINATE_ROUNDING: f64 = 16.0 * f64::EPSILON;

/// How far the reciprocal depth of an end is off, over its size: one rounding to f32, 2⁻²⁴, and as much again.
const END_ERROR: f32 = 1.0 / (1 << 23) as f32;

/// How far it is off besides, over how far ends are from the origin, in units: an offset and its scalar product in
/// f64, six roundings of ε/2 = 2⁻⁵³ of up to twice that distance, and more than as much again for room.
const END_NOISE: f32 = 1.0 / (1_u64 << 48) as f32;

impl BatchProjection {
    /// Projects rays of one direction, those with a bit, that start on the plane across it
    /// through `eye`; `amid` is a point amid the shapes.
    #[inline(always)]
    pub(in crate::visibility) fn project_along<S: Simd>(
        &mut self,
        simd: S,
        eye: DVec3,
        direction: DVec3,
        amid: DVec3,
        asked: &[u32; PACKETS],
        start: impl Fn(usize) -> DVec3x16<S>,
    ) {
        (self.error, self.ends) = (0.0, None);
        self.state = State::Unfit;
        let range = ranges(
            simd,
            #[inline(always)]
            |packet| asked[packet],
            &start,
        );
        let Some([least, most]) = range else {
            return;
        };
        // Rays that are not spread evenly have the middle of their box beside the plane that they start on.
        let middle = least * 0.5 + most * 0.5;
        let middle = middle + direction * direction.dot(eye - middle);
        let unit = (most - least).max_element();
        let depth = direction.dot(amid - middle);
        // As with tangents: from further away, f64 places shapes no better than the rays are apart.
        let is_fit = unit > depth.abs() * f64::from(NARROWEST)
            && (SMALLEST_UNIT..1.0 / SMALLEST_UNIT).contains(&unit);
        if !is_fit || !self.orient_to(middle + direction * depth, direction) {
            return;
        }
        self.unit = unit;
        let reciprocal_depth = depth / unit;
        // The rounding of coordinates moves a start along w as well.
        let coordinates = least.abs().max(most.abs()).max_element() + eye.abs().max_element();
        let room =
            (reciprocal_depth.abs() + 2.0) * START_ERROR + coordinates / unit * COORDINATE_ROUNDING;
        self.shared = Shared::Direction(Start {
            depth: -depth,
            reciprocal_depth: [
                (reciprocal_depth - room) as f32,
                (reciprocal_depth + room) as f32,
            ],
            distance: depth.abs(),
        });
        // The same samples are those of rays from a point one unit behind the starts, all in one plane.
        let [.., w] = self.axes;
        let one_unit = F64x16::splat(simd, unit);
        self.project_over(
            simd,
            1.0 / unit,
            asked,
            #[inline(always)]
            |packet| {
                let beside = start(packet).minus(middle);
                let ahead = one_unit - beside.dot_with(w);
                beside + DVec3x16::splat(simd, w).times(ahead)
            },
        );
    }

    /// Orients the projection along the light of a sun, for groups of its ends; whether that is a direction.
    pub(in crate::visibility) fn orient_along(&mut self, middle: DVec3, direction: DVec3) -> bool {
        self.ends = None;
        self.state = State::Unfit;
        self.orient_to(middle, direction)
    }

    /// Vectors in the axes of the projection.
    #[inline(always)]
    pub(in crate::visibility) fn turned<S: Simd>(&self, vectors: DVec3x16<S>) -> DVec3x16<S> {
        let [u, v, w] = self.axes;
        DVec3x16 {
            x: vectors.dot_with(u),
            y: vectors.dot_with(v),
            z: vectors.dot_with(w),
        }
    }

    /// Projects the light of a sun along which it is oriented, to the ends with a bit, which are between these in
    /// its axes from `middle`.
    #[inline(never)]
    pub(in crate::visibility) fn project_to_ends<S: Simd>(
        &mut self,
        simd: S,
        asked: &[u32; PACKETS],
        ends: &[Column; 3],
        middle: DVec3,
        range: [DVec3; 2],
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.project_ends_along(simd, asked, ends, middle, range),
        );
    }

    #[inline(always)]
    fn project_ends_along<S: Simd>(
        &mut self,
        simd: S,
        asked: &[u32; PACKETS],
        ends: &[Column; 3],
        middle: DVec3,
        [least, most]: [DVec3; 2],
    ) {
        self.state = State::Unfit;
        let unit = (most.x - least.x).max(most.y - least.y);
        let distance = most.z - least.z;
        // As with the starts of a camera's rays.
        let is_fit = unit > distance * f64::from(NARROWEST)
            && (SMALLEST_UNIT..1.0 / SMALLEST_UNIT).contains(&unit);
        if !is_fit {
            return;
        }
        let [u, v, w] = self.axes;
        let place = least * 0.5 + most * 0.5;
        let origin = middle + (u * place.x + v * place.y + w * place.z);
        self.origin = origin;
        self.unit = unit;
        self.shared = Shared::Direction(Start::endless(distance));
        // The same samples are those of rays from a point one unit before the ends, all in one plane.
        let one_unit = F64x16::splat(simd, unit);
        self.project_over(
            simd,
            1.0 / unit,
            asked,
            #[inline(always)]
            |packet| {
                let beside = offsets(simd, ends, packet, origin);
                let ahead = one_unit - beside.dot_with(w);
                beside + DVec3x16::splat(simd, w).times(ahead)
            },
        );
        let infinite = F32x16::splat(simd, f32::INFINITY);
        let give = F32x16::splat(simd, END_ERROR);
        let noise = F32x16::splat(simd, (distance / unit + 2.0) as f32 * END_NOISE);
        let mut far = [infinite; PACKETS];
        for packet in 0..PACKETS {
            let bits = asked[packet];
            if bits == 0 {
                continue;
            }
            let first = packet * LANES;
            let is_asked = Mask32x16::from_bits(simd, bits);
            let depth = offsets(simd, ends, packet, origin).dot_with(w);
            let reciprocal_depth = (depth * (-1.0 / unit)).narrowed(simd);
            let room = reciprocal_depth.abs().times_plus(give, noise);
            far[packet] = is_asked.select(reciprocal_depth - room, infinite);
            far[packet].store(&mut self.least.0[first..]);
            let most = is_asked.select(reciprocal_depth + room, infinite);
            most.store(&mut self.most.0[first..]);
        }
        let far = smallest_of_each(far);
        far.store(&mut self.far.0);
        self.farthest = far.smallest();
    }

    /// The median of how wide or high the packets are that are more than a point, in lengths of the world; infinite
    /// if there are none.
    pub(in crate::visibility) fn median_width(&self) -> f64 {
        let mut widths = [0.0; PACKETS];
        let mut count = 0;
        let [left, right, bottom, top] = &self.boxes;
        for packet in 0..PACKETS {
            let width = right.0[packet] - left.0[packet];
            let height = top.0[packet] - bottom.0[packet];
            widths[count] = width.max(height);
            count += usize::from(widths[count] > 0.0);
        }
        let widths = &mut widths[..count];
        if widths.is_empty() {
            return f64::INFINITY;
        }
        let (_, &mut median, _) = widths.select_nth_unstable_by(count / 2, f32::total_cmp);
        f64::from(median) * self.unit
    }

    /// The rays with a bit in two groups, parted in the middle of where they are widest or highest, if that is
    /// more than `most` in lengths of the world.
    #[inline(always)]
    pub(in crate::visibility) fn halves<S: Simd>(
        &self,
        simd: S,
        asked: &[u32; PACKETS],
        most: f64,
    ) -> Option<[[u32; PACKETS]; 2]> {
        let [left, right, bottom, top] = self.bounds;
        let (width, height) = (right - left, top - bottom);
        if f64::from(width.max(height)) * self.unit <= most {
            return None;
        }
        let (places, middle) = if width > height {
            (&self.x, left * 0.5 + right * 0.5)
        } else {
            (&self.y, bottom * 0.5 + top * 0.5)
        };
        let middle = F32x16::splat(simd, middle);
        let mut halves = [[0; PACKETS]; 2];
        for (packet, &bits) in asked.iter().enumerate() {
            let place = F32x16::load(simd, &places.0[packet * LANES..]);
            let upper = bits & place.gt(middle).to_bits();
            halves[0][packet] = bits & !upper;
            halves[1][packet] = upper;
        }
        let [lower, upper] = &halves;
        (*lower != [0; PACKETS] && *upper != [0; PACKETS]).then_some(halves)
    }

    /// The reciprocal depth of what is infinitely far away.
    pub(in crate::visibility) fn endless(&self) -> f32 {
        match self.shared {
            Shared::Point => 0.0,
            Shared::Direction(_) => f32::NEG_INFINITY,
        }
    }

    /// What a tree's nodes have to meet to hold anything of interest to the rays.
    #[inline(always)]
    pub(in crate::visibility) fn beam(&self, tree: &Tree) -> Beam {
        let rectangle = self.rectangle();
        match self.shared {
            Shared::Point => Beam::from_point(tree, self.origin, self.axes, rectangle, self.error),
            Shared::Direction(start) => {
                let rectangle = [
                    rectangle[0] * self.unit,
                    rectangle[1] * self.unit,
                    rectangle[2] * self.unit,
                    rectangle[3] * self.unit,
                ];
                let Start {
                    depth, distance, ..
                } = start;
                let (origin, axes, error) = (self.origin, self.axes, self.error);
                let beam = Beam::along(tree, origin, axes, rectangle, [depth, distance], error);
                if start.is_endless() {
                    beam.without_start()
                } else {
                    beam
                }
            }
        }
    }

    /// What is left of fragments, as rays meet only what is ahead of their start.
    #[inline(always)]
    pub(in crate::visibility) fn ahead<S: Simd>(
        &self,
        simd: S,
        fragments: Fragments<S>,
    ) -> Fragments<S> {
        let Shared::Direction(Start {
            reciprocal_depth, ..
        }) = self.shared
        else {
            return fragments;
        };
        let [ahead, behind] = both(reciprocal_depth, |reciprocal_depth| {
            F32x16::splat(simd, reciprocal_depth)
        });
        Fragments {
            may_cover: fragments.may_cover & fragments.least.le(behind),
            covered: fragments.covered & ahead.gt(fragments.most),
            least: fragments.least,
            most: fragments.most.min(behind),
        }
    }

    /// What is left of the fragments of a sphere, which rays that start within it meet at the second crossing of
    /// their line. That may be off by `error`, and by `edge_error` more where it is not sure.
    #[inline(always)]
    pub(in crate::visibility) fn first_ahead<S: Simd>(
        &self,
        simd: S,
        fragments: Fragments<S>,
        second: F32x16<S>,
        [error, edge_error]: [F32x16<S>; 2],
    ) -> Fragments<S> {
        let Shared::Direction(Start {
            reciprocal_depth, ..
        }) = self.shared
        else {
            return fragments;
        };
        let [ahead, behind] = both(reciprocal_depth, |reciprocal_depth| {
            F32x16::splat(simd, reciprocal_depth)
        });
        let (least, most) = (second - error, second + error);
        let is_first = fragments.covered & ahead.gt(fragments.most);
        let is_second = fragments.covered & fragments.least.gt(behind) & ahead.gt(most);
        Fragments {
            may_cover: fragments.may_cover & (least - edge_error).le(behind),
            covered: is_first | is_second,
            least: is_second.select(least, fragments.least),
            most: is_second.select(most, fragments.most.min(behind)),
        }
    }
}
