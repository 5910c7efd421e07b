//! The shapes: how rays meet each, and how each is set up on a projection.

pub(in crate::visibility) mod disk;
pub(in crate::visibility) mod plane;
mod sphere;
pub(in crate::visibility) mod triangle;

use std::fmt;

use fearless_simd::Simd;

use super::primitive::Primitive;
use super::projection::{BatchProjection, DepthTest};
use super::question::{NearestHit, Occlusion};
use super::rays::ShearedRays;
use super::tree::{Beam, Bounds};
pub(in crate::visibility) use sphere::{Sphere, SphereBlock};
pub(in crate::visibility) use triangle::{
    PlaneSetup, SingleRay, Triangle, TriangleBlock, TrianglePerRay, edge, side_by_side,
};

/// A shape that fits in a box.
pub(in crate::visibility) trait Shape: Copy + Send + Sync {
    /// Several of them, as the projection takes them.
    type Block: Block<Self>;

    /// Where the shapes are as they are, if blocks have no more of them than projections need.
    type Exact: fmt::Debug + Send + Sync;

    /// How many, at most sixteen.
    const WIDTH: usize;

    /// What the slots of this kind of shape have in common.
    const SLOTS: u32;

    /// The smallest box around it.
    fn bounds(&self) -> Bounds;

    /// L2: offers where the rays hit it at t above 0.
    fn intersect<S: Simd>(&self, simd: S, packet: &ShearedRays<S>, nearest: &mut NearestHit<S>);

    /// L4: hides the points that it stands strictly before.
    fn occlude<S: Simd>(&self, simd: S, packet: &ShearedRays<S>, occlusion: &mut Occlusion<'_, S>);

    /// Whether it is certain, and soon told, that no ray on a projection meets it.
    fn is_beside(&self, projection: &BatchProjection) -> bool;
}

/// A few shapes side by side.
pub(in crate::visibility) trait Block<T: Shape>: Send + Sync {
    /// What a projection makes of them before it is looked at ray by ray.
    type Setup;

    /// Of [`Shape::WIDTH`] shapes or fewer, at least one; the first has the number `first`, the others follow.
    fn of(shapes: &[T], first: u32) -> Self;

    /// One of them, by its place.
    fn get(&self, exact: &T::Exact, place: usize) -> T;

    /// Which one is at a place.
    fn primitive(&self, place: usize) -> Primitive;

    /// One bit for each place that the rays of a beam might meet a shape at.
    fn near<S: Simd>(&self, simd: S, beam: &Beam) -> u32;

    /// Has it on its way from memory.
    fn touch(&self);

    /// Rasterizes those with a bit. The first has the slot `slot`, the others follow.
    fn rasterize<S: Simd>(
        &self,
        simd: S,
        bits: u32,
        slot: u32,
        setup: &mut Self::Setup,
        projection: &mut BatchProjection,
        depth_test: impl DepthTest,
    );
}
