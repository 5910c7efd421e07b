//! The program as a user or a script meets it: exit codes, messages, files.

mod accuracy;
mod contact_sheet;
mod diff;
mod exit_codes;
mod false_color;
mod files;
mod frames;
mod help;
mod interruption;
mod layers;
mod light;
mod merge;
mod new;
mod probe;
mod relight;
mod report;
mod sequences;
mod speaking;
mod streams;
mod verify;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use candela::exr::{Compression, ExrImage, read};
use candela::oracle::{Oracle, Outcome};
use candela::scene::Scene;
use serde_json::Value;
use tempfile::TempDir;

use crate::openimageio::{decode, oiiotool};

const COMMANDS: [&str; 16] = [
    "render",
    "tonemap",
    "contact-sheet",
    "relight",
    "merge",
    "job",
    "check",
    "probe",
    "light",
    "lux",
    "verify",
    "report",
    "diff",
    "new",
    "completions",
    "schema",
];

const RESOLUTION: [u32; 2] = [60, 40];

/// A ball on a floor, with its shadow and some background.
const SCENE: &str = r#"
[image]
resolution = [60, 40]
background = [0.1, 0.2, 0.4]

[camera.perspective]
eye = [0.0, 1.0, 4.0]
look_at = [0.0, 0.6, 0.0]
vertical_fov = 40.0

[materials.clay.phong]
diffuse = [0.7, 0.3, 0.2]
specular = 0.3
shininess = 50

[lights.key.point]
position = [3, 4, 3]
intensity = [30, 30, 30]

[lights.fill.point]
position = [-3, 2, 1]
intensity = 4

[objects.ball.sphere]
material = "clay"
center = [0, 0.5, 0]
radius = 0.5

[objects.floor.plane]
material = "clay"
point = [0, 0, 0]
normal = [0, 1, 0]
"#;

/// A folder with the scene in it.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("ball.toml"), SCENE).unwrap();
    folder
}

fn candela(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_candela"));
    command
        .current_dir(folder)
        .args(arguments.split_whitespace())
        // A panic would show itself.
        .env("RUST_BACKTRACE", "1");
    command
}

fn output(folder: &Path, arguments: &str) -> Output {
    candela(folder, arguments).output().unwrap()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8(bytes.to_vec()).unwrap()
}

/// A PNG without its texts: a preview has its scene's hash where other pictures have their file's.
fn without_texts(png: &Path) -> Vec<u8> {
    let bytes = fs::read(png).unwrap();
    let (start, mut rest) = bytes.split_at(8);
    let mut kept = start.to_vec();
    while !rest.is_empty() {
        let length = u32::from_be_bytes(rest[..4].try_into().unwrap()) as usize;
        let chunk;
        (chunk, rest) = rest.split_at(length + 12);
        if !chunk[4..].starts_with(b"tEXt") {
            kept.extend(chunk);
        }
    }
    kept
}

/// Runs what must work; what it prints to stdout.
fn succeeds(folder: &Path, arguments: &str) -> String {
    let output = output(folder, arguments);
    let stderr = text(&output.stderr);
    assert!(output.status.success(), "candela {arguments}\n{stderr}");
    text(&output.stdout)
}

/// Runs what must fail with an exit code, one message, and nothing on stdout; the message.
fn fails(folder: &Path, arguments: &str, code: i32) -> String {
    let output = output(folder, arguments);
    let message = text(&output.stderr);
    assert_eq!(
        output.status.code(),
        Some(code),
        "candela {arguments}\n{message}"
    );
    assert_eq!(text(&output.stdout), "", "candela {arguments}");
    let errors = message.lines().filter(|line| line.starts_with("error"));
    assert_eq!(errors.count(), 1, "candela {arguments}\n{message}");
    for trace in ["panicked", "backtrace", "RUST_"] {
        assert!(!message.contains(trace), "candela {arguments}\n{message}");
    }
    message
}

fn image(folder: &Path, name: &str) -> ExrImage {
    read(&folder.join(name)).unwrap()
}

/// The files of a folder, sorted.
fn files(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn wrong_usage() {
    let folder = folder();
    for arguments in [
        "rendr",
        "render --sampels 4",
        "render ball.toml more.toml",
        "render ball.toml --samples 0",
        "render ball.toml --samples 1.5",
        "render ball.toml --samples -1",
        "render ball.toml --samples 99999999999",
        "render ball.toml --threads 0",
        "render ball.toml --compression zap",
        "render ball.toml --crop 1,2,3",
        "render ball.toml --crop 5,5,5,9",
        "render ball.toml --crop 9,9,1,1",
        "render ball.toml -o ball.png",
        "render ball.toml --preview ball.exr",
        "render ball.toml -o",
        "tonemap",
        "tonemap ball.exr --bits 12",
        "tonemap ball.exr --view filmic",
        "tonemap ball.exr --exposure nan",
        "tonemap ball.exr --exposure 1 --auto-exposure",
        "check",
        "completions klingon",
    ] {
        fails(folder.path(), arguments, 2);
    }
    assert_eq!(files(folder.path()), ["ball.toml"]);
    // No command at all: the help, as an error.
    let output = output(folder.path(), "");
    assert_eq!(output.status.code(), Some(2));
    assert!(text(&output.stderr).contains("Usage: candela"));
}

#[test]
fn bad_scenes() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    fs::write(
        path("radius.toml"),
        SCENE.replace("radius = 0.5", "radius = -1"),
    )
    .unwrap();
    fs::write(path("key.toml"), SCENE.replace("radius", "radios")).unwrap();
    fs::write(path("syntax.toml"), "[image\n").unwrap();
    fs::write(path("binary.toml"), [0xff, 0x00, 0xfe]).unwrap();
    fs::write(path("empty.toml"), "").unwrap();
    fs::create_dir(path("folder.toml")).unwrap();
    let before = files(folder.path());
    for (scene, part) in [
        ("radius.toml", "-1"),
        ("key.toml", "radios"),
        ("syntax.toml", "[image"),
        ("binary.toml", "UTF-8"),
        ("missing.toml", "cannot read the scene file"),
        ("folder.toml", "cannot read the scene file"),
    ] {
        for command in [
            format!("render {scene} -o new.exr --stats new.json --preview new.png"),
            format!("check {scene}"),
            format!("probe {scene} --pixel 0,0"),
        ] {
            let message = fails(folder.path(), &command, 1);
            assert!(message.contains(part), "{message}");
            assert!(message.contains(scene), "{message}");
        }
    }
    // More than one thing is missing, and all is said.
    let output = output(folder.path(), "render empty.toml");
    assert_eq!(output.status.code(), Some(1));
    assert!(output.stdout.is_empty());
    assert!(text(&output.stderr).contains("empty.toml"));
    assert_eq!(files(folder.path()), before);
}

#[test]
fn outputs_that_cannot_be_written() {
    let folder = folder();
    let mut places = vec!["absent/out", "ball.toml/out"];
    // Where even root cannot write.
    if Path::new("/proc/self").exists() {
        places.push("/proc/out");
    } else {
        println!("/proc is not here: a folder that is closed to everybody is not tried");
    }
    for place in places {
        for option in ["-o PLACE.exr", "--preview PLACE.png", "--stats PLACE.json"] {
            let arguments = format!("render ball.toml {}", option.replace("PLACE", place));
            let message = fails(folder.path(), &arguments, 1);
            assert!(message.contains(place), "{message}");
        }
    }
    fs::create_dir(folder.path().join("taken.exr")).unwrap();
    let message = fails(folder.path(), "render ball.toml -o taken.exr", 1);
    assert!(message.contains("taken.exr"), "{message}");
    assert_eq!(files(folder.path()), ["ball.toml", "taken.exr"]);
}

/// Names that lead to one file, whatever they look like, would lose what is in it.
#[test]
fn no_output_goes_over_what_is_read_or_written() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    fs::copy(path("ball.toml"), path("plain")).unwrap();
    succeeds(folder.path(), "render ball.toml -o made.exr --quiet");
    let mut cases = vec!["render plain -o plain"];
    #[cfg(unix)]
    {
        use std::os::unix::fs::symlink;
        symlink("ball.toml", path("link.exr")).unwrap();
        symlink("ball.toml", path("link.json")).unwrap();
        symlink("made.exr", path("link.png")).unwrap();
        cases.extend([
            "render ball.toml -o link.exr",
            "render ball.toml -o new.exr --stats link.json",
            "render ball.toml -o made.exr --preview link.png",
            "tonemap made.exr -o link.png",
        ]);
    }
    let before = [
        fs::read(path("ball.toml")).unwrap(),
        fs::read(path("made.exr")).unwrap(),
    ];
    for arguments in cases {
        let message = fails(folder.path(), arguments, 1);
        assert!(
            message.contains("give another name"),
            "{arguments}: {message}"
        );
    }
    let after = [
        fs::read(path("ball.toml")).unwrap(),
        fs::read(path("made.exr")).unwrap(),
    ];
    assert!(before == after);
    assert!(!path("new.exr").exists());
}

#[test]
fn what_is_there_stays_after_an_error() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("bad.toml"), SCENE.replace("clay\"", "mud\"")).unwrap();
    for name in ["old.exr", "old.png", "old.json"] {
        fs::write(path(name), "old").unwrap();
    }
    let all = "-o old.exr --preview old.png --stats old.json";
    for arguments in [
        format!("render ball.toml {all} --crop 0,0,61,40"),
        format!("render ball.toml {all} --samples 0"),
        format!("render absent.toml {all}"),
        "tonemap absent.exr -o old.png".to_owned(),
        "tonemap old.exr -o old.png".to_owned(),
        "render ball.toml -o old.exr --preview absent/old.png".to_owned(),
    ] {
        let code = if arguments.contains("--samples") {
            2
        } else {
            1
        };
        fails(folder.path(), &arguments, code);
    }
    assert_eq!(
        output(folder.path(), &format!("render bad.toml {all}"))
            .status
            .code(),
        Some(1)
    );
    for name in ["old.exr", "old.png", "old.json"] {
        assert_eq!(fs::read_to_string(path(name)).unwrap(), "old");
    }
    // And is replaced where nothing is wrong.
    succeeds(folder.path(), &format!("render ball.toml {all}"));
    assert_eq!(image(folder.path(), "old.exr").resolution, RESOLUTION);
    assert!(
        fs::read_to_string(path("old.json"))
            .unwrap()
            .starts_with('{')
    );
}

#[test]
fn default_names() {
    let folder = folder();
    fs::create_dir(folder.path().join("scenes")).unwrap();
    fs::write(folder.path().join("scenes/deep.toml"), SCENE).unwrap();
    succeeds(folder.path(), "render scenes/deep.toml");
    succeeds(folder.path(), "tonemap deep.exr");
    succeeds(folder.path(), "render");
    assert_eq!(
        files(folder.path()),
        ["ball.toml", "deep.exr", "deep.png", "lecture.exr", "scenes"]
    );
    assert_eq!(files(&folder.path().join("scenes")), ["deep.toml"]);
    let lecture = image(folder.path(), "lecture.exr");
    assert_eq!(lecture.resolution, Scene::builtin().image.resolution.value);
}

#[test]
fn the_same_scene_gives_the_same_bytes() {
    let folder = folder();
    for name in ["a", "b"] {
        let threads = if name == "a" { 1 } else { 2 };
        succeeds(
            folder.path(),
            &format!(
                "render ball.toml -o {name}.exr --preview {name}.png --samples 3 --threads {threads}"
            ),
        );
    }
    let bytes = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("a.exr") == bytes("b.exr"));
    assert!(bytes("a.png") == bytes("b.png"));
}

#[test]
fn a_crop_is_a_part_at_its_place() {
    let folder = folder();
    succeeds(folder.path(), "render ball.toml --samples 4");
    let whole = decode(&folder.path().join("ball.exr"));
    for [x0, y0, x1, y1] in [
        [7, 11, 45, 39],
        [0, 0, 60, 40],
        [59, 39, 60, 40],
        [16, 0, 17, 40],
    ] {
        let arguments =
            format!("render ball.toml --samples 4 -o crop.exr --crop {x0},{y0},{x1},{y1}");
        succeeds(folder.path(), &arguments);
        let crop = decode(&folder.path().join("crop.exr"));
        assert_eq!(crop.data_window, [x0, y0, x1 - x0, y1 - y0]);
        assert_eq!(crop.display_window, [0, 0, 60, 40]);
        for y in y0..y1 {
            for x in x0..x1 {
                let part = crop.pixel((x - x0) as usize, (y - y0) as usize);
                assert_eq!(part, whole.pixel(x as usize, y as usize));
            }
        }
    }
    let message = fails(folder.path(), "render ball.toml --crop 0,0,60,41", 1);
    assert!(message.contains("60,40"), "{message}");
}

#[test]
fn precision_and_compression() {
    let folder = folder();
    succeeds(
        folder.path(),
        "render ball.toml -o full.exr --compression none",
    );
    let full = image(folder.path(), "full.exr");
    for compression in Compression::ALL {
        for half in ["", "--half"] {
            let name = compression.name();
            let arguments = format!("render ball.toml -o a.exr --compression {name} {half}");
            succeeds(folder.path(), &arguments);
            let info = oiiotool(folder.path(), "--info -v a.exr");
            let kind = if half.is_empty() { "float" } else { "half" };
            assert!(info.contains(&format!("compression: \"{name}\"")), "{info}");
            assert!(info.contains(&format!("4 channel, {kind}")), "{info}");
            if half.is_empty() && !["pxr24", "dwaa", "dwab"].contains(&name) {
                assert_eq!(image(folder.path(), "a.exr").pixels, full.pixels, "{name}");
            }
        }
    }
    // A value beyond the largest HALF is clamped, and the user is told.
    let bright = SCENE.replace("[30, 30, 30]", "1e9");
    fs::write(folder.path().join("bright.toml"), bright).unwrap();
    let output = output(
        folder.path(),
        "render bright.toml --half --stats bright.json",
    );
    assert!(output.status.success());
    assert!(text(&output.stderr).contains("beyond the largest HALF"));
    let pixels = image(folder.path(), "bright.exr").pixels;
    let largest = pixels.iter().flatten().copied().fold(0.0, f32::max);
    assert_eq!(largest, 65_504.0);
    let at_most = pixels.iter().flat_map(|pixel| &pixel[..3]);
    let at_most = at_most.filter(|&&channel| channel == 65_504.0).count() as u64;
    let clamped = json(folder.path(), "bright.json")["clamped_to_half"].as_u64();
    assert_eq!(clamped, Some(at_most));
}

fn json(folder: &Path, name: &str) -> Value {
    serde_json::from_str(&fs::read_to_string(folder.join(name)).unwrap()).unwrap()
}

#[test]
fn statistics() {
    let folder = folder();
    let arguments = "render ball.toml --samples 1 --stats stats.json --threads 2";
    succeeds(folder.path(), arguments);
    let stats = json(folder.path(), "stats.json");
    assert_eq!(stats["image"], serde_json::json!([60, 40]));
    assert_eq!(stats["samples"], 1);
    assert_eq!(stats["threads"], 2);
    assert_eq!(stats["primary_rays"], 60 * 40);
    // One shadow ray to each light above each point that is seen.
    let oracle = Oracle::new(&Scene::parse(SCENE, "ball.toml").unwrap());
    let mut above = 0;
    for y in 0..RESOLUTION[1] {
        for x in 0..RESOLUTION[0] {
            let decisions = oracle.decisions(f64::from(x) + 0.5, f64::from(y) + 0.5);
            let mut lights = decisions.lights.iter();
            above += lights
                .by_ref()
                .filter(|&&light| light != Outcome::Below)
                .count();
        }
    }
    assert_eq!(stats["shadow_rays"], above);
    assert!(stats["plan"].is_object(), "{stats}");
    // A ball and a plane; a batch for each tile of 16 × 16 pixels.
    let work = &stats["work"];
    assert_eq!(work["primary"]["batches"], 4 * 3);
    for rays in ["primary", "shadow"] {
        assert!(work[rays]["fallbacks"].is_u64() && work[rays]["resolved_whole"].is_u64());
        for count in ["leaves", "distinct_leaves", "leaf_bytes", "pairs"] {
            assert_eq!(work[rays][count], 0, "{rays}: {count}");
        }
    }
    let seconds = |name: &str| {
        let seconds = stats["seconds"][name].as_f64().unwrap();
        assert!((0.0..60.0).contains(&seconds), "{name}: {seconds}");
        seconds
    };
    let parts = seconds("load") + seconds("build") + seconds("render") + seconds("write");
    // `write` is what is left of the total, up to the rounding of the sum.
    assert!(seconds("render") > 0.0 && (parts - seconds("total")).abs() < 1e-9);

    succeeds(
        folder.path(),
        "render ball.toml --stats stats.json --samples 4 --crop 10,5,30,25",
    );
    let stats = json(folder.path(), "stats.json");
    assert_eq!(stats["image"], serde_json::json!([60, 40]));
    assert_eq!(stats["samples"], 4);
    assert_eq!(stats["primary_rays"], 20 * 20 * 4);
}

#[test]
fn quiet_is_silent() {
    let folder = folder();
    for (arguments, is_silent) in [
        ("render ball.toml --preview ball.png --quiet", true),
        ("render ball.toml -q", true),
        ("render ball.toml", false),
    ] {
        let output = output(folder.path(), arguments);
        assert!(output.status.success());
        assert_eq!(text(&output.stdout), "");
        assert_eq!(
            output.stderr.is_empty(),
            is_silent,
            "{}",
            text(&output.stderr)
        );
    }
}

#[test]
fn a_preview_is_what_tonemap_makes() {
    let folder = folder();
    for more in ["", "--half", "--samples 5 --compression dwaa"] {
        succeeds(
            folder.path(),
            &format!("render ball.toml --preview preview.png {more}"),
        );
        succeeds(folder.path(), "tonemap ball.exr -o tonemapped.png");
        let chunks = |name: &str| without_texts(&folder.path().join(name));
        assert!(chunks("preview.png") == chunks("tonemapped.png"), "{more}");
    }
}

#[test]
fn checks() {
    let folder = folder();
    let report = succeeds(folder.path(), "check ball.toml");
    for part in [
        "is legal", "60 × 40", "ball", "floor", "clay", "key", "fill", "plan", "left out",
    ] {
        assert!(report.contains(part), "{part}:\n{report}");
    }
    assert_eq!(files(folder.path()), ["ball.toml"]);
    // A scene that is odd is legal.
    let inside = SCENE.replace("position = [3, 4, 3]", "position = [0, 0.5, 0]");
    fs::write(folder.path().join("inside.toml"), inside).unwrap();
    let report = succeeds(folder.path(), "check inside.toml");
    assert!(
        report.contains("`key` is inside of object `ball`"),
        "{report}"
    );
}

/// A quad that bulges by its normals, through the middle of the scene's ball.
const BULGE: &str = "v -1 0.5 -1\nv 1 0.5 -1\nv 1 0.5 1\nv -1 0.5 1\n\
    vn -1 2 -1\nvn 1 2 -1\nvn 1 2 1\nvn -1 2 1\nf 1//1 4//4 3//3 2//2\n";

fn with_bulge(folder: &Path, name: &str, keys: &str) {
    let mesh = format!("[objects.bulge.mesh]\nmaterial = \"clay\"\nfile = \"bulge.obj\"\n{keys}\n");
    fs::write(folder.join("bulge.obj"), BULGE).unwrap();
    fs::write(folder.join(name), format!("{SCENE}\n{mesh}")).unwrap();
}

/// The plan has lifted shadow rays where a smooth mesh asks for them; on one that is shaded flat it is
/// said that the key does nothing.
#[test]
fn check_says_whether_shadow_rays_are_lifted() {
    let folder = folder();
    let hanika = "shadow_terminator = \"hanika\"";
    for (keys, is_lifted, is_warned) in [
        ("", false, false),
        ("shadow_terminator = \"geometric\"", false, false),
        (hanika, true, false),
        (
            "shadow_terminator = \"hanika\"\nsmooth = false",
            false,
            true,
        ),
    ] {
        with_bulge(folder.path(), "bulge.toml", keys);
        let report = succeeds(folder.path(), "check bulge.toml");
        let (computed, left_out) = report.split_once("left out").unwrap();
        let line = "lifted shadow rays (L4)";
        assert_eq!(computed.contains(line), is_lifted, "{report}");
        assert_eq!(left_out.contains(line), !is_lifted, "{report}");
        let warning = "of object `bulge` does nothing: it is shaded flat";
        assert_eq!(report.contains(warning), is_warned, "{report}");
    }
    // A file without normals.
    with_bulge(folder.path(), "bulge.toml", hanika);
    let flat = BULGE
        .replace("vn", "# vn")
        .replace("1//1 4//4 3//3 2//2", "1 4 3 2");
    fs::write(folder.path().join("bulge.obj"), flat).unwrap();
    let report = succeeds(folder.path(), "check bulge.toml");
    assert!(report.contains("does nothing"), "{report}");
}

/// What is left out of the report for its cost is said.
#[test]
fn check_says_why_colors_are_not_compared() {
    let folder = folder();
    // With the clay, the key and the fill: 5000 materials and 5001 lights.
    let more = (1..5000).map(|i| {
        format!(
            "[materials.m{i}.phong]\ndiffuse = 0.5\n\
             [lights.l{i}.point]\nposition = [0, 9, {i}]\nintensity = 1\n"
        )
    });
    let many = SCENE.to_owned() + &more.collect::<String>();
    fs::write(folder.path().join("many.toml"), many).unwrap();
    let report = succeeds(folder.path(), "check many.toml");
    let expected = "colors     not compared with other transport: 5001 lights and 5000 materials take \
                    too long\n";
    assert!(report.contains(expected), "{report}");
    let report = succeeds(folder.path(), "check ball.toml");
    assert!(
        report.contains("ΔE00") && !report.contains("not compared"),
        "{report}"
    );
}
