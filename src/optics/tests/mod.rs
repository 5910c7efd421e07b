//! The room against published numbers, other forms of its equations, and what must hold of any.

mod conductor;
mod direction;
mod fresnel;
mod glass;
mod metal;

use super::*;

/// Cosines from grazing to the normal.
fn cosines() -> impl Iterator<Item = f64> {
    (0..=200).map(|step| f64::from(step) / 200.0)
}

/// The cosine of an angle in degrees.
fn cosine(degrees: f64) -> f64 {
    degrees.to_radians().cos()
}

/// Whether `value` rounds to what was published with so many decimals.
#[track_caller]
fn assert_published(value: f64, published: f64, decimals: i32) {
    let half = 0.5001 * 10_f64.powi(-decimals);
    assert!(
        (value - published).abs() <= half,
        "{value} is not {published} to {decimals} decimals"
    );
}
