//! candela and the yardstick in turn on one scene: times, and whether the pictures agree.

use std::path::Path;
use std::time::Instant;

use candela::Camera;
use candela::exr::ExrOptions;
use candela::image::Film;
use candela::output::Unfinished;
use candela::render::{Counts, Job, Options, RenderError, Renderer};
use candela::world::{Loaded, World};
use rayon::ThreadPool;
use serde::Serialize;

use super::Result;
use super::scenes::Scene;
use super::work::Work;
use super::yardstick::{self, Yardstick};

/// What a render makes.
type Rendered = std::result::Result<(Film, Counts), RenderError>;

/// Pictures agree in a pixel where every channel does to this share. Embree and the yardstick compute
/// in f32: near a shadow's terminator and in highlights that is good for some 1e-4.
const TOLERANCE: f32 = 1e-3;

/// A pixel is at an edge where a channel of its 3 × 3 neighborhood varies by more than this share:
/// there a ray's rounding decides what it hits.
const EDGE: f32 = 0.1;

/// What is measured, and with what.
pub(crate) struct Bench<'a> {
    pub(crate) folder: &'a Path,
    pub(crate) program: Option<&'a Path>,
    pub(crate) threads: usize,
    pub(crate) runs: u32,
}

/// Of several measurements.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Spread {
    pub(crate) median: f64,
    pub(crate) min: f64,
    pub(crate) max: f64,
}

/// How two pictures of one sample a pixel differ.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Agreement {
    pub(crate) pixels: usize,
    /// Pixels that differ by more than the tolerance.
    pub(crate) different: usize,
    /// Those among them that are not at an edge.
    pub(crate) different_inside: usize,
    /// The mean of the yardstick's picture over that of candela's, less 1.
    pub(crate) mean: f64,
}

/// One scene with so many lights and samples. Times in seconds.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Row {
    pub(crate) scene: String,
    pub(crate) content: String,
    pub(crate) lights: usize,
    pub(crate) samples: u32,
    pub(crate) primary_rays: u64,
    pub(crate) shadow_rays: u64,
    pub(crate) work: Work,
    pub(crate) load: f64,
    pub(crate) build: f64,
    pub(crate) render: Spread,
    pub(crate) write: f64,
    pub(crate) embree_build: Option<f64>,
    pub(crate) embree_render: Option<Spread>,
    /// Embree's time over candela's, run by run.
    pub(crate) ratio: Option<Spread>,
    /// Seconds of the yardstick's shading alone, without a ray traced.
    pub(crate) shading: Option<f64>,
    pub(crate) agreement: Option<Agreement>,
    #[serde(skip)]
    pub(crate) embree_version: Option<String>,
}

impl Spread {
    pub(crate) fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let (low, high) = (values[(values.len() - 1) / 2], values[values.len() / 2]);
        Self {
            median: (low + high) / 2.0,
            min: values[0],
            max: values[values.len() - 1],
        }
    }
}

/// What `work` gives, and the seconds that it takes.
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

pub(crate) fn pool(threads: usize) -> Result<ThreadPool> {
    Ok(rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?)
}

/// A world, its camera, and the seconds that it takes to read the scene and validate it.
pub(crate) fn load(
    path: &Path,
    change: impl FnOnce(&mut candela::Scene),
) -> Result<(World, Camera, f64)> {
    let start = Instant::now();
    let Loaded { world, camera, .. } = World::load_with(path, change)?;
    Ok((world, camera, start.elapsed().as_secs_f64()))
}

impl Bench<'_> {
    /// Measures a scene with each of these numbers of lights and samples.
    pub(crate) fn scene(
        &self,
        scene: &Scene,
        lights: &[usize],
        samples: &[u32],
    ) -> Result<Vec<Row>> {
        let mut yardstick = self.yardstick(scene)?;
        let pool = pool(self.threads)?;
        let mut rows = Vec::new();
        for &lights in lights {
            let (world, camera, load) =
                pool.install(|| load(&scene.path, |scene| scene.lights.truncate(lights)))?;
            let (renderer, build) = timed(|| pool.install(|| Renderer::new(&world)));
            let renderer = renderer?;
            let render_with = |samples: u32, counts_work: bool| -> (Rendered, f64) {
                let options = Options {
                    samples,
                    counts_work,
                    ..Options::default()
                };
                let render = || renderer.film(&camera, &options, &Job::new());
                timed(|| pool.install(render))
            };
            let render = |samples: u32| render_with(samples, false);
            // The first renders of both are not measured.
            let (film, _) = render(1).0?;
            let agreement = match &mut yardstick {
                None => None,
                Some(yardstick) => {
                    yardstick.render(1, self.threads, lights)?;
                    Some(Agreement::of(&film, &yardstick.image(self.folder)?)?)
                }
            };
            let exr = self.folder.join(format!("{}.exr", scene.name));
            let (written, write) = timed(|| {
                pool.install(|| film.write_exr(&exr, &ExrOptions::default(), &Unfinished::new()))
            });
            written?;
            for &samples in samples {
                let (mut ours, mut theirs, mut shading) = (Vec::new(), Vec::new(), Vec::new());
                // To tell leaves apart takes a little time: this one is not measured.
                let (_, counts) = render_with(samples, true).0?;
                for _ in 0..self.runs {
                    let (rendered, seconds) = render(samples);
                    rendered?;
                    ours.push(seconds);
                    if let Some(yardstick) = &mut yardstick {
                        theirs.push(yardstick.render(samples, self.threads, lights)?);
                        shading.push(yardstick.shade(samples, self.threads, lights)?);
                    }
                }
                let ratios: Vec<f64> = ours
                    .iter()
                    .zip(&theirs)
                    .map(|(ours, theirs)| theirs / ours)
                    .collect();
                let if_run = |values: Vec<f64>| (!values.is_empty()).then(|| Spread::of(values));
                rows.push(Row {
                    scene: scene.name.clone(),
                    content: scene.content.clone(),
                    lights,
                    samples,
                    primary_rays: counts.primary_rays,
                    shadow_rays: counts.shadow_rays,
                    work: Work::of(&counts),
                    load,
                    build,
                    render: Spread::of(ours),
                    write,
                    embree_build: yardstick.as_ref().map(|yardstick| yardstick.build),
                    embree_render: if_run(theirs),
                    ratio: if_run(ratios),
                    shading: if_run(shading).map(|spread| spread.median),
                    agreement,
                    embree_version: yardstick
                        .as_ref()
                        .map(|yardstick| yardstick.version.clone()),
                });
            }
        }
        Ok(rows)
    }

    /// The yardstick with a scene and all of its lights.
    pub(crate) fn yardstick(&self, scene: &Scene) -> Result<Option<Yardstick>> {
        let Some(program) = self.program else {
            return Ok(None);
        };
        let (world, camera, _) = load(&scene.path, |_| {})?;
        let path = self.folder.join(format!("{}.bin", scene.name));
        yardstick::write_scene(&world, &camera, &path)?;
        drop(world);
        Ok(Some(Yardstick::start(program, &path, self.threads)?))
    }
}

impl Agreement {
    /// Compares two pictures of the same size.
    pub(crate) fn of(film: &Film, yardstick: &[[f32; 3]]) -> Result<Self> {
        let ours: Vec<[f32; 3]> = film
            .pixels()
            .iter()
            .map(|&[r, g, b, _]| [r, g, b])
            .collect();
        if ours.len() != yardstick.len() {
            return Err("the yardstick's picture has another size".into());
        }
        let [width, height] = film.resolution().map(|side| side as usize);
        let mut agreement = Self {
            pixels: ours.len(),
            different: 0,
            different_inside: 0,
            mean: sum(yardstick) / sum(&ours) - 1.0,
        };
        for (index, (a, b)) in ours.iter().zip(yardstick).enumerate() {
            let differs = |channel: usize| {
                let (a, b) = (a[channel], b[channel]);
                let agrees = (a - b).abs() <= TOLERANCE * a.abs().max(b.abs());
                !agrees // So that NaN differs from everything.
            };
            if !(0..3).any(differs) {
                continue;
            }
            agreement.different += 1;
            let (x, y) = (index % width, index / width);
            let columns = x.saturating_sub(1)..(x + 2).min(width);
            let rows = y.saturating_sub(1)..(y + 2).min(height);
            let varies = |channel: usize| {
                let neighbors = rows.clone().flat_map(|y| {
                    let row = &ours[y * width..][..width];
                    row[columns.clone()].iter().map(move |pixel| pixel[channel])
                });
                let (low, high) = neighbors.fold((f32::INFINITY, 0.0_f32), |(low, high), value| {
                    (low.min(value), high.max(value))
                });
                high - low > EDGE * high
            };
            agreement.different_inside += usize::from(!(0..3).any(varies));
        }
        Ok(agreement)
    }
}

fn sum(pixels: &[[f32; 3]]) -> f64 {
    pixels
        .as_flattened()
        .iter()
        .map(|&value| f64::from(value))
        .sum()
}
