//! Scenes that are made in code: what is wrong with them names the entry, and their hash is that of their
//! content.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

use candela::exr::ExrOptions;
use candela::mesh::{MeshGroup, MeshNormals};
use candela::output::Unfinished;
use candela::scene::{
    Camera, Entry, Image, Light, Lobes, Material, MeshFile, Object, Scene, Source, Span, Spanned,
    Transport, Value, View,
};
use candela::spectrum::{Curve, Observer};
use candela::world::Loaded;
use candela::{Options, World, render};

use crate::openimageio::oiiotool;

fn entry<T>(name: &str, value: T) -> Entry<T> {
    Entry {
        name: name.to_owned(),
        span: Span::default(),
        value,
    }
}

fn material(diffuse: f64) -> Material {
    Material::Phong(Lobes {
        diffuse: Value::Uniform(diffuse).into(),
        specular: Value::Uniform(0.25).into(),
        shininess: Some(9.0.into()),
        coat: None,
    })
}

fn ball(radius: f64) -> Object {
    Object::Sphere {
        material: "clay".to_owned().into(),
        center: [0.0, 0.0, 0.0].into(),
        radius: radius.into(),
    }
}

fn lamp(intensity: Value) -> Light {
    Light::Point {
        position: [1.0, 2.0, 3.0].into(),
        intensity: intensity.into(),
        group: None,
    }
}

fn triangle_mesh() -> MeshFile {
    MeshFile {
        positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        triangles: vec![[0, 1, 2]],
        ..MeshFile::default()
    }
}

fn mesh(geometry: MeshFile) -> Object {
    let source = "[image]\nresolution = [1, 1]\n[camera.orthographic]\neye = [0, 0, 1]\n\
                  look_at = [0, 0, 0]\nheight = 1\n[objects.o.mesh]\nmaterial = \"clay\"\n\
                  file = \"triangle.obj\"\n";
    // The object of a file, with another mesh and no places.
    let scene = Scene::parse(source, "tests/bad_scenes/mesh.toml").unwrap();
    let mut object = scene.objects.into_iter().next().unwrap().value;
    if let Object::Mesh {
        material,
        file,
        scale,
        rotate,
        translate,
        geometry: place,
        ..
    } = &mut object
    {
        *place = Arc::new(geometry);
        material.span = Span::default();
        file.span = Span::default();
        for vector in [scale, rotate, translate] {
            vector.span = Span::default();
        }
    }
    object
}

fn scene() -> Scene {
    Scene {
        source: Arc::new(Source::new("<code>".into(), String::new())),
        anchor: None,
        image: Image {
            resolution: [4, 3].into(),
            color_space: Spanned::default(),
            background: Value::ZERO.into(),
            transport: Transport::default().into(),
            observer: Observer::default().into(),
            max_depth: 8.0.into(),
        },
        camera: Camera::Orthographic {
            view: View {
                eye: [0.0, 0.0, 5.0].into(),
                look_at: [0.0, 0.0, 0.0].into(),
                up: [0.0, 1.0, 0.0].into(),
            },
            height: 3.0.into(),
        }
        .into(),
        materials: vec![entry("clay", material(0.5))],
        lights: vec![entry("key", lamp(Value::Uniform(10.0)))],
        objects: vec![
            entry("ball", ball(1.0)),
            entry("wing", mesh(triangle_mesh())),
        ],
        inputs: Vec::new(),
    }
}

/// What is wrong with the scene once it is changed.
fn errors(change: impl FnOnce(&mut Scene)) -> String {
    let mut scene = scene();
    change(&mut scene);
    match World::new(&scene) {
        Ok(_) => panic!("the scene is accepted"),
        Err(errors) => errors.to_string(),
    }
}

fn first_line(change: impl FnOnce(&mut Scene)) -> String {
    errors(change).lines().next().unwrap().to_owned()
}

#[test]
fn errors_name_the_entry() {
    assert_eq!(
        errors(|scene| scene.objects[0].value = ball(-1.0)),
        "error: object `ball`: `radius` is -1, expected a length above 0, in scene units\n\
         --> <code>"
    );
    assert_eq!(
        first_line(|scene| scene.lights[0].value = lamp(Value::Uniform(-3.0))),
        "error: light `key`: `intensity` is -3, expected a number from 0 to 3.4e38"
    );
    assert_eq!(
        first_line(|scene| scene.materials[0].value = material(2.0)),
        "error: material `clay`: `diffuse` is [2, 2, 2], expected at most 1 in every channel"
    );
    assert_eq!(
        first_line(|scene| scene.objects[1].name = "\u{1b}[31m".to_owned()),
        "error: `\\u{1b}[31m` cannot be the name of an object: names are made of letters, digits, \
         `_`, `-`, `.` and spaces"
    );
    assert_eq!(
        first_line(|scene| scene.image.resolution.value = [0, 5]),
        "error: the image: `resolution` is [0, 5], expected a width and a height from 1 to 65536 \
         pixels"
    );
    let height = |height: f64| {
        move |scene: &mut Scene| {
            if let Camera::Orthographic { height: place, .. } = &mut scene.camera.value {
                place.value = height;
            }
        }
    };
    assert_eq!(
        first_line(height(f64::NAN)),
        "error: the camera: `height` is NaN, expected a length above 0, in scene units"
    );
    let unknown = errors(|scene| scene.materials[0].name = "Clay".to_owned());
    let expected = "error: object `ball`: unknown material `clay`";
    assert!(unknown.starts_with(expected), "{unknown}");
    assert!(unknown.contains("`Clay`"), "{unknown}");
}

#[test]
fn names_are_there_once() {
    assert_eq!(
        first_line(|scene| scene.materials.push(entry("clay", material(0.1)))),
        "error: material `clay` is there twice"
    );
    assert_eq!(
        first_line(|scene| scene.lights.push(entry("key", lamp(Value::ZERO)))),
        "error: light `key` is there twice"
    );
    assert_eq!(
        first_line(|scene| scene.objects.push(entry("ball", ball(2.0)))),
        "error: object `ball` is there twice"
    );
    // But an object may have the name of a light.
    let mut fine = scene();
    fine.objects[0].name = "key".to_owned();
    assert!(World::new(&fine).is_ok());
    assert!(first_line(|scene| scene.lights[0].name.clear()).contains("an empty string"));
    let long = first_line(|scene| scene.lights[0].name = "x".repeat(201));
    assert!(long.ends_with("names are at most 200 bytes long"), "{long}");
}

#[test]
fn meshes_have_all_that_they_name() {
    let said = |change: fn(&mut MeshFile)| {
        let mut geometry = triangle_mesh();
        change(&mut geometry);
        let line = first_line(|scene| scene.objects[1].value = mesh(geometry));
        line.strip_prefix("error: object `wing`: ")
            .unwrap_or_else(|| panic!("{line}"))
            .to_owned()
    };
    for (change, expected) in [
        (
            (|mesh| mesh.triangles.push([0, 1, 3])) as fn(&mut MeshFile),
            "triangle 1 of the mesh names position 3, but the mesh has 3, counted from 0",
        ),
        (
            |mesh| mesh.triangles = vec![[u32::MAX, 0, 1]],
            "triangle 0 of the mesh names position 4294967295, but the mesh has 3, counted from 0",
        ),
        (
            |mesh| mesh.triangles.clear(),
            "the mesh has no triangles, expected at least one",
        ),
        (
            |mesh| mesh.positions[1][2] = f64::NAN,
            "position 1 of the mesh is [1.0, 0.0, NaN], expected three finite numbers",
        ),
        (
            |mesh| mesh.positions[2][0] = f64::INFINITY,
            "position 2 of the mesh is [inf, 1.0, 0.0], expected three finite numbers",
        ),
        (
            |mesh| mesh.normals = normal(2, None),
            "triangle 0 of the mesh names normal 2, but the mesh has 2, counted from 0",
        ),
        (
            |mesh| mesh.normals = normal(3, Some(vec![[0, 1, 3]])),
            "triangle 0 of the mesh names normal 3, but the mesh has 3, counted from 0",
        ),
        (
            |mesh| mesh.normals = normal(3, Some(Vec::new())),
            "the mesh has 1 triangle, but indices of normals for 0, expected as many",
        ),
        (
            |mesh| {
                mesh.normals = normal(3, None);
                mesh.normals.as_mut().unwrap().vectors[1] = [0.0; 3];
            },
            "a normal of triangle 0 of the mesh is [0, 0, 0], expected a direction",
        ),
        (
            |mesh| {
                mesh.normals = normal(3, None);
                mesh.normals.as_mut().unwrap().vectors[1] = [0.0, f64::NAN, 0.0];
            },
            "normal 1 of the mesh is [0.0, NaN, 0.0], expected three finite numbers",
        ),
        (
            |mesh| {
                mesh.groups = vec![MeshGroup {
                    name: "g".to_owned(),
                    triangles: 0..2,
                }];
            },
            "the group `g` of the mesh has triangles 0 to 2, expected some of 0 to 1: groups follow \
             each other, and none is empty",
        ),
    ] {
        assert_eq!(said(change), expected);
    }
}

fn normal(count: usize, triangles: Option<Vec<[u32; 3]>>) -> Option<MeshNormals> {
    Some(MeshNormals {
        vectors: vec![[0.0, 0.0, 1.0]; count],
        triangles,
    })
}

/// Every value that the picture depends on changes the hash, and nothing else does.
#[test]
fn the_hash_is_that_of_the_content() {
    let curve = |value| {
        let curve = Curve::new(vec![400.0, 700.0], vec![value, 0.5]).unwrap();
        Value::Curve(Arc::new(curve))
    };
    type Change = Box<dyn Fn(&mut Scene)>;
    let changes: Vec<Change> = vec![
        Box::new(|_| {}),
        Box::new(|scene| scene.image.resolution.value[1] = 4),
        Box::new(|scene| scene.image.background.value = Value::Uniform(1e-300)),
        Box::new(|scene| scene.image.transport.value = Transport::Spectral),
        Box::new(|scene| scene.image.observer.value = Observer::ALL[1]),
        Box::new(|scene| {
            if let Camera::Orthographic { height, .. } = &mut scene.camera.value {
                height.value = 3.0_f64.next_up();
            }
        }),
        Box::new(|scene| scene.materials[0].value = material(0.5_f64.next_down())),
        Box::new(|scene| scene.materials.push(entry("gold", material(0.5)))),
        Box::new(move |scene| scene.lights[0].value = lamp(curve(1.0))),
        Box::new(move |scene| scene.lights[0].value = lamp(curve(1.0_f64.next_up()))),
        Box::new(|scene| scene.lights[0].name = "Key".to_owned()),
        Box::new(|scene| scene.lights.clear()),
        Box::new(|scene| scene.objects[0].value = ball(1.0_f64.next_up())),
        Box::new(|scene| scene.objects.swap(0, 1)),
        Box::new(|scene| {
            let mut geometry = triangle_mesh();
            geometry.positions[2][1] = 1.0_f64.next_up();
            scene.objects[1].value = mesh(geometry);
        }),
        Box::new(|scene| {
            let mut geometry = triangle_mesh();
            geometry.normals = normal(3, None);
            scene.objects[1].value = mesh(geometry);
        }),
        Box::new(|scene| {
            let other = scene.objects[1].value.clone();
            scene.objects.push(entry("other", other));
        }),
    ];
    let hashes: HashSet<String> = changes
        .iter()
        .map(|change| {
            let mut scene = scene();
            change(&mut scene);
            scene.hash().to_string()
        })
        .collect();
    assert_eq!(hashes.len(), changes.len());
    let (world, _) = World::new(&scene()).unwrap();
    assert_eq!(world.scene_hash(), scene().hash().to_string());
    assert_eq!(world.inputs_hash(), world.scene_hash());
    // One mesh that two objects share is one that each has for itself.
    let twice = |shared: bool| {
        let mut scene = scene();
        let object = if shared {
            scene.objects[1].value.clone()
        } else {
            mesh(triangle_mesh())
        };
        scene.objects.push(entry("other", object));
        scene.hash()
    };
    assert_eq!(twice(true), twice(true));
}

/// `sha256sum` of some files, run in their folder.
fn sha256sum(folder: &Path, arguments: &str) -> String {
    let command = format!("sha256sum {arguments}");
    let output = Command::new("sh")
        .args(["-c", &command])
        .current_dir(folder)
        .output()
        .unwrap();
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    text[..64].to_owned()
}

const SCENE: &str = r#"
[objects.wing.mesh]
material = "clay"
file = "meshes/wing one.obj"
[objects.tail.mesh]
material = "clay"
file = "tail.obj"
[objects.other.mesh]
material = "clay"
file = "meshes/wing one.obj"
[materials.clay.phong]
diffuse = { file = "red.csv" }
[image]
resolution = [2, 2]
background = { file = "sky.csv" }
[camera.orthographic]
eye = [0, 0, 5]
look_at = [0, 0, 0]
height = 3
"#;

const WING: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n# the end";

fn files() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("meshes")).unwrap();
    for (name, content) in [
        ("scene.toml", SCENE),
        ("meshes/wing one.obj", WING),
        // A header that says faces come first: the file is not read from start to end.
        (
            "tail.obj",
            "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n\
             element vertex 3\nproperty float x\nproperty float y\nproperty float z\nend_header\n\
             3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n",
        ),
        ("red.csv", "400,0.1\n700,0.9\n"),
        ("sky.csv", "nm,value\n400,0.2\n700,0.1\n"),
    ] {
        fs::write(folder.path().join(name), content).unwrap();
    }
    folder
}

fn load(folder: &Path) -> Loaded {
    World::load(folder.join("scene.toml")).unwrap()
}

#[test]
fn inputs_are_hashed_as_sha256sum_does() {
    let folder = files();
    let folder = folder.path();
    let Loaded {
        scene,
        world,
        camera,
        ..
    } = load(folder);
    let names: Vec<&str> = scene
        .inputs
        .iter()
        .map(|input| input.name.as_str())
        .collect();
    // In the order in which they are named, each once.
    assert_eq!(
        names,
        ["meshes/wing one.obj", "tail.obj", "red.csv", "sky.csv"]
    );
    assert_eq!(world.scene_hash(), sha256sum(folder, "scene.toml"));
    let all =
        "scene.toml 'meshes/wing one.obj' tail.obj red.csv sky.csv | cut -d' ' -f1 | sha256sum";
    assert_eq!(world.inputs_hash(), sha256sum(folder, all));
    let paths: Vec<PathBuf> = scene.files();
    assert_eq!(paths[0], folder.join("scene.toml"));
    assert_eq!(paths.len(), 5);

    let exr = folder.join("out.exr");
    let film = render(&world, &camera, &Options::default()).unwrap();
    film.write_exr(&exr, &ExrOptions::default(), &Unfinished::new())
        .unwrap();
    let printed = oiiotool(folder, "--info -v out.exr");
    for (key, hash) in [
        ("scene_sha256", world.scene_hash()),
        ("inputs_sha256", world.inputs_hash()),
    ] {
        let line = format!("candela:{key}: \"{hash}\"");
        assert!(printed.contains(&line), "{line}\n{printed}");
    }
}

#[test]
fn a_changed_input_changes_the_hash_of_the_inputs_alone() {
    let folder = files();
    let folder = folder.path();
    let before = load(folder).world;
    for (name, content) in [
        ("meshes/wing one.obj", WING.replace("end", "End")),
        ("sky.csv", "nm,value\n400,0.2\n700,0.11\n".to_owned()),
    ] {
        let old = fs::read(folder.join(name)).unwrap();
        fs::write(folder.join(name), content).unwrap();
        let after = load(folder).world;
        assert_eq!(after.scene_hash(), before.scene_hash(), "{name}");
        assert_ne!(after.inputs_hash(), before.inputs_hash(), "{name}");
        fs::write(folder.join(name), old).unwrap();
        assert_eq!(
            load(folder).world.inputs_hash(),
            before.inputs_hash(),
            "{name}"
        );
    }
    // What only the command line says is no input.
    let other = World::load_with(folder.join("scene.toml"), |scene| {
        scene.image.transport.value = Transport::Rgb;
    })
    .unwrap();
    assert_eq!(other.world.inputs_hash(), before.inputs_hash());
}
