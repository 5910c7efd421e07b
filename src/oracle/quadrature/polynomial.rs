//! Real roots of polynomials.

/// The roots of a s² + 2 b s + c; not a number where there are none.
pub(super) fn quadratic(a: f64, b: f64, c: f64) -> [f64; 2] {
    let root = (b * b - a * c).sqrt();
    let larger = -(b + root.copysign(b));
    [larger / a, c / larger]
}

/// Adds the product of two polynomials, times a factor; coefficients begin with the constant.
pub(super) fn sum_of_products(a: &[f64], b: &[f64], factor: f64, sum: &mut [f64]) {
    for (i, a) in a.iter().enumerate() {
        for (j, b) in b.iter().enumerate() {
            sum[i + j] += factor * a * b;
        }
    }
}

fn value(coefficients: &[f64], at: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * at + c)
}

/// The roots within a range that is about 1 wide, and where the polynomial touches 0 up to its last digits.
pub(super) fn roots(coefficients: &[f64], [from, to]: [f64; 2]) -> Vec<f64> {
    let size: f64 = coefficients.iter().map(|c| c.abs()).sum();
    if coefficients.len() < 2 || size == 0.0 {
        return Vec::new();
    }
    // Between the roots of its derivative it only rises or only falls.
    let derivative: Vec<f64> = coefficients[1..]
        .iter()
        .zip(1_i32..)
        .map(|(c, power)| f64::from(power) * c)
        .collect();
    let turns = roots(&derivative, [from, to]);
    let mut found = Vec::new();
    let mut low = from;
    for high in turns.iter().copied().chain([to]) {
        found.extend(bisected(coefficients, [low, high]));
        low = high;
    }
    let touches = |&turn: &f64| value(coefficients, turn).abs() <= 1e-12 * size;
    found.extend(turns.into_iter().filter(touches));
    found.sort_by(f64::total_cmp);
    found
}

/// Where the sign changes.
fn bisected(coefficients: &[f64], [mut low, mut high]: [f64; 2]) -> Option<f64> {
    let is_low = value(coefficients, low) < 0.0;
    if is_low == (value(coefficients, high) < 0.0) {
        return None;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if (value(coefficients, middle) < 0.0) == is_low {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_of_a_quartic() {
        // (x − 0.5)² (x + 0.25) (x − 3)
        let mut quartic = [0.0; 5];
        let square = [0.25, -1.0, 1.0];
        sum_of_products(&square, &[-0.75, -2.75, 1.0], 1.0, &mut quartic);
        let found = roots(&quartic, [-1.0, 1.0]);
        let is_near = |root: f64| found.iter().any(|at| (at - root).abs() < 1e-7);
        assert!(is_near(-0.25) && is_near(0.5), "{found:?}");
        assert!(
            found
                .iter()
                .all(|at| (at + 0.25).abs().min((at - 0.5).abs()) < 1e-7)
        );
    }
}
