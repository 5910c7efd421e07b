//! The points of surfaces that primary rays hit.

use std::ops::Range;

use fearless_simd::Simd;

use super::canvas::NOTHING;
use super::lift::Lifts;
use super::packet::{Nearest, Rays};
use super::search::Search;
use super::triangle::{self, Facet, Lie};
use super::{PLANES, Primitive, ROUNDING, SPHERES, Visibility, outline, plane};
use crate::lanes::{LANES, Lanes, Mask, Vectors, Words, ones};
use crate::math::{DVec3, Direction, SAFE_SQUARES, all_three};
use crate::world::geometry::{from_shorter_edges, triangle_normal};
use crate::world::{Shape, World};

/// Rays that are traced and shaded together.
pub const BATCH: usize = 256;

/// Where a ray touches a sphere, rounding may put the outward normal on the far side, and it is turned inwards.
/// n·ω_o is then the error of the point over the radius, which is far below this for spheres that canvases tell.
const EDGE_ON: f64 = 1.0 / 64.0;

/// Packets of a batch.
pub const PACKETS: usize = BATCH / LANES;

/// One number for each ray of a batch.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Column(pub(crate) [f64; BATCH]);

impl Column {
    pub(crate) const ZERO: Self = Self([0.0; BATCH]);
}

impl std::ops::Deref for Column {
    type Target = [f64; BATCH];

    #[inline(always)]
    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl std::ops::DerefMut for Column {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

/// p of the lecture for every ray of a batch, with all that L3 to L8 need there, number by number in
/// columns. Where a ray hits nothing the numbers mean nothing.
#[derive(Clone, Debug)]
pub struct Points {
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
    /// What is hit.
    pub(crate) primitive: [u64; BATCH],
    /// What all of them are on.
    pub(super) only: Only,
    /// The largest of `error`, and the box around the positions.
    pub(super) largest_error: f64,
    pub(super) bounds: [DVec3; 2],
    /// Which of them have shadow rays that start elsewhere, and where.
    pub(super) lifts: Lifts,
    /// Its material, an index into [`World::materials`].
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

/// Three columns of a packet.
#[inline(always)]
pub(crate) fn columns(columns: &[Column; 3], packet: usize) -> [&[f64]; 3] {
    let [x, y, z] = columns;
    let lanes = packet * LANES..(packet + 1) * LANES;
    [&x[lanes.clone()], &y[lanes.clone()], &z[lanes]]
}

#[inline(always)]
pub(super) fn columns_mut(columns: &mut [Column; 3], packet: usize) -> [&mut [f64]; 3] {
    let [x, y, z] = columns;
    let lanes = packet * LANES..(packet + 1) * LANES;
    [&mut x[lanes.clone()], &mut y[lanes.clone()], &mut z[lanes]]
}

/// What a primitive says about all its points.
#[derive(Clone, Copy)]
struct Source {
    /// The center of a curved shape, or the normal of a flat one.
    reference: DVec3,
    /// A point of a flat shape.
    tangent: DVec3,
    is_curved: bool,
    material: u32,
}

/// What points are on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Only {
    Nothing,
    One(Primitive),
    /// More than one primitive, or it is not known that it is one: no batch is settled by that.
    Many,
}

impl Only {
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
    pub(super) last: &'s mut Option<Shown<S>>,
}

impl Points {
    /// Forgets all points.
    pub(super) fn begin(&mut self, is_smooth: bool) {
        self.is_smooth = is_smooth;
        self.only = Only::Nothing;
        self.lifts.begin();
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
        visibility: &Visibility<'_>,
        packet: usize,
        rays: &Rays<S>,
        nearest: &Nearest<S>,
        Known { slots, met, last }: Known<'_, S>,
    ) {
        let world = visibility.world;
        let first_lane = packet * LANES;
        let infinite = Lanes::splat(simd, f64::INFINITY);
        let asked = (nearest.t.lt(infinite) & nearest.asked).to_bits();
        let found = below(simd, slots, NOTHING);
        let bits = asked | found & met;
        self.hit[packet] = bits;
        if bits == 0 {
            return;
        }
        let first = bits.trailing_zeros() as usize;
        let is_one = asked == 0 && {
            let one = Words::splat(simd, slots[first]);
            Words::load(simd, slots).eq(one).to_bits() & bits == bits
        };
        let (reference, tangent, is_curved, t);
        if is_one {
            let slot = slots[first];
            if rays.shared_origin.is_none() || last.is_none_or(|last| last.slot != slot) {
                *last = Some(Shown::new(simd, visibility, slot, rays));
            }
            let shown = last.as_ref().expect("it is there now");
            let Shown {
                primitive, source, ..
            } = *shown;
            self.only = self.only.and(primitive);
            t = shown.met(simd, visibility, rays, bits);
            reference = Vectors::splat(simd, source.reference);
            tangent = Vectors::splat(simd, source.tangent);
            is_curved = Mask::from_bits(simd, if source.is_curved { bits } else { 0 });
            let lanes = first_lane..first_lane + LANES;
            self.primitive[lanes.clone()].fill(primitive.0);
            self.material[lanes].fill(source.material);
            self.is_uniform[packet] = true;
        } else if asked == 0 && below(simd, slots, SPHERES) & bits == bits {
            self.only = Only::Many;
            let triangles = &visibility.triangles;
            (t, reference, tangent) = meet_triangles(simd, triangles, rays, slots, bits);
            is_curved = Mask::from_bits(simd, 0);
            let (mut object, mut material) = (u32::MAX, 0);
            let mut are_uniform = true;
            for lane in ones(bits) {
                let primitive = triangles.get(slots[lane]).primitive();
                self.primitive[first_lane + lane] = primitive.0;
                let (of, _) = primitive.parts();
                if of != object {
                    let its = world.objects()[of as usize].material as u32;
                    are_uniform &= object == u32::MAX || its == material;
                    (object, material) = (of, its);
                }
                self.material[first_lane + lane] = material;
            }
            self.is_uniform[packet] = are_uniform;
        } else {
            self.only = Only::Many;
            let mut sources = Sources::new(nearest);
            sources.ask(simd, visibility, rays, slots, found & met);
            sources.take(world, asked);
            let lanes = first_lane..first_lane + LANES;
            self.primitive[lanes.clone()].copy_from_slice(&sources.primitive);
            self.material[lanes].copy_from_slice(&sources.material);
            let material = sources.material[first];
            self.is_uniform[packet] = ones(bits).all(|lane| sources.material[lane] == material);
            let [x, y, z] = &sources.reference;
            reference = Vectors::load(simd, [x, y, z]);
            let [x, y, z] = &sources.tangent;
            tangent = Vectors::load(simd, [x, y, z]);
            is_curved = Mask::from_bits(simd, sources.curved);
            t = Lanes::load(simd, &sources.t);
        }

        let way = rays.direction.times(t);
        let position = rays.origin + way;
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
        let is_turned = normal.dot(to_viewer).lt(Lanes::splat(simd, 0.0));
        let geometric = is_turned.select_vectors(-normal, normal);
        let cos_viewer = geometric.dot(to_viewer);
        let is_edge_on = is_turned & cos_viewer.lt(Lanes::splat(simd, EDGE_ON));
        self.edge_on[packet] = is_edge_on.to_bits() & curved;
        let tangent = is_curved.select_vectors(position, tangent);
        // t comes from the way to the shape's own reference, and is rounded with it; then one rounding
        // for the product and one for the sum.
        let magnitude = rays.origin.taxicab() + way.taxicab() + (tangent - rays.origin).taxicab();
        let error = magnitude * ROUNDING;

        position.store(columns_mut(&mut self.position, packet));
        error.store(&mut self.error[first_lane..]);
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

    /// Whether a ray of the batch hits something.
    #[inline(always)]
    pub(crate) fn is_hit(&self, slot: usize) -> bool {
        self.hit[slot / LANES] >> (slot % LANES) & 1 == 1
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

/// A shape that rays are known to meet first.
#[derive(Clone, Copy)]
pub(super) struct Shown<S: Simd> {
    slot: u32,
    primitive: Primitive,
    source: Source,
    /// Of a triangle, as seen from where the rays start.
    lie: Option<Lie<S>>,
}

impl<S: Simd> Shown<S> {
    #[inline(never)]
    fn new(simd: S, visibility: &Visibility<'_>, slot: u32, rays: &Rays<S>) -> Self {
        simd.vectorize(
            #[inline(always)]
            || Self::at(simd, visibility, slot, rays),
        )
    }

    #[inline(always)]
    fn at(simd: S, visibility: &Visibility<'_>, slot: u32, rays: &Rays<S>) -> Self {
        let mut lie = None;
        let primitive = if slot >= PLANES {
            let plane = &visibility.world.planes()[(slot - PLANES) as usize];
            Primitive::whole(plane.object)
        } else if slot >= SPHERES {
            visibility.spheres.get(slot - SPHERES).primitive()
        } else {
            let facet = visibility.triangles.get(slot);
            let [a, b, c] = facet.vertices();
            let corners = [
                Vectors::splat(simd, a),
                Vectors::splat(simd, b),
                Vectors::splat(simd, c),
            ];
            lie = Some(Lie::new(corners, rays.origin));
            facet.primitive()
        };
        Self {
            slot,
            primitive,
            source: source(visibility.world, primitive),
            lie,
        }
    }

    /// L2 in f64: where rays that are known to meet it do so.
    #[inline(always)]
    fn met(&self, simd: S, visibility: &Visibility<'_>, rays: &Rays<S>, bits: u32) -> Lanes<S> {
        let asked = Mask::from_bits(simd, bits);
        if let Some(lie) = &self.lie {
            let (_, t) = triangle::met(simd, lie, rays, asked);
            t
        } else if self.slot >= PLANES {
            let plane = &visibility.world.planes()[(self.slot - PLANES) as usize];
            plane::met(plane, rays)
        } else {
            let ball = visibility.spheres.get(self.slot - SPHERES);
            let met = ball.first_met(simd, rays, asked);
            let (_, t) = met.expect("a ray that surely meets a sphere meets it");
            t
        }
    }
}

/// One bit for each slot of a packet below another.
#[inline(always)]
fn below<S: Simd>(simd: S, slots: &[u32], end: u32) -> u32 {
    Words::load(simd, slots)
        .lt(Words::splat(simd, end))
        .to_bits()
}

/// Where some rays meet triangles, each its own: t, the unit normal, and a corner.
#[inline(never)]
fn meet_triangles<S: Simd>(
    simd: S,
    triangles: &Search<Facet>,
    rays: &Rays<S>,
    slots: &[u32],
    bits: u32,
) -> (Lanes<S>, Vectors<S>, Vectors<S>) {
    simd.vectorize(
        #[inline(always)]
        || {
            let corners = outline::side_by_side(
                simd,
                bits,
                #[inline(always)]
                |lane| triangles.get(slots[lane]).vertices(),
            );
            let lie = Lie::new(corners, rays.origin);
            let (_, t) = triangle::met(simd, &lie, rays, Mask::from_bits(simd, bits));
            let [a, ..] = corners;
            let square = lie.normal.dot(lie.normal);
            let inverse = square.inverse_root(simd);
            (t, unit(simd, lie.normal, square, inverse, bits), a)
        },
    )
}

/// What the primitives of a packet's rays say about the points, ray by ray.
struct Sources {
    t: [f64; LANES],
    primitive: [u64; LANES],
    material: [u32; LANES],
    reference: [[f64; LANES]; 3],
    tangent: [[f64; LANES]; 3],
    curved: u32,
}

impl Sources {
    /// Those of the nearest hits, as far as they are known.
    #[inline(always)]
    fn new<S: Simd>(nearest: &Nearest<S>) -> Self {
        Self {
            t: nearest.t.to_array(),
            primitive: nearest.primitive.to_array(),
            material: [0; LANES],
            reference: [[0.0; LANES]; 3],
            tangent: [[0.0; LANES]; 3],
            curved: 0,
        }
    }

    /// Takes what the world says of the primitives of some rays.
    fn take(&mut self, world: &World, bits: u32) {
        let mut known = None;
        for lane in ones(bits) {
            let primitive = Primitive(self.primitive[lane]);
            let source = match known {
                Some((of, source)) if of == primitive => source,
                _ => source(world, primitive),
            };
            known = Some((primitive, source));
            self.put(lane, source);
        }
    }

    fn put(&mut self, lane: usize, source: Source) {
        for axis in 0..3 {
            self.reference[axis][lane] = source.reference[axis];
            self.tangent[axis][lane] = source.tangent[axis];
        }
        self.curved |= u32::from(source.is_curved) << lane;
        self.material[lane] = source.material;
    }

    /// Where the rays that surely meet shapes do so, each its own.
    #[inline(never)]
    fn ask<S: Simd>(
        &mut self,
        simd: S,
        visibility: &Visibility<'_>,
        rays: &Rays<S>,
        slots: &[u32],
        met: u32,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                self.ask_triangles(simd, visibility, rays, slots, met);
                self.ask_others(simd, visibility, rays, slots, met);
            },
        );
    }

    /// Where the rays that meet triangles do so, each its own.
    #[inline(always)]
    fn ask_triangles<S: Simd>(
        &mut self,
        simd: S,
        visibility: &Visibility<'_>,
        rays: &Rays<S>,
        slots: &[u32],
        met: u32,
    ) {
        let bits = below(simd, slots, SPHERES) & met;
        if bits == 0 {
            return;
        }
        let (t, normal, _) = meet_triangles(simd, &visibility.triangles, rays, slots, bits);
        let t = t.to_array();
        let normal = [
            normal.x.to_array(),
            normal.y.to_array(),
            normal.z.to_array(),
        ];
        for lane in ones(bits) {
            let facet = visibility.triangles.get(slots[lane]);
            let (object, _) = facet.primitive().parts();
            self.t[lane] = t[lane];
            self.primitive[lane] = facet.primitive().0;
            self.put(
                lane,
                Source {
                    reference: DVec3::from_array(all_three(normal, |column| column[lane])),
                    tangent: facet.vertices()[0],
                    is_curved: false,
                    material: visibility.world.objects()[object as usize].material as u32,
                },
            );
        }
    }

    /// Where the rays that meet other shapes do so, shape by shape.
    #[inline(always)]
    fn ask_others<S: Simd>(
        &mut self,
        simd: S,
        visibility: &Visibility<'_>,
        rays: &Rays<S>,
        slots: &[u32],
        met: u32,
    ) {
        let mut left = met & !below(simd, slots, SPHERES);
        while left != 0 {
            let slot = slots[left.trailing_zeros() as usize];
            let mut bits = 0;
            for (lane, &other) in slots.iter().enumerate() {
                bits |= u32::from(other == slot) << lane;
            }
            bits &= left;
            left &= !bits;
            let shown = Shown::new(simd, visibility, slot, rays);
            let t = shown.met(simd, visibility, rays, bits).to_array();
            for lane in ones(bits) {
                self.t[lane] = t[lane];
                self.primitive[lane] = shown.primitive.0;
                self.put(lane, shown.source);
            }
        }
    }
}

#[inline]
fn source(world: &World, primitive: Primitive) -> Source {
    let (object, triangle) = primitive.parts();
    let object = &world.objects()[object as usize];
    let material = object.material as u32;
    match object.shape {
        Shape::Sphere(index) => Source {
            reference: world.spheres()[index].center.0,
            tangent: DVec3::ZERO,
            is_curved: true,
            material,
        },
        Shape::Plane(index) => {
            let plane = &world.planes()[index];
            Source {
                reference: plane.normal.get(),
                tangent: plane.point.0,
                is_curved: false,
                material,
            }
        }
        Shape::Mesh(_) => {
            let vertices = world.triangles().vertices(triangle);
            let normal = triangle_normal(vertices).expect("no triangle is degenerate");
            Source {
                reference: normal.get(),
                tangent: from_shorter_edges(vertices)[0],
                is_curved: false,
                material,
            }
        }
    }
}

/// Vectors at unit length, from their squares and the reciprocal roots of these; 0 for those of `asked` that
/// have no direction.
#[inline(always)]
pub(super) fn unit<S: Simd>(
    simd: S,
    vectors: Vectors<S>,
    square: Lanes<S>,
    inverse_root: Lanes<S>,
    asked: u32,
) -> Vectors<S> {
    let is_safe = square.is_within(simd, SAFE_SQUARES).to_bits();
    let units = vectors.times(inverse_root);
    let unsafe_lanes = asked & !is_safe;
    if unsafe_lanes == 0 {
        return units;
    }
    // Tiny and huge vectors are scaled before they are squared.
    let mut columns = [units.x.to_array(), units.y.to_array(), units.z.to_array()];
    let exact = [
        vectors.x.to_array(),
        vectors.y.to_array(),
        vectors.z.to_array(),
    ];
    for lane in ones(unsafe_lanes) {
        let vector = DVec3::from_array(exact.map(|column| column[lane]));
        let unit = Direction::new(vector).map_or(DVec3::ZERO, Direction::get);
        for axis in 0..3 {
            columns[axis][lane] = unit[axis];
        }
    }
    let [x, y, z] = &columns;
    Vectors::load(simd, [x, y, z])
}
