//! The CIE's illuminants by name.

use super::cubic::cubic;
use super::daylight::{daylight, white};
use super::{Spectrum, tables};

/// An illuminant of the CIE, relative: only its shape counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Illuminant {
    name: &'static str,
    form: Form,
}

/// Where an illuminant's numbers come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Form {
    /// The tungsten lamp, by its own formula.
    A,
    /// The same at every wavelength.
    EqualEnergy,
    /// Daylight of this nominal temperature in K.
    Daylight(u16),
    /// The daylight that is white in RGB.
    White,
    /// From a table's column of its name.
    Fluorescent,
    Led,
    Discharge,
}

/// T_nominal · 1.4388/1.4380: c₂ has changed since the D illuminants got their names (CIE 15:2018).
const DAYLIGHT_CORRECTION: f64 = 1.4388 / 1.4380;

impl Illuminant {
    /// The daylight that is white in every RGB space.
    pub const D65: Self = Self::ALL[4];

    /// Every illuminant, in the order of the documentation.
    pub const ALL: [Self; 32] = {
        const fn illuminant(name: &'static str, form: Form) -> Illuminant {
            Illuminant { name, form }
        }
        [
            illuminant("A", Form::A),
            illuminant("E", Form::EqualEnergy),
            illuminant("D50", Form::Daylight(5000)),
            illuminant("D55", Form::Daylight(5500)),
            illuminant("D65", Form::White),
            illuminant("D75", Form::Daylight(7500)),
            illuminant("F1", Form::Fluorescent),
            illuminant("F2", Form::Fluorescent),
            illuminant("F3", Form::Fluorescent),
            illuminant("F4", Form::Fluorescent),
            illuminant("F5", Form::Fluorescent),
            illuminant("F6", Form::Fluorescent),
            illuminant("F7", Form::Fluorescent),
            illuminant("F8", Form::Fluorescent),
            illuminant("F9", Form::Fluorescent),
            illuminant("F10", Form::Fluorescent),
            illuminant("F11", Form::Fluorescent),
            illuminant("F12", Form::Fluorescent),
            illuminant("LED-B1", Form::Led),
            illuminant("LED-B2", Form::Led),
            illuminant("LED-B3", Form::Led),
            illuminant("LED-B4", Form::Led),
            illuminant("LED-B5", Form::Led),
            illuminant("LED-BH1", Form::Led),
            illuminant("LED-RGB1", Form::Led),
            illuminant("LED-V1", Form::Led),
            illuminant("LED-V2", Form::Led),
            illuminant("HP1", Form::Discharge),
            illuminant("HP2", Form::Discharge),
            illuminant("HP3", Form::Discharge),
            illuminant("HP4", Form::Discharge),
            illuminant("HP5", Form::Discharge),
        ]
    };

    /// The illuminant of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|illuminant| illuminant.name == name)
    }

    /// Its name, as the CIE and a scene file have it.
    pub const fn name(self) -> &'static str {
        self.name
    }

    /// Its relative spectrum on the grid; lamps are cubic between the 5 nm of their tables, and constant beyond 380
    /// and 780 nm, so that their sums at 1 nm are the CIE's at 5 nm (CIE 15:2018).
    pub fn spectrum(self) -> Spectrum {
        match self.form {
            Form::A => Spectrum::from_fn(illuminant_a),
            Form::EqualEnergy => Spectrum::constant(1.0),
            Form::Daylight(nominal) => daylight(f64::from(nominal) * DAYLIGHT_CORRECTION),
            Form::White => white(),
            Form::Fluorescent => self.tabulated(tables::fluorescent()),
            Form::Led => self.tabulated(tables::led()),
            Form::Discharge => self.tabulated(tables::discharge()),
        }
    }

    fn tabulated(self, table: &tables::Table) -> Spectrum {
        cubic(table.wavelengths(), table.column(self.name))
    }
}

/// A(λ) = 100 (560/λ)⁵ [exp(1.435e7/(2848·560)) − 1] / [exp(1.435e7/(2848 λ)) − 1]
/// (ISO/CIE 11664-2)
fn illuminant_a(nm: f64) -> f64 {
    let planck = |nm: f64| libm::expm1(1.435e7 / (2848.0 * nm));
    let ratio = 560.0 / nm;
    100.0 * ratio * ratio * ratio * ratio * ratio * planck(560.0) / planck(nm)
}

#[cfg(test)]
mod tests {
    use super::super::{FIRST, Observer, blackbody};
    use super::*;

    fn xy([x, y, z]: [f64; 3]) -> [f64; 2] {
        [x / (x + y + z), y / (x + y + z)]
    }

    /// The sums over the 5 nm of the tables are the CIE's own.
    #[test]
    fn lamps_have_their_sums_at_5_nm() {
        let mut worst = (0.0_f64, "");
        for table in [tables::fluorescent(), tables::led(), tables::discharge()] {
            for &name in table.names() {
                let spectrum = Illuminant::named(name).unwrap().spectrum();
                assert!(
                    spectrum.values().iter().all(|&value| value >= 0.0),
                    "{name}"
                );
                for observer in Observer::ALL {
                    let points = table.wavelengths().iter().zip(table.column(name));
                    let mut sums = [0.0; 3];
                    for (nm, value) in points {
                        let place = (nm - f64::from(FIRST)) as usize;
                        for (sum, matching) in sums.iter_mut().zip(observer.color_matching()) {
                            *sum += value * matching[place];
                        }
                    }
                    let expected = xy(sums);
                    let actual = xy(observer.xyz(&spectrum));
                    for (actual, expected) in actual.iter().zip(expected) {
                        let error = (actual - expected).abs();
                        worst = if error > worst.0 {
                            (error, name)
                        } else {
                            worst
                        };
                    }
                }
            }
        }
        // At 1 nm a part of the power is on either side of a point, where the matching functions bend.
        assert!(worst.0 < 6e-5 && worst.0 > 1.5e-5, "{worst:?}");
    }

    /// Those of D65 by which RGB spaces are defined (ITU-R BT.709-6); of A, sums over 5 nm, 380–780 nm, from
    /// colour-science 0.4.7.
    #[test]
    fn standard_illuminants_have_the_published_chromaticities() {
        for (name, x, y, bound) in [
            ("D65", 0.3127, 0.3290, 1e-14),
            ("A", 0.447_575, 0.407_446, 1e-5),
        ] {
            let [actual_x, actual_y] =
                xy(Observer::Cie1931.xyz(&Illuminant::named(name).unwrap().spectrum()));
            let error = (actual_x - x).abs().max((actual_y - y).abs());
            assert!(error < bound, "{name}: {actual_x} {actual_y}");
        }
    }

    #[test]
    fn black_bodies_have_the_published_chromaticities() {
        for (temperature, x, y) in [
            (2000.0, 0.526_677, 0.413_297),
            (3200.0, 0.423_360, 0.398_952),
            (5000.0, 0.345_101, 0.351_608),
            (10_000.0, 0.280_634, 0.288_288),
        ] {
            let [actual_x, actual_y] = xy(Observer::Cie1931.xyz(&blackbody(temperature)));
            assert!((actual_x - x).abs() < 2e-6 && (actual_y - y).abs() < 2e-6);
        }
    }

    #[test]
    fn names_are_unique_and_found() {
        for illuminant in Illuminant::ALL {
            assert_eq!(Illuminant::named(illuminant.name()), Some(illuminant));
            assert!(illuminant.spectrum().total() > 0.0);
        }
        assert_eq!(Illuminant::D65.name(), "D65");
        assert_eq!(Illuminant::named("D66"), None);
    }
}
