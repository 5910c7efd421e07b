//! The normals of smooth meshes between their vertices.

use fearless_simd::Simd;

use super::Points;
use super::unit::unit;
use crate::math::{DVec3, Normal, all_three};
use crate::simd::{DVec3x16, F64x16, LANES, Mask64x16, ones};
use crate::visibility::batch::{columns, columns_mut};
use crate::visibility::primitive::Primitive;
use crate::visibility::rays::Rays;
use crate::visibility::shape::{edge, side_by_side};
use crate::world::geometry::MeshNormals;
use crate::world::{Shape, World};

impl Points {
    /// Puts interpolated normals where the rays of a packet hit a smooth mesh, on the side of the
    /// geometric normal: Σ wᵢ nᵢ at unit length, with the barycentric coordinates wᵢ of the hit. Where
    /// the vertex normals cancel each other, the geometric normal stays.
    #[inline(never)]
    pub(super) fn interpolate<S: Simd>(
        &mut self,
        simd: S,
        world: &World,
        packet: usize,
        rays: &Rays<S>,
    ) {
        simd.vectorize(
            #[inline(always)]
            || self.interpolate_all(simd, world, packet, rays),
        );
    }

    #[inline(always)]
    fn interpolate_all<S: Simd>(&mut self, simd: S, world: &World, packet: usize, rays: &Rays<S>) {
        let lanes = packet * LANES..(packet + 1) * LANES;
        let smooth = Smooth::of(world, &self.primitive[lanes.clone()], self.hit[packet]);
        if smooth.bits == 0 {
            return;
        }
        let corners = side_by_side(
            simd,
            smooth.bits,
            #[inline(always)]
            |lane| world.triangles().vertices(smooth.triangle[lane]),
        );
        let normals = side_by_side(
            simd,
            smooth.bits,
            #[inline(always)]
            |lane| all_three(smooth.normals(world, lane), Normal::get),
        );
        let geometric = DVec3x16::load(simd, columns(&self.geometric_normal, packet));
        let weights = weights(corners, rays);
        let between = between(simd, smooth.bits, weights, normals, geometric);
        let normal = between.normal;
        normal.store(columns_mut(&mut self.shading_normal, packet));
        let to_viewer = DVec3x16::load(simd, columns(&self.to_viewer, packet));
        let cos_viewer = &mut self.cos_viewer[lanes];
        normal.dot(to_viewer).store(cos_viewer);
        if smooth.lifts {
            let bits = smooth.lifted(world, &self.primitive[packet * LANES..]);
            let outwards = [
                between.on_its_side(normals[0]),
                between.on_its_side(normals[1]),
                between.on_its_side(normals[2]),
            ];
            let bits = bits & between.has_direction.to_bits();
            self.lift(simd, packet, bits, &corners, &outwards, &weights);
        }
    }
}

/// The triangles of smooth meshes among those that the rays of a packet hit.
struct Smooth<'w> {
    /// One bit for each ray that hits one.
    bits: u32,
    /// Whether shadow rays start off some of them.
    lifts: bool,
    triangle: [u32; LANES],
    /// The normals of its mesh, and the mesh's first triangle.
    mesh: [Option<(&'w MeshNormals, u32)>; LANES],
}

impl<'w> Smooth<'w> {
    fn of(world: &'w World, primitives: &[u64], hit: u32) -> Self {
        let mut smooth = Self {
            bits: 0,
            lifts: false,
            triangle: [0; LANES],
            mesh: [None; LANES],
        };
        // Neighbors mostly hit the same object.
        let (mut known, mut mesh) = (u32::MAX, None);
        for lane in ones(hit) {
            let (object, triangle) = Primitive(primitives[lane]).parts();
            if object != known {
                known = object;
                mesh = match world.objects()[object as usize].shape {
                    Shape::Mesh(index) => {
                        let mesh = &world.triangles().meshes()[index];
                        smooth.lifts |= mesh.lifts_shadow_rays();
                        let normals = mesh.normals.as_ref();
                        normals.map(|normals| (normals, mesh.triangles.start))
                    }
                    Shape::Sphere(_) | Shape::Plane(_) | Shape::Disk(_) => None,
                };
            }
            smooth.bits |= u32::from(mesh.is_some()) << lane;
            smooth.triangle[lane] = triangle;
            smooth.mesh[lane] = mesh;
        }
        smooth
    }

    /// One bit for each ray that hits a triangle which shadow rays start off.
    fn lifted(&self, world: &World, primitives: &[u64]) -> u32 {
        let mut lifted = 0;
        for lane in ones(self.bits) {
            let (object, _) = Primitive(primitives[lane]).parts();
            if let Shape::Mesh(index) = world.objects()[object as usize].shape {
                let lifts = world.triangles().meshes()[index].lifts_shadow_rays();
                lifted |= u32::from(lifts) << lane;
            }
        }
        lifted
    }

    /// The vertex normals of the triangle that a ray with a bit hits.
    #[inline(always)]
    fn normals(&self, world: &World, lane: usize) -> [Normal; 3] {
        let (normals, first) = self.mesh[lane].expect("a lane with a bit has a mesh");
        let triangles = world.triangles();
        triangles.normals_at(normals, first, self.triangle[lane])
    }
}

/// Barycentric coordinates, of corner after corner, where rays hit triangles, each its own: the edge
/// functions that also say that it is hit, in proportion to their sum.
#[inline(always)]
fn weights<S: Simd>(corners: [DVec3x16<S>; 3], rays: &Rays<S>) -> [F64x16<S>; 3] {
    let d = rays.direction;
    let [x, y, z] = [d.x.abs(), d.y.abs(), d.z.abs()];
    // The axis that a ray runs along becomes its last.
    let is_x = x.ge(y) & x.ge(z);
    let is_y = y.ge(z);
    let d = turned(d, is_x, is_y);
    let slopes = [d.x / d.z, d.y / d.z];
    let [a, b, c] = corners;
    let a = sheared(turned(a - rays.origin, is_x, is_y), slopes);
    let b = sheared(turned(b - rays.origin, is_x, is_y), slopes);
    let c = sheared(turned(c - rays.origin, is_x, is_y), slopes);
    let [u, v, w] = [edge(b, c), edge(c, a), edge(a, b)];
    let sum = u + v + w;
    [u / sum, v / sum, w / sum]
}

/// The components in cyclic order, so that x comes last, or else y; elsewhere as they are.
#[inline(always)]
fn turned<S: Simd>(v: DVec3x16<S>, is_x: Mask64x16<S>, is_y: Mask64x16<S>) -> DVec3x16<S> {
    DVec3x16 {
        x: is_x.select(v.y, is_y.select(v.z, v.x)),
        y: is_x.select(v.z, is_y.select(v.x, v.y)),
        z: is_x.select(v.x, is_y.select(v.y, v.z)),
    }
}

/// Where a point is as seen along rays that start at 0 and have these slopes over z.
#[inline(always)]
fn sheared<S: Simd>(point: DVec3x16<S>, slopes: [F64x16<S>; 2]) -> [F64x16<S>; 2] {
    [point.x - slopes[0] * point.z, point.y - slopes[1] * point.z]
}

/// What vertex normals come to.
struct Between<S: Simd> {
    /// On the side of the geometric normal.
    normal: DVec3x16<S>,
    /// Where the vertex normals are on the other side.
    is_turned: Mask64x16<S>,
    /// Where they do not cancel each other.
    has_direction: Mask64x16<S>,
}

impl<S: Simd> Between<S> {
    /// Vertex normals, turned as their sum is.
    #[inline(always)]
    fn on_its_side(&self, normals: DVec3x16<S>) -> DVec3x16<S> {
        self.is_turned.select_vectors(-normals, normals)
    }
}

/// Σ wᵢ nᵢ at unit length and on the side of the geometric normals, for the rays with a bit; the
/// geometric normals for the others, and where the sum has no direction.
#[inline(always)]
fn between<S: Simd>(
    simd: S,
    bits: u32,
    weights: [F64x16<S>; 3],
    normals: [DVec3x16<S>; 3],
    geometric: DVec3x16<S>,
) -> Between<S> {
    let [u, v, w] = weights;
    let [a, b, c] = normals;
    // From 0 on, so that no sum of zeros is −0.
    let zero = DVec3x16::splat(simd, DVec3::ZERO);
    let sum = zero + a.times(u) + b.times(v) + c.times(w);
    let square = sum.dot(sum);
    let normal = unit(simd, sum, square, square.inverse_root(simd), bits);
    let has_direction = normal.dot(normal).is_positive();
    let is_turned = normal.dot(geometric).lt(F64x16::splat(simd, 0.0));
    let normal = is_turned.select_vectors(-normal, normal);
    let is_smooth = Mask64x16::from_bits(simd, bits) & has_direction;
    Between {
        normal: is_smooth.select_vectors(normal, geometric),
        is_turned,
        has_direction,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::{Kernel, SimdLevel};

    /// A ray that hits a triangle.
    #[derive(Clone, Copy, Debug)]
    struct Hit {
        origin: DVec3,
        direction: DVec3,
        corners: [DVec3; 3],
        normals: [DVec3; 3],
        geometric: DVec3,
    }

    impl Hit {
        /// Barycentric coordinates by Woop, Benthin & Wald 2013, one ray at a time.
        fn weights(&self) -> [f64; 3] {
            let d = self.direction;
            let size = d.abs();
            let [u, v, w] = if size.x >= size.y && size.x >= size.z {
                [1, 2, 0]
            } else if size.y >= size.z {
                [2, 0, 1]
            } else {
                [0, 1, 2]
            };
            let slopes = [d[u] / d[w], d[v] / d[w]];
            let [a, b, c] = self.corners.map(|corner| {
                let from = corner - self.origin;
                [from[u] - slopes[0] * from[w], from[v] - slopes[1] * from[w]]
            });
            let edge = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - q[0] * p[1];
            let functions = [edge(b, c), edge(c, a), edge(a, b)];
            let sum: f64 = functions.iter().sum();
            functions.map(|function| function / sum)
        }

        /// The same as [`between`], one ray at a time.
        fn normal(&self) -> DVec3 {
            let [u, v, w] = self.weights();
            let [a, b, c] = self.normals;
            match Normal::new(DVec3::ZERO + a * u + b * v + c * w).map(Normal::get) {
                Some(normal) if normal.dot(self.geometric) < 0.0 => -normal,
                Some(normal) => normal,
                None => self.geometric,
            }
        }
    }

    struct Between<'h>(&'h [Hit; LANES], u32);

    impl Kernel for Between<'_> {
        type Output = [DVec3; LANES];

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            let Self(hits, bits) = self;
            let load = |vector: &dyn Fn(&Hit) -> DVec3| {
                let axes = [0, 1, 2].map(|axis| hits.each_ref().map(|hit| vector(hit)[axis]));
                let [x, y, z] = &axes;
                DVec3x16::load(simd, [x, y, z])
            };
            let rays = Rays::new(load(&|hit| hit.origin), load(&|hit| hit.direction), None);
            let corners = [0, 1, 2].map(|corner: usize| load(&|hit| hit.corners[corner]));
            let normals = [0, 1, 2].map(|corner: usize| load(&|hit| hit.normals[corner]));
            let geometric = load(&|hit| hit.geometric);
            let weights = weights(corners, &rays);
            let found = between(simd, bits, weights, normals, geometric).normal;
            let [x, y, z] = [found.x.to_array(), found.y.to_array(), found.z.to_array()];
            std::array::from_fn(|lane| DVec3::new(x[lane], y[lane], z[lane]))
        }
    }

    /// A number from −1 to 1 without order: multiples of irrational ones.
    fn scattered(index: u32, dimension: u32) -> f64 {
        let step = f64::from(dimension * 2 + 3).sqrt();
        ((f64::from(index) + 1.0) * step).fract() * 2.0 - 1.0
    }

    fn scattered_vector(index: u32, dimension: u32) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|axis| scattered(index, dimension + axis)))
    }

    /// A ray through the inside of a triangle, in a scene of some size.
    fn any_hit(index: u32, size: f64) -> Hit {
        let corners = [0, 3, 6].map(|dimension| scattered_vector(index, dimension));
        let [u, v] = [9, 10].map(|dimension| scattered(index, dimension).abs() * 0.5);
        let hit = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
        let origin = scattered_vector(index, 11) * 3.0;
        let normals = [14, 17, 20].map(|dimension| scattered_vector(index, dimension).normalize());
        Hit {
            origin: origin * size,
            direction: (hit - origin) * size,
            corners: corners.map(|corner| corner * size),
            normals,
            geometric: (corners[1] - corners[0])
                .cross(corners[2] - corners[0])
                .normalize(),
        }
    }

    /// Every instruction set gives the bits that one ray at a time has.
    #[track_caller]
    fn agrees(hits: &[Hit; LANES], bits: u32) {
        for (name, level) in SimdLevel::available() {
            let found = level.run(Between(hits, bits));
            for (lane, (hit, found)) in hits.iter().zip(found).enumerate() {
                let is_smooth = bits >> lane & 1 == 1;
                let expected = if is_smooth {
                    hit.normal()
                } else {
                    hit.geometric
                };
                let to_bits = |vector: DVec3| vector.to_array().map(f64::to_bits);
                assert_eq!(to_bits(found), to_bits(expected), "{name} {lane} {hit:?}");
            }
        }
    }

    #[test]
    fn the_same_bits_as_one_ray_at_a_time() {
        for size in [1.0, 1e-9, 1e-30, 1e30] {
            for packet in 0..200 {
                let hits = std::array::from_fn(|lane| any_hit(packet * 16 + lane as u32, size));
                agrees(&hits, scattered(packet, 30).to_bits() as u32 & 0xffff);
                agrees(&hits, 0xffff);
            }
        }
    }

    /// Rays along axes and diagonals, through corners and edges; normals that cancel each other, nearly
    /// or beyond f64; triangles whose edge functions are 0 or overflow.
    #[test]
    fn hard_cases_have_the_same_bits() {
        let plain = Hit {
            origin: DVec3::Z,
            direction: -DVec3::Z,
            corners: [-DVec3::X - DVec3::Y, DVec3::X, DVec3::Y],
            normals: [DVec3::X, DVec3::Y, DVec3::Z],
            geometric: DVec3::Z,
        };
        let [a, b, c] = plain.corners;
        let to = |point: DVec3| Hit {
            direction: point - plain.origin,
            ..plain
        };
        let tiny = DVec3::splat(1e-200);
        let along = |direction: DVec3| Hit {
            origin: -direction,
            direction,
            corners: [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| axis - direction * 1e-3),
            ..plain
        };
        let with = |normals: [DVec3; 3]| Hit {
            normals,
            ..to(a * 0.5 + b * 0.5)
        };
        let hits = [
            plain,
            to(a),
            to(b * 0.5 + c * 0.5),
            along(DVec3::X + DVec3::Y),
            along(DVec3::Y + DVec3::Z),
            along(DVec3::ONE),
            along(-DVec3::Y),
            // The two ends of an edge point in opposite ways: no direction in its middle, or hardly one.
            with([DVec3::X, -DVec3::X, DVec3::Z]),
            with([DVec3::X, -DVec3::X + tiny, DVec3::Z]),
            with([DVec3::X + DVec3::Y * 1e-17, -DVec3::X, DVec3::Z]),
            with([DVec3::X, DVec3::X, -DVec3::X]),
            // On the other side.
            with([-DVec3::Z, -DVec3::Z, DVec3::X]),
            with([-DVec3::X, DVec3::Y, -DVec3::Z]),
            // Without extent, and beyond f64.
            Hit {
                corners: [DVec3::ZERO; 3],
                ..plain
            },
            Hit {
                corners: plain.corners.map(|corner| corner * 1e200),
                ..plain
            },
            Hit {
                corners: plain.corners.map(|corner| corner * 1e-170),
                ..plain
            },
        ];
        agrees(&hits, 0xffff);
        assert_eq!(hits[7].normal(), DVec3::Z, "normals that cancel each other");
        assert_eq!(hits[13].normal(), DVec3::Z, "a triangle without extent");
        assert_eq!(hits[1].normal(), DVec3::X, "at a corner");
    }
}
