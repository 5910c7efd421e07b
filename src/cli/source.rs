//! Where a scene comes from: a file, or standard input.

use std::io;
use std::path::{Path, PathBuf};

use candela::scene::{Diagnostics, Reading, Scene};
use candela::world::{Loaded, World};

use super::frames::{Frame, frame};

/// The name of standard input on the command line; a file of that name is `./-`.
const STANDARD_INPUT: &str = "-";

/// What messages call a scene from there.
const STANDARD_INPUT_SHOWN: &str = "<stdin>";

/// The scene that a command is about.
#[derive(Debug, clap::Args)]
pub(crate) struct SceneArguments {
    /// The scene file; `-` is standard input
    #[arg(value_name = "SCENE.toml")]
    scene: PathBuf,

    #[command(flatten)]
    base: BaseArguments,
}

/// The frame of the scene that a command is about.
#[derive(Debug, clap::Args)]
pub(crate) struct FrameArguments {
    /// The frame of a scene that moves; may have a fraction [default: 1]
    #[arg(long, value_name = "FRAME", value_parser = frame, allow_hyphen_values = true)]
    frame: Option<Frame>,
}

impl FrameArguments {
    pub(super) fn number(&self) -> Option<f64> {
        self.frame.map(Frame::number)
    }
}

/// What the files that a scene names are relative to.
#[derive(Debug, clap::Args)]
pub(crate) struct BaseArguments {
    /// The folder of the meshes and curves that the scene names [default: the scene's own, or the
    /// current one for a scene from standard input]
    #[arg(long, value_name = "DIR", requires = "scene")]
    base: Option<PathBuf>,

    /// Change a value of the scene, as if the file said so, such as lights.key.point.intensity=20; may be repeated
    ///
    /// KEYS is the header with the key: `image.color_space=acescg`, `camera.perspective.vertical_fov=30`,
    /// `materials.clay.phong.diffuse="#804020"`, `lights.key.point.intensity.candela=20`. VALUE is written as in the
    /// file; a name needs no quotes. What there is not cannot be changed.
    #[arg(long, value_name = "KEYS=VALUE")]
    set: Vec<String>,
}

impl SceneArguments {
    /// The scene's name in messages.
    pub(super) fn name(&self) -> &Path {
        shown(&self.scene)
    }

    /// Reads and validates the scene at a frame, changed in between.
    pub(super) fn load(
        &self,
        frame: Option<f64>,
        change: impl FnOnce(&mut Scene),
    ) -> Result<Loaded, Diagnostics> {
        self.base.load(Some(&self.scene), frame, change)
    }
}

impl BaseArguments {
    /// Reads and validates the scene at `path`, or the built-in one, at a frame, changed in between.
    pub(super) fn load(
        &self,
        path: Option<&Path>,
        frame: Option<f64>,
        change: impl FnOnce(&mut Scene),
    ) -> Result<Loaded, Diagnostics> {
        let folder = self.base.as_deref();
        let reading = match path {
            None => Reading::of_builtin(&self.set),
            Some(path) if is_standard_input(path) => {
                let folder = folder.unwrap_or(Path::new(""));
                Reading::of_stream(io::stdin().lock(), shown(path), folder, &self.set)
            }
            Some(path) => {
                let folder = folder.or_else(|| path.parent()).unwrap_or(Path::new(""));
                Reading::of_file_in(path, folder, &self.set)
            }
        };
        let reading = match frame {
            Some(frame) => reading.at(frame),
            None => reading,
        };
        World::of_reading(reading, change)
    }
}

/// Whether an input is standard input, by its name on the command line.
pub(super) fn is_standard_input(path: &Path) -> bool {
    path.as_os_str() == STANDARD_INPUT
}

/// An input as messages name it.
fn shown(path: &Path) -> &Path {
    if is_standard_input(path) {
        Path::new(STANDARD_INPUT_SHOWN)
    } else {
        path
    }
}

/// An input as the command line names it, from how messages do.
pub(super) fn unshown(path: &Path) -> &Path {
    if path.as_os_str() == STANDARD_INPUT_SHOWN {
        Path::new(STANDARD_INPUT)
    } else {
        path
    }
}
