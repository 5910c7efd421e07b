//! What `diff` has found, for people and for programs.

use std::io::{self, Write};
use std::path::PathBuf;

use candela::compare::Place;
use candela::internal::{counted, printable, printable_path};
use serde::Serialize;

use super::figures::LayerReport;
use super::limits::BeyondLimit;
use crate::cli::numbers::number;

/// All that was found.
#[derive(Serialize)]
pub(super) struct Report<'r> {
    pub(super) reference: &'r str,
    pub(super) image: &'r str,
    /// The relative error from which on a pixel is a flip.
    pub(super) tolerance: f64,
    pub(super) layers: &'r [LayerReport],
    /// What was not compared.
    pub(super) left_out: &'r [String],
    /// What is beyond its limit.
    pub(super) beyond: &'r [BeyondLimit],
}

impl LayerReport {
    fn write(&self, tolerance: f64, output: &mut impl Write) -> io::Result<()> {
        let metrics = &self.metrics;
        let shown: Vec<String> = self
            .channels
            .iter()
            .take(8)
            .map(|name| printable(name))
            .collect();
        let more = if self.channels.len() > shown.len() {
            ", …"
        } else {
            ""
        };
        writeln!(
            output,
            "\n{}: {}{more}",
            printable(&self.name),
            shown.join(", ")
        )?;
        let [reference, image] = [metrics.not_finite_in_reference, metrics.not_finite_in_image];
        if reference + image > 0 {
            writeln!(
                output,
                "    not finite    {reference} values of A, {image} of B"
            )?;
        }
        let Some(at) = metrics.max_at else {
            return writeln!(output, "    the same");
        };
        let Place { x, y, .. } = at;
        let channel = self.max_in.as_deref().unwrap_or_default();
        writeln!(
            output,
            "    |B − A|       max {} at {x},{y} in {}, mean {}",
            number(metrics.max_error),
            printable(channel),
            number(metrics.mean_error),
        )?;
        writeln!(
            output,
            "    RMSE          {}, PSNR {} dB",
            number(metrics.rmse),
            number(metrics.psnr)
        )?;
        let place = metrics
            .relative_max_at
            .map_or_else(String::new, |at| format!(" at {},{}", at.x, at.y));
        writeln!(
            output,
            "    relative      max {}{place}, 99.9 % of the pixels up to {}, relMSE {}",
            number(metrics.relative_max),
            number(metrics.relative_p999),
            number(metrics.relmse),
        )?;
        writeln!(
            output,
            "    flips         {} of {} above {}",
            metrics.flips,
            counted(metrics.pixels as usize, "pixel", "pixels"),
            number(tolerance),
        )?;
        if let Some(flip) = self.flip {
            let hdr = match self.hdr_flip {
                Some(hdr) => format!("{hdr:.6} over all exposures"),
                None => "none over all exposures, as the median of A is black".to_owned(),
            };
            writeln!(output, "    FLIP          {flip:.6} as sRGB, {hdr}")?;
        }
        Ok(())
    }
}

impl Report<'_> {
    pub(super) fn write_json(&self, output: &mut impl Write) -> io::Result<()> {
        serde_json::to_writer_pretty(&mut *output, self).map_err(io::Error::from)?;
        writeln!(output)
    }

    pub(super) fn write_text(
        &self,
        written: &[PathBuf],
        output: &mut impl Write,
    ) -> io::Result<()> {
        writeln!(
            output,
            "A, the reference: {}\nB, the image:     {}",
            self.reference, self.image
        )?;
        for sentence in self.left_out {
            writeln!(output, "left out: {sentence}")?;
        }
        for layer in self.layers {
            layer.write(self.tolerance, output)?;
        }
        if !written.is_empty() {
            let names: Vec<String> = written.iter().map(|path| printable_path(path)).collect();
            writeln!(output, "\nwrote {}", names.join(", "))?;
        }
        Ok(())
    }
}
