//! The sweep: the reference, and each setting's time and error.

use std::time::Instant;

use candela::image::{Film, Window};
use candela::render::{Counts, Job, Options, RenderError};
use candela::scene::{Diagnostics, MAX_RESOLUTION, Scene, Transport};
use candela::world::{World, plan};
use candela::{Camera, Renderer};

use super::metrics::{Truth, planes};
use super::pictures;
use super::progress::Progress;
use super::setting::Setting;
use super::table::{Aim, LeftOut, ReferenceRow, Row};
use crate::cli::Failure;

/// Samples of the render that tells how long others will take.
const TRIAL: u32 = 16;

/// How many times smaller, along each side, the pixels of the reference are.
const FINER: u32 = 2;

/// Repeats end where they have taken so many seconds.
const PATIENCE: f64 = 10.0;

/// Errors below so many times the reference's own say little.
const ABOVE_REFERENCE: f64 = 2.0;

/// How a sweep goes about it.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) settings: Vec<Setting>,
    /// The most samples of the reference, and seconds that it may take.
    pub(super) reference: u32,
    pub(super) reference_seconds: f64,
    /// How often each setting is rendered.
    pub(super) runs: u32,
}

/// A reference that pictures can be held against.
pub(super) struct Reference {
    pub(super) row: ReferenceRow,
    pub(super) truth: Truth,
    pub(super) film: Film,
}

/// What was found of one transport.
pub(super) struct Swept {
    pub(super) reference: Reference,
    pub(super) rows: Vec<Row>,
    /// Of what was rendered to an error, how many samples each pixel took: what it is, and a PNG.
    pub(super) samples: Vec<(String, Vec<u8>)>,
    /// What cannot be rendered to an error.
    pub(super) left_out: Vec<LeftOut>,
}

/// How light is carried in a world.
fn transport(renderer: &Renderer<'_>) -> &'static str {
    match renderer.plan().transport() {
        plan::Transport::Rgb => Transport::Rgb.name(),
        plan::Transport::Spectral => Transport::Spectral.name(),
    }
}

/// The world of a scene whose light is carried so.
pub(super) fn world(scene: &Scene, transport: Transport) -> Result<(World, Camera), Diagnostics> {
    let mut scene = scene.clone();
    scene.image.transport.value = transport;
    World::new(&scene)
}

/// Renders the reference, then each setting as often as it is asked for.
pub(super) fn sweep(
    scene: &Scene,
    world: &World,
    camera: &Camera,
    plan: &Plan,
    progress: &Progress,
) -> Result<Swept, Failure> {
    let renderer = Renderer::new(world)?;
    let transport = transport(&renderer);
    progress.begin(format!("{transport}, the reference"));
    let reference = reference(&renderer, scene, camera, plan)?;
    progress.end();
    let (mut rows, mut samples, mut left_out) = (Vec::new(), Vec::new(), Vec::new());
    for &setting in &plan.settings {
        progress.begin(format!("{transport}, {}", setting.name()));
        match row(&renderer, camera, plan, setting, &reference) {
            Ok(row) => rows.push(row),
            Err(failure) if is_too_dark(&failure) => {
                left_out.push(LeftOut {
                    what: format!("{}, {transport}, {}", setting.series(), setting.name()),
                    why: failure.to_string(),
                });
                continue;
            }
            Err(failure) => return Err(failure),
        }
        if setting.target().is_some() {
            samples.push(samples_of(&renderer, camera, setting)?);
        }
        progress.end();
    }
    Ok(Swept {
        reference,
        rows,
        samples,
        left_out,
    })
}

/// Whether there is no light that errors could be relative to.
fn is_too_dark(failure: &Failure) -> bool {
    let error = failure.downcast_ref::<RenderError>();
    error.is_some_and(|error| matches!(error, RenderError::TooDark))
}

/// A film, what it took, and the seconds from the first ray to the finished film.
fn timed(
    renderer: &Renderer<'_>,
    camera: &Camera,
    options: &Options,
) -> Result<(Film, Counts, f64), Failure> {
    let start = Instant::now();
    let (film, counts) = renderer.film(camera, options, &Job::new())?;
    Ok((film, counts, start.elapsed().as_secs_f64()))
}

/// Renders what the others are measured against: a finer image, of which each pixel is the mean of four. Samples are
/// elsewhere in finer pixels: those of the sweep are not among them.
fn reference(
    renderer: &Renderer<'_>,
    scene: &Scene,
    camera: &Camera,
    plan: &Plan,
) -> Result<Reference, Failure> {
    // The first one fills tables and caches.
    timed(renderer, camera, &Setting::Samples(1).options())?;
    let (_, _, seconds) = timed(renderer, camera, &Setting::Samples(TRIAL).options())?;
    // Both halves and the whole.
    let of_a_sample = 1.5 * seconds / f64::from(TRIAL);
    let samples = affordable(plan.reference, plan.reference_seconds / of_a_sample);
    let fine = camera.resolution().map(|side| side * FINER);
    if fine.iter().any(|&side| side > MAX_RESOLUTION) {
        let most = MAX_RESOLUTION / FINER;
        return Err(
            format!("an image of more than {most} pixels along a side has no reference").into(),
        );
    }
    let fine = renderer.world().place(&scene.camera.value, fine)?;
    // Of all samples those of the first half are the render with half as many: H₁ − R = (H₁ − H₂)/2.
    let half = means(renderer, &fine, samples / 2)?;
    let start = Instant::now();
    let film = means(renderer, &fine, samples)?;
    let seconds = start.elapsed().as_secs_f64();
    let truth = Truth::new(&film)?;
    let error = truth.rmse(&planes(half.pixels())?)?;
    let row = ReferenceRow {
        transport: transport(renderer),
        samples,
        seconds,
        rmse_cd_m2: error,
        rmse_percent: truth.percent(error),
        mean_cd_m2: truth.mean,
        median_cd_m2: truth.median,
        relmse_epsilon: 1e-2 * truth.median * truth.median,
        exposure_ev: truth.ev,
    };
    Ok(Reference { row, truth, film })
}

/// The film of a camera whose pixels are [`FINER`] times smaller, brought to so many samples of each pixel of the image;
/// some rows at a time.
fn means(renderer: &Renderer<'_>, fine: &Camera, samples: u32) -> Result<Film, Failure> {
    const ROWS: u32 = 64 * FINER;
    let [width, height] = fine.resolution();
    let resolution = [width / FINER, height / FINER];
    let mut pixels: Vec<[f32; 4]> = Vec::new();
    pixels.try_reserve_exact(resolution[0] as usize * resolution[1] as usize)?;
    let mut metadata = None;
    for y in (0..height).step_by(ROWS as usize) {
        let window = Window {
            x: 0,
            y,
            width,
            height: ROWS.min(height - y),
        };
        let options = Options {
            window: Some(window),
            ..Setting::Samples(samples / (FINER * FINER)).options()
        };
        let (film, _, _) = timed(renderer, fine, &options)?;
        let rows = film.pixels().chunks_exact((width * FINER) as usize);
        for rows in rows {
            let (upper, lower) = rows.split_at(width as usize);
            let blocks = upper
                .as_chunks::<2>()
                .0
                .iter()
                .zip(lower.as_chunks::<2>().0);
            pixels.extend(
                blocks.map(|(upper, lower)| mean([upper[0], upper[1], lower[0], lower[1]])),
            );
        }
        metadata = Some(film.metadata().clone());
    }
    let metadata = metadata.ok_or("the image has no rows")?;
    Ok(Film::new(
        resolution,
        Window::whole(resolution),
        pixels,
        metadata,
    ))
}

/// The mean of four pixels.
fn mean(pixels: [[f32; 4]; 4]) -> [f32; 4] {
    std::array::from_fn(|channel| {
        let sum: f64 = pixels.iter().map(|pixel| f64::from(pixel[channel])).sum();
        (sum / 4.0) as f32
    })
}

/// The largest power of two up to `most` that is not above `limit`; at least 16, so that no half is the centers of finer
/// pixels alone.
fn affordable(most: u32, limit: f64) -> u32 {
    let powers = (4..u32::BITS).map(|power| 1 << power);
    let affordable = powers.take_while(|&samples| samples <= most && f64::from(samples) <= limit);
    affordable.last().unwrap_or(16)
}

fn row(
    renderer: &Renderer<'_>,
    camera: &Camera,
    plan: &Plan,
    setting: Setting,
    reference: &Reference,
) -> Result<Row, Failure> {
    let options = setting.options();
    let mut seconds = Vec::new();
    let (film, counts) = loop {
        let (film, counts, taken) = timed(renderer, camera, &options)?;
        seconds.push(taken);
        let is_enough = seconds.len() >= plan.runs as usize;
        if is_enough || seconds.iter().sum::<f64>() > PATIENCE {
            break (film, counts);
        }
    };
    let planes = planes(film.pixels())?;
    let errors = reference.truth.errors(&planes)?;
    let pixels = film.pixels().len() as f64;
    let of_target = setting.target().map(|target| Aim {
        target: Some(target),
        within_target: Some(reference.truth.within(&planes, target, counts.errors.floor)),
        proven: Some(counts.errors.bound() as f64 / pixels),
        unmet: Some(counts.errors.unmet),
    });
    Ok(Row {
        series: setting.series(),
        transport: reference.row.transport.to_owned(),
        setting: setting.name(),
        label: setting.label(),
        samples_per_pixel: Some(counts.primary_rays as f64 / pixels),
        seconds: median(&mut seconds),
        runs: seconds.len() as u32,
        rays: Some(counts.primary_rays + counts.shadow_rays),
        aim: of_target.unwrap_or_default(),
        is_near_reference: is_near(errors.rmse, reference),
        errors,
        picture: pictures::png(&reference.truth.error_picture(&planes)?)?,
    })
}

/// A picture of how many samples each pixel takes.
fn samples_of(
    renderer: &Renderer<'_>,
    camera: &Camera,
    setting: Setting,
) -> Result<(String, Vec<u8>), Failure> {
    let (film, _, _) = timed(renderer, camera, &setting.with_samples())?;
    let samples = (0..film.pixels().len()).map(|pixel| film.values(pixel)[0]);
    let samples: Vec<f32> = samples.collect();
    let most = samples.iter().copied().fold(0.0, f32::max);
    let picture = pictures::png(&pictures::counts(&film, &samples))?;
    Ok((format!("{}: at most {most}", setting.name()), picture))
}

/// Whether an error is so small that the reference's own counts.
pub(super) fn is_near(rmse: f64, reference: &Reference) -> bool {
    rmse < ABOVE_REFERENCE * reference.row.rmse_cd_m2
}

/// The middle one, or the mean of both.
pub(super) fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len().is_multiple_of(2) {
        f64::midpoint(values[middle - 1], values[middle])
    } else {
        values[middle]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_are_powers_of_two_within_limits() {
        assert_eq!(affordable(4096, 1e9), 4096);
        assert_eq!(affordable(5000, 1e9), 4096);
        assert_eq!(affordable(4096, 300.0), 256);
        assert_eq!(affordable(4096, 0.1), 16);
        assert_eq!(affordable(1, 1e9), 16);
        assert_eq!(affordable(65_536, f64::INFINITY), 65_536);
    }

    #[test]
    fn medians() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [4.0, 1.0, 2.0, 3.0]), 2.5);
        assert_eq!(median(&mut [7.0]), 7.0);
    }
}
