//! A polynomial for a function of a cosine.

use std::f64::consts::PI;

use crate::math::DVec3;

/// The largest degree of a polynomial for T.
pub(super) const MOST_DEGREE: usize = 4;

/// The largest sum of coefficients: integrals are off by 1e-12, which becomes 1e-8.
const LARGEST: f64 = 1e4;

/// A polynomial in the cosine to an axis.
pub(super) struct Fit {
    pub(super) axis: DVec3,
    pub(super) degree: usize,
    pub(super) coefficients: [f64; MOST_DEGREE + 1],
    /// Of the cosines.
    pub(super) middle: f64,
    half: f64,
    /// How far it is off.
    pub(super) off: f64,
}

impl Fit {
    /// Through Chebyshev's points.
    pub(super) fn of_degree(
        degree: usize,
        axis: DVec3,
        [middle, half]: [f64; 2],
        function: &impl Fn(f64) -> f64,
    ) -> Self {
        let count = degree + 1;
        let at = |number: f64| middle + half * (PI * number / count as f64).cos();
        let mut places = [0.0; MOST_DEGREE + 1];
        let mut differences = [0.0; MOST_DEGREE + 1];
        for number in 0..count {
            places[number] = at(number as f64 + 0.5);
            differences[number] = function(places[number]);
        }
        // Newton's divided differences, and then powers.
        for order in 1..count {
            for number in (order..count).rev() {
                let apart = places[number] - places[number - order];
                let difference = differences[number] - differences[number - 1];
                differences[number] = if apart == 0.0 {
                    0.0
                } else {
                    difference / apart
                };
            }
        }
        let mut coefficients = [0.0; MOST_DEGREE + 1];
        for number in (0..count).rev() {
            for power in (1..count).rev() {
                coefficients[power] =
                    coefficients[power - 1] - places[number] * coefficients[power];
            }
            coefficients[0] = differences[number] - places[number] * coefficients[0];
        }
        let mut fit = Self {
            axis,
            degree,
            coefficients,
            middle,
            half,
            off: 0.0,
        };
        // It is most off between the points and at the ends.
        for number in 0..=count {
            let cosine = at(number as f64);
            fit.off = fit.off.max((function(cosine) - fit.at(cosine)).abs());
        }
        fit
    }

    pub(super) fn at(&self, cosine: f64) -> f64 {
        let coefficients = self.coefficients[..=self.degree].iter().rev();
        coefficients.fold(0.0, |sum, coefficient| sum * cosine + coefficient)
    }

    /// Whether its coefficients are so small that integrals of powers may be as far off as they are rounded.
    pub(super) fn is_steady(&self) -> bool {
        let coefficients = self.coefficients[..=self.degree].iter();
        coefficients
            .map(|coefficient| coefficient.abs())
            .sum::<f64>()
            <= LARGEST
    }

    /// How much it differs, where it does not turn.
    pub(super) fn spread(&self) -> f64 {
        let ends = [self.middle - self.half, self.middle + self.half];
        let [least, most] = ends.map(|cosine| self.at(cosine));
        (most - least).abs()
    }

    /// a and b of a + b c, which is the same at the ends.
    pub(super) fn line(&self) -> [f64; 2] {
        let [least, most] = [self.middle - self.half, self.middle + self.half];
        if self.half <= 0.0 {
            return [self.at(self.middle), 0.0];
        }
        let slope = (self.at(most) - self.at(least)) / (most - least);
        [self.at(least) - slope * least, slope]
    }
}

/// A linear function of a direction, a + Σ b v·u: a product of functions of cosines, about.
pub(super) struct Line {
    pub(super) constant: f64,
    /// v and b
    pub(super) slopes: Vec<(DVec3, f64)>,
    /// Whether it is taken away for the lobe as well.
    pub(super) has_lobe: bool,
}

impl Line {
    pub(super) const NONE: Self = Self {
        constant: 0.0,
        slopes: Vec::new(),
        has_lobe: false,
    };

    /// The product of polynomials, linear around the middle of each.
    pub(super) fn of(fits: &[Fit]) -> Self {
        let lines: Vec<[f64; 2]> = fits.iter().map(Fit::line).collect();
        let at_middle = |place: usize| lines[place][0] + lines[place][1] * fits[place].middle;
        let product: f64 = (0..fits.len()).map(at_middle).product();
        let mut constant = product;
        let mut slopes = Vec::with_capacity(fits.len());
        for (place, fit) in fits.iter().enumerate() {
            let others = (0..fits.len()).filter(|&other| other != place);
            let slope = lines[place][1] * others.map(at_middle).product::<f64>();
            if slope.abs() <= LARGEST {
                constant -= slope * fit.middle;
                slopes.push((fit.axis, slope));
            }
        }
        Self {
            constant,
            slopes,
            has_lobe: false,
        }
    }

    /// Along a unit vector.
    pub(super) fn at(&self, way: DVec3) -> f64 {
        let slopes = self.slopes.iter();
        slopes.fold(self.constant, |sum, (axis, slope)| {
            sum + slope * axis.dot(way)
        })
    }
}
