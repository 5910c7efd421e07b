//! How time and memory grow with threads, triangles, lights, samples and pixels.
//!
//! Every point is measured in a process of its own, so that its peak of memory is its own.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use candela::exr::ExrOptions;
use candela::output::Unfinished;
use candela::render::{Job, Options, Renderer};
use serde::{Deserialize, Serialize};

use super::archive::{keep, milliseconds};
use super::compare::{Spread, load, pool, timed};
use super::plot::plot;
use super::scenes::{self, Scene};
use super::{Result, Setting};

/// A point that takes longer than this many seconds is measured once.
const LONG: f64 = 20.0;

const NAMES: [&str; 6] = [
    "threads",
    "threads-mesh",
    "triangles",
    "lights",
    "samples",
    "pixels",
];

/// One render.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Point {
    scene: PathBuf,
    samples: u32,
    threads: usize,
    resolution: [u32; 2],
}

/// What one render took. Seconds and bytes.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct Cost {
    load: f64,
    build: f64,
    render: f64,
    write: f64,
    /// `None` where the system does not say.
    peak_memory: Option<f64>,
}

/// One place of a table.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Measured {
    /// What grows.
    pub(crate) x: f64,
    label: String,
    samples_per_second: f64,
    load: Spread,
    build: Spread,
    pub(crate) render: Spread,
    write: Spread,
    /// Bytes.
    pub(crate) peak_memory: Option<Spread>,
}

/// How cost grows with one thing.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Table {
    name: String,
    pub(crate) title: String,
    pub(crate) axis: String,
    pub(crate) points: Vec<Measured>,
}

/// A table to be: what it is about, and its points by their place on the axis.
struct Sweep {
    name: &'static str,
    title: &'static str,
    axis: &'static str,
    points: Vec<(f64, String, Point)>,
}

/// The program's half of [`measure`]: renders what the JSON `point` says, and prints its cost.
pub(crate) fn measure_here(point: &str) -> Result<()> {
    let point: Point = serde_json::from_str(point)?;
    let cost = pool(point.threads)?.install(|| -> Result<Cost> {
        let (world, camera, load) = load(&point.scene, |scene| {
            scene.image.resolution.value = point.resolution;
        })?;
        let (renderer, build) = timed(|| Renderer::new(&world));
        let renderer = renderer?;
        let options = Options {
            samples: point.samples,
            ..Options::default()
        };
        let (rendered, render) = timed(|| renderer.film(&camera, &options, &Job::new()));
        let (film, _) = rendered?;
        let exr = point.scene.with_extension("exr");
        let (written, write) =
            timed(|| film.write_exr(&exr, &ExrOptions::default(), &Unfinished::new()));
        written?;
        fs::remove_file(exr)?;
        Ok(Cost {
            load,
            build,
            render,
            write,
            peak_memory: peak_memory(),
        })
    })?;
    println!("{}", serde_json::to_string(&cost)?);
    Ok(())
}

/// The most bytes that this process ever had in memory, where the system says it.
fn peak_memory() -> Option<f64> {
    let status = fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kibibytes * 1024.0)
}

/// Measures all tables that are wanted.
pub(crate) fn measure(
    folder: &Path,
    setting: &Setting,
    runs: u32,
    is_wanted: &dyn Fn(&str) -> bool,
) -> Result<Vec<Table>> {
    let mut tables = Vec::new();
    for name in NAMES.into_iter().filter(|name| is_wanted(name)) {
        let sweep = sweep(folder, setting.threads, name)?;
        eprintln!("{}: {} …", sweep.name, sweep.title);
        tables.push(sweep.measure(runs)?);
    }
    if tables.is_empty() {
        return Err(format!("no such table; there are {}", NAMES.join(", ")).into());
    }
    Ok(tables)
}

fn sweep(folder: &Path, threads: usize, name: &str) -> Result<Sweep> {
    const FULL_HD: [u32; 2] = [1920, 1080];
    let point = |scene: &Scene, samples: u32, threads: usize, resolution: [u32; 2]| Point {
        scene: scene.path.clone(),
        samples,
        threads,
        resolution,
    };
    Ok(match name {
        "threads" | "threads-mesh" => {
            let (name, title, scene) = if name == "threads" {
                (
                    "threads",
                    "25 spheres, 3 lights, 4 samples",
                    scenes::write_spheres(folder)?,
                )
            } else {
                let scene = scenes::write_smooth(folder, 1_000_000)?;
                ("threads-mesh", "1 M triangles, 3 lights, 4 samples", scene)
            };
            let powers = (0..)
                .map(|power| 1 << power)
                .take_while(|&count| count < threads);
            let counts = powers.chain([threads]);
            Sweep {
                name,
                title,
                axis: "threads",
                points: counts
                    .map(|count| {
                        (
                            count as f64,
                            count.to_string(),
                            point(&scene, 4, count, FULL_HD),
                        )
                    })
                    .collect(),
            }
        }
        "triangles" => {
            let mut points = Vec::new();
            for (count, label) in [
                (1_000, "1 k"),
                (10_000, "10 k"),
                (100_000, "100 k"),
                (1_000_000, "1 M"),
                (10_000_000, "10 M"),
            ] {
                let scene = scenes::write_smooth(folder, count)?;
                points.push((
                    count as f64,
                    label.to_owned(),
                    point(&scene, 4, threads, FULL_HD),
                ));
            }
            Sweep {
                name: "triangles",
                title: "one shape, ever finer, with vertex normals; 3 lights, 4 samples",
                axis: "triangles",
                points,
            }
        }
        "lights" => {
            let mut points = Vec::new();
            for count in [1, 3, 10, 30, 100, 300, 1000] {
                let scene = scenes::write_lights(folder, count)?;
                points.push((
                    count as f64,
                    count.to_string(),
                    point(&scene, 1, threads, FULL_HD),
                ));
            }
            Sweep {
                name: "lights",
                title: "25 spheres, 1 sample",
                axis: "lights",
                points,
            }
        }
        "samples" => {
            let scene = scenes::write_spheres(folder)?;
            let counts = [1, 4, 16, 64, 256].into_iter();
            Sweep {
                name: "samples",
                title: "25 spheres, 3 lights",
                axis: "samples a pixel",
                points: counts
                    .map(|count| {
                        (
                            f64::from(count),
                            count.to_string(),
                            point(&scene, count, threads, FULL_HD),
                        )
                    })
                    .collect(),
            }
        }
        _ => {
            let scene = scenes::write_spheres(folder)?;
            let sizes = [
                ([854, 480], "480p"),
                ([1280, 720], "720p"),
                (FULL_HD, "1080p"),
                ([2560, 1440], "1440p"),
                ([3840, 2160], "4K"),
                ([7680, 4320], "8K"),
            ];
            Sweep {
                name: "pixels",
                title: "25 spheres, 3 lights, 1 sample",
                axis: "pixels",
                points: sizes
                    .into_iter()
                    .map(|(size, label)| {
                        let pixels = f64::from(size[0]) * f64::from(size[1]);
                        (pixels, label.to_owned(), point(&scene, 1, threads, size))
                    })
                    .collect(),
            }
        }
    })
}

impl Sweep {
    fn measure(self, runs: u32) -> Result<Table> {
        let mut points = Vec::new();
        for (x, label, point) in self.points {
            let mut costs = Vec::new();
            for _ in 0..runs {
                let cost = point.cost()?;
                costs.push(cost);
                if cost.load + cost.build + cost.render + cost.write > LONG {
                    break;
                }
            }
            let of = |part: fn(&Cost) -> f64| Spread::of(costs.iter().map(part).collect());
            let memory: Option<Vec<f64>> = costs.iter().map(|cost| cost.peak_memory).collect();
            let [width, height] = point.resolution.map(f64::from);
            let render = of(|cost| cost.render);
            points.push(Measured {
                x,
                label,
                samples_per_second: width * height * f64::from(point.samples) / render.median,
                load: of(|cost| cost.load),
                build: of(|cost| cost.build),
                render,
                write: of(|cost| cost.write),
                peak_memory: memory.map(Spread::of),
            });
        }
        Ok(Table {
            name: self.name.to_owned(),
            title: self.title.to_owned(),
            axis: self.axis.to_owned(),
            points,
        })
    }
}

impl Point {
    fn cost(&self) -> Result<Cost> {
        let output = Command::new(std::env::current_exe()?)
            .args(["--point", &serde_json::to_string(self)?])
            .stderr(Stdio::inherit())
            .output()?;
        if !output.status.success() {
            return Err(format!("{}: {}", self.scene.display(), output.status).into());
        }
        Ok(serde_json::from_slice(&output.stdout)?)
    }
}

/// The tables; with the names of their plots where they are kept beside.
pub(crate) fn markdown(setting: &Setting, tables: &[Table], stem: Option<&str>) -> String {
    let mut text = format!(
        "# Scaling\n\n{}\n\nTimes are medians in ms.\n",
        setting.line()
    );
    for table in tables {
        // Writing to a string does not fail.
        let _ = write!(
            text,
            "\n## {}\n\n{}\n\n| {} | render | of the first | Msamples/s | load | build | write \
             | peak memory, MB |\n| --- | --- | --- | --- | --- | --- | --- | --- |\n",
            table.name, table.title, table.axis,
        );
        let first = table.points.first().map(|point| point.render.median);
        for point in &table.points {
            let memory = point.peak_memory;
            let _ = writeln!(
                text,
                "| {} | {} | {:.2} | {:.2} | {} | {} | {} | {} |",
                point.label,
                milliseconds(point.render.median),
                point.render.median / first.unwrap_or(f64::NAN),
                point.samples_per_second / 1e6,
                milliseconds(point.load.median),
                milliseconds(point.build.median),
                milliseconds(point.write.median),
                memory.map_or_else(
                    || "–".to_owned(),
                    |bytes| format!("{:.0}", bytes.median / 1e6)
                ),
            );
        }
        if let Some(stem) = stem {
            let _ = write!(text, "\n![{}]({stem}/{}.svg)\n", table.name, table.name);
        }
    }
    text
}

/// Keeps the tables as Markdown with plots and as JSON.
pub(crate) fn archive(setting: &Setting, tables: &[Table]) -> Result<()> {
    #[derive(Serialize)]
    struct Report<'a> {
        setting: &'a Setting,
        tables: &'a [Table],
    }
    let stem = setting.file_stem() + "-scaling";
    for table in tables {
        keep(&format!("{stem}/{}.svg", table.name), &plot(table))?;
    }
    keep(
        &format!("{stem}.md"),
        &markdown(setting, tables, Some(&stem)),
    )?;
    let json = serde_json::to_string_pretty(&Report { setting, tables })?;
    keep(&format!("{stem}.json"), &(json + "\n"))
}

impl Measured {
    /// How this place on the axis is called.
    pub(crate) fn label(&self) -> &str {
        &self.label
    }
}
