//! Names that illuminants have elsewhere, and what to say of them.

use super::super::diagnostic::Problem;
use crate::spectrum::Illuminant;

/// What to say of an illuminant that there is not.
pub(super) fn unknown_illuminant(name: &str) -> Problem {
    let what = "illuminant";
    if let Some(illuminant) = illuminant_called(name) {
        return Problem::OtherWord {
            what,
            name: name.to_owned(),
            meant: illuminant.name(),
        };
    }
    let advice = match temperature(name) {
        Some(kelvin) => format!(
            "a color by its temperature is `{{ blackbody = {kelvin} }}` or, of daylight from 4000 K, \
             `{{ daylight = {kelvin} }}`"
        ),
        None if matches!(name, "B" | "C" | "b" | "c") => {
            "the CIE has withdrawn its illuminants B and C; \
            `{ daylight = 4874 }` and `{ daylight = 6774 }` have their temperatures"
                .to_owned()
        }
        None => {
            let names = Illuminant::ALL.iter().map(|known| known.name());
            return Problem::unknown(what, name, names);
        }
    };
    Problem::Elsewhere {
        what,
        name: name.to_owned(),
        key: None,
        advice: advice.into(),
    }
}

/// The illuminant that has this name elsewhere: `d65`, `FL2`, `CIE A`, `LED_B3`.
pub(super) fn illuminant_called(name: &str) -> Option<Illuminant> {
    let upper = name.to_uppercase().replace(['-', '_', '.', ' '], "");
    let mut short = upper.as_str();
    for word in ["CIE", "STD", "STANDARD", "ILLUMINANT", "ILL"] {
        short = short.strip_prefix(word).unwrap_or(short);
    }
    let short = match short {
        "TUNGSTEN" | "INCANDESCENT" => "A".to_owned(),
        "EQUALENERGY" => "E".to_owned(),
        "NOON" | "DAYLIGHT" => "D65".to_owned(),
        _ => match short.strip_prefix("FL") {
            Some(number) => format!("F{number}"),
            None => short.to_owned(),
        },
    };
    let is_it = |illuminant: &Illuminant| illuminant.name().replace('-', "") == short;
    Illuminant::ALL.into_iter().find(is_it)
}

/// The kelvins in `6500K`, `6500 K` or, of a D illuminant that has no table here, `D60`.
pub(super) fn temperature(name: &str) -> Option<u32> {
    let upper = name.to_uppercase();
    if let Some(hundreds) = upper.strip_prefix('D') {
        let hundreds = hundreds.parse::<u32>().ok();
        return hundreds.filter(|n| (40..=250).contains(n)).map(|n| n * 100);
    }
    let kelvin = upper.strip_suffix('K')?.trim_end().parse().ok()?;
    (500..=1_000_000).contains(&kelvin).then_some(kelvin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn illuminants_have_many_names() {
        for (written, meant) in [
            ("d65", "D65"),
            ("FL2", "F2"),
            ("FL11", "F11"),
            ("fl 1", "F1"),
            ("CIE A", "A"),
            ("cie-d50", "D50"),
            ("illuminant A", "A"),
            ("CIE Standard Illuminant D65", "D65"),
            ("LED_B3", "LED-B3"),
            ("ledbh1", "LED-BH1"),
            ("hp1", "HP1"),
        ] {
            let problem = unknown_illuminant(written);
            assert!(
                matches!(problem, Problem::OtherWord { meant: found, .. } if found == meant),
                "{written}: {problem:?}"
            );
        }
        for (written, kelvin) in [
            ("6500K", "6500"),
            ("3200 k", "3200"),
            ("D60", "6000"),
            ("D93", "9300"),
        ] {
            let problem = unknown_illuminant(written);
            assert!(
                matches!(&problem, Problem::Elsewhere { advice, .. } if advice.contains(kelvin)),
                "{written}: {problem:?}"
            );
        }
        for written in ["", "D", "X", "F13", "FL", "D65 daylight", "Ⅾ65", "K"] {
            let problem = unknown_illuminant(written);
            assert!(
                matches!(problem, Problem::Unknown { .. }),
                "{written}: {problem:?}"
            );
        }
    }
}
