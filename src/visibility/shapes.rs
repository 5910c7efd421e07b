//! All shapes of a world, kind by kind.

use fearless_simd::Simd;

use super::batch::{BATCH, Column, columns, offsets};
use super::primitive::{PLANES, Primitive, Who};
use super::projection::{Canvas, Verdict};
use super::question::{Ends, Nearest, Shadow};
use super::rays::{Rays, ShearedRays};
use super::search::Search;
use super::shape::{Ball, Block, Facet, Shape, plane};
use super::tree::Stack;
use crate::math::{DVec3, Point};
use crate::simd::{DVec3x16, F64x16, LANES, Mask64x16, U64x16};
use crate::world::{Plan, World};

/// The shapes of a world, arranged for tracing.
#[derive(Debug)]
pub(super) struct Shapes<'w> {
    pub(super) world: &'w World,
    pub(super) spheres: Search<Ball>,
    pub(super) triangles: Search<Facet>,
}

/// What a canvas makes of the blocks of each kind.
type DrawingOf<T> = <<T as Shape>::Block as Block<T>>::Drawing;

/// What is drawn on a canvas, block by block.
#[derive(Debug, Default)]
pub(super) struct Drawings {
    discs: DrawingOf<Ball>,
    outlines: DrawingOf<Facet>,
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

impl<'w> Shapes<'w> {
    /// Arranges the shapes of a world as its plan says; builds the trees.
    pub(super) fn new(world: &'w World, plan: &Plan) -> Self {
        let triangles = world.triangles();
        let meshes = triangles.meshes();
        let facet = |index| {
            let mesh = meshes.partition_point(|mesh| mesh.triangles.end <= index);
            let primitive = Primitive::triangle(meshes[mesh].object, index);
            Facet::new(primitive, triangles.vertices(index))
        };
        let ball = |index: u32| Ball::new(&world.spheres()[index as usize], world.camera());
        Self {
            world,
            triangles: Search::new(triangles.len() as u32, facet, plan.triangles()),
            spheres: Search::new(world.spheres().len() as u32, ball, plan.spheres()),
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

    /// Puts all shapes that the rays on a canvas may meet on it.
    #[inline(always)]
    pub(super) fn cast<S: Simd>(
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
            plane::cast_plane(simd, point, normal, who, canvas, verdict);
        }
        let Drawings { discs, outlines } = drawings;
        self.spheres.cast(simd, canvas, discs, stack, verdict);
        self.triangles.cast(simd, canvas, outlines, stack, verdict);
    }

    /// L2 for the rays of a packet, in f64.
    #[inline(never)]
    pub(super) fn ask_nearest<S: Simd>(
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
                let points = Ends {
                    position: DVec3x16::load(simd, columns(ends.position, packet)),
                    error: F64x16::load(simd, &ends.error[lanes..]),
                    primitive: U64x16::load(simd, &ends.primitive[lanes..]),
                };
                let mut shadow = Shadow {
                    light,
                    points: &points,
                    asked: Mask64x16::from_bits(simd, asked),
                    asked_bits: asked,
                };
                for plane in self.world.planes() {
                    plane::occlude(simd, plane, &mut shadow);
                }
                let rays =
                    Rays::from_point(simd, light, offsets(simd, ends.position, packet, light.0));
                let packet = ShearedRays::new(rays);
                self.spheres.ask(simd, &packet, &mut shadow, stack);
                self.triangles.ask(simd, &packet, &mut shadow, stack);
                shadow.asked_bits
            },
        )
    }
}
