//! `candela verify`: the renderer against the oracle on a scene of one's own.

use std::fs;
use std::path::Path;

use serde_json::Value;

use super::{SCENE, fails, files, folder, image, output, succeeds, text};
use crate::openimageio::oiiotool;

fn json(folder: &Path, arguments: &str) -> Value {
    let text = succeeds(folder, &format!("verify {arguments} --json"));
    serde_json::from_str(&text).unwrap()
}

/// How many pixels the histogram has.
fn counted(report: &Value) -> u64 {
    let rows = report["histogram"].as_array().unwrap();
    rows.iter().map(|row| row["pixels"].as_u64().unwrap()).sum()
}

#[test]
fn scenes_agree() {
    let folder = folder();
    let spectral = SCENE.replace(
        "intensity = 4",
        "intensity = { lumens = 50, color = { illuminant = \"A\" } }",
    );
    fs::write(folder.path().join("spectral.toml"), spectral).unwrap();
    for scene in ["ball.toml", "spectral.toml"] {
        let report = json(folder.path(), &format!("{scene} --all"));
        assert_eq!(report["agrees"], true, "{report}");
        assert_eq!([&report["pixels"], &report["of"]], [2400, 2400]);
        assert_eq!(counted(&report), 2400);
        assert_eq!([&report["wrong"], &report["flips"]], [0, 0]);
        let largest = report["largest"].as_f64().unwrap();
        assert!(largest > 1e-9 && largest < 1.2e-7, "{largest}");
        let told = succeeds(folder.path(), &format!("verify {scene}"));
        assert!(told.contains("1000 of 2400 pixels"), "{told}");
        assert!(
            told.ends_with("verdict: the renderer agrees with the equations\n"),
            "{told}"
        );
    }
}

#[test]
fn pixels_are_chosen_by_the_seed() {
    let folder = folder();
    let of = |arguments: &str| json(folder.path(), &format!("ball.toml {arguments}"));
    assert_eq!(of("--pixels 100"), of("--pixels 100 --seed 0"));
    assert_ne!(
        of("--pixels 100 --seed 1")["histogram"],
        of("--pixels 100 --seed 2")["histogram"]
    );
    assert_eq!(counted(&of("--pixels 100")), 100);
    assert_eq!(of("--pixels 5000")["pixels"], 2400);
}

/// With no tolerance at all, the rounding to f32 is beyond it, on no edge.
#[test]
fn what_is_off_is_told() {
    let folder = folder();
    for arguments in [
        "verify ball.toml --tolerance 0",
        "verify ball.toml --tolerance 1e-9 --json",
    ] {
        let output = output(folder.path(), arguments);
        let (told, message) = (text(&output.stdout), text(&output.stderr));
        assert_eq!(output.status.code(), Some(3), "{message}");
        assert!(
            message.starts_with("error: ") && message.contains("and on no edge"),
            "{message}"
        );
        if arguments.ends_with("--json") {
            let report: Value = serde_json::from_str(&told).unwrap();
            assert_eq!(report["agrees"], false);
            let off = report["off"].as_array().unwrap();
            assert_eq!(report["wrong"].as_u64().unwrap() as usize, off.len());
            assert!(off.iter().all(|pixel| pixel["edge"].is_null()));
        } else {
            assert!(told.contains("wrong: there is no edge"), "{told}");
            assert!(
                told.contains("does not agree with the equations here"),
                "{told}"
            );
        }
    }
}

/// The oracle's picture is that of the renderer, but for the last bit, and says what made it.
#[test]
fn the_oracle_draws() {
    let folder = folder();
    let told = succeeds(folder.path(), "verify ball.toml --all --oracle oracle.exr");
    assert!(told.contains("wrote oracle.exr"), "{told}");
    succeeds(folder.path(), "render ball.toml -o ball.exr --samples 1");
    succeeds(
        folder.path(),
        "diff oracle.exr ball.exr --max-relative 1.2e-7",
    );
    let [oracle, rendered] = ["oracle.exr", "ball.exr"].map(|name| image(folder.path(), name));
    assert_eq!(oracle.color, rendered.color);
    let header = oiiotool(folder.path(), "--info -v oracle.exr");
    assert!(
        header.contains("candela:oracle") && header.contains("worldToCamera"),
        "{header}"
    );
    assert!(
        header.contains("candela:scene_sha256") && !header.contains("candela:plan"),
        "{header}"
    );
    let message = fails(
        folder.path(),
        "verify ball.toml --all --oracle absent/o.exr",
        1,
    );
    assert!(message.contains("absent/o.exr"), "{message}");
    assert_eq!(
        files(folder.path()),
        ["ball.exr", "ball.toml", "oracle.exr"]
    );
}

#[test]
fn wrong_usage_and_scenes() {
    let folder = folder();
    for arguments in [
        "",
        "ball.toml --pixels 0",
        "ball.toml --pixels 5 --all",
        "ball.toml --tolerance -1",
        "ball.toml --max-flips -1",
        "ball.toml --oracle out.exr",
        "ball.toml --all --oracle out.png",
    ] {
        fails(folder.path(), &format!("verify {arguments}"), 2);
    }
    fs::write(
        folder.path().join("bad.toml"),
        SCENE.replace("radius", "radios"),
    )
    .unwrap();
    let message = fails(folder.path(), "verify bad.toml", 1);
    assert!(message.contains("radios"), "{message}");
    let message = fails(
        folder.path(),
        "verify ball.toml --all --oracle ball.toml",
        2,
    );
    assert!(message.contains("EXR"), "{message}");
}
