//! candela: a renderer for direct light.

pub mod film;
pub mod math;
pub mod scene;
pub mod shading;
pub mod units;
pub mod visibility;
pub mod world;
