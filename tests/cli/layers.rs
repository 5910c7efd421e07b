//! `render --layers`, `--wavelengths` and `--transport`.

use std::fs;

use tempfile::TempDir;

use super::{RESOLUTION, candela, fails, files, folder, image, output, succeeds, text};
use crate::openimageio::{decode, oiiotool};

/// The ball, one of its lights orange: on colored surfaces that is another color as spectra than as
/// RGB, where white light is the same.
fn colorful() -> TempDir {
    let folder = folder();
    let path = folder.path().join("ball.toml");
    let scene = fs::read_to_string(&path).unwrap();
    let orange = scene.replace("intensity = 4", "intensity = [4, 2, 0.5]");
    assert_ne!(orange, scene);
    fs::write(path, orange).unwrap();
    folder
}

#[test]
fn a_scene_of_rgb_values_has_bands_when_asked() {
    let folder = colorful();
    let folder = folder.path();
    succeeds(folder, "render ball.toml -o rgb.exr");
    succeeds(
        folder,
        "render ball.toml -o spectral.exr --transport spectral",
    );
    succeeds(folder, "render ball.toml -o bands.exr --layers spectral");
    let bands = decode(&folder.join("bands.exr"));
    assert_eq!(bands.channels.len(), 4 + 41);
    assert_eq!(bands.channels[4], "S0.380,000000nm");
    assert_eq!(bands.channels[44], "S0.780,000000nm");
    // Some pixel of the floor.
    assert!(bands.pixel(5, 35)[4..].iter().all(|&band| band > 0.0));

    let pixels = |name| image(folder, name).pixels;
    assert!(pixels("bands.exr") == pixels("spectral.exr"));
    assert!(pixels("bands.exr") != pixels("rgb.exr"));
    for name in ["rgb.exr", "spectral.exr"] {
        assert_eq!(decode(&folder.join(name)).channels, ["R", "G", "B", "A"]);
    }
}

#[test]
fn the_built_in_scene_has_bands_too() {
    let folder = folder();
    let folder = folder.path();
    let arguments = "render --crop 600,300,616,309 --layers spectral --wavelengths 400:700:50";
    succeeds(folder, arguments);
    let bands = decode(&folder.join("lecture.exr"));
    assert_eq!(bands.channels.len(), 4 + 7);
    assert_eq!(bands.data_window, [600, 300, 16, 9]);
}

#[test]
fn transport_is_overridden() {
    let folder = colorful();
    let folder = folder.path();
    let scene = fs::read_to_string(folder.join("ball.toml")).unwrap();
    for transport in ["auto", "rgb", "spectral"] {
        let said = format!("[image]\ntransport = \"{transport}\"");
        let name = format!("{transport}.toml");
        fs::write(folder.join(name), scene.replace("[image]", &said)).unwrap();
        succeeds(folder, &format!("render {transport}.toml"));
    }
    let pixels = |name: &str| image(folder, name).pixels;
    assert!(pixels("auto.exr") == pixels("rgb.exr"));
    assert!(pixels("auto.exr") != pixels("spectral.exr"));
    for (scene, option, same) in [
        ("rgb", "spectral", "spectral.exr"),
        ("spectral", "rgb", "rgb.exr"),
        ("spectral", "auto", "auto.exr"),
    ] {
        let arguments = format!("render {scene}.toml -o other.exr --transport {option}");
        succeeds(folder, &arguments);
        assert!(pixels("other.exr") == pixels(same), "{arguments}");
    }

    // Bands of a scene that forces RGB.
    let message = fails(folder, "render rgb.toml -o none.exr --layers spectral", 1);
    for part in [
        "--layers spectral",
        "transport = \"rgb\"",
        "--transport spectral",
    ] {
        assert!(message.contains(part), "{message}");
    }
    assert!(!files(folder).contains(&"none.exr".to_owned()));
    succeeds(
        folder,
        "render rgb.toml -o some.exr --layers spectral --transport spectral",
    );
    assert!(pixels("some.exr") == pixels("spectral.exr"));
}

#[test]
fn wrong_layers_are_wrong_usage() {
    let folder = folder();
    let folder = folder.path();
    let before = files(folder);
    for (options, expected) in [
        ("--layers spectrl", "did you mean `spectral`?"),
        ("--layers spectral,normals", "did you mean `normal`?"),
        ("--layers light", "did you mean `lights`?"),
        (
            "--layers Z",
            "there is no layer `Z`; there is lights, light-diffuse",
        ),
        (
            "--layers xyz",
            "there is no layer `xyz`; there is lights, light-diffuse, light-specular, relight",
        ),
        ("--layers depth=key", "`depth` takes no names of lights"),
        (
            "--layers cryptomatte=lights",
            "expected cryptomatte=object or cryptomatte=material",
        ),
        ("--layers relight,no-relight", "leave one out"),
        (
            "--cryptomatte-levels 4",
            "--layers cryptomatte, which is not asked for",
        ),
        (
            "--layers cryptomatte --cryptomatte-levels 201",
            "expected a number from 1 to 200",
        ),
        ("--spectral-output b.exr", "--layers spectral"),
        ("--full-window", "--crop"),
        ("--layers depth,lights,depth", "--layers has `depth` twice"),
        (
            "--layers normal --layers depth,normal",
            "--layers has `normal` twice",
        ),
        ("--layers lights,,depth", "there is no layer ``"),
        ("--layers spectral,", "there is no layer ``"),
        ("--wavelengths 400:700:10", "--layers spectral"),
        ("--layers spectral --transport rgb", "--transport rgb"),
        ("--transport yes", "[possible values: auto, rgb, spectral]"),
    ] {
        let message = fails(folder, &format!("render ball.toml {options}"), 2);
        assert!(message.contains(expected), "{options}\n{message}");
    }
    for (wavelengths, expected) in [
        ("400:700", "START:END:STEP in whole nm, such as 400:700:10"),
        ("400:700:10:5", "START:END:STEP"),
        ("400:700:2.5", "START:END:STEP"),
        ("-400:700:10", "START:END:STEP"),
        ("99999999999:700:10", "START:END:STEP"),
        ("300:700:10", "from 360 to 830 nm"),
        ("400:900:10", "from 360 to 830 nm"),
        ("700:400:10", "START < END"),
        ("500:500:10", "START < END"),
        ("400:700:0", "at least 1 nm"),
        ("400:705:10", "such as 700 or 710"),
        ("800:825:20", "such as 820"),
        ("400:410:300", "whole steps from START"),
    ] {
        let options = format!("render ball.toml --layers spectral --wavelengths {wavelengths}");
        let message = fails(folder, &options, 2);
        assert!(message.contains(expected), "{wavelengths}\n{message}");
    }
    assert_eq!(files(folder), before);
}

/// In any order, with and without bands, the file is the same; it says what is in it.
#[test]
fn layers_of_all_kinds_together() {
    let folder = folder();
    let folder = folder.path();
    let expected = "--layers lights,no-relight,depth,normal,spectral --wavelengths 400:700:100";
    succeeds(folder, &format!("render ball.toml -o a.exr {expected}"));
    let other =
        "--layers normal,spectral --layers no-relight,depth,lights --wavelengths 400:700:100";
    succeeds(
        folder,
        &format!("render ball.toml -o b.exr --threads 1 {other}"),
    );
    let bytes = |name| fs::read(folder.join(name)).unwrap();
    assert!(bytes("a.exr") == bytes("b.exr"));

    let all = decode(&folder.join("a.exr"));
    // The file has them sorted by name; OpenImageIO puts R, G, B, A and Z first.
    let lights = ["background", "fill", "key"];
    let lights = lights.map(|name| ["R", "G", "B"].map(|c| format!("light_{name}.{c}")));
    let mut found = all.channels.clone();
    let mut expected = lights.concat();
    for name in ["R", "G", "B", "A", "Z", "N.X", "N.Y", "N.Z"] {
        expected.push(name.to_owned());
    }
    for nm in [400, 500, 600, 700] {
        expected.push(format!("S0.{nm},000000nm"));
    }
    found.sort();
    expected.sort();
    assert_eq!(found, expected);
    let info = oiiotool(folder, "--info -v a.exr");
    assert!(
        info.contains("candela:layers: \"lights,depth,normal,spectral\""),
        "{info}"
    );

    // R, G, B and A are what they are without.
    succeeds(folder, "render ball.toml -o c.exr --transport spectral");
    let pixels = |name| image(folder, name).pixels;
    assert!(pixels("a.exr") == pixels("c.exr"));
    let part = "render ball.toml -o part.exr --layers lights,depth --crop 20,10,31,29 --samples 4 \
                --stats part.json --preview part.png";
    succeeds(folder, part);
    let stats = fs::read_to_string(folder.join("part.json")).unwrap();
    let stats: serde_json::Value = serde_json::from_str(&stats).unwrap();
    assert_eq!(stats["layers"], serde_json::json!(["lights", "depth"]));
    let part = decode(&folder.join("part.exr"));
    assert_eq!(part.channels.len(), 4 + 3 * 3 + 1);
    assert_eq!(part.data_window, [20, 10, 11, 19]);
    assert_eq!(part.display_window, [0, 0, 60, 40]);
}

/// The names of lights are such that only the background's can make a channel twice.
#[test]
fn a_light_that_is_called_background() {
    let folder = folder();
    let folder = folder.path();
    let scene = fs::read_to_string(folder.join("ball.toml")).unwrap();
    let named = scene.replace("lights.key", "lights.background");
    fs::write(folder.join("named.toml"), &named).unwrap();
    let message = fails(folder, "render named.toml --layers lights", 1);
    for part in ["`light_background`", "rename the light", "`background` out"] {
        assert!(message.contains(part), "{message}");
    }
    assert!(!files(folder).contains(&"named.exr".to_owned()));
    succeeds(folder, "render named.toml --layers depth");
    // Where the background is black, the name is free.
    let line = "background = [0.1, 0.2, 0.4]\n";
    assert!(named.contains(line));
    fs::write(folder.join("black.toml"), named.replace(line, "")).unwrap();
    succeeds(folder, "render black.toml --layers lights");
    let decoded = decode(&folder.join("black.exr"));
    assert_eq!(decoded.channels.len(), 4 + 2 * 3);

    // Spaces and letters of any script, as long as a name may be.
    let long = "ñ".repeat(100);
    let named = scene.replace("lights.key", "lights.\"left key\"");
    let named = named.replace("lights.fill", &format!("lights.\"{long}\""));
    fs::write(folder.join("script.toml"), named).unwrap();
    succeeds(folder, "render script.toml --layers lights");
    let info = oiiotool(folder, "--info -v script.exr");
    for name in ["left key", &long] {
        assert!(info.contains(&format!("light_{name}.R")), "{info}");
    }
}

/// Each of 100 lights, and the background, has three channels of four bytes.
#[test]
fn lights_that_fit_no_memory_are_refused() {
    let folder = folder();
    let folder = folder.path();
    let mut scene = fs::read_to_string(folder.join("ball.toml")).unwrap();
    for number in 0..98 {
        scene += &format!("[lights.l{number}.point]\nposition = [0, 9, 0]\nintensity = 1\n");
    }
    let large = scene.replace("[60, 40]", "[65536, 65536]");
    fs::write(folder.join("large.toml"), large).unwrap();
    let message = limited(folder, "render large.toml --layers lights --threads 2");
    // Strips of 65536 × 16 × (16 + 101 · 12) bytes and their blocks, 13 at once.
    for part in ["16.7 GB", "choose fewer --layers or", "--crop"] {
        assert!(message.contains(part), "{message}");
    }
}

/// What a command says that fails in no more than 16 GB of addresses.
fn limited(folder: &std::path::Path, arguments: &str) -> String {
    let mut command = std::process::Command::new("sh");
    command
        .current_dir(folder)
        .args([
            "-c",
            &format!("ulimit -v 16000000 && exec \"$0\" {arguments}"),
        ])
        .arg(candela(folder, "").get_program());
    let output = command.output().unwrap();
    let message = text(&output.stderr);
    assert_eq!(output.status.code(), Some(75), "{message}");
    message
}

/// Asked for the memory before hours of rendering: 471 bands of the largest image.
#[test]
fn bands_that_fit_no_memory_are_refused() {
    let folder = folder();
    let folder = folder.path();
    let scene = fs::read_to_string(folder.join("ball.toml")).unwrap();
    let large = scene.replace("[60, 40]", "[65536, 65536]");
    fs::write(folder.join("large.toml"), large).unwrap();
    let options = "--layers spectral --wavelengths 360:830:1";
    // A strip of 65536 × 16 × (16 + 471 · 4) bytes is 2 GB, a block is as large, and of both together two
    // threads want 13 at once, more than a process may ask for here.
    let message = limited(folder, &format!("render large.toml --threads 2 {options}"));
    for part in ["25.9 GB", "--wavelengths", "--crop"] {
        assert!(message.contains(part), "{message}");
    }

    let piz = format!("render large.toml --compression piz {options}");
    let message = fails(folder, &piz, 1);
    assert!(message.contains("blocks of 4.0 GB"), "{message}");
}

#[test]
fn halves_that_hold_bands_badly_are_reported() {
    let folder = folder();
    let output = output(folder.path(), "render ball.toml --layers spectral --half");
    let message = text(&output.stderr);
    assert!(output.status.success(), "{message}");
    assert!(
        message.contains("of which HALF keeps few digits"),
        "{message}"
    );
    let bands = decode(&folder.path().join("ball.exr"));
    let pixels = (RESOLUTION[0] * RESOLUTION[1]) as usize;
    assert_eq!(bands.values.len(), pixels * 45);
}

/// A mirror with a color lets no sum over reflectances be made: the message names it, and what is not asked for is left out.
#[test]
fn mirrors_that_color_light_are_named() {
    let folder = colorful();
    let folder = folder.path();
    let scene = fs::read_to_string(folder.join("ball.toml")).unwrap()
        + "\n[materials.ring.metal]\npreset = \"gold\"\n\
           [objects.ring.sphere]\nmaterial = \"ring\"\ncenter = [0, 50, 0]\nradius = 1\n";
    fs::write(folder.join("ring.toml"), scene).unwrap();
    let asked = "render ring.toml -o none.exr --layers lights,relight";
    let message = fails(folder, asked, 1);
    assert!(message.contains("the material `ring`"), "{message}");
    assert!(!folder.join("none.exr").exists());
    succeeds(folder, "render ring.toml -o ring.exr --layers lights");
    succeeds(folder, "relight ring.exr -o dim.exr --light key=0.5");
    let message = fails(folder, "relight ring.exr -o red.exr --light key=#ff0000", 1);
    assert!(
        message.contains("unless mirrors or glass color light"),
        "{message}"
    );
}
