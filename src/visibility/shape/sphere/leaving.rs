//! Spheres before rays that leave surfaces: what they meet after their start.

use fearless_simd::Simd;

use super::conic::SphereLanes;
use super::{Crossings, Sphere, SphereBlock, crossings};
use crate::simd::{DVec3x16, F64x16, Mask64x16};
use crate::visibility::primitive::Primitive;
use crate::visibility::ray_batch::RayStarts;
use crate::visibility::rays::Rays;

/// L2: which of the rays in `asked` meet the spheres of their lanes after their starts, and where first; `None` if none
/// does.
///
/// Where a start is on a sphere, its `own` or one that it is on up to its rounding error, one of the crossings is there,
/// and the other as far beyond the middle of both.
#[inline(always)]
fn first_met_after<S: Simd>(
    simd: S,
    rays: &Rays<S>,
    starts: &RayStarts<S>,
    spheres: &SphereLanes<S>,
    own: Mask64x16<S>,
    asked: Mask64x16<S>,
) -> Option<(Mask64x16<S>, F64x16<S>)> {
    let outwards = starts.position - spheres.center;
    let off = outwards.dot(outwards).sqrt() - spheres.radius;
    let is_on = (own | off.abs().le(starts.error)) & asked;
    let oc = -(rays.origin - spheres.center);
    let others = crossings(
        simd,
        oc,
        spheres.radius,
        rays,
        asked & !is_on,
        #[inline(always)]
        || oc.dot(oc).sqrt(),
    );
    let mut met = others.map(
        #[inline(always)]
        |Crossings {
             exist,
             first,
             second,
         }| {
            let t = first.gt(starts.t).select(first, second);
            (exist & t.gt(starts.t), t)
        },
    );
    if is_on.any() {
        let two = F64x16::splat(simd, 2.0);
        let t = starts.t - two * outwards.dot(rays.direction) / rays.square;
        let is_met = is_on & t.gt(starts.t);
        met = Some(match met {
            Some((others, at)) => (others | is_met, is_on.select(t, at)),
            None => (is_met, t),
        });
    }
    met
}

impl Sphere {
    /// L2: which of the rays in `asked` meet it after their starts, and where first.
    #[inline(always)]
    pub(in crate::visibility) fn first_met_after<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        starts: &RayStarts<S>,
        asked: Mask64x16<S>,
    ) -> Option<(Mask64x16<S>, F64x16<S>)> {
        let spheres = SphereLanes {
            center: DVec3x16::splat(simd, self.center.0),
            radius: F64x16::splat(simd, self.radius),
        };
        let own = starts.primitive.eq(self.primitive().lanes(simd));
        first_met_after(simd, rays, starts, &spheres, own, asked)
    }
}

impl SphereBlock {
    /// L2: which of the spheres with a bit a ray meets after its start, and where first. All of `rays` and `starts` are
    /// the one.
    #[inline(always)]
    pub(in crate::visibility) fn first_met_after<S: Simd>(
        &self,
        simd: S,
        rays: &Rays<S>,
        starts: &RayStarts<S>,
        own: Primitive,
        bits: u32,
    ) -> Option<(Mask64x16<S>, F64x16<S>)> {
        let own = Mask64x16::from_bits(simd, self.places_of(own));
        let asked = Mask64x16::from_bits(simd, bits);
        first_met_after(simd, rays, starts, &self.spheres(simd), own, asked)
    }
}
