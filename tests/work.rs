//! What visibility takes, counted: facts where the work is known, the same for any number of threads.

use candela::render::{Counts, Job, Options, Renderer, SimdLevel, Work};
use candela::scene::{Camera, Image, Light, Material, MeshFile, Object, Placement, Scene};
use candela::world::World;

const RESOLUTION: [u32; 2] = [60, 40];

/// Tiles of 16 × 16 pixels; at one sample each of them is a batch.
const TILES: u64 = 4 * 3;

const LIGHTS: u64 = 2;

/// Triangles of a leaf, and rays of a packet.
const LANES: u64 = 16;

/// Some objects under two lights, seen from (0, 0, 4).
fn scene(objects: impl IntoIterator<Item = Object>) -> Scene {
    let [width, height] = RESOLUTION;
    let scene = Scene::new(
        Image::new(width, height),
        Camera::perspective([0.0, 0.0, 4.0], [0.0; 3], 40.0),
    )
    .material("clay", Material::phong(0.5))
    .light("key", Light::point([1.0, 2.0, 5.0], 10.0))
    .light("fill", Light::point([-2.0, 1.0, 6.0], 10.0));
    let objects = objects.into_iter().enumerate();
    objects.fold(scene, |scene, (number, object)| {
        scene.object(format!("o{number}"), object)
    })
}

/// A wavy sheet of 2 · `side`² triangles, all of which the camera and both lights see from the front.
fn sheet(side: u32) -> Object {
    let place = |number: u32| 2.0 * f64::from(number) / f64::from(side) - 1.0;
    let mut mesh = MeshFile::default();
    for row in 0..=side {
        for column in 0..=side {
            let [x, y] = [column, row].map(place);
            let z = 0.05 * (7.0 * x).sin() * (5.0 * y).cos();
            mesh.positions.push([x, y, z]);
        }
    }
    for row in 0..side {
        for column in 0..side {
            let first = row * (side + 1) + column;
            let above = first + side + 1;
            mesh.triangles.push([first, first + 1, above + 1]);
            mesh.triangles.push([first, above + 1, above]);
        }
    }
    Object::mesh("clay", mesh, Placement::default())
}

fn counts(scene: &Scene, threads: usize, options: &Options) -> Counts {
    let (world, camera) = World::new(scene).unwrap();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().unwrap().install(|| {
        let renderer = Renderer::new(&world).unwrap();
        let rendered = renderer.film(&camera, options, &Job::new());
        rendered.unwrap().1
    })
}

fn with_work(samples: u32) -> Options {
    Options {
        samples,
        counts_work: true,
        ..Options::default()
    }
}

#[test]
fn without_triangles_there_are_no_leaves() {
    let ball = Object::sphere("clay", [0.0; 3], 0.5);
    let wall = Object::plane("clay", [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]);
    let Work { primary, shadow } = counts(&scene([ball, wall]), 2, &with_work(1)).work;
    assert_eq!(primary.batches, TILES);
    for work in [primary, shadow] {
        assert_eq!(work.distinct_leaves, Some(0));
        assert_eq!([work.leaves, work.leaf_bytes, work.pairs], [0; 3]);
    }
}

#[test]
fn one_triangle_before_all_is_set_up_once_a_batch_and_tested_nowhere() {
    let vertices = [[-90.0, -90.0, 0.0], [90.0, -90.0, 0.0], [0.0, 90.0, 0.0]];
    let scene = scene([Object::triangle("clay", vertices)]);
    for (_, simd) in SimdLevel::available() {
        let options = Options {
            simd,
            ..with_work(1)
        };
        let counts = counts(&scene, 2, &options);
        let all = u64::from(RESOLUTION[0] * RESOLUTION[1]);
        assert_eq!([counts.hits, counts.lit], [all, LIGHTS * all]);
        let Work { primary, shadow } = counts.work;
        for (work, origins) in [(primary, 1), (shadow, LIGHTS)] {
            assert_eq!(work.batches, TILES * origins);
            assert_eq!(work.resolved_whole, work.batches);
            assert_eq!(work.leaves, work.batches);
            assert_eq!(work.distinct_leaves, Some(origins));
            assert_eq!([work.pairs, work.fallbacks], [0, 0]);
        }
        assert_eq!(primary.leaf_bytes * LIGHTS, shadow.leaf_bytes);
    }
}

#[test]
fn each_leaf_of_a_mesh_is_met_from_the_eye_and_from_each_light() {
    const SIDE: u32 = 32;
    let triangles = u64::from(2 * SIDE * SIDE);
    // So many samples that each leaf is the first that some ray meets.
    let counts = counts(&scene([sheet(SIDE)]), 2, &with_work(16));
    let Work { primary, shadow } = counts.work;
    let leaves = primary.distinct_leaves.unwrap();
    assert!(
        (triangles.div_ceil(LANES)..=triangles / 8).contains(&leaves),
        "{leaves}"
    );
    assert_eq!(shadow.distinct_leaves, Some(LIGHTS * leaves));
    let rays = [
        (primary, counts.hits, leaves),
        (shadow, counts.shadow_rays, LIGHTS * leaves),
    ];
    for (work, met, leaves) in rays {
        assert!(work.leaves >= leaves);
        assert!(work.resolved_whole < work.batches);
        // Hardly a ray in a hundred is too near to an edge.
        assert!(work.fallbacks < met / 100, "{work:?}");
        assert_eq!(work.leaf_bytes % work.leaves, 0);
    }
    assert!(primary.pairs * LANES >= counts.hits - primary.fallbacks);
}

#[test]
fn threads_do_not_change_it_and_it_changes_nothing() {
    let ball = Object::sphere("clay", [0.0, 0.0, 0.8], 0.3);
    let scene = scene([sheet(32), ball]);
    for samples in [1, 4] {
        let once = counts(&scene, 1, &with_work(samples));
        for threads in [2, 3, 7] {
            assert_eq!(
                counts(&scene, threads, &with_work(samples)),
                once,
                "{threads}"
            );
        }
        let without = Options {
            counts_work: false,
            ..with_work(samples)
        };
        let without = counts(&scene, 2, &without);
        assert_eq!(without.work, Work::default());
        let work = once.work;
        assert_eq!(Counts { work, ..without }, once);
    }
}

/// Instructions with fused multiply-adds round alike.
#[test]
fn instructions_that_fuse_take_the_same() {
    let scene = scene([sheet(32)]);
    let all = SimdLevel::available().into_iter();
    let fused = all.filter(|&(name, _)| name != "sse2");
    let mut works = fused.map(|(_, simd)| {
        let options = Options {
            simd,
            ..with_work(4)
        };
        counts(&scene, 2, &options).work
    });
    if let Some(first) = works.next() {
        assert!(works.all(|work| work == first));
    }
}
