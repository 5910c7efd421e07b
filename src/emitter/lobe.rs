//! ∫ (w·u)ⁿ dω and ∫ (w·u)ⁿ (v·u) dω by what they are on the boundary (Stokes; Arvo 1995, "Applications of
//! irradiance tensors to the simulation of non-Lambertian phenomena", for whole n; here for any).
//!
//! With c = w·u, φ the azimuth about w, so that dφ = w·(u × du)/(1 − c²):
//!
//! (n+1) ∫ cⁿ dω = ∮ (1 − cⁿ⁺¹) dφ
//!
//! (n+2) ∫ cⁿ (v·u) dω = (w·v) ∮ (1 − cⁿ) dφ + ∮ cⁿ v·(u × du)
//!
//! Both are ∮ α S w·(u × du) + cᵏ v·(u × du), where S = (1 − cᵏ)/(1 − c²). S has no pole where c is 1: however
//! close to w the boundary passes, it bends no more than cᵏ does, over 1/√k rad, and Gauss–Legendre's points need
//! know nothing else. Where cᵏ is below [`NEGLIGIBLE`] what is left is α dφ, which is α times a difference of
//! azimuths.

use super::clip::{across, for_each_edge};
use super::gauss;
use super::power::{Power, any};
use crate::math::DVec3;

/// The natural logarithm of cᵏ that is left out: 7e-13 of what it is on w.
const NEGLIGIBLE: f64 = -28.0;

/// By how many 1/√k at most half a span is wide for each rule to be exact to 1e-12 of a full lobe, wherever w is.
const WIDTHS: [(usize, f64); 6] = [
    (4, 0.2),
    (8, 0.9),
    (12, 2.0),
    (16, 3.4),
    (24, 5.8),
    (32, WIDEST_LOBE),
];

/// The widest of these.
const WIDEST_LOBE: f64 = 8.0;

/// tan(π/8): wider spans of a great circle are halved.
const WIDEST: f64 = 0.414_213_562_373_095_03;

/// Powers that are not whole and below this bend where c is 0; spans are graded towards there.
const SMOOTH: f64 = 16.0;

/// What a span takes that is as far from where c is 0 as it is long.
const GRADED: usize = 12;

/// Nothing is halved any more that is so short, in radians.
const SHORTEST: f64 = 1e-15;

/// Light that is seen over a smaller angle in radians is integrated over its area, where the lobe is wide besides:
/// of the result, integrals along the boundary lose as many digits as that angle has zeros.
const SMALL: f64 = 1e-3;

/// How wide the lobe is then at least, by how many times the light's angle is 1/√k.
const SMALL_BEND: f64 = 0.2;

/// Whether light whose angle in radians is about `reach` is integrated over its area.
pub(super) fn is_small(reach: f64, integrand: &Integrand) -> bool {
    reach < SMALL && reach * integrand.root < SMALL_BEND
}

/// max(0, w·u)ⁿ of unit vectors.
pub(super) fn power(w: DVec3, u: DVec3, exponent: f64) -> f64 {
    let [power, _] = any(exponent, w.dot(u), w.cross(u).length_squared().min(1.0));
    power
}

/// What is integrated along the boundary.
#[derive(Clone, Copy, Debug)]
pub(super) struct Integrand {
    /// Of unit length.
    w: DVec3,
    v: DVec3,
    /// α
    azimuth: f64,
    power: Power,
    /// √k
    root: f64,
    /// The squared sine of the angle to w beyond which cᵏ is negligible, and the cosine.
    window: f64,
    window_cosine: f64,
    /// Twice the sine of half that angle.
    window_chord: f64,
    /// Half of a span so short that nothing is lost where c is 0 in it.
    least: f64,
}

/// A great circle about a point of it: w and v there, along it, and across.
#[derive(Clone, Copy)]
struct Circle {
    w: [f64; 3],
    /// v across.
    v: f64,
}

/// Where c is 0: two turns of the outline, and how far beside the real axis.
#[derive(Clone, Copy)]
struct Zeros([f64; 2], f64);

impl Zeros {
    fn distance(self, turn: f64) -> f64 {
        use std::f64::consts::{PI, TAU};
        let Self(places, beside) = self;
        let along = places.map(|place| {
            let apart = (turn - place).abs() % TAU;
            PI - (PI - apart).abs()
        });
        libm::hypot(along[0].min(along[1]), beside)
    }
}

impl Integrand {
    /// (n+1) (w·u)ⁿ
    pub(super) fn lobe(w: DVec3, exponent: f64) -> Self {
        Self::new(w, DVec3::ZERO, 1.0, exponent + 1.0)
    }

    /// (n+2) (w·u)ⁿ (v·u)
    pub(super) fn cosine_lobe(w: DVec3, v: DVec3, exponent: f64) -> Self {
        Self::new(w, v, w.dot(v), exponent)
    }

    fn new(w: DVec3, v: DVec3, azimuth: f64, exponent: f64) -> Self {
        let power = Power::new(exponent);
        let window = -libm::expm1(2.0 * NEGLIGIBLE / exponent);
        let window_cosine = libm::exp(NEGLIGIBLE / exponent);
        Self {
            w,
            v,
            azimuth,
            power,
            root: exponent.sqrt(),
            window,
            window_cosine,
            // sin² = (1 − cos)(1 + cos), and 4 sin² of the half is 2 (1 − cos).
            window_chord: (2.0 * window / (1.0 + window_cosine)).sqrt(),
            least: match power {
                Power::Any(exponent) if exponent < SMOOTH => libm::exp(-33.0 / (1.0 + exponent)),
                Power::Any(_) | Power::Whole(_) => 0.0,
            },
        }
    }

    /// Of a polygon no edge of which is within the window, the integral over its boundary: α times its winding
    /// about w. `None` where one may be.
    pub(super) fn whole(&self, corners: &[DVec3]) -> Option<f64> {
        if self.window > 0.98 {
            return None;
        }
        let [x, y, z] = self.w.to_array();
        // Any half-plane from w will do to count who passes it.
        let half_plane = if x.abs() < 0.7 {
            DVec3::new(0.0, z, -y)
        } else {
            DVec3::new(-z, 0.0, x)
        };
        let (mut winding, mut is_near) = (0.0, false);
        for_each_edge(corners, self.w, |from, to| {
            let cross = across(from, to);
            let height = self.w.dot(cross);
            if height * height < self.window * cross.length_squared() {
                let is_within = |corner: DVec3| {
                    self.w.cross(corner).length_squared() < self.window * corner.length_squared()
                };
                let is_foot_between =
                    self.w.dot(cross.cross(from)) > 0.0 && self.w.dot(cross.cross(to)) < 0.0;
                is_near |= is_foot_between || is_within(from) || is_within(to);
            }
            let is_above = [half_plane.dot(from) > 0.0, half_plane.dot(to) > 0.0];
            if is_above == [false, true] && height > 0.0 {
                winding += 1.0;
            } else if is_above == [true, false] && height < 0.0 {
                winding -= 1.0;
            }
        });
        (!is_near).then(|| f64::abs(std::f64::consts::TAU * winding * self.azimuth))
    }

    /// α times the angle about w from one direction to another, less than half a turn.
    fn turned(&self, from: DVec3, to: DVec3) -> f64 {
        let sine = self.w.dot(across(from, to));
        let cosine = self.w.cross(from).dot(self.w.cross(to));
        self.azimuth * libm::atan2(sine, cosine)
    }

    /// Along the straight edge between two vectors, where c is at least 0.
    pub(super) fn edge(&self, from: DVec3, to: DVec3) -> f64 {
        let cross = across(from, to);
        let sine = cross.length();
        if sine == 0.0 {
            // No length, or through the point itself, where it has no side.
            return 0.0;
        }
        let side = cross / sine;
        let w3 = self.w.dot(side);
        if !w3.is_finite() {
            return 0.0;
        }
        if w3 * w3 >= self.window {
            return self.turned(from, to);
        }
        let cosine = from.dot(to);
        let [from_length, to_length] = [from.length(), to.length()];
        let product = from_length * to_length;
        // tan of half and of a quarter of the angle.
        let half = if cosine > 0.0 {
            sine / (product + cosine)
        } else {
            (product - cosine) / sine
        };
        let quarter = half / (1.0 + (1.0 + half * half).sqrt());
        let middle = if cosine > 0.0 {
            from * to_length + to * from_length
        } else {
            (to * from_length - from * to_length).cross(side)
        };
        let middle = middle / middle.length();
        let along = side.cross(middle);
        let circle = Circle {
            w: [self.w.dot(middle), self.w.dot(along), w3],
            v: self.v.dot(side),
        };
        let [start, end] = [-quarter, quarter].map(|r| circle.squared_sine(r));
        if start < self.window && end < self.window {
            if quarter <= WIDEST && 2.0 * quarter * self.root <= WIDEST_LOBE && self.least == 0.0 {
                return self.span(&circle, quarter);
            }
            let half = 2.0 * libm::atan(quarter);
            return self.spans(&circle, [-half, half]);
        }
        let half = 2.0 * libm::atan(quarter);
        self.near_edge(&circle, half)
    }

    /// Of an edge some of which is beyond the window: its part within, and the azimuths of the others.
    fn near_edge(&self, circle: &Circle, half: f64) -> f64 {
        let [w1, w2, w3] = circle.w;
        let c = libm::hypot(w1, w2);
        let foot = libm::atan2(w2, w1);
        let width = if self.window > 0.5 {
            libm::acos((self.window_cosine / c).min(1.0))
        } else {
            let sine = (self.window - w3 * w3).max(0.0).sqrt() / c;
            libm::asin(sine.min(1.0))
        };
        let [start, end] = [-half, half];
        let from = (foot - width).max(start).min(end);
        let to = (foot + width).max(start).min(end);
        // tan φ = sin τ / (w₃ cos τ) from the foot on.
        let turned = |from: f64, to: f64| {
            let [(sin_from, cos_from), (sin_to, cos_to)] =
                [from - foot, to - foot].map(libm::sincos);
            let cosine = sin_from * sin_to + w3 * w3 * cos_from * cos_to;
            libm::atan2(w3 * libm::sin(to - from), cosine)
        };
        if from >= to {
            return self.azimuth * turned(start, end);
        }
        let mut total = self.spans(circle, [from, to]);
        if from > start {
            total += self.azimuth * turned(start, from);
        }
        if to < end {
            total += self.azimuth * turned(to, end);
        }
        total
    }

    /// Along a great circle from one angle to another, in as many spans as it takes.
    fn spans(&self, circle: &Circle, [from, to]: [f64; 2]) -> f64 {
        let half = 0.5 * (to - from);
        let middle = from + half;
        let turned = circle.turned(middle);
        let quarter = libm::tan(0.5 * half);
        let is_narrow = quarter <= WIDEST && half * self.root <= WIDEST_LOBE;
        if half <= SHORTEST || is_narrow && (half <= self.least || self.is_apart(&turned, half)) {
            return self.span(&turned, quarter);
        }
        self.spans(circle, [from, middle]) + self.spans(circle, [middle, to])
    }

    /// Whether c is 0 no closer to a span than it is long.
    fn is_apart(&self, circle: &Circle, half: f64) -> bool {
        if self.least == 0.0 {
            return true;
        }
        let [w1, w2, _] = circle.w;
        let (sin, cos) = libm::sincos((3.0 * half).min(std::f64::consts::FRAC_PI_2));
        // c as far from the middle as three halves of the span.
        w1 * cos >= w2.abs() * sin || w1 * cos <= -w2.abs() * sin
    }

    /// Along a great circle, as far from its point to both sides as r = tan(τ/2) says. With r for τ sines and
    /// cosines are rational.
    fn span(&self, circle: &Circle, quarter: f64) -> f64 {
        let least = if self.least > 0.0 {
            GRADED
        } else {
            least_points(quarter)
        };
        let count = points(2.0 * quarter * self.root).max(least);
        self.span_by(gauss::half_rule(count), circle, quarter)
    }

    #[inline(always)]
    fn span_by(&self, rule: &[[f64; 2]], circle: &Circle, quarter: f64) -> f64 {
        let [w1, w2, w3] = circle.w;
        let around = self.azimuth * w3;
        let mut total = 0.0;
        for pair in rule.chunks_exact(2) {
            let [[x0, g0], [x1, g1]] = [pair[0], pair[1]];
            let weights = [g0, g0, g1, g1];
            let places = [x0, -x0, x1, -x1];
            let (mut cosines, mut squares) = ([0.0; 4], [0.0; 4]);
            let mut widths = [0.0; 4];
            for lane in 0..4 {
                let r = quarter * places[lane];
                let inverse = 1.0 / (1.0 + r * r);
                let cos = (1.0 - r * r) * inverse;
                let sin = 2.0 * r * inverse;
                let across = w1 * sin - w2 * cos;
                cosines[lane] = (w1 * cos + w2 * sin).max(0.0);
                squares[lane] = w3 * w3 + across * across;
                widths[lane] = weights[lane] * inverse;
            }
            let [powers, quotients] = self.power.of(cosines, squares);
            for lane in 0..4 {
                total += widths[lane] * (around * quotients[lane] + circle.v * powers[lane]);
            }
        }
        2.0 * quarter * total
    }

    /// Along an arc of an ellipse whose frame is that of w and v, where c is at least 0.
    pub(super) fn arc(&self, radii: [f64; 3], turns: [f64; 2]) -> f64 {
        let [b, d, a] = radii;
        let w = self.w * DVec3::new(b, d, a);
        if !w.is_finite() {
            return 0.0;
        }
        // c |g| = w₃ a + w₁ b cos t + w₂ d sin t, which is 0 at these, or as far beside the real axis.
        let length = libm::hypot(w.x, w.y);
        let middle = libm::atan2(w.y, w.x);
        let zeros = if length > w.z.abs() {
            let half = libm::acos(-w.z / length);
            Zeros([middle - half, middle + half], 0.0)
        } else {
            let beside = if length > 0.0 {
                libm::acosh(w.z.abs() / length)
            } else {
                f64::INFINITY
            };
            Zeros([middle + std::f64::consts::PI; 2], beside)
        };
        self.arcs(radii, turns, zeros)
    }

    /// In as many arcs as it takes.
    fn arcs(&self, radii: [f64; 3], [from, to]: [f64; 2], zeros: Zeros) -> f64 {
        let [b, d, a] = radii;
        let at = |t: f64| {
            let (sin, cos) = libm::sincos(t);
            DVec3::new(b * cos, d * sin, a)
        };
        let half = 0.5 * (to - from);
        let middle = from + half;
        let place = at(middle);
        let length = place.length();
        // No angle from the middle to either end is larger than the width.
        let width = half * b.max(d) / length;
        if width <= 0.5 {
            let width = width / (1.0 - width);
            let apart = (place / length - self.w).length();
            if apart - width >= self.window_chord && apart > 2.0 * width {
                return self.turned(at(from), at(to));
            }
            let is_narrow = half <= 0.8 && width * self.root <= WIDEST_LOBE;
            let is_smooth = half <= self.least || zeros.distance(middle) >= 3.0 * half;
            if is_narrow && (self.least == 0.0 || is_smooth) {
                return self.arc_span(radii, middle, half, width);
            }
        }
        if half > SHORTEST {
            let halves = [[from, middle], [middle, to]];
            return halves
                .map(|turns| self.arcs(radii, turns, zeros))
                .iter()
                .sum();
        }
        0.0
    }

    fn arc_span(&self, [b, d, a]: [f64; 3], middle: f64, half: f64, width: f64) -> f64 {
        let rule = gauss::half_rule(points(width * self.root).max(GRADED));
        let (sin_middle, cos_middle) = libm::sincos(middle);
        let mut total = 0.0;
        for pair in rule.chunks_exact(2) {
            let (mut cosines, mut squares) = ([0.0; 4], [0.0; 4]);
            let (mut turns, mut sides) = ([0.0; 4], [0.0; 4]);
            for (place, &[x, weight]) in pair.iter().enumerate() {
                let (sin, cos) = libm::sincos(half * x);
                for (side, sin) in [sin, -sin].into_iter().enumerate() {
                    let lane = 2 * place + side;
                    let cos_t = cos_middle * cos - sin_middle * sin;
                    let sin_t = sin_middle * cos + cos_middle * sin;
                    let g = DVec3::new(b * cos_t, d * sin_t, a);
                    let normal = DVec3::new(-a * d * cos_t, -a * b * sin_t, b * d);
                    let inverse = 1.0 / g.length_squared();
                    cosines[lane] = (self.w.dot(g) * inverse.sqrt()).max(0.0);
                    squares[lane] = (self.w.cross(g).length_squared() * inverse).min(1.0);
                    turns[lane] = weight * inverse * self.w.dot(normal);
                    sides[lane] = weight * inverse * self.v.dot(normal);
                }
            }
            let [powers, quotients] = self.power.of(cosines, squares);
            for lane in 0..4 {
                total += self.azimuth * turns[lane] * quotients[lane] + sides[lane] * powers[lane];
            }
        }
        half * total
    }
}

/// How many points a span takes of which half is so many 1/√k wide.
fn points(width: f64) -> usize {
    let rule = WIDTHS.iter().find(|(_, widest)| width <= *widest);
    rule.map_or(32, |(count, _)| *count)
}

/// How many points it takes for 1/(1 + r²), whose poles are at ±i.
fn least_points(quarter: f64) -> usize {
    if quarter < 0.045 {
        4
    } else if quarter < 0.3 {
        8
    } else {
        12
    }
}

impl Circle {
    /// About a point further along.
    fn turned(&self, angle: f64) -> Self {
        let [w1, w2, w3] = self.w;
        let (sin, cos) = libm::sincos(angle);
        Self {
            w: [w1 * cos + w2 * sin, w2 * cos - w1 * sin, w3],
            v: self.v,
        }
    }

    /// Of the angle between w and the direction at τ, of which r is tan(τ/2).
    fn squared_sine(&self, r: f64) -> f64 {
        let [w1, w2, w3] = self.w;
        let across = (w1 * 2.0 * r - w2 * (1.0 - r * r)) / (1.0 + r * r);
        w3 * w3 + across * across
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each rule at its widest, wherever w is beside the span, against many narrow ones.
    #[test]
    fn rules_are_as_exact_as_they_say() {
        for (count, width) in WIDTHS {
            for k in [
                1.0,
                3.5,
                21.0,
                201.0,
                1001.0,
                1e4 + 0.5,
                1e6 + 0.5,
                1e9 + 0.5,
            ] {
                let half: f64 = width / f64::sqrt(k);
                let quarter = libm::tan(half / 2.0);
                if half > 0.78 || least_points(quarter) > count {
                    continue;
                }
                let integrand = Integrand::new(DVec3::Z, DVec3::Z, 1.0, k);
                for across in [0.0, 1e-6, 1e-3, 0.03, 0.1, 0.3, 1.0, 2.0, 4.0] {
                    for along in [0.0, 0.1, 0.3, 0.5, 0.8, 1.0, 1.3, 2.0] {
                        let w3 = (across / f64::sqrt(k)).min(0.9);
                        let (sin, cos) = libm::sincos(along * half);
                        let c = f64::sqrt(1.0 - w3 * w3);
                        let circle = Circle {
                            w: [c * cos, c * sin, w3],
                            v: w3,
                        };
                        if c * libm::cos((1.0 + along) * half) < 0.1 {
                            continue;
                        }
                        let actual = integrand.span_by(gauss::half_rule(count), &circle, quarter);
                        let parts = (0..8).map(|place| {
                            let part = half / 8.0;
                            let middle = part * f64::from(2 * place + 1) - half;
                            let quarter = libm::tan(part / 2.0);
                            let circle = circle.turned(middle);
                            integrand.span_by(gauss::half_rule(32), &circle, quarter)
                        });
                        let error = (actual - parts.sum::<f64>()).abs() / std::f64::consts::TAU;
                        assert!(error < 1e-12, "{count} {k} {across} {along}: {error:e}");
                    }
                }
            }
        }
    }
}
