//! Sixteen rays at a time: how they put their question to shapes, and their way down a tree.

use fearless_simd::Simd;

use super::batch::range;
use super::question::{NearestHit, Occlusion};
use super::rays::{Rays, ShearedRays};
use super::shape::Shape;
use super::tree::{Beam, Stack, Tree};
use crate::math::DVec3;
use crate::simd::{F64x16, LANES, Mask64x16};

/// What a packet asks of the shapes in a tree.
pub(super) trait Question<S: Simd> {
    /// One bit for each ray that still asks.
    fn asked(&self) -> u32;

    /// The largest t that is of interest to any of them.
    fn limit(&self, simd: S) -> f64;

    /// How far the ends of their rays may be from where they should be.
    fn error(&self, simd: S) -> f64;

    /// Asks one shape.
    fn ask<T: Shape>(&mut self, simd: S, packet: &ShearedRays<S>, shape: &T);

    /// Asks only for some of the rays from now on.
    fn only(&mut self, simd: S, bits: u32);
}

impl<S: Simd> Question<S> for NearestHit<S> {
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
    fn ask<T: Shape>(&mut self, simd: S, packet: &ShearedRays<S>, shape: &T) {
        shape.intersect(simd, packet, self);
    }

    #[inline(always)]
    fn only(&mut self, simd: S, bits: u32) {
        self.asked_bits = bits;
        self.asked = Mask64x16::from_bits(simd, bits);
    }
}

impl<S: Simd> Question<S> for Occlusion<'_, S> {
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
    fn ask<T: Shape>(&mut self, simd: S, packet: &ShearedRays<S>, shape: &T) {
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
    packet: &ShearedRays<S>,
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
