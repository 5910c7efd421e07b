//! The rays that leave the points of a batch by one branch.

use fearless_simd::Simd;

use super::counts::Counts;
use super::path_step::{Above, KnownFilters, Step, hits};
use super::setup::Setup;
use crate::shading::{self, Arriving, Branch, Filter, Leaving, PlaneMirror};
use crate::simd::{F64x16, LANES, ones};
use crate::spectrum::Spectrum;
use crate::visibility::{BATCH, Column, columns};
use crate::world::Delta;

/// A branch of which less than this arrives is not followed: of light that is 10⁶ times as bright as what is beside it,
/// the last digit of 32 bits would be more.
const NEGLIGIBLE: f64 = 1e-14;

/// A ray that leaves a point by one wavelength's way.
pub(super) struct Way {
    pub(super) slot: usize,
    pub(super) nm: u16,
    /// What of each wavelength takes it; `None` is all.
    pub(super) share: Option<Spectrum>,
    /// The place that it is noted at.
    pub(super) sample: u16,
}

/// Where rays that leave a batch of points are put.
pub(super) struct LeavingRays<'a, 'w> {
    pub(super) setup: &'a Setup<'w>,
    pub(super) above: Above<'a>,
    /// How often they have been reflected or refracted before.
    pub(super) depth: u32,
    pub(super) step: &'a mut Step,
    /// How much of the brightest radiance rays may bring to a sample that are left out together.
    pub(super) negligible: f64,
    /// How much of it those that are left out would have brought at most, of each sample.
    pub(super) cut: &'a mut Column,
    pub(super) counts: &'a mut Counts,
    pub(super) known: KnownFilters,
}

impl LeavingRays<'_, '_> {
    /// Takes all that are reflected.
    pub(super) fn reflected<S: Simd>(&mut self, simd: S) {
        let Above { rays, points, .. } = self.above;
        let mut mirror: Option<PlaneMirror> = None;
        for (packet, &hit) in points.hit.iter().enumerate() {
            for lane in ones(hit) {
                let slot = packet * LANES + lane;
                if self.delta(slot).is_none() {
                    continue;
                }
                let [eye, direction] = rays.ray(slot);
                let mirror = match &mut mirror {
                    Some(mirror) if mirror.is_of(points, slot, eye) => mirror,
                    other => {
                        let world = self.setup.world;
                        other.insert(PlaneMirror::of(world, points, slot, eye))
                    }
                };
                if lane == hit.trailing_zeros() as usize
                    && self.reflected_packet(simd, mirror, packet)
                {
                    break;
                }
                let lanes = self.above.lanes;
                let lane = (lanes.media[slot], lanes.nm[slot]);
                match mirror.reflected(points, slot, direction, lane) {
                    Some(Some(leaving)) => self.take(slot, leaving, lanes.sample[slot]),
                    Some(None) => {}
                    None => self.leave(slot, Branch::Reflected, None, lanes.sample[slot]),
                }
            }
        }
    }

    /// Takes all that go through surfaces, but by the ways of wavelengths.
    pub(super) fn transmitted(&mut self) {
        let Above { points, lanes, .. } = self.above;
        for slot in hits(points) {
            if self.delta(slot).is_some_and(Delta::transmits) {
                self.leave(slot, Branch::Transmitted, None, lanes.sample[slot]);
            }
        }
    }

    /// What is smooth of what is met.
    fn delta(&self, slot: usize) -> Option<&Delta> {
        self.setup
            .world
            .delta(self.above.points.material[slot] as usize)
    }

    /// Takes a ray that leaves a point by one wavelength's way.
    pub(super) fn leave_by(&mut self, way: Way) {
        self.leave(way.slot, Branch::Dispersed(way.nm), way.share, way.sample);
    }

    /// Takes the ray that leaves a point by one branch, or what share of it there is.
    fn leave(&mut self, slot: usize, branch: Branch, share: Option<Spectrum>, sample: u16) {
        let Above {
            rays,
            points,
            lanes,
            ..
        } = self.above;
        let [origin, direction] = rays.ray(slot);
        let arriving = Arriving {
            origin,
            direction,
            media: lanes.media[slot],
            nm: lanes.nm[slot],
        };
        let leaving = shading::leave(self.setup.world, points, slot, &arriving, branch);
        if let Some(mut leaving) = leaving {
            leaving.filter = share.map(Filter::Spectrum).or(leaving.filter);
            self.take(slot, leaving, sample);
        }
    }

    /// Takes a ray that leaves a point to the others, unless next to nothing of it arrives.
    fn take(&mut self, slot: usize, leaving: Leaving, sample: u16) {
        let world = self.setup.world;
        let Step {
            rays,
            shaded,
            lanes,
            ..
        } = &mut *self.step;
        let filter = leaving.filter;
        let mut weight = leaving.weight;
        for (weight, above) in weight.iter_mut().zip(&self.above.lanes.weight) {
            *weight *= above[slot];
        }
        let most = weight
            .iter()
            .fold(0.0, |most, weight| f64::max(most, weight.abs()));
        // What arrives of the brightest radiance of the world, at most.
        let bound = || {
            let peak = filter.as_ref().map_or(1.0, |filter| filter.peak(world));
            most * peak * shading::most_in(world, leaving.media)
        };
        let cut = &mut self.cut[usize::from(sample)];
        let is_negligible =
            || self.negligible > 0.0 && *cut + bound() <= self.negligible || most < NEGLIGIBLE;
        if self.depth >= world.max_depth() || is_negligible() {
            if most > 0.0 {
                *cut += bound();
                self.counts.cut_rays += 1;
            }
            return;
        }
        let place = lanes.count;
        lanes.count += 1;
        rays.push_from(leaving.origin, leaving.direction, &leaving.start);
        lanes.sample[place] = sample;
        for (column, weight) in lanes.weight.iter_mut().zip(weight) {
            column[place] = weight;
        }
        lanes.media[place] = leaving.media;
        lanes.nm[place] = leaving.nm;
        let past = (self.above.shaded, slot);
        match filter {
            None => self.known.pass_on(past, shaded, place),
            Some(Filter::Color(color)) => self.known.color(world, past, color, shaded, place),
            Some(Filter::Spectrum(filter)) => {
                let material = self.above.points.material[slot];
                self.known.own(past, (material, &filter), shaded, place);
            }
        }
    }

    /// Takes all rays of a packet at once, if one plane mirror reflects them all: those that [`Self::take`] would take one by
    /// one. Whether that is so.
    #[inline(never)]
    fn reflected_packet<S: Simd>(&mut self, simd: S, mirror: &PlaneMirror, packet: usize) -> bool {
        simd.vectorize(
            #[inline(always)]
            || self.reflected_lanes(simd, mirror, packet),
        )
    }

    #[inline(always)]
    fn reflected_lanes<S: Simd>(&mut self, simd: S, mirror: &PlaneMirror, packet: usize) -> bool {
        let Above {
            rays,
            points,
            shaded: past,
            lanes: above,
        } = self.above;
        let world = self.setup.world;
        if self.depth >= world.max_depth() {
            return false;
        }
        let Some(reflected) = mirror.reflected_packet(simd, points, rays, packet) else {
            return false;
        };
        let bits = points.hit[packet];
        let weights = [
            F64x16::load(simd, columns(&above.weight, packet)[0]) * reflected.weight[0],
            F64x16::load(simd, columns(&above.weight, packet)[1]) * reflected.weight[1],
            F64x16::load(simd, columns(&above.weight, packet)[2]) * reflected.weight[2],
        ];
        let most = weights[0].abs().max(weights[1].abs()).max(weights[2].abs());
        let peak = reflected
            .color
            .map_or(1.0, |color| Filter::Color(color).peak(world));
        // Where there is any doubt they are taken one by one.
        let is_enough = most.ge(F64x16::splat(simd, NEGLIGIBLE))
            & (most * peak).gt(F64x16::splat(simd, self.negligible));
        let is_enough = is_enough.to_bits();
        if is_enough & bits != bits {
            return false;
        }
        let Step {
            rays,
            shaded,
            lanes,
            ..
        } = &mut *self.step;
        let first = packet * LANES;
        let place = lanes.count;
        let count = bits.count_ones() as usize;
        let ray = (reflected.origin, reflected.direction);
        let starts = points.ray_starts(simd, packet, reflected.t);
        rays.push_reflected(simd, bits, ray, &starts);
        lanes.count += count;
        if count == LANES && place + LANES <= BATCH {
            lanes.sample[place..place + LANES].copy_from_slice(&above.sample[first..first + LANES]);
            lanes.nm[place..place + LANES].copy_from_slice(&above.nm[first..first + LANES]);
            weights[0].store(&mut lanes.weight[0][place..]);
            weights[1].store(&mut lanes.weight[1][place..]);
            weights[2].store(&mut lanes.weight[2][place..]);
        } else {
            let [r, g, b] = [
                weights[0].to_array(),
                weights[1].to_array(),
                weights[2].to_array(),
            ];
            for (place, lane) in (place..).zip(ones(bits)) {
                lanes.sample[place] = above.sample[first + lane];
                lanes.nm[place] = above.nm[first + lane];
                lanes.weight[0][place] = r[lane];
                lanes.weight[1][place] = g[lane];
                lanes.weight[2][place] = b[lane];
            }
        }
        if !world.bodies().is_empty() {
            for (place, lane) in (place..).zip(ones(bits)) {
                lanes.media[place] = above.media[first + lane];
            }
        }
        if reflected.color.is_some() || past.filters.has_any() {
            for (place, lane) in (place..).zip(ones(bits)) {
                let past = (past, first + lane);
                match reflected.color {
                    None => self.known.pass_on(past, shaded, place),
                    Some(color) => self.known.color(world, past, color, shaded, place),
                }
            }
        }
        true
    }
}
