//! Rays of a batch that start at one point, as samples on a plane before it: a projection.
//!
//! Seen from the point that they share, every shape covers a part of the plane, and whether a ray meets the shape
//! is whether its sample is within that part. On the projection d = x u + y v + w the edges of a triangle
//! are three affine functions of x and y, the reciprocal of the depth of a plane is another, and a
//! sphere has a quadratic one. They are set up once for all rays of the batch, in f64, and evaluated in
//! f32, two fused multiply-adds each.
//!
//! The f32 decides only what is certain: every number comes with a bound on its error, and a ray for
//! which the bound does not tell is *ambiguous*. It falls back to f64, alone with its packet, in
//! the way of [`super::packet`]. So the projection decides how long an image takes, and not one of its bits.

mod affine;
mod depth_test;
mod extent;
mod fragments;
mod parallel;
mod sample_grid;

use std::sync::Arc;

use fearless_simd::Simd;

use super::batch::{BATCH, Floats, PACKETS, Row, longest};
use super::primitive::ShapeId;
use super::work::{MetLeaves, Work};
use crate::math::{DVec3, all_three, both};
use crate::simd::{DVec3x16, F32x16, LANES, Mask32x16, U32x16, smallest_of_each};
pub(in crate::visibility) use affine::Affine;
pub(in crate::visibility) use depth_test::{DepthTest, NearestHitTest, OcclusionTest};
pub(in crate::visibility) use extent::{Extent, Extents};
pub(in crate::visibility) use fragments::Fragments;
use sample_grid::SampleGrid;

/// The bound on the error of an affine or quadratic function of x and y, over the sum of the magnitudes
/// of its terms: the rounding of coefficients, of x and y, and of the operations to f32, 2⁻²⁴ each, at
/// most fourteen, and what the set-up in f64 leaves.
pub(in crate::visibility) const POLYNOMIAL_ERROR: f32 = 1.0 / (1 << 20) as f32;

/// What an f64 may be off, relative to what it is compared with, to be as good as exact in f32.
pub(in crate::visibility) const NEGLIGIBLE: f64 = 1.0 / (1 << 25) as f64;

/// How much a corner's place on the projection is off by the rounding of its offset in f64, times the size of the
/// offset over its depth: eight roundings of 2⁻⁵³, and eight times that.
pub(in crate::visibility) const NOISE: f32 = 1.0 / (1_u64 << 47) as f32;

/// Rays all closer together than this, as a tangent, do not go on a projection: f64 places shapes no better.
const NARROWEST: f32 = 1.0 / (1 << 26) as f32;

/// Rays whose depth is less than this part of the largest do not go on one projection: f32 would end.
const SHALLOWEST: f32 = 1e-30;

/// A box that reaches back to less than this part of its distance does not bound a projection.
const SHALLOWEST_BOX: f64 = 1.0 / 8.0;

/// Rays further from the middle than this, as a tangent, do not go on one projection.
const WIDEST: f32 = 2.0;

/// Shapes whose reciprocal depth is beyond this, or its reciprocal, are not told from f32; ends may be.
pub(in crate::visibility) const RECIPROCAL_DEPTH_LIMIT: f64 = 1e30;
const END_RECIPROCAL_DEPTH_LIMIT: f32 = 1e37;

/// From so many triangles on, it is worth to know which rays are where.
const MANY: u32 = 64;

/// Before so many triangles a projection gives way to packets, for which a tree is nearly as deep whatever it
/// holds. An estimate: about 1 µs a ray there, and about 0.05 µs a triangle here. (Tests have fewer triangles.)
const TOO_MANY: u32 = if cfg!(test) { 1 << 10 } else { 1 << 13 };

/// The least and the largest x and y of no ray.
const NOWHERE: [f32; 4] = [
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::INFINITY,
    f32::NEG_INFINITY,
];

/// No shape.
pub(in crate::visibility) const NOTHING: u32 = u32::MAX;

/// The projection of a batch: its samples, and what is known of each.
#[derive(Debug)]
pub(in crate::visibility) struct BatchProjection {
    pub(in crate::visibility) shared: Shared,
    /// Where all rays start; or, of parallel rays, a point amid them.
    pub(in crate::visibility) origin: DVec3,
    /// u, v and w, orthonormal; w is the middle of the rays.
    pub(in crate::visibility) axes: [DVec3; 3],
    /// The same in f32.
    pub(in crate::visibility) orientation: [[f32; 3]; 3],
    /// The least and the largest x and y of all rays.
    pub(in crate::visibility) bounds: [f32; 4],
    /// The least reciprocal depth that is of interest to any ray, or less.
    pub(in crate::visibility) farthest: f32,
    /// The largest |x| and the largest |y| of any ray.
    pub(in crate::visibility) extent: [f64; 2],
    /// The reciprocal depth is this over the depth along w; see [`Shared`] for parallel rays.
    pub(in crate::visibility) unit: f64,
    /// A box around the ends of shadow rays, relative to the origin.
    pub(in crate::visibility) ends: Option<[DVec3; 2]>,
    /// How far the origin or the ends of the rays may be from where they should be.
    pub(in crate::visibility) error: f64,
    /// Whether some of the ends are points of spheres seen from within.
    pub(in crate::visibility) has_points_within: bool,
    pub(in crate::visibility) state: State,
    /// Of a projection bounded by what primary rays see the first shape so far, and of one bounded by the ends
    /// of rays the largest reciprocal depth of these.
    pub(in crate::visibility) cover: Option<Cover>,
    pub(in crate::visibility) nearest_end: f32,
    x: Floats,
    y: Floats,
    /// The range of the reciprocal depth of what is known of a ray: of a primary ray its nearest hit, the
    /// reciprocal depth of the infinitely far where there is none; of a shadow ray its end, infinite where that
    /// is known to be dark.
    pub(in crate::visibility) least: Floats,
    pub(in crate::visibility) most: Floats,
    /// What a primary ray meets first.
    pub(in crate::visibility) slots: [u32; BATCH],
    /// For each packet a bit for each ray that f32 cannot decide: unless something nearer hides it, or
    /// in any case.
    pub(in crate::visibility) ambiguous: [u32; PACKETS],
    pub(in crate::visibility) unresolved: [u32; PACKETS],
    /// The least and the largest x and y of each packet.
    boxes: [Row; 4],
    /// The least reciprocal depth that is of interest to any ray of each packet.
    pub(in crate::visibility) far: Row,
    /// For each packet one bit for each ray.
    asked: [u32; PACKETS],
    /// How many triangles were near any ray, and from [`MANY`] on where the rays are.
    drawn: u32,
    grid: SampleGrid,
    /// What was done for this batch and those before it.
    pub(in crate::visibility) work: Work,
    /// Where it is noted which leaves are met, if anybody asks; by the number of the origin, 0 for the eye.
    pub(in crate::visibility) met_leaves: Option<Arc<MetLeaves>>,
    pub(in crate::visibility) origin_number: usize,
}

/// What the rays on a projection share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::visibility) enum Shared {
    /// The point that they start at: the projection's origin.
    Point,
    /// The direction w. Their samples are how far along u and v they are beside the origin, over the unit; the
    /// reciprocal depth of what they meet is minus its depth along w from there, over the unit.
    Direction(Start),
}

/// Where parallel rays start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::visibility) struct Start {
    /// At which depth along w, from the origin. The light of a sun comes from infinitely far away; its depths
    /// count from the origin.
    pub(in crate::visibility) depth: f64,
    /// Between which reciprocal depths, all rounding included; both infinite for a sun.
    pub(in crate::visibility) reciprocal_depth: [f32; 2],
    /// At least how far along w the starts of a camera's rays, or the ends of a sun's, are from the origin.
    pub(in crate::visibility) distance: f64,
}

impl Start {
    /// The light of a sun, whose segments end no further than `distance` from the origin along w.
    const fn endless(distance: f64) -> Self {
        Self {
            depth: 0.0,
            reciprocal_depth: [f32::INFINITY; 2],
            distance,
        }
    }

    /// Whether it is infinitely far away.
    fn is_endless(self) -> bool {
        let [ahead, _] = self.reciprocal_depth;
        ahead == f32::INFINITY
    }

    /// What is less deep than this along w is behind it.
    #[inline]
    pub(in crate::visibility) fn nearest(self) -> f64 {
        if self.is_endless() {
            f64::NEG_INFINITY
        } else {
            self.depth
        }
    }
}

/// How much is known of a projection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::visibility) enum State {
    /// A box around the rays' ends, so that shapes beside the way to it are told.
    Bounded,
    /// Bounded, and one shape is before all of the box: no light gets there.
    Occluded,
    /// Bounded, but more than one shape may be what is seen first.
    Overlapping,
    /// Every ray.
    Projected,
    /// The rays are not for a projection.
    Unfit,
}

/// A shape that all rays on a projection meet, without any of them.
#[derive(Clone, Copy, Debug)]
pub(in crate::visibility) struct Cover {
    slot: u32,
    /// Between which reciprocal depths.
    pub(in crate::visibility) range: [f32; 2],
}

impl Default for BatchProjection {
    fn default() -> Self {
        let floats = Floats([0.0; BATCH]);
        let row = Row([0.0; LANES]);
        Self {
            shared: Shared::Point,
            origin: DVec3::ZERO,
            axes: [DVec3::X, DVec3::Y, DVec3::Z],
            orientation: [[0.0; 3]; 3],
            bounds: [0.0; 4],
            farthest: 0.0,
            extent: [0.0; 2],
            unit: 1.0,
            ends: None,
            error: 0.0,
            has_points_within: false,
            state: State::Unfit,
            cover: None,
            nearest_end: 0.0,
            x: floats,
            y: floats,
            least: floats,
            most: floats,
            slots: [NOTHING; BATCH],
            ambiguous: [0; PACKETS],
            unresolved: [0; PACKETS],
            boxes: [row; 4],
            far: row,
            asked: [0; PACKETS],
            drawn: 0,
            grid: SampleGrid::default(),
            work: Work::default(),
            met_leaves: None,
            origin_number: 0,
        }
    }
}

impl BatchProjection {
    /// Orients the projection to a box around the ends of rays from one point, given as offsets from there;
    /// whether it is anywhere.
    pub(in crate::visibility) fn orient_to_ends(
        &mut self,
        origin: DVec3,
        [least, most]: [DVec3; 2],
    ) -> bool {
        self.ends = Some([least, most]);
        self.unit = longest(&[least, most]);
        self.state = State::Unfit;
        self.orient_to(origin, least * 0.5 + most * 0.5)
    }

    /// Bounds a projection that is oriented to the ends of rays by the box around them, so that shapes that are
    /// not on the way there are told without any ray; whether it can.
    #[inline]
    pub(in crate::visibility) fn bound(&mut self) -> bool {
        let Some([least, most]) = self.ends else {
            return false;
        };
        let [u, v, w] = self.axes;
        let half = most * 0.5 - least * 0.5;
        let [x, y, z] = all_three([u, v, w], |axis| axis.abs().dot(half));
        let middle = w.dot(least * 0.5 + most * 0.5);
        let (shallowest, deepest) = (middle - z, middle + z);
        let over = 1.0 / shallowest;
        let [x, y] = [(x * over) as f32, (y * over) as f32];
        self.bounds = [-x, x, -y, y];
        self.farthest = (self.unit / deepest) as f32 * (1.0 - 2.0 * POLYNOMIAL_ERROR);
        self.nearest_end = (self.unit / shallowest) as f32 * (1.0 + 2.0 * POLYNOMIAL_ERROR);
        let is_before = shallowest > self.unit * SHALLOWEST_BOX && deepest.is_finite();
        if is_before && self.is_fit() {
            self.state = State::Bounded;
        }
        self.state == State::Bounded
    }

    /// Bounds the projection by what rays from one point see that are between these directions; whether it can.
    pub(in crate::visibility) fn bound_between(
        &mut self,
        origin: DVec3,
        directions: [DVec3; 4],
    ) -> bool {
        (self.error, self.ends) = (0.0, None);
        (self.state, self.cover, self.farthest) = (State::Unfit, None, 0.0);
        if !self.orient_to(origin, directions.iter().sum()) {
            return false;
        }
        let [u, v, w] = self.axes;
        let mut bounds = NOWHERE;
        for direction in directions {
            let over_depth = 1.0 / direction.dot(w);
            let sample = both([u, v], |axis| (direction.dot(axis) * over_depth) as f32);
            for axis in 0..2 {
                bounds[2 * axis] = bounds[2 * axis].min(sample[axis]);
                bounds[2 * axis + 1] = bounds[2 * axis + 1].max(sample[axis]);
            }
        }
        self.bounds = bounds;
        let are_before = directions.iter().all(|direction| direction.dot(w) > 0.0);
        if are_before && self.is_fit() {
            self.state = State::Bounded;
        }
        self.state == State::Bounded
    }

    /// Takes a shape to be what all rays see first, as far as is known.
    #[inline]
    pub(in crate::visibility) fn cover_with(&mut self, id: ShapeId, range: [f32; 2]) {
        self.cover = Some(Cover {
            slot: id.slot,
            range,
        });
        [self.farthest, _] = range;
    }

    /// Has no interest in shapes any more.
    pub(in crate::visibility) fn close(&mut self, state: State) {
        self.state = state;
        self.bounds = NOWHERE;
        self.farthest = f32::INFINITY;
    }

    /// Resolves all rays at once: they see what was found while there were only bounds.
    pub(in crate::visibility) fn resolve_whole(&mut self) {
        let slot = self.cover.map_or(NOTHING, |cover| cover.slot);
        self.slots.fill(slot);
        (self.ambiguous, self.unresolved) = ([0; PACKETS], [0; PACKETS]);
    }

    /// Orients the projection to a direction from its origin; whether that is one.
    #[inline]
    fn orient_to(&mut self, origin: DVec3, direction: DVec3) -> bool {
        let Some(w) = direction.try_normalize() else {
            return false;
        };
        let (u, v) = w.any_orthonormal_pair();
        self.shared = Shared::Point;
        (self.origin, self.axes) = (origin, [u, v, w]);
        self.orientation = all_three(self.axes, |axis| axis.as_vec3().to_array());
        true
    }

    /// Makes the largest |x| and |y| from the bounds; whether f32 will do for them.
    #[inline]
    fn is_fit(&mut self) -> bool {
        let [left, right, bottom, top] = self.bounds;
        self.extent = [f64::from(right.max(-left)), f64::from(top.max(-bottom))];
        let widest = right.max(-left).max(top).max(-bottom);
        (NARROWEST..WIDEST).contains(&widest)
    }

    /// Projects rays from one point, around the direction `middle`, that end nowhere;
    /// those with a bit.
    #[inline(always)]
    pub(in crate::visibility) fn project_around<S: Simd>(
        &mut self,
        simd: S,
        origin: DVec3,
        middle: DVec3,
        asked: &[u32; PACKETS],
        direction: impl Fn(usize) -> DVec3x16<S>,
    ) {
        (self.error, self.ends) = (0.0, None);
        self.state = State::Unfit;
        if self.orient_to(origin, middle) {
            self.project_over(simd, 1.0 / middle.length(), asked, direction);
        }
    }

    /// Projects the rays of a projection that is oriented to the box around their ends, those with a bit: o + ω.
    #[inline(always)]
    pub(in crate::visibility) fn project<S: Simd>(
        &mut self,
        simd: S,
        asked: &[u32; PACKETS],
        offset: impl Fn(usize) -> DVec3x16<S>,
    ) {
        self.project_over(simd, 1.0 / self.unit, asked, offset);
    }

    #[inline(always)]
    fn project_over<S: Simd>(
        &mut self,
        simd: S,
        scale: f64,
        asked: &[u32; PACKETS],
        direction: impl Fn(usize) -> DVec3x16<S>,
    ) {
        let have_ends = self.ends.is_some();
        (self.asked, self.drawn) = (*asked, 0);
        let [u, v, w] = self.axes;
        let infinite = F32x16::splat(simd, f32::INFINITY);
        let one = F32x16::splat(simd, 1.0);
        let zero = F32x16::splat(simd, 0.0);
        let endless = F32x16::splat(simd, self.endless());
        let mut shallowest = infinite;
        let mut sides = [[infinite; PACKETS]; 4];
        let mut far = [infinite; PACKETS];
        for packet in 0..PACKETS {
            let first = packet * LANES;
            let bits = asked[packet];
            (self.ambiguous[packet], self.unresolved[packet]) = (0, 0);
            if bits == 0 {
                // Shapes that are anywhere are shown to these rays as well.
                infinite.store(&mut self.least.0[first..]);
                infinite.store(&mut self.most.0[first..]);
                continue;
            }
            let direction = direction(packet);
            let is_asked = Mask32x16::from_bits(simd, bits);
            // In units of the largest, which are far from the ends of f32.
            let depth = (direction.dot_with(w) * scale).narrowed(simd);
            shallowest = is_asked.select(depth, infinite).min(shallowest);
            let inverse = one / depth;
            let x = (direction.dot_with(u) * scale).narrowed(simd) * inverse;
            let y = (direction.dot_with(v) * scale).narrowed(simd) * inverse;
            x.store(&mut self.x.0[first..]);
            y.store(&mut self.y.0[first..]);
            sides[0][packet] = is_asked.select(x, infinite);
            sides[1][packet] = is_asked.select(zero - x, infinite);
            sides[2][packet] = is_asked.select(y, infinite);
            sides[3][packet] = is_asked.select(zero - y, infinite);
            let (least, most) = if have_ends {
                let reciprocal_depth = inverse.min(F32x16::splat(simd, END_RECIPROCAL_DEPTH_LIMIT));
                (
                    reciprocal_depth * F32x16::splat(simd, 1.0 - POLYNOMIAL_ERROR),
                    reciprocal_depth * F32x16::splat(simd, 1.0 + POLYNOMIAL_ERROR),
                )
            } else {
                U32x16::splat(simd, NOTHING).store(&mut self.slots[first..]);
                (endless, endless)
            };
            far[packet] = is_asked.select(least, infinite);
            far[packet].store(&mut self.least.0[first..]);
            is_asked
                .select(most, infinite)
                .store(&mut self.most.0[first..]);
        }
        let [left, right, bottom, top] = sides;
        smallest_of_each(left).store(&mut self.boxes[0].0);
        (zero - smallest_of_each(right)).store(&mut self.boxes[1].0);
        smallest_of_each(bottom).store(&mut self.boxes[2].0);
        (zero - smallest_of_each(top)).store(&mut self.boxes[3].0);
        smallest_of_each(far).store(&mut self.far.0);
        self.bounds = [
            F32x16::load(simd, &self.boxes[0].0).smallest(),
            F32x16::load(simd, &self.boxes[1].0).largest(),
            F32x16::load(simd, &self.boxes[2].0).smallest(),
            F32x16::load(simd, &self.boxes[3].0).largest(),
        ];
        // Listed shapes come before any look, and must not meet what was left of the projection before.
        self.farthest = F32x16::load(simd, &self.far.0).smallest();
        self.state = if self.is_fit() && shallowest.smallest() > SHALLOWEST {
            State::Projected
        } else {
            State::Unfit
        };
    }

    /// Whether the origin and the ends of all rays are on one side of a plane, which is clear of them.
    #[inline]
    pub(in crate::visibility) fn is_beside(&self, point: DVec3, normal: DVec3) -> bool {
        let Some([least, most]) = self.ends else {
            return false;
        };
        let height = normal.dot(point - self.origin);
        let towards = if height > 0.0 { normal } else { -normal };
        let nearest = (towards * least).max(towards * most);
        let rounding = towards.abs().dot(least.abs().max(most.abs())) + height.abs();
        let room = rounding * NEGLIGIBLE + normal.length() * self.error / NEGLIGIBLE;
        nearest.element_sum() + room < height.abs()
    }

    /// Which rays are where, once more than a few triangles have come near them; with `count` more.
    #[inline(always)]
    pub(in crate::visibility) fn sample_grid<S: Simd>(
        &mut self,
        simd: S,
        count: u32,
    ) -> Option<&SampleGrid> {
        if self.state != State::Projected {
            return None;
        }
        let before = self.drawn;
        self.drawn += count;
        if self.drawn < MANY {
            return None;
        }
        if before < MANY {
            let places = [&self.x.0, &self.y.0];
            self.grid.fill(simd, self.bounds, places, &self.asked);
        }
        Some(&self.grid)
    }

    /// The rectangle around all rays, with what f32 takes away.
    #[inline]
    pub(in crate::visibility) fn rectangle(&self) -> [f64; 4] {
        let [left, right, bottom, top] = self.bounds;
        let [give_x, give_y] = both(self.extent, |extent| extent * f64::from(POLYNOMIAL_ERROR));
        [
            f64::from(left) - give_x,
            f64::from(right) + give_x,
            f64::from(bottom) - give_y,
            f64::from(top) + give_y,
        ]
    }

    /// Whether there are so many triangles before it that its rays had better go in packets, which those then do
    /// that still ask for something.
    #[inline(always)]
    pub(in crate::visibility) fn gives_up<S: Simd>(&mut self, simd: S) -> bool {
        let gives_up = self.state == State::Projected && self.drawn >= TOO_MANY;
        if gives_up {
            for packet in 0..PACKETS {
                self.unresolved[packet] |= self.asking(simd, packet).to_bits();
            }
        }
        gives_up
    }

    /// Looks how far it goes; the largest depth along w, from where rays start, that is of interest to any.
    #[inline(always)]
    pub(in crate::visibility) fn look<S: Simd>(&mut self, simd: S) -> f64 {
        if self.state == State::Projected {
            self.farthest = F32x16::load(simd, &self.far.0).smallest();
        }
        match self.shared {
            Shared::Point => self.unit / f64::from(self.farthest),
            Shared::Direction(start) => -f64::from(self.farthest) * self.unit - start.depth,
        }
    }

    /// Whether shapes of these least and largest x and y and largest reciprocal depths may be of interest to
    /// any ray.
    #[inline(always)]
    pub(in crate::visibility) fn is_of_interest<S: Simd>(
        &self,
        simd: S,
        [left, right, bottom, top]: [F32x16<S>; 4],
        most: F32x16<S>,
    ) -> Mask32x16<S> {
        let [all_left, all_right, all_bottom, all_top] = self.bounds;
        left.le(F32x16::splat(simd, all_right))
            & right.ge(F32x16::splat(simd, all_left))
            & bottom.le(F32x16::splat(simd, all_top))
            & top.ge(F32x16::splat(simd, all_bottom))
            & most.ge(F32x16::splat(simd, self.farthest))
    }

    /// One bit for each packet that a shape of this extent may be of interest to.
    #[inline(always)]
    pub(in crate::visibility) fn meets<S: Simd>(&self, simd: S, extent: &Extent) -> u32 {
        let [left, right, bottom, top] = &self.boxes;
        let meets = F32x16::load(simd, &left.0).le(F32x16::splat(simd, extent.x[1]))
            & F32x16::load(simd, &right.0).ge(F32x16::splat(simd, extent.x[0]))
            & F32x16::load(simd, &bottom.0).le(F32x16::splat(simd, extent.y[1]))
            & F32x16::load(simd, &top.0).ge(F32x16::splat(simd, extent.y[0]))
            & F32x16::load(simd, &self.far.0).le(F32x16::splat(simd, extent.most));
        meets.to_bits()
    }

    /// x and y of the rays of a packet.
    #[inline(always)]
    pub(in crate::visibility) fn samples<S: Simd>(&self, simd: S, packet: usize) -> [F32x16<S>; 2] {
        let first = packet * LANES;
        [
            F32x16::load(simd, &self.x.0[first..]),
            F32x16::load(simd, &self.y.0[first..]),
        ]
    }

    /// For each packet a bit for each ray that falls back to f64.
    #[inline]
    pub(in crate::visibility) fn falls_back(&self, packet: usize) -> u32 {
        self.ambiguous[packet] | self.unresolved[packet]
    }

    /// One bit for each primary ray of a packet that is known to meet something.
    #[inline(always)]
    pub(in crate::visibility) fn found<S: Simd>(&self, simd: S, packet: usize) -> u32 {
        U32x16::load(simd, self.nearest_slots(packet))
            .lt(U32x16::splat(simd, NOTHING))
            .to_bits()
    }

    /// What the primary rays of a packet meet first, [`NOTHING`] where they meet nothing; except for
    /// those that fall back to f64.
    #[inline]
    pub(in crate::visibility) fn nearest_slots(&self, packet: usize) -> &[u32] {
        &self.slots[packet * LANES..(packet + 1) * LANES]
    }

    /// Whether what is met at these reciprocal depths is of interest to the rays of a packet.
    #[inline(always)]
    pub(in crate::visibility) fn concerns<S: Simd>(
        &self,
        simd: S,
        packet: usize,
        reciprocal_depth: F32x16<S>,
    ) -> Mask32x16<S> {
        reciprocal_depth.ge(F32x16::load(simd, &self.least.0[packet * LANES..]))
    }

    /// One bit for each shadow ray of a packet whose end is not known to be dark.
    #[inline(always)]
    pub(in crate::visibility) fn reached<S: Simd>(&self, simd: S, packet: usize) -> u32 {
        self.asking(simd, packet).to_bits()
    }

    /// The rays of a packet that still ask for something.
    #[inline(always)]
    pub(in crate::visibility) fn asking<S: Simd>(&self, simd: S, packet: usize) -> Mask32x16<S> {
        let least = F32x16::load(simd, &self.least.0[packet * LANES..]);
        !least.ge(F32x16::splat(simd, f32::INFINITY))
    }
}
