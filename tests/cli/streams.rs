//! `-`: scenes from standard input, files to standard output.

use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use super::{SCENE, candela, fails, files, folder, succeeds, text};

/// A tetrahedron for scenes that name a mesh.
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
    property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";

/// Runs candela with a file as its standard input.
fn fed(folder: &Path, arguments: &str, file: &str) -> Output {
    candela(folder, arguments)
        .stdin(File::open(folder.join(file)).unwrap())
        .output()
        .unwrap()
}

fn read(folder: &Path, name: &str) -> Vec<u8> {
    fs::read(folder.join(name)).unwrap()
}

/// A scene with a mesh beside it, `models/scene.toml`.
fn with_mesh(folder: &Path) {
    let mesh = "[objects.leaf.mesh]\nmaterial = \"clay\"\nfile = \"leaf.ply\"\n\
        [materials.tin.phong]\ndiffuse = { file = \"tin.csv\" }\n";
    fs::create_dir(folder.join("models")).unwrap();
    fs::write(folder.join("models/scene.toml"), SCENE.to_owned() + mesh).unwrap();
    fs::write(folder.join("models/leaf.ply"), PLY).unwrap();
    fs::write(folder.join("models/tin.csv"), "400,0.5\n700,0.5\n").unwrap();
}

#[test]
fn a_scene_from_standard_input_is_as_from_its_file() {
    let folder = folder();
    let folder = folder.path();
    with_mesh(folder);
    succeeds(folder, "render models/scene.toml -q -o file.exr");
    for (arguments, name) in [
        ("render - --base models -q -o piped.exr", "piped.exr"),
        // The name that a scene without one leaves to the EXR.
        ("render - --base models/../models/ -q", "scene.exr"),
    ] {
        let output = fed(folder, arguments, "models/scene.toml");
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(
            read(folder, name) == read(folder, "file.exr"),
            "{arguments}"
        );
    }
    let output = fed(folder, "check - --base models", "models/scene.toml");
    let report = text(&output.stdout);
    assert!(report.starts_with("<stdin> is legal\n"), "{report}");
    let as_file = succeeds(folder, "check models/scene.toml");
    assert_eq!(
        report.split_once('\n').unwrap().1,
        as_file.split_once('\n').unwrap().1
    );

    let output = fed(
        folder,
        "probe - --base models --pixel 30,20",
        "models/scene.toml",
    );
    let as_file = succeeds(folder, "probe models/scene.toml --pixel 30,20");
    assert_eq!(text(&output.stdout), as_file);
}

#[test]
fn files_of_a_scene_are_found_where_the_base_says() {
    let folder = folder();
    let folder = folder.path();
    with_mesh(folder);
    // Without it, beside where the command runs.
    let output = fed(folder, "check -", "models/scene.toml");
    assert_eq!(output.status.code(), Some(1));
    let message = text(&output.stderr);
    assert!(
        message.contains("cannot use the mesh file leaf.ply: "),
        "{message}"
    );
    assert!(message.contains("--> <stdin>:"), "{message}");
    // For a file as well, in place of its folder.
    fs::rename(folder.join("models/leaf.ply"), folder.join("leaf.ply")).unwrap();
    fs::rename(folder.join("models/tin.csv"), folder.join("tin.csv")).unwrap();
    succeeds(folder, "check models/scene.toml --base .");
    for elsewhere in ["", "--base absent"] {
        let output = candela(folder, &format!("check models/scene.toml {elsewhere}")).output();
        let output = output.unwrap();
        assert_eq!(output.status.code(), Some(1));
        let message = text(&output.stderr);
        assert!(message.contains("leaf.ply: No such file"), "{message}");
    }
    let output = fed(folder, "check -", "models/scene.toml");
    assert!(output.status.success(), "{}", text(&output.stderr));
}

/// What a scene names is read as the scene is, wherever that is.
#[test]
fn outputs_do_not_go_over_files_that_a_base_leads_to() {
    let folder = folder();
    let folder = folder.path();
    with_mesh(folder);
    let mesh = "file = \"leaf";
    let scene = text(&read(folder, "models/scene.toml")).replace("leaf.ply", "leaf");
    assert!(scene.contains(mesh));
    fs::write(folder.join("models/scene.toml"), scene).unwrap();
    fs::copy(folder.join("models/leaf.ply"), folder.join("leaf")).unwrap();
    fs::copy(folder.join("models/tin.csv"), folder.join("tin.csv")).unwrap();
    for outputs in [
        "-o leaf",
        "-o ./leaf",
        "-o a.exr --preview leaf",
        "-o a.exr --stats models/../leaf",
        "-o a.exr --preview tin.csv/../leaf",
    ] {
        let arguments = format!("render models/scene.toml --base . {outputs}");
        let message = fails(folder, &arguments, 1);
        assert!(message.contains("leaf"), "{message}");
        assert!(read(folder, "leaf") == PLY.as_bytes(), "{outputs}");
        assert!(!files(folder).contains(&"a.exr".to_owned()), "{outputs}");
    }
    let output = fed(
        folder,
        "render - --base models -o models/leaf",
        "models/scene.toml",
    );
    assert_eq!(output.status.code(), Some(1));
}

#[test]
fn what_is_wrong_with_standard_input_is_said() {
    let folder = folder();
    fs::write(
        folder.path().join("key.toml"),
        SCENE.replace("radius", "radios"),
    )
    .unwrap();
    fs::write(folder.path().join("empty.toml"), "").unwrap();
    fs::write(folder.path().join("bytes.toml"), b"a = \"\xff\"").unwrap();
    for (file, part) in [
        ("key.toml", "--> <stdin>:"),
        ("empty.toml", "the scene file is empty"),
        ("bytes.toml", "is not UTF-8"),
    ] {
        let output = fed(folder.path(), "render -", file);
        assert_eq!(output.status.code(), Some(1));
        let message = text(&output.stderr);
        assert!(message.contains(part), "{message}");
    }
    // A file of that name has another one as well.
    let message = fails(folder.path(), "check ./-", 1);
    assert!(message.contains("No such file"), "{message}");
    fs::write(folder.path().join("-"), SCENE).unwrap();
    assert!(succeeds(folder.path(), "check ./-").starts_with("./- is legal"));
}

#[test]
fn standard_output_gets_the_file_and_nothing_else() {
    let folder = folder();
    let folder = folder.path();
    succeeds(folder, "render ball.toml -o file.exr --preview file.png");
    succeeds(folder, "tonemap file.exr -o shown.png");
    for (arguments, file) in [
        ("render ball.toml -o -", "file.exr"),
        ("render ball.toml -o piped.exr --preview -", "file.png"),
        ("tonemap file.exr -o -", "shown.png"),
    ] {
        let output = candela(folder, arguments).output().unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert!(output.stdout == read(folder, file), "{arguments}");
        // A file that is open already gets it where it is open.
        let mut command = candela(folder, arguments);
        let status = command
            .stdout(File::create(folder.join("out")).unwrap())
            .stderr(Stdio::null())
            .status();
        assert!(status.unwrap().success());
        assert!(read(folder, "out") == read(folder, file), "{arguments}");
    }
    let output = candela(folder, "render ball.toml -q -o a.exr --stats -").output();
    let stats: serde_json::Value = serde_json::from_slice(&output.unwrap().stdout).unwrap();
    assert_eq!(stats["image"], serde_json::json!([60, 40]));
    assert!(!files(folder).contains(&"-".to_owned()));
    // What is not whole is not sent.
    let output = candela(folder, "render absent.toml -o -").output().unwrap();
    assert_eq!((output.status.code(), output.stdout.len()), (Some(1), 0));
}

/// The preview is made of the EXR, wherever that goes.
#[cfg(unix)]
#[test]
fn a_preview_beside_a_stream() {
    let folder = folder();
    let folder = folder.path();
    succeeds(folder, "render ball.toml -q -o file.exr --preview file.png");
    let temporary = tempfile::tempdir().unwrap();
    for output in ["-", "/dev/stdout", "/dev/null"] {
        let arguments = format!("render ball.toml -q -o {output} --preview made.png");
        let run = candela(folder, &arguments)
            .env("TMPDIR", temporary.path())
            .output()
            .unwrap();
        assert!(run.status.success(), "{}", text(&run.stderr));
        if output == "/dev/null" {
            assert_eq!(run.stdout.len(), 0);
        } else {
            assert!(run.stdout == read(folder, "file.exr"), "{output}");
        }
        assert!(
            read(folder, "made.png") == read(folder, "file.png"),
            "{output}"
        );
        assert_eq!(files(temporary.path()), [""; 0], "{output}");
        fs::remove_file(folder.join("made.png")).unwrap();
    }
    // Nothing is kept in a file to make the preview of.
    let run = candela(folder, "render ball.toml -q -o - --preview made.png")
        .env("TMPDIR", folder.join("absent"))
        .output()
        .unwrap();
    assert!(run.status.success(), "{}", text(&run.stderr));
    assert!(run.stdout == read(folder, "file.exr"));
    assert!(read(folder, "made.png") == read(folder, "file.png"));
}

/// More than is kept in memory until it is whole.
#[test]
fn standard_output_gets_large_files_too() {
    let folder = folder();
    let folder = folder.path();
    let scene = SCENE.replace("[60, 40]", "[1600, 800]");
    fs::write(folder.join("ball.toml"), scene).unwrap();
    let render = "render ball.toml -q --samples 1 --compression none -o";
    succeeds(folder, &format!("{render} file.exr"));
    let output = candela(folder, &format!("{render} -")).output().unwrap();
    assert!(output.status.success(), "{}", text(&output.stderr));
    assert!(output.stdout.len() > 20_000_000);
    assert!(output.stdout == read(folder, "file.exr"));
}

#[test]
fn two_outputs_do_not_share_standard_output() {
    let folder = folder();
    let folder = folder.path();
    let mut cases = vec!["-o - --stats -", "-o a.exr --preview - --stats -"];
    if cfg!(target_os = "linux") {
        cases.extend([
            "-o - --preview /dev/stdout",
            "-o /dev/fd/1 --stats /proc/self/fd/1",
        ]);
    }
    for outputs in cases {
        let message = fails(folder, &format!("render ball.toml {outputs}"), 2);
        assert!(message.contains("would go to standard output"), "{message}");
    }
    assert_eq!(files(folder), ["ball.toml"]);
}

/// Standard output and input may be files that the command names, too.
#[cfg(unix)]
#[test]
fn redirected_files_are_places() {
    let folder = folder();
    let folder = folder.path();
    let path = folder.join("p.png");
    let mut command = candela(folder, "render ball.toml -o - --preview p.png");
    let output = command
        .stdout(File::create(&path).unwrap())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    let message = text(&output.stderr);
    assert!(message.contains("would be one file"), "{message}");

    fs::write(folder.join("scene"), SCENE).unwrap();
    let output = fed(folder, "render - -o scene", "scene");
    assert_eq!(output.status.code(), Some(1));
    let message = text(&output.stderr);
    assert!(message.contains("which is read"), "{message}");
    assert_eq!(fs::read_to_string(folder.join("scene")).unwrap(), SCENE);
}

/// Runs candela at a terminal of its own, which copies to standard output.
#[cfg(unix)]
fn at_a_terminal(folder: &Path, arguments: &str) -> Command {
    let spawn = "import os, pty, sys\n\
        sys.exit(os.waitstatus_to_exitcode(pty.spawn(sys.argv[1:])))";
    let mut command = Command::new("python3");
    command
        .current_dir(folder)
        .args(["-c", spawn, env!("CARGO_BIN_EXE_candela")])
        .args(arguments.split_whitespace())
        .stdin(Stdio::null());
    command
}

/// Colors are for terminals that have them, and for who has not asked for none (no-color.org).
#[cfg(unix)]
#[test]
fn errors_are_colored_where_that_is_wanted() {
    let folder = folder();
    for (term, no_color, is_colored) in [
        ("xterm", None, true),
        ("xterm", Some(""), true),
        ("xterm", Some("1"), false),
        ("dumb", None, false),
    ] {
        // A scene's error, and one of the command line.
        for (arguments, code) in [("check absent.toml", 1), ("rendr", 2)] {
            let mut command = at_a_terminal(folder.path(), arguments);
            for name in ["NO_COLOR", "CLICOLOR", "CLICOLOR_FORCE"] {
                command.env_remove(name);
            }
            // Machines that test set it, and clap heeds it.
            command.env("CI", "true").env("TERM", term);
            if let Some(value) = no_color {
                command.env("NO_COLOR", value);
            }
            let output = match command.output() {
                Ok(output) => output,
                Err(error) => {
                    return println!("python3 is not here ({error}): no terminal is tried");
                }
            };
            let shown = text(&output.stdout);
            assert_eq!(output.status.code(), Some(code), "{shown}");
            assert!(shown.contains("error"), "{shown}");
            assert_eq!(
                shown.contains('\u{1b}'),
                is_colored,
                "{term} {no_color:?}: {shown:?}"
            );
        }
    }
}

/// Bytes that are no text would garble a terminal; text is welcome there.
#[cfg(unix)]
#[test]
fn no_picture_is_sent_to_a_terminal() {
    let folder = folder();
    let folder = folder.path();
    succeeds(folder, "render ball.toml -q -o file.exr");
    for (arguments, code, part) in [
        ("render ball.toml -q -o -", 1, "it is a terminal"),
        (
            "render ball.toml -q -o a.exr --preview -",
            1,
            "it is a terminal",
        ),
        ("tonemap file.exr -o -", 1, "it is a terminal"),
        ("render ball.toml -q -o a.exr --stats -", 0, "\"samples\""),
    ] {
        let output = match at_a_terminal(folder, arguments).output() {
            Ok(output) => output,
            Err(error) => return println!("python3 is not here ({error}): no terminal is tried"),
        };
        let shown = text(&output.stdout);
        assert_eq!(output.status.code(), Some(code), "{arguments}: {shown}");
        assert!(shown.contains(part), "{arguments}: {shown}");
    }
    assert_eq!(files(folder), ["a.exr", "ball.toml", "file.exr"]);
}
