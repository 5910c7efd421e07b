//! Lines of one value through a picture's numbers: marching squares over the centers of pixels.

use std::collections::HashMap;

use candela::display::Field;

use crate::cli::drawing::Xy;

/// A line in a picture, in pixels from the picture's top left.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Line {
    pub(super) points: Vec<Xy>,
    /// Whether the last point is the first.
    pub(super) is_closed: bool,
}

/// How far to each side of two pixels the differences are that theirs is measured by: up to three in a row, those of an
/// edge with its anti-aliasing, are fewer than half of the seven.
const REACH: usize = 3;

/// A difference is a jump where it is larger than so many times that of most pixels around,
const STEEPER: f64 = 4.0;
/// and than this part of the larger number, below which it is no more than a kink in the line.
const VISIBLE: f64 = 0.04;

/// No second end.
const NONE: usize = usize::MAX;

/// A value that has lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Level {
    pub(super) value: f64,
    /// The steepest that the numbers may be, per pixel: where they are steeper, this line and those of other values would
    /// run into each other.
    pub(super) steepest: f64,
}

/// All lines of a level, in the order of the picture's rows.
///
/// There is none through pixels without a surface, and none between pixels whose numbers jump, as at the edges of
/// objects and of hard shadows: all levels between the two would run there, on top of each other.
pub(super) fn trace(field: &Field, level: Level) -> Vec<Line> {
    let segments = segments(field, level);
    let level = level.value;
    // Each point is the end of one segment or two.
    let mut beside: HashMap<usize, [usize; 2]> = HashMap::new();
    for &[a, b] in &segments {
        for (from, to) in [(a, b), (b, a)] {
            let ends = beside.entry(from).or_insert([NONE; 2]);
            let free = usize::from(ends[0] != NONE);
            ends[free] = to;
        }
    }
    let mut lines = Vec::new();
    let mut follow = |start: usize, beside: &mut HashMap<usize, [usize; 2]>| {
        let mut sides = vec![start];
        let mut at = start;
        while let Some(next) = take(beside, at) {
            take_back(beside, next, at);
            sides.push(next);
            at = next;
            if at == start {
                break;
            }
        }
        if sides.len() > 1 {
            lines.push(Line {
                points: sides
                    .iter()
                    .map(|&side| point(field, side, level))
                    .collect(),
                is_closed: at == start,
            });
        }
    };
    // Those with ends from their ends; what is left are rings.
    for &[a, b] in &segments {
        for end in [a, b] {
            if beside.get(&end).is_some_and(|ends| ends[1] == NONE) {
                follow(end, &mut beside);
            }
        }
    }
    for &[a, _] in &segments {
        follow(a, &mut beside);
    }
    lines
}

/// The next point, whose segment counts as gone along then.
fn take(beside: &mut HashMap<usize, [usize; 2]>, at: usize) -> Option<usize> {
    let ends = beside.get_mut(&at)?;
    let place = ends.iter().position(|&end| end != NONE)?;
    Some(std::mem::replace(&mut ends[place], NONE))
}

/// The same segment, from its other end.
fn take_back(beside: &mut HashMap<usize, [usize; 2]>, at: usize, from: usize) {
    if let Some(ends) = beside.get_mut(&at)
        && let Some(end) = ends.iter_mut().find(|end| **end == from)
    {
        *end = NONE;
    }
}

/// Pieces of lines, from a side of a square of four pixels to another. A side is twice the number of its first pixel, plus 1
/// where it goes down.
fn segments(field: &Field, Level { value, steepest }: Level) -> Vec<[usize; 2]> {
    let [width, height] = field.size();
    let mut segments = Vec::new();
    let is_above = |number: f32| f64::from(number) >= value;
    for y in 0..height.saturating_sub(1) {
        for x in 0..width.saturating_sub(1) {
            let corners = [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)];
            let numbers = corners.map(|(x, y)| field.at(x, y));
            let [a, b, c, d] = numbers.map(is_above);
            if a == b && b == c && c == d || numbers.iter().any(|number| !number.is_finite()) {
                continue;
            }
            let numbers = numbers.map(f64::from);
            if slope(numbers) > steepest {
                continue;
            }
            let first = y * width + x;
            let [top, right, bottom, left] = [
                2 * first,
                2 * (first + 1) + 1,
                2 * (first + width),
                2 * first + 1,
            ];
            let crossed = [
                (a != b, top),
                (b != c, right),
                (d != c, bottom),
                (a != d, left),
            ];
            let mut crossed = crossed
                .into_iter()
                .filter_map(|(is_crossed, side)| is_crossed.then_some(side));
            if crossed.clone().any(|side| is_jump(field, side)) {
                continue;
            }
            match (crossed.next(), crossed.next(), crossed.next()) {
                (Some(one), Some(other), None) => segments.push([one, other]),
                // A saddle: what is in the middle says which corners belong together.
                (Some(_), Some(_), Some(_)) => {
                    let middle = numbers.iter().sum::<f64>() / 4.0;
                    if (middle >= value) == a {
                        segments.extend([[top, right], [bottom, left]]);
                    } else {
                        segments.extend([[top, left], [bottom, right]]);
                    }
                }
                _ => {}
            }
        }
    }
    segments
}

/// How much the numbers change from a pixel to the next at most, by those at the corners of a square, clockwise.
fn slope([a, b, c, d]: [f64; 4]) -> f64 {
    libm::hypot((b + c - a - d) / 2.0, (d + c - a - b) / 2.0)
}

/// The pixels at the ends of a side.
fn ends(field: &Field, side: usize) -> [[usize; 2]; 2] {
    let width = field.size()[0];
    let [x, y] = [side / 2 % width, side / 2 / width];
    let next = if side.is_multiple_of(2) {
        [x + 1, y]
    } else {
        [x, y + 1]
    };
    [[x, y], next]
}

/// Whether the numbers at the ends of a side are of two objects, or of light and shadow.
fn is_jump(field: &Field, side: usize) -> bool {
    let [[x, y], next] = ends(field, side);
    let number = |[x, y]: [usize; 2]| f64::from(field.at(x, y));
    let [one, other] = [[x, y], next].map(number);
    let difference = (other - one).abs();
    if difference <= VISIBLE * one.abs().max(other.abs()) {
        return false;
    }
    let is_down = next[0] == x;
    let (place, count) = if is_down {
        (y, field.size()[1])
    } else {
        (x, field.size()[0])
    };
    let along = |place: usize| number(if is_down { [x, place] } else { [place, y] });
    let around = place.saturating_sub(REACH)..(place + REACH + 1).min(count - 1);
    let mut differences: Vec<f64> = around
        .map(|place| (along(place + 1) - along(place)).abs())
        .filter(|difference| difference.is_finite())
        .collect();
    differences.sort_unstable_by(f64::total_cmp);
    // The lower one of two in the middle.
    let usual = differences[(differences.len() - 1) / 2];
    difference > STEEPER * usual
}

/// Where a side has the level.
fn point(field: &Field, side: usize, level: f64) -> Xy {
    let pixels = ends(field, side);
    let [one, other] = pixels.map(|[x, y]| f64::from(field.at(x, y)));
    let part = ((level - one) / (other - one)).clamp(0.0, 1.0);
    let [[x, y], [next_x, next_y]] = pixels.map(|place| place.map(|place| place as f64));
    let window = field.window();
    [
        f64::from(window.x) + 0.5 + x + part * (next_x - x),
        f64::from(window.y) + 0.5 + y + part * (next_y - y),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use candela::image::Window;

    fn trace(field: &Field, value: f64) -> Vec<Line> {
        let steepest = f64::INFINITY;
        super::trace(field, Level { value, steepest })
    }

    fn field(width: u32, height: u32, value: impl Fn(f64, f64) -> f64) -> Field {
        let values = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let center = |place: u32| f64::from(place) + 0.5;
        let values = values.map(|(x, y)| value(center(x), center(y)) as f32);
        Field::new(Window::whole([width, height]), values.collect())
    }

    /// E = 10 x: 205 lx are at x = 20.5, over all rows.
    #[test]
    fn a_ramp_has_a_straight_line() {
        let lines = trace(&field(40, 30, |x, _| 10.0 * x), 205.0);
        let [line] = &lines[..] else {
            panic!("{lines:?}")
        };
        assert!(!line.is_closed);
        assert_eq!(line.points.len(), 30);
        for (point, row) in line.points.iter().zip(0..) {
            assert!((point[0] - 20.5).abs() < 1e-5, "{point:?}");
            assert_eq!(point[1], f64::from(row) + 0.5);
        }
    }

    /// E = I h / (h² + r²)^(3/2) of a lamp above a floor: each level is a ring of a known radius.
    #[test]
    fn below_a_lamp_are_circles() {
        let [middle, height] = [100.3, 60.0];
        let intensity = 1e6;
        let field = field(200, 200, |x, y| {
            let squared = (x - middle).powi(2) + (y - middle).powi(2);
            intensity * height / (height * height + squared).powf(1.5)
        });
        for level in [60.0, 100.0, 200.0, 270.0_f64] {
            let distance = (intensity * height / level).cbrt();
            let radius = (distance * distance - height * height).sqrt();
            let lines = trace(&field, level);
            let [line] = &lines[..] else {
                panic!("{level}: {} lines", lines.len())
            };
            assert!(line.is_closed && line.points[0] == line.points[line.points.len() - 1]);
            for [x, y] in &line.points {
                let found = (x - middle).hypot(y - middle);
                assert!((found - radius).abs() < 0.02, "{found}, {radius}");
            }
        }
        assert_eq!(trace(&field, 280.0), []);
    }

    /// Where two surfaces meet, over two pixels, there is nothing; the ramp on one of them has its line up to the edge.
    #[test]
    fn jumps_have_no_line() {
        let edge = field(40, 20, |x, y| match x {
            ..20.0 => 100.0 + y,
            20.0..21.0 => 400.0,
            _ => 800.0 + 2.0 * x,
        });
        assert_eq!(trace(&edge, 300.0), []);
        let lines = trace(&edge, 110.0);
        let [line] = &lines[..] else {
            panic!("{lines:?}")
        };
        assert_eq!(line.points.len(), 20);
        assert!(
            line.points
                .iter()
                .all(|[x, y]| *x <= 19.5 && (y - 10.0).abs() < 1e-5)
        );
    }

    /// A shadow that is soft over four pixels is no jump.
    #[test]
    fn soft_shadows_have_lines() {
        let soft = field(40, 20, |x, _| {
            (800.0 - 200.0 * (x - 20.0)).clamp(0.0, 800.0)
        });
        let lines = trace(&soft, 500.0);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].points.iter().all(|[x, _]| (x - 21.5).abs() < 1e-5));
    }

    #[test]
    fn nothing_is_where_no_surface_is() {
        let part = field(40, 20, |x, _| if x < 15.0 { f64::NAN } else { 10.0 * x });
        assert_eq!(trace(&part, 120.0), []);
        assert_eq!(trace(&part, 200.0).len(), 1);
    }

    #[test]
    fn steep_places_have_no_line() {
        let ramp = field(40, 30, |x, _| 10.0 * x);
        let of = |steepest| {
            super::trace(
                &ramp,
                Level {
                    value: 205.0,
                    steepest,
                },
            )
            .len()
        };
        assert_eq!([of(9.9), of(10.1)], [0, 1]);
    }

    #[test]
    fn saddles_are_parted() {
        let saddle = field(20, 20, |x, y| 100.0 + (x - 10.0) * (y - 10.0));
        assert_eq!(trace(&saddle, 104.0).len(), 2);
        assert_eq!(trace(&saddle, 96.0).len(), 2);
    }
}
