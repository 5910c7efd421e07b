//! Integrals over what is seen of a planar polygon, from its corners as they are seen from a point.
//!
//! Of corners, see [`clip`](super::clip). Nothing is allocated; the polygon is cut by the horizon edge by edge.

use super::clip::for_each_edge;
use super::gauss;
use super::lambert::half_edge;
use super::lobe::{Integrand, is_small, power};
use crate::math::DVec3;

/// Polygons whose angle in radians is below this are integrated over their area: what four points say of them is
/// then exact to the last digits.
const SMALL: f64 = 1e-2;

/// Φ(n) = ∫ max(0, n·u) dω in sr, from 0 to π: the irradiance per unit of radiance (Lambert 1760; Baum, Rushmeier &
/// Winget 1989): ½ Σ Θᵢ n·mᵢ over the edges of what is above the horizon, Θᵢ the angle of an edge, mᵢ the unit
/// normal of the plane through it and the point. `normal` is of unit length.
///
/// Off by 3e-15 at most, and by 1e-13 of the result where the polygon is narrow and above the horizon. A point in
/// the polygon's plane sees 0 of it from outside; from inside, and on an edge, what is on one of the two sides.
pub(crate) fn irradiance(corners: &[DVec3], normal: DVec3) -> f64 {
    if reach(corners) < SMALL && corners.iter().all(|corner| normal.dot(*corner) >= 0.0) {
        return over_small(corners, |u| normal.dot(u));
    }
    let mut total = 0.0;
    for_each_edge(corners, normal, |from, to| {
        total += half_edge(normal, from, to);
    });
    total.abs()
}

/// τⁿ(w) = ∫ max(0, w·u)ⁿ dω in sr, from 0 to 2π/(n+1), of a polygon that the horizon has cut already; w of unit
/// length, n from 0 to 1e9. It is exact to 3e-12 of 2π/(n+1).
pub(crate) fn lobe(corners: &[DVec3], w: DVec3, exponent: f64) -> f64 {
    let integrand = Integrand::lobe(w, exponent);
    if is_small(reach(corners), &integrand) && corners.iter().all(|corner| w.dot(*corner) > 0.0) {
        return over_small(corners, |u| power(w, u, exponent));
    }
    boundary(corners, w, &integrand) / (exponent + 1.0)
}

/// ∫ max(0, w·u)ⁿ v·u dω in sr, from 0 to 2π/(n+2), of a polygon that v's horizon has cut already, as [`lobe`]. It
/// is exact to 3e-12 of 2π/(n+2).
pub(crate) fn cosine_lobe(corners: &[DVec3], w: DVec3, v: DVec3, exponent: f64) -> f64 {
    let integrand = Integrand::cosine_lobe(w, v, exponent);
    if is_small(reach(corners), &integrand) && corners.iter().all(|corner| w.dot(*corner) > 0.0) {
        return over_small(corners, |u| power(w, u, exponent) * v.dot(u)).max(0.0);
    }
    boundary(corners, w, &integrand) / (exponent + 2.0)
}

/// The sum over the edges of what is on w's side.
fn boundary(corners: &[DVec3], w: DVec3, integrand: &Integrand) -> f64 {
    // Most points are far from the lobe's edge: then there is all of it, or nothing.
    if let Some(winding) = integrand.whole(corners) {
        return winding;
    }
    let mut total = 0.0;
    for_each_edge(corners, w, |from, to| total += integrand.edge(from, to));
    total.abs()
}

/// The solid angle of a polygon, in sr, from 0 to 2π: the sum of those of the triangles around a corner (van
/// Oosterom & Strackee 1983). A point in its plane sees 0 of it, or, inside of it, 2π or 0 as it is rounded.
pub(crate) fn solid_angle(corners: &[DVec3]) -> f64 {
    let mut total = 0.0;
    for_each_triangle(corners, |[first, b, c]| {
        let volume = first.dot((b - first).cross(c - first));
        let first_length = first.length();
        let [b_length, c_length] = [b.length(), c.length()];
        let around = first_length * b_length * c_length
            + first.dot(b) * c_length
            + first.dot(c) * b_length
            + b.dot(c) * first_length;
        total += 2.0 * libm::atan2(volume, around);
    });
    total.abs()
}

/// The triangles around the first corner.
fn for_each_triangle(corners: &[DVec3], mut take: impl FnMut([DVec3; 3])) {
    if let [first, rest @ ..] = corners {
        for pair in rest.windows(2) {
            take([*first, pair[0], pair[1]]);
        }
    }
}

/// How far a polygon reaches from its first corner, over the distance of that: about its angle in radians where it
/// is small.
fn reach(corners: &[DVec3]) -> f64 {
    let [first, rest @ ..] = corners else {
        return 0.0;
    };
    let squares = rest
        .iter()
        .map(|&corner| (corner - *first).length_squared());
    let largest = squares.fold(0.0, f64::max);
    (largest / first.length_squared()).sqrt()
}

/// ∫ f(x) dω over a polygon that is so small that f and 1/|x|² hardly bend over it, x of unit length: products of
/// Gauss–Legendre rules of four points over the triangles around a corner. Boundary integrals lose, of what is
/// small, as many digits as its angle has zeros; this does not.
fn over_small(corners: &[DVec3], f: impl Fn(DVec3) -> f64) -> f64 {
    let half = gauss::half_rule(4);
    let mut rule = [[0.0; 2]; 4];
    for (place, &[x, weight]) in half.iter().enumerate() {
        rule[2 * place] = [0.5 - 0.5 * x, 0.5 * weight];
        rule[2 * place + 1] = [0.5 + 0.5 * x, 0.5 * weight];
    }
    let mut total = 0.0;
    for_each_triangle(corners, |[first, b, c]| {
        let scale = 1.0 / first.length();
        let unit = first * scale;
        let [b, c] = [b, c].map(|corner| (corner - first) * scale);
        let volume = unit.dot(b.cross(c));
        let mut sum = 0.0;
        for [s, weight] in rule {
            for [t, other] in rule {
                // The triangle as a square of which one side is one corner.
                let place = unit + (b * (1.0 - t) + c * t) * s;
                let inverse = 1.0 / place.length();
                sum += weight * other * s * (inverse * inverse * inverse) * f(place * inverse);
            }
        }
        total += volume * sum;
    });
    total.abs()
}
