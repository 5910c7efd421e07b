//! `candela render`: a scene file becomes an EXR.

mod layers;
mod progress;
mod summary;
mod values;

use std::ffi::OsStr;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use candela::display::{self, Alpha, Frame};
use candela::exr::{Compression, ExrOptions, Precision};
use candela::image::{Channels, Window};
use candela::memory::Size;
use candela::output::{self, Staged, Unfinished};
use candela::render::{self, Layers, MAX_SAMPLES, Options, Renderer};
use candela::scene::Scene;
use candela::simd::SimdLevel;
use candela::world::{Bands, Loaded, Plan, World, physics};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde::Serialize;

use super::develop::DevelopArguments;
use super::source::{BaseArguments, is_standard_input};
use super::{Failure, MAX_THREADS};
use layers::LayerArguments;
use progress::Progress;
use summary::Summary;
use values::{Crop, count, crop, named};

/// Samples a pixel where none are asked for: nobody's first picture has steps at its edges.
const DEFAULT_SAMPLES: u32 = 16;

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
  candela render scene.toml --samples 1
      Pixel centers and nothing else: a quick look, and values to compare
  candela render scene.toml --crop 600,300,700,400 --samples 256
      Only a part, at its place in the whole image
  candela render scene.toml --half --compression dwaa
      A small file
  candela render scene.toml --layers lights,depth,normal
      Also each light by itself, the distance and the normal, for compositing
  candela render scene.toml --layers spectral --wavelengths 400:700:10
      A spectral image: R, G, B, A and 31 bands")]
pub(crate) struct Arguments {
    /// The scene file; `-` is standard input [default: the built-in lecture scene]
    #[arg(value_name = "SCENE.toml")]
    scene: Option<PathBuf>,

    #[command(flatten)]
    base: BaseArguments,

    /// The EXR file, or - for standard output [default: SCENE.exr in the current folder]
    #[arg(short, long, value_name = "OUT.exr", value_parser = named("exr"))]
    output: Option<PathBuf>,

    /// Samples a pixel, 1 to 65536: 1 is its center and nothing else, more are spread over it
    #[arg(
        long,
        value_name = "N",
        default_value_t = DEFAULT_SAMPLES,
        allow_negative_numbers = true
    )]
    #[arg(value_parser = |text: &str| count(text, MAX_SAMPLES))]
    samples: u32,

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

    /// Also write the `chromaticities` attribute, for software that does not know `colorInteropID`
    #[arg(long)]
    chromaticities: bool,

    /// No progress bar, no summary and no warnings
    #[arg(short, long)]
    quiet: bool,
}

/// `--stats`
#[derive(Serialize)]
struct Statistics<'a> {
    scene_sha256: &'a str,
    inputs_sha256: &'a str,
    image: [u32; 2],
    window: [u32; 4],
    samples: u32,
    /// What is made beside R, G, B, A.
    layers: Vec<&'static str>,
    threads: usize,
    primary_rays: u64,
    /// Camera rays that hit an object.
    hits: u64,
    shadow_rays: u64,
    /// Points that a light reaches, of the shadow rays.
    lit: u64,
    /// Times that a light was on the very point to shade, d = 0, and added nothing.
    singular_lights: u64,
    /// Channels whose radiance does not fit their type: f32, and HALF with `--half`.
    clamped: u64,
    clamped_to_half: u64,
    seconds: &'a Seconds,
    plan: &'a Plan,
}

#[derive(Default, Serialize)]
struct Seconds {
    load: f64,
    build: f64,
    render: f64,
    write: f64,
    total: f64,
}

impl Arguments {
    /// What is wrong with the options as they stand together.
    pub(crate) fn misuse(&self) -> Option<String> {
        self.layers.misuse()
    }
}

pub(crate) fn run(arguments: &Arguments, unfinished: &Unfinished) -> Result<(), Failure> {
    super::with_threads(arguments.threads, || render(arguments, unfinished))
}

fn render(arguments: &Arguments, unfinished: &Unfinished) -> Result<(), Failure> {
    let output = arguments
        .output
        .clone()
        .unwrap_or_else(|| default_output(arguments));
    let mut seconds = Seconds::default();
    let start = Instant::now();

    let Loaded {
        scene,
        world,
        camera,
    } = match &arguments.scene {
        Some(path) => {
            let change = |scene: &mut Scene| arguments.layers.apply(scene);
            arguments.base.load(path, change)?
        }
        None => {
            let mut scene = Scene::builtin();
            arguments.layers.apply(&mut scene);
            let (world, camera) = World::new(&scene)?;
            Loaded {
                scene,
                world,
                camera,
            }
        }
    };
    arguments.layers.check(&world)?;
    let window = arguments
        .crop
        .map(|crop| crop.within(camera.resolution()))
        .transpose()?;
    // Found out now rather than after an hour of rendering.
    let outputs = [
        Some(&output),
        arguments.preview.as_ref(),
        arguments.stats.as_ref(),
    ];
    let outputs: Vec<&Path> = outputs
        .into_iter()
        .flatten()
        .map(PathBuf::as_path)
        .collect();
    let inputs = scene.files();
    let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
    super::refuse_same_files(&inputs, &outputs)?;
    super::refuse_terminal(&output)?;
    if let Some(preview) = &arguments.preview {
        super::refuse_terminal(preview)?;
    }
    for output in &outputs {
        output::check(output)?;
    }
    drop(scene);
    let whole = window.unwrap_or(Window::whole(camera.resolution()));
    let layers = arguments.layers.layers();
    let channels = layers.channels(&world);
    let exr_options = ExrOptions {
        precision: if arguments.half {
            Precision::Half
        } else {
            Precision::Float
        },
        compression: arguments.compression,
        chromaticities: arguments.chromaticities,
    };
    exr_options.check(whole, &channels)?;
    let spectral = world.spectra().zip(layers.spectral);
    let table = spectral.map_or(0, |(spectra, wavelengths)| {
        Bands::size(spectra, wavelengths)
    });
    let threads = rayon::current_num_threads();
    let pixels = render::memory(whole, &channels, &exr_options, threads);
    fits_in_memory(pixels, table, layers, &channels).map_err(super::failure::transient)?;
    seconds.load = start.elapsed().as_secs_f64();

    let (renderer, build) = timed(|| Renderer::new(world));
    let renderer = renderer?;
    let world = renderer.world();
    seconds.build = build;

    let options = Options {
        samples: arguments.samples,
        window,
        layers,
        simd: arguments.simd.unwrap_or_default(),
    };
    let progress = Progress::new(whole, !arguments.quiet);
    let advance = |pixels| progress.advance(pixels);
    // The preview is made of the file, which a stream does not give back.
    let staged = match arguments.preview {
        Some(_) => Staged::new(&output, unfinished)?,
        None => None,
    };
    let written = staged.as_ref().map_or(&*output, Staged::path);
    let content = |mut sink: &mut dyn output::Sink| {
        renderer.render_exr(&camera, &options, &advance, &exr_options, &mut sink)
    };
    let rendered = match &staged {
        Some(staged) => staged.fill(&output, content),
        None => output::write(&output, unfinished, content),
    };
    seconds.render = progress.finish();
    let (counts, report) = rendered?;
    // A PNG with alpha cannot hold light where nothing covers a pixel.
    let has_background = world.background().0.0 != [0.0; 3];
    let developed = match &arguments.preview {
        Some(preview) => {
            let settings = display::Settings {
                exposure: arguments.development.exposure(),
                view: arguments.development.view,
                // Where there is none, what light is there is of the compression.
                alpha: if has_background {
                    Alpha::Opaque
                } else {
                    Alpha::Keep
                },
                dither: arguments.development.dither,
                // Of a part, the part; of the whole that is the whole.
                frame: Frame::Data,
                ..display::Settings::default()
            };
            Some(display::convert(written, preview, &settings, unfinished)?)
        }
        None => None,
    };
    if let Some(staged) = staged {
        staged.send(&output)?;
    }
    seconds.total = start.elapsed().as_secs_f64();
    seconds.write = seconds.total - seconds.render - seconds.build - seconds.load;

    if let Some(path) = &arguments.stats {
        let Window {
            x,
            y,
            width,
            height,
        } = whole;
        let statistics = Statistics {
            scene_sha256: world.scene_hash(),
            inputs_sha256: world.inputs_hash(),
            image: camera.resolution(),
            window: [x, y, x + width, y + height],
            samples: arguments.samples,
            layers: layers.names(),
            threads,
            primary_rays: counts.primary_rays,
            hits: counts.hits,
            shadow_rays: counts.shadow_rays,
            lit: counts.lit,
            singular_lights: counts.singular,
            clamped: counts.clamped,
            clamped_to_half: report.clamped_to_half,
            seconds: &seconds,
            plan: renderer.plan(),
        };
        let json = serde_json::to_string_pretty(&statistics)?;
        output::write(path, unfinished, |sink| writeln!(sink, "{json}"))?;
    }
    if !arguments.quiet {
        let summary = Summary {
            arguments,
            output: &output,
            resolution: camera.resolution(),
            window: whole,
            has_lights: !world.lights().is_empty(),
            warnings: physics::warnings(world),
            counts,
            exr: report,
            developed,
            seconds: seconds.render,
        };
        // Nowhere is left to report that the messages themselves cannot be written.
        let _ = summary.write(&mut io::stderr().lock());
    }
    Ok(())
}

/// Whether the system would give the memory for so many bytes of pixels under way, and for a table of
/// so many numbers for the bands of lights on materials.
fn fits_in_memory(
    pixels: u64,
    table: u64,
    layers: Layers,
    channels: &Channels,
) -> Result<(), Failure> {
    let mut rows: Vec<u8> = Vec::new();
    let mut bands: Vec<f64> = Vec::new();
    let fits = usize::try_from(pixels).is_ok_and(|count| rows.try_reserve_exact(count).is_ok())
        && usize::try_from(table).is_ok_and(|count| bands.try_reserve_exact(count).is_ok());
    if fits {
        return Ok(());
    }
    let table = table.saturating_mul(size_of::<f64>() as u64);
    let size = Size(pixels.saturating_add(table));
    if table > pixels {
        return Err(format!(
            "the bands of all lights on all materials take {size} of memory, more than \
             there is; choose fewer --wavelengths, or fewer lights or materials",
        )
        .into());
    }
    let fewer = if layers.spectral.is_some() {
        "fewer --wavelengths or "
    } else if !channels.list.is_empty() {
        "fewer --layers or "
    } else {
        ""
    };
    Err(format!(
        "the rows of the image that are rendered at once take {size} of memory, more than \
         there is; choose {fewer}a smaller `resolution`, or render it in parts with --crop",
    )
    .into())
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// SCENE.exr in the current folder; scene.exr for a scene from standard input.
fn default_output(arguments: &Arguments) -> PathBuf {
    let scene = match arguments.scene.as_deref() {
        None => Path::new("lecture.toml"),
        Some(scene) if is_standard_input(scene) => Path::new("scene.toml"),
        Some(scene) => scene,
    };
    PathBuf::from(scene.file_name().unwrap_or(OsStr::new("scene"))).with_extension("exr")
}

#[cfg(test)]
mod tests {
    use candela::world::Wavelengths;

    use super::*;

    #[test]
    fn what_does_not_fit_in_memory_is_said() {
        let layers = Layers {
            spectral: Some(Wavelengths::default()),
            ..Layers::default()
        };
        let channels = layers.channels(&World::new(&Scene::builtin()).unwrap().0);
        assert!(fits_in_memory(1000, 1000, layers, &channels).is_ok());
        // 2⁵⁸ numbers are 2⁶¹ bytes, more than any machine addresses.
        let message = |table| {
            let error = fits_in_memory(1000, table, layers, &channels).unwrap_err();
            error.to_string()
        };
        for table in [1 << 58, u64::MAX] {
            let message = message(table);
            assert!(
                message.contains("bands of all lights on all materials"),
                "{message}"
            );
            assert!(
                message.contains("fewer --wavelengths, or fewer lights"),
                "{message}"
            );
        }
        assert!(
            message(1 << 58).contains("2305843009.2 GB"),
            "{}",
            message(1 << 58)
        );

        let rows = |layers, channels| {
            let error = fits_in_memory(1 << 61, 0, layers, channels).unwrap_err();
            error.to_string()
        };
        let message = rows(layers, &channels);
        assert!(message.contains("2305843009.2 GB"), "{message}");
        assert!(
            message.contains("fewer --wavelengths or a smaller"),
            "{message}"
        );
        let message = rows(Layers::default(), &Channels::default());
        assert!(
            message.contains("choose a smaller `resolution`"),
            "{message}"
        );
    }
}
