//! Rendering into a film in memory.

use std::ops::ControlFlow;
use std::sync::Mutex;

use super::batch::TILE;
use super::sink::{RenderedTile, Sink};
use crate::image::{Film, Window};

/// A film that is being filled.
pub(super) struct FilmSink<'f> {
    window: Window,
    /// Its rows of tiles by themselves, so that threads seldom wait for each other.
    strips: Vec<Mutex<Strip<'f>>>,
}

/// The rows of a film that a row of tiles has.
struct Strip<'f> {
    pixels: &'f mut [[f32; 4]],
    values: &'f mut [f32],
}

impl<'f> FilmSink<'f> {
    /// Fills this film.
    pub(super) fn new(film: &'f mut Film) -> Self {
        let window = film.window();
        let channels = film.channels().list.len();
        let (pixels, values) = film.rows_mut();
        let count = window.width as usize * TILE as usize;
        // No chunk may be of length 0; of no values there are none all the same.
        let mut values = values.chunks_mut((count * channels).max(1));
        let strips = pixels.chunks_mut(count).map(|pixels| {
            let values = values.next().unwrap_or_default();
            Mutex::new(Strip { pixels, values })
        });
        Self {
            window,
            strips: strips.collect(),
        }
    }
}

impl Sink for FilmSink<'_> {
    fn take(&self, tile: &RenderedTile) -> ControlFlow<()> {
        let number = (tile.window().y - self.window.y) / TILE;
        let mut strip = super::lock(&self.strips[number as usize]);
        let Strip { pixels, values } = &mut *strip;
        tile.copy_to(self.window, self.window.y + number * TILE, pixels, values);
        ControlFlow::Continue(())
    }
}
