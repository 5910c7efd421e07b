//! Radiance to pixels: tiles, their samples, the box filter, and where finished tiles go.

mod bands;
mod batch;
mod counts;
mod film;
mod layer_sums;
mod layers;
mod options;
mod renderer;
mod sampling;
mod setup;
mod strips;
mod sums;
mod tile;

pub use counts::{Counts, SCREEN_WHITE};
pub use film::render;
pub use layers::{BACKGROUND_LIGHT, Layers};
pub use options::{MAX_SAMPLES, Options};
pub use renderer::Renderer;
pub use strips::memory;
