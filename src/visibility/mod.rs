//! What a camera ray sees (L2) and what a light reaches (L4).
//!
//! Rays come in batches that share something: the primary rays of a tile share the eye or a
//! direction, the shadow rays to a point light share the light. All is asked here in such
//! batches and answered for the whole batch, so that how a batch is traced is nobody else's
//! business. Each kind of shape is searched on its own, through a list or a tree as the
//! [`Plan`] says.
//!
//! Intersections are computed in f64. The tree's boxes are f32 and conservative, and ties are
//! settled by the order of the scene file: the picture does not depend on the tree.

mod builder;
mod bundle;
mod bvh;
mod descent;
mod plane;
mod search;
mod sphere;
mod surface;
mod triangle;

pub use surface::{Primitive, SurfacePoint};

use rayon::prelude::*;

use crate::math::{DVec3, Point, Ray};
use crate::world::{Plan, World};
use bundle::Bundle;
use search::Search;
use triangle::{Facet, ShearedRay};

/// How much a few operations in f64 on coordinates of magnitude 1 can be off: each by ε/2, eight of
/// them, and as much again for room. Times a length, it is the bound below which "on the surface"
/// and "beside it" are the same.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The primary rays of one batch.
#[derive(Clone, Debug)]
pub enum PrimaryRays {
    /// Of a perspective camera.
    SharedOrigin {
        /// Where all rays start.
        origin: Point,
        /// Where each goes; of any length.
        directions: Vec<DVec3>,
    },
    /// Of an orthographic camera.
    SharedDirection {
        /// Where each starts.
        origins: Vec<Point>,
        /// Where all rays go.
        direction: DVec3,
    },
}

/// The nearest thing that a primary ray hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The ray's parameter (L1). Range: above 0.
    pub t: f64,
    /// What is hit there.
    pub primitive: Primitive,
}

/// The shapes of a world, arranged for tracing.
#[derive(Debug)]
pub struct Visibility<'w> {
    world: &'w World,
    spheres: Search<sphere::Ball>,
    triangles: Search<Facet>,
}

impl PrimaryRays {
    /// The rays of the camera of `world` through points of the image, in pixels.
    pub fn through(world: &World, points: impl Iterator<Item = [f64; 2]>) -> Self {
        use crate::world::Projection;
        let camera = world.camera();
        let rays = points.map(|[x, y]| camera.ray(x, y));
        match camera.projection() {
            Projection::Perspective { .. } => Self::SharedOrigin {
                origin: camera.eye(),
                directions: rays.map(|ray| ray.direction).collect(),
            },
            Projection::Orthographic { .. } => Self::SharedDirection {
                origins: rays.map(|ray| ray.origin).collect(),
                direction: camera.forward().get(),
            },
        }
    }

    /// The rays one by one.
    pub fn iter(&self) -> impl Iterator<Item = Ray> + '_ {
        (0..self.len()).map(|index| match self {
            Self::SharedOrigin { origin, directions } => Ray {
                origin: *origin,
                direction: directions[index],
            },
            Self::SharedDirection { origins, direction } => Ray {
                origin: origins[index],
                direction: *direction,
            },
        })
    }

    /// What all rays have in common; `None` where there are none.
    fn bundle(&self) -> Option<Bundle> {
        match self {
            Self::SharedOrigin { origin, directions } => {
                Bundle::from_point(*origin, directions.iter().copied(), f64::INFINITY)
            }
            Self::SharedDirection { origins, direction } => {
                let origins = origins.iter().map(|origin| origin.0);
                Bundle::parallel(origins, *direction, f64::INFINITY)
            }
        }
    }

    /// How many rays there are.
    pub fn len(&self) -> usize {
        match self {
            Self::SharedOrigin { directions, .. } => directions.len(),
            Self::SharedDirection { origins, .. } => origins.len(),
        }
    }

    /// Whether there is no ray.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

impl<'w> Visibility<'w> {
    /// Arranges the shapes of a world as its plan says; builds the trees.
    pub fn new(world: &'w World, plan: &Plan) -> Self {
        let balls = world.spheres().iter().enumerate();
        let balls = balls.map(|(index, sphere)| sphere::Ball::new(index as u32, sphere));
        let triangles = world.triangles();
        let facets = (0..triangles.len() as u32).into_par_iter();
        let facets = facets.map(|index| Facet::new(index, triangles.vertices(index)));
        Self {
            world,
            spheres: Search::new(balls.collect(), plan.spheres()),
            triangles: Search::new(facets.collect(), plan.triangles()),
        }
    }

    /// L2: the nearest hit of every ray of a batch.
    pub fn nearest(&self, rays: &PrimaryRays) -> Vec<Option<Hit>> {
        let Some(bundle) = rays.bundle() else {
            return Vec::new();
        };
        let rays: Vec<Ray> = rays.iter().collect();
        let mut nearest: Vec<Option<Hit>> = vec![None; rays.len()];
        for (index, plane) in self.world.planes().iter().enumerate() {
            for (ray, nearest) in rays.iter().zip(&mut nearest) {
                if let Some(t) = plane::intersect(plane, ray) {
                    self.keep_nearest(nearest, t, Primitive::Plane(index as u32));
                }
            }
        }
        let limit_of = |nearest: &Option<Hit>| nearest.map_or(f64::INFINITY, |hit| hit.t);
        let mut limits: Vec<f64> = nearest.iter().map(limit_of).collect();

        let spheres = self.spheres.within(&bundle);
        if !spheres.is_empty() {
            spheres.visit(&rays, &mut limits, |ball, ray| {
                if let Some(t) = ball.intersect(&rays[ray]) {
                    self.keep_nearest(&mut nearest[ray], t, Primitive::Sphere(ball.index()));
                }
                limit_of(&nearest[ray])
            });
        }
        let triangles = self.triangles.within(&bundle);
        if !triangles.is_empty() {
            let sheared: Vec<ShearedRay> = rays.iter().copied().map(ShearedRay::new).collect();
            triangles.visit(&rays, &mut limits, |triangle, ray| {
                if let Some(t) = triangle.intersect(&sheared[ray]) {
                    self.keep_nearest(&mut nearest[ray], t, Primitive::Triangle(triangle.index()));
                }
                limit_of(&nearest[ray])
            });
        }
        nearest
    }

    /// Keeps the nearer of two hits; at the same distance the one written first in the scene.
    fn keep_nearest(&self, nearest: &mut Option<Hit>, t: f64, primitive: Primitive) {
        let is_nearer = nearest.is_none_or(|known| {
            t < known.t || (t == known.t && self.rank(primitive) < self.rank(known.primitive))
        });
        if is_nearer {
            *nearest = Some(Hit { t, primitive });
        }
    }

    /// The place of a primitive in the order of the scene file.
    fn rank(&self, primitive: Primitive) -> (u32, u32) {
        match primitive {
            Primitive::Sphere(index) => (self.world.spheres()[index as usize].object, 0),
            Primitive::Plane(index) => (self.world.planes()[index as usize].object, 0),
            Primitive::Triangle(index) => (self.world.triangles().mesh(index).object, index),
        }
    }

    /// The point of the surface that a ray hits, with its normals turned towards the viewer.
    pub fn surface(&self, ray: &Ray, hit: &Hit) -> SurfacePoint {
        SurfacePoint::new(self.world, ray, hit)
    }

    /// L4: for every point, whether the light at `light` reaches it. Asked only of points whose
    /// geometric normal faces the light; `facing` says which, and for the others the answer is
    /// no. At the light itself (d = 0) it is no as well.
    pub fn lit(&self, light: Point, points: &[SurfacePoint], facing: &[bool]) -> Vec<bool> {
        let asked = points.iter().zip(facing).filter(|&(_, &facing)| facing);
        let asked: Vec<&SurfacePoint> = asked.map(|(point, _)| point).collect();
        let mut lit = self.reached(light, &asked).into_iter();
        let answer = |&facing: &bool| facing && lit.next().unwrap_or(false);
        facing.iter().map(answer).collect()
    }

    /// Which of these points the light reaches.
    fn reached(&self, light: Point, points: &[&SurfacePoint]) -> Vec<bool> {
        let shadow_ray = |point: &&SurfacePoint| Ray {
            origin: light,
            direction: point.position.from(light),
        };
        let rays: Vec<Ray> = points.iter().map(shadow_ray).collect();
        let directions = rays.iter().map(|ray| ray.direction);
        let Some(bundle) = Bundle::from_point(light, directions, 1.0) else {
            return Vec::new();
        };
        // The limit of a ray: 1, the point itself, while nothing is known to be in its way.
        const DONE: f64 = -1.0;
        let limit_if = |is_occluded: bool| if is_occluded { DONE } else { 1.0 };
        let mut limits = vec![1.0; rays.len()];
        for (index, plane) in self.world.planes().iter().enumerate() {
            for ((ray, point), limit) in rays.iter().zip(points).zip(&mut limits) {
                let is_own = point.primitive == Primitive::Plane(index as u32);
                if *limit > 0.0 && !is_own {
                    *limit = limit_if(plane::occludes(plane, ray, point));
                }
            }
        }
        let spheres = self.spheres.within(&bundle);
        if !spheres.is_empty() {
            spheres.visit(&rays, &mut limits, |ball, ray| {
                limit_if(ball.occludes(&rays[ray], points[ray]))
            });
        }
        let triangles = self.triangles.within(&bundle);
        if !triangles.is_empty() {
            let sheared: Vec<ShearedRay> = rays.iter().copied().map(ShearedRay::new).collect();
            triangles.visit(&rays, &mut limits, |triangle, ray| {
                limit_if(triangle.occludes(&sheared[ray], points[ray]))
            });
        }
        limits.iter().map(|&limit| limit > 0.0).collect()
    }

    /// Bytes of the arrays and trees.
    pub fn memory(&self) -> usize {
        self.spheres.memory() + self.triangles.memory()
    }
}
