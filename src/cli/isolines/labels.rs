//! Where lines have their values written: few places, where the line is straight and nothing else is near.

use std::collections::HashMap;

use crate::cli::drawing::Xy;

/// A line, and how far along it each of its points is.
pub(super) struct Path<'l> {
    pub(super) points: &'l [Xy],
    pub(super) along: Vec<f64>,
    /// The width of its label.
    pub(super) width: f64,
    /// Lines of one number have one value.
    pub(super) level: usize,
}

/// A place for a label.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Place {
    pub(super) path: usize,
    pub(super) middle: Xy,
    /// By how much it is turned clockwise, −90° to 90°: it is never upside down.
    pub(super) turn: f64,
    /// The part of the line that it takes the place of.
    pub(super) gap: [f64; 2],
}

/// What labels keep to.
pub(super) struct Rules {
    pub(super) picture: Xy,
    /// How high digits are.
    pub(super) height: f64,
    /// Between labels of one value.
    pub(super) apart: f64,
}

/// The most labels of a line.
const MOST: usize = 4;

/// The chord of a label is at least so much of the line below it.
const STRAIGHT: f64 = 0.97;

impl<'l> Path<'l> {
    pub(super) fn new(points: &'l [Xy], width: f64, level: usize) -> Self {
        let mut length = 0.0;
        let mut along = vec![0.0];
        for pair in points.windows(2) {
            length += distance(pair[0], pair[1]);
            along.push(length);
        }
        Self {
            points,
            along,
            width,
            level,
        }
    }

    pub(super) fn length(&self) -> f64 {
        self.along.last().copied().unwrap_or(0.0)
    }

    /// The point so far along the line.
    pub(super) fn at(&self, along: f64) -> Xy {
        let after = self.along.partition_point(|&before| before < along);
        let after = after.clamp(1, self.points.len() - 1);
        let [start, end] = [self.along[after - 1], self.along[after]];
        let part = if end > start {
            ((along - start) / (end - start)).clamp(0.0, 1.0)
        } else {
            0.0
        };
        let [from, to] = [self.points[after - 1], self.points[after]];
        [0, 1].map(|axis| from[axis] + part * (to[axis] - from[axis]))
    }
}

fn distance(a: Xy, b: Xy) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}

/// Places for labels, the longest lines first.
pub(super) fn places(paths: &[Path<'_>], rules: &Rules) -> Vec<Place> {
    let lines = Lines::new(paths, rules.height);
    let mut order: Vec<usize> = (0..paths.len()).collect();
    order.sort_by(|&a, &b| paths[b].length().total_cmp(&paths[a].length()));
    let mut placed: Vec<(Place, usize, f64)> = Vec::new();
    for number in order {
        let path = &paths[number];
        let mut candidates = candidates(number, path, rules);
        candidates.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        let wanted = (path.length() / (2.0 * rules.apart)).ceil() as usize;
        let mut count = 0;
        for (_, place) in candidates {
            if count == wanted.min(MOST) {
                break;
            }
            let is_free = placed.iter().all(|(other, level, width)| {
                let least = if *level == path.level {
                    rules.apart
                } else {
                    (width + path.width) / 2.0 + rules.height
                };
                distance(other.middle, place.middle) >= least
            });
            if is_free && !lines.are_near(&place, path, rules.height) {
                placed.push((place, path.level, path.width));
                count += 1;
            }
        }
    }
    placed.into_iter().map(|(place, ..)| place).collect()
}

/// Places along a line where a label would be within the picture and on a straight piece, the lower the number the better.
fn candidates(number: usize, path: &Path<'_>, rules: &Rules) -> Vec<(f64, Place)> {
    let length = path.length();
    // Some of the line shows on both sides.
    let margin = path.width / 2.0 + 2.0 * rules.height;
    let step = (rules.height / 2.0).max(1.0);
    let count = ((length - 2.0 * margin) / step).floor();
    if count.is_nan() || count < 0.0 {
        return Vec::new();
    }
    let [columns, rows] = rules.picture;
    let edge = path.width / 2.0 + rules.height;
    let places = (0..=count as usize).filter_map(|place| {
        let middle = margin + place as f64 * step;
        let gap = [middle - path.width / 2.0, middle + path.width / 2.0];
        let [start, end] = gap.map(|along| path.at(along));
        let straight = distance(start, end) / path.width;
        let at = [0, 1].map(|axis| (start[axis] + end[axis]) / 2.0);
        let is_inside =
            (edge..columns - edge).contains(&at[0]) && (edge..rows - edge).contains(&at[1]);
        if straight < STRAIGHT || !is_inside {
            return None;
        }
        let turn = libm::atan2(end[1] - start[1], end[0] - start[0]).to_degrees();
        // Read from below or, where the line is upright, from the right.
        let turn = match turn {
            ..=-90.0 => turn + 180.0,
            90.0.. => turn - 180.0,
            _ => turn,
        };
        let tilt = libm::sin(turn.to_radians()).abs();
        let off = (middle / length - 0.5).abs();
        let cost = 10.0 * (1.0 - straight) + 0.5 * tilt + 0.5 * off;
        let place = Place {
            path: number,
            middle: at,
            turn,
            gap,
        };
        Some((cost, place))
    });
    places.collect()
}

/// Which lines are where.
struct Lines {
    /// The side of a square of the picture, in pixels.
    side: f64,
    /// The number of a line and how far along it that is, of each point in a square.
    squares: HashMap<[i64; 2], Vec<(usize, f64)>>,
}

impl Lines {
    fn new(paths: &[Path<'_>], height: f64) -> Self {
        let side = (height / 2.0).max(1.0);
        let mut squares: HashMap<_, Vec<_>> = HashMap::new();
        for (number, path) in paths.iter().enumerate() {
            for (&point, &along) in path.points.iter().zip(&path.along) {
                let square = squares.entry(square(point, side)).or_default();
                if square.last().is_none_or(|&(last, _)| last != number) {
                    square.push((number, along));
                }
            }
        }
        Self { side, squares }
    }

    /// Whether another line, or the same farther on, runs through a label or close by.
    fn are_near(&self, place: &Place, path: &Path<'_>, height: f64) -> bool {
        let [half, up] = [path.width / 2.0, height];
        let (sin, cos) = libm::sincos(place.turn.to_radians());
        let across = (2.0 * half / self.side).ceil() as i64;
        let down = (2.0 * up / self.side).ceil() as i64;
        (0..=across).any(|column| {
            (0..=down).any(|row| {
                let x = half * (2.0 * column as f64 / across as f64 - 1.0);
                let y = up * (2.0 * row as f64 / down as f64 - 1.0);
                let [left, top] = place.middle;
                let point = [left + x * cos - y * sin, top + x * sin + y * cos];
                let there = self.squares.get(&square(point, self.side));
                let [start, end] = place.gap;
                let own = start - 2.0 * height..end + 2.0 * height;
                there.is_some_and(|there| {
                    there
                        .iter()
                        .any(|(line, along)| *line != place.path || !own.contains(along))
                })
            })
        })
    }
}

fn square(point: Xy, side: f64) -> [i64; 2] {
    point.map(|place| (place / side).floor() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RULES: Rules = Rules {
        picture: [400.0, 300.0],
        height: 8.0,
        apart: 120.0,
    };

    fn level_line(y: f64) -> Vec<Xy> {
        (10..=390).map(|x| [f64::from(x), y]).collect()
    }

    #[test]
    fn labels_are_sparse_and_readable() {
        // From right to left: what is written still runs to the right.
        let points: Vec<Xy> = level_line(150.0).into_iter().rev().collect();
        let paths = [Path::new(&points, 30.0, 0)];
        let places = places(&paths, &RULES);
        assert_eq!(places.len(), 2);
        assert!(places.iter().all(|place| place.turn.abs() < 1e-9));
        assert!(distance(places[0].middle, places[1].middle) >= 120.0);
        assert!((places[0].middle[0] - 200.0).abs() < 8.0);
        let [start, end] = places[0].gap;
        assert!((end - start - 30.0).abs() < 1e-9);
    }

    #[test]
    fn there_is_none_where_lines_are_close() {
        let [one, other] = [level_line(150.0), level_line(155.0)];
        let paths = [Path::new(&one, 30.0, 0), Path::new(&other, 30.0, 1)];
        assert_eq!(places(&paths, &RULES), []);
        let far = level_line(190.0);
        let paths = [Path::new(&one, 30.0, 0), Path::new(&far, 30.0, 1)];
        assert_eq!(places(&paths, &RULES).len(), 4);
    }

    #[test]
    fn small_rings_have_none() {
        let ring: Vec<Xy> = (0..=60)
            .map(|step| {
                let (sin, cos) = libm::sincos(f64::from(step).to_radians() * 6.0);
                [200.0 + 12.0 * cos, 150.0 + 12.0 * sin]
            })
            .collect();
        assert_eq!(places(&[Path::new(&ring, 30.0, 0)], &RULES), []);
    }
}
