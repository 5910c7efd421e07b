//! Projections before rays of one direction: those of an orthographic camera.
//!
//! Such rays share a point that is infinitely far away. On the projection across them a sample is where a ray
//! starts, in units of the batch's size, and all that is true of shapes seen from a point is true here of
//! shapes as w flattens them. Depth does not shrink with distance, though: a plane's is affine in x and y
//! itself, not its reciprocal. So what stands for the reciprocal depth is minus the depth, which may have
//! either sign, from a point amid the shapes, as f32 has the most digits near 0; and what is behind the start
//! of the rays has to be told.

use fearless_simd::Simd;

use super::fragments::Fragments;
use super::{BatchProjection, NARROWEST, Shared, Start, State};
use crate::math::{DVec3, both};
use crate::simd::{DVec3x16, F32x16, F64x16};
use crate::visibility::batch::{PACKETS, ranges};
use crate::visibility::tree::{Beam, Tree};

/// Units of projections below this have no reciprocal in f64, or none to speak of.
const SMALLEST_UNIT: f64 = 1e-290;

/// How far the reciprocal depth of the start is off, over the sum of it and 2, the batch's size: one rounding
/// to f32, 2⁻²⁴, and as much again.
const START_ERROR: f64 = 1.0 / (1 << 23) as f64;

/// How far along the direction starts are from their plane by rounding, over the largest coordinates: a scalar
/// product of differences, six roundings of ε/2 of numbers up to three times those, and less than as much again for room.
const COORDINATE_ROUNDING: f64 = 16.0 * f64::EPSILON;

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
                Beam::along(tree, self.origin, self.axes, rectangle, start.depth)
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
