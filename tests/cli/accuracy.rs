//! `render --max-error`.

use std::fs;

use super::{fails, files, folder, output, succeeds, text};

#[test]
fn wrong_targets_are_wrong_usage() {
    let folder = folder();
    let folder = folder.path();
    let before = files(folder);
    for (options, expected) in [
        ("--max-error 0", "such as 0.5% or 0.005, from 1e-6"),
        ("--max-error -1", "such as 0.5% or 0.005"),
        ("--max-error nan", "such as 0.5% or 0.005"),
        ("--max-error 150%", "to 1, which is 100%"),
        (
            "--max-error 1% --samples 4",
            "cannot be used with '--samples",
        ),
        ("--max-error 1% --error-floor 0", "above 0 in cd/m²"),
        ("--max-error 1% --max-samples 0", "from 1 to 65536"),
        ("--error-floor 1", "--max-error"),
        ("--max-samples 16", "--max-error"),
        ("--layers error", "known with --max-error alone"),
    ] {
        let message = fails(folder, &format!("render ball.toml {options}"), 2);
        assert!(message.contains(expected), "{options}\n{message}");
    }
    assert_eq!(files(folder), before);
}

#[test]
fn summary_and_statistics_say_what_came_of_it() {
    let folder = folder();
    let folder = folder.path();
    let arguments = "render ball.toml --max-error 1% --layers error,samples --stats stats.json";
    let rendered = output(folder, arguments);
    assert!(rendered.status.success());
    let summary = text(&rendered.stderr);
    assert!(
        summary.contains(", to an error of 1 %, rendered in"),
        "{summary}"
    );
    assert!(summary.contains("of the pixels proven to "), "{summary}");
    let json = fs::read_to_string(folder.join("stats.json")).unwrap();
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let accuracy = &json["accuracy"];
    let count = |name: &str| accuracy[name].as_u64().unwrap();
    let pixels = json["image"][0].as_u64().unwrap() * json["image"][1].as_u64().unwrap();
    assert_eq!(count("bound_pixels") + count("estimated_pixels"), pixels);
    assert_eq!(
        count("smooth_pixels") + count("edge_pixels"),
        count("bound_pixels")
    );
    assert_eq!(accuracy["max_error"], 0.01);
    assert!(accuracy["worst_bound"].as_f64().unwrap() <= 0.01 + 1e-7);
    // The most that a pixel may take.
    assert_eq!(json["samples"], 4096);
    // A few samples are not enough, and that is said.
    let few = output(folder, "render ball.toml --max-error 0.01% --max-samples 4");
    let summary = text(&few.stderr);
    let warning = "pixels that 4 samples have not brought to an error of 0.01 %: ";
    assert!(summary.contains(warning), "{summary}");
}

/// A grain of dust in front of nothing: nowhere on the grid is any light.
#[test]
fn a_scene_that_is_too_dark_for_a_floor() {
    let folder = folder();
    let folder = folder.path();
    let scene = "
        [image]
        resolution = [200, 200]
        [camera.orthographic]
        eye = [0, 0, 10]
        look_at = [0, 0, 0]
        height = 10
        [materials.m.phong]
        diffuse = 0.3
        [lights.l.point]
        position = [0, 0, 100]
        intensity = 100
        [objects.dust.sphere]
        material = 'm'
        center = [0.02, 0.02, 0]
        radius = 0.01
    ";
    fs::write(folder.join("dust.toml"), scene).unwrap();
    let before = files(folder);
    let message = fails(folder, "render dust.toml --max-error 1%", 1);
    assert!(
        message.starts_with("error: the image is too dark"),
        "{message}"
    );
    assert!(message.contains("--error-floor, in cd/m²"), "{message}");
    assert_eq!(files(folder), before);
    succeeds(folder, "render dust.toml --max-error 1% --error-floor 1e-5");
}
