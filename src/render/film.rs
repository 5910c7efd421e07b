//! Rendering into a film in memory.

use rayon::prelude::*;

use super::batch::TILE;
use super::counts::Counts;
use super::options::Options;
use super::setup::{View, set_up};
use super::tile::{Space, Tile};
use crate::camera::Camera;
use crate::image::{Film, Window};
use crate::visibility::Visibility;
use crate::world::{Plan, World};

/// Renders a world as a camera sees it: plans, builds what the plan needs, and renders with the threads
/// of the current rayon pool. The same world, camera and options give the same bits on any number of
/// threads. Where more than one picture is made of a world, a [`Renderer`](super::Renderer) builds once.
///
/// # Panics
/// If [`Options::samples`] is out of range, [`Options::window`] is not inside the image,
/// [`Options::layers`] has a spectral one where the world carries light as RGB, or the camera is placed in
/// a world with another anchor.
pub fn render(world: &World, camera: &Camera, options: &Options) -> Film {
    let plan = Plan::new(world);
    let visibility = Visibility::new(world, &plan);
    let view = View {
        world,
        plan: &plan,
        visibility: &visibility,
        camera,
    };
    render_with(view, options, &|_| {}).0
}

/// [`render`] of what is built. `progress` is told after each tile how many pixels it had.
pub(super) fn render_with(
    view: View<'_>,
    options: &Options,
    progress: &(dyn Fn(u64) + Sync),
) -> (Film, Counts) {
    set_up(view, options, |work, spec| {
        let mut film = Film::black(spec);
        let tiles = tiles(&mut film, TILE).into_par_iter();
        let tiles = tiles.map_init(Box::<Space>::default, |space, mut tile| {
            let counts = work.tile(&mut tile, space);
            progress(tile.window.count());
            counts
        });
        let counts = tiles.reduce(Counts::default, Counts::and);
        (film, counts)
    })
}

/// The film in square tiles of `side` pixels, smaller at the right and bottom.
fn tiles(film: &mut Film, side: u32) -> Vec<Tile<'_>> {
    let Window {
        x,
        y,
        width,
        height,
    } = film.window();
    let mut tiles = Vec::new();
    let channels = film.channels().list.len();
    let (columns, side_length) = (width as usize, side as usize);
    let (pixels, values) = film.rows_mut();
    // No chunk may be of length 0; of no values there are none all the same.
    let mut values = values.chunks_mut((columns * channels).max(1));
    let strips = pixels.chunks_mut(columns * side_length);
    for (strip, top) in strips.zip((0..height).step_by(side_length)) {
        let first = tiles.len();
        tiles.extend((0..width).step_by(side_length).map(|left| Tile {
            window: Window {
                x: x + left,
                y: y + top,
                width: side.min(width - left),
                height: side.min(height - top),
            },
            rows: Vec::with_capacity(side_length),
            values: Vec::new(),
        }));
        for row in strip.chunks_mut(columns) {
            for (tile, part) in tiles[first..].iter_mut().zip(row.chunks_mut(side_length)) {
                tile.rows.push(part);
            }
            let row = values.next().unwrap_or_default();
            let parts = row.chunks_mut((side_length * channels).max(1));
            for (tile, part) in tiles[first..].iter_mut().zip(parts) {
                tile.values.push(part);
            }
        }
    }
    tiles
}
