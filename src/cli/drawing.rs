//! A drawing of lines, marks and text, from which SVG and PNG are made: both show the same.
//!
//! Text is outlines, not characters of whatever font a viewer has: it looks the same everywhere.

mod raster;
mod svg;

use std::collections::HashMap;
use std::sync::OnceLock;

pub(super) use raster::{raster, raster_on};
pub(super) use svg::{escaped, svg};

/// The outlines, and where they are from.
const GLYPHS: &str = include_str!("drawing/glyphs.txt");

/// Units of the outlines in the font size.
pub(super) const UNITS: f64 = 2048.0;

/// How high digits and capitals are in the font size: 1493 of 2048 units in DejaVu Sans.
pub(super) const CAP: f64 = 0.729;

/// What is drawn for a character that there is no outline of.
const UNKNOWN: char = '□';

/// sRGB-coded R, G, B.
pub(super) type Color = [u8; 3];

/// A place or a size, x to the right and y down.
pub(super) type Xy = [f64; 2];

/// What is drawn, the first things below the others, on white unless another ground is given.
pub(super) struct Drawing {
    pub(super) size: Xy,
    pub(super) items: Vec<Item>,
}

/// Something that is drawn.
pub(super) enum Item {
    Line {
        points: Vec<Xy>,
        color: Color,
        width: f64,
        is_dashed: bool,
    },
    /// A rectangle.
    Fill {
        /// Its top left.
        at: Xy,
        size: Xy,
        color: Color,
    },
    Mark {
        at: Xy,
        mark: Mark,
        color: Color,
        /// Whether its inside is white.
        is_hollow: bool,
    },
    Text {
        at: Xy,
        text: String,
        size: f64,
        color: Color,
        anchor: Anchor,
        /// By how many degrees it is turned clockwise around its place; −90 runs upwards.
        turn: f64,
    },
}

impl Item {
    /// A line of text that runs to the right.
    pub(super) fn text(at: Xy, text: &str, size: f64, color: Color, anchor: Anchor) -> Self {
        Self::Text {
            at,
            text: text.to_owned(),
            size,
            color,
            anchor,
            turn: 0.0,
        }
    }
}

/// The shape of a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mark {
    Circle,
    Square,
    Diamond,
    Triangle,
    Pentagon,
}

/// What of a text is at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// The distance of a mark's corners from its middle, about; its area is that of the circle.
pub(super) const MARK_RADIUS: f64 = 4.5;

impl Mark {
    /// Its corners around (0, 0); none of a circle.
    pub(super) fn corners(self) -> Vec<Xy> {
        let (count, first, radius): (u32, f64, f64) = match self {
            Self::Circle => return Vec::new(),
            Self::Square => (4, 45.0, 1.25),
            Self::Diamond => (4, 0.0, 1.3),
            Self::Triangle => (3, 90.0, 1.45),
            Self::Pentagon => (5, 90.0, 1.2),
        };
        let corner = |number| {
            let angle = (first + 360.0 / f64::from(count) * f64::from(number)).to_radians();
            let radius = radius * MARK_RADIUS;
            [radius * libm::cos(angle), -radius * libm::sin(angle)]
        };
        (0..count).map(corner).collect()
    }
}

/// A character's outline.
pub(super) struct Glyph {
    /// How far the next character is, in [`UNITS`].
    pub(super) advance: f64,
    /// Its path as SVG has it, in absolute coordinates, y up.
    pub(super) path: &'static str,
}

/// A part of a path, y up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Segment {
    Move(Xy),
    Line(Xy),
    /// The control point, and the end.
    Curve(Xy, Xy),
    Close,
}

/// The character that is drawn for one, and its outline.
pub(super) fn glyph(character: char) -> (char, &'static Glyph) {
    static TABLE: OnceLock<HashMap<char, Glyph>> = OnceLock::new();
    let table = TABLE.get_or_init(|| GLYPHS.lines().filter_map(parsed).collect());
    match table.get(&character) {
        Some(glyph) => (character, glyph),
        None => (UNKNOWN, &table[&UNKNOWN]),
    }
}

/// The outline in a line of the table; `None` of a comment.
fn parsed(line: &'static str) -> Option<(char, Glyph)> {
    if line.starts_with('#') {
        return None;
    }
    let (code, rest) = line.split_once(' ')?;
    let (advance, path) = rest.split_once(' ')?;
    let character = char::from_u32(u32::from_str_radix(code, 16).ok()?)?;
    let advance = advance.parse().ok()?;
    Some((character, Glyph { advance, path }))
}

/// The characters of a text, each with where it starts in [`UNITS`]; and how wide all are.
pub(super) fn placed(text: &str) -> (Vec<(f64, char)>, f64) {
    let mut at = 0.0;
    let characters = text.chars().map(|character| {
        let start = at;
        let (character, glyph) = glyph(character);
        at += glyph.advance;
        (start, character)
    });
    let characters = characters.collect();
    (characters, at)
}

/// The width of a text of this font size.
pub(super) fn width(text: &str, size: f64) -> f64 {
    placed(text).1 * size / UNITS
}

/// The parts of an outline. As SVG has it, numbers go on with the last command; those after a move are of lines.
pub(super) fn segments(path: &str) -> Vec<Segment> {
    let mut segments: Vec<Segment> = Vec::new();
    let starts: Vec<usize> = path
        .match_indices(|c: char| c.is_ascii_alphabetic())
        .map(|(start, _)| start)
        .collect();
    let ends = starts.iter().skip(1).copied().chain([path.len()]);
    for (&start, end) in starts.iter().zip(ends) {
        let numbers: Vec<f64> = path[start + 1..end]
            .split_whitespace()
            .filter_map(|number| number.parse().ok())
            .collect();
        let command = &path[start..=start];
        let [here_x, here_y] = segments.last().map_or([0.0; 2], |last| last.end());
        match command {
            "M" | "L" => {
                let ends = numbers.as_chunks::<2>().0.iter().enumerate();
                segments.extend(ends.map(|(number, &end)| match (command, number) {
                    ("M", 0) => Segment::Move(end),
                    _ => Segment::Line(end),
                }));
            }
            "H" => segments.extend(numbers.iter().map(|&x| Segment::Line([x, here_y]))),
            "V" => segments.extend(numbers.iter().map(|&y| Segment::Line([here_x, y]))),
            "Q" => {
                let curves = numbers.as_chunks::<4>().0.iter();
                segments.extend(curves.map(|&[a, b, x, y]| Segment::Curve([a, b], [x, y])));
            }
            _ => segments.push(Segment::Close),
        }
    }
    segments
}

impl Segment {
    /// Where it ends; not asked of one that closes, which a move follows.
    fn end(self) -> Xy {
        match self {
            Self::Move(end) | Self::Line(end) | Self::Curve(_, end) => end,
            Self::Close => [0.0; 2],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_outline_is_read() {
        for code in 32..127 {
            let character = char::from(code);
            let (drawn, glyph) = glyph(character);
            assert_eq!(drawn, character);
            assert!(glyph.advance > 0.0);
            let parts = segments(glyph.path);
            assert_eq!(parts.is_empty(), character == ' ', "{character}");
            // No number is left over.
            let numbers = |part: &Segment| match part {
                Segment::Move(_) | Segment::Line(_) => 2,
                Segment::Curve(..) => 4,
                Segment::Close => 0,
            };
            let of_one = glyph.path.matches(['H', 'V']).count();
            let blanks = glyph.path.replace(|c: char| c.is_ascii_alphabetic(), " ");
            let written = blanks.split_whitespace().count();
            assert_eq!(parts.iter().map(numbers).sum::<usize>(), written + of_one);
        }
        assert_eq!(glyph('語').0, UNKNOWN);
    }

    #[test]
    fn an_outline_in_parts() {
        let parts = segments("M1 2 1 3H3V4L5 6Q7 8 9 10Z");
        let expected = [
            Segment::Move([1.0, 2.0]),
            Segment::Line([1.0, 3.0]),
            Segment::Line([3.0, 3.0]),
            Segment::Line([3.0, 4.0]),
            Segment::Line([5.0, 6.0]),
            Segment::Curve([7.0, 8.0], [9.0, 10.0]),
            Segment::Close,
        ];
        assert_eq!(parts, expected);
    }
}
