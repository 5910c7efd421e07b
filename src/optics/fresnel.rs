//! How much a smooth boundary reflects (Fresnel 1823).

/// c_t = √(1 − (1 − c²)/η²), the cosine of the refracted direction; `None` at total reflection.
///
/// `cos_incident` is in 0..=1, η = n_t/n_i above zero, and so is the result in 0..=1. It is g/η of [`dielectric`], which
/// loses no digits at grazing incidence where η is near 1.
pub(crate) fn cos_transmitted(cos_incident: f64, eta: f64) -> Option<f64> {
    Some((scaled_cosine(cos_incident, eta)? / eta).min(1.0))
}

/// g = η c_t = √((η − 1)(η + 1) + c²); `None` where g² is below zero: total reflection.
#[inline]
fn scaled_cosine(cos_incident: f64, eta: f64) -> Option<f64> {
    let square = (eta - 1.0) * (eta + 1.0) + cos_incident * cos_incident;
    (square >= 0.0).then(|| square.sqrt())
}

/// F = ½ (r⊥² + r∥²) with r⊥ = (c − η c_t)/(c + η c_t) and r∥ = (η c − c_t)/(η c + c_t): the part of unpolarized light
/// that the boundary between two dielectrics reflects; 1 at total reflection. 1 − F passes.
///
/// `cos_incident` is in 0..=1, η = n_t/n_i above zero. F is in 0..=1: 0 at η = 1, else 1 at grazing incidence, and
/// ((η − 1)/(η + 1))² along the normal. It has all its digits but a few last ones, where F is near 0 too; just below the
/// critical angle, where its slope is infinite, only as many as g² = (η² − 1) + c² has.
#[inline]
pub(crate) fn dielectric(cos_incident: f64, eta: f64) -> f64 {
    let Some(scaled) = scaled_cosine(cos_incident, eta) else {
        return 1.0;
    };
    unpolarized(cos_incident, [scaled, 0.0], distance_from_one(eta, 0.0))
}

/// F = ½ (|r⊥|² + |r∥|²) of the boundary from a dielectric to a metal of index η = n + i k, both relative to the
/// dielectric: [`dielectric`] in complex numbers.
///
/// With s² = 1 − c² and a + i b = √(η² − s²),
///
/// a² − b² = n² − k² − s², a b = n k, |r⊥|² = ((a − c)² + b²)/((a + c)² + b²),
/// |r∥|² = |r⊥|² ((c a − s²)² + c² b²)/((c a + s²)² + c² b²).
///
/// `cos_incident` is in 0..=1; n and k are not below zero, not both zero, and below 1e70. F is in 0..=1, 1 at grazing
/// incidence. Where k = 0 it has the bits of `dielectric(cos_incident, n)`, at total reflection too.
#[inline]
pub(crate) fn conductor(cos_incident: f64, n: f64, k: f64) -> f64 {
    let real = (n - 1.0) * (n + 1.0) + cos_incident * cos_incident - k * k;
    let half_imaginary = n * k;
    let modulus = (real * real + 4.0 * half_imaginary * half_imaginary).sqrt();
    // The larger part by its root, the smaller by a b = n k: neither cancels.
    let root = ((modulus + real.abs()) * 0.5).sqrt();
    let other = if root > 0.0 {
        half_imaginary / root
    } else {
        0.0
    };
    let scaled = if real >= 0.0 {
        [root, other]
    } else {
        [other, root]
    };
    unpolarized(cos_incident, scaled, distance_from_one(n, k))
}

/// |η² − 1|² = |η − 1|² |η + 1|² of η = n + i k.
#[inline]
fn distance_from_one(n: f64, k: f64) -> f64 {
    ((n - 1.0) * (n - 1.0) + k * k) * ((n + 1.0) * (n + 1.0) + k * k)
}

/// F of a + i b = √(η² − s²) and w = |η² − 1|².
///
/// (a + i b)² − c² = η² − 1, so |a + i b − c|² = w/q with q = |a + i b + c|² = |a + i b − c|² + 4 a c, and
///
/// |r⊥|² = w/(w + 4 a c q), |r∥|² = |r⊥|² m/(m + 4 a c s²), m = |c (a + i b) − s²|².
///
/// Nothing cancels but in m, which is 0 at Brewster's angle, and no quotient is above 1.
#[inline]
fn unpolarized(c: f64, [a, b]: [f64; 2], w: f64) -> f64 {
    if w == 0.0 {
        return 0.0;
    }
    let sine_squared = (1.0 - c) * (1.0 + c);
    let cosines = 4.0 * a * c;
    let sum = a + c;
    let perpendicular = w / (w + cosines * (sum * sum + b * b));
    let along = c * a - sine_squared;
    let across = c * b;
    let m = along * along + across * across;
    let parallel_to_it = m / (m + cosines * sine_squared);
    0.5 * perpendicular * (1.0 + parallel_to_it)
}

/// [R, T] of a thin pane, both of its faces and all inner reflections summed: R = 2 F/(1 + F), T = (1 − F)/(1 + F) with
/// F = [`dielectric`]`(cos_incident, n)`, without absorption or interference (Stokes 1862).
///
/// F is the mean of both polarizations, and inner reflections have it too, as if each began unpolarized. A real pane
/// keeps them apart, ½ Σ 2 r²/(1 + r²): its R is less, for n = 1.5 by up to 0.0222, at 74°.
///
/// n is the index of the pane over that of what is around it. Both numbers are in 0..=1, R + T = 1 to the last digit,
/// and what is transmitted keeps its direction.
#[inline]
pub(crate) fn pane(cos_incident: f64, n: f64) -> [f64; 2] {
    let face = dielectric(cos_incident, n);
    [2.0 * face / (1.0 + face), (1.0 - face) / (1.0 + face)]
}

/// R₀ + (1 − R₀)(1 − c)⁵: a metal whose reflectance along the normal is R₀, approximately (Schlick 1994).
///
/// R₀ and `cos_incident` are in 0..=1, and so is the result: R₀ along the normal, 1 at grazing incidence.
#[inline]
pub(crate) fn schlick(r0: f64, cos_incident: f64) -> f64 {
    let x = 1.0 - cos_incident;
    let square = x * x;
    r0 + (1.0 - r0) * (square * square * x)
}
