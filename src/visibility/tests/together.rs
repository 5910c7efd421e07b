//! Rays that go much the same way, which share a beam, against each of them alone.

use super::incoherent::{Everything, Ray, agree_with_rays, bundle, world_of};
use super::*;
use crate::visibility::ray_batch::RayStart;
use crate::visibility::rays::Rays;
use crate::visibility::tree::{Beam, Bounds, TreeFrame};

/// For each of some rays sixteen that start near it and go its way: by spreads from nothing to a fourth of their length.
fn neighbors(rays: &[Ray], size: f64) -> Vec<Ray> {
    let neighbor = |index: u32| {
        let [origin, direction] = rays[index as usize / LANES];
        let number = |dimension: u32| scattered(index, 60 + dimension) * 2.0 - 1.0;
        let vector = |dimension: u32| {
            DVec3::new(
                number(dimension),
                number(dimension + 1),
                number(dimension + 2),
            )
        };
        let spread = |dimension: u32| {
            let exponent = scattered(index / LANES as u32, 70 + dimension);
            0.25 * 10_f64.powf(-6.0 * exponent)
        };
        [
            origin + vector(0) * (size * spread(0)),
            direction + vector(3) * (direction.abs().max_element() * spread(1)),
        ]
    };
    (0..(rays.len() * LANES) as u32).map(neighbor).collect()
}

/// Clutter with triangles and spheres, many or few.
fn worlds() -> [(World, f64); 4] {
    let world = |size: f64, place: [f64; 3], triangles, spheres| {
        let mut scene = Writer::new(size, place, 40.0, EYE);
        scene.clutter(triangles, spheres, 0.3);
        scene.plane([0.0, -1.0, 0.0], [0.1, 1.0, 0.2]);
        (world_of(&scene), size)
    };
    [
        world(1.0, [0.0; 3], 400, 120),
        world(1.0, [0.0; 3], 10, 25),
        world(1e-6, [0.0; 3], 100, 40),
        world(1e-3, [100.0, -50.0, 7.0], 100, 70),
    ]
}

#[test]
fn rays_of_a_beam_meet_what_they_meet_one_by_one() {
    for (world, size) in worlds() {
        let visibility = Visibility::new(&world, &Plan::new(&world));
        let some = bundle(&Everything::new(&world), size, 600);
        let hit = agree_with_rays(&visibility, &neighbors(&some, size));
        assert!(hit > 0.2, "{hit}");
    }
}

/// What rays that leave surfaces meet, so many of them at once.
struct Leaving<'a>(&'a Visibility<'a>, &'a [(Ray, RayStart)], usize);

impl Kernel for Leaving<'_> {
    type Output = Vec<(u64, u64)>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let Self(visibility, rays, at_once) = self;
        let mut batch = IncoherentRays::default();
        let mut space = Workspace::default();
        let mut found = Vec::new();
        for rays in rays.chunks(at_once) {
            batch.clear();
            for ([origin, direction], start) in rays {
                batch.push_from(*origin, *direction, start);
            }
            let hits = visibility.hits(simd, &batch, &mut space);
            found.extend((0..rays.len()).map(|ray| (hits.t[ray].to_bits(), hits.primitive[ray])));
        }
        found
    }
}

/// Rays leave what they start on, together as alone: from spheres, triangles and edges, to both sides.
#[test]
fn rays_that_leave_surfaces_together_meet_what_each_meets_alone() {
    for (world, size) in worlds() {
        let visibility = Visibility::new(&world, &Plan::new(&world));
        let all = Everything::new(&world);
        let some = bundle(&all, size, 400);
        let rays: Vec<(Ray, RayStart)> = neighbors(&some, size)
            .into_iter()
            .zip(0_u32..)
            .map(|([_, direction], index)| {
                // Those of a packet leave one shape, some of them the same point.
                let (position, error, primitive) = all.on_surface(index / LANES as u32);
                let beside = all.on_surface(index);
                let (position, error) = if index % 3 == 0 && beside.2 == primitive {
                    (beside.0, beside.1)
                } else {
                    (position, error)
                };
                let start = RayStart {
                    t: 0.0,
                    position,
                    error,
                    primitive,
                };
                ([position, direction], start)
            })
            .collect();
        for (name, level) in SimdLevel::available() {
            let together = level.run(Leaving(&visibility, &rays, 256));
            let alone = level.run(Leaving(&visibility, &rays, 1));
            let different = together.iter().zip(&alone).position(|(a, b)| a != b);
            assert_eq!(
                different,
                None,
                "{name} {:?}",
                different.map(|ray| rays[ray])
            );
        }
    }
}

/// Whether rays share a beam, whatever leaves there are.
struct Shared<'a>(&'a [Ray]);

impl Kernel for Shared<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let rays: Rays<S> = incoherent::lanes_of(simd, self.0);
        let frame = TreeFrame::around(Bounds {
            min: -DVec3::ONE,
            max: DVec3::ONE,
        });
        let asked = (1 << self.0.len()) - 1;
        Beam::around(simd, &frame, &rays, asked, 1.0).is_some()
    }
}

#[test]
fn rays_share_a_beam_that_go_much_the_same_way() {
    let level = SimdLevel::default();
    let ray = [DVec3::new(0.1, 0.2, 3.0), DVec3::new(0.0, 0.1, -1.0)];
    assert!(level.run(Shared(&neighbors(&[ray], 1.0))));
    assert!(!level.run(Shared(&[ray, [ray[0], -ray[1]]])));
}
