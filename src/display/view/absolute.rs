//! Luminance as it is: 1 cd/m² in the file is 1 cd/m² on the screen, where its brightness is set to what is
//! said here. x / w, w the luminance of the screen's white.

use fearless_simd::Simd;

use crate::display::lanes::{Rgb, Transform, each};

/// x / w for each channel.
pub(in crate::display) struct Absolute {
    /// w: the luminance of the screen's white in cd/m²; above 0.
    pub(in crate::display) white: f64,
}

impl Transform for Absolute {
    #[inline(always)]
    fn apply<S: Simd>(&self, _: S, rgb: Rgb<S>) -> Rgb<S> {
        each(
            rgb,
            #[inline(always)]
            |luminance| luminance / self.white,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::display::lanes::of_one;

    #[test]
    fn closed_form() {
        assert_eq!(
            of_one(&Absolute { white: 80.0 }, [0.0, 80.0, -8.0]),
            [0.0, 1.0, -0.1]
        );
        assert_eq!(
            of_one(&Absolute { white: 100.0 }, [50.0, 100.0, 200.0]),
            [0.5, 1.0, 2.0]
        );
    }
}
