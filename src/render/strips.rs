//! Rendering straight into a file: no film, but the rows of tiles that are under way.
//!
//! ```text
//! tiles, begun in order ─▶ strip ─▶ blocks of lines ─▶ file
//!  by all threads           │         │                 │
//!                           │         │                 in order, by whoever has the next
//!                           │         compressed by the thread that finishes the strip's last tile
//!                           as many rows as whole tiles and whole blocks have
//! ```
//!
//! Tiles and blocks are both counted from the top of the window, and their heights are powers of two,
//! so that the higher of both is the height of a strip. The bytes are those of the finished film's
//! [`Film::write_exr`](crate::image::Film::write_exr), for any number of threads.

use std::io::{self, Seek, Write};
use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};

use super::batch::TILE;
use super::counts::Counts;
use super::options::Options;
use super::setup::{View, set_up};
use super::tile::{Space, Tile, Work};
use crate::exr::{ExrFile, ExrOptions, ExrReport, Packer};
use crate::image::{Channels, Rows, Window};
use crate::turns::in_turn;

/// Renders what is built and writes it as OpenEXR into `sink`: see
/// [`Renderer::render_exr`](super::Renderer::render_exr).
pub(super) fn render_exr(
    view: View<'_>,
    options: &Options,
    progress: &(dyn Fn(u64) + Sync),
    exr: &ExrOptions,
    sink: &mut (impl Write + Seek + Send),
) -> io::Result<(Counts, ExrReport)> {
    set_up(view, options, |work, spec| {
        let file = ExrFile::begin(&spec, exr, sink)?;
        let strips = Strips::new(spec.window, &spec.channels, &file);
        let each = |worker: &mut Worker, number| {
            let tile = strips.tile(number);
            worker.render(work, tile, strips.channels);
            progress(tile.count());
            strips.add(tile, worker);
            if file.has_failed() {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        };
        let workers = in_turn(strips.tiles(), || Worker::new(file.packer()), each);
        let counts = workers.iter().map(|worker| worker.counts);
        let counts = counts.fold(Counts::default(), Counts::and);
        Ok((counts, file.finish()?))
    })
}

/// A block that is compressed is there as it is, as the file has it, and in between.
const COPIES_OF_BLOCK: u64 = 5;

/// About how many bytes of pixels [`Renderer::render_exr`](super::Renderer::render_exr) has in memory at once for a window with these channels
/// beside R, G, B and A, on so many threads: a strip, a block and a tile for each, and
/// a strip that waits.
pub fn memory(window: Window, channels: &Channels, exr: &ExrOptions, threads: usize) -> u64 {
    let lines = exr.lines_per_block();
    let [strip, block] = [strip_lines(lines), lines as u32].map(|lines| {
        let pixel = size_of::<[f32; 4]>() + channels.list.len() * size_of::<f32>();
        u64::from(window.width) * u64::from(lines.min(window.height)) * pixel as u64
    });
    // A tile has its values, and before these their sums in f64.
    let tile = u64::from(TILE) * u64::from(TILE);
    let sums = tile * channels.list.len() as u64 * (size_of::<f64>() + size_of::<f32>()) as u64;
    let threads = threads as u64;
    strip * (threads + 1) + (block * COPIES_OF_BLOCK + sums) * threads
}

/// The height of a strip, unless the window is less high.
fn strip_lines(lines_per_block: usize) -> u32 {
    TILE.max(lines_per_block as u32)
}

/// The window in strips, as far as they are being rendered.
struct Strips<'s, 'f> {
    window: Window,
    /// Values of each pixel beside R, G, B, A.
    channels: usize,
    /// Rows of a strip that is not cut off.
    lines: u32,
    file: &'s ExrFile<'f>,
    /// From the top.
    strips: Vec<Mutex<Strip>>,
    /// Memory of strips that were written.
    spare: Mutex<Vec<Strip>>,
}

/// A strip's pixels, empty before its first tile and after its last.
#[derive(Debug, Default)]
struct Strip {
    pixels: Vec<[f32; 4]>,
    values: Vec<f32>,
    /// Of its pixels, those that are rendered.
    count: usize,
}

impl<'s, 'f> Strips<'s, 'f> {
    fn new(window: Window, channels: &Channels, file: &'s ExrFile<'f>) -> Self {
        let lines = strip_lines(file.lines_per_block());
        let strips = (0..window.height.div_ceil(lines)).map(|_| Mutex::default());
        Self {
            window,
            channels: channels.list.len(),
            lines,
            file,
            strips: strips.collect(),
            spare: Mutex::default(),
        }
    }

    /// Tiles in a row.
    fn columns(&self) -> usize {
        self.window.width.div_ceil(TILE) as usize
    }

    /// How many tiles there are.
    fn tiles(&self) -> usize {
        self.columns() * self.window.height.div_ceil(TILE) as usize
    }

    /// Where in the image the tile with this number is.
    fn tile(&self, number: usize) -> Window {
        let Window {
            x,
            y,
            width,
            height,
        } = self.window;
        let left = (number % self.columns()) as u32 * TILE;
        let top = (number / self.columns()) as u32 * TILE;
        Window {
            x: x + left,
            y: y + top,
            width: TILE.min(width - left),
            height: TILE.min(height - top),
        }
    }

    /// Copies a tile that a worker has rendered to its strip, and has the worker write the strip if it
    /// is whole.
    fn add(&self, tile: Window, worker: &mut Worker) {
        let top = tile.y - self.window.y;
        let number = (top / self.lines) as usize;
        let first = number as u32 * self.lines;
        let width = self.window.width as usize;
        let size = width * self.lines.min(self.window.height - first) as usize;
        let mut strip = lock(&self.strips[number]);
        if strip.pixels.is_empty() {
            *strip = lock(&self.spare).pop().unwrap_or_default();
            strip.pixels.resize(size, [0.0; 4]);
            strip.values.resize(size * self.channels, 0.0);
        }
        let columns = tile.width as usize;
        let mut start = (top - first) as usize * width + (tile.x - self.window.x) as usize;
        for row in 0..tile.height as usize {
            let (from, channels) = (row * columns, self.channels);
            strip.pixels[start..][..columns].copy_from_slice(&worker.pixels[from..][..columns]);
            strip.values[start * channels..][..columns * channels]
                .copy_from_slice(&worker.values[from * channels..][..columns * channels]);
            start += width;
        }
        strip.count += columns * tile.height as usize;
        if strip.count < size {
            return;
        }
        let whole = std::mem::take(&mut *strip);
        drop(strip);
        let mut strip = whole;
        let lines = self.file.lines_per_block();
        let blocks = strip.pixels.chunks(width * lines);
        let first_block = first as usize / lines;
        for (block, pixels) in blocks.enumerate() {
            let values = &strip.values[block * width * lines * self.channels..];
            let rows = Rows {
                pixels,
                values: &values[..pixels.len() * self.channels],
            };
            self.file.add(first_block + block, rows, &mut worker.packer);
        }
        strip.count = 0;
        lock(&self.spare).push(strip);
    }
}

/// What a thread needs, and what it has counted.
struct Worker {
    space: Box<Space>,
    packer: Packer,
    /// The tile's.
    pixels: Vec<[f32; 4]>,
    values: Vec<f32>,
    counts: Counts,
}

impl Worker {
    fn new(packer: Packer) -> Self {
        Self {
            space: Box::default(),
            packer,
            pixels: Vec::new(),
            values: Vec::new(),
            counts: Counts::default(),
        }
    }

    /// Renders a tile into `pixels` and `values`.
    fn render(&mut self, work: Work<'_>, window: Window, channels: usize) {
        let (width, count) = (window.width as usize, window.count() as usize);
        self.pixels.clear();
        self.pixels.resize(count, [0.0; 4]);
        self.values.clear();
        self.values.resize(count * channels, 0.0);
        let mut tile = Tile {
            window,
            rows: self.pixels.chunks_mut(width).collect(),
            // No chunk may be of length 0; of no values there are none all the same.
            values: self.values.chunks_mut((width * channels).max(1)).collect(),
        };
        let counts = work.tile(&mut tile, &mut self.space);
        self.counts = self.counts.and(counts);
    }
}

/// A panic elsewhere ends the render in any case.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
