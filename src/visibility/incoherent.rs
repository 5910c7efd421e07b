//! Rays and segments that share nothing: each on its own way down the trees.
//!
//! A ray goes through the nodes alone, eight boxes at a time, and sixteen shapes of a leaf are put to it side
//! by side: spheres in f64, triangles in f32 with bounds ([`SingleRay`]). What f32 cannot rule out is a
//! candidate, what it is sure of says how far to look. In the end the candidates of all rays of the batch are
//! put to f64, sixteen pairs of a ray and a triangle at a time, by the formulas of the packets. So a ray meets what it
//! meets in a packet, at the same t to the bit, and ties go by the order of the scene.

mod batches;

use fearless_simd::Simd;

use super::Visibility;
use super::batch::{BATCH, PACKETS, columns, first_lanes};
use super::primitive::Primitive;
use super::question::NearestHit;
use super::rays::{Rays, ShearedRays};
use super::search::{Along, DESCENTS, Descents, Way};
use super::shape::{SingleRay, SphereBlock, TriangleBlock, TrianglePerRay, plane, side_by_side};
use super::shapes::Shapes;
use crate::simd::{DVec3x16, LANES, U64x16, ones};
#[cfg(test)]
pub(crate) use batches::EndBatch;
pub(crate) use batches::{Hits, RayBatch, SegmentBatch};
use batches::{Pair, gathered};

/// What a thread needs for batches, to be used again and again.
#[derive(Debug)]
pub(crate) struct Candidates {
    descents: Descents,
    pairs: Vec<Pair>,
}

/// The candidates of one ray.
#[derive(Clone, Copy, Debug)]
struct Shortlist {
    /// The least t at which each is met, if it is.
    least: [f64; LANES],
    triangles: [u32; LANES],
    len: usize,
}

impl Default for Candidates {
    fn default() -> Self {
        Self {
            descents: Default::default(),
            pairs: Vec::with_capacity(2 * BATCH),
        }
    }
}

impl Shortlist {
    /// Puts one more on it; there is room.
    #[inline(always)]
    fn push(&mut self, least: f64, triangle: u32) {
        self.least[self.len] = least;
        self.triangles[self.len] = triangle;
        self.len += 1;
    }

    /// Drops those that are certainly met after t of `limit`.
    #[inline]
    fn keep_up_to(&mut self, limit: f64) {
        let mut kept = 0;
        for place in 0..self.len {
            if self.least[place] <= limit {
                self.least[kept] = self.least[place];
                self.triangles[kept] = self.triangles[place];
                kept += 1;
            }
        }
        self.len = kept;
    }

    /// As pairs with a ray.
    fn pairs(&self, ray: usize) -> impl Iterator<Item = Pair> {
        let triangles = self.triangles.iter().take(self.len);
        triangles.map(move |&triangle| Pair {
            ray: ray as u32,
            triangle,
        })
    }

    /// The same, for all at once.
    fn to_array(&self, ray: usize) -> [Pair; LANES] {
        let mut pairs = [Pair {
            ray: ray as u32,
            triangle: 0,
        }; LANES];
        for (pair, listed) in pairs.iter_mut().zip(self.pairs(ray)) {
            *pair = listed;
        }
        pairs
    }
}

/// A segment is not free.
#[inline(always)]
fn hide(free: &mut [u32; PACKETS], segment: usize) {
    free[segment / LANES] &= !(1 << (segment % LANES));
}

/// A ray on its way along triangles, and its candidates.
#[derive(Clone, Copy, Debug)]
struct CurrentRay {
    ray: usize,
    single: SingleRay,
    limit: f64,
    list: Shortlist,
}

impl CurrentRay {
    const NONE: Self = Self {
        ray: 0,
        single: SingleRay::NONE,
        limit: 0.0,
        list: Shortlist {
            least: [0.0; LANES],
            triangles: [0; LANES],
            len: 0,
        },
    };

    #[inline(always)]
    fn set(&mut self, ray: usize, way: &Way) {
        self.ray = ray;
        self.single = SingleRay::new(way.origin, way.direction);
        self.limit = way.limit;
        self.list.len = 0;
    }
}

/// L2 for spheres.
struct NearestSpheres<'b> {
    rays: &'b RayBatch,
    hits: &'b mut Hits,
    current: [usize; DESCENTS],
}

impl<S: Simd> Along<S, SphereBlock> for NearestSpheres<'_> {
    #[inline(always)]
    fn begin(&mut self, place: usize, ray: usize) -> Option<Way> {
        self.current[place] = ray;
        Some(self.rays.way(ray, self.hits.t[ray]))
    }

    #[inline(always)]
    fn show(&mut self, simd: S, place: usize, block: &SphereBlock, bits: u32) -> Option<f64> {
        let ray = self.current[place];
        let way = self.rays.way(ray, 0.0);
        let lanes = Rays::new(
            DVec3x16::splat(simd, way.origin),
            DVec3x16::splat(simd, way.direction),
            None,
        );
        if let Some((found, t)) = block.first_met(simd, &lanes, bits) {
            let t = t.to_array();
            for place in ones(found.to_bits()) {
                self.hits.offer(ray, t[place], block.primitive(place));
            }
        }
        Some(self.hits.t[ray])
    }

    #[inline(always)]
    fn end(&mut self, _: usize) {}
}

/// L2 for triangles: their candidates.
struct NearestTriangles<'b, 'w> {
    shapes: &'b Shapes<'w>,
    rays: &'b RayBatch,
    hits: &'b mut Hits,
    pairs: &'b mut Vec<Pair>,
    current: [CurrentRay; DESCENTS],
}

impl<S: Simd> Along<S, TriangleBlock> for NearestTriangles<'_, '_> {
    #[inline(always)]
    fn begin(&mut self, place: usize, ray: usize) -> Option<Way> {
        let way = self.rays.way(ray, self.hits.t[ray]);
        self.current[place].set(ray, &way);
        Some(way)
    }

    #[inline(always)]
    fn show(&mut self, simd: S, place: usize, block: &TriangleBlock, bits: u32) -> Option<f64> {
        let CurrentRay {
            ray,
            single,
            limit,
            list,
        } = &mut self.current[place];
        let Some(met) = block.meet(simd, single, bits) else {
            return Some(*limit);
        };
        let reach = met.reach();
        for place in ones(met.maybe) {
            let [least, most] = reach.of(place);
            if most < 0.0 || least > *limit {
                continue;
            }
            if list.len == LANES {
                list.keep_up_to(*limit);
            }
            if list.len == LANES {
                let pairs = list.to_array(*ray);
                self.shapes.meet_pairs(simd, self.rays, &pairs, self.hits);
                list.len = 0;
                *limit = limit.min(self.hits.t[*ray]);
            }
            list.push(least, block.number(place));
            if met.surely >> place & 1 == 1 && least > 0.0 && most < *limit {
                *limit = most;
            }
        }
        Some(*limit)
    }

    #[inline(always)]
    fn end(&mut self, place: usize) {
        let CurrentRay {
            ray, limit, list, ..
        } = &mut self.current[place];
        list.keep_up_to(*limit);
        self.pairs.extend(list.pairs(*ray));
    }
}

/// L4 for spheres.
struct SegmentSpheres<'b> {
    segments: &'b SegmentBatch,
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
    segments: &'b SegmentBatch,
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
                let pairs = list.to_array(*segment);
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

impl Visibility<'_> {
    /// L2: what each ray of a batch meets first, whatever they share.
    #[inline(never)]
    pub(crate) fn nearest<S: Simd>(
        &self,
        simd: S,
        rays: &RayBatch,
        space: &mut Candidates,
        hits: &mut Hits,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.shapes.nearest_all(simd, rays, space, hits),
        );
    }

    /// L4: one bit for each segment of a batch, packet by packet, that no shape stands strictly between the ends
    /// of, whatever they share.
    #[inline(never)]
    pub(crate) fn free<S: Simd>(
        &self,
        simd: S,
        segments: &SegmentBatch,
        space: &mut Candidates,
    ) -> [u32; PACKETS] {
        simd.vectorize(
            #[inline(always)]
            || self.shapes.free_all(simd, segments, space),
        )
    }
}

impl Shapes<'_> {
    #[inline(always)]
    fn nearest_all<S: Simd>(
        &self,
        simd: S,
        rays: &RayBatch,
        space: &mut Candidates,
        hits: &mut Hits,
    ) {
        self.meet_planes(simd, rays, hits);
        let Candidates { descents, pairs } = space;
        pairs.clear();
        if !self.spheres.is_empty() {
            let mut asker = NearestSpheres {
                rays,
                hits,
                current: [0; DESCENTS],
            };
            self.spheres
                .along::<S, _, true>(simd, rays.count, &mut asker, descents);
        }
        if !self.triangles.is_empty() {
            let mut asker = NearestTriangles {
                shapes: self,
                rays,
                hits,
                pairs,
                current: [CurrentRay::NONE; DESCENTS],
            };
            self.triangles
                .along::<S, _, true>(simd, rays.count, &mut asker, descents);
            for pairs in pairs.chunks(LANES) {
                self.meet_pairs(simd, rays, pairs, hits);
            }
        }
    }

    /// Begins with the planes.
    #[inline(always)]
    fn meet_planes<S: Simd>(&self, simd: S, rays: &RayBatch, hits: &mut Hits) {
        for packet in 0..rays.count.div_ceil(LANES) {
            let lanes = packet * LANES..(packet + 1) * LANES;
            let packet_of_rays = Rays::new(
                DVec3x16::load(simd, columns(&rays.origin, packet)),
                DVec3x16::load(simd, columns(&rays.direction, packet)),
                None,
            );
            let mut nearest = NearestHit::new(simd, first_lanes(rays.count, packet));
            for plane in self.world.planes() {
                plane::intersect(simd, plane, &packet_of_rays, &mut nearest);
            }
            nearest.t.store(&mut hits.t[lanes.clone()]);
            hits.primitive[lanes].copy_from_slice(&nearest.primitive.to_array());
        }
    }

    /// Puts at most sixteen pairs to f64.
    #[inline(never)]
    fn meet_pairs<S: Simd>(&self, simd: S, rays: &RayBatch, pairs: &[Pair], hits: &mut Hits) {
        simd.vectorize(
            #[inline(always)]
            || {
                let origin = gathered(simd, &rays.origin, pairs);
                let direction = gathered(simd, &rays.direction, pairs);
                let packet = ShearedRays::new(Rays::new(origin, direction, None));
                let (facets, primitives) = self.facets(simd, pairs);
                let (found, t) = facets.intersect(simd, &packet);
                let t = t.to_array();
                for lane in ones(found.to_bits()) {
                    let ray = pairs[lane].ray as usize;
                    hits.offer(ray, t[lane], Primitive(primitives[lane]));
                }
            },
        );
    }

    /// The triangles of at most sixteen pairs.
    #[inline(always)]
    fn facets<S: Simd>(&self, simd: S, pairs: &[Pair]) -> (TrianglePerRay<S>, [u64; LANES]) {
        let asked = first_lanes(pairs.len(), 0);
        let mut primitives = [u64::MAX; LANES];
        for (primitive, pair) in primitives.iter_mut().zip(pairs) {
            *primitive = self.triangles.get(pair.triangle).primitive().0;
        }
        let corners = side_by_side(
            simd,
            asked,
            #[inline(always)]
            |lane| self.triangles.get(pairs[lane].triangle).vertices(),
        );
        let facets = TrianglePerRay {
            corners,
            primitive: U64x16::load(simd, &primitives),
            asked,
        };
        (facets, primitives)
    }

    #[inline(always)]
    fn free_all<S: Simd>(
        &self,
        simd: S,
        segments: &SegmentBatch,
        space: &mut Candidates,
    ) -> [u32; PACKETS] {
        let Candidates { descents, pairs } = space;
        pairs.clear();
        let mut free = self.free_of_planes(simd, segments);
        if !self.spheres.is_empty() {
            let mut asker = SegmentSpheres {
                segments,
                free: &mut free,
                current: [0; DESCENTS],
            };
            self.spheres
                .along::<S, _, false>(simd, segments.count, &mut asker, descents);
        }
        if !self.triangles.is_empty() {
            let mut asker = SegmentTriangles {
                shapes: self,
                segments,
                free: &mut free,
                pairs,
                current: [CurrentRay::NONE; DESCENTS],
            };
            self.triangles
                .along::<S, _, false>(simd, segments.count, &mut asker, descents);
            for pairs in pairs.chunks(LANES) {
                for lane in ones(self.hidden_pairs(simd, segments, pairs)) {
                    hide(&mut free, pairs[lane].ray as usize);
                }
            }
        }
        free
    }

    #[inline(always)]
    fn free_of_planes<S: Simd>(&self, simd: S, segments: &SegmentBatch) -> [u32; PACKETS] {
        let mut free = [0; PACKETS];
        for packet in 0..segments.count.div_ceil(LANES) {
            free[packet] = first_lanes(segments.count, packet);
            if self.world.planes().is_empty() {
                continue;
            }
            let (start, end) = (
                segments.start.packet(simd, packet),
                segments.end.packet(simd, packet),
            );
            for plane in self.world.planes() {
                free[packet] &= !plane::is_between(simd, plane, &start, &end).to_bits();
            }
        }
        free
    }

    /// Puts at most sixteen pairs to f64; one bit for each whose triangle stands in the way.
    #[inline(never)]
    fn hidden_pairs<S: Simd>(&self, simd: S, segments: &SegmentBatch, pairs: &[Pair]) -> u32 {
        simd.vectorize(
            #[inline(always)]
            || {
                let start = segments.start.gathered(simd, pairs);
                let end = segments.end.gathered(simd, pairs);
                let direction = end.position - start.position;
                let packet = ShearedRays::new(Rays::new(start.position, direction, None));
                let (facets, _) = self.facets(simd, pairs);
                facets.occlude(simd, &packet, &start, &end).to_bits()
            },
        )
    }
}
