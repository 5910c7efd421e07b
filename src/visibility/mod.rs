//! What a camera ray sees (L2) and what a light reaches (L4).
//!
//! Rays come in batches that share something: the primary rays of a few pixels share the eye or a
//! direction, the shadow rays to a point light share the light. All is asked here in such batches and
//! answered for the whole batch: first interval arithmetic on the batch as a whole drops the shapes
//! that none of its rays can meet, then packets of sixteen rays ask those that are left, side by side.
//! Each kind of shape is searched on its own, through a list or a tree as the [`Plan`] says.
//!
//! Intersections are computed in f64. The tree's boxes are f32 and conservative, and ties are
//! settled by the order of the scene file: the picture depends neither on the tree, nor on which rays
//! are asked together, nor on the instruction set.

mod builder;
mod bundle;
mod bvh;
mod nodes;
mod packet;
mod plane;
mod search;
mod sphere;
mod surface;
mod triangle;

use fearless_simd::Simd;
use rayon::prelude::*;

pub use surface::{BATCH, PACKETS, Points};
pub(crate) use surface::{Column, columns};

use crate::lanes::{Ids, LANES, Lanes, Mask, Vectors};
use crate::math::{DVec3, Point};
use crate::world::{Plan, Projection, World};
use bundle::Bundle;
use packet::{EMPTY_STACK, Ends, Nearest, Rays, Shadow, Stack};
use search::Search;
use triangle::Facet;

/// How much a few operations in f64 on coordinates of magnitude 1 can be off: each by ε/2, eight of
/// them, and as much again for room. Times a length, it is the bound below which "on the surface"
/// and "beside it" are the same.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

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
    fn lanes<S: Simd>(self, simd: S) -> Ids<S> {
        Ids::splat(simd, self.0)
    }
}

/// The shapes of a world, arranged for tracing.
#[derive(Debug)]
pub struct Visibility<'w> {
    world: &'w World,
    spheres: Search<sphere::Ball>,
    triangles: Search<Facet>,
    is_smooth: bool,
}

/// What a thread needs to trace batches, to be used again and again.
#[derive(Debug)]
pub struct Workspace {
    /// Of a perspective camera where each ray goes, of an orthographic one where each starts.
    varying: [Column; 3],
    stack: Box<Stack>,
}

impl Default for Workspace {
    fn default() -> Self {
        Self {
            varying: [[0.0; BATCH]; 3],
            stack: Box::new(EMPTY_STACK),
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
    vectors: impl Fn(usize) -> Vectors<S>,
) -> Option<[DVec3; 2]> {
    let infinite = Vectors::splat(simd, DVec3::INFINITY);
    let (mut least, mut most) = (infinite, -infinite);
    let mut any = 0;
    for packet in 0..PACKETS {
        let bits = bits(packet);
        if bits == 0 {
            continue;
        }
        any |= bits;
        let asked = Mask::from_bits(simd, bits);
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
        let triangles = world.triangles();
        let facets = triangles.meshes().par_iter().flat_map(|mesh| {
            mesh.triangles.clone().into_par_iter().map(|index| {
                let primitive = Primitive::triangle(mesh.object, index);
                Facet::new(primitive, triangles.vertices(index))
            })
        });
        Self {
            world,
            spheres: Search::new(
                world.spheres().iter().map(sphere::Ball::new).collect(),
                plan.spheres(),
            ),
            triangles: Search::new(facets.collect(), plan.triangles()),
            is_smooth: triangles.meshes().iter().any(|mesh| mesh.normals.is_some()),
        }
    }

    /// L1 and L2: the points that the primary rays through points of the image (in pixels) hit.
    #[inline(never)]
    pub(crate) fn see<S: Simd>(
        &self,
        simd: S,
        places: [&Column; 2],
        count: usize,
        space: &mut Workspace,
        points: &mut Points,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.see_all(simd, places, count, space, points),
        );
    }

    #[inline(always)]
    fn see_all<S: Simd>(
        &self,
        simd: S,
        [xs, ys]: [&Column; 2],
        count: usize,
        space: &mut Workspace,
        points: &mut Points,
    ) {
        let camera = self.world.camera();
        for packet in 0..PACKETS {
            let x = Lanes::load(simd, &xs[packet * LANES..]);
            let y = Lanes::load(simd, &ys[packet * LANES..]);
            let varying = camera.varying(simd, x, y);
            let [x, y, z] = &mut space.varying;
            let lanes = packet * LANES..(packet + 1) * LANES;
            varying.store([&mut x[lanes.clone()], &mut y[lanes.clone()], &mut z[lanes]]);
        }
        let varying = &space.varying;
        let range = ranges(
            simd,
            #[inline(always)]
            |packet| first_lanes(count, packet),
            #[inline(always)]
            |packet| Vectors::load(simd, columns(varying, packet)),
        );
        let Some(range) = range else {
            points.hit = [0; PACKETS];
            return;
        };
        let is_perspective = matches!(camera.projection(), Projection::Perspective { .. });
        let (eye, forward) = (camera.eye(), camera.forward().get());
        let bundle = if is_perspective {
            Bundle::new([eye.0; 2], range, f64::INFINITY)
        } else {
            Bundle::new(range, [forward; 2], f64::INFINITY)
        };
        let spheres = self.spheres.within(&bundle);
        let triangles = self.triangles.within(&bundle);
        for packet in 0..PACKETS {
            let bits = first_lanes(count, packet);
            if bits == 0 {
                points.hit[packet] = 0;
                continue;
            }
            let varying = Vectors::load(simd, columns(varying, packet));
            let rays = if is_perspective {
                Rays::from_point(simd, eye, varying)
            } else {
                Rays::new(simd, varying, Vectors::splat(simd, forward), None)
            };
            let mut nearest = Nearest::new(simd, bits);
            for plane in self.world.planes() {
                plane::intersect(simd, plane, &rays, &mut nearest);
            }
            spheres.ask(simd, &rays, &mut nearest, &mut space.stack);
            triangles.ask(simd, &rays, &mut nearest, &mut space.stack);
            points.fill(simd, self.world, packet, &rays, &nearest);
            if self.is_smooth {
                let ray = |slot: usize| {
                    let varying = DVec3::from_array(varying_at(&space.varying, slot));
                    if is_perspective {
                        (eye.0, varying)
                    } else {
                        (varying, forward)
                    }
                };
                points.interpolate(self.world, packet, ray);
            }
        }
    }

    /// L4: which of the points with a bit in `facing` the light reaches. Asked only of points whose
    /// geometric normal faces the light.
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
        let range = ranges(
            simd,
            #[inline(always)]
            |packet| facing[packet],
            #[inline(always)]
            |packet| way(simd, points, packet, light),
        );
        let Some(range) = range else {
            return [0; PACKETS];
        };
        let bundle = Bundle::new([light.0; 2], range, 1.0);
        let spheres = self.spheres.within(&bundle);
        let triangles = self.triangles.within(&bundle);
        let planes = self.world.planes();
        if planes.is_empty() && spheres.is_empty() && triangles.is_empty() {
            return *facing;
        }
        let mut lit = [0; PACKETS];
        for packet in 0..PACKETS {
            if facing[packet] == 0 {
                continue;
            }
            let lanes = packet * LANES;
            let ends = Ends {
                position: Vectors::load(simd, columns(&points.position, packet)),
                error: Lanes::load(simd, &points.error[lanes..]),
                primitive: Ids::load(simd, &points.primitive[lanes..]),
            };
            let mut shadow = Shadow {
                light,
                points: &ends,
                asked: Mask::from_bits(simd, facing[packet]),
                asked_bits: facing[packet],
            };
            for plane in planes {
                plane::occlude(simd, plane, &mut shadow);
            }
            if !(spheres.is_empty() && triangles.is_empty()) {
                let rays = Rays::from_point(simd, light, way(simd, points, packet, light));
                spheres.ask(simd, &rays, &mut shadow, &mut space.stack);
                triangles.ask(simd, &rays, &mut shadow, &mut space.stack);
            }
            lit[packet] = shadow.asked_bits;
        }
        lit
    }

    /// Bytes of the arrays and trees.
    pub fn memory(&self) -> usize {
        self.spheres.memory() + self.triangles.memory()
    }
}

/// From a light to the points of a packet.
#[inline(always)]
fn way<S: Simd>(simd: S, points: &Points, packet: usize, light: Point) -> Vectors<S> {
    Vectors::load(simd, columns(&points.position, packet)).minus(light.0)
}

fn varying_at(columns: &[Column; 3], slot: usize) -> [f64; 3] {
    columns.each_ref().map(|column| column[slot])
}
