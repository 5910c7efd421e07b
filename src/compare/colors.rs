//! Errors as colors.

use super::magma::MAGMA;

/// Shows errors over decades: black is none, or as little as the first decade begins with, a light yellow as
/// much as the last ends with, or more; the steps between, by the logarithm, look alike.
///
/// The colors are those of magma: Smith & van der Walt 2015, in matplotlib.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FalseColor {
    /// What is black. Range: above 0.
    pub least: f64,
    /// What is as bright as can be. Range: above `least`.
    pub most: f64,
}

impl FalseColor {
    /// Six decades up to an error as large as what it is an error of.
    pub const RELATIVE: Self = Self {
        least: 1e-6,
        most: 1.0,
    };

    /// sRGB-coded R, G, B of an error.
    pub fn color(&self, error: f64) -> [u8; 3] {
        let part = libm::log(error / self.least) / libm::log(self.most / self.least);
        // `as` makes 0 of what is below, and of NaN.
        let index = (part * 255.0 + 0.5) as u8;
        MAGMA[usize::from(index)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_have_equal_parts() {
        let color = |error: f64| FalseColor::RELATIVE.color(error);
        let at = |part: f64| MAGMA[(part * 255.0).round() as usize];
        assert_eq!([color(0.0), color(1e-7), color(1e-6)], [MAGMA[0]; 3]);
        assert_eq!(color(1e-3), at(0.5));
        assert_eq!(color(1e-2), at(2.0 / 3.0));
        assert_eq!(
            [color(1.0), color(7.0), color(f64::INFINITY)],
            [MAGMA[255]; 3]
        );
    }

    #[test]
    fn brightness_only_grows() {
        // Two neighbors in 8 bits may be equally bright.
        let some = MAGMA.iter().step_by(15);
        let brightness = some.map(|&[r, g, b]| 2 * u32::from(r) + 7 * u32::from(g) + u32::from(b));
        assert!(brightness.is_sorted_by(|a, b| a < b));
    }
}
