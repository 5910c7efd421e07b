//! How to render.

use super::accuracy::{ErrorTarget, MAX_SAMPLES, MIN_RELATIVE_ERROR};
use super::layers::{Layers, Relight, coloring};
use crate::camera::Camera;
use crate::image::Window;
use crate::simd::SimdLevel;
use crate::world::World;

/// How to render.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Samples of each pixel. 1 samples pixel centers and nothing else; more are a fixed pattern
    /// that differs from pixel to pixel. Range: 1 to [`MAX_SAMPLES`]. Default 1.
    pub samples: u32,
    /// How exact each pixel is to be; `samples` says nothing then. Default `None`.
    pub target: Option<ErrorTarget>,
    /// Whether a light with an area is cut by all shapes in its way, however many; else where more than 24 are in its
    /// way, as many of its points as its `samples` say are asked. With a `target` it is cut by up to 4096 shapes in any
    /// case. Default: no.
    pub cuts_areas: bool,
    /// The part of the image to render; `None` is all of it.
    pub window: Option<Window>,
    /// What is made beside R, G, B and A. Default: nothing.
    pub layers: Layers,
    /// The instructions to render with, which make no difference to the image. Default: the widest
    /// that the machine has.
    pub simd: SimdLevel,
    /// The frame of a sequence, which the header then names. Default `None`.
    pub frame: Option<f64>,
    /// Whether [`Counts::work`](super::Counts::work) is counted, which takes a little time, and a bit of memory for each
    /// leaf seen from the eye and from each light, 64 MB at most. Default: no.
    pub counts_work: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            samples: 1,
            target: None,
            cuts_areas: false,
            window: None,
            layers: Layers::default(),
            simd: SimdLevel::default(),
            frame: None,
            counts_work: false,
        }
    }
}

/// Options that a world cannot be rendered with, or a camera.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OptionsError {
    /// [`Options::samples`] is out of range.
    #[error("{0} samples of a pixel are out of range; choose 1 to {MAX_SAMPLES}")]
    Samples(u32),
    /// [`Options::target`] is out of range.
    #[error(
        "a target of {} with a floor of {:?} cd/m² and at most {} samples is out of range; choose a target from \
         {MIN_RELATIVE_ERROR} to 1, a floor above 0 and 1 to {MAX_SAMPLES} samples",
        .0.relative, .0.floor, .0.max_samples
    )]
    Target(ErrorTarget),
    /// [`Layers::error`] is asked for without [`Options::target`].
    #[error("the layer `error` is known only where pixels are rendered to an error; set a target")]
    NoTarget,
    /// [`Options::window`] is not inside the image, or has no pixels.
    #[error(
        "the window of {} × {} pixels at ({}, {}) is not inside the image of {} × {}; choose a part of it",
        window.width, window.height, window.x, window.y, resolution[0], resolution[1]
    )]
    Window {
        /// What was asked for.
        window: Window,
        /// Width and height of the whole image.
        resolution: [u32; 2],
    },
    /// [`Options::layers`] has [`Layers::spectral`], but the world carries light as RGB.
    #[error(
        "there are no bands where light is carried as RGB; leave the layer `spectral` out, or \
         set the image's `transport` to \"spectral\""
    )]
    Bands,
    /// [`Options::layers`] has [`Relight::Always`], but light is carried spectrally, and a material colors what is seen by
    /// way of it: that is no sum over the reflectances of surfaces.
    #[error(
        "the layer `relight` cannot be made: the material `{material}` gives what is seen by way of it another color; leave \
         `relight` out, make that material gray or a mirror without `schlick` (where mirrors have many colors, with a lower \
         `max_depth`), or set the image's `transport` to \"rgb\", where it is not needed"
    )]
    ColoredWays {
        /// The material, by its name.
        material: String,
    },
    /// The camera is [placed](World::place) in a world with another anchor.
    #[error(
        "the camera is of another world, whose positions have another anchor; place it in this one"
    )]
    Camera,
}

impl Options {
    /// What of the camera's image is rendered.
    ///
    /// # Errors
    /// If the world cannot be rendered with these options, or through this camera.
    pub fn check(&self, world: &World, camera: &Camera) -> Result<Window, OptionsError> {
        if !(1..=MAX_SAMPLES).contains(&self.samples) {
            return Err(OptionsError::Samples(self.samples));
        }
        if let Some(target) = self.target.filter(|target| !target.is_valid()) {
            return Err(OptionsError::Target(target));
        }
        if self.layers.error && self.target.is_none() {
            return Err(OptionsError::NoTarget);
        }
        if self.layers.spectral.is_some() && world.spectra().is_none() {
            return Err(OptionsError::Bands);
        }
        if self.layers.relight == Relight::Always
            && world.spectra().is_some()
            && let Some(material) = coloring(world)
        {
            let material = material.to_owned();
            return Err(OptionsError::ColoredWays { material });
        }
        if camera.anchor() != world.anchor() {
            return Err(OptionsError::Camera);
        }
        let resolution @ [width, height] = camera.resolution();
        let window = self.window.unwrap_or(Window::whole(resolution));
        let ends_in = |first: u32, count: u32, end| {
            count > 0 && first.checked_add(count).is_some_and(|last| last <= end)
        };
        if ends_in(window.x, window.width, width) && ends_in(window.y, window.height, height) {
            Ok(window)
        } else {
            Err(OptionsError::Window { window, resolution })
        }
    }
}
