//! Disks: all ways to the same bits, against another formula, and against fans of triangles.

use super::incoherent::{
    Everything, FreeByAll, FreeSegments, Segment, Traced, agrees_with_brute_force, bundle,
    segments, world_of,
};
use super::shafts::holds_for_every_ray;
use super::*;
use crate::visibility::primitive::Primitive;
use crate::visibility::shaft::ShaftQuestion;

impl Writer {
    pub(super) fn disk(&mut self, center: [f64; 3], normal: [f64; 3], radius: f64) {
        self.disks.push((center, normal, radius));
    }

    /// A scene has an object: one that is in nobody's way.
    fn speck(&mut self) {
        self.sphere([50.0, 0.0, 0.0], 1e-3);
    }

    /// Puts the disks into a world, as the last objects.
    pub(super) fn add_disks(&self, world: &mut World) {
        let (size, place) = (self.size, DVec3::from_array(self.place));
        for &(center, normal, radius) in &self.disks {
            let center = place + DVec3::from_array(center) * size - world.anchor();
            world.add_disk(center, DVec3::from_array(normal), radius * size);
        }
    }

    /// Disks without order within 1 of the middle; every fourth is across an axis.
    fn disks_around(&mut self, count: u32, largest: f64) {
        for index in 0..count {
            let at = |dimension: u32| scattered(index, dimension + 60) * 2.0 - 1.0;
            let mut normal = [at(3), at(4), at(5)];
            if index % 4 == 0 {
                normal = [0.0; 3];
                normal[(index / 4 % 3) as usize] = 1.0;
            }
            let radius = largest * (0.1 + 0.9 * scattered(index, 67));
            self.disk([at(0), at(1), at(2)], normal, radius);
        }
    }
}

#[test]
fn disks_are_decided_by_the_projection() {
    let mut scene = Writer::new(1.0, [0.0; 3], 40.0, EYE);
    scene.clutter(100, 20, 0.2);
    scene.disks_around(60, 0.3);
    scene.plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
    scene.lights();
    for direction in [[-0.3, -0.8, -0.5], [0.9, -0.2, -0.3], [0.1, -0.3, 0.7]] {
        scene.sun(direction);
    }
    let fallback = scene.agrees();
    assert!(fallback < FALLS_BACK, "{fallback}");
}

/// With nothing else; of few shapes one often resolves a whole batch.
#[test]
fn a_few_disks_alone() {
    for seed in 0..24 {
        let mut scene = Writer::new(1.0, [0.0; 3], 20.0 + f64::from(seed) * 3.0, EYE);
        scene.speck();
        for index in 0..1 + seed % 4 {
            let at = |dimension| scattered(seed * 8 + index, dimension) * 2.0 - 1.0;
            let radius = 10_f64.powf(at(6) * 1.5);
            scene.disk([at(0), at(1), at(2)], [at(3), at(4), at(5)], radius);
        }
        if seed % 3 == 0 {
            scene.plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
        }
        scene.lights();
        scene.sun([0.3, -1.0, 0.2]);
        scene.agrees();
    }
}

#[test]
fn disks_of_any_size_in_any_place() {
    for (size, place) in [
        (1e-6, [0.0; 3]),
        (1e6, [0.0; 3]),
        (1e-3, [100.0, -50.0, 7.0]),
        (1.0, [1e6, -7e5, 3e5]),
        (1.0, [1e12, -7e11, 3e11]),
        (1e-30, [0.0; 3]),
        (1e29, [0.0; 3]),
    ] {
        let mut scene = Writer::new(size, place, 40.0, EYE);
        scene.clutter(20, 5, 0.3);
        scene.disks_around(40, 0.5);
        scene.plane([0.0, -1.0, 0.0], [0.1, 1.0, 0.2]);
        scene.lights();
        scene.suns();
        scene.agrees();
    }
    // Far from what the scene is relative to.
    for place in [1e3, 1e9] {
        let mut elsewhere = Writer::new(1.0, [0.0; 3], 10.0, [place, place * 0.2, place * 0.5]);
        elsewhere.disks_around(30, 0.5);
        elsewhere.clutter(20, 5, 0.2);
        elsewhere.lights();
        elsewhere.sun([-0.3, -0.8, -0.5]);
        elsewhere.agrees();
    }
}

/// Radii from a dot to a floor without an end.
#[test]
fn disks_of_unlike_sizes() {
    for radius in [1e-30, 1e-12, 1e-6, 1e-3, 1e3, 1e9, 1e20, 1e29] {
        let mut scene = Writer::new(1.0, [0.0; 3], 40.0, EYE);
        scene.disk([0.0; 3], [0.2, 1.0, 0.1], radius);
        scene.disk([0.0, -1.0, 0.0], [0.0, 1.0, 0.0], radius);
        scene.disk([radius, -0.8, 0.0], [0.0, 1.0, 0.0], radius);
        scene.disk([0.0, 0.0, -radius], [0.0, 1.0, 1e-3], radius);
        scene.clutter(20, 5, 0.2);
        scene.lights();
        scene.sun([-0.3, -0.8, -0.5]);
        scene.agrees();
    }
}

/// Seen edge-on, exactly and almost; the viewer within them; and lights on them and in their planes, in the middle,
/// at the rim and beside.
#[test]
fn disks_edge_on() {
    for tilt in [0.0, 1e-17, 1e-12, 1e-8, 1e-5, 1e-3] {
        let mut scene = Writer::new(1.0, [0.0; 3], 60.0, EYE);
        let [x, y, z] = EYE;
        // Through the viewer.
        scene.disk([0.0, y, 0.0], [tilt, 1.0, tilt], 1.0);
        scene.disk([0.0, y, 0.5], [0.0, 1.0, tilt], 4.0);
        scene.disk([x, 0.0, 0.0], [1.0, tilt, 0.0], 0.7);
        scene.disk([x, y, z], [0.0, tilt, 1.0], 0.5);
        scene.disk([x, y, z - 0.1 - tilt], [0.0, tilt, 1.0], 0.01);
        // Under and beside lights.
        scene.disk([0.0, -0.5, 0.0], [tilt, 1.0, 0.0], 0.4);
        scene.disk([0.5, 0.0, 0.0], [1.0, 0.0, tilt], 0.4);
        scene.plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
        scene.clutter(20, 5, 0.2);
        for light in [
            [0.0, -0.5, 0.0],
            [0.4, -0.5, 0.0],
            [0.2, -0.5, 0.1],
            [3.0, -0.5, 0.0],
            [0.0, -0.5 + 1e-13, 0.2],
            [0.0, -0.5 + 1e-7, 0.2],
            [0.5, 0.4, 0.0],
            [0.5, 0.1, 0.2],
            [0.5, 4.0, 1.0],
            EYE,
        ] {
            scene.light(light);
        }
        for direction in [
            [tilt, -1.0, 0.0],
            [1.0, -tilt, 0.0],
            [0.0, tilt, -1.0],
            [-1.0, -tilt, tilt],
        ] {
            scene.sun(direction);
        }
        scene.agrees();
        let mut level = Writer::orthographic(2.2, [0.0, 0.1, 3.0], [0.0, 0.1 - 3.0 * tilt, 0.0]);
        level.disk([0.0, 0.1, 0.0], [0.0, 1.0, 0.0], 0.7);
        level.disk([0.0, -0.5, 0.0], [tilt, 1.0, tilt], 0.9);
        level.disk([0.3, 0.0, -0.2], [1.0, tilt, 0.0], 0.5);
        level.disk([0.0, 0.0, 3.0], [0.0, tilt, 1.0], 0.5);
        level.disk([0.0, 0.0, -2.0], [0.0, tilt, 1.0], 0.8);
        level.clutter(20, 10, 0.1);
        level.lights();
        level.sun([0.0, 0.0, -1.0]);
        level.agrees();
    }
}

/// Rays through the rim: pixels' middles, at which the rims of disks across the view are, within and without.
#[test]
fn rays_through_the_rim() {
    // One pixel is 1 wide at a depth of 1.
    let half = f64::from(RESOLUTION[1]) / 2.0;
    for give in [0.0, 1e-15, 1e-9, 1e-7, 1e-5] {
        let mut scene = Writer::new(1.0, [0.0; 3], 90.0, [0.0, 0.0, 1.0]);
        for index in 0..12 {
            let at = |dimension| scattered(index, dimension);
            let (column, row) = ((at(0) * 40.0).floor() - 19.5, (at(1) * 30.0).floor() - 14.5);
            let depth = 1.0 + at(2);
            let scale = depth / half;
            let rim = (3.0 + (at(3) * 4.0).floor()) * scale;
            let center = [column * scale, row * scale, 1.0 - depth];
            scene.disk(center, [0.0, 0.0, 1.0], rim * (1.0 + give));
            scene.disk(center, [0.0, 0.3, 1.0], rim * (1.0 - give));
        }
        scene.plane([0.0, 0.0, -4.0], [0.0, 0.1, 1.0]);
        scene.light([0.0, 0.0, 1.0]);
        scene.lights();
        scene.agrees();
    }
}

/// Disks in one plane with each other, with planes and with triangles, at one depth: what is first in the scene is
/// seen. And such that touch each other and spheres.
#[test]
fn disks_upon_each_other() {
    let mut scene = Writer::new(1.0, [0.0; 3], 50.0, EYE);
    scene.plane([0.0, -0.5, 0.0], [0.0, 1.0, 0.0]);
    scene.triangle([[-1.0, -0.5, 0.0], [1.0, -0.5, 0.0], [0.0, -0.5, 1.0]]);
    scene.sphere([0.0, -0.25, 0.0], 0.25);
    scene.disk([0.0, -0.5, 0.0], [0.0, 1.0, 0.0], 0.5);
    scene.disk([0.0, -0.5, 0.0], [0.0, -1.0, 0.0], 0.5);
    scene.disk([0.2, -0.5, 0.2], [0.0, 1.0, 0.0], 0.5);
    scene.disk([0.0, 0.0, 0.0], [0.0, 1.0, 0.0], 0.25);
    scene.disk([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], 0.25);
    scene.disk([0.0, 0.0, 0.0], [0.0, 0.0, 1.0], 0.25);
    scene.disk([0.25, -0.25, 0.0], [1.0, 0.0, 0.0], 0.25);
    scene.lights();
    scene.light([0.0, 0.0, 0.0]);
    scene.light([0.25, -0.5, 0.0]);
    scene.suns();
    scene.agrees();
}

#[test]
fn disks_before_parallel_rays_at_every_scale() {
    for height in [1e-12, 1e-7, 1e-3, 30.0, 1e5, 1e9] {
        let mut scene = Writer::orthographic(height, EYE, [0.01, 0.02, 0.03]);
        scene.disks_around(40, 0.5);
        scene.clutter(20, 4, 0.2);
        scene.plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
        scene.lights();
        scene.suns();
        scene.agrees();
    }
}

/// Suns and telescopes.
#[test]
fn disks_far_away() {
    for distance in [1e6, 1e9, 1.5e11, 1e13] {
        let towards = [0.3 * distance, 0.7 * distance, 0.4 * distance];
        let mut scene = Writer::new(1.0, [0.0; 3], 10.0, EYE);
        scene.disks_around(40, 0.3);
        scene.plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
        scene.disk(towards, [-0.3, -0.7, -0.4], distance * 0.01);
        scene.light(towards);
        scene.agrees();
        let mut scene = Writer::new(1.0, [0.0; 3], 100.0 / distance, towards);
        scene.disks_around(40, 0.4);
        scene.clutter(20, 10, 0.2);
        scene.lights();
        scene.agrees();
    }
}

fn amid(size: f64, place: [f64; 3]) -> Writer {
    let mut scene = Writer::new(size, place, 40.0, EYE);
    scene.clutter(60, 20, 0.3);
    scene.disks_around(40, 0.5);
    scene.plane([0.0, -0.9, 0.0], [0.1, 1.0, 0.2]);
    scene
}

#[test]
fn rays_meet_disks_one_by_one() {
    for size in [1.0, 1e-6, 1e6, 1e-30, 1e29] {
        let scene = amid(size, [0.0; 3]);
        let hit = agrees_with_brute_force(&world_of(&scene), size, 8000);
        assert!(hit > 0.2, "{size} {hit}");
    }
}

/// Shape by shape, and to and fro.
#[test]
fn segments_are_free_of_disks_one_by_one() {
    for (size, place) in [
        (1.0, [0.0; 3]),
        (1e-5, [0.0; 3]),
        (1e4, [1e7, -3e6, 0.0]),
        (1e-30, [0.0; 3]),
        (1e29, [0.0; 3]),
    ] {
        let world = world_of(&amid(size, place));
        let all = Everything::new(&world);
        let visibility = Visibility::new(&world, &Plan::new(&world));
        let segments = segments(&all, size, 8000);
        let expected = SimdLevel::default().run(FreeByAll(&all, &segments));
        for (name, level) in SimdLevel::available() {
            let found = level.run(FreeSegments(&visibility, &segments));
            for ((found, expected), segment) in found.iter().zip(&expected).zip(&segments) {
                assert_eq!(found, expected, "{name} {segment:?}");
            }
        }
        let back: Vec<Segment> = segments.iter().map(|&[start, end]| [end, start]).collect();
        let back = SimdLevel::default().run(FreeSegments(&visibility, &back));
        assert_eq!(back, expected);
    }
}

/// By another formula: with the plane's equation at the ends, by the cross product of Q = R²(n·d)² − |n × (d × e)|².
#[test]
fn disks_are_met_by_another_formula_too() {
    let mut scene = Writer::new(1.0, [0.0; 3], 40.0, EYE);
    scene.speck();
    scene.disks_around(60, 0.5);
    let world = world_of(&scene);
    let all = Everything::new(&world);
    let visibility = Visibility::new(&world, &Plan::new(&world));
    let rays = bundle(&all, 1.0, 20_000);
    let found = SimdLevel::default().run(Traced(&visibility, &rays));
    let (mut compared, mut hit) = (0, 0);
    for (&[origin, direction], (t, primitive)) in rays.iter().zip(found) {
        let unit = direction.normalize();
        let (mut nearest, mut which, mut is_clear) = (f64::INFINITY, u64::MAX, true);
        for disk in world.disks() {
            let (n, e) = (disk.normal.get(), disk.center.0 - origin);
            let (facing, height) = (n.dot(unit), n.dot(e));
            let beside = n.cross(unit.cross(e)).length();
            let inside = disk.radius * facing.abs() - beside;
            let at = height / facing;
            let room = 1e-9 * (1.0 + origin.length());
            is_clear &= inside.abs() > room && (height.abs() > room || inside < -room);
            if inside > 0.0 && at > 0.0 && at < nearest {
                (nearest, which) = (at, Primitive::whole(disk.object).0);
            }
        }
        // But for rays that start on the speck.
        if is_clear && primitive != Primitive::whole(0).0 {
            compared += 1;
            hit += u32::from(nearest.is_finite());
            assert_eq!(primitive, which, "{origin} {direction}");
            let t = t * direction.length();
            let room = 1e-6 * (1.0 + origin.length());
            assert!(t == nearest || (t - nearest).abs() <= room, "{t} {nearest}");
        }
    }
    assert!(compared > 10_000 && hit > 3000, "{compared} {hit}");
}

/// Rays and segments meet a disk where they meet a fan of triangles, but near the rim.
#[test]
fn disks_are_fans_of_triangles() {
    const CORNERS: u32 = 256;
    // The largest part of the radius that is between the rim and an edge.
    let sagitta = 1.0 - (std::f64::consts::PI / f64::from(CORNERS)).cos();
    let mut round = Writer::new(1.0, [0.0; 3], 40.0, EYE);
    round.disks_around(8, 0.9);
    let mut cut = Writer::new(1.0, [0.0; 3], 40.0, EYE);
    for &(center, normal, radius) in &round.disks {
        let (center, normal) = (DVec3::from_array(center), DVec3::from_array(normal));
        let (a, b) = normal.normalize().any_orthonormal_pair();
        let corner = |index: u32| {
            let turn = f64::from(index) / f64::from(CORNERS) * std::f64::consts::TAU;
            let (sine, cosine) = turn.sin_cos();
            (center + (a * cosine + b * sine) * radius).to_array()
        };
        for index in 0..CORNERS {
            cut.triangle([center.to_array(), corner(index), corner(index + 1)]);
        }
    }
    round.speck();
    let worlds = [world_of(&round), world_of(&cut)];
    let [disks, fans] = worlds.each_ref();
    let ways = worlds
        .each_ref()
        .map(|world| Visibility::new(world, &Plan::new(world)));
    let rays: Vec<_> = (0..20_000)
        .map(|index| {
            let [a, b] = [0, 3].map(|dimension| {
                let at = |axis: u32| scattered(index, dimension + axis) * 3.0 - 1.5;
                DVec3::new(at(0), at(1), at(2))
            });
            [a, b - a]
        })
        .collect();
    let ends: Vec<Segment> = rays
        .iter()
        .map(|&[start, way]| [(start, 0.0, u64::MAX), (start + way, 0.0, u64::MAX)])
        .collect();
    let [met, fan_met] = ways
        .each_ref()
        .map(|way| SimdLevel::default().run(Traced(way, &rays)));
    let [free, fan_free] = ways
        .each_ref()
        .map(|way| SimdLevel::default().run(FreeSegments(way, &ends)));
    assert!(fans.triangles().len() == 8 * CORNERS as usize);
    let (mut compared, mut hit) = (0, 0);
    for (place, &[start, way]) in rays.iter().enumerate() {
        let is_clear = disks.disks().iter().all(|disk| {
            let n = disk.normal.get();
            let at = n.dot(disk.center.0 - start) / n.dot(way);
            let beside = (start + way * at - disk.center.0).length() / disk.radius;
            !(1.0 - sagitta - 1e-9..1.0 + 1e-9).contains(&beside)
        });
        if is_clear {
            compared += 1;
            hit += u32::from(!free[place]);
            let (t, fan_t) = (met[place].0, fan_met[place].0);
            assert!(t == fan_t || (t - fan_t).abs() < 1e-9 * t, "{t} {fan_t}");
            assert_eq!(free[place], fan_free[place]);
        }
    }
    assert!(compared > 19_000 && hit > 2000, "{compared} {hit}");
}

/// What is on a disk is not hidden by it, wherever the other end is, nor what touches it with rounding.
#[test]
fn disks_do_not_hide_what_is_on_them() {
    let mut scene = Writer::new(1.0, [0.0; 3], 40.0, EYE);
    scene.disk([0.1, 0.2, 0.3], [0.3, 1.0, -0.2], 0.8);
    scene.speck();
    let world = world_of(&scene);
    let disk = world.disks()[0];
    let visibility = Visibility::new(&world, &Plan::new(&world));
    let own = Primitive::whole(disk.object).0;
    let (a, b) = disk.normal.get().any_orthonormal_pair();
    let mut segments: Vec<Segment> = Vec::new();
    for index in 0..4000 {
        let at = |dimension| scattered(index, dimension) * 2.0 - 1.0;
        let start = disk.center.0 + (a * at(0) + b * at(1)) * (0.5 * disk.radius);
        let end = DVec3::new(at(2), at(3), at(4)) * 4.0;
        for on in [own, u64::MAX] {
            let (start, end) = ((start, 1e-14, on), (end, 0.0, u64::MAX));
            segments.extend([[start, end], [end, start]]);
        }
    }
    let free = SimdLevel::default().run(FreeSegments(&visibility, &segments));
    assert!(!free.contains(&false));
    // A little further on the other side all of them are.
    let beyond: Vec<Segment> = segments
        .iter()
        .step_by(4)
        .map(|&[(start, ..), end]| {
            let side = disk.normal.get() * disk.normal.get().dot(end.0 - start).signum();
            [(start - side * 1e-9, 0.0, u64::MAX), end]
        })
        .collect();
    let free = SimdLevel::default().run(FreeSegments(&visibility, &beyond));
    assert!(!free.contains(&true));
}

#[test]
fn shafts_through_disks() {
    for (size, count) in [
        (1.0, 1200),
        (1e-20, 150),
        (1e-6, 150),
        (1e6, 150),
        (1e20, 150),
    ] {
        let mut scene = Writer::new(size, [0.0; 3], 40.0, EYE);
        scene.clutter(10, 5, 0.5);
        scene.disks_around(40, 0.9);
        scene.plane([0.0, -1.5, 0.0], [0.0, 1.0, 0.05]);
        for question in [
            ShaftQuestion::Contents,
            ShaftQuestion::FirstHit,
            ShaftQuestion::Blockage,
        ] {
            let counts = holds_for_every_ray(&scene, size, count, question);
            assert!(counts.nothing > 5 && counts.all > 5, "{size} {counts:?}");
        }
    }
}

/// One disk: nothing, all or some, as anyone sees.
#[test]
fn a_shaft_through_one_disk() {
    let mut scene = Writer::new(1.0, [0.0; 3], 40.0, EYE);
    scene.disk([0.0; 3], [0.0, 1.0, 0.0], 1.0);
    scene.speck();
    for question in [ShaftQuestion::FirstHit, ShaftQuestion::Contents] {
        let counts = holds_for_every_ray(&scene, 1.0, 400, question);
        assert!(
            counts.nothing > 50 && counts.all > 5 && counts.these > 50,
            "{counts:?}"
        );
    }
}
