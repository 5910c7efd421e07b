//! Functions over a square with proven bounds: what they are, and how much they bend.
//!
//! A square has the coordinates u, v, both from −1 to 1; at the silhouette of a sphere there is a third one, w, which
//! is a function of these (see [`Clip`](super::clip::Clip)). Of a function f over it a [`Model`] knows
//!
//! f = c + g_u u + g_v v + g_w w + e, |e| ≤ r,
//!
//! of which c is the value at the middle, u = v = 0, where there is no w, and bounds on |∂f/∂u|, |∂f/∂v|, |∂²f/∂u²|
//! and |∂²f/∂v²| over the whole square. Sums, products and functions of models are models again (affine arithmetic: de Figueiredo & Stolfi 2004, "Affine Arithmetic: Concepts and
//! Applications"; derivatives by the product and the chain rule). Linear functions are exact, so that what cancels
//! to first order does so here as well.
//!
//! The rounding of the arithmetic itself, some 1e-15 of the numbers, is not tracked: it is far below every error
//! that is told.

use std::ops::{Add, Mul, Neg, Sub};

use crate::math::DVec3;

/// A function over a square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Model {
    /// Its linear part.
    pub(super) center: f64,
    pub(super) slope: [f64; 3],
    /// How far it is from that, at most; infinite where nothing is known.
    pub(super) rest: f64,
    /// At least |∂f/∂u| and |∂f/∂v|.
    first: [f64; 2],
    /// At least |∂²f/∂u²| and |∂²f/∂v²|.
    second: [f64; 2],
}

/// A function's value at one number and bounds on its derivatives over a range.
#[derive(Clone, Copy)]
struct Function {
    value: f64,
    slope: f64,
    /// At least |h′| and |h″| over the range.
    first: f64,
    second: f64,
}

impl Model {
    /// Nothing is known of it.
    pub(super) const UNKNOWN: Self = Self {
        center: 0.0,
        slope: [0.0; 3],
        rest: f64::INFINITY,
        first: [f64::INFINITY; 2],
        second: [f64::INFINITY; 2],
    };

    /// Of all that is known of it; unknown where that has no bound.
    pub(super) fn known(
        center: f64,
        slope: [f64; 3],
        rest: f64,
        first: [f64; 2],
        second: [f64; 2],
    ) -> Self {
        let model = Self {
            center,
            slope,
            rest,
            first,
            second,
        };
        if center.is_finite() && model.radius().is_finite() {
            model
        } else {
            Self::UNKNOWN
        }
    }

    /// c + g_u u + g_v v
    pub(super) fn linear(center: f64, [u, v]: [f64; 2]) -> Self {
        Self {
            center,
            slope: [u, v, 0.0],
            rest: 0.0,
            first: [u.abs(), v.abs()],
            second: [0.0; 2],
        }
    }

    /// c (1 + w), whose derivatives have no bounds.
    pub(super) fn third(center: f64) -> Self {
        Self {
            center,
            slope: [0.0, 0.0, center],
            rest: 0.0,
            first: [f64::INFINITY; 2],
            second: [f64::INFINITY; 2],
        }
    }

    pub(super) fn constant(value: f64) -> Self {
        Self::linear(value, [0.0; 2])
    }

    /// How far it is from its center, at most.
    #[inline]
    fn radius(&self) -> f64 {
        self.along() + self.rest
    }

    /// How far its linear part is from its center, at most.
    fn along(&self) -> f64 {
        let [u, v, w] = self.slope;
        u.abs() + v.abs() + w.abs()
    }

    /// It is at least this.
    pub(super) fn least(&self) -> f64 {
        self.center - self.radius()
    }

    /// It is at most this.
    pub(super) fn most(&self) -> f64 {
        self.center + self.radius()
    }

    /// |f| is at most this.
    pub(super) fn magnitude(&self) -> f64 {
        self.center.abs() + self.radius()
    }

    /// Whether anything is known of it.
    pub(super) fn is_known(&self) -> bool {
        self.rest < f64::INFINITY
    }

    /// How far the mean over a square of half the side `part` within this one is from the value at its middle, at
    /// most.
    ///
    /// f less its tangent is at most ½ M u² along each axis: the mean of u² over −h to h is h²/3.
    pub(super) fn bend(&self, part: f64) -> f64 {
        (self.second[0] + self.second[1]) * (part * part / 6.0)
    }

    /// How far the mean over the whole square is from the value in the middle, at most.
    pub(super) fn mean_error(&self) -> f64 {
        // The linear part is 0 in the mean. (What has no bound may be no number.)
        self.rest.min(self.bend(1.0))
    }

    /// At least the absolute values of its first and second derivatives along an axis of the square.
    pub(super) fn derivatives(&self, axis: usize) -> [f64; 2] {
        [self.first[axis], self.second[axis]]
    }

    /// Its linear part alone.
    pub(super) fn line(self) -> Self {
        Self { rest: 0.0, ..self }
    }

    /// The value of the linear part somewhere.
    pub(super) fn at(&self, place: [f64; 3]) -> f64 {
        let terms = self.slope.iter().zip(place);
        self.center + terms.map(|(slope, place)| slope * place).sum::<f64>()
    }

    /// a f
    #[inline]
    pub(super) fn times(self, factor: f64) -> Self {
        let size = factor.abs();
        Self {
            center: self.center * factor,
            slope: self.slope.map(|slope| slope * factor),
            rest: self.rest * size,
            first: self.first.map(|bound| bound * size),
            second: self.second.map(|bound| bound * size),
        }
    }

    /// f + a
    #[inline]
    pub(super) fn plus(self, number: f64) -> Self {
        Self {
            center: self.center + number,
            ..self
        }
    }

    /// h(f)
    fn through(self, function: Function) -> Self {
        let Function {
            value,
            slope,
            first,
            second,
        } = function;
        let radius = self.radius();
        let along = |axis: usize| {
            let steep = self.first[axis];
            second * steep * steep + first * self.second[axis]
        };
        let model = Self {
            center: value,
            slope: self.slope.map(|along| along * slope),
            rest: slope.abs() * self.rest + 0.5 * second * radius * radius,
            first: self.first.map(|bound| bound * first),
            second: [along(0), along(1)],
        };
        if model.rest.is_finite() {
            model
        } else {
            Self::UNKNOWN
        }
    }

    /// 1/f, for f above 0.
    pub(super) fn reciprocal(self) -> Self {
        let least = self.least();
        let is_above = least > 0.0;
        if !is_above {
            return Self::UNKNOWN;
        }
        let (at, over) = (1.0 / self.center, 1.0 / least);
        self.through(Function {
            value: at,
            slope: -at * at,
            first: over * over,
            second: 2.0 * over * over * over,
        })
    }

    /// √f, for f above 0.
    pub(super) fn root(self) -> Self {
        let least = self.least();
        let is_above = least > 0.0;
        if !is_above {
            return Self::UNKNOWN;
        }
        let (at, lowest) = (self.center.sqrt(), least.sqrt());
        self.through(Function {
            value: at,
            slope: 0.5 / at,
            first: 0.5 / lowest,
            second: 0.25 / (lowest * least),
        })
    }

    /// max(f, 0)ⁿ. Where f changes its sign, nothing is known for n below 2: the slope jumps there.
    pub(super) fn power(self, exponent: f64) -> Self {
        let (least, most) = (self.least(), self.most());
        if most <= 0.0 {
            return Self::constant(0.0);
        }
        if !most.is_finite() || (least <= 0.0 && exponent < 2.0) {
            return Self::UNKNOWN;
        }
        let power = |base: f64, exponent: f64| {
            if base > 0.0 {
                libm::pow(base, exponent)
            } else if exponent == 0.0 {
                1.0
            } else {
                0.0
            }
        };
        // cⁿ⁻² at the end where it is larger; for n between 1 and 2 cⁿ⁻¹ is larger at the other.
        let end = if exponent < 2.0 { least } else { most };
        let at = power(self.center, exponent - 1.0);
        let bend = power(end, exponent - 2.0);
        let first = if (1.0..2.0).contains(&exponent) {
            power(most, exponent - 1.0)
        } else {
            bend * end
        };
        self.through(Function {
            value: at * self.center.max(0.0),
            slope: exponent * at,
            first: exponent * first,
            second: (exponent * (exponent - 1.0)).abs() * bend,
        })
    }

    /// h(f) of an h whose slope does not jump, from h and h′ at a number, and bounds on |h′| and |h″|.
    pub(super) fn bounded(self, h: impl Fn(f64) -> [f64; 2], first: f64, second: f64) -> Self {
        let [value, slope] = h(self.center);
        self.through(Function {
            value,
            slope,
            first,
            second,
        })
    }
}

impl Add for Model {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        let each = |a: [f64; 2], b: [f64; 2]| [a[0] + b[0], a[1] + b[1]];
        let ([u, v, w], [a, b, c]) = (self.slope, other.slope);
        Self {
            center: self.center + other.center,
            slope: [u + a, v + b, w + c],
            rest: self.rest + other.rest,
            first: each(self.first, other.first),
            second: each(self.second, other.second),
        }
    }
}

impl Neg for Model {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self {
            center: -self.center,
            slope: self.slope.map(|slope| -slope),
            ..self
        }
    }
}

impl Sub for Model {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Model {
    type Output = Self;

    #[inline]
    fn mul(self, other: Self) -> Self {
        if !(self.is_known() && other.is_known()) {
            return Self::UNKNOWN;
        }
        let (a, b) = (self.magnitude(), other.magnitude());
        let (along, other_along) = (self.along(), other.along());
        let slope = |axis: usize| self.center * other.slope[axis] + other.center * self.slope[axis];
        let first = |axis: usize| a * other.first[axis] + self.first[axis] * b;
        let second = |axis: usize| {
            a * other.second[axis]
                + 2.0 * self.first[axis] * other.first[axis]
                + self.second[axis] * b
        };
        Self {
            center: self.center * other.center,
            slope: [slope(0), slope(1), slope(2)],
            rest: along * other_along + self.rest * b + other.rest * (self.center.abs() + along),
            first: [first(0), first(1)],
            second: [second(0), second(1)],
        }
    }
}

/// A vector over a square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Vector(pub(super) [Model; 3]);

impl Vector {
    /// c + g_u u + g_v v
    pub(super) fn linear(center: DVec3, slope: [DVec3; 2]) -> Self {
        Self([0, 1, 2].map(|axis| Model::linear(center[axis], [slope[0][axis], slope[1][axis]])))
    }

    pub(super) fn constant(value: DVec3) -> Self {
        Self::linear(value, [DVec3::ZERO; 2])
    }

    /// a · b
    #[inline]
    pub(super) fn dot(self, other: Self) -> Model {
        let [x, y, z] = self.0;
        let [a, b, c] = other.0;
        x * a + y * b + z * c
    }

    /// a · b, of a vector that is the same everywhere.
    #[inline]
    pub(super) fn along(self, direction: DVec3) -> Model {
        let [x, y, z] = self.0;
        x.times(direction.x) + y.times(direction.y) + z.times(direction.z)
    }

    /// a × b
    pub(super) fn cross(self, other: Self) -> Self {
        let [x, y, z] = self.0;
        let [a, b, c] = other.0;
        Self([y * c - z * b, z * a - x * c, x * b - y * a])
    }

    /// f a
    pub(super) fn scaled(self, factor: Model) -> Self {
        Self(self.0.map(|component| component * factor))
    }

    pub(super) fn minus(self, vector: DVec3) -> Self {
        let [x, y, z] = self.0;
        Self([x.plus(-vector.x), y.plus(-vector.y), z.plus(-vector.z)])
    }

    /// The value of the linear part in the middle.
    pub(super) fn center(&self) -> DVec3 {
        self.at([0.0; 3])
    }

    /// The value of the linear part somewhere.
    pub(super) fn at(&self, place: [f64; 3]) -> DVec3 {
        let [x, y, z] = &self.0;
        DVec3::new(x.at(place), y.at(place), z.at(place))
    }

    /// How long a vector of these numbers of its components is.
    fn length_of(&self, number: impl Fn(&Model) -> f64) -> f64 {
        let [x, y, z] = &self.0;
        DVec3::new(number(x), number(y), number(z)).length()
    }

    /// How far its linear part is from its center, at most.
    pub(super) fn reach(&self) -> f64 {
        self.length_of(Model::along)
    }

    /// How far it is from its linear part, at most.
    pub(super) fn rest(&self) -> f64 {
        self.length_of(|component| component.rest)
    }

    /// How far it is from its center, at most.
    pub(super) fn radius(&self) -> f64 {
        self.length_of(Model::radius)
    }

    /// It is at most so long.
    pub(super) fn magnitude(&self) -> f64 {
        self.center().length() + self.radius()
    }

    /// At least the lengths of its first and second derivatives along an axis of the square.
    pub(super) fn derivatives(&self, axis: usize) -> [f64; 2] {
        [
            self.length_of(|component| component.derivatives(axis)[0]),
            self.length_of(|component| component.derivatives(axis)[1]),
        ]
    }

    /// Whether it depends on the third coordinate.
    pub(super) fn has_third(&self) -> bool {
        self.0.iter().any(|component| component.slope[2] != 0.0)
    }

    /// A box around all its values; `None` where nothing is known.
    pub(super) fn bounds(&self) -> Option<[DVec3; 2]> {
        let [x, y, z] = &self.0;
        let least = DVec3::new(x.least(), y.least(), z.least());
        let most = DVec3::new(x.most(), y.most(), z.most());
        (least.is_finite() && most.is_finite()).then_some([least, most])
    }
}

impl Add for Vector {
    type Output = Self;

    #[inline]
    fn add(self, other: Self) -> Self {
        let ([x, y, z], [a, b, c]) = (self.0, other.0);
        Self([x + a, y + b, z + c])
    }
}

impl Neg for Vector {
    type Output = Self;

    #[inline]
    fn neg(self) -> Self {
        Self(self.0.map(|component| -component))
    }
}

impl Sub for Vector {
    type Output = Self;

    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}
