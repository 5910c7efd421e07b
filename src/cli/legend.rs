//! The legend of false colors, as a panel in the picture itself or beside it.

use candela::display::{FalseColor, Measure, Overlay};

use super::drawing::{Anchor, CAP, Color, Drawing, Item, Xy, raster_on, width};
use super::numbers::number;

/// The panel: dark, and the picture shows through a little.
const GROUND: [u8; 4] = [20, 20, 20, 214];

const TEXT: Color = [228; 3];
const LINE: Color = [150; 3];

/// Pictures of so many rows have text of [`TEXT_SIZE`] pixels.
const ROWS: f64 = 480.0;
const TEXT_SIZE: f64 = 12.0;

/// Pixels, beside a picture of [`ROWS`].
const MARGIN: f64 = 12.0;
const PADDING: f64 = 12.0;
const BAR_WIDTH: f64 = 14.0;
const LONGEST_BAR: f64 = 300.0;
const SHORTEST_BAR: f64 = 48.0;
/// The fields of what is above and below the range, and how far they are from the bar.
const FIELD: f64 = 12.0;
const FIELD_GAP: f64 = 4.0;
/// Marks beside the bar, and how far numbers are from it.
const TICK: f64 = 4.0;
const TO_NUMBERS: f64 = 9.0;
/// Between two numbers, at least.
const APART: f64 = 19.0;

/// A value that is marked, such as that of a line in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mark {
    pub(super) value: f64,
    /// Of its line.
    pub(super) color: Color,
}

/// The legend at the right edge of a picture, in the middle, if there is room for it.
pub(super) fn legend(resolution: [u32; 2], colors: &FalseColor, marks: &[Mark]) -> Option<Overlay> {
    let [columns, rows] = resolution.map(f64::from);
    let panel = Panel::new(colors, marks, [columns, rows], LONGEST_BAR)?;
    let [width, height] = panel.size;
    if width + 2.0 * panel.pixels(MARGIN) > columns {
        return None;
    }
    let drawing = Drawing {
        size: panel.size,
        items: panel.items(colors),
    };
    let (size, pixels) = raster_on(&drawing, 1.0, GROUND)?;
    let left = columns - width - panel.pixels(MARGIN);
    let top = ((rows - height) / 2.0).floor();
    Some(Overlay {
        corner: [left, top].map(|place| place as u32),
        width: size[0],
        pixels,
    })
}

/// The legend at the right of a picture, as high as it is, if that is high enough.
pub(super) fn beside(resolution: [u32; 2], colors: &FalseColor, marks: &[Mark]) -> Option<Overlay> {
    let [columns, rows] = resolution.map(f64::from);
    let mut panel = Panel::new(colors, marks, [columns, rows], f64::INFINITY)?;
    // What is over and under the panel where it is in the picture.
    panel.top += ((rows - panel.size[1]) / 2.0).floor();
    panel.size[1] = rows;
    let [r, g, b, _] = GROUND;
    let drawing = Drawing {
        size: panel.size,
        items: panel.items(colors),
    };
    let (size, pixels) = raster_on(&drawing, 1.0, [r, g, b, 255])?;
    Some(Overlay {
        corner: [resolution[0], 0],
        width: size[0],
        pixels,
    })
}

/// The size of what is drawn, in whole pixels.
struct Panel {
    /// Pixels of a unit.
    scale: f64,
    size: Xy,
    /// The bar's top, and its length.
    top: f64,
    length: f64,
    title: &'static str,
    /// Where on the bar, from 0 below to 1, and the number.
    ticks: Vec<(f64, String)>,
    /// Lines across the bar, and their colors.
    marks: Vec<(f64, Color)>,
    /// What is written beside the fields below and above the range.
    ends: [String; 2],
}

impl Panel {
    /// `None` where there is no room.
    fn new(colors: &FalseColor, marks: &[Mark], [columns, rows]: Xy, longest: f64) -> Option<Self> {
        let scale = (rows.min(columns) / ROWS).clamp(0.75, 8.0);
        let pixels = |units: f64| (units * scale).round();
        let title = match colors.measure() {
            Measure::Stops => "EV",
            Measure::Luminance => "cd/m²",
            Measure::Illuminance => "lx",
        };
        let field = pixels(FIELD) + pixels(FIELD_GAP);
        let head = pixels(PADDING) + pixels(TEXT_SIZE + 8.0);
        let around = head + 2.0 * field + pixels(PADDING);
        let length = (rows - 2.0 * pixels(MARGIN) - around).min(pixels(longest));
        if length < pixels(SHORTEST_BAR) {
            return None;
        }
        let [least, most] = colors.range();
        let ends = [
            format!("< {}", written(least)),
            format!("> {}", written(most)),
        ];
        let room = length / pixels(APART);
        let ticks = if marks.is_empty() {
            ticks(colors, room)
        } else {
            marked(colors, marks, room)
        };
        let marks = marks
            .iter()
            .map(|mark| (colors.part(mark.value), mark.color));
        let marks = marks.filter(|(part, _)| (0.0..=1.0).contains(part));
        let size = pixels(TEXT_SIZE);
        let numbers = ticks.iter().map(|(_, number)| number).chain(&ends);
        let widest = numbers
            .map(|number| width(number, size))
            .fold(0.0, f64::max);
        let to_numbers = pixels(BAR_WIDTH) + pixels(TO_NUMBERS);
        let inside = (to_numbers + widest).max(width(title, size)).ceil();
        Some(Self {
            scale,
            size: [inside + 2.0 * pixels(PADDING), length + around],
            top: head + field,
            length,
            title,
            ticks,
            marks: marks.collect(),
            ends,
        })
    }

    fn pixels(&self, units: f64) -> f64 {
        (units * self.scale).round()
    }

    fn items(&self, colors: &FalseColor) -> Vec<Item> {
        let left = self.pixels(PADDING);
        let bar = self.pixels(BAR_WIDTH);
        let field = self.pixels(FIELD);
        let gap = self.pixels(FIELD_GAP);
        let bottom = self.top + self.length;
        let title = self.top - gap - field - self.pixels(TEXT_SIZE + 8.0) + self.cap();
        let mut items = vec![self.text([left, title], self.title)];
        let mut fill = |y: f64, height: f64, color: Color| {
            items.push(Item::Fill {
                at: [left, y],
                size: [bar, height],
                color,
            });
        };
        fill(self.top - gap - field, field, [255; 3]);
        fill(bottom + gap, field, [0; 3]);
        let rows = self.length as u32;
        for row in 0..rows {
            let part = 1.0 - (f64::from(row) + 0.5) / f64::from(rows);
            fill(self.top + f64::from(row), 1.0, colors.color(part));
        }
        let right = left + bar;
        for &(part, color) in &self.marks {
            let y = bottom - part * self.length;
            items.push(Item::Line {
                points: vec![[left, y], [right, y]],
                color,
                width: self.scale,
                is_dashed: false,
            });
        }
        let numbers = right + self.pixels(TO_NUMBERS);
        let middle = self.cap() / 2.0;
        for (part, number) in &self.ticks {
            let y = bottom - part * self.length;
            items.push(Item::Line {
                points: vec![
                    [right + self.pixels(1.0), y],
                    [right + self.pixels(1.0 + TICK), y],
                ],
                color: LINE,
                width: self.scale,
                is_dashed: false,
            });
            items.push(self.text([numbers, y + middle], number));
        }
        let [below, above] = &self.ends;
        items.push(self.text([numbers, self.top - gap - field / 2.0 + middle], above));
        items.push(self.text([numbers, bottom + gap + field / 2.0 + middle], below));
        items
    }

    /// How high digits and capitals are.
    fn cap(&self) -> f64 {
        self.pixels(TEXT_SIZE) * CAP
    }

    fn text(&self, at: Xy, text: &str) -> Item {
        Item::Text {
            at,
            text: text.to_owned(),
            size: self.pixels(TEXT_SIZE),
            color: TEXT,
            anchor: Anchor::Start,
            turn: 0.0,
        }
    }
}

/// The values that are marked, of which numbers have room: from the largest on.
fn marked(colors: &FalseColor, marks: &[Mark], most: f64) -> Vec<(f64, String)> {
    let free = 0.4 / most;
    let mut last = f64::INFINITY;
    let mut ticks = Vec::new();
    for mark in marks.iter().rev() {
        let part = colors.part(mark.value);
        if (free..=1.0 - free).contains(&part) && last - part >= 0.8 / most {
            ticks.push((part, written(mark.value)));
            last = part;
        }
    }
    ticks
}

/// Where marks go, and their numbers, at most about so many; none at the ends, which have their own.
fn ticks(colors: &FalseColor, most: f64) -> Vec<(f64, String)> {
    let [first, last] = colors.range();
    let numbers = match colors.measure() {
        Measure::Stops => {
            let steps = [1.0, 2.0, 4.0, 8.0];
            let step = steps.into_iter().find(|step| (last - first) / step <= most);
            let step = step.unwrap_or(16.0);
            let numbers = (first / step).ceil() as i32..=(last / step).floor() as i32;
            numbers.map(|number| f64::from(number) * step).collect()
        }
        Measure::Luminance | Measure::Illuminance => {
            let decades = libm::log10(last / first);
            // From the most marks of a decade to those of every fourth one.
            let within: &[f64] = if decades * 3.0 <= most {
                &[1.0, 2.0, 5.0]
            } else {
                &[1.0]
            };
            let steps = [1, 2, 4, 8, 16];
            let step = steps
                .into_iter()
                .find(|&step| decades / f64::from(step) <= most);
            let step = step.unwrap_or(32);
            let powers = libm::log10(first).floor() as i32..=libm::log10(last).ceil() as i32;
            let powers = powers.filter(|power| power.rem_euclid(step) == 0);
            let numbers = powers.flat_map(|power| {
                within
                    .iter()
                    // As a text, so that 0.001 is written like that.
                    .filter_map(move |digit| format!("{digit}e{power}").parse::<f64>().ok())
            });
            numbers.collect::<Vec<f64>>()
        }
    };
    let ticks = numbers
        .into_iter()
        .map(|number| (colors.part(number), number));
    // The width of a number's half from the ends.
    let free = 0.4 / most;
    let ticks = ticks.filter(|(part, _)| (free..=1.0 - free).contains(part));
    ticks
        .map(|(part, number)| (part, written(number)))
        .collect()
}

/// A number with a minus, not a hyphen. Ends of a range in stops are off by a rounding.
fn written(value: f64) -> String {
    let rounded = format!("{value:.2e}").parse().unwrap_or(value);
    number(rounded).replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;
    use candela::display::Image;

    fn numbers(colors: &FalseColor, most: f64) -> String {
        let ticks = ticks(colors, most).into_iter();
        let numbers: Vec<String> = ticks.map(|(_, number)| number).collect();
        numbers.join(" ")
    }

    #[test]
    fn marks_are_round_numbers() {
        let stops = FalseColor::default();
        assert_eq!(numbers(&stops, 9.0), "−6 −4 −2 0 2 4 6");
        assert_eq!(numbers(&stops, 4.0), "−4 0 4");
        let three = FalseColor::luminance(0.1, 100.0).unwrap();
        assert_eq!(numbers(&three, 10.0), "0.2 0.5 1 2 5 10 20 50");
        assert_eq!(numbers(&three, 5.0), "1 10");
        let wide = FalseColor::luminance(1e-6, 1e6).unwrap();
        assert_eq!(numbers(&wide, 7.0), "0.0001 0.01 1 100 10000");
    }

    /// A tick's number is the value that is there on the bar, whatever chose it.
    #[test]
    fn ticks_carry_their_values() {
        let colors = FalseColor::illuminance(5.0, 2000.0).unwrap();
        let marks = [10.0, 75.0, 300.0, 310.0, 1000.0].map(|value| Mark {
            value,
            color: [255; 3],
        });
        for ticks in [ticks(&colors, 20.0), marked(&colors, &marks, 20.0)] {
            assert!(ticks.len() >= 4);
            for (part, text) in ticks {
                let value: f64 = text.parse().unwrap();
                let there = 5.0 * (2000.0_f64 / 5.0).powf(part);
                assert!((there / value - 1.0).abs() < 1e-12, "{there}, {text}");
            }
        }
        // Numbers that would overlap: the larger one stays.
        let numbers: Vec<String> = marked(&colors, &marks, 20.0)
            .into_iter()
            .map(|(_, number)| number)
            .collect();
        assert_eq!(numbers, ["1000", "310", "75", "10"]);
    }

    /// The panel is where the pixels differ, the bar's colors are those of the map, and the rest is as it was.
    #[test]
    fn the_bar_shows_the_map() {
        const SIZE: [u32; 2] = [640, 480];
        let gray = vec![[100; 3]; 640 * 480];
        let mut image = Image::opaque(SIZE, gray);
        let colors = FalseColor::default();
        image.lay(&legend(SIZE, &colors, &[]).unwrap());
        let panel = Panel::new(&colors, &[], SIZE.map(f64::from), LONGEST_BAR).unwrap();
        let pixels = image.samples().as_chunks::<3>().0;
        let at = |x: f64, y: f64| pixels[y as usize * 640 + x as usize];
        let left = 640.0 - panel.size[0] - panel.pixels(MARGIN);
        let top = ((480.0 - panel.size[1]) / 2.0).floor();
        let middle = left + panel.pixels(PADDING) + panel.pixels(BAR_WIDTH) / 2.0;
        for row in [0.0, 10.0, 149.0, 200.0, 299.0] {
            let part = 1.0 - (row + 0.5) / panel.length;
            assert_eq!(at(middle, top + panel.top + row), colors.color(part));
        }
        let field = panel.pixels(FIELD) / 2.0 + panel.pixels(FIELD_GAP);
        assert_eq!(at(middle, top + panel.top - field), [255; 3]);
        assert_eq!(at(middle, top + panel.top + panel.length + field), [0; 3]);
        assert_eq!(at(left - 1.0, 240.0), [100; 3]);
        assert_eq!(at(640.0 - panel.pixels(MARGIN), 240.0), [100; 3]);
        // 214 of 255 of the panel's 20, the rest of the picture's 100.
        assert_eq!(at(left + 1.0, top + 1.0), [33; 3]);
    }

    #[test]
    fn small_pictures_have_none() {
        assert_eq!(legend([60, 40], &FalseColor::default(), &[]), None);
        assert_eq!(beside([60, 40], &FalseColor::default(), &[]), None);
    }
}
