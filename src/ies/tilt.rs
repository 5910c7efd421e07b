//! How the light of a lamp depends on its tilt: `TILT=INCLUDE` and files of tilt factors.
//!
//! LM-63-02, section 4: a lamp-to-luminaire geometry, the number of pairs, angles, and factors on the
//! intensities. The angle is how far the luminaire is tilted away from the position in which it was
//! measured. candela renders a luminaire as it was measured, whatever way it looks in the scene: the factor at 0° is
//! applied (1 in every file that makes sense), and the rest is kept for those who know the lamp.

use super::error::{Fault, Problem};
use super::limits::MOST_ANGLES;
use super::numbers::{Number, Numbers};
use super::remarks::IesRemarks;

/// How the lamp lies in the luminaire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LampGeometry {
    /// 1: base up or down where the luminaire looks straight down.
    Vertical,
    /// 2: horizontal where it looks straight down, and horizontal still where the luminaire is tilted.
    HorizontalAlways,
    /// 3: horizontal where it looks straight down, and tilted with the luminaire.
    HorizontalTilted,
}

/// Factors on all intensities over the tilt of the luminaire.
#[derive(Clone, Debug, PartialEq)]
pub struct TiltFactors {
    /// How the lamp lies in the luminaire.
    pub geometry: LampGeometry,
    /// Tilts in degrees, ascending. Range: −180 to 180.
    pub angles: Vec<f64>,
    /// A factor for each. Range: not negative.
    pub factors: Vec<f64>,
}

/// What a file says of tilt.
#[derive(Clone, Debug, PartialEq)]
pub enum Tilt {
    /// It does not matter.
    None,
    /// Factors, in the file or in the file that it names.
    Factors(TiltFactors),
    /// The name of a file of factors that was not read.
    File(String),
}

impl TiltFactors {
    /// The factor at a tilt in degrees, linear between its neighbors; beyond the first and the last, theirs.
    pub fn at(&self, angle: f64) -> f64 {
        let after = self.angles.partition_point(|&other| other <= angle);
        let last = self.factors.len().saturating_sub(1);
        let (i, j) = (after.saturating_sub(1), after.min(last));
        match (self.angles.get(i..=j), self.factors.get(i..=j)) {
            (Some(&[a, b]), Some(&[f, g])) => f + (g - f) * ((angle - a) / (b - a)),
            (_, Some(&[f, ..])) => f,
            _ => 1.0,
        }
    }

    pub(super) fn read(
        numbers: &mut Numbers<'_>,
        remarks: &mut IesRemarks,
    ) -> Result<Self, Problem> {
        const GEOMETRY: &str = "the lamp-to-luminaire geometry: 1 (vertical), 2 or 3 (horizontal)";
        let written = numbers.next(GEOMETRY)?;
        let geometry = match written.value {
            1.0 => LampGeometry::Vertical,
            2.0 => LampGeometry::HorizontalAlways,
            3.0 => LampGeometry::HorizontalTilted,
            value => {
                let fault = Fault::OutOfRange {
                    what: "the lamp-to-luminaire geometry",
                    value,
                    expected: "1 (vertical), 2 or 3 (horizontal)",
                };
                return Err(Problem::new(written.offset, fault));
            }
        };
        let written = numbers.next("the number of tilt angles")?;
        let count = count(written, "tilt angles", "a whole number from 1 on")?;
        let found = numbers.count(count.saturating_mul(2));
        if found < count * 2 {
            let expected = "as many tilt angles and then as many factors as it counts";
            let fault = Fault::FileEnds { expected };
            return Err(Problem::new(written.offset, fault));
        }
        let mut pairs = Vec::new();
        pairs.try_reserve_exact(count)?;
        for _ in 0..count {
            let angle = numbers.next("a tilt angle in degrees")?;
            let value = angle.value;
            if value.abs() > 180.0 {
                let expected = "-180 to 180 degrees, from the position in which it was measured";
                let what = "a tilt angle";
                let fault = Fault::OutOfRange {
                    what,
                    value,
                    expected,
                };
                return Err(Problem::new(angle.offset, fault));
            }
            pairs.push((angle, 1.0));
        }
        for pair in &mut pairs {
            let factor = numbers.next("a tilt factor")?;
            let value = factor.value;
            if !(0.0..=1e6).contains(&value) {
                let (what, expected) = ("a tilt factor", "0 to a million, and 1 at 0 degrees");
                let fault = Fault::OutOfRange {
                    what,
                    value,
                    expected,
                };
                return Err(Problem::new(factor.offset, fault));
            }
            pair.1 = value;
        }
        let is_sorted = pairs.is_sorted_by(|(a, _), (b, _)| a.value <= b.value);
        if !is_sorted {
            IesRemarks::add(&mut remarks.unsorted_lists);
            pairs.sort_by(|(a, _), (b, _)| a.value.total_cmp(&b.value));
        }
        for [(a, f), (b, g)] in pairs.array_windows() {
            if a.value == b.value && f != g {
                let (what, value) = ("tilt", b.value);
                return Err(Problem::new(b.offset, Fault::Twice { what, value }));
            }
        }
        let before = pairs.len();
        pairs.dedup_by(|(a, _), (b, _)| a.value == b.value);
        let repeated = u32::try_from(before - pairs.len()).unwrap_or(u32::MAX);
        remarks.repeated_angles = remarks.repeated_angles.saturating_add(repeated);
        let offset = pairs.first().map_or(0, |(first, _)| first.offset);
        let tilt = Self {
            geometry,
            angles: pairs.iter().map(|(angle, _)| angle.value).collect(),
            factors: pairs.iter().map(|&(_, factor)| factor).collect(),
        };
        if tilt.at(0.0) <= 0.0 {
            let fault = Fault::OutOfRange {
                what: "the tilt factor at 0 degrees",
                value: tilt.at(0.0),
                expected: "one above 0, usually 1",
            };
            return Err(Problem::new(offset, fault));
        }
        Ok(tilt)
    }
}

/// A number that counts `what`.
pub(super) fn count(
    written: Number,
    what: &'static str,
    expected: &'static str,
) -> Result<usize, Problem> {
    let Number { value, offset } = written;
    if value.fract() != 0.0 || value < 1.0 {
        let what = match what {
            "vertical angles" => "the number of vertical angles",
            "horizontal angles" => "the number of horizontal angles",
            _ => "the number of tilt angles",
        };
        let fault = Fault::OutOfRange {
            what,
            value,
            expected,
        };
        return Err(Problem::new(offset, fault));
    }
    if value > MOST_ANGLES as f64 {
        let fault = Fault::TooManyAngles { what, count: value };
        return Err(Problem::new(offset, fault));
    }
    Ok(value as usize)
}
