//! cᵏ and (1 − cᵏ)/(1 − c²), which are what lobes are made of.

/// Whole exponents up to this are raised to by multiplication: k roundings of 2⁻⁵³ at most, 2⁻⁴² in all.
const LARGEST_WHOLE: u32 = 1 << 11;

/// k of cᵏ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Power {
    Whole(u32),
    Any(f64),
}

/// [cᵏ, (1 − cᵏ)/(1 − c²)] of four cosines.
pub(super) type Fours = [[f64; 4]; 2];

impl Power {
    /// Of an exponent from 0 on.
    pub(super) fn new(exponent: f64) -> Self {
        let whole = exponent as u32;
        if f64::from(whole) == exponent && whole <= LARGEST_WHOLE {
            Self::Whole(whole)
        } else {
            Self::Any(exponent)
        }
    }

    /// Of four cosines from 0 to 1 and their squared sines, each of which has its own digits.
    #[inline(always)]
    pub(super) fn of(self, cosines: [f64; 4], squared_sines: [f64; 4]) -> Fours {
        match self {
            Self::Whole(exponent) => whole(exponent, cosines),
            Self::Any(exponent) => {
                let mut fours = [[0.0; 4]; 2];
                for lane in 0..4 {
                    let [power, quotient] = any(exponent, cosines[lane], squared_sines[lane]);
                    fours[0][lane] = power;
                    fours[1][lane] = quotient;
                }
                fours
            }
        }
    }
}

/// (1 − z^j)/(1 − z) is 1 + z + … + z^(j−1), of which double as many are the sum times 1 + z^j, and one more adds
/// z^j: no digit cancels. With z = c², cᵏ is z^j or c z^j, and 1 − c z^j = (1 − z^j) + z^j (1 − c).
#[inline(always)]
fn whole(exponent: u32, cosines: [f64; 4]) -> Fours {
    let squares = cosines.map(|c| c * c);
    let half = exponent / 2;
    let (mut powers, mut sums) = ([1.0; 4], [0.0; 4]);
    if half > 0 {
        (powers, sums) = (squares, [1.0; 4]);
        for bit in (0..half.ilog2()).rev() {
            for lane in 0..4 {
                sums[lane] += sums[lane] * powers[lane];
                powers[lane] *= powers[lane];
            }
            if half >> bit & 1 == 1 {
                for lane in 0..4 {
                    sums[lane] += powers[lane];
                    powers[lane] *= squares[lane];
                }
            }
        }
    }
    if exponent % 2 == 1 {
        for lane in 0..4 {
            sums[lane] += powers[lane] / (1.0 + cosines[lane]);
            powers[lane] *= cosines[lane];
        }
    }
    [powers, sums]
}

/// By ln c = ½ ln(1 − sin²), which has all its digits where c is close to 1, and the quotient them where cᵏ is.
pub(super) fn any(exponent: f64, cosine: f64, squared_sine: f64) -> [f64; 2] {
    if squared_sine < f64::MIN_POSITIVE {
        return [1.0, exponent / 2.0];
    }
    if cosine <= 0.0 {
        return [0.0, 1.0 / squared_sine];
    }
    let logarithm = if squared_sine < 0.5 {
        0.5 * libm::log1p(-squared_sine)
    } else {
        libm::log(cosine)
    };
    let less_one = libm::expm1(exponent * logarithm);
    [1.0 + less_one, -less_one / squared_sine]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The two ways are one where both go, down to the smallest angles.
    #[test]
    fn whole_powers_are_those_of_any_number() {
        for exponent in [0, 1, 2, 3, 7, 20, 51, 200, 1023, 2048] {
            for sine in [0.0, 1e-200, 1e-12, 1e-5, 0.01, 0.3, 0.8, 0.999] {
                let cosine = f64::sqrt(1.0 - sine * sine);
                let [powers, quotients] = whole(exponent, [cosine; 4]);
                let [power, quotient] = any(f64::from(exponent), cosine, sine * sine);
                assert!((powers[0] - power).abs() < 1e-12, "{exponent} {sine}");
                let error = (quotients[0] - quotient).abs();
                assert!(error <= 1e-12 * quotient, "{exponent} {sine}");
            }
        }
    }

    #[test]
    fn exponents_are_whole_where_they_are_written_so() {
        assert_eq!(Power::new(50.0), Power::Whole(50));
        assert_eq!(Power::new(12.5), Power::Any(12.5));
        assert_eq!(Power::new(1e9), Power::Any(1e9));
        assert_eq!(Power::new(0.0), Power::Whole(0));
    }
}
