//! Colors as lists of components, in which the equations hold one by one.
//!
//! There are three, red, green and blue, where light is carried as RGB, and 471, one for each nm
//! from 360 to 830, where it is carried spectrally. The equations do not ask which.

/// Light or reflectance, component by component. All that meet have as many.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Components(pub(super) Vec<f64>);

impl Components {
    /// The same `count` times.
    pub(super) fn uniform(value: f64, count: usize) -> Self {
        Self(vec![value; count])
    }

    /// As many zeros.
    pub(super) fn zero(&self) -> Self {
        Self::uniform(0.0, self.0.len())
    }

    pub(super) fn scaled(&self, factor: f64) -> Self {
        Self(self.0.iter().map(|component| component * factor).collect())
    }

    pub(super) fn plus(&self, other: &Self) -> Self {
        let pairs = self.0.iter().zip(&other.0);
        Self(pairs.map(|(a, b)| a + b).collect())
    }

    /// Component by component, as light and reflectance multiply.
    pub(super) fn times(&self, other: &Self) -> Self {
        let pairs = self.0.iter().zip(&other.0);
        Self(pairs.map(|(a, b)| a * b).collect())
    }

    /// What is left of 1: 1 − R.
    pub(super) fn rest(&self) -> Self {
        Self(self.0.iter().map(|component| 1.0 - component).collect())
    }

    /// One of them alone, all others 0.
    pub(super) fn only(&self, place: usize) -> Self {
        let mut alone = self.zero();
        alone.0[place] = self.0[place];
        alone
    }

    /// Whether all are 0.
    pub(super) fn is_zero(&self) -> bool {
        self.0.iter().all(|&component| component == 0.0)
    }

    /// The sum of all: over the grid of wavelengths, the integral.
    pub(super) fn sum(&self) -> f64 {
        self.0.iter().sum()
    }
}
