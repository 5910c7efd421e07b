//! Frames of a scene: what is built for one is kept for the next, as far as it stays where it is.

use std::path::Path;
use std::sync::Arc;

use candela::image::Film;
use candela::render::{Job, Layers, Options, Renderer};
use candela::scene::{Camera, Image, Light, Material, MeshFile, Object, Placement, Scene, Value};
use candela::world::World;

/// A bumpy sheet of 2 · 40² triangles around the origin, and what is closer to a dragon: as many in a knot of folds.
fn sheet(folds: f64) -> Arc<MeshFile> {
    const SIDE: usize = 41;
    let mut text = String::new();
    for row in 0..SIDE {
        for column in 0..SIDE {
            let [x, z] = [column, row].map(|place| place as f64 / 20.0 - 1.0);
            let y = 0.25 * (folds * x).sin() * (folds * z + x).cos();
            text += &format!("v {x} {y} {z}\n");
        }
    }
    for row in 1..SIDE {
        for column in 1..SIDE {
            let corner = |row: usize, column: usize| (row - 1) * SIDE + column;
            let [a, b] = [corner(row, column), corner(row, column + 1)];
            let [c, d] = [corner(row + 1, column), corner(row + 1, column + 1)];
            text += &format!("f {a} {b} {d}\nf {a} {d} {c}\n");
        }
    }
    Arc::new(MeshFile::parse(text.as_bytes(), Path::new("sheet.obj")).unwrap())
}

fn at(place: [f64; 3], degrees: f64) -> Placement {
    Placement {
        rotate: [degrees, 20.0, 0.0],
        translate: place,
        ..Placement::default()
    }
}

/// Sheets at places, which may go through each other, some loose triangles, and as many spheres as take a tree.
fn scene(sheets: &[(Arc<MeshFile>, Placement)]) -> Scene {
    let mut scene = Scene::new(
        Image::new(64, 48).background(0.1),
        Camera::perspective([0.3, 2.5, 5.0], [0.0, 0.0, 0.0], 50.0),
    )
    .material("clay", Material::phong(0.5).specular(0.2, 30.0))
    .light("key", Light::point([3.0, 4.0, 3.0], 30.0))
    .light(
        "low",
        Light::point([-3.0, 0.6, 2.0], Value::from([5.0, 8.0, 9.0])),
    );
    for (number, (sheet, placement)) in sheets.iter().enumerate() {
        let object = Object::mesh("clay", Arc::clone(sheet), *placement);
        scene = scene.object(format!("sheet {number}"), object);
    }
    for number in 0..20 {
        let [x, z] = [f64::from(number % 5), f64::from(number / 5)].map(|place| place * 0.6 - 1.2);
        let y = 0.8 + 0.1 * f64::from(number % 3);
        let corners = [[x, y, z], [x + 0.3, y, z + 0.1], [x + 0.1, y + 0.3, z]];
        scene = scene.object(format!("shard {number}"), Object::triangle("clay", corners));
    }
    for number in 0..70 {
        let [x, z] =
            [f64::from(number % 10), f64::from(number / 10)].map(|place| place * 0.5 - 2.0);
        scene = scene.object(
            format!("ball {number}"),
            Object::sphere("clay", [x, -0.9, z], 0.15),
        );
    }
    scene
}

fn shown(renderer: &Renderer<'_>, camera: &candela::Camera) -> Vec<u32> {
    let options = Options {
        samples: 4,
        layers: Layers {
            lights: true,
            depth: true,
            normal: true,
            ..Layers::default()
        },
        ..Options::default()
    };
    let (film, _): (Film, _) = renderer.film(camera, &options, &Job::new()).unwrap();
    let values = (0..film.pixels().len()).flat_map(|pixel| film.values(pixel));
    let all = film.pixels().as_flattened().iter().copied().chain(values);
    all.map(f32::to_bits).collect()
}

/// A camera that moves around a mesh builds nothing: trees are built with the renderer, and it counts them.
#[test]
fn a_camera_that_moves_builds_nothing() {
    let (world, camera) = World::new(&scene(&[(sheet(9.0), at([0.0; 3], 10.0))])).unwrap();
    let renderer = Renderer::new(&world).unwrap();
    // The sheet, the shards and the spheres.
    assert_eq!(renderer.trees_built(), 3);
    let first = shown(&renderer, &camera);
    let moved = Camera::perspective([2.0, 2.0, 4.0], [0.0, 0.0, 0.0], 40.0);
    let moved = world.place(&moved, [64, 48]).unwrap();
    assert_ne!(shown(&renderer, &moved), first);
    assert_eq!(renderer.trees_built(), 3);
    // A renderer that is made again for the same world has it all.
    let again = renderer.again(&world).unwrap();
    assert_eq!(again.trees_built(), 0);
    assert_eq!(shown(&again, &camera), first);
}

/// Of three sheets one moves: it alone is built, and the picture is that of a world of its own.
#[test]
fn what_stays_is_kept_from_frame_to_frame() {
    let sheets = [sheet(9.0), sheet(5.0), sheet(14.0)];
    let frame = |height: f64| {
        let places = [[-0.9, 0.0, 0.0], [0.9, height, 0.2], [0.0, 0.3, -0.8]];
        let placed = sheets.iter().zip(places).zip([10.0, 40.0, -30.0]);
        let placed = placed.map(|((sheet, place), turn)| (Arc::clone(sheet), at(place, turn)));
        scene(&placed.collect::<Vec<_>>())
    };
    let (world, camera) = World::new(&frame(0.0)).unwrap();
    let renderer = Renderer::new(&world).unwrap();
    assert_eq!(renderer.trees_built(), 5);
    let (next_world, next_camera) = World::new(&frame(0.4)).unwrap();
    let next = renderer.again(&next_world).unwrap();
    assert_eq!(next.trees_built(), 1);
    let anew = Renderer::new(&next_world).unwrap();
    assert_eq!(anew.trees_built(), 5);
    let picture = shown(&next, &next_camera);
    assert!(picture == shown(&anew, &next_camera));
    assert!(picture != shown(&renderer, &camera));
    // And back again.
    let back = next.again(&world).unwrap();
    assert_eq!(back.trees_built(), 1);
    assert!(shown(&back, &camera) == shown(&renderer, &camera));
}

/// Lights, materials and the background are no part of what is built.
#[test]
fn light_builds_nothing() {
    let of = |height: f64| {
        let scene = scene(&[
            (sheet(9.0), at([0.0; 3], 10.0)),
            (sheet(4.0), at([0.4; 3], 50.0)),
        ]);
        scene.light("more", Light::point([0.0, height, 2.0], 5.0))
    };
    let (world, _) = World::new(&of(3.0)).unwrap();
    let renderer = Renderer::new(&world).unwrap();
    let (other_world, camera) = World::new(&of(2.0)).unwrap();
    let other = renderer.again(&other_world).unwrap();
    assert_eq!(other.trees_built(), 0);
    let anew = Renderer::new(&other_world).unwrap();
    assert!(shown(&other, &camera) == shown(&anew, &camera));
}
