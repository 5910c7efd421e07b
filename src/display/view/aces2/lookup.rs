//! The tables by hue, and how lanes read them.

use fearless_simd::Simd;

use super::gamut::Gamut;
use super::tables::{CIRCLE, HUES, Tables};
use crate::simd::{F64x16, LANES, every_nth};

/// Equal parts of the circle, for each of which the interval at its start is known: an eighth of a degree each.
const BINS: usize = 8 * HUES;

/// Numbers of a hue: reach, J and M of the cusp, 1/γ of the upper hull.
const COLUMNS: usize = 4;

/// Straight lines between hues. Both tables of ACES 2.0, of which each has its own hues, are in one with the
/// hues of both, so that both are the same straight lines as alone.
pub(super) struct Lookup {
    /// Where the lines begin: hues from 0° to below 360°, rising, and after them ∞.
    starts: Vec<f64>,
    /// 1/(end of the line − its start).
    per_width: Vec<f64>,
    /// At the starts, and at 360°.
    rows: Vec<[f64; COLUMNS]>,
    /// The last line that begins up to the start of each bin, and up to 360°.
    first: Vec<u16>,
    /// The most lines that begin inside of a bin.
    steps: usize,
}

/// What there is to know of the hues of colors.
pub(super) struct Hue<S: Simd> {
    pub(super) cosine: F64x16<S>,
    pub(super) sine: F64x16<S>,
    /// M that AP1 reaches at the peak's J.
    pub(super) reach: F64x16<S>,
    pub(super) gamut: Gamut<S>,
}

impl Lookup {
    pub(super) fn new(tables: &Tables) -> Self {
        let whole_degrees = (0..=HUES).map(|degree| degree as f64);
        let mut hues: Vec<f64> = tables.cusps.iter().map(|cusp| cusp.hue).collect();
        hues.extend(whole_degrees);
        hues.sort_by(f64::total_cmp);
        hues.dedup();
        let rows = hues.iter().map(|&hue| row(tables, hue)).collect();
        let per_width = hues.windows(2).map(|h| 1.0 / (h[1] - h[0])).collect();
        let mut starts = hues;
        starts.pop();
        let bin_start = |bin: usize| bin as f64 * (CIRCLE / BINS as f64);
        let last_until = |hue: f64| starts.partition_point(|&start| start <= hue) - 1;
        let first: Vec<usize> = (0..=BINS).map(|bin| last_until(bin_start(bin))).collect();
        let steps = first.windows(2).map(|ends| ends[1] - ends[0]).max();
        starts.push(f64::INFINITY);
        Self {
            starts,
            per_width,
            rows,
            first: first.iter().map(|&line| line as u16).collect(),
            steps: steps.expect("there are bins"),
        }
    }

    /// Of hues from 0 to 360°.
    #[inline(always)]
    pub(super) fn at<S: Simd>(
        &self,
        simd: S,
        hue: F64x16<S>,
        [cosine, sine]: [F64x16<S>; 2],
    ) -> Hue<S> {
        let (hues, bins) = (hue.to_array(), (hue * (BINS as f64 / CIRCLE)).to_array());
        let mut weights = [0.0; LANES];
        let mut pairs = [[[0.0; COLUMNS]; 2]; LANES];
        for lane in 0..LANES {
            let mut line = usize::from(self.first[(bins[lane] as usize).min(BINS)]);
            for _ in 0..self.steps {
                line += usize::from(hues[lane] >= self.starts[line + 1]);
            }
            weights[lane] = (hues[lane] - self.starts[line]) * self.per_width[line];
            pairs[lane] = [self.rows[line], self.rows[line + 1]];
        }
        let numbers = pairs.as_flattened().as_flattened();
        let [r0, j0, m0, u0, r1, j1, m1, u1] = every_nth([
            nth(simd, numbers, 0),
            nth(simd, numbers, 1),
            nth(simd, numbers, 2),
            nth(simd, numbers, 3),
            nth(simd, numbers, 4),
            nth(simd, numbers, 5),
            nth(simd, numbers, 6),
            nth(simd, numbers, 7),
        ]);
        let t = F64x16::load(simd, &weights);
        Hue {
            cosine,
            sine,
            reach: r0 + (r1 - r0) * t,
            gamut: Gamut {
                cusp: [j0 + (j1 - j0) * t, m0 + (m1 - m0) * t],
                upper_hull: u0 + (u1 - u0) * t,
            },
        }
    }
}

/// The n-th sixteen.
#[inline(always)]
fn nth<S: Simd>(simd: S, numbers: &[f64], n: usize) -> F64x16<S> {
    F64x16::load(simd, &numbers[n * LANES..])
}

/// All of a hue from 0 to 360°.
fn row(tables: &Tables, hue: f64) -> [f64; COLUMNS] {
    let degree = (hue as usize).min(HUES - 1);
    let between = |from: f64, to: f64, t: f64| from + (to - from) * t;
    let reach = between(
        tables.reach[degree],
        tables.reach[degree + 1],
        hue - degree as f64,
    );
    let next = tables.cusps.partition_point(|cusp| cusp.hue <= hue);
    let next = next.clamp(1, tables.cusps.len() - 1);
    let (from, to) = (tables.cusps[next - 1], tables.cusps[next]);
    let t = (hue - from.hue) / (to.hue - from.hue);
    [
        reach,
        between(from.lightness, to.lightness, t),
        between(from.colorfulness, to.colorfulness, t),
        between(from.upper_hull, to.upper_hull, t),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::view::aces2::tables::Cusp;
    use crate::simd::{Kernel, SimdLevel};

    struct At<'a>(&'a Lookup, f64);

    impl Kernel for At<'_> {
        type Output = [f64; COLUMNS];

        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Self::Output {
            let zero = F64x16::splat(simd, 0.0);
            let hue = self.0.at(simd, F64x16::splat(simd, self.1), [zero, zero]);
            let [lightness, colorfulness] = hue.gamut.cusp;
            [
                hue.reach.to_array()[0],
                lightness.to_array()[0],
                colorfulness.to_array()[0],
                hue.gamut.upper_hull.to_array()[0],
            ]
        }
    }

    #[test]
    fn both_tables_are_straight_between_their_hues() {
        // Cusps at squares of hues, so that some are close to each other, and values that bend at each.
        let cusp = |k: usize| Cusp {
            hue: (k * k) as f64 / 360.0,
            lightness: (k * k % 17) as f64,
            colorfulness: k as f64,
            upper_hull: -(k as f64),
        };
        let tables = Tables {
            reach: (0..=HUES).map(|k| (k * k % 13) as f64).collect(),
            cusps: (0..=HUES).map(cusp).collect(),
        };
        let lookup = Lookup::new(&tables);
        for step in 0..=3600 {
            let hue = f64::from(step) / 10.0;
            let found = SimdLevel::default().run(At(&lookup, hue));
            let k = (hue * 360.0).sqrt() as usize;
            let degree = (hue as usize).min(HUES - 1);
            let reach = &tables.reach[degree..];
            let reach = reach[0] + (reach[1] - reach[0]) * (hue - degree as f64);
            let (from, to) = (cusp(k.min(HUES - 1)), cusp(k.min(HUES - 1) + 1));
            let t = (hue - from.hue) / (to.hue - from.hue);
            let between = |from: f64, to: f64| from + (to - from) * t;
            let expected = [
                reach,
                between(from.lightness, to.lightness),
                between(from.colorfulness, to.colorfulness),
                between(from.upper_hull, to.upper_hull),
            ];
            for (found, expected) in found.into_iter().zip(expected) {
                assert!(
                    (found - expected).abs() < 1e-9,
                    "{hue}: {found}, {expected}"
                );
            }
        }
    }
}
