//! Lines of equal light over a picture in false colors, with their values.

mod labels;
mod trace;

use candela::display::{FalseColor, Field, Overlay};
use rayon::prelude::*;

use super::Failure;
use super::drawing::{Anchor, CAP, Color, Drawing, Item, Xy, raster_on, width};
use super::numbers::number;
use labels::{Path, Place, Rules, places};
use trace::{Level, Line, trace};

const LIGHT: Color = [244; 3];
const DARK: Color = [12; 3];

/// Where a false color has more light than this, of which 1 is white, black is seen better on it than white.
const BRIGHT: f64 = 0.2;

/// Pixels, beside a picture of [`ROWS`].
const LINE_WIDTH: f64 = 1.25;
const TEXT_SIZE: f64 = 11.5;
const PADDING: f64 = 4.0;
/// Nearer lines are none.
const CLOSEST: f64 = 3.0;
/// Shorter lines are specks.
const SHORTEST: f64 = 24.0;
/// Between labels of one value.
const APART: f64 = 170.0;
const ROWS: f64 = 480.0;

/// The color of the line of a value: that value's false color is on both of its sides.
pub(super) fn line_color(colors: &FalseColor, value: f64) -> Color {
    let part = colors.part(value);
    let below = if part < 0.0 {
        [0; 3]
    } else {
        colors.color(part)
    };
    let under = if part > 1.0 { [255; 3] } else { below };
    let [r, g, b] = under.map(|code| candela::internal::srgb_decode(f64::from(code) / 255.0));
    let [of_red, of_green, of_blue] = candela::Primaries::REC709.luminance_weights();
    if of_red * r + of_green * g + of_blue * b > BRIGHT {
        DARK
    } else {
        LIGHT
    }
}

/// The lines of these values, for a picture of this resolution.
pub(super) fn isolines(
    field: &Field,
    resolution: [u32; 2],
    values: &[f64],
    colors: &FalseColor,
) -> Result<Overlay, Failure> {
    // What the raster has, and what is made of it.
    let pixels = resolution
        .iter()
        .map(|&side| u64::from(side))
        .product::<u64>();
    let mut room: Vec<[u8; 8]> = Vec::new();
    room.try_reserve_exact(usize::try_from(pixels)?)?;
    drop(room);

    let items = items(field, resolution.map(f64::from), values, colors);
    let size = resolution.map(f64::from);
    let drawn = raster_on(&Drawing { size, items }, 1.0, [0; 4]);
    let ([width, _], pixels) = drawn.ok_or("the picture is too large for lines")?;
    Ok(Overlay {
        corner: [0, 0],
        width,
        pixels,
    })
}

fn items(field: &Field, size: Xy, values: &[f64], colors: &FalseColor) -> Vec<Item> {
    let scale = (size[0].min(size[1]) / ROWS).clamp(0.75, 8.0);
    let levels = levels(values, CLOSEST * scale.sqrt());
    let traced: Vec<Vec<Line>> = levels
        .into_par_iter()
        .map(|level| trace(field, level))
        .collect();
    let texts: Vec<String> = values.iter().map(|&value| number(value)).collect();
    let text_size = (TEXT_SIZE * scale).round();
    let mut paths: Vec<Path<'_>> = Vec::new();
    for (level, lines) in traced.iter().enumerate() {
        let room = width(&texts[level], text_size) + 2.0 * PADDING * scale;
        let lines = lines
            .iter()
            .map(|line| Path::new(&line.points, room, level));
        paths.extend(lines.filter(|path| path.length() >= SHORTEST * scale));
    }
    let rules = Rules {
        picture: size,
        height: CAP * text_size,
        apart: APART * scale,
    };
    let places = places(&paths, &rules);
    let mut items = Vec::new();
    for (number, path) in paths.iter().enumerate() {
        let color = line_color(colors, values[path.level]);
        let own = places.iter().filter(|place| place.path == number);
        items.extend(pieces(path, own).into_iter().map(|points| Item::Line {
            points,
            color,
            // Large pictures are shown smaller, but not all of them.
            width: LINE_WIDTH * scale.sqrt(),
            is_dashed: false,
        }));
    }
    for place in &places {
        let level = paths[place.path].level;
        let (sin, cos) = libm::sincos(place.turn.to_radians());
        let [x, y] = place.middle;
        // Digits stand on the base line; their middle is on the line.
        let down = CAP * text_size / 2.0;
        items.push(Item::Text {
            at: [x - down * sin, y + down * cos],
            text: texts[level].clone(),
            size: text_size,
            color: line_color(colors, values[level]),
            anchor: Anchor::Middle,
            turn: place.turn,
        });
    }
    items
}

/// The levels of values in order, of which two lines are at least so far apart.
fn levels(values: &[f64], apart: f64) -> Vec<Level> {
    let level = |(place, &value): (usize, &f64)| {
        let before = place.checked_sub(1).map(|place| value - values[place]);
        let after = values.get(place + 1).map(|next| next - value);
        let step = before
            .into_iter()
            .chain(after)
            .fold(f64::INFINITY, f64::min);
        Level {
            value,
            steepest: step / apart,
        }
    };
    values.iter().enumerate().map(level).collect()
}

/// A line without its gaps.
fn pieces<'p>(path: &Path<'_>, places: impl Iterator<Item = &'p Place>) -> Vec<Vec<Xy>> {
    let mut gaps: Vec<[f64; 2]> = places.map(|place| place.gap).collect();
    gaps.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let starts = std::iter::once(0.0).chain(gaps.iter().map(|gap| gap[1]));
    let ends = gaps.iter().map(|gap| gap[0]).chain([path.length()]);
    let piece = |(start, end): (f64, f64)| {
        let inside = path.points.iter().zip(&path.along);
        let inside = inside.filter(|&(_, &along)| start < along && along < end);
        let inside = inside.map(|(&point, _)| point);
        std::iter::once(path.at(start))
            .chain(inside)
            .chain([path.at(end)])
            .collect()
    };
    starts.zip(ends).map(piece).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use candela::image::Window;

    /// E = 10 x, 400 × 200 pixels: the line of 1000 lx is at x = 100, of the width that lines have.
    #[test]
    fn a_line_is_drawn_where_it_is() {
        let values = (0..200).flat_map(|_| (0..400).map(|x| 10.0 * (x as f32 + 0.5)));
        let field = Field::new(Window::whole([400, 200]), values.collect());
        let colors = FalseColor::illuminance(10.0, 10_000.0).unwrap();
        let overlay = isolines(&field, [400, 200], &[1000.0], &colors).unwrap();
        assert_eq!(overlay.pixels.len(), 400 * 200);
        let mut unbroken = 0;
        for row in overlay.pixels.chunks(400) {
            let coverage = |x: usize| f64::from(row[x][3]) / 255.0;
            let covered: Vec<usize> = (0..400).filter(|&x| row[x][3] > 0).collect();
            // Elsewhere is the label, which runs along the line.
            assert!(covered.iter().all(|x| (90..110).contains(x)), "{covered:?}");
            if covered == [99, 100] && (0.9..1.3).contains(&(coverage(99) + coverage(100))) {
                assert!((coverage(99) - coverage(100)).abs() < 0.02);
                unbroken += 1;
            }
        }
        assert!(unbroken > 140, "{unbroken}");
    }

    #[test]
    fn lines_are_seen_on_their_color() {
        let colors = FalseColor::illuminance(10.0, 1000.0).unwrap();
        assert_eq!(line_color(&colors, 20.0), LIGHT);
        assert_eq!(line_color(&colors, 900.0), DARK);
        // Beyond the range the picture is black, or white.
        assert_eq!(line_color(&colors, 5.0), LIGHT);
        assert_eq!(line_color(&colors, 2000.0), DARK);
    }

    #[test]
    fn a_gap_parts_a_line() {
        let points: Vec<Xy> = (0..=10).map(|x| [f64::from(x), 0.0]).collect();
        let path = Path::new(&points, 3.0, 0);
        let place = Place {
            path: 0,
            middle: [5.0, 0.0],
            turn: 0.0,
            gap: [3.5, 6.5],
        };
        let pieces = pieces(&path, [place].iter());
        assert_eq!(pieces.len(), 2);
        assert_eq!(pieces[0].last(), Some(&[3.5, 0.0]));
        assert_eq!(pieces[1].first(), Some(&[6.5, 0.0]));
    }
}
