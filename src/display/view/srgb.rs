//! The picture as it is: radiance 1 is the screen's white, and what exceeds it clips.

/// Clips each channel to 0 to 1.
pub(super) fn apply(rgb: [f64; 3]) -> [f64; 3] {
    rgb.map(|x| x.clamp(0.0, 1.0))
}
