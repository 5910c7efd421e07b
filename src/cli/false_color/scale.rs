//! Ranges and values that a picture in false colors has where none are given: round numbers.

use candela::display::Field;

/// What is darker, or brighter, of a picture's lit pixels is outside of a range that is chosen.
const DARKEST: f64 = 0.005;
const BRIGHTEST: f64 = 0.998;

/// The largest factor from the least to the most of a range that is chosen: what is darker is black.
const WIDEST: f64 = 200.0;

/// The ends of ranges, in each decade.
const ENDS: [f64; 3] = [1.0, 2.0, 5.0];

/// The steps of illuminances in EN 12464-1, in each decade; then fewer.
const STEPS: [&[f64]; 4] = [
    &[1.0, 1.5, 2.0, 3.0, 5.0, 7.5],
    &[1.0, 2.0, 3.0, 5.0],
    &[1.0, 3.0],
    &[1.0],
];

/// More lines than this are too many.
const LINES: usize = 12;

/// The range of a picture where nothing is lit.
const DARK: [f64; 2] = [1.0, 1000.0];

/// A range for what is lit of a picture, from a round number to another.
pub(super) fn range(field: Option<&Field>) -> [f64; 2] {
    let quantile = |part| field.and_then(|field| field.quantile(part));
    let Some((least, most)) = quantile(DARKEST).zip(quantile(BRIGHTEST)) else {
        return DARK;
    };
    // What false colors can have.
    let [least, most] = [least, most].map(|end| end.clamp(1e-20, 1e20));
    let numbers = round(&ENDS, least.max(most / WIDEST) / 10.0, most * 10.0);
    let least = least.max(most / WIDEST) * (1.0 + 1e-3);
    let below = numbers.iter().rev().find(|&&number| number <= least);
    let above = numbers
        .iter()
        .find(|&&number| number >= most * (1.0 - 1e-3));
    match (below, above) {
        (Some(&below), Some(&above)) if below < above => [below, above],
        (Some(&below), _) => [below, below * 10.0],
        _ => DARK,
    }
}

/// Values for lines within a range, its ends left out.
pub(super) fn values([least, most]: [f64; 2]) -> Vec<f64> {
    let within = |steps: &&[f64]| {
        let mut numbers = round(steps, least, most);
        numbers.retain(|&number| least < number && number < most);
        numbers
    };
    let lists = STEPS.iter().map(within);
    let mut lists = lists.filter(|list| list.len() <= LINES);
    lists.next().unwrap_or_default()
}

/// These numbers times powers of ten, from `least` to `most` at least.
fn round(steps: &[f64], least: f64, most: f64) -> Vec<f64> {
    let powers = libm::log10(least).floor() as i32..=libm::log10(most).ceil() as i32;
    let numbers = powers.flat_map(|power| {
        // As a text, so that 0.3 is what is written like that.
        steps
            .iter()
            .filter_map(move |step| format!("{step}e{power}").parse::<f64>().ok())
    });
    numbers.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use candela::image::Window;

    fn of(values: &[f32]) -> [f64; 2] {
        let window = Window::whole([values.len() as u32, 1]);
        range(Some(&Field::new(window, values.to_vec())))
    }

    #[test]
    fn ranges_are_round_and_hold_the_picture() {
        assert_eq!(of(&[63.0, 120.0, 480.0]), [50.0, 500.0]);
        assert_eq!(of(&[20.0, 1000.0]), [20.0, 1000.0]);
        assert_eq!(of(&[0.0, 0.3, 0.9]), [0.2, 1.0]);
        assert_eq!(of(&[300.0, 300.0]), [200.0, 500.0]);
        // Shadows do not count without end.
        assert_eq!(of(&[1e-9, 0.001, 900.0]), [2.0, 1000.0]);
        assert_eq!(of(&[0.0, f32::NAN]), DARK);
        assert_eq!(range(None), DARK);
    }

    /// EN 12464-1:2021, 5.3.2, the scale of illuminances.
    #[test]
    fn values_are_those_of_lighting() {
        let office = values([40.0, 2000.0]);
        assert_eq!(
            office,
            [
                50.0, 75.0, 100.0, 150.0, 200.0, 300.0, 500.0, 750.0, 1000.0, 1500.0
            ]
        );
        let wide = values([1.0, 1000.0]);
        assert_eq!(
            wide,
            [
                2.0, 3.0, 5.0, 10.0, 20.0, 30.0, 50.0, 100.0, 200.0, 300.0, 500.0
            ]
        );
        assert_eq!(values([0.1, 1e4]).len(), 9);
        assert_eq!(values([1e-3, 1.0]).len(), 11);
        assert_eq!(
            values([1e-4, 1e4]),
            [1e-3, 0.01, 0.1, 1.0, 10.0, 100.0, 1e3]
        );
    }
}
