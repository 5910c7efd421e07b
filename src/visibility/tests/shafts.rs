//! Shafts against many of their rays, each before all shapes.

use super::incoherent::{Everything, Ray, lanes_of, world_of};
use super::*;
use crate::simd::ones;
use crate::visibility::question::NearestHit;
use crate::visibility::rays::ShearedRays;
use crate::visibility::shaft::{Shaft, ShaftAnswer, ShaftQuestion, ShaftSpace};
use crate::visibility::shape::{Shape as _, disk, plane};

/// Rays of a shaft that are tried.
const TRIED: u32 = 48;

/// Rays with their ranges of t.
struct Samples {
    rays: Vec<Ray>,
    range: [f64; 2],
}

/// What some rays meet: all that each does, and first.
struct MeetAll<'a>(&'a Everything<'a>, &'a Samples);

impl Kernel for MeetAll<'_> {
    type Output = Vec<Vec<(f64, u64)>>;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Self::Output {
        let Self(all, Samples { rays, range }) = self;
        let mut met = vec![Vec::new(); rays.len()];
        for (first, rays) in (0..).step_by(LANES).zip(rays.chunks(LANES)) {
            let packet = ShearedRays::new(lanes_of(simd, rays));
            let mut take = |nearest: &NearestHit<S>| {
                let (t, primitive) = (nearest.t.to_array(), nearest.primitive.to_array());
                for lane in ones((1 << rays.len()) - 1) {
                    if (range[0]..=range[1]).contains(&t[lane]) && t[lane].is_finite() {
                        met[first + lane].push((t[lane], primitive[lane]));
                    }
                }
            };
            let none = NearestHit::new(simd, (1 << rays.len()) - 1);
            for plane in all.world.planes() {
                let mut nearest = none;
                plane::intersect(simd, plane, &packet.rays, &mut nearest);
                take(&nearest);
            }
            for disk in all.world.disks() {
                let mut nearest = none;
                disk::intersect(simd, disk, &packet.rays, &mut nearest);
                take(&nearest);
            }
            for sphere in &all.spheres {
                let mut nearest = none;
                sphere.intersect(simd, &packet, &mut nearest);
                take(&nearest);
            }
            for triangle in &all.triangles {
                let mut nearest = none;
                triangle.intersect(simd, &packet, &mut nearest);
                take(&nearest);
            }
        }
        met
    }
}

struct Ask<'a>(
    &'a Visibility<'a>,
    &'a Shaft,
    ShaftQuestion,
    usize,
    &'a mut ShaftSpace,
);

impl Kernel for Ask<'_> {
    type Output = ShaftAnswer;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> ShaftAnswer {
        let Self(visibility, shaft, question, most, space) = self;
        visibility.shaft(simd, shaft, question, u64::MAX, most, space)
    }
}

fn vector(index: u32, dimension: u32) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|axis| scattered(index, dimension + axis) * 2.0 - 1.0))
}

/// Between two numbers, as often at either as anywhere.
fn between(index: u32, dimension: u32, [least, most]: [f64; 2]) -> f64 {
    let at = scattered(index, dimension) * 2.0 - 0.5;
    least + (most - least) * at.clamp(0.0, 1.0)
}

fn in_box(index: u32, dimension: u32, [min, max]: [DVec3; 2]) -> DVec3 {
    DVec3::from_array([0, 1, 2].map(|axis| {
        between(
            index,
            dimension + axis,
            [min[axis as usize], max[axis as usize]],
        )
    }))
}

/// A shaft of each kind in turn, wide or narrow, and some of its rays: its corners among them.
fn shaft(index: u32, size: f64) -> (Shaft, Samples) {
    let width = 10_f64.powf(-0.3 - 3.0 * scattered(index, 20));
    let eye = vector(index, 0) * size * 2.5;
    let forward = (vector(index, 3) * size * 0.6 - eye).normalize();
    let (u, v) = forward.any_orthonormal_pair();
    let depths = match index / 4 % 3 {
        0 => [0.0, f64::INFINITY],
        1 => [size * 0.5, f64::INFINITY],
        _ => [size, size * (1.5 + 2.0 * scattered(index, 21))],
    };
    let corner = |s: f64, t: f64| u * (s * width) + v * (t * width * 0.7);
    let window = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let inside = |sample: u32| {
        let [s, t] = [30, 31].map(|dimension| between(sample + index, dimension, [-1.0, 1.0]));
        corner(s, t)
    };
    match index % 4 {
        0 => {
            let directions = window.map(|(s, t)| forward + corner(s, t));
            let rays = (0..TRIED).map(|sample| [eye, forward + inside(sample)]);
            let rays = rays
                .chain(directions.map(|direction| [eye, direction]))
                .collect();
            let shaft = Shaft::Perspective {
                eye,
                directions,
                forward,
                depths,
            };
            (
                shaft,
                Samples {
                    rays,
                    range: depths,
                },
            )
        }
        1 => {
            let starts = window.map(|(s, t)| eye + corner(s, t) * size);
            let rays = (0..TRIED).map(|sample| [eye + inside(sample) * size, forward]);
            let rays = rays.chain(starts.map(|start| [start, forward])).collect();
            let shaft = Shaft::Orthographic {
                starts,
                forward,
                depths,
            };
            (
                shaft,
                Samples {
                    rays,
                    range: depths,
                },
            )
        }
        kind => {
            let around = |middle: DVec3, width: f64, dimension| {
                let half = vector(index, dimension).abs() * (width * size);
                [middle - half, middle + half]
            };
            let to = vector(index, 6) * size * 2.5;
            let from = around(vector(index, 0) * size * 1.2, width, 9);
            let to = if kind == 2 {
                [to, to]
            } else {
                around(to, width * 0.5, 12)
            };
            let rays = (0..TRIED + 8).map(|sample| {
                let start = in_box(sample + index, 30, from);
                [start, in_box(sample + index, 33, to) - start]
            });
            let rays = rays.collect();
            let shaft = if kind == 2 {
                Shaft::ToPoint { from, to: to[0] }
            } else {
                Shaft::ToBox { from, to }
            };
            let range = [0.0, 1.0];
            (shaft, Samples { rays, range })
        }
    }
}

/// How often each answer was given.
#[derive(Debug, Default)]
pub(super) struct Counts {
    pub(super) nothing: u32,
    pub(super) all: u32,
    pub(super) these: u32,
    too_many: u32,
}

/// Asks many shafts and tries their rays.
#[track_caller]
pub(super) fn holds_for_every_ray(
    scene: &Writer,
    size: f64,
    count: u32,
    question: ShaftQuestion,
) -> Counts {
    let world = world_of(scene);
    let all = Everything::new(&world);
    let visibility = Visibility::new(&world, &Plan::new(&world));
    let mut space = ShaftSpace::default();
    let mut counts = Counts::default();
    for index in 0..count {
        let (shaft, samples) = shaft(index, size);
        let mut ask = |level: SimdLevel, most| {
            let answer = level.run(Ask(&visibility, &shaft, question, most, &mut space));
            (answer, space.list.clone())
        };
        let (answer, list) = ask(SimdLevel::default(), 48);
        for (name, level) in SimdLevel::available() {
            assert_eq!(ask(level, 48), (answer, list.clone()), "{name}");
        }
        assert!(list.is_sorted(), "in the order of the scene");
        match answer {
            ShaftAnswer::Nothing => counts.nothing += 1,
            ShaftAnswer::All(_) => counts.all += 1,
            ShaftAnswer::These => counts.these += 1,
            ShaftAnswer::TooMany => {
                counts.too_many += 1;
                // There are, and room for all of them lists them.
                let (_, list) = ask(SimdLevel::default(), usize::MAX);
                assert!(list.len() > 48 || question != ShaftQuestion::Contents);
                continue;
            }
        }
        for (met, ray) in SimdLevel::default()
            .run(MeetAll(&all, &samples))
            .iter()
            .zip(&samples.rays)
        {
            let first = met
                .iter()
                .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            let has = |shape: u64| met.iter().any(|&(_, other)| other == shape);
            match (question, answer) {
                (_, ShaftAnswer::Nothing) => assert!(met.is_empty(), "{shaft:?} {ray:?} {met:?}"),
                (ShaftQuestion::Blockage, ShaftAnswer::All(shape)) => {
                    assert!(has(shape), "{shaft:?} {ray:?} {met:?} {shape}");
                }
                (_, ShaftAnswer::All(shape)) => {
                    let first = first.map(|&(_, first)| first);
                    assert_eq!(first, Some(shape), "{shaft:?} {ray:?} {met:?}");
                }
                _ => {}
            }
            let listed: Vec<u64> = match (question, answer) {
                (ShaftQuestion::FirstHit, _) => {
                    first.map(|&(_, first)| first).into_iter().collect()
                }
                (ShaftQuestion::Blockage, ShaftAnswer::All(_)) => Vec::new(),
                _ => met.iter().map(|&(_, shape)| shape).collect(),
            };
            for shape in listed {
                assert!(list.contains(&shape), "{shaft:?} {ray:?} {met:?} {list:?}");
            }
        }
    }
    counts
}

fn scene(size: f64) -> Writer {
    let mut scene = Writer::new(size, [0.0; 3], 40.0, EYE);
    scene.clutter(60, 30, 0.5);
    scene.plane([0.0, -1.5, 0.0], [0.0, 1.0, 0.05]);
    scene
}

#[test]
fn what_is_in_shafts_is_listed() {
    let counts = holds_for_every_ray(&scene(1.0), 1.0, 1200, ShaftQuestion::Contents);
    assert!(
        counts.nothing > 100 && counts.all > 50 && counts.these > 200,
        "{counts:?}"
    );
}

#[test]
fn what_shafts_meet_first_is_listed() {
    let counts = holds_for_every_ray(&scene(1.0), 1.0, 1200, ShaftQuestion::FirstHit);
    assert!(
        counts.nothing > 100 && counts.all > 200 && counts.these > 200,
        "{counts:?}"
    );
}

#[test]
fn what_stands_in_shafts_is_told() {
    let counts = holds_for_every_ray(&scene(1.0), 1.0, 1200, ShaftQuestion::Blockage);
    assert!(
        counts.nothing > 100 && counts.all > 200 && counts.these > 100,
        "{counts:?}"
    );
}

#[test]
fn shafts_at_all_scales() {
    for size in [1e-20, 1e-6, 1e6, 1e20] {
        for question in [ShaftQuestion::Contents, ShaftQuestion::FirstHit] {
            let counts = holds_for_every_ray(&scene(size), size, 150, question);
            assert!(counts.nothing > 5 && counts.all > 5, "{size} {counts:?}");
        }
    }
}

/// A floor and a ball over it: the answers that anyone sees.
#[test]
fn a_ball_over_a_floor() {
    let mut scene = Writer::new(1.0, [0.0; 3], 40.0, EYE);
    scene.plane([0.0, -1.0, 0.0], [0.0, 1.0, 0.0]);
    scene.sphere([0.0; 3], 0.5);
    let world = world_of(&scene);
    let visibility = Visibility::new(&world, &Plan::new(&world));
    let [floor, ball] = [0, 1_u64 << 32];
    let mut space = ShaftSpace::default();
    let mut ask = |from: [f64; 3], to: [f64; 3], half: f64, question| {
        let around = |middle: [f64; 3]| {
            let middle = DVec3::from_array(middle);
            [middle - half, middle + half]
        };
        let shaft = Shaft::ToBox {
            from: around(from),
            to: around(to),
        };
        let answer = SimdLevel::default().run(Ask(&visibility, &shaft, question, 8, &mut space));
        (answer, space.list.clone())
    };
    use ShaftAnswer::{All, Nothing, These};
    use ShaftQuestion::{Blockage, Contents, FirstHit};
    // Beside the ball, above the floor.
    assert_eq!(
        ask([2.0, 0.0, 0.0], [2.0, 3.0, 0.0], 0.1, Contents),
        (Nothing, vec![])
    );
    // From below it to above it.
    let below = [0.0, -0.8, 0.0];
    assert_eq!(
        ask(below, [0.0, 3.0, 0.0], 0.1, Contents),
        (All(ball), vec![ball])
    );
    // Past its edge.
    assert_eq!(
        ask([0.5, -0.8, 0.0], [0.5, 3.0, 0.0], 0.1, Contents),
        (These, vec![ball])
    );
    // From above both to under the floor.
    let under = [0.0, -3.0, 0.0];
    assert_eq!(
        ask([0.0, 3.0, 0.0], under, 0.1, Contents),
        (All(ball), vec![floor, ball])
    );
    assert_eq!(ask(under, [0.0, 3.0, 0.0], 0.1, FirstHit).0, All(floor));
    assert!(matches!(
        ask([0.5, 3.0, 0.0], [0.5, -3.0, 0.0], 0.1, Contents).0,
        These
    ));
    assert_eq!(
        ask([0.5, 3.0, 0.0], [0.5, -3.0, 0.0], 0.1, Blockage).0,
        All(floor)
    );
}
