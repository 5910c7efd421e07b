//! Verdicts against many samples, and against each other.

use super::*;
use crate::render::{Job, Options, Renderer};
use crate::scene::Scene;
use crate::simd::SimdLevel;
use crate::world::Plan;

const RESOLUTION: [u32; 2] = [96, 54];

const TARGET: Target = Target {
    relative: 0.01,
    floor: 0.003,
    most_side: 8,
};

/// Works with a scene of the repository, small.
fn with_scene<T>(name: &str, work: impl FnOnce(&World, &Camera, &Visibility<'_>) -> T) -> T {
    let path = format!("{}/scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let mut scene = Scene::load(&path).unwrap();
    scene.image.resolution.value = RESOLUTION;
    let (world, camera) = World::new(&scene).unwrap();
    let visibility = Visibility::new(&world, &Plan::new(&world));
    work(&world, &camera, &visibility)
}

fn verdicts(
    world: &World,
    camera: &Camera,
    visibility: &Visibility<'_>,
    simd: SimdLevel,
    windows: &[Window],
) -> Vec<Verdict> {
    verdicts_for(TARGET, world, camera, visibility, simd, windows)
}

fn verdicts_for(
    target: Target,
    world: &World,
    camera: &Camera,
    visibility: &Visibility<'_>,
    simd: SimdLevel,
    windows: &[Window],
) -> Vec<Verdict> {
    let mut quadrature = Quadrature::new(world, camera, visibility, simd, target, true);
    let mut all = Vec::new();
    for &window in windows {
        let mut verdicts = Vec::new();
        quadrature.tell(window, &mut verdicts);
        all.extend(verdicts);
    }
    all
}

/// Bounds hold of the means over 4096 samples, which are themselves off by up to 4e-3 where there is an edge; how
/// many pixels are told by one sample, integrated, and neither.
#[track_caller]
fn bounds_hold_of(
    name: &str,
    (target, window): (Target, Window),
    world: &World,
    camera: &Camera,
    visibility: &Visibility<'_>,
) -> [u32; 3] {
    let renderer = Renderer::new(world).unwrap();
    let film = |samples| {
        let options = Options {
            samples,
            window: Some(window),
            ..Options::default()
        };
        renderer.film(camera, &options, &Job::new()).unwrap().0
    };
    let (centers, many) = (film(1), film(4096));
    let simd = SimdLevel::default();
    let verdicts = verdicts_for(target, world, camera, visibility, simd, &[window]);
    let mut counts = [0; 3];
    for (pixel, verdict) in verdicts.iter().enumerate() {
        let truth = many.pixels()[pixel].map(f64::from);
        let (mean, error, room) = match *verdict {
            Verdict::Smooth {
                side: 1,
                error: [r, g, b],
                ..
            } => {
                counts[0] += 1;
                let center = centers.pixels()[pixel].map(f64::from);
                (center, [r, g, b, 0.0], 1e-5)
            }
            Verdict::Integrated { mean, error, .. } => {
                counts[1] += 1;
                (mean, error, 4e-3)
            }
            Verdict::Smooth { .. } | Verdict::Open { .. } => {
                counts[2] += 1;
                continue;
            }
        };
        // What is on both sides of an edge is in the pixels around it too.
        let [x, y] = [pixel as u32 % window.width, pixel as u32 / window.width];
        let around = |place: u32, size: u32| place.saturating_sub(1)..(place + 2).min(size);
        let neighbors = around(y, window.height).flat_map(|y| {
            let row = y * window.width;
            around(x, window.width).map(move |x| (row + x) as usize)
        });
        let neighbors: Vec<usize> = neighbors.collect();
        for channel in 0..4 {
            let near = neighbors
                .iter()
                .map(|&place| f64::from(many.pixels()[place][channel]));
            let room = room * near.fold(mean[channel], f64::max).max(TARGET.floor);
            let off = (truth[channel] - mean[channel]).abs();
            assert!(
                off <= error[channel] + room,
                "{name}, pixel {pixel}: {truth:?} {verdict:?}"
            );
        }
    }
    counts
}

#[test]
fn bounds_hold() {
    for name in [
        "lecture",
        "many-spheres",
        "shadows",
        "spot",
        "orthographic",
        "mesh",
    ] {
        with_scene(name, |world, camera, visibility| {
            let counts = bounds_hold_of(
                name,
                (TARGET, Window::whole(RESOLUTION)),
                world,
                camera,
                visibility,
            );
            assert!(counts[0] > 0, "{name}: {counts:?}");
        });
    }
}

/// The silhouettes of disks, before each other and the floor, and the borders of their shadows.
#[test]
fn bounds_hold_of_disks() {
    for lens in [
        "perspective]\nvertical_fov = 45",
        "orthographic]\nheight = 4",
    ] {
        let scene = format!(
            "[image]\nresolution = [96, 54]\n\
             [camera.{lens}\neye = [0, 3, 5]\nlook_at = [0, 0.3, 0]\n\
             [materials.m.phong]\ndiffuse = 0.5\n\
             [lights.l.point]\nposition = [1, 6, 2]\nintensity = 100\n\
             [lights.k.point]\nposition = [-4, 3, 1]\nintensity = 40\n\
             [objects.floor.plane]\nmaterial = 'm'\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n"
        );
        let scene = Scene::parse(&scene, "disks.toml").unwrap();
        let (mut world, camera) = World::new(&scene).unwrap();
        for (center, normal, radius) in [
            ([0.0, 1.0, 0.0], [0.0, 1.0, 0.0], 0.6),
            ([0.9, 0.5, 0.3], [0.3, 1.0, 0.4], 0.4),
            ([-1.0, 0.7, 0.2], [1.0, 0.3, 0.5], 0.5),
            ([-0.2, 0.3, 1.0], [0.0, 0.1, 1.0], 0.25),
        ] {
            let center = DVec3::from_array(center) - world.anchor();
            world.add_disk(center, DVec3::from_array(normal), radius);
        }
        let visibility = Visibility::new(&world, &Plan::new(&world));
        let [smooth, integrated, _] = bounds_hold_of(
            "disks",
            (TARGET, Window::whole(RESOLUTION)),
            &world,
            &camera,
            &visibility,
        );
        assert!(smooth > 1000 && integrated > 50, "{smooth} {integrated}");
    }
}

/// Under lights with an area: what each shape receives of each, cut by its horizon or not, glossy or not, and both
/// sides of silhouettes under and before them.
#[test]
fn bounds_hold_under_lights_with_an_area() {
    let lights = [
        "rectangle]\nlook_at = [0, 0, 0]\nsize = [1.5, 0.8]",
        "disk]\nlook_at = [0.5, 0, 0]\nradius = 0.7\ntwo_sided = true",
        "sphere]\nradius = 0.6",
        // A part of it is below the floor.
        "rectangle]\ndirection = [0.3, 0.1, 1]\nsize = [1.5, 6]",
    ];
    for (light, lens) in lights.iter().zip([
        "perspective]\nvertical_fov = 40",
        "orthographic]\nheight = 3",
        "perspective]\nvertical_fov = 55",
        "perspective]\nvertical_fov = 40",
    ]) {
        let scene = format!(
            "[image]\nresolution = [192, 108]\nbackground = [0.1, 0.2, 0.3]\n\
             [camera.{lens}\neye = [0, 2, 5]\nlook_at = [0, 0.8, 0]\n\
             [materials.dull.phong]\ndiffuse = [0.3, 0.2, 0.1]\n\
             [materials.bright.phong]\ndiffuse = 0.1\nspecular = 0.5\nshininess = 30\n\
             [materials.satin.normalized_phong]\ndiffuse = 0.3\nspecular = 0.4\nshininess = 9.5\n\
             [lights.l.{light}\ncenter = [0.4, 2.3, -1.5]\nluminance = [4, 3, 2]\n\
             [objects.floor.plane]\nmaterial = 'satin'\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n\
             [objects.wall.plane]\nmaterial = 'dull'\npoint = [0, 0, -2.5]\nnormal = [0.3, 0, 1]\n\
             [objects.stand.triangle]\nmaterial = 'dull'\n\
             vertices = [[-2.5, 0, -0.8], [-1.2, 0, -0.5], [-2, 1.2, -0.9]]\n\
             [objects.ball.sphere]\nmaterial = 'bright'\ncenter = [-0.9, 0.6, 0.3]\nradius = 0.6\n\
             [objects.bead.sphere]\nmaterial = 'dull'\ncenter = [0.1, 0.3, 1.5]\nradius = 0.3\n\
             [objects.card.triangle]\nmaterial = 'bright'\n\
             vertices = [[0.3, 0.1, 0.2], [1.5, 0.2, 0.1], [0.9, 1.4, -0.3]]\n"
        );
        let scene = Scene::parse(&scene, "areas.toml").unwrap();
        let (world, camera) = World::new(&scene).unwrap();
        let visibility = Visibility::new(&world, &Plan::new(&world));
        // Before the ball and the triangle that stands on the floor.
        let window = Window {
            x: 40,
            y: 52,
            width: 64,
            height: 24,
        };
        let [smooth, integrated, open] =
            bounds_hold_of(light, (TARGET, window), &world, &camera, &visibility);
        assert!(
            smooth > 200 && integrated > 10,
            "{light}: {smooth} {integrated} {open}"
        );
    }
}

/// What is told of a pixel depends on its place in the image alone.
#[test]
fn windows_and_instructions_make_no_difference() {
    with_scene("lecture", |world, camera, visibility| {
        let [width, height] = RESOLUTION;
        let rows: Vec<Window> = (0..height)
            .map(|y| Window {
                x: 0,
                y,
                width,
                height: 1,
            })
            .collect();
        let whole = [Window::whole(RESOLUTION)];
        let first = verdicts(world, camera, visibility, SimdLevel::default(), &whole);
        assert!(first == verdicts(world, camera, visibility, SimdLevel::default(), &rows));
        for (_, level) in SimdLevel::available() {
            assert!(first == verdicts(world, camera, visibility, level, &whole));
        }
    });
}

/// Nothing is missed, however small: a ball of a thousandth of a pixel in view leaves its pixel open.
#[test]
fn what_no_sample_meets_is_told() {
    let scene = "
        [image]
        resolution = [16, 16]
        [camera.orthographic]
        eye = [0, 0, 1]
        look_at = [0, 0, 0]
        height = 16
        [materials.m.phong]
        diffuse = 0.5
        [lights.l.point]
        position = [0, 0, 10]
        intensity = 100
        [objects.dust.sphere]
        material = 'm'
        center = [2.3, 3.1, 0]
        radius = 0.0005
    ";
    let (world, camera) = World::new(&Scene::parse(scene, "dust.toml").unwrap()).unwrap();
    let visibility = Visibility::new(&world, &Plan::new(&world));
    let window = Window::whole([16, 16]);
    let told = verdicts(
        &world,
        &camera,
        &visibility,
        SimdLevel::default(),
        &[window],
    );
    for ([x, y], verdict) in window.pixels().zip(told) {
        let is_background = verdict
            == Verdict::Smooth {
                side: 1,
                error: [0.0; 3],
                is_bound: true,
                relative: 0.0,
            };
        // x = 2.3 is in column 10, y = 3.1 in row 4.
        assert_eq!(is_background, [x, y] != [10, 4], "{x}, {y}: {verdict:?}");
    }
}

/// The border of a sharp cone is an edge, though no shape makes it: 10 m below the lamp, 18° are 3.25 m.
#[test]
fn the_border_of_a_spot_is_an_edge() {
    let scene = "
        [image]
        resolution = [16, 16]
        [camera.orthographic]
        eye = [0, 0, 20]
        look_at = [0, 0, 0]
        height = 16
        [materials.m.phong]
        diffuse = 0.5
        [lights.l.spot]
        position = [0, 0, 10]
        look_at = [0, 0, 0]
        intensity = 100
        inner = 18
        outer = 18
        [objects.floor.plane]
        material = 'm'
        point = [0, 0, 0]
        normal = [0, 0, 1]
    ";
    let (world, camera) = World::new(&Scene::parse(scene, "spot.toml").unwrap()).unwrap();
    let visibility = Visibility::new(&world, &Plan::new(&world));
    let window = Window::whole([16, 16]);
    let told = verdicts(
        &world,
        &camera,
        &visibility,
        SimdLevel::default(),
        &[window],
    );
    // From the middle of the image to the nearest and the furthest point of a pixel.
    let radius = 10.0 * 18.0_f64.to_radians().tan();
    let mut borders = 0;
    for ([x, y], verdict) in window.pixels().zip(told) {
        let [x, y] = [x, y].map(|place| (f64::from(place) - 7.5).abs());
        let is_border = (x - 0.5).hypot(y - 0.5) < radius && radius < (x + 0.5).hypot(y + 0.5);
        if is_border {
            borders += 1;
            assert!(
                matches!(
                    verdict,
                    Verdict::Open {
                        is_smooth: false,
                        ..
                    }
                ),
                "{x}, {y}: {verdict:?}"
            );
        }
    }
    assert!(borders > 10);
}
