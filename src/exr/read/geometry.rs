//! Where a part's pixels are: its windows, its blocks, and which of them the display window shows.

use super::header::{Levels, Part, Tiles};
use super::{ExrProblem, damaged};
use crate::image::Window;

/// The largest display window, in pixels, around a small data window: 16 384 squared.
///
/// A display window's size is a claim that no data backs, so a damaged header could ask for a PNG
/// of any length.
const MAX_SPARSE_PIXELS: u64 = 1 << 28;

/// The longest side of a display window around a small data window: a row of the PNG is in memory
/// as a whole, and of one pixel each there would be too many.
const MAX_SPARSE_SIDE: u64 = 1 << 20;

/// Display windows above [`MAX_SPARSE_PIXELS`] or [`MAX_SPARSE_SIDE`] are plausible up to this
/// multiple of the data.
const MAX_SPARSITY: u64 = 16;

/// A rectangle of the data window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rectangle {
    pub(super) left: u32,
    pub(super) top: u32,
    pub(super) width: u32,
    pub(super) height: u32,
}

/// Where a part's pixels are, and which of them count.
#[derive(Debug)]
pub(super) struct Geometry {
    /// Width and height of the display window.
    pub(super) resolution: [u32; 2],
    /// The part of the display window that the file has pixels for.
    pub(super) window: Option<Window>,
    /// The top left of `window` in the data window.
    pub(super) origin: [u32; 2],
    /// Width and height of the data window.
    pub(super) size: [u32; 2],
    /// The coordinates of the data window's top left.
    pub(super) start: [i32; 2],
    /// Width and height of a block that is not cut off.
    pub(super) block: [u32; 2],
    /// Blocks beside and below each other, in the largest level.
    pub(super) blocks: [u32; 2],
    pub(super) is_tiled: bool,
}

/// The length of a window's side.
const fn side(first: i32, last: i32) -> u32 {
    last.abs_diff(first) + 1
}

impl Geometry {
    /// With so many lines in a block of scan lines.
    pub(super) fn new(part: &Part, lines: u32) -> Self {
        let [left, top, right, bottom] = part.data_window;
        let [display_left, display_top, display_right, display_bottom] = part.display_window;
        let size = [side(left, right), side(top, bottom)];
        let resolution = [
            side(display_left, display_right),
            side(display_top, display_bottom),
        ];
        let overlap = |data: [i32; 2], display: [i32; 2]| {
            let (first, last) = (data[0].max(display[0]), data[1].min(display[1]));
            (first <= last).then(|| (first, side(first, last)))
        };
        let columns = overlap([left, right], [display_left, display_right]);
        let rows = overlap([top, bottom], [display_top, display_bottom]);
        let window = columns.zip(rows).map(|((x, width), (y, height))| Window {
            x: x.abs_diff(display_left),
            y: y.abs_diff(display_top),
            width,
            height,
        });
        let origin = columns.zip(rows).map_or([0, 0], |((x, _), (y, _))| {
            [x.abs_diff(left), y.abs_diff(top)]
        });
        let block = part
            .tiles
            .map_or([size[0], lines], |tiles| [tiles.width, tiles.height]);
        Self {
            resolution,
            window,
            origin,
            size,
            start: [left, top],
            block,
            blocks: [0, 1].map(|side| size[side].div_ceil(block[side])),
            is_tiled: part.tiles.is_some(),
        }
    }

    /// Whether the display window is about as large as the data makes plausible.
    pub(super) fn check_display(&self) -> Result<(), ExrProblem> {
        let area = |[width, height]: [u32; 2]| u64::from(width) * u64::from(height);
        let is_plausible = |shown: u64, data: u64, sparse: u64| {
            shown <= sparse.max(data.saturating_mul(MAX_SPARSITY))
        };
        let side_is_plausible = |side: usize| {
            let (shown, data) = (self.resolution[side], self.size[side]);
            is_plausible(shown.into(), data.into(), MAX_SPARSE_SIDE)
        };
        if is_plausible(area(self.resolution), area(self.size), MAX_SPARSE_PIXELS)
            && side_is_plausible(0)
            && side_is_plausible(1)
        {
            return Ok(());
        }
        let [width, height] = self.resolution;
        Err(ExrProblem::TooLarge(width, height))
    }

    /// The block in this column and row of blocks.
    pub(super) fn rectangle(&self, column: u32, row: u32) -> Rectangle {
        let (left, top) = (column * self.block[0], row * self.block[1]);
        Rectangle {
            left,
            top,
            width: self.block[0].min(self.size[0] - left),
            height: self.block[1].min(self.size[1] - top),
        }
    }

    /// How many blocks the largest level has.
    pub(super) fn count(&self) -> u64 {
        u64::from(self.blocks[0]) * u64::from(self.blocks[1])
    }
}

/// How many chunks a part has, all levels together.
pub(super) fn chunks(part: &Part, lines: u32) -> u64 {
    let [left, top, right, bottom] = part.data_window;
    let (width, height) = (side(left, right), side(top, bottom));
    let Some(tiles) = part.tiles else {
        return u64::from(height.div_ceil(lines));
    };
    let blocks = |width: u32, height: u32| {
        u64::from(width.div_ceil(tiles.width)) * u64::from(height.div_ceil(tiles.height))
    };
    match tiles.levels {
        Levels::One => blocks(width, height),
        Levels::MipMap => (0..levels(width.max(height), tiles))
            .map(|level| blocks(scaled(width, level, tiles), scaled(height, level, tiles)))
            .sum(),
        Levels::RipMap => {
            let sizes =
                |side| (0..levels(side, tiles)).map(move |level| scaled(side, level, tiles));
            sizes(height)
                .map(|height| sizes(width).map(|width| blocks(width, height)).sum::<u64>())
                .sum()
        }
    }
}

/// How many levels halve a side down to 1.
fn levels(side: u32, tiles: Tiles) -> u32 {
    if tiles.rounds_up {
        side.next_power_of_two().ilog2() + 1
    } else {
        side.ilog2() + 1
    }
}

/// A side after it was halved `level` times.
fn scaled(side: u32, level: u32, tiles: Tiles) -> u32 {
    let scaled = if tiles.rounds_up {
        u64::from(side).div_ceil(1 << level) as u32
    } else {
        side >> level
    };
    scaled.max(1)
}

/// Samples of a channel at every `sampling`-th coordinate from `first` on, `length` long.
pub(super) fn samples(first: i32, length: u32, sampling: u32) -> u32 {
    let (first, sampling) = (i64::from(first), i64::from(sampling));
    let end = first + i64::from(length);
    let before = |end: i64| (end - 1).div_euclid(sampling);
    (before(end) - before(first)) as u32
}

/// Whether the sampling of a part's channels is one that OpenEXR allows.
pub(super) fn check_sampling(part: &Part) -> Result<(), ExrProblem> {
    let [left, top, right, bottom] = part.data_window;
    let (width, height) = (side(left, right), side(top, bottom));
    for channel in &part.channels {
        let [x, y] = channel.sampling;
        if (x, y) == (1, 1) {
            continue;
        }
        let divides = |start: i32, length: u32, sampling: u32| {
            i64::from(start) % i64::from(sampling) == 0 && length.is_multiple_of(sampling)
        };
        if part.tiles.is_some() || !divides(left, width, x) || !divides(top, height, y) {
            return Err(damaged(
                "its channels have a sampling that does not fit its data window",
            ));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_counted() {
        assert_eq!(samples(0, 10, 1), 10);
        assert_eq!(samples(0, 10, 2), 5);
        assert_eq!(samples(0, 1, 2), 1);
        assert_eq!(samples(1, 1, 2), 0);
        assert_eq!(samples(-2, 1, 2), 1);
        assert_eq!(samples(-3, 4, 3), 2);
        assert_eq!(samples(-1, 1, 3), 0);
    }

    #[test]
    fn levels_halve_down_to_one() {
        let tiles = |rounds_up| Tiles {
            width: 64,
            height: 64,
            levels: Levels::MipMap,
            rounds_up,
        };
        let sizes = |side, rounds_up| -> Vec<u32> {
            let tiles = tiles(rounds_up);
            (0..levels(side, tiles))
                .map(|level| scaled(side, level, tiles))
                .collect()
        };
        assert_eq!(sizes(15, false), [15, 7, 3, 1]);
        assert_eq!(sizes(15, true), [15, 8, 4, 2, 1]);
        assert_eq!(sizes(16, true), [16, 8, 4, 2, 1]);
        assert_eq!(sizes(1, true), [1]);
    }
}
