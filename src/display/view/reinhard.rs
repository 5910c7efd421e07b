//! Reinhard et al. 2002, eq. 3: x / (1 + x).
//!
//! The paper has it on luminance. Here it is applied per channel, as most renderers do: on
//! luminance a saturated color keeps channels above 1, which then clip with a shift in hue, while
//! per channel everything stays inside 0 to 1 and strong light bleaches towards white.

/// x / (1 + x) for each channel, 0 below 0.
pub(super) fn apply(rgb: [f64; 3]) -> [f64; 3] {
    // As 1 / (1 + 1/x), since ∞ / (1 + ∞) is not a number.
    rgb.map(|x| 1.0 / (1.0 + 1.0 / x.max(0.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form() {
        let [a, b, c] = apply([0.18, 1.0, 4.0]);
        assert!((a - 0.18 / 1.18).abs() < f64::EPSILON);
        assert!((b - 0.5).abs() < f64::EPSILON);
        assert!((c - 0.8).abs() < f64::EPSILON);
    }
}
