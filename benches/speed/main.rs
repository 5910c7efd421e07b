//! candela's benchmark: its render times beside those of Embree doing the same work, on scenes that it
//! writes itself. benches/README.md says how to run it and how to read what it prints.

mod archive;
mod compare;
mod meshes;
mod plot;
#[path = "../rays/mod.rs"]
mod rays;
mod scaling;
mod scenes;
mod tonemap;
mod whole;
mod work;
mod yardstick;

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

use clap::Parser;
use serde::Serialize;

/// Whatever went wrong ends the benchmark with a message.
type Result<T> = std::result::Result<T, Box<dyn Error + Send + Sync>>;

/// Measure candela's speed, beside Embree's on the same scenes
#[derive(Debug, Parser)]
#[command(name = "cargo bench --", no_binary_name = false)]
struct Arguments {
    /// Only what is for every day: spheres and dragon, 3 lights, 4 samples, and the whole process
    #[arg(long, conflicts_with = "scaling")]
    quick: bool,

    /// How time and memory grow with threads, triangles, lights, samples and pixels instead
    #[arg(long)]
    scaling: bool,

    /// Rays and segments that share nothing instead, one thread; nothing is archived
    #[arg(long, conflicts_with_all = ["quick", "scaling"])]
    rays: bool,

    /// From an EXR to a PNG instead, view by view, beside oiiotool and Python; nothing is archived
    #[arg(long, conflicts_with_all = ["quick", "scaling", "rays"])]
    tonemap: bool,

    /// The folder of the Stanford dragon's meshes, dragon_vrip.ply and dragon_vrip_res2.ply to _res4
    #[arg(long, value_name = "FOLDER")]
    dragon: Option<PathBuf>,

    /// Only these scenes or, with --scaling, tables; nothing is archived then
    #[arg(long, value_name = "NAME")]
    only: Vec<String>,

    /// Only with these samples a pixel; nothing is archived then
    #[arg(long, value_name = "N", conflicts_with_all = ["quick", "scaling"])]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=65536))]
    samples: Vec<u32>,

    /// How often each time is measured
    #[arg(long, value_name = "N", default_value_t = 5)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..=1000))]
    runs: u32,

    /// Threads to render with [default: one for each logical processor]
    #[arg(long, value_name = "N")]
    #[arg(value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,

    /// The version of Embree to compare with [default: 4 where it is installed, else 3]
    #[arg(long, value_name = "3|4", conflicts_with_all = ["scaling", "tonemap"])]
    #[arg(value_parser = clap::value_parser!(u8).range(3..=4))]
    embree: Option<u8>,

    /// The date in the archive [default: today, from the system]
    #[arg(long, value_name = "YYYY-MM-DD")]
    date: Option<String>,

    /// The machine in the archive [default: the processor's model, from the system]
    #[arg(long, value_name = "MODEL")]
    machine: Option<String>,

    /// Leave benches/archive as it is
    #[arg(long)]
    no_archive: bool,

    /// Measure one render in this process, described in JSON
    #[arg(long, hide = true)]
    point: Option<String>,

    /// Cargo says so; it makes no difference
    #[arg(long, hide = true)]
    bench: bool,
}

/// Where and when a benchmark ran.
#[derive(Clone, Debug, Serialize)]
struct Setting {
    date: String,
    machine: String,
    logical_processors: usize,
    threads: usize,
    runs: u32,
    /// Processes that wanted to run in the minute before the benchmark did, where the system says it.
    load_before: Option<f64>,
    /// What was measured: the commit, with `-dirty` where the sources differ from it.
    candela: String,
    /// Its version, where it ran.
    embree: Option<String>,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<()> {
    if let Some(point) = &arguments.point {
        return scaling::measure_here(point);
    }
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("bench");
    fs::create_dir_all(&folder)?;
    let mut setting = Setting::new(arguments)?;
    let is_wanted =
        |name: &str| arguments.only.is_empty() || arguments.only.iter().any(|only| only == name);

    if arguments.scaling {
        let tables = scaling::measure(&folder, &setting, arguments.runs, &is_wanted)?;
        print!("{}", scaling::markdown(&setting, &tables, None));
        if arguments.may_archive() {
            scaling::archive(&setting, &tables)?;
        }
        return Ok(());
    }

    if arguments.tonemap {
        print!("{}", tonemap::measure(&folder, arguments.runs)?);
        return Ok(());
    }

    if arguments.rays {
        let scenes = scenes::write_all(&folder, arguments.dragon.as_deref())?;
        let is_default = |name: &str| ["spheres-10k", "dragon", "smooth", "room"].contains(&name);
        let scenes: Vec<_> = scenes
            .iter()
            .filter(|scene| is_wanted(&scene.name))
            .filter(|scene| !arguments.only.is_empty() || is_default(&scene.name))
            .collect();
        print!(
            "{}",
            rays::measure(&folder, &scenes, arguments.runs, arguments.embree)?
        );
        return Ok(());
    }

    let program = yardstick::compile(&folder, arguments.embree);
    if let Err(error) = &program {
        eprintln!(
            "The yardstick cannot be compiled: {error}\n\
             candela is measured alone. For the comparison install Embree 4 or 3 and a C++ compiler;\n\
             on Debian and Ubuntu: apt install libembree-dev g++"
        );
    }
    let program = program.ok();
    let scenes = scenes::write_all(&folder, arguments.dragon.as_deref())?;
    let known: Vec<&str> = scenes.iter().map(|scene| scene.name.as_str()).collect();
    if let Some(unknown) = arguments
        .only
        .iter()
        .find(|only| !known.contains(&only.as_str()))
    {
        return Err(format!("no scene {unknown}; there are {}", known.join(", ")).into());
    }
    let bench = compare::Bench {
        folder: &folder,
        program: program.as_deref(),
        threads: setting.threads,
        runs: arguments.runs,
    };
    let mut rows = Vec::new();
    for scene in &scenes {
        let is_quick = scene.name == "spheres" || scene.name.starts_with("dragon");
        if !is_wanted(&scene.name) || (arguments.quick && !is_quick) {
            continue;
        }
        let (lights, samples): (&[usize], &[u32]) = if arguments.quick {
            (&[3], &[4])
        } else if arguments.samples.is_empty() {
            (&scene.lights, &scene.samples)
        } else {
            (&scene.lights, &arguments.samples)
        };
        eprintln!("{}: {} …", scene.name, scene.content);
        rows.extend(bench.scene(scene, lights, samples)?);
    }
    setting.embree = rows.iter().find_map(|row| row.embree_version.clone());
    let whole = if is_wanted("spheres") {
        eprintln!("whole process …");
        Some(whole::measure(&bench, &scenes[0])?)
    } else {
        None
    };
    let report = archive::Report {
        setting,
        rows,
        whole,
    };
    print!("{}", report.markdown());
    if arguments.may_archive() {
        report.archive(if arguments.quick { "-quick" } else { "" })?;
    }
    Ok(())
}

impl Arguments {
    fn may_archive(&self) -> bool {
        !self.no_archive && self.only.is_empty() && self.samples.is_empty()
    }
}

impl Setting {
    fn new(arguments: &Arguments) -> Result<Self> {
        let logical_processors = std::thread::available_parallelism()?.get();
        let of_system = |program: &str, arguments: &[&str]| {
            let output = Command::new(program).args(arguments).output().ok()?;
            let text = String::from_utf8(output.stdout).ok()?;
            let text = text.trim();
            (output.status.success() && !text.is_empty()).then(|| text.to_owned())
        };
        let model = || {
            let info = fs::read_to_string("/proc/cpuinfo").ok()?;
            let line = info.lines().find(|line| line.starts_with("model name"))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        };
        let root = env!("CARGO_MANIFEST_DIR");
        let date = arguments
            .date
            .clone()
            .or_else(|| of_system("date", &["+%F"]));
        let machine = arguments.machine.clone().or_else(model);
        Ok(Self {
            date: date.ok_or("the system does not say the date; add --date")?,
            machine: machine.ok_or("the system does not name its processor; add --machine")?,
            logical_processors,
            threads: arguments.threads.map_or(logical_processors, usize::from),
            runs: arguments.runs,
            load_before: fs::read_to_string("/proc/loadavg")
                .ok()
                .and_then(|text| text.split_whitespace().next()?.parse().ok()),
            candela: of_system("git", &["-C", root, "describe", "--always", "--dirty"])
                .unwrap_or_else(|| env!("CARGO_PKG_VERSION").to_owned()),
            embree: None,
        })
    }

    /// Where it was measured, in a line.
    fn line(&self) -> String {
        let embree = match &self.embree {
            Some(version) => format!(" beside Embree {version}"),
            None => String::new(),
        };
        let load = match self.load_before {
            Some(load) => format!(" System load before: {load}."),
            None => String::new(),
        };
        format!(
            "{}, {}, {} logical processors. candela {}{embree}; threads: {}, runs: {}.{load}",
            self.date, self.machine, self.logical_processors, self.candela, self.threads, self.runs,
        )
    }

    /// The start of the name of every file in the archive.
    fn file_stem(&self) -> String {
        let slug = |text: &str| {
            let words = text.split(|c: char| !c.is_ascii_alphanumeric());
            let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
            words.join("-").to_lowercase()
        };
        format!(
            "{}-{}-{}",
            slug(&self.date),
            slug(&self.machine),
            self.logical_processors
        )
    }
}
