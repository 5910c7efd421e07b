//! A drawing as pixels. tiny-skia fills and strokes paths with anti-aliasing; outlines of text are paths as well, so that
//! no font and no SVG has to be read.

use candela::display::Image;
use tiny_skia::{
    Color, FillRule, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, StrokeDash, Transform,
};

use super::{Drawing, Item, MARK_RADIUS, Mark, Segment, UNITS, Xy, glyph, placed, segments};

/// The drawing on white with so many pixels to a unit; `None` where that is no picture.
pub(in crate::cli) fn raster(drawing: &Drawing, scale: f64) -> Option<Image> {
    let pixels = drawn(drawing, scale, Color::WHITE)?;
    let opaque = pixels.pixels().iter();
    let opaque = opaque.map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]);
    let size = [pixels.width(), pixels.height()];
    Some(Image::opaque(size, opaque.collect()))
}

/// The drawing on a ground of R, G, B, A, and its width and height in pixels: sRGB-coded, R, G, B not multiplied by A.
/// `None` where that is no picture.
pub(in crate::cli) fn raster_on(
    drawing: &Drawing,
    scale: f64,
    [r, g, b, a]: [u8; 4],
) -> Option<([u32; 2], Vec<[u8; 4]>)> {
    let pixels = drawn(drawing, scale, Color::from_rgba8(r, g, b, a))?;
    let plain = pixels.pixels().iter().map(|pixel| {
        let pixel = pixel.demultiply();
        [pixel.red(), pixel.green(), pixel.blue(), pixel.alpha()]
    });
    Some(([pixels.width(), pixels.height()], plain.collect()))
}

fn drawn(drawing: &Drawing, scale: f64, ground: Color) -> Option<Pixmap> {
    let [width, height] = drawing.size.map(|side| (side * scale).round() as u32);
    let mut pixels = Pixmap::new(width, height)?;
    pixels.fill(ground);
    let whole = Transform::from_scale(scale as f32, scale as f32);
    for item in &drawing.items {
        draw(&mut pixels, item, whole);
    }
    Some(pixels)
}

fn draw(pixels: &mut Pixmap, item: &Item, whole: Transform) {
    match item {
        Item::Line {
            points,
            color,
            width,
            is_dashed,
        } => {
            let dash = is_dashed.then(|| StrokeDash::new(vec![6.0, 4.0], 0.0));
            let stroke = Stroke {
                width: *width as f32,
                line_join: tiny_skia::LineJoin::Round,
                dash: dash.flatten(),
                ..Stroke::default()
            };
            if let Some(path) = polygon(points, false) {
                pixels.stroke_path(&path, &paint(*color), &stroke, whole, None);
            }
        }
        Item::Fill { at, size, color } => {
            let ([x, y], [width, height]) = (at.map(|at| at as f32), size.map(|side| side as f32));
            if let Some(rectangle) = Rect::from_xywh(x, y, width, height) {
                pixels.fill_rect(rectangle, &paint(*color), whole, None);
            }
        }
        Item::Mark {
            at: [x, y],
            mark,
            color,
            is_hollow,
        } => {
            let path = match mark {
                Mark::Circle => PathBuilder::from_circle(*x as f32, *y as f32, MARK_RADIUS as f32),
                Mark::Square | Mark::Diamond | Mark::Triangle | Mark::Pentagon => {
                    let corners = mark.corners();
                    let corners: Vec<Xy> = corners.iter().map(|[a, b]| [x + a, y + b]).collect();
                    polygon(&corners, true)
                }
            };
            let fill = if *is_hollow { [255; 3] } else { *color };
            if let Some(path) = path {
                let stroke = Stroke {
                    width: 1.6,
                    ..Stroke::default()
                };
                pixels.fill_path(&path, &paint(fill), FillRule::Winding, whole, None);
                pixels.stroke_path(&path, &paint(*color), &stroke, whole, None);
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
            let scale = (size / UNITS) as f32;
            let place = Transform::from_translate(*x as f32, *y as f32);
            let turn = Transform::from_rotate(*turn as f32);
            let place = whole
                .pre_concat(place)
                .pre_concat(turn)
                .pre_scale(scale, -scale);
            for (at, character) in characters {
                let first = (at - width * anchor.part()).round();
                if let Some(path) = outline(character) {
                    let place = place.pre_translate(first as f32, 0.0);
                    pixels.fill_path(&path, &paint(*color), FillRule::Winding, place, None);
                }
            }
        }
    }
}

fn paint([r, g, b]: super::Color) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(r, g, b, 255);
    paint.anti_alias = true;
    paint
}

fn polygon(points: &[Xy], is_closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (number, point) in points.iter().enumerate() {
        let [x, y] = point.map(|number| number as f32);
        if number == 0 {
            path.move_to(x, y);
        } else {
            path.line_to(x, y);
        }
    }
    if is_closed {
        path.close();
    }
    path.finish()
}

/// A character's outline; `None` of a blank.
fn outline(character: char) -> Option<Path> {
    let mut path = PathBuilder::new();
    for segment in segments(glyph(character).1.path) {
        match segment {
            Segment::Move([x, y]) => path.move_to(x as f32, y as f32),
            Segment::Line([x, y]) => path.line_to(x as f32, y as f32),
            Segment::Curve([a, b], [x, y]) => path.quad_to(a as f32, b as f32, x as f32, y as f32),
            Segment::Close => path.close(),
        }
    }
    path.finish()
}
