//! L4: which segments are free.

use fearless_simd::Simd;

use super::batch::IncoherentSegments;
use super::candidates::{Candidates, CurrentRay, Pair};
use crate::simd::{DVec3x16, LANES, ones};
use crate::visibility::batch::{PACKETS, first_lanes};
use crate::visibility::rays::{Rays, ShearedRays};
use crate::visibility::search::{Along, Way};
use crate::visibility::shape::{Block, SphereBlock, TriangleBlock, disk, plane};
use crate::visibility::shapes::Shapes;
use crate::visibility::tree::DESCENTS;

/// A segment is not free.
#[inline(always)]
fn hide(free: &mut [u32; PACKETS], segment: usize) {
    free[segment / LANES] &= !(1 << (segment % LANES));
}

/// L4 for spheres.
struct SegmentSpheres<'b> {
    segments: &'b IncoherentSegments,
    free: &'b mut [u32; PACKETS],
    current: [usize; DESCENTS],
}

impl<S: Simd> Along<S, SphereBlock> for SegmentSpheres<'_> {
    #[inline(always)]
    fn begin(&mut self, place: usize, segment: usize) -> Option<Way> {
        self.current[place] = segment;
        self.segments.way(segment, self.free)
    }

    #[inline(always)]
    fn show(&mut self, simd: S, place: usize, block: &SphereBlock, bits: u32) -> Option<f64> {
        let segment = self.current[place];
        let [start, end] = self.segments.ends(segment);
        let rays = Rays::new(
            DVec3x16::splat(simd, start.position),
            DVec3x16::splat(simd, end.position - start.position),
            None,
        );
        if block.hides(simd, &rays, [&start, &end], bits) {
            hide(self.free, segment);
            return None;
        }
        Some(1.0)
    }

    #[inline(always)]
    fn end(&mut self, _: usize) {}
}

/// L4 for triangles: what f32 is sure of, and the candidates.
struct SegmentTriangles<'b, 'w> {
    shapes: &'b Shapes<'w>,
    segments: &'b IncoherentSegments,
    free: &'b mut [u32; PACKETS],
    pairs: &'b mut Vec<Pair>,
    current: [CurrentRay; DESCENTS],
}

impl<S: Simd> Along<S, TriangleBlock> for SegmentTriangles<'_, '_> {
    #[inline(always)]
    fn begin(&mut self, place: usize, segment: usize) -> Option<Way> {
        let way = self.segments.way(segment, self.free)?;
        self.current[place].set(segment, &way);
        Some(way)
    }

    #[inline(always)]
    fn show(&mut self, simd: S, place: usize, block: &TriangleBlock, bits: u32) -> Option<f64> {
        let CurrentRay {
            ray: segment,
            single,
            list,
            ..
        } = &mut self.current[place];
        let Some(met) = block.meet(simd, single, bits) else {
            return Some(1.0);
        };
        let [start, end] = self.segments.ends(*segment);
        let between = if met.surely != 0 {
            met.between(simd, single, [start.error, end.error])
        } else {
            0
        };
        let reach = met.reach();
        for place in ones(met.maybe) {
            let own = block.primitive(place);
            if own == start.primitive || own == end.primitive {
                continue;
            }
            let [least, most] = reach.of(place);
            let mut is_hidden = between >> place & 1 == 1;
            if !is_hidden && (most < 0.0 || least > 1.0) {
                continue;
            }
            if !is_hidden && list.len == LANES {
                let pairs = list.all_pairs(*segment);
                is_hidden = self.shapes.hidden_pairs(simd, self.segments, &pairs) != 0;
                list.len = 0;
            }
            if is_hidden {
                hide(self.free, *segment);
                list.len = 0;
                return None;
            }
            list.push(least, block.number(place));
        }
        Some(1.0)
    }

    #[inline(always)]
    fn end(&mut self, place: usize) {
        let CurrentRay { ray, list, .. } = &self.current[place];
        self.pairs.extend(list.pairs(*ray));
    }
}

impl Shapes<'_> {
    #[inline(always)]
    pub(super) fn free_all<S: Simd>(
        &self,
        simd: S,
        segments: &IncoherentSegments,
        space: &mut Candidates,
    ) -> [u32; PACKETS] {
        let Candidates { descents, pairs } = space;
        pairs.clear();
        let mut free = self.free_of_planes(simd, segments);
        if !self.world.disks().is_empty() {
            self.hide_by_disks(simd, segments, &mut free);
        }
        if !self.spheres.is_empty() {
            let mut asker = SegmentSpheres {
                segments,
                free: &mut free,
                current: [0; DESCENTS],
            };
            self.spheres.along::<S, _, false>(
                simd,
                0..segments.count,
                &mut asker,
                &mut descents.alone,
            );
        }
        if !self.triangles.is_empty() {
            let mut asker = SegmentTriangles {
                shapes: self,
                segments,
                free: &mut free,
                pairs,
                current: [CurrentRay::NONE; DESCENTS],
            };
            self.triangles.along::<S, _, false>(
                simd,
                0..segments.count,
                &mut asker,
                &mut descents.alone,
            );
            for pairs in pairs.chunks(LANES) {
                for lane in ones(self.hidden_pairs(simd, segments, pairs)) {
                    hide(&mut free, pairs[lane].ray as usize);
                }
            }
        }
        free
    }

    #[inline(always)]
    fn free_of_planes<S: Simd>(&self, simd: S, segments: &IncoherentSegments) -> [u32; PACKETS] {
        let mut free = [0; PACKETS];
        for (packet, free) in free.iter_mut().enumerate() {
            *free = first_lanes(segments.count, packet);
            if *free == 0 || self.world.planes().is_empty() {
                continue;
            }
            let (start, end) = (
                segments.start.packet(simd, packet),
                segments.end.packet(simd, packet),
            );
            for plane in self.world.planes() {
                *free &= !plane::is_between(simd, plane, &start, &end).to_bits();
            }
        }
        free
    }

    /// Disks that are beside the box around a packet's segments are left out.
    #[inline(never)]
    fn hide_by_disks<S: Simd>(
        &self,
        simd: S,
        segments: &IncoherentSegments,
        free: &mut [u32; PACKETS],
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                for (packet, free) in free.iter_mut().enumerate() {
                    if *free == 0 {
                        continue;
                    }
                    let start = segments.start.packet(simd, packet);
                    let end = segments.end.packet(simd, packet);
                    let bounds = segments.bounds(packet, *free);
                    for disk in self.world.disks() {
                        if !disk::is_beside(disk, bounds) {
                            *free &= !disk::is_between(simd, disk, &start, &end).to_bits();
                        }
                    }
                }
            },
        );
    }

    /// Puts at most sixteen pairs to f64; one bit for each whose triangle stands in the way.
    #[inline(never)]
    fn hidden_pairs<S: Simd>(&self, simd: S, segments: &IncoherentSegments, pairs: &[Pair]) -> u32 {
        simd.vectorize(
            #[inline(always)]
            || {
                let start = segments.start.gathered(simd, pairs);
                let end = segments.end.gathered(simd, pairs);
                let direction = end.position - start.position;
                let packet = ShearedRays::new(Rays::new(start.position, direction, None));
                let (triangles, _) = self.triangles_of(simd, pairs);
                triangles.occlude(simd, &packet, &start, &end).to_bits()
            },
        )
    }
}
