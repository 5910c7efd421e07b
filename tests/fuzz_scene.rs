//! Scene files that are damaged, or made to be expensive.

use std::fs;
use std::path::Path;

use candela::scene::{Diagnostics, Reading, Scene};
use candela::world::World;

use crate::fuzzing;
use crate::images::scene_files;

/// Cases by default: `CANDELA_FUZZ` is for more.
const CASES: u64 = 20_000;

/// The scenes of `scenes/` and those that are wrong in one way each.
fn corpus() -> Vec<Vec<u8>> {
    let bad = fs::read_dir("tests/bad_scenes").unwrap();
    let mut paths: Vec<_> = bad.map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|found| found == "toml"));
    paths.sort();
    assert!(paths.len() >= 40);
    // Legal scenes as often as all the others, or few cases would come far.
    let wrong = paths.len();
    paths.extend(scene_files().into_iter().cycle().take(wrong));
    paths.iter().map(|path| fs::read(path).unwrap()).collect()
}

/// The world, or the messages; with the meshes of the scenes in reach.
fn read(bytes: &[u8]) -> Result<World, Diagnostics> {
    let text = String::from_utf8_lossy(bytes).into_owned();
    let scene = Reading::of_text(text, Path::new("scenes/fuzzed.toml")).complete()?;
    World::new(&scene)
}

#[test]
fn the_scenes_are_accepted() {
    for path in scene_files() {
        assert_eq!(fuzzing::check(&fs::read(path).unwrap(), read), Ok(true));
    }
}

#[test]
fn damaged_scenes() {
    let corpus = corpus();
    let corpus: Vec<&[u8]> = corpus.iter().map(Vec::as_slice).collect();
    let outcomes = fuzzing::run("scene", &corpus, CASES, read);
    // Both ends must be reached, or the mutations are too timid or too wild.
    assert!(outcomes.accepted * 100 > outcomes.refused, "{outcomes:?}");
    assert!(outcomes.refused * 2 > outcomes.accepted, "{outcomes:?}");
}

/// Whatever the bytes, a file is read as its text is: also where they are not UTF-8, as most
/// mutations of binary numbers are not.
#[test]
fn damaged_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("fuzzed.toml");
    let corpus = corpus();
    let corpus: Vec<&[u8]> = corpus.iter().map(Vec::as_slice).collect();
    let outcomes = fuzzing::run("scene-file", &corpus, CASES / 20, |bytes| {
        fs::write(&path, bytes).unwrap();
        World::load(&path).map(|(_, world)| world)
    });
    assert!(
        outcomes.accepted > 0 && outcomes.refused > 0,
        "{outcomes:?}"
    );
}

/// Files of 300 kB whose form is simple and whose cost would be anything but linear in a careless
/// reader.
#[test]
fn expensive_scenes() {
    const SIZE: usize = 300_000;
    let lecture = &Scene::builtin().source.text;
    let repeated = |part: &str| part.repeat(SIZE / part.len());
    let numbered = |part: &str| -> String {
        (0..SIZE / part.len())
            .map(|number| part.replace('#', &number.to_string()))
            .collect()
    };
    for (name, text) in [
        ("open arrays", format!("[image]\na = {}", repeated("["))),
        ("open tables", format!("[image]\na = {}", repeated("{a="))),
        ("headers", repeated("[image]\n")),
        ("a deep header", format!("[{}a]", repeated("a."))),
        (
            "unknown keys",
            format!("[image]\n{}", numbered("key_# = 1\n")),
        ),
        ("unknown sections", numbered("[section_#]\n")),
        (
            "unknown materials",
            format!(
                "{lecture}{}",
                numbered(
                    "[objects.o#.sphere]\nmaterial = \"m#\"\ncenter = [0, 0, 0]\nradius = 1\n"
                )
            ),
        ),
        (
            "bad values",
            format!("{lecture}{}", numbered("[lights.l#.point]\nposition = 1\n")),
        ),
        (
            "a long name",
            format!("[materials.{}.phong]\n", "x".repeat(SIZE)),
        ),
        (
            "a long string",
            format!("[image]\ncolor_space = \"{}\"\n", "y".repeat(SIZE)),
        ),
        (
            "a long number",
            format!("[image]\nresolution = [{}, 1]\n", "9".repeat(SIZE)),
        ),
        ("comments", repeated("# comment\n")),
        ("quotes", repeated("\"")),
        (
            "commas",
            format!("[image]\nresolution = [{}]", repeated("1,")),
        ),
        (
            "inline",
            format!("[image]\nbackground = {{ {} }}", numbered("rgb# = 1, ")),
        ),
        ("no line end", "x".repeat(SIZE)),
        ("returns", repeated("\r")),
        (
            "legal",
            format!(
                "{lecture}{}",
                numbered(
                    "[objects.o#.sphere]\nmaterial = \"clay\"\ncenter = [#, 0, 0]\nradius = 1\n",
                )
            ),
        ),
    ] {
        match fuzzing::check(text.as_bytes(), read) {
            Ok(is_accepted) => assert_eq!(is_accepted, name == "legal", "`{name}`"),
            Err(broken) => panic!("`{name}` {broken}"),
        }
    }
}

/// As many lights as materials: their products are one for each pair.
#[test]
fn many_lights_on_many_materials() {
    let mut text = Scene::builtin().source.text.clone();
    for number in 0..1000 {
        text += &format!("[materials.m{number}.phong]\ndiffuse = 0.5\n");
        text += &format!("[lights.l{number}.point]\nposition = [0, 9, 0]\nintensity = 1\n");
    }
    assert_eq!(fuzzing::check(text.as_bytes(), read), Ok(true));
}
