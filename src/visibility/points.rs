//! The points of surfaces that primary rays hit.

mod facing;
mod lift;
mod met;
mod smooth;
mod unit;

use std::ops::Range;

use fearless_simd::Simd;

use super::batch::{BATCH, Column, PACKETS, columns, columns_mut};
use super::primitive::{Primitive, SPHERES};
use super::projection::NOTHING;
use super::question::NearestHit;
use super::ray_batch::{RayStart, RayStarts};
use super::rays::{ROUNDING, Rays};
use super::shapes::Shapes;
use crate::math::{DVec3, Normal, Point};
use crate::simd::{DVec3x16, F64x16, LANES, Mask64x16, U32x16, U64x16, ones};
pub(crate) use facing::Facing;
use lift::Lifts;
pub(super) use met::surface_of;
use met::{KnownShape, SurfaceRecords, below, meet_triangles};
use unit::unit;

/// Where a ray touches a sphere, rounding may put the outward normal on the far side, and it is turned inwards.
/// n·ω_o is then the error of the point over the radius, which is far below this for spheres that projections
/// tell.
const EDGE_ON: f64 = 1.0 / 64.0;

/// p of the lecture for every ray of a batch, with all that L3 to L8 need there, number by number in
/// columns. Where a ray hits nothing the numbers mean nothing.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    /// For each packet one bit for each ray that hits something.
    pub(crate) hit: [u32; PACKETS],
    /// p, relative to the world's anchor.
    pub(crate) position: [Column; 3],
    /// A bound on the rounding error of p, in scene units: what is nearer to it than this may be the
    /// surface itself.
    pub(crate) error: Column,
    /// ω_o: from the point to the viewer.
    pub(crate) to_viewer: [Column; 3],
    /// The normal of the surface, turned towards the viewer.
    pub(super) geometric_normal: [Column; 3],
    /// The geometric normal times a point of the plane that touches the surface at p: for flat shapes one that
    /// is known exactly, for others p itself. Of lifted points the interpolated normal times p.
    pub(super) plane: Column,
    /// Whether `shading_normal` is anything else than the geometric normal.
    is_smooth: bool,
    /// The interpolated normal of a smooth mesh, on the viewer's side of the surface; elsewhere the geometric
    /// normal. Only where there are smooth meshes.
    pub(super) shading_normal: [Column; 3],
    /// n · ω_o
    pub(crate) cos_viewer: Column,
    /// For each packet one bit for each point of a sphere that is seen so nearly edge-on that rounding may have
    /// turned its normal to the wrong side.
    pub(super) edge_on: [u32; PACKETS],
    /// For each packet one bit for each other point of a sphere that is seen from within.
    pub(super) within: [u32; PACKETS],
    /// What is hit.
    pub(crate) primitive: [u64; BATCH],
    /// What all of them are on.
    pub(super) only: Only,
    /// The largest of `error`, and the box around the positions.
    pub(super) largest_error: f64,
    pub(super) bounds: [DVec3; 2],
    /// Which of them have shadow rays that start elsewhere, and where.
    pub(super) lifts: Lifts,
    /// Its material, an index into [`World::materials`](crate::world::World::materials).
    pub(crate) material: [u32; BATCH],
    /// For each packet, whether all its points have one material.
    pub(crate) is_uniform: [bool; PACKETS],
}

impl Default for Points {
    fn default() -> Self {
        const NONE: Column = Column::ZERO;
        Self {
            hit: [0; PACKETS],
            position: [NONE; 3],
            error: NONE,
            to_viewer: [NONE; 3],
            geometric_normal: [NONE; 3],
            plane: NONE,
            is_smooth: false,
            shading_normal: [NONE; 3],
            cos_viewer: NONE,
            edge_on: [0; PACKETS],
            within: [0; PACKETS],
            primitive: [0; BATCH],
            only: Only::Nothing,
            largest_error: 0.0,
            bounds: [DVec3::ZERO; 2],
            lifts: Lifts::default(),
            material: [0; BATCH],
            is_uniform: [true; PACKETS],
        }
    }
}

/// What stands for a normal that is no number.
fn any_normal() -> Normal {
    Normal::new(DVec3::Z).expect("z is a direction")
}

/// Where the shadow rays of a point start, and what it is on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Start {
    /// p, or off it p′.
    pub(crate) position: Point,
    /// A bound on its rounding error.
    pub(crate) error: f64,
    /// The normal of the tangent plane that light has to be above of, towards the viewer.
    pub(crate) horizon: Normal,
    /// What it is on.
    pub(crate) primitive: u64,
}

/// What points are on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Only {
    Nothing,
    One(Primitive),
    /// More than one primitive, or it is not known that it is one: no batch is resolved whole by that.
    Many,
}

impl Only {
    /// What all points are on, if that is known to be one.
    pub(super) fn one(self) -> Option<Primitive> {
        match self {
            Self::One(primitive) => Some(primitive),
            Self::Nothing | Self::Many => None,
        }
    }

    /// With points on one more primitive.
    fn and(self, primitive: Primitive) -> Self {
        match self {
            Self::Nothing => Self::One(primitive),
            Self::One(known) if known == primitive => self,
            Self::One(_) | Self::Many => Self::Many,
        }
    }
}

/// What some rays of a packet are known to hit first.
pub(super) struct Known<'s, S: Simd> {
    /// The slot of each ray's shape; [`NOTHING`] where it hits nothing.
    pub(super) slots: &'s [u32],
    /// One bit for each ray that it is known of.
    pub(super) met: u32,
    /// The last shape that all rays of a packet hit, which the next may hit as well.
    pub(super) last: &'s mut Option<KnownShape<S>>,
}

/// Where the rays of a packet meet shapes.
#[derive(Clone, Copy)]
struct Met<S: Simd> {
    t: F64x16<S>,
    /// The center of a curved shape, or the normal of a flat one.
    reference: DVec3x16<S>,
    /// A point of a flat shape.
    tangent: DVec3x16<S>,
    is_curved: Mask64x16<S>,
}

impl From<Start> for RayStart {
    /// Of a ray from there.
    fn from(start: Start) -> Self {
        Self {
            t: 0.0,
            position: start.position.0,
            error: start.error,
            primitive: start.primitive,
        }
    }
}

impl Points {
    /// Forgets all points.
    pub(super) fn begin(&mut self, is_smooth: bool) {
        self.is_smooth = is_smooth;
        self.only = Only::Nothing;
        self.lifts.begin();
    }

    /// Knows nothing of what was met before.
    pub(crate) fn forget(&mut self) {
        self.only = Only::Nothing;
    }

    /// Where the rays of a packet leave these points, at t of theirs.
    #[inline(always)]
    pub(crate) fn ray_starts<S: Simd>(&self, simd: S, packet: usize, t: F64x16<S>) -> RayStarts<S> {
        let first = packet * LANES;
        RayStarts {
            t,
            position: DVec3x16::load(simd, columns(&self.position, packet)),
            error: F64x16::load(simd, &self.error[first..]),
            primitive: U64x16::load(simd, &self.primitive[first..]),
        }
    }

    /// Knows all points, and what they have in common.
    #[inline(always)]
    pub(super) fn end<S: Simd>(&mut self, simd: S) {
        (self.largest_error, self.bounds) = self.around(simd, &self.position, &self.error);
        if self.lifts.are_any {
            self.end_lifted(simd);
        }
    }

    /// Makes the points of a packet from the nearest hits of some rays, and for the others from what they
    /// are known to hit first.
    #[inline(always)]
    pub(super) fn fill<S: Simd>(
        &mut self,
        simd: S,
        shapes: &Shapes<'_>,
        packet: usize,
        rays: &Rays<S>,
        nearest: &NearestHit<S>,
        Known { slots, met, last }: Known<'_, S>,
    ) {
        let infinite = F64x16::splat(simd, f64::INFINITY);
        let asked = (nearest.t.lt(infinite) & nearest.asked).to_bits();
        let found = below(simd, slots, NOTHING) & met;
        let bits = asked | found;
        self.hit[packet] = bits;
        if bits == 0 {
            return;
        }
        let slot = slots[bits.trailing_zeros() as usize];
        let are_all_known = asked == 0;
        let surface = if are_all_known && are_equal(simd, slots, slot) & bits == bits {
            self.meet_one(simd, shapes, packet, rays, bits, slot, last)
        } else if are_all_known && below(simd, slots, SPHERES) & bits == bits {
            self.meet_triangles(simd, shapes, packet, rays, bits, slots)
        } else {
            let mut surfaces = SurfaceRecords::new(nearest);
            surfaces.ask(simd, shapes, rays, slots, found);
            surfaces.take(shapes.world, asked);
            self.meet_several(simd, packet, bits, &surfaces)
        };
        self.place(simd, packet, rays, bits, surface);
        if self.is_smooth {
            self.interpolate(simd, shapes.world, packet, rays);
        }
    }

    /// L2 for rays that are known to hit one shape.
    #[inline(always)]
    #[expect(clippy::too_many_arguments, reason = "a step of `fill`")]
    fn meet_one<S: Simd>(
        &mut self,
        simd: S,
        shapes: &Shapes<'_>,
        packet: usize,
        rays: &Rays<S>,
        bits: u32,
        slot: u32,
        last: &mut Option<KnownShape<S>>,
    ) -> Met<S> {
        if rays.shared_origin.is_none() || last.is_none_or(|last| last.slot != slot) {
            *last = Some(KnownShape::new(simd, shapes, slot, rays));
        }
        let shape = last.as_ref().expect("it is there now");
        let KnownShape {
            primitive, surface, ..
        } = *shape;
        self.only = self.only.and(primitive);
        let lanes = packet * LANES..(packet + 1) * LANES;
        self.primitive[lanes.clone()].fill(primitive.0);
        self.material[lanes].fill(surface.material);
        self.is_uniform[packet] = true;
        Met {
            t: shape.met(simd, shapes, rays, bits),
            reference: DVec3x16::splat(simd, surface.reference),
            tangent: DVec3x16::splat(simd, surface.tangent),
            is_curved: Mask64x16::from_bits(simd, if surface.is_curved { bits } else { 0 }),
        }
    }

    /// L2 for rays that are known to hit triangles, each its own.
    #[inline(always)]
    fn meet_triangles<S: Simd>(
        &mut self,
        simd: S,
        shapes: &Shapes<'_>,
        packet: usize,
        rays: &Rays<S>,
        bits: u32,
        slots: &[u32],
    ) -> Met<S> {
        self.only = Only::Many;
        let triangles = &shapes.triangles;
        let (t, reference, tangent) = meet_triangles(simd, triangles, rays, slots, bits);
        let first_lane = packet * LANES;
        let (mut object, mut material) = (u32::MAX, 0);
        let mut are_uniform = true;
        for lane in ones(bits) {
            let primitive = triangles.primitive(slots[lane]);
            self.primitive[first_lane + lane] = primitive.0;
            let (of, _) = primitive.parts();
            if of != object {
                let its = shapes.world.objects()[of as usize].material as u32;
                are_uniform &= object == u32::MAX || its == material;
                (object, material) = (of, its);
            }
            self.material[first_lane + lane] = material;
        }
        self.is_uniform[packet] = are_uniform;
        Met {
            t,
            reference,
            tangent,
            is_curved: Mask64x16::from_bits(simd, 0),
        }
    }

    /// What was found of rays that hit shapes of any kind.
    #[inline(always)]
    fn meet_several<S: Simd>(
        &mut self,
        simd: S,
        packet: usize,
        bits: u32,
        surfaces: &SurfaceRecords,
    ) -> Met<S> {
        self.only = Only::Many;
        let lanes = packet * LANES..(packet + 1) * LANES;
        self.primitive[lanes.clone()].copy_from_slice(&surfaces.primitive);
        self.material[lanes].copy_from_slice(&surfaces.material);
        let material = surfaces.material[bits.trailing_zeros() as usize];
        self.is_uniform[packet] = ones(bits).all(|lane| surfaces.material[lane] == material);
        let [x, y, z] = &surfaces.reference;
        let reference = DVec3x16::load(simd, [x, y, z]);
        let [x, y, z] = &surfaces.tangent;
        Met {
            t: F64x16::load(simd, &surfaces.t),
            reference,
            tangent: DVec3x16::load(simd, [x, y, z]),
            is_curved: Mask64x16::from_bits(simd, surfaces.curved),
        }
    }

    /// Places the points of a packet where its rays meet shapes: p, ω_o and n of each.
    #[inline(always)]
    fn place<S: Simd>(&mut self, simd: S, packet: usize, rays: &Rays<S>, bits: u32, met: Met<S>) {
        let Met {
            t,
            reference,
            tangent,
            is_curved,
        } = met;
        let offset = rays.direction.times(t);
        let position = rays.origin + offset;
        let inverse = rays.square.nearly_inverse_root(simd);
        let to_viewer = unit(simd, -rays.direction, rays.square, inverse, bits);
        let curved = bits & is_curved.to_bits();
        let normal = if curved == 0 {
            reference
        } else {
            let outwards = position - reference;
            let square = outwards.dot(outwards);
            let inverse = square.nearly_inverse_root(simd);
            let outwards = unit(simd, outwards, square, inverse, curved);
            // A sphere smaller than the rounding of its place faces the viewer.
            let has_direction = outwards.dot(outwards).is_positive();
            let outwards = has_direction.select_vectors(outwards, to_viewer);
            is_curved.select_vectors(outwards, reference)
        };
        let is_turned = normal.dot(to_viewer).lt(F64x16::splat(simd, 0.0));
        let geometric = is_turned.select_vectors(-normal, normal);
        let cos_viewer = geometric.dot(to_viewer);
        let turned = is_turned.to_bits() & curved;
        let edge_on = cos_viewer.lt(F64x16::splat(simd, EDGE_ON)).to_bits();
        self.edge_on[packet] = turned & edge_on;
        self.within[packet] = turned & !edge_on;
        let tangent = is_curved.select_vectors(position, tangent);

        let first_lane = packet * LANES;
        position.store(columns_mut(&mut self.position, packet));
        position_error(rays, offset, tangent).store(&mut self.error[first_lane..]);
        to_viewer.store(columns_mut(&mut self.to_viewer, packet));
        geometric.store(columns_mut(&mut self.geometric_normal, packet));
        geometric.dot(tangent).store(&mut self.plane[first_lane..]);
        if self.is_smooth {
            geometric.store(columns_mut(&mut self.shading_normal, packet));
        }
        cos_viewer.store(&mut self.cos_viewer[first_lane..]);
    }

    /// n of L5 to L7: the interpolated normal of a smooth mesh, on the viewer's side of the surface; elsewhere
    /// the geometric normal.
    #[inline(always)]
    pub(crate) fn shading_normals(&self) -> &[Column; 3] {
        if self.is_smooth {
            &self.shading_normal
        } else {
            &self.geometric_normal
        }
    }

    /// The normals of the surfaces, turned towards the viewer.
    #[inline(always)]
    pub(crate) fn geometric_normals(&self) -> &[Column; 3] {
        &self.geometric_normal
    }

    /// The geometric normal of a point on a flat shape times any point of its plane.
    #[inline]
    pub(crate) fn plane(&self, slot: usize) -> f64 {
        self.plane[slot]
    }

    /// Where the shadow rays of a point that is hit start.
    #[inline]
    pub(crate) fn start(&self, slot: usize) -> Start {
        let at = |columns: &[Column; 3]| {
            let [x, y, z] = columns;
            DVec3::new(x[slot], y[slot], z[slot])
        };
        let starts = self.starts();
        let is_lifted = self.lifts.points[slot / LANES] >> (slot % LANES) & 1 == 1;
        let normal = at(if is_lifted {
            &self.shading_normal
        } else {
            &self.geometric_normal
        });
        Start {
            position: Point(at(starts.position)),
            error: starts.error[slot],
            horizon: Normal::new(normal).unwrap_or_else(any_normal),
            primitive: self.primitive[slot],
        }
    }

    /// A box around where all shadow rays start, from its least to its largest coordinates.
    #[inline]
    pub(crate) fn bounds_of_starts(&self) -> [DVec3; 2] {
        self.starts().bounds
    }

    /// The same of one packet.
    pub(crate) fn bounds_of_packet(&self, packet: usize) -> [DVec3; 2] {
        let [x, y, z] = self.starts().position;
        let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for lane in ones(self.hit[packet]) {
            let slot = packet * LANES + lane;
            let position = DVec3::new(x[slot], y[slot], z[slot]);
            (least, most) = (least.min(position), most.max(position));
        }
        [least, most]
    }

    /// What all points are on, if that is known to be one shape.
    #[inline]
    pub(crate) fn only_shape(&self) -> Option<u64> {
        self.only.one().map(|primitive| primitive.0)
    }

    /// Whether a ray of the batch hits something.
    #[inline(always)]
    pub(crate) fn is_hit(&self, slot: usize) -> bool {
        self.hit[slot / LANES] >> (slot % LANES) & 1 == 1
    }

    /// The object that a ray hits, an index into [`World::objects`](crate::world::World::objects).
    #[inline(always)]
    pub(crate) fn object(&self, slot: usize) -> u32 {
        let (object, _) = Primitive(self.primitive[slot]).parts();
        object
    }

    /// Whether every ray that a batch has room for hits something.
    #[inline(always)]
    pub(crate) fn all_hit(&self) -> bool {
        self.hit
            .iter()
            .all(|&bits| bits.count_ones() == LANES as u32)
    }

    /// Whether no ray of the batch hits anything.
    #[inline(always)]
    pub(crate) fn none_hit(&self) -> bool {
        self.hit.iter().all(|&bits| bits == 0)
    }

    /// How many rays of some slots hit something.
    #[inline(always)]
    pub(crate) fn hits(&self, slots: Range<usize>) -> u32 {
        let packets = slots.start / LANES..slots.end.div_ceil(LANES);
        packets.fold(0, |count, packet| {
            let first = packet * LANES;
            let start = slots.start.saturating_sub(first);
            let end = (slots.end - first).min(LANES);
            let lanes = (1 << end) - (1_u32 << start);
            count + (self.hit[packet] & lanes).count_ones()
        })
    }
}

/// One bit for each slot of a packet that is this one.
#[inline(always)]
fn are_equal<S: Simd>(simd: S, slots: &[u32], slot: u32) -> u32 {
    let slot = U32x16::splat(simd, slot);
    U32x16::load(simd, slots).eq(slot).to_bits()
}

/// A bound on the rounding error of p = o + t ω, beside which a point of the surface is known, in scene units.
///
/// t comes from the offset between o and that point, and is rounded with it; then there is one rounding for the
/// product t ω and one for the sum. Each is relative to one of three lengths, for which the sums of their
/// components' magnitudes stand: at least the length, at most √3 times as much.
#[inline(always)]
fn position_error<S: Simd>(rays: &Rays<S>, offset: DVec3x16<S>, tangent: DVec3x16<S>) -> F64x16<S> {
    let to_surface = tangent - rays.origin;
    let magnitude = rays.origin.taxicab() + offset.taxicab() + to_surface.taxicab();
    magnitude * ROUNDING
}
