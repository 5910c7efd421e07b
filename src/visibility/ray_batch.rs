//! Rays of a batch, by what they share.

use fearless_simd::Simd;

use super::batch::{BATCH, Column, columns, columns_from, columns_mut, first_lanes, vector};
use super::rays::Rays;
use crate::math::{DVec3, Point};
use crate::simd::{DVec3x16, F64x16, LANES, U64x16, ones};

/// At most [`BATCH`] rays r(t) = o + t ω, ω of any length but zero, with what they have in common, if anything.
///
/// What differs among rays that share something is a function `F` of a packet's number: it is called when it is
/// needed, perhaps more than once, perhaps never.
#[derive(Clone, Copy, Debug)]
pub(crate) enum RayBatch<'r, F> {
    /// They start at one point: those of a perspective camera, and of its image in a plane mirror.
    FromPoint {
        origin: Point,
        direction: F,
        count: usize,
        /// Four directions that enclose all of theirs, where these are known.
        around: Option<[DVec3; 4]>,
    },
    /// They go one way: those of an orthographic camera.
    Along {
        direction: DVec3,
        origin: F,
        count: usize,
    },
    /// Nothing.
    Any(&'r IncoherentRays),
}

/// Rays, each with an origin and a direction of its own, ray by ray in columns.
#[derive(Clone, Debug)]
pub(crate) struct IncoherentRays {
    origin: [Column; 3],
    direction: [Column; 3],
    /// Where each starts, if any starts at a surface.
    starts: Option<Box<Starts>>,
    /// The origin of all of them, where they share one and leave surfaces beyond it.
    eye: Option<DVec3>,
    count: usize,
}

/// Where rays leave surfaces.
#[derive(Clone, Debug)]
struct Starts {
    /// t of each start: nothing before it is met.
    t: Column,
    position: [Column; 3],
    error: Column,
    primitive: [u64; BATCH],
}

/// Where a ray leaves a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayStart {
    /// t there: nothing before it is met. 0 for a ray whose origin is its start; one that comes out of a plane mirror
    /// has the image of its eye in that mirror for an origin.
    pub(crate) t: f64,
    pub(crate) position: DVec3,
    /// A bound on the rounding error of the position: flat shapes whose planes are no further away are not met.
    pub(crate) error: f64,
    /// What it is on: a flat shape is not met again, a sphere at its other side alone.
    pub(crate) primitive: u64,
}

/// Where the rays of a packet leave surfaces: [`RayStart`] lane by lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RayStarts<S: Simd> {
    pub(super) t: F64x16<S>,
    pub(super) position: DVec3x16<S>,
    pub(super) error: F64x16<S>,
    pub(super) primitive: U64x16<S>,
}

impl RayStart {
    /// The same for all lanes.
    #[inline(always)]
    pub(super) fn lanes<S: Simd>(&self, simd: S) -> RayStarts<S> {
        RayStarts {
            t: F64x16::splat(simd, self.t),
            position: DVec3x16::splat(simd, self.position),
            error: F64x16::splat(simd, self.error),
            primitive: U64x16::splat(simd, self.primitive),
        }
    }
}

impl Starts {
    fn none() -> Box<Self> {
        Box::new(Self {
            t: Column::ZERO,
            position: [Column::ZERO; 3],
            error: Column::ZERO,
            primitive: [u64::MAX; BATCH],
        })
    }
}

impl<F> RayBatch<'_, F> {
    /// One bit for each ray of a packet.
    #[inline(always)]
    pub(super) fn lanes(&self, packet: usize) -> u32 {
        match *self {
            Self::FromPoint { count, .. } | Self::Along { count, .. } => first_lanes(count, packet),
            Self::Any(rays) => first_lanes(rays.count, packet),
        }
    }

    /// The rays of a packet.
    #[inline(always)]
    pub(super) fn packet<S: Simd>(&self, simd: S, packet: usize) -> Rays<S>
    where
        F: Fn(usize) -> DVec3x16<S>,
    {
        match self {
            Self::FromPoint {
                origin, direction, ..
            } => Rays::from_point(simd, *origin, direction(packet)),
            Self::Along {
                direction, origin, ..
            } => Rays::new(origin(packet), DVec3x16::splat(simd, *direction), None),
            Self::Any(rays) => rays.packet(simd, packet),
        }
    }
}

impl Default for IncoherentRays {
    fn default() -> Self {
        Self {
            origin: [Column::ZERO; 3],
            direction: [Column::ZERO; 3],
            starts: None,
            eye: None,
            count: 0,
        }
    }
}

impl IncoherentRays {
    /// Forgets all rays.
    pub(crate) fn clear(&mut self) {
        self.count = 0;
        self.eye = None;
    }

    /// Puts a ray to the others; there are at most [`BATCH`].
    pub(crate) fn push(&mut self, origin: DVec3, direction: DVec3) {
        debug_assert!(self.count < BATCH);
        for axis in 0..3 {
            self.origin[axis][self.count] = origin[axis];
            self.direction[axis][self.count] = direction[axis];
        }
        self.count += 1;
    }

    /// Takes all rays of a batch.
    #[inline(always)]
    pub(crate) fn take<S: Simd>(
        &mut self,
        simd: S,
        batch: &RayBatch<'_, impl Fn(usize) -> DVec3x16<S>>,
    ) {
        self.count = match batch {
            RayBatch::FromPoint { count, .. } | RayBatch::Along { count, .. } => *count,
            RayBatch::Any(rays) => rays.count,
        };
        (self.starts, self.eye) = (None, None);
        for packet in 0..self.count.div_ceil(LANES) {
            let rays = batch.packet(simd, packet);
            rays.origin.store(columns_mut(&mut self.origin, packet));
            rays.direction
                .store(columns_mut(&mut self.direction, packet));
        }
    }

    /// Puts a ray that leaves a surface to the others, all of which do.
    #[inline]
    pub(crate) fn push_from(&mut self, origin: DVec3, direction: DVec3, start: &RayStart) {
        let ray = self.count;
        let is_shared = start.t > 0.0 && (ray == 0 || self.eye == Some(origin));
        self.eye = is_shared.then_some(origin);
        self.push(origin, direction);
        let starts = self.starts.get_or_insert_with(Starts::none);
        starts.t[ray] = start.t;
        for axis in 0..3 {
            starts.position[axis][ray] = start.position[axis];
        }
        starts.error[ray] = start.error;
        starts.primitive[ray] = start.primitive;
    }

    /// Puts the rays of a packet to the others that come from the image of their eye in a plane mirror, and leave a
    /// surface: as [`Self::push_from`] does one by one.
    #[inline(always)]
    pub(crate) fn push_reflected<S: Simd>(
        &mut self,
        simd: S,
        bits: u32,
        (origin, direction): (DVec3, DVec3x16<S>),
        left: &RayStarts<S>,
    ) {
        let place = self.count;
        let is_shared = place == 0 || self.eye == Some(origin);
        self.eye = is_shared.then_some(origin);
        self.count += bits.count_ones() as usize;
        let starts = self.starts.get_or_insert_with(Starts::none);
        let primitive = left.primitive.to_array();
        if self.count == place + LANES {
            DVec3x16::splat(simd, origin).store(columns_from(&mut self.origin, place));
            direction.store(columns_from(&mut self.direction, place));
            left.t.store(&mut starts.t[place..]);
            left.position
                .store(columns_from(&mut starts.position, place));
            left.error.store(&mut starts.error[place..]);
            starts.primitive[place..place + LANES].copy_from_slice(&primitive);
            return;
        }
        let [direction, position] =
            [direction, left.position].map(|v| [v.x.to_array(), v.y.to_array(), v.z.to_array()]);
        let (t, error) = (left.t.to_array(), left.error.to_array());
        for (ray, lane) in (place..).zip(ones(bits)) {
            for axis in 0..3 {
                self.origin[axis][ray] = origin[axis];
                self.direction[axis][ray] = direction[axis][lane];
                starts.position[axis][ray] = position[axis][lane];
            }
            starts.t[ray] = t[lane];
            starts.error[ray] = error[lane];
            starts.primitive[ray] = primitive[lane];
        }
    }

    /// Where a ray leaves a surface, if it does.
    #[inline(always)]
    pub(crate) fn start(&self, ray: usize) -> Option<RayStart> {
        let starts = self.starts.as_ref()?;
        Some(RayStart {
            t: starts.t[ray],
            position: vector(&starts.position, ray),
            error: starts.error[ray],
            primitive: starts.primitive[ray],
        })
    }

    /// The origin of all rays, where they share one and leave surfaces beyond it: the image of an eye in a plane mirror.
    #[inline(always)]
    pub(super) fn eye(&self) -> Option<DVec3> {
        self.eye
    }

    /// Where the rays of a packet leave surfaces, if they do.
    #[inline(always)]
    pub(super) fn starts_of_packet<S: Simd>(&self, simd: S, packet: usize) -> Option<RayStarts<S>> {
        let starts = self.starts.as_ref()?;
        let first = packet * LANES;
        Some(RayStarts {
            t: F64x16::load(simd, &starts.t[first..]),
            position: DVec3x16::load(simd, columns(&starts.position, packet)),
            error: F64x16::load(simd, &starts.error[first..]),
            primitive: U64x16::load(simd, &starts.primitive[first..]),
        })
    }

    /// t and error of all starts, and what they are on, if any starts at a surface.
    #[inline(always)]
    pub(super) fn starts(&self) -> Option<([&Column; 2], &[u64; BATCH])> {
        let starts = self.starts.as_ref()?;
        Some(([&starts.t, &starts.error], &starts.primitive))
    }

    /// How many there are.
    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Where they start, and where they go.
    #[inline(always)]
    pub(super) fn vectors(&self) -> [&[Column; 3]; 2] {
        [&self.origin, &self.direction]
    }

    /// Where those of a packet start, and where they go.
    #[inline(always)]
    pub(crate) fn vectors_of_packet<S: Simd>(&self, simd: S, packet: usize) -> [DVec3x16<S>; 2] {
        [
            DVec3x16::load(simd, columns(&self.origin, packet)),
            DVec3x16::load(simd, columns(&self.direction, packet)),
        ]
    }

    /// Where one starts, and where it goes.
    #[inline(always)]
    pub(crate) fn ray(&self, ray: usize) -> [DVec3; 2] {
        [vector(&self.origin, ray), vector(&self.direction, ray)]
    }

    /// Those of a packet.
    #[inline(always)]
    pub(super) fn packet<S: Simd>(&self, simd: S, packet: usize) -> Rays<S> {
        Rays::new(
            DVec3x16::load(simd, columns(&self.origin, packet)),
            DVec3x16::load(simd, columns(&self.direction, packet)),
            None,
        )
    }
}
