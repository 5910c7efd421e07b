//! Numbers for reading.

/// A number with six significant digits and no zeros at its end: for reading; JSON has them all.
pub(super) fn number(value: f64) -> String {
    const DIGITS: i32 = 6;
    if value == 0.0 || !value.is_finite() {
        // Without the sign that −0 has.
        return format!("{}", value + 0.0);
    }
    // Rounded first: 0.99999996 has its first digit before the point.
    let scientific = format!("{value:.*e}", (DIGITS - 1) as usize);
    let Some((mantissa, exponent)) = scientific.split_once('e') else {
        return scientific;
    };
    match exponent.parse::<i32>() {
        Ok(exponent @ -4..=DIGITS) => {
            let decimals = (DIGITS - 1 - exponent).max(0);
            without_zeros(&format!("{value:.*}", decimals as usize)).to_owned()
        }
        Ok(_) | Err(_) => format!("{}e{exponent}", without_zeros(mantissa)),
    }
}

/// `1.50` → `1.5`, `2.00` → `2`, `100` → `100`
fn without_zeros(number: &str) -> &str {
    if number.contains('.') {
        number.trim_end_matches('0').trim_end_matches('.')
    } else {
        number
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn six_significant_digits() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (1.0, "1"),
            (-30.0, "-30"),
            (0.1 + 0.2, "0.3"),
            (2.0 / 3.0, "0.666667"),
            (1e6 / 3.0, "333333"),
            (0.999_999_96, "1"),
            (0.000_123_456_78, "0.000123457"),
            (1.234_567_8e-9, "1.23457e-9"),
            (1.5e11, "1.5e11"),
            (1_234_567.0, "1234567"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(number(value), text);
        }
    }
}
