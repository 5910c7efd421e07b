//! What comes by mirrors and glass: layers of its own, and a part of the share of each light.

use fearless_simd::Simd;

use super::super::arrivals::Arrivals;
use super::super::batch::NumberedSamples;
use super::super::layers::Content;
use super::LayerSums;
use super::spectral::SpectralSums;
use crate::shading::{LightTerms, Shaded, emission};
use crate::simd::{LANES, ones};
use crate::visibility::{Column, Points};

impl LayerSums<'_> {
    /// Adds what comes by mirrors and through glass.
    #[inline(always)]
    pub(in crate::render) fn add_branches<S: Simd>(
        &mut self,
        simd: S,
        samples: NumberedSamples<'_>,
        reflected: &[Column; 3],
        transmitted: &[Column; 3],
    ) {
        for (content, part) in [
            (Content::Reflection, reflected),
            (Content::Refraction, transmitted),
        ] {
            if let Some(first) = self.requested.place(content) {
                self.planes.add_three(simd, samples, first, part);
            }
        }
    }

    /// Adds what rays that have left surfaces see of the background and of lights to the shares of these.
    #[inline(always)]
    pub(in crate::render) fn add_path<S: Simd>(
        &mut self,
        simd: S,
        samples: NumberedSamples<'_>,
        points: &Points,
        shaded: &Shaded,
        arrivals: Arrivals<'_>,
        scattered: &mut [Column; 3],
    ) {
        let requested = self.requested;
        if let Some(paths) = self.spectral.as_mut().and_then(SpectralSums::paths) {
            paths.add_path(requested.world, points, shaded, arrivals);
        }
        self.add_relight_emission(simd, samples, points, &shaded.filters, arrivals);
        let Some(first) = requested.place(Content::Lights) else {
            return;
        };
        let mut seen = [Column::ZERO; 3];
        if let Some(share) = requested.shares.background() {
            // Before any light is added the radiance is that of the background, and of lights that are seen.
            for (channel, seen) in seen.iter_mut().enumerate() {
                for (packet, &bits) in points.hit.iter().enumerate() {
                    for lane in ones(!bits & ((1 << LANES) - 1)) {
                        let slot = packet * LANES + lane;
                        seen[slot] = shaded.radiance[channel][slot];
                    }
                }
            }
            arrivals.scatter(&seen, scattered);
            self.planes
                .add_three(simd, samples, first + 3 * share, scattered);
        }
        if !requested.world.has_emission() {
            return;
        }
        for light in 0..requested.world.lights().len() {
            let Some(share) = requested.shares.of_light(light) else {
                continue;
            };
            let mut is_seen = false;
            for seen in &mut seen {
                seen.fill(0.0);
            }
            for (packet, &bits) in points.hit.iter().enumerate() {
                for lane in ones(bits) {
                    let slot = packet * LANES + lane;
                    if let Some((index, luminance)) =
                        emission(requested.world, points, &shaded.filters, slot)
                        && index == light
                    {
                        is_seen = true;
                        for (seen, luminance) in seen.iter_mut().zip(luminance) {
                            seen[slot] = luminance;
                        }
                    }
                }
            }
            if is_seen {
                arrivals.scatter(&seen, scattered);
                self.planes
                    .add_three(simd, samples, first + 3 * share, scattered);
            }
        }
    }

    /// Adds what a light does at the points that rays meet that have left surfaces to the share of that light.
    #[inline(always)]
    pub(in crate::render) fn add_path_light<S: Simd>(
        &mut self,
        simd: S,
        samples: NumberedSamples<'_>,
        shaded: &Shaded,
        terms: &LightTerms,
        arrivals: Arrivals<'_>,
        scattered: &mut [Column; 3],
    ) {
        if let Some(paths) = self.spectral.as_mut().and_then(SpectralSums::paths) {
            paths.add_light(shaded, terms, arrivals);
        }
        let Some(share) = self.requested.shares.of_light(terms.light) else {
            return;
        };
        if let Some(first) = self.requested.place(Content::Relight) {
            let place = (first, share);
            self.add_relight(simd, samples, shaded, terms, place, Some(arrivals));
        }
        for (content, part) in [
            (Content::Lights, &terms.radiance),
            (Content::LightDiffuse, &terms.lobes.diffuse),
            (Content::LightSpecular, &terms.lobes.specular),
        ] {
            if let Some(first) = self.requested.place(content) {
                arrivals.scatter(part, scattered);
                self.planes
                    .add_three(simd, samples, first + 3 * share, scattered);
            }
        }
    }
}
