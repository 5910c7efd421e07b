//! What `benches/rays` asks: batches of rays and segments that share nothing. Not part of the library's face.

use fearless_simd::Simd;

use crate::math::DVec3;
use crate::simd::{Kernel, SimdLevel};
use crate::visibility::{
    BATCH, IncoherentRays, IncoherentSegments, PACKETS, SegmentBatch, Visibility, Workspace,
};
use crate::world::{Plan, World};

/// A world whose trees are built, on one thread.
#[derive(Debug)]
pub struct Tracer<'w> {
    visibility: Visibility<'w>,
    level: SimdLevel,
    space: Workspace,
    rays: Box<IncoherentRays>,
    segments: Box<IncoherentSegments>,
}

struct Nearest<'t, 'w>(&'t mut Tracer<'w>, &'t mut Vec<f64>);

impl Kernel for Nearest<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self(tracer, t) = self;
        let Tracer {
            visibility,
            space,
            rays,
            ..
        } = tracer;
        let hits = visibility.hits(simd, rays, space);
        t.extend(&hits.t[..rays.count()]);
    }
}

struct Free<'t, 'w>(&'t mut Tracer<'w>);

impl Kernel for Free<'_, '_> {
    type Output = [u32; PACKETS];

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let Tracer {
            visibility,
            space,
            segments,
            ..
        } = self.0;
        visibility.free(simd, SegmentBatch::Any(segments), space)
    }
}

impl<'w> Tracer<'w> {
    /// Builds the trees of a world.
    pub fn new(world: &'w World, level: SimdLevel) -> Self {
        Self {
            visibility: Visibility::new(world, &Plan::new(world)),
            level,
            space: Workspace::default(),
            rays: Box::default(),
            segments: Box::default(),
        }
    }

    /// t of the nearest hit of each ray o + t ω, infinite where there is none.
    pub fn nearest(&mut self, rays: &[[DVec3; 2]], t: &mut Vec<f64>) {
        t.clear();
        for rays in rays.chunks(BATCH) {
            self.rays.clear();
            for &[origin, direction] in rays {
                self.rays.push(origin, direction);
            }
            self.level.run(Nearest(self, t));
        }
    }

    /// Whether nothing is between the ends of each segment, given as its start and the way to its end.
    pub fn free(&mut self, segments: &[[DVec3; 2]], free: &mut Vec<bool>) {
        free.clear();
        for segments in segments.chunks(BATCH) {
            self.segments.count = segments.len();
            for (place, &[start, way]) in segments.iter().enumerate() {
                self.segments.start.set(place, start, 0.0, u64::MAX);
                self.segments.end.set(place, start + way, 0.0, u64::MAX);
            }
            let bits = self.level.run(Free(self));
            let places = 0..segments.len();
            free.extend(places.map(|place| bits[place / 16] >> (place % 16) & 1 == 1));
        }
    }
}
