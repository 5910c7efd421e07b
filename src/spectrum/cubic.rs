//! From the tables of lamps at 5 nm to the grid.

use super::{FIRST, Spectrum};

/// A table at equal steps of whole nm, on the grid: cubic between its points, constant beyond them.
///
/// At a part f of the step from S₁ to S₂, with S₀ and S₃ on their other sides (Lagrange; one of the methods of
/// CIE 15:2018),
///
/// S(λ) = −f(f−1)(f−2)/6 S₀ + (f+1)(f−1)(f−2)/2 S₁ − (f+1)f(f−2)/2 S₂ + (f+1)f(f−1)/6 S₃,
///
/// straight in the first and the last step, which have no S₀ or S₃.
///
/// A point, be it a part of a curve or a line, spreads over 1 nm without a change of its power, its place, or its
/// second and third moment. So Σ S(λ) w(λ) at 1 nm is Δλ Σ S_j w(λ_j) over the points, as the CIE sums its tables, for
/// any smooth w: no sharper than a color matching function. Straight lines would blur w by a tent two steps wide.
///
/// Between the foot of a line and darkness the cubic may be below zero. It is 0 there, and what that adds is
/// taken from S₀ or S₃, the larger, which is the line.
///
/// # Panics
/// With fewer than two points, or where they are beside the grid.
pub(super) fn cubic(wavelengths: &[f64], values: &[f64]) -> Spectrum {
    let step = wavelengths[1] - wavelengths[0];
    let last = values.len() - 1;
    let mut below_zero = vec![0.0; values.len()];
    let mut spectrum = Spectrum::from_fn(|nm| {
        let place = ((nm - wavelengths[0]) / step).clamp(0.0, last as f64);
        let from = (place as usize).min(last - 1);
        let f = place - from as f64;
        let straight = values[from] * (1.0 - f) + values[from + 1] * f;
        if from == 0 || from + 1 == last || f == 0.0 {
            return straight;
        }
        let [s0, s1, s2, s3] = [from - 1, from, from + 1, from + 2].map(|point| values[point]);
        let value = -f * (f - 1.0) * (f - 2.0) / 6.0 * s0
            + (f + 1.0) * (f - 1.0) * (f - 2.0) / 2.0 * s1
            - (f + 1.0) * f * (f - 2.0) / 2.0 * s2
            + (f + 1.0) * f * (f - 1.0) / 6.0 * s3;
        if value < 0.0 {
            below_zero[if s0 >= s3 { from - 1 } else { from + 2 }] += value;
        }
        value.max(0.0)
    });
    for (nm, below) in wavelengths.iter().zip(below_zero) {
        spectrum.0[(nm - f64::from(FIRST)) as usize] += below;
    }
    spectrum
}

#[cfg(test)]
mod tests {
    use super::super::wavelengths;
    use super::*;

    /// Sums of 471 terms of about 1, and moments in nm about their middle.
    const ROUNDING: f64 = 1e-11;

    /// 380, 385, … 780 nm.
    fn points() -> Vec<f64> {
        (0..81).map(|i| 380.0 + 5.0 * f64::from(i)).collect()
    }

    fn spread(value: impl Fn(f64) -> f64) -> Spectrum {
        let values: Vec<f64> = points().into_iter().map(value).collect();
        cubic(&points(), &values)
    }

    #[test]
    fn cubics_are_themselves() {
        let curve = |nm: f64| {
            let x = (nm - 580.0) / 100.0;
            20.0 + x * (3.0 + x * (0.7 - 1.9 * x))
        };
        let spectrum = spread(curve);
        for (nm, value) in wavelengths().zip(spectrum.values()) {
            if (385.0..=775.0).contains(&nm) {
                assert!((value - curve(nm)).abs() < ROUNDING, "{nm}: {value}");
            }
        }
        // Straight in the first step, and constant beyond.
        let first = curve(380.0) * 0.6 + curve(385.0) * 0.4;
        assert!((spectrum.at(382.0) - first).abs() < ROUNDING);
        assert_eq!([360.0, 379.0].map(|nm| spectrum.at(nm)), [curve(380.0); 2]);
        assert_eq!([781.0, 830.0].map(|nm| spectrum.at(nm)), [curve(780.0); 2]);
    }

    /// Over other light a line has the power of 5 nm times its point, at its point, and neither width nor lean.
    #[test]
    fn lines_keep_power_place_and_width() {
        let (line, ground) = (
            spread(|nm| if nm == 435.0 { 31.0 } else { 10.0 }),
            spread(|_| 10.0),
        );
        for (power, expected) in [(0, 105.0), (1, 0.0), (2, 0.0), (3, 0.0)] {
            let terms = wavelengths().zip(line.values().iter().zip(ground.values()));
            let moment: f64 = terms
                .map(|(nm, (line, ground))| (line - ground) * (nm - 435.0).powi(power))
                .sum();
            assert!(
                (moment - expected).abs() < 1e3 * ROUNDING,
                "{power}: {moment}"
            );
        }
    }

    /// And in the dark it keeps its power.
    #[test]
    fn nothing_is_below_zero() {
        let spectrum = spread(|nm| if nm == 435.0 { 21.0 } else { 0.0 });
        assert!(spectrum.values().iter().all(|&value| value >= 0.0));
        assert!((spectrum.total() - 105.0).abs() < ROUNDING);
        assert!((spectrum.at(427.0), spectrum.at(443.0)) == (0.0, 0.0));
        assert!(spectrum.at(434.0) > 18.0 && spectrum.at(434.0) == spectrum.at(436.0));
    }
}
