//! Gauss and Legendre's rules on 0 to 1.

/// Places and weights.
pub(super) type Rule = &'static [[f64; 2]];

/// Exact for polynomials of degree 5.
pub(super) const THREE: Rule = &[
    [0.112_701_665_379_258_31, 0.277_777_777_777_777_8],
    [0.5, 0.444_444_444_444_444_4],
    [0.887_298_334_620_741_7, 0.277_777_777_777_777_8],
];

/// Exact for polynomials of degree 9.
pub(super) const FIVE: Rule = &[
    [0.046_910_077_030_668_004, 0.118_463_442_528_094_54],
    [0.230_765_344_947_158_45, 0.239_314_335_249_683_24],
    [0.5, 0.284_444_444_444_444_44],
    [0.769_234_655_052_841_5, 0.239_314_335_249_683_24],
    [0.953_089_922_969_332, 0.118_463_442_528_094_54],
];

/// Exact for polynomials of degree 13.
pub(super) const SEVEN: Rule = &[
    [0.025_446_043_828_620_736, 0.064_742_483_084_434_85],
    [0.129_234_407_200_302_77, 0.139_852_695_744_638_32],
    [0.297_077_424_311_301_4, 0.190_915_025_252_559_46],
    [0.5, 0.208_979_591_836_734_7],
    [0.702_922_575_688_698_5, 0.190_915_025_252_559_46],
    [0.870_765_592_799_697_2, 0.139_852_695_744_638_32],
    [0.974_553_956_171_379_3, 0.064_742_483_084_434_85],
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_up_to_the_degree_are_exact() {
        for (rule, count) in [(THREE, 3), (FIVE, 5), (SEVEN, 7)] {
            assert_eq!(rule.len(), count);
            for power in 0..2 * count as i32 {
                let sum: f64 = rule.iter().map(|[x, weight]| weight * x.powi(power)).sum();
                assert!(
                    (sum * f64::from(power + 1) - 1.0).abs() < 4e-15,
                    "{count} {power}"
                );
            }
        }
    }
}
