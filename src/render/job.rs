//! A render as it is seen from outside: watched, and canceled.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};

use super::sink::{RenderedTile, Sink};

/// A render that other threads may watch and cancel.
///
/// ```
/// use std::sync::atomic::{AtomicU64, Ordering};
///
/// use candela::render::{Job, Renderer};
/// use candela::{Options, Scene, World};
///
/// let (world, camera) = World::new(&Scene::builtin())?;
/// let renderer = Renderer::new(&world)?;
/// let pixels = AtomicU64::new(0);
/// let job = Job::watched(|more| {
///     pixels.fetch_add(more, Ordering::Relaxed);
/// });
/// let (film, _) = renderer.film(&camera, &Options::default(), &job)?;
/// assert_eq!(pixels.load(Ordering::Relaxed), film.pixels().len() as u64);
///
/// let job = Job::new();
/// job.cancel(); // most often by another thread
/// assert!(renderer.film(&camera, &Options::default(), &job).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Default)]
pub struct Job<'j> {
    is_canceled: AtomicBool,
    watcher: Option<Box<dyn Fn(u64) + Sync + 'j>>,
    viewer: Option<&'j dyn Sink>,
}

impl<'j> Job<'j> {
    /// A job that nobody watches.
    pub fn new() -> Self {
        Self::default()
    }

    /// A job whose watcher is told, after each tile and from any thread, how many pixels it had.
    pub fn watched(watcher: impl Fn(u64) + Sync + 'j) -> Self {
        Self {
            is_canceled: AtomicBool::new(false),
            watcher: Some(Box::new(watcher)),
            viewer: None,
        }
    }

    /// The same job, whose tiles are also shown to `viewer` as they come. Whether it breaks or not, rendering goes on.
    #[must_use]
    pub fn shown_to(self, viewer: &'j dyn Sink) -> Self {
        Self {
            viewer: Some(viewer),
            ..self
        }
    }

    /// Ends it, once the tiles are done that are under way.
    pub fn cancel(&self) {
        self.is_canceled.store(true, Ordering::Relaxed);
    }

    /// Whether [`Job::cancel`] has been called.
    pub fn is_canceled(&self) -> bool {
        self.is_canceled.load(Ordering::Relaxed)
    }

    /// A tile more is rendered.
    pub(super) fn advance(&self, tile: &RenderedTile) {
        if let Some(viewer) = self.viewer {
            // Nothing depends on what is looked at.
            let _ = viewer.take(tile);
        }
        if let Some(watcher) = &self.watcher {
            watcher(tile.window().count());
        }
    }
}

impl fmt::Debug for Job<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut job = f.debug_struct("Job");
        job.field("is_canceled", &self.is_canceled);
        job.finish_non_exhaustive()
    }
}
