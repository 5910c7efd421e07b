//! The scenes of the benchmark, written as files that anyone can render.

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::fs::{self, File};
use std::io::{BufWriter, Write as _};
use std::path::{Path, PathBuf};

use super::Result;
use super::meshes;

/// A scene and how it is measured.
#[derive(Clone, Debug)]
pub(crate) struct Scene {
    /// What it is called in tables and files.
    pub(crate) name: String,
    /// What is in it.
    pub(crate) content: String,
    /// The numbers of lights to render it with: the first of its lights.
    pub(crate) lights: Vec<usize>,
    /// The numbers of samples a pixel to render it with.
    pub(crate) samples: Vec<u32>,
    /// The scene file.
    pub(crate) path: PathBuf,
}

/// A point light: position and intensity.
type Light = ([f64; 3], [f64; 3]);

const THREE_LIGHTS: [Light; 3] = [
    ([3.0, 4.0, 3.0], [30.0, 30.0, 30.0]),
    ([-3.0, 3.0, 2.0], [10.0, 14.0, 20.0]),
    ([0.0, 5.0, -3.0], [20.0, 12.0, 8.0]),
];

/// Over a floor, 4 m away, 1.2 m high; 40° wide.
const CAMERA: &str = "\
[camera.perspective]
eye = [0, 1.2, 4]
look_at = [0, 0.6, 0]
vertical_fov = 23.140917140577795
";

const ORTHOGRAPHIC: &str = "\
[camera.orthographic]
eye = [0, 2.2, 4]
look_at = [0, 0.3, 0]
height = 2.2
";

/// From 200 m away, 0.5° high.
const TELEPHOTO: &str = "\
[camera.perspective]
eye = [0, 60, 190.8]
look_at = [0, 0.35, 0]
vertical_fov = 0.5
";

const IN_THE_ROOM: &str = "\
[camera.perspective]
eye = [0.5, 1.6, 3.7]
look_at = [0, 1.1, 0]
vertical_fov = 60
";

const MATERIALS: &str = "\
[materials.floor.phong]
diffuse = 0.5
specular = 0.3
shininess = 50

[materials.clay.phong]
diffuse = [0.7, 0.3, 0.2]
specular = 0.3
shininess = 50
";

/// The meshes of the Stanford dragon: the scene's name, its file, its triangles.
const DRAGONS: [(&str, &str, &str); 4] = [
    ("dragon", "dragon_vrip.ply", "871 k"),
    ("dragon-res2", "dragon_vrip_res2.ply", "202 k"),
    ("dragon-res3", "dragon_vrip_res3.ply", "48 k"),
    ("dragon-res4", "dragon_vrip_res4.ply", "11 k"),
];

/// Writes the scenes of the benchmark into `folder`, and the dragon's where its meshes are.
pub(crate) fn write_all(folder: &Path, dragon: Option<&Path>) -> Result<Vec<Scene>> {
    let few = [1, 3];
    let mut scenes = vec![
        write_spheres(folder)?,
        write_scene(
            folder,
            "spheres-10k",
            "10 000 spheres",
            CAMERA,
            &many_spheres(),
            &THREE_LIGHTS,
            &few,
        )?,
    ];
    for (name, file, triangles) in DRAGONS {
        let Some(mesh) = dragon.map(|dragon| dragon.join(file)) else {
            continue;
        };
        if !mesh.is_file() {
            eprintln!("{name} is left out: {} is not there", mesh.display());
            continue;
        }
        let mut objects = floor();
        add_mesh(&mut objects, &mesh.canonicalize()?, 10.0, -0.5);
        let content = format!("Stanford dragon, {triangles} triangles");
        scenes.push(write_scene(
            folder,
            name,
            &content,
            CAMERA,
            &objects,
            &THREE_LIGHTS,
            &few,
        )?);
    }
    if dragon.is_none() {
        eprintln!("the dragon is left out: say where its meshes are with --dragon FOLDER");
    }
    let torus = write_torus(folder, 1_000_000)?;
    let content = "a mesh with vertex normals, 1 M triangles";
    for (name, content, camera) in [
        ("smooth", content.to_owned(), CAMERA),
        (
            "orthographic",
            format!("{content}, orthographic"),
            ORTHOGRAPHIC,
        ),
        ("telephoto", format!("{content}, from 200 m"), TELEPHOTO),
    ] {
        scenes.push(write_scene(
            folder,
            name,
            &content,
            camera,
            &torus,
            &THREE_LIGHTS,
            &few,
        )?);
    }
    for (name, content, mesh) in [
        ("noisy", "a scan with noise, 1 M triangles", meshes::noisy()),
        (
            "slivers",
            "tubes of 200 k triangles, 1:1000",
            meshes::slivers(),
        ),
        (
            "cad",
            "blocks with fillets, faces on each other, 314 k triangles",
            meshes::cad(),
        ),
    ] {
        let file = format!("{name}.ply");
        mesh.write(&folder.join(&file))?;
        let mut objects = floor();
        add_mesh(&mut objects, Path::new(&file), 1.0, 0.0);
        let scene = write_scene(folder, name, content, CAMERA, &objects, &THREE_LIGHTS, &[3])?;
        // 16 samples of slivers take minutes.
        scenes.push(Scene {
            samples: vec![1, 4],
            ..scene
        });
    }
    scenes.push(write_lights(folder, 100)?);
    let room_lights = [
        ([0.0, 2.6, 0.0], [8.0, 8.0, 8.0]),
        ([-2.2, 0.5, -2.0], [1.0, 2.0, 3.0]),
        ([2.5, 1.5, 2.5], [3.0, 2.0, 1.0]),
    ];
    scenes.push(write_scene(
        folder,
        "room",
        "a closed room, lights and camera inside",
        IN_THE_ROOM,
        &room(),
        &room_lights,
        &few,
    )?);
    Ok(scenes)
}

/// 25 spheres under `count` lights, spread evenly over a half sphere, together as bright as three.
pub(crate) fn write_lights(folder: &Path, count: usize) -> Result<Scene> {
    let golden_angle = PI * (3.0 - 5.0_f64.sqrt());
    let lights: Vec<Light> = (0..count)
        .map(|index| {
            let height = (index as f64 + 0.5) / count as f64;
            let (radius, angle) = ((1.0 - height * height).sqrt(), golden_angle * index as f64);
            let position = [radius * angle.cos(), 0.1 + height, radius * angle.sin()];
            let warmth = index as f64 / count as f64;
            let intensity = [0.7 + 0.6 * warmth, 1.0, 1.3 - 0.6 * warmth];
            (
                position.map(|coordinate| 5.0 * coordinate),
                intensity.map(|channel| channel * 60.0 / count as f64),
            )
        })
        .collect();
    let name = format!("lights-{count}");
    let content = format!("25 spheres, {count} lights");
    let objects = spheres();
    let scene = write_scene(folder, &name, &content, CAMERA, &objects, &lights, &[count])?;
    Ok(Scene {
        samples: vec![1, 4],
        ..scene
    })
}

/// 25 spheres under three lights.
pub(crate) fn write_spheres(folder: &Path) -> Result<Scene> {
    write_scene(
        folder,
        "spheres",
        "25 spheres",
        CAMERA,
        &spheres(),
        &THREE_LIGHTS,
        &[1, 3],
    )
}

/// The smooth mesh with about `triangles` triangles.
pub(crate) fn write_smooth(folder: &Path, triangles: u64) -> Result<Scene> {
    let objects = write_torus(folder, triangles)?;
    let name = format!("smooth-{triangles}");
    let content = format!("a mesh with vertex normals, {triangles} triangles");
    write_scene(
        folder,
        &name,
        &content,
        CAMERA,
        &objects,
        &THREE_LIGHTS,
        &[3],
    )
}

fn write_scene(
    folder: &Path,
    name: &str,
    content: &str,
    camera: &str,
    objects: &str,
    lights: &[Light],
    counts: &[usize],
) -> Result<Scene> {
    let mut text = format!(
        "# {content}: a scene of candela's benchmark.\n\
         [image]\nresolution = [1920, 1080]\n\n{camera}\n{MATERIALS}\n"
    );
    for (index, (position, intensity)) in lights.iter().enumerate() {
        writeln!(
            text,
            "[lights.l{index}.point]\nposition = {position:?}\nintensity = {intensity:?}\n"
        )?;
    }
    text += objects;
    let path = folder.join(format!("{name}.toml"));
    fs::write(&path, text)?;
    Ok(Scene {
        name: name.to_owned(),
        content: content.to_owned(),
        lights: counts.to_vec(),
        samples: vec![1, 4, 16],
        path,
    })
}

/// 40 m × 40 m at y = 0.
fn floor() -> String {
    let corners =
        [[-20, 0, -20], [20, 0, -20], [20, 0, 20], [-20, 0, 20]].map(|c| c.map(f64::from));
    let mut objects = String::new();
    add_quad(&mut objects, "floor", corners);
    objects
}

fn add_quad(objects: &mut String, name: &str, [a, b, c, d]: [[f64; 3]; 4]) {
    for (half, corners) in [("a", [a, b, c]), ("b", [a, c, d])] {
        *objects += &format!(
            "[objects.{name}-{half}.triangle]\nmaterial = \"floor\"\nvertices = {corners:?}\n\n"
        );
    }
}

fn add_sphere(objects: &mut String, name: &str, center: [f64; 3], radius: f64) {
    *objects += &format!(
        "[objects.{name}.sphere]\nmaterial = \"clay\"\ncenter = {center:?}\nradius = {radius:?}\n\n"
    );
}

fn add_mesh(objects: &mut String, file: &Path, scale: f64, height: f64) {
    // As TOML and Rust quote text alike here, a path with quotes in it is safe.
    *objects += &format!(
        "[objects.mesh.mesh]\nmaterial = \"clay\"\nfile = {:?}\nscale = {scale:?}\n\
         translate = [0, {height:?}, 0]\n\n",
        file.display().to_string()
    );
}

fn spheres() -> String {
    let mut objects = floor();
    for i in -2..3 {
        for j in -2..3 {
            let center = [0.7 * f64::from(i), 0.3, 0.7 * f64::from(j)];
            add_sphere(
                &mut objects,
                &format!("ball{}{}", i + 2, j + 2),
                center,
                0.3,
            );
        }
    }
    objects
}

/// A field of 100 × 100 spheres in a wave.
fn many_spheres() -> String {
    let mut objects = floor();
    for i in 0..100_u32 {
        for j in 0..100_u32 {
            let [x, z] = [i, j].map(|place| (f64::from(place) - 49.5) * 0.04);
            let height = 0.3 + 0.2 * (4.0 * x).sin() * (3.0 * z).cos();
            add_sphere(&mut objects, &format!("s{i}-{j}"), [x, height, z], 0.018);
        }
    }
    objects
}

/// Six walls, a block and nine spheres.
fn room() -> String {
    let mut objects = String::new();
    add_box(&mut objects, "room", [-3.0, 0.0, -3.0], [3.0, 3.0, 4.0]);
    add_box(&mut objects, "block", [-1.8, 0.0, -2.0], [-0.9, 1.4, -1.1]);
    for i in 0..9 {
        let (x, z) = (f64::from(i % 3) * 0.8 - 0.4, f64::from(i / 3) * 0.8 - 1.0);
        add_sphere(&mut objects, &format!("ball{i}"), [x, 0.3, z], 0.3);
    }
    objects
}

fn add_box(objects: &mut String, name: &str, low: [f64; 3], high: [f64; 3]) {
    for axis in 0..3 {
        for (side, at) in [("low", low), ("high", high)] {
            let corner = |second: bool, third: bool| {
                let mut corner = at;
                let [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
                corner[b] = if second { high[b] } else { low[b] };
                corner[c] = if third { high[c] } else { low[c] };
                corner
            };
            let corners = [(false, false), (true, false), (true, true), (false, true)];
            add_quad(
                objects,
                &format!("{name}-{axis}-{side}"),
                corners.map(|(second, third)| corner(second, third)),
            );
        }
    }
}

/// A rippled torus over a floor; its mesh is a PLY file with vertex normals beside the scene.
fn write_torus(folder: &Path, triangles: u64) -> Result<String> {
    // Three times as long as around, so that its squares are squares.
    let around = ((triangles as f64 / 6.0).sqrt().round() as u32).max(3);
    let along = 3 * around;
    let name = format!("torus-{triangles}.ply");
    let mut file = BufWriter::new(File::create(folder.join(&name))?);
    write!(
        file,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\n\
         property float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\n\
         element face {}\nproperty list uchar uint vertex_indices\nend_header\n",
        along * around,
        2 * along * around,
    )?;
    for i in 0..along {
        for j in 0..around {
            let u = TAU * f64::from(i) / f64::from(along);
            let v = TAU * f64::from(j) / f64::from(around);
            for value in torus_point(u, v).into_iter().chain(torus_normal(u, v)) {
                file.write_all(&(value as f32).to_le_bytes())?;
            }
        }
    }
    for i in 0..along {
        for j in 0..around {
            let vertex = |i: u32, j: u32| (i % along) * around + j % around;
            let square = [
                vertex(i, j),
                vertex(i + 1, j),
                vertex(i + 1, j + 1),
                vertex(i, j + 1),
            ];
            for corners in [[0, 2, 1], [0, 3, 2]] {
                file.write_all(&[3])?;
                for corner in corners {
                    file.write_all(&square[corner].to_le_bytes())?;
                }
            }
        }
    }
    file.flush()?;
    let mut objects = floor();
    add_mesh(&mut objects, Path::new(&name), 1.0, 0.4);
    Ok(objects)
}

/// A point of the rippled torus, at the angle `u` about its axis (y) and `v` about its tube.
fn torus_point(u: f64, v: f64) -> [f64; 3] {
    let tube = 0.35 * (1.0 + 0.06 * (24.0 * u).sin() * (8.0 * v).sin());
    let distance = 0.9 + tube * v.cos();
    [distance * u.cos(), tube * v.sin(), distance * u.sin()]
}

/// Its normal, by central differences.
fn torus_normal(u: f64, v: f64) -> [f64; 3] {
    const STEP: f64 = 1e-5;
    let difference = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let [ax, ay, az] = difference(torus_point(u, v + STEP), torus_point(u, v - STEP));
    let [bx, by, bz] = difference(torus_point(u + STEP, v), torus_point(u - STEP, v));
    let normal = [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx];
    let length = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
    normal.map(|n| n / length)
}
