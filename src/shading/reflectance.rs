//! L5 to L8 at the points of a packet for one light, without the light's color and the material's.

use fearless_simd::Simd;

use super::groups::{Gloss, Group, Shininess};
use super::power::{powers, whole_powers};
use super::spot::{falloff, inverse_roots};
use crate::math::Point;
use crate::simd::{DVec3x16, F64x16, LANES, Mask64x16};
use crate::visibility::{Points, columns};
use crate::world::{Light, Lobes};

/// What L5 to L8 need of the points of a packet.
#[derive(Clone, Copy)]
pub(super) struct Ends<S: Simd> {
    position: DVec3x16<S>,
    /// n
    normal: DVec3x16<S>,
    /// ω_o
    to_viewer: DVec3x16<S>,
    /// n · ω_o
    cos_viewer: F64x16<S>,
}

impl<S: Simd> Ends<S> {
    #[inline(always)]
    pub(super) fn load(simd: S, points: &Points, packet: usize) -> Self {
        Self {
            position: DVec3x16::load(simd, columns(&points.position, packet)),
            normal: DVec3x16::load(simd, columns(points.shading_normals(), packet)),
            to_viewer: DVec3x16::load(simd, columns(&points.to_viewer, packet)),
            cos_viewer: F64x16::load(simd, &points.cos_viewer[packet * LANES..]),
        }
    }
}

/// The cosine terms of L5 and L7 over d², in m⁻², of points that a light reaches from one of its origins; of a
/// spot times f(θ), of a sun over 1 m².
#[inline(always)]
pub(super) fn geometry<S: Simd>(
    simd: S,
    ends: &Ends<S>,
    light: &Light,
    origin: Point,
    groups: &[Group],
) -> Lobes<F64x16<S>> {
    let zero = F64x16::splat(simd, 0.0);
    let to_light = -ends.position.minus(origin.0);
    let [inverse, inverse_square] = inverse_roots(simd, to_light.dot(to_light));
    let received = match light {
        // What a luminaire sends into a direction is a factor of its own.
        Light::Point(_) | Light::Ies(_) => inverse_square,
        Light::Area(_) => unreachable!("a light with an area has integrals of its own"),
        Light::Spot(spot) => inverse_square * falloff(simd, spot, to_light, inverse),
        Light::Sun(_) => F64x16::splat(simd, 1.0),
    };
    let height = ends.normal.dot(to_light);
    let cos_incident = (height * inverse).max(zero);
    // L6: ω_o·ω_r = 2 (n·ω_i) (n·ω_o) − ω_i·ω_o, the second factor of which is the same for all lights.
    let along = height * ends.cos_viewer * 2.0 - to_light.dot(ends.to_viewer);
    let cos_reflected = along * inverse;
    let mut specular = zero;
    for &Group { members, gloss } in groups {
        let Gloss::Lobe {
            shininess,
            has_cosine,
        } = gloss
        else {
            continue;
        };
        // By the material alone, so that a point has the same bits beside any others.
        let lobe = match shininess {
            Shininess::Whole(exponent) => whole_powers(simd, cos_reflected, exponent),
            Shininess::Any(exponent) => powers(simd, cos_reflected, F64x16::splat(simd, exponent)),
        };
        let lobe = if has_cosine {
            lobe * cos_incident
        } else {
            lobe
        };
        specular = Mask64x16::from_bits(simd, members).select(lobe, specular);
    }
    // Closer than 1e-154 to a light the quotient is beyond f64, and would make a black channel NaN.
    let largest = F64x16::splat(simd, f64::MAX);
    Lobes {
        diffuse: (cos_incident * received).min(largest),
        specular: (specular * received).min(largest),
    }
}
