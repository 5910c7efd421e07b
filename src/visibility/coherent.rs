//! L2 and L4 for rays that share a point or a direction, and segments to one point: by a projection, which decides
//! in f32 what is certain, and for the few that are left in packets of sixteen, in f64; for those to a sun see
//! [`sun`].

mod mirrored;
mod sun;

use fearless_simd::Simd;

use super::batch::{Column, PACKETS, longest, offsets, ranges};
use super::points::{Known, Only, Points};
use super::projection::{NearestHitTest, OcclusionTest, State};
use super::question::NearestHit;
use super::ray_batch::RayBatch;
use super::rays::ROUNDING;
use super::shapes::SegmentStarts;
use super::{Visibility, Workspace, is_far};
use crate::math::{DVec3, Point};
use crate::simd::{DVec3x16, F64x16, LANES};

/// How far offsets from a light are off, over its distance from the anchor: its own place and the difference.
const LIGHT_ROUNDING: f64 = 2.0 * ROUNDING;

/// Fewer rays than this are not worth a projection.
const FEW: u32 = 8;

impl Visibility<'_> {
    /// L2: what rays meet first that share a point or a direction.
    #[inline(always)]
    pub(super) fn nearest_coherent<S: Simd>(
        &self,
        simd: S,
        rays: &RayBatch<'_, impl Fn(usize) -> DVec3x16<S>>,
        space: &mut Workspace,
        points: &mut Points,
    ) {
        space.projection.origin_number = 0;
        space.projection.work.primary.batches += 1;
        let mut asked = [0; PACKETS];
        for (packet, bits) in asked.iter_mut().enumerate() {
            *bits = rays.lanes(packet);
        }
        let is_projected =
            self.uses_projection && self.project_nearest(simd, rays, &asked, space, points.only);
        let Workspace {
            projection, stack, ..
        } = space;
        points.begin(self.is_smooth);
        let mut last = None;
        for (packet, bits) in asked.into_iter().enumerate() {
            if bits == 0 {
                points.hit[packet] = 0;
                continue;
            }
            let fallback = if is_projected {
                projection.falls_back(packet) & bits
            } else {
                bits
            };
            projection.work.primary.fallbacks += u64::from(fallback.count_ones());
            let known = bits & !fallback;
            if fallback == 0 && projection.found(simd, packet) & known == 0 {
                points.hit[packet] = 0;
                continue;
            }
            let rays = rays.packet(simd, packet);
            let mut nearest = NearestHit::new(simd, fallback);
            if fallback != 0 {
                self.shapes.ask_nearest(simd, &rays, &mut nearest, stack);
            }
            let known = Known {
                slots: projection.nearest_slots(packet),
                met: known,
                last: &mut last,
            };
            points.fill(simd, &self.shapes, packet, &rays, &nearest, known);
        }
        points.end(simd);
    }

    /// Projects the rays with a bit and rasterizes all that they may meet; whether the projection knows anything
    /// then. `only` is what the batch before met.
    #[inline(always)]
    fn project_nearest<S: Simd>(
        &self,
        simd: S,
        rays: &RayBatch<'_, impl Fn(usize) -> DVec3x16<S>>,
        asked: &[u32; PACKETS],
        space: &mut Workspace,
        only: Only,
    ) -> bool {
        let Workspace {
            projection,
            setups,
            stack,
            ..
        } = space;
        match rays {
            RayBatch::FromPoint {
                origin,
                direction,
                count,
                around,
            } => {
                projection.unit = unit_of(self.somewhere - origin.0);
                // What one batch meets, the next one mostly does.
                let may_resolve_whole = self.are_few || only != Only::Many;
                let is_bounded = may_resolve_whole
                    && around.is_some_and(|around| projection.bound_between(origin.0, around));
                if is_bounded {
                    self.shapes
                        .rasterize(simd, projection, setups, stack, NearestHitTest);
                }
                if is_bounded && projection.state == State::Bounded {
                    projection.resolve_whole();
                    projection.work.primary.resolved_whole += 1;
                    return true;
                }
                let ray = count / 2;
                let middle = direction(ray / LANES).lane(ray % LANES);
                projection.project_around(
                    simd,
                    origin.0,
                    middle,
                    asked,
                    #[inline(always)]
                    #[expect(
                        clippy::redundant_closure,
                        reason = "by a reference it is not inlined"
                    )]
                    |packet| direction(packet),
                );
            }
            RayBatch::Along {
                direction,
                origin,
                count,
            } => {
                let ray = count / 2;
                let middle = origin(ray / LANES).lane(ray % LANES);
                projection.unit = unit_of(self.somewhere - middle);
                projection.project_along(
                    simd,
                    middle,
                    *direction,
                    self.somewhere,
                    asked,
                    #[inline(always)]
                    #[expect(
                        clippy::redundant_closure,
                        reason = "by a reference it is not inlined"
                    )]
                    |packet| origin(packet),
                );
            }
            RayBatch::Any(_) => return false,
        }
        if projection.state == State::Projected {
            self.shapes
                .rasterize(simd, projection, setups, stack, NearestHitTest);
        }
        projection.state != State::Unfit
    }

    /// L4: which of the points with a bit in `facing` the light reaches.
    #[inline(never)]
    pub(super) fn free_to_point<S: Simd>(
        &self,
        simd: S,
        light: Point,
        points: &Points,
        facing: &[u32; PACKETS],
        space: &mut Workspace,
    ) -> [u32; PACKETS] {
        if is_far(light, points) {
            return self.free_to_far_point(simd, light, points, facing, space);
        }
        simd.vectorize(
            #[inline(always)]
            || self.free_to_point_all(simd, light, points, facing, space),
        )
    }

    #[inline(always)]
    fn free_to_point_all<S: Simd>(
        &self,
        simd: S,
        light: Point,
        points: &Points,
        facing: &[u32; PACKETS],
        space: &mut Workspace,
    ) -> [u32; PACKETS] {
        let mut lit = [0; PACKETS];
        let facing = self.lit_edge_on(simd, light, points, facing, space, &mut lit);
        if facing.iter().all(|&bits| bits == 0) {
            return lit;
        }
        let mut within = 0;
        for (bits, seen_within) in facing.iter().zip(points.within) {
            within |= bits & seen_within;
        }
        space.projection.has_points_within = within != 0;
        space.groups.clear();
        space.groups.push(facing);
        let starts = points.starts();
        // All points of the batch will often do.
        let [least, most] = starts.bounds;
        let mut range =
            Some([least - light.0, most - light.0]).filter(|range| !self.is_wide(range));
        while let Some(group) = space.groups.pop() {
            let range = range.take().or_else(|| {
                ranges(
                    simd,
                    #[inline(always)]
                    |packet| group[packet],
                    #[inline(always)]
                    |packet| offsets(simd, starts.position, packet, light.0),
                )
            });
            let Some(range) = range else {
                continue;
            };
            let mut members = 0;
            for bits in group {
                members += bits.count_ones();
            }
            let is_worth = members >= FEW;
            if is_worth
                && self.is_wide(&range)
                && let Some(halves) = halves(simd, starts.position, light, &group, range)
            {
                space.groups.extend(halves);
                continue;
            }
            let state = if self.uses_projection && is_worth {
                self.project_occlusion(simd, light, points, &group, range, space)
            } else {
                State::Unfit
            };
            let work = &mut space.projection.work.shadow;
            work.batches += 1;
            work.resolved_whole += u64::from(matches!(state, State::Occluded | State::Bounded));
            match state {
                State::Occluded => {}
                // There is nothing between the light and the points.
                State::Bounded => {
                    for (lit, bits) in lit.iter_mut().zip(group) {
                        *lit |= bits;
                    }
                }
                State::Projected => {
                    self.gather_lit(simd, light, points, &group, space, &mut lit);
                }
                State::Overlapping | State::Unfit => {
                    for (packet, &bits) in group.iter().enumerate() {
                        if bits != 0 {
                            lit[packet] |=
                                self.ask_reached(simd, light, points, packet, bits, space);
                        }
                    }
                }
            }
        }
        lit
    }

    /// L4 in f64 for the points of spheres that are seen edge-on; the others that face the light.
    ///
    /// A projection takes it that no sphere hides points of its own that are seen from outside and face the
    /// light. Those with a normal on the wrong side it does hide.
    #[inline(always)]
    fn lit_edge_on<S: Simd>(
        &self,
        simd: S,
        light: Point,
        points: &Points,
        facing: &[u32; PACKETS],
        space: &mut Workspace,
        lit: &mut [u32; PACKETS],
    ) -> [u32; PACKETS] {
        let mut others = *facing;
        for (packet, bits) in others.iter_mut().enumerate() {
            let edge_on = *bits & points.edge_on[packet];
            if edge_on != 0 {
                *bits &= !edge_on;
                lit[packet] = self.ask_reached(simd, light, points, packet, edge_on, space);
            }
        }
        others
    }

    /// Projects the shadow rays of a group, whose ends are in a range as seen from the light, and rasterizes all
    /// that may be on their way; what is known then.
    #[inline(always)]
    fn project_occlusion<S: Simd>(
        &self,
        simd: S,
        light: Point,
        points: &Points,
        group: &[u32; PACKETS],
        range: [DVec3; 2],
        space: &mut Workspace,
    ) -> State {
        let Workspace {
            projection,
            setups,
            stack,
            ..
        } = space;
        let starts = points.starts();
        let occlusion = OcclusionTest {
            light,
            starts: starts.position,
            primitives: &points.primitive,
            only: points.only.one(),
            within: &points.within,
            asked: group,
        };
        projection.error = starts.largest_error + light_error(light);
        if !projection.orient_to_ends(light.0, range) {
            return State::Unfit;
        }
        // Around a point of a mesh, neighbors are always on the way to the box.
        let may_resolve_whole = self.are_few || points.only != Only::Many;
        if !(may_resolve_whole && projection.bound()) {
            occlusion.project(simd, projection);
        }
        if projection.state != State::Unfit {
            self.shapes
                .rasterize(simd, projection, setups, stack, occlusion);
        }
        projection.state
    }

    /// Takes which points of a group the light reaches from a projection, and asks in f64 where that does not
    /// tell.
    #[inline(always)]
    fn gather_lit<S: Simd>(
        &self,
        simd: S,
        light: Point,
        points: &Points,
        group: &[u32; PACKETS],
        space: &mut Workspace,
        lit: &mut [u32; PACKETS],
    ) {
        for (packet, &bits) in group.iter().enumerate() {
            if bits == 0 {
                continue;
            }
            let reached = space.projection.reached(simd, packet) & bits;
            let fallback = space.projection.falls_back(packet) & reached;
            lit[packet] |= reached & !fallback;
            if fallback != 0 {
                lit[packet] |= self.ask_reached(simd, light, points, packet, fallback, space);
            }
        }
    }

    /// L4 in f64 for some points of a packet.
    #[inline(always)]
    fn ask_reached<S: Simd>(
        &self,
        simd: S,
        light: Point,
        points: &Points,
        packet: usize,
        bits: u32,
        space: &mut Workspace,
    ) -> u32 {
        space.projection.work.shadow.fallbacks += u64::from(bits.count_ones());
        let starts = points.starts();
        let ends = SegmentStarts {
            position: starts.position,
            error: starts.error,
            primitive: &points.primitive,
        };
        self.shapes
            .ask_reached(simd, light, ends, packet, bits, &mut space.stack)
    }

    /// Whether directions in a range are too far apart for one projection.
    fn is_wide(&self, range: &[DVec3; 2]) -> bool {
        let [least, most] = *range;
        (most - least).max_element() > longest(range) * self.most_spread
    }
}

/// The unit of a projection from a point, by the way from there to what it looks at.
fn unit_of(way: DVec3) -> f64 {
    let distance = way.length();
    if distance > 0.0 { distance } else { 1.0 }
}

/// How far the offsets from a light to points may be off by its own place: rounding it to the f64 of its
/// coordinates and the differences, in scene units.
#[inline(always)]
fn light_error(light: Point) -> f64 {
    light.0.length() * LIGHT_ROUNDING
}

/// Points too far apart for one beam, in two groups: by where along the widest side of their range, seen from
/// the light, they are. `None` where rounding makes one of them empty.
#[inline(always)]
fn halves<S: Simd>(
    simd: S,
    starts: &[Column; 3],
    light: Point,
    group: &[u32; PACKETS],
    [least, most]: [DVec3; 2],
) -> Option<[[u32; PACKETS]; 2]> {
    let widest = (most - least).max_position();
    let middle = F64x16::splat(simd, least[widest] * 0.5 + most[widest] * 0.5);
    let mut lower = *group;
    for (packet, bits) in lower.iter_mut().enumerate() {
        if *bits != 0 {
            let offset = offsets(simd, starts, packet, light.0);
            *bits &= offset.component(widest).lt(middle).to_bits();
        }
    }
    let mut upper = *group;
    for (upper, lower) in upper.iter_mut().zip(lower) {
        *upper &= !lower;
    }
    (lower != *group && lower != [0; PACKETS]).then_some([lower, upper])
}
