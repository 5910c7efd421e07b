//! Units other than nm, by which numbers that are no wavelengths of the grid are recognized.

use std::fmt;

use super::is_on_grid;

/// A unit in which spectra are tabulated, other than nm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WavelengthUnit {
    /// µm
    Micrometer,
    /// Å, 0.1 nm
    Angstrom,
    /// cm⁻¹, the wavenumber 1/λ
    Wavenumber,
    /// eV, the photon's energy h c/λ
    Electronvolt,
    /// m
    Meter,
    /// mm
    Millimeter,
    /// Hz, the frequency c/λ
    Hertz,
}

impl WavelengthUnit {
    /// All of them, the most usual first.
    pub const ALL: [Self; 7] = [
        Self::Micrometer,
        Self::Angstrom,
        Self::Wavenumber,
        Self::Electronvolt,
        Self::Meter,
        Self::Millimeter,
        Self::Hertz,
    ];

    /// The wavelength in nm that a number of this unit is.
    pub fn nm(self, number: f64) -> f64 {
        match self {
            Self::Micrometer => number * 1e3,
            Self::Angstrom => number * 0.1,
            Self::Wavenumber => 1e7 / number,
            // h c by the SI's exact values of h, c and e.
            Self::Electronvolt => 1_239.841_984 / number,
            Self::Meter => number * 1e9,
            Self::Millimeter => number * 1e6,
            Self::Hertz => 299_792_458e9 / number,
        }
    }

    /// How to get nm from it.
    pub const fn in_nm(self) -> &'static str {
        match self {
            Self::Micrometer => "1 µm is 1000 nm",
            Self::Angstrom => "10 Å are 1 nm",
            Self::Wavenumber => "x cm⁻¹ are 1e7/x nm",
            Self::Electronvolt => "x eV are 1239.84/x nm",
            Self::Meter => "1 m is 1e9 nm",
            Self::Millimeter => "1 mm is 1e6 nm",
            Self::Hertz => "x Hz are 2.998e17/x nm",
        }
    }

    /// The units in which some of `numbers` would be wavelengths on the grid's range.
    pub(super) fn likely(numbers: &[f64]) -> Vec<Self> {
        let fits = |unit: &Self| numbers.iter().any(|&number| is_on_grid(unit.nm(number)));
        Self::ALL.into_iter().filter(fits).collect()
    }
}

impl fmt::Display for WavelengthUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Micrometer => "µm",
            Self::Angstrom => "Å",
            Self::Wavenumber => "cm⁻¹",
            Self::Electronvolt => "eV",
            Self::Meter => "m",
            Self::Millimeter => "mm",
            Self::Hertz => "Hz",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_unit_has_550_nm() {
        for (unit, number) in WavelengthUnit::ALL.into_iter().zip([
            0.55,
            5500.0,
            18_181.818_181_818_18,
            2.254_258_152_727_273,
            5.5e-7,
            5.5e-4,
            5.450_771_963_636_364e14,
        ]) {
            assert!((unit.nm(number) / 550.0 - 1.0).abs() < 1e-12, "{unit}");
        }
    }
}
