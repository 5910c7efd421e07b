//! From scenes to images, the way a user would: text, scene, world, film.

use std::fs;
use std::path::{Path, PathBuf};

use candela::image::{Film, Window};
use candela::render::{Counts, Job, Options, Renderer, SimdLevel};
use candela::scene::{Material, Scene};
use candela::world::World;

/// Relative to the package, where tests run.
const SCENES: &str = "scenes";

/// Every file of `scenes/`, sorted.
pub(crate) fn scene_files() -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = fs::read_dir(SCENES)
        .expect("tests run in the package's folder")
        .map(|entry| entry.expect("the folder is readable").path())
        .filter(|path| path.extension().is_some_and(|found| found == "toml"))
        .collect();
    files.sort();
    assert!(!files.is_empty());
    files
}

/// What is rendered of a scene that is written here.
pub(crate) fn film_of_text(text: &str, options: &Options) -> Film {
    let scene = Scene::parse(text, "test.toml").unwrap_or_else(|error| panic!("{error}\n{text}"));
    let (world, camera) = World::new(&scene).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let renderer = Renderer::new(&world).unwrap();
    renderer.film(&camera, options, &Job::new()).unwrap().0
}

/// The same bits, those of layers as well, by any number of threads, on any instruction set, and in a part of the image.
pub(crate) fn assert_same_everywhere(text: &str, options: &Options, part: Window) {
    let bits = |film: &Film, place: usize| -> Vec<u32> {
        let values = film.pixels()[place].into_iter().chain(film.values(place));
        values.map(f32::to_bits).collect()
    };
    let whole = film_of_text(text, options);
    let mut others = Vec::new();
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        others.push(pool.install(|| film_of_text(text, options)));
    }
    for (_, simd) in SimdLevel::available() {
        let options = Options {
            simd,
            ..options.clone()
        };
        others.push(film_of_text(text, &options));
    }
    for other in &others {
        for place in 0..whole.pixels().len() {
            assert_eq!(bits(&whole, place), bits(other, place), "{place}\n{text}");
        }
    }
    let options = Options {
        window: Some(part),
        ..options.clone()
    };
    let film = film_of_text(text, &options);
    let [width, _] = whole.resolution();
    for (place, [x, y]) in part.pixels().enumerate() {
        let pixel = (y * width + x) as usize;
        assert_eq!(bits(&film, place), bits(&whole, pixel), "{x}, {y}\n{text}");
    }
}

/// Whether anything in a scene is perfectly smooth, a mirror or glass.
pub(crate) fn is_smooth(scene: &Scene) -> bool {
    let mut materials = scene.materials.iter();
    materials.any(|material| match &material.value {
        Material::Phong(lobes) | Material::NormalizedPhong(lobes) => lobes.coat.is_some(),
        Material::Mirror(_) | Material::Metal(_) | Material::Glass(_) | Material::Pane(_) => true,
    })
}

/// The file's name without its extension.
pub(crate) fn name_of(path: &Path) -> String {
    path.file_stem().unwrap().to_string_lossy().into_owned()
}

/// A scene from its text, without mesh files.
pub(crate) fn parse(text: &str) -> Scene {
    Scene::parse(text, "test.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// The image of a scene with `samples` samples a pixel.
pub(crate) fn film_of(scene: &Scene, samples: u32) -> Film {
    let (world, camera) = World::new(scene).unwrap_or_else(|error| panic!("{error}"));
    let options = Options {
        samples,
        ..Options::default()
    };
    candela::render(&world, &camera, &options).unwrap()
}

/// The image of a scene given as text.
pub(crate) fn render(text: &str, samples: u32) -> Film {
    film_of(&parse(text), samples)
}

/// R, G, B, A of one pixel.
pub(crate) fn pixel(film: &Film, x: u32, y: u32) -> [f32; 4] {
    let width = film.window().width;
    film.pixels()[(y * width + x) as usize]
}

/// [`render`], and what it took.
pub(crate) fn render_counted(text: &str, samples: u32) -> (Film, Counts) {
    let (world, camera) = World::new(&parse(text)).unwrap_or_else(|error| panic!("{error}"));
    let options = Options {
        samples,
        ..Options::default()
    };
    let renderer = Renderer::new(&world).unwrap();
    renderer.film(&camera, &options, &Job::new()).unwrap()
}

/// The same view in at most `width` columns.
pub(crate) fn at_width(mut scene: Scene, width: u32) -> Scene {
    let [columns, rows] = scene.image.resolution.value;
    if columns > width {
        let height = f64::from(width) * f64::from(rows) / f64::from(columns);
        scene.image.resolution.value = [width, (height.round() as u32).max(1)];
    }
    scene
}

/// The bits of all pixels: 0.0 and −0.0 differ, and NaN equals itself.
pub(crate) fn bits(film: &Film) -> Vec<[u32; 4]> {
    film.pixels()
        .iter()
        .map(|pixel| pixel.map(f32::to_bits))
        .collect()
}
