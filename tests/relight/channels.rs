//! What becomes of each channel, on pixels whose values are known.

use std::path::Path;

use candela::exr::{ExrOptions, Precision};
use candela::image::{Channels, Film, Metadata, Window};
use candela::relight::RelightError;
use candela::scene::ColorSpace;
use serde_json::json;

use super::{ChannelKind, change, planes, with_attribute, with_channel, without, write};

/// A film of two pixels of this light, without channels.
fn plain(rgb: [[f32; 3]; 2]) -> Film {
    let metadata = Metadata {
        color_space: ColorSpace::Rec709,
        world_to_camera: [[0.0; 4]; 4],
        world_to_ndc: [[0.0; 4]; 4],
        provenance: Vec::new(),
        numbers: Vec::new(),
    };
    let pixels = rgb.map(|[r, g, b]| [r, g, b, 1.0]).to_vec();
    let film = Film::new([2, 1], Window::whole([2, 1]), pixels, metadata);
    film.with_channels(Channels::default(), Vec::new())
}

/// The film with a layer of this light.
fn with_layer(film: &Film, layer: &str, rgb: [[f32; 3]; 2]) -> Film {
    ["R", "G", "B"]
        .iter()
        .enumerate()
        .fold(film.clone(), |film, (place, c)| {
            let values = rgb.map(|pixel| pixel[place]);
            with_channel(&film, &format!("{layer}.{c}"), ChannelKind::Light, &values)
        })
}

const KEY: [[f32; 3]; 2] = [[1.0, 2.0, 3.0], [0.5, 0.25, 0.0]];
const FILL: [[f32; 3]; 2] = [[4.0, 0.5, 1.0], [8.0, 1.0, 2.0]];

fn sum(parts: &[[[f32; 3]; 2]]) -> [[f32; 3]; 2] {
    [0, 1].map(|pixel| [0, 1, 2].map(|c| parts.iter().map(|part| part[pixel][c]).sum()))
}

fn times(factor: f32, rgb: [[f32; 3]; 2]) -> [[f32; 3]; 2] {
    rgb.map(|pixel| pixel.map(|channel| channel * factor))
}

fn said(film: &Film) -> Film {
    let lights = json!([
        { "name": "key", "kind": "point", "group": null, "candela": 1.0, "rgb": [1.0, 1.0, 1.0] },
        { "name": "fill", "kind": "spot", "group": null, "candela": 1.0, "rgb": [1.0, 1.0, 0.0], "falloff": "gltf" },
    ]);
    let film = with_attribute(film, "candela:lights", &lights.to_string());
    with_attribute(&film, "candela:transport", "rgb")
}

/// A film of a key and a fill.
fn film() -> Film {
    let film = with_layer(&plain(sum(&[KEY, FILL])), "light_key", KEY);
    said(&with_layer(&film, "light_fill", FILL))
}

fn layer(path: &Path, layer: &str) -> [[f32; 3]; 2] {
    let planes = planes(path);
    let dot = if layer.is_empty() { "" } else { "." };
    [0, 1].map(|pixel| ["R", "G", "B"].map(|c| planes[&format!("{layer}{dot}{c}")][pixel]))
}

/// Writes the film, changes it, and says what was to be told.
fn relit(film: &Film, path: &Path, texts: &[&str]) -> Vec<String> {
    write(film, path, &ExrOptions::default());
    change(path, texts)
        .unwrap_or_else(|error| panic!("{error}"))
        .notes
}

fn refused(film: &Film, texts: &[&str]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write(film, &path, &ExrOptions::default());
    let before = std::fs::read(&path).unwrap();
    let message = change(&path, texts).unwrap_err().to_string();
    assert!(std::fs::read(&path).unwrap() == before, "{message}");
    message
}

/// What light does not change stays to the bit, and what cannot follow it goes with a word.
#[test]
fn what_stays_and_what_goes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let mut film = film();
    let stays = [
        "Z",
        "samples",
        "N.X",
        "P.Y",
        "albedo.R",
        "shadow_key",
        "CryptoObject00.R",
    ];
    let goes = ["error", "error_kind", "irradiance.R", "S0.500,000000nm"];
    let odd = [f32::from_bits(0x7fc1_2345), -0.0];
    for name in stays.iter().chain(&goes).chain(&["mist"]) {
        film = with_channel(&film, name, ChannelKind::Data, &odd);
    }
    for name in [
        "candela:bands",
        "emissiveUnits",
        "spectralLayoutVersion",
        "candela:scene_sha256",
    ] {
        film = with_attribute(&film, name, "said");
    }
    let notes = relit(&film, &path, &["key=2"]);
    let planes = planes(&path);
    for name in stays.iter().chain(&["mist"]) {
        let bits: Vec<u32> = planes[*name].iter().map(|value| value.to_bits()).collect();
        assert_eq!(bits, odd.map(f32::to_bits), "{name}");
    }
    assert!(goes.iter().all(|name| !planes.contains_key(*name)));
    for part in ["`irradiance`", "`error`", "the bands `S0`", "`mist`"] {
        assert_eq!(
            notes.iter().filter(|note| note.contains(part)).count(),
            1,
            "{notes:?}"
        );
    }
    assert_eq!(notes.len(), 4, "{notes:?}");
    for name in ["candela:bands", "emissiveUnits", "spectralLayoutVersion"] {
        assert_eq!(super::files::find_text(&path, name), None);
    }
    assert_eq!(super::files::text(&path, "candela:scene_sha256"), "said");
    // What a light is beside its color stays said.
    assert!(super::files::text(&path, "candela:lights").contains(r#""falloff":"gltf""#));
}

/// A factor of 1 changes no pixel, and nothing goes.
#[test]
fn nothing_asked_for_changes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    // Its sum is off by a rounding.
    let film = with_channel(&film(), "error", ChannelKind::Data, &[1.0, 2.0]);
    write(&film, &path, &ExrOptions::default());
    let before = planes(&path);
    assert_eq!(relit(&film, &path, &["key=1", "fill=1.0"]), [""; 0]);
    assert_eq!(planes(&path), before);
}

#[test]
fn lobes_follow_their_light() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let halves = |rgb| [times(0.25, rgb), times(0.75, rgb)];
    let ([key_diffuse, key_specular], [fill_diffuse, fill_specular]) = (halves(KEY), halves(FILL));
    let mut whole = film();
    for (name, rgb) in [
        ("light_key_diffuse", key_diffuse),
        ("light_key_specular", key_specular),
        ("light_fill_diffuse", fill_diffuse),
        ("light_fill_specular", fill_specular),
        ("diffuse", sum(&[key_diffuse, fill_diffuse])),
        ("specular", sum(&[key_specular, fill_specular])),
    ] {
        whole = with_layer(&whole, name, rgb);
    }
    assert_eq!(relit(&whole, &path, &["key=2"]), [""; 0]);
    assert_eq!(layer(&path, ""), sum(&[times(2.0, KEY), FILL]));
    assert_eq!(layer(&path, "light_key"), times(2.0, KEY));
    assert_eq!(layer(&path, "light_fill"), FILL);
    assert_eq!(layer(&path, "light_key_diffuse"), times(2.0, key_diffuse));
    assert_eq!(layer(&path, "light_fill_specular"), fill_specular);
    assert_eq!(
        layer(&path, "diffuse"),
        sum(&[times(2.0, key_diffuse), fill_diffuse])
    );
    assert_eq!(
        layer(&path, "specular"),
        sum(&[times(2.0, key_specular), fill_specular])
    );
    // Of a color the lobes take the ratio of R, G and B.
    relit(&whole, &path, &["key={rgb=[2, 1, 0.5]}"]);
    let scale = f64::from(layer(&path, "light_key")[0][0]) / 2.0;
    assert!(
        (f64::from(layer(&path, "light_key_diffuse")[0][1]) - 0.5 * scale).abs() < 1e-6 * scale
    );
    // Without the lobe of the light that changes the sum is not known; without another's it is.
    let some = without(&whole, "light_key_diffuse");
    let notes = relit(&some, &path, &["key=2"]);
    assert!(
        notes.len() == 1 && notes[0].contains("`diffuse` is left out"),
        "{notes:?}"
    );
    assert!(!planes(&path).contains_key("diffuse.R"));
    let some = without(&whole, "light_fill_diffuse");
    assert_eq!(relit(&some, &path, &["key=2"]), [""; 0]);
    assert_eq!(
        layer(&path, "diffuse"),
        sum(&[times(2.0, key_diffuse), fill_diffuse])
    );
}

/// A light may be called as a lobe of another would be.
#[test]
fn names_like_lobes_are_lights() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let light = |name: &str| json!({ "name": name, "kind": "point", "group": null, "candela": 1.0, "rgb": [1.0, 1.0, 1.0] });
    let lights = json!([light("key"), light("key_diffuse")]).to_string();
    let film = with_layer(&plain(sum(&[KEY, FILL])), "light_key", KEY);
    let film = with_layer(&film, "light_key_diffuse", FILL);
    relit(
        &with_attribute(&film, "candela:lights", &lights),
        &path,
        &["key=2"],
    );
    assert_eq!(layer(&path, "light_key_diffuse"), FILL);
    assert_eq!(layer(&path, ""), sum(&[times(2.0, KEY), FILL]));
}

/// The background's share may be a layer of its own name.
#[test]
fn a_background_is_a_share() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let sky = [[0.5, 0.5, 0.5], [0.0, 0.0, 0.0]];
    let film = with_layer(&plain(sum(&[KEY, FILL, sky])), "light_key", KEY);
    let film = with_layer(
        &said(&with_layer(&film, "light_fill", FILL)),
        "background",
        sky,
    );
    for film in [film.clone(), with_layer(&film, "light_background", sky)] {
        relit(&film, &path, &["background=0.5", "key=off"]);
        assert_eq!(layer(&path, ""), sum(&[FILL, times(0.5, sky)]));
        assert_eq!(layer(&path, "background"), times(0.5, sky));
    }
    let message = refused(&film, &["background=#ffffff"]);
    assert!(
        message.contains("a factor such as background=0.5"),
        "{message}"
    );
}

#[test]
fn what_types_cannot_hold_is_clamped_and_counted() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let half = ExrOptions {
        precision: Precision::Half,
        ..ExrOptions::default()
    };
    write(&film(), &path, &half);
    let report = change(&path, &["fill=10000"]).unwrap();
    // 80 000 of the fill alone, and in R.
    assert_eq!((report.clamped_to_half, report.clamped_to_float), (2, 0));
    assert_eq!(layer(&path, "light_fill")[1], [65504.0, 10000.0, 20000.0]);
    assert_eq!(layer(&path, "")[1][0], 65504.0);
    // What they stand for is not known any more.
    assert_eq!(change(&path, &["fill=0.5"]).unwrap().were_clamped, 2);
    write(&film(), &path, &half);
    let report = change(&path, &["key=1e-5"]).unwrap();
    assert_eq!(report.small_in_half, 5);
    write(&film(), &path, &ExrOptions::default());
    let report = change(&path, &["fill=1e38"]).unwrap();
    assert_eq!((report.clamped_to_half, report.clamped_to_float), (0, 4));
    assert_eq!(layer(&path, "light_fill")[1][0], f32::MAX);
}

/// Other programs' layers can be multiplied where they add up to the picture, and only there.
#[test]
fn files_of_other_programs() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let bare = with_layer(&plain(sum(&[KEY, FILL])), "light_key", KEY);
    let film = with_layer(&bare, "light_fill", FILL);
    relit(&film, &path, &["key=2"]);
    assert_eq!(layer(&path, ""), sum(&[times(2.0, KEY), FILL]));
    assert_eq!(super::files::find_text(&path, "candela:lights"), None);
    let message = refused(&film, &["key=#ff8040"]);
    assert!(
        message.contains("does not say what the color of `key` is"),
        "{message}"
    );
    let message = refused(&bare, &["key=2"]);
    assert!(
        message.contains("R of pixel 1,0 differs by 8e0"),
        "{message}"
    );
    let message = refused(&plain(KEY), &["key=2"]);
    assert!(message.contains("no layer of a light"), "{message}");
    assert!(
        message.contains("`candela render --layers lights`"),
        "{message}"
    );
}

#[test]
fn what_cannot_be_is_refused() {
    for (texts, part) in [
        (
            &["keys=2"][..],
            "there is no light `keys`; did you mean `key`? it has key, fill",
        ),
        (&["sun=2"], "there is no light `sun`; it has key, fill"),
        (&["background=2"], "there is no light `background`"),
        (&["key=2", "key=#ffffff"], "`key` is there twice"),
        (
            &["fill=#ffffff"],
            "`fill` cannot get this color: its blue was 0",
        ),
        (&["key=#fffff"], "`#` and six hexadecimal digits"),
        (
            &["key={blackbody=-3}"],
            "`blackbody` is -3, expected a temperature",
        ),
        (&["key={blackbdy=3000}"], "did you mean `blackbody`?"),
        (&["key={candela=3}"], "candela"),
        (&["key={blackbody=3000"], "--> --light:1:"),
        (&["key=[1, 2]"], "an array of 2"),
        (&["key=[0, 0, 0]"], "`color` is black"),
    ] {
        let message = refused(&film(), texts);
        assert!(message.contains(part), "{texts:?}: {message}");
    }
    // The place is in what was written.
    for (text, at) in [
        ("key=2,{blackbdy=3000}", "blackbdy"),
        ("key = #12345", "#12345"),
    ] {
        let message = refused(&film(), &[text]);
        let shown = message.lines().position(|line| line.ends_with(text));
        let shown = shown.unwrap_or_else(|| panic!("{message}"));
        let lines: Vec<&str> = message.lines().collect();
        assert_eq!(
            lines[shown].find(at),
            lines[shown + 1].find('^'),
            "{message}"
        );
    }
}

#[test]
fn headers_that_say_nonsense_are_refused() {
    let light = |text: &str| with_attribute(&film(), "candela:lights", text);
    for text in [
        "",
        "[",
        "{}",
        "[{}]",
        &"[".repeat(100_000),
        r#"[{"name":"key","kind":"point","group":null,"candela":-1,"rgb":[1,1,1]}]"#,
        r#"[{"name":"key","kind":"point","group":null,"candela":1e999,"rgb":[1,1,1]}]"#,
        r#"[{"name":"key","kind":"point","group":null,"candela":1,"rgb":[1,1]}]"#,
        r#"[{"name":"key","kind":"point","group":null,"candela":1,"rgb":[1,1,1]},
            {"name":"key","kind":"point","group":null,"candela":1,"rgb":[1,1,1]}]"#,
        r#"[{"name":"key","kind":"point","group":"fill","candela":1,"rgb":[1,1,1]},
            {"name":"fill","kind":"point","group":null,"candela":1,"rgb":[1,1,1]}]"#,
    ] {
        let message = refused(&light(text), &["key=2"]);
        assert!(
            message.contains("`candela:lights` is not as candela writes it"),
            "{message}"
        );
    }
    for (name, text) in [
        ("candela:transport", "neutrino"),
        ("candela:observer", "1066"),
        ("candela:reflectances", "no JSON"),
        ("candela:relit", "{}"),
    ] {
        let film = with_attribute(&film(), name, text);
        let message = refused(&film, &["key=#ffffff"]);
        assert!(
            message.contains(&format!("`{name}` is not as")),
            "{message}"
        );
    }
    // A light is asked for in a color, and the curves of reflectances are too short or too few.
    let spectral = with_attribute(&film(), "candela:transport", "spectral");
    let message = refused(&spectral, &["key=#ffffff"]);
    assert!(message.contains("`relight_key.flat`"), "{message}");
    let spectral = with_channel(&spectral, "relight_key.1", ChannelKind::Data, &[1.0, 1.0]);
    for curves in [json!([]), json!([[1.0]])] {
        let text = json!({ "observer": "1931", "curves": curves }).to_string();
        let film = with_attribute(&spectral, "candela:reflectances", &text);
        let message = refused(&film, &["key=#ffffff"]);
        assert!(
            message.contains("`candela:reflectances` is not as"),
            "{message}"
        );
    }
}

/// Of files that do not say which lights are seen, one with an area may be where there is a layer `emission`, and one that
/// is told to be has a layer of its own.
#[test]
fn lights_of_older_files_may_be_seen() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let glow = [[1.0, 1.0, 1.0], [0.0; 3]];
    let film = with_layer(&plain(sum(&[KEY, FILL, glow])), "light_key", KEY);
    let film = with_layer(&with_layer(&film, "light_fill", FILL), "emission", glow);
    let light = |name: &str, kind: &str| json!({ "name": name, "kind": kind, "group": null, "candela": 1.0, "rgb": [1.0, 1.0, 1.0] });
    let lights = json!([light("key", "rectangle"), light("fill", "point")]);
    let older = with_attribute(&said(&film), "candela:lights", &lights.to_string());
    let message = refused(&older, &["key=2"]);
    assert!(
        message.contains("`key` is seen in the picture"),
        "{message}"
    );
    assert_eq!(relit(&older, &path, &["fill=2"]), [""; 0]);
    assert_eq!(layer(&path, ""), sum(&[KEY, times(2.0, FILL), glow]));
    assert_eq!(layer(&path, "emission"), glow);
    let newer = with_layer(&older, "emission_key", glow);
    assert_eq!(relit(&newer, &path, &["key=2"]), [""; 0]);
    assert_eq!(
        layer(&path, ""),
        sum(&[times(2.0, KEY), FILL, times(2.0, glow)])
    );
    assert_eq!(layer(&path, "emission"), times(2.0, glow));
    assert_eq!(layer(&path, "emission_key"), times(2.0, glow));
}

/// A new spectrum takes the lobes with it, which only their sum is known of.
#[test]
fn a_new_spectrum_drops_lobes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let mut film = with_attribute(&film(), "candela:transport", "spectral");
    for (name, rgb) in [
        ("light_key_diffuse", KEY),
        ("light_fill_diffuse", FILL),
        ("diffuse", sum(&[KEY, FILL])),
    ] {
        film = with_layer(&film, name, rgb);
    }
    film = with_channel(&film, "relight_key.flat", ChannelKind::Data, &[2.0, 0.25]);
    let notes = relit(&film, &path, &["key=0.5,{illuminant=\"D65\"}"]);
    assert_eq!(notes.len(), 2, "{notes:?}");
    let planes = planes(&path);
    assert!(!planes.contains_key("light_key_diffuse.R") && !planes.contains_key("diffuse.R"));
    assert_eq!(layer(&path, "light_fill_diffuse"), FILL);
    // D65 is white: of 1 cd there is 1 in each of R, G and B, to the bit.
    assert_eq!(layer(&path, "light_key"), [[1.0; 3], [0.125; 3]]);
    assert_eq!(planes["relight_key.flat"], [1.0, 0.125]);
    assert_eq!(layer(&path, ""), sum(&[[[1.0; 3], [0.125; 3]], FILL]));
    let error = change(&path, &["fill=#ffffff"]).unwrap_err();
    assert!(matches!(error, RelightError::NotStored(_)), "{error}");
}
