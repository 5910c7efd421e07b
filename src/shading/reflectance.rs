//! L5 to L8 at the points of a packet for one light, without the light's color and the material's.

use fearless_simd::Simd;

use super::power::powers;
use crate::lanes::{LANES, Lanes, Mask, Vectors};
use crate::math::{Point, SAFE_SQUARES};
use crate::visibility::{Points, columns};
use crate::world::material::Model;
use crate::world::{Lobes, Material};

/// What the lobes of the points' materials look like.
#[derive(Clone, Copy)]
pub(super) struct Surfaces<S: Simd> {
    /// n of L7.
    shininess: Lanes<S>,
    /// Where there is a specular lobe.
    is_specular: Mask<S>,
    /// Where L7 has the cosine of the incident light as a factor.
    is_normalized: Mask<S>,
    any_specular: bool,
}

impl<S: Simd> Surfaces<S> {
    /// All of one material.
    #[inline(always)]
    pub(super) fn uniform(simd: S, material: &Material) -> Self {
        let mask = |is: bool| Mask::from_bits(simd, if is { u32::MAX } else { 0 });
        Self {
            shininess: Lanes::splat(simd, material.shininess()),
            is_specular: mask(material.is_specular()),
            is_normalized: mask(is_normalized(material)),
            any_specular: material.is_specular(),
        }
    }

    /// Each of its own, for the lanes with a bit.
    #[inline(always)]
    pub(super) fn mixed<'m>(simd: S, bits: u32, material: impl Fn(usize) -> &'m Material) -> Self {
        let mut shininess = [1.0; LANES];
        let (mut specular, mut normalized) = (0, 0);
        for (lane, shininess) in shininess.iter_mut().enumerate() {
            if bits >> lane & 1 == 1 {
                let material = material(lane);
                *shininess = material.shininess();
                specular |= u32::from(material.is_specular()) << lane;
                normalized |= u32::from(is_normalized(material)) << lane;
            }
        }
        Self {
            shininess: Lanes::load(simd, &shininess),
            is_specular: Mask::from_bits(simd, specular),
            is_normalized: Mask::from_bits(simd, normalized),
            any_specular: specular != 0,
        }
    }
}

fn is_normalized(material: &Material) -> bool {
    match material.model() {
        Model::Phong => false,
        Model::NormalizedPhong => true,
    }
}

/// The cosine terms of L5 and L7 over d², in m⁻², of points that a light reaches.
#[inline(always)]
pub(super) fn geometry<S: Simd>(
    simd: S,
    points: &Points,
    packet: usize,
    light: Point,
    surfaces: &Surfaces<S>,
) -> Lobes<Lanes<S>> {
    let zero = Lanes::splat(simd, 0.0);
    let to_light = -Vectors::load(simd, columns(&points.position, packet)).minus(light.0);
    let square = to_light.dot(to_light);
    let is_safe = square.is_within(simd, SAFE_SQUARES);
    let mut inverse = square.inverse_root(simd);
    let mut inverse_square = inverse * inverse;
    if (!is_safe).any() {
        let one = Lanes::splat(simd, 1.0);
        inverse = is_safe.select(inverse, one / square.sqrt());
        inverse_square = is_safe.select(inverse_square, one / square);
    }
    let normal = Vectors::load(simd, columns(&points.shading_normal, packet));
    let height = normal.dot(to_light);
    let cos_incident = (height * inverse).max(zero);
    let specular = if surfaces.any_specular {
        // L6: ω_o·ω_r = 2 (n·ω_i) (n·ω_o) − ω_i·ω_o, the second factor of which is the same for all
        // lights.
        let to_viewer = Vectors::load(simd, columns(&points.to_viewer, packet));
        let cos_viewer = Lanes::load(simd, &points.cos_viewer[packet * LANES..]);
        let cos_reflected = (height * cos_viewer * 2.0 - to_light.dot(to_viewer)) * inverse;
        let lobe = powers(simd, cos_reflected, surfaces.shininess);
        let lobe = surfaces.is_normalized.select(lobe * cos_incident, lobe);
        surfaces.is_specular.select(lobe, zero)
    } else {
        zero
    };
    // Closer than 1e-154 to a light the quotient is beyond f64, and would make a black channel NaN.
    let largest = Lanes::splat(simd, f64::MAX);
    Lobes {
        diffuse: (cos_incident * inverse_square).min(largest),
        specular: (specular * inverse_square).min(largest),
    }
}
