//! L3 and L5 to L9: how much light each point sends to the viewer.

mod groups;
mod power;
mod reflectance;
mod spot;
mod terms;
#[cfg(test)]
mod tests;

use fearless_simd::Simd;

use groups::Groups;
pub(crate) use groups::Share;
use reflectance::{Ends, geometry};
pub(crate) use terms::{LightTerms, Terms};

use crate::math::Point;
use crate::simd::{F64x16, LANES, Mask64x16};
use crate::units::ReflectedIntensity;
use crate::visibility::{Column, Facing, PACKETS, Points, SegmentBatch, Visibility, Workspace};
use crate::world::{Light, Lobes, RecentProducts, World};

/// The light of a batch of points, and what it took.
#[derive(Clone, Debug)]
pub(crate) struct Shaded {
    /// L_o of each point in cd/m², per primary; the background's where nothing is hit.
    pub radiance: [Column; 3],
    /// How many points were asked for a light's visibility (L4).
    pub shadow_rays: u64,
    /// How many of these the light reaches.
    pub lit_points: u64,
    /// How often a light was at the very point it should light, d = 0, and added nothing.
    pub singular: u64,
    lit: Vec<Lit>,
    groups: Groups,
    /// Of the last packet whose terms were kept.
    terms: Vec<LightTerms>,
    recent: RecentProducts,
}

/// A light that is above some points of a batch.
#[derive(Clone, Debug)]
struct Lit {
    /// An index into [`World::lights`].
    light: usize,
    /// Which of its points the light comes from.
    origin: Point,
    /// For each packet one bit for each point that it reaches.
    points: [u32; PACKETS],
    /// V at each of these points, where something takes a part of the light; `None` is 1 at all of them, which
    /// multiplies nothing. A V that differs by wavelength is a weighted sum of several, each with products of
    /// its own.
    transmitted: Option<Box<Column>>,
}

impl Default for Shaded {
    fn default() -> Self {
        Self {
            radiance: [Column::ZERO; 3],
            shadow_rays: 0,
            lit_points: 0,
            singular: 0,
            lit: Vec::new(),
            groups: Groups::default(),
            terms: Vec::new(),
            recent: RecentProducts::default(),
        }
    }
}

/// L9: L_o(ω_o) = Σ_s L_i^s(p) r(ω_i^s, ω_o) V^s(p) over a batch of points.
#[inline(never)]
pub(crate) fn radiance<S: Simd>(
    simd: S,
    world: &World,
    visibility: &Visibility<'_>,
    points: &Points,
    space: &mut Workspace,
    shaded: &mut Shaded,
) {
    simd.vectorize(
        #[inline(always)]
        || {
            shaded.ask(simd, world, visibility, points, space);
            for packet in 0..PACKETS {
                shaded.sum(simd, world, points, packet, KeepsTerms::No);
            }
        },
    );
}

/// L4 alone: which lights reach the points of a batch, for [`packet_terms`] after it.
#[inline(never)]
pub(crate) fn ask_lights<S: Simd>(
    simd: S,
    world: &World,
    visibility: &Visibility<'_>,
    points: &Points,
    space: &mut Workspace,
    shaded: &mut Shaded,
) {
    simd.vectorize(
        #[inline(always)]
        || shaded.ask(simd, world, visibility, points, space),
    );
}

/// L9 over the points of a packet of the batch, and the terms of the sum that are not hidden (L4).
#[inline(never)]
pub(crate) fn packet_terms<'s, S: Simd>(
    simd: S,
    world: &World,
    points: &Points,
    packet: usize,
    shaded: &'s mut Shaded,
) -> Terms<'s> {
    simd.vectorize(
        #[inline(always)]
        || shaded.sum(simd, world, points, packet, KeepsTerms::Yes),
    );
    Terms {
        first: packet * LANES,
        hit: points.hit[packet],
        shares: shaded.groups.shares(),
        lights: &shaded.terms,
    }
}

/// Whether a sum keeps its terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum KeepsTerms {
    No,
    Yes,
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
        self.groups.clear();
        (self.shadow_rays, self.lit_points, self.singular) = (0, 0, 0);
        if points.none_hit() {
            return;
        }
        for (index, light) in world.lights().iter().enumerate() {
            let inside = match &light.value {
                Light::Point(_) => points.hit,
                light @ Light::Spot(spot) => {
                    if light.misses(points.bounds()) {
                        continue;
                    }
                    spot::inside(simd, spot, points)
                }
            };
            for origin in light.value.origins() {
                let Facing { mut above, at } = points.facing(simd, world, origin);
                for (above, inside) in above.iter_mut().zip(inside) {
                    *above &= inside;
                }
                let asked: u32 = above.iter().map(|bits| bits.count_ones()).sum();
                self.shadow_rays += u64::from(asked);
                self.singular += u64::from(at);
                if asked > 0 {
                    let segments = SegmentBatch::ToPoint {
                        end: origin,
                        points,
                        facing: &above,
                    };
                    let lit = visibility.free(simd, segments, space);
                    let reached: u32 = lit.iter().map(|bits| bits.count_ones()).sum();
                    self.lit_points += u64::from(reached);
                    self.lit.push(Lit {
                        light: index,
                        origin,
                        points: lit,
                        transmitted: None,
                    });
                }
            }
        }
    }

    /// Sums the terms of the lights that reach the points of a packet.
    #[inline(always)]
    fn sum<S: Simd>(
        &mut self,
        simd: S,
        world: &World,
        points: &Points,
        packet: usize,
        keeps: KeepsTerms,
    ) {
        let hit = points.hit[packet];
        let first = packet * LANES;
        if hit != 0 {
            let materials = &points.material[first..first + LANES];
            let is_uniform = points.is_uniform[packet];
            self.groups.take(world, materials, hit, is_uniform);
        }
        self.terms.clear();
        let sums = if hit == 0 {
            [F64x16::splat(simd, 0.0); 3]
        } else {
            self.sum_lights(simd, world, points, packet, keeps)
        };
        let is_hit = Mask64x16::from_bits(simd, hit);
        let background = world.background().0.0;
        for channel in 0..3 {
            let background = F64x16::splat(simd, background[channel]);
            let radiance = is_hit.select(sums[channel], background);
            radiance.store(&mut self.radiance[channel][first..]);
        }
    }

    /// Σ geometry × weight × I · k of the groups' shares.
    #[inline(always)]
    fn sum_lights<S: Simd>(
        &mut self,
        simd: S,
        world: &World,
        points: &Points,
        packet: usize,
        keeps: KeepsTerms,
    ) -> [F64x16<S>; 3] {
        let zero = F64x16::splat(simd, 0.0);
        let mut sums = [zero; 3];
        let ends = Ends::load(simd, points, packet);
        let Self {
            lit,
            groups,
            terms,
            recent,
            ..
        } = self;
        for Lit {
            light,
            origin,
            points: lit,
            transmitted,
        } in lit.iter()
        {
            let (light, bits) = (*light, lit[packet]);
            if bits == 0 {
                continue;
            }
            let source = &world.lights()[light].value;
            let mut geometry = geometry(simd, &ends, source, *origin, groups.get());
            if let Some(transmitted) = transmitted {
                let part = F64x16::load(simd, &transmitted[packet * LANES..]);
                geometry.diffuse = geometry.diffuse * part;
                geometry.specular = geometry.specular * part;
            }
            let mut reflected = world.reflected_from(light, Some(recent));
            let mut alone = [zero; 3];
            for share in groups.shares() {
                let reflected = reflected(share.reflectance as usize);
                let lit = Mask64x16::from_bits(simd, bits & share.members);
                add_share(simd, share, lit, &geometry, &reflected, &mut sums);
                if keeps == KeepsTerms::Yes {
                    add_share(simd, share, lit, &geometry, &reflected, &mut alone);
                }
            }
            if keeps == KeepsTerms::Yes {
                terms.push(LightTerms {
                    light,
                    points: bits,
                    geometry: Lobes {
                        diffuse: geometry.diffuse.to_array(),
                        specular: geometry.specular.to_array(),
                    },
                    radiance: [
                        alone[0].to_array(),
                        alone[1].to_array(),
                        alone[2].to_array(),
                    ],
                });
            }
        }
        sums
    }
}

/// Adds geometry × weight × I · k of a share to the sums of the points that are lit.
#[inline(always)]
fn add_share<S: Simd>(
    simd: S,
    share: &Share,
    is_lit: Mask64x16<S>,
    geometry: &Lobes<F64x16<S>>,
    reflected: &Lobes<ReflectedIntensity>,
    sums: &mut [F64x16<S>; 3],
) {
    let zero = F64x16::splat(simd, 0.0);
    let (kd, ks) = (reflected.diffuse.0.0, reflected.specular.0.0);
    let mut diffuse = is_lit.select(geometry.diffuse, zero);
    let mut specular = is_lit.select(geometry.specular, zero);
    match &share.weights {
        None => {
            sums[0] = sums[0] + (diffuse * kd[0] + specular * ks[0]);
            sums[1] = sums[1] + (diffuse * kd[1] + specular * ks[1]);
            sums[2] = sums[2] + (diffuse * kd[2] + specular * ks[2]);
        }
        Some(weights) => {
            let weights = F64x16::load(simd, weights);
            // What is of weight 0 is left out.
            let counts = is_lit & !weights.eq(zero);
            diffuse = diffuse * weights;
            specular = specular * weights;
            for channel in 0..3 {
                let more = diffuse * kd[channel] + specular * ks[channel];
                sums[channel] = counts.select(sums[channel] + more, sums[channel]);
            }
        }
    }
}
