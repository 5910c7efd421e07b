//! The rays that leave the points of a batch by one branch, what they meet, and what they have been through.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use super::arrivals::Arrivals;
use super::setup::Setup;
use crate::shading::{self, LightTerms, Shaded};
use crate::simd::{LANES, ones};
use crate::spectrum::Spectrum;
use crate::visibility::{BATCH, Column, IncoherentRays, PACKETS, Points, vector};
use crate::world::{Chain, ChainColor, Media, World};

/// A batch of rays that have left surfaces, and what they meet.
pub(super) struct Step {
    pub(super) rays: IncoherentRays,
    pub(super) points: Points,
    pub(super) shaded: Shaded,
    pub(super) terms: LightTerms,
    pub(super) lanes: Lanes,
    /// Parts of layers, at the places of the camera rays.
    pub(super) scattered: [Column; 3],
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
pub(super) struct Lanes {
    /// The camera ray that each comes from, by its place in its batch.
    pub(super) sample: [u16; BATCH],
    /// How much of the radiance arrives, per primary.
    pub(super) weight: [Column; 3],
    pub(super) media: [Media; BATCH],
    /// The wavelength in nm whose way it takes; 0 where it is that of all.
    pub(super) nm: [u16; BATCH],
    pub(super) count: usize,
}

impl Default for Lanes {
    fn default() -> Self {
        Self {
            sample: [0; BATCH],
            weight: [Column::ZERO; 3],
            media: [Media::NONE; BATCH],
            nm: [0; BATCH],
            count: 0,
        }
    }
}

/// Rays, what they meet, and what they have been through.
#[derive(Clone, Copy)]
pub(super) struct Above<'a> {
    pub(super) rays: &'a IncoherentRays,
    pub(super) points: &'a Points,
    pub(super) shaded: &'a Shaded,
    pub(super) lanes: &'a Lanes,
}

/// The filters that rays of one branch have, so far.
#[derive(Default)]
pub(super) struct KnownFilters {
    /// Those that nothing was put to, by their numbers before.
    passed_on: HashMap<u16, u16>,
    /// Those that colored mirrors make.
    chains: Vec<(Chain, u16)>,
    /// The last one of a material, and what it was before.
    last: Option<(u16, u32, u16)>,
}

/// A ray before it leaves a point: its batch, and its place there.
type Past<'a> = (&'a Shaded, usize);

impl KnownFilters {
    /// A filter that a surface does not change, if there is one.
    #[inline]
    pub(super) fn pass_on(&mut self, (past, slot): Past<'_>, shaded: &mut Shaded, ray: usize) {
        let before = past.filters.number(slot);
        let Some(filter) = past.filters.get(before) else {
            return;
        };
        if let Some(chain) = past.filters.chain(before) {
            return self.chain(chain, || filter, shaded, ray);
        }
        match self.passed_on.entry(before) {
            Entry::Occupied(known) => shaded.filters.share(ray, *known.get()),
            Entry::Vacant(place) => {
                shaded.filters.push(ray, filter.clone());
                place.insert(shaded.filters.number(ray));
            }
        }
    }

    /// A filter after one more reflection by a colored mirror.
    #[inline]
    pub(super) fn color(
        &mut self,
        world: &World,
        (past, slot): Past<'_>,
        color: ChainColor,
        shaded: &mut Shaded,
        ray: usize,
    ) {
        let chains = world.chains().expect("colors are of chains");
        let before = past.filters.number(slot);
        let chain_before = past.filters.chain(before);
        let is_chain = before == 0 || chain_before.is_some();
        match chains.after(chain_before, color).filter(|_| is_chain) {
            Some(chain) => self.chain(chain, || chains.spectrum(chain), shaded, ray),
            None => {
                let reflectance = chains.reflectance(color);
                let filter = match past.filters.get(before) {
                    Some(past) => past.times(reflectance),
                    None => reflectance.clone(),
                };
                shaded.filters.push(ray, filter);
            }
        }
    }

    /// A filter that colored mirrors make.
    #[inline]
    fn chain<'a>(
        &mut self,
        chain: Chain,
        filter: impl FnOnce() -> &'a Spectrum,
        shaded: &mut Shaded,
        ray: usize,
    ) {
        // There are few, and the last one mostly is it.
        let known = self.chains.iter().rev().find(|(known, _)| *known == chain);
        match known {
            Some((_, number)) => shaded.filters.share(ray, *number),
            None => {
                shaded.filters.push_chain(ray, chain, filter());
                self.chains.push((chain, shaded.filters.number(ray)));
            }
        }
    }

    /// A filter of a material, which may depend on the angle.
    pub(super) fn own(
        &mut self,
        (past, slot): Past<'_>,
        (material, filter): (u32, &Spectrum),
        shaded: &mut Shaded,
        ray: usize,
    ) {
        let before = past.filters.number(slot);
        let filter = match past.filters.get(before) {
            Some(past) => past.times(filter),
            None => filter.clone(),
        };
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

impl Step {
    pub(super) fn clear(&mut self) {
        self.rays.clear();
        self.shaded.filters.clear();
        self.lanes.count = 0;
    }

    pub(super) fn above(&self) -> Above<'_> {
        Above {
            rays: &self.rays,
            points: &self.points,
            shaded: &self.shaded,
            lanes: &self.lanes,
        }
    }
}

impl Lanes {
    /// Camera rays have been through nothing.
    pub(super) fn of_camera() -> Self {
        let mut lanes = Self::default();
        for (slot, sample) in lanes.sample.iter_mut().enumerate() {
            *sample = slot as u16;
        }
        for weight in &mut lanes.weight {
            weight.fill(1.0);
        }
        lanes
    }

    /// Where the light that these rays see arrives.
    pub(super) fn arrivals(&self) -> Arrivals<'_> {
        Arrivals {
            samples: &self.sample[..self.count],
            weights: &self.weight,
        }
    }
}

/// The points that are hit.
pub(super) fn hits(points: &Points) -> impl Iterator<Item = usize> {
    (0..PACKETS).flat_map(|packet| ones(points.hit[packet]).map(move |lane| packet * LANES + lane))
}

/// Takes away what the glass between the ends of rays absorbs; whether that is anything.
pub(super) fn absorb(
    setup: &Setup<'_>,
    rays: &IncoherentRays,
    points: &Points,
    shaded: &mut Shaded,
    lanes: &mut Lanes,
) -> bool {
    let mut is_any = false;
    if setup.world.bodies().is_empty() {
        return is_any;
    }
    for slot in 0..lanes.count {
        if lanes.media[slot].top().is_none() {
            continue;
        }
        let is_hit = points.hit[slot / LANES] >> (slot % LANES) & 1 == 1;
        let end = vector(&points.position, slot);
        let start = rays.start(slot).map(|start| start.position);
        let [eye, _] = rays.ray(slot);
        let distance = if is_hit {
            (end - start.unwrap_or(eye)).length()
        } else {
            f64::INFINITY
        };
        let Some((factors, filter)) = shading::absorbed(setup.world, lanes.media[slot], distance)
        else {
            continue;
        };
        is_any = true;
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
    is_any
}
