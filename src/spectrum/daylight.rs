//! The CIE's daylight, by its correlated color temperature.

use super::{Curve, Spectrum, tables};

/// The D illuminant of a correlated color temperature in K, relative: 100 at 560 nm.
///
/// S(λ) = S₀(λ) + M₁ S₁(λ) + M₂ S₂(λ), with M₁ and M₂ from the chromaticity x_D, y_D of daylight at
/// that temperature, rounded to three decimals; linear between the 5 nm of the table (CIE 15:2018).
/// Range: 4000 to 25 000 K.
pub fn daylight(temperature: f64) -> Spectrum {
    let [x, y] = chromaticity(temperature);
    let m = 0.0241 + 0.2562 * x - 0.7341 * y;
    mixed([
        three_decimals((-1.3515 - 1.7703 * x + 5.9114 * y) / m),
        three_decimals((0.0300 - 31.4424 * x + 30.0717 * y) / m),
    ])
}

/// M₁ and M₂ of the daylight whose chromaticity is x = 0.3127, y = 0.3290 (ITU-R BT.709-6), for the 2° observer: to
/// three decimals they would be −0.294 and −0.690, and the D illuminant of 6504 K has −0.295 and −0.689.
const WHITE: [f64; 2] = [-0.294_359_373_680_371, -0.690_067_533_387_034];

/// The daylight that is white in RGB, relative: 100 at 560 nm.
///
/// It is illuminant D65, but for the rounding: the CIE rounds M₁ and M₂, and the standards of RGB spaces round its
/// chromaticity, 0.31272, 0.32903, to 0.3127, 0.3290. With M₁ and M₂ from these four decimals, D65 is the white of
/// the spaces, and no other light needs to be adapted to them. Its values differ from the CIE's table by at most
/// 5e-4 of them.
pub(super) fn white() -> Spectrum {
    mixed(WHITE)
}

/// S₀ + M₁ S₁ + M₂ S₂
fn mixed([m1, m2]: [f64; 2]) -> Spectrum {
    let table = tables::daylight();
    let [s0, s1, s2] = ["S0", "S1", "S2"].map(|name| table.column(name));
    let values = s0.iter().zip(s1).zip(s2);
    let values = values.map(|((s0, s1), s2)| s0 + m1 * s1 + m2 * s2);
    Curve::new(table.wavelengths().to_vec(), values.collect())
        .expect("daylight is not negative from 4000 K on")
        .spectrum()
}

/// (x_D, y_D)
fn chromaticity(temperature: f64) -> [f64; 2] {
    let t = temperature;
    let (t2, t3) = (t * t, t * t * t);
    let x = if t <= 7000.0 {
        -4.6070e9 / t3 + 2.9678e6 / t2 + 0.09911e3 / t + 0.244_063
    } else {
        -2.0064e9 / t3 + 1.9018e6 / t2 + 0.24748e3 / t + 0.237_040
    };
    [x, -3.0 * x * x + 2.870 * x - 0.275]
}

fn three_decimals(m: f64) -> f64 {
    (m * 1e3).round() / 1e3
}

#[cfg(test)]
mod tests {
    use glam::{DMat2, DVec2};

    use super::super::Observer;
    use super::*;
    use crate::color::Primaries;

    /// CIE standard illuminant D65 (ISO/CIE 11664-2), some of its printed values.
    #[test]
    fn d65_is_the_published_one() {
        let d65 = daylight(6500.0 * 1.4388 / 1.4380);
        for (nm, published) in [
            (380.0, 49.9755),
            (400.0, 82.7549),
            (450.0, 117.008),
            (500.0, 109.354),
            (560.0, 100.0),
            (600.0, 90.0062),
            (650.0, 80.0268),
            (700.0, 71.6091),
            (780.0, 63.3828),
        ] {
            let actual = d65.at(nm);
            assert!((actual - published).abs() < 1e-3, "{nm}: {actual}");
        }
    }

    /// M₁ and M₂ from the chromaticity: x (X + Y + Z) = X and y (X + Y + Z) = Y are linear in them.
    #[test]
    fn white_has_the_chromaticity_of_rgb_spaces() {
        let [x, y] = Primaries::REC709.white;
        let remainders = |[m1, m2]: [f64; 2]| {
            let [big_x, big_y, big_z] = Observer::Cie1931.xyz(&mixed([m1, m2]));
            let sum = big_x + big_y + big_z;
            DVec2::new(big_x - x * sum, big_y - y * sum)
        };
        let at_0 = remainders([0.0, 0.0]);
        let slopes = DMat2::from_cols(remainders([1.0, 0.0]) - at_0, remainders([0.0, 1.0]) - at_0);
        let derived = slopes.inverse() * -at_0;
        assert!(
            derived.abs_diff_eq(DVec2::from_array(WHITE), 1e-11),
            "{derived:?}"
        );
    }

    #[test]
    fn white_is_d65_but_for_rounding() {
        let table = daylight(6500.0 * 1.4388 / 1.4380);
        let white = white();
        let pairs = white.values().iter().zip(table.values());
        let off = pairs.map(|(white, d65)| (white / d65 - 1.0).abs());
        let worst = off.fold(0.0, f64::max);
        assert!(worst > 4e-4 && worst < 5e-4, "{worst}");
    }

    #[test]
    fn daylight_is_legal_in_its_range() {
        for temperature in (4000..=25_000).step_by(100) {
            let spectrum = daylight(f64::from(temperature));
            assert!(spectrum.values().iter().all(|&value| value > 0.0));
            assert!((spectrum.at(560.0) - 100.0).abs() < 1e-9);
        }
    }
}
