//! The files that `render` writes.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use candela::output;

use super::Arguments;
use crate::cli::advice::no_frames;
use crate::cli::frames::{Frame, Frames, check_name, with_place};
use crate::cli::source::is_standard_input;
use crate::cli::{Failure, refuse_same_files, refuse_terminal};

/// Where a render's files go, of all frames or of one.
#[derive(Clone)]
pub(super) struct Outputs {
    pub(super) exr: PathBuf,
    /// Of the bands of a spectral image, where they have a file of their own.
    pub(super) bands: Option<PathBuf>,
    pub(super) preview: Option<PathBuf>,
    pub(super) statistics: Option<PathBuf>,
    pub(super) manifest: Option<PathBuf>,
}

impl Outputs {
    pub(super) fn new(arguments: &Arguments) -> Self {
        let exr = arguments.output.clone();
        Self {
            exr: exr.unwrap_or_else(|| default_output(arguments)),
            bands: arguments.layers.spectral_output.clone(),
            preview: arguments.preview.clone(),
            statistics: arguments.stats.clone(),
            manifest: arguments.manifest.clone(),
        }
    }

    /// Those of a frame, with its number in their names.
    pub(super) fn of(&self, frame: Option<Frame>) -> Self {
        let Some(frame) = frame else {
            return self.clone();
        };
        let named = |path: &PathBuf| frame.name(path);
        Self {
            exr: named(&self.exr),
            bands: self.bands.as_ref().map(named),
            preview: self.preview.as_ref().map(named),
            statistics: self.statistics.clone(),
            manifest: self.manifest.clone(),
        }
    }

    /// All of them.
    fn all(&self) -> impl Iterator<Item = &Path> {
        let others = [&self.bands, &self.preview, &self.statistics, &self.manifest];
        let others = others.into_iter().flatten();
        std::iter::once(&self.exr)
            .chain(others)
            .map(PathBuf::as_path)
    }

    /// Whether names have a place for the numbers of frames just where there are several.
    pub(super) fn check_names(&self, frames: Option<&Frames>) -> Result<(), String> {
        let of_frames = [Some(&self.exr), self.bands.as_ref(), self.preview.as_ref()];
        for path in of_frames.into_iter().flatten() {
            check_name(path, frames)?;
        }
        for path in [&self.statistics, &self.manifest].into_iter().flatten() {
            no_frames(path)?;
        }
        let is_stream = |path: &&PathBuf| path.as_os_str() == "-";
        if frames.is_some_and(|frames| frames.list().len() > 1)
            && of_frames.into_iter().flatten().any(|path| is_stream(&path))
        {
            return Err(
                "several frames cannot go to standard output; give a name such as f.####.exr"
                    .to_owned(),
            );
        }
        Ok(())
    }

    /// Whether anything goes to standard output.
    pub(super) fn are_on_standard_output(&self) -> bool {
        self.all()
            .any(|path| output::Place::of_output(path).is_standard_output())
    }

    /// Whether all of them can be written, none over another or one of these inputs.
    pub(super) fn check(&self, inputs: &[PathBuf]) -> Result<(), Failure> {
        let all: Vec<&Path> = self.all().collect();
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

/// SCENE.exr in the current folder; SCENE.####.exr for frames, SCENE.tile0003.exr for a tile, SCENE.tile0003.####.exr for
/// tiles of frames; scene.exr for a scene from standard input.
fn default_output(arguments: &Arguments) -> PathBuf {
    let scene = match arguments.scene.as_deref() {
        None => Path::new("lecture.toml"),
        Some(scene) if is_standard_input(scene) => Path::new("scene.toml"),
        Some(scene) => scene,
    };
    let name = PathBuf::from(scene.file_name().unwrap_or(OsStr::new("scene")));
    let name = match arguments.tile {
        None => name.with_extension("exr"),
        Some(tile) => name.with_extension(format!("tile{:04}.exr", tile.index())),
    };
    match &arguments.frames {
        Some(frames) if frames.list().len() > 1 => with_place(&name),
        Some(_) | None => name,
    }
}
