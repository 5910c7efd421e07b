//! Kronrod's rule of 15 points, and Gauss's of 7 among them: what they differ by is more than the larger one is off.

/// Places from −1 to 1, of which there are as many below 0, with the weights of both rules (QUADPACK, `qk15`).
const NODES: [[f64; 3]; 8] = [
    [0.991_455_371_120_812_6, 0.022_935_322_010_529_224, 0.0],
    [
        0.949_107_912_342_758_5,
        0.063_092_092_629_978_56,
        0.129_484_966_168_869_7,
    ],
    [0.864_864_423_359_769_1, 0.104_790_010_322_250_19, 0.0],
    [
        0.741_531_185_599_394_4,
        0.140_653_259_715_525_92,
        0.279_705_391_489_276_64,
    ],
    [0.586_087_235_467_691_1, 0.169_004_726_639_267_9, 0.0],
    [
        0.405_845_151_377_397_2,
        0.190_350_578_064_785_4,
        0.381_830_050_505_118_9,
    ],
    [0.207_784_955_007_898_47, 0.204_432_940_075_298_89, 0.0],
    [0.0, 0.209_482_141_084_727_82, 0.417_959_183_673_469_4],
];

/// The places between two ends, with the weights of both rules.
pub(super) fn nodes([from, to]: [f64; 2]) -> impl Iterator<Item = [f64; 3]> {
    let (middle, semi) = (0.5 * (from + to), 0.5 * (to - from));
    NODES.iter().flat_map(move |&[place, fine, coarse]| {
        let at = move |place: f64| [middle + semi * place, semi * fine, semi * coarse];
        let other = (place > 0.0).then(|| at(-place));
        std::iter::once(at(place)).chain(other)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_up_to_the_degree_are_exact() {
        for power in 0..=22 {
            let sum = |of: usize| -> f64 {
                nodes([0.0, 1.0])
                    .map(|node| node[of] * node[0].powi(power))
                    .sum()
            };
            let exact = 1.0 / f64::from(power + 1);
            assert!((sum(1) / exact - 1.0).abs() < 4e-15, "{power}: {}", sum(1));
            if power < 14 {
                assert!((sum(2) / exact - 1.0).abs() < 4e-15, "{power}: {}", sum(2));
            }
        }
        assert_eq!(nodes([0.0, 1.0]).count(), 15);
    }
}
