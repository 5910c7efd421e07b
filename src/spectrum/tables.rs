//! The published tables, as they are in `data/`, without any interpolation.

use std::sync::LazyLock;

/// A table: wavelengths and, for each, a number in every column.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    names: Vec<&'static str>,
    wavelengths: Vec<f64>,
    columns: Vec<Vec<f64>>,
}

impl Table {
    /// Parses one of the files of `data/`: comments, the last of which names the columns, then
    /// one line of numbers for each wavelength.
    fn parse(text: &'static str) -> Self {
        let comments = text.lines().map_while(|line| line.strip_prefix('#'));
        let header = comments.last().expect("a table has a header");
        let names: Vec<&str> = header.trim().split(',').skip(1).collect();
        let mut table = Self {
            columns: vec![Vec::new(); names.len()],
            names,
            wavelengths: Vec::new(),
        };
        for line in text.lines().filter(|line| !line.starts_with('#')) {
            let mut numbers = line
                .split(',')
                .map(|number| number.parse::<f64>().expect("a table holds numbers"));
            table.wavelengths.extend(numbers.next());
            for column in &mut table.columns {
                column.push(numbers.next().expect("a table has no gaps"));
            }
        }
        table
    }

    /// The names of the columns.
    pub fn names(&self) -> &[&'static str] {
        &self.names
    }

    /// The wavelengths in nm, ascending, equally spaced.
    pub fn wavelengths(&self) -> &[f64] {
        &self.wavelengths
    }

    /// The column of this name, one number for each wavelength.
    ///
    /// # Panics
    /// If there is none.
    pub fn column(&self, name: &str) -> &[f64] {
        let place = self.names.iter().position(|column| *column == name);
        &self.columns[place.unwrap_or_else(|| panic!("no column `{name}`"))]
    }
}

macro_rules! table {
    ($(#[$doc:meta])* $name:ident, $file:literal) => {
        $(#[$doc])*
        pub fn $name() -> &'static Table {
            static TABLE: LazyLock<Table> =
                LazyLock::new(|| Table::parse(include_str!(concat!("data/", $file))));
            &TABLE
        }
    };
}

table! {
    /// x̄, ȳ, z̄ (columns `x`, `y`, `z`) of the CIE 1931 2° observer, 360–830 nm at 1 nm.
    cie_1931, "cie_1931_2_degree.csv"
}
table! {
    /// x̄, ȳ, z̄ (columns `x`, `y`, `z`) of the CIE 1964 10° observer, 360–830 nm at 1 nm.
    cie_1964, "cie_1964_10_degree.csv"
}
table! {
    /// `S0`, `S1`, `S2` of the D series, 300–830 nm at 5 nm.
    daylight, "daylight.csv"
}
table! {
    /// `F1` to `F12`, 380–780 nm at 5 nm.
    fluorescent, "fluorescent.csv"
}
table! {
    /// `LED-B1` to `LED-V2`, 380–780 nm at 5 nm.
    led, "led.csv"
}
table! {
    /// `HP1` to `HP5`, 380–780 nm at 5 nm.
    discharge, "discharge.csv"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn observers_have_the_published_sums() {
        // Five decimals, as published with the tables.
        for (table, sums) in [
            (cie_1931(), [106.865_47, 106.856_92, 106.892_25]),
            (cie_1964(), [116.648_52, 116.661_88, 116.673_98]),
        ] {
            assert_eq!(table.wavelengths().len(), 471);
            assert_eq!(table.wavelengths()[0], 360.0);
            for (name, sum) in ["x", "y", "z"].into_iter().zip(sums) {
                let actual: f64 = table.column(name).iter().sum();
                assert!((actual - sum).abs() < 6e-6, "{name}: {actual}");
            }
        }
    }

    #[test]
    fn tables_are_equally_spaced_and_complete() {
        for (table, step, columns) in [
            (cie_1931(), 1.0, 3),
            (cie_1964(), 1.0, 3),
            (daylight(), 5.0, 3),
            (fluorescent(), 5.0, 12),
            (led(), 5.0, 9),
            (discharge(), 5.0, 5),
        ] {
            assert_eq!(table.names().len(), columns);
            let pairs = table.wavelengths().windows(2);
            assert!(pairs.into_iter().all(|pair| pair[1] - pair[0] == step));
            for name in table.names() {
                assert_eq!(table.column(name).len(), table.wavelengths().len());
            }
        }
    }
}
