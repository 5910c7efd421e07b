//! What a camera ray sees (L2) and what a light reaches (L4).
//!
//! Rays come in batches that share something: the primary rays of a few pixels share the eye or a
//! direction, the shadow rays to a point light share the light. All is asked here in such batches and
//! answered for the whole batch: on a canvas before the point that its rays share, which decides in
//! f32 what is certain, and for the few rays that are left in packets of sixteen, in f64. Each kind of
//! shape is searched on its own, through a list or a tree as the [`Plan`] says.
//!
//! Every number of a point is computed in f64. The tree's boxes are f32 and conservative, and ties are
//! settled by the order of the scene file: the picture depends neither on the tree, nor on which rays
//! are asked together, nor on the instruction set.

mod beam;
mod bins;
mod builder;
mod bvh;
mod canvas;
mod disc;
mod extent;
mod facing;
mod lift;
mod met;
mod nodes;
mod outline;
mod packet;
mod plane;
mod search;
mod sketch;
mod smooth;
mod sphere;
mod surface;
mod triangle;
mod verdict;

#[cfg(test)]
mod tests;

use std::sync::Arc;

use fearless_simd::Simd;

pub(crate) use facing::Facing;
pub use surface::{BATCH, PACKETS, Points};
pub(crate) use surface::{Column, columns};
use surface::{Known, Only};

use crate::camera::{Camera, Projection};
use crate::math::{DVec3, Point, both};
use crate::memory::{self, OutOfMemory};
use crate::simd::{DVec3x16, F64x16, LANES, Mask64x16, U64x16};
use crate::world::{Plan, World};
use beam::{EMPTY_STACK, Stack};
use canvas::{Canvas, State};
use disc::Discs;
use outline::Outlines;
use packet::{Ends, Nearest, Packet, Rays, Shadow};
use search::Search;
use triangle::Facet;
use verdict::{First, Reached, Verdict, Who};

/// How much a few operations in f64 on coordinates of magnitude 1 can be off: each by ε/2, eight of
/// them, and as much again for room. Times a length, it is the bound below which "on the surface"
/// and "beside it" are the same.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The slots of the shapes: what the kinds have beside the place among their kind.
const TRIANGLES: u32 = 0;
const SPHERES: u32 = 1 << 30;
const PLANES: u32 = 2 << 30;

/// Rays whose directions differ by more than this part of their length do not share a canvas: at a
/// silhouette, points of the object and points far behind it would be enclosed in one beam.
const MOST_SPREAD: f64 = 1.0 / 16.0;

/// So many shapes are soon told, whatever is enclosed: rays that share a canvas may then differ as much as
/// [`MOST_SPREAD_AMID_FEW`].
const FEW_SHAPES: usize = 64;
const MOST_SPREAD_AMID_FEW: f64 = 1.0;

/// What building a tree takes for each shape, at most; a test measures it.
const BYTES_OF_TRIANGLE: u64 = 260;
const BYTES_OF_SPHERE: u64 = 130;

/// Fewer rays than this are not worth a canvas.
const FEW: u32 = 8;

/// One shape that a ray can hit: its object, and of a mesh its triangle, in the order of the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Primitive(u64);

impl Primitive {
    /// An object of one shape.
    fn whole(object: u32) -> Self {
        Self(u64::from(object) << 32)
    }

    /// A triangle, by its index in the world.
    fn triangle(object: u32, index: u32) -> Self {
        Self(u64::from(object) << 32 | u64::from(index))
    }

    /// The object, and the triangle.
    fn parts(self) -> (u32, u32) {
        ((self.0 >> 32) as u32, self.0 as u32)
    }

    #[inline(always)]
    fn lanes<S: Simd>(self, simd: S) -> U64x16<S> {
        U64x16::splat(simd, self.0)
    }
}

/// The shapes of a world, arranged for tracing; whatever looks at them. Copies share what was built.
#[derive(Clone, Debug)]
pub struct Parts {
    spheres: Arc<Search<sphere::Ball>>,
    triangles: Arc<Search<Facet>>,
}

impl Parts {
    /// Arranges the shapes of a world as its plan says; builds the trees.
    fn new(world: &World, plan: &Plan) -> Self {
        let triangles = world.triangles();
        let meshes = triangles.meshes();
        let facet = |index| {
            let mesh = meshes.partition_point(|mesh| mesh.triangles.end <= index);
            let primitive = Primitive::triangle(meshes[mesh].object, index);
            Facet::new(primitive, triangles.vertices(index))
        };
        let triangles = Search::new(triangles.len() as u32, facet, plan.triangles());
        let ball = |index: u32| sphere::Ball::new(&world.spheres()[index as usize]);
        let spheres = Search::new(world.spheres().len() as u32, ball, plan.spheres());
        Self {
            spheres: Arc::new(spheres),
            triangles: Arc::new(triangles),
        }
    }

    /// [`Parts::new`], if there is as much memory as it takes.
    pub(crate) fn try_new(world: &World, plan: &Plan) -> Result<Self, OutOfMemory> {
        let needed = memory::look_for(Visibility::memory_needed(world));
        needed.map_err(|error| error.for_what("building the trees over all shapes"))?;
        Ok(Self::new(world, plan))
    }

    /// Bytes of the arrays and trees.
    pub(crate) fn memory(&self) -> usize {
        self.spheres.memory() + self.triangles.memory()
    }
}

/// A world and its shapes, as rays ask them.
#[derive(Debug)]
pub struct Visibility<'w> {
    world: &'w World,
    spheres: Arc<Search<sphere::Ball>>,
    triangles: Arc<Search<Facet>>,
    is_smooth: bool,
    /// A point amid the shapes.
    somewhere: DVec3,
    /// Whether there are no more than [`FEW_SHAPES`].
    are_few: bool,
    /// How much the directions of rays on one canvas may differ, as a part of their length.
    most_spread: f64,
    /// Whether canvases decide what they can, as they do but in tests.
    uses_canvas: bool,
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

    /// Stretches a canvas before the primary rays of the packets' samples with a bit; `somewhere` is amid the
    /// shapes.
    #[inline(always)]
    fn stretch<S: Simd>(
        &self,
        simd: S,
        somewhere: DVec3,
        asked: &[u32; PACKETS],
        canvas: &mut Canvas,
    ) {
        let camera = self.camera;
        match camera.projection() {
            Projection::Perspective { .. } => {
                let [x, y] = both(self.places, |places| places[self.count / 2]);
                canvas.stretch_around(
                    simd,
                    camera.eye().0,
                    camera.ray(x, y).direction,
                    asked,
                    #[inline(always)]
                    |packet| self.varying(simd, packet),
                );
            }
            Projection::Orthographic { .. } => {
                canvas.stretch_along(
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

/// What is drawn on a canvas, block by block.
#[derive(Debug, Default)]
struct Drawings {
    discs: Discs,
    outlines: Outlines,
}

/// What a thread needs to trace batches, to be used again and again.
#[derive(Debug)]
pub struct Workspace {
    canvas: Canvas,
    drawings: Drawings,
    stack: Box<Stack>,
    /// Groups of points that are still to be asked for a light.
    groups: Vec<[u32; PACKETS]>,
}

impl Default for Workspace {
    fn default() -> Self {
        Self {
            canvas: Canvas::default(),
            drawings: Drawings::default(),
            stack: Box::new(EMPTY_STACK),
            groups: Vec::new(),
        }
    }
}

/// One bit for each of the first `count` lanes of a packet.
fn first_lanes(count: usize, packet: usize) -> u32 {
    let left = count.saturating_sub(packet * LANES).min(LANES);
    (1_u32 << left) - 1
}

/// The ranges of columns over the lanes with a bit; `None` where there is none.
#[inline(always)]
fn ranges<S: Simd>(
    simd: S,
    bits: impl Fn(usize) -> u32,
    vectors: impl Fn(usize) -> DVec3x16<S>,
) -> Option<[DVec3; 2]> {
    let infinite = DVec3x16::splat(simd, DVec3::INFINITY);
    let (mut least, mut most) = (infinite, -infinite);
    let mut any = 0;
    for packet in 0..PACKETS {
        let bits = bits(packet);
        if bits == 0 {
            continue;
        }
        any |= bits;
        let asked = Mask64x16::from_bits(simd, bits);
        let vectors = vectors(packet);
        let low = asked.select_vectors(vectors, infinite);
        let high = asked.select_vectors(vectors, -infinite);
        least.x = low.x.min(least.x);
        least.y = low.y.min(least.y);
        least.z = low.z.min(least.z);
        most.x = high.x.max(most.x);
        most.y = high.y.max(most.y);
        most.z = high.z.max(most.z);
    }
    (any != 0).then(|| {
        [
            -DVec3::new(
                (-least.x).largest(),
                (-least.y).largest(),
                (-least.z).largest(),
            ),
            DVec3::new(most.x.largest(), most.y.largest(), most.z.largest()),
        ]
    })
}

impl<'w> Visibility<'w> {
    /// Arranges the shapes of a world as its plan says; builds the trees.
    pub fn new(world: &'w World, plan: &Plan) -> Self {
        Self::of(world, Parts::new(world, plan))
    }

    /// A world and the parts that were built of it.
    pub(crate) fn of(world: &'w World, parts: Parts) -> Self {
        let shapes = world.triangles().len() + world.spheres().len();
        let meshes = world.triangles().meshes();
        let is_smooth = meshes.iter().any(|mesh| mesh.normals.is_some());
        let Parts { spheres, triangles } = parts;
        let plane = world.planes().first().map(|plane| plane.point.0);
        let somewhere = triangles.somewhere().or(spheres.somewhere()).or(plane);
        Self {
            world,
            somewhere: somewhere.unwrap_or(DVec3::ZERO),
            spheres,
            triangles,
            is_smooth,
            are_few: shapes <= FEW_SHAPES,
            most_spread: if shapes <= FEW_SHAPES {
                MOST_SPREAD_AMID_FEW
            } else {
                MOST_SPREAD
            },
            uses_canvas: true,
        }
    }

    /// [`Visibility::new`], if there is as much memory as it takes.
    ///
    /// # Errors
    /// If there is not.
    pub fn try_new(world: &'w World, plan: &Plan) -> Result<Self, OutOfMemory> {
        Ok(Self::of(world, Parts::try_new(world, plan)?))
    }

    /// About how many bytes [`Visibility::new`] takes at once, of which it keeps about half.
    pub fn memory_needed(world: &World) -> u64 {
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
            canvas,
            drawings,
            stack,
            ..
        } = space;
        let (eye, forward) = (camera.eye(), camera.forward().get());
        let is_perspective = matches!(camera.projection(), Projection::Perspective { .. });
        let mut asked = [0; PACKETS];
        for (packet, bits) in asked.iter_mut().enumerate() {
            *bits = first_lanes(count, packet);
        }
        let has_canvas = self.uses_canvas && {
            let distance = (self.somewhere - eye.0).length();
            canvas.unit = if distance > 0.0 { distance } else { 1.0 };
            // What one batch sees, the next one mostly does.
            let may_settle = self.are_few || points.only != Only::Many;
            let is_aimed =
                is_perspective && may_settle && canvas.aim_between(eye.0, samples.corners());
            if is_aimed {
                self.cast(simd, canvas, drawings, stack, First);
            }
            if is_aimed && canvas.state == State::Aimed {
                canvas.settle();
            } else {
                samples.stretch(simd, self.somewhere, &asked, canvas);
                if canvas.state == State::Stretched {
                    self.cast(simd, canvas, drawings, stack, First);
                }
            }
            canvas.state != State::Unfit
        };
        points.begin(self.is_smooth);
        let mut last = None;
        for (packet, bits) in asked.into_iter().enumerate() {
            if bits == 0 {
                points.hit[packet] = 0;
                continue;
            }
            let again = if has_canvas {
                canvas.asked_again(packet) & bits
            } else {
                bits
            };
            let known = bits & !again;
            if again == 0 && canvas.found(simd, packet) & known == 0 {
                points.hit[packet] = 0;
                continue;
            }
            let varying = samples.varying(simd, packet);
            let rays = if is_perspective {
                Rays::from_point(simd, eye, varying)
            } else {
                Rays::new(varying, DVec3x16::splat(simd, forward), None)
            };
            let mut nearest = Nearest::new(simd, again);
            if again != 0 {
                self.ask_nearest(simd, &rays, &mut nearest, stack);
            }
            let known = Known {
                slots: canvas.first_met(packet),
                met: known,
                last: &mut last,
            };
            points.fill(simd, self, packet, &rays, &nearest, known);
            if self.is_smooth {
                points.interpolate(simd, self.world, packet, &rays);
            }
        }
        points.end(simd);
    }

    /// Puts all shapes that the rays on a canvas may meet on it.
    #[inline(always)]
    fn cast<S: Simd>(
        &self,
        simd: S,
        canvas: &mut Canvas,
        drawings: &mut Drawings,
        stack: &mut Stack,
        verdict: impl Verdict,
    ) {
        for (index, plane) in self.world.planes().iter().enumerate() {
            let (point, normal) = (plane.point.0, plane.normal.get());
            let who = Who {
                slot: PLANES | index as u32,
                primitive: Primitive::whole(plane.object),
            };
            outline::cast_plane(simd, point, normal, who, canvas, verdict);
        }
        let Drawings { discs, outlines } = drawings;
        self.spheres.cast(simd, canvas, discs, stack, verdict);
        self.triangles.cast(simd, canvas, outlines, stack, verdict);
    }

    /// L2 for the rays of a packet, in f64.
    #[inline(never)]
    fn ask_nearest<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        nearest: &mut Nearest<S>,
        stack: &mut Stack,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                for plane in self.world.planes() {
                    plane::intersect(simd, plane, rays, nearest);
                }
                let packet = Packet::new(*rays);
                self.spheres.ask(simd, &packet, nearest, stack);
                self.triangles.ask(simd, &packet, nearest, stack);
            },
        );
    }

    /// L4 for the points of a packet, `asked` of them, in f64: one bit for each that the light reaches.
    #[inline(never)]
    fn ask_reached<S: Simd>(
        &self,
        simd: S,
        light: Point,
        points: &Points,
        packet: usize,
        asked: u32,
        stack: &mut Stack,
    ) -> u32 {
        simd.vectorize(
            #[inline(always)]
            || {
                let lanes = packet * LANES;
                let starts = points.starts();
                let ends = Ends {
                    position: DVec3x16::load(simd, columns(starts.position, packet)),
                    error: F64x16::load(simd, &starts.error[lanes..]),
                    primitive: U64x16::load(simd, &points.primitive[lanes..]),
                };
                let mut shadow = Shadow {
                    light,
                    points: &ends,
                    asked: Mask64x16::from_bits(simd, asked),
                    asked_bits: asked,
                };
                for plane in self.world.planes() {
                    plane::occlude(simd, plane, &mut shadow);
                }
                let rays = Rays::from_point(simd, light, way(simd, points, packet, light));
                let packet = Packet::new(rays);
                self.spheres.ask(simd, &packet, &mut shadow, stack);
                self.triangles.ask(simd, &packet, &mut shadow, stack);
                shadow.asked_bits
            },
        )
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
        let Workspace {
            canvas,
            drawings,
            stack,
            groups,
            ..
        } = space;
        let mut lit = [0; PACKETS];
        let mut facing = *facing;
        // A canvas takes it that no sphere hides points of its own that are seen from outside and face the
        // light. Those with a normal on the wrong side it does hide.
        for (packet, bits) in facing.iter_mut().enumerate() {
            let edge_on = *bits & points.edge_on[packet];
            if edge_on != 0 {
                *bits &= !edge_on;
                lit[packet] = self.ask_reached(simd, light, points, packet, edge_on, stack);
            }
        }
        if facing.iter().all(|&bits| bits == 0) {
            return lit;
        }
        let mut within = 0;
        for (bits, seen_within) in facing.iter().zip(points.within) {
            within |= bits & seen_within;
        }
        canvas.has_points_within = within != 0;
        groups.clear();
        groups.push(facing);
        let starts = points.starts();
        // All points of the batch will often do.
        let [least, most] = starts.bounds;
        let mut range =
            Some([least - light.0, most - light.0]).filter(|range| !self.is_wide(range));
        while let Some(group) = groups.pop() {
            let range = range.take().or_else(|| {
                ranges(
                    simd,
                    #[inline(always)]
                    |packet| group[packet],
                    #[inline(always)]
                    |packet| way(simd, points, packet, light),
                )
            });
            let Some([least, most]) = range else {
                continue;
            };
            let mut members = 0;
            for bits in group {
                members += bits.count_ones();
            }
            let is_worth = members >= FEW;
            if is_worth && self.is_wide(&[least, most]) {
                let widest = (most - least).max_position();
                // Points too far apart for one beam part into groups.
                let middle = F64x16::splat(simd, least[widest] * 0.5 + most[widest] * 0.5);
                let mut lower = group;
                for (packet, bits) in lower.iter_mut().enumerate() {
                    if *bits != 0 {
                        let way = way(simd, points, packet, light);
                        *bits &= way.component(widest).lt(middle).to_bits();
                    }
                }
                // Neither part is empty, unless rounding makes it so.
                if lower != group && lower != [0; PACKETS] {
                    let mut upper = group;
                    for (upper, lower) in upper.iter_mut().zip(lower) {
                        *upper &= !lower;
                    }
                    groups.push(lower);
                    groups.push(upper);
                    continue;
                }
            }
            let reached = Reached {
                light,
                points,
                asked: &group,
            };
            canvas.error = starts.largest_error + light.0.length() * (2.0 * ROUNDING);
            let is_turned =
                self.uses_canvas && is_worth && canvas.turn_to_ends(light.0, [least, most]);
            // Around a point of a mesh, neighbors are always on the way to the box.
            let may_settle = self.are_few || points.only != Only::Many;
            if is_turned && !(may_settle && canvas.aim()) {
                reached.stretch(simd, canvas);
            }
            let is_fit = is_turned && canvas.state != State::Unfit;
            if is_fit {
                self.cast(simd, canvas, drawings, stack, reached);
            }
            if is_fit && canvas.state == State::Dark {
                continue;
            }
            if is_fit && canvas.state == State::Aimed {
                // There is nothing between the light and the points.
                for (lit, bits) in lit.iter_mut().zip(group) {
                    *lit |= bits;
                }
                continue;
            }
            let has_canvas = is_fit && canvas.state == State::Stretched;
            for (packet, bits) in group.into_iter().enumerate() {
                if bits == 0 {
                    continue;
                }
                let (reached, again) = if has_canvas {
                    let reached = canvas.reached(simd, packet) & bits;
                    (reached, canvas.asked_again(packet) & reached)
                } else {
                    (bits, bits)
                };
                lit[packet] |= reached & !again;
                if again != 0 {
                    lit[packet] |= self.ask_reached(simd, light, points, packet, again, stack);
                }
            }
        }
        lit
    }

    /// Whether directions in a range are too far apart for one canvas.
    fn is_wide(&self, range: &[DVec3; 2]) -> bool {
        let [least, most] = *range;
        (most - least).max_element() > longest(range) * self.most_spread
    }

    /// Bytes of the arrays and trees.
    pub fn memory(&self) -> usize {
        self.spheres.memory() + self.triangles.memory()
    }
}

/// The largest component of any direction in a range.
fn longest([least, most]: &[DVec3; 2]) -> f64 {
    least.abs().max(most.abs()).max_element()
}

/// From a light to where its shadow rays from the points of a packet start.
#[inline(always)]
fn way<S: Simd>(simd: S, points: &Points, packet: usize, light: Point) -> DVec3x16<S> {
    DVec3x16::load(simd, columns(points.starts().position, packet)).minus(light.0)
}
