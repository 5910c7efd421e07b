//! `--stats`: counts and times as JSON.

use candela::image::Window;
use candela::render::{RenderedExr, Renderer, Work};
use candela::world::Plan;
use serde::Serialize;

use super::request::Request;
use super::stage::Stage;

/// What is written.
#[derive(Serialize)]
pub(super) struct Statistics<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    frame: Option<f64>,
    scene_sha256: &'a str,
    inputs_sha256: &'a str,
    image: [u32; 2],
    window: [u32; 4],
    /// Of each pixel; where it is rendered to an error, the most.
    samples: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    accuracy: Option<Accuracy>,
    /// What is made beside R, G, B, A.
    layers: Vec<&'static str>,
    threads: usize,
    primary_rays: u64,
    /// Camera rays that hit an object.
    hits: u64,
    /// Rays that have left mirrors and glass, and of these those that were not followed.
    secondary_rays: u64,
    cut_rays: u64,
    /// A bound of what these would have added to any pixel, in cd/m².
    depth_rest: f64,
    shadow_rays: u64,
    /// Points that a light reaches, of the shadow rays.
    lit: u64,
    /// Times that a light was on the very point to shade, d = 0, and added nothing.
    singular_lights: u64,
    /// Channels whose radiance does not fit their type: f32, and HALF with `--half`.
    clamped: u64,
    clamped_to_half: u64,
    work: Work,
    seconds: &'a Seconds,
    plan: &'a Plan,
}

/// Those of a still, or of several frames as a list, with the seconds of all.
pub(super) fn json(
    mut frames: Vec<serde_json::Value>,
    seconds: &Seconds,
    is_still: bool,
) -> serde_json::Result<String> {
    let seconds = serde_json::to_value(seconds)?;
    if is_still && let Some(mut still) = frames.pop() {
        still["seconds"] = seconds;
        return serde_json::to_string_pretty(&still);
    }
    serde_json::to_string_pretty(&serde_json::json!({
        "seconds": seconds,
        "frames": frames,
    }))
}

/// What was asked of the pixels' errors, and what came of it. Errors are relative.
#[derive(Serialize)]
struct Accuracy {
    max_error: f64,
    /// In cd/m².
    floor: f64,
    max_samples: u32,
    /// Smooth pixels and those whose edges are integrated.
    bound_pixels: u64,
    smooth_pixels: u64,
    edge_pixels: u64,
    estimated_pixels: u64,
    /// Of the estimated ones.
    unmet_pixels: u64,
    worst_bound: f64,
    worst_estimate: f64,
}

/// How long each step took.
#[derive(Default, Serialize)]
pub(super) struct Seconds {
    pub(super) load: f64,
    pub(super) build: f64,
    pub(super) render: f64,
    pub(super) write: f64,
    pub(super) total: f64,
}

impl<'a> Statistics<'a> {
    pub(super) fn new(
        renderer: &'a Renderer<'_>,
        stage: &Stage,
        request: &Request,
        rendered: &RenderedExr,
        seconds: &'a Seconds,
    ) -> Self {
        let (world, counts) = (renderer.world(), rendered.counts);
        let Window {
            x,
            y,
            width,
            height,
        } = request.window;
        Self {
            frame: request.options.frame,
            scene_sha256: world.scene_hash(),
            inputs_sha256: world.inputs_hash(),
            image: stage.camera.resolution(),
            window: [x, y, x + width, y + height],
            samples: match request.options.target {
                Some(target) => target.max_samples,
                None => request.options.samples,
            },
            accuracy: request.options.target.map(|target| {
                let errors = counts.errors;
                Accuracy {
                    max_error: target.relative,
                    floor: errors.floor,
                    max_samples: target.max_samples,
                    bound_pixels: errors.bound(),
                    smooth_pixels: errors.smooth,
                    edge_pixels: errors.edges,
                    estimated_pixels: errors.estimated,
                    unmet_pixels: errors.unmet,
                    worst_bound: errors.worst_bound,
                    worst_estimate: errors.worst_estimate,
                }
            }),
            layers: request.options.layers.names(),
            threads: rayon::current_num_threads(),
            primary_rays: counts.primary_rays,
            hits: counts.hits,
            secondary_rays: counts.secondary_rays,
            cut_rays: counts.cut_rays,
            depth_rest: counts.depth_rest,
            shadow_rays: counts.shadow_rays,
            lit: counts.lit,
            singular_lights: counts.singular,
            clamped: counts.clamped,
            clamped_to_half: rendered.report.clamped_to_half,
            work: counts.work,
            seconds,
            plan: renderer.plan(),
        }
    }
}
