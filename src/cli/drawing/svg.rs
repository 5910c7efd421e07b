//! A drawing as SVG.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::{Anchor, Color, Drawing, Item, MARK_RADIUS, Mark, UNITS, Xy, glyph, placed};

/// The drawing as a file of its own: no font, no style and no other file is asked for.
pub(in crate::cli) fn svg(drawing: &Drawing, title: &str) -> String {
    let [width, height] = drawing.size;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" role=\"img\">\n<title>{}</title>\n<defs>\n",
        escaped(title),
    );
    // Writing to a string does not fail.
    for character in characters(drawing) {
        let path = glyph(character).1.path;
        let _ = writeln!(svg, "<path id=\"{}\" d=\"{path}\"/>", id(character));
    }
    let _ = writeln!(
        svg,
        "</defs>\n<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>"
    );
    for item in &drawing.items {
        write(&mut svg, item);
    }
    svg + "</svg>\n"
}

/// The characters that have an outline.
fn characters(drawing: &Drawing) -> BTreeSet<char> {
    let mut characters = BTreeSet::new();
    for item in &drawing.items {
        if let Item::Text { text, .. } = item {
            characters.extend(placed(text).0.iter().map(|&(_, character)| character));
        }
    }
    characters.remove(&' ');
    characters
}

fn id(character: char) -> String {
    format!("c{:x}", u32::from(character))
}

fn write(svg: &mut String, item: &Item) {
    // Writing to a string does not fail.
    let _ = match item {
        Item::Line {
            points,
            color,
            width,
            is_dashed,
        } => {
            let dashes = if *is_dashed {
                " stroke-dasharray=\"6 4\""
            } else {
                ""
            };
            writeln!(
                svg,
                "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{width}\" \
                 stroke-linejoin=\"round\"{dashes}/>",
                list(points),
                code(*color),
            )
        }
        Item::Fill {
            at: [x, y],
            size: [width, height],
            color,
        } => writeln!(
            svg,
            "<rect x=\"{x:.2}\" y=\"{y:.2}\" width=\"{width:.2}\" height=\"{height:.2}\" fill=\"{}\"/>",
            code(*color),
        ),
        Item::Mark {
            at,
            mark,
            color,
            is_hollow,
        } => {
            let fill = if *is_hollow {
                "#ffffff".to_owned()
            } else {
                code(*color)
            };
            let paint = format!(
                "fill=\"{fill}\" stroke=\"{}\" stroke-width=\"1.6\"",
                code(*color)
            );
            let [x, y] = *at;
            match mark {
                Mark::Circle => writeln!(
                    svg,
                    "<circle class=\"mark\" cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{MARK_RADIUS}\" {paint}/>"
                ),
                Mark::Square | Mark::Diamond | Mark::Triangle | Mark::Pentagon => {
                    let corners: Vec<Xy> =
                        mark.corners().iter().map(|[a, b]| [x + a, y + b]).collect();
                    writeln!(
                        svg,
                        "<polygon class=\"mark\" points=\"{}\" {paint}/>",
                        list(&corners)
                    )
                }
            }
        }
        Item::Text {
            at: [x, y],
            text,
            size,
            color,
            anchor,
            turn,
        } => {
            let (characters, width) = placed(text);
            let turn = if *turn == 0.0 {
                String::new()
            } else {
                format!(" rotate({turn})")
            };
            let first = -width * anchor.part();
            let mut uses = String::new();
            for (at, character) in characters.iter().filter(|(_, character)| *character != ' ') {
                let _ = write!(
                    uses,
                    "<use href=\"#{}\" x=\"{:.0}\"/>",
                    id(*character),
                    first + at
                );
            }
            writeln!(
                svg,
                "<g aria-label=\"{}\" fill=\"{}\" transform=\"translate({x:.2} {y:.2}){turn} \
                 scale({scale:.6} -{scale:.6})\">{uses}</g>",
                escaped(text),
                code(*color),
                scale = size / UNITS,
            )
        }
    };
}

impl Anchor {
    /// How much of a text is before its place.
    pub(super) const fn part(self) -> f64 {
        match self {
            Self::Start => 0.0,
            Self::Middle => 0.5,
            Self::End => 1.0,
        }
    }
}

fn code([r, g, b]: Color) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

fn list(points: &[Xy]) -> String {
    let points: Vec<String> = points
        .iter()
        .map(|[x, y]| format!("{x:.2},{y:.2}"))
        .collect();
    points.join(" ")
}

/// A text as XML and HTML have it, between tags and in quotes.
pub(in crate::cli) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            character if character.is_control() => escaped.push(' '),
            character => escaped.push(character),
        }
    }
    escaped
}
