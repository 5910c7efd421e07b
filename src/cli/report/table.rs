//! What was measured, as CSV, as JSON, and for reading.

use std::io::Write;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::fit::slope;
use super::metrics::Errors;
use crate::cli::Failure;
use crate::cli::numbers::number;

/// A picture's time and error.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Row {
    /// The program, and the way it was asked: points of one curve have one name.
    pub(super) series: String,
    /// How light is carried: `rgb` or `spectral`.
    pub(super) transport: String,
    /// What makes it another point of the curve.
    pub(super) setting: String,
    /// That, in short.
    #[serde(skip)]
    pub(super) label: String,
    /// Camera rays over pixels; not known of all programs.
    pub(super) samples_per_pixel: Option<f64>,
    /// The median of the runs: render time alone.
    pub(super) seconds: f64,
    pub(super) runs: u32,
    /// Camera rays and shadow rays.
    pub(super) rays: Option<u64>,
    /// Of a row that is rendered to an error, what became of its pixels.
    #[serde(flatten)]
    pub(super) aim: Aim,
    #[serde(flatten)]
    pub(super) errors: Errors,
    /// Whether the error is below twice the reference's own, and says little.
    #[serde(rename = "near_reference")]
    pub(super) is_near_reference: bool,
    /// The relative errors in false colors, as PNG.
    #[serde(skip)]
    pub(super) picture: Vec<u8>,
}

/// What was asked for of each pixel, and how many have it; `None` of what was not rendered to an error.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct Aim {
    /// |I − R| over the larger of R and the floor is to be at most this.
    pub(super) target: Option<f64>,
    /// The part of the pixels whose error is so small, against the reference.
    pub(super) within_target: Option<f64>,
    /// The part whose error is a bound, not an estimate.
    pub(super) proven: Option<f64>,
    /// How many the most samples have not brought to the target.
    pub(super) unmet: Option<u64>,
}

/// The columns of the CSV: the keys of a row in JSON.
const COLUMNS: [&str; 19] = [
    "series",
    "transport",
    "setting",
    "samples_per_pixel",
    "seconds",
    "runs",
    "rays",
    "target",
    "within_target",
    "proven",
    "unmet",
    "rmse_cd_m2",
    "rmse_percent",
    "relmse",
    "relative_p999",
    "relative_max",
    "flip",
    "hdr_flip",
    "near_reference",
];

/// What the rows of a transport are measured against, as tables have it.
#[derive(Clone, Debug, Serialize)]
pub(super) struct ReferenceRow {
    pub(super) transport: &'static str,
    pub(super) samples: u32,
    pub(super) seconds: f64,
    /// Its own error, estimated: half the deviation of its two halves, in cd/m².
    pub(super) rmse_cd_m2: f64,
    /// That in percent of the mean; `None` of a black picture.
    pub(super) rmse_percent: Option<f64>,
    pub(super) mean_cd_m2: f64,
    pub(super) median_cd_m2: f64,
    /// ε of relMSE, in (cd/m²)².
    pub(super) relmse_epsilon: f64,
    /// The exposure of ꟻLIP and of the picture, in EV.
    pub(super) exposure_ev: f64,
}

/// How fast the error of a curve falls.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Slope {
    pub(super) series: String,
    pub(super) transport: String,
    /// a of RMSE ∝ timeᵃ.
    pub(super) by_time: Option<f64>,
    /// a of RMSE ∝ samplesᵃ.
    pub(super) by_samples: Option<f64>,
}

/// What could not be measured, and why.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LeftOut {
    pub(super) what: String,
    pub(super) why: String,
}

/// All of a report but its pictures.
#[derive(Serialize)]
pub(super) struct Report {
    pub(super) candela: &'static str,
    /// The scene's file, without its folder.
    pub(super) scene: String,
    pub(super) resolution: [u32; 2],
    pub(super) threads: usize,
    pub(super) references: Vec<ReferenceRow>,
    pub(super) rows: Vec<Row>,
    pub(super) slopes: Vec<Slope>,
    pub(super) left_out: Vec<LeftOut>,
    /// What else there is to know, a sentence each.
    pub(super) remarks: Vec<String>,
}

/// Rows of one series and transport.
pub(super) struct Curve<'r> {
    pub(super) series: &'r str,
    pub(super) transport: &'r str,
    pub(super) rows: Vec<&'r Row>,
}

impl Row {
    /// Its curve, for reading.
    pub(super) fn name(&self) -> String {
        format!("{}, {}", self.series, spoken(&self.transport))
    }

    /// Time in s and error in percent of the mean, if both can be on logarithmic axes.
    pub(super) fn point(&self) -> Option<[f64; 2]> {
        let error = self.errors.rmse_percent?;
        let is_positive = |number: f64| number > 0.0 && number.is_finite();
        (is_positive(self.seconds) && is_positive(error)).then_some([self.seconds, error])
    }
}

/// A transport as text has it.
pub(super) fn spoken(transport: &str) -> &str {
    if transport == "rgb" { "RGB" } else { transport }
}

/// The rows, curve by curve, in the order in which they come.
pub(super) fn curves(rows: &[Row]) -> Vec<Curve<'_>> {
    let mut curves: Vec<Curve<'_>> = Vec::new();
    for row in rows {
        let is_of =
            |curve: &&mut Curve<'_>| curve.series == row.series && curve.transport == row.transport;
        match curves.iter_mut().find(is_of) {
            Some(curve) => curve.rows.push(row),
            None => curves.push(Curve {
                series: &row.series,
                transport: &row.transport,
                rows: vec![row],
            }),
        }
    }
    curves
}

/// How fast each curve falls, without what is near the reference.
pub(super) fn slopes(rows: &[Row]) -> Vec<Slope> {
    let of = |curve: Curve<'_>| {
        let counted = || curve.rows.iter().filter(|row| !row.is_near_reference);
        let by_time: Vec<[f64; 2]> = counted().filter_map(|row| row.point()).collect();
        let by_samples =
            counted().filter_map(|row| Some([row.samples_per_pixel?, row.point()?[1]]));
        Slope {
            by_time: slope(&by_time),
            by_samples: slope(&by_samples.collect::<Vec<_>>()),
            series: curve.series.to_owned(),
            transport: curve.transport.to_owned(),
        }
    };
    curves(rows).into_iter().map(of).collect()
}

impl Report {
    /// The rows as CSV, RFC 4180 but for its ends of lines; what is not known is empty.
    pub(super) fn csv(&self) -> Result<String, Failure> {
        let mut csv = COLUMNS.join(",") + "\n";
        for row in &self.rows {
            let row = serde_json::to_value(row)?;
            let cells: Vec<String> = COLUMNS.iter().map(|column| cell(&row[column])).collect();
            csv += &(cells.join(",") + "\n");
        }
        Ok(csv)
    }

    /// All of it as JSON.
    pub(super) fn json(&self) -> Result<String, Failure> {
        Ok(serde_json::to_string_pretty(self)? + "\n")
    }

    /// The rows for reading.
    pub(super) fn write_text(&self, output: &mut impl Write) -> Result<(), Failure> {
        let [width, height] = self.resolution;
        writeln!(
            output,
            "{}, {width} × {height}, {}",
            self.scene,
            self.counted_threads()
        )?;
        for reference in &self.references {
            writeln!(output, "reference, {}", said(reference))?;
        }
        let [series, setting] = [
            |row: &Row| row.name().chars().count(),
            |row: &Row| row.setting.chars().count(),
        ]
        .map(|length| self.rows.iter().map(length).max().unwrap_or(0));
        writeln!(
            output,
            "\n{:series$}  {:setting$}  {:>10}  {:>9}  {:>9}  {:>9}  {:>9}  {:>9}",
            "", "", "seconds", "RMSE", "relMSE", "p99.9", "max", "ꟻLIP",
        )?;
        for row in &self.rows {
            let errors = &row.errors;
            writeln!(
                output,
                "{:series$}  {:setting$}  {:>10}  {:>9}  {:>9}  {:>9}  {:>9}  {:>9}{}",
                row.name(),
                row.setting,
                short(Some(row.seconds)),
                percent(errors.rmse_percent),
                short(errors.relmse),
                short(errors.relative_p999),
                short(errors.relative_max),
                short(Some(errors.flip)),
                if row.is_near_reference {
                    "  near the reference"
                } else {
                    ""
                },
            )?;
        }
        let slopes = self.slopes.iter().filter(|slope| slope.by_time.is_some());
        for (number, slope) in slopes.enumerate() {
            let start = if number == 0 { "\n" } else { "" };
            writeln!(output, "{start}{}: {}", slope.name(), slope.said())?;
        }
        for left_out in &self.left_out {
            writeln!(output, "left out: {}: {}", left_out.what, left_out.why)?;
        }
        for remark in &self.remarks {
            writeln!(output, "{remark}")?;
        }
        Ok(())
    }

    pub(super) fn counted_threads(&self) -> String {
        match self.threads {
            1 => "1 thread".to_owned(),
            threads => format!("{threads} threads"),
        }
    }
}

impl Slope {
    /// Its curve, for reading.
    pub(super) fn name(&self) -> String {
        format!("{}, {}", self.series, spoken(&self.transport))
    }

    /// As text has it.
    pub(super) fn said(&self) -> String {
        let of = |name: &str, slope: Option<f64>| Some(format!("{name}^{}", exponent(slope?)));
        let both = [of("time", self.by_time), of("samples", self.by_samples)];
        let both: Vec<String> = both.into_iter().flatten().collect();
        format!("RMSE ∝ {}", both.join(", ∝ "))
    }
}

/// A slope with two decimals and a real minus.
pub(super) fn exponent(slope: f64) -> String {
    format!("{slope:.2}").replace('-', "−")
}

/// What a reference is, in words.
pub(super) fn said(reference: &ReferenceRow) -> String {
    let error = match reference.rmse_percent {
        Some(error) => format!("its own RMSE is about {} %", digits(error)),
        None => "the picture is black".to_owned(),
    };
    format!(
        "{}: {} samples in {} s; {error} (mean {} cd/m², ε of relMSE {} (cd/m²)²)",
        spoken(reference.transport),
        reference.samples,
        digits(reference.seconds),
        digits(reference.mean_cd_m2),
        digits(reference.relmse_epsilon),
    )
}

/// Three significant digits.
pub(super) fn digits(value: f64) -> String {
    let rounded = format!("{value:.2e}").parse().unwrap_or(value);
    number(rounded)
}

/// That, or a dash where there is no number.
pub(super) fn short(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), digits)
}

pub(super) fn percent(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), |value| format!("{} %", digits(value)))
}

/// A value as a cell of a CSV.
fn cell(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(text) if text.contains(['"', ',', '\n', '\r']) => {
            format!("\"{}\"", text.replace('"', "\"\""))
        }
        Value::String(text) => text.clone(),
        Value::Bool(_) | Value::Number(_) | Value::Array(_) | Value::Object(_) => value.to_string(),
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A row of a power law: error in percent = 2 time^−3/4, time = samples/100.
    pub(in super::super) fn row(series: &str, transport: &str, samples: u32) -> Row {
        let seconds = f64::from(samples) / 100.0;
        let percent = 2.0 * seconds.powf(-0.75);
        Row {
            series: series.to_owned(),
            transport: transport.to_owned(),
            setting: format!("{samples} samples"),
            label: samples.to_string(),
            samples_per_pixel: Some(samples.into()),
            seconds,
            runs: 5,
            rays: None,
            aim: Aim::default(),
            errors: Errors {
                rmse: percent / 100.0,
                rmse_percent: Some(percent),
                relmse: Some(1e-3),
                relative_p999: Some(0.1),
                relative_max: None,
                flip: 0.01,
                hdr_flip: None,
            },
            is_near_reference: false,
            picture: Vec::new(),
        }
    }

    #[test]
    fn slopes_leave_out_what_is_near_the_reference() {
        let mut rows: Vec<Row> = [1, 4, 16, 64].map(|n| row("a, b", "rgb", n)).into();
        rows.push(Row {
            is_near_reference: true,
            seconds: 100.0,
            ..rows[0].clone()
        });
        rows.push(row("other", "rgb", 1));
        let slopes = slopes(&rows);
        assert_eq!(slopes.len(), 2);
        for found in [slopes[0].by_time, slopes[0].by_samples] {
            assert!((found.unwrap() + 0.75).abs() < 1e-13);
        }
        assert_eq!(slopes[1].by_time, None);
        assert_eq!(slopes[0].said(), "RMSE ∝ time^−0.75, ∝ samples^−0.75");
    }

    #[test]
    fn cells_are_quoted_where_they_must_be() {
        assert_eq!(cell(&Value::from("a, \"b\"")), "\"a, \"\"b\"\"\"");
        assert_eq!(cell(&Value::from("a b")), "a b");
        assert_eq!(cell(&Value::Null), "");
        assert_eq!(cell(&Value::from(0.5)), "0.5");
        assert_eq!(cell(&Value::from(true)), "true");
    }

    #[test]
    fn digits_are_three() {
        let said = [0.0123456, 12.3456, 0.000_012_34, 0.0].map(digits);
        assert_eq!(said, ["0.0123", "12.3", "1.23e-5", "0"]);
    }
}
