//! candela: a renderer for direct light.

#![forbid(unsafe_code)]

pub mod color;
pub mod display;
pub mod film;
pub mod math;
pub mod oracle;
pub mod output;
pub mod scene;
pub mod shading;
pub mod units;
pub mod visibility;
pub mod world;
