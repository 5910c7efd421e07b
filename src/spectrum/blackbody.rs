//! Planck's law.

use super::Spectrum;

/// The second radiation constant c₂ = h c / k in m·K (CODATA 2018, exact since the SI of 2019).
const C2: f64 = 1.438_776_877e-2;

/// The spectrum of a black body at `temperature` in K, relative: 1 at its peak on the grid.
///
/// λ⁻⁵ / (exp(c₂/(λT)) − 1). Range: such that anything is visible at all, from 100 K.
pub fn blackbody(temperature: f64) -> Spectrum {
    // ln of the relative spectrum, so that the exponent neither over- nor underflows.
    let logarithm = |nm: f64| {
        let exponent = C2 / (nm * 1e-9 * temperature);
        // ln(eˣ − 1) = x + ln(1 − e⁻ˣ)
        -5.0 * libm::log(nm) - exponent - libm::log(-libm::expm1(-exponent))
    };
    let logarithms = Spectrum::from_fn(logarithm);
    let (peak, _) = logarithms.peak();
    Spectrum::from_fn(|nm| libm::exp(logarithm(nm) - peak))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// k, h, c of the SI, exact.
    #[test]
    fn the_constant_follows_from_the_si() {
        let (h, c, k) = (6.626_070_15e-34, 299_792_458.0, 1.380_649e-23);
        assert!((h * c / k - C2).abs() < 1e-11);
    }

    #[test]
    fn wien_s_displacement() {
        // λ T = 2.897771955e-3 m·K at the peak.
        for nm in [400.0, 555.0, 800.0] {
            let (value, peak) = blackbody(2.897_771_955e-3 / (nm * 1e-9)).peak();
            assert_eq!((value, peak), (1.0, nm));
        }
    }

    #[test]
    fn ratios_are_planck_s() {
        let planck = |nm: f64, t: f64| {
            let meters = nm * 1e-9;
            meters.powi(-5) / ((C2 / (meters * t)).exp() - 1.0)
        };
        for temperature in [1000.0, 3200.0, 20_000.0] {
            let spectrum = blackbody(temperature);
            let expected = planck(450.0, temperature) / planck(650.0, temperature);
            let actual = spectrum.at(450.0) / spectrum.at(650.0);
            assert!((actual / expected - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn extremes_stay_finite() {
        for temperature in [100.0, 1e9] {
            let spectrum = blackbody(temperature);
            assert!(spectrum.values().iter().all(|value| value.is_finite()));
            assert_eq!(spectrum.peak().0, 1.0);
        }
    }
}
