//! What the header says of an image as a whole, from what it says of its tiles: sums and maxima.

use std::collections::BTreeMap;

use crate::exr::head::RESIDUAL;
use crate::exr::read::Attribute;

/// How an attribute of the whole is made of those of the tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rule {
    /// A count, as text: their sum.
    Sum,
    /// A number, as text: the largest.
    Largest,
    /// A float: the largest.
    LargestFloat,
}

/// All that differ from tile to tile. Those of mirrors, of `--max-error` and of layers that add up to the image.
const RULES: [(&str, Rule); 8] = [
    ("candela:cut_rays", Rule::Sum),
    ("candela:depth_rest", Rule::Largest),
    ("candela:bound_pixels", Rule::Sum),
    ("candela:estimated_pixels", Rule::Sum),
    ("candela:unmet_pixels", Rule::Sum),
    ("candela:worst_bound", Rule::Largest),
    ("candela:worst_estimate", Rule::Largest),
    (RESIDUAL, Rule::LargestFloat),
];

/// Whether an attribute is one of these.
pub(super) fn is_total(name: &[u8]) -> bool {
    RULES.iter().any(|(total, _)| total.as_bytes() == name)
}

/// What comes of the tiles so far.
#[derive(Debug, Default)]
pub(super) struct Totals(BTreeMap<&'static str, Total>);

#[derive(Clone, Copy, Debug, PartialEq)]
enum Total {
    Count(u64),
    Number(f64),
    Float(f32),
}

impl Totals {
    /// Adds a tile.
    ///
    /// # Errors
    /// The name of an attribute that is no number of its kind.
    pub(super) fn add(&mut self, attributes: &[Attribute]) -> Result<(), &'static str> {
        let Self(totals) = self;
        for (name, rule) in RULES {
            let found = attributes.iter().find(|it| it.name == name.as_bytes());
            let Some(found) = found else {
                continue;
            };
            let here = read(found, rule).ok_or(name)?;
            let total = match totals.get(name) {
                None => here,
                Some(&before) => before.and(here).ok_or(name)?,
            };
            totals.insert(name, total);
        }
        Ok(())
    }

    /// The value of the attribute of the whole, if it is one of these.
    pub(super) fn value(&self, name: &[u8]) -> Option<Vec<u8>> {
        let Self(totals) = self;
        let mut all = totals.iter();
        let (_, total) = all.find(|(total, _)| total.as_bytes() == name)?;
        // As they were written: the shortest digits that are this number.
        Some(match total {
            Total::Count(count) => count.to_string().into_bytes(),
            Total::Number(number) => number.to_string().into_bytes(),
            Total::Float(number) => number.to_le_bytes().to_vec(),
        })
    }
}

impl Total {
    /// Of two, if they are of one kind and fit it.
    fn and(self, other: Self) -> Option<Self> {
        match (self, other) {
            (Self::Count(a), Self::Count(b)) => a.checked_add(b).map(Self::Count),
            (Self::Number(a), Self::Number(b)) => Some(Self::Number(a.max(b))),
            (Self::Float(a), Self::Float(b)) => Some(Self::Float(a.max(b))),
            (Self::Count(_) | Self::Number(_) | Self::Float(_), _) => None,
        }
    }
}

fn read(attribute: &Attribute, rule: Rule) -> Option<Total> {
    let Attribute { kind, value, .. } = attribute;
    let text = || {
        let text = str::from_utf8(value).ok()?;
        (kind == b"string").then_some(text)
    };
    match rule {
        Rule::Sum => text()?.parse().ok().map(Total::Count),
        Rule::Largest => {
            let number = text()?.parse().ok().filter(|number: &f64| !number.is_nan());
            number.map(Total::Number)
        }
        Rule::LargestFloat => {
            let bytes = value.as_slice().try_into().ok()?;
            let number = Some(f32::from_le_bytes(bytes)).filter(|number| !number.is_nan());
            number.filter(|_| kind == b"float").map(Total::Float)
        }
    }
}
