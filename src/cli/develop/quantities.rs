//! Numbers with a meaning, as options have them.

use candela::Primaries;
use candela::display::Exposure;
use candela::spectrum::{Illuminant, Observer, Spectrum, blackbody};

/// An exposure in EV.
pub(super) fn ev(text: &str) -> Result<f64, String> {
    finite(text).ok_or_else(|| "expected a finite number of EV, such as 1.5 or -2".to_owned())
}

/// A number above 0.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    finite(text)
        .filter(|&number| number > 0.0)
        .ok_or_else(|| "expected a number above 0".to_owned())
}

/// The speed of a sensor. Lines of equal light are looked for under that name, too.
pub(super) fn speed(text: &str) -> Result<f64, String> {
    positive(text).map_err(|_| {
        "expected the speed of a sensor, such as 100; lines of equal light are --iso-lines"
            .to_owned()
    })
}

/// A luminance of a screen.
pub(super) fn luminance(text: &str) -> Result<f64, String> {
    finite(text)
        .filter(|&number| number > 0.0 && number <= 10_000.0)
        .ok_or_else(|| "expected cd/m² above 0, at most 10000".to_owned())
}

/// Seconds, as a number or as 1/60.
pub(super) fn shutter(text: &str) -> Result<f64, String> {
    let seconds = match text.split_once('/') {
        Some((above, below)) => finite(above)
            .zip(finite(below))
            .map(|(above, below)| above / below),
        None => finite(text),
    };
    seconds
        .filter(|&seconds| seconds > 0.0 && seconds.is_finite())
        .ok_or_else(|| "expected seconds above 0, such as 1/60 or 0.5".to_owned())
}

/// An f-number, with or without `f/`.
pub(super) fn aperture(text: &str) -> Result<f64, String> {
    let number = text.strip_prefix("f/").unwrap_or(text);
    positive(number).map_err(|_| "expected an f-number above 0, such as 8 or f/8".to_owned())
}

/// How an exposure is chosen.
pub(super) fn rule(text: &str) -> Result<Exposure, String> {
    let percent = match text.split_once(':') {
        None if text == "log-average" => return Ok(Exposure::Auto),
        Some(("percentile", percent)) => finite(percent.trim_end_matches('%')),
        _ => None,
    };
    percent
        .filter(|&percent| percent > 0.0 && percent <= 100.0)
        .map(Exposure::Percentile)
        .ok_or_else(|| {
            "expected log-average, or percentile:P with P above 0, at most 100".to_owned()
        })
}

/// What is to look white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct White {
    /// `None` for the white of the screens.
    pub(super) chromaticity: Option<[f64; 2]>,
}

/// The lowest and highest temperature, as those of a scene's black bodies.
const TEMPERATURES: [f64; 2] = [500.0, 1e6];

/// A light by its name, a temperature in K, or x,y.
pub(super) fn white(text: &str) -> Result<White, String> {
    let expected = || {
        let names = Illuminant::ALL.map(Illuminant::name).join(", ");
        format!(
            "expected a light ({names}), a temperature from 500 to 1000000 K, or a chromaticity \
             such as 0.3127,0.3290"
        )
    };
    if text == Illuminant::D65.name() {
        return Ok(White { chromaticity: None });
    }
    if let Some(light) = Illuminant::named(text) {
        return Ok(of_spectrum(&light.spectrum()));
    }
    let chromaticity = match text.split_once(',') {
        Some((x, y)) => finite(x.trim())
            .zip(finite(y.trim()))
            .map(|(x, y)| [x, y])
            .filter(|&chromaticity| is_white(chromaticity)),
        None => {
            let temperature = finite(text.trim_end_matches(['K', ' ']));
            let [lowest, highest] = TEMPERATURES;
            return temperature
                .filter(|temperature| (lowest..=highest).contains(temperature))
                .map(|temperature| of_spectrum(&blackbody(temperature)))
                .ok_or_else(expected);
        }
    };
    chromaticity
        .map(|chromaticity| {
            let screen = Primaries::REC709.white;
            White {
                chromaticity: (chromaticity != screen).then_some(chromaticity),
            }
        })
        .ok_or_else(expected)
}

/// Whether light of a chromaticity excites all three kinds of cones: it can be made white then.
fn is_white([x, y]: [f64; 2]) -> bool {
    y > 0.0 && x > 0.0 && x + y < 1.0 && Primaries::can_be_white([x, y])
}

fn of_spectrum(spectrum: &Spectrum) -> White {
    let [x, y, z] = Observer::Cie1931.xyz(spectrum);
    let sum = x + y + z;
    White {
        chromaticity: Some([x / sum, y / sum]),
    }
}

fn finite(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().filter(|number| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras() {
        assert_eq!(shutter("1/4"), Ok(0.25));
        assert_eq!(shutter("0.5"), Ok(0.5));
        assert_eq!(aperture("f/8"), Ok(8.0));
        assert_eq!(aperture("2.8"), Ok(2.8));
        for bad in ["1/0", "0", "-1", "1/2/3", "nan", ""] {
            assert!(shutter(bad).is_err(), "{bad}");
        }
        for bad in ["f/", "f/0", "F8", "inf"] {
            assert!(aperture(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn rules() {
        assert_eq!(rule("log-average"), Ok(Exposure::Auto));
        assert_eq!(rule("percentile:99.5"), Ok(Exposure::Percentile(99.5)));
        for bad in [
            "percentile",
            "percentile:0",
            "percentile:101",
            "median",
            "99",
        ] {
            assert!(rule(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn whites() {
        let of = |text| white(text).map(|white| white.chromaticity);
        assert_eq!(of("D65"), Ok(None));
        assert_eq!(of("0.3127,0.3290"), Ok(None));
        assert_eq!(of("0.44, 0.40"), Ok(Some([0.44, 0.40])));
        // CIE 15, table T.3: illuminant A, a black body of 2856 K as it was defined.
        for text in ["A", "2856", "2856K"] {
            let [x, y] = of(text).unwrap().unwrap();
            assert!(
                (x - 0.4476).abs() < 1e-4 && (y - 0.4074).abs() < 1e-4,
                "{text}"
            );
        }
        for bad in [
            "D99",
            "0",
            "-3200",
            "0.3",
            "1,2",
            "0.1,0",
            "0.8,0.1,0.1",
            "0.17,0.001",
            "",
        ] {
            assert!(white(bad).is_err(), "{bad}");
        }
    }
}
