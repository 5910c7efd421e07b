//! Points of a light with an area, one by one: where very many shapes hide a part of it, and before panes.

use fearless_simd::Simd;

use super::area::{AreaLit, AreaSpace, AreaTerms, Asked};
use super::panes::{Crossing, Opaque, PaneSpace};
use crate::emitter::{Emitter, Received, Receiver, SurfacePoint};
use crate::math::Point;
use crate::simd::LANES;
use crate::visibility::{PACKETS, RayStart, SegmentBatch, Visibility, Workspace};
use crate::world::World;
use crate::world::light::AreaLight;

impl Asked<'_, '_> {
    /// Takes away what panes reflect, of [the points](AreaSpace::undimmed) where that is not known otherwise: as much as
    /// of [`AreaLight::samples`] points of the light.
    #[inline(never)]
    pub(super) fn through_panes<S: Simd>(
        &self,
        simd: S,
        lit: &mut AreaLit,
        area: &mut AreaSpace,
        space: &mut Workspace,
    ) {
        let AreaSpace {
            undimmed, panes, ..
        } = area;
        for &slot in &*undimmed {
            let start = self.points.start(slot);
            let receiver = self.receiver(slot, &start);
            let scene = (self.world, self.visibility);
            let (light, start) = (self.light, start.into());
            let [diffuse, specular] =
                through_panes(simd, scene, light, &start, &receiver, panes, space);
            let AreaTerms { geometry, seen } = &mut *lit.terms;
            geometry.diffuse[slot] *= diffuse;
            geometry.specular[slot] *= specular;
            seen[slot] *= diffuse;
        }
    }

    /// Asks points of the light, of all points of the batch that have a bit: what arrives with nothing in the way,
    /// times the part of it that arrives of those points.
    #[inline(never)]
    pub(super) fn sample<S: Simd>(
        &self,
        simd: S,
        sampled: &[u32; PACKETS],
        lit: &mut AreaLit,
        area: &mut AreaSpace,
        space: &mut Workspace,
    ) {
        let AreaSpace { free, sums, .. } = area;
        sums.clear();
        sums.resize(free.len(), [0.0; 4]);
        for point in self.light.emitter.points(self.light.samples) {
            let facing = self.points.facing(simd, self.world, point.position);
            let mut above = facing.above;
            for (above, sampled) in above.iter_mut().zip(sampled) {
                *above &= sampled;
            }
            if above == [0; PACKETS] {
                continue;
            }
            let asked: u32 = above.iter().map(|bits| bits.count_ones()).sum();
            lit.asked += u64::from(asked);
            let segments = SegmentBatch::ToPoint {
                end: point.position,
                to_light: None,
                number: self.number,
                points: self.points,
                facing: &above,
            };
            let reached = self.visibility.free(simd, segments, space);
            for ((slot, receiver, _), sums) in free.iter().zip(sums.iter_mut()) {
                let bit = |bits: &[u32; PACKETS]| bits[slot / LANES] >> (slot % LANES) & 1 == 1;
                if !bit(&above) {
                    continue;
                }
                let weights = weights(
                    &self.light.emitter,
                    &point,
                    self.points.start(*slot).position,
                    receiver,
                );
                let is_reached = bit(&reached);
                for (lobe, weight) in weights.into_iter().enumerate() {
                    sums[2 * lobe] += weight;
                    sums[2 * lobe + 1] += if is_reached { weight } else { 0.0 };
                }
            }
        }
        for ((slot, _, received), &[all, reached, of_lobe, reached_of_lobe]) in
            free.iter().zip(&*sums)
        {
            let part = |reached: f64, all: f64| if all > 0.0 { reached / all } else { 0.0 };
            let share = part(reached, all);
            if reached > 0.0 || reached_of_lobe > 0.0 {
                let of_lobe = if of_lobe > 0.0 {
                    part(reached_of_lobe, of_lobe)
                } else {
                    share
                };
                let seen = Received {
                    irradiance: received.irradiance * share,
                    lobe: received.lobe * of_lobe,
                    solid_angle: received.solid_angle * share,
                };
                self.put(lit, *slot, &seen, share);
            }
        }
    }
}

/// How much of the light that a point receives of a light with an area passes panes, for its diffuse and its specular
/// lobe, as [`AreaLight::samples`] points of the light say.
pub(super) fn through_panes<S: Simd>(
    simd: S,
    (world, visibility): (&World, &Visibility<'_>),
    light: &AreaLight,
    start: &RayStart,
    receiver: &Receiver,
    panes: &mut PaneSpace,
    space: &mut Workspace,
) -> [f64; 2] {
    let from = Point(start.position);
    panes.crossings.clear();
    for point in light.emitter.points(light.samples) {
        let crossing = Crossing::new(*start, point.position.from(from), 1.0);
        panes.crossings.push(crossing);
    }
    panes.cross(simd, world, visibility, Opaque::Ignored, space);
    let (mut all, mut passed) = ([0.0; 2], [0.0; 2]);
    let points = light.emitter.points(light.samples);
    for (point, crossing) in points.into_iter().zip(&panes.crossings) {
        let weights = weights(&light.emitter, &point, from, receiver);
        for lobe in 0..2 {
            all[lobe] += weights[lobe];
            passed[lobe] += weights[lobe] * crossing.passed;
        }
    }
    [0, 1].map(|lobe: usize| {
        if all[lobe] > 0.0 {
            passed[lobe] / all[lobe]
        } else {
            1.0
        }
    })
}

/// What a part of a light sends to the lobes of a point, with nothing in the way: only the ratios count.
fn weights(emitter: &Emitter, of: &SurfacePoint, to: Point, receiver: &Receiver) -> [f64; 2] {
    let way = of.position.from(to);
    let square = way.length_squared();
    let inverse = square.sqrt().recip();
    let cos_light = -of.normal.dot(way) * inverse;
    let cos_light = if emitter.is_two_sided() {
        cos_light.abs()
    } else {
        cos_light.max(0.0)
    };
    let solid_angle = of.area * cos_light / square;
    let u = way * inverse;
    let cos_incident = receiver.normal.get().dot(u).max(0.0);
    let lobe = receiver.gloss.as_ref().map_or(0.0, |gloss| {
        let cosine = gloss.axis.get().dot(u).max(0.0);
        let lobe = libm::pow(cosine, gloss.shininess);
        if gloss.has_cosine {
            lobe * cos_incident
        } else {
            lobe
        }
    });
    let weights = [solid_angle * cos_incident, solid_angle * lobe];
    if weights.iter().all(|weight| weight.is_finite()) {
        weights
    } else {
        [0.0; 2]
    }
}
