//! What is looked at along the ways of wavelengths, before light takes them.

use fearless_simd::Simd;

use super::dispersion::{Seen, Segment};
use super::path_step::Lanes;
use crate::math::DVec3;
use crate::simd::LANES;
use crate::visibility::{
    IncoherentRays, Points, Shaft, ShaftAnswer, ShaftQuestion, ShaftSpace, Visibility,
    object_and_triangle, vector,
};

/// What is seen along the ways of wavelengths.
pub(super) struct Sights {
    pub(super) seen: Vec<Seen>,
    /// Further away than this there is nothing.
    pub(super) reach: f64,
}

impl Sights {
    /// Notes what rays have met.
    pub(super) fn note(&mut self, rays: &IncoherentRays, points: &Points, lanes: &Lanes) {
        for slot in 0..lanes.count {
            let Some(start) = rays.start(slot) else {
                continue;
            };
            let is_hit = points.hit[slot / LANES] >> (slot % LANES) & 1 == 1;
            let end = if is_hit {
                vector(&points.position, slot)
            } else {
                let [_, direction] = rays.ray(slot);
                let far = 4.0 * (self.reach + start.position.length());
                start.position + direction.normalize_or_zero() * far
            };
            let (from, _) = object_and_triangle(start.primitive);
            self.seen[usize::from(lanes.sample[slot])]
                .segments
                .push(Segment {
                    ends: [start.position, end],
                    objects: [Some(from), is_hit.then(|| points.object(slot))],
                });
        }
    }
}

/// Whether nothing but the objects at their ends is in the shaft around segments.
pub(super) fn is_free<S: Simd>(
    simd: S,
    visibility: &Visibility<'_>,
    segments: [&Segment; 5],
    shafts: &mut ShaftSpace,
) -> bool {
    /// More are not gone through.
    const MOST_LISTED: usize = 16;
    let [from, to] = [0, 1].map(|end| {
        let points = segments.map(|segment| segment.ends[end]);
        let [first, ..] = points;
        let least = points.into_iter().fold(first, DVec3::min);
        [least, points.into_iter().fold(first, DVec3::max)]
    });
    let shaft = Shaft::ToBox { from, to };
    let question = ShaftQuestion::Contents;
    let objects = segments[0].objects;
    let is_end = |shape: u64| objects.contains(&Some(object_and_triangle(shape).0));
    match visibility.shaft(simd, &shaft, question, u64::MAX, MOST_LISTED, shafts) {
        ShaftAnswer::Nothing => true,
        ShaftAnswer::All(shape) => is_end(shape),
        ShaftAnswer::These => shafts.list.iter().all(|&shape| is_end(shape)),
        ShaftAnswer::TooMany => false,
    }
}
