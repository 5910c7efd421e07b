//! Pictures and times of other programs: a JSON file beside its EXRs, as `reference/peers/run.py` writes it.

use std::fs;
use std::path::{Path, PathBuf};

use candela::exr::{self, ExrImage};
use candela::image::Window;
use candela::internal::{counted, printable_path};
use serde::Deserialize;

use super::metrics::planes;
use super::pictures;
use super::sweep::{Reference, is_near};
use super::table::{Aim, LeftOut, Row};
use crate::cli::Failure;

/// The most bytes that such a file has.
const LONGEST: u64 = 1 << 24;

/// The file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Peers {
    /// Threads that the programs had.
    threads: usize,
    rows: Vec<PeerRow>,
    /// Programs that cannot show the scene.
    #[serde(default)]
    left_out: Vec<LeftOut>,
    /// What there is to know of the programs, a sentence each.
    #[serde(default)]
    remarks: Vec<String>,
    /// Where it was read from.
    #[serde(skip)]
    path: PathBuf,
}

/// A picture of another program.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PeerRow {
    series: String,
    setting: String,
    label: String,
    #[serde(default)]
    samples_per_pixel: Option<f64>,
    seconds: f64,
    runs: u32,
    /// The EXR, from the file's folder: R, G, B in cd/m², Rec.709.
    picture: PathBuf,
}

/// What peers add to a report.
pub(super) struct Measured {
    pub(super) rows: Vec<Row>,
    pub(super) left_out: Vec<LeftOut>,
    pub(super) remarks: Vec<String>,
}

impl Peers {
    /// Reads the file, not its pictures.
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        let name = printable_path(path);
        let size = fs::metadata(path).map_err(|error| format!("cannot read {name}: {error}"))?;
        if size.len() > LONGEST {
            return Err(
                format!("cannot read {name}: it is too long for a list of pictures").into(),
            );
        }
        let text =
            fs::read_to_string(path).map_err(|error| format!("cannot read {name}: {error}"))?;
        let peers: Self = serde_json::from_str(&text).map_err(|error| {
            format!("{name} is not a list of other programs' pictures: {error}")
        })?;
        let wrong = |row: &&PeerRow| !(row.seconds > 0.0 && row.seconds.is_finite());
        if let Some(row) = peers.rows.iter().find(wrong) {
            return Err(format!(
                "{name}: the seconds of {:?}, {:?}, are {}; expected a time above 0",
                row.series, row.setting, row.seconds
            )
            .into());
        }
        let path = path.to_path_buf();
        Ok(Self { path, ..peers })
    }

    /// The files that are read.
    pub(super) fn files(&self) -> Vec<PathBuf> {
        let pictures = self.rows.iter().map(|row| self.place(row));
        std::iter::once(self.path.clone()).chain(pictures).collect()
    }

    fn place(&self, row: &PeerRow) -> PathBuf {
        self.path
            .parent()
            .unwrap_or(Path::new(""))
            .join(&row.picture)
    }

    /// Measures the pictures against a reference.
    pub(super) fn measure(
        self,
        reference: &Reference,
        threads: usize,
    ) -> Result<Measured, Failure> {
        let window = reference.film.window();
        let mut rows = Vec::new();
        for row in &self.rows {
            let path = self.place(row);
            let image = exr::read(&path)?;
            check(&image, window, &path)?;
            let planes = planes(&image.pixels)?;
            let errors = reference.truth.errors(&planes)?;
            rows.push(Row {
                series: row.series.clone(),
                transport: reference.row.transport.to_owned(),
                setting: row.setting.clone(),
                label: row.label.clone(),
                samples_per_pixel: row.samples_per_pixel,
                seconds: row.seconds,
                runs: row.runs,
                rays: None,
                aim: Aim::default(),
                is_near_reference: is_near(errors.rmse, reference),
                errors,
                picture: pictures::png(&reference.truth.error_picture(&planes)?)?,
            });
        }
        let mut remarks = self.remarks;
        if self.threads != threads {
            remarks.push(format!(
                "the other programs had {}, candela {threads}",
                counted(self.threads, "thread", "threads")
            ));
        }
        Ok(Measured {
            rows,
            left_out: self.left_out,
            remarks,
        })
    }
}

/// Whether a picture is one of the whole scene.
fn check(image: &ExrImage, window: Window, path: &Path) -> Result<(), Failure> {
    if image.window == Some(window) {
        return Ok(());
    }
    let [width, height] = image.resolution;
    Err(format!(
        "{} has {width} × {height} pixels, or not all of them; the scene has {} × {}",
        printable_path(path),
        window.width,
        window.height,
    )
    .into())
}
