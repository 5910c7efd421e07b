//! Error over time, both logarithmic, a curve for each program and way of asking.

use super::table::{Curve, Report, Row, curves, digits, exponent, spoken};
use crate::cli::drawing::{Anchor, Color, Drawing, Item, MARK_RADIUS, Mark, Xy, width};

const SIZE: Xy = [960.0, 540.0];

/// Where the axes cross, and how long they are.
const ORIGIN: Xy = [78.0, 478.0];
const AXES: Xy = [604.0, 398.0];

const LEGEND: Xy = [706.0, 96.0];
const LEGEND_STEP: f64 = 40.0;

/// The largest width of a line of the legend.
const LEGEND_WIDTH: f64 = 212.0;

const INK: Color = [34, 34, 38];
const GRAY: Color = [112, 112, 120];
const GRID: Color = [214, 214, 220];
const FINE_GRID: Color = [238, 238, 241];

/// Of candela's samples, its targets, and other programs: colors that those with color-deficient vision can tell apart
/// (Okabe & Ito 2008).
const COLORS: [Color; 7] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [150, 110, 0],
    [86, 180, 233],
    [230, 159, 0],
];

const MARKS: [Mark; 5] = [
    Mark::Circle,
    Mark::Square,
    Mark::Triangle,
    Mark::Diamond,
    Mark::Pentagon,
];

/// Space around the points, in decades.
const MARGIN: f64 = 0.18;

/// The plot of a report.
pub(super) fn plot(report: &Report) -> Drawing {
    let mut items = heading(report);
    let curves = curves(&report.rows);
    let Some(axes) = Axes::new(&curves, report) else {
        items.push(Item::text(
            [ORIGIN[0] + AXES[0] / 2.0, ORIGIN[1] - AXES[1] / 2.0],
            "no error is above 0: there is nothing to plot",
            14.0,
            GRAY,
            Anchor::Middle,
        ));
        return Drawing { size: SIZE, items };
    };
    axes.draw(&mut items);
    axes.references(report, &mut items);
    let styles = styles(&curves);
    for (curve, style) in curves.iter().zip(&styles) {
        let points: Vec<Xy> = curve
            .rows
            .iter()
            .filter_map(|row| axes.place(row))
            .collect();
        if points.len() > 1 {
            items.push(Item::Line {
                points,
                color: style.color,
                width: 1.8,
                is_dashed: style.is_hollow,
            });
        }
    }
    for (curve, style) in curves.iter().zip(&styles) {
        let places = curve.rows.iter().filter_map(|row| axes.place(row));
        items.extend(places.map(|at| style.mark(at)));
    }
    labels(&axes, &curves, &styles, &mut items);
    legend(report, &curves, &styles, &mut items);
    Drawing { size: SIZE, items }
}

fn heading(report: &Report) -> Vec<Item> {
    let [width, height] = report.resolution;
    let title = format!("Error over time: {}", report.scene);
    let threads = report.counted_threads();
    let below =
        format!("{width} × {height} pixels, {threads}; render time alone, median of the runs");
    vec![
        Item::text([ORIGIN[0], 34.0], &title, 18.0, INK, Anchor::Start),
        Item::text([ORIGIN[0], 56.0], &below, 12.0, GRAY, Anchor::Start),
    ]
}

/// What both axes show.
struct Axes {
    /// The logarithms at the ends, of time and of error.
    ends: [[f64; 2]; 2],
}

impl Axes {
    /// For all points, and a reference that is not far below; `None` where there are none.
    fn new(curves: &[Curve<'_>], report: &Report) -> Option<Self> {
        let rows = curves.iter().flat_map(|curve| &curve.rows);
        let points: Vec<[f64; 2]> = rows.filter_map(|row| row.point()).collect();
        let ends = |axis: usize| {
            let values = points.iter().map(|point| point[axis].log10());
            values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
                [low.min(value), high.max(value)]
            })
        };
        let mut ends = [ends(0), ends(1)];
        if points.is_empty() {
            return None;
        }
        for reference in references(report) {
            if ends[1][0] - reference.log10() < 1.0 {
                ends[1][0] = ends[1][0].min(reference.log10());
            }
        }
        for [low, high] in &mut ends {
            *low -= MARGIN;
            *high += MARGIN;
        }
        Some(Self { ends })
    }

    /// Where a value of an axis is, from 0 at its start to 1.
    fn part(&self, axis: usize, value: f64) -> f64 {
        let [low, high] = self.ends[axis];
        (value.log10() - low) / (high - low)
    }

    fn x(&self, time: f64) -> f64 {
        ORIGIN[0] + AXES[0] * self.part(0, time)
    }

    fn y(&self, error: f64) -> f64 {
        ORIGIN[1] - AXES[1] * self.part(1, error)
    }

    fn place(&self, row: &Row) -> Option<Xy> {
        row.point()
            .map(|[time, error]| [self.x(time), self.y(error)])
    }

    /// 1, 2, … 9 of each decade within an axis.
    fn ticks(&self, axis: usize) -> Vec<Tick> {
        let [low, high] = self.ends[axis];
        let decades = low.floor() as i32..=high.ceil() as i32;
        let all = decades.flat_map(|decade| (1..10).map(move |digit| (decade, digit)));
        let mut ticks: Vec<Tick> = all
            .map(|(decade, digit)| Tick {
                value: f64::from(digit) * 10.0_f64.powi(decade),
                digit,
            })
            .filter(|tick| (low..=high).contains(&tick.value.log10()))
            .collect();
        let is_short = ticks.iter().filter(|tick| tick.digit == 1).count() < 3;
        ticks.retain(|tick| tick.digit == 1 || high - low < 6.0);
        for tick in &mut ticks {
            // What is written down, of few decades 2 and 5 as well.
            if is_short && matches!(tick.digit, 2 | 5) {
                tick.digit = 1;
            }
        }
        ticks
    }

    fn draw(&self, items: &mut Vec<Item>) {
        let [left, bottom] = ORIGIN;
        let [right, top] = [left + AXES[0], bottom - AXES[1]];
        let line = |points: [Xy; 2], color, width| Item::Line {
            points: points.to_vec(),
            color,
            width,
            is_dashed: false,
        };
        let (times, errors) = (self.ticks(0), self.ticks(1));
        // The fine lines below the others.
        for is_named in [false, true] {
            let color = if is_named { GRID } else { FINE_GRID };
            for tick in times.iter().filter(|tick| tick.is_named() == is_named) {
                let x = self.x(tick.value);
                items.push(line([[x, bottom], [x, top]], color, 1.0));
            }
            for tick in errors.iter().filter(|tick| tick.is_named() == is_named) {
                let y = self.y(tick.value);
                items.push(line([[left, y], [right, y]], color, 1.0));
            }
        }
        for tick in times.iter().filter(|tick| tick.is_named()) {
            let at = [self.x(tick.value), bottom + 18.0];
            items.push(Item::text(
                at,
                &digits(tick.value),
                12.0,
                INK,
                Anchor::Middle,
            ));
        }
        for tick in errors.iter().filter(|tick| tick.is_named()) {
            let at = [left - 8.0, self.y(tick.value) + 4.0];
            items.push(Item::text(at, &digits(tick.value), 12.0, INK, Anchor::End));
        }
        items.push(line([[left, bottom], [right, bottom]], INK, 1.2));
        items.push(line([[left, bottom], [left, top]], INK, 1.2));
        let middle = [left + AXES[0] / 2.0, bottom - AXES[1] / 2.0];
        items.push(Item::text(
            [middle[0], bottom + 44.0],
            "render time (s)",
            13.0,
            INK,
            Anchor::Middle,
        ));
        items.push(Item::Text {
            at: [24.0, middle[1]],
            text: "RMSE (% of the mean radiance)".to_owned(),
            size: 13.0,
            color: INK,
            anchor: Anchor::Middle,
            turn: -90.0,
        });
    }

    /// The errors of the references themselves, where they are not far below.
    fn references(&self, report: &Report, items: &mut Vec<Item>) {
        let lowest = references(report).fold(f64::INFINITY, f64::min);
        if !(0.0..=1.0).contains(&self.part(1, lowest)) {
            return;
        }
        let y = self.y(lowest);
        items.push(Item::Line {
            points: vec![[ORIGIN[0], y], [ORIGIN[0] + AXES[0], y]],
            color: GRAY,
            width: 1.0,
            is_dashed: true,
        });
        let at = [ORIGIN[0] + 8.0, y - 5.0];
        let said = format!("the reference's own error, about {} %", digits(lowest));
        items.push(Item::text(at, &said, 11.0, GRAY, Anchor::Start));
    }
}

/// A line of the grid.
struct Tick {
    value: f64,
    /// Its first digit; 1 of all that have their number written down.
    digit: u32,
}

impl Tick {
    fn is_named(&self) -> bool {
        self.digit == 1
    }
}

/// The references' own errors in percent, those that are above 0.
fn references(report: &Report) -> impl Iterator<Item = f64> {
    let errors = report.references.iter().filter_map(|row| row.rmse_percent);
    errors.filter(|error| *error > 0.0)
}

/// How a curve is drawn.
struct Style {
    color: Color,
    mark: Mark,
    /// Of a transport that is not the first: hollow marks, dashed lines.
    is_hollow: bool,
}

impl Style {
    fn mark(&self, at: Xy) -> Item {
        Item::Mark {
            at,
            mark: self.mark,
            color: self.color,
            is_hollow: self.is_hollow,
        }
    }
}

/// A color and a mark for each series; the same for all transports.
fn styles(curves: &[Curve<'_>]) -> Vec<Style> {
    let mut series: Vec<&str> = Vec::new();
    let first = curves.first().map_or("", |curve| curve.transport);
    let mut styles = Vec::new();
    for curve in curves {
        let known = series.iter().position(|name| *name == curve.series);
        let number = known.unwrap_or_else(|| {
            series.push(curve.series);
            series.len() - 1
        });
        styles.push(Style {
            color: COLORS[number % COLORS.len()],
            mark: MARKS[number % MARKS.len()],
            is_hollow: curve.transport != first,
        });
    }
    styles
}

/// What makes each point of the first transport another, beside it, where there is room.
fn labels(axes: &Axes, curves: &[Curve<'_>], styles: &[Style], items: &mut Vec<Item>) {
    const FONT: f64 = 10.5;
    let all = || curves.iter().flat_map(|curve| &curve.rows);
    let marks = all().filter_map(|row| axes.place(row)).map(|[x, y]| {
        let radius = MARK_RADIUS + 1.0;
        [x - radius, y - radius, x + radius, y + radius]
    });
    let mut taken: Vec<[f64; 4]> = marks.collect();
    for curve in curves {
        let points: Vec<Xy> = curve
            .rows
            .iter()
            .filter_map(|row| axes.place(row))
            .collect();
        for ends in points.windows(2) {
            taken.extend(along([ends[0], ends[1]]).map(|[x, y]| [x, y, x, y]));
        }
    }
    for (curve, style) in curves.iter().zip(styles) {
        if style.is_hollow {
            continue;
        }
        for row in &curve.rows {
            let Some([x, y]) = axes.place(row) else {
                continue;
            };
            let wide = width(&row.label, FONT);
            let places = [
                [x + 8.0, y - 6.0],
                [x - 8.0 - wide, y + 13.0],
                [x - wide / 2.0, y - 10.0],
                [x - wide / 2.0, y + 18.0],
            ];
            let free = places.into_iter().find_map(|at @ [left, base]| {
                let around = [left - 1.0, base - FONT, left + wide + 1.0, base + 2.0];
                let is_free = taken.iter().all(|other| !overlap(&around, other));
                let is_inside = left + wide < ORIGIN[0] + AXES[0] && left > ORIGIN[0];
                (is_free && is_inside).then_some((at, around))
            });
            if let Some((at, around)) = free {
                taken.push(around);
                items.push(Item::text(at, &row.label, FONT, style.color, Anchor::Start));
            }
        }
    }
}

/// Points on a line, not far from each other.
fn along([from, to]: [Xy; 2]) -> impl Iterator<Item = Xy> {
    const STEP: f64 = 4.0;
    let way = [to[0] - from[0], to[1] - from[1]];
    let steps = (way[0].abs().max(way[1].abs()) / STEP).ceil().max(1.0) as u32;
    (0..=steps).map(move |step| {
        let part = f64::from(step) / f64::from(steps);
        [from[0] + part * way[0], from[1] + part * way[1]]
    })
}

/// Whether two rectangles, left, top, right, bottom, have points in common.
fn overlap(a: &[f64; 4], b: &[f64; 4]) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}

fn legend(report: &Report, curves: &[Curve<'_>], styles: &[Style], items: &mut Vec<Item>) {
    let [left, top] = LEGEND;
    let transports = curves
        .iter()
        .any(|curve| curve.transport != curves[0].transport);
    for (number, (curve, style)) in curves.iter().zip(styles).enumerate() {
        let y = top + LEGEND_STEP * number as f64;
        items.push(Item::Line {
            points: vec![[left, y - 4.0], [left + 26.0, y - 4.0]],
            color: style.color,
            width: 1.8,
            is_dashed: style.is_hollow,
        });
        items.push(style.mark([left + 13.0, y - 4.0]));
        let name = if transports {
            format!("{}, {}", curve.series, spoken(curve.transport))
        } else {
            curve.series.to_owned()
        };
        let at = [left + 36.0, y];
        items.push(Item::text(
            at,
            &fitting(&name, 12.0),
            12.0,
            INK,
            Anchor::Start,
        ));
        let is_of = |slope: &&super::table::Slope| {
            slope.series == curve.series && slope.transport == curve.transport
        };
        let slope = report
            .slopes
            .iter()
            .find(is_of)
            .and_then(|slope| slope.by_time);
        let slope = slope.map_or_else(String::new, |slope| {
            format!("RMSE ∝ time to the {}", exponent(slope))
        });
        items.push(Item::text(
            [left + 36.0, y + 15.0],
            &slope,
            10.5,
            GRAY,
            Anchor::Start,
        ));
    }
}

/// A text that is not wider than the legend.
fn fitting(name: &str, size: f64) -> String {
    let mut fitting = name.to_owned();
    while width(&fitting, size) > LEGEND_WIDTH && fitting.pop().is_some() {
        let kept = fitting.trim_end_matches('…').to_owned();
        let mut shorter = kept;
        shorter.pop();
        fitting = shorter + "…";
    }
    fitting
}

#[cfg(test)]
mod tests {
    use super::super::table::slopes;
    use super::super::table::tests::row;
    use super::*;
    use crate::cli::drawing::{raster, svg};

    fn report(rows: Vec<Row>) -> Report {
        Report {
            candela: "0",
            scene: "a <scene>.toml".to_owned(),
            resolution: [60, 40],
            threads: 2,
            references: Vec::new(),
            slopes: slopes(&rows),
            rows,
            left_out: Vec::new(),
            remarks: Vec::new(),
        }
    }

    #[test]
    fn each_row_is_a_point_where_its_numbers_are() {
        let counts = [1, 4, 16, 64, 256];
        let mut rows: Vec<Row> = counts.map(|n| row("candela", "rgb", n)).into();
        rows.extend(counts.map(|n| row("candela", "spectral", n)));
        let report = report(rows);
        let text = svg(&plot(&report), "plot");
        // Of both curves, and of their lines in the legend.
        assert_eq!(text.matches("class=\"mark\"").count(), 12, "{text}");
        // A power law is a straight line: equal steps.
        let line = text
            .lines()
            .find(|line| line.contains("polyline") && line.matches(',').count() == 5);
        let list = line.unwrap().split('"').nth(1).unwrap();
        let points: Vec<Vec<f64>> = list
            .split(' ')
            .map(|point| {
                point
                    .split(',')
                    .map(|number| number.parse().unwrap())
                    .collect()
            })
            .collect();
        let steps = |axis: usize| -> Vec<f64> {
            let both = points.windows(2);
            both.map(|both| both[1][axis] - both[0][axis]).collect()
        };
        for steps in [steps(0), steps(1)] {
            let equal = |step: &f64| *step > 0.0 && (step - steps[0]).abs() < 0.03;
            assert!(steps.iter().all(equal), "{points:?}");
        }
        assert!(
            text.contains("aria-label=\"RMSE ∝ time to the −0.75\""),
            "{text}"
        );
        assert!(text.contains("a &lt;scene&gt;.toml") && !text.contains("a <scene>"));
        assert!(text.contains("aria-label=\"render time (s)\""));
        for outside in ["http://", "https://", "file:", "<image", "<style"] {
            let found = text.matches(outside).count();
            // The name of SVG's own tags is no place.
            assert_eq!(found, usize::from(outside == "http://"), "{outside}");
        }
    }

    #[test]
    fn png_and_svg_are_of_one_drawing() {
        let report = report([1, 4, 16].map(|n| row("candela", "rgb", n)).into());
        let drawing = plot(&report);
        let picture = raster(&drawing, 2.0).unwrap();
        assert_eq!(picture.resolution(), [1920, 1080]);
        // In the middle of each mark is its color.
        let [blue, ..] = COLORS;
        let marks = drawing.items.iter().filter_map(|item| match item {
            Item::Mark { at, .. } => Some(*at),
            Item::Line { .. } | Item::Text { .. } | Item::Fill { .. } => None,
        });
        for [x, y] in marks {
            let place = (2.0 * y) as usize * 1920 + (2.0 * x) as usize;
            assert_eq!(picture.samples()[3 * place..][..3], blue);
        }
    }

    #[test]
    fn without_errors_there_is_no_curve() {
        let mut black = row("candela", "rgb", 1);
        black.errors.rmse_percent = None;
        let text = svg(&plot(&report(vec![black])), "plot");
        assert!(text.contains("there is nothing to plot"));
        assert_eq!(text.matches("class=\"mark\"").count(), 0);
    }

    #[test]
    fn one_point_is_enough() {
        let text = svg(&plot(&report(vec![row("candela", "rgb", 1)])), "plot");
        assert_eq!(text.matches("class=\"mark\"").count(), 2);
        assert!(!text.contains("NaN"));
    }

    #[test]
    fn long_names_end_in_dots() {
        assert_eq!(fitting("candela", 12.0), "candela");
        let long = fitting(&"renderer ".repeat(20), 12.0);
        assert!(long.ends_with('…') && width(&long, 12.0) <= LEGEND_WIDTH);
    }
}
