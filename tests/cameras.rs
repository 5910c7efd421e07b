//! One world, many cameras: what a camera shows does not depend on what was built for which.

use candela::Camera;
use candela::image::{Film, Window};
use candela::render::{Job, Layers, Options, Renderer};
use candela::scene::{self, Scene};
use candela::world::World;

use crate::images::{film_of, parse};

/// A dome that the camera may be in or out of, a ball with a light in it, flat shapes, and two lights.
const SCENE: &str = r#"
[image]
resolution = [48, 32]

[camera.perspective]
eye = [0.3, 1.2, 6.1]
look_at = [100.25, -3.5, 7.125]
vertical_fov = 50

[materials.clay.phong]
diffuse = [0.7, 0.4, 0.2]
specular = 0.3
shininess = 20

[lights.key.point]
position = [101, 2, 8]
intensity = 20

[lights.within.point]
position = [99, -3, 7]
intensity = 5

[objects.dome.sphere]
material = "clay"
center = [100, -3, 7]
radius = 9

[objects.ball.sphere]
material = "clay"
center = [99, -3, 7]
radius = 0.8

[objects.floor.plane]
material = "clay"
point = [100, -4, 7]
normal = [0, 1, 0]

[objects.sail.triangle]
material = "clay"
vertices = [[101, -4, 5], [103, -4, 6], [102, 0, 5.5]]
"#;

/// Cameras outside of everything, in the dome, in the ball, on the dome, and with parallel rays.
fn cameras() -> Vec<scene::Camera> {
    use scene::Camera;
    let middle = [100.25, -3.5, 7.125];
    vec![
        Camera::perspective([130.0, 20.0, 31.0], middle, 30.0),
        Camera::perspective([104.0, -2.0, 10.0], middle, 70.0).up([0.1, 1.0, 0.2]),
        Camera::perspective([99.1, -2.9, 7.2], middle, 110.0),
        Camera::perspective([109.0, -3.0, 7.0], middle, 90.0),
        Camera::orthographic([120.0, 5.0, 7.0], middle, 20.0),
        Camera::orthographic([101.0, -3.0, 8.0], middle, 3.0),
    ]
}

fn bits(film: &Film) -> Vec<u32> {
    let pixels = film.pixels().as_flattened().iter().copied();
    let values = film.pixels().iter().enumerate();
    let values = values.flat_map(|(pixel, _)| film.values(pixel));
    pixels.chain(values).map(f32::to_bits).collect()
}

fn options(window: Option<Window>) -> Options {
    Options {
        samples: 3,
        window,
        layers: Layers {
            lights: true,
            depth: true,
            normal: true,
            ..Layers::default()
        },
        ..Options::default()
    }
}

fn film(renderer: &Renderer<'_>, camera: &Camera, options: &Options) -> Film {
    renderer.film(camera, options, &Job::new()).unwrap().0
}

/// Cameras placed in one world show the bits that the scene with each of them has, which is read, built
/// and rendered on its own: all of them look at the anchor. Nothing is left of what was rendered before.
#[test]
fn a_placed_camera_shows_what_a_scene_with_it_shows() {
    let scene = parse(SCENE);
    let (world, _) = World::new(&scene).unwrap();
    let renderer = Renderer::new(&world).unwrap();
    for camera in cameras() {
        let placed = renderer.world().place(&camera, [48, 32]).unwrap();
        let shown = film(&renderer, &placed, &options(None));
        let mut other = scene.clone();
        other.camera.value = camera;
        let (world, its_own) = World::new(&other).unwrap();
        assert_eq!(placed, its_own);
        let expected = candela::render(&world, &its_own, &options(None)).unwrap();
        assert_eq!(bits(&shown), bits(&expected), "{:?}", other.camera.value);
        assert_eq!(
            shown.metadata().world_to_camera,
            expected.metadata().world_to_camera
        );
    }
}

/// The anchor is the scene's, whatever a camera looks at: a camera that looks elsewhere shows the same
/// bits in the world whose pictures came before and in one that was just built; and so does a part.
#[test]
fn a_camera_that_looks_elsewhere_shows_the_same_in_any_process() {
    let elsewhere = scene::Camera::perspective([97.3, -1.7, 12.4], [98.1, -2.9, 6.3], 80.0);
    let (world, camera) = World::new(&parse(SCENE)).unwrap();
    let used = Renderer::new(&world).unwrap();
    film(&used, &camera, &options(None));
    let place = |renderer: &Renderer| renderer.world().place(&elsewhere, [48, 32]).unwrap();
    let placed = place(&used);
    assert_eq!(placed.anchor().to_array(), [100.25, -3.5, 7.125]);
    let whole = film(&used, &placed, &options(None));
    let (world, _) = World::new(&parse(SCENE)).unwrap();
    let other = Renderer::new(&world).unwrap();
    let expected = film(&other, &place(&other), &options(None));
    assert_eq!(bits(&whole), bits(&expected));
    let window = Window {
        x: 17,
        y: 5,
        width: 20,
        height: 19,
    };
    let part = film(&used, &placed, &options(Some(window)));
    for (pixel, [x, y]) in window.pixels().enumerate() {
        let in_whole = (y * 48 + x) as usize;
        assert_eq!(part.pixels()[pixel], whole.pixels()[in_whole]);
    }
}

/// As a scene made in code with that camera would be told.
#[test]
fn a_camera_that_cannot_be_placed_is_an_error() {
    let (world, _) = World::new(&Scene::builtin()).unwrap();
    let refused = |camera: scene::Camera, resolution: [u32; 2]| {
        let error = world.place(&camera, resolution).unwrap_err();
        error.list()[0].to_string()
    };
    let legal = || scene::Camera::perspective([0.0, 1.0, 4.0], [0.0; 3], 40.0);
    for (camera, resolution, said) in [
        (legal(), [0, 9], "resolution"),
        (legal(), [9, 65_537], "resolution"),
        (
            scene::Camera::perspective([0.0; 3], [0.0; 3], 40.0),
            [9, 9],
            "same point",
        ),
        (
            scene::Camera::perspective([0.0; 3], [1.0; 3], 180.0),
            [9, 9],
            "vertical_fov",
        ),
        (
            scene::Camera::orthographic([0.0; 3], [1.0; 3], -1.0),
            [9, 9],
            "height",
        ),
        (legal().up([0.0, 1.0, 4.0]), [9, 9], "along the view"),
        (legal().up([f64::NAN; 3]), [9, 9], "`up`"),
    ] {
        let message = refused(camera, resolution);
        assert!(message.contains(said), "{said}: {message}");
    }
}

/// The camera is no part of what is built: a scene is the same world whoever looks.
#[test]
fn a_world_is_rendered_as_its_scene_says() {
    let scene = parse(SCENE);
    let (world, camera) = World::new(&scene).unwrap();
    let renderer = Renderer::new(&world).unwrap();
    let one = Options::default();
    assert_eq!(
        bits(&film(&renderer, &camera, &one)),
        bits(&film_of(&scene, 1))
    );
}
