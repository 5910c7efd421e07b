//! `candela relight` on the command line.

use std::fs;
use std::process::Stdio;

use super::{candela, fails, files, folder, succeeds, text};

#[test]
fn a_light_goes_off() {
    let folder = folder();
    succeeds(
        folder.path(),
        "render ball.toml -q --samples 4 --layers lights -o a.exr",
    );
    let output = candela(
        folder.path(),
        "relight a.exr -o b.exr --light fill=off --light",
    );
    let output = { output }.arg("key = 2").output().unwrap();
    let message = text(&output.stderr);
    assert!(
        output.status.success() && output.stdout.is_empty(),
        "{message}"
    );
    assert_eq!(
        message.lines().next(),
        Some("b.exr: 60 × 40, relit with fill=off key = 2")
    );
    let scene = super::SCENE.replace("[30, 30, 30]", "[60, 60, 60]");
    let scene = scene.replace("intensity = 4", "intensity = 0");
    fs::write(folder.path().join("ball.toml"), scene).unwrap();
    succeeds(
        folder.path(),
        "render ball.toml -q --samples 4 --layers lights -o c.exr",
    );
    succeeds(folder.path(), "diff c.exr b.exr --max-relative 1e-6");
    assert!(!succeeds(folder.path(), "diff c.exr a.exr").is_empty());
    // In place, through a pipe, and without a word.
    let quiet = |arguments: &str| {
        let output = candela(folder.path(), arguments).output().unwrap();
        assert_eq!(text(&output.stderr), "", "{arguments}");
        output.stdout
    };
    quiet("relight a.exr -o a.exr -q --light fill=off");
    quiet("relight a.exr -o a.exr -q --light key=2");
    succeeds(folder.path(), "diff a.exr b.exr --max-relative 1e-6");
    let piped = candela(folder.path(), "relight - -o - -q --light key=1")
        .stdin(fs::File::open(folder.path().join("a.exr")).unwrap())
        .output()
        .unwrap();
    fs::write(folder.path().join("piped.exr"), piped.stdout).unwrap();
    succeeds(folder.path(), "diff a.exr piped.exr --max-relative 0");
}

#[test]
fn wrong_words_are_2() {
    let folder = folder();
    for (arguments, part) in [
        ("relight a.exr --light key=2", "--output"),
        ("relight a.exr -o b.exr", "--light"),
        ("relight a.exr -o b.exr --light key", "expected NAME=VALUE"),
        ("relight a.exr -o b.exr --light key=-1", "`-1` is no factor"),
        ("relight a.exr -o b.exr --light key=2,red", "is no color"),
        ("relight a.exr -o b.png --light key=2", "b.exr"),
    ] {
        let message = fails(folder.path(), arguments, 2);
        assert!(message.contains(part), "{arguments}: {message}");
    }
    assert_eq!(files(folder.path()), ["ball.toml"]);
}

/// Nothing is damaged, and one message says what is wrong.
#[test]
fn what_is_wrong_leaves_all_as_it_was() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    succeeds(
        folder.path(),
        "render ball.toml -q --samples 1 -o plain.exr",
    );
    succeeds(
        folder.path(),
        "render ball.toml -q --samples 1 --layers lights -o a.exr",
    );
    let bytes = fs::read(path("a.exr")).unwrap();
    fs::write(path("cut.exr"), &bytes[..bytes.len() / 2]).unwrap();
    fs::write(path("text.exr"), "no EXR").unwrap();
    fs::write(path("old.exr"), "old").unwrap();
    let before = files(folder.path());
    for (arguments, part) in [
        (
            "relight plain.exr -o old.exr --light key=2",
            "cannot relight plain.exr: it has no layer",
        ),
        (
            "relight a.exr -o old.exr --light kye=2",
            "did you mean `key`?",
        ),
        (
            "relight cut.exr -o old.exr --light key=2",
            "cannot read cut.exr",
        ),
        (
            "relight cut.exr -o cut.exr --light key=2",
            "cannot read cut.exr",
        ),
        (
            "relight text.exr -o old.exr --light key=2",
            "it is not an OpenEXR file",
        ),
        (
            "relight absent.exr -o old.exr --light key=2",
            "cannot read absent.exr",
        ),
        (
            "relight a.exr -o absent/b.exr --light key=2",
            "the folder absent does not exist",
        ),
    ] {
        let message = fails(folder.path(), arguments, 1);
        assert!(message.contains(part), "{arguments}: {message}");
    }
    if cfg!(target_os = "linux") {
        // Where even root cannot write, and a disk that is full.
        let message = fails(
            folder.path(),
            "relight a.exr -o /proc/b.exr --light key=2",
            1,
        );
        assert!(message.contains("/proc/b.exr"), "{message}");
        let arguments = "relight a.exr -o - --light key=2";
        let full = fs::OpenOptions::new()
            .write(true)
            .open("/dev/full")
            .unwrap();
        let output = candela(folder.path(), arguments)
            .stdout(full)
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(75), "{message}");
        assert!(message.contains("the disk is full"), "{message}");
    }
    assert_eq!(files(folder.path()), before);
    assert_eq!(fs::read(path("old.exr")).unwrap(), b"old");
    assert!(fs::read(path("a.exr")).unwrap() == bytes);
}

/// A file that grows beyond a limit amid the writing, as on a small disk.
#[cfg(unix)]
#[test]
fn a_disk_that_fills_up_keeps_the_old_file() {
    let folder = folder();
    let scene = super::SCENE.replace("[60, 40]", "[600, 400]");
    fs::write(folder.path().join("ball.toml"), scene).unwrap();
    let render = "render ball.toml -q --samples 1 --compression none --layers lights -o a.exr";
    succeeds(folder.path(), render);
    let bytes = fs::read(folder.path().join("a.exr")).unwrap();
    let output = std::process::Command::new("sh")
        .current_dir(folder.path())
        .args([
            "-c",
            "ulimit -f 1000; exec \"$0\" relight a.exr -o a.exr --light key=2",
        ])
        .arg(env!("CARGO_BIN_EXE_candela"))
        .output()
        .unwrap();
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(75), "{message}");
    assert!(
        message.contains("larger than the file size limit"),
        "{message}"
    );
    assert_eq!(files(folder.path()), ["a.exr", "ball.toml"]);
    assert!(fs::read(folder.path().join("a.exr")).unwrap() == bytes);
}
