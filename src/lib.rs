//! candela: a renderer for direct light.

pub mod film;
pub mod math;
pub mod oracle;
pub mod scene;
pub mod units;
