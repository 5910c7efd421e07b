//! `candela new`, and the pictures that the README shows.

use std::fs;
use std::path::Path;

use candela::scene;

use super::{candela, fails, files, succeeds, text};

const FIRST: &str = include_str!("../../scenes/first.toml");

#[test]
fn a_new_scene_is_rendered_by_the_command_that_is_printed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let message = succeeds(folder, "new");
    assert_eq!(files(folder), ["candela.schema.json", "scene.toml"]);
    let scene = fs::read_to_string(folder.join("scene.toml")).unwrap();
    assert_eq!(scene, format!("#:schema ./candela.schema.json\n\n{FIRST}"));
    let schema = fs::read_to_string(folder.join("candela.schema.json")).unwrap();
    assert_eq!(schema, scene::schema());
    assert!(message.contains("scene.toml: "), "{message}");
    assert!(message.contains("candela.schema.json: "), "{message}");

    let next = "  candela render scene.toml --preview scene.png\n  candela check scene.toml\n";
    assert!(message.ends_with(next), "{message}");
    succeeds(folder, "check scene.toml");
    // Of the picture a part, for the time it takes.
    let arguments = "render scene.toml --preview scene.png --crop 400,200,420,210";
    let output = candela(folder, arguments).output().unwrap();
    assert!(output.status.success());
    assert!(
        !text(&output.stderr).contains("warning"),
        "{}",
        text(&output.stderr)
    );
}

#[test]
fn a_folder_is_made_and_named_in_what_to_do_next() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let message = succeeds(folder, "new my/pictures");
    assert!(
        message.contains("candela render my/pictures/scene.toml --preview scene.png"),
        "{message}"
    );
    let made = folder.join("my/pictures");
    assert_eq!(files(&made), ["candela.schema.json", "scene.toml"]);
    succeeds(folder, "check my/pictures/scene.toml");
}

#[test]
fn nothing_is_written_over() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("scene.toml"), "mine").unwrap();
    let message = fails(folder, "new", 1);
    assert!(message.contains("scene.toml is there already"), "{message}");
    assert!(message.contains("candela new my-scene"), "{message}");
    assert_eq!(files(folder), ["scene.toml"]);
    assert_eq!(
        fs::read_to_string(folder.join("scene.toml")).unwrap(),
        "mine"
    );

    // Its own scene may have been changed as well.
    succeeds(folder, "new own");
    fails(folder, "new own", 1);
    // Another schema is somebody's; the same one serves many scenes.
    fs::remove_file(folder.join("own/scene.toml")).unwrap();
    succeeds(folder, "new own");
    fs::remove_file(folder.join("own/scene.toml")).unwrap();
    fs::write(folder.join("own/candela.schema.json"), "{}").unwrap();
    fails(folder, "new own", 1);
    assert_eq!(files(&folder.join("own")), ["candela.schema.json"]);

    // A file is no folder, and a link to nowhere is something.
    let message = fails(folder, "new scene.toml", 1);
    assert!(
        message.contains("cannot make the folder scene.toml"),
        "{message}"
    );
    #[cfg(unix)]
    {
        fs::create_dir(folder.join("linked")).unwrap();
        std::os::unix::fs::symlink("nowhere", folder.join("linked/scene.toml")).unwrap();
        fails(folder, "new linked", 1);
        assert!(!folder.join("linked/nowhere").exists());
    }
}

/// A folder whose name looks like an option is named so that the next command takes it for a folder.
#[cfg(unix)]
#[test]
fn a_folder_that_looks_like_an_option() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let message = succeeds(folder, "new -- -q");
    assert!(
        message.contains("  candela check ./-q/scene.toml\n"),
        "{message}"
    );
    succeeds(folder, "check ./-q/scene.toml");
}

/// Where the README shows the scene's picture, it quotes the scene.
#[test]
fn the_readme_quotes_the_first_scene() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = fs::read_to_string(root.join("README.md")).unwrap();
    let quote = format!("```toml\n{FIRST}```\n");
    assert_eq!(
        readme.contains("docs/pictures/first.png"),
        readme.contains(&quote),
        "scenes/first.toml, between lines of ```, and docs/pictures/first.png stand together"
    );
}

/// A PNG's width and height, and its bytes decoded.
fn decoded(path: &Path) -> ((u32, u32), Vec<u8>) {
    let file = std::io::BufReader::new(fs::File::open(path).unwrap());
    let mut reader = png::Decoder::new(file).read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    ((info.width, info.height), bytes)
}

/// Whoever runs the README's commands gets the README's pictures, pixel by pixel.
#[test]
fn the_pictures_of_the_readme_are_those_of_its_commands() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = fs::read_to_string(root.join("README.md")).unwrap();
    let command = "render scenes/lecture.toml -o lecture.exr --preview lecture.png";
    assert!(readme.contains(&format!("cargo run --release -- {command}")));

    let scenes = root.join("scenes");
    let render = |arguments: [&str; 6]| {
        let status = candela(folder, "").args(arguments).arg("--quiet").status();
        assert!(status.unwrap().success());
    };
    let scene = |name: &str| scenes.join(name).to_str().unwrap().to_owned();
    for (name, scene) in [
        ("lecture", scene("lecture.toml")),
        ("first", scene("first.toml")),
    ] {
        let (exr, png) = (format!("{name}.exr"), format!("{name}.png"));
        render(["render", &scene, "-o", &exr, "--preview", &png]);
        let shown = root.join("docs/pictures").join(&png);
        let (size, pixels) = decoded(&folder.join(&png));
        let (shown_size, shown_pixels) = decoded(&shown);
        assert_eq!(size, shown_size);
        let differ = pixels
            .iter()
            .zip(&shown_pixels)
            .filter(|(a, b)| a != b)
            .count();
        assert_eq!(
            (differ, pixels.len()),
            (0, shown_pixels.len()),
            "docs/pictures/{name}.png is not what is rendered; docs/pictures.sh {name} makes it anew"
        );
    }
    for line in ["/lecture.exr", "/lecture.png"] {
        let ignored = fs::read_to_string(root.join(".gitignore")).unwrap();
        assert!(ignored.lines().any(|ignored| ignored == line), "{line}");
    }
}
