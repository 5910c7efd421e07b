//! What a camera ray sees (L2) and what a light reaches (L4).
//!
//! Rays come in batches that share something: the primary rays of a few pixels share the eye or a
//! direction, the shadow rays to a point light share the light. All is asked here in such batches and
//! answered for the whole batch: by a projection from the point that its rays share, which decides in
//! f32 what is certain, and for the few rays that are left in packets of sixteen, in f64. Each kind of
//! shape is searched on its own, through a list or a tree as the [`Plan`] says.
//!
//! Every number of a point is computed in f64. The tree's boxes are f32 and conservative, and ties are
//! settled by the order of the scene file: the picture depends neither on the tree, nor on which rays
//! are asked together, nor on the instruction set.
//!
//! On floors, of which each uses only those before it:
//! 1. `batch`, `primitive`: the columns of a batch; which shape it is.
//! 2. `rays`, `question`: the rays of a packet, what they ask, and what is known of the answer.
//! 3. `tree`: a bounding volume hierarchy and the beams that go down it. It knows boxes, not shapes.
//! 4. `projection`: the samples of a batch on a plane, and the depth test that fragments pass there.
//! 5. `shape`: spheres, triangles and planes, each with its set-up before a projection and its test in f64.
//! 6. `packet`: how a packet goes down a tree and puts its question to shapes.
//! 7. `search`, `shapes`: all shapes of a kind, and all of a world.
//! 8. `points`, and here: the answers.

mod batch;
mod incoherent;
mod packet;
mod points;
mod primitive;
mod projection;
mod question;
mod rays;
mod search;
#[cfg_attr(
    not(test),
    expect(dead_code, reason = "lights with a size and error targets are to ask")
)]
mod shaft;
mod shape;
mod shapes;
mod tree;

#[cfg(test)]
mod tests;

use fearless_simd::Simd;

pub(crate) use batch::{BATCH, PACKETS};
pub(crate) use batch::{Column, columns};
pub(crate) use incoherent::{Candidates, Hits, RayBatch, SegmentBatch};
pub(crate) use points::Facing;
pub(crate) use points::Points;

use crate::camera::{Camera, Projection};
use crate::math::{DVec3, Point, both};
use crate::memory::{self, OutOfMemory};
use crate::simd::{DVec3x16, F64x16, LANES};
use crate::world::{Plan, World};
use batch::{first_lanes, longest, offsets, ranges};
use points::{Known, Only};
use projection::{BatchProjection, NearestHitTest, OcclusionTest, State};
use question::NearestHit;
use rays::{ROUNDING, Rays};
use shapes::{Parts, Segments, Setups, Shapes};
use tree::{EMPTY_STACK, Stack};

/// Rays whose directions differ by more than this part of their length do not share a projection: at a
/// silhouette, points of the object and points far behind it would be enclosed in one beam.
const MOST_SPREAD: f64 = 1.0 / 16.0;

/// So many shapes are soon told, whatever is enclosed: rays that share a projection may then differ as much as
/// [`MOST_SPREAD_AMID_FEW`].
const FEW_SHAPES: usize = 64;
const MOST_SPREAD_AMID_FEW: f64 = 1.0;

/// What building a tree takes for each shape, at most; a test measures it.
const BYTES_OF_TRIANGLE: u64 = 260;
const BYTES_OF_SPHERE: u64 = 130;

/// Fewer rays than this are not worth a projection.
const FEW: u32 = 8;

/// A world and its shapes, as rays ask them.
#[derive(Debug)]
pub(crate) struct Visibility<'w> {
    shapes: Shapes<'w>,
    /// What they were put together from.
    parts: Parts,
    is_smooth: bool,
    /// A point amid the shapes.
    somewhere: DVec3,
    /// Whether there are no more than [`FEW_SHAPES`].
    are_few: bool,
    /// How much the directions of rays on one projection may differ, as a part of their length.
    most_spread: f64,
    /// Whether projections decide what they can, as they do but in tests.
    uses_projection: bool,
}

/// Points of the image of a camera whose primary rays are traced together, in pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Samples<'s> {
    pub(crate) camera: &'s Camera,
    /// x and y of each.
    pub(crate) places: [&'s Column; 2],
    pub(crate) count: usize,
    /// The least and the largest x, and the least and the largest y.
    pub(crate) window: [[f64; 2]; 2],
}

impl Samples<'_> {
    /// What differs among the primary rays of a packet: their directions, of an orthographic camera where they
    /// start.
    #[inline(always)]
    fn varying<S: Simd>(&self, simd: S, packet: usize) -> DVec3x16<S> {
        let [x, y] = self.places;
        let first = packet * LANES;
        let x = F64x16::load(simd, &x[first..]);
        self.camera
            .varying(simd, x, F64x16::load(simd, &y[first..]))
    }

    /// Projects the primary rays of the packets' samples with a bit; `somewhere` is amid the
    /// shapes.
    #[inline(always)]
    fn project<S: Simd>(
        &self,
        simd: S,
        somewhere: DVec3,
        asked: &[u32; PACKETS],
        projection: &mut BatchProjection,
    ) {
        let camera = self.camera;
        match camera.projection() {
            Projection::Perspective { .. } => {
                let [x, y] = both(self.places, |places| places[self.count / 2]);
                projection.project_around(
                    simd,
                    camera.eye().0,
                    camera.ray(x, y).direction,
                    asked,
                    #[inline(always)]
                    |packet| self.varying(simd, packet),
                );
            }
            Projection::Orthographic { .. } => {
                projection.project_along(
                    simd,
                    camera.eye().0,
                    camera.forward().get(),
                    somewhere,
                    asked,
                    #[inline(always)]
                    |packet| self.varying(simd, packet),
                );
            }
        }
    }

    /// The directions of the primary rays around all of them.
    fn corners(&self) -> [DVec3; 4] {
        let camera = self.camera;
        let [[left, right], [top, bottom]] = self.window;
        let direction = |x, y| camera.ray(x, y).direction;
        [
            direction(left, top),
            direction(right, top),
            direction(left, bottom),
            direction(right, bottom),
        ]
    }
}

/// What a thread needs to trace batches, to be used again and again.
#[derive(Debug)]
pub(crate) struct Workspace {
    projection: BatchProjection,
    setups: Setups,
    stack: Box<Stack>,
    /// Groups of points that are still to be asked for a light.
    groups: Vec<[u32; PACKETS]>,
}

impl Default for Workspace {
    fn default() -> Self {
        Self {
            projection: BatchProjection::default(),
            setups: Setups::default(),
            stack: Box::new(EMPTY_STACK),
            groups: Vec::new(),
        }
    }
}

impl<'w> Visibility<'w> {
    /// Arranges the shapes of a world as its plan says; builds the trees.
    pub(crate) fn new(world: &'w World, plan: &Plan) -> Self {
        Self::of(world, Parts::new(world, plan, None))
    }

    /// The shapes of another world, with the trees of those that are where they were.
    ///
    /// # Errors
    /// If there is not as much memory as all of it takes.
    pub(crate) fn again<'v>(
        &self,
        world: &'v World,
        plan: &Plan,
    ) -> Result<Visibility<'v>, OutOfMemory> {
        Self::look_for_memory(world)?;
        let kept = (self.shapes.world, &self.parts);
        Ok(Visibility::of(world, Parts::new(world, plan, Some(kept))))
    }

    /// How many trees were built for it: none for what was kept.
    pub(crate) fn trees_built(&self) -> usize {
        self.parts.built()
    }

    /// A world and the parts that were built of it.
    fn of(world: &'w World, parts: Parts) -> Self {
        let shapes = Shapes::of(world, &parts);
        let meshes = world.triangles().meshes();
        let count = world.triangles().len() + world.spheres().len();
        Self {
            somewhere: shapes.somewhere(),
            shapes,
            parts,
            is_smooth: meshes.iter().any(|mesh| mesh.normals.is_some()),
            are_few: count <= FEW_SHAPES,
            most_spread: if count <= FEW_SHAPES {
                MOST_SPREAD_AMID_FEW
            } else {
                MOST_SPREAD
            },
            uses_projection: true,
        }
    }

    /// [`Visibility::new`], if there is as much memory as it takes.
    ///
    /// # Errors
    /// If there is not.
    pub(crate) fn try_new(world: &'w World, plan: &Plan) -> Result<Self, OutOfMemory> {
        Self::look_for_memory(world)?;
        Ok(Self::new(world, plan))
    }

    fn look_for_memory(world: &World) -> Result<(), OutOfMemory> {
        let needed = memory::look_for(Self::memory_needed(world));
        needed.map_err(|error| error.for_what("building the trees over all shapes"))
    }

    /// About how many bytes [`Visibility::new`] takes at once, of which it keeps about half.
    pub(crate) fn memory_needed(world: &World) -> u64 {
        let triangles = world.triangles().len() as u64;
        let spheres = world.spheres().len() as u64;
        triangles * BYTES_OF_TRIANGLE + spheres * BYTES_OF_SPHERE
    }

    /// L1 and L2: the points that the primary rays through points of the image hit.
    #[inline(never)]
    pub(crate) fn see<S: Simd>(
        &self,
        simd: S,
        samples: Samples<'_>,
        space: &mut Workspace,
        points: &mut Points,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.see_all(simd, samples, space, points),
        );
    }

    #[inline(always)]
    fn see_all<S: Simd>(
        &self,
        simd: S,
        samples: Samples<'_>,
        space: &mut Workspace,
        points: &mut Points,
    ) {
        let Samples { camera, count, .. } = samples;
        let Workspace {
            projection,
            setups,
            stack,
            ..
        } = space;
        let (eye, forward) = (camera.eye(), camera.forward().get());
        let is_perspective = matches!(camera.projection(), Projection::Perspective { .. });
        let mut asked = [0; PACKETS];
        for (packet, bits) in asked.iter_mut().enumerate() {
            *bits = first_lanes(count, packet);
        }
        let is_projected = self.uses_projection && {
            let distance = (self.somewhere - eye.0).length();
            projection.unit = if distance > 0.0 { distance } else { 1.0 };
            // What one batch sees, the next one mostly does.
            let may_resolve_whole = self.are_few || points.only != Only::Many;
            let is_bounded = is_perspective
                && may_resolve_whole
                && projection.bound_between(eye.0, samples.corners());
            if is_bounded {
                self.shapes
                    .rasterize(simd, projection, setups, stack, NearestHitTest);
            }
            if is_bounded && projection.state == State::Bounded {
                projection.resolve_whole();
            } else {
                samples.project(simd, self.somewhere, &asked, projection);
                if projection.state == State::Projected {
                    self.shapes
                        .rasterize(simd, projection, setups, stack, NearestHitTest);
                }
            }
            projection.state != State::Unfit
        };
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
            let known = bits & !fallback;
            if fallback == 0 && projection.found(simd, packet) & known == 0 {
                points.hit[packet] = 0;
                continue;
            }
            let varying = samples.varying(simd, packet);
            let rays = if is_perspective {
                Rays::from_point(simd, eye, varying)
            } else {
                Rays::new(varying, DVec3x16::splat(simd, forward), None)
            };
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
            if self.is_smooth {
                points.interpolate(simd, self.shapes.world, packet, &rays);
            }
        }
        points.end(simd);
    }

    /// L4: which of the points with a bit in `facing` the light reaches. Asked only of points that it is
    /// [above of](Points::facing).
    #[inline(never)]
    pub(crate) fn lit<S: Simd>(
        &self,
        simd: S,
        light: Point,
        points: &Points,
        facing: &[u32; PACKETS],
        space: &mut Workspace,
    ) -> [u32; PACKETS] {
        simd.vectorize(
            #[inline(always)]
            || self.lit_all(simd, light, points, facing, space),
        )
    }

    #[inline(always)]
    fn lit_all<S: Simd>(
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
        let starts = points.starts();
        let ends = Segments {
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

    /// Bytes of the arrays and trees.
    pub(crate) fn memory(&self) -> usize {
        self.shapes.memory() + self.parts.memory()
    }
}

/// How far the offsets from a light to points may be off by its own place: rounding it to the f64 of its
/// coordinates and the differences, in scene units.
#[inline(always)]
fn light_error(light: Point) -> f64 {
    light.0.length() * (2.0 * ROUNDING)
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
