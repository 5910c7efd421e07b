//! Light that no surface reflects, seen by camera rays: of lights themselves, and of the background.

use fearless_simd::Simd;

use super::super::arrivals::Arrivals;
use super::super::batch::NumberedSamples;
use super::super::layers::Content;
use super::LayerSums;
use crate::shading::{Shaded, emission};
use crate::simd::{F64x16, LANES, Mask64x16, ones};
use crate::visibility::{Column, PACKETS, Points};

impl LayerSums<'_> {
    /// What lights that are seen send themselves.
    #[inline(never)]
    pub(super) fn add_emission<S: Simd>(
        &mut self,
        simd: S,
        samples: NumberedSamples<'_>,
        points: &Points,
        shaded: &Shaded,
        dimmed: Option<Arrivals<'_>>,
        first: usize,
    ) {
        if !self.requested.world.has_emission() {
            return;
        }
        for channel in 0..3 {
            self.fill_luminance(points, shaded, channel, |_| true);
            self.add_dimmed(simd, samples, first + channel, channel, dimmed);
        }
    }

    /// The same light by light, or group by group, and for lights of other colors.
    #[inline(never)]
    pub(super) fn add_emission_of_lights<S: Simd>(
        &mut self,
        simd: S,
        samples: NumberedSamples<'_>,
        points: &Points,
        shaded: &Shaded,
        dimmed: Option<Arrivals<'_>>,
    ) {
        let requested = self.requested;
        let first = requested.place(Content::EmissionOfLights);
        let spectral = requested.place(Content::Relight).zip(
            requested
                .reflectances
                .as_ref()
                .map(|reflectances| reflectances.count() * requested.shares.of_lights().len()),
        );
        if (first.is_none() && spectral.is_none()) || !self.sees_lights(points) {
            return;
        }
        for (place, &share) in requested.shares.seen().iter().enumerate() {
            if let Some(first) = first {
                let is_of_share = |light| requested.shares.of_light(light) == Some(share);
                for channel in 0..3 {
                    if self.fill_luminance(points, shaded, channel, is_of_share) {
                        let plane = first + 3 * place + channel;
                        self.add_dimmed(simd, samples, plane, channel, dimmed);
                    }
                }
            }
            if let Some((first, of_reflectances)) = spectral
                && self.fill_emission(points, share, |_| true)
            {
                self.add_arrived(simd, samples, first + of_reflectances + place, dimmed);
            }
        }
    }

    /// One primary of what some of the lights send that are seen, into the column; whether any is.
    fn fill_luminance(
        &mut self,
        points: &Points,
        shaded: &Shaded,
        channel: usize,
        is_of_lights: impl Fn(usize) -> bool,
    ) -> bool {
        *self.column = Column::ZERO;
        let mut is_any = false;
        for (packet, &bits) in points.hit.iter().enumerate() {
            for lane in ones(bits) {
                let slot = packet * LANES + lane;
                let seen = emission(self.requested.world, points, &shaded.filters, slot);
                if let Some((light, luminance)) = seen
                    && is_of_lights(light)
                {
                    is_any = true;
                    self.column[slot] = luminance[channel];
                }
            }
        }
        is_any
    }

    /// The background where nothing is hit: to its share, or to a layer of its own.
    #[inline(always)]
    pub(super) fn add_background<S: Simd>(
        &mut self,
        simd: S,
        samples: NumberedSamples<'_>,
        points: &Points,
        shaded: &Shaded,
        dimmed: Option<Arrivals<'_>>,
        (content, first): (Content, usize),
    ) {
        let first = match (content, self.requested.shares.background()) {
            (Content::Background, _) => first,
            (_, Some(share)) => first + 3 * share,
            (_, None) => return,
        };
        if points.all_hit() {
            return;
        }
        let background = self.requested.world.background().0.0;
        for (channel, background) in background.into_iter().enumerate() {
            for packet in 0..PACKETS {
                let is_hit = Mask64x16::from_bits(simd, points.hit[packet]);
                let zero = F64x16::splat(simd, 0.0);
                let values = is_hit.select(zero, F64x16::splat(simd, background));
                values.store(&mut self.column[packet * LANES..]);
            }
            if dimmed.is_some() {
                self.filter_background(points, shaded, channel);
            }
            self.add_dimmed(simd, samples, first + channel, channel, dimmed);
        }
    }

    /// The background as filters leave it.
    fn filter_background(&mut self, points: &Points, shaded: &Shaded, channel: usize) {
        let world = self.requested.world;
        for (packet, &bits) in points.hit.iter().enumerate() {
            for lane in ones(!bits & ((1 << LANES) - 1)) {
                let slot = packet * LANES + lane;
                if let Some(filter) = shaded.filters.get(shaded.filters.number(slot)) {
                    self.column[slot] = world.background_through(filter).0.0[channel];
                }
            }
        }
    }

    /// Adds the column to a plane, or what the glass around the eye leaves of it in a primary.
    #[inline(always)]
    fn add_dimmed<S: Simd>(
        &mut self,
        simd: S,
        samples: NumberedSamples<'_>,
        plane: usize,
        channel: usize,
        dimmed: Option<Arrivals<'_>>,
    ) {
        if let Some(dimmed) = dimmed {
            let weights = dimmed.weights[channel].iter();
            let column = self.column.iter_mut();
            column
                .zip(weights)
                .for_each(|(value, weight)| *value *= weight);
        }
        self.planes.add(simd, samples, plane, &self.column);
    }
}
