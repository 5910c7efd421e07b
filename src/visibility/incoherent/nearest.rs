//! L2: what rays meet first.

use fearless_simd::Simd;

use super::batch::Hits;
use super::candidates::{Candidates, CurrentRay, Pair};
use super::leave;
use crate::math::DVec3;
use crate::simd::{DVec3x16, LANES, ones};
use crate::visibility::batch::first_lanes;
use crate::visibility::primitive::Primitive;
use crate::visibility::question::NearestHit;
use crate::visibility::ray_batch::IncoherentRays;
use crate::visibility::rays::{Rays, ShearedRays};
use crate::visibility::search::{Along, AlongInPackets, AskedPacket, Way};
use crate::visibility::shape::{Block, Sphere, SphereBlock, Triangle, TriangleBlock, disk, plane};
use crate::visibility::shapes::Shapes;
use crate::world::geometry::area_vector;

/// L2 for spheres.
struct NearestSpheres<'b> {
    rays: &'b IncoherentRays,
    hits: &'b mut Hits,
    current: [usize; LANES],
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
        let [origin, direction] = self.rays.ray(ray);
        let lanes = Rays::new(
            DVec3x16::splat(simd, origin),
            DVec3x16::splat(simd, direction),
            None,
        );
        let met = match self.rays.start(ray) {
            Some(start) => {
                let own = Primitive(start.primitive);
                block.first_met_after(simd, &lanes, &start.lanes(simd), own, bits)
            }
            None => block.first_met(simd, &lanes, bits),
        };
        if let Some((found, t)) = met {
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

impl<S: Simd> AlongInPackets<S, Sphere> for NearestSpheres<'_> {
    #[inline(always)]
    fn show_shape(&mut self, simd: S, packet: &AskedPacket<'_, S>, sphere: &Sphere) {
        let rays = &packet.rays.rays;
        let met = match &packet.starts {
            Some(starts) => sphere.first_met_after(simd, rays, starts, packet.asked),
            None => sphere.first_met(simd, rays, packet.asked),
        };
        if let Some((found, t)) = met {
            let t = t.to_array();
            for lane in ones(found.to_bits()) {
                self.hits
                    .offer(packet.first + lane, t[lane], sphere.primitive());
            }
        }
    }

    #[inline(always)]
    fn limit(&self, place: usize) -> f64 {
        self.hits.t[self.current[place]]
    }
}

/// L2 for triangles: their candidates.
struct NearestTriangles<'b, 'w> {
    shapes: &'b Shapes<'w>,
    rays: &'b IncoherentRays,
    hits: &'b mut Hits,
    pairs: &'b mut Vec<Pair>,
    current: [CurrentRay; LANES],
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
        let start = self.rays.start(*ray);
        let first = start.as_ref().map_or(0.0, |start| start.t);
        for place in ones(met.maybe) {
            let [least, most] = reach.of(place);
            if most < first || least > *limit {
                continue;
            }
            if list.len == LANES {
                list.keep_up_to(*limit);
            }
            if list.len == LANES {
                let pairs = list.all_pairs(*ray);
                self.shapes.meet_pairs(simd, self.rays, &pairs, self.hits);
                list.len = 0;
                *limit = limit.min(self.hits.t[*ray]);
            }
            list.push(least, block.number(place));
            let is_own = start.is_some_and(|start| start.primitive == block.primitive(place).0);
            if met.surely >> place & 1 == 1 && least > first && most < *limit && !is_own {
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

impl<S: Simd> AlongInPackets<S, Triangle> for NearestTriangles<'_, '_> {
    #[inline(always)]
    fn show_shape(&mut self, simd: S, packet: &AskedPacket<'_, S>, triangle: &Triangle) {
        let met = triangle.met_by(simd, &packet.rays, packet.bits, packet.asked);
        let Some((found, t)) = met else {
            return;
        };
        let t = t.to_array();
        for lane in ones(found.to_bits()) {
            let ray = packet.first + lane;
            if let Some(start) = self.rays.start(ray) {
                let vertices = triangle.vertices();
                let normal = area_vector(vertices);
                if !leave::flat(&start, t[lane], triangle.primitive(), vertices[0], normal) {
                    continue;
                }
            }
            self.hits.offer(ray, t[lane], triangle.primitive());
            let limit = &mut self.current[lane].limit;
            *limit = limit.min(t[lane]);
        }
    }

    #[inline(always)]
    fn limit(&self, place: usize) -> f64 {
        self.current[place].limit
    }
}

impl Shapes<'_> {
    #[inline(always)]
    pub(super) fn nearest_all<S: Simd>(
        &self,
        simd: S,
        rays: &IncoherentRays,
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
                current: [0; LANES],
            };
            self.spheres
                .along_in_packets(simd, rays, &mut asker, descents);
        }
        if !self.triangles.is_empty() {
            let mut asker = NearestTriangles {
                shapes: self,
                rays,
                hits,
                pairs,
                current: [CurrentRay::NONE; LANES],
            };
            self.triangles
                .along_in_packets(simd, rays, &mut asker, descents);
            for pairs in pairs.chunks(LANES) {
                self.meet_pairs(simd, rays, pairs, hits);
            }
        }
    }

    /// Begins with the planes and disks.
    #[inline(always)]
    fn meet_planes<S: Simd>(&self, simd: S, rays: &IncoherentRays, hits: &mut Hits) {
        for packet in 0..rays.count().div_ceil(LANES) {
            let lanes = packet * LANES..(packet + 1) * LANES;
            let packet_of_rays = rays.packet(simd, packet);
            let mut nearest = NearestHit::new(simd, first_lanes(rays.count(), packet));
            if rays.start(0).is_some() {
                self.meet_planes_from(simd, rays, packet, hits);
                continue;
            }
            for plane in self.world.planes() {
                plane::intersect(simd, plane, &packet_of_rays, &mut nearest);
            }
            for disk in self.world.disks() {
                disk::intersect(simd, disk, &packet_of_rays, &mut nearest);
            }
            nearest.t.store(&mut hits.t[lanes.clone()]);
            hits.primitive[lanes].copy_from_slice(&nearest.primitive.to_array());
        }
    }

    /// The same for rays of a packet that leave surfaces.
    #[inline(always)]
    fn meet_planes_from<S: Simd>(
        &self,
        simd: S,
        rays: &IncoherentRays,
        packet: usize,
        hits: &mut Hits,
    ) {
        let lanes = packet * LANES..(packet + 1) * LANES;
        hits.t[lanes.clone()].fill(f64::INFINITY);
        hits.primitive[lanes].fill(u64::MAX);
        let asked = first_lanes(rays.count(), packet);
        let packet_of_rays = rays.packet(simd, packet);
        let mut offer = |found: NearestHit<S>, object: u32, point: DVec3, normal: DVec3| {
            let t = found.t.to_array();
            for lane in ones(asked) {
                let ray = packet * LANES + lane;
                let primitive = Primitive::whole(object);
                if t[lane] < f64::INFINITY
                    && let Some(start) = rays.start(ray)
                    && leave::flat(&start, t[lane], primitive, point, normal)
                {
                    hits.offer(ray, t[lane], primitive);
                }
            }
        };
        for plane in self.world.planes() {
            let mut found = NearestHit::new(simd, asked);
            plane::intersect(simd, plane, &packet_of_rays, &mut found);
            offer(found, plane.object, plane.point.0, plane.normal.get());
        }
        for disk in self.world.disks() {
            let mut found = NearestHit::new(simd, asked);
            disk::intersect(simd, disk, &packet_of_rays, &mut found);
            offer(found, disk.object, disk.center.0, disk.normal.get());
        }
    }

    /// Puts at most sixteen pairs to f64.
    #[inline(never)]
    fn meet_pairs<S: Simd>(&self, simd: S, rays: &IncoherentRays, pairs: &[Pair], hits: &mut Hits) {
        simd.vectorize(
            #[inline(always)]
            || {
                let packet = ShearedRays::new(rays.gathered(simd, pairs));
                let (triangles, primitives) = self.triangles_of(simd, pairs);
                let (found, t) = triangles.intersect(simd, &packet);
                let t = t.to_array();
                for lane in ones(found.to_bits()) {
                    let ray = pairs[lane].ray as usize;
                    let primitive = Primitive(primitives[lane]);
                    if let Some(start) = rays.start(ray) {
                        let vertices = self.triangles.get(pairs[lane].triangle).vertices();
                        let normal = area_vector(vertices);
                        if !leave::flat(&start, t[lane], primitive, vertices[0], normal) {
                            continue;
                        }
                    }
                    hits.offer(ray, t[lane], primitive);
                }
            },
        );
    }
}
