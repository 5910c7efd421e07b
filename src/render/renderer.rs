//! What renders a world, as often as it is asked to.

use std::io::{self, Seek, Write};

use super::counts::Counts;
use super::exr_sink::ExrSink;
use super::film_sink::FilmSink;
use super::job::Job;
use super::layer_sums::RequestedLayers;
use super::options::{Options, OptionsError};
use super::sampling::Sampler;
use super::scheduler::render_tiles;
use super::sink::Sink;
use super::tile::{Kept, Setup};
use crate::exr::{ExrFile, ExrImage, ExrOptions, ExrReport, Preserve};
use crate::image::{Film, ImageSpec, Metadata, Window};
use crate::memory::OutOfMemory;
use crate::visibility::Visibility;
use crate::world::{Bands, Plan, World};

/// Renders a world: plans, builds what the plan needs, and renders with the threads of the
/// current rayon pool. The same world and options give the same bits on any number of threads.
///
/// # Errors
/// If the world cannot be rendered with these options, or there is not enough memory.
pub fn render(world: &World, options: &Options) -> Result<Film, RenderError> {
    let renderer = Renderer::new(world)?;
    let (film, _) = renderer.film(options, &Job::new())?;
    Ok(film)
}

/// A world with all that is built to render it.
#[derive(Debug)]
pub struct Renderer<'w> {
    world: &'w World,
    plan: Plan,
    visibility: Visibility<'w>,
}

/// Why a render came to no end.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The world cannot be rendered with these options.
    #[error("{0}")]
    Options(#[from] OptionsError),
    /// The system does not give the memory.
    #[error("{0}")]
    Memory(#[from] OutOfMemory),
    /// The file cannot be written.
    #[error("{0}")]
    Write(#[from] io::Error),
    /// [`Job::cancel`] was called.
    #[error("rendering was canceled")]
    Canceled,
}

impl From<RenderError> for io::Error {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Write(error) => error,
            RenderError::Options(error) => Self::new(io::ErrorKind::InvalidInput, error),
            RenderError::Memory(error) => Self::new(io::ErrorKind::OutOfMemory, error),
            RenderError::Canceled => Self::other(error),
        }
    }
}

/// A file that was rendered.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct RenderedExr {
    /// What rendering took and met.
    pub counts: Counts,
    /// What was written.
    pub report: ExrReport,
    /// What the file shows, as if it were read back, where [`Preserve::Image`] asks for it.
    pub image: Option<ExrImage>,
}

impl<'w> Renderer<'w> {
    /// Plans, and builds what the plan needs.
    ///
    /// # Errors
    /// If there is not enough memory.
    pub fn new(world: &'w World) -> Result<Self, OutOfMemory> {
        let plan = Plan::new(world);
        let visibility = Visibility::try_new(world, &plan)?;
        Ok(Self {
            world,
            plan,
            visibility,
        })
    }

    /// What it renders.
    pub fn world(&self) -> &'w World {
        self.world
    }

    /// What it computes: just what the world needs.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Renders a film, and tells what that took.
    ///
    /// # Errors
    /// If the options are not for this world, or the job is canceled.
    pub fn film(&self, options: &Options, job: &Job<'_>) -> Result<(Film, Counts), RenderError> {
        let spec = self.spec(options)?;
        let mut film = Film::black(spec);
        let counts = self.tiles(options, job, &FilmSink::new(&mut film))?;
        Ok((film, counts))
    }

    /// Renders and writes OpenEXR into `sink`, from the sink's start: blocks are compressed and written
    /// while others are still being rendered, and the film is never there as a whole. The bytes are
    /// those that [`Renderer::film`] and [`Film::write_exr_to`] make one after the other.
    ///
    /// # Errors
    /// As [`Renderer::film`] and [`Film::write_exr_to`]; rendering ends with the first.
    pub fn exr(
        &self,
        options: &Options,
        exr: &ExrOptions,
        preserve: Preserve,
        job: &Job<'_>,
        sink: &mut (impl Write + Seek + Send),
    ) -> Result<RenderedExr, RenderError> {
        let spec = self.spec(options)?;
        let file = ExrFile::begin(&spec, exr, preserve, sink)?;
        let counts = {
            let strips = ExrSink::new(spec.window, &spec.channels, &file);
            self.tiles(options, job, &strips)?
        };
        let (report, image) = file.finish()?;
        Ok(RenderedExr {
            counts,
            report,
            image,
        })
    }

    /// Renders, and hands each tile to `sink`.
    ///
    /// # Errors
    /// If the options are not for this world, or the job is canceled.
    pub fn tiles(
        &self,
        options: &Options,
        job: &Job<'_>,
        sink: &dyn Sink,
    ) -> Result<Counts, RenderError> {
        let counts = self.set_up(options, Kept::Sums, |setup, window| {
            let channels = options.layers.channels(self.world).list.len();
            render_tiles(setup, window, channels, job, sink)
        })?;
        if job.is_canceled() {
            return Err(RenderError::Canceled);
        }
        Ok(counts)
    }

    /// Makes what all tiles have in common, and works with it on a window.
    pub(super) fn set_up<T>(
        &self,
        options: &Options,
        sums: Kept,
        work: impl FnOnce(&Setup<'_>, Window) -> T,
    ) -> Result<T, OptionsError> {
        let window = options.check(self.world)?;
        let spectra = self.world.spectra().zip(options.layers.spectral);
        let bands = spectra.map(|(spectra, wavelengths)| Bands::new(spectra, wavelengths));
        let sampler = Sampler::new(options.samples);
        let setup = Setup {
            world: self.world,
            visibility: &self.visibility,
            simd: options.simd,
            sampler: &sampler,
            layers: RequestedLayers::new(self.world, options.layers, bands.as_ref()),
            sums,
        };
        Ok(work(&setup, window))
    }

    /// All of an image that is known before its first pixel.
    fn spec(&self, options: &Options) -> Result<ImageSpec, OptionsError> {
        Ok(ImageSpec {
            resolution: self.world.resolution(),
            window: options.check(self.world)?,
            channels: options.layers.channels(self.world),
            metadata: self.metadata(options),
        })
    }

    fn metadata(&self, options: &Options) -> Metadata {
        let world = self.world;
        let plan = serde_json::to_string(&self.plan).expect("a plan is plain data");
        let layers = options.layers.names();
        let layers = (!layers.is_empty()).then(|| ("layers".to_owned(), layers.join(",")));
        let inputs = ("inputs_sha256".to_owned(), world.inputs_hash().to_owned());
        let others = [
            ("plan".to_owned(), plan),
            ("samples".to_owned(), options.samples.to_string()),
            ("scene_sha256".to_owned(), world.scene_hash().to_owned()),
        ];
        Metadata {
            color_space: world.color_space(),
            world_to_camera: world.camera().world_to_camera(world.anchor()),
            world_to_ndc: world.camera().world_to_ndc(world.anchor()),
            provenance: std::iter::once(inputs)
                .chain(layers)
                .chain(others)
                .collect(),
        }
    }
}
