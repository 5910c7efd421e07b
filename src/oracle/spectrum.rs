//! The spectra that a scene can name, as components: one for each nm from 360 to 830.
//!
//! Of the library only the published tables are used, and the points of curves and lines.

use super::components::Components;
use crate::spectrum::{Curve, Lines, tables};

/// The first and the last wavelength in nm.
const GRID: [u16; 2] = [360, 830];

/// c₂ = h c / k in m·K, from the constants of the SI.
const SECOND_RADIATION_CONSTANT: f64 = 6.626_070_15e-34 * 299_792_458.0 / 1.380_649e-23;

/// The wavelengths in nm, one for each component.
pub(super) fn wavelengths() -> impl Iterator<Item = f64> {
    let [first, last] = GRID;
    (first..=last).map(f64::from)
}

/// The function's values at all wavelengths.
pub(super) fn on_grid(f: impl FnMut(f64) -> f64) -> Components {
    Components(wavelengths().map(f).collect())
}

/// The same at every wavelength.
pub(super) fn flat(value: f64) -> Components {
    on_grid(|_| value)
}

/// ∫ a(λ) b(λ) dλ
pub(super) fn integral(a: &Components, b: &Components) -> f64 {
    a.0.iter().zip(&b.0).map(|(a, b)| a * b).sum()
}

/// A spectrum's value at any wavelength of the grid's range: linear between its components.
pub(super) fn at(spectrum: &Components, nm: f64) -> f64 {
    let wavelengths: Vec<f64> = wavelengths().collect();
    interpolated(&wavelengths, &spectrum.0, nm)
}

/// Linear between the points, constant beyond the first and the last.
pub(super) fn interpolated(points: &[f64], values: &[f64], nm: f64) -> f64 {
    let above = points.partition_point(|&point| point < nm);
    if above == 0 || above == points.len() {
        return values[above.min(points.len() - 1)];
    }
    let (a, b) = (points[above - 1], points[above]);
    values[above - 1] + (values[above] - values[above - 1]) * ((nm - a) / (b - a))
}

/// The curve's value at each wavelength or, where its points are less than 1 nm apart (but for a
/// rounding), its mean with the weights of a line's triangle: what is finer than the components
/// keeps its power.
pub(super) fn curve(curve: &Curve) -> Components {
    let (points, values) = (curve.wavelengths(), curve.values());
    on_grid(|nm| {
        let first = points.partition_point(|&point| point <= nm - 1.0);
        let near: Vec<f64> = points[first..]
            .iter()
            .copied()
            .take_while(|&point| point < nm + 1.0)
            .collect();
        let before = points[..first].last();
        let after = points.get(first + near.len());
        let reaching: Vec<f64> = before
            .into_iter()
            .chain(&near)
            .chain(after)
            .copied()
            .collect();
        if reaching
            .windows(2)
            .all(|pair| pair[1] - pair[0] >= 1.0 - 1e-9)
        {
            return interpolated(points, values, nm);
        }
        let mut corners = [near, vec![nm - 1.0, nm, nm + 1.0]].concat();
        corners.sort_by(f64::total_cmp);
        let weighted = |at: f64| interpolated(points, values, at) * (1.0 - (at - nm).abs());
        // Simpson's rule: exact for the products of straight lines between the corners.
        let pieces = corners.windows(2).map(|ends| {
            let (a, b) = (ends[0], ends[1]);
            (b - a) * (weighted(a) + 4.0 * weighted((a + b) / 2.0) + weighted(b)) / 6.0
        });
        pieces.sum()
    })
}

/// Each line is a triangle of its power that reaches to 1 nm beside it.
pub(super) fn lines(lines: &Lines) -> Components {
    on_grid(|nm| {
        let share = |[at, power]: &[f64; 2]| power * (1.0 - (nm - at).abs()).max(0.0);
        lines.lines().iter().map(share).sum()
    })
}

/// The CIE's illuminant of this name, of any size; dark where there is none.
pub(super) fn illuminant(name: &str) -> Components {
    // c₂ was 1.4380e-2 when these got their names (CIE 15:2018).
    let corrected = |nominal: f64| daylight(nominal * 1.4388 / 1.4380);
    match name {
        "A" => illuminant_a(),
        "E" => flat(1.0),
        "D50" => corrected(5000.0),
        "D55" => corrected(5500.0),
        "D65" => white(),
        "D75" => corrected(7500.0),
        tabulated => [tables::fluorescent(), tables::led(), tables::discharge()]
            .into_iter()
            .find(|table| table.names().contains(&tabulated))
            .map_or_else(|| flat(0.0), |table| lamp(table, tabulated)),
    }
}

fn column(table: &tables::Table, name: &str) -> Components {
    on_grid(|nm| interpolated(table.wavelengths(), table.column(name), nm))
}

/// A lamp: between its points the polynomial of degree 3 through the two on each side, in Newton's form; in the first
/// and the last interval straight. Where that is negative, there is no light, and the larger of the two outer points
/// has less by as much.
fn lamp(table: &tables::Table, name: &str) -> Components {
    let (points, values) = (table.wavelengths(), table.column(name));
    let mut light = column(table, name);
    for (interval, four) in values.windows(4).enumerate() {
        let [p, q, r, s] = [four[0], four[1], four[2], four[3]];
        let (first, second, third) = (q - p, r - 2.0 * q + p, s - 3.0 * r + 3.0 * q - p);
        let outer = [points[interval], points[interval + 3]];
        let width = (outer[1] - outer[0]) / 3.0;
        let from = outer[0] + width;
        for component in place(from) + 1..place(from + width) {
            let u = 1.0 + (f64::from(GRID[0]) + component as f64 - from) / width;
            let pairs = u * (u - 1.0) / 2.0;
            let polynomial = p + u * first + pairs * second + pairs * (u - 2.0) / 3.0 * third;
            light.0[component] = polynomial.max(0.0);
            let line = if p >= s { outer[0] } else { outer[1] };
            light.0[place(line)] += polynomial.min(0.0);
        }
    }
    light
}

/// Which component a wavelength in whole nm has.
fn place(nm: f64) -> usize {
    usize::from(nm as u16 - GRID[0])
}

/// A(λ) = 100 (560/λ)⁵ (exp(1.435e7/(2848·560)) − 1) / (exp(1.435e7/(2848 λ)) − 1)
/// (ISO/CIE 11664-2)
fn illuminant_a() -> Components {
    let exponential = |nm: f64| (1.435e7 / (2848.0 * nm)).exp() - 1.0;
    on_grid(|nm| 100.0 * (560.0 / nm).powi(5) * exponential(560.0) / exponential(nm))
}

/// Daylight of a correlated color temperature in K, of any size:
/// S(λ) = S₀(λ) + M₁ S₁(λ) + M₂ S₂(λ) (CIE 15:2018, 4.1.2).
pub(super) fn daylight(temperature: f64) -> Components {
    // In powers of 1000 K / T.
    let u = 1e3 / temperature;
    let x = if temperature <= 7000.0 {
        0.244_063 + 0.099_11 * u + 2.9678 * u.powi(2) - 4.6070 * u.powi(3)
    } else {
        0.237_040 + 0.247_48 * u + 1.9018 * u.powi(2) - 2.0064 * u.powi(3)
    };
    let y = -3.0 * x.powi(2) + 2.870 * x - 0.275;
    let divisor = 0.0241 + 0.2562 * x - 0.7341 * y;
    let three_decimals = |m: f64| (m * 1000.0).round() / 1000.0;
    let m1 = three_decimals((-1.3515 - 1.7703 * x + 5.9114 * y) / divisor);
    let m2 = three_decimals((0.0300 - 31.4424 * x + 30.0717 * y) / divisor);
    let [s0, s1, s2] = daylight_components();
    s0.plus(&s1.scaled(m1)).plus(&s2.scaled(m2))
}

/// S₀, S₁ and S₂ of daylight.
fn daylight_components() -> [Components; 3] {
    let table = tables::daylight();
    ["S0", "S1", "S2"].map(|name| column(table, name))
}

/// Illuminant D65 as the standards of RGB spaces have it: the daylight S₀ + M₁ S₁ + M₂ S₂ whose chromaticity is
/// 0.3127, 0.3290 for the 2° observer, by Cramer's rule.
fn white() -> Components {
    let table = tables::cie_1931();
    let bars = ["x", "y", "z"].map(|name| Components(table.column(name).to_vec()));
    let parts = daylight_components();
    let [at_0, of_m1, of_m2] = parts.each_ref().map(|part| {
        let [x, y, z] = bars.each_ref().map(|bar| part.times(bar).sum());
        let sum = x + y + z;
        [x - 0.3127 * sum, y - 0.3290 * sum]
    });
    let cross = |a: [f64; 2], b: [f64; 2]| a[0] * b[1] - a[1] * b[0];
    let m1 = cross(of_m2, at_0) / cross(of_m1, of_m2);
    let m2 = cross(at_0, of_m1) / cross(of_m1, of_m2);
    let [s0, s1, s2] = parts;
    s0.plus(&s1.scaled(m1)).plus(&s2.scaled(m2))
}

/// Planck's law, of any size: λ⁻⁵ / (exp(c₂/(λT)) − 1), with λ in μm before the fraction.
pub(super) fn blackbody(temperature: f64) -> Components {
    on_grid(|nm| {
        let exponent = SECOND_RADIATION_CONSTANT / (nm * 1e-9 * temperature);
        (nm * 1e-3).powi(-5) / exponent.exp_m1()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A few operations.
    const ROUNDING: f64 = 1e-14;

    fn at(spectrum: &Components, nm: u16) -> f64 {
        spectrum.0[usize::from(nm - GRID[0])]
    }

    #[test]
    fn curves_are_straight_between_their_points() {
        let written = Curve::new(vec![400.5, 410.5, 700.0], vec![1.0, 3.0, 0.5]).unwrap();
        let spectrum = curve(&written);
        assert_eq!(spectrum.0.len(), 471);
        assert_eq!(
            [360, 400, 700, 830].map(|nm| at(&spectrum, nm)),
            [1.0, 1.0, 0.5, 0.5]
        );
        assert!((at(&spectrum, 405) - 1.9).abs() < ROUNDING);
    }

    /// A triangle of 1 at its peak, 0.4 nm wide, has 0.2, a fifth of which is nearer to 435 nm.
    #[test]
    fn fine_curves_keep_their_power() {
        let written = Curve::new(
            vec![400.0, 435.6, 435.8, 436.0, 500.0],
            vec![0.0, 0.0, 1.0, 0.0, 0.0],
        );
        let spectrum = curve(&written.unwrap());
        assert!((spectrum.sum() - 0.2).abs() < ROUNDING * 100.0);
        for (nm, power) in [(434, 0.0), (435, 0.04), (436, 0.16), (437, 0.0)] {
            assert!((at(&spectrum, nm) - power).abs() < ROUNDING * 100.0, "{nm}");
        }
    }

    #[test]
    fn lines_keep_their_power_and_their_place() {
        let written = Lines::new(vec![
            [589.0, 0.5],
            [589.6, 0.25],
            [830.0, 1.0],
            [360.0, 2.0],
        ]);
        let spectrum = lines(&written.unwrap());
        assert!((spectrum.sum() - 3.75).abs() < ROUNDING);
        for (nm, power) in [(360, 2.0), (588, 0.0), (589, 0.6), (590, 0.15), (830, 1.0)] {
            assert!((at(&spectrum, nm) - power).abs() < ROUNDING * 100.0, "{nm}");
        }
    }

    /// CIE standard illuminants (ISO/CIE 11664-2), some of the printed values.
    #[test]
    fn standard_illuminants() {
        let (a, d65) = (illuminant("A"), illuminant("D65"));
        // D65 is printed with its M₁ and M₂ rounded, which is up to 5e-4 of it.
        for (nm, in_a, in_d65) in [
            (400, 14.7080, 82.7549),
            (450, 33.0859, 117.008),
            (560, 100.0, 100.0),
            (700, 198.261, 71.6091),
            (780, 241.675, 63.3828),
        ] {
            assert!((at(&a, nm) - in_a).abs() < 1e-3, "{nm}: {}", at(&a, nm));
            assert!((at(&d65, nm) / in_d65 - 1.0).abs() < 5e-4, "{nm}");
        }
        assert_eq!(illuminant("E"), flat(1.0));
        // No panic where a scene is not legal.
        assert_eq!(illuminant("D66"), flat(0.0));
    }

    /// The CIE's four decimals (CIE 15:2018), and the foot of a line of mercury in F12.
    #[test]
    fn lamps() {
        let matching =
            ["x", "y", "z"].map(|name| Components(tables::cie_1931().column(name).to_vec()));
        for (name, xy) in [
            ("F11", [0.3805, 0.3769]),
            ("F12", [0.4370, 0.4042]),
            ("LED-V1", [0.4548, 0.4044]),
            ("HP1", [0.5330, 0.4150]),
        ] {
            let light = illuminant(name);
            assert!(light.0.iter().all(|&value| value >= 0.0), "{name}");
            let [x, y, z] = [0, 1, 2].map(|i: usize| integral(&light, &matching[i]));
            for (actual, published) in [x, y].map(|c| c / (x + y + z)).into_iter().zip(xy) {
                assert!((actual - published).abs() < 6e-5, "{name}: {actual}");
            }
        }
        let light = illuminant("F12");
        for (nm, value) in [(360, 0.96), (380, 0.96), (405, 12.48), (440, 7.9)] {
            assert!((at(&light, nm) - value).abs() < ROUNDING, "{nm}");
        }
        assert_eq!(at(&light, 428), 0.0);
        // −0.056 · 1.08 + 0.448 · 1.37 + 0.672 · 1.78 − 0.064 · 29.05 at 428 nm: the line has less by that.
        assert!((at(&light, 435) - 28.940_24).abs() < ROUNDING * 100.0);
    }

    /// λ T = 2.897771955e-3 m·K at the peak (CODATA 2018).
    #[test]
    fn wien_s_displacement() {
        for nm in [400, 555, 800_u16] {
            let spectrum = blackbody(2.897_771_955e-3 / (f64::from(nm) * 1e-9));
            let peak = at(&spectrum, nm);
            assert!(spectrum.0.iter().all(|&value| value <= peak), "{nm}");
        }
    }
}
