//! candela: a renderer for direct light.

#![forbid(unsafe_code)]

pub mod film;
pub mod math;
pub mod scene;
pub mod units;
