//! What a frame costs, for whoever parts the work.

use std::time::Instant;

use candela::exr::{Tile, TileNumber};
use candela::image::Window;
use candela::render::{Job, Options, Renderer};
use rayon::prelude::*;

use super::Arguments;
use super::outputs::Outputs;
use super::request::Request;
use super::stage::Stage;
use crate::cli::{Failure, failure};

/// Columns and rows of the parts that are rendered to find out: four of the renderer's tiles.
const PART: [u32; 2] = [64, 16];

/// No further parts are rendered after so many seconds.
const ENOUGH: f64 = 0.5;

/// The inverse of the golden ratio: parts at its multiples, modulo 1, are spread evenly however many there are.
/// Knuth, The Art of Computer Programming 3, section 6.4.
const SPREAD: f64 = 0.618_033_988_749_894_9;

/// The first frame of a render, read and checked.
pub(in crate::cli) struct FirstFrame {
    stage: Stage,
    request: Request,
}

impl Arguments {
    /// The first option that has no meaning in a job: it names a file that would be each task's, or a window.
    pub(in crate::cli) fn beyond_jobs(&self) -> Option<&'static str> {
        [
            ("--preview", self.preview.is_some()),
            ("--spectral-output", self.layers.spectral_output.is_some()),
            ("--stats", self.stats.is_some()),
            ("--manifest", self.manifest.is_some()),
            ("--display-server", self.display_server.is_some()),
        ]
        .into_iter()
        .find_map(|(name, is_there)| is_there.then_some(name))
    }

    /// Whether it says itself where the EXR goes.
    pub(in crate::cli) const fn has_output(&self) -> bool {
        self.output.is_some()
    }

    /// Whether it says itself which frames.
    pub(in crate::cli) const fn has_frames(&self) -> bool {
        self.frames.is_some()
    }
}

impl FirstFrame {
    /// Reads and checks the scene with its options; so many tiles must be possible.
    pub(in crate::cli) fn load(arguments: &Arguments, tiles: Option<u32>) -> Result<Self, Failure> {
        let first = arguments.frames.as_ref().map(|frames| frames.list()[0]);
        let stage = Stage::load(arguments, first)?;
        let request = Request::new(arguments, &stage, first)?;
        request.check(&stage.world)?;
        if let Some(frames) = &arguments.frames {
            // Better here than on many machines.
            stage.check(frames.list())?;
        }
        if let Some(count) = tiles {
            let number = TileNumber::new(count - 1, count)?;
            let tile = Tile {
                number,
                of: request.window,
            };
            let window = tile.window(arguments.compression);
            window.map_err(|error| failure::Misuse(format!("--tiles: {error}")))?;
        }
        Ok(Self { stage, request })
    }

    /// The files that the scene was read from.
    pub(in crate::cli) fn files(&self) -> Vec<std::path::PathBuf> {
        self.stage.scene.files()
    }

    /// Where the EXR of all frames goes.
    pub(in crate::cli) fn output(arguments: &Arguments) -> std::path::PathBuf {
        Outputs::new(arguments).exr
    }

    /// Seconds that rendering the whole frame takes with all threads, from parts of it that are spread over the picture.
    /// Reading, building and writing are not in it.
    pub(in crate::cli) fn seconds(&self) -> Result<f64, Failure> {
        let Self { stage, request } = self;
        let renderer = Renderer::new(&stage.world)?;
        let whole = request.window;
        // With an error to render to, each part looks at all of the picture first, which is not to count.
        let part = match request.options.target {
            Some(_) => [whole.width, PART[1]],
            None => PART,
        };
        let (columns, rows) = (
            whole.width.div_ceil(part[0]),
            whole.height.div_ceil(part[1]),
        );
        let count = u64::from(columns) * u64::from(rows);
        let together = rayon::current_num_threads() as u64;
        let start = Instant::now();
        let (mut pixels, mut next) = (0, 0);
        while next < count && start.elapsed().as_secs_f64() < ENOUGH {
            let rendered: Result<Vec<u64>, Failure> = (next..(next + together).min(count))
                .into_par_iter()
                .map(|number| {
                    let place = ((number as f64 * SPREAD).fract() * count as f64) as u64;
                    // Below the number of columns, and of rows.
                    let [column, row] = [place % u64::from(columns), place / u64::from(columns)]
                        .map(|index| index as u32);
                    let (x, y) = (column * part[0], row * part[1]);
                    let window = Window {
                        x: whole.x + x,
                        y: whole.y + y,
                        width: part[0].min(whole.width - x),
                        height: part[1].min(whole.height - y),
                    };
                    let options = Options {
                        window: Some(window),
                        ..request.options.clone()
                    };
                    renderer.film(&stage.camera, &options, &Job::new())?;
                    Ok(window.count())
                })
                .collect();
            pixels += rendered?.into_iter().sum::<u64>();
            next += together;
        }
        let seconds = start.elapsed().as_secs_f64();
        Ok(seconds * whole.count() as f64 / pixels as f64)
    }
}
