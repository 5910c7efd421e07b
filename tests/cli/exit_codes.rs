//! The exit codes, which scripts and queues go by: docs/exit-codes.md.

use std::fs;
use std::process::{Command, Output, Stdio};

use super::{SCENE, candela, fails, folder, succeeds, text};

/// Runs candela with a shell's words before it, such as limits.
#[cfg(unix)]
fn after(folder: &std::path::Path, words: &str, arguments: &str) -> Output {
    Command::new("sh")
        .current_dir(folder)
        .args(["-c", &format!("{words}; exec \"$0\" {arguments}")])
        .arg(env!("CARGO_BIN_EXE_candela"))
        .output()
        .unwrap()
}

#[test]
fn the_help_and_the_page_list_them() {
    let help = succeeds(folder().path(), "--help");
    let page = include_str!("../../docs/exit-codes.md");
    for code in ["0", "1", "2", "3", "75", "128 + n"] {
        let in_help = help
            .lines()
            .any(|line| line.trim_start().starts_with(&format!("{code}  ")));
        assert!(in_help, "{code}: {help}");
        assert!(page.contains(&format!("| {code} |")), "{code}");
    }
}

#[cfg(unix)]
#[test]
fn what_is_wrong_by_itself_is_1() {
    let folder = folder();
    fs::write(
        folder.path().join("bad.toml"),
        SCENE.replace("0.5, 0]", "]"),
    )
    .unwrap();
    fs::write(folder.path().join("bad.exr"), "no EXR").unwrap();
    // A link to itself, and what cannot be read like a file.
    let _socket = std::os::unix::net::UnixListener::bind(folder.path().join("socket")).unwrap();
    std::os::unix::fs::symlink("loop", folder.path().join("loop")).unwrap();
    let mesh = "[objects.m.mesh]\nmaterial = \"clay\"\nfile = \"loop\"\n";
    fs::write(folder.path().join("mesh.toml"), SCENE.to_owned() + mesh).unwrap();
    for arguments in [
        "render bad.toml",
        "check absent.toml",
        "tonemap absent.exr",
        "tonemap bad.exr",
        "check loop",
        "tonemap loop",
        "check socket",
        "tonemap socket -o a.png",
        "check mesh.toml",
        "render ball.toml -o absent/a.exr",
        "probe ball.toml --pixel 60,0",
    ] {
        fails(folder.path(), arguments, 1);
    }
}

/// A disk that is full today may have room tomorrow.
#[cfg(target_os = "linux")]
#[test]
fn what_a_later_try_may_cure_is_75() {
    let folder = folder();
    let full = || {
        fs::OpenOptions::new()
            .write(true)
            .open("/dev/full")
            .unwrap()
    };
    for arguments in [
        "render ball.toml -q -o /dev/full",
        "render ball.toml -q -o a.exr --preview /dev/full",
        "render ball.toml -q -o a.exr --stats /dev/full",
        "tonemap a.exr -o /dev/full",
    ] {
        let message = fails(folder.path(), arguments, 75);
        assert!(message.contains("the disk is full"), "{message}");
    }
    for arguments in [
        "check ball.toml",
        "probe ball.toml --pixel 30,20",
        "probe ball.toml --pixel 30,20 --json",
        "completions bash",
        "schema",
        "man",
        "new fresh",
        "render ball.toml -q -o -",
        "--help",
        "check --help",
        "--version",
    ] {
        let output = candela(folder.path(), arguments).stdout(full()).output();
        let output = output.unwrap();
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(75), "{arguments}: {message}");
        assert!(
            message.starts_with("error: cannot write to standard output: the disk is full"),
            "{message}"
        );
    }
}

/// The limit of `ulimit -f` comes with a signal, which would end the program without a word.
#[cfg(target_os = "linux")]
#[test]
fn a_file_beyond_the_size_limit_is_75_and_leaves_nothing() {
    let folder = folder();
    let scene = SCENE.replace("[60, 40]", "[600, 400]");
    fs::write(folder.path().join("ball.toml"), scene).unwrap();
    for ignored in ["", "; trap '' XFSZ"] {
        let render = "render ball.toml -q --compression none -o a.exr";
        let output = after(folder.path(), &format!("ulimit -f 1000{ignored}"), render);
        let message = text(&output.stderr);
        assert_eq!(output.status.code(), Some(75), "{message}");
        assert!(
            message.contains("larger than the file size limit"),
            "{message}"
        );
        assert_eq!(message.lines().count(), 1, "{message}");
        assert_eq!(super::files(folder.path()), ["ball.toml"]);
    }
    // Standard output may be a file as well.
    let output = after(
        folder.path(),
        "ulimit -f 1000; exec > out",
        "render ball.toml -q --compression none -o -",
    );
    assert_eq!(output.status.code(), Some(75), "{}", text(&output.stderr));
}

/// What is tried later must not stumble over what is there from the first time.
#[cfg(target_os = "linux")]
#[test]
fn a_new_scene_may_be_tried_again() {
    let folder = folder();
    // The scene would fit, the schema does not.
    let output = after(folder.path(), "ulimit -f 10", "new fresh");
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(75), "{message}");
    assert!(
        message.contains("candela.schema.json: the file is larger"),
        "{message}"
    );
    assert_eq!(super::files(&folder.path().join("fresh")), [""; 0]);
    succeeds(folder.path(), "new fresh");
}

#[cfg(target_os = "linux")]
#[test]
fn threads_that_the_system_does_not_give_are_75() {
    let folder = folder();
    // The stacks of so many threads do not fit into so much address space, in kB.
    let output = after(
        folder.path(),
        "unset RUST_MIN_STACK; ulimit -v 1000000",
        "render ball.toml -q --threads 1024",
    );
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(75), "{message}");
    assert!(
        message.starts_with("error: cannot start the threads"),
        "{message}"
    );
    assert_eq!(message.lines().count(), 1, "{message}");
    assert_eq!(super::files(folder.path()), ["ball.toml"]);
}

#[test]
fn a_wrong_number_of_threads_in_the_environment_is_no_error() {
    let folder = folder();
    for (said, threads) in [
        ("100000", Some(1024)),
        ("3", Some(3)),
        ("0", None),
        ("many", None),
    ] {
        let output = candela(folder.path(), "render ball.toml -q --stats a.json")
            .env("RAYON_NUM_THREADS", said)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", text(&output.stderr));
        let used = super::json(folder.path(), "a.json")["threads"].as_u64();
        let there = std::thread::available_parallelism().map_or(1, usize::from) as u64;
        assert_eq!(used, Some(threads.unwrap_or(there.min(1024))), "{said}");
    }
}

/// What is closed or full is no reason to panic.
#[cfg(unix)]
#[test]
fn streams_that_cannot_be_used_are_no_panic() {
    let folder = folder();
    for (redirected, arguments, code) in [
        (">&-", "check ball.toml", 0),
        (">&- 2>&- <&-", "check ball.toml", 0),
        (">&-", "probe ball.toml --pixel 30,20", 0),
        (">&-", "completions bash", 0),
        (">&-", "schema", 0),
        (">&-", "man", 0),
        (">&-", "new fresh", 0),
        ("2>&-", "render ball.toml -o a.exr", 0),
        ("2>&-", "render absent.toml", 1),
        (">&- 2>&-", "rendr", 2),
        ("<&-", "check -", 1),
        // Not open for writing.
        ("1</dev/null", "render ball.toml -q -o -", 1),
    ] {
        let output = after(folder.path(), &format!("exec {redirected}"), arguments);
        let message = text(&output.stderr);
        assert_eq!(
            output.status.code(),
            Some(code),
            "{arguments} {redirected}: {message}"
        );
        assert!(!message.contains("panicked"), "{message}");
    }
    if cfg!(target_os = "linux") {
        for (arguments, code) in [
            ("render ball.toml", 0),
            ("check absent.toml", 1),
            ("rendr", 2),
        ] {
            let output = after(folder.path(), "exec 2>/dev/full", arguments);
            assert_eq!(output.status.code(), Some(code), "{arguments}");
        }
    }
}

/// Whoever reads the picture has seen enough.
#[test]
fn a_reader_that_went_away_is_0() {
    let folder = folder();
    for arguments in [
        "render ball.toml -q -o -",
        "render ball.toml -q -o a.exr --preview -",
        "render ball.toml -q -o a.exr --stats -",
        "tonemap a.exr -o -",
        "--help",
    ] {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = candela(folder.path(), arguments)
            .stdout(writer)
            .stderr(Stdio::piped())
            .output()
            .unwrap();
        assert_eq!(text(&output.stderr), "", "{arguments}");
        assert_eq!(output.status.code(), Some(0), "{arguments}");
    }
}
