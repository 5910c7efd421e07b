//! Sixteen rays at a time: what they are, what they ask, and their way down a tree.

use fearless_simd::Simd;

use super::Primitive;
use super::beam::{Beam, Stack, range};
use super::nodes::Tree;
use super::search::Shape;
use super::triangle::{Shears, shears};
use crate::math::{DVec3, Point};
use crate::simd::{DVec3x16, F64x16, LANES, Mask64x16, U64x16};

/// Rays r(t) = o + t ω, side by side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rays<S: Simd> {
    pub(super) origin: DVec3x16<S>,
    pub(super) direction: DVec3x16<S>,
    /// Where all start, if they start at one point.
    pub(super) shared_origin: Option<DVec3>,
    /// |ω|²
    pub(super) square: F64x16<S>,
}

/// Rays that are asked together.
#[derive(Clone, Copy, Debug)]
pub(super) struct Packet<S: Simd> {
    pub(super) rays: Rays<S>,
    pub(super) shears: Shears<S>,
}

impl<S: Simd> Packet<S> {
    #[inline(always)]
    pub(super) fn new(rays: Rays<S>) -> Self {
        Self {
            rays,
            shears: shears(rays.direction),
        }
    }
}

impl<S: Simd> Rays<S> {
    /// Rays from one point.
    #[inline(always)]
    pub(super) fn from_point(simd: S, origin: Point, direction: DVec3x16<S>) -> Self {
        let origins = DVec3x16::splat(simd, origin.0);
        Self::new(origins, direction, Some(origin.0))
    }

    #[inline(always)]
    pub(super) fn new(
        origin: DVec3x16<S>,
        direction: DVec3x16<S>,
        shared_origin: Option<DVec3>,
    ) -> Self {
        Self {
            origin,
            direction,
            shared_origin,
            square: direction.dot(direction),
        }
    }
}

/// The nearest hits so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Nearest<S: Simd> {
    /// The rays that ask.
    pub(super) asked: Mask64x16<S>,
    pub(super) asked_bits: u32,
    /// t; infinite where nothing is hit.
    pub(super) t: F64x16<S>,
    pub(super) primitive: U64x16<S>,
}

impl<S: Simd> Nearest<S> {
    #[inline(always)]
    pub(super) fn new(simd: S, asked_bits: u32) -> Self {
        Self {
            asked: Mask64x16::from_bits(simd, asked_bits),
            asked_bits,
            t: F64x16::splat(simd, f64::INFINITY),
            primitive: U64x16::splat(simd, u64::MAX),
        }
    }

    /// Takes the hits that are nearer; at the same distance what is written first in the scene.
    #[inline(always)]
    pub(super) fn offer(
        &mut self,
        simd: S,
        found: Mask64x16<S>,
        t: F64x16<S>,
        primitive: Primitive,
    ) {
        let primitive = primitive.lanes(simd);
        let ties = t.eq(self.t) & primitive.lt(self.primitive);
        let is_nearer = found & self.asked & (t.lt(self.t) | ties);
        self.t = is_nearer.select(t, self.t);
        self.primitive = is_nearer.select_ids(primitive, self.primitive);
    }
}

/// Points of surfaces that ask for a light.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends<S: Simd> {
    pub(super) position: DVec3x16<S>,
    pub(super) error: F64x16<S>,
    pub(super) primitive: U64x16<S>,
}

/// Which points a light reaches, so far.
#[derive(Debug)]
pub(super) struct Shadow<'p, S: Simd> {
    pub(super) light: Point,
    pub(super) points: &'p Ends<S>,
    /// Those that nothing is known to hide.
    pub(super) asked: Mask64x16<S>,
    pub(super) asked_bits: u32,
}

impl<S: Simd> Shadow<'_, S> {
    #[inline(always)]
    pub(super) fn hide(&mut self, hidden: Mask64x16<S>) {
        self.asked = self.asked & !hidden;
        self.asked_bits = self.asked.to_bits();
    }
}

/// What a packet asks of the shapes in a tree.
pub(super) trait Question<S: Simd> {
    /// One bit for each ray that still asks.
    fn asked(&self) -> u32;

    /// The largest t that is of interest to any of them.
    fn limit(&self, simd: S) -> f64;

    /// How far the ends of their rays may be from where they should be.
    fn error(&self, simd: S) -> f64;

    /// Asks one shape.
    fn ask<T: Shape>(&mut self, simd: S, packet: &Packet<S>, shape: &T);

    /// Asks only for some of the rays from now on.
    fn only(&mut self, simd: S, bits: u32);
}

impl<S: Simd> Question<S> for Nearest<S> {
    #[inline(always)]
    fn asked(&self) -> u32 {
        self.asked_bits
    }

    #[inline(always)]
    fn limit(&self, simd: S) -> f64 {
        let zero = F64x16::splat(simd, 0.0);
        self.asked.select(self.t, zero).largest()
    }

    #[inline(always)]
    fn error(&self, _: S) -> f64 {
        // They end on no shape yet.
        0.0
    }

    #[inline(always)]
    fn ask<T: Shape>(&mut self, simd: S, packet: &Packet<S>, shape: &T) {
        shape.intersect(simd, packet, self);
    }

    #[inline(always)]
    fn only(&mut self, simd: S, bits: u32) {
        self.asked_bits = bits;
        self.asked = Mask64x16::from_bits(simd, bits);
    }
}

impl<S: Simd> Question<S> for Shadow<'_, S> {
    #[inline(always)]
    fn asked(&self) -> u32 {
        self.asked_bits
    }

    #[inline(always)]
    fn limit(&self, _: S) -> f64 {
        // A shadow ray ends at the point.
        1.0
    }

    #[inline(always)]
    fn error(&self, simd: S) -> f64 {
        let zero = F64x16::splat(simd, 0.0);
        self.asked.select(self.points.error, zero).largest()
    }

    #[inline(always)]
    fn ask<T: Shape>(&mut self, simd: S, packet: &Packet<S>, shape: &T) {
        shape.occlude(simd, packet, self);
    }

    #[inline(always)]
    fn only(&mut self, simd: S, bits: u32) {
        self.asked_bits = bits;
        self.asked = Mask64x16::from_bits(simd, bits);
    }
}

/// Rays whose directions differ by more than this part of their length do not share a beam: at a
/// silhouette, points of the object and points far behind it would be enclosed in one.
const MOST_BEAM_SPREAD: f64 = 1.0 / 64.0;

/// How far apart some rays are.
struct Spread {
    /// The middle of their directions.
    middle: DVec3,
    /// One bit for each of those that should go without the others; 0 if all are alike.
    parted: u32,
}

impl Spread {
    /// Of the rays with a bit.
    #[inline(always)]
    fn of<S: Simd>(simd: S, rays: &Rays<S>, bits: u32) -> Self {
        let asked = Mask64x16::from_bits(simd, bits);
        let d = rays.direction;
        let directions = [
            range(simd, d.x, asked),
            range(simd, d.y, asked),
            range(simd, d.z, asked),
        ];
        let (mut widest, mut width, mut length) = (0, 0.0, 0.0);
        for (axis, [least, most]) in directions.into_iter().enumerate() {
            if most - least > width {
                (widest, width) = (axis, most - least);
            }
            length = f64::max(length, f64::max(most.abs(), least.abs()));
        }
        let mut parted = 0;
        if width > length * MOST_BEAM_SPREAD {
            let [least, most] = directions[widest];
            let middle = F64x16::splat(simd, least * 0.5 + most * 0.5);
            parted = d.component(widest).lt(middle).to_bits() & bits;
        }
        let [x, y, z] = directions;
        Self {
            middle: DVec3::new(
                x[0] * 0.5 + x[1] * 0.5,
                y[0] * 0.5 + y[1] * 0.5,
                z[0] * 0.5 + z[1] * 0.5,
            ),
            // Neither part is empty, unless rounding makes it so.
            parted: if parted == bits { 0 } else { parted },
        }
    }
}

/// Shows a packet's question the leaves of a tree that its rays might meet, near ones first: `show` is
/// given a leaf's first block and how many shapes it has.
#[inline(always)]
pub(super) fn descend<S: Simd, Q: Question<S>>(
    simd: S,
    tree: &Tree,
    packet: &Packet<S>,
    question: &mut Q,
    stack: &mut Stack,
    mut show: impl FnMut(u32, u32, &Beam, &mut Q),
) {
    if question.asked() == 0 {
        return;
    }
    // Rays too unlike for one beam part into groups.
    let mut groups = [0; LANES];
    groups[0] = question.asked();
    let mut waiting = 1;
    let mut left = 0;
    while waiting > 0 {
        waiting -= 1;
        let group = groups[waiting];
        let Spread { middle, parted } = Spread::of(simd, &packet.rays, group);
        if parted == 0 {
            question.only(simd, group);
            let error = question.error(simd);
            let (beam, pace) = Beam::of(simd, tree, &packet.rays, middle, group, error);
            beam.descend(
                simd,
                tree,
                question.limit(simd) * pace,
                stack,
                #[inline(always)]
                |block, count, _| {
                    show(block, count, &beam, question);
                    (question.asked() != 0).then(
                        #[inline(always)]
                        || question.limit(simd) * pace,
                    )
                },
            );
            left |= question.asked();
        } else {
            groups[waiting] = group & parted;
            groups[waiting + 1] = group & !parted;
            waiting += 2;
        }
    }
    question.only(simd, left);
}
