//! Slopes: how fast errors fall.

/// The exponent a of y = c xᵃ through these points: the line of least squares through their logarithms. `None` of fewer
/// than three points, or where all have the same x. Range of the numbers: above 0, finite.
pub(super) fn slope(points: &[[f64; 2]]) -> Option<f64> {
    if points.len() < 3 {
        return None;
    }
    let logarithms: Vec<[f64; 2]> = points.iter().map(|point| point.map(f64::ln)).collect();
    let count = logarithms.len() as f64;
    let mean = |axis: usize| logarithms.iter().map(|point| point[axis]).sum::<f64>() / count;
    let [x, y] = [mean(0), mean(1)];
    let along: f64 = logarithms.iter().map(|point| (point[0] - x).powi(2)).sum();
    let both = logarithms
        .iter()
        .map(|point| (point[0] - x) * (point[1] - y));
    let slope = both.sum::<f64>() / along;
    slope.is_finite().then_some(slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_of_a_power_law() {
        let law = |exponent: f64| -> Vec<[f64; 2]> {
            let at = [0.01, 0.04, 0.3, 2.0, 17.0];
            at.iter()
                .map(|&x: &f64| [x, 3.0 * x.powf(exponent)])
                .collect()
        };
        for exponent in [-0.75, -0.5, -1.0, 0.0, 2.0] {
            let found = slope(&law(exponent)).unwrap();
            assert!((found - exponent).abs() < 1e-13, "{found}");
        }
        assert_eq!(slope(&law(-0.75)[..2]), None);
        assert_eq!(slope(&[[1.0, 1.0], [1.0, 2.0], [1.0, 3.0]]), None);
    }
}
