//! Verdicts against many samples, and against each other.

mod division;
mod rims;

use super::border::{border, over_width};
use super::surface::Solid;
use super::*;
use crate::emitter::Emitter;
use crate::math::{Normal, Point};
use crate::render::{Job, Options, Renderer};
use crate::scene::Scene;
use crate::simd::SimdLevel;
use crate::visibility::{ShaftQuestion, object_and_triangle};
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
    verdicts_to(TARGET, world, camera, visibility, simd, windows)
}

fn verdicts_to(
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
    window: Window,
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
    let verdicts = verdicts(world, camera, visibility, simd, &[window]);
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
            Verdict::Interpolated { mean, error, .. } => {
                counts[0] += 1;
                (mean, error, 1e-5)
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
            let window = Window::whole(RESOLUTION);
            let counts = bounds_hold_of(name, window, world, camera, visibility);
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
        let window = Window::whole(RESOLUTION);
        let [smooth, integrated, _] = bounds_hold_of("disks", window, &world, &camera, &visibility);
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
            bounds_hold_of(light, window, &world, &camera, &visibility);
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

/// A camera above the plane z = 0 that looks down on it, whose pixel in column 8 and row 7 is from 0 to 1 in x and in y;
/// and triangles by their numbers.
fn from_above<T>(
    triangles: &[[[f64; 3]; 3]],
    work: impl FnOnce(&Quadrature<'_>, &View, &[u64]) -> T,
) -> T {
    let mut scene = "
        [image]
        resolution = [16, 16]
        [camera.orthographic]
        eye = [0, 0, 9]
        look_at = [0, 0, 0]
        height = 16
        [materials.m.phong]
        diffuse = 0.5
        [lights.l.point]
        position = [0, 0, 10]
        intensity = 100
    "
    .to_owned();
    for (number, vertices) in triangles.iter().enumerate() {
        scene +=
            &format!("[objects.t{number}.triangle]\nmaterial = 'm'\nvertices = {vertices:?}\n");
    }
    let (world, camera) = World::new(&Scene::parse(&scene, "above.toml").unwrap()).unwrap();
    let visibility = Visibility::new(&world, &Plan::new(&world));
    let simd = SimdLevel::default();
    let mut quadrature = Quadrature::new(&world, &camera, &visibility, simd, TARGET, true);
    let shaft = quadrature.window(aligned([0, 0], 16));
    quadrature.ask(&shaft, ShaftQuestion::Contents, u64::MAX, 16);
    let mut shapes = quadrature.space.list.clone();
    // In the order of the file.
    shapes.sort_by_key(|&shape| object_and_triangle(shape).0);
    let view = View::new(&camera, aligned([8, 7], 1));
    work(&quadrature, &view, &shapes)
}

/// A triangle that is all of the pixel up to x at one side of it, at these heights there and at the other corner.
fn up_to(x: f64, [near, far]: [f64; 2]) -> [[f64; 3]; 3] {
    [[x, -7.0, near], [x, 7.0, near], [-7.0, 0.0, far]]
}

#[test]
fn what_is_covered_is_dropped() {
    let front = up_to(0.5, [1.0; 2]);
    let beside = [[0.5, -7.0, 1.0], [0.5, 7.0, 1.0], [7.0, 0.0, 1.0]];
    for (others, kept) in [
        // Behind it, and no wider.
        (vec![up_to(0.4, [0.0; 2])], vec![0]),
        (vec![up_to(0.5, [0.0; 2])], vec![0]),
        (vec![up_to(0.4, [0.5, 1.0])], vec![0]),
        // Wider: a strip of it is seen.
        (vec![up_to(0.6, [0.0; 2])], vec![0, 1]),
        // Before it, in its plane, and through it.
        (vec![up_to(0.4, [2.0; 2])], vec![0, 1]),
        (vec![up_to(0.4, [1.0; 2])], vec![0, 1]),
        (vec![up_to(0.4, [0.0, 2.0])], vec![0, 1]),
        // Behind two that have an edge in common nothing is seen, which is in the middle of the pixel here.
        (vec![beside, up_to(0.6, [0.0; 2])], vec![0, 1]),
        (vec![beside, up_to(0.4, [2.0; 2])], vec![0, 1, 2]),
        // What is before both covers one of them.
        (vec![beside, up_to(0.6, [2.0; 2])], vec![1, 2]),
    ] {
        let triangles: Vec<_> = [front].into_iter().chain(others.clone()).collect();
        from_above(&triangles, |quadrature, view, shapes| {
            assert_eq!(shapes.len(), triangles.len());
            let mut left = shapes.to_vec();
            quadrature.drop_covered(view, &mut left);
            let expected: Vec<u64> = kept.iter().map(|&number: &usize| shapes[number]).collect();
            assert_eq!(left, expected, "{others:?}");
        });
    }
}

/// Past an edge 1 above the plane, what is seen of a light 4 above it moves three times as far as the eye does: that part
/// of the light comes into view from one side of the pixel to the other, and that of its diagonal is the most.
#[test]
fn borders_move_across_a_light() {
    let down = Normal::new(-DVec3::Z).unwrap();
    let middle = Point::new(0.5, 0.5, 4.0);
    let (a, b) = (DVec3::new(0.0, 5.0, 0.0), DVec3::new(20.0, 0.0, 0.0));
    let rectangle = Emitter::rectangle(middle, [a, b], false).unwrap();
    let disk = Emitter::disk(middle, down, 20.0, false).unwrap();
    let globe = Emitter::sphere(middle, 0.5).unwrap();
    from_above(&[up_to(0.5, [1.0; 2])], |_, view, _| {
        let plane = Solid::Plane {
            point: DVec3::ZERO,
            normal: DVec3::Z,
        };
        let surface = Surface::new(view, &plane).unwrap();
        let edge = |height: f64| Solid::Triangle {
            corners: [[0.5, -7.0], [0.5, 7.0], [-7.0, 0.0]].map(|[x, y]| DVec3::new(x, y, height)),
            normal: DVec3::Z,
            normals: None,
            is_lifted: false,
        };
        let most = |emitter: &Emitter, solids: &[Solid]| {
            border(&surface, emitter, &solids.iter().copied())
        };
        for (emitter, size) in [(&rectangle, 10.0), (&disk, 40.0), (&globe, 1.0)] {
            assert_eq!(most(emitter, &[]), 0.0);
            // How far it moves at least, as a part of the light, and not 20 times that.
            for height in [2.0, 3.0, 3.5] {
                let least = (4.0 - height) / height / size;
                let found = most(emitter, &[edge(height)]);
                assert!(
                    found >= least && found <= 20.0 * least,
                    "{height}: {found} {least}"
                );
                // The widest of several counts.
                assert_eq!(most(emitter, &[edge(3.9), edge(height)]), found);
            }
            // What the points may touch may hide all of it from one and nothing from another.
            assert_eq!(most(emitter, &[edge(1.0)]), f64::INFINITY);
            // Below the horizon nothing is hidden, nor so far beyond the light.
            assert_eq!(most(emitter, &[edge(-0.1)]), 0.0);
            assert_eq!(most(emitter, &[edge(6.0)]), 0.0);
            // Where another triangle goes on, there is no border.
            let beyond = Solid::Triangle {
                corners: [[0.5, 7.0], [0.5, -7.0], [8.0, 0.0]].map(|[x, y]| DVec3::new(x, y, 2.0)),
                normal: DVec3::Z,
                normals: None,
                is_lifted: false,
            };
            let alone = most(emitter, &[edge(2.0)]);
            assert!(most(emitter, &[beyond, edge(2.0)]) < alone);
            // A ball that stands on the plane 3 m away is touched by lines of 3 m. Points are √2 m apart at most.
            let ball = Solid::Sphere {
                center: DVec3::new(3.5, 0.5, 1.0),
                radius: 1.0,
            };
            let nearest = 3.0 - 2.0_f64.sqrt();
            let moved = 2.0_f64.sqrt() * (4.0 - nearest) / nearest;
            assert!((most(emitter, &[ball]) / (moved * over_width(emitter)) - 1.0).abs() < 1e-13);
        }
    });
}

/// Where a ball touches the floor, and as far from there as nothing is seen of a light past the ball, all is dark, and that
/// is proven although the ball is as near as can be.
#[test]
fn it_is_dark_below_a_ball() {
    for light in [
        "disk]\ndirection = [0, -1, 0]\nradius = 0.5",
        "rectangle]\ndirection = [0, -1, 0]\nsize = [0.7, 0.6]",
        "sphere]\nradius = 0.5",
    ] {
        let scene = format!(
            "[image]\nresolution = [96, 54]\n\
             [camera.perspective]\neye = [0, 0.4, 3]\nlook_at = [0, 0.1, 0.3]\nvertical_fov = 20\n\
             [materials.m.phong]\ndiffuse = 0.5\nspecular = 0.2\nshininess = 8\n\
             [lights.l.{light}\ncenter = [0, 6, 0]\nluminance = 100\n\
             [objects.floor.plane]\nmaterial = 'm'\npoint = [0, 0, 0]\nnormal = [0, 1, 0]\n\
             [objects.ball.sphere]\nmaterial = 'm'\ncenter = [0, 1, 0]\nradius = 1\n"
        );
        let (world, camera) = World::new(&Scene::parse(&scene, "ball.toml").unwrap()).unwrap();
        let visibility = Visibility::new(&world, &Plan::new(&world));
        let window = Window::whole(RESOLUTION);
        bounds_hold_of(light, window, &world, &camera, &visibility);
        let simd = SimdLevel::default();
        let told = verdicts(&world, &camera, &visibility, simd, &[window]);
        let anchor = world.anchor();
        let center = DVec3::Y - anchor;
        let mut dark = 0;
        for ([x, y], verdict) in window.pixels().zip(told) {
            // Two tangents, of the ball and the light, meet the floor further away than this.
            let is_below = [[0, 0], [1, 0], [0, 1], [1, 1]]
                .iter()
                .all(|[right, down]| {
                    let ray = camera.ray(f64::from(x + right), f64::from(y + down));
                    let (from, way) = (ray.origin.0, ray.direction);
                    let floor = from - way * ((from.y + anchor.y) / way.y);
                    let nearest = from + way * ((center - from).dot(way) / way.length_squared());
                    way.y < 0.0
                        && (floor + anchor).length() < 0.8
                        && (nearest - center).length() > 1.0
                });
            if is_below {
                dark += 1;
                let is_dark = matches!(
                    verdict,
                    Verdict::Smooth {
                        side: 1,
                        error: [0.0, 0.0, 0.0],
                        is_bound: true,
                        ..
                    } | Verdict::Interpolated {
                        mean: [0.0, 0.0, 0.0, 1.0],
                        error: [0.0, 0.0, 0.0, 0.0],
                        is_bound: true,
                    }
                );
                assert!(is_dark, "{light}: {x}, {y}: {verdict:?}");
            }
        }
        assert!(dark > 100, "{light}: {dark}");
    }
}

/// Under a panel most pixels are told by the nodes of squares, whatever the window and the instructions; what is proven
/// holds, and what is estimated too, against exact samples.
#[test]
fn squares_are_interpolated_under_lights_with_an_area() {
    const TARGET: Target = Target {
        relative: 0.1,
        floor: 1.0,
        most_side: 1,
    };
    let mut scene = Scene::load(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/room.toml")).unwrap();
    scene.image.resolution.value = [640, 360];
    let (world, camera) = World::new(&scene).unwrap();
    let visibility = Visibility::new(&world, &Plan::new(&world));
    // A part of the floor, the boxes and the balls.
    let window = Window {
        x: 208,
        y: 200,
        width: 208,
        height: 150,
    };
    let told =
        |simd, windows: &[Window]| verdicts_to(TARGET, &world, &camera, &visibility, simd, windows);
    let first = told(SimdLevel::default(), &[window]);
    let rows: Vec<Window> = (window.y..window.y + window.height)
        .map(|y| Window {
            y,
            height: 1,
            ..window
        })
        .collect();
    assert!(first == told(SimdLevel::default(), &rows));
    for (_, level) in SimdLevel::available() {
        assert!(first == told(level, &[window]));
    }
    let options = Options {
        samples: 64,
        window: Some(window),
        ..Options::default()
    };
    let renderer = Renderer::new(&world).unwrap();
    let film = renderer.film(&camera, &options, &Job::new()).unwrap().0;
    let (mut proven, mut estimated) = (0, 0);
    for ((verdict, truth), place) in first.iter().zip(film.pixels()).zip(window.pixels()) {
        let Verdict::Interpolated {
            mean,
            error,
            is_bound,
        } = *verdict
        else {
            continue;
        };
        *if is_bound {
            &mut proven
        } else {
            &mut estimated
        } += 1;
        for channel in 0..4 {
            let off = (mean[channel] - f64::from(truth[channel])).abs();
            // Of 64 samples where it is smooth: twice what is measured.
            assert!(
                off <= error[channel] + 2e-4,
                "{place:?}: {verdict:?} {truth:?}"
            );
        }
    }
    assert!(proven > 10_000 && estimated > 3000, "{proven} {estimated}");
}
