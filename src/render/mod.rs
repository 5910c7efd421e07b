//! Radiance to pixels: tiles, their samples, the box filter, and where rendered tiles go.
//!
//! ```text
//! scheduler ─ tile ─ passes ─ batches ─ sums ─ means ─ sink
//!     │        │       │         │        │      │       │
//!     │        │       │         │        │      │       a film in memory, or strips of a file
//!     │        │       │         │        │      the box filter, narrowed to f32
//!     │        │       │         │        f64, in the order of a pixel's samples
//!     │        │       │         256 samples that are traced and shaded together
//!     │        │       ranges of samples, of some pixels
//!     │        16 × 16 pixels in Z order
//!     row by row, by all threads, until the job is canceled
//! ```

mod accuracy;
mod adaptive;
mod arrivals;
mod bands;
mod batch;
mod counts;
mod cryptomatte;
mod dispersion;
mod exr_sink;
mod film_sink;
mod illuminance;
mod job;
mod layer_sums;
mod layers;
mod leaving_rays;
mod options;
mod path_step;
mod paths;
mod renderer;
mod sampling;
mod scheduler;
mod setup;
mod shares;
mod sights;
mod sink;
mod statistics;
mod sums;
#[cfg(test)]
mod tests;
mod tile;

use std::sync::{Mutex, MutexGuard, PoisonError};

pub use accuracy::{ErrorCounts, ErrorTarget, MAX_SAMPLES, MIN_RELATIVE_ERROR};
pub use counts::Counts;
#[doc(hidden)]
pub use counts::SCREEN_WHITE;
#[doc(hidden)]
pub use exr_sink::memory;
pub use illuminance::illuminance;
pub use job::Job;
pub use layers::{Layers, MatteRanks, Relight};
pub use options::{Options, OptionsError};
#[doc(hidden)]
pub use renderer::{Built, is_done};
pub use renderer::{RenderError, RenderedExr, Renderer, render};
#[doc(hidden)]
pub use shares::BACKGROUND_LIGHT;
pub use sink::{RenderedTile, Sink};

pub use crate::simd::SimdLevel;
#[doc(hidden)]
pub use crate::simd::UnknownInstructions;
pub use crate::visibility::{RayWork, Work};

/// A panic elsewhere ends the render in any case.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
