//! Glasses, and a few other clear bodies, by name.
//!
//! Numbers are the published ones, as the database of refractiveindex.info (M. N. Polyanskiy, Scientific Data 11, 94,
//! 2024; CC0 1.0) has them; the file of each is below, under its folder `database/data`. Those of Schott are its catalog
//! of 20 January 2017, at 20 °C. Glasses and silica are relative to air, water to vacuum (1.00027 times as large).

use super::sellmeier::Sellmeier;

/// A clear body whose index is published.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Glass {
    /// What the maker's catalog calls it, or its common name in lower case.
    pub(crate) name: &'static str,
    /// Its index over the wavelength.
    pub(crate) dispersion: Sellmeier,
    /// The wavelengths that it was fitted to, in nm. Where they end within 360 to 830 nm the formula goes on smoothly.
    pub(crate) fitted: [f64; 2],
    /// Who published it.
    pub(crate) source: &'static str,
}

impl Glass {
    /// The glass of this name.
    pub(crate) fn named(name: &str) -> Option<&'static Self> {
        Self::ALL.iter().find(|glass| glass.name == name)
    }

    /// The names of all, in the order of the documentation.
    pub(crate) fn names() -> impl Iterator<Item = &'static str> {
        Self::ALL.iter().map(|glass| glass.name)
    }

    /// Every glass: crowns, flints, then the rest.
    pub(crate) const ALL: [Self; 16] = [
        // specs/schott/optical/N-FK51A.yml
        Self {
            name: "N-FK51A",
            dispersion: Sellmeier::three(
                [0.971247817, 0.216901417, 0.904651666],
                [0.00472301995, 0.0153575612, 168.68133],
            ),
            fitted: [290.0, 2500.0],
            source: "Schott",
        },
        // specs/schott/optical/N-BK7.yml
        Self {
            name: "N-BK7",
            dispersion: Sellmeier::three(
                [1.03961212, 0.231792344, 1.01046945],
                [0.00600069867, 0.0200179144, 103.560653],
            ),
            fitted: [300.0, 2500.0],
            source: "Schott",
        },
        // specs/schott/optical/N-K5.yml
        Self {
            name: "N-K5",
            dispersion: Sellmeier::three(
                [1.08511833, 0.199562005, 0.930511663],
                [0.00661099503, 0.024110866, 111.982777],
            ),
            fitted: [310.0, 2500.0],
            source: "Schott",
        },
        // specs/schott/optical/N-BAK4.yml
        Self {
            name: "N-BAK4",
            dispersion: Sellmeier::three(
                [1.28834642, 0.132817724, 0.945395373],
                [0.00779980626, 0.0315631177, 105.965875],
            ),
            fitted: [334.0, 2500.0],
            source: "Schott",
        },
        // specs/schott/optical/N-SK16.yml
        Self {
            name: "N-SK16",
            dispersion: Sellmeier::three(
                [1.34317774, 0.241144399, 0.994317969],
                [0.00704687339, 0.0229005, 92.7508526],
            ),
            fitted: [310.0, 2500.0],
            source: "Schott",
        },
        // specs/schott/optical/N-LAK10.yml
        Self {
            name: "N-LAK10",
            dispersion: Sellmeier::three(
                [1.72878017, 0.169257825, 1.19386956],
                [0.00886014635, 0.0363416509, 82.9009069],
            ),
            fitted: [350.0, 2500.0],
            source: "Schott",
        },
        // specs/schott/optical/F2.yml
        Self {
            name: "F2",
            dispersion: Sellmeier::three(
                [1.34533359, 0.209073176, 0.937357162],
                [0.00997743871, 0.0470450767, 111.886764],
            ),
            fitted: [320.0, 2500.0],
            source: "Schott",
        },
        // specs/schott/optical/N-F2.yml
        Self {
            name: "N-F2",
            dispersion: Sellmeier::three(
                [1.39757037, 0.159201403, 1.2686543],
                [0.00995906143, 0.0546931752, 119.248346],
            ),
            fitted: [365.0, 2500.0],
            source: "Schott",
        },
        // specs/schott/optical/N-SF11.yml
        Self {
            name: "N-SF11",
            dispersion: Sellmeier::three(
                [1.73759695, 0.313747346, 1.89878101],
                [0.013188707, 0.0623068142, 155.23629],
            ),
            fitted: [370.0, 2500.0],
            source: "Schott",
        },
        // specs/schott/optical/N-SF6.yml
        Self {
            name: "N-SF6",
            dispersion: Sellmeier::three(
                [1.77931763, 0.338149866, 2.08734474],
                [0.0133714182, 0.0617533621, 174.01759],
            ),
            fitted: [370.0, 2500.0],
            source: "Schott",
        },
        // specs/schott/optical/N-SF66.yml
        Self {
            name: "N-SF66",
            dispersion: Sellmeier::three(
                [2.0245976, 0.470187196, 2.59970433],
                [0.0147053225, 0.0692998276, 161.817601],
            ),
            fitted: [390.0, 2500.0],
            source: "Schott",
        },
        // main/SiO2/nk/Malitson.yml: J. Opt. Soc. Am. 55, 1205; 20 °C.
        Self {
            name: "fused-silica",
            dispersion: Sellmeier::three(
                [0.6961663, 0.4079426, 0.8974794],
                [squared(0.0684043), squared(0.1162414), squared(9.896161)],
            ),
            fitted: [210.0, 6700.0],
            source: "Malitson 1965",
        },
        // main/CaF2/nk/Malitson.yml: Appl. Opt. 2, 1103; 24 °C.
        Self {
            name: "calcium-fluoride",
            dispersion: Sellmeier::three(
                [0.5675888, 0.4710914, 3.8484723],
                [squared(0.050263605), squared(0.1003909), squared(34.649040)],
            ),
            fitted: [230.0, 9700.0],
            source: "Malitson 1963",
        },
        // main/Al2O3/nk/Malitson-o.yml: J. Opt. Soc. Am. 62, 1405, and Dodge, Handbook of Laser Science and Technology
        // IV, 1986: the ordinary ray; 20 °C.
        Self {
            name: "sapphire",
            dispersion: Sellmeier::three(
                [1.4313493, 0.65054713, 5.3414021],
                [squared(0.0726631), squared(0.1193242), squared(18.028251)],
            ),
            fitted: [200.0, 5000.0],
            source: "Malitson and Dodge 1972",
        },
        // main/C/nk/Peter.yml: Zeitschrift für Physik 15, 358; room temperature.
        Self {
            name: "diamond",
            dispersion: Sellmeier::three(
                [0.3306, 4.3356, 0.0],
                [squared(0.1750), squared(0.1060), 0.0],
            ),
            fitted: [226.0, 760.0],
            source: "Peter 1923",
        },
        // main/H2O/nk/Daimon-20.0C.yml: Appl. Opt. 46, 3811; 20 °C.
        Self {
            name: "water",
            dispersion: Sellmeier {
                b: [0.5684027565, 0.1726177391, 0.02086189578, 0.1130748688],
                c: [0.005101829712, 0.01821153936, 0.02620722293, 10.69792721],
            },
            fitted: [182.0, 1129.0],
            source: "Daimon and Masumura 2007",
        },
    ];
}

/// C of a resonance that is published as its wavelength.
const fn squared(micrometers: f64) -> f64 {
    micrometers * micrometers
}
