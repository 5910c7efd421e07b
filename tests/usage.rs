//! Wrong usage: what the program says, and that it ends with exit code 2.

use std::path::Path;
use std::process::Command;

/// What the program says of wrong usage.
fn misuse(arguments: &str, folder: &Path) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_candela"))
        .args(arguments.split_whitespace())
        .current_dir(folder)
        .output()
        .unwrap();
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2), "{arguments}: {text}");
    assert!(output.stdout.is_empty(), "{arguments}");
    let made = std::fs::read_dir(folder).unwrap().count();
    assert_eq!(made, 0, "{arguments} wrote files");
    text
}

#[test]
fn a_tip_says_what_to_write() {
    let folder = tempfile::tempdir().unwrap();
    for (arguments, tip) in [
        (
            "scene.toml",
            "tip: a scene is rendered by `candela render scene.toml`",
        ),
        (
            "x.exr",
            "tip: a picture of an EXR is made by `candela tonemap x.exr`",
        ),
        (
            "render scene.toml --spp 16",
            "tip: samples a pixel are `--samples N`",
        ),
        (
            "render scene.toml --width 800",
            "`resolution = [width, height]` in its `[image]`",
        ),
        ("render scene.toml -j 4", "tip: threads are `--threads N`"),
        ("render scene.toml --seed 1", "tip: nothing is random"),
        (
            "render scene.toml --aovs normal",
            "tip: what is written beside the picture is `--layers LIST`",
        ),
        (
            "render scene.toml --region 0,0,1,1",
            "tip: a part of the picture is `--crop X0,Y0,X1,Y1`",
        ),
        (
            "tonemap x.exr --gamma 2.2",
            "tip: a PNG is always sRGB-coded",
        ),
    ] {
        let text = misuse(arguments, folder.path());
        assert!(text.contains(tip), "{arguments}: {text}");
        assert_eq!(text.matches("tip: ").count(), 1, "{text}");
    }
}

#[test]
fn places_for_frames_need_frames() {
    let folder = tempfile::tempdir().unwrap();
    for arguments in [
        "render -o f.####.exr",
        "render -o f.%04d.exr",
        "render -o f.$F4.exr",
        "render --preview f.####.png",
    ] {
        let text = misuse(arguments, folder.path());
        assert!(
            text.contains("say which ones by --frames, such as --frames 1-100"),
            "{arguments}: {text}"
        );
    }
}

#[test]
fn one_is_no_plural() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let text = "[image]\nresolution = [1, 1]\n\
                [camera.perspective]\neye = [0, 0, 5]\nlook_at = [0, 0, 0]\nvertical_fov = 40\n\
                [materials.clay.phong]\ndiffuse = 0.2\n\
                [lights.key.point]\nposition = [0, 0, 5]\nintensity = 1\n\
                [objects.wing.triangle]\nmaterial = \"clay\"\n\
                vertices = [[0, 0, 0], [1, 0, 0], [0, 1, 0]]\n";
    std::fs::write(&scene, text).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_candela"))
        .arg("check")
        .arg(&scene)
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("objects    1, with 1 triangle\n"), "{text}");
    let rays = "rays       1 camera ray a sample, and up to 1 shadow ray for each\n";
    assert!(text.contains(rays), "{text}");
}
