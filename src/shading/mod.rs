//! L3 and L5 to L9: how much light each point sends to the viewer.

mod power;
mod reflectance;

use fearless_simd::Simd;

pub use power::power;
use reflectance::{Ends, Gloss, geometry};

use crate::math::Point;
use crate::simd::{F64x16, LANES, Mask64x16, ones};
use crate::visibility::{Column, Facing, PACKETS, Points, Visibility, Workspace};
use crate::world::{Lobes, World};

/// The light of a batch of points, and what it took.
#[derive(Clone, Debug)]
pub struct Shaded {
    /// L_o of each point in cd/m², per primary; the background's where nothing is hit.
    pub radiance: [Column; 3],
    /// How many points were asked for a light's visibility (L4).
    pub shadow_rays: u64,
    /// How many of these the light reaches.
    pub lit_points: u64,
    /// How often a light was at the very point it should light, d = 0, and added nothing.
    pub singular: u64,
    lit: Vec<Lit>,
}

/// A light that is above some points of a batch.
#[derive(Clone, Debug)]
struct Lit {
    /// An index into [`World::lights`].
    light: usize,
    position: Point,
    /// For each packet one bit for each point that it reaches.
    points: [u32; PACKETS],
}

impl Default for Shaded {
    fn default() -> Self {
        Self {
            radiance: [Column::ZERO; 3],
            shadow_rays: 0,
            lit_points: 0,
            singular: 0,
            lit: Vec::new(),
        }
    }
}

/// Terms of L9 without their color, of one light at the points of a packet.
#[derive(Clone, Copy, Debug)]
pub struct Terms<'t> {
    /// The first point of the packet, by its place in the batch.
    first: usize,
    /// One bit for each point that the light reaches.
    bits: u32,
    light: usize,
    materials: &'t [u32],
    geometry: &'t Lobes<[f64; LANES]>,
}

impl Terms<'_> {
    /// One after the other.
    pub fn iter(&self) -> impl Iterator<Item = Term> {
        ones(self.bits).map(|lane| Term {
            point: self.first + lane,
            light: self.light,
            material: self.materials[lane] as usize,
            geometry: Lobes {
                diffuse: self.geometry.diffuse[lane],
                specular: self.geometry.specular[lane],
            },
        })
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

/// L9: L_o(ω_o) = Σ_s L_i^s(p) r(ω_i^s, ω_o) V^s(p) over a batch of points.
///
/// `each`, if there is one, is told of all terms of the sum that are not hidden (L4): packet by packet,
/// light by light within.
#[inline(never)]
pub(crate) fn radiance<S: Simd>(
    simd: S,
    world: &World,
    visibility: &Visibility<'_>,
    points: &Points,
    space: &mut Workspace,
    shaded: &mut Shaded,
    each: Option<&mut dyn FnMut(Terms<'_>)>,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            shaded.ask(simd, world, visibility, points, space);
            shaded.sum(simd, world, points, each);
        },
    );
}

impl Shaded {
    /// L4: finds out which lights reach which points.
    #[inline(always)]
    fn ask<S: Simd>(
        &mut self,
        simd: S,
        world: &World,
        visibility: &Visibility<'_>,
        points: &Points,
        space: &mut Workspace,
    ) {
        self.lit.clear();
        (self.shadow_rays, self.lit_points, self.singular) = (0, 0, 0);
        if points.none_hit() {
            return;
        }
        for (index, light) in world.lights().iter().enumerate() {
            let position = light.value.position;
            let Facing { above, at } = points.facing(simd, world, position);
            let asked: u32 = above.iter().map(|bits| bits.count_ones()).sum();
            self.shadow_rays += u64::from(asked);
            self.singular += u64::from(at);
            if asked > 0 {
                let lit = visibility.lit(simd, position, points, &above, space);
                let reached: u32 = lit.iter().map(|bits| bits.count_ones()).sum();
                self.lit_points += u64::from(reached);
                self.lit.push(Lit {
                    light: index,
                    position,
                    points: lit,
                });
            }
        }
    }

    /// Sums the terms of the lights that reach points, packet by packet.
    #[inline(always)]
    fn sum<S: Simd>(
        &mut self,
        simd: S,
        world: &World,
        points: &Points,
        mut each: Option<&mut dyn FnMut(Terms<'_>)>,
    ) {
        let zero = F64x16::splat(simd, 0.0);
        let background = world.background().0.0;
        for (packet, &hit) in points.hit.iter().enumerate() {
            let first = packet * LANES;
            let materials = &points.material[first..first + LANES];
            let mut sums = [zero; 3];
            if hit != 0 {
                let mut groups = Groups::default();
                groups.take(world, materials, hit, points.is_uniform[packet]);
                let ends = Ends::load(simd, points, packet);
                for &Lit {
                    light,
                    position,
                    points: ref lit,
                } in &self.lit
                {
                    let bits = lit[packet];
                    if bits == 0 {
                        continue;
                    }
                    let geometry = geometry(simd, &ends, position, groups.get());
                    let reflected = world.reflected_from(light);
                    for &Group {
                        material, members, ..
                    } in groups.get()
                    {
                        let is_lit = Mask64x16::from_bits(simd, bits & members);
                        let diffuse = is_lit.select(geometry.diffuse, zero);
                        let specular = is_lit.select(geometry.specular, zero);
                        let reflected = reflected(material as usize);
                        let (kd, ks) = (reflected.diffuse.0.0, reflected.specular.0.0);
                        sums[0] = sums[0] + (diffuse * kd[0] + specular * ks[0]);
                        sums[1] = sums[1] + (diffuse * kd[1] + specular * ks[1]);
                        sums[2] = sums[2] + (diffuse * kd[2] + specular * ks[2]);
                    }
                    if let Some(each) = &mut each {
                        each(Terms {
                            first,
                            bits,
                            light,
                            materials,
                            geometry: &Lobes {
                                diffuse: geometry.diffuse.to_array(),
                                specular: geometry.specular.to_array(),
                            },
                        });
                    }
                }
            }
            let is_hit = Mask64x16::from_bits(simd, hit);
            for channel in 0..3 {
                let background = F64x16::splat(simd, background[channel]);
                let radiance = is_hit.select(sums[channel], background);
                radiance.store(&mut self.radiance[channel][first..]);
            }
        }
    }
}

/// The points of a packet with one material.
#[derive(Clone, Copy, Debug, Default)]
struct Group {
    material: u32,
    /// One bit for each.
    members: u32,
    gloss: Gloss,
}

impl Group {
    fn new(world: &World, material: u32, members: u32) -> Self {
        Self {
            material,
            members,
            gloss: Gloss::of(&world.materials()[material as usize].value),
        }
    }
}

/// The points of a packet, material by material.
#[derive(Clone, Copy, Debug, Default)]
struct Groups {
    groups: [Group; LANES],
    count: usize,
}

impl Groups {
    /// Takes the points with a bit.
    #[inline(always)]
    fn take(&mut self, world: &World, materials: &[u32], bits: u32, are_uniform: bool) {
        if are_uniform {
            let material = materials[bits.trailing_zeros() as usize];
            self.groups[0] = Group::new(world, material, bits);
            self.count = 1;
            return;
        }
        for lane in ones(bits) {
            let material = materials[lane];
            let known = &mut self.groups[..self.count];
            match known.iter_mut().find(|group| group.material == material) {
                Some(group) => group.members |= 1 << lane,
                None => {
                    self.groups[self.count] = Group::new(world, material, 1 << lane);
                    self.count += 1;
                }
            }
        }
    }

    #[inline(always)]
    fn get(&self) -> &[Group] {
        &self.groups[..self.count]
    }
}
