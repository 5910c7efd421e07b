//! Files as they are: links, names that are alike or strange, runs that were killed.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use std::time::Duration;

use super::{SCENE, candela, fails, files, folder, image, succeeds, text};

/// Runs candela with words that have no spaces to be parted at.
fn with(folder: &Path, words: &[&str]) -> Output {
    candela(folder, "").args(words).output().unwrap()
}

#[cfg(unix)]
fn link(folder: &Path, to: &str, name: &str) {
    std::os::unix::fs::symlink(to, folder.join(name)).unwrap();
}

/// Links to nothing lead to a place as well: there, one output would go over the other.
#[cfg(unix)]
#[test]
fn two_outputs_to_one_place_are_refused_whatever_leads_there() {
    let folder = folder();
    fs::create_dir(folder.path().join("sub")).unwrap();
    fs::create_dir(folder.path().join("deep")).unwrap();
    link(folder.path(), "made.exr", "dangling.png");
    link(folder.path(), "dangling.png", "chain.png");
    link(folder.path(), "sub", "way");
    link(folder.path(), "../sub/made.exr", "deep/back.png");
    let absolute = folder.path().join("sub/made.exr");
    link(folder.path(), absolute.to_str().unwrap(), "absolute.json");
    let before = files(folder.path());
    for outputs in [
        "-o made.exr --preview dangling.png",
        "-o made.exr --preview chain.png",
        "-o made --preview ./made",
        "-o made --preview sub/../made",
        "-o sub/made --preview way/made",
        "-o sub/made.exr --preview deep/back.png",
        "-o way/made.exr --stats absolute.json",
        "-o a.exr --preview deep/back.png --stats absolute.json",
    ] {
        let message = fails(folder.path(), &format!("render ball.toml {outputs}"), 1);
        assert!(
            message.contains("would be one file"),
            "{outputs}: {message}"
        );
        assert_eq!(files(folder.path()), before, "{outputs}");
        assert_eq!(files(&folder.path().join("sub")), [""; 0], "{outputs}");
    }
    // What is somewhere else is written, through the link.
    succeeds(
        folder.path(),
        "render ball.toml -q -o other.exr --preview chain.png",
    );
    let png = fs::read(folder.path().join("made.exr")).unwrap();
    assert!(png.starts_with(b"\x89PNG"));
    assert!(folder.path().join("dangling.png").is_symlink());
}

/// A hard link is another name of what is read, or of the other output.
#[cfg(unix)]
#[test]
fn hard_links_are_one_place() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    succeeds(folder.path(), "render ball.toml -q -o made.exr");
    fs::hard_link(path("made.exr"), path("made.png")).unwrap();
    fs::hard_link(path("ball.toml"), path("scene.exr")).unwrap();
    for arguments in [
        "tonemap made.exr -o made.png",
        "render ball.toml -o made.exr --preview made.png",
        "render ball.toml -o scene.exr",
    ] {
        let message = fails(folder.path(), arguments, 1);
        assert!(message.contains("give another name"), "{message}");
    }
    assert_eq!(fs::read_to_string(path("ball.toml")).unwrap(), SCENE);
    assert_eq!(
        image(folder.path(), "made.exr").resolution,
        super::RESOLUTION
    );
}

/// Of what cannot be read, another name for what is made of it would not help.
#[test]
fn what_is_no_picture_is_told_before_where_it_would_go() {
    let folder = folder();
    for (bytes, expected) in [
        (&b"\x89PNG\r\n\x1a\n"[..], "it ends too early"),
        (b"no picture", "it is not an OpenEXR file, nor a PNG, "),
    ] {
        fs::write(folder.path().join("picture.png"), bytes).unwrap();
        let message = fails(folder.path(), "tonemap picture.png", 1);
        assert!(message.contains(expected), "{message}");
        assert_eq!(fs::read(folder.path().join("picture.png")).unwrap(), bytes);
    }
    succeeds(folder.path(), "render ball.toml -q --preview picture.png");
    let message = fails(folder.path(), "tonemap picture.png", 1);
    assert!(message.contains("would be written over"), "{message}");
}

/// `kill -9` leaves an unfinished file, for the next run to remove.
#[cfg(target_os = "linux")]
#[test]
fn what_a_killed_run_leaves_is_removed_by_the_next() {
    let folder = folder();
    let large = SCENE.replace("[60, 40]", "[4000, 4000]");
    fs::write(folder.path().join("large.toml"), large).unwrap();
    // Other runs' business: one to another target that still runs, and a file that looks alike.
    let long = "render large.toml -q --samples 4096 --threads 2";
    let mut killed = candela(folder.path(), &format!("{long} -o a.exr"))
        .spawn()
        .unwrap();
    let mut running = candela(folder.path(), &format!("{long} -o b.exr"))
        .spawn()
        .unwrap();
    let unfinished = || -> Vec<String> {
        let names = files(folder.path()).into_iter();
        names.filter(|name| name.starts_with(".candela-")).collect()
    };
    for _ in 0..2000 {
        if unfinished().len() == 2 {
            break;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let both = unfinished();
    assert_eq!(both.len(), 2, "{both:?}");
    assert!(both[0].starts_with(".candela-a.exr-"), "{both:?}");
    killed.kill().unwrap();
    killed.wait().unwrap();
    assert_eq!(unfinished(), both);
    // Another target, and what only checks, leave it.
    succeeds(folder.path(), "render ball.toml -q -o c.exr");
    assert_eq!(unfinished(), both);
    succeeds(folder.path(), "render ball.toml -q -o a.exr");
    assert_eq!(unfinished(), [both[1].as_str()]);
    // The live run keeps its file even from a run to the same target.
    succeeds(folder.path(), "render ball.toml -q -o b.exr");
    assert_eq!(unfinished(), [both[1].as_str()]);
    running.kill().unwrap();
    running.wait().unwrap();
    succeeds(folder.path(), "render ball.toml -q -o b.exr");
    assert_eq!(
        files(folder.path()),
        ["a.exr", "b.exr", "ball.toml", "c.exr", "large.toml"]
    );
}

/// The longest name that a file system takes leaves no room for a longer one beside it.
#[test]
fn names_of_any_length_and_kind() {
    let folder = folder();
    let long = "a".repeat(251) + ".exr";
    let longer = "a".repeat(252) + ".exr";
    for name in [
        long.as_str(),
        "ü 光'\".exr",
        "./-.exr",
        "a.exr.exr",
        ".exr.exr",
    ] {
        let output = with(folder.path(), &["render", "ball.toml", "-q", "-o", name]);
        assert!(output.status.success(), "{}", text(&output.stderr));
        assert_eq!(image(folder.path(), name).resolution, super::RESOLUTION);
    }
    let message = fails(folder.path(), &format!("render ball.toml -o {longer}"), 1);
    assert!(message.contains("choose a shorter one"), "{message}");
}

/// What a name or a file holds does not reach the terminal as it is.
#[cfg(unix)]
#[test]
fn messages_do_not_steer_the_terminal() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let folder = folder();
    let evil = "\u{1b}]0;evil\u{7}\u{9b}31m\rerror: fake\n\u{202e}";
    let file = format!("{evil}.toml");
    fs::write(folder.path().join(&file), SCENE.replace("radius", "radios")).unwrap();
    let good = format!("{evil}good");
    fs::write(folder.path().join(&good), SCENE).unwrap();
    let exr = format!("{evil}.exr");
    let png = format!("{evil}.png");
    let tif = format!("{evil}.tif");
    let mesh = SCENE.to_owned()
        + "[objects.m.mesh]\nmaterial = \"clay\"\nfile = \"\\u001b[31mm\\u202e.ply\"\n"
        + "[lights.\"\\u001b[31m\".point]\n";
    fs::write(folder.path().join("mesh.toml"), mesh).unwrap();
    // Characters as they are, where TOML allows them and where it does not.
    let raw = "a = \"\u{1b}[31m\u{7}\"\nb = \"\u{9b}31m\u{202e}\u{2028}x\" y\n\
        # \u{1b}[0m\n\"\u{9b}\u{202e}\" = 1\n[\u{1b}]\n";
    fs::write(folder.path().join("raw.toml"), raw).unwrap();
    let near = SCENE.replace("= \"clay\"", "= \"cla\u{9b}y\"")
        + "[materials.\"cla\u{9b}\u{202e}\".phong]\ndiffuse = 1\n";
    fs::write(folder.path().join("near.toml"), near).unwrap();
    let in_folder = format!("{evil}/a.exr");
    let huge = "x".repeat(100_000);
    let mut seen = 0;
    for words in [
        &["check", &file][..],
        &["check", &good],
        &["check", evil],
        &["check", "mesh.toml"],
        &["check", "raw.toml"],
        &["check", "near.toml"],
        &["render", &file],
        &["render", &good, "-o", &exr],
        &["render", &good, "-o", &exr, "--preview", &png],
        &["render", &good, "-o", &tif],
        &["render", &good, "-o", &good],
        &["render", &good, "-o", &in_folder],
        &["render", &good, evil],
        &["render", &good, "--samples", evil],
        &["render", &good, "--compression", evil],
        &["render", &good, "--crop", evil],
        &["render", &good, "--layers", evil],
        &["tonemap", &exr, "-o", &tif],
        &["tonemap", &exr, "-o", &exr],
        &["tonemap", &exr, "-o", &png],
        &["tonemap", &good],
        &["probe", &file, "--pixel", "0,0"],
        &["probe", &good, "--pixel", evil],
        &["completions", evil],
        &[evil],
        &["--\u{1b}[31mevil"],
        &["check", &huge],
        &["render", "--samples", &huge],
        &[&huge],
    ] {
        let output = with(folder.path(), words);
        for bytes in [&output.stdout, &output.stderr] {
            let shown = text(bytes);
            let steers = |c: char| (c.is_control() && c != '\n') || c == '\u{202e}';
            assert!(!shown.contains(steers), "{words:?}: {shown:?}");
            assert!(!shown.contains("\nerror: fake"), "{words:?}: {shown}");
            assert!(shown.len() < 10_000, "{words:?}: {} bytes", shown.len());
            seen += usize::from(shown.contains("u{1b}"));
        }
    }
    // Most of them do name the file.
    assert!(seen > 15, "{seen}");
    // Bytes that are no text.
    let latin1 = OsStr::from_bytes(b"f\xfcll\x1b.exr");
    let output = candela(folder.path(), "render ball.toml -o")
        .arg(latin1)
        .output();
    let message = text(&output.unwrap().stderr);
    assert!(message.starts_with("f\u{fffd}ll\\u{1b}.exr: "), "{message}");
}

/// What is no place for a file says so before there is work done for it.
#[cfg(unix)]
#[test]
fn places_that_are_no_files() {
    let folder = folder();
    let socket = folder.path().join("socket");
    let _socket = std::os::unix::net::UnixListener::bind(&socket).unwrap();
    let message = fails(folder.path(), "render ball.toml -o socket", 1);
    assert!(message.contains("it is a socket"), "{message}");
    // A FIFO gets the file as a pipe does.
    let fifo = folder.path().join("fifo");
    assert!(
        Command::new("mkfifo")
            .arg(&fifo)
            .status()
            .unwrap()
            .success()
    );
    let mut writer = candela(folder.path(), "render ball.toml -q -o fifo")
        .spawn()
        .unwrap();
    let bytes = fs::read(&fifo).unwrap();
    assert!(writer.wait().unwrap().success());
    succeeds(folder.path(), "render ball.toml -q -o a.exr");
    assert!(bytes == fs::read(folder.path().join("a.exr")).unwrap());
    // A folder, and one that a link to nothing names.
    link(folder.path(), "none/", "way");
    let message = fails(folder.path(), "render ball.toml -o way", 1);
    assert!(message.contains("it is a folder"), "{message}");
}
