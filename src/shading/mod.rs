//! L3 and L5 to L9: how much light each point sends to the viewer.

mod area;
mod area_points;
mod delta;
mod emission;
mod filters;
mod groups;
mod meter;
mod panes;
mod plane_mirror;
mod power;
mod reflectance;
mod spot;
mod terms;
#[cfg(test)]
mod tests;

use fearless_simd::Simd;

pub(crate) use area::AreaSpace;
use area::{AreaTerms, Asked};
pub(crate) use delta::{Arriving, Branch, Filter, Leaving, absorbed, leave, most_in};
use emission::{add_emission, filter_background};
pub(crate) use emission::{emission, emitter_seen};
pub(crate) use filters::Filters;
use groups::Groups;
pub(crate) use groups::Share;
pub(crate) use meter::area_illuminance;
pub(crate) use panes::{Crossing, Opaque, PaneSpace};
pub(crate) use plane_mirror::PlaneMirror;
use reflectance::{Ends, geometry};
pub(crate) use terms::{Detail, LightTerms};

use crate::math::{DVec3, Point};
use crate::simd::{F64x16, LANES, Mask64x16, ones};
use crate::units::ReflectedIntensity;
use crate::visibility::{
    Column, Facing, PACKETS, Points, SegmentBatch, Visibility, Workspace, columns,
};
use crate::world::light::{AreaLight, IesLight};
use crate::world::{Delta, Light, Lobes, RecentProducts, World};

/// The light of a batch of points, and what it took.
#[derive(Debug)]
pub(crate) struct Shaded {
    /// L_o of each point in cd/m², per primary; the background's where nothing is hit.
    pub radiance: [Column; 3],
    /// How many points were asked for a light's visibility (L4).
    pub shadow_rays: u64,
    /// How many of these the light reaches.
    pub lit_points: u64,
    /// Whether what is seen of lights with an area is computed past many shapes too, not sampled.
    pub cuts_areas: bool,
    /// What the light of each point is seen through.
    pub filters: Filters,
    /// How often a light was at the very point it should light, d = 0, and added nothing.
    pub singular: u64,
    /// For each packet one bit for each point with lobes.
    lobed: [u32; PACKETS],
    lit: Vec<Lit>,
    groups: Groups,
    /// What each packet is made of, where light is told light by light.
    packets: Vec<Groups>,
    recent: RecentProducts,
    area: Box<AreaSpace>,
    panes: PaneSpace,
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
    /// A factor of the light at each of these points: of a luminaire how much it sends there. `None` is 1 at all of
    /// them, which multiplies nothing.
    factors: Option<Box<Column>>,
    /// Of light that comes through panes, how much of it passes. `None` is all at all of them.
    passed: Option<Box<Column>>,
    /// What a light with an area does at each of these points.
    area: Option<Box<AreaTerms>>,
}

impl Default for Shaded {
    fn default() -> Self {
        Self {
            radiance: [Column::ZERO; 3],
            shadow_rays: 0,
            lit_points: 0,
            cuts_areas: false,
            filters: Filters::default(),
            singular: 0,
            lobed: [0; PACKETS],
            lit: Vec::new(),
            groups: Groups::default(),
            packets: Vec::new(),
            recent: RecentProducts::default(),
            area: Box::default(),
            panes: PaneSpace::default(),
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
                shaded.sum(simd, world, points, packet);
            }
        },
    );
}

/// Begins a batch whose light is told light by light: finds out which lights reach which points (L4), and what the
/// points are made of. [`light_terms`] of each of [`Shaded::lit`], in order, then comes to what [`radiance`] does.
#[inline(never)]
pub(crate) fn begin_terms<S: Simd>(
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
            shaded.begin(simd, world, points);
        },
    );
}

/// Adds one of the lights that are above any point to the radiance of a batch (L9), and tells its terms.
#[inline(never)]
pub(crate) fn light_terms<S: Simd>(
    simd: S,
    world: &World,
    points: &Points,
    lit: usize,
    detail: Detail,
    shaded: &mut Shaded,
    terms: &mut LightTerms,
) {
    simd.vectorize(
        #[inline(always)]
        || shaded.add_light(simd, world, points, lit, detail, terms),
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
        self.groups.clear();
        (self.shadow_rays, self.lit_points, self.singular) = (0, 0, 0);
        if points.none_hit() {
            return;
        }
        self.lobed = lobed(world, points);
        if self.lobed == [0; PACKETS] {
            return;
        }
        let mut next_number = 0;
        for (index, light) in world.lights().iter().enumerate() {
            let numbers = next_number..;
            next_number += light.value.origins().len();
            if let Light::Area(area) = &light.value {
                self.ask_area(
                    simd,
                    world,
                    visibility,
                    points,
                    (index, area, numbers.start),
                    space,
                );
                continue;
            }
            let mut factors = None;
            let inside = match &light.value {
                Light::Point(_) | Light::Sun(_) | Light::Area(_) => points.hit,
                Light::Ies(luminaire) => {
                    let factors = factors.insert(Box::new(Column::ZERO));
                    luminaire_factors(luminaire, points, factors)
                }
                light @ Light::Spot(spot) => {
                    if light.misses(points.bounds()) {
                        continue;
                    }
                    spot::inside(simd, spot, points)
                }
            };
            for (number, origin) in numbers.zip(light.value.origins()) {
                let Facing { mut above, at } = points.facing(simd, world, origin);
                for ((above, inside), lobed) in above.iter_mut().zip(inside).zip(self.lobed) {
                    *above &= inside & lobed;
                }
                let asked: u32 = above.iter().map(|bits| bits.count_ones()).sum();
                self.shadow_rays += u64::from(asked);
                self.singular += u64::from(at);
                if asked > 0 {
                    let segments = SegmentBatch::ToPoint {
                        end: origin,
                        to_light: light.value.direction(),
                        number,
                        points,
                        facing: &above,
                    };
                    let mut lit = visibility.free(simd, segments, space);
                    let mut passed = None;
                    if world.has_panes() && lit != above {
                        let to_light = light.value.direction();
                        passed = self.panes.through(
                            simd,
                            (world, visibility, points),
                            (origin, to_light),
                            &above,
                            &mut lit,
                            space,
                        );
                    }
                    let reached: u32 = lit.iter().map(|bits| bits.count_ones()).sum();
                    self.lit_points += u64::from(reached);
                    self.lit.push(Lit {
                        light: index,
                        origin,
                        points: lit,
                        factors: factors.clone(),
                        passed,
                        area: None,
                    });
                }
            }
        }
    }

    /// The same for a light with an area, of which each point sees a part.
    #[inline(always)]
    fn ask_area<S: Simd>(
        &mut self,
        simd: S,
        world: &World,
        visibility: &Visibility<'_>,
        points: &Points,
        (index, light, number): (usize, &AreaLight, usize),
        space: &mut Workspace,
    ) {
        let asked = Asked {
            world,
            visibility,
            points,
            index,
            light,
            number,
            // Of points of a light it is not asked past panes.
            cuts_all: self.cuts_areas || world.has_panes(),
            accuracy: if self.cuts_areas {
                &area::ACCURACY_FOR_ERROR
            } else {
                &area::ACCURACY
            },
            lobed: &self.lobed,
        };
        let Some(lit) = asked.terms(simd, &mut self.area, space) else {
            return;
        };
        let reached: u32 = lit.points.iter().map(|bits| bits.count_ones()).sum();
        self.shadow_rays += lit.asked;
        self.lit_points += u64::from(reached);
        self.lit.push(Lit {
            light: index,
            origin: light.emitter.center(),
            points: lit.points,
            factors: None,
            passed: None,
            area: Some(lit.terms),
        });
    }

    /// Sums the light that reaches the points of a packet.
    #[inline(always)]
    fn sum<S: Simd>(&mut self, simd: S, world: &World, points: &Points, packet: usize) {
        let hit = points.hit[packet];
        let first = packet * LANES;
        if hit != 0 {
            let materials = &points.material[first..first + LANES];
            let is_uniform = points.is_uniform[packet];
            let filters = self.filters.numbers(first);
            self.groups.take(world, materials, filters, hit, is_uniform);
            if world.has_coats() {
                self.groups.coat(world, &points.cos_viewer[first..]);
            }
        }
        let sums = if hit == 0 {
            [F64x16::splat(simd, 0.0); 3]
        } else {
            self.sum_lights(simd, world, points, packet)
        };
        let is_hit = Mask64x16::from_bits(simd, hit);
        let background = world.background().0.0;
        for channel in 0..3 {
            let background = F64x16::splat(simd, background[channel]);
            let radiance = is_hit.select(sums[channel], background);
            radiance.store(&mut self.radiance[channel][first..]);
        }
        if self.filters.numbers(first).is_some() {
            filter_background(world, &self.filters, hit, first, &mut self.radiance);
        }
        if world.has_emission() {
            add_emission(world, points, packet, &self.filters, &mut self.radiance);
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
    ) -> [F64x16<S>; 3] {
        let mut sums = [F64x16::splat(simd, 0.0); 3];
        let ends = Ends::load(simd, points, packet);
        let Self {
            lit,
            groups,
            recent,
            filters,
            ..
        } = self;
        for lit in lit.iter() {
            let bits = lit.points[packet];
            if bits == 0 {
                continue;
            }
            let geometry = lit.geometry(simd, world, &ends, groups, packet);
            let mut reflected = world.reflected_from(lit.light, Some(recent));
            for share in groups.shares() {
                let material = share.reflectance as usize;
                let filtered = filters.reflected(world, share.filter, lit.light, material);
                let reflected = match filtered {
                    None => reflected(material),
                    Some(filtered) => filtered,
                };
                let is_lit = Mask64x16::from_bits(simd, bits & share.members);
                add_share(simd, share, is_lit, &geometry, &reflected, &mut sums);
            }
        }
        sums
    }

    /// The background's radiance where nothing is hit, elsewhere 0; and what each packet is made of.
    #[inline(always)]
    fn begin<S: Simd>(&mut self, simd: S, world: &World, points: &Points) {
        self.packets.resize_with(PACKETS, Groups::default);
        let zero = F64x16::splat(simd, 0.0);
        let background = world.background().0.0;
        for (packet, groups) in self.packets.iter_mut().enumerate() {
            let hit = points.hit[packet];
            let first = packet * LANES;
            if hit == 0 {
                groups.clear();
            } else {
                let materials = &points.material[first..first + LANES];
                let filters = self.filters.numbers(first);
                groups.take(world, materials, filters, hit, points.is_uniform[packet]);
                if world.has_coats() {
                    groups.coat(world, &points.cos_viewer[first..]);
                }
            }
            let is_hit = Mask64x16::from_bits(simd, hit);
            for channel in 0..3 {
                let background = F64x16::splat(simd, background[channel]);
                let radiance = is_hit.select(zero, background);
                radiance.store(&mut self.radiance[channel][first..]);
            }
            if self.filters.numbers(first).is_some() {
                filter_background(world, &self.filters, hit, first, &mut self.radiance);
            }
            if world.has_emission() {
                add_emission(world, points, packet, &self.filters, &mut self.radiance);
            }
        }
    }

    /// Adds a light to the radiance, and tells its terms.
    #[inline(always)]
    fn add_light<S: Simd>(
        &mut self,
        simd: S,
        world: &World,
        points: &Points,
        lit: usize,
        detail: Detail,
        terms: &mut LightTerms,
    ) {
        let Self {
            lit: all,
            packets,
            recent,
            radiance,
            filters,
            ..
        } = self;
        let lit = &all[lit];
        terms.light = lit.light;
        terms.points = lit.points;
        let seen = lit.area.as_ref().map(|area| Box::new(area.seen));
        terms.seen = seen.or_else(|| lit.passed.clone());
        let zero = F64x16::splat(simd, 0.0);
        for (packet, groups) in packets.iter().enumerate() {
            let bits = lit.points[packet];
            let first = packet * LANES;
            let mut alone = [zero; 3];
            let mut lobes = Lobes {
                diffuse: [zero; 3],
                specular: [zero; 3],
            };
            let mut geometry = Lobes {
                diffuse: zero,
                specular: zero,
            };
            if bits != 0 {
                let ends = Ends::load(simd, points, packet);
                geometry = lit.geometry(simd, world, &ends, groups, packet);
                let mut reflected = world.reflected_from(lit.light, Some(recent));
                let [r, g, b] = columns(radiance, packet);
                let mut sums = [
                    F64x16::load(simd, r),
                    F64x16::load(simd, g),
                    F64x16::load(simd, b),
                ];
                for share in groups.shares() {
                    let material = share.reflectance as usize;
                    let filtered = filters.reflected(world, share.filter, lit.light, material);
                    let reflected = match filtered {
                        None => reflected(material),
                        Some(filtered) => filtered,
                    };
                    let is_lit = Mask64x16::from_bits(simd, bits & share.members);
                    add_share(simd, share, is_lit, &geometry, &reflected, &mut sums);
                    if detail.has_radiance {
                        add_share(simd, share, is_lit, &geometry, &reflected, &mut alone);
                    }
                    if detail.has_lobes {
                        let [diffuse, specular] = apart(&reflected);
                        add_share(simd, share, is_lit, &geometry, &diffuse, &mut lobes.diffuse);
                        add_share(
                            simd,
                            share,
                            is_lit,
                            &geometry,
                            &specular,
                            &mut lobes.specular,
                        );
                    }
                }
                store(sums, radiance, first);
                let is_lit = Mask64x16::from_bits(simd, bits);
                geometry.diffuse = is_lit.select(geometry.diffuse, zero);
                geometry.specular = is_lit.select(geometry.specular, zero);
            }
            if detail.has_radiance {
                store(alone, &mut terms.radiance, first);
            }
            if detail.has_lobes {
                store(lobes.diffuse, &mut terms.lobes.diffuse, first);
                store(lobes.specular, &mut terms.lobes.specular, first);
            }
            if detail.has_geometry {
                geometry.diffuse.store(&mut terms.geometry.diffuse[first..]);
                geometry
                    .specular
                    .store(&mut terms.geometry.specular[first..]);
            }
        }
    }

    /// How many lights are above any point of the batch, each from one of its origins.
    pub(crate) fn lit(&self) -> usize {
        self.lit.len()
    }

    /// What the points of a packet reflect with, after [`begin_terms`].
    pub(crate) fn shares(&self, packet: usize) -> &[Share] {
        self.packets[packet].shares()
    }
}

impl Lit {
    /// The cosine terms of both lobes over d² at the points of a packet, times the light's factor there.
    #[inline(always)]
    fn geometry<S: Simd>(
        &self,
        simd: S,
        world: &World,
        ends: &Ends<S>,
        groups: &Groups,
        packet: usize,
    ) -> Lobes<F64x16<S>> {
        if let Some(area) = &self.area {
            let first = packet * LANES;
            return Lobes {
                diffuse: F64x16::load(simd, &area.geometry.diffuse[first..]),
                specular: F64x16::load(simd, &area.geometry.specular[first..]),
            };
        }
        let light = &world.lights()[self.light].value;
        let mut geometry = geometry(simd, ends, light, self.origin, groups.get());
        for factors in self.factors.iter().chain(&self.passed) {
            let part = F64x16::load(simd, &factors[packet * LANES..]);
            geometry.diffuse = geometry.diffuse * part;
            geometry.specular = geometry.specular * part;
        }
        geometry
    }
}

/// One bit for each point with lobes, which lights light: mirrors and glass have none.
#[inline(always)]
fn lobed(world: &World, points: &Points) -> [u32; PACKETS] {
    let mut bits = points.hit;
    if world.has_deltas() {
        for (packet, bits) in bits.iter_mut().enumerate() {
            for lane in ones(*bits) {
                let material = points.material[packet * LANES + lane] as usize;
                let has_lobes = world.delta(material).is_none_or(Delta::has_lobes);
                *bits &= !(u32::from(!has_lobes) << lane);
            }
        }
    }
    bits
}

/// f of a luminaire at each point of a batch; for each packet one bit for each point where that is above 0.
#[inline(never)]
fn luminaire_factors(
    luminaire: &IesLight,
    points: &Points,
    factors: &mut Column,
) -> [u32; PACKETS] {
    let mut inside = [0; PACKETS];
    for (packet, &hit) in points.hit.iter().enumerate() {
        for lane in ones(hit) {
            let point = packet * LANES + lane;
            let [x, y, z] = &points.position;
            let position = DVec3::new(x[point], y[point], z[point]);
            let factor = luminaire.factor(position - luminaire.position.0);
            factors[point] = factor;
            inside[packet] |= u32::from(factor > 0.0) << lane;
        }
    }
    inside
}

/// Puts R, G and B of a packet into their columns.
#[inline(always)]
fn store<S: Simd>([r, g, b]: [F64x16<S>; 3], columns: &mut [Column; 3], first: usize) {
    r.store(&mut columns[0][first..]);
    g.store(&mut columns[1][first..]);
    b.store(&mut columns[2][first..]);
}

/// What is reflected by each lobe alone.
#[inline(always)]
fn apart(reflected: &Lobes<ReflectedIntensity>) -> [Lobes<ReflectedIntensity>; 2] {
    let none = ReflectedIntensity::default();
    [
        Lobes {
            diffuse: reflected.diffuse,
            specular: none,
        },
        Lobes {
            diffuse: none,
            specular: reflected.specular,
        },
    ]
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
