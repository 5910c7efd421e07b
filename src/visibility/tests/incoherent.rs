//! Rays and segments that share nothing against all shapes one by one, without a tree and without f32.

use super::*;
use crate::simd::{DVec3x16, Mask64x16, U64x16};
use crate::visibility::batch::BATCH;
use crate::visibility::incoherent::{EndBatch, IncoherentSegments};
use crate::visibility::primitive::Primitive;
use crate::visibility::question::{End, NearestHit, SegmentEnds};
use crate::visibility::rays::{ROUNDING, Rays, ShearedRays};
use crate::visibility::shape::{
    Block as _, Shape as _, Sphere, SphereBlock, Triangle, TrianglePerRay, disk, plane,
};
use crate::visibility::shapes::SegmentStarts;

/// A ray o + t ω.
pub(super) type Ray = [DVec3; 2];

/// The world of a writer's scene.
pub(super) fn world_of(writer: &Writer) -> World {
    let text = format!("{}{}", writer.text, writer.cameras[0]);
    let mut scene = Scene::parse(&text, "test.toml").unwrap_or_else(|e| panic!("{e}"));
    lifted::add_meshes(&mut scene, &writer.meshes);
    let (mut world, _) = World::new(&scene).unwrap_or_else(|e| panic!("{e}"));
    writer.add_disks(&mut world);
    world
}

/// All shapes of a world in the order of their kinds.
pub(super) struct Everything<'w> {
    pub(super) world: &'w World,
    pub(super) spheres: Vec<Sphere>,
    pub(super) triangles: Vec<Triangle>,
}

impl<'w> Everything<'w> {
    pub(super) fn new(world: &'w World) -> Self {
        let triangles = world.triangles();
        let triangle = |index| {
            let primitive = Primitive::triangle(triangles.mesh(index).object, index);
            Triangle::new(primitive, triangles.vertices(index))
        };
        let spheres = world.spheres().iter();
        Self {
            world,
            spheres: spheres.map(Sphere::new).collect(),
            triangles: (0..triangles.len() as u32).map(triangle).collect(),
        }
    }

    /// A point of some triangle, sphere or disk, its error and its primitive.
    pub(super) fn on_surface(&self, index: u32) -> (DVec3, f64, u64) {
        let solid = self.spheres.len() + self.triangles.len();
        let count = solid + self.world.disks().len();
        let which = (scattered(index, 40) * count as f64) as usize;
        let [u, v, w] = [41, 42, 43].map(|dimension| scattered(index, dimension));
        let (position, size, primitive) = if which >= solid {
            let disk = &self.world.disks()[which - solid];
            let (a, b) = disk.normal.get().any_orthonormal_pair();
            // Some on the rim.
            let (sine, cosine) = (v * std::f64::consts::TAU).sin_cos();
            let out = (u * 1.2).min(1.0).sqrt() * disk.radius;
            let size = disk.center.0.abs().element_sum() + disk.radius;
            let position = disk.center.0 + (a * cosine + b * sine) * out;
            (position, size, Primitive::whole(disk.object))
        } else if which < self.spheres.len() {
            let (center, radius) = self.spheres[which].center_and_radius();
            let out = DVec3::new(u - 0.5, v - 0.5, w - 0.5).normalize();
            let size = center.abs().element_sum() + radius;
            (center + out * radius, size, self.spheres[which].primitive())
        } else {
            let triangle = &self.triangles[which - self.spheres.len()];
            let [a, b, c] = triangle.vertices();
            let (u, v) = if u + v > 1.0 {
                (1.0 - u, 1.0 - v)
            } else {
                (u, v)
            };
            let size = a.abs().element_sum() + b.abs().element_sum() + c.abs().element_sum();
            (a + (b - a) * u + (c - a) * v, size, triangle.primitive())
        };
        (position, size * ROUNDING, primitive.0)
    }

    /// Some point of an edge, or a corner.
    fn on_edge(&self, index: u32) -> Option<DVec3> {
        let count = self.triangles.len();
        let which = (scattered(index, 44) * count as f64) as usize;
        let [a, b, _] = self.triangles.get(which)?.vertices();
        Some(match index % 3 {
            0 => a,
            1 => a * 0.5 + b * 0.5,
            _ => a + (b - a) * scattered(index, 45),
        })
    }
}

/// The same rays, as if they shared nothing.
pub(super) fn separate<S: Simd>(
    simd: S,
    rays: &RayBatch<'_, impl Fn(usize) -> DVec3x16<S>>,
) -> IncoherentRays {
    let mut separate = IncoherentRays::default();
    for packet in 0..PACKETS {
        let rays = rays.packet(simd, packet);
        for lane in 0..LANES {
            separate.push(rays.origin.lane(lane), rays.direction.lane(lane));
        }
    }
    separate
}

/// The nearest hit of each of some rays among all shapes.
struct BruteForce<'a>(&'a Everything<'a>, &'a [Ray]);

impl Kernel for BruteForce<'_> {
    type Output = Vec<(f64, u64)>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let Self(all, rays) = self;
        let mut found = Vec::new();
        for rays in rays.chunks(LANES) {
            let packet = ShearedRays::new(lanes_of(simd, rays));
            let mut nearest = NearestHit::new(simd, (1 << rays.len()) - 1);
            for plane in all.world.planes() {
                plane::intersect(simd, plane, &packet.rays, &mut nearest);
            }
            for disk in all.world.disks() {
                disk::intersect(simd, disk, &packet.rays, &mut nearest);
            }
            for sphere in &all.spheres {
                sphere.intersect(simd, &packet, &mut nearest);
            }
            for triangle in &all.triangles {
                triangle.intersect(simd, &packet, &mut nearest);
            }
            let (t, primitive) = (nearest.t.to_array(), nearest.primitive.to_array());
            found.extend((0..rays.len()).map(|lane| (t[lane], primitive[lane])));
        }
        found
    }
}

/// Sixteen rays or fewer.
#[inline(always)]
pub(super) fn lanes_of<S: Simd>(simd: S, rays: &[Ray]) -> Rays<S> {
    let vectors = |part: usize| {
        let column = |axis: usize| {
            let mut numbers = [1.0; LANES];
            for (number, ray) in numbers.iter_mut().zip(rays) {
                *number = ray[part][axis];
            }
            numbers
        };
        let [x, y, z] = [column(0), column(1), column(2)];
        DVec3x16::load(simd, [&x, &y, &z])
    };
    Rays::new(vectors(0), vectors(1), None)
}

/// The same by the trees.
pub(super) struct Traced<'a>(pub(super) &'a Visibility<'a>, pub(super) &'a [Ray]);

impl Kernel for Traced<'_> {
    type Output = Vec<(f64, u64)>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let Self(visibility, rays) = self;
        let mut batch = IncoherentRays::default();
        let mut space = Workspace::default();
        let mut found = Vec::new();
        for rays in rays.chunks(BATCH) {
            batch.clear();
            for &[origin, direction] in rays {
                batch.push(origin, direction);
            }
            let hits = visibility.hits(simd, &batch, &mut space);
            found.extend((0..rays.len()).map(|ray| (hits.t[ray], hits.primitive[ray])));
        }
        found
    }
}

/// Rays without order in and around a world within `size` of the origin: from anywhere, from surfaces and from far
/// away; anywhere, along axes, across them, and through edges and corners; with ways of all lengths.
pub(super) fn bundle(all: &Everything<'_>, size: f64, count: u32) -> Vec<Ray> {
    let vector = |index, dimension: u32| {
        DVec3::from_array([0, 1, 2].map(|axis| scattered(index, dimension + axis) * 2.0 - 1.0))
    };
    let ray = |index: u32| {
        let origin = match index % 5 {
            0 | 1 => vector(index, 0) * size * 1.5,
            2 => all.on_surface(index).0,
            3 => vector(index, 0) * size * 10_f64.powf(6.0 * scattered(index, 9)),
            _ => all.on_edge(index).unwrap_or(DVec3::ZERO),
        };
        let towards = vector(index, 3) * size - origin;
        let mut direction = match index % 7 {
            0 | 1 => vector(index, 6),
            2 | 3 => towards,
            4 => all.on_edge(index + 1).unwrap_or(DVec3::ZERO) - origin,
            5 => {
                DVec3::AXES[(index / 7) as usize % 3]
                    * if index.is_multiple_of(2) { 1.0 } else { -1.0 }
            }
            _ => vector(index, 6).with_y(if index.is_multiple_of(2) { 0.0 } else { 1e-310 }),
        };
        if index.is_multiple_of(11) {
            direction *= 10_f64.powf(200.0 * scattered(index, 10) - 100.0);
        }
        if direction == DVec3::ZERO {
            direction = DVec3::ONE;
        }
        [origin, direction]
    };
    (0..count).map(ray).collect()
}

/// Traces a bundle on every instruction set and compares it with all shapes one by one, to the bit; the part of
/// all rays that hit something.
#[track_caller]
pub(super) fn agrees_with_brute_force(world: &World, size: f64, count: u32) -> f64 {
    let visibility = Visibility::new(world, &Plan::new(world));
    agree_with_brute_force(&visibility, size, count)
}

#[track_caller]
pub(super) fn agree_with_brute_force(visibility: &Visibility<'_>, size: f64, count: u32) -> f64 {
    let all = Everything::new(visibility.shapes.world);
    agree_with_rays(visibility, &bundle(&all, size, count))
}

/// The same of any rays.
#[track_caller]
pub(super) fn agree_with_rays(visibility: &Visibility<'_>, rays: &[Ray]) -> f64 {
    let all = Everything::new(visibility.shapes.world);
    let expected = SimdLevel::default().run(BruteForce(&all, rays));
    for (name, level) in SimdLevel::available() {
        let found = level.run(Traced(visibility, rays));
        for ((found, expected), ray) in found.iter().zip(&expected).zip(rays) {
            let bits = |(t, primitive): (f64, u64)| (t.to_bits(), primitive);
            assert_eq!(
                bits(*found),
                bits(*expected),
                "{name} {ray:?} {found:?} {expected:?}"
            );
        }
    }
    let hit = expected.iter().filter(|(t, _)| t.is_finite()).count();
    hit as f64 / rays.len() as f64
}

fn clutter(size: f64, place: [f64; 3], triangles: u32, spheres: u32) -> Writer {
    let mut scene = Writer::new(size, place, 40.0, EYE);
    scene.clutter(triangles, spheres, 0.3);
    scene
}

#[test]
fn rays_meet_what_they_meet_one_by_one() {
    let mut scene = clutter(1.0, [0.0; 3], 300, 100);
    scene.plane([0.0, -1.0, 0.0], [0.1, 1.0, 0.2]);
    let hit = agrees_with_brute_force(&world_of(&scene), 1.0, 40_000);
    assert!(hit > 0.5, "{hit}");
    let hit = agrees_with_brute_force(&world_of(&clutter(1.0, [0.0; 3], 10, 5)), 1.0, 10_000);
    assert!(hit > 0.1, "{hit}");
}

#[test]
fn rays_at_all_scales_and_places() {
    for (size, place) in [
        (1e-6, [0.0; 3]),
        (1e6, [0.0; 3]),
        (1e-30, [0.0; 3]),
        (1e29, [0.0; 3]),
        (1e-3, [100.0, -50.0, 7.0]),
    ] {
        let scene = clutter(size, place, 120, 40);
        let hit = agrees_with_brute_force(&world_of(&scene), size, 8000);
        assert!(hit > 0.2, "{size} {hit}");
    }
    // The scene is far from what it is relative to: only a few digits are left.
    for place in [1e3, 1e6, 1e9] {
        let mut scene = Writer::new(1.0, [0.0; 3], 10.0, [place, place * 0.2, place * 0.5]);
        scene.place = [place, place * 0.2, place * 0.5];
        scene.clutter(120, 40, 0.3);
        let world = world_of(&scene);
        let all = Everything::new(&world);
        let visibility = Visibility::new(&world, &Plan::new(&world));
        let shift = DVec3::new(place, place * 0.2, place * 0.5);
        let mut rays = bundle(&all, 1.0, 4000);
        for ray in rays.iter_mut().filter(|ray| ray[0].length() < place * 0.5) {
            ray[0] += shift;
        }
        let expected = SimdLevel::default().run(BruteForce(&all, &rays));
        assert_eq!(
            SimdLevel::default().run(Traced(&visibility, &rays)),
            expected
        );
        assert!(expected.iter().filter(|(t, _)| t.is_finite()).count() > 500);
    }
}

/// A sphere that is cut into triangles, each corner the same number in all of them.
fn polyhedron(size: f64, place: [f64; 3], cuts: u32) -> Writer {
    let mut scene = Writer::new(size, place, 40.0, EYE);
    let mut faces = Vec::new();
    for signs in 0..8_u32 {
        let sign = |axis: u32| if signs >> axis & 1 == 1 { 1.0 } else { -1.0 };
        faces.push([DVec3::X * sign(0), DVec3::Y * sign(1), DVec3::Z * sign(2)]);
    }
    for _ in 0..cuts {
        let cut = |[a, b, c]: [DVec3; 3]| {
            let middle = |p: DVec3, q: DVec3| (p + q).normalize();
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.into_iter().flat_map(cut).collect();
    }
    for face in faces {
        scene.triangle(face.map(|corner| corner.to_array()));
    }
    scene
}

/// From inside, every ray leaves through the surface: between its triangles there is nothing. Not at edges and
/// not at corners, at any scale and far from the origin.
#[test]
fn closed_meshes_do_not_leak() {
    for (size, place) in [
        (1.0, [0.0; 3]),
        (1e-6, [0.0; 3]),
        (1e6, [1e9, 0.0, -1e9]),
        (1e-3, [10.0; 3]),
    ] {
        let world = world_of(&polyhedron(size, place, 3));
        let all = Everything::new(&world);
        let visibility = Visibility::new(&world, &Plan::new(&world));
        let mut rays = Vec::new();
        for index in 0..6000_u32 {
            let start = DVec3::from_array(
                [0, 1, 2].map(|axis| (scattered(index, axis) - 0.5) * 0.6 * size),
            );
            let corner = all.on_edge(index).unwrap();
            rays.push([start, corner - start]);
            rays.push([DVec3::ZERO, corner]);
        }
        for (name, level) in SimdLevel::available() {
            for (ray, (t, _)) in rays.iter().zip(level.run(Traced(&visibility, &rays))) {
                assert!((t - 1.0).abs() < 0.2, "{name} {size} {ray:?} {t}");
            }
            let segments: Vec<Segment> = rays
                .iter()
                .map(|&[start, way]| {
                    let end = start + way * 1.5;
                    [(start, 0.0, u64::MAX), (end, 0.0, u64::MAX)]
                })
                .collect();
            let free = level.run(FreeSegments(&visibility, &segments));
            assert!(!free.contains(&true), "{name} {size}");
        }
    }
}

/// An end: where, its error, and what it is on.
pub(super) type SegmentEnd = (DVec3, f64, u64);
pub(super) type Segment = [SegmentEnd; 2];

/// Which segments are free, by the trees.
pub(super) struct FreeSegments<'a>(pub(super) &'a Visibility<'a>, pub(super) &'a [Segment]);

impl Kernel for FreeSegments<'_> {
    type Output = Vec<bool>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let Self(visibility, segments) = self;
        let mut batch = IncoherentSegments::default();
        let mut space = Workspace::default();
        let mut free = Vec::new();
        for segments in segments.chunks(BATCH) {
            batch.count = segments.len();
            for (place, segment) in segments.iter().enumerate() {
                let [(start, start_error, start_on), (end, end_error, end_on)] = *segment;
                batch.start.set(place, start, start_error, start_on);
                batch.end.set(place, end, end_error, end_on);
            }
            let bits = visibility.free(simd, SegmentBatch::Any(&batch), &mut space);
            let places = 0..segments.len();
            free.extend(places.map(|place| bits[place / LANES] >> (place % LANES) & 1 == 1));
        }
        free
    }
}

/// Which segments are free, shape by shape.
pub(super) struct FreeByAll<'a>(pub(super) &'a Everything<'a>, pub(super) &'a [Segment]);

impl Kernel for FreeByAll<'_> {
    type Output = Vec<bool>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let Self(all, segments) = self;
        let blocks: Vec<(SphereBlock, u32)> = all
            .spheres
            .chunks(LANES)
            .map(|spheres| (SphereBlock::of(spheres, 0), (1 << spheres.len()) - 1))
            .collect();
        let mut free = Vec::new();
        for segments in segments.chunks(LANES) {
            let ends = [0, 1].map(|end: usize| ends_of(simd, segments, end));
            let [start, end] = &ends;
            let direction = end.position - start.position;
            let packet = ShearedRays::new(Rays::new(start.position, direction, None));
            let mut hidden = Mask64x16::from_bits(simd, 0);
            for plane in all.world.planes() {
                hidden = hidden | plane::is_between(simd, plane, start, end);
            }
            for disk in all.world.disks() {
                hidden = hidden | disk::is_between(simd, disk, start, end);
            }
            for triangle in &all.triangles {
                let per_ray = TrianglePerRay {
                    corners: triangle
                        .vertices()
                        .map(|corner| DVec3x16::splat(simd, corner)),
                    primitive: U64x16::splat(simd, triangle.primitive().0),
                    asked: 0xffff,
                };
                hidden = hidden | per_ray.occlude(simd, &packet, start, end);
            }
            let hidden = hidden.to_bits();
            for (lane, segment) in segments.iter().enumerate() {
                let [start, end] = segment.map(|(position, error, primitive)| End {
                    position,
                    error,
                    primitive: Primitive(primitive),
                });
                let rays = Rays::new(
                    DVec3x16::splat(simd, start.position),
                    DVec3x16::splat(simd, end.position - start.position),
                    None,
                );
                let is_hidden = blocks
                    .iter()
                    .any(|(block, bits)| block.hides(simd, &rays, [&start, &end], *bits));
                free.push(!is_hidden && hidden >> lane & 1 == 0);
            }
        }
        free
    }
}

#[inline(always)]
fn ends_of<S: Simd>(simd: S, segments: &[Segment], end: usize) -> SegmentEnds<S> {
    let mut columns = [[0.0; LANES]; 4];
    let mut primitive = [u64::MAX; LANES];
    for (lane, segment) in segments.iter().enumerate() {
        let (position, error, on) = segment[end];
        for axis in 0..3 {
            columns[axis][lane] = position[axis];
        }
        columns[3][lane] = error;
        primitive[lane] = on;
    }
    let [x, y, z, error] = &columns;
    SegmentEnds {
        position: DVec3x16::load(simd, [x, y, z]),
        error: F64x16::load(simd, error),
        primitive: U64x16::load(simd, &primitive),
    }
}

/// Segments between points anywhere, on surfaces, and both. (Numbers of other dimensions than those of the
/// shapes: some of the others are in line with corners.)
pub(super) fn segments(all: &Everything<'_>, size: f64, count: u32) -> Vec<Segment> {
    let anywhere = |index, dimension: u32| {
        let position = DVec3::from_array(
            [0, 1, 2].map(|axis| (scattered(index, dimension + axis) * 2.0 - 1.0) * size * 1.3),
        );
        (position, 0.0, u64::MAX)
    };
    let segment = |index: u32| match index % 4 {
        0 => [anywhere(index, 50), anywhere(index, 53)],
        1 => [anywhere(index, 50), all.on_surface(index)],
        2 => [all.on_surface(index), anywhere(index, 50)],
        _ => [all.on_surface(index), all.on_surface(index + 1)],
    };
    (0..count).map(segment).collect()
}

#[test]
fn segments_are_free_as_they_are_shape_by_shape() {
    for (size, place) in [(1.0, [0.0; 3]), (1e-5, [0.0; 3]), (1e4, [1e7, -3e6, 0.0])] {
        let mut scene = clutter(size, place, 150, 50);
        scene.plane([0.0, -0.8, 0.0], [0.0, 1.0, 0.1]);
        let world = world_of(&scene);
        let all = Everything::new(&world);
        let visibility = Visibility::new(&world, &Plan::new(&world));
        let segments = segments(&all, size, 12_000);
        let expected = SimdLevel::default().run(FreeByAll(&all, &segments));
        for (name, level) in SimdLevel::available() {
            let found = level.run(FreeSegments(&visibility, &segments));
            for ((found, expected), segment) in found.iter().zip(&expected).zip(&segments) {
                assert_eq!(found, expected, "{name} {segment:?}");
            }
        }
        let free = expected.iter().filter(|&&free| free).count();
        assert!((2000..10_000).contains(&free), "{free}");
        // To and fro, nothing else is in the way.
        let back: Vec<Segment> = segments.iter().map(|&[start, end]| [end, start]).collect();
        let back = SimdLevel::default().run(FreeSegments(&visibility, &back));
        for ((back, expected), segment) in back.iter().zip(&expected).zip(&segments) {
            assert_eq!(back, expected, "{segment:?}");
        }
    }
}

/// From a point light, a segment is free where the light's own test says so.
#[test]
fn segments_from_one_point_are_those_of_a_light() {
    struct Lit<'a>(&'a Visibility<'a>, DVec3, &'a [Segment]);

    impl Kernel for Lit<'_> {
        type Output = Vec<bool>;

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            let Self(visibility, light, segments) = self;
            let mut ends = EndBatch::default();
            for (place, &[_, (position, error, primitive)]) in segments.iter().enumerate() {
                ends.set(place, position, error, primitive);
            }
            let points = SegmentStarts {
                position: &ends.position,
                error: &ends.error,
                primitive: &ends.primitive,
            };
            let mut stack = Box::new(EMPTY_STACK);
            let mut lit = Vec::new();
            for packet in 0..segments.len() / LANES {
                let bits = visibility.shapes.ask_reached(
                    simd,
                    Point(light),
                    points,
                    packet,
                    0xffff,
                    &mut stack,
                );
                lit.extend((0..LANES).map(|lane| bits >> lane & 1 == 1));
            }
            lit
        }
    }

    let mut scene = clutter(1.0, [0.0; 3], 150, 50);
    scene.plane([0.0, -0.8, 0.0], [0.0, 1.0, 0.1]);
    scene.light([0.2, 2.0, 0.3]);
    let world = world_of(&scene);
    let all = Everything::new(&world);
    let visibility = Visibility::new(&world, &Plan::new(&world));
    for index in 0..40_u32 {
        let light = if index.is_multiple_of(2) {
            DVec3::from_array([0, 1, 2].map(|axis| scattered(index, axis) * 3.0 - 1.5))
        } else {
            all.on_surface(index).0
        };
        let segments: Vec<Segment> = (0..BATCH as u32)
            .map(|end| [(light, 0.0, u64::MAX), all.on_surface(index * 1000 + end)])
            .collect();
        for (name, level) in SimdLevel::available() {
            let lit = level.run(Lit(&visibility, light, &segments));
            let free = level.run(FreeSegments(&visibility, &segments));
            assert_eq!(lit, free, "{name} {light}");
        }
    }
}

/// Whatever stands on a plane or on a sphere does not hide it where it touches, and from a start on a sphere
/// segments that lead outwards are free of it, those that lead through it are not.
#[test]
fn ends_on_surfaces_are_not_hidden_by_them() {
    let mut scene = Writer::new(1.0, [0.0; 3], 40.0, EYE);
    scene.sphere([0.0; 3], 1.0);
    let world = world_of(&scene);
    let all = Everything::new(&world);
    let visibility = Visibility::new(&world, &Plan::new(&world));
    let mut segments = Vec::new();
    for index in 0..4000 {
        let (start, error, on) = all.on_surface(index);
        let end = DVec3::from_array([0, 1, 2].map(|axis| scattered(index, axis) * 8.0 - 4.0));
        segments.push([(start, error, on), (end, 0.0, u64::MAX)]);
        // On nothing that is known, but within the error.
        segments.push([(start, error, u64::MAX), (end, 0.0, u64::MAX)]);
    }
    let free = SimdLevel::default().run(FreeSegments(&visibility, &segments));
    for (&[(start, ..), (end, ..)], free) in segments.iter().zip(free) {
        let outwards = start.dot(end - start);
        let is_inside = end.length() < 1.0;
        if outwards.abs() > 1e-9 {
            assert_eq!(free, outwards > 0.0 || is_inside, "{start} {end}");
        }
    }
}

/// By another formula (Möller & Trumbore 1997) rays meet the same triangle at the same t, unless they
/// graze an edge.
#[test]
fn rays_meet_triangles_by_another_formula_too() {
    let world = world_of(&clutter(1.0, [0.0; 3], 200, 0));
    let all = Everything::new(&world);
    let visibility = Visibility::new(&world, &Plan::new(&world));
    let rays = bundle(&all, 1.0, 20_000);
    let found = SimdLevel::default().run(Traced(&visibility, &rays));
    let mut compared = 0;
    for (&[origin, direction], (t, primitive)) in rays.iter().zip(found) {
        let direction_size = direction.length();
        let unit = direction / direction_size;
        let (mut nearest, mut which, mut is_clear) = (f64::INFINITY, u64::MAX, true);
        for triangle in &all.triangles {
            let [a, b, c] = triangle.vertices();
            let (e, f) = (b - a, c - a);
            let p = unit.cross(f);
            let determinant = e.dot(p);
            let s = origin - a;
            let u = s.dot(p) / determinant;
            let q = s.cross(e);
            let v = unit.dot(q) / determinant;
            let at = f.dot(q) / determinant;
            let inside = u.min(v).min(1.0 - u - v);
            let room = 1e-9 * (1.0 + origin.length());
            is_clear &= inside.abs() > room && at.abs() > room || inside < -room;
            is_clear &= determinant.abs() > 1e-6 * e.length() * f.length();
            if inside > 0.0 && at > 0.0 && at < nearest {
                (nearest, which) = (at, triangle.primitive().0);
            }
        }
        if is_clear {
            compared += 1;
            let t = t * direction_size;
            assert_eq!(primitive, which, "{origin} {direction}");
            let room = 1e-8 * (1.0 + origin.length());
            assert!(t == nearest || (t - nearest).abs() <= room, "{t} {nearest}");
        }
    }
    assert!(compared > 8000, "{compared}");
}
