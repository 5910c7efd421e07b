//! `candela render`: a scene file becomes an EXR.

mod accuracy;
mod cost;
mod finish;
mod layers;
mod manifest;
mod outputs;
mod progress;
mod request;
mod stage;
mod statistics;
mod summary;
mod values;

use std::collections::HashSet;
use std::io::{self, Write};
use std::path::PathBuf;
use std::time::Instant;

use candela::display::{self, Alpha};
use candela::exr::{self, Compression, ExrImage, TileNumber};
use candela::output::{self, Unfinished, Written};
use candela::render::{Built, SimdLevel};
use candela::render::{Job, RenderError, RenderedExr, Renderer};
use candela::world::{World, physics};
use clap::builder::{PossibleValuesParser, TypedValueParser};

use super::crop::{Crop, crop};
use super::develop::DevelopArguments;
use super::display_server::DisplayServer;
use super::frames::{Frame, Frames, frames};
use super::sequence::output_name;
use super::source::BaseArguments;
use super::{Failure, MAX_THREADS};
use accuracy::AccuracyArguments;
pub(super) use accuracy::max_error;
pub(super) use cost::FirstFrame;
use finish::Finishing;
use layers::LayerArguments;
pub(super) use layers::transports;
use manifest::Manifest;
use outputs::Outputs;
use progress::{Lines, Progress};
use request::Request;
use stage::Stage;
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
      The shares of two lights, where they reach, and mattes of objects and materials
  candela render shot.toml --frames 1-240 -o f.####.exr --preview f.####.png
      A sequence; a second time with --skip-done it goes on where it was ended
  candela render scene.toml --set lights.key.point.intensity=20
      With another value than the file has")]
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

    /// Render these frames of a scene that moves, such as 1-100, 1-100:2 or 1,5,9-12, into files such as f.####.exr
    ///
    /// Frames may have fractions. Names have the number in the place of #### or %04d: of -o, --preview and
    /// --spectral-output. One process keeps what does not change from frame to frame. Without, a scene that moves is
    /// rendered at frame 1.
    #[arg(long, visible_alias = "frame", value_name = "LIST", value_parser = frames, allow_hyphen_values = true)]
    frames: Option<Frames>,

    /// Leave files as they are that are whole and say of themselves what would be rendered: of the same inputs, options
    /// and version. Previews are made anew of them
    #[arg(long)]
    skip_done: bool,

    /// Write counts and times as JSON; of frames an object with `frames`, those of each, and `seconds`, of all together
    #[arg(long, value_name = "FILE.json", value_parser = named("json"))]
    stats: Option<PathBuf>,

    /// Write what was read, with what, and what was written, with SHA-256 hashes, as JSON
    #[arg(long, value_name = "FILE.json", value_parser = named("json"))]
    manifest: Option<PathBuf>,

    /// Write lines about the progress to standard output, at most one a second: of Open Job Description, of Alfred (which
    /// Tractor and Deadline 10 read), or as JSON
    #[arg(long, value_name = "FORMAT")]
    progress: Option<Lines>,

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
        let names = Outputs::new(self).check_names(self.frames.as_ref());
        let misuse = self.layers.misuse(self.accuracy.target().is_some());
        misuse.or(names.err()).or_else(|| {
            let several = self
                .frames
                .as_ref()
                .is_some_and(|frames| frames.list().len() > 1);
            (several && self.display_server.is_some()).then(|| {
                "--display-server shows one picture; leave it out, or render one frame".to_owned()
            })
        })
    }
}

/// Of more frames than this, the files are looked at when they are written.
const CHECKED: usize = 1000;

/// Nothing says what errors are relative to.
const TOO_DARK: &str = "the image is too dark to say what errors are relative to: it is black at 64 × 64 points over \
    it, but not everywhere; set the radiance below which errors do not matter with --error-floor, in cd/m²";

pub(crate) fn run(arguments: &Arguments, unfinished: &Unfinished) -> Result<(), Failure> {
    super::with_threads(arguments.threads, || render(arguments, unfinished))
}

fn render(arguments: &Arguments, unfinished: &Unfinished) -> Result<(), Failure> {
    let start = Instant::now();
    let all = Outputs::new(arguments);
    // None for a still.
    let frames: Vec<Option<Frame>> = match &arguments.frames {
        None => vec![None],
        Some(frames) => frames.list().iter().copied().map(Some).collect(),
    };

    let mut stage = Stage::load(arguments, frames[0])?;
    // Found out now rather than after an hour of rendering.
    let inputs = stage.scene.files();
    let request = Request::new(arguments, &stage, frames[0])?;
    for frame in frames.iter().take(CHECKED) {
        all.of(*frame).check(&inputs)?;
    }
    request.check(&stage.world)?;
    if let Some(frames) = &arguments.frames {
        stage.check(frames.list())?;
    }
    let mut render = Render {
        arguments,
        unfinished,
        start,
        progress: Progress::new(
            frames.len(),
            request.window.count(),
            !arguments.quiet,
            arguments.progress,
            all.are_on_standard_output(),
        ),
        seconds: Seconds {
            load: start.elapsed().as_secs_f64(),
            ..Seconds::default()
        },
        statistics: Vec::new(),
        manifest: Manifest::new(arguments, &stage.scene),
        is_first: true,
        told: HashSet::new(),
        finishing: None,
    };

    render.warn_of_frames(&all);
    let rendered = render.frames(&mut stage, &frames, &all);
    if rendered.is_err() {
        // The frame before is whole, and gets its name.
        render.end_last()?;
    }
    rendered?;
    render.finish(&all)
}

/// A render that is under way.
struct Render<'a> {
    arguments: &'a Arguments,
    unfinished: &'a Unfinished,
    start: Instant,
    progress: Progress,
    seconds: Seconds,
    /// Of each frame.
    statistics: Vec<serde_json::Value>,
    manifest: Option<Manifest>,
    /// Whether no frame is rendered yet.
    is_first: bool,
    /// Kinds of warnings that were given.
    told: HashSet<String>,
    /// The frame before, and what there is to say of it.
    finishing: Option<(Finishing, String)>,
}

impl Render<'_> {
    fn frames(
        &mut self,
        stage: &mut Stage,
        frames: &[Option<Frame>],
        all: &Outputs,
    ) -> Result<(), Failure> {
        let mut built = None;
        for (number, frame) in frames.iter().enumerate() {
            if let Some(frame) = frame.filter(|_| number > 0) {
                let (gone, seconds) = timed(|| stage.go_to(frame, built.take()));
                built = gone?;
                self.seconds.build += seconds;
            }
            let request = Request::new(self.arguments, stage, *frame)?;
            let outputs = all.of(*frame);
            if self.arguments.skip_done && request.is_done(stage, &outputs)? {
                self.skip(&request, &outputs, stage)?;
                continue;
            }
            let renderer = match built.take() {
                Some(built) => Built::of(built, &stage.world),
                None => {
                    let (renderer, seconds) = timed(|| Renderer::new(&stage.world));
                    self.seconds.build += seconds;
                    renderer?
                }
            };
            self.frame(&renderer, stage, *frame, &request, &outputs)?;
            built = Some(renderer.into_built());
        }
        Ok(())
    }

    /// Renders a frame and writes its files.
    fn frame(
        &mut self,
        renderer: &Renderer<'_>,
        stage: &Stage,
        frame: Option<Frame>,
        request: &Request,
        outputs: &Outputs,
    ) -> Result<(), Failure> {
        let Self {
            arguments,
            unfinished,
            ..
        } = *self;
        let server = match &arguments.display_server {
            Some(address) => {
                Some(request.show(&stage.world, &stage.camera, address, &outputs.exr)?)
            }
            None => None,
        };
        let progress = self.progress.begin(frame.map(|frame| frame.to_string()));
        let job = Job::watched(|pixels| progress.advance(pixels));
        let job = match &server {
            Some(server) => job.shown_to(server),
            None => job,
        };
        let (rendered, files) = write(renderer, stage, request, outputs, unfinished, &job)?;
        let seconds = progress.seconds();
        drop(job);
        self.seconds.render += seconds;
        let unseen = server.and_then(DisplayServer::warning);
        // Its files get their names while the next frame is being rendered.
        self.end_last()?;
        let finishing = Finishing::begin(files);
        let image = rendered.image.as_ref();
        let developed = image.map_or(Ok(None), |image| {
            develop(arguments, &stage.world, image, outputs, unfinished)
        });
        let (finishing, developed) = match developed {
            Ok(developed) => (finishing, developed),
            Err(error) => {
                // The EXR is whole whatever becomes of its picture.
                finishing.wait()?;
                return Err(error);
            }
        };

        let of_frame = Seconds {
            render: seconds,
            ..Seconds::default()
        };
        if outputs.statistics.is_some() {
            let statistics = Statistics::new(renderer, stage, request, &rendered, &of_frame);
            self.statistics.push(serde_json::to_value(&statistics)?);
        }
        if let Some(manifest) = &mut self.manifest {
            manifest.add(frame, outputs, Some(&rendered.counts), seconds);
        }
        let mut said = String::new();
        if !arguments.quiet {
            let summary = Summary {
                arguments,
                outputs,
                frame,
                resolution: stage.camera.resolution(),
                window: request.window,
                has_lights: !stage.world.lights().is_empty(),
                // Of the first frame: they take their time, and `check` has them of any.
                warnings: if std::mem::replace(&mut self.is_first, false) {
                    physics::warnings(&stage.world)
                } else {
                    Vec::new()
                },
                counts: rendered.counts,
                exr: rendered.report,
                developed,
                unseen,
                seconds,
            };
            said = summary.text(&mut self.told);
        }
        self.finishing = Some((finishing, said));
        Ok(())
    }

    /// What is to be known of several frames before any is rendered.
    fn warn_of_frames(&self, outputs: &Outputs) {
        let frames = self.arguments.frames.as_ref();
        let are_several = frames.is_some_and(|frames| frames.list().len() > 1);
        if !are_several || outputs.preview.is_none() || self.arguments.quiet {
            return;
        }
        if let Some(warning) = self.arguments.development.of_frames() {
            self.progress
                .print(|stream| writeln!(stream, "warning: {warning}"));
        }
    }

    /// Leaves a frame as it is; its preview is made anew.
    fn skip(&mut self, request: &Request, outputs: &Outputs, stage: &Stage) -> Result<(), Failure> {
        self.end_last()?;
        let mut said = format!("{}: is done already", output_name(&outputs.exr));
        if let Some(preview) = &outputs.preview {
            let image = exr::read(&outputs.exr)?;
            let Self {
                arguments,
                unfinished,
                ..
            } = *self;
            develop(arguments, &stage.world, &image, outputs, unfinished)?;
            said.push_str(&format!(
                "\n{}: its preview, made anew",
                output_name(preview)
            ));
        }
        if let Some(manifest) = &mut self.manifest {
            manifest.add(request.frame(), outputs, None, 0.0);
        }
        self.progress.skip();
        if !self.arguments.quiet {
            self.progress.print(|stream| writeln!(stream, "{said}"));
        }
        Ok(())
    }

    /// Waits until the frame before has its names, and says so.
    fn end_last(&mut self) -> Result<(), Failure> {
        let Some((finishing, said)) = self.finishing.take() else {
            return Ok(());
        };
        finishing.wait()?;
        if !said.is_empty() {
            self.progress.print(|stream| writeln!(stream, "{said}"));
        }
        Ok(())
    }

    /// After the last frame.
    fn finish(mut self, outputs: &Outputs) -> Result<(), Failure> {
        let last = self.finishing.take();
        let said = match last {
            Some((finishing, said)) => {
                finishing.wait()?;
                said
            }
            None => String::new(),
        };
        let seconds = &mut self.seconds;
        seconds.total = self.start.elapsed().as_secs_f64();
        seconds.write = seconds.total - seconds.render - seconds.build - seconds.load;
        if let Some(path) = &outputs.statistics {
            let is_still = self.arguments.frames.is_none();
            let json = statistics::json(self.statistics, seconds, is_still)?;
            output::write(path, self.unfinished, |sink| writeln!(sink, "{json}"))?;
        }
        if let (Some(path), Some(manifest)) = (&outputs.manifest, self.manifest) {
            let json = manifest.json(seconds)?;
            output::write(path, self.unfinished, |sink| writeln!(sink, "{json}"))?;
        }
        self.progress.finish();
        if !self.arguments.quiet {
            let of_run = Summary::of_run(outputs);
            let lines: Vec<String> = Some(said)
                .filter(|said| !said.is_empty())
                .into_iter()
                .chain(of_run)
                .collect();
            if !lines.is_empty() {
                // Nowhere is left to report that the messages themselves cannot be written.
                let _ = writeln!(io::stderr().lock(), "{}", lines.join("\n"));
            }
        }
        Ok(())
    }
}

/// Renders a frame into its files, which have not got their names then.
fn write(
    renderer: &Renderer<'_>,
    stage: &Stage,
    request: &Request,
    outputs: &Outputs,
    unfinished: &Unfinished,
    job: &Job<'_>,
) -> Result<(RenderedExr, Vec<Written>), Failure> {
    let Request {
        options,
        exr,
        preserve,
        ..
    } = request;
    let camera = &stage.camera;
    let mut is_too_dark = false;
    let mut of_bands = None;
    let mut bands_written = None;
    let written = output::begin(&outputs.exr, unfinished, |mut sink| {
        let rendered = match &outputs.bands {
            None => renderer.exr(camera, options, exr, *preserve, job, &mut sink),
            Some(path) => {
                let mut rendered = None;
                let written = output::begin(path, unfinished, |mut bands| {
                    let both = renderer
                        .exr_and_bands(camera, options, exr, *preserve, job, &mut sink, &mut bands);
                    rendered = Some(both);
                    Ok(())
                });
                match (written, rendered) {
                    (Ok(((), written)), Some(rendered)) => {
                        bands_written = Some(written);
                        rendered
                    }
                    (Err(error), _) => {
                        of_bands = Some(error);
                        return Err(io::Error::other("stopped"));
                    }
                    (Ok(_), None) => unreachable!("what is written was rendered"),
                }
            }
        };
        is_too_dark = matches!(rendered, Err(RenderError::TooDark));
        Ok(rendered?)
    });
    if let Some(error) = of_bands {
        return Err(error.into());
    }
    if is_too_dark {
        return Err(TOO_DARK.into());
    }
    let (rendered, written) = written?;
    let files = bands_written.into_iter().chain([written]);
    Ok((rendered, files.collect()))
}

/// Makes the preview of what was rendered, where one is asked for.
fn develop(
    arguments: &Arguments,
    world: &World,
    image: &ExrImage,
    outputs: &Outputs,
    unfinished: &Unfinished,
) -> Result<Option<display::Report>, Failure> {
    let Some(preview) = &outputs.preview else {
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
        frame: display::Frame::Data,
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
