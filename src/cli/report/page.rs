//! The page: one file of HTML that holds its pictures.

use std::fmt::Write as _;

use candela::compare::FalseColor;

use super::pictures::{COUNTS, png, scale_bar};
use super::table::{Report, Row, percent, said, short};
use crate::cli::Failure;
use crate::cli::drawing::escaped;

const STYLE: &str = "\
body { font: 15px/1.5 system-ui, sans-serif; color: #222226; max-width: 1040px; margin: 2em auto; padding: 0 1em; }
h1 { font-size: 1.5em; } h2 { font-size: 1.15em; margin-top: 2em; }
img, svg { max-width: 100%; height: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .2em .7em; text-align: right; border-bottom: 1px solid #e2e2e6; white-space: nowrap; }
th:first-child, td:first-child, th:nth-child(2), td:nth-child(2) { text-align: left; }
tr.near td { color: #8a8a92; }
.wide { overflow-x: auto; }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(300px, 1fr)); gap: 1em; }
figure { margin: 0; } figcaption { font-size: .85em; color: #55555c; }
.note { color: #55555c; font-size: .9em; }
";

/// What is said of the columns.
const NOTES: &str = "\
Times are of rendering alone, from the first camera ray to the finished picture in memory: reading the scene, building \
trees and writing files are not in them. Errors are of R, G and B of all pixels against the reference: RMSE = \
√mean (I − R)², in percent of the reference's mean; relMSE = mean (I − R)² / (R² + ε); of a pixel the relative error is \
the largest |I − R| / max(R, median/1000) of its channels, p99.9 what 99.9 % of the pixels do not exceed. ꟻLIP is of the picture \
as shown here, HDR-ꟻLIP of all exposures. Within the target are pixels of which no \
channel is off by more than the target of the larger of R and the floor. Gray rows are below twice the reference's own error and count for no slope.";

/// Pictures beside the report.
pub(super) struct Pictures<'p> {
    /// The reference as PNG.
    pub(super) render: &'p [u8],
    /// The plot as SVG.
    pub(super) plot: &'p str,
    /// How many samples pixels took, as PNG, with what they show.
    pub(super) samples: &'p [(String, Vec<u8>)],
}

/// The page.
pub(super) fn page(report: &Report, pictures: &Pictures<'_>) -> Result<String, Failure> {
    let [width, height] = report.resolution;
    let scene = escaped(&report.scene);
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width\">\n<title>{scene}: error over time</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{scene}: error over time</h1>\n\
         <p>{width} × {height} pixels, {}, candela {}.</p>\n",
        report.counted_threads(),
        report.candela,
    );
    // Writing to a string does not fail.
    for reference in &report.references {
        let _ = writeln!(page, "<p>Reference, {}.</p>", escaped(&said(reference)));
    }
    let _ = writeln!(page, "{}", pictures.plot);
    list(&mut page, report);
    let _ = writeln!(page, "<h2>All numbers</h2>\n<div class=\"wide\">");
    table(&mut page, &report.rows);
    let _ = writeln!(page, "</div>\n<p class=\"note\">{}</p>", escaped(NOTES));
    let _ = writeln!(
        page,
        "<h2>The picture</h2>\n{}",
        image(pictures.render, "the reference")
    );
    let _ = writeln!(
        page,
        "<h2>Relative errors</h2>\n<p>10⁻⁶ {} 1, by the logarithm; of each block of pixels the largest.</p>\n\
         <div class=\"pictures\">",
        image(
            &png(&scale_bar(&FalseColor::RELATIVE))?,
            "from black to light yellow"
        ),
    );
    let first = report.rows.first().map_or("", |row| row.transport.as_str());
    for row in report.rows.iter().filter(|row| row.transport == first) {
        let error = percent(row.errors.rmse_percent);
        let seconds = short(Some(row.seconds));
        let below = format!("{}, {}: {seconds} s, RMSE {error}", row.series, row.setting);
        figure(&mut page, &row.picture, &below);
    }
    let _ = writeln!(page, "</div>");
    if !pictures.samples.is_empty() {
        let scale = image(&png(&scale_bar(&COUNTS))?, "from black to light yellow");
        let _ = writeln!(
            page,
            "<h2>Samples of each pixel</h2>\n<p>1 {scale} 4096, by the logarithm; of each block of pixels the \
             largest.</p>\n<div class=\"pictures\">",
        );
        for (said, picture) in pictures.samples {
            figure(&mut page, picture, said);
        }
        let _ = writeln!(page, "</div>");
    }
    Ok(page + "</body>\n</html>\n")
}

/// Slopes, what is left out, and remarks.
fn list(page: &mut String, report: &Report) {
    let slopes = report.slopes.iter().filter(|slope| slope.by_time.is_some());
    let slopes = slopes.map(|slope| format!("{}: {}", slope.name(), slope.said()));
    let left_out = report.left_out.iter();
    let left_out =
        left_out.map(|left_out| format!("left out: {}: {}", left_out.what, left_out.why));
    let all = slopes.chain(left_out).chain(report.remarks.iter().cloned());
    let _ = writeln!(page, "<ul>");
    for sentence in all {
        let _ = writeln!(page, "<li>{}</li>", escaped(&sentence));
    }
    let _ = writeln!(page, "</ul>");
}

fn table(page: &mut String, rows: &[Row]) {
    let _ = writeln!(
        page,
        "<table>\n<tr><th>series</th><th>setting</th><th>samples a pixel</th><th>time, s</th><th>runs</th>\
         <th>rays, 10⁶</th><th>within target</th><th>proven</th><th>RMSE, cd/m²</th><th>RMSE</th><th>relMSE</th><th>p99.9</th><th>largest</th>\
         <th>ꟻLIP</th><th>HDR-ꟻLIP</th></tr>"
    );
    for row in rows {
        let errors = &row.errors;
        let class = if row.is_near_reference {
            " class=\"near\""
        } else {
            ""
        };
        let rays = row.rays.map(|rays| rays as f64 / 1e6);
        let numbers = [
            short(row.samples_per_pixel),
            short(Some(row.seconds)),
            row.runs.to_string(),
            short(rays),
            percent(row.aim.within_target.map(|part| 100.0 * part)),
            percent(row.aim.proven.map(|part| 100.0 * part)),
            short(Some(errors.rmse)),
            percent(errors.rmse_percent),
            short(errors.relmse),
            short(errors.relative_p999),
            short(errors.relative_max),
            short(Some(errors.flip)),
            short(errors.hdr_flip),
        ];
        let _ = writeln!(
            page,
            "<tr{class}><td>{}</td><td>{}</td><td>{}</td></tr>",
            escaped(&row.name()),
            escaped(&row.setting),
            numbers.join("</td><td>"),
        );
    }
    let _ = writeln!(page, "</table>");
}

fn figure(page: &mut String, png: &[u8], said: &str) {
    let _ = writeln!(
        page,
        "<figure>{}<figcaption>{}</figcaption></figure>",
        image(png, said),
        escaped(said),
    );
}

fn image(png: &[u8], said: &str) -> String {
    format!(
        "<img alt=\"{}\" src=\"data:image/png;base64,{}\">",
        escaped(said),
        base64(png)
    )
}

/// RFC 4648, section 4.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let byte = |place: usize| u32::from(three.get(place).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for place in 0..4 {
            let digit = (bits >> (18 - 6 * place) & 63) as usize;
            text.push(if place <= three.len() {
                char::from(DIGITS[digit])
            } else {
                '='
            });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_the_rfc() {
        for (bytes, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
    }
}
