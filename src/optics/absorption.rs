//! What a body takes of the light that crosses it.

/// exp(−σ d): what is left of light after a way `distance` through a medium that absorbs `sigma` of it per length
/// (Bouguer 1729, Lambert 1760, Beer 1852).
///
/// Both are finite and not below zero, σ in 1/m where d is in m; the result is in 0..=1. A medium that lets T through at
/// a thickness of 1 m has σ = −ln T.
pub(crate) fn absorbed(sigma: f64, distance: f64) -> f64 {
    libm::exp(-(sigma * distance))
}
