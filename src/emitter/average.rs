//! Means over a piece of a light by quadrature: points, and the weights that the integrals have there.

use super::conic::WholeCone;
use super::gauss::half_rule;
use super::received::Received;
use crate::math::DVec3;

/// Points of the quadrature along and across each triangle of a piece.
const POINTS: usize = 4;

/// So many points of equal weight are few.
const FEW: f64 = 6.0;

/// Sums over points, of each integral.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    all: Received,
    seen: Received,
    rest: Received,
    /// Of squares of weights, and of squares of the rest.
    squares: Received,
    rest_squares: Received,
    /// The sum over points that are seen, and their number.
    plain: Received,
    count: f64,
    /// The most and the least.
    range: Option<[Received; 2]>,
}

/// Of each integral, the part of it that nothing opaque hides, the mean of the rest over that, and how much it differs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Means {
    pub(super) seen: Received,
    pub(super) rest: Received,
    pub(super) deviation: Received,
}

impl Sums {
    pub(super) fn add(&mut self, weights: Received, rest: Option<Received>) {
        self.all += weights;
        if let Some(rest) = rest {
            self.seen += weights;
            self.rest += weights.times(rest);
            self.squares += weights.times(weights);
            self.rest_squares += weights.times(rest).times(rest);
            self.plain += rest;
            self.count += 1.0;
            let [most, least] = self.range.unwrap_or([rest; 2]);
            self.range = Some([most.most(rest), least.least(rest)]);
        }
    }

    pub(super) fn means(&self) -> Means {
        // Where no point has a weight all of them are alike.
        let plain = if self.count > 0.0 {
            self.plain * self.count.recip()
        } else {
            Received::NOTHING
        };
        let spread = self
            .range
            .map_or(Received::NOTHING, |[most, least]| most - least);
        // The part that is seen, the mean of the rest, and how much it differs, of one integral.
        let of = |of: fn(&Received) -> f64| {
            let [all, seen] = [of(&self.all), of(&self.seen)];
            let part = if all > 0.0 { seen / all } else { 0.0 };
            if seen <= 0.0 {
                return [part, of(&plain), of(&spread)];
            }
            let mean = of(&self.rest) / seen;
            // Where few points have all the weight they do not tell what is between them.
            let is_few = seen * seen < FEW * of(&self.squares);
            let deviation = (of(&self.rest_squares) / seen - mean * mean)
                .max(0.0)
                .sqrt();
            [part, mean, if is_few { of(&spread) } else { deviation }]
        };
        let irradiance = of(|received| received.irradiance);
        let lobe = of(|received| received.lobe);
        let solid_angle = of(|received| received.solid_angle);
        let all_of = |place: usize| Received {
            irradiance: irradiance[place],
            lobe: lobe[place],
            solid_angle: solid_angle[place],
        };
        let [seen, rest, deviation] = [0, 1, 2].map(all_of);
        Means {
            seen,
            rest,
            deviation,
        }
    }
}

/// Takes points of what a convex polygon and a cone have in common, and the solid angle that each stands for, but for a
/// factor that all have: as triangles around a place within, which are cut where the cone's border begins and ends.
pub(super) fn for_each_point(
    cone: Option<WholeCone>,
    corners: &[DVec3],
    mut take: impl FnMut(DVec3, f64),
) {
    let Some(middle) = middle(cone, corners) else {
        return;
    };
    let mut from = corners[corners.len() - 1];
    for &to in corners {
        let [a, b] = [from - middle, to - middle];
        let area = a.cross(b).length();
        from = to;
        let mut cuts = [0.0, 1.0, 1.0, 1.0];
        let mut count = 2;
        if let Some(cone) = cone {
            for place in crossings(&cone, middle + a, b - a) {
                if place > 0.0 && place < 1.0 {
                    cuts[count - 1] = place;
                    count += 1;
                }
            }
        }
        for ends in cuts[..count].windows(2) {
            let width = ends[1] - ends[0];
            for (s, of_s) in rule() {
                let way = a + (b - a) * (ends[0] + width * s);
                let exit =
                    |cone: WholeCone| crossings(&cone, middle, way).into_iter().find(|&t| t > 0.0);
                let end = cone.and_then(exit).map_or(1.0, |t| t.min(1.0));
                for (t, of_t) in rule() {
                    let t = t * end;
                    let x = middle + way * t;
                    // dω = x·N/|x|³ dA, dA = |a × b| t ds dt; x·N is the same everywhere.
                    let cube = x.length_squared() * x.length();
                    take(x, of_s * of_t * width * end * area * t / cube);
                }
            }
        }
    }
}

/// Points in 0..1 and their weights, which add up to 1.
fn rule() -> impl Iterator<Item = (f64, f64)> {
    let half = half_rule(POINTS).iter();
    half.flat_map(|&[x, weight]| [(0.5 - 0.5 * x, 0.5 * weight), (0.5 + 0.5 * x, 0.5 * weight)])
}

/// Where from + t way crosses a cone, in ascending order; NaN where it does not.
fn crossings(cone: &WholeCone, from: DVec3, way: DVec3) -> [f64; 2] {
    let [p, q] = [from, way].map(|vector| cone.round(vector));
    let product = |a: DVec3, b: DVec3| a.x * b.x + a.y * b.y - a.z * b.z;
    let (a, b, c) = (product(q, q), product(p, q), product(p, p));
    let root = (b * b - a * c).sqrt();
    // Of both, the larger number first; the other one by their product c/a.
    let sum = -(b + if b < 0.0 { -root } else { root });
    let [one, other] = [sum / a, c / sum];
    if one < other {
        [one, other]
    } else {
        [other, one]
    }
}

/// A place within a convex polygon and a cone; `None` where they have nothing in common.
fn middle(cone: Option<WholeCone>, corners: &[DVec3]) -> Option<DVec3> {
    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
    let mut add = |place: DVec3| {
        sum += place;
        count += 1.0;
    };
    let Some(cone) = cone else {
        corners.iter().for_each(|&corner| add(corner));
        return (count > 2.0).then(|| sum / count);
    };
    let [first, second, third, ..] = *corners else {
        return None;
    };
    let normal = (second - first).cross(third - first);
    // Where the cone's axis meets the polygon's plane.
    let axis = cone.axis() * (normal.dot(first) / normal.dot(cone.axis()));
    let mut is_within = axis.is_finite();
    let mut from = corners[corners.len() - 1];
    for &to in corners {
        let edge = to - from;
        is_within &= normal.dot(edge.cross(axis - from)) >= 0.0;
        if cone.holds(to) {
            add(to);
        }
        for place in crossings(&cone, from, edge) {
            if place > 0.0 && place < 1.0 {
                add(from + edge * place);
            }
        }
        from = to;
    }
    if is_within {
        add(axis);
    }
    (count > 0.0).then(|| sum / count)
}
