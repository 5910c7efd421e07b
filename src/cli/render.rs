//! `candela render`: a scene file becomes an EXR.

mod layers;

use std::ffi::OsStr;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use candela::display;
use candela::film::exr::{Compression, ExrOptions, ExrReport, Precision};
use candela::film::{self, Channels, Counts, Layers, MAX_SAMPLES, Options, Window};
use candela::lanes::Door;
use candela::output::{self, Unfinished};
use candela::scene::Scene;
use candela::visibility::Visibility;
use candela::world::{Bands, Plan, World};
use clap::builder::{OsStringValueParser, PossibleValuesParser, TypedValueParser};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;

use super::Failure;
use layers::LayerArguments;

/// A run that takes longer than this shows a progress bar.
const PATIENCE: Duration = Duration::from_secs(1);

/// More threads than any machine makes use of.
const MAX_THREADS: u32 = 1024;

/// Render a scene to a linear OpenEXR image in cd/m²
///
/// Each pixel is the sum over all lights of I/d² times the reflectance times the visibility, in
/// linear RGB. 1.0 in the file is 1 cd/m². The image is the same to the bit for any number of
/// threads.
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Examples:
  candela render
      Render the built-in scene to lecture.exr
  candela render scene.toml -o scene.exr --samples 64
      64 samples a pixel, for smooth edges
  candela render scene.toml --preview scene.png
      Also make a PNG, as `candela tonemap` would
  candela render scene.toml --crop 600,300,700,400 --samples 256
      Only a part, at its place in the whole image
  candela render scene.toml --half --compression dwaa
      A small file
  candela render scene.toml --layers lights,depth,normal
      Also each light by itself, the distance and the normal, for compositing
  candela render scene.toml --layers spectral --wavelengths 400:700:10
      A spectral image: R, G, B, A and 31 bands")]
pub(crate) struct Arguments {
    /// The scene file [default: the built-in lecture scene]
    #[arg(value_name = "SCENE.toml")]
    scene: Option<PathBuf>,

    /// The EXR file [default: SCENE.exr in the current folder]
    #[arg(short, long, value_name = "OUT.exr", value_parser = named("exr"))]
    output: Option<PathBuf>,

    /// Samples a pixel, 1 to 65536: 1 is its center, more are spread over it
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1,
        allow_negative_numbers = true
    )]
    #[arg(value_parser = |text: &str| count(text, MAX_SAMPLES))]
    samples: u32,

    /// Also make a PNG of the EXR, as `candela tonemap` does without options
    #[arg(long, value_name = "OUT.png", value_parser = named("png"))]
    preview: Option<PathBuf>,

    #[command(flatten)]
    layers: LayerArguments,

    /// Write 16-bit HALF channels; values beyond 65504 become that and are counted
    #[arg(long)]
    half: bool,

    /// Render only columns X0 to X1 and rows Y0 to Y1, X1 and Y1 not included; (0, 0) is the top
    /// left. The EXR keeps the place in the whole image
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = crop, allow_hyphen_values = true)]
    crop: Option<Crop>,

    /// Threads to render with, 1 to 1024 [default: one for each logical processor]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    #[arg(value_parser = |text: &str| count(text, MAX_THREADS))]
    threads: Option<u32>,

    /// Instructions to render with; the image is the same to the bit with all [default: the widest
    /// of this machine]
    #[arg(long, value_name = "NAME")]
    #[arg(value_parser = PossibleValuesParser::new(Door::available().into_iter().map(|(name, _)| name))
        .try_map(|name| name.parse::<Door>()))]
    simd: Option<Door>,

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

    /// No progress bar and no summary
    #[arg(short, long)]
    quiet: bool,
}

/// `--crop`, whatever the image's size.
#[derive(Clone, Copy, Debug)]
struct Crop {
    from: [u32; 2],
    to: [u32; 2],
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
    shadow_rays: u64,
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
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(arguments.threads.map_or(0, |threads| threads as usize))
        .build()
        .map_err(|error| super::shortage::no_threads(&error))?;
    pool.install(|| render(arguments, unfinished))
}

fn render(arguments: &Arguments, unfinished: &Unfinished) -> Result<(), Failure> {
    let output = arguments
        .output
        .clone()
        .unwrap_or_else(|| default_output(arguments));
    let mut seconds = Seconds::default();
    let start = Instant::now();

    let (scene, world) = match &arguments.scene {
        Some(path) => World::load_with(path, |scene| arguments.layers.apply(scene))?,
        None => {
            let mut scene = Scene::builtin();
            arguments.layers.apply(&mut scene);
            let world = World::new(&scene)?;
            (scene, world)
        }
    };
    arguments.layers.check(&world)?;
    let window = arguments
        .crop
        .map(|crop| crop.within(world.resolution()))
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
    for output in &outputs {
        output::check(output)?;
    }
    drop(scene);
    let whole = window.unwrap_or(Window::whole(world.resolution()));
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
    let pixels = film::memory(whole, &channels, &exr_options, threads);
    fits_in_memory(pixels, table, layers, &channels)
        .map_err(super::shortage::for_lack_of_memory)?;
    let plan = Plan::new(&world);
    seconds.load = start.elapsed().as_secs_f64();

    let (visibility, build) = timed(|| Visibility::try_new(&world, &plan));
    let visibility = visibility?;
    seconds.build = build;

    let options = Options {
        samples: arguments.samples,
        window,
        layers,
        door: arguments.simd.unwrap_or_default(),
    };
    let progress = Progress::new(whole, arguments);
    let advance = |pixels| progress.advance(pixels);
    let rendered = output::write(&output, unfinished, |mut sink| {
        film::render_exr(
            &world,
            &plan,
            &visibility,
            &options,
            &advance,
            &exr_options,
            &mut sink,
        )
    });
    seconds.render = progress.finish();
    let (counts, report) = rendered?;
    if let Some(preview) = &arguments.preview {
        display::convert(&output, preview, &display::Settings::default(), unfinished)?;
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
            image: world.resolution(),
            window: [x, y, x + width, y + height],
            samples: arguments.samples,
            layers: layers.names(),
            threads,
            primary_rays: counts.primary_rays,
            shadow_rays: counts.shadow_rays,
            singular_lights: counts.singular,
            clamped: counts.clamped,
            clamped_to_half: report.clamped_to_half,
            seconds: &seconds,
            plan: &plan,
        };
        let json = serde_json::to_string_pretty(&statistics)?;
        output::write(path, unfinished, |sink| writeln!(sink, "{json}"))?;
    }
    if !arguments.quiet {
        summarize(&output, &world, arguments, &counts, &report, &seconds);
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
    let pixels = pixels as f64;
    let table = table as f64 * size_of::<f64>() as f64;
    let gigabytes = (pixels + table) / 1e9;
    if table > pixels {
        return Err(format!(
            "the bands of all lights on all materials take {gigabytes:.1} GB of memory, more than \
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
        "the rows of the image that are rendered at once take {gigabytes:.1} GB of memory, more than \
         there is; choose {fewer}a smaller `resolution`, or render it in parts with --crop",
    )
    .into())
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = Instant::now();
    let result = work();
    (result, start.elapsed().as_secs_f64())
}

/// SCENE.exr in the current folder.
fn default_output(arguments: &Arguments) -> PathBuf {
    let scene = arguments
        .scene
        .as_deref()
        .unwrap_or(Path::new("lecture.toml"));
    PathBuf::from(scene.file_name().unwrap_or(OsStr::new("scene"))).with_extension("exr")
}

/// What was written, and what a user should know about it.
fn summarize(
    output: &Path,
    world: &World,
    arguments: &Arguments,
    counts: &Counts,
    report: &ExrReport,
    seconds: &Seconds,
) {
    let [width, height] = world.resolution();
    let samples = match arguments.samples {
        1 => "1 sample".to_owned(),
        samples => format!("{samples} samples"),
    };
    let mut lines = vec![format!(
        "{}: {width} × {height}, {samples} a pixel, rendered in {:.2} s",
        output.display(),
        seconds.render,
    )];
    let mut warn = |count: u64, what: &str| {
        if count > 0 {
            lines.push(format!("warning: {what}: {count}"));
        }
    };
    warn(
        counts.singular,
        "points at which a light is (d = 0), and where it adds nothing",
    );
    warn(
        counts.clamped,
        "values beyond the largest FLOAT, which became that",
    );
    warn(
        report.clamped_to_half,
        "values beyond the largest HALF, which became that",
    );
    warn(
        report.small_in_half,
        "values of layers of light below 6.1e-5, of which HALF keeps few digits",
    );
    // Nowhere is left to report that the messages themselves cannot be written.
    let _ = writeln!(io::stderr(), "{}", lines.join("\n"));
}

/// How far rendering is: a bar that shows itself only when it is worth it.
struct Progress {
    bar: ProgressBar,
    start: Instant,
    pixels: u64,
    /// When the last pixel was rendered, while the last blocks of the file are still to be written.
    end: OnceLock<Duration>,
    wanted: bool,
}

impl Progress {
    fn new(window: Window, arguments: &Arguments) -> Self {
        let pixels = window.count();
        let style = "{bar:40} {percent:>3} %, {eta} left";
        let style = ProgressStyle::with_template(style).expect("the template is well-formed");
        let bar = ProgressBar::with_draw_target(Some(pixels), ProgressDrawTarget::hidden());
        Self {
            bar: bar.with_style(style),
            start: Instant::now(),
            pixels,
            end: OnceLock::new(),
            wanted: !arguments.quiet && io::stderr().is_terminal(),
        }
    }

    fn advance(&self, pixels: u64) {
        self.bar.inc(pixels);
        if self.wanted && self.bar.is_hidden() && self.start.elapsed() > PATIENCE {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
        }
        if self.bar.position() >= self.pixels {
            self.end.get_or_init(|| self.start.elapsed());
        }
    }

    /// Removes the bar; the seconds from the start to the last pixel.
    fn finish(&self) -> f64 {
        self.bar.finish_and_clear();
        let end = self.end.get_or_init(|| self.start.elapsed());
        end.as_secs_f64()
    }
}

impl Crop {
    fn within(self, resolution: [u32; 2]) -> Result<Window, Failure> {
        let Self { from, to } = self;
        let [width, height] = resolution;
        if to[0] > width || to[1] > height {
            return Err(format!(
                "--crop {},{},{},{} is not inside of the image, whose pixels are 0,0,{width},{height}",
                from[0], from[1], to[0], to[1],
            )
            .into());
        }
        Ok(Window {
            x: from[0],
            y: from[1],
            width: to[0] - from[0],
            height: to[1] - from[1],
        })
    }
}

fn crop(text: &str) -> Result<Crop, String> {
    let expected = || "expected X0,Y0,X1,Y1 in pixels, such as 0,0,640,360".to_owned();
    let numbers: Result<Vec<u32>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    let [x0, y0, x1, y1] = numbers.map_err(|_| expected())?[..] else {
        return Err(expected());
    };
    if x0 >= x1 || y0 >= y1 {
        return Err("there are no pixels in it: expected X0 < X1 and Y0 < Y1".to_owned());
    }
    Ok(Crop {
        from: [x0, y0],
        to: [x1, y1],
    })
}

/// A path whose extension is `extension`, so that a file never belies its name.
fn named(extension: &'static str) -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().try_map(move |path| {
        let path = PathBuf::from(path);
        if path.as_os_str() == "-" {
            return Err("a file name is needed; standard output is /dev/stdout".to_owned());
        }
        match path.extension() {
            Some(found) if !found.eq_ignore_ascii_case(extension) => Err(format!(
                "this option writes {}; name the file {}",
                extension.to_uppercase(),
                path.with_extension(extension).display(),
            )),
            Some(_) | None => Ok(path),
        }
    })
}

/// A whole number from 1 to `most`.
fn count(text: &str, most: u32) -> Result<u32, String> {
    let number = text
        .parse()
        .ok()
        .filter(|number| (1..=most).contains(number));
    number.ok_or_else(|| format!("expected a whole number from 1 to {most}"))
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
        let channels = layers.channels(&World::new(&Scene::builtin()).unwrap());
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
