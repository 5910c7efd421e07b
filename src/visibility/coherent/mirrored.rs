//! L2 for rays that come out of a plane mirror, or go straight on behind a pane: they share the image of their eye, or the
//! eye itself, as those of a camera do, but meet nothing before the surface that they leave.
//!
//! In the projection that surface is a reciprocal depth of each ray: what is certainly nearer is not met, and where f32 does
//! not tell, the ray goes its own way, as those do that share nothing, to the same bits.

use fearless_simd::Simd;

use super::{FEW, unit_of};
use crate::math::DVec3;
use crate::simd::{F32x16, F64x16, LANES, U64x16, ones};
use crate::visibility::batch::{BATCH, Floats, PACKETS, first_lanes};
use crate::visibility::incoherent::Hits;
use crate::visibility::points::{Known, Points, surface_of};
use crate::visibility::primitive::{PLANES, Primitive, SPHERES, ShapeId};
use crate::visibility::projection::{
    BatchProjection, DepthTest, Fragments, NEGLIGIBLE, NearestHitTest, POLYNOMIAL_ERROR, State,
};
use crate::visibility::question::NearestHit;
use crate::visibility::ray_batch::IncoherentRays;
use crate::visibility::rays::Rays;
use crate::visibility::shapes::Shapes;
use crate::visibility::work::{RayWork, Work};
use crate::visibility::{Visibility, Workspace};

/// What is the first that a ray meets beyond the flat surface that it leaves?
#[derive(Clone, Copy)]
struct BeyondTest<'t, 'w> {
    shapes: &'t Shapes<'w>,
    /// Between which reciprocal depths each ray leaves it.
    near: &'t [Floats; 2],
    /// What each ray leaves.
    primitives: &'t [u64; BATCH],
    /// If all leave one, a point of it, and its normal to where they go.
    plane: Option<[DVec3; 2]>,
}

/// On which side of the surface a shape is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    /// Where the rays go.
    Beyond,
    Before,
    Both,
}

impl Visibility<'_> {
    /// L2: the points that rays meet first that leave one flat surface, and share a point.
    #[inline(always)]
    pub(in crate::visibility) fn nearest_mirrored<S: Simd>(
        &self,
        simd: S,
        rays: &IncoherentRays,
        space: &mut Workspace,
        points: &mut Points,
    ) {
        let is_projected = self.project_mirrored(simd, rays, space);
        if !is_projected {
            return self.nearest_incoherent(simd, rays, space, points);
        }
        let mut open = [0; PACKETS];
        for (packet, open) in open.iter_mut().enumerate() {
            *open = space.projection.falls_back(packet) & first_lanes(rays.count(), packet);
        }
        let alone = self.nearest_alone(simd, rays, &open, space);
        let origin = rays.eye();
        points.begin(self.is_smooth);
        let mut last = None;
        for (packet, open) in open.into_iter().enumerate() {
            let asked = first_lanes(rays.count(), packet);
            let first = packet * LANES;
            let slots = space.projection.nearest_slots(packet);
            if asked == 0 || open == 0 && space.projection.found(simd, packet) & asked == 0 {
                points.hit[packet] = 0;
                continue;
            }
            let nearest = match &alone {
                Some(hits) => NearestHit {
                    t: F64x16::load(simd, &hits.t[first..]),
                    primitive: U64x16::load(simd, &hits.primitive[first..]),
                    ..NearestHit::new(simd, open)
                },
                None => NearestHit::new(simd, 0),
            };
            let known = Known {
                slots,
                met: asked & !open,
                last: &mut last,
            };
            let mut rays = rays.packet(simd, packet);
            rays.shared_origin = origin;
            points.fill(simd, &self.shapes, packet, &rays, &nearest, known);
        }
        points.end(simd);
    }

    /// Projects all rays and rasterizes all that they may meet; whether the projection knows anything then.
    #[inline(always)]
    fn project_mirrored<S: Simd>(
        &self,
        simd: S,
        rays: &IncoherentRays,
        space: &mut Workspace,
    ) -> bool {
        let count = rays.count();
        let (Some(origin), Some(([t, error], primitives))) = (rays.eye(), rays.starts()) else {
            return false;
        };
        if !self.uses_projection || count < FEW as usize {
            return false;
        }
        let Some(plane) = self.plane_left(rays, primitives) else {
            return false;
        };
        let Workspace {
            projection,
            setups,
            stack,
            ..
        } = space;
        projection.origin_number = 0;
        projection.unit = unit_of(self.somewhere - origin);
        let [_, middle] = rays.ray(count / 2);
        let mut asked = [0; PACKETS];
        for (packet, asked) in asked.iter_mut().enumerate() {
            *asked = first_lanes(count, packet);
        }
        projection.project_around(
            simd,
            origin,
            middle,
            &asked,
            #[inline(always)]
            |packet| rays.packet(simd, packet).direction,
        );
        if projection.state != State::Projected {
            return false;
        }
        let [_, _, w] = projection.axes;
        let unit = projection.unit;
        let mut near = [Floats([0.0; BATCH]), Floats([0.0; BATCH])];
        for packet in 0..count.div_ceil(LANES) {
            let first = packet * LANES;
            let Rays { direction, .. } = rays.packet(simd, packet);
            let depth = direction.dot_with(w) * F64x16::load(simd, &t[first..]);
            // A start that is on a sphere as far as is known may be beside it.
            let is_vague = F64x16::load(simd, &error[first..])
                .gt(depth * F64x16::splat(simd, NEGLIGIBLE))
                .to_bits();
            if is_vague & first_lanes(count, packet) != 0 {
                return false;
            }
            let reciprocal = (F64x16::splat(simd, unit) / depth).narrowed(simd);
            let [least, most] = &mut near;
            (reciprocal * F32x16::splat(simd, 1.0 - POLYNOMIAL_ERROR)).store(&mut least.0[first..]);
            (reciprocal * F32x16::splat(simd, 1.0 + POLYNOMIAL_ERROR)).store(&mut most.0[first..]);
        }
        let beyond = BeyondTest {
            shapes: &self.shapes,
            near: &near,
            primitives,
            plane,
        };
        self.shapes
            .rasterize(simd, projection, setups, stack, beyond);
        true
    }

    /// A point of the flat surface that rays leave, and its normal to where they go, if it is one; `None` if any leaves
    /// a curved one.
    #[inline(always)]
    fn plane_left(
        &self,
        rays: &IncoherentRays,
        primitives: &[u64; BATCH],
    ) -> Option<Option<[DVec3; 2]>> {
        let primitives = &primitives[..rays.count()];
        let [first, ..] = primitives else {
            return None;
        };
        let mut last = None;
        for primitive in primitives {
            if last != Some(primitive)
                && surface_of(self.shapes.world, Primitive(*primitive)).is_curved
            {
                return None;
            }
            last = Some(primitive);
        }
        if primitives.iter().any(|other| other != first) {
            return Some(None);
        }
        let normal = surface_of(self.shapes.world, Primitive(*first)).reference;
        let [_, direction] = rays.ray(0);
        let ahead = if direction.dot(normal) < 0.0 {
            -normal
        } else {
            normal
        };
        Some(rays.start(0).map(|start| [start.position, ahead]))
    }

    /// What those rays with a bit meet, each on its own way; `None` if there are none.
    #[inline(always)]
    fn nearest_alone<S: Simd>(
        &self,
        simd: S,
        rays: &IncoherentRays,
        open: &[u32; PACKETS],
        space: &mut Workspace,
    ) -> Option<Box<Hits>> {
        if open.iter().all(|&bits| bits == 0) {
            return None;
        }
        let mut some = std::mem::take(&mut space.open);
        some.clear();
        let slots = open.iter().enumerate();
        let slots: Vec<usize> = slots
            .flat_map(|(packet, &bits)| ones(bits).map(move |lane| packet * LANES + lane))
            .collect();
        for &slot in &slots {
            let [origin, direction] = rays.ray(slot);
            if let Some(start) = rays.start(slot) {
                some.push_from(origin, direction, &start);
            }
        }
        let mut at_slots = Box::<Hits>::default();
        let hits = self.hits(simd, &some, space);
        for (place, &slot) in slots.iter().enumerate() {
            at_slots.t[slot] = hits.t[place];
            at_slots.primitive[slot] = hits.primitive[place];
        }
        space.open = some;
        Some(at_slots)
    }
}

impl BeyondTest<'_, '_> {
    /// Where a sphere is; flat shapes are met once, which their depth tells.
    #[inline(always)]
    fn side(self, id: ShapeId) -> Side {
        if !(SPHERES..PLANES).contains(&id.slot) {
            return Side::Beyond;
        }
        let Some([point, normal]) = self.plane else {
            return Side::Both;
        };
        let (center, radius) = self
            .shapes
            .spheres
            .get(id.slot - SPHERES)
            .center_and_radius();
        let height = normal.dot(center - point);
        let size = center.abs().max_element() + point.abs().max_element() + radius;
        let room = radius + size * NEGLIGIBLE;
        if height > room {
            Side::Beyond
        } else if height < -room {
            Side::Before
        } else {
            Side::Both
        }
    }
}

impl DepthTest for BeyondTest<'_, '_> {
    #[inline(always)]
    fn work(self, all: &mut Work) -> &mut RayWork {
        NearestHitTest.work(all)
    }

    #[inline(always)]
    fn are_all_on(self, _: ShapeId) -> bool {
        false
    }

    #[inline(always)]
    fn resolves_whole(
        self,
        _: &mut BatchProjection,
        _: ShapeId,
        _: Option<[f32; 2]>,
        _: f32,
    ) -> bool {
        false
    }

    #[inline(always)]
    fn ensure_projected<S: Simd>(self, simd: S, projection: &mut BatchProjection) -> bool {
        NearestHitTest.ensure_projected(simd, projection)
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
        let side = self.side(id);
        if side == Side::Before {
            return;
        }
        let [least, most] = self.near;
        let is_before = fragments
            .least
            .gt(F32x16::load(simd, &most.0[packet * LANES..]));
        let is_beyond = F32x16::load(simd, &least.0[packet * LANES..]).gt(fragments.most);
        let mut may_cover = fragments.may_cover & !id.has(simd, self.primitives, packet);
        if side == Side::Both {
            // Its other crossing may be beyond.
            let open = may_cover & !is_beyond;
            projection.unresolved[packet] |= open.to_bits();
        }
        may_cover = may_cover & !is_before;
        let fragments = Fragments {
            may_cover,
            covered: fragments.covered & is_beyond,
            ..fragments
        };
        NearestHitTest.resolve(simd, projection, packet, id, fragments);
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
        _: S,
        _: &mut BatchProjection,
        _: usize,
        _: ShapeId,
        _: bool,
    ) {
    }
}
