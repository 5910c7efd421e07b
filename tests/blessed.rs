//! Images of all scenes as somebody looked at them and found them right.
//!
//! `BLESS=1` writes them anew. They are compared bit by bit: the renderer computes with IEEE
//! operations and the `libm` crate alone, whose results no machine, compiler or number of threads
//! may change.

use std::fs;
use std::path::{Path, PathBuf};

use candela::exr::{ExrOptions, read};
use candela::image::{Film, Window};
use candela::output::Unfinished;
use candela::scene::Scene;

use crate::images::{at_width, bits, film_of, name_of, scene_files};

const FOLDER: &str = "reference";

/// Columns of the images: enough to show what is wrong, little to keep.
const WIDTH: u32 = 160;

/// More than one, so that the pattern of samples and the filter are part of the promise.
const SAMPLES: u32 = 4;

fn rendered(path: &Path) -> Film {
    let scene = Scene::load(path).unwrap_or_else(|error| panic!("{error}"));
    film_of(&at_width(scene, WIDTH), SAMPLES)
}

fn write(film: &Film, path: &Path) {
    film.write_exr(path, &ExrOptions::default(), &Unfinished::new())
        .unwrap();
}

fn reference_of(scene: &Path) -> PathBuf {
    Path::new(FOLDER).join(name_of(scene)).with_extension("exr")
}

/// The image as the film that it was written from, but for what its header says.
fn blessed(reference: &Path, like: &Film) -> Result<Film, String> {
    if !reference.exists() {
        return Err(format!("{} is missing", reference.display()));
    }
    let image = read(reference).map_err(|error| error.to_string())?;
    if image.resolution != like.resolution() {
        return Err(format!(
            "{} has {:?} pixels, the image {:?}",
            reference.display(),
            image.resolution,
            like.resolution()
        ));
    }
    let window = Window::whole(image.resolution);
    Ok(Film::new(
        image.resolution,
        window,
        image.pixels,
        like.metadata().clone(),
    ))
}

/// What differs, with the files that show it.
fn compare(name: &str, actual: &Film, expected: &Film) -> Result<(), String> {
    let (actual_bits, expected_bits) = (bits(actual), bits(expected));
    let different = actual_bits
        .iter()
        .zip(&expected_bits)
        .filter(|(actual, expected)| actual != expected)
        .count();
    if different == 0 {
        return Ok(());
    }
    let difference: Vec<[f32; 4]> = actual
        .pixels()
        .iter()
        .zip(expected.pixels())
        .map(|(a, b)| std::array::from_fn(|i| (a[i] - b[i]).abs()))
        .collect();
    let largest = difference.iter().flatten().copied().fold(0.0, f32::max);
    let difference = Film::new(
        actual.resolution(),
        actual.window(),
        difference,
        actual.metadata().clone(),
    );
    let folder = Path::new("target/blessed");
    fs::create_dir_all(folder).unwrap();
    let mut message = format!(
        "{name}: {different} of {} pixels differ, by {largest:e} at most:",
        actual_bits.len()
    );
    for (film, kind) in [
        (actual, "actual"),
        (expected, "expected"),
        (&difference, "difference"),
    ] {
        let path = folder.join(format!("{name}.{kind}.exr"));
        write(film, &path);
        message += &format!("\n  {}", path.display());
    }
    Err(message)
}

#[test]
fn every_scene_looks_as_blessed() {
    let bless = std::env::var_os("BLESS").is_some();
    let mut failures = Vec::new();
    for scene in scene_files() {
        let (actual, reference) = (rendered(&scene), reference_of(&scene));
        if bless {
            write(&actual, &reference);
        }
        let result = blessed(&reference, &actual)
            .and_then(|expected| compare(&name_of(&scene), &actual, &expected));
        failures.extend(result.err());
    }
    assert!(
        failures.is_empty(),
        "{}\nLook at the images; if they are right, BLESS=1 accepts them.",
        failures.join("\n")
    );
}

#[test]
fn every_blessed_image_has_a_scene() {
    let scenes: Vec<PathBuf> = scene_files()
        .iter()
        .map(|scene| reference_of(scene))
        .collect();
    for entry in fs::read_dir(FOLDER).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|found| found == "exr") {
            assert!(scenes.contains(&path), "{} has no scene", path.display());
        }
    }
}

/// A difference of the last bit in one pixel is found, and shown.
#[test]
fn one_bit_is_a_difference() {
    let expected = film_of(&at_width(Scene::builtin(), 40), 1);
    let mut pixels = expected.pixels().to_vec();
    let pixel = pixels.iter_mut().find(|pixel| pixel[0] > 0.0).unwrap();
    pixel[0] = pixel[0].next_up();
    let actual = Film::new(
        expected.resolution(),
        expected.window(),
        pixels,
        expected.metadata().clone(),
    );
    let message = compare("one bit", &actual, &expected).unwrap_err();
    assert!(message.starts_with("one bit: 1 of "), "{message}");
    for kind in ["actual", "expected", "difference"] {
        let path = PathBuf::from(format!("target/blessed/one bit.{kind}.exr"));
        assert!(message.contains(path.to_str().unwrap()), "{message}");
        assert_eq!(read(&path).unwrap().pixels.len(), expected.pixels().len());
        fs::remove_file(path).unwrap();
    }
    assert!(compare("one bit", &expected, &expected).is_ok());
}
