//! `candela report`: speed against error, as tables, a plot, and a page.

mod fit;
mod metrics;
mod page;
mod peers;
mod pictures;
mod plot;
mod progress;
mod setting;
mod sweep;
mod table;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use candela::Primaries;
use candela::internal::printable_path;
use candela::output::{self, Unfinished};
use candela::render::MAX_SAMPLES;
use candela::scene::{Scene, Transport};
use candela::world::Loaded;

use super::drawing::{raster, svg};
use super::render::{count, transports};
use super::source::{FrameArguments, SceneArguments};
use super::{Failure, MAX_THREADS};
use page::Pictures;
use peers::Peers;
use progress::Progress;
use setting::Setting;
use sweep::{Plan, Swept};
use table::{LeftOut, Report, Row};

/// Pixels of the PNG for each unit of the plot.
const PLOT_SCALE: f64 = 2.0;

/// The files that are written.
const FILES: [&str; 5] = [
    "report.csv",
    "report.json",
    "plot.svg",
    "plot.png",
    "index.html",
];

/// Measure speed against error on a scene: tables, a plot, pictures of the error
///
/// Renders the scene with more and more samples, each several times, and holds each picture against a reference of
/// many more: how long it took, and how far it is off. Light is carried as RGB and spectrally, where the scene can be
/// both. Pictures of other programs come into the same tables with --peers.
#[derive(Debug, clap::Args)]
#[command(after_long_help = "\
Examples:
  candela report scene.toml -o report
      report/index.html, with plot.svg, plot.png, report.csv and report.json beside it
  candela report scene.toml -o report --samples 1,16,256 --runs 9
      Other points, and more repeats of each
  candela report scene.toml -o report --errors none
      Without what is rendered to an error
  candela report scene.toml -o report --reference 65536 --reference-seconds 600
      A better reference, for small errors
  candela report scene.toml -o report --peers peers/peers.json
      With other programs' times and pictures, as reference/peers/run.py writes them

Exit codes:
  0   all files are written
  1   the scene or a file of --peers is not right, or the folder cannot be written")]
pub(crate) struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,

    #[command(flatten)]
    frame: FrameArguments,

    /// The folder of the report, which is made if it is not there
    #[arg(short, long, value_name = "DIR")]
    output: PathBuf,

    /// Samples a pixel to measure, parted by commas
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "1,4,16,64,256"
    )]
    #[arg(value_parser = setting::samples)]
    samples: Vec<u32>,

    /// Errors to render to, parted by commas, such as 1% or 0.01; or `none`
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "4%,2%,1%,0.5%,0.2%,0.1%"
    )]
    #[arg(value_parser = setting::error)]
    errors: Vec<Option<f64>>,

    /// Samples of the reference at most, of which it takes the largest power of two
    #[arg(long, value_name = "N", default_value_t = 16_384)]
    #[arg(value_parser = |text: &str| count(text, MAX_SAMPLES))]
    reference: u32,

    /// Seconds that a reference may take, about; it has fewer samples where that is too short
    #[arg(long, value_name = "S", default_value_t = 60.0, value_parser = super::diff::limit)]
    reference_seconds: f64,

    /// How often each point is measured, of which the median counts; fewer where that takes long
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = |text: &str| count(text, 1000))]
    runs: u32,

    /// How light is carried: `rgb`, `spectral`, or `auto`, which is both where the scene can be both
    #[arg(long, value_name = "NAME", default_value = Transport::Auto.name())]
    #[arg(value_parser = transports())]
    transport: Transport,

    /// Pictures and times of other programs, as reference/peers/run.py writes them
    #[arg(long, value_name = "FILE.json")]
    peers: Option<PathBuf>,

    /// Threads to render with, 1 to 1024 [default: one for each logical processor]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    #[arg(value_parser = |text: &str| count(text, MAX_THREADS))]
    threads: Option<u32>,
}

/// Measures and writes; the table goes to `output`.
pub(crate) fn run(
    arguments: &Arguments,
    unfinished: &Unfinished,
    output: &mut (impl Write + Send),
) -> Result<(), Failure> {
    super::with_threads(arguments.threads, || report(arguments, unfinished, output))
}

fn report(
    arguments: &Arguments,
    unfinished: &Unfinished,
    output: &mut impl Write,
) -> Result<(), Failure> {
    let frame = arguments.frame.number();
    let Loaded { scene, world, .. } = arguments.scene.load(frame, |_| {})?;
    drop(world);
    let peers = arguments.peers.as_deref().map(Peers::read).transpose()?;
    // Found out now rather than after minutes of rendering.
    let paths = arguments.paths(&scene, peers.as_ref())?;

    let mut measured = measure(arguments, &scene)?;
    let threads = rayon::current_num_threads();
    if let Some(peers) = peers {
        measured.add(peers, threads)?;
    }
    let first = &measured.swept[0].reference;
    let render = pictures::png(&pictures::shown(&first.film, first.truth.ev))?;
    if !first.truth.has_light() {
        let black =
            "the picture is black: errors relative to its light are not defined, and left empty";
        measured.remarks.push(black.to_owned());
    }
    let film = first.film.resolution();
    let rows = measured.rows();
    let report = Report {
        candela: env!("CARGO_PKG_VERSION"),
        scene: arguments.file_name(),
        resolution: film,
        threads,
        references: measured
            .swept
            .iter()
            .map(|swept| swept.reference.row.clone())
            .collect(),
        slopes: table::slopes(&rows),
        rows,
        left_out: measured.left_out,
        remarks: measured.remarks,
    };
    let samples = measured.swept.swap_remove(0).samples;
    let drawing = plot::plot(&report);
    let plot = svg(&drawing, &format!("Error over time: {}", report.scene));
    let raster = raster(&drawing, PLOT_SCALE).ok_or("the plot is too large")?;
    let pictures = Pictures {
        render: &render,
        plot: &plot,
        samples: &samples,
    };
    let page = page::page(&report, &pictures)?;
    let contents = [
        report.csv()?.into_bytes(),
        report.json()?.into_bytes(),
        plot.into_bytes(),
        pictures::png(&raster)?,
        page.into_bytes(),
    ];
    for (path, content) in paths.iter().zip(&contents) {
        output::write(path, unfinished, |sink| sink.write_all(content))?;
    }
    report.write_text(output)?;
    let names: Vec<String> = paths.iter().map(|path| printable_path(path)).collect();
    writeln!(output, "\nwritten: {}", names.join(", "))?;
    output.flush()?;
    Ok(())
}

impl Arguments {
    /// The files to write; an error where one of them cannot be.
    fn paths(&self, scene: &Scene, peers: Option<&Peers>) -> Result<Vec<PathBuf>, Failure> {
        let folder = &self.output;
        fs::create_dir_all(folder).map_err(|error| {
            format!("cannot make the folder {}: {error}", printable_path(folder))
        })?;
        let paths: Vec<PathBuf> = FILES.iter().map(|name| folder.join(name)).collect();
        let mut inputs = scene.files();
        inputs.extend(peers.into_iter().flat_map(Peers::files));
        let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
        let outputs: Vec<&Path> = paths.iter().map(PathBuf::as_path).collect();
        super::refuse_same_files(&inputs, &outputs)?;
        for path in outputs {
            output::check(path)?;
        }
        Ok(paths)
    }

    /// The scene's name without its folder.
    fn file_name(&self) -> String {
        let name = self.scene.name();
        printable_path(Path::new(name.file_name().unwrap_or(name.as_os_str())))
    }

    fn plan(&self) -> Plan {
        let samples = self.samples.iter().copied().map(Setting::Samples);
        let errors = self.errors.iter().flatten().copied().map(Setting::Target);
        Plan {
            settings: samples.chain(errors).collect(),
            reference: self.reference,
            reference_seconds: self.reference_seconds,
            runs: self.runs,
        }
    }

    /// The ways of light to measure.
    fn transports(&self) -> &'static [Transport] {
        match self.transport {
            Transport::Auto => &[Transport::Rgb, Transport::Spectral],
            Transport::Rgb => &[Transport::Rgb],
            Transport::Spectral => &[Transport::Spectral],
        }
    }
}

/// What was measured so far.
struct Measured {
    /// At least one.
    swept: Vec<Swept>,
    peers: Vec<Row>,
    left_out: Vec<LeftOut>,
    remarks: Vec<String>,
}

/// Sweeps each way of light; an error where there is none.
fn measure(arguments: &Arguments, scene: &Scene) -> Result<Measured, Failure> {
    let plan = arguments.plan();
    let mut measured = Measured {
        swept: Vec::new(),
        peers: Vec::new(),
        left_out: Vec::new(),
        remarks: Vec::new(),
    };
    let mut refused: Option<Failure> = None;
    let progress = Progress::new(arguments.transports().len() * (1 + plan.settings.len()));
    for &transport in arguments.transports() {
        match sweep::world(scene, transport) {
            Ok((world, camera)) => {
                let mut swept = sweep::sweep(scene, &world, &camera, &plan, &progress)?;
                measured.left_out.append(&mut swept.left_out);
                measured.swept.push(swept);
            }
            Err(errors) => {
                let first = errors.list().first().map(|error| error.problem.to_string());
                measured.left_out.push(LeftOut {
                    what: format!("candela, {}", transport.name()),
                    why: first.unwrap_or_default(),
                });
                refused = Some(errors.into());
            }
        }
    }
    match (measured.swept.is_empty(), refused) {
        (true, Some(refused)) => Err(refused),
        _ => Ok(measured),
    }
}

impl Measured {
    /// Adds what other programs took, beside the picture that carries light as they do.
    fn add(&mut self, peers: Peers, threads: usize) -> Result<(), Failure> {
        let is_rgb = |swept: &&Swept| swept.reference.row.transport == Transport::Rgb.name();
        let Some(swept) = self.swept.iter().find(is_rgb) else {
            self.left_out.push(LeftOut {
                what: "the programs of --peers".to_owned(),
                why: "they carry light as RGB, which is not measured here".to_owned(),
            });
            return Ok(());
        };
        let primaries = swept.reference.film.metadata().color_space.primaries();
        if primaries != Primaries::REC709 {
            self.left_out.push(LeftOut {
                what: "the programs of --peers".to_owned(),
                why: "they work in Rec.709, and the scene in another color space".to_owned(),
            });
            return Ok(());
        }
        let found = peers.measure(&swept.reference, threads)?;
        self.peers = found.rows;
        self.left_out.extend(found.left_out);
        self.remarks.extend(found.remarks);
        Ok(())
    }

    /// All rows: candela's, then the others'.
    fn rows(&self) -> Vec<Row> {
        let own = self.swept.iter().flat_map(|swept| &swept.rows);
        own.chain(&self.peers).cloned().collect()
    }
}
