//! A grid of small pictures with their names: where each goes, and what is drawn around them.

use candela::display::{Image, Overlay};

use crate::cli::Failure;
use crate::cli::drawing::{Anchor, Color, Drawing, Item, Xy, raster_on, width};

/// A neutral gray, so dark that pictures look as on a screen of their own.
pub(super) const GROUND: Color = [30; 3];

const TITLE: Color = [236; 3];
const NAME: Color = [214; 3];
const NOTE: Color = [144; 3];

/// Pixels of a sheet at most: 11 bytes each while it is drawn.
const LARGEST: u64 = 1 << 26;

/// Columns over rows that look well on a screen, in lengths.
const ASPECT: f64 = 1.5;

/// A picture and what is written below it.
pub(super) struct Cell {
    pub(super) name: String,
    /// Beside the name, at the right end.
    pub(super) note: String,
    pub(super) image: Image,
}

/// What is written above the pictures.
pub(super) struct Head {
    pub(super) title: String,
    pub(super) note: String,
}

/// Where the pictures go, in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layout {
    pub(super) columns: u32,
    rows: u32,
    /// Width and height of a picture.
    picture: [u32; 2],
    /// How large text and margins are: 1 beside pictures of 480 columns.
    scale: f64,
}

impl Layout {
    /// For so many pictures, at least one, of one size.
    pub(super) fn new(count: u32, picture: [u32; 2]) -> Self {
        let of = |columns: u32| {
            // Text stays readable beside small pictures.
            let scale = (f64::from(picture[0].max(picture[1])) / 480.0).clamp(0.75, 8.0);
            Self {
                columns,
                rows: count.div_ceil(columns),
                picture,
                scale,
            }
        };
        let cost = |layout: &Self| {
            let [width, height] = layout.size().map(|side| side as f64);
            let empty = f64::from(layout.columns * layout.rows - count);
            libm::fabs(libm::log(width / height / ASPECT)) + empty / f64::from(count)
        };
        let layouts = (1..=count.max(1)).map(of);
        let best = layouts.min_by(|one, other| cost(one).total_cmp(&cost(other)));
        best.unwrap_or_else(|| of(1))
    }

    /// So many units of the drawing, in pixels.
    fn pixels(&self, units: f64) -> u64 {
        (units * self.scale).round() as u64
    }

    fn margin(&self) -> u64 {
        self.pixels(36.0)
    }

    fn gap(&self) -> u64 {
        self.pixels(28.0)
    }

    /// The title's line with what is below it.
    fn head(&self) -> u64 {
        self.pixels(44.0)
    }

    /// The line of names below a picture.
    fn line(&self) -> u64 {
        self.pixels(26.0)
    }

    /// Width and height of the sheet.
    pub(super) fn size(&self) -> [u64; 2] {
        let [width, height] = self.picture.map(u64::from);
        let [columns, rows] = [self.columns, self.rows].map(u64::from);
        let across = columns * width + (columns - 1) * self.gap();
        let down = rows * (height + self.line()) + (rows - 1) * self.gap();
        // Below the last line there is room within the line.
        [
            across + 2 * self.margin(),
            self.margin() + self.head() + down + self.margin() - self.pixels(8.0),
        ]
    }

    /// The top left of a picture.
    fn corner(&self, number: u32) -> [u64; 2] {
        let [width, height] = self.picture.map(u64::from);
        let [column, row] = [number % self.columns, number / self.columns].map(u64::from);
        [
            self.margin() + column * (width + self.gap()),
            self.margin() + self.head() + row * (height + self.line() + self.gap()),
        ]
    }
}

/// Draws the sheet.
pub(super) fn sheet(layout: &Layout, head: &Head, cells: &[Cell]) -> Result<Image, Failure> {
    let size = layout.size();
    let too_large = || {
        format!(
            "the sheet would have {} × {} pixels; choose smaller pictures with --width",
            size[0], size[1]
        )
    };
    let [width, height] = size;
    if width * height > LARGEST {
        return Err(too_large().into());
    }
    let drawing = Drawing {
        size: size.map(|side| side as f64),
        items: items(layout, head, cells),
    };
    let [r, g, b] = GROUND;
    let (size, pixels) = raster_on(&drawing, 1.0, [r, g, b, u8::MAX]).ok_or_else(too_large)?;
    let opaque = pixels.into_iter().map(|[r, g, b, _]| [r, g, b]);
    let mut image = Image::opaque(size, opaque.collect());
    for (number, cell) in (0..).zip(cells) {
        let [x, y] = layout.corner(number).map(|place| place as u32);
        let samples = cell.image.samples().as_chunks::<3>().0;
        let pixels: Vec<[u8; 4]> = samples
            .iter()
            .map(|&[r, g, b]| [r, g, b, u8::MAX])
            .collect();
        image.lay(&Overlay {
            corner: [x, y],
            width: layout.picture[0],
            pixels,
        });
    }
    Ok(image)
}

/// All text of the sheet.
fn items(layout: &Layout, head: &Head, cells: &[Cell]) -> Vec<Item> {
    let unit = layout.scale;
    let margin = layout.margin() as f64;
    let right = layout.size()[0] as f64 - margin;
    let mut items = Vec::new();
    // The base of capitals of 22 units is 16 below their top.
    let line = Line {
        left: margin,
        right,
        base: margin + 16.0 * unit,
        gap: 18.0 * unit,
    };
    line.write(
        &mut items,
        (&head.title, 22.0 * unit, TITLE),
        (&head.note, 14.0 * unit, NOTE),
    );
    for (number, cell) in (0..).zip(cells) {
        let [x, y] = layout.corner(number).map(|place| place as f64);
        let line = Line {
            left: x,
            right: x + f64::from(layout.picture[0]),
            base: y + f64::from(layout.picture[1]) + 20.0 * unit,
            gap: 12.0 * unit,
        };
        line.write(
            &mut items,
            (&cell.name, 14.0 * unit, NAME),
            (&cell.note, 13.0 * unit, NOTE),
        );
    }
    items
}

/// A line with a text at its start and one at its end.
struct Line {
    left: f64,
    right: f64,
    base: f64,
    /// Between the two.
    gap: f64,
}

/// A text, its size and color.
type Styled<'t> = (&'t str, f64, Color);

impl Line {
    fn write(&self, items: &mut Vec<Item>, first: Styled<'_>, last: Styled<'_>) {
        let mut add = |at: Xy, (text, size, color): Styled<'_>, anchor| {
            items.push(Item::Text {
                at,
                text: text.to_owned(),
                size,
                color,
                anchor,
                turn: 0.0,
            });
        };
        let room = self.right - self.left;
        let (name, size, color) = first;
        // A name may take it all; what is beside it goes where it fits.
        let name = fitting(name, size, room);
        let rest = room - width(&name, size) - self.gap;
        add([self.left, self.base], (&name, size, color), Anchor::Start);
        if width(last.0, last.1) <= rest {
            add([self.right, self.base], last, Anchor::End);
        }
    }
}

/// As much of a text as has room, with … where some is left out: in the middle, since both ends tell more.
fn fitting(text: &str, size: f64, room: f64) -> String {
    if width(text, size) <= room {
        return text.to_owned();
    }
    let characters: Vec<char> = text.chars().collect();
    let shortened = |kept: usize| {
        let (start, end) = (kept.div_ceil(2), kept / 2);
        let start: String = characters[..start].iter().collect();
        let end: String = characters[characters.len() - end..].iter().collect();
        start + "…" + &end
    };
    let mut kept = (0..characters.len()).rev();
    let kept = kept.find(|&kept| width(&shortened(kept), size) <= room);
    shortened(kept.unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_fit_a_screen() {
        let columns = |count| Layout::new(count, [480, 270]).columns;
        let all: Vec<u32> = (1..=16).map(columns).collect();
        for (count, columns) in (1..).zip(&all) {
            let rows = u32::div_ceil(count, *columns);
            assert!(
                columns * rows < count + rows.max(*columns),
                "{count}: {columns}"
            );
        }
        assert_eq!(all[..10], [1, 2, 2, 2, 3, 3, 3, 3, 3, 4]);
        // A tall picture beside another rather than above it.
        assert_eq!(Layout::new(2, [200, 480]).columns, 2);
        assert_eq!(Layout::new(3, [1000, 100]).columns, 1);
    }

    #[test]
    fn pictures_lie_inside_of_the_sheet() {
        for count in 1..=20 {
            let layout = Layout::new(count, [123, 77]);
            let [width, height] = layout.size();
            let [x, y] = layout.corner(count - 1);
            assert!(x + 123 + layout.margin() <= width);
            assert!(y + 77 + layout.line() <= height);
        }
    }

    #[test]
    fn long_names_lose_their_middle() {
        assert_eq!(fitting("abc", 10.0, 100.0), "abc");
        let short = fitting("a_very_long_name_of_a_layer", 10.0, 60.0);
        assert!(width(&short, 10.0) <= 60.0);
        assert!(short.starts_with("a_v") && short.ends_with("er") && short.contains('…'));
        assert_eq!(fitting("abcdef", 10.0, 1.0), "…");
    }
}
