//! The part of a square on one side of a line, and integrals over it.

use super::model::Model;

/// The part of the square −1 ≤ u, v ≤ 1 where φ = c + g_u u + g_v v ≥ 0.
///
/// With √φ = s (1 + w) and a `scale` s, half of the largest √φ of the square, integrals of w are there as well: over a
/// polygon, the strip between φ and φ + dφ is as long as a function that is linear between the corners, and that times
/// √φ or 1/√φ has an integral in closed form.
#[derive(Clone, Copy, Debug)]
pub(super) struct Clip {
    /// Over the square's.
    pub(super) area: f64,
    /// The mean of u, v and w; that of w only if it was asked for.
    pub(super) middle: [f64; 3],
    /// The mean of 1/√φ, if it was asked for.
    pub(super) inverse_root: f64,
}

type Corner = [f64; 2];

impl Clip {
    pub(super) fn new(inside: &Model, scale: Option<f64>) -> Self {
        let [u, v, _] = inside.slope;
        let of = |[x, y]: Corner| inside.center + u * x + v * y;
        let mut corners: [Corner; 8] = [[0.0; 2]; 8];
        let mut count = 0;
        const SQUARE: [Corner; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        for i in 0..4 {
            let (from, to) = (SQUARE[i], SQUARE[(i + 1) % 4]);
            let (before, after) = (of(from), of(to));
            if before >= 0.0 {
                corners[count] = from;
                count += 1;
            }
            if (before >= 0.0) != (after >= 0.0) {
                let t = before / (before - after);
                corners[count] = [
                    from[0] + (to[0] - from[0]) * t,
                    from[1] + (to[1] - from[1]) * t,
                ];
                count += 1;
            }
        }
        let corners = &corners[..count];
        let (mut twice_area, mut moment) = (0.0, [0.0; 2]);
        for i in 1..count.saturating_sub(1) {
            let (a, b, c) = (corners[0], corners[i], corners[i + 1]);
            let twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            twice_area += twice;
            for axis in 0..2 {
                moment[axis] += twice * (a[axis] + b[axis] + c[axis]) / 3.0;
            }
        }
        let is_left = twice_area > 0.0;
        if !is_left {
            return Self {
                area: 0.0,
                middle: [0.0; 3],
                inverse_root: 0.0,
            };
        }
        let mut clip = Self {
            area: twice_area / 8.0,
            middle: [moment[0] / twice_area, moment[1] / twice_area, 0.0],
            inverse_root: 0.0,
        };
        if let Some(scale) = scale {
            let [root, inverse_root] = roots(corners, of);
            clip.middle[2] = root / scale - 1.0;
            clip.inverse_root = inverse_root;
        }
        clip
    }
}

/// The means of √φ and 1/√φ over a polygon, triangle by triangle from its first corner.
fn roots(corners: &[Corner], of: impl Fn(Corner) -> f64) -> [f64; 2] {
    let (mut area, mut root, mut inverse) = (0.0, 0.0, 0.0);
    for i in 1..corners.len().saturating_sub(1) {
        let (a, b, c) = (corners[0], corners[i], corners[i + 1]);
        let twice = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        if twice <= 0.0 {
            continue;
        }
        let mut heights = [a, b, c].map(|corner| of(corner).max(0.0));
        heights.sort_unstable_by(f64::total_cmp);
        let [sum, over] = triangle_roots(heights);
        area += twice;
        root += twice * sum;
        inverse += twice * over;
    }
    [root / area, inverse / area]
}

/// The means of √φ and 1/√φ over a triangle, φ linear, from φ at its corners in ascending order.
///
/// With the second divided difference [x, y, z] of F: the mean of F″ over a triangle is 2 F[x, y, z] (Hermite and
/// Genocchi). F = 4/15 φ^(5/2) for √φ, and 4/3 φ^(3/2) for 1/√φ.
fn triangle_roots([low, middle, high]: [f64; 3]) -> [f64; 2] {
    let spread = high - low;
    if spread <= high * 1e-3 {
        // Divided differences lose their digits: the value in the middle, which √ bends from by less than 1e-6.
        let root = ((low + middle + high) / 3.0).sqrt();
        return [root, 1.0 / root];
    }
    // The difference of the powers n + ½ over that of the numbers, by √.
    let first = |power: i32, x: f64, y: f64| {
        let (p, q) = (x.sqrt(), y.sqrt());
        // (pⁿ − qⁿ)/(p² − q²) = Σ pⁱ qⁿ⁻¹⁻ⁱ / (p + q)
        let sum: f64 = (0..power).map(|i| p.powi(i) * q.powi(power - 1 - i)).sum();
        if p + q > 0.0 { sum / (p + q) } else { 0.0 }
    };
    let second = |power: i32| (first(power, middle, high) - first(power, low, middle)) / spread;
    [2.0 * 4.0 / 15.0 * second(5), 2.0 * 4.0 / 3.0 * second(3)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against many points.
    #[test]
    fn means_over_what_a_line_leaves() {
        for (center, slope) in [
            (0.3, [1.0, 0.5]),
            (-0.9, [0.2, 1.1]),
            (2.0, [0.7, -0.4]),
            (0.0, [0.0, 1.0]),
            (5.0, [1e-4, 2e-4]),
        ] {
            let inside = Model::linear(center, slope);
            let scale = 0.5 * inside.most().sqrt();
            let clip = Clip::new(&inside, Some(scale));
            let side = 2000;
            let (mut count, mut sums, mut inverse) = (0.0, [0.0; 3], 0.0);
            for i in 0..side * side {
                let [u, v] = [i % side, i / side]
                    .map(|n| (f64::from(n) + 0.5) * 2.0 / f64::from(side) - 1.0);
                let phi = center + slope[0] * u + slope[1] * v;
                if phi >= 0.0 {
                    count += 1.0;
                    sums[0] += u;
                    sums[1] += v;
                    sums[2] += phi.sqrt() / scale - 1.0;
                    inverse += 1.0 / phi.sqrt();
                }
            }
            let total = f64::from(side * side);
            assert!((clip.area - count / total).abs() < 1e-3, "{clip:?}");
            for (axis, sum) in sums.iter().enumerate() {
                let mean = sum / count;
                assert!(
                    (clip.middle[axis] - mean).abs() < 2e-3,
                    "{axis} {clip:?} {mean}"
                );
            }
            let mean = inverse / count;
            assert!(
                (clip.inverse_root / mean - 1.0).abs() < 2e-2,
                "{clip:?} {mean}"
            );
        }
    }

    #[test]
    fn nothing_is_left_of_nothing() {
        assert_eq!(
            Clip::new(&Model::linear(-3.0, [1.0, 1.0]), Some(1.0)).area,
            0.0
        );
        assert_eq!(Clip::new(&Model::linear(3.0, [1.0, 1.0]), None).area, 1.0);
    }
}
