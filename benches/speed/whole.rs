//! From the scene file to the EXR on disk, as a process of its own.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde::Serialize;

use super::Result;
use super::compare::{Bench, Spread, timed};
use super::scenes::Scene;

/// Spheres at one sample, all lights. Times in seconds.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Whole {
    /// `candela render`, from its start to its end.
    pub(crate) candela: Spread,
    /// `oiiotool in.exr -o out.exr` with candela's file, from its start to its end.
    pub(crate) oiiotool: Option<Spread>,
    /// The yardstick's render alone.
    pub(crate) embree_render: Option<Spread>,
}

/// `oiiotool` as `tests/setup.sh` installs it: not the Python script that starts it, whose time
/// would count, but the program itself; else the system's.
fn oiiotool() -> PathBuf {
    let installed = Path::new(env!("CARGO_TARGET_TMPDIR")).with_file_name("openimageio/lib");
    let folders = std::fs::read_dir(installed).into_iter().flatten().flatten();
    let mut programs =
        folders.map(|folder| folder.path().join("site-packages/OpenImageIO/bin/oiiotool"));
    programs
        .find(|path| path.is_file())
        .unwrap_or_else(|| "oiiotool".into())
}

pub(crate) fn measure(bench: &Bench<'_>, scene: &Scene) -> Result<Whole> {
    let exr = bench.folder.join("whole.exr");
    let copy = bench.folder.join("copy.exr");
    let threads = bench.threads.to_string();
    let mut render = Command::new(env!("CARGO_BIN_EXE_candela"));
    render.args(["render", "--quiet", "--threads", &threads, "-o"]);
    render.arg(&exr).arg(&scene.path);
    let mut rewrite = Command::new(oiiotool());
    rewrite
        .args(["--threads", &threads])
        .arg(&exr)
        .arg("-o")
        .arg(&copy);
    let mut yardstick = bench.yardstick(scene)?;
    let lights = scene.lights.iter().copied().max().unwrap_or(0);

    let (mut ours, mut written, mut theirs) = (Vec::new(), Vec::new(), Vec::new());
    // The first run of each is not measured.
    for run in 0..=bench.runs {
        let keep = |times: &mut Vec<f64>, seconds: f64| {
            if run > 0 {
                times.push(seconds);
            }
        };
        let seconds = run_process(&mut render)?.ok_or("candela has no program to run")?;
        keep(&mut ours, seconds);
        match run_process(&mut rewrite)? {
            Some(seconds) => keep(&mut written, seconds),
            None if run == 0 => eprintln!("no oiiotool: tests/setup.sh installs it"),
            None => {}
        }
        if let Some(yardstick) = &mut yardstick {
            keep(&mut theirs, yardstick.render(1, bench.threads, lights)?);
        }
    }
    let if_run = |values: Vec<f64>| (!values.is_empty()).then(|| Spread::of(values));
    Ok(Whole {
        candela: Spread::of(ours),
        oiiotool: if_run(written),
        embree_render: if_run(theirs),
    })
}

/// The seconds that a process takes; `None` where there is no such program.
fn run_process(command: &mut Command) -> Result<Option<f64>> {
    let (status, seconds) = timed(|| command.stdin(Stdio::null()).status());
    match status {
        Ok(status) if status.success() => Ok(Some(seconds)),
        Ok(status) => Err(format!("{}: {status}", command.get_program().display()).into()),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(error.into()),
    }
}
