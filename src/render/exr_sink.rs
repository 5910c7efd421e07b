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

use std::ops::ControlFlow;
use std::sync::Mutex;

use super::batch::TILE;
use super::lock;
use super::sink::{RenderedTile, Sink};
use crate::exr::{ExrFile, ExrOptions, Packer, Preserve};
use crate::image::{Channels, Rows, Window};

/// A block that is compressed is there as it is, as the file has it, and in between.
const COPIES_OF_BLOCK: u64 = 5;

/// About how many bytes of pixels [`Renderer::exr`](super::Renderer::exr) has in memory at once for a window with these channels
/// beside R, G, B and A, on so many threads: a strip, a block and a tile for each, a strip that
/// waits, and the image that is preserved, if it is.
pub fn memory(
    window: Window,
    channels: &Channels,
    exr: &ExrOptions,
    preserve: Preserve,
    threads: usize,
) -> u64 {
    let lines = exr.lines_per_block();
    let [strip, block] = [strip_lines(lines), lines as u32].map(|lines| {
        let pixel = size_of::<[f32; 4]>() + channels.list.len() * size_of::<f32>();
        u64::from(window.width) * u64::from(lines.min(window.height)) * pixel as u64
    });
    // A tile has its values, and before these their sums in f64.
    let tile = u64::from(TILE) * u64::from(TILE);
    let sums = tile * channels.list.len() as u64 * (size_of::<f64>() + size_of::<f32>()) as u64;
    let threads = threads as u64;
    let preserved = match preserve {
        Preserve::Nothing => 0,
        Preserve::Image => window.count().saturating_mul(size_of::<[f32; 4]>() as u64),
    };
    (strip * (threads + 1) + (block * COPIES_OF_BLOCK + sums) * threads).saturating_add(preserved)
}

/// The height of a strip, unless the window is less high.
fn strip_lines(lines_per_block: usize) -> u32 {
    TILE.max(lines_per_block as u32)
}

/// A file that is being written, and the strips of it that are being rendered.
pub(super) struct ExrSink<'s, 'f> {
    window: Window,
    /// Values of each pixel beside R, G, B, A.
    channels: usize,
    /// Rows of a strip that is not cut off.
    lines: u32,
    file: &'s ExrFile<'f>,
    /// From the top.
    strips: Vec<Mutex<Strip>>,
    /// What is not in use, for the next strip that is begun or written.
    spare_strips: Mutex<Vec<Strip>>,
    spare_packers: Mutex<Vec<Packer>>,
}

/// A strip's pixels, empty before its first tile and after its last.
#[derive(Debug, Default)]
struct Strip {
    pixels: Vec<[f32; 4]>,
    /// As those of [`Rows`].
    values: Vec<f32>,
    /// Of its pixels, those that are rendered.
    count: usize,
}

impl<'s, 'f> ExrSink<'s, 'f> {
    pub(super) fn new(window: Window, channels: &Channels, file: &'s ExrFile<'f>) -> Self {
        let lines = strip_lines(file.lines_per_block());
        let strips = (0..window.height.div_ceil(lines)).map(|_| Mutex::default());
        Self {
            window,
            channels: channels.list.len(),
            lines,
            file,
            strips: strips.collect(),
            spare_strips: Mutex::default(),
            spare_packers: Mutex::default(),
        }
    }

    /// Copies a tile to its strip; the strip, if it is whole by that, and its number.
    fn add(&self, tile: &RenderedTile) -> Option<(usize, Strip)> {
        let number = (tile.window().y - self.window.y) / self.lines;
        let first = number * self.lines;
        let rows = self.lines.min(self.window.height - first);
        let size = self.window.width as usize * rows as usize;
        let mut strip = lock(&self.strips[number as usize]);
        if strip.pixels.is_empty() {
            *strip = lock(&self.spare_strips).pop().unwrap_or_default();
            strip.pixels.resize(size, [0.0; 4]);
            strip.values.resize(size * self.channels, 0.0);
        }
        let Strip {
            pixels,
            values,
            count,
        } = &mut *strip;
        tile.copy_to(self.window, self.window.y + first, pixels, values);
        *count += tile.pixels().len();
        let is_whole = *count == size;
        is_whole.then(|| (number as usize, std::mem::take(&mut *strip)))
    }

    /// Writes the blocks of a strip.
    fn write(&self, number: usize, strip: &Strip, packer: &mut Packer) {
        let lines = self.file.lines_per_block();
        let block = self.window.width as usize * lines;
        let first = number * self.lines as usize / lines;
        for (place, pixels) in strip.pixels.chunks(block).enumerate() {
            let values = &strip.values[place * block * self.channels..];
            let rows = Rows {
                pixels,
                values: &values[..pixels.len() * self.channels],
            };
            self.file.add(first + place, rows, packer);
        }
    }
}

impl Sink for ExrSink<'_, '_> {
    fn take(&self, tile: &RenderedTile) -> ControlFlow<()> {
        if let Some((number, mut strip)) = self.add(tile) {
            let packer = lock(&self.spare_packers).pop();
            let mut packer = packer.unwrap_or_else(|| self.file.packer());
            self.write(number, &strip, &mut packer);
            lock(&self.spare_packers).push(packer);
            strip.count = 0;
            lock(&self.spare_strips).push(strip);
        }
        if self.file.has_failed() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}
