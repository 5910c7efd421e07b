//! Perfectly smooth boundaries: what they reflect and let through, where it goes, and the glasses and metals that they
//! are made of.
//!
//! Light is unpolarized, and each boundary starts anew: F is the mean of both polarizations. Cosines are between a
//! direction and the normal on its own side, in 0..=1. η = n_t/n_i is the index beyond the boundary over the one before
//! it, so 1/n for light that leaves a body of index n.
//!
//! Radiance that passes a boundary is also scaled by 1/η², and by η² on its way out. A closed body seen from outside
//! has both, so nothing here does it.
//!
//! Only +, −, ·, ÷, √ and comparisons are used, and libm's exponential function.

mod absorption;
mod direction;
mod fresnel;
mod glass;
mod metal;
mod sellmeier;
#[cfg(test)]
mod tests;

pub(crate) use absorption::absorbed;
pub(crate) use direction::{reflected, refracted};
pub(crate) use fresnel::{conductor, dielectric, pane, schlick};
pub(crate) use glass::Glass;
pub(crate) use metal::Metal;
