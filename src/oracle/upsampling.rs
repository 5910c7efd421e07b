//! A smooth reflectance of a given color, of the family of Jakob and Hanika (2019):
//! R(λ) = ½ + x / (2 √(1 + x²)), where x is a quadratic polynomial of λ.
//!
//! Three numbers make a polynomial and a color is three, so that for a color there is one at most.
//! Here the polynomial is known by its values at three [`KNOTS`], each of which mostly moves one of
//! the channels, and these values are found by the method of Levenberg and Marquardt with
//! differences for derivatives.

use super::colorimetry::inverse;
use super::components::Components;
use super::spectrum::{integral, on_grid};
use super::vector::{Vector, add, dot, negate, scale, subtract};

/// Wavelengths in nm in the middle of red, green and blue.
const KNOTS: Vector = [610.0, 540.0, 450.0];

/// How far, in each channel, a reflectance's color may be from the one asked for. Those that are
/// out of reach are further away by far.
const TOLERANCE: f64 = 1e-6;

/// Steps after which what is not reached is out of reach. Most colors take ten; just within the
/// limit, where the knots' values grow without bound, it is hundreds.
const STEPS: usize = 400;

/// For the differences: the error of a central one, h², is as small as that of its rounding, ε/h.
const DIFFERENCE: f64 = 1e-5;

/// The reflectance whose color is `target`, where that of a reflectance is its integrals with
/// `weights`. `None` if it is too bright or too saturated for there to be one.
pub(super) fn reflectance(weights: &[Components; 3], target: Vector) -> Option<Components> {
    let error = |knots: Vector| {
        let reflectance = smooth(knots);
        let color = weights
            .each_ref()
            .map(|weights| integral(weights, &reflectance));
        subtract(color, target)
    };
    // Gray: the inverse of R(x).
    let mean = (target.iter().sum::<f64>() / 3.0).clamp(0.01, 0.99);
    let mut knots = [(mean - 0.5) / (mean * (1.0 - mean)).sqrt(); 3];
    let mut residual = error(knots);
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        let changes = changes(error, knots);
        let better = loop {
            let tried = add(knots, step(&changes, residual, damping));
            let there = error(tried);
            if dot(there, there) < dot(residual, residual) {
                damping *= 0.1;
                break Some((tried, there));
            }
            damping *= 10.0;
            // Then a step is too short to change anything.
            if damping > 1e9 {
                break None;
            }
        };
        let Some(better) = better else { break };
        (knots, residual) = better;
    }
    let is_met = residual.iter().all(|channel| channel.abs() <= TOLERANCE);
    is_met.then(|| smooth(knots))
}

/// R(λ) of the polynomial with these values at the [`KNOTS`] (Lagrange).
fn smooth(values: Vector) -> Components {
    let [a, b, c] = KNOTS;
    on_grid(|nm| {
        let at_a = (nm - b) * (nm - c) / ((a - b) * (a - c));
        let at_b = (nm - c) * (nm - a) / ((b - c) * (b - a));
        let at_c = (nm - a) * (nm - b) / ((c - a) * (c - b));
        sigmoid(dot(values, [at_a, at_b, at_c]))
    })
}

/// ½ + x / (2 √(1 + x²)) = ½ / (√(1 + x²) (√(1 + x²) − x)), of which the latter does not cancel
/// below 0.
fn sigmoid(x: f64) -> f64 {
    if x > 0.0 {
        return 1.0 - sigmoid(-x);
    }
    let root = x.hypot(1.0);
    0.5 / (root * (root - x))
}

/// Row by row, how the error changes with the value at each knot: Jᵀ, by central differences.
fn changes(error: impl Fn(Vector) -> Vector, at: Vector) -> [Vector; 3] {
    [0, 1, 2].map(|knot: usize| {
        let h = DIFFERENCE * (1.0 + at[knot].abs());
        let moved = |by: f64| {
            let mut moved = at;
            moved[knot] += by;
            error(moved)
        };
        scale(subtract(moved(h), moved(-h)), 1.0 / (2.0 * h))
    })
}

/// The step δ with (JᵀJ + μ diag(JᵀJ)) δ = −Jᵀ f.
fn step(transposed: &[Vector; 3], f: Vector, damping: f64) -> Vector {
    let mut normal = transposed.map(|a| transposed.map(|b| dot(a, b)));
    for (i, row) in normal.iter_mut().enumerate() {
        row[i] *= 1.0 + damping;
    }
    let downhill = negate(transposed.map(|row| dot(row, f)));
    inverse(&normal).map(|row| dot(row, downhill))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::colorimetry::Colorimetry;
    use crate::oracle::spectrum::wavelengths;
    use crate::scene::ColorSpace;
    use crate::spectrum::Observer;

    fn weights(space: ColorSpace) -> [Components; 3] {
        Colorimetry::new(Observer::Cie1931, space).weights()
    }

    fn at(spectrum: &Components, nm: f64) -> f64 {
        let place = wavelengths().position(|grid| grid == nm).unwrap();
        spectrum.0[place]
    }

    /// Computed with colour-science and the tabulated D65, by the matrix of Rec.709 as it stands: its
    /// white is by 2e-4 not that of the CIE's D65.
    #[test]
    fn a_published_reflectance() {
        let colorimetry = Colorimetry::new(Observer::Cie1931, ColorSpace::Rec709);
        let weights = colorimetry.weights_without_adaptation(ColorSpace::Rec709);
        let found = reflectance(&weights, [0.8, 0.3, 0.05]).unwrap();
        for (nm, expected) in [(450.0, 0.079_391), (550.0, 0.332_378), (650.0, 0.801_065)] {
            assert!(
                (at(&found, nm) - expected).abs() < 5e-6,
                "{nm}: {}",
                at(&found, nm)
            );
        }
    }

    /// The corners of the cube included, black and white apart.
    #[test]
    fn every_color_of_rec709_has_a_reflectance() {
        const RESIDUAL: f64 = 1e-11;
        let weights = weights(ColorSpace::Rec709);
        let steps = [0.0, 1e-4, 0.02, 0.3, 0.7, 0.98, 1.0];
        for r in steps {
            for g in steps {
                for b in steps {
                    let target = [r, g, b];
                    if r == g && g == b {
                        continue;
                    }
                    let found = reflectance(&weights, target)
                        .unwrap_or_else(|| panic!("{target:?} is out of reach"));
                    assert!(found.0.iter().all(|r| (0.0..=1.0).contains(r)));
                    for (weights, target) in weights.iter().zip(target) {
                        let error = (integral(weights, &found) - target).abs();
                        assert!(error < RESIDUAL, "{target}: {error:e}");
                    }
                }
            }
        }
    }

    #[test]
    fn nearly_gray_is_nearly_flat() {
        let weights = weights(ColorSpace::AcesCg);
        for gray in [0.01, 0.2, 0.5, 0.9] {
            let found = reflectance(&weights, [gray, gray, gray * (1.0 + 1e-9)]).unwrap();
            assert!(found.0.iter().all(|r| (r - gray).abs() < 1e-7 * gray));
        }
    }

    #[test]
    fn what_no_surface_is_has_none() {
        for (space, target) in [
            (ColorSpace::Rec709, [1.1, 1.0, 1.0]),
            (ColorSpace::Rec709, [-1.0, 0.5, 0.5]),
            (ColorSpace::Rec2020, [0.0, 1.0, 0.0]),
            (ColorSpace::AcesCg, [0.0, 0.0, 1e-3]),
            (ColorSpace::Rec709, [f64::NAN, 0.5, 0.5]),
        ] {
            assert!(reflectance(&weights(space), target).is_none(), "{target:?}");
        }
    }
}
