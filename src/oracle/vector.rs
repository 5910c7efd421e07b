//! The few operations on three numbers that the equations need.
//!
//! The oracle has its own, so that a mistake in the renderer's vectors cannot hide here as well.

use super::wide::{Real, Wide};

/// Three coordinates or components as written; also a linear RGB triple.
pub(super) type Vector = [f64; 3];

/// Three coordinates or components as computed.
pub(super) type WideVector = [Wide; 3];

pub(super) const ZERO: Vector = [0.0; 3];

/// What was written, exactly.
pub(super) fn widened(a: Vector) -> WideVector {
    a.map(Wide::from)
}

/// The nearest in f64.
pub(super) fn narrowed<T: Real>(a: [T; 3]) -> Vector {
    a.map(Real::narrow)
}

pub(super) fn add<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(super) fn subtract<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Component by component, as light and reflectance multiply.
pub(super) fn multiply<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

pub(super) fn scale<T: Real>(a: [T; 3], factor: T) -> [T; 3] {
    a.map(|component| component * factor)
}

pub(super) fn negate<T: Real>(a: [T; 3]) -> [T; 3] {
    a.map(|component| -component)
}

pub(super) fn dot<T: Real>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub(super) fn length<T: Real>(a: [T; 3]) -> T {
    dot(a, a).sqrt()
}

/// The vector at unit length, or `None` where it has no direction (zero, infinite or NaN).
///
/// Scaled by its largest component first, so that squares neither underflow nor overflow.
pub(super) fn unit<T: Real>(a: [T; 3]) -> Option<[T; 3]> {
    let [x, y, z] = narrowed(a).map(f64::abs);
    let largest = x.max(y).max(z);
    if largest == 0.0 || !(x + y + z).is_finite() {
        return None;
    }
    let scaled = a.map(|component| component / T::from(largest));
    Some(scale(scaled, T::from(1.0) / length(scaled)))
}
