//! What was measured as tables for people and for programs, and where it is kept.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use serde::Serialize;

use super::compare::{Row, Spread};
use super::whole::Whole;
use super::{Result, Setting, work};

/// Kept with the sources, by date and machine.
pub(crate) const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/archive");

/// A whole benchmark.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Report {
    pub(crate) setting: Setting,
    pub(crate) rows: Vec<Row>,
    pub(crate) whole: Option<Whole>,
}

/// Seconds in milliseconds, with three digits.
pub(crate) fn milliseconds(seconds: f64) -> String {
    let milliseconds = seconds * 1e3;
    match milliseconds {
        0.0..10.0 => format!("{milliseconds:.2}"),
        10.0..100.0 => format!("{milliseconds:.1}"),
        _ => format!("{milliseconds:.0}"),
    }
}

fn spread(spread: Spread) -> String {
    format!(
        "{} ({}–{})",
        milliseconds(spread.median),
        milliseconds(spread.min),
        milliseconds(spread.max),
    )
}

fn or_dash<T>(value: Option<T>, show: impl FnOnce(T) -> String) -> String {
    value.map_or_else(|| "–".to_owned(), show)
}

/// Writes one table or picture of a run into the archive.
pub(crate) fn keep(name: &str, text: &str) -> Result<()> {
    let path = Path::new(FOLDER).join(name);
    fs::create_dir_all(path.with_file_name(""))?;
    fs::write(&path, text)?;
    eprintln!("wrote {}", path.display());
    Ok(())
}

impl Report {
    /// The tables.
    pub(crate) fn markdown(&self) -> String {
        let mut text = format!("# Speed\n\n{}\n", self.setting.line());
        text += "\n1920 × 1080. Times are in ms: the median (min–max) of all runs, candela and Embree in \
                 turn. `ratio` is Embree's time over candela's, run by run. `floor` is the share of \
                 candela's time that the yardstick's shading takes where no ray is traced.\n\n\
                 | scene | lights | samples | candela | Embree | ratio | Msamples/s | floor |\n\
                 | --- | --- | --- | --- | --- | --- | --- | --- |\n";
        for row in &self.rows {
            let rate = row.primary_rays as f64 / row.render.median / 1e6;
            let ratio = |ratio: Spread| {
                format!(
                    "**{:.2}** ({:.2}–{:.2})",
                    ratio.median, ratio.min, ratio.max
                )
            };
            let floor = |shading: f64| format!("{:.0} %", 100.0 * shading / row.render.median);
            // Writing to a string does not fail.
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {} | {} | {rate:.2} | {} |",
                row.scene,
                row.lights,
                row.samples,
                spread(row.render),
                or_dash(row.embree_render, spread),
                or_dash(row.ratio, ratio),
                or_dash(row.shading, floor),
            );
        }
        text += &work::markdown(&self.rows);
        text += &self.other_times();
        text += &self.whole_process();
        text
    }

    /// What is not rendering, and how the pictures agree: the same for any number of samples.
    fn other_times(&self) -> String {
        let mut text = "\nLoading, building and writing in ms, once for each line. The pictures at 1 sample: \
                        pixels that differ from the yardstick's by more than 0.1 % in some channel, how \
                        many of them are not at an edge, and how far the means are apart.\n\n\
                        | scene | lights | load | build | Embree's build | write | different | not at an edge \
                        | means |\n\
                        | --- | --- | --- | --- | --- | --- | --- | --- | --- |\n"
            .to_owned();
        let same = |a: &Row, b: &Row| a.scene == b.scene && a.lights == b.lights;
        for row in self.rows.chunk_by(same).filter_map(|rows| rows.first()) {
            let agreement = |agreement: super::compare::Agreement| {
                format!(
                    "{} | {} | {:+.1e}",
                    agreement.different, agreement.different_inside, agreement.mean,
                )
            };
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {} | {} | {} |",
                row.scene,
                row.lights,
                milliseconds(row.load),
                milliseconds(row.build),
                or_dash(row.embree_build, milliseconds),
                milliseconds(row.write),
                row.agreement
                    .map_or_else(|| "– | – | –".to_owned(), agreement),
            );
        }
        let mut scenes: Vec<(&str, &str)> = Vec::new();
        for row in &self.rows {
            let scene = (row.scene.as_str(), row.content.as_str());
            if !scenes.contains(&scene) {
                scenes.push(scene);
            }
        }
        let scenes: Vec<String> = scenes
            .iter()
            .map(|(name, content)| format!("{name}: {content}"))
            .collect();
        text + "\n" + &scenes.join("; ") + ".\n"
    }

    fn whole_process(&self) -> String {
        let Some(whole) = &self.whole else {
            return String::new();
        };
        let over = |other: Option<Spread>| {
            or_dash(other, |other| {
                format!("{:.2}", whole.candela.median / other.median)
            })
        };
        format!(
            "\nThe whole process, spheres, 1 sample, all lights, in ms:\n\n\
             | | time | candela's over this |\n| --- | --- | --- |\n\
             | `candela render`, scene file to EXR on disk | {} | |\n\
             | `oiiotool in.exr -o out.exr` of that EXR | {} | {} |\n\
             | the yardstick's render alone | {} | {} |\n",
            spread(whole.candela),
            or_dash(whole.oiiotool, spread),
            over(whole.oiiotool),
            or_dash(whole.embree_render, spread),
            over(whole.embree_render),
        )
    }

    /// Keeps the tables as Markdown and as JSON.
    pub(crate) fn archive(&self, kind: &str) -> Result<()> {
        let stem = self.setting.file_stem() + kind;
        keep(&format!("{stem}.md"), &self.markdown())?;
        let json = serde_json::to_string_pretty(self)?;
        keep(&format!("{stem}.json"), &(json + "\n"))
    }
}
