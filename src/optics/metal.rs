//! Metals by name.
//!
//! Numbers are the published ones, as the database of refractiveindex.info (M. N. Polyanskiy, Scientific Data 11, 94,
//! 2024; CC0 1.0) has them; the file of each is below, under its folder `database/data`. Points are those between 354 and
//! 900 nm; aluminum has one below. All are of evaporated films in good order: a polished or tarnished metal is darker.

/// A metal whose complex index n + i k is published.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Metal {
    /// Its name in lower case.
    pub(crate) name: &'static str,
    /// Who published it.
    pub(crate) source: &'static str,
    /// [λ in nm, n, k] at ascending wavelengths, from below 360 to above 830 nm.
    pub(crate) points: &'static [[f64; 3]],
}

impl Metal {
    /// The metal of this name.
    pub(crate) fn named(name: &str) -> Option<&'static Self> {
        Self::ALL.iter().find(|metal| metal.name == name)
    }

    /// The names of all, in the order of the documentation.
    pub(crate) fn names() -> impl Iterator<Item = &'static str> {
        Self::ALL.iter().map(|metal| metal.name)
    }

    /// [n, k] at a wavelength: n and k are each linear between their points, and constant beyond them.
    pub(crate) fn index(&self, nm: f64) -> [f64; 2] {
        let above = self.points.partition_point(|point| point[0] <= nm);
        let last = self.points.len() - 1;
        let [[from_nm, from_n, from_k], [to_nm, to_n, to_k]] =
            [above.saturating_sub(1), above.min(last)].map(|place| self.points[place]);
        // Beyond the points both are the same one.
        if from_nm == to_nm {
            return [from_n, from_k];
        }
        let part = (nm - from_nm) / (to_nm - from_nm);
        [
            from_n * (1.0 - part) + to_n * part,
            from_k * (1.0 - part) + to_k * part,
        ]
    }

    /// Every metal.
    pub(crate) const ALL: [Self; 7] = [
        Self {
            name: "aluminum",
            source: "Rakić 1995",
            points: &ALUMINUM,
        },
        Self {
            name: "copper",
            source: "Johnson and Christy 1972",
            points: &COPPER,
        },
        Self {
            name: "gold",
            source: "Johnson and Christy 1972",
            points: &GOLD,
        },
        Self {
            name: "iron",
            source: "Johnson and Christy 1974",
            points: &IRON,
        },
        Self {
            name: "nickel",
            source: "Johnson and Christy 1974",
            points: &NICKEL,
        },
        Self {
            name: "silver",
            source: "Johnson and Christy 1972",
            points: &SILVER,
        },
        Self {
            name: "titanium",
            source: "Johnson and Christy 1974",
            points: &TITANIUM,
        },
    ];
}

// main/Al/nk/Rakic.yml: Appl. Opt. 34, 4755.
const ALUMINUM: [[f64; 3]; 15] = [
    [326.28, 0.31474, 3.9165],
    [364.66, 0.39877, 4.3957],
    [413.28, 0.52135, 5.0008],
    [442.8, 0.6079, 5.3676],
    [476.87, 0.7278, 5.7781],
    [516.6, 0.8734, 6.2418],
    [563.57, 1.0728, 6.7839],
    [619.93, 1.366, 7.4052],
    [652.25, 1.5724, 7.7354],
    [688.81, 1.8301, 8.0601],
    [729.32, 2.1606, 8.3565],
    [774.91, 2.6154, 8.4914],
    [794.78, 2.7675, 8.3866],
    [815.69, 2.7668, 8.2573],
    [837.74, 2.6945, 8.1878],
];

// main/Cu/nk/Johnson.yml: Phys. Rev. B 6, 4370.
const COPPER: [[f64; 3]; 18] = [
    [354.2, 1.37, 1.916],
    [367.9, 1.36, 1.975],
    [381.5, 1.33, 2.045],
    [397.4, 1.32, 2.116],
    [413.3, 1.28, 2.207],
    [430.5, 1.25, 2.305],
    [450.9, 1.24, 2.397],
    [471.4, 1.25, 2.483],
    [495.9, 1.22, 2.564],
    [520.9, 1.18, 2.608],
    [548.6, 1.02, 2.577],
    [582.1, 0.7, 2.704],
    [616.8, 0.3, 3.205],
    [659.5, 0.22, 3.747],
    [704.5, 0.21, 4.205],
    [756.0, 0.24, 4.665],
    [821.1, 0.26, 5.18],
    [892.0, 0.3, 5.768],
];

// main/Au/nk/Johnson.yml: Phys. Rev. B 6, 4370.
const GOLD: [[f64; 3]; 18] = [
    [354.2, 1.5, 1.866],
    [367.9, 1.48, 1.895],
    [381.5, 1.46, 1.933],
    [397.4, 1.47, 1.952],
    [413.3, 1.46, 1.958],
    [430.5, 1.45, 1.948],
    [450.9, 1.38, 1.914],
    [471.4, 1.31, 1.849],
    [495.9, 1.04, 1.833],
    [520.9, 0.62, 2.081],
    [548.6, 0.43, 2.455],
    [582.1, 0.29, 2.863],
    [616.8, 0.21, 3.272],
    [659.5, 0.14, 3.697],
    [704.5, 0.13, 4.103],
    [756.0, 0.14, 4.542],
    [821.1, 0.16, 5.083],
    [892.0, 0.17, 5.663],
];

// main/Fe/nk/Johnson.yml: Phys. Rev. B 9, 5056.
const IRON: [[f64; 3]; 18] = [
    [354.0, 1.93, 2.35],
    [368.0, 2.02, 2.43],
    [381.0, 2.12, 2.5],
    [397.0, 2.24, 2.58],
    [413.0, 2.35, 2.65],
    [431.0, 2.48, 2.71],
    [451.0, 2.59, 2.77],
    [471.0, 2.67, 2.82],
    [496.0, 2.74, 2.88],
    [521.0, 2.86, 2.91],
    [549.0, 2.95, 2.93],
    [582.0, 2.94, 2.99],
    [617.0, 2.88, 3.05],
    [659.0, 2.92, 3.1],
    [704.0, 2.86, 3.19],
    [756.0, 2.87, 3.28],
    [821.0, 2.94, 3.39],
    [892.0, 2.96, 3.56],
];

// main/Ni/nk/Johnson.yml: Phys. Rev. B 9, 5056.
const NICKEL: [[f64; 3]; 18] = [
    [354.0, 1.74, 2.32],
    [368.0, 1.7, 2.4],
    [381.0, 1.72, 2.48],
    [397.0, 1.72, 2.57],
    [413.0, 1.7, 2.69],
    [431.0, 1.71, 2.82],
    [451.0, 1.73, 2.95],
    [471.0, 1.78, 3.09],
    [496.0, 1.82, 3.25],
    [521.0, 1.85, 3.42],
    [549.0, 1.92, 3.61],
    [582.0, 1.96, 3.8],
    [617.0, 1.99, 4.02],
    [659.0, 1.99, 4.26],
    [704.0, 2.06, 4.5],
    [756.0, 2.13, 4.73],
    [821.0, 2.26, 4.97],
    [892.0, 2.4, 5.23],
];

// main/Ag/nk/Johnson.yml: Phys. Rev. B 6, 4370.
const SILVER: [[f64; 3]; 18] = [
    [354.2, 0.1, 1.419],
    [367.9, 0.07, 1.657],
    [381.5, 0.05, 1.864],
    [397.4, 0.05, 2.07],
    [413.3, 0.05, 2.275],
    [430.5, 0.04, 2.462],
    [450.9, 0.04, 2.657],
    [471.4, 0.05, 2.869],
    [495.9, 0.05, 3.093],
    [520.9, 0.05, 3.324],
    [548.6, 0.06, 3.586],
    [582.1, 0.05, 3.858],
    [616.8, 0.06, 4.152],
    [659.5, 0.05, 4.483],
    [704.5, 0.04, 4.838],
    [756.0, 0.03, 5.242],
    [821.1, 0.04, 5.727],
    [892.0, 0.04, 6.312],
];

// main/Ti/nk/Johnson.yml: Phys. Rev. B 9, 5056.
const TITANIUM: [[f64; 3]; 18] = [
    [354.0, 1.82, 2.87],
    [368.0, 1.9, 2.9],
    [381.0, 1.99, 2.93],
    [397.0, 2.08, 2.95],
    [413.0, 2.14, 2.98],
    [431.0, 2.21, 3.01],
    [451.0, 2.27, 3.04],
    [471.0, 2.32, 3.1],
    [496.0, 2.36, 3.19],
    [521.0, 2.44, 3.3],
    [549.0, 2.54, 3.43],
    [582.0, 2.6, 3.58],
    [617.0, 2.67, 3.72],
    [659.0, 2.76, 3.84],
    [704.0, 2.86, 3.96],
    [756.0, 3.0, 4.01],
    [821.0, 3.21, 4.01],
    [892.0, 3.29, 3.96],
];
