//! From spectra to XYZ to RGB, and from one RGB space to another.

use super::components::Components;
use super::spectrum::{illuminant, integral};
use super::vector::{Vector, dot};
use crate::scene::ColorSpace;
use crate::spectrum::{Observer, tables};

/// Three rows.
type Matrix = [Vector; 3];

/// XYZ to the cone responses of the Bradford transform (ICC.1:2022, annex E).
const BRADFORD: Matrix = [
    [0.8951, 0.2664, -0.1614],
    [-0.7502, 1.7135, 0.0367],
    [0.0389, -0.0685, 1.0296],
];

/// The chromaticities (x, y) of a space's red, green and blue, and of its white.
fn chromaticities(space: ColorSpace) -> ([[f64; 2]; 3], [f64; 2]) {
    const D65: [f64; 2] = [0.3127, 0.3290];
    const ACES: [f64; 2] = [0.32168, 0.33767];
    match space {
        // ITU-R BT.709-6
        ColorSpace::Rec709 => ([[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]], D65),
        // SMPTE EG 432-1, with D65
        ColorSpace::P3D65 => ([[0.680, 0.320], [0.265, 0.690], [0.150, 0.060]], D65),
        // ITU-R BT.2020-2
        ColorSpace::Rec2020 => ([[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]], D65),
        // S-2014-004
        ColorSpace::AcesCg => ([[0.713, 0.293], [0.165, 0.830], [0.128, 0.044]], ACES),
    }
}

/// The XYZ of a chromaticity with Y = 1.
fn xyz_of([x, y]: [f64; 2]) -> Vector {
    [x / y, 1.0, (1.0 - x - y) / y]
}

fn apply(matrix: &Matrix, v: Vector) -> Vector {
    matrix.map(|row| dot(row, v))
}

fn transposed(m: &Matrix) -> Matrix {
    [0, 1, 2].map(|i: usize| m.map(|row| row[i]))
}

/// A B
fn product(a: &Matrix, b: &Matrix) -> Matrix {
    let columns = transposed(b);
    a.map(|row| columns.map(|column| dot(row, column)))
}

/// By cofactors.
pub(super) fn inverse(m: &Matrix) -> Matrix {
    let cofactor = |row: usize, column: usize| {
        let (r, s) = ((row + 1) % 3, (row + 2) % 3);
        let (c, d) = ((column + 1) % 3, (column + 2) % 3);
        m[r][c] * m[s][d] - m[r][d] * m[s][c]
    };
    let determinant: f64 = (0..3)
        .map(|column| m[0][column] * cofactor(0, column))
        .sum();
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| cofactor(column, row) / determinant))
}

/// RGB → XYZ: the primaries as columns, each as strong as makes R = G = B = 1 the white.
fn xyz_from_rgb(space: ColorSpace) -> Matrix {
    let (primaries, white) = chromaticities(space);
    let columns = transposed(&primaries.map(xyz_of));
    let strengths = apply(&inverse(&columns), xyz_of(white));
    columns.map(|row| [0, 1, 2].map(|i: usize| row[i] * strengths[i]))
}

/// Adapts XYZ from one white to another: each cone response by the quotient of the whites'.
fn bradford(from: Vector, to: Vector) -> Matrix {
    let (from, to) = (apply(&BRADFORD, from), apply(&BRADFORD, to));
    let gains = [0, 1, 2].map(|i: usize| BRADFORD[i].map(|c| c * to[i] / from[i]));
    product(&inverse(&BRADFORD), &gains)
}

/// XYZ under a white of Y = 1 → RGB, such that this white is R = G = B.
fn rgb_from_xyz(space: ColorSpace, white: Vector) -> Matrix {
    let (_, to) = chromaticities(space);
    product(&inverse(&xyz_from_rgb(space)), &bradford(white, xyz_of(to)))
}

/// Linear RGB of one space in another; white stays white. Gray needs no arithmetic.
pub(super) fn converted(rgb: Vector, from: ColorSpace, to: ColorSpace) -> Vector {
    let is_gray = rgb[0] == rgb[1] && rgb[1] == rgb[2];
    if from == to || is_gray {
        return rgb;
    }
    let (_, white) = chromaticities(from);
    let xyz = apply(&xyz_from_rgb(from), rgb);
    apply(&rgb_from_xyz(to, xyz_of(white)), xyz)
}

/// The luminance of linear RGB; that of R = G = B = 1 is 1.
pub(super) fn luminance(rgb: Vector, space: ColorSpace) -> f64 {
    let [_, y, _] = apply(&xyz_from_rgb(space), rgb);
    y
}

/// How an observer sees spectra, in RGB of the working space. White is illuminant D65.
#[derive(Clone, Debug)]
pub(super) struct Colorimetry {
    /// K_m in lm/W.
    efficacy: f64,
    /// x̄, ȳ, z̄
    matching: [Components; 3],
    /// Illuminant D65 of 1 cd.
    pub(super) white: Components,
    rgb_from_xyz: Matrix,
}

impl Colorimetry {
    pub(super) fn new(observer: Observer, space: ColorSpace) -> Self {
        // 683 lm/W at 540 THz, where ȳ of the 10° observer is 0.9991.
        let (efficacy, table) = match observer {
            Observer::Cie1931 => (683.0, tables::cie_1931()),
            Observer::Cie1964 => (683.6, tables::cie_1964()),
        };
        let matching = ["x", "y", "z"].map(|name| Components(table.column(name).to_vec()));
        let d65 = illuminant("D65");
        let white = d65.scaled(1.0 / (efficacy * integral(&d65, &matching[1])));
        let seen = matching
            .each_ref()
            .map(|bar| efficacy * integral(&white, bar));
        Self {
            efficacy,
            matching,
            white,
            rgb_from_xyz: rgb_from_xyz(space, seen),
        }
    }

    /// X = K_m ∫ S(λ) x̄(λ) dλ, and so Y and Z: of a spectral radiance, Y is in cd/m².
    fn xyz(&self, spectrum: &Components) -> Vector {
        let bars = self.matching.each_ref();
        bars.map(|bar| self.efficacy * integral(spectrum, bar))
    }

    /// K_m ∫ S(λ) ȳ(λ) dλ: of a spectral intensity, in cd.
    pub(super) fn luminous(&self, spectrum: &Components) -> f64 {
        let [_, y, _] = self.xyz(spectrum);
        y
    }

    /// The RGB of light.
    pub(super) fn light(&self, spectrum: &Components) -> Vector {
        apply(&self.rgb_from_xyz, self.xyz(spectrum))
    }

    /// How far the RGB of a spectrum may be off that may be off by this at each wavelength, to either side.
    pub(super) fn light_error(&self, error: &Components) -> Vector {
        self.rgb_from_xyz.map(|row| {
            let of_wavelength = |place: usize, error: &f64| {
                let matching = (0..3).map(|i: usize| row[i] * self.matching[i].0[place]);
                (error * matching.sum::<f64>()).abs()
            };
            let places = error.0.iter().enumerate();
            let sum: f64 = places
                .map(|(place, error)| of_wavelength(place, error))
                .sum();
            self.efficacy * sum
        })
    }

    /// The RGB of a reflectance: what becomes of white light of 1 cd.
    pub(super) fn reflectance(&self, reflectance: &Components) -> Vector {
        self.light(&self.white.times(reflectance))
    }

    /// The three functions of wavelength with which a reflectance is integrated for its RGB.
    pub(super) fn weights(&self) -> [Components; 3] {
        self.rgb_from_xyz.map(|row| {
            let [x, y, z] = [0, 1, 2].map(|i: usize| self.matching[i].scaled(row[i]));
            let matching = x.plus(&y).plus(&z).scaled(self.efficacy);
            matching.times(&self.white)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::oracle::spectrum::{blackbody, daylight, flat, on_grid};
    use crate::oracle::vector::subtract;

    /// Sums of 471 terms.
    const ROUNDING: f64 = 1e-13;

    impl Colorimetry {
        /// [`Colorimetry::weights`] under the CIE's D65 by the matrix of a space alone, whose white is another in the
        /// fourth decimal.
        pub(in crate::oracle) fn weights_without_adaptation(
            &self,
            space: ColorSpace,
        ) -> [Components; 3] {
            let d65 = daylight(6500.0 * 1.4388 / 1.4380);
            let rgb_from_xyz = inverse(&xyz_from_rgb(space));
            Self {
                rgb_from_xyz,
                white: d65.scaled(1.0 / self.luminous(&d65)),
                ..self.clone()
            }
            .weights()
        }
    }

    fn everywhere(test: impl Fn(&Colorimetry)) {
        for observer in [Observer::Cie1931, Observer::Cie1964] {
            for space in ColorSpace::ALL {
                test(&Colorimetry::new(observer, space));
            }
        }
    }

    /// Every line of the table: made by other code than ours from the same tables, at the same 1 nm.
    #[test]
    fn lights_have_the_published_chromaticities() {
        /// Nine decimals are printed; D illuminants are made of tables with fewer than others'.
        const PRINTED: f64 = 1e-8;
        let colorimetry = Colorimetry::new(Observer::Cie1931, ColorSpace::Rec709);
        let mut compared = 0;
        for line in include_str!("../../reference/illuminants.csv").lines() {
            let mut cells = line.split(',');
            let (Some(name), Some(Ok(x)), Some(Ok(y))) = (
                cells.next(),
                cells.next().map(str::parse::<f64>),
                cells.next().map(str::parse::<f64>),
            ) else {
                continue;
            };
            let spectrum = match name.split_once(' ') {
                // Ours is that of RGB spaces.
                None if name == "D65" => daylight(6500.0 * 1.4388 / 1.4380),
                None => illuminant(name),
                Some(("daylight", temperature)) => daylight(temperature.parse().unwrap()),
                Some(("blackbody", temperature)) => blackbody(temperature.parse().unwrap()),
                // The printed tables of what has an equation.
                Some(_) => continue,
            };
            let [big_x, big_y, big_z] = colorimetry.xyz(&spectrum);
            let sum = big_x + big_y + big_z;
            let error = (big_x / sum - x).abs().max((big_y / sum - y).abs());
            assert!(error < PRINTED, "{name}: {} {}", big_x / sum, big_y / sum);
            compared += 1;
        }
        assert_eq!(compared, 39);
    }

    #[test]
    fn d65_is_white_and_gray_reflects_gray() {
        everywhere(|colorimetry| {
            for channel in colorimetry.light(&colorimetry.white) {
                assert!((channel - 1.0).abs() < ROUNDING, "{channel}");
            }
            for channel in colorimetry.reflectance(&flat(0.18)) {
                assert!((channel - 0.18).abs() < ROUNDING, "{channel}");
            }
            assert!((colorimetry.luminous(&colorimetry.white) - 1.0).abs() < ROUNDING);
        });
    }

    /// 540 THz is 555.016 nm in air; the table's peak is 1 at 555 nm.
    #[test]
    fn a_watt_at_555_nm() {
        let colorimetry = Colorimetry::new(Observer::Cie1931, ColorSpace::Rec709);
        let line = on_grid(|nm| f64::from(u8::from(nm == 555.0)));
        assert!((colorimetry.luminous(&line) - 683.0).abs() < ROUNDING * 683.0);
    }

    #[test]
    fn integrals_with_the_weights_are_the_color() {
        everywhere(|colorimetry| {
            let ramp = on_grid(|nm| nm / 830.0);
            let weights = colorimetry.weights();
            let expected = colorimetry.reflectance(&ramp);
            for (weights, expected) in weights.iter().zip(expected) {
                assert!((integral(weights, &ramp) - expected).abs() < ROUNDING);
            }
        });
    }

    /// Matrices from colour-science 0.4.7, Bradford, twelve decimals.
    #[test]
    fn conversions_are_published_ones() {
        use ColorSpace::{AcesCg, P3D65, Rec709, Rec2020};
        let unit = |i: usize| [0, 1, 2].map(|j: usize| f64::from(u8::from(i == j)));
        for (from, to, rows) in [
            (
                AcesCg,
                Rec709,
                [
                    [1.705050992658, -0.621792120657, -0.083258872001],
                    [-0.130256417507, 1.140804736575, -0.010548319068],
                    [-0.024003356805, -0.128968976065, 1.152972332870],
                ],
            ),
            (
                Rec709,
                Rec2020,
                [
                    [0.627403895935, 0.329283038378, 0.043313065687],
                    [0.069097289358, 0.919540395075, 0.011362315566],
                    [0.016391438875, 0.088013307877, 0.895595253248],
                ],
            ),
            (
                Rec709,
                P3D65,
                [
                    [0.822461968714, 0.177538031286, 0.0],
                    [0.033194198851, 0.966805801149, 0.0],
                    [0.017082630721, 0.072397440664, 0.910519928615],
                ],
            ),
        ] {
            let columns = transposed(&rows);
            for (i, column) in columns.into_iter().enumerate() {
                let differences = subtract(converted(unit(i), from, to), column);
                assert!(
                    differences
                        .iter()
                        .all(|difference| difference.abs() < 1e-12)
                );
            }
        }
        assert_eq!(converted([0.3; 3], AcesCg, Rec709), [0.3; 3]);
        // Rec.709's green by the middle row of its matrix.
        assert!((luminance(unit(1), Rec709) - 0.715_168_678_8).abs() < 1e-10);
    }
}
