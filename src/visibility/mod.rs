//! What rays meet first (L2), whether segments are free (L4), and what stands in whole shafts of them.
//!
//! Questions come in batches with what their rays share ([`RayBatch`], [`SegmentBatch`]): a point, as the primary
//! rays of a perspective camera and the shadow rays to a point light do; a direction; or nothing. Batches
//! that share something are answered as a whole (`coherent`): by a projection from the shared point or along the
//! shared direction, which decides in f32 what is certain, and for the few rays that are left in packets of
//! sixteen, in f64; those to a sun ray by ray. All others go down the same trees ray by ray (`incoherent`), to
//! the same bits. Each kind of shape is searched on its own, through a list or a tree as the [`Plan`] says.
//!
//! Every number of a point is computed in f64. The tree's boxes are f32 and conservative, and ties are
//! settled by the order of the scene file: the picture depends neither on the tree, nor on which rays
//! are asked together, nor on the instruction set.
//!
//! On floors, of which each uses only those before it:
//! 1. `batch`, `primitive`, `work`: the columns of a batch; which shape it is; what it takes, counted.
//! 2. `rays`, `ray_batch`, `question`: the rays of a packet and of a batch, what they ask, and what is known of the
//!    answer.
//! 3. `tree`: a bounding volume hierarchy and the beams that go down it. It knows boxes, not shapes.
//! 4. `projection`: the samples of a batch on a plane, and the depth test that fragments pass there.
//! 5. `shape`: spheres, triangles, planes and disks, each with its set-up before a projection and its test in f64.
//! 6. `packet`: how a packet goes down a tree and puts its question to shapes.
//! 7. `search`, `shapes`: all shapes of a kind, and all of a world.
//! 8. `points`: the answers.
//! 9. `coherent`, `incoherent`, `shaft`: the ways to them; here which way it is.

mod batch;
mod coherent;
mod incoherent;
mod packet;
mod points;
mod primitive;
mod projection;
mod question;
mod ray_batch;
mod rays;
mod search;
mod shaft;
mod shape;
mod shapes;
mod tree;
mod work;

#[cfg(test)]
mod tests;

use std::sync::Arc;

use fearless_simd::Simd;

pub(crate) use batch::{BATCH, PACKETS};
pub(crate) use batch::{Column, columns, vector};
pub(crate) use incoherent::IncoherentSegments;
pub(crate) use points::Facing;
pub(crate) use points::{Points, Start};
pub(crate) use ray_batch::{IncoherentRays, RayBatch, RayStart};
pub(crate) use shaft::{Shaft, ShaftAnswer, ShaftQuestion, ShaftSpace};
pub(crate) use work::MetLeaves;
pub use work::{RayWork, Work};

use crate::math::{DVec3, Direction, Point};
use crate::memory::{self, OutOfMemory};
use crate::simd::DVec3x16;
use crate::world::{Plan, World};
use incoherent::IncoherentSpace;
use projection::BatchProjection;
use shape::TriangleBlock;
pub(crate) use shapes::Parts;
use shapes::{Setups, Shapes};
use tree::{EMPTY_STACK, Stack};

/// Rays whose directions differ by more than this part of their length do not share a projection: at a
/// silhouette, points of the object and points far behind it would be enclosed in one beam.
const MOST_SPREAD: f64 = 1.0 / 16.0;

/// So many shapes are soon told, whatever is enclosed: rays that share a projection may then differ as much as
/// [`MOST_SPREAD_AMID_FEW`].
const FEW_SHAPES: usize = 64;
const MOST_SPREAD_AMID_FEW: f64 = 1.0;

/// A light so many times further away than points is no longer where their rays are measured from: its distance
/// is rounded by more than 1e-8 of their coordinates.
const FAR: f64 = 67_108_864.0; // 2²⁶

/// What building a tree takes for each shape, at most; a test measures it.
const BYTES_OF_TRIANGLE: u64 = 100;
const BYTES_OF_SPHERE: u64 = 130;

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

/// At most [`BATCH`] segments, with what they have in common, if anything.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SegmentBatch<'s> {
    /// Their end, a point of a light. Those from points of surfaces with a bit, which must be
    /// [above](Points::facing) of it.
    ToPoint {
        end: Point,
        /// Of a light that is infinitely far away the way to it; `end` is then so far along it that segments are
        /// parallel to the last digit.
        to_light: Option<Direction>,
        /// Which it is among the points of all lights.
        number: usize,
        points: &'s Points,
        facing: &'s [u32; PACKETS],
    },
    /// Nothing.
    Any(&'s IncoherentSegments),
}

/// The object of a shape, and of a mesh its triangle, from what answers name it by.
pub(crate) fn object_and_triangle(shape: u64) -> (u32, u32) {
    primitive::Primitive(shape).parts()
}

/// What a thread needs to trace batches, to be used again and again.
#[derive(Debug)]
pub(crate) struct Workspace {
    projection: BatchProjection,
    setups: Setups,
    stack: Box<Stack>,
    /// Groups of points that are still to be asked for a light.
    groups: Vec<[u32; PACKETS]>,
    incoherent: IncoherentSpace,
    /// Rays that a projection does not tell.
    open: IncoherentRays,
}

impl Default for Workspace {
    fn default() -> Self {
        Self {
            projection: BatchProjection::default(),
            setups: Setups::default(),
            stack: Box::new(EMPTY_STACK),
            groups: Vec::new(),
            incoherent: IncoherentSpace::default(),
            open: IncoherentRays::default(),
        }
    }
}

impl Workspace {
    /// Takes note of the leaves that are met from now on, if any are given.
    pub(crate) fn note_leaves(&mut self, leaves: Option<Arc<MetLeaves>>) {
        self.projection.met_leaves = leaves;
    }

    /// What was done since this was last asked.
    pub(crate) fn take_work(&mut self) -> Work {
        let mut work = std::mem::take(&mut self.projection.work);
        for rays in [&mut work.primary, &mut work.shadow] {
            rays.leaf_bytes = rays.leaves * TriangleBlock::BYTES as u64;
        }
        work
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

    /// What was built for it, without its world.
    pub(crate) fn into_parts(self) -> Parts {
        self.parts
    }

    /// A world again and what was built for it.
    pub(crate) fn of_parts(world: &'w World, parts: Parts) -> Self {
        Self::of(world, parts)
    }

    /// How many trees were built for it: none for what was kept.
    pub(crate) fn trees_built(&self) -> usize {
        self.parts.built()
    }

    /// A world and the parts that were built of it.
    fn of(world: &'w World, parts: Parts) -> Self {
        let shapes = Shapes::of(world, &parts);
        let meshes = world.triangles().meshes();
        let count = world.triangles().len() + world.spheres().len() + world.disks().len();
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

    /// About how many bytes [`Visibility::new`] takes at once, of which it keeps half or more.
    pub(crate) fn memory_needed(world: &World) -> u64 {
        let triangles = world.triangles().len() as u64;
        let spheres = world.spheres().len() as u64;
        triangles * BYTES_OF_TRIANGLE + spheres * BYTES_OF_SPHERE
    }

    /// L2: the points that the rays of a batch meet first.
    #[inline(never)]
    pub(crate) fn nearest<S: Simd>(
        &self,
        simd: S,
        rays: &RayBatch<'_, impl Fn(usize) -> DVec3x16<S>>,
        space: &mut Workspace,
        points: &mut Points,
    ) {
        simd.vectorize(
            #[inline(always)]
            || match rays {
                RayBatch::FromPoint { .. } | RayBatch::Along { .. } => {
                    self.nearest_coherent(simd, rays, space, points);
                }
                RayBatch::Any(rays) if rays.eye().is_some() => {
                    self.nearest_mirrored(simd, rays, space, points);
                }
                RayBatch::Any(rays) => self.nearest_incoherent(simd, rays, space, points),
            },
        );
    }

    /// L4: one bit for each segment of a batch, packet by packet, that no shape stands strictly between the ends
    /// of.
    #[inline(always)]
    pub(crate) fn free<S: Simd>(
        &self,
        simd: S,
        segments: SegmentBatch<'_>,
        space: &mut Workspace,
    ) -> [u32; PACKETS] {
        match segments {
            SegmentBatch::ToPoint {
                end,
                to_light,
                number,
                points,
                facing,
            } => {
                space.projection.origin_number = number + 1;
                match to_light {
                    Some(to_light) => self.free_to_sun(simd, end, to_light, points, facing, space),
                    None => self.free_to_point(simd, end, points, facing, space),
                }
            }
            SegmentBatch::Any(segments) => self.free_incoherent(simd, segments, space),
        }
    }

    /// No leaf yet, to be told apart as they are met from the eye and from so many points of lights; `None` if
    /// these are too many.
    pub(crate) fn met_leaves(&self, origins: usize) -> Option<Arc<MetLeaves>> {
        MetLeaves::none(
            self.shapes.triangles.blocks_count(),
            origins.checked_add(1)?,
        )
    }

    /// At least the largest coordinate of any sphere, triangle or disk.
    pub(crate) fn reach(&self) -> f64 {
        let disks = self.shapes.world.disks().iter();
        disks.fold(self.parts.reach(), |reach, disk| {
            reach.max(disk.center.0.abs().max_element() + disk.radius)
        })
    }

    /// Bytes of the arrays and trees.
    pub(crate) fn memory(&self) -> usize {
        self.shapes.memory() + self.parts.memory()
    }
}

/// Whether a light is so far away that segments are measured from the points.
#[inline]
fn is_far(light: Point, points: &Points) -> bool {
    let [least, most] = points.bounds();
    let reach = least.abs().max(most.abs()).max_element();
    light.0.abs().max_element() > FAR * reach
}
