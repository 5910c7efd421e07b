//! The conformance suite: small scenes whose pictures a formula gives, by code of another language.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use candela::exr::{ExrImage, read};
use candela::scene::Scene;
use serde_json::Value;

use crate::images::film_of;
use crate::measured::Measured;

/// The scenes, their pictures and the scripts that make and run them.
pub(crate) const FOLDER: &str = "reference/conformance";

/// Below this part of the picture's peak, errors are relative to that.
const FLOOR: f64 = 1e-6;

/// A script of the suite, by the Python that `tests/setup.sh` has found.
pub(crate) fn script(name: &str) -> Command {
    let python = "target/openimageio/bin/python";
    assert!(Path::new(python).exists(), "run ./check, which installs it");
    let mut command = Command::new(python);
    command
        .arg(Path::new(FOLDER).join(name))
        .env("PYTHONDONTWRITEBYTECODE", "1");
    command
}

/// Runs a script that judges candela by another program, and fails where one of the facts that it prints does not
/// hold. `environment` has a Python of `tests/setup.sh`, which leaves it out where it cannot be installed.
pub(crate) fn judge(environment: &str, script: &str) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let python = folder.join(format!("target/{environment}/bin/python"));
    if !python.exists() {
        println!(
            "skipped: {} is missing; ./check installs it",
            python.display()
        );
        return;
    }
    let output = Command::new(python)
        .args([script, env!("CARGO_BIN_EXE_candela")])
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .unwrap();
    println!("{}", printed(&output));
    assert!(output.status.success(), "{}", printed(&output));
}

pub(crate) fn printed(output: &Output) -> String {
    format!(
        "{}{}",
        String::from_utf8_lossy(&output.stdout),
        String::from_utf8_lossy(&output.stderr)
    )
}

/// Name, formula and tolerance of each case.
pub(crate) fn suite() -> Vec<(String, String, f64)> {
    let list = fs::read_to_string(Path::new(FOLDER).join("suite.json")).unwrap();
    let list: Value = serde_json::from_str(&list).unwrap();
    let cases = list.as_array().unwrap().iter();
    let text = |case: &Value, key: &str| case[key].as_str().unwrap().to_owned();
    cases
        .map(|case| {
            let tolerance = case["tolerance"].as_f64().unwrap();
            (text(case, "name"), text(case, "formula"), tolerance)
        })
        .collect()
}

/// Files of the suite, their names alone, in order.
fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap();
    let mut files: Vec<PathBuf> = entries
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|found| found == extension))
        .map(|path| path.file_name().unwrap().into())
        .collect();
    files.sort();
    files
}

fn see(worst: &mut Measured, name: &str, actual: &[[f32; 4]], expected: &ExrImage) {
    assert_eq!(actual.len(), expected.pixels.len(), "{name}");
    let channels = |pixel: &[f32; 4]| [0, 1, 2].map(|i: usize| f64::from(pixel[i]));
    let brightest = |pixel: &[f32; 4]| {
        channels(pixel)
            .map(f64::abs)
            .into_iter()
            .fold(0.0, f64::max)
    };
    let peak = expected.pixels.iter().map(brightest).fold(0.0, f64::max);
    for (index, (actual, expected)) in actual.iter().zip(&expected.pixels).enumerate() {
        assert_eq!(actual[3], expected[3], "{name}, pixel {index}");
        let scale = brightest(expected).max(FLOOR * peak);
        for (a, b) in channels(actual).into_iter().zip(channels(expected)) {
            worst.see((a - b).abs() / scale, || format!("{name}, pixel {index}"));
        }
    }
}

#[test]
fn every_case_is_its_formula() {
    let suite = suite();
    assert!(suite.len() >= 24, "{}", suite.len());
    let folder = Path::new(FOLDER);
    let mut worst = Measured::rounding("conformance");
    for (name, _, tolerance) in &suite {
        let scene = Scene::load(folder.join(format!("{name}.toml")));
        let scene = scene.unwrap_or_else(|error| panic!("{error}"));
        let expected = read(&folder.join(format!("{name}.exr"))).unwrap();
        see(&mut worst, name, film_of(&scene, 1).pixels(), &expected);
        // What is asked of others is less than what is held here.
        assert!((1e-6..=1e-4).contains(tolerance), "{name}: {tolerance}");
    }
    worst.judge();
}

/// Each file belongs to a case, and the page has each case with its formula.
#[test]
fn the_suite_is_whole() {
    let suite = suite();
    for extension in ["toml", "exr"] {
        let mut named: Vec<PathBuf> = suite
            .iter()
            .map(|(name, ..)| format!("{name}.{extension}").into())
            .collect();
        named.sort();
        assert_eq!(files(Path::new(FOLDER), extension), named);
    }
    let page = fs::read_to_string("docs/conformance.md").unwrap();
    for (name, formula, _) in &suite {
        let row = format!("| `{name}` | {formula} |");
        assert!(page.lines().any(|line| line == row), "{row}");
    }
}

/// The script makes the same scenes, and the same pictures but for the last bit of a mathematical library.
#[test]
fn the_suite_can_be_made_again() {
    let folder = tempfile::tempdir().unwrap();
    let output = script("generate.py").arg(folder.path()).output().unwrap();
    assert!(output.status.success(), "{}", printed(&output));
    for extension in ["toml", "obj", "json"] {
        let names = files(folder.path(), extension);
        assert_eq!(names, files(Path::new(FOLDER), extension));
        for name in names {
            let text = |folder: &Path| fs::read_to_string(folder.join(&name)).unwrap();
            assert_eq!(text(folder.path()), text(Path::new(FOLDER)));
        }
    }
    let mut worst = Measured::rounding("pictures made again");
    for name in files(folder.path(), "exr") {
        let made = read(&folder.path().join(&name)).unwrap();
        let kept = read(&Path::new(FOLDER).join(&name)).unwrap();
        see(&mut worst, &name.to_string_lossy(), &made.pixels, &kept);
    }
    worst.judge();
}

/// What others run: the program, from file to file, and the score.
#[test]
fn the_runner_scores() {
    let program = [
        "--renderer",
        "candela",
        "--program",
        env!("CARGO_BIN_EXE_candela"),
        "--jobs",
        "2",
    ];
    let output = script("run.py").args(program).output().unwrap();
    let text = printed(&output);
    assert!(output.status.success(), "{text}");
    let count = suite().len();
    let score = format!("candela: {count} pass, 0 fail, 0 not expressible, of {count}");
    assert!(text.contains(&score), "{text}");
    // And it can fail.
    let output = script("run.py")
        .args(program)
        .args(["--tolerance", "1e-12", "blackbody"])
        .output()
        .unwrap();
    let text = printed(&output);
    assert_eq!(output.status.code(), Some(1), "{text}");
    assert!(text.contains("candela: 0 pass, 1 fail"), "{text}");
}
