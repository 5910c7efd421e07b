//! All shapes of a world, kind by kind.

use std::sync::Arc;

use fearless_simd::Simd;

use super::batch::{BATCH, Column, columns, offsets};
use super::primitive::{PLANES, Primitive, ShapeId};
use super::projection::{BatchProjection, DepthTest};
use super::question::{NearestHit, Occlusion, SegmentEnds};
use super::rays::{Rays, ShearedRays};
use super::search::Search;
use super::shape::{Block, Shape, Sphere, Triangle, plane};
use super::tree::Stack;
use crate::math::{DVec3, Point};
use crate::simd::{DVec3x16, F64x16, LANES, Mask64x16, U64x16};
use crate::world::{Plan, World};

/// The shapes of a world, arranged for tracing, whatever looks at them. Copies share what was built.
#[derive(Clone, Debug)]
pub(super) struct Parts {
    spheres: Arc<Search<Sphere>>,
    triangles: Arc<Search<Triangle>>,
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

/// The ends of a batch's segments to a light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Segments<'p> {
    pub(super) position: &'p [Column; 3],
    /// A bound on the rounding error of each.
    pub(super) error: &'p Column,
    /// What each is on.
    pub(super) primitive: &'p [u64; BATCH],
}

impl Parts {
    /// Arranges the shapes of a world as its plan says; builds the trees.
    pub(super) fn new(world: &World, plan: &Plan) -> Self {
        let triangles = world.triangles();
        let meshes = triangles.meshes();
        let triangle = |index| {
            let mesh = meshes.partition_point(|mesh| mesh.triangles.end <= index);
            let primitive = Primitive::triangle(meshes[mesh].object, index);
            Triangle::new(primitive, triangles.vertices(index))
        };
        let triangles = Search::new(triangles.len() as u32, triangle, plan.triangles());
        let sphere = |index: u32| Sphere::new(&world.spheres()[index as usize]);
        let spheres = Search::new(world.spheres().len() as u32, sphere, plan.spheres());
        Self {
            spheres: Arc::new(spheres),
            triangles: Arc::new(triangles),
        }
    }
}

impl<'w> Shapes<'w> {
    /// A world and the parts that were built of it.
    pub(super) fn of(world: &'w World, parts: Parts) -> Self {
        let Parts { spheres, triangles } = parts;
        Self {
            world,
            spheres,
            triangles,
        }
    }

    /// A point amid the shapes.
    pub(super) fn somewhere(&self) -> DVec3 {
        let plane = self.world.planes().first().map(|plane| plane.point.0);
        let solid = self.triangles.somewhere().or(self.spheres.somewhere());
        solid.or(plane).unwrap_or(DVec3::ZERO)
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
        ends: Segments<'_>,
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
