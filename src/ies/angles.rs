//! Angles as they are written to angles as they are kept: ascending, each once, in the standard's range.
//!
//! LM-63-02, section 4. Vertical angles of type C go from 0 or 90 to 90 or 180, those of types A and B from
//! −90 or 0 to 90. The last horizontal angle of type C tells the symmetry: 0 axial, 90 quadrants, 180
//! mirrored, 360 none; from 90 to 270 it is mirrored by the other plane. Of types A and B the first one does:
//! 0 mirrored, −90 none.

use super::coordinates::Coordinates;
use super::error::{Fault, Problem};
use super::limits::ANGLE_TOLERANCE;
use super::numbers::Number;
use super::photometry::Symmetry;
use super::remarks::IesRemarks;

/// Angles, and whose values are theirs.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct List {
    /// Degrees, strictly ascending.
    pub(super) angles: Vec<f64>,
    /// The places in the file's list.
    pub(super) order: Vec<usize>,
}

fn is_near(a: f64, b: f64) -> bool {
    (a - b).abs() <= ANGLE_TOLERANCE
}

impl List {
    /// Sorted; of equal angles one. `is_same` says whether two places of the file's list have the same values.
    fn sorted(
        written: &[Number],
        what: &'static str,
        is_same: &impl Fn(usize, usize) -> bool,
        remarks: &mut IesRemarks,
    ) -> Result<Self, Problem> {
        let mut pairs = Vec::new();
        pairs.try_reserve_exact(written.len())?;
        pairs.extend(written.iter().map(|number| number.value).zip(0_usize..));
        if !pairs.is_sorted_by(|a, b| a.0 <= b.0) {
            IesRemarks::add(&mut remarks.unsorted_lists);
            pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        }
        for &[(a, i), (b, j)] in pairs.array_windows() {
            if a == b && !is_same(i, j) {
                let offset = written.get(j).map_or(0, |number| number.offset);
                return Err(Problem::new(offset, Fault::Twice { what, value: b }));
            }
        }
        let before = pairs.len();
        pairs.dedup_by(|a, b| a.0 == b.0);
        let repeated = u32::try_from(before - pairs.len()).unwrap_or(u32::MAX);
        remarks.repeated_angles = remarks.repeated_angles.saturating_add(repeated);
        Ok(Self {
            angles: pairs.iter().map(|pair| pair.0).collect(),
            order: pairs.iter().map(|pair| pair.1).collect(),
        })
    }

    pub(super) fn first(&self) -> f64 {
        self.angles.first().copied().unwrap_or_default()
    }

    pub(super) fn last(&self) -> f64 {
        self.angles.last().copied().unwrap_or_default()
    }

    /// Angles times `sign` plus `shift`, ascending again.
    fn moved(&mut self, sign: f64, shift: f64) {
        for angle in &mut self.angles {
            *angle = sign * *angle + shift;
        }
        if sign < 0.0 {
            self.angles.reverse();
            self.order.reverse();
        }
    }

    /// Puts the first and the last angle where they are meant to be, if they are near.
    fn round_ends(&mut self, ends: &[f64], remarks: &mut IesRemarks) {
        let count = self.angles.len();
        for i in [0, count.saturating_sub(1)] {
            let Some(angle) = self.angles.get(i).copied() else {
                continue;
            };
            let near = ends.iter().find(|&&end| is_near(angle, end));
            // Others may be as near: they stay apart.
            let fits = |end: f64| {
                let below = i.checked_sub(1).and_then(|i| self.angles.get(i));
                let above = self.angles.get(i + 1);
                below.is_none_or(|&other| other < end) && above.is_none_or(|&other| other > end)
            };
            if let Some(&end) = near.filter(|&&end| end != angle && fits(end)) {
                self.angles[i] = end;
                IesRemarks::add(&mut remarks.rounded_angles);
            }
        }
    }
}

fn in_range(
    written: &[Number],
    what: &'static str,
    coordinates: Coordinates,
    (least, most): (f64, f64),
) -> Result<(), Problem> {
    let is_beyond = |value: f64| value < least - ANGLE_TOLERANCE || value > most + ANGLE_TOLERANCE;
    match written.iter().find(|number| is_beyond(number.value)) {
        Some(&Number { value, offset }) => {
            let fault = Fault::Angle {
                what,
                value,
                coordinates,
                least,
                most,
            };
            Err(Problem::new(offset, fault))
        }
        None => Ok(()),
    }
}

/// The vertical angles.
pub(super) fn vertical(
    written: &[Number],
    coordinates: Coordinates,
    is_same: &impl Fn(usize, usize) -> bool,
    remarks: &mut IesRemarks,
) -> Result<List, Problem> {
    let [limits, _] = coordinates.limits();
    in_range(written, "vertical", coordinates, limits)?;
    let mut list = List::sorted(written, "vertical", is_same, remarks)?;
    let ends: &[f64] = match coordinates {
        Coordinates::C => &[0.0, 90.0, 180.0],
        Coordinates::A => &[-90.0, 0.0, 90.0],
        Coordinates::B => &[-180.0, -90.0, 0.0, 90.0, 180.0],
    };
    list.round_ends(ends, remarks);
    let (first, last) = (list.first(), list.last());
    if list.angles.len() < 2 {
        let offset = written.first().map_or(0, |number| number.offset);
        let fault = Fault::OutOfRange {
            what: "the number of different vertical angles",
            value: 1.0,
            expected: "at least 2, such as 0 and 90",
        };
        return Err(Problem::new(offset, fault));
    }
    let is_whole = match coordinates {
        Coordinates::C => ends.contains(&first) && ends.contains(&last),
        Coordinates::A | Coordinates::B => last >= 90.0 && (first == 0.0 || first <= -90.0),
    };
    remarks.partial_range |= !is_whole;
    Ok(list)
}

/// The horizontal angles, and the symmetry that they tell.
pub(super) fn horizontal(
    written: &[Number],
    coordinates: Coordinates,
    is_same: &impl Fn(usize, usize) -> bool,
    remarks: &mut IesRemarks,
) -> Result<(List, Symmetry), Problem> {
    let [_, limits] = coordinates.limits();
    in_range(written, "horizontal", coordinates, limits)?;
    match coordinates {
        Coordinates::C => {
            let unwrapped = unwrapped(written)?;
            if unwrapped != written {
                remarks.turned_planes = true;
            }
            let list = List::sorted(&unwrapped, "horizontal", is_same, remarks)?;
            around(list, written, remarks)
        }
        Coordinates::A | Coordinates::B => {
            let list = List::sorted(written, "horizontal", is_same, remarks)?;
            sideways(list, written, coordinates, limits.1, remarks)
        }
    }
}

/// Angles that start again at 0 amid the list go on beyond 360.
fn unwrapped(written: &[Number]) -> Result<Vec<Number>, Problem> {
    let mut angles = Vec::new();
    angles.try_reserve_exact(written.len())?;
    angles.extend_from_slice(written);
    let is_descent = |pair: &[Number; 2]| pair[1].value < pair[0].value;
    let mut descents = written
        .array_windows()
        .enumerate()
        .filter(|(_, pair)| is_descent(pair));
    let (first, second) = (descents.next(), descents.next());
    let (Some(start), Some(end)) = (written.first(), written.last()) else {
        return Ok(angles);
    };
    if let (Some((i, [before, after])), None) = (first, second)
        && before.value > 180.0
        && end.value <= start.value
        // What is a turn further on follows, as the next plane does.
        && after.value + 360.0 - before.value <= 90.0
    {
        for angle in angles.iter_mut().skip(i + 1) {
            angle.value += 360.0;
        }
    }
    Ok(angles)
}

/// Horizontal angles of type C.
fn around(
    mut list: List,
    written: &[Number],
    remarks: &mut IesRemarks,
) -> Result<(List, Symmetry), Problem> {
    let (first, last) = (list.first(), list.last());
    let span = last - first;
    // By how many quarters the list starts after 0, if these are whole.
    let quarters = libm::rint(first / 90.0);
    let at_quarter = is_near(first, quarters * 90.0);
    let is_even = quarters.rem_euclid(2.0) == 0.0;
    if list.angles.len() == 1 {
        remarks.turned_planes |= first != 0.0;
        list.angles = vec![0.0];
        return Ok((list, Symmetry::Axial));
    }
    if is_near(span, 90.0) && at_quarter {
        if quarters != 0.0 {
            remarks.turned_planes = true;
            if is_even {
                list.moved(1.0, -quarters * 90.0);
            } else {
                list.moved(-1.0, (quarters + 1.0) * 90.0);
            }
        }
        list.round_ends(&[0.0, 90.0], remarks);
        return Ok((list, Symmetry::Quadrants));
    }
    if is_near(span, 180.0) && at_quarter {
        let symmetry = if is_even {
            if quarters != 0.0 {
                remarks.turned_planes = true;
                match quarters.rem_euclid(4.0) {
                    0.0 => list.moved(1.0, -quarters * 90.0),
                    _ => list.moved(-1.0, (quarters + 2.0) * 90.0),
                }
            }
            list.round_ends(&[0.0, 180.0], remarks);
            Symmetry::Mirrored
        } else {
            if quarters != 1.0 {
                remarks.turned_planes = true;
                match quarters.rem_euclid(4.0) {
                    1.0 => list.moved(1.0, (1.0 - quarters) * 90.0),
                    _ => list.moved(-1.0, (quarters + 3.0) * 90.0),
                }
            }
            list.round_ends(&[90.0, 270.0], remarks);
            Symmetry::MirroredAcross
        };
        return Ok((list, symmetry));
    }
    let gap = 360.0 - span;
    let mut steps = list.angles.array_windows().map(|[a, b]| b - a);
    let (first_step, last_step) = (steps.clone().next(), steps.next_back());
    let fits = |step: Option<f64>| step.is_some_and(|step| is_near(step, gap));
    if !is_near(gap, 0.0) {
        // Two planes do not tell a step.
        if !(list.angles.len() > 2 && gap > 0.0 && (fits(first_step) || fits(last_step))) {
            let offset = written.last().map_or(0, |number| number.offset);
            return Err(Problem::new(offset, Fault::NoSymmetry { first, last }));
        }
        remarks.added_plane = true;
        let order = list.order.first().copied().unwrap_or_default();
        list.angles.push(first + 360.0);
        list.order.push(order);
    }
    if !(0.0..360.0).contains(&first) {
        remarks.turned_planes = true;
        list.moved(1.0, -360.0 * (first / 360.0).floor());
    }
    remarks.turned_planes |= first != 0.0 && !is_near(first, 0.0);
    let start = list.first();
    let start = if is_near(start, 0.0) { 0.0 } else { start };
    list.round_ends(&[start, start + 360.0], remarks);
    Ok((list, Symmetry::None))
}

/// Horizontal angles of types A and B.
fn sideways(
    mut list: List,
    written: &[Number],
    coordinates: Coordinates,
    most: f64,
    remarks: &mut IesRemarks,
) -> Result<(List, Symmetry), Problem> {
    if list.angles.len() > 1 && list.first() < 0.0 && is_near(list.last(), 0.0) {
        list.moved(-1.0, 0.0);
        remarks.turned_planes = true;
    }
    list.round_ends(&[-most, -90.0, 0.0, 90.0, most], remarks);
    let (first, last) = (list.first(), list.last());
    if list.angles.len() < 2 || first > 0.0 || last < 0.0 {
        let offset = written.first().map_or(0, |number| number.offset);
        let fault = Fault::NoMiddle {
            coordinates,
            first,
            last,
        };
        return Err(Problem::new(offset, fault));
    }
    remarks.partial_range |= last < 90.0 || !(first == 0.0 || first <= -90.0);
    let symmetry = if first == 0.0 {
        Symmetry::Mirrored
    } else {
        Symmetry::None
    };
    Ok((list, symmetry))
}
