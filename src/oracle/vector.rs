//! The few operations on three f64 that the equations need.
//!
//! The oracle has its own, so that a mistake in the renderer's vectors cannot hide here as well.

/// Three coordinates or components; also a linear RGB triple.
pub(super) type Vector = [f64; 3];

pub(super) const ZERO: Vector = [0.0; 3];

pub(super) fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(super) fn subtract(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Component by component, as light and reflectance multiply.
pub(super) fn multiply(a: Vector, b: Vector) -> Vector {
    [a[0] * b[0], a[1] * b[1], a[2] * b[2]]
}

pub(super) fn scale(a: Vector, factor: f64) -> Vector {
    a.map(|component| component * factor)
}

pub(super) fn negate(a: Vector) -> Vector {
    a.map(|component| -component)
}

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Vector, b: Vector) -> Vector {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub(super) fn length(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// The vector at unit length, or `None` where it has no direction (zero, infinite or NaN).
///
/// Scaled by its largest component first, so that squares neither underflow nor overflow.
pub(super) fn unit(a: Vector) -> Option<Vector> {
    let largest = a[0].abs().max(a[1].abs()).max(a[2].abs());
    if largest == 0.0 || !a.iter().all(|component| component.is_finite()) {
        return None;
    }
    let scaled = a.map(|component| component / largest);
    Some(scale(scaled, 1.0 / length(scaled)))
}
