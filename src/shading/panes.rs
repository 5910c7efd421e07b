//! Light that comes through thin panes: V of a segment is the product of T over the panes that it crosses, 0 where
//! anything else stands in its way.

use fearless_simd::Simd;

use crate::math::{DVec3, Direction, Point};
use crate::optics;
use crate::simd::{LANES, ones};
use crate::visibility::{
    BATCH, Column, IncoherentRays, PACKETS, Points, RayStart, Visibility, Workspace,
    object_and_triangle,
};
use crate::world::geometry::area_vector;
use crate::world::{Delta, Shape, World};

/// How much a few roundings of f64 are of a coordinate.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// A segment from a point towards a light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// Where it starts, and what was crossed last.
    pub(crate) start: RayStart,
    pub(crate) origin: DVec3,
    pub(crate) direction: DVec3,
    /// t of the light.
    pub(crate) end: f64,
    /// The product so far.
    pub(crate) passed: f64,
    is_done: bool,
}

impl Crossing {
    /// From a point on a surface to a light at t = `end`.
    pub(crate) fn new(start: RayStart, direction: DVec3, end: f64) -> Self {
        Self {
            origin: start.position,
            start,
            direction,
            end,
            passed: 1.0,
            is_done: false,
        }
    }
}

/// What may stand in the way beside panes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Opaque {
    /// It hides the light.
    Hides,
    /// It is reckoned with elsewhere.
    Ignored,
}

/// What a thread needs for that, to be used again and again.
#[derive(Debug, Default)]
pub(crate) struct PaneSpace {
    rays: Box<IncoherentRays>,
    pub(crate) crossings: Vec<Crossing>,
}

impl PaneSpace {
    /// Lets light come through panes to points that something is before: sets the bits of those that it reaches, and
    /// tells how much of it passes.
    #[inline(never)]
    pub(super) fn through<S: Simd>(
        &mut self,
        simd: S,
        (world, visibility, points): (&World, &Visibility<'_>, &Points),
        (origin, to_light): (Point, Option<Direction>),
        above: &[u32; PACKETS],
        lit: &mut [u32; PACKETS],
        space: &mut Workspace,
    ) -> Option<Box<Column>> {
        self.crossings.clear();
        let mut slots = Vec::new();
        for (packet, (&above, lit)) in above.iter().zip(&*lit).enumerate() {
            for lane in ones(above & !lit) {
                let slot = packet * LANES + lane;
                let start = points.start(slot);
                let (direction, end) = match to_light {
                    Some(to_light) => (to_light.get(), f64::INFINITY),
                    None => (origin.from(start.position), 1.0),
                };
                self.crossings
                    .push(Crossing::new(start.into(), direction, end));
                slots.push(slot);
            }
        }
        self.cross(simd, world, visibility, Opaque::Hides, space);
        let mut passed: Option<Box<Column>> = None;
        for (slot, crossing) in slots.into_iter().zip(&self.crossings) {
            if crossing.passed > 0.0 {
                lit[slot / LANES] |= 1 << (slot % LANES);
                let passed = passed.get_or_insert_with(|| Box::new(Column([1.0; BATCH])));
                passed[slot] = crossing.passed;
            }
        }
        passed
    }

    /// Finds out how much of the light comes along each of the segments.
    #[inline(never)]
    pub(crate) fn cross<S: Simd>(
        &mut self,
        simd: S,
        world: &World,
        visibility: &Visibility<'_>,
        opaque: Opaque,
        space: &mut Workspace,
    ) {
        let Self { rays, crossings } = self;
        for crossings in crossings.chunks_mut(BATCH) {
            loop {
                rays.clear();
                for crossing in crossings.iter().filter(|crossing| !crossing.is_done) {
                    rays.push_from(crossing.origin, crossing.direction, &crossing.start);
                }
                if rays.count() == 0 {
                    break;
                }
                let hits = visibility.hits(simd, rays, space);
                let open = crossings.iter_mut().filter(|crossing| !crossing.is_done);
                for (ray, crossing) in open.enumerate() {
                    crossing.meet(world, opaque, hits.t[ray], hits.primitive[ray]);
                }
            }
        }
    }
}

impl Crossing {
    /// What becomes of it where it meets a shape at t.
    fn meet(&mut self, world: &World, opaque: Opaque, t: f64, primitive: u64) {
        // Also where t is infinite.
        if t >= self.end {
            self.is_done = true;
            return;
        }
        let (object, triangle) = object_and_triangle(primitive);
        let object = &world.objects()[object as usize];
        let position = self.origin + self.direction * t;
        if let Some(Delta::Pane { n }) = world.delta(object.material) {
            let normal = match object.shape {
                Shape::Sphere(index) => position - world.spheres()[index].center.0,
                Shape::Plane(index) => world.planes()[index].normal.get(),
                Shape::Disk(index) => world.disks()[index].normal.get(),
                Shape::Mesh(_) => area_vector(world.triangles().vertices(triangle)),
            };
            let lengths = (normal.length_squared() * self.direction.length_squared()).sqrt();
            let cosine = (normal.dot(self.direction) / lengths).abs().min(1.0);
            let [_, transmittance] = optics::pane(cosine, *n);
            self.passed *= transmittance;
        } else if opaque == Opaque::Hides {
            self.passed = 0.0;
        }
        let size = self.origin.abs() + (self.direction * t).abs();
        self.start = RayStart {
            t,
            position,
            error: ROUNDING * (size.x + size.y + size.z),
            primitive,
        };
        self.is_done = self.passed == 0.0;
    }
}
