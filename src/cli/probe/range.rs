//! The wavelengths of `--spectrum`.

use std::str::FromStr;

use candela::spectrum::{FIRST, LAST};

/// Wavelengths in whole nm, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Range {
    first: u32,
    last: u32,
    step: u32,
}

impl Range {
    /// Where nothing is said.
    pub(super) const DEFAULT: &'static str = "380:780:10";

    /// Each in nm, ascending.
    pub(super) fn wavelengths(self) -> impl Iterator<Item = u32> {
        (self.first..=self.last).step_by(self.step as usize)
    }
}

impl FromStr for Range {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Vec<Option<u32>> = text.split(':').map(|part| part.parse().ok()).collect();
        let [Some(first), Some(last), Some(step)] = numbers[..] else {
            return Err(format!(
                "expected start, end and step in whole nm, such as {}",
                Self::DEFAULT
            ));
        };
        if first < FIRST || last > LAST || last < first {
            return Err(format!(
                "the wavelengths go from {first} to {last} nm, expected two from {FIRST} to {LAST}, \
                 the smaller first"
            ));
        }
        if step == 0 {
            return Err("the step is 0, expected 1 nm or more".to_owned());
        }
        Ok(Self { first, last, step })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_read_and_checked() {
        let wavelengths =
            |text: &str| -> Vec<u32> { text.parse::<Range>().unwrap().wavelengths().collect() };
        assert_eq!(wavelengths("580:590:5"), [580, 585, 590]);
        assert_eq!(wavelengths("580:589:5"), [580, 585]);
        assert_eq!(wavelengths("830:830:1"), [830]);
        assert_eq!(wavelengths(Range::DEFAULT).len(), 41);
        for (text, part) in [
            ("", "380:780:10"),
            ("380", "380:780:10"),
            ("380:780", "380:780:10"),
            ("380:780:10:1", "380:780:10"),
            ("380:780:-10", "380:780:10"),
            ("380.5:780:10", "380:780:10"),
            ("4294967296:780:10", "380:780:10"),
            ("780:380:10", "the smaller first"),
            ("359:780:10", "360 to 830"),
            ("380:831:10", "360 to 830"),
            ("380:780:0", "step is 0"),
        ] {
            let error = text.parse::<Range>().unwrap_err();
            assert!(error.contains(part), "{text}: {error}");
        }
    }
}
