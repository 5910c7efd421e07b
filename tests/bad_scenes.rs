//! Scenes that are wrong in one way each, and exactly what the user is told.
//!
//! `tests/bad_scenes/NAME.toml` states its claim in the first line; `NAME.txt` beside it is the
//! message. `BLESS=1` writes the messages anew.

use std::fs;
use std::path::{Path, PathBuf};

use candela::world::World;

/// Relative to the package, where tests run, so that messages name no folder of one machine.
const FOLDER: &str = "tests/bad_scenes";

/// The scenes are here to grow: fewer than these means that the folder was not found whole.
const AT_LEAST: usize = 40;

fn files(extension: &str) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = fs::read_dir(FOLDER)
        .expect("tests run in the package's folder")
        .map(|entry| entry.expect("the folder is readable").path())
        .filter(|path| path.extension().is_some_and(|found| found == extension))
        .collect();
    files.sort();
    files
}

fn message(scene: &Path) -> Option<String> {
    let error = World::load(scene).err()?;
    Some(format!("{error}\n"))
}

#[test]
fn each_bad_scene_gets_its_message() {
    let bless = std::env::var_os("BLESS").is_some();
    let scenes = files("toml");
    assert!(scenes.len() >= AT_LEAST, "{} scenes", scenes.len());
    let mut different = Vec::new();
    for scene in scenes {
        let actual = message(&scene).unwrap_or_else(|| panic!("{} is read", scene.display()));
        let beside = scene.with_extension("txt");
        if bless {
            fs::write(&beside, &actual).unwrap();
        } else if fs::read_to_string(&beside).ok().as_ref() != Some(&actual) {
            different.push(format!("{}:\n{actual}", scene.display()));
        }
    }
    assert!(
        different.is_empty(),
        "these messages have changed (BLESS=1 accepts them):\n\n{}",
        different.join("\n")
    );
}

#[test]
fn each_message_belongs_to_a_scene() {
    let messages = files("txt");
    assert!(messages.len() >= AT_LEAST);
    for message in messages {
        let scene = message.with_extension("toml");
        assert!(scene.exists(), "{}", scene.display());
    }
}

#[test]
fn a_file_that_is_not_there() {
    assert_eq!(
        message(Path::new("tests/bad_scenes/no_such_file.toml")).unwrap(),
        "error: cannot read the scene file: No such file or directory (os error 2)\n\
         --> tests/bad_scenes/no_such_file.toml\n \
         = help: without a scene file, `candela render` renders the built-in scene\n"
    );
}

#[test]
fn a_folder_is_not_a_scene() {
    let message = message(Path::new(FOLDER)).unwrap();
    assert!(
        message.starts_with("error: cannot read the scene file: "),
        "{message}"
    );
    assert!(message.contains("--> tests/bad_scenes\n"), "{message}");
}
