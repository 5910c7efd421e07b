//! L4 for the light of a sun: parallel segments, before which all shapes are as they are before the rays of an
//! orthographic camera.
//!
//! What a projection along the light leaves open is put to f64 segment by segment, from the points on: that is how
//! all of it is answered where there is no projection, to the same bits.

use fearless_simd::Simd;

use super::FEW;
use crate::math::{DVec3, Direction, Point, all_three};
use crate::visibility::batch::{PACKETS, offsets, ranges};
use crate::visibility::points::Points;
use crate::visibility::projection::{OcclusionTest, State};
use crate::visibility::{Visibility, Workspace};

/// Points that are spread, across the light, over more than so many times what a packet mostly is are not projected
/// together: at a silhouette, all between the object and what is far behind it would be. Packets of
/// a batch are four times four, so that those of a smooth surface stay together.
const MOST_SPREAD: f64 = 8.0;

impl Visibility<'_> {
    /// L4: which of the points with a bit in `facing` the light of a sun reaches. `light` is so far away in its
    /// direction that segments there are parallel to the last digit.
    #[inline(never)]
    pub(in crate::visibility) fn free_to_sun<S: Simd>(
        &self,
        simd: S,
        light: Point,
        to_light: Direction,
        points: &Points,
        facing: &[u32; PACKETS],
        space: &mut Workspace,
    ) -> [u32; PACKETS] {
        let (mut lit, mut unknown) = ([0; PACKETS], *facing);
        if self.uses_projection {
            simd.vectorize(
                #[inline(always)]
                || {
                    let answer = [&mut lit, &mut unknown];
                    self.project_sun(simd, light, to_light, points, answer, space);
                },
            );
        }
        let mut count = 0;
        for bits in unknown {
            count += bits.count_ones();
        }
        if count > 0 {
            space.projection.work.shadow.fallbacks += u64::from(count);
            let free = self.free_to_far_point(simd, light, points, &unknown, space);
            for (lit, free) in lit.iter_mut().zip(free) {
                *lit |= free;
            }
        }
        lit
    }

    /// Takes from the points that it is unknown of those that projections decide, and those of them that are lit.
    #[inline(always)]
    fn project_sun<S: Simd>(
        &self,
        simd: S,
        light: Point,
        to_light: Direction,
        points: &Points,
        [lit, unknown]: [&mut [u32; PACKETS]; 2],
        space: &mut Workspace,
    ) {
        let Workspace {
            projection,
            setups,
            stack,
            groups,
            ..
        } = space;
        let starts = points.starts();
        let [least, most] = starts.bounds;
        let middle = least * 0.5 + most * 0.5;
        if !projection.orient_along(middle, -to_light.get()) {
            return;
        }
        projection.error = starts.largest_error;
        // A projection takes it that no sphere hides points of its own that are seen from outside and face the
        // light: not those that are seen edge-on.
        let mut asked = *unknown;
        let mut within = 0;
        for (packet, bits) in asked.iter_mut().enumerate() {
            *bits &= !points.edge_on[packet];
            within |= *bits & points.within[packet];
        }
        projection.has_points_within = within != 0;
        groups.clear();
        groups.push(asked);
        // All points of the batch will often do.
        let half = most * 0.5 - least * 0.5;
        let reach = DVec3::from_array(all_three(projection.axes, |axis| axis.abs().dot(half)));
        let mut range = Some([-reach, reach]);
        let mut most_spread = self.are_few.then_some(f64::INFINITY);
        while let Some(group) = groups.pop() {
            let mut members = 0;
            for bits in group {
                members += bits.count_ones();
            }
            if members < FEW {
                continue;
            }
            let range = range.take().or_else(
                #[inline(always)]
                || {
                    ranges(
                        simd,
                        #[inline(always)]
                        |packet| group[packet],
                        #[inline(always)]
                        |packet| projection.turned(offsets(simd, starts.position, packet, middle)),
                    )
                },
            );
            let Some(range) = range else {
                continue;
            };
            projection.project_to_ends(simd, &group, starts.position, middle, range);
            if projection.state == State::Unfit {
                continue;
            }
            let most_spread = *most_spread.get_or_insert_with(
                #[inline(always)]
                || projection.median_width() * MOST_SPREAD,
            );
            if let Some(halves) = projection.halves(simd, &group, most_spread) {
                groups.extend(halves);
                continue;
            }
            projection.work.shadow.batches += 1;
            let occlusion = OcclusionTest {
                light,
                starts: starts.position,
                primitives: &points.primitive,
                only: points.only.one(),
                within: &points.within,
                asked: &group,
            };
            self.shapes
                .rasterize(simd, projection, setups, stack, occlusion);
            for (packet, &bits) in group.iter().enumerate() {
                if bits == 0 {
                    continue;
                }
                let reached = projection.reached(simd, packet) & bits;
                let fallback = projection.falls_back(packet) & reached;
                lit[packet] |= reached & !fallback;
                unknown[packet] &= !bits | fallback;
            }
        }
    }
}
