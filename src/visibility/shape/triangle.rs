//! L2 and L4 for triangles, without cracks between neighbors.
//!
//! A ray is sheared so that it runs along its largest axis z (Woop, Benthin & Wald 2013, "Watertight
//! Ray/Triangle Intersection"). Seen along z, a triangle is flat, and the ray passes through it where
//! the origin is inside. Each corner is projected on its own, whatever triangle it is part of. The
//! edge function xᵢ yⱼ − xⱼ yᵢ compares two products, and rounding each of them cannot turn their order
//! around: it has the right sign or is 0, which counts as inside. So no ray slips between triangles
//! that share an edge or a corner.

mod leaf_block;
mod pairs;
mod setup;
mod single;

use std::sync::Arc;

use fearless_simd::Simd;

use super::{Block, Shape};
use crate::math::DVec3;
use crate::simd::{DVec3x16, F64x16, LANES, Mask64x16, ones};
use crate::visibility::primitive::{Primitive, ShapeId, TRIANGLES};
use crate::visibility::projection::{BatchProjection, DepthTest, State};
use crate::visibility::question::{NearestHit, Occlusion};
use crate::visibility::rays::{CYCLE, ROUNDING, Rays, Shear, ShearedRays};
use crate::visibility::tree::{Beam, Bounds};
use crate::world::Triangles;
use crate::world::geometry::{Turn, area_vector};
use leaf_block::{LeafBlock, Objects, Turns};
pub(in crate::visibility) use pairs::TrianglePerRay;
use setup::TriangleSetups;
pub(in crate::visibility) use single::{BlockHits, SingleRay};

/// A triangle with its place in the world, its corners in f64.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct Triangle {
    /// In the cyclic order of the world, from the corner between the two shorter edges on.
    vertices: [DVec3; 3],
    /// The place of that corner among those of the world.
    start: Turn,
    primitive: Primitive,
}

/// A corner: one for all rays, or one for each.
trait Corner<S: Simd>: Copy {
    /// How far it is along an axis beyond where rays start.
    fn beyond(self, axis: usize, origin: F64x16<S>) -> F64x16<S>;
}

impl<S: Simd> Corner<S> for DVec3 {
    #[inline(always)]
    fn beyond(self, axis: usize, origin: F64x16<S>) -> F64x16<S> {
        -(origin - self.to_array()[axis])
    }
}

impl<S: Simd> Corner<S> for DVec3x16<S> {
    #[inline(always)]
    fn beyond(self, axis: usize, origin: F64x16<S>) -> F64x16<S> {
        -(origin - self.component(axis))
    }
}

/// Which rays pass through a triangle, or each through its own: all edge functions have one sign. The i-th
/// edge function is twice the area that the ray makes with the edge opposite of the i-th corner.
#[inline(always)]
fn passes_through<S: Simd, V: Corner<S>>(
    simd: S,
    vertices: [V; 3],
    packet: &ShearedRays<S>,
    asked: u32,
) -> Mask64x16<S> {
    let mut passes = Mask64x16::from_bits(simd, 0);
    for axis in 0..3 {
        let shear = &packet.shears[axis];
        if shear.bits & asked == 0 {
            continue;
        }
        let [u, v, w] = edge_functions(vertices, &packet.rays, shear, axis);
        let zero = F64x16::splat(simd, 0.0);
        let positive = u.ge(zero) & v.ge(zero) & w.ge(zero);
        let negative = u.le(zero) & v.le(zero) & w.le(zero);
        // Corners so far away that they are all in one place enclose nothing: neither sign.
        passes = passes | ((positive | negative) & !(positive & negative) & shear.rays);
    }
    passes
}

#[inline(always)]
fn edge_functions<S: Simd, V: Corner<S>>(
    vertices: [V; 3],
    rays: &Rays<S>,
    shear: &Shear<S>,
    axis: usize,
) -> [F64x16<S>; 3] {
    let [u, v, w] = CYCLE[axis];
    let origin = [rays.origin.x, rays.origin.y, rays.origin.z];
    let a = projected(vertices[0], origin, shear, [u, v, w]);
    let b = projected(vertices[1], origin, shear, [u, v, w]);
    let c = projected(vertices[2], origin, shear, [u, v, w]);
    [edge(b, c), edge(c, a), edge(a, b)]
}

/// A corner as seen along the rays.
#[inline(always)]
fn projected<S: Simd, V: Corner<S>>(
    vertex: V,
    origin: [F64x16<S>; 3],
    shear: &Shear<S>,
    [u, v, w]: [usize; 3],
) -> [F64x16<S>; 2] {
    let z = vertex.beyond(w, origin[w]);
    [
        vertex.beyond(u, origin[u]) - shear.slopes[0] * z,
        vertex.beyond(v, origin[v]) - shear.slopes[1] * z,
    ]
}

#[inline(always)]
pub(in crate::visibility) fn edge<S: Simd>(p: [F64x16<S>; 2], q: [F64x16<S>; 2]) -> F64x16<S> {
    p[0] * q[1] - q[0] * p[1]
}

/// The planes of triangles, as seen from where rays start.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct PlaneSetup<S: Simd> {
    /// Twice the area, as a vector.
    pub(in crate::visibility) normal: DVec3x16<S>,
    /// The way to the plane, times the length of `normal`.
    height: F64x16<S>,
    /// |`normal`|², as far as rounding goes.
    rounding: F64x16<S>,
    /// From the start to the least and the largest coordinates.
    least: DVec3x16<S>,
    most: DVec3x16<S>,
}

impl<S: Simd> PlaneSetup<S> {
    /// By the corners of each lane's triangle from the one between the shorter edges on.
    #[inline(always)]
    pub(in crate::visibility) fn new([a, b, c]: [DVec3x16<S>; 3], origin: DVec3x16<S>) -> Self {
        let normal = (b - a).cross(c - a);
        Self {
            normal,
            height: (a - origin).dot(normal),
            rounding: normal.dot(normal) * (ROUNDING * ROUNDING),
            least: a.min(b).min(c) - origin,
            most: a.max(b).max(c) - origin,
        }
    }
}

/// x, y or else z.
#[inline(always)]
fn along<S: Simd>(is_x: Mask64x16<S>, is_y: Mask64x16<S>, vectors: DVec3x16<S>) -> F64x16<S> {
    is_x.select(vectors.x, is_y.select(vectors.y, vectors.z))
}

/// L2: where rays that pass through triangles, `asked`, meet them; and whether that is at t above 0 and
/// seen at all.
#[inline(always)]
pub(in crate::visibility) fn met<S: Simd>(
    setup: &PlaneSetup<S>,
    rays: &Rays<S>,
    asked: Mask64x16<S>,
) -> (Mask64x16<S>, F64x16<S>) {
    let d = rays.direction;
    let speed = d.dot(setup.normal);
    // Seen edge-on, as far as can be told, a triangle has no extent.
    let is_seen = (speed * speed).gt(rays.square * setup.rounding);
    let t = setup.height / speed;
    // The hit is between the corners, also where the normal of a sliver is not worth much.
    let [x, y, z] = [d.x.abs(), d.y.abs(), d.z.abs()];
    let is_x = x.ge(y) & x.ge(z);
    let is_y = y.ge(z);
    let direction = along(is_x, is_y, d);
    let to_least = along(is_x, is_y, setup.least);
    let to_most = along(is_x, is_y, setup.most);
    let offset = direction * t;
    let is_between = offset.ge(to_least) & offset.le(to_most);
    let t = if (asked & !is_between).any() {
        let (to_least, to_most) = (to_least / direction, to_most / direction);
        let near = to_least.min(to_most);
        let far = to_most.max(to_least);
        is_between.select(t, t.max(near).min(far))
    } else {
        t
    };
    (is_seen & t.is_positive(), t)
}

/// The same in a function of its own, for those who seldom ask.
#[inline(never)]
fn met_apart<S: Simd>(
    simd: S,
    setup: &PlaneSetup<S>,
    rays: &Rays<S>,
    asked: Mask64x16<S>,
) -> (Mask64x16<S>, F64x16<S>) {
    simd.vectorize(
        #[inline(always)]
        || met(setup, rays, asked),
    )
}

impl Triangle {
    /// The corners, from the one between the shorter edges on.
    pub(in crate::visibility) fn vertices(&self) -> [DVec3; 3] {
        self.vertices
    }

    pub(in crate::visibility) fn primitive(&self) -> Primitive {
        self.primitive
    }

    #[inline(always)]
    fn passed_through<S: Simd>(
        &self,
        simd: S,
        packet: &ShearedRays<S>,
        asked: u32,
    ) -> Mask64x16<S> {
        passes_through(simd, self.vertices, packet, asked)
    }

    /// L2: which of the rays in `asked`, by bits and by lanes, meet it at t above 0, and where; `None` if none does.
    #[inline(always)]
    pub(in crate::visibility) fn met_by<S: Simd>(
        &self,
        simd: S,
        packet: &ShearedRays<S>,
        bits: u32,
        asked: Mask64x16<S>,
    ) -> Option<(Mask64x16<S>, F64x16<S>)> {
        let passes = self.passed_through(simd, packet, bits) & asked;
        if !passes.any() {
            return None;
        }
        let [a, b, c] = self.vertices;
        let corners = [
            DVec3x16::splat(simd, a),
            DVec3x16::splat(simd, b),
            DVec3x16::splat(simd, c),
        ];
        let setup = PlaneSetup::new(corners, packet.rays.origin);
        let (is_met, t) = met_apart(simd, &setup, &packet.rays, passes);
        Some((passes & is_met, t))
    }

    #[inline]
    pub(in crate::visibility) fn new(primitive: Primitive, vertices: [DVec3; 3]) -> Self {
        let start = Turn::to_shorter_edges(vertices);
        Self {
            vertices: start.of(vertices),
            start,
            primitive,
        }
    }
}

/// Sixteen triangles or fewer, as projections take them. The triangles that they stand for are elsewhere.
#[derive(Clone, Debug)]
pub(in crate::visibility) struct TriangleBlock {
    leaf: LeafBlock,
    /// Those of the triangles in the world.
    numbers: [u32; LANES],
}

impl TriangleBlock {
    /// How much is read of it to set it up.
    pub(in crate::visibility) const BYTES: usize = size_of::<LeafBlock>();

    /// What f32 can tell of one ray and the triangles with a bit; `None` if it passes through none.
    #[inline(always)]
    pub(in crate::visibility) fn meet<S: Simd>(
        &self,
        simd: S,
        ray: &SingleRay,
        bits: u32,
    ) -> Option<BlockHits<S>> {
        self.leaf.meet(simd, ray, bits)
    }

    /// The number of a triangle in the order of all.
    #[inline(always)]
    pub(in crate::visibility) fn number(&self, place: usize) -> u32 {
        self.leaf.number + place as u32
    }
}

impl Block<Triangle> for TriangleBlock {
    type Setup = TriangleSetups;

    fn of(shapes: &[Triangle], first: u32) -> Self {
        let mut numbers = [0; LANES];
        let mut turns = Turns::default();
        for (place, shape) in shapes.iter().enumerate() {
            (_, numbers[place]) = shape.primitive.parts();
            turns.set(place, shape.start);
        }
        let objects = Objects::of(shapes.iter().map(|shape| shape.primitive.parts().0));
        let vertices = shapes.iter().map(Triangle::vertices);
        Self {
            leaf: LeafBlock::of(vertices, first, turns, objects),
            numbers,
        }
    }

    #[inline(always)]
    fn get(&self, world: &Arc<Triangles>, place: usize) -> Triangle {
        let start = self.leaf.turns.get(place);
        Triangle {
            vertices: world.vertices_from(self.numbers[place], start),
            start,
            primitive: self.primitive(place),
        }
    }

    #[inline(always)]
    fn primitive(&self, place: usize) -> Primitive {
        Primitive::triangle(self.leaf.objects.get(place), self.numbers[place])
    }

    #[inline(always)]
    fn near<S: Simd>(&self, simd: S, beam: &Beam) -> u32 {
        let [a, b, c] = self.leaf.corners(simd);
        let error = self.leaf.error();
        let center = beam.center();
        let (a, b, c) = (a.minus(center), b.minus(center), c.minus(center));
        let mut bits = u32::MAX;
        for plane in &beam.planes() {
            let (a, b, c) = (
                a.dot_with(plane.normal),
                b.dot_with(plane.normal),
                c.dot_with(plane.normal),
            );
            let offset = plane.offset - plane.size() * error;
            let reaches = a.max(b).max(c).ge(F64x16::splat(simd, offset));
            bits &= reaches.to_bits();
        }
        bits
    }

    #[inline(always)]
    fn touch(&self) {
        self.leaf.touch();
    }

    #[inline(always)]
    fn rasterize<S: Simd>(
        &self,
        simd: S,
        bits: u32,
        slot: u32,
        setups: &mut TriangleSetups,
        projection: &mut BatchProjection,
        depth_test: impl DepthTest,
    ) {
        depth_test.work(&mut projection.work).leaves += 1;
        if let Some(met) = &projection.met_leaves {
            let block = (slot - Triangle::SLOTS) as usize / LANES;
            met.meet(projection.origin_number, block);
        }
        setups.set_up(simd, projection, &self.leaf, bits);
        let id = |place: usize| ShapeId {
            slot: slot + place as u32,
            primitive: self.primitive(place),
        };
        let mut left = setups.of_interest;
        if projection.state != State::Projected {
            for place in ones(setups.of_interest) {
                let (cover, most) = (
                    setups.extents.cover(place),
                    setups.extents.most_within(place),
                );
                // A triangle does not hide its own points.
                let is_resolved = depth_test.are_all_on(id(place))
                    || depth_test.resolves_whole(projection, id(place), cover, most)
                    || !depth_test.ensure_projected(simd, projection);
                left &= !(u32::from(is_resolved) << place);
            }
        }
        if left != 0 {
            setups.rasterize(simd, left, id, projection, depth_test);
        }
    }
}

impl Shape for Triangle {
    type Block = TriangleBlock;

    type Exact = Arc<Triangles>;

    const WIDTH: usize = LANES;

    const SLOTS: u32 = TRIANGLES;

    fn bounds(&self) -> Bounds {
        let [a, b, c] = self.vertices;
        Bounds {
            min: a.min(b).min(c),
            max: a.max(b).max(c),
        }
    }

    #[inline(always)]
    fn intersect<S: Simd>(&self, simd: S, packet: &ShearedRays<S>, nearest: &mut NearestHit<S>) {
        if let Some((found, t)) = self.met_by(simd, packet, nearest.asked_bits, nearest.asked) {
            nearest.offer(simd, found, t, self.primitive);
        }
    }

    #[inline]
    fn is_beside(&self, projection: &BatchProjection) -> bool {
        projection.is_beside(self.vertices[0], area_vector(self.vertices))
    }

    /// L4: whether the triangle stands strictly between the start of the ray, a light, and the
    /// point at its end: they are on different sides of its plane, each further from it than its
    /// rounding error, and the ray passes through it. A triangle does not occlude itself.
    #[inline(always)]
    fn occlude<S: Simd>(&self, simd: S, packet: &ShearedRays<S>, occlusion: &mut Occlusion<'_, S>) {
        let passes = self.passed_through(simd, packet, occlusion.asked_bits) & occlusion.asked;
        if !passes.any() {
            return;
        }
        let normal = area_vector(self.vertices);
        let light = occlusion.light.0;
        let to_light = light - self.vertices[0];
        let light_height = normal.dot(to_light);
        let scale = normal.length();
        let light_error = ROUNDING * (to_light.length() + light.length());
        if light_height.abs() <= light_error * scale {
            return;
        }
        let points = occlusion.points;
        let to_point = points.position.minus(self.vertices[0]);
        let point_height = to_point.dot_with(normal);
        let beyond = if light_height > 0.0 {
            -point_height
        } else {
            point_height
        };
        // The sum of the components' magnitudes is at least the length.
        let length = to_point.taxicab();
        let is_clear = beyond.gt((points.error + length * ROUNDING) * scale);
        let is_own = points.primitive.eq(self.primitive.lanes(simd));
        occlusion.hide(passes & is_clear & !is_own);
    }
}

/// Sixteen triangles' corners side by side.
#[inline(always)]
pub(in crate::visibility) fn side_by_side<S: Simd>(
    simd: S,
    bits: u32,
    corners: impl Fn(usize) -> [DVec3; 3],
) -> [DVec3x16<S>; 3] {
    let mut columns = [[0.0; LANES]; 9];
    for lane in ones(bits) {
        let [a, b, c] = corners(lane);
        columns[0][lane] = a.x;
        columns[1][lane] = a.y;
        columns[2][lane] = a.z;
        columns[3][lane] = b.x;
        columns[4][lane] = b.y;
        columns[5][lane] = b.z;
        columns[6][lane] = c.x;
        columns[7][lane] = c.y;
        columns[8][lane] = c.z;
    }
    let [ax, ay, az, bx, by, bz, cx, cy, cz] = &columns;
    [
        DVec3x16::load(simd, [ax, ay, az]),
        DVec3x16::load(simd, [bx, by, bz]),
        DVec3x16::load(simd, [cx, cy, cz]),
    ]
}
