//! The CIE's standard observers.

use std::sync::LazyLock;

use super::tables::{self, Table};
use super::{SAMPLES, Spectrum};

/// Whose color matching functions turn spectra into colors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Observer {
    /// CIE 1931, 2° field: the one that photometry and the RGB spaces are defined by.
    #[default]
    Cie1931,
    /// CIE 1964, 10° field: for large patches of color.
    Cie1964,
}

/// The color matching functions of an observer on the grid.
struct Matching([Box<[f64; SAMPLES]>; 3]);

impl Observer {
    /// Every observer, in the order of the documentation.
    pub const ALL: [Self; 2] = [Self::Cie1931, Self::Cie1964];

    /// The name in a scene file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cie1931 => "1931",
            Self::Cie1964 => "1964",
        }
    }

    /// K_m, in lm/W: luminous intensity is K_m ∫ I(λ) ȳ(λ) dλ.
    ///
    /// 683 for the 2° observer (CIE 018:2019; the SI's 683 at 540 THz is 683.002 at the peak); by the
    /// same definition 683.6 for the 10° observer, whose ȳ is below 1 there (CIE 165:2005).
    pub const fn luminous_efficacy(self) -> f64 {
        match self {
            Self::Cie1931 => 683.0,
            Self::Cie1964 => 683.6,
        }
    }

    /// x̄, ȳ and z̄ on the grid.
    pub fn color_matching(self) -> [&'static [f64; SAMPLES]; 3] {
        static CIE_1931: LazyLock<Matching> = LazyLock::new(|| Matching::of(tables::cie_1931()));
        static CIE_1964: LazyLock<Matching> = LazyLock::new(|| Matching::of(tables::cie_1964()));
        let Matching([x, y, z]) = match self {
            Self::Cie1931 => &*CIE_1931,
            Self::Cie1964 => &*CIE_1964,
        };
        [x, y, z]
    }

    /// X, Y, Z = K_m ∫ S(λ) x̄(λ) dλ, …: for a spectral intensity in W·sr⁻¹·nm⁻¹, Y is in cd.
    pub fn xyz(self, spectrum: &Spectrum) -> [f64; 3] {
        self.color_matching()
            .map(|matching| self.luminous_efficacy() * spectrum.integral(matching))
    }

    /// Y alone.
    pub fn luminous(self, spectrum: &Spectrum) -> f64 {
        let [_, y, _] = self.color_matching();
        self.luminous_efficacy() * spectrum.integral(y)
    }
}

impl Matching {
    fn of(table: &Table) -> Self {
        Self(["x", "y", "z"].map(|name| {
            let column = table.column(name).to_vec().into_boxed_slice();
            Box::try_from(column).expect("the observers' tables are on the grid")
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The candela: 683 lm/W at 540 THz, which is 555.016 nm in air (λ = c/(n ν), n = 1.00028).
    #[test]
    fn efficacies_follow_from_the_candela() {
        for observer in Observer::ALL {
            let [_, y, _] = observer.color_matching();
            let at_540_thz = Spectrum(Box::new(*y)).at(555.016);
            let efficacy = 683.0 / at_540_thz;
            let stated = observer.luminous_efficacy();
            assert!((efficacy - stated).abs() < 0.05, "{efficacy} {stated}");
        }
    }

    #[test]
    fn equal_energy_is_white() {
        // The tables' sums differ by 3e-4 at most.
        for observer in Observer::ALL {
            let [x, y, z] = observer.xyz(&Spectrum::constant(1.0));
            assert!((x / y - 1.0).abs() < 4e-4 && (z / y - 1.0).abs() < 4e-4);
        }
    }
}
