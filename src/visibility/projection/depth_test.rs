//! The depth test of a [`BatchProjection`]: what is resolved by the fragments of shapes, and what stays ambiguous.

use fearless_simd::Simd;

use super::fragments::Fragments;
use super::{BatchProjection, State};
use crate::math::Point;
use crate::simd::{F32x16, LANES, Mask32x16, U32x16};
use crate::visibility::batch::{BATCH, Column, PACKETS, offsets};
use crate::visibility::primitive::{Primitive, ShapeId};
use crate::visibility::work::{RayWork, Work};

/// The depth test: what is made of fragments.
pub(in crate::visibility) trait DepthTest: Copy {
    /// What is done for it, of all.
    fn work(self, all: &mut Work) -> &mut RayWork;

    /// Whether all rays end on the shape.
    fn are_all_on(self, id: ShapeId) -> bool;

    /// Takes note, where there are only bounds, of a shape that may be of interest: `cover` is between which
    /// reciprocal depths all rays surely meet it, if they do, and `most` the largest at which any does. Whether
    /// no ray need be asked.
    fn resolves_whole(
        self,
        projection: &mut BatchProjection,
        id: ShapeId,
        cover: Option<[f32; 2]>,
        most: f32,
    ) -> bool;

    /// Projects the samples where there are only bounds; whether it is fit for its rays.
    fn ensure_projected<S: Simd>(self, simd: S, projection: &mut BatchProjection) -> bool;

    /// Tests the fragments of the shape, and resolves what it can.
    fn resolve<S: Simd>(
        self,
        simd: S,
        projection: &mut BatchProjection,
        packet: usize,
        id: ShapeId,
        fragments: Fragments<S>,
    );

    /// The shape cannot be told from f32: all rays of a packet that may meet it fall back to f64.
    fn leave_unresolved<S: Simd>(
        self,
        simd: S,
        projection: &mut BatchProjection,
        packet: usize,
        id: ShapeId,
    );

    /// A sphere that the end of a ray is on may hide it all the same: those fall back to f64 that are seen from
    /// within, and of one that cannot be told all.
    fn leave_own_unresolved<S: Simd>(
        self,
        simd: S,
        projection: &mut BatchProjection,
        packet: usize,
        id: ShapeId,
        is_untold: bool,
    );
}

/// What is the first that a primary ray meets?
#[derive(Clone, Copy)]
pub(in crate::visibility) struct NearestHitTest;

/// Which points does the light reach, of those with a bit?
#[derive(Clone, Copy)]
pub(in crate::visibility) struct OcclusionTest<'p> {
    /// Where the light is.
    pub(in crate::visibility) light: Point,
    /// Where the shadow rays of the points start.
    pub(in crate::visibility) starts: &'p [Column; 3],
    /// What each point is on, and what all of them are on, if that is one.
    pub(in crate::visibility) primitives: &'p [u64; BATCH],
    pub(in crate::visibility) only: Option<Primitive>,
    /// For each packet one bit for each point of a sphere that is seen from within.
    pub(in crate::visibility) within: &'p [u32; PACKETS],
    pub(in crate::visibility) asked: &'p [u32; PACKETS],
}

impl OcclusionTest<'_> {
    /// Projects the points before the light.
    #[inline(never)]
    pub(in crate::visibility) fn project<S: Simd>(self, simd: S, projection: &mut BatchProjection) {
        simd.vectorize(
            #[inline(always)]
            || {
                projection.project(
                    simd,
                    self.asked,
                    #[inline(always)]
                    |packet| offsets(simd, self.starts, packet, self.light.0),
                );
            },
        );
    }
}

impl DepthTest for NearestHitTest {
    #[inline(always)]
    fn work(self, all: &mut Work) -> &mut RayWork {
        &mut all.primary
    }

    #[inline(always)]
    fn are_all_on(self, _: ShapeId) -> bool {
        false
    }

    #[inline(always)]
    fn resolves_whole(
        self,
        projection: &mut BatchProjection,
        id: ShapeId,
        cover: Option<[f32; 2]>,
        most: f32,
    ) -> bool {
        if projection.state != State::Bounded {
            return false;
        }
        let before = projection.cover.map(|cover| cover.range);
        match (cover, before) {
            (_, Some([least, _])) if most < least => {}
            (Some(range), None) => projection.cover_with(id, range),
            (Some(range), Some([_, most])) if range[0] > most => projection.cover_with(id, range),
            _ => projection.close(State::Overlapping),
        }
        true
    }

    #[inline(always)]
    fn ensure_projected<S: Simd>(self, _: S, projection: &mut BatchProjection) -> bool {
        projection.state == State::Projected
    }

    #[inline(always)]
    fn resolve<S: Simd>(
        self,
        simd: S,
        projection: &mut BatchProjection,
        packet: usize,
        id: ShapeId,
        fragments: Fragments<S>,
    ) {
        let first = packet * LANES;
        let least = F32x16::load(simd, &projection.least.0[first..]);
        let may_cover = fragments.may_cover & fragments.most.ge(least);
        let bits = may_cover.to_bits();
        if bits == 0 {
            return;
        }
        let most = F32x16::load(simd, &projection.most.0[first..]);
        let is_nearer = may_cover & fragments.covered & fragments.least.gt(most);
        let nearer = is_nearer.to_bits();
        let least = is_nearer.select(fragments.least, least);
        least.store(&mut projection.least.0[first..]);
        let ambiguous = bits & !nearer;
        let most_of_both = most.max(fragments.most);
        let most = Mask32x16::from_bits(simd, ambiguous).select(most_of_both, most);
        is_nearer
            .select(fragments.most, most)
            .store(&mut projection.most.0[first..]);
        let slots = U32x16::load(simd, &projection.slots[first..]);
        let slots = is_nearer.select_words(U32x16::splat(simd, id.slot), slots);
        slots.store(&mut projection.slots[first..]);
        projection.ambiguous[packet] = projection.ambiguous[packet] & !nearer | ambiguous;
        projection.far.0[packet] = least.smallest();
    }

    #[inline(always)]
    fn leave_unresolved<S: Simd>(
        self,
        simd: S,
        projection: &mut BatchProjection,
        packet: usize,
        _: ShapeId,
    ) {
        projection.unresolved[packet] |= projection.asking(simd, packet).to_bits();
    }

    #[inline(always)]
    fn leave_own_unresolved<S: Simd>(
        self,
        _: S,
        _: &mut BatchProjection,
        _: usize,
        _: ShapeId,
        _: bool,
    ) {
    }
}

impl DepthTest for OcclusionTest<'_> {
    #[inline(always)]
    fn work(self, all: &mut Work) -> &mut RayWork {
        &mut all.shadow
    }

    #[inline(always)]
    fn are_all_on(self, id: ShapeId) -> bool {
        self.only == Some(id.primitive)
    }

    #[inline(always)]
    fn resolves_whole(
        self,
        projection: &mut BatchProjection,
        id: ShapeId,
        cover: Option<[f32; 2]>,
        _: f32,
    ) -> bool {
        let is_before = cover.is_some_and(|[least, _]| least > projection.nearest_end);
        let are_others = self.only.is_some_and(|own| own != id.primitive);
        let is_occluded = projection.state == State::Bounded && is_before && are_others;
        if is_occluded {
            projection.close(State::Occluded);
        }
        is_occluded
    }

    #[inline(always)]
    fn ensure_projected<S: Simd>(self, simd: S, projection: &mut BatchProjection) -> bool {
        if projection.state == State::Bounded {
            self.project(simd, projection);
        }
        projection.state == State::Projected
    }

    #[inline(always)]
    fn resolve<S: Simd>(
        self,
        simd: S,
        projection: &mut BatchProjection,
        packet: usize,
        id: ShapeId,
        fragments: Fragments<S>,
    ) {
        let first = packet * LANES;
        let least = F32x16::load(simd, &projection.least.0[first..]);
        let may_cover = fragments.may_cover & fragments.most.ge(least);
        if may_cover.to_bits() == 0 {
            return;
        }
        let may_cover = may_cover & !id.has(simd, self.primitives, packet);
        let bits = may_cover.to_bits();
        if bits == 0 {
            return;
        }
        let most = F32x16::load(simd, &projection.most.0[first..]);
        let is_occluded = may_cover & fragments.covered & fragments.least.gt(most);
        let occluded = is_occluded.to_bits();
        projection.ambiguous[packet] = (projection.ambiguous[packet] | bits) & !occluded;
        projection.unresolved[packet] &= !occluded;
        if occluded != 0 {
            let infinite = F32x16::splat(simd, f32::INFINITY);
            let least = is_occluded.select(infinite, least);
            least.store(&mut projection.least.0[first..]);
            projection.far.0[packet] = least.smallest();
        }
    }

    #[inline(always)]
    fn leave_unresolved<S: Simd>(
        self,
        simd: S,
        projection: &mut BatchProjection,
        packet: usize,
        id: ShapeId,
    ) {
        let own = id.has(simd, self.primitives, packet);
        projection.unresolved[packet] |= (projection.asking(simd, packet) & !own).to_bits();
    }

    #[inline(always)]
    fn leave_own_unresolved<S: Simd>(
        self,
        simd: S,
        projection: &mut BatchProjection,
        packet: usize,
        id: ShapeId,
        is_untold: bool,
    ) {
        let own = id.has(simd, self.primitives, packet);
        let own = (projection.asking(simd, packet) & own).to_bits();
        let seen_so = if is_untold { own } else { self.within[packet] };
        projection.unresolved[packet] |= own & seen_so;
    }
}
