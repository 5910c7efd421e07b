//! `candela new`: a first scene, to start from.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use candela::internal::printable_path;
use candela::output::{self, Unfinished};
use candela::scene::schema;

use super::Failure;

/// The scene, as it stands in `scenes/` and in the README.
const SCENE: &str = include_str!("../../scenes/first.toml");

/// What the scene is called in the new folder.
const SCENE_NAME: &str = "scene.toml";

/// What the schema is called beside it.
const SCHEMA_NAME: &str = "candela.schema.json";

/// Start a scene of one's own: write a small one, with comments, to scene.toml
///
/// Beside it goes candela.schema.json, by which editors complete keys and explain them. Nothing that is
/// there is written over.
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Examples:
  candela new
      Write scene.toml here
  candela new pictures
      Write it to the folder `pictures`, which is made if it is not there")]
pub(crate) struct Arguments {
    /// The folder [default: the current one]
    #[arg(value_name = "DIR")]
    folder: Option<PathBuf>,
}

/// Writes the files, and what to do next to `messages`.
pub(crate) fn run(
    arguments: &Arguments,
    unfinished: &Unfinished,
    messages: &mut impl Write,
) -> Result<(), Failure> {
    let folder = arguments.folder.as_deref().unwrap_or(Path::new(""));
    let scene = format!("#:schema ./{SCHEMA_NAME}\n\n{SCENE}");
    let files = [
        (SCENE_NAME, scene, "a scene to start from"),
        (SCHEMA_NAME, schema(), "what a scene may say, for editors"),
    ];
    let files = files.map(|(name, text, what)| (folder.join(name), text, what));
    for (path, text, _) in &files {
        // A link that leads nowhere is something, too.
        let Ok(there) = path.symlink_metadata() else {
            continue;
        };
        // One schema serves many scenes.
        let is_the_schema = path.ends_with(SCHEMA_NAME)
            && there.is_file()
            && fs::read(path).is_ok_and(|found| found == text.as_bytes());
        if !is_the_schema {
            return Err(format!(
                "{} is there already, and nothing is written over it; name another folder, such as \
                 `candela new my-scene`, or move the file away",
                printable_path(path),
            )
            .into());
        }
    }
    if !folder.as_os_str().is_empty() {
        fs::create_dir_all(folder).map_err(|error| {
            format!("cannot make the folder {}: {error}", printable_path(folder))
        })?;
    }
    // The scene last: where it is missing, the same command may be tried again.
    for (path, text, _) in files.iter().rev() {
        output::write(path, unfinished, |sink| sink.write_all(text.as_bytes()))?;
    }
    for (path, _, what) in &files {
        writeln!(messages, "{}: {what}", printable_path(path))?;
    }
    let scene = quoted(&no_option(&files[0].0));
    writeln!(
        messages,
        "\nNext:\n  candela render {scene} --preview scene.png\n  candela check {scene}"
    )?;
    Ok(())
}

/// A path that a command does not take for an option.
fn no_option(path: &Path) -> PathBuf {
    if path.as_os_str().as_encoded_bytes().starts_with(b"-") {
        Path::new(".").join(path)
    } else {
        path.to_path_buf()
    }
}

/// A path as a shell takes it: in quotes where it holds more than plain letters.
fn quoted(path: &Path) -> String {
    let text = printable_path(path);
    let is_plain = |c: char| c.is_alphanumeric() || "/._-+:\\".contains(c);
    if text.chars().all(is_plain) {
        return text;
    }
    if cfg!(windows) {
        format!("\"{text}\"")
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use candela::scene::Scene;
    use candela::world::{World, physics};

    #[test]
    fn the_scene_is_legal_and_nothing_is_odd_about_it() {
        let scene = Scene::parse(SCENE, SCENE_NAME).unwrap();
        let warnings = physics::warnings(&World::new(&scene).unwrap().0);
        assert_eq!(warnings, []);
    }

    /// Whoever reads it may have no other text at hand.
    #[test]
    fn every_key_is_explained_where_it_is_first_met() {
        let mut met: Vec<&str> = Vec::new();
        for line in SCENE
            .lines()
            .filter(|line| !line.trim_start().starts_with('#'))
        {
            // A comment has two spaces before it; a color's # has none.
            let (code, comment) = line.split_once("  #").unwrap_or((line, ""));
            let key = match code.split_once('=') {
                Some((key, _)) => key.trim(),
                // `[materials.jade.phong]` is as `[materials.clay.phong]`.
                None => code.trim().rsplit('.').next().unwrap_or_default(),
            };
            if !key.is_empty() && !met.contains(&key) {
                assert!(!comment.is_empty(), "{line}");
                met.push(key);
            }
        }
        assert!(met.len() > 15, "{met:?}");
    }

    #[test]
    fn paths_are_quoted_for_the_shell() {
        assert_eq!(quoted(Path::new("a/scene.toml")), "a/scene.toml");
        if cfg!(not(windows)) {
            assert_eq!(quoted(Path::new("my scene.toml")), "'my scene.toml'");
            assert_eq!(quoted(Path::new("it's/s.toml")), r"'it'\''s/s.toml'");
        }
    }
}
