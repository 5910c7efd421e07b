//! A smooth reflectance of a given color (Jakob & Hanika 2019).
//!
//! R(λ) = s(c₀ λ² + c₁ λ + c₂) with s(x) = ½ + x / (2 √(1 + x²)): never below 0 or above 1, and
//! for every color that a reflectance of this form can have there are coefficients. They are solved
//! for here, color by color, rather than looked up in a table of rounded ones.

use std::cell::Cell;

use super::{FIRST, LAST, Spectrum};

/// How far, in each channel, the color of a solution may be from the one asked for.
pub const RESIDUAL: f64 = 1e-6;

/// Where the iteration stops: as good as f64 sums over the grid get.
const CONVERGED: f64 = 1e-13;

/// Newton steps towards one target before it counts as too far away.
const MOST_STEPS: usize = 40;

/// How often the integrals are computed before a color counts as out of reach: 3 ms. Colors within
/// reach take 10, those close to its limit several hundred.
const PATIENCE: u32 = 1500;

/// The shortest step from gray to the color, as a part of the whole way.
const SHORTEST: f64 = 1.0 / 4096.0;

/// The coefficients of a reflectance.
///
/// They are kept for a wavelength that runs from −1 to 1 over the grid, in which the three powers
/// are of one size; [`Coefficients::in_nanometers`] has the published form.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients([f64; 3]);

/// λ in nm on a scale from −1 to 1 over the grid.
fn centered(nm: f64) -> f64 {
    (nm - MIDDLE) / HALF_WIDTH
}

const MIDDLE: f64 = (FIRST + LAST) as f64 / 2.0;
const HALF_WIDTH: f64 = (LAST - FIRST) as f64 / 2.0;

impl Coefficients {
    /// The reflectance, 0 to 1.
    pub fn spectrum(self) -> Spectrum {
        Spectrum::from_fn(|nm| sigmoid(self.polynomial(centered(nm))))
    }

    /// c₀, c₁, c₂ of c₀ λ² + c₁ λ + c₂ with λ in nm.
    pub fn in_nanometers(self) -> [f64; 3] {
        let [a, b, c] = self.0;
        let (scale, shift) = (1.0 / HALF_WIDTH, MIDDLE / HALF_WIDTH);
        // a (λ scale − shift)² + b (λ scale − shift) + c
        [
            a * scale * scale,
            (b - 2.0 * a * shift) * scale,
            (a * shift - b) * shift + c,
        ]
    }

    fn polynomial(self, x: f64) -> f64 {
        let [a, b, c] = self.0;
        (a * x + b) * x + c
    }
}

/// s(x) = ½ + x / (2 √(1 + x²)), without cancellation for large negative x.
fn sigmoid(x: f64) -> f64 {
    let root = (1.0 + x * x).sqrt();
    if x < 0.0 {
        0.5 / (root * (root - x))
    } else {
        0.5 + 0.5 * x / root
    }
}

/// The coefficients of a reflectance whose color is `target`, where a reflectance R has the color
/// ∫ R(λ) w(λ) dλ in the three `weights`. Those of a reflectance of 1 must be (1, 1, 1).
///
/// `None` if no reflectance of this form comes within [`RESIDUAL`] of it, in each channel: colors
/// more saturated or brighter than surfaces can be. Black and white are its limits, not its members.
pub fn reflectance(weights: &[Spectrum; 3], target: [f64; 3]) -> Option<Coefficients> {
    let solver = Solver {
        weights,
        evaluations: Cell::new(0),
    };
    let gray = (target.iter().sum::<f64>() / 3.0).clamp(0.02, 0.98);
    // s(x) = r at x = (r − ½)/√(r (1 − r)): exact for gray.
    let start = (gray - 0.5) / (gray * (1.0 - gray)).sqrt();
    let mut coefficients = [0.0, 0.0, start];
    // From gray to the color, in steps as long as the iteration can bear.
    let (mut done, mut step) = (0.0, 1.0);
    while done < 1.0 {
        let next = f64::min(done + step, 1.0);
        let on_the_way = target.map(|channel| gray + (channel - gray) * next);
        let (found, residual) = solver.towards(on_the_way, coefficients);
        // Only the end must be met to the last digit.
        let wanted = if next < 1.0 { 1e-3 } else { 1e-9 };
        if residual <= wanted || (next == 1.0 && step <= 2.0 * SHORTEST && residual <= RESIDUAL) {
            (coefficients, done) = (found, next);
            step *= 2.0;
        } else {
            step /= 2.0;
            if step < SHORTEST || solver.evaluations.get() > PATIENCE {
                return None;
            }
        }
    }
    Some(Coefficients(coefficients))
}

struct Solver<'a> {
    weights: &'a [Spectrum; 3],
    /// How often the integrals were computed.
    evaluations: Cell<u32>,
}

/// The colors' differences, and how they change with each coefficient.
struct Linearized {
    difference: [f64; 3],
    jacobian: [[f64; 3]; 3],
}

impl Solver<'_> {
    /// Newton's method with halved steps where the whole one leads away. The best coefficients, and
    /// their largest residual.
    fn towards(&self, target: [f64; 3], start: [f64; 3]) -> ([f64; 3], f64) {
        let mut at = start;
        let mut here = self.linearized(at, target);
        for _ in 0..MOST_STEPS {
            let norm = largest(here.difference);
            if norm <= CONVERGED || self.evaluations.get() > PATIENCE {
                break;
            }
            let Some(step) = solve(here.jacobian, here.difference) else {
                break;
            };
            let mut length = 1.0;
            let better = loop {
                let tried: [f64; 3] = std::array::from_fn(|i| at[i] - length * step[i]);
                let there = self.linearized(tried, target);
                if largest(there.difference) < norm {
                    break Some((tried, there));
                }
                length /= 2.0;
                if length < 1e-4 {
                    break None;
                }
            };
            let Some((tried, there)) = better else { break };
            (at, here) = (tried, there);
        }
        (at, largest(here.difference))
    }

    fn linearized(&self, coefficients: [f64; 3], target: [f64; 3]) -> Linearized {
        self.evaluations.update(|count| count + 1);
        let polynomial = Coefficients(coefficients);
        let mut difference = target.map(|channel| -channel);
        let mut jacobian = [[0.0; 3]; 3];
        for (place, nm) in super::wavelengths().enumerate() {
            let x = centered(nm);
            let value = polynomial.polynomial(x);
            let reflectance = sigmoid(value);
            let square = 1.0 + value * value;
            let slope = 0.5 / (square * square.sqrt());
            for channel in 0..3 {
                let weight = self.weights[channel].values()[place];
                difference[channel] += weight * reflectance;
                let slope = weight * slope;
                jacobian[channel][0] += slope * x * x;
                jacobian[channel][1] += slope * x;
                jacobian[channel][2] += slope;
            }
        }
        Linearized {
            difference,
            jacobian,
        }
    }
}

fn largest(vector: [f64; 3]) -> f64 {
    // Not `max`, which would lose a NaN.
    vector.iter().fold(0.0, |largest, value| {
        if value.abs() <= largest {
            largest
        } else {
            value.abs()
        }
    })
}

/// x with A x = b by elimination with the largest pivots; `None` where A has no inverse.
fn solve(mut a: [[f64; 3]; 3], mut b: [f64; 3]) -> Option<[f64; 3]> {
    // Each row to the size of 1: near black and white a channel hardly changes.
    for (row, right) in a.iter_mut().zip(&mut b) {
        let scale = largest(*row);
        if !(scale > 0.0 && scale.is_finite()) {
            return None;
        }
        *row = row.map(|value| value / scale);
        *right /= scale;
    }
    for column in 0..3 {
        let pivot =
            (column..3).max_by(|&i, &j| a[i][column].abs().total_cmp(&a[j][column].abs()))?;
        a.swap(column, pivot);
        b.swap(column, pivot);
        if a[column][column] == 0.0 {
            return None;
        }
        for row in column + 1..3 {
            let factor = a[row][column] / a[column][column];
            let above = a[column];
            for (value, above) in a[row].iter_mut().zip(above) {
                *value -= factor * above;
            }
            b[row] -= factor * b[column];
        }
    }
    let mut x = [0.0; 3];
    for row in (0..3).rev() {
        let known: f64 = (row + 1..3).map(|column| a[row][column] * x[column]).sum();
        x[row] = (b[row] - known) / a[row][row];
    }
    x.iter().all(|value| value.is_finite()).then_some(x)
}

#[cfg(test)]
mod tests {
    use super::super::{Observer, SAMPLES, daylight};
    use super::*;

    /// Linear Rec.709 from XYZ (IEC 61966-2-1, as derived with more digits).
    const FROM_XYZ: [[f64; 3]; 3] = [
        [3.240_969_941_9, -1.537_383_177_6, -0.498_610_760_3],
        [-0.969_243_636_3, 1.875_967_501_5, 0.041_555_057_4],
        [0.055_630_079_7, -0.203_976_958_9, 1.056_971_514_2],
    ];

    /// What linear Rec.709 makes of a reflectance under D65, each channel scaled so that white is 1.
    fn rec709() -> [Spectrum; 3] {
        unscaled_rec709().map(|weights| weights.scaled(1.0 / weights.total()))
    }

    /// The same by the matrix alone, which is for a white that is rounded to four decimals, and the CIE's D65, whose
    /// own is not.
    fn unscaled_rec709() -> [Spectrum; 3] {
        let d65 = daylight(6500.0 * 1.4388 / 1.4380);
        let xyz = Observer::Cie1931.color_matching();
        FROM_XYZ.map(|row| {
            let mut place = 0..SAMPLES;
            let weights = Spectrum::from_fn(|_| {
                let i = place.next().unwrap();
                let matching = row[0] * xyz[0][i] + row[1] * xyz[1][i] + row[2] * xyz[2][i];
                matching * d65.values()[i]
            });
            weights.scaled(1.0 / d65.integral(xyz[1]))
        })
    }

    fn color(weights: &[Spectrum; 3], reflectance: &Spectrum) -> [f64; 3] {
        std::array::from_fn(|i| reflectance.integral(weights[i].values()))
    }

    #[test]
    fn published_coefficients() {
        let weights = unscaled_rec709();
        let found = reflectance(&weights, [0.8, 0.3, 0.05]).unwrap();
        // Computed with the tabulated D65, which is rounded to the fourth decimal.
        let expected = [-4.498_204_9e-6, 1.649_791_77e-2, -8.068_982_69];
        for (actual, expected) in found.in_nanometers().into_iter().zip(expected) {
            assert!(
                (actual / expected - 1.0).abs() < 2e-4,
                "{actual} {expected}"
            );
        }
        let spectrum = found.spectrum();
        for (nm, expected) in [(450.0, 0.079_391), (550.0, 0.332_378), (650.0, 0.801_065)] {
            assert!((spectrum.at(nm) - expected).abs() < 5e-5, "{nm}");
        }
    }

    #[test]
    fn every_color_of_rec709_is_in_reach() {
        let weights = rec709();
        let steps = [0.0, 1e-4, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 1.0];
        for r in steps {
            for g in steps {
                for b in steps {
                    let target = [r, g, b];
                    if target == [0.0; 3] || target == [1.0; 3] {
                        continue;
                    }
                    let found = reflectance(&weights, target)
                        .unwrap_or_else(|| panic!("{target:?} is out of reach"));
                    let actual = color(&weights, &found.spectrum());
                    for (actual, target) in actual.into_iter().zip(target) {
                        assert!((actual - target).abs() <= RESIDUAL, "{actual} {target}");
                    }
                }
            }
        }
    }

    #[test]
    fn gray_is_constant() {
        let weights = rec709();
        for v in [0.02, 0.18, 0.5, 0.9] {
            let found = reflectance(&weights, [v; 3]).unwrap();
            for value in found.spectrum().values() {
                assert!((value - v).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn what_no_surface_is_is_out_of_reach() {
        let weights = rec709();
        for target in [
            [2.0, 0.1, 0.1],
            [-0.5, 1.0, -0.2],
            [f64::NAN, 0.1, 0.1],
            [1.0, 1.0, 1.5],
        ] {
            assert_eq!(reflectance(&weights, target), None, "{target:?}");
        }
    }
}
