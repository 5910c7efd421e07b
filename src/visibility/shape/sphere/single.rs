//! One ray before the spheres of a block: L2 and L4 in f64, to the bits of [`super::Sphere`]'s.

use fearless_simd::Simd;

use super::conic::SphereLanes;
use super::{Crossings, SphereBlock, crossings, is_between};
use crate::simd::{DVec3x16, F64x16, Mask64x16};
use crate::visibility::primitive::Primitive;
use crate::visibility::question::End;
use crate::visibility::rays::{ROUNDING, Rays};

impl SphereBlock {
    pub(in crate::visibility) fn primitive(&self, place: usize) -> Primitive {
        Primitive::whole(self.object[place])
    }

    /// L2: which of the spheres with a bit a ray meets at t above 0, from outside or inside, and where first;
    /// `None` if it is none. All of `rays` are the one.
    #[inline(always)]
    pub(in crate::visibility) fn first_met<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        bits: u32,
    ) -> Option<(Mask64x16<S>, F64x16<S>)> {
        let SphereLanes { center, radius, .. } = self.spheres(simd);
        let asked = Mask64x16::from_bits(simd, bits);
        let oc = -(rays.origin - center);
        let Crossings {
            exist,
            first,
            second,
        } = crossings(
            simd,
            oc,
            radius,
            rays,
            asked,
            #[inline(always)]
            || oc.dot(oc).sqrt(),
        )?;
        let t = first.is_positive().select(first, second);
        Some((exist & t.is_positive(), t))
    }

    /// One bit for each place that has a shape.
    #[inline(always)]
    pub(in crate::visibility) fn places_of(&self, primitive: Primitive) -> u32 {
        let (object, part) = primitive.parts();
        if part != 0 {
            return 0;
        }
        let mut bits = 0;
        for (place, &other) in self.object.iter().enumerate() {
            bits |= u32::from(other == object) << place;
        }
        bits
    }

    /// L4: whether one of the spheres with a bit stands strictly between the ends of a segment. All of `rays` are
    /// the one from the start to the end.
    ///
    /// An end is on a sphere if that is its own, or if it is off it by no more than its error; then no root
    /// of L2 there can be trusted. From a start on a sphere a segment that leads inwards leaves it again
    /// unless the end is inside or on it; one that leads outwards never comes back. The same holds from
    /// the end backwards. A chord hides nothing. (A start without an error, a light, is on no sphere: it counts
    /// as a crossing only what is further from it than rounding.)
    #[inline(always)]
    pub(in crate::visibility) fn hides<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        [start, end]: [&End; 2],
        bits: u32,
    ) -> bool {
        let SphereLanes { center, radius, .. } = self.spheres(simd);
        let asked = Mask64x16::from_bits(simd, bits);
        let from_start = -(center - DVec3x16::splat(simd, start.position));
        let start_distance = from_start.dot(from_start).sqrt();
        let start_length = start.position.length();
        let at_start = (start_distance + radius + start_length) * ROUNDING + start.error;
        let start_off = start_distance - radius;
        let is_own = Mask64x16::from_bits(simd, self.places_of(start.primitive));
        let is_on_start = if start.error > 0.0 {
            is_own | start_off.abs().le(at_start)
        } else {
            is_own
        };
        let outwards = DVec3x16::splat(simd, end.position) - center;
        let distance_square = outwards.dot(outwards);
        let reach = outwards.taxicab() + radius;
        let at_end = reach * ROUNDING + end.error;
        let off = distance_square - radius * radius;
        let is_on_end = Mask64x16::from_bits(simd, self.places_of(end.primitive))
            | off.abs().le(at_end * reach);
        // From the start inwards to an end outside, and from a start outside inwards at the end.
        let leads_in = (-from_start.dot(rays.direction)).is_positive();
        let leads_out = outwards.dot(rays.direction).is_positive();
        let from_on = is_on_start & !is_on_end & leads_in & off.is_positive();
        let to_on = is_on_end & !is_on_start & leads_out & start_off.gt(at_start);
        if ((from_on | to_on) & asked).any() {
            return true;
        }
        let free = asked & !is_on_start & !is_on_end;
        let oc = -(rays.origin - center);
        let crossings = crossings(
            simd,
            oc,
            radius,
            rays,
            free,
            #[inline(always)]
            || oc.dot(oc).sqrt(),
        );
        crossings.is_some_and(
            #[inline(always)]
            |Crossings {
                 exist,
                 first,
                 second,
             }| {
                let hidden = is_between(simd, first, rays, at_start)
                    | is_between(simd, second, rays, at_start);
                (exist & hidden).any()
            },
        )
    }
}
