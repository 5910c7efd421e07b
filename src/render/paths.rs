//! Light that comes by mirrors and glass (Whitted 1980): every branch is followed, none by chance.
//!
//! L(ray) is what lights do at the point that it meets, plus a share of L of each ray that leaves this point by
//! reflection or refraction. Rays that leave the points of a batch by the same branch are a batch again, at most as
//! large. Branches are followed one after the other to their ends, the reflected one first, so that the sum of a sample
//! has the same order beside any others.

use fearless_simd::Simd;

use super::arrivals::Arrivals;
use super::batch::NumberedSamples;
use super::counts::Counts;
use super::dispersion::{Seen, Spread};
use super::layer_sums::LayerSums;
use super::leaving_rays::{LeavingRays, Way};
use super::path_step::{Above, KnownFilters, Lanes, Step, absorb, hits};
use super::setup::Setup;
use super::sights::{Sights, is_free};
use crate::math::Point;
use crate::shading::{self, Branch, Shaded};
use crate::simd::DVec3x16;
use crate::visibility::{BATCH, Column, IncoherentRays, Points, RayBatch, ShaftSpace, Workspace};
use crate::world::Media;

/// What a thread needs to follow light, to be used again and again.
pub(super) struct Paths {
    rays: IncoherentRays,
    seen: Lanes,
    spare: Vec<Box<Step>>,
    arrived: Arrived,
    /// The bodies of glass that the eye is inside of, where all rays have one.
    around_eye: Option<(Point, Media)>,
    /// Whether that glass absorbs any light.
    is_dimmed: bool,
    shafts: ShaftSpace,
}

impl Default for Paths {
    fn default() -> Self {
        Self {
            rays: IncoherentRays::default(),
            seen: Lanes::of_camera(),
            spare: Vec::new(),
            arrived: Arrived::default(),
            around_eye: None,
            is_dimmed: false,
            shafts: ShaftSpace::default(),
        }
    }
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

/// A step whose branches are being followed.
struct Taken {
    step: Box<Step>,
    branches: Branches,
    /// That by which its rays left the points that the camera sees.
    first: Branch,
}

/// The branches of a step.
#[derive(Default)]
struct Branches {
    /// How many have been followed.
    followed: usize,
    /// Where light is dispersed, the wavelengths that it is split into.
    spreads: Option<Vec<Split>>,
}

/// A point at which light is dispersed.
struct Split {
    slot: usize,
    spread: Spread,
    ways: Vec<u16>,
}

/// What is the same for all rays of a batch, and where what they see goes.
struct Tracer<'t, 's, 'w, 'l> {
    setup: &'t Setup<'w>,
    samples: NumberedSamples<'s>,
    tracing: &'t mut Workspace,
    shafts: &'t mut ShaftSpace,
    layers: Option<&'t mut LayerSums<'l>>,
    arrived: &'t mut Arrived,
    /// How often rays have been reflected or refracted that the first batch of all is made of.
    depth: u32,
    /// What is looked at along the ways of wavelengths, before light takes them.
    sights: Option<Sights>,
    counts: Counts,
}

impl Paths {
    /// Takes a batch of camera rays before their points are shaded, and what the glass around the eye absorbs of their light:
    /// filters, and what to [dim](Self::dim) it by. Whether there is any of that.
    #[inline(never)]
    pub(super) fn begin<S: Simd>(
        &mut self,
        simd: S,
        setup: &Setup<'_>,
        rays: &RayBatch<'_, impl Fn(usize) -> DVec3x16<S>>,
        points: &Points,
        shaded: &mut Shaded,
    ) -> bool {
        shaded.filters.clear();
        let has_bodies = !setup.world.bodies().is_empty();
        if !has_bodies && !is_any_smooth(setup, points) {
            return false;
        }
        simd.vectorize(
            #[inline(always)]
            || self.rays.take(simd, rays),
        );
        self.begin_seen(setup);
        if self.is_dimmed {
            for weight in &mut self.seen.weight {
                weight.fill(1.0);
            }
        }
        self.is_dimmed = has_bodies && absorb(setup, &self.rays, points, shaded, &mut self.seen);
        self.is_dimmed
    }

    /// What arrives of the light of the batch that was [begun](Self::begin), where the glass around the eye absorbs any.
    pub(super) fn dimmed(&self) -> Option<Arrivals<'_>> {
        self.is_dimmed.then(|| self.seen.arrivals())
    }

    /// What is left of light on its way to the eye.
    pub(super) fn dim(&self, light: &mut [Column; 3]) {
        for (light, weight) in light.iter_mut().zip(&self.seen.weight) {
            for (light, weight) in light.iter_mut().zip(weight.iter()) {
                *light *= weight;
            }
        }
    }

    /// Follows the light of the batch that was [begun](Self::begin) through mirrors and glass, and adds what arrives to
    /// its radiance.
    #[inline(never)]
    #[expect(clippy::too_many_arguments, reason = "all that a batch is")]
    pub(super) fn follow<S: Simd>(
        &mut self,
        simd: S,
        setup: &Setup<'_>,
        points: &Points,
        shaded: &mut Shaded,
        samples: NumberedSamples<'_>,
        tracing: &mut Workspace,
        layers: Option<&mut LayerSums<'_>>,
    ) -> Counts {
        if !is_any_smooth(setup, points) {
            return Counts::default();
        }
        for channel in 0..3 {
            self.arrived.reflected[channel].fill(0.0);
            self.arrived.transmitted[channel].fill(0.0);
        }
        self.arrived.cut.fill(0.0);
        let mut tracer = Tracer {
            setup,
            samples,
            tracing,
            shafts: &mut self.shafts,
            layers,
            arrived: &mut self.arrived,
            depth: 0,
            sights: None,
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

/// Whether anything that is hit is smooth.
fn is_any_smooth(setup: &Setup<'_>, points: &Points) -> bool {
    let is_smooth = |slot: usize| setup.world.delta(points.material[slot] as usize).is_some();
    hits(points).any(is_smooth)
}

impl<'w> Tracer<'_, '_, 'w, '_> {
    /// Follows all branches of points that are seen, to their ends.
    fn follow<S: Simd>(&mut self, simd: S, seen: Above<'_>, spare: &mut Vec<Box<Step>>) {
        // What is on its way, from the camera on: recursion would take a stack as deep as the paths.
        let mut steps: Vec<Taken> = Vec::new();
        let mut of_seen = Branches::default();
        loop {
            let depth = self.depth + steps.len() as u32;
            let (above, branches, first) = match steps.last_mut() {
                None => (seen, &mut of_seen, None),
                Some(taken) => {
                    let Taken {
                        step,
                        branches,
                        first,
                    } = taken;
                    (step.above(), branches, Some(*first))
                }
            };
            let mut step = spare.pop().unwrap_or_default();
            let Some(branch) = self.leave_next(simd, above, depth, branches, &mut step, spare)
            else {
                spare.push(step);
                match steps.pop() {
                    Some(taken) => spare.push(taken.step),
                    None => return,
                }
                continue;
            };
            if step.lanes.count == 0 {
                spare.push(step);
                continue;
            }
            let first = first.unwrap_or(branch);
            self.see(simd, first, &mut step);
            steps.push(Taken {
                step,
                branches: Branches::default(),
                first,
            });
        }
    }

    /// Takes the rays that leave the points of a batch by the next branch, and tells which that is; `None` where all
    /// have been followed.
    fn leave_next<S: Simd>(
        &mut self,
        simd: S,
        above: Above<'_>,
        depth: u32,
        branches: &mut Branches,
        step: &mut Step,
        spare: &mut Vec<Box<Step>>,
    ) -> Option<Branch> {
        let number = branches.followed;
        branches.followed += 1;
        step.clear();
        if number > 1 && branches.spreads.is_none() {
            branches.spreads = Some(self.splits(simd, above, depth, spare));
        }
        let mut leaving = self.leaving(above, depth, step);
        match number {
            0 => {
                leaving.reflected(simd);
                Some(Branch::Reflected)
            }
            1 => {
                leaving.transmitted();
                Some(Branch::Transmitted)
            }
            _ => {
                let mut is_any = false;
                for Split { slot, spread, ways } in branches.spreads.iter().flatten() {
                    if let Some(&nm) = ways.get(number - 2) {
                        is_any = true;
                        leaving.leave_by(Way {
                            slot: *slot,
                            nm,
                            share: Some(spread.share(nm)),
                            sample: above.lanes.sample[*slot],
                        });
                    }
                }
                is_any.then_some(Branch::Transmitted)
            }
        }
    }

    /// Where rays that leave a batch of points are put.
    fn leaving<'a>(
        &'a mut self,
        above: Above<'a>,
        depth: u32,
        step: &'a mut Step,
    ) -> LeavingRays<'a, 'w> {
        LeavingRays {
            setup: self.setup,
            above,
            depth,
            step,
            // Ways that are looked along tell where light is cut.
            negligible: if self.sights.is_none() {
                self.setup.negligible
            } else {
                0.0
            },
            cut: &mut self.arrived.cut,
            counts: &mut self.counts,
            known: KnownFilters::default(),
        }
    }

    /// The points of a batch that disperse light, and into which wavelengths.
    fn splits<S: Simd>(
        &mut self,
        simd: S,
        above: Above<'_>,
        depth: u32,
        spare: &mut Vec<Box<Step>>,
    ) -> Vec<Split> {
        let world = self.setup.world;
        if !world.has_dispersion() {
            return Vec::new();
        }
        let is_split = |slot: &usize| {
            above.lanes.nm[*slot] == 0 && world.may_disperse(above.points.material[*slot] as usize)
        };
        let slots = hits(above.points).filter(is_split);
        let mut splits: Vec<Split> = slots
            .map(|slot| Split {
                slot,
                spread: Spread::new(),
                ways: Vec::new(),
            })
            .collect();
        if depth >= world.max_depth() {
            // None is followed, which one counts.
            for split in &mut splits {
                split.ways.push(Spread::MIDDLE);
            }
            return splits;
        }
        let reach = self.setup.visibility.reach();
        loop {
            let mut wanted = Vec::new();
            for (place, Split { spread, .. }) in splits.iter().enumerate() {
                spread.wanted(|nm| wanted.push((place, nm)));
            }
            if wanted.is_empty() {
                break;
            }
            for part in wanted.chunks(BATCH) {
                let ways = part.iter().enumerate().map(|(sample, &(place, nm))| Way {
                    slot: splits[place].slot,
                    nm,
                    share: None,
                    sample: sample as u16,
                });
                let sights = Sights {
                    seen: vec![Seen::default(); part.len()],
                    reach,
                };
                let seen = self.look_along(simd, above, depth, ways, sights, spare);
                for (&(place, nm), seen) in part.iter().zip(seen) {
                    splits[place].spread.note(nm, seen);
                }
            }
            let visibility = self.setup.visibility;
            for Split { spread, .. } in &mut splits {
                spread.decide(|segments| is_free(simd, visibility, segments, self.shafts));
            }
        }
        for Split { spread, ways, .. } in &mut splits {
            *ways = spread.ways();
        }
        splits
    }

    /// What is seen along the ways of wavelengths, of which there are at most [`BATCH`]; `sights` has a place for each.
    fn look_along<S: Simd>(
        &mut self,
        simd: S,
        above: Above<'_>,
        depth: u32,
        ways: impl Iterator<Item = Way>,
        sights: Sights,
        spare: &mut Vec<Box<Step>>,
    ) -> Vec<Seen> {
        let mut arrived = Box::<Arrived>::default();
        let mut step = spare.pop().unwrap_or_default();
        step.clear();
        let mut tracer = Tracer {
            setup: self.setup,
            samples: self.samples,
            tracing: &mut *self.tracing,
            shafts: &mut *self.shafts,
            layers: None,
            arrived: &mut arrived,
            depth: depth + 1,
            sights: Some(sights),
            counts: Counts::default(),
        };
        let mut leaving = tracer.leaving(above, depth, &mut step);
        for way in ways {
            leaving.leave_by(way);
        }
        if step.lanes.count > 0 {
            tracer.see(simd, Branch::Transmitted, &mut step);
            tracer.follow(simd, step.above(), spare);
        }
        spare.push(step);
        let Tracer { sights, counts, .. } = tracer;
        self.counts.secondary_rays += counts.secondary_rays;
        self.counts.shadow_rays += counts.shadow_rays;
        self.counts.lit += counts.lit;
        let mut seen = sights.map_or_else(Vec::new, |sights| sights.seen);
        for (sample, seen) in seen.iter_mut().enumerate() {
            for (channel, value) in seen.value.iter_mut().enumerate() {
                *value = arrived.reflected[channel][sample] + arrived.transmitted[channel][sample];
            }
            seen.is_cut = arrived.cut[sample] > 0.0;
        }
        seen
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
        if let Some(sights) = &mut self.sights {
            sights.note(rays, points, lanes);
        }
        shaded.cuts_areas = self.setup.cuts_areas;
        match &mut self.layers {
            Some(layers) if layers.requested().wants_light() => {
                let detail = layers.requested().detail();
                shading::begin_terms(simd, world, visibility, points, self.tracing, shaded);
                let arrivals = lanes.arrivals();
                layers.add_path(simd, self.samples, points, shaded, arrivals, scattered);
                for lit in 0..shaded.lit() {
                    shading::light_terms(simd, world, points, lit, detail, shaded, terms);
                    let samples = self.samples;
                    layers.add_path_light(simd, samples, shaded, terms, arrivals, scattered);
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
