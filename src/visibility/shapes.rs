//! All shapes of a world, kind by kind.

use std::sync::Arc;

use fearless_simd::Simd;
use rayon::prelude::*;

use super::batch::{BATCH, Column, columns, offsets};
use super::primitive::{PLANES, Primitive, ShapeId};
use super::projection::{BatchProjection, DepthTest};
use super::question::{NearestHit, Occlusion, SegmentEnds};
use super::rays::{Rays, ShearedRays};
use super::search::{NumberedShapes, Search, outsized};
use super::shape::{Block, Shape, Sphere, Triangle, disk, plane};
use super::tree::{Bounds, PartTree, PlacedPart, Stack};
use crate::math::{DVec3, Point, all_three, both};
use crate::simd::{DVec3x16, F64x16, LANES, Mask64x16, U64x16};
use crate::world::plan::Acceleration;
use crate::world::{Plan, Triangles, World};

/// A mesh of so many triangles has a tree of its own, so that it is kept when something else moves. A tree over
/// fewer is soon built: all smaller meshes share one.
const LEAST_PART: usize = 1024;

/// The shapes of a world, arranged for tracing, whatever looks at them. Copies share what was built.
#[derive(Clone, Debug)]
pub(crate) struct Parts {
    spheres: Arc<Search<Sphere>>,
    triangles: Arc<Search<Triangle>>,
    /// The trees of meshes that stand under the one of all triangles, if there is more than one.
    meshes: Vec<MeshPart>,
    /// How many trees were built for it.
    built: usize,
}

/// Triangles with a tree of their own.
#[derive(Clone, Debug)]
struct MeshPart {
    /// In the order of the world.
    numbers: Vec<u32>,
    tree: Arc<PartTree>,
}

/// A world with its shapes, as rays ask them.
#[derive(Debug)]
pub(super) struct Shapes<'w> {
    pub(super) world: &'w World,
    pub(super) spheres: Arc<Search<Sphere>>,
    pub(super) triangles: Arc<Search<Triangle>>,
}

/// What a projection makes of the blocks of each kind.
type SetupOf<T> = <<T as Shape>::Block as Block<T>>::Setup;

/// What is set up before the rays of a batch, block by block.
#[derive(Debug, Default)]
pub(super) struct Setups {
    spheres: SetupOf<Sphere>,
    triangles: SetupOf<Triangle>,
}

/// Where a batch's segments to a light start.
#[derive(Clone, Copy, Debug)]
pub(super) struct SegmentStarts<'p> {
    pub(super) position: &'p [Column; 3],
    /// A bound on the rounding error of each.
    pub(super) error: &'p Column,
    /// What each is on.
    pub(super) primitive: &'p [u64; BATCH],
}

impl Parts {
    /// Arranges the shapes of a world as its plan says; builds the trees, but those that another world has of the
    /// same shapes.
    pub(super) fn new(world: &World, plan: &Plan, kept: Option<(&World, &Self)>) -> Self {
        Self::with_parts_of(LEAST_PART, world, plan, kept)
    }

    /// [`Parts::new`] with trees of their own for meshes of this many triangles.
    pub(super) fn with_parts_of(
        least: usize,
        world: &World,
        plan: &Plan,
        kept: Option<(&World, &Self)>,
    ) -> Self {
        let mut built = 0;
        let spheres = match kept {
            Some((other, parts)) if other.spheres() == world.spheres() => {
                Arc::clone(&parts.spheres)
            }
            _ => {
                built += usize::from(plan.spheres() == Acceleration::Tree);
                Arc::new(Search::new(&SpheresOf(world), plan.spheres()))
            }
        };
        if let Some((other, parts)) = kept
            && have_same_triangles(other, world)
        {
            return Self {
                spheres,
                built,
                ..parts.clone()
            };
        }
        let (triangles, meshes) = search_triangles(least, world, plan, kept, &mut built);
        Self {
            spheres,
            triangles: Arc::new(triangles),
            meshes,
            built,
        }
    }

    /// At least the largest coordinate of any sphere or triangle.
    pub(super) fn reach(&self) -> f64 {
        self.spheres.reach().max(self.triangles.reach())
    }

    /// How many trees were built for it: none for what was kept.
    pub(super) fn built(&self) -> usize {
        self.built
    }

    /// Bytes of the trees of meshes.
    pub(super) fn memory(&self) -> usize {
        let meshes = self.meshes.iter();
        meshes
            .map(|part| size_of_val(part.numbers.as_slice()) + part.tree.memory())
            .sum()
    }
}

/// All spheres of a world.
struct SpheresOf<'w>(&'w World);

impl NumberedShapes<Sphere> for SpheresOf<'_> {
    fn count(&self) -> u32 {
        self.0.spheres().len() as u32
    }

    fn shape(&self, number: u32) -> Sphere {
        Sphere::new(&self.0.spheres()[number as usize])
    }

    fn bounds(&self, number: u32) -> Bounds {
        self.shape(number).bounds()
    }

    /// Blocks have all of it.
    fn exact(&self) {}
}

/// All triangles of a world.
struct TrianglesOf<'w>(&'w World);

impl NumberedShapes<Triangle> for TrianglesOf<'_> {
    fn count(&self) -> u32 {
        self.0.triangles().len() as u32
    }

    fn shape(&self, number: u32) -> Triangle {
        let triangles = self.0.triangles();
        let primitive = Primitive::triangle(triangles.mesh(number).object, number);
        Triangle::new(primitive, triangles.vertices(number))
    }

    #[inline]
    fn bounds(&self, number: u32) -> Bounds {
        let [a, b, c] = self.0.triangles().vertices(number);
        Bounds {
            min: a.min(b).min(c),
            max: a.max(b).max(c),
        }
    }

    fn exact(&self) -> Arc<Triangles> {
        Arc::clone(self.0.shared_triangles())
    }
}

/// All triangles, and the trees of their parts if there is more than one; `built` counts those that are new.
fn search_triangles(
    least: usize,
    world: &World,
    plan: &Plan,
    kept: Option<(&World, &Parts)>,
    built: &mut usize,
) -> (Search<Triangle>, Vec<MeshPart>) {
    let triangles = &TrianglesOf(world);
    if plan.triangles() != Acceleration::Tree {
        return (Search::new(triangles, plan.triangles()), Vec::new());
    }
    let listed = outsized(triangles);
    if !has_parts(least, world, &listed) {
        *built += 1;
        return (Search::in_one_tree(triangles, listed), Vec::new());
    }
    let parts = numbers_of_parts(least, world, &listed);
    let bounds = |number| triangles.bounds(number);
    let tree_of = |numbers: &Vec<u32>| {
        let (other, parts) = kept?;
        let mut parts = parts.meshes.iter();
        let known = parts
            .find(|part| part.numbers == *numbers && are_same_triangles(other, world, numbers));
        known.map(|part| Arc::clone(&part.tree))
    };
    let parts: Vec<MeshPart> = parts
        .into_iter()
        .map(|numbers| {
            let tree = tree_of(&numbers).unwrap_or_else(|| {
                *built += 1;
                Arc::new(PartTree::new(&numbers, Triangle::WIDTH, &bounds))
            });
            MeshPart { numbers, tree }
        })
        .collect();
    let placed: Vec<PlacedPart<'_>> = parts
        .iter()
        .map(|MeshPart { numbers, tree }| PlacedPart { tree, numbers })
        .collect();
    (Search::of_parts(triangles, &placed, listed), parts)
}

/// Whether there are more trees than one.
fn has_parts(least: usize, world: &World, listed: &[u32]) -> bool {
    let meshes = world.triangles().meshes();
    let large = meshes.iter().filter(|mesh| mesh.triangles.len() >= least);
    let mut small = meshes.iter().filter(|mesh| mesh.triangles.len() < least);
    let is_treed = |number: u32| listed.binary_search(&number).is_err();
    let has_loose = small.any(|mesh| mesh.triangles.clone().any(is_treed));
    large.count() + usize::from(has_loose) > 1
}

/// The numbers of the triangles of each part, but the `listed` ones: each mesh of at least so many, and all others.
fn numbers_of_parts(least: usize, world: &World, listed: &[u32]) -> Vec<Vec<u32>> {
    let is_treed = |number: &u32| listed.binary_search(number).is_err();
    let (mut parts, mut loose) = (Vec::new(), Vec::new());
    for mesh in world.triangles().meshes() {
        let numbers = mesh.triangles.clone().filter(is_treed);
        if mesh.triangles.len() >= least {
            parts.push(numbers.collect());
        } else {
            loose.extend(numbers);
        }
    }
    parts.push(loose);
    parts.retain(|numbers| !numbers.is_empty());
    parts
}

/// Whether triangles of two worlds have the same corners, to the bit.
fn are_same_triangles(one: &World, other: &World, numbers: &[u32]) -> bool {
    let count = one.triangles().len().min(other.triangles().len());
    let corners = |world: &World, number| {
        let vertices = world.triangles().vertices(number);
        all_three(vertices, |vertex| {
            all_three(vertex.to_array(), f64::to_bits)
        })
    };
    numbers
        .par_iter()
        .all(|&number| (number as usize) < count && corners(one, number) == corners(other, number))
}

/// Whether all triangles of two worlds are the same, and of the same objects.
fn have_same_triangles(one: &World, other: &World) -> bool {
    let [one_has, other_has] = both([one, other], World::triangles);
    if std::ptr::eq(one_has, other_has) {
        return true;
    }
    let mut meshes = one_has.meshes().iter().zip(other_has.meshes());
    let are_alike = one_has.len() == other_has.len()
        && one_has.meshes().len() == other_has.meshes().len()
        && meshes
            .all(|(one, other)| (one.object, &one.triangles) == (other.object, &other.triangles));
    let numbers: Vec<u32> = (0..one_has.len() as u32).collect();
    are_alike && are_same_triangles(one, other, &numbers)
}

impl<'w> Shapes<'w> {
    /// A world and the parts that were built of it.
    pub(super) fn of(world: &'w World, parts: &Parts) -> Self {
        let Parts {
            spheres, triangles, ..
        } = parts.clone();
        Self {
            world,
            spheres,
            triangles,
        }
    }

    /// A point amid the shapes.
    pub(super) fn somewhere(&self) -> DVec3 {
        let plane = self.world.planes().first().map(|plane| plane.point.0);
        let disk = self.world.disks().first().map(|disk| disk.center.0);
        let solid = self.triangles.somewhere().or(self.spheres.somewhere());
        solid.or(disk).or(plane).unwrap_or(DVec3::ZERO)
    }

    /// Bytes of the arrays and trees.
    pub(super) fn memory(&self) -> usize {
        self.spheres.memory() + self.triangles.memory()
    }

    /// Rasterizes all shapes that the rays of a projection may meet.
    #[inline(always)]
    pub(super) fn rasterize<S: Simd>(
        &self,
        simd: S,
        projection: &mut BatchProjection,
        setups: &mut Setups,
        stack: &mut Stack,
        depth_test: impl DepthTest,
    ) {
        for (index, plane) in self.world.planes().iter().enumerate() {
            let (point, normal) = (plane.point.0, plane.normal.get());
            let id = ShapeId {
                slot: PLANES | index as u32,
                primitive: Primitive::whole(plane.object),
            };
            plane::rasterize_plane(simd, point, normal, id, projection, depth_test);
        }
        self.spheres
            .rasterize(simd, projection, &mut setups.spheres, stack, depth_test);
        self.triangles
            .rasterize(simd, projection, &mut setups.triangles, stack, depth_test);
        // In the end, when much of what they are behind is known.
        if !self.world.disks().is_empty() {
            disk::rasterize_disks(simd, self.world.disks(), projection, depth_test);
        }
    }

    /// L2 for the rays of a packet, in f64.
    #[inline(never)]
    pub(super) fn ask_nearest<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        nearest: &mut NearestHit<S>,
        stack: &mut Stack,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                for plane in self.world.planes() {
                    plane::intersect(simd, plane, rays, nearest);
                }
                for disk in self.world.disks() {
                    disk::intersect(simd, disk, rays, nearest);
                }
                let packet = ShearedRays::new(*rays);
                self.spheres.ask(simd, &packet, nearest, stack);
                self.triangles.ask(simd, &packet, nearest, stack);
            },
        );
    }

    /// L4 for the points of a packet, `asked` of them, in f64: one bit for each that the light reaches.
    #[inline(never)]
    pub(super) fn ask_reached<S: Simd>(
        &self,
        simd: S,
        light: Point,
        ends: SegmentStarts<'_>,
        packet: usize,
        asked: u32,
        stack: &mut Stack,
    ) -> u32 {
        simd.vectorize(
            #[inline(always)]
            || {
                let lanes = packet * LANES;
                let points = SegmentEnds {
                    position: DVec3x16::load(simd, columns(ends.position, packet)),
                    error: F64x16::load(simd, &ends.error[lanes..]),
                    primitive: U64x16::load(simd, &ends.primitive[lanes..]),
                };
                let mut occlusion = Occlusion {
                    light,
                    points: &points,
                    asked: Mask64x16::from_bits(simd, asked),
                    asked_bits: asked,
                };
                for plane in self.world.planes() {
                    plane::occlude(simd, plane, &mut occlusion);
                }
                for disk in self.world.disks() {
                    disk::occlude(simd, disk, &mut occlusion);
                }
                let rays =
                    Rays::from_point(simd, light, offsets(simd, ends.position, packet, light.0));
                let packet = ShearedRays::new(rays);
                self.spheres.ask(simd, &packet, &mut occlusion, stack);
                self.triangles.ask(simd, &packet, &mut occlusion, stack);
                occlusion.asked_bits
            },
        )
    }
}
