//! L3 and L5 to L9: how much light each point sends to the viewer.

mod power;
mod reflectance;

use fearless_simd::Simd;

pub use power::power;
use reflectance::{Surfaces, geometry};

use crate::lanes::{LANES, Lanes, ones};
use crate::units::ReflectedIntensity;
use crate::visibility::{Column, PACKETS, Points, Visibility, Workspace};
use crate::world::{Lobes, World};

/// The light of a batch of points, and what it took.
#[derive(Clone, Debug)]
pub struct Shaded {
    /// L_o of each point in cd/m², per primary; 0 where nothing is hit.
    pub radiance: [Column; 3],
    /// How many points were asked for a light's visibility (L4).
    pub shadow_rays: u64,
    /// How often a light was at the very point it should light, d = 0, and added nothing.
    pub singular: u64,
}

impl Default for Shaded {
    fn default() -> Self {
        Self {
            radiance: [Column::ZERO; 3],
            shadow_rays: 0,
            singular: 0,
        }
    }
}

/// One term of L9 without its color: what a light that is seen does at a point, by geometry alone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// The point, by its place in the batch.
    pub point: usize,
    /// An index into [`World::lights`].
    pub light: usize,
    /// An index into [`World::materials`].
    pub material: usize,
    /// The cosine term of each lobe over d², in m⁻², at most [`f64::MAX`]: times I · k it is the
    /// radiance that the lobe sends to the viewer.
    pub geometry: Lobes<f64>,
}

/// L9: L_o(ω_o) = Σ_s L_i^s(p) r(ω_i^s, ω_o) V^s(p), light by light over a batch of points.
///
/// `each`, if there is one, is told of every term of the sum that is not hidden (L4): light by light,
/// point by point within.
#[inline(never)]
pub(crate) fn radiance<S: Simd>(
    simd: S,
    world: &World,
    visibility: &Visibility<'_>,
    points: &Points,
    space: &mut Workspace,
    shaded: &mut Shaded,
    each: Option<&mut dyn FnMut(Term)>,
) {
    simd.vectorize(
        #[inline(always)]
        || sum(simd, world, visibility, points, space, shaded, each),
    );
}

#[inline(always)]
fn sum<S: Simd>(
    simd: S,
    world: &World,
    visibility: &Visibility<'_>,
    points: &Points,
    space: &mut Workspace,
    shaded: &mut Shaded,
    mut each: Option<&mut dyn FnMut(Term)>,
) {
    for column in &mut shaded.radiance {
        column.fill(0.0);
    }
    (shaded.shadow_rays, shaded.singular) = (0, 0);
    for (index, light) in world.lights().iter().enumerate() {
        let position = light.value.position;
        let mut above = [0; PACKETS];
        for (packet, above) in above.iter_mut().enumerate() {
            let facing = points.facing(simd, packet, position);
            *above = facing.above;
            shaded.shadow_rays += u64::from(facing.above.count_ones());
            shaded.singular += u64::from(facing.at.count_ones());
        }
        let lit = visibility.lit(simd, position, points, &above, space);
        let transport = world.transport(index);
        for (packet, bits) in lit.into_iter().enumerate() {
            if bits == 0 {
                continue;
            }
            let first = packet * LANES;
            let materials = &points.material[first..first + LANES];
            let (surfaces, reflected) = if points.is_uniform[packet] {
                let material = materials[points.hit[packet].trailing_zeros() as usize] as usize;
                (
                    Surfaces::uniform(simd, &world.materials()[material].value),
                    splat(simd, &transport[material]),
                )
            } else {
                let material = |lane: usize| &world.materials()[materials[lane] as usize].value;
                (
                    Surfaces::mixed(simd, bits, material),
                    gather(simd, bits, |lane| &transport[materials[lane] as usize]),
                )
            };
            let geometry = geometry(simd, points, packet, position, &surfaces);
            let is_lit = crate::lanes::Mask::from_bits(simd, bits);
            for (channel, column) in shaded.radiance.iter_mut().enumerate() {
                let before = Lanes::load(simd, &column[first..]);
                let more = reflected.diffuse[channel] * geometry.diffuse
                    + reflected.specular[channel] * geometry.specular;
                is_lit
                    .select(before + more, before)
                    .store(&mut column[first..]);
            }
            if let Some(each) = &mut each {
                let diffuse = geometry.diffuse.to_array();
                let specular = geometry.specular.to_array();
                for lane in ones(bits) {
                    each(Term {
                        point: first + lane,
                        light: index,
                        material: materials[lane] as usize,
                        geometry: Lobes {
                            diffuse: diffuse[lane],
                            specular: specular[lane],
                        },
                    });
                }
            }
        }
    }
}

/// I · k of one material in all lanes, channel by channel.
#[inline(always)]
fn splat<S: Simd>(simd: S, lobes: &Lobes<ReflectedIntensity>) -> Lobes<[Lanes<S>; 3]> {
    let ([r, g, b], [sr, sg, sb]) = (lobes.diffuse.0.0, lobes.specular.0.0);
    let splat = |value: f64| Lanes::splat(simd, value);
    Lobes {
        diffuse: [splat(r), splat(g), splat(b)],
        specular: [splat(sr), splat(sg), splat(sb)],
    }
}

/// I · k of each lane's own material, for the lanes with a bit.
#[inline(always)]
fn gather<'t, S: Simd>(
    simd: S,
    bits: u32,
    lobes: impl Fn(usize) -> &'t Lobes<ReflectedIntensity>,
) -> Lobes<[Lanes<S>; 3]> {
    let mut diffuse = [[0.0; LANES]; 3];
    let mut specular = [[0.0; LANES]; 3];
    for lane in ones(bits) {
        let lobes = lobes(lane);
        for channel in 0..3 {
            diffuse[channel][lane] = lobes.diffuse.0.0[channel];
            specular[channel][lane] = lobes.specular.0.0[channel];
        }
    }
    let lanes = |[r, g, b]: [[f64; LANES]; 3]| {
        [
            Lanes::load(simd, &r),
            Lanes::load(simd, &g),
            Lanes::load(simd, &b),
        ]
    };
    Lobes {
        diffuse: lanes(diffuse),
        specular: lanes(specular),
    }
}
