//! Light that comes by mirrors and glass (Whitted 1980): every branch is followed, none by chance.
//!
//! L(ray) is what lights do at the point that it meets, plus a share of L of each ray that leaves this point by
//! reflection or refraction. Rays that leave the points of a batch by the same branch are a batch again, at most as
//! large. Branches are followed one after the other to their ends, the reflected one first, so that the sum of a sample
//! has the same order beside any others.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use fearless_simd::Simd;

use super::batch::NumberedSamples;
use super::counts::Counts;
use super::layer_sums::LayerSums;
use super::setup::Setup;
use crate::math::Point;
use crate::shading::{self, Arriving, BANDS, Branch, Filter, LightTerms, Shaded};
use crate::simd::{DVec3x16, LANES, ones};
use crate::spectrum::Spectrum;
use crate::visibility::{
    BATCH, Column, IncoherentRays, PACKETS, Points, RayBatch, Workspace, vector,
};
use crate::world::Media;

/// A branch of which less than this arrives is not followed: of light that is 10⁶ times as bright as what is beside it,
/// the last digit of 32 bits would be more.
const NEGLIGIBLE: f64 = 1e-14;

/// What a thread needs to follow light, to be used again and again.
#[derive(Default)]
pub(super) struct Paths {
    rays: IncoherentRays,
    seen: Lanes,
    spare: Vec<Box<Step>>,
    arrived: Arrived,
    /// The bodies of glass that the eye is inside of, where all rays have one.
    around_eye: Option<(Point, Media)>,
}

/// What comes by the branches of a batch of camera rays, in cd/m² per primary.
#[derive(Clone, Debug)]
struct Arrived {
    reflected: [Column; 3],
    transmitted: [Column; 3],
    /// How much of the brightest radiance rays that were not followed would have brought at most, of each sample.
    cut: Column,
}

impl Default for Arrived {
    fn default() -> Self {
        Self {
            reflected: [Column::ZERO; 3],
            transmitted: [Column::ZERO; 3],
            cut: Column::ZERO,
        }
    }
}

/// A batch of rays that have left surfaces, and what they meet.
struct Step {
    rays: IncoherentRays,
    points: Points,
    shaded: Shaded,
    terms: LightTerms,
    lanes: Lanes,
    /// Parts of layers, at the places of the camera rays.
    scattered: [Column; 3],
}

impl Default for Step {
    fn default() -> Self {
        Self {
            rays: IncoherentRays::default(),
            points: Points::default(),
            shaded: Shaded::default(),
            terms: LightTerms::default(),
            lanes: Lanes::default(),
            scattered: [Column::ZERO; 3],
        }
    }
}

/// What rays have been through.
#[derive(Clone, Debug)]
struct Lanes {
    /// The camera ray that each comes from, by its place in its batch.
    sample: [u16; BATCH],
    /// How much of the radiance arrives, per primary.
    weight: [Column; 3],
    media: [Media; BATCH],
    band: [u16; BATCH],
    count: usize,
}

impl Default for Lanes {
    fn default() -> Self {
        Self {
            sample: [0; BATCH],
            weight: [Column::ZERO; 3],
            media: [Media::NONE; BATCH],
            band: [0; BATCH],
            count: 0,
        }
    }
}

/// The filters that rays of one branch have, so far.
#[derive(Default)]
struct KnownFilters {
    /// By the number of the filter before, and the band that the ray is part of from here on, 0 for none.
    by_band: HashMap<(u16, u16), u16>,
    /// The last one of a material, and what it was before.
    last: Option<(u16, u32, u16)>,
}

impl KnownFilters {
    /// A filter that follows from two numbers.
    fn filter(
        &mut self,
        shaded: &mut Shaded,
        ray: usize,
        key: (u16, u16),
        make: impl FnOnce() -> Spectrum,
    ) {
        match self.by_band.entry(key) {
            Entry::Occupied(known) => shaded.filters.share(ray, *known.get()),
            Entry::Vacant(place) => {
                shaded.filters.push(ray, make());
                place.insert(shaded.filters.number(ray));
            }
        }
    }

    /// A filter of a material, which may depend on the angle.
    fn own(
        &mut self,
        shaded: &mut Shaded,
        ray: usize,
        (before, material): (u16, u32),
        filter: Spectrum,
    ) {
        match self.last {
            Some((known, of, number))
                if (known, of) == (before, material)
                    && shaded.filters.get(number) == Some(&filter) =>
            {
                shaded.filters.share(ray, number);
            }
            _ => {
                shaded.filters.push(ray, filter);
                self.last = Some((before, material, shaded.filters.number(ray)));
            }
        }
    }
}

/// A step whose branches are being followed.
struct Taken {
    step: Box<Step>,
    /// The next of its branches, and how many there are.
    next: u16,
    count: u16,
    /// That by which its rays left the points that the camera sees.
    first: Branch,
}

/// What is the same for all rays of a batch, and where what they see goes.
struct Tracer<'t, 's, 'w, 'l> {
    setup: &'t Setup<'w>,
    samples: NumberedSamples<'s>,
    tracing: &'t mut Workspace,
    layers: Option<&'t mut LayerSums<'l>>,
    arrived: &'t mut Arrived,
    counts: Counts,
}

/// Rays, what they meet, and what they have been through.
#[derive(Clone, Copy)]
struct Above<'a> {
    rays: &'a IncoherentRays,
    points: &'a Points,
    shaded: &'a Shaded,
    lanes: &'a Lanes,
}

impl Paths {
    /// Follows the light of a batch of camera rays through mirrors and glass, and adds what arrives to their radiance.
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "all that a batch is")]
    pub(super) fn follow<S: Simd>(
        &mut self,
        simd: S,
        setup: &Setup<'_>,
        rays: &RayBatch<'_, impl Fn(usize) -> DVec3x16<S>>,
        points: &Points,
        shaded: &mut Shaded,
        samples: NumberedSamples<'_>,
        tracing: &mut Workspace,
        layers: Option<&mut LayerSums<'_>>,
    ) -> Counts {
        let world = setup.world;
        let is_smooth = |slot: usize| world.delta(points.material[slot] as usize).is_some();
        if !hits(points).any(is_smooth) {
            return Counts::default();
        }
        self.rays.take(simd, rays);
        self.begin_seen(setup);
        for channel in 0..3 {
            self.arrived.reflected[channel].fill(0.0);
            self.arrived.transmitted[channel].fill(0.0);
        }
        self.arrived.cut.fill(0.0);
        let mut tracer = Tracer {
            setup,
            samples,
            tracing,
            layers,
            arrived: &mut self.arrived,
            counts: Counts::default(),
        };
        let above = Above {
            rays: &self.rays,
            points,
            shaded,
            lanes: &self.seen,
        };
        tracer.follow(simd, above, &mut self.spare);
        let Tracer {
            layers,
            mut counts,
            arrived,
            ..
        } = tracer;
        let Arrived {
            reflected,
            transmitted,
            cut,
        } = &*arrived;
        for channel in 0..3 {
            let sum = &mut shaded.radiance[channel];
            for slot in 0..BATCH {
                sum[slot] = sum[slot] + reflected[channel][slot] + transmitted[channel][slot];
            }
        }
        if let Some(layers) = layers {
            layers.add_branches(simd, samples, reflected, transmitted);
        }
        counts.cut = cut.iter().fold(0.0, |most, &cut| f64::max(most, cut));
        counts
    }

    /// Camera rays have been through nothing, but may start inside of glass.
    fn begin_seen(&mut self, setup: &Setup<'_>) {
        let world = setup.world;
        let seen = &mut self.seen;
        seen.count = self.rays.count();
        for slot in 0..BATCH {
            seen.sample[slot] = slot as u16;
        }
        for weight in &mut seen.weight {
            weight.fill(1.0);
        }
        seen.band.fill(0);
        if world.bodies().is_empty() {
            return;
        }
        for slot in 0..seen.count {
            let [origin, _] = self.rays.ray(slot);
            let origin = Point(origin);
            let media = match self.around_eye {
                Some((eye, media)) if eye == origin => media,
                _ => world.media_around(origin),
            };
            self.around_eye = Some((origin, media));
            seen.media[slot] = media;
        }
    }
}

impl Tracer<'_, '_, '_, '_> {
    /// Follows all branches of the points that the camera sees, to their ends.
    fn follow<S: Simd>(&mut self, simd: S, seen: Above<'_>, spare: &mut Vec<Box<Step>>) {
        // What is on its way, from the camera on: recursion would take a stack as deep as the paths.
        let mut steps: Vec<Taken> = Vec::new();
        let mut next_of_seen = 0;
        let count_of_seen = self.branches(seen);
        loop {
            let depth = steps.len();
            let (above, next, count, first) = match steps.last_mut() {
                None => (seen, &mut next_of_seen, count_of_seen, None),
                Some(taken) => {
                    let Taken {
                        step,
                        next,
                        count,
                        first,
                    } = taken;
                    (step.above(), next, *count, Some(*first))
                }
            };
            if *next == count {
                match steps.pop() {
                    Some(taken) => spare.push(taken.step),
                    None => return,
                }
                continue;
            }
            let branch = match *next {
                0 => Branch::Reflected,
                1 => Branch::Transmitted,
                band => Branch::Dispersed(band - 2),
            };
            *next += 1;
            let mut step = spare.pop().unwrap_or_default();
            self.leave(above, depth as u32, branch, &mut step);
            if step.lanes.count == 0 {
                spare.push(step);
                continue;
            }
            let first = first.unwrap_or(branch);
            self.see(simd, first, &mut step);
            let count = self.branches(step.above());
            steps.push(Taken {
                step,
                next: 0,
                count,
                first,
            });
        }
    }

    /// How many branches may leave the points of a batch.
    fn branches(&self, above: Above<'_>) -> u16 {
        let Setup { world, .. } = *self.setup;
        let is_split = |slot: usize| {
            above.lanes.band[slot] == 0 && world.may_disperse(above.points.material[slot] as usize)
        };
        if world.has_dispersion() && hits(above.points).any(is_split) {
            2 + BANDS
        } else {
            2
        }
    }

    /// Takes the rays that leave the points of a batch by one branch.
    fn leave(&mut self, above: Above<'_>, depth: u32, branch: Branch, step: &mut Step) {
        let Setup { world, .. } = *self.setup;
        let Step {
            rays,
            shaded,
            lanes,
            ..
        } = step;
        rays.clear();
        shaded.filters.clear();
        lanes.count = 0;
        let mut known = KnownFilters::default();
        for slot in hits(above.points) {
            let material = above.points.material[slot];
            let is_there = match branch {
                Branch::Reflected | Branch::Transmitted => world.delta(material as usize).is_some(),
                Branch::Dispersed(_) => {
                    above.lanes.band[slot] == 0 && world.may_disperse(material as usize)
                }
            };
            if !is_there {
                continue;
            }
            let [origin, direction] = above.rays.ray(slot);
            let arriving = Arriving {
                origin,
                direction,
                media: above.lanes.media[slot],
                band: above.lanes.band[slot],
            };
            let Some(leaving) = shading::leave(world, above.points, slot, &arriving, branch) else {
                continue;
            };
            let sample = above.lanes.sample[slot];
            let mut weight = leaving.weight;
            for (weight, above) in weight.iter_mut().zip(&above.lanes.weight) {
                *weight *= above[slot];
            }
            let most = weight
                .iter()
                .fold(0.0, |most, weight| f64::max(most, weight.abs()));
            if depth >= world.max_depth() || most < NEGLIGIBLE {
                if most > 0.0 {
                    let peak = match &leaving.filter {
                        Some(Filter::Own(filter)) => filter.peak().0,
                        Some(Filter::Band(_)) | None => 1.0,
                    };
                    let inside = shading::most_in(world, leaving.media);
                    self.arrived.cut[usize::from(sample)] += most * peak * inside;
                    self.counts.cut_rays += 1;
                }
                continue;
            }
            let place = lanes.count;
            lanes.count += 1;
            rays.push_from(leaving.origin, leaving.direction, &leaving.start);
            lanes.sample[place] = sample;
            for (column, weight) in lanes.weight.iter_mut().zip(weight) {
                column[place] = weight;
            }
            lanes.media[place] = leaving.media;
            lanes.band[place] = leaving.band;
            let before = above.shaded.filters.number(slot);
            let past = above.shaded.filters.get(before);
            match (past, leaving.filter) {
                (None, None) => continue,
                (Some(past), None) => known.filter(shaded, place, (before, 0), || past.clone()),
                (past, Some(Filter::Band(band))) => {
                    known.filter(shaded, place, (before, band), || {
                        let share = shading::share_of_band(band);
                        past.map_or_else(|| share.clone(), |past| past.times(&share))
                    });
                }
                (past, Some(Filter::Own(factor))) => {
                    let filter = past.map_or_else(|| factor.clone(), |past| past.times(&factor));
                    known.own(shaded, place, (before, material), filter);
                }
            }
        }
    }

    /// Finds out what rays meet, and adds what lights do there to what arrives.
    #[inline(never)]
    fn see<S: Simd>(&mut self, simd: S, first: Branch, step: &mut Step) {
        let Setup {
            world, visibility, ..
        } = *self.setup;
        let Step {
            rays,
            points,
            shaded,
            terms,
            lanes,
            scattered,
        } = step;
        let batch: RayBatch<'_, fn(usize) -> DVec3x16<S>> = RayBatch::Any(rays);
        visibility.nearest(simd, &batch, self.tracing, points);
        self.counts.secondary_rays += lanes.count as u64;
        absorb(self.setup, rays, points, shaded, lanes);
        shaded.cuts_areas = self.setup.cuts_areas;
        match &mut self.layers {
            Some(layers) if layers.requested().wants_light() => {
                let detail = layers.requested().detail();
                shading::begin_terms(simd, world, visibility, points, self.tracing, shaded);
                let scatter = |from: &[Column; 3], to: &mut [Column; 3]| {
                    lanes.scatter(from, to);
                };
                layers.add_path(simd, self.samples, points, shaded, scattered, scatter);
                for lit in 0..shaded.lit() {
                    shading::light_terms(simd, world, points, lit, detail, shaded, terms);
                    layers.add_path_light(simd, self.samples, terms, scattered, scatter);
                }
            }
            _ => shading::radiance(simd, world, visibility, points, self.tracing, shaded),
        }
        self.counts.shadow_rays += shaded.shadow_rays;
        self.counts.lit += shaded.lit_points;
        self.counts.singular += shaded.singular;
        let sums = match first {
            Branch::Reflected => &mut self.arrived.reflected,
            Branch::Transmitted | Branch::Dispersed(_) => &mut self.arrived.transmitted,
        };
        for ((sums, weight), radiance) in sums.iter_mut().zip(&lanes.weight).zip(&shaded.radiance) {
            for (slot, &sample) in lanes.sample[..lanes.count].iter().enumerate() {
                sums[usize::from(sample)] += weight[slot] * radiance[slot];
            }
        }
    }
}

impl Step {
    fn above(&self) -> Above<'_> {
        Above {
            rays: &self.rays,
            points: &self.points,
            shaded: &self.shaded,
            lanes: &self.lanes,
        }
    }
}

impl Lanes {
    /// What arrives of a part of the radiance, at the places of the camera rays.
    fn scatter(&self, from: &[Column; 3], to: &mut [Column; 3]) {
        for (channel, to) in to.iter_mut().enumerate() {
            to.fill(0.0);
            for slot in 0..self.count {
                to[usize::from(self.sample[slot])] =
                    self.weight[channel][slot] * from[channel][slot];
            }
        }
    }
}

/// The points that are hit.
fn hits(points: &Points) -> impl Iterator<Item = usize> {
    (0..PACKETS).flat_map(|packet| ones(points.hit[packet]).map(move |lane| packet * LANES + lane))
}

/// Takes away what the glass between the ends of rays absorbs.
fn absorb(
    setup: &Setup<'_>,
    rays: &IncoherentRays,
    points: &Points,
    shaded: &mut Shaded,
    lanes: &mut Lanes,
) {
    for slot in 0..lanes.count {
        if lanes.media[slot].top().is_none() {
            continue;
        }
        let is_hit = points.hit[slot / LANES] >> (slot % LANES) & 1 == 1;
        let end = vector(&points.position, slot);
        let distance = match rays.start(slot) {
            Some(start) if is_hit => (end - start.position).length(),
            Some(_) | None => f64::INFINITY,
        };
        let Some((factors, filter)) = shading::absorbed(setup.world, lanes.media[slot], distance)
        else {
            continue;
        };
        for (weight, factor) in lanes.weight.iter_mut().zip(factors) {
            weight[slot] *= factor;
        }
        if let Some(filter) = filter {
            let filters = &mut shaded.filters;
            let filter = match filters.get(filters.number(slot)) {
                Some(before) => before.times(&filter),
                None => filter,
            };
            filters.push(slot, filter);
        }
    }
}
