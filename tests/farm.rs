//! Jobs for farms, run by a real engine: `openjd` of `tests/setup.sh`, and the scripts by bash.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::conformance::printed;

const SCENE: &str = r#"
[image]
resolution = [64, 96]

[camera.perspective]
eye = { keys = [[1, [0, 1, 4]], [24, [2, 1, 3]]] }
look_at = [0.0, 0.6, 0.0]
vertical_fov = 40.0

[materials.clay.phong]
diffuse = [0.7, 0.3, 0.2]

[lights.key.point]
position = [3, 4, 3]
intensity = 30

[objects.ball.sphere]
material = "clay"
center = [0, 0.5, 0]
radius = 0.5
"#;

/// A name that shells, YAML and format strings would each take for something else.
const NASTY: &str = "it's {{Param.X}} \"$(a)\" ä 100% #1.toml";

fn folder(scene: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(scene), SCENE).unwrap();
    folder
}

fn candela(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_candela"));
    command
        .current_dir(folder)
        .args(arguments)
        .output()
        .unwrap()
}

fn succeeds(folder: &Path, arguments: &[&str]) -> String {
    let output = candela(folder, arguments);
    assert!(
        output.status.success(),
        "{arguments:?}: {}",
        printed(&output)
    );
    String::from_utf8(output.stdout).unwrap()
}

/// Writes what `candela job` prints to a file.
fn job(folder: &Path, name: &str, arguments: &[&str]) -> String {
    let text = succeeds(folder, &[&["job"], arguments].concat());
    fs::write(folder.join(name), &text).unwrap();
    text
}

/// The engine; none where `tests/setup.sh` has not installed it.
fn openjd(folder: &Path) -> Option<Command> {
    let program = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/openjd/bin/openjd");
    if !program.exists() {
        println!(
            "skipped: {} is missing; ./check installs it",
            program.display()
        );
        return None;
    }
    let mut command = Command::new(program);
    command
        .current_dir(folder)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        // Else its lines come when it has ended.
        .env("PYTHONUNBUFFERED", "1");
    Some(command)
}

fn is_legal(folder: &Path, template: &str) {
    let Some(mut openjd) = openjd(folder) else {
        return;
    };
    let output = openjd.args(["check", template]).output().unwrap();
    assert!(output.status.success(), "{}", printed(&output));
}

/// Runs a template with this build of candela; None where there is no engine.
fn run(folder: &Path, template: &str, more: &[&str]) -> Option<Output> {
    let program = concat!("Candela=", env!("CARGO_BIN_EXE_candela"));
    let mut openjd = openjd(folder)?;
    openjd.args(["run", template, "-p", program]).args(more);
    Some(openjd.output().unwrap())
}

fn read(folder: &Path, name: &str) -> Vec<u8> {
    fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// When files were written, which does not change where they are left alone.
fn times(folder: &Path, names: &[String]) -> Vec<std::time::SystemTime> {
    let time = |name: &String| fs::metadata(folder.join(name)).unwrap().modified().unwrap();
    names.iter().map(time).collect()
}

#[test]
fn templates_are_legal() {
    let folder = folder("shot.toml");
    let folder = folder.path();
    fs::write(folder.join(NASTY), SCENE).unwrap();
    fs::create_dir(folder.join("out")).unwrap();
    let cases: [&[&str]; 9] = [
        &["shot.toml"],
        &["shot.toml", "--frames", "1-100"],
        &[
            "shot.toml",
            "--frames",
            "1-100x2,200",
            "-o",
            "out/f_%05d.exr",
        ],
        &["shot.toml", "--frames", "-3-3"],
        &["shot.toml", "--tiles", "6"],
        &[
            "shot.toml",
            "--frames",
            "1-3,8.5",
            "--tiles",
            "2",
            "-o",
            "f.####.exr",
        ],
        &[
            "shot.toml",
            "--frames",
            "1-9",
            "--",
            "--samples",
            "4",
            "--layers",
            "lights",
        ],
        &[NASTY, "--frames", "1-4"],
        &[NASTY, "--tiles", "3", "-o", "{{a}} 'b'.exr"],
    ];
    for arguments in cases {
        job(folder, "job.yaml", arguments);
        is_legal(folder, "job.yaml");
    }
    let scene = folder.join("shot.toml");
    job(
        folder,
        "job.yaml",
        &[scene.to_str().unwrap(), "--frames", "1-4"],
    );
    is_legal(folder, "job.yaml");
}

#[test]
fn chunks_are_stated_and_stable() {
    let folder = folder("shot.toml");
    let folder = folder.path();
    let arguments = [
        "shot.toml",
        "--frames",
        "1-100",
        "--seconds-per-frame",
        "11",
    ];
    let text = job(folder, "job.yaml", &arguments);
    assert!(text.contains("defaultTaskCount: 25\n"), "{text}");
    assert_eq!(text, job(folder, "job.yaml", &arguments));
    // A frame of a few thousand pixels takes no second anywhere.
    let text = job(folder, "job.yaml", &["shot.toml", "--frames", "1-100"]);
    assert!(text.contains("defaultTaskCount: 100\n"), "{text}");
}

#[test]
fn frames_run_and_run_again_for_nothing() {
    let folder = folder(NASTY);
    let folder = folder.path();
    let arguments = [
        NASTY,
        "--frames",
        "1-5:2",
        "-o",
        "f {{x}}.####.exr",
        "--",
        "--samples",
        "4",
    ];
    job(folder, "job.yaml", &arguments);
    let Some(output) = run(folder, "job.yaml", &[]) else {
        return;
    };
    let said = printed(&output);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("openjd_progress"), "{said}");
    let frames = ["1", "3", "5"].map(|frame| format!("f {{{{x}}}}.000{frame}.exr"));
    succeeds(
        folder,
        &[
            "render",
            NASTY,
            "--frame",
            "3",
            "--samples",
            "4",
            "-o",
            "own.exr",
            "-q",
        ],
    );
    assert!(read(folder, "own.exr") == read(folder, &frames[1]));

    // A frame that is lost is made again; the others are left alone.
    fs::remove_file(folder.join(&frames[1])).unwrap();
    let left = [frames[0].clone(), frames[2].clone()];
    let before = times(folder, &left);
    let output = run(folder, "job.yaml", &[]).unwrap();
    assert!(output.status.success(), "{}", printed(&output));
    assert_eq!(times(folder, &left), before);
    assert!(read(folder, "own.exr") == read(folder, &frames[1]));
}

#[test]
fn tiles_are_merged() {
    let folder = folder("shot.toml");
    let folder = folder.path();
    fs::create_dir(folder.join("out")).unwrap();
    job(
        folder,
        "job.yaml",
        &["shot.toml", "--tiles", "3", "-o", "out/still.exr"],
    );
    let Some(output) = run(folder, "job.yaml", &[]) else {
        return;
    };
    assert!(output.status.success(), "{}", printed(&output));
    succeeds(folder, &["render", "shot.toml", "-o", "own.exr", "-q"]);
    assert!(read(folder, "own.exr") == read(folder, "out/still.exr"));

    job(
        folder,
        "job.yaml",
        &[
            "shot.toml",
            "--frames",
            "2,10",
            "--tiles",
            "2",
            "-o",
            "out/f.####.exr",
        ],
    );
    let output = run(folder, "job.yaml", &[]).unwrap();
    assert!(output.status.success(), "{}", printed(&output));
    succeeds(
        folder,
        &[
            "render",
            "shot.toml",
            "--frame",
            "10",
            "-o",
            "own.exr",
            "-q",
        ],
    );
    assert!(read(folder, "own.exr") == read(folder, "out/f.0010.exr"));
}

#[test]
fn a_task_that_fails_says_why() {
    let folder = folder("shot.toml");
    let folder = folder.path();
    job(folder, "job.yaml", &["shot.toml", "--frames", "1-4"]);
    fs::write(
        folder.join("shot.toml"),
        SCENE.replace("vertical_fov", "vertical_fog"),
    )
    .unwrap();
    let Some(output) = run(folder, "job.yaml", &[]) else {
        return;
    };
    assert_eq!(output.status.code(), Some(1), "{}", printed(&output));
    let said = printed(&output);
    assert!(said.contains("unknown key `vertical_fog`"), "{said}");
}

#[cfg(unix)]
#[test]
fn a_cancel_leaves_nothing_half_written() {
    let folder = folder("shot.toml");
    let folder = folder.path();
    let large = SCENE.replace("[64, 96]", "[4000, 4000]");
    fs::write(folder.join("shot.toml"), large).unwrap();
    job(
        folder,
        "job.yaml",
        &["shot.toml", "-o", "still.exr", "--", "--samples", "256"],
    );
    let Some(mut openjd) = openjd(folder) else {
        return;
    };
    let program = concat!("Candela=", env!("CARGO_BIN_EXE_candela"));
    openjd.args(["run", "job.yaml", "-p", program]);
    let log = fs::File::create(folder.join("log")).unwrap();
    let mut child = openjd
        .stdout(log.try_clone().unwrap())
        .stderr(log)
        .spawn()
        .unwrap();
    let start = Instant::now();
    while !fs::read_to_string(folder.join("log"))
        .unwrap()
        .contains("openjd_progress")
    {
        assert!(
            start.elapsed() < Duration::from_secs(300),
            "nothing is rendered"
        );
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        std::thread::sleep(Duration::from_millis(50));
    }
    let kill = Command::new("kill")
        .args(["-TERM", &child.id().to_string()])
        .status();
    assert!(kill.unwrap().success());
    let status = child.wait().unwrap();
    let log = fs::read_to_string(folder.join("log")).unwrap();
    assert!(!status.success(), "{log}");
    assert!(log.to_lowercase().contains("cancel"), "{log}");
    assert_eq!(names(folder), ["job.yaml", "log", "shot.toml"], "{log}");
}

/// Runs a task of a Slurm script, without Slurm.
fn task(folder: &Path, script: &str, task: usize, more: &[&str]) {
    let mut bash = Command::new("bash");
    bash.current_dir(folder).arg(script).args(more);
    bash.env("CANDELA", env!("CARGO_BIN_EXE_candela"));
    bash.env("SLURM_ARRAY_TASK_ID", task.to_string());
    let output = bash.output().unwrap();
    assert!(output.status.success(), "{}", printed(&output));
}

#[cfg(unix)]
#[test]
fn scripts_for_slurm_run() {
    let folder = folder(NASTY);
    let folder = folder.path();
    let name = "it's $(x).####.exr";
    let script = job(
        folder,
        "job.sh",
        &[
            NASTY,
            "--frames",
            "1-3",
            "--engine",
            "slurm",
            "--seconds-per-frame",
            "150",
            "-o",
            name,
        ],
    );
    assert!(script.contains("#SBATCH --array=0-1\n"), "{script}");
    task(folder, "job.sh", 0, &[]);
    task(folder, "job.sh", 1, &[]);
    let frames = names(folder)
        .iter()
        .filter(|name| name.starts_with("it's $(x).000"))
        .count();
    assert_eq!(frames, 3);

    // One chunk, and a still.
    for arguments in [
        &[NASTY, "--frames", "1-2", "-o", "g.####.exr"][..],
        &[NASTY, "-o", "h.exr"],
    ] {
        job(
            folder,
            "job.sh",
            &[arguments, &["--engine", "slurm"]].concat(),
        );
        task(folder, "job.sh", 0, &[]);
    }
    assert!(folder.join("g.0002.exr").exists() && folder.join("h.exr").exists());

    let slurm = ["--engine", "slurm", "--tiles", "2"];
    job(
        folder,
        "job.sh",
        &[&[NASTY, "-o", "a b.exr"][..], &slurm].concat(),
    );
    task(folder, "job.sh", 0, &[]);
    task(folder, "job.sh", 1, &[]);
    task(folder, "job.sh", 0, &["merge"]);
    succeeds(folder, &["render", NASTY, "-o", "own.exr", "-q"]);
    assert!(read(folder, "own.exr") == read(folder, "a b.exr"));

    job(
        folder,
        "job.sh",
        &[&[NASTY, "--frames", "7,9", "-o", name][..], &slurm].concat(),
    );
    for index in 0..4 {
        task(folder, "job.sh", index, &[]);
    }
    task(folder, "job.sh", 0, &["merge"]);
    succeeds(
        folder,
        &["render", NASTY, "--frame", "9", "-o", "own.exr", "-q"],
    );
    assert!(read(folder, "own.exr") == read(folder, "it's $(x).0009.exr"));
}

#[cfg(unix)]
#[test]
fn lists_for_opencue_are_commands() {
    let folder = folder(NASTY);
    let folder = folder.path();
    let arguments = [
        NASTY,
        "--frames",
        "1-3",
        "--engine",
        "opencue",
        "--seconds-per-frame",
        "100",
        "-o",
        "f.####.exr",
    ];
    let list = job(folder, "list.txt", &arguments);
    assert_eq!(list.lines().count(), 2, "{list}");
    let path = std::env::var("PATH").unwrap_or_default();
    let program = PathBuf::from(env!("CARGO_BIN_EXE_candela"));
    let path = format!("{}:{path}", program.parent().unwrap().display());
    let mut sh = Command::new("sh");
    let output = sh
        .current_dir(folder)
        .arg("list.txt")
        .env("PATH", path)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", printed(&output));
    assert!(folder.join("f.0003.exr").exists());
}

#[test]
fn bundles_name_every_file() {
    let folder = folder("shot.toml");
    let folder = folder.path();
    fs::write(
        folder.join("more.toml"),
        "[lights.fill.point]\nposition = [0, 3, 3]\nintensity = 4\n",
    )
    .unwrap();
    fs::write(
        folder.join("shot.toml"),
        format!("include = [\"more.toml\"]\n{SCENE}"),
    )
    .unwrap();
    let printed = job(
        folder,
        "job.yaml",
        &["shot.toml", "--frames", "1-3", "--bundle", "bundle"],
    );
    assert_eq!(printed, "");
    let bundle = folder.join("bundle");
    assert_eq!(
        names(&bundle),
        [
            "asset_references.yaml",
            "parameter_values.yaml",
            "template.yaml"
        ]
    );
    is_legal(&bundle, "template.yaml");
    let assets = String::from_utf8(read(&bundle, "asset_references.yaml")).unwrap();
    for name in ["shot.toml", "more.toml"] {
        let path = fs::canonicalize(folder).unwrap().join(name);
        assert!(assets.contains(path.to_str().unwrap()), "{assets}");
    }
}

#[test]
fn what_is_no_job_is_said() {
    let folder = folder("shot.toml");
    let folder = folder.path();
    let cases: [(&[&str], i32, &str); 15] = [
        (&["shot.toml", "--tiles", "7"], 2, "from 1 to 6"),
        (&["shot.toml", "--tiles", "0"], 2, "from 1 to"),
        (&["-"], 2, "no standard input"),
        (&["none.toml"], 1, "none.toml"),
        (
            &["shot.toml", "--frames", "1-3", "-o", "f.exr"],
            2,
            "f.####.exr",
        ),
        (
            &["shot.toml", "--frames", "1", "--tiles", "2", "-o", "f.exr"],
            2,
            "f.####.exr",
        ),
        (&["shot.toml", "--", "--sampels", "4"], 2, "--sampels"),
        (&["shot.toml", "--", "--frames", "1"], 2, "after `--`"),
        (
            &["shot.toml", "-o", "a.exr", "--", "-o", "b.exr"],
            2,
            "after `--`",
        ),
        (&["shot.toml", "--", "-o", "b.exr"], 2, "after `--`"),
        (
            &["shot.toml", "--", "--preview", "b.png"],
            2,
            "candela tonemap",
        ),
        (&["shot.toml", "--", "--tile", "0/2"], 2, "--tiles"),
        (
            &["shot.toml", "--engine", "opencue", "--tiles", "2"],
            2,
            "openjd or slurm",
        ),
        (
            &["shot.toml", "--engine", "slurm", "--bundle", "b"],
            2,
            "--engine openjd",
        ),
        (
            &["shot.toml", "--frames", "1.5,2", "-o", "f.####.exr"],
            1,
            "whole numbers",
        ),
    ];
    for (arguments, code, part) in cases {
        let output = candela(folder, &[&["job"], arguments].concat());
        assert_eq!(
            output.status.code(),
            Some(code),
            "{arguments:?}: {}",
            printed(&output)
        );
        assert!(output.stdout.is_empty(), "{arguments:?}");
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(message.contains(part), "{arguments:?}: {message}");
        assert_eq!(message.matches("error: ").count(), 1, "{message}");
    }
    assert_eq!(names(folder), ["shot.toml"]);
}
