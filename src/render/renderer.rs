//! What renders a world, as often as it is asked to.

use std::io::{self, Seek, Write};
use std::path::Path;

use super::accuracy::{ErrorCounts, Goal};
use super::batch::Selection;
use super::counts::Counts;
use super::exr_sink::ExrSink;
use super::film_sink::FilmSink;
use super::job::Job;
use super::layer_sums::RequestedLayers;
use super::layers::{is_about_bands, is_band};
use super::options::{Options, OptionsError};
use super::sampling::Sampler;
use super::scheduler::{render_tiles, windows};
use super::sink::{ErrorChannels, Sink};
use super::tile::{Kept, Setup, Space, Tile};
use crate::camera::Camera;
use crate::exr::{ExrFile, ExrImage, ExrOptions, ExrReport, Preserve, is_whole};
use crate::image::{Film, ImageSpec, Metadata, Number, Window};
use crate::memory::{OutOfMemory, look_for};
use crate::visibility::{Parts, Visibility};
use crate::world::{Bands, Plan, World};

/// What part of the error that is asked for may be of branches that are not followed: little beside what samples
/// are off by.
const LEFT_OUT_OF_ERROR: f64 = 1.0 / 64.0;

/// The columns and rows of points that say what errors are relative to.
const FLOOR_PARTS: u32 = 64;

/// Renders a world as a camera sees it: plans, builds what the plan needs, and renders with the threads
/// of the current rayon pool. The same world, camera and options give the same bits on any number of
/// threads. Where more than one picture is made of a world, a [`Renderer`] builds once.
///
/// # Errors
/// If the world cannot be rendered with these options or through this camera, or there is not enough
/// memory.
pub fn render(world: &World, camera: &Camera, options: &Options) -> Result<Film, RenderError> {
    let renderer = Renderer::new(world)?;
    let (film, _) = renderer.film(camera, options, &Job::new())?;
    Ok(film)
}

/// A world with all that is built to render it: once, for any number of cameras.
///
/// ```
/// use candela::render::Job;
/// use candela::scene::Camera;
/// use candela::{Options, Renderer, Scene, World};
///
/// let (world, camera) = World::new(&Scene::builtin())?;
/// let renderer = Renderer::new(&world)?;
/// let (film, _) = renderer.film(&camera, &Options::default(), &Job::new())?;
/// // A camera that moves builds nothing.
/// for step in 0..3 {
///     let eye = [0.1 * f64::from(step), 1.0, 4.0];
///     let moved = Camera::perspective(eye, [0.0, 0.5, 0.0], 40.0);
///     let moved = world.place(&moved, [64, 36])?;
///     renderer.film(&moved, &Options::default(), &Job::new())?;
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Renderer<'w> {
    world: &'w World,
    plan: Plan,
    visibility: Visibility<'w>,
}

/// What a [`Renderer`] has built for a world, while it has none.
#[doc(hidden)]
#[derive(Debug)]
pub struct Built {
    plan: Plan,
    parts: Parts,
}

impl Built {
    /// The renderer of the world that it was built for.
    pub fn of(self, world: &World) -> Renderer<'_> {
        Renderer {
            world,
            plan: self.plan,
            visibility: Visibility::of_parts(world, self.parts),
        }
    }
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
    /// The image is black at all points that say what errors are relative to, and elsewhere it is not.
    #[error(
        "the image is too dark to say what errors are relative to: it is black at 64 × 64 points over it, but not \
         everywhere; set the floor"
    )]
    TooDark,
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
            RenderError::Canceled | RenderError::TooDark => Self::other(error),
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

    /// Of another world, such as the next frame, with the trees of the shapes that are where they were: the
    /// same pictures as of [`Renderer::new`], sooner.
    ///
    /// # Errors
    /// If there is not enough memory.
    pub fn again<'v>(&self, world: &'v World) -> Result<Renderer<'v>, OutOfMemory> {
        let plan = Plan::new(world);
        let visibility = self.visibility.again(world, &plan)?;
        Ok(Renderer {
            world,
            plan,
            visibility,
        })
    }

    /// What was built, without its world, which may then move elsewhere.
    #[doc(hidden)]
    pub fn into_built(self) -> Built {
        Built {
            plan: self.plan,
            parts: self.visibility.into_parts(),
        }
    }

    /// How many trees were built for it: of each large mesh one, of all other triangles one, of the spheres one,
    /// where they are many; none of what [`Renderer::again`] keeps.
    pub fn trees_built(&self) -> usize {
        self.visibility.trees_built()
    }

    /// About how many bytes [`Renderer::new`] takes at once, of which it keeps about half.
    pub fn memory_needed(world: &World) -> u64 {
        Visibility::memory_needed(world)
    }

    /// Bytes of what it has built.
    pub fn memory(&self) -> usize {
        self.visibility.memory()
    }

    /// What it renders.
    pub fn world(&self) -> &'w World {
        self.world
    }

    /// What it computes: just what the world needs.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Renders a film of what a camera sees, and tells what that took. Its bits do not depend on what was
    /// rendered before.
    ///
    /// # Errors
    /// If the camera or the options are not for this world, or the job is canceled.
    pub fn film(
        &self,
        camera: &Camera,
        options: &Options,
        job: &Job<'_>,
    ) -> Result<(Film, Counts), RenderError> {
        let spec = self.spec(camera, options)?;
        let mut film = Film::black(spec);
        let counts = self.tiles(camera, options, job, &FilmSink::new(&mut film))?;
        if options.target.is_some() {
            film.add_provenance(counts.errors.provenance());
        }
        if self.world.has_deltas() {
            film.add_provenance(counts.depth_provenance());
        }
        Ok((film, counts))
    }

    /// Renders and writes OpenEXR into `sink`, from the sink's start: blocks are compressed and written
    /// while others are still being rendered, and the film is never there as a whole, unless it is rendered to an
    /// error, or through mirrors and glass, where the header, which comes first, says what came of it, or written with
    /// [`ExrOptions::full_window`]. The bytes are those that [`Renderer::film`] and
    /// [`Film::write_exr_to`] make one after the other.
    ///
    /// # Errors
    /// As [`Renderer::film`] and [`Film::write_exr_to`]; rendering ends with the first.
    pub fn exr(
        &self,
        camera: &Camera,
        options: &Options,
        exr: &ExrOptions,
        preserve: Preserve,
        job: &Job<'_>,
        sink: &mut (impl Write + Seek + Send),
    ) -> Result<RenderedExr, RenderError> {
        let spec = self.spec(camera, options)?;
        let is_whole = options.target.is_some() || exr.full_window || self.world.has_deltas();
        if is_whole {
            let (film, counts) = self.film_of_file(camera, options, exr, job)?;
            let (report, image) = film.write_exr_and_keep(sink, exr, preserve)?;
            return Ok(RenderedExr {
                counts,
                report,
                image,
            });
        }
        let file = ExrFile::begin(&spec, exr, preserve, sink)?;
        let counts = {
            let strips = ExrSink::new(spec.window, &spec.channels, &file);
            self.tiles(camera, options, job, &strips)?
        };
        let (report, image) = file.finish()?;
        Ok(RenderedExr {
            counts,
            report,
            image,
        })
    }

    /// Renders, and writes two OpenEXR files: one of the bands of [`Layers::spectral`](super::Layers::spectral) with R,
    /// G, B and A, one of all else. The films are in memory as a whole. What is told is of the latter.
    ///
    /// # Errors
    /// As [`Renderer::exr`].
    #[expect(clippy::too_many_arguments, reason = "two files are written as one is")]
    pub fn exr_and_bands(
        &self,
        camera: &Camera,
        options: &Options,
        exr: &ExrOptions,
        preserve: Preserve,
        job: &Job<'_>,
        sink: &mut (impl Write + Seek + Send),
        bands: &mut (impl Write + Seek + Send),
    ) -> Result<RenderedExr, RenderError> {
        let (film, counts) = self.film_of_file(camera, options, exr, job)?;
        let [of_bands, film] = film.apart(|channel| is_band(&channel.name), is_about_bands);
        of_bands.write_exr_to(bands, exr)?;
        drop(of_bands);
        let (report, image) = film.write_exr_and_keep(sink, exr, preserve)?;
        Ok(RenderedExr {
            counts,
            report,
            image,
        })
    }

    /// Renders the film of a file that is not written while it is rendered.
    fn film_of_file(
        &self,
        camera: &Camera,
        options: &Options,
        exr: &ExrOptions,
        job: &Job<'_>,
    ) -> Result<(Film, Counts), RenderError> {
        let spec = self.spec(camera, options)?;
        let pixels = if exr.full_window {
            let whole = Window::whole(spec.resolution).count();
            whole.saturating_add(spec.window.count())
        } else {
            spec.window.count()
        };
        let values = 4 + spec.channels.list.len() as u64;
        look_for(pixels.saturating_mul(4 * values)).map_err(|error| error.for_what("the film"))?;
        let (film, counts) = self.film(camera, options, job)?;
        let film = if exr.full_window {
            film.in_full_window()
        } else {
            film
        };
        Ok((film, counts))
    }

    /// Renders, and hands each tile to `sink`.
    ///
    /// # Errors
    /// If the camera or the options are not for this world, or the job is canceled.
    pub fn tiles(
        &self,
        camera: &Camera,
        options: &Options,
        job: &Job<'_>,
        sink: &dyn Sink,
    ) -> Result<Counts, RenderError> {
        let channels = options.layers.channels(self.world).list.len();
        let about_errors = ErrorChannels {
            error: options.layers.error,
            samples: options.layers.samples,
        };
        let mut counts = self.set_up(camera, options, Kept::Sums, |setup, window| {
            let goal = options.target.map(|target| {
                let floor = target.floor.unwrap_or_else(|| self.floor(setup));
                Goal::new(&target, floor, channels == about_errors.count())
            });
            let [left_out, negligible] = goal.as_ref().map_or([0.0; 2], |goal| self.left_out(goal));
            let setup = Setup {
                goal: goal.as_ref(),
                left_out,
                negligible,
                ..*setup
            };
            render_tiles(&setup, window, (channels, about_errors), job, sink)
        })?;
        if job.is_canceled() {
            return Err(RenderError::Canceled);
        }
        // Black is exact; what is not black needs something to be relative to.
        if options.target.is_some() && counts.errors.floor == 0.0 && counts.errors.unmet > 0 {
            return Err(RenderError::TooDark);
        }
        if counts.cut > 0.0 {
            counts.depth_rest = counts.cut * self.world.brightest();
        }
        Ok(counts)
    }

    /// How much radiance in cd/m² may be left out of each sample, and which part that is of the brightest of the world;
    /// nothing where that has no bound.
    fn left_out(&self, goal: &Goal) -> [f64; 2] {
        if !self.world.has_deltas() {
            return [0.0; 2];
        }
        let left_out = LEFT_OUT_OF_ERROR * goal.target.relative * goal.target.floor;
        let part = left_out / self.world.brightest();
        if part > 0.0 && part.is_finite() {
            [left_out, part]
        } else {
            [0.0; 2]
        }
    }

    /// A hundredth of the mean luminance of the image in cd/m², from the centers of 64 × 64 parts.
    fn floor(&self, setup: &Setup<'w>) -> f64 {
        let parts = [FLOOR_PARTS; 2];
        let sampler = Sampler::over(setup.camera.resolution(), parts);
        let setup = Setup {
            sampler: &sampler,
            layers: None,
            ..*setup
        };
        let (mut tile, mut space) = (Box::<Tile<'_>>::default(), Box::<Space>::default());
        let weights = self.world.color_space().primaries().luminance_weights();
        let mut sum = 0.0;
        for window in windows(Window::whole(parts)) {
            tile.begin(&setup, window);
            tile.pass(&setup, 0..1, &Selection::ALL, &mut space);
            for pixel in 0..tile.places().len() {
                let (radiance, _) = tile.sums_of(pixel);
                let channels = radiance.iter().zip(weights);
                sum += channels
                    .map(|(channel, weight)| channel * weight)
                    .sum::<f64>();
            }
        }
        let mean = sum / f64::from(FLOOR_PARTS * FLOOR_PARTS);
        // Below the least normal f32 pixels have no relative precision.
        let floor = mean * 0.01;
        if floor >= f64::from(f32::MIN_POSITIVE) {
            floor
        } else {
            0.0
        }
    }

    /// Makes what all tiles have in common, and works with it on a window.
    pub(super) fn set_up<T>(
        &self,
        camera: &Camera,
        options: &Options,
        sums: Kept,
        work: impl FnOnce(&Setup<'_>, Window) -> T,
    ) -> Result<T, OptionsError> {
        let window = options.check(self.world, camera)?;
        let spectra = self.world.spectra().zip(options.layers.spectral);
        let bands = spectra.map(|(spectra, wavelengths)| Bands::new(spectra, wavelengths));
        let most = options
            .target
            .map_or(options.samples, |target| target.max_samples);
        let sampler = Sampler::new(most);
        let layers = RequestedLayers::new(self.world, camera, &options.layers, bands.as_ref());
        let origins = self.world.lights().iter();
        let origins = origins.map(|light| light.value.origins().len()).sum();
        let met_leaves = options
            .counts_work
            .then(|| self.visibility.met_leaves(origins))
            .flatten();
        let setup = Setup {
            world: self.world,
            camera,
            visibility: &self.visibility,
            counts_work: options.counts_work,
            met_leaves: met_leaves.as_ref(),
            simd: options.simd,
            cuts_areas: options.cuts_areas || options.target.is_some(),
            sampler: &sampler,
            layers: layers.as_ref(),
            sums,
            left_out: 0.0,
            negligible: 0.0,
            goal: None,
        };
        Ok(work(&setup, window))
    }

    /// All of an image that is known before its first pixel.
    fn spec(&self, camera: &Camera, options: &Options) -> Result<ImageSpec, OptionsError> {
        spec(self.world, &self.plan, camera, options)
    }
}

/// Whether the file at `path`, and that of its bands where they have one, are whole, and say of themselves just what
/// would be rendered: the same inputs, options and version. Nothing is built for it.
///
/// # Errors
/// If the camera or the options are not for this world.
#[doc(hidden)]
pub fn is_done(
    world: &World,
    camera: &Camera,
    options: &Options,
    exr: &ExrOptions,
    path: &Path,
    bands: Option<&Path>,
) -> Result<bool, OptionsError> {
    let mut spec = spec(world, &Plan::new(world), camera, options)?;
    if exr.full_window {
        spec.window = Window::whole(spec.resolution);
    }
    // What comes of rendering to an error is known at its end.
    let errors = ErrorCounts::default();
    let is_known = |name: &str| {
        let mut counts = errors.provenance();
        let is_count = |name: &str| counts.any(|(count, _)| count == name);
        options.target.is_none() || !name.strip_prefix("candela:").is_some_and(is_count)
    };
    let done = |spec: &ImageSpec, path: &Path| is_whole(path, spec, exr, &is_known);
    Ok(match bands {
        None => done(&spec, path),
        Some(bands) => {
            let [of_bands, of_all_else] =
                spec.apart(|channel| is_band(&channel.name), is_about_bands);
            done(&of_bands, bands) && done(&of_all_else, path)
        }
    })
}

fn spec(
    world: &World,
    plan: &Plan,
    camera: &Camera,
    options: &Options,
) -> Result<ImageSpec, OptionsError> {
    Ok(ImageSpec {
        resolution: camera.resolution(),
        window: options.check(world, camera)?,
        channels: options.layers.channels(world),
        metadata: metadata(world, plan, camera, options),
    })
}

fn metadata(world: &World, plan: &Plan, camera: &Camera, options: &Options) -> Metadata {
    let plan = serde_json::to_string(plan).expect("a plan is plain data");
    let layers = options.layers.names();
    let layers = (!layers.is_empty()).then(|| ("layers".to_owned(), layers.join(",")));
    let inputs = ("inputs_sha256".to_owned(), world.inputs_hash().to_owned());
    let accuracy = match options.target {
        None => vec![],
        Some(target) => vec![
            ("max_error".to_owned(), target.relative.to_string()),
            ("max_samples".to_owned(), target.max_samples.to_string()),
        ],
    };
    let samples = options.target.is_none().then(|| {
        // At most 65 536.
        let samples = Number::Integer(options.samples as i32);
        ("candela:samples".to_owned(), samples)
    });
    let others = [
        ("camera".to_owned(), camera.description()),
        ("lights".to_owned(), world.describe_lights()),
        ("observer".to_owned(), world.observer().name().to_owned()),
        ("transport".to_owned(), world.transport().to_owned()),
        ("plan".to_owned(), plan),
        ("scene_sha256".to_owned(), world.scene_hash().to_owned()),
    ];
    let frame = options
        .frame
        .map(|frame| ("frame".to_owned(), frame.to_string()));
    let set = (!world.set().is_empty()).then(|| ("set".to_owned(), world.set().join("\n")));
    let mut provenance: Vec<(String, String)> = std::iter::once(inputs)
        .chain(frame)
        .chain(set)
        .chain(layers)
        .chain(others)
        .chain(accuracy)
        .collect();
    provenance.sort();
    Metadata {
        color_space: world.color_space(),
        world_to_camera: camera.world_to_camera(),
        world_to_ndc: camera.world_to_ndc(),
        provenance,
        numbers: lens(camera).into_iter().chain(samples).collect(),
    }
}

/// OpenEXR's attributes for the lens of a perspective camera. It is a pinhole, so that there is no aperture.
fn lens(camera: &Camera) -> Vec<(String, Number)> {
    let Some((focal_length, sensor)) = camera.lens() else {
        return Vec::new();
    };
    let attributes = [
        ("pinholeFocalLength", Number::Float(focal_length as f32)),
        (
            "sensorOverallDimensions",
            Number::Pair(sensor.map(|side| side as f32)),
        ),
    ];
    attributes
        .map(|(name, number)| (name.to_owned(), number))
        .to_vec()
}
