//! The numbers of a file: tilt, lamps, factors, angles, intensities.
//!
//! LM-63-02, section 4: lamps, lumens per lamp, multiplier, number of vertical and of horizontal angles, type
//! of photometry, type of units, width, length, height; ballast factor, ballast-lamp factor (kept for
//! future use since 1995, and 1), input watts; then the angles, and the intensities of one plane after the
//! other. In LM-63-19 the second factor became the *file generation type*, which is no factor.

use super::angles::{List, horizontal, vertical};
use super::coordinates::Coordinates;
use super::error::{Fault, Problem};
use super::header::Edition;
use super::limits::{LEAST_CANDELA, MOST_CANDELA, NOISE_PER_MILLE};
use super::numbers::{Commas, Number, Numbers};
use super::photometry::{Photometry, Symmetry};
use super::remarks::IesRemarks;
use super::tilt::{TiltFactors, count};

/// The size of the luminous opening, in meters. Negative numbers tell round shapes, as LM-63-02 lists them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// Across the plane of axis and up.
    pub width: f64,
    /// Along up.
    pub length: f64,
    /// Along the axis.
    pub height: f64,
}

/// The lamps of a luminaire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamps {
    /// How many.
    pub count: f64,
    /// Rated luminous flux of each, in lm; `None` for absolute photometry.
    pub lumens: Option<f64>,
}

/// The factors on the intensities of a file. All are in the intensities of [`Photometry`] already.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factors {
    /// The multiplier.
    pub multiplier: f64,
    /// The ballast factor.
    pub ballast: f64,
    /// The ballast-lamp photometric factor; 1 in LM-63-2019, which has none.
    pub ballast_lamp: f64,
    /// The tilt factor at 0°; 1 where there is none.
    pub tilt: f64,
}

/// All that stands behind `TILT=`.
#[derive(Clone, Debug)]
pub(super) struct Body {
    pub(super) tilt: Option<TiltFactors>,
    pub(super) lamps: Lamps,
    pub(super) factors: Factors,
    pub(super) generation: Option<f64>,
    pub(super) opening: Option<Opening>,
    pub(super) watts: f64,
    pub(super) photometry: Photometry,
    pub(super) remarks: IesRemarks,
}

/// What is known before the numbers are read.
#[derive(Clone, Copy, Debug)]
pub(super) struct Given<'a> {
    pub(super) edition: Edition,
    /// Whether tilt factors stand before the numbers.
    pub(super) has_tilt: bool,
    /// Those of another file.
    pub(super) tilt: Option<&'a TiltFactors>,
}

const BALLAST: &str = "the ballast factor";

/// A number above 0.
fn factor(
    numbers: &mut Numbers<'_>,
    what: &'static str,
    expected: &'static str,
) -> Result<f64, Problem> {
    let Number { value, offset } = numbers.next(expected)?;
    if !(value > 0.0 && value <= 1e12) {
        // Of the two lines before the angles the second is often left out, and then the first angle is read as it.
        let expected = if what == BALLAST && value == 0.0 {
            "a factor above 0, usually 1; if this is the first angle, put a line `1 1 0` before it: ballast factor, \
             ballast-lamp factor and input watts"
        } else {
            "a factor above 0 and up to 1e12, usually 1"
        };
        let fault = Fault::OutOfRange {
            what,
            value,
            expected,
        };
        return Err(Problem::new(offset, fault));
    }
    Ok(value)
}

fn list(
    numbers: &mut Numbers<'_>,
    count: usize,
    expected: &'static str,
) -> Result<Vec<Number>, Problem> {
    let mut list = Vec::new();
    list.try_reserve_exact(count)?;
    for _ in 0..count {
        list.push(numbers.next(expected)?);
    }
    Ok(list)
}

/// Reads the numbers from `start` on. Commas delimit where that is how the counts are right, and otherwise
/// are decimal points where only that is right.
pub(super) fn read(
    bytes: &[u8],
    start: usize,
    given: Given<'_>,
    remarks: &IesRemarks,
) -> Result<Body, Problem> {
    let with = |commas| Body::read(Numbers::new(bytes, start, commas), given, remarks.clone());
    let delimited = with(Commas::Delimit);
    let Some(comma) = super::numbers::first_tight_comma(bytes, start) else {
        return delimited;
    };
    let is_exact = |body: &Body| body.remarks.extra_numbers == 0;
    if delimited.as_ref().is_ok_and(is_exact) {
        return delimited;
    }
    match (delimited, with(Commas::Decimal)) {
        (Ok(_), Ok(decimal)) if is_exact(&decimal) => Ok(decimal),
        (Ok(_), Ok(_)) => Err(Problem::new(comma, Fault::Commas)),
        (Ok(delimited), Err(_)) => Ok(delimited),
        (Err(_), Ok(decimal)) => Ok(decimal),
        (Err(one), Err(other)) => Err(if other.offset > one.offset {
            other
        } else {
            one
        }),
    }
}

impl Body {
    fn read(
        mut numbers: Numbers<'_>,
        given: Given<'_>,
        mut remarks: IesRemarks,
    ) -> Result<Self, Problem> {
        let numbers = &mut numbers;
        let included = if given.has_tilt {
            Some(TiltFactors::read(numbers, &mut remarks)?)
        } else {
            None
        };
        let tilt = included.as_ref().or(given.tilt);
        let tilt = tilt.map_or(1.0, |tilt| tilt.at(0.0));

        let lamps = lamps(numbers, &mut remarks)?;
        let multiplier = factor(numbers, "the multiplier", "a multiplier, usually 1")?;
        const COUNT: &str = "a whole number from 1 on";
        let written = numbers.next("the number of vertical angles")?;
        let counts_at = written.offset;
        let height = count(written, "vertical angles", COUNT)?;
        let written = numbers.next("the number of horizontal angles")?;
        let width = count(written, "horizontal angles", COUNT)?;
        let coordinates = coordinates(numbers)?;
        let opening = opening(numbers, &mut remarks)?;
        let ballast = factor(numbers, BALLAST, "a ballast factor, usually 1")?;
        let (ballast_lamp, generation) = second_factor(numbers, given.edition, &mut remarks)?;
        let watts = numbers.next("the input watts")?.value;
        let factors = Factors {
            multiplier,
            ballast,
            ballast_lamp,
            tilt,
        };

        // No more than 2³² + 2¹⁷, and no memory before they are there.
        let needed = height.saturating_mul(width).saturating_add(height + width);
        let found = numbers.count(needed);
        if found < needed {
            let fault = Fault::TooFew {
                vertical: height,
                horizontal: width,
                needed,
                found,
            };
            return Err(Problem::new(counts_at, fault));
        }
        let written_v = list(numbers, height, "a vertical angle in degrees")?;
        let written_h = list(numbers, width, "a horizontal angle in degrees")?;
        let first = numbers.clone().word();
        let values_at = first.map_or(numbers.position(), |word| word.offset);
        let values = values(numbers, height * width, factors, &mut remarks)?;

        let columns_same = |i: usize, j: usize| {
            let mut planes = values.chunks_exact(height);
            planes.all(|plane| plane.get(i) == plane.get(j))
        };
        let planes_same = |i: usize, j: usize| {
            let plane = |i: usize| values.get(i * height..(i + 1) * height);
            plane(i) == plane(j)
        };
        let list_v = vertical(&written_v, coordinates, &columns_same, &mut remarks)?;
        let (list_h, symmetry) = horizontal(&written_h, coordinates, &planes_same, &mut remarks)?;
        let mut candela = table(values, height, width, &list_v, &list_h)?;
        if coordinates == Coordinates::C && symmetry == Symmetry::None {
            close_seam(&mut candela, list_v.angles.len(), &mut remarks);
        }
        if !candela.iter().any(|&value| value > LEAST_CANDELA) {
            return Err(Problem::new(values_at, Fault::Dark));
        }
        (remarks.extra_numbers, remarks.trailing_bytes) = numbers.rest();
        remarks.decimal_commas = numbers.decimal_commas;
        remarks.fortran_exponents = numbers.fortran_exponents;
        Ok(Self {
            tilt: included,
            lamps,
            factors,
            generation,
            opening,
            watts,
            photometry: Photometry::new(
                coordinates,
                symmetry,
                list_v.angles,
                list_h.angles,
                candela,
            ),
            remarks,
        })
    }
}

fn lamps(numbers: &mut Numbers<'_>, remarks: &mut IesRemarks) -> Result<Lamps, Problem> {
    let Number { value, offset } = numbers.next("the number of lamps")?;
    if !(0.0..=1e9).contains(&value) {
        let (what, expected) = ("the number of lamps", "0 to 1e9, usually 1");
        let fault = Fault::OutOfRange {
            what,
            value,
            expected,
        };
        return Err(Problem::new(offset, fault));
    }
    let lumens = numbers.next("the lumens per lamp, or -1")?.value;
    remarks.odd_lumens = lumens < 0.0 && lumens != -1.0;
    Ok(Lamps {
        count: value,
        lumens: (lumens >= 0.0).then_some(lumens),
    })
}

fn coordinates(numbers: &mut Numbers<'_>) -> Result<Coordinates, Problem> {
    let Number { value, offset } = numbers.next("the type of photometry: 1, 2 or 3")?;
    match value {
        1.0 => Ok(Coordinates::C),
        2.0 => Ok(Coordinates::B),
        3.0 => Ok(Coordinates::A),
        value => {
            let what = "the type of photometry";
            let expected = "1 (type C, as most files have), 2 (type B) or 3 (type A)";
            let fault = Fault::OutOfRange {
                what,
                value,
                expected,
            };
            Err(Problem::new(offset, fault))
        }
    }
}

fn opening(
    numbers: &mut Numbers<'_>,
    remarks: &mut IesRemarks,
) -> Result<Option<Opening>, Problem> {
    const FOOT: f64 = 0.3048;
    let unit = numbers.next("the type of units: 1 (feet) or 2 (meters)")?;
    let width = numbers.next("the width of the opening")?.value;
    let length = numbers.next("the length of the opening")?.value;
    let height = numbers.next("the height of the opening")?.value;
    let unit = match unit.value {
        1.0 => FOOT,
        2.0 => 1.0,
        _ => {
            remarks.unknown_unit = true;
            return Ok(None);
        }
    };
    Ok(Some(Opening {
        width: width * unit,
        length: length * unit,
        height: height * unit,
    }))
}

/// The ballast-lamp factor, and the file generation type.
fn second_factor(
    numbers: &mut Numbers<'_>,
    edition: Edition,
    remarks: &mut IesRemarks,
) -> Result<(f64, Option<f64>), Problem> {
    if edition >= Edition::Lm63_2019 {
        let generation = numbers.next("the file generation type, such as 1.00001")?;
        return Ok((1.0, Some(generation.value)));
    }
    let mut ahead = numbers.clone();
    if ahead.next("the ballast-lamp factor, usually 1")?.value == 0.0 {
        remarks.no_ballast_lamp_factor = true;
        *numbers = ahead;
        return Ok((1.0, None));
    }
    let what = "the ballast-lamp factor";
    Ok((
        factor(numbers, what, "the ballast-lamp factor, usually 1")?,
        None,
    ))
}

/// The intensities with all factors.
fn values(
    numbers: &mut Numbers<'_>,
    count: usize,
    factors: Factors,
    remarks: &mut IesRemarks,
) -> Result<Vec<f64>, Problem> {
    let Factors {
        multiplier,
        ballast,
        ballast_lamp,
        tilt,
    } = factors;
    let mut values = Vec::new();
    values.try_reserve_exact(count)?;
    let (mut largest, mut least) = (0.0_f64, (0.0_f64, 0));
    for _ in 0..count {
        let Number { value, offset } = numbers.next("an intensity in cd")?;
        let value = value * multiplier * ballast * ballast_lamp * tilt;
        if value.abs() > MOST_CANDELA {
            return Err(Problem::new(offset, Fault::TooBright { value }));
        }
        if value < least.0 {
            least = (value, offset);
        }
        if value < 0.0 {
            IesRemarks::add(&mut remarks.negative_values);
        }
        largest = largest.max(value);
        // No −0.
        values.push(value + 0.0);
    }
    let (value, offset) = least;
    if -value > largest * f64::from(NOISE_PER_MILLE) / 1000.0 {
        return Err(Problem::new(offset, Fault::Negative { value }));
    }
    for value in &mut values {
        *value = value.max(0.0);
    }
    Ok(values)
}

/// The values in the order of the angles that are kept.
fn table(
    values: Vec<f64>,
    height: usize,
    width: usize,
    vertical: &List,
    horizontal: &List,
) -> Result<Vec<f64>, Problem> {
    let is_plain = |order: &[usize], count: usize| order.iter().copied().eq(0..count);
    if is_plain(&vertical.order, height) && is_plain(&horizontal.order, width) {
        return Ok(values);
    }
    let mut table = Vec::new();
    table.try_reserve_exact(vertical.order.len() * horizontal.order.len())?;
    for h in &horizontal.order {
        let plane = values.get(h * height..(h + 1) * height).unwrap_or_default();
        table.extend(vertical.order.iter().filter_map(|&v| plane.get(v)));
    }
    Ok(table)
}

/// Makes the last plane, a turn after the first, the same.
fn close_seam(candela: &mut [f64], height: usize, remarks: &mut IesRemarks) {
    let (first, last) = candela.split_at_mut(candela.len() - height);
    for (last, &first) in last.iter_mut().zip(first.iter()) {
        if *last != first {
            IesRemarks::add(&mut remarks.open_seam);
            *last = first;
        }
    }
}
