//! Frames of a sequence, what is set on the command line, files in several parts, progress lines, manifests.

use std::collections::BTreeMap;
use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use sha2::{Digest, Sha256};

use super::{SCENE, candela, fails, files, folder, output, succeeds, text};

/// The ball rolls, and the key light moves with the camera.
fn moving(folder: &Path) {
    let scene = SCENE
        .replace(
            "center = [0, 0.5, 0]",
            "center = { keys = [[1, [-1, 0.5, 0]], [24, [1, 0.5, 0]]] }",
        )
        .replace(
            "eye = [0.0, 1.0, 4.0]",
            "eye = { keys = [[1, [0, 1, 4]], [24, [2, 1, 3]]], interpolation = \"smooth\" }",
        );
    fs::write(folder.join("shot.toml"), scene).unwrap();
}

fn read(folder: &Path, name: &str) -> Vec<u8> {
    fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// What a file is, beyond its bytes: another one of the same bytes is another file.
#[cfg(unix)]
fn identity(folder: &Path, name: &str) -> (u64, i64) {
    use std::os::unix::fs::MetadataExt;
    let metadata = fs::metadata(folder.join(name)).unwrap();
    (metadata.ino(), metadata.mtime_nsec())
}

#[test]
fn frames_have_names_and_are_those_of_single_runs() {
    let folder = folder();
    let folder = folder.path();
    moving(folder);
    succeeds(
        folder,
        "render shot.toml --frames 1-5:2,9.5 -o f.####.exr --preview p_%02d.png -q",
    );
    assert_eq!(
        files(folder),
        [
            "ball.toml",
            "f.0001.exr",
            "f.0003.exr",
            "f.0005.exr",
            "f.0009.5.exr",
            "p_01.png",
            "p_03.png",
            "p_05.png",
            "p_09.5.png",
            "shot.toml"
        ]
    );
    succeeds(
        folder,
        "render shot.toml --frame 3 -o one.exr --preview one.png -q",
    );
    assert!(read(folder, "one.exr") == read(folder, "f.0003.exr"));
    assert!(read(folder, "one.png") == read(folder, "p_03.png"));
    assert!(read(folder, "f.0001.exr") != read(folder, "f.0003.exr"));
    // Without a frame it is the first.
    succeeds(folder, "render shot.toml -o first.exr -q");
    assert!(read(folder, "first.exr") == read(folder, "f.0001.exr"));
    // The name of the scene with a place for numbers.
    succeeds(folder, "render shot.toml --frames 1,2 -q");
    assert!(read(folder, "shot.0001.exr") == read(folder, "f.0001.exr"));
    // A still has no frame in its header, and each frame its own.
    let header = |name: &str| String::from_utf8_lossy(&read(folder, name)).into_owned();
    succeeds(folder, "render ball.toml -o still.exr -q");
    assert!(!header("still.exr").contains("candela:frame"));
    assert!(header("f.0009.5.exr").contains("candela:frame\0string\0\u{3}\0\0\u{0}9.5"));
    // Pictures of a sequence in one.
    succeeds(folder, "contact-sheet f.####.exr --width 60 -o sheet.png");
    succeeds(folder, "tonemap f.####.exr -o t.####.png -q");
    assert!(folder.join("t.0005.png").exists() && folder.join("sheet.png").exists());
}

#[test]
fn what_is_wrong_with_frames_is_said() {
    let folder = folder();
    let folder = folder.path();
    moving(folder);
    for (arguments, code, part) in [
        (
            "render shot.toml --frames 5-1 -o f.####.exr",
            2,
            "there is no frame in 5-1",
        ),
        (
            "render shot.toml --frames , -o f.####.exr",
            2,
            "expected frames such as",
        ),
        (
            "render shot.toml -o f.####.exr",
            2,
            "say which ones by --frames",
        ),
        (
            "render shot.toml --preview f.%04d.png",
            2,
            "say which ones by --frames",
        ),
        (
            "render shot.toml --frames 1-3 -o f.exr",
            2,
            "such as f.####.exr",
        ),
        (
            "render shot.toml --frames 1-3 -o f.####.exr --preview p.png",
            2,
            "such as p.####.png",
        ),
        ("render shot.toml --frames 1-3 -o -", 2, "standard output"),
        (
            "render shot.toml --frames 1-3 -o f.####.exr --stats s.####.json",
            2,
            "this is one file",
        ),
        (
            "render shot.toml --frames 1-3,2 -o f.####.exr",
            2,
            "frame 2 is there twice",
        ),
        (
            "render shot.toml --frames 1.5,2 -o f.####.exr --preview f.####.exr",
            2,
            "this option writes PNG",
        ),
        (
            "probe shot.toml --pixel 1,1 --frame x",
            2,
            "the number of a frame",
        ),
        ("contact-sheet g.####.exr", 1, "no frame has a name like"),
        (
            "contact-sheet shot.toml --view agx",
            2,
            "--view goes with --layers, or with frames",
        ),
    ] {
        let told = fails(folder, arguments, code);
        assert!(told.contains(part), "{arguments}: {told}");
    }
    for (from, to, part) in [
        (
            "radius = 0.5",
            "radius = { keys = [[5, 1], [3, 2]] }",
            "does not come after 5",
        ),
        (
            "radius = 0.5",
            "radius = { keys = [[1, 1], [1, 2]] }",
            "does not come after 1",
        ),
        (
            "radius = 0.5",
            "radius = { keys = [[1, 1], [3, [1, 2, 3]]] }",
            "is an array of 3, expected",
        ),
        (
            "radius = 0.5",
            "radius = { keys = [[1, 1], [3, \"a\"]] }",
            "is the string \"a\", expected",
        ),
        (
            "radius = 0.5",
            "radius = { keys = [] }",
            "is an empty array, expected pairs",
        ),
        (
            "radius = 0.5",
            "radius = { keys = [[1]] }",
            "expected a frame and a value",
        ),
        (
            "radius = 0.5",
            "radius = { keys = [[nan, 1]] }",
            "is not from -1e9 to 1e9",
        ),
        (
            "radius = 0.5",
            "radius = { keys = [[1, 1]], interpolation = \"cubic\" }",
            "one of `linear`",
        ),
        (
            "radius = 0.5",
            "radius = { keyframes = [[1, 1]] }",
            "write `keys`",
        ),
        (
            "radius = 0.5",
            "radius = { keys = [[1, 1]], loop = true }",
            "unknown key `loop`",
        ),
        (
            "intensity = 4",
            "intensity = { keys = [[1, { keys = [[1, 2]] }]] }",
            "keys within keys",
        ),
        (
            "material = \"clay\"",
            "material = { keys = [[1, \"clay\"]] }",
            "expected the name of a material",
        ),
    ] {
        fs::write(folder.join("bad.toml"), SCENE.replacen(from, to, 1)).unwrap();
        let told = fails(folder, "render bad.toml --frames 1-3 -o f.####.exr", 1);
        assert!(told.contains(part), "{to}: {told}");
        assert!(told.contains("bad.toml:"), "{told}");
    }
    // What is wrong later is found before the first frame is rendered.
    let shrinking = SCENE.replace("radius = 0.5", "radius = { keys = [[1, 1], [5, -1]] }");
    fs::write(folder.join("shrinks.toml"), shrinking).unwrap();
    let told = fails(folder, "check shrinks.toml --frames 1-5", 1);
    assert!(told.contains("at frame 3, `radius` is 0"), "{told}");
    assert!(told.contains("3 of 5 frames are in error"), "{told}");
    for call in [
        "render shrinks.toml --frames 1-5 -o s.%d.exr -q",
        "job shrinks.toml --frames 1-5",
        "job shrinks.toml --frames 1-5 --tiles 2",
    ] {
        let told = fails(folder, call, 1);
        assert!(told.contains("at frame 3, `radius` is 0"), "{told}");
    }
    // Without frames, those of keys are looked at.
    let told = fails(folder, "check shrinks.toml", 1);
    assert!(told.contains("at frame 5, `radius` is -1"), "{told}");
    let wild = SCENE.replace(
        "intensity = 4",
        "intensity = { keys = [[1, 0], [2, 0], [3, 9]], interpolation = \"smooth\" }",
    );
    fs::write(folder.join("wild.toml"), wild).unwrap();
    succeeds(folder, "check wild.toml");
    let told = fails(folder, "check wild.toml --frames 1.5", 1);
    assert!(told.contains("`linear` does not"), "{told}");
    // A triangle is placed when its frame comes; the frames before are whole.
    let flat = format!(
        "{SCENE}\n[objects.leaf.triangle]\nmaterial = \"clay\"\n\
         vertices = {{ keys = [[1, [[0, 0, 0], [1, 0, 0], [0, 1, 0]]], [2, [[0, 0, 0], [1, 0, 0], [2, 0, 0]]]] }}\n"
    );
    fs::write(folder.join("flat.toml"), flat).unwrap();
    fails(folder, "check flat.toml", 1);
    fails(folder, "render flat.toml --frames 1-5 -o s.%d.exr -q", 1);
    let made: Vec<String> = files(folder)
        .into_iter()
        .filter(|name| name.ends_with("exr"))
        .collect();
    assert_eq!(made, ["s.1.exr"]);
    succeeds(folder, "check shot.toml --frames 1-24");
    // Wrong usage, which no file can cure.
    let far = "render shot.toml --frames 1-2 -o";
    fails(folder, &format!("{far} f.%04d.####.exr"), 2);
    fails(folder, &format!("{far} f.%65536d.exr"), 1);
    fails(folder, "render shot.toml -o - --preview - -q", 2);
}

/// What is whole and of the same inputs, options and version stays the very file; all else is made anew.
#[cfg(unix)]
#[test]
fn what_is_done_is_left_alone() {
    let folder = folder();
    let folder = folder.path();
    moving(folder);
    let names = ["f.1.exr", "f.2.exr", "f.3.exr"];
    let render = |more: &str| {
        succeeds(
            folder,
            &format!("render shot.toml --frames 1-3 -o f.%d.exr -q --skip-done {more}"),
        );
        names.map(|name| identity(folder, name))
    };
    let first = render("");
    let bytes = names.map(|name| read(folder, name));
    assert_eq!(render(""), first);
    assert_eq!(render("--threads 1 --preview p.%d.png"), first);
    assert!(folder.join("p.2.png").exists());
    let call = "render shot.toml --frames 1-3 -o f.%d.exr --skip-done --preview p.%d.png --auto-exposure \
                --manifest m.json";
    let done = output(folder, call);
    let told = text(&done.stderr);
    for part in [
        "warning: --auto-exposure exposes each frame by itself",
        "f.2.exr: is done already\np.2.png: its preview, made anew",
    ] {
        assert!(told.contains(part), "{told}");
    }
    let manifest: serde_json::Value = serde_json::from_slice(&read(folder, "m.json")).unwrap();
    let rendered = |i: usize| {
        (
            &manifest["outputs"][i]["path"],
            &manifest["outputs"][i]["rendered"],
        )
    };
    assert_eq!(rendered(0), (&"f.1.exr".into(), &false.into()));
    assert_eq!(rendered(1), (&"p.1.png".into(), &true.into()));
    // What was written is found, in order.
    succeeds(
        folder,
        "render shot.toml --frames -2,0.25,12 -o n.####.exr -q --samples 1",
    );
    succeeds(folder, "tonemap n.####.exr -o n.####.png -q");
    let pictures: Vec<String> = files(folder)
        .into_iter()
        .filter(|name| name.starts_with("n.") && name.ends_with("png"))
        .collect();
    assert_eq!(pictures, ["n.-002.png", "n.0000.25.png", "n.0012.png"]);
    // Cut off, with a byte of its pixels changed, and no EXR at all.
    let mut broken = bytes[0].clone();
    broken.truncate(bytes[0].len() - 10);
    fs::write(folder.join(names[0]), &broken).unwrap();
    let mut broken = bytes[1].clone();
    let middle = broken.len() / 2;
    broken[middle] ^= 0x10;
    fs::write(folder.join(names[1]), &broken).unwrap();
    fs::write(folder.join(names[2]), "no picture").unwrap();
    let again = render("");
    assert!((0..3).all(|i| again[i] != first[i]));
    assert!(names.map(|name| read(folder, name)) == bytes);
    // Other options make other files.
    let mut last = again;
    for options in [
        "--samples 4",
        "--half",
        "--layers depth",
        "--compression piz",
        "--crop 0,0,30,20",
        "--set lights.fill.point.intensity=5",
        "--transport spectral",
        "--max-error 5%",
        "--layers spectral --spectral-output b.%d.exr",
    ] {
        let changed = render(options);
        assert!((0..3).all(|i| changed[i] != last[i]), "{options}");
        assert_eq!(render(options), changed, "{options}");
        last = changed;
    }
    // And so does another scene.
    let scene = fs::read_to_string(folder.join("shot.toml")).unwrap();
    fs::write(folder.join("shot.toml"), scene + "# changed\n").unwrap();
    let changed = render("--layers spectral --spectral-output b.%d.exr");
    assert!((0..3).all(|i| changed[i] != last[i]));
}

/// Killed at any moment and begun again, a sequence ends with the same files.
#[cfg(unix)]
#[test]
fn a_sequence_that_is_killed_goes_on() {
    let folder = folder();
    let folder = folder.path();
    moving(folder);
    let call = "render shot.toml --set image.resolution=[320,240] --samples 64 --frames 1-12 -q --skip-done -o";
    let start = Instant::now();
    succeeds(folder, &format!("{call} whole.%02d.exr"));
    let whole = start.elapsed();
    for kill in 0..8 {
        let mut run = candela(folder, &format!("{call} k.%02d.exr"))
            .spawn()
            .unwrap();
        std::thread::sleep(whole.mul_f64(f64::from(kill) / 8.0));
        // SIGKILL; whatever it has left is not a whole file.
        run.kill().unwrap();
        run.wait().unwrap();
        for frame in 1..=12 {
            let name = format!("k.{frame:02}.exr");
            if folder.join(&name).exists() {
                assert!(
                    read(folder, &name) == read(folder, &format!("whole.{frame:02}.exr")),
                    "{name}"
                );
            }
        }
    }
    succeeds(folder, &format!("{call} k.%02d.exr"));
    for frame in 1..=12 {
        let [killed, whole] =
            ["k", "whole"].map(|name| read(folder, &format!("{name}.{frame:02}.exr")));
        assert!(killed == whole, "{frame}");
    }
    // What the killed ones left is gone.
    assert!(files(folder).iter().all(|name| !name.ends_with(".tmp")));
}

/// Text beside text: a scene in several files is the scene in one, and its hash covers all of them.
#[cfg(unix)]
#[test]
fn scenes_in_several_files() {
    let folder = folder();
    let folder = folder.path();
    let (top, rest) = SCENE.split_at(SCENE.find("[materials").unwrap());
    let (lights, objects) = rest.split_at(rest.find("[objects").unwrap());
    fs::create_dir(folder.join("parts")).unwrap();
    fs::write(
        folder.join("main.toml"),
        format!("include = [\"parts/lights.toml\"]\n{top}{objects}"),
    )
    .unwrap();
    fs::write(folder.join("parts/lights.toml"), lights).unwrap();
    succeeds(folder, "render ball.toml -o one.exr -q");
    succeeds(folder, "render main.toml -o parts.exr -q");
    succeeds(folder, "diff one.exr parts.exr --max-error 0");
    let hash = |name: &str| {
        let bytes = read(folder, name);
        let key = b"candela:inputs_sha256\0string\0\x40\0\0\0";
        let place = bytes
            .windows(key.len())
            .position(|part| part == key)
            .unwrap()
            + key.len();
        bytes[place..place + 64].to_vec()
    };
    let before = hash("parts.exr");
    fs::write(
        folder.join("parts/lights.toml"),
        format!("{lights}# a comment\n"),
    )
    .unwrap();
    succeeds(folder, "render main.toml -o parts.exr -q");
    let after = hash("parts.exr");
    assert_ne!(before, after);
    succeeds(
        folder,
        "render main.toml -o parts.exr -q --set lights.fill.point.intensity=5",
    );
    assert_ne!(hash("parts.exr"), after);
    std::os::unix::fs::symlink("/dev/zero", folder.join("pipe.toml")).unwrap();
    // An included file is an input, which nothing is written over.
    let told = fails(folder, "render main.toml -o parts/lights.toml", 2);
    assert!(told.contains("writes EXR"), "{told}");

    for (text, part) in [
        ("include = [\"parts\"]\n", "it is a directory"),
        ("include = [\"pipe.toml\"]\n", "it is a device or pipe"),
        ("include = [\"image.toml\"]\n", "it is no text"),
        (
            "include = [\"no.toml\"]\n",
            "cannot read the included file no.toml",
        ),
        (
            "include = [\"main.toml\"]\n",
            "is a part of this scene already",
        ),
        (
            "include = [\"parts/lights.toml\", \"parts/../parts/lights.toml\"]\n",
            "include it once",
        ),
        (
            "include = \"parts/lights.toml\"\n",
            "expected a list of files",
        ),
        ("include = [\"bad.toml\"]\n", "--> bad.toml:2:5"),
        ("include = [\"twice.toml\"]\n", "is there twice"),
    ] {
        fs::write(folder.join("bad.toml"), "# a line\nx = \n").unwrap();
        fs::write(folder.join("image.toml"), b"\x89PNG\r\n").unwrap();
        fs::write(
            folder.join("twice.toml"),
            "[objects.ball.sphere]\nmaterial = \"clay\"\ncenter = [0, 0, 0]\nradius = 1\n",
        )
        .unwrap();
        let rest = if text.contains("twice") {
            SCENE.to_owned()
        } else {
            format!("{top}{objects}")
        };
        fs::write(folder.join("main.toml"), format!("{text}{rest}")).unwrap();
        let told = fails(folder, "check main.toml", 1);
        assert!(told.contains(part), "{text}: {told}");
    }
}

/// What is set is as if the file said so, and checked like it.
#[test]
fn values_on_the_command_line() {
    let folder = folder();
    let folder = folder.path();
    let changed = SCENE
        .replace("intensity = 4", "intensity = 20")
        .replace("rec709", "acescg");
    fs::write(folder.join("changed.toml"), changed).unwrap();
    succeeds(folder, "render changed.toml -o file.exr -q");
    succeeds(
        folder,
        "render ball.toml -o set.exr -q --set lights.fill.point.intensity=20",
    );
    succeeds(folder, "diff file.exr set.exr --max-error 0");
    for set in [
        "image.color_space=acescg",
        "camera.perspective.vertical_fov=20",
        "materials.clay.phong.diffuse=#804020",
        "objects.ball.sphere.center=[0,1,0]",
        "lights.key.point.intensity={lumens=800}",
    ] {
        succeeds(folder, &format!("check ball.toml --set {set}"));
    }
    for (set, part) in [
        ("lights.fil.point.intensity=20", "did you mean `fill`?"),
        (
            "lights.fill.spot.outer=20",
            "unknown kind in the scene: `spot`",
        ),
        ("lights.fill.point.intesity=20", "did you mean `intensity`?"),
        (
            "lights.fill.point.intensity=-20",
            "`intensity` is -20, expected",
        ),
        (
            "lights.fill.point.intensity.candela=20",
            "set it as a whole",
        ),
        ("lights.fill=20", "this sets no value"),
        ("light.fill.point.intensity=20", "did you mean `lights`?"),
        ("image.color_space=acescq", "did you mean `acescg`?"),
        ("nonsense", "expected KEYS=VALUE"),
        ("lights.fill.point.intensity=[1", "expected KEYS=VALUE"),
        (
            "lights.fill.point.intensity=",
            "a value is missing after `=`",
        ),
        ("=20", "expected KEYS=VALUE"),
    ] {
        let told = fails(folder, &format!("render ball.toml --set {set}"), 1);
        assert!(told.contains(part), "{set}: {told}");
        assert!(told.contains("--> --set:1:"), "{set}: {told}");
    }
    assert!(!folder.join("ball.exr").exists());
    // Of the scene that is rendered without a file, too.
    succeeds(
        folder,
        "render -o built-in.exr -q --samples 1 --set image.resolution=[32,18]",
    );
    let told = fails(folder, "render --set image.resolution=[0,18]", 1);
    assert!(told.contains("--> --set:1:"), "{told}");
}

/// A line for whoever waits, at most one a second and one at the end, and nothing else on standard output.
#[test]
fn progress_is_told_in_lines() {
    let folder = folder();
    let folder = folder.path();
    moving(folder);
    for (format, first, last) in [
        ("openjd", "openjd_progress: ", "openjd_progress: 100.0"),
        ("alfred", "ALF_PROGRESS ", "ALF_PROGRESS 100%"),
        (
            "json",
            "{\"progress\": ",
            "{\"progress\": 1.0000, \"frame\": 2, \"done\": 2, \"frames\": 2}",
        ),
    ] {
        let said = succeeds(
            folder,
            &format!("render shot.toml --frames 1,2 -o f.%d.exr -q --progress {format}"),
        );
        assert_eq!(said.lines().last(), Some(last));
        assert!(said.lines().all(|line| line.starts_with(first)), "{said}");
    }
    // The picture has standard output for itself.
    let done = output(folder, "render shot.toml -o - -q --progress json");
    assert!(done.stdout.starts_with(b"\x76\x2f\x31\x01"));
    assert!(text(&done.stderr).starts_with("{\"progress\": 1"));

    let call = "render shot.toml --set image.resolution=[640,480] --samples 1024 -o long.exr -q --progress openjd";
    let mut run = candela(folder, call)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let start = Instant::now();
    let lines = BufReader::new(run.stdout.take().unwrap()).lines();
    let mut times: Vec<Duration> = lines
        .map(|line| line.map(|_| start.elapsed()).unwrap())
        .collect();
    assert!(run.wait().unwrap().success());
    let end = times.pop().unwrap();
    assert!(times.len() as f64 <= end.as_secs_f64(), "{times:?}");
}

#[test]
fn a_manifest_names_all_files() {
    let folder = folder();
    let folder = folder.path();
    moving(folder);
    succeeds(
        folder,
        "render shot.toml --frames 1-2 -o f.%d.exr --preview p.%d.png -q --manifest m.json --set lights.fill.point.intensity=5",
    );
    let manifest =
        |name: &str| -> serde_json::Value { serde_json::from_slice(&read(folder, name)).unwrap() };
    let first = manifest("m.json");
    let hash = |name: &str| -> String {
        Sha256::digest(read(folder, name))
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect()
    };
    assert_eq!(first["inputs"][0]["path"], "shot.toml");
    assert_eq!(first["inputs"][0]["sha256"], hash("shot.toml"));
    assert_eq!(first["set"][0], "lights.fill.point.intensity=5");
    let outputs: BTreeMap<&str, &serde_json::Value> = first["outputs"]
        .as_array()
        .unwrap()
        .iter()
        .map(|output| (output["path"].as_str().unwrap(), output))
        .collect();
    assert_eq!(
        outputs.keys().copied().collect::<Vec<_>>(),
        ["f.1.exr", "f.2.exr", "p.1.png", "p.2.png"]
    );
    for (name, output) in &outputs {
        assert_eq!(output["sha256"], hash(name), "{name}");
        assert_eq!(output["bytes"], read(folder, name).len());
        assert_eq!(output["rendered"], true);
    }
    assert_eq!(first["primary_rays"], 2 * 60 * 40 * 16);
    succeeds(
        folder,
        "render shot.toml --frames 1-2 -o f.%d.exr -q --manifest n.json --skip-done --set lights.fill.point.intensity=5",
    );
    let second = manifest("n.json");
    assert_eq!(second["outputs"][0]["rendered"], false);
    assert_eq!(
        second["outputs"][0]["sha256"],
        first["outputs"][0]["sha256"]
    );
    assert_eq!(second["primary_rays"], 0);
}
