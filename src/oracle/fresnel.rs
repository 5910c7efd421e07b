//! Perfectly smooth boundaries: how much of the light each reflects, and where the rest goes.
//!
//! Light is unpolarized: F is the mean of both polarizations, and each boundary starts anew.

use super::vector::{WideVector, add, scale};
use super::wide::{Real, Wide};

/// c_t = √(1 − (1 − c²)/η²), the cosine of the refracted direction (Snell's law); `None` at total reflection.
pub(super) fn cos_refracted(c: Wide, eta: Wide) -> Option<Wide> {
    let one = Wide::from(1.0);
    let squared = one - (one - c) * (one + c) / (eta * eta);
    (squared >= Wide::from(0.0)).then(|| squared.sqrt())
}

/// F = ½ (r∥² + r⊥²), r∥ = (η c − c_t)/(η c + c_t), r⊥ = (c − η c_t)/(c + η c_t), with η = n_t/n_i (Fresnel 1823);
/// 1 at total reflection.
pub(super) fn dielectric(c: Wide, eta: Wide) -> Wide {
    let one = Wide::from(1.0);
    if eta == one {
        return Wide::from(0.0);
    }
    let Some(c_t) = cos_refracted(c, eta) else {
        return one;
    };
    let parallel = (eta * c - c_t) / (eta * c + c_t);
    let across = (c - eta * c_t) / (c + eta * c_t);
    (parallel * parallel + across * across) * Wide::from(0.5)
}

/// The same with a complex η = n + ik: r⊥ = (c − q)/(c + q), r∥ = (η² c − q)/(η² c + q), q = √(η² − 1 + c²).
pub(super) fn conductor(c: f64, n: f64, k: f64) -> f64 {
    if n == 1.0 && k == 0.0 {
        return 0.0;
    }
    let square = [(n - k) * (n + k), 2.0 * n * k];
    let q = complex_root([square[0] - (1.0 - c) * (1.0 + c), square[1]]);
    let reflected = |[a, b]: [f64; 2]| {
        let squared = |re: f64, im: f64| re * re + im * im;
        squared(a - q[0], b - q[1]) / squared(a + q[0], b + q[1])
    };
    let both = reflected([c, 0.0]) + reflected(square.map(|part| part * c));
    // Of n = k = 0 nothing goes in.
    if both.is_nan() { 1.0 } else { 0.5 * both }
}

/// √(x + iy) with y ≥ 0: the larger part by a root, the other by 2 a b = y.
fn complex_root([x, y]: [f64; 2]) -> [f64; 2] {
    let larger = ((x.hypot(y) + x.abs()) / 2.0).sqrt();
    let other = if larger > 0.0 {
        y / (2.0 * larger)
    } else {
        0.0
    };
    if x >= 0.0 {
        [larger, other]
    } else {
        [other, larger]
    }
}

/// R = 2F/(1 + F) and T = (1 − F)/(1 + F) of a thin pane: both faces, and all that goes to and fro between them.
pub(super) fn pane(c: Wide, n: f64) -> [f64; 2] {
    let one = Wide::from(1.0);
    let face = dielectric(c, Wide::from(n));
    [Wide::from(2.0) * face, one - face].map(|part| (part / (one + face)).narrow())
}

/// R + (1 − R)(1 − c)⁵ (Schlick 1994).
pub(super) fn schlick(reflectance: f64, c: f64) -> f64 {
    reflectance + (1.0 - reflectance) * (1.0 - c).powi(5)
}

/// t = d/η + (c/η − c_t) n, with n on the side that d comes from and c = −n·d.
pub(super) fn refracted(
    d: WideVector,
    n: WideVector,
    eta: Wide,
    [c, c_t]: [Wide; 2],
) -> WideVector {
    add(scale(d, Wide::from(1.0) / eta), scale(n, c / eta - c_t))
}
