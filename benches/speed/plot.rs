//! Tables as pictures: SVG with logarithmic axes, time on the left and memory on the right.

use std::fmt::Write as _;

use super::scaling::Table;

const PANEL: [f64; 2] = [360.0, 240.0];
const MARGIN: [f64; 2] = [56.0, 44.0];

/// A table's render time and peak memory over what grows.
pub(crate) fn plot(table: &Table) -> String {
    let [width, height] = [
        2.0 * (PANEL[0] + MARGIN[0]) + 24.0,
        PANEL[1] + 2.0 * MARGIN[1],
    ];
    let labels: Vec<(f64, &str)> = table
        .points
        .iter()
        .map(|point| (point.x, point.label()))
        .collect();
    let times = table
        .points
        .iter()
        .map(|point| (point.x, point.render.median));
    let memory = table.points.iter().filter_map(|point| {
        let peak = point.peak_memory?;
        Some((point.x, peak.median / 1e6))
    });
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n",
    );
    let panels: [(&str, Vec<(f64, f64)>); 2] = [
        ("render, s", times.collect()),
        ("peak memory, MB", memory.collect()),
    ];
    for (place, (title, values)) in panels.into_iter().enumerate() {
        let left = MARGIN[0] + place as f64 * (PANEL[0] + MARGIN[0]);
        panel(&mut svg, left, title, &table.axis, &labels, &values);
    }
    svg + "</svg>\n"
}

fn panel(
    svg: &mut String,
    left: f64,
    title: &str,
    axis: &str,
    labels: &[(f64, &str)],
    values: &[(f64, f64)],
) {
    if values.is_empty() {
        return;
    }
    let range = |numbers: &mut dyn Iterator<Item = f64>| {
        numbers.fold((f64::INFINITY, 0.0_f64), |(low, high), number| {
            (low.min(number), high.max(number))
        })
    };
    // Whole decades of time or memory, all of what grows.
    let (low_x, high_x) = range(&mut labels.iter().map(|label| label.0));
    let (low, high) = range(&mut values.iter().map(|value| value.1));
    let (low, high) = (low.log10().floor(), high.log10().ceil());
    let (top, bottom) = (MARGIN[1], MARGIN[1] + PANEL[1]);
    let x = |value: f64| {
        let span = (high_x / low_x).log10().max(f64::MIN_POSITIVE);
        left + PANEL[0] * (value / low_x).log10() / span
    };
    let y = |value: f64| bottom - PANEL[1] * (value.log10() - low) / (high - low).max(1.0);

    // Writing to a string does not fail.
    let _ = writeln!(
        svg,
        "<text x=\"{left}\" y=\"{}\" font-weight=\"bold\">{title}</text>\n\
         <text x=\"{}\" y=\"{}\" text-anchor=\"middle\">{axis}</text>",
        top - 14.0,
        left + PANEL[0] / 2.0,
        bottom + 34.0,
    );
    for decade in low as i32..=(high as i32).max(low as i32 + 1) {
        let value = 10.0_f64.powi(decade);
        let at = y(value);
        let _ = writeln!(
            svg,
            "<path d=\"M{left} {at:.1}h{}\" stroke=\"#ddd\"/>\
             <text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{value}</text>",
            PANEL[0],
            left - 6.0,
            at + 4.0,
        );
    }
    for (value, label) in labels {
        let at = x(*value);
        let _ = writeln!(
            svg,
            "<path d=\"M{at:.1} {top}v{}\" stroke=\"#eee\"/>\
             <text x=\"{at:.1}\" y=\"{}\" text-anchor=\"middle\">{label}</text>",
            PANEL[1],
            bottom + 16.0,
        );
    }
    let points: Vec<String> = values
        .iter()
        .map(|&(at, value)| format!("{:.1},{:.1}", x(at), y(value)))
        .collect();
    let _ = writeln!(
        svg,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"#c4622d\" stroke-width=\"2\"/>",
        points.join(" "),
    );
    for point in &points {
        let (x, y) = point.split_once(',').unwrap_or_default();
        let _ = writeln!(
            svg,
            "<circle cx=\"{x}\" cy=\"{y}\" r=\"3\" fill=\"#c4622d\"/>"
        );
    }
}
