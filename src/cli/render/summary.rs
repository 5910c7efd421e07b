//! What `render` says at its end: the files that it wrote, and what a user should know about them.

use std::collections::HashSet;

use candela::display::{Exposure, LOOKS_BLACK, MANY_CLIPPED, Report, View, digits};
use candela::exr::ExrReport;
use candela::image::Window;
use candela::internal::printable_path;
use candela::render::Counts;
use candela::world::physics::Warning;

use super::Arguments;
use super::outputs::Outputs;
use crate::cli::frames::Frame;
use crate::cli::sequence::output_name;

/// Warnings of `candela check` beyond so many are counted, not listed.
const LISTED: usize = 5;

/// All that there is to say.
pub(super) struct Summary<'a> {
    pub(super) arguments: &'a Arguments,
    pub(super) outputs: &'a Outputs,
    pub(super) frame: Option<Frame>,
    /// The whole image's.
    pub(super) resolution: [u32; 2],
    /// What was rendered of it.
    pub(super) window: Window,
    pub(super) has_lights: bool,
    /// Those of `candela check`.
    pub(super) warnings: Vec<Warning>,
    pub(super) counts: Counts,
    pub(super) exr: ExrReport,
    /// Of the preview, where there is one.
    pub(super) developed: Option<Report>,
    /// What a viewer missed.
    pub(super) unseen: Option<String>,
    /// From the first camera ray to the last pixel.
    pub(super) seconds: f64,
}

impl Summary<'_> {
    /// A line for each file, then one for each warning that was not given before.
    pub(super) fn text(&self, told: &mut HashSet<String>) -> String {
        let files = self.files();
        let warnings = self.checked().into_iter().chain(self.of_view());
        let warnings = warnings.chain(self.of_values()).chain(self.of_preview());
        let warnings = warnings.chain(self.unseen.clone());
        // Those of one kind are given at one frame of a sequence, whatever their numbers.
        let kind = |warning: &String| warning.replace(|c: char| c.is_ascii_digit() || c == '.', "");
        let warnings: Vec<String> = warnings.collect();
        let kinds: Vec<String> = warnings.iter().map(kind).collect();
        let warnings = warnings.into_iter().zip(&kinds);
        let warnings = warnings.filter(|(_, kind)| !told.contains(*kind));
        let warnings = warnings.map(|(warning, _)| format!("warning: {warning}"));
        let lines: Vec<String> = files.into_iter().chain(warnings).collect();
        told.extend(kinds);
        lines.join("\n")
    }

    /// A line for each file that is of all frames.
    pub(super) fn of_run(outputs: &Outputs) -> Vec<String> {
        let mut lines = Vec::new();
        if let Some(stats) = &outputs.statistics {
            lines.push(format!("{}: counts and times", output_name(stats)));
        }
        if let Some(manifest) = &outputs.manifest {
            lines.push(format!(
                "{}: what was read and written",
                output_name(manifest)
            ));
        }
        lines
    }

    fn files(&self) -> Vec<String> {
        let [width, height] = self.resolution;
        let size = if self.window == Window::whole(self.resolution) {
            format!("{width} × {height}")
        } else {
            let Window {
                width: columns,
                height: rows,
                ..
            } = self.window;
            format!("{columns} × {rows} of {width} × {height}")
        };
        let accuracy = self.arguments.accuracy.summary();
        let mut lines = vec![format!(
            "{}: {size}, {accuracy}, rendered in {:.2} s",
            output_name(&self.outputs.exr),
            self.seconds,
        )];
        lines.extend(self.arguments.accuracy.outcome(&self.counts.errors));
        if let Some(bands) = &self.outputs.bands {
            lines.push(format!("{}: its bands", output_name(bands)));
        }
        if let (Some(preview), Some(developed)) = (&self.outputs.preview, &self.developed) {
            // What is chosen may be repeated with `tonemap`.
            let exposure = match self.arguments.development.exposure() {
                Exposure::Auto | Exposure::Percentile(_) => {
                    format!(", exposure {}", developed.exposure())
                }
                Exposure::Ev(_) => String::new(),
            };
            lines.push(format!("{}: its preview{exposure}", output_name(preview)));
        }
        lines
    }

    /// What `candela check` warns of.
    fn checked(&self) -> Vec<String> {
        let warnings = self.warnings.iter().take(LISTED).map(ToString::to_string);
        let mut lines: Vec<String> = warnings.collect();
        let more = self.warnings.len().saturating_sub(LISTED);
        if more > 0 {
            let all = match &self.arguments.scene {
                Some(scene) => format!("; `candela check {}` shows all", printable_path(scene)),
                None => String::new(),
            };
            lines.push(format!("and {more} more{all}"));
        }
        lines
    }

    /// Why there is nothing to see, where that is so.
    fn of_view(&self) -> Option<String> {
        let Counts { hits, lit, .. } = self.counts;
        let is_part = self.window != Window::whole(self.resolution);
        if hits == 0 {
            let place = if is_part {
                " in this part of the image"
            } else {
                ""
            };
            return Some(format!(
                "nothing is in view: no camera ray{place} hits an object; look at `eye`, `look_at` and \
                 where the objects are",
            ));
        }
        // That there is no light at all is said already.
        if !self.has_lights {
            return None;
        }
        if lit == 0 && self.counts.secondary_rays == 0 {
            return Some(format!(
                "every light is hidden or below the surface, wherever the camera looks; {} says which \
                 and by what",
                self.probe(),
            ));
        }
        self.of_brightness()
    }

    /// Whether the picture is black, or blown out: as the preview shows it, or else as `candela tonemap`
    /// would without options.
    fn of_brightness(&self) -> Option<String> {
        if self.counts.brightest == 0.0 {
            return Some(format!(
                "the picture is black: light reaches what is in view, but its intensity is 0 or all of it \
                 is absorbed; {} shows which",
                self.probe(),
            ));
        }
        match &self.developed {
            Some(report) => of_shown(report),
            None => self.of_light(),
        }
    }

    /// As `candela tonemap` would show it without options.
    fn of_light(&self) -> Option<String> {
        let brightest = f64::from(self.counts.brightest);
        let clipped = self.counts.beyond_white as f64 / self.window.count() as f64;
        let tonemap = format!("of `candela tonemap {}`", printable_path(&self.outputs.exr));
        if brightest < LOOKS_BLACK {
            return Some(format!(
                "the brightest pixel has {} cd/m², where the screen's white is 1: try --auto-exposure \
                 {tonemap}",
                digits(brightest),
            ));
        }
        if clipped >= MANY_CLIPPED {
            return Some(format!(
                "{:.0} % of the picture is brighter than the screen, whose white is 1 cd/m²: try a lower \
                 --exposure, --auto-exposure or --view reinhard {tonemap}",
                100.0 * clipped,
            ));
        }
        None
    }

    /// What values did not fit what they are stored in.
    fn of_values(&self) -> Vec<String> {
        let counted = [
            (
                self.counts.singular,
                "points at which a light is (d = 0), and where it adds nothing",
            ),
            (
                self.counts.clamped,
                "values beyond the largest FLOAT, which became that",
            ),
            (
                self.exr.clamped_to_half,
                "values beyond the largest HALF, which became that",
            ),
            (
                self.exr.small_in_half,
                "values of layers of light below 6.1e-5, of which HALF keeps few digits",
            ),
        ];
        let counted = counted.into_iter().filter(|&(count, _)| count > 0);
        let unmet = self.arguments.accuracy.warning(&self.counts.errors);
        counted
            .map(|(count, what)| format!("{what}: {count}"))
            .chain(unmet)
            .collect()
    }

    /// What is to be known about the PNG.
    fn of_preview(&self) -> Vec<String> {
        let warnings = self.developed.iter().flat_map(|report| &report.warnings);
        warnings.cloned().collect()
    }

    /// The command that explains the pixel in the middle.
    fn probe(&self) -> String {
        let Window {
            x,
            y,
            width,
            height,
        } = self.window;
        let scene = self.arguments.scene.as_deref();
        let scene = scene.map_or_else(|| "SCENE.toml".to_owned(), printable_path);
        let (x, y) = (x + width / 2, y + height / 2);
        let frame = self
            .frame
            .map_or_else(String::new, |frame| format!(" --frame {frame}"));
        format!("`candela probe {scene}{frame} --pixel {x},{y}`")
    }
}

/// Whether a preview is black, or blown out. Where numbers of the EXR are light on the screen, with their unit.
fn of_shown(report: &Report) -> Option<String> {
    let is_light = report.view == View::Srgb && report.brightest > 0.0;
    if is_light && report.is_black {
        return Some(format!(
            "the brightest pixel has {} cd/m², where the screen's white is {}: {}",
            digits(report.brightest),
            digits(report.white),
            report.way_out_of_black(),
        ));
    }
    if is_light && report.clipped >= MANY_CLIPPED {
        let end = if report.peak > report.white {
            "peak"
        } else {
            "white"
        };
        return Some(format!(
            "{:.0} % of the picture is brighter than the screen, whose {end} is {} cd/m²: {}",
            100.0 * report.clipped,
            digits(report.peak),
            report.way_out_of_clipping(),
        ));
    }
    report.remarks().into_iter().next()
}
