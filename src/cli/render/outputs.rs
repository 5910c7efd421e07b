//! The files that `render` writes.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use candela::output;

use super::Arguments;
use crate::cli::source::is_standard_input;
use crate::cli::{Failure, refuse_same_files, refuse_terminal};

/// Where a render's files go.
pub(super) struct Outputs {
    pub(super) exr: PathBuf,
    /// Of the bands of a spectral image, where they have a file of their own.
    pub(super) bands: Option<PathBuf>,
    preview: Option<PathBuf>,
    pub(super) statistics: Option<PathBuf>,
}

impl Outputs {
    pub(super) fn new(arguments: &Arguments) -> Self {
        let exr = arguments.output.clone();
        Self {
            exr: exr.unwrap_or_else(|| default_output(arguments)),
            bands: arguments.layers.spectral_output.clone(),
            preview: arguments.preview.clone(),
            statistics: arguments.stats.clone(),
        }
    }

    /// Whether all of them can be written, none over another or one of these inputs.
    pub(super) fn check(&self, inputs: &[PathBuf]) -> Result<(), Failure> {
        let all = [
            Some(&self.exr),
            self.bands.as_ref(),
            self.preview.as_ref(),
            self.statistics.as_ref(),
        ];
        let all: Vec<&Path> = all.into_iter().flatten().map(PathBuf::as_path).collect();
        let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
        refuse_same_files(&inputs, &all)?;
        refuse_terminal(&self.exr)?;
        for other in [&self.bands, &self.preview].into_iter().flatten() {
            refuse_terminal(other)?;
        }
        for output in all {
            output::check(output)?;
        }
        Ok(())
    }
}

/// SCENE.exr in the current folder, SCENE.tile0003.exr for a tile; scene.exr for a scene from standard input.
fn default_output(arguments: &Arguments) -> PathBuf {
    let scene = match arguments.scene.as_deref() {
        None => Path::new("lecture.toml"),
        Some(scene) if is_standard_input(scene) => Path::new("scene.toml"),
        Some(scene) => scene,
    };
    let name = PathBuf::from(scene.file_name().unwrap_or(OsStr::new("scene")));
    match arguments.tile {
        None => name.with_extension("exr"),
        Some(tile) => name.with_extension(format!("tile{:04}.exr", tile.index())),
    }
}
