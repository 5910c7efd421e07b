//! Which channels are shown.

use std::path::Path;

use super::file::{Part, channel, rgb, row, write};
use super::{NEAREST, assert_pixels, shown};

/// A gray of each of these is coded as 0, 63, 118, 188 and 255.
const GRAYS: [f32; 5] = [0.0, 0.05, 0.18, 0.5, 1.0];
const CODES: [u8; 5] = [0, 63, 118, 188, 255];

const COLORS: [[f32; 3]; 2] = [[0.18, 0.18, 0.18], [0.5, 0.5, 0.5]];
const COLOR_CODES: [[u8; 3]; 2] = [[118; 3], [188; 3]];
const OTHER: [[f32; 3]; 2] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
const OTHER_CODES: [[u8; 3]; 2] = [[255, 0, 0], [0, 255, 0]];

#[track_caller]
fn assert_shows(path: &Path, layer: Option<&str>, expected: &[[u8; 3]]) {
    assert_pixels(&shown(path, layer, &NEAREST).unwrap(), expected);
}

#[track_caller]
fn refused(path: &Path, layer: Option<&str>) -> String {
    match shown(path, layer, &NEAREST) {
        Ok(_) => panic!("it is shown"),
        Err(message) => message,
    }
}

#[test]
fn luminance_alone_is_gray() {
    let folder = tempfile::tempdir().unwrap();
    let luminance = || channel("Y", |x, _| GRAYS[x as usize]);
    let path = write(folder.path(), &[row(5, vec![luminance()])]);
    let gray = shown(&path, None, &NEAREST).unwrap();
    assert_eq!(gray.pixels, CODES.map(|code| vec![code; 3]));
    assert!(gray.report.warnings.is_empty());

    let alpha = |x| if x < 3 { 1.0 } else { 0.5 };
    let premultiplied = channel("Y", move |x, _| GRAYS[x as usize] * alpha(x));
    let channels = vec![channel("A", move |x, _| alpha(x)), premultiplied];
    let path = write(folder.path(), &[row(5, channels)]);
    let alphas = [255, 255, 255, 128, 128];
    let expected: Vec<Vec<u8>> = CODES
        .iter()
        .zip(alphas)
        .map(|(&code, alpha)| vec![code, code, code, alpha])
        .collect();
    assert_eq!(shown(&path, None, &NEAREST).unwrap().pixels, expected);
}

/// As Blender's multilayer EXRs have them.
#[test]
fn layers_are_shown_by_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let mut channels = rgb("ViewLayer.Combined.", &COLORS);
    channels.push(channel("ViewLayer.Combined.A", |_, _| 1.0));
    channels.push(channel("ViewLayer.Depth.Z", |x, _| GRAYS[x as usize + 2]));
    channels.extend(rgb("ViewLayer.DiffDir.", &OTHER));
    let path = write(folder.path(), &[row(2, channels)]);

    let combined = shown(&path, Some("ViewLayer.Combined"), &NEAREST).unwrap();
    assert_eq!(
        combined.pixels,
        [[118, 118, 118, 255], [188, 188, 188, 255]]
    );
    assert_shows(&path, Some("ViewLayer.DiffDir"), &OTHER_CODES);
    assert_shows(&path, Some("ViewLayer.Depth.Z"), &[[118; 3], [188; 3]]);
    assert_shows(&path, Some("ViewLayer.DiffDir.R"), &[[255; 3], [0; 3]]);

    let names = "ViewLayer.Combined, ViewLayer.DiffDir, ViewLayer.Depth.Z";
    let message = refused(&path, None);
    assert!(
        message.ends_with(&format!(
            "it has no channels R, G, B; it has {names}; show one of these with --layer NAME"
        )),
        "{message}"
    );
    let message = refused(&path, Some("Combined"));
    assert!(
        message.ends_with(&format!("it has no layer `Combined`; it has {names}")),
        "{message}"
    );
    assert!(refused(&path, Some("")).contains("it has no layer ``"));
    assert!(refused(&path, Some("ViewLayer")).contains("it has no layer `ViewLayer`"));
}

/// Such as candela's own, beside R, G, B; and channels in small letters.
#[test]
fn layers_beside_the_picture() {
    let folder = tempfile::tempdir().unwrap();
    let mut channels = rgb("", &COLORS);
    channels.extend(rgb("light_key.", &OTHER));
    channels.push(channel("S0.550,000000nm", |x, _| GRAYS[x as usize + 2]));
    channels.push(channel("Z", |x, _| x as f32));
    for (name, place) in [("glow.r", 0), ("glow.g", 1), ("glow.b", 2)] {
        channels.push(channel(name, move |x, _| OTHER[x as usize][place]));
    }
    let path = write(folder.path(), &[row(2, channels)]);
    assert_shows(&path, None, &COLOR_CODES);
    assert_shows(&path, Some("light_key"), &OTHER_CODES);
    assert_shows(&path, Some("glow"), &OTHER_CODES);
    assert_shows(&path, Some("S0.550,000000nm"), &[[118; 3], [188; 3]]);
    assert_shows(&path, Some("Z"), &[[0; 3], [255; 3]]);
    let message = refused(&path, Some("light_kay"));
    assert!(
        message.ends_with("it has glow, light_key, S0.550,000000nm, Z"),
        "{message}"
    );
}

#[test]
fn parts_are_shown_by_their_names() {
    let folder = tempfile::tempdir().unwrap();
    let named = |part: Part, name: &str| part.with("name", "string", name.as_bytes());
    let depth = named(
        row(2, vec![channel("Z", |x, _| GRAYS[x as usize + 2])]),
        "depth",
    );
    let picture = named(row(2, rgb("", &COLORS)), "beauty");
    let mut channels = rgb("", &OTHER);
    channels.extend(rgb("inner.", &COLORS));
    let other = named(row(2, channels), "other.part");
    let path = write(folder.path(), &[depth, picture, other]);
    assert_shows(&path, None, &COLOR_CODES);
    assert_shows(&path, Some("beauty"), &COLOR_CODES);
    assert_shows(&path, Some("other.part"), &OTHER_CODES);
    assert_shows(&path, Some("inner"), &COLOR_CODES);
    assert_shows(&path, Some("other.part.inner"), &COLOR_CODES);
    assert_shows(&path, Some("depth"), &[[118; 3], [188; 3]]);
    assert_shows(&path, Some("depth.Z"), &[[118; 3], [188; 3]]);
    assert_shows(&path, Some("Z"), &[[118; 3], [188; 3]]);
    let message = refused(&path, Some("deep"));
    assert!(
        message.ends_with("it has beauty, other.part, inner, Z"),
        "{message}"
    );
}

/// As Nuke and others write them, in either case, with and without a layer.
#[test]
fn colors_by_their_words() {
    let folder = tempfile::tempdir().unwrap();
    let words = |names: [&str; 4]| {
        let [alpha, rgb @ ..] = names;
        let mut channels = vec![channel(alpha, |_, _| 1.0)];
        for (place, name) in rgb.into_iter().enumerate() {
            channels.push(channel(name, move |x, _| OTHER[x as usize][place]));
        }
        channels
    };
    let opaque = [[255, 0, 0, 255], [0, 255, 0, 255]];
    for names in [
        ["alpha", "red", "green", "blue"],
        ["Alpha", "Red", "Green", "Blue"],
    ] {
        let path = write(folder.path(), &[row(2, words(names))]);
        assert_eq!(shown(&path, None, &NEAREST).unwrap().pixels, opaque);
        assert!(refused(&path, Some("x")).ends_with("it has nothing else that can be shown"));
    }
    let layered = ["d.alpha", "d.red", "d.green", "d.blue"];
    let path = write(folder.path(), &[row(2, words(layered))]);
    assert_eq!(shown(&path, Some("d"), &NEAREST).unwrap().pixels, opaque);
    assert!(refused(&path, None).contains("it has d; show"));
    // R, G, B go before words, and words do not mix with them.
    let mut both = words(["alpha", "red", "green", "blue"]);
    both.extend(rgb("", &COLORS));
    let path = write(folder.path(), &[row(2, both)]);
    let grays = [[118, 118, 118, 255], [188, 188, 188, 255]];
    assert_eq!(shown(&path, None, &NEAREST).unwrap().pixels, grays);
    let mixed = ["R", "green", "B"].map(|name| channel(name, |_, _| 0.0));
    let path = write(folder.path(), &[row(1, mixed.into())]);
    assert!(refused(&path, None).contains("it has no channels R, G, B"));
}

/// Arnold's main layer.
#[test]
fn a_layer_called_rgba() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(folder.path(), &[row(2, rgb("RGBA.", &OTHER))]);
    assert_shows(&path, Some("RGBA"), &OTHER_CODES);
    assert!(refused(&path, None).contains("it has RGBA; show"));
}

#[test]
fn names_are_utf8_and_steer_no_terminal() {
    let folder = tempfile::tempdir().unwrap();
    let path = write(
        folder.path(),
        &[row(1, vec![channel("Füll.光", |_, _| 0.18)])],
    );
    assert!(refused(&path, None).contains("it has Füll.光; show"));
    assert_shows(&path, Some("Füll.光"), &[[118; 3]]);

    let hostile = channel("\u{1b}[31mEVIL\u{7}\n", |_, _| 0.0);
    let path = write(folder.path(), &[row(1, vec![hostile])]);
    let message = refused(&path, None);
    assert!(
        message.contains(r"it has \u{1b}[31mEVIL\u{7}\n; show"),
        "{message}"
    );
    let long = channel(&"x".repeat(255), |_, _| 0.0);
    let path = write(folder.path(), &[row(1, vec![long])]);
    let message = refused(&path, None);
    assert!(message.contains("xxx…xxx"), "{message}");

    let part = row(2, rgb("", &COLORS));
    let part = part.with(
        "colorInteropID",
        "string",
        "\u{1b}]0;".repeat(50_000).as_bytes(),
    );
    let path = write(folder.path(), &[part]);
    let warnings = shown(&path, None, &NEAREST).unwrap().report.warnings;
    assert!(warnings[0].contains(r"\u{1b}]0;"), "{warnings:?}");
    assert!(warnings[0].len() < 2000 && !warnings[0].contains('\u{1b}'));
    // Thousands of channels are not all listed.
    let many = (0..3000).map(|number| channel(&format!("id{number:04}"), |_, _| 0.0));
    let path = write(folder.path(), &[row(1, many.collect())]);
    let message = refused(&path, None);
    assert!(message.contains("id0019 and 2980 more; show"), "{message}");
}
