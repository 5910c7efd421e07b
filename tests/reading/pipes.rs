//! EXRs that come through a pipe.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use super::file::{rgb, row, write};

const COLORS: [[f32; 3]; 2] = [[0.5, 0.1, 0.2], [0.3, 0.9, 0.1]];

/// Runs a line of the shell, in which `candela` is the program under test; whether it succeeded, and what
/// it said.
fn shell(folder: &Path, line: &str) -> (bool, String) {
    let output = Command::new("bash")
        .current_dir(folder)
        .args(["-c", line])
        .env("candela", env!("CARGO_BIN_EXE_candela"))
        .stdin(Stdio::null())
        .output()
        .unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    (output.status.success(), said)
}

#[test]
#[cfg(unix)]
fn a_pipe_is_as_good_as_a_file() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[row(2, rgb("", &COLORS))]);
    let png = |line: &str| {
        let (is_done, said) = shell(folder.path(), line);
        assert!(is_done, "{line}: {said}");
        let png = fs::read(folder.path().join("x.png")).unwrap();
        fs::remove_file(folder.path().join("x.png")).unwrap();
        png
    };
    // The hash is that of what came through, and nothing tells how it came.
    let expected = png("$candela tonemap a.exr -o x.png");
    let hash = shell(folder.path(), "sha256sum a.exr >&2").1;
    let [hash, ..] = hash.split(' ').collect::<Vec<_>>()[..] else {
        panic!("no hash");
    };
    let text = format!("candela:source\0{hash}");
    assert!(
        expected
            .windows(text.len())
            .any(|found| found == text.as_bytes())
    );
    for line in [
        "cat a.exr | $candela tonemap - -o x.png",
        "cat a.exr | $candela tonemap /dev/stdin -o x.png",
        "$candela tonemap - -o x.png < a.exr",
        "$candela tonemap <(cat a.exr) -o x.png",
        "mkfifo fifo; cat a.exr > fifo & $candela tonemap fifo -o x.png",
    ] {
        assert!(png(line) == expected, "{line}");
    }
}

#[test]
#[cfg(unix)]
fn what_comes_through_a_pipe_may_be_anything() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &[row(2, rgb("", &COLORS))]);
    for (line, expected) in [
        (
            "$candela tonemap - -o x.png < /dev/null",
            "cannot read standard input: it is not an OpenEXR file, nor a PNG, JPEG, TIFF or Radiance HDR",
        ),
        (
            "$candela tonemap /dev/zero -o x.png",
            "cannot read /dev/zero: it is not an OpenEXR file, nor a PNG, JPEG, TIFF or Radiance HDR",
        ),
        (
            "head -c 300 a.exr | $candela tonemap - -o x.png",
            "cannot read standard input: the file is damaged or incomplete",
        ),
        (
            "cat a.exr | $candela tonemap -",
            "standard input gives the PNG no name; give it one with -o OUT.png",
        ),
    ] {
        let (is_done, said) = shell(folder.path(), line);
        assert!(!is_done && said.contains(expected), "{line}: {said}");
        assert_eq!(said.lines().count(), 1, "{said}");
        assert!(!folder.path().join("x.png").exists());
    }
}
