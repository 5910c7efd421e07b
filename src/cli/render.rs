//! `candela render`: a scene file becomes an EXR.

mod accuracy;
mod layers;
mod outputs;
mod progress;
mod request;
mod statistics;
mod summary;
mod values;

use std::io;
use std::path::PathBuf;
use std::time::Instant;

use candela::Camera;
use candela::display::{self, Alpha, Frame};
use candela::exr::{Compression, ExrImage, TileNumber};
use candela::output::{self, Unfinished};
use candela::render::SimdLevel;
use candela::render::{Job, RenderError, Renderer};
use candela::scene::Scene;
use candela::world::{Loaded, World, physics};
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::crop::{Crop, crop};
use super::develop::DevelopArguments;
use super::display_server::DisplayServer;
use super::source::BaseArguments;
use super::{Failure, MAX_THREADS};
use accuracy::AccuracyArguments;
pub(super) use accuracy::max_error;
use layers::LayerArguments;
pub(super) use layers::transports;
use outputs::Outputs;
use progress::Progress;
use request::Request;
use statistics::{Seconds, Statistics};
use summary::Summary;
pub(super) use values::{count, named};

/// Render a scene to a linear OpenEXR image in cd/m²
///
/// Each pixel is the sum over all lights of I/d² times the reflectance times the visibility, in
/// linear RGB. 1.0 in the file is 1 cd/m². The image is the same to the bit for any number of
/// threads.
#[derive(Debug, clap::Args)]
#[command(mut_arg("exposure", |option| option.requires("preview")))]
#[command(mut_arg("auto_exposure", |option| option.requires("preview")))]
#[command(mut_arg("view", |option| option.requires("preview")))]
#[command(mut_arg("dither", |option| option.requires("preview")))]
#[command(mut_arg("iso", |option| option.requires("preview")))]
#[command(mut_arg("white_balance", |option| option.requires("preview")))]
#[command(mut_arg("display", |option| option.requires("preview")))]
#[command(mut_arg("white_nits", |option| option.requires("preview")))]
#[command(mut_arg("gamut", |option| option.requires("preview")))]
#[command(after_long_help = "\
Examples:
  candela render
      Render the built-in scene to lecture.exr
  candela render scene.toml --preview scene.png
      Also make a PNG, as `candela tonemap` would
  candela render scene.toml --preview scene.png --auto-exposure
      And choose its exposure, as long as the light of the scene is still a guess
  candela render scene.toml -o scene.exr --samples 256
      256 samples a pixel, for edges that bear a magnifying glass
  candela render scene.toml --max-error 0.5%
      Each pixel right to half a percent, with as few samples as that takes
  candela render scene.toml --samples 1
      Pixel centers and nothing else: a quick look, and values to compare
  candela render scene.toml --crop 600,300,700,400 --samples 256
      Only a part, at its place in the whole image
  candela render scene.toml --tile 3/16
      The fourth of 16 tiles, scene.tile0003.exr; `candela merge` makes one image of all
  candela render scene.toml --half --compression dwaa
      A small file
  candela render scene.toml --layers lights,depth,normal
      Also each light by itself, the distance and the normal, for compositing
  candela render scene.toml --layers spectral --wavelengths 400:700:10
      A spectral image: R, G, B, A and 31 bands
  candela render scene.toml --layers lights=key,fill,shadow,cryptomatte
      The shares of two lights, where they reach, and mattes of objects and materials")]
pub(crate) struct Arguments {
    /// The scene file; `-` is standard input [default: the built-in lecture scene]
    #[arg(value_name = "SCENE.toml")]
    scene: Option<PathBuf>,

    #[command(flatten)]
    base: BaseArguments,

    /// The EXR file, or - for standard output [default: SCENE.exr in the current folder]
    #[arg(short, long, value_name = "OUT.exr", value_parser = named("exr"))]
    output: Option<PathBuf>,

    #[command(flatten)]
    accuracy: AccuracyArguments,

    /// Also make a PNG of what is rendered, as `candela tonemap` would; - is standard output
    #[arg(long, value_name = "OUT.png", value_parser = named("png"))]
    preview: Option<PathBuf>,

    #[command(flatten)]
    development: DevelopArguments,

    #[command(flatten)]
    layers: LayerArguments,

    /// Write 16-bit HALF channels; values beyond 65504 become that and are counted
    #[arg(long)]
    half: bool,

    /// Render only columns X0 to X1 and rows Y0 to Y1, X1 and Y1 not included; (0, 0) is the top
    /// left. The EXR keeps the place in the whole image, the preview shows the part alone
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = crop, allow_hyphen_values = true)]
    crop: Option<Crop>,

    /// Render only tile I of N, for `candela merge`; I is from 0 to N - 1
    ///
    /// Tiles are whole rows of the image, or of the part of --crop, cut at multiples of 16 rows, or of the rows that
    /// --compression takes together where these are more. There are at most as many tiles as such strips. All tiles of
    /// one image are rendered with the same options.
    #[arg(
        long,
        value_name = "I/N",
        conflicts_with = "full_window",
        allow_hyphen_values = true
    )]
    #[arg(value_parser = |text: &str| text.parse::<TileNumber>())]
    tile: Option<TileNumber>,

    /// Threads to render with, 1 to 1024 [default: one for each logical processor]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    #[arg(value_parser = |text: &str| count(text, MAX_THREADS))]
    threads: Option<u32>,

    /// Instructions to render with; the image is the same to the bit with all [default: the widest
    /// of this machine]
    #[arg(long, value_name = "NAME")]
    #[arg(value_parser = PossibleValuesParser::new(SimdLevel::available().into_iter().map(|(name, _)| name))
        .try_map(|name| name.parse::<SimdLevel>()))]
    simd: Option<SimdLevel>,

    /// Write counts and times as JSON
    #[arg(long, value_name = "FILE.json", value_parser = named("json"))]
    stats: Option<PathBuf>,

    /// Compression of the EXR; dwaa, dwab and, for 32-bit values, pxr24 lose precision
    #[arg(long, value_name = "NAME", default_value = Compression::default().name())]
    #[arg(value_parser = PossibleValuesParser::new(Compression::ALL.map(Compression::name))
        .try_map(|name| name.parse::<Compression>()))]
    compression: Compression,

    /// Also write the `chromaticities` attribute in Rec.709, where software that does not know `colorInteropID` takes it
    /// for granted; in other spaces it is written in any case
    #[arg(long)]
    chromaticities: bool,

    /// Write the part of --crop into a data window of the whole image, black around it, for software that loses the
    /// place of a part (Blender, GIMP, OpenCV, three.js)
    #[arg(long, requires = "crop")]
    full_window: bool,

    /// Also show the picture in tev while it is rendered, which listens at HOST:PORT, such as 127.0.0.1:14158
    #[arg(long, value_name = "HOST:PORT")]
    display_server: Option<String>,

    /// No progress bar, no summary and no warnings
    #[arg(short, long)]
    quiet: bool,
}

impl Arguments {
    /// What is wrong with the options as they stand together.
    pub(crate) fn misuse(&self) -> Option<String> {
        self.layers.misuse(self.accuracy.target().is_some())
    }
}

/// Nothing says what errors are relative to.
const TOO_DARK: &str = "the image is too dark to say what errors are relative to: it is black at 64 × 64 points over \
    it, but not everywhere; set the radiance below which errors do not matter with --error-floor, in cd/m²";

pub(crate) fn run(arguments: &Arguments, unfinished: &Unfinished) -> Result<(), Failure> {
    super::with_threads(arguments.threads, || render(arguments, unfinished))
}

fn render(arguments: &Arguments, unfinished: &Unfinished) -> Result<(), Failure> {
    let start = Instant::now();
    let mut seconds = Seconds::default();
    let outputs = Outputs::new(arguments);

    let (inputs, world, camera) = load(arguments)?;
    let request = Request::new(arguments, &world, &camera)?;
    // Found out now rather than after an hour of rendering.
    outputs.check(&inputs)?;
    request.check(&world)?;
    seconds.load = start.elapsed().as_secs_f64();

    let (renderer, build) = timed(|| Renderer::new(&world));
    let renderer = renderer?;
    seconds.build = build;

    let progress = Progress::new(request.window, !arguments.quiet);
    let server = match &arguments.display_server {
        Some(address) => Some(request.show(&world, &camera, address, &outputs.exr)?),
        None => None,
    };
    let job = Job::watched(|pixels| progress.advance(pixels));
    let job = match &server {
        Some(server) => job.shown_to(server),
        None => job,
    };
    let mut is_too_dark = false;
    let mut of_bands = None;
    let written = output::write(&outputs.exr, unfinished, |mut sink| {
        let Request {
            options,
            exr,
            preserve,
            ..
        } = &request;
        let rendered = match &outputs.bands {
            None => renderer.exr(&camera, options, exr, *preserve, &job, &mut sink),
            Some(path) => {
                let mut rendered = None;
                let written = output::write(path, unfinished, |mut bands| {
                    let both = renderer.exr_and_bands(
                        &camera, options, exr, *preserve, &job, &mut sink, &mut bands,
                    );
                    rendered = Some(both);
                    Ok(())
                });
                match (written, rendered) {
                    (Ok(()), Some(rendered)) => rendered,
                    (Err(error), _) => {
                        of_bands = Some(error);
                        return Err(io::Error::other("stopped"));
                    }
                    (Ok(()), None) => unreachable!("what is written was rendered"),
                }
            }
        };
        is_too_dark = matches!(rendered, Err(RenderError::TooDark));
        Ok(rendered?)
    });
    seconds.render = progress.finish();
    if let Some(error) = of_bands {
        return Err(error.into());
    }
    if is_too_dark {
        return Err(TOO_DARK.into());
    }
    let rendered = written?;
    drop(job);
    let unseen = server.and_then(DisplayServer::warning);
    let developed = develop(arguments, &world, rendered.image.as_ref(), unfinished)?;
    seconds.total = start.elapsed().as_secs_f64();
    seconds.write = seconds.total - seconds.render - seconds.build - seconds.load;

    if let Some(path) = &outputs.statistics {
        let statistics = Statistics::new(&renderer, &camera, &request, &rendered, &seconds);
        let json = serde_json::to_string_pretty(&statistics)?;
        output::write(path, unfinished, |sink| writeln!(sink, "{json}"))?;
    }
    if !arguments.quiet {
        let summary = Summary {
            arguments,
            output: &outputs.exr,
            resolution: camera.resolution(),
            window: request.window,
            has_lights: !world.lights().is_empty(),
            warnings: physics::warnings(&world),
            counts: rendered.counts,
            exr: rendered.report,
            developed,
            unseen,
            seconds: seconds.render,
        };
        // Nowhere is left to report that the messages themselves cannot be written.
        let _ = summary.write(&mut io::stderr().lock());
    }
    Ok(())
}

/// The world with its camera, and the files that it was read from.
fn load(arguments: &Arguments) -> Result<(Vec<PathBuf>, World, Camera), Failure> {
    let change = |scene: &mut Scene| arguments.layers.apply(scene);
    let Loaded {
        scene,
        world,
        camera,
    } = match &arguments.scene {
        Some(path) => arguments.base.load(path, change)?,
        None => {
            let mut scene = Scene::builtin();
            change(&mut scene);
            let (world, camera) = World::new(&scene)?;
            Loaded {
                scene,
                world,
                camera,
            }
        }
    };
    Ok((scene.files(), world, camera))
}

/// Makes the preview of what was rendered, where one is asked for.
fn develop(
    arguments: &Arguments,
    world: &World,
    image: Option<&ExrImage>,
    unfinished: &Unfinished,
) -> Result<Option<display::Report>, Failure> {
    let (Some(preview), Some(image)) = (&arguments.preview, image) else {
        return Ok(None);
    };
    // A PNG with alpha cannot hold light where nothing covers a pixel.
    let has_background = world.background().0.0 != [0.0; 3];
    let resolution = image
        .window
        .map_or(image.resolution, |part| [part.width, part.height]);
    let look = arguments.development.look(resolution)?;
    let settings = display::Settings {
        // Where there is none, what light is there is of the compression.
        alpha: if has_background {
            Alpha::Opaque
        } else {
            Alpha::Keep
        },
        // Of a part, the part; of the whole that is the whole.
        frame: Frame::Data,
        ..arguments.development.settings(&look)
    };
    let report = display::convert_image(image, world.scene_hash(), preview, &settings, unfinished)?;
    Ok(Some(report))
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}
