//! What reading, validating and preparing a scene takes in memory, whatever is in its file.

use std::path::Path;
use std::process::Command;

use candela::render::Renderer;
use candela::scene::{Reading, Scene};
use candela::world::World;

use crate::allocation::peak;

/// `docs/limits.md`: what a scene file may take while it is read, as a multiple of its size and in
/// bytes beside that.
const READING: (usize, usize) = (25, 200_000_000);

/// The same for what is made of it when it is validated, beside spectra.
const VALIDATING: (usize, usize) = (15, 10_000_000);

/// On one thread, so that all that is allocated is counted.
fn alone<T: Send>(work: impl FnOnce() -> T + Send) -> (T, usize) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1);
    pool.build().unwrap().install(|| peak(work))
}

const HEAD: &str = "\
[image]
resolution = [4, 3]
[camera.orthographic]
eye = [0, 0, 5]
look_at = [0, 0, 0]
height = 3
[materials.m.phong]
diffuse = 0.5
[lights.l.point]
position = [0, 0, 9]
intensity = 1
[objects.o.sphere]
material = \"m\"
center = [0, 0, 0]
radius = 1
";

/// A scene of some entries more, of about 3 MB.
fn scene_of(entry: impl Fn(usize) -> String) -> String {
    let mut text = HEAD.to_owned();
    let mut number = 0;
    while text.len() < 3_000_000 {
        text += &entry(number);
        number += 1;
    }
    text
}

fn sphere(number: usize) -> String {
    format!("[objects.o{number}.sphere]\nmaterial = \"m\"\ncenter = [{number}, 0, 0]\nradius = 1\n")
}

/// Files of every kind of content that is many times larger in memory.
fn greedy() -> Vec<(&'static str, bool, String)> {
    let spaces = " ".repeat(1_100_000);
    vec![
        ("spheres", true, scene_of(sphere)),
        (
            "entries as keys",
            true,
            scene_of(|n| {
                let header = if n == 0 { "[objects]\n" } else { "" };
                let sphere = "{ material = \"m\", center = [0, 0, 0], radius = 1 }";
                format!("{header}o{n}.sphere = {sphere}\n")
            }),
        ),
        (
            "materials",
            true,
            scene_of(|n| format!("[materials.m{n}.phong]\n")),
        ),
        (
            "lights",
            true,
            scene_of(|n| format!("[lights.l{n}.point]\nposition = [0, 0, 9]\nintensity = 1\n")),
        ),
        (
            "entries of no kind",
            false,
            scene_of(|n| format!("[objects.o{n}]\n")),
        ),
        (
            "unknown sections",
            false,
            scene_of(|n| format!("[objets.o{n}]\na.b = 1\n")),
        ),
        (
            "tables in an array",
            false,
            format!("x = [{}]", "{a=1},".repeat(600_000)),
        ),
        (
            "as many as may be in a small file",
            false,
            format!("x = [{}]", "{a=1},".repeat(170_000)),
        ),
        (
            "as many as may be in one entry",
            false,
            format!("[image]\nx = [{}]\n{spaces}", "{a=1},".repeat(166_000)),
        ),
        (
            "as many numbers",
            false,
            format!("[image]\nx = [{}]\n{spaces}", "1,".repeat(499_000)),
        ),
        (
            "a long text",
            false,
            format!("[image]\nx = \"{}\"", "é".repeat(1_000_000)),
        ),
        (
            "a text of escapes",
            false,
            format!("[image]\nx = \"{}\"", "\\n".repeat(1_000_000)),
        ),
        ("comments", false, "# x\n".repeat(800_000)),
        (
            "blank lines",
            true,
            HEAD.to_owned() + &"\n".repeat(3_000_000),
        ),
        ("brackets", false, format!("x = {}", "[".repeat(3_000_000))),
    ]
}

#[test]
fn reading_and_validating_take_what_is_said() {
    for (name, is_legal, text) in greedy() {
        let size = text.len();
        let (reading, most) = alone(|| Reading::of_text(text, Path::new("greedy.toml")));
        assert!(
            most <= READING.0 * size + READING.1,
            "`{name}` takes {most} bytes for {size}"
        );
        let scene = reading.complete();
        assert_eq!(scene.is_ok(), is_legal, "`{name}`");
        if let Ok(scene) = scene {
            let (world, most) = alone(|| World::new(&scene).is_ok());
            assert!(world, "`{name}`");
            assert!(
                most <= VALIDATING.0 * size + VALIDATING.1,
                "`{name}` takes {most} bytes for {size}"
            );
        }
    }
}

/// However long the file, what one entry takes is all that is there at once beside the scene: most of
/// the tree of a file is not.
#[test]
fn a_large_file_is_no_tree_at_once() {
    let text = scene_of(sphere);
    let size = text.len();
    let (reading, most) = alone(|| Reading::of_text(text, Path::new("spheres.toml")));
    assert!(reading.complete().is_ok());
    // What is looked for at first, ten times the size, is the most: a tree of all would take 13 times,
    // beside the scene.
    assert!(most <= 10 * size + 1000, "{most} bytes for {size}");
}

/// What [`Renderer::memory_needed`] says is enough, and not much more.
#[test]
fn preparing_takes_what_is_said() {
    let grid: String = (0..200 * 200)
        .map(|i| format!("v {} {} {}\n", i % 200, i / 200, i * i % 7))
        .chain((0..199 * 199).map(|i| {
            let corner = i / 199 * 200 + i % 199 + 1;
            format!("f {corner} {} {}\n", corner + 1, corner + 201)
        }))
        .collect();
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("grid.obj"), grid).unwrap();
    let mesh = "[objects.g.mesh]\nmaterial = \"m\"\nfile = \"grid.obj\"\n";
    for text in [HEAD.to_owned() + mesh, scene_of(sphere)] {
        let scene = Scene::parse(&text, folder.path().join("a.toml")).unwrap();
        let (world, _) = World::new(&scene).unwrap();
        let (kept, most) = alone(|| Renderer::new(&world).unwrap().memory());
        let needed = Renderer::memory_needed(&world) as usize;
        assert!(most <= needed, "{most} of {needed}, {kept} kept");
        assert!(needed <= 2 * most + 1_000_000, "{most} of {needed}");
    }
}

/// A scene as it is in a small file and in a large one, which is read piece by piece, is the same.
#[test]
fn pieces_are_read_as_the_whole() {
    let mut scenes = crate::fuzz_scene::legal();
    scenes.push(SCATTERED.as_bytes().to_vec());
    let comment = format!("# {}\n", "x".repeat(70_000));
    for text in scenes {
        let text = String::from_utf8(text).unwrap();
        if text.lines().count() > 500 {
            continue;
        }
        // Comments between entries make each a piece, and the file a large one.
        let mut parted = comment.repeat(16);
        let mut depth = 0;
        for line in text.lines() {
            if depth == 0 && !line.starts_with('#') {
                parted += &comment;
            }
            let code = line.split('#').next().unwrap();
            depth += code.matches(['[', '{']).count();
            depth -= code.matches([']', '}']).count();
            parted = parted + line + "\n";
        }
        assert!(parted.len() > 1 << 20);
        let world = |text: &str| {
            let path = Path::new("tests/bad_scenes/parted.toml");
            let scene = Scene::parse(text, path).map_err(|error| error.list()[0].to_string());
            let world = World::new(&scene.unwrap()).map_err(|error| error.list()[0].to_string());
            let (world, camera) = world.unwrap();
            format!(
                "{:?}{:?}{:?}{:?}{:?}{:?}{:?}",
                camera,
                world.materials(),
                world.lights(),
                world.objects(),
                world.spheres(),
                world.planes(),
                world.triangles(),
            )
        };
        assert_eq!(world(&parted), world(&text));
    }
}

/// Tables of one entry under several headers, and entries under the header of their section.
const SCATTERED: &str = r#"
[materials]
cloth.phong.diffuse = 0.5
cloth.phong.specular = 0.25
cloth.phong.shininess = 9
"a paint".phong = { diffuse = [0.5, 0.25, 0] }

[image]
resolution = [4, 3]

[materials.curved.phong]
[materials.curved.phong.diffuse]
wavelengths = [
    400, 500,
    700 ]
values = [0.1, 0.5, 0.2]

[camera]
[camera.orthographic]
eye = [0, 0, 5]
look_at = [0, 0, 0]
height = 3

[objects]
a.sphere = { material = "cloth", center = [0, 0, 0], radius = 1 }
b.sphere.material = "a paint"
b.sphere.center = [2, 0, 0]
b.sphere.radius = 1
[objects.c]
[objects.c.plane]
material = 'curved'
point = [0, 0, -1]
normal = [0, 0, 1]

[lights.l.point]
position = [0, 0, 9]
intensity.candela = 3
"#;

/// What is wrong in a large file is said at its place.
#[test]
fn errors_in_pieces_have_their_places() {
    let spheres = scene_of(sphere);
    for (wrong, line, said) in [
        (
            "[objects.bad.sphere]\nradius = 1 1\n",
            2,
            "this is not TOML; write `radius = [1, 1]`",
        ),
        (
            "[objects.bad.sphere]\nradius = \"1\"\n",
            2,
            "`radius` is the string \"1\"",
        ),
        (
            "[objects.o7.sphere]\nmaterial = \"m\"\ncenter = [0, 0, 0]\nradius = 1\n",
            1,
            "object `o7` is there twice",
        ),
        ("[image]\n", 1, "section `image` is there twice"),
        (
            "[camera.perspective]\n",
            1,
            "section `camera` is there twice",
        ),
        (
            "[objects]\nbad.sphere = { material = 3, center = [0, 0, 0], radius = 1 }\n",
            2,
            "`material` is the integer 3",
        ),
        ("[objets.x]\n", 1, "unknown section `objets`"),
    ] {
        let half = spheres.len() / 2;
        let half = half + spheres[half..].find("[objects").unwrap();
        let (above, below) = spheres.split_at(half);
        let amid = format!("{above}{wrong}{below}");
        for text in [format!("{spheres}{wrong}"), amid] {
            let start = text.find(wrong).unwrap();
            let expected = text[..start].lines().count() + line;
            let read = |bytes: &[u8]| {
                let text = String::from_utf8(bytes.to_vec()).unwrap();
                let scene = Reading::of_text(text, Path::new("large.toml")).complete()?;
                World::new(&scene)
            };
            let Err(errors) = read(text.as_bytes()) else {
                panic!("{wrong} is accepted");
            };
            let message = errors.to_string();
            assert!(message.contains(said), "{wrong}\n{message}");
            let place = format!("large.toml:{expected}:");
            assert!(message.contains(&place), "{wrong} {place}\n{message}");
        }
    }
}

/// However little memory there is, a command does its work or says that there is too little, with exit
/// code 75: no step of these is ended by a signal. The address space is what is limited, threads' stacks
/// included.
#[cfg(target_os = "linux")]
#[test]
fn where_memory_ends_the_exit_code_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: String| std::fs::write(folder.path().join(name), text).unwrap();
    write("spheres.toml", scene_of(sphere));
    let lights = |n| format!("[lights.l{n}.point]\nposition = [{n}, 0, 9]\nintensity = 1\n");
    let lights: String = (0..2000).map(lights).collect();
    write("lights.toml", HEAD.to_owned() + &lights);
    write("wide.toml", HEAD.replace("[4, 3]", "[65536, 65536]"));
    let spectral = HEAD.replace("[4, 3]", "[4, 3]\ntransport = \"spectral\"");
    write("spectral.toml", spectral + &lights);
    let run = |megabytes: usize, command: &str| {
        let limited = format!(
            "ulimit -v {}; exec {} {command}",
            megabytes * 1024,
            env!("CARGO_BIN_EXE_candela"),
        );
        let mut shell = Command::new("sh");
        let shell = shell.args(["-c", &limited]).current_dir(folder.path());
        // Not optimized, tracing takes more stack than a thread usually has.
        shell.env("RUST_MIN_STACK", "16777216");
        shell.env_remove("RAYON_NUM_THREADS").output().unwrap()
    };
    // A small file with a display window of a million columns, whose rows are long.
    write("long.toml", HEAD.to_owned() + &sphere(0));
    let rendered = run(2048, "render long.toml --quiet --threads 2");
    assert!(rendered.status.success());
    let mut exr = std::fs::read(folder.path().join("long.exr")).unwrap();
    let name = b"displayWindow\0box2i\0";
    let place = exr.windows(name.len()).position(|bytes| bytes == name);
    let right = place.unwrap() + name.len() + 4 + 8;
    exr[right..right + 4].copy_from_slice(&((1_i32 << 20) - 1).to_le_bytes());
    std::fs::write(folder.path().join("long.exr"), exr).unwrap();
    // Less than the program itself takes, before it has a say, is nothing to start with.
    let starts = |megabytes: &usize| run(*megabytes, "--version").status.success();
    let least = (8..).step_by(4).find(starts).unwrap();
    for command in [
        "check spheres.toml",
        "render lights.toml --quiet --threads 2 --layers lights,normal",
        "render wide.toml --quiet --threads 2 --crop 0,0,65536,2",
        "check spectral.toml",
        "probe spheres.toml --pixel 1,1",
        "render spheres.toml --quiet --threads 2",
        "tonemap long.exr",
    ] {
        let (mut done, mut refused) = (0, 0);
        // From what the program itself hardly starts with to what is enough.
        for megabytes in (least..least + 400).step_by(40).chain([2048]) {
            let output = run(megabytes, command);
            let said = String::from_utf8_lossy(&output.stderr);
            match output.status.code() {
                Some(0) => done += 1,
                Some(75) => {
                    let is_named = ["memory", "thread", "wait for signals"];
                    assert!(is_named.iter().any(|what| said.contains(what)), "{said}");
                    assert!(!said.contains("overflowed its stack"), "{said}");
                    refused += 1;
                }
                code => panic!(
                    "`{command}` in {megabytes} MB: {code:?} {}\n{said}",
                    output.status
                ),
            }
        }
        assert!(done > 0 && refused > 0, "`{command}`: {done} {refused}");
    }
}
