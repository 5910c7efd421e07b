//! ½ n · ∮ u × du: the pieces of the boundary that Lambert's irradiance (1760) is the sum of.

use super::clip::across;
use crate::math::DVec3;

/// ½ Θ n·m of the straight edge between two vectors, Θ its angle, m the unit normal of the plane through it and the
/// point; 0 where it has no length or passes through the point.
#[inline(always)]
pub(super) fn half_edge(normal: DVec3, from: DVec3, to: DVec3) -> f64 {
    let cross = across(from, to);
    let sine = cross.length();
    if sine > 0.0 {
        0.5 * libm::atan2(sine, from.dot(to)) * (normal.dot(cross) / sine)
    } else {
        0.0
    }
}

/// ½ ∫ n · (u × du) along an arc of the outline, `normal` in the frame.
///
/// n · (g × g′) = n₃ b d − n₁ a d cos t − n₂ a b sin t, and each of the three over |g|² has a closed form.
pub(super) fn half_arc(radii: [f64; 3], normal: DVec3, [from, to]: [f64; 2]) -> f64 {
    use std::f64::consts::{PI, TAU};
    let [b, d, a] = radii;
    let [along_e1, along_e2] = [a * a + b * b, a * a + d * d];
    let root = (along_e1 * along_e2).sqrt();
    let turn = to - from;
    if turn >= TAU {
        return PI * normal.z * b * d / root;
    }
    let [(sin_from, cos_from), (sin_to, cos_to)] = [from, to].map(libm::sincos);
    // ∫ dt/|g|²: the angle between both ends once the second axis is stretched, which keeps half turns.
    let stretch = (along_e2 / along_e1).sqrt();
    let x = cos_from * cos_to + stretch * stretch * sin_from * sin_to;
    let y = stretch * libm::sin(turn);
    let angle = libm::atan2(y, x);
    let angle = if turn < PI {
        angle.max(0.0)
    } else if angle < 0.0 {
        angle + TAU
    } else {
        angle
    };
    // Differences of sines and cosines by their halves.
    let (sin_middle, cos_middle) = libm::sincos(0.5 * (from + to));
    let twice = 2.0 * libm::sin(0.5 * turn);
    let difference = (d - b) * (d + b);
    let of_cosine = inverse_quadratic(along_e1, difference, [sin_from, sin_to], twice * cos_middle);
    let of_sine = inverse_quadratic(
        along_e2,
        -difference,
        [cos_from, cos_to],
        twice * sin_middle,
    );
    0.5 * (normal.z * b * d * (angle / root)
        - a * (normal.x * d * of_cosine + normal.y * b * of_sine))
}

/// ∫ ds/(p + k s²) from s₀ to s₁, of which the difference is s₁ − s₀, for p + k s² above 0.
fn inverse_quadratic(p: f64, k: f64, [from, to]: [f64; 2], difference: f64) -> f64 {
    let denominator = p + k * from * to;
    let square = p * k * difference * difference;
    // The tangent, or the hyperbolic one, of what the arctangents differ by, times √(p k).
    if square.abs() < 1e-6 * denominator * denominator && denominator > 0.0 {
        let x = square / (denominator * denominator);
        return difference / denominator * (1.0 - x / 3.0 * (1.0 - x * 0.6));
    }
    let root = (p * k.abs()).sqrt();
    if k > 0.0 {
        libm::atan2(root * difference, denominator) / root
    } else {
        libm::atanh(root * difference / denominator) / root
    }
}
