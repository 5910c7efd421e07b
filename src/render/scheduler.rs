//! Which tile is rendered when, and by whom.

use std::ops::ControlFlow;

use super::adaptive::Adaptive;
use super::batch::{Selection, TILE};
use super::counts::Counts;
use super::job::Job;
use super::sink::{ErrorChannels, RenderedTile, Sink};
use super::tile::{Setup, Space, Tile};
use crate::image::Window;
use crate::turns::in_turn;

/// Renders all tiles of a window by all threads of the current rayon pool, and hands each to the sink.
/// It ends early where the job is canceled or the sink has enough.
pub(super) fn render_tiles<'w>(
    setup: &Setup<'w>,
    window: Window,
    (channels, error_channels): (usize, ErrorChannels),
    job: &Job<'_>,
    sink: &dyn Sink,
) -> Counts {
    let each = |worker: &mut Worker<'w>, number| {
        if job.is_canceled() {
            return ControlFlow::Break(());
        }
        worker.render(setup, tile(window, number));
        job.advance(&worker.rendered);
        sink.take(&worker.rendered)
    };
    let workers = in_turn(
        tiles(window),
        || Worker::new(setup, RenderedTile::new(channels, error_channels)),
        each,
    );
    let counts = workers.iter().map(|worker| worker.counts);
    let mut counts = counts.fold(Counts::default(), Counts::and);
    if let Some(leaves) = setup.met_leaves {
        leaves.count_into(&mut counts.work);
    }
    counts
}

/// Tiles in a row of a window.
fn columns(window: Window) -> usize {
    window.width.div_ceil(TILE) as usize
}

/// How many tiles a window has.
fn tiles(window: Window) -> usize {
    columns(window) * window.height.div_ceil(TILE) as usize
}

/// Where in the image the tile of a window with this number is, counted row by row.
fn tile(window: Window, number: usize) -> Window {
    let left = (number % columns(window)) as u32 * TILE;
    let top = (number / columns(window)) as u32 * TILE;
    Window {
        x: window.x + left,
        y: window.y + top,
        width: TILE.min(window.width - left),
        height: TILE.min(window.height - top),
    }
}

/// What a thread needs, and what it has counted.
struct Worker<'w> {
    tile: Box<Tile<'w>>,
    space: Box<Space>,
    rendered: RenderedTile,
    adaptive: Option<Adaptive<'w>>,
    counts: Counts,
}

impl<'w> Worker<'w> {
    fn new(setup: &Setup<'w>, rendered: RenderedTile) -> Self {
        Self {
            tile: Box::default(),
            space: Space::of(setup),
            rendered,
            adaptive: setup.goal.map(|goal| Adaptive::new(setup, goal)),
            counts: Counts::default(),
        }
    }

    /// Renders a tile into `rendered`.
    fn render(&mut self, setup: &Setup<'w>, window: Window) {
        if let Some((adaptive, goal)) = self.adaptive.as_mut().zip(setup.goal) {
            let (tile, space) = (&mut self.tile, &mut self.space);
            let met = adaptive.render(setup, goal, window, tile, space, &mut self.rendered);
            self.counts = self.counts.and(met);
            return;
        }
        let samples = 0..setup.sampler.samples();
        self.tile.begin(setup, window);
        let taken = self
            .tile
            .pass(setup, samples, &Selection::ALL, &mut self.space);
        let met = self.tile.means(setup, &mut self.rendered);
        self.rendered.set_samples(setup.sampler.samples());
        self.counts = self.counts.and(taken).and(met);
    }
}

/// The tiles of a window.
pub(super) fn windows(window: Window) -> impl Iterator<Item = Window> {
    (0..tiles(window)).map(move |number| tile(window, number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_all_of_a_window_and_do_not_overlap() {
        let window = Window {
            x: 5,
            y: 7,
            width: 40,
            height: 33,
        };
        let mut pixels: Vec<[u32; 2]> = windows(window).flat_map(Window::pixels).collect();
        assert_eq!(pixels.len() as u64, window.count());
        pixels.sort_unstable_by_key(|&[x, y]| [y, x]);
        assert!(pixels.into_iter().eq(window.pixels()));
    }
}
